/* What the room check gives to the rooms above it (docs/map.md). */
#ifndef RIC_CHECK_ROOM_H
#define RIC_CHECK_ROOM_H

#include "shaken.h"
#include "simulator.h"

#endif
