/* A step over a branch point (event.c): where two branches cross nothing can be solved close by,
 * and all that happens is read off cubics through four points of it. */
#include <stdlib.h>
#include <string.h>

#include "symmetric_end.h"
#include "branch_point_gap.h"
#include "event_parts.h"
#include "model/room.h"
#include "base/room.h"

/* Looks for a better place of an arrival: on sharp turns the zero of the determinant is off. */
#define ASIDE_STEPS 12
/* What may keep two branches apart (ric_branch_point_gap) that cross: rounding. */
#define CROSSED 1e-11
#define FLAT 4 /* periods of a multiplication from which on its order is none below four */
/* dE/ds at a multiplication, of that at 1/2 RIC_CROSSING beside it, below which it counts as zero.
 */
#define ON_SLOPE 0.02
#define BRIDGED 6 /* pieces of a step over a branch point */
/* AT_ONCE: of the size: distance below which a touch falls on a branch point: at that of the points
 * beside it an orbit is known to less */
#define AT_ONCE 1e-6
/* TOUCHES_ZERO: part of what the determinant is at both ends of a step: below it it vanishes */
#define TOUCHES_ZERO 1e-2

/* Whether a branch comes to a corner of orbits that are their own image there: the family on which
 * both contacts stay together crosses. No slope vanishes: the branch has a kink there. */
static bool meets_corner(const ric_continuation *tr, const ric_event_bridge *q, double h,
                         double *at)
{
    if (tr->limits->ghost || !ric_event_watched(tr, RIC_TEST_FLIGHT) ||
        !(q->test[0][RIC_TEST_FLIGHT] * q->test[3][RIC_TEST_FLIGHT] < 0))
        return false;
    double x = ric_event_bridge_root(tr, q, RIC_TEST_FLIGHT, q->x[0], q->x[3],
                                     q->test[0][RIC_TEST_FLIGHT], NAN);
    if (x > *at + 0.05 * h) return false;
    *at = x;
    return true;
}

/* Whether a gap closes where the determinant vanishes: that of a mass which is met by no force
 * while another one strikes, on a branch whose orbits have a symmetry there that its equations
 * lack. Then orbits without it cross, which meet the stop the other way round. */
static bool meets_touch(const ric_continuation *tr, const ric_event_bridge *q, double at)
{
    const double before = q->test[0][RIC_TEST_REACH], after = q->test[3][RIC_TEST_REACH];
    if (tr->limits->ghost || !ric_event_watched(tr, RIC_TEST_REACH) || !(before > 0 && after < 0))
        return false;
    const double x = ric_event_bridge_root(tr, q, RIC_TEST_REACH, q->x[0], q->x[3], before, NAN);
    return fabs(x - at) <= AT_ONCE * tr->chain->scale;
}

static double crossing(const ric_continuation *tr, const ric_event_bridge *q)
{
    return ric_event_bridge_root(tr, q, RIC_TEST_DET, q->x[0], q->x[3], q->test[0][RIC_TEST_DET],
                                 NAN);
}

ric_status ric_event_cross_touches(ric_continuation *tr, double h, bool *touches)
{
    ric_event_bridge q;
    *touches = false;
    if (!(tr->now.test[RIC_TEST_REACH] > 0 && tr->next.test[RIC_TEST_REACH] < 0)) return RIC_OK;
    const ric_status status = ric_event_bridge_build(tr, h, &q);
    if (status) return status == RIC_E_NUMERIC ? RIC_OK : status;
    *touches = meets_touch(tr, &q, crossing(tr, &q));
    free(q.u);
    return RIC_OK;
}

ric_status ric_event_cross_corner(ric_continuation *tr, double h, int *end_test, double *end)
{
    ric_event_bridge q;
    bool good;
    ric_status status = ric_event_solve(tr, *end, h, RIC_LOOK_ALL, &tr->mid, &good);
    const double beside = fmin(fabs(tr->now.test[RIC_TEST_DET]), fabs(tr->next.test[RIC_TEST_DET]));
    if (status || !(fabs(tr->mid.test[RIC_TEST_DET]) < TOUCHES_ZERO * beside)) return status;
    status = ric_event_bridge_build_at(tr, *end / h, h, &q);
    if (status) return status == RIC_E_NUMERIC ? RIC_OK : status;
    const double before = q.test[0][RIC_TEST_FLIGHT];
    if (before > 0 && q.test[3][RIC_TEST_FLIGHT] < 0) {
        *end = ric_event_bridge_root(tr, &q, RIC_TEST_FLIGHT, q.x[0], q.x[3], before, NAN);
        *end_test = RIC_TEST_FLIGHT;
        ric_event_bridge_station(tr, &q, *end, h, &tr->mid);
    }
    free(q.u);
    return RIC_OK;
}

