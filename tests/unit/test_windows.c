/* Windows that the program chooses: what they hold, on the article's study, in other units and on
 * random models; and energies given in first touches. */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/options.h"
#include "random_models.h"
#include "ricochet.h"
#include "study/study.h"
#include "study/windows.h"

static ric_study *parse(const char *model, const char *rest)
{
    char text[2000];
    ric_study *study = NULL;
    snprintf(text, sizeof text, "model:\n%s%s", model, rest);
    if (ric_study_parse(text, "text", ".", &study)) print_error("%s\n%s\n", text, ric_detail());
    assert_non_null(study);
    return study;
}

static const char two_masses[] = "  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
                                 "  contacts: [{normal: [-1, 1], clearance: 1}]\n";

/* Wide enough for G1_2,4 of the article, at energy 80.97, and for its elementary structure. */
static void the_article_is_in_the_window(void **state)
{
    (void)state;
    ric_study *study = parse(two_masses, "");
    const ric_explore_options *o = ric_study_options(study);
    assert_true(ric_study_window_chosen(study, false) && ric_study_window_chosen(study, true));
    assert_true(o->energy[0] == 0 && o->energy[1] > 100 && o->energy[1] < 1000);
    assert_true(o->frequency[0] < 0.2 && o->frequency[1] > 10);
    ric_study_free(study);
}

/* Mass and stiffness times a factor do not change the motion: energies go with it. Frequencies go
 * with the square root of stiffness. Rounding to two digits is all that differs. */
static void windows_follow_the_units(void **state)
{
    (void)state;
    for (int e = -9; e <= 9; e += 3) {
        char model[300];
        double factor = pow(10, e);
        snprintf(model, sizeof model,
                 "  mass: [[2, 0], [0, 1]]\n  stiffness: [[%.17g, %.17g], [%.17g, %.17g]]\n"
                 "  contacts: [{normal: [-1, 1], clearance: 0.003}]\n",
                 9 * factor, -factor, -factor, factor);
        ric_study *one = parse(two_masses, ""), *other = parse(model, "");
        const ric_explore_options *a = ric_study_options(one), *b = ric_study_options(other);
        for (int i = 0; i < 2; i++) {
            assert_true(fabs(b->energy[i] - factor * a->energy[i]) <= 0.11 * factor * a->energy[i]);
            assert_true(fabs(b->frequency[i] - sqrt(factor) * a->frequency[i]) <=
                        0.2 * sqrt(factor) * a->frequency[i]);
        }
        ric_study_free(one);
        ric_study_free(other);
    }
}

static void what_is_given_stays(void **state)
{
    (void)state;
    ric_study *study = parse(two_masses, "explore: {energy: [0.1, 7], frequency: auto}\n"),
              *again = NULL;
    const ric_explore_options *o = ric_study_options(study);
    assert_true(o->energy[0] == 0.1 && o->energy[1] == 7);
    assert_true(!ric_study_window_chosen(study, false) && ric_study_window_chosen(study, true));
    /* the text of the study has the numbers */
    assert_int_equal(ric_study_parse(ric_study_text(study), "again", ".", &again), RIC_OK);
    assert_memory_equal(ric_study_options(again), o, sizeof *o);
    assert_false(ric_study_window_chosen(again, true));
    ric_study_free(again);
    ric_study_free(study);
}

static void energies_in_first_touches(void **state)
{
    double touch[2];
    int contact[2];
    (void)state;
    ric_study *study = parse(two_masses,
                             "explore:\n  energy: {first_touch_of: 2, times: [0.5, 10]}\n"
                             "  at_energy: {first_touch_of: 1, times: [3, 2]}\n"
                             "regions:\n  - {energy: {first_touch_of: 1, times: [1, 2]}, "
                             "frequency: [1, 2], depth: 6}\n");
    const ric_explore_options *o = ric_study_options(study);
    assert_int_equal(ric_model_grazing_energies(ric_study_model(study), touch, contact), RIC_OK);
    assert_true(o->energy[0] == 0.5 * touch[1] && o->energy[1] == 10 * touch[1]);
    assert_true(o->at_energy.n == 2 && o->at_energy.value[0] == 2 * touch[0] &&
                o->at_energy.value[1] == 3 * touch[0]);
    assert_true(o->region[0].energy[1] == 2 * touch[0]);
    assert_false(ric_study_window_chosen(study, false));
    ric_study_free(study);
}

