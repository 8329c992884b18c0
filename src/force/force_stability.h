/* What the first order says of the stability of the forced orbit that inherits that of the atlas
 * (docs/forcing.md). */
#ifndef RIC_FORCE_FORCE_STABILITY_H
#define RIC_FORCE_FORCE_STABILITY_H

#include "force.h"

/* RIC_STABLE_UNDECIDED where the next order, relative to the motion, may decide: where it outweighs
 * what the losses make of a pair of multipliers, and where the flag changes within what it moves
 * the orbit along its branch. */
ric_status ric_force_stability(const ric_force *force, const ric_branch *branch,
                               const ric_orbit *orbit, double next_order, ric_stability *out);

#endif
