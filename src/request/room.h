/* What the room request gives to the rooms above it (docs/map.md). */
#ifndef RIC_REQUEST_ROOM_H
#define RIC_REQUEST_ROOM_H

#include "orbit_at.h"
#include "stored.h"

#endif
