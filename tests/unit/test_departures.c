/* The departures of every junction add up: as many candidates as subsets of touches, or as the
 * theory has it, counted here from the orbit of the junction alone; and every one that counts as
 * taken or known is a branch of the atlas that is there. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "junction/grazing_words.h"
#include "sample.h"

#define FIXED 1e-6 /* distance of an orbit from its image that counts as none */

/* Relative distance of images of one orbit; of a neighbour of one with more symmetry it is more. */
#define EXACT 1e-10

enum { FEW = 4 }; /* points of a branch: of fewer nothing follows */
enum { MAX_BITS = 16, MAX_GROUP = 4096, MAX_TEXT = 1024 };

/* -------------------------------------------------------------- candidates */

/* Which impact of `c` the first one of its image is, for every operation that maps the orbit to
 * itself: shifts, then run backwards, mirrored or not. Found by carrying each out, not from the
 * symmetries that the program has noted. */
typedef struct {
    int shift;
    bool reverse;
} operation;

static int group_of(const ric_model *m, const ric_periodic *c, operation *group)
{
    int n = 0;
    for (int mirror = 0; mirror <= m->symmetric; mirror++)
        for (int reverse = 0; reverse < 2; reverse++)
            for (int shift = 0; shift < c->N; shift++) {
                ric_periodic *image = ric_periodic_transform(m, c, shift, reverse, mirror);
                assert_non_null(image);
                if (ric_periodic_distance(c, image) < FIXED) {
                    assert_true(n < MAX_GROUP);
                    group[n++] = (operation){shift, reverse};
                }
                ric_periodic_free(image);
            }
    return n;
}

/* The number of subsets of the touches of a grazing gone through k times, up to the symmetries of
 * that orbit, without those that are a shorter orbit gone through several times. */
static int count_subsets(const ric_model *m, const ric_node *node)
{
    static operation group[MAX_GROUP];
    static bool seen[1 << MAX_BITS];
    int k = node->multiple, N = node->cycle->N, bits = node->n_touch * k, count = 0,
        place[MAX_BITS], bit_at[1024];
    ric_periodic *whole = ric_periodic_repeat(node->cycle, k);
    assert_true(bits <= MAX_BITS && whole->N < 1024);
    int n = group_of(m, whole, group);
    for (int i = 0; i < whole->N; i++) bit_at[i] = -1;
    for (int b = 0; b < bits; b++)
        bit_at[place[b] = b / node->n_touch * N + node->touch[b % node->n_touch]] = b;
    memset(seen, 0, sizeof seen);
    for (unsigned set = 0; set < 1u << bits; set++) {
        bool repeated = false;
        if (seen[set]) continue;
        for (int i = 0; i < n; i++) {
            unsigned image = 0;
            for (int b = 0; b < bits; b++) {
                int from = place[b],
                    to = group[i].reverse ? group[i].shift - from : from - group[i].shift;
                to = (to % whole->N + whole->N) % whole->N;
                assert_true(bit_at[to] >= 0);
                if (set & 1u << b) image |= 1u << bit_at[to];
            }
            seen[image] = true;
            repeated |= image == set && !group[i].reverse && group[i].shift % N == 0 &&
                        group[i].shift > 0;
        }
        count += !repeated;
    }
    ric_periodic_free(whole);
    return count;
}

/* Section 8: what a multiplication of order r is left by, besides the branch that passes. In a
 * structure that lacks the symmetry x -> -x of the orbit, two families that would be images of each
 * other are two. */
static int count_families(const ric_model *m, const ric_node *node)
{
    const ric_periodic *c = node->cycle;
    int p = node->rotation[0], q = node->rotation[1], order = c->half && p % 2 ? 2 * q : q;
    bool reversible = c->pure >= 0 || c->flip >= 0;
    if (order == 2) return 1;
    if (order == 3) return 1;
    if (!m->symmetric && c->half && c->pure >= 0 && p % 2 && q % 2 == 0) return 3;
    return order % 2 && reversible ? 1 : 2; /* of odd order one curve passes; without mirror points
                                               its halves are two branches */
}

