#include "response_trace.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define FIRST 0.2       /* of the longest step: the first one */
#define SHORTEST 1e-7   /* of the longest step: where a curve is given up */
#define TURN 0.97       /* least cosine between the directions at the ends of a step */
#define STRAIGHT 0.995  /* from on which steps grow */
#define ASIDE 0.3       /* of a step: what the corrector may move */
#define SAME 1e-7       /* relative: an orbit met again */
#define LOCATED 1e-13   /* of a step: where an event is */
#define NEAR_VALUE 1e-3 /* from 1 or -1, of a multiplier at a place where one passes it */
#define ON_CIRCLE 1e-4  /* multipliers at a place of Neimark and Sacker */
#define BESIDE 0.1      /* of a step: how far from where it was seen a branch point is */
/* ARRIVED: relative: an orbit that is its own image; there it is known to the third root of
 * rounding */
#define ARRIVED 1e-3
#define NEARER 0.1 /* how much nearer to that than the ends of its step it must be */
#define SHORT                                                                                      \
    0.9999 /* of a step that ends in a grazing: beyond it multipliers come back from infinity with \
              other signs */
#define FINEST 1e-3  /* of the longest step: events that lie closer are not told apart */
#define UNKNOWN 1e-6 /* multipliers nearer to the circle count on neither side */
#define OPEN 0.5     /* gaps wider than that part of the clearance tell nothing */

enum { QUICK = 5, LOCATE_MOST = 100, STEP_WORK = 10000 /* multiplications of a step, about */ };

/* ------------------------------------------------------------------- orbits */

static void free_orbit(ric_response_orbit *orbit)
{
    free(orbit->u);
    orbit->u = NULL;
}

void ric_response_trace_free(ric_response_trace *t)
{
    if (!t) return;
    for (int i = 0; i < t->n_point; i++) free_orbit(&t->points[i]);
    for (int i = 0; i < t->n_event; i++) free_orbit(&t->events[i].at);
    free(t->points);
    free(t->events);
    ric_force_orbit_free(t->shape);
    free(t);
}

void ric_response_trace_put(const ric_response_orbit *from, ric_force_orbit *o)
{
    memcpy(o->u, from->u, (size_t)o->N * (size_t)o->m * sizeof *o->u);
    o->drive = from->drive;
    o->residual = from->residual;
}

ric_status ric_response_trace_margin(const ric_force_orbit *o, double *margin)
{
    *margin = OPEN;
    for (int k = 0; k < o->N; k++) {
        if (o->events) *margin = fmin(*margin, ric_force_motion_speed(o, k));
        if (!(ric_force_orbit_tau(o, k) > 0)) *margin = fmin(*margin, -OPEN);
        for (int f = 0; f < o->medium->model->n_face; f++) {
            double highest, time;
            ric_status status = ric_force_motion_highest(o, k, f, 1 - *margin, &highest, &time);
            if (status) return status;
            *margin = fmin(*margin, 1 - highest);
        }
    }
    return RIC_OK;
}

/* ------------------------------------------------------------------- probes */

/* What is known at one orbit: signs of the products, scaled so that none overflows. */
typedef struct {
    ric_response_orbit orbit;
    double *full; /* [N m + 1] direction of all unknowns */
    double one, minus, pairs;
} probe;

typedef struct {
    ric_force_orbit *o;
    const ric_response_trace_options *options;
    size_t all;
    ric_response_trace *out;
} tracer;

static bool probe_create(const tracer *t, probe *p)
{
    const size_t m = (size_t)t->o->m, n = (size_t)t->o->n;
    *p = (probe){0};
    p->orbit.u = ric_calloc(2 * t->all + 1 + m + 1 + 4 * n, sizeof *p->orbit.u);
    if (!p->orbit.u) return false;
    p->orbit.tangent = p->orbit.u + t->all;
    p->orbit.multipliers = p->orbit.tangent + m + 1;
    p->full = p->orbit.multipliers + 4 * n;
    return true;
}

static void products(int size, const double *mu, probe *p)
{
    double _Complex one = 1, minus = 1, pairs = 1;
    for (int i = 0; i < size; i++) {
        const double _Complex a = mu[2 * i] + I * mu[2 * i + 1];
        one *= (a - 1) / (1 + cabs(a));
        minus *= (a + 1) / (1 + cabs(a));
        for (int j = 0; j < i; j++) {
            const double _Complex b = a * (mu[2 * j] + I * mu[2 * j + 1]);
            pairs *= (b - 1) / (1 + cabs(b));
        }
    }
    p->one = creal(one);
    p->minus = creal(minus);
    p->pairs = creal(pairs);
}

