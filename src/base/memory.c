#include "memory.h"

#include <sys/mman.h>

#define WORK_MEMORY_ERROR (-1010) /* of LAPACKE; -1011 is that of its transposed copies */

/* SMALL: bytes up to which a block that this thread has just freed is had again at once, but by
 * malloc alone: calloc of the GNU library asks the heap */
#define SMALL 1024

static _Thread_local bool starved;

static void *given(void *memory, size_t size)
{
    if (!memory && size) starved = true;
    return memory;
}

void *ric_malloc(size_t size)
{
    return given(malloc(size), size);
}

/* Not inlined, or the compiler makes calloc of it again. */
static __attribute__((noinline)) void *small(size_t size)
{
    return malloc(size);
}

void *ric_calloc(size_t count, size_t size)
{
    if (count > SMALL || size > SMALL || count * size > SMALL || count * size == 0)
        return given(calloc(count, size), count * size);
    void *memory = small(count * size);
    return given(memory ? memset(memory, 0, count * size) : NULL, count * size);
}

void *ric_realloc(void *old, size_t size)
{
    return given(realloc(old, size), size);
}

char *ric_strdup(const char *text)
{
    return given(strdup(text), 1);
}

int ric_lapack(int info)
{
    if (info <= WORK_MEMORY_ERROR) starved = true;
    return info;
}

/* Blocks behind one another, which are free again when all of them have been named. Where the
 * library fills what it gives and takes, hundreds of megabytes would be written. */
void ric_memory_spread(int blocks)
{
#ifdef MADV_HUGEPAGE
    enum { BLOCK = RIC_SPREAD_BLOCK << 20, PAGE = 1 << 12 };
    char *block = blocks > 0 && !getenv("MALLOC_PERTURB_") ? malloc(BLOCK) : NULL;
    if (!block) return;
    madvise(block - (uintptr_t)block % PAGE, BLOCK + PAGE, MADV_HUGEPAGE);
    ric_memory_spread(blocks - 1);
    free(block);
#else
    (void)blocks;
#endif
}

bool ric_memory_failed(void)
{
    return starved;
}

void ric_memory_lose(void)
{
    starved = true;
}

void ric_memory_clear(void)
{
    starved = false;
}
