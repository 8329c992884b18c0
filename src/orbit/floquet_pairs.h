/* Pairs of multipliers, rho = lambda + 1 / lambda, as eigenvalues of what a map gives, each with
 * what is known of it (docs/theory.md section 5).
 *
 * A map is far from normal beside a slow impact and where pairs meet: with entries of 1e3 in it a
 * rho of 3.0 was off by 2.4e-5, thirty times the rounding of the map. */
#ifndef RIC_ORBIT_FLOQUET_PAIRS_H
#define RIC_ORBIT_FLOQUET_PAIRS_H

#include <complex.h>
#include <stdbool.h>

typedef struct {
    int count;     /* k */
    double *rho;   /* [2k] re, im */
    double *error; /* [k] of the matrix that it is an eigenvalue of, or what was measured of it */
    double *alone; /* [k] of each itself if no other is beside it: error times its condition, or
                      error again */
    double *condition; /* [k] by how much more than the error of the matrix each moves */
} ric_floquet_pairs;

/* The larger multiplier of a pair; the other is its inverse, without cancellation. */
double complex ric_floquet_pairs_large(const double *rho);
/* Its relative error where rho has the error e: d lambda / lambda = d rho / (lambda - 1 / lambda),
 * and where the two meet, at +-1, the root of e. */
double ric_floquet_pairs_large_error(const double *rho, double e);

/* H = 2 + 4 b'c [k * k], and its eigenvalues: the product knows every rho to the rounding of the
 * largest. */
void ric_floquet_pairs_product(int k, const double *b, const double *c, int exponent, double *H);
/* rho of H, and the condition of each, HUGE_VAL where it was not `asked` for. work [k * k]. */
bool ric_floquet_pairs_of_matrix(const double *H, bool asked, double *work, ric_floquet_pairs *out);
/* What is known of rho whose conditions are those in a matrix [size * size], if its entries are off
 * by `error`. */
void ric_floquet_pairs_allow(int size, const double *matrix, double error, ric_floquet_pairs *out);
/* rho = 2 + 4 eig(b'c) where the rounding of the largest matters. b and c are off by `rounding`.
 * work [4 k^2]. */
bool ric_floquet_pairs_of_blocks(const double *b, const double *c, int exponent, double rounding,
                                 double *work, ric_floquet_pairs *out);

/* A + sigma B^-1 for a symplectic B [2k * 2k]: B^-1 = -J B' J. */
void ric_floquet_pairs_inverse(int k, const double *A, int sigma, const double *B, double *out);
/* 2k eigenvalues, each there twice, as k; apart [k]: half the distance of the two. */
void ric_floquet_pairs_up(int k, const double *all, double *rho, double *apart);
/* rho from A = M + M^-1 [2k * 2k] of the return map M, used up. */
bool ric_floquet_pairs_of_period(double *A, ric_floquet_pairs *out);
/* The conditions of rho that were found otherwise. In M + M^-1, where each rho is there twice, it
 * has no condition of its own: in M it has. */
void ric_floquet_pairs_conditions(const double *M, ric_floquet_pairs *out);

#endif
