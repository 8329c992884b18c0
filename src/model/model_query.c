/* What a structure tells of itself: its numbers, energies at which contacts matter, states. */
#include "model.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "modal.h"
#include "regime.h"
#include "base/room.h"

/* OPPOSITE: directions in which two faces push are opposite up to this part; and of the square of a
 * normal: what belongs to loose masses, if the face pushes them */
#define OPPOSITE 1e-9
/* Cosine between two normals (metric M^-1) below which reflections are taken to commute. */
#define ORTHOGONAL 1e-12
/* LOCKED: eigenvalues of n modes below this many last digits of the largest, for each, are zero */
#define LOCKED 16.0

static bool same_contact(const ric_contact *a, const ric_contact *b)
{
    return a->clearance == b->clearance && a->sides == b->sides && a->law == b->law &&
           a->stiffness == b->stiffness && a->exponent == b->exponent && a->length == b->length &&
           a->reference == b->reference;
}

/* The structure, whatever is lost at its stops. */
bool ric_model_same(const ric_model *a, const ric_model *b)
{
    if (a->n_dof != b->n_dof || a->n_contact != b->n_contact) return false;
    const size_t n = (size_t)a->n_dof, size = n * n * sizeof *a->M;
    bool same = !memcmp(a->M, b->M, size) && !memcmp(a->K, b->K, size) &&
                !memcmp(a->b, b->b, (size_t)a->n_contact * n * sizeof *a->b);
    for (int f = 0; f < a->n_contact && same; f++)
        same = same_contact(&a->contact[f], &b->contact[f]);
    return same;
}

int ric_model_n_dof(const ric_model *m)
{
    return m->n_dof;
}
int ric_model_n_mode(const ric_model *m)
{
    return m->n;
}
int ric_model_n_contact(const ric_model *m)
{
    return m->n_contact;
}
int ric_model_n_face(const ric_model *m)
{
    return m->n_face;
}
int ric_model_n_part(const ric_model *m)
{
    return m->n_part;
}
bool ric_model_symmetric(const ric_model *m)
{
    return m->symmetric;
}
const ric_units *ric_model_units(const ric_model *m)
{
    return &m->units;
}
void ric_model_name_units(ric_model *m, const ric_units *units)
{
    m->units = *units;
}
double ric_model_length(const ric_model *m)
{
    const ric_contact *first = &m->contact[0];
    return first->law != RIC_LAW_POWER ? first->clearance : first->length > 0 ? first->length : 1;
}
double ric_model_restitution(const ric_model *m)
{
    return m->restitution;
}
const double *ric_model_mass(const ric_model *m)
{
    return m->M;
}
const double *ric_model_stiffness(const ric_model *m)
{
    return m->K;
}

ric_status ric_model_contact(const ric_model *m, int contact, ric_contact *out)
{
    if (contact < 0 || contact >= m->n_contact)
        return ric_fail(RIC_E_RANGE, "contact %d does not exist; there are %d, from 0", contact,
                        m->n_contact);
    *out = m->contact[contact];
    return RIC_OK;
}

ric_status ric_model_face(const ric_model *m, int face, int *contact, int *side, int *mirror)
{
    if (face < 0 || face >= m->n_face)
        return ric_fail(RIC_E_RANGE, "face %d does not exist; there are %d, from 0", face,
                        m->n_face);
    if (contact) *contact = m->face[face].contact;
    if (side) *side = m->face[face].side;
    if (mirror) *mirror = m->face[face].mirror;
    return RIC_OK;
}

ric_status ric_model_frequencies(const ric_model *m, double *out)
{
    memcpy(out, m->frequency, (size_t)m->n_dof * sizeof *out);
    return RIC_OK;
}

ric_status ric_model_modes(const ric_model *m, double *out)
{
    memcpy(out, m->Phi, (size_t)m->n_dof * (size_t)m->n_dof * sizeof *out);
    return RIC_OK;
}

ric_status ric_model_seen(const ric_model *m, bool *out)
{
    memcpy(out, m->seen, (size_t)m->n_dof * sizeof *out);
    return RIC_OK;
}

ric_status ric_model_modal_normals(const ric_model *m, double *out)
{
    memcpy(out, m->normal, (size_t)m->n_contact * (size_t)m->n_dof * sizeof *out);
    return RIC_OK;
}

/* Linear mode i with amplitude A reaches c_fi A = d_f; E / d^2 = omega_i^2 (d_f/d)^2 / (2 c_fi^2).
 * Law power is met at once. */
