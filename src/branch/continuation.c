#include "continuation.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "symmetric_end.h"
#include "base/room.h"
#include "continuation_step.h"
#include "event.h"
#include "event_parts.h"
#include "leap.h"
#include "model/room.h"
#include "multiple_cover.h"

/* STEP_ANGLE: turning angle that a step aims at, rad: cubic prediction then leaves one Newton step
 */
#define STEP_ANGLE 0.08
#define SOFT_STEP 0.1   /* first step from the grazing of a spring, of its compliance */
#define FIRST_STEP 3e-5 /* of the size of the unknowns */
#define SHORTEST 1e-8   /* of the size: a first step that is shorter shows rounding */
#define SMALLEST_STEP                                                                              \
    1e-11              /* of the size of the unknowns: below it the branch counts as failed        \
                        */
#define STRAIGHT 1e-12 /* angle of a step, rad, that is rounding */
/* STEEP: rounding of a flight beyond which inner nodes are asked for: what verify asks of a stored
 * start */
#define STEEP 1e-11
/* ALIKE: length, of the size of the unknowns, of a step in which resonances are not told apart */
#define ALIKE 1e-8
#define PERIODS 8         /* points of a step at which its period is looked at */
#define BRANCH_POINT 1e-7 /* smallest end pivot at the start below which it is one */
/* LAST_STEP: of the size, towards a zero of the bordered determinant: crossings are read off from
 * there (event.c) */
#define LAST_STEP 1e-3
/* BORDER: slack of a window: what lies on its border is inside, whatever the rounding */
#define BORDER 5e-13
/* AT_LOWEST: relative: a start this near to the lower end of the energy window lies on it */
#define AT_LOWEST 1e-9
/* MERGED: scaled time: two impacts of a ghost nearer than this are one, or none; beside it the
 * orbit is known to rounding / time */
#define MERGED 1e-5
/* SHORT: scaled time: a flight that vanishes with a speed is less where that is rounding already,
 * if it is its fifth power or a lower one */
#define SHORT 0.01

ric_limits ric_continuation_limits(const ric_model *m, const double energy[2],
                                   const double frequency[2], double max_step, int max_points)
{
    double lowest = fmax(energy[0], m->linear_energy);
    double longest = frequency[0] > 0 ? RIC_TWO_PI / frequency[0] * m->omega_ref : HUGE_VAL;
    return (ric_limits){.energy = {lowest / m->energy_unit * (1 - BORDER),
                                   energy[1] / m->energy_unit * (1 + BORDER)},
                        .period = {RIC_TWO_PI / frequency[1] * m->omega_ref * (1 - BORDER),
                                   longest * (1 + BORDER)},
                        .max_step = max_step,
                        .max_points = max_points};
}

/* ------------------------------------------------------------------ stations */

/* Smallest time between two switches of one spring: it vanishes where an impact would lose its
 * speed, at a grazing. */
static double smallest_touch(const ric_shooting *c, const double *u)
{
    double least = HUGE_VAL;
    for (int k = 0; k < c->n_flight; k++)
        if (ric_shooting_touches(c, k)) least = fmin(least, u[c->n_start + k]);
    return least;
}

/* Flights between different contacts; between mirror points in flight there is no such thing. Two
 * impacts on one contact cannot come together without losing their speed, which ends a branch; a
 * ghost goes on without, so that there all flights count. */
static double smallest_flight(const ric_shooting *c, const double *u, bool ghost)
{
    const ric_model *m = c->model;
    double least = HUGE_VAL;
    for (int k = 0; k < c->n_flight; k++) {
        int f = c->face[k], g = c->face[k + 1];
        double tau = u[c->n_start + k];
        if (ric_shooting_touches(c, k)) continue;
        if (ghost || f < 0 || g < 0 || m->face[f].contact != m->face[g].contact)
            least = fmin(least, tau);
    }
    return least;
}

/* Pairs in ascending order, so that each is continuous as long as they do not meet; what is lost
 * comes last. */
