/* Orbits of a stored branch between its points. */
#ifndef RIC_REQUEST_ORBIT_AT_H
#define RIC_REQUEST_ORBIT_AT_H

#include "orbit/room.h"

/* The orbit in the plane across the chord from the first to the last of three stored points, at the
 * part x of its length, solved to rounding: along x it is an analytic curve, also where the energy
 * or the period turns back. Not of linear modes. RIC_E_NUMERIC: Newton's method does not converge
 * there. */
ric_status ric_orbit_at_chord(const ric_atlas *atlas, const ric_branch *branch, const int points[3],
                              double x, ric_orbit **out);
void ric_orbit_at_free(ric_orbit *orbit);

#endif