static int count_candidates(const ric_model *m, const ric_node *node)
{
    switch (node->kind) {
    case RIC_KIND_GRAZING:
        return node->refusal             ? 1
               : m->law != RIC_LAW_RIGID ? -1
                                         : count_subsets(m, node); /* pairs of switches */
    case RIC_KIND_CORNER:
        return node->refusal ? 0 : -1; /* orders of pairs of impacts are not counted here */
    case RIC_KIND_BRANCH_POINT: return 2;
    case RIC_KIND_MULTIPLICATION: return 1 + count_families(m, node);
    case RIC_KIND_START: return 1;
    default: return 0;
    }
}

/* ---------------------------------------------------------------- branches */

static bool there(const ric_departure *d)
{
    return d->state == RIC_DEPARTURE_TAKEN || d->state == RIC_DEPARTURE_KNOWN;
}

/* Ends of branches at a way out. */
static int count_ends(const ric_graph *g, int node, unsigned choice)
{
    int n = 0;
    for (int i = 0; i < g->n_edge; i++)
        n += (g->edges[i].from == node && g->edges[i].leave == choice) +
             (g->edges[i].to == node && g->edges[i].arrive == choice);
    return n;
}

/* Branches that pass a junction as the orbit there, or aside: with q times its period or less of
 * its symmetry. */
static int count_passing(const ric_graph *g, int node, bool aside)
{
    const ric_periodic *c = g->nodes[node]->cycle;
    int n = 0;
    for (int i = 0; i < g->n_edge; i++)
        for (int k = 0; k < g->edges[i].n_inner; k++) {
            if (g->edges[i].inner[k].node != node) continue;
            ric_periodic *cycle = ric_continuation_cycle(g->edges[i].trace,
                                                         g->edges[i].trace->points +
                                                             sizeof(ric_point) / sizeof(double));
            bool less = (c->half && !cycle->half) || (c->flip >= 0 && cycle->flip < 0);
            n += (cycle->N > c->N || less) == aside;
            ric_periodic_free(cycle);
        }
    return n;
}

static const char *state_text(ric_departure_state state)
{
    static const char *const texts[] = {"open",         "taken",       "known",
                                        "inadmissible", "over budget", "refused"};
    return texts[state];
}

static int failures;

static void report(const ric_graph *g, int i, const char *name, const char *what, unsigned choice,
                   int wanted, int found)
{
    const ric_node *node = g->nodes[i];
    fprintf(stderr,
            "%s: %s at E %.10g, %d impacts, %d touches, multiple %d (%d/%d), depth %d: %s %u: %d, "
            "not %d\n",
            name, ric_kind_text(node->kind), node->energy * g->model->energy_unit, node->cycle->N,
            node->n_touch, node->multiple, node->rotation[0], node->rotation[1], node->depth, what,
            choice, found, wanted);
    failures++;
}

static void check_node(const ric_graph *g, int i, const char *name)
{
    const ric_node *node = g->nodes[i];
    int candidates = count_candidates(g->model, node), crossing = 0, crossed = 0;
    if (candidates >= 0 && node->n_departure != candidates)
        report(g, i, name, "candidates", 0, candidates, node->n_departure);
    for (int k = 0; k < node->n_departure; k++) {
        const ric_departure *d = &node->departures[k];
        int wanted = there(d), found;
        if (d->state == RIC_DEPARTURE_OPEN)
            report(g, i, name, state_text(d->state), d->choice, 0, 1);
        if (d->state == RIC_DEPARTURE_REFUSED && !d->why)
            report(g, i, name, "refused without a reason", d->choice, 0, 1);
        /* the linear mode is no edge */
        if (node->kind == RIC_KIND_GRAZING && ric_node_impacts(node, d->choice) == 0) continue;
        if (node->kind == RIC_KIND_BRANCH_POINT && node->test == RIC_TEST_DET) { /* both pass */
            crossing += wanted;
            crossed = count_passing(g, i, false);
            continue;
        }
        if (node->kind == RIC_KIND_START)
            found = wanted; /* a start is inside its branch and no junction of it */
        else if (ric_node_passes(node, d->choice))
            found = count_passing(g, i, d->choice != RIC_THROUGH);
        else found = count_ends(g, i, d->choice);
        if (found != wanted) report(g, i, name, state_text(d->state), d->choice, wanted, found);
    }
    if (crossing != crossed) report(g, i, name, "branches that cross", 0, crossing, crossed);
}

