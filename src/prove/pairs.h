/* Whether d numbers lie in (-2, 2), real and apart, or one of them off [-2, 2], from the sums of
 * their powers: those of pairs of multipliers, rho = x + 1/x, along a line. */
#ifndef RIC_PROVE_PAIRS_H
#define RIC_PROVE_PAIRS_H

#include "line.h"
#include "orbit/room.h"

enum { RIC_PAIRS_MOST = 7 };

/* sum [d]: of rho, of rho^2, .. of rho^d, d <= RIC_PAIRS_MOST. */
ric_stability ric_pairs_judge(int d, const ric_line *sum);

#endif
