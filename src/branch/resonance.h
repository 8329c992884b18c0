/* Where multipliers are roots of unity: the values of lambda + 1/lambda at which orbits of several
 * periods leave (docs/theory.md section 7). */
#ifndef RIC_BRANCH_RESONANCE_H
#define RIC_BRANCH_RESONANCE_H

#include <stdbool.h>

#include "model/room.h"

/* RIC_SEEN_TO: of 1 + |rho|: the error of a pair with which what is passed is seen; what is nearer
 * to a resonance is noise of the multipliers. */
#define RIC_SEEN_TO 1e-9

typedef struct {
    double rho; /* lambda + 1/lambda of the map in use: of half a period on orbits with z(t+T/2) =
                   -z(t), else of the period */
    int p, q;   /* rotation number over the period, in lowest terms; of p and q - p the smaller one
                   where rho is that of a period */
} ric_resonance;

/* All with 2 <= q <= largest, smallest rho first; *n their number. NULL with *n = 0 if there is
 * none, *n = -1: no memory. */
ric_resonance *ric_resonance_list(bool half, int largest, int *n);

/* A function that changes its sign where one of the pairs rho [2 * n_pair: re, im] passes `value`,
 * and is smooth where pairs meet. */
double ric_resonance_test(const double *rho, int n_pair, double value);
/* The same, 0 where one of them is no farther from it than its error [n_pair]: of such a pair it is
 * not known on which side it is. NAN where one is lost in rounding: the others do not tell what is
 * passed. */
double ric_resonance_side(const double *rho, const double *error, int n_pair, double value);

/* A mode that the contacts hardly feel keeps its frequency, and where its resonances lie is known
 * beforehand: at the periods T with omega_k T / 2 pi = p / q. How many of them, over all such modes
 * and all q up to `largest`, lie between two periods; at most 2 are counted. */
int ric_resonance_faint(const ric_model *model, int largest, double shorter, double longer);

#endif
