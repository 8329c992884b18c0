#include "node_solve.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "branch_point.h"
#include "canonical.h"
#include "node_solve_twice.h"
#include "branch/room.h"
#include "base/room.h"

/* AT_ZERO: a determinant whose zero is farther away than this, by its slope, has none here: the
 * sign changed at a pole */
#define AT_ZERO 1e-6
#define TOLD 1e-3  /* of it: two points nearer than this do not tell a slope */
#define FIRST 1e-6 /* of the size: first step of the secant, and the least that is tried */
#define LEAST_FIRST 1e-8
/* SETTLED: of the size: where the secant leads no farther than this from the best place, what is
 * left is rounding of the function */
#define SETTLED (4 * DBL_EPSILON)
#define ASTRAY 1e-2 /* of the size: a secant that goes so far seeks another zero */
/* FINE: where rounding may move the zero of a determinant of a smooth flow by more, it is sought in
 * higher precision */
#define FINE 1e-12
/* PLACED: an extremum is listed if its place is known to this part of the size of the orbit (a
 * bound: the error is a tenth) */
#define PLACED 1e-6
#define NARROWEST 1e-10 /* of the size: shorter branches are none */
/* FINE_STEPS: in extended precision, from a place that has the digits of double */
#define FINE_STEPS 5
/* STRAIGHT: part of its ends by which a function may be off a straight line that passes zero */
#define STRAIGHT 0.2
/* STEP: times the bound of its rounding by which a function is off zero on either side */
#define STEP 100
/* AT_ROOT: distance of lambda + 1/lambda from the root of unity of a multiplication, beside its
 * error */
#define AT_ROOT 1e-6
#define NEAR_ROOT 1e-4 /* the same with an error that is larger: farther away there is none */
/* FIRST_MOVE: of the size: the first step towards the root, from a zero of the determinant beside
 * it */
#define FIRST_MOVE 1e-12
#define FARTHEST 1.5e-4 /* a step of ten, which is rounded, may come to BESIDE or beyond */
#define BESIDE 1e-4     /* distance, relative, of the points whose slopes tell how sharp it is */
/* MET: relative distance at which it is: beside a branch point orbits are known to rounding /
 * distance */
#define MET 1e-8
/* NO_TIME: of the period: what rounding leaves of a flight between two impacts at one instant */
#define NO_TIME 1e-12
#define TOUCHES 1e-13 /* of the clearance: a motion that ends so near to a stop touches it */
/* WORSE: times what a motion is off touching: how far it may be from where it touches */
#define WORSE 10
/* BEYOND: of the clearance: an orbit that goes through a stop by more is no motion, and one that
 * stays farther from all no grazing */
#define BEYOND 1e-9
/* PASSES: most of them: where a place is known to less than a grain they need not come to an end */
#define PASSES 5
/* COARSE_GRAIN: the same where what vanishes is regular: the fewer orbits that differ by rounding
 * are rounded to different ones */
#define COARSE_GRAIN 0x1p-28

/* The same zero where rounding hides it: sought with twice the digits from u on, an orbit beside
 * it. */
static bool solve_finely(ric_criterion_work *q, double *u)
{
    ric_shooting *c = q->chain;
    double t[c->n_unknown];
    ric_continuation_tangent(c, NULL, t);
    if (!ric_node_solve_twice(c, q->test, t, u)) return false;
    ric_shooting_evaluate(c, u);
    return c->residual <= 4 * ric_continuation_tolerance(c);
}

/* f [4]: the function within h of u on either side, at these parts of it. */
static const double parts[] = {-1, -0.5, 0.5, 1};

static bool around(ric_criterion_work *q, const double *u, const double *normal, double h,
                   double *f, double *noise)
{
    ric_shooting *c = q->chain;
    int size = c->n_unknown, iterations;
    double v[size], du[size], t[size];
    *noise = 0;
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < size; j++) v[j] = u[j] + parts[i] * h * normal[j];
        if (!ric_continuation_correct(c, v, u, normal, parts[i] * h, du, &iterations)) return false;
        double sign = ric_continuation_tangent(c, normal, t);
        f[i] = ric_criterion_value(q, v, t, sign);
        if (isfinite(q->noise)) *noise = fmax(*noise, q->noise);
    }
    return true;
}

