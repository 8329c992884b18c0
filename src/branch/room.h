/* What the room branch gives to the rooms above it (docs/map.md). */
#ifndef RIC_BRANCH_ROOM_H
#define RIC_BRANCH_ROOM_H

#include "continuation.h"
#include "continuation_pack.h"
#include "continuation_pause.h"
#include "leap.h"
#include "symmetry.h"
#include "user_point.h"

#endif