static void sort_pairs(const ric_floquet *f, double *out, double *error)
{
    const double *rho = f->own;
    for (int i = 0; i < f->n_pair; i++) {
        int place = i;
        for (; place > 0 && !isnan(rho[2 * i]) && !(out[2 * place - 2] <= rho[2 * i]); place--) {
            memcpy(out + 2 * place, out + 2 * place - 2, 2 * sizeof *out);
            error[place] = error[place - 1];
        }
        memcpy(out + 2 * place, rho + 2 * i, 2 * sizeof *out);
        error[place] = f->own_error[i];
    }
}

ric_periodic *ric_continuation_cycle(const ric_continuation *tr, const double *u)
{
    ric_shooting_fly(tr->chain, u);
    return ric_periodic_from_chain(tr->chain, u);
}

const ric_resonance *ric_continuation_resonance(const ric_continuation *tr, int test)
{
    int k = test - RIC_N_TEST;
    return k >= 0 && k < tr->n_resonance ? &tr->resonances[k] : NULL;
}

double ric_continuation_side(const ric_continuation *tr, int k, const ric_station *p)
{
    return ric_resonance_side(p->own, p->error, tr->floquet.n_pair, tr->resonances[k].rho);
}

void ric_continuation_remember(ric_continuation *tr, const ric_station *p)
{
    for (int k = 0; k < tr->n_resonance; k++) {
        const double side = ric_continuation_side(tr, k, p);
        if (side != 0) tr->passed[k] = isnan(side) ? 0 : side;
    }
}

bool ric_continuation_resonances(ric_continuation *tr)
{
    tr->resonances = ric_resonance_list(ric_shooting_halves(tr->chain), tr->limits->multiply,
                                        &tr->n_resonance);
    if (tr->n_resonance < 0) return false;
    tr->passed = ric_calloc((size_t)tr->n_resonance + 1, sizeof *tr->passed);
    return tr->passed != NULL;
}

const ric_user_point *ric_continuation_user_point(const ric_continuation *tr, int test)
{
    int place = test - RIC_N_TEST - tr->n_resonance;
    return place >= 0 && place < tr->limits->n_asked ? &tr->limits->asked[place] : NULL;
}

static double definite(double value, double error)
{
    return fabs(value) > error ? value : 0;
}

/* Below its error a determinant has no sign: beside a q-tupling it stays there for a long way (like
 * distance^(q-2)). The orbit is known to rounding / pivot at every impact alike, and moves the
 * factors of the map, whose kicks go with 1 / speed, by that much. Where this bound leaves the sign
 * open although it is not the one expected, the error is measured: unknowns moved by more than they
 * are uncertain, twice this way and that. The tests are the determinants over their size, which
 * grows without bound near a grazing and with instability. */
static void keep_definite(ric_continuation *tr, ric_station *p, double approach)
{
    ric_shooting *c = tr->chain;
    int size = c->n_unknown;
    double blur = 1 + (1 + 1 / fabs(approach)) * c->scale / c->smallest,
           move = ric_continuation_rounding(c) * c->scale * (1 + 1 / c->smallest);
    const ric_floquet *f = &tr->floquet;
    double value[3] = {f->det_a, f->det_b, f->det_d},
           error[3] = {f->error_a, f->error_b, f->error_d}, seen[3] = {0}, size_of[3];
    const double most[3] = {f->size_a, f->size_b, f->size_d};
    bool open = false;
    for (int i = 0; i < 3; i++) {
        bool expected = value[i] * tr->definite[RIC_TEST_A + i] > 0 && p != &tr->mid;
        size_of[i] = error[i] > 0 ? error[i] / DBL_EPSILON : 1;
        p->factor[i] = value[i] / most[i];
        p->test[RIC_TEST_A + i] = (expected ? value[i] : definite(value[i], error[i] * blur)) /
                                  size_of[i];
        p->hidden[i] = error[i] * blur / size_of[i];
        open |= p->test[RIC_TEST_A + i] == 0 && value[i] != 0;
    }
    if (!open || !(move <= ric_continuation_beside(c))) return;
    for (unsigned way = 1; way <= 2; way++) {
        unsigned bits = way * 2654435769u;
        for (int i = 0; i < size; i++) tr->guess[i] = p->u[i] + ric_moved(&bits, move);
        ric_shooting_fly(c, tr->guess);
        ric_floquet_factors(c, &tr->floquet);
        double moved[3] = {f->det_a, f->det_b, f->det_d};
        for (int i = 0; i < 3; i++)
            seen[i] = fmax(seen[i], RIC_MEASURED * fabs(moved[i] - value[i]));
    }
    ric_shooting_fly(c, p->u);
    for (int i = 0; i < 3; i++) {
        if (p->test[RIC_TEST_A + i] == 0)
            p->test[RIC_TEST_A + i] = definite(value[i], seen[i]) / size_of[i];
        p->hidden[i] = fmin(p->hidden[i], seen[i] / size_of[i]);
    }
}