/* Whether f [4] is a straight line that is `middle` at u: by its slope over h, and more than what
 * it may be off. */
static bool straight(const double *f, double middle, double *slope)
{
    double off = 0;
    *slope = 0;
    for (int i = 0; i < 4; i++) *slope += parts[i] * f[i] / 2.5;
    for (int i = 0; i < 4; i++) off = fmax(off, fabs(f[i] - middle - *slope * parts[i]));
    return off < STRAIGHT * fabs(*slope);
}

/* Whether the function is a line through zero within h of u on either side. */
static bool passes(ric_criterion_work *q, const double *u, const double *normal, double h)
{
    double f[4], slope, noise;
    return around(q, u, normal, h, f, &noise) && straight(f, 0, &slope) && fabs(slope) > noise;
}

/* Whether the branch goes on for h on either side of u: all impacts have a speed, and flights a
 * time. */
static bool goes_on(ric_shooting *c, const double *u, const double *normal, double h)
{
    int size = c->n_unknown, iterations;
    double v[size], du[size];
    for (int side = -1; side <= 1; side += 2) {
        for (int j = 0; j < size; j++) v[j] = u[j] + side * h * normal[j];
        if (!ric_continuation_correct(c, v, u, normal, side * h, du, &iterations)) return false;
        if (!(ric_continuation_approach(c, true) > 0)) return false;
        for (int k = 0; k < c->n_flight; k++)
            if (!(v[c->n_start + k] > 0)) return false;
    }
    return true;
}

/* Whether f [4] changes its sign at u, and is more than `least` on either side. */
static bool changes(const double *f, double least)
{
    const double sign = f[0] < 0 ? -1 : 1, before = fmin(sign * f[0], sign * f[1]),
                 behind = fmin(-sign * f[2], -sign * f[3]);
    return fmin(before, behind) > least;
}

/* Whether the function is any line beside u: on a branch of one period its slope is rounding, of
 * which a bound tells little. It is looked at in two distances, smaller ones beside an end, and
 * where a branch turns within less, so that the function is a step of more than rounding. */
static bool inclines(ric_criterion_work *q, const double *u, const double *normal)
{
    const double rounding = STEP * ric_continuation_blur(q->chain, q->test);
    double f[4], slope, noise;
    bool step = false;
    int looked = 0;
    for (double h = BESIDE; h >= NARROWEST && (looked < 2 || step); h /= 10) {
        const double size = h * q->chain->scale;
        const bool seen = around(q, u, normal, size, f, &noise);
        if (seen && straight(f, (f[0] + f[1] + f[2] + f[3]) / 4, &slope)) return true;
        step = seen && changes(f, rounding);
        looked += goes_on(q->chain, u, normal, size);
    }
    return false;
}

/* Whether a zero at u stands out of rounding: at some distance the function passes it in a straight
 * line. On a branch of orbits that belong to families of two parameters, or nearly so, determinants
 * are rounding all along, and bounds of it tell little. The chain is left at u. */
static bool stands_out(ric_criterion_work *q, const double *u)
{
    ric_shooting *c = q->chain;
    double normal[c->n_unknown];
    bool found = false;
    ric_shooting_evaluate(c, u);
    ric_continuation_tangent(c, NULL, normal);
    for (double h = PLACED; h >= NARROWEST && !found;
         h /= 10) /* deep in a cascade branches are no longer than that */
        found = passes(q, u, normal, h * c->scale);
    for (double h = 10 * PLACED; h <= FARTHEST && !found; h *= 10)
        found = passes(q, u, normal, h * c->scale);
    ric_shooting_evaluate(c, u);
    return found;
}

