#include "flight.h"
#include "base/room.h"

#include <stdlib.h>
#include <string.h>

#include "power_flow.h"
#include "model/room.h"

uint64_t ric_flight_mirror(const ric_model *m, uint64_t closed)
{
    uint64_t image = 0;
    for (int f = 0; closed >> f && f < m->n_face; f++)
        if (closed >> f & 1 && m->face[f].mirror >= 0) image |= (uint64_t)1 << m->face[f].mirror;
    return image;
}

/* --------------------------------------------------------------------- maps */

/* Law power: the workspace is kept on the stack unless the structure is large. */
enum { SMALL = 1 << 15 };

/* Where the flow cannot be followed the state is infinite, and no orbit is found there. `matrix` and `lost` may be
 * NULL. */
void ric_flight_smooth(const ric_model *m, double tau, const double *w, double *matrix, double *lost, double *after)
{
    size_t states = 2 * (size_t)m->n, size = ric_power_flow_work(m, matrix ? 2 * m->n : 0),
           small = size <= SMALL ? size : 1;
    _Alignas(16) double stack[small];
    double *work = size <= SMALL ? stack : ric_malloc(size * sizeof *work), unwanted;
    if (after != w) memcpy(after, w, states * sizeof *w);
    if (!work || !(matrix ? ric_power_flow_map_surely(m, tau, after, matrix, lost ? lost : &unwanted, work)
                          : ric_power_flow_fly(m, tau, after, 0, NULL, work))) {
        for (size_t i = 0; i < states; i++) after[i] = HUGE_VAL;
        for (size_t i = 0; matrix && i < states * states; i++) matrix[i] = 0;
        if (lost) *lost = 0;
    }
    if (work != stack) free(work);
}

double ric_flight_pace(const ric_model *m, const double *w)
{
    size_t size = ric_power_flow_work(m, 0), small = size <= SMALL ? size : 1;
    _Alignas(16) double stack[small];
    double *work = size <= SMALL ? stack : ric_malloc(size * sizeof *work),
           pace = work ? ric_power_flow_pace(m, w, work) : 0;
    if (work != stack) free(work);
    return pace;
}

/* The phase of a set of closed springs. Without one, for want of memory or because both faces of a contact would be
 * closed, the states are no numbers, and the chain does not converge. */
static const ric_regime *phase_of(const ric_model *m, uint64_t closed, size_t size, double *lost)
{
    const ric_regime *phase;
    ric_regime_get(m, closed, &phase);
    for (size_t i = 0; !phase && i < size; i++) lost[i] = NAN;
    return phase;
}

static const ric_face *closing(const ric_model *m, uint64_t closed, int event)
{
    return event >= 0 && closed >> event & 1 ? &m->face[event] : NULL;
}

void ric_flight_go(const ric_model *m, uint64_t closed, int event, double tau, const double *w, double *after)
{
    int n = m->n;
    double trig[3 * n];
    if (m->smooth) {
        ric_flight_smooth(m, tau, w, NULL, NULL, after);
        return;
    }
    if (closed) {
        const ric_regime *phase = phase_of(m, closed, 2 * (size_t)n, after);
        if (phase) ric_regime_fly(phase, closing(m, closed, event), tau, w, after, NULL);
        return;
    }
    ric_flight_trig(m, n, tau, trig);
    ric_flight(n, trig, w, after);
}

void ric_flight_map(const ric_model *m, uint64_t closed, int event, double tau, const double *w, double *matrix,
                    double *after, double *rate)
{
    int n = m->n;
    double trig[3 * n];
    if (m->smooth) {
        ric_flight_smooth(m, tau, w, matrix, NULL, after);
        ric_flight_rate(m, 0, after, rate);
        return;
    }
    if (closed) {
        const ric_regime *phase = phase_of(m, closed, 2 * (size_t)n, after);
        if (!phase) return;
        ric_regime_fly(phase, closing(m, closed, event), tau, w, after, rate + n);
        ric_regime_matrix(phase, tau, matrix);
        for (int i = 0; i < n; i++) rate[i] = m->kappa[i] * after[n + i];
        return;
    }
    ric_flight_trig(m, n, tau, trig);
    ric_flight(n, trig, w, after);
    ric_flow(m, n, after, rate);
    memset(matrix, 0, 4 * (size_t)n * n * sizeof *matrix);
    for (int i = 0; i < n; i++) {
        matrix[i * 2 * n + i] = matrix[(n + i) * 2 * n + n + i] = trig[i];
        matrix[i * 2 * n + n + i] = trig[n + i];
        matrix[(n + i) * 2 * n + i] = -trig[2 * n + i];
    }
}

