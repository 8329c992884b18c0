/* Branch points where two branches of one symmetry cross: their directions (docs/theory.md section
 * 8). */
#ifndef RIC_JUNCTION_BRANCH_POINT_H
#define RIC_JUNCTION_BRANCH_POINT_H

#include "node.h"
#include "outset.h"

/* The place where two branches of one symmetry cross, from an orbit u [n_unknown] of the chain near
 * it, which is moved: beside it orbits are known to the root of rounding only, but the equation
 * that is left on the kernel has a stationary point there, which is regular. The chain is left
 * where it was flown last. False: it does not come there. */
bool ric_branch_point_place(ric_shooting *chain, double *u);

/* At the node, in the unit direction of the branch that `choice` stands for: THROUGH is the one
 * along which the energy changes faster, SIDE the other. RIC_E_NUMERIC: refused, the reason in
 * ric_detail(). */
ric_status ric_branch_point_depart(const ric_model *model, const ric_node *node, unsigned choice,
                                   ric_outset *out);

/* Which of the two an orbit near the node lies on. */
ric_status ric_branch_point_choice(const ric_model *model, const ric_node *node,
                                   const ric_periodic *near, unsigned *choice);

#endif
