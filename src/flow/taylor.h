/* One step after another of the smooth flow by Taylor series (power_flow.h), for one kind of
 * numbers. This text is included once for each of them, by a file that has defined
 *
 *     real                 the numbers
 *     pair                 two of them, side by side: PAIR makes one of two, BOTH of one twice,
 *                          AFTER of 0 and one, ACROSS of the last of one pair and the first of
 *                          another, LOAD of two that follow each other in memory, to which STORE
 *                          puts them; FIRST and LAST are its numbers, PLUS and TIMES work on both
 *     ORDER                of the series, even
 *     EPSILON              of the numbers
 *     ADD, SUB, MUL, NEG   of them; SCALE, times a double; OVER, a double over an integer;
 *                          FROM a double, NEAR one; LESS: the order of two
 *                          (taylor_plain.h where C has all of them, and no lanes are wanted)
 *
 * and gets fly_series. Lengths of steps are double.
 *
 * The force does not depend on the velocity, so that the displacements of two orders in a row are
 * known before the forces of either: orders are made two at a time, side by side, which is half as
 * many to wait for. */
#include <math.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"

/* Last terms of the series, relative to the largest coordinate: the terms left out add up to a
 * quarter of it. */
#define TRUNCATION EPSILON
/* What the equation of motion may be off by at the end of a step, over ORDER, relative to the
 * largest coordinate: rounding takes the half. */
#define DEFECT (4 * EPSILON)
/* Exponents up to this one show all of themselves within the orders computed. */
enum { SEEN = ORDER - 3 };
#define INLINE static inline __attribute__((always_inline))

/* A series x: each coefficient twice, and each with the one after it, backwards, so that two orders
 * of a product are a product of two stretches of memory. */
typedef struct {
    pair twice[ORDER], back[ORDER]; /* (x_i, x_i), and at ORDER - 1 - i (x_i, x_(i+1)) */
} numbers;

/* How s^(m - 1) is made: product k, from 1 on, of the series left[k] and right[k], where series 0
 * is s; the last is s^(m - 1). */
typedef struct {
    int count, left[RIC_SMOOTH_PRODUCTS + 1], right[RIC_SMOOTH_PRODUCTS + 1];
} recipe;

/* The series of one contact: s and its powers, and the newest coefficients of each. */
typedef struct {
    numbers power[RIC_SMOOTH_PRODUCTS + 1];
    pair last[RIC_SMOOTH_PRODUCTS + 1];
} powers;

static void plan(const ric_model *m, recipe *how)
{
    for (int f = 0; f < m->n_contact; f++)
        how[f].count = ric_power_flow_products(m->contact[f].exponent, how[f].left, how[f].right);
}

static inline double larger(double a, double b)
{
    return a > b ? a : b;
}

/* Coefficients J and J + 1 of x, J even, after those of `last`. */
INLINE void set(numbers *x, int J, pair last, pair value)
{
    pair *back = x->back + ORDER - 1 - J;
    if (J > 0) back[1] = ACROSS(last, value);
    back[0] = value;
    x->twice[J] = BOTH(FIRST(value));
    x->twice[J + 1] = BOTH(LAST(value));
}

/* Coefficients J and J + 1 of x y, J > 0, but for what x_J, x_(J+1), y_J and y_(J+1) give, and the
 * product of x_1. */
INLINE pair before(int J, const numbers *x, const numbers *y)
{
    const pair *a = x->twice, *b = y->back + ORDER - 1 - J;
    pair even = BOTH(FROM(0)), odd = even;
    for (int l = 2; l < J; l += 2) {
        even = PLUS(even, TIMES(a[l], b[l]));
        odd = PLUS(odd, TIMES(a[l + 1], b[l + 1]));
    }
    return PLUS(odd, even);
}

