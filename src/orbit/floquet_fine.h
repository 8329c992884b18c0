/* The map between sections of a chain of linear flights in extended precision (docs/theory.md
 * section 5).
 *
 * Where impacts are slow, their kicks go with 1 / speed, and products of them cancel: the map may
 * be larger by ten powers of ten than its trace. The orbit is then known much better than a product
 * in double says. It is flown again from its first state for its flight times, the columns along
 * with it, so that every kick belongs to one and the same orbit; the modes are those of the model,
 * as exactly as it has them, with and without closed springs. Cost
 * O(n_flight n^2), and O(n_flight n^3) where springs are closed. */
#ifndef RIC_ORBIT_FLOQUET_FINE_H
#define RIC_ORBIT_FLOQUET_FINE_H

#include "shooting.h"

typedef long double ric_fine_real;

/* Numbers that the map takes: `store` of ric_floquet_fine_map. */
size_t ric_floquet_fine_size(int n);
/* Whether a chain has such a map: not under a power law. */
bool ric_floquet_fine_fits(const ric_shooting *chain);
/* Newton's method in extended precision, from u to the nearest solution: orbit [2n + n_flight], its
 * start state and its times. *moved: the length of the first step. False: it does not converge. The
 * chain is evaluated at u afterwards. Cost of each step: one evaluation, and one flight of the
 * state alone in extended precision. */
bool ric_floquet_fine_orbit(ric_shooting *chain, const double *u, ric_fine_real *orbit,
                            double *moved);
/* The same, rounded, in place of u, where the chain is evaluated then. False, with u as it was: it
 * does not converge, or a power law. */
bool ric_floquet_fine_nearest(ric_shooting *chain, double *u);
/* P [2k * 2k], k = n - 1, at the start of `store`: coordinates in the section of the start mirror
 * to those in that of the end mirror, whose bases `start` and `end` [k * n] are given in double; in
 * the general form, which needs none, of the return to what is perpendicular to flow and gradient
 * (without sigma). *size: largest entry met. False: it is not finite. `orbit`: in more digits than
 * the chain has it, or NULL. */
bool ric_floquet_fine_map(const ric_shooting *chain, const ric_fine_real *orbit,
                          const double *start, const double *end, ric_fine_real *store,
                          double *size);

#endif