/* Everything at the orbit in t->o, which is solved; row [m + 1] gives the sense of the direction.
 */
static bool look(const tracer *t, const double *row, double arclength, probe *p)
{
    ric_force_orbit *o = t->o;
    const int m = o->m;
    ric_response_orbit *at = &p->orbit;
    if (!ric_force_orbit_tangent(o, t->options->along, t->options->scale, row, p->full))
        return false;
    memcpy(at->u, o->u, t->all * sizeof *at->u);
    memcpy(at->tangent, p->full, (size_t)m * sizeof *at->tangent);
    at->tangent[m] = p->full[t->all];
    at->drive = o->drive;
    at->residual = o->residual;
    at->arclength = arclength;
    if (ric_force_motion_multipliers(o, at->multipliers, &at->rounding, NULL)) return false;
    at->stable = ric_force_motion_judge(o->n, at->multipliers, at->rounding, &at->largest);
    products(2 * o->n, at->multipliers, p);
    return !ric_response_trace_margin(o, &at->margin);
}

static double parameter(const tracer *t, const ric_response_orbit *at)
{
    return t->options->along == RIC_ALONG_OMEGA   ? at->drive.omega
           : t->options->along == RIC_ALONG_LEVEL ? at->drive.level
                                                  : at->drive.restitution;
}

/* The orbit a length h further along the direction at p, in t->o. */
static bool go(const tracer *t, const probe *p, double h, int *steps)
{
    ric_force_orbit *o = t->o;
    const int m = o->m;
    double *free_one = ric_force_orbit_parameter(o, t->options->along);
    ric_response_trace_put(&p->orbit, o);
    const double *row = p->orbit.tangent,
                 aim = ric_dot(m, row, o->u) + row[m] * *free_one / t->options->scale + h;
    for (size_t i = 0; i < t->all; i++) o->u[i] += h * p->full[i];
    *free_one += h * p->full[t->all] * t->options->scale;
    return ric_force_orbit_solve(o, t->options->along, t->options->scale, row, aim, steps);
}

/* Distance in the first unknowns and the parameter from u, of the orbit in t->o; phases modulo a
 * turn. */
static double apart(const tracer *t, const double *u, double value)
{
    const ric_force_orbit *o = t->o;
    double sum = 0;
    for (int i = 0; i < o->m; i++) {
        const double d = o->u[i] - u[i], off = i == 2 * o->n ? remainder(d, RIC_TWO_PI) : d;
        sum += off * off;
    }
    const double off = (*ric_force_orbit_parameter(t->o, t->options->along) - value) /
                       t->options->scale;
    return sqrt(sum + off * off);
}

static double size_of(const tracer *t, const probe *p)
{
    double sum = 1;
    for (int i = 0; i < 2 * t->o->n; i++) sum += p->orbit.u[i] * p->orbit.u[i];
    return sqrt(sum);
}

/* -------------------------------------------------------------------- events */

typedef enum { BY_FOLD, BY_ONE, BY_MINUS, BY_PAIRS, BY_MARGIN } reading;

static double read_probe(const tracer *t, const probe *p, reading what)
{
    switch (what) {
    case BY_FOLD: return p->orbit.tangent[t->o->m];
    case BY_ONE: return p->one;
    case BY_MINUS: return p->minus;
    case BY_PAIRS: return p->pairs;
    default: return p->orbit.margin;
    }
}

static bool look_at(const tracer *t, const probe *from, double h, probe *p)
{
    return go(t, from, h, NULL) && look(t, from->orbit.tangent, from->orbit.arclength + h, p);
}

/* Zero of a reading between `from`, h = 0, and h, where it is `last`; `p` is the orbit there.
 * Regula falsi with the halving of Illinois, and bisection where that is slow. Beside an orbit at
 * which curves cross Newton's method may not come to an end, and what is tried lies farther from
 * it.
 */
