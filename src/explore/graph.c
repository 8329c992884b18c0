#include "graph_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "junction/room.h"

/* ORDERED: relative: nodes nearer in energy or period are put in order by what cannot be rounded */
#define ORDERED 1e-8
#define MAX_POINTS 200000

/* ------------------------------------------------------------------- create */

ric_status ric_graph_create(const ric_study *study, ric_store *store, ric_graph **out)
{
    const ric_model *m = ric_study_model(study);
    const ric_explore_options *o = ric_study_options(study);
    ric_graph *g = ric_calloc(1, sizeof *g);
    *out = NULL;
    if (!g) return ric_no_memory("an atlas");
    g->study = study;
    g->model = m;
    g->options = o;
    g->store = store;
    double energy[2], frequency[2];
    ric_region_window(o, energy, frequency);
    g->largest = ric_region_largest(o);
    g->limits = ric_continuation_limits(m, energy, frequency, o->max_step, MAX_POINTS);
    g->limits.multiply = o->multiply;
    g->limits.tongue_width = o->cross_tongues ? o->tongue_width : 0;
    g->limits.n_asked = ric_user_point_list(o, g->limits.asked);
    for (int i = 0; i < o->n_cascade; i++)
        g->limits.multiply = o->cascade[i] > g->limits.multiply ? o->cascade[i]
                                                                : g->limits.multiply;
    g->deep = g->limits;
    g->deep.multiply = g->largest.multiply;
    *out = g;
    return RIC_OK;
}

void ric_graph_edge_release(ric_edge *e)
{
    ric_continuation_free(e->trace);
    ric_periodic_free(e->first);
    free(e->inner);
    free(e->unplaced);
}

void ric_graph_free(ric_graph *g)
{
    if (!g) return;
    for (int i = 0; i < g->n_node; i++) ric_node_free(g->nodes[i]);
    for (int i = 0; i < g->n_edge; i++) ric_graph_edge_release(&g->edges[i]);
    ric_starts_release(&g->starts);
    free(g->nodes);
    free(g->by_energy);
    free(g->edges);
    free(g);
}

/* -------------------------------------------------------------------- nodes */

int ric_graph_node_order(const ric_node *a, const ric_node *b)
{
    double de = a->energy - b->energy, dt = a->period - b->period;
    if (fabs(de) > ORDERED * (fabs(a->energy) + fabs(b->energy))) return de < 0 ? -1 : 1;
    if (a == b) return 0;
    int na = a->cycle->N - a->n_touch, nb = b->cycle->N - b->n_touch;
    if (na != nb) return na < nb ? -1 : 1;
    if (fabs(dt) > ORDERED * (a->period + b->period)) return dt > 0 ? -1 : 1;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    if (a->multiple != b->multiple) return a->multiple - b->multiple;
    if (a->rotation[0] != b->rotation[0]) return a->rotation[0] - b->rotation[0];
    if (a->cycle->N != b->cycle->N) return a->cycle->N - b->cycle->N;
    return ric_periodic_compare(a->springs, a->cycle,
                                b->cycle); /* images of each other under what is no symmetry of the
                                              whole structure */
}

/* The first place of `by_energy` whose node has at least this energy. */
static int place_of(const ric_graph *g, double energy)
{
    int low = 0, high = g->n_node;
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (g->nodes[g->by_energy[middle]]->energy < energy) low = middle + 1;
        else high = middle;
    }
    return low;
}

/* The known node that equals this one, the first of them, or -1. */
static int known(const ric_graph *g, const ric_node *node)
{
    int found = -1;
    double near = 2 * ric_node_near(node->energy);
    for (int k = place_of(g, node->energy - near); k < g->n_node; k++) {
        int i = g->by_energy[k];
        if (g->nodes[i]->energy > node->energy + near) break;
        if ((found < 0 || i < found) && ric_node_same(g->model, g->nodes[i], node)) found = i;
    }
    return found;
}

static bool make_room(ric_graph *g)
{
    if (g->n_node < g->node_capacity) return true;
    int capacity = g->node_capacity ? 2 * g->node_capacity : 64;
    ric_node **nodes = ric_realloc(g->nodes, (size_t)capacity * sizeof *nodes);
    if (nodes) g->nodes = nodes;
    int *by_energy = nodes ? ric_realloc(g->by_energy, (size_t)capacity * sizeof *by_energy) : NULL;
    if (by_energy) g->by_energy = by_energy;
    if (by_energy) g->node_capacity = capacity;
    return by_energy;
}

int ric_graph_append(ric_graph *g, ric_node *node)
{
    if (!make_room(g)) {
        ric_node_free(node);
        return -1;
    }
    int place = place_of(g, node->energy);
    memmove(g->by_energy + place + 1, g->by_energy + place,
            (size_t)(g->n_node - place) * sizeof *g->by_energy);
    g->by_energy[place] = g->n_node;
    g->nodes[g->n_node] = node;
    return g->n_node++;
}

int ric_graph_add(ric_graph *g, ric_node *node, int depth)
{
    int found = known(g, node);
    if (found >= 0) {
        ric_node_free(node);
        if (depth < g->nodes[found]->depth) g->nodes[found]->depth = depth;
        return found;
    }
    /* the ways out of a grazing that a worker comes to are the owner's to list */
    bool listed = !ric_node_chooses(node) || (node->kind == RIC_KIND_CORNER && node->refusal) ||
                  (node->kind == RIC_KIND_GRAZING && g->owner) ||
                  ric_grazing_words_list(g->model, node);
    if (!listed) {
        ric_node_free(node);
        return -1;
    }
    node->depth = depth;
    return ric_graph_append(g, node);
}

void ric_graph_mark(ric_graph *g, ric_node *node, unsigned choice, ric_departure_state state)
{
    for (int i = 0; i < node->n_departure; i++) {
        ric_departure *d = &node->departures[i];
        if (d->choice != choice || d->state == RIC_DEPARTURE_TAKEN) continue;
        d->state = state;
        if (d->job) ric_workers_withdraw(g->workers, d->job);
    }
}

/* -------------------------------------------------------------------- edges */

ric_edge *ric_graph_add_edge(ric_graph *g)
{
    if (g->n_edge == g->edge_capacity) {
        int capacity = g->edge_capacity ? 2 * g->edge_capacity : 64;
        ric_edge *grown = ric_realloc(g->edges, (size_t)capacity * sizeof *grown);
        if (!grown) return NULL;
        g->edges = grown;
        g->edge_capacity = capacity;
    }
    ric_edge *e = &g->edges[g->n_edge++];
    *e = (ric_edge){.from = -1, .to = -1, .mode = -1};
    return e;
}
