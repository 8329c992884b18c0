#include "joined.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "modal.h"
#include "model.h"
#include "modes.h"

/* ALIKE: of |c|: parts of normals in a mode that differ by less are the same but for rounding of
 * shapes, which have an error of rounding over the distance of frequencies */
#define ALIKE 1e-9
/* SAME: relative: numbers of a study that are meant to be one */
#define SAME 1e-12
/* NEARLY: of |c|: what is left of a mode in the mean of normals that are nearly images */
#define NEARLY 1e-6

ric_status ric_joined_create(int n_contact, ric_joined *out)
{
    *out = (ric_joined){.n_contact = n_contact,
                        .group = ric_calloc((size_t)n_contact + 1, sizeof *out->group),
                        .sign = ric_calloc((size_t)n_contact + 1, sizeof *out->sign)};
    if (out->group && out->sign) return RIC_OK;
    ric_joined_free(out);
    return ric_no_memory("contacts that close together");
}

void ric_joined_free(ric_joined *joined)
{
    free(joined->group);
    free(joined->sign);
    *joined = (ric_joined){.n_group = 0};
}

/* ------------------------------------------------------------ one contact for several */

static bool same(double a, double b)
{
    return fabs(a - b) <= SAME * fmax(fabs(a), fabs(b));
}

static bool same_sides(const ric_contact *a, const ric_contact *b, int sign)
{
    const ric_sides turned = b->sides == RIC_SIDES_BOTH    ? RIC_SIDES_BOTH
                             : b->sides == RIC_SIDES_UPPER ? RIC_SIDES_LOWER
                                                           : RIC_SIDES_UPPER;
    return a->sides == (sign < 0 ? turned : b->sides);
}

/* What two contacts that close together do not have in common; NULL: nothing. */
static const char *difference(const ric_contact *a, const ric_contact *b, int sign)
{
    return a->law != b->law || a->exponent != b->exponent ? "their laws differ"
           : !same(a->clearance, b->clearance)            ? "their clearances differ"
           : !same(a->stiffness, b->stiffness) || !same(a->length, b->length) ||
                   !same(a->reference, b->reference)
               ? "their stiffnesses differ"
           : !same_sides(a, b, sign) ? "one closes upwards and the other downwards; a minus before "
                                       "one of the two numbers "
                                       "says that"
                                     : NULL;
}

/* Contact `first` with all of its group. */
static ric_status join(const ric_joined *j, int n, const ric_contact *contacts, int first,
                       ric_contact *out)
{
    double *normal = ric_own(out->normal), largest = 0, size = 0;
    char name[200] = "";
    size_t used = 0;
    for (int i = first; i < j->n_contact; i++) {
        if (j->group[i] != j->group[first]) continue;
        const char *why = difference(&contacts[first], &contacts[i], j->sign[i]);
        if (why)
            return ric_fail(RIC_E_INPUT, "contacts %d and %d do not close together: %s", first + 1,
                            i + 1, why);
        out->together++;
        for (int k = 0; k < n; k++) {
            normal[k] += j->sign[i] * contacts[i].normal[k];
            size = fmax(size, fabs(contacts[i].normal[k]));
        }
        if (contacts[i].name && used < sizeof name)
            used += (size_t)snprintf(name + used, sizeof name - used, "%s%s",
                                     !used            ? ""
                                     : j->sign[i] < 0 ? "-"
                                                      : "+",
                                     contacts[i].name);
    }
    for (int k = 0; k < n; k++) {
        normal[k] /= out->together;
        largest = fmax(largest, fabs(normal[k]));
    }
    if (!(largest > ALIKE * size))
        return ric_fail(RIC_E_INPUT,
                        "contacts %d and others cannot close together: the mean of their normals "
                        "is zero; a minus before the number of one that closes upwards as the "
                        "first one closes downwards turns its normal round",
                        first + 1);
    if (used && !(out->name = ric_strdup(name))) return ric_no_memory("a contact's name");
    out->stiffness *= out->together; /* all of them push */
    out->reference *= out->together;
    return RIC_OK;
}