/* The rows of the atlas say the same: the sum, and the branches that a junction names are those
 * that name the junction. */
static void check_rows(const ric_atlas *atlas, const char *name)
{
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        int named = 0, known = 0;
        for (int k = 1; k <= ric_atlas_n_branch(atlas); k++) {
            ric_branch b = branch_of(atlas, k);
            bool meets = b.from == id || b.to == id;
            for (int i = 0; i < b.n_junction; i++) meets |= b.junctions[i] == id;
            named += meets;
        }
        for (int k = 0; k < j.n_branch; k++) {
            ric_branch b = branch_of(atlas, j.branches[k]);
            bool meets = b.from == id || b.to == id;
            for (int i = 0; i < b.n_junction; i++) meets |= b.junctions[i] == id;
            known += meets;
        }
        if (named != j.n_branch || known != j.n_branch)
            fail_msg("%s: junction %d names %d branches, %d name it", name, id, j.n_branch, named);
    }
}

/* The linear mode that grazes at a node is a row of its own where its departure counts as known or
 * taken. */
static void check_modes(const ric_graph *g, const ric_atlas *atlas, const char *name)
{
    for (int i = 0; i < g->n_node; i++) {
        const ric_node *node = g->nodes[i];
        if (node->kind != RIC_KIND_GRAZING || node->n_touch < node->cycle->N ||
            node->multiple > 1 || node->refusal)
            continue;
        assert_true(node->mode >= 0 || node->mixture >= 0);
        for (int k = 0; k < node->n_departure && node->mode >= 0;
             k++) { /* a mixture is a motion of several modes */
            int rows = 0;
            if (ric_node_impacts(node, node->departures[k].choice)) continue;
            for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
                ric_branch b = branch_of(atlas, id);
                rows += b.impacts == 0 && b.mode == g->model->mode[node->mode] + 1 && b.to &&
                        junction_of(atlas, b.to).impacts == 0;
            }
            if (rows != there(&node->departures[k]))
                report(g, i, name, "linear modes", 0, there(&node->departures[k]), rows);
        }
    }
}

/* What all orbits of a branch between its ends have is said of it, and none of them is a shorter
 * orbit gone through several times. */
static void check_orbits(const ric_graph *g, const ric_edge *e, const char *name)
{
    const ric_continuation *tr = e->trace;
    bool said[2] = {ric_shooting_halves(tr->chain), tr->chain->start != RIC_MIRROR_NONE},
         all[2] = {true, true};
    for (int i = 1; i + 1 < tr->n_point; i++) {
        const double *point = tr->points + tr->stride * (size_t)i;
        ric_periodic *orbit = ric_continuation_cycle(tr,
                                                     point + sizeof(ric_point) / sizeof(double));
        int copies = ric_periodic_find_symmetries(g->model, orbit, EXACT);
        if (copies > 1)
            fail_msg("%s: point %d of %d of a branch of %d impacts at E %.10g is an orbit gone "
                     "through %d times",
                     name, i, tr->n_point, orbit->N, e->energy[0] * g->model->energy_unit, copies);
        all[0] &= orbit->half;
        all[1] &= orbit->pure >= 0 || orbit->flip >= 0;
        ric_periodic_free(orbit);
    }
    for (int k = 0; k < 2 && tr->n_point > FEW; k++)
        if (all[k] && !said[k])
            fail_msg(
                "%s: all orbits of a branch of %d flights from E %.10g are %s, which is not said",
                name, tr->chain->n_flight, e->energy[0] * g->model->energy_unit,
                k ? "reversible" : "symmetric");
}

