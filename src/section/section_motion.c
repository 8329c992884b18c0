#include "section_motion.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* Faces that are met within this part of a gap of each other are met together. */
#define TOGETHER 1e-12
/* Panels that a flight is searched for: some 10^5 periods of the fastest mode. */
#define PANELS_MOST 2000000

/* ------------------------------------------------------------------ create */

ric_status ric_section_motion_create(const ric_model *m, double energy, ric_section_motion **out)
{
    size_t n = (size_t)m->n, contacts = (size_t)m->n_contact, smooth = 0;
    const ric_flight_law *law = ric_flight_law_of(m);
    ric_section_motion *s = ric_calloc(1, sizeof *s);
    *out = NULL;
    if (!s) return ric_no_memory("a motion");
    if (law->integrated) smooth = ric_power_flow_work(m, 2) + 16 * n + 2;
    s->m = m;
    s->n = m->n;
    s->closes = law->closes;
    s->smooth = law->integrated;
    s->energy = energy;
    size_t search = 4 * n + 8 * contacts;
    s->store = ric_calloc(8 * n + 4 * n * n + (smooth > search ? smooth : search) + 2,
                          sizeof *s->store);
    if (!s->store) {
        free(s);
        return ric_no_memory("a motion");
    }
    s->w = s->store;
    s->u = s->w + 2 * n;
    s->rate = s->u + 2 * n;
    s->next = s->rate + 2 * n;
    s->matrix = s->next + 2 * n;
    s->work = s->matrix + 4 * n * n;
    *out = s;
    return RIC_OK;
}

void ric_section_motion_free(ric_section_motion *s)
{
    if (!s) return;
    for (int i = 0; i < s->n_phase; i++) ric_section_phase_release(&s->phases[i]);
    free(s->phases);
    free(s->store);
    free(s);
}

/* The phase with these springs closed, made when it is first met. */
static ric_status find_phase(ric_section_motion *s, const ric_section_phase **out)
{
    for (int i = 0; i < s->n_phase; i++)
        if (s->phases[i].closed == s->closed) {
            *out = &s->phases[i];
            return RIC_OK;
        }
    ric_section_phase *more = ric_realloc(s->phases, (size_t)(s->n_phase + 1) * sizeof *more);
    if (!more) return ric_no_memory("a phase of a section");
    s->phases = more;
    ric_status status = ric_section_phase_create(s->m, s->closed, &more[s->n_phase]);
    if (!status) *out = &more[s->n_phase++];
    return status;
}

/* ------------------------------------------------------------------ states */

void ric_section_motion_pass(ric_section_motion *s, double tau)
{
    double step = s->low + tau, sum = s->time + step;
    s->low = step - (sum - s->time);
    s->time = sum;
}

void ric_section_motion_onto(int n, const double *g, double gap, double *w)
{
    double square = 0, s = 0;
    for (int i = 0; i < n; i++) {
        s += g[i] * w[i];
        square += g[i] * g[i];
    }
    for (int i = 0; i < n; i++) w[i] -= (s - gap) / square * g[i];
}

/* One step of Newton's method along the gradient h of the energy. */
void ric_section_motion_level(ric_section_motion *s)
{
    int n = s->n;
    double off = ric_flight_energy(s->m, s->closed, s->w) - s->energy, square = 0, *h = s->next;
    ric_flight_rate(s->m, s->closed, s->w, s->rate);
    for (int i = 0; i < n; i++) {
        h[i] = -s->rate[n + i] / s->m->kappa[i];
        h[n + i] = s->w[n + i];
        square += h[i] * h[i] + h[n + i] * h[n + i];
    }
    for (int i = 0; i < 2 * n && square > 0; i++) s->w[i] -= off / square * h[i];
}

static const ric_face *face_under(const ric_section_motion *s, ric_face *own)
{
    if (!s->smooth) return s->face >= 0 ? &s->m->face[s->face] : NULL;
    if (s->face < 0) return NULL;
    *own = (ric_face){.contact = s->face / 2, .c = s->m->c + s->face / 2 * s->n};
    own->cc = ric_dot(s->n, own->c, own->c);
    return own;
}

