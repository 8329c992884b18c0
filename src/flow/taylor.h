/* One step after another of the smooth flow by Taylor series (power_flow.h), for one kind of
 * numbers. This text is included once for each of them, by a file that has defined
 *
 *     real                 the numbers, and lane, a vector of LANES of them that is loaded and
 *                          multiplied at once; sum_of adds up one
 *     ORDER                of the series, and PAD, what lane may read beyond it
 *     EPSILON              of the numbers
 *     ADD, SUB, MUL, NEG   of them; SCALE, times a double; OVER, a double over an integer; FROM a
 *                          double, NEAR one; LESS: the order of two (taylor_plain.h where C has all
 *                          of them)
 *
 * and gets fly_series. Lengths of steps are double. */
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

/* Coefficients forwards and backwards, so that a convolution is a product of two stretches of
 * memory: back[ORDER - j] = x[j]. */
typedef struct {
    real x[ORDER + PAD], back[ORDER + PAD];
} numbers;

/* The series of one contact: s, its powers on the way to s^(m - 1), which is the last, and s^m. */
typedef struct {
    int count; /* products to s^(m - 1); series 0 is s, series k the k-th product */
    int left[RIC_SMOOTH_PRODUCTS + 1], right[RIC_SMOOTH_PRODUCTS + 1];
    numbers power[RIC_SMOOTH_PRODUCTS + 1];
} powers;

static void plan(int exponent, powers *p)
{
    memset(p->power, 0, sizeof p->power);
    p->count = ric_power_flow_products(exponent, p->left, p->right);
}

static inline double larger(double a, double b)
{
    return a > b ? a : b;
}

static inline double top_of(int count, const real *x)
{
    double a = 0, b = 0;
    int i = 0;
    for (; i + 1 < count; i += 2) {
        a = larger(a, fabs(NEAR(x[i])));
        b = larger(b, fabs(NEAR(x[i + 1])));
    }
    if (i < count) a = larger(a, fabs(NEAR(x[i])));
    return larger(a, b);
}

/* sum of x_l y_(j-l), l = 1 .. j-1: all but the newest coefficients, which wait for it in
 * registers. */
static inline real middle(int j, const numbers *x, const numbers *y)
{
    const real *a = x->x, *b = y->back + ORDER - j;
    lane s = {0}, t = {0}, a0, b0, a1, b1;
    int l = 1;
    for (; l + 2 * LANES - 1 < j; l += 2 * LANES) {
        memcpy(&a0, a + l, sizeof a0);
        memcpy(&b0, b + l, sizeof b0);
        memcpy(&a1, a + l + LANES, sizeof a1);
        memcpy(&b1, b + l + LANES, sizeof b1);
        s = ADD(s, MUL(a0, b0));
        t = ADD(t, MUL(a1, b1));
    }
    s = ADD(s, t);
    real sum = sum_of(s);
    for (; l < j; l++) sum = ADD(sum, MUL(a[l], b[l]));
    return sum;
}

static inline real convolve(int j, const numbers *x, const numbers *y)
{
    if (j == 0) return MUL(x->x[0], y->x[0]);
    return ADD(middle(j, x, y), ADD(MUL(x->x[0], y->x[j]), MUL(x->x[j], y->x[0])));
}

static inline void set(numbers *x, int j, real value)
{
    x->x[j] = x->back[ORDER - j] = value;
}

/* Coefficient j of all powers from s_j; returns that of s^m. */
static inline real extend(powers *p, int j, real s)
{
    set(&p->power[0], j, s);
    for (int k = 1; k <= p->count; k++)
        set(&p->power[k], j, convolve(j, &p->power[p->left[k]], &p->power[p->right[k]]));
    return convolve(j, &p->power[p->count], &p->power[0]);
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

/* Step for which the terms of the two highest orders stay below TRUNCATION of the size. */
static inline double radius(int count, const real *coefficients)
{
    double size = TRUNCATION * top_of(count, coefficients), h = HUGE_VAL;
    for (int j = ORDER; j >= ORDER - 1; j--) {
        double top = top_of(count, coefficients + (size_t)j * (size_t)count);
        if (top > 0) h = fmin(h, pow(size / top, 1.0 / j));
    }
    return h;
}

/* S(R) = sum |s_j| R^j. */
static double majorant(const real *s, double R)
{
    double sum = fabs(NEAR(s[ORDER - 1]));
    for (int j = ORDER - 2; j >= 0; j--) sum = fabs(NEAR(s[j])) + R * sum;
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
                                    NEAR(power(FROM(majorant(p[f].power[0].x, R)), exponent))),
                               1.0 / ORDER);
            best = fmax(best, R * fmin(bound, 0.5));
        }
        h = fmin(h, best);
    }
    return h;
}

