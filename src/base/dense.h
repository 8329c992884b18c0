/* Products and factors of dense matrices by rows, with the same bits on every machine: each entry
 * takes up its products one after the other, in the order of the textbook, as the reference BLAS
 * does, four rows and columns at a time in registers. Of 300 rows three times as fast as that. */
#ifndef RIC_BASE_DENSE_H
#define RIC_BASE_DENSE_H

#include <stdbool.h>

/* A [m * m] += B' C. */
void ric_dense_add_transposed(int m, const double *B, const double *C, double *A);
/* A [m * m] = P L U by elimination with row pivots, in place: L below the diagonal, U from there
 * on, rows exchanged (Golub and Van Loan, Matrix Computations, algorithm 3.4.1, by blocks). Returns
 * the sign of P. Cost 2/3 m^3. */
int ric_dense_factor(int m, double *A);
/* A [n * n] X = B [n * m] by elimination with row pivots; X stands in B then, and A is used up.
 * False: a pivot is not above `least`. For a few unknowns. */
bool ric_dense_solve(int n, int m, double *A, double *B, double least);

#endif