static bool locate(const tracer *t, const probe *from, reading what, double h, double last,
                   probe *p)
{
    double a = 0, fa = read_probe(t, from, what), b = h, fb = last;
    for (int k = 0; k < LOCATE_MOST; k++) {
        double c = k % 3 == 2 ? (a + b) / 2 : a + (b - a) * (fa / (fa - fb));
        if (!look_at(t, from, c, p)) {
            c = fabs(c - a) > fabs(b - c) ? (3 * a + b) / 4 : (a + 3 * b) / 4;
            if (!look_at(t, from, c, p)) return false;
        }
        const double f = read_probe(t, p, what);
        if (f == 0 || fabs(b - a) < LOCATED * h) return true;
        if ((f > 0) == (fb > 0)) {
            b = c;
            fb = f;
            if (k % 3 == 1) fa /= 2;
        } else {
            a = b;
            fa = fb;
            b = c;
            fb = f;
        }
    }
    return true;
}

static bool on_circle(const tracer *t, const probe *p)
{
    double nearest = INFINITY;
    for (int i = 0; i < 2 * t->o->n; i++) {
        const double re = p->orbit.multipliers[2 * i], im = p->orbit.multipliers[2 * i + 1];
        if (fabs(im) > ON_CIRCLE) nearest = fmin(nearest, fabs(hypot(re, im) - 1));
    }
    return nearest < ON_CIRCLE;
}

/* Whether a multiplier is near 1 or -1, as a zero of their product says; a sign also changes where
 * one is infinite. */
static bool has_multiplier(const tracer *t, const probe *p, double value)
{
    double nearest = INFINITY;
    for (int i = 0; i < 2 * t->o->n; i++)
        nearest = fmin(nearest,
                       hypot(p->orbit.multipliers[2 * i] - value, p->orbit.multipliers[2 * i + 1]));
    return nearest < NEAR_VALUE;
}

/* Whether a zero of a reading is the event that it stands for. */
static bool is_event(const tracer *t, const probe *p, reading what)
{
    if (what == BY_ONE || what == BY_MINUS) return has_multiplier(t, p, what == BY_ONE ? 1 : -1);
    return what != BY_PAIRS || on_circle(t, p);
}

/* Along the direction at a to other unknowns and value of the parameter; phases modulo a turn. */
static double way(const tracer *t, const probe *a, const double *u, double value)
{
    const int m = t->o->m;
    double sum = a->orbit.tangent[m] * (value - parameter(t, &a->orbit)) / t->options->scale;
    for (int i = 0; i < m; i++) {
        const double off = u[i] - a->orbit.u[i];
        sum += a->orbit.tangent[i] * (i == 2 * t->o->n ? remainder(off, RIC_TWO_PI) : off);
    }
    return sum;
}

/* From a place where a multiplier is 1 within its rounding to the branch point itself, if that lies
 * beside it. The direction stays: there are two at a branch point. */
static void settle_branch_point(const tracer *t, const probe *from, double h, probe *p)
{
    ric_force_orbit *o = t->o;
    ric_response_orbit *at = &p->orbit;
    double multipliers[4 * o->n], rounding;
    ric_response_trace_put(at, o);
    if (!ric_force_orbit_branch_point(o, t->options->along, t->options->scale) ||
        !(apart(t, at->u, parameter(t, at)) < BESIDE * h) ||
        ric_force_motion_multipliers(o, multipliers, &rounding, NULL))
        return;
    memcpy(at->u, o->u, t->all * sizeof *at->u);
    memcpy(at->multipliers, multipliers, sizeof multipliers);
    at->drive = o->drive;
    at->residual = o->residual;
    at->rounding = rounding;
    at->stable = ric_force_motion_judge(o->n, multipliers, rounding, &at->largest);
    at->arclength = from->orbit.arclength + way(t, from, o->u, parameter(t, at));
}

/* Doubles the room of an array that is full. */
static bool make_room(void **array, int n, int *room, size_t each)
{
    if (n < *room) return true;
    void *more = ric_realloc(*array, (size_t)(*room ? 2 * *room : 64) * each);
    if (!more) return false;
    *array = more;
    *room = *room ? 2 * *room : 64;
    return true;
}

/* How far the orbit is, relative, from one that repeats itself within its period or that is its own
 * mirror image; infinite where there is no such image to compare it with. */
static double asymmetry(const tracer *t, const ric_response_orbit *at)
{
    ric_force_orbit *o = t->o;
    const int size = 2 * o->n, images = ric_model_symmetric(o->medium->model) ? 2 : 1;
    double z[size], x[size], least = INFINITY;
    ric_response_trace_put(at, o);
    const double begin = ric_force_orbit_theta(o, 0) +
                         o->drive.omega * ric_force_orbit_tau(o, 0) / 2;
    if (ric_force_motion_strobe(o, begin, z)) return INFINITY;
    for (int i = 0; i < images; i++)
        for (int k = i ? 0 : 1; k < o->harmonic; k++) {
            double most = 0, length = 1;
            if (ric_force_motion_strobe(o, begin + RIC_TWO_PI * k + (i ? RIC_PI : 0), x)) continue;
            for (int j = 0; j < size; j++) {
                most = fmax(most, fabs(z[j] - (i ? -x[j] : x[j])));
                length = fmax(length, 1 + fabs(z[j]));
            }
            least = fmin(least, most / length);
        }
    return least;
}

