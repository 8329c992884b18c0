#include "stored.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"

ric_status ric_stored_cycle(const ric_atlas *a, const ric_branch *b, int i, ric_point *point, ric_periodic **out)
{
    const ric_model *m = ric_atlas_model(a);
    int n = m->n_dof, N = b->letters;
    double *state = ric_calloc(2 * (size_t)n, sizeof *state), *flights = ric_calloc((size_t)N + 1, sizeof *flights);
    ric_status status = state && flights ? ric_atlas_point(a, b->id, i, point, state, flights)
                                         : ric_no_memory("a stored orbit");
    *out = NULL;
    int marks = m->smooth ? 2 : N;
    if (!status && !(*out = ric_periodic_create(m->n, marks))) status = ric_no_memory("a stored orbit");
    if (!status && m->smooth) {
        (*out)->tau[0] = flights[0] * m->omega_ref;
        if (!ric_periodic_mark(*out, marks)) status = ric_no_memory("a stored orbit");
        ric_model_from_state(m, state, state + n, (*out)->w);
    } else if (!status) {
        ric_periodic_spell(m, *out, b->word);
        for (int k = 0; k < N; k++) (*out)->tau[k] = flights[k] * m->omega_ref;
        ric_model_from_state(m, state, state + n, (*out)->w);
    }
    free(state);
    free(flights);
    return status;
}

void ric_stored_symmetries(const ric_model *m, const ric_branch *b, ric_periodic *c)
{
    bool centre = strstr(b->mirror, "centre"), other = strstr(b->mirror, "rest") || strstr(b->mirror, "impact");
    if (m->smooth) { /* they start at the mirror point that the chain starts at */
        c->half = b->symmetric;
        c->flip = b->reversible && centre ? 0 : -1;
        c->pure = !b->reversible || !other ? -1 : centre;
        return;
    }
    ric_periodic_find_symmetries(m, c, 1e-8);
    if (!b->symmetric) c->half = false;
    if (!b->reversible || !other) c->pure = -1;
    if (!b->reversible || !centre) c->flip = -1;
}
