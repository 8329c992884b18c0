/* Curves that leave an event of another one: with other impacts at a grazing, along the second
 * direction at a branch point, of twice the period at a doubling (docs/forcing.md). */
#ifndef RIC_RESPONSE_RESPONSE_WORD_H
#define RIC_RESPONSE_RESPONSE_WORD_H

#include "response_trace.h"

enum {
    RIC_TOUCHES_MOST = 16
}; /* at one time of the period or another; a symmetric orbit has two in each */

/* What has no speed at a grazing: an event of the word, or a face that is touched in flight. */
typedef struct {
    bool event;
    int flight, face;
    double time; /* after the start of the flight */
} ric_response_touch;

/* *n of them, at most RIC_TOUCHES_MOST; -1: more. */
ric_status ric_response_word_touches(const ric_force_orbit *o, ric_response_touch *out, int *n);

/* An orbit whose word has those of the touches that `set` has bits for, as impacts, solved beside
 * the grazing in `o`, and the direction [m + 1] away from it; its m is that of o. NULL: there is
 * none, or it is no motion. */
ric_force_orbit *ric_response_word_change(const ric_force_orbit *o,
                                          const ric_response_trace_options *options, int n,
                                          const ric_response_touch *touches, unsigned set,
                                          double *direction);

/* The same orbit as one of `copies` times the period. NULL: no memory. */
ric_force_orbit *ric_response_word_repeat(const ric_force_orbit *o, int copies);

/* The same along the second direction at a branch point (copies 1) or a doubling (2); sign: which
 * side. */
ric_force_orbit *ric_response_word_aside(const ric_force_orbit *o,
                                         const ric_response_trace_options *options,
                                         const double *tangent, int copies, double sign,
                                         double *direction);

#endif
