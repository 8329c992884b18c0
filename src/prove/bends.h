/* Second derivatives of the equations of a chain on balls, in several directions: what D changes by
 * along each. They couple no two blocks, so that each is a matrix of small ones along its diagonal;
 * in a basis (skew.h) it is that, and a few columns that are sums of all. */
#ifndef RIC_PROVE_BENDS_H
#define RIC_PROVE_BENDS_H

#include "equations.h"
#include "skew.h"

typedef struct {
    const ric_chain *c;
    const ric_enclosure *e;
    arb_mat_t *flights;
    ric_equations q; /* J: the derivatives in the direction that was taken */
} ric_bends;

/* On the balls of a chain, which are borrowed. */
void ric_bends_open(ric_bends *b, const ric_chain *c, const ric_enclosure *e);
void ric_bends_close(ric_bends *b);
/* A = D^2 F `along` [m * size + 1]; all that follows is of that. */
void ric_bends_take(ric_bends *b, arb_srcptr along);
/* out [n] = A x, of the n unknowns; the plane, the last of it, is no part of that. */
void ric_bends_apply(const ric_bends *b, arb_srcptr x, arb_ptr out);
/* Z of a contraction += by |C A T|, T the basis. */
void ric_bends_add(const ric_bends *b, const ric_skew *s, double by, ric_contraction *k);
/* W [n * n] column by column: T C A, approximately, without signs. */
void ric_bends_turn(const ric_bends *b, const ric_skew *s, const ric_contraction *k, double *W);

#endif
