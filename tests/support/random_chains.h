/* Random structures of a few modes with stops and springs, and chains of flights on them. */
#ifndef RIC_TESTS_RANDOM_CHAINS_H
#define RIC_TESTS_RANDOM_CHAINS_H

#include "prove/chain.h"
#include "random_models.h"

/* In [-1, 1). */
static inline double draw(void)
{
    return uniform(-1, 1);
}

/* A structure of n modes with a stop, a stop and a spring, or two springs. */
static inline ric_model *structure(int n, int springs)
{
    double M[16], K[16], normal[8];
    ric_contact contacts[2];
    ric_model *model = NULL;
    random_definite(n, n, 0.5, M);
    random_definite(n, n, 0.3, K);
    for (int f = 0; f < 2; f++) {
        for (int i = 0; i < n; i++) normal[f * n + i] = draw();
        contacts[f] = (ric_contact){.normal = normal + f * n, .clearance = uniform(0.5, 2)};
        if (f < springs) contacts[f].law = RIC_LAW_BILINEAR;
        if (f < springs) contacts[f].stiffness = uniform(0.5, 5);
    }
    assert_int_equal(ric_model_create(n, M, K, 2, contacts, 1, &model), RIC_OK);
    return model;
}

/* m flights from face to face, in phases as they come: no motion, but a chain of maps. The ends are
 * general, or mirror points of all kinds in turn with i. */
static inline void lay_chain(ric_chain *c, const ric_enclosure *e, int m, int i)
{
    static const ric_chain_end ends[][2] = {{RIC_CHAIN_GENERAL, RIC_CHAIN_GENERAL},
                                            {RIC_CHAIN_REST, RIC_CHAIN_IMPACT},
                                            {RIC_CHAIN_IMPACT, RIC_CHAIN_REST},
                                            {RIC_CHAIN_IMPACT, RIC_CHAIN_IMPACT},
                                            {RIC_CHAIN_CENTRE, RIC_CHAIN_REST}};
    const ric_chain_end start = ends[i % 5][0], end = ends[i % 5][1];
    uint64_t closed = 0;
    *c = (ric_chain){.start = start, .end = end, .sign = start ? 1 : draw() > 0 ? 1 : -1};
    ric_chain_allocate(c, e, m);
    for (int k = 0; k <= m; k++) {
        const bool flight = start &&
                            (k ? k == m && end != RIC_CHAIN_IMPACT : start != RIC_CHAIN_IMPACT);
        c->face[k] = flight ? -1 : (int)(uniform(0, 1) * e->n_face) % e->n_face;
        if (k == m) break;
        if (c->face[k] >= 0 && e->wall[c->face[k]].closes) closed ^= (uint64_t)1 << c->face[k];
        if (ric_phase_get(e, closed, &c->phase[k])) closed = 0, c->phase[k] = NULL;
    }
}

#endif
