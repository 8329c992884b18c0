/* The orbit at a junction as it is stored: solved for from its canonical form, with rounded
 * unknowns, so that it does not remember where it came from. */
#ifndef RIC_JUNCTION_CANONICAL_H
#define RIC_JUNCTION_CANONICAL_H

#include "orbit/room.h"

/* Grain of the unknowns, in general. */
#define RIC_CANONICAL_GRAIN 0x1p-32

/* Moves the unknowns of a chain to where something holds, false where that is not; `rounded`: from
 * unknowns that have been, and to all digits. */
typedef bool ric_canonical_solver(const void *of, ric_shooting *chain, double *u, bool rounded);

typedef struct {
    ric_canonical_solver *solve;
    const void *of;
    double grain;
    int passes; /* at most */
} ric_canonical_way;

/* From an orbit nearby; in no canonical form itself, as its chain may start at another event. NULL:
 * it does not come there. */
ric_periodic *ric_canonical_solve(const ric_model *model, const ric_periodic *cycle,
                                  const ric_canonical_way *way);

#endif
