#include "force_start.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "orbit/room.h"

/* Under a power law the period is divided, so that no part multiplies errors by much. */
enum { SMOOTH_PARTS = 4 };

/* The state at phase 0 of the force, which is that much later: *z of the solver. */
static ric_status smooth_start(const ric_orbit *orbit, double phase, double period,
                               ric_force_orbit *o)
{
    const int n = o->n;
    double state[2 * n];
    double later = -phase / (o->drive.omega * o->medium->time);
    later -= floor(later / period) * period;
    ric_orbit_at_time(orbit, later, state, state + n);
    ric_force_motion_enter(o->medium, state, o->u);
    for (int k = 0; k < o->N; k++) {
        double *u = ric_force_orbit_node(o, k);
        u[2 * n + 1] = ric_force_orbit_period(o) / o->N;
        u[2 * n] = k * o->drive.omega * u[2 * n + 1];
    }
    return ric_force_orbit_spread(o);
}

ric_status ric_force_start_from(ric_force_medium *m, const ric_orbit *orbit, int harmonic,
                                double level, double phase, ric_force_orbit **out)
{
    ric_point point;
    const int n = m->n;
    double state[2 * n];
    ric_status status;
    *out = NULL;
    ric_orbit_data(orbit, &point, NULL, NULL, NULL);
    const ric_force_drive drive = {harmonic * point.frequency / m->time, level,
                                   m->force->restitution};
    if (m->smooth) {
        status = ric_force_orbit_create(m, SMOOTH_PARTS, NULL, NULL, harmonic, out);
        if (status) return status;
        (*out)->drive = drive;
        return smooth_start(orbit, phase, RIC_TWO_PI / point.frequency, *out);
    }
    ric_orbit_data(orbit, NULL, state, NULL, NULL);
    ric_periodic *c = ric_force_cycle(m->force, orbit, state);
    if (!c) return ric_no_memory("a forced orbit");
    uint64_t closed[c->N + 1];
    for (int k = 0; k < c->N; k++) closed[k] = ric_periodic_closed(m->model, c, k);
    status = ric_force_orbit_create(m, c->N, c->face, closed, harmonic, out);
    if (!status) {
        (*out)->drive = drive;
        ric_force_motion_enter(m, state, (*out)->u);
        for (int k = 0; k < c->N; k++) ric_force_orbit_node(*out, k)[2 * n + 1] = c->tau[k];
        (*out)->u[2 * n] = phase;
        status = ric_force_orbit_spread(*out);
    }
    ric_periodic_free(c);
    return status;
}

/* To first order the phase is free: beside the orbit of the atlas Newton's method hardly knows it.
 * So it is held first, while the level is free, and the level is brought back on what this gives.
 */
bool ric_force_start_settle(ric_force_orbit *o)
{
    const int size = 2 * o->n;
    const double level = o->drive.level;
    double row[o->m + 1], rate[size];
    memset(row, 0, sizeof row);
    ric_force_medium_rate(o->medium, o->closed[0], &o->drive, o->u[size], o->u, rate);
    const double speed = sqrt(ric_dot(size, rate, rate));
    for (int i = 0; i < size && !o->events; i++) row[i] = rate[i] / speed;
    row[size] = o->events;
    if (!ric_force_orbit_solve(o, RIC_ALONG_LEVEL, level, row, ric_dot(o->m, row, o->u), NULL))
        return false;
    o->drive.level = level;
    return ric_force_orbit_solve(o, RIC_ALONG_LEVEL, level, NULL, 0, NULL);
}

ric_status ric_force_start_linear(ric_force_medium *m, double omega, double level,
                                  ric_force_orbit **out)
{
    const int n = m->n, parts = m->smooth ? SMOOTH_PARTS : 1;
    ric_status status = ric_force_orbit_create(m, parts, NULL, NULL, 1, out);
    if (status) return status;
    (*out)->drive = (ric_force_drive){omega, level, m->force->restitution};
    for (int k = 0; k < parts; k++) {
        double *u = ric_force_orbit_node(*out, k);
        u[2 * n + 1] = ric_force_orbit_period(*out) / parts;
        u[2 * n] = k * omega * u[2 * n + 1];
    }
    return RIC_OK;
}
