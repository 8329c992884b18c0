#include "base/room.h"
#include "power_flow.h"

/* As in power_flow.c, for twice the digits. */
enum { ORDER = 40 };
#define EPSILON RIC_TWICE_EPSILON
typedef ric_twice real;
#define ADD ric_twice_add
#define SUB(x, y) ric_twice_add(x, ric_twice_negative(y))
#define MUL ric_twice_multiply
#define NEG ric_twice_negative
#define SCALE ric_twice_scale
#define OVER ric_twice_over
#define FROM ric_twice_from
#define NEAR(x) ((x).hi)
#define LESS(x, y) ((x).hi < (y).hi || ((x).hi == (y).hi && (x).lo < (y).lo))
/* Two of them, with the operations of twice.h in lanes. */
typedef struct {
    ric_lane hi, lo;
} pair;
#define AFTER(x) PAIR(FROM(0), x)
#define ACROSS(x, y) ((pair){{(x).hi[1], (y).hi[0]}, {(x).lo[1], (y).lo[0]}})
#define FIRST(x) ((ric_twice){(x).hi[0], (x).lo[0]})
#define LAST(x) ((ric_twice){(x).hi[1], (x).lo[1]})
static inline pair PAIR(ric_twice x, ric_twice y)
{
    return (pair){{x.hi, y.hi}, {x.lo, y.lo}};
}
static inline pair BOTH(ric_twice x)
{
    return PAIR(x, x);
}
static inline pair LOAD(const ric_twice *x)
{
    return PAIR(x[0], x[1]);
}
static inline pair ordered(ric_lane a, ric_lane b)
{
    const ric_lane s = a + b;
    return (pair){s, b - (s - a)};
}
static inline pair sum(ric_lane a, ric_lane b)
{
    const ric_lane s = a + b, c = s - a;
    return (pair){s, (a - (s - c)) + (b - c)};
}
static inline pair PLUS(pair a, pair b)
{
    pair s = sum(a.hi, b.hi);
    const pair t = sum(a.lo, b.lo);
    s = ordered(s.hi, s.lo + t.hi);
    return ordered(s.hi, s.lo + t.lo);
}
static inline pair TIMES(pair a, pair b)
{
    const double split = 0x1p27 + 1;
    const ric_lane p = a.hi * b.hi, x = split * a.hi, y = split * b.hi;
    const ric_lane a1 = x - (x - a.hi), a2 = a.hi - a1, b1 = y - (y - b.hi), b2 = b.hi - b1;
    const ric_lane low = ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2;
    return ordered(p, low + (a.hi * b.lo + a.lo * b.hi));
}
static inline void STORE(ric_twice *x, pair y)
{
    x[0] = FIRST(y);
    x[1] = LAST(y);
}
#include "taylor.h"

size_t ric_power_flow_twice_work(const ric_model *m, int columns)
{
    return series_work(m, columns + columns % 2);
}

bool ric_power_flow_twice(const ric_model *m, ric_twice tau, ric_twice *w, int columns,
                          ric_twice *X, ric_twice *work)
{
    int rows = 2 * m->n, even = columns + columns % 2;
    recipe how[m->n_contact];
    ric_twice wide[rows * even + 1];
    plan(m, how);
    if (columns == even)
        return fly_series(m, m->n, m->n_contact, how, columns, tau, w, X, NULL, work);
    /* beside the last column one of zeros */
    for (int i = 0; i < rows; i++) {
        memcpy(wide + i * even, X + i * columns, (size_t)columns * sizeof *X);
        wide[i * even + columns] = FROM(0);
    }
    bool flown = fly_series(m, m->n, m->n_contact, how, even, tau, w, wide, NULL, work);
    for (int i = 0; i < rows; i++)
        memcpy(X + i * columns, wide + i * even, (size_t)columns * sizeof *X);
    return flown;
}