/* The same of x^2: every product comes twice, but for the one in the middle. */
INLINE pair before_square(int J, const numbers *x)
{
    const pair *a = x->twice, *b = x->back + ORDER - 1 - J;
    pair even = BOTH(FROM(0)), odd = even;
    int l = 2, half = J / 2;
    for (; l + 1 < half; l += 2) {
        even = PLUS(even, TIMES(a[l], b[l]));
        odd = PLUS(odd, TIMES(a[l + 1], b[l + 1]));
    }
    if (l < half) even = PLUS(even, TIMES(a[l], b[l]));
    odd = PLUS(odd, even);
    odd = PLUS(odd, odd);
    return J > 2 ? PLUS(odd, TIMES(PAIR(FROM(1), FROM(2)), TIMES(a[half], b[half]))) : odd;
}

/* Both coefficients from those before, `rest`, the last ones of y and the ones that are new. */
INLINE pair product(int J, const numbers *x, const numbers *y, pair rest, pair xs, pair last,
                    pair ys)
{
    if (J == 0) return PLUS(TIMES(BOTH(FIRST(xs)), ys), TIMES(AFTER(LAST(xs)), BOTH(FIRST(ys))));
    return PLUS(PLUS(rest, PLUS(TIMES(y->twice[0], xs), TIMES(y->twice[1], AFTER(FIRST(xs))))),
                PLUS(TIMES(x->twice[0], ys), TIMES(x->twice[1], ACROSS(last, ys))));
}

INLINE pair square(int J, const numbers *x, pair rest, pair last, pair xs)
{
    if (J == 0) return PLUS(TIMES(BOTH(FIRST(xs)), xs), AFTER(MUL(FIRST(xs), LAST(xs))));
    pair more = TIMES(x->twice[1], ACROSS(last, xs)), first = TIMES(x->twice[0], xs);
    if (J == 2) return PLUS(PLUS(first, first), TIMES(PAIR(FROM(1), FROM(2)), more));
    more = PLUS(first, more);
    return PLUS(rest, PLUS(more, more));
}

/* Coefficients J and J + 1 of all powers from those of s; returns those of s^m. */
INLINE pair extend(const recipe *how, powers *p, int J, pair s)
{
    pair rest[RIC_SMOOTH_PRODUCTS + 1], now[RIC_SMOOTH_PRODUCTS + 1];
    const int count = how->count;
#pragma GCC unroll 6
    for (int k = 1; k <= count; k++) {
        const numbers *x = &p->power[how->left[k]], *y = &p->power[how->right[k]];
        rest[k] = how->left[k] == how->right[k] ? before_square(J, x) : before(J, x, y);
    }
    rest[0] = before(J, &p->power[0], &p->power[count]);
    set(&p->power[0], J, p->last[0], s);
    now[0] = s;
#pragma GCC unroll 6
    for (int k = 1; k <= count; k++) {
        int a = how->left[k], b = how->right[k];
        const numbers *x = &p->power[a], *y = &p->power[b];
        now[k] = a == b ? square(J, x, rest[k], p->last[b], now[b])
                        : product(J, x, y, rest[k], now[a], p->last[b], now[b]);
        set(&p->power[k], J, p->last[k], now[k]);
    }
    pair out = product(J, &p->power[0], &p->power[count], rest[0], s, p->last[count], now[count]);
#pragma GCC unroll 6
    for (int k = 0; k <= count; k++) p->last[k] = now[k];
    return out;
}

/* x^k by binary powers: the same bits everywhere. */
static real power(real x, int k)
{
    real result = FROM(1);
    for (; k > 0; k /= 2) {
        if (k % 2) result = MUL(result, x);
        x = MUL(x, x);
    }
    return result;
}

/* x^(1/j) within a thousandth, for j above 20, by the exponent of x and its first digits: the same
 * bits everywhere, and a fifth of the time of pow. */
static inline double root_of(double x, int j)
{
    int exponent;
    if (!(x > 0 && x < HUGE_VAL)) return x;
    double t = 2 * frexp(x, &exponent) - 1, y = (exponent - 1 + t * (1.3465 - 0.3465 * t)) / j,
           whole = floor(y + 0.5), r = y - whole;
    return ldexp(1 + r * (0.6931 + r * (0.2402 + r * 0.0555)), (int)whole);
}

/* Of numbers whose series are known: size over the largest coefficient of order ORDER - 1, and of
 * order ORDER. The least of all that is taken in. */
typedef struct {
    double last[2];
} reaches;

