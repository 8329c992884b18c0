/* Along the stored points of a branch, in the class of the one in its middle. */
#ifndef RIC_PROVE_WALK_H
#define RIC_PROVE_WALK_H

#include "chain.h"
#include "prover.h"

typedef struct {
    const ric_prover *p;
    const ric_enclosure *e;
    ric_branch branch;
    ric_chain like; /* the class of the branch */
    double *state;  /* [2 n_dof + letters] scratch */
    double slow;    /* of questions at its ends (augmented.h) */
} ric_walk;

/* To be closed in any case. */
ric_status ric_walk_open(ric_walk *w, ric_prover *p, int id, int level);
void ric_walk_close(ric_walk *w);
/* Finds the class; like.u is NULL where a stored number is not finite. */
ric_status ric_walk_class(ric_walk *w);
/* What is stored of point i. */
ric_status ric_walk_point(ric_walk *w, int i, ric_point *stored);
/* Its orbit in the class of the branch; the chain is to be freed in any case. */
ric_status ric_walk_chain(ric_walk *w, int i, ric_chain *out, bool *made);
/* At an arclength, on the chord of two stored points; the same. */
ric_status ric_walk_between(ric_walk *w, double at, ric_chain *out, bool *made);

#endif
