#include "curve.h"

#include <math.h>
#include <stdio.h>

#include "base/room.h"
#include "existence.h"
#include "monodromy.h"
#include "prover.h"

enum { DEEPEST = 14 }; /* halvings of a step: 2^-14 of one is where two branches meet, or a gap closes */

/* -------------------------------------------------------------------- nodes */

void ric_curve_node_init(ric_node *a)
{
    *a = (ric_node){.why = "it has no chain"};
    arb_init(a->exists);
}

void ric_curve_node_clear(ric_node *a)
{
    ric_chain_free(&a->c);
    arb_clear(a->exists);
}

void ric_curve_node_prove(ric_node *a, const ric_enclosure *e)
{
    ric_existence x;
    ric_existence_init(&x);
    a->why = ric_existence_prove(&x, &a->c, e);
    if (!a->why && !x.identified) a->why = "another orbit may lie as near: a junction";
    if (!a->why && !(x.moved <= RIC_PROVER_NEAR)) a->why = "the orbit that was proved lies elsewhere";
    arb_set(a->exists, x.exists);
    ric_existence_clear(&x);
}

/* The orbit near the middle of two; it is solved from there, so that it may be moved by more than a stored one. */
static void node_between(ric_node *m, const ric_node *a, const ric_node *b, const ric_enclosure *e)
{
    ric_existence x;
    ric_existence_init(&x);
    ric_chain_copy(&m->c, &a->c);
    for (slong i = 0; i < (slong)a->c.m * a->c.size; i++) {
        arb_add(m->c.u + i, a->c.u + i, b->c.u + i, e->prec);
        arb_mul_2exp_si(m->c.u + i, m->c.u + i, -1);
        arb_get_mid_arb(m->c.u + i, m->c.u + i);
    }
    m->why = ric_existence_prove(&x, &m->c, e);
    arb_set(m->exists, x.exists);
    ric_existence_clear(&x);
}

/* -------------------------------------------------------------------- tubes */

static double size_of(const ric_tube *t)
{
    arb_t x;
    arb_init(x);
    ric_chain_norm(t->k.n, t->chord, t->k.prec, x);
    const double size = arf_get_d(arb_midref(x), ARF_RND_NEAR);
    arb_clear(x);
    return size;
}

/* All of the arc are motions: gaps, and what multipliers say. */
static bool tube_stands(ric_curve *x, const ric_tube *t)
{
    ric_passage passage;
    ric_monodromy multipliers;
    ric_passage_init(&passage);
    ric_monodromy_init(&multipliers);
    const bool stands = ric_passage_prove(&passage, &t->hull, x->e, &(ric_family){t->hull.u, t->middle, t->half, NULL});
    snprintf(x->why, sizeof x->why, "%s", passage.why);
    if (stands) {
        ric_monodromy_enclose(&multipliers, &t->hull, x->e, t->hull.u);
        x->length[multipliers.stable] += size_of(t);
        x->approach = fmin(x->approach, arf_get_d(arb_midref(passage.approach), ARF_RND_FLOOR));
        x->tubes++;
    }
    ric_passage_clear(&passage);
    ric_monodromy_clear(&multipliers);
    return stands;
}

static bool join_by_one(ric_curve *x, const ric_node *a, const ric_node *b)
{
    ric_tube t;
    snprintf(x->why, sizeof x->why, "the arc between two orbits is not proved to be one");
    bool done = ric_tube_create(&t, &a->c, &b->c, x->e);
    if (done) {
        snprintf(x->why, sizeof x->why, "tubes are not proved to meet");
        done = ric_tube_holds(&t, &a->c, a->exists) && ric_tube_holds(&t, &b->c, b->exists) && tube_stands(x, &t);
    }
    ric_tube_free(&t);
    return done;
}

static bool join(ric_curve *x, const ric_node *a, const ric_node *b, int depth)
{
    if (join_by_one(x, a, b)) return true;
    if (depth == DEEPEST) return false;
    ric_node m;
    ric_curve_node_init(&m);
    node_between(&m, a, b, x->e);
    bool done = !m.why;
    if (m.why) snprintf(x->why, sizeof x->why, "between two orbits: %s", m.why);
    done = done && join(x, a, &m, depth + 1) && join(x, &m, b, depth + 1);
    ric_curve_node_clear(&m);
    return done;
}

bool ric_curve_join(ric_curve *x, const ric_node *a, const ric_node *b)
{
    return ric_chain_same_class(&a->c, &b->c) && join(x, a, b, 0);
}
