/* The impact-to-impact map at one energy, for structures with two seen modes (docs/theory.md
 * section 11, hunt).
 *
 * A motion of energy E that has just left face f is known by two numbers: y, its place along the
 * face, and the angle of its velocity. With n the unit normal of the face in modal coordinates and
 * e perpendicular to n,
 *     q = at n + y e,   dq/dt = P (sin(angle) e - side cos(angle) n),   P = sqrt(2 (E - V(q))),   V
 *                       = sum omega_i^2
 * q_i^2 / 2. The impact turns the normal part round, so that the angle may be taken before or after
 * it, and an impact of no speed, a grazing, is a regular place, |angle| = pi/2. The map preserves
 * the area dy d(P sin(angle)). All of it is made from the frame of the simulator and shares nothing
 * with the chains that solve the orbits of an atlas. */
#ifndef RIC_HUNT_IMPACT_MAP_H
#define RIC_HUNT_IMPACT_MAP_H

#include "ricochet.h"

typedef struct {
    int contact, side, mirror; /* mirror: face on the other side, -1 if none */
    double normal[2], along[2], at;
    double clearance;         /* at = side * clearance / |c| */
    double norm;              /* |c| */
    double middle, radius[2]; /* motions on the face: ((y - middle) / radius[0])^2 + (P sin(angle) /
                                 radius[1])^2 < 1; radius 0: out of reach */
} ric_impact_map_face;

typedef struct {
    const ric_model *model;
    ric_simulator *sim;
    int n_dof, mode[2]; /* of the simulator's frame */
    double omega[2], energy;
    double panel, turn[4]; /* a search step, and cos and sin of it per mode */
    int n_face;
    ric_impact_map_face *face;
} ric_impact_map;

/* An impact: its face, the two numbers, and the time to the next one (seconds). */
typedef struct {
    int face;
    double y, angle, tau;
} ric_hit;

/* RIC_E_INPUT unless exactly two modes are seen by rigid stops without losses. */
ric_status ric_impact_map_create(const ric_model *model, double energy, ric_impact_map **out);
void ric_impact_map_free(ric_impact_map *section);

/* P at a place on a face; 0 out of reach. */
double ric_impact_map_speed(const ric_impact_map *section, int face, double y);
/* Modal state w [4] = q, dq/dt right after an impact; false where there is no such motion at this
 * energy. */
bool ric_impact_map_state(const ric_impact_map *section, const ric_hit *hit, double *w);
/* Whether a modal state is on this side of all faces but one (-1: of all). */
bool ric_impact_map_inside(const ric_impact_map *section, const double *w, int but);
/* The next impact of a motion w that leaves face `from` (-1: starts in flight), within `horizon`:
 * its time, and what w is right after it. Impacts slower than the search resolves may be missed:
 * what is found here is checked with the simulator. */
bool ric_impact_map_next(const ric_impact_map *section, const double *w, int from, double horizon,
                         double *time, ric_hit *hit, double *after);
/* The matrix D [4] of (y, angle) -> (y', angle') over the flight from a to the face of b; false at
 * a grazing. */
bool ric_impact_map_slope(const ric_impact_map *section, const ric_hit *a, const ric_hit *b,
                          double *D);

/* Newton's method on all impacts of an orbit and all times at once: impact k flies for tau_k onto
 * impact k + 1, the last one onto the first one, mirrored by x -> -x if `half`. hits [N] are moved
 * to the solution; work [ric_impact_map_work(N)]. */
bool ric_impact_map_polish(const ric_impact_map *section, int N, bool half, ric_hit *hits,
                           double *work);
size_t ric_impact_map_work(int N);

/* Whether the simulator makes the same motion of it, flight by flight, and sees no other touch. */
bool ric_impact_map_admissible(const ric_impact_map *section, int N, const ric_hit *hits);
/* The matrix of the whole way round, D [4]: product of the slopes. */
bool ric_impact_map_around(const ric_impact_map *section, int N, const ric_hit *hits, double *D);

/* Scaled x, v [n_dof each] right after an impact, unseen modes at rest; and back: the impact of a
 * state on a face. */
void ric_impact_map_write(const ric_impact_map *section, const ric_hit *hit, double *x, double *v);
void ric_impact_map_read(const ric_impact_map *section, int face, const double *x, const double *v,
                         ric_hit *hit);

/* The image of an impact under x -> -x, and under time reversal (tau is left alone). */
ric_hit ric_impact_map_mirrored(const ric_impact_map *section, ric_hit hit);
ric_hit ric_impact_map_reversed(ric_hit hit);

#endif
