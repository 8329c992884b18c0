/* Newton's method onto the curve of orbits, and what is rounding of it. */
#include "continuation.h"

#include <float.h>
#include <math.h>

#include "base/room.h"
#include "flow/room.h"

#define NEWTON_STEPS 8
#define HOPELESS 1e3 /* residual, of the size, from which no Newton step leads back */
#define FLOOR 0.03   /* of the tolerance: where another Newton step changes nothing */
/* ROUNDED: of the tolerance: under a power law a Newton step is made of rounding there, and leaves
 * as much, while the flight that would tell is nearly all that a step costs */
#define ROUNDED 0.125
/* BENT: between stops a Newton step of this length, of the size, leaves its square times that, of
 * 1, at most (560 was seen of 30,000 orbits), or BENT_SAFETY times what the step before has left.
 * Springs that are stiff, and power laws, bend by more */
#define BENT 1e4
#define BENT_SAFETY 10
#define ACCEPTED 4 /* tolerances: the largest residual of an orbit that is stored */
/* LOST: the same over ACCEPTED where the tolerance is larger: where more is rounding, nothing is
 * known of an orbit */
#define LOST 2.5e-10
/* BESIDE: of the size, a step of Newton's method to an orbit that is the same but for rounding, at
 * most: where the equations are singular the first one leads anywhere, and flights through the
 * energies there may take seconds */
#define BESIDE 0.1

/* Rounding of n_flight rotations adds up like a random walk; the constants are three times what was
 * measured. */
static double of_flights(const ric_shooting *c)
{
    return 24 * DBL_EPSILON * (1 + 0.25 * sqrt(c->n_flight)) * (1 + 0.1 * c->n);
}

/* A closed spring makes a velocity of the rounding of the displacement at which it was met. */
double ric_continuation_rounding(const ric_shooting *c)
{
    return of_flights(c) * (1 + c->stiff);
}

double ric_continuation_tolerance(const ric_shooting *c)
{
    return ric_continuation_rounding(c) * c->share + DBL_EPSILON * c->grain;
}

/* The kernel vector is lost by rounding / pivot as it stands; and the orbit is known to what its
 * residual leaves / pivot, towards the other branch, where the field of directions turns by 1 /
 * distance, that is, by 1 / pivot once more. */
double ric_continuation_blur(const ric_shooting *c, int test)
{
    double kernel = ric_continuation_rounding(c) / c->smallest * (1 + FLOOR / c->smallest);
    return test == RIC_TEST_PERIOD ? sqrt(c->n_flight) * kernel : kernel;
}

double ric_continuation_slope(const ric_shooting *c, int test, const double *t)
{
    double sum = 0;
    if (test == RIC_TEST_SLOPE) return ric_shooting_energy_slope(c, t) / c->scale;
    for (int k = c->n_start; k < c->n_start + c->n_flight; k++) sum += t[k];
    return sum;
}

bool ric_continuation_solved(const ric_shooting *c)
{
    return c->residual <= ACCEPTED * fmin(ric_continuation_tolerance(c), LOST);
}

/* The plane normal . (u - origin) = target, or, normal NULL, none; and the longest step, beyond
 * which there is another orbit. */
typedef struct {
    const double *origin, *normal;
    double target, longest;
} aim;

/* The step du that a plane asks for: along the curve to it. False: the curve runs beside it. */
static bool into_plane(const ric_shooting *c, const double *u, const aim *to, double *du)
{
    const double *normal = to->normal;
    int size = c->n_unknown;
    double kernel[size];
    ric_shooting_steps(c, du, kernel);
    double across = ric_dot(size, normal, kernel), now = ric_dot(size, normal, du) - to->target;
    for (int j = 0; j < size; j++) now += normal[j] * (u[j] - to->origin[j]);
    if (fabs(across) < RIC_RANK) return false;
    for (int j = 0; j < size; j++) du[j] -= now / across * kernel[j];
    return true;
}

static bool correct(ric_shooting *c, double *u, const aim *to, double *du, int *iterations)
{
    int size = c->n_unknown;
    const ric_flight_law *law = ric_flight_law_of(c->model);
    const bool bounded = !law->closes && !law->integrated;
    double last = HUGE_VAL, bent = BENT, left = HUGE_VAL;
    for (int i = 0; i <= NEWTON_STEPS; i++) {
        *iterations = i;
        c->rough = i == 0; /* it is never the last */
        ric_shooting_evaluate(c, u);
        c->rough = false;
        if (c->singular || !(c->residual < HOPELESS)) return false;
        /* at rounding level, and not merely passing through it: an unstable orbit needs every digit
         */
        double tolerance = fmin(ric_continuation_tolerance(c), LOST);
        /* with springs most displacements are met better than they may be */
        const double flights = of_flights(c) * c->share, floor = FLOOR * flights;
        if (i > 0 &&
            (c->residual <= floor || (law->integrated && c->residual <= ROUNDED * tolerance) ||
             (bounded && c->residual <= flights && left <= floor) ||
             (c->residual <= tolerance && c->residual > RIC_FALLING * last)))
            return true;
        if (i > 0 && c->residual > tolerance)
            bent = fmax(bent, BENT_SAFETY * bent * c->residual / left);
        if (i > 2 && c->residual > RIC_STALLING * last) return ric_continuation_solved(c);
        last = c->residual;
        if (!to->normal) ric_shooting_step(c, true, 0, du);
        else if (!into_plane(c, u, to, du)) return false;
        const double moved = ric_dot(size, du, du);
        if (moved > to->longest * to->longest) return false;
        left = bent * moved / (c->scale * c->scale);
        for (int j = 0; j < size; j++) u[j] += du[j];
    }
    return false;
}

bool ric_continuation_correct(ric_shooting *c, double *u, const double *origin,
                              const double *normal, double target, double *du, int *iterations)
{
    const aim to = {.origin = origin, .normal = normal, .target = target, .longest = HUGE_VAL};
    return correct(c, u, &to, du, iterations);
}

bool ric_continuation_correct_beside(ric_shooting *c, double *u)
{
    const aim to = {.longest = BESIDE * c->scale};
    double du[c->n_unknown];
    int iterations;
    return correct(c, u, &to, du, &iterations);
}

double ric_continuation_tangent(const ric_shooting *c, const double *along, double *t)
{
    ric_shooting_step(c, false, 1, t);
    if (!along || ric_dot(c->n_unknown, t, along) >= 0) return 1;
    for (int i = 0; i < c->n_unknown; i++) t[i] = -t[i];
    return -1;
}
