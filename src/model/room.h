/* What the room model gives to the rooms above it (docs/map.md). */
#ifndef RIC_MODEL_ROOM_H
#define RIC_MODEL_ROOM_H

#include "joined.h"
#include "losses.h"
#include "mixture.h"
#include "modal.h"
#include "model.h"
#include "regime.h"
#include "truncate.h"
#include "word.h"

#endif
