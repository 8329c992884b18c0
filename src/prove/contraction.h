/* Krawczyk's test for n equations in balls (Computing 4 (1969) 187-201). C is any matrix near the
 * inverse of their derivative J. Where y >= |C F| at a centre, Z >= |1 - C J| on the box of radii b
 * around it, and y + Z b < b number by number, the map u - C F(u) takes the box into itself and
 * contracts it: there is one zero in it, and J is regular. Bounds are numbers that are rounded up.
 * C is in doubles, and products with it are bounded as in quick.h, unless 1 - C J is then larger
 * than what a box may do to it: it is in Arb's numbers where J is that near to singular. */
#ifndef RIC_PROVE_CONTRACTION_H
#define RIC_PROVE_CONTRACTION_H

#include <stdbool.h>

#include "ball.h"

/* Of 1 - C J that doubles may leave: 2^-10 where radii are as 1 : 2^8, and more where all of a box
 * are the same. */
#define RIC_CONTRACTION_FINE 0x1p-18
#define RIC_CONTRACTION_EVEN 0x1p-4

/* A column that is zero but for `count` numbers. */
typedef struct {
    slong count, *at;
    ric_ball *x;
} ric_contraction_column;

/* Room for n. */
void ric_contraction_column_open(ric_contraction_column *x, slong n);
void ric_contraction_column_close(ric_contraction_column *x);

static inline void ric_contraction_column_put(ric_contraction_column *x, slong at, ric_ball y)
{
    x->at[x->count] = at;
    x->x[x->count++] = y;
}

typedef struct {
    slong n, prec;
    double *C;     /* [n * n] column by column, exact */
    bool wide;     /* it is this one: */
    arb_mat_t own; /* exact */
    double *Z;     /* [n * n] column by column */
    mag_ptr y;     /* [n] */
    mag_ptr b;     /* [n] */
} ric_contraction;

void ric_contraction_create(ric_contraction *k, slong n, slong prec);
void ric_contraction_free(ric_contraction *k);
/* C from the middle of J, in doubles if they leave less than that of 1 - C J in a row; false where
 * it is singular. */
bool ric_contraction_invert(ric_contraction *k, const arb_mat_t J, double left);
/* The same in doubles alone, however well they do. */
bool ric_contraction_invert_quickly(ric_contraction *k, const arb_mat_t J);
/* out = C x. */
void ric_contraction_apply(const ric_contraction *k, arb_srcptr x, arb_ptr out);
/* A lower bound of the least singular value of all that Z was found from: |J^-1| <= |C| / (1 - |1 -
 * C J|). Nothing where C is not in doubles. */
double ric_contraction_least(const ric_contraction *k);
/* Z from J on the box. */
void ric_contraction_defect(ric_contraction *k, const arb_mat_t J);
/* Column j of Z += by |C x|: of what J has more in it at some distance. */
void ric_contraction_add(ric_contraction *k, slong j, const ric_contraction_column *x, double by);
/* Z += |C| times `rows` rows from `row` on whose numbers in column j are at most weight[j]. */
void ric_contraction_loosen(ric_contraction *k, slong row, slong rows, const double *weight);
/* The largest sum of a row of Z. */
double ric_contraction_left(const ric_contraction *k);
/* The largest eigenvalue of W [n * n], which has no negative number, about: that of Z is less than
 * 1 where any b does. */
double ric_contraction_root(slong n, const double *W);
/* Whether what Z is now, that of the middle of J, is of no account: C is near enough to its
 * inverse. */
bool ric_contraction_is_fine(const ric_contraction *k);
/* C in Arb's numbers. */
bool ric_contraction_invert_widely(ric_contraction *k, const arb_mat_t J);
/* out = Z x, rounded up. */
void ric_contraction_map(const ric_contraction *k, mag_srcptr x, mag_ptr out);
/* Whether y + Z b < b; if not, b is made that times 1 + 1/8 where it is too small, to be tried
 * again. */
bool ric_contraction_holds(ric_contraction *k);
/* Whether any b does for Z and y as they are, found in rounds in which it grows. */
bool ric_contraction_may_hold(ric_contraction *k);

#endif
