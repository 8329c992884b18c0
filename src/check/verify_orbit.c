/* A stored orbit as the replay takes it (verify.c): its faces in the simulator's modal frame, its
 * events, the springs that are closed in each flight, and the expected chain. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "base/room.h"
#include "verify_parts.h"

static ric_status load_faces(replay *r)
{
    const real *c;
    ric_simulator_frame(r->sim, &r->omega, &c);
    for (int f = 0; f < r->n_face; f++) {
        face_t *face = &r->face[f];
        ric_contact contact;
        ric_status status = ric_model_face(r->model, f, &face->contact, &face->side, NULL);
        if (!status) status = ric_model_contact(r->model, face->contact, &contact);
        if (status) return status;
        face->c = c + face->contact * r->n;
        face->cc = ric_replay_dot(r->n, face->c, face->c);
        face->limit = contact.clearance / ric_model_length(r->model);
        face->spring = contact.law == RIC_LAW_BILINEAR ? contact.stiffness : 0;
    }
    return RIC_OK;
}

void ric_verify_replay_close(replay *r)
{
    ric_simulator_return(r->model, r->sim);
    free(r->face);
    free(r->store);
    free(r->stored);
    free(r->event);
    free(r->closed);
}

static ric_status allocate(replay *r)
{
    size_t n = (size_t)r->n, f = (size_t)r->n_flight;
    r->store = ric_calloc(5 * n + (f + 1) * (4 * n + 2), sizeof *r->store);
    r->stored = ric_calloc(5 * n + f, sizeof *r->stored);
    r->face = ric_calloc((size_t)r->n_face + 1, sizeof *r->face);
    if (!r->store || !r->stored || !r->face)
        return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit of %d flights", r->n_flight);
    r->state = r->stored;
    r->x = r->state + 2 * n;
    r->flights = r->x + 2 * n;
    r->frequency = r->flights + f;
    r->kappa = r->store;
    r->w = r->kappa + n;
    r->moved = r->w + 2 * n;
    r->tau = r->moved + 2 * n;
    r->speed = r->tau + f + 1;
    r->chain = r->speed + f + 1;
    r->trig = r->chain + (f + 1) * 2 * n;
    return RIC_OK;
}

/* The springs in each flight from the letters: those that the word opens before it closes them are
 * closed at its start. */
static void find_closed(replay *r)
{
    int N = r->n_flight, F = r->n_face;
    for (int f = 0; f < F; f++) {
        bool now = false;
        for (int i = 1; i <= r->branch.letters; i++) {
            int letter = r->branch.word[i % r->branch.letters];
            if (letter % F != f) continue;
            now = i < r->branch.letters ? letter >= F : letter < F;
            if (i < r->branch.letters) break;
        }
        for (int k = 0; k < N; k++) {
            r->closed[(size_t)k * (size_t)F + (size_t)f] = r->face[f].spring > 0 && now;
            if (r->branch.letters && r->branch.word[(k + 1) % N] % F == f) now = !now;
        }
    }
}

static ric_status load_events(replay *r)
{
    bool springs = false;
    int letters = r->branch.letters;
    for (int f = 0; f < r->n_face; f++) springs |= r->face[f].spring > 0;
    r->event = ric_calloc((size_t)letters + 1, sizeof *r->event);
    if (springs)
        r->closed = ric_calloc((size_t)r->n_flight * (size_t)r->n_face + 1, sizeof *r->closed);
    if (!r->event || (springs && !r->closed))
        return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit of %d flights", r->n_flight);
    for (int k = 0; k < letters; k++) {
        int letter = r->branch.word[k];
        bool good = letter >= 0 && letter < (springs ? 2 : 1) * r->n_face;
        if (!good || (letter >= r->n_face && !(r->face[letter - r->n_face].spring > 0)))
            return ric_fail(RIC_E_FORMAT,
                            "branch %d: letter %d of its word is no face of the model",
                            r->branch.id, k);
        r->event[k] = letter % r->n_face;
    }
    r->n_event = letters;
    if (springs) find_closed(r);
    return RIC_OK;
}

/* The orbit from its next event on. */
static void start_later(replay *r)
{
    int N = r->n_event, first = r->event[0];
    size_t F = (size_t)r->n_face;
    bool closed[F];
    real tau = r->tau[0];
    ric_replay_fly(r, 0, tau, r->chain, r->chain);
    ric_replay_reflect(r, ric_replay_end_face(r, 0), r->chain);
    memcpy(closed, r->closed, sizeof closed);
    memmove(r->closed, r->closed + F, (size_t)(N - 1) * sizeof closed);
    memcpy(r->closed + (size_t)(N - 1) * F, closed, sizeof closed);
    for (int i = 0; i + 1 < N; i++) {
        r->event[i] = r->event[i + 1];
        r->tau[i] = r->tau[i + 1];
    }
    r->event[N - 1] = first;
    r->tau[N - 1] = tau;
}