/* Whether the curve, which turns at p between a and b, comes to an orbit with more symmetry there:
 * that of the curve which it left at its other end, or another one. Beyond, it is its own image. */
static bool arrives(const tracer *t, const probe *a, const probe *p, const probe *b)
{
    const double there = asymmetry(t, &p->orbit);
    return there < ARRIVED &&
           there < NEARER * fmin(asymmetry(t, &a->orbit), asymmetry(t, &b->orbit));
}

/* Multipliers outside the unit circle, -1: some are not known to be on either side. */
static int outside(const tracer *t, const probe *p)
{
    int count = 0;
    for (int i = 0; i < 2 * t->o->n; i++) {
        const double size = hypot(p->orbit.multipliers[2 * i], p->orbit.multipliers[2 * i + 1]);
        if (!(fabs(size - 1) > UNKNOWN + p->orbit.rounding)) return -1;
        count += size > 1;
    }
    return count;
}

/* Whether multipliers cross the circle between a and b otherwise than the events from `first` on
 * say: some lie so close that a step does not tell them apart. */
static bool unexplained(const tracer *t, const probe *a, const probe *b, int first)
{
    const int before = outside(t, a), behind = outside(t, b);
    int single = 0, pairs = 0;
    for (int i = first; i < t->out->n_event; i++) {
        const ric_response_kind kind = t->out->events[i].kind;
        single += kind == RIC_RESPONSE_FOLD || kind == RIC_RESPONSE_BRANCH_POINT ||
                  kind == RIC_RESPONSE_DOUBLING;
        pairs += kind == RIC_RESPONSE_NEIMARK_SACKER;
    }
    if (before < 0 || behind < 0) return false;
    const int change = abs(behind - before);
    return change > single + 2 * pairs || (change - single) % 2 != 0;
}

static void drop_events(tracer *t, int first, double beyond)
{
    ric_response_trace *out = t->out;
    int kept = first;
    for (int i = first; i < out->n_event; i++) {
        if (out->events[i].at.arclength > beyond) free_orbit(&out->events[i].at);
        else out->events[kept++] = out->events[i];
    }
    out->n_event = kept;
}

static bool keep_event(tracer *t, ric_response_kind kind, probe *p)
{
    ric_response_trace *out = t->out;
    if (!make_room((void **)&out->events, out->n_event, &out->room_event, sizeof *out->events))
        return false;
    out->events[out->n_event++] = (ric_response_trace_event){.kind = kind, .at = p->orbit};
    p->orbit.u = NULL;
    return true;
}

/* UNCLEAR: it turns, and not where. */
typedef enum { GOES_ON, GRAZES, ARRIVES, UNCLEAR } step_end;

/* Events of the step from a to b, of length h, the grazing at its end among them; *ends: how. At an
 * arrival b becomes the orbit there, at a grazing one just before it. */
static bool find_events(tracer *t, const probe *a, probe *b, double h, step_end *ends)
{
    static const ric_response_kind kinds[] = {RIC_RESPONSE_FOLD, RIC_RESPONSE_BRANCH_POINT,
                                              RIC_RESPONSE_DOUBLING, RIC_RESPONSE_NEIMARK_SACKER,
                                              RIC_RESPONSE_GRAZING};
    const int before = t->out->n_event;
    double end = INFINITY;
    *ends = b->orbit.margin < 0 ? GRAZES : GOES_ON;
    for (int what = BY_MARGIN; what >= BY_FOLD; what--) {
        const double first = read_probe(t, a, (reading)what),
                     last = read_probe(t, b, (reading)what);
        const bool folds = a->orbit.tangent[t->o->m] * b->orbit.tangent[t->o->m] < 0;
        probe p;
        if (!(first * last < 0) || (what == BY_ONE && folds)) continue;
        if (!probe_create(t, &p)) return false;
        p.orbit
            .arclength = NAN; /* until an orbit is found; at an arrival the last ones may not be */
        const bool found = locate(t, a, (reading)what, h, last, &p);
        if (!found && what == BY_MARGIN) {
            free_orbit(&p.orbit);
            return false;
        }
        if (found && what == BY_MARGIN) end = p.orbit.arclength;
        if (found && what == BY_ONE) settle_branch_point(t, a, h, &p);
        if (what == BY_FOLD && p.orbit.arclength <= end && arrives(t, a, &p, b)) {
            const probe swap = *b;
            *b = p;
            p = swap;
            *ends = ARRIVES;
            drop_events(t, before, b->orbit.arclength - BESIDE * h);
            free_orbit(&p.orbit);
            continue;
        }
        if (what == BY_FOLD && !found && !(p.orbit.arclength > end)) *ends = UNCLEAR;
        if (found && p.orbit.arclength <= end && is_event(t, &p, (reading)what) &&
            !keep_event(t, kinds[what], &p)) {
            free_orbit(&p.orbit);
            return false;
        }
        free_orbit(&p.orbit);
        if (what != BY_MARGIN) continue;
        h = SHORT * (end - a->orbit.arclength);
        if (!go(t, a, h, NULL) || !look(t, a->orbit.tangent, a->orbit.arclength + h, b)) break;
    }
    return true;
}

