/* How a branch sets out from a junction: its orbit problem, a point of it and a direction. */
#ifndef RIC_JUNCTION_OUTSET_H
#define RIC_JUNCTION_OUTSET_H

#include "branch/room.h"
#include "orbit/room.h"

/* chain NULL: no branch leaves that way. */
typedef struct {
    ric_shooting *chain;
    double *u, *t;   /* [n_unknown] the orbit at the junction, the direction */
    unsigned ignore; /* tests that are left out in the first step: their bits */
} ric_outset;

/* At an orbit, in no direction yet. What is there after an error is to be cleared, too. */
ric_status ric_outset_open(const ric_model *model, const ric_periodic *cycle, ric_outset *out);
void ric_outset_clear(ric_outset *out);
/* The trace that begins there; *from gives up what it has, also after an error. */
ric_status ric_outset_trace(ric_outset *from, const ric_limits *limits, ric_continuation **out);

#endif
