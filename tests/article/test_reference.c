/* The atlas of the article's model against numbers computed elsewhere: junctions, ends and depths
 * of the branches; the same for any step length and in any system of units; departures that add up.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "sample.h"

#define STUDY "examples/elementary/study.yaml"

typedef struct {
    const char *name;
    ric_kind kind;
    double omega, energy;
    int impacts, grazings, multiple, rotation[2], a, b;
    const char *word;
    int candidates; /* ways out up to symmetry */
} expected;

/* Computed independently in two formulations, many with 40 digits: relative accuracy 1e-9 or
 * better. The candidates are subsets of the touches up to the symmetries of the orbit, counted by
 * hand: two touches that are images of one another give 3, four give 7. */
static const expected reference[] = {
    {"G1_0,2", RIC_KIND_GRAZING, 0.9287310650464, 0.601588369489, 0, 2, 1, {0, 0}, 0, 0, "", 3},
    {"G2_0,2", RIC_KIND_GRAZING, 2.153475936438, 2.960911630511, 0, 2, 1, {0, 0}, 0, 0, "", 3},
    {"C1_31",
     RIC_KIND_EXTREMUM,
     0.9615592867033224,
     0.5935887039620914,
     2,
     0,
     1,
     {0, 0},
     3,
     1,
     "01",
     0},
    {"C2_31",
     RIC_KIND_EXTREMUM,
     2.7537248237692933,
     1.8245662467804078,
     2,
     0,
     1,
     {0, 0},
     3,
     1,
     "01",
     0},
    {"C1_32",
     RIC_KIND_BRANCH_POINT,
     1.3820239896966182,
     1.901327637945699,
     2,
     0,
     1,
     {0, 0},
     3,
     2,
     "01",
     2},
    {"G1_2,2",
     RIC_KIND_GRAZING,
     1.3820239896966182,
     2.5197414093965973,
     2,
     2,
     1,
     {0, 0},
     0,
     0,
     "01",
     3},
    {"G1_2,4",
     RIC_KIND_GRAZING,
     1.6667902994358654,
     80.97406747026484,
     2,
     4,
     1,
     {0, 0},
     0,
     0,
     "01",
     7},
    {"G2_4,2", RIC_KIND_GRAZING, 1.680665446, 28.644438205, 4, 2, 1, {0, 0}, 0, 0, "0101", 3},
    {"G1_4,2",
     RIC_KIND_GRAZING,
     1.6983835151921738,
     18.968887538984884,
     4,
     2,
     1,
     {0, 0},
     0,
     0,
     "0011",
     3},
    {"C3_32",
     RIC_KIND_BRANCH_POINT,
     1.673922264624197,
     22.98740319908438,
     6,
     0,
     1,
     {0, 0},
     3,
     2,
     "010101",
     2},
    {"S6 minimum",
     RIC_KIND_EXTREMUM,
     1.6862160212567914,
     3.8486931745366952,
     6,
     0,
     1,
     {0, 0},
     3,
     1,
     "010101",
     0},
    {"C1_33",
     RIC_KIND_MULTIPLICATION,
     1.6862380961394556,
     3.8487372168924985,
     2,
     0,
     3,
     {2, 3},
     3,
     3,
     "01",
     2},
    {"C2_32",
     RIC_KIND_BRANCH_POINT,
     1.6667902994358654,
     16.13227945265392,
     4,
     0,
     1,
     {0, 0},
     3,
     2,
     "0011",
     2},
    {"C3_31",
     RIC_KIND_EXTREMUM,
     1.5192560925039564,
     9.158308399286632,
     4,
     0,
     1,
     {0, 0},
     3,
     1,
     "0011",
     0},
    {"C4_32",
     RIC_KIND_BRANCH_POINT,
     1.5319867157145204,
     15.557457022590903,
     4,
     0,
     1,
     {0, 0},
     3,
     2,
     "0011",
     2},
    {"A5 C21",
     RIC_KIND_EXTREMUM,
     1.679212540627532,
     28.55821023511334,
     5,
     0,
     1,
     {0, 0},
     2,
     1,
     "00101",
     0},
};
enum { N_REFERENCE = sizeof reference / sizeof *reference };

