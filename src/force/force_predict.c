/* What the balance of energies of an orbit predicts of the forced structure, and how far that can
 * be trusted.
 *
 * From one period to the next the energy changes by L |V| cos(phase + arg V) - D and the phase of
 * the force by Omega dT/dE times what the energy is off: a pendulum in the plane of the two, with a
 * centre where dT/dE W'(phase) < 0 and a saddle where it is positive (Shaw and Wiggins 1988;
 * docs/forcing.md). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "force_stability.h"

/* Largest distance between the forced orbit and the one of the atlas, relative, at which the first
 * order is trusted: the second is then a hundredth. */
#define NEAR 0.1
/* The part of the way to a grazing, or to where the period does not depend on the energy, that the
 * forced orbit may go. */
#define HALF_WAY 0.5
/* Relative: a period that does not depend on the energy, to what steps of a branch tell. */
#define CONSTANT_PERIOD 1e-9
/* Of the integrand: a work that is nothing but rounding. */
#define NO_WORK 1e-11
/* Relative: what quadrature may leave. */
#define WELL_KNOWN 1e-6

/* ------------------------------------------------------------------- slope */

/* The three stored points around an arclength, at places of their own: a junction may be stored
 * twice. False: there are fewer. */
static bool around(const ric_atlas *a, const ric_branch *b, double arclength, ric_point out[3])
{
    ric_point last[3], p;
    double least = INFINITY;
    int n = 0;
    for (int i = 0; i < b->n_point && !ric_atlas_point(a, b->id, i, &p, NULL, NULL); i++) {
        if (n > 0 && fabs(p.arclength - last[2].arclength) <= RIC_TIE * (1 + fabs(p.arclength)))
            continue;
        last[0] = last[1];
        last[1] = last[2];
        last[2] = p;
        n++;
        if (n < 3 || !(fabs(last[1].arclength - arclength) < least)) continue;
        least = fabs(last[1].arclength - arclength);
        memcpy(out, last, sizeof last);
    }
    return isfinite(least);
}

/* First and second derivative at a place of the parabola through three values. */
static void parabola(const double s[3], const double y[3], double at, double out[2])
{
    const double first = (y[1] - y[0]) / (s[1] - s[0]), second = (y[2] - y[1]) / (s[2] - s[1]),
                 bend = (second - first) / (s[2] - s[0]);
    out[0] = first + bend * (2 * at - s[0] - s[1]);
    out[1] = 2 * bend;
}

/* d log T / d log E along a branch, from three stored points around the orbit, and by which part of
 * itself it changes with log E. NaN: there are fewer. */
typedef struct {
    double log_t, change;
} course;

static course course_of(const ric_atlas *a, const ric_branch *b, double arclength)
{
    double s[3], e[3], t[3], by_e[2], by_t[2];
    ric_point p[3];
    if (!around(a, b, arclength, p)) return (course){NAN, NAN};
    for (int k = 0; k < 3; k++) {
        s[k] = p[k].arclength;
        e[k] = log(p[k].energy);
        t[k] = -log(p[k].frequency);
    }
    parabola(s, t, arclength, by_t);
    parabola(s, e, arclength, by_e);
    return (course){by_t[0] / by_e[0], (by_t[1] / by_t[0] - by_e[1] / by_e[0]) / by_e[0]};
}

/* -------------------------------------------------------------------- trust */

/* Distance of the multipliers other than the trivial ones from 1, as sqrt |2 - lambda - 1 / lambda|
 * of the nearest pair: the factor by which they damp the answer to a small force. 1 where there are
 * none. */
static double away_from_one(const ric_orbit *orbit)
{
    const int n = ric_model_n_mode(ric_orbit_model(orbit)) - 1;
    double least = 1, multipliers[4 * n + 1];
    if (n < 1 || ric_orbit_multipliers(orbit, multipliers)) return 1;
    for (int k = 0; k < 2 * n; k++) {
        const double re = multipliers[2 * k] - 1, im = multipliers[2 * k + 1];
        least = fmin(least, hypot(re, im) / sqrt(fmax(1, hypot(re + 1, im))));
    }
    return isfinite(least) ? least : 0; /* lost in rounding: nothing is known */
}

/* What of a motion of this energy is left until it grazes, relative. */
static double margin(const ric_point *p)
{
    double least = INFINITY;
    if (!isnan(p->reach)) least = fmin(least, 1 - p->reach);
    if (!isnan(p->approach)) least = fmin(least, p->approach / sqrt(2 * p->energy));
    return least;
}

/* How far a force of this amplitude moves the structure to and fro, relative to the motion: slow
 * modes as free masses, fast ones as springs. Large where the motion has little of the harmonic in
 * question, and the force must be large. */
static double shake(const ric_force *f, double level, const ric_prediction *p)
{
    double sum = 0;
    for (int i = 0; i < f->n; i++) {
        const double speed = level * f->g[i] / fmax(p->omega, f->model->frequency[i]);
        sum += speed * speed;
    }
    return sqrt(sum / (2 * p->energy));
}

/* What the estimate of the next order is made of. */
typedef struct {
    double exchanged,
        shaken;  /* energy in a period; by the force to and fro: both relative to the motion */
    double away; /* of multipliers from 1 */
    course way;
} reasons;

