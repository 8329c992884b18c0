#include "stored.h"

#include <stdlib.h>
#include <string.h>

#include "status.h"

static ric_status no_memory(void)
{
    return ric_fail(RIC_E_NOMEM, "no memory for a stored orbit");
}

bool ric_branch_linear(const ric_model *m, const ric_branch *b)
{
    return b->impacts == 0 && !(m->smooth && (b->mode == 0 || m->seen[b->mode - 1]));
}

ric_status ric_stored_cycle(const ric_atlas *a, const ric_branch *b, int i, ric_point *point, ric_cycle **out)
{
    const ric_model *m = ric_atlas_model(a);
    int n = m->n_dof, N = b->letters;
    double *state = calloc(2 * (size_t)n, sizeof *state), *flights = calloc((size_t)N + 1, sizeof *flights);
    ric_status status = state && flights ? ric_atlas_point(a, b->id, i, point, state, flights) : no_memory();
    *out = NULL;
    int marks = m->smooth ? 2 : N;
    if (!status && !(*out = ric_cycle_create(m->n, marks))) status = no_memory();
    if (!status && m->smooth) {
        (*out)->tau[0] = flights[0] * m->omega_ref;
        if (!ric_cycle_mark(*out, marks)) status = no_memory();
        ric_model_from_state(m, state, state + n, (*out)->w);
    } else if (!status) {
        ric_cycle_spell(m, *out, b->word);
        for (int k = 0; k < N; k++) (*out)->tau[k] = flights[k] * m->omega_ref;
        ric_model_from_state(m, state, state + n, (*out)->w);
    }
    free(state);
    free(flights);
    return status;
}

void ric_stored_symmetries(const ric_model *m, const ric_branch *b, ric_cycle *c)
{
    bool centre = strstr(b->mirror, "centre"), other = strstr(b->mirror, "rest") || strstr(b->mirror, "impact");
    if (m->smooth) { /* they start at the mirror point that the chain starts at */
        c->half = b->symmetric;
        c->flip = b->reversible && centre ? 0 : -1;
        c->pure = !b->reversible || !other ? -1 : centre;
        return;
    }
    ric_cycle_find_symmetries(m, c, 1e-8);
    if (!b->symmetric) c->half = false;
    if (!b->reversible || !other) c->pure = -1;
    if (!b->reversible || !centre) c->flip = -1;
}

bool ric_turn_find(const ric_model *m, ric_chain *c, const double *u, const ric_cycle *like, ric_turn *out)
{
    ric_chain_fly(c, u);
    ric_cycle *raw = ric_cycle_from_chain(c, u);
    bool found = raw && ric_cycle_match(m, like, raw, 1e-6, &out->shift, &out->reverse, &out->mirror);
    ric_cycle_free(raw);
    return found;
}

ric_cycle *ric_turn_cycle(const ric_model *m, ric_chain *c, const double *u, const ric_turn *t)
{
    ric_chain_fly(c, u);
    ric_cycle *raw = ric_cycle_from_chain(c, u),
              *turned = raw ? ric_cycle_transform(m, raw, t->shift, t->reverse, t->mirror) : NULL;
    ric_cycle_free(raw);
    return turned;
}

ric_status ric_turn_write(const ric_model *m, ric_chain *c, const double *u, const ric_turn *t, double *x, double *v,
                          double *flights)
{
    ric_cycle *cycle = ric_turn_cycle(m, c, u, t);
    if (!cycle) return no_memory();
    if (x && v) ric_model_to_state(m, cycle->w, x, v);
    if (flights && m->smooth) flights[0] = ric_cycle_period(cycle) / m->omega_ref;
    else for (int k = 0; flights && k < cycle->N; k++) flights[k] = cycle->tau[k] / m->omega_ref;
    ric_cycle_free(cycle);
    return RIC_OK;
}
