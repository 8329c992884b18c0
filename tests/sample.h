/* Of many cases of a kind a test takes all; with RICOCHET_TEST_EVERY=n, for tools that make it slow
 * (tools/memcheck.sh), every n-th. What a test counts may then fall short. A number like 7, prime to the small ones by
 * which cases are told apart, keeps cases of all kinds. */
#ifndef SAMPLE_H
#define SAMPLE_H

#include <stdlib.h>

static inline int every(void)
{
    const char *given = getenv("RICOCHET_TEST_EVERY");
    int n = given ? atoi(given) : 1;
    return n > 1 ? n : 1;
}

#endif
