#include "branch_point.h"

#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "flow/room.h"
#include "base/room.h"

/* DISTINCT: smallest sine of the angle between two directions that can be told apart at the first step, 1e-3 of the
 * orbit */
#define DISTINCT 1e-3
#define NEIGHBOUR 0.1 /* an orbit farther away, relative, is no neighbour */

typedef struct {
    ric_shooting *chain;
    int size;
    double *u0;
    double *kernel;    /* [2 * size] */
    double *left;      /* [size] left null vector that is not the redundant equation's */
    double *J, *U, *V; /* [size^2 each] */
    double way[2][2];  /* directions in the kernel: THROUGH, SIDE */
    double *memory;
} crossing;

static void crossing_free(crossing *q)
{
    ric_shooting_free(q->chain);
    free(q->u0);
    free(q->memory);
}

static ric_status crossing_create(const ric_model *m, const ric_node *node, crossing *q)
{
    *q = (crossing){0};
    ric_status status = ric_periodic_to_chain(m, node->cycle, &q->chain, &q->u0);
    if (status) return status;
    /* the general form has as many equations as unknowns, one redundant; the others one fewer */
    size_t n = (size_t)q->chain->n_unknown;
    q->size = (int)n;
    if (!(q->memory = ric_calloc(3 * n + 3 * n * n, sizeof *q->memory))) return ric_no_memory("a departure");
    q->kernel = q->memory;
    q->left = q->kernel + 2 * n;
    q->J = q->left + n;
    q->U = q->J + n * n;
    q->V = q->U + n * n;
    return RIC_OK;
}

/* Kernel and the left null vector: in the general form that one of two which is perpendicular to the mean gradient of
 * the energy (section 3). */
static ric_status kernels(crossing *q)
{
    ric_shooting *c = q->chain;
    int n = q->size, equations, rank = n - 2, first = n - 2 * c->n;
    double s[n], super[n], part[2] = {1, 0};
    bool whole = c->start == RIC_MIRROR_NONE;
    ric_shooting_fly(c, q->u0);
    equations = ric_shooting_jacobian(c, q->u0, q->J);
    if (n < 3 || equations != (whole ? n : n - 1) ||
        ric_lapack(
            LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'A', 'A', equations, n, q->J, n, s, q->U, equations, q->V, n, super)) ||
        s[rank] > RIC_RANK * s[0] || s[rank] > RIC_RANK_GAP * s[rank - 1])
        return ric_fail(RIC_E_NUMERIC, "the kernel at the branch point has not two dimensions");
    memcpy(q->kernel, q->V + (size_t)rank * (size_t)n, 2 * (size_t)n * sizeof *q->kernel);
    if (whole) {
        double from[2 * c->n], gradient[2 * c->n], h[2] = {0};
        for (int i = 0; i < 2 * c->n; i++) from[i] = c->sigma * c->w[i];
        ric_flight_secant(c->model, c->closed[c->n_flight], from, c->w + 2 * c->n * c->n_flight, gradient);
        for (int i = 0; i < 2 * c->n; i++)
            for (int j = 0; j < 2; j++) h[j] += gradient[i] * q->U[(first + i) * n + rank + j];
        part[0] = h[1] / hypot(h[0], h[1]);
        part[1] = -h[0] / hypot(h[0], h[1]);
    }
    for (int i = 0; i < equations; i++)
        q->left[i] = part[0] * q->U[i * equations + rank] + (whole ? part[1] * q->U[i * equations + rank + 1] : 0);
    return RIC_OK;
}

/* The algebraic branching equation: the second derivative of the equations along the left null vector, Q [3] =
 * (11, 12, 22) on the kernel, vanishes along both branches (H. B. Keller, in: Applications of Bifurcation Theory,
 * 1977). */
