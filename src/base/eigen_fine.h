/* Single eigenvalues of a product of small matrices in extended precision, from what is known of
 * them in double. */
#ifndef RIC_BASE_EIGEN_FINE_H
#define RIC_BASE_EIGEN_FINE_H

#include <stdbool.h>

/* B C, [m * m] each, whose entries are uncertain by `rounding`; C NULL: B alone. */
typedef struct {
    int m;
    const long double *B, *C;
    long double rounding;
} ric_eigen_factors;

/* One eigenvalue of the product, mu [2] re, im, and its *error: in double on entry, in extended
 * precision on return; `apart`: how far the next one is. The error returned is measured by moving
 * the entries. Inverse iteration on [C, -1; -mu, B], which never forms the product: a small
 * eigenvalue beside large ones is known to the rounding of the factors (Golub and Van Loan, Matrix
 * Computations, section 7.6.1). Cost O(m^3). work [4 m^2 + 2 m] complex. False: the iteration
 * leaves what was known; mu and error are as they were. */
bool ric_eigen_fine(const ric_eigen_factors *product, double apart, long double _Complex *work,
                    double *mu, double *error);

#endif
