/* Where the shaken masses end up from random starts: on curves that were computed, stable parts of
 * them, or on motions that are not periodic, which are counted; below the birth of a detached
 * resonance, where it is an isola, and above the level at which it joins. RICOCHET_ATTRACTORS names
 * a file in which each start is written down, and is not taken again (tools/attractors). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "responses.h"

#include "explored.h"
#include "sample.h"

enum { SETTLE = 700, MORE = 12, PERIODS = 16, MOST = 64, STARTS = 125, PARTING = 400, BLOCKS = 20 };

#define RESTITUTION 0.9
#define CHAOTIC 4 /* errors of the mean: a parting that stands clear of 0 */
#define SAME 1e-5 /* states of one motion that has settled to 1e-7 */

static const double two_pi = 6.283185307179586;
static const char *const study =
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {energy: [0, 60], frequency: [0.3, 4], impacts: 4, multiply: 2, depth: 2}\n";

/* A motion at one frequency: its states at phase 0, period by period. */
typedef struct {
    int periods;
    ric_stability stable;
    double strobe[PERIODS][4];
} motion;

typedef struct {
    int n;
    motion m[MOST];
} motions;

static ric_shaking shaking_of(double e)
{
    static const double force[] = {1, -0.1}, zeta = 0.01;
    return (
        ric_shaking){.n_force = 2, .force = force, .n_ratio = 1, .ratios = &zeta, .restitution = e};
}

/* Through whole periods of the force; false: it cannot be followed. */
static bool turn(ric_shaken *s, double *begun, double omega, int periods)
{
    const double end = *begun + periods * two_pi / omega;
    bool hit = true;
    ric_impact impact;
    while (hit)
        if (ric_shaken_advance(s, end, &hit, &impact)) return false;
    *begun = end;
    return true;
}

static double apart(const double *a, const double *b, double sign)
{
    double most = 0;
    for (int i = 0; i < 4; i++) most = fmax(most, fabs(a[i] - sign * b[i]));
    return most;
}

/* The orbit of a point of a response, flown from phase 0 on. */
static void add_motion(const ric_model *model, const ric_response_curve *c,
                       const ric_response_point *p, motions *all)
{
    const ric_shaking shaking = shaking_of(p->restitution);
    ric_shaken *s;
    const double first = fmod(2 * two_pi - fmod(p->phase, two_pi), two_pi) / p->omega;
    double time;
    bool hit = true;
    ric_impact impact;
    if (all->n == MOST || c->harmonic > PERIODS) return;
    motion *m = &all->m[all->n++];
    *m = (motion){.periods = c->harmonic, .stable = p->stable};
    assert_int_equal(ric_shaken_create(model, &shaking, p->omega, p->level, &s), RIC_OK);
    assert_int_equal(ric_shaken_start(s, p->state, p->state + 2, p->phase), RIC_OK);
    for (int k = 0; k < c->harmonic; k++) {
        for (hit = true; hit;)
            assert_int_equal(ric_shaken_advance(s, first + k * two_pi / p->omega, &hit, &impact),
                             RIC_OK);
        ric_shaken_state(s, &time, m->strobe[k], m->strobe[k] + 2);
    }
    ric_shaken_free(s);
}

static void add_side(const ric_atlas *atlas, double level, double e, double omega, double other,
                     motions *all)
{
    ric_response_options o;
    static const int harmonics[] = {1, 2, 3};
    ric_response_defaults(&o);
    o.shaking = shaking_of(e);
    o.window[0] = fmin(omega, other);
    o.window[1] = fmax(omega, other);
    o.n_level = 1;
    o.levels = &level;
    o.n_harmonic = 3;
    o.harmonics = harmonics;
    ric_response *r = response_of(atlas, &o);
    for (int id = 1; id <= ric_response_n_curve(r); id++) {
        ric_response_curve c;
        ric_response_point p;
        ric_response_curve_at(r, id, &c);
        for (int i = 0; i < c.n_point && !ric_response_point_at(r, id, i, &p); i++)
            if (fabs(p.omega / omega - 1) < 1e-12) add_motion(ric_response_model(r), &c, &p, all);
    }
    ric_response_free(r);
}

/* Its number of periods, 0: it is not periodic, -1: it cannot be followed; and its state at phase
 * 0. What is left of a slow mode may repeat nearly after more periods than the motion has: the
 * first of them that is near counts. */
