#include "model.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "joined.h"
#include "mixture.h"
#include "modes.h"
#include "modal.h"
#include "regime.h"
#include "base/room.h"

/* Of the largest entry: what rounding of a study's numbers leaves of symmetry; more is a mistake in
 * them. */
#define ASYMMETRIC 1e-12
/* Entry of a matrix: products with twice the digits of a double overflow beyond 1.3e300 (twice.h).
 */
#define LARGEST 1e300

static void *array(size_t count, size_t size)
{
    return ric_calloc(count ? count : 1, size);
}

/* ---------------------------------------------------------------- checks */

static ric_status check_matrix(int n, const double *A, const char *name)
{
    double largest = 0;
    for (int i = 0; i < n * n; i++) {
        if (!isfinite(A[i]))
            return ric_fail(RIC_E_INPUT,
                            "%s matrix: the entry of row %d, column %d is not a finite number",
                            name, i / n + 1, i % n + 1);
        if (fabs(A[i]) > LARGEST)
            return ric_fail(RIC_E_INPUT,
                            "%s matrix: the entry of row %d, column %d is %g, and numbers up to %g "
                            "are taken; choose "
                            "other units",
                            name, i / n + 1, i % n + 1, A[i], LARGEST);
        largest = fmax(largest, fabs(A[i]));
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++)
            if (fabs(A[i * n + j] - A[j * n + i]) > ASYMMETRIC * largest)
                return ric_fail(RIC_E_INPUT,
                                "%s matrix is not symmetric: row %d, column %d is %.17g but row "
                                "%d, column %d is "
                                "%.17g; make them equal",
                                name, i + 1, j + 1, A[i * n + j], j + 1, i + 1, A[j * n + i]);
    return RIC_OK;
}

static ric_status check_contact(int n, int i, const ric_contact *contact)
{
    if (contact->law == RIC_LAW_POWER) {
        if (contact->exponent < 3 || contact->exponent > 99 || contact->exponent % 2 == 0)
            return ric_fail(RIC_E_INPUT,
                            "contact %d: exponent %d is not an odd number from 3 to 99", i + 1,
                            contact->exponent);
        const double *value = contact->length != 0 ? &contact->reference : &contact->stiffness;
        if (!isfinite(*value) || *value <= 0 || !isfinite(contact->length) || contact->length < 0)
            return ric_fail(RIC_E_INPUT,
                            "contact %d: a power law needs a stiffness, or a length with a "
                            "reference stiffness, positive",
                            i + 1);
    } else if (!isfinite(contact->clearance) || contact->clearance <= 0)
        return ric_fail(RIC_E_INPUT,
                        "contact %d: clearance %g is not a positive length; the linear motion that "
                        "every branch starts "
                        "from needs an open gap (for a preloaded stop use a small clearance)",
                        i + 1, contact->clearance);
    if (contact->law == RIC_LAW_BILINEAR &&
        (!isfinite(contact->stiffness) || contact->stiffness <= 0))
        return ric_fail(RIC_E_INPUT, "contact %d: contact stiffness %g is not positive", i + 1,
                        contact->stiffness);
    double largest = 0;
    for (int j = 0; j < n; j++) {
        if (!isfinite(contact->normal[j]))
            return ric_fail(RIC_E_INPUT, "contact %d: number %d of the normal is not finite", i + 1,
                            j + 1);
        largest = fmax(largest, fabs(contact->normal[j]));
    }
    if (largest == 0)
        return ric_fail(RIC_E_INPUT,
                        "contact %d: the normal is all zeros; it must name the displacements that "
                        "close the gap",
                        i + 1);
    return RIC_OK;
}

static ric_status check(int n, const double *M, const double *K, int n_contact,
                        const ric_contact *contacts, double restitution)
{
    ric_status status = RIC_OK;
    if (n < 1 || n > 10000)
        return ric_fail(RIC_E_INPUT, "%d degrees of freedom; there must be 1 to 10000", n);
    if (n_contact < 1)
        return ric_fail(
            RIC_E_INPUT,
            "no contacts; without one the structure is linear and its modes are the answer");
    if (!(restitution >= 0 && restitution <= 1))
        return ric_fail(RIC_E_INPUT, "restitution %g is outside [0, 1]", restitution);
    if ((status = check_matrix(n, M, "mass"))) return status;
    if ((status = check_matrix(n, K, "stiffness"))) return status;
    for (int i = 0; i < n_contact; i++) {
        if ((status = check_contact(n, i, &contacts[i]))) return status;
        if ((contacts[i].law == RIC_LAW_POWER) != (contacts[0].law == RIC_LAW_POWER))
            return ric_fail(
                RIC_E_INPUT,
                "contact %d: a power law and contacts that open and close cannot be mixed", i + 1);
    }
    return RIC_OK;
}

/* ------------------------------------------------------------ eigenvalues */

