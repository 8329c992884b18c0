/* Where the heap grows, the system is asked for its large pages. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <malloc.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/room.h"

enum { BEFORE = 1 << 20, AFTER = 1 << 22 }; /* the second does not fit where the first has been */

typedef struct {
    bool found, heap, asked; /* on the heap of the program; with large pages */
} pages;

/* What the system says of the memory at p. */
static pages pages_at(const void *p)
{
    pages out = {0};
    char line[4096];
    FILE *maps = fopen("/proc/self/smaps", "r");
    while (maps && fgets(line, sizeof line, maps)) {
        unsigned long from, to;
        if (sscanf(line, "%lx-%lx ", &from, &to) == 2) {
            out.found = from <= (uintptr_t)p && (uintptr_t)p < to;
            if (out.found) out.heap = strstr(line, "[heap]") != NULL;
        }
        if (!out.found || strncmp(line, "VmFlags:", 8)) continue;
        out.asked = strstr(line, " hg") != NULL;
        break;
    }
    if (maps) fclose(maps);
    return out;
}

static pages pages_of_block(size_t size)
{
    char *block = calloc(size, 1);
    const pages at = pages_at(block);
    free(block);
    return at;
}

static void *on_thread(void *out)
{
    ((pages *)out)[0] = pages_of_block(BEFORE);
    ric_memory_spread(2);
    ((pages *)out)[1] = pages_of_block(AFTER);
    return NULL;
}

static void heaps_have_large_pages(void **state)
{
    (void)state;
    if (access("/sys/kernel/mm/transparent_hugepage/enabled", R_OK)) {
        print_message("this system has no large pages\n");
        skip();
    }
    unsetenv("MALLOC_PERTURB_"); /* under which nothing is asked for */
#ifdef M_MMAP_THRESHOLD
    mallopt(M_MMAP_THRESHOLD, 1 << 25); /* as the program does (cli/common/main.c) */
    mallopt(M_TRIM_THRESHOLD, 1 << 28);
#endif
    const pages before = pages_of_block(BEFORE);
    if (!before.heap) {
        print_message("another allocator, of which nothing is promised\n");
        skip();
    }
    assert_false(before.asked);
    ric_memory_spread(2);
    assert_true(pages_of_block(AFTER).asked);
    pages other[2];
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, on_thread, other), 0);
    pthread_join(thread, NULL);
    assert_true(other[0].found && !other[0].asked);
    assert_true(other[1].found && other[1].asked);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(heaps_have_large_pages)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
