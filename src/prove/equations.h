/* The equations of a chain (chain.h) at its centre, and their derivatives, in groups of rows that
 * belong to one block of unknowns or to two. */
#ifndef RIC_PROVE_EQUATIONS_H
#define RIC_PROVE_EQUATIONS_H

#include "chain.h"

typedef struct {
    int rows, first, second; /* blocks; second: -1 if there is none */
    arb_mat_t J, K;          /* derivatives by the first and by the second block */
    arb_mat_t F;             /* [rows] */
} ric_equation_group;

typedef struct {
    int n; /* groups: m - 1 flights from impact to impact, the beginning, the end, the plane */
    ric_equation_group *group; /* [n] */
} ric_equations;

void ric_equation_create(ric_equations *q, const ric_chain *c);
void ric_equation_free(ric_equations *q);
/* Everything at the centre of the chain but for the slack of the flights, which `existence` weighs.
 */
void ric_equation_evaluate(ric_equations *q, const ric_chain *c, const ric_enclosure *e);
/* F alone; J and K stay those of where they were evaluated. */
void ric_equation_values(ric_equations *q, const ric_chain *c, const ric_enclosure *e);
/* The plane is another one now: F and derivatives of that, all else stays. */
void ric_equation_move_plane(ric_equations *q, const ric_chain *c, const ric_enclosure *e);

/* Adds to all of it what the slack of the flights may be, so that F and its derivatives hold those
 * of the structure: of `evaluate`, with NULL, or of `second`, with its direction. */
void ric_equation_loosen(ric_equations *q, const ric_chain *c, const ric_enclosure *e,
                         arb_srcptr along);
/* That of each flight, out [m]: an upper bound for every number of these rows, and of J and K. */
void ric_equation_slack(const ric_chain *c, const ric_enclosure *e, arb_srcptr along, arb_ptr out);
/* The first derivatives of all flights [m], for `second` in several directions. */
arb_mat_t *ric_equation_flights(const ric_chain *c, const ric_enclosure *e);
void ric_equation_flights_free(const ric_chain *c, arb_mat_t *flights);
/* J: the second derivatives, in the direction of `along` [m * size + 1] and one that is left open.
 * They couple no two blocks; all else is zero. */
void ric_equation_second(ric_equations *q, const ric_chain *c, const ric_enclosure *e,
                         arb_mat_t *flights, arb_srcptr along);

/* All but the plane in the first rows of J, whose columns are the unknowns, and in F; either may be
 * NULL. */
void ric_equation_gather(const ric_equations *q, const ric_chain *c, arb_mat_struct *J, arb_ptr F);

/* out = G' x [n] of all but the plane; x [m * size + 1]. */
void ric_equation_apply(const ric_equations *q, const ric_chain *c, arb_srcptr x, slong prec,
                        arb_ptr out);

static inline ric_equation_group *ric_equation_start(const ric_equations *q)
{
    return &q->group[q->n - 3];
}
static inline ric_equation_group *ric_equation_end(const ric_equations *q)
{
    return &q->group[q->n - 2];
}
static inline ric_equation_group *ric_equation_plane(const ric_equations *q)
{
    return &q->group[q->n - 1];
}

/* (q, p) <- (c q + s p, back q + c p) is the flight of mode i. */
void ric_equation_turn(const ric_enclosure *e, slong i, const arb_t tau, arb_t c, arb_t s,
                       arb_t back);
/* The derivatives of F0(tau) w in a phase by w and tau, out [2n * 2n + 1], and the flown state
 * [2n]. */
void ric_equation_flight(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w,
                         const arb_t tau, arb_mat_t out, arb_ptr flown);
/* A flight: a state [2n] and a time, in a phase. */
typedef struct {
    const ric_enclosure *e;
    const ric_phase *phase;
    arb_srcptr w, tau;
} ric_equation_span;

/* The second derivatives of F0(tau) w in the direction along = (v, theta) [2n + 1] and one left
 * open, by (w, tau), out [2n * 2n + 1]; D: the first ones, of ric_equation_flight. */
void ric_equation_bend(const ric_equation_span *f, const arb_mat_t D, arb_srcptr along,
                       arb_mat_t out);
/* The n conditions of the mirror point that a chain begins with, or ends with, as rows on (q, p):
 * B [n * 2n]; `gap` is what the first one of an impact equals. */
void ric_equation_mirror(const ric_enclosure *e, const ric_chain *chain, bool last, arb_mat_t B,
                         arb_t gap);

#endif
