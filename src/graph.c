#include "graph.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <stdio.h>
#include <time.h>

#include "crossing.h"
#include "depart.h"
#include "motion.h"
#include "subset.h"
#include "ring.h"
#include "status.h"

#define TWO_PI 6.283185307179586477
#define MAX_POINTS 200000
#define AT_END 1e-9    /* arclength within which an event belongs to the end of its branch */
#define NEAR_END 1e-2  /* part of a branch near its end where that end's own junction is not met again */
#define END_NEAR 1e-4  /* of the size: how far off an end read off cubics may be */
#define SAVE_EVERY 1.0 /* seconds between commits of finished traces */

/* ------------------------------------------------------------------- create */

ric_status ric_graph_create(const ric_study *study, ric_store *store, ric_graph **out)
{
    const ric_model *m = ric_study_model(study);
    const ric_explore_options *o = ric_study_options(study);
    ric_graph *g = calloc(1, sizeof *g);
    *out = NULL;
    if (!g) return ric_fail(RIC_E_NOMEM, "no memory for an atlas");
    g->study = study;
    g->model = m;
    g->options = o;
    g->store = store;
    g->limits = ric_trace_limits(m, o->energy, o->frequency, o->max_step, MAX_POINTS);
    g->limits.multiply = o->multiply;
    g->limits.n_asked = ric_asked_list(o, g->limits.asked);
    for (int i = 0; i < o->n_cascade; i++) g->limits.multiply = o->cascade[i] > g->limits.multiply ? o->cascade[i] : g->limits.multiply;
    *out = g;
    return RIC_OK;
}

static void edge_release(ric_edge *e)
{
    ric_trace_free(e->trace);
    free(e->inner);
}

void ric_graph_free(ric_graph *g)
{
    if (!g) return;
    for (int i = 0; i < g->n_node; i++) ric_node_free(g->nodes[i]);
    for (int i = 0; i < g->n_edge; i++) edge_release(&g->edges[i]);
    ric_starts_release(&g->starts);
    free(g->nodes);
    free(g->edges);
    free(g);
}

/* -------------------------------------------------------------------- nodes */

int ric_node_order(const ric_node *a, const ric_node *b)
{
    double de = a->energy - b->energy, dt = a->period - b->period;
    if (fabs(de) > 1e-8 * (fabs(a->energy) + fabs(b->energy))) return de < 0 ? -1 : 1;
    if (a == b) return 0;
    int na = a->cycle->N - a->n_touch, nb = b->cycle->N - b->n_touch;
    if (na != nb) return na < nb ? -1 : 1;
    if (fabs(dt) > 1e-8 * (a->period + b->period)) return dt > 0 ? -1 : 1;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    if (a->multiple != b->multiple) return a->multiple - b->multiple;
    if (a->rotation[0] != b->rotation[0]) return a->rotation[0] - b->rotation[0];
    if (a->cycle->N != b->cycle->N) return a->cycle->N - b->cycle->N;
    return ric_cycle_compare(a->springs, a->cycle, b->cycle); /* images of each other under what is no symmetry of the whole structure */
}

/* Takes over `node`: the known one that it equals, or a new one. -1: no memory. */
static int find_or_add(ric_graph *g, ric_node *node, int depth)
{
    for (int i = 0; i < g->n_node; i++) {
        if (!ric_node_same(g->model, g->nodes[i], node)) continue;
        ric_node_free(node);
        if (depth < g->nodes[i]->depth) g->nodes[i]->depth = depth;
        return i;
    }
    bool listed = !ric_node_chooses(node) || (node->kind == RIC_KIND_CORNER && node->refusal) || ric_subset_list(node);
    if (listed && g->n_node == g->node_capacity) {
        int capacity = g->node_capacity ? 2 * g->node_capacity : 64;
        ric_node **grown = realloc(g->nodes, (size_t)capacity * sizeof *grown);
        listed = grown;
        if (grown) {
            g->nodes = grown;
            g->node_capacity = capacity;
        }
    }
    if (!listed) {
        ric_node_free(node);
        return -1;
    }
    node->depth = depth;
    g->nodes[g->n_node] = node;
    return g->n_node++;
}

static void mark(ric_graph *g, ric_node *node, unsigned choice, ric_departure_state state)
{
    for (int i = 0; i < node->n_departure; i++) {
        ric_departure *d = &node->departures[i];
        if (d->choice != choice || d->state == RIC_DEPARTURE_TAKEN) continue;
        d->state = state;
        if (d->job) ric_workers_withdraw(g->workers, d->job);
    }
}

/* ------------------------------------------------------------------- tracing */

/* The text that names a trace for later runs: junction, departure, and everything that shapes the outcome. */
static void trace_key(const ric_graph *g, const ric_node *node, unsigned choice, int side, char *key, size_t size)
{
    const ric_limits *l = &g->limits;
    uint64_t hash = 14695981039346656037u; /* FNV-1a of the word: it may be long */
    hash ^= node->cycle->closed;
    for (int i = 0; i < node->cycle->N; i++) hash = (hash ^ (uint64_t)node->cycle->face[i]) * 1099511628211u;
    int used = snprintf(key, size, "%d %d %d/%d %a %a %u %d %a %a %a %a %a %d %016" PRIx64, (int)node->kind, node->cycle->N, node->rotation[0], node->multiple,
             node->energy, node->period, choice, side,
             l->energy[0], l->energy[1], l->period[0], l->period[1], l->max_step, l->multiply,
             hash);
    if (l->n_asked) snprintf(key + used, size - (size_t)used, " %016" PRIx64, ric_asked_key(l->n_asked, l->asked));
}

/* For later runs, or for the owner of the graph. */
static ric_status keep_trace(ric_graph *g, const char *key, const void *blob, size_t size)
{
    if (ric_starved()) return ric_fail(RIC_E_NOMEM, "no memory for a branch");
    if (g->recall.worker) ric_memo_put(g->recall.memo, key, strlen(key), blob ? blob : "", size);
    return g->store ? ric_store_trace_put(g->store, key, blob ? blob : "", size) : RIC_OK;
}

