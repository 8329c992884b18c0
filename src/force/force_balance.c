/* What an orbit of the conservative structure would lose by damping and impacts, and what a
 * harmonic force would do, over one period (docs/forcing.md; Hill, Neild and Cammarano 2016;
 * Cenedese and Haller 2020).
 *
 * Free flights in closed form: with P_i = p_i + i omega_i q_i at its start p_i(t) = Re(P_i e^{i
 * omega_i t}), and with I(a) = int_0^tau e^{i a t} dt
 *     int p_i p_j dt = Re(P_i P_j I(omega_i + omega_j) + P_i conj(P_j) I(omega_i - omega_j)) / 2,
 *     int p_i e^{i Omega t} dt = (P_i I(Omega + omega_i) + conj(P_i) I(Omega - omega_i)) / 2.
 * Flights against springs by the rule of Gauss with eight nodes in panels, halved until two of them
 * agree. */
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "flow/room.h"
#include "force.h"
#include "orbit/room.h"

#define AGREE 1e-13 /* relative: two quadratures of one flight; their rounding is a tenth of it */

enum {
    PANELS_FIRST = 2,
    PANELS_MOST = 4096
}; /* the last stands for a flight that does not settle; the error says so */

typedef double _Complex cplx;

/* int_0^tau e^{i a t} dt, without cancellation at a = 0. */
static cplx turned(double a, double tau)
{
    const double half = a * tau / 2;
    return tau * (half == 0 ? 1 : sin(half) / half) * cexp(I * half);
}

/* A flight of an orbit, and its place in the period of the force. */
typedef struct {
    const ric_force *force;
    uint64_t closed;
    int event;
    double tau, begin, Omega; /* seconds, rad/s */
    const double *w;          /* [2 n] of the model's own frame */
} flight;

/* q, p [n] at its start. */
static void free_flight(const flight *s, const double *q, const double *p, ric_force_balance *sum)
{
    const ric_force *f = s->force;
    const int n = f->n;
    const double *omega = f->model->frequency, tau = s->tau, Omega = s->Omega;
    cplx work = 0;
    for (int i = 0; i < n; i++) {
        const cplx P = p[i] + I * omega[i] * q[i];
        for (int j = 0; j < n; j++) {
            if (f->C[i * n + j] == 0) continue;
            const cplx Q = p[j] + I * omega[j] * q[j];
            sum->damping += f->C[i * n + j] / 2 *
                            creal(P * Q * turned(omega[i] + omega[j], tau) +
                                  P * conj(Q) * turned(omega[i] - omega[j], tau));
        }
        work += f->g[i] / 2 *
                (P * turned(Omega + omega[i], tau) + conj(P) * turned(Omega - omega[i], tau));
        sum->size += fabs(f->g[i]) * cabs(P) * tau;
    }
    work *= cexp(I * Omega * s->begin);
    sum->work[0] += creal(work);
    sum->work[1] += cimag(work);
}

/* -------------------------------------------------------------- quadrature */

static void add_sample(const flight *s, const double *w, double weight, double t,
                       ric_force_balance *sum)
{
    const ric_force *f = s->force;
    const int n = f->n;
    double x[n], v[n], q[n], p[n], loss = 0, push = 0;
    ric_model_to_state(f->model, w, x, v);
    ric_force_modal(f, x, v, q, p);
    for (int i = 0; i < n; i++) {
        loss += p[i] * ric_dot(n, f->C + i * n, p);
        push += f->g[i] * p[i];
    }
    sum->damping += weight * loss;
    sum->work[0] += weight * push * cos(s->Omega * (s->begin + t));
    sum->work[1] += weight * push * sin(s->Omega * (s->begin + t));
    sum->size += weight * fabs(push);
}

/* A flight that is integrated goes on from node to node; another one starts anew, with its closing.
 */
static ric_force_balance composite(const flight *s, int panels)
{
    const ric_model *m = s->force->model;
    const bool goes_on = ric_flight_law_of(m)->integrated;
    ric_force_balance sum = {0};
    double w[2 * m->n], last = 0;
    memcpy(w, s->w, sizeof w);
    for (int i = 0; i < 8 * panels; i++) {
        double weight;
        const double t = ric_gauss_node(s->tau, panels, i, &weight);
        if (goes_on) ric_flight_go(m, s->closed, -1, (t - last) * m->omega_ref, w, w);
        else ric_flight_go(m, s->closed, s->event, t * m->omega_ref, s->w, w);
        last = t;
        add_sample(s, w, weight, t, &sum);
    }
    return sum;
}

