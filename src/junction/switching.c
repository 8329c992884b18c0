#include "switching.h"

#include <stdlib.h>
#include <string.h>

#include "corner.h"
#include "branch_point.h"
#include "mixture_way.h"
#include "model/room.h"
#include "grazing_words.h"
#include "multiplication.h"
#include "grazing_spring.h"
#include "base/room.h"
#include "orbit/room.h"

#define SEVERAL 1e-9 /* a pivot below it belongs to a kernel of several dimensions */
/* TRIAL: first trial step of a departure, relative to the size of the orbit; its tenth must agree
 */
#define TRIAL 1e-4
/* NEARER: the same where neither side has a branch there */
#define NEARER 1e-6
/* VANISHING: part of a change that a margin at the junction may be off zero, beside its rounding,
 * where it vanishes */
#define VANISHING 1e-5
#define TOUCH 1e-9 /* reach within this of 1 at the junction is a touch */
/* AT_ONE_TIME: scaled time by which a touch moves within TRIAL at most */
#define AT_ONE_TIME 1e-2
/* SECANT: distance, relative, of the point that gives the direction of a side branch */
#define SECANT 1e-4
#define NEAR 1e-5 /* the same of points that are not solved: directions are their differences */
/* ITSELF: of an orbit and its image, one is the orbit itself if its distance is less than this part
 * of the other's */
#define ITSELF 1e-2
/* SECOND: what counts as zero in the end rows that the flights leave, whose entries are of order
 * one */
#define SECOND 1e-6

static const char move_together[] =
    "the kernel at the grazing has more than one dimension: modes of commensurate "
    "frequencies move together there and no single branch leaves";

/* Two contacts of a kept word that close at one instant. */
static const char *together(const ric_model *m, const ric_periodic *c)
{
    for (int i = 0; i < c->N; i++) {
        const ric_face *f = &m->face[c->face[i]], *g = &m->face[c->face[(i + 1) % c->N]];
        if (f->contact == g->contact || c->tau[i] > RIC_COINCIDENT) continue;
        return ric_corner_commute(m, f, g) ? "two contacts close together for a whole branch; "
                                             "`together` under `model` makes a study of such "
                                             "motions"
                                           : "two contacts close together and their normals are "
                                             "not orthogonal in the metric of M^-1: the "
                                             "impact law does not say what happens";
    }
    return NULL;
}

/* What has to be positive on a branch, at the junction that it leaves: some of it vanishes there.
 */
typedef struct {
    const double *u, *approach; /* [n_unknown] [n_flight + 1] */
    int n_touch;
    ric_touch touch[4 * RIC_MAX_TOUCHES];
} leaving;

/* Whether a margin is lost at a distance because it vanishes at the junction, not because the
 * branch ends on the way. */
static bool vanishes(double there, double here, double lost)
{
    return there <= fmax(lost, VANISHING * fabs(here - there));
}

static double time_of(const ric_shooting *c, const double *u, const ric_touch *touch)
{
    double sum = touch->time;
    for (int k = 0; k < touch->flight; k++) sum += u[c->n_start + k];
    return sum;
}

/* The same of a gap that is closed there: whether it is one of those that touch at the junction. */
static bool touches(const ric_shooting *c, const leaving *from, const double *u,
                    const ric_touch *beyond)
{
    for (int i = 0; i < from->n_touch; i++)
        if (from->touch[i].face == beyond->face &&
            fabs(time_of(c, from->u, &from->touch[i]) - time_of(c, u, beyond)) <= AT_ONE_TIME)
            return true;
    return false;
}

/* Admissible at distance h along t from u0? Strictly: every margin has its sign. An impact may have
 * no speed but rounding, and the branch be shorter than that. */
typedef enum { NONE, BRANCH, LOST, BEYOND } trial;

static trial admissible(ric_shooting *c, const leaving *from, const double *t, double h)
{
    int size = c->n_unknown, iterations;
    double u[size], du[size];
    for (int i = 0; i < size; i++) u[i] = from->u[i] + h * t[i];
    if (!ric_continuation_correct(c, u, from->u, t, h, du, &iterations)) return LOST;
    double lost = 4 * ric_continuation_tolerance(c) * c->scale * (1 + 1 / c->smallest);
    for (int k = c->start == RIC_MIRROR_IMPACT ? 0 : 1; k <= c->n_flight; k++)
        if (c->face[k] < 0 || c->model->face[c->face[k]].spring > 0) continue;
        else if (fabs(c->approach[k]) <= lost) return LOST;
        else if (c->approach[k] < 0)
            return vanishes(from->approach[k], c->approach[k], lost) ? NONE : BEYOND;
    for (int k = 0; k < c->n_flight; k++) {
        const double time = u[c->n_start + k];
        if (ric_shooting_touches(c, k) && fabs(time) <= lost) return LOST;
        else if (!(time > 0)) return vanishes(from->u[c->n_start + k], time, lost) ? NONE : BEYOND;
    }
    ric_touch farthest;
    if (ric_reach(c, u, &farthest) < 1) return BRANCH;
    return touches(c, from, u, &farthest) ? NONE : BEYOND;
}