/* Ends in either order, NULL: the window. `through`: junctions of the table passed, in any order.
 */
typedef struct {
    const char *label, *end[2], *through[5];
    int depth;
    bool symmetric, reversible;
} edge;

static const edge edges[] = {
    {"S0+", {NULL, "G1_0,2"}, {NULL}, 0, true, true},
    {"S0-", {NULL, "G2_0,2"}, {NULL}, 0, true, true},
    {"S2+[01]", {"G1_0,2", "G1_2,4"}, {"C1_31", "C1_32"}, 1, true, true},
    {"S2-[01]", {"G2_0,2", NULL}, {"C2_31", "C1_33"}, 1, true, true},
    {"A2[01]", {"C1_32", "G1_2,2"}, {NULL}, 2, false, true},
    {"A3[001]", {"G1_2,2", "G1_2,4"}, {NULL}, 2, false, false},
    {"A4[0001]", {"G1_2,2", "G1_2,4"}, {NULL}, 2, false, true},
    {"S4[0011]", {"C2_32", "G1_2,4"}, {NULL}, 2, true, false},
    {"A4[0101]", {"G2_4,2", "G1_2,4"}, {NULL}, 2, false, true},
    {"A5[00101]", {"G2_4,2", "G1_2,4"}, {"A5 C21"}, 2, false, false},
    {"S6[010101]", {"G1_4,2", "G1_2,4"}, {"C1_33", "S6 minimum", "C3_32"}, 2, true, true},
    {"S4[0011]", {"G1_4,2", NULL}, {"C2_32", "C3_31", "C4_32"}, 3, true, true},
    {"A6[010101]", {"C3_32", "G2_4,2"}, {NULL}, 3, false, true},
};
enum { N_EDGE = sizeof edges / sizeof *edges };

/* ------------------------------------------------------------------ helpers */

/* Explores a study in memory; max_step 0: the study's own. */
static ric_atlas *explore(const ric_study *study, double max_step, ric_graph **graph)
{
    ric_graph *g = NULL;
    ric_atlas *atlas = NULL;
    assert_int_equal(ric_graph_create(study, NULL, &g), RIC_OK);
    if (max_step > 0) g->limits.max_step = max_step;
    if (ric_graph_explore(g, NULL)) fail_msg("%s", ric_detail());
    if (ric_rows_make(g, study, true, &atlas)) fail_msg("%s", ric_detail());
    if (graph) *graph = g;
    else ric_graph_free(g);
    return atlas;
}

static ric_study *read_study(void)
{
    ric_study *study = NULL;
    if (ric_study_read(STUDY, &study)) fail_msg("%s", ric_detail());
    return study;
}

static bool close_to(double a, double b, double tolerance)
{
    return fabs(a - b) <= tolerance * fmax(fabs(a), fabs(b));
}

static const char *word_text(int n, const int *word, char *out)
{
    for (int i = 0; i < n; i++) out[i] = (char)('0' + word[i]);
    out[n] = 0;
    return out;
}

/* Id of a junction of the table, energies multiplied by `factor`; it is there exactly once. */
static int find(const ric_atlas *atlas, const expected *e, double factor)
{
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        if (j.kind != e->kind || !close_to(j.energy, factor * e->energy, 1e-9) ||
            !close_to(j.frequency, e->omega, 1e-9))
            continue;
        if (found) fail_msg("%s is there twice: %d and %d", e->name, found, id);
        found = id;
    }
    if (!found) fail_msg("no %s at E %.13g, omega %.13g", e->name, factor * e->energy, e->omega);
    return found;
}

