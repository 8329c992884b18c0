/* Where within a step something happens: solved for, or read off cubics where nothing can be solved
 * (event.c). */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "event_parts.h"
#include "model/room.h"
#include "base/room.h"

#define PLACE 2e-16         /* of the step: a zero within it is at the last digit */
#define PLACE_AT_ZERO 1e-17 /* scaled arclength: the same beside a step of no length */
#define PLACED 1e-14        /* of the size: a resonance that near is solved for as a junction */
/* How much more than at a known place the error of a cubic may be where it is corrected by that. */
#define ALIKE 4
/* A sign change whose function does not fall below this part of its values at the ends is a pole or
 * a hop. */
#define TRUE_ZERO 1e-5
/* The same for multipliers: on sharp tongues they run from -3e4 to 2 within 1e-7 and are noise of
 * 1e-5. */
#define TRUE_RESONANCE 1e-2
/* CLOSED: of the size: a gap that is less than minus this is closed, whatever the rounding */
#define CLOSED 1e-13
#define SCALES 16 /* of distances from a touch of springs, at which gaps are looked at */

/* ------------------------------------------------------------------ location */

void ric_event_cubic(const ric_continuation *tr, double x, double h, double *u)
{
    const ric_station *a = &tr->now, *b = &tr->next;
    double y = x / h, H = b->s - a->s;
    double p = 2 * y * y * y - 3 * y * y + 1, q = (y * y * y - 2 * y * y + y) * H, r = 1 - p,
           s = (y * y * y - y * y) * H;
    for (int i = 0; i < tr->chain->n_unknown; i++)
        u[i] = p * a->u[i] + q * a->t[i] + r * b->u[i] + s * b->t[i];
}

/* The orbit at x of an earlier call in this step: the chain is left evaluated there, as Newton's
 * method left it. */
static bool solved_before(ric_continuation *tr, double x, double *u)
{
    const ric_solved_orbits *q = &tr->solved;
    const size_t size = (size_t)tr->chain->n_unknown;
    for (int i = q->n - 1; i >= 0 && i >= q->n - RIC_MOST_SOLVED; i--) {
        if (q->x[i % RIC_MOST_SOLVED] != x) continue;
        memcpy(u, q->u + (size_t)(i % RIC_MOST_SOLVED) * size, size * sizeof *u);
        ric_shooting_evaluate(tr->chain, u);
        tr->evaluations++;
        return !tr->chain->singular;
    }
    return false;
}

static void keep_solved(ric_continuation *tr, double x, const double *u)
{
    ric_solved_orbits *q = &tr->solved;
    const size_t size = (size_t)tr->chain->n_unknown;
    if (q->full) return;
    const int place = q->n++ % RIC_MOST_SOLVED;
    q->x[place] = x;
    memcpy(q->u + (size_t)place * size, u, size * sizeof *u);
}

/* How the error of the cubic grows between its ends, at both of which it has a double zero. */
static double growth(double x, double h)
{
    return x * x * (h - x) * (h - x);
}

/* The two orbits solved for that are nearest to x, by their numbers in the ring; -1: none, which
 * errors at their places tell nothing of that at x. */
static void nearest(const ric_continuation *tr, double x, double h, int *near)
{
    const ric_solved_orbits *q = &tr->solved;
    near[0] = near[1] = -1;
    for (int i = q->n - 1; i >= 0 && i >= q->n - RIC_MOST_SOLVED; i--) {
        const int k = i % RIC_MOST_SOLVED;
        if (!(growth(x, h) <= ALIKE * growth(q->x[k], h))) continue;
        if (near[0] < 0 || fabs(q->x[k] - x) < fabs(q->x[near[0]] - x)) {
            near[1] = near[0];
            near[0] = k;
        } else if (near[1] < 0 || fabs(q->x[k] - x) < fabs(q->x[near[1]] - x)) near[1] = k;
    }
}

/* The unknowns at x, from the cubic and what it misses orbits nearby by, over its growth: a number
 * for one of them, a straight line for two. */
static void predict(const ric_continuation *tr, double x, double h, double *u)
{
    const ric_solved_orbits *q = &tr->solved;
    const int size = tr->chain->n_unknown;
    int near[2];
    double at[size], all = growth(x, h);
    ric_event_cubic(tr, x, h, u);
    nearest(tr, x, h, near);
    double part[2] = {1, 0};
    if (near[1] >= 0) {
        const double apart = q->x[near[0]] - q->x[near[1]], aside = (x - q->x[near[0]]) / apart;
        if (fabs(aside) <= ALIKE) {
            part[0] = 1 + aside;
            part[1] = -aside;
        }
    }
    for (int k = 0; k < 2 && near[k] >= 0 && part[k] != 0; k++) {
        const double *v = q->u + near[k] * size, factor = part[k] * all / growth(q->x[near[k]], h);
        ric_event_cubic(tr, q->x[near[k]], h, at);
        for (int i = 0; i < size; i++) u[i] += factor * (v[i] - at[i]);
    }
}

