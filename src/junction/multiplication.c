#include "multiplication.h"

#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "model/room.h"
#include "orbit/room.h"
#include "base/room.h"

#define TURNS 1e-4 /* the shift, from such differences, is a rotation of its order within this */
/* RADIUS: first radius, relative to the size of the orbit: nearer by, dE/ds and others are rounding
 * (continuation.c) */
#define RADIUS 1e-3
/* RADII: doublings or halvings of it: to a quarter of the orbit, and to where the angle of order 3
 * is rounding */
#define RADII 8
/* BEND: largest angle between chord and curve, rad: farther along, the parabola s ~ h^2 has left
 * the node behind */
#define BEND 1.0
/* CLEAR: the angular equation must stand out of rounding by this factor: its roots then keep three
 * digits */
#define CLEAR 1e3
#define SAMPLES 12 /* of a sector, which holds one period of a sine */
#define NEWTON_STEPS 12
/* STALLED: of the tolerance: what is left where Newton's method stalls, as on branches
 * (continuation.c) */
#define STALLED 4
/* NEIGHBOUR: an orbit farther away than the widest circle is no neighbour of the node */
#define NEIGHBOUR 0.25

typedef struct {
    ric_shooting *chain;
    int size, order;
    int sign; /* of the state after one period of the map: -1 where the map is over half a period of
                 an S orbit */
    double *memory;
    double *u0;      /* [size] the orbit gone through r times */
    double *tangent; /* [size] T, of the branch that is repeated */
    double *plane;  /* [2 * size] conjugate radii of the ellipse on which the shift is a rotation */
    double *dual;   /* [2 * size] z_i = dual_i . (u - u0) */
    double *left;   /* [2 * size] left null vectors that are not the energy's */
    double *energy; /* [size] left null vector of the redundant equation */
    double *A, *b;  /* [(size + 2)^2], [size + 2] */
    ric_singular at; /* the orbit problem at u0 */
    double M[4];     /* d^2(left . equations) / ds dz */
    double radius;
    double
        angle[2]; /* the two roots of the first sector, in the order of ric_multiplication_depart */
    double *start; /* [2 * size] orbits there */
} ring;

bool ric_multiplication_applies(const ric_node *node, unsigned choice)
{
    const ric_periodic *c = node->cycle;
    return node->kind == RIC_KIND_MULTIPLICATION && choice != RIC_THROUGH && c->pure < 0 &&
           c->flip < 0 && ric_symmetry_order(c, node->rotation[0], node->rotation[1]) > 2;
}

static void ring_free(ring *q)
{
    ric_singular_free(&q->at);
    ric_shooting_free(q->chain);
    free(q->memory);
}

static ric_status ring_create(const ric_model *m, const ric_node *node, ring *q)
{
    *q = (ring){.order = ric_symmetry_order(node->cycle, node->rotation[0], node->rotation[1]),
                .sign = node->cycle->half ? -1 : 1};
    ric_symmetry problem = ric_node_problem(node, RIC_SIDE);
    ric_periodic *cycle = ric_symmetry_cycle(node->cycle, &problem);
    double *u = NULL;
    ric_status status = cycle ? ric_periodic_to_chain(m, cycle, &q->chain, &u)
                              : ric_no_memory("a departure");
    ric_periodic_free(cycle);
    if (status) return status;
    size_t n = (size_t)q->chain->n_unknown, k = n + 2;
    if ((q->memory = ric_calloc(11 * n + k * k + k, sizeof *q->memory))) {
        double **const parts[] = {&q->u0,     &q->tangent, &q->plane, &q->dual, &q->left,
                                  &q->energy, &q->start,   &q->A,     &q->b};
        const size_t sizes[] = {n, n, 2 * n, 2 * n, 2 * n, n, 2 * n, k * k, k};
        double *next = q->memory;
        for (int i = 0; i < 9; next += sizes[i++]) *parts[i] = next;
        memcpy(q->u0, u, n * sizeof *u);
    } else status = ric_no_memory("a departure");
    q->size = (int)n;
    free(u);
    return status;
}

/* -------------------------------------------------------------------- kernel */

/* shift, below, under a power law: one flight for all periods. What the image has along the flow,
 * to which the kernel is perpendicular at the start, is taken away: inner nodes would show it. */
