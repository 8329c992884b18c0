/* Krawczyk's test for n equations in balls (Computing 4 (1969) 187-201). C is any matrix near the
 * inverse of their derivative J. Where y >= |C F| at a centre, Z >= |1 - C J| on the box of radii b
 * around it, and y + Z b < b number by number, the map u - C F(u) takes the box into itself and
 * contracts it: there is one zero in it, and J is regular. Bounds are numbers that are rounded up.
 */
#ifndef RIC_PROVE_CONTRACTION_H
#define RIC_PROVE_CONTRACTION_H

#include <stdbool.h>

#include "arb_numbers.h"

typedef struct {
    slong n, prec;
    arb_mat_t C; /* exact */
    mag_ptr Z;   /* [n * n] */
    mag_ptr y;   /* [n] */
    mag_ptr b;   /* [n] */
} ric_contraction;

void ric_contraction_create(ric_contraction *k, slong n, slong prec);
void ric_contraction_free(ric_contraction *k);
/* C from the middle of J; false where that is singular. */
bool ric_contraction_invert(ric_contraction *k, const arb_mat_t J);
/* out = C x. */
void ric_contraction_apply(const ric_contraction *k, arb_srcptr x, arb_ptr out);
/* Z from J on the box. */
void ric_contraction_defect(ric_contraction *k, const arb_mat_t J);
/* Whether y + Z b < b; if not, b is made that times 1 + 1/8 where it is too small, to be tried
 * again. */
bool ric_contraction_holds(ric_contraction *k);

#endif
