/* The pure steps of an exploration by way of the memo: a worker computes and leaves them there, the owner of the graph
 * takes them out or computes what is missing. Also nodes and cycles as bytes, for keys and for other machines. */
#ifndef RIC_JUNCTION_NODE_CACHE_H
#define RIC_JUNCTION_NODE_CACHE_H

#include "base/room.h"
#include "node.h"

typedef struct {
    ric_memo *memo; /* NULL: everything is computed */
    bool worker;    /* puts results in; else takes them out */
} ric_recall;

typedef enum {
    RIC_SOLVE_ARRIVAL,
    RIC_SOLVE_CORNER,
    RIC_SOLVE_GRAZING,
    RIC_SOLVE_INTERIOR,
    RIC_SOLVE_MULTIPLICATION,
    RIC_SOLVE_USER
} ric_solve_kind;

/* Which of the functions of node.h, and its arguments. */
typedef struct {
    ric_solve_kind kind;
    int test;         /* of an interior point */
    int p, q;         /* of a multiplication */
    ric_asked asked;  /* of kind user */
} ric_solve;

ric_status ric_solve_node(const ric_model *model, ric_recall recall, ric_solve solve, const ric_cycle *cycle,
                          ric_node **out);

/* A node with its departures (none of the reasons), and back; bytes of one machine type and version. */
ric_status ric_node_pack(const ric_node *node, void **bytes, size_t *size);
ric_status ric_node_unpack(const ric_model *model, const void *bytes, size_t size, ric_node **out);

#endif
