#include "branch_point_gap.h"

#include <math.h>
#include <string.h>

#include "base/room.h"

#define GAP_STEPS 3 /* Newton steps towards a crossing: they converge quadratically from 1e-3 */
#define LEFT 1e-3   /* distance, relative, from a crossing at which another one is looked at */

/* Newton's method in the range of the Jacobian without its smallest singular values, of which two
 * are those of the kernel: the right hand side that remains is the reduced equation of Lyapunov and
 * Schmidt at its saddle, up to the square of the distance from it. */
double ric_branch_point_gap(ric_shooting *c, const double *u)
{
    int n = c->n_unknown, rank = n - 2;
    double r[ric_shooting_rows(c)], v[n], gap = NAN, moved = 0;
    ric_singular q;
    if (n > RIC_DENSE_MOST) return 0;
    if (rank < 1 || ric_singular_create(c, true, &q)) return NAN;
    memcpy(v, u, sizeof v);
    for (int i = 0; i <= GAP_STEPS; i++) {
        if (!ric_singular_factor(&q, v)) goto out;
        ric_shooting_residuals(c, v, r);
        gap = ric_singular_step(&q, rank, r, v) / c->scale;
    }
    for (int j = 0; j < n; j++) moved = fmax(moved, fabs(v[j] - u[j]));
    bool singular = rank == 1 || q.values[rank] < RIC_RANK_GAP * q.values[rank - 1];
    if (!singular || !(moved < LEFT * c->scale)) gap = NAN;
out:
    ric_singular_free(&q);
    return gap;
}
