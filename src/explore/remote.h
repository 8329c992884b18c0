/* Hands on other machines: whoever runs the exploration of a study may lend it more than the
 * threads of this process (mpi/ does so). */
#ifndef RIC_EXPLORE_REMOTE_H
#define RIC_EXPLORE_REMOTE_H

#include "base/room.h"
#include "workers.h"

typedef struct ric_remote {
    /* Before the first departure is taken: from now on the crew may claim departures (workers.h),
     * and puts what it finds in the memo. */
    ric_status (*join)(void *user, const ric_study *study, ric_workers *workers, ric_cache *memo);
    /* Returns when none of its threads touches either any more. */
    void (*leave)(void *user);
    void *user;
} ric_remote;

/* What ric_explore can be given besides; any of them may be NULL. */
typedef struct {
    const ric_remote *crew;
    /* Whether an atlas that a stop has left unfinished is worth more than the tables of the file,
     * which it then replaces; NULL: it always is. The work is kept in either case. */
    bool (*worth)(void *user, const ric_atlas *unfinished);
    void *user;
} ric_explore_more;

/* ric_explore, and the atlas that was written, if `out` is not NULL: free *out, which is NULL after
 * a failure other than RIC_E_INTERRUPTED. */
ric_status ric_explore_with(const ric_study *study, const char *path, const ric_run_options *run,
                            const ric_explore_more *more, ric_atlas **out);

/* At the other end: what is needed to prepare departures of a study. */
typedef struct ric_explore_worker ric_explore_worker;
ric_status ric_explore_worker_create(const ric_study *study, ric_explore_worker **out);
void ric_explore_worker_free(ric_explore_worker *hand);
/* Takes over the node, and returns the memo with all that following the departure has found, to be
 * drained. */
ric_cache *ric_explore_worker_prepare(ric_explore_worker *hand, ric_node *node, unsigned choice);
const ric_model *ric_explore_worker_model(const ric_explore_worker *hand);

#endif
