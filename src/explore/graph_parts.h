/* What the files of the graph share: graph.c (nodes and edges), graph_roots.c (where it begins),
 * graph_trace.c (from a departure to a trace), graph_follow.c (and to an edge), graph_schedule.c
 * (the order of work). No other file needs it. */
#ifndef RIC_EXPLORE_GRAPH_PARTS_H
#define RIC_EXPLORE_GRAPH_PARTS_H

#include "graph.h"
#include "stored_work.h"

/* In the memo, where workers find what the store has of traces that were broken off: before their
 * keys. */
#define RIC_LENT "lent "

/* Takes over `node`: the known one that it equals, or a new one. -1: no memory. */
int ric_graph_add(ric_graph *graph, ric_node *node, int depth);
/* Takes over a node that no other equals, whose departures are listed. -1: no memory. */
int ric_graph_append(ric_graph *graph, ric_node *node);
/* The state of departure `choice` of a node, unless it has been taken. */
void ric_graph_mark(ric_graph *graph, ric_node *node, unsigned choice, ric_departure_state state);
/* An empty edge, the last of the list; NULL: no memory. */
ric_edge *ric_graph_add_edge(ric_graph *graph);
void ric_graph_edge_release(ric_edge *edge);
/* An edge that goes back over its own image has met, in between, an orbit with a symmetry more than
 * it has, where it should have ended: its trace says that events may be missing there. */
void ric_graph_edge_returning(const ric_graph *graph, ric_edge *edge);

/* The nodes from which everything else is reached. */
ric_status ric_graph_start(ric_graph *graph);

/* Refused (RIC_E_NUMERIC): a branch that is lost before it has left its start. */
ric_status ric_graph_has_left(const ric_continuation *trace);
/* Traces departure `choice` (side -1: the other way, at a branch that passes). RIC_OK with *out =
 * NULL: inadmissible. A branch that comes to a region with multiplications of higher order is
 * traced again, with an eye on them. */
ric_status ric_graph_trace(ric_graph *graph, const ric_node *node, unsigned choice, int side,
                           ric_continuation **out);
/* From the end of `along`, such a trace, the way back and on to the other end; in regions as well.
 */
ric_status ric_graph_trace_back(ric_graph *graph, const ric_node *node, unsigned choice, int side,
                                const ric_continuation *along, ric_continuation **out);

/* A branch with a real end: from departure `choice` of node `from`. *taken = false when
 * inadmissible. */
ric_status ric_graph_follow(ric_graph *graph, int from, unsigned choice, int depth, bool *taken);
/* The whole of a branch that passes through a junction: to one end, then from there to the other.
 */
ric_status ric_graph_follow_through(ric_graph *graph, int inside, unsigned through, int depth);
/* Whether an earlier run has followed the departure. */
bool ric_graph_followed_before(ric_graph *graph, const ric_node *node, unsigned choice);

#endif
