/* The flow and its neighbours in quadruple precision, for one purpose: where a multiplier passes 1 so slowly that the rounding of a flight in
 * double covers the place. Beside a multiplication of high order tau2 - 2 may stay below 1e-9 over a whole branch, and its zero is known to
 * 1e-14 / 1e-9 only; in quadruple precision nothing of that is seen. The orbit itself is known well enough: its corrections are
 * solved for in double, from residuals in quadruple precision. */
#include "fine.h"

#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "smooth.h"
#include "status.h"
#include "trace.h"

/* 113 bits: of the compiler on x86, long double elsewhere. */
#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 quad;
#else
typedef long double quad;
#endif

#define TRUNCATION 1e-33  /* last terms of a series, relative to the largest coordinate */
#define SETTLED 1e-17     /* an orbit is corrected until it moves by less, relative; the next time it would move by a billionth of that */
#define PLACED 1e-18      /* and the branch point until it does */
#define FIRST 1e-8        /* first step of the secant */
#define REGULAR 1e-9      /* smaller singular values, relative, belong to the family and to the phase */
#define NEAR 1e-2         /* a branch point farther away, relative, is another one */
enum { LOWEST_ORDER = 40, CORRECTIONS = 12, SECANTS = 20 };

typedef struct {
    const ric_chain *chain;
    const ric_model *m;
    int kind, n, rows, order;
    double scale;
    quad *Y, *s, *power; /* series of state and neighbours, of their gaps, and of the powers of the first of these */
    quad *w, *X;         /* [2n], and [2n * width] state and neighbours */
    quad *u, *residual;  /* a point of the branch [n_unknown] and what it leaves of the conditions at its end [rows] */
    double *inverse;     /* [n_unknown * rows] of their derivatives */
    quad *B;             /* [(2n)^2], and at least [(n + 1)^2] */
} fine;

/* ------------------------------------------------------------------- the flow */

static quad convolve(int j, const quad *x, const quad *y)
{
    quad sum = 0;
    for (int l = 0; l <= j; l++) sum += x[l] * y[j - l];
    return sum;
}

/* Coefficients up to `order` of the state, the first column of Y [order + 1][2n][width], and of its neighbours, the others. */
static void expand(fine *q, int width, int order)
{
    const ric_model *m = q->m;
    int n = q->n, size = 2 * n * width, length = q->order + 1;
    for (int j = 0; j < order; j++) {
        const quad *now = q->Y + (size_t)j * size;
        quad *next = q->Y + (size_t)(j + 1) * size, over = (quad)1 / (j + 1);
        for (int k = 0; k < n * width; k++) {
            next[k] = over * m->kappa[k / width] * now[n * width + k];
            next[n * width + k] = -over * m->stiff[k / width] * now[k];
        }
        for (int f = 0; f < m->n_contact; f++) {
            int left[RIC_SMOOTH_PRODUCTS + 1], right[RIC_SMOOTH_PRODUCTS + 1];
            int count = ric_smooth_products(m->contact[f].exponent, left, right);
            quad *s = q->s + (size_t)f * width * length, *power = q->power + (size_t)f * (RIC_SMOOTH_PRODUCTS + 1) * length;
            for (int k = 0; k < width; k++) {
                s[k * length + j] = 0;
                for (int i = 0; i < n; i++) s[k * length + j] += m->g[f * n + i] * now[i * width + k];
            }
            power[j] = s[j];
            for (int i = 1; i <= count; i++) power[i * length + j] = convolve(j, power + left[i] * length, power + right[i] * length);
            for (int k = 0; k < width; k++) {
                quad push = over * m->spring[f] * (k ? m->contact[f].exponent : 1) * convolve(j, power + count * length, s + k * length);
                for (int i = 0; i < n; i++) next[(n + i) * width + k] -= m->c[f * n + i] * push;
            }
        }
    }
}

/* Where the last terms of the series are too small to be seen. */
static double step_of(const fine *q, int size)
{
    double top[4] = {0}, h = HUGE_VAL;
    for (int k = 0; k < size; k++) {
        top[0] = fmax(top[0], fabs((double)q->Y[k]));
        for (int i = 1; i < 4; i++) top[i] = fmax(top[i], fabs((double)q->Y[(size_t)(q->order - 3 + i) * size + k]));
    }
    for (int i = 1; i < 4; i++)
        if (top[i] > 0) h = fmin(h, pow(TRUNCATION * top[0] / top[i], 1.0 / (q->order - 3 + i)));
    return h;
}

/* Takes the columns of X [2n * width], the first of which is the state, through the time tau > 0. */
static bool fly(fine *q, quad tau, int width, quad *X)
{
    int size = 2 * q->n * width;
    quad left = tau;
    for (int step = 0; left > 0; step++) {
        if (step == RIC_SMOOTH_STEPS) return false;
        memcpy(q->Y, X, (size_t)size * sizeof *X);
        expand(q, width, q->order);
        double longest = step_of(q, size);
        if (!(longest > 0)) return false;
        quad h = longest < left ? (quad)longest : left;
        for (int k = 0; k < size; k++) {
            X[k] = 0;
            for (int j = q->order; j >= 0; j--) X[k] = X[k] * h + q->Y[(size_t)j * size + k];
        }
        left -= h;
    }
    return true;
}