/* No two departures of a grazing that lead to different branches are one orbit, however it is read.
 */
static void check_classes(const ric_graph *g, int i, const char *name)
{
    const ric_node *node = g->nodes[i];
    ric_periodic *orbit[node->n_departure + 1];
    if (node->kind != RIC_KIND_GRAZING || node->refusal) return;
    for (int k = 0; k < node->n_departure; k++)
        orbit[k] = ric_grazing_words_cycle(g->model, node, node->departures[k].choice);
    for (int k = 0; k < node->n_departure; k++)
        for (int j = 0; j < k; j++)
            if (orbit[j] && orbit[k] && there(&node->departures[j]) &&
                there(&node->departures[k]) &&
                ric_periodic_same(g->model, orbit[j], orbit[k], FIXED))
                report(g, i, name, "is the departure", node->departures[k].choice,
                       (int)node->departures[k].choice, (int)node->departures[j].choice);
    for (int k = 0; k < node->n_departure; k++) ric_periodic_free(orbit[k]);
}

/* Both ends of a branch are one way out of one junction: it has passed an arrival and come back as
 * its own image. */
static void check_ends(const ric_graph *g, const ric_edge *e, const char *name)
{
    if (e->from >= 0 && e->from == e->to && e->leave == e->arrive)
        fail_msg("%s: a branch of %d flights from E %.10g comes back to its start as its own image",
                 name, e->trace->chain->n_flight, e->energy[0] * g->model->energy_unit);
}

static void check_study(const ric_study *study, const char *name)
{
    ric_graph *g = NULL;
    ric_atlas *atlas = NULL;
    assert_int_equal(ric_graph_create(study, NULL, &g), RIC_OK);
    if (ric_graph_explore(g, NULL) || ric_rows_make(g, study, true, &atlas))
        fail_msg("%s: %s", name, ric_detail());
    for (int i = 0; i < g->n_node; i++) check_node(g, i, name);
    for (int i = 0; i < g->n_node; i++) check_classes(g, i, name);
    for (int i = 0; i < g->n_edge; i++) {
        check_orbits(g, &g->edges[i], name);
        check_ends(g, &g->edges[i], name);
    }
    int unplaced = 0, said = 0;
    for (int i = 0; i < g->n_edge; i++) unplaced += g->edges[i].n_unplaced;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        int n = 0;
        const char *text = branch_of(atlas, id).why, *last = strrchr(text, ';');
        if (strstr(text, "to a junction")) sscanf(last ? last + 1 : text, "%d", &n);
        said += n;
        if (n && !strstr(text, " at E "))
            fail_msg("%s: branch %d does not say where: %s", name, id, text);
    }
    if (ric_atlas_n_unplaced(atlas) != unplaced || said != unplaced)
        fail_msg("%s: %d events without a junction, the atlas counts %d, its branches %d", name,
                 unplaced, ric_atlas_n_unplaced(atlas), said);
    check_modes(g, atlas, name);
    check_rows(atlas, name);
    ric_atlas_free(atlas);
    ric_graph_free(g);
}

static void check_text(const char *model, const char *options)
{
    char text[MAX_TEXT];
    ric_study *study = NULL;
    snprintf(text, sizeof text, "%sexplore: {%s}\n", model, options);
    if (ric_study_parse(text, "test", ".", &study)) fail_msg("%s", ric_detail());
    check_study(study, options);
    ric_study_free(study);
}

