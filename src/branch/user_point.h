/* Energies and frequencies that a study asks for: each passage of a branch is a junction of kind user
 * (docs/theory.md section 7). */
#ifndef RIC_BRANCH_USER_POINT_H
#define RIC_BRANCH_USER_POINT_H

#include "ricochet.h"

#define RIC_ASKED_MAX (2 * RIC_NUMBERS_MAX)

typedef struct {
    bool frequency;  /* of the orbit, in rad/s; else its scaled energy */
    double value;
} ric_asked;

/* All of them in ascending order, energies first, written to out [RIC_ASKED_MAX]; how many. */
int ric_asked_list(const ric_explore_options *options, ric_asked *out);

/* Relative distance of an orbit from what was asked for. */
double ric_asked_off(const ric_asked *asked, double energy, double frequency);

/* A number that stands for the list in the key of a stored trace. */
uint64_t ric_asked_key(int n, const ric_asked *list);

#endif
