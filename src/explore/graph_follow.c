/* From a departure to an edge of the graph: what its trace ends at, and what it passes. */
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "junction/room.h"
#include "graph_parts.h"
#include "branch/room.h"

#define AT_END 1e-9     /* arclength within which an event belongs to the end of its branch */
#define SAME_EVENT 1e-5 /* arclength, relative, within which two events of one place lie */
/* NEAR_END: part of a branch near its end where that end's own junction is not met again */
#define NEAR_END 1e-2
/* FLAT: relative: to what the period is known where it has an extremum, whose place is known to
 * 1e-6 */
#define FLAT 1e-8
#define END_NEAR 1e-4  /* of the size: how far off an end read off cubics may be */
#define END_SAME 1e-14 /* the same: what is no farther off is the orbit of the junction */

/* Whether the branch stopped because gaps of two contacts closed at one instant. */
static bool at_corner(const ric_continuation *tr)
{
    ric_touch touch;
    if (tr->end.test == RIC_TEST_FLIGHT) return true;
    if (tr->end.test != RIC_TEST_REACH) return false;
    ric_shooting_fly(tr->chain, tr->end.u);
    ric_reach(tr->chain, tr->end.u, &touch);
    return touch.face >= 0 && touch.kink;
}

/* Whether a branch that ends here, by this way, can be traced from here. */
static bool departs(const ric_node *node, unsigned choice)
{
    return !(ric_node_chooses(node) && node->refusal) && !ric_node_unmirrored(node, choice);
}

/* Which of the branches that leave a multiplication without mirror points this is: its last point
 * before the end tells. */
static ric_status ring_choice(const ric_graph *g, const ric_continuation *tr, const ric_node *node,
                              unsigned *choice)
{
    int side, last = tr->n_point - 1;
    const ric_point *row = ric_continuation_row(tr, last);
    if (last > 0 && row->arclength >= tr->end.s) row = ric_continuation_row(tr, last - 1);
    ric_periodic *near = ric_continuation_cycle(tr, (const double *)(row + 1));
    if (!near) return ric_no_memory("a junction");
    ric_status status = ric_multiplication_class(g->model, node, near, choice, &side);
    ric_periodic_free(near);
    if (status != RIC_E_NUMERIC) return status;
    *choice = RIC_SIDE; /* refused to those who want to leave here, too */
    return RIC_OK;
}

/* Whether two chains are the same problem. */
static bool same_problem(const ric_shooting *a, const ric_shooting *b)
{
    size_t faces = (size_t)a->n_flight + 1;
    return a->start == b->start && a->end == b->end && a->sigma == b->sigma &&
           a->n_flight == b->n_flight && a->parts == b->parts && a->closed[0] == b->closed[0] &&
           !memcmp(a->face, b->face, faces * sizeof *a->face);
}

/* The end of a branch at a junction, read off cubics, is replaced by the orbit of the junction
 * itself: of its images, as orbits of the branch's own problem, the one that lies there. What bends
 * the curves there grows with the stiffness; between stops, too, an orbit beside a branch point may
 * as well be one of the other branch, and so it is where two contacts begin to close together for
 * good. */
static ric_status end_on_node(const ric_graph *g, ric_continuation *tr, const ric_node *node,
                              unsigned choice)
{
    ric_shooting *c = tr->chain;
    int size = c->n_unknown;
    double nearest = END_NEAR * c->scale, best[size];
    const bool meets = node->kind == RIC_KIND_CORNER && node->refusal == RIC_REFUSAL_TOGETHER;
    if (!meets && !ric_node_leaves(node, choice)) return RIC_OK;
    ric_symmetry problem = ric_node_problem(node, choice);
    ric_periodic *whole = meets ? ric_periodic_copy(node->cycle)
                                : ric_symmetry_cycle(node->cycle, &problem);
    if (!whole) return ric_no_memory("the end of a branch");
    int operations = ric_periodic_operations(g->model);
    for (int k = 0; k < operations * whole->N; k++) {
        ric_shooting *chain = NULL;
        double *u = NULL, off = 0;
        int op = k % operations;
        ric_periodic *image = ric_periodic_transform(g->model, whole, k / operations, op & 1,
                                                     op & 2);
        bool fits = image && !ric_periodic_to_chain(g->model, image, &chain, &u) &&
                    same_problem(chain, c);
        for (int i = 0; fits && i < size; i++) off = fmax(off, fabs(u[i] - tr->end.u[i]));
        if (fits && off < nearest) {
            nearest = off;
            memcpy(best, u, sizeof best);
        }
        ric_periodic_free(image);
        ric_shooting_free(chain);
        free(u);
    }
    ric_periodic_free(whole);
    if (nearest == END_NEAR * c->scale || (meets && nearest <= END_SAME * c->scale)) return RIC_OK;
    return ric_continuation_end_at(tr, best);
}

