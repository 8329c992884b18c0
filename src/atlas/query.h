/* How branches hang on their junctions: what duplicates, segments and bases ask. */
#ifndef RIC_ATLAS_QUERY_H
#define RIC_ATLAS_QUERY_H

#include "ricochet.h"

/* The same grazing gone through `multiple` times, if it is a junction of its own; else 0. */
int ric_query_twin(const ric_atlas *atlas, const ric_junction *junction, int multiple);

#endif