/* Traces departure `choice` (side -1: the other way, at a branch that passes). RIC_OK with *out = NULL: inadmissible. */
static ric_status trace_departure(ric_graph *g, const ric_node *node, unsigned choice, int side, ric_trace **out)
{
    char key[1024];
    void *blob = NULL;
    size_t size;
    ric_chain *chain = NULL;
    double *u0 = NULL, *t0 = NULL;
    unsigned ignore = 0;
    ric_status status = RIC_OK;
    *out = NULL;
    trace_key(g, node, choice, side, key, sizeof key);
    if (g->store && (status = ric_store_trace_get(g->store, key, &blob, &size))) return status;
    bool stored = blob != NULL;
    if (!blob && g->recall.memo && !g->recall.worker) blob = ric_memo_take(g->recall.memo, key, strlen(key), &size);
    if (blob) {
        status = size ? ric_trace_unpack(g->model, &g->limits, blob, size, out) : RIC_OK;
        if (!status && !stored) status = keep_trace(g, key, blob, size);
        free(blob);
        return status;
    }
    if ((status = ric_node_depart(g->model, node, choice, side, &chain, &u0, &t0, &ignore))) return status;
    if (chain) {
        if ((status = ric_trace_create(chain, u0, t0, ignore, &g->limits, out))) goto out;
        if ((status = ric_trace_run(*out))) goto out;
    }
    if (g->store || g->recall.worker) {
        if (!(status = *out ? ric_trace_pack(*out, &blob, &size) : (size = 0, RIC_OK))) status = keep_trace(g, key, blob, size);
    }
out:
    if (status) {
        ric_trace_free(*out);
        *out = NULL;
    }
    free(blob);
    free(u0);
    free(t0);
    return status;
}

/* Whether the branch stopped because gaps of two contacts closed at one instant. */
static bool at_corner(const ric_trace *tr)
{
    ric_touch touch;
    if (tr->end.test == RIC_TEST_FLIGHT) return true;
    if (tr->end.test != RIC_TEST_REACH) return false;
    ric_chain_fly(tr->chain, tr->end.u);
    ric_reach(tr->chain, tr->end.u, &touch);
    return touch.face >= 0 && touch.kink;
}

/* Whether a branch that ends here can be traced from here. */
static bool departs(const ric_node *node)
{
    return !(ric_node_chooses(node) && node->refusal);
}

/* Which of the branches that leave a multiplication without mirror points this is: its last point before the end tells. */
static ric_status ring_choice(const ric_graph *g, const ric_trace *tr, const ric_node *node, unsigned *choice)
{
    int side;
    const double *last = tr->points + (size_t)(tr->n_point - 2) * tr->stride + sizeof(ric_point) / sizeof(double);
    ric_cycle *near = ric_trace_cycle(tr, last);
    if (!near) return ric_fail(RIC_E_NOMEM, "no memory for a junction");
    ric_status status = ric_ring_class(g->model, node, near, choice, &side);
    ric_cycle_free(near);
    if (status != RIC_E_NUMERIC) return status;
    *choice = RIC_SIDE; /* refused to those who want to leave here, too */
    return RIC_OK;
}

/* Under a power law the end of a branch at a junction, read off cubics, is replaced by the orbit of the junction itself: of its images, as
 * orbits of the branch's own problem, the one that lies there. */
static ric_status end_on_node(const ric_graph *g, ric_trace *tr, const ric_node *node, unsigned choice)
{
    ric_chain *c = tr->chain;
    int size = c->n_unknown;
    double nearest = END_NEAR * c->scale, best[size];
    if (!g->model->smooth || !ric_node_leaves(node, choice)) return RIC_OK;
    ric_problem problem = ric_node_problem(node, choice);
    ric_cycle *whole = ric_problem_cycle(node->cycle, &problem);
    if (!whole) return ric_fail(RIC_E_NOMEM, "no memory for the end of a branch");
    for (int k = 0; k < 4 * whole->N; k++) {
        ric_chain *chain = NULL;
        double *u = NULL, off = 0;
        ric_cycle *image = ric_cycle_transform(g->model, whole, k / 4, k & 1, k & 2);
        bool fits = image && !ric_cycle_to_chain(g->model, image, &chain, &u) && chain->start == c->start && chain->end == c->end;
        for (int i = 0; fits && i < size; i++) off = fmax(off, fabs(u[i] - tr->end.u[i]));
        if (fits && off < nearest) {
            nearest = off;
            memcpy(best, u, sizeof best);
        }
        ric_cycle_free(image);
        ric_chain_free(chain);
        free(u);
    }
    ric_cycle_free(whole);
    if (nearest == END_NEAR * c->scale) return RIC_OK;
    double *last = tr->points + (size_t)(tr->n_point - 1) * tr->stride;
    ric_point *row = (ric_point *)last;
    memcpy(tr->end.u, best, sizeof best);
    memcpy(last + sizeof *row / sizeof *last, best, sizeof best);
    ric_chain_fly(c, best);
    row->energy = ric_chain_energy(c) * g->model->energy_unit;
    row->frequency = TWO_PI / ric_chain_time(c, best) * g->model->omega_ref;
    row->residual = (float)c->residual;
    return RIC_OK;
}

