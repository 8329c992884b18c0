/* Second derivatives of the equations of a chain on balls, in several directions: what D changes by
 * along each. They couple no two blocks, so that each is a matrix of small ones along its diagonal;
 * in a basis (skew.h) it is that, and a few columns that are sums of all. A flight of modes couples
 * no two of them, so that most numbers of these are zero but for the slack, which is the same for
 * all rows of a flight and added by itself. */
#ifndef RIC_PROVE_BENDS_H
#define RIC_PROVE_BENDS_H

#include "equations.h"
#include "skew.h"

/* A of one flight: the only rows and columns that it has a part in. */
typedef struct {
    slong row, rows, first, columns;
    ric_ball *A;  /* [rows * columns] */
    double slack; /* what the flight leaves open of each number of it */
} ric_bend;

typedef struct {
    const ric_chain *c;
    const ric_enclosure *e;
    arb_mat_t *flights; /* [m] first derivatives, */
    ric_ball *D;        /* [m * 2n * (2n + 1)] in doubles, too, */
    ric_ball *B;        /* [n * 2n] the rows of a mirror point at the end, */
    ric_ball *normal;   /* [2 * n] and the impact there, c and 2 c / (c . c) */
    ric_bend *at;       /* [m] in the direction that was taken */
    slong rows;         /* of all equations but the plane */
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
/* The same for what flights leave open of the first derivatives on the balls of a chain. */
void ric_bends_loosen(const ric_chain *c, const ric_enclosure *e, const ric_skew *s,
                      ric_contraction *k);
/* W [n * n] column by column: T C A, approximately, without signs. */
void ric_bends_turn(const ric_bends *b, const ric_skew *s, const ric_contraction *k, double *W);

#endif