static inline void take_in(double size, double last, double highest, reaches *all)
{
    if (last > 0) all->last[0] = fmin(all->last[0], size / last);
    if (highest > 0) all->last[1] = fmin(all->last[1], size / highest);
}

/* Step for which the terms of the two highest orders stay below TRUNCATION of the size. */
static inline double radius(const reaches *all)
{
    return fmin(root_of(TRUNCATION * all->last[0], ORDER - 1),
                root_of(TRUNCATION * all->last[1], ORDER));
}

/* S(R) = sum |s_j| R^j. */
static double majorant(const numbers *s, double R)
{
    double sum = fabs(NEAR(FIRST(s->twice[ORDER - 1])));
    for (int j = ORDER - 2; j >= 0; j--) sum = fabs(NEAR(FIRST(s->twice[j]))) + R * sum;
    return sum;
}

/* Powers beyond SEEN announce themselves too late: seen from s = 0 the series of s^99 starts at
 * order 99, and the terms computed say nothing of what is left out. Cauchy's bound does: no
 * coefficient of s^m exceeds S(R)^m R^-j. With it the force leaves less than spring |c| S(R)^m h
 * (h/R)^ORDER / (ORDER (1 - h/R)) out of p, m times that of neighbours. The step is the longest
 * that keeps this below TRUNCATION of the size for one of a few R. */
static double guard(const ric_model *m, int n, int contacts, const powers *p, double size, double h)
{
    for (int f = 0; f < contacts; f++) {
        int exponent = m->contact[f].exponent;
        if (exponent <= SEEN) continue;
        double best = 0, factor = exponent * m->spring[f] * h / ORDER, widest = 0;
        for (int i = 0; i < n; i++) widest = larger(widest, fabs(m->c[f * n + i]));
        factor *= widest;
        for (double R = 6 * h; R / 2 > best; R *= 0.7) {
            double bound = pow(TRUNCATION * size /
                                   (factor *
                                    NEAR(power(FROM(majorant(&p[f].power[0], R)), exponent))),
                               1.0 / ORDER);
            best = fmax(best, R * fmin(bound, 0.5));
        }
        h = fmin(h, best);
    }
    return h;
}

/* ---------------------------------------------------------------- the state */

/* The orders of its series W [HALF + 1][2n] are pairs: of a displacement 2K and 2K + 1, of a
 * velocity 2K - 1 and 2K, so that the first is 0 and the second the state. */
enum { HALF = ORDER / 2 };

/* Coefficients J + 1 and J + 2 of the velocities, and the two after these of the displacements,
 * from those up to J, J even. over [ORDER + 2]: 1 / j. */
INLINE void state_orders(const ric_model *m, int n, int contacts, int J, const real *over,
                         const recipe *how, powers *p, pair *W)
{
    pair *now = W + J / 2 * 2 * n, *next = now + 2 * n, factor = LOAD(over + J + 1);
    for (int i = 0; i < n; i++)
        next[n + i] = TIMES(TIMES(BOTH(FROM(-m->stiff[i])), factor), now[i]);
    for (int f = 0; f < contacts; f++) {
        const double *g = m->g + f * n, *c = m->c + f * n;
        const pair spring = TIMES(BOTH(FROM(-m->spring[f])), factor);
        pair s = TIMES(BOTH(FROM(g[0])), now[0]);
        for (int i = 1; i < n; i++) s = PLUS(s, TIMES(BOTH(FROM(g[i])), now[i]));
        pair push = extend(&how[f], &p[f], J, s);
        for (int i = 0; i < n; i++)
            next[n + i] = PLUS(next[n + i], TIMES(TIMES(BOTH(FROM(c[i])), spring), push));
    }
    factor = LOAD(over + J + 2);
    for (int i = 0; i < n; i++)
        next[i] = TIMES(TIMES(BOTH(FROM(m->kappa[i])), factor), next[n + i]);
}

INLINE void state_start(const ric_model *m, int n, const real *w, pair *W)
{
    for (int i = 0; i < n; i++) {
        W[i] = PAIR(w[i], SCALE(m->kappa[i], w[n + i]));
        W[n + i] = AFTER(w[n + i]);
    }
}