/* The node at the far end of a trace (-1: none) and the departure there that the branch is. */
static ric_status end_node(ric_graph *g, ric_trace *tr, int depth, int *index, unsigned *choice)
{
    ric_status status = RIC_OK;
    ric_node *node = NULL;
    *index = -1;
    *choice = 0;
    if (tr->stop != RIC_STOP_JUNCTION || !tr->end.u) return RIC_OK;
    ric_cycle *cycle = ric_trace_cycle(tr, tr->end.u);
    if (!cycle) return ric_fail(RIC_E_NOMEM, "no memory for a junction");
    ric_solve solve = {.kind = tr->arrival                                                      ? RIC_SOLVE_ARRIVAL
                               : at_corner(tr) || ric_node_coincident(g->model, cycle) ? RIC_SOLVE_CORNER
                                                                                       : RIC_SOLVE_GRAZING};
    status = ric_solve_node(g->model, g->recall, solve, cycle, &node);
    if (status == RIC_E_NUMERIC) {
        tr->stop = RIC_STOP_FAILED;
        tr->why = "the junction at the end does not converge";
        status = RIC_OK;
    }
    if (node) {
        if (node->kind == RIC_KIND_CORNER && node->refusal) tr->stop = RIC_STOP_CORNER;
        *index = find_or_add(g, node, depth);
        if (*index < 0) status = ric_fail(RIC_E_NOMEM, "no memory for a junction");
        else if (ric_node_chooses(g->nodes[*index]) && departs(g->nodes[*index])) {
            int found = ric_subset_choice(g->model, g->nodes[*index], cycle);
            if (found < 0) {
                tr->stop = RIC_STOP_FAILED;
                tr->why = "the branch does not fit the junction at its end";
                *index = -1;
            } else *choice = (unsigned)found;
        } else if (!g->model->smooth && ric_ring_applies(g->nodes[*index], RIC_SIDE)) status = ring_choice(g, tr, g->nodes[*index], choice);
        else *choice = ric_node_chooses(g->nodes[*index]) ? 0 : ric_node_arrived(g->model, g->nodes[*index], cycle);
    }
    if (!status && tr->arrival && *index >= 0) status = end_on_node(g, tr, g->nodes[*index], *choice);
    ric_cycle_free(cycle);
    return status;
}

/* ------------------------------------------------------------------- edges */

static ric_edge *add_edge(ric_graph *g)
{
    if (g->n_edge == g->edge_capacity) {
        int capacity = g->edge_capacity ? 2 * g->edge_capacity : 64;
        ric_edge *grown = realloc(g->edges, (size_t)capacity * sizeof *grown);
        if (!grown) return NULL;
        g->edges = grown;
        g->edge_capacity = capacity;
    }
    ric_edge *e = &g->edges[g->n_edge++];
    *e = (ric_edge){.from = -1, .to = -1, .mode = -1};
    return e;
}

/* Tests whose zeros are junctions on a chain of this form: on a half chain types a and d double the period, which is another matter. */
static bool is_junction(const ric_chain *c, int test)
{
    bool half_chain = c->start != RIC_MIRROR_NONE && c->multiple == 2;
    return !(half_chain && (test == RIC_TEST_A || test == RIC_TEST_D));
}

static bool breaks_or_crosses(int test)
{
    return test == RIC_TEST_DET || test == RIC_TEST_A || test == RIC_TEST_B || test == RIC_TEST_D;
}

/* Which of the ways out of a junction the edge is that passes it; `aside`: as an orbit of several periods, or one without the symmetry of the
 * junction. */
static ric_status passing_choice(const ric_graph *g, const ric_edge *e, const ric_event *event, const ric_node *node, bool aside, unsigned *choice)
{
    int size = e->trace->chain->n_unknown;
    double u[size];
    *choice = aside ? RIC_SIDE : RIC_THROUGH;
    if (node->kind != RIC_KIND_BRANCH_POINT || node->test != RIC_TEST_DET) return RIC_OK;
    for (int i = 0; i < size; i++) u[i] = event->u[i] + RIC_LEAVING * e->trace->chain->scale * event->t[i];
    ric_cycle *near = ric_trace_cycle(e->trace, u);
    ric_status status = near ? ric_crossing_choice(g->model, node, near, choice) : ric_fail(RIC_E_NOMEM, "no memory for a junction");
    ric_cycle_free(near);
    return status == RIC_E_NUMERIC ? RIC_OK : status; /* refused when it is left, with the reason */
}

/* Whether the orbit has a symmetry x -> -x there that neither the branch nor the structure has: the branch passes its mirror image. */
static bool passes_image(const ric_model *m, const ric_cycle *cycle, int test)
{
    ric_cycle *found = !m->symmetric && test == RIC_TEST_DET ? ric_cycle_copy(cycle) : NULL;
    if (found) ric_cycle_find_symmetries(m, found, 1e-5);
    bool more = found && ((found->half && !cycle->half) || (found->flip >= 0 && cycle->flip < 0));
    ric_cycle_free(found);
    return more;
}

static ric_status add_inner(ric_graph *g, ric_edge *e, const ric_event *event)
{
    ric_status status;
    ric_node *node = NULL;
    const double *last = e->trace->points + (size_t)(e->trace->n_point - 1) * e->trace->stride;
    if (!is_junction(e->trace->chain, event->test)) return RIC_OK;
    /* the ends of a branch are junctions of their own */
    double length = ((const ric_point *)last)->arclength;
    if (event->s < AT_END || event->s > length - AT_END) return RIC_OK;
    ric_cycle *cycle = ric_trace_cycle(e->trace, event->u);
    if (!cycle) return ric_fail(RIC_E_NOMEM, "no memory for a junction");
    bool aside = breaks_or_crosses(event->test) && (ric_cycle_repeats(g->model, cycle, 1e-5) || passes_image(g->model, cycle, event->test));
    const ric_asked *asked = ric_trace_asked(e->trace, event->test);
    const ric_resonance *resonance = ric_trace_resonance(e->trace, event->test);
    ric_solve solve = aside       ? (ric_solve){.kind = RIC_SOLVE_ARRIVAL}
                      : asked     ? (ric_solve){.kind = RIC_SOLVE_USER, .asked = *asked}
                      : resonance ? (ric_solve){.kind = RIC_SOLVE_MULTIPLICATION, .p = resonance->p, .q = resonance->q}
                                  : (ric_solve){.kind = RIC_SOLVE_INTERIOR, .test = event->test};
    status = ric_solve_node(g->model, g->recall, solve, cycle, &node);
    ric_cycle_free(cycle);
    if (status == RIC_E_NUMERIC) {
        e->n_unplaced++;
        return RIC_OK;
    }
    if (!node) return status;
    int index = find_or_add(g, node, e->depth);
    if (index < 0) return ric_fail(RIC_E_NOMEM, "no memory for a junction");
    if ((index == e->from && event->s < NEAR_END * length) || (index == e->to && event->s > (1 - NEAR_END) * length)) return RIC_OK;
    for (int i = 0; i < e->n_inner; i++) /* at a q-fold repeated orbit several tests vanish at once */
        if (e->inner[i].node == index && fabs(e->inner[i].at - event->s) < 1e-5 * (1 + event->s)) return RIC_OK;
    unsigned choice;
    if ((status = passing_choice(g, e, event, g->nodes[index], aside, &choice))) return status;
    mark(g, g->nodes[index], choice, RIC_DEPARTURE_KNOWN);
    return ric_edge_attach(e, index, choice, event->s);
}

