/* Eigenvalues of small dense matrices, and of products whose factors are kept apart. */
#ifndef RIC_BASE_EIGEN_H
#define RIC_BASE_EIGEN_H

#include <stdbool.h>

/* +move or -move, pseudorandomly: errors are measured by moving what is uncertain. */
static inline double ric_moved(unsigned *bits, double move)
{
    double way = *bits >> 31 ? move : -move;
    *bits = *bits * 1664525u + 1013904223u;
    return way;
}

/* re, im of the eigenvalues of A [k * k], destroyed: out [2k]. False: A is not finite, or LAPACK
 * failed. */
bool ric_eigen(int k, double *A, double *out);

/* The same, with the condition [k] of each: by how much more than the 2-norm of a small change of A
 * it moves, 1 / |y' x| of its left and right vectors of length one (Golub and Van Loan, Matrix
 * Computations, section 7.2.2). A stays, and is not balanced, which would tell the conditions of
 * another matrix. The vectors are those of the Schur form, whose angles are the same: they are not
 * taken back, which would take more time than all else. The Schur form is that of A', which has
 * another rounding than that of A. False also where there is no memory. */
bool ric_eigen_conditions(int k, const double *A, double *out, double *condition);

/* Whether a diagonal similarity makes A [k * k] no smaller than half of its size (Parlett and
 * Reinsch, Numer. Math. 13 (1969)), so that the eigenvalues of A as it is are off by no more than
 * twice what those of the balanced matrix are. work [k^2]. False also for what is not finite. */
bool ric_eigen_balanced(int k, const double *A, double *work);

/* mu [2m] = eigenvalues of B C, [m * m] each, sorted, and the error [m] of each, measured on
 * entries that are moved by `rounding` in three ways. The product knows small eigenvalues no better
 * than the rounding of the large ones, as it has the square of their size. With B = Q R P'
 * (pivoted) R P' C Q is similar to it, and its rows are graded from the large ones down, to which
 * the QR algorithm keeps: what cancels has the size of the factors, not of the product. H [3 m^2]
 * is workspace. */
bool ric_eigen_product(int m, const double *B, const double *C, double rounding, double *H,
                       double *mu, double *error);

#endif
