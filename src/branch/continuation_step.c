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
/* OLDER: points of the branch before those two that a prediction goes through; SPACED: of the last
 * step, the least distance between two of them, as differences of rounding grow with its inverse;
 * STRAIGHT: cosine between the last two tangents below which nothing is told by what was */
enum { OLDER = 2, CUBIC = 4, KNOTS = CUBIC + OLDER };
#define SPACED 0.1
#define STRAIGHT 0.5

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

/* Where an orbit lies in the direction of the tangent at the present one. */
static double place(const ric_continuation *tr, const double *u)
{
    double sum = 0;
    for (int i = 0; i < tr->chain->n_unknown; i++) sum += tr->now.t[i] * (u[i] - tr->now.u[i]);
    return sum;
}

/* The stored points before `past`, the nearest first, that a prediction goes through as well; their
 * number. Those before a tongue that was stepped over are of another piece of the branch. */
static int older_points(const ric_continuation *tr, const double *out[OLDER])
{
    const int first = tr->n_gap > 0 ? tr->gaps[tr->n_gap - 1].point + 1 : 0;
    int count = 0;
    for (int i = tr->n_point - 1; i >= first && count < OLDER; i--) {
        const ric_point *row = ric_continuation_row(tr, i);
        if (row->arclength < tr->past.s) out[count++] = (const double *)(row + 1);
    }
    return count;
}

/* The points that a prediction goes through by their places x [KNOTS], twice those whose tangents
 * count, and differences [KNOTS - 1][size] of one to the next over that of their places; how many,
 * 0 where the branch turns too much. */
static int knots(const ric_continuation *tr, double *x, double *differences)
{
    const int size = tr->chain->n_unknown;
    const double *u0 = tr->now.u, *u1 = tr->past.u, *older[OLDER];
    const double back = place(tr, u1), slope = ric_dot(size, tr->past.t, tr->now.t);
    if (!(back < 0 && slope > STRAIGHT)) return 0;
    x[0] = x[1] = 0;
    x[2] = x[3] = back;
    double *d = differences;
    for (int i = 0; i < size; i++) {
        d[i] = tr->now.t[i];
        d[size + i] = (u1[i] - u0[i]) / back;
        d[2 * size + i] = tr->past.t[i] / slope;
    }
    int count = CUBIC;
    for (const int all = CUBIC + older_points(tr, older); count < all; count++) {
        const double *last = count > CUBIC ? older[count - CUBIC - 1] : u1,
                     *next = older[count - CUBIC];
        x[count] = place(tr, next);
        const double step = x[count] - x[count - 1];
        if (!(step < SPACED * back)) break;
        for (int i = 0; i < size; i++) d[(count - 1) * size + i] = (next[i] - last[i]) / step;
    }
    return count;
}

/* Newton's polynomial through the last points and the tangents of two of them, in the distance
 * along the present tangent, which the plane at distance h keeps: the cubic, and as many terms more
 * as each is less than the one before. */
static void through_all(const ric_continuation *tr, double h, double *u)
{
    const int size = tr->chain->n_unknown;
    double d[(KNOTS - 1) * size], x[KNOTS], weight = h * h, before = 0;
    const int count = knots(tr, x, d);
    for (int order = 2; order < count; order++) {
        for (int k = 0; k + order < count; k++) {
            const double over = 1 / (x[k + order] - x[k]);
            for (int i = k * size; i < (k + 1) * size; i++) d[i] = (d[size + i] - d[i]) * over;
        }
        const double term = weight * weight * ric_dot(size, d, d);
        if (order >= CUBIC && term > before) break;
        before = order >= CUBIC ? term : fmax(before, term);
        for (int i = 0; i < size; i++) u[i] += weight * d[i];
        weight *= h - x[order];
    }
}

/* Cubic through the last two points and tangents, read off at distance h beyond. */
static void through_two(const ric_continuation *tr, double h, double *u)
{
    int size = tr->chain->n_unknown;
    const double *u0 = tr->now.u, *t0 = tr->now.t, *u1 = tr->past.u, *t1 = tr->past.t;
    double H = tr->now.s - tr->past.s, x = 1 + h / H;
    double a = 2 * x * x * x - 3 * x * x + 1, b = (x * x * x - 2 * x * x + x) * H, c = 1 - a,
           d = (x * x * x - x * x) * H;
    for (int i = 0; i < size; i++) u[i] = a * u1[i] + b * t1[i] + c * u0[i] + d * t0[i];
}

/* A straight line at the start. Where a flight is integrated, and is nearly all that a step costs,
 * more is asked of a prediction than of one between stops, beside whose grazings branches bend. */
static void predict(const ric_continuation *tr, double h, double *u)
{
    for (int i = 0; i < tr->chain->n_unknown; i++) u[i] = tr->now.u[i] + h * tr->now.t[i];
    if (!tr->has_past || h > LONGER * (tr->now.s - tr->past.s)) return;
    if (ric_flight_law_of(tr->chain->model)->integrated) through_all(tr, h, u);
    else through_two(tr, h, u);
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
