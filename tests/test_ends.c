/* First and last orbits of branches, and junctions, where events fall together: what is stored there solves its
 * equations as it stands, lasts no negative time, and touches what it is said to touch. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "explored.h"

/* Branches through a soft and a stiff spring end where contacts of no time begin or end. */
static void no_negative_flight(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[2, 0, 0], [0, 1.75, 0], [0, 0, 0.75]]\n"
        "  stiffness: [[7.75, -7.75, 0], [-7.75, 14, -6.25], [0, -6.25, 6.25]]\n  contacts:\n"
        "    - {normal: [-1, 1, 0], law: bilinear, clearance: 8.33, sides: both, stiffness: 0.02617}\n"
        "    - {normal: [0, -1, 1], law: bilinear, clearance: 8.338, sides: both, stiffness: 10450}\n"
        "explore: {energy: [0, 30.98], frequency: [0.4791, 11.41], impacts: 8, multiply: 3, depth: 2}\n");
    int none = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        double *flights = calloc((size_t)b.letters + 1, sizeof *flights);
        for (int i = 0; i < b.n_point && b.letters; i++) {
            ric_point p;
            assert_int_equal(ric_atlas_point(atlas, id, i, &p, NULL, flights), RIC_OK);
            for (int k = 0; k < b.letters; k++) {
                if (flights[k] < 0) fail_msg("branch %d, point %d: flight %d lasts %g", id, i, k, flights[k]);
                none += flights[k] == 0;
            }
            point_passes(atlas, id, i);
        }
        free(flights);
    }
    assert_true(none > 0);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_negative_flight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
