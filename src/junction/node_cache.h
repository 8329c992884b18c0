/* The pure steps of an exploration by way of the memo: a worker computes and leaves them there, the
 * owner of the graph takes them out or computes what is missing. Also nodes and cycles as bytes,
 * for keys and for other machines. */
#ifndef RIC_JUNCTION_NODE_CACHE_H
#define RIC_JUNCTION_NODE_CACHE_H

#include "base/room.h"
#include "node.h"

typedef struct {
    ric_cache *memo; /* NULL: everything is computed */
    bool worker;     /* puts results in; else takes them out */
} ric_node_cache;

typedef enum {
    RIC_DEFINING_ARRIVAL,
    RIC_DEFINING_CORNER,
    RIC_DEFINING_GRAZING,
    RIC_DEFINING_INTERIOR,
    RIC_DEFINING_MULTIPLICATION,
    RIC_DEFINING_USER
} ric_defining_kind;

/* Which of the functions of node.h, and its arguments. */
typedef struct {
    ric_defining_kind kind;
    int test;             /* of an interior point */
    int p, q;             /* of a multiplication */
    ric_user_point asked; /* of kind user */
} ric_defining;

ric_status ric_node_cache_solve(const ric_model *model, ric_node_cache recall, ric_defining solve,
                                const ric_periodic *cycle, ric_node **out);

/* ric_grazing_words_touches, by way of the memo. */
ric_periodic *ric_node_cache_touches(const ric_model *model, ric_node_cache recall,
                                     const ric_periodic *cycle, bool **kept);

/* A node with its departures (none of the reasons), and back; bytes of one machine type and
 * version. */
ric_status ric_node_pack(const ric_node *node, void **bytes, size_t *size);
ric_status ric_node_unpack(const ric_model *model, const void *bytes, size_t size, ric_node **out);

#endif
