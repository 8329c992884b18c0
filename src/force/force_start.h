/* Where exact forced orbits start: beside orbits of the atlas, and at the steady answer of the
 * linear structure. */
#ifndef RIC_FORCE_FORCE_START_H
#define RIC_FORCE_FORCE_START_H

#include "force_motion.h"

/* The forced problem with the word of an orbit of the atlas, at Omega = harmonic * omega, and its
 * state, at the phase of the force there; not yet solved. Level 0 has the losses alone. The
 * restitution is that of the force. RIC_E_INPUT, RIC_E_NUMERIC: it cannot be. */
ric_status ric_force_start_from(ric_force_medium *medium, const ric_orbit *orbit, int harmonic,
                                double level, double phase, ric_force_orbit **out);
/* Solves it at its level. */
bool ric_force_start_settle(ric_force_orbit *o);
/* Without events, from rest: that of the linear structure is solved in one step. omega of the
 * solver. */
ric_status ric_force_start_linear(ric_force_medium *medium, double omega, double level,
                                  ric_force_orbit **out);

#endif
