/* Internal resonances along branches: on two modes and a rigid stop the first one that the backbone
 * of the lower mode meets is known beforehand. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/room.h"
#include "explored.h"
#include "random_models.h"

/* Modes 1 and r, of which the stop hardly sees the second one. */
static ric_atlas *two_modes(double r, double faint, const char *options)
{
    char text[1024];
    snprintf(text, sizeof text,
             "model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[1, 0], [0, %.17g]]\n"
             "  contacts: [{normal: [1, %.17g], clearance: 1}]\n"
             "explore: {start: [1], impacts: 2, multiply: 1, depth: 1, %s}\n",
             r * r, faint, options);
    return explore_text(text);
}

/* S2[01] has frequencies above that of its mode. Of the resonances of odd order it meets that next
 * below r first, and climbs along it: up to the energy r^2 / 2 c^2 of the faint mode alone. */
static void the_first_odd_resonance_is_followed(void **state)
{
    (void)state;
    seed_now = 20090101;
    print_message("seed %llu\n", (unsigned long long)seed_now);
    for (int i = 0; i < 20; i++) {
        const double r = uniform(3.3, 23.3), faint = pow(10, uniform(-3.3, -1.3));
        const int expected = 2 * (int)floor((r - 1) / 2) + 1;
        if (r - expected < 0.05) continue; /* next to it the backbone begins in the tongue */
        ric_atlas *atlas = two_modes(r, faint, "energy: [0, 40], frequency: [0.1, 40]");
        const int id = branch_named(atlas, "S2+[01]");
        int n;
        ric_tongue *t;
        char text[100], asked[100];
        assert_int_equal(ric_branch_tongues(atlas, id, &n, &t), RIC_OK);
        print_message("r %.6f c %.2e: %d\n", r, faint, n);
        assert_int_equal(n, 1);
        assert_int_equal(t->mode, 2);
        assert_int_equal(t->turns, expected);
        assert_int_equal(t->per, 1);
        assert_true(fabs(t->frequency[1] * expected / r - 1) < faint);
        assert_true(t->energy[1] > t->energy[0]);
        snprintf(asked, sizeof asked, "follows %d : 1 with mode 2 from E ", expected);
        assert_int_equal(ric_tongue_text(t, 1, sizeof text, text), RIC_OK);
        assert_memory_equal(text, asked, strlen(asked));
        ric_tongues_free(t);
        ric_atlas_free(atlas);
    }
}

/* ------------------------------------------------------------------- crossed */

/* The energy of S2[01] at a frequency, by the closed form (docs/theory.md section 11). */
static double closed_form(int n, const double *omega, const double *c, double frequency)
{
    double tau = RIC_TWO_PI / frequency / 2, above = 0, below = 0;
    for (int i = 0; i < n; i++) {
        above += c[i] * c[i] / pow(cos(omega[i] * tau / 2), 2);
        below += c[i] * c[i] * tan(omega[i] * tau / 2) / omega[i];
    }
    return above / (2 * below * below);
}

static ric_point point_of(const ric_atlas *atlas, int id, int i)
{
    ric_point p;
    assert_int_equal(ric_atlas_point(atlas, id, i, &p, NULL, NULL), RIC_OK);
    return p;
}

/* Where the branch is followed to the end of its tongue it ends there; crossed, it goes on to the
 * window, and every orbit is one of S2[01]: beyond the gaps too, which are those of the odd
 * resonances on the way, in order. */
static void the_backbone_goes_on_behind_its_tongues(void **state)
{
    (void)state;
    seed_now = 20091;
    print_message("seed %llu\n", (unsigned long long)seed_now);
    for (int k = 0; k < 12; k++) {
        const double r = uniform(6, 30), faint = pow(10, uniform(-3.5, -2.25)), c[2] = {1, faint},
                     omega[2] = {1, r};
        if (fmod(r + 1, 2) < 0.1) continue;
        ric_atlas *atlas =
            two_modes(r, faint,
                      "energy: [0, 8], frequency: [0.1, 40], tongues: cross, tongue_width: 0.05");
        const int id = branch_named(atlas, "S2+[01]");
        const ric_branch b = branch_of(atlas, id);
        int n, expected = 2 * (int)floor((r - 1) / 2) + 1;
        ric_tongue *t;
        assert_int_equal(b.stop, RIC_STOP_WINDOW);
        assert_string_equal(b.why, "upper end of the energy window");
        assert_int_equal(ric_branch_tongues(atlas, id, &n, &t), RIC_OK);
        print_message("r %.6f c %.2e: %d gaps, omega to %.4f\n", r, faint, n, b.frequency_max);
        assert_true(n > 0);
        for (int i = 0; i < n; i++) {
            assert_true(t[i].crossed && t[i].mode == 2 && t[i].per == 1 &&
                        t[i].last == t[i].first + 1);
            assert_int_equal(t[i].turns, expected - 2 * i);
            assert_true(t[i].frequency[0] < r / t[i].turns && t[i].frequency[1] > r / t[i].turns);
            assert_true(t[i].frequency[1] / t[i].frequency[0] - 1 < 0.05);
            assert_true(ric_branch_steps_over(atlas, id, t[i].first));
            assert_false(ric_branch_steps_over(atlas, id, t[i].last));
        }
        assert_true(r / t[n - 1].turns < b.frequency_max &&
                    r / (t[n - 1].turns - 2) > b.frequency_max);
        for (int i = 1; i < b.n_point; i++) {
            const ric_point p = point_of(atlas, id, i);
            assert_true(fabs(closed_form(2, omega, c, p.frequency) / p.energy - 1) < 1e-6);
            if (i % 7 == 0) point_passes(atlas, id, i);
        }
        ric_tongues_free(t);
        ric_atlas_free(atlas);
    }
}