INLINE double state_reach(int n, const pair *W, reaches *all)
{
    const pair *last = W + (HALF - 1) * 2 * n, *highest = last + 2 * n;
    double size = 0, top[2] = {0};
    for (int i = 0; i < n; i++) {
        size = larger(size, larger(fabs(NEAR(FIRST(W[i]))), fabs(NEAR(LAST(W[n + i])))));
        top[0] = larger(top[0],
                        larger(fabs(NEAR(LAST(last[i]))), fabs(NEAR(FIRST(highest[n + i])))));
        top[1] = larger(top[1],
                        larger(fabs(NEAR(FIRST(highest[i]))), fabs(NEAR(LAST(highest[n + i])))));
    }
    take_in(size, top[0], top[1], all);
    return size;
}

/* w [2n] at h: even and odd orders side by side. */
INLINE void state_sum(int n, real h, const pair *W, real *w)
{
    const real square = MUL(h, h);
    const pair both = BOTH(square);
    pair x[2 * n];
    for (int i = 0; i < 2 * n; i++) x[i] = W[HALF * 2 * n + i];
    for (int K = HALF - 1; K > 0; K--)
        for (int i = 0; i < 2 * n; i++) x[i] = PLUS(W[K * 2 * n + i], TIMES(both, x[i]));
    for (int i = 0; i < n; i++) {
        real odd = ADD(LAST(W[i]), MUL(square, LAST(x[i])));
        w[i] = ADD(FIRST(W[i]), ADD(MUL(h, odd), MUL(square, FIRST(x[i]))));
        w[n + i] = ADD(LAST(W[n + i]), ADD(MUL(h, FIRST(x[n + i])), MUL(square, LAST(x[n + i]))));
    }
}

/* Largest |dp/dt - force| at h, where the series has come to w. The last term left out grows like
 * t^ORDER: the error that the step leaves in p is h / ORDER times this. */
INLINE double defect(const ric_model *m, int n, int contacts, real h, const pair *W, const real *w)
{
    double off = 0;
    real push[contacts];
    const pair square = BOTH(MUL(h, h));
    pair rate[n];
    for (int f = 0; f < contacts; f++) {
        real s = FROM(0);
        for (int i = 0; i < n; i++) s = ADD(s, SCALE(m->g[f * n + i], w[i]));
        push[f] = SCALE(m->spring[f], power(s, m->contact[f].exponent));
    }
    for (int i = 0; i < n; i++)
        rate[i] = TIMES(PAIR(FROM(ORDER - 1), FROM(ORDER)), W[HALF * 2 * n + n + i]);
    for (int K = HALF - 1; K > 0; K--)
        for (int i = 0; i < n; i++)
            rate[i] = PLUS(TIMES(PAIR(FROM(2 * K - 1), FROM(2 * K)), W[K * 2 * n + n + i]),
                           TIMES(square, rate[i]));
    for (int i = 0; i < n; i++) {
        real all = ADD(FIRST(rate[i]), ADD(MUL(h, LAST(rate[i])), SCALE(m->stiff[i], w[i])));
        for (int f = 0; f < contacts; f++) all = ADD(all, SCALE(m->c[f * n + i], push[f]));
        off = larger(off, fabs(NEAR(all)));
    }
    return off;
}

/* The step, at most h, and the state w after it. */
INLINE real advance(const ric_model *m, int n, int contacts, const powers *p, double size, real h,
                    int sign, const pair *W, real *w)
{
    double limit = DEFECT * size * ORDER, longest = guard(m, n, contacts, p, size, NEAR(h));
    if (LESS(FROM(longest), h)) h = FROM(longest);
    for (;;) {
        const real along = SCALE(sign, h);
        state_sum(n, along, W, w);
        double off = NEAR(h) * defect(m, n, contacts, along, W, w);
        if (off <= limit || !(NEAR(h) > 0)) return h;
        h = SCALE(off < HUGE_VAL ? larger(0.2, 0.9 * pow(limit / off, 1.0 / (ORDER + 1))) : 0.2, h);
    }
}

/* --------------------------------------------------------------- neighbours */

/* Columns side by side in pairs, `lanes` of them, their series A [ORDER + 1][2n][lanes]. */

