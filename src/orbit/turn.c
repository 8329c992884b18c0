#include "turn.h"

#include <stdlib.h>

#include "base/room.h"
#include "shooting_parts.h"

bool ric_turn_find(const ric_model *m, ric_shooting *c, const double *u, const ric_periodic *like,
                   ric_turn *out)
{
    ric_shooting_fly(c, u);
    ric_periodic *raw = ric_periodic_from_chain(c, u);
    bool found = raw && ric_periodic_match(m, like, raw, RIC_SAME_LOCATED, out);
    ric_periodic_free(raw);
    return found;
}

static ric_periodic *turned(const ric_model *m, const ric_shooting *c, const double *u,
                            const ric_turn *t)
{
    ric_periodic *raw = ric_periodic_from_chain(c, u),
                 *out = raw ? ric_periodic_transform(m, raw, t->shift, t->reverse, t->mirror)
                            : NULL;
    ric_periodic_free(raw);
    return out;
}

ric_periodic *ric_turn_cycle(const ric_model *m, ric_shooting *c, const double *u,
                             const ric_turn *t)
{
    ric_shooting_fly(c, u);
    return turned(m, c, u, t);
}

/* Whether the start of the chain tells where the stored orbit starts: without events, it starts
 * there, or at its image half a period on, or is looked for from there. */
static bool told_by_start(const ric_shooting *c, const ric_turn *t)
{
    return !ric_periodic_has_events(c->model) &&
           (t->shift == 0 || c->start == RIC_MIRROR_NONE || ric_shooting_halves(c));
}

ric_status ric_turn_write(const ric_model *m, ric_shooting *c, const double *u, const ric_turn *t,
                          double *x, double *v, double *flights)
{
    if (told_by_start(c, t)) ric_start_of(c, u, c->w);
    else ric_shooting_fly(c, u);
    ric_periodic *cycle = turned(m, c, u, t);
    if (!cycle) return ric_no_memory("an orbit");
    if (x && v) ric_model_to_state(m, cycle->w, x, v);
    if (flights) ric_periodic_flights(m, cycle, flights);
    ric_periodic_free(cycle);
    return RIC_OK;
}