static int find_by_name(const ric_atlas *atlas, const char *name, double factor)
{
    for (int i = 0; i < N_REFERENCE; i++)
        if (name && !strcmp(reference[i].name, name)) return find(atlas, &reference[i], factor);
    return 0;
}

static bool has(int n, const int *list, int item)
{
    for (int i = 0; i < n; i++)
        if (list[i] == item) return true;
    return false;
}

/* ---------------------------------------------------------------- junctions */

static void check_junctions(const ric_atlas *atlas, double factor)
{
    char word[64];
    for (int i = 0; i < N_REFERENCE; i++) {
        const expected *e = &reference[i];
        ric_junction j = junction_of(atlas, find(atlas, e, factor));
        word_text(j.impacts, j.word, word);
        if (j.impacts != e->impacts || j.grazings != e->grazings || j.multiple != e->multiple ||
            j.a != e->a || j.b != e->b || strcmp(word, e->word) ||
            (e->multiple > 1 && memcmp(j.rotation, e->rotation, sizeof e->rotation)))
            fail_msg("%s: N %d, p %d, multiple %d (%d/%d), a %d, b %d, word %s", e->name, j.impacts,
                     j.grazings, j.multiple, j.rotation[0], j.rotation[1], j.a, j.b, word);
    }
}

static void junctions_of_the_article(void **state)
{
    (void)state;
    ric_study *study = read_study();
    ric_atlas *atlas = explore(study, 0, NULL);
    check_junctions(atlas, 1);
    /* the list of names in the study reaches them */
    for (int i = 0; i < N_REFERENCE; i++)
        assert_string_equal(junction_of(atlas, find(atlas, &reference[i], 1)).name,
                            reference[i].name);
    ric_atlas_free(atlas);
    ric_study_free(study);
}

/* ----------------------------------------------------------------- branches */

static int find_branch(const ric_atlas *atlas, const edge *e, double factor)
{
    int found = 0,
        ends[2] = {find_by_name(atlas, e->end[0], factor), find_by_name(atlas, e->end[1], factor)};
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        bool fits = (b.from == ends[0] && b.to == ends[1]) ||
                    (b.from == ends[1] && b.to == ends[0]);
        if (!fits || strcmp(b.label, e->label)) continue;
        if (found)
            fail_msg("%s from %s to %s is there twice: %d and %d", e->label, e->end[0], e->end[1],
                     found, id);
        found = id;
    }
    if (!found)
        fail_msg("no %s from %s to %s", e->label, e->end[0] ? e->end[0] : "the window",
                 e->end[1] ? e->end[1] : "the window");
    return found;
}

