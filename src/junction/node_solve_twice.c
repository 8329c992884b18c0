/* The flow and its neighbours in twice the digits of a double, for one purpose: where a multiplier
 * passes 1 so slowly that the rounding of a flight in double covers the place. Beside a
 * multiplication of high order tau2 - 2 may stay below 1e-9 over a whole branch, and its zero is
 * known to 1e-14 / 1e-9 only; with twice the digits nothing of that is seen. The orbit itself is
 * known well enough: its corrections are solved for in double, from residuals with twice the
 * digits. */
#include "node_solve_twice.h"

#include <stdlib.h>

#include <lapacke.h>

#include "orbit/room.h"
#include "flow/room.h"
#include "base/room.h"
#include "branch/room.h"

/* What is not a flight is computed in 113 bits, of the compiler on x86, or in long double
 * elsewhere: it is little. */
#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 real;
#else
typedef long double real;
#endif

/* SETTLED: an orbit is corrected until it moves by less, relative; the next time it would move by a
 * ten-millionth of that, as it lies FIRST beside the orbit that the derivatives are those of */
#define SETTLED 1e-13
#define PLACED 1e-18 /* and the branch point until it does, or will with the next secant */
#define MARGIN 1e-3  /* of that, where it is told from the steps before */
#define FIRST 1e-8   /* first step of the secant */
#define REGULAR                                                                                    \
    1e-9          /* smaller singular values, relative, belong to the family and to the phase      \
                   */
#define NEAR 1e-2 /* a branch point farther away, relative, is another one */
enum { CORRECTIONS = 12, SECANTS = 20 };

typedef struct {
    const ric_shooting *chain;
    const ric_model *m;
    int kind, n, rows;
    double scale;
    real *w, *X; /* [2n] and [2n * columns] state and neighbours */
    int columns; /* unknowns of the orbit in one flight: inner nodes count for nothing here */
    real *u, *residual; /* a point of the branch [columns] and what it leaves of the conditions at
                           its end [rows] */
    double *inverse;    /* [columns * rows] of their derivatives */
    real *B;            /* [(2n)^2], and at least [(n + 1)^2] */
    ric_twice *flown, *work; /* of a flight: tau, w and X in twice the digits */
} fine;

static ric_twice twice(real x)
{
    const double hi = (double)x;
    return (ric_twice){hi, (double)(x - hi)};
}

static void put(ric_twice *out, const real *x, int count)
{
    for (int i = 0; i < count; i++) out[i] = twice(x[i]);
}

static void take(real *out, const ric_twice *x, int count)
{
    for (int i = 0; i < count; i++) out[i] = (real)x[i].hi + x[i].lo;
}

static bool fly(fine *q, real tau, int columns)
{
    const int n2 = 2 * q->n;
    put(q->flown, q->w, n2);
    put(q->flown + n2, q->X, n2 * columns);
    if (!ric_power_flow_twice(q->m, twice(tau), q->flown, columns, q->flown + n2, q->work))
        return false;
    take(q->w, q->flown, n2);
    take(q->X, q->flown + n2, n2 * columns);
    return true;
}

/* x^k by binary powers. */
static real power(real x, int k)
{
    real result = 1;
    for (; k > 0; k /= 2) {
        if (k % 2) result *= x;
        x *= x;
    }
    return result;
}

/* ------------------------------------------------------------------ the orbit */

/* The state that the start block u makes. */
static void lift(fine *q, const real *u)
{
    int n = q->n, count = q->chain->n_start, first = q->chain->start == RIC_MIRROR_CENTRE ? n : 0;
    memset(q->w, 0, 2 * (size_t)n * sizeof *q->w);
    for (int i = 0; i < count; i++) q->w[first + i] = u[i];
}

/* What a condition at the end of the flight leaves of a state that has come from `start`, or of a
 * derivative of one: components a stride apart. */
static real off_end(const fine *q, int row, const real *end, int stride, real start)
{
    const ric_shooting *c = q->chain;
    if (c->end == RIC_MIRROR_REST) return end[(q->n + row) * stride];
    if (c->end == RIC_MIRROR_CENTRE) return end[row * stride];
    return end[row * stride] - c->sigma * start;
}

static void rate(const fine *q, const real *w, real *out)
{
    const ric_model *m = q->m;
    int n = q->n;
    for (int i = 0; i < n; i++) {
        out[i] = m->kappa[i] * w[n + i];
        out[n + i] = -m->stiff[i] * w[i];
    }
    for (int f = 0; f < m->n_contact; f++) {
        real s = 0;
        for (int i = 0; i < n; i++) s += m->g[f * n + i] * w[i];
        real push = m->spring[f] * power(s, m->contact[f].exponent);
        for (int i = 0; i < n; i++) out[n + i] -= push * m->c[f * n + i];
    }
}

