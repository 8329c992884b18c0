/* A structure with its lowest modes only. */
#ifndef RIC_MODEL_TRUNCATE_H
#define RIC_MODEL_TRUNCATE_H

#include "ricochet.h"

/* How many modes there are up to a frequency in rad/s. */
int ric_truncate_count(const ric_model *model, double up_to);
/* RIC_E_INPUT where the lowest n_mode cannot be kept alone: a mode of the same frequency is left
 * out, or no mode of a contact is kept; the detail says which. */
ric_status ric_truncate_check(const ric_model *model, int n_mode);
/* What the modes above the lowest n_mode give way by at contact f to a force of 1 at contact g,
 * statically. */
double ric_truncate_rest(const ric_model *model, int n_mode, int f, int g);
/* A sentence on rigid stops whose c.c the upper half of the modes still makes grow, with the cures;
 * "" where there is none. */
void ric_truncate_growth(const ric_model *model, size_t size, char *out);

#endif