/* Traces again from the far end, so that what is stored does not depend on which end was found first. */
static ric_status from_smaller_end(ric_graph *g, int from, unsigned leave, int to, unsigned arrive, ric_trace **tr, bool *turned)
{
    ric_trace *back = NULL;
    int home = -1;
    unsigned choice = 0;
    ric_node *a = g->nodes[from], *b = g->nodes[to];
    int order = from == to ? (arrive < leave ? 1 : -1) : -ric_node_order(b, a);
    *turned = false;
    if (order <= 0 || !departs(b)) return RIC_OK;
    ric_status status = trace_departure(g, b, arrive, 1, &back);
    if (status == RIC_E_NUMERIC) return RIC_OK;
    if (!status && back) status = end_node(g, back, 1 << 20, &home, &choice);
    if (status) return status;
    if (!back || home != from || (ric_node_chooses(a) && choice != leave)) {
        (*tr)->stop = RIC_STOP_FAILED;
        (*tr)->why = "the way back does not lead home";
        ric_trace_free(back);
        return RIC_OK;
    }
    ric_trace_free(*tr);
    *tr = back;
    *turned = true;
    return RIC_OK;
}

static ric_status finish_edge(ric_graph *g, ric_trace *tr, int from, unsigned leave, int to, unsigned arrive, int depth, int mode)
{
    ric_status status = RIC_OK;
    ric_edge *e = add_edge(g);
    if (!e) {
        ric_trace_free(tr);
        return ric_fail(RIC_E_NOMEM, "no memory for a branch");
    }
    e->trace = tr;
    e->from = from;
    e->to = to;
    e->leave = leave;
    e->arrive = arrive;
    e->depth = depth;
    e->mode = mode;
    for (int i = 0; i < tr->n_event && !status; i++) status = add_inner(g, e, &tr->events[i]);
    return status;
}

/* A branch has been followed from end to end by the last edge: what an earlier trace from one of its ends left behind, stuck on the way,
 * is a part of it. */
static void supersede(ric_graph *g)
{
    ric_edge *last = &g->edges[g->n_edge - 1];
    if (last->trace->stop == RIC_STOP_FAILED || last->from < 0 || last->to < 0) return;
    for (int i = 0; i < g->n_edge - 1; i++) {
        ric_edge *e = &g->edges[i];
        bool same = (e->from == last->from && e->leave == last->leave) || (e->from == last->to && e->leave == last->arrive);
        if (e->trace->stop != RIC_STOP_FAILED || e->to >= 0 || !same) continue;
        edge_release(e);
        memmove(e, e + 1, (size_t)(g->n_edge - 1 - i) * sizeof *e);
        g->n_edge--;
        return;
    }
}

/* A branch with a real end: from departure `choice` of node `from`. *taken = false when inadmissible. */
static ric_status follow(ric_graph *g, int from, unsigned choice, int depth, bool *taken)
{
    ric_trace *tr = NULL;
    int to;
    unsigned arrive;
    bool turned = false;
    ric_status status = trace_departure(g, g->nodes[from], choice, 1, &tr);
    *taken = tr != NULL;
    if (status || !tr) return status;
    if ((status = end_node(g, tr, depth, &to, &arrive))) goto out;
    if (to >= 0) {
        mark(g, g->nodes[to], arrive, RIC_DEPARTURE_KNOWN);
        if ((status = from_smaller_end(g, from, choice, to, arrive, &tr, &turned))) goto out;
    }
    int mode = g->nodes[from]->mode >= 0 ? g->nodes[from]->mode : to >= 0 ? g->nodes[to]->mode : -1;
    if (turned) status = finish_edge(g, tr, to, arrive, from, choice, depth, mode);
    else status = finish_edge(g, tr, from, choice, to, arrive, depth, mode);
    if (!status) supersede(g);
    return status;
out:
    ric_trace_free(tr);
    return status;
}

/* Traces from the end of `tr` back along it, to its other end. */
static ric_status trace_back(ric_graph *g, const ric_trace *tr, ric_trace **out)
{
    const unsigned ignore = 1u << RIC_TEST_E_MAX | 1u << RIC_TEST_E_MIN | 1u << RIC_TEST_F_MAX | 1u << RIC_TEST_F_MIN |
                            1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH | 1u << RIC_TEST_FLIGHT | 1u << RIC_TEST_A |
                            1u << RIC_TEST_B | 1u << RIC_TEST_D | 1u << RIC_TEST_DET;
    ric_chain *chain = ric_chain_copy(tr->chain);
    double *back = chain ? calloc((size_t)chain->n_unknown, sizeof *back) : NULL;
    *out = NULL;
    if (!back) {
        ric_chain_free(chain);
        return ric_fail(RIC_E_NOMEM, "no memory for a branch");
    }
    for (int i = 0; i < chain->n_unknown; i++) back[i] = -tr->end.t[i];
    ric_status status = ric_trace_create(chain, tr->end.u, back, ignore, &g->limits, out);
    if (!status) status = ric_trace_run(*out);
    free(back);
    if (status) {
        ric_trace_free(*out);
        *out = NULL;
    }
    return status;
}

