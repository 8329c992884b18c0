/* Admissibility: how far the gaps open in flight (docs/theory.md section 6). */
#ifndef RIC_ORBIT_REACH_H
#define RIC_ORBIT_REACH_H

#include "shooting.h"

typedef struct {
    double value; /* gap over clearance, 1 = touch */
    int flight;   /* of the chain */
    int face;
    double time; /* since the start of the flight */
    bool kink;   /* at an impact of another contact: no stationary point */
} ric_touch;

/* The largest value of s / gap over all faces at stationary points in flight (maxima towards the
 * face) and at impacts of other contacts; 0 if all are below 0. Nothing above the returned value is
 * missed: intervals are bisected until a bound decides. */
double ric_reach(const ric_shooting *chain, const double *u, ric_touch *where);

/* All such values of at least `threshold`, in order of time; returns their number (only the first
 * `capacity` are written). */
int ric_reach_all(const ric_shooting *chain, const double *u, double threshold, int capacity,
                  ric_touch *touches);

#endif
