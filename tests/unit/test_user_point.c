/* Energies and frequencies that a study asks for: every passage of every branch is a junction, and
 * nothing else is. */
#define _GNU_SOURCE
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "explored.h"

#define PI 3.14159265358979323846
#define LEAST_ENERGY 0.5935887039620914 /* of S2+, computed elsewhere with 40 digits */
#define BRANCH_POINT 1.3820239896966182 /* frequency of C1_32, and of all of A2 */

static const char model[] = "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
                            "  contacts: [{normal: [-1, 1], clearance: 1}]\n";

/* `text` [1000]: a study with these options. */
static const char *text_with(const char *options, char *text)
{
    snprintf(text, 1000, "%sexplore: {multiply: 1, %s}\n", model, options);
    return text;
}

static ric_atlas *explore(const char *options, double max_step, ric_store *store)
{
    char text[1000];
    return explore_text_with(text_with(options, text), store, max_step);
}

/* Junctions of kind user on a branch within a relative distance of an energy or a frequency. */
static int count_near(const ric_atlas *atlas, const ric_branch *b, bool frequency, double value,
                      double off)
{
    int count = 0;
    for (int k = 0; k < b->n_junction; k++) {
        ric_junction j = junction_of(atlas, b->junctions[k]);
        count += j.kind == RIC_KIND_USER &&
                 fabs((frequency ? j.frequency : j.energy) / value - 1) < off;
    }
    return count;
}

static int count_users(const ric_atlas *atlas, const ric_branch *b, bool frequency, double value)
{
    return count_near(atlas, b, frequency, value, 1e-13);
}

/* How often the stored points of a branch go from one side of a value to the other; those on it are
 * junctions' own. */
static int count_passages(const ric_atlas *atlas, int branch, bool frequency, double value)
{
    int count = 0;
    double before = 0;
    for (int i = 0; i < branch_of(atlas, branch).n_point; i++) {
        ric_point p;
        assert_int_equal(ric_atlas_point(atlas, branch, i, &p, NULL, NULL), RIC_OK);
        double off = (frequency ? p.frequency : p.energy) / value - 1;
        if (fabs(off) < 1e-12) continue;
        count += before * off < 0;
        before = off;
    }
    return count;
}

#define MANY "at_energy: [0.594, 0.5, 3.8487, 10, 30], at_frequency: [1.5, 1.51, 1.68]"
static const double asked[2][5] = {{0.594, 0.5, 3.8487, 10, 30}, {1.5, 1.51, 1.68, NAN, NAN}};

static void every_passage_is_a_junction(void **state)
{
    (void)state;
    ric_atlas *atlas = explore("depth: 3, " MANY, 0, NULL);
    int sum = 0, users = 0, most = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        for (int k = 0; k < 10; k++) {
            double value = asked[k / 5][k % 5];
            ric_branch b = branch_of(atlas, id);
            int found = isnan(value) ? 0 : count_users(atlas, &b, k / 5, value),
                passed = isnan(value) ? 0 : count_passages(atlas, id, k / 5, value);
            if (found != passed)
                fail_msg("%d %s: %g is passed %d times and found %d times", id, b.label, value,
                         passed, found);
            sum += found;
            most = found > most ? found : most;
        }
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        if (j.kind != RIC_KIND_USER) continue;
        users++;
        assert_int_equal(j.n_branch, 1);
        assert_int_equal(j.label[0], 'U');
        assert_int_equal(j.departures.taken + j.departures.known + j.departures.over_budget +
                             j.departures.refused,
                         0);
    }
    assert_int_equal(sum, users);
    assert_true(users > 30 && most == 2);
    for (int k = 0; k < 3; k++) {
        static const char *const labels[] = {"S2+[01]", "S2-[01]", "S6[010101]"};
        ric_branch b = branch_of(atlas, branch_named(atlas, labels[k]));
        assert_int_equal(count_users(atlas, &b, false, 10), k == 2 ? 2 : 1);
    }
    ric_atlas_free(atlas);
}

/* c_i^2 = (8 - 3 L) / (11 - 4 L) at L = omega_i^2, the zeros of 2 L^2 - 11 L + 8 = det(K - L M);
 * energy of S2[01] at omega. */
static double s2_energy(double omega)
{
    double top = 0, F = 0;
    for (int i = 0; i < 2; i++) {
        double L = (11 + (i ? 1 : -1) * sqrt(57)) / 4, cc = (8 - 3 * L) / (11 - 4 * L),
               x = sqrt(L) * PI / (2 * omega);
        top += cc / (cos(x) * cos(x));
        F += cc * tan(x) / sqrt(L);
    }
    return top / (2 * F * F);
}