/* With one, two and four modes the backbones agree but for their tongues: mode by mode as the
 * closed form does. */
static void backbones_agree_away_from_the_tongues(void **state)
{
    (void)state;
    static const double omega[4] = {1, 9.23, 24.61, 48.37}, c[4] = {1, 0.02, 0.008, 0.003};
    double first[8] = {0};
    for (int n = 1; n <= 4; n *= 2) {
        char text[2048];
        int used = snprintf(text, sizeof text, "model:\n  mass: [");
        for (int pass = 0; pass < 2; pass++) {
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n; j++)
                    used += snprintf(text + used, sizeof text - (size_t)used, "%s%.17g%s",
                                     j ? ", " : "[",
                                     i != j ? 0
                                     : pass ? omega[i] * omega[i]
                                            : 1,
                                     j + 1 < n   ? ""
                                     : i + 1 < n ? "], "
                                                 : "]]\n");
            if (!pass) used += snprintf(text + used, sizeof text - (size_t)used, "  stiffness: [");
        }
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "  contacts: [{clearance: 1, normal: ");
        for (int i = 0; i < n; i++)
            used += snprintf(text + used, sizeof text - (size_t)used, "%s%g", i ? ", " : "[", c[i]);
        snprintf(text + used, sizeof text - (size_t)used,
                 "]}]\nexplore: {start: [1], energy: [0, 30], frequency: [0.1, 50], impacts: 2, "
                 "multiply: 1, depth: 1, "
                 "tongues: cross}\n");
        ric_atlas *atlas = explore_text(text);
        const int id = branch_named(atlas, n == 2 ? "S2+[01]" : "S2(1)[01]");
        const ric_branch b = branch_of(atlas, id);
        assert_string_equal(b.why, "upper end of the energy window");
        for (int k = 0; k < 8; k++) {
            double energy = 0, asked = 1.05 + 0.07 * k;
            for (int i = 1; i < b.n_point; i++) {
                const ric_point p = point_of(atlas, id, i - 1), q = point_of(atlas, id, i);
                if ((p.frequency - asked) * (q.frequency - asked) > 0 ||
                    ric_branch_steps_over(atlas, id, i - 1))
                    continue;
                energy = p.energy + (asked - p.frequency) / (q.frequency - p.frequency) *
                                        (q.energy - p.energy);
            }
            if (n == 1) first[k] = energy;
            if (energy > 0) assert_true(fabs(energy / first[k] - 1) < 0.01);
            if (energy > 0) assert_true(fabs(energy / closed_form(n, omega, c, asked) - 1) < 5e-3);
        }
        ric_atlas_free(atlas);
    }
}

/* Which tongues are stepped over does not depend on where the steps fall; a narrower gap than that
 * of a tongue is not enough for it. */
static void gaps_do_not_depend_on_steps(void **state)
{
    (void)state;
    static const double steps[] = {0.1, 0.03, 0.008};
    int turns[16], most = 0;
    for (int k = 0; k < 3; k++) {
        char text[1024];
        snprintf(text, sizeof text,
                 "model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[1, 0], [0, 316.84]]\n  "
                 "contacts: [{normal: [1, "
                 "0.004], clearance: 1}]\nexplore: {start: [1], impacts: 2, multiply: 1, depth: 1, "
                 "tongues: cross, "
                 "energy: [0, 40], frequency: [0.1, 40]}\n");
        ric_atlas *atlas = explore_text_with(text, NULL, steps[k]);
        int n;
        ric_tongue *t;
        assert_int_equal(ric_branch_tongues(atlas, branch_named(atlas, "S2+[01]"), &n, &t), RIC_OK);
        if (k) assert_int_equal(n, most);
        for (int i = 0; i < n; i++) {
            if (k) assert_int_equal(t[i].turns, turns[i]);
            turns[i] = t[i].turns;
        }
        most = n;
        ric_tongues_free(t);
        ric_atlas_free(atlas);
    }
    ric_atlas *atlas =
        two_modes(17.8, 0.004,
                  "energy: [0, 40], frequency: [0.1, 40], tongues: cross, tongue_width: 1e-5");
    int n;
    ric_tongue *t;
    assert_int_equal(ric_branch_tongues(atlas, branch_named(atlas, "S2+[01]"), &n, &t), RIC_OK);
    assert_true(n == 1 && !t->crossed);
    ric_tongues_free(t);
    ric_atlas_free(atlas);
}

/* A family of a mode itself is none, nor is a backbone that no faint mode bends. */
static void families_of_their_own_are_no_tongues(void **state)
{
    (void)state;
    int n;
    ric_tongue *t;
    ric_atlas *atlas = explore_text(
        "model: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]], contacts: "
        "[{normal: [-1, 1], clearance: 1}]}\n"
        "explore: {energy: [0, 100], impacts: 6, depth: 2}\n");
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        assert_int_equal(ric_branch_tongues(atlas, id, &n, &t), RIC_OK);
        assert_int_equal(n, 0);
        ric_tongues_free(t);
    }
    assert_int_equal(ric_branch_tongues(atlas, 0, &n, &t), RIC_E_RANGE);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_odd_resonance_is_followed),
        cmocka_unit_test(the_backbone_goes_on_behind_its_tongues),
        cmocka_unit_test(backbones_agree_away_from_the_tongues),
        cmocka_unit_test(gaps_do_not_depend_on_steps),
        cmocka_unit_test(families_of_their_own_are_no_tongues),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
