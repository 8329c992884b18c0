/* What the room locus gives to the rooms above it (docs/map.md). */
#ifndef RIC_LOCUS_ROOM_H
#define RIC_LOCUS_ROOM_H

#endif
