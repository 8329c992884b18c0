#include "turn.h"

#include <stdlib.h>

#include "base/room.h"

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
    if (!cycle) return ric_fail(RIC_E_NOMEM, "no memory for an orbit");
    if (x && v) ric_model_to_state(m, cycle->w, x, v);
    if (flights && m->smooth) flights[0] = ric_cycle_period(cycle) / m->omega_ref;
    else for (int k = 0; flights && k < cycle->N; k++) flights[k] = cycle->tau[k] / m->omega_ref;
    ric_cycle_free(cycle);
    return RIC_OK;
}