/* Where resonance k is passed up to distance `to` in a step over a branch point at `at`, looked at
 * between the points that are known: multipliers may go to and fro beside it. Room for BRIDGED
 * places; returns their number. At an end that is its own image the only pair is 2, from where it
 * goes with the square of the distance, on both sides: on sharp turns cubics miss it by hundreds.
 */
static int cross_resonance(const ric_continuation *tr, const ric_event_bridge *q, int k, double at,
                           double to, double h, ric_event_root *out)
{
    int test = RIC_N_TEST + k, n = 0;
    const double after = ric_continuation_side(tr, k, &tr->next), rho = tr->resonances[k].rho;
    double from = 0, before = ric_continuation_side(tr, k, &tr->now), own = tr->now.own[0];
    if (before == 0) before = tr->passed[k];
    if (after == 0) return 0; /* the next step shows whether it was passed */
    double place[BRIDGED] = {q->x[0], q->x[1], q->x[2], q->x[3], at, h};
    for (int i = 4; i > 0 && place[i - 1] > at; i--) {
        place[i] = place[i - 1];
        place[i - 1] = at;
    }
    for (int i = 0; i < BRIDGED; i++) {
        double x = place[i];
        if (x <= from || x > h) continue;
        const bool image = x == q->image && tr->floquet.n_pair == 1;
        double value = x == h ? after : image ? 2 - rho : ric_event_bridge_test(tr, q, test, x);
        if (before * value < 0) {
            double root_at = image ? x - (x - from) * sqrt((2 - rho) / (2 - own))
                                   : ric_event_bridge_root(tr, q, test, from, x, before, NAN);
            if (root_at < to || to == h) out[n++] = (ric_event_root){test, root_at};
        }
        from = x;
        before = value;
        own = value + rho;
    }
    return n;
}

/* Whether the branch meets an image of its own, by `kept`, where the determinant vanishes, or
 * beside it: a zero read off cubics lies aside of the middle between the orbit there and its image.
 * *at and tr->mid are moved to it. */
static bool at_image(ric_continuation *tr, const ric_event_bridge *q, double h,
                     bool (*kept)(const ric_continuation *, const ric_crossed *, double *),
                     double *at)
{
    const double from = *at;
    /* a neighbour on the side where there is more room: close by it is lost in rounding */
    const int size = tr->chain->n_unknown, far = from - q->x[0] > q->x[3] - from ? 0 : 3;
    const ric_crossed place = {tr->mid.u, q->u + far * size, q->u + (3 - far) * size};
    for (int i = 0; i < ASIDE_STEPS; i++) {
        double aside;
        if (kept(tr, &place, &aside)) return true;
        const double x = *at + aside * (q->x[far] - *at);
        if (x == *at || !(x > q->x[0] && x < q->x[3])) break;
        ric_event_bridge_station(tr, q, *at = x, h, &tr->mid);
    }
    if (*at != from) ric_event_bridge_station(tr, q, *at = from, h, &tr->mid);
    return false;
}

/* Where a branch meets its own image, and at a multiplication of order 4 and more, dE/ds and dT/ds
 * vanish with the determinant: that zero belongs to the one junction, and beyond it the other sign
 * is the one to expect. A family of order 3 passes on a slope; its extremum lies aside and is a
 * junction of its own. Of fewer than four periods the order is not known, as it may be that of half
 * a period: there the slope tells. */
static bool is_level(ric_continuation *tr, ric_event_bridge *q, double at)
{
    const double ends = fmax(fabs(q->test[0][RIC_TEST_SLOPE]), fabs(q->test[3][RIC_TEST_SLOPE]));
    return fabs(ric_event_bridge_test(tr, q, RIC_TEST_SLOPE, at)) < ON_SLOPE * ends;
}

