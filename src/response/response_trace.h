/* Curves of exact forced orbits along one parameter (docs/forcing.md), by pseudo-arclength in the
 * state, phase and time of the first flight and the parameter.
 *
 * Events are zeros of functions along the curve: the parameter's part of the tangent (fold), the
 * products over all multipliers of mu - 1 without a fold (branch point) and of mu + 1 (period
 * doubling), the product over all pairs of mu_i mu_j - 1 (Neimark and Sacker), and the least of all
 * speeds at events and of all gaps that stay open (grazing), at which the curve ends. */
#ifndef RIC_RESPONSE_RESPONSE_TRACE_H
#define RIC_RESPONSE_RESPONSE_TRACE_H

#include "force/room.h"

typedef struct {
    ric_force_along along;
    double scale, window[2]; /* of the parameter, units of the solver */
    double step;             /* longest, relative to 1 + the size of the unknowns */
    int points;              /* most of a curve */
} ric_response_trace_options;

/* One orbit of a curve: unknowns [N m], and the direction there on the first unknowns and the
 * parameter [m + 1]. */
typedef struct {
    double arclength;
    ric_force_drive drive;
    double *u, *tangent;
    double *multipliers; /* [4 n] */
    double largest, rounding, residual;
    ric_stability stable;
    double margin; /* least speed or gap; 0 grazes */
} ric_response_orbit;

typedef struct {
    ric_response_kind kind;
    ric_response_orbit at;
    int id; /* of the event in the whole response, given later */
} ric_response_trace_event;

typedef struct {
    ric_force_orbit *shape; /* word, and room for one orbit */
    int n_point, room_point, n_event, room_event;
    ric_response_orbit *points;
    ric_response_trace_event *events;
    ric_response_stop stop, other; /* at its end, and at its start */
    int from, to;                  /* ids of events at its ends, 0: none */
    ric_status status;
} ric_response_trace;

/* Takes the shape, which holds a solved orbit, and follows the curve from there in the direction [m
 * + 1], and the other way too if `both`. Never NULL but without memory. */
ric_response_trace *ric_response_trace_run(ric_force_orbit *shape,
                                           const ric_response_trace_options *options,
                                           const double *direction, bool both);
void ric_response_trace_free(ric_response_trace *trace);
/* Puts an orbit of a trace into an orbit of its shape. */
void ric_response_trace_put(const ric_response_orbit *from, ric_force_orbit *o);
/* Least of speeds at events and of 1 - (gap over clearance) inside flights, at most a half. */
ric_status ric_response_trace_margin(const ric_force_orbit *o, double *margin);

#endif