/* The whole of a branch that passes through a junction: to one end, then from there to the other. */
static ric_status follow_through(ric_graph *g, int inside, unsigned through, int depth)
{
    ric_status status = RIC_OK;
    ric_trace *tr[2] = {NULL, NULL}, *whole = NULL;
    int to[2] = {-1, -1};
    unsigned arrive[2];
    for (int i = 0; i < 2; i++) {
        if ((status = trace_departure(g, g->nodes[inside], through, i ? -1 : 1, &tr[i])) || !tr[i]) goto out;
        if ((status = end_node(g, tr[i], depth, &to[i], &arrive[i]))) goto out;
        if (tr[i]->stop == RIC_STOP_CLOSED) {
            status = finish_edge(g, tr[i], -1, 0, -1, 0, depth, g->nodes[inside]->mode);
            tr[i] = NULL;
            goto out;
        }
        if (to[i] < 0 || !departs(g->nodes[to[i]])) continue;
        bool taken;
        mark(g, g->nodes[to[i]], arrive[i], RIC_DEPARTURE_TAKEN);
        status = follow(g, to[i], arrive[i], depth, &taken);
        goto out;
    }
    /* neither end is a junction that branches depart from */
    int first = tr[0]->end.u ? 0 : 1, far;
    unsigned choice;
    if (!tr[first]->end.u) goto out;
    if ((status = trace_back(g, tr[first], &whole)) || (status = end_node(g, whole, depth, &far, &choice))) goto out;
    if (far >= 0) mark(g, g->nodes[far], choice, RIC_DEPARTURE_KNOWN);
    status = finish_edge(g, whole, to[first], 0, far, choice, depth, g->nodes[inside]->mode);
    whole = NULL;
out:
    ric_trace_free(tr[0]);
    ric_trace_free(tr[1]);
    ric_trace_free(whole);
    return status;
}

/* ----------------------------------------------------------------- exploring */

/* Whether a multiplication is larger than asked for; or, on a cascade, a departure is none of its steps. What starts from a mode, and what goes
 * on beyond a corner, belongs to any. */
static bool astray(const ric_graph *g, const ric_node *node, unsigned choice)
{
    const ric_explore_options *o = g->options;
    if (o->n_cascade == 0) return choice != RIC_THROUGH && (node->multiple > o->multiply || o->base % node->multiple);
    if (node->depth == 0 || node->kind == RIC_KIND_CORNER) return false;
    return node->depth > o->n_cascade || !ric_node_leaves(node, choice) || node->multiple != o->cascade[node->depth - 1];
}

static bool over_budget(const ric_graph *g, const ric_node *node, unsigned choice, ric_budget *which)
{
    /* the original of a duplicate may lie outside the frequency window */
    double period = node->period * (choice != RIC_THROUGH || node->kind == RIC_KIND_GRAZING ? node->multiple : 1);
    *which = period < g->limits.period[0] || period > g->limits.period[1]                         ? RIC_BUDGET_WINDOW
             : astray(g, node, choice)                                                            ? RIC_BUDGET_MULTIPLY
             : ric_node_impacts(node, choice) > g->options->impacts                               ? RIC_BUDGET_IMPACTS
             : g->options->symmetric_only && !ric_node_half(g->model, node, choice)               ? RIC_BUDGET_SYMMETRIC
                                                                                                  : RIC_N_BUDGET;
    return *which != RIC_N_BUDGET;
}

static bool is_linear(const ric_node *node, unsigned choice)
{
    return node->kind == RIC_KIND_GRAZING && ric_node_impacts(node, choice) == 0;
}

static ric_status take(ric_graph *g, int index, int place, int depth)
{
    ric_node *node = g->nodes[index];
    ric_departure *d = &node->departures[place];
    unsigned choice = d->choice;
    ric_status status = RIC_OK;
    if (is_linear(node, choice)) {
        d->state = RIC_DEPARTURE_KNOWN; /* the linear mode itself */
        return RIC_OK;
    }
    if (over_budget(g, node, choice, &d->budget)) {
        d->state = RIC_DEPARTURE_OVER_BUDGET;
        return RIC_OK;
    }
    if (d->job && !ric_workers_await(g->workers, d->job, g->limits.stop, g->limits.user))
        return ric_fail(RIC_E_INTERRUPTED, "stopped on request");
    if (node->kind == RIC_KIND_CORNER) depth--; /* the same branch goes on with two letters exchanged */
    if (ric_node_passes(node, choice)) {
        /* where two branches of one symmetry cross, the edges that pass have said which they are */
        bool crossing = node->kind == RIC_KIND_BRANCH_POINT && node->test == RIC_TEST_DET;
        for (int i = 0; choice == RIC_THROUGH && !crossing && i < g->n_edge; i++) {
            double where;
            /* a branch that ends here has left, it does not pass */
            if (g->edges[i].from == index || g->edges[i].to == index || !ric_edge_contains(g->model, &g->edges[i], node, &where))
                continue;
            d->state = RIC_DEPARTURE_KNOWN;
            return node->kind == RIC_KIND_START ? RIC_OK : ric_edge_attach(&g->edges[i], index, choice, where);
        }
        status = follow_through(g, index, choice, depth);
        node->departures[place].state = RIC_DEPARTURE_TAKEN;
    } else {
        bool taken = false;
        d->state = RIC_DEPARTURE_TAKEN;
        status = follow(g, index, choice, depth, &taken);
        if (!status && !taken) node->departures[place].state = RIC_DEPARTURE_INADMISSIBLE;
    }
    if (ric_starved()) status = ric_fail(RIC_E_NOMEM, "no memory for a branch");
    if (status == RIC_E_INTERRUPTED || status == RIC_E_NOMEM) node->departures[place].state = RIC_DEPARTURE_OPEN;
    if (status == RIC_E_NUMERIC) {
        node->departures[place].state = RIC_DEPARTURE_REFUSED;
        node->departures[place].why = strdup(ric_detail());
        status = RIC_OK;
    }
    return status;
}