/* Error of lambda + 1/lambda at u: of the map, and of the orbit, which is known to rounding, by the
 * slope along the curve. */
static double root_error(const ric_criterion_work *q, double slope)
{
    const ric_shooting *c = q->chain;
    return 4 * q->floquet.error +
           (isfinite(slope) ? fabs(slope) : 0) * ric_continuation_tolerance(c) * c->scale;
}

/* How far lambda + 1/lambda scatters over orbits that are not told apart from that at u, where the
 * chain has been evaluated: along the curve, and across it. Deep in a cascade the multipliers are
 * known far worse than the place. */
static double scatter_of_root(ric_criterion_work *q, const double *u, const double *normal,
                              double f0)
{
    enum { ALONG = 4, ALL = ALONG + RIC_TRACE_WAYS };
    static const int place[ALONG] = {-2, -1, 1, 2};
    ric_shooting *c = q->chain;
    int size = c->n_unknown, iterations;
    double v[ALL * size], du[size], scatter = 0, grain = ric_continuation_tolerance(c) * c->scale;
    for (int i = 0; i < ALONG; i++)
        for (int j = 0; j < size; j++) v[i * size + j] = u[j] + place[i] * grain * normal[j];
    if (!ric_continuation_move(c, u, v + ALONG * size)) return HUGE_VAL;
    for (int i = 0; i < ALL; i++) {
        double *at = v + i * size;
        if (i >= ALONG) ric_shooting_fly(c, at);
        else if (!ric_continuation_correct(c, at, u, normal, place[i] * grain, du, &iterations))
            continue;
        double f = ric_criterion_off_rotation(q);
        if (isfinite(f)) scatter = fmax(scatter, fabs(f - f0));
    }
    return scatter;
}

/* The determinant of the larger problem holds a stiff spring that closes for a short time to
 * rounding times its stiffness, and over that time the multipliers run through all they can: its
 * zero is near the root, and may be far from it in what matters. There the multipliers themselves
 * are exact, and lead on from u by the secant, which is moved if it comes nearer. False: it is
 * known that no multiplier has the root, or nothing of them is. */
static bool solve_root(ric_criterion_work *q, double *u)
{
    ric_shooting *c = q->chain;
    int size = c->n_unknown, iterations;
    double origin[size], normal[size], best[size], du[size], x0 = 0, x1 = FIRST_MOVE * c->scale;
    ric_shooting_evaluate(c, u);
    double f0 = ric_criterion_off_rotation(q), least = hypot(f0, q->aside),
           error = root_error(q, 0);
    if (!isfinite(least)) return !q->last; /* lost: nothing is known to be there */
    if (least <= fmin(NEAR_ROOT, AT_ROOT + error)) return true;
    ric_continuation_tangent(c, NULL, normal);
    double scatter = 4 * scatter_of_root(q, u, normal, f0);
    memcpy(origin, u, sizeof origin);
    memcpy(best, u, sizeof best);
    for (int i = 0; i < 20 && fabs(x1) <= AT_ZERO * c->scale; i++) {
        for (int j = 0; j < size; j++) u[j] = origin[j] + x1 * normal[j];
        if (!ric_continuation_correct(c, u, origin, normal, x1, du, &iterations)) break;
        double f1 = ric_criterion_off_rotation(q), distance = hypot(f1, q->aside);
        if (!isfinite(distance)) break;
        if (distance < least) {
            least = distance;
            memcpy(best, u, sizeof best);
            error = root_error(q, (f1 - f0) / (x1 - x0));
        }
        double next = x1 - f1 * (x1 - x0) / (f1 - f0);
        if (least <= q->floquet.error || next == x1) break;
        if (fabs(f1 - f0) < 4 * q->floquet.error) next = 10 * x1; /* nothing but rounding yet */
        x0 = x1;
        f0 = f1;
        x1 = next;
    }
    memcpy(u, best, sizeof best);
    ric_shooting_evaluate(c, u);
    return least <= fmin(NEAR_ROOT, AT_ROOT + error + scatter);
}

