/* The structure in balls: what the decimals of its matrices, normals and clearances say, nothing
 * rounded.
 *
 * Units: lengths in d of the first contact, times in 2^-time s, masses such that |c| of the first
 * contact is near 1; both factors are powers of two, so that nothing is rounded. A basis X of the
 * modes that are moved, exactly orthonormal in M, makes of the structure q'' = -(L + R) q with a
 * diagonal L >= 0 whose entries are exact and |R| <= rho, far below what is computed with. No
 * eigenvalue needs to be simple, or away from zero, for that: where frequencies are equal any basis
 * does, and what a frequency that is not quite zero does is in R. An impact is p <- p - 2
 * (c.p)/(c.c) c without an error.
 *
 * Flights F(t) of L + R differ from those of L, in the spectral norm, by at most `slack` (Duhamel's
 * formula; see ric_enclosure_slack), so do their derivatives. */
#ifndef RIC_PROVE_ENCLOSURE_H
#define RIC_PROVE_ENCLOSURE_H

#include "arb_numbers.h"
#include "model/room.h"

typedef struct {
    int contact, side, mirror;
    arb_t gap;    /* side d_f / d_0 */
    bool closes;  /* there is a spring behind it */
    arb_t spring; /* its stiffness, 0 of a stop */
} ric_wall;

typedef struct {
    slong prec; /* bits of what is computed with it */
    const ric_model *model;
    int n, n_dof, n_contact, n_face;
    int time, mass;                /* exponents of the scale */
    arb_mat_t X;                   /* [n_dof * n] */
    arb_mat_t back;                /* [n * n_dof] X' M: q = back x */
    arb_mat_t C;                   /* [n_contact * n] rows c */
    arb_ptr cc;                    /* [n_contact] c . c */
    arb_mat_t turn;                /* [n_contact * n] 2 c / (c . c) */
    arb_ptr omega;                 /* [n] 0 for a zero mode */
    arb_ptr square;                /* [n] L, exact; omega^2 is what it encloses */
    arb_t rho, top;                /* |R|; 1 + largest L */
    arb_t spread;                  /* |X|, in the Frobenius norm */
    ric_wall *wall;                /* [n_face] */
    struct ric_phase_list *phases; /* of closed springs, made when they are asked for (phase.h) */
    struct ric_twin_list *twins;   /* permutations of the structure, too (twins.h) */
    char why[160];                 /* why there is none */
} ric_enclosure;

/* false, with the reason in `why`, where the structure cannot be enclosed. To be released in any
 * case. */
bool ric_enclosure_create(ric_enclosure *e, const ric_model *model, slong prec);
/* The same with all modes of the structure, those that no contact sees, too. */
bool ric_enclosure_create_whole(ric_enclosure *e, const ric_model *model, slong prec);
void ric_enclosure_free(ric_enclosure *e);

/* The same structure, borrowed, for what is computed with few bits: balls that are wide anyway. */
ric_enclosure ric_enclosure_coarse(const ric_enclosure *e);

/* An upper bound, for 0 <= t, of |F(t) - F0(t)|, |F'(t) - F0'(t)| and |F''(t) - F0''(t)|; not
 * finite where there is none. */
void ric_enclosure_slack(const ric_enclosure *e, const arb_t t, arb_t out);

/* How many frequencies the structure has, each counted once: exactly; 0 where it has more than 40
 * modes. */
int ric_enclosure_frequencies(const ric_model *model);
/* Where the structure may rest with these springs closed, out [n], also where it is free to move
 * then: found in rational numbers. False where there is no such place, or more than 40 degrees of
 * freedom. */
bool ric_enclosure_rest(const ric_enclosure *e, uint64_t closed, arb_ptr out);
/* Whether the normals of two contacts are exactly orthogonal in the metric of M^-1. */
bool ric_enclosure_orthogonal(const ric_model *model, int a, int b);
/* The exponent of the scale of times: 2^time is near the frequency that the model is scaled by. */
int ric_enclosure_time(const ric_model *model);
/* A decimal as it is printed with the fewest digits that give the number back. */
void ric_enclosure_decimal(double x, char out[40]);

static inline arb_ptr ric_enclosure_c(const ric_enclosure *e, int contact)
{
    return arb_mat_entry(e->C, contact, 0);
}

#endif
