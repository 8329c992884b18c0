/* The orbit problem where its Jacobian has a kernel of several dimensions, or nearly so
 * (docs/theory.md section 7): dense, from its singular values. Where branches meet, directions are
 * looked for in the kernel, and Newton's method goes on in what is left of the range.
 * O(n_unknown^3): for at most RIC_DENSE_MOST unknowns where time counts. */
#ifndef RIC_ORBIT_SINGULAR_H
#define RIC_ORBIT_SINGULAR_H

#include "shooting.h"

typedef struct {
    ric_shooting *chain;
    int unknowns, equations; /* equations: of the last factorisation */
    double *J;               /* [rows * unknowns] work */
    double *values;          /* [unknowns] singular values, from the largest down */
    double *right;           /* [unknowns * unknowns] right singular vectors in rows */
    double *left; /* [equations * equations] left ones in columns; NULL unless asked for */
    double *super, *memory;
} ric_singular;

ric_status ric_singular_create(ric_shooting *chain, bool left, ric_singular *out);
void ric_singular_free(ric_singular *singular);

/* At u, where the chain is flown. False: LAPACK failed, or there is no memory. */
bool ric_singular_factor(ric_singular *singular, const double *u);
/* Singular values that are above `least` of the largest. */
int ric_singular_rank(const ric_singular *singular, double least);
/* Whether the kernel has k dimensions, told from the next direction by a gap. */
bool ric_singular_opens(const ric_singular *singular, int k);
/* Its k last right singular vectors, [k * unknowns] rows. */
const double *ric_singular_kernel(const ric_singular *singular, int k);
/* The left singular vectors beyond the range that this leaves, in rows of [equations]; returns
 * their number, k or less. */
int ric_singular_cokernel(const ric_singular *singular, int k, double *out);
/* General form: the left null vector of the equation that says nothing new, out [equations] of unit
 * length, at the orbit where the chain was flown last: the closure, along the mean gradient of the
 * energy (section 3). */
void ric_singular_redundant(const ric_singular *singular, double *out);

/* One step of Newton's method from residuals r [equations] in the range of the `rank` largest
 * singular values: the shortest one; u [unknowns] moves. Returns the part of r that lies outside
 * that range. */
double ric_singular_step(const ric_singular *singular, int rank, const double *r, double *u);

/* Second derivative of the equations along `along` [unknowns] at u, by a central difference: out
 * [n_left * n_right] = left . (dJ/du along) right, left [n_left * equations], right [n_right *
 * unknowns] in rows. The chain's scale is that of its last flight. False: no memory. */
bool ric_singular_bend(ric_singular *singular, const double *u, const double *along, int n_left,
                       const double *left, int n_right, const double *right, double *out);

/* A direction t [size] of a kernel without its choice of sign: its largest component is positive.
 */
void ric_singular_orient(int size, double *t);

#endif
