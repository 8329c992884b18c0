/* A structure with its lowest modes only (docs/theory.md section 1). Its contacts act along b_N = M
 * Phi_N Phi_N' b, which moves the modes that are kept as b does and no other: M, K and the new
 * normals are a structure like any other, in which the rest of the modes is not seen, and whoever
 * checks an orbit needs to know no more.
 *
 * The rest gives way to a force F at contact f by R F, R = sum over the rest of c c' / omega^2.
 * Behind a spring that is one of its own, k / (1 + k R); a rigid stop would no longer be one, and a
 * power law none either: there it is left out. */
#include "truncate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "modal.h"
#include "model.h"
#include "modes.h"

#define EQUAL 1e-8   /* relative: frequencies that belong to one family of modes */
#define UNSEEN 1e-10 /* of c.c: what is left of a contact that no mode that is kept sees */

int ric_truncate_count(const ric_model *m, double up_to)
{
    int n = 0;
    while (n < m->n_dof && m->frequency[n] <= up_to) n++;
    return n;
}

double ric_truncate_rest(const ric_model *m, int n_mode, int f, int g)
{
    double sum = 0;
    for (int i = n_mode; i < m->n_dof; i++)
        if (m->frequency[i] > 0)
            sum += m->normal[f * m->n_dof + i] * m->normal[g * m->n_dof + i] /
                   (m->frequency[i] * m->frequency[i]);
    return sum;
}

ric_status ric_truncate_check(const ric_model *m, int n_mode)
{
    const int n = m->n_dof;
    if (n_mode < 1 || n_mode > n)
        return ric_fail(RIC_E_INPUT, "%d modes; the structure has modes 1 to %d", n_mode, n);
    if (n_mode < n && m->frequency[n_mode] <= m->frequency[n_mode - 1] * (1 + EQUAL))
        return ric_fail(RIC_E_INPUT,
                        "modes %d and %d have one frequency; keep both, or none of them", n_mode,
                        n_mode + 1);
    for (int f = 0; f < m->n_contact; f++) {
        double kept = 0, all = 0;
        for (int i = 0; i < n; i++) {
            const double c = m->normal[f * n + i];
            all += c * c;
            if (i < n_mode) kept += c * c;
        }
        if (kept < UNSEEN * all)
            return ric_fail(RIC_E_INPUT,
                            "contact %d is seen by none of the %d modes that are kept; keep more",
                            f + 1, n_mode);
    }
    return RIC_OK;
}

/* b_N of a contact, [n_dof]. */
static void project(const ric_model *m, int n_mode, int f, double *out)
{
    const int n = m->n_dof;
    double sum[n];
    for (int j = 0; j < n; j++) {
        sum[j] = 0;
        for (int i = 0; i < n_mode; i++) sum[j] += m->Phi[j * n + i] * m->normal[f * n + i];
    }
    for (int j = 0; j < n; j++) out[j] = ric_dot(n, m->M + j * n, sum);
}

ric_status ric_model_truncate(const ric_model *m, int n_mode, ric_model **out)
{
    const size_t n = (size_t)m->n_dof, n_contact = (size_t)m->n_contact;
    *out = NULL;
    ric_status status = ric_truncate_check(m, n_mode);
    if (status) return status;
    ric_contact *contacts = ric_calloc(n_contact, sizeof *contacts);
    double *normals = ric_calloc(n_contact * n, sizeof *normals);
    if (!contacts || !normals) status = ric_no_memory("a model with fewer modes");
    for (int f = 0; f < m->n_contact && !status; f++) {
        contacts[f] = m->contact[f];
        contacts[f].normal = normals + (size_t)f * n;
        project(m, n_mode, f, normals + (size_t)f * n);
        if (contacts[f].law == RIC_LAW_BILINEAR)
            contacts[f].stiffness /= 1 + contacts[f].stiffness * ric_truncate_rest(m, n_mode, f, f);
    }
    const ric_model *same = ric_modes_distinct(m) ? m : NULL; /* of which the modes are taken */
    if (!status)
        status = ric_model_create_near(same, m->n_dof, m->M, m->K, m->n_contact, contacts,
                                       m->restitution, out);
    free(contacts);
    free(normals);
    return status;
}