/* x [count] at h. */
static inline __attribute__((always_inline)) void sum_series(int count, real h,
                                                             const real *coefficients, real *x)
{
    memcpy(x, coefficients + (size_t)ORDER * (size_t)count, (size_t)count * sizeof *x);
    for (int j = ORDER - 1; j >= 0; j--)
        for (int i = 0; i < count; i++)
            x[i] = ADD(coefficients[(size_t)j * (size_t)count + (size_t)i], MUL(h, x[i]));
}

/* Largest |dp/dt - force| at h, where the series has come to w. The last term left out grows like
 * t^ORDER: the error that the step leaves in p is h / ORDER times this. */
static inline __attribute__((always_inline)) double defect(const ric_model *m, int n, int contacts,
                                                           real h, const real *W, const real *w)
{
    double off = 0;
    real push[contacts];
    for (int f = 0; f < contacts; f++) {
        real s = FROM(0);
        for (int i = 0; i < n; i++) s = ADD(s, SCALE(m->g[f * n + i], w[i]));
        push[f] = SCALE(m->spring[f], power(s, m->contact[f].exponent));
    }
    for (int i = 0; i < n; i++) {
        real rate = SCALE(ORDER, W[(size_t)ORDER * 2 * (size_t)n + (size_t)n + (size_t)i]);
        for (int j = ORDER - 1; j >= 1; j--)
            rate = ADD(SCALE(j, W[(size_t)j * 2 * (size_t)n + (size_t)n + (size_t)i]),
                       MUL(h, rate));
        rate = ADD(rate, SCALE(m->stiff[i], w[i]));
        for (int f = 0; f < contacts; f++) rate = ADD(rate, SCALE(m->c[f * n + i], push[f]));
        off = larger(off, fabs(NEAR(rate)));
    }
    return off;
}

/* The step, at most h, and the state w after it. */
static inline __attribute__((always_inline)) real advance(const ric_model *m, int n, int contacts,
                                                          const powers *p, real h, int sign,
                                                          const real *W, real *w)
{
    double size = top_of(2 * n, W), limit = DEFECT * size * ORDER,
           longest = guard(m, n, contacts, p, size, NEAR(h));
    if (LESS(FROM(longest), h)) h = FROM(longest);
    for (;;) {
        const real along = SCALE(sign, h);
        sum_series(2 * n, along, W, w);
        double off = NEAR(h) * defect(m, n, contacts, along, W, w);
        if (off <= limit || !(NEAR(h) > 0)) return h;
        h = SCALE(off < HUGE_VAL ? larger(0.2, 0.9 * pow(limit / off, 1.0 / (ORDER + 1))) : 0.2, h);
    }
}

/* Coefficient j + 1 of the state [2n] from coefficient j. */
static inline __attribute__((always_inline)) void state_order(const ric_model *m, int n,
                                                              int contacts, int j, powers *p,
                                                              real *W)
{
    const real *a = W + (size_t)j * 2 * (size_t)n;
    real *next = W + (size_t)(j + 1) * 2 * (size_t)n, over = OVER(1, j + 1);
    for (int i = 0; i < n; i++) {
        next[i] = MUL(SCALE(m->kappa[i], over), a[n + i]);
        next[n + i] = MUL(SCALE(m->stiff[i], NEG(over)), a[i]);
    }
    for (int f = 0; f < contacts; f++) {
        const double *g = m->g + f * n, *c = m->c + f * n;
        real s = FROM(0);
        for (int i = 0; i < n; i++) s = ADD(s, SCALE(g[i], a[i]));
        real push = MUL(SCALE(m->spring[f], over), extend(&p[f], j, s));
        for (int i = 0; i < n; i++) next[n + i] = SUB(next[n + i], SCALE(c[i], push));
    }
}

/* The same of the columns [2n * columns], by lanes: d(s^m) = m s^(m - 1) ds. S [contacts][ORDER +
 * 1][columns] collects ds. */
