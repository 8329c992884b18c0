/* Sine and cosine, in lanes of two arguments and one by one, by sums and products alone: the same
 * bits for an argument wherever it stands, in either lane and on every processor, where the C
 * library chooses its way by what the processor can do (docs/decisions/0010-sines.md).
 *
 * x = k pi/2 + r + low with |r| <= pi/4: k is the nearest integer to 2 x / pi, and pi/2 is taken
 * from x in two parts, the first of 33 bits, so that k times it is exact for |k| < 2^20 and x - k
 * P1 too; what is lost of the second is below 2^-66 (Cody and Waite). Then sin r and cos r by the
 * polynomials of least error, 2^-59 and 2^-64 of 1, and what `low` adds to first order. Together
 * off by less than 2^-53, the distance of doubles below 1; sin^2 + cos^2 by less than 2^-52. sin is
 * odd and cos even to the bit, and sin 0 = 0, cos 0 = 1.
 *
 * |x| above RIC_SINE_LIMIT, and what is no number, goes to the C library. */
#ifndef RIC_BASE_SINE_H
#define RIC_BASE_SINE_H

#include <math.h>
#include <stdint.h>

#include "lane.h"

#define RIC_SINE_LIMIT 0x1p20

/* What RIC_SINE_LIMIT leaves to the C library, of either lane. */
void ric_sine_beyond(ric_lane x, ric_lane *sine, ric_lane *cosine);

static inline __attribute__((always_inline)) void ric_sine_lanes(ric_lane x, ric_lane *sine,
                                                                 ric_lane *cosine)
{
    typedef int64_t bits __attribute__((vector_size(16)));
    const double whole = 0x1.8p52; /* whose last digit is 1 */
    const ric_lane sum = x * 0x1.45f306dc9c883p-1 + whole, k = sum - whole;
    const ric_lane a = x - k * 0x1.921fb544p+0, b = k * 0x1.0b4611a626331p-34;
    const ric_lane r = a - b, low = (a - r) - b, z = r * r, zz = z * z, half = 0.5 * z;
    const ric_lane in_s = (0x1.111111110ea87p-7 +
                           z * (-0x1.a01a019aa371ap-13 + z * 0x1.71de346757037p-19)) +
                          z * zz * (-0x1.ae5da9ea4faa5p-26 + z * 0x1.5d61cff1e52dbp-33);
    const ric_lane in_c = (0x1.555555555554cp-5 +
                           z * (-0x1.6c16c16c1521dp-10 + z * 0x1.a01a019cbf0d5p-16)) +
                          z * zz *
                              (-0x1.27e4f81265524p-22 +
                               z * (0x1.1ee9f110b2c8fp-29 + z * -0x1.8fb10a3273f0dp-37));
    const ric_lane near = 1 - half, cube = z * r;
    const ric_lane s = r - ((z * (0.5 * low - cube * in_s) - low) - cube * -0x1.555555555553dp-3);
    const ric_lane c = near + (((1 - near) - half) + (zz * in_c - r * low));
    bits turns, s_bits, c_bits;
    memcpy(&turns, &sum, sizeof turns);
    memcpy(&s_bits, &s, sizeof s);
    memcpy(&c_bits, &c, sizeof c);
    const bits odd = -(turns & 1), other = (s_bits ^ c_bits) & odd;
    s_bits = s_bits ^ other ^ ((turns & 2) << 62);
    c_bits = c_bits ^ other ^ (((turns + 1) & 2) << 62);
    memcpy(sine, &s_bits, sizeof s);
    memcpy(cosine, &c_bits, sizeof c);
    if (!(fabs(x[0]) <= RIC_SINE_LIMIT) || !(fabs(x[1]) <= RIC_SINE_LIMIT))
        ric_sine_beyond(x, sine, cosine);
}

static inline void ric_sine_cosine(double x, double *sine, double *cosine)
{
    ric_lane s, c;
    ric_sine_lanes((ric_lane){x, x}, &s, &c);
    *sine = s[0];
    *cosine = c[0];
}

/* In extended precision, where that has 64 bits: off by less than 2^-64 up to RIC_SINE_LIMIT, in a
 * fifth of the time of the C library, which makes them elsewhere. */
void ric_sine_cosine_fine(long double x, long double *sine, long double *cosine);

#endif