static bool correct(ric_continuation *tr, double x, double h, ric_station *out)
{
    const ric_station *a = &tr->now;
    int iterations;
    out->s = a->s + (tr->next.s - a->s) * (x / h);
    if ((out->solved = solved_before(tr, x, out->u))) return true;
    predict(tr, x, h, out->u);
    out->solved = ric_continuation_correct(tr->chain, out->u, a->u, a->t, x, tr->du, &iterations);
    tr->evaluations += iterations + 1;
    if (out->solved) keep_solved(tr, x, out->u);
    return out->solved;
}

void ric_event_know(ric_continuation *tr, double x, const ric_station *p)
{
    ric_known_pairs *k = &tr->known;
    const size_t size = 2 * (size_t)tr->floquet.n_pair;
    if (!tr->n_resonance || k->n == RIC_MOST_KNOWN) return;
    k->x[k->n] = x;
    memcpy(k->own + (size_t)k->n * size, p->own, size * sizeof *p->own);
    k->n++;
}

ric_status ric_event_solve(ric_continuation *tr, double x, double h, unsigned at, ric_station *out,
                           bool *good)
{
    if (!(*good = correct(tr, x, h, out))) return RIC_OK;
    double sign = ric_continuation_tangent(tr->chain, tr->now.t, out->t);
    ric_status status = ric_continuation_look(tr, out, sign, at);
    if (!status && at & RIC_LOOK_PAIRS) ric_event_know(tr, x, out);
    return status;
}

/* What has to be looked at for one test. */
static unsigned needed(const ric_continuation *tr, int test)
{
    if (ric_continuation_resonance(tr, test)) return RIC_LOOK_PAIRS | RIC_LOOK_FOR;
    if (test < RIC_N_TEST && EVENT_SINGULAR & 1u << test) return RIC_LOOK_FACTORS;
    return test == RIC_TEST_REACH    ? RIC_LOOK_REACH
           : test == RIC_TEST_SLOPE  ? RIC_LOOK_ENERGY
           : test == RIC_TEST_PERIOD ? RIC_LOOK_PERIOD
                                     : 0;
}

double ric_event_value(const ric_continuation *tr, int test, const ric_station *p)
{
    if (test < RIC_N_TEST) return p->test[test];
    const ric_user_point *asked = ric_continuation_user_point(tr, test);
    if (asked) return ric_user_point_off(asked, p->row.energy, p->row.frequency);
    return ric_resonance_test(p->own, tr->floquet.n_pair, tr->resonances[test - RIC_N_TEST].rho);
}

/* By what a zero is told from a jump: of the factors of the map, whose tests are relative to pivots
 * that change their places, what is smooth. */
static double height(int test, const ric_station *p, double value)
{
    return test < RIC_N_TEST && EVENT_SINGULAR & 1u << test
               ? fabs(p->factor[test == RIC_TEST_A   ? 0
                                : test == RIC_TEST_B ? 1
                                                     : 2])
               : fabs(value);
}

/* Draws the ends x, f of a bracket together to what is known inside. */
static void draw_together(const ric_continuation *tr, double rho, double *x, double *f)
{
    const ric_known_pairs *k = &tr->known;
    const int n_pair = tr->floquet.n_pair;
    for (int i = 0; i < k->n; i++) {
        if (!(k->x[i] > x[0] && k->x[i] < x[1])) continue;
        const double value = ric_resonance_test(k->own + i * 2 * n_pair, n_pair, rho);
        if (!(value * f[0] > 0 || value * f[1] > 0)) continue;
        const int end = value * f[0] > 0 ? 0 : 1;
        x[end] = k->x[i];
        f[end] = value;
    }
}

/* The same of values without bound: the only pair less what it is at the resonance, which along a
 * branch is nearly a quotient of straight lines, as it runs through infinity where an impact loses
 * its speed. False: it is not known at both ends, or there are several pairs. */
static bool off_resonance(const ric_continuation *tr, double rho, const double *x, double *f)
{
    const ric_known_pairs *k = &tr->known;
    double off[2] = {NAN, NAN};
    for (int i = 0; i < k->n && tr->floquet.n_pair == 1; i++)
        for (int end = 0; end < 2; end++)
            if (k->x[i] == x[end]) off[end] = k->own[2 * i] - rho;
    if (!(off[0] * f[0] > 0 && off[1] * f[1] > 0)) return false;
    memcpy(f, off, sizeof off);
    return true;
}