typedef struct {
    int index, place;
    const ric_node *node;
} open_departure;

static int departure_order(const void *a, const void *b)
{
    const open_departure *p = a, *q = b;
    int order = p->index == q->index ? 0 : ric_node_order(p->node, q->node);
    if (order) return order;
    return p->index != q->index ? p->index - q->index : p->place - q->place;
}

/* Any order will do: Fisher and Yates' shuffle with the generator xorshift64. */
static void shuffle(uint64_t seed, int n, open_departure *list)
{
    for (int i = n - 1; i > 0; i--) {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        int j = (int)(seed % (uint64_t)(i + 1));
        open_departure moved = list[i];
        list[i] = list[j];
        list[j] = moved;
    }
}

/* Open departures of nodes at `depth`, sorted; NULL with *n = 0 when there is none. At the last depth of the budget only corners: what goes
 * on there is the same branch. */
static open_departure *open_at(ric_graph *g, int depth, bool last, int *n)
{
    int count = 0;
    for (int pass = 0;; pass++) {
        open_departure *list = pass ? malloc((size_t)(count ? count : 1) * sizeof *list) : NULL;
        int k = 0;
        for (int i = 0; i < g->n_node; i++)
            for (int j = 0; j < g->nodes[i]->n_departure; j++) {
                if (g->nodes[i]->depth != depth || g->nodes[i]->departures[j].state != RIC_DEPARTURE_OPEN) continue;
                if (last && g->nodes[i]->kind != RIC_KIND_CORNER) continue;
                if (list) list[k] = (open_departure){i, j, g->nodes[i]};
                k++;
            }
        count = k;
        if (!pass) continue;
        *n = list ? count : 0;
        if (list) qsort(list, (size_t)count, sizeof *list, departure_order);
        return list;
    }
}

/* Grazings at `depth` gone through several times are junctions, too: those from which some branch can leave within the budgets. */
static ric_status list_duplicates(ric_graph *g, int depth)
{
    for (int i = 0; i < g->n_node; i++) {
        ric_node *node = g->nodes[i];
        if (node->kind != RIC_KIND_GRAZING || node->multiple > 1 || node->depth != depth || node->expanded || node->refusal) continue;
        node->expanded = true;
        int flown = ric_cycle_impacts(node->springs, node->cycle) - node->n_touch;
        for (int k = 2; k <= g->options->multiply && k * flown < g->options->impacts && k * node->period <= g->limits.period[1]; k++) {
            ric_node *duplicate = NULL;
            if (g->options->base % k) continue;
            ric_status status = ric_node_duplicate(g->model, node, k, &duplicate);
            if (status) return status;
            if (find_or_add(g, duplicate, depth) < 0) return ric_fail(RIC_E_NOMEM, "no memory for a junction");
            node = g->nodes[i];
        }
    }
    return RIC_OK;
}

/* Under a power law the orbits of a mode at vanishing energy are those of the linear structure. Where the window starts higher, the branch is
 * followed up to there. *out = NULL: it does not come so far. */
static ric_status smooth_start(ric_graph *g, int mode, ric_node **out)
{
    static const int face[] = {-1, -1};
    const ric_model *m = g->model;
    ric_chain *chain = NULL;
    ric_trace *way = NULL;
    ric_cycle *cycle = NULL;
    int n = m->n, iterations;
    double u[n + 1], t[n + 1], du[n + 1], energy = 2 * RIC_LINEAR_ENERGY / m->energy_unit;
    ric_limits limits = g->limits;
    *out = NULL;
    if (m->omega[mode] == 0) return RIC_OK;
    ric_status status = ric_chain_create(m, RIC_MIRROR_CENTRE, RIC_MIRROR_REST, 1, 1, face, &chain);
    if (status) return status;
    memset(u, 0, sizeof u);
    u[mode] = sqrt(2 * energy);
    u[n] = TWO_PI / (4 * m->omega[mode]);
    if (!ric_trace_correct(chain, u, NULL, NULL, 0, du, &iterations)) {
        status = ric_fail(RIC_E_NUMERIC, "the motion of mode %d at small energy does not converge", m->mode[mode] + 1);
        goto out;
    }
    if (energy > limits.energy[0]) cycle = ric_cycle_from_chain(chain, u);
    else {
        limits = (ric_limits){.energy = {0, g->limits.energy[0] * (1 + RIC_LINEAR_ENERGY)}, .period = {0, HUGE_VAL},
                              .max_step = limits.max_step, .max_points = limits.max_points};
        memset(t, 0, sizeof t);
        t[mode] = 1;
        status = ric_trace_create(chain, u, t, 0, &limits, &way);
        chain = NULL;
        if (status || (status = ric_trace_run(way)) || way->end.test != RIC_TEST_E_MAX) goto out;
        cycle = ric_trace_cycle(way, way->end.u);
    }
    status = cycle ? ric_node_start(m, cycle, out) : ric_fail(RIC_E_NOMEM, "no memory for a start");
    if (*out) (*out)->mode = mode;
out:
    ric_cycle_free(cycle);
    ric_trace_free(way);
    ric_chain_free(chain);
    return status;
}