static ric_status shift_smooth(ring *q, const double *v, double *out)
{
    const ric_model *m = q->chain->model;
    int n = 2 * m->n;
    double after[n], rate[n], *map = ric_malloc((size_t)n * (size_t)n * sizeof *map);
    if (!map) return ric_no_memory("the map of a period");
    ric_flight_map(m, 0, -1, q->u0[n] / q->order, q->u0, map, after, rate);
    for (int i = 0; i < n; i++) out[i] = q->sign * ric_dot(n, map + i * n, v);
    double along = q->sign * ric_dot(n, rate, out) / ric_dot(n, rate, rate);
    for (int i = 0; i < n; i++) out[i] -= q->sign * along * rate[i];
    out[n] = v[n];
    ric_shooting_fly(q->chain, q->u0);
    ric_shooting_nodes_along(q->chain, out);
    free(map);
    return RIC_OK;
}

/* Where the shift by one period of the map takes the direction v: the state after n_flight / r
 * flights, and the times moved up. */
static ric_status shift(ring *q, const double *v, double *out)
{
    ric_shooting *c = q->chain;
    int n = 2 * c->n, step = c->n_flight / q->order;
    double u[q->size], after[n], h = RIC_DIFFERENCE * c->scale;
    if (!ric_periodic_has_events(c->model)) return shift_smooth(q, v, out);
    for (int i = 0; i < q->size; i++) u[i] = q->u0[i] + h * v[i];
    ric_shooting_fly(c, u);
    memcpy(after, c->w + n * step, sizeof after);
    for (int i = 0; i < q->size; i++) u[i] = q->u0[i] - h * v[i];
    ric_shooting_fly(c, u);
    for (int i = 0; i < n; i++) out[i] = q->sign * (after[i] - c->w[n * step + i]) / (2 * h);
    for (int k = 0; k < c->n_flight; k++) out[n + k] = v[n + (k + step) % c->n_flight];
    return RIC_OK;
}

static void multiply(const double *A, const double *B, double *out)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            out[3 * i + j] = 0;
            for (int k = 0; k < 3; k++) out[3 * i + j] += A[3 * i + k] * B[3 * k + j];
        }
}

/* S [9] is the shift in coordinates of the kernel: false unless S^r = 1 with one fixed direction
 * and a plane that turns. P = mean of the powers of S, which projects on the fixed direction;
 * *cosine of the angle by which the plane turns. */
