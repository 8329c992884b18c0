/* Whether a solution of the forced problem is a motion, its multipliers, and what it does. */
#ifndef RIC_FORCE_FORCE_MOTION_H
#define RIC_FORCE_FORCE_MOTION_H

#include "force_orbit.h"

/* Speed at event k in the direction that it needs: towards a face that is met, away from a spring
 * that opens. */
double ric_force_motion_speed(const ric_force_orbit *o, int k);

/* The highest value of a gap coordinate over its clearance in a flight, above `least`: maxima are
 * found by bisection under a bound of its second derivative, so that none is overlooked, and the
 * end of the flight counts, too, where the event is that of another face. 1 touches the face. Of a
 * closed face 2 less that. `least`, and *time = NaN: there is none above it. */
ric_status ric_force_motion_highest(const ric_force_orbit *o, int k, int face, double least,
                                    double *highest, double *time);

/* "" or what forbids the solution: every event is in its direction, and no other face is met. */
ric_status ric_force_motion_fault(const ric_force_orbit *o, const char **fault);

/* Multipliers [4 n] of the map over the period as re, im; `rounding`: what their size may be off
 * by. With X [2n * 2n] the map itself of deviations at the time of event 0, right after it; may be
 * NULL. */
ric_status ric_force_motion_multipliers(const ric_force_orbit *o, double *out, double *rounding,
                                        double *X);

ric_stability ric_force_motion_judge(int n, const double *multipliers, double rounding,
                                     double *largest);

/* Largest |x_j| and root of the mean of x_j^2 over the period, scaled by the clearance, [n] each;
 * largest gap coordinate over its clearance inside all flights, NaN where none is above a half;
 * least speed at an event, NaN without events. Scaled units of the solver for the speed. */
typedef struct {
    double *peak, *rms;
    double reach, approach;
} ric_force_measures;
ric_status ric_force_motion_measure(const ric_force_orbit *o, ric_force_measures *out);

/* State [2n] at phase theta, or whole periods of the orbit earlier or later, of which event 0
 * begins one: of the stroboscopic map. */
ric_status ric_force_motion_strobe(const ric_force_orbit *o, double theta, double *z);

/* Scaled public state and seconds, [2 n_dof], from and to the units of the solver. */
void ric_force_motion_leave(const ric_force_medium *m, const double *z, double *state);
void ric_force_motion_enter(const ric_force_medium *m, const double *state, double *z);

#endif
