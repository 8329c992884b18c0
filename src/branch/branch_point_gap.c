#include "branch_point_gap.h"

#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "base/room.h"

#define GAP_STEPS 3 /* Newton steps towards a crossing: they converge quadratically from 1e-3 */
#define LEFT 1e-3   /* distance, relative, from a crossing at which another one is looked at */

/* Newton's method in the range of the Jacobian without its smallest singular values, of which two are those of the
 * kernel: the right hand side that remains is the reduced equation of Lyapunov and Schmidt at its saddle, up to the
 * square of the distance from it. */
double ric_branch_point_gap(ric_shooting *c, const double *u)
{
    size_t n = (size_t)c->n_unknown, rows = (size_t)ric_shooting_rows(c);
    int rank = c->n_unknown - 2, unknowns = c->n_unknown, equations = 0;
    if (unknowns > RIC_DENSE_MOST) return 0;
    double *memory = ric_calloc(rows * n + rows * rows + n * n + 3 * rows + 2 * n, sizeof *memory), gap = NAN,
           moved = 0;
    if (!memory || rank < 1) goto out;
    double *J = memory, *U = J + rows * n, *V = U + rows * rows, *r = V + n * n, *s = r + rows, *super = s + rows,
           *v = super + rows;
    memcpy(v, u, n * sizeof *v);
    for (int i = 0; i <= GAP_STEPS; i++) {
        equations = ric_shooting_jacobian(c, v, J);
        ric_shooting_residuals(c, v, r);
        if (!equations) goto out;
        if (ric_lapack(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'A', 'A', equations, unknowns, J, unknowns, s, U, equations, V,
                                      unknowns, super)))
            goto out;
        gap = 0;
        for (int k = 0; k < equations; k++) {
            double part = 0;
            for (int j = 0; j < equations; j++) part += U[j * equations + k] * r[j];
            if (k >= rank) gap = hypot(gap, part);
            for (int j = 0; k < rank && j < unknowns; j++) v[j] -= part / s[k] * V[k * unknowns + j];
        }
    }
    gap /= c->scale;
    for (size_t j = 0; j < n; j++) moved = fmax(moved, fabs(v[j] - u[j]));
    bool singular = rank == 1 || s[rank] < RIC_RANK_GAP * s[rank - 1];
    if (!singular || !(moved < LEFT * c->scale)) gap = NAN;
out:
    free(memory);
    return gap;
}
