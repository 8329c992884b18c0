/* Closed orbits: from a chain and back in every form, the group that acts on them, symmetries,
 * canonical form, dropped touches. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explore/graph.h"
#include "random_orbits.h"
#include "sample.h"

enum { MAX_N = 6, MAX_CONTACT = 3, MAX_FLIGHT = 5, MAX_SIZE = 2 * MAX_N + MAX_FLIGHT + 1 };

/* ------------------------------------------------------------------ helpers */

/* What runs over random orbits of every form. */
typedef void check_orbit(const ric_model *m, ric_shooting *chain, const double *u,
                         ric_periodic *cycle, const char *where);

static void over_random_orbits(check_orbit *check)
{
    double u[MAX_SIZE];
    int found[N_FORM] = {0};
    for (int n = 2; n <= 4; n++)
        for (int form = 0; form < N_FORM; form++)
            for (int trial = 0; trial < 8; trial += every()) {
                uint64_t seed = 10000u * (uint64_t)n + 100u * (uint64_t)form + (uint64_t)trial;
                char where[80];
                ric_model *m = random_structure_of(seed, n, 1 + trial % 2, trial == 7, false);
                ric_shooting *chain = random_orbit(m, form, 2 + below(MAX_FLIGHT - 1), u);
                ric_periodic *cycle = chain ? ric_periodic_from_chain(chain, u) : NULL;
                if (cycle && primitive(m, cycle)) {
                    found[form]++;
                    snprintf(where, sizeof where, "seed %llu, n = %d, form %d, %d flights",
                             (unsigned long long)seed, n, form, chain->n_flight);
                    check(m, chain, u, cycle, where);
                }
                ric_periodic_free(cycle);
                ric_shooting_free(chain);
                ric_model_free(m);
            }
    for (int form = 0; form < N_FORM; form++)
        if (found[form] < 8) fail_msg("form %d: only %d orbits found", form, found[form]);
}

static void check_distance(const ric_periodic *a, const ric_periodic *b, const char *where,
                           const char *what)
{
    double distance = a && b ? ric_periodic_distance(a, b) : HUGE_VAL;
    if (!(distance <= 1e-11)) fail_msg("%s: %s: distance %.3g", where, what, distance);
}

/* -------------------------------------------------------------- round trip */

static bool same_form(const ric_shooting *a, const ric_shooting *b)
{
    bool as_it_is = a->start == b->start && a->end == b->end,
         exchanged = a->start == b->end && a->end == b->start;
    return (as_it_is || exchanged) && a->sigma == b->sigma && a->multiple == b->multiple;
}

static void check_round_trip(const ric_model *m, ric_shooting *chain, const double *u,
                             ric_periodic *cycle, const char *where)
{
    ric_shooting *back = NULL;
    double *v = NULL;
    int letters = 0;
    ric_turn turn;
    assert_int_equal(ric_periodic_to_chain(m, cycle, &back, &v), RIC_OK);
    ric_shooting_fly(back, v);
    if (!same_form(chain, back))
        fail_msg("%s: comes back as %d-%d sigma %d", where, back->start, back->end, back->sigma);
    if (!(back->residual <= 1e-12))
        fail_msg("%s: residual %.3g after the round trip", where, back->residual);
    double T = ric_shooting_time(chain, u), E = ric_shooting_energy(chain);
    assert_true(fabs(ric_shooting_time(back, v) - T) <= 1e-12 * T &&
                fabs(ric_periodic_period(cycle) - T) <= 1e-12 * T);
    assert_true(fabs(ric_shooting_energy(back) - E) <= 1e-12 * (1 + E) &&
                fabs(ric_periodic_energy(m, cycle) - E) <= 1e-12 * (1 + E));
    ric_periodic *again = ric_periodic_from_chain(back, v);
    assert_non_null(again);
    if (!ric_periodic_match(m, cycle, again, 1e-11, &turn))
        fail_msg("%s: another orbit comes back", where);
    ric_periodic *image = ric_periodic_transform(m, again, turn.shift, turn.reverse, turn.mirror);
    check_distance(cycle, image, where, "matched image");
    if (image->half != cycle->half || image->pure != cycle->pure || image->flip != cycle->flip)
        fail_msg("%s: symmetries %d %d %d become %d %d %d", where, cycle->half, cycle->pure,
                 cycle->flip, image->half, image->pure, image->flip);
    /* impacts per period: those of the chain, each as often as the form repeats it */
    for (int k = 0; k <= chain->n_flight; k++) {
        if (chain->face[k] < 0) continue;
        bool border = k == 0 || k == chain->n_flight;
        if (chain->start == RIC_MIRROR_NONE) letters += k > 0 ? chain->multiple : 0;
        else letters += border ? chain->multiple / 2 : chain->multiple;
    }
    assert_int_equal(letters, cycle->N);
    ric_periodic_free(image);
    ric_periodic_free(again);
    ric_shooting_free(back);
    free(v);
}

