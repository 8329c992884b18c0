/* Replay of orbits under power-law springs (docs/theory.md section 11). */
#ifndef RIC_CHECK_VERIFY_SMOOTH_H
#define RIC_CHECK_VERIFY_SMOOTH_H

#include "simulator.h"
#include "simulator_power.h"

/* claims: NULL, or what is stored with the orbit is computed anew as well. */
ric_status ric_verify_smooth(const ric_atlas *atlas, int branch, int point, ric_check *out,
                             ric_claims *claims);
/* How far an orbit is off its images, of its size: half a period on in x -> -x; and its start off a
 * mirror point, where reversible orbits are stored from. `start` [2 n_dof]: over its size. */
ric_status ric_verify_smooth_images(const ric_atlas *atlas, int branch, int point, ric_real fit[2],
                                    ric_real *start);

/* Shapes [d * k] of the modes that contacts see, and their transpose times the mass, [k * d], which
 * undoes them. */
ric_status ric_verify_smooth_modes(const ric_model *m, int d, int k, ric_real *from, ric_real *to);
/* As ric_verify_kind, of an orbit of this period under power-law springs. */
ric_status ric_verify_kind_smooth(const ric_model *m, ric_simulator_power *springs,
                                  const ric_junction *j, ric_real period, ric_claims *out);

#endif
