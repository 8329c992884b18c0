#include "event.h"

#include <stdlib.h>
#include <string.h>

#include "arrival.h"
#include "crossing_gap.h"
#include "event_parts.h"
#include "motion.h"
#include "status.h"

#define BEFORE (1 - 1e-4) /* just before a grazing the functions that are singular there still have their sign */
/* A step, relative to the size of the orbit, in which a factor of the map that changes its sign without a zero has
 * jumped. */
#define JUMP 1e-7
/* How far the sign of a factor that was never seen may come out of rounding in one step, over the least that is
 * seen. */
#define EMERGED 100
/* Looks for a better place of an arrival: on sharp turns the zero of the determinant is off. */
#define ASIDE_STEPS 3
/* Part of the largest step within which two pairs that pass a resonance count as one event. */
#define TOGETHER 1e-6
/* Of the size: the start of a closed branch again. */
#define SAME_PLACE 1e-8
/* The same at a branch point, of the step over it: the cubic is off by its fourth power, and another branch through
 * that point has another heading. */
#define ON_CUBIC 1e-4
/* Attempts to place a step over it well: the secant has settled by then, or the determinant only touches zero. */
#define APPROACHES 4
/* What may keep two branches apart (ric_crossing_gap) that cross: rounding. */
#define CROSSED 1e-11
/* dE/ds at a multiplication, of that at 1/2 CROSSING beside it, below which it counts as zero. */
#define ON_SLOPE 0.02

#define STRETCHES 3 /* of a step, between its extrema of energy and of period */
#define ROUNDING 1e-12 /* relative distance from what was asked for at which orbits are not told apart by shorter
                        * steps */

static const unsigned terminal = 1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH | 1u << RIC_TEST_FLIGHT |
                                 1u << RIC_TEST_E_MAX | 1u << RIC_TEST_E_MIN | 1u << RIC_TEST_F_MAX |
                                 1u << RIC_TEST_F_MIN;
/* What ghosts are allowed to do: gaps are penetrated, impacts have the wrong direction. Where the speed of one of them
 * passes through zero the singular functions change sign without a zero. */
static const unsigned free_of_ghosts = 1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH | 1u << RIC_TEST_A |
                                       1u << RIC_TEST_B | 1u << RIC_TEST_D;
/* Functions that vanish at an extremum. */
static const unsigned extrema = 1u << RIC_TEST_SLOPE | 1u << RIC_TEST_PERIOD;

static bool watched(const ric_trace *tr, int test)
{
    if (tr->ignore & 1u << test) return false;
    /* short of an orbit of fewer periods the determinant is rounding, and its zero nothing that could be crossed */
    if (test == RIC_TEST_DET && tr->longest < HUGE_VAL) return false;
    return !(tr->limits->ghost && (free_of_ghosts & 1u << test));
}

static int resonances_below(const ric_trace *tr, double rho)
{
    return ric_resonance_below(tr->resonances, tr->n_resonance, rho);
}

static bool all_finite(int n, const double *x)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(x[i])) return false;
    return true;
}

/* Whether the parabola through three values of rho passes a resonance within the last step and comes back. */
static bool turns_at_resonance(const ric_trace *tr, double f0, double f1, double f2, double x0, double x2)
{
    double C = ((f2 - f1) / x2 - (f0 - f1) / x0) / (x2 - x0), B = (f2 - f1) / x2 - C * x2, vertex = -B / (2 * C);
    if (!isfinite(f0 + f1 + f2) || !(vertex > 0 && vertex < x2)) return false;
    double extreme = f1 + B * vertex / 2, end = fabs(f1 - extreme) < fabs(f2 - extreme) ? f1 : f2;
    extreme += 0.4 * (extreme - end); /* what the cubic term may add */
    return resonances_below(tr, extreme) != resonances_below(tr, end);
}

/* Distance of a zero of the bordered determinant in this step or close behind its end; infinite if there is none. */
static double crossing_ahead(const ric_trace *tr, double h)
{
    double fa = tr->now.test[RIC_TEST_DET], fb = tr->next.test[RIC_TEST_DET], x = h * fa / (fa - fb);
    return watched(tr, RIC_TEST_DET) && !tr->avoided && x > 0 && x < h + CROSSING / 4 * tr->chain->scale ? x : HUGE_VAL;
}

