/* Whether damping and force fit a structure. */
#include "losses.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define SYMMETRIC                                                                                  \
    1e-8              /* of the largest entry: a damping matrix that is printed with nine digits   \
                       */
#define NEGATIVE 1e-9 /* relative to the largest: an eigenvalue that rounding makes of zero */

ric_status ric_losses_check_force(int n, int n_force, const double *force)
{
    double largest = 0;
    if (n_force != n)
        return ric_fail(
            RIC_E_INPUT,
            "the force has %d number%s, but the structure has %d displacement%s; give one number "
            "for each",
            n_force, n_force == 1 ? "" : "s", n, n == 1 ? "" : "s");
    for (int i = 0; i < n_force; i++) {
        if (!isfinite(force[i]))
            return ric_fail(RIC_E_INPUT, "number %d of the force is not finite", i + 1);
        largest = fmax(largest, fabs(force[i]));
    }
    if (!(largest > 0))
        return ric_fail(RIC_E_INPUT,
                        "the force is zero; name the displacements that it acts on, 1,0");
    return RIC_OK;
}

ric_status ric_losses_check_ratios(int n, int n_ratio, const double *ratios)
{
    if (n_ratio != 1 && n_ratio != n)
        return ric_fail(
            RIC_E_INPUT,
            "%d damping ratios, but the structure has %d modes; give one for all, or one for each",
            n_ratio, n);
    for (int i = 0; i < n_ratio; i++)
        if (!(ratios[i] >= 0 && isfinite(ratios[i])))
            return ric_fail(RIC_E_INPUT,
                            "damping ratio %.10g of mode %d is negative; it is 0 or more",
                            ratios[i], i + 1);
    return RIC_OK;
}

ric_status ric_losses_check_matrix(int n, int n_matrix, const double *C)
{
    if (n_matrix != n)
        return ric_fail(RIC_E_INPUT,
                        "the damping matrix has %d rows, but the structure has %d displacements",
                        n_matrix, n);
    double largest = 0, values[n], *A = ric_malloc((size_t)n * (size_t)n * sizeof *A);
    if (!A) return ric_no_memory("a damping matrix");
    memcpy(A, C, (size_t)n * (size_t)n * sizeof *A);
    for (int i = 0; i < n * n; i++) largest = fmax(largest, isfinite(C[i]) ? fabs(C[i]) : INFINITY);
    ric_status status = RIC_OK;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++)
            if (!(fabs(C[i * n + j] - C[j * n + i]) <= SYMMETRIC * largest) && !status)
                status =
                    ric_fail(RIC_E_INPUT,
                             "the damping matrix is not symmetric: row %d, column %d is %.17g but "
                             "row %d, column %d is %.17g; make them equal",
                             i + 1, j + 1, C[i * n + j], j + 1, i + 1, C[j * n + i]);
    if (!status && !isfinite(largest))
        status = ric_fail(RIC_E_INPUT, "the damping matrix is not finite");
    if (!status && ric_lapack(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'U', n, A, n, values)))
        status = ric_fail(RIC_E_NUMERIC,
                          "the eigenvalues of the damping matrix cannot be computed");
    if (!status && values[0] < -NEGATIVE * largest)
        status = ric_fail(
            RIC_E_INPUT,
            "the damping is negative: the matrix has the eigenvalue %.10g; a damping matrix "
            "has none below 0",
            values[0]);
    free(A);
    return status;
}
