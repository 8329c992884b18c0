/* Motion of the damped and shaken structure, for those who check and for `simulate`. */
#ifndef RIC_CHECK_SHAKEN_H
#define RIC_CHECK_SHAKEN_H

#include "simulator.h"

/* As of the public one, in extended precision: x, v [2n]. */
ric_status ric_shaken_start_long(ric_shaken *s, const ric_real *y, ric_real phase);
void ric_shaken_state_long(const ric_shaken *s, ric_real *time, ric_real *y);
/* Springs that are closed at the start are those whose face is passed, and that of `face` (-1:
 * none), which has just been met. */
void ric_shaken_close(ric_shaken *s, int face);
/* Which springs are closed, [n_face]: to ask, and to say. */
void ric_shaken_closed(const ric_shaken *s, bool *closed);
void ric_shaken_set(ric_shaken *s, const bool *closed);

#endif
