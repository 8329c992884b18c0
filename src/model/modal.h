/* Flight and impact on energy coordinates w = (a, p): O(n) each (docs/theory.md section 1). */
#ifndef RIC_MODEL_MODAL_H
#define RIC_MODEL_MODAL_H

#include <math.h>

#include "model.h"

/* trig [3n]: cos(omega tau), kappa sin(omega tau) / omega, omega sin(omega tau) / kappa. */
static inline void ric_flight_trig(const ric_model *m, int n, double tau, double *restrict trig)
{
    for (int i = 0; i < n; i++) {
        double s, c;
        if (m->omega[i] > 0) {
            double phase = m->omega[i] * tau;
            sincos(phase, &s, &c);
            if (m->fast) { /* turn by what rounding took from the phase */
                double low = fma(m->omega[i], tau, -phase) + m->omega_low[i] * tau, t = s;
                s += low * c;
                c -= low * t;
            }
            trig[i] = c;
            trig[n + i] = trig[2 * n + i] = s;
        } else {
            trig[i] = 1;
            trig[n + i] = tau;
            trig[2 * n + i] = 0;
        }
    }
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
