/* Flight and impact on energy coordinates w = (a, p): O(n) each (docs/theory.md section 1). */
#ifndef RIC_MODEL_MODAL_H
#define RIC_MODEL_MODAL_H

#include <math.h>

#include "base/room.h"
#include "model.h"

/* What modes that do not turn have instead, and those that turn so often that rounding of their
 * phase counts: mode i, with cosine and sine of its rounded phase. */
static inline void ric_flight_mend(const ric_model *m, int i, double tau, double *c, double *s,
                                   double *other)
{
    const double phase = m->omega[i] * tau;
    if (m->omega[i] > 0 && !m->fast) return;
    if (m->omega[i] > 0) { /* turn by what rounding took from the phase */
        const double low = fma(m->omega[i], tau, -phase) + m->omega_low[i] * tau, t = *s;
        *s += low * *c;
        *c -= low * t;
        *other = *s;
    } else {
        *c = 1;
        *s = tau;
        *other = 0;
    }
}

/* cos(omega tau), kappa sin(omega tau) / omega and omega sin(omega tau) / kappa of modes i and j,
 * one in each lane. */
static inline __attribute__((always_inline)) void ric_flight_trig_lanes(const ric_model *m, int i,
                                                                        int j, double tau,
                                                                        ric_lane trig[3])
{
    const ric_lane omega = {m->omega[i], m->omega[j]};
    ric_sine_lanes(omega * tau, &trig[1], &trig[0]);
    trig[2] = trig[1];
    if (!m->fast && omega[0] > 0 && omega[1] > 0) return;
    double each[3][2];
    memcpy(each, trig, sizeof each);
    for (int l = 0; l < 2; l++)
        ric_flight_mend(m, l ? j : i, tau, &each[0][l], &each[1][l], &each[2][l]);
    memcpy(trig, each, sizeof each);
}

/* The same of all modes, trig [3n]. */
static inline __attribute__((always_inline)) void ric_flight_trig(const ric_model *m, int n,
                                                                  double tau, double *restrict trig)
{
    ric_lane two[3];
    for (int i = 0; i + 1 < n; i += 2) {
        ric_flight_trig_lanes(m, i, i + 1, tau, two);
        for (int k = 0; k < 3; k++) ric_lane_store(trig + k * n + i, two[k]);
    }
    if (n % 2 == 0) return;
    ric_flight_trig_lanes(m, n - 1, n - 1, tau, two);
    for (int k = 0; k < 3; k++) trig[k * n + n - 1] = two[k][0];
}

/* w_after = rotation * w. May work in place. */
static inline void ric_flight(int n, const double *restrict trig, const double *w, double *after)
{
    for (int i = 0; i < n; i++) {
        double a = w[i], p = w[n + i];
        after[i] = trig[i] * a + trig[n + i] * p;
        after[n + i] = trig[i] * p - trig[2 * n + i] * a;
    }
}

/* p <- p - 2 (c.p)/(c.c) c. */
static inline void ric_impact_reflect(int n, const ric_face *face, double *restrict p)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += face->c[i] * p[i];
    sum *= 2 / face->cc;
    for (int i = 0; i < n; i++) p[i] -= sum * face->c[i];
}

/* dw/dt in flight. */
static inline void ric_flow(const ric_model *m, int n, const double *restrict w, double *restrict f)
{
    for (int i = 0; i < n; i++) {
        f[i] = m->kappa[i] * w[n + i];
        f[n + i] = -m->stiff[i] * w[i];
    }
}

static inline double ric_gap(int n, const ric_face *face, const double *a)
{
    double s = 0;
    for (int i = 0; i < n; i++) s += face->g[i] * a[i];
    return s;
}

static inline double ric_dot(int n, const double *x, const double *y)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * y[i];
    return sum;
}

#endif