/* The same touch, u, with all its digits. Where a gap opens slowly along a branch the rounding of
 * orbits in double leaves billionths of its energy open: they are met in extended precision, and
 * along the curve the criterion by its slope there. u stays as it is where that leads away. */
static void place_finely(ric_criterion_work *q, double *u)
{
    ric_shooting *c = q->chain;
    const int size = c->n_unknown;
    double v[size], along[size], t[size], slope = 0, before = 0, step = 0;
    memcpy(v, u, sizeof v);
    ric_continuation_tangent(c, NULL, along);
    q->u = v;
    bool good = true;
    for (int i = 0; good && i < FINE_STEPS; i++) {
        for (int j = 0; j < size; j++) v[j] += step * along[j];
        if (!(good = ric_floquet_fine_nearest(c, v))) break;
        const double sign = ric_continuation_tangent(c, along, t),
                     value = ric_criterion_value(q, v, t, sign);
        if (i == 1) slope = (value - before) / step;
        before = value;
        step = i == 0 ? LEAST_FIRST * c->scale : -value / slope;
        good = fabs(step) <= RIC_SAME_LOCATED * c->scale;
    }
    if (good) memcpy(u, v, sizeof v);
    q->u = u;
    ric_shooting_evaluate(c, u);
}

/* Secant iteration along the curve from u to the zero of the criterion. u is moved there; false
 * where there is none. */
static bool solve_criterion(ric_criterion_work *q, double *u)
{
    ric_shooting *c = q->chain;
    int size = c->n_unknown, iterations;
    double du[size], origin[size], normal[size], t[size], best[size];
    double x0 = 0, x1 = 0, f0 = 0, f1, least = HUGE_VAL, at = 0, slope = 0, first = FIRST;
    q->u = u;
    if (!ric_continuation_correct(c, u, NULL, NULL, 0, du, &iterations)) return false;
    memcpy(origin, u, sizeof origin);
    ric_continuation_tangent(c, NULL, normal);
    f1 = ric_criterion_value(q, u, normal, 1);
    for (int i = 0; i < 30; i++) {
        if (fabs(x1 - x0) > TOLD * AT_ZERO * c->scale) slope = fabs((f1 - f0) / (x1 - x0));
        if (fabs(f1) < least) {
            least = fabs(f1);
            at = x1;
            memcpy(best, u, sizeof best);
        } else if (i > 4) break;
        if (f1 == 0) break;
        double x2 = i == 0 ? first * c->scale : x1 - f1 * (x1 - x0) / (f1 - f0);
        if (!isfinite(x2) || fabs(x2) > ASTRAY * c->scale) break;
        if (i > 0 && fabs(x2 - at) <= SETTLED * c->scale) break;
        x0 = x1;
        f0 = f1;
        x1 = x2;
        for (int j = 0; j < size; j++) u[j] = origin[j] + x1 * normal[j];
        if (!ric_continuation_correct(c, u, origin, normal, x1, du, &iterations)) {
            if (i > 0 || first < LEAST_FIRST) return false;
            first /= 10; /* deep in a cascade a branch is no longer than that */
            x1 = 0;
            i = -1;
            continue;
        }
        double sign = ric_continuation_tangent(c, normal, t);
        f1 = ric_criterion_value(q, u, t, sign);
        if (x1 == x0) break;
    }
    memcpy(u, best, sizeof best);
    ric_shooting_evaluate(c, u);
    if (q->test == RIC_TEST_APPROACH && q->last) place_finely(q, u);
    if (q->test == RIC_TEST_ASKED) return least <= MET;
    bool by_determinant = ric_criterion_breaks_symmetry(q->test) || q->test == RIC_TEST_DET ||
                          (q->test == RIC_TEST_ROTATION && ric_criterion_by_larger(q));
    if (q->test == RIC_TEST_ROTATION && !by_determinant) return solve_root(q, u);
    if (!by_determinant) /* an extremum, unless the secant has led away from it */
        return (q->test != RIC_TEST_SLOPE && q->test != RIC_TEST_PERIOD) ||
               least <= fmax(PLACED * c->scale * slope, ric_continuation_blur(c, q->test));
    /* the bound of the rounding may be less than what the secant leaves */
    bool blurred = ric_flight_law_of(c->model)->integrated &&
                   ric_criterion_breaks_symmetry(q->test) &&
                   !(fmax(q->noise, least) <= FINE * c->scale * slope);
    if (blurred) return !q->last || solve_finely(q, u);
    if (!(least <= AT_ZERO * c->scale * slope)) return false;
    const bool told = q->test == RIC_TEST_ROTATION || !ric_flight_law_of(c->model)->integrated;
    if (q->last && told && !stands_out(q, best)) return false;
    return !q->last || q->test != RIC_TEST_ROTATION || solve_root(q, u);
}

