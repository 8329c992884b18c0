/* Energies and frequencies that a study asks for: each passage of a branch is a junction of kind
 * user (docs/theory.md section 7). */
#ifndef RIC_BRANCH_USER_POINT_H
#define RIC_BRANCH_USER_POINT_H

#include "ricochet.h"

#define RIC_USER_POINTS_MAX (2 * RIC_NUMBERS_MAX)

typedef struct {
    bool frequency; /* of the orbit, in rad/s; else its scaled energy */
    double value;
} ric_user_point;

/* All of them in ascending order, energies first, written to out [RIC_USER_POINTS_MAX]; how many.
 */
int ric_user_point_list(const ric_explore_options *options, ric_user_point *out);

/* Relative distance of an orbit from what was asked for. */
double ric_user_point_off(const ric_user_point *asked, double energy, double frequency);

/* A number that stands for the list in the key of a stored trace. */
uint64_t ric_user_point_key(int n, const ric_user_point *list);

#endif
