/* The exact forced problem (docs/forcing.md): a closed list of flights between events, in
 * `harmonic` periods of the force.
 *
 * Unknown of flight k: the state z_k [2n] right after event k, the phase theta_k of the force
 * there, and the time tau_k to event k + 1: m = 2n + 2 numbers. Its m equations: the next state,
 * the next phase, and the gap at event k + 1. Without events (a motion that meets no stop, or under
 * a power law) the flights are equal parts of the time, and theta_0 = 0. One parameter may be free:
 * then one row more, on the unknowns of flight 0 and the parameter.
 *
 * The matrix is block bidiagonal but for the closure. Flights 1 .. N - 1 are eliminated one after
 * the other by Householder reflections of 2m rows (structured orthogonal factorisation, Wright,
 * SIAM J. Sci. Stat. Comput. 13 (1992)), which is stable for unstable orbits; what is left is one
 * dense system of m + 1 unknowns. Time and memory O(N m^3) and O(N m^2). */
#ifndef RIC_FORCE_FORCE_ORBIT_H
#define RIC_FORCE_FORCE_ORBIT_H

#include "force_medium.h"

typedef enum { RIC_ALONG_OMEGA, RIC_ALONG_LEVEL, RIC_ALONG_RESTITUTION } ric_force_along;

typedef struct {
    ric_force_medium *medium; /* borrowed */
    int n, N, m, harmonic;
    bool events;      /* flights end at faces */
    int *face;        /* [N] at the start of flight k */
    uint64_t *closed; /* [N] springs that are closed in flight k */
    double *u;        /* [N * m] */
    ric_force_drive drive;
    double residual; /* relative, of the last correction */
    double *room;    /* of the elimination */
} ric_force_orbit;

/* face, closed [N]; face NULL: no events. */
ric_status ric_force_orbit_create(ric_force_medium *medium, int N, const int *face,
                                  const uint64_t *closed, int harmonic, ric_force_orbit **out);
ric_force_orbit *ric_force_orbit_copy(const ric_force_orbit *orbit);
/* u and the drive of another one of the same shape. */
void ric_force_orbit_take(ric_force_orbit *orbit, const ric_force_orbit *from);
void ric_force_orbit_free(ric_force_orbit *orbit);

/* Event that ends flight k, -1 if none does. */
static inline int ric_force_orbit_end(const ric_force_orbit *o, int k)
{
    return o->events ? o->face[(k + 1) % o->N] : -1;
}
static inline double *ric_force_orbit_node(const ric_force_orbit *o, int k)
{
    return o->u + (size_t)k * (size_t)o->m;
}
static inline double ric_force_orbit_theta(const ric_force_orbit *o, int k)
{
    return ric_force_orbit_node(o, k)[2 * o->n];
}
static inline double ric_force_orbit_tau(const ric_force_orbit *o, int k)
{
    return ric_force_orbit_node(o, k)[2 * o->n + 1];
}
static inline ric_force_start ric_force_orbit_start(const ric_force_orbit *o, int k)
{
    return (ric_force_start){o->closed[k], &o->drive, ric_force_orbit_theta(o, k),
                             ric_force_orbit_node(o, k)};
}
double *ric_force_orbit_parameter(ric_force_orbit *o, ric_force_along along);
double ric_force_orbit_period(const ric_force_orbit *o);
/* States of all flights but the first, from it and the flight times. */
ric_status ric_force_orbit_spread(ric_force_orbit *o);

/* Newton's method. row [m + 1], NULL: the parameter is held; else row . (first unknowns, parameter
 * / scale) = aim. True: solved to rounding; *steps, unless NULL, how many it took. */
bool ric_force_orbit_solve(ric_force_orbit *o, ric_force_along along, double scale,
                           const double *row, double aim, int *steps);
/* Direction [N m + 1] of the curve at a solved orbit, its part [m + 1] on (first unknowns,
 * parameter / scale) of length one, with a positive product with row [m + 1]. */
bool ric_force_orbit_tangent(ric_force_orbit *o, ric_force_along along, double scale,
                             const double *row, double *out);
/* The other direction [N m + 1] in the kernel, where there are two: perpendicular to `tangent` [m +
 * 1], and of length one on the first unknowns and the parameter. *second: the smallest singular
 * value but one, relative, 0 at a crossing. */
bool ric_force_orbit_aside(ric_force_orbit *o, ric_force_along along, double scale,
                           const double *tangent, double *out, double *second);
/* To the branch point next to the orbit, which lies beside it on a curve: known to rounding, where
 * curve and orbit by themselves are known to the third root of it. False: it is not found, and the
 * orbit is what it was. */
bool ric_force_orbit_branch_point(ric_force_orbit *o, ric_force_along along, double scale);

#endif
