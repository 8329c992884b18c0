/* Points of linear modes, and those that are junctions themselves. */
#ifndef RIC_PROVE_PROVER_MODE_H
#define RIC_PROVE_PROVER_MODE_H

#include "prover.h"

/* The orbit of a linear mode, with its state x, v [2 n_dof], in closed form. */
void ric_prover_mode(const ric_enclosure *e, const ric_point *stored, const double *state,
                     ric_proof *out);
/* A point that is a junction, which is proved, and whose orbit is compared with what is stored;
 * `out` is left as it is where it is none, or that fails. */
ric_status ric_prover_at_junction(ric_prover *p, const ric_branch *branch, int i, ric_proof *out);

#endif
