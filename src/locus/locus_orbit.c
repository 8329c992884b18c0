/* Orbits on the surface of place along the branch and parameter, and the charts in which a locus is
 * solved. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "flow/room.h"
#include "locus_parts.h"

/* HALF_OPEN: reach, of the clearance: gaps that open less are no touches, nor near one */
#define HALF_OPEN 0.5
/* TOGETHER: of the clearance: touches that symmetry brings about together differ by less. SAME: a
 * touch that goes with the one that is followed may be larger by that, which is rounding; what
 * breaks the symmetry makes it more */
#define TOGETHER 1e-6
#define SAME 1e-9
#define DIRECTION 0.01 /* part by which two measurements of a direction may differ */
#define SHORTEST 1e-7  /* half step of a difference, of the orbit and of the range */
#define STEP_LAST                                                                                  \
    1e-9 /* of the size: a secant whose last step is longer has not come to a zero                 \
          */
enum { TOUCHES_MOST = 64, SECANT_STEPS = 15 };

void ric_locus_orbit_free(ric_locus_orbit *o)
{
    ric_shooting_free(o->chain);
    ric_model_free(o->model);
    free(o->u);
    free(o->t);
    free(o->along);
    *o = (ric_locus_orbit){.p = 0};
}

/* ---------------------------------------------------------------- measures */

static int by_value(const void *a, const void *b)
{
    const ric_touch *x = a, *y = b;
    return x->value < y->value ? 1 : x->value > y->value ? -1 : x->time < y->time ? -1 : 1;
}

static int by_size(const void *a, const void *b)
{
    const double x = fabs(*(const double *)a), y = fabs(*(const double *)b);
    return x < y ? -1 : x > y;
}

/* What other touches leave: by how much they are smaller than the one that is followed, `own`, but
 * for those `together` with it, itself among them, which are as large: none of them may be larger
 * by more than rounding. */
static double spare_of(int n, const ric_touch *touches, int own, int together)
{
    double off[TOUCHES_MOST], spare = 1 - HALF_OPEN;
    int others = 0;
    for (int i = 0; i < n; i++)
        if (i != own) off[others++] = touches[i].value - touches[own].value;
    qsort(off, (size_t)others, sizeof *off, by_size);
    for (int i = 0; i < others; i++)
        spare = fmin(spare, i < together - 1 ? TOGETHER * fmin(1, 1 - off[i] / SAME) : -off[i]);
    return spare;
}

/* How far a touch is from the one that is followed. */
static double apart(const ric_locus_orbit *o, const ric_locus_touch *from, const ric_touch *to)
{
    if (to->flight != from->flight || to->face != from->face) return HUGE_VAL;
    return fabs(to->time / o->u[o->chain->n_start + to->flight] - from->share);
}

/* The gaps in flight: the value of the touch that is followed, NAN if it is lost, and what the
 * others leave. Without `from` the touch is the largest, and those that are as large go with it. */
static double measure_gaps(const ric_locus_problem *q, const ric_locus_touch *from,
                           ric_locus_orbit *o, int *n_touch)
{
    ric_touch touches[TOUCHES_MOST];
    const bool grazing = q->what.test == RIC_TEST_TOUCH;
    int n = ric_reach_all(o->chain, o->u, HALF_OPEN, TOUCHES_MOST, touches), own = -1;
    n = n < TOUCHES_MOST ? n : TOUCHES_MOST;
    qsort(touches, (size_t)n, sizeof *touches, by_value);
    o->spare[0] = 1 - HALF_OPEN;
    if (!grazing) {
        if (n) o->spare[0] = 1 - touches[0].value;
        return NAN;
    }
    for (int i = 0; i < n && from; i++)
        if (isfinite(apart(o, from, &touches[i])) &&
            (own < 0 || apart(o, from, &touches[i]) < apart(o, from, &touches[own])))
            own = i;
    if (!from && n) {
        own = 0;
        for (*n_touch = 1; *n_touch < n && touches[*n_touch].value > touches[0].value - TOGETHER;)
            ++*n_touch;
    }
    if (own < 0) return NAN;
    const ric_touch *touch = &touches[own];
    o->touch = (ric_locus_touch){touch->flight, touch->face,
                                 touch->time / o->u[o->chain->n_start + touch->flight]};
    o->spare[0] = spare_of(n, touches, own, *n_touch);
    return touch->value - 1;
}