static void refused(const char *model, const char *rest, const char *says)
{
    char text[1000];
    ric_study *study = NULL;
    snprintf(text, sizeof text, "model:\n%s%s", model, rest);
    assert_int_equal(ric_study_parse(text, "text", ".", &study), RIC_E_INPUT);
    if (!strstr(ric_detail(), says)) print_error("no '%s' in '%s'\n", says, ric_detail());
    assert_non_null(strstr(ric_detail(), says));
}

static void bad_multiples(void **state)
{
    static const char *const rest[][2] = {
        {"explore: {energy: {times: [0, 1]}}\n", "explore.energy.first_touch_of: missing"},
        {"explore: {energy: {first_touch_of: 1}}\n", "explore.energy.times: missing"},
        {"explore: {energy: {first_touch_of: 1, times: auto}}\n",
         "explore.energy.times: expected a list"},
        {"explore: {energy: {first_touch_of: 1, times: [2, 1]}}\n",
         "explore.energy.times: the window [2, 1] is"},
        {"explore: {energy: {first_touch_of: 3, times: [0, 1]}}\n",
         "there is no mode 3; the structure has modes 1 to"},
        {"explore: {energy: {first_touch_of: 1.5, times: [0, 1]}}\n", "1.5 is no mode"},
        {"explore: {energy: {first_touch_of: 1, times: [0, 1.0e+18]}}\n", "are taken"},
        {"explore: {frequency: {first_touch_of: 1, times: [0, 1]}}\n",
         "explore.frequency: expected a value"},
        {"regions: [{energy: auto, frequency: [1, 2]}]\n", "regions[1].energy: 'auto'"},
        {"regions: [{energy: [1, 2], frequency: auto}]\n", "regions[1].frequency: 'auto'"},
        {"explore: {energy: automatic}\n", "or auto"},
    };
    static const char stiff[] =
        "  mass: [[2, 0], [0, 1]]\n  stiffness: [[9e3, -1e3], [-1e3, 1e3]]\n"
        "  contacts: [{normal: [-1, 1], clearance: 1}]\n";
    (void)state;
    for (size_t i = 0; i < sizeof rest / sizeof *rest; i++) refused(stiff, rest[i][0], rest[i][1]);
    refused("  mass: [[1, 0], [0, 1]]\n  stiffness: [[1, 0], [0, 2]]\n  contacts: [{normal: [1, "
            "0], clearance: 1}]\n",
            "explore: {energy: {first_touch_of: 2, times: [0, 1]}}\n", "mode 2 never touches");
    refused("  mass: [[1.0e-20]]\n  stiffness: [[1.0e+20]]\n  contacts: [{normal: [1], clearance: "
            "1}]\n",
            "", "choose other units");
}

/* Under a power law energy 1 is where the force of the spring is that of the structure: one mass k
 * x against k_c x^3 at x = sqrt(k / k_c), energy k^2 / (2 k_c) of the linear motion; the same from
 * a length and a reference. */
static void onset_under_a_power_law(void **state)
{
    int mode;
    (void)state;
    ric_study *study = parse("  mass: [[2]]\n  stiffness: [[3]]\n"
                             "  contacts: [{law: power, normal: [1], exponent: 3, stiffness: 5}]\n",
                             "");
    assert_true(fabs(ric_model_onset(ric_study_model(study), &mode) - 9 / 10.0) < 1e-14 &&
                mode == 1);
    ric_study_free(study);
    study = parse(
        "  mass: [[2]]\n  stiffness: [[3]]\n"
        "  contacts: [{law: power, normal: [1], exponent: 3, length: 0.5, reference: 1.25}]\n",
        "");
    assert_true(fabs(ric_model_onset(ric_study_model(study), &mode) - 9 / 10.0 / 0.25) < 1e-14);
    assert_true(ric_study_options(study)->energy[1] > 100);
    ric_study_free(study);
}