/* The pseudo-inverse of the derivatives of the end conditions at u, all in double: what it is off
 * by only makes corrections less good. */
static bool invert(fine *q)
{
    int columns = q->columns, n_start = q->chain->n_start, rows = q->rows, rank;
    int most = rows > columns ? rows : columns;
    double J[rows * columns], B[most * rows], values[most];
    int n2 = 2 * q->n, first = q->chain->start == RIC_MIRROR_CENTRE ? q->n : 0;
    double w[n2], M[n2 * n2];
    real velocity[n2];
    lift(q, q->u);
    for (int i = 0; i < n2; i++) w[i] = (double)q->w[i];
    ric_flight_smooth(q->m, (double)q->u[n_start], w, M, NULL, w);
    if (!isfinite(w[0])) return false;
    for (int i = 0; i < n2; i++) q->w[i] = w[i];
    rate(q, q->w, velocity);
    for (int i = 0; i < n2 * n2; i++) q->X[i] = M[i];
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < n_start; k++)
            J[i * columns + k] = (double)off_end(q, i, q->X + first + k, n2, i == k);
        J[i * columns + n_start] = (double)
            velocity[q->chain->end == RIC_MIRROR_REST ? q->n + i : i];
    }
    memset(B, 0, sizeof B);
    for (int i = 0; i < rows; i++) B[i * rows + i] = 1;
    if (ric_lapack(LAPACKE_dgelsd(LAPACK_ROW_MAJOR, rows, columns, rows, J, columns, B, rows,
                                  values, REGULAR, &rank)))
        return false;
    memcpy(q->inverse, B, (size_t)columns * (size_t)rows * sizeof *B);
    return true;
}

/* The orbit nearest to u, in u. */
static bool correct(fine *q)
{
    int columns = q->columns, n_start = q->chain->n_start;
    real start[2 * q->n];
    for (int i = 0; i < CORRECTIONS; i++) {
        double moved = 0;
        lift(q, q->u);
        memcpy(start, q->w, sizeof start);
        if (!(q->u[n_start] > 0) || !fly(q, q->u[n_start], 0)) return false;
        for (int k = 0; k < q->rows; k++) q->residual[k] = off_end(q, k, q->w, 1, start[k]);
        for (int j = 0; j < columns; j++) {
            real du = 0;
            for (int k = 0; k < q->rows; k++) du -= q->inverse[j * q->rows + k] * q->residual[k];
            q->u[j] += du;
            moved = fmax(moved, fabs((double)du));
        }
        if (moved <= SETTLED * q->scale) return true;
    }
    return false;
}

/* ----------------------------------------------------------- the branch point */

static real determinant(int size, real *A)
{
    real product = 1;
    for (int j = 0; j < size; j++) {
        int best = j;
        for (int i = j + 1; i < size; i++)
            if (fabs((double)A[i * size + j]) > fabs((double)A[best * size + j])) best = i;
        real pivot = A[best * size + j];
        if (pivot == 0) return 0;
        product *= best == j ? pivot : -pivot;
        for (int k = j; k < size; k++) {
            real swap = A[best * size + k];
            A[best * size + k] = A[j * size + k];
            A[j * size + k] = swap;
        }
        for (int i = j + 1; i < size; i++) {
            real factor = A[i * size + j] / pivot;
            for (int k = j; k < size; k++) A[i * size + k] -= factor * A[j * size + k];
        }
    }
    return product;
}

/* The matrix of the flight takes neighbours that keep the mirror point at its start, and those that
 * do not, to such that keep and do not keep the one at its end: one block of it gets a kernel where
 * the symmetry breaks (docs/theory.md section 5). That of type b has one already, along the flow,
 * and the rows of its image are perpendicular to the gradient of the energy: both border it.
 * Without mirror points a neighbour closes that is not turned round in half a period. */
