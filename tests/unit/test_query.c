/* Duplicates, segments and fractal bases: counted on the article's two masses, against its
 * statements and against numbers computed elsewhere. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "close.h"

#define MOST 9 /* duplicates, as in Fig. 20 */

static const char model_text[] = "title: Two masses\n"
                                 "model:\n"
                                 "  mass: [[2, 0], [0, 1]]\n"
                                 "  stiffness: [[9, -1], [-1, 1]]\n"
                                 "  contacts:\n"
                                 "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n";

/* ------------------------------------------------------------------ helpers */

static ric_atlas *explore(const char *options)
{
    char text[1024];
    snprintf(text, sizeof text, "%sexplore: {%s}\n", model_text, options);
    return explore_text(text);
}

/* q up to 9 on the branches next to the linear modes; the window holds 8/9 of S2-. */
static ric_atlas *wide(void)
{
    return explore("energy: [0, 200], frequency: [0.2, 30], impacts: 2, multiply: 9, depth: 1");
}

/* Doublings of doublings; every branch has a base. */
static ric_atlas *deep(void)
{
    return explore("energy: [0, 200], frequency: [0.2, 10], impacts: 12, multiply: 2, depth: 2");
}

/* The one branch with a label. */
static ric_branch labelled(const ric_atlas *atlas, const char *label)
{
    ric_branch found = {0};
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch branch = branch_of(atlas, id);
        if (strcmp(branch.label, label)) continue;
        assert_int_equal(found.id, 0);
        found = branch;
    }
    assert_int_not_equal(found.id, 0);
    return found;
}

static int points_of(const ric_atlas *atlas, int id, int k, ric_duplicate_point **out)
{
    int n = -1;
    *out = calloc((size_t)branch_of(atlas, id).n_junction + 2, sizeof **out);
    assert_non_null(*out);
    assert_int_equal(ric_duplicate_points(atlas, id, k, &n, *out), RIC_OK);
    return n;
}

static int divisor(int a, int b)
{
    return b ? divisor(b, a % b) : a;
}

/* --------------------------------------------------------------- duplicates */

/* Section 3.2.1 of the article: k - 1 multiplications on every k-duplicate of S2-[01] and of
 * S2+[01], one for each j/k. */
static void backbones_have_one_less(void **state)
{
    static const char *const labels[] = {"S2-[01]", "S2+[01]"};
    ric_atlas *atlas = wide();
    (void)state;
    for (int i = 0; i < 2; i++)
        for (int k = 1; k <= MOST; k++) {
            const int id = labelled(atlas, labels[i]).id;
            bool seen[MOST + 1] = {false};
            ric_duplicate_point *points;
            int n = points_of(atlas, id, k, &points), count = 0;
            for (int p = 0; p < n; p++) {
                const ric_junction junction = junction_of(atlas, points[p].junction);
                const int j = points[p].j, common = j ? divisor(j, k) : 1;
                assert_int_equal(points[p].j > 0, junction.kind == RIC_KIND_MULTIPLICATION);
                assert_int_equal(points[p].origin, !j            ? RIC_DUPLICATE_COPY
                                                   : common == 1 ? RIC_DUPLICATE_OWN
                                                                 : RIC_DUPLICATE_INHERITED);
                if (!j) continue;
                assert_true(j < k && !seen[j]);
                seen[j] = true;
                count++;
                assert_int_equal(junction.rotation[0] * common, j);
                assert_int_equal(junction.rotation[1] * common, k);
                assert_relative(points[p].frequency, junction.frequency / common, 1e-15);
            }
            assert_int_equal(count, k - 1);
            free(points);
        }
    ric_atlas_free(atlas);
}

/* On A1[0] the first multiplication is on the 4-duplicate: before it they are on the inadmissible
 * part (Fig. 20c). */
static void tongue_starts_at_four(void **state)
{
    ric_atlas *atlas = wide();
    const int id = labelled(atlas, "A1[0]").id;
    (void)state;
    for (int k = 1; k <= 4; k++) {
        ric_duplicate_point *points;
        int n = points_of(atlas, id, k, &points), count = 0;
        for (int p = 0; p < n; p++) count += points[p].j > 0;
        assert_int_equal(count, k == 4);
        free(points);
    }
    ric_atlas_free(atlas);
}

/* Computed independently to 1e-9 or better: rotation number p/q on S2-[01], frequency of the
 * original, energy. */