static inline __attribute__((always_inline)) void column_order(const ric_model *m, int n,
                                                               int contacts, int columns, int j,
                                                               const powers *p, lane *A, lane *S)
{
    int lanes = columns / LANES;
    const lane *now = A + (size_t)j * 2 * (size_t)n * (size_t)lanes;
    lane *next = A + (size_t)(j + 1) * 2 * (size_t)n * (size_t)lanes;
    real over = OVER(1, j + 1);
    for (int i = 0; i < n; i++) {
        real kappa = SCALE(m->kappa[i], over), stiff = SCALE(m->stiff[i], NEG(over));
        for (int k = 0; k < lanes; k++) {
            next[i * lanes + k] = MUL(kappa, now[(n + i) * lanes + k]);
            next[(n + i) * lanes + k] = MUL(stiff, now[i * lanes + k]);
        }
    }
    for (int f = 0; f < contacts; f++) {
        const real *u = p[f].power[p[f].count].back + ORDER - j;
        const double *g = m->g + f * n, *c = m->c + f * n;
        real factor = SCALE(m->contact[f].exponent, SCALE(m->spring[f], over));
        lane *all = S + (size_t)f * (ORDER + 1) * (size_t)lanes;
        for (int k = 0; k < lanes; k++) {
            lane ds = {0}, even = {0}, odd = {0};
            for (int i = 0; i < n; i++) ds = ADD(ds, SCALE(g[i], now[i * lanes + k]));
            all[j * lanes + k] = ds;
            int l = 0;
            for (; l + 1 < j; l += 2) {
                even = ADD(even, MUL(u[l], all[l * lanes + k]));
                odd = ADD(odd, MUL(u[l + 1], all[(l + 1) * lanes + k]));
            }
            if (l < j) even = ADD(even, MUL(u[l], all[l * lanes + k]));
            lane push = MUL(factor, ADD(ADD(even, odd), MUL(u[j], ds)));
            for (int i = 0; i < n; i++)
                next[(n + i) * lanes + k] = SUB(next[(n + i) * lanes + k], SCALE(c[i], push));
        }
    }
}

/* Adds x^2 N N' to S [2n * 2n], where x is the size of the state w and N the inverse of M [2n *
 * 2n]: that is symplectic in (q, p), a = kappa q, so that the blocks of N are those of M
 * transposed. */
static void gather(const ric_model *m, const real *w, const real *M, double *S)
{
    int n = m->n, size = 2 * n;
    double N[size * size], x = top_of(size, w);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double over = 1 / m->kappa[j];
            N[i * size + j] = m->kappa[i] * NEAR(M[(n + j) * size + n + i]) * over;
            N[i * size + n + j] = -m->kappa[i] * NEAR(M[j * size + n + i]);
            N[(n + i) * size + j] = -NEAR(M[(n + j) * size + i]) * over;
            N[(n + i) * size + n + j] = NEAR(M[j * size + i]);
        }
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++)
            S[i * size + j] += x * x * ric_dot(size, N + i * size, N + j * size);
}

/* Numbers of workspace for `columns` neighbours; it starts at a multiple of the size of a lane. The
 * powers take an even number of them: what follows is read by lanes. */
static size_t powers_size(void)
{
    return (sizeof(powers) + sizeof(lane) - 1) / sizeof(lane) * LANES;
}

static size_t series_work(const ric_model *m, int columns)
{
    size_t n = (size_t)m->n, contacts = (size_t)m->n_contact, width = 1 + (size_t)columns;
    return contacts * powers_size() + (ORDER + 1) * (2 * n + contacts) * width;
}

/* Takes w [2n] and X [2n * columns] through the time tau. S [2n * 2n] may be NULL: where X starts
 * as 1, it gathers the rounding of the steps, over epsilon and squared, taken back to the start. */
static inline __attribute__((always_inline)) bool fly_series(const ric_model *m, int n,
                                                             int contacts, int columns, real tau,
                                                             real *w, real *X, double *S,
                                                             real *work)
{
    powers *p = (powers *)work;
    real *W = work + (size_t)contacts * powers_size(), *A = W + (size_t)(ORDER + 1) * 2 * (size_t)n;
    real *series = A + (size_t)(ORDER + 1) * 2 * (size_t)n * (size_t)columns,
         left = NEAR(tau) < 0 ? NEG(tau) : tau;
    int sign = NEAR(tau) < 0 ? -1 : 1;
    if (!isfinite(NEAR(tau))) return false;
    for (int f = 0; f < contacts; f++) plan(m->contact[f].exponent, &p[f]);
    for (int step = 0; NEAR(left) > 0; step++) {
        if (step == RIC_SMOOTH_STEPS || ric_halt(ORDER * ORDER * (1.0 + contacts) * (1 + columns)))
            return false;
        memcpy(W, w, 2 * (size_t)n * sizeof *w);
        if (columns) memcpy(A, X, 2 * (size_t)n * (size_t)columns * sizeof *X);
        for (int j = 0; j < ORDER; j++) {
            state_order(m, n, contacts, j, p, W);
            if (columns)
                column_order(m, n, contacts, columns, j, p, (lane *)(void *)A,
                             (lane *)(void *)series);
        }
        double longest = radius(2 * n, W);
        if (columns) longest = fmin(longest, radius(2 * n * columns, A));
        const bool shorter = LESS(FROM(longest), left);
        real h = advance(m, n, contacts, p, shorter ? FROM(longest) : left, sign, W, w);
        if (!(NEAR(h) > 0)) return false;
        if (columns) sum_series(2 * n * columns, SCALE(sign, h), A, X);
        if (S) gather(m, w, X, S);
        left = SUB(left, h);
        for (int i = 0; i < 2 * n; i++)
            if (!isfinite(NEAR(w[i]))) return false;
    }
    return true;
}
