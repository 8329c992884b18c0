/* Numbers that agree to a tolerance in double. cmocka's assert_float_equal compares in single
 * precision, to which everything agrees that is right to seven digits; the test `rooms` lets nobody
 * use it. */
#ifndef RIC_TESTS_CLOSE_H
#define RIC_TESTS_CLOSE_H

#include <math.h>
#include <stdbool.h>

/* |found - wanted| <= tolerance; a NaN is near nothing. */
#define assert_close(found, wanted, tolerance)                                                     \
    assert_close_at(found, wanted, tolerance, __FILE__, __LINE__)

/* The same, relative to what is expected. */
#define assert_relative(found, wanted, tolerance)                                                  \
    assert_relative_at(found, wanted, tolerance, __FILE__, __LINE__)

static inline void assert_close_at(double found, double wanted, double tolerance, const char *file,
                                   int line)
{
    if (fabs(found - wanted) <= tolerance) return;
    print_error("%.17g, expected %.17g to %.3g: off by %.3g\n", found, wanted, tolerance,
                fabs(found - wanted));
    _fail(file, line);
}

static inline void assert_relative_at(double found, double wanted, double tolerance,
                                      const char *file, int line)
{
    assert_close_at(found, wanted, tolerance * fabs(wanted), file, line);
}

/* Whether it would hold. */
static inline bool agrees(double found, double wanted, double tolerance)
{
    return fabs(found - wanted) <= tolerance * fabs(wanted);
}

#endif
