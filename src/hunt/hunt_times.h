/* A motion from the faces that it meets and guesses of all its flight times at once (docs/theory.md
 * section 11, hunt).
 *
 * Nothing is flown from impact to impact, so that no error is multiplied along the period. With a =
 * omega cot(omega tau) and b = omega / sin(omega tau) a mode that goes from q0 to q1 in the time
 * tau
 *
 *     leaves with  b q1 - a q0   and arrives with  a q1 - b q0   (a = b = 1 / tau where omega = 0).
 *
 * The momentum along a face is kept at every impact: for given times that is a cyclic tridiagonal
 * linear system for the places y_k of all impacts. What is left is r_k, half the sum of the
 * velocities across the face before and after the impact, zero where it is elastic, and the energy.
 * Since sum J_k r_k = 0 with the impulses J_k, one r_k, that of the largest impulse, follows from
 * the others: N equations for N times, solved by Newton's method with halved steps. Cost O(N^3) a
 * step. */
#ifndef RIC_HUNT_HUNT_TIMES_H
#define RIC_HUNT_HUNT_TIMES_H

#include "hunt.h"

enum { RIC_TIMES_MOST = RIC_HUNT_IMPACTS };

/* A flight: a and b of both modes (b is negative where the orbit closes with x -> -x after it), and
 * velocities. */
typedef struct {
    double a[2], b[2], leave[2], arrive[2];
} ric_times_flight;

typedef struct {
    const ric_impact_map *section;
    int N;
    bool half;      /* of an orbit with z(t + T/2) = -z(t) */
    double longest; /* sum of the flights, at most */
    ric_times_flight flight[RIC_TIMES_MOST];
    double K[RIC_TIMES_MOST * RIC_TIMES_MOST]; /* of the places */
    double
        y[RIC_TIMES_MOST * (RIC_TIMES_MOST + 1)]; /* places, and their derivatives by all times */
    double r[RIC_TIMES_MOST + 1],
        J[(RIC_TIMES_MOST + 1) * RIC_TIMES_MOST]; /* residuals, the energy last */
    double A[RIC_TIMES_MOST * RIC_TIMES_MOST], step[RIC_TIMES_MOST];
} ric_times;

/* hits [N]: faces and flight times are given; times, places and angles are those of the motion
 * afterwards. False: none was reached, or an impact would have to pull. */
bool ric_hunt_times_solve(ric_times *t, ric_hit *hits);

#endif
