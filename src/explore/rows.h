/* From the explored graph to the records of an atlas: names, order, ids, full orbits. */
#ifndef RIC_EXPLORE_ROWS_H
#define RIC_EXPLORE_ROWS_H

#include "atlas/room.h"
#include "graph.h"

/* Labels that are in the store of the graph are taken from there, others are measured and put
 * there. When a stop is asked for (ric_graph_stopped) the rest stays unmeasured, and the atlas
 * unfinished. */
ric_status ric_rows_make(ric_graph *graph, const ric_study *study, bool finished, ric_atlas **out);

#endif