static ric_status start_modes(ric_graph *g)
{
    const ric_model *m = g->model;
    for (int i = 0; i < m->n; i++) {
        ric_node *node = NULL;
        bool wanted = g->options->n_start == 0;
        for (int j = 0; j < g->options->n_start; j++) wanted |= g->options->start[j] == m->mode[i] + 1;
        if (!wanted) continue;
        ric_status status = m->smooth ? smooth_start(g, i, &node) : ric_node_linear(m, i, &node);
        if (status) return status;
        if (!node) continue;
        if (node->energy > g->limits.energy[1]) {
            ric_node_free(node);
            continue;
        }
        if (find_or_add(g, node, 0) < 0) return ric_fail(RIC_E_NOMEM, "no memory for a junction");
    }
    return RIC_OK;
}

/* A loose mass in a gap (a seen mode of zero frequency) has no linear grazing. Its S2 orbits have a closed form (docs/theory.md section
 * 11): q_i = A c_i sin(omega_i t) / (omega_i cos(omega_i h / 2)) from the centre, h half a period, A from s(h/2) = d. It is scanned over
 * the frequency window; every stretch of admissible orbits gives a start, from which its branch is followed both ways. */
static void closed_form(const ric_model *m, const ric_face *f, double omega, double *u)
{
    int n = m->n;
    double sum = 0, quarter = TWO_PI / (4 * omega);
    for (int k = 0; k < n; k++) {
        double x = m->omega[k] * quarter;
        sum += f->c[k] * f->c[k] * (m->omega[k] > 0 ? tan(x) / m->omega[k] : quarter);
        u[k] = f->c[k] / cos(x);
    }
    for (int k = 0; k < n; k++) u[k] *= f->gap / sum;
    u[n] = quarter;
}

#define SCAN 1.01 /* ratio of neighbouring frequencies of the scan */

static ric_status start_stretch(ric_graph *g, ric_chain *chain, const double *u)
{
    ric_chain_fly(chain, u);
    ric_cycle *cycle = ric_cycle_from_chain(chain, u);
    ric_node *node = NULL;
    if (!cycle) return ric_fail(RIC_E_NOMEM, "no memory for a start");
    ric_status status = ric_node_start(g->model, cycle, &node);
    ric_cycle_free(cycle);
    if (status == RIC_E_NUMERIC) return RIC_OK;
    if (!status && find_or_add(g, node, 0) < 0) status = ric_fail(RIC_E_NOMEM, "no memory for a start");
    return status;
}

static ric_status start_loose(ric_graph *g)
{
    const ric_model *m = g->model;
    int n = m->n, upper = -1, face[2] = {-1, -1};
    bool loose = false, inside = false;
    for (int i = 0; i < n; i++) loose |= m->omega[i] == 0;
    for (int f = 0; f < m->n_face && upper < 0; f++)
        if (m->face[f].mirror >= 0 && m->face[f].side > 0) upper = f;
    if (!loose || upper < 0 || m->n_contact > 1) return RIC_OK;
    if (m->springs)
        return ric_fail(RIC_E_INPUT, "the structure can move as a rigid body against a contact of law bilinear: such families have no closed form to "
                        "start from in this version; hold the structure by a soft spring, or make the contact rigid");
    ric_chain *chain = NULL;
    face[1] = upper;
    ric_status status = ric_chain_create(m, RIC_MIRROR_CENTRE, RIC_MIRROR_IMPACT, 1, 1, face, &chain);
    double u[n + 1], low = isfinite(g->limits.period[1]) ? TWO_PI / g->limits.period[1] : 1e-3;
    for (double omega = low; !status && omega < TWO_PI / g->limits.period[0]; omega *= SCAN) {
        closed_form(m, &m->face[upper], omega, u);
        ric_chain_fly(chain, u);
        double energy = ric_chain_energy(chain);
        bool good = energy > g->limits.energy[0] && energy < g->limits.energy[1] && chain->residual < 1e-9 && chain->approach[1] > 0 &&
                    ric_reach(chain, u, NULL) < 1;
        if (good && !inside) status = start_stretch(g, chain, u);
        inside = good;
    }
    ric_chain_free(chain);
    return status;
}

/* Orbits given from outside, such as those that a hunt has found. One that is no orbit to this version is left out. */
static ric_status start_given(ric_graph *g)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < g->starts.n && !status; i++) {
        ric_cycle *cycle = NULL;
        ric_node *node = NULL;
        status = ric_start_solve(g->model, g->starts.cycle[i], &cycle);
        if (!status) status = ric_node_start(g->model, cycle, &node);
        ric_cycle_free(cycle);
        if (status == RIC_E_NUMERIC) status = RIC_OK;
        else if (!status && (node->energy < g->limits.energy[0] || node->energy > g->limits.energy[1])) ric_node_free(node);
        else if (!status && find_or_add(g, node, 0) < 0) status = ric_fail(RIC_E_NOMEM, "no memory for a start");
    }
    return status;
}

static double seconds_since(const struct timespec *start)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - start->tv_sec) + 1e-9 * (double)(now.tv_nsec - start->tv_nsec);
}

/* Now and then what was traced is made safe against a kill. */
static ric_status save_now_and_then(ric_graph *g, double *saved)
{
    double now = seconds_since(&g->start);
    if (!g->store || now - *saved < SAVE_EVERY) return RIC_OK;
    *saved = now;
    return ric_store_commit(g->store);
}

/* Shows how far the owner has come and asks whether to stop. */
static bool stopped(void *user)
{
    ric_graph *g = user;
    if (!g->run || !g->run->progress) return false;
    g->progress.branches = g->n_edge;
    g->progress.junctions = g->n_node;
    g->progress.seconds = seconds_since(&g->start);
    if (g->run->progress(&g->progress, g->run->user)) g->stopping = true;
    return g->stopping;
}

/* The same for a worker, who follows the owner. */
static bool owner_stopped(void *user)
{
    return ((ric_graph *)user)->stopping;
}