/* Impact of the chain (index into approach) whose speed is smallest, or flight between switches of
 * one spring that is shortest. */
static int slowest(const ric_shooting *c, const double *u, bool *soft)
{
    int best = -1;
    double least = HUGE_VAL;
    *soft = false;
    for (int k = c->start == RIC_MIRROR_IMPACT ? 0 : 1; k <= c->n_flight; k++)
        if (c->face[k] >= 0 && c->model->face[c->face[k]].spring == 0 &&
            fabs(c->approach[k]) < least) {
            least = fabs(c->approach[k]);
            best = k;
        }
    for (int k = 0; k < c->n_flight; k++)
        if (ric_shooting_touches(c, k) && fabs(u[c->n_start + k]) < least) {
            least = fabs(u[c->n_start + k]);
            best = k;
            *soft = true;
        }
    return best;
}

static bool place_crossing(const void *of, ric_shooting *chain, double *u, bool rounded)
{
    (void)of, (void)rounded;
    return ric_branch_point_place(chain, u);
}

static bool solve_for(const void *of, ric_shooting *chain, double *u, bool rounded)
{
    ric_criterion_work q = ric_criterion_begin(*(const ric_criterion *)of, chain);
    q.last = rounded;
    bool good = !ric_floquet_create(chain->n, &q.floquet);
    /* of several touches the slowest is noise unless it is that of the rounded unknowns */
    ric_shooting_evaluate(chain, u);
    if (q.test == RIC_TEST_APPROACH) good &= (q.place = slowest(chain, u, &q.soft)) >= 0;
    if (q.test == RIC_TEST_FLIGHT) q.place = ric_criterion_shortest(chain, u);
    good = good && solve_criterion(&q, u);
    ric_criterion_release(&q);
    return good;
}

/* A crossing of two branches of one symmetry is placed to all its digits where an orbit beside it
 * comes there. */
static ric_periodic *solve_near(const ric_model *m, const ric_periodic *cycle,
                                const ric_criterion *what)
{
    const bool crosses = what->test == RIC_TEST_DET;
    const ric_canonical_way place = {.solve = place_crossing,
                                     .grain = RIC_CANONICAL_GRAIN,
                                     .passes = 2},
                            find = {.solve = solve_for,
                                    .of = what,
                                    .grain = what->test == RIC_TEST_ASKED ? COARSE_GRAIN
                                                                          : RIC_CANONICAL_GRAIN,
                                    .passes = PASSES};
    ric_periodic *placed = crosses ? ric_canonical_solve(m, cycle, &place) : NULL;
    if (placed) return placed;
    ric_periodic *out = ric_canonical_solve(m, cycle, &find);
    if (out && crosses) placed = ric_canonical_solve(m, out, &place);
    if (!placed) return out;
    ric_periodic_free(out);
    return placed;
}

