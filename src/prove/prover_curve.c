/* Branches as curves: docs/proofs.md states the theorem. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "atlas/room.h"
#include "base/room.h"
#include "curve.h"
#include "prover.h"

typedef struct {
    const ric_prover *p;
    const ric_enclosure *e;
    ric_branch branch;
    ric_chain like; /* the class of the branch: that of the point in its middle */
    double *state;  /* [2 n_dof + letters] scratch */
    ric_curve curve;
} walk;

static ric_status walk_open(walk *w, ric_prover *p, int id)
{
    *w = (walk){.p = p, .e = ric_prover_enclosure(p, 0)};
    w->curve = (ric_curve){.e = w->e, .approach = HUGE_VAL};
    ric_status status = ric_atlas_branch(p->atlas, id, &w->branch);
    if (status) return status;
    w->state = ric_calloc((size_t)(2 * w->e->n_dof + w->branch.letters), sizeof *w->state);
    return w->state ? RIC_OK : ric_no_memory("a proof");
}

static void walk_close(walk *w)
{
    ric_chain_free(&w->like);
    free(w->state);
}

/* What is stored of point i: energy and frequency have to be those of the orbit, as for a point alone. */
static ric_status read_point(walk *w, int i, ric_point *stored)
{
    return ric_atlas_point(w->p->atlas, w->branch.id, i, stored, w->state, w->state + 2 * w->e->n_dof);
}

static ric_status prove_node(walk *w, int i, ric_node *a)
{
    ric_point stored;
    const ric_status status = read_point(w, i, &stored);
    if (status) return status;
    if (ric_chain_like(&a->c, w->e, &w->branch, w->state, w->state + 2 * w->e->n_dof, &w->like))
        ric_curve_node_prove(a, w->e);
    return RIC_OK;
}

/* An end that is a junction: its orbit touches, or belongs to two curves. */
static bool is_junction(const walk *w, int i)
{
    if (i == 0) return w->branch.from > 0;
    return i == w->branch.n_point - 1 && (w->branch.to > 0 || w->branch.stop == RIC_STOP_CORNER);
}

/* One step; `joined` says whether both orbits are on the curve. */
static bool prove_step(walk *w, const ric_node *a, const ric_node *b, int i, ric_curve_proof *out)
{
    const char *why = a->why ? a->why : b->why;
    snprintf(w->curve.why, sizeof w->curve.why, "%s", why ? why : "another class of orbits");
    if (!why && ric_curve_join(&w->curve, a, b)) return true;
    snprintf(out->why, sizeof out->why, "between points %d and %d: %.150s", i, i + 1, w->curve.why);
    return false;
}

/* Steps to ends that are junctions are left to these. */
static ric_status prove_steps(walk *w, ric_curve_proof *out)
{
    const int n = w->branch.n_point;
    ric_node nodes[2];
    for (int i = 0; i < 2; i++) ric_curve_node_init(&nodes[i]);
    ric_status status = prove_node(w, 0, &nodes[0]);
    bool done = n > 1;
    for (int i = 0; i + 1 < n && !status && done; i++) {
        ric_node *a = &nodes[i % 2], *b = &nodes[(i + 1) % 2];
        ric_curve_node_clear(b);
        ric_curve_node_init(b);
        status = prove_node(w, i + 1, b);
        const bool end = is_junction(w, i) || is_junction(w, i + 1);
        const bool joined = !status && !end && prove_step(w, a, b, i, out);
        if (i == 0) out->from = joined;
        if (i == n - 2) out->to = joined;
        done = joined || end;
    }
    for (int i = 0; i < 2; i++) ric_curve_node_clear(&nodes[i]);
    if (!status) out->state = done ? RIC_PROOF_DONE : RIC_PROOF_NONE;
    return status;
}

static ric_status find_class(walk *w)
{
    ric_point stored;
    const ric_status status = read_point(w, w->branch.n_point / 2, &stored);
    if (!status) ric_chain_create(&w->like, w->e, &w->branch, w->state, w->state + 2 * w->e->n_dof);
    return status;
}

ric_status ric_prover_curve(ric_prover *p, int id, ric_curve_proof *out)
{
    walk w;
    ric_status status = walk_open(&w, p, id);
    *out = (ric_curve_proof){.branch = id, .state = RIC_PROOF_NONE};
    const char *left_out = status ? NULL : ric_prover_left_out(p, &w.branch);
    if (left_out) {
        out->state = RIC_PROOF_LEFT_OUT;
        snprintf(out->why, sizeof out->why, "%s", left_out);
    } else if (!status && !p->at[0].good) snprintf(out->why, sizeof out->why, "%s", w.e->why);
    else if (!status && !(status = find_class(&w)) && w.like.u) status = prove_steps(&w, out);
    const double *length = w.curve.length, all = length[0] + length[1] + length[2];
    out->tubes = w.curve.tubes;
    out->stable = all > 0 ? length[RIC_STABLE_YES] / all : 0;
    out->unstable = all > 0 ? length[RIC_STABLE_NO] / all : 0;
    out->approach = ldexp(w.curve.approach, w.e->time);
    walk_close(&w);
    return status;
}
