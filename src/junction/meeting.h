/* Where a branch comes to orbits that close two contacts at one instant for good (docs/theory.md
 * section 8). */
#ifndef RIC_JUNCTION_MEETING_H
#define RIC_JUNCTION_MEETING_H

#include "orbit/room.h"

/* The orbit at which the branch of `cycle`, which is near it, has no time left between two impacts
 * of different contacts, in its canonical form. NULL: it is not found there. */
ric_periodic *ric_meeting_solve(const ric_model *model, const ric_periodic *cycle);

/* Whether an orbit with no time between two impacts has neighbours with none: it lies on the curve
 * of those that close both contacts together, and not where the branch comes to that. */
bool ric_meeting_stays(const ric_model *model, const ric_periodic *cycle);

#endif