static void those_of_two_impacts_have_a_closed_form(void **state)
{
    (void)state;
    ric_atlas *atlas = explore("depth: 1, " MANY, 0, NULL);
    int count = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        if (j.kind != RIC_KIND_USER || j.impacts != 2) continue;
        double closed = s2_energy(j.frequency);
        if (!(fabs(j.energy / closed - 1) < 1e-12))
            fail_msg("%s: omega %.17g, E %.17g, closed form %.17g", j.label, j.frequency, j.energy,
                     closed);
        count++;
    }
    assert_int_equal(count, 9); /* seven on S2+, the lowest energy twice, and two on S2- */
    ric_atlas_free(atlas);
}

static void they_do_not_depend_on_the_step(void **state)
{
    (void)state;
    ric_atlas *usual = explore("depth: 3, " MANY, 0, NULL);
    static const double steps[] = {0.007, 0.013, 0.1, 0.5};
    for (int i = 0; i < 4; i++) {
        ric_atlas *atlas = explore("depth: 3, " MANY, steps[i], NULL);
        assert_int_equal(ric_atlas_n_junction(usual), ric_atlas_n_junction(atlas));
        for (int id = 1; id <= ric_atlas_n_junction(usual); id++) {
            ric_junction a = junction_of(usual, id), b = junction_of(atlas, id);
            bool same = a.kind == b.kind && fabs(a.energy / b.energy - 1) < 1e-12 &&
                        fabs(a.frequency / b.frequency - 1) < 1e-12;
            for (int k = 0; k < 4 && a.kind == RIC_KIND_USER; k++)
                same = same && fabs(a.state[k] - b.state[k]) < 1e-11;
            if (!same || strcmp(a.label, b.label))
                fail_msg("step %g: %s at E %.15g, omega %.15g becomes %s at E %.15g, omega %.15g",
                         steps[i], a.label, a.energy, a.frequency, b.label, b.energy, b.frequency);
        }
        ric_atlas_free(atlas);
    }
    ric_atlas_free(usual);
}

/* A value close to an extremum is passed on both sides of it, in one step, however large; on its
 * other side it is not met. */
static void both_sides_of_an_extremum(void **state)
{
    (void)state;
    for (double step = 0.03; step < 1; step *= 3)
        for (int digits = 2; digits <= 8; digits++)
            for (int side = -1; side <= 1; side += 2) {
                char options[100];
                double value = LEAST_ENERGY * (1 + side * pow(10, -digits));
                snprintf(options, sizeof options, "start: [1], depth: 1, at_energy: [%.17g]",
                         value);
                ric_atlas *atlas = explore(options, step, NULL);
                ric_branch b = branch_of(atlas, branch_named(atlas, "S2+[01]"));
                /* from 0.6016 down to the extremum and up */
                int found = count_users(atlas, &b, false, value);
                if (found != (side > 0 ? 2 : 0))
                    fail_msg("step %g: extremum %+d 1e-%d: %d passages", step, side, digits, found);
                ric_atlas_free(atlas);
            }
}

/* S6 passes its minimum 3.8486931745366952 and the threefold S2- at 3.8487372168924985 within one
 * short step, where equations cannot be solved: values around both are found on either side of the
 * minimum, on S6 to rounding over the distance. */
static void beside_a_branch_point(void **state)
{
    (void)state;
    static const double parts[] = {1e-3, 0.03, 0.3, 0.7, 0.97, 0.999, 1.001, 1.03, 1.5, 3, 10, 100};
    enum { N = sizeof parts / sizeof *parts };
    char options[400] = "depth: 2, at_energy: [";
    double least = 3.8486931745366952, value[N];
    for (int i = 0; i < N; i++) {
        value[i] = least + parts[i] * (3.8487372168924985 - least);
        snprintf(options + strlen(options), sizeof options - strlen(options), "%s%.17g",
                 i ? ", " : "", value[i]);
    }
    strcat(options, "]");
    for (double step = 0.01; step < 1; step *= 1.7) {
        ric_atlas *atlas = explore(options, step, NULL);
        ric_branch s2 = branch_of(atlas, branch_named(atlas, "S2-[01]")),
                   s6 = branch_of(atlas, branch_named(atlas, "S6[010101]"));
        for (int i = 0; i < N; i++) {
            int on_s2 = count_users(atlas, &s2, false, value[i]),
                on_s6 = count_near(atlas, &s6, false, value[i], 1e-9);
            if (on_s2 != 1 || on_s6 != 2)
                fail_msg("step %g: E %.17g (part %g): %d on S2-, %d on S6", step, value[i],
                         parts[i], on_s2, on_s6);
        }
        ric_atlas_free(atlas);
    }
}

