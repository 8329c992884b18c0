/* Rows of an atlas while they are made from the graph (rows.h): one for each branch, one for each
 * junction. */
#ifndef RIC_EXPLORE_ROWS_PARTS_H
#define RIC_EXPLORE_ROWS_PARTS_H

#include <math.h>

#include "atlas/room.h"
#include "graph.h"
#include "base/room.h"

typedef struct {
    ric_branch_record record;
    int from, to; /* nodes */
    const ric_edge *edge;
    int user;    /* first of the junctions on a linear mode, in the numbering of nodes */
    int ends[4]; /* ids of the junctions and ways out of them, which tell apart what is alike in all
                    else */
} ric_branch_row;

typedef struct {
    ric_junction_record record;
    const ric_node *node;
    int index;
} ric_junction_row;

static inline ric_status ric_no_rows(void)
{
    return ric_no_memory("the atlas");
}

/* The node number k that a branch passes. */
static inline int ric_branch_row_passed(const ric_branch_row *s, int k)
{
    return s->edge ? s->edge->inner[k].node : s->user + k;
}

/* E = omega^2 q^2 / 2, lengths scaled */
static inline double ric_linear_amplitude(double omega, double energy)
{
    return sqrt(2 * energy) / omega;
}

/* Equal to what rounding leaves: 0. */
static inline int ric_compare_numbers(double a, double b)
{
    if (fabs(a - b) <= RIC_TIE * (fabs(a) + fabs(b))) return 0;
    return a < b ? -1 : 1;
}

/* Why a branch ends, and what may be missing on it: allocated, NULL: no memory. */
char *ric_branch_row_why(const ric_edge *edge);
/* The record of a traced branch, over its canonical word. */
ric_status ric_branch_row_make(const ric_graph *graph, const ric_edge *edge, ric_branch_row *out);

/* A linear mode from rest to where it touches, at `energy` (or to the end of the energy window):
 * states at its mirror point. seen: its index among the seen modes, or -1; node: where it touches,
 * or -1. */
ric_status ric_branch_row_linear(const ric_model *model, const ric_explore_options *options,
                                 int mode, int seen, int node, double energy, ric_branch_row *out);

/* qsort: linear modes, backbones without impacts, then by depth, word, energy, frequency, mirror
 * points and ends. */
int ric_branch_row_order(const void *p, const void *q);

/* The record of node `index`, without its multiplicities, label and name. */
ric_status ric_junction_row_make(const ric_model *model, const ric_node *node, int index,
                                 ric_junction_row *out);

/* What was asked for on a linear mode: energies; its frequency is one number and passes nothing.
 * junctions [*n] grows. */
ric_status ric_junction_row_energies(const ric_graph *graph, int mode, ric_branch_row *branch,
                                     ric_junction_row *junctions, int *n);

/* qsort: by impacts, energy, frequency and kind. */
int ric_junction_row_order(const void *p, const void *q);

/* n calls each(user, 0..). */
typedef struct {
    int n;
    ric_status (*each)(void *user, int i);
    void *user;
} ric_rows_task;

/* By all workers: what comes `first`, then C_ab of one junction of the atlas after the other, with
 * its row; those that a stop leaves unmeasured have a = b = 0, and then the atlas is not finished.
 */
ric_status ric_junction_rows_measure(ric_graph *graph, const ric_junction_row *junctions,
                                     ric_atlas *atlas, const ric_rows_task *first);

/* Labels of all junctions, which have their keys and names: within a family they are numbered in
 * the order of their ids; one whose name is a label of its family has that, and no other has a
 * label that is a name. What `kept`, lines of an earlier atlas of this file or NULL, says of a key
 * stays; labels of a finished atlas are kept in it for the next. */
ric_status ric_junction_labels_give(const char *kept, ric_atlas *atlas);

/* Names of the study: the nearest junction of the right kind, within what the digits of a printed
 * number leave open. */
ric_status ric_junction_rows_name(const ric_study *study, int n, ric_junction_row *junctions);

#endif