static ric_margins margins(const ric_shooting *c, const double *u, bool reach)
{
    return (ric_margins){.reach = reach ? ric_reach(c, u, NULL) : NAN,
                         .approach = ric_continuation_approach(c, false),
                         .closing = ric_continuation_approach(c, true),
                         .time = ric_shooting_time(c, u),
                         .energy = ric_shooting_energy(c)};
}

ric_margins ric_continuation_margins(const ric_shooting *c, const double *u)
{
    return margins(c, u, true);
}

ric_point ric_continuation_point(const ric_shooting *c, const ric_floquet *f, const ric_margins *of,
                                 double arclength)
{
    const ric_model *m = c->model;
    return (ric_point){.arclength = arclength,
                       .energy = of->energy * m->energy_unit,
                       .frequency = RIC_TWO_PI / of->time * m->omega_ref,
                       .trace = f->trace_asinh,
                       .rotation = f->rotation,
                       .reach = of->reach > 0 ? of->reach : NAN,
                       .approach = of->closing < HUGE_VAL ? of->closing * m->length * m->omega_ref
                                                          : NAN,
                       .residual = (float)c->residual,
                       .stable = (int32_t)f->stable};
}

/* All of a row at u, where the chain has been flown: nothing of it is taken from elsewhere. */
static ric_status measure(ric_continuation *tr, double s, const double *u, ric_station *p,
                          ric_margins *out)
{
    ric_shooting *c = tr->chain;
    ric_status status = tr->floquet.work ? RIC_OK : ric_floquet_create(c->n, &tr->floquet);
    if (!status) status = ric_floquet_compute(c, &tr->floquet);
    if (status) return status;
    *out = ric_continuation_margins(c, u);
    p->solved = ric_continuation_solved(c);
    p->doubtful = ric_continuation_doubtful(c, &tr->floquet);
    p->row = ric_continuation_point(c, &tr->floquet, out, s);
    return RIC_OK;
}

ric_status ric_continuation_fill(ric_continuation *tr, double s, ric_station *p)
{
    ric_margins margins;
    p->s = s;
    ric_shooting_evaluate(tr->chain, p->u);
    ric_status status = measure(tr, s, p->u, p, &margins);
    if (status || !p->doubtful) return status;
    p->doubtful = false;
    status = ric_continuation_judge(tr->chain, p->u, &tr->floquet);
    p->row = ric_continuation_point(tr->chain, &tr->floquet, &margins, s);
    return status;
}

static double definite_slope(ric_shooting *c, int test, const ric_station *p, bool asked)
{
    if (!asked) return NAN;
    const double slope = ric_continuation_slope(c, test, p->t);
    return definite(slope, ric_continuation_slope_error(c, p->u, p->t, test, slope));
}

/* Where a speed vanishes by powers of the distance it is rounding for a long way, and what vanishes
 * with it tells where: a flight, or a touch of a spring. As long as that lasts it counts as some.
 */
static double definite_speed(const ric_shooting *c, double speed, double flight)
{
    const double least = ric_continuation_rounding(c) * c->scale;
    return fabs(speed) < least && flight > least && flight < SHORT ? least : speed;
}