/* Which of the ways out of a grazing or a corner a branch is whose end orbit is `cycle`; -1: none.
 */
static int way_chosen(const ric_graph *g, const ric_node *node, const ric_periodic *cycle)
{
    bool *kept = NULL;
    if (node->kind == RIC_KIND_CORNER) return ric_grazing_words_order(g->model, node, cycle);
    ric_periodic *full = ric_node_cache_touches(g->model, g->recall, cycle, &kept);
    const int found = full && kept ? ric_grazing_words_choice(g->model, node, full, kept) : -1;
    ric_periodic_free(full);
    free(kept);
    return found;
}

/* Why the junction at the end of a trace is not found. */
static ric_why why_lost(const ric_model *m, const ric_periodic *cycle)
{
    ric_periodic *full = ric_grazing_words_touches(m, cycle, NULL);
    const bool counted = full;
    ric_periodic_free(full);
    return counted ? RIC_WHY_NO_JUNCTION : RIC_WHY_TOUCHES;
}

/* The node at the far end of a trace (-1: none) and the departure there that the branch is. */
static ric_status end_node(ric_graph *g, ric_continuation *tr, int depth, int *index,
                           unsigned *choice)
{
    ric_status status = RIC_OK;
    ric_node *node = NULL;
    *index = -1;
    *choice = 0;
    if (tr->stop != RIC_STOP_JUNCTION || !tr->end.u) return RIC_OK;
    ric_periodic *cycle = ric_continuation_cycle(tr, tr->end.u);
    if (!cycle) return ric_no_memory("a junction");
    ric_defining solve = {.kind = tr->arrival ? RIC_DEFINING_ARRIVAL
                                  : at_corner(tr) || ric_node_coincident(g->model, cycle)
                                      ? RIC_DEFINING_CORNER
                                      : RIC_DEFINING_GRAZING};
    status = ric_node_cache_solve(g->model, g->recall, solve, cycle, &node);
    if (status == RIC_E_NUMERIC) {
        tr->stop = RIC_STOP_FAILED;
        tr->why = why_lost(g->model, cycle);
        status = RIC_OK;
    }
    if (node) {
        if (node->kind == RIC_KIND_CORNER && node->refusal) tr->stop = RIC_STOP_CORNER;
        *index = ric_graph_add(g, node, depth);
        if (*index < 0) status = ric_no_memory("a junction");
        else if (ric_node_chooses(g->nodes[*index]) && departs(g->nodes[*index], RIC_THROUGH)) {
            int found = way_chosen(g, g->nodes[*index], cycle);
            if (found < 0) {
                tr->stop = RIC_STOP_FAILED;
                tr->why = RIC_WHY_NO_FIT;
                *index = -1;
            } else *choice = (unsigned)found;
        } else if (ric_multiplication_applies(g->nodes[*index], RIC_SIDE))
            status = ring_choice(g, tr, g->nodes[*index], choice);
        else
            *choice = ric_node_chooses(g->nodes[*index])
                          ? 0
                          : ric_node_arrived(g->model, g->nodes[*index], cycle);
    }
    if (!status && (tr->arrival || tr->stop == RIC_STOP_CORNER) && *index >= 0)
        status = end_on_node(g, tr, g->nodes[*index], *choice);
    ric_periodic_free(cycle);
    return ric_trust(status);
}

