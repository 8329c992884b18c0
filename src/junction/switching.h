/* Leaving a junction: the orbit problem of a way out, a start and a direction (docs/theory.md
 * section 8). */
#ifndef RIC_JUNCTION_SWITCHING_H
#define RIC_JUNCTION_SWITCHING_H

#include "node.h"
#include "outset.h"

/* Prepares the departure. side = -1: the other way, of a branch that passes. RIC_OK with
 * out->chain = NULL: inadmissible; RIC_E_NUMERIC: refused, the reason in ric_detail(), and
 * out->chain is NULL, too. */
ric_status ric_switching_depart(const ric_model *model, const ric_node *node, unsigned choice,
                                int side, ric_outset *out);

#endif
