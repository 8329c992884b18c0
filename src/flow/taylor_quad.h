/* taylor.h in quadruple precision. */
/* 113 bits: of the compiler on x86, long double elsewhere. */
#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 real;
#else
typedef long double real;
#endif
typedef real lane;
enum { ORDER = 44, PAD = 4, LANES = 1 }; /* as in power_flow.c */
#define EPSILON 1e-33
#define ABS(x) ((x) < 0 ? -(x) : (x))
static inline real sum_of(lane x)
{
    return x;
}
#include "taylor.h"