/* ------------------------------------------------------------------- edges */

/* On a half chain tests A and D vanish where the period doubles. */
static bool doubles(const ric_shooting *c, int test)
{
    return c->start != RIC_MIRROR_NONE && c->multiple == 2 &&
           (test == RIC_TEST_A || test == RIC_TEST_D);
}

static bool at_one_place(double s, const ric_event *event)
{
    return fabs(s - event->s) < SAME_EVENT * (1 + event->s);
}

/* The resonance that an event belongs to, or NULL. A doubling is met as a zero of A or D and by its
 * multiplier; that may pass -1 and come back within one step, where only the tests tell both
 * places. *twin: the event is met by its multiplier, too. */
static const ric_resonance *resonance_of(const ric_continuation *tr, const ric_event *event,
                                         bool *twin)
{
    const ric_resonance *doubling = NULL;
    *twin = false;
    if (!doubles(tr->chain, event->test)) return ric_continuation_resonance(tr, event->test);
    for (int k = 0; k < tr->n_resonance; k++)
        if (tr->resonances[k].q == 2) doubling = &tr->resonances[k];
    for (int i = 0; i < tr->n_event; i++) {
        const ric_resonance *other = ric_continuation_resonance(tr, tr->events[i].test);
        *twin |= other && other == doubling && at_one_place(tr->events[i].s, event);
    }
    return doubling;
}

static bool breaks_or_crosses(int test)
{
    return test == RIC_TEST_DET || test == RIC_TEST_A || test == RIC_TEST_B || test == RIC_TEST_D;
}

/* Which of the ways out of a junction the edge is that passes it; `aside`: as an orbit of several
 * periods, or one without the symmetry of the junction. */
static ric_status passing_choice(const ric_graph *g, const ric_edge *e, const ric_event *event,
                                 const ric_node *node, bool aside, unsigned *choice)
{
    int size = e->trace->chain->n_unknown;
    double u[size];
    *choice = aside ? RIC_SIDE : RIC_THROUGH;
    if (node->kind != RIC_KIND_BRANCH_POINT || node->test != RIC_TEST_DET) return RIC_OK;
    for (int i = 0; i < size; i++)
        u[i] = event->u[i] + RIC_LEAVING * e->trace->chain->scale * event->t[i];
    ric_periodic *near = ric_continuation_cycle(e->trace, u);
    ric_status status = near ? ric_branch_point_choice(g->model, node, near, choice)
                             : ric_no_memory("a junction");
    ric_periodic_free(near);
    return status == RIC_E_NUMERIC ? RIC_OK : status; /* refused when it is left, with the reason */
}

/* Whether the orbit has a symmetry x -> -x there that neither the branch nor the structure has: the
 * branch passes its mirror image. */
static bool passes_image(const ric_model *m, const ric_periodic *cycle, int test)
{
    ric_periodic *found = !m->symmetric && test == RIC_TEST_DET ? ric_periodic_copy(cycle) : NULL;
    if (found) ric_periodic_find_symmetries(m, found, RIC_SAME_EXTRAPOLATED);
    bool more = found && ((found->half && !cycle->half) || (found->flip >= 0 && cycle->flip < 0));
    ric_periodic_free(found);
    return more;
}

/* Where it is and what it was taken for: the atlas names what it has not found. */
static ric_status add_unplaced(const ric_graph *g, ric_edge *e, const ric_event *event,
                               const ric_resonance *resonance, const ric_periodic *cycle)
{
    ric_unplaced *more = ric_realloc(e->unplaced, ((size_t)e->n_unplaced + 1) * sizeof *more);
    if (!more) return ric_no_memory("a branch");
    e->unplaced = more;
    more[e->n_unplaced++] = (ric_unplaced){.test = event->test,
                                           .p = resonance ? resonance->p : 0,
                                           .q = resonance ? resonance->q : 0,
                                           .energy = ric_periodic_energy(g->model, cycle) *
                                                     g->model->energy_unit,
                                           .frequency = RIC_TWO_PI / ric_periodic_period(cycle) *
                                                        g->model->omega_ref};
    return RIC_OK;
}