/* What two trials say that agree, the second a tenth as far as the first. LOST: none agree. */
static trial ask_side(ric_shooting *c, const leaving *from, const double *t, int side)
{
    double h = side * TRIAL * c->scale;
    trial first = NONE, second = BRANCH;
    for (int i = 0; i < 6 && (first != second || first == BEYOND); i++, h /= 10) {
        first = admissible(c, from, t, h);
        second = admissible(c, from, t, h / 10);
    }
    return first == second ? first : LOST;
}

/* Where neither side has a branch so far away it may have one that is shorter: the gap that closes
 * at its end is one that opens at the junction. */
static trial ask_nearer(ric_shooting *c, const leaving *from, const double *t, int side)
{
    const trial near = admissible(c, from, t, side * NEARER * c->scale),
                nearest = admissible(c, from, t, side * NEARER / 10 * c->scale);
    if (near != BRANCH && nearest != BRANCH) return NONE;
    return near == nearest ? BRANCH : LOST;
}

/* The side of t [n_unknown] on which the branch exists: *found +-1, 0 for neither; t0 [n_unknown]
 * points there. What vanishes at the junction is positive on one side of it alone, so that where
 * the branch is on one side it is not asked how short it would be on the other. */
static ric_status try_sides(ric_shooting *c, const double *u0, const double *t, double *t0,
                            int *found)
{
    double approach[c->n_flight + 1];
    leaving from = {.u = u0, .approach = approach};
    const int capacity = (int)(sizeof from.touch / sizeof *from.touch);
    ric_shooting_fly(c, u0);
    memcpy(approach, c->approach, sizeof approach);
    from.n_touch = ric_reach_all(c, u0, 1 - TOUCH, capacity, from.touch);
    if (from.n_touch > capacity) from.n_touch = capacity;
    trial said[2] = {ask_side(c, &from, t, 1), ask_side(c, &from, t, -1)};
    if (said[0] == NONE && said[1] == NONE)
        for (int k = 0; k < 2; k++) said[k] = ask_nearer(c, &from, t, k ? -1 : 1);
    const bool either = said[0] == BRANCH || said[1] == BRANCH;
    for (int k = 0; k < 2; k++)
        if (said[k] == LOST || (said[k] == BEYOND && !either))
            return ric_fail(RIC_E_NUMERIC,
                            "whether the departure is admissible is lost in rounding");
    if (said[0] == BRANCH && said[1] == BRANCH)
        return ric_fail(RIC_E_NUMERIC,
                        "the departure is admissible both ways: the touch does not end it");
    if (either) *found = said[0] == BRANCH ? 1 : -1;
    for (int i = 0; i < c->n_unknown && either; i++) t0[i] = *found * t[i];
    return RIC_OK;
}

static ric_status find_side(ric_outset *out, int *found)
{
    ric_shooting *c = out->chain;
    double t[c->n_unknown];
    int iterations;
    *found = 0;
    if (!ric_continuation_correct(c, out->u, NULL, NULL, 0, t, &iterations))
        return ric_fail(RIC_E_NUMERIC, "the orbit at the grazing does not converge (residual %g)",
                        c->residual);
    if (c->smallest < SEVERAL) return ric_fail(RIC_E_NUMERIC, "%s", move_together);
    ric_continuation_tangent(c, NULL, t);
    return try_sides(c, out->u, t, out->t, found);
}

/* Whether a mode beside those of a linear motion has a frequency that the period of it, gone
 * through `multiple` times, is a whole number of periods of: it moves along at will, and takes part
 * in what the impacts drive. */
static bool commensurate(const ric_model *m, const ric_node *node)
{
    double turn = node->multiple * node->period / RIC_TWO_PI;
    const ric_eigenspace *own = &m->mixtures->space[ric_node_space(m, node)];
    for (int i = 0; i < m->n; i++) {
        double turns = m->omega[i] * turn;
        if (i >= own->first && i < own->first + own->size) continue;
        if (fabs(turns - rint(turns)) < RIC_SAME_LOCATED) return true;
    }
    return false;
}