static void linear_modes_pass_energies_only(void **state)
{
    (void)state;
    ric_atlas *atlas =
        explore("depth: 0, at_energy: [0.3, 1, 5], at_frequency: [0.9, 0.92873106504644953]", 0,
                NULL);
    static const int counts[2] = {1, 2}; /* they touch at 0.60 and 2.96 */
    for (int mode = 0; mode < 2; mode++) {
        ric_branch b = branch_of(atlas, branch_named(atlas, mode ? "S0-" : "S0+"));
        assert_int_equal(b.n_junction, counts[mode]);
        for (int k = 0; k < b.n_junction; k++) {
            ric_junction j = junction_of(atlas, b.junctions[k]);
            double energy = ric_model_energy(ric_atlas_model(atlas), j.state, j.state + 2);
            assert_true(j.kind == RIC_KIND_USER && j.energy == (k ? 1 : 0.3) && j.impacts == 0);
            assert_true(fabs(energy / j.energy - 1) < 1e-14 &&
                        fabs(b.junction_at[k] * b.frequency_min - sqrt(2 * j.energy)) < 1e-14);
            assert_true(fabs(j.flights[0] * j.frequency - 2 * PI) < 1e-14 &&
                        j.frequency == b.frequency_min);
            assert_true(j.n_branch == 1 && j.branches[0] == b.id);
        }
    }
    ric_atlas_free(atlas);
}

/* The frequency of a horizontal branch is passed by the branch that crosses, not by itself. */
static void a_horizontal_branch_passes_nothing(void **state)
{
    (void)state;
    for (int off = -2; off <= 2; off++) {
        char options[100];
        double value = BRANCH_POINT * (1 + off * 2e-16);
        snprintf(options, sizeof options, "depth: 2, at_frequency: [%.17g]", value);
        ric_atlas *atlas = explore(options, 0, NULL);
        ric_branch a2 = branch_of(atlas, branch_named(atlas, "A2[01]")),
                   s2 = branch_of(atlas, branch_named(atlas, "S2+[01]"));
        assert_int_equal(count_users(atlas, &a2, true, value), 0);
        assert_int_equal(count_users(atlas, &s2, true, value), 1);
        ric_atlas_free(atlas);
    }
}

/* An atlas that is asked for more ends as if all had been asked for at once, and again without
 * computing anything. */
static void an_atlas_is_extended(void **state)
{
    (void)state;
    char folder[] = "/tmp/ricochet-asked-XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/a", folder);
    ric_atlas *whole = explore("depth: 2, " MANY, 0, NULL);
    static const char *const options[] = {"depth: 2", "depth: 2, at_energy: [10]",
                                          "depth: 2, " MANY, "depth: 2, " MANY};
    for (int i = 0; i < 4; i++) {
        char text[1000];
        ric_study *study = NULL;
        ric_store *store = NULL;
        if (ric_study_parse(text_with(options[i], text), "study", ".", &study))
            fail_msg("%s", ric_detail());
        if (ric_store_open(path, study, &store)) fail_msg("%s", ric_detail());
        ric_atlas *atlas = explore(options[i], 0, store);
        assert_int_equal(ric_store_write(store, atlas, 1), RIC_OK);
        for (int id = 1; i >= 2 && id <= ric_atlas_n_junction(whole); id++) {
            ric_junction a = junction_of(whole, id), b = junction_of(atlas, id);
            assert_true(a.kind == b.kind && a.energy == b.energy && a.frequency == b.frequency &&
                        !strcmp(a.label, b.label));
        }
        if (i >= 2) assert_int_equal(ric_atlas_n_junction(whole), ric_atlas_n_junction(atlas));
        ric_atlas_free(atlas);
        ric_store_close(store);
        ric_study_free(study);
    }
    ric_atlas *read_back = NULL;
    assert_int_equal(ric_atlas_read(path, &read_back), RIC_OK);
    assert_int_equal(ric_atlas_n_junction(whole), ric_atlas_n_junction(read_back));
    ric_atlas_free(read_back);
    ric_atlas_free(whole);
    unlink(path);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_passage_is_a_junction),
        cmocka_unit_test(those_of_two_impacts_have_a_closed_form),
        cmocka_unit_test(they_do_not_depend_on_the_step),
        cmocka_unit_test(both_sides_of_an_extremum),
        cmocka_unit_test(linear_modes_pass_energies_only),
        cmocka_unit_test(a_horizontal_branch_passes_nothing),
        cmocka_unit_test(an_atlas_is_extended),
        cmocka_unit_test(beside_a_branch_point),
    };
    return cmocka_run_group_tests_name("asked", tests, NULL, NULL);
}
