/* Parts of the plane of energy and frequency where a study has larger budgets. */
#ifndef RIC_STUDY_REGION_H
#define RIC_STUDY_REGION_H

#include <stddef.h>

#include "ricochet.h"

/* What may be departed to from a junction. */
typedef struct {
    int depth, impacts, multiply;
    bool inside; /* within the windows of the study, or in a region */
    bool raised; /* in a region */
} ric_budgets;

/* At a junction with this scaled energy, frequency of its orbit in rad/s, and multiple: the largest
 * of the study and of every region that holds it, at its own frequency or at that of the orbit gone
 * through `multiple` times. */
ric_budgets ric_region_budgets(const ric_explore_options *options, double energy, double frequency,
                               int multiple);
/* The largest of all. */
ric_budgets ric_region_largest(const ric_explore_options *options);
/* How far branches are followed: the smallest window that holds that of the study and every region.
 */
void ric_region_window(const ric_explore_options *options, double energy[2], double frequency[2]);
/* Whether a branch may have multiplications in a region that the study by itself does not look for.
 * points: one ric_point each, `stride` doubles apart. */
bool ric_region_multiplies(const ric_explore_options *options, int n_point, size_t stride,
                           const double *points);
/* Whether all that `inner` asks for is asked for by `outer`. */
bool ric_region_covers(const ric_region *outer, const ric_region *inner);

#endif
