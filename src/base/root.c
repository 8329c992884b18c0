#include "root.h"

#include <math.h>

/* A jump takes 55 to the last digit, a zero of order three 60 to ten digits: what is left is
 * rounding. */
enum { PASSES_MOST = 60 };
/* Of the first bracket: steps below it need not shrink, as what moves them is rounding. */
#define SHORT 1e-8

ric_root ric_root_between(double a, double fa, double b, double fb, double tolerance)
{
    return (ric_root){.x = b,
                      .f = fb,
                      .tolerance = tolerance,
                      .past = a,
                      .f_past = fa,
                      .other = a,
                      .f_other = fa,
                      .step = b - a,
                      .before = b - a};
}

/* Keeps the zero between x and `other`, x the better of the two. */
static void keep_bracket(ric_root *r)
{
    if (r->f * r->f_other > 0) {
        r->other = r->past;
        r->f_other = r->f_past;
        r->step = r->before = r->x - r->past;
    }
    if (fabs(r->f_other) < fabs(r->f)) {
        r->past = r->x;
        r->x = r->other;
        r->other = r->past;
        r->f_past = r->f;
        r->f = r->f_other;
        r->f_other = r->f_past;
    }
}

/* The step that interpolation asks for, p / q, of the secant or of an inverse parabola. */
static void interpolate(const ric_root *r, double half, double *p, double *q)
{
    double s = r->f / r->f_past;
    if (r->past == r->other) {
        *p = 2 * half * s;
        *q = 1 - s;
    } else if (r->quotient) { /* the cross-ratio of four values is that of their places */
        double t = (r->f / r->f_other) * ((r->f_past - r->f_other) / (r->f_past - r->f)) *
                   ((r->past - r->x) / (r->past - r->other));
        *p = 2 * half * t;
        *q = 1 - t;
    } else {
        double t = r->f_past / r->f_other, u = r->f / r->f_other;
        *p = s * (2 * half * t * (t - u) - (r->x - r->past) * (u - 1));
        *q = (t - 1) * (u - 1) * (s - 1);
    }
    if (*p > 0) *q = -*q;
    else *p = -*p;
}

bool ric_root_next(ric_root *r)
{
    double p, q;
    keep_bracket(r);
    double half = (r->other - r->x) / 2, least = r->tolerance;
    if (fabs(half) <= least || fabs(r->f) <= r->noise || r->passes++ == PASSES_MOST) return false;
    if (fabs(r->before) < least || fabs(r->f_past) <= fabs(r->f)) r->step = r->before = half;
    else {
        interpolate(r, half, &p, &q);
        if (2 * p < fmin(3 * half * q - fabs(least * q), fabs(r->before * q))) {
            r->before = r->step;
            r->step = p / q;
        } else r->step = r->before = half;
    }
    r->past = r->x;
    r->f_past = r->f;
    r->x += fabs(r->step) > least ? r->step : copysign(least, half);
    return true;
}

ric_root_slope ric_root_slope_between(double low, double high, bool rises, double first)
{
    double whole = high - low;
    return (ric_root_slope){.low = low,
                            .high = high,
                            .whole = whole,
                            .x = first,
                            .step = whole,
                            .rises = rises};
}

/* To x - move, or to the middle of the bracket where that leaves it or does not shrink. A step that
 * is lost in the last digit of x, which has just become an end of the bracket, is the last one. */
static bool go(ric_root_slope *r, double f, double move)
{
    if ((f > 0) == r->rises) r->high = r->x;
    else r->low = r->x;
    double next = r->x - move;
    if (next == r->x) return false;
    bool shrinks = fabs(move) <= r->step / 2 || r->step < SHORT * r->whole;
    r->halved = !(next > r->low && next < r->high) || !shrinks;
    if (r->halved) next = (r->low + r->high) / 2;
    r->step = fabs(next - r->x);
    r->x = next;
    return r->step > fmax(r->least, r->part * fabs(next));
}

bool ric_root_slope_next(ric_root_slope *r, double f, double slope)
{
    return f != 0 && r->passes++ < PASSES_MOST && go(r, f, f / slope);
}

/* The zero of the parabola that is the nearer one; of the tangent where the parabola has none. */
bool ric_root_slope_bent(ric_root_slope *r, double f, double slope, double bend)
{
    if (f == 0 || r->passes++ >= PASSES_MOST) return false;
    double under = slope * slope - 2 * f * bend;
    return go(r, f, under > 0 ? 2 * f / (slope + copysign(sqrt(under), slope)) : f / slope);
}
