/* What the room flow gives to the rooms above it (docs/map.md). */
#ifndef RIC_FLOW_ROOM_H
#define RIC_FLOW_ROOM_H

#include "flight.h"
#include "flight_law.h"
#include "power_flow.h"

#endif
