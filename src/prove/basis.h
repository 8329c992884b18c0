/* A basis in which a symmetric K is all but diagonal, exactly orthonormal in M: refined from any
 * near guess, then enclosed. */
#ifndef RIC_PROVE_BASIS_H
#define RIC_PROVE_BASIS_H

#include "arb_numbers.h"

enum { RIC_BASIS_GUARD = 96 }; /* bits that the basis has beyond those computed with */

typedef struct {
    int n;
    slong bits, prec; /* computed with; those of the basis */
    arb_mat_t M, K;   /* [n * n] */
    arb_mat_t X;      /* [n * n] the guess, refined in place */
    arb_mat_t R, S, W;
} ric_basis;

/* X' K X = L + R: the diagonal L [n], exact, its roots, |R| <= rho, and 1 + the largest of L or
 * of 1. */
typedef struct {
    arb_ptr omega, square;
    arb_ptr rho, top;
} ric_squares;

void ric_basis_open(ric_basis *z, int n, slong bits);
void ric_basis_close(ric_basis *z);
void ric_basis_refine(ric_basis *z);
/* X [n * k], k <= n, becomes exactly orthonormal in M, in balls; false where it was far from it.
 * error: scratch. */
bool ric_basis_orthonormalise(const ric_basis *z, arb_mat_t X, arb_t error);
/* Of such columns; false if an entry of L is negative. An entry of rounding size counts as zero. */
bool ric_basis_squares(const ric_basis *z, const arb_mat_t X, ric_squares *out);

#endif
