/* Disturbances that part contacts which close together (docs/theory.md sections 1 and 5): to first
 * order they move the modes alone that the orbit does not. */
#ifndef RIC_ORBIT_PARTING_H
#define RIC_ORBIT_PARTING_H

#include "periodic.h"

/* Why there are no multipliers of them; NULL: there are. */
const char *ric_parting_undefined(const ric_model *model, const ric_periodic *orbit);
/* How many there are: 0 where nothing closes together. */
int ric_parting_count(const ric_model *model);
/* The multipliers over a period, re, im of each, out [2 count], and what each may be off by,
 * error [count]. RIC_E_INPUT: they are not defined. */
ric_status ric_parting_multipliers(const ric_model *model, const ric_periodic *orbit, double *out,
                                   double *error);
/* What these say: stable where each is a simple one on the unit circle. */
ric_stability ric_parting_stability(int count, const double *multipliers, const double *error);

#endif
