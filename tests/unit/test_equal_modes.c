/* Structures with modes of one frequency, or all but one: under power laws no branch starts at what
 * the springs mix, and that is said; what is stored are orbits. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"

static const char options[] = "explore: {energy: [0, 1], frequency: [0.5, 6], depth: 1}\n";
static const char two[] = "mass: [[1, 0], [0, 1]], stiffness: [[2, 0], [0, 2]]";
static const char four[] = "mass: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "
                           "stiffness: [[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 5, 0], [0, 0, 0, 9]]";

static void says(const char *structure, const char *contacts, const char *reason, int refused,
                 bool others)
{
    char text[1024];
    snprintf(text, sizeof text, "title: equal modes\nmodel: {%s, contacts: [%s]}\n%s", structure,
             contacts, options);
    ric_atlas *atlas = explore_text(text);
    int said = 0;
    for (int j = 1; j <= ric_atlas_n_junction(atlas); j++) {
        const ric_junction junction = junction_of(atlas, j);
        said += junction.departures.refused > 0 && strstr(junction.refusal, reason);
    }
    assert_int_equal(said, refused);
    assert_int_equal(ric_atlas_n_branch(atlas) > 0, others);
    ric_atlas_free(atlas);
}

static void mixed_modes_say_so(void **state)
{
    (void)state;
    says(two,
         "{normal: [1, 0], law: power, exponent: 5, length: 1, reference: 1},"
         " {normal: [1, -1], law: power, exponent: 7, length: 1, reference: 1}",
         "its frequency is that of mode", 2, false);
}

static void the_others_are_followed(void **state)
{
    (void)state;
    says(four,
         "{normal: [1, 0, 1, 0], law: power, exponent: 5, length: 1, reference: 1},"
         " {normal: [1, -1, 0, 1], law: power, exponent: 3, length: 1, reference: 1}",
         "its frequency is that of mode", 2, true);
}

static void parts_say_so(void **state)
{
    (void)state;
    says(two,
         "{normal: [1, 0], law: power, exponent: 5, length: 1, reference: 1},"
         " {normal: [0, 1], law: power, exponent: 7, length: 1, reference: 1}",
         "the structure falls into parts", 2, false);
}

/* Two modes whose frequencies differ by less than the springs change them at the lowest energy of a
 * branch: the motion there is a mixture, and each has its branch from that energy on, not from
 * nothing. */
static void near_modes_have_branches(void **state)
{
    (void)state;
    const double lowest = 1e-6, apart[] = {1e-8, 1e-7, 4e-7, 1e-6, 3e-6},
                 aside[] = {0.6, 0.3, -0.9};
    for (int i = 0; i < 15; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "title: near modes\nmodel: {mass: [[1, 0], [0, 1]], stiffness: [[1, 0], [0, "
                 "%.17g]], contacts: "
                 "[{normal: [1, %g], law: power, exponent: 3, length: 1, reference: 1}]}\n%s",
                 1 + apart[i % 5], aside[i / 5], options);
        ric_atlas *atlas = explore_text(text);
        assert_int_equal(ric_atlas_n_branch(atlas), 2);
        for (int id = 1; id <= 2; id++) {
            const ric_branch branch = branch_of(atlas, id);
            assert_true(branch.energy_min > lowest * (1 - 1e-6));
            for (int k = 0; k < branch.n_point; k++) point_passes(atlas, id, k);
        }
        ric_atlas_free(atlas);
    }
}

/* Of two modes 8e-13 apart one comes to have the spring for itself and the other none of it, at the
 * lowest energies: each has its branch in whatever order the coordinates come. A start that
 * rounding had put below the window went on to rest, and a kernel without a sign was taken for a
 * junction. */
