/* C_ab: multiplicities of the eigenvalue 0 of the article's square Jacobian (eq. 29). */
#ifndef RIC_MULTIPLICITY_H
#define RIC_MULTIPLICITY_H

#include "cycle.h"

/* Algebraic (a) and geometric (b) multiplicity at an orbit repeated `multiple` times; 0, 0 if it is too long for a dense matrix. */
ric_status ric_multiplicity(const ric_model *model, const ric_cycle *cycle, int multiple, int *a, int *b);

#endif
