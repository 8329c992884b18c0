/* The orbit problem of a proof: all states right after the impacts and all flight times are
 * unknowns (multiple shooting), so that nothing grows along the orbit and no speed is divided by.
 *
 * Block k of the m blocks is (q_k, p_k, tau_k) [2n + 1]; the last one of a general chain has lambda
 * behind it. With Q_k the impact on face k and F the flight:
 *   Q_k+1 w_k+1 = F(tau_k) w_k,  s_k+1 c.q_k+1 = d_k+1                          (k = 0..m-2)
 *   general: s_0 c.q_0 = d_0,  w_0 = sigma (1 + lambda) Q_0 F(tau_m-1) w_m-1    (sigma = -1: half a
 *                              period)
 *   reversible: n conditions of a mirror point on w_0, n on F(tau_m-1) w_m-1    (docs/theory.md
 *   section 4)
 *   one number of x, v or tau of block `at` = held / 10^RIC_CHAIN_HELD         a plane across the
 *   curve of orbits
 * Flights and impacts keep the energy, so a zero has E(w_0) = (1 + lambda)^2 E(w_0): with E > 0 and
 * |lambda| < 1 it is lambda = 0, and the chain closes.
 * Springs: an event is also a spring that closes, or opens, and there Q = 1; each flight is that of
 * its phase (phase.h). At the event the spring is not pressed in, so that the energy, springs
 * included, stays what it is. */
#ifndef RIC_PROVE_CHAIN_H
#define RIC_PROVE_CHAIN_H

#include "phase.h"
#include "twins.h"

/* Decimals of the number that is held, lengths in d and times in 2^-time s: what rounds it moves an
 * orbit by no more than what is stored is off anyway. */
enum { RIC_CHAIN_HELD = 15 };

typedef enum {
    RIC_CHAIN_GENERAL,
    RIC_CHAIN_REST,
    RIC_CHAIN_IMPACT,
    RIC_CHAIN_CENTRE,
    RIC_CHAIN_TWIN, /* in flight; it goes back as its image under a permutation: of junctions alone
                     */
    RIC_CHAIN_BOTH  /* behind impacts of two contacts at one instant, at the beginning of junctions
                       alone (both.h) */
} ric_chain_end;

typedef struct {
    int n, m, size;           /* modes, blocks, numbers in a block */
    ric_chain_end start, end; /* of a general chain both are that */
    int sign;                 /* sigma */
    const ric_twin *twin;     /* that permutation, borrowed from the enclosure, or NULL */
    int *face;                /* [m + 1] where block k begins, and the end; -1: in flight */
    int also;                 /* BOTH: the other face where it begins */
    const ric_phase **phase;  /* [m] of the flight of block k, borrowed from the enclosure */
    int first;        /* the impact of the word, from 0, at or before which the chain begins */
    bool half_flight; /* it begins in the middle of the flight after that impact */
    arb_ptr u;        /* [m * size + 1] centre, exact; lambda last */
    int at, number; /* block of the plane, and which of its numbers is held (ric_chain_number); -1:
                       none yet */
    fmpz_t held;    /* at what, in units of 10^-RIC_CHAIN_HELD */
    arb_ptr
        row; /* [size] the derivative of that number, times 2^-scale so that its size is near 1 */
    slong scale;
} ric_chain;

/* The chain of an orbit: state right after impact 0 [2 n_dof], flights, word of `branch`, which
 * also says in which class it is looked for: with mirror points, half of a symmetric orbit, or in
 * general. To be released in any case. NULL, or why there is none. */
const char *ric_chain_create(ric_chain *c, const ric_enclosure *e, const ric_branch *branch,
                             const double *state, const double *flights);
/* The same in the class of another chain of the branch; false if the stored numbers are not finite.
 */
bool ric_chain_like(ric_chain *c, const ric_enclosure *e, const ric_branch *branch,
                    const double *state, const double *flights, const ric_chain *other);
/* The same without the contacts of no length in it, which are touches; false where it has none, or
 * nothing else. */
bool ric_chain_shorten(ric_chain *c, const ric_enclosure *e, const ric_branch *branch,
                       const double *state, const double *flights);
/* Of a linear mode, state [2 n_dof] anywhere on it: from rest to the centre, a quarter of the
 * period. */
bool ric_chain_mode(ric_chain *c, const ric_enclosure *e, const double *state, double period);
/* Room for m blocks, all zero. */
void ric_chain_allocate(ric_chain *c, const ric_enclosure *e, int m);
void ric_chain_copy(ric_chain *to, const ric_chain *from);
void ric_chain_free(ric_chain *c);
/* Whether the same equations hold for both. */
bool ric_chain_same_class(const ric_chain *a, const ric_chain *b);