static const struct {
    int q, p;
    double omega, energy;
} resonances[] = {
    {2, 1, 3.6000626807, 2.2556893214}, {3, 1, 3.0317165407, 1.8899969588},
    {3, 2, 5.0587142884, 3.8487372169}, {4, 1, 2.894565003, 1.8433727529},
    {4, 3, 6.6353971937, 6.3037444738}, {5, 1, 2.8396610567, 1.8319290484},
    {5, 2, 3.1989568372, 1.9736577763}, {5, 3, 4.3012701794, 2.9297465999},
    {5, 4, 8.2418979499, 9.5171204595},
};

static void resonances_are_where_they_should_be(void **state)
{
    ric_atlas *atlas = wide();
    const int id = labelled(atlas, "S2-[01]").id;
    (void)state;
    for (size_t i = 0; i < sizeof resonances / sizeof *resonances; i++)
        for (int times = 1; times * resonances[i].q <= MOST;
             times++) { /* also on the duplicates that inherit it */
            const int k = times * resonances[i].q;
            ric_duplicate_point *points;
            int n = points_of(atlas, id, k, &points), found = 0;
            for (int p = 0; p < n; p++) {
                if (points[p].j != times * resonances[i].p) continue;
                found++;
                assert_relative(points[p].energy, resonances[i].energy, 1e-9);
                assert_relative(points[p].frequency, resonances[i].omega / k, 1e-9);
            }
            assert_int_equal(found, 1);
            free(points);
        }
    ric_atlas_free(atlas);
}

/* G_{N,p} becomes G_{kN,kp}: the row names the junction that the atlas has there, reached from the
 * mode and from what leaves it alike. */
static void grazings_are_multiplied(void **state)
{
    ric_atlas *atlas = wide();
    const ric_branch mode = labelled(atlas, "S0-"), loop = labelled(atlas, "A1[0]");
    ric_duplicate_point *points;
    (void)state;
    for (int k = 1; k <= MOST; k++) {
        assert_int_equal(points_of(atlas, mode.id, k, &points), 1);
        const ric_junction junction = junction_of(atlas, points[0].junction);
        assert_int_equal(points[0].origin, RIC_DUPLICATE_COPY);
        assert_int_equal(points[0].times, k);
        assert_int_equal(junction.multiple, k);
        assert_relative(junction.frequency, junction_of(atlas, mode.to).frequency / k, 1e-15);
        free(points);
    }
    int n = points_of(atlas, loop.id, 3, &points);
    assert_int_equal(points[n - 1].times, 6); /* A1[0] ends at G_0,4, the 2-duplicate of G_0,2 */
    assert_int_equal(junction_of(atlas, points[n - 1].junction).multiple, 6);
    free(points);
    ric_atlas_free(atlas);
}

static void labels_are_those_of_the_article(void **state)
{
    static const struct {
        const char *label;
        int k;
        const char *wanted;
    } cases[] = {
        {"S2-[01]", 1, "S2-[01]"},
        {"S2-[01]", 3, "S2^{3-}[01]"},
        {"S0+", 2, "S0^{2+}"},
        {"A4[0011]", 12, "A4^{12}[0011]"},
        {"S2(3)[0.12]", 2, "S2^{2(3)}[0.12]"},
    };
    char text[32];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const ric_branch branch = {.label = cases[i].label};
        assert_int_equal(ric_duplicate_label(&branch, cases[i].k, sizeof text, text), RIC_OK);
        assert_string_equal(text, cases[i].wanted);
        assert_int_equal(ric_duplicate_label(&branch, cases[i].k, strlen(cases[i].wanted), text),
                         RIC_E_RANGE);
    }
}

/* ---------------------------------------------------------------- segments */

