/* The exact forced problem between rigid stops (docs/forcing.md): time by 1/omega_ref, modal displacements such that
 * the normal of the first contact has length 1. */
#ifndef RIC_FORCE_FORCE_EXACT_H
#define RIC_FORCE_FORCE_EXACT_H

#include "force.h"

typedef struct {
    int n, N;
    double Omega, period, restitution;
    double unit;           /* of modal displacements */
    double *omega, *delta; /* [n] frequency, and rate of decay: zeta omega */
    double *push;          /* [n] amplitude of the modal force */
    double *steady;        /* [2 n] re and im of its steady answer */
    double *normal;        /* [n_contact * n] */
    int *face;             /* [N] met at the end of flight k - 1, face[0] at that of the last one */
    double *gap;           /* [n_face] signed: side times where the face is */
    const ric_model *model;
} ric_force_exact;

/* Number of unknowns: state [2 n] right after impact 0, flights [N], phase of the force there. */
static inline int ric_force_exact_size(const ric_force_exact *e)
{
    return 2 * e->n + e->N + 1;
}

/* RIC_E_NUMERIC, with the remedy, where the force resonates with a mode that is not damped. */
ric_status ric_force_exact_create(const ric_force *force, int N, const int *word, double Omega, int harmonic,
                                  double level, ric_force_exact **out);
void ric_force_exact_free(ric_force_exact *exact);

/* Flight from z [2n] at phase: z1 [2n] after tau; turn [4n] (may be NULL): what it makes of deviations of each mode. */
void ric_force_exact_fly(const ric_force_exact *e, double tau, double phase, const double *z, double *turn, double *z1);
/* p <- p - (1 + e) (c.p)/(c.c) c of the columns of p [n * ld]. */
void ric_force_exact_strike(const ric_force_exact *e, int face, int ld, double *p);
/* dz/dt of a state. */
void ric_force_exact_rate(const ric_force_exact *e, double phase, const double *z, double *rate);
/* Newton's correction of u [size] to rounding; the relative residual that is left. False: it does not converge. */
bool ric_force_exact_solve(const ric_force_exact *e, double *u, double *residual);

/* force_motion.c: whether the solution is a motion: every impact approaches its face, no gap is passed in between. ""
 * or what forbids it. */
const char *ric_force_motion_fault(const ric_force_exact *e, const double *u);
/* Multipliers [4 n] of the stroboscopic map as re, im; `rounding`: what their size may be off by. False: LAPACK failed.
 */
bool ric_force_motion_multipliers(const ric_force_exact *e, const double *u, double *out, double *rounding);

#endif
