/* The branch that leaves where mirrors are broken (augmented.h, BREAK). An orbit of it is two motions x = u + e a and y
 * = u - e a along the chain of the branch that passes, each the other one turned round at a broken mirror point, and
 * each turned into itself at the other. So with G the equations of the chain (G(u + e a) + G(u - e a)) / 2 = 0,  (G(u +
 * e a) - G(u - e a)) / 2 e = 0,  l.a = 1 with the rows of the mirror points; at e = 0 these are the equations of the
 * junction, and regular there. If a box around it is taken into itself for all 0 <= e <= size there is one zero for
 * each e, and the orbits are one arc that begins in the junction. */
#ifndef RIC_PROVE_LEAVING_H
#define RIC_PROVE_LEAVING_H

#include "augmented.h"

typedef struct {
    arb_t size; /* exact */
    slong count;
    arb_ptr x, y;    /* [count] balls: the orbit at e = size */
    double approach; /* no impact of the arc is slower, scaled, per 2^-time s */
} ric_leaving;

/* From a junction that was proved, whose test is done anew; to be freed in any case. */
bool ric_leaving_prove(ric_leaving *v, ric_augmented *junction);
void ric_leaving_free(ric_leaving *v);

#endif
