/* The suite has two forms: `make test` takes of the dear kinds of cases a sample or a smaller case,
 * and `make long`, which sets RICOCHET_TEST_LONG, all of them (CONTRIBUTING.md, Tests). What a test
 * takes beside its short form it names by long_form().
 *
 * Of many cases of a kind a test takes all; with RICOCHET_TEST_EVERY=n, for tools that make it slow
 * (tools/memcheck.sh), every n-th. What a test counts may then fall short. A number like 7, prime
 * to the small ones by which cases are told apart, keeps cases of all kinds. */
#ifndef SAMPLE_H
#define SAMPLE_H

#include <stdbool.h>
#include <stdlib.h>

static inline bool long_form(void)
{
    const char *given = getenv("RICOCHET_TEST_LONG");
    return given && *given && atoi(given) != 0;
}

/* Every how many cases one is taken, where the short form takes every `few`-th. */
static inline int every_of(int few)
{
    const char *given = getenv("RICOCHET_TEST_EVERY");
    int n = given ? atoi(given) : 1;
    return n > 1 ? n : long_form() ? 1 : few;
}

static inline int every(void)
{
    return every_of(1);
}

#endif
