/* Internal resonances along branches: on two modes and a rigid stop the first one that the backbone of the lower mode
 * meets is known beforehand. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

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

static int labelled(const ric_atlas *atlas, const char *label)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        if (!strcmp(branch_of(atlas, id).label, label)) return id;
    fail_msg("no branch %s", label);
    return 0;
}

/* S2[01] has frequencies above that of its mode. Of the resonances of odd order it meets that next below r first, and
 * climbs along it: up to the energy r^2 / 2 c^2 of the faint mode alone. */
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
        const int id = labelled(atlas, "S2+[01]");
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

/* A family of a mode itself is none, nor is a backbone that no faint mode bends. */
static void families_of_their_own_are_no_tongues(void **state)
{
    (void)state;
    int n;
    ric_tongue *t;
    ric_atlas *atlas = explore_text("model: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]], contacts: "
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
        cmocka_unit_test(families_of_their_own_are_no_tongues),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
