/* What the room hunt gives to the rooms above it (docs/map.md). */
#ifndef RIC_HUNT_ROOM_H
#define RIC_HUNT_ROOM_H

#endif
