/* What the room prove gives to the rooms above it (docs/map.md): what include/ricochet.h declares
 * of ric_prover_. */
#ifndef RIC_PROVE_ROOM_H
#define RIC_PROVE_ROOM_H

#include "ricochet.h"

#endif
