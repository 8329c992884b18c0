/* Arrivals of a branch without mirror points at an orbit of fewer periods, a period multiplication
 * (docs/theory.md section 8). */
#ifndef RIC_BRANCH_MULTIPLE_COVER_H
#define RIC_BRANCH_MULTIPLE_COVER_H

#include "continuation.h"

/* Whether the next step, of length *h, would come to an orbit that repeats itself r >= 3 times.
 * Close to it the angle in the plane of its kernel is held only by a pivot that falls like
 * distance^(r-2): what no step can follow is extrapolated. RIC_OK with *order = 0: no, but *h may
 * have become shorter; else *order = r and `out` is that orbit. */
ric_status ric_multiple_cover_ahead(ric_continuation *trace, double *h, int *order,
                                    ric_station *out);

#endif
