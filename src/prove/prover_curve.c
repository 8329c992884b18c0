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
    ric_node beyond; /* the other end of an arc across a junction, where the curve goes on */
    station *stations;
    int n;
    ric_curve_work work;
    ric_arcs arcs; /* the certificate */
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
            t->stations[t->n++] = (station){.point = -1,
                                            .junction = b->junctions[next],
                                            .at = b->junction_at[next]};
        if (!is_at(&t->w, i, point.arclength)) t->stations[t->n++] = (station){.point = i};
    }
    return RIC_OK;
}

/* ----------------------------------------------------------------- junctions */

/* A spring that closes and opens at one instant: the conditions of both are one there, and the
 * equations singular; not so with a mirror point in the midst of the contact, from which only half
 * of it is in the chain. */
static bool has_no_length(const ric_chain *c, arb_srcptr u)
{
    for (int k = 0; k < c->m; k++)
        if (c->face[k] >= 0 && c->face[k + 1] >= 0 &&
            arb_contains_zero(u + (slong)k * c->size + 2 * c->n))
            return true;
    return false;
}

/* A story cut at an end of the branch: the node. */
static ric_status cut_end(tracing *t, int i, ric_story *story, ric_node *a)
{
    const double place = 1e-5;
    ric_chain c = {0};
    bool made;
    const ric_status status = ric_walk_chain(&t->w, i, &c, &made);
    arb_ptr u = made ? _arb_vec_init((slong)c.m * c.size + 1) : NULL;
    if (!made || !ric_story_cut(story, &c, place, u))
        a->why = "what was proved of the junction at its end has another class";
    else if (has_no_length(&c, u)) a->why = "it ends in a contact of no length";
    else ric_curve_node_place(a, &c, u, true, t->w.e);
    if (made) _arb_vec_clear(u, (slong)c.m * c.size + 1);
    ric_chain_free(&c);
    return status;
}

/* How far apart two orbits of a class are. */
static double apart(const ric_chain *c, arb_srcptr u, const ric_enclosure *e)
{
    const slong count = (slong)c->m * c->size;
    arb_ptr way = _arb_vec_init(count);
    arb_t size;
    arb_init(size);
    _arb_vec_sub(way, c->u, u, count, e->prec);
    ric_chain_norm(count, way, e->prec, size);
    const double length = arf_get_d(arb_midref(size), ARF_RND_NEAR);
    arb_clear(size);
    _arb_vec_clear(way, count);
    return length;
}

/* The arc that leaves, or passes, a curve of a smaller class near the chain `like`: its end on the
 * side of `from`, and the other one. */
static void place_leaving(tracing *t, const ric_augmented *x, const ric_chain *like,
                          const ric_chain *from, ric_node *a, ric_node *beyond)
{
    ric_leaving leaving;
    if (ric_chain_same_class(like, from) && ric_leaving_prove(&leaving, x, like)) {
        const int side = apart(from, leaving.end[1], t->w.e) < apart(from, leaving.end[0], t->w.e);
        ric_curve_node_place(a, like, leaving.end[side], false, t->w.e);
        if (beyond) ric_curve_node_place(beyond, like, leaving.end[1 - side], false, t->w.e);
        t->curve.tubes++;
        t->curve.approach = fmin(t->curve.approach, leaving.approach);
    } else a->why = "the arc that leaves the junction there is not proved";
    ric_leaving_free(&leaving);
}

static ric_status place_first(tracing *t, int i, const ric_augmented *x, ric_node *a)
{
    ric_chain like = {0}, next = {0};
    bool made = false, both = false;
    ric_status status = ric_walk_chain(&t->w, i, &like, &made);
    if (!status) status = ric_walk_chain(&t->w, i ? i - 1 : 1, &next, &both);
    if (made && both) place_leaving(t, x, &like, &next, a, NULL);
    ric_chain_free(&like);
    ric_chain_free(&next);
    return status;
}