/* -------------------------------------------------------------------- tracing */

static bool keep_point(tracer *t, const probe *p)
{
    ric_response_trace *out = t->out;
    probe copy;
    if (!make_room((void **)&out->points, out->n_point, &out->room_point, sizeof *out->points))
        return false;
    if (!probe_create(t, &copy)) return false;
    const ric_response_orbit kept = copy.orbit;
    memcpy(kept.u, p->orbit.u, (size_t)(p->full - p->orbit.u) * sizeof *kept.u);
    copy.orbit = p->orbit;
    copy.orbit.u = kept.u;
    copy.orbit.tangent = kept.tangent;
    copy.orbit.multipliers = kept.multipliers;
    out->points[out->n_point++] = copy.orbit;
    return true;
}

/* At the edge of the window that lies between a and the orbit in t->o. */
static bool to_edge(tracer *t, const probe *a, double edge, probe *b)
{
    double *free_one = ric_force_orbit_parameter(t->o, t->options->along);
    const double before = parameter(t, &a->orbit), part = (edge - before) / (*free_one - before);
    for (size_t i = 0; i < t->all; i++)
        t->o->u[i] = a->orbit.u[i] + part * (t->o->u[i] - a->orbit.u[i]);
    *free_one = edge;
    return ric_force_orbit_solve(t->o, t->options->along, t->options->scale, NULL, 0, NULL) &&
           look(t, a->orbit.tangent, a->orbit.arclength + way(t, a, t->o->u, edge), b);
}

/* Whether the step from a, of length h, comes by the first point again. */
static bool closes(const tracer *t, const probe *a, double h)
{
    const ric_response_orbit *first = &t->out->points[0];
    const double back = way(t, a, first->u, parameter(t, first));
    if (!(back > 0 && back <= h) || !go(t, a, back, NULL)) return false;
    return apart(t, first->u, parameter(t, first)) < SAME * (1 + fabs(a->orbit.u[0]));
}

/* One step of at most *h from a to b; false: too short. The step that was taken in *taken. */
static bool advance(tracer *t, const probe *a, double *h, double shortest, probe *b, double *taken)
{
    for (; *h > shortest; *h /= 2) {
        int steps;
        if (ric_halted() || ric_memory_failed()) return false;
        if (!go(t, a, *h, &steps) || steps > 2 * QUICK) continue;
        double moved = 0;
        for (int i = 0; i < t->o->m; i++) {
            const double off = t->o->u[i] - a->orbit.u[i] - *h * a->full[i];
            moved += off * off;
        }
        if (sqrt(moved) > ASIDE * *h) continue;
        if (!look(t, a->orbit.tangent, a->orbit.arclength + *h, b)) continue;
        const double turn = ric_dot(t->o->m + 1, a->orbit.tangent, b->orbit.tangent);
        if (turn < TURN) continue;
        *taken = *h;
        if (turn > STRAIGHT && steps <= QUICK) *h *= 1.5;
        return true;
    }
    return false;
}

