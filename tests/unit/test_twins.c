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

/* The permutations of a whole structure; how many. */
static int all(const char *stiffness, const char *contacts, int faces[8][4])
{
    char text[1000];
    ric_study *study;
    int n = 0;
    snprintf(text, sizeof text, "model:\n  mass: %s\n  stiffness: %s\n  contacts:\n%s", unit,
             stiffness, contacts);
    assert_int_equal(ric_study_parse(text, "test", ".", &study), RIC_OK);
    const ric_model *m = ric_study_model(study);
    struct ric_twin_list *list = ric_twins_create();
    for (const ric_twin *twin; (twin = ric_twins_get(list, m, n)); n++) {
        assert_true(n < 8);
        for (int i = 0; i < 3; i++) {
            assert_int_equal(twin->to[twin->to[i]], i);
            assert_int_equal(twin->sign[twin->to[i]], twin->sign[i]);
        }
        for (int f = 0; f < m->n_face && f < 4; f++) faces[n][f] = twin->face[f];
    }
    ric_twins_free(list);
    ric_study_free(study);
    return n;
}

/* Left and right, either by itself or with x -> -x: faces +left, -left, +right, -right. */
static void a_whole_structure_has_images(void **state)
{
    (void)state;
    static const int one[4] = {3, 2, 1, 0}, other[4] = {2, 3, 0, 1};
    int faces[8][4];
    assert_int_equal(all(row, pair, faces), 2);
    const bool first = faces[0][0] == 3;
    assert_memory_equal(faces[!first], one, sizeof one);
    assert_memory_equal(faces[first], other, sizeof other);
    assert_int_equal(all("[[2, -1, 0], [-1, 2, -1], [0, -1, 2.0000000000000004]]", pair, faces), 0);
}

/* Every stop needs an image: a third one takes it away, and so does one side of both. */
static void every_stop_counts(void **state)
{
    (void)state;
    int faces[8][4];
    char text[500];
    snprintf(text, sizeof text, "%s%s", pair,
             "    - {normal: [1, 0, 0], clearance: 3, sides: both, law: rigid}\n");
    assert_int_equal(all(row, text, faces), 0);
    assert_int_equal(all(row,
                         "    - {normal: [-1, 1, 0], clearance: 1, sides: upper, law: rigid}\n"
                         "    - {normal: [0, -1, 1], clearance: 1, sides: upper, law: rigid}\n",
                         faces),
                     1);
    assert_int_equal(faces[0][0], 1);
    assert_int_equal(all(row,
                         "    - {normal: [-1, 1, 0], clearance: 1, sides: both, law: rigid}\n"
                         "    - {normal: [0, -1, 1], clearance: 1.25, sides: both, law: rigid}\n",
                         faces),
                     0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_whole_structure_has_images), cmocka_unit_test(every_stop_counts),
        cmocka_unit_test(a_row_of_masses_has_two_ends), cmocka_unit_test(signs_are_found),
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