static void refuse_all(ric_graph *g, const char *why)
{
    for (int i = 0; i < g->n_node; i++)
        for (int j = 0; j < g->nodes[i]->n_departure; j++) {
            bool linear = ric_node_impacts(g->nodes[i], g->nodes[i]->departures[j].choice) == 0;
            g->nodes[i]->departures[j].state = linear ? RIC_DEPARTURE_KNOWN : RIC_DEPARTURE_REFUSED;
            g->nodes[i]->departures[j].why = linear ? NULL : strdup(why);
        }
}

void ric_graph_prepare(void *graph, ric_node *node, unsigned choice)
{
    ric_forget_hunger();
    ric_graph *g = graph;
    ric_graph *alone = calloc(1, sizeof *alone);
    ric_node **nodes = malloc(sizeof *nodes);
    if (alone && nodes) {
        *alone = (ric_graph){.model = g->model, .options = g->options, .limits = g->limits, .recall = {g->recall.memo, true},
                             .nodes = nodes, .n_node = 1, .node_capacity = 1};
        alone->limits.stop = owner_stopped;
        alone->limits.user = g;
        nodes[0] = node;
        for (int i = 0; i < node->n_departure; i++) node->departures[i].job = 0;
        for (int i = 0; i < node->n_departure; i++)
            if (node->departures[i].choice == choice) take(alone, 0, i, 1); /* an error is met again by the owner */
        ric_graph_free(alone);
    } else {
        ric_node_free(node);
        free(nodes);
        free(alone);
    }
}

/* Whether an earlier run has followed the departure. */
static bool followed_before(ric_graph *g, const ric_node *node, unsigned choice)
{
    char key[1024];
    void *blob = NULL;
    size_t size;
    if (!g->store) return false;
    trace_key(g, node, choice, 1, key, sizeof key);
    bool found = !ric_store_trace_get(g->store, key, &blob, &size) && blob;
    free(blob);
    return found;
}

/* What the owner comes to next. Of a branch that passes, the owner may know an edge that it is part of. */
static void offer(ric_graph *g, int n, const open_departure *list)
{
    for (int i = 0; g->workers && i < n; i++) {
        ric_node *node = g->nodes[list[i].index];
        ric_departure *d = &node->departures[list[i].place];
        bool passes = d->choice == RIC_THROUGH && ric_node_passes(node, d->choice);
        if (d->state == RIC_DEPARTURE_OPEN && !d->job && !passes && !is_linear(node, d->choice) && !over_budget(g, node, d->choice, &d->budget) &&
            !followed_before(g, node, d->choice))
            d->job = ric_workers_offer(g->workers, node, d->choice);
    }
}

/* Departures of the next depth as far as they are known, so that no worker is idle while the last ones of this depth are followed. */
static void offer_ahead(ric_graph *g, int depth, int limit)
{
    int n;
    if (!g->workers || depth + 1 > limit || ric_workers_waiting(g->workers) > 0) return;
    open_departure *list = open_at(g, depth + 1, depth + 1 == limit, &n);
    offer(g, n, list);
    free(list);
}

static ric_status explore(ric_graph *g, const ric_run_options *run)
{
    clock_gettime(CLOCK_MONOTONIC, &g->start);
    g->run = run;
    g->stopping = false;
    ric_forget_hunger();
    g->limits.stop = stopped;
    g->limits.user = g;
    ric_status status = g->only_given ? RIC_OK : start_modes(g);
    if (status) return status;
    if (g->model->n_part > 1) {
        refuse_all(g, "the structure falls into parts that no contact joins: their energies are conserved one by one; study each part alone");
        return RIC_OK;
    }
    if (!g->only_given && (status = start_loose(g))) return status;
    if ((status = start_given(g))) return status;
    double saved = 0;
    int limit = g->options->depth > 0 ? g->options->depth : 1 << 20;
    for (int depth = 0; depth <= limit && !status; depth++) {
        int n = 0;
        bool deeper = false;
        do {
            /* edges found at this depth may add nodes of the same depth (a branch met from its side): repeat until none is open */
            if (depth < limit && !g->options->n_cascade && (status = list_duplicates(g, depth))) break;
            open_departure *list = open_at(g, depth, depth == limit, &n);
            if (g->shuffle) shuffle(g->shuffle, n, list);
            offer(g, n, list);
            for (int i = 0; i < n && !status; i++) {
                if (g->nodes[list[i].index]->departures[list[i].place].state != RIC_DEPARTURE_OPEN) continue;
                g->progress.open = n - i;
                g->progress.depth = depth;
                if (stopped(g)) status = ric_fail(RIC_E_INTERRUPTED, "stopped on request");
                else status = take(g, list[i].index, list[i].place, depth + 1);
                if (!status) status = save_now_and_then(g, &saved);
                offer_ahead(g, depth, limit);
            }
            free(list);
        } while (n && !status);
        for (int i = 0; i < g->n_node; i++) deeper |= g->nodes[i]->depth > depth;
        if (!deeper) break;
    }
    if (!status && ric_starved()) status = ric_fail(RIC_E_NOMEM, "no memory for an atlas");
    return status ? status : ric_graph_settle(g);
}

ric_status ric_graph_explore(ric_graph *g, const ric_run_options *run)
{
    ric_status status = RIC_OK;
    g->n_worker = run && run->workers > 1 ? run->workers : 1;
    if (g->n_worker > 1 || g->crew) {
        if ((status = ric_memo_create(&g->recall.memo))) goto out;
        if ((status = ric_workers_create(g->n_worker, ric_graph_prepare, g, &g->workers))) goto out;
    }
    if (g->crew && (status = g->crew->join(g->crew->user, g->study, g->workers, g->recall.memo))) goto out;
    status = explore(g, run);
    if (g->crew) g->crew->leave(g->crew->user);
out:
    ric_workers_free(g->workers);
    ric_memo_free(g->recall.memo);
    g->workers = NULL;
    g->recall.memo = NULL;
    return status;
}
