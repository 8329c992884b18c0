/* Between event.c and the other files of events: places within a step from `now` to `next`, of
 * length h, by their distance x from `now`. */
#ifndef RIC_BRANCH_EVENT_PARTS_H
#define RIC_BRANCH_EVENT_PARTS_H

#include "event.h"

/* Factors of the map, which grows without bound where an impact loses its speed. */
#define EVENT_SINGULAR (1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D)
/* Functions that end a branch. */
#define EVENT_TERMINAL                                                                             \
    (1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH | 1u << RIC_TEST_FLIGHT |                      \
     1u << RIC_TEST_E_MAX | 1u << RIC_TEST_E_MIN | 1u << RIC_TEST_F_MAX | 1u << RIC_TEST_F_MIN)
/* Functions that vanish at an extremum. */
#define EVENT_EXTREMA (1u << RIC_TEST_SLOPE | 1u << RIC_TEST_PERIOD)
/* Whether a test is looked at on this step. */
bool ric_event_watched(const ric_continuation *trace, int test);

/* The unknowns [n_unknown] on the cubic through now and next. */
void ric_event_cubic(const ric_continuation *trace, double x, double h, double *u);
/* Solves at x, starting from the cubic, and looks `at` (ric_continuation_look); *good: it
 * converged. */
ric_status ric_event_solve(ric_continuation *trace, double x, double h, unsigned at,
                           ric_station *out, bool *good);
/* Keeps the multipliers of an orbit of this step, for the search of others. */
void ric_event_know(ric_continuation *trace, double x, const ric_station *station);
/* Value of a test function, or of what is watched beyond them: resonances, and what was asked for.
 */
double ric_event_value(const ric_continuation *trace, int test, const ric_station *station);
/* The zero of a test function that is fa at xa and fb, of the other sign, at xb; the station there
 * is left in trace->mid. *zero: it is a true one, no pole and no hop. */
ric_status ric_event_locate(ric_continuation *trace, int test, double xa, double fa, double xb,
                            double fb, double h, double *where, bool *zero);
/* Where springs close for no time, at *end, all gaps of a mode may close at once, and one of them a
 * little before: it opens again to nothing there, and is closed in between by less than the step
 * shows. It is looked for on every scale down to distance `least`; *test and *end become those of
 * it. */
ric_status ric_event_reach_beside(ric_continuation *trace, double least, double h, int *test,
                                  double *end);

/* A zero of a test at a distance; their order along the step, for qsort. */
typedef struct {
    int test;
    double x;
} ric_event_root;

int ric_event_by_place(const void *a, const void *b);

/* Values [ric_continuation_watched] at a point of the step. */
double *ric_event_samples_values(const ric_continuation *trace, int i);
/* Starts with the two ends of a step; keeps the last points of a step that has been accepted. */
void ric_event_samples_begin(ric_continuation *trace, double h);
void ric_event_samples_shift(ric_continuation *trace);
/* Drops the points beyond `end`, which becomes the last one. */
ric_status ric_event_samples_cut(ric_continuation *trace, double end, double h);
/* One more point; *good: it converged. */
ric_status ric_event_samples_insert(ric_continuation *trace, double x, double h, bool *good);
/* The same unless one is there; how often the tests `which`, and with `pairs` the resonances,
 * change their signs. */
ric_status ric_event_samples_add(ric_continuation *trace, double x, double h);
int ric_event_samples_changes(const ric_continuation *trace, unsigned which, bool pairs);
/* More points, until every zero of the tests `which`, and with `pairs` of the resonances, shows.
 * from, to: places where functions may have poles, or NAN. */
ric_status ric_event_samples_refine(ric_continuation *trace, unsigned which, bool pairs,
                                    double from, double to, double h);
/* More points where a function may vanish twice that does not seem to: some are at hand to tell how
 * a function bends, and may do so badly. With `pairs` also where two of several may pass +-2, or
 * one pass it and come back, which leaves the signs of the tests `which` as they were. `end`: a
 * zero that was located, which tells of what lies before it; or NULL. They are kept if they show a
 * zero: what finds nothing changes no bit of what comes after. */
