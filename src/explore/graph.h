/* The graph while it is explored: nodes (junctions) and edges (branches). rows.h turns it into the
 * atlas that users read. */
#ifndef RIC_EXPLORE_GRAPH_H
#define RIC_EXPLORE_GRAPH_H

#include <stdatomic.h>
#include <time.h>

#include "remote.h"
#include "junction/room.h"
#include "study/room.h"
#include "start.h"
#include "atlas/room.h"

/* A node that an edge passes, as the way out `choice` of it. */
typedef struct {
    int node;
    unsigned choice;
    double at; /* arclength */
} ric_passage;

/* An event whose junction does not converge. */
typedef struct {
    int test, p, q;           /* q = 0: no multiplication */
    double energy, frequency; /* as the atlas has them */
} ric_unplaced;

typedef struct {
    ric_continuation *trace;
    int from, to;           /* nodes, -1 = none */
    unsigned leave, arrive; /* choices at them */
    int n_inner;
    ric_passage *inner; /* in order */
    int n_unplaced;
    ric_unplaced *unplaced; /* in order */
    double energy[2];       /* least and largest of its points */
    ric_periodic *first;    /* its first orbit, owned: the word is that of all */
    int depth, mode;        /* mode: linear mode whose backbone this is, from 0; -1 */
} ric_edge;

typedef struct ric_graph ric_graph;
struct ric_graph {
    const ric_study *study;
    const ric_model *model;
    const ric_explore_options *options;
    ric_limits limits;
    ric_limits
        deep; /* the same with the largest multiply of a region: for branches that come there */
    ric_budgets largest;
    ric_store *store;           /* traces of an earlier run; may be NULL */
    const char *labels;         /* that finished atlases of the file have shown (junction_labels.c);
                                   borrowed, may be NULL */
    ric_node_cache recall;      /* what workers have computed */
    const ric_remote *crew;     /* NULL: nobody beside the threads of this process */
    const ric_run_options *run; /* of the present exploration; may be NULL */
    ric_progress progress;
    struct timespec start;
    atomic_bool stopping; /* somebody asked to stop */
    atomic_int fresh; /* steps, traces and labels that this exploration has added to what is kept */
    ric_graph *owner; /* of a worker's graph; NULL: it is the owner's own */
    int n_worker;     /* departures that are followed at a time */
    ric_workers *workers; /* NULL: none beside the owner */
    ric_starts starts;    /* orbits given to start from, owned */
    bool only_given;      /* from these alone, not from the modes */
    int n_node, node_capacity;
    ric_node **nodes;
    int *by_energy; /* the same, by increasing energy */
    int n_edge, edge_capacity;
    ric_edge *edges;
    long counted;     /* points of the branches that count to explore.points */
    uint64_t shuffle; /* 0; else departures of one depth are taken in another order: for tests,
                         which expect the same atlas */
};

ric_status ric_graph_create(const ric_study *study, ric_store *store, ric_graph **out);
void ric_graph_free(ric_graph *graph);

/* Everything within the study's budgets; `run` may be NULL. RIC_E_INTERRUPTED leaves a consistent,
 * unfinished graph. */
ric_status ric_graph_explore(ric_graph *graph, const ric_run_options *run);
/* Shows whoever runs the exploration how far it is, and asks whether to stop. */
bool ric_graph_stopped(ric_graph *graph);
/* A worker's part: the departure is taken on a graph of its own, for the sake of what that leaves
 * in the memo. Takes over the node. */
void ric_graph_prepare(void *graph, ric_node *node, unsigned choice);

/* Smallest first: energy, then impacts, then period. */
int ric_graph_node_order(const ric_node *a, const ric_node *b);

/* Lists a node that the edge passes, in order of arclength. */
ric_status ric_graph_edge_attach(ric_edge *edge, int node, unsigned choice, double at);
/* Whether an edge passes through the orbit of a node; its arclength there. */
bool ric_graph_edge_contains(const ric_model *model, const ric_edge *edge, const ric_node *node,
                             double *at);
/* Brings the departures of the finished graph to a state that does not depend on the order of work:
 * nothing is open, what an edge passes is known, and of the ways to an edge one counts as taken. */
ric_status ric_graph_settle(ric_graph *graph);

#endif
