/* From an atlas to the response of the shaken structure: curves from the predictions of first order
 * and from the linear motion, and from what they meet, task by task. Each task is done or not done
 * in the file, so the order is always the same. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "response_keep.h"

enum {
    STARTS = 3, /* of a run of stored orbits above the threshold */
    KEY_MAX = 96
};

/* ------------------------------------------------------------------- starts */

/* A solved start: followed if it is a motion, and new. */
static ric_status take_start(ric_response_driver *d, ric_force_orbit *o, int branch, bool *taken)
{
    double margin;
    ric_status status = ric_response_trace_margin(o, &margin);
    const double value = *ric_force_orbit_parameter(o, d->trace.along);
    *taken = !status && margin > 0 && value >= d->trace.window[0] && value <= d->trace.window[1];
    if (*taken && !ric_response_keep_repeats(o) && !ric_response_keep_known(d, o))
        return ric_response_keep_follow(d, o, NULL, branch, 0);
    ric_force_orbit_free(o);
    return status;
}

/* Whether the structure has a steady answer with the springs of each flight: Newton's method would
 * only say that it does not converge. */
static ric_status answers(const ric_response_driver *d, const ric_force_orbit *o)
{
    const ric_force_frame *frame;
    ric_status status = RIC_OK;
    for (int k = 0; k < o->N && !status && !d->medium->smooth; k++)
        status = ric_force_frame_find(d->medium, o->closed[k], o->drive.omega, &frame);
    return status;
}

static ric_status start_linear(ric_response_driver *d)
{
    ric_force_orbit *o = NULL;
    bool taken;
    ric_status status = RIC_OK;
    for (int end = 0; end < 2 && !status; end++) {
        double omega = d->r->asked.omega / d->medium->time, level = d->level;
        if (d->trace.along == RIC_ALONG_OMEGA) omega = d->trace.window[end];
        if (d->trace.along == RIC_ALONG_LEVEL) level = d->trace.window[end];
        status = ric_response_keep_forgive(d, ric_force_start_linear(d->medium, omega, level, &o));
        if (!o) continue;
        const ric_status resonant = answers(d, o);
        if (!status) status = ric_response_keep_forgive(d, resonant);
        if (d->trace.along == RIC_ALONG_RESTITUTION) o->drive.restitution = d->trace.window[end];
        if (!status && !resonant &&
            ric_force_orbit_solve(o, d->trace.along, d->trace.scale, NULL, 0, NULL))
            status = take_start(d, o, 0, &taken);
        else ric_force_orbit_free(o);
        o = NULL;
    }
    return status;
}

/* Both phases at one orbit of the atlas; *taken: one of them was found. */
static ric_status start_beside(ric_response_driver *d, int branch, const ric_orbit *orbit,
                               int harmonic, double level, bool *taken)
{
    ric_prediction p;
    ric_status status = ric_force_predict_balance(d->force, branch, orbit, harmonic, level, &p);
    *taken = false;
    for (int k = 0; k < p.n_phase && !status; k++) {
        ric_force_orbit *o = NULL;
        bool one = false;
        ric_status possible = ric_force_start_from(d->medium, orbit, harmonic, level, p.phases[k],
                                                   &o);
        if (!possible) possible = answers(d, o);
        status = ric_response_keep_forgive(d, possible);
        if (o && !possible && ric_force_start_settle(o))
            status = ric_response_keep_forgive(d, take_start(d, o, branch, &one));
        else ric_force_orbit_free(o);
        *taken = *taken || one;
    }
    return status;
}

/* How good a start an orbit is: lower is better, NaN is none. */
static double merit(ric_response_driver *d, int branch, const ric_orbit *orbit, int harmonic)
{
    ric_prediction p;
    if (ric_force_predict_balance(d->force, branch, orbit, harmonic, 0, &p)) return NAN;
    const double omega = p.omega / d->medium->time;
    if (!(p.threshold < d->level) || omega < d->trace.window[0] || omega > d->trace.window[1])
        return NAN;
    return p.threshold / d->level + (p.trusted ? 0 : 1);
}

/* Of a run of stored orbits [from, to] above the threshold: at its best place, then towards its
 * ends. */
static ric_status start_run(ric_response_driver *d, int branch, int harmonic, int from, int to,
                            const double *merits)
{
    int best = from;
    ric_status status = RIC_OK;
    for (int i = from; i <= to; i++)
        if (merits[i] < merits[best]) best = i;
    const int places[STARTS] = {best, (best + to) / 2, (best + from) / 2};
    bool taken = false;
    for (int k = 0; k < STARTS && !status && !taken; k++) {
        ric_orbit **orbits = NULL;
        int n = 0;
        if (k > 0 && places[k] == best) continue;
        status = ric_orbit_find(d->atlas, branch, RIC_AT_POINT, places[k], &n, &orbits);
        if (!status && n > 0)
            status = start_beside(d, branch, orbits[0], harmonic, d->level, &taken);
        ric_orbits_free(n, orbits);
    }
    return status;
}

