/* The way out of a grazing that belongs to a family of linear motions, because modes share its
 * frequency (docs/theory.md section 8, equal frequencies). */
#ifndef RIC_JUNCTION_MIXTURE_WAY_H
#define RIC_JUNCTION_MIXTURE_WAY_H

#include "orbit/room.h"

/* At the orbit u of a chain, all of whose impacts have no speed, the Jacobian's kernel holds the
 * linear motions beside it that keep touching, along which the speeds stay zero, and at most the
 * directions in which they rise. t [n_unknown]: the one direction perpendicular to all linear
 * motions, of unit length; *count: of how many it is one, 0 if there is none in which all impacts
 * rise. Cost that of a dense singular value decomposition. */
ric_status ric_mixture_way(ric_shooting *chain, const double *u, double *t, int *count);

#endif