/* The tests that need no map; p->row has no stability. */
static void examine_orbit(ric_continuation *tr, ric_station *p, double orientation,
                          const ric_margins *now, unsigned at)
{
    ric_shooting *c = tr->chain;
    const ric_limits *lim = tr->limits;
    double *F = p->test;
    F[RIC_TEST_REACH] = 1 - now->reach;
    const double touch = smallest_touch(c, p->u), flight = smallest_flight(c, p->u, lim->ghost);
    F[RIC_TEST_APPROACH] = fmin(definite_speed(c, now->approach, fmin(touch, flight)), touch);
    F[RIC_TEST_FLIGHT] = flight - (lim->ghost ? MERGED : 0);
    F[RIC_TEST_DET] = orientation * c->end_det;
    F[RIC_TEST_SLOPE] = definite_slope(c, RIC_TEST_SLOPE, p, at & RIC_LOOK_ENERGY);
    F[RIC_TEST_PERIOD] = definite_slope(c, RIC_TEST_PERIOD, p, at & RIC_LOOK_PERIOD);
    F[RIC_TEST_E_MAX] = lim->energy[1] - now->energy;
    F[RIC_TEST_E_MIN] = now->energy - tr->lowest;
    F[RIC_TEST_F_MAX] = now->time - lim->period[0];
    F[RIC_TEST_F_MIN] = lim->period[1] - now->time;
}

ric_status ric_continuation_look(ric_continuation *tr, ric_station *p, double orientation,
                                 unsigned at)
{
    static const ric_floquet none = {.trace_asinh = NAN,
                                     .rotation = NAN,
                                     .stable = RIC_STABLE_UNDECIDED};
    ric_shooting *c = tr->chain;
    const ric_floquet *of = at & RIC_LOOK_PAIRS ? &tr->floquet : &none;
    const ric_margins now = margins(c, p->u, at & RIC_LOOK_REACH);
    tr->steep |= ric_flight_law_of(c->model)->integrated && ric_continuation_tolerance(c) > STEEP;
    tr->floquet.enough = at & RIC_LOOK_FOR ? RIC_SEEN_TO : 0;
    ric_status status = at & RIC_LOOK_PAIRS ? ric_floquet_compute(c, &tr->floquet) : RIC_OK;
    tr->floquet.enough = 0;
    if (status) return status;
    p->solved = ric_continuation_solved(c);
    p->doubtful = of != &none && ric_continuation_doubtful(c, of);
    p->row = ric_continuation_point(c, of, &now, p->s);
    if (of == &none || ric_continuation_still(c))
        for (int i = 0; i < 2 * tr->floquet.n_pair; i++) p->own[i] = NAN;
    else sort_pairs(of, p->own, p->error);
    for (int i = 0; i < 3; i++) p->test[RIC_TEST_A + i] = p->factor[i] = p->hidden[i] = NAN;
    examine_orbit(tr, p, orientation, &now, at);
    if (!(at & RIC_LOOK_FACTORS)) return RIC_OK;
    if (of == &none) ric_floquet_factors(c, &tr->floquet);
    keep_definite(tr, p, now.approach);
    return RIC_OK;
}

static bool station_create(ric_station *p, int size, int n_pair)
{
    p->own = ric_calloc(2 * (size_t)n_pair + 1, sizeof(double));
    p->error = ric_calloc((size_t)n_pair + 1, sizeof(double));
    p->u = ric_calloc((size_t)size, sizeof(double));
    p->t = ric_calloc((size_t)size, sizeof(double));
    return p->u && p->t && p->own && p->error;
}

static void station_free(ric_station *p)
{
    free(p->u);
    free(p->t);
    free(p->own);
    free(p->error);
    *p = (ric_station){0};
}

static bool samples_create(ric_continuation *tr)
{
    tr->samples.values = ric_calloc(RIC_MOST_SAMPLES * (size_t)ric_continuation_watched(tr),
                                    sizeof(double));
    tr->known.own = ric_calloc(RIC_MOST_KNOWN * 2 * (size_t)tr->chain->n, sizeof(double));
    tr->solved.u = ric_calloc(RIC_MOST_SOLVED * (size_t)tr->chain->n_unknown, sizeof(double));
    return tr->samples.values && tr->known.own && tr->solved.u;
}

/* -------------------------------------------------------------------- start */

