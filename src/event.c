#include "event.h"

#include <stdlib.h>
#include <string.h>

#include "arrival.h"
#include "crossing.h"
#include "motion.h"
#include "status.h"

#define LOCATE_STEPS 60
#define BEFORE (1 - 1e-4) /* just before a grazing the functions that are singular there still have their sign */
/* A sign change whose function does not fall below this part of its values at the ends is a pole or a hop. */
#define TRUE_ZERO 1e-5
/* A step, relative to the size of the orbit, in which a factor of the map that changes its sign without a zero has jumped. */
#define JUMP 1e-7
/* The same for multipliers: on sharp tongues they run from -3e4 to 2 within 1e-7 and are noise of 1e-5. */
#define TRUE_RESONANCE 1e-2
/* How far the sign of a factor that was never seen may come out of rounding in one step, over the least that is seen. */
#define EMERGED 100
/* Looks for a better place of an arrival: on sharp turns the zero of the determinant is off. */
#define ASIDE_STEPS 3
/* Part of the largest step within which two pairs that pass a resonance count as one event. */
#define TOGETHER 1e-6
/* A step over a zero of the bordered determinant is made this short (of the size of the orbit) first. Two branches meet there: at
 * distance x the orbit is known across them only to rounding / x, so nothing is solved close by; the crossing is read off a cubic
 * through four points at good distance, and the junction is solved on its own equations later. */
#define CROSSING 1e-3
/* Of the size: the start of a closed branch again. */
#define SAME_PLACE 1e-8
/* The same at a branch point, of the step over it: the cubic is off by its fourth power, and another branch through that point has another
 * heading. */
#define ON_CUBIC 1e-4
/* Attempts to place a step over it well: the secant has settled by then, or the determinant only touches zero. */
#define APPROACHES 4
/* What may keep two branches apart (ric_crossing_gap) that cross: rounding. */
#define CROSSED 1e-11
/* dE/ds at a multiplication, of that at 1/2 CROSSING beside it, below which it counts as zero. */
#define ON_SLOPE 0.02

#define STRETCHES 3 /* of a step, between its extrema of energy and of period */
#define ROUNDING 1e-12 /* relative distance from what was asked for at which orbits are not told apart by shorter steps */

static const unsigned terminal = 1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH | 1u << RIC_TEST_FLIGHT | 1u << RIC_TEST_E_MAX |
                                 1u << RIC_TEST_E_MIN | 1u << RIC_TEST_F_MAX | 1u << RIC_TEST_F_MIN;
/* Factors of the map, which grows without bound where an impact loses its speed. */
static const unsigned singular = 1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D;
/* What ghosts are allowed to do: gaps are penetrated, impacts have the wrong direction. Where the speed of one of them passes through zero
 * the singular functions change sign without a zero. */
static const unsigned free_of_ghosts = 1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH | 1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D;
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

/* Behind a multiplication of high order the signs of the factors are lost in rounding for a long way, and the first that is seen may be that
 * behind a zero: it has to be seen soon after it emerges. */
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
    for (int i = 0; i < tr->floquet.n_pair && !(tr->ignore & singular); i++)
        if (turns_at_resonance(tr, p->own[2 * i], a->own[2 * i], b->own[2 * i], x0, x2)) return true;
    for (int i = 0; i < RIC_N_TEST; i++) {
        double f0 = p->test[i], f1 = a->test[i], f2 = b->test[i];
        if (!watched(tr, i) || f1 * f2 <= 0 || !isfinite(f0 + f1 + f2)) continue;
        /* f = f1 + B x + C x^2 */
        double C = ((f2 - f1) / x2 - (f0 - f1) / x0) / (x2 - x0), B = (f2 - f1) / x2 - C * x2, vertex = -B / (2 * C);
        if (!(vertex > 0 && vertex < x2)) continue;
        double bottom = f1 + B * vertex / 2, end = fmin(fabs(f1), fabs(f2));
        /* towards zero, and the cubic term could make up for what is left; what falls by orders beside a grazing dips far below, and means nothing */
        if (bottom * f1 < 0.4 * end * fabs(f1) && (fabs(bottom) < fabs(f1) || !(singular & 1u << i))) return true;
    }
    return false;
}