static void segments_make_up_the_branch(void **state)
{
    ric_atlas *atlas = deep();
    (void)state;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch branch = branch_of(atlas, id);
        double energy[2] = {INFINITY, -INFINITY}, frequency[2] = {INFINITY, -INFINITY};
        int n = -1, points = 0;
        ric_segment *segments = calloc((size_t)branch.n_junction + 1, sizeof *segments);
        assert_int_equal(ric_branch_segments(atlas, id, &n, segments), RIC_OK);
        assert_int_equal(n, branch.n_junction + 1);
        for (int i = 0; i < n; i++) {
            assert_int_equal(segments[i].branch, id);
            assert_int_equal(segments[i].from, i ? branch.junctions[i - 1] : branch.from);
            assert_int_equal(segments[i].to, i + 1 < n ? branch.junctions[i] : branch.to);
            energy[0] = fmin(energy[0], segments[i].energy[0]);
            energy[1] = fmax(energy[1], segments[i].energy[1]);
            frequency[0] = fmin(frequency[0], segments[i].frequency[0]);
            frequency[1] = fmax(frequency[1], segments[i].frequency[1]);
            points += segments[i].points;
        }
        assert_true(points <= branch.n_point - 2);
        assert_true(energy[0] <= branch.energy_min * (1 + 1e-9) &&
                    energy[1] >= branch.energy_max * (1 - 1e-9));
        assert_relative(frequency[0], branch.frequency_min, 1e-6);
        assert_relative(frequency[1], branch.frequency_max, 1e-6);
        free(segments);
    }
    ric_atlas_free(atlas);
}

/* "S6[010101] turns stable at C3_32 until the next critical point" (section 3.1): here the minimum
 * beside C1_33. */
static void stability_changes_between_segments(void **state)
{
    ric_atlas *atlas = deep();
    const ric_branch branch = labelled(atlas, "S6[010101]");
    ric_segment segments[8];
    int n, stable = 0;
    (void)state;
    assert_true(branch.n_junction < 8);
    assert_int_equal(ric_branch_segments(atlas, branch.id, &n, segments), RIC_OK);
    for (int i = 0; i < n; i++) {
        /* of the two points */
        const bool inside = segments[i].frequency[0] > 1.67392 &&
                            segments[i].frequency[1] < 1.686217;
        assert_true(segments[i].stable_fraction == (inside ? 1 : 0));
        stable += inside;
    }
    assert_int_equal(stable, 2); /* a doubling lies between */
    ric_atlas_free(atlas);
}

/* -------------------------------------------------------------------- bases */

static bool contains(const ric_base *base, int id)
{
    for (int i = 0; i < base->n_branch; i++)
        if (base->branches[i] == id) return true;
    return false;
}

/* The one base of a branch. */
static ric_base base_of(const ric_bases *bases, int id)
{
    ric_base found = {0}, base;
    for (int i = 0; !ric_bases_get(bases, i, &base); i++)
        if (contains(&base, id)) {
            assert_int_equal(found.j, 0);
            found = base;
        }
    return found;
}

static void every_branch_has_a_base(void **state)
{
    ric_atlas *atlas = deep();
    ric_bases *bases;
    ric_base base;
    (void)state;
    assert_int_equal(ric_bases_find(atlas, 0, &bases), RIC_OK);
    assert_int_equal(ric_bases_largest(bases), 4); /* doublings of doublings */
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        assert_int_not_equal(base_of(bases, id).j, 0);
    for (int i = 0; i < ric_bases_n(bases); i++) {
        assert_int_equal(ric_bases_get(bases, i, &base), RIC_OK);
        for (int k = 0; k < base.n_duplicate; k++) /* A^k{F^j} lies in F^jk */
            assert_int_equal(base_of(bases, base.duplicates[2 * k]).j * base.duplicates[2 * k + 1],
                             base.j);
    }
    assert_int_equal(ric_bases_get(bases, ric_bases_n(bases), &base), RIC_E_RANGE);
    ric_bases_free(bases);
    assert_int_equal(ric_bases_find(atlas, 65, &bases), RIC_E_RANGE);
    assert_null(bases);
    ric_atlas_free(atlas);
}

/* Section 3.2.2: the elementary structure is F_1^1, F_2^1 and F_2^2. S6, S4 and what else leaves
 * G1_2,4 is in the first, the backbone S2- alone in the second, the closed loop of Fig. 17 in the
 * third; doublings on the loop are in F_2^4, those on S6 in F_1^2. */
