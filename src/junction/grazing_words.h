/* Ways out of a grazing or a corner: subsets of the touches that stay as impacts, or of the pairs
 * of impacts whose order is exchanged, up to the symmetries of the orbit; at a duplicate, of the
 * orbit gone through several times (docs/theory.md section 8). Bit j * p + i of a choice stands for
 * touch (or pair) i of p in the j-th time through. */
#ifndef RIC_JUNCTION_GRAZING_WORDS_H
#define RIC_JUNCTION_GRAZING_WORDS_H

#include "node.h"

/* All gaps that touch in flight become impacts of no speed; kept [allocated, may be NULL] marks
 * those that were impacts before. NULL: no memory, or more touches than are enumerated, as of a
 * body that rests at a stop; which of them ric_grazing_words_lost() says. */
ric_periodic *ric_grazing_words_touches(const ric_model *model, const ric_periodic *cycle,
                                        bool **kept);
ric_status ric_grazing_words_lost(const ric_periodic *cycle);

/* Lists one departure for every class of choices. Those of a duplicate that repeat themselves after
 * fewer periods belong to fewer and are left out. With too many touches there is a single one, over
 * budget. False: no memory. */
bool ric_grazing_words_list(const ric_model *model, ric_node *node);

/* A grazing orbit with those of its impacts and touches that keep[i] names, one at least, and all
 * symmetries that it has then; NULL: no memory. */
ric_periodic *ric_grazing_words_keep(const ric_model *model, const ric_periodic *whole,
                                     const bool *keep);
/* The orbit as the branch that leaves by `choice` sees it, with the symmetries that are left; NULL
 * with no impact left, or no memory. */
ric_periodic *ric_grazing_words_cycle(const ric_model *model, const ric_node *node,
                                      unsigned choice);

/* Which choice a branch is that ends at a grazing with the orbit `full`, as
 * ric_grazing_words_touches has it with `kept`; events at one instant may change places in both. At
 * a corner the orbit itself tells. -1 if none fits. */
int ric_grazing_words_choice(const ric_model *model, const ric_node *node, ric_periodic *full,
                             bool *kept);
int ric_grazing_words_order(const ric_model *model, const ric_node *node,
                            const ric_periodic *cycle);

#endif
