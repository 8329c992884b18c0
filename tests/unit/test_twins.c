/* Contacts that are images of one another under a permutation of the coordinates with signs that
 * takes mass and stiffness to themselves. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>

#include "ricochet.h"

#if __has_include(<arb.h>) || __has_include(<flint/arb.h>)
#include "prove/twins.h"

static bool twins(const char *mass, const char *stiffness, const char *contacts, int a, int b)
{
    char text[1000];
    ric_study *study;
    snprintf(text, sizeof text, "model:\n  mass: %s\n  stiffness: %s\n  contacts:\n%s", mass,
             stiffness, contacts);
    assert_int_equal(ric_study_parse(text, "test", ".", &study), RIC_OK);
    const bool are = ric_twins_are(ric_study_model(study), a, b);
    assert_true(are == ric_twins_are(ric_study_model(study), b, a));
    ric_study_free(study);
    return are;
}

static const char unit[] = "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
                  row[] = "[[2, -1, 0], [-1, 2, -1], [0, -1, 2]]";
static const char pair[] = "    - {normal: [-1, 1, 0], clearance: 1, sides: both, law: rigid}\n"
                           "    - {normal: [0, -1, 1], clearance: 1, sides: both, law: rigid}\n";

static void a_row_of_masses_has_two_ends(void **state)
{
    (void)state;
    assert_true(twins(unit, row, pair, 0, 1));
    assert_false(twins(unit, "[[2, -1, 0], [-1, 2, -1], [0, -1, 2.0000000000000004]]", pair, 0, 1));
    assert_false(twins("[[1, 0, 0], [0, 1, 0], [0, 0, 1.0000000000000002]]", row, pair, 0, 1));
}

/* Coordinates that are counted the other way: x3 -> -x3. */
static void signs_are_found(void **state)
{
    (void)state;
    const char turned[] = "    - {normal: [-1, 1, 0], clearance: 1, sides: both, law: rigid}\n"
                          "    - {normal: [0, 1, 1], clearance: 1, sides: both, law: rigid}\n";
    assert_true(twins(unit, "[[2, -1, 0], [-1, 2, 1], [0, 1, 2]]", turned, 0, 1));
    assert_false(twins(unit, row, turned, 0, 1));
}

static void normals_and_clearances_count(void **state)
{
    (void)state;
    assert_false(twins(
        unit, row,
        "    - {normal: [-1, 1, 0], clearance: 1, sides: both, law: rigid}\n"
        "    - {normal: [0, -1, 1], clearance: 1.0000000000000002, sides: both, law: rigid}\n",
        0, 1));
    assert_false(twins(unit, row,
                       "    - {normal: [-1, 1, 0], clearance: 1, sides: both, law: rigid}\n"
                       "    - {normal: [0, -1, 1.5], clearance: 1, sides: both, law: rigid}\n",
                       0, 1));
    assert_false(twins(
        unit, row,
        "    - {normal: [-1, 1, 0], clearance: 1, sides: both, law: rigid}\n"
        "    - {normal: [0, -1, 1], clearance: 1, sides: both, law: bilinear, stiffness: 3}\n",
        0, 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_row_of_masses_has_two_ends),
        cmocka_unit_test(signs_are_found),
        cmocka_unit_test(normals_and_clearances_count),
    };
    return cmocka_run_group_tests_name("twins", tests, NULL, NULL);
}
#else
int main(void)
{
    return 77;
}
#endif