/* The same at a linear motion of modes that share a frequency. Its kernel holds the other linear
 * motions that touch; across them lies the one branch, if there is one: beside a motion that is
 * none of ric_mixtures the impulses do not drive that motion itself, and no impact gets any speed.
 */
static ric_status find_shared_side(const ric_node *node, ric_outset *out, int *found)
{
    ric_shooting *c = out->chain;
    double t[c->n_unknown];
    int count;
    *found = 0;
    if (c->n_unknown > RIC_DENSE_MOST)
        return ric_fail(
            RIC_E_NUMERIC,
            "a grazing of modes of one frequency with %d unknowns: more than this version "
            "looks for a way out of",
            c->n_unknown);
    ric_shooting_fly(c, out->u);
    ric_status status = ric_mixture_way(c, out->u, t, &count);
    if (!status && count != 1 && commensurate(c->model, node))
        return ric_fail(RIC_E_NUMERIC, "%s", move_together);
    if (status || count == 0) return status;
    if (count > 1)
        return ric_fail(RIC_E_NUMERIC, "modes of one frequency, and impacts that share their "
                                       "impulse in any way: no single branch "
                                       "leaves");
    status = try_sides(c, out->u, t, out->t, found);
    for (int i = 0; i < c->n_unknown; i++) out->t[i] *= RIC_LEAVING * c->scale;
    return status;
}

/* From a grazing or a corner. */
static ric_status depart_subset(const ric_model *m, const ric_node *node, unsigned choice,
                                ric_outset *out, bool *singular)
{
    ric_periodic *cycle = ric_grazing_words_cycle(m, node, choice);
    int found = 0;
    if (!cycle) return ric_no_memory("a departure");
    if (!ric_model_balances(m, cycle->N, cycle->face)) { /* no motion strikes these faces alone */
        ric_periodic_free(cycle);
        return RIC_OK;
    }
    const char *refused = node->kind == RIC_KIND_GRAZING ? together(m, cycle) : NULL;
    ric_status status = refused ? ric_fail(RIC_E_NUMERIC, "%s", refused)
                                : ric_outset_open(m, cycle, out);
    ric_periodic_free(cycle);
    if (status) return status;
    if (ric_grazing_spring_applies(node)) {
        ric_outset_clear(out);
        return ric_grazing_spring_depart(m, node, choice, out, singular);
    }
    *singular = node->kind == RIC_KIND_GRAZING && ric_node_space(m, node) >= 0;
    status = *singular ? find_shared_side(node, out, &found) : find_side(out, &found);
    if (!found) ric_outset_clear(out);
    return status;
}

/* Kernel [2 rows of `size`] of the dense Jacobian; false if it has not two dimensions. The largest
 * singular value is that of a flight time, hundreds in stiff structures: regular ones may be 1e-8
 * of it, and what counts is the gap. */
static bool dense_plane(ric_shooting *c, const double *u, double *kernel)
{
    ric_singular q;
    if (ric_singular_create(c, false, &q)) return false;
    bool found = ric_singular_factor(&q, u) && ric_singular_opens(&q, 2);
    if (found) memcpy(kernel, ric_singular_kernel(&q, 2), 2 * (size_t)q.unknowns * sizeof *kernel);
    ric_singular_free(&q);
    return found;
}

static bool plane(ric_shooting *c, const double *u, double *kernel)
{
    double second;
    if (c->n_unknown <= RIC_DENSE_MOST) return dense_plane(c, u, kernel);
    ric_shooting_evaluate(c, u);
    return ric_shooting_plane(c, kernel, &second) && second <= SECOND;
}

/* A neighbour of the node on the branch that passes, on one side, as unknowns of the problem in
 * which the other one leaves. */
static ric_status neighbour(const ric_outset *passes, int side, const ric_turn *turn,
                            const ric_symmetry *problem, double **u)
{
    const ric_model *m = passes->chain->model;
    const double h = side * NEAR * passes->chain->scale;
    double point[passes->chain->n_unknown];
    ric_shooting *chain = NULL;
    ric_status status;
    for (int i = 0; i < passes->chain->n_unknown; i++) point[i] = passes->u[i] + h * passes->t[i];
    ric_periodic *home = ric_turn_cycle(m, passes->chain, point, turn),
                 *repeated = home ? ric_symmetry_cycle(home, problem) : NULL;
    status = repeated ? ric_periodic_to_chain(m, repeated, &chain, u)
                      : ric_no_memory("a departure");
    ric_shooting_free(chain);
    ric_periodic_free(home);
    ric_periodic_free(repeated);
    return status;
}

