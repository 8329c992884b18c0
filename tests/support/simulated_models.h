/* Models, motions in closed form and a simulator for the tests of the simulator and of the
 * verification. The closed forms are computed from ric_model_modes, which the simulator does not
 * use. */
#ifndef SIMULATED_MODELS_H
#define SIMULATED_MODELS_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "random_models.h"
#include "ricochet.h"

enum { MAX_N = 50, MAX_CONTACT = 4 };

static const double PI = 3.14159265358979323846;

static inline void check_close(double a, double b, double tolerance, const char *what)
{
    double error = fabs(a - b) / fmax(1e-300, fmax(fabs(a), fabs(b)));
    if (!(error <= tolerance))
        fail_msg("%s: %.17g against %.17g, relative difference %.3g > %.3g", what, a, b, error,
                 tolerance);
}

static inline ric_model *make(int n, const double *M, const double *K, int n_contact,
                              const ric_contact *contacts, double restitution)
{
    ric_model *model = NULL;
    if (ric_model_create(n, M, K, n_contact, contacts, restitution, &model))
        fail_msg("%s", ric_detail());
    return model;
}

static inline ric_model *make_one(double m, double k, ric_sides sides, double restitution)
{
    double normal = 1;
    ric_contact contact = {.normal = &normal, .clearance = 1, .sides = sides};
    return make(1, &m, &k, 1, &contact, restitution);
}

static inline ric_model *make_two(void) /* the article's model */
{
    double M[] = {2, 0, 0, 1}, K[] = {9, -1, -1, 1}, normal[] = {-1, 1};
    ric_contact contact = {.normal = normal, .clearance = 1};
    return make(2, M, K, 1, &contact, 1);
}

/* Masses and springs of order n, their frequencies of order 1. */
static inline ric_model *make_random(uint64_t seed, int n, int n_contact, double restitution)
{
    double M[MAX_N * MAX_N], K[MAX_N * MAX_N], normal[MAX_CONTACT * MAX_N];
    ric_contact contacts[MAX_CONTACT] = {{0}};
    seed_now = seed;
    random_definite(n, n, 0.5 * n, M);
    random_definite(n, n, 0.1 * n, K);
    for (int f = 0; f < n_contact; f++) {
        for (int i = 0; i < n; i++) normal[f * n + i] = uniform(-1, 1);
        contacts[f] = (ric_contact){.normal = normal + f * n,
                                    .clearance = uniform(0.5, 2),
                                    .sides = f % 3 == 2 ? RIC_SIDES_UPPER : RIC_SIDES_BOTH};
    }
    return make(n, M, K, n_contact, contacts, restitution);
}

static inline ric_simulator *simulator(const ric_model *model)
{
    ric_simulator *sim = NULL;
    if (ric_simulator_create(model, &sim)) fail_msg("%s", ric_detail());
    return sim;
}

static inline void start(ric_simulator *sim, const double *x, const double *v)
{
    if (ric_simulator_start(sim, x, v)) fail_msg("%s", ric_detail());
}

static inline bool advance(ric_simulator *sim, double t, ric_impact *impact)
{
    bool hit;
    if (ric_simulator_advance(sim, t, &hit, impact)) fail_msg("%s", ric_detail());
    return hit;
}

/* A state well inside every stop. */
static inline void random_state(const ric_model *model, double speed, double *x, double *v)
{
    int n = ric_model_n_dof(model);
    for (int i = 0; i < n; i++) {
        x[i] = uniform(-0.2, 0.2) / n;
        v[i] = uniform(-speed, speed);
    }
}

/* Modal closed forms from the model's own modes. */
typedef struct {
    int n, n_contact;
    double omega[MAX_N], phi[MAX_N * MAX_N], c[MAX_CONTACT * MAX_N], d[MAX_CONTACT];
    ric_sides sides[MAX_CONTACT];
    const double *M;
} modal;

static inline modal make_modal(const ric_model *model)
{
    modal m = {.n = ric_model_n_dof(model),
               .n_contact = ric_model_n_contact(model),
               .M = ric_model_mass(model)};
    ric_model_frequencies(model, m.omega);
    ric_model_modes(model, m.phi);
    for (int f = 0; f < m.n_contact; f++) {
        ric_contact contact;
        assert_int_equal(ric_model_contact(model, f, &contact), RIC_OK);
        m.d[f] = contact.clearance / ric_model_length(model);
        m.sides[f] = contact.sides;
        for (int i = 0; i < m.n; i++) {
            double c = 0;
            for (int j = 0; j < m.n; j++) c += contact.normal[j] * m.phi[j * m.n + i];
            m.c[f * m.n + i] = c;
        }
    }
    return m;
}

static inline void to_modal(const modal *m, const double *x, double *q)
{
    for (int i = 0; i < m->n; i++) {
        q[i] = 0;
        for (int j = 0; j < m->n; j++)
            for (int k = 0; k < m->n; k++) q[i] += m->phi[j * m->n + i] * m->M[j * m->n + k] * x[k];
    }
}

static inline void to_space(const modal *m, const double *q, double *x)
{
    for (int j = 0; j < m->n; j++) {
        x[j] = 0;
        for (int i = 0; i < m->n; i++) x[j] += m->phi[j * m->n + i] * q[i];
    }
}

static inline void modal_flight(const modal *m, double t, const double *q, const double *p,
                                double *qt, double *pt)
{
    for (int i = 0; i < m->n; i++) {
        double w = m->omega[i], s = sin(w * t), c = cos(w * t), qi = q[i], pi = p[i];
        qt[i] = w > 0 ? qi * c + pi / w * s : qi + pi * t;
        pt[i] = w > 0 ? pi * c - w * qi * s : pi;
    }
}

static inline double modal_gap(const modal *m, int contact, double t, const double *q,
                               const double *p)
{
    double qt[MAX_N], pt[MAX_N], s = 0;
    modal_flight(m, t, q, p, qt, pt);
    for (int i = 0; i < m->n; i++) s += m->c[contact * m->n + i] * qt[i];
    return s;
}

static inline double distance(int n, const double *x, const double *y)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += (x[i] - y[i]) * (x[i] - y[i]);
    return sqrt(sum);
}

static inline double length(int n, const double *x)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * x[i];
    return sqrt(sum);
}

/* S2[01]: q_i = -J c_i sin(omega_i (t - h/2)) / (omega_i cos(omega_i h/2)), J sum c_i^2 tan(omega_i
 * h/2) / omega_i = d, h = pi / omega; *through: beyond a stop on the way. False: the impacts would
 * pull. */
static inline bool s2_motion(const modal *m, double h, double *x, double *v, bool *through)
{
    double q[MAX_N], p[MAX_N], sum = 0;
    *through = false;
    for (int i = 0; i < m->n; i++)
        sum += m->c[i] * m->c[i] * tan(m->omega[i] * h / 2) / m->omega[i];
    if (sum <= 0) return false;
    for (int i = 0; i < m->n; i++) {
        q[i] = m->c[i] * tan(m->omega[i] * h / 2) / (m->omega[i] * sum);
        p[i] = -m->c[i] / sum;
    }
    for (int i = 1; i < 4000; i++) *through |= fabs(modal_gap(m, 0, h * i / 4000, q, p)) > 1;
    to_space(m, q, x);
    to_space(m, p, v);
    return true;
}

/* Only where it is a motion. */
static inline bool s2_orbit(const modal *m, double h, double *x, double *v)
{
    bool through;
    return s2_motion(m, h, x, v, &through) && !through;
}

#endif
