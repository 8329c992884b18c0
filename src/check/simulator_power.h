/* Motion under power-law springs, for those who check: from M, K and the contacts alone, in extended precision, by
 * extrapolation. */
#ifndef RIC_CHECK_SIMULATOR_POWER_H
#define RIC_CHECK_SIMULATOR_POWER_H

#include "simulator.h"

typedef struct ric_springs ric_springs;

ric_status ric_springs_create(const ric_model *model, ric_springs **out);
void ric_springs_free(ric_springs *springs);
/* Scaled state y [2 n_dof] = x, v through a time in seconds; with it deviations Y [2 n_dof * 2 n_dof], one a column, or
 * NULL. */
ric_status ric_springs_go(ric_springs *springs, ric_real time, ric_real *y, double *Y);
/* x'' [n_dof] at a displacement. */
void ric_springs_accelerations(const ric_springs *springs, const ric_real *x, ric_real *a);

#endif
