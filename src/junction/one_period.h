/* Multiplicities of a multiplication from one period of its orbit instead of all that it is gone
 * through (docs/theory.md section 7). */
#ifndef RIC_JUNCTION_ONE_PERIOD_H
#define RIC_JUNCTION_ONE_PERIOD_H

#include "node.h"

/* Whether this is a multiplication by three or more of an orbit of two modes without a closed
 * spring that is C_33 far beyond what a doubt leaves. *clear false: to be measured on all periods
 * (multiplicity.c). Three flights of one period, O(N). */
ric_status ric_one_period_tells(const ric_model *model, const ric_node *node, bool *clear);

#endif
