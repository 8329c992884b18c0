#include "mixture_way.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "base/room.h"
#include "model/room.h"

/* RISES: speed per unit of a kernel vector that counts as none: differences leave 1e-10 */
#define RISES 1e-6

/* Change of the speed of every impact along every kernel vector, A [impacts * k]; returns the
 * number of impacts. */
static int rates_of(ric_shooting *c, const double *u, int k, const double *kernel, double *A)
{
    int size = c->n_unknown, impacts = 0;
    double v[size], h = RIC_DIFFERENCE * c->scale;
    memset(A, 0, (size_t)(c->n_flight + 1) * (size_t)k * sizeof *A);
    for (int j = 0; j < k; j++)
        for (int side = -1; side <= 1; side += 2) {
            for (int i = 0; i < size; i++) v[i] = u[i] + side * h * kernel[j * size + i];
            ric_shooting_fly(c, v);
            impacts = 0;
            for (int i = c->start == RIC_MIRROR_IMPACT ? 0 : 1; i <= c->n_flight; i++)
                if (c->face[i] >= 0) A[impacts++ * k + j] += side * c->approach[i] / (2 * h);
        }
    return impacts;
}

/* Whether some combination of the first two columns of U [impacts * impacts] leaves no entry below
 * zero but for rounding: half planes that the entries allow, of which the borders are tried. */
static bool rises_together(int impacts, const double *U)
{
    for (int i = 0; i < impacts; i++)
        for (int side = -1; side <= 1; side += 2) {
            double x = -side * U[i * impacts + 1], y = side * U[i * impacts], least = 0,
                   size = hypot(x, y);
            for (int j = 0; j < impacts; j++)
                least = fmin(least, x * U[j * impacts] + y * U[j * impacts + 1]);
            if (size > RISES && least > -RISES * size) return true;
        }
    return false;
}

/* The same of one column, of either sign. */
static bool rises_alone(int impacts, const double *U)
{
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (int i = 0; i < impacts; i++) {
        least = fmin(least, U[i * impacts]);
        most = fmax(most, U[i * impacts]);
    }
    return least > -RISES || most < RISES;
}

/* The part of the kernel [k * size] that is perpendicular to all vectors along which no speed
 * changes. */
static ric_status rising(ric_shooting *c, const double *u, int k, const double *kernel, double *t,
                         int *count)
{
    int size = c->n_unknown, most = c->n_flight + 1;
    double *W = ric_calloc((size_t)k * (size_t)k, sizeof *W),
           *A = ric_calloc((size_t)(most * k), sizeof *A),
           *U = ric_calloc((size_t)most * (size_t)most, sizeof *U);
    ric_status status = W && A && U ? RIC_OK : ric_no_memory("a departure");
    if (!status) {
        double s[most + k], super[most + k];
        int impacts = rates_of(c, u, k, kernel, A), rank = impacts < k ? impacts : k;
        if (ric_lapack(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'A', 'A', impacts, k, A, k, s, U, impacts,
                                      W, k, super)))
            status = ric_fail(RIC_E_NUMERIC, "the kernel at the grazing could not be taken apart");
        while (!status && *count < rank && s[*count] > RISES) ++*count;
        if (!status && ((*count == 1 && !rises_alone(impacts, U)) ||
                        (*count == 2 && !rises_together(impacts, U))))
            *count = 0;
        for (int j = 0; j < k; j++)
            for (int i = 0; i < size; i++) t[i] += W[j] * kernel[j * size + i];
    }
    free(W);
    free(A);
    free(U);
    return status;
}

ric_status ric_mixture_way(ric_shooting *c, const double *u, double *t, int *count)
{
    ric_singular q;
    *count = 0;
    memset(t, 0, (size_t)c->n_unknown * sizeof *t);
    ric_status status = ric_singular_create(c, false, &q);
    if (status) return status;
    if (ric_singular_factor(&q, u)) {
        int k = q.unknowns - ric_singular_rank(&q, RIC_RANK);
        status = rising(c, u, k, ric_singular_kernel(&q, k), t, count);
    } else status = ric_fail(RIC_E_NUMERIC, "the kernel at the grazing could not be found");
    ric_singular_free(&q);
    return status;
}