/* ------------------------------------------------------------------ the orbit */

/* Column k of X [2n * width]: the state that the start block u makes, or column k - 1 of its derivatives. */
static void lift(const fine *q, const quad *u, int width, quad *X)
{
    int n = q->n, first = q->chain->start == RIC_MIRROR_CENTRE ? n : 0;
    memset(X, 0, 2 * (size_t)n * width * sizeof *X);
    for (int i = 0; i < q->chain->n_start; i++) {
        X[(first + i) * width] = u[i];
        if (width > 1) X[(first + i) * width + 1 + i] = 1;
    }
}

/* What a condition at the end of the flight leaves of a state that has come from `start`, or of a derivative of one: components a stride apart. */
static quad off_end(const fine *q, int row, const quad *end, int stride, quad start)
{
    const ric_chain *c = q->chain;
    if (c->end == RIC_MIRROR_REST) return end[(q->n + row) * stride];
    if (c->end == RIC_MIRROR_CENTRE) return end[row * stride];
    return end[row * stride] - c->sigma * start;
}

static void rate(fine *q, const quad *w, quad *out)
{
    memcpy(q->Y, w, 2 * (size_t)q->n * sizeof *w);
    expand(q, 1, 1);
    memcpy(out, q->Y + 2 * q->n, 2 * (size_t)q->n * sizeof *out);
}

/* The pseudo-inverse, in double, of the derivatives of the end conditions at u. */
static bool invert(fine *q)
{
    int columns = q->chain->n_unknown, n_start = q->chain->n_start, width = 1 + n_start, rows = q->rows, rank;
    int most = rows > columns ? rows : columns;
    double J[rows * columns], B[most * rows], values[most];
    quad velocity[2 * q->n];
    lift(q, q->u, width, q->X);
    if (!fly(q, q->u[n_start], width, q->X)) return false;
    for (int i = 0; i < 2 * q->n; i++) q->w[i] = q->X[i * width];
    rate(q, q->w, velocity);
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < n_start; k++) J[i * columns + k] = (double)off_end(q, i, q->X + 1 + k, width, i == k);
        J[i * columns + n_start] = (double)velocity[q->chain->end == RIC_MIRROR_REST ? q->n + i : i];
    }
    memset(B, 0, sizeof B);
    for (int i = 0; i < rows; i++) B[i * rows + i] = 1;
    if (ric_lapack(LAPACKE_dgelsd(LAPACK_ROW_MAJOR, rows, columns, rows, J, columns, B, rows, values, REGULAR, &rank))) return false;
    memcpy(q->inverse, B, (size_t)columns * rows * sizeof *B);
    return true;
}

/* The orbit nearest to u, in u. */
static bool correct(fine *q)
{
    int columns = q->chain->n_unknown, n_start = q->chain->n_start;
    quad start[2 * q->n];
    for (int i = 0; i < CORRECTIONS; i++) {
        double moved = 0;
        lift(q, q->u, 1, q->w);
        memcpy(start, q->w, sizeof start);
        if (!(q->u[n_start] > 0) || !fly(q, q->u[n_start], 1, q->w)) return false;
        for (int k = 0; k < q->rows; k++) q->residual[k] = off_end(q, k, q->w, 1, start[k]);
        for (int j = 0; j < columns; j++) {
            quad du = 0;
            for (int k = 0; k < q->rows; k++) du -= q->inverse[j * q->rows + k] * q->residual[k];
            q->u[j] += du;
            moved = fmax(moved, fabs((double)du));
        }
        if (moved <= SETTLED * q->scale) return true;
    }
    return false;
}

/* ----------------------------------------------------------- the branch point */

static quad determinant(int size, quad *A)
{
    quad product = 1;
    for (int j = 0; j < size; j++) {
        int best = j;
        for (int i = j + 1; i < size; i++)
            if (fabs((double)A[i * size + j]) > fabs((double)A[best * size + j])) best = i;
        quad pivot = A[best * size + j];
        if (pivot == 0) return 0;
        product *= best == j ? pivot : -pivot;
        for (int k = j; k < size; k++) {
            quad swap = A[best * size + k];
            A[best * size + k] = A[j * size + k];
            A[j * size + k] = swap;
        }
        for (int i = j + 1; i < size; i++) {
            quad factor = A[i * size + j] / pivot;
            for (int k = j; k < size; k++) A[i * size + k] -= factor * A[j * size + k];
        }
    }
    return product;
}

/* The matrix of the flight takes neighbours that keep the mirror point at its start, and those that do not, to such that keep and do not keep
 * the one at its end: one block of it gets a kernel where the symmetry breaks (docs/theory.md section 5). That of type b has one already, along
 * the flow, and the rows of its image are perpendicular to the gradient of the energy: both border it. Without mirror points a neighbour
 * closes that is not turned round in half a period. */
