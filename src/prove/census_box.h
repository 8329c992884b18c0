/* Boxes of flight times and states in which a census looks for orbits of one word: what they can be
 * made smaller by without losing one. Nothing is thrown away but by a comparison that a ball which
 * is not a number does not pass. */
#ifndef RIC_PROVE_CENSUS_BOX_H
#define RIC_PROVE_CENSUS_BOX_H

#include "census_rows.h"

typedef struct {
    double lo, hi;
} ric_range;

typedef struct {
    ric_range t[RIC_CENSUS_IMPACTS], w[4]; /* flight times, state behind impact 0 */
} ric_census_box;

/* What every orbit that is looked for keeps to: `flight` bounds each flight, the sum lies within
 * `period`, and the first flight is the longest one, which is where an orbit is begun. */
typedef struct {
    double flight, period[2];
} ric_census_limits;

/* w + half its width, exactly within the range; and at least half the width around that. */
double ric_census_box_middle(ric_range x);
double ric_census_box_radius(ric_range x);

/* Numbers of the equations that are applied to a functional y of the rows: with the unknowns (w, t)
 * = centre + z, |z_i| <= radius_i,
 *   0 = y.F in value +- error + sum linear_i z_i     (w first, then t)
 * for every orbit of the box. */
typedef struct {
    ric_ball value, linear[4 + RIC_CENSUS_IMPACTS];
    double error;
} ric_census_sum;

typedef struct {
    ric_census_rows rows;
    double radius[4 + RIC_CENSUS_IMPACTS];
    double reach;                 /* |w - its centre| */
    double rest[RIC_CENSUS_ROWS]; /* remainders of the rows */
} ric_census_frame;

/* The remainders at the centre that the rows are at, for states no larger than `size`. */
void ric_census_frame_bound(ric_census_frame *f, double size);
void ric_census_frame_sum(const ric_census_frame *f, const double *y, bool shifted,
                          ric_census_sum *out);
/* At least |linear . z|. */
double ric_census_frame_linear(const ric_census_frame *f, const ric_ball *linear);

/* false: there is no orbit of the word in the box. Otherwise the box holds all that it held before.
 */
bool ric_census_box_reduce(ric_census_box *b, const ric_census_pair *p, const ric_census_word *word,
                           const ric_census_limits *limits);
/* false: no motion of the box is one that approaches its faces and passes none in between. */
bool ric_census_box_moves(const ric_census_box *b, const ric_census_pair *p,
                          const ric_census_word *word);

#endif
