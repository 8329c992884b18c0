#include "sine.h"

#include <float.h>

void ric_sine_beyond(ric_lane x, ric_lane *sine, ric_lane *cosine)
{
    for (int i = 0; i < 2; i++) {
        if (fabs(x[i]) <= RIC_SINE_LIMIT) continue;
        double s, c;
        sincos(x[i], &s, &c);
        (*sine)[i] = s;
        (*cosine)[i] = c;
    }
}

#if LDBL_MANT_DIG == 64

/* As ric_sine_lanes, with 44 and 64 bits of pi/2: what is lost of it is below 2^-88; the
 * polynomials are off by 2^-70 and 2^-75. The turns are counted in double: where extended precision
 * is emulated with fewer digits, as memory checkers do, sines have those then, and are none else.
 */
void ric_sine_cosine_fine(long double x, long double *sine, long double *cosine)
{
    if (!(fabsl(x) <= RIC_SINE_LIMIT)) {
        sincosl(x, sine, cosine);
        return;
    }
    const double whole = 0x1.8p52; /* whose last digit is 1 */
    const double k = ((double)x * 0x1.45f306dc9c883p-1 + whole) - whole;
    const long double a = x - k * 0x1.921fb54442cp+0L, b = k * 0x1.18469898cc51701cp-44L;
    const long double r = a - b, low = (a - r) - b, z = r * r, zz = z * z, half = z / 2;
    const long double in_s = (0x1.1111111111106dcep-7L + z * -0x1.a01a01a01817bdb6p-13L) +
                             zz * ((0x1.71de3a5295c9cccap-19L + z * -0x1.ae6451dfb736efb8p-26L) +
                                   zz * (0x1.61202a963094d676p-33L +
                                         z * -0x1.aa76ca6ec08f70acp-41L));
    const long double in_c = (0x1.5555555555555536p-5L + z * -0x1.6c16c16c16c0fde8p-10L) +
                             zz * ((0x1.a01a01a018dabfb8p-16L + z * -0x1.27e4fb75f949eea4p-22L) +
                                   zz * ((0x1.1eed8c9eecddef36p-29L +
                                          z * -0x1.939332d7168484fap-37L) +
                                         zz * 0x1.aac3379dfb0dac88p-45L));
    const long double near = 1 - half, cube = z * r;
    const long double s = r -
                          ((z * (low / 2 - cube * in_s) - low) - cube * -0x1.5555555555555506p-3L);
    const long double c = near + (((1 - near) - half) + (zz * in_c - r * low));
    const int turns = (int)k & 3;
    *sine = turns == 0 ? s : turns == 1 ? c : turns == 2 ? -s : -c;
    *cosine = turns == 0 ? c : turns == 1 ? -s : turns == 2 ? -c : s;
}

#else

void ric_sine_cosine_fine(long double x, long double *sine, long double *cosine)
{
    sincosl(x, sine, cosine);
}

#endif
