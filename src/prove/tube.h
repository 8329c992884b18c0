/* A piece of a branch as a theorem. Between two centres a and b of one class let p(s) = a + s (b -
 * a), and hold the orbit on the plane v.(u - p(s)) = 0 across it, v = b - a. If the contraction of
 * contraction.h takes the box of radii r around every p(s) into itself, -RIC_TUBE_MORE <= s <= 1 +
 * RIC_TUBE_MORE, there is exactly one orbit in each, and they are one smooth arc, over folds, too:
 * only the direction of v may not turn away from it. Equations vanish at both ends of the line but
 * for `residual`, so on it they are at most |D^2 F (b - a)^2| / 8 (the error of interpolation). */
#ifndef RIC_PROVE_TUBE_H
#define RIC_PROVE_TUBE_H

#include "contraction.h"
#include "equations.h"
#include "skew.h"

#define RIC_TUBE_MORE 0x1p-12

/* An orbit: within `exists` of a centre; borrowed. */
typedef struct {
    const ric_chain *c;
    arb_srcptr exists;
} ric_tube_end;

typedef struct {
    const ric_chain *from, *to; /* centres, borrowed */
    arb_srcptr exists[2];
    ric_chain hull;       /* u: balls that hold every orbit of the arc */
    ric_contraction k;    /* of the equations in the basis: its radii are those of x */
    ric_skew basis;       /* u = p(s) + T x */
    mag_ptr spread;       /* [n] |T| radii: how far u goes */
    arb_ptr chord, row;   /* [n] b - a; the same times a power of two */
    arb_ptr ends;         /* [2 * n] the equations at both centres */
    arb_ptr sag;          /* [n] w: orbits lie near p(s) + s (1 - s) w, */
    mag_ptr rest;         /* [n] and within that of it */
    arb_ptr middle, half; /* [m * size + 1] of the arc, with its distance from the line; and of the
                             line (ric_family) */
    arb_t length;         /* row . chord */
} ric_tube;

bool ric_tube_create(ric_tube *t, ric_tube_end from, ric_tube_end to, const ric_enclosure *e);
void ric_tube_free(ric_tube *t);
/* Whether the orbits at both ends are of the arc. */
bool ric_tube_holds(const ric_tube *t);

/* Balls that hold the orbits of a part of the arc, out [m * size + 1]; of a tube that was created.
 */
void ric_tube_part(const ric_tube *t, double from, double to, arb_ptr out);
/* The same as lines: orbits lie within the balls of `middle` + s `half`, -1 <= s <= 1. */
void ric_tube_line(const ric_tube *t, double from, double to, arb_ptr middle, arb_ptr half);
/* How much too long the line is, or how little, for a proof that takes all bounds number by number:
 * the root of |C D^2 F (b - a)| / 2, about. A guess; of a tube that was created. */
double ric_tube_strain(const ric_tube *t, const ric_enclosure *e);
/* The derivative of the arc by s, out [m * size + 1]; of a tube that was created. */
void ric_tube_slope(const ric_tube *t, const ric_enclosure *e, arb_ptr out);

#endif
