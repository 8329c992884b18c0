/* Branches as curves: docs/proofs.md states the theorem. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "atlas/room.h"
#include "base/room.h"
#include "curve.h"
#include "leaving.h"
#include "prover.h"
#include "prover_junction.h"

/* Where a curve is held: at a stored point, or at a junction that it passes. */
typedef struct {
    int point, junction; /* -1; 0 */
    double at;           /* of a junction: arclength */
} station;

typedef struct {
    ric_walk w;
    ric_prover *p;
    ric_curve curve;
    station *stations;
    int n;
} tracing;

/* ----------------------------------------------------------------- stations */

/* An end that is a junction: its orbit touches, or belongs to two curves. */
static bool is_junction(const ric_walk *w, int i)
{
    if (i == 0) return w->branch.from > 0;
    return i == w->branch.n_point - 1 && (w->branch.to > 0 || w->branch.stop == RIC_STOP_CORNER);
}

/* A point that is stored at a junction is left to it. */
static bool is_at(const ric_walk *w, int i, double arclength)
{
    const double near = 1e-9;
    for (int k = 0; k < w->branch.n_junction && i > 0 && i < w->branch.n_point - 1; k++)
        if (fabs(w->branch.junction_at[k] - arclength) <= near * (1 + arclength)) return true;
    return false;
}

static ric_status list_stations(tracing *t)
{
    const ric_branch *b = &t->w.branch;
    ric_point point;
    int next = 0;
    t->stations = ric_calloc((size_t)(b->n_point + b->n_junction), sizeof *t->stations);
    if (!t->stations) return ric_no_memory("a proof");
    for (int i = 0; i < b->n_point; i++) {
        const ric_status status = ric_walk_point(&t->w, i, &point);
        if (status) return status;
        for (; i > 0 && next < b->n_junction && b->junction_at[next] <= point.arclength; next++)
            t->stations[t->n++] = (station){.point = -1, .junction = b->junctions[next], .at = b->junction_at[next]};
        if (!is_at(&t->w, i, point.arclength)) t->stations[t->n++] = (station){.point = i};
    }
    return RIC_OK;
}

/* ----------------------------------------------------------------- junctions */

/* The chain of point i, or a share of the way to the next one inside. */
static ric_status chain_near(tracing *t, int i, double length, ric_chain *c, bool *made)
{
    bool both = true;
    ric_chain next = {0};
    ric_status status = ric_walk_chain(&t->w, i, c, made);
    if (status || !*made || length == 0) return status;
    status = ric_walk_chain(&t->w, i ? i - 1 : 1, &next, &both);
    *made = both && ric_chain_same_class(c, &next);
    if (*made) ric_curve_move(c, &next, length, t->w.e);
    ric_chain_free(&next);
    return status;
}

/* A story cut near an end of the branch: the node. */
static ric_status cut_end(tracing *t, int i, ric_story *story, double length, ric_node *a)
{
    ric_chain c = {0};
    bool made;
    const double place = 1e-5 + 4 * length;
    const ric_status status = chain_near(t, i, length, &c, &made);
    arb_ptr u = made ? _arb_vec_init((slong)c.m * c.size + 1) : NULL;
    if (made && ric_story_cut(story, &c, place, u)) ric_curve_node_place(a, &c, u, length == 0, t->w.e);
    else a->why = "what was proved of the junction at its end has another class";
    if (made) _arb_vec_clear(u, (slong)c.m * c.size + 1);
    ric_chain_free(&c);
    return status;
}

/* Where mirrors are broken: the arc that leaves, up to its end. */
static ric_status place_leaving(tracing *t, int i, ric_augmented *x, ric_node *a)
{
    ric_leaving leaving;
    ric_story story;
    ric_status status = RIC_OK;
    if (ric_leaving_prove(&leaving, x)) {
        ric_story_tell_pair(&story, &x->c, x->ask.broken, leaving.x, leaving.y, t->w.e);
        status = cut_end(t, i, &story, arf_get_d(arb_midref(leaving.size), ARF_RND_NEAR), a);
        ric_story_free(&story);
        t->curve.tubes++;
        t->curve.approach = fmin(t->curve.approach, leaving.approach);
    } else a->why = "the arc that leaves the junction at its end is not proved";
    ric_leaving_free(&leaving);
    return status;
}

/* The orbit of a junction at an end, in the class of the branch: a grazing, or a little beyond a broken mirror. */
static ric_status place_end(tracing *t, int i, ric_node *a)
{
    ric_junction row;
    ric_augmented x = {0};
    ric_junction_proof proof = {.state = RIC_PROOF_NONE};
    ric_status status = ric_atlas_junction(t->p->atlas, i ? t->w.branch.to : t->w.branch.from, &row);
    a->why = "the junction at its end is not proved";
    if (!status && (row.kind == RIC_KIND_GRAZING || row.kind == RIC_KIND_BRANCH_POINT))
        status = ric_prover_junction_find(t->p, &row, 0, &x, &proof);
    if (!status && proof.state == RIC_PROOF_DONE && row.kind == RIC_KIND_GRAZING) {
        ric_story story;
        ric_prover_junction_tell(&x, &story);
        status = cut_end(t, i, &story, 0, a);
        ric_story_free(&story);
    } else if (!status && proof.state == RIC_PROOF_DONE) status = place_leaving(t, i, &x, a);
    ric_augmented_free(&x);
    return status;
}

