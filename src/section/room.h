/* What the room section gives to the rooms above it (docs/map.md). */
#ifndef RIC_SECTION_ROOM_H
#define RIC_SECTION_ROOM_H

#endif
