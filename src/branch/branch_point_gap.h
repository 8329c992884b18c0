/* Whether two branches cross at a point or only come near (docs/theory.md section 7). */
#ifndef RIC_BRANCH_BRANCH_POINT_GAP_H
#define RIC_BRANCH_BRANCH_POINT_GAP_H

#include "orbit/room.h"

/* What keeps two branches apart that seem to cross at u, a point near both: the residual, relative
 * to the size of the orbit, that is left where all other equations hold. Zero (rounding) where they
 * do cross, and for problems of hundreds of unknowns, which are not looked at. NAN: there is no
 * such point close by. */
double ric_branch_point_gap(ric_shooting *chain, const double *u);

#endif