static double shortest_flight(const ric_locus_problem *q, const ric_locus_orbit *o)
{
    const ric_shooting *c = o->chain;
    double least = HUGE_VAL;
    for (int k = 0; k < c->n_flight; k++)
        if (k != q->place && c->face[k] >= 0 && c->face[k + 1] >= 0)
            least = fmin(least, o->u[c->n_start + k]);
    return isfinite(least) ? least : 1;
}

static double definite(double value, double error)
{
    return fabs(value) > error ? value : NAN;
}

/* Signs that tell what else is met: extrema of energy and period, and kernels that break a
 * symmetry. */
static void measure_meetings(const ric_locus_problem *q, const ric_floquet *f, ric_locus_orbit *o)
{
    const ric_shooting *c = o->chain;
    const bool kernel = ric_criterion_breaks_symmetry(q->what.test) ||
                        q->what.test == RIC_TEST_ROTATION;
    double period = 0;
    for (int k = c->n_start; k < c->n_start + c->n_flight; k++) period += o->t[k];
    o->meets[0] = q->what.test == RIC_TEST_SLOPE
                      ? NAN
                      : definite(ric_shooting_energy_slope(c, o->t) / c->scale,
                                 ric_continuation_blur(c, RIC_TEST_SLOPE));
    o->meets[1] = q->what.test == RIC_TEST_PERIOD
                      ? NAN
                      : definite(period, ric_continuation_blur(c, RIC_TEST_PERIOD));
    o->meets[2] = kernel ? NAN : definite(f->det_a, f->error_a);
    o->meets[3] = kernel ? NAN : definite(f->det_b, f->error_b);
    o->meets[4] = kernel ? NAN : definite(f->det_d, f->error_d);
}

/* What vanishes, by the criterion of a junction; `near` (may be NULL) tells the orientation of the
 * larger problem. */
static double measure_criterion(ric_locus_problem *q, const ric_locus_orbit *near,
                                double orientation, ric_criterion_work *work, ric_locus_orbit *o)
{
    work->choice = q->choice;
    work->place = q->place;
    work->u = o->u;
    if (near && near->along) {
        const size_t size = (size_t)near->n_along * sizeof *near->along;
        if ((work->along = ric_malloc(size))) memcpy(work->along, near->along, size);
    }
    const double f = ric_criterion_value(work, o->u, o->t, orientation);
    q->choice = work->choice;
    o->along = work->along;
    o->n_along = work->n_along;
    work->along = NULL;
    return f;
}

/* Everything about an orbit that has been solved: the chain is evaluated at u. */
static ric_status measure(ric_locus_problem *q, const ric_locus_orbit *near, ric_locus_orbit *o)
{
    ric_shooting *c = o->chain;
    const double *along = near && near->chain->n_unknown == c->n_unknown ? near->t : NULL;
    ric_criterion_work work = ric_criterion_begin(q->what, c);
    ric_status status = ric_floquet_create(c->n, &work.floquet);
    if (!status) status = ric_floquet_compute(c, &work.floquet);
    if (status) goto out;
    const double orientation = ric_continuation_tangent(c, along, o->t);
    const ric_margins margins = ric_continuation_margins(c, o->u);
    o->energy = ric_shooting_energy(c) * o->model->energy_unit;
    o->frequency = RIC_TWO_PI / ric_shooting_time(c, o->u) * o->model->omega_ref;
    o->length = ric_model_length(o->model);
    measure_meetings(q, &work.floquet, o);
    o->f = measure_gaps(q, near ? &near->touch : NULL, o, &q->n_touch);
    o->spare[1] = isfinite(margins.closing) ? margins.closing : 1;
    if (!near && q->what.test == RIC_TEST_FLIGHT) q->place = ric_criterion_shortest(c, o->u);
    o->spare[2] = shortest_flight(q, o);
    if (!near) q->sign = q->what.test == RIC_TEST_DET ? 0 : copysign(1, orientation * c->end_det);
    o->spare[3] = q->sign != 0 ? q->sign * orientation * c->end_det : 1;
    if (q->what.test != RIC_TEST_TOUCH) o->f = measure_criterion(q, near, orientation, &work, o);
    if (!isfinite(o->f))
        status = ric_fail(RIC_E_NUMERIC, "what vanishes at the junction is lost in rounding");
out:
    ric_criterion_release(&work);
    return ric_trust(status);
}

