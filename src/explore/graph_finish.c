/* What is left to say once a graph is explored: which departures are known, and which of the ways
 * to a branch counts as taken. */
#include "graph.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define ON_ENERGY 1e-13 /* of 1 + energy: an orbit that near to the energy of a junction has it */

/* ---------------------------------------------------------------- passages */

ric_status ric_graph_edge_attach(ric_edge *e, int node, unsigned choice, double at)
{
    ric_passage *inner = ric_realloc(e->inner, (size_t)(e->n_inner + 1) * sizeof *inner);
    if (!inner) return ric_no_memory("a junction");
    e->inner = inner;
    int place = e->n_inner++;
    for (; place > 0 && inner[place - 1].at > at; place--) inner[place] = inner[place - 1];
    inner[place] = (ric_passage){node, choice, at};
    return RIC_OK;
}

/* Whether an edge passes through the orbit of a node; its arclength there. */
bool ric_graph_edge_contains(const ric_model *m, const ric_edge *e, const ric_node *node,
                             double *at)
{
    ric_continuation *tr = e->trace;
    ric_shooting *c = tr->chain;
    int size = c->n_unknown, iterations;
    bool found = false;
    ric_turn turn;
    if (tr->n_point < 2) return false;
    double target = node->energy * m->energy_unit, du[size], u[size], t[size];
    if (target < e->energy[0] || target > e->energy[1] ||
        !ric_periodic_alike(m, node->cycle, e->first))
        return false;
    for (int i = 0; i + 1 < tr->n_point && !found; i++) {
        const ric_point *a = ric_continuation_row(tr, i);
        const ric_point *b = ric_continuation_row(tr, i + 1);
        if ((a->energy - target) * (b->energy - target) > 0 || a->energy == b->energy ||
            ric_leap_behind(tr, i))
            continue;
        const double *ua = (const double *)(a + 1), *ub = (const double *)(b + 1);
        double x = (target - a->energy) / (b->energy - a->energy), step = 0;
        for (int j = 0; j < size; j++) {
            u[j] = ua[j] + x * (ub[j] - ua[j]);
            t[j] = ub[j] - ua[j];
            step += t[j] * t[j];
        }
        for (int k = 0; k < 12; k++) {
            double origin[size];
            memcpy(origin, u, sizeof origin);
            if (!ric_continuation_correct(c, u, origin, t, 0, du, &iterations)) break;
            double slope, kernel[size], miss = ric_shooting_energy(c) - node->energy;
            ric_continuation_tangent(c, t, kernel);
            slope = ric_shooting_energy_slope(c, kernel);
            if (fabs(miss) < ON_ENERGY * (1 + node->energy) || slope == 0 ||
                fabs(miss / slope) > 2 * sqrt(step))
                break;
            for (int j = 0; j < size; j++) u[j] -= miss / slope * kernel[j];
        }
        ric_periodic *cycle = ric_continuation_cycle(tr, u);
        found = cycle && ric_periodic_match(m, node->cycle, cycle, RIC_SAME_EXTRAPOLATED, &turn);
        ric_periodic_free(cycle);
        *at = a->arclength + x * (b->arclength - a->arclength);
    }
    return found;
}

/* ---------------------------------------------------------------- settling */

/* Through which junctions an edge is known to pass, [n_node]; allocated. */
static bool *passed_nodes(const ric_graph *g)
{
    bool *passed = ric_calloc((size_t)g->n_node + 1, sizeof *passed);
    for (int i = 0; passed && i < g->n_edge; i++)
        for (int k = 0; k < g->edges[i].n_inner; k++) {
            const ric_passage *p = &g->edges[i].inner[k];
            if (p->node >= 0 && p->choice == RIC_THROUGH) passed[p->node] = true;
        }
    return passed;
}

/* The branch that passes a junction, if an edge is that branch: one that was followed from
 * elsewhere, or through the junction with nothing on it that showed the junction, does not list it
 * yet. Where two branches of one symmetry cross the edges have said which they are. */
static ric_status find_passage(ric_graph *g, int index, ric_departure *d, bool *passed)
{
    const ric_node *node = g->nodes[index];
    double at;
    if (d->choice != RIC_THROUGH || !ric_node_passes(node, d->choice) ||
        node->kind == RIC_KIND_START || passed[index])
        return RIC_OK;
    if (node->kind == RIC_KIND_BRANCH_POINT && node->test == RIC_TEST_DET) return RIC_OK;
    for (int i = 0; i < g->n_edge; i++) {
        ric_edge *e = &g->edges[i];
        if (e->from == index || e->to == index || !ric_graph_edge_contains(g->model, e, node, &at))
            continue;
        if (ric_halted()) return RIC_OK; /* it may be none; the caller asks, too */
        d->state = RIC_DEPARTURE_KNOWN;
        passed[index] = true;
        return ric_graph_edge_attach(e, index, d->choice, at);
    }
    return RIC_OK;
}

static void set_state(ric_node *node, unsigned choice, ric_departure_state state)
{
    for (int i = 0; i < node->n_departure; i++)
        if (node->departures[i].choice == choice) node->departures[i].state = state;
}

/* Of the ways to an edge the one that is fewest departures from the start; an end before a passage,
 * then the smaller node. */
static void choose_way(ric_graph *g, const ric_edge *e)
{
    const ric_passage ends[2] = {{e->from, e->leave, 0}, {e->to, e->arrive, 0}};
    int best = -1;
    unsigned choice = 0;
    for (int i = 0; i < 2 + e->n_inner; i++) {
        const ric_passage *p = i < 2 ? &ends[i] : &e->inner[i - 2];
        if (p->node < 0 || g->nodes[p->node]->n_departure == 0) continue;
        int order = best < 0 ? -1 : g->nodes[p->node]->depth - g->nodes[best]->depth;
        if (order == 0 && i < 2) order = ric_graph_node_order(g->nodes[p->node], g->nodes[best]);
        if (order == 0 && i >= 2 && best != e->from && best != e->to)
            order = ric_graph_node_order(g->nodes[p->node], g->nodes[best]);
        if (order >= 0) continue;
        best = p->node;
        choice = p->choice;
    }
    if (best >= 0) set_state(g->nodes[best], choice, RIC_DEPARTURE_TAKEN);
}

ric_status ric_graph_settle(ric_graph *g)
{
    bool *passed = passed_nodes(g);
    ric_status status = passed ? RIC_OK : ric_no_memory("a graph");
    for (int i = 0; i < g->n_node && !status; i++)
        for (int j = 0; j < g->nodes[i]->n_departure && !status; j++) {
            ric_departure *d = &g->nodes[i]->departures[j];
            status = ric_trust(find_passage(g, i, d, passed));
            if (!status && d->state == RIC_DEPARTURE_OPEN) {
                d->state = RIC_DEPARTURE_OVER_BUDGET;
                d->budget = RIC_BUDGET_DEPTH;
            }
            if (d->state == RIC_DEPARTURE_TAKEN && g->nodes[i]->kind != RIC_KIND_START)
                d->state = RIC_DEPARTURE_KNOWN;
        }
    for (int i = 0; i < g->n_edge && !status; i++) choose_way(g, &g->edges[i]);
    free(passed);
    return status;
}