/* Behind a multiplication of high order the signs of the factors are lost in rounding for a long way, and the first
 * that is seen may be that behind a zero: it has to be seen soon after it emerges. */
static bool emerges_late(const ric_trace *tr)
{
    for (int i = 0; i < 3; i++) {
        int test = RIC_TEST_A + i;
        bool lost = tr->definite[test] == 0 && tr->past.test[test] == 0 && tr->now.test[test] == 0;
        if (watched(tr, test) && lost && fabs(tr->next.test[test]) > EMERGED * tr->now.hidden[i]) return true;
    }
    return false;
}

bool ric_event_suspicious(const ric_trace *tr, double h)
{
    const ric_station *p = &tr->past, *a = &tr->now, *b = &tr->next;
    if (!tr->has_past || h < 1e-5 * tr->step_max || crossing_ahead(tr, h) < HUGE_VAL) return false;
    if (emerges_late(tr)) return true;
    double x0 = p->s - a->s, x2 = b->s - a->s;
    int pairs = 2 * tr->floquet.n_pair;
    bool known = all_finite(pairs, p->own) && all_finite(pairs, a->own) && all_finite(pairs, b->own);
    for (int i = 0; known && i < tr->floquet.n_pair && !(tr->ignore & EVENT_SINGULAR); i++)
        if (turns_at_resonance(tr, p->own[2 * i], a->own[2 * i], b->own[2 * i], x0, x2)) return true;
    for (int i = 0; i < RIC_N_TEST; i++) {
        double f0 = p->test[i], f1 = a->test[i], f2 = b->test[i];
        if (!watched(tr, i) || f1 * f2 <= 0 || !isfinite(f0 + f1 + f2)) continue;
        /* f = f1 + B x + C x^2 */
        double C = ((f2 - f1) / x2 - (f0 - f1) / x0) / (x2 - x0), B = (f2 - f1) / x2 - C * x2, vertex = -B / (2 * C);
        if (!(vertex > 0 && vertex < x2)) continue;
        double bottom = f1 + B * vertex / 2, end = fmin(fabs(f1), fabs(f2));
        /* towards zero, and the cubic term could make up for what is left; what falls by orders beside a grazing dips
         * far below, and means nothing */
        if (bottom * f1 < 0.4 * end * fabs(f1) && (fabs(bottom) < fabs(f1) || !(EVENT_SINGULAR & 1u << i))) return true;
    }
    return false;
}

/* -------------------------------------------------------------------- keeping */

static ric_status fill_event(const ric_trace *tr, int test, const ric_station *p, ric_event *out)
{
    size_t bytes = (size_t)tr->chain->n_unknown * sizeof(double);
    *out = (ric_event){.test = test, .s = p->s, .u = malloc(bytes), .t = malloc(bytes)};
    if (!out->u || !out->t) {
        free(out->u);
        free(out->t);
        out->u = out->t = NULL;
        return ric_fail(RIC_E_NOMEM, "no memory for an event");
    }
    memcpy(out->u, p->u, bytes);
    memcpy(out->t, p->t, bytes);
    return RIC_OK;
}

ric_status ric_event_keep(ric_trace *tr, int test, const ric_station *p)
{
    if (tr->n_event == tr->event_capacity) {
        int capacity = tr->event_capacity ? 2 * tr->event_capacity : 8;
        ric_event *grown = realloc(tr->events, (size_t)capacity * sizeof *grown);
        if (!grown) return ric_fail(RIC_E_NOMEM, "no memory for %d events", capacity);
        tr->events = grown;
        tr->event_capacity = capacity;
    }
    ric_status status = fill_event(tr, test, p, &tr->events[tr->n_event]);
    if (!status) tr->n_event++;
    return status;
}

ric_status ric_event_arrive(ric_trace *tr, const ric_station *p)
{
    ric_status status = fill_event(tr, RIC_TEST_DET, p, &tr->end);
    tr->arrival = true;
    tr->stop = RIC_STOP_JUNCTION;
    tr->why = RIC_WHY_NONE;
    return status ? status : ric_trace_keep(tr, p);
}