static void round_trip(void **state)
{
    (void)state;
    over_random_orbits(check_round_trip);
}

/* The states of a cycle close up: the flight after the last impact leads back to the first. */
static void check_states(const ric_model *m, ric_shooting *chain, const double *u,
                         ric_periodic *cycle, const char *where)
{
    (void)chain;
    (void)u;
    double W[4 * MAX_FLIGHT * 2 * MAX_N];
    ric_periodic_states(m, cycle, W);
    for (int k = 0; k < cycle->N; k++) {
        ric_periodic *moved = ric_periodic_transform(m, cycle, k, false, false);
        for (int i = 0; i < 2 * m->n; i++)
            if (!(fabs(moved->w[i] - W[2 * m->n * k + i]) <= 1e-12 * 40))
                fail_msg("%s: state after impact %d", where, k);
        const ric_face *f = &m->face[cycle->face[k]];
        double s = 0;
        for (int i = 0; i < m->n; i++) s += f->g[i] * W[2 * m->n * k + i];
        if (!(fabs(s - f->gap) <= 1e-11 * 20))
            fail_msg("%s: impact %d is off its face by %.3g", where, k, s - f->gap);
        double alone[2 * MAX_N];
        ric_periodic_state(m, cycle, k, alone);
        assert_memory_equal(alone, W + 2 * m->n * k, 2 * (size_t)m->n * sizeof *W);
        ric_periodic_free(moved);
    }
    ric_periodic *around = ric_periodic_transform(m, cycle, cycle->N, false, false);
    check_distance(cycle, around, where, "once around");
    ric_periodic_free(around);
}

static void states_close_up(void **state)
{
    (void)state;
    over_random_orbits(check_states);
}

/* ------------------------------------------------------------------- group */

/* (s, r, m) takes impact i from s + (-1)^r i. Composition, and what becomes of the symmetries. */
static void check_group(const ric_model *m, ric_shooting *chain, const double *u,
                        ric_periodic *cycle, const char *where)
{
    (void)chain;
    (void)u;
    int N = cycle->N;
    for (int trial = 0; trial < 24; trial += every()) {
        int s1 = below(N), s2 = below(N), r1 = trial & 1, r2 = trial >> 1 & 1, m1 = trial >> 2 & 1,
            m2 = below(2);
        ric_periodic *first = ric_periodic_transform(m, cycle, s1, r1, m1),
                     *both = ric_periodic_transform(m, first, s2, r2, m2);
        ric_periodic *at_once = ric_periodic_transform(m, cycle, s1 + (r1 ? -s2 : s2), r1 != r2,
                                                       m1 != m2);
        ric_periodic *undone = ric_periodic_transform(m, first, r1 ? s1 : -s1, r1, m1);
        check_distance(both, at_once, where, "two operations and their product");
        check_distance(cycle, undone, where, "an operation undone");
        if (both->pure != at_once->pure || both->flip != at_once->flip ||
            both->half != at_once->half || undone->pure != cycle->pure ||
            undone->flip != cycle->flip || undone->half != cycle->half)
            fail_msg("%s: the symmetries do not follow (%d %d %d)(%d %d %d)", where, s1, r1, m1, s2,
                     r2, m2);
        for (int kind = 0; kind < 3; kind++) { /* they are symmetries of the image */
            int place = kind == 0     ? first->pure
                        : kind == 1   ? first->flip
                        : first->half ? N / 2
                                      : -1;
            if (place < 0) continue;
            ric_periodic *image = ric_periodic_transform(m, first, place, kind<2, kind> 0);
            check_distance(first, image, where,
                           kind == 0   ? "reversal"
                           : kind == 1 ? "reversal with mirror"
                                       : "half period");
            ric_periodic_free(image);
        }
        ric_periodic_free(first);
        ric_periodic_free(both);
        ric_periodic_free(at_once);
        ric_periodic_free(undone);
    }
}

static void transforms_are_a_group(void **state)
{
    (void)state;
    over_random_orbits(check_group);
}

/* ------------------------------------------------------------- symmetries */

