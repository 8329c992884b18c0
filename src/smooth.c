#include "smooth.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "motion.h"

/* Highest order of the series. With a radius of convergence r and the step h = r TRUNCATION^(1/ORDER) the cost of a time is
 * ORDER^2 / h, least at ORDER = -ln(TRUNCATION) / 2 = 18 (Jorba and Zou 2005) if only the products counted; what each step costs besides
 * moves it up. */
enum { ORDER = 28, PAD = 4 };
/* Last terms of the series, relative to the largest coordinate: the terms left out add up to a quarter of it. */
#define TRUNCATION DBL_EPSILON
/* What the equation of motion may be off by at the end of a step, over ORDER, relative to the largest coordinate: rounding takes the half. */
#define DEFECT (4 * DBL_EPSILON)
/* Exponents up to this one show all of themselves within the orders computed. */
enum { SEEN = ORDER - 3 };

typedef double pair __attribute__((vector_size(16)));

/* Coefficients forwards and backwards, so that a convolution is a product of two stretches of memory: back[ORDER - j] = x[j]. */
typedef struct {
    double x[ORDER + PAD], back[ORDER + PAD];
} numbers;

/* The series of one contact: s, its powers on the way to s^(m - 1), which is the last, and s^m. */
typedef struct {
    int count;                /* products to s^(m - 1); series 0 is s, series k the k-th product */
    int left[RIC_SMOOTH_PRODUCTS + 1], right[RIC_SMOOTH_PRODUCTS + 1];
    numbers power[RIC_SMOOTH_PRODUCTS + 1];
} powers;

int ric_smooth_products(int exponent, int *left, int *right)
{
    int count = 0, product = -1;
    for (int rest = (exponent - 1) / 2, square = 0; rest > 0; rest /= 2) {
        left[++count] = square;
        right[count] = square;
        square = count;
        if (rest % 2 == 0) continue;
        if (product >= 0) {
            left[++count] = product;
            right[count] = square;
            product = count;
        } else product = square;
    }
    return count;
}

static void plan(int exponent, powers *p)
{
    memset(p->power, 0, sizeof p->power);
    p->count = ric_smooth_products(exponent, p->left, p->right);
}

static inline double larger(double a, double b)
{
    return a > b ? a : b;
}

static inline double top_of(int count, const double *x)
{
    double a = 0, b = 0;
    int i = 0;
    for (; i + 1 < count; i += 2) {
        a = larger(a, fabs(x[i]));
        b = larger(b, fabs(x[i + 1]));
    }
    if (i < count) a = larger(a, fabs(x[i]));
    return larger(a, b);
}

/* sum of x_l y_(j-l), l = 1 .. j-1: all but the newest coefficients, which wait for it in registers. */
static inline double middle(int j, const numbers *x, const numbers *y)
{
    const double *a = x->x, *b = y->back + ORDER - j;
    pair s = {0, 0}, t = {0, 0}, a0, b0, a1, b1;
    int l = 1;
    for (; l + 3 < j; l += 4) {
        memcpy(&a0, a + l, sizeof a0);
        memcpy(&b0, b + l, sizeof b0);
        memcpy(&a1, a + l + 2, sizeof a1);
        memcpy(&b1, b + l + 2, sizeof b1);
        s += a0 * b0;
        t += a1 * b1;
    }
    s += t;
    double sum = s[0] + s[1];
    for (; l < j; l++) sum += a[l] * b[l];
    return sum;
}

static inline double convolve(int j, const numbers *x, const numbers *y)
{
    if (j == 0) return x->x[0] * y->x[0];
    return middle(j, x, y) + (x->x[0] * y->x[j] + x->x[j] * y->x[0]);
}

static inline void set(numbers *x, int j, double value)
{
    x->x[j] = x->back[ORDER - j] = value;
}