/* What rounding makes of the energy of an orbit: where the equations are all but singular, as
 * beside modes of nearly one frequency, more than a part of its values at the ends. And of the
 * speed of an impact, which is less for a long way where it vanishes by powers of the distance. */
static double blur(const ric_shooting *c, int test)
{
    if (test == RIC_TEST_APPROACH) return ric_continuation_rounding(c) * c->scale;
    const bool energy = test == RIC_TEST_E_MAX || test == RIC_TEST_E_MIN;
    return energy ? DBL_EPSILON / c->smallest * ric_shooting_energy(c) : 0;
}

ric_status ric_event_locate(ric_continuation *tr, int test, double xa, double fa, double xb,
                            double fb, double h, double *where, bool *zero)
{
    double size = fmax(fabs(fa), fabs(fb)), top = height(test, &tr->now, fa);
    const unsigned at = needed(tr, test);
    ric_status status;
    bool good = false;
    const ric_resonance *resonance = ric_continuation_resonance(tr, test);
    double x[2] = {xa, xb}, f[2] = {fa, fb};
    if (resonance) draw_together(tr, resonance->rho, x, f);
    const bool quotient = resonance && off_resonance(tr, resonance->rho, x, f);
    ric_root r = ric_root_between(x[0], f[0], x[1], f[1],
                                  fmax(PLACE * h + PLACE_AT_ZERO,
                                       resonance ? PLACED * tr->chain->scale : 0));
    r.quotient = quotient;
    *zero = false;
    double last = NAN;
    while (ric_root_next(&r)) {
        if ((status = ric_event_solve(tr, last = r.x, h, at, &tr->mid, &good))) return status;
        if (!good) return RIC_OK;
        const double value = ric_event_value(tr, test, &tr->mid);
        r.f = quotient ? tr->mid.own[0] - resonance->rho : value;
        if (quotient) r.noise = fmin(tr->floquet.error, RIC_SEEN_TO * (1 + fabs(resonance->rho)));
        top = fmax(top, height(test, &tr->mid, value));
    }
    if (r.x == last) good = true;
    else if ((status = ric_event_solve(tr, r.x, h, at, &tr->mid, &good))) return status;
    *where = r.x;
    double least = ric_event_value(tr, test, &tr->mid),
           part = test < RIC_N_TEST ? TRUE_ZERO : TRUE_RESONANCE;
    *zero = good && (fabs(least) <= fmax(part * size, blur(tr->chain, test)) ||
                     (test < RIC_N_TEST && height(test, &tr->mid, least) <= part * top));
    return RIC_OK;
}

ric_status ric_event_reach_beside(ric_continuation *tr, double least, double h, int *test,
                                  double *end)
{
    double from = 0, before = tr->now.test[RIC_TEST_REACH], x;
    bool good = before > 0, zero = false;
    for (double d = *end / SCALES; good && d >= least; d /= SCALES) {
        ric_status status = ric_event_solve(tr, *end - d, h, RIC_LOOK_REACH, &tr->mid, &good);
        const double f = good ? tr->mid.test[RIC_TEST_REACH] : NAN;
        if (!status && f < -CLOSED * tr->chain->scale)
            status = ric_event_locate(tr, RIC_TEST_REACH, from, before, *end - d, f, h, &x, &zero);
        if (status) return status;
        if (zero) {
            *test = RIC_TEST_REACH;
            *end = x;
        }
        if (zero || !(f > 0)) break;
        from = *end - d;
        before = f;
    }
    return RIC_OK;
}

/* ------------------------------------------------------------------ crossings */

static void lagrange(const double *x, double at, double *value, double *slope)
{
    for (int i = 0; i < 4; i++) {
        double product = 1, sum = 0;
        for (int j = 0; j < 4; j++) {
            if (j == i) continue;
            double rest = 1 / (x[i] - x[j]);
            product *= (at - x[j]) / (x[i] - x[j]);
            for (int k = 0; k < 4; k++)
                if (k != i && k != j) rest *= (at - x[k]) / (x[i] - x[k]);
            sum += rest;
        }
        value[i] = product;
        slope[i] = sum;
    }
}

/* The function of a resonance at point i. That of several pairs tends to a sign where they are
 * large, and a cubic through such values does not show that they are small in between: of one pair
 * it is the pair, which grows like the square of the distance from an end that is its own image. */
static double bridge_resonance(const ric_continuation *tr, const ric_event_bridge *q, int i,
                               double rho)
{
    const int n_pair = tr->floquet.n_pair;
    const double *own = q->own + i * 2 * n_pair;
    return n_pair == 1 ? own[0] - rho : ric_resonance_test(own, n_pair, rho);
}