static void loose_masses(void **state)
{
    int mode;
    (void)state;
    ric_study *study = parse("  mass: [[1, 0], [0, 0.3]]\n  stiffness: [[5.0e4, 0], [0, 0]]\n"
                             "  contacts: [{normal: [1, -1], clearance: 1.0e-3}]\n",
                             "");
    const ric_explore_options *o = ric_study_options(study);
    assert_true(o->energy[0] > 0 && o->energy[0] < 25000 && o->energy[1] > 25000);
    assert_true(o->frequency[0] > 10 && o->frequency[0] < 223 && o->frequency[1] > 223);
    ric_study_free(study);
    /* an energy window that is given below all touches is the loose mass's own: 2 pi / 4 sqrt(2 E
     * c.c) */
    study = parse("  mass: [[1, 0], [0, 0.3]]\n  stiffness: [[5.0e4, 0], [0, 0]]\n"
                  "  contacts: [{normal: [1, -1], clearance: 1.0e-3}]\n",
                  "explore: {energy: [0.1, 10]}\n");
    o = ric_study_options(study);
    assert_true(o->frequency[0] > 1 && o->frequency[0] < 1.29 && o->frequency[1] > 12.8 &&
                o->frequency[1] < 28);
    ric_study_free(study);
    study = parse(
        "  mass: [[0.3]]\n  stiffness: [[0]]\n  contacts: [{normal: [1], clearance: 1.0e-3}]\n",
        "");
    assert_true(isnan(ric_model_onset(ric_study_model(study), &mode)) && mode == 0);
    assert_true(ric_study_options(study)->energy[0] > 0);
    ric_study_free(study);
}

/* Whatever the model, the windows can be read back, and hold the first touch of some mode that is
 * started from. */
static void windows_of_random_models(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 60; seed++) {
        seed_now = seed;
        const int n = 1 + below(6);
        double M[n * n], K[n * n], b[n], frequency[n], onset[n];
        ric_model *model = NULL;
        random_definite(n, n, 0.3, M);
        random_definite(n, n, 0.1, K);
        for (int i = 0; i < n; i++) b[i] = uniform(-1, 1);
        const ric_contact contact = {.normal = b,
                                     .clearance = uniform(0.1, 3),
                                     .sides = (ric_sides)below(3),
                                     .law = (ric_law)below(3),
                                     .stiffness = uniform(0.1, 9),
                                     .exponent = 3 + 2 * below(9)};
        assert_int_equal(ric_model_create(n, M, K, 1, &contact, 1, &model), RIC_OK);
        bool held = false;
        ric_explore_options o;
        ric_explore_options_init(&o);
        o.impacts = 1 + (int)(seed * 7 % 60);
        assert_int_equal(ric_windows_choose(model, &o), RIC_OK);
        assert_int_equal(ric_model_onsets(model, onset), RIC_OK);
        assert_int_equal(ric_model_frequencies(model, frequency), RIC_OK);
        for (int i = 0; i < n; i++)
            held |= onset[i] > o.energy[0] && onset[i] < o.energy[1] / 10 &&
                    frequency[i] > o.frequency[0] && frequency[i] < o.frequency[1];
        if (!held)
            print_error("seed %u: energy [%g, %g], frequency [%g, %g]\n", seed, o.energy[0],
                        o.energy[1], o.frequency[0], o.frequency[1]);
        assert_true(held);
        ric_model_free(model);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_article_is_in_the_window),
        cmocka_unit_test(windows_follow_the_units),
        cmocka_unit_test(what_is_given_stays),
        cmocka_unit_test(energies_in_first_touches),
        cmocka_unit_test(bad_multiples),
        cmocka_unit_test(onset_under_a_power_law),
        cmocka_unit_test(loose_masses),
        cmocka_unit_test(windows_of_random_models),
    };
    return cmocka_run_group_tests_name("windows", tests, NULL, NULL);
}
