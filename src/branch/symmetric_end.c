#include "symmetric_end.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "orbit/room.h"
#include "base/room.h"

/* Cosine with the direction of the branch beyond which the image of a neighbour counts as lying on
 * it. */
#define ALONG 0.9
#define SETTLE_STEPS 3

/* Whether the image lies on the branch on the other side of `here`, where `beyond` is. The
 * operation is no isometry of the unknowns: lengths may differ. Nor is what is beyond opposite to
 * the neighbour: a branch may bend within the step over the crossing. */
static bool opposite(int size, const double *here, const double *beyond, const double *image)
{
    double product = 0, a = 0, b = 0;
    for (int i = 0; i < size; i++) {
        double d = beyond[i] - here[i], e = image[i] - here[i];
        product += d * e;
        a += d * d;
        b += e * e;
    }
    return product > ALONG * sqrt(a * b);
}

/* How far towards `near`, as a part of the way, the middle between `here` and its image lies. */
static double middle(int size, const double *here, const double *near, const double *image)
{
    double product = 0, square = 0;
    for (int i = 0; i < size; i++) {
        product += (image[i] - here[i]) * (near[i] - here[i]);
        square += (near[i] - here[i]) * (near[i] - here[i]);
    }
    return product / (2 * square);
}

/* Unknowns of a cycle without mirror points as it stands. */
static void free_unknowns(const ric_shooting *c, const ric_periodic *cycle, double *u)
{
    memcpy(u, cycle->w, 2 * (size_t)c->n * sizeof *u);
    u[2 * c->n] = ric_periodic_period(cycle) / c->multiple;
    ric_shooting_nodes_spread(c, u);
}

/* An orbit of a chain without events as a cycle that starts where the chain does; NULL: no memory.
 */
static ric_periodic *free_cycle(const ric_shooting *c, const double *u)
{
    ric_periodic *cycle = ric_periodic_create(c->n, 1);
    if (!cycle) return NULL;
    memcpy(cycle->w, u, 2 * (size_t)c->n * sizeof *u);
    cycle->tau[0] = c->multiple * u[2 * c->n];
    cycle->face[0] = -1;
    if (ric_periodic_mark(cycle, 2)) return cycle;
    ric_periodic_free(cycle);
    return NULL;
}

/* turned_round of orbits without events or mirror points: the operation comes with any shift in
 * time, which is that which keeps `here`, or half a period more. */
static bool turned_freely(const ric_continuation *tr, const ric_crossed *place, int from, int to,
                          double *aside)
{
    const ric_shooting *c = tr->chain;
    const ric_model *m = c->model;
    bool found = false;
    *aside = 0;
    ric_periodic *here = free_cycle(c, place->at), *near = free_cycle(c, place->beside);
    for (int op = from; here && near && op <= to; op++) {
        ric_periodic *image = ric_periodic_transform(m, here, 0, op & 1, op & 2);
        double time = image && op ? ric_periodic_phase(m, here, image) : 0;
        ric_periodic_free(image);
        for (int s = op == 0; s < 2 && !found; s++) {
            double shift = time + s * ric_periodic_period(here) / 2, same[c->n_unknown],
                   w[c->n_unknown];
            ric_periodic *image_here = ric_periodic_transform(m, here, 0, op & 1, op & 2),
                         *image_near = ric_periodic_transform(m, near, 0, op & 1, op & 2);
            if (image_here && image_near) {
                ric_periodic_shift(m, here, shift, image_here);
                double distance = ric_periodic_distance(here, image_here);
                free_unknowns(c, image_here, same);
                if (distance < RIC_SAME_READ_OFF) {
                    ric_periodic_shift(m, here, shift, image_near);
                    free_unknowns(c, image_near, w);
                    bool turned = opposite(c->n_unknown, place->at, place->beyond, w);
                    found = turned && distance < RIC_SAME_EXTRAPOLATED;
                    if (turned && !found)
                        *aside = middle(c->n_unknown, place->at, place->beside, same);
                }
            }
            ric_periodic_free(image_here);
            ric_periodic_free(image_near);
        }
    }
    ric_periodic_free(here);
    ric_periodic_free(near);
    return found;
}

/* At a zero of the bordered determinant: whether one of the operations from..to (1 reversal, 2 x ->
 * -x, 3 both, each with a shift; 0 shifts only) keeps the orbit there and turns the branch round.
 * Where one all but does, *aside is how far towards `beside` the middle between the orbit and its
 * image lies; else 0. */
