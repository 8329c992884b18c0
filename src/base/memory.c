#include "memory.h"

#define WORK_MEMORY_ERROR (-1010) /* of LAPACKE; -1011 is that of its transposed copies */

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

void *ric_calloc(size_t count, size_t size)
{
    return given(calloc(count, size), count * size);
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
