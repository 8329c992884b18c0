/* What the room junction gives to the rooms above it (docs/map.md). */
#ifndef RIC_JUNCTION_ROOM_H
#define RIC_JUNCTION_ROOM_H

#include "branch_point.h"
#include "grazing_words.h"
#include "multiplication.h"
#include "multiplicity.h"
#include "node.h"
#include "node_solve.h"
#include "node_cache.h"
#include "outset.h"
#include "switching.h"

#endif
