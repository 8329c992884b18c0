/* A forced oscillator before a rigid stop, beside numbers that others have published: I. Ghosh and
 * D. J. W. Simpson, The VIVID function for numerically continuing periodic orbits arising from
 * grazing bifurcations of hybrid dynamical systems, arXiv 2510.16218 (2025), from the data of their
 * Fig. 4 (github.com/indrag49/VIVID, files pp2_omega0.8_SNb.csv, PD.csv, PDb.csv). x'' + 0.04 x' +
 * x = A cos(omega t), stop at x = 1, restitution 0.9; motions of two periods of the force with one
 * impact, which begin where the motion without impacts grazes.
 *
 * And beside a published formula: orbits with one impact in n periods of the force, without
 * damping, of C. Budd, F. Dux and A. Cliffe, The effect of frequency and clearance variations on
 * single-degree-of-freedom impact oscillators, J. Sound Vib. 184 (1995) 475-502, as F. Dux's
 * program has them (github.com/FelixDux/impact-oscillator, periodic.ex). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "responses.h"

#include "explored.h"

static const char *const study =
    "title: t\nmodel:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts:\n"
    "    - {normal: [1], clearance: 1, sides: upper, law: rigid}\n"
    "explore: {energy: [0, 10], frequency: [0.5, 3], impacts: 2, multiply: 1, depth: 1}\n";

static const char *const deep =
    "title: t\nmodel:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts:\n"
    "    - {normal: [1], clearance: 1, sides: upper, law: rigid}\n"
    "explore: {energy: [0, 100], frequency: [0.5, 3], impacts: 1, multiply: 1, depth: 1}\n";
static const double two_pi = 6.283185307179586;

/* `off`: what their criterion, a multiplier within 1e-5 of 1 or -1, leaves of the amplitude: its
 * square at a fold. */
static const struct {
    ric_response_kind kind;
    double omega, amplitude, speed, off;
} published[] =
    {{RIC_RESPONSE_FOLD, 0.79900000000000004, 0.36283620197625438, 0.124086571337902, 1e-10},
     {RIC_RESPONSE_FOLD, 0.79773799999999884, 0.3639352451056187, 0.30691079008790628, 1e-10},
     {RIC_RESPONSE_FOLD, 0.79645799999999756, 0.36427266133641317, 0.48576235258791312, 1e-10},
     {RIC_RESPONSE_FOLD, 0.79517799999999628, 0.36386017003773841, 0.655824852587926, 1e-10},
     {RIC_RESPONSE_FOLD, 0.793897999999995, 0.36274415197815912, 0.81524672758793915, 1e-10},
     {RIC_RESPONSE_FOLD, 0.79133799999999244, 0.35863762861859533, 1.0969186025879609, 1e-10},
     {RIC_RESPONSE_FOLD, 0.78877799999998988, 0.3524851831425872, 1.3246373525879838, 1e-10},
     {RIC_RESPONSE_DOUBLING, 0.80109000000000108, 0.35971818306783282, 0.0079483669574728008, 1e-9},
     {RIC_RESPONSE_DOUBLING, 0.81000000000000005, 0.34753339889455342, 0.065303988295362006, 1e-8},
     {RIC_RESPONSE_DOUBLING, 0.83990999999999671, 0.3258950696317931, 0.26728714259220182, 1e-6},
     {RIC_RESPONSE_DOUBLING, 0.89990999999999011, 0.35410869513606769, 0.74631058009192908, 1e-6},
     {RIC_RESPONSE_DOUBLING, 0.9299099999999868, 0.40353289937745368, 1.0518945644669537, 1e-5},
     {RIC_RESPONSE_DOUBLING, 0.98990999999998019, 0.36705573921619861, 1.147429720718272, 1e-5}};

