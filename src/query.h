/* How branches hang on their junctions: what duplicates, segments and bases ask. */
#ifndef RIC_QUERY_H
#define RIC_QUERY_H

#include "ricochet.h"

/* Which duplicate of a branch passes a junction where that is drawn: q for the branch that a q-tupling lies on, 1 for what leaves there. */
int ric_junction_level(const ric_junction *junction, const ric_branch *branch);
/* The same grazing gone through `multiple` times, if it is a junction of its own; else 0. */
int ric_junction_twin(const ric_atlas *atlas, const ric_junction *junction, int multiple);

#endif