/* Whether an extremum of the period was solved for that is not the one seen: where the period of a
 * branch is one number its slope changes sign in rounding, and the extremum is one of another
 * branch. A true one is flat, so that the period is known better than its place. */
static bool strays(const ric_node *node, const ric_periodic *cycle)
{
    double seen = ric_periodic_period(cycle);
    return fabs(node->period * node->multiple - seen) > FLAT * seen;
}

/* A function that vanishes twice has two zeros: where their orbits count as one junction the branch
 * says so. One of the two may be rounding beside it, and that of another place be missing: it lies
 * between the points on both sides. */
static void tell_crowded(ric_edge *e, const ric_event *event)
{
    ric_continuation *tr = e->trace;
    const ric_event *other = tr->events;
    while (other < event && !(other->test == event->test && at_one_place(other->s, event))) other++;
    if (other == event) return;
    const int beyond = ric_continuation_points_until(tr, event->s),
              after = beyond < tr->n_point ? beyond : tr->n_point - 1,
              before = after > 0 ? after - 1 : 0;
    ric_continuation_widen(tr->unresolved++ == 0, ric_continuation_row(tr, before)->energy,
                           ric_continuation_row(tr, after)->energy, tr->crowded_at);
}

/* Arclength of the end, of which the orbit is not stored where it cannot be solved: the last point
 * may be an event that lies before it. */
static double length_of(const ric_continuation *tr)
{
    const double last = ric_continuation_row(tr, tr->n_point - 1)->arclength;
    return tr->end.u ? fmax(last, tr->end.s) : last;
}

static ric_status add_inner(ric_graph *g, ric_edge *e, const ric_event *event)
{
    ric_status status;
    ric_node *node = NULL;
    bool twin, doubling = doubles(e->trace->chain, event->test);
    const ric_resonance *resonance = resonance_of(e->trace, event, &twin);
    if (doubling && (twin || !resonance)) return RIC_OK;
    /* the ends of a branch are junctions of their own, but for the place where a closed one begins
     * and ends */
    const double length = length_of(e->trace);
    if (event->s < AT_END || (event->s > length - AT_END && e->trace->stop != RIC_STOP_CLOSED))
        return RIC_OK;
    ric_periodic *cycle = ric_continuation_cycle(e->trace, event->u);
    if (!cycle) return ric_no_memory("a junction");
    bool aside = !doubling && breaks_or_crosses(event->test) &&
                 (ric_periodic_repeats(g->model, cycle, RIC_SAME_EXTRAPOLATED) ||
                  passes_image(g->model, cycle, event->test));
    const ric_user_point *asked = ric_continuation_user_point(e->trace, event->test);
    ric_defining solve = aside   ? (ric_defining){.kind = RIC_DEFINING_ARRIVAL}
                         : asked ? (ric_defining){.kind = RIC_DEFINING_USER, .asked = *asked}
                         : resonance
                             ? (ric_defining){.kind = RIC_DEFINING_MULTIPLICATION,
                                              .p = resonance->p,
                                              .q = resonance->q}
                             : (ric_defining){.kind = RIC_DEFINING_INTERIOR, .test = event->test};
    status = ric_node_cache_solve(g->model, g->recall, solve, cycle, &node);
    aside |= node && solve.kind == RIC_DEFINING_INTERIOR && node->kind == RIC_KIND_MULTIPLICATION;
    bool off = node && event->test == RIC_TEST_PERIOD && strays(node, cycle);
    if (off) {
        ric_node_free(node);
        node = NULL;
    }
    if (off || status == RIC_E_NUMERIC) status = add_unplaced(g, e, event, resonance, cycle);
    ric_periodic_free(cycle);
    if (!node) return status;
    int index = ric_graph_add(g, node, e->depth);
    if (index < 0) return ric_no_memory("a junction");
    if ((index == e->from && event->s < NEAR_END * length) ||
        (index == e->to && event->s > (1 - NEAR_END) * length))
        return RIC_OK;
    for (int i = 0; i < e->n_inner;
         i++) /* at a q-fold repeated orbit several tests vanish at once */
        if (e->inner[i].node == index && at_one_place(e->inner[i].at, event)) {
            tell_crowded(e, event);
            return RIC_OK;
        }
    unsigned choice;
    if ((status = passing_choice(g, e, event, g->nodes[index], aside, &choice))) return status;
    ric_graph_mark(g, g->nodes[index], choice, RIC_DEPARTURE_KNOWN);
    return ric_graph_edge_attach(e, index, choice, event->s);
}

