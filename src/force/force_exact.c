/* Newton's method on the exact forced problem: state after impact 0, flight times and the phase of the force;
 * equations: closure, one gap per impact, and the flights together are harmonic periods of the force.
 *
 * A flight is closed: what is left beside the steady answer Re(A e^{i phase}) decays and turns mode by mode. */
#include "force_exact.h"

#include <complex.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define RESONANT 1e-9   /* relative: the force has the frequency of a mode that is not damped */
#define CONVERGED 1e-11 /* residual, relative to 1 + |state| */
#define CRITICAL 1e-7   /* relative: roots of a mode that are one to half of all digits */

enum { NEWTON_MOST = 40, HALVINGS_MOST = 30 };

void ric_force_exact_free(ric_force_exact *e)
{
    if (!e) return;
    free(e->omega);
    free(e->delta);
    free(e->push);
    free(e->steady);
    free(e->normal);
    free(e->face);
    free(e->gap);
    free(e);
}

static ric_status resonance(const ric_force *f, int mode)
{
    return ric_fail(
        RIC_E_NUMERIC,
        "the force has the frequency %.10g of mode %d, which is not damped: its answer grows without bound; "
        "give that mode a damping",
        f->model->frequency[mode], mode + 1);
}

static ric_status find_steady(const ric_force *f, ric_force_exact *e)
{
    for (int i = 0; i < e->n; i++) {
        const double stiff = (e->omega[i] - e->Omega) * (e->omega[i] + e->Omega), loss = 2 * e->delta[i] * e->Omega;
        if (e->push[i] == 0) continue;
        if (!(hypot(stiff, loss) > RESONANT * e->Omega * e->Omega)) return resonance(f, i);
        const double size = stiff * stiff + loss * loss;
        e->steady[i] = e->push[i] * stiff / size;
        e->steady[e->n + i] = -e->push[i] * loss / size;
    }
    return RIC_OK;
}

static void take_contacts(ric_force_exact *e, const int *word)
{
    const ric_model *m = e->model;
    for (int i = 0; i < m->n_contact * e->n; i++) e->normal[i] = m->normal[i] / e->unit;
    for (int f = 0; f < m->n_face; f++) e->gap[f] = m->contact[m->face[f].contact].clearance / ric_model_length(m);
    for (int k = 0; k < e->N; k++) e->face[k] = word[k];
}

static void take_modes(const ric_force *f, double level, ric_force_exact *e)
{
    const double t = f->model->omega_ref;
    e->unit = sqrt(ric_dot(e->n, f->model->normal, f->model->normal));
    for (int i = 0; i < e->n; i++) {
        e->omega[i] = f->model->frequency[i] / t;
        e->delta[i] = f->C[i * e->n + i] / (2 * t);
        e->push[i] = level * f->g[i] * e->unit / (t * t);
    }
}

ric_status ric_force_exact_create(const ric_force *f, int N, const int *word, double Omega, int harmonic, double level,
                                  ric_force_exact **out)
{
    const ric_model *m = f->model;
    const size_t n = (size_t)f->n;
    ric_force_exact *e = ric_calloc(1, sizeof *e);
    *out = NULL;
    if (!e) return ric_no_memory("a forced orbit");
    *e = (ric_force_exact){.n = f->n, .N = N, .restitution = f->restitution, .model = m};
    e->Omega = Omega / m->omega_ref;
    e->period = harmonic * RIC_TWO_PI / e->Omega;
    e->omega = ric_calloc(n, sizeof *e->omega);
    e->delta = ric_calloc(n, sizeof *e->delta);
    e->push = ric_calloc(n, sizeof *e->push);
    e->steady = ric_calloc(2 * n, sizeof *e->steady);
    e->normal = ric_calloc(n * (size_t)m->n_contact, sizeof *e->normal);
    e->face = ric_calloc((size_t)N, sizeof *e->face);
    e->gap = ric_calloc((size_t)m->n_face, sizeof *e->gap);
    ric_status status = RIC_OK;
    if (!e->omega || !e->delta || !e->push || !e->steady || !e->normal || !e->face || !e->gap)
        status = ric_no_memory("a forced orbit");
    if (!status) {
        take_modes(f, level, e);
        take_contacts(e, word);
        status = find_steady(f, e);
    }
    if (!status) *out = e;
    else ric_force_exact_free(e);
    return status;
}

/* ------------------------------------------------------------------ flights */

