/* Leaving a junction: the orbit problem of a way out, a start and a direction (docs/theory.md
 * section 8). */
#ifndef RIC_JUNCTION_SWITCHING_H
#define RIC_JUNCTION_SWITCHING_H

#include "node.h"

/* Prepares the departure: chain, start u0 and direction t0 (both allocated), bits to ignore in the
 * first step. side = -1: the other way, of a branch that passes. RIC_OK with *chain = NULL:
 * inadmissible; RIC_E_NUMERIC: refused, the reason in ric_detail(). */
ric_status ric_switching_depart(const ric_model *model, const ric_node *node, unsigned choice,
                                int side, ric_shooting **chain, double **u0, double **t0,
                                unsigned *ignore);

#endif
