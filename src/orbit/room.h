/* What the room orbit gives to the rooms above it (docs/map.md). */
#ifndef RIC_ORBIT_ROOM_H
#define RIC_ORBIT_ROOM_H

#include "floquet.h"
#include "floquet_fine.h"
#include "parting.h"
#include "periodic.h"
#include "reach.h"
#include "shooting.h"
#include "shooting_nodes.h"
#include "singular.h"
#include "turn.h"

#endif