static bool leaves(const ric_junction *row)
{
    return row->kind == RIC_KIND_BRANCH_POINT || row->kind == RIC_KIND_MULTIPLICATION;
}

/* A grazing at an end: what is proved of it by any branch, or in the class of this one. */
static ric_status place_grazing(tracing *t, int i, const ric_junction *row, bool own, ric_node *a)
{
    ric_augmented x = {0};
    ric_junction_proof proof = {.state = RIC_PROOF_NONE};
    t->w.slow = own ? RIC_PROVER_SLOW : 0;
    ric_status status = own ? ric_prover_junction_end(&t->w, row, i > 0, &x, &proof)
                            : ric_prover_junction_find(t->p, row, 0, &x, &proof);
    if (!status && proof.state == RIC_PROOF_DONE) {
        ric_story story;
        ric_prover_junction_tell(&x, &story);
        status = cut_end(t, i, &story, a);
        ric_story_free(&story);
    }
    ric_augmented_free(&x);
    return status;
}

/* The orbit of a junction at an end, in the class of the branch: a grazing, or a little beyond
 * where it leaves. A grazing may lack mirrors in the class of another branch that this one has. */
static ric_status place_end(tracing *t, int i, ric_node *a)
{
    ric_junction row;
    ric_augmented x = {0};
    ric_junction_proof proof = {.state = RIC_PROOF_NONE};
    ric_status status = ric_atlas_junction(t->p->atlas, i ? t->w.branch.to : t->w.branch.from,
                                           &row);
    a->why = "the junction at its end is not proved";
    for (int own = 0; own < 2 && !status && row.kind == RIC_KIND_GRAZING && !a->c.u; own++)
        status = place_grazing(t, i, &row, own, a);
    if (!status && leaves(&row)) status = ric_prover_junction_find(t->p, &row, 0, &x, &proof);
    if (!status && proof.state == RIC_PROOF_DONE) status = place_first(t, i, &x, a);
    ric_augmented_free(&x);
    return status;
}

/* Newton's method may come to an image of the junction that the branch passes, which is as good a
 * proof, but on the branch that is the image of this one: u [m * size + 1] is then told of the same
 * motion near the chord of the points beside it. */
static void take_side(const tracing *t, const ric_chain *chord, const ric_augmented *x, arb_ptr u)
{
    const double place = 1e-5;
    ric_story story;
    if (!(apart(chord, u, t->w.e) > place)) return;
    ric_prover_junction_tell(x, &story);
    ric_story_cut(&story, chord, place, u);
    ric_story_free(&story);
}

/* A junction that the branch passes. */
static ric_status place_inside(tracing *t, const station *s, const ric_junction *row, ric_node *a)
{
    ric_augmented x = {0};
    ric_chain chord = {0};
    ric_junction_proof proof = {.state = RIC_PROOF_NONE};
    const ric_status status = ric_prover_junction_inside(&t->w, row, s->at, &x, &chord, &proof);
    if (!status && proof.state == RIC_PROOF_DONE) {
        const slong count = (slong)x.c.m * x.c.size + 1;
        arb_ptr u = _arb_vec_init(count);
        _arb_vec_set(u, x.z, x.n_orbit);
        take_side(t, &chord, &x, u);
        ric_curve_node_place(a, &x.c, u, false, t->w.e);
        _arb_vec_clear(u, count);
    }
    ric_chain_free(&chord);
    ric_augmented_free(&x);
    return status;
}

/* A curve of a smaller class, or a shorter orbit, that it passes in its own class: behind it, seen
 * from the node before. */
