#ifndef RIC_PROVE_PROVER_AT_JUNCTION_H
#define RIC_PROVE_PROVER_AT_JUNCTION_H

#include "prover.h"

/* A point that is a junction, which is proved, and whose orbit is compared with what is stored;
 * `out` is left as it is where it is none, or that fails. */
ric_status ric_prover_at_junction(ric_prover *p, const ric_branch *branch, int i, ric_proof *out);

#endif