/* Coefficient j of all powers from s_j; returns that of s^m. */
static inline double extend(powers *p, int j, double s)
{
    set(&p->power[0], j, s);
    for (int k = 1; k <= p->count; k++) set(&p->power[k], j, convolve(j, &p->power[p->left[k]], &p->power[p->right[k]]));
    return convolve(j, &p->power[p->count], &p->power[0]);
}

/* In doubles, and an even number: what follows in the workspace is read by pairs. */
static size_t powers_size(void)
{
    return (sizeof(powers) + sizeof(pair) - 1) / sizeof(pair) * 2;
}

size_t ric_smooth_work(const ric_model *m, int columns)
{
    size_t n = (size_t)m->n, contacts = (size_t)m->n_contact, width = 1 + (size_t)columns;
    return contacts * powers_size() + (ORDER + 1) * (2 * n + contacts) * width;
}

/* x^k by binary powers: the same bits everywhere. */
static double power(double x, int k)
{
    double result = 1;
    for (; k > 0; k /= 2) {
        if (k % 2) result *= x;
        x *= x;
    }
    return result;
}

/* Step for which the terms of the two highest orders stay below TRUNCATION of the size. */
static inline double radius(int count, const double *coefficients)
{
    double size = TRUNCATION * top_of(count, coefficients), h = HUGE_VAL;
    for (int j = ORDER; j >= ORDER - 1; j--) {
        double top = top_of(count, coefficients + (size_t)j * count);
        if (top > 0) h = fmin(h, pow(size / top, 1.0 / j));
    }
    return h;
}

/* S(R) = sum |s_j| R^j. */
static double majorant(const double *s, double R)
{
    double sum = fabs(s[ORDER - 1]);
    for (int j = ORDER - 2; j >= 0; j--) sum = fabs(s[j]) + R * sum;
    return sum;
}

/* Powers beyond SEEN announce themselves too late: seen from s = 0 the series of s^99 starts at order 99, and the terms computed say nothing
 * of what is left out. Cauchy's bound does: no coefficient of s^m exceeds S(R)^m R^-j. With it the force leaves less than
 * spring |c| S(R)^m h (h/R)^ORDER / (ORDER (1 - h/R)) out of p, m times that of neighbours. The step is the longest that keeps this below
 * TRUNCATION of the size for one of a few R. */
static double guard(const ric_model *m, int n, int contacts, const powers *p, double size, double h)
{
    for (int f = 0; f < contacts; f++) {
        int exponent = m->contact[f].exponent;
        if (exponent <= SEEN) continue;
        double best = 0, factor = exponent * m->spring[f] * top_of(n, m->c + f * n) * h / ORDER;
        for (double R = 6 * h; R / 2 > best; R *= 0.7) {
            double bound = pow(TRUNCATION * size / (factor * power(majorant(p[f].power[0].x, R), exponent)), 1.0 / ORDER);
            best = fmax(best, R * fmin(bound, 0.5));
        }
        h = fmin(h, best);
    }
    return h;
}

/* x [count] at h. */
static inline __attribute__((always_inline)) void sum_series(int count, double h, const double *coefficients, double *x)
{
    memcpy(x, coefficients + (size_t)ORDER * count, (size_t)count * sizeof *x);
    for (int j = ORDER - 1; j >= 0; j--)
        for (int i = 0; i < count; i++) x[i] = coefficients[(size_t)j * count + i] + h * x[i];
}

/* Largest |dp/dt - force| at h, where the series has come to w. The last term left out grows like t^ORDER: the error that the step leaves in
 * p is h / ORDER times this. */
static inline __attribute__((always_inline)) double defect(const ric_model *m, int n, int contacts, double h, const double *W, const double *w)
{
    double off = 0, push[contacts];
    for (int f = 0; f < contacts; f++) {
        double s = 0;
        for (int i = 0; i < n; i++) s += m->g[f * n + i] * w[i];
        push[f] = m->spring[f] * power(s, m->contact[f].exponent);
    }
    for (int i = 0; i < n; i++) {
        double rate = ORDER * W[(size_t)ORDER * 2 * n + n + i];
        for (int j = ORDER - 1; j >= 1; j--) rate = j * W[(size_t)j * 2 * n + n + i] + h * rate;
        rate += m->stiff[i] * w[i];
        for (int f = 0; f < contacts; f++) rate += push[f] * m->c[f * n + i];
        off = larger(off, fabs(rate));
    }
    return off;
}

