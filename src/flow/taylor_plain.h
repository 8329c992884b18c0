/* What taylor.h does with numbers that C knows. */
#define ADD(x, y) ((x) + (y))
#define SUB(x, y) ((x) - (y))
#define MUL(x, y) ((x) * (y))
#define NEG(x) (-(x))
#define SCALE(factor, x) ((factor) * (x))
#define OVER(x, count) ((real)(x) / (count))
#define FROM(x) ((real)(x))
#define NEAR(x) ((double)(x))
#define LESS(x, y) ((x) < (y))

/* Pairs of numbers that have no lanes. */
#ifndef PAIR
typedef struct {
    real first, last;
} pair;
#define PAIR(x, y) ((pair){x, y})
#define AFTER(x) ((pair){0, x})
#define ACROSS(x, y) ((pair){(x).last, (y).first})
#define FIRST(x) ((x).first)
#define LAST(x) ((x).last)
static inline pair BOTH(real x)
{
    return (pair){x, x};
}
static inline pair PLUS(pair x, pair y)
{
    return (pair){x.first + y.first, x.last + y.last};
}
static inline pair TIMES(pair x, pair y)
{
    return (pair){x.first * y.first, x.last * y.last};
}
static inline pair LOAD(const real *x)
{
    return (pair){x[0], x[1]};
}
static inline void STORE(real *x, pair y)
{
    x[0] = y.first;
    x[1] = y.last;
}
#endif
