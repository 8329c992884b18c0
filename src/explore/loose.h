/* Where families of loose masses begin (docs/theory.md section 8). A seen mode of frequency zero
 * has no linear vibration; it goes to and fro between two faces that push it in opposite
 * directions. Such motions with a mirror point at, or where a spring is closed in the middle of,
 * both contacts are found without a guess: for given times they are linear in the state. */
#ifndef RIC_EXPLORE_LOOSE_H
#define RIC_EXPLORE_LOOSE_H

#include "orbit/room.h"
#include "branch/room.h"

/* Takes the orbit of a chain at its unknowns u, flown there, as one to start from. */
typedef ric_status (*ric_loose_take)(void *data, ric_shooting *chain, const double *u);

/* Follows the curves of orbits between each two faces of the model that pass some frequencies of a
 * window, and gives one orbit of every stretch of admissible ones. */
ric_status ric_loose_scan(const ric_model *model, const ric_limits *limits, ric_loose_take take,
                          void *data);

#endif
