/* A trace between two steps as bytes with which another run goes on. What follows has the same
 * bits as if it had never been broken off. */
#ifndef RIC_BRANCH_CONTINUATION_PAUSE_H
#define RIC_BRANCH_CONTINUATION_PAUSE_H

#include "continuation.h"

/* A trace between two steps, NULL: one that has not begun, and which attempt it is
 * (graph_trace.c). */
ric_status ric_continuation_pause(const ric_continuation *trace, int parts, void **blob,
                                  size_t *size);
/* *out = NULL for one that has not begun. RIC_E_FORMAT: these are no such bytes; then *parts is 0.
 */
ric_status ric_continuation_resume(const ric_model *model, const ric_limits *limits,
                                   const void *blob, size_t size, int *parts,
                                   ric_continuation **out);

#endif
