/* Ball arithmetic: the headers of Arb, which lie in FLINT from its version 3 on. A ball is a centre
 * and a radius, and every operation encloses the result for all numbers of its operands (Johansson,
 * IEEE Trans. Comput. 66 (2017) 1281-1292). A comparison is true only if it holds for all of them,
 * so that a ball that is not a number answers no. */
#ifndef RIC_PROVE_ARB_NUMBERS_H
#define RIC_PROVE_ARB_NUMBERS_H

#if __has_include(<flint/arb.h>)
#include <flint/arb.h>
#include <flint/arb_mat.h>
#include <flint/arb_poly.h>
#include <flint/acb_poly.h>
#else
#include <acb_poly.h>
#include <arb.h>
#include <arb_mat.h>
#include <arb_poly.h>
#endif
#include <flint/fmpq.h>
#include <flint/fmpq_mat.h>

#include <stdbool.h>

/* x to the nearest double, as arf_get_d with ARF_RND_NEAR. */
double ric_arb_nearest(const arf_t x);
/* The centre, rounded; for guesses. */
static inline double ric_arb_middle(const arb_t x)
{
    return ric_arb_nearest(arb_midref(x));
}
/* A <- 0: of large matrices, in which few numbers are anything else. */
void ric_arb_clean(arb_mat_t A);
/* Bounds of x, rounded outwards. */
void ric_arb_interval(const arb_t x, double out[2]);
/* x [n * 1] becomes x / |x| without its radii; false if that is nothing. */
bool ric_arb_normalise(arb_mat_t x, slong prec);

#endif