ric_periodic *ric_node_solve(const ric_model *m, const ric_periodic *cycle, ric_criterion what,
                             bool *moved)
{
    ric_periodic *out = solve_near(m, cycle, &what);
    if (!out) return NULL;
    /* a chain may start at another impact than the canonical one; and what was found must be what
     * was looked for */
    /* an extremum whose place is known to PLACED does not move: what does was rounding, and led to
     * another branch */
    const double far = what.test == RIC_TEST_SLOPE || what.test == RIC_TEST_PERIOD
                           ? 10 * PLACED
                           : RIC_SAME_READ_OFF;
    const bool near = ric_periodic_same(m, cycle, out, far);
    ric_periodic *canonical = near ? ric_periodic_canonical(m, out) : NULL;
    if (moved) *moved = !near;
    ric_periodic_free(out);
    return canonical;
}

bool ric_node_solve_sharp(const ric_model *m, const ric_periodic *cycle, int test)
{
    ric_criterion_work q = {.test = test};
    double *u = NULL;
    bool line = false, placed = false;
    if (!ric_periodic_to_chain(m, cycle, &q.chain, &u)) {
        ric_shooting *c = q.chain;
        double f[4], noise, normal[c->n_unknown];
        ric_shooting_evaluate(c, u);
        ric_continuation_tangent(c, NULL, normal);
        const bool seen = around(&q, u, normal, BESIDE * c->scale, f, &noise);
        ric_shooting_evaluate(c, u);
        const double least = PLACED * fabs(f[3] - f[0]) / (2 * BESIDE);
        placed = seen && least > ric_continuation_slope_error(c, u, normal, test, least);
        line = inclines(&q, u, normal);
    }
    ric_shooting_free(q.chain);
    free(u);
    return line && placed;
}

static bool solve_chain(ric_shooting *chain, double *u)
{
    double du[chain->n_unknown], from[chain->n_unknown], moved = 0;
    int iterations;
    memcpy(from, u, sizeof from);
    if (!ric_continuation_correct(chain, u, NULL, NULL, 0, du, &iterations)) return false;
    for (int i = 0; i < chain->n_unknown; i++) moved = fmax(moved, fabs(u[i] - from[i]));
    return moved <= RIC_SAME_LOCATED * chain->scale;
}

/* How far the motion of the chain reaches beyond the stop that it comes nearest to, of its
 * clearance. */
static double beyond(ric_shooting *c, const double *u)
{
    ric_shooting_fly(c, u);
    return ric_reach(c, u, NULL) - 1;
}

/* Moves u along its curve to where the motion touches, by no more than a place is known to: with
 * its touches an orbit may lack a symmetry that it has without them, and be known worse, as far as
 * it is off touching. */
static void settle_touch(ric_shooting *c, double *u, double off)
{
    const double farthest = fmin(fmax(RIC_SAME_LOCATED, WORSE * off), RIC_SAME_READ_OFF) * c->scale;
    const int size = c->n_unknown;
    double origin[size], normal[size], v[size], du[size], x0 = 0, x1 = LEAST_FIRST * c->scale,
                                                          f0 = beyond(c, u), least = fabs(f0);
    int iterations;
    memcpy(origin, u, sizeof origin);
    ric_shooting_evaluate(c, u);
    ric_continuation_tangent(c, NULL, normal);
    for (int i = 0; i < 5 && least > TOUCHES && fabs(x1) <= farthest; i++) {
        for (int j = 0; j < size; j++) v[j] = origin[j] + x1 * normal[j];
        if (!ric_continuation_correct(c, v, origin, normal, x1, du, &iterations)) return;
        const double f1 = beyond(c, v), next = x1 - f1 * (x1 - x0) / (f1 - f0);
        if (fabs(f1) < least) {
            least = fabs(f1);
            memcpy(u, v, sizeof v);
        }
        if (!isfinite(next)) return;
        x0 = x1;
        f0 = f1;
        x1 = next;
    }
}

/* Of an orbit with mirror points the state at one of these is solved for, and flown to where the
 * orbit is said to begin: on the way stiff springs multiply its rounding, and the rest of the
 * period does so again. Where that leaves it open, that state is solved for itself, on the whole
 * period; it moves by next to nothing. */