/* Only that, of a structure whose orbits with simultaneous touches are counted by subsets of a list
 * no more. */
static void check_classes_of(const char *text)
{
    ric_study *study = NULL;
    if (ric_study_parse(text, "test", ".", &study)) fail_msg("%s", ric_detail());
    ric_graph *g = explored_graph(study);
    for (int i = 0; i < g->n_node; i++) check_classes(g, i, "classes");
    ric_graph_free(g);
    ric_study_free(study);
}

/* ------------------------------------------------------------------- studies */

static void examples(void **state)
{
    static const char *const names[] = {"elementary",   "symmetric-path", "three-masses",
                                        "two-walls",    "corner",         "symmetric-chain",
                                        "loose-mass",   "free-pair",      "beam-midspan",
                                        "fractal-base", "cascade"};
    (void)state;
    failures = 0;
    for (size_t i = 0; i < sizeof names / sizeof *names; i += (size_t)every()) {
        char path[128];
        ric_study *study = NULL;
        snprintf(path, sizeof path, "examples/%s/study.yaml", names[i]);
        if (ric_study_read(path, &study)) fail_msg("%s", ric_detail());
        check_study(study, names[i]);
        ric_study_free(study);
    }
    assert_int_equal(failures, 0);
}

static const char two[] =
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n";

static void multiplications(void **state)
{
    (void)state;
    failures = 0;
    check_text(two, "energy: [0, 200], frequency: [0.2, 10], impacts: 12, multiply: 2, depth: 3");
    if (long_form())
        check_text(two,
                   "energy: [0, 200], frequency: [0.2, 10], impacts: 8, multiply: 4, depth: 3");
    check_text(two, "energy: [0, 100], frequency: [0.3, 10], impacts: 12, multiply: 5, depth: 2");
    assert_int_equal(failures, 0);
}

static const char three[] = "model:\n  mass: [[1.5, 0, 0], [0, 1, 0], [0, 0, 0.8]]\n"
                            "  stiffness: [[5, -1, 0], [-1, 3, -2], [0, -2, 5]]\n  contacts:\n"
                            "    - {normal: [1, 0, 0], clearance: 1, sides: upper, law: rigid}\n"
                            "    - {normal: [0, -1, 1], clearance: 0.7, sides: both, law: rigid}\n";

static void three_modes(void **state)
{
    (void)state;
    failures = 0;
    check_text(three, "energy: [0, 20], frequency: [0.2, 10], impacts: 8, multiply: 2, depth: 2");
    check_text("model:\n  mass: [[1, 0, 0], [0, 1.3, 0], [0, 0, 0.7]]\n  stiffness: [[6, -2, 0], "
               "[-2, 5, -3], [0, -3, "
               "7]]\n  contacts:\n"
               "    - {normal: [-1, 1, 0], clearance: 1, sides: both, law: rigid}\n",
               "energy: [0, 50], frequency: [0.1, 30], impacts: 8, multiply: 4, depth: 3");
    assert_int_equal(failures, 0);
}

/* From one mode only, the other one is met from its side. */
static void one_start(void **state)
{
    (void)state;
    failures = 0;
    for (int depth = 0; depth < 4; depth++)
        for (int mode = 1; mode <= 2; mode++)
            for (int multiply = 1; multiply <= 3; multiply += 2) {
                char options[128];
                snprintf(options, sizeof options,
                         "start: [%d], energy: [0, 200], frequency: [0.2, 10], impacts: 8, "
                         "multiply: %d, depth: %d",
                         mode, multiply, depth);
                if (multiply == 1 || depth) check_text(two, options);
            }
    assert_int_equal(failures, 0);
}

/* The touch of a wall that has no opposite side hides that the orbit is its own mirror image: by a
 * rest in flight, or half a period on. */
