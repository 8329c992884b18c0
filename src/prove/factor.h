/* Bounds of the inverse of the derivative D of the equations at linear cost.
 *
 * A = D'D is block tridiagonal but for a corner, and positive. With any L: if |L L' - (A - alpha)|
 * <= delta in the Frobenius norm, then A >= alpha - delta, and |D^-1| <= (alpha - delta)^-1/2. L
 * comes from a Cholesky factorisation without enclosures, and only the product is enclosed, block
 * by block: nothing recurs, so nothing grows along the orbit (Rump, Acta Numerica 19 (2010)
 * 287-449, section 10). */
#ifndef RIC_PROVE_FACTOR_H
#define RIC_PROVE_FACTOR_H

#include "equations.h"

typedef struct {
    int m;
    slong prec;
    arb_mat_t *A; /* [m] diagonal blocks, in balls */
    arb_mat_t *U; /* [m] blocks (k, k + 1); [m - 1] is the corner (0, m - 1), apart from U[0] where
                     m = 2 */
    arb_mat_t *L; /* [m] lower triangles, exact */
    arb_mat_t *G; /* [m] L_k^-1 of block (k, k + 1), exact */
    arb_mat_t *H; /* [m] the same of (k, m - 1): what a corner fills in */
} ric_factor;

void ric_factor_create(ric_factor *f, const ric_chain *c, slong prec);
void ric_factor_free(ric_factor *f);
/* A = D'D. */
void ric_factor_assemble(ric_factor *f, const ric_equations *q);
/* L of A - alpha, alpha exact; false if that is not positive. */
bool ric_factor_make(ric_factor *f, const arb_t alpha);
/* x [m blocks] <- (L L')^-1 x, approximately. */
void ric_factor_solve(const ric_factor *f, arb_mat_t *x);
/* An upper bound of |L L' - (A - alpha)|. */
void ric_factor_residual(const ric_factor *f, const arb_t alpha, arb_t out);

#endif
