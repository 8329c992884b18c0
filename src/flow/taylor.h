/* One step after another of the smooth flow by Taylor series (power_flow.h), for one kind of numbers. This text is
 * included once for each of them, by a file that has defined
 *
 *     real            the numbers, and lane, a vector of LANES of them that is loaded and multiplied at once; sum_of
 * adds up one
 *     ORDER           of the series, and PAD, what lane may read beyond it
 *     EPSILON, ABS    of the numbers
 *
 * and gets fly_series. Lengths of steps are double. */
#include <math.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"

/* Last terms of the series, relative to the largest coordinate: the terms left out add up to a quarter of it. */
#define TRUNCATION EPSILON
/* What the equation of motion may be off by at the end of a step, over ORDER, relative to the largest coordinate:
 * rounding takes the half. */
#define DEFECT (4 * EPSILON)
/* Exponents up to this one show all of themselves within the orders computed. */
enum { SEEN = ORDER - 3 };

/* Coefficients forwards and backwards, so that a convolution is a product of two stretches of memory: back[ORDER - j] =
 * x[j]. */
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
        a = larger(a, (double)ABS(x[i]));
        b = larger(b, (double)ABS(x[i + 1]));
    }
    if (i < count) a = larger(a, (double)ABS(x[i]));
    return larger(a, b);
}

/* sum of x_l y_(j-l), l = 1 .. j-1: all but the newest coefficients, which wait for it in registers. */
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
        s += a0 * b0;
        t += a1 * b1;
    }
    s += t;
    real sum = sum_of(s);
    for (; l < j; l++) sum += a[l] * b[l];
    return sum;
}