/* Coefficients J + 1 and J + 2 of `width` pairs of columns from those up to J, J even: d(s^m) = m
 * s^(m - 1) ds. S [contacts][ORDER][lanes] collects ds. */
INLINE void columns_orders(const ric_model *m, int n, int contacts, int lanes, int width, int J,
                           const real *over, const recipe *how, const powers *p, pair *A, pair *S)
{
    const int row = 2 * n * lanes;
    pair *now = A + J * row, *next = now + row, *last = next + row;
    const real one = over[J + 1], two = over[J + 2];
    for (int i = 0; i < n; i++)
        for (int k = 0; k < width; k++) {
            next[i * lanes + k] = TIMES(BOTH(SCALE(m->kappa[i], one)), now[(n + i) * lanes + k]);
            next[(n + i) * lanes + k] = TIMES(BOTH(SCALE(-m->stiff[i], one)), now[i * lanes + k]);
            last[(n + i) * lanes + k] = TIMES(BOTH(SCALE(-m->stiff[i], two)), next[i * lanes + k]);
        }
    for (int f = 0; f < contacts; f++) {
        const pair *u = p[f].power[how[f].count].twice;
        const double *g = m->g + f * n, *c = m->c + f * n;
        const real factor = SCALE(-m->contact[f].exponent, FROM(m->spring[f]));
        pair *all = S + f * ORDER * lanes, first[width], second[width];
        for (int k = 0; k < width; k++) {
            pair a = TIMES(BOTH(FROM(g[0])), now[k]), b = TIMES(BOTH(FROM(g[0])), next[k]);
            for (int i = 1; i < n; i++) {
                a = PLUS(a, TIMES(BOTH(FROM(g[i])), now[i * lanes + k]));
                b = PLUS(b, TIMES(BOTH(FROM(g[i])), next[i * lanes + k]));
            }
            all[J * lanes + k] = a;
            all[(J + 1) * lanes + k] = b;
            first[k] = TIMES(u[0], a);
            second[k] = PLUS(TIMES(u[0], b), TIMES(u[1], a));
        }
        for (int l = 0; l < J; l++)
            for (int k = 0; k < width; k++) {
                first[k] = PLUS(first[k], TIMES(u[J - l], all[l * lanes + k]));
                second[k] = PLUS(second[k], TIMES(u[J + 1 - l], all[l * lanes + k]));
            }
        for (int k = 0; k < width; k++) {
            for (int i = 0; i < n; i++) {
                pair *x = next + (n + i) * lanes + k, *y = last + (n + i) * lanes + k;
                *x = PLUS(*x, TIMES(BOTH(MUL(SCALE(c[i], factor), one)), first[k]));
                *y = PLUS(*y, TIMES(BOTH(MUL(SCALE(c[i], factor), two)), second[k]));
            }
        }
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < width; k++)
            last[i * lanes + k] = TIMES(BOTH(SCALE(m->kappa[i], two)), next[(n + i) * lanes + k]);
}

INLINE double top_of(int count, const pair *x)
{
    double a = 0, b = 0;
    for (int i = 0; i < count; i++) {
        a = larger(a, fabs(NEAR(FIRST(x[i]))));
        b = larger(b, fabs(NEAR(LAST(x[i]))));
    }
    return larger(a, b);
}

/* X [2n * 2 lanes] at h. */
INLINE void columns_sum(int count, real h, const pair *A, real *X)
{
    const pair both = BOTH(h);
    pair x[count];
    for (int i = 0; i < count; i++) x[i] = A[ORDER * count + i];
    for (int j = ORDER - 1; j >= 0; j--)
        for (int i = 0; i < count; i++) x[i] = PLUS(A[j * count + i], TIMES(both, x[i]));
    for (int i = 0; i < count; i++) STORE(X + 2 * i, x[i]);
}

/* Adds x^2 N N' to S [2n * 2n], where x is the size of the state w and N the inverse of M [2n *
 * 2n]: that is symplectic in (q, p), a = kappa q, so that the blocks of N are those of M
 * transposed. */