static bool test(fine *q, quad *value)
{
    const ric_chain *c = q->chain;
    int n = q->n, n2 = 2 * n, mirrored = c->start != RIC_MIRROR_NONE, count = mirrored ? n : n2, width = 1 + count;
    int own = c->start == RIC_MIRROR_CENTRE ? n : 0, at_end = c->end == RIC_MIRROR_CENTRE ? n : 0; /* where what keeps a mirror point stands */
    int column = mirrored && q->kind != RIC_TEST_A ? n - own : own, row = mirrored && q->kind == RIC_TEST_D ? n - at_end : at_end;
    int size = count + (mirrored && q->kind == RIC_TEST_B);
    quad f[n2];
    double end[n2], h[n2];
    lift(q, q->u, 1, q->w);
    rate(q, q->w, f);
    memset(q->X, 0, (size_t)n2 * width * sizeof *q->X);
    for (int i = 0; i < n2; i++) q->X[i * width] = q->w[i];
    for (int k = 0; k < count; k++) q->X[(column + k) * width + 1 + k] = 1;
    if (!fly(q, q->u[c->n_start], width, q->X)) return false;
    for (int i = 0; i < n2; i++) end[i] = (double)q->X[i * width];
    ric_flight_secant(q->m, 0, end, end, h);
    memset(q->B, 0, (size_t)size * size * sizeof *q->B);
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < count; k++) q->B[i * size + k] = q->X[(row + i) * width + 1 + k] - (!mirrored && i == k);
        if (size == count) continue;
        q->B[i * size + count] = h[row + i];
        q->B[count * size + i] = f[column + i];
    }
    *value = determinant(size, q->B);
    return true;
}

/* The orbit at the distance x from u0 along t. */
static bool place(fine *q, const double *u0, const double *t, quad x)
{
    for (int i = 0; i < q->chain->n_unknown; i++) q->u[i] = u0[i] + x * t[i];
    return correct(q);
}

static bool look(fine *q, const double *u0, const double *t, quad x, quad *value)
{
    return place(q, u0, t, x) && test(q, value);
}

static bool create(fine *q, const ric_chain *c, int kind)
{
    const ric_model *m = c->model;
    size_t n2 = 2 * (size_t)c->n, width = 1 + n2, contacts = (size_t)m->n_contact;
    *q = (fine){.chain = c, .m = m, .kind = kind, .n = c->n, .order = LOWEST_ORDER, .scale = c->scale};
    q->rows = c->end == RIC_MIRROR_NONE ? 2 * c->n : c->n;
    /* a power beyond the order would not show in the series from s = 0 */
    for (size_t f = 0; f < contacts; f++) q->order = m->contact[f].exponent + 4 > q->order ? m->contact[f].exponent + 4 : q->order;
    size_t length = (size_t)q->order + 1;
    q->Y = malloc(length * n2 * width * sizeof *q->Y);
    q->s = malloc(contacts * width * length * sizeof *q->s);
    q->power = malloc(contacts * (RIC_SMOOTH_PRODUCTS + 1) * length * sizeof *q->power);
    q->X = malloc((n2 * width + n2 + (size_t)c->n_unknown + n2 + (n2 + 1) * (n2 + 1)) * sizeof *q->X);
    q->inverse = malloc(((size_t)c->n_unknown + 1) * (n2 + 1) * sizeof *q->inverse);
    if (!q->Y || !q->s || !q->power || !q->X || !q->inverse) return false;
    q->w = q->X + n2 * width;
    q->u = q->w + n2;
    q->residual = q->u + c->n_unknown;
    q->B = q->residual + n2;
    return true;
}

static void release(fine *q)
{
    free(q->Y);
    free(q->s);
    free(q->power);
    free(q->X);
    free(q->inverse);
}

bool ric_fine_branch_point(const ric_chain *c, int kind, const double *t, double *u)
{
    fine q;
    quad x0 = 0, x1 = FIRST * c->scale, f0, f1;
    bool good = create(&q, c, kind), found = false;
    for (int i = 0; good && i < c->n_unknown; i++) q.u[i] = u[i];
    good = good && invert(&q) && look(&q, u, t, x0, &f0) && look(&q, u, t, x1, &f1);
    for (int i = 0; good && !found && i < SECANTS && f1 != f0; i++) {
        quad x2 = x1 - f1 * (x1 - x0) / (f1 - f0);
        if (!(fabs((double)x2) <= NEAR * c->scale)) break;
        found = fabs((double)(x2 - x1)) <= PLACED * c->scale;
        x0 = x1;
        f0 = f1;
        x1 = x2;
        good = found ? place(&q, u, t, x1) : look(&q, u, t, x1, &f1);
    }
    for (int i = 0; good && found && i < c->n_unknown; i++) u[i] = (double)q.u[i];
    release(&q);
    return good && found;
}