static ric_periodic *repeat(const ric_periodic *c, int q)
{
    ric_periodic *out = ric_periodic_create(c->n, q * c->N);
    assert_non_null(out);
    for (int i = 0; i < q * c->N; i++) {
        out->face[i] = c->face[i % c->N];
        out->tau[i] = c->tau[i % c->N];
    }
    memcpy(out->w, c->w, 2 * (size_t)c->n * sizeof *c->w);
    return out;
}

static void check_symmetries(const ric_model *m, ric_shooting *chain, const double *u,
                             ric_periodic *cycle, const char *where)
{
    (void)u;
    ric_periodic *found = ric_periodic_copy(cycle);
    found->half = false;
    found->pure = found->flip = -1;
    int q = ric_periodic_find_symmetries(m, found, 1e-10);
    bool lost = (cycle->half && !found->half) || (cycle->pure >= 0 && found->pure < 0) ||
                (cycle->flip >= 0 && found->flip < 0);
    assert_int_equal(q, 1);
    if (lost)
        fail_msg("%s: symmetries %d %d %d, found %d %d %d", where, cycle->half, cycle->pure,
                 cycle->flip, found->half, found->pure, found->flip);
    if (chain->start != RIC_MIRROR_NONE)
        assert_true((cycle->pure < 0 || cycle->pure == found->pure) &&
                    (cycle->flip < 0 || cycle->flip == found->flip));
    /* a repeated orbit is recognised and cut back */
    for (int k = 2; k <= 3; k++) {
        ric_periodic *longer = repeat(cycle, k);
        int repetitions = ric_periodic_find_symmetries(m, longer, 1e-10);
        if (repetitions != k) fail_msg("%s: repeated %d times, found %d", where, k, repetitions);
        ric_periodic *shorter = ric_periodic_shorten(longer, k);
        check_distance(cycle, shorter, where, "repeated and cut");
        ric_periodic_find_symmetries(m, shorter, 1e-10);
        assert_true(shorter->half == found->half && shorter->pure == found->pure &&
                    shorter->flip == found->flip);
        ric_periodic_free(shorter);
        ric_periodic_free(longer);
    }
    /* a disturbed one has none */
    found->w[0] += 1e-3;
    ric_periodic_find_symmetries(m, found, 1e-10);
    assert_true(!found->half);
    ric_periodic_free(found);
}

static void symmetries_are_found(void **state)
{
    (void)state;
    over_random_orbits(check_symmetries);
}

/* --------------------------------------------------------- canonical form */

static void check_canonical(const ric_model *m, ric_shooting *chain, const double *u,
                            ric_periodic *cycle, const char *where)
{
    (void)chain;
    (void)u;
    int word[4 * MAX_FLIGHT + 2];
    ric_periodic *canonical = ric_periodic_canonical(m, cycle);
    assert_non_null(canonical);
    assert_int_equal(ric_word_canonical(m, cycle->N, cycle->face, true, word), RIC_OK);
    assert_memory_equal(canonical->face, word, (size_t)cycle->N * sizeof *word);
    for (int op = 0; op < 4; op++)
        for (int s = 0; s < cycle->N; s++) {
            ric_turn turn;
            ric_periodic *image = ric_periodic_transform(m, cycle, s, op & 1, op & 2),
                         *again = ric_periodic_canonical(m, image);
            check_distance(canonical, again, where, "canonical form of an image");
            if (canonical->half != again->half || canonical->pure != again->pure ||
                canonical->flip != again->flip)
                fail_msg("%s: canonical forms with other symmetries", where);
            if (!ric_periodic_match(m, cycle, image, 1e-10, &turn))
                fail_msg("%s: an image is not recognised", where);
            if (!ric_periodic_alike(m, cycle, image))
                fail_msg("%s: an image has another word", where);
            /* with one letter exchanged: words are alike if their canonical forms are one */
            int other[4 * MAX_FLIGHT + 2];
            image->face[s] = (image->face[s] + 1) % m->n_face;
            assert_int_equal(ric_word_canonical(m, image->N, image->face, true, other), RIC_OK);
            bool equal = !memcmp(word, other, (size_t)cycle->N * sizeof *word);
            if (ric_periodic_alike(m, cycle, image) != equal)
                fail_msg("%s: words that are %s", where,
                         equal ? "images of each other are told apart"
                               : "none are taken for images");
            ric_periodic_free(image);
            ric_periodic_free(again);
        }
    ric_periodic_free(canonical);
}

static void canonical_is_invariant(void **state)
{
    (void)state;
    over_random_orbits(check_canonical);
}

