/* A basis of the unknowns in which boxes are small. Where a derivative J is near to singular, its
 * inverse C makes of any small change one along a single direction r, for which |C| |J - J0| number
 * by number counts what cancels in r many times over. With T the identity but for one column, that
 * of the largest number of r, which is r itself, u = T x has one number that is known badly, and
 * all others well. T is a product of a few of these: J T and T^-1 C take its place. */
#ifndef RIC_PROVE_SKEW_H
#define RIC_PROVE_SKEW_H

#include "contraction.h"

enum { RIC_SKEW_MOST = 4 };

typedef struct {
    slong n;
    int count;
    slong at[RIC_SKEW_MOST];
    double *r[RIC_SKEW_MOST]; /* [n] each; 1 at its own `at`, 0 at those before */
} ric_skew;

void ric_skew_create(ric_skew *s, slong n);
void ric_skew_free(ric_skew *s);
/* One direction more, the longest of C that the basis does not have yet, and C <- T^-1 C, which is
 * any matrix and need not be exact; false if there is none. C has to be in doubles. */
bool ric_skew_find(ric_skew *s, ric_contraction *k);
/* A <- A T. */
void ric_skew_columns(const ric_skew *s, arb_mat_t A, slong prec);
/* x <- T x, approximately. */
void ric_skew_turn(const ric_skew *s, double *x);
/* out = |T| b: how far u goes in a box of x of radii b; out may be b. */
void ric_skew_spread(const ric_skew *s, mag_srcptr b, mag_ptr out);
/* out = |T^-1| u, of the radii u of a box that x has then; out may be u. */
void ric_skew_enter(const ric_skew *s, mag_srcptr u, mag_ptr out);
/* out [n]: column `at` of T for direction d; all others are those of the identity. */
void ric_skew_direction(const ric_skew *s, int d, arb_ptr out);

#endif