static void close_up(const ric_model *m, ric_periodic *c)
{
    ric_shooting *chain = NULL;
    double *u = NULL;
    ric_periodic *plain = ric_periodic_start(m, c) == 0 ? ric_periodic_copy(c) : NULL;
    if (!plain) return;
    plain->half = false;
    plain->pure = plain->flip = -1;
    if (!ric_periodic_to_chain(m, plain, &chain, &u)) {
        ric_shooting_evaluate(chain, u);
        const double open = chain->residual;
        bool closes = open > ric_continuation_tolerance(chain) && solve_chain(chain, u) &&
                      2 * chain->residual < open;
        for (int k = chain->n_start; closes && k < chain->n_unknown; k++) closes = u[k] >= 0;
        if (closes) {
            memcpy(c->w, u, 2 * (size_t)m->n * sizeof *u);
            memcpy(c->tau, u + chain->n_start, (size_t)c->N * sizeof *u);
        }
    }
    ric_periodic_free(plain);
    ric_shooting_free(chain);
    free(u);
}

ric_periodic *ric_node_solve_again(const ric_model *m, const ric_periodic *cycle)
{
    ric_shooting *chain = NULL;
    double *u = NULL;
    ric_periodic *solved = NULL, *out = NULL;
    bool good = !ric_periodic_to_chain(m, cycle, &chain, &u);
    const double given = good ? fabs(beyond(chain, u)) : 0;
    if (good && (good = solve_chain(chain, u))) settle_touch(chain, u, given);
    /* in a family of two parameters Newton's method may slide to where nothing touches: then it
     * stays as it was */
    if (good && fabs(beyond(chain, u)) <= fmax(10 * TOUCHES, 2 * given))
        solved = ric_periodic_from_chain(chain, u);
    if (solved) out = ric_periodic_canonical(m, solved);
    if (out && ric_periodic_has_events(m) && out->N > 0) close_up(m, out);
    ric_periodic_free(solved);
    ric_shooting_free(chain);
    free(u);
    return out;
}

bool ric_node_solve_touches(const ric_model *m, const ric_periodic *cycle)
{
    ric_shooting *chain = NULL;
    double *u = NULL;
    const bool touches = !ric_periodic_to_chain(m, cycle, &chain, &u) &&
                         fabs(beyond(chain, u)) <= 10 * TOUCHES;
    ric_shooting_free(chain);
    free(u);
    return touches;
}

bool ric_node_solve_solved(const ric_model *m, const ric_periodic *cycle)
{
    ric_shooting *chain = NULL;
    double *u = NULL;
    bool solved = !ric_periodic_to_chain(m, cycle, &chain, &u);
    if (solved) ric_shooting_evaluate(chain, u);
    solved = solved && ric_continuation_solved(chain);
    ric_shooting_free(chain);
    free(u);
    return solved;
}

/* Whether an orbit is a motion that closes and goes through no stop; *reach: how near it comes to
 * one, of the clearance. */
static bool is_motion(const ric_model *m, const ric_periodic *cycle, double *reach)
{
    ric_shooting *chain = NULL;
    double *u = NULL;
    bool admissible = true;
    for (int i = 0; i < cycle->N; i++)
        admissible &= cycle->tau[i] >= -NO_TIME * ric_periodic_period(cycle);
    admissible = admissible && !ric_periodic_to_chain(m, cycle, &chain, &u);
    if (admissible) {
        ric_shooting_fly(chain, u);
        *reach = ric_reach(chain, u, NULL);
        admissible = chain->residual <= RIC_SAME_SOLVED && *reach <= 1 + BEYOND;
    }
    ric_shooting_free(chain);
    free(u);
    return admissible;
}

bool ric_node_solve_admissible(const ric_model *m, const ric_periodic *cycle)
{
    double reach;
    return is_motion(m, cycle, &reach);
}

bool ric_node_solve_grazes(const ric_model *m, const ric_periodic *cycle)
{
    double reach;
    return is_motion(m, cycle, &reach) && reach >= 1 - BEYOND;
}
