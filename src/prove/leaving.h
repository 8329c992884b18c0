/* Where a curve meets another one of a smaller class: a mirror is broken, or a period is
 * multiplied. Let G(v) = 0 be the curve of the smaller class, F(u) = 0 that of the larger one, and
 * u = T v the same orbit written as one of the larger class: T is linear, as all states and times
 * of the one are images, or sums, of those of the other. The larger class has F(T v) = 0 all along
 * the first curve, so that F alone is singular where the two meet. With u = T v + e a
 *   G(v) = 0,  (F(T v + e a) - F(T v)) / e = 0,  l.a = 1,  k.a = 0
 * is regular there, at e = 0, where the second says F' a = 0: a is a motion beside the orbit that
 * the smaller class lacks, l and k fix its size and which v it is seen from. If a box around that
 * is taken into itself for all |e| <= size there is one zero for each e, and the u are one arc that
 * passes the other curve at e = 0. Where it only leaves from there both halves of it are images of
 * one another. Crandall and Rabinowitz, J. Funct. Anal. 8 (1971) 321-340. */
#ifndef RIC_PROVE_LEAVING_H
#define RIC_PROVE_LEAVING_H

#include "augmented.h"

typedef struct {
    slong count;
    arb_ptr
        end[2]; /* [count] balls: the orbits at e = -size and at e = size, in the larger class */
    double approach; /* no impact of the arc is slower, scaled, per 2^-time s */
} ric_leaving;

/* From a junction that was proved; `like`: near its orbit, of the class that the arc has. To be
 * freed in any case. */
bool ric_leaving_prove(ric_leaving *v, const ric_augmented *junction, const ric_chain *like);
void ric_leaving_free(ric_leaving *v);

#endif
