/* The graph while it is explored: nodes (junctions) and edges (branches). chart.h turns it into the atlas that users read. */
#ifndef RIC_GRAPH_H
#define RIC_GRAPH_H

#include "crew.h"
#include "node.h"
#include "solve.h"
#include "store.h"

typedef struct {
    ric_trace *trace;
    int from, to;            /* nodes, -1 = none */
    unsigned leave, arrive;  /* choices at them */
    int n_inner;
    int *inner;              /* nodes passed, in order */
    double *inner_at;
    int depth, mode;         /* mode: linear mode whose backbone this is, from 0; -1 */
} ric_edge;

typedef struct {
    const ric_study *study;
    const ric_model *model;
    const ric_explore_options *options;
    ric_limits limits;
    ric_store *store;        /* traces of an earlier run; may be NULL */
    ric_recall recall;       /* what workers have computed */
    const ric_crew *crew;    /* NULL: nobody beside the threads of this process */
    int n_worker;            /* the owner among them */
    ric_workers *workers;    /* NULL: none beside the owner */
    int n_node, node_capacity;
    ric_node **nodes;
    int n_edge, edge_capacity;
    ric_edge *edges;
} ric_graph;

ric_status ric_graph_create(const ric_study *study, ric_store *store, ric_graph **out);
void ric_graph_free(ric_graph *graph);

/* Everything within the study's budgets; `run` may be NULL. RIC_E_INTERRUPTED leaves a consistent, unfinished graph. */
ric_status ric_graph_explore(ric_graph *graph, const ric_run_options *run);
/* A worker's part: the departure is taken on a graph of its own, for the sake of what that leaves in the memo. Takes over the node. */
void ric_graph_prepare(void *graph, ric_node *node, unsigned choice);

/* A trace as bytes that another run can take up, and back (bit for bit). */
ric_status ric_trace_pack(const ric_trace *trace, void **blob, size_t *size);
ric_status ric_trace_unpack(const ric_model *model, const ric_limits *limits, const void *blob, size_t size, ric_trace **out);

#endif
