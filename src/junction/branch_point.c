#include "branch_point.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "flow/room.h"
#include "base/room.h"

/* DISTINCT: smallest sine of the angle between two directions that can be told apart at the first
 * step, 1e-3 of the orbit */
#define DISTINCT 1e-3
#define NEIGHBOUR 0.1 /* an orbit farther away, relative, is no neighbour */
#define BENT 1e-6 /* of the largest singular value, over the size: less is no second derivative */
#define STEPS 8   /* to the place, quadratic ones from 1e-7 */
#define ROUNDED 1e-14 /* of the size: a shorter step is rounding */
#define LEFT 1e-12    /* the same: one that is longer at last has not come there */

typedef struct {
    ric_shooting *chain;
    double *u0;
    ric_singular at;  /* the orbit problem at u0 */
    double way[2][2]; /* directions in the kernel: THROUGH, SIDE */
} crossing;

static void crossing_free(crossing *q)
{
    ric_singular_free(&q->at);
    ric_shooting_free(q->chain);
    free(q->u0);
}

/* The general form has as many equations as unknowns, one redundant; the others one fewer. */
static ric_status open_kernel(const ric_model *m, const ric_node *node, crossing *q)
{
    *q = (crossing){0};
    ric_status status = ric_periodic_to_chain(m, node->cycle, &q->chain, &q->u0);
    if (!status) status = ric_singular_create(q->chain, true, &q->at);
    if (status) return status;
    ric_shooting_fly(q->chain, q->u0);
    bool found = ric_singular_factor(&q->at, q->u0) && ric_singular_opens(&q->at, 2),
         whole = q->chain->start == RIC_MIRROR_NONE;
    if (found && q->at.equations == (whole ? q->at.unknowns : q->at.unknowns - 1)) return RIC_OK;
    return ric_fail(RIC_E_NUMERIC, "the kernel at the branch point has not two dimensions");
}

/* The left null vector that is not the redundant equation's: of two the one perpendicular to it. */
static void left_vector(const crossing *q, double *left)
{
    int equations = q->at.equations;
    double both[2 * equations], redundant[equations];
    if (ric_singular_cokernel(&q->at, 2, both) == 1) {
        memcpy(left, both, sizeof redundant);
        return;
    }
    ric_singular_redundant(&q->at, redundant);
    double x = ric_dot(equations, both, redundant),
           y = ric_dot(equations, both + equations, redundant);
    for (int i = 0; i < equations; i++)
        left[i] = (y * both[i] - x * both[equations + i]) / hypot(x, y);
}

/* The direction (x, y) of the kernel, out [unknowns]. */
static void along(const crossing *q, const double way[2], double *out)
{
    int n = q->at.unknowns;
    const double *kernel = ric_singular_kernel(&q->at, 2);
    for (int i = 0; i < n; i++) out[i] = way[0] * kernel[i] + way[1] * kernel[n + i];
}

/* The algebraic branching equation: the second derivative of the equations along the left null
 * vector, Q = (11, 12; 21, 22) on the kernel, vanishes along both branches (H. B. Keller, in:
 * Applications of Bifurcation Theory, 1977). */
static ric_status directions(crossing *q)
{
    int n = q->at.unknowns;
    const double *kernel = ric_singular_kernel(&q->at, 2);
    double left[q->at.equations], Q[2][2], slope[2], t[n];
    left_vector(q, left);
    for (int i = 0; i < 2; i++)
        if (!ric_singular_bend(&q->at, q->u0, kernel + i * n, 1, left, 2, kernel, Q[i]))
            return ric_no_memory("a departure");
    double a = Q[0][0], b = (Q[0][1] + Q[1][0]) / 2, d = Q[1][1], root = b * b - a * d,
           size = hypot(a - d, 2 * b) + fabs(a + d);
    if (!(root > 0))
        return ric_fail(
            RIC_E_NUMERIC,
            "no two branches cross at the branch point: the branching equation has no real roots");
    root = sqrt(root);
    /* a x^2 + 2 b x y + d y^2 = 0, without cancellation */
    double p = -(b + copysign(root, b));
    double x[2][2] = {{p, a}, {d, p}};
    ric_shooting_fly(q->chain, q->u0);
    for (int k = 0; k < 2; k++) {
        double norm = hypot(x[k][0], x[k][1]);
        if (!(norm > RIC_RANK * size))
            return ric_fail(RIC_E_NUMERIC,
                            "the branching equation at the branch point is degenerate");
        for (int j = 0; j < 2; j++) x[k][j] /= norm;
        along(q, x[k], t);
        slope[k] = fabs(ric_shooting_energy_slope(q->chain, t));
    }
    if (fabs(x[0][0] * x[1][1] - x[0][1] * x[1][0]) < DISTINCT)
        return ric_fail(RIC_E_NUMERIC, "the branches that cross at the branch point touch: their "
                                       "directions cannot be told apart");
    int through = slope[1] > slope[0];
    memcpy(q->way[0], x[through], sizeof x[0]);
    memcpy(q->way[1], x[!through], sizeof x[0]);
    return RIC_OK;
}

