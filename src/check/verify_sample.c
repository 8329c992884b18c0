/* Which points of a branch are replayed where not all are. */
#include <stdint.h>
#include <stdlib.h>

#include "ricochet.h"

enum { FIXED = 3, SPREAD = RIC_VERIFY_SAMPLE - FIXED };

static int compare(const void *a, const void *b)
{
    int x = *(const int *)a, y = *(const int *)b;
    return (x > y) - (x < y);
}

/* First, middle, last and SPREAD more, spread by a hash of the branch's number (Steele, Lea, Flood
 * 2014). */
static void choose(int branch, int n_point, int *chosen)
{
    uint64_t z = (uint64_t)branch;
    chosen[0] = 0;
    chosen[1] = n_point / 2;
    chosen[2] = n_point - 1;
    for (int i = 0; i < SPREAD; i++) {
        uint64_t mixed = z += 0x9e3779b97f4a7c15u;
        mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9u;
        mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebu;
        chosen[FIXED + i] = (int)((mixed ^ (mixed >> 31)) % (uint64_t)n_point);
    }
    qsort(chosen, RIC_VERIFY_SAMPLE, sizeof *chosen, compare);
}

ric_status ric_verify_sample(const ric_atlas *atlas, int branch, int *n, int *out)
{
    ric_branch b;
    ric_status status = ric_atlas_branch(atlas, branch, &b);
    *n = 0;
    if (status || b.n_point == 0) return status;
    choose(branch, b.n_point, out);
    for (int i = 0; i < RIC_VERIFY_SAMPLE; i++)
        if (i == 0 || out[i] != out[*n - 1]) out[(*n)++] = out[i];
    return RIC_OK;
}
