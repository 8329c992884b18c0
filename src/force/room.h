/* What the room force gives to the rooms above it (docs/map.md). */
#ifndef RIC_FORCE_ROOM_H
#define RIC_FORCE_ROOM_H

#include "force_start.h"

#endif