void ric_section_motion_start(ric_section_motion *s, uint64_t closed, int face, const double *w)
{
    ric_face own;
    s->closed = closed;
    s->face = face;
    s->time = s->low = 0;
    s->why[0] = '\0';
    memcpy(s->w, w, 2 * (size_t)s->n * sizeof *s->w);
    if (face >= 0) ric_section_motion_level(s);
    ric_flight_rate(s->m, closed, s->w, s->rate);
    ric_section_measure_begin(s->m, s->w, s->rate, s->u, &s->measure);
    const ric_face *on = face_under(s, &own);
    if (on) ric_section_measure_leave(&s->measure, on, s->w, s->rate, s->u);
    else s->measure.turning = false;
}

/* ----------------------------------------------------------------- flights */

static double argument(const double *from, const double *to)
{
    return atan2(from[0] * to[1] - from[1] * to[0], from[0] * to[0] + from[1] * to[1]);
}

/* With all springs open the number turns by the sum of the frequencies; a free mode moves it along
 * a straight line beside that, by less than half a turn. */
static void fly_open(ric_section_motion *s, double tau)
{
    int n = s->n;
    const ric_model *m = s->m;
    bool free_mode = s->measure.turning && (m->omega[0] == 0 || m->omega[1] == 0);
    double *trig = s->matrix, before[2], after[2], turn = 0;
    if (free_mode) {
        ric_flight_rate(m, 0, s->w, s->rate);
        ric_section_measure_number(m, s->w, s->rate, s->u, before);
    }
    ric_flight_trig(m, n, tau, trig);
    ric_flight(n, trig, s->w, s->w);
    ric_flight(n, trig, s->u, s->u);
    if (!s->measure.turning) return;
    for (int i = 0; i < n; i++) turn += m->omega[i] * tau;
    s->measure.angle -= turn;
    if (!free_mode) return;
    double back[2] = {cos(turn) * before[0] + sin(turn) * before[1],
                      cos(turn) * before[1] - sin(turn) * before[0]};
    ric_flight_rate(m, 0, s->w, s->rate);
    ric_section_measure_number(m, s->w, s->rate, s->u, after);
    s->measure.angle += argument(back, after);
}

/* A flight with springs closed, in parts of a panel, in which the number turns by less than half a
 * turn. The state is that from the start of the flight. */
static void fly_closed(ric_section_motion *s, const ric_section_phase *p, double tau)
{
    int size = 2 * s->n, parts = s->measure.turning && p->panel > 0 ? 1 + (int)(tau / p->panel) : 1;
    double begin[size], before[2], after[2];
    const ric_face *closing = ric_face_in(s->closed, s->face) ? &s->m->face[s->face] : NULL;
    memcpy(begin, s->w, sizeof begin);
    ric_regime_matrix(p->regime, tau / parts, s->matrix);
    if (s->measure.turning) ric_section_measure_number(s->m, s->w, s->rate, s->u, before);
    for (int k = 1; k <= parts; k++) {
        ric_regime_fly(p->regime,
                       &(ric_regime_course){closing, k < parts ? tau * k / parts : tau, begin},
                       s->w);
        for (int i = 0; i < size; i++) s->next[i] = ric_dot(size, s->matrix + i * size, s->u);
        memcpy(s->u, s->next, (size_t)size * sizeof *s->u);
        if (!s->measure.turning) continue;
        ric_flight_rate(s->m, s->closed, s->w, s->rate);
        ric_section_measure_number(s->m, s->w, s->rate, s->u, after);
        s->measure.angle += argument(before, after);
        memcpy(before, after, sizeof before);
    }
}

/* ------------------------------------------------------------------ events */

