/* A stop that was asked for reaches what takes long, however deep. The thread that computes says
 * whom to ask; the kernels ask while they work. From the first yes on they return at once, with
 * anything: their callers see orbits that do not converge, and ric_fail() (status.h) turns that
 * into RIC_E_INTERRUPTED. Whoever keeps results, or takes a "no" for an answer, asks ric_halted()
 * before it does, as it asks for hunger (memory.h). */
#ifndef RIC_BASE_HALT_H
#define RIC_BASE_HALT_H

#include <stdbool.h>

/* Whom this thread asks from now on, NULL: nobody. What was answered before is forgotten. */
void ric_halt_ask(bool (*asked)(void *user), void *user);
/* Whether to return at once. `work`: how many multiplications lie ahead, about; so the question,
 * which may read a clock, is put every millisecond or so and costs nothing. */
bool ric_halt(double work);
/* Whether the answer has been yes. */
bool ric_halted(void);

#endif
