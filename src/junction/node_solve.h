/* The orbit at a junction, located on its own defining equation from one nearby. */
#ifndef RIC_JUNCTION_NODE_SOLVE_H
#define RIC_JUNCTION_NODE_SOLVE_H

#include "criterion.h"

/* Re-solves `cycle` (with its symmetries) on its defining equation: canonical start, unknowns
 * rounded, solved again, so that nothing is left of where it came from. NULL where there is none
 * near; *moved (may be NULL): because it went elsewhere. */
ric_periodic *ric_node_solve(const ric_model *model, const ric_periodic *cycle, ric_criterion what,
                             bool *moved);
/* Without its touches an orbit is one of fewer events; what their speeds were beside zero is
 * missing from it, and it is solved once more. NULL: it does not converge. */
ric_periodic *ric_node_solve_again(const ric_model *model, const ric_periodic *cycle);
/* Whether an orbit touches the stop that it comes nearest to. */
bool ric_node_solve_touches(const ric_model *model, const ric_periodic *cycle);
/* Whether an orbit closes as far as one of a branch has to. */
bool ric_node_solve_solved(const ric_model *model, const ric_periodic *cycle);
/* Whether an orbit is a motion that closes. Newton's method knows the equations only: beyond the
 * end of a branch it solves them with flights of less than no time, or through a stop. What does
 * not become a chain is none. */
bool ric_node_solve_admissible(const ric_model *model, const ric_periodic *cycle);
/* Whether it is one, and touches. */
bool ric_node_solve_grazes(const ric_model *model, const ric_periodic *cycle);
/* Whether rounding leaves an extremum its place: dE/ds or dT/ds passes zero there fast enough. */
bool ric_node_solve_sharp(const ric_model *model, const ric_periodic *cycle, int test);

#endif