static bool turns(int order, const double *S, double *P, double *cosine)
{
    double power[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, next[9], off = 0;
    memset(P, 0, 9 * sizeof *P);
    for (int k = 0; k < order; k++) {
        for (int i = 0; i < 9; i++) P[i] += power[i] / order;
        multiply(S, power, next);
        memcpy(power, next, sizeof power);
    }
    for (int i = 0; i < 9; i++) off = fmax(off, fabs(power[i] - (i % 4 == 0)));
    *cosine = (S[0] + S[4] + S[8] - 1) / 2;
    return off < TURNS && fabs(P[0] + P[4] + P[8] - 1) < TURNS && fabs(*cosine) < 1;
}

/* out = A v, A [9]. */
static void apply(const double *A, const double *v, double *out)
{
    for (int i = 0; i < 3; i++)
        out[i] = A[3 * i] * v[0] + A[3 * i + 1] * v[1] + A[3 * i + 2] * v[2];
}

/* Of the unit vectors of the unknowns the one whose image under A (kernel coordinates) is longest:
 * a choice that does not depend on the basis of the kernel. out [3]: that image, in kernel
 * coordinates. */
static void longest_image(const ring *q, const double *kernel, const double *A, double *out)
{
    double most = 0;
    for (int j = 0; j < q->size; j++) {
        double v[3] = {kernel[j], kernel[q->size + j], kernel[2 * q->size + j]}, image[3];
        apply(A, v, image);
        double length = ric_dot(3, image, image);
        if (length <= most * (1 + RIC_TIE_IN_KERNEL)) continue;
        most = length;
        memcpy(out, image, sizeof image);
    }
}

static void cross(const double *a, const double *b, double *out)
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Tangent, plane and dual vectors from the kernel [3 * size]. */
static ric_status split(ring *q, const double *kernel)
{
    int n = q->size;
    double S[9], P[9], Q[9], image[n], cosine, t[3] = {0}, f[2][3] = {{0}}, rows[2][3];
    for (int j = 0; j < 3; j++) {
        ric_status status = shift(q, kernel + j * n, image);
        if (status) return status;
        for (int i = 0; i < 3; i++) S[3 * i + j] = ric_dot(n, kernel + i * n, image);
    }
    if (!turns(q->order, S, P, &cosine))
        return ric_fail(RIC_E_NUMERIC,
                        "the kernel at a multiplication of order %d does not turn with the period",
                        q->order);
    for (int i = 0; i < 9; i++) Q[i] = (i % 4 == 0) - P[i];
    longest_image(q, kernel, P, t);
    longest_image(q, kernel, Q, f[0]);
    apply(S, f[0], f[1]);
    for (int i = 0; i < 3; i++) f[1][i] = (f[1][i] - cosine * f[0][i]) / sqrt(1 - cosine * cosine);
    double size = sqrt((ric_dot(3, f[0], f[0]) + ric_dot(3, f[1], f[1])) / 2),
           length = sqrt(ric_dot(3, t, t)), volume;
    for (int i = 0; i < 3; i++) {
        f[0][i] /= size;
        f[1][i] /= size;
        t[i] /= length;
    }
    cross(f[1], t, rows[0]);
    cross(t, f[0], rows[1]);
    volume = ric_dot(3, f[0], rows[0]);
    for (int j = 0; j < n; j++) {
        double v[3] = {kernel[j], kernel[n + j], kernel[2 * n + j]};
        q->tangent[j] = ric_dot(3, t, v);
        for (int k = 0; k < 2; k++) {
            q->plane[k * n + j] = ric_dot(3, f[k], v);
            q->dual[k * n + j] = ric_dot(3, rows[k], v) / volume;
        }
    }
    return RIC_OK;
}

/* Of the left kernel [3 * size] the two directions perpendicular to that of the redundant equation.
 */
static void split_left(ring *q, const double *kernel)
{
    int n = q->size;
    double h[3], a[3], b[3], sum = 0;
    ric_shooting_fly(q->chain, q->u0);
    ric_singular_redundant(&q->at, q->energy);
    for (int i = 0; i < 3; i++) h[i] = ric_dot(n, kernel + i * n, q->energy);
    int least = fabs(h[0]) < fabs(h[1]) ? 0 : 1;
    if (fabs(h[2]) < fabs(h[least])) least = 2;
    double unit[3] = {least == 0, least == 1, least == 2};
    cross(h, unit, a);
    cross(h, a, b);
    for (int i = 0; i < 3; i++) sum += a[i] * a[i];
    for (int j = 0; j < n; j++) {
        double v[3] = {kernel[j], kernel[n + j], kernel[2 * n + j]};
        q->left[j] = ric_dot(3, a, v) / sqrt(sum);
        q->left[n + j] = ric_dot(3, b, v) / sqrt(sum * ric_dot(3, h, h));
    }
}

/* M = d^2(left . equations) / ds dz: how fast the plane turns as the repeated branch is followed.
 */
static ric_status twist(ring *q)
{
    if (!ric_singular_bend(&q->at, q->u0, q->tangent, 2, q->left, 2, q->plane, q->M))
        return ric_no_memory("a departure");
    double size = ric_dot(4, q->M, q->M);
    if (fabs(q->M[0] * q->M[3] - q->M[1] * q->M[2]) > RIC_RANK * size) return RIC_OK;
    return ric_fail(RIC_E_NUMERIC,
                    "the rotation number does not pass the multiplication, it turns round there");
}

/* -------------------------------------------------------------------- circle */

/* Without an event the phase is free, and the first row keeps corrections across the flow. Orbits
 * on the circle start in the plane across the flow at the node. */
static void hold_phase(ring *q, const double *u)
{
    int n = 2 * q->chain->n;
    double rate[n];
    ric_flight_rate(q->chain->model, 0, q->u0, rate);
    double norm = sqrt(ric_dot(n, rate, rate));
    q->b[0] = 0;
    memset(q->A, 0, ((size_t)q->size + 2) * sizeof *q->A);
    for (int i = 0; i < n; i++) {
        q->A[i] = rate[i] / norm;
        q->b[0] += q->A[i] * (u[i] - q->u0[i]);
    }
}

/* The orbit problem with z = h (cos, sin)(angle), an unfolding of the redundant equation and one
 * along M (-sin, cos), whose coefficient *g is minus the angular part of the gradient: n + 2
 * equations for u [size] and the two coefficients. */
static bool on_circle(ring *q, double angle, double *u, double *g)
{
    ric_shooting *c = q->chain;
    int n = q->size, k = n + 2;
    lapack_int pivot[k];
    double z[2] = {q->radius * cos(angle), q->radius * sin(angle)}, e[n], energy = 0,
           last = HUGE_VAL;
    double m[2] = {q->M[1] * z[0] - q->M[0] * z[1], q->M[3] * z[0] - q->M[2] * z[1]},
           norm = hypot(m[0], m[1]);
    for (int j = 0; j < n; j++) {
        e[j] = (m[0] * q->left[j] + m[1] * q->left[n + j]) / norm;
        u[j] = q->u0[j] + z[0] * q->plane[j] + z[1] * q->plane[n + j];
    }
    *g = 0;
    for (int i = 0; i < NEWTON_STEPS; i++) {
        ric_shooting_fly(c, u);
        if (ric_shooting_jacobian(c, u, q->at.J) != n) return false;
        ric_shooting_residuals(c, u, q->b);
        memset(q->A, 0, (size_t)k * (size_t)k * sizeof *q->A);
        double size = 0;
        for (int j = 0; j < n; j++) {
            memcpy(q->A + j * k, q->at.J + j * n, (size_t)n * sizeof *q->at.J);
            q->A[j * k + n] = q->energy[j];
            q->A[j * k + n + 1] = e[j];
            q->b[j] += energy * q->energy[j] + *g * e[j];
            size = fmax(size, fabs(q->b[j]));
        }
        if (!ric_periodic_has_events(c->model)) hold_phase(q, u);
        for (int j = 0; j < 2; j++) {
            memcpy(q->A + (n + j) * k, q->dual + j * n, (size_t)n * sizeof *q->dual);
            q->b[n + j] = -z[j];
            for (int l = 0; l < n; l++) q->b[n + j] += q->dual[j * n + l] * (u[l] - q->u0[l]);
        }
        /* at rounding level, and no longer falling */
        double tolerance = ric_continuation_tolerance(c) * c->scale;
        if (size <= tolerance && size > RIC_FALLING * last) return true;
        if (i > 2 && size > RIC_STALLING * last) return size <= STALLED * tolerance;
        last = size;
        if (ric_lapack(LAPACKE_dgesv(LAPACK_ROW_MAJOR, k, 1, q->A, k, pivot, q->b, 1)))
            return false;
        for (int j = 0; j < n; j++) u[j] -= q->b[j];
        energy -= q->b[n];
        *g -= q->b[n + 1];
    }
    return false;
}

/* Zero of g between two angles; the orbit there in u. */
static bool zero_between(ring *q, double a, double ga, double b, double gb, double *angle,
                         double *u)
{
    ric_root r = ric_root_between(a, ga, b, gb, RIC_LAST_DIGIT);
    while (ric_root_next(&r))
        if (!on_circle(q, r.x, u, &r.f)) return false;
    *angle = r.x;
    if (!on_circle(q, *angle, u, &r.f)) return false;
    ric_shooting_fly(q->chain, u);
    return q->chain->residual <= STALLED * ric_continuation_tolerance(q->chain);
}

typedef enum {
    CIRCLE_GOOD,
    CIRCLE_NARROW,
    CIRCLE_WIDE
} circle; /* narrow: the angular equation is lost in rounding */

/* The coefficient g at SAMPLES + 1 angles of a sector; *most, where it is largest. */
static circle scan(ring *q, double origin, double *g, double *most)
{
    double u[q->size], largest = 0;
    for (int i = 0; i <= SAMPLES; i++) {
        double angle = origin + RIC_TWO_PI / q->order * i / SAMPLES;
        if (!on_circle(q, angle, u, &g[i])) return CIRCLE_WIDE;
        if (fabs(g[i]) <= largest) continue;
        largest = fabs(g[i]);
        *most = angle;
    }
    return largest > CLEAR * ric_continuation_tolerance(q->chain) * q->chain->scale ? CIRCLE_GOOD
                                                                                    : CIRCLE_NARROW;
}

/* The two roots of a sector at the present radius; slope [2] of the angular part there. */
static circle search(ring *q, double slope[2])
{
    double g[SAMPLES + 1], origin = 0, unused, step = RIC_TWO_PI / q->order / SAMPLES;
    int found = 0;
    circle result = scan(q, 0, g, &origin);
    if (!result)
        result = scan(q, origin, g,
                      &unused); /* from an extremum to the next: no root at the border */
    for (int i = 0; i < SAMPLES && !result; i++) {
        if ((g[i] < 0) == (g[i + 1] < 0)) continue;
        if (found == 2) return CIRCLE_WIDE;
        double a = origin + i * step;
        if (!zero_between(q, a, g[i], a + step, g[i + 1], &q->angle[found],
                          q->start + found * q->size))
            return CIRCLE_WIDE;
        slope[found++] = g[i] - g[i + 1]; /* the angular part is -g */
    }
    return result ? result : found == 2 ? CIRCLE_GOOD : CIRCLE_WIDE;
}

/* Puts the elliptic root first, of two alike the one of smaller energy. With delta = (E - E_0) /
 * (dE/ds), the place on the repeated branch that has the energy of the orbit, the radial derivative
 * of the gradient is -2 nu delta; its product with the angular one, g', both over nu, is the
 * determinant of the Hessian of H at constant energy: positive where the multipliers are on the
 * unit circle. */
static void sort_roots(ring *q, const double slope[2])
{
    ric_shooting *c = q->chain;
    double rise, energy, offset[2];
    ric_shooting_fly(c, q->u0);
    energy = ric_shooting_energy(c);
    rise = ric_shooting_energy_slope(c, q->tangent);
    for (int i = 0; i < 2; i++) {
        ric_shooting_fly(c, q->start + i * q->size);
        offset[i] = ric_shooting_energy(c) - energy;
    }
    bool elliptic[2] = {offset[0] * rise * slope[0] < 0, offset[1] * rise * slope[1] < 0};
    if (elliptic[0] != elliptic[1] ? elliptic[0] : offset[0] < offset[1]) return;
    double angle = q->angle[0];
    q->angle[0] = q->angle[1];
    q->angle[1] = angle;
    for (int i = 0; i < q->size; i++) {
        double u = q->start[i];
        q->start[i] = q->start[q->size + i];
        q->start[q->size + i] = u;
    }
}

/* Largest angle between a start, seen from the node, and the curve there. */
static double bend(ring *q)
{
    int n = q->size;
    double t[n], chord[n], most = 0;
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < n; j++) chord[j] = q->start[i * n + j] - q->u0[j];
        ric_shooting_evaluate(q->chain, q->start + i * n);
        ric_continuation_tangent(q->chain, chord, t);
        most = fmax(most, acos(fmin(1, ric_dot(n, t, chord) / sqrt(ric_dot(n, chord, chord)))));
    }
    return most;
}

