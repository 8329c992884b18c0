#include "symmetry.h"

#include <math.h>
#include <stdlib.h>

#include "continuation.h"

ric_problem ric_problem_breaking(const ric_cycle *c, int test)
{
    bool quarter = c->half && c->pure >= 0;
    ric_problem out = {.copies = 1, .pure = -1, .flip = -1};
    if (!quarter) return out;
    /* a quarter starts at a centre: kernels of type a keep it, of type d keep the other mirror, of type b only z(t+T/2)
     * = -z(t) */
    if (test == RIC_TEST_A) out.flip = c->flip;
    else if (test == RIC_TEST_D) out.pure = c->pure;
    else out.half = true;
    return out;
}

int ric_problem_order(const ric_cycle *c, int p, int q)
{
    return c->half && p % 2 ? 2 * q : q; /* exp(2 pi i p / (2 q)) */
}

bool ric_problem_passes(const ric_cycle *c, int p, int q)
{
    int order = ric_problem_order(c, p, q);
    return order % 2 && (order == 3 || c->pure >= 0 || c->flip >= 0);
}

double ric_problem_rho(bool half, int p, int q)
{
    return 2 * cos((half ? 1 : 2) * 3.14159265358979323846 * p / q);
}

/* An orbit of the map over r of its periods is symmetric about points of both kinds if r is odd, about two of one kind
 * if r is even (Lamb and Roberts, Physica D 112 (1998)). On an S orbit the two kinds are the mirror points of either
 * reversal, half a period of the map apart, and after an odd number of half periods z has changed its sign. */
int ric_problem_multiplying(const ric_cycle *c, int p, int q, ric_problem out[2])
{
    int N = c->N * q, order = ric_problem_order(c, p, q);
    bool reversible = c->pure >= 0 || c->flip >= 0;
    for (int i = 0; i < 2; i++) out[i] = (ric_problem){.copies = q, .half = c->half && order % 2, .pure = c->pure,
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

ric_cycle *ric_problem_cycle(const ric_cycle *c, const ric_problem *problem)
{
    ric_cycle *out = ric_cycle_repeat(c, problem->copies);
    if (!out) return NULL;
    out->half = problem->half;
    out->pure = problem->pure;
    out->flip = problem->flip;
    return out;
}

int ric_problem_singular(const ric_model *m, const ric_cycle *cycle, const ric_problem problems[2])
{
    double smallest[2] = {HUGE_VAL, HUGE_VAL};
    for (int i = 0; i < 2; i++) {
        ric_chain *chain = NULL;
        double *u = NULL;
        ric_cycle *repeated = ric_problem_cycle(cycle, &problems[i]);
        if (repeated && !ric_cycle_to_chain(m, repeated, &chain, &u)) {
            ric_chain_evaluate(chain, u);
            smallest[i] = chain->smallest;
        }
        ric_chain_free(chain);
        ric_cycle_free(repeated);
        free(u);
    }
    return smallest[1] < smallest[0];
}