/* A junction that the branch passes. */
static ric_status place_inside(tracing *t, const station *s, ric_node *a)
{
    ric_junction row;
    ric_augmented x = {0};
    ric_junction_proof proof = {.state = RIC_PROOF_NONE};
    ric_status status = ric_atlas_junction(t->p->atlas, s->junction, &row);
    if (!status && ric_prover_junction_asked(&row, &t->w.branch))
        status = ric_prover_junction_inside(&t->w, &row, s->at, &x, &proof);
    if (!status && proof.state == RIC_PROOF_DONE) {
        const slong count = (slong)x.c.m * x.c.size + 1;
        arb_ptr u = _arb_vec_init(count);
        _arb_vec_set(u, x.z, x.n_orbit);
        ric_curve_node_place(a, &x.c, u, false, t->w.e);
        _arb_vec_clear(u, count);
    }
    ric_augmented_free(&x);
    return status;
}

static ric_status place(tracing *t, const station *s, ric_node *a)
{
    bool made;
    if (s->point < 0) return place_inside(t, s, a);
    if (is_junction(&t->w, s->point)) return place_end(t, s->point, a);
    const ric_status status = ric_walk_chain(&t->w, s->point, &a->c, &made);
    if (made) ric_curve_node_prove(a, t->w.e);
    return status;
}

/* -------------------------------------------------------------------- steps */

/* Between two stations; false with the reason. */
static bool prove_step(tracing *t, const ric_node *a, const ric_node *b, const char *where, ric_curve_proof *out)
{
    const char *why = a->why ? a->why : b->why;
    snprintf(t->curve.why, sizeof t->curve.why, "%s", why ? why : "another class of orbits");
    if (!why && ric_curve_join(&t->curve, a, b)) return true;
    snprintf(out->why, sizeof out->why, "%s: %.130s", where, t->curve.why);
    return false;
}

static int name_station(const tracing *t, int k)
{
    while (t->stations[k].point < 0) k--;
    return t->stations[k].point;
}

/* Steps to ends that are junctions are left out where these are not proved, or no tube reaches them; so are junctions
 * inside. */
static ric_status prove_steps(tracing *t, ric_curve_proof *out)
{
    const int last = t->n - 1;
    char where[60];
    ric_node nodes[2];
    int from = 0; /* the station of the node that comes next */
    for (int i = 0; i < 2; i++) ric_curve_node_init(&nodes[i]);
    ric_status status = place(t, &t->stations[0], &nodes[0]);
    bool done = last > 0;
    int turn = 0;
    for (int k = 1; k <= last && !status && done; k++) {
        ric_node *a = &nodes[turn], *b = &nodes[1 - turn];
        ric_curve_node_clear(b);
        ric_curve_node_init(b);
        status = place(t, &t->stations[k], b);
        if (t->stations[k].point < 0 && b->why) continue;
        const bool end = (from == 0 && is_junction(&t->w, 0)) ||
                         (k == last && is_junction(&t->w, t->w.branch.n_point - 1));
        snprintf(where, sizeof where, "between points %d and %d", name_station(t, from),
                 name_station(t, k) + (t->stations[k].point < 0));
        const bool joined = !status && prove_step(t, a, b, where, out);
        if (from == 0) out->from = joined;
        if (k == last) out->to = joined;
        done = joined || end;
        from = k;
        turn = 1 - turn;
    }
    for (int i = 0; i < 2; i++) ric_curve_node_clear(&nodes[i]);
    if (done) *out->why = 0;
    if (!status) out->state = done ? RIC_PROOF_DONE : RIC_PROOF_NONE;
    return status;
}

ric_status ric_prover_curve(ric_prover *p, int id, ric_curve_proof *out)
{
    tracing t = {.p = p, .curve = {.approach = HUGE_VAL}};
    ric_status status = ric_walk_open(&t.w, p, id, 0);
    t.curve.e = t.w.e;
    *out = (ric_curve_proof){.branch = id, .state = RIC_PROOF_NONE};
    const char *left_out = status ? NULL : ric_prover_left_out(p, &t.w.branch);
    if (left_out) {
        out->state = RIC_PROOF_LEFT_OUT;
        snprintf(out->why, sizeof out->why, "%s", left_out);
    } else if (!status && !p->at[0].good) snprintf(out->why, sizeof out->why, "%s", t.w.e->why);
    else if (!status && !(status = ric_walk_class(&t.w)) && t.w.like.u && !(status = list_stations(&t)))
        status = prove_steps(&t, out);
    const double *length = t.curve.length, all = length[0] + length[1] + length[2];
    out->tubes = t.curve.tubes;
    out->stable = all > 0 ? length[RIC_STABLE_YES] / all : 0;
    out->unstable = all > 0 ? length[RIC_STABLE_NO] / all : 0;
    out->approach = ldexp(t.curve.approach, t.w.e->time);
    free(t.stations);
    ric_walk_close(&t.w);
    return status;
}
