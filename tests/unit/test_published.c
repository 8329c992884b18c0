/* A forced oscillator before a rigid stop, beside numbers that others have published: I. Ghosh and D. J. W. Simpson,
 * The VIVID function for numerically continuing periodic orbits arising from grazing bifurcations of hybrid dynamical
 * systems, arXiv 2510.16218 (2025), from the data of their Fig. 4 (github.com/indrag49/VIVID, files
 * pp2_omega0.8_SNb.csv, PD.csv, PDb.csv). x'' + 0.04 x' + x = A cos(omega t), stop at x = 1, restitution 0.9; motions
 * of two periods of the force with one impact, which begin where the motion without impacts grazes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "responses.h"

#include "explored.h"

static const char *const study = "title: t\nmodel:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts:\n"
                                 "    - {normal: [1], clearance: 1, sides: upper, law: rigid}\n"
                                 "explore: {energy: [0, 10], frequency: [0.5, 3], impacts: 2, multiply: 1, depth: 1}\n";

/* `off`: what their criterion, a multiplier within 1e-5 of 1 or -1, leaves of the amplitude: its square at a fold. */
static const struct {
    ric_response_kind kind;
    double omega, amplitude, speed, off;
} published[] = {{RIC_RESPONSE_FOLD, 0.79900000000000004, 0.36283620197625438, 0.124086571337902, 1e-10},
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
    o.shaking = (ric_shaking){.n_force = 1, .force = &one, .n_ratio = 1, .ratios = &zeta, .restitution = 0.9};
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
            if (fabs(e.at.level - published[i].amplitude) >= fabs(amplitude - published[i].amplitude)) continue;
            amplitude = e.at.level;
            speed = fabs(e.at.state[1]) / 0.9; /* before the impact */
        }
        ric_response_free(r);
        if (!(fabs(amplitude - published[i].amplitude) < published[i].off))
            fail_msg("omega %.10g: amplitude %.15g, published %.15g", published[i].omega, amplitude,
                     published[i].amplitude);
        if (!(fabs(speed - published[i].speed) < 1e-4))
            fail_msg("omega %.10g: speed %.15g, published %.15g", published[i].omega, speed, published[i].speed);
    }
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_events)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