ric_status ric_event_samples_probe(ric_continuation *trace, unsigned which, bool pairs,
                                   const ric_event_root *end, double h);
/* Tells that functions may vanish in this step where it is not seen. */
void ric_event_samples_unresolved(ric_continuation *trace);
/* More points at distances from `end` that fall from that of `other` to `least`. */
ric_status ric_event_samples_approach(ric_continuation *trace, double end, double other,
                                      double least, double h);
/* Between springs multipliers are smooth up to the ends of a branch, next to which nothing is
 * looked for: what is passed there all the same is told of. `station`: the end, or the start,
 * beside point i of the step, which goes on to an energy. */
void ric_event_samples_tell(ric_continuation *trace, const ric_station *station, int i,
                            double energy);

/* Where what was asked for is passed up to distance `to`, between the extrema of energy and period
 * among the *n roots known: so a value passed twice, on both sides of an extremum, is found twice.
 * Room for RIC_EVENT_STRETCHES * n_asked more roots. `solve`: at orbits that are solved; false: on
 * the cubic. */
enum { RIC_EVENT_STRETCHES = 3 }; /* of a step, between its extrema of energy and of period */
ric_status ric_event_asked_find(ric_continuation *trace, bool solve, double to, double h,
                                ric_event_root *roots, int *n, bool *retry);
/* The same in a step over a branch point, whose other events have been kept, the first of them
 * `first`. */
ric_status ric_event_asked_cross(ric_continuation *trace, int first, double to, double h);

/* A step over a zero of the bordered determinant, which is made short first, RIC_CROSSING of the
 * size of the orbit. Two branches meet there: at distance x the orbit is known across them only to
 * rounding / x, so nothing is solved close by; every inner event is read off cubics through four
 * points at good distance, and the junctions are solved on their own equations later (node_solve.c
 * of junction). *end_test: why the branch ends there, at *end: DET where it meets its own image,
 * FLIGHT at a corner, REACH where a gap closes there; -1 if it goes on. */
ric_status ric_event_cross(ric_continuation *trace, double h, int *end_test, double *end,
                           bool *retry);
/* A corner at *end at which the determinant vanishes without changing its sign, as where two other
 * curves cross, is read off in the same manner: *end_test is FLIGHT then. */
ric_status ric_event_cross_corner(ric_continuation *trace, double h, int *end_test, double *end);
/* Whether a gap closes at the branch point of such a step. */
ric_status ric_event_cross_touches(ric_continuation *trace, double h, bool *touches);
/* A step over a branch point: four points of it, and the cubics through them. free(u). */
typedef struct {
    double x[4], test[4][RIC_N_TEST];
    double *u;    /* [4 * n_unknown] */
    double *own;  /* [4 * 2 * n_pair], behind u */
    double image; /* where the branch ends at its own image, and a pair is 2; NAN */
} ric_event_bridge;

ric_status ric_event_bridge_build(ric_continuation *trace, double h, ric_event_bridge *out);
/* The same over a place that is known, at this part of the step. */
ric_status ric_event_bridge_build_at(ric_continuation *trace, double part, double h,
                                     ric_event_bridge *out);
/* A test function or a resonance at x. */
double ric_event_bridge_test(const ric_continuation *trace, const ric_event_bridge *bridge,
                             int test, double x);
/* Its zero between a and b, where its signs differ, or did but for the zero at `known` (NAN: none),
 * which is divided out; `sign` is that at a. */
double ric_event_bridge_root(const ric_continuation *trace, const ric_event_bridge *bridge,
                             int test, double a, double b, double sign, double known);
/* The point at x read off the cubics; nothing is solved. */
void ric_event_bridge_station(const ric_continuation *trace, const ric_event_bridge *bridge,
                              double x, double h, ric_station *out);

#endif
