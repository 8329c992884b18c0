/* Corners that can be passed: two contacts with orthogonal normals close at one instant
 * (docs/theory.md section 8). */
#ifndef RIC_JUNCTION_CORNER_H
#define RIC_JUNCTION_CORNER_H

#include "orbit/room.h"

#define RIC_COINCIDENT 1e-7 /* two impacts closer than this in time are one instant */

enum { RIC_CORNER_UNDEFINED = -1, RIC_CORNER_TOGETHER = -2 };

/* Whether two events at one instant may change their order: their impacts do not disturb each
 * other, or both are switches of springs, at which no velocity changes. */
bool ric_corner_commute(const ric_model *model, const ric_face *f, const ric_face *g);

/* Pairs of impacts of different contacts at one instant: the place of the first of each, in order,
 * and their number. UNDEFINED: the normals of a pair are not orthogonal in the metric of M^-1, or
 * there are more than `capacity` pairs. TOGETHER: an impact slower than `speed` (a touch) is one of
 * a pair, or three meet: what goes on keeps them together. */
int ric_corner_pairs(const ric_model *model, const ric_periodic *cycle, double speed, int capacity,
                     int *pairs);

/* The same motion with the letters of every pair in `choice` (bit i: pair i) exchanged, its
 * symmetries found anew. NULL: no memory. */
ric_periodic *ric_corner_swap(const ric_model *model, const ric_periodic *cycle, int n_pair,
                              const int *pairs, unsigned choice, double tolerance);

/* Of all orders of the pairs the one with most symmetries, and of these the smallest canonical
 * word. NULL: no memory. */
ric_periodic *ric_corner_least(const ric_model *model, const ric_periodic *cycle, int n_pair,
                               const int *pairs, double tolerance);

/* Whether another order of the pairs is the same motion, run backwards or mirrored: then the orbit
 * belongs to a family on which they stay together. */
bool ric_corner_fixed(const ric_model *model, const ric_periodic *cycle, int n_pair,
                      const int *pairs, double tolerance);

#endif