/* ------------------------------------------------------------------- the step */

static void end_by(ric_trace *tr, int test)
{
    static const ric_why edge[RIC_N_TEST] = {
        [RIC_TEST_E_MAX] = RIC_WHY_ENERGY_MAX, [RIC_TEST_E_MIN] = RIC_WHY_ENERGY_MIN,
        [RIC_TEST_F_MAX] = RIC_WHY_FREQUENCY_MAX, [RIC_TEST_F_MIN] = RIC_WHY_FREQUENCY_MIN};
    tr->stop = edge[test] ? RIC_STOP_WINDOW : RIC_STOP_JUNCTION;
    tr->why = edge[test];
}

/* Back at the orbit `home`, at the arclength s, going the same way as `heading` from there. */
static bool reaches(ric_trace *tr, double h, const double *home, const double *heading, double *s)
{
    int size = tr->chain->n_unknown;
    double along = 0, across = 0;
    for (int i = 0; i < size; i++) along += (home[i] - tr->now.u[i]) * tr->now.t[i];
    if (!(along > 0 && along <= h)) return false;
    for (int i = 0; i < size; i++) {
        double d = home[i] - tr->now.u[i] - along * tr->now.t[i];
        across += d * d;
    }
    if (sqrt(across) > 0.3 * h) return false;
    double distance = 0, first = along, most = SAME_PLACE * tr->chain->scale, *u = tr->mid.u;
    const double *t = tr->next.t;
    /* a branch point itself, as which many branches start: the cubic knows it */
    if (tr->now.test[RIC_TEST_DET] * tr->next.test[RIC_TEST_DET] < 0) {
        ric_event_cubic(tr, along, h, u);
        along = 0;
        for (int i = 0; i < size; i++) along += (home[i] - u[i]) * t[i];
        for (int i = 0; i < size; i++) u[i] += along * t[i];
        most = fmax(most, ON_CUBIC * h);
    } else {
        bool good = false;
        if (ric_event_solve(tr, along, h, &tr->mid, &good) || !good) return false;
        t = tr->mid.t;
    }
    for (int i = 0; i < size; i++) distance = fmax(distance, fabs(u[i] - home[i]));
    if (!(distance < most && ric_dot(size, t, heading) > 0.5)) return false;
    *s = tr->now.s + (tr->next.s - tr->now.s) * (first / h);
    return true;
}

/* Back at the start, at the arclength s; `home` [n_unknown] is the start once more. From a centre to a rest under a
 * power law an orbit shows its image x -> -x half a period on, which is the same orbit: there the way round a closed
 * branch may end with the other sign. */
static bool closes(ric_trace *tr, double h, double *home, double *s)
{
    const ric_chain *c = tr->chain;
    int size = c->n_unknown;
    double heading[size];
    if (tr->n_point < 8) return false;
    memcpy(home, tr->start_u, (size_t)size * sizeof *home);
    if (reaches(tr, h, home, tr->start_t, s)) return true;
    if (!c->model->smooth || c->start != RIC_MIRROR_CENTRE || c->end != RIC_MIRROR_REST) return false;
    for (int i = 0; i < size; i++) {
        double sign = i == c->n_start ? 1 : -1; /* the time, and states before and after it */
        home[i] = sign * tr->start_u[i];
        heading[i] = sign * tr->start_t[i];
    }
    return reaches(tr, h, home, heading, s);
}

/* Ends a closed branch with the point that it began with; what lies beyond was met at the start. */
static ric_status close_up(ric_trace *tr, const double *home, double s)
{
    double slack = SAME_PLACE * tr->chain->scale;
    for (; tr->n_event > 0 && tr->events[tr->n_event - 1].s > s + slack; tr->n_event--) {
        free(tr->events[tr->n_event - 1].u);
        free(tr->events[tr->n_event - 1].t);
    }
    tr->stop = RIC_STOP_CLOSED;
    tr->why = RIC_WHY_CLOSED;
    memcpy(tr->mid.u, home, (size_t)tr->chain->n_unknown * sizeof *home);
    ric_status status = ric_trace_fill(tr, s, &tr->mid);
    return status ? status : ric_trace_keep(tr, &tr->mid);
}

