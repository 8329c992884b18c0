/* Pairs of multipliers to more digits than an eigenvalue solver in double leaves, from a map in
 * extended precision. Beside a slow impact one pair goes with 1 / speed, and the others are known
 * to its rounding (docs/theory.md section 5): with one of 1e10 two masses more had six digits of
 * theirs. */
#ifndef RIC_ORBIT_FLOQUET_SHARP_H
#define RIC_ORBIT_FLOQUET_SHARP_H

#include "floquet_fine.h"
#include "floquet_pairs.h"

/* Whether that is done where there are so many pairs. */
bool ric_floquet_sharpens(int n_pair);
/* Replaces those rho = 2 + 4 eig(b' c) whose error, over 1 + |rho|, is above `to`, and what is
 * known of them; b and c [k * k] are uncertain by `rounding`. What cannot be had stays. */
void ric_floquet_sharpen_blocks(const ric_fine_real *b, const ric_fine_real *c,
                                ric_fine_real rounding, double to, ric_floquet_pairs *pairs);
/* The same with rho = lambda + 1 / lambda of the map M [2k * 2k] of the general form. */
void ric_floquet_sharpen_map(const ric_fine_real *M, ric_fine_real rounding, double to,
                             ric_floquet_pairs *pairs);

#endif
