/* Events of a step: zeros of test functions, located to rounding (docs/theory.md section 7). */
#ifndef RIC_BRANCH_EVENT_H
#define RIC_BRANCH_EVENT_H

#include "continuation.h"

/* Whether a factor whose sign was lost in rounding comes out of it so late on this step that a zero
 * may lie before. The step is then shortened. */
bool ric_event_suspicious(const ric_continuation *trace, double h);

/* Keeps a station as an interior event; ends the branch at one where it meets an orbit of fewer
 * periods. */
ric_status ric_event_keep(ric_continuation *trace, int test, const ric_station *station);
ric_status ric_event_arrive(ric_continuation *trace, const ric_station *station);

/* Ends the branch at the border of a tongue that others step over. */
ric_status ric_event_border(ric_continuation *trace, const ric_station *station);

/* Finds every event between now and next. Interior ones are kept; one that ends the branch cuts the
 * step there, stores the last point and sets *done. *retry asks for a smaller step (a sign change
 * without a zero: the step has left the branch). */
ric_status ric_event_find(ric_continuation *trace, double h, bool *done, bool *retry);

#endif
