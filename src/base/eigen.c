#include "eigen.h"
#include "memory.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#define MOVES 3      /* by which an error is measured: a single one may lie across */
#define MEASURED 4.0 /* its margin */

bool ric_eigen(int k, double *A, double *out)
{
    double re[k + 1], im[k + 1];
    for (int i = 0; i < k * k; i++)
        if (!isfinite(A[i])) return false;
    if (ric_lapack(LAPACKE_dgeev(LAPACK_ROW_MAJOR, 'N', 'N', k, A, k, re, im, NULL, 1, NULL, 1)))
        return false;
    for (int i = 0; i < k; i++) {
        out[2 * i] = re[i];
        out[2 * i + 1] = im[i];
    }
    return true;
}

bool ric_eigen_conditions(int k, const double *A, double *out, double *condition)
{
    const size_t kk = (size_t)k * (size_t)k;
    double re[k + 1], im[k + 1], norm, scale[k + 1], apart[k + 1];
    double *store = ric_calloc(3 * kk + 1, sizeof *store), *copy = store, *left = copy + kk,
           *right = left + kk;
    lapack_int first, last;
    bool found = store != NULL;
    for (size_t i = 0; i < kk && found; i++) found = isfinite(copy[i] = A[i]);
    /* read by columns it is the transpose, whose eigenvalues and conditions are the same; not
     * balanced, which would tell the conditions of another matrix */
    found = found && !ric_lapack(LAPACKE_dgeevx(LAPACK_COL_MAJOR, 'N', 'V', 'V', 'E', k, copy, k,
                                                re, im, left, k, right, k, &first, &last, scale,
                                                &norm, condition, apart));
    for (int i = 0; i < k && found; i++) {
        out[2 * i] = re[i];
        out[2 * i + 1] = im[i];
        condition[i] = 1 / condition[i];
    }
    free(store);
    return found;
}

static int by_value(const void *p, const void *q)
{
    const double *a = p, *b = q;
    return a[0] != b[0] ? (a[0] < b[0] ? -1 : 1) : (a[1] > b[1]) - (a[1] < b[1]);
}

/* By how much entries are moved, and in which pseudorandom way, from 1 on. */
typedef struct {
    double by;
    unsigned way;
} move_t;

/* Of factors whose entries are moved. */
static bool moved_product(int m, const double *B, const double *C, move_t move, double *H,
                          double *mu)
{
    double *R = H, *S = R + m * m, *A = S + m * m, tau[m];
    lapack_int pivot[m];
    unsigned bits = 2654435769u * move.way;
    for (int i = 0; i < m * m; i++) {
        R[i] = B[i] + ric_moved(&bits, move.by);
        A[i] = C[i] + ric_moved(&bits, move.by);
        if (!isfinite(R[i] + A[i])) return false;
    }
    memset(pivot, 0, sizeof pivot);
    if (ric_lapack(LAPACKE_dgeqp3(LAPACK_ROW_MAJOR, m, m, R, m, pivot, tau))) return false;
    for (int i = 0; i < m; i++) memcpy(S + i * m, A + (pivot[i] - 1) * m, (size_t)m * sizeof *S);
    if (ric_lapack(LAPACKE_dormqr(LAPACK_ROW_MAJOR, 'R', 'N', m, m, m, R, m, tau, S, m)))
        return false;
    memset(A, 0, (size_t)(m * m) * sizeof *A);
    for (int i = 0; i < m; i++)
        for (int l = i; l < m; l++)
            for (int j = 0; j < m; j++) A[i * m + j] += R[i * m + l] * S[l * m + j];
    if (!ric_eigen(m, A, mu)) return false;
    qsort(mu, (size_t)m, 2 * sizeof *mu, by_value);
    return true;
}

bool ric_eigen_product(int m, const double *B, const double *C, double rounding, double *H,
                       double *mu, double *error)
{
    double moved[2 * m];
    if (!moved_product(m, B, C, (move_t){0}, H, mu)) return false;
    memset(error, 0, (size_t)m * sizeof *error);
    for (unsigned way = 1; way <= MOVES; way++) {
        if (!moved_product(m, B, C, (move_t){rounding, way}, H, moved)) return false;
        for (int i = 0; i < m; i++)
            error[i] = fmax(error[i], MEASURED * hypot(moved[2 * i] - mu[2 * i],
                                                       moved[2 * i + 1] - mu[2 * i + 1]));
    }
    for (int i = 0; i < m; i++) error[i] += 2 * DBL_EPSILON * hypot(mu[2 * i], mu[2 * i + 1]);
    return true;
}