static void hidden_by_wall(void **state)
{
    (void)state;
    failures = 0;
    check_text(
        "model:\n  mass: [[0.75, 0, 0], [0, 2, 0], [0, 0, 1.5]]\n"
        "  stiffness: [[9.75, -3.5, 0], [-3.5, 11.25, -7.75], [0, -7.75, 12.75]]\n  contacts:\n"
        "    - {normal: [1, 0, 0], clearance: 0.533, sides: lower, law: bilinear, stiffness: "
        "737.8}\n"
        "    - {normal: [-1, 1, 0], clearance: 0.5335, sides: both, law: rigid}\n",
        "energy: [0, 43.13], frequency: [0.2736, 11.42], impacts: 6, multiply: 2, depth: 1");
    check_text(
        "model:\n  mass: [[0.25, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.25]]\n"
        "  stiffness: [[3, -3, 0, 0], [-3, 3.5, -0.5, 0], [0, -0.5, 2.25, -1.75], [0, 0, -1.75, "
        "1.75]]\n"
        "  contacts:\n    - {normal: [0, 0, 0, 1], clearance: 1.41, sides: both, law: rigid}\n"
        "    - {normal: [0, 1, 0, 0], clearance: 1.41, sides: upper, law: bilinear, stiffness: "
        "279.8}\n",
        "energy: [0, 14.23], frequency: [0.1769, 12.85], impacts: 3, multiply: 2, depth: 1");
    assert_int_equal(failures, 0);
}

/* Two contacts that close at one instant are listed in an order, which hides that the orbit is the
 * same backwards. */
static void hidden_by_order(void **state)
{
    (void)state;
    failures = 0;
    check_text("model:\n  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n  stiffness: [[2, 0, 0], [0, 3, "
               "0], [0, 0, 2]]\n"
               "  contacts:\n    - {normal: [-1, 1, 0], clearance: 12.5, sides: both, law: rigid}\n"
               "    - {normal: [0, -1, 1], clearance: 12.5, sides: upper, law: rigid}\n",
               "energy: [0, 5.9], frequency: [0.28, 5.2], impacts: 5, multiply: 1, depth: 1");
    /* and that two choices of touches are one */
    check_classes_of(
        "model:\n  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
        "  stiffness: [[2, -1, 0], [-1, 2, -1], [0, -1, 2]]\n  contacts:\n"
        "    - {normal: [-1, 1, 0], clearance: 1, sides: both, law: rigid}\n"
        "    - {normal: [0, -1, 1], clearance: 1, sides: both, law: rigid}\n"
        "explore: {energy: [0, 20], frequency: [0.2, 10], impacts: 3, multiply: 2, depth: 1}\n");
    assert_int_equal(failures, 0);
}

/* A6[223223] comes to a doubling of A3[223] in a bend much narrower than the step over a branch
 * point: it ends there, instead of going on as A3[223] gone through twice, or as its own image. */
static void sharp_arrival(void **state)
{
    (void)state;
    failures = 0;
    check_text("model:\n  mass: [[2, 0, 0], [0, 0.5, 0], [0, 0, 1.75]]\n"
               "  stiffness: [[3.25, -3.25, 0], [-3.25, 8, -4.75], [0, -4.75, 4.75]]\n  contacts:\n"
               "    - {normal: [-1, 1, 0], clearance: 1.66, sides: both, law: rigid}\n"
               "    - {normal: [1, 0, -1], clearance: 0.00166, sides: both, law: rigid}\n",
               "energy: [0, 5.644], frequency: [0.2863, 12.83], impacts: 6, multiply: 2, depth: 2");
    assert_int_equal(failures, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(examples),
                                       cmocka_unit_test(multiplications),
                                       cmocka_unit_test(three_modes),
                                       cmocka_unit_test(one_start),
                                       cmocka_unit_test(hidden_by_wall),
                                       cmocka_unit_test(hidden_by_order),
                                       cmocka_unit_test(sharp_arrival)};
    return cmocka_run_group_tests_name("departures", tests, NULL, NULL);
}
