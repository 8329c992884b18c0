#include "symmetry.h"
#include "base/room.h"

#include <math.h>
#include <stdlib.h>

#include "continuation.h"

ric_symmetry ric_symmetry_breaking(const ric_periodic *c, int test)
{
    bool quarter = c->half && c->pure >= 0;
    ric_symmetry out = {.copies = 1, .pure = -1, .flip = -1};
    if (!quarter) return out;
    /* a quarter starts at a centre: kernels of type a keep it, of type d keep the other mirror, of
     * type b only z(t+T/2) = -z(t) */
    if (test == RIC_TEST_A) out.flip = c->flip;
    else if (test == RIC_TEST_D) out.pure = c->pure;
    else out.half = true;
    return out;
}

int ric_symmetry_order(const ric_periodic *c, int p, int q)
{
    return c->half && p % 2 ? 2 * q : q; /* exp(2 pi i p / (2 q)) */
}

bool ric_symmetry_passes(const ric_periodic *c, int p, int q)
{
    int order = ric_symmetry_order(c, p, q);
    return order % 2 && (order == 3 || c->pure >= 0 || c->flip >= 0);
}

double ric_symmetry_rho(bool half, int p, int q)
{
    return 2 * cos((half ? 1 : 2) * RIC_PI * p / q);
}

/* An orbit of the map over r of its periods is symmetric about points of both kinds if r is odd,
 * about two of one kind if r is even (Lamb and Roberts, Physica D 112 (1998)). On an S orbit the
 * two kinds are the mirror points of either reversal, half a period of the map apart, and after an
 * odd number of half periods z has changed its sign. */
int ric_symmetry_multiplying(const ric_periodic *c, int p, int q, ric_symmetry out[2])
{
    int N = c->N * q, order = ric_symmetry_order(c, p, q);
    bool reversible = c->pure >= 0 || c->flip >= 0;
    for (int i = 0; i < 2; i++)
        out[i] = (ric_symmetry){.copies = q,
                                .half = c->half && order % 2,
                                .pure = c->pure,
                                .flip = c->flip};
    if (!reversible || order % 2) return 1;
    if (c->half) {
        out[0].flip = -1;
        out[1].pure = -1;
    } else {
        if (c->pure >= 0) out[1].pure = (c->pure + c->N) % N;
        else out[1].flip = (c->flip + c->N) % N;
    }
    return 2;
}

ric_periodic *ric_symmetry_cycle(const ric_periodic *c, const ric_symmetry *problem)
{
    ric_periodic *out = ric_periodic_repeat(c, problem->copies);
    if (!out) return NULL;
    out->half = problem->half;
    out->pure = problem->pure;
    out->flip = problem->flip;
    return out;
}

int ric_symmetry_singular(const ric_model *m, const ric_periodic *cycle,
                          const ric_symmetry problems[2], bool *both)
{
    double smallest[2] = {HUGE_VAL, HUGE_VAL};
    for (int i = 0; i < 2; i++) {
        ric_shooting *chain = NULL;
        double *u = NULL;
        ric_periodic *repeated = ric_symmetry_cycle(cycle, &problems[i]);
        if (repeated && !ric_periodic_to_chain(m, repeated, &chain, &u)) {
            ric_shooting_evaluate(chain, u);
            smallest[i] = chain->smallest;
        }
        ric_shooting_free(chain);
        ric_periodic_free(repeated);
        free(u);
    }
    if (both) *both = fmax(smallest[0], smallest[1]) <= RIC_SAME_SOLVED;
    return smallest[1] < smallest[0];
}
