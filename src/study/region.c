#include "region.h"

#include <limits.h>
#include <math.h>

static bool within(const double window[2], double value)
{
    return value >= window[0] && value <= window[1];
}

static bool holds(const ric_region *r, double energy, double frequency, int multiple)
{
    return within(r->energy, energy) &&
           (within(r->frequency, frequency) || within(r->frequency, frequency / multiple));
}

/* Depth 0 is without limit. */
static int limit_of(int depth)
{
    return depth == 0 ? INT_MAX : depth;
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

static ric_budgets of_study(const ric_explore_options *o)
{
    return (
        ric_budgets){.depth = limit_of(o->depth), .impacts = o->impacts, .multiply = o->multiply};
}

static void raise(ric_budgets *b, const ric_region *r)
{
    b->depth = larger(b->depth, limit_of(r->depth));
    b->impacts = larger(b->impacts, r->impacts);
    b->multiply = larger(b->multiply, r->multiply);
    b->inside = b->raised = true;
}

ric_budgets ric_region_budgets(const ric_explore_options *o, double energy, double frequency,
                               int multiple)
{
    ric_budgets budgets = of_study(o);
    /* without regions branches end at the windows, and only the originals of duplicates lie beyond;
     * families that reach into a window begin below its lower end */
    budgets.inside = o->n_region == 0 ||
                     (energy <= o->energy[1] && (within(o->frequency, frequency) ||
                                                 within(o->frequency, frequency / multiple)));
    for (int i = 0; i < o->n_region; i++)
        if (holds(&o->region[i], energy, frequency, multiple)) raise(&budgets, &o->region[i]);
    return budgets;
}

ric_budgets ric_region_largest(const ric_explore_options *o)
{
    ric_budgets budgets = of_study(o);
    for (int i = 0; i < o->n_region; i++) raise(&budgets, &o->region[i]);
    return budgets;
}

static void extend(double window[2], const double by[2])
{
    window[0] = fmin(window[0], by[0]);
    window[1] = fmax(window[1], by[1]);
}

void ric_region_window(const ric_explore_options *o, double energy[2], double frequency[2])
{
    for (int i = 0; i < 2; i++) {
        energy[i] = o->energy[i];
        frequency[i] = o->frequency[i];
    }
    for (int i = 0; i < o->n_region; i++) {
        extend(energy, o->region[i].energy);
        extend(frequency, o->region[i].frequency);
    }
}

/* Whether the curve from a to b may come into a window: it bends by less than it is long. */
static bool near(const double window[2], double a, double b, int multiple)
{
    double low = fmin(a, b), high = fmax(a, b), room = high - low;
    return (high + room) / multiple >= window[0] && (low - room) / multiple <= window[1];
}

static bool comes_near(const ric_region *r, const ric_point *a, const ric_point *b)
{
    if (!near(r->energy, a->energy, b->energy, 1)) return false;
    for (int q = 1; q <= r->multiply; q++)
        if (near(r->frequency, a->frequency, b->frequency, q)) return true;
    return false;
}

bool ric_region_multiplies(const ric_explore_options *o, int n_point, size_t stride,
                           const double *points)
{
    for (int i = 0; i < o->n_region; i++) {
        if (o->region[i].multiply <= o->multiply) continue;
        for (int k = 0; k + 1 < n_point; k++) {
            const ric_point *a = (const ric_point *)(points + (size_t)k * stride);
            const ric_point *b = (const ric_point *)(points + (size_t)(k + 1) * stride);
            if (comes_near(&o->region[i], a, b)) return true;
        }
    }
    return false;
}

bool ric_region_covers(const ric_region *outer, const ric_region *inner)
{
    return outer->energy[0] <= inner->energy[0] && outer->energy[1] >= inner->energy[1] &&
           outer->frequency[0] <= inner->frequency[0] &&
           outer->frequency[1] >= inner->frequency[1] &&
           limit_of(outer->depth) >= limit_of(inner->depth) && outer->impacts >= inner->impacts &&
           outer->multiply >= inner->multiply;
}