INLINE void gather(const ric_model *m, int n, const real *w, const real *M, double *S)
{
    int size = 2 * n;
    double N[size * size], x = 0;
    for (int i = 0; i < size; i++) x = larger(x, fabs(NEAR(w[i])));
    for (int j = 0; j < n; j++) {
        double over = 1 / m->kappa[j];
        for (int i = 0; i < n; i++) {
            N[i * size + j] = m->kappa[i] * NEAR(M[(n + j) * size + n + i]) * over;
            N[i * size + n + j] = -m->kappa[i] * NEAR(M[j * size + n + i]);
            N[(n + i) * size + j] = -NEAR(M[(n + j) * size + i]) * over;
            N[(n + i) * size + n + j] = NEAR(M[j * size + i]);
        }
    }
    for (int i = 0; i < size; i++)
        for (int j = 0; j <= i; j++) {
            double sum = 0;
            for (int k = 0; k < size; k++) sum += N[i * size + k] * N[j * size + k];
            S[i * size + j] += x * x * sum;
            S[j * size + i] = S[i * size + j];
        }
}

/* ---------------------------------------------------------------- a flight */

/* Numbers of workspace for `columns` neighbours; it starts at a multiple of the size of a lane. */
static size_t powers_size(void)
{
    return (sizeof(powers) + sizeof(pair) - 1) / sizeof(pair) * 2;
}

static size_t series_work(const ric_model *m, int columns)
{
    size_t n = (size_t)m->n, contacts = (size_t)m->n_contact, width = (size_t)columns;
    return contacts * powers_size() + (HALF + 1) * 4 * n + (ORDER + 1) * (2 * n + contacts) * width;
}

static inline void list_inverses(real *over)
{
    for (int j = 1; j <= ORDER + 1; j++) over[j] = OVER(1, j);
}

/* Takes w [2n] and X [2n * columns] through the time tau. S [2n * 2n] may be NULL: where X starts
 * as 1, it gathers the rounding of the steps, over epsilon and squared, taken back to the start. */
INLINE bool fly_series(const ric_model *m, int n, int contacts, const recipe *how, int columns,
                       real tau, real *w, real *X, double *S, real *work)
{
    powers *p = (powers *)(void *)work;
    const int lanes = columns / 2, count = 2 * n * lanes;
    pair *W = (pair *)(void *)(work + (size_t)contacts * powers_size()),
         *A = W + (HALF + 1) * 2 * n, *series = A + (ORDER + 1) * count;
    real left = NEAR(tau) < 0 ? NEG(tau) : tau, over[ORDER + 2];
    int sign = NEAR(tau) < 0 ? -1 : 1;
    if (!isfinite(NEAR(tau))) return false;
    list_inverses(over);
    for (int step = 0; NEAR(left) > 0; step++) {
        if (step == RIC_SMOOTH_STEPS || ric_halt(ORDER * ORDER * (1.0 + contacts) * (1 + columns)))
            return false;
        state_start(m, n, w, W);
        for (int i = 0; i < count; i++) A[i] = LOAD(X + 2 * i);
        for (int J = 0; J < ORDER; J += 2) {
            int k = 0;
            state_orders(m, n, contacts, J, over, how, p, W);
            for (; k + 1 < lanes; k += 2)
                columns_orders(m, n, contacts, lanes, 2, J, over, how, p, A + k, series + k);
            if (k < lanes)
                columns_orders(m, n, contacts, lanes, 1, J, over, how, p, A + k, series + k);
        }
        reaches all = {{HUGE_VAL, HUGE_VAL}};
        double size = state_reach(n, W, &all);
        if (columns)
            take_in(top_of(count, A), top_of(count, A + (ORDER - 1) * count),
                    top_of(count, A + ORDER * count), &all);
        double longest = radius(&all);
        const bool shorter = LESS(FROM(longest), left);
        real h = advance(m, n, contacts, p, size, shorter ? FROM(longest) : left, sign, W, w);
        if (!(NEAR(h) > 0)) return false;
        if (columns) columns_sum(count, SCALE(sign, h), A, X);
        if (S) gather(m, n, w, X, S);
        left = SUB(left, h);
        for (int i = 0; i < 2 * n; i++)
            if (!isfinite(NEAR(w[i]))) return false;
    }
    return true;
}
