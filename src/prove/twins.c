#include "twins.h"

#include <stdlib.h>

#include "base/room.h"

enum { TRIES = 100000 }; /* coordinates that are laid on others, in all */

typedef struct {
    const ric_model *m;
    int a, b, turned; /* the normal of a becomes `turned` times that of b */
    int *to, *sign;   /* [n_dof] where a coordinate goes, 0 in `sign`: nowhere yet */
    bool *taken;      /* [n_dof] */
    int tries;
} search;

/* Whether coordinate i may go to j: what it has with those before it stays what it is. */
static bool fits(const search *s, int i, int j, int sign)
{
    const ric_model *m = s->m;
    const int n = m->n_dof;
    if (s->taken[j] || sign * m->b[s->a * n + i] != s->turned * m->b[s->b * n + j]) return false;
    if (m->M[i * n + i] != m->M[j * n + j] || m->K[i * n + i] != m->K[j * n + j]) return false;
    for (int k = 0; k < i; k++) {
        const int both = sign * s->sign[k], at = j * n + s->to[k];
        if (m->M[i * n + k] != both * m->M[at] || m->K[i * n + k] != both * m->K[at]) return false;
    }
    return true;
}

static bool lay(search *s, int i)
{
    if (i == s->m->n_dof) return true;
    for (int j = 0; j < s->m->n_dof; j++)
        for (int sign = 1; sign >= -1; sign -= 2) {
            if (++s->tries > TRIES) return false;
            if (!fits(s, i, j, sign)) continue;
            s->to[i] = j;
            s->sign[i] = sign;
            s->taken[j] = true;
            if (lay(s, i + 1)) return true;
            s->taken[j] = false;
        }
    return false;
}

bool ric_twins_are(const ric_model *m, int a, int b)
{
    const ric_contact *x = &m->contact[a], *y = &m->contact[b];
    if (x->stiffness > 0 || y->stiffness > 0 || x->clearance != y->clearance) return false;
    search s = {.m = m, .a = a, .b = b, .turned = 1};
    s.to = ric_calloc(2 * (size_t)m->n_dof, sizeof *s.to);
    s.taken = ric_calloc((size_t)m->n_dof, sizeof *s.taken);
    s.sign = s.to ? s.to + m->n_dof : NULL;
    bool found = s.to && s.taken && lay(&s, 0);
    s.turned = -1;
    found = found || (s.to && s.taken && lay(&s, 0));
    free(s.to);
    free(s.taken);
    return found;
}
