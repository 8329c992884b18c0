/* The shaken structure in the units of the solver. */
#include "force_medium.h"

#include <math.h>
#include <stdlib.h>

#include "base/room.h"

void ric_force_medium_free(ric_force_medium *m)
{
    if (!m) return;
    for (ric_force_frame *f = m->frames, *next; f; f = next) {
        next = f->next;
        ric_force_frame_free(f);
    }
    free(m->omega);
    free(m);
}

static double power(double x, int exponent)
{
    double out = 1;
    for (int i = 0; i < exponent; i++) out *= x;
    return out;
}

/* Force of a contact on a scaled gap coordinate, over d, at s = 1 beyond its gap; only power laws
 * have an exponent. */
static double stiffness_of(const ric_model *m, int contact)
{
    const ric_contact *c = &m->contact[contact];
    const double d = ric_model_length(m);
    if (m->spring[contact] == 0) return 0;
    if (c->exponent == 0) return c->stiffness;
    if (c->length > 0) return c->reference * power(d / c->length, c->exponent - 1);
    return c->stiffness * power(d, c->exponent - 1);
}

static void take_numbers(const ric_force *f, ric_force_medium *m)
{
    const ric_model *model = f->model;
    const int n = f->n;
    const double t = m->time;
    m->unit = sqrt(ric_dot(n, model->normal, model->normal));
    for (int i = 0; i < n; i++) {
        m->omega[i] = model->frequency[i] / t;
        m->push[i] = f->g[i] * m->unit / (t * t);
    }
    for (int i = 0; i < n * n; i++) m->C[i] = f->C[i] / t;
    for (int i = 0; i < model->n_contact * n; i++) m->normal[i] = model->normal[i] / m->unit;
    for (int i = 0; i < model->n_face; i++)
        m->gap[i] = model->contact[model->face[i].contact].clearance / ric_model_length(model);
    for (int i = 0; i < model->n_contact; i++)
        m->spring[i] = stiffness_of(model, i) * m->unit * m->unit / (t * t);
}

ric_status ric_force_medium_create(const ric_force *f, ric_force_medium **out)
{
    const ric_model *model = f->model;
    const size_t n = (size_t)f->n, contacts = (size_t)model->n_contact,
                 faces = (size_t)model->n_face;
    ric_force_medium *m = ric_calloc(1, sizeof *m);
    *out = NULL;
    if (!m || !(m->omega = ric_calloc(2 * n + n * n + contacts * (n + 1) + faces + 8 * n,
                                      sizeof *m->omega))) {
        free(m);
        return ric_no_memory("a forced structure");
    }
    m->force = f;
    m->model = model;
    m->n = f->n;
    m->smooth = !ric_model_detached(model);
    m->time = model->omega_ref;
    m->push = m->omega + n;
    m->C = m->push + n;
    m->normal = m->C + n * n;
    m->gap = m->normal + contacts * n;
    m->spring = m->gap + faces;
    m->work = m->spring + contacts;
    take_numbers(f, m);
    *out = m;
    return RIC_OK;
}

const double *ric_force_medium_normal(const ric_force_medium *m, int face)
{
    return m->normal + (size_t)m->model->face[face].contact * (size_t)m->n;
}

double ric_force_medium_towards(const ric_force_medium *m, int face, const double *q)
{
    return m->model->face[face].side * ric_dot(m->n, ric_force_medium_normal(m, face), q);
}

bool ric_force_medium_rigid(const ric_force_medium *m, int face)
{
    return m->spring[m->model->face[face].contact] == 0;
}

void ric_force_medium_strike(const ric_force_medium *m, double restitution, int face, int ld,
                             double *p)
{
    const int n = m->n;
    const double *c = ric_force_medium_normal(m, face),
                 factor = (1 + restitution) / ric_dot(n, c, c);
    if (!ric_force_medium_rigid(m, face)) return;
    for (int j = 0; j < ld; j++) {
        double sum = 0;
        for (int i = 0; i < n; i++) sum += c[i] * p[i * ld + j];
        for (int i = 0; i < n; i++) p[i * ld + j] -= factor * sum * c[i];
    }
}

void ric_force_medium_rate(const ric_force_medium *m, uint64_t closed, const ric_force_drive *d,
                           double theta, const double *z, double *rate)
{
    const int n = m->n;
    const double *p = z + n, push = d->level * cos(theta);
    for (int i = 0; i < n; i++) {
        rate[i] = p[i];
        rate[n + i] = push * m->push[i] - m->omega[i] * m->omega[i] * z[i] -
                      ric_dot(n, m->C + i * n, p);
    }
    for (int f = 0; f < m->model->n_face; f++) {
        if (!ric_face_in(closed, f)) continue;
        const double *c = ric_force_medium_normal(m, f),
                     beyond = ric_force_medium_towards(m, f, z) - m->gap[f],
                     pull = m->spring[m->model->face[f].contact] * m->model->face[f].side * beyond;
        for (int i = 0; i < n; i++) rate[n + i] -= pull * c[i];
    }
    for (int k = 0; m->smooth && k < m->model->n_contact; k++) {
        const double *c = m->normal + (size_t)k * (size_t)n,
                     pull = m->spring[k] * power(ric_dot(n, c, z), m->model->contact[k].exponent);
        for (int i = 0; i < n; i++) rate[n + i] -= pull * c[i];
    }
}