static ric_status along_omega(ric_response_driver *d, const ric_branch *b, int harmonic)
{
    double *merits = ric_calloc((size_t)b->n_point + 2, sizeof *merits);
    ric_status status = merits ? RIC_OK : ric_no_memory("a response");
    int from = -1;
    for (int i = 0; i < b->n_point && !status; i++) {
        ric_orbit **orbits = NULL;
        int n = 0;
        ric_point point;
        merits[i] = NAN;
        if (ric_atlas_point(d->atlas, b->id, i, &point, NULL, NULL) || !(point.energy > 0))
            continue;
        status = ric_orbit_find(d->atlas, b->id, RIC_AT_POINT, i, &n, &orbits);
        if (!status && n > 0) merits[i] = merit(d, b->id, orbits[0], harmonic);
        ric_orbits_free(n, orbits);
    }
    for (int i = 0; i <= b->n_point && !status; i++) {
        const bool good = i < b->n_point && !isnan(merits[i]);
        if (good && from < 0) from = i;
        if (good || from < 0) continue;
        status = start_run(d, b->id, harmonic, from, i - 1, merits);
        from = -1;
    }
    free(merits);
    return status;
}

/* At one frequency: twice the threshold where the level varies. */
static ric_status at_omega(ric_response_driver *d, const ric_branch *b, int harmonic)
{
    ric_orbit **orbits = NULL;
    int n = 0;
    ric_prediction p;
    bool taken;
    ric_status status = ric_orbit_find(d->atlas, b->id, RIC_AT_FREQUENCY,
                                       d->r->asked.omega / harmonic, &n, &orbits);
    for (int i = 0; i < n && !status; i++) {
        double level = d->level;
        status = ric_force_predict_balance(d->force, b->id, orbits[i], harmonic, 0, &p);
        if (!status && d->trace.along == RIC_ALONG_LEVEL)
            level = fmin(2 * p.threshold, (p.threshold + d->trace.window[1]) / 2);
        if (!status && isfinite(level))
            status = start_beside(d, b->id, orbits[i], harmonic, level, &taken);
    }
    ric_orbits_free(n, orbits);
    return status == RIC_E_RANGE ? RIC_OK : status;
}

/* -------------------------------------------------------------------- tasks */

static ric_status done(ric_response_driver *d, const char *key, int curve, int event)
{
    ric_status status = ric_trust(RIC_OK);
    if (!status) status = ric_response_store_put(d->file, d->r, curve, event, key);
    if (!status && !ric_response_add_task(d->r, key)) status = ric_no_memory("a response");
    return status;
}

static ric_status start_all(ric_response_driver *d, int place)
{
    const ric_response_options *a = &d->r->asked;
    char key[KEY_MAX];
    ric_branch b;
    ric_status status = RIC_OK;
    const int first = a->branch ? a->branch : 0,
              last = a->branch ? a->branch : ric_atlas_n_branch(d->atlas);
    for (int id = first; id <= last && !status; id++)
        for (int h = 0; h < (id ? a->n_harmonic : 1) && !status; h++) {
            const int curve = d->r->n_curve + 1, event = d->r->n_event + 1;
            if (id) status = ric_atlas_branch(d->atlas, id, &b);
            snprintf(key, sizeof key, "level %d branch %s harmonic %d", place,
                     id && !status ? b.key : "-", id ? a->harmonics[h] : 1);
            if (status || ric_response_did(d->r, key)) continue;
            if (id == 0) status = start_linear(d);
            const bool moves = id && !status && !(b.letters == 0 && d->medium->model->n_face);
            if (id && a->branch && !status && !moves)
                status = ric_response_keep_forgive(
                    d,
                    ric_fail(
                        RIC_E_NUMERIC,
                        "branch %d is a linear mode, which meets no stop: its forced motion is "
                        "that of the linear structure, which is followed where no branch is named",
                        id));
            if (moves)
                status = a->along == RIC_RESPONSE_OMEGA ? along_omega(d, &b, a->harmonics[h])
                                                        : at_omega(d, &b, a->harmonics[h]);
            if (!status) status = done(d, key, curve, event);
        }
    return status;
}

static ric_status leave_all(ric_response_driver *d)
{
    char key[KEY_MAX];
    ric_status status = RIC_OK;
    for (int id = 1; id <= d->r->n_event && !status; id++) {
        const int curve = d->r->n_curve + 1, event = d->r->n_event + 1;
        snprintf(key, sizeof key, "event %d", id);
        if (ric_response_did(d->r, key)) continue;
        status = ric_response_leave(d, id);
        if (!status) status = done(d, key, curve, event);
    }
    return status;
}