static ric_status check_mass(int n, const double *M)
{
    ric_status status = RIC_OK;
    double *A = array((size_t)n * (size_t)n, sizeof *A), *value = array((size_t)n, sizeof *value);
    if (!A || !value) {
        status = ric_no_memory("the mass matrix");
        goto out;
    }
    memcpy(A, M, (size_t)n * (size_t)n * sizeof *A);
    if (ric_lapack(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'U', n, A, n, value))) {
        status = ric_fail(RIC_E_NUMERIC,
                          "the eigenvalues of the mass matrix could not be computed");
        goto out;
    }
    if (value[0] <= n * DBL_EPSILON * value[n - 1]) {
        int worst = 0;
        for (int i = 0; i < n; i++)
            if (M[i * n + i] < M[worst * n + worst]) worst = i;
        status = value[0] > 0
                     ? ric_fail(RIC_E_INPUT,
                                "mass matrix is singular to rounding: its eigenvalues go from %g "
                                "to %g; check row "
                                "%d, column %d, which is %g",
                                value[0], value[n - 1], worst + 1, worst + 1, M[worst * n + worst])
                     : ric_fail(RIC_E_INPUT,
                                "mass matrix is not positive definite: its smallest eigenvalue is "
                                "%g; check row %d, column %d, "
                                "which is %g%s",
                                value[0], worst + 1, worst + 1, M[worst * n + worst],
                                M[worst * n + worst] == 0
                                    ? ": a displacement without mass follows the others "
                                      "statically; condense it out of both matrices, or give it a "
                                      "mass"
                                    : "");
    }
out:
    free(A);
    free(value);
    return status;
}

/* ------------------------------------------------------------ scaled frame */

void ric_model_complement(int n, const double *h, double *E)
{
    double norm = sqrt(ric_dot(n, h, h)), v0 = h[0] + copysign(norm, h[0]),
           beta = 1 / (norm * (norm + fabs(h[0])));
    for (int i = 1; i < n; i++)
        for (int j = 0; j < n; j++) E[(i - 1) * n + j] = (i == j) - beta * h[i] * (j ? h[j] : v0);
    /* the reflection's pivot sign would turn the basis over where h[0] changes sign */
    for (int j = 0; n > 1 && h[0] < 0 && j < n; j++) E[j] = -E[j];
}

/* The reflection is 1 - beta v v' with v = (v0, h_1, ..). */
void ric_model_across(int n, const double *h, int columns, int ld, double *X)
{
    double norm = sqrt(ric_dot(n, h, h)), v0 = h[0] + copysign(norm, h[0]),
           beta = 1 / (norm * (norm + fabs(h[0])));
    double along[columns];
    for (int j = 0; j < columns; j++) along[j] = v0 * X[j];
    for (int i = 1; i < n; i++)
        for (int j = 0; j < columns; j++) along[j] += h[i] * X[i * ld + j];
    for (int j = 0; j < columns; j++) along[j] *= beta;
    for (int i = 1; i < n; i++)
        for (int j = 0; j < columns; j++) X[(i - 1) * ld + j] = X[i * ld + j] - h[i] * along[j];
    for (int j = 0; n > 1 && h[0] < 0 && j < columns; j++) X[j] = -X[j];
}

#define LINEAR_ENERGY                                                                              \
    1e-6          /* amplitudes of a thousandth of the length at which a power law acts            \
                   */
#define FAST 20.0 /* ratio to the lowest frequency */
/* NEAR_ONE: powers of two by which a unit may be off before it is changed: a digit */
#define NEAR_ONE 4

/* The length at which a contact acts: its clearance, or where the force of a power law is that of
 * the structure, k_c s^m c.c = omega_ref^2 s. */
static double acting_length(const ric_model *m, int f)
{
    const ric_contact *contact = &m->contact[f];
    double cc = 0, order = contact->exponent - 1, omega2 = m->omega_ref * m->omega_ref;
    if (contact->law != RIC_LAW_POWER) return contact->clearance;
    for (int i = 0; i < m->n; i++)
        cc += m->normal[f * m->n_dof + m->mode[i]] * m->normal[f * m->n_dof + m->mode[i]];
    if (!(cc > 0)) return HUGE_VAL;
    return contact->length > 0
               ? contact->length * pow(omega2 / (contact->reference * cc), 1 / order)
               : pow(omega2 / (contact->stiffness * cc), 1 / order);
}

/* A power of two near x, so that nothing is rounded by it; 1 as long as that will do. */
static double unit_near(double x)
{
    double exponent = round(log2(x));
    return fabs(exponent) < NEAR_ONE || !isfinite(exponent) ? 1 : exp2(exponent);
}

static double length_unit(const ric_model *m)
{
    double least = HUGE_VAL;
    for (int f = 0; f < m->n_contact; f++) least = fmin(least, acting_length(m, f));
    return unit_near(least / ric_model_length(m));
}

