/* A zero of a continuous function where it changes its sign: the one root finder of the house. The
 * caller keeps the function, which may carry states along, be dear, or refuse; the finder only says
 * where it wants to know it. */
#ifndef RIC_BASE_ROOT_H
#define RIC_BASE_ROOT_H

#include <stdbool.h>

/* Of values alone (R. P. Brent, Algorithms for Minimization without Derivatives, 1973, chapter 4):
 * inverse quadratic interpolation that never takes more than a few times the steps of a bisection.
 *
 *     ric_root r = ric_root_between(a, fa, b, fb, tolerance);
 *     while (ric_root_next(&r)) r.f = function(r.x);
 *
 * r.x is then the better end of a bracket no longer than two tolerances, and r.f its value, which
 * may not be the last one that was asked for. A function known to `noise` has come as far as it can
 * where it is no larger: 0 otherwise. */
typedef struct {
    double x, f;           /* where the function is wanted; there the caller leaves its value */
    double tolerance;      /* of x, absolute */
    double noise;          /* of f */
    double past, f_past;   /* the estimate before */
    double other, f_other; /* the zero lies between x and this */
    double step, before;   /* the last two steps */
    int passes;
    bool quotient; /* interpolate by a quotient of straight lines instead of an inverse parabola:
                      set after the start */
} ric_root;

/* fa and fb have different signs. */
ric_root ric_root_between(double a, double fa, double b, double fb, double tolerance);
bool ric_root_next(ric_root *root);

/* Of a function with its derivative: Newton's method, kept inside a bracket that shrinks, with a
 * bisection wherever a step is not half of the one before.
 *
 *     ric_root_slope r = ric_root_slope_between(a, b, f(b) > 0, first);
 *     do f = function(r.x, &slope); while (ric_root_slope_next(&r, f, slope));
 *
 * r.x is then the zero; where the last step was too short to matter the function has not been asked
 * for there. */
typedef struct {
    double low, high, whole; /* the zero lies between them; their distance at first */
    double x, step;          /* where the function is wanted; length of the last step */
    double least,
        part; /* a step of no more than `least`, or this part of x, is the last one: 0 unless set */
    int passes;
    bool rises;  /* the function is above 0 at the high end */
    bool halved; /* the last step went to the middle of the bracket */
} ric_root_slope;

ric_root_slope ric_root_slope_between(double low, double high, bool rises, double first);
bool ric_root_slope_next(ric_root_slope *root, double f, double slope);
/* The same by parabolas, with the second derivative `bend` (Cauchy's method): each step cubes the
 * error, and a zero beside an extremum is met as fast as any other. */
bool ric_root_slope_bent(ric_root_slope *root, double f, double slope, double bend);

#endif