/* The radius: wide enough for the angular equation to stand out of rounding, narrow enough for a
 * chord to tell of the curve. */
static ric_status choose_radius(ring *q, double slope[2])
{
    bool wider = false, narrower = false;
    ric_shooting_fly(q->chain, q->u0);
    q->radius = RADIUS * q->chain->scale;
    for (int i = 0; i < RADII; i++) {
        circle found = search(q, slope);
        if (found == CIRCLE_NARROW) {
            if (narrower) break;
            wider = true;
            q->radius *= 2;
        } else if (found == CIRCLE_WIDE || bend(q) > BEND) {
            if (wider) break;
            narrower = true;
            q->radius /= 2;
        } else return RIC_OK;
    }
    return ric_fail(RIC_E_NUMERIC,
                    "the directions at a multiplication of order %d are lost in rounding on every "
                    "circle that is "
                    "narrow enough to speak of directions",
                    q->order);
}

/* An orbit of all r periods, and no shorter one repeated. */
static bool primitive(ring *q, const double *u)
{
    ric_shooting_fly(q->chain, u);
    ric_periodic *cycle = ric_periodic_from_chain(q->chain, u);
    bool result = cycle && ric_periodic_find_symmetries(q->chain->model, cycle,
                                                        0.01 * q->radius / q->chain->scale) == 1;
    ric_periodic_free(cycle);
    return result;
}

