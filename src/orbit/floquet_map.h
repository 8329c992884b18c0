/* The map of a chain between the sections at its ends, in double (docs/theory.md section 5): what
 * floquet.c reads multipliers off, with the sizes from which it bounds their error. */
#ifndef RIC_ORBIT_FLOQUET_MAP_H
#define RIC_ORBIT_FLOQUET_MAP_H

#include "floquet.h"
#include "floquet_pairs.h"

/* Rounding of one flight and impact, in units of DBL_EPSILON: measured against 40-digit arithmetic,
 * with a margin. */
#define RIC_FLOQUET_ROUNDING 16.0
/* RIC_FLOQUET_MOST_PAIRS: up to which the halves are taken apart, or extended precision is used:
 * they need 32 k^2 numbers */
#define RIC_FLOQUET_MOST_PAIRS 64

/* The map P [2k * 2k], k = n - 1, times 2^exponent, its blocks [k * k] and the bases of its
 * sections [k * n] of a reversible chain, and the workspace that is left. All of it lies in
 * f->work. growth: largest entry on the way; size: the same with those of P. */
typedef struct {
    double *P, *E0, *E1, *a, *b, *c, *d, *A, *tmp, growth, size;
    int exponent;
} ric_floquet_linear;

/* Of a reversible chain, and the determinants of its blocks. */
ric_floquet_linear ric_floquet_map_reversible(const ric_shooting *chain, ric_floquet *f);
/* Of the return in the general form, with sigma, and its determinant: a multiplier -1 of the
 * half-period map breaks z(t+T/2) = -z(t). */
ric_floquet_linear ric_floquet_map_whole(const ric_shooting *chain, ric_floquet *f);
/* Pairs of the general form from two halves of the return map, M = sigma P2 P1, M + M^-1 + 2 =
 * sigma (P2 + sigma P1^-1) (P1 + sigma P2^-1): the factors have the square root of the size of M.
 * work [28 k^2], V [2n * 2k]. False: it cannot be done. */
bool ric_floquet_map_halves(const ric_shooting *chain, double *work, double *V,
                            ric_floquet_pairs *out);
/* Blocks [k * k] from P; a centre exchanges the roles of q and p, (Q, P) = (dp, -dq), so that P
 * stays symplectic. */
void ric_floquet_map_blocks(const ric_shooting *chain, const double *P, double *a, double *b,
                            double *c, double *d);
/* Roundings that neighbours of the orbit go through, which the times of springs move, in units of
 * RIC_FLOQUET_ROUNDING. */
double ric_floquet_map_roundings(const ric_shooting *chain);
/* Of A [k * k], rows ld apart; *error: when every entry may be off by `rounding`: the smallest
 * pivot decides whether it has a sign. work [k * k]. */
double ric_floquet_map_determinant(int k, int ld, const double *A, double *work, double rounding,
                                   double *error);

#endif
