/* Grazings whose touches no symmetry exchanges, or which alone see where a structure is: the same
 * for every step. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "close.h"
#include "explored.h"
#include "steps.h"

/* The first mass touches both its stops twice in one flight between impacts
 * of the second on it: no symmetry takes these touches to one another. As impacts they were known
 * to the root of rounding, so that one to all of them passed for touches and E was off by 1e-9. */
static void four_touches_of_one_flight(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(
        1e-13,
        "model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[3, 0], [0, 2]]\n"
        "  contacts: [{normal: [1, 0], clearance: 1.62, sides: both, law: rigid},\n"
        "             {normal: [-1, 1], clearance: 1.55, sides: both, law: rigid}]\n"
        "explore: {energy: [0, 3.15], frequency: [0.2828, 5.196], impacts: 4, multiply: 2, depth: "
        "1}\n");
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        const ric_junction j = junction_of(atlas, id);
        found += j.kind == RIC_KIND_GRAZING && j.impacts == 2 && j.grazings == 4 &&
                 agrees(j.energy, 3.0977760926588163, 1e-14);
    }
    assert_int_equal(found, 1);
    ric_atlas_free(atlas);
}

/* Four masses that nothing holds, between springs that see their shape alone; a wall that they
 * touch is the first thing that sees where they are. The touch alone leaves them a curve of
 * motions, of which each step found another place, with energies apart in the fifth digit. S2[12],
 * which comes there, holds its middle by its symmetry: the junction is at its end. */
static void the_place_along_a_free_mode(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(
        1e-13,
        "model:\n  mass: [[0.75, 0, 0, 0], [0, 1.5, 0, 0], [0, 0, 0.5, 0], [0, 0, 0, 1]]\n"
        "  stiffness: [[4.75, -4.75, 0, 0], [-4.75, 9, -4.25, 0], [0, -4.25, 6.25, -2], [0, 0, -2, "
        "2]]\n"
        "  contacts: [{normal: [-2, 1, 2, -2], law: rigid, clearance: 1.31, sides: lower},\n"
        "             {normal: [1, 0, 0, -1], law: bilinear, clearance: 0.776, sides: both, "
        "stiffness: 159300}]\n"
        "explore: {energy: [0, 0.8329], frequency: [0.2748, 12.03], impacts: 5, multiply: 2, "
        "depth: 1}\n");
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        const ric_junction j = junction_of(atlas, id);
        if (j.kind != RIC_KIND_GRAZING || !j.impacts) continue;
        const ric_branch b = branch_of(atlas, j.branches[0]);
        ric_point end;
        assert_int_equal(ric_atlas_point(atlas, b.id, b.n_point - 1, &end, NULL, NULL), RIC_OK);
        assert_true(agrees(j.energy, end.energy, 1e-14));
        found++;
    }
    assert_int_equal(found, 1);
    ric_atlas_free(atlas);
}

/* Two masses that nothing holds: the wall is touched while a spring is closed, which turns the
 * motion there. */
static void a_touch_while_a_spring_is_closed(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(
        1e-13, "model:\n  mass: [[1, 0], [0, 2]]\n  stiffness: [[5.75, -5.75], [-5.75, 5.75]]\n"
               "  contacts: [{normal: [-1, 1], law: bilinear, clearance: 0.837, sides: both, "
               "stiffness: 32.27},\n"
               "             {normal: [1, 0], law: rigid, clearance: 1.03, sides: lower}]\n"
               "explore: {energy: [0, 26.78], frequency: [0.5874, 8.811], impacts: 4, multiply: 2, "
               "depth: 2}\n");
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        const ric_junction j = junction_of(atlas, id);
        found += j.kind == RIC_KIND_GRAZING && j.impacts == 2 && j.grazings == 1;
    }
    assert_int_equal(found, 1);
    ric_atlas_free(atlas);
}

/* Two bodies of two masses that nothing holds: the stop between them sees that they come nearer,
 * the wall that both move. Each of the two free modes, however they are chosen, is seen by an
 * impact, and their sum by none. */
