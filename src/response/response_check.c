/* Replays orbits of a response with the simulator, which knows nothing of how they were found. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "check/room.h"
#include "model/room.h"
#include "response.h"

/* What a replay may be off by, relative to the state, for each unit of growth: the digits of what
 * is stored. */
#define REPLAYED 1e-11
/* Multipliers from differences, relative to 1 + the largest. */
#define DIFFERENCED 1e-5
/* Half step of the differences, relative to 1 + the state: small against slow impacts, large
 * against the rounding of 80 bits. */
#define MOVED 1e-10
#define LATE 1e-6 /* of the period: the last event may come so late */
/* Of the size of the state, over the speed of the slowest impact: by so much the digits of what is
 * stored move its time. */
#define SLOW (16 * DBL_EPSILON)

typedef struct {
    const ric_response_curve *curve;
    const ric_response_point *p;
    const ric_model *model;
    int n, faces;
    ric_shaken *sim;
    double slowest; /* speed of an event */
} replay;

static int face_of(const replay *r, int k)
{
    return r->curve->letters ? r->curve->word[k % r->curve->letters] % r->faces : -1;
}

static bool begins_with_spring(const replay *r)
{
    return r->curve->letters && r->model->face[face_of(r, 0)].spring > 0;
}

/* The last event, and the state with which the period ends: at its end where a spring closes or
 * opens, through which the motion is smooth, as a slow closing comes early or late by more than the
 * digits of the state. */
static ric_status last_event(replay *r, bool *hit, ric_impact *impact, double *now)
{
    const double end = r->p->period * (1 + LATE);
    bool another = false;
    ric_impact other;
    ric_status status = RIC_OK;
    *hit = false;
    if (begins_with_spring(r)) {
        status = ric_shaken_advance(r->sim, r->p->period, hit, impact);
        if (!status && *hit) status = ric_shaken_advance(r->sim, r->p->period, &another, &other);
        ric_shaken_state(r->sim, NULL, now, now + r->n);
    }
    if (!status && !*hit) {
        status = ric_shaken_advance(r->sim, end, hit, impact);
        if (!begins_with_spring(r)) ric_shaken_state(r->sim, NULL, now, now + r->n);
    }
    *hit = *hit && !another;
    return status;
}

/* From its state through one period: how far it returns, and its events. */
static ric_status once_round(replay *r, ric_response_checked *out)
{
    const double *x = r->p->state, end = r->p->period * (1 + LATE);
    const int letters = r->curve->letters;
    double now[2 * r->n], size = 1, due = 0;
    ric_status status = ric_shaken_start(r->sim, x, x + r->n, r->p->phase);
    if (status) return status;
    ric_shaken_close(r->sim, face_of(r, 0));
    out->faces_agree = true;
    ric_shaken_state(r->sim, NULL, now, now + r->n);
    for (int k = 0; k < letters && out->faces_agree; k++) {
        bool hit;
        ric_impact impact;
        status = k + 1 < letters ? ric_shaken_advance(r->sim, end, &hit, &impact)
                                 : last_event(r, &hit, &impact, now);
        if (status) return status;
        due += r->p->flights[k];
        out->faces_agree = hit && impact.face == face_of(r, k + 1);
        if (!hit) break;
        r->slowest = fmin(r->slowest, fabs(impact.approach));
        out->flight_error = fmax(out->flight_error, fabs(impact.time - due) / r->p->period);
    }
    bool hit = false;
    ric_impact impact;
    if (!letters) {
        status = ric_shaken_advance(r->sim, r->p->period, &hit, &impact);
        ric_shaken_state(r->sim, NULL, now, now + r->n);
    }
    out->faces_agree = out->faces_agree && !hit;
    for (int i = 0; i < 2 * r->n; i++) size = fmax(size, 1 + fabs(x[i]));
    for (int i = 0; i < 2 * r->n; i++)
        out->return_error = fmax(out->return_error, fabs(now[i] - x[i]) / size);
    return status;
}

/* Through a period from a state at the phase after `begin`; false: other events than the word has.
 */
static bool map(replay *r, const ric_real *y, const bool *closed, double begin, ric_real *out)
{
    const double omega = r->p->omega;
    int count = 0;
    bool hit = true;
    if (ric_shaken_start_long(r->sim, y, (ric_real)r->p->phase + (ric_real)omega * begin))
        return false;
    ric_shaken_set(r->sim, closed);
    while (hit) {
        ric_impact impact;
        if (ric_shaken_advance(r->sim, r->p->period, &hit, &impact)) return false;
        count += hit;
    }
    ric_shaken_state_long(r->sim, NULL, out);
    return count == r->curve->letters;
}