/* The scaled force of a contact is spring * s^exponent, or spring * (s - gap). */
static double scaled_spring(const ric_model *m, const ric_contact *contact, double unit)
{
    double d = ric_model_length(m) * m->length;
    if (contact->law == RIC_LAW_RIGID) return 0;
    if (contact->law == RIC_LAW_BILINEAR) return contact->stiffness / unit;
    double k = contact->length > 0
                   ? contact->reference * pow(d / contact->length, contact->exponent - 1)
                   : contact->stiffness * pow(d, contact->exponent - 1);
    return k / unit;
}

static void scale_modes(ric_model *m)
{
    int n = m->n, nd = m->n_dof, k = 0;
    for (int i = 0; i < nd; i++)
        if (m->seen[i]) m->mode[k++] = i;
    m->omega_ref = 1;
    for (int i = n - 1; i >= 0; i--)
        if (m->frequency[m->mode[i]] > 0) m->omega_ref = m->frequency[m->mode[i]];
    double cc = 0;
    for (int i = 0; i < n; i++) cc += m->normal[m->mode[i]] * m->normal[m->mode[i]];
    double unit = sqrt(cc); /* |c_0|, physical */
    double stiffness = m->omega_ref * m->omega_ref / cc;
    m->length = length_unit(m);
    m->energy_unit = stiffness * m->length * m->length;
    if (m->law == RIC_LAW_POWER) m->linear_energy = LINEAR_ENERGY * unit_near(m->energy_unit);
    for (int f = 0; f < m->n_contact; f++)
        m->spring[f] = scaled_spring(m, &m->contact[f], stiffness);
    for (int i = 0; i < n; i++) {
        int mode = m->mode[i];
        long double omega = ((long double)m->frequency[mode] + m->frequency_low[mode]) /
                            m->omega_ref;
        m->omega[i] = (double)omega;
        m->omega_low[i] = (double)(omega - m->omega[i]);
        m->fast |= omega > FAST;
        m->kappa[i] = m->omega[i] > 0 ? m->omega[i] : 1;
        m->stiff[i] = m->omega[i] > 0 ? m->omega[i] : 0;
        for (int f = 0; f < m->n_contact; f++) {
            m->c[f * n + i] = m->normal[f * nd + mode] / unit;
            m->g[f * n + i] = m->c[f * n + i] / m->kappa[i];
        }
        double shape[nd]; /* columns of a large matrix are far apart in memory; M is symmetric, so
                             that its rows will do */
        for (int l = 0; l < nd; l++) shape[l] = m->Phi[l * nd + mode];
        for (int j = 0; j < nd; j++) {
            m->to_modal[i * nd + j] = ric_dot(nd, shape, m->M + j * nd) * unit / m->length;
            m->to_space[j * n + i] = shape[j] / unit * m->length;
        }
    }
}

static void make_faces(ric_model *m)
{
    int n = m->n;
    m->symmetric = true;
    for (int f = 0; f < m->n_contact; f++) {
        double *E = m->E + (size_t)f * (size_t)(n - 1) * (size_t)n;
        ric_model_complement(n, m->c + f * n, E);
        if (m->contact[f].law == RIC_LAW_POWER) continue;
        bool both = m->contact[f].sides == RIC_SIDES_BOTH;
        if (!both) m->symmetric = false;
        for (int side = 1; side >= -1; side -= 2) {
            if (side > 0 && m->contact[f].sides == RIC_SIDES_LOWER) continue;
            if (side < 0 && m->contact[f].sides == RIC_SIDES_UPPER) continue;
            int mirror = !both ? -1 : side > 0 ? m->n_face + 1 : m->n_face - 1;
            m->face[m->n_face++] = (ric_face){.contact = f,
                                              .side = side,
                                              .mirror = mirror,
                                              .gap = side * m->contact[f].clearance /
                                                     m->contact[0].clearance / m->length,
                                              .spring = m->spring[f],
                                              .c = m->c + f * n,
                                              .g = m->g + f * n,
                                              .cc = ric_dot(n, m->c + f * n, m->c + f * n),
                                              .E = E};
        }
    }
}

static ric_status allocate(ric_model *m, int n, int n_contact)
{
    size_t nn = (size_t)n * (size_t)n, fn = (size_t)n_contact * (size_t)n;
    m->n_dof = n;
    m->n_contact = n_contact;
    m->M = array(nn, sizeof(double));
    m->K = array(nn, sizeof(double));
    m->b = array(fn, sizeof(double));
    m->contact = array((size_t)n_contact, sizeof *m->contact);
    m->spring = array((size_t)n_contact, sizeof(double));
    m->frequency = array((size_t)n, sizeof(double));
    m->frequency_low = array((size_t)n, sizeof(double));
    m->Phi = array(nn, sizeof(double));
    m->normal = array(fn, sizeof(double));
    m->seen = array((size_t)n, sizeof *m->seen);
    if (!m->M || !m->K || !m->b || !m->contact || !m->spring || !m->frequency ||
        !m->frequency_low || !m->Phi || !m->normal || !m->seen)
        return ric_fail(RIC_E_NOMEM, "no memory for a model of %d degrees of freedom", n);
    return RIC_OK;
}

