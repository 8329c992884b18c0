/* What is checked of damping and force before a structure takes them: RIC_E_INPUT with what is
 * wrong. */
#ifndef RIC_MODEL_LOSSES_H
#define RIC_MODEL_LOSSES_H

#include "ricochet.h"

/* n displacements, and a force that has a number for each of them and is not zero. */
ric_status ric_losses_check_force(int n, int n_force, const double *force);
/* One ratio for all n modes or one for each, none negative. */
ric_status ric_losses_check_ratios(int n, int n_ratio, const double *ratios);
/* [n_matrix^2]. A damping matrix takes energy, whatever the motion, if it is symmetric without a
 * negative eigenvalue. */
ric_status ric_losses_check_matrix(int n, int n_matrix, const double *C);

#endif