ric_status ric_joined_contacts(const ric_joined *j, int n, const ric_contact *contacts, int *n_out,
                               ric_contact **out)
{
    const int n_contact = j->n_contact;
    bool done[n_contact + 1];
    memset(done, 0, sizeof done);
    *n_out = 0;
    if (!(*out = ric_calloc((size_t)n_contact + 1, sizeof **out)))
        return ric_no_memory("contacts that close together");
    for (int i = 0; i < n_contact; i++) {
        if (j->group[i] && done[j->group[i]]) continue;
        ric_contact *c = &(*out)[(*n_out)++];
        double *normal = ric_calloc((size_t)n, sizeof *normal);
        *c = contacts[i];
        c->name = NULL;
        c->normal = normal; /* released with the contact, also on failure */
        if (!normal) return ric_no_memory("contacts that close together");
        if (j->group[i]) {
            const ric_status status = join(j, n, contacts, i, c);
            if (status) return status;
            done[j->group[i]] = true;
            continue;
        }
        memcpy(normal, contacts[i].normal, (size_t)n * sizeof *normal);
        if (contacts[i].name && !(c->name = ric_strdup(contacts[i].name)))
            return ric_no_memory("a contact's name");
    }
    return RIC_OK;
}

/* ------------------------------------------------------------ is it one structure? */

/* phi_i . y of mode i. */
static double part(const ric_model *m, int i, const double *y)
{
    double sum = 0;
    for (int k = 0; k < m->n_dof; k++) sum += m->Phi[k * m->n_dof + i] * y[k];
    return sum;
}

/* |c| of a normal. */
static double norm(const ric_model *m, const double *y)
{
    double sum = 0;
    for (int i = 0; i < m->n_dof; i++) {
        const double c = part(m, i, y);
        sum += c * c;
    }
    return sqrt(sum);
}

/* "" or what a user may do where contacts part by no more than last digits, or a mode that parts
 * them is seen by no more than these. */
static const char *remedy(const ric_model *m, int mode, double apart, double size)
{
    bool nearly = true;
    for (int f = 0; f < m->n_contact; f++) {
        const double *c = &m->normal[f * m->n_dof];
        nearly &= fabs(c[mode]) <= NEARLY * sqrt(ric_dot(m->n_dof, c, c));
    }
    return nearly || apart <= NEARLY * size
               ? "; but for the last digits it is one, so that the mean of it and its image will do"
               : "";
}

ric_status ric_joined_check(const ric_joined *j, const ric_model *m, const ric_contact *contacts)
{
    for (int i = 0; i < j->n_contact; i++) {
        int first = 0;
        while (j->group[i] && j->group[first] != j->group[i]) first++;
        if (!j->group[i] || first == i) continue;
        const double size = norm(m, contacts[i].normal);
        for (int k = 0; k < m->n_dof; k++) {
            const double a = part(m, k, contacts[first].normal),
                         b = j->sign[i] * part(m, k, contacts[i].normal);
            if (m->seen[k] && fabs(a - b) > ALIKE * size)
                return ric_fail(RIC_E_INPUT,
                                "contacts %d and %d do not stay together: mode %d of %.6g rad/s "
                                "moves them by %.10g and %.10g, and the impacts that they share "
                                "would start it; only where a structure is its own image with "
                                "contacts exchanged do they, all that are exchanged at once%s",
                                first + 1, j->sign[i] * (i + 1), k + 1, m->frequency[k], a, b,
                                remedy(m, k, fabs(a - b), size));
        }
    }
    return RIC_OK;
}

/* ------------------------------------------------------------ what may be joined */

/* Of a pair, and of what goes with it: the modes in which its contacts move alike. */
typedef struct {
    const ric_model *m;
    double *size; /* [n_contact] |c| */
    bool *alike;  /* [n_dof] */
} search;