ric_status ric_model_grazing_energies(const ric_model *m, double *energy, int *contact)
{
    for (int i = 0; i < m->n_dof; i++) {
        energy[i] = INFINITY;
        contact[i] = -1;
        for (int f = 0; f < m->n_contact; f++) {
            double c = m->normal[f * m->n_dof + i],
                   d = m->contact[f].clearance / ric_model_length(m), omega = m->frequency[i];
            if (c == 0 || omega == 0) continue;
            double E = omega * omega * d * d / (2 * c * c);
            if (E < energy[i]) {
                energy[i] = E;
                contact[i] = f;
            }
        }
    }
    return RIC_OK;
}

/* Linear mode i with the force of contact f under a power law as large as that of the structure
 * along it: with r the displacement c_fi A over the contact's length, reference r^m c_fi =
 * omega_i^2 A, so that r^(m-1) = omega_i^2 / (reference c_fi^2). */
static double power_onset(const ric_model *m, int f, int i)
{
    const ric_contact *contact = &m->contact[f];
    const bool own = contact->length > 0;
    const double c = m->normal[f * m->n_dof + i], omega2 = m->frequency[i] * m->frequency[i],
                 k = own ? contact->reference : contact->stiffness,
                 length = own ? contact->length : 1,
                 ratio = pow(omega2 / (k * c * c), 1.0 / (contact->exponent - 1)),
                 amplitude = length / c * ratio / ric_model_length(m);
    return omega2 * amplitude * amplitude / 2;
}

ric_status ric_model_onsets(const ric_model *m, double *energy)
{
    int contact[m->n_dof];
    if (m->law != RIC_LAW_POWER) {
        ric_status status = ric_model_grazing_energies(m, energy, contact);
        for (int i = 0; i < m->n_dof; i++)
            if (!m->seen[i]) energy[i] = INFINITY;
        return status;
    }
    for (int i = 0; i < m->n_dof; i++) {
        energy[i] = INFINITY;
        for (int f = 0; f < m->n_contact; f++)
            if (m->seen[i] && m->frequency[i] > 0 && m->normal[f * m->n_dof + i] != 0)
                energy[i] = fmin(energy[i], power_onset(m, f, i));
    }
    return RIC_OK;
}

double ric_model_onset(const ric_model *m, int *mode)
{
    double energy[m->n_dof];
    if (mode) *mode = 0;
    if (ric_model_onsets(m, energy)) return NAN;
    for (int i = 0; i < m->n_dof; i++)
        if (isfinite(energy[i])) {
            if (mode) *mode = i + 1;
            return energy[i];
        }
    return NAN;
}

/* Eigenfrequencies with s = 0 held: diag(omega^2) restricted to the complement of c, in
 * mass-normalised modal coordinates. */
ric_status ric_model_locked_frequencies(const ric_model *m, int contact, double *out)
{
    ric_status status = RIC_OK;
    int n = m->n_dof;
    double *E = ric_calloc((size_t)n * (size_t)n, sizeof *E),
           *A = ric_calloc((size_t)n * (size_t)n, sizeof *A);
    if (contact < 0 || contact >= m->n_contact) {
        status = ric_fail(RIC_E_RANGE, "contact %d does not exist; there are %d, from 0", contact,
                          m->n_contact);
        goto out;
    }
    if (!E || !A) {
        status = ric_no_memory("the locked frequencies");
        goto out;
    }
    ric_model_complement(n, m->normal + contact * n, E);
    for (int i = 0; i < n - 1; i++)
        for (int j = 0; j < n - 1; j++)
            for (int k = 0; k < n; k++)
                A[i * (n - 1) + j] += E[i * n + k] * m->frequency[k] * m->frequency[k] *
                                      E[j * n + k];
    if (n > 1 && ric_lapack(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'U', n - 1, A, n - 1, out))) {
        status = ric_fail(RIC_E_NUMERIC, "the locked frequencies could not be computed");
        goto out;
    }
    double largest = n > 1 ? fabs(out[n - 2]) : 0;
    for (int i = 0; i < n - 1; i++)
        out[i] = out[i] <= LOCKED * n * DBL_EPSILON * largest ? 0 : sqrt(out[i]);
out:
    free(E);
    free(A);
    return status;
}