static void orders_of_coordinates_have_the_same_branches(void **state)
{
    (void)state;
    static const double mass[4][4] = {{1.234375, -0.296875, 0.171875, -0.328125},
                                      {-0.296875, 1.40625, -0.265625, 0.4375},
                                      {0.171875, -0.265625, 1.46875, -0.265625},
                                      {-0.328125, 0.4375, -0.265625, 2.53125}},
                        stiffness[4][4] = {{1.821317725247347, -0.9283491548175783,
                                            1.1313345902990561, -0.16158959343632714},
                                           {-0.9283491548175783, 3.2001303121506535,
                                            -3.396279143570664, -0.04693590227559686},
                                           {1.1313345902990561, -3.396279143570664,
                                            6.988071561697629, 0.5813671043022718},
                                           {-0.16158959343632714, -0.04693590227559686,
                                            0.5813671043022718, 2.6621152552641036}};
    const double(*matrix[])[4] = {mass, stiffness};
    for (int k = 0; k < 8; k++) {
        char text[2048] = "title: orders\nmodel:\n";
        size_t used = strlen(text);
        int order[4];
        for (int i = 0; i < 4; i++) order[i] = k < 4 ? (i + k) % 4 : (7 - k + 4 - i) % 4;
        for (int a = 0; a < 2; a++) {
            used += (size_t)snprintf(text + used, sizeof text - used, "  %s: [",
                                     a ? "stiffness" : "mass");
            for (int i = 0; i < 16; i++)
                used += (size_t)snprintf(text + used, sizeof text - used, "%s%.17g%s",
                                         i % 4 ? ", " : "[", matrix[a][order[i / 4]][order[i % 4]],
                                         i % 4 < 3 ? ""
                                         : i < 15  ? "], "
                                                   : "]]\n");
        }
        snprintf(text + used, sizeof text - used,
                 "  contacts: [{normal: [%d, %d, %d, %d], law: power, exponent: 5, stiffness: "
                 "8.558}]\n"
                 "explore: {energy: [0, 11.77], frequency: [0.2, 7.245], multiply: 1, depth: 1}\n",
                 order[0] == 1, order[1] == 1, order[2] == 1, order[3] == 1);
        ric_atlas *atlas = explore_text(text);
        assert_int_equal(ric_atlas_n_branch(atlas), 4);
        for (int id = 1; id <= 4; id++)
            for (int p = 0; p < branch_of(atlas, id).n_point; p += 8) point_passes(atlas, id, p);
        for (int j = 1; j <= ric_atlas_n_junction(atlas); j++)
            assert_int_equal(junction_of(atlas, j).departures.refused, 0);
        ric_atlas_free(atlas);
    }
}

/* Two frequencies from a rounding to a millionth apart: what is taken for equal is so to what the
 * replay finds in an orbit, and the others are orbits of their own modes, however near those are.
 */
static void near_modes_are_no_equal_ones(void **state)
{
    (void)state;
    const double apart[] = {1e-15, 3e-14, 1e-13, 3e-13, 1e-12, 3e-12, 9e-12, 3e-11, 1e-9, 1e-6};
    const char *law[] = {"rigid, clearance: 1", "bilinear, clearance: 1, stiffness: 5",
                         "power, exponent: 5, length: 1, reference: 1"};
    for (int i = 0; i < 30; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "title: near modes\nmodel: {mass: [[1, 0], [0, 1]], stiffness: [[1, 0], [0, "
                 "%.17g]], contacts: "
                 "[{normal: [1, 0.6], law: %s}]}\n"
                 "explore: {energy: [0, 3], frequency: [0.2, 3], depth: 1, impacts: 3}\n",
                 1 + apart[i % 10], law[i / 10]);
        ric_atlas *atlas = explore_text(text);
        const int branches = ric_atlas_n_branch(atlas);
        assert_true(branches > 0);
        for (int id = 1; id <= branches; id++)
            for (int k = 0; k < branch_of(atlas, id).n_point; k++) point_passes(atlas, id, k);
        ric_atlas_free(atlas);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mixed_modes_say_so),
        cmocka_unit_test(the_others_are_followed),
        cmocka_unit_test(parts_say_so),
        cmocka_unit_test(near_modes_have_branches),
        cmocka_unit_test(orders_of_coordinates_have_the_same_branches),
        cmocka_unit_test(near_modes_are_no_equal_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