/* ------------------------------------------------------------------ location */

/* The unknowns at distance x from `now` on the cubic through now and next. */
static void on_cubic(const ric_trace *tr, double x, double h, double *u)
{
    const ric_station *a = &tr->now, *b = &tr->next;
    double y = x / h, H = b->s - a->s;
    double p = 2 * y * y * y - 3 * y * y + 1, q = (y * y * y - 2 * y * y + y) * H, r = 1 - p, s = (y * y * y - y * y) * H;
    for (int i = 0; i < tr->chain->n_unknown; i++) u[i] = p * a->u[i] + q * a->t[i] + r * b->u[i] + s * b->t[i];
}

/* Solves at distance x from `now`, between now and next, from the cubic through both. */
static ric_status station_at(ric_trace *tr, double x, double h, ric_station *out, bool *good)
{
    ric_chain *c = tr->chain;
    const ric_station *a = &tr->now;
    int iterations;
    on_cubic(tr, x, h, out->u);
    *good = ric_trace_correct(c, out->u, a->u, a->t, x, tr->du, &iterations);
    tr->evaluations += iterations + 1;
    if (!*good) return RIC_OK;
    double sign = ric_trace_tangent(c, a->t, out->t);
    out->s = a->s + (tr->next.s - a->s) * (x / h);
    return ric_trace_examine(tr, out, sign);
}

/* Value of a test function, or of what is watched beyond them: resonances, and what was asked for. */
static double value_of(const ric_trace *tr, int test, const ric_station *p)
{
    if (test < RIC_N_TEST) return p->test[test];
    const ric_asked *asked = ric_trace_asked(tr, test);
    if (asked) return ric_asked_off(asked, p->row.energy, p->row.frequency);
    return ric_resonance_test(p->own, tr->floquet.n_pair, tr->resonances[test - RIC_N_TEST].rho);
}

/* By what a zero is told from a jump: of the factors of the map, whose tests are relative to pivots that change their places, what is smooth. */
static double height(int test, const ric_station *p, double value)
{
    return test < RIC_N_TEST && singular & 1u << test ? fabs(p->factor[test == RIC_TEST_A ? 0 : test == RIC_TEST_B ? 1 : 2]) : fabs(value);
}

/* Brent's method on the distance from `now`; the result is left in tr->mid. *zero: a true zero was found. */
static ric_status locate(ric_trace *tr, int test, double xa, double fa, double xb, double fb, double h, double *where, bool *zero)
{
    double a = xa, b = xb, size = fmax(fabs(fa), fabs(fb)), top = height(test, &tr->now, fa), c = a, fc = fa, d = b - a, e = d;
    ric_status status;
    bool good = false;
    *zero = false;
    for (int i = 0; i < LOCATE_STEPS; i++) {
        if (fb * fc > 0) {
            c = a;
            fc = fa;
            d = e = b - a;
        }
        if (fabs(fc) < fabs(fb)) {
            a = b; b = c; c = a;
            fa = fb; fb = fc; fc = fa;
        }
        double tolerance = 2e-16 * h + 1e-17, m = (c - b) / 2;
        if (fabs(m) <= tolerance || fb == 0) break;
        if (fabs(e) < tolerance || fabs(fa) <= fabs(fb)) d = e = m;
        else {
            double s = fb / fa, p, q;
            if (a == c) {
                p = 2 * m * s;
                q = 1 - s;
            } else {
                double t = fa / fc, r = fb / fc;
                p = s * (2 * m * t * (t - r) - (b - a) * (r - 1));
                q = (t - 1) * (r - 1) * (s - 1);
            }
            if (p > 0) q = -q;
            else p = -p;
            if (2 * p < fmin(3 * m * q - fabs(tolerance * q), fabs(e * q))) {
                e = d;
                d = p / q;
            } else d = e = m;
        }
        a = b;
        fa = fb;
        b += fabs(d) > tolerance ? d : copysign(tolerance, m);
        if ((status = station_at(tr, b, h, &tr->mid, &good))) return status;
        if (!good) return RIC_OK;
        fb = value_of(tr, test, &tr->mid);
        top = fmax(top, height(test, &tr->mid, fb));
    }
    if ((status = station_at(tr, b, h, &tr->mid, &good))) return status;
    *where = b;
    double least = value_of(tr, test, &tr->mid), part = test < RIC_N_TEST ? TRUE_ZERO : TRUE_RESONANCE;
    *zero = good && (fabs(least) <= part * size || (test < RIC_N_TEST && height(test, &tr->mid, least) <= part * top));
    return RIC_OK;
}

