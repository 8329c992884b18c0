/* A structure with its damping and its force, in all modes, seen or not (docs/forcing.md).
 *
 * q = Phi' M x [n], lengths scaled by the clearance d, p = dq/dt per second:
 *     dp/dt = -omega^2 q - C p + L g cos(Omega t + phase),    g = Phi' f / d,
 * where L is the amplitude and f the vector of the force, both physical. */
#ifndef RIC_FORCE_FORCE_H
#define RIC_FORCE_FORCE_H

#include "model/room.h"
#include "orbit/room.h"

struct ric_force {
    const ric_atlas *atlas; /* borrowed */
    const ric_model *model;
    int n;
    double *into;       /* [n * n] Phi' M */
    double *g;          /* [n] */
    double *C;          /* [n * n] modal damping, 1/s */
    bool diagonal;      /* C is */
    bool lossless;      /* C is 0 */
    double restitution; /* (0, 1] */
};

/* An orbit of the atlas as a list of events, at its state; NULL: no memory. */
ric_periodic *ric_force_cycle(const ric_force *force, const ric_orbit *orbit, const double *state);
/* Modal displacements and speeds of a public state. */
void ric_force_modal(const ric_force *force, const double *x, const double *v, double *q,
                     double *p);

/* What a motion loses and receives. */
typedef struct {
    double damping, impacts; /* scaled energies */
    double
        work[2];  /* int f.x' e^{i Omega t} dt over d^2: scaled energy for a force of amplitude 1 */
    double size;  /* of the integrand of the work: a work below rounding of it is none */
    double error; /* what quadrature may have left of either, relative to its size */
} ric_force_balance;

/* Over one period of an orbit, the force at Omega = harmonic * omega with phase 0 at its start;
 * `linear`: it meets no contact (force_balance.c). */
ric_status ric_force_balance_of(const ric_force *force, const ric_orbit *orbit, bool linear,
                                int harmonic, ric_force_balance *out);
/* Whether the force does work on it, or what there is of it is rounding (force_predict.c). */
bool ric_force_predict_works(const ric_force_balance *sum);
/* ric_force_predict without its `stable`, which is left undecided. */
ric_status ric_force_predict_balance(const ric_force *force, int branch, const ric_orbit *orbit,
                                     int harmonic, double level, ric_prediction *out);

#endif
