/* A gap on parts of a flight of all orbits of a tube, in doubles: their balls are wider than what
 * these round, and there are many parts. With h = d - side c.q the modes q_i of the flight turn by
 * themselves, |q_i| <= A_i, |q_i''| <= omega_i^2 A_i. So on a part of length 2 r a mode is off its
 * values in the middle by what Taylor's formula says, or by A_i and what it is there, the smaller
 * one: fast modes of small size do not make parts short. */
#ifndef RIC_PROVE_GLIDE_H
#define RIC_PROVE_GLIDE_H

#include "enclosure.h"
#include "ball.h"

enum { RIC_GLIDE_READINGS = 64 }; /* times of a flight that are kept: faces ask for the same ones */

typedef struct {
    const ric_enclosure *e; /* of the phase */
    int n;                  /* its modes */
    ric_ball *line;         /* [2 * 2n] the beginning of the flight: middle of the line, and half */
    ric_ball *c, *square;   /* [n] normal; omega^2 */
    double *omega, *size;   /* [n] bounds; of A_i, infinite where omega_i is 0 */
    double *swing;          /* [n] of |q_i''| */
    ric_ball d;
    int side;
    double slack; /* what flights leave open of h and its derivatives */
    arb_ptr time; /* [READINGS + 1] and what there is then, [2 * 3n] each: q, p, L q */
    ric_ball *at;
    int count;
} ric_glide;

/* On a part of a flight: h is at least `least`, and h' and h'' are in balls. */
typedef struct {
    double least;
    ric_ball rate, bend;
} ric_glide_part;

void ric_glide_create(ric_glide *g, int n);
void ric_glide_free(ric_glide *g);
/* A flight in the modes of e, from states `middle` - `half` .. `middle` + `half`, all in `hull`
 * [2n]. */
void ric_glide_board(ric_glide *g, const ric_enclosure *e, arb_srcptr hull, arb_srcptr middle,
                     arb_srcptr half);
/* A face: its normal in these modes, and d. */
void ric_glide_place(ric_glide *g, arb_srcptr c, int side, const arb_t d, const arb_t slack);
ric_glide_part ric_glide_look(ric_glide *g, const arb_t mid, const arb_t r);

#endif
