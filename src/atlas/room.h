/* What the room atlas gives to the rooms above it (docs/map.md). */
#ifndef RIC_ATLAS_ROOM_H
#define RIC_ATLAS_ROOM_H

#include "atlas.h"
#include "keys.h"
#include "links.h"
#include "store.h"

#endif