/* Whether the branch passes one orbit twice, between the arclengths s: as the image of it, or of
 * itself, the second time; or one of its two junctions has been taken for the other. Where branches
 * cross it may be on both. */
static bool passes_twice(const ric_graph *g, const ric_edge *e, double s[2])
{
    bool twice = e->from >= 0 && e->from == e->to && e->leave == e->arrive;
    s[0] = 0;
    s[1] = ric_continuation_row(e->trace, e->trace->n_point - 1)->arclength;
    for (int i = 0; i < e->n_inner; i++)
        for (int j = i + 1; j < e->n_inner; j++) {
            const double a = e->inner[i].at, b = e->inner[j].at;
            if (e->inner[i].node != e->inner[j].node ||
                g->nodes[e->inner[i].node]->kind == RIC_KIND_BRANCH_POINT || b - a > s[1] - s[0])
                continue;
            twice = true;
            s[0] = a;
            s[1] = b;
        }
    return twice;
}

void ric_graph_edge_returning(const ric_graph *g, ric_edge *e)
{
    ric_continuation *tr = e->trace;
    double s[2];
    if (tr->stop == RIC_STOP_CLOSED || !passes_twice(g, e, s)) return;
    for (int i = 0; i < tr->n_point; i++) {
        const ric_point *p = ric_continuation_row(tr, i);
        if (p->arclength >= s[0] && p->arclength <= s[1])
            ric_continuation_widen(tr->unresolved++ == 0, p->energy, p->energy, tr->crowded_at);
    }
}

/* Traces again from the far end, so that what is stored does not depend on which end was found
 * first: the ends of *e are exchanged then. */
static ric_status from_smaller_end(ric_graph *g, ric_edge *e)
{
    ric_continuation *back = NULL;
    int home = -1;
    unsigned choice = 0;
    ric_node *a = g->nodes[e->from], *b = g->nodes[e->to];
    int order = e->from == e->to ? (e->arrive < e->leave ? 1 : -1) : -ric_graph_node_order(b, a);
    if (order <= 0 || !departs(b, e->arrive)) return RIC_OK;
    ric_status status = ric_graph_trace(g, b, e->arrive, 1, &back);
    if (status == RIC_E_NUMERIC) return RIC_OK;
    if (!status && back) status = end_node(g, back, 1 << 20, &home, &choice);
    if (status) return status;
    if (!back || home != e->from || (ric_node_chooses(a) && choice != e->leave)) {
        e->trace->stop = RIC_STOP_FAILED;
        e->trace->why = RIC_WHY_NO_WAY_BACK;
        ric_continuation_free(back);
        return RIC_OK;
    }
    ric_continuation_free(e->trace);
    *e = (ric_edge){.trace = back,
                    .from = e->to,
                    .leave = e->arrive,
                    .to = e->from,
                    .arrive = e->leave,
                    .depth = e->depth,
                    .mode = e->mode};
    return RIC_OK;
}

/* What tells quickly that an orbit is none of the edge's. */
static ric_status note_orbits(ric_edge *e)
{
    e->energy[0] = HUGE_VAL;
    e->energy[1] = -HUGE_VAL;
    for (int i = 0; i < e->trace->n_point; i++) {
        const ric_point *p = ric_continuation_row(e->trace, i);
        e->energy[0] = fmin(e->energy[0], p->energy);
        e->energy[1] = fmax(e->energy[1], p->energy);
    }
    e->first = ric_continuation_cycle(e->trace,
                                      e->trace->points + sizeof(ric_point) / sizeof(double));
    return e->first ? RIC_OK : ric_no_memory("a branch");
}