static inline real convolve(int j, const numbers *x, const numbers *y)
{
    if (j == 0) return x->x[0] * y->x[0];
    return middle(j, x, y) + (x->x[0] * y->x[j] + x->x[j] * y->x[0]);
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
    real result = 1;
    for (; k > 0; k /= 2) {
        if (k % 2) result *= x;
        x *= x;
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
    double sum = (double)ABS(s[ORDER - 1]);
    for (int j = ORDER - 2; j >= 0; j--) sum = (double)ABS(s[j]) + R * sum;
    return sum;
}

/* Powers beyond SEEN announce themselves too late: seen from s = 0 the series of s^99 starts at order 99, and the terms
 * computed say nothing of what is left out. Cauchy's bound does: no coefficient of s^m exceeds S(R)^m R^-j. With it the
 * force leaves less than spring |c| S(R)^m h (h/R)^ORDER / (ORDER (1 - h/R)) out of p, m times that of neighbours. The
 * step is the longest that keeps this below TRUNCATION of the size for one of a few R. */
static double guard(const ric_model *m, int n, int contacts, const powers *p, double size, double h)
{
    for (int f = 0; f < contacts; f++) {
        int exponent = m->contact[f].exponent;
        if (exponent <= SEEN) continue;
        double best = 0, factor = exponent * m->spring[f] * h / ORDER, widest = 0;
        for (int i = 0; i < n; i++) widest = larger(widest, fabs(m->c[f * n + i]));
        factor *= widest;
        for (double R = 6 * h; R / 2 > best; R *= 0.7) {
            double bound = pow(TRUNCATION * size / (factor * (double)power(majorant(p[f].power[0].x, R), exponent)),
                               1.0 / ORDER);
            best = fmax(best, R * fmin(bound, 0.5));
        }
        h = fmin(h, best);
    }
    return h;
}

/* x [count] at h. */
static inline __attribute__((always_inline)) void sum_series(int count, real h, const real *coefficients, real *x)
{
    memcpy(x, coefficients + (size_t)ORDER * (size_t)count, (size_t)count * sizeof *x);
    for (int j = ORDER - 1; j >= 0; j--)
        for (int i = 0; i < count; i++) x[i] = coefficients[(size_t)j * (size_t)count + (size_t)i] + h * x[i];
}

/* Largest |dp/dt - force| at h, where the series has come to w. The last term left out grows like t^ORDER: the error
 * that the step leaves in p is h / ORDER times this. */
static inline __attribute__((always_inline)) double defect(const ric_model *m, int n, int contacts, real h,
                                                           const real *W, const real *w)
{
    double off = 0;
    real push[contacts];
    for (int f = 0; f < contacts; f++) {
        real s = 0;
        for (int i = 0; i < n; i++) s += m->g[f * n + i] * w[i];
        push[f] = m->spring[f] * power(s, m->contact[f].exponent);
    }
    for (int i = 0; i < n; i++) {
        real rate = ORDER * W[(size_t)ORDER * 2 * (size_t)n + (size_t)n + (size_t)i];
        for (int j = ORDER - 1; j >= 1; j--) rate = j * W[(size_t)j * 2 * (size_t)n + (size_t)n + (size_t)i] + h * rate;
        rate += m->stiff[i] * w[i];
        for (int f = 0; f < contacts; f++) rate += push[f] * m->c[f * n + i];
        off = larger(off, (double)ABS(rate));
    }
    return off;
}

/* The step, at most h, and the state w after it. */
static inline __attribute__((always_inline)) real advance(const ric_model *m, int n, int contacts, const powers *p,
                                                          real h, int sign, const real *W, real *w)
{
    double size = top_of(2 * n, W), limit = DEFECT * size * ORDER, longest = guard(m, n, contacts, p, size, (double)h);
    if (longest < h) h = longest;
    for (;;) {
        sum_series(2 * n, sign * h, W, w);
        double off = (double)h * defect(m, n, contacts, sign * h, W, w);
        if (off <= limit || !(h > 0)) return h;
        h *= off < HUGE_VAL ? larger(0.2, 0.9 * pow(limit / off, 1.0 / (ORDER + 1))) : 0.2;
    }
}

/* Coefficient j + 1 of the state [2n] from coefficient j. */
static inline __attribute__((always_inline)) void state_order(const ric_model *m, int n, int contacts, int j, powers *p,
                                                              real *W)
{
    const real *a = W + (size_t)j * 2 * (size_t)n;
    real *next = W + (size_t)(j + 1) * 2 * (size_t)n, over = (real)1 / (j + 1);
    for (int i = 0; i < n; i++) {
        next[i] = over * m->kappa[i] * a[n + i];
        next[n + i] = -over * m->stiff[i] * a[i];
    }
    for (int f = 0; f < contacts; f++) {
        const double *g = m->g + f * n, *c = m->c + f * n;
        real s = 0;
        for (int i = 0; i < n; i++) s += g[i] * a[i];
        real push = over * m->spring[f] * extend(&p[f], j, s);
        for (int i = 0; i < n; i++) next[n + i] -= push * c[i];
    }
}

/* The same of the columns [2n * columns], by lanes: d(s^m) = m s^(m - 1) ds. S [contacts][ORDER + 1][columns] collects
 * ds. */
static inline __attribute__((always_inline)) void column_order(const ric_model *m, int n, int contacts, int columns,
                                                               int j, const powers *p, lane *A, lane *S)
{
    int lanes = columns / LANES;
    const lane *now = A + (size_t)j * 2 * (size_t)n * (size_t)lanes;
    lane *next = A + (size_t)(j + 1) * 2 * (size_t)n * (size_t)lanes;
    real over = (real)1 / (j + 1);
    for (int i = 0; i < n; i++) {
        real kappa = over * m->kappa[i], stiff = -over * m->stiff[i];
        for (int k = 0; k < lanes; k++) {
            next[i * lanes + k] = kappa * now[(n + i) * lanes + k];
            next[(n + i) * lanes + k] = stiff * now[i * lanes + k];
        }
    }
    for (int f = 0; f < contacts; f++) {
        const real *u = p[f].power[p[f].count].back + ORDER - j;
        const double *g = m->g + f * n, *c = m->c + f * n;
        real factor = over * m->spring[f] * m->contact[f].exponent;
        lane *all = S + (size_t)f * (ORDER + 1) * (size_t)lanes;
        for (int k = 0; k < lanes; k++) {
            lane ds = {0}, even = {0}, odd = {0};
            for (int i = 0; i < n; i++) ds += g[i] * now[i * lanes + k];
            all[j * lanes + k] = ds;
            int l = 0;
            for (; l + 1 < j; l += 2) {
                even += u[l] * all[l * lanes + k];
                odd += u[l + 1] * all[(l + 1) * lanes + k];
            }
            if (l < j) even += u[l] * all[l * lanes + k];
            lane push = factor * (even + odd + u[j] * ds);
            for (int i = 0; i < n; i++) next[(n + i) * lanes + k] -= c[i] * push;
        }
    }
}

/* Adds x^2 N N' to S [2n * 2n], where x is the size of the state w and N the inverse of M [2n * 2n]: that is symplectic
 * in (q, p), a = kappa q, so that the blocks of N are those of M transposed. */
static void gather(const ric_model *m, const real *w, const real *M, double *S)
{
    int n = m->n, size = 2 * n;
    double N[size * size], x = top_of(size, w);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double over = 1 / m->kappa[j];
            N[i * size + j] = m->kappa[i] * (double)M[(n + j) * size + n + i] * over;
            N[i * size + n + j] = -m->kappa[i] * (double)M[j * size + n + i];
            N[(n + i) * size + j] = -(double)M[(n + j) * size + i] * over;
            N[(n + i) * size + n + j] = (double)M[j * size + i];
        }
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++) S[i * size + j] += x * x * ric_dot(size, N + i * size, N + j * size);
}

