/* Contacts that are images of one another. A permutation of the coordinates, some of them with the
 * other sign, that takes mass and stiffness to themselves takes each mode of a frequency of its own
 * to itself or to its opposite; where it takes the normal of one contact to that of another, or to
 * its opposite, both gaps change alike in such a mode. */
#ifndef RIC_PROVE_TWINS_H
#define RIC_PROVE_TWINS_H

#include "model/room.h"

/* Whether contact a is taken to contact b, of the same clearance, both stops: compared as the
 * decimals that the model holds. False also where too many permutations would have to be tried. */
bool ric_twins_are(const ric_model *m, int a, int b);

#endif
