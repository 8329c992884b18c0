/* What is made of the numbers that a map gives: rho of every pair and its error, the stability, the
 * multipliers. `f` has room for them (floquet.h). */
#ifndef RIC_ORBIT_FLOQUET_JUDGE_H
#define RIC_ORBIT_FLOQUET_JUDGE_H

#include "floquet.h"
#include "floquet_pairs.h"

/* n = 2: everything from the products b c and a d (scaled by 2^(-2 exponent), `error` likewise),
 * without cancellation near rho = +-2. */
void ric_floquet_judge_plane(ric_floquet *f, bool quarter, double bc, double ad, double twist,
                             int exponent, double error);
/* n = 2 from the trace of the map over a period, or over half of one joined with x -> -x; trace and
 * error scaled by 2^(-exponent). */
void ric_floquet_judge_trace(ric_floquet *f, bool half, double trace, double twist, int exponent,
                             double error);
/* Of the rho of the chain's map, f->rho, and what is known of them. What is lost is NaN; the map's
 * own rho only if it may be on the unit circle. */
void ric_floquet_judge_pairs(ric_floquet *f, bool quarter, const ric_floquet_pairs *known);
/* Beyond the range of a double: some multiplier is astronomically large. */
void ric_floquet_judge_lost(ric_floquet *f);

#endif