/* ------------------------------------------------------------------ images */

static bool same_bits(const ric_periodic *a, const ric_periodic *b)
{
    const size_t N = (size_t)a->N;
    return a->N == b->N && a->closed == b->closed && a->half == b->half && a->pure == b->pure &&
           a->flip == b->flip && !memcmp(a->face, b->face, N * sizeof *a->face) &&
           !memcmp(a->tau, b->tau, N * sizeof *a->tau) &&
           !memcmp(a->w, b->w, 2 * (size_t)a->n * sizeof *a->w);
}

/* Whether the word or a flight time of an image of a cycle tells it from the cycle. */
static bool tells_apart(const ric_periodic *cycle, const ric_periodic *image, double most)
{
    bool apart = memcmp(cycle->face, image->face, (size_t)cycle->N * sizeof *cycle->face);
    for (int i = 0; i < cycle->N; i++) apart = apart || fabs(cycle->tau[i] - image->tau[i]) > most;
    return apart;
}

/* The canonical form and the nearest image from all images, made one by one: what is only read off
 * the cycle is the same to the last bit. */
static void check_reading(const ric_model *m, ric_periodic *cycle, const ric_periodic *to,
                          const char *where)
{
    ric_periodic *least = ric_periodic_copy(cycle), *nearest = NULL;
    double distance = 1e-3;
    for (int op = 0; op < ric_periodic_operations(m); op++)
        for (int s = 0; s < cycle->N; s++) {
            ric_periodic *image = ric_periodic_transform(m, cycle, s, op & 1, op & 2);
            if (!image) continue;
            double off = ric_periodic_distance(to, image);
            assert_int_equal(ric_periodic_apart(m, cycle, s, op, 1e-3),
                             tells_apart(cycle, image, 1e-3));
            if (ric_periodic_compare(ric_periodic_springs(m), image, least) < 0) {
                ric_periodic_free(least);
                least = ric_periodic_copy(image);
            }
            if (off < distance) {
                distance = off;
                ric_periodic_free(nearest);
                nearest = image;
            } else ric_periodic_free(image);
        }
    ric_periodic *canonical = ric_periodic_canonical(m, cycle),
                 *found = ric_periodic_nearest(m, to, cycle, 1e-3);
    if (!same_bits(least, canonical)) fail_msg("%s: not the canonical form of all images", where);
    if (!found != !nearest || (found && !same_bits(found, nearest)))
        fail_msg("%s: not the nearest image", where);
    ric_periodic_free(least);
    ric_periodic_free(nearest);
    ric_periodic_free(canonical);
    ric_periodic_free(found);
}

static void check_images(const ric_model *m, ric_shooting *chain, const double *u,
                         ric_periodic *cycle, const char *where)
{
    (void)chain;
    (void)u;
    for (int k = 1; k <= 2; k++)
        for (int s = 0; s < cycle->N; s++) {
            ric_periodic *longer = ric_periodic_repeat(cycle, k),
                         *to = ric_periodic_transform(m, longer, s, s & 1, s & 2);
            to->w[0] += 1e-6;
            check_reading(m, longer, to, where);
            ric_periodic_free(longer);
            ric_periodic_free(to);
        }
}

static void images_are_read(void **state)
{
    (void)state;
    over_random_orbits(check_images);
}

/* -------------------------------------------------------------------- keep */

/* Drops touches of zero speed: the same motion with fewer impacts, and the symmetries that the
 * choice leaves. */
static void check_keep(const ric_model *m, const ric_periodic *cycle, const int *touch, int n_touch,
                       const char *where)
{
    for (unsigned choice = 0; choice < 1u << n_touch; choice++) {
        bool keep[64];
        int kept = cycle->N;
        for (int i = 0; i < cycle->N; i++) keep[i] = true;
        for (int i = 0; i < n_touch; i++)
            if (!(choice >> i & 1)) {
                keep[touch[i]] = false;
                kept--;
            }
        if (kept == 0) continue;
        ric_periodic *out = ric_periodic_keep(m, cycle, keep);
        ric_shooting *chain = NULL;
        double *u = NULL, T = ric_periodic_period(cycle), E = ric_periodic_energy(m, cycle);
        assert_non_null(out);
        assert_int_equal(out->N, kept);
        assert_true(fabs(ric_periodic_period(out) - T) <= 1e-12 * T &&
                    fabs(ric_periodic_energy(m, out) - E) <= 1e-11 * (1 + E));
        for (int i = 0, j = 0; i < cycle->N; i++)
            if (keep[i]) assert_int_equal(out->face[j++], cycle->face[i]);
        assert_int_equal(ric_periodic_to_chain(m, out, &chain, &u), RIC_OK);
        ric_shooting_fly(chain, u);
        if (!(chain->residual <= 1e-9))
            fail_msg("%s, choice %u: residual %.3g", where, choice, chain->residual);
        ric_periodic *found = ric_periodic_copy(out);
        int q = ric_periodic_find_symmetries(m, found, 1e-7);
        if (q == 1 &&
            (found->half != out->half || found->pure != out->pure || found->flip != out->flip))
            fail_msg("%s, choice %u: symmetries %d %d %d, found %d %d %d", where, choice, out->half,
                     out->pure, out->flip, found->half, found->pure, found->flip);
        ric_periodic_free(found);
        ric_periodic_free(out);
        ric_shooting_free(chain);
        free(u);
    }
}

