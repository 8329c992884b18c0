/* Where the shaken masses end up from random starts: on curves that were computed, stable parts of them, or on motions
 * that are not periodic, which are counted. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "explored.h"
#include "sample.h"

enum { SETTLE = 700, MORE = 6, PERIODS = 16, MOST = 64 };

static const double two_pi = 6.283185307179586;
static const char
    *const study = "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
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
    static const double force[] = {1, 0}, zeta = 0.01;
    return (ric_shaking){.n_force = 2, .force = force, .n_ratio = 1, .ratios = &zeta, .restitution = e};
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
static void add_motion(const ric_model *model, const ric_response_curve *c, const ric_response_point *p, motions *all)
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
            assert_int_equal(ric_shaken_advance(s, first + k * two_pi / p->omega, &hit, &impact), RIC_OK);
        ric_shaken_state(s, &time, m->strobe[k], m->strobe[k] + 2);
    }
    ric_shaken_free(s);
}

static void add_side(const ric_atlas *atlas, double level, double e, double omega, double other, motions *all)
{
    char path[] = "/tmp/ricochet-response-XXXXXX";
    const int fd = mkstemp(path);
    ric_response_options o;
    ric_response *r = NULL;
    static const int harmonics[] = {1, 2, 3};
    assert_true(fd >= 0);
    close(fd);
    ric_response_defaults(&o);
    o.shaking = shaking_of(e);
    o.window[0] = fmin(omega, other);
    o.window[1] = fmax(omega, other);
    o.n_level = 1;
    o.levels = &level;
    o.n_harmonic = 3;
    o.harmonics = harmonics;
    if (ric_response_run(atlas, &o, path, NULL, NULL) || ric_response_read(path, &r)) fail_msg("%s", ric_detail());
    unlink(path);
    for (int id = 1; id <= ric_response_n_curve(r); id++) {
        ric_response_curve c;
        ric_response_point p;
        ric_response_curve_at(r, id, &c);
        for (int i = 0; i < c.n_point && !ric_response_point_at(r, id, i, &p); i++)
            if (fabs(p.omega / omega - 1) < 1e-12) add_motion(ric_response_model(r), &c, &p, all);
    }
    ric_response_free(r);
}

/* Its number of periods, 0: it is not periodic, -1: it cannot be followed; and its state at phase 0. */
static int settle(const ric_model *model, const ric_shaking *shaking, double omega, double level, unsigned *seed,
                  double *out)
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
            if (k > 0 && apart(strobe[k], strobe[0], 1) < 1e-7) found = k;
            else if (!turn(s, &begun, omega, 1)) found = -1;
        }
    }
    memcpy(out, strobe[0], sizeof strobe[0]);
    ric_shaken_free(s);
    return found;
}

/* Whether a state belongs to one of the motions, or to its mirror image half a period of the force later; *near: how
 * far the nearest is. */
static bool known(const motions *all, int periods, const double *at, double *near)
{
    *near = INFINITY;
    for (int i = 0; i < all->n; i++)
        for (int k = 0; k < all->m[i].periods; k++)
            if (all->m[i].periods == periods) *near = fmin(*near, apart(at, all->m[i].strobe[k], 1));
    return *near < 1e-5;
}

/* Mirror images: x -> -x at the opposite phase. Their strobes are those half a period later, turned round; so the image
 * of an attractor is flown instead. */
static void add_images(const ric_model *model, double omega, double level, double e, motions *all)
{
    const ric_shaking shaking = shaking_of(e);
    const int n = all->n;
    for (int i = 0; i < n && all->n < MOST; i++) {
        ric_shaken *s;
        motion *m = &all->m[all->n++];
        *m = all->m[i];
        assert_int_equal(ric_shaken_create(model, &shaking, omega, level, &s), RIC_OK);
        assert_int_equal(ric_shaken_start(s, all->m[i].strobe[0], all->m[i].strobe[0] + 2, 0), RIC_OK);
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

static void test_attractors(void **state)
{
    (void)state;
    static const struct {
        double level, omega, e;
    } cases[] = {{0.2, 1.2, 0.9}, {0.1, 1.2, 0.9}, {0.35, 1.3, 0.9}};
    const int starts = long_form() ? 500 : 6, n_case = long_form() ? 3 : 1;
    ric_atlas *atlas = explore_text(study);
    const ric_model *model = ric_atlas_model(atlas);
    for (int c = 0; c < n_case; c++) {
        const ric_shaking shaking = shaking_of(cases[c].e);
        motions *all = calloc(1, sizeof *all);
        unsigned seed = 7;
        int on_curve = 0, wild = 0, lost = 0;
        assert_non_null(all);
        add_side(atlas, cases[c].level, cases[c].e, cases[c].omega, 0.4, all);
        add_side(atlas, cases[c].level, cases[c].e, cases[c].omega, 3, all);
        add_images(model, cases[c].omega, cases[c].level, cases[c].e, all);
        for (int i = 0; i < starts; i++) {
            double at[4], near;
            const int periods = settle(model, &shaking, cases[c].omega, cases[c].level, &seed, at);
            if (periods < 0) lost++;
            else if (periods == 0) wild++;
            else if (known(all, periods, at, &near)) on_curve++;
            else
                print_message("level %g, omega %g: start %d: an attractor of %d periods is on no curve, the nearest is "
                              "%.3g away: %.10g %.10g %.10g %.10g\n",
                              cases[c].level, cases[c].omega, i, periods, near, at[0], at[1], at[2], at[3]);
        }
        print_message("level %g, omega %g: %d starts, %d on curves, %d not periodic, %d come to rest on a stop; %d "
                      "orbits there\n",
                      cases[c].level, cases[c].omega, starts, on_curve, wild, lost, all->n);
        assert_int_equal(on_curve + wild + lost, starts);
        free(all);
    }
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_attractors)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