/* ---------------------------------------------------------------------- call */

static ric_status check(const ric_response_options *o)
{
    const double *w = o->window;
    if (!(isfinite(w[0]) && isfinite(w[1]) && w[0] > 0 && w[1] > w[0]))
        return ric_fail(
            RIC_E_INPUT,
            "the window is %.10g to %.10g; give two numbers above 0, the smaller one first", w[0],
            w[1]);
    if (o->along == RIC_RESPONSE_RESTITUTION && !(w[1] <= 1))
        return ric_fail(RIC_E_INPUT,
                        "the window of the restitution is %.10g to %.10g; it is at most 1", w[0],
                        w[1]);
    if (o->along != RIC_RESPONSE_OMEGA && !(o->omega > 0 && isfinite(o->omega)))
        return ric_fail(RIC_E_INPUT, "the frequency of the force is missing; give it in rad/s");
    if (o->along != RIC_RESPONSE_LEVEL && o->n_level < 1)
        return ric_fail(RIC_E_INPUT, "the level of the force is missing; give one or several");
    for (int i = 0; i < o->n_level && o->along != RIC_RESPONSE_LEVEL; i++)
        if (!(o->levels[i] > 0 && isfinite(o->levels[i])))
            return ric_fail(RIC_E_INPUT,
                            "level %.10g; a level is an amplitude of the force, above 0",
                            o->levels[i]);
    for (int i = 0; i < o->n_harmonic; i++)
        if (o->harmonics[i] < 1)
            return ric_fail(RIC_E_INPUT, "harmonic %d; harmonics are 1, 2, 3, ...",
                            o->harmonics[i]);
    if (!(o->step > 0 && o->step <= 1))
        return ric_fail(RIC_E_INPUT, "step %.10g; give a number above 0, at most 1", o->step);
    return RIC_OK;
}

/* A restitution is one of rigid stops. */
static ric_status check_along(const ric_force_medium *m, const ric_response_options *o)
{
    bool rigid = o->along != RIC_RESPONSE_RESTITUTION;
    for (int f = 0; f < m->model->n_face && !rigid; f++) rigid = ric_force_medium_rigid(m, f);
    if (rigid) return RIC_OK;
    return ric_fail(
        RIC_E_INPUT,
        "the restitution cannot vary, as no contact of this structure is rigid; vary the "
        "frequency or the level of the force");
}

static ric_status open_driver(const ric_atlas *atlas, const ric_response_options *o,
                              const char *path, ric_response_driver *d)
{
    *d = (ric_response_driver){.atlas = atlas};
    ric_shaking shaking = o->shaking;
    if (o->along == RIC_RESPONSE_RESTITUTION) shaking.restitution = o->window[1];
    ric_status status = check(o);
    if (!status) status = ric_force_create(atlas, &shaking, &d->force);
    if (!status) status = ric_force_medium_create(d->force, &d->medium);
    if (!status) status = check_along(d->medium, o);
    ric_branch b;
    if (!status && o->branch) status = ric_atlas_branch(atlas, o->branch, &b);
    if (status) return status;
    d->r = ric_response_create(d->medium->model);
    if (d->r) d->r->atlas = atlas;
    char *text = d->r && ric_response_take(d->r, o) ? ric_response_store_text(d->r) : NULL;
    if (!text) return ric_no_memory("a response");
    status = ric_response_store_open(path, text, ric_study_text(ric_atlas_study(atlas)), d->r,
                                     &d->file);
    free(text);
    const double unit = o->along == RIC_RESPONSE_OMEGA ? d->medium->time : 1;
    d->trace = (ric_response_trace_options){.along = (ric_force_along)o->along,
                                            .scale = o->along == RIC_RESPONSE_LEVEL ? o->window[1]
                                                                                    : 1,
                                            .window = {o->window[0] / unit, o->window[1] / unit},
                                            .step = o->step,
                                            .points = o->points};
    return status;
}

ric_status ric_response_run(const ric_atlas *atlas, const ric_response_options *o, const char *path,
                            bool (*stop)(void *user), void *user)
{
    ric_response_driver d;
    ric_status status = open_driver(atlas, o, path, &d);
    ric_halt_ask(stop, user);
    if (!status && !d.r->finished) {
        const int levels = o->along == RIC_RESPONSE_LEVEL ? 1 : o->n_level;
        for (int i = 0; i < levels && !status; i++) {
            d.level = o->along == RIC_RESPONSE_LEVEL ? o->window[0] : o->levels[i];
            status = start_all(&d, i);
        }
        if (!status) status = leave_all(&d);
        if (!status) status = ric_response_store_finish(d.file);
    }
    ric_halt_ask(NULL, NULL);
    ric_response_store_close(d.file);
    ric_response_free(d.r);
    ric_force_medium_free(d.medium);
    ric_force_free(d.force);
    return status;
}