static void check_branches(const ric_atlas *atlas, double factor)
{
    for (int i = 0; i < N_EDGE; i++) {
        const edge *e = &edges[i];
        ric_branch b = branch_of(atlas, find_branch(atlas, e, factor));
        if (b.depth != e->depth) fail_msg("%s: depth %d, not %d", e->label, b.depth, e->depth);
        if (b.symmetric != e->symmetric || b.reversible != e->reversible)
            fail_msg("%s: symmetric %d, reversible %d", e->label, b.symmetric, b.reversible);
        int through = 0;
        for (; through < 5 && e->through[through]; through++) {
            int id = find_by_name(atlas, e->through[through], factor);
            ric_junction j = junction_of(atlas, id);
            if (!has(b.n_junction, b.junctions, id))
                fail_msg("%s does not pass %s", e->label, e->through[through]);
            if (!has(j.n_branch, j.branches, b.id))
                fail_msg("%s does not list %s", e->through[through], e->label);
        }
        for (int k = 0, known = 0; k < b.n_junction; k++) { /* and nothing else of the table */
            for (int r = 0; r < N_REFERENCE; r++)
                known += find(atlas, &reference[r], factor) == b.junctions[k];
            if (k + 1 == b.n_junction && known != through)
                fail_msg("%s passes %d junctions of the table, not %d", e->label, known, through);
        }
        for (int k = 1; k < b.n_junction; k++) assert_true(b.junction_at[k] > b.junction_at[k - 1]);
    }
    /* the seven forms of eq. 49 leave one grazing */
    static const char *const forms[7] = {"S2+[01]",  "A3[001]",   "A4[0001]",  "S4[0011]",
                                         "A4[0101]", "A5[00101]", "S6[010101]"};
    ric_junction j = junction_of(atlas, find_by_name(atlas, "G1_2,4", factor));
    assert_int_equal(j.n_branch, 7);
    for (int i = 0; i < 7; i++) {
        int times = 0;
        for (int k = 0; k < 7; k++)
            times += !strcmp(branch_of(atlas, j.branches[k]).label, forms[i]);
        if (times != 1) fail_msg("%s leaves G1_2,4 %d times", forms[i], times);
    }
    /* A4[0011], over at its own grazing, is the deepest */
    ric_junction c4 = junction_of(atlas, find_by_name(atlas, "C4_32", factor));
    bool seen = false;
    for (int k = 0; k < c4.n_branch; k++) {
        ric_branch b = branch_of(atlas, c4.branches[k]);
        if (strcmp(b.label, "A4[0011]")) continue;
        seen = true;
        assert_int_equal(b.depth, 4);
        assert_true(b.from == c4.id || b.to == c4.id);
    }
    assert_true(seen);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        if (b.stop == RIC_STOP_FAILED || b.stop == RIC_STOP_BUDGET)
            fail_msg("branch %d %s stops: %s, %s", id, b.label, ric_stop_text(b.stop), b.why);
    }
}

static void branches_of_the_article(void **state)
{
    (void)state;
    ric_study *study = read_study();
    ric_atlas *atlas = explore(study, 0, NULL);
    check_branches(atlas, 1);
    /* horizontal branches: one frequency from end to end */
    for (int i = 0; i < N_EDGE; i++) {
        ric_branch b = branch_of(atlas, find_branch(atlas, &edges[i], 1));
        if (strcmp(b.label, "A2[01]") && (strcmp(b.label, "S4[0011]") || b.reversible)) continue;
        if (!close_to(b.frequency_min, b.frequency_max, 1e-12))
            fail_msg("%s is not horizontal: %.17g to %.17g", b.label, b.frequency_min,
                     b.frequency_max);
    }
    ric_atlas_free(atlas);
    ric_study_free(study);
}

/* ---------------------------------------------------- step length and units */

/* Same junctions in the same order, same branches: labels, ends, what they pass, depths. Energies
 * of b are `factor` times those of a. */
static void check_same_atlas(const ric_atlas *a, const ric_atlas *b, double factor,
                             const char *what)
{
    if (ric_atlas_n_junction(a) != ric_atlas_n_junction(b) ||
        ric_atlas_n_branch(a) != ric_atlas_n_branch(b))
        fail_msg("%s: %d junctions and %d branches, not %d and %d", what, ric_atlas_n_junction(b),
                 ric_atlas_n_branch(b), ric_atlas_n_junction(a), ric_atlas_n_branch(a));
    for (int id = 1; id <= ric_atlas_n_junction(a); id++) {
        ric_junction x = junction_of(a, id), y = junction_of(b, id);
        if (x.kind != y.kind || !close_to(factor * x.energy, y.energy, 1e-9) ||
            !close_to(x.frequency, y.frequency, 1e-9))
            fail_msg(
                "%s: junction %d %s at E %.13g, omega %.13g becomes %s at E %.13g, omega %.13g",
                what, id, x.label, x.energy, x.frequency, y.label, y.energy / factor, y.frequency);
        if (strcmp(x.label, y.label) || x.impacts != y.impacts || x.a != y.a || x.b != y.b ||
            x.n_branch != y.n_branch ||
            memcmp(x.word, y.word, (size_t)x.impacts * sizeof *x.word) ||
            memcmp(x.branches, y.branches, (size_t)x.n_branch * sizeof *x.branches) ||
            memcmp(&x.departures, &y.departures, sizeof x.departures))
            fail_msg("%s: junction %d %s differs (%s, a %d, b %d, departures %d %d %d %d %d "
                     "against %d %d %d %d %d)",
                     what, id, x.label, y.label, y.a, y.b, x.departures.taken, x.departures.known,
                     x.departures.inadmissible, x.departures.over_budget, x.departures.refused,
                     y.departures.taken, y.departures.known, y.departures.inadmissible,
                     y.departures.over_budget, y.departures.refused);
    }
    for (int id = 1; id <= ric_atlas_n_branch(a); id++) {
        ric_branch x = branch_of(a, id), y = branch_of(b, id);
        if (strcmp(x.label, y.label) || x.from != y.from || x.to != y.to || x.stop != y.stop ||
            x.depth != y.depth || x.n_junction != y.n_junction ||
            memcmp(x.junctions, y.junctions, (size_t)x.n_junction * sizeof *x.junctions))
            fail_msg(
                "%s: branch %d %s (%d to %d) becomes %s (%d to %d, %s %s, depth %d, passes %d)",
                what, id, x.label, x.from, x.to, y.label, y.from, y.to, ric_stop_text(y.stop),
                y.why, y.depth, y.n_junction);
    }
}