ric_status ric_continuation_equip(ric_continuation *tr)
{
    int n = tr->chain->n_unknown, n_pair = tr->chain->n - 1;
    size_t size = (size_t)n;
    tr->du = ric_calloc(size, sizeof(double));
    tr->guess = ric_calloc(size, sizeof(double));
    tr->start_u = ric_calloc(size, sizeof(double));
    tr->start_t = ric_calloc(size, sizeof(double));
    if (!tr->du || !tr->guess || !tr->start_u || !tr->start_t ||
        !station_create(&tr->now, n, n_pair) || !station_create(&tr->next, n, n_pair) ||
        !station_create(&tr->mid, n, n_pair) || !station_create(&tr->past, n, n_pair) ||
        !samples_create(tr))
        return ric_no_memory("a branch");
    tr->may_gain = ric_symmetric_end_may_gain(tr->chain);
    return ric_floquet_create(tr->chain->n, &tr->floquet);
}

/* The length of the first step from a start; `length` of the caller's direction where that is
 * singular. */
static double first_step(const ric_continuation *tr, bool regular, double length)
{
    const ric_shooting *c = tr->chain;
    double step = regular                           ? fmin(FIRST_STEP * c->scale, tr->step_max)
                  : tr->ignore & RIC_SINGULAR_START ? length
                                                    : RIC_LEAVING * c->scale;
    /* where contacts of springs begin the first step goes without dE/ds and dT/ds, which vanish at
     * its start: it stays short of the extrema that follow at the inverse of the stiffness, the
     * square of the frequency (theory section 10) */
    if (c->fastest > 0 && tr->ignore & 1u << RIC_TEST_REACH)
        step = fmin(step, SOFT_STEP / (1 + c->fastest * c->fastest) * c->scale);
    return step;
}

/* Solves the first orbit from the guess u0, and prepares the first step along t0. */
static ric_status begin(ric_continuation *tr, const double *u0, const double *t0)
{
    ric_status status;
    ric_shooting *chain = tr->chain;
    const size_t size = (size_t)chain->n_unknown;
    int iterations;
    memcpy(tr->now.u, u0, size * sizeof *u0);
    ric_shooting_evaluate(chain, u0);
    /* at a branch point the kernel has two dimensions: a Newton step would go anywhere, and the
     * direction is the caller's. The smallest pivot does not always show it */
    bool regular = chain->smallest > BRANCH_POINT && !(tr->ignore & RIC_SINGULAR_START);
    if (regular && !ric_continuation_correct(chain, tr->now.u, NULL, NULL, 0, tr->du, &iterations))
        return ric_fail(RIC_E_NUMERIC, "the start of a branch does not converge: residual %g",
                        chain->residual);
    double sign = 1, norm = sqrt(ric_dot(chain->n_unknown, t0, t0));
    if (regular) sign = ric_continuation_tangent(chain, t0, tr->now.t);
    for (size_t i = 0; !regular && i < size; i++) tr->now.t[i] = t0[i] / norm;
    /* families that reach into the window begin below it */
    if (ric_shooting_energy(chain) < tr->limits->energy[0] * (1 - AT_LOWEST)) tr->lowest = -1;
    if ((status = ric_continuation_look(tr, &tr->now, sign, RIC_LOOK_ALL))) return status;
    if (!tr->now.solved)
        return ric_fail(RIC_E_NUMERIC, "the start of a branch is no orbit: residual %g",
                        chain->residual);
    for (int i = 0; i < RIC_N_TEST; i++)
        tr->definite[i] = tr->ignore & 1u << i ? 0 : tr->now.test[i];
    ric_continuation_remember(tr, &tr->now);
    memcpy(tr->start_u, tr->now.u, size * sizeof *u0);
    memcpy(tr->start_t, tr->now.t, size * sizeof *u0);
    tr->longest = HUGE_VAL;
    tr->step_max = tr->limits->max_step * chain->scale;
    tr->step = first_step(tr, regular, norm);
    return RIC_OK;
}

ric_status ric_continuation_create(ric_shooting *chain, const double *u0, const double *t0,
                                   unsigned ignore, const ric_limits *limits,
                                   ric_continuation **out)
{
    ric_status status = RIC_OK;
    size_t size = (size_t)chain->n_unknown;
    ric_continuation *tr = ric_calloc(1, sizeof *tr);
    *out = NULL;
    if (!tr) {
        ric_shooting_free(chain);
        return ric_no_memory("a branch");
    }
    tr->chain = chain;
    tr->limits = limits;
    tr->lowest = limits->energy[0];
    tr->ignore = ignore;
    tr->end.test = -1;
    tr->stride = sizeof(ric_point) / sizeof(double) + size;
    if (!ric_continuation_resonances(tr)) {
        status = ric_no_memory("a branch");
        goto out;
    }
    if ((status = ric_continuation_equip(tr))) goto out;
    if ((status = begin(tr, u0, t0))) goto out;
    if ((status = ric_continuation_keep(tr, &tr->now))) goto out;
    *out = tr;
    tr = NULL;
out:
    ric_continuation_free(tr);
    return status;
}

