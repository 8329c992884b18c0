/* Motion under power-law springs, for those who check: from M, K and the contacts alone, in
 * extended precision, by extrapolation. */
#ifndef RIC_CHECK_SIMULATOR_POWER_H
#define RIC_CHECK_SIMULATOR_POWER_H

#include "simulator.h"

typedef struct ric_simulator_power ric_simulator_power;

ric_status ric_simulator_power_create(const ric_model *model, ric_simulator_power **out);
void ric_simulator_power_free(ric_simulator_power *springs);
/* Scaled state y [2 n_dof] = x, v through a time in seconds; with it deviations Y [2 n_dof * 2
 * n_dof], one a column, or NULL. */
ric_status ric_simulator_power_go(ric_simulator_power *springs, ric_real time, ric_real *y,
                                  double *Y);
/* x'' [n_dof] at a displacement. */
void ric_simulator_power_accelerations(const ric_simulator_power *springs, const ric_real *x,
                                       ric_real *a);

#endif