/* One step towards the place, v [unknowns], and its length in the kernel. */
static bool approach(crossing *q, double *v, double *step)
{
    int n = q->at.unknowns;
    double r[ric_shooting_rows(q->chain)], Q[2][2], g[2] = {0, 0};
    ric_shooting_fly(q->chain, v);
    if (!ric_singular_factor(&q->at, v) || !ric_singular_opens(&q->at, 2)) return false;
    const double *kernel = ric_singular_kernel(&q->at, 2);
    double left[q->at.equations], both[2 * q->at.equations];
    left_vector(q, left);
    ric_shooting_residuals(q->chain, v, r);
    for (int i = 0, count = ric_singular_cokernel(&q->at, 2, both); i < count; i++)
        g[i] = q->at.values[n - 2 + i] * ric_dot(q->at.equations, left, both + i * q->at.equations);
    for (int i = 0; i < 2; i++)
        if (!ric_singular_bend(&q->at, v, kernel + i * n, 1, left, 2, kernel, Q[i])) return false;
    double a = Q[0][0], b = (Q[0][1] + Q[1][0]) / 2, d = Q[1][1], det = a * d - b * b;
    /* a saddle, or no two branches cross; and more than the rounding of differences */
    double size = hypot(hypot(a, d), M_SQRT2 * b);
    if (!(-det > RIC_RANK * size * size && size > BENT * q->at.values[0] / q->chain->scale))
        return false;
    double x = (b * g[1] - d * g[0]) / det, y = (b * g[0] - a * g[1]) / det;
    ric_singular_step(&q->at, n - 2, r, v);
    for (int i = 0; i < n; i++) v[i] += x * kernel[i] + y * kernel[n + i];
    *step = hypot(x, y);
    return true;
}

bool ric_branch_point_place(ric_shooting *c, double *u)
{
    crossing q = {.chain = c};
    int n = c->n_unknown;
    double v[n], step = HUGE_VAL, moved = 0;
    if (ric_singular_create(c, true, &q.at)) return false;
    memcpy(v, u, sizeof v);
    bool good = true;
    for (int i = 0; i < STEPS && good && step > ROUNDED * c->scale; i++)
        good = approach(&q, v, &step);
    good = good && step <= LEFT * c->scale;
    for (int i = 0; i < n; i++) moved = fmax(moved, fabs(v[i] - u[i]));
    if (good) ric_shooting_fly(c, v);
    good = good && c->residual <= ric_continuation_tolerance(c) &&
           moved <= RIC_SAME_LOCATED * c->scale;
    if (good) memcpy(u, v, sizeof v);
    ric_singular_free(&q.at);
    return good;
}

static ric_status solve(const ric_model *m, const ric_node *node, crossing *q)
{
    ric_status status = open_kernel(m, node, q);
    if (!status) status = directions(q);
    if (status) crossing_free(q);
    return status;
}

ric_status ric_branch_point_depart(const ric_model *m, const ric_node *node, unsigned choice,
                                   ric_outset *out)
{
    crossing q;
    ric_status status = solve(m, node, &q);
    if (status) return status;
    if ((out->t = ric_malloc((size_t)q.at.unknowns * sizeof *out->t))) {
        along(&q, q.way[choice != RIC_THROUGH], out->t);
        ric_singular_orient(q.at.unknowns, out->t);
        out->chain = q.chain;
        out->u = q.u0;
        q.chain = NULL;
        q.u0 = NULL;
    } else status = ric_no_memory("a departure");
    crossing_free(&q);
    return status;
}

ric_status ric_branch_point_choice(const ric_model *m, const ric_node *node,
                                   const ric_periodic *near, unsigned *choice)
{
    crossing q;
    ric_shooting *chain = NULL;
    double *u = NULL, x = 0, y = 0;
    ric_status status = solve(m, node, &q);
    if (status) return status;
    ric_periodic *home = ric_periodic_nearest(m, node->cycle, near, NEIGHBOUR);
    if (!home) status = ric_fail(RIC_E_NUMERIC, "the orbit does not lie beside the branch point");
    if (!status && !(status = ric_periodic_to_chain(m, home, &chain, &u)) &&
        chain->n_unknown != q.at.unknowns)
        status = ric_fail(RIC_E_NUMERIC, "the orbit has not the symmetry of the branch point");
    const double *kernel = ric_singular_kernel(&q.at, 2);
    for (int i = 0; !status && i < q.at.unknowns; i++) {
        x += kernel[i] * (u[i] - q.u0[i]);
        y += kernel[q.at.unknowns + i] * (u[i] - q.u0[i]);
    }
    double across[2] = {fabs(x * q.way[0][1] - y * q.way[0][0]),
                        fabs(x * q.way[1][1] - y * q.way[1][0])};
    *choice = across[1] < across[0] ? RIC_SIDE : RIC_THROUGH;
    ric_shooting_free(chain);
    ric_periodic_free(home);
    free(u);
    crossing_free(&q);
    return status;
}