static void steady_at(const ric_force_exact *e, double phase, double *z)
{
    const double c = cos(phase), s = sin(phase);
    for (int i = 0; i < e->n; i++) {
        const double re = e->steady[i], im = e->steady[e->n + i];
        z[i] = re * c - im * s;
        z[e->n + i] = -e->Omega * (re * s + im * c);
    }
}

/* Its derivative by the phase. */
static void steady_turn(const ric_force_exact *e, double phase, double *dz)
{
    const double c = cos(phase), s = sin(phase);
    for (int i = 0; i < e->n; i++) {
        const double re = e->steady[i], im = e->steady[e->n + i];
        dz[i] = -re * s - im * c;
        dz[e->n + i] = -e->Omega * (re * c - im * s);
    }
}

/* e^{-delta tau} times cos and sin / frequency of the damped mode, hyperbolic beyond critical damping. */
static void decayed(double omega, double delta, double tau, double *c, double *s)
{
    const double square = (omega - delta) * (omega + delta), root = sqrt(fabs(square)), decay = exp(-delta * tau);
    if (root * tau <= CRITICAL) {
        *c = decay;
        *s = decay * tau;
    } else if (square > 0) {
        *c = decay * cos(root * tau);
        *s = decay * sin(root * tau) / root;
    } else {
        /* Neither the slower rate, root - delta, nor slow - fast is taken as a difference: digits would be lost. */
        const double slow = exp(-omega * omega / (root + delta) * tau), part = -expm1(-2 * root * tau);
        *c = slow * (2 - part) / 2;
        *s = slow * part / (2 * root);
    }
}

void ric_force_exact_fly(const ric_force_exact *e, double tau, double phase, const double *z, double *turn, double *z1)
{
    const int n = e->n;
    double before[2 * n], after[2 * n];
    steady_at(e, phase, before);
    steady_at(e, phase + e->Omega * tau, after);
    for (int i = 0; i < n; i++) {
        double c, s;
        decayed(e->omega[i], e->delta[i], tau, &c, &s);
        const double by[4] = {c + e->delta[i] * s, s, -e->omega[i] * e->omega[i] * s, c - e->delta[i] * s},
                     q = z[i] - before[i], p = z[n + i] - before[n + i];
        z1[i] = after[i] + by[0] * q + by[1] * p;
        z1[n + i] = after[n + i] + by[2] * q + by[3] * p;
        if (turn) memcpy(turn + 4 * i, by, sizeof by);
    }
}

void ric_force_exact_rate(const ric_force_exact *e, double phase, const double *z, double *rate)
{
    const int n = e->n;
    for (int i = 0; i < n; i++) {
        rate[i] = z[n + i];
        rate[n + i] = e->push[i] * cos(phase) - e->omega[i] * e->omega[i] * z[i] - 2 * e->delta[i] * z[n + i];
    }
}

/* ---------------------------------------------------------------- equations */

/* Columns of X [2n * size] through a flight: deviations turn, and the phase and all flights before shift the force. */
static void carry(const ric_force_exact *e, int k, double phase, double tau, const double *turn, const double *z1,
                  double *X)
{
    const int n = e->n, size = ric_force_exact_size(e);
    double before[2 * n], shift[2 * n], rate[2 * n];
    steady_turn(e, phase, before);
    steady_turn(e, phase + e->Omega * tau, shift);
    ric_force_exact_rate(e, phase + e->Omega * tau, z1, rate);
    for (int i = 0; i < n; i++) {
        const double *by = turn + 4 * i;
        double *q = X + (size_t)i * (size_t)size, *p = X + (size_t)(n + i) * (size_t)size;
        shift[i] -= by[0] * before[i] + by[1] * before[n + i];
        shift[n + i] -= by[2] * before[i] + by[3] * before[n + i];
        for (int j = 0; j < size; j++) {
            const double a = q[j], b = p[j];
            q[j] = by[0] * a + by[1] * b;
            p[j] = by[2] * a + by[3] * b;
        }
        for (int j = 0; j < k; j++) {
            q[2 * n + j] += e->Omega * shift[i];
            p[2 * n + j] += e->Omega * shift[n + i];
        }
        q[2 * n + k] += rate[i];
        p[2 * n + k] += rate[n + i];
        q[size - 1] += shift[i];
        p[size - 1] += shift[n + i];
    }
}