static double of(const search *s, int f, int mode)
{
    return s->m->normal[f * s->m->n_dof + mode];
}

/* Whether contacts f and g, one of them turned by sign, move as one in the modes that are alike. */
static bool as_one(const search *s, int f, int g, int sign)
{
    const double lost = ALIKE * (s->size[f] + s->size[g]);
    if (difference(&s->m->contact[f], &s->m->contact[g], sign)) return false;
    for (int k = 0; k < s->m->n_dof; k++)
        if (s->alike[k] && !(fabs(of(s, f, k) - sign * of(s, g, k)) <= lost)) return false;
    return true;
}

/* Whether the mean of a group sees modes that are alike, and no others. */
static bool sees_these(const search *s, const ric_joined *j, int group)
{
    double these = 0, others = 0;
    for (int k = 0; k < s->m->n_dof; k++) {
        double sum = 0;
        for (int f = 0; f < j->n_contact; f++)
            if (j->group[f] == group) sum += j->sign[f] * of(s, f, k);
        if (s->alike[k]) these += sum * sum;
        else others = fmax(others, fabs(sum));
    }
    return these > 0 && others <= RIC_UNSEEN * sqrt(these);
}

/* Whether contact f is its own image. */
static bool alone(const search *s, int f)
{
    for (int k = 0; k < s->m->n_dof; k++)
        if (!s->alike[k] && of(s, f, k) != 0) return false;
    return true;
}

/* All contacts, from the modes that are alike: false where some have no partner, or none has. */
static bool join_all(const search *s, ric_joined *j)
{
    const int n = s->m->n_contact;
    j->n_group = 0;
    memset(j->group, 0, (size_t)n * sizeof *j->group);
    for (int f = 0; f < n; f++) {
        int count = 1;
        if (j->group[f] || alone(s, f)) continue;
        j->group[f] = ++j->n_group;
        j->sign[f] = 1;
        for (int g = f + 1; g < n; g++)
            for (int sign = 1; sign >= -1 && !j->group[g]; sign -= 2) {
                if (!as_one(s, f, g, sign) || alone(s, g)) continue;
                j->group[g] = j->n_group;
                j->sign[g] = sign;
                count++;
            }
        if (count == 1 || !sees_these(s, j, j->n_group)) return false;
    }
    return j->n_group > 0;
}

/* From contacts f and g as the first pair. */
static bool begin(const search *s, int f, int g, int sign, ric_joined *j)
{
    bool both = false, apart = false;
    if (difference(&s->m->contact[f], &s->m->contact[g], sign)) return false;
    for (int k = 0; k < s->m->n_dof; k++) {
        const double a = of(s, f, k), b = sign * of(s, g, k),
                     lost = ALIKE * (s->size[f] + s->size[g]);
        s->alike[k] = fabs(a - b) <= lost;
        both |= s->alike[k] && fabs(a) > lost;
        apart |= !s->alike[k];
    }
    if (!both || !apart) return false;
    /* the pair that comes first of all that it joins: each is told once */
    for (int i = 0; i < f; i++)
        if (!alone(s, i)) return false;
    if (!join_all(s, j)) return false;
    for (int i = f + 1; i < g; i++)
        if (j->group[i] == j->group[f]) return false;
    return j->group[g] == j->group[f] && j->sign[g] == sign;
}

void ric_joined_write(const ric_joined *j, size_t size, char *out)
{
    size_t used = (size_t)snprintf(out, size, "[");
    for (int k = 1; k <= j->n_group; k++) {
        bool any = false;
        for (int i = 0; i < j->n_contact && used < size; i++) {
            if (j->group[i] != k) continue;
            used += (size_t)snprintf(out + used, size - used, "%s%d",
                                     any     ? ", "
                                     : k > 1 ? ", ["
                                             : "[",
                                     j->sign[i] * (i + 1));
            any = true;
        }
        if (any && used < size) used += (size_t)snprintf(out + used, size - used, "]");
    }
    if (used < size) snprintf(out + used, size - used, "]");
}

