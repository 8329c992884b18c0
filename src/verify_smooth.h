/* Replay of orbits under power-law springs (docs/theory.md section 11). */
#ifndef RIC_VERIFY_SMOOTH_H
#define RIC_VERIFY_SMOOTH_H

#include "ricochet.h"

/* claims: NULL, or what is stored with the orbit is computed anew as well. */
ric_status ric_verify_smooth(const ric_atlas *atlas, int branch, int point, ric_check *out, ric_claims *claims);

#endif