typedef struct { int test; double x; } root;

static int by_place(const void *a, const void *b)
{
    const root *p = a, *q = b;
    return p->x < q->x ? -1 : p->x > q->x ? 1 : p->test - q->test;
}

/* All zeros of the tests in `which` up to distance `to`, whose functions there are `end`. */
static ric_status find_roots(ric_trace *tr, unsigned which, double to, const double *end, double h, root *roots, int *n,
                             bool *retry)
{
    for (int i = 0; i < RIC_N_TEST; i++) {
        double fa = tr->now.test[i], fb = end[i], x;
        bool zero;
        if (!(which & 1u << i) || !watched(tr, i)) continue;
        if (fa == 0 && fb * tr->definite[i] < 0) { /* the sign changed where rounding hid it: as near as can be told */
            roots[(*n)++] = (root){i, 0};
            continue;
        }
        if (!(fa * fb < 0)) continue;
        ric_status status = ric_event_locate(tr, i, 0, fa, to, fb, h, &x, &zero);
        if (status) return status;
        if (!zero) {
            /* the factors of the map may jump where rounding hides them; in a step this short nothing else can have
             * happened */
            if ((EVENT_SINGULAR & 1u << i) && h < JUMP * tr->chain->scale) continue;
            *retry = true;
            return RIC_OK;
        }
        roots[(*n)++] = (root){i, x};
    }
    return RIC_OK;
}

/* Arranges for a short step with the crossing in its middle, and for no point close to one, where all but the
 * determinant is rounding; false when all is well. */
static bool approach_crossing(ric_trace *tr, double h)
{
    double x = crossing_ahead(tr, h), length = CROSSING * tr->chain->scale, step = fmax(2 * x, length / 2);
    if (x == HUGE_VAL || (h > 0.7 * step && h < 1.4 * step && h < 3 * length) || ++tr->approaches > APPROACHES)
        return false;
    tr->wanted = x > 1.1 * length ? fmin(x - length / 2, 0.9 * h) : step;
    tr->after = length;
    return true;
}

/* Functions that are looked at a little before an end of kind `test`: the factors of the map, and where a contact of a
 * spring shrinks to nothing dE/ds and dT/ds, which vanish with it. */
static unsigned late_at(const ric_trace *tr, int test)
{
    return EVENT_SINGULAR | (tr->chain->model->springs && test == RIC_TEST_APPROACH ? extrema : 0);
}

/* The far end of the branch, if one of the functions `which` that end it vanishes in this step: its test, or -1, and
 * its distance. `limit` holds the test functions there, the singular ones a little before. */
static ric_status find_end(ric_trace *tr, unsigned which, double h, int *test, double *end, double *limit, bool *retry)
{
    root roots[RIC_N_TEST];
    int n = 0;
    bool good;
    *test = -1;
    *end = h;
    memcpy(limit, tr->next.test, sizeof tr->next.test);
    ric_status status = find_roots(tr, which, h, limit, h, roots, &n, retry);
    if (status || *retry || !n) return status;
    qsort(roots, (size_t)n, sizeof *roots, by_place);
    *test = roots[0].test;
    *end = roots[0].x;
    if ((status = ric_event_solve(tr, *end, h, &tr->mid, &good))) return status;
    memcpy(limit, tr->mid.test, sizeof tr->mid.test);
    if ((status = ric_event_solve(tr, *end * BEFORE, h, &tr->mid, &good))) return status;
    for (int i = 0; i < RIC_N_TEST; i++)
        if (late_at(tr, *test) & 1u << i) limit[i] = tr->mid.test[i];
    return RIC_OK;
}

/* ---------------------------------------------------------- what was asked for */

/* The point at distance x: solved, or in a step over a branch point, where nothing can be, on the cubic. */
static ric_status look(ric_trace *tr, bool solve, double x, double h, ric_station *out, bool *good)
{
    *good = true;
    if (solve) return ric_event_solve(tr, x, h, out, good);
    ric_event_cubic(tr, x, h, out->u);
    memcpy(out->t, tr->now.t, (size_t)tr->chain->n_unknown * sizeof *out->t);
    return ric_trace_fill(tr, tr->now.s + (tr->next.s - tr->now.s) * (x / h), out);
}

