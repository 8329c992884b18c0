/* C_ab: multiplicities of the eigenvalue 0 of the article's square Jacobian (eq. 29). */
#ifndef RIC_JUNCTION_MULTIPLICITY_H
#define RIC_JUNCTION_MULTIPLICITY_H

#include "node.h"

/* Algebraic (a) and geometric (b) multiplicity at an extremum, a branch point or a multiplication,
 * on the duplicate where it lives. *decided = false: the ranks are lost in rounding, and a and b
 * are those of the kind (docs/theory.md section 7). */
ric_status ric_multiplicity(const ric_model *model, const ric_node *node, int *a, int *b,
                            bool *decided);

#endif
