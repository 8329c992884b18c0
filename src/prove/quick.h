/* What factor.h does, in doubles with bounds of their rounding: for all orbits whose equations are
 * not all but singular, and ten times as fast.
 *
 * D is taken as the doubles nearest to its balls, and what that leaves out, what the products of
 * A = D'D are rounded by and what |L L' - (A - alpha)| is computed with are bounded in the
 * Frobenius norm, block by block: a sum of k products is off by at most 2 k u of the sum of their
 * sizes for k u < 1/2 in any order (Higham, Accuracy and Stability of Numerical Algorithms, 2002,
 * section 3.1), u = 2^-53, and the sums of sizes are at most products of norms. Numbers that are
 * none make every bound one that is none. */
#ifndef RIC_PROVE_QUICK_H
#define RIC_PROVE_QUICK_H

#include "equations.h"

typedef struct {
    int rows, first, second; /* blocks, as in ric_equation_group */
    double *J, *K;           /* [rows * wide] */
} ric_quick_group;

typedef struct {
    int m, n, size, wide;      /* blocks, groups, numbers in a block and in the last one */
    bool corner;               /* a group joins the last block to the first one */
    ric_quick_group *group;    /* [n] */
    double *A, *U, *L, *G, *H; /* [m] blocks of wide * wide, as in ric_factor */
    double *off_A, *off_U;     /* [m] what they are off by, at most */
    double *work;              /* [2 wide * wide] */
    double *row, *spare;       /* vectors of all rows; of all unknowns */
} ric_quick;

void ric_quick_create(ric_quick *f, const ric_chain *c);
void ric_quick_free(ric_quick *f);
/* D from J and K of the equations, and A = D'D. */
void ric_quick_assemble(ric_quick *f, const ric_equations *q);
/* L of A - alpha; false if that is not positive. */
bool ric_quick_make(ric_quick *f, double alpha);
/* x [unknowns] <- (L L')^-1 x, approximately. */
void ric_quick_solve(const ric_quick *f, double *x);
/* x [unknowns] <- what D x = F has, approximately, F that of the equations. */
void ric_quick_step(const ric_quick *f, const ric_equations *q, double *x);
/* An upper bound of |L L' - (A - alpha)|. */
double ric_quick_residual(const ric_quick *f, double alpha);

static inline int ric_quick_unknowns(const ric_quick *f)
{
    return (f->m - 1) * f->size + f->wide;
}

#endif