/* Takes over the trace of an edge of which its ends are known. */
static ric_status finish_edge(ric_graph *g, const ric_edge *given)
{
    ric_edge *e = ric_graph_add_edge(g);
    if (!e) {
        ric_continuation_free(given->trace);
        return ric_no_memory("a branch");
    }
    *e = *given;
    const ric_continuation *tr = e->trace;
    ric_status status = note_orbits(e);
    for (int i = 0; i < tr->n_event && !status; i++) status = add_inner(g, e, &tr->events[i]);
    if (!status) ric_graph_edge_returning(g, e);
    status = ric_trust(status);
    /* no branch with some of its junctions */
    if (status == RIC_E_INTERRUPTED) ric_graph_edge_release(&g->edges[--g->n_edge]);
    return status;
}

/* Whether a trace ended where another one, from the other end of the branch, may not: stuck on the
 * way, or at the lower end of the energy window, which a branch that begins below it passes. */
static bool one_sided(const ric_continuation *tr)
{
    return tr->stop == RIC_STOP_FAILED ||
           (tr->stop == RIC_STOP_WINDOW && tr->end.test == RIC_TEST_E_MIN);
}

/* A branch has been followed from end to end by the last edge: what an earlier trace from one of
 * its ends left behind is a part of it. */
static void supersede(ric_graph *g)
{
    ric_edge *last = &g->edges[g->n_edge - 1];
    if (last->trace->stop == RIC_STOP_FAILED || last->from < 0 || last->to < 0) return;
    for (int i = 0; i < g->n_edge - 1; i++) {
        ric_edge *e = &g->edges[i];
        if (e->to >= 0) continue; /* nearly all, before anything that lies elsewhere is looked at */
        const bool same = (e->from == last->from && e->leave == last->leave) ||
                          (e->from == last->to && e->leave == last->arrive);
        if (!same || !one_sided(e->trace)) continue;
        ric_graph_edge_release(e);
        memmove(e, e + 1, (size_t)(g->n_edge - 1 - i) * sizeof *e);
        g->n_edge--;
        return;
    }
}

/* What was taken for known is not, because following it was broken off. */
static void reopen(ric_status status, ric_node *node, unsigned choice)
{
    for (int i = 0; i < node->n_departure && status == RIC_E_INTERRUPTED; i++)
        if (node->departures[i].choice == choice) node->departures[i].state = RIC_DEPARTURE_OPEN;
}

ric_status ric_graph_follow(ric_graph *g, int from, unsigned choice, int depth, bool *taken)
{
    ric_continuation *tr = NULL;
    int to = -1;
    unsigned arrive;
    ric_status status = ric_graph_trace(g, g->nodes[from], choice, 1, &tr);
    *taken = tr != NULL;
    if (status || !tr) return status;
    if ((status = end_node(g, tr, depth, &to, &arrive))) goto out;
    if ((status = ric_graph_has_left(tr))) goto out; /* an end that is no junction is found here */
    int mode = g->nodes[from]->mode >= 0 ? g->nodes[from]->mode : to >= 0 ? g->nodes[to]->mode : -1;
    ric_edge edge = {.trace = tr,
                     .from = from,
                     .leave = choice,
                     .to = to,
                     .arrive = arrive,
                     .depth = depth,
                     .mode = mode};
    if (to >= 0) {
        ric_graph_mark(g, g->nodes[to], arrive, RIC_DEPARTURE_KNOWN);
        status = from_smaller_end(g, &edge);
        tr = edge.trace;
        if (status) goto out;
    }
    status = finish_edge(g, &edge);
    if (!status) supersede(g);
    else if (to >= 0) reopen(status, g->nodes[to], arrive);
    return status;
out:
    if (to >= 0) reopen(status, g->nodes[to], arrive);
    ric_continuation_free(tr);
    return status;
}