static bool turned_round(const ric_continuation *tr, const ric_crossed *place, int from, int to,
                         double *aside)
{
    ric_shooting *c = tr->chain;
    const ric_model *m = c->model;
    bool found = false;
    if (!ric_periodic_has_events(m) && c->start == RIC_MIRROR_NONE)
        return turned_freely(tr, place, from, to, aside);
    *aside = 0;
    ric_periodic *here = ric_continuation_cycle(tr, place->at),
                 *near = ric_continuation_cycle(tr, place->beside),
                 *beyond = ric_continuation_cycle(tr, place->beyond);
    double *u = NULL, *v = NULL, *x = NULL;
    for (int op = from; here && near && beyond && !found && op <= to; op++)
        for (int s = 0; s < here->N && !found; s++) {
            if ((op == 0 && s == 0) || ric_periodic_apart(m, here, s, op, RIC_SAME_READ_OFF))
                continue;
            ric_periodic *image = ric_periodic_transform(m, here, s, op & 1, op & 2);
            double distance = image && image->pure == here->pure && image->flip == here->flip
                                  ? ric_periodic_distance(here, image)
                                  : HUGE_VAL;
            double *same = distance < RIC_SAME_READ_OFF ? ric_periodic_unknowns(m, image) : NULL;
            ric_periodic_free(image);
            if (!same) continue;
            if (!u) u = ric_periodic_unknowns(m, here);
            if (!v) v = ric_periodic_unknowns(m, near);
            if (!x) x = ric_periodic_unknowns(m, beyond);
            image = ric_periodic_transform(m, near, s, op & 1, op & 2);
            double *w = ric_periodic_unknowns(m, image);
            bool turned = u && v && x && w && opposite(c->n_unknown, u, x, w);
            found = turned && distance < RIC_SAME_EXTRAPOLATED;
            if (turned && !found) *aside = middle(c->n_unknown, u, v, same);
            free(w);
            free(same);
            ric_periodic_free(image);
        }
    free(u);
    free(v);
    free(x);
    ric_periodic_free(here);
    ric_periodic_free(near);
    ric_periodic_free(beyond);
    return found;
}

bool ric_symmetric_end_meets(const ric_continuation *tr, const ric_crossed *place, double *aside)
{
    return turned_round(tr, place, 0, ric_periodic_operations(tr->chain->model) - 1, aside);
}

bool ric_symmetric_end_passes(const ric_continuation *tr, const ric_crossed *place, double *aside)
{
    *aside = 0;
    if (tr->chain->model->symmetric) return false;
    ric_periodic *cycle = ric_continuation_cycle(tr, place->at);
    bool mirrors = cycle && ric_periodic_mirrors(tr->chain->model, cycle);
    ric_periodic_free(cycle);
    return mirrors && turned_round(tr, place, 2, 3, aside);
}

int ric_symmetric_end_repeats(const ric_continuation *tr, const double *at)
{
    const ric_model *m = tr->chain->model;
    ric_periodic *cycle = ric_continuation_cycle(tr, at);
    int times = 1;
    if (cycle && ric_periodic_repeats(m, cycle, RIC_SAME_EXTRAPOLATED))
        times = (int)fmax(2, ric_periodic_find_symmetries(m, cycle, RIC_SAME_EXTRAPOLATED));
    ric_periodic_free(cycle);
    return times;
}

/* Singular values that belong to the range. Under a power law the shortest step to a crossing may
 * leave one above RIC_RANK that does not: how many there are to drop is known. */
static int range_of(const ric_singular *q)
{
    const ric_shooting *c = q->chain;
    int rank = ric_singular_rank(q, RIC_RANK),
        known = q->equations - (c->start == RIC_MIRROR_NONE ? 2 : 1);
    if (!ric_flight_law_of(c->model)->integrated || known < 1) return rank;
    double first = q->values[known];
    return ric_singular_rank(q,
                             fmin(1.5 * first, sqrt(first * q->values[known - 1])) / q->values[0]);
}

/* Symmetries within `tolerance` beyond those of the form that the cycle of a chain has; takes the
 * cycle over. */
static bool has_more(const ric_model *m, ric_periodic *cycle, double tolerance)
{
    ric_periodic *seen = cycle ? ric_periodic_copy(cycle) : NULL;
    bool more = seen && (ric_periodic_find_symmetries(m, seen, tolerance) > 1 ||
                         (seen->half && !cycle->half) || (seen->pure >= 0 && cycle->pure < 0) ||
                         (seen->flip >= 0 && cycle->flip < 0));
    ric_periodic_free(seen);
    ric_periodic_free(cycle);
    return more;
}

/* Of words alone: all states and times are one. */
bool ric_symmetric_end_may_gain(const ric_shooting *c)
{
    double nothing[c->n_unknown];
    if (!ric_periodic_has_events(c->model)) return false;
    memset(nothing, 0, sizeof nothing);
    ric_periodic *cycle = ric_periodic_from_chain(c, nothing);
    if (cycle) memset(cycle->w, 0, 2 * (size_t)c->n * sizeof *cycle->w);
    return has_more(c->model, cycle, DBL_MAX);
}

bool ric_symmetric_end_gains(const ric_shooting *c, const double *u)
{
    return has_more(c->model, ric_periodic_from_chain(c, u), RIC_SAME_SOLVED);
}

/* Newton's method with the shortest correction, without the directions that singular values below
 * RIC_RANK leave undetermined. */
ric_status ric_symmetric_end_settle(ric_shooting *c, double *u)
{
    int columns = c->n_unknown;
    double v[columns], r[ric_shooting_rows(c)], moved = 0;
    ric_singular q;
    ric_status status = ric_singular_create(c, true, &q);
    if (status) return status;
    memcpy(v, u, sizeof v);
    for (int i = 0; i < SETTLE_STEPS; i++) {
        if (!ric_singular_factor(&q, v)) goto out;
        ric_shooting_residuals(c, v, r);
        ric_singular_step(&q, range_of(&q), r, v);
    }
    ric_shooting_fly(c, v);
    for (int j = 0; j < columns; j++) moved = fmax(moved, fabs(v[j] - u[j]));
    if (ric_continuation_solved(c) && moved <= RIC_SAME_EXTRAPOLATED * c->scale)
        memcpy(u, v, sizeof v);
out:
    ric_singular_free(&q);
    return status;
}