static ric_status allocate_scaled(ric_model *m)
{
    size_t n = (size_t)m->n, f = (size_t)m->n_contact;
    m->mode = array(n, sizeof *m->mode);
    m->omega = array(n, sizeof(double));
    m->omega_low = array(n, sizeof(double));
    m->kappa = array(n, sizeof(double));
    m->stiff = array(n, sizeof(double));
    m->c = array(f * n, sizeof(double));
    m->g = array(f * n, sizeof(double));
    m->E = array(f * n * n, sizeof(double));
    m->face = array(2 * f, sizeof *m->face);
    m->to_modal = array(n * (size_t)m->n_dof, sizeof(double));
    m->to_space = array(n * (size_t)m->n_dof, sizeof(double));
    if (!m->mode || !m->omega || !m->omega_low || !m->kappa || !m->stiff || !m->c || !m->g ||
        !m->E || !m->face || !m->to_modal || !m->to_space)
        return ric_fail(RIC_E_NOMEM, "no memory for %d seen modes", m->n);
    return RIC_OK;
}

ric_status ric_model_create_near(const ric_model *near, int n_dof, const double *mass,
                                 const double *stiffness, int n_contact,
                                 const ric_contact *contacts, double restitution, ric_model **out)
{
    ric_model *m = NULL;
    ric_status status = check(n_dof, mass, stiffness, n_contact, contacts, restitution);
    *out = NULL;
    if (status) goto out;
    if ((status = check_mass(n_dof, mass))) goto out;
    if (!(m = ric_calloc(1, sizeof *m))) {
        status = ric_no_memory("a model");
        goto out;
    }
    if ((status = allocate(m, n_dof, n_contact))) goto out;
    for (int i = 0; i < n_dof; i++)
        for (int j = 0; j < n_dof; j++) {
            m->M[i * n_dof + j] = (mass[i * n_dof + j] + mass[j * n_dof + i]) / 2;
            m->K[i * n_dof + j] = (stiffness[i * n_dof + j] + stiffness[j * n_dof + i]) / 2;
        }
    for (int i = 0; i < n_contact; i++) {
        memcpy(m->b + i * n_dof, contacts[i].normal, (size_t)n_dof * sizeof(double));
        m->contact[i] = contacts[i];
        m->contact[i].normal = m->b + i * n_dof;
        if (contacts[i].name && !(m->contact[i].name = ric_strdup(contacts[i].name))) {
            status = ric_no_memory("a contact's name");
            goto out;
        }
    }
    for (int i = 0; i < n_contact; i++)
        m->law = contacts[i].law > m->law ? contacts[i].law : m->law;
    m->restitution = restitution;
    const bool taken = near && ric_modes_take(m, near);
    if (!taken && (status = ric_modes_find(m))) goto out;
    if ((status = ric_modes_see(m))) goto out;
    if (near && !taken && (status = ric_modes_orient(m, near))) goto out;
    if ((status = allocate_scaled(m))) goto out;
    scale_modes(m);
    make_faces(m);
    if ((status = ric_regimes_create(m))) goto out;
    if ((status = ric_mixtures_create(m))) goto out;
    if ((status = ric_shelf_create(&m->simulators))) goto out;
    *out = m;
    m = NULL;
out:
    ric_model_free(m);
    return status;
}

ric_status ric_model_create(int n_dof, const double *mass, const double *stiffness, int n_contact,
                            const ric_contact *contacts, double restitution, ric_model **out)
{
    return ric_model_create_near(NULL, n_dof, mass, stiffness, n_contact, contacts, restitution,
                                 out);
}

void ric_model_free(ric_model *m)
{
    if (!m) return;
    for (int i = 0; m->contact && i < m->n_contact; i++) free(ric_own(m->contact[i].name));
    void *owned[] =
        {m->M,     m->K,      m->b,    m->contact, m->spring, m->frequency, m->frequency_low,
         m->Phi,   m->normal, m->seen, m->mode,    m->omega,  m->omega_low, m->kappa,
         m->stiff, m->c,      m->g,    m->E,       m->face,   m->to_modal,  m->to_space};
    for (size_t i = 0; i < sizeof owned / sizeof *owned; i++) free(owned[i]);
    ric_regimes_free(m);
    ric_mixtures_free(m);
    ric_joined_members_free(m->members);
    ric_shelf_free(m->simulators);
    free(m);
}
