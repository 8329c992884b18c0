/* Whether one atlas has all the branches of another. */
#include <math.h>
#include <string.h>

#include "atlas.h"
#include "base/room.h"

static bool close_to(double a, double b)
{
    return fabs(a - b) <= RIC_SAME_LOCATED * (fabs(a) + fabs(b));
}

/* Whether two branches of different runs are the same curve. */
static bool same_branch(const ric_branch *a, const ric_branch *b)
{
    return a->letters == b->letters && a->symmetric == b->symmetric && a->mode == b->mode &&
           !memcmp(a->word, b->word, (size_t)a->letters * sizeof *a->word) &&
           close_to(a->energy_min, b->energy_min) && close_to(a->energy_max, b->energy_max) &&
           close_to(a->frequency_min, b->frequency_min) &&
           close_to(a->frequency_max, b->frequency_max);
}

bool ric_atlas_contains(const ric_atlas *large, const ric_atlas *small)
{
    const int n = large->n_branch;
    for (int i = 0; i < small->n_branch; i++) {
        bool found = false;
        for (int k = 0; k < n && !found;
             k++) /* numbers shift a little, so that it is mostly near */
            found = same_branch(&small->branches[i].row, &large->branches[(i + k) % n].row);
        if (!found) return false;
    }
    return true;
}
