/* A zero of the equations of a word as a theorem, by a contraction of all unknowns: flight times,
 * state, and lambda in P_N w = (1 + lambda) w, which is 0 at a zero as P_N keeps |w|. */
#ifndef RIC_PROVE_CENSUS_ZERO_H
#define RIC_PROVE_CENSUS_ZERO_H

#include "census_box.h"

typedef struct {
    double t[RIC_CENSUS_IMPACTS], w[4]; /* centre */
    double unique; /* in the box that many times (1 / top, |w|) around the centre there is exactly
                      one zero, */
    double exists; /* and it is in that one */
} ric_census_zero;

/* By Newton's method from the middle of a box; false if none is found or it cannot be proved. */
bool ric_census_zero_find(const ric_census_pair *p, const ric_census_word *word,
                          const ric_census_box *from, ric_census_zero *out);
/* The box in which the zero is (unique: the only one). */
void ric_census_zero_box(const ric_census_pair *p, const ric_census_word *word,
                         const ric_census_zero *z, double radius, ric_census_box *out);

#endif