static inline bool ric_chain_general(const ric_chain *c)
{
    return c->start == RIC_CHAIN_GENERAL;
}
static inline arb_ptr ric_chain_block(const ric_chain *c, int k)
{
    return c->u + (slong)k * c->size;
}
/* Numbers of block k: one more in the last of a general chain. */
static inline int ric_chain_width(const ric_chain *c, int k)
{
    return c->size + (ric_chain_general(c) && k == c->m - 1);
}
/* Whether the way back from a mirror point is an image of the way there. */
static inline bool ric_chain_turned(ric_chain_end end)
{
    return end == RIC_CHAIN_CENTRE || end == RIC_CHAIN_TWIN;
}
/* Whether half of the orbit is an image of the other half: the chain is half of it, or one of two
 * mirror points turns. */
static inline bool ric_chain_halved(const ric_chain *c)
{
    return ric_chain_general(c) ? c->sign < 0
                                : ric_chain_turned(c->start) != ric_chain_turned(c->end);
}
/* Whether x -> -x takes the orbit to itself. */
static inline bool ric_chain_symmetric(const ric_chain *c)
{
    return ric_chain_halved(c) && !c->twin;
}
/* Whether images under x -> -x of the chain belong to the orbit. */
static inline bool ric_chain_imaged(const ric_chain *c)
{
    return ric_chain_general(c) ? c->sign < 0
                                : c->start == RIC_CHAIN_CENTRE || c->end == RIC_CHAIN_CENTRE;
}
/* How often the chain lies in a period. */
static inline int ric_chain_copies(const ric_chain *c)
{
    return (ric_chain_general(c) ? 1 : 2) * (ric_chain_halved(c) ? 2 : 1);
}

/* (q, p) [2n] of x then v [2 n_dof], in d and seconds: midpoints. */
void ric_chain_state(const ric_enclosure *e, const double *state, arb_ptr w);
/* A number of a block: x [n_dof], then v [n_dof], then tau; and its derivative by (q, p, tau), out
 * [2n + 1]. */
void ric_chain_number(const ric_enclosure *e, arb_srcptr block, int number, arb_t out);
void ric_chain_number_row(const ric_enclosure *e, int number, arb_ptr out);
/* What the number of the plane is held at. */
void ric_chain_held(const ric_chain *c, slong prec, arb_t out);
/* out = F0(tau) w in a phase, [2n] each, out may not be w. */
void ric_chain_fly(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w, const arb_t tau,
                   arb_ptr out);
/* p <- Q p for the contact of `face`, where no spring is. */
void ric_chain_reflect(const ric_enclosure *e, int face, arb_ptr p);
/* c . x [n] of the contact of `face`. */
void ric_chain_along(const ric_enclosure *e, int face, arb_srcptr x, arb_t out);
/* RIC_AT_MIRROR: what is left of velocities, or displacements, at a mirror point, of those of the
 * motion: only where to begin is decided by it. */
#define RIC_AT_MIRROR 1e-6
/* Whether the motion goes back from the state w, [2n] each, as what came by `image`: it has its
 * places, and its velocities the other way round, by middles. */
bool ric_chain_goes_back(const ric_enclosure *e, arb_srcptr w, arb_srcptr image);
/* 1/2 p.p + 1/2 q.(L + R) q + 1/2 sum k (s - d)^2. */
void ric_chain_energy(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w, arb_t out);
/* (L + R + sum k c c') q [n] in a phase; and q'' = sum k d c less that. */
void ric_chain_stiffen(const ric_enclosure *e, const ric_phase *phase, arb_srcptr q, arb_ptr out);
void ric_chain_pull(const ric_enclosure *e, const ric_phase *phase, arb_srcptr q, arb_ptr out);
/* Whether zeros in u, balls of all blocks and lambda, have lambda = 0. */
bool ric_chain_closes(const ric_chain *c, const ric_enclosure *e, arb_srcptr u);
/* Whether the spring at the beginning of block k, or at the end of the chain, opens there. */
bool ric_chain_opens(const ric_chain *c, const ric_enclosure *e, int k);
/* Euclidean norm of n numbers, an upper bound as a ball. */
void ric_chain_norm(slong n, arb_srcptr x, slong prec, arb_t out);
/* slack (1 + |w|): what a flight of w [2n] over tau and its derivatives may have beyond the
 * enclosed modes. */
void ric_chain_slack(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w, const arb_t tau,
                     arb_t out);

#endif
