/* What was proved as lines of JSON that stand on their own: docs/proofs.md describes them. */
#ifndef RIC_PROVE_CERTIFICATE_H
#define RIC_PROVE_CERTIFICATE_H

#include "chain.h"

/* What balls hold of an orbit. */
typedef struct {
    arb_srcptr u; /* [m * size] the blocks of its chain */
    arb_srcptr energy, period, trace;
} ric_measured;

/* One line each, to be freed; NULL: no memory. The line of a point is "" where a number is not told from the middle of
 * two decimals: more bits tell it. */
char *ric_certificate_model(const ric_model *model);
char *ric_certificate_point(const ric_chain *c, const ric_enclosure *e, const ric_measured *z, const ric_proof *proof);

#endif