/* What ric_continuation_equip has made. */
static void unequip(ric_continuation *tr)
{
    ric_floquet_release(&tr->floquet);
    station_free(&tr->now);
    station_free(&tr->next);
    station_free(&tr->mid);
    station_free(&tr->past);
    double **const arrays[] = {&tr->samples.values, &tr->known.own, &tr->solved.u, &tr->du,
                               &tr->guess,          &tr->start_u,   &tr->start_t};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
        free(*arrays[i]);
        *arrays[i] = NULL;
    }
}

void ric_continuation_rest(ric_continuation *tr)
{
    unequip(tr);
    ric_shooting_nodes_drop(tr->chain);
    const size_t stored = (size_t)tr->n_point * tr->stride * sizeof *tr->points;
    double *fits = stored ? ric_realloc(tr->points, stored) : NULL;
    if (!fits) return;
    tr->points = fits;
    tr->point_capacity = tr->n_point;
}

void ric_continuation_free(ric_continuation *tr)
{
    if (!tr) return;
    unequip(tr);
    ric_shooting_free(tr->chain);
    for (int i = 0; i < tr->n_event; i++) {
        free(tr->events[i].u);
        free(tr->events[i].t);
    }
    free(tr->events);
    free(tr->gaps);
    free(tr->resonances);
    free(tr->passed);
    free(tr->end.u);
    free(tr->end.t);
    free(tr->points);
    free(tr);
}

/* --------------------------------------------------------------------- step */

/* Whether more than one resonance of modes that the contacts hardly feel lies within the step:
 * tests that change their sign twice do not show it. The period between the two points is that of
 * the cubic through both. */
static bool crowded(const ric_continuation *tr, double h)
{
    const ric_shooting *c = tr->chain;
    const ric_station *a = &tr->now, *b = &tr->next;
    double T[2] = {ric_shooting_time(c, a->u), ric_shooting_time(c, b->u)}, slope[2] = {0},
           low = HUGE_VAL, high = 0, H = b->s - a->s;
    if (tr->limits->ghost || h < ALIKE * c->scale) return false;
    for (int k = c->n_start; k < c->n_start + c->n_flight; k++) {
        slope[0] += c->multiple * a->t[k];
        slope[1] += c->multiple * b->t[k];
    }
    for (int i = 0; i <= PERIODS; i++) {
        double x = (double)i / PERIODS, y = x * x * (3 - 2 * x),
               t = T[0] + (T[1] - T[0]) * y + H * x * (1 - x) * (slope[0] * (1 - x) - slope[1] * x);
        low = fmin(low, t);
        high = fmax(high, t);
    }
    return ric_resonance_faint(c->model, tr->limits->multiply, low, high) > 1;
}

static void adapt(ric_continuation *tr, double h, const ric_course *way)
{
    double factor = way->angle > STRAIGHT ? STEP_ANGLE / way->angle : 2;
    if (way->iterations > 3) factor = fmin(factor, 0.7);
    factor = fmax(0.3, fmin(2, factor));
    tr->step_max = tr->limits->max_step * tr->chain->scale;
    tr->step = fmin(h * factor, tr->step_max);
    if (tr->after > 0) tr->step = fmin(tr->step, tr->after);
    tr->after = 0;
}

/* An event ends a branch where a margin goes through zero; what the first step ignores at the start
 * must have come out on the right side, and not stay at zero: contacts that stay together, or
 * impacts that stay without speed, are no branch. */
static bool margins_hold(const ric_station *p, unsigned ignored)
{
    static const int margins[] = {RIC_TEST_REACH, RIC_TEST_APPROACH, RIC_TEST_FLIGHT};
    for (int i = 0; i < 3; i++)
        if (!(p->test[margins[i]] > (ignored & 1u << margins[i] ? RIC_MARGIN : -RIC_MARGIN)))
            return false;
    return true;
}

