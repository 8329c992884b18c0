/* Which springs are met beyond a grazing (docs/theory.md section 10). */
#ifndef RIC_JUNCTION_GRAZING_SPRING_H
#define RIC_JUNCTION_GRAZING_SPRING_H

#include "node.h"
#include "outset.h"

/* Whether some touch of a grazing is that of a spring. */
bool ric_grazing_spring_applies(const ric_node *node);

/* The departure `choice` of such a grazing; out->chain NULL if no motion leaves that way.
 * *singular: the kernel has several dimensions there, and the length of out->t is the first step.
 */
ric_status ric_grazing_spring_depart(const ric_model *model, const ric_node *node, unsigned choice,
                                     ric_outset *out, bool *singular);

#endif
