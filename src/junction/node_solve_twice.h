/* Branch points of smooth structures that double precision leaves too uncertain (docs/theory.md
 * section 10). */
#ifndef RIC_JUNCTION_NODE_SOLVE_TWICE_H
#define RIC_JUNCTION_NODE_SOLVE_TWICE_H

#include "orbit/room.h"

/* From u [n_unknown] along the branch of the chain, whose tangent there is t, to where the test of
 * a kind (RIC_TEST_A, _B or _D) vanishes; chains without mirror points over half a period have kind
 * A only. False, with u as it was: there is none close by, or no memory. Cost: a dozen flights,
 * each some hundred times as long as in double precision. */
bool ric_node_solve_twice(const ric_shooting *chain, int kind, const double *t, double *u);

#endif
