/* That there is exactly one orbit near the centre of a chain: the theorem of Newton and Kantorovich
 * (Ortega, SIAM J. Numer. Anal. 5 (1968) 408-411). With |D^-1| <= beta and |F| at the centre and a
 * Lipschitz constant K of D around it, 2 beta^2 K |F| <= 1 gives one zero within 2 beta |F|, and no
 * other within 1 / (beta K). Norms are Euclidean, over all states and times in the units of the
 * enclosure. The second derivative couples no two blocks, so that K does not grow with their
 * number. */
#ifndef RIC_PROVE_EXISTENCE_H
#define RIC_PROVE_EXISTENCE_H

#include "chain.h"

typedef struct {
    double moved; /* of the centre from where the chain began, over 1 + |its largest block| */
    double shift; /* the same, as it is */
    double blur;  /* what rounding to doubles of what the chain began with may do to the orbit:
                     |D^-1| times that; about */
    arb_t exists, unique; /* radii around the centre */
    bool identified;      /* the chain began where the orbit is the only one */
    int way; /* in which numbers equations are looked at first, and what they were proved in: from
                doubles, 0, on to what bears equations nearer to singular */
    double *tangent; /* [m * size] of the curve of orbits there, of length 1: a guess, or NULL */
} ric_existence;

void ric_existence_init(ric_existence *x);
void ric_existence_clear(ric_existence *x);
/* Moves the centre of the chain to the orbit, chooses the plane across the curve that it lies on,
 * and proves. NULL, or why there is no proof at this precision. */
const char *ric_existence_prove(ric_existence *x, ric_chain *c, const ric_enclosure *e);
/* The same of an orbit that began anywhere: whether it was alone there is not asked, and `unique`
 * need not be told. */
const char *ric_existence_find(ric_existence *x, ric_chain *c, const ric_enclosure *e);

#endif
