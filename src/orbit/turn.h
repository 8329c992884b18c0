/* From the orbit that a chain solves to the start and direction in which its branch is stored, and
 * back. */
#ifndef RIC_ORBIT_TURN_H
#define RIC_ORBIT_TURN_H

#include "periodic.h"

/* The operation that takes the orbit of a chain to the start and direction in which its branch is
 * stored. */
bool ric_turn_find(const ric_model *model, ric_shooting *chain, const double *u,
                   const ric_periodic *like, ric_turn *out);
/* The orbit of the chain at u, turned. NULL: no memory. */
ric_periodic *ric_turn_cycle(const ric_model *model, ric_shooting *chain, const double *u,
                             const ric_turn *turn);
/* The same as it is stored: x and v [n_dof each] and the flights [N], in seconds; any of them NULL.
 */
ric_status ric_turn_write(const ric_model *model, ric_shooting *chain, const double *u,
                          const ric_turn *turn, double *x, double *v, double *flights);

#endif
