/* What a branch passes beside its ends, and beside its own image, does not depend on how far apart
 * its points lie. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "close.h"
#include "explore/graph_parts.h"
#include "explored.h"
#include "steps.h"

/* Gaps of 1/1000 of each other: |w| is 131. */
static const char returning[] =
    "model:\n  mass: [[1.890625, 0.234375], [0.234375, 1.15625]]\n"
    "  stiffness: [[2.0149765091291507, 0.8971315879005736], [0.8971315879005736, "
    "4.623897066319733]]\n"
    "  contacts:\n"
    "    - {normal: [-1, 1], law: rigid, clearance: 0.000517, sides: both}\n"
    "    - {normal: [1, 0], law: rigid, clearance: 5.17e-07, sides: upper}\n"
    "explore: {energy: [0, 1.414], frequency: [0.1999, 5.999], impacts: 3, multiply: 2, depth: "
    "2}\n";

static int count_at(const ric_atlas *atlas, ric_kind kind, double energy, double tolerance)
{
    int count = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        count += j.kind == kind && agrees(j.energy, energy, tolerance);
    }
    return count;
}

/* A3[222] comes to an orbit that is its own image backwards, and ends there. It is 17 away from an
 * orbit gone through three times, which long steps took for near: they went on over the image.
 * Extrema of the period are flat. */
static void ends_at_its_image(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(1e-7, returning);
    assert_int_equal(count_at(atlas, RIC_KIND_BRANCH_POINT, 0.00490567344351, 1e-10), 1);
    ric_atlas_free(atlas);
}

/* One passage of a multiplication more, as where a branch goes back over its image. */
static void returning_is_said(void **state)
{
    (void)state;
    ric_study *study = NULL;
    assert_int_equal(ric_study_parse(returning, "test", ".", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    int tried = 0;
    for (int i = 0; i < graph->n_edge; i++) {
        ric_edge *e = &graph->edges[i];
        const ric_continuation *tr = e->trace;
        ric_graph_edge_returning(graph, e);
        assert_int_equal(tr->unresolved, 0);
        if (e->n_inner == 0 || graph->nodes[e->inner[0].node]->kind == RIC_KIND_BRANCH_POINT)
            continue;
        const double again = (e->inner[0].at +
                              ric_continuation_row(tr, tr->n_point - 1)->arclength) /
                             2;
        if (tr->n_point < 9 || !(again > e->inner[e->n_inner - 1].at)) continue;
        assert_int_equal(ric_graph_edge_attach(e, e->inner[0].node, RIC_THROUGH, again), RIC_OK);
        ric_graph_edge_returning(graph, e);
        assert_true(tr->unresolved > 0 && tr->crowded_at[0] > 0);
        tried++;
    }
    print_message("# %d branches\n", tried);
    assert_true(tried > 0);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* Two branches that are mirror images of each other, but for a spring that they do not reach,
 * double 7e-12 of their energy behind their grazing: one of them was looked at so near to it, the
 * other was not. */
static void doublings_beside_a_grazing(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(
        1e-9,
        "model:\n"
        "  mass: [[1.34375, -0.1875, 0.078125], [-0.1875, 1.703125, -0.1875], [0.078125, -0.1875, "
        "1.765625]]\n"
        "  stiffness: [[8.61333946318051, 2.549643188425369, -3.1112634045522167], "
        "[2.549643188425369, "
        "8.545024061135367, -0.7546651917744671], [-3.1112634045522167, -0.7546651917744671, "
        "3.234016108359813]]\n"
        "  contacts:\n"
        "    - {normal: [-1, 1, 0], law: rigid, clearance: 17.1, sides: both}\n"
        "    - {normal: [0, 0, 1], law: bilinear, clearance: 8.91, sides: upper, stiffness: "
        "513300}\n"
        "    - {normal: [1, 0, -1], law: rigid, clearance: 9.93, sides: both}\n"
        "explore: {energy: [0, 3.953], frequency: [0.2, 9], impacts: 2, multiply: 2, depth: 2}\n");
    assert_int_equal(count_at(atlas, RIC_KIND_MULTIPLICATION, 1.67303609677389, 1e-13), 2);
    ric_atlas_free(atlas);
}

static bool said_at(const ric_atlas *atlas, double energy)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const char *at = strstr(branch_of(atlas, id).why, "closer together than can be told apart");
        double low, high;
        if (at &&
            sscanf(at, "closer together than can be told apart (E %lf to %lf)", &low, &high) == 2 &&
            low <= energy && high >= energy)
            return true;
    }
    return false;
}

/* A mode touches springs. A4[0101] comes to it and before that, by 5e-12 of the energy, closes a
 * gap; A2[01] doubles nearer to it than anything is looked for. */
static void beside_the_touch_of_a_mode(void **state)
{
    (void)state;
    static const double steps[] = {0.009, 0.03, 0.09};
    for (int i = 0; i < 3; i++) {
        ric_atlas *atlas = explore_text_with(
            "model:\n  mass: [[2, 0], [0, 1.5]]\n  stiffness: [[2, -0.5], [-0.5, 6.75]]\n"
            "  contacts: [{normal: [1, 0], law: bilinear, clearance: 0.00121, sides: both, "
            "stiffness: 855600}]\n"
            "explore: {energy: [0, 1349], frequency: [0.1976, 6.381], impacts: 4, multiply: 2, "
            "depth: "
            "2}\n",
            NULL, steps[i]);
        assert_int_equal(count_at(atlas, RIC_KIND_GRAZING, 678.517096743246, 2e-14), 1);
        const int found = count_at(atlas, RIC_KIND_MULTIPLICATION, 678.517096656604, 1e-13);
        if (!found && !said_at(atlas, 678.517096656604))
            fail_msg("step %g: a doubling is neither found nor said to be missing", steps[i]);
        ric_atlas_free(atlas);
    }
}

/* Modes at 1 and 2. S6[010101] comes to the second one, where all its impacts end at once and are
 * known to the root of rounding: some steps took two of them for impacts of an S2[01] that touches
 * four times more, which has no speed at either, where it is the mode that touches ten times. */
static void no_impacts_without_speed(void **state)
{
    (void)state;
    static const double steps[] = {0.006, 0.009, 0.03};
    for (int i = 0; i < 3; i++) {
        ric_atlas *atlas = explore_text_with(
            "model:\n  mass: [[0.515625, 0.03125], [0.03125, 0.953125]]\n"
            "  stiffness: [[0.757852433001187, 0.8094748503892197], [0.8094748503892197, "
            "3.4533947269237726]]\n"
            "  contacts: [{normal: [-1, 1], law: rigid, clearance: 0.000827, sides: both}]\n"
            "explore: {energy: [0, 53.36], frequency: [0.2, 6], impacts: 8, multiply: 3, depth: "
            "2}\n",
            NULL, steps[i]);
        int found = 0;
        for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
            const ric_junction j = junction_of(atlas, id);
            if (j.kind != RIC_KIND_GRAZING || !agrees(j.frequency, 0.4, 1e-9)) continue;
            if (j.impacts > 0) fail_msg("step %g: %s", steps[i], j.label);
            found++;
        }
        assert_int_equal(found, 1);
        ric_atlas_free(atlas);
    }
}

