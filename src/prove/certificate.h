/* What was proved as lines of JSON that stand on their own: docs/proofs.md describes them. */
#ifndef RIC_PROVE_CERTIFICATE_H
#define RIC_PROVE_CERTIFICATE_H

#include "chain.h"
#include "existence.h"

/* One line each, to be freed; NULL: no memory. */
char *ric_certificate_model(const ric_model *model);
char *ric_certificate_point(const ric_chain *c, const ric_enclosure *e, const ric_existence *x, const ric_proof *proof);

#endif