static ric_status place_across(tracing *t, const station *s, const ric_junction *row,
                               const ric_node *before, ric_node *a)
{
    ric_augmented x = {0};
    ric_junction_proof proof = {.state = RIC_PROOF_NONE};
    ric_chain like = {0};
    bool made = false;
    ric_status status = ric_prover_junction_find(t->p, row, 0, &x, &proof);
    if (!status && proof.state == RIC_PROOF_DONE)
        status = ric_walk_between(&t->w, s->at, &like, &made);
    if (made && !before->why) {
        ric_curve_node_clear(&t->beyond);
        ric_curve_node_init(&t->beyond);
        place_leaving(t, &x, &like, &before->c, a, &t->beyond);
    }
    ric_chain_free(&like);
    ric_augmented_free(&x);
    return status;
}

static ric_status place(tracing *t, const station *s, const ric_node *before, ric_node *a)
{
    bool made;
    ric_status status;
    if (s->point < 0) {
        ric_junction row;
        status = ric_atlas_junction(t->p->atlas, s->junction, &row);
        if (status) return status;
        if (ric_prover_junction_asked(&row, &t->w.branch)) status = place_inside(t, s, &row, a);
        return status || !a->why || !leaves(&row) ? status : place_across(t, s, &row, before, a);
    }
    if (is_junction(&t->w, s->point)) return place_end(t, s->point, a);
    status = ric_walk_chain(&t->w, s->point, &a->c, &made);
    if (made) ric_curve_node_prove(a, t->w.e);
    return status;
}

/* -------------------------------------------------------------------- steps */

/* Between two stations; false with the reason. */
static bool prove_step(tracing *t, const ric_node *a, const ric_node *b, const char *where,
                       ric_curve_proof *out)
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

static void swap_nodes(ric_node *a, ric_node *b)
{
    const ric_node other = *a;
    *a = *b;
    *b = other;
}

/* From station `from` to station k, whose node is b; false where that ends the curve. */
static bool prove_next(tracing *t, int from, int k, const ric_node *a, const ric_node *b,
                       ric_curve_proof *out)
{
    char where[60];
    const bool end = (from == 0 && is_junction(&t->w, 0)) ||
                     (k == t->n - 1 && is_junction(&t->w, t->w.branch.n_point - 1));
    snprintf(where, sizeof where, "between points %d and %d", name_station(t, from),
             name_station(t, k) + (t->stations[k].point < 0));
    const bool joined = prove_step(t, a, b, where, out);
    if (from == 0) out->from = joined;
    if (k == t->n - 1) out->to = joined;
    return joined || end;
}

/* --------------------------------------------------------------------- arcs */

/* Tells of what is proved up to station k, a stored orbit from which the curve can be gone on with:
 * its node is found anew, and all else is in the arc. */
static ric_status tell_arc(tracing *t, int k, const ric_curve_proof *out)
{
    const int point = t->stations[k].point;
    if (!t->work.tell || point < 0 || is_junction(&t->w, point) || ric_halted()) return RIC_OK;
    const ric_curve *c = &t->curve;
    ric_arc_proof arc = {.branch = t->w.branch.id,
                         .point = point,
                         .tubes = c->tubes,
                         .from = out->from,
                         .approach = c->approach,
                         .open = t->arcs.open,
                         .told = t->arcs.unique && !t->work.plain,
                         .certificate = ric_certificate_arcs_new(&t->arcs)};
    for (int i = 0; i < 3; i++) arc.length[i] = c->length[i];
    snprintf(arc.prover, sizeof arc.prover, "%s", ric_prover_version());
    return arc.certificate ? t->work.tell(&arc, t->work.user) : ric_no_memory("a certificate");
}

/* Takes up what was proved before; the station where it ends, or 0. */
static int go_on(tracing *t, ric_curve_proof *out)
{
    const ric_arc_proof *last = t->work.n ? &t->work.arcs[t->work.n - 1] : NULL;
    int k = t->n - 1;
    while (last && k > 0 && t->stations[k].point != last->point) k--;
    if (!last || k == 0 || is_junction(&t->w, last->point)) return 0;
    if (!last->told && !t->work.plain) return 0;
    ric_curve *c = &t->curve;
    for (int i = 0; i < t->work.n; i++)
        ric_certificate_arcs_again(&t->arcs, t->work.arcs[i].certificate);
    t->arcs.open = last->open;
    t->arcs.unique = last->told;
    c->tubes = last->tubes;
    c->approach = isfinite(last->approach) ? last->approach : HUGE_VAL;
    for (int i = 0; i < 3; i++) c->length[i] = last->length[i];
    out->from = last->from;
    return k;
}

