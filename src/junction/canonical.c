#include "canonical.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* Unknowns [n], on their grains; n = 0: none. */
typedef struct {
    int n;
    double *u;
} grid;

/* Rounds the unknowns u [n]. True if they are those of the pass before: another one would find the
 * same bits. */
static bool settled(grid *last, int n, double grain, double *u)
{
    bool same = last->n == n;
    for (int i = 0; i < n; i++) u[i] = rint(u[i] / grain) * grain;
    for (int i = 0; same && i < n; i++) same = u[i] == last->u[i];
    free(last->u);
    last->u = ric_malloc((size_t)n * sizeof *u);
    last->n = last->u ? n : 0;
    if (last->u) memcpy(last->u, u, (size_t)n * sizeof *u);
    return same;
}

/* Where an unknown lies between two grains, one source of a junction rounds it up and another down,
 * and what is found differs in its last bits: it is rounded and solved again until it does not
 * change. */
ric_periodic *ric_canonical_solve(const ric_model *m, const ric_periodic *cycle,
                                  const ric_canonical_way *way)
{
    ric_periodic *source = ric_periodic_copy(cycle), *out = NULL;
    grid last = {0};
    for (int pass = 0; pass < way->passes && source; pass++) {
        ric_shooting *chain = NULL;
        double *u = NULL;
        const bool good = !ric_periodic_to_chain(m, source, &chain, &u);
        ric_periodic_free(source);
        source = NULL;
        if (!(good && pass && settled(&last, chain->n_unknown, way->grain, u))) {
            ric_periodic_free(out);
            out = good && way->solve(way->of, chain, u, pass > 0)
                      ? ric_periodic_from_chain(chain, u)
                      : NULL;
            if (out && pass + 1 < way->passes) source = ric_periodic_canonical(m, out);
        }
        ric_shooting_free(chain);
        free(u);
    }
    free(last.u);
    return out;
}