static void any_step_length(void **state)
{
    (void)state;
    ric_study *study = read_study();
    ric_atlas *usual = explore(study, 0, NULL);
    for (int i = 0; i < 20; i += every_of(3)) {
        char what[64];
        double step = pow(10, -2 + 2 * i / 19.0);
        snprintf(what, sizeof what, "step %.4g", step);
        ric_atlas *atlas = explore(study, step, NULL);
        check_same_atlas(usual, atlas, 1, what);
        ric_atlas_free(atlas);
    }
    check_junctions(usual, 1);
    ric_atlas_free(usual);
    ric_study_free(study);
}

/* The same for other structures with few steps; tools/steps.py is the long form. */
static void any_step_length_elsewhere(void **state)
{
    (void)state;
    static const char *const others[] = {"symmetric-path", "three-masses", "loose-mass",
                                         "two-walls", "gears"};
    static const double steps[] = {0.01, 0.01274, 0.026, 0.0336, 0.07, 0.0886, 0.3, 1};
    for (int i = 0; i < (int)(sizeof others / sizeof *others); i++) {
        char path[512], what[64];
        ric_study *study = NULL;
        snprintf(path, sizeof path, "examples/%s/study.yaml", others[i]);
        if (ric_study_read(path, &study)) fail_msg("%s", ric_detail());
        ric_atlas *usual = explore(study, 0, NULL);
        for (int k = 0; k < (int)(sizeof steps / sizeof *steps); k += every_of(3)) {
            snprintf(what, sizeof what, "%s, step %.4g", others[i], steps[k]);
            ric_atlas *atlas = explore(study, steps[k], NULL);
            check_same_atlas(usual, atlas, 1, what);
            ric_atlas_free(atlas);
        }
        ric_atlas_free(usual);
        ric_study_free(study);
    }
}

/* And with multiplications and duplicates of grazings. */
static void any_step_length_with_multiplications(void **state)
{
    (void)state;
    static const char *const options[] = {"impacts: 12, multiply: 2, depth: 3",
                                          "impacts: 8, multiply: 4, depth: 3"};
    static const double steps[] = {0.01, 0.04, 0.2, 0.7};
    for (int i = 0; i < 2; i++) {
        char text[512], what[128];
        ric_study *study = NULL;
        snprintf(text, sizeof text,
                 "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                 "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                 "explore: {energy: [0, 200], frequency: [0.2, 10], %s}\n",
                 options[i]);
        if (ric_study_parse(text, "test", ".", &study)) fail_msg("%s", ric_detail());
        ric_atlas *usual = explore(study, 0, NULL);
        for (int k = 0; k < 4; k += every_of(3)) {
            snprintf(what, sizeof what, "%s, step %.4g", options[i], steps[k]);
            ric_atlas *atlas = explore(study, steps[k], NULL);
            check_same_atlas(usual, atlas, 1, what);
            ric_atlas_free(atlas);
        }
        ric_atlas_free(usual);
        ric_study_free(study);
    }
}