double ric_flight_chord(const ric_model *m, uint64_t closed, int event, int face, double tau, const double *w,
                        double *by_w, double *by_tau)
{
    const ric_regime *phase;
    double lost = NAN;
    if (ric_regime_get(m, closed, &phase)) return lost;
    return ric_regime_chord(phase, closing(m, closed, event), m->face[face].contact, tau, w, by_w, by_tau);
}

void ric_flight_onto(const ric_model *m, uint64_t closed, int event, int ld, double *X)
{
    const ric_face *from = closing(m, closed, event);
    if (from) ric_regime_onto(m->n, from, ld, X);
}

double ric_flight_fastest(const ric_model *m, uint64_t closed)
{
    const ric_regime *phase;
    double fastest = 0;
    if (!closed || ric_regime_get(m, closed, &phase)) return 0;
    for (int i = 0; i < m->n; i++) fastest = fmax(fastest, phase->omega[i]);
    return fastest;
}

/* ------------------------------------------------------------------- forces */

static double power(double s, int exponent)
{
    double out = s, square = s * s;
    for (int i = 1; i < exponent; i += 2) out *= square;
    return out;
}

void ric_flight_rate(const ric_model *m, uint64_t closed, const double *w, double *rate)
{
    int n = m->n;
    ric_flow(m, n, w, rate);
    for (int f = 0; closed >> f && f < m->n_face; f++) {
        if (!(closed >> f & 1)) continue;
        const ric_face *face = &m->face[f];
        double force = face->spring * (ric_gap(n, face, w) - face->gap);
        for (int i = 0; i < n; i++) rate[n + i] -= force * face->c[i];
    }
    for (int f = 0; m->smooth && f < m->n_contact; f++) {
        double force = m->spring[f] * power(ric_dot(n, m->g + f * n, w), m->contact[f].exponent);
        for (int i = 0; i < n; i++) rate[n + i] -= force * m->c[f * n + i];
    }
}

double ric_flight_energy(const ric_model *m, uint64_t closed, const double *w)
{
    int n = m->n;
    double sum = 0, springs = 0;
    for (int i = 0; i < n; i++) {
        if (m->stiff[i] != 0) sum += w[i] * w[i];
        sum += w[n + i] * w[n + i];
    }
    for (int f = 0; closed >> f && f < m->n_face; f++) {
        if (!(closed >> f & 1)) continue;
        double over = ric_gap(n, &m->face[f], w) - m->face[f].gap;
        springs += m->face[f].spring * over * over;
    }
    for (int f = 0; m->smooth && f < m->n_contact; f++) {
        double s = ric_dot(n, m->g + f * n, w);
        springs += m->spring[f] * s * power(s, m->contact[f].exponent) * 2 / (m->contact[f].exponent + 1);
    }
    return (sum + springs) / 2;
}

/* (s1^(m+1) - s0^(m+1)) / (s1 - s0), without the cancellation. */
static double power_secant(double s0, double s1, int exponent)
{
    double sum = 0, lead = 1;
    for (int j = 0; j <= exponent; j++) {
        sum = sum * s0 + lead;
        lead *= s1;
    }
    return sum;
}

void ric_flight_secant(const ric_model *m, uint64_t closed, const double *w0, const double *w1, double *h)
{
    int n = m->n;
    for (int i = 0; i < n; i++) {
        h[i] = m->stiff[i] == 0 ? 0 : w1[i] + w0[i];
        h[n + i] = w1[n + i] + w0[n + i];
    }
    for (int f = 0; closed >> f && f < m->n_face; f++) {
        if (!(closed >> f & 1)) continue;
        const ric_face *face = &m->face[f];
        double force = face->spring * (ric_gap(n, face, w0) + ric_gap(n, face, w1) - 2 * face->gap);
        for (int i = 0; i < n; i++) h[i] += force * face->g[i];
    }
    for (int f = 0; m->smooth && f < m->n_contact; f++) {
        const double *g = m->g + f * n;
        int exponent = m->contact[f].exponent;
        double force = 2 * m->spring[f] / (exponent + 1) * power_secant(ric_dot(n, g, w0), ric_dot(n, g, w1), exponent);
        for (int i = 0; i < n; i++) h[i] += force * g[i];
    }
}
