/* From the explored graph to the records of an atlas: names, order, ids, full orbits. */
#ifndef RIC_CHART_H
#define RIC_CHART_H

#include "atlas.h"
#include "graph.h"

ric_status ric_chart(const ric_graph *graph, const ric_study *study, bool finished, ric_atlas **out);

/* The same, and meanwhile, on some thread, beside(user, atlas) is called once, if there is one: the branches of the
 * atlas are done, and its junctions, whose labels take all workers, are not there yet. */
ric_status ric_chart_beside(const ric_graph *graph, const ric_study *study, bool finished,
                            ric_status (*beside)(void *user, const ric_atlas *atlas), void *user, ric_atlas **out);

#endif
