/* Between the files that make a response: what they share, orbits and the rows that are kept of
 * them, and which orbits are known already. */
#ifndef RIC_RESPONSE_KEEP_H
#define RIC_RESPONSE_KEEP_H

#include "response.h"
#include "response_word.h"

#define RIC_RESPONSE_SAME 1e-6 /* relative: two orbits that were solved to rounding and located */

typedef struct {
    const ric_atlas *atlas;
    ric_force *force;
    ric_force_medium *medium;
    ric_response *r;
    ric_response_file *file;
    ric_response_trace_options trace;
    double level;   /* of the curves that are looked for, physical */
    bool own_image; /* the event that is left is an orbit that x -> -x maps to itself */
} ric_response_driver;

/* The orbit of a row, with the word of its curve; its states after other events are flown. NULL: it
 * cannot be. */
ric_force_orbit *ric_response_keep_orbit(ric_response_driver *d, const ric_response_line *line,
                                         const ric_response_row *row);
/* The word of an orbit [letters], to be freed; NULL without memory. And its impacts and contacts.
 */
int *ric_response_keep_word(const ric_force_orbit *o);
int ric_response_keep_impacts(const ric_force_orbit *o);
/* Whether a motion of several periods of the force repeats itself earlier: it is one of fewer,
 * traversed more than once, as the predictions beside duplicates lead to. */
bool ric_response_keep_repeats(const ric_force_orbit *o);
/* What varies along curves. */
double ric_response_keep_value(const ric_response_driver *d, const ric_response_point *p);
/* The curve that an orbit lies on already, 0: none. */
int ric_response_keep_known(ric_response_driver *d, ric_force_orbit *o);
/* Whether an orbit, of a curve that leaves events of this kind, is the one of such an event: there
 * it is known to the third root of rounding only. */
bool ric_response_keep_at_event(ric_response_driver *d, ric_force_orbit *o,
                                const ric_response_mark *e);
/* Follows the curve of a solved orbit, which it takes, and keeps it. direction: NULL both ways;
 * from: the event that it begins at, 0: none. */
ric_status ric_response_keep_follow(ric_response_driver *d, ric_force_orbit *o,
                                    const double *direction, int branch, int from);
/* Errors of a start, as a resonance, are no reason to stop; they are counted, and the first one is
 * kept. */
ric_status ric_response_keep_forgive(ric_response_driver *d, ric_status status);

/* Curves of all kinds that begin at an event (response_leave.c). */
ric_status ric_response_leave(ric_response_driver *d, int event);

#endif