/* Numbers of workspace for `columns` neighbours; it starts at a multiple of the size of a lane. The powers take an even
 * number of them: what follows is read by lanes. */
static size_t powers_size(void)
{
    return (sizeof(powers) + sizeof(lane) - 1) / sizeof(lane) * LANES;
}

static size_t series_work(const ric_model *m, int columns)
{
    size_t n = (size_t)m->n, contacts = (size_t)m->n_contact, width = 1 + (size_t)columns;
    return contacts * powers_size() + (ORDER + 1) * (2 * n + contacts) * width;
}

/* Takes w [2n] and X [2n * columns] through the time tau. S [2n * 2n] may be NULL: where X starts as 1, it gathers the
 * rounding of the steps, over epsilon and squared, taken back to the start. */
static inline __attribute__((always_inline)) bool fly_series(const ric_model *m, int n, int contacts, int columns,
                                                             real tau, real *w, real *X, double *S, real *work)
{
    powers *p = (powers *)work;
    real *W = work + (size_t)contacts * powers_size(), *A = W + (size_t)(ORDER + 1) * 2 * (size_t)n;
    real *series = A + (size_t)(ORDER + 1) * 2 * (size_t)n * (size_t)columns, left = ABS(tau);
    int sign = tau < 0 ? -1 : 1;
    if (!isfinite((double)tau)) return false;
    for (int f = 0; f < contacts; f++) plan(m->contact[f].exponent, &p[f]);
    for (int step = 0; left > 0; step++) {
        if (step == RIC_SMOOTH_STEPS || ric_halt(ORDER * ORDER * (1.0 + contacts) * (1 + columns))) return false;
        memcpy(W, w, 2 * (size_t)n * sizeof *w);
        if (columns) memcpy(A, X, 2 * (size_t)n * (size_t)columns * sizeof *X);
        for (int j = 0; j < ORDER; j++) {
            state_order(m, n, contacts, j, p, W);
            if (columns) column_order(m, n, contacts, columns, j, p, (lane *)(void *)A, (lane *)(void *)series);
        }
        double longest = radius(2 * n, W);
        if (columns) longest = fmin(longest, radius(2 * n * columns, A));
        real h = advance(m, n, contacts, p, longest < left ? longest : left, sign, W, w);
        if (!(h > 0)) return false;
        if (columns) sum_series(2 * n * columns, sign * h, A, X);
        if (S) gather(m, w, X, S);
        left -= h;
        for (int i = 0; i < 2 * n; i++)
            if (!isfinite((double)w[i])) return false;
    }
    return true;
}
