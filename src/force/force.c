/* Damping and force of a structure, checked and taken to its modes. */
#include "force.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define SYMMETRIC 1e-8 /* of the largest entry: a damping matrix that is printed with nine digits */
#define DIAGONAL 1e-10 /* relative to the diagonal: couplings that assembling leaves in alpha M + beta K */
#define NEGATIVE 1e-9  /* relative to the largest: an eigenvalue that rounding makes of zero */

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

static ric_status check_force(const ric_model *m, const ric_shaking *s)
{
    double largest = 0;
    if (s->n_force != m->n_dof)
        return ric_fail(RIC_E_INPUT,
                        "the force has %d numbers, but the structure has %d displacements; give one number "
                        "for each",
                        s->n_force, m->n_dof);
    for (int i = 0; i < s->n_force; i++) {
        if (!isfinite(s->force[i])) return ric_fail(RIC_E_INPUT, "number %d of the force is not finite", i + 1);
        largest = fmax(largest, fabs(s->force[i]));
    }
    if (!(largest > 0)) return ric_fail(RIC_E_INPUT, "the force is zero; name the displacements that it acts on, 1,0");
    return RIC_OK;
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
        return ric_fail(RIC_E_INPUT, "restitution %.10g is not above 0 and at most 1; 1 loses nothing", e);
    if (e == 0)
        return ric_fail(RIC_E_INPUT, "restitution 0: bodies stay together after an impact, which no orbit of the atlas "
                                     "does; give a number above 0, for example 0.95");
    if (e < 1 && !has_rigid(m))
        return ric_fail(RIC_E_INPUT, "restitution %.10g, but no contact of this structure is rigid; leave it out", e);
    return RIC_OK;
}

/* Ratios zeta_i: C = diag(2 zeta_i omega_i). One ratio stands for all. */
static ric_status take_ratios(ric_force *f, const ric_shaking *s)
{
    if (s->n_ratio != 1 && s->n_ratio != f->n)
        return ric_fail(RIC_E_INPUT,
                        "%d damping ratios, but the structure has %d modes; give one for all, or one for "
                        "each",
                        s->n_ratio, f->n);
    for (int i = 0; i < f->n; i++) {
        const double zeta = s->ratios[s->n_ratio > 1 ? i : 0];
        if (!(zeta >= 0 && isfinite(zeta)))
            return ric_fail(RIC_E_INPUT, "damping ratio %.10g of mode %d is negative; it is 0 or more", zeta, i + 1);
        f->C[i * f->n + i] = 2 * zeta * f->model->frequency[i];
    }
    return RIC_OK;
}

/* A damping matrix takes energy, whatever the motion, if it is symmetric without a negative eigenvalue. */
static ric_status check_matrix(int n, const double *C)
{
    double largest = 0, values[n], *A = ric_malloc((size_t)n * (size_t)n * sizeof *A);
    if (!A) return ric_no_memory("a damping matrix");
    memcpy(A, C, (size_t)n * (size_t)n * sizeof *A);
    for (int i = 0; i < n * n; i++) largest = fmax(largest, isfinite(C[i]) ? fabs(C[i]) : INFINITY);
    ric_status status = RIC_OK;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++)
            if (!(fabs(C[i * n + j] - C[j * n + i]) <= SYMMETRIC * largest) && !status)
                status = ric_fail(RIC_E_INPUT,
                                  "the damping matrix is not symmetric: row %d, column %d is %.17g but "
                                  "row %d, column %d is %.17g; make them equal",
                                  i + 1, j + 1, C[i * n + j], j + 1, i + 1, C[j * n + i]);
    if (!status && !isfinite(largest)) status = ric_fail(RIC_E_INPUT, "the damping matrix is not finite");
    if (!status && ric_lapack(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'U', n, A, n, values)))
        status = ric_fail(RIC_E_NUMERIC, "the eigenvalues of the damping matrix cannot be computed");
    if (!status && values[0] < -NEGATIVE * largest)
        status = ric_fail(RIC_E_INPUT,
                          "the damping is negative: the matrix has the eigenvalue %.10g; a damping matrix "
                          "has none below 0",
                          values[0]);
    free(A);
    return status;
}

static ric_status take_matrix(ric_force *f, const ric_shaking *s)
{
    const int n = f->n;
    const double *Phi = f->model->Phi;
    if (s->n_matrix != n)
        return ric_fail(RIC_E_INPUT, "the damping matrix has %d rows, but the structure has %d displacements",
                        s->n_matrix, n);
    ric_status status = check_matrix(n, s->matrix);
    for (int i = 0; i < n && !status; i++)
        for (int j = 0; j < n; j++)
            for (int a = 0; a < n; a++)
                for (int b = 0; b < n; b++) f->C[i * n + j] += Phi[a * n + i] * s->matrix[a * n + b] * Phi[b * n + j];
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
    if (s->n_force) {
        ric_status status = check_force(m, s);
        if (status) return status;
    }
    if (!(s->restitution >= 0 && s->restitution <= 1))
        return ric_fail(RIC_E_INPUT, "restitution %.10g is not from 0 to 1", s->restitution);
    if (s->n_ratio > 1 && s->n_ratio != n)
        return ric_fail(RIC_E_INPUT,
                        "%d damping ratios, but the structure has %d modes; give one for all, or one for each",
                        s->n_ratio, n);
    for (int i = 0; i < s->n_ratio; i++)
        if (!(s->ratios[i] >= 0 && isfinite(s->ratios[i])))
            return ric_fail(RIC_E_INPUT, "damping ratio %.10g of mode %d is negative; it is 0 or more", s->ratios[i],
                            i + 1);
    if (s->n_matrix && s->n_matrix != n)
        return ric_fail(RIC_E_INPUT, "the damping matrix has %d rows, but the structure has %d displacements",
                        s->n_matrix, n);
    return s->n_matrix ? check_matrix(n, s->matrix) : RIC_OK;
}

ric_status ric_force_create(const ric_atlas *atlas, const ric_shaking *s, ric_force **out)
{
    const ric_model *m = ric_atlas_model(atlas);
    const size_t n = (size_t)m->n_dof;
    *out = NULL;
    ric_status status = check_force(m, s);
    if (!status) status = check_restitution(m, s->restitution);
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
            status = ric_fail(RIC_E_INPUT, "nothing is lost: the damping is 0 and the restitution 1; a force of any "
                                           "size drives such a motion. Give one of them");
    }
    if (!status) *out = f;
    else ric_force_free(f);
    return status;
}
