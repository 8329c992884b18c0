/* Two modes between stops in the numbers of a census: w = (a_1, a_2, p_1, p_2) with a_i = omega_i
 * q_i, in the units of enclosure.h. |w|^2 / 2 is the energy, flights turn the planes (a_i, p_i) by
 * omega_i t, an impact on face f turns p round in the normal c, and the gap of f closes where g.a =
 * d, g_i = c_i / omega_i: all of them are isometries of w, which is what the bounds of a census
 * rest on. */
#ifndef RIC_PROVE_CENSUS_PAIR_H
#define RIC_PROVE_CENSUS_PAIR_H

#include "ball.h"
#include "enclosure.h"

/* What flights leave open of w, its first, second and third derivatives, because of the part of the
 * structure that its modes do not diagonalise: ric_census_pair_create refuses where it is not far
 * below that. */
#define RIC_CENSUS_SLACK 0x1p-66

enum { RIC_CENSUS_FACES = 16 };

typedef struct {
    int mirror;
    ric_ball c[2], g[2], d; /* signed, so that d > 0 */
    ric_ball turn;          /* 2 / c.c */
    double c_size, g_size;  /* |c|, |g|, upper bounds */
} ric_census_face;

typedef struct {
    const ric_enclosure *e;
    ric_ball omega[2];
    int n_face;
    bool mirrored; /* x -> -x takes the structure to itself */
    ric_census_face face[RIC_CENSUS_FACES];
    double top;            /* an upper bound of the larger omega */
    ric_ball energy;       /* 1/2 |w|^2 */
    double size;           /* |w|, an upper bound */
    double longest_period; /* for which the slack holds */
    /* cosines and sines of omega_i k spacing, 0 <= k < n_turn (census_turn.c) */
    double spacing;
    int n_turn;
    ric_ball *turns; /* [n_turn * 4] cos, sin of both modes */
} ric_census_pair;

/* false, with the reason in `why`, for what a census does not do. energy: scaled (docs/theory.md);
 * period: an upper bound, in units of the enclosure. */
bool ric_census_pair_create(ric_census_pair *p, const ric_enclosure *e, double energy,
                            double period, char why[160]);
void ric_census_pair_free(ric_census_pair *p);

/* Makes a table of turns up to a time, without which each is asked of Arb; false: no memory. */
bool ric_census_turns(ric_census_pair *p, double longest);
/* cos and sin of omega_i t, exact t. */
void ric_census_turn(const ric_census_pair *p, double t, ric_ball cosine[2], ric_ball sine[2]);
/* w <- F(t) w, of a turn; w <- Q w. */
void ric_census_fly(const ric_ball cosine[2], const ric_ball sine[2], ric_ball w[4]);
void ric_census_reflect(const ric_census_face *f, ric_ball w[4]);
/* g.a and c.p. */
ric_ball ric_census_place(const ric_census_face *f, const ric_ball w[4]);
ric_ball ric_census_speed(const ric_census_face *f, const ric_ball w[4]);

#endif
