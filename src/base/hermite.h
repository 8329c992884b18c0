/* What is certain about a function between two samples of it (docs/theory.md section 6). */
#ifndef RIC_BASE_HERMITE_H
#define RIC_BASE_HERMITE_H

#include <math.h>

/* A function g with its first two derivatives at one time. */
typedef struct {
    double t, g[3];
} ric_sample;

/* BELOW: g <= level throughout; FLAT: it is a straight line to rounding. */
typedef enum {
    RIC_SHAPE_BELOW,
    RIC_SHAPE_RISING,
    RIC_SHAPE_FALLING,
    RIC_SHAPE_CONVEX,
    RIC_SHAPE_CONCAVE,
    RIC_SHAPE_FLAT,
    RIC_SHAPE_UNKNOWN
} ric_shape;

/* Of g on [a, b], whose fourth derivative is at most D4 and whose values are known to `band`: the
 * cubic through values and slopes at the ends is off by D4 h^4 / 384, its slope by D4 h^3 sqrt(3) /
 * 216, its second derivative by D4 h^2 / 12 (Birkhoff and Priver, J. Math. Phys. 46 (1967) 440),
 * and Bernstein coefficients bound the cubic. Inline: the innermost loop of replays and sections.
 */
static inline ric_shape ric_hermite_shape(double D4, double band, const ric_sample *a,
                                          const ric_sample *b, double level)
{
    double h = b->t - a->t, e0 = D4 * h * h * h * h / 384,
           e1 = D4 * h * h * h * (0.5773502691896258 / 72), e2 = D4 * h * h / 12;
    double left = a->g[0] + h * a->g[1] / 3, right = b->g[0] - h * b->g[1] / 3;
    if (fmax(fmax(a->g[0], b->g[0]), fmax(left, right)) + e0 <= level) return RIC_SHAPE_BELOW;
    double middle = 3 * (right - left) / h, noise = band / (8 * h);
    if (fmin(fmin(a->g[1], b->g[1]), middle - noise) - e1 > 0) return RIC_SHAPE_RISING;
    if (fmax(fmax(a->g[1], b->g[1]), middle + noise) + e1 < 0) return RIC_SHAPE_FALLING;
    double first = 2 * (middle - a->g[1]) / h, last = 2 * (b->g[1] - middle) / h,
           noise2 = 2 * noise / h;
    if (fmin(first, last) - noise2 - e2 > 0) return RIC_SHAPE_CONVEX;
    if (fmax(first, last) + noise2 + e2 < 0) return RIC_SHAPE_CONCAVE;
    double bend = h * h * fmax(fabs(first), fabs(last)) / 8;
    return e0 + bend <= band / 2 ? RIC_SHAPE_FLAT : RIC_SHAPE_UNKNOWN;
}

/* g at time t, of whatever `of` is. */
typedef ric_sample ric_hermite_look(const void *of, double t);
/* Zero of g (order 0) or g' (order 1) between lo and hi, where it changes sign: Newton's method
 * kept inside a shrinking bracket. */
ric_sample ric_hermite_zero(ric_hermite_look *look, const void *of, int order, ric_sample lo,
                            ric_sample hi);

#endif
