/* A branch as one curve: tubes (tube.h) from stored point to stored point, glued at orbits that lie
 * in both, gaps open along all of them. Where a step is too long for one tube it takes several, to
 * orbits that are solved in between, each as long as the one before says. */
#ifndef RIC_PROVE_CURVE_H
#define RIC_PROVE_CURVE_H

#include "certificate.h"
#include "passage.h"
#include "tube.h"

/* An orbit that is proved: within `exists` of the centre of the chain. */
typedef struct {
    ric_chain c;
    arb_t exists;
    double unique;   /* no other orbit of the class holds its number at the same value so near the
                        centre; 0: not known */
    int way;         /* of its proof (existence.h) */
    double *tangent; /* [m * size] of the curve there, of length 1: a guess, or NULL */
    arb_ptr last;    /* [m * size + 1] balls, of an orbit that touches and ends the curve; NULL */
    const char *why; /* why it is none, or NULL */
} ric_node;

typedef struct {
    const ric_enclosure *e;
    int tubes, tried; /* in all; that failed, of the step that is being proved */
    double
        length[3];   /* along the curve, by ric_stability: what is unstable, stable and undecided */
    ric_arcs *arcs;  /* its certificate, or NULL */
    char why[200];   /* where it ends, and why */
    double approach; /* no impact is slower, scaled, per 2^-time s */
} ric_curve;

void ric_curve_node_init(ric_node *a);
void ric_curve_node_clear(ric_node *a);
/* Proves the orbit near the centre of a->c, which it moves there. */
void ric_curve_node_prove(ric_node *a, const ric_enclosure *e);

/* The orbit in the balls u [m * size + 1], of the class of `like`, as a node; `last`: it touches,
 * and the curve ends. */
void ric_curve_node_place(ric_node *a, const ric_chain *like, arb_srcptr u, bool last,
                          const ric_enclosure *e);

/* Whether the two orbits are on one curve of motions, but for one that touches, which ends it; what
 * is found is added to `x`. */
bool ric_curve_join(ric_curve *x, const ric_node *a, const ric_node *b);

#endif