/* Two stops at one instant: only if their normals are orthogonal does the order not matter. */
static bool stands_alone(ric_section_motion *s, int f)
{
    const ric_model *m = s->m;
    const ric_face *face = &m->face[f];
    for (int k = 0; k < m->n_face; k++) {
        const ric_face *other = &m->face[k];
        if (other->contact == face->contact || other->spring > 0) continue;
        if (fabs(ric_gap(s->n, other, s->w) - other->gap) > TOGETHER * fabs(other->gap)) continue;
        if (ric_model_orthogonal(m, face->contact, other->contact)) continue;
        snprintf(s->why, sizeof s->why,
                 "faces %d and %d are met together, and one impact changes the speed at the other",
                 f < k ? f : k, f < k ? k : f);
        return false;
    }
    return true;
}

/* The impact of the state and, with the time dt by which a neighbour comes later, of the deviation:
 * velocities are turned round, and dw (R f(w) - f(R w)) dt is added (saltation). */
static void reflect(ric_section_motion *s, const ric_face *face)
{
    int n = s->n;
    const double *F = s->rate + n;
    double *a = s->u, *p = s->u + n, speed = ric_dot(n, face->c, s->w + n),
           gap = ric_dot(n, face->g, a), dt = speed != 0 ? -gap / speed : 0,
           push = ric_dot(n, face->c, p) + dt * ric_dot(n, face->c, F);
    for (int i = 0; i < n; i++) {
        a[i] -= s->m->kappa[i] * 2 * gap / face->cc * face->c[i];
        p[i] -= 2 * push / face->cc * face->c[i];
    }
    ric_impact_reflect(n, face, s->w + n);
}

/* With all springs open the energy is a sum of squares: one factor puts it right. */
static void level(ric_section_motion *s)
{
    if (s->closed) {
        ric_section_motion_level(s);
        return;
    }
    double factor = 1 + (s->energy - ric_flight_energy(s->m, 0, s->w)) / (2 * s->energy);
    for (int i = 0; i < s->n; i++) {
        if (s->m->stiff[i] != 0) s->w[i] *= factor;
        s->w[s->n + i] *= factor;
    }
}

/* What the event does; whether it lies on the section. */
static bool meet(ric_section_motion *s, int f)
{
    const ric_face *face = &s->m->face[f];
    double square = ric_dot(2 * s->n, s->u, s->u);
    if (!(square > RIC_SECTION_SHORT && square < RIC_SECTION_LONG))
        ric_section_measure_growth(&s->measure, s->u);
    ric_section_motion_onto(s->n, face->g, face->gap, s->w);
    level(s);
    /* Where a force along the face is large, as of modes that are bent against each other, each of
     * the two undoes the other, and more at every event, if the state is left beside the face. */
    ric_section_motion_onto(s->n, face->g, face->gap, s->w);
    s->face = f;
    bool opens = face->spring > 0 && ric_face_in(s->closed, f);
    if (face->spring > 0) s->closed ^= (uint64_t)1 << f;
    ric_flight_rate(s->m, s->closed, s->w, s->rate);
    if (opens) return false;
    ric_section_measure_arrive(&s->measure, face, s->w, s->rate, s->u);
    if (face->spring == 0) reflect(s, face);
    ric_section_measure_leave(&s->measure, face, s->w, s->rate, s->u);
    return true;
}

ric_status ric_section_motion_next(ric_section_motion *s, int *face)
{
    if (s->smooth) return ric_section_power_next(s, face);
    for (;;) {
        const ric_section_phase *phase = NULL;
        const double *z = s->w;
        ric_status status = find_phase(s, &phase);
        if (status) return status;
        if (phase->regime) {
            ric_regime_enter(phase->regime, s->w, s->next);
            z = s->next;
        }
        ric_section_event event = ric_section_search(s->m, phase, z, s->face, PANELS_MOST, s->work);
        *face = event.face;
        if (event.face < 0 || event.rests) {
            snprintf(
                s->why, sizeof s->why,
                event.rests
                    ? "the structure stays on face %d: a lasting contact is outside the impact law"
                    : "the motion meets no face any more",
                event.face);
            return RIC_OK;
        }
        if (phase->regime) fly_closed(s, phase, event.time);
        else fly_open(s, event.time);
        ric_section_motion_pass(s, event.time);
        if (s->m->face[event.face].spring == 0 && !stands_alone(s, event.face)) return RIC_OK;
        if (meet(s, event.face)) return RIC_OK;
    }
}