/* ------------------------------------------------------------------ crossings */

/* Four points of a step that crosses a branch point, and the cubics through them. */
typedef struct {
    double x[4], test[4][RIC_N_TEST];
    double *u;   /* [4 * n_unknown] */
    double *own; /* [4 * 2 * n_pair], behind u */
} crossing;

static void lagrange(const double *x, double at, double *value, double *slope)
{
    for (int i = 0; i < 4; i++) {
        double product = 1, sum = 0;
        for (int j = 0; j < 4; j++) {
            if (j == i) continue;
            double rest = 1 / (x[i] - x[j]);
            product *= (at - x[j]) / (x[i] - x[j]);
            for (int k = 0; k < 4; k++)
                if (k != i && k != j) rest *= (at - x[k]) / (x[i] - x[k]);
            sum += rest;
        }
        value[i] = product;
        slope[i] = sum;
    }
}

static double crossing_test(const ric_trace *tr, const crossing *q, int test, double at)
{
    double value[4], slope[4], sum = 0;
    int n_pair = tr->floquet.n_pair;
    lagrange(q->x, at, value, slope);
    for (int i = 0; i < 4; i++)
        sum += value[i] * (test < RIC_N_TEST ? q->test[i][test]
                                             : ric_resonance_test(q->own + i * 2 * n_pair, n_pair, tr->resonances[test - RIC_N_TEST].rho));
    return sum;
}

/* Solves at the four distances q->x; false if one of them does not converge. */
static ric_status crossing_solve(ric_trace *tr, double h, crossing *q, bool *good)
{
    size_t size = (size_t)tr->chain->n_unknown, pairs = 2 * (size_t)tr->floquet.n_pair;
    *good = true;
    for (int i = 0; i < 4 && *good; i++) {
        ric_status status = station_at(tr, q->x[i], h, &tr->mid, good);
        if (status) return status;
        memcpy(q->test[i], tr->mid.test, sizeof tr->mid.test);
        memcpy(q->u + i * size, tr->mid.u, size * sizeof *q->u);
        memcpy(q->own + i * pairs, tr->mid.own, pairs * sizeof *q->own);
    }
    return RIC_OK;
}

/* The points lie at fixed distances on both sides, wherever in the step the root is: a point close to it would be noise. Where the branch
 * bends too much for that, they lie within the step. */
static ric_status crossing_create(ric_trace *tr, double h, crossing *q)
{
    static const double place[4] = {-1, -0.5, 0.5, 1};
    size_t size = (size_t)tr->chain->n_unknown, pairs = 2 * (size_t)tr->floquet.n_pair;
    double fa = tr->now.test[RIC_TEST_DET], fb = tr->next.test[RIC_TEST_DET], root = fa / (fa - fb);
    double within[4] = {0, root / 2 * h, (1 + root) / 2 * h, h};
    bool good = false;
    if (!(q->u = malloc(4 * (size + pairs) * sizeof *q->u))) return ric_fail(RIC_E_NOMEM, "no memory for a crossing");
    q->own = q->u + 4 * size;
    for (int i = 0; i < 4; i++) q->x[i] = root * h + place[i] * CROSSING / 2 * tr->chain->scale;
    ric_status status = crossing_solve(tr, h, q, &good);
    if (!status && !good) {
        memcpy(q->x, within, sizeof within);
        status = crossing_solve(tr, h, q, &good);
    }
    if (!status && !good) status = ric_fail(RIC_E_NUMERIC, "no convergence beside a branch point");
    if (status) {
        free(q->u);
        q->u = NULL;
    }
    return status;
}