/* The step, at most h, and the state w after it. */
static inline __attribute__((always_inline)) double advance(const ric_model *m, int n, int contacts, const powers *p, double h, double sign,
                                                            const double *W, double *w)
{
    double size = top_of(2 * n, W), limit = DEFECT * size * ORDER;
    h = guard(m, n, contacts, p, size, h);
    for (;;) {
        sum_series(2 * n, sign * h, W, w);
        double off = h * defect(m, n, contacts, sign * h, W, w);
        if (off <= limit || !(h > 0)) return h;
        h *= off < HUGE_VAL ? larger(0.2, 0.9 * pow(limit / off, 1.0 / (ORDER + 1))) : 0.2;
    }
}

/* Coefficient j + 1 of the state [2n] from coefficient j. */
static inline __attribute__((always_inline)) void state_order(const ric_model *m, int n, int contacts, int j, powers *p, double *W)
{
    const double *a = W + (size_t)j * 2 * n;
    double *next = W + (size_t)(j + 1) * 2 * n, over = 1.0 / (j + 1);
    for (int i = 0; i < n; i++) {
        next[i] = over * m->kappa[i] * a[n + i];
        next[n + i] = -over * m->stiff[i] * a[i];
    }
    for (int f = 0; f < contacts; f++) {
        const double *g = m->g + f * n, *c = m->c + f * n;
        double s = 0;
        for (int i = 0; i < n; i++) s += g[i] * a[i];
        double push = over * m->spring[f] * extend(&p[f], j, s);
        for (int i = 0; i < n; i++) next[n + i] -= push * c[i];
    }
}

/* The same of the columns [2n * columns], by pairs: d(s^m) = m s^(m - 1) ds. S [contacts][ORDER + 1][columns] collects ds. */
static inline __attribute__((always_inline)) void column_order(const ric_model *m, int n, int contacts, int columns, int j, const powers *p,
                                                               pair *A, pair *S)
{
    int pairs = columns / 2;
    const pair *now = A + (size_t)j * 2 * n * pairs;
    pair *next = A + (size_t)(j + 1) * 2 * n * pairs;
    double over = 1.0 / (j + 1);
    for (int i = 0; i < n; i++) {
        double kappa = over * m->kappa[i], stiff = -over * m->stiff[i];
        for (int k = 0; k < pairs; k++) {
            next[i * pairs + k] = kappa * now[(n + i) * pairs + k];
            next[(n + i) * pairs + k] = stiff * now[i * pairs + k];
        }
    }
    for (int f = 0; f < contacts; f++) {
        const double *u = p[f].power[p[f].count].back + ORDER - j, *g = m->g + f * n, *c = m->c + f * n;
        double factor = over * m->spring[f] * m->contact[f].exponent;
        pair *all = S + (size_t)f * (ORDER + 1) * pairs;
        for (int k = 0; k < pairs; k++) {
            pair ds = {0, 0}, even = {0, 0}, odd = {0, 0};
            for (int i = 0; i < n; i++) ds += g[i] * now[i * pairs + k];
            all[j * pairs + k] = ds;
            int l = 0;
            for (; l + 1 < j; l += 2) {
                even += u[l] * all[l * pairs + k];
                odd += u[l + 1] * all[(l + 1) * pairs + k];
            }
            if (l < j) even += u[l] * all[l * pairs + k];
            pair push = factor * (even + odd + u[j] * ds);
            for (int i = 0; i < n; i++) next[(n + i) * pairs + k] -= c[i] * push;
        }
    }
}

/* Adds x^2 N N' to S [2n * 2n], where x is the size of the state w and N the inverse of M [2n * 2n]: that is symplectic in (q, p), a = kappa q, so
 * that the blocks of N are those of M transposed. */