/* From the first point in the direction of `a`, which is the orbit there. */
static ric_response_stop follow(tracer *t, probe *a)
{
    probe b;
    double longest = t->options->step * size_of(t, a), h = FIRST * longest, taken;
    const double low = t->options->window[0], high = t->options->window[1];
    const int first = t->out->n_point;
    ric_response_stop stop = RIC_RESPONSE_FAILED;
    if (!probe_create(t, &b)) return stop;
    while (true) {
        step_end ends;
        const int known = t->out->n_event;
        if (t->out->n_point >= t->options->points) {
            stop = RIC_RESPONSE_BUDGET;
            break;
        }
        longest = t->options->step * size_of(t, a);
        h = fmin(h, longest);
        if (ric_halt(STEP_WORK)) break;
        if (!advance(t, a, &h, SHORTEST * longest, &b, &taken)) break;
        if (t->out->n_point > first + 3 && closes(t, a, taken)) {
            stop = RIC_RESPONSE_CLOSED;
            break;
        }
        const double value = parameter(t, &b.orbit);
        const bool leaves = value < low || value > high;
        if (leaves) {
            ric_response_trace_put(&b.orbit, t->o);
            if (!to_edge(t, a, value < low ? low : high, &b)) break;
            taken = b.orbit.arclength - a->orbit.arclength;
        }
        if (!find_events(t, a, &b, taken, &ends)) break;
        if (ends == GRAZES) {
            stop = RIC_RESPONSE_GRAZES;
            break;
        }
        if (taken > FINEST * longest &&
            (ends == UNCLEAR || (ends == GOES_ON && unexplained(t, a, &b, known)))) {
            drop_events(t, known, -INFINITY);
            h = taken / 2;
            continue;
        }
        if (ends == UNCLEAR) break;
        if (!keep_point(t, &b)) break;
        if (ends == ARRIVES) {
            stop = RIC_RESPONSE_JOINS;
            break;
        }
        if (leaves) {
            stop = RIC_RESPONSE_WINDOW;
            break;
        }
        const probe swap = *a;
        *a = b;
        b = swap;
    }
    free_orbit(&b.orbit);
    return stop;
}

/* Points and events of the first way, turned round, before those of the second. */
static void turn_round(const tracer *t)
{
    ric_response_trace *out = t->out;
    for (int i = 0, j = out->n_point - 1; i < j; i++, j--) {
        const ric_response_orbit swap = out->points[i];
        out->points[i] = out->points[j];
        out->points[j] = swap;
    }
    for (int i = 0; i < out->n_point + out->n_event; i++) {
        ric_response_orbit *at = i < out->n_point ? &out->points[i]
                                                  : &out->events[i - out->n_point].at;
        at->arclength = -at->arclength;
        for (int j = 0; j <= t->o->m; j++) at->tangent[j] = -at->tangent[j];
    }
}

static int by_arclength(const void *p, const void *q)
{
    const ric_response_trace_event *a = p, *b = q;
    return (a->at.arclength > b->at.arclength) - (a->at.arclength < b->at.arclength);
}

static bool begin(tracer *t, const double *direction, const ric_response_orbit *from, probe *a)
{
    if (!probe_create(t, a)) return false;
    if (from) ric_response_trace_put(from, t->o);
    return look(t, direction, 0, a);
}

ric_response_trace *ric_response_trace_run(ric_force_orbit *shape,
                                           const ric_response_trace_options *options,
                                           const double *direction, bool both)
{
    ric_response_trace *out = ric_calloc(1, sizeof *out);
    if (!out) {
        ric_force_orbit_free(shape);
        return NULL;
    }
    out->shape = shape;
    tracer t = {shape, options, (size_t)shape->N * (size_t)shape->m, out};
    const int m = shape->m;
    probe a;
    double back[m + 1];
    ric_response_stop last = RIC_RESPONSE_FAILED;
    bool begun = begin(&t, direction, NULL, &a) && keep_point(&t, &a);
    if (begun) last = follow(&t, &a);
    free_orbit(&a.orbit);
    out->stop = last;
    out->other = last == RIC_RESPONSE_CLOSED ? last : RIC_RESPONSE_WINDOW;
    if (begun && both && last != RIC_RESPONSE_CLOSED) {
        turn_round(&t);
        for (int i = 0; i <= m; i++) back[i] = out->points[out->n_point - 1].tangent[i];
        begun = begin(&t, back, &out->points[out->n_point - 1], &a);
        out->other = out->stop;
        out->stop = begun ? follow(&t, &a) : RIC_RESPONSE_FAILED;
        free_orbit(&a.orbit);
    }
    if (out->n_event) qsort(out->events, (size_t)out->n_event, sizeof *out->events, by_arclength);
    if (ric_memory_failed() || ric_halted()) out->status = ric_trust(RIC_OK);
    return out;
}
