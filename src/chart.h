/* From the explored graph to the records of an atlas: names, order, ids, full orbits. */
#ifndef RIC_CHART_H
#define RIC_CHART_H

#include "atlas.h"
#include "graph.h"

ric_status ric_chart(const ric_graph *graph, const ric_study *study, bool finished, ric_atlas **out);

#endif