int ric_model_together(const ric_model *m, int last, size_t size, char *text, bool *mode)
{
    const int n = m->n_contact;
    double norms[n];
    ric_joined found;
    const search s = {.m = m, .size = norms, .alike = mode};
    int number = 0, at = 0;
    for (int f = 0; f < n; f++) {
        const double *c = &m->normal[f * m->n_dof];
        norms[f] = sqrt(ric_dot(m->n_dof, c, c));
    }
    if (m->members || ric_joined_create(n, &found)) return 0;
    for (int f = 0; f < n && !at; f++)
        for (int g = f + 1; g < n && !at; g++)
            for (int sign = 1; sign >= -1 && !at; sign -= 2)
                if (++number > last && begin(&s, f, g, sign, &found)) at = number;
    for (int k = 0; k < m->n_dof && at; k++) mode[k] = mode[k] && m->seen[k];
    if (at) ric_joined_write(&found, size, text);
    ric_joined_free(&found);
    return at;
}

/* ------------------------------------------------------------ what parts them */

void ric_joined_members_free(ric_members *members)
{
    if (!members) return;
    free(members->mode);
    free(members->first);
    free(members->omega);
    free(members->c);
    free(members->cc);
    free(members->disturbs);
    free(members);
}

static ric_status allocate_members(int n, int n_contact, int n_member, ric_members **out)
{
    const size_t most = (size_t)n + 1;
    ric_members *m = *out = ric_calloc(1, sizeof *m);
    if (!m) return ric_no_memory("contacts that close together");
    m->mode = ric_calloc(most, sizeof *m->mode);
    m->first = ric_calloc((size_t)n_contact + 1, sizeof *m->first);
    m->omega = ric_calloc(most, sizeof *m->omega);
    m->c = ric_calloc(most * (size_t)n_member, sizeof *m->c);
    m->cc = ric_calloc((size_t)n_member, sizeof *m->cc);
    m->disturbs = ric_calloc((size_t)n_contact + 1, sizeof *m->disturbs);
    return m->mode && m->first && m->omega && m->c && m->cc && m->disturbs
               ? RIC_OK
               : ric_no_memory("contacts that close together");
}

/* The contacts in the order of those that stand for them, parts [n_contact * n_mode] of their
 * normals in all modes. */
static void list_members(const ric_joined *j, const ric_model *model, int n_mode,
                         const ric_contact *contacts, ric_members *m, double *parts)
{
    const double unit = sqrt(ric_dot(model->n_dof, model->normal, model->normal)); /* model.c */
    int contact = 0;
    for (int f = 0; f < j->n_contact; f++) {
        bool before = false;
        for (int g = 0; g < f; g++) before |= j->group[f] && j->group[g] == j->group[f];
        if (before) continue;
        m->first[contact] = m->n_member;
        for (int g = f; g < j->n_contact; g++) {
            if (g != f && (!j->group[f] || j->group[g] != j->group[f])) continue;
            double *own = parts + m->n_member++ * n_mode;
            for (int i = 0; i < n_mode; i++)
                own[i] = (j->sign[g] < 0 ? -1 : 1) / unit * part(model, i, contacts[g].normal);
        }
        m->first[++contact] = m->n_member;
    }
}

/* The modes in which some of them part. */
static void list_modes(const ric_model *model, int n_mode, const double *parts, ric_members *m)
{
    for (int i = 0; i < n_mode; i++) {
        bool any = false;
        for (int a = 0; a < m->n_member; a++)
            any |= fabs(parts[a * n_mode + i]) > ALIKE * sqrt(m->cc[a]);
        if (model->seen[i] || !any) continue;
        m->omega[m->n] = model->frequency[i] / model->omega_ref;
        m->mode[m->n++] = i;
    }
    for (int a = 0; a < m->n_member; a++)
        for (int k = 0; k < m->n; k++) m->c[a * m->n + k] = parts[a * n_mode + m->mode[k]];
}

