/* From an orbit of an atlas to the exact forced orbit beside it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "force_start.h"

static double apart(int n, const double *a, const double *b)
{
    double most = 0, size = 1;
    for (int i = 0; i < n; i++) {
        most = fmax(most, fabs(a[i] - b[i]));
        size = fmax(size, 1 + fabs(b[i]));
    }
    return most / size;
}

/* Solved: what leaves. Flights are those of the word, which an orbit without events has none of. */
static ric_status answer(const ric_force_orbit *o, const double *start, ric_forced *out,
                         double *state, double *flights, double *multipliers)
{
    double rounding = 0;
    ric_status status = ric_force_motion_fault(o, &out->fault);
    out->distance = apart(2 * o->n, o->u, start);
    out->phase = remainder(ric_force_orbit_theta(o, 0), RIC_TWO_PI);
    ric_force_motion_leave(o->medium, o->u, state);
    flights[0] = ric_force_orbit_period(o) / o->medium->time;
    for (int k = 0; o->events && k < o->N; k++)
        flights[k] = ric_force_orbit_tau(o, k) / o->medium->time;
    if (!status) status = ric_force_motion_multipliers(o, multipliers, &rounding, NULL);
    if (!status) out->stable = ric_force_motion_judge(o->n, multipliers, rounding, &out->largest);
    return status;
}

ric_status ric_force_solve(const ric_force *f, const ric_orbit *orbit, int harmonic, double level,
                           double phase, ric_forced *out, double *state, double *flights,
                           double *multipliers)
{
    ric_force_medium *medium = NULL;
    ric_force_orbit *o = NULL;
    double start[2 * f->n];
    *out = (ric_forced){.fault = "Newton's method does not converge",
                        .stable = RIC_STABLE_UNDECIDED};
    if (harmonic < 1)
        return ric_fail(RIC_E_INPUT, "harmonic %d; harmonics are 1, 2, 3, ...", harmonic);
    if (!(level > 0 && isfinite(level)))
        return ric_fail(RIC_E_INPUT, "a level is an amplitude of the force, above 0");
    if (ric_orbit_letters(orbit) == 0 && ric_model_detached(f->model))
        return ric_fail(
            RIC_E_INPUT,
            "a linear mode meets no stop: its forced motion is that of the linear structure");
    ric_status status = ric_force_medium_create(f, &medium);
    if (!status) status = ric_force_start_from(medium, orbit, harmonic, level, phase, &o);
    if (!status) {
        memcpy(start, o->u, sizeof start);
        out->omega = o->drive.omega * medium->time;
        if (ric_force_start_settle(o)) status = answer(o, start, out, state, flights, multipliers);
        out->residual = o->residual;
    }
    if (!status) status = ric_trust(RIC_OK);
    ric_force_orbit_free(o);
    ric_force_medium_free(medium);
    return status;
}