void ric_force_exact_strike(const ric_force_exact *e, int face, int ld, double *p)
{
    const double *c = e->normal + (size_t)e->model->face[face].contact * (size_t)e->n;
    const double factor = (1 + e->restitution) / ric_dot(e->n, c, c);
    for (int j = 0; j < ld; j++) {
        double sum = 0;
        for (int i = 0; i < e->n; i++) sum += c[i] * p[i * ld + j];
        for (int i = 0; i < e->n; i++) p[i * ld + j] -= factor * sum * c[i];
    }
}

/* Residuals R [size] and, unless J is NULL, their derivatives [size * size]; X [2n * size] is work. */
static void evaluate(const ric_force_exact *e, const double *u, double *R, double *J, double *X)
{
    const int n = e->n, size = ric_force_exact_size(e);
    double z[2 * n], z1[2 * n], turn[4 * n], phase = u[size - 1];
    memcpy(z, u, sizeof z);
    memset(X, 0, 2 * (size_t)n * (size_t)size * sizeof *X);
    for (int i = 0; i < 2 * n; i++) X[i * size + i] = 1;
    if (J) memset(J, 0, (size_t)size * (size_t)size * sizeof *J);
    R[size - 1] = -e->period;
    for (int k = 0; k < e->N; k++) {
        const int face = e->face[(k + 1) % e->N], row = 2 * n + k;
        const double *c = e->normal + (size_t)e->model->face[face].contact * (size_t)n;
        ric_force_exact_fly(e, u[row], phase, z, turn, z1);
        if (J) carry(e, k, phase, u[row], turn, z1, X);
        R[row] = ric_dot(n, c, z1) - e->model->face[face].side * e->gap[face];
        R[size - 1] += u[row];
        for (int j = 0; J && j < size; j++)
            for (int i = 0; i < n; i++) J[row * size + j] += c[i] * X[i * size + j];
        if (J) J[(size - 1) * size + row] = 1;
        ric_force_exact_strike(e, face, 1, z1 + n);
        if (J) ric_force_exact_strike(e, face, size, X + (size_t)n * (size_t)size);
        memcpy(z, z1, sizeof z);
        phase += e->Omega * u[row];
    }
    for (int i = 0; i < 2 * n; i++) {
        R[i] = z[i] - u[i];
        for (int j = 0; J && j < size; j++) J[i * size + j] = X[i * size + j] - (i == j);
    }
}

static double largest(int n, const double *x)
{
    double most = 0;
    for (int i = 0; i < n; i++) most = isfinite(x[i]) ? fmax(most, fabs(x[i])) : INFINITY;
    return most;
}

static double residual_of(const ric_force_exact *e, const double *u, const double *R)
{
    return largest(ric_force_exact_size(e), R) / (1 + largest(2 * e->n, u));
}

/* The part of a step that leaves all flights positive. */
static double possible(const ric_force_exact *e, const double *u, const double *step)
{
    double part = 1;
    for (int k = 2 * e->n; k < 2 * e->n + e->N; k++)
        while (!(u[k] - part * step[k] > 0) && part > DBL_EPSILON) part /= 2;
    return part;
}

bool ric_force_exact_solve(const ric_force_exact *e, double *u, double *residual)
{
    const size_t size = (size_t)ric_force_exact_size(e);
    double *J = ric_malloc(size * size * sizeof *J), *X = ric_malloc(size * size * sizeof *X),
           *R = ric_calloc(2 * size, sizeof *R), *best = ric_calloc(size, sizeof *best);
    int *pivot = ric_calloc(size, sizeof *pivot), worse = 0;
    *residual = INFINITY;
    for (int k = 0; J && X && R && best && pivot && k < NEWTON_MOST && worse < 3; k++) {
        evaluate(e, u, R, J, X);
        const double now = residual_of(e, u, R);
        if (!isfinite(now)) break;
        if (now < *residual) {
            *residual = now;
            memcpy(best, u, size * sizeof *u);
        } else worse += now < CONVERGED || *residual < CONVERGED;
        if (ric_lapack(LAPACKE_dgesv(LAPACK_ROW_MAJOR, (int)size, 1, J, (int)size, pivot, R, 1))) break;
        const double part = possible(e, u, R);
        for (size_t i = 0; i < size; i++) u[i] -= part * R[i];
    }
    if (best) memcpy(u, best, size * sizeof *u);
    free(J);
    free(X);
    free(R);
    free(best);
    free(pivot);
    return *residual <= CONVERGED;
}