static bool test(fine *q, real *value)
{
    const ric_shooting *c = q->chain;
    int n = q->n, n2 = 2 * n, mirrored = c->start != RIC_MIRROR_NONE, count = mirrored ? n : n2;
    /* where what keeps a mirror point stands */
    int own = c->start == RIC_MIRROR_CENTRE ? n : 0, at_end = c->end == RIC_MIRROR_CENTRE ? n : 0;
    int column = mirrored && q->kind != RIC_TEST_A ? n - own : own,
        row = mirrored && q->kind == RIC_TEST_D ? n - at_end : at_end;
    int size = count + (mirrored && q->kind == RIC_TEST_B);
    real f[n2];
    double end[n2], h[n2];
    lift(q, q->u);
    rate(q, q->w, f);
    memset(q->X, 0, (size_t)n2 * (size_t)count * sizeof *q->X);
    for (int k = 0; k < count; k++) q->X[(column + k) * count + k] = 1;
    if (!fly(q, q->u[c->n_start], count)) return false;
    for (int i = 0; i < n2; i++) end[i] = (double)q->w[i];
    ric_flight_secant(q->m, 0, end, end, h);
    memset(q->B, 0, (size_t)size * (size_t)size * sizeof *q->B);
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < count; k++)
            q->B[i * size + k] = q->X[(row + i) * count + k] - (!mirrored && i == k);
        if (size == count) continue;
        q->B[i * size + count] = h[row + i];
        q->B[count * size + i] = f[column + i];
    }
    *value = determinant(size, q->B);
    return true;
}

/* The orbit at the distance x from u0 along t. */
static bool place(fine *q, const double *u0, const double *t, real x)
{
    for (int i = 0; i < q->columns; i++) q->u[i] = u0[i] + x * t[i];
    return correct(q);
}

static bool look(fine *q, const double *u0, const double *t, real x, real *value)
{
    return place(q, u0, t, x) && test(q, value);
}

static bool create(fine *q, const ric_shooting *c, int kind)
{
    size_t n2 = 2 * (size_t)c->n;
    *q = (fine){.chain = c,
                .m = c->model,
                .kind = kind,
                .n = c->n,
                .columns = c->n_start + 1,
                .scale = c->scale};
    q->rows = c->end == RIC_MIRROR_NONE ? 2 * c->n : c->n;
    q->work = ric_malloc(ric_power_flow_twice_work(c->model, 2 * c->n) * sizeof *q->work);
    q->flown = ric_malloc((n2 * n2 + n2) * sizeof *q->flown);
    q->X = ric_malloc((n2 * n2 + n2 + (size_t)q->columns + n2 + (n2 + 1) * (n2 + 1)) *
                      sizeof *q->X);
    q->inverse = ric_malloc(((size_t)q->columns + 1) * (n2 + 1) * sizeof *q->inverse);
    if (!q->work || !q->flown || !q->X || !q->inverse) return false;
    q->w = q->X + n2 * n2;
    q->u = q->w + n2;
    q->residual = q->u + q->columns;
    q->B = q->residual + n2;
    return true;
}

static void release(fine *q)
{
    free(q->work);
    free(q->flown);
    free(q->X);
    free(q->inverse);
}

/* The orbit in doubles, with the nodes that it has in more digits. */
static bool write_back(fine *q, double *u)
{
    const ric_shooting *c = q->chain;
    double node[2 * q->n];
    for (int i = 0; i < q->columns; i++) u[i] = (double)q->u[i];
    lift(q, q->u);
    for (int j = 1; j < c->parts; j++) {
        if (!fly(q, q->u[c->n_start] / c->parts, 0)) return false;
        for (int i = 0; i < 2 * q->n; i++) node[i] = (double)q->w[i];
        ric_shooting_nodes_put(c, j, node, u);
    }
    return true;
}

/* Whether the next secant moves by less than `least`. Errors of secants are products, e2 = C e1 e0,
 * so that e2 / e1 is at most e1 / e0: the next step is at most now^2 / before, with a margin.
 * before: 0 where it was none of a secant. */
static bool settles(double now, double before, double least)
{
    return fabs(now) <= least || now * now <= MARGIN * least * fabs(before);
}

bool ric_node_solve_twice(const ric_shooting *c, int kind, const double *t, double *u)
{
    fine q;
    real x0 = 0, x1 = FIRST * c->scale, f0, f1;
    bool good = create(&q, c, kind), found = false;
    for (int i = 0; good && i < q.columns; i++) q.u[i] = u[i];
    good = good && invert(&q) && look(&q, u, t, x0, &f0) && look(&q, u, t, x1, &f1);
    for (int i = 0; good && !found && i < SECANTS && f1 != f0; i++) {
        real x2 = x1 - f1 * (x1 - x0) / (f1 - f0);
        if (!(fabs((double)x2) <= NEAR * c->scale)) break;
        found = settles((double)(x2 - x1), i ? (double)(x1 - x0) : 0, PLACED * c->scale);
        x0 = x1;
        f0 = f1;
        x1 = x2;
        good = found ? place(&q, u, t, x1) : look(&q, u, t, x1, &f1);
    }
    good = good && found && write_back(&q, u);
    release(&q);
    return good;
}