static ric_status directions(crossing *q)
{
    ric_shooting *c = q->chain;
    int n = q->size;
    double h = RIC_DIFFERENCE * c->scale, Q[2][2] = {{0}}, u[n], slope[2], t[n];
    for (int i = 0; i < 2; i++)
        for (int side = -1; side <= 1; side += 2) {
            for (int j = 0; j < n; j++) u[j] = q->u0[j] + side * h * q->kernel[i * n + j];
            ric_shooting_fly(c, u);
            int equations = ric_shooting_jacobian(c, u, q->J);
            for (int k = 0; k < 2; k++)
                for (int e = 0; e < equations; e++)
                    Q[i][k] += side * q->left[e] * ric_dot(n, q->J + e * n, q->kernel + k * n) / (2 * h);
        }
    double a = Q[0][0], b = (Q[0][1] + Q[1][0]) / 2, d = Q[1][1], root = b * b - a * d,
           size = hypot(a - d, 2 * b) + fabs(a + d);
    if (!(root > 0))
        return ric_fail(RIC_E_NUMERIC,
                        "no two branches cross at the branch point: the branching equation has no real roots");
    root = sqrt(root);
    /* a x^2 + 2 b x y + d y^2 = 0, without cancellation */
    double p = -(b + copysign(root, b));
    double x[2][2] = {{p, a}, {d, p}};
    ric_shooting_fly(c, q->u0);
    for (int k = 0; k < 2; k++) {
        double norm = hypot(x[k][0], x[k][1]);
        if (!(norm > RIC_RANK * size))
            return ric_fail(RIC_E_NUMERIC, "the branching equation at the branch point is degenerate");
        for (int j = 0; j < 2; j++) x[k][j] /= norm;
        for (int j = 0; j < n; j++) t[j] = x[k][0] * q->kernel[j] + x[k][1] * q->kernel[n + j];
        slope[k] = fabs(ric_shooting_energy_slope(c, t));
    }
    if (fabs(x[0][0] * x[1][1] - x[0][1] * x[1][0]) < DISTINCT)
        return ric_fail(RIC_E_NUMERIC,
                        "the branches that cross at the branch point touch: their directions cannot be told apart");
    int through = slope[1] > slope[0];
    memcpy(q->way[0], x[through], sizeof x[0]);
    memcpy(q->way[1], x[!through], sizeof x[0]);
    return RIC_OK;
}

static ric_status solve(const ric_model *m, const ric_node *node, crossing *q)
{
    ric_status status = crossing_create(m, node, q);
    if (!status) status = kernels(q);
    if (!status) status = directions(q);
    if (status) crossing_free(q);
    return status;
}

ric_status ric_branch_point_depart(const ric_model *m, const ric_node *node, unsigned choice, ric_shooting **chain,
                                   double **u0, double **t0)
{
    crossing q;
    int largest = 0;
    ric_status status = solve(m, node, &q);
    if (status) return status;
    int n = q.size;
    const double *way = q.way[choice != RIC_THROUGH];
    if (!(*t0 = ric_malloc((size_t)n * sizeof **t0))) {
        crossing_free(&q);
        return ric_no_memory("a departure");
    }
    for (int i = 0; i < n; i++) (*t0)[i] = way[0] * q.kernel[i] + way[1] * q.kernel[n + i];
    for (int i = 1; i < n; i++)
        if (fabs((*t0)[i]) > fabs((*t0)[largest]) * (1 + RIC_TIE_IN_KERNEL)) largest = i;
    double sign = (*t0)[largest] < 0 ? -1 : 1;
    for (int i = 0; i < n; i++) (*t0)[i] *= sign;
    *chain = q.chain;
    *u0 = q.u0;
    q.chain = NULL;
    q.u0 = NULL;
    crossing_free(&q);
    return RIC_OK;
}

ric_status ric_branch_point_choice(const ric_model *m, const ric_node *node, const ric_periodic *near, unsigned *choice)
{
    crossing q;
    ric_shooting *chain = NULL;
    double *u = NULL, x = 0, y = 0;
    ric_status status = solve(m, node, &q);
    if (status) return status;
    ric_periodic *home = ric_periodic_nearest(m, node->cycle, near, NEIGHBOUR);
    if (!home) status = ric_fail(RIC_E_NUMERIC, "the orbit does not lie beside the branch point");
    if (!status && !(status = ric_periodic_to_chain(m, home, &chain, &u)) && chain->n_unknown != q.size)
        status = ric_fail(RIC_E_NUMERIC, "the orbit has not the symmetry of the branch point");
    for (int i = 0; !status && i < q.size; i++) {
        x += q.kernel[i] * (u[i] - q.u0[i]);
        y += q.kernel[q.size + i] * (u[i] - q.u0[i]);
    }
    double across[2] = {fabs(x * q.way[0][1] - y * q.way[0][0]), fabs(x * q.way[1][1] - y * q.way[1][0])};
    *choice = across[1] < across[0] ? RIC_SIDE : RIC_THROUGH;
    ric_shooting_free(chain);
    ric_periodic_free(home);
    free(u);
    crossing_free(&q);
    return status;
}
