/* Orbits that close two contacts together are a curve of solutions of the branch's equations, too,
 * with a flight of no time in them, and the branch crosses it: at the crossing these equations are
 * singular, also with that flight as one equation more. Beside it they are not. The crossing is
 * read off orbits of the branch whose flight lasts +-h, +-2h, +-3h (less than no time: beyond the
 * end), which are known to rounding / h, solved in more digits than double has: by the polynomial
 * through these six, and the one through the inner four tells how good that is. */
#include "meeting.h"

#include <stdlib.h>
#include <string.h>

#include "canonical.h"
#include "criterion.h"
#include "branch/room.h"
#include "base/room.h"

enum { SIDES = 6, PASSES = 2 };
#define SINGULAR 1e-5 /* of the largest: a singular value that is zero where curves cross */
/* STAYS: of a curve's direction: change of a flight that has none. Beside a crossing, where a
 * corner is solved for in vain, 3e-6 was seen; those of two-walls have 2e-2 and more */
#define STAYS 1e-5

/* FARTHEST, NEAREST: h, scaled; by FINER from one to the next */
#define FARTHEST 0x1p-6
#define NEAREST 0x1p-20
#define FINER 0.25
#define WORSE 16 /* times the least error: a smaller h is worse from here on */

static const double places[SIDES] = {-3, -2, -1, 1, 2, 3};

/* The polynomial through `count` orbits v [count * size] in their unknown k, where that is 0: u. */
static void read_off(int count, int size, const double *v, int k, double *u)
{
    memset(u, 0, (size_t)size * sizeof *u);
    for (int i = 0; i < count; i++) {
        const double own = v[i * size + k];
        double share = 1;
        for (int j = 0; j < count; j++)
            if (j != i) share *= v[j * size + k] / (v[j * size + k] - own);
        for (int j = 0; j < size; j++) u[j] += share * v[i * size + j];
    }
    u[k] = 0;
}

/* Where to look for orbits whose flight k lasts h: at u + h t, t the direction of the kernel in
 * which that flight changes most. Beside u itself the equations are singular as at u. */
static void direction(ric_shooting *c, const double *u, int k, double *t)
{
    const int size = c->n_unknown;
    ric_singular q;
    memset(t, 0, (size_t)size * sizeof *t);
    if (size <= RIC_DENSE_MOST && !ric_singular_create(c, false, &q)) {
        const bool good = ric_singular_factor(&q, u);
        const int count = good ? size - ric_singular_rank(&q, SINGULAR) : 0;
        const double *kernel = count > 0 ? ric_singular_kernel(&q, count) : NULL;
        for (int i = 0; i < count; i++)
            for (int j = 0; j < size; j++) t[j] += kernel[i * size + k] * kernel[i * size + j];
        ric_singular_free(&q);
    }
    const double own = t[k];
    for (int j = 0; j < size; j++) t[j] = own > SINGULAR ? t[j] / own : 0;
    t[k] = 1;
}

bool ric_meeting_stays(const ric_model *m, const ric_periodic *cycle)
{
    ric_shooting *c = NULL;
    double *u = NULL;
    ric_singular q;
    bool stays = false;
    if (!ric_periodic_to_chain(m, cycle, &c, &u) && c->n_unknown <= RIC_DENSE_MOST &&
        !ric_singular_create(c, false, &q)) {
        const double *t = ric_singular_factor(&q, u) ? ric_singular_kernel(&q, 1) : NULL;
        const int shortest = ric_criterion_shortest(c, u);
        stays = t && shortest >= 0 && fabs(t[c->n_start + shortest]) < STAYS;
        ric_singular_free(&q);
    }
    ric_shooting_free(c);
    free(u);
    return stays;
}

/* The same of orbits whose flight k lasts about places[i] * h, looked for from `from` along `t`.
 * Returns how far the two polynomials are apart. */
static double cross(ric_shooting *c, const double *from, const double *t, int k, double h,
                    double *u)
{
    const int size = c->n_unknown;
    double along[size], v[SIDES * size], du[size], four[size], apart = 0;
    int iterations;
    memset(along, 0, sizeof along);
    along[k] = 1;
    for (int i = 0; i < SIDES; i++) {
        double *at = v + i * size;
        for (int j = 0; j < size; j++) at[j] = from[j] + (places[i] * h - from[k]) * t[j];
        at[k] = places[i] * h;
        if (!ric_continuation_correct(c, at, from, along, at[k] - from[k], du, &iterations))
            return HUGE_VAL;
        ric_floquet_fine_nearest(c, at); /* or it stays as it is */
    }
    read_off(SIDES, size, v, k, u);
    read_off(SIDES - 2, size, v + size, k, four);
    for (int j = 0; j < size; j++) apart = fmax(apart, fabs(u[j] - four[j]));
    return apart;
}

static bool solve(const void *of, ric_shooting *c, double *u, bool rounded)
{
    (void)of, (void)rounded;
    const int size = c->n_unknown;
    double from[size], v[size], t[size], least = HUGE_VAL;
    ric_shooting_evaluate(c, u);
    const int shortest = ric_criterion_shortest(c, u), k = c->n_start + shortest;
    if (shortest < 0) return false;
    memcpy(from, u, sizeof from);
    direction(c, from, k, t);
    for (double h = FARTHEST; h >= NEAREST; h *= FINER) {
        const double apart = cross(c, from, t, k, h, v);
        if (apart < least) memcpy(u, v, sizeof v);
        else if (least < HUGE_VAL && apart > WORSE * least) break;
        least = fmin(least, apart);
    }
    ric_shooting_evaluate(c, u);
    return least <= RIC_SAME_SOLVED * c->scale && ric_continuation_solved(c);
}

ric_periodic *ric_meeting_solve(const ric_model *m, const ric_periodic *cycle)
{
    const ric_canonical_way way = {.solve = solve, .grain = RIC_CANONICAL_GRAIN, .passes = PASSES};
    ric_periodic *found = ric_canonical_solve(m, cycle, &way), *out = NULL;
    if (found && ric_periodic_same(m, cycle, found, RIC_SAME_READ_OFF))
        out = ric_periodic_canonical(m, found);
    ric_periodic_free(found);
    return out;
}