/* In the kernel of the larger problem, perpendicular to the symmetric branch, largest component
 * positive. */
static ric_status side_direction(const double *before, const double *after, ric_outset *out)
{
    int size = out->chain->n_unknown;
    double kernel[2 * size], p = 0, q = 0;
    ric_shooting_fly(out->chain, out->u);
    if (!plane(out->chain, out->u, kernel))
        return ric_fail(RIC_E_NUMERIC, "the kernel at the branch point has not two dimensions");
    for (int i = 0; i < size; i++) {
        p += kernel[i] * (after[i] - before[i]);
        q += kernel[size + i] * (after[i] - before[i]);
    }
    for (int i = 0; i < size; i++) out->t[i] = (q * kernel[i] - p * kernel[size + i]) / hypot(p, q);
    ric_singular_orient(size, out->t);
    return RIC_OK;
}

/* The kernel vector is perpendicular to the symmetric branch, the branch that leaves need not be:
 * its direction is that of a point on it. The symmetric branch has no point in the plane that is
 * solved in. */
static bool secant_direction(ric_outset *out)
{
    ric_shooting *c = out->chain;
    int size = c->n_unknown, iterations;
    const double h = SECANT * c->scale, *u0 = out->u;
    double u[size], du[size], *t0 = out->t;
    for (int pass = 0; pass < 2; pass++) {
        double norm = 0;
        for (int i = 0; i < size; i++) u[i] = u0[i] + h * t0[i];
        if (!ric_continuation_correct(c, u, u0, t0, h, du, &iterations)) return false;
        for (int i = 0; i < size; i++) norm += (u[i] - u0[i]) * (u[i] - u0[i]);
        for (int i = 0; i < size; i++) t0[i] = (u[i] - u0[i]) / sqrt(norm);
    }
    return true;
}

/* Unknowns of the chain of an image of a cycle; allocated, NULL without memory. */
static double *image_unknowns(const ric_model *m, const ric_periodic *cycle, int shift, bool mirror)
{
    ric_periodic *image = ric_periodic_transform(m, cycle, shift, false, mirror);
    double *u = ric_periodic_unknowns(m, image);
    ric_periodic_free(image);
    return u;
}

