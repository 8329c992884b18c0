/* Regions of a study: read, written and read again; one takes the place of those that ask for no
 * more; which budgets hold where. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "study/region.h"
#include "base/status.h"
#include "study/study.h"

static const char model[] = "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
                            "  contacts:\n    - {normal: [-1, 1], clearance: 1.0, sides: both}\n";

static ric_study *study_with(const char *explore)
{
    char text[2000];
    ric_study *study = NULL;
    snprintf(text, sizeof text, "%s%s", model, explore);
    if (ric_study_parse(text, "study", ".", &study)) fail_msg("%s", ric_detail());
    return study;
}

static const char three[] =
    "explore: {energy: [0, 200], frequency: [0.5, 5], depth: 3, impacts: 12, multiply: 2}\n";

/* Each bit but those of padding. */
static bool same_region(const ric_region *a, const ric_region *b)
{
    return !memcmp(a->energy, b->energy, sizeof a->energy) &&
           !memcmp(a->frequency, b->frequency, sizeof a->frequency) && a->depth == b->depth &&
           a->impacts == b->impacts && a->multiply == b->multiply;
}

static void regions_are_read_back_bit_for_bit(void **state)
{
    (void)state;
    ric_study *study = study_with(
        "explore: {depth: 3}\nregions:\n  - {frequency: [1.6, 1.7], energy: [0.1, 80], depth: 0}\n"
        "  - {energy: [3, 4], frequency: [0.30000000000000004, 2], impacts: 40, multiply: "
        "5}\nnames: []\n");
    ric_study *again = NULL;
    if (ric_study_parse(ric_study_text(study), "study", ".", &again)) fail_msg("%s", ric_detail());
    const ric_explore_options *a = ric_study_options(study), *b = ric_study_options(again);
    assert_int_equal(b->n_region, 2);
    for (int i = 0; i < 2; i++) assert_true(same_region(&a->region[i], &b->region[i]));
    assert_int_equal(b->region[0].depth, 0);
    assert_int_equal(b->region[0].impacts, RIC_REGION_SAME);
    assert_int_equal(b->region[1].depth, RIC_REGION_SAME);
    assert_true(b->region[1].frequency[0] == 0.30000000000000004);
    assert_string_equal(ric_study_text(study), ric_study_text(again));
    ric_study_free(study);
    ric_study_free(again);
}

static void a_region_takes_the_place_of_those_that_ask_for_no_more(void **state)
{
    (void)state;
    ric_study *study = study_with(three);
    const ric_explore_options *o = ric_study_options(study);
    const ric_region small = {{1, 2}, {1, 2}, 4, RIC_REGION_SAME, RIC_REGION_SAME},
                     deep = {{1, 2}, {1, 2}, 6, RIC_REGION_SAME, RIC_REGION_SAME};
    const ric_region large = {{0.5, 3}, {1, 2.5}, 5, 20, RIC_REGION_SAME},
                     without_limit = {{0.5, 3}, {1, 2.5}, 0, 20, 3};
    assert_int_equal(ric_study_add_region(study, &small), RIC_OK);
    assert_int_equal(ric_study_add_region(study, &small), RIC_OK);
    assert_int_equal(o->n_region, 1);
    assert_int_equal(ric_study_add_region(study, &deep), RIC_OK);
    assert_int_equal(o->n_region, 1);
    assert_int_equal(ric_study_add_region(study, &large), RIC_OK); /* wider, but not as deep */
    assert_int_equal(o->n_region, 2);
    assert_int_equal(ric_study_add_region(study, &without_limit), RIC_OK);
    assert_int_equal(o->n_region, 1);
    assert_true(same_region(&o->region[0], &without_limit));
    assert_non_null(strstr(ric_study_text(study), "regions:\n  - {energy: [0.5, 3], frequency: [1, "
                                                  "2.5], depth: 0, impacts: 20, multiply: 3}\n"));
    ric_study_free(study);
}

static void there_are_so_many_and_no_more(void **state)
{
    (void)state;
    ric_study *study = study_with(three);
    for (int i = 0; i < RIC_REGIONS_MAX; i++)
        assert_int_equal(ric_study_add_region(study, &(ric_region){{i, i + 0.5}, {1, 2}, 5, 5, 5}),
                         RIC_OK);
    char before[40];
    snprintf(before, sizeof before, "%zu", strlen(ric_study_text(study)));
    assert_int_equal(ric_study_add_region(study, &(ric_region){{99, 100}, {1, 2}, 5, 5, 5}),
                     RIC_E_RANGE);
    assert_int_equal(ric_study_options(study)->n_region, RIC_REGIONS_MAX);
    assert_int_equal(strlen(ric_study_text(study)), strtoul(before, NULL, 10));
    /* instead of them all */
    assert_int_equal(ric_study_add_region(study, &(ric_region){{0, 100}, {1, 2}, 5, 5, 5}), RIC_OK);
    assert_int_equal(ric_study_options(study)->n_region, 1);
    ric_study_free(study);
    study = study_with("explore: {cascade: [3, 2]}\n");
    assert_int_equal(ric_study_add_region(study, &(ric_region){{0, 1}, {1, 2}, 5, 5, 5}),
                     RIC_E_INPUT);
    ric_study_free(study);
}

static void budgets_hold_where_the_region_is(void **state)
{
    (void)state;
    ric_study *study = study_with(
        "explore: {energy: [0, 200], frequency: [0.5, 5], depth: 3, impacts: 12, multiply: 2}\n"
        "regions:\n  - {energy: [10, 300], frequency: [1, 2], depth: 5, impacts: 8, multiply: "
        "6}\n");
    const ric_explore_options *o = ric_study_options(study);
    double energy[2], frequency[2];
    ric_budgets b = ric_region_budgets(o, 20, 1.5, 1);
    assert_true(b.depth == 5 && b.impacts == 12 && b.multiply == 6 &&
                b.inside); /* never less than elsewhere */
    b = ric_region_budgets(o, 20, 4.5, 1);
    assert_true(b.depth == 3 && b.impacts == 12 && b.multiply == 2 && b.inside);
    b = ric_region_budgets(o, 20, 4.5, 3); /* drawn at 1.5 */
    assert_true(b.depth == 5 && b.multiply == 6 && b.inside);
    b = ric_region_budgets(o, 250, 1.5, 1);
    assert_true(b.depth == 5 && b.inside);
    b = ric_region_budgets(o, 250, 4.5, 1);
    assert_true(b.depth == 3 && !b.inside);
    ric_region_window(o, energy, frequency);
    assert_true(energy[0] == 0 && energy[1] == 300 && frequency[0] == 0.5 && frequency[1] == 5);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regions_are_read_back_bit_for_bit),
        cmocka_unit_test(a_region_takes_the_place_of_those_that_ask_for_no_more),
        cmocka_unit_test(there_are_so_many_and_no_more),
        cmocka_unit_test(budgets_hold_where_the_region_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