/* Along the amplitude at one frequency. */
static ric_response *along(const ric_atlas *atlas, double omega)
{
    static const double one = 1, zeta = 0.02;
    ric_response_options o;
    ric_response_defaults(&o);
    o.along = RIC_RESPONSE_LEVEL;
    o.shaking = (ric_shaking){.n_force = 1,
                              .force = &one,
                              .n_ratio = 1,
                              .ratios = &zeta,
                              .restitution = 0.9};
    o.window[0] = 0.02;
    o.window[1] = 0.6;
    o.omega = omega;
    o.impacts = o.periods = o.once_in = 2;
    ric_response *r = response_of(atlas, &o);
    return r;
}

static void test_events(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(study);
    for (size_t i = 0; i < sizeof published / sizeof *published; i++) {
        ric_response *r = along(atlas, published[i].omega);
        double amplitude = INFINITY, speed = INFINITY;
        for (int id = 1; id <= ric_response_n_event(r); id++) {
            ric_response_event e;
            ric_response_curve c;
            assert_int_equal(ric_response_event_at(r, id, &e), RIC_OK);
            assert_int_equal(ric_response_curve_at(r, e.curve, &c), RIC_OK);
            if (e.kind != published[i].kind || c.harmonic != 2 || c.impacts != 1) continue;
            if (fabs(e.at.level - published[i].amplitude) >=
                fabs(amplitude - published[i].amplitude))
                continue;
            amplitude = e.at.level;
            speed = fabs(e.at.state[1]) / 0.9; /* before the impact */
        }
        ric_response_free(r);
        if (!(fabs(amplitude - published[i].amplitude) < published[i].off))
            fail_msg("omega %.10g: amplitude %.15g, published %.15g", published[i].omega, amplitude,
                     published[i].amplitude);
        if (!(fabs(speed - published[i].speed) < 1e-4))
            fail_msg("omega %.10g: speed %.15g, published %.15g", published[i].omega, speed,
                     published[i].speed);
    }
    ric_atlas_free(atlas);
}

/* x'' + x = cos(omega t), stop at sigma: with g = 1 / (1 - omega^2), T = 2 pi n / omega and c = sin
 * T (1 + r) / (1 - cos T) the speed V of the impact lies on the ellipse (sigma + c V / 2)^2 + ((1 -
 * r) V / (2 omega))^2 = g^2, and two orbits meet at the largest sigma, |g| sqrt(1 + (c omega / (1 -
 * r))^2). Here the stop is at 1 and the amplitude 1 / sigma. */
static void test_one_impact(void **state)
{
    (void)state;
    static const struct {
        double omega, r;
        int n;
    } cases[] = {{3.7, 0.8, 2}, {3, 0.9, 2}, {1.8, 0.8, 1}, {5.5, 0.7, 3}};
    static const double one = 1;
    ric_atlas *atlas = explore_text(deep);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const double omega = cases[i].omega, T = two_pi * cases[i].n / omega,
                     lost = (1 - cases[i].r) / omega, c = sin(T) * (1 + cases[i].r) / (1 - cos(T)),
                     g = 1 / (1 - omega * omega), sigma = fabs(g) * sqrt(1 + c * c / (lost * lost)),
                     V = -2 * c * sigma / (c * c + lost * lost);
        ric_response_options o;
        double level = 0, speed = 0;
        ric_response_defaults(&o);
        o.along = RIC_RESPONSE_LEVEL;
        o.shaking = (ric_shaking){.n_force = 1, .force = &one, .restitution = cases[i].r};
        o.window[0] = 0.02;
        o.window[1] = 3 / sigma;
        o.omega = omega;
        o.n_harmonic = 1;
        o.harmonics = &cases[i].n;
        o.impacts = 1;
        o.periods = cases[i].n;
        ric_response *r = response_of(atlas, &o);
        int folds = 0;
        for (int id = 1; id <= ric_response_n_event(r); id++) {
            ric_response_event e;
            assert_int_equal(ric_response_event_at(r, id, &e), RIC_OK);
            if (e.kind != RIC_RESPONSE_FOLD) continue;
            folds++;
            level = e.at.level;
            speed = fabs(e.at.state[1]) / cases[i].r / level; /* before the impact */
        }
        ric_response_free(r);
        assert_int_equal(folds, 1);
        if (!(fabs(level * sigma - 1) < 1e-12))
            fail_msg("omega %g: fold at %.16g, published formula %.16g", omega, level, 1 / sigma);
        if (!(fabs(speed / V - 1) < 1e-6))
            fail_msg("omega %g: speed %.16g, formula %.16g", omega, speed, V);
    }
    ric_atlas_free(atlas);
}