/* Whether the contact that flight k is has no length: what its spring exchanges, over a parabola,
 * is below the last digit of the motion. */
static bool is_nothing(const replay *r, int k)
{
    const face_t *face = &r->face[r->event[k]];
    real fastest = 0, tau = r->tau[k];
    for (int i = 0; i < r->n; i++) fastest = fmax(fastest, r->omega[i]);
    return tau <= NO_LENGTH * r->period &&
           face->spring * face->cc * fastest * tau * tau * tau / 12 <= DBL_EPSILON;
}

/* Contacts of no length are touches: both events go, and the flights before, in and behind them
 * become one. */
static void drop_touches(replay *r)
{
    size_t F = (size_t)r->n_face;
    for (int k = 0; k < r->n_event; k++) {
        int N = r->n_event, next = (k + 1) % N;
        if (r->event[k] != r->event[next] || !(r->face[r->event[k]].spring > 0) ||
            !is_nothing(r, k))
            continue;
        if (N > 2 && (k == 0 || next == 0)) {
            start_later(r);
            k = -1;
            continue;
        }
        r->tau[N > 2 ? k - 1 : 0] += N > 2 ? r->tau[k] + r->tau[k + 1] : r->tau[1];
        if (N == 2) memcpy(r->closed, r->closed + F * (size_t)(1 - k), F * sizeof *r->closed);
        for (int i = k; i + 2 < N; i++) {
            r->event[i] = r->event[i + 2];
            r->tau[i] = r->tau[i + 2];
            memmove(r->closed + (size_t)i * F, r->closed + (size_t)(i + 2) * F,
                    F * sizeof *r->closed);
        }
        r->n_event = N - 2;
        r->n_flight = N > 2 ? N - 2 : 1;
        k = -1;
    }
}

static ric_status prepare(replay *r, const ric_model *model)
{
    r->model = model;
    r->n = ric_model_n_dof(r->model);
    r->n_face = ric_model_n_face(r->model);
    r->n_flight = r->branch.letters > 0 ? r->branch.letters : 1;
    r->depth = DEPTH;
    return allocate(r);
}

/* The frequencies that the library says, in the order of the simulator's modes. */
static ric_status load_frequencies(replay *r)
{
    const int n = r->n;
    double said[n];
    ric_status status = ric_model_frequencies(r->model, said);
    for (int i = 0; i < n && !status; i++) {
        r->frequency[i] = said[0];
        for (int j = 1; j < n; j++)
            if (fabs(said[j] - r->omega[i]) < fabs(r->frequency[i] - r->omega[i]))
                r->frequency[i] = said[j];
    }
    return status;
}

/* From the state and the flights. */
static ric_status make_orbit(replay *r, bool touches)
{
    ric_status status = ric_simulator_borrow(r->model, &r->sim);
    if (!status) status = load_faces(r);
    if (!status) status = load_frequencies(r);
    if (!status) status = load_events(r);
    if (status) return status;
    for (int k = 0; k < r->n_flight; k++) {
        r->tau[k] = r->flights[k];
        r->period += r->tau[k];
    }
    for (int i = 0; i < r->n; i++)
        r->kappa[i] = r->omega[i] > 0 ? r->omega[i] : 2 * acos((real)-1) / r->period;
    r->energy = ric_model_energy(r->model, r->state, r->state + r->n);
    ric_simulator_modal(r->sim, r->state, r->state + r->n, r->chain);
    r->norm = ric_replay_distance(r, r->chain, NULL);
    if (r->closed && !touches) drop_touches(r);
    ric_replay_make_chain(r);
    return RIC_OK;
}

ric_status ric_verify_replay_open(replay *r, const ric_atlas *atlas, int branch, int point,
                                  bool touches)
{
    ric_status status = ric_atlas_branch(atlas, branch, &r->branch);
    if (!status) status = prepare(r, ric_atlas_model(atlas));
    if (!status) status = ric_atlas_point(atlas, branch, point, &r->point, r->state, r->flights);
    return status ? status : make_orbit(r, touches);
}

ric_status ric_verify_replay_open_orbit(replay *r, const ric_model *model, const ric_branch *like,
                                        const double *state, const double *flights)
{
    r->branch = *like;
    ric_status status = prepare(r, model);
    if (status) return status;
    memcpy(r->state, state, 2 * (size_t)r->n * sizeof *state);
    memcpy(r->flights, flights, (size_t)r->n_flight * sizeof *flights);
    return make_orbit(r, true);
}
