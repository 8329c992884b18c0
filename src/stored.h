/* From the points that an atlas stores to the problems that they solve, and back. */
#ifndef RIC_STORED_H
#define RIC_STORED_H

#include "cycle.h"

/* The operation that takes the orbit of a chain to the start and direction in which its branch is stored. */
typedef struct { int shift; bool reverse, mirror; } ric_turn;

/* Point i of a branch as a cycle without symmetries. */
ric_status ric_stored_cycle(const ric_atlas *atlas, const ric_branch *branch, int i, ric_point *point, ric_cycle **out);
/* The symmetries that the branch has as a whole, with their places in the cycle; found at a stored point, which is
 * converged. */
void ric_stored_symmetries(const ric_model *model, const ric_branch *branch, ric_cycle *cycle);

bool ric_turn_find(const ric_model *model, ric_chain *chain, const double *u, const ric_cycle *like, ric_turn *out);
/* The orbit of the chain at u, turned. NULL: no memory. */
ric_cycle *ric_turn_cycle(const ric_model *model, ric_chain *chain, const double *u, const ric_turn *turn);
/* The same as it is stored: x and v [n_dof each] and the flights [N], in seconds; any of them NULL. */
ric_status ric_turn_write(const ric_model *model, ric_chain *chain, const double *u, const ric_turn *turn, double *x,
                          double *v, double *flights);

#endif