/* Between gaps of 1/1000 of each other an impact loses its speed in the orbit that touches the
 * opposite stop: to which side of that rounding puts the end of A7 depends on the step, and its
 * last orbit was 0.036 of the energy before it. */
static void ends_where_a_touch_takes_an_impact(void **state)
{
    (void)state;
    static const double steps[] = {0.009, 0.03, 0.09};
    for (int i = 0; i < 3; i++) {
        ric_atlas *atlas = explore_text_with(
            "model:\n  mass: [[1.8125, -0.03125], [-0.03125, 0.953125]]\n"
            "  stiffness: [[4.375, -0.0625], [-0.0625, 1.8125]]\n  contacts:\n"
            "    - {normal: [1, -1], law: rigid, clearance: 14.1, sides: both}\n"
            "    - {normal: [0, 1], law: bilinear, clearance: 0.0141, sides: both, stiffness: "
            "0.364}\n"
            "explore: {energy: [0, 2.629], frequency: [0.2758, 4.661], impacts: 8, multiply: 2, "
            "depth: 2}\n",
            NULL, steps[i]);
        const int id = branch_named(atlas, "A7[0-321-230-323]");
        assert_relative(branch_of(atlas, id).energy_max, 1.47763400342, 1e-10);
        ric_atlas_free(atlas);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(ends_at_its_image),
                                       cmocka_unit_test(returning_is_said),
                                       cmocka_unit_test(doublings_beside_a_grazing),
                                       cmocka_unit_test(beside_the_touch_of_a_mode),
                                       cmocka_unit_test(no_impacts_without_speed),
                                       cmocka_unit_test(ends_where_a_touch_takes_an_impact)};
    return cmocka_run_group_tests_name("steps_ends", tests, NULL, NULL);
}