static double bisect_cubic(ric_trace *tr, int test, double a, double fa, double b, double h)
{
    bool good;
    for (int i = 0; i < LOCATE_STEPS; i++) {
        look(tr, false, (a + b) / 2, h, &tr->mid, &good);
        if ((ric_event_value(tr, test, &tr->mid) < 0) == (fa < 0)) a = (a + b) / 2;
        else b = (a + b) / 2;
    }
    return (a + b) / 2;
}

/* Passages between the distances xa and xb, at which what was asked for is `before` and `after` away, with no extremum
 * in between. A value met exactly counts as above, so that it is found in one of the two steps that end there. */
static ric_status find_monotonic(ric_trace *tr, bool solve, double xa, double xb, const double *before,
                                 const double *after, double h, root *roots, int *n, bool *retry)
{
    /* on a horizontal branch the frequency is one number but for rounding, and passes nothing */
    bool horizontal = tr->now.test[RIC_TEST_PERIOD] == 0 && tr->next.test[RIC_TEST_PERIOD] == 0;
    for (int k = 0; k < tr->limits->n_asked; k++) {
        int test = RIC_N_TEST + tr->n_resonance + k;
        double fa = before[k], fb = after[k], x = xb;
        bool zero = true;
        if ((fa < 0) == (fb < 0) || (horizontal && tr->limits->asked[k].frequency)) continue;
        if (!solve) x = bisect_cubic(tr, test, xa, fa, xb, h);
        else {
            ric_status status = ric_event_locate(tr, test, xa, fa, xb, fb, h, &x, &zero);
            if (status) return status;
        }
        if (!zero && fmax(fabs(fa), fabs(fb)) > ROUNDING) {
            *retry = true;
            return RIC_OK;
        }
        roots[(*n)++] = (root){test, zero ? x : xb};
    }
    return RIC_OK;
}

static void distances(const ric_trace *tr, const ric_station *p, double *out)
{
    for (int k = 0; k < tr->limits->n_asked; k++) out[k] = ric_event_value(tr, RIC_N_TEST + tr->n_resonance + k, p);
}

/* Where what was asked for is passed up to distance `to`, between the extrema of energy and period among the *n roots
 * known: so a value passed twice, on both sides of an extremum, is found twice. Room for STRETCHES * n_asked more
 * roots. */
static ric_status find_asked(ric_trace *tr, bool solve, double to, double h, root *roots, int *n, bool *retry)
{
    int known = *n;
    double from = 0, f[2][RIC_ASKED_MAX];
    if (tr->limits->n_asked == 0) return RIC_OK;
    qsort(roots, (size_t)known, sizeof *roots, by_place);
    distances(tr, &tr->now, f[0]);
    for (int i = 0; i <= known && !*retry; i++) {
        if (i < known && roots[i].test != RIC_TEST_SLOPE && roots[i].test != RIC_TEST_PERIOD) continue;
        double x = i < known ? roots[i].x : to;
        bool good = true, last = i == known && to == h;
        ric_status status = last ? RIC_OK : look(tr, solve, x, h, &tr->mid, &good);
        if (status) return status;
        distances(tr, last ? &tr->next : &tr->mid, f[1]);
        if (!(*retry = !good)) status = find_monotonic(tr, solve, from, x, f[0], f[1], h, roots, n, retry);
        if (status) return status;
        memcpy(f[0], f[1], sizeof f[0]);
        from = x;
    }
    return RIC_OK;
}

/* The same in a step over a branch point, whose other events have been kept, the first of them `first`. */
static ric_status cross_asked(ric_trace *tr, int first, double to, double h)
{
    int n = 0, known = tr->n_event - first;
    double scale = h / (tr->next.s - tr->now.s);
    root roots[known + STRETCHES * tr->limits->n_asked + 1];
    bool good, retry = false;
    for (; n < known; n++) roots[n] = (root){tr->events[first + n].test, (tr->events[first + n].s - tr->now.s) * scale};
    ric_status status = find_asked(tr, false, to, h, roots, &n, &retry);
    for (int i = known; i < n && !status; i++)
        if (!(status = look(tr, false, roots[i].x, h, &tr->mid, &good)))
            status = ric_event_keep(tr, roots[i].test, &tr->mid);
    return status;
}

