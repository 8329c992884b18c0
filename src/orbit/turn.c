#include "turn.h"

#include <stdlib.h>

#include "base/room.h"

bool ric_turn_find(const ric_model *m, ric_shooting *c, const double *u, const ric_periodic *like,
                   ric_turn *out)
{
    ric_shooting_fly(c, u);
    ric_periodic *raw = ric_periodic_from_chain(c, u);
    bool found = raw && ric_periodic_match(m, like, raw, RIC_SAME_LOCATED, out);
    ric_periodic_free(raw);
    return found;
}

ric_periodic *ric_turn_cycle(const ric_model *m, ric_shooting *c, const double *u,
                             const ric_turn *t)
{
    ric_shooting_fly(c, u);
    ric_periodic *raw = ric_periodic_from_chain(c, u),
                 *turned = raw ? ric_periodic_transform(m, raw, t->shift, t->reverse, t->mirror)
                               : NULL;
    ric_periodic_free(raw);
    return turned;
}

ric_status ric_turn_write(const ric_model *m, ric_shooting *c, const double *u, const ric_turn *t,
                          double *x, double *v, double *flights)
{
    ric_periodic *cycle = ric_turn_cycle(m, c, u, t);
    if (!cycle) return ric_no_memory("an orbit");
    if (x && v) ric_model_to_state(m, cycle->w, x, v);
    if (flights) ric_periodic_flights(m, cycle, flights);
    ric_periodic_free(cycle);
    return RIC_OK;
}
