/* Between augmented.c and augmented_rows.c: the equations of a junction, and the flights that they
 * are made of. */
#ifndef RIC_PROVE_AUGMENTED_ROWS_H
#define RIC_PROVE_AUGMENTED_ROWS_H

#include "augmented.h"

/* The equations and their derivative at z: F [n], J [n * n]. */
void ric_augmented_evaluate(ric_augmented *x, arb_srcptr z, arb_mat_struct *J, arb_ptr F);
/* How many motions beside the orbit they have. */
int ric_augmented_motions(const ric_augmented *x);
/* A turn of a chain without mirrors has a factor more, 1 + mu, behind the motions. */
bool ric_augmented_has_factor(const ric_augmented *x);

/* The derivative of a flight, D, and that of D in the direction of a motion's block, with what the
 * flights leave open of both. */
typedef struct {
    arb_mat_t D, second;
    arb_ptr flown;
} ric_augmented_flight;

/* In a phase over time tau; along: NULL, or [2n + 1]. */
void ric_augmented_flight_open(ric_augmented_flight *f, const ric_enclosure *e,
                               const ric_phase *phase, arb_srcptr w, const arb_t tau,
                               arb_srcptr along);
void ric_augmented_flight_close(ric_augmented_flight *f);

#endif
