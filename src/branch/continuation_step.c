/* One step along a branch (docs/theory.md section 7): predicted, corrected, and looked at from
 * outside. */
#include "continuation_step.h"

#include <string.h>

#include "base/room.h"
#include "model/room.h"

#define STEP_ANGLE_MAX 0.35 /* a step that turns more is refused: it may have changed branch */
/* GIVEN: drift of a step that ends at a solved point: the first one from a singular start may, and
 * is no guess */
#define GIVEN 1e-6
/* STEP_HIDDEN: turning, rad, that shows between the chord of a step and its tangents, and not
 * between the tangents: the branch bends and bends back within it. Of other steps 999 in 1,000 hide
 * less than 5e-4 */
#define STEP_HIDDEN 0.005
#define STEP_DRIFT                                                                                 \
    0.25 /* a step whose corrector moved more than this part of it is refused, too                 \
          */
/* NEGATIVE: scaled time: events whose flight is shorter than minus this do not come in that order
 */
#define NEGATIVE 1e-3

/* LONGER: times the last step: one that is longer goes straight on, as the cubic through its ends
 * is known to nothing so far beyond them */
#define LONGER 2.5

static bool positive_flights(const ric_shooting *c, const double *u)
{
    for (int k = 0; k < c->n_flight; k++)
        if (!(u[c->n_start + k] > -NEGATIVE)) return false;
    return true;
}

/* Without an event to start from the phase of an orbit is free, and the corrector leaves it as it
 * is. Whatever a chord had along the flow the cubic below would multiply by five at every step,
 * until no step is short enough: a prediction goes across the flow. */
static void across_flow(const ric_continuation *tr, double *u)
{
    const ric_shooting *c = tr->chain;
    int size = 2 * c->n;
    if (c->start != RIC_MIRROR_NONE || c->face[0] >= 0) return;
    double rate[size], along = 0;
    ric_flight_rate(c->model, c->closed[0], tr->now.u, rate);
    for (int i = 0; i < size; i++) along += rate[i] * (u[i] - tr->now.u[i]);
    along /= ric_dot(size, rate, rate);
    for (int i = 0; i < size; i++) u[i] -= along * rate[i];
}

/* Cubic through the last two points and tangents, read off at distance h beyond; a straight line at
 * the start. */
static void predict(const ric_continuation *tr, double h, double *u)
{
    int size = tr->chain->n_unknown;
    const double *u0 = tr->now.u, *t0 = tr->now.t, *u1 = tr->past.u, *t1 = tr->past.t;
    double H = tr->now.s - tr->past.s, x = 1 + h / H;
    if (!tr->has_past || h > LONGER * H) {
        for (int i = 0; i < size; i++) u[i] = u0[i] + h * t0[i];
        return;
    }
    double a = 2 * x * x * x - 3 * x * x + 1, b = (x * x * x - 2 * x * x + x) * H, c = 1 - a,
           d = (x * x * x - x * x) * H;
    for (int i = 0; i < size; i++) u[i] = a * u1[i] + b * t1[i] + c * u0[i] + d * t0[i];
    across_flow(tr, u);
}

static double angle_between(int size, const double *a, const double *b, double norm)
{
    return acos(fmin(1, ric_dot(size, a, b) / norm));
}

bool ric_continuation_try(ric_continuation *tr, double h, ric_course *out)
{
    ric_shooting *c = tr->chain;
    int size = c->n_unknown;
    predict(tr, h, tr->next.u);
    memcpy(tr->guess, tr->next.u, (size_t)size * sizeof *tr->guess);
    if (!ric_continuation_correct(c, tr->next.u, tr->now.u, tr->now.t, h, tr->du, &out->iterations))
        return false;
    if (!positive_flights(c, tr->next.u)) return false;
    double moved = 0, chord[size];
    for (int i = 0; i < size; i++) {
        double d = tr->next.u[i] - tr->guess[i];
        chord[i] = tr->next.u[i] - tr->now.u[i];
        moved += d * d;
    }
    double length = sqrt(ric_dot(size, chord, chord));
    out->orientation = ric_continuation_tangent(c, tr->now.t, tr->next.t);
    out->angle = angle_between(size, tr->next.t, tr->now.t, 1);
    out->hidden = angle_between(size, tr->now.t, chord, length) +
                  angle_between(size, tr->next.t, chord, length) - out->angle -
                  ric_continuation_tolerance(c) / c->smallest / length;
    out->drift = sqrt(moved) / h;
    /* arc over chord of a circle through both points */
    tr->next.s = tr->now.s + length * (1 + out->angle * out->angle / 24);
    return true;
}

bool ric_continuation_stays(const ric_continuation *tr, const ric_course *way)
{
    bool given = tr->ignore & RIC_SINGULAR_START && way->drift < GIVEN;
    /* close to a crossing the branch may bend towards the other one: whether it does is asked there
     * (event.c) */
    bool crosses = tr->now.test[RIC_TEST_DET] * way->orientation * tr->chain->end_det < 0;
    bool straight = way->hidden < STEP_HIDDEN || !tr->has_past || crosses;
    return ((way->angle < STEP_ANGLE_MAX && straight) || given) && way->drift < STEP_DRIFT;
}