static int settle(const ric_model *model, const ric_shaking *shaking, double omega, double level,
                  unsigned *seed, double *out)
{
    ric_shaken *s;
    double x[2], v[2], strobe[PERIODS + 1][4], begun = 0;
    int found = 0;
    for (int i = 0; i < 2; i++) {
        x[i] = 0.45 * (2.0 * (rand_r(seed) / (double)RAND_MAX) - 1);
        v[i] = 3 * (2.0 * (rand_r(seed) / (double)RAND_MAX) - 1);
    }
    assert_int_equal(ric_shaken_create(model, shaking, omega, level, &s), RIC_OK);
    assert_int_equal(ric_shaken_start(s, x, v, 0), RIC_OK);
    for (int more = 0; more < MORE && found == 0; more++) {
        if (!turn(s, &begun, omega, SETTLE)) found = -1;
        for (int k = 0; k <= PERIODS && found == 0; k++) {
            double time;
            ric_shaken_state(s, &time, strobe[k], strobe[k] + 2);
            if (k > 0 && apart(strobe[k], strobe[0], 1) < 1e-7)
                for (found = 1; apart(strobe[found], strobe[0], 1) > SAME;) found++;
            else if (!turn(s, &begun, omega, 1)) found = -1;
        }
    }
    memcpy(out, strobe[0], sizeof strobe[0]);
    ric_shaken_free(s);
    return found;
}

/* How fast a motion and a neighbour part, per period of the force, and the error of that mean. */
typedef struct {
    double rate, error;
} speed;

/* On the average over many periods: above 0 it is chaotic, about 0 it has several frequencies,
 * below 0 it is periodic. The error is that of the mean of blocks, which are longer than what a
 * period remembers. 0 and infinity where it cannot be followed. */
static speed parting(const ric_model *model, const ric_shaking *shaking, double omega, double level,
                     const double *at)
{
    const double aside = 1e-8;
    const speed lost = {0, INFINITY};
    double own[4], other[4], block[BLOCKS] = {0}, sum = 0, squares = 0, time;
    memcpy(own, at, sizeof own);
    memcpy(other, at, sizeof other);
    other[0] += aside;
    for (int k = 0; k < PARTING; k++) {
        double *const both[] = {own, other};
        double apart = 0;
        for (int i = 0; i < 2; i++) {
            ric_shaken *s;
            double begun = 0;
            assert_int_equal(ric_shaken_create(model, shaking, omega, level, &s), RIC_OK);
            bool good = !ric_shaken_start(s, both[i], both[i] + 2, 0) && turn(s, &begun, omega, 1);
            if (good) ric_shaken_state(s, &time, both[i], both[i] + 2);
            ric_shaken_free(s);
            if (!good) return lost;
        }
        for (int i = 0; i < 4; i++) apart += (other[i] - own[i]) * (other[i] - own[i]);
        apart = sqrt(apart) / aside;
        if (!(apart > 0)) return lost;
        block[k * BLOCKS / PARTING] += log(apart) * BLOCKS / PARTING;
        for (int i = 0; i < 4; i++) other[i] = own[i] + (other[i] - own[i]) / apart;
    }
    for (int i = 0; i < BLOCKS; i++) sum += block[i] / BLOCKS;
    for (int i = 0; i < BLOCKS; i++) squares += (block[i] - sum) * (block[i] - sum);
    return (speed){sum, sqrt(squares / (BLOCKS - 1) / BLOCKS)};
}

/* Whether a state belongs to one of the motions, or to its mirror image half a period of the force
 * later; *near: how far the nearest is. */
static bool known(const motions *all, int periods, const double *at, double *near)
{
    *near = INFINITY;
    for (int i = 0; i < all->n; i++)
        for (int k = 0; k < all->m[i].periods; k++)
            if (all->m[i].periods == periods)
                *near = fmin(*near, apart(at, all->m[i].strobe[k], 1));
    return *near < SAME;
}

/* Mirror images: x -> -x at the opposite phase. Their strobes are those half a period later, turned
 * round; so the image of an attractor is flown instead. */
static void add_images(const ric_model *model, double omega, double level, double e, motions *all)
{
    const ric_shaking shaking = shaking_of(e);
    const int n = all->n;
    for (int i = 0; i < n && all->n < MOST; i++) {
        ric_shaken *s;
        motion *m = &all->m[all->n++];
        *m = all->m[i];
        assert_int_equal(ric_shaken_create(model, &shaking, omega, level, &s), RIC_OK);
        assert_int_equal(ric_shaken_start(s, all->m[i].strobe[0], all->m[i].strobe[0] + 2, 0),
                         RIC_OK);
        double time, begun = 0;
        bool followed = true;
        for (int k = 0; k < m->periods && followed; k++) {
            const double end = (k + 0.5) * two_pi / omega;
            bool hit = true;
            ric_impact impact;
            while (hit && followed) followed = !ric_shaken_advance(s, end, &hit, &impact);
            begun = end;
            ric_shaken_state(s, &time, m->strobe[k], m->strobe[k] + 2);
            for (int j = 0; j < 4; j++) m->strobe[k][j] = -m->strobe[k][j];
        }
        (void)begun;
        ric_shaken_free(s);
    }
}

/* ------------------------------------------------------------------- starts */