/* ------------------------------------------------------------------ orbits */

static ric_status open_orbit(const ric_locus_problem *q, double p, const ric_shooting *chain,
                             const double *u, ric_locus_orbit *o)
{
    o->p = p;
    ric_status status = ric_locus_model(q->base, &q->vary, p, chain->model, &o->model);
    if (!status) status = ric_locus_carry(chain, u, o->model, &o->chain, &o->u);
    if (!status && !(o->t = ric_calloc((size_t)o->chain->n_unknown, sizeof *o->t)))
        status = ric_no_memory("an orbit");
    return status;
}

static void take(ric_locus_orbit *from, ric_locus_orbit *to)
{
    ric_locus_orbit_free(to);
    *to = *from;
    *from = (ric_locus_orbit){.p = 0};
}

ric_status ric_locus_orbit_begin(ric_locus_problem *q, const ric_periodic *cycle,
                                 ric_locus_orbit *o)
{
    int iterations;
    *o = (ric_locus_orbit){.p = 0};
    ric_shooting *chain = NULL;
    double *u = NULL;
    ric_status status = ric_periodic_to_chain(q->base, cycle, &chain, &u);
    if (!status) ric_shooting_fly(chain, u);
    if (!status) status = open_orbit(q, q->vary.at, chain, u, o);
    ric_shooting_free(chain);
    free(u);
    if (status) return status;
    double du[o->chain->n_unknown];
    if (!ric_continuation_correct(o->chain, o->u, NULL, NULL, 0, du, &iterations))
        return ric_fail(RIC_E_NUMERIC, "the orbit of the junction does not converge");
    return measure(q, NULL, o);
}

/* The orbit at (a, b) of a chart. RIC_E_NUMERIC where there is none or it does not converge. offset
 * [n_unknown], may be NULL: of the orbit from the centre carried to its structure. */
static ric_status orbit_at(ric_locus_problem *q, const ric_locus_chart *chart, double a, double b,
                           double *offset, ric_locus_orbit *o)
{
    const ric_locus_orbit *centre = chart->centre;
    const int size = centre->chain->n_unknown;
    int iterations;
    double origin[size], du[size], target = a * centre->chain->scale;
    *o = (ric_locus_orbit){.p = 0};
    ric_status status = open_orbit(q, centre->p + b * ric_locus_range(&q->vary), centre->chain,
                                   centre->u, o);
    if (status) return status;
    memcpy(origin, o->u, sizeof origin);
    for (int i = 0; i < size; i++) o->u[i] += target * centre->t[i] + b * chart->drift[i];
    if (!ric_continuation_correct(o->chain, o->u, origin, centre->t, target, du, &iterations))
        return ric_fail(RIC_E_NUMERIC, "Newton's method does not converge");
    for (int i = 0; i < size && offset; i++) offset[i] = o->u[i] - origin[i];
    return measure(q, centre, o);
}

/* Secant iteration to the last digit: the best of what it passes counts. */
ric_status ric_locus_orbit_solve(ric_locus_problem *q, const ric_locus_chart *chart,
                                 const double at[2], const double across[2], ric_locus_orbit *out)
{
    double x0 = 0, x1 = 0, f0 = 0,
           slope = chart->slope[0] * across[0] + chart->slope[1] * across[1], last = HUGE_VAL;
    ric_status status = RIC_OK;
    ric_locus_orbit now;
    *out = (ric_locus_orbit){.f = HUGE_VAL};
    for (int i = 0; i < SECANT_STEPS && !status; i++) {
        status = orbit_at(q, chart, at[0] + x1 * across[0], at[1] + x1 * across[1], NULL, &now);
        const double f1 = now.f;
        const bool better = !status && fabs(f1) < fabs(out->f);
        if (better) take(&now, out);
        else ric_locus_orbit_free(&now);
        if (status || f1 == 0 || (!better && last <= STEP_LAST)) break;
        if (i > 0 && f1 != f0) slope = (f1 - f0) / (x1 - x0);
        x0 = x1;
        f0 = f1;
        x1 -= f1 / slope;
        last = fabs(x1 - x0);
        if (!isfinite(x1) || x1 == x0) break;
    }
    if (!status && !(last <= STEP_LAST) && out->f != 0)
        status = ric_fail(RIC_E_NUMERIC, "the junction is not found again");
    if (status) ric_locus_orbit_free(out);
    return status;
}