/* The energy that is exchanged in a period, relative, moves amplitudes by half as much; the time
 * that this costs has to be made up by the energy, where the period hardly depends on it by a large
 * part; multipliers near 1 answer with as much more, to the force within a period, too. A level
 * that is no farther from the threshold than this may be on its other side. */
static double estimate(const reasons *r)
{
    return r->exchanged / 2 * (1 + 1 / (2 * RIC_TWO_PI * fabs(r->way.log_t)) + 1 / r->away) +
           r->shaken * (1 + 1 / r->away);
}

static void judge(const ric_point *point, const reasons *r, double level, ric_prediction *p)
{
    const double drift = r->exchanged / (4 * RIC_TWO_PI * fabs(r->way.log_t));
    p->estimate = estimate(r);
    p->why = "";
    if (isinf(p->threshold)) p->why = "work";
    else if (!(p->error <= WELL_KNOWN)) p->why = "error";
    else if (!(fabs(r->way.log_t) > CONSTANT_PERIOD) || !(drift <= NEAR) ||
             !(2 * drift * fabs(r->way.change) <= HALF_WAY))
        p->why = "period";
    else if (!(r->shaken <= NEAR)) p->why = "force";
    else if (!((r->exchanged / 2 + r->shaken) / r->away <= NEAR)) p->why = "multiplier";
    else if (!(p->estimate <= NEAR)) p->why = "size";
    else if (!(p->estimate <= HALF_WAY * margin(point))) p->why = "grazing";
    else if (level > 0 && !(fabs(level / p->threshold - 1) > p->estimate)) p->why = "level";
    p->trusted = !*p->why;
}

/* ------------------------------------------------------------------- phases */

/* -arg V +- acos(D / (L |V|)): the plus belongs to a falling W, which is a centre where dT/dE > 0.
 */
static void find_phases(double level, double work, double loss, double log_t, ric_prediction *p)
{
    if (!(level >= p->threshold) || isinf(p->threshold)) return;
    const double angle = acos(fmin(1, loss / (level * work))), way = log_t < 0 ? -1 : 1,
                 middle = -atan2(p->work[1], p->work[0]);
    p->n_phase = 2;
    p->phases[0] = remainder(middle + way * angle, RIC_TWO_PI);
    p->phases[1] = remainder(middle - way * angle, RIC_TWO_PI);
}

bool ric_force_predict_works(const ric_force_balance *sum)
{
    return hypot(sum->work[0], sum->work[1]) > (NO_WORK + sum->error) * sum->size;
}

ric_status ric_force_predict_balance(const ric_force *f, int branch, const ric_orbit *orbit,
                                     int harmonic, double level, ric_prediction *out)
{
    ric_branch b;
    ric_point point;
    ric_force_balance sum;
    if (harmonic < 1)
        return ric_fail(RIC_E_INPUT, "harmonic %d; harmonics are 1, 2, 3, ...", harmonic);
    if (!(level >= 0 && isfinite(level)))
        return ric_fail(RIC_E_INPUT, "a level is an amplitude of the force, above 0");
    ric_status status = ric_atlas_branch(f->atlas, branch, &b);
    if (!status)
        status = ric_force_balance_of(f, orbit, ric_branch_linear(f->model, &b), harmonic, &sum);
    if (status) return status;
    ric_orbit_data(orbit, &point, NULL, NULL, NULL);
    const course way = course_of(f->atlas, &b, point.arclength);
    const double loss = sum.damping + sum.impacts, work = hypot(sum.work[0], sum.work[1]),
                 log_t = way.log_t;
    const bool works = ric_force_predict_works(&sum);
    *out = (ric_prediction){.energy = point.energy,
                            .frequency = point.frequency,
                            .harmonic = harmonic,
                            .omega = harmonic * point.frequency,
                            .loss_damping = sum.damping,
                            .loss_impacts = sum.impacts,
                            .work = {sum.work[0], sum.work[1]},
                            .threshold = works ? loss / work : INFINITY,
                            .threshold_impacts = works ? sum.impacts / work : INFINITY,
                            .error = sum.error,
                            .slope = log_t * RIC_TWO_PI / point.frequency / point.energy};
    find_phases(level, work, loss, log_t, out);
    out->stable = RIC_STABLE_UNDECIDED;
    const reasons r = {.exchanged = fmax(loss, works ? level * work : 0) / point.energy,
                       .shaken = works ? shake(f, fmax(level, out->threshold), out) : 0,
                       .away = away_from_one(orbit),
                       .way = way};
    judge(&point, &r, level, out);
    return RIC_OK;
}

ric_status ric_force_predict(const ric_force *f, int branch, const ric_orbit *orbit, int harmonic,
                             double level, ric_prediction *out)
{
    ric_branch b;
    ric_status status = ric_force_predict_balance(f, branch, orbit, harmonic, level, out);
    if (status || out->slope == 0 || !isfinite(1 / out->slope)) return status;
    status = ric_atlas_branch(f->atlas, branch, &b);
    return status ? status : ric_force_stability(f, &b, orbit, out->estimate, &out->stable);
}
