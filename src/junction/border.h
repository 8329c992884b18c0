/* The article's square Jacobian J (eq. 29) and its bordered systems at linear cost (docs/theory.md
 * section 7).
 *
 * Unknowns of J: start state w_0 [2n], time fractions beta [N], period T; rows: closure w_N - w_0
 * [2n], one condition per event in the order of the fractions [N] (the phase under a power law,
 * where N = 1), sum of the fractions. With d tau_k = T d beta_k + beta_k dT the last row and the
 * period split off: what is left acts on (w_0, tau), and is made triangular from the right as in
 * shooting.c, one Householder reflection per condition. 2n combinations of the unknowns are left
 * for the 2n rows of the closure, the small matrix S: it has the kernel of J. Only S is bordered,
 *
 *     [ S   U ] [ z ]   [ r ]
 *     [ V'  0 ] [ g ] = [ s ],   U, V [2n * b] its own singular vectors of least value.
 *
 * All operations on columns are orthogonal, so that nothing grows but the times of impact, which
 * are unknowns, however unstable the orbit. Factorisation O(N n^2), each solve O(N n). States are
 * scaled by the size of w_0. */
#ifndef RIC_JUNCTION_BORDER_H
#define RIC_JUNCTION_BORDER_H

#include "orbit/room.h"

typedef struct {
    int n, N, unknowns; /* seen modes, flights, 2n + N */
    const ric_shooting *chain;
    double size, T; /* of w_0; the period */
    double *map,
        *rate; /* [N * stride], [N * 2n] of each flight, as the chain has them but for the moves */
    double *v, *beta;    /* [N * 2n], [N] Householder vector of each condition */
    double *pivot, *row; /* [N], [N * 2n] rows of the conditions */
    double *pinned; /* [N * 2n] what the pinned combination makes of the state at the condition */
    double *X;      /* [2n * 2n] live columns */
    double *K; /* [unknowns * 2n] combinations that are left for the closure, orthonormal columns */
    double *S; /* [2n * 2n] */
    double *left, *right,
        *sigma;      /* singular vectors in columns, in rows; values from the largest down, [2n] */
    double *small;   /* [(4n)^2] the bordered S, factorised */
    int *swap;       /* [4n] */
    int b;           /* columns of the border */
    double *U, *V;   /* [2n * b] rows of the closure; [unknowns * b] of (w_0, tau) */
    long operations; /* multiplications so far on columns of flights */
} ric_border;

/* NULL: no memory. For flights and borders of the size of this chain. */
ric_border *ric_border_create(const ric_shooting *chain);
void ric_border_free(ric_border *border);

/* Factorises at the last flight of the chain, in its general form and plain. Entries of the flights
 * are moved by `rounding` in the pattern of `bits`; 0 leaves them. False: J is not finite. */
bool ric_border_factor(ric_border *border, double rounding, unsigned bits);
/* Its singular values without vectors: `sigma`. False: LAPACK failed. */
bool ric_border_values(ric_border *border);
/* Borders of b columns, b <= 2n: those of `frame`, or its own where it is `border` itself, which
 * gives it its singular values and vectors. False: LAPACK failed, or what is bordered is singular.
 */
bool ric_border_set(ric_border *border, const ric_border *frame, int b);
/* [J U; V' 0] (x, g) = (r, s) for `count` right-hand sides at once: r, x [(unknowns + 1) * count]
 * in the order of J; s, g [b * count]. x NULL: only g is wanted. */
void ric_border_solve(ric_border *border, int count, const double *r, const double *s, double *x,
                      double *g);
/* What conditions r [N * count] make of the start state and of the end, [2n * count] each, while
 * the combinations that are left stay 0. */
void ric_border_conditions(ric_border *border, int count, const double *r, double *start,
                           double *end);
/* Column i of the last b of K by singular values, in the unknowns of the chain, [unknowns]. */
void ric_border_kernel(const ric_border *border, int i, double *du);

#endif