/* Whether a first step has left a branch that is shorter: between two grazings with slow impacts
 * some are, and of what vanishes at the start no crossing is seen within it. */
static bool over_the_end(const ric_continuation *tr, double h)
{
    return !tr->has_past && !tr->limits->ghost && h > SHORTEST * tr->chain->scale &&
           !margins_hold(&tr->next, tr->ignore);
}

static void swap_stations(ric_continuation *tr)
{
    ric_station old = tr->past;
    tr->past = tr->now;
    tr->now = tr->next;
    tr->next = old;
    tr->has_past = true;
}

/* The two halves of the period of an orbit between two mirror points of one kind are images of each
 * other: then its branch is another one. */
static bool symmetric_after_all(const ric_shooting *c)
{
    int n = c->n;
    double off = 0;
    if (ric_periodic_has_events(c->model) || c->start != c->end || c->start == RIC_MIRROR_NONE)
        return false;
    for (int i = 0; i < 2 * n; i++) off = fmax(off, fabs(c->w[i] + c->w[2 * n + i]));
    return off < RIC_SAME_SOLVED * c->scale;
}

/* Under a power law a branch may come to another one at a small angle, and a step that is long for
 * what is left slips over to it. The bordered determinant tells: its zero ahead, by the secant, is
 * approached by steps that leave some of the way. */
static double before_crossing(const ric_continuation *tr, double h)
{
    double f0 = tr->past.test[RIC_TEST_DET], f1 = tr->now.test[RIC_TEST_DET],
           least = LAST_STEP * tr->chain->scale;
    if (!ric_flight_law_of(tr->chain->model)->integrated || !tr->has_past || tr->ignore ||
        !(f0 * f1 > 0) || fabs(f1) >= fabs(f0) || h <= least)
        return h;
    double x = (tr->now.s - tr->past.s) * f1 / (f0 - f1);
    return fmin(h, fmax(x / 3, least));
}

const char *ric_continuation_why_text(ric_why why)
{
    static const char *const text[RIC_N_WHY] = {
        [RIC_WHY_NONE] = "",
        [RIC_WHY_ENERGY_MAX] = "upper end of the energy window",
        [RIC_WHY_ENERGY_MIN] = "lower end of the energy window",
        [RIC_WHY_FREQUENCY_MAX] = "upper end of the frequency window",
        [RIC_WHY_FREQUENCY_MIN] = "lower end of the frequency window",
        [RIC_WHY_CLOSED] = "back at its start",
        [RIC_WHY_POINTS] = "largest number of points of a branch",
        [RIC_WHY_NO_STEP] = "no step, however small, stays on the branch",
        [RIC_WHY_NO_JUNCTION] = "the junction at the end does not converge",
        [RIC_WHY_NO_FIT] = "the branch does not fit the junction at its end",
        [RIC_WHY_TOUCHES] = "its end touches more often than is looked at, or rests on a contact",
        [RIC_WHY_TONGUE] = "border of a tongue that is stepped over",
        [RIC_WHY_NO_WAY_BACK] = "the way back does not lead home",
    };
    return text[why];
}

/* What is known of a step before it is taken: a tongue that is stepped over, branches of several
 * periods ahead. *over: there is no step to take. */
static ric_status look_ahead(ric_continuation *tr, double *h, bool *over, bool *done)
{
    int order;
    ric_status status = ric_leap_try(tr, over);
    if (status || *over) return status;
    tr->longest = HUGE_VAL;
    if ((status = ric_multiple_cover_ahead(tr, h, &order, &tr->mid))) return status;
    *h = before_crossing(tr, *h);
    if (order > 3) {
        *over = *done = true;
        return ric_event_arrive(tr, &tr->mid);
    }
    if (order < 3) return RIC_OK;
    /* there the branch passes, and the determinant touches zero */
    status = ric_event_keep(tr, RIC_TEST_DET, &tr->mid);
    if (!status) tr->ignore |= 1u << RIC_TEST_DET;
    return status;
}