/* Bisection on the cubic between a and b, where its signs differ, or did but for the zero at `known` (NAN: none), which is divided out. */
static double crossing_root(const ric_trace *tr, const crossing *q, int test, double a, double b, double sign, double known)
{
    for (int i = 0; i < 60; i++) {
        double m = (a + b) / 2, fm = crossing_test(tr, q, test, m) * (m < known ? -1 : 1);
        if (sign * fm > 0) a = m;
        else b = m;
    }
    return (a + b) / 2;
}

/* The point at x read off the cubics; nothing is solved. */
static void crossing_station(const ric_trace *tr, const crossing *q, double x, double h, ric_station *out)
{
    int size = tr->chain->n_unknown;
    double value[4], slope[4], norm = 0;
    lagrange(q->x, x, value, slope);
    for (int j = 0; j < size; j++) {
        out->u[j] = out->t[j] = 0;
        for (int i = 0; i < 4; i++) {
            out->u[j] += value[i] * q->u[i * size + j];
            out->t[j] += slope[i] * q->u[i * size + j];
        }
        norm += out->t[j] * out->t[j];
    }
    for (int j = 0; j < size; j++) out->t[j] /= sqrt(norm);
    out->s = tr->now.s + (tr->next.s - tr->now.s) * x / h;
    /* the row is that of the nearest end but for what the cubics give */
    out->row = tr->next.row;
    out->row.arclength = out->s;
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
    tr->why = "";
    return status ? status : ric_trace_keep(tr, p);
}

/* ------------------------------------------------------------------- the step */

static void window_text(ric_trace *tr, int test)
{
    static const char *const text[RIC_N_TEST] = {
        [RIC_TEST_E_MAX] = "upper end of the energy window", [RIC_TEST_E_MIN] = "lower end of the energy window",
        [RIC_TEST_F_MAX] = "upper end of the frequency window", [RIC_TEST_F_MIN] = "lower end of the frequency window"};
    tr->stop = text[test] ? RIC_STOP_WINDOW : RIC_STOP_JUNCTION;
    tr->why = text[test] ? text[test] : "";
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
    if (tr->now.test[RIC_TEST_DET] * tr->next.test[RIC_TEST_DET] < 0) { /* a branch point itself, as which many branches start: the cubic knows it */
        on_cubic(tr, along, h, u);
        along = 0;
        for (int i = 0; i < size; i++) along += (home[i] - u[i]) * t[i];
        for (int i = 0; i < size; i++) u[i] += along * t[i];
        most = fmax(most, ON_CUBIC * h);
    } else {
        bool good = false;
        if (station_at(tr, along, h, &tr->mid, &good) || !good) return false;
        t = tr->mid.t;
    }
    for (int i = 0; i < size; i++) distance = fmax(distance, fabs(u[i] - home[i]));
    if (!(distance < most && ric_dot(size, t, heading) > 0.5)) return false;
    *s = tr->now.s + (tr->next.s - tr->now.s) * (first / h);
    return true;
}

/* Back at the start, at the arclength s; `home` [n_unknown] is the start once more. From a centre to a rest under a power law an orbit shows its
 * image x -> -x half a period on, which is the same orbit: there the way round a closed branch may end with the other sign. */
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
    tr->why = "back at its start";
    memcpy(tr->mid.u, home, (size_t)tr->chain->n_unknown * sizeof *home);
    tr->mid.row = *(const ric_point *)tr->points;
    tr->mid.row.arclength = s;
    return ric_trace_keep(tr, &tr->mid);
}

typedef struct { int test; double x; } root;

static int by_place(const void *a, const void *b)
{
    const root *p = a, *q = b;
    return p->x < q->x ? -1 : p->x > q->x ? 1 : p->test - q->test;
}

/* All zeros of the tests in `which` up to distance `to`, whose functions there are `end`. */
static ric_status find_roots(ric_trace *tr, unsigned which, double to, const double *end, double h, root *roots, int *n, bool *retry)
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
        ric_status status = locate(tr, i, 0, fa, to, fb, h, &x, &zero);
        if (status) return status;
        if (!zero) {
            /* the factors of the map may jump where rounding hides them; in a step this short nothing else can have happened */
            if ((singular & 1u << i) && h < JUMP * tr->chain->scale) continue;
            *retry = true;
            return RIC_OK;
        }
        roots[(*n)++] = (root){i, x};
    }
    return RIC_OK;
}