/* The way back from an end of a branch passes the junction that the branch was followed from; if it
 * does not, one of the two ways has gone over to another branch. One that leaves a multiplication
 * and passes it has more periods than the junction, and is not asked. */
static ric_status comes_home(const ric_graph *g, ric_continuation *back, const ric_node *home,
                             unsigned through)
{
    double at;
    ric_edge way = {.trace = back};
    if (through != RIC_THROUGH) return RIC_OK;
    ric_status status = note_orbits(&way);
    if (!status && !ric_graph_edge_contains(g->model, &way, home, &at))
        status = ric_trust(ric_fail(RIC_E_NUMERIC,
                                    "the branch is followed to an end of it, and from there back "
                                    "it does not pass the junction"));
    ric_periodic_free(way.first);
    return status;
}

/* The branch is stored as it is followed from one of its ends: from a junction that it departs
 * from, otherwise from the first end that is found. Where a backbone, found in its midst, is
 * followed back from there to a window, its other side has no junction, and is not followed for
 * itself. */
ric_status ric_graph_follow_through(ric_graph *g, int inside, unsigned through, int depth)
{
    ric_status status = RIC_OK, missed = RIC_OK;
    ric_continuation *tr[2] = {NULL, NULL}, *whole = NULL;
    int to[2] = {-1, -1}, first = 0, far;
    unsigned arrive[2] = {0}, choice;
    bool stuck = false; /* at the first end: it is not followed from there */
    const bool backbone = g->nodes[inside]->kind == RIC_KIND_START;
    for (int i = 0; i < 2 && !(whole && whole->stop == RIC_STOP_WINDOW); i++) {
        if ((status = ric_graph_trace(g, g->nodes[inside], through, i ? -1 : 1, &tr[i])) || !tr[i])
            break;
        if ((status = end_node(g, tr[i], depth, &to[i], &arrive[i]))) goto out;
        if (tr[i]->stop == RIC_STOP_CLOSED) {
            status = finish_edge(g, &(ric_edge){.trace = tr[i],
                                                .from = -1,
                                                .to = -1,
                                                .depth = depth,
                                                .mode = g->nodes[inside]->mode});
            tr[i] = NULL;
            goto out;
        }
        if (i == 0) stuck = to[0] >= 0 && ric_node_unmirrored(g->nodes[to[0]], arrive[0]);
        if (to[i] >= 0 && departs(g->nodes[to[i]], arrive[i])) {
            bool taken;
            ric_graph_mark(g, g->nodes[to[i]], arrive[i], RIC_DEPARTURE_TAKEN);
            status = ric_graph_follow(g, to[i], arrive[i], depth, &taken);
            reopen(status, g->nodes[to[i]], arrive[i]);
            if (status != RIC_E_NUMERIC) goto out;
            status = RIC_OK;
            stuck = stuck || i == 0;
        }
        first = tr[0]->end.u && !stuck ? 0 : 1;
        for (; first <= i && (i || backbone) && !whole && tr[first]->end.u; first += !whole) {
            status = ric_graph_trace_back(g, g->nodes[inside], through, first ? -1 : 1, tr[first],
                                          &whole);
            /* speeds that vanish by powers show in no first step: from the other end */
            if (status && (status != RIC_E_NUMERIC || first)) goto out;
            missed = status;
            stuck |= missed != RIC_OK;
        }
    }
    if (!whole && !status) status = missed;
    if (!whole || status || (status = comes_home(g, whole, g->nodes[inside], through)) ||
        (status = end_node(g, whole, depth, &far, &choice)))
        goto out;
    if (far >= 0) ric_graph_mark(g, g->nodes[far], choice, RIC_DEPARTURE_KNOWN);
    status = finish_edge(g, &(ric_edge){.trace = whole,
                                        .from = to[first],
                                        .leave = arrive[first],
                                        .to = far,
                                        .arrive = choice,
                                        .depth = depth,
                                        .mode = g->nodes[inside]->mode});
    whole = NULL;
out:
    ric_continuation_free(tr[0]);
    ric_continuation_free(tr[1]);
    ric_continuation_free(whole);
    return status;
}