/* A wall on one side that nothing reaches takes x -> -x from the structure, but not from its
 * motions: the same junctions at the same energies, and as many symmetric branches. What is not its
 * own image is there twice, or once where the branch passes its image. */
static void wall_out_of_reach(void **state)
{
    (void)state;
    static const char text[] =
        "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
        "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
        "%sexplore: {start: modes, energy: [0, 200], frequency: [0.2, 10], impacts: %d, "
        "multiply: %d, depth: %d}\n";
    static const int budgets[2][3] = {{24, 1, 4}, {12, 2, 3}};
    for (int i = 0; i < 2; i++) {
        ric_atlas *atlas[2];
        int symmetric[2] = {0}, images = 0;
        for (int k = 0; k < 2; k++) {
            char study_text[1024];
            ric_study *study = NULL;
            snprintf(study_text, sizeof study_text, text,
                     k ? "    - {normal: [0, 1], clearance: 1000, sides: upper, law: rigid}\n" : "",
                     budgets[i][0], budgets[i][1], budgets[i][2]);
            if (ric_study_parse(study_text, "wall", ".", &study)) fail_msg("%s", ric_detail());
            atlas[k] = explore(study, 0, NULL);
            ric_study_free(study);
            for (int id = 1; id <= ric_atlas_n_branch(atlas[k]); id++) {
                ric_branch b = branch_of(atlas[k], id);
                symmetric[k] += b.symmetric;
                if (b.stop == RIC_STOP_FAILED) fail_msg("branch %d %s: %s", id, b.label, b.why);
            }
        }
        if (symmetric[0] != symmetric[1])
            fail_msg("%d symmetric branches, with the wall %d", symmetric[0], symmetric[1]);
        for (int id = 1; id <= ric_atlas_n_junction(atlas[0]); id++) {
            ric_junction x = junction_of(atlas[0], id);
            int found = 0;
            for (int k = 1; k <= ric_atlas_n_junction(atlas[1]); k++) {
                ric_junction y = junction_of(atlas[1], k);
                found += x.kind == y.kind && x.impacts == y.impacts && x.a == y.a && x.b == y.b &&
                         x.multiple == y.multiple && close_to(x.energy, y.energy, 1e-10) &&
                         close_to(x.frequency, y.frequency, 1e-10);
            }
            if (found < 1 || found > 2)
                fail_msg("%s at E %.13g is there %d times with the wall", x.label, x.energy, found);
            images += found - 1;
        }
        assert_true(images > 0);
        assert_int_equal(ric_atlas_n_junction(atlas[0]) + images, ric_atlas_n_junction(atlas[1]));
        for (int k = 0; k < 2; k++) ric_atlas_free(atlas[k]);
    }
}

static ric_atlas *explore_in_units(double mass, double stiffness, double length, ric_study **study)
{
    char text[1024];
    double window = 200 * stiffness; /* energy over length squared */
    snprintf(text, sizeof text,
             "title: units\nmodel:\n  mass: [[%.17g, 0], [0, %.17g]]\n  stiffness: [[%.17g, "
             "%.17g], [%.17g, %.17g]]\n"
             "  contacts:\n    - {normal: [-1, 1], clearance: %.17g, sides: both, law: rigid}\n"
             "explore: {start: modes, energy: [0, %.17g], frequency: [0.2, 10], impacts: 24, "
             "multiply: 1, depth: 4}\n",
             2 * mass, mass, 9 * stiffness, -stiffness, -stiffness, stiffness, length, window);
    if (ric_study_parse(text, "units", ".", study)) fail_msg("%s", ric_detail());
    return explore(*study, 0, NULL);
}

