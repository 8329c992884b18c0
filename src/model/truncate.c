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
/* GROWS: of c.c: a mass of its own at the contact leaves less than this to the upper half */
#define GROWS 0.25
enum { FEW_MODES = 6 }; /* below, the structure is taken for what it is */

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

/* Share of c.c that the upper half of the modes brings. A truncated continuum keeps growing; its
 * impact orbits do not converge. */
static double late_growth(const ric_model *m, int f)
{
    double all = 0, late = 0;
    for (int i = 0; i < m->n_dof; i++) {
        const double c = m->normal[f * m->n_dof + i];
        all += c * c;
        if (i >= m->n_dof / 2) late += c * c;
    }
    return all > 0 ? late / all : 0;
}

void ric_truncate_growth(const ric_model *m, size_t size, char *out)
{
    int n = 0, first = 0;
    double most = 0;
    char more[40] = "";
    out[0] = '\0';
    for (int f = 0; f < m->n_contact && m->n_dof >= FEW_MODES; f++) {
        const double growth = late_growth(m, f);
        if (m->contact[f].law != RIC_LAW_RIGID || growth <= GROWS) continue;
        if (n++ == 0) first = f + 1;
        most = fmax(most, growth);
    }
    if (n == 0) return;
    if (n > 1) snprintf(more, sizeof more, " and of %d more", n - 1);
    snprintf(out, size,
             "the upper half of all modes brings %s%.0f %% of c.c of contact %d%s, which still "
             "grows: if the structure is a truncated continuum, its impact orbits do not converge "
             "with the number of modes; the cures are a mass of its own at the contact point, or a "
             "spring (law: bilinear) in place of the stop",
             n > 1 ? "up to " : "", 100 * most, first, more);
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
