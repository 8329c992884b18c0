/* Between which times of contact motions of a loose mass lie (loose.h, docs/theory.md section 8).
 *
 * Both ends of a motion, from the centre, from the impact on a stop or from the middle of a contact
 * that has lasted for a time a, are states of the open structure that n numbers x, y make up:
 *     w_f = S_f x + s_f,   w_g = J (S_g y + s_g)
 * with J the reversal of speeds. Each is a Lagrangian plane, so that with the form
 *     [v, w] = sum (v_a w_p - v_p w_a) / kappa
 * and the free flight R between them, n equations give x for given times:
 *     [J S_g, R (S_f x + s_f) - J s_g] = 0.
 * What is left is one gap at the end of the contact with each spring. Times the determinant of the
 * system they have no poles, and change sign at a zero. */
#ifndef RIC_EXPLORE_LOOSE_ZEROS_H
#define RIC_EXPLORE_LOOSE_ZEROS_H

#include "model/room.h"

typedef struct ric_loose_zeros ric_loose_zeros;

/* Faces f, -1 for the centre, and g; springs among them are closed for at most `longest` [springs],
 * from the middle of the contact on. */
ric_status ric_loose_zeros_create(const ric_model *model, int f, int g, const double longest[2],
                                  ric_loose_zeros **out);
void ric_loose_zeros_free(ric_loose_zeros *zeros);

/* Tells of a box of times of contact, [springs], in which all gaps change their sign, and where
 * they seem to vanish; *found: nothing more is looked for in there. */
typedef ric_status (*ric_loose_box)(void *data, const double low[2], const double high[2],
                                    const double near[2], bool *found);
/* All boxes for motions that last `time` from end to end. */
ric_status ric_loose_zeros_find(ric_loose_zeros *zeros, double time, ric_loose_box tell,
                                void *data);

#endif
