/* Damping and force of a structure, checked and taken to its modes. */
#include "force.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* DIAGONAL: relative to the diagonal: couplings that assembling leaves in alpha M + beta K */
#define DIAGONAL 1e-10

void ric_force_free(ric_force *f)
{
    if (!f) return;
    free(f->into);
    free(f->g);
    free(f->C);
    free(f);
}

const ric_model *ric_force_model(const ric_force *f)
{
    return f->model;
}

void ric_force_modal(const ric_force *f, const double *x, const double *v, double *q, double *p)
{
    for (int i = 0; i < f->n; i++) {
        q[i] = ric_dot(f->n, f->into + i * f->n, x);
        p[i] = ric_dot(f->n, f->into + i * f->n, v);
    }
}

static bool has_rigid(const ric_model *m)
{
    for (int i = 0; i < m->n_contact; i++)
        if (ric_model_detached(m) && m->spring[i] == 0) return true;
    return false;
}

static ric_status check_restitution(const ric_model *m, double e)
{
    if (!(e >= 0 && e <= 1))
        return ric_fail(RIC_E_INPUT,
                        "restitution %.10g is not above 0 and at most 1; 1 loses nothing", e);
    if (e == 0)
        return ric_fail(
            RIC_E_INPUT,
            "restitution 0: bodies stay together after an impact, which no orbit of the atlas "
            "does; give a number above 0, for example 0.95");
    if (e < 1 && !has_rigid(m))
        return ric_fail(
            RIC_E_INPUT,
            "restitution %.10g, but no contact of this structure is rigid; leave it out", e);
    return RIC_OK;
}

/* Ratios zeta_i: C = diag(2 zeta_i omega_i). One ratio stands for all. */
static ric_status take_ratios(ric_force *f, const ric_shaking *s)
{
    ric_status status = ric_losses_check_ratios(f->n, s->n_ratio, s->ratios);
    for (int i = 0; i < f->n && !status; i++)
        f->C[i * f->n + i] = 2 * s->ratios[s->n_ratio > 1 ? i : 0] * f->model->frequency[i];
    return status;
}

static ric_status take_matrix(ric_force *f, const ric_shaking *s)
{
    const int n = f->n;
    const double *Phi = f->model->Phi;
    ric_status status = ric_losses_check_matrix(n, s->n_matrix, s->matrix);
    for (int i = 0; i < n && !status; i++)
        for (int j = 0; j < n; j++)
            for (int a = 0; a < n; a++)
                for (int b = 0; b < n; b++)
                    f->C[i * n + j] += Phi[a * n + i] * s->matrix[a * n + b] * Phi[b * n + j];
    return status;
}

static void look_at_damping(ric_force *f)
{
    const int n = f->n;
    f->diagonal = f->lossless = true;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double *entry = &f->C[i * n + j];
            const double size = sqrt(fabs(f->C[i * n + i] * f->C[j * n + j]));
            if (i != j && fabs(*entry) <= DIAGONAL * size) *entry = 0;
            f->diagonal = f->diagonal && (i == j || *entry == 0);
            f->lossless = f->lossless && *entry == 0;
        }
}

static void to_modes(ric_force *f, const double *force)
{
    const ric_model *m = f->model;
    const int n = f->n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            f->g[i] += m->Phi[j * n + i] * force[j] / ric_model_length(m);
            for (int k = 0; k < n; k++) f->into[i * n + j] += m->Phi[k * n + i] * m->M[k * n + j];
        }
}

ric_status ric_force_check(const ric_model *m, const ric_shaking *s)
{
    const int n = m->n_dof;
    ric_status status = s->n_force ? ric_losses_check_force(n, s->n_force, s->force) : RIC_OK;
    if (!status && !(s->restitution >= 0 && s->restitution <= 1))
        status = ric_fail(RIC_E_INPUT, "restitution %.10g is not from 0 to 1", s->restitution);
    if (!status && s->n_ratio) status = ric_losses_check_ratios(n, s->n_ratio, s->ratios);
    if (!status && s->n_matrix) status = ric_losses_check_matrix(n, s->n_matrix, s->matrix);
    return status ? status : ric_joined_check_shaking(m, s);
}

ric_status ric_force_create(const ric_atlas *atlas, const ric_shaking *s, ric_force **out)
{
    const ric_model *m = ric_atlas_model(atlas);
    const size_t n = (size_t)m->n_dof;
    *out = NULL;
    ric_status status = ric_losses_check_force(m->n_dof, s->n_force, s->force);
    if (!status) status = check_restitution(m, s->restitution);
    if (!status) status = ric_joined_check_shaking(m, s);
    if (status) return status;
    ric_force *f = ric_calloc(1, sizeof *f);
    if (!f) return ric_no_memory("a force");
    *f = (ric_force){.atlas = atlas, .model = m, .n = m->n_dof, .restitution = s->restitution};
    f->into = ric_calloc(n * n, sizeof *f->into);
    f->C = ric_calloc(n * n, sizeof *f->C);
    f->g = ric_calloc(n, sizeof *f->g);
    if (!f->into || !f->C || !f->g) status = ric_no_memory("a force");
    if (!status) status = s->matrix ? take_matrix(f, s) : s->ratios ? take_ratios(f, s) : RIC_OK;
    if (!status) {
        to_modes(f, s->force);
        look_at_damping(f);
        if (f->lossless && f->restitution == 1)
            status =
                ric_fail(RIC_E_INPUT,
                         "nothing is lost: the damping is 0 and the restitution 1; a force of any "
                         "size drives such a motion. Give one of them");
    }
    if (!status) *out = f;
    else ric_force_free(f);
    return status;
}
