/* Lanes of two numbers, in which one instruction does what shooting.c does in two.
 *
 * Flights and elimination of two modes with rigid contacts, the structure that most atlases are
 * made of: the columns of the Jacobian lie side by side, the rows of a column in lanes. Newton step
 * and kernel vector of any structure (ric_shooting_steps): one in each lane. Every number is made
 * by the same operations in the same order as in shooting.c, and has the same bits, on every
 * machine: no product is fused with a sum. */
#ifndef RIC_ORBIT_SHOOTING_LANES_H
#define RIC_ORBIT_SHOOTING_LANES_H

#include "shooting.h"

/* A chain that is `plain` is left to shooting.c, which is what the lanes are compared with. */
static inline bool ric_shooting_lanes_fit(const ric_shooting *c)
{
    return c->n == 2 && ric_flight_law_of(c->model)->turns && c->parts == 1 && !c->plain;
}

/* Both take the start state, and what it leaves of its condition, `gap`; `left` as in
 * ric_shooting_evaluate_left, or NULL; *largest grows to the largest gap that is left. The chain is
 * eliminated to its end, but of one that ends on an impact mirror, false, the rows X at the end of
 * its last flight are set, and *sign to that of the product of all pivots so far. */
void ric_shooting_lanes_general(ric_shooting *c, const double *u, const double *left, double gap,
                                double *largest);
bool ric_shooting_lanes_reversible(ric_shooting *c, const double *u, const double *left, double gap,
                                   double *largest, double *sign);

#endif