static void touches_are_dropped(void **state)
{
    (void)state;
    int grazings = 0;
    char where[64];
    for (uint64_t seed = 1; seed <= 12; seed += (uint64_t)every()) {
        int n = 1 + (int)(seed % 6);
        ric_model *m = random_structure_of(seed, n, 1, false, false);
        for (int mode = 0; mode < n; mode++) {
            ric_node *node = NULL;
            assert_int_equal(ric_node_linear(m, mode, &node), RIC_OK);
            assert_non_null(node);
            snprintf(where, sizeof where, "seed %llu, mode %d", (unsigned long long)seed, mode + 1);
            check_keep(m, node->cycle, node->touch, node->n_touch, where);
            ric_node_free(node);
        }
        ric_model_free(m);
    }
    ric_study *study = NULL;
    ric_graph *graph = NULL;
    assert_int_equal(ric_study_read("examples/elementary/study.yaml", &study), RIC_OK);
    assert_int_equal(ric_graph_create(study, NULL, &graph), RIC_OK);
    assert_int_equal(ric_graph_explore(graph, NULL), RIC_OK);
    for (int i = 0; i < graph->n_node; i++) {
        ric_node *node = graph->nodes[i];
        if (node->kind != RIC_KIND_GRAZING) continue;
        snprintf(where, sizeof where, "elementary, grazing at E %.6g", node->energy);
        check_keep(graph->model, node->cycle, node->touch, node->n_touch, where);
        grazings++;
    }
    assert_true(grazings >= 6);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* Images under x -> -x exist where every face that is met has an opposite, and where every spring
 * has one that is closed all the while. */
static void images_that_exist(void **state)
{
    (void)state;
    double M[] = {0.645, 0, 0, 1.305}, K[] = {5.93, -4.0809, -4.0809, 5.4961}, b[] = {0, 1, -1, 1};
    ric_contact contacts[2] = {{.normal = b, .clearance = 1.235, .sides = RIC_SIDES_UPPER},
                               {.normal = b + 2,
                                .clearance = 1.582,
                                .sides = RIC_SIDES_LOWER,
                                .law = RIC_LAW_BILINEAR,
                                .stiffness = 300}};
    for (int sides = 0; sides < 2; sides++) {
        ric_model *m = NULL;
        for (int f = 0; sides && f < 2; f++) contacts[f].sides = RIC_SIDES_BOTH;
        assert_int_equal(ric_model_create(2, M, K, 2, contacts, 1, &m), RIC_OK);
        assert_int_equal(ric_periodic_operations(m), sides ? 4 : 2);
        for (int spring = 0; spring < 2; spring++) {
            ric_periodic *c = ric_periodic_create(2, 1);
            c->tau[0] = 1;
            c->closed = spring ? 2 : 0;
            ric_periodic *image = ric_periodic_transform(m, c, 0, false, true),
                         *back = ric_periodic_transform(m, c, 0, true, 0);
            assert_int_equal(ric_periodic_mirrors(m, c), sides);
            assert_int_equal(image != NULL, sides);
            assert_non_null(back);
            ric_periodic_free(c);
            ric_periodic_free(image);
            ric_periodic_free(back);
        }
        ric_model_free(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip),
        cmocka_unit_test(states_close_up),
        cmocka_unit_test(transforms_are_a_group),
        cmocka_unit_test(symmetries_are_found),
        cmocka_unit_test(canonical_is_invariant),
        cmocka_unit_test(images_are_read),
        cmocka_unit_test(touches_are_dropped),
        cmocka_unit_test(images_that_exist),
    };
    return cmocka_run_group_tests_name("cycle", tests, NULL, NULL);
}
