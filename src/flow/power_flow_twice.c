#include "base/room.h"
#include "power_flow.h"

/* As in power_flow.c, for twice the digits. */
enum { ORDER = 40, PAD = 4, LANES = 1 };
#define EPSILON RIC_TWICE_EPSILON
typedef ric_twice real, lane;
#define ADD ric_twice_add
#define SUB(x, y) ric_twice_add(x, ric_twice_negative(y))
#define MUL ric_twice_multiply
#define NEG ric_twice_negative
#define SCALE ric_twice_scale
#define OVER ric_twice_over
#define FROM ric_twice_from
#define NEAR(x) ((x).hi)
#define LESS(x, y) ((x).hi < (y).hi || ((x).hi == (y).hi && (x).lo < (y).lo))
static inline ric_twice sum_of(lane x)
{
    return x;
}
#include "taylor.h"

size_t ric_power_flow_twice_work(const ric_model *m, int columns)
{
    return series_work(m, columns);
}

bool ric_power_flow_twice(const ric_model *m, ric_twice tau, ric_twice *w, int columns,
                          ric_twice *X, ric_twice *work)
{
    return fly_series(m, m->n, m->n_contact, columns, tau, w, X, NULL, work);
}
