/* What the room base gives to the rooms above it (docs/map.md). */
#ifndef RIC_BASE_ROOM_H
#define RIC_BASE_ROOM_H

#include "buffer.h"
#include "bytes.h"
#include "c_locale.h"
#include "cache.h"
#include "constants.h"
#include "dense.h"
#include "eigen.h"
#include "eigen_fine.h"
#include "extremes.h"
#include "gauss.h"
#include "halt.h"
#include "hermite.h"
#include "lane.h"
#include "memory.h"
#include "root.h"
#include "shelf.h"
#include "sine.h"
#include "status.h"
#include "together.h"
#include "tolerances.h"
#include "twice.h"

#endif
