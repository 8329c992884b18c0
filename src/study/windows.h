/* Windows that a study leaves open: chosen from the frequencies that are seen, the energies at
 * which contacts begin to matter, and the impacts allowed (docs/study.md). */
#ifndef RIC_STUDY_WINDOWS_H
#define RIC_STUDY_WINDOWS_H

#include "ricochet.h"

/* Puts numbers where energy or frequency is 0, 0; numbers that are there stay. RIC_E_INPUT if those
 * of the model are beyond what an option may be: the detail says which. */
ric_status ric_windows_choose(const ric_model *model, ric_explore_options *options);

/* How many of the lowest modes are worth keeping in the windows that would be chosen: all of a
 * small structure, of others those that begin there and those that have more than static
 * compliance, as far as a first look can afford them. */
ric_status ric_windows_modes(const ric_model *model, const ric_explore_options *options, int *n);

/* A mode so many times faster than another one has hardly more than its static compliance in what
 * that one does. */
enum { RIC_WINDOWS_FAR = 20 };
/* How many of n frequencies, ascending, are not far above the highest one of the modes that are
 * met. */
int ric_windows_worth(int n, const double *frequency, double highest);

/* Whether a first look keeps all modes anyway, as contacts see few. */
bool ric_windows_few(const ric_model *model);

/* How many points of branches a first look at the model can afford, explore.points: some seconds of
 * one core. */
int ric_windows_points(const ric_model *model);

#endif