double ric_event_bridge_test(const ric_continuation *tr, const ric_event_bridge *q, int test,
                             double at)
{
    double value[4], slope[4], sum = 0;
    lagrange(q->x, at, value, slope);
    for (int i = 0; i < 4; i++)
        sum += value[i] * (test < RIC_N_TEST
                               ? q->test[i][test]
                               : bridge_resonance(tr, q, i, tr->resonances[test - RIC_N_TEST].rho));
    return sum;
}

/* Solves at the four distances q->x; false if one of them does not converge. */
static ric_status build_at(ric_continuation *tr, double h, ric_event_bridge *q, bool *good)
{
    size_t size = (size_t)tr->chain->n_unknown, pairs = 2 * (size_t)tr->floquet.n_pair;
    *good = true;
    for (int i = 0; i < 4 && *good; i++) {
        ric_status status = ric_event_solve(tr, q->x[i], h, RIC_LOOK_ALL, &tr->mid, good);
        if (status) return status;
        memcpy(q->test[i], tr->mid.test, sizeof tr->mid.test);
        memcpy(q->u + (size_t)i * (size_t)size, tr->mid.u, (size_t)size * sizeof *q->u);
        memcpy(q->own + (size_t)i * (size_t)pairs, tr->mid.own, (size_t)pairs * sizeof *q->own);
    }
    return RIC_OK;
}

/* The points lie at fixed distances on both sides, wherever in the step the root is: a point close
 * to it would be noise. Where the branch bends too much for that, they lie within the step. */
ric_status ric_event_bridge_build_at(ric_continuation *tr, double root, double h,
                                     ric_event_bridge *q)
{
    static const double place[4] = {-1, -0.5, 0.5, 1};
    size_t size = (size_t)tr->chain->n_unknown, pairs = 2 * (size_t)tr->floquet.n_pair;
    double within[4] = {0, root / 2 * h, (1 + root) / 2 * h, h};
    bool good = false;
    if (!(q->u = ric_malloc(4 * (size + pairs) * sizeof *q->u))) return ric_no_memory("a crossing");
    q->own = q->u + 4 * size;
    for (int i = 0; i < 4; i++) q->x[i] = root * h + place[i] * RIC_CROSSING / 2 * tr->chain->scale;
    ric_status status = build_at(tr, h, q, &good);
    if (!status && !good) {
        memcpy(q->x, within, sizeof within);
        status = build_at(tr, h, q, &good);
    }
    if (!status && !good) status = ric_fail(RIC_E_NUMERIC, "no convergence beside a branch point");
    if (status) {
        free(q->u);
        q->u = NULL;
    }
    return status;
}

ric_status ric_event_bridge_build(ric_continuation *tr, double h, ric_event_bridge *q)
{
    const double fa = tr->now.test[RIC_TEST_DET], fb = tr->next.test[RIC_TEST_DET];
    return ric_event_bridge_build_at(tr, fa / (fa - fb), h, q);
}

/* The same without its zero at `known`, NAN for none: the cubic, less what it misses zero by there,
 * over the distance. */
static double deflated(const ric_continuation *tr, const ric_event_bridge *q, int test, double x,
                       double known)
{
    double f = ric_event_bridge_test(tr, q, test, x);
    return isnan(known) ? f : (f - ric_event_bridge_test(tr, q, test, known)) / (x - known);
}

double ric_event_bridge_root(const ric_continuation *tr, const ric_event_bridge *q, int test,
                             double a, double b, double sign, double known)
{
    double fa = sign * fabs(deflated(tr, q, test, a, known)), fb = deflated(tr, q, test, b, known);
    if (sign * fb > 0) { /* the first of two zeros */
        fb = deflated(tr, q, test, (a + b) / 2, known);
        if (sign * fb > 0) return isnan(known) ? b : known;
        b = (a + b) / 2;
    }
    ric_root r = ric_root_between(a, fa, b, fb, PLACE * fabs(b - a));
    while (ric_root_next(&r)) r.f = deflated(tr, q, test, r.x, known);
    return r.x;
}

void ric_event_bridge_station(const ric_continuation *tr, const ric_event_bridge *q, double x,
                              double h, ric_station *out)
{
    int size = tr->chain->n_unknown;
    double value[4], slope[4], norm = 0;
    lagrange(q->x, x, value, slope);
    for (int j = 0; j < size; j++) {
        out->u[j] = out->t[j] = 0;
        for (int i = 0; i < 4; i++) {
            out->u[j] += value[i] * q->u[i * size + j];
            out->t[j] += slope[i] * q->u[i * size + j];
        }
        norm += out->t[j] * out->t[j];
    }
    for (int j = 0; j < size; j++) out->t[j] /= sqrt(norm);
    out->s = tr->now.s + (tr->next.s - tr->now.s) * x / h;
    out->solved = false; /* until it has been looked at */
}