/* Arranges for a short step with the crossing in its middle, and for no point close to one, where all but the determinant is rounding;
 * false when all is well. */
static bool approach_crossing(ric_trace *tr, double h)
{
    double x = crossing_ahead(tr, h), length = CROSSING * tr->chain->scale, step = fmax(2 * x, length / 2);
    if (x == HUGE_VAL || (h > 0.7 * step && h < 1.4 * step && h < 3 * length) || ++tr->approaches > APPROACHES) return false;
    tr->wanted = x > 1.1 * length ? fmin(x - length / 2, 0.9 * h) : step;
    tr->after = length;
    return true;
}

/* Functions that are looked at a little before an end of kind `test`: the factors of the map, and where a contact of a spring shrinks to
 * nothing dE/ds and dT/ds, which vanish with it. */
static unsigned late_at(const ric_trace *tr, int test)
{
    return singular | (tr->chain->model->springs && test == RIC_TEST_APPROACH ? extrema : 0);
}

/* The far end of the branch, if one of the functions `which` that end it vanishes in this step: its test, or -1, and its distance. `limit` holds
 * the test functions there, the singular ones a little before. */
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
    if ((status = station_at(tr, *end, h, &tr->mid, &good))) return status;
    memcpy(limit, tr->mid.test, sizeof tr->mid.test);
    if ((status = station_at(tr, *end * BEFORE, h, &tr->mid, &good))) return status;
    for (int i = 0; i < RIC_N_TEST; i++)
        if (late_at(tr, *test) & 1u << i) limit[i] = tr->mid.test[i];
    return RIC_OK;
}

/* ---------------------------------------------------------- what was asked for */

static void complete_row(ric_trace *tr, ric_station *p);

/* The point at distance x: solved, or in a step over a branch point, where nothing can be, on the cubic. */
static ric_status look(ric_trace *tr, bool solve, double x, double h, ric_station *out, bool *good)
{
    *good = true;
    if (solve) return station_at(tr, x, h, out, good);
    on_cubic(tr, x, h, out->u);
    memcpy(out->t, tr->now.t, (size_t)tr->chain->n_unknown * sizeof *out->t);
    out->s = tr->now.s + (tr->next.s - tr->now.s) * (x / h);
    complete_row(tr, out);
    return RIC_OK;
}

static double bisect_cubic(ric_trace *tr, int test, double a, double fa, double b, double h)
{
    bool good;
    for (int i = 0; i < LOCATE_STEPS; i++) {
        look(tr, false, (a + b) / 2, h, &tr->mid, &good);
        if ((value_of(tr, test, &tr->mid) < 0) == (fa < 0)) a = (a + b) / 2;
        else b = (a + b) / 2;
    }
    return (a + b) / 2;
}

/* Passages between the distances xa and xb, at which what was asked for is `before` and `after` away, with no extremum in between. A value
 * met exactly counts as above, so that it is found in one of the two steps that end there. */
static ric_status find_monotonic(ric_trace *tr, bool solve, double xa, double xb, const double *before, const double *after, double h,
                                 root *roots, int *n, bool *retry)
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
            ric_status status = locate(tr, test, xa, fa, xb, fb, h, &x, &zero);
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
    for (int k = 0; k < tr->limits->n_asked; k++) out[k] = value_of(tr, RIC_N_TEST + tr->n_resonance + k, p);
}

/* Where what was asked for is passed up to distance `to`, between the extrema of energy and period among the *n roots known: so a
 * value passed twice, on both sides of an extremum, is found twice. Room for STRETCHES * n_asked more roots. */
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
        if (!(status = look(tr, false, roots[i].x, h, &tr->mid, &good))) status = ric_event_keep(tr, roots[i].test, &tr->mid);
    return status;
}

/* ------------------------------------------------------- over a branch point */

