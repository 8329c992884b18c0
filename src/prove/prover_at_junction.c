/* Points that are junctions themselves: docs/proofs.md states the theorem. */
#include "prover_at_junction.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "atlas/room.h"
#include "base/room.h"
#include "prover_junction.h"

/* The junction that a point is, or 0. */
static int junction_of(const ric_branch *b, int i, double arclength)
{
    const double near = 1e-9;
    if (i == 0) return b->from;
    if (i == b->n_point - 1) return b->to;
    for (int k = 0; k < b->n_junction; k++)
        if (fabs(b->junction_at[k] - arclength) <= near * (1 + arclength)) return b->junctions[k];
    return 0;
}

static void tell_chain(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, ric_proof *out)
{
    arb_t x;
    arb_init(x);
    ric_chain_energy(e, c->phase[0], u, x);
    arb_mul_2exp_si(x, x, 2 * e->time - e->mass);
    ric_arb_interval(x, out->energy);
    arb_zero(x);
    for (int k = 0; k < c->m; k++) arb_add(x, x, u + (slong)k * c->size + 2 * e->n, e->prec);
    arb_mul_ui(x, x, (ulong)ric_chain_copies(c), e->prec);
    arb_mul_2exp_si(x, x, -e->time);
    ric_arb_interval(x, out->period);
    out->symmetric = ric_chain_symmetric(c);
    out->reversible = !ric_chain_general(c);
    arb_clear(x);
}

/* The largest difference from the centre of a chain, over 1 + its size. */
static double differs(const ric_chain *c, arb_srcptr u)
{
    double worst = 0, size = 0;
    for (slong i = 0; i < (slong)c->m * c->size; i++) {
        worst = fmax(worst, fabs(ric_arb_middle(c->u + i) - ric_arb_middle(u + i)));
        size = fmax(size, fabs(ric_arb_middle(c->u + i)));
    }
    return worst / (1 + size);
}

/* The orbit of the junction told with the word and in the class of the branch. */
static ric_status compare(ric_walk *w, int i, ric_story *story, ric_proof *out)
{
    bool made;
    ric_chain c = {0};
    ric_status status = ric_walk_class(w);
    if (!status) status = ric_walk_chain(w, i, &c, &made);
    if (!status && made) {
        arb_ptr u = _arb_vec_init((slong)c.m * c.size + 1);
        const bool cut = ric_story_cut(story, &c, RIC_PROVER_NEAR, u);
        if (cut) out->distance = differs(&c, u);
        if (cut) tell_chain(&c, w->e, u, out);
        _arb_vec_clear(u, (slong)c.m * c.size + 1);
    }
    ric_chain_free(&c);
    return status;
}

static ric_status compare_at(ric_walk *w, int i, const ric_junction *row, const ric_augmented *x,
                             const ric_junction_proof *proof, ric_proof *out)
{
    ric_point stored;
    ric_story story;
    ric_status status = ric_walk_point(w, i, &stored);
    if (status) return status;
    ric_prover_junction_tell(x, &story);
    *out = (ric_proof){.branch = out->branch,
                       .point = i,
                       .state = RIC_PROOF_NONE,
                       .stable = RIC_STABLE_UNDECIDED};
    out->distance = HUGE_VAL;
    out->approach = out->trace[0] = out->trace[1] = NAN;
    out->bits = proof->bits;
    out->exists = proof->exists;
    out->unique = proof->unique;
    if (w->branch.letters > 0) status = compare(w, i, &story, out);
    else {
        out->distance = ric_story_distance(&story, 0, 0, NULL, w->state,
                                           w->state + 2 * w->e->n_dof);
        out->symmetric = out->reversible = true;
        for (int k = 0; k < 2; k++) out->energy[k] = proof->energy[k];
        for (int k = 0; k < 2; k++) out->period[k] = proof->period[k];
    }
    ric_story_free(&story);
    if (status) return status;
    if (!(out->distance <= RIC_PROVER_NEAR))
        snprintf(out->why, sizeof out->why, "the stored orbit is not that of the junction %s",
                 row->label);
    else if (ric_prover_agrees(&stored, out)) {
        out->state = RIC_PROOF_DONE;
        snprintf(out->why, sizeof out->why, "the junction %s itself", row->label);
    }
    return RIC_OK;
}

/* What is proved of the junction, by any branch or in the class of this one, against point i. */
static ric_status look_at(ric_prover *p, ric_walk *w, int i, const ric_junction *row, bool own,
                          ric_proof *out)
{
    ric_augmented x = {0};
    ric_junction_proof proof = {.state = RIC_PROOF_NONE};
    ric_status status = own ? ric_walk_class(w) : RIC_OK;
    w->slow = own ? RIC_PROVER_SLOW : 0;
    if (!own) status = ric_prover_junction_find(p, row, 0, &x, &proof);
    else if (!status && w->like.u) status = ric_prover_junction_end(w, row, i > 0, &x, &proof);
    if (!status && proof.state == RIC_PROOF_DONE) {
        ric_proof found = *out;
        status = compare_at(w, i, row, &x, &proof, &found);
        if (!status && found.state == RIC_PROOF_DONE) *out = found;
    }
    ric_augmented_free(&x);
    return status;
}

/* A corner has two orders; a grazing may lack mirrors in the class of another branch that this one
 * has. */
ric_status ric_prover_at_junction(ric_prover *p, const ric_branch *branch, int i, ric_proof *out)
{
    ric_walk w;
    ric_point stored;
    ric_junction row;
    ric_status status = ric_atlas_point(p->atlas, branch->id, i, &stored, NULL, NULL);
    const int junction = status ? 0 : junction_of(branch, i, stored.arclength);
    if (!junction || !p->at[0].good) return status;
    status = ric_walk_open(&w, p, branch->id, 0);
    if (!status) status = ric_atlas_junction(p->atlas, junction, &row);
    const bool corner = !status && row.kind == RIC_KIND_CORNER,
               grazes = !status && row.kind == RIC_KIND_GRAZING && branch->letters > 0;
    if (!status && !corner) status = look_at(p, &w, i, &row, false, out);
    if (!status && (corner || grazes) && out->state != RIC_PROOF_DONE)
        status = look_at(p, &w, i, &row, true, out);
    ric_walk_close(&w);
    return status;
}
