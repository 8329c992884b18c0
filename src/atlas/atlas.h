/* The atlas in memory: what exploring makes, the store keeps and every reading command asks. */
#ifndef RIC_ATLAS_ATLAS_H
#define RIC_ATLAS_ATLAS_H

#include "columns.h"

/* A tongue that a branch has stepped over, between a point and the next one: a mode, from 1, with
 * its turns in a period, and how many other resonances lie in the gap. */
typedef struct {
    int point, mode, turns, others;
} ric_atlas_gap;

/* A branch that owns its arrays. `row` is what the public interface hands out; its pointers lead
 * into this struct. */
typedef struct {
    ric_branch row;
    char *key, *label, *mirror, *why;
    int *word, *junctions;
    double *junction_at;
    int n_gap;
    ric_atlas_gap *gaps; /* in order */
    size_t stride;       /* doubles per point: sizeof(ric_point) / 8 + 2 n_dof + max(impacts, 1) */
    double *points;      /* [n_point * stride]: ric_point, state (x, v), flights */
} ric_branch_record;

typedef struct {
    ric_junction row;
    char *key, *label, *name, *refusal;
    int *word, *branches;
    double *state, *flights;
} ric_junction_record;

/* A proof that is kept with the atlas. */
typedef struct {
    ric_proof proof;
    char *certificate; /* "": none */
} ric_proof_record;

/* Of a curve, or a junction: integers are its branch, bits, tubes, and whether its ends are on it;
 * numbers the distance, both radii, energy and period, the stable and unstable shares and the
 * approach, NaN where there is none. */
typedef enum { RIC_GRAPH_CURVE, RIC_GRAPH_JUNCTION } ric_graph_kind;
typedef struct {
    ric_graph_kind kind;
    int id;
    ric_proof_state state;
    char why[200], how[60], prover[32];
    int integer[5];
    double number[10];
} ric_graph_proof;

struct ric_atlas {
    ric_study *study; /* owned */
    bool finished;
    int n_unplaced, n_blind;
    int n_branch, n_junction;
    ric_branch_record *branches;    /* [n_branch], id = index + 1 */
    ric_junction_record *junctions; /* [n_junction], id = index + 1 */
    char *labels; /* lines "KEY LABEL" of all that finished atlases of this file have shown, or NULL
                   */
    int n_proof;
    ric_proof_record *proofs; /* by branch and point */
    int n_graph_proof;
    ric_graph_proof *graph_proofs; /* of curves and junctions */
    int n_arc;
    ric_arc_proof *arcs; /* of curves in work, by branch and point */
    char **arc_texts;    /* their certificates */
};

/* Whether every branch of `small` is in `large`, as far as words and ends tell. */
bool ric_atlas_contains(const ric_atlas *large, const ric_atlas *small);

/* Releases what the records own, not the array itself. */
void ric_atlas_branch_record_free(ric_branch_record *branch);
void ric_atlas_junction_record_free(ric_junction_record *junction);
/* Point i of a branch, both within the atlas; state and flights stay where they are. */
ric_point_row ric_atlas_point_row(const ric_atlas *atlas, int branch, int i);
size_t ric_atlas_point_stride(int n_dof, int letters);

#endif