static double apart(const ric_force_balance *a, const ric_force_balance *b)
{
    const double loss = fabs(a->damping - b->damping) / (b->damping > 0 ? b->damping : 1),
                 work = hypot(a->work[0] - b->work[0], a->work[1] - b->work[1]) /
                        (b->size > 0 ? b->size : 1);
    return fmax(loss, work);
}

/* Against springs. */
static void pressed_flight(const flight *s, ric_force_balance *sum)
{
    ric_force_balance last = composite(s, PANELS_FIRST), now = last;
    double error = INFINITY;
    for (int panels = 2 * PANELS_FIRST; panels <= PANELS_MOST && !(error <= AGREE); panels *= 2) {
        now = composite(s, panels);
        const double before = error;
        error = apart(&last, &now);
        last = now;
        if (error >= before && error < RIC_TIE) break; /* rounding is all that is left */
    }
    sum->damping += now.damping;
    sum->work[0] += now.work[0];
    sum->work[1] += now.work[1];
    sum->size += now.size;
    sum->error = fmax(sum->error, isfinite(error) ? error : INFINITY);
}

/* ------------------------------------------------------------------ orbits */

static void impact(const ric_force *f, int face, const double *p, ric_force_balance *sum)
{
    const ric_model *m = f->model;
    const double *c = m->normal + (size_t)m->face[face].contact * (size_t)f->n,
                 speed = ric_dot(f->n, c, p), e = f->restitution;
    sum->impacts += (1 - e) * (1 + e) * speed * speed / (2 * ric_dot(f->n, c, c));
}

static void along_cycle(const ric_force *f, const ric_periodic *c, double Omega,
                        ric_force_balance *sum)
{
    const ric_model *m = f->model;
    const int n = f->n;
    double w[2 * m->n], after[2 * m->n], x[n], v[n], q[n], p[n], begin = 0;
    memcpy(w, c->w, sizeof w);
    for (int i = 0; i < c->N; i++) {
        const uint64_t closed = ric_periodic_closed(m, c, i);
        const int next = c->face[(i + 1) % c->N];
        const double tau = c->tau[i] / m->omega_ref;
        const flight s = {f, closed, c->face[i], tau, begin, Omega, w};
        ric_model_to_state(m, w, x, v);
        ric_force_modal(f, x, v, q, p);
        if (ric_flight_dense(m, closed)) pressed_flight(&s, sum);
        else free_flight(&s, q, p, sum);
        ric_flight_go(m, closed, c->face[i], c->tau[i], w, after);
        memcpy(w, after, sizeof w);
        begin += tau;
        if (next < 0) continue;
        ric_flight_strike(m->n, &m->face[next], w + m->n);
        ric_model_to_state(m, w, x, v);
        ric_force_modal(f, x, v, q, p);
        if (m->face[next].spring == 0) impact(f, next, p, sum);
    }
}

/* The orbit as a list of events, at its state. */
ric_periodic *ric_force_cycle(const ric_force *f, const ric_orbit *orbit, const double *state)
{
    const ric_model *m = f->model;
    const int N = ric_orbit_letters(orbit);
    double *flights = ric_calloc((size_t)N + 1, sizeof *flights);
    int *word = ric_calloc((size_t)N + 1, sizeof *word);
    ric_periodic *c = NULL;
    if (flights && word) {
        ric_orbit_data(orbit, NULL, NULL, flights, word);
        for (int k = 0; k < (N > 0 ? N : 1); k++) flights[k] *= m->omega_ref;
        c = ric_periodic_spelled(m, N, word, flights);
        if (c) ric_model_from_state(m, state, state + f->n, c->w);
    }
    free(flights);
    free(word);
    return c;
}

ric_status ric_force_balance_of(const ric_force *f, const ric_orbit *orbit, bool linear,
                                int harmonic, ric_force_balance *out)
{
    const int n = f->n;
    double state[2 * n], q[n], p[n];
    ric_point point;
    *out = (ric_force_balance){0};
    if (linear) {
        double period;
        ric_orbit_data(orbit, &point, state, &period, NULL);
        ric_force_modal(f, state, state + n, q, p);
        const flight s = {.force = f, .tau = period, .Omega = harmonic * point.frequency};
        free_flight(&s, q, p, out);
        return RIC_OK;
    }
    ric_orbit_data(orbit, &point, state, NULL, NULL);
    ric_periodic *c = ric_force_cycle(f, orbit, state);
    if (!c) return ric_no_memory("an orbit");
    along_cycle(f, c, harmonic * point.frequency, out);
    ric_periodic_free(c);
    return ric_trust(RIC_OK);
}