/* The amplitude at the fold of motions with one impact in two periods, as above with damping 2
 * delta: out of P (1 - F, -r V - G) = (1 - F, V - G) for the flight P over both, F and G are linear
 * in V, and F^2 + (G / omega)^2 is the square of the linear answer. */
static double fold_amplitude(double omega)
{
    const double r = 0.9, delta = 0.02, root = sqrt(1 - delta * delta), T = 2 * two_pi / omega,
                 d = exp(-delta * T), cosine = d * cos(root * T), sine = d * sin(root * T) / root;
    const double P[4] = {cosine + delta * sine, sine, -sine, cosine - delta * sine};
    const double m[4] = {P[0] - 1, P[1], P[2], P[3] - 1}, det = m[0] * m[3] - m[1] * m[2],
                 by[2] = {-r * P[1], -r * P[3] - 1};
    const double f = (m[3] * by[0] - m[1] * by[1]) / det,
                 g = (m[0] * by[1] - m[2] * by[0]) / det / omega;
    return sqrt(1 - f * f / (f * f + g * g)) * hypot(1 - omega * omega, 2 * delta * omega);
}

static double fold_between(double amplitude, double a, double b)
{
    for (int k = 0; k < 100; k++) {
        const double c = (a + b) / 2;
        if ((fold_amplitude(a) > amplitude) == (fold_amplitude(c) > amplitude)) a = c;
        else b = c;
    }
    return a;
}

/* The oscillator of the numbers above has an isola of such motions, beside twice the frequencies of
 * its free ones: one closed curve, whose two folds the closed form gives. */
static void test_isola(void **state)
{
    (void)state;
    static const double one = 1, zeta = 0.02, levels[] = {0.5, 1};
    static const int two = 2;
    ric_atlas *atlas = explore_text(deep);
    for (size_t i = 0; i < sizeof published / sizeof *published; i++)
        if (published[i].kind == RIC_RESPONSE_FOLD)
            assert_true(fabs(fold_amplitude(published[i].omega) - published[i].amplitude) <
                        published[i].off);
    ric_response_options o;
    ric_response_defaults(&o);
    o.shaking = (ric_shaking){.n_force = 1,
                              .force = &one,
                              .n_ratio = 1,
                              .ratios = &zeta,
                              .restitution = 0.9};
    o.window[0] = 1.8;
    o.window[1] = 4.2;
    o.n_level = 2;
    o.levels = levels;
    o.n_harmonic = 1;
    o.harmonics = &two;
    o.impacts = o.periods = 2;
    ric_response *r = response_of(atlas, &o);
    int closed = 0, folds = 0;
    for (int id = 1; id <= ric_response_n_curve(r); id++) {
        ric_response_curve c;
        assert_int_equal(ric_response_curve_at(r, id, &c), RIC_OK);
        closed += c.impacts == 1 && c.harmonic == 2 && c.end == RIC_RESPONSE_CLOSED;
    }
    for (int id = 1; id <= ric_response_n_event(r); id++) {
        ric_response_event e;
        assert_int_equal(ric_response_event_at(r, id, &e), RIC_OK);
        if (e.kind != RIC_RESPONSE_FOLD) continue;
        const bool upper = e.at.omega > 2.4;
        const double wanted = fold_between(e.at.level, upper ? 2.5 : 2.01, upper ? 3.9 : 2.3);
        if (!(fabs(e.at.omega / wanted - 1) < 1e-10))
            fail_msg("level %g: fold at %.15g, closed form %.15g", e.at.level, e.at.omega, wanted);
        folds++;
    }
    assert_int_equal(closed, 2);
    assert_int_equal(folds, 4);
    ric_response_free(r);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_events),
                                       cmocka_unit_test(test_one_impact),
                                       cmocka_unit_test(test_isola)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
