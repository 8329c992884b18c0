/* A plain loop on several threads, and a call beside what else is done. */
#ifndef RIC_BASE_TOGETHER_H
#define RIC_BASE_TOGETHER_H

#include "status.h"

/* Calls each(user, i) for all i below `count`, on n threads, which take them up in this order; the
 * status and the reason of one that failed. With one thread they come one after the other. */
ric_status ric_together(int n, int count, ric_status (*each)(void *user, int i), void *user);

/* One call on a thread of its own, or at once where there is none to be had. */
typedef struct ric_together_call ric_together_call;
/* NULL without memory. */
ric_together_call *ric_together_begin(ric_status (*call)(void *user), void *user);
/* Waits for it; its status, with the reason. It is gone then. NULL has nothing to say. */
ric_status ric_together_end(ric_together_call *call);

#endif