typedef enum { ON_CURVE, WILD, LOST, UNKNOWN, OUTCOMES } outcome;
static const char *const outcome_text[] = {"curve", "not-periodic", "rests", "unknown"};

/* One level and frequency. */
typedef struct {
    double level, omega;
    int starts, count[OUTCOMES], chaotic;
    int measured;                   /* of those that are not periodic, in this run */
    double slowest, fastest, error; /* their parting, and its largest error */
    motions *all;
} place;

/* Outcomes of an earlier run: those starts are done. */
static void read_log(const char *path, place *p, bool *done)
{
    FILE *file = path ? fopen(path, "r") : NULL;
    double level, omega;
    int start;
    char word[32];
    while (file && fscanf(file, "%lf %lf %d %31s", &level, &omega, &start, word) == 4)
        for (int i = 0; i < OUTCOMES; i++) {
            if (level != p->level || omega != p->omega || start < 0 || start >= p->starts ||
                done[start])
                continue;
            if (strcmp(word, outcome_text[i]) != 0) continue;
            p->count[i]++;
            done[start] = true;
        }
    if (file) fclose(file);
}

static void write_log(const char *path, const place *p, int start, outcome what)
{
    FILE *file = path ? fopen(path, "a") : NULL;
    if (!file) return;
    fprintf(file, "%.17g %.17g %d %s\n", p->level, p->omega, start, outcome_text[what]);
    fclose(file);
}

static outcome one_start(const ric_model *model, place *p, int start)
{
    const ric_shaking shaking = shaking_of(RESTITUTION);
    unsigned seed = 7 + 1000 * (unsigned)start;
    double at[4], near;
    const int periods = settle(model, &shaking, p->omega, p->level, &seed, at);
    if (periods < 0) return LOST;
    if (periods == 0) {
        const speed now = parting(model, &shaking, p->omega, p->level, at);
        p->chaotic += now.rate > CHAOTIC * now.error;
        p->slowest = fmin(p->slowest, now.rate);
        p->fastest = fmax(p->fastest, now.rate);
        p->error = fmax(p->error, now.error);
        return WILD;
    }
    if (known(p->all, periods, at, &near)) return ON_CURVE;
    print_message("level %g, omega %g: start %d: an attractor of %d periods is on no curve, the "
                  "nearest is %.3g away: "
                  "%.10g %.10g %.10g %.10g\n",
                  p->level, p->omega, start, periods, near, at[0], at[1], at[2], at[3]);
    return UNKNOWN;
}

static void all_starts(const ric_atlas *atlas, place *p)
{
    const ric_model *model = ric_atlas_model(atlas);
    const char *path = getenv("RICOCHET_ATTRACTORS");
    bool done[STARTS] = {false};
    read_log(path, p, done);
    if (p->count[ON_CURVE] + p->count[WILD] + p->count[LOST] == p->starts)
        return; /* of an earlier run, which said so */
    assert_non_null(p->all = calloc(1, sizeof *p->all));
    add_side(atlas, p->level, RESTITUTION, p->omega, 0.4, p->all);
    add_side(atlas, p->level, RESTITUTION, p->omega, 3, p->all);
    add_images(model, p->omega, p->level, RESTITUTION, p->all);
    for (int i = 0; i < p->starts; i++) {
        if (done[i]) continue;
        const outcome what = one_start(model, p, i);
        p->count[what]++;
        p->measured += what == WILD;
        write_log(path, p, i, what);
    }
    print_message("level %g, omega %g: %d starts, %d on curves, %d not periodic, %d at rest on a "
                  "stop, %d unknown; %d "
                  "orbits there\n",
                  p->level, p->omega, p->starts, p->count[ON_CURVE], p->count[WILD], p->count[LOST],
                  p->count[UNKNOWN], p->all->n);
    if (p->fastest > -INFINITY)
        print_message("%d of %d that are not periodic are chaotic: neighbours part by %.3g to %.3g "
                      "a period, +- %.2g\n",
                      p->chaotic, p->measured, p->slowest, p->fastest, p->error);
    free(p->all);
    assert_int_equal(p->count[UNKNOWN], 0);
    assert_true(p->measured - p->chaotic <= p->starts / 100); /* those that were just settling */
}

static void test_attractors(void **state)
{
    (void)state;
    static const double levels[] = {0.4, 0.25, 0.6}, omegas[] = {1.2, 1.0, 1.35, 1.1, 2.3};
    ric_atlas *atlas = explore_text(study);
    for (int i = 0; i < (long_form() ? 3 : 1); i++)
        for (int j = 0; j < (long_form() ? 5 : 1); j++) {
            place p = {.level = levels[i],
                       .omega = omegas[j],
                       .starts = long_form() ? STARTS : 6,
                       .slowest = INFINITY,
                       .fastest = -INFINITY};
            all_starts(atlas, &p);
        }
    ric_atlas_free(atlas);
}