static void gather(const ric_model *m, const double *w, const double *M, double *S)
{
    int n = m->n, size = 2 * n;
    double N[size * size], x = top_of(size, w);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double over = 1 / m->kappa[j];
            N[i * size + j] = m->kappa[i] * M[(n + j) * size + n + i] * over;
            N[i * size + n + j] = -m->kappa[i] * M[j * size + n + i];
            N[(n + i) * size + j] = -M[(n + j) * size + i] * over;
            N[(n + i) * size + n + j] = M[j * size + i];
        }
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++) S[i * size + j] += x * x * ric_dot(size, N + i * size, N + j * size);
}

/* S [2n * 2n] may be NULL: it gathers the rounding of the steps, taken back to the start, which is that of X = 1. */
static inline __attribute__((always_inline)) bool fly(const ric_model *m, int n, int contacts, int columns, double tau, double *w, double *X,
                                                      double *S, double *work)
{
    powers *p = (powers *)work;
    double *W = work + contacts * powers_size(), *A = W + (size_t)(ORDER + 1) * 2 * n;
    double *series = A + (size_t)(ORDER + 1) * 2 * n * columns, left = fabs(tau), sign = tau < 0 ? -1 : 1;
    if (!isfinite(tau)) return false;
    for (int f = 0; f < contacts; f++) plan(m->contact[f].exponent, &p[f]);
    for (int step = 0; left > 0; step++) {
        if (step == RIC_SMOOTH_STEPS) return false;
        memcpy(W, w, 2 * (size_t)n * sizeof *w);
        if (columns) memcpy(A, X, 2 * (size_t)n * columns * sizeof *X);
        for (int j = 0; j < ORDER; j++) {
            state_order(m, n, contacts, j, p, W);
            if (columns) column_order(m, n, contacts, columns, j, p, (pair *)A, (pair *)series);
        }
        double h = fmin(radius(2 * n, W), left);
        if (columns) h = fmin(h, radius(2 * n * columns, A));
        h = advance(m, n, contacts, p, h, sign, W, w);
        if (!(h > 0)) return false;
        if (columns) sum_series(2 * n * columns, sign * h, A, X);
        if (S) gather(m, w, X, S);
        left -= h;
        for (int i = 0; i < 2 * n; i++)
            if (!isfinite(w[i])) return false;
    }
    return true;
}

/* The same code with sizes known to the compiler for the structures of the article. */
static bool go(const ric_model *m, double tau, double *w, int columns, double *X, double *S, double *work)
{
    if (m->n == 2 && m->n_contact == 1 && columns == 4) return fly(m, 2, 1, 4, tau, w, X, S, work);
    if (m->n == 2 && m->n_contact == 1 && columns == 0) return fly(m, 2, 1, 0, tau, w, X, S, work);
    return fly(m, m->n, m->n_contact, columns, tau, w, X, S, work);
}

bool ric_smooth_fly(const ric_model *m, double tau, double *w, int columns, double *X, double *work)
{
    return go(m, tau, w, columns, X, NULL, work);
}

bool ric_smooth_map(const ric_model *m, double tau, double *w, double *M, double *lost, double *work)
{
    int size = 2 * m->n;
    double S[size * size], start = top_of(size, w), largest = 0;
    for (int i = 0; i < size * size; i++) M[i] = i % (size + 1) == 0;
    for (int i = 0; i < size * size; i++) S[i] = start * start * M[i];
    if (!go(m, tau, w, size, M, S, work)) return false;
    for (int i = 0; i < size; i++) {
        const double *row = M + i * size;
        double sum = 0, own = start * start * ric_dot(size, row, row); /* where S is lost in rounding, too, the start is left */
        for (int j = 0; j < size; j++) sum += row[j] * ric_dot(size, S + j * size, row);
        largest = larger(largest, larger(sum, own));
    }
    *lost = sqrt(largest);
    return true;
}
