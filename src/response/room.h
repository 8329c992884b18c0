/* What the room response gives to the rooms above it (docs/map.md). */
#ifndef RIC_RESPONSE_ROOM_H
#define RIC_RESPONSE_ROOM_H

#endif