/* A stable periodic motion takes its neighbours in as its largest multiplier says; what random
 * starts come to beside the second mode parts from them. */
static void test_parting(void **state)
{
    (void)state;
    const ric_shaking shaking = shaking_of(RESTITUTION);
    ric_atlas *atlas = explore_text(study);
    const ric_model *model = ric_atlas_model(atlas);
    double x[2] = {0.1, 0.2}, v[2] = {0}, at[4], begun = 0, time;
    ric_shaken *s;
    /* without impacts: the multipliers are those of the damped modes, of which the slower one
     * decays last */
    const double omega = 1.2, slow = -0.01 * 0.928731065046 * two_pi / omega;
    assert_int_equal(ric_shaken_create(model, &shaking, omega, 0.05, &s), RIC_OK);
    assert_int_equal(ric_shaken_start(s, x, v, 0), RIC_OK);
    assert_true(turn(s, &begun, omega, 300));
    ric_shaken_state(s, &time, at, at + 2);
    ric_shaken_free(s);
    const speed calm = parting(model, &shaking, omega, 0.05, at);
    print_message("without impacts %.6f +- %.1g a period, multipliers say %.6f\n", calm.rate,
                  calm.error, slow);
    assert_true(fabs(calm.rate - slow) < 0.1 * fabs(slow));
    for (int start = 0; start < (long_form() ? 10 : 2); start++) {
        unsigned seed = 7 + 1000 * (unsigned)start;
        for (int i = 0; i < 2; i++) {
            x[i] = 0.45 * (2.0 * (rand_r(&seed) / (double)RAND_MAX) - 1);
            v[i] = 3 * (2.0 * (rand_r(&seed) / (double)RAND_MAX) - 1);
        }
        begun = 0;
        assert_int_equal(ric_shaken_create(model, &shaking, 2.3, 0.6, &s), RIC_OK);
        assert_int_equal(ric_shaken_start(s, x, v, 0), RIC_OK);
        assert_true(turn(s, &begun, 2.3, SETTLE));
        ric_shaken_state(s, &time, at, at + 2);
        ric_shaken_free(s);
        const speed wild = parting(model, &shaking, 2.3, 0.6, at);
        print_message("start %d beside the second mode: %.3f +- %.3f a period\n", start, wild.rate,
                      wild.error);
        assert_true(wild.rate > CHAOTIC * wild.error && wild.rate > 0.15 && wild.rate < 0.4);
    }
    ric_atlas_free(atlas);
}

/* -------------------------------------------------------------------- isola */

/* Curves of one impact on either side in a period of the force, around 1.2 rad/s: how many, how
 * many of them closed, and how many begin or end at a grazing. */
static void around(const ric_atlas *atlas, double level, int *curves, int *closed, int *grazing,
                   double window[2])
{
    ric_response_options o;
    ric_response_defaults(&o);
    o.shaking = shaking_of(RESTITUTION);
    o.window[0] = 0.5;
    o.window[1] = 1.7;
    o.n_level = 1;
    o.levels = &level;
    o.impacts = 2;
    o.periods = 1;
    ric_response *r = response_of(atlas, &o);
    *curves = *closed = *grazing = 0;
    for (int id = 1; id <= ric_response_n_curve(r); id++) {
        ric_response_curve c;
        ric_response_point p;
        double from = INFINITY, to = 0;
        ric_response_curve_at(r, id, &c);
        for (int i = 0; i < c.n_point && !ric_response_point_at(r, id, i, &p); i++) {
            from = fmin(from, p.omega);
            to = fmax(to, p.omega);
        }
        if (c.letters != 2 || from > 1.2 || to < 1.2) continue;
        ++*curves;
        *closed += c.end == RIC_RESPONSE_CLOSED;
        *grazing += c.begin == RIC_RESPONSE_GRAZES || c.end == RIC_RESPONSE_GRAZES;
        window[0] = from;
        window[1] = to;
    }
    ric_response_free(r);
}

/* Below the birth that is predicted for S2+, between it and the join at the grazing of mode 1, and
 * above. */
static void test_isola(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(study);
    int curves, closed, grazing;
    double window[2];
    around(atlas, 0.25, &curves, &closed, &grazing, window);
    assert_int_equal(curves, 0);
    around(atlas, 0.4, &curves, &closed, &grazing, window);
    assert_true(curves == 1 && closed == 1);
    assert_true(window[0] < 0.976 && window[0] > 0.974 && window[1] > 1.403 && window[1] < 1.405);
    around(atlas, 0.6, &curves, &closed, &grazing, window);
    assert_true(curves == 1 && closed == 0 && grazing == 1);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_isola),
                                       cmocka_unit_test(test_attractors),
                                       cmocka_unit_test(test_parting)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
