/* Branches as curves: docs/proofs.md states the theorem. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "atlas/room.h"
#include "base/room.h"
#include "curve.h"
#include "prover.h"
#include "walk.h"

typedef struct {
    ric_walk w;
    ric_curve curve;
} tracing;

static ric_status prove_node(tracing *t, int i, ric_node *a)
{
    bool made;
    const ric_status status = ric_walk_chain(&t->w, i, &a->c, &made);
    if (made) ric_curve_node_prove(a, t->w.e);
    return status;
}

/* An end that is a junction: its orbit touches, or belongs to two curves. */
static bool is_junction(const ric_walk *w, int i)
{
    if (i == 0) return w->branch.from > 0;
    return i == w->branch.n_point - 1 && (w->branch.to > 0 || w->branch.stop == RIC_STOP_CORNER);
}

/* One step; `joined` says whether both orbits are on the curve. */
static bool prove_step(tracing *t, const ric_node *a, const ric_node *b, int i, ric_curve_proof *out)
{
    const char *why = a->why ? a->why : b->why;
    snprintf(t->curve.why, sizeof t->curve.why, "%s", why ? why : "another class of orbits");
    if (!why && ric_curve_join(&t->curve, a, b)) return true;
    snprintf(out->why, sizeof out->why, "between points %d and %d: %.150s", i, i + 1, t->curve.why);
    return false;
}

/* Steps to ends that are junctions are left to these. */
static ric_status prove_steps(tracing *t, ric_curve_proof *out)
{
    const int n = t->w.branch.n_point;
    ric_node nodes[2];
    for (int i = 0; i < 2; i++) ric_curve_node_init(&nodes[i]);
    ric_status status = prove_node(t, 0, &nodes[0]);
    bool done = n > 1;
    for (int i = 0; i + 1 < n && !status && done; i++) {
        ric_node *a = &nodes[i % 2], *b = &nodes[(i + 1) % 2];
        ric_curve_node_clear(b);
        ric_curve_node_init(b);
        status = prove_node(t, i + 1, b);
        const bool end = is_junction(&t->w, i) || is_junction(&t->w, i + 1);
        const bool joined = !status && !end && prove_step(t, a, b, i, out);
        if (i == 0) out->from = joined;
        if (i == n - 2) out->to = joined;
        done = joined || end;
    }
    for (int i = 0; i < 2; i++) ric_curve_node_clear(&nodes[i]);
    if (!status) out->state = done ? RIC_PROOF_DONE : RIC_PROOF_NONE;
    return status;
}

ric_status ric_prover_curve(ric_prover *p, int id, ric_curve_proof *out)
{
    tracing t = {.curve = {.approach = HUGE_VAL}};
    ric_status status = ric_walk_open(&t.w, p, id, 0);
    t.curve.e = t.w.e;
    *out = (ric_curve_proof){.branch = id, .state = RIC_PROOF_NONE};
    const char *left_out = status ? NULL : ric_prover_left_out(p, &t.w.branch);
    if (left_out) {
        out->state = RIC_PROOF_LEFT_OUT;
        snprintf(out->why, sizeof out->why, "%s", left_out);
    } else if (!status && !p->at[0].good) snprintf(out->why, sizeof out->why, "%s", t.w.e->why);
    else if (!status && !(status = ric_walk_class(&t.w)) && t.w.like.u) status = prove_steps(&t, out);
    const double *length = t.curve.length, all = length[0] + length[1] + length[2];
    out->tubes = t.curve.tubes;
    out->stable = all > 0 ? length[RIC_STABLE_YES] / all : 0;
    out->unstable = all > 0 ? length[RIC_STABLE_NO] / all : 0;
    out->approach = ldexp(t.curve.approach, t.w.e->time);
    ric_walk_close(&t.w);
    return status;
}