/* The kernel, right and left, of the orbit gone through r times, taken apart. */
static ric_status open_kernel(ring *q)
{
    ric_status status = ric_singular_create(q->chain, true, &q->at);
    if (status) return status;
    ric_shooting_fly(q->chain, q->u0);
    if (!ric_singular_factor(&q->at, q->u0) || q->at.equations != q->size ||
        !ric_singular_opens(&q->at, 3))
        return ric_fail(
            RIC_E_NUMERIC,
            "the kernel at a multiplication without mirror points has not three dimensions");
    double left[3 * q->size];
    ric_singular_cokernel(&q->at, 3, left);
    if ((status = split(q, ric_singular_kernel(&q->at, 3)))) return status;
    split_left(q, left);
    return twist(q);
}

/* Everything above. */
static ric_status solve(const ric_model *m, const ric_node *node, ring *q)
{
    double slope[2];
    ric_status status = ring_create(m, node, q);
    if (!status) status = open_kernel(q);
    if (!status) status = choose_radius(q, slope);
    if (status) goto out;
    sort_roots(q, slope);
    for (int i = 0; i < 2; i++)
        if (!primitive(q, q->start + i * q->size))
            status = ric_fail(
                RIC_E_NUMERIC,
                "what was found beside a multiplication of order %d is an orbit of fewer periods",
                q->order);
out:
    if (status) ring_free(q);
    return status;
}