static void elementary_structure(void **state)
{
    static const struct {
        const char *label;
        int mode, j;
    } members[] = {
        {"S0+", 1, 1},      {"S2+[01]", 1, 1},  {"S6[010101]", 1, 1},
        {"S4[0011]", 1, 1}, {"A4[0001]", 1, 1}, {"S0-", 2, 1},
        {"S2-[01]", 2, 1},  {"A1[0]", 2, 2},    {NULL, 0, 0},
    };
    ric_atlas *atlas = deep();
    ric_bases *bases;
    int count = 0, modes[3][5] = {{0}};
    (void)state;
    assert_int_equal(ric_bases_find(atlas, 0, &bases), RIC_OK);
    for (int i = 0; members[i].mode; i++) {
        const int id = labelled(atlas, members[i].label).id;
        assert_int_equal(base_of(bases, id).mode, members[i].mode);
        assert_int_equal(base_of(bases, id).j, members[i].j);
    }
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_base base = base_of(bases, id);
        const bool elementary = base.j == 1 || (base.mode == 2 && base.j == 2);
        assert_int_equal(ric_bases_elementary(bases, id), elementary);
        count += elementary;
        modes[base.mode][base.j]++;
    }
    assert_int_equal(modes[2][1], 2); /* linear mode and backbone */
    assert_int_equal(modes[2][2], 7); /* Fig. 17 */
    assert_int_equal(count, modes[1][1] + 2 + 7);
    assert_false(ric_bases_elementary(bases, 0));
    ric_bases_free(bases);
    ric_atlas_free(atlas);
}

/* S6[010101] meets S2^{3-} at C1_33 and is in F_1^1; what leaves S2^{3-} at 1/3 is in F_2^3. A path
 * that passed the backbone would join them, and F_2^3 leaves out what is in F_1^1. */
static void bases_of_triplings(void **state)
{
    ric_atlas *atlas = explore(
        "energy: [0, 100], frequency: [0.6, 10], impacts: 6, multiply: 3, depth: 2");
    const ric_branch backbone = labelled(atlas, "S2-[01]"), chatter = labelled(atlas, "S6[010101]");
    ric_bases *bases;
    int chatters = 0, loops = 0;
    (void)state;
    assert_int_equal(ric_bases_find(atlas, 0, &bases), RIC_OK);
    for (int i = 0; i < backbone.n_junction; i++) {
        const ric_junction junction = junction_of(atlas, backbone.junctions[i]);
        if (junction.multiple != 3) continue;
        for (int k = 0; k < junction.n_branch; k++) {
            const int id = junction.branches[k];
            if (id == backbone.id) continue;
            const ric_base base = base_of(bases, id);
            const bool chattering = id == chatter.id;
            assert_int_equal(junction.rotation[0], chattering ? 2 : 1);
            assert_int_equal(base.mode, chattering ? 1 : 2);
            assert_int_equal(base.j, chattering ? 1 : 3);
            chatters += chattering;
            loops += !chattering;
        }
    }
    assert_int_equal(chatters, 1);
    assert_int_equal(loops, 2);
    ric_bases_free(bases);
    ric_atlas_free(atlas);
}

/* Duplicates of a grazing do not count as the mode's own: one backbone a mode, which starts where
 * the mode ends. */
static void one_backbone_a_mode(void **state)
{
    ric_atlas *atlas = deep();
    int n = 0;
    (void)state;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch branch = branch_of(atlas, id);
        if (!branch.mode) continue;
        n++;
        const int at = branch.impacts ? branch.from : branch.to;
        assert_int_equal(junction_of(atlas, at).kind, RIC_KIND_GRAZING);
        assert_int_equal(junction_of(atlas, at).multiple, 1);
    }
    assert_int_equal(n, 4);
    ric_atlas_free(atlas);
}

/* The word of a duplicated grazing is that of the orbit, touches left out, however often it is gone
 * through. */
static void duplicated_grazings_have_the_word_once(void **state)
{
    ric_atlas *atlas = deep();
    int n = 0;
    (void)state;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        const ric_junction junction = junction_of(atlas, id);
        double period = 0;
        if (junction.kind != RIC_KIND_GRAZING || junction.multiple == 1) continue;
        n++;
        for (int i = 0; i < (junction.impacts ? junction.impacts : 1); i++)
            period += junction.flights[i];
        assert_relative(junction.frequency * junction.multiple * period, 2 * acos(-1), 1e-12);
    }
    assert_true(n > 5);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(backbones_have_one_less),
        cmocka_unit_test(tongue_starts_at_four),
        cmocka_unit_test(resonances_are_where_they_should_be),
        cmocka_unit_test(grazings_are_multiplied),
        cmocka_unit_test(labels_are_those_of_the_article),
        cmocka_unit_test(segments_make_up_the_branch),
        cmocka_unit_test(stability_changes_between_segments),
        cmocka_unit_test(every_branch_has_a_base),
        cmocka_unit_test(elementary_structure),
        cmocka_unit_test(bases_of_triplings),
        cmocka_unit_test(one_backbone_a_mode),
        cmocka_unit_test(duplicated_grazings_have_the_word_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
