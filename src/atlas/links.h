/* Which branches hang together. */
#ifndef RIC_ATLAS_LINKS_H
#define RIC_ATLAS_LINKS_H

#include "atlas.h"

/* Gives every branch its family and whether that has a linear mode (ric_branch.family, .linked). */
ric_status ric_links_make(ric_atlas *atlas);

#endif