/* Whether a branch comes to a corner of orbits that are their own image there: the family on which both contacts stay together crosses. */
static bool meets_corner(const ric_trace *tr, const crossing *q, double h, double *at)
{
    if (tr->limits->ghost || !watched(tr, RIC_TEST_FLIGHT) || !(q->test[0][RIC_TEST_FLIGHT] * q->test[3][RIC_TEST_FLIGHT] < 0)) return false;
    double x = crossing_root(tr, q, RIC_TEST_FLIGHT, q->x[0], q->x[3], q->test[0][RIC_TEST_FLIGHT], NAN);
    if (x > *at + 0.05 * h) return false;
    *at = x;
    return true;
}

/* A step over a branch point (shorter than CROSSING): every inner function from the cubics. *end_test: why the branch ends there, at *end:
 * DET where it meets its own image, FLIGHT at a corner; -1 if it goes on. */
static ric_status cross(ric_trace *tr, double h, int *end_test, double *end, bool *retry)
{
    crossing q;
    root roots[RIC_N_TEST + tr->n_resonance];
    int n = 0;
    int first = tr->n_event;
    ric_status status = crossing_create(tr, h, &q);
    *end_test = -1;
    if ((*retry = status == RIC_E_NUMERIC && tr->avoided)) return RIC_OK;
    if (status) return status;
    double at = crossing_root(tr, &q, RIC_TEST_DET, q.x[0], q.x[3], q.test[0][RIC_TEST_DET], NAN);
    if (meets_corner(tr, &q, h, &at)) *end_test = RIC_TEST_FLIGHT;
    crossing_station(tr, &q, at, h, &tr->mid);
    /* a neighbour on the side where there is more room: close by it is lost in rounding */
    int far = at - q.x[0] > q.x[3] - at ? 0 : 3;
    const double *beside = q.u + far * tr->chain->n_unknown;
    for (int i = 0; i < ASIDE_STEPS && *end_test < 0; i++) {
        double aside, x;
        if (ric_arrival_meets(tr, tr->mid.u, beside, &aside)) *end_test = RIC_TEST_DET;
        else if ((x = at + aside * (q.x[far] - at)) == at || !(x > q.x[1] && x < q.x[2])) break;
        else crossing_station(tr, &q, at = x, h, &tr->mid);
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
    /* Where a branch meets its own image, and at a multiplication of order 4 and more, dE/ds and dT/ds vanish with the determinant: that
     * zero belongs to the one junction, and beyond it the other sign is the one to expect. A family of order 3 passes on a slope; its
     * extremum lies aside and is a junction of its own. */
    bool image = !arrived && ric_arrival_passes(tr, tr->mid.u, beside);
    bool flat = arrived || image || (repeated && fabs(crossing_test(tr, &q, RIC_TEST_SLOPE, at)) <
                                             ON_SLOPE * fmax(fabs(q.test[0][RIC_TEST_SLOPE]), fabs(q.test[3][RIC_TEST_SLOPE])));
    for (int i = 0; i < RIC_N_TEST; i++) {
        double before = tr->now.test[i] != 0 ? tr->now.test[i] : tr->definite[i], after = tr->next.test[i];
        if ((terminal & 1u << i) || !watched(tr, i)) continue;
        bool shared = flat && (extrema & 1u << i);
        if (shared) before = tr->definite[i] = -before;
        /* at a duplicate the kernels of all symmetries open at once, like high powers of the distance */
        if ((singular & 1u << i) && (arrived || image || repeated)) continue;
        if (!(before * after < 0)) continue;
        double x = i == RIC_TEST_DET ? at : crossing_root(tr, &q, i, 0, h, before, shared ? at : NAN);
        if (arrived && x >= at) continue;
        roots[n++] = (root){i, x};
    }
    for (int k = 0; k < tr->n_resonance; k++) {
        double before = value_of(tr, RIC_N_TEST + k, &tr->now), after = value_of(tr, RIC_N_TEST + k, &tr->next);
        if (!(before * after < 0)) continue;
        double x = crossing_root(tr, &q, RIC_N_TEST + k, 0, h, before, NAN);
        if (!arrived || x < at) roots[n++] = (root){RIC_N_TEST + k, x};
    }
    qsort(roots, (size_t)n, sizeof *roots, by_place);
    for (int i = 0; i < n && !status; i++) {
        crossing_station(tr, &q, roots[i].x, h, &tr->mid);
        status = ric_event_keep(tr, roots[i].test, &tr->mid);
    }
    if (!status) status = cross_asked(tr, first, arrived ? at : h, h);
    for (int i = 0; i < RIC_N_TEST; i++)
        if ((image || repeated) && (singular & 1u << i)) tr->definite[i] = tr->next.test[i] = 0; /* no sign is expected */
    if (arrived && !status) crossing_station(tr, &q, at, h, &tr->mid);
    free(q.u);
    return status;
}

/* All resonances that a pair passes up to distance `to`, where the pairs are those of `end`; roots has room for every one. */
static ric_status find_resonances(ric_trace *tr, double to, const double *end, double h, root *roots, int *n, bool *retry)
{
    const double *start = tr->now.own;
    int n_pair = tr->floquet.n_pair, known = *n;
    if (tr->ignore & singular) return RIC_OK; /* at a grazing the multipliers have no bound */
    for (int i = 0; i < n_pair; i++) {
        if (!isfinite(start[2 * i] + end[2 * i])) continue;
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
            ric_status status = locate(tr, RIC_N_TEST + k, 0, fa, to, fb, h, &x, &zero);
            if (status) return status;
            if (!zero && h >= JUMP * tr->chain->scale) { /* in a shorter step its place is known well enough: the junction is solved anew */
                *retry = true;
                return RIC_OK;
            }
            roots[(*n)++] = (root){RIC_N_TEST + k, x};
        }
    }
    return RIC_OK;
}

