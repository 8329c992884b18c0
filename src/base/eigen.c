#include "eigen.h"
#include "memory.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#define MOVES 3      /* by which an error is measured: a single one may lie across */
#define MEASURED 4.0 /* its margin */
#define FAR 300      /* powers of two from which on entries are scaled */

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

/* Conditions of the eigenvalues of a Schur form T. vectors [2 k^2] is workspace. */
static bool conditions_of(int k, const double *T, double *vectors, double *condition)
{
    double *left = vectors, *right = vectors + (size_t)k * (size_t)k, apart[k + 1];
    lapack_int count;
    if (ric_lapack(LAPACKE_dtrevc(LAPACK_COL_MAJOR, 'B', 'A', NULL, k, T, k, left, k, right, k, k,
                                  &count)) ||
        ric_lapack(LAPACKE_dtrsna(LAPACK_COL_MAJOR, 'E', 'A', NULL, k, T, k, left, k, right, k,
                                  condition, apart, k, &count)))
        return false;
    for (int i = 0; i < k; i++) condition[i] = 1 / condition[i];
    return true;
}

/* T = ldexp(A, -*exponent), which is zero but for entries whose products are no numbers. False: one
 * of A is none. */
static bool scaled(size_t count, const double *A, double *T, int *exponent)
{
    double most = 0;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(A[i])) return false;
        most = fmax(most, fabs(A[i]));
    }
    frexp(most, exponent);
    if (abs(*exponent) < FAR) *exponent = 0;
    for (size_t i = 0; i < count; i++) T[i] = *exponent ? ldexp(A[i], -*exponent) : A[i];
    return true;
}

bool ric_eigen_conditions(int k, const double *A, double *out, double *condition)
{
    const size_t kk = (size_t)k * (size_t)k;
    double re[k + 1], im[k + 1], tau[k + 1], *T = ric_calloc(3 * kk + 1, sizeof *T);
    int exponent;
    /* read by columns it is the transpose, whose eigenvalues and conditions are the same */
    bool found = T && scaled(kk, A, T, &exponent) &&
                 !ric_lapack(LAPACKE_dgehrd(LAPACK_COL_MAJOR, k, 1, k, T, k, tau));
    for (int j = 0; j < k && found; j++)
        for (int i = j + 2; i < k; i++) T[j * k + i] = 0;
    found = found &&
            !ric_lapack(
                LAPACKE_dhseqr(LAPACK_COL_MAJOR, 'S', 'N', k, 1, k, T, k, re, im, NULL, 1)) &&
            conditions_of(k, T, T + kk, condition);
    for (int i = 0; i < k && found; i++) {
        out[2 * i] = exponent ? ldexp(re[i], exponent) : re[i];
        out[2 * i + 1] = exponent ? ldexp(im[i], exponent) : im[i];
    }
    free(T);
    return found;
}

static double square_of(size_t count, const double *A)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) sum += A[i] * A[i];
    return sum;
}

bool ric_eigen_balanced(int k, const double *A, double *work)
{
    const size_t kk = (size_t)k * (size_t)k;
    const double square = square_of(kk, A);
    double scale[k + 1];
    lapack_int low, high;
    if (!isfinite(square)) return false;
    memcpy(work, A, kk * sizeof *A);
    /* read by columns it is the transpose, whose balanced form is that of A, transposed */
    if (ric_lapack(LAPACKE_dgebal(LAPACK_COL_MAJOR, 'S', k, work, k, &low, &high, scale)))
        return false;
    return square <= 4 * square_of(kk, work);
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