/* ------------------------------------------------------------------ charts */

void ric_locus_chart_free(ric_locus_chart *chart)
{
    free(chart->drift);
    chart->drift = NULL;
}

/* Central difference of f along an axis of the chart, with that of the unknowns, drift [n_unknown].
 */
static ric_status difference(ric_locus_problem *q, const ric_locus_chart *chart, int axis, double h,
                             double *drift, double *slope)
{
    const int size = chart->centre->chain->n_unknown;
    double offset[2][size], f[2];
    for (int side = 0; side < 2; side++) {
        const double x = side ? h : -h;
        ric_locus_orbit o;
        ric_status status = orbit_at(q, chart, axis ? 0 : x, axis ? x : 0, offset[side], &o);
        f[side] = o.f;
        ric_locus_orbit_free(&o);
        if (status) return status;
    }
    *slope = (f[1] - f[0]) / (2 * h);
    for (int i = 0; i < size; i++) drift[i] = (offset[1][i] - offset[0][i]) / (2 * h);
    return RIC_OK;
}

/* Two lengths of a difference agree unless rounding, or another orbit next to this one, makes them:
 * the longest pair that does, as functions turn sharply where modes become commensurate. */
static ric_status slope_along(ric_locus_problem *q, ric_locus_chart *chart, int axis, double *drift)
{
    const int size = chart->centre->chain->n_unknown;
    double rough, other[size];
    for (double h = RIC_DIFFERENCE; h >= SHORTEST; h /= 10) {
        ric_status status = difference(q, chart, axis, h, drift, &chart->slope[axis]);
        if (!status) status = difference(q, chart, axis, 2 * h, other, &rough);
        if (status && status != RIC_E_NUMERIC) return status;
        if (!status) chart->doubt[axis] = fabs(chart->slope[axis] - rough);
        if (!status && chart->doubt[axis] <= DIRECTION * fabs(rough)) break;
    }
    return RIC_OK;
}

/* A slope that is next to nothing, as at a fold, is rounding: it counts with the other one. */
static ric_status slopes(ric_locus_problem *q, ric_locus_chart *chart)
{
    double drift[chart->centre->chain->n_unknown];
    ric_status status = slope_along(q, chart, 0, drift);
    if (!status) status = slope_along(q, chart, 1, chart->drift);
    if (status) return status;
    return hypot(chart->doubt[0], chart->doubt[1]) <=
                   DIRECTION * hypot(chart->slope[0], chart->slope[1])
               ? RIC_OK
               : ric_fail(RIC_E_NUMERIC, "its direction is lost in rounding");
}

ric_status ric_locus_chart_make(ric_locus_problem *q, const ric_locus_orbit *centre,
                                const double *before, ric_locus_chart *out)
{
    const int size = centre->chain->n_unknown;
    *out = (ric_locus_chart){.centre = centre,
                             .drift = ric_calloc((size_t)size, sizeof *out->drift)};
    ric_status status = out->drift ? slopes(q, out) : ric_no_memory("a chart");
    const double norm = hypot(out->slope[0], out->slope[1]),
                 drift = ric_dot(size, out->drift, out->drift);
    if (!status && !(norm > 0))
        status = ric_fail(RIC_E_NUMERIC, "the junction is not regular: two of them meet");
    if (status) {
        ric_locus_chart_free(out);
        return status;
    }
    out->ahead[0] = -out->slope[1] / norm;
    out->ahead[1] = out->slope[0] / norm;
    const double same = before ? ric_dot(2, out->ahead, before) : out->ahead[1];
    for (int i = 0; i < 2 && same < 0; i++) out->ahead[i] = -out->ahead[i];
    const double scale = centre->chain->scale, turn = out->ahead[1];
    out->stretch = sqrt(out->ahead[0] * out->ahead[0] +
                        turn * turn * (1 + drift / (scale * scale)));
    return RIC_OK;
}
