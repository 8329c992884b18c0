/* What the orbit is where the bordered determinant of a branch vanishes (docs/theory.md sections 7
 * and 8). */
#ifndef RIC_BRANCH_SYMMETRIC_END_H
#define RIC_BRANCH_SYMMETRIC_END_H

#include "continuation.h"

/* An orbit of a branch, and neighbours [n_unknown] on either side. */
typedef struct {
    const double *at, *beside, *beyond;
} ric_crossed;

/* Whether an operation of the symmetry group of the structure keeps the orbit and turns the branch
 * round. Then the branch ends there: beyond is its own mirror image. Where one all but does, *aside
 * is how far towards `beside` the middle between the orbit and its image lies; else 0. */
bool ric_symmetric_end_meets(const ric_continuation *trace, const ric_crossed *place,
                             double *aside);
/* Whether x -> -x does so, a symmetry that the structure lacks but not the contacts that the orbit
 * meets. Beyond are the mirror images, other motions, and the branch goes on. *aside as above. */
bool ric_symmetric_end_passes(const ric_continuation *trace, const ric_crossed *place,
                              double *aside);
/* How often the orbit goes through one of fewer impacts. */
int ric_symmetric_end_repeats(const ric_continuation *trace, const double *at);

/* Whether the word of a chain is that of orbits with a symmetry that its form does not have, or of
 * fewer impacts. */
bool ric_symmetric_end_may_gain(const ric_shooting *chain);
/* Whether the orbit at u, where the chain has been evaluated, is one of them. A branch meets such
 * orbits in points, at its ends and where it passes a junction: a step that ends at one has gone
 * over to the branch that they form. */
bool ric_symmetric_end_gains(const ric_shooting *chain, const double *u);

/* Moves u onto the curve from a point read off cubics at a branch point, where the kernel has more
 * dimensions than one. u stays where it was if rounding level is not reached close by. */
ric_status ric_symmetric_end_settle(ric_shooting *chain, double *u);

#endif
