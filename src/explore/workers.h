/* Threads that prepare departures ahead of the owner of a graph: they follow each on a graph of its
 * own and leave what they found in a memo (cache.h). The owner takes the departures in its own
 * order and finds most of the work done; the atlas is the same for any number of them. */
#ifndef RIC_EXPLORE_WORKERS_H
#define RIC_EXPLORE_WORKERS_H

#include "junction/room.h"

typedef struct ric_workers ric_workers;

/* What is done with a departure; `node` is the callee's. Any thread. */
typedef void ric_prepare(void *user, ric_node *node, unsigned choice);

/* n threads; 0: the owner works itself. Beside threads it does not: what it found would keep it
 * from handing out the next departures, and the threads would wait. */
ric_status ric_workers_create(int n, ric_prepare *prepare, void *user, ric_workers **out);
/* Waits for what is in hand and drops the rest. */
void ric_workers_free(ric_workers *workers);

/* A copy of a node for all departures from it that are offered; who makes it gives it up when all
 * are. NULL without memory. */
typedef struct ric_workers_node ric_workers_node;
ric_workers_node *ric_workers_share(const ric_node *node);
void ric_workers_unshare(ric_workers_node *node);
/* Puts a departure at the end of the queue. Returns its number, 0 without memory. */
int ric_workers_offer(ric_workers *workers, ric_workers_node *node, unsigned choice);
/* The owner has no use for it any more, or does it on its own. */
void ric_workers_withdraw(ric_workers *workers, int job);
/* Returns true when the departure is prepared; threads take it before all others. Without threads
 * one that is untouched is withdrawn, and others are worked on while it is in hand elsewhere. False
 * when `stop` (may be NULL), asked now and then, says so. */
bool ric_workers_await(ric_workers *workers, int job, bool (*stop)(void *user), void *user);
/* For hands that are no threads of these workers: the number of a departure that waits, which is
 * now in hand, and its node, which is the caller's; 0 if none waits. Finished, it is done. */
int ric_workers_claim(ric_workers *workers, ric_node **node, unsigned *choice);
void ric_workers_finish(ric_workers *workers, int job);
/* Departures that wait for a worker. */
int ric_workers_waiting(ric_workers *workers);

#endif
