/* Numbers of twice the digits of a double: the sum of two, of which the second is at most half a
 * unit of the last place of the first (Dekker, Numer. Math. 18 (1971) 224-242). Sums and products
 * are off by a few units of 2^-105, relative; no number may be near the ends of the range of a
 * double. Ten times as fast as quadruple precision by the compiler's library, and the same bits on
 * every machine, as only sums and products of doubles are rounded. */
#ifndef RIC_BASE_TWICE_H
#define RIC_BASE_TWICE_H

typedef struct {
    double hi, lo;
} ric_twice;

#define RIC_TWICE_EPSILON 0x1p-103 /* of a sum or a product, relative to the larger operand */

/* hi + lo = a + b exactly, for |a| >= |b| or a = 0. */
static inline ric_twice ric_twice_ordered(double a, double b)
{
    const double s = a + b;
    return (ric_twice){s, b - (s - a)};
}
/* The same in any order (Knuth). */
static inline ric_twice ric_twice_sum(double a, double b)
{
    const double s = a + b, c = s - a;
    return (ric_twice){s, (a - (s - c)) + (b - c)};
}
/* hi + lo = a b exactly: halves of 26 bits (Veltkamp). */
static inline ric_twice ric_twice_product(double a, double b)
{
    const double split = 0x1p27 + 1, p = a * b, x = split * a, y = split * b;
    const double a1 = x - (x - a), a2 = a - a1, b1 = y - (y - b), b2 = b - b1;
    return (ric_twice){p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2};
}
static inline ric_twice ric_twice_add(ric_twice a, ric_twice b)
{
    ric_twice s = ric_twice_sum(a.hi, b.hi);
    const ric_twice t = ric_twice_sum(a.lo, b.lo);
    s = ric_twice_ordered(s.hi, s.lo + t.hi);
    return ric_twice_ordered(s.hi, s.lo + t.lo);
}
static inline ric_twice ric_twice_negative(ric_twice a)
{
    return (ric_twice){-a.hi, -a.lo};
}
static inline ric_twice ric_twice_multiply(ric_twice a, ric_twice b)
{
    const ric_twice p = ric_twice_product(a.hi, b.hi);
    return ric_twice_ordered(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
static inline ric_twice ric_twice_scale(double factor, ric_twice a)
{
    const ric_twice p = ric_twice_product(factor, a.hi);
    return ric_twice_ordered(p.hi, p.lo + factor * a.lo);
}
/* a / count for a double a and an integer. */
static inline ric_twice ric_twice_over(double a, int count)
{
    const double q = a / count;
    const ric_twice p = ric_twice_product(q, count);
    return ric_twice_ordered(q, ((a - p.hi) - p.lo) / count);
}
static inline ric_twice ric_twice_from(double a)
{
    return (ric_twice){a, 0};
}

/* Of a number in extended precision, which has no more digits than that. */
static inline ric_twice ric_twice_of(long double x)
{
    const double hi = (double)x;
    return (ric_twice){hi, (double)(x - hi)};
}

#endif
