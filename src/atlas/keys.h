/* Keys of branches and junctions: short texts made from what no budget, order of work or machine
 * changes. docs/atlas-format.md says what goes into them and how far they last. */
#ifndef RIC_ATLAS_KEYS_H
#define RIC_ATLAS_KEYS_H

#include "atlas.h"

/* Gives every branch and every junction its key; those that it has go. */
ric_status ric_keys_make(ric_atlas *atlas);

#endif
