/* Branch points where two branches of one symmetry cross: their directions (docs/theory.md section
 * 8). */
#ifndef RIC_JUNCTION_BRANCH_POINT_H
#define RIC_JUNCTION_BRANCH_POINT_H

#include "node.h"
#include "outset.h"

/* At the node, in the unit direction of the branch that `choice` stands for: THROUGH is the one
 * along which the energy changes faster, SIDE the other. RIC_E_NUMERIC: refused, the reason in
 * ric_detail(). */
ric_status ric_branch_point_depart(const ric_model *model, const ric_node *node, unsigned choice,
                                   ric_outset *out);

/* Which of the two an orbit near the node lies on. */
ric_status ric_branch_point_choice(const ric_model *model, const ric_node *node,
                                   const ric_periodic *near, unsigned *choice);

#endif
