/* From an orbit of an atlas to the exact forced orbit beside it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "force_exact.h"

#define UNDECIDED 1e-9 /* multipliers nearer to the circle than this decide nothing, however well they are known */

static ric_status check(const ric_force *f, const ric_orbit *orbit, int harmonic, double level)
{
    const ric_model *m = f->model;
    if (harmonic < 1) return ric_fail(RIC_E_INPUT, "harmonic %d; harmonics are 1, 2, 3, ...", harmonic);
    if (!(level > 0 && isfinite(level))) return ric_fail(RIC_E_INPUT, "a level is an amplitude of the force, above 0");
    for (int i = 0; i < m->n_contact; i++)
        if (!ric_model_detached(m) || m->spring[i] > 0)
            return ric_fail(RIC_E_INPUT,
                            "exact forced orbits are computed between rigid stops only; contact %d is a "
                            "spring, for which there is the prediction",
                            i + 1);
    if (!f->diagonal)
        return ric_fail(RIC_E_INPUT,
                        "exact forced orbits are computed with modal damping only, and this matrix couples "
                        "modes; give ratios, or a matrix alpha M + beta K");
    if (ric_orbit_letters(orbit) == 0)
        return ric_fail(RIC_E_INPUT, "a linear mode meets no stop: its forced motion is that of the linear structure");
    return RIC_OK;
}

/* Unknowns from the orbit of the atlas and the phase predicted. */
static void guess(const ric_force *f, const ric_force_exact *e, const ric_orbit *orbit, double phase, double *work,
                  double *u)
{
    const int n = e->n;
    double *state = work, *flights = work + 2 * n, t = f->model->omega_ref;
    ric_orbit_data(orbit, NULL, state, flights, NULL);
    ric_force_modal(f, state, state + n, u, u + n);
    for (int i = 0; i < n; i++) {
        u[i] *= e->unit;
        u[n + i] *= e->unit / t;
    }
    for (int k = 0; k < e->N; k++) u[2 * n + k] = flights[k] * t;
    u[2 * n + e->N] = phase;
}

static double apart(int n, const double *a, const double *b)
{
    double most = 0, size = 1;
    for (int i = 0; i < n; i++) {
        most = fmax(most, fabs(a[i] - b[i]));
        size = fmax(size, 1 + fabs(b[i]));
    }
    return most / size;
}

static void leave(const ric_force *f, const ric_force_exact *e, const double *u, double *state, double *flights)
{
    const int n = e->n;
    const double t = f->model->omega_ref, *Phi = f->model->Phi;
    for (int j = 0; j < n; j++) {
        state[j] = state[n + j] = 0;
        for (int i = 0; i < n; i++) {
            state[j] += Phi[j * n + i] * u[i] / e->unit;
            state[n + j] += Phi[j * n + i] * u[n + i] * t / e->unit;
        }
    }
    for (int k = 0; k < e->N; k++) flights[k] = u[2 * n + k] / t;
}

static ric_stability judge(int n, const double *multipliers, double rounding, double *largest)
{
    const double near = fmax(rounding, UNDECIDED);
    *largest = 0;
    for (int i = 0; i < 2 * n; i++) *largest = fmax(*largest, hypot(multipliers[2 * i], multipliers[2 * i + 1]));
    return *largest < 1 - near ? RIC_STABLE_YES : *largest > 1 + near ? RIC_STABLE_NO : RIC_STABLE_UNDECIDED;
}

/* u solved: what leaves. */
static ric_status answer(const ric_force *f, const ric_force_exact *e, const double *u, const double *start,
                         ric_forced *out, double *state, double *flights, double *multipliers)
{
    double rounding = 0;
    out->fault = ric_force_motion_fault(e, u);
    out->distance = apart(2 * e->n, u, start);
    out->phase = remainder(u[2 * e->n + e->N], RIC_TWO_PI);
    leave(f, e, u, state, flights);
    if (!ric_force_motion_multipliers(e, u, multipliers, &rounding))
        return ric_trust(ric_fail(RIC_E_NUMERIC, "the multipliers of a forced orbit cannot be computed"));
    out->stable = judge(e->n, multipliers, rounding, &out->largest);
    return RIC_OK;
}

ric_status ric_force_solve(const ric_force *f, const ric_orbit *orbit, int harmonic, double level, double phase,
                           ric_forced *out, double *state, double *flights, double *multipliers)
{
    ric_force_exact *e = NULL;
    ric_point point;
    const int N = ric_orbit_letters(orbit), n = f->n;
    *out = (ric_forced){.fault = "Newton's method does not converge", .stable = RIC_STABLE_UNDECIDED};
    ric_status status = check(f, orbit, harmonic, level);
    if (status) return status;
    int *word = ric_calloc((size_t)N, sizeof *word);
    double *u = ric_calloc(4 * (size_t)(2 * n + N + 1), sizeof *u);
    if (!word || !u) {
        status = ric_no_memory("a forced orbit");
        goto out;
    }
    double *start = u + 2 * n + N + 1, *work = start + 2 * n + N + 1;
    ric_orbit_data(orbit, &point, NULL, NULL, word);
    out->omega = harmonic * point.frequency;
    if ((status = ric_force_exact_create(f, N, word, out->omega, harmonic, level, &e))) goto out;
    guess(f, e, orbit, phase, work, u);
    memcpy(start, u, (size_t)(2 * n + N + 1) * sizeof *u);
    if (ric_force_exact_solve(e, u, &out->residual)) status = answer(f, e, u, start, out, state, flights, multipliers);
    if (!status) status = ric_trust(RIC_OK);
out:
    ric_force_exact_free(e);
    free(word);
    free(u);
    return status;
}
