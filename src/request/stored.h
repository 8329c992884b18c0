/* From the points that an atlas stores to the problems that they solve, and back. */
#ifndef RIC_REQUEST_STORED_H
#define RIC_REQUEST_STORED_H

#include "orbit/room.h"

/* Point i of a branch as a cycle without symmetries. */
ric_status ric_stored_cycle(const ric_atlas *atlas, const ric_branch *branch, int i,
                            ric_point *point, ric_periodic **out);
/* The symmetries that the branch has as a whole, with their places in the cycle of point i. At an
 * end others hold within rounding, too, and those of the branch are told by the point beside it. */
ric_status ric_stored_symmetries(const ric_atlas *atlas, const ric_branch *branch, int i,
                                 ric_periodic *cycle);
/* The problem that a cycle made of stored point i solves, and its unknowns, both allocated.
 * RIC_E_FORMAT where they leave it open: what is then computed from them belongs to no branch, and
 * may take any time. */
ric_status ric_stored_chain(const ric_model *model, const ric_branch *branch, int i,
                            const ric_periodic *cycle, ric_shooting **chain, double **u);
/* The multipliers [4] of a point of two modes, from the trace that is stored with it. False where
 * that does not say them: it is lost, or beyond a double, or on the border of stability, where only
 * the error of the orbit tells whether a digit of them is known; and for other numbers of modes. */
bool ric_stored_multipliers(const ric_model *model, const ric_point *point, double *out);

#endif
