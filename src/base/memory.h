/* Running out of memory is not an answer. The library allocates by these functions only, which
 * remember, per thread, when one failed. Functions may then give up in any way, "does not converge"
 * among them; whoever keeps results asks ric_memory_failed() before it does. */
#ifndef RIC_BASE_MEMORY_H
#define RIC_BASE_MEMORY_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void *ric_malloc(size_t size);
void *ric_calloc(size_t count, size_t size);
void *ric_realloc(void *old, size_t size);
char *ric_strdup(const char *text);
/* Asks the system for its large pages where the heap of this thread is going to grow, by that many
 * blocks: memory then comes by 2 MB at a time instead of 4 kB. No memory is taken. Nothing changes
 * where malloc maps blocks of that size, or gives what is freed back. Blocks are as large as the
 * GNU library lets them be on a heap (cli/common/main.c): of the large page in which one ends
 * something is touched already. */
#define RIC_SPREAD_BLOCK 31 /* MB */
#define RIC_SPREAD_THREAD 2 /* blocks on the heap of a thread, which has 64 MB there */
void ric_memory_spread(int blocks);
/* What a structure that others only read owns, for who fills or frees it. */
static inline void *ric_own(const void *owned)
{
    return (void *)(uintptr_t)owned;
}
/* Passes on what a function of LAPACKE returned. */
int ric_lapack(int info);

/* Whether this thread has run out of memory since it was last asked to forget. */
bool ric_memory_failed(void);
/* Says so of memory that a library wanted in vain. */
void ric_memory_lose(void);
void ric_memory_clear(void);

#endif