ric_status ric_joined_attach(const ric_joined *j, int n_mode, const ric_contact *contacts,
                             ric_model *model)
{
    ric_members *m;
    ric_status status = allocate_members(n_mode, model->n_contact, j->n_contact, &m);
    double *parts = ric_calloc((size_t)j->n_contact * (size_t)n_mode, sizeof *parts);
    ric_joined_members_free(model->members);
    model->members = m;
    if (!status && !parts) status = ric_no_memory("contacts that close together");
    if (!status) {
        list_members(j, model, n_mode, contacts, m, parts);
        for (int a = 0; a < m->n_member; a++)
            m->cc[a] = ric_dot(n_mode, parts + a * n_mode, parts + a * n_mode);
        for (int f = 0; f < model->n_contact; f++)
            for (int a = m->first[f]; a < m->first[f + 1]; a++)
                for (int b = m->first[f]; b < a; b++)
                    m->disturbs[f] |= fabs(
                                          ric_dot(n_mode, parts + a * n_mode, parts + b * n_mode)) >
                                      ALIKE * sqrt(m->cc[a] * m->cc[b]);
        list_modes(model, n_mode, parts, m);
    }
    free(parts);
    return status;
}

bool ric_joined_parts(const ric_model *m, int mode)
{
    for (int k = 0; m->members && k < m->members->n; k++)
        if (m->members->mode[k] == mode) return true;
    return false;
}

ric_status ric_model_parted(const ric_model *m, bool *out)
{
    for (int i = 0; i < m->n_dof; i++) out[i] = ric_joined_parts(m, i);
    return RIC_OK;
}

/* ------------------------------------------------------------ what does not belong */

/* y [n_dof] by its parts in the modes, a force or a momentum. */
static ric_status check_parts(const ric_model *m, const double *y, const char *what)
{
    double size = 0, parts[m->n_dof];
    for (int i = 0; i < m->n_dof; i++) {
        parts[i] = part(m, i, y);
        size = fmax(size, fabs(parts[i]));
    }
    for (int i = 0; i < m->n_dof; i++)
        if (ric_joined_parts(m, i) && fabs(parts[i]) > ALIKE * size)
            return ric_fail(RIC_E_INPUT,
                            "%s mode %d of %.6g rad/s, in which contacts that close together by "
                            "`together` would part; leave that out, or `together` in the study",
                            what, i + 1, m->frequency[i]);
    return RIC_OK;
}

ric_status ric_model_check_state(const ric_model *m, const double *x, const double *v)
{
    double momentum[m->n_dof];
    ric_status status = RIC_OK;
    for (int which = 0; which < 2 && m->members && !status; which++) {
        for (int i = 0; i < m->n_dof; i++)
            momentum[i] = ric_dot(m->n_dof, m->M + i * m->n_dof, which ? v : x);
        status = check_parts(m, momentum,
                             which ? "the velocity has a part in"
                                   : "the displacement has a part in");
    }
    return status;
}

/* Whether damping takes a motion of seen modes to others. */
static ric_status check_damping(const ric_model *m, const double *C)
{
    double drag[m->n_dof];
    ric_status status = RIC_OK;
    for (int i = 0; i < m->n_dof && !status; i++) {
        if (!m->seen[i]) continue;
        memset(drag, 0, sizeof drag);
        for (int k = 0; k < m->n_dof; k++)
            for (int l = 0; l < m->n_dof; l++)
                drag[k] += C[k * m->n_dof + l] * m->Phi[l * m->n_dof + i];
        status = check_parts(m, drag, "the damping matrix couples modes that are seen with");
    }
    return status;
}

ric_status ric_joined_check_shaking(const ric_model *m, const ric_shaking *s)
{
    if (!m->members) return RIC_OK;
    const ric_status status = s->n_force ? check_parts(m, s->force, "the force pushes") : RIC_OK;
    return !status && s->n_matrix ? check_damping(m, s->matrix) : status;
}
