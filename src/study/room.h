/* What the room study gives to the rooms above it (docs/map.md). */
#ifndef RIC_STUDY_ROOM_H
#define RIC_STUDY_ROOM_H

#include "options.h"
#include "region.h"
#include "study.h"

#endif