static ric_status stop_with(ric_continuation *tr, ric_stop stop, ric_why why, bool *done)
{
    tr->stop = stop;
    tr->why = why;
    *done = true;
    return RIC_OK;
}

/* The step from `now` to `next` has been taken: what it leaves for the one after it. */
static ric_status move_on(ric_continuation *tr, bool *done)
{
    for (int i = 0; i < RIC_N_TEST; i++)
        if (tr->next.test[i] != 0) tr->definite[i] = tr->next.test[i];
    if (!tr->limits->ghost && !margins_hold(&tr->next, tr->ignore))
        return ric_fail(RIC_E_NUMERIC,
                        "the branch is not admissible beside its start: margins %.3g in flight, "
                        "%.3g in speed, %.3g in time",
                        tr->next.test[RIC_TEST_REACH], tr->next.test[RIC_TEST_APPROACH],
                        tr->next.test[RIC_TEST_FLIGHT]);
    ric_status status = ric_leap_leave(tr, done);
    if (status || *done) return status;
    /* what is broken off here is done again: nothing that a stop may reach comes behind the first
     * change of a station */
    if ((status = ric_trust(ric_continuation_keep(tr, &tr->next)))) return status;
    tr->ignore = 0;
    tr->approaches = 0;
    if (fabs(tr->next.test[RIC_TEST_DET]) > fabs(tr->now.test[RIC_TEST_DET])) tr->avoided = false;
    ric_event_samples_shift(tr);
    ric_continuation_remember(tr, &tr->next);
    swap_stations(tr);
    return RIC_OK;
}

ric_status ric_continuation_advance(ric_continuation *tr, bool *done)
{
    ric_status status = RIC_OK;
    double h = tr->step, size = tr->chain->scale;
    *done = false;
    tr->too_long = HUGE_VAL;
    if (tr->n_point >= tr->limits->max_points)
        return stop_with(tr, RIC_STOP_BUDGET, RIC_WHY_POINTS, done);
    bool over;
    if ((status = look_ahead(tr, &h, &over, done)) || over) return status;
    for (;;) {
        ric_course way = {0};
        bool good = ric_continuation_try(tr, h, &way);
        tr->evaluations += way.iterations + 1;
        good = good && !symmetric_after_all(tr->chain) &&
               !(tr->may_gain && ric_symmetric_end_gains(tr->chain, tr->next.u));
        const bool solved = good;
        good = good && ric_continuation_stays(tr, &way);
        double shorter;
        if (good && ric_leap_ahead(tr, h, &shorter)) {
            if (shorter > 0) h = shorter;
            else if ((status = ric_leap_try(tr, &over)) || over) return status;
            continue;
        }
        if (good && !crowded(tr, h)) {
            if ((status = ric_continuation_look(tr, &tr->next, way.orientation, RIC_LOOK_ALL)))
                return status;
            if (over_the_end(tr, h)) {
                h *= 0.125;
                continue;
            }
            if (!ric_event_suspicious(tr, h)) {
                bool retry = false;
                if ((status = ric_event_find(tr, h, done, &retry))) return status;
                if (*done) return RIC_OK;
                if (!retry) {
                    adapt(tr, h, &way);
                    break;
                }
                if (tr->wanted > 0) {
                    h = tr->wanted;
                    tr->wanted = 0;
                    continue;
                }
            }
        }
        tr->too_long = h;
        h *= solved ? 0.5 : 0.25;
        if (h < SMALLEST_STEP * size) return stop_with(tr, RIC_STOP_FAILED, RIC_WHY_NO_STEP, done);
    }
    return move_on(tr, done);
}

ric_status ric_continuation_run(ric_continuation *tr)
{
    bool done = false;
    ric_status status = RIC_OK;
    while (!done && !status) {
        const ric_continuation_place here = ric_continuation_mark(tr);
        status = ric_trust(ric_continuation_advance(tr, &done));
        if (status == RIC_E_INTERRUPTED) ric_continuation_return(tr, &here);
        else if (tr->limits->stepped) tr->limits->stepped(tr->limits->user);
    }
    if (!status && tr->n_point == 0)
        return ric_fail(RIC_E_NUMERIC, "no orbit of the branch can be solved for");
    return status;
}