/* ------------------------------------------------------- over a branch point */

/* Whether a branch comes to a corner of orbits that are their own image there: the family on which both contacts stay
 * together crosses. */
static bool meets_corner(const ric_trace *tr, const ric_bridge *q, double h, double *at)
{
    if (tr->limits->ghost || !watched(tr, RIC_TEST_FLIGHT) ||
        !(q->test[0][RIC_TEST_FLIGHT] * q->test[3][RIC_TEST_FLIGHT] < 0))
        return false;
    double x = ric_bridge_root(tr, q, RIC_TEST_FLIGHT, q->x[0], q->x[3], q->test[0][RIC_TEST_FLIGHT], NAN);
    if (x > *at + 0.05 * h) return false;
    *at = x;
    return true;
}

/* A step over a branch point (shorter than CROSSING): every inner function from the cubics. *end_test: why the branch
 * ends there, at *end: DET where it meets its own image, FLIGHT at a corner; -1 if it goes on. */
static ric_status cross(ric_trace *tr, double h, int *end_test, double *end, bool *retry)
{
    ric_bridge q;
    root roots[RIC_N_TEST + tr->n_resonance];
    int n = 0;
    int first = tr->n_event;
    ric_status status = ric_bridge_build(tr, h, &q);
    *end_test = -1;
    if ((*retry = status == RIC_E_NUMERIC && tr->avoided)) return RIC_OK;
    if (status) return status;
    double at = ric_bridge_root(tr, &q, RIC_TEST_DET, q.x[0], q.x[3], q.test[0][RIC_TEST_DET], NAN);
    if (meets_corner(tr, &q, h, &at)) *end_test = RIC_TEST_FLIGHT;
    ric_bridge_station(tr, &q, at, h, &tr->mid);
    /* a neighbour on the side where there is more room: close by it is lost in rounding */
    int far = at - q.x[0] > q.x[3] - at ? 0 : 3;
    const double *beside = q.u + far * tr->chain->n_unknown;
    for (int i = 0; i < ASIDE_STEPS && *end_test < 0; i++) {
        double aside, x;
        if (ric_arrival_meets(tr, tr->mid.u, beside, &aside)) *end_test = RIC_TEST_DET;
        else if ((x = at + aside * (q.x[far] - at)) == at || !(x > q.x[1] && x < q.x[2])) break;
        else ric_bridge_station(tr, &q, at = x, h, &tr->mid);
    }
    bool arrived = *end_test >= 0;
    if (arrived) *end = at;
    bool repeated = ric_arrival_repeats(tr, tr->mid.u);
    /* two branches that only come close: the step has changed from one to the other */
    if (!arrived && !repeated && !(ric_crossing_gap(tr->chain, tr->mid.u) < CROSSED)) {
        free(q.u);
        *retry = tr->avoided = true;
        return RIC_OK;
    }
    /* Where a branch meets its own image, and at a multiplication of order 4 and more, dE/ds and dT/ds vanish with the
     * determinant: that zero belongs to the one junction, and beyond it the other sign is the one to expect. A family
     * of order 3 passes on a slope; its extremum lies aside and is a junction of its own. */
    bool image = !arrived && ric_arrival_passes(tr, tr->mid.u, beside);
    bool flat = arrived || image ||
                (repeated && fabs(ric_bridge_test(tr, &q, RIC_TEST_SLOPE, at)) <
                                 ON_SLOPE * fmax(fabs(q.test[0][RIC_TEST_SLOPE]), fabs(q.test[3][RIC_TEST_SLOPE])));
    for (int i = 0; i < RIC_N_TEST; i++) {
        double before = tr->now.test[i] != 0 ? tr->now.test[i] : tr->definite[i], after = tr->next.test[i];
        if ((terminal & 1u << i) || !watched(tr, i)) continue;
        bool shared = flat && (extrema & 1u << i);
        if (shared) before = tr->definite[i] = -before;
        /* at a duplicate the kernels of all symmetries open at once, like high powers of the distance */
        if ((EVENT_SINGULAR & 1u << i) && (arrived || image || repeated)) continue;
        if (!(before * after < 0)) continue;
        double x = i == RIC_TEST_DET ? at : ric_bridge_root(tr, &q, i, 0, h, before, shared ? at : NAN);
        if (arrived && x >= at) continue;
        roots[n++] = (root){i, x};
    }
    for (int k = 0; k < tr->n_resonance; k++) {
        double before = ric_event_value(tr, RIC_N_TEST + k, &tr->now),
               after = ric_event_value(tr, RIC_N_TEST + k, &tr->next);
        if (!(before * after < 0)) continue;
        double x = ric_bridge_root(tr, &q, RIC_N_TEST + k, 0, h, before, NAN);
        if (!arrived || x < at) roots[n++] = (root){RIC_N_TEST + k, x};
    }
    qsort(roots, (size_t)n, sizeof *roots, by_place);
    for (int i = 0; i < n && !status; i++) {
        ric_bridge_station(tr, &q, roots[i].x, h, &tr->mid);
        status = ric_event_keep(tr, roots[i].test, &tr->mid);
    }
    if (!status) status = cross_asked(tr, first, arrived ? at : h, h);
    for (int i = 0; i < RIC_N_TEST; i++)
        /* no sign is expected */
        if ((image || repeated) && (EVENT_SINGULAR & 1u << i)) tr->definite[i] = tr->next.test[i] = 0;
    if (arrived && !status) ric_bridge_station(tr, &q, at, h, &tr->mid);
    free(q.u);
    return status;
}

