/* The shaken structure as the solver of exact forced orbits sees it (docs/forcing.md): all modes q,
 * displacements such that the normal of the first contact has length 1, time by 1/omega_ref,
 *     q'' = -omega^2 q - C q' - (springs) + level push cos(theta),    theta' = Omega.
 * A state z [2n] is (q, q'). Between two events the structure is linear for the set of springs that
 * are closed, and flights are closed forms (force_frame.c); under a power law they are summed as
 * series (force_series.c). */
#ifndef RIC_FORCE_FORCE_MEDIUM_H
#define RIC_FORCE_FORCE_MEDIUM_H

#include <complex.h>

#include "force.h"

/* What may be varied. omega in the unit 1/time above, level a physical amplitude. */
typedef struct {
    double omega, level, restitution;
} ric_force_drive;

/* The structure with some springs closed: z = V y, whose coordinates decay and turn by themselves.
 */
typedef struct ric_force_frame {
    struct ric_force_frame *next;
    uint64_t closed;
    bool plain; /* y = z: damping couples no modes, and no spring is closed */
    double *alpha,
        *beta;     /* [2n] not plain: eigenvalues alpha + i beta, pairs in a row, beta > 0 first */
    double *V, *W; /* [2n * 2n] and its inverse; not plain */
    double *rest;  /* [2n] equilibrium */
    double omega;  /* of the force, for which holds: */
    double _Complex *answer, *slope; /* [2n] steady answer to level 1, Re(answer e^{i theta}), and
                                        its derivative by omega */
} ric_force_frame;

typedef struct {
    const ric_force *force; /* borrowed */
    const ric_model *model;
    int n;
    bool smooth;       /* power law: no events */
    double time, unit; /* omega_ref; of displacements */
    double *omega, *C, *push;
    double *normal; /* [n_contact * n] */
    double *gap;    /* [n_face] */
    double *spring; /* [n_contact] q'' = -spring (s - gap) c, or -spring s^exponent c; 0: rigid */
    ric_force_frame *frames;
    double *work;
} ric_force_medium;

ric_status ric_force_medium_create(const ric_force *force, ric_force_medium **out);
void ric_force_medium_free(ric_force_medium *medium);

/* dz/dt. */
void ric_force_medium_rate(const ric_force_medium *m, uint64_t closed, const ric_force_drive *d,
                           double theta, const double *z, double *rate);
/* p <- p - (1 + e) (c.p)/(c.c) c of the columns of p [n * ld]; springs leave it. */
void ric_force_medium_strike(const ric_force_medium *m, double restitution, int face, int ld,
                             double *p);
/* Normal of the contact of a face [n]. */
const double *ric_force_medium_normal(const ric_force_medium *m, int face);
/* side * (c.q): larger than the gap beyond the face; the same of speeds. */
double ric_force_medium_towards(const ric_force_medium *m, int face, const double *q);
bool ric_force_medium_rigid(const ric_force_medium *m, int face);

/* ------------------------------------------------------------ force_frame.c */

/* Columns of D [2n * (2n + 3)] of a flight: derivatives by the state, and by these. */
enum { RIC_BY_THETA, RIC_BY_OMEGA, RIC_BY_LEVEL, RIC_BY_COUNT };

/* Where a flight begins. */
typedef struct {
    uint64_t closed; /* springs */
    const ric_force_drive *drive;
    double theta;    /* phase of the force */
    const double *z; /* [2n] */
} ric_force_start;

/* z1 [2n] after tau, which may be the z of the start; D may be NULL. RIC_E_NUMERIC, with the
 * remedy: the force resonates with a mode that is not damped, or modes are too near to critical
 * damping to be told apart. O(n^2), O(n^3) with D. */
ric_status ric_force_frame_fly(ric_force_medium *m, const ric_force_start *start, double tau,
                               double *z1, double *D);
ric_status ric_force_frame_find(ric_force_medium *m, uint64_t closed, double omega,
                                const ric_force_frame **out);
void ric_force_frame_free(ric_force_frame *frame);
/* e^{-delta tau} times cos, and sin / frequency, of a damped mode. */
void ric_force_frame_decay(double omega, double delta, double tau, double *c, double *s);

/* One linear reading s = row . z along a flight, and a bound of |s''| (row [2n]). */
typedef struct {
    const ric_force_medium *medium;
    const ric_force_frame *frame;
    const double *row;
    double *y; /* [2n] coordinates of the deviation from the steady answer at the start, times the
                  row: */
    double *weight; /* [2n] */
    double rest, theta, omega, bend;
    double _Complex steady;
} ric_force_reading;
/* room [4n] is kept by the reading. */
ric_status ric_force_frame_read(ric_force_medium *m, const ric_force_start *start,
                                const double *row, double *room, ric_force_reading *out);
/* s and ds/dt at t. */
double ric_force_frame_look(const ric_force_reading *r, double t, double *slope);

/* ----------------------------------------------------------- force_series.c */

/* The same under power laws, summed as series. */
ric_status ric_force_series_fly(ric_force_medium *m, const ric_force_start *start, double tau,
                                double *z1, double *D);

#endif
