/* Numbers along a line, in doubles: x(s) = m + g s within r, for all -1 <= s <= 1. What changes
 * along an arc goes with g, and cancels there as it does in the arc; r has what is bent, and every
 * rounding, as the radius of a ball has it (ball.h). s^2 is 1/2 within 1/2, so that of a product of
 * two slopes half goes to the middle. A line that is not a number compares false with everything.
 */
#ifndef RIC_PROVE_LINE_H
#define RIC_PROVE_LINE_H

#include "ball.h"

typedef struct {
    double m, g, r;
} ric_line;

static inline ric_line ric_line_exact(double x)
{
    return (ric_line){x, 0, 0};
}
static inline ric_line ric_line_ball(ric_ball x)
{
    return (ric_line){x.m, 0, x.r};
}
static inline ric_line ric_line_of(const arb_t x)
{
    return ric_line_ball(ric_ball_of(x));
}
/* The ball of all of it. */
static inline ric_ball ric_line_whole(ric_line a)
{
    return (ric_ball){a.m, ric_up(fabs(a.g) + a.r)};
}
/* At least |m + g s|. */
static inline double ric_line_size(ric_line a)
{
    return fabs(a.m) + fabs(a.g);
}
static inline ric_line ric_line_add(ric_line a, ric_line b)
{
    const double m = a.m + b.m, g = a.g + b.g;
    return (ric_line){m, g, ric_up(a.r + b.r + (fabs(m) + fabs(g)) * RIC_BALL_UNIT)};
}
static inline ric_line ric_line_sub(ric_line a, ric_line b)
{
    return ric_line_add(a, (ric_line){-b.m, -b.g, b.r});
}
/* Seven numbers are rounded for m and g, each of them at most the product of the sizes, and their
 * sum at most four times that. */
static inline ric_line ric_line_mul(ric_line a, ric_line b)
{
    const double half = a.g * b.g / 2, A = ric_line_size(a), B = ric_line_size(b);
    return (ric_line){a.m * b.m + half, a.m * b.g + a.g * b.m,
                      ric_up(A * (b.r + 4 * RIC_BALL_UNIT * B) + a.r * (B + b.r) + fabs(half))};
}
/* 1 / x = 1/m - (x - m)/m^2 + (x - m)^2 / (m^2 x), of which the last part has the sign of m and is
 * at most w^2 / (m^2 (|m| - w)), w = |g| + r. */
static inline ric_line ric_line_inverse(ric_line a)
{
    const double w = ric_up(fabs(a.g) + a.r), least = ric_down(fabs(a.m) - w);
    if (!(least > 0)) return (ric_line){NAN, NAN, NAN};
    const double y = 1 / a.m, g = -a.g * y * y, half = ric_up(y * y * w * w / least) / 2;
    const double rounded = 8 * RIC_BALL_UNIT * (fabs(y) + fabs(g) + half);
    return (ric_line){y + copysign(half, a.m), g, ric_up(ric_up(a.r * y * y) + half + rounded)};
}

#endif