/* All resonances that a pair passes up to distance `to`, where the pairs are those of `end`; roots has room for every
 * one. *blind grows by the distance, if some pair is lost in rounding. */
static ric_status find_resonances(ric_trace *tr, double to, const double *end, double h, root *roots, int *n,
                                  double *blind, bool *retry)
{
    const double *start = tr->now.own;
    int n_pair = tr->floquet.n_pair, known = *n;
    if (tr->ignore & EVENT_SINGULAR) return RIC_OK; /* at a grazing the multipliers have no bound */
    if (!all_finite(2 * n_pair, start) || !all_finite(2 * n_pair, end)) {
        if (n_pair && tr->n_resonance) *blind += to;
        return RIC_OK;
    }
    for (int i = 0; i < n_pair; i++) {
        int a = resonances_below(tr, start[2 * i]), b = resonances_below(tr, end[2 * i]);
        for (int k = a < b ? a : b; k < (a < b ? b : a); k++) {
            double value = tr->resonances[k].rho, x;
            double fa = ric_resonance_test(start, n_pair, value), fb = ric_resonance_test(end, n_pair, value);
            bool zero, listed = false;
            for (int j = known; j < *n; j++) listed |= roots[j].test == RIC_N_TEST + k;
            if (listed) continue;
            if (!(fa * fb < 0)) { /* two pairs pass the same one: a step for each, if any step tells them apart */
                *retry = start[2 * i + 1] == 0 && end[2 * i + 1] == 0 && h > TOGETHER * tr->step_max;
                if (*retry) return RIC_OK;
                continue;
            }
            ric_status status = ric_event_locate(tr, RIC_N_TEST + k, 0, fa, to, fb, h, &x, &zero);
            if (status) return status;
            if (!zero && h >= JUMP * tr->chain->scale) { /* in a shorter step its place is known well enough: the
                                                          * junction is solved anew */
                *retry = true;
                return RIC_OK;
            }
            roots[(*n)++] = (root){RIC_N_TEST + k, x};
        }
    }
    return RIC_OK;
}

/* The pairs `own` at the farthest place before an end, at most *to, where none is lost in rounding; what is left of the
 * way in *blind. */
static ric_status look_before(ric_trace *tr, double h, double *to, double *own, double *blind)
{
    int size = 2 * tr->floquet.n_pair;
    double end = *to;
    bool good;
    *to *= BEFORE;
    for (double back = 4 * (1 - BEFORE); !all_finite(size, own) && back < 0.5; back *= 4) {
        ric_status status = ric_event_solve(tr, end * (1 - back), h, &tr->mid, &good);
        if (status) return status;
        memcpy(own, tr->mid.own, (size_t)size * sizeof *own);
        *blind = end * back;
        *to = end - *blind;
    }
    return RIC_OK;
}

