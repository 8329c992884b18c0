/* One step along a branch, from the present point to the next. */
#ifndef RIC_BRANCH_CONTINUATION_STEP_H
#define RIC_BRANCH_CONTINUATION_STEP_H

#include "continuation.h"

/* How a step went: the angle between its tangents; what its chord turns from both beyond that angle
 * and beyond what rounding moves its ends across the branch, which the branch turns to and fro
 * between them; the way of the corrector relative to the step; and the sign of the kernel vector at
 * its end. */
typedef struct {
    double angle, hidden, drift, orientation;
    int iterations;
} ric_course;

/* Solves for `next` at distance h, its place, its tangent. False: no convergence. */
bool ric_continuation_try(ric_continuation *trace, double h, ric_course *out);
/* Whether the step has kept to its branch, by what is seen of its course. The direction of the
 * first step may be a guess, off the tangent by more than any bend. */
bool ric_continuation_stays(const ric_continuation *trace, const ric_course *way);

#endif