/* ----------------------------------------------------------------- interface */

ric_status ric_multiplication_depart(const ric_model *m, const ric_node *node, unsigned choice,
                                     int side, ric_outset *out)
{
    ring q;
    ric_status status = solve(m, node, &q);
    if (status) return status;
    size_t bytes = (size_t)q.size * sizeof *out->u;
    const double *start = q.start + (choice == RIC_OTHER_SIDE || side < 0 ? q.size : 0);
    out->u = ric_malloc(bytes);
    out->t = ric_malloc(bytes);
    if (out->u && out->t) {
        memcpy(out->u, q.u0, bytes);
        for (int i = 0; i < q.size; i++) out->t[i] = start[i] - q.u0[i];
        out->chain = q.chain;
        q.chain = NULL;
    } else status = ric_no_memory("a departure");
    ring_free(&q);
    return status;
}

/* Angle in the plane of the node of an orbit that starts where the node does. */
static double angle_of(const ric_model *m, const ring *q, const ric_periodic *home)
{
    ric_shooting *chain = NULL;
    double *u = NULL, z[2] = {NAN, NAN};
    if (!ric_periodic_to_chain(m, home, &chain, &u) && chain->n_unknown == q->size) {
        memset(z, 0, sizeof z);
        for (int i = 0; i < q->size; i++)
            for (int j = 0; j < 2; j++) z[j] += q->dual[j * q->size + i] * (u[i] - q->u0[i]);
    }
    ric_shooting_free(chain);
    free(u);
    return atan2(z[1], z[0]);
}

/* Smallest differences of the angles of `near`, shifted by any number of periods, from the two
 * roots; false if it is no neighbour. The shift turns the plane by whole sectors only in the limit
 * of small circles: one of the images is the orbit that was found, exactly. */
static bool compare(const ric_model *m, const ric_node *node, const ring *q,
                    const ric_periodic *near, double off[2])
{
    ric_periodic *repeated = ric_periodic_repeat(node->cycle, node->multiple),
                 *home = repeated ? ric_periodic_nearest(m, repeated, near, NEIGHBOUR) : NULL;
    bool turned = q->order > node->multiple; /* each shift is half a period, joined with x -> -x */
    off[0] = off[1] = HUGE_VAL;
    for (int k = 0; home && k < q->order; k++) {
        ric_periodic *image = ric_periodic_transform(m, home, k * home->N / q->order, false,
                                                     turned && k % 2);
        if (image) ric_periodic_align(m, repeated, image);
        double angle = image ? angle_of(m, q, image) : NAN;
        for (int i = 0; i < 2; i++)
            off[i] = fmin(off[i], fabs(remainder(angle - q->angle[i], RIC_TWO_PI)));
        ric_periodic_free(image);
    }
    ric_periodic_free(repeated);
    ric_periodic_free(home);
    return off[0] < HUGE_VAL;
}

ric_status ric_multiplication_class(const ric_model *m, const ric_node *node,
                                    const ric_periodic *near, unsigned *choice, int *side)
{
    ring q;
    double off[2];
    ric_status status = solve(m, node, &q);
    if (status) return status;
    if (compare(m, node, &q, near, off)) {
        bool second = off[1] < off[0],
             passes = ric_symmetry_passes(node->cycle, node->rotation[0], node->rotation[1]);
        *choice = second && !passes ? RIC_OTHER_SIDE : RIC_SIDE;
        *side = second && passes ? -1 : 1;
    } else status = ric_fail(RIC_E_NUMERIC, "the orbit does not lie beside the multiplication");
    ring_free(&q);
    return status;
}
