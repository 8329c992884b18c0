/* The work that a file keeps for later runs: traces that are finished or were broken off, and
 * labels. */
#ifndef RIC_EXPLORE_STORED_WORK_H
#define RIC_EXPLORE_STORED_WORK_H

#include "ricochet.h"
#include "atlas/room.h"

/* Keys of traces that were broken off: that of the trace with this ending. */
#define RIC_PAUSED " paused"
/* What begins so is the label of a junction. */
#define RIC_LABEL "label "

/* A trace that is kept: as nothing where nothing departs, as the reason where it could not be
 * traced. */
#define RIC_REFUSED "refused: "

/* Refuses a file with a row of stored work that a run of `study` could not take up, before the run
 * has written anything. Work of another version of the solver is not looked at: it is dropped. */
ric_status ric_stored_work_check(ric_store *store, const ric_study *study);

#endif
