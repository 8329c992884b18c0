/* Gauss's elimination in doubles of the middle of a matrix of balls, whose equations are in a band
 * but for some rows: what is zero is passed over. Nothing is bounded: whoever takes what it gives
 * bounds what that leaves. */
#ifndef RIC_PROVE_LU_H
#define RIC_PROVE_LU_H

#include <stdbool.h>

#include "arb_numbers.h"

typedef struct {
    slong n;
    double *a;    /* [n * n] both factors, row by row */
    slong *order; /* [n] of their rows */
} ric_lu;

void ric_lu_create(ric_lu *f, slong n);
void ric_lu_free(ric_lu *f);
/* false where a pivot is exactly zero. */
bool ric_lu_make(ric_lu *f, const arb_mat_t J);
/* C [n * n] <- the inverse, column by column. */
void ric_lu_invert(const ric_lu *f, double *C);
/* out [n] <- the inverse times x. */
void ric_lu_solve(const ric_lu *f, const double *x, double *out);

#endif
