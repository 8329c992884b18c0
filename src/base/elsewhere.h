/* What the GNU library has and the C library of macOS has not, made of what both have. Meson
 * includes it before all else where that is so; a test compiles it where it is not
 * (tests/cli/cli_install.sh). */
#ifndef RIC_BASE_ELSEWHERE_H
#define RIC_BASE_ELSEWHERE_H

#include <math.h>

static inline void ric_elsewhere_sincos(double x, double *s, double *c)
{
    *s = sin(x);
    *c = cos(x);
}

static inline void ric_elsewhere_sincosl(long double x, long double *s, long double *c)
{
    *s = sinl(x);
    *c = cosl(x);
}

#define sincos ric_elsewhere_sincos
#define sincosl ric_elsewhere_sincosl

#endif
