/* Leaps over tongues: a branch that meets an internal resonance with a mode that it hardly excites
 * goes on behind it (docs/theory.md section 12). */
#ifndef RIC_BRANCH_LEAP_H
#define RIC_BRANCH_LEAP_H

#include "continuation.h"

/* Whether the step of length h to trace->next leads into a tongue that may be stepped over:
 * *shorter is the length with which it ends at the border, from where the next step leaps. */
bool ric_leap_ahead(ric_continuation *trace, double h, double *shorter);
/* From a border to the other one. *over: the trace stands there, and the gap is noted; else it goes
 * into the tongue. */
ric_status ric_leap_try(ric_continuation *trace, bool *over);
/* Whether what lies between point i of a trace and the next one was stepped over. */
bool ric_leap_behind(const ric_continuation *trace, int i);
/* Ends a branch that comes out of a tongue, where the branch that leaps over it passes. */
ric_status ric_leap_leave(ric_continuation *trace, bool *done);

#endif