static double largest_difference(int size, const double *a, const double *b)
{
    double most = 0;
    for (int i = 0; i < size; i++) most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

/* A family of even order is its own image half its period on, turned round: its direction is that
 * part of the kernel vector which changes its sign. Nothing is solved, so that families of any
 * smallness are left in the right direction: deep in a cascade other orbits lie about. A cycle may
 * be read from either of its mirror points, which the shift exchanges, and on S orbits the other
 * one shows the mirror image: of the two sets of unknowns one must be that of the chain itself. */
static ric_status odd_direction(const ric_model *m, const ric_node *node, ric_outset *out)
{
    ric_shooting *c = out->chain;
    int size = c->n_unknown;
    double point[size], norm = 0, sign = 0, *t0 = out->t;
    bool found = false, turned = node->cycle->half && node->multiple % 2;
    for (int i = 0; i < size; i++) point[i] = out->u[i] + NEAR * c->scale * t0[i];
    ric_shooting_fly(c, point);
    ric_periodic *here = ric_periodic_from_chain(c, point);
    if (!here) return ric_no_memory("a departure");
    for (int mirror = 0; mirror <= ric_periodic_mirrors(m, here) && !found; mirror++) {
        double *v = image_unknowns(m, here, 0, mirror),
               *w = image_unknowns(m, here, here->N / 2, mirror != turned);
        double a = v && w ? largest_difference(size, v, point) : 0,
               b = v && w ? largest_difference(size, w, point) : 0;
        found = fmin(a, b) < ITSELF * fmax(a, b);
        for (int i = 0; found && i < size; i++) {
            norm += (v[i] - w[i]) * (v[i] - w[i]);
            sign += (v[i] - w[i]) * t0[i];
        }
        for (int i = 0; found && i < size; i++)
            t0[i] = copysign(1 / sqrt(norm), sign) * (v[i] - w[i]);
        free(v);
        free(w);
    }
    ric_periodic_free(here);
    return found && norm > 0
               ? RIC_OK
               : ric_fail(RIC_E_NUMERIC, "no orbit was found beside the branch point");
}

static ric_status depart_through(const ric_model *m, const ric_node *node, ric_outset *out)
{
    ric_status status = ric_outset_open(m, node->cycle, out);
    if (status) return status;
    ric_shooting_evaluate(out->chain, out->u);
    ric_continuation_tangent(out->chain, NULL, out->t);
    return RIC_OK;
}

static bool turns_round(const ric_node *node)
{
    return node->kind == RIC_KIND_MULTIPLICATION &&
           ric_symmetry_order(node->cycle, node->rotation[0], node->rotation[1]) % 2 == 0;
}

static ric_status depart_side(const ric_model *m, const ric_node *node, unsigned choice,
                              ric_outset *out)
{
    ric_symmetry problem = ric_node_problem(node, choice);
    ric_outset passes = {0};
    double *before = NULL, *after = NULL;
    ric_turn turn;
    ric_periodic *cycle = ric_symmetry_cycle(node->cycle, &problem);
    ric_status status = depart_through(m, node, &passes);
    if (!status) status = ric_outset_open(m, cycle, out);
    if (status) goto out;
    /* the cycle of a chain may start elsewhere than the canonical one */
    if (!ric_turn_find(m, passes.chain, passes.u, node->cycle, &turn)) {
        status = ric_fail(RIC_E_NUMERIC,
                          "the symmetric branch could not be followed at its branch point");
        goto out;
    }
    if ((status = neighbour(&passes, -1, &turn, &problem, &before))) goto out;
    if ((status = neighbour(&passes, 1, &turn, &problem, &after))) goto out;
    if ((status = side_direction(before, after, out))) goto out;
    if (turns_round(node)) status = odd_direction(m, node, out);
    else if (!secant_direction(out))
        status = ric_fail(RIC_E_NUMERIC, "no orbit was found beside the branch point");
out:
    ric_outset_clear(&passes);
    ric_periodic_free(cycle);
    free(before);
    free(after);
    return status;
}

/* Along t, or for side = -1 against it; the start may be singular: its first step is the length of
 * t. */
static void orient(int side, double length, ric_outset *out)
{
    for (int i = 0; i < out->chain->n_unknown; i++) out->t[i] *= side * length;
}

/* Whether a spring is met from here on: the contact is short as the distance x from the grazing,
 * and energy and period change as x^2. */
static bool keeps_soft(const ric_node *node, unsigned choice)
{
    for (int bit = 0; bit < node->n_touch * node->multiple; bit++)
        if (ric_node_strikes(choice, bit) && ric_node_soft(node, bit % node->n_touch)) return true;
    return false;
}

/* As ric_switching_depart, into an empty *out, which is to be cleared after an error. */
static ric_status depart(const ric_model *m, const ric_node *node, unsigned choice, int side,
                         ric_outset *out)
{
    const unsigned breaks = 1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D,
                   slopes = 1u << RIC_TEST_SLOPE | 1u << RIC_TEST_PERIOD;
    bool singular = false;
    ric_status status;
    if (node->kind == RIC_KIND_GRAZING) {
        status = depart_subset(m, node, choice, out, &singular);
        out->ignore = breaks | 1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH;
        if (keeps_soft(node, choice)) out->ignore |= slopes;
        if (singular) out->ignore |= 1u << RIC_TEST_DET | RIC_SINGULAR_START;
        return status;
    }
    if (node->kind == RIC_KIND_CORNER) {
        status = depart_subset(m, node, choice, out, &singular);
        out->ignore = 1u << RIC_TEST_FLIGHT;
        return status;
    }
    const bool crosses = node->kind == RIC_KIND_BRANCH_POINT && node->test == RIC_TEST_DET,
               through = choice == RIC_THROUGH && !crosses;
    out->ignore = breaks | 1u << RIC_TEST_DET | (through ? 0 : slopes | RIC_SINGULAR_START);
    if (ric_node_unmirrored(node, choice))
        return ric_fail(RIC_E_NUMERIC,
                        "a period takes every deviation to its negative there: a branch "
                        "that keeps no mirror point is not looked for");
    if (!through && !crosses && ric_multiplication_applies(node, choice))
        return ric_multiplication_depart(m, node, choice, side, out);
    status = crosses   ? ric_branch_point_depart(m, node, choice, out)
             : through ? depart_through(m, node, out)
                       : depart_side(m, node, choice, out);
    if (!status) orient(side, through ? 1 : RIC_LEAVING * out->chain->scale, out);
    return status;
}

ric_status ric_switching_depart(const ric_model *m, const ric_node *node, unsigned choice, int side,
                                ric_outset *out)
{
    *out = (ric_outset){0};
    const ric_status status = depart(m, node, choice, side, out);
    if (status) ric_outset_clear(out);
    return status;
}
