/* Chains between mirror points at which a motion goes back as its image under a permutation of the
 * coordinates (twins.h): x(-t) = S x(t). Where the chain ends with one of another kind, half of the
 * period is the image of the other half. */
#ifndef RIC_PROVE_TWIN_CHAIN_H
#define RIC_PROVE_TWIN_CHAIN_H

#include "chain.h"

/* The image of a state w [2n], in balls that hold it. */
void ric_twin_chain_image(const ric_enclosure *e, const ric_twin *twin, arb_ptr w);
/* From such a mirror point of the motion of a general chain to the next mirror point of any kind;
 * false where all modes are not seen, or near its centre there is none. To be freed in any case. */
bool ric_twin_chain_create(ric_chain *c, const ric_chain *general, const ric_enclosure *e,
                           const ric_twin *twin);

#endif
