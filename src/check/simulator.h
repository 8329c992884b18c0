/* The simulator's own modal frame, for those who check with it. */
#ifndef RIC_CHECK_SIMULATOR_H
#define RIC_CHECK_SIMULATOR_H

#include "ricochet.h"

/* It computes in extended precision: an unstable orbit amplifies the last digit of a double beyond
 * what a check may allow. */
typedef long double ric_real;

/* A [n * n] = L L' in place; false if A is not positive definite. */
bool ric_simulator_cholesky(int n, ric_real *A);

/* A simulator as good as new, with the modes that it knows already, and back to the model. */
ric_status ric_simulator_borrow(const ric_model *model, ric_simulator **out);
void ric_simulator_return(const ric_model *model, ric_simulator *sim);
/* Borrowed: omega [n_dof] rad/s, 0 for a free mode; modal normals c [n_contact * n_dof]. */
void ric_simulator_frame(const ric_simulator *sim, const ric_real **omega, const ric_real **c);
/* w [2 n_dof] = q, p of a scaled state x, v. */
void ric_simulator_modal(const ric_simulator *sim, const double *x, const double *v, ric_real *w);
/* Of a unit of number j, from 0, of such a state. */
void ric_simulator_modal_unit(const ric_simulator *sim, int j, ric_real *w);
/* As ric_simulator_start, from w; and the present state as w. closed [n_face] tells which springs
 * are, NULL: those that w is beyond. */
ric_status ric_simulator_start_modal(ric_simulator *sim, const bool *closed, const ric_real *w);
/* The motion with given springs closed for a time, whatever the gaps; w [2 n_dof], may work in
 * place. `linear`: of a small deviation. */
ric_status ric_simulator_fly(ric_simulator *sim, const bool *closed, bool linear, ric_real t,
                             const ric_real *w, ric_real *after);
/* The transposed of that: what a row [2 n_dof] behind a flight is before it. */
ric_status ric_simulator_fly_back(ric_simulator *sim, const bool *closed, ric_real t,
                                  ric_real *row);
/* Largest gap over clearance, at a maximum in a part of the present flight: of the face, or of its
 * image under x -> -x; of a closed one 2 less that, at a minimum. `best` if none is larger. */
double ric_simulator_highest(const ric_simulator *sim, int face, bool image, double from, double to,
                             double best);
/* The same, from part[0] to part[1], of the points at which the gap bends the other way at a speed
 * of at most `slow`, where a maximum may begin: what is nearest to `wanted`; infinite if there is
 * none. */
double ric_simulator_level(const ric_simulator *sim, int face, bool image, const double part[2],
                           double slow, double wanted);
void ric_simulator_state_modal(const ric_simulator *sim, ric_real *time, ric_real *w);

#endif
