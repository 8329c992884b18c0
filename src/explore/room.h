/* What the room explore gives to the rooms above it (docs/map.md). */
#ifndef RIC_EXPLORE_ROOM_H
#define RIC_EXPLORE_ROOM_H

#include "graph.h"
#include "remote.h"
#include "rows.h"
#include "start.h"
#include "stored_work.h"

#endif