/* The largest multiplier from differences of that length, NaN: they meet other events. X [4 n^2] is
 * workspace. */
static double differenced(replay *r, const ric_real *y, const bool *closed, double begin,
                          ric_real move, double *X)
{
    const int size = 2 * r->n;
    ric_real side[2][size];
    double mu[2 * size], largest = 0;
    for (int j = 0; j < size; j++) {
        for (int k = 0; k < 2; k++) {
            ric_real from[size];
            memcpy(from, y, sizeof from);
            from[j] += k ? move : -move;
            if (!map(r, from, closed, begin, side[k])) return NAN;
        }
        for (int i = 0; i < size; i++)
            X[i * size + j] = (double)((side[1][i] - side[0][i]) / (2 * move));
    }
    if (!ric_eigen(size, X, mu)) return NAN;
    for (int i = 0; i < size; i++) largest = fmax(largest, hypot(mu[2 * i], mu[2 * i + 1]));
    return largest;
}

/* Of the map that starts in the first flight. Beside a grazing the map bends: what half the step
 * changes is not known. */
static ric_status multipliers(replay *r, ric_response_checked *out)
{
    const int size = 2 * r->n;
    const double begin = r->p->flights[0] / 3;
    ric_real y[size];
    double size_of = 1, *X = ric_calloc((size_t)size * (size_t)size, sizeof *X);
    bool closed[r->faces + 1], hit;
    ric_impact impact;
    if (!X) return ric_no_memory("a replay");
    ric_status status = ric_shaken_start(r->sim, r->p->state, r->p->state + r->n, r->p->phase);
    if (!status) ric_shaken_close(r->sim, face_of(r, 0));
    if (!status) status = ric_shaken_advance(r->sim, begin, &hit, &impact);
    if (!status) {
        ric_shaken_state_long(r->sim, NULL, y);
        ric_shaken_closed(r->sim, closed);
        for (int i = 0; i < size; i++) size_of = fmax(size_of, 1 + fabs((double)y[i]));
        const double whole = differenced(r, y, closed, begin, MOVED * size_of, X),
                     half = differenced(r, y, closed, begin, MOVED * size_of / 2, X),
                     error = fabs(half - r->p->largest) - fabs(half - whole);
        out->multiplier_error = fmax(0, error) / (1 + r->p->largest);
        if (isnan(error)) out->multiplier_error = NAN;
    }
    free(X);
    return status;
}

static ric_status check(const ric_response *r, const ric_response_curve *c,
                        const ric_response_point *p, ric_response_checked *out)
{
    ric_shaking shaking = r->asked.shaking;
    shaking.restitution = p->restitution;
    replay now = {c,    p,       r->model, ric_model_n_dof(r->model), ric_model_n_face(r->model),
                  NULL, INFINITY};
    *out = (ric_response_checked){.multiplier_error = NAN};
    ric_status status = ric_shaken_create(r->model, &shaking, p->omega, p->level, &now.sim);
    if (!status) status = once_round(&now, out);
    if (!status && isfinite(p->largest)) status = multipliers(&now, out);
    ric_shaken_free(now.sim);
    /* What stays in contact is no orbit, and is an answer of the replay. */
    if (status == RIC_E_RANGE || status == RIC_E_NUMERIC) status = RIC_OK, out->faces_agree = false;
    const double growth = 1 + (isfinite(p->largest) ? p->largest : 0);
    double size = 1;
    for (int i = 0; i < 2 * now.n; i++) size = fmax(size, 1 + fabs(p->state[i]));
    const double slow = now.slowest > 0 ? SLOW * size / (now.slowest * p->period) : 0;
    out->passed = out->faces_agree && out->flight_error < REPLAYED * growth + slow &&
                  out->return_error < REPLAYED * growth && !(out->multiplier_error > DIFFERENCED);
    return status;
}

ric_status ric_response_check_point(const ric_response *r, int curve, int i,
                                    ric_response_checked *out)
{
    ric_response_curve c;
    ric_response_point p;
    ric_status status = ric_response_curve_at(r, curve, &c);
    if (!status) status = ric_response_point_at(r, curve, i, &p);
    return status ? status : check(r, &c, &p, out);
}