ric_status ric_model_compliance(const ric_model *m, int contact, double *cumulative)
{
    double sum = 0;
    if (contact < 0 || contact >= m->n_contact)
        return ric_fail(RIC_E_RANGE, "contact %d does not exist; there are %d, from 0", contact,
                        m->n_contact);
    for (int i = 0; i < m->n_dof; i++) {
        double c = m->normal[contact * m->n_dof + i];
        cumulative[i] = sum += c * c;
    }
    return RIC_OK;
}

/* x' A x, with A x of twice the digits: it cancels by as much as the highest mode is stiffer than
 * the motion, 1e9 in a beam of short finite elements. */
static double quadratic(int n, const double *A, const double *x)
{
    double sum = 0;
    for (int i = 0; i < n; i++) {
        ric_twice force = {0, 0};
        for (int j = 0; j < n; j++)
            force = ric_twice_add(force, ric_twice_product(A[i * n + j], x[j]));
        sum += x[i] * force.hi;
    }
    return sum;
}

double ric_model_energy(const ric_model *m, const double *x, const double *v)
{
    double energy = (quadratic(m->n_dof, m->M, v) + quadratic(m->n_dof, m->K, x)) / 2;
    for (int f = 0; f < m->n_contact; f++) {
        const ric_contact *contact = &m->contact[f];
        double s = ric_dot(m->n_dof, contact->normal, x),
               unit = m->energy_unit / (m->length * m->length),
               d = contact->clearance / ric_model_length(m);
        if (contact->law == RIC_LAW_POWER)
            energy += m->energy_unit * m->spring[f] * pow(s / m->length, contact->exponent + 1) /
                      (contact->exponent + 1);
        if (contact->law != RIC_LAW_BILINEAR) continue;
        double over = s > d && contact->sides != RIC_SIDES_LOWER    ? s - d
                      : s < -d && contact->sides != RIC_SIDES_UPPER ? -s - d
                                                                    : 0;
        energy += unit * m->spring[f] * over * over / 2;
    }
    return energy;
}

bool ric_model_orthogonal(const ric_model *m, int f, int g)
{
    const double *c = m->c + f * m->n, *d = m->c + g * m->n;
    return fabs(ric_dot(m->n, c, d)) <=
           ORTHOGONAL * sqrt(ric_dot(m->n, c, c) * ric_dot(m->n, d, d));
}

/* p . q of the parts of faces f and g that belong to loose masses, in the direction in which they
 * push. */
static double pushes(const ric_model *m, int face_f, int face_g)
{
    const ric_face *f = &m->face[face_f], *g = &m->face[face_g];
    double sum = 0;
    for (int i = 0; i < m->n; i++)
        if (!(m->omega[i] > 0)) sum += f->side * f->c[i] * (g->side * g->c[i]);
    return sum;
}

bool ric_model_opposite(const ric_model *m, int f, int g)
{
    const double ff = pushes(m, f, f), gg = pushes(m, g, g);
    return ff > 0 && gg > 0 && pushes(m, f, g) < -(1 - OPPOSITE) * sqrt(ff * gg);
}

bool ric_model_balances(const ric_model *m, int n, const int *faces)
{
    for (int i = 0; i < n; i++) {
        const double *c = m->face[faces[i]].c;
        bool alone = pushes(m, faces[i], faces[i]) > OPPOSITE * ric_dot(m->n, c, c);
        for (int j = 0; j < n && alone; j++) alone = !(pushes(m, faces[i], faces[j]) < 0);
        if (alone) return false;
    }
    return true;
}

bool ric_model_rattles(const ric_model *m)
{
    for (int f = 0; f < m->n_face && m->n_part == 1; f++)
        for (int g = f + 1; g < m->n_face; g++)
            if (ric_model_opposite(m, f, g)) return true;
    return false;
}

void ric_model_to_state(const ric_model *m, const double *w, double *x, double *v)
{
    int n = m->n;
    for (int j = 0; j < m->n_dof; j++) {
        double sx = 0, sv = 0;
        for (int i = 0; i < n; i++) {
            sx += m->to_space[j * n + i] * (w[i] / m->kappa[i]);
            sv += m->to_space[j * n + i] * w[n + i];
        }
        x[j] = sx;
        v[j] = sv * m->omega_ref;
    }
}

void ric_model_from_state(const ric_model *m, const double *x, const double *v, double *w)
{
    int n = m->n;
    for (int i = 0; i < n; i++) {
        w[i] = m->kappa[i] * ric_dot(m->n_dof, m->to_modal + i * m->n_dof, x);
        w[n + i] = ric_dot(m->n_dof, m->to_modal + i * m->n_dof, v) / m->omega_ref;
    }
}