static void the_place_along_two_free_modes(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(
        1e-12,
        "model:\n  mass: [[1.25, 0, 0, 0], [0, 0.75, 0, 0], [0, 0, 1.25, 0], [0, 0, 0, 1.5]]\n"
        "  stiffness: [[2.5, -2.5, 0, 0], [-2.5, 2.5, 0, 0], [0, 0, 6.25, -6.25], [0, 0, -6.25, "
        "6.25]]\n"
        "  contacts: [{normal: [-1, 1, 0, 0], law: bilinear, stiffness: 5, clearance: 1.1, sides: "
        "both},\n"
        "             {normal: [1, 0, 0, -1], law: rigid, clearance: 0.901625540452666, sides: "
        "both},\n"
        "             {normal: [0, 1, 0, 1], law: rigid, clearance: 0.9060586313654718, sides: "
        "lower}]\n"
        "explore: {energy: [0, 12], frequency: [0.3, 9], impacts: 4, multiply: 2, depth: 1}\n");
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        const ric_junction j = junction_of(atlas, id);
        found += j.kind == RIC_KIND_GRAZING && j.impacts == 2;
    }
    assert_int_equal(found, 13);
    ric_atlas_free(atlas);
}

/* Two frequencies as one to three, but for little: A2[11] ends at a touch, to which its gap opens
 * so slowly that the rounding of a reach, and of an orbit in double, leave 1e-9 of its energy open.
 * As an event, and in extended precision, it is the same orbit for all steps. */
static void the_end_beside_a_resonance(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(
        1e-13, "model:\n  mass: [[0.515625, -0.03125], [-0.03125, 2.0625]]\n"
               "  stiffness: [[0.5187597405510036, 0.09571239200907587], [0.09571239200907587, "
               "8.229355825714082]]\n"
               "  contacts: [{normal: [0, 1], law: bilinear, clearance: 0.00162, sides: upper, "
               "stiffness: 34.65},\n"
               "             {normal: [-1, 1], law: rigid, clearance: 0.00162, sides: upper}]\n"
               "explore: {energy: [0, 18.15], frequency: [0.2001, 6.004], impacts: 4, multiply: 3, "
               "depth: 1}\n");
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        const ric_junction j = junction_of(atlas, id);
        found += j.kind == RIC_KIND_GRAZING && j.impacts == 2 &&
                 agrees(j.energy, 0.264317142032995, 1e-13);
    }
    assert_int_equal(found, 1);
    ric_atlas_free(atlas);
}

/* Two frequencies as one to two: A2[11] ends 3e-7 of the clearance short of its touch, and is lost
 * on the way there. The junction is the solution with the touch as an event, which touches. */
static void an_end_that_is_short_of_its_touch(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n"
        "  mass: [[1.515625, 0.0625, -0.1875], [0.0625, 1.640625, 0.046875], [-0.1875, 0.046875, "
        "1.78125]]\n"
        "  stiffness: [[12.547851293979528, 4.056076943841447, -2.0775034357814324],\n"
        "    [4.056076943841447, 3.514265290770568, 0.8135200919515737],\n"
        "    [-2.0775034357814324, 0.8135200919515737, 7.02294651279666]]\n"
        "  contacts: [{normal: [0, 1, 0], law: rigid, clearance: 1.3, sides: lower},\n"
        "             {normal: [1, -1, 1], law: bilinear, clearance: 0.649, sides: lower, "
        "stiffness: 106.9},\n"
        "             {normal: [0, 0, 1], law: rigid, clearance: 1.91, sides: both}]\n"
        "explore: {energy: [0, 8.635], frequency: [0.2, 9], impacts: 4, multiply: 2, depth: 2}\n");
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        const ric_junction j = junction_of(atlas, id);
        ric_claims claims;
        if (j.kind != RIC_KIND_GRAZING || j.impacts != 2) continue;
        assert_int_equal(ric_verify_junction(atlas, id, &claims), RIC_OK);
        if (claims.numbers == RIC_AGREES_NO) fail_msg("%s: %s", j.label, claims.finding);
        found += agrees(j.energy, 3.770511, 1e-6);
    }
    assert_int_equal(found, 1);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(four_touches_of_one_flight),
                                       cmocka_unit_test(the_place_along_a_free_mode),
                                       cmocka_unit_test(a_touch_while_a_spring_is_closed),
                                       cmocka_unit_test(the_place_along_two_free_modes),
                                       cmocka_unit_test(the_end_beside_a_resonance),
                                       cmocka_unit_test(an_end_that_is_short_of_its_touch)};
    return cmocka_run_group_tests_name("touches", tests, NULL, NULL);
}