static ric_status inner_events(ric_trace *tr, double h, bool ends, double to, const double *limit, unsigned late,
                               bool *retry)
{
    int n = 0, size = 2 * tr->floquet.n_pair;
    root roots[RIC_N_TEST + tr->n_resonance + STRETCHES * tr->limits->n_asked];
    double own[size + 1], blind = 0;
    bool good;
    /* at an end the last look was a little before it */
    memcpy(own, ends ? tr->mid.own : tr->next.own, (size_t)size * sizeof *own);
    unsigned inner = ~terminal & ((1u << RIC_N_TEST) - 1);
    ric_status status = find_roots(tr, inner & ~late, to, limit, h, roots, &n, retry);
    if (!status && !*retry) status = find_roots(tr, inner & late, ends ? to * BEFORE : to, limit, h, roots, &n, retry);
    double known = to; /* for the multipliers */
    if (!status && !*retry && ends && tr->n_resonance) status = look_before(tr, h, &known, own, &blind);
    if (!status && !*retry) status = find_resonances(tr, known, own, h, roots, &n, &blind, retry);
    if (!status && !*retry) status = find_asked(tr, true, to, h, roots, &n, retry);
    if (status || *retry) return status;
    tr->blind += blind;
    qsort(roots, (size_t)n, sizeof *roots, by_place);
    for (int i = 0; i < n && !status; i++)
        if (!(status = ric_event_solve(tr, roots[i].x, h, &tr->mid, &good)) &&
            !(status = ric_event_keep(tr, roots[i].test, &tr->mid)))
            status = ric_trace_keep(tr, &tr->mid); /* a stored point, so that extremes of a branch are among its
                                                    * points */
    return status;
}

ric_status ric_event_find(ric_trace *tr, double h, bool *done, bool *retry)
{
    int test;
    double end, limit[RIC_N_TEST];
    bool good, crossed = tr->now.test[RIC_TEST_DET] * tr->next.test[RIC_TEST_DET] < 0 && watched(tr, RIC_TEST_DET);
    if ((*retry = approach_crossing(tr, h))) return RIC_OK;
    double home[tr->chain->n_unknown], s;
    bool closed = closes(tr, h, home, &s);
    /* a corner next to a branch point is read off cubics with it: close by nothing can be solved */
    double flight[2] = {tr->now.test[RIC_TEST_FLIGHT], tr->next.test[RIC_TEST_FLIGHT]};
    unsigned which = crossed && !tr->limits->ghost && flight[0] * flight[1] < 0 ? terminal & ~(1u << RIC_TEST_FLIGHT)
                                                                                : terminal;
    ric_status status = find_end(tr, which, h, &test, &end, limit, retry);
    if (status || *retry) return status;
    if (test >= 0 && crossed) crossed = tr->now.test[RIC_TEST_DET] * limit[RIC_TEST_DET] < 0;
    int read = -1; /* the end, read off cubics */
    if (crossed) status = cross(tr, h, &read, &end, retry);
    else status = inner_events(tr, h, test >= 0, end, limit, late_at(tr, test), retry);
    if (status || *retry) return status;
    if (test < 0 && !closed && read < 0) return RIC_OK;
    *done = true;
    if (read >= 0) {
        test = read;
        tr->arrival = read == RIC_TEST_DET;
        end_by(tr, test);
        if (tr->arrival && (status = ric_arrival_settle(tr->chain, tr->mid.u))) return status;
        if ((status = ric_trace_fill(tr, tr->mid.s, &tr->mid))) return status;
        tr->mid.row.stable = RIC_STABLE_UNDECIDED; /* two branches meet there */
    } else if (test < 0) {
        return close_up(tr, home, s);
    } else {
        if ((status = ric_event_solve(tr, end, h, &tr->mid, &good))) return status;
        tr->mid.solved &= good;
        end_by(tr, test);
    }
    if ((status = fill_event(tr, test, &tr->mid, &tr->end))) return status;
    return ric_trace_keep(tr, &tr->mid);
}