/* Steps to ends that are junctions are left out where these are not proved, or no tube reaches
 * them; so are junctions inside. */
static ric_status prove_steps(tracing *t, ric_curve_proof *out)
{
    ric_node here, next;
    int from = go_on(t, out); /* the station of the node that comes next */
    ric_curve_node_init(&here);
    ric_curve_node_init(&next);
    ric_curve_node_init(&t->beyond);
    ric_status status = place(t, &t->stations[from], NULL, &here);
    bool done = t->n > 1;
    for (int k = from + 1; k < t->n && !status && done; k++) {
        ric_curve_node_clear(&next);
        ric_curve_node_init(&next);
        status = place(t, &t->stations[k], &here, &next);
        if (status || (t->stations[k].point < 0 && next.why)) continue;
        done = prove_next(t, from, k, &here, &next, out);
        from = k;
        swap_nodes(&here, &next);
        if (t->beyond.c.u) {
            swap_nodes(&here, &t->beyond);
            ric_certificate_arcs_break(&t->arcs);
        } else if (done) status = tell_arc(t, k, out);
        ric_curve_node_clear(&t->beyond);
        ric_curve_node_init(&t->beyond);
    }
    ric_curve_node_clear(&here);
    ric_curve_node_clear(&next);
    ric_curve_node_clear(&t->beyond);
    if (done) *out->why = 0;
    if (!status) out->state = done ? RIC_PROOF_DONE : RIC_PROOF_NONE;
    return status;
}

ric_status ric_prover_curve(ric_prover *p, int id, ric_curve_proof *out)
{
    return ric_prover_curve_from(p, id, &(ric_curve_work){.n = 0}, out);
}

ric_status ric_prover_curve_from(ric_prover *p, int id, const ric_curve_work *work,
                                 ric_curve_proof *out)
{
    tracing t = {.p = p, .curve = {.approach = HUGE_VAL}, .work = *work};
    if (!ric_certificate_arcs_open(&t.arcs)) return ric_no_memory("a certificate");
    if (!work->plain) t.curve.arcs = &t.arcs;
    ric_status status = ric_walk_open(&t.w, p, id, 0);
    t.curve.e = t.w.e;
    *out = (ric_curve_proof){.branch = id, .state = RIC_PROOF_NONE};
    snprintf(out->prover, sizeof out->prover, "%s", ric_prover_version());
    const char *left_out = status ? NULL : ric_prover_left_out(p, &t.w.branch);
    if (left_out) {
        out->state = RIC_PROOF_LEFT_OUT;
        snprintf(out->why, sizeof out->why, "%s", left_out);
    } else if (!status && !p->at[0].good) snprintf(out->why, sizeof out->why, "%s", t.w.e->why);
    else if (!status && !(status = ric_walk_class(&t.w)) && t.w.like.u &&
             !(status = list_stations(&t)))
        status = prove_steps(&t, out);
    const double *length = t.curve.length, all = length[0] + length[1] + length[2];
    out->tubes = t.curve.tubes;
    out->stable = all > 0 ? length[RIC_STABLE_YES] / all : 0;
    out->unstable = all > 0 ? length[RIC_STABLE_NO] / all : 0;
    out->approach = ldexp(t.curve.approach, t.w.e->time);
    free(t.stations);
    free(p->certificate);
    p->certificate = ric_certificate_arcs_close(&t.arcs, &t.w.like, t.w.e, out);
    ric_walk_close(&t.w);
    return status ? status : p->certificate ? RIC_OK : ric_no_memory("a certificate");
}