static ric_status inner_events(ric_trace *tr, double h, bool ends, double to, const double *limit, unsigned late, bool *retry)
{
    int n = 0, size = 2 * tr->floquet.n_pair;
    root roots[RIC_N_TEST + tr->n_resonance + STRETCHES * tr->limits->n_asked];
    double own[size + 1];
    bool good;
    /* at an end the last look was a little before it */
    memcpy(own, ends ? tr->mid.own : tr->next.own, (size_t)size * sizeof *own);
    unsigned inner = ~terminal & ((1u << RIC_N_TEST) - 1);
    ric_status status = find_roots(tr, inner & ~late, to, limit, h, roots, &n, retry);
    if (!status && !*retry) status = find_roots(tr, inner & late, ends ? to * BEFORE : to, limit, h, roots, &n, retry);
    if (!status && !*retry) status = find_resonances(tr, ends ? to * BEFORE : to, own, h, roots, &n, retry);
    if (!status && !*retry) status = find_asked(tr, true, to, h, roots, &n, retry);
    if (status || *retry) return status;
    qsort(roots, (size_t)n, sizeof *roots, by_place);
    for (int i = 0; i < n && !status; i++)
        if (!(status = station_at(tr, roots[i].x, h, &tr->mid, &good)) && !(status = ric_event_keep(tr, roots[i].test, &tr->mid)))
            status = ric_trace_keep(tr, &tr->mid); /* a stored point, so that extremes of a branch are among its points */
    return status;
}

/* Energy, frequency and residual of an end that was not solved as a station. */
static void complete_row(ric_trace *tr, ric_station *p)
{
    const ric_model *m = tr->chain->model;
    ric_chain_fly(tr->chain, p->u);
    p->row.energy = ric_chain_energy(tr->chain) * m->energy_unit;
    p->row.frequency = 6.283185307179586477 / ric_chain_time(tr->chain, p->u) * m->omega_ref;
    p->row.residual = (float)tr->chain->residual;
    p->row.stable = RIC_STABLE_UNDECIDED;
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
    unsigned which = crossed && !tr->limits->ghost && flight[0] * flight[1] < 0 ? terminal & ~(1u << RIC_TEST_FLIGHT) : terminal;
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
        window_text(tr, test);
        if (tr->arrival && (status = ric_arrival_settle(tr->chain, tr->mid.u))) return status;
        complete_row(tr, &tr->mid);
    } else if (test < 0) {
        return close_up(tr, home, s);
    } else {
        if ((status = station_at(tr, end, h, &tr->mid, &good))) return status;
        window_text(tr, test);
    }
    if ((status = fill_event(tr, test, &tr->mid, &tr->end))) return status;
    return ric_trace_keep(tr, &tr->mid);
}