/* The zeros of a step become events in the order in which the branch meets them. */
static ric_status keep_roots(ric_continuation *tr, ric_event_bridge *q, double h,
                             ric_event_root *roots, int n)
{
    ric_status status = RIC_OK;
    qsort(roots, (size_t)n, sizeof *roots, ric_event_by_place);
    for (int i = 0; i < n && !status; i++) {
        ric_event_bridge_station(tr, q, roots[i].x, h, &tr->mid);
        status = ric_event_keep(tr, roots[i].test, &tr->mid);
    }
    return status;
}

ric_status ric_event_cross(ric_continuation *tr, double h, int *end_test, double *end, bool *retry)
{
    ric_event_bridge q;
    ric_event_root roots[RIC_N_TEST + BRIDGED * tr->n_resonance];
    int n = 0, first = tr->n_event;
    ric_status status = ric_event_bridge_build(tr, h, &q);
    *end_test = -1;
    if (status) return (*retry = status == RIC_E_NUMERIC && tr->avoided) ? RIC_OK : status;
    double at = crossing(tr, &q);
    if (meets_corner(tr, &q, h, &at)) *end_test = RIC_TEST_FLIGHT;
    else if (meets_touch(tr, &q, at)) *end_test = RIC_TEST_REACH;
    ric_event_bridge_station(tr, &q, at, h, &tr->mid);
    if (*end_test < 0 && at_image(tr, &q, h, ric_symmetric_end_meets, &at))
        *end_test = RIC_TEST_DET;
    const int times = ric_symmetric_end_repeats(tr, tr->mid.u);
    const bool arrived = *end_test >= 0, repeated = times > 1, level = times >= FLAT && !arrived;
    if (arrived) *end = at;
    q.image = *end_test == RIC_TEST_DET ? at : NAN;
    /* the determinant has a zero of higher order there, which cubics place badly; the slope has a
     * simple one */
    if (level && q.test[0][RIC_TEST_SLOPE] * q.test[3][RIC_TEST_SLOPE] < 0) {
        at = ric_event_bridge_root(tr, &q, RIC_TEST_SLOPE, q.x[0], q.x[3],
                                   q.test[0][RIC_TEST_SLOPE], NAN);
        ric_event_bridge_station(tr, &q, at, h, &tr->mid);
    }
    /* two branches that only come close: the step has changed from one to the other */
    if (!arrived && !repeated && !(ric_branch_point_gap(tr->chain, tr->mid.u) < CROSSED)) {
        free(q.u);
        tr->avoided = *retry = true;
        return RIC_OK;
    }
    bool image = !arrived && at_image(tr, &q, h, ric_symmetric_end_passes, &at);
    bool flat = *end_test == RIC_TEST_DET || image || level || (repeated && is_level(tr, &q, at));
    for (int i = 0; i < RIC_N_TEST; i++) {
        double before = tr->now.test[i] != 0 ? tr->now.test[i] : tr->definite[i],
               after = tr->next.test[i];
        if ((EVENT_TERMINAL & 1u << i) || !ric_event_watched(tr, i)) continue;
        bool shared = flat && (EVENT_EXTREMA & 1u << i);
        if (shared) before = tr->definite[i] = -before;
        /* at a duplicate the kernels of all symmetries open at once, like high powers of the
         * distance */
        if ((EVENT_SINGULAR & 1u << i) && (arrived || image || repeated)) continue;
        if (!(before * after < 0)) continue;
        double x = i == RIC_TEST_DET
                       ? at
                       : ric_event_bridge_root(tr, &q, i, 0, h, before, shared ? at : NAN);
        if (arrived && x >= at) continue;
        roots[n++] = (ric_event_root){i, x};
    }
    for (int k = 0; k < tr->n_resonance; k++)
        n += cross_resonance(tr, &q, k, at, arrived ? at : h, h, roots + n);
    status = keep_roots(tr, &q, h, roots, n);
    if (!status) status = ric_event_asked_cross(tr, first, arrived ? at : h, h);
    for (int i = 0; i < RIC_N_TEST; i++) /* no sign is expected */
        if ((image || repeated) && (EVENT_SINGULAR & 1u << i))
            tr->definite[i] = tr->next.test[i] = 0;
    if (arrived && !status) ric_event_bridge_station(tr, &q, at, h, &tr->mid);
    free(q.u);
    return status;
}
