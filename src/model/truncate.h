/* A structure with its lowest modes only. */
#ifndef RIC_MODEL_TRUNCATE_H
#define RIC_MODEL_TRUNCATE_H

#include "ricochet.h"

/* How many modes there are up to a frequency in rad/s. */
int ric_truncate_count(const ric_model *model, double up_to);
/* What the modes above the lowest n_mode give way by at contact f to a force of 1 at contact g, statically. */
double ric_truncate_rest(const ric_model *model, int n_mode, int f, int g);

#endif
