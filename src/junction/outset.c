#include "outset.h"

#include <stdlib.h>

#include "base/room.h"

ric_status ric_outset_open(const ric_model *m, const ric_periodic *cycle, ric_outset *out)
{
    ric_status status = cycle ? ric_periodic_to_chain(m, cycle, &out->chain, &out->u)
                              : ric_no_memory("a departure");
    if (status) return status;
    out->t = ric_calloc((size_t)out->chain->n_unknown, sizeof *out->t);
    return out->t ? RIC_OK : ric_no_memory("a departure");
}

void ric_outset_clear(ric_outset *out)
{
    ric_shooting_free(out->chain);
    free(out->u);
    free(out->t);
    *out = (ric_outset){0};
}

ric_status ric_outset_trace(ric_outset *from, const ric_limits *limits, ric_continuation **out)
{
    const ric_status status = ric_continuation_create(from->chain, from->u, from->t, from->ignore,
                                                      limits, out);
    from->chain = NULL; /* it is the trace's */
    ric_outset_clear(from);
    return status;
}
