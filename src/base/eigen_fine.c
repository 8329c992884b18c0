#include "eigen_fine.h"
#include "eigen.h"

#include <complex.h>
#include <float.h>
#include <math.h>

typedef long double real;
typedef long double _Complex complex_t;

#define STEPS 8       /* of inverse iteration: its error is squared by each */
#define MOVES 3       /* by which an error is measured: a single one may lie across */
#define MEASURED 4.0L /* its margin */
/* SINGULAR: in place of a pivot that is zero: mu is then an eigenvalue to the last digit */
#define SINGULAR 0x1p-16000L

/* The factors as they are, or moved in one of several ways. */
typedef struct {
    const ric_eigen_factors *of;
    real move;
    unsigned way;
} product;

/* Entry x, moved, if at all, by no less than the rounding of the elimination. */
static real moved(real x, unsigned *bits, real move)
{
    return x + ric_moved(bits, move > 0) * (move + 2 * LDBL_EPSILON * fabsl(x));
}

/* A [2m * 2m] = [C, -1; -mu, B], for C NULL A [m * m] = B - mu. */
static void fill(const product *p, complex_t mu, complex_t *A)
{
    const real *B = p->of->B, *C = p->of->C;
    const int m = p->of->m, size = C ? 2 * m : m, low = C ? m : 0;
    unsigned bits = 2654435769u * (p->way + 1);
    for (int i = 0; i < size * size; i++) A[i] = 0;
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < m; j++) {
            A[(low + i) * size + low + j] = moved(B[i * m + j], &bits, p->move);
            if (C) A[i * size + j] = moved(C[i * m + j], &bits, p->move);
        }
        if (C) A[i * size + m + i] = -1;
        A[(low + i) * size + i] -= mu;
    }
}

/* Solves A z = r by elimination with row pivots; both are used up, z stands in r. */
static void solve(int size, complex_t *A, complex_t *r)
{
    for (int k = 0; k < size; k++) {
        int best = k;
        for (int i = k + 1; i < size; i++)
            if (cabsl(A[i * size + k]) > cabsl(A[best * size + k])) best = i;
        for (int j = 0; j < size && best != k; j++) {
            complex_t swap = A[k * size + j];
            A[k * size + j] = A[best * size + j];
            A[best * size + j] = swap;
        }
        complex_t swap = r[k];
        r[k] = r[best];
        r[best] = swap;
        if (!(cabsl(A[k * size + k]) > 0)) A[k * size + k] = SINGULAR;
        for (int i = k + 1; i < size; i++) {
            complex_t factor = A[i * size + k] / A[k * size + k];
            for (int j = k + 1; j < size; j++) A[i * size + j] -= factor * A[k * size + j];
            r[i] -= factor * r[k];
        }
    }
    for (int k = size - 1; k >= 0; k--) {
        for (int j = k + 1; j < size; j++) r[k] -= A[k * size + j] * r[j];
        r[k] /= A[k * size + k];
    }
}

/* (B C - mu) x' = x changes mu by x / x' where x' is largest. x [m] is the vector so far. False: no
 * number. */
static bool iterate(const product *p, complex_t *work, complex_t *x, complex_t *mu)
{
    const int m = p->of->m, size = p->of->C ? 2 * m : m;
    complex_t *A = work, *z = A + size * size;
    real last = HUGE_VALL;
    for (int step = 0; step < STEPS; step++) {
        fill(p, *mu, A);
        for (int i = 0; i < size; i++) z[i] = i < size - m ? 0 : x[i - (size - m)];
        solve(size, A, z);
        int most = 0;
        for (int i = 1; i < m; i++)
            if (cabsl(z[i]) > cabsl(z[most])) most = i;
        const complex_t change = x[most] / z[most], scale = 1 / z[most];
        if (!isfinite(cabsl(change)) || !isfinite(cabsl(scale))) return false;
        for (int i = 0; i < m; i++) x[i] = z[i] * scale;
        *mu += change;
        /* the first steps turn the vector, and from some step on there is nothing left but rounding
         */
        if (step > 1 && (cabsl(change) >= last || cabsl(change) <= LDBL_EPSILON * cabsl(*mu)))
            return true;
        last = cabsl(change);
    }
    return true;
}

bool ric_eigen_fine(const ric_eigen_factors *factors, double apart, long double _Complex *work,
                    double *mu, double *error)
{
    const int m = factors->m;
    complex_t x[m], found = mu[0] + mu[1] * I;
    const complex_t given = found;
    product p = {.of = factors};
    for (int i = 0; i < m; i++) x[i] = 1 + (real)i / m;
    if (!iterate(&p, work, x, &found)) return false;
    real off = 0;
    p.move = factors->rounding;
    for (p.way = 0; p.way < MOVES; p.way++) {
        complex_t again = found;
        if (!iterate(&p, work, x, &again)) return false;
        off = fmaxl(off, MEASURED * cabsl(again - found));
    }
    off += 2 * DBL_EPSILON * cabsl(found);
    if (!(cabsl(found - given) <= *error) || !(*error + cabsl(found - given) < apart / 2) ||
        !(off < *error))
        return false;
    /* one that is real in double has no other beside it, and is real */
    mu[0] = (double)creall(found);
    if (fabs(mu[1]) > 0) mu[1] = (double)cimagl(found);
    *error = (double)off;
    return true;
}