static void any_units(void **state)
{
    (void)state;
    ric_study *si, *other;
    ric_atlas *a = explore_in_units(1, 1, 1, &si);
    check_junctions(a, 1);
    check_branches(a, 1);
    /* kg, m, N -> t, mm, N, then two without meaning */
    static const double units[3][3] = {{1e-3, 1e-3, 1e3},
                                       {1e-3, 1e-3, 0.07},
                                       {3.1e5, 3.1e5, 1.7e-4}};
    for (int i = 0; i < 3; i++) {
        char what[64];
        snprintf(what, sizeof what, "units %d", i);
        ric_atlas *b = explore_in_units(units[i][0], units[i][1], units[i][2], &other);
        check_same_atlas(a, b, units[i][1], what);
        check_junctions(b, units[i][1]);
        assert_true(ric_model_length(ric_study_model(other)) == units[i][2]);
        ric_atlas_free(b);
        ric_study_free(other);
    }
    ric_atlas_free(a);
    ric_study_free(si);
}

/* --------------------------------------------------------------- departures */

static void departures_add_up(void **state)
{
    (void)state;
    ric_study *study = read_study();
    ric_graph *graph = NULL;
    ric_atlas *atlas = explore(study, 0, &graph);
    double unit = ric_study_model(study)->energy_unit;
    int matched = 0;
    for (int i = 0; i < N_REFERENCE; i++) {
        ric_departures d = junction_of(atlas, find(atlas, &reference[i], 1)).departures;
        int sum = d.taken + d.known + d.inadmissible + d.over_budget + d.refused;
        if (sum != reference[i].candidates)
            fail_msg("%s: %d taken, %d known, %d inadmissible, %d over budget, %d refused, but %d "
                     "candidates",
                     reference[i].name, d.taken, d.known, d.inadmissible, d.over_budget, d.refused,
                     reference[i].candidates);
    }
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        ric_departures d = j.departures;
        for (int i = 0; i < graph->n_node; i++) {
            const ric_node *node = graph->nodes[i];
            if (node->kind != j.kind || !close_to(node->energy * unit, j.energy, 1e-11)) continue;
            matched++;
            if (d.taken + d.known + d.inadmissible + d.over_budget + d.refused != node->n_departure)
                fail_msg("junction %d %s: %d candidates", id, j.label, node->n_departure);
            for (int k = 0; k < node->n_departure; k++)
                if (node->departures[k].state == RIC_DEPARTURE_OPEN)
                    fail_msg("junction %d %s: departure %d is open", id, j.label, k);
        }
        assert_true((d.refused > 0) == (j.refusal[0] != 0));
        /* every branch that ends here accounts for a departure taken or known; one that passes for
         * one, in both directions */
        int ends = 0;
        for (int k = 0; k < j.n_branch; k++) {
            ric_branch b = branch_of(atlas, j.branches[k]);
            ends += (b.from == id) + (b.to == id);
            assert_true(b.from == id || b.to == id || has(b.n_junction, b.junctions, id));
        }
        if (j.kind == RIC_KIND_GRAZING && d.taken + d.known != ends)
            fail_msg("junction %d %s: %d taken and %d known, but %d branches end there", id,
                     j.label, d.taken, d.known, ends);
    }
    assert_int_equal(matched, ric_atlas_n_junction(atlas));
    ric_graph_free(graph);
    ric_atlas_free(atlas);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(junctions_of_the_article),
        cmocka_unit_test(branches_of_the_article),
        cmocka_unit_test(any_step_length),
        cmocka_unit_test(any_step_length_elsewhere),
        cmocka_unit_test(any_step_length_with_multiplications),
        cmocka_unit_test(wall_out_of_reach),
        cmocka_unit_test(any_units),
        cmocka_unit_test(departures_add_up),
    };
    return cmocka_run_group_tests_name("reference", tests, NULL, NULL);
}
