/* Exploring is a function of the study: in whatever order the departures are taken, the atlas is
 * the same bit for bit. The short form tries one order beside the usual one, the long form three.
 */
#include "stored_atlases.h"

#include "explored.h"
#include "sample.h"

static ric_atlas *explore_shuffled(const ric_study *study, uint64_t seed)
{
    ric_graph *g = NULL;
    ric_atlas *atlas = NULL;
    assert_int_equal(ric_graph_create(study, NULL, &g), RIC_OK);
    g->shuffle = seed;
    if (ric_graph_explore(g, NULL) || ric_rows_make(g, study, true, &atlas))
        fail_msg("%s", ric_detail());
    ric_graph_free(g);
    return atlas;
}

static void say_difference(const ric_atlas *a, const ric_atlas *b, const char *name,
                           unsigned long long seed)
{
    fprintf(stderr, "%s, order %llu: %d branches and %d junctions, against %d and %d\n", name, seed,
            b->n_branch, b->n_junction, a->n_branch, a->n_junction);
    for (int i = 0; i < a->n_branch && i < b->n_branch; i++) {
        const ric_branch *x = &a->branches[i].row, *y = &b->branches[i].row;
        if (same_branch(&a->branches[i], &b->branches[i])) continue;
        fprintf(
            stderr,
            "  branch %d %s: E %.17g to %.17g, %d points, junctions %d to %d, depth %d, %s %s\n",
            x->id, x->label, x->energy_min, x->energy_max, x->n_point, x->from, x->to, x->depth,
            ric_stop_text(x->stop), x->why);
        fprintf(
            stderr,
            "  becomes   %s: E %.17g to %.17g, %d points, junctions %d to %d, depth %d, %s %s\n",
            y->label, y->energy_min, y->energy_max, y->n_point, y->from, y->to, y->depth,
            ric_stop_text(y->stop), y->why);
    }
    for (int i = 0; i < a->n_junction && i < b->n_junction; i++) {
        const ric_junction *x = &a->junctions[i].row, *y = &b->junctions[i].row;
        const ric_departures *d = &x->departures, *e = &y->departures;
        if (same_junction(x, y, ric_model_n_dof(ric_atlas_model(a)))) continue;
        fprintf(stderr, "  junction %d %s: E %.17g, departures %d %d %d %d %d\n", x->id, x->label,
                x->energy, d->taken, d->known, d->inadmissible, d->over_budget, d->refused);
        fprintf(stderr, "  becomes     %s: E %.17g, departures %d %d %d %d %d\n", y->label,
                y->energy, e->taken, e->known, e->inadmissible, e->over_budget, e->refused);
    }
}

static void check(const ric_study *study, const char *name)
{
    ric_atlas *usual = explore_shuffled(study, 0);
    int different = 0, orders = 0;
    for (uint64_t seed = 1; seed <= 3; seed += (uint64_t)every_of(3), orders++) {
        ric_atlas *atlas = explore_shuffled(study, seed * 0x9e3779b97f4a7c15u);
        if (!same_atlas(usual, atlas)) {
            different++;
            say_difference(usual, atlas, name, seed);
        }
        ric_atlas_free(atlas);
    }
    ric_atlas_free(usual);
    if (different) fail_msg("%s: another atlas in %d of %d orders", name, different, orders);
}

static void check_example(const char *name)
{
    char path[128];
    ric_study *study = NULL;
    snprintf(path, sizeof path, "examples/%s/study.yaml", name);
    if (ric_study_read(path, &study)) fail_msg("%s", ric_detail());
    check(study, name);
    ric_study_free(study);
}

static void examples(void **state)
{
    static const char *const names[] = {"elementary",   "symmetric-path", "three-masses",
                                        "corner",       "loose-mass",     "fractal-base",
                                        "two-walls",    "free-pair",      "symmetric-chain",
                                        "beam-midspan", "bilinear",       "two-springs",
                                        "power-3",      "gears"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i += (size_t)every_of(2))
        check_example(names[i]);
}

static void multiplications(void **state)
{
    static const char *const options[] = {
        "start: [1], energy: [0, 200], frequency: [0.2, 10], impacts: 8, multiply: 3, depth: 3",
        "energy: [0, 200], frequency: [0.2, 10], impacts: 12, multiply: 2, depth: 3",
        "energy: [0, 200], frequency: [0.2, 10], impacts: 24, multiply: 2, depth: 4",
        "energy: [0, 200], frequency: [0.2, 10], impacts: 12, multiply: 4, depth: 2",
    };
    (void)state;
    for (size_t i = 0; i < sizeof options / sizeof *options; i += (size_t)every_of(4)) {
        char text[512];
        snprintf(text, sizeof text,
                 "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                 "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\nexplore: {%s}\n",
                 options[i]);
        ric_study *study = study_of(text);
        check(study, options[i]);
        ric_study_free(study);
    }
}

/* Whether the atlas has a branch of this name of which this one is a part. */
static bool has_like(const ric_atlas *atlas, const ric_branch *b)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch other = branch_of(atlas, id);
        if (!strcmp(other.label, b->label) && other.energy_max > b->energy_max * (1 - 1e-9) &&
            other.energy_min < b->energy_min * (1 + 1e-9))
            return true;
    }
    return false;
}

/* Families that reach into a window begin below it. What a window with a higher lower end holds is
 * part of what the whole one holds; all of it, but for what can be reached through lower energies
 * alone, where a branch that comes down has ended. */
static void windows_from_above(void **state)
{
    static const double lower[] = {0, 0.7, 5, 20};
    static const int expected[] =
        {57, 57, 50, 40}; /* at least: branches that reach above 5, above 5, above 5 and above 20 */
    ric_atlas *whole = NULL;
    (void)state;
    for (int i = 0; i < 4; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                 "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                 "explore: {energy: [%g, 100], frequency: [0.3, 10], impacts: 8, multiply: 3, "
                 "depth: 3}\n",
                 lower[i]);
        ric_atlas *atlas = explore_text(text);
        int count = 0;
        if (!whole) whole = atlas;
        for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
            ric_branch b = branch_of(atlas, id);
            if (b.energy_max < fmax(lower[i], 5)) continue;
            count++;
            if (!has_like(whole, &b))
                fail_msg("lower end %g: %s up to E %.12g is not in the whole atlas", lower[i],
                         b.label, b.energy_max);
        }
        print_message("lower end %g: %d branches\n", lower[i], count);
        assert_true(count >= expected[i]);
        if (atlas != whole) ric_atlas_free(atlas);
    }
    ric_atlas_free(whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(examples),
                                       cmocka_unit_test(multiplications),
                                       cmocka_unit_test(windows_from_above)};
    return cmocka_run_group_tests_name("order", tests, NULL, NULL);
}
