#include "twins.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"

enum {
    TRIES = 100000, /* coordinates that are laid on others, in all */
    MOST = 8        /* permutations of one structure that are kept */
};

struct ric_twin_list {
    bool looked;
    int n;
    ric_twin of[MOST];
};

typedef struct {
    const ric_model *m;
    struct ric_twin_list *list; /* all of the structure, or NULL: one contact */
    int a, b, turned;           /* the normal of a becomes `turned` times that of b */
    int *to, *sign;             /* [n_dof] where a coordinate goes, 0 in `sign`: nowhere yet */
    bool *taken;                /* [n_dof] */
    int tries;
} search;

/* Whether coordinate i comes back from where it goes, as far as that is known. */
static bool undoes(const search *s, int i)
{
    const int j = s->to[i];
    if (j < i && (s->to[j] != i || s->sign[j] != s->sign[i])) return false;
    for (int k = 0; k < i; k++)
        if (s->to[k] == i && k != j) return false;
    return true;
}

/* Whether the normal of contact a becomes `turned` times that of b at coordinate i. */
static bool matches(const search *s, int a, int b, int turned, int i)
{
    const ric_model *m = s->m;
    const int n = m->n_dof;
    return s->sign[i] * m->b[a * n + i] == turned * m->b[b * n + s->to[i]];
}

/* Whether coordinate i may go where it does: what it has with those before it stays what it is. */
static bool fits(const search *s, int i)
{
    const ric_model *m = s->m;
    const int n = m->n_dof, j = s->to[i];
    if (s->taken[j]) return false;
    if (s->list ? !undoes(s, i) : !matches(s, s->a, s->b, s->turned, i)) return false;
    if (m->M[i * n + i] != m->M[j * n + j] || m->K[i * n + i] != m->K[j * n + j]) return false;
    for (int k = 0; k < i; k++) {
        const int both = s->sign[i] * s->sign[k], at = j * n + s->to[k];
        if (m->M[i * n + k] != both * m->M[at] || m->K[i * n + k] != both * m->K[at]) return false;
    }
    return true;
}

/* The face that a face goes to, or -1. */
static int find_face(const search *s, int face)
{
    const ric_model *m = s->m;
    const int a = m->face[face].contact;
    for (int f = 0; f < m->n_face; f++) {
        const int b = m->face[f].contact, turned = m->face[f].side * m->face[face].side;
        bool same = m->contact[a].clearance == m->contact[b].clearance;
        for (int i = 0; i < m->n_dof && same; i++) same = matches(s, a, b, turned, i);
        if (same) return f;
    }
    return -1;
}

/* Keeps the permutation if it takes all stops to stops, and is none of those left out; whether
 * there is room for no more. */
static bool keep(search *s)
{
    const int n = s->m->n_dof;
    ric_twin *twin = &s->list->of[s->list->n];
    bool good = false;
    for (int i = 0; i < n; i++) good = good || s->to[i] != i || s->sign[i] != s->sign[0];
    twin->to = good ? ric_calloc(2 * (size_t)n + (size_t)s->m->n_face, sizeof *twin->to) : NULL;
    if (!twin->to) return false;
    twin->sign = twin->to + n;
    twin->face = twin->sign + n;
    memcpy(twin->to, s->to, (size_t)n * sizeof *twin->to);
    memcpy(twin->sign, s->sign, (size_t)n * sizeof *twin->sign);
    for (int f = 0; f < s->m->n_face; f++) {
        twin->face[f] = find_face(s, f);
        good = good && twin->face[f] >= 0;
    }
    if (good) s->list->n++;
    else free(twin->to);
    return s->list->n == MOST;
}

static bool lay(search *s, int i)
{
    if (i == s->m->n_dof) return s->list ? keep(s) : true;
    for (int j = 0; j < s->m->n_dof; j++)
        for (int sign = 1; sign >= -1; sign -= 2) {
            if (++s->tries > TRIES) return false;
            s->to[i] = j;
            s->sign[i] = sign;
            if (!fits(s, i)) continue;
            s->taken[j] = true;
            if (lay(s, i + 1)) return true;
            s->taken[j] = false;
        }
    return false;
}

static bool open_search(search *s)
{
    const size_t n = (size_t)s->m->n_dof;
    s->to = ric_calloc(2 * n, sizeof *s->to);
    s->taken = ric_calloc(n, sizeof *s->taken);
    s->sign = s->to ? s->to + n : NULL;
    return s->to && s->taken;
}

static void close_search(search *s)
{
    free(s->to);
    free(s->taken);
}

bool ric_twins_are(const ric_model *m, int a, int b)
{
    const ric_contact *x = &m->contact[a], *y = &m->contact[b];
    if (x->stiffness > 0 || y->stiffness > 0 || x->clearance != y->clearance) return false;
    search s = {.m = m, .a = a, .b = b, .turned = 1};
    const bool opened = open_search(&s);
    bool found = opened && lay(&s, 0);
    s.turned = -1;
    found = found || (opened && lay(&s, 0));
    close_search(&s);
    return found;
}

struct ric_twin_list *ric_twins_create(void)
{
    return ric_calloc(1, sizeof(struct ric_twin_list));
}

void ric_twins_free(struct ric_twin_list *list)
{
    for (int i = 0; list && i < list->n; i++) free(list->of[i].to);
    free(list);
}

const ric_twin *ric_twins_get(struct ric_twin_list *list, const ric_model *m, int number)
{
    if (!list) return NULL;
    search s = {.m = m, .list = list};
    bool stops = !list->looked;
    for (int k = 0; k < m->n_contact; k++) stops = stops && m->contact[k].stiffness == 0;
    if (stops && open_search(&s)) lay(&s, 0);
    if (stops) close_search(&s);
    list->looked = true;
    return number < list->n ? &list->of[number] : NULL;
}
