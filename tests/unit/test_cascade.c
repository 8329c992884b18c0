/* Cascades of period multiplications: the constant of area-preserving doublings, the article's path
 * in F_1^8, long orbits and their accuracy, the kernel of long chains against the dense one, and
 * all of it with a cubic spring. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <lapacke.h>

#include "explored.h"
#include "sample.h"
#include "branch/symmetry.h"

/* DELTA: ratio of successive parameter differences of doublings of area-preserving maps */
#define DELTA 8.721097200

static const char *const article =
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {energy: [0, 200], frequency: [0.2, 10], impacts: 6, multiply: 1, depth: 2}\n";

/* The cubic spring of section 3.3: both backbones and nothing else, and the same with what leaves
 * them by doubling. */
static const char cubic[] = "title: t\nmodel: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, "
                            "1]], contacts: [{normal: [-1, 1], law: power, "
                            "exponent: 3, length: 1, reference: 1}]}\nexplore: {energy: [0, 880], "
                            "frequency: [0.2, 10], multiply: %d, depth: "
                            "%d}\n";

/* Only S2- and what leaves it by 3. */
static const char *const article_with_s6 =
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {start: [2], energy: [0, 40], frequency: [1, 10], impacts: 6, depth: 0, cascade: "
    "[3]}\n";

static const char *const guided =
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {start: [2], energy: [0, 40], frequency: [0.6, 10], impacts: 12, depth: 0, cascade: "
    "[3, 2]}\n";

static ric_cascade *follow(const ric_atlas *atlas, const char *label, int n, const int *multiple,
                           const int *rotation, bool to_end)
{
    ric_cascade *cascade = NULL;
    const ric_cascade_options options = {.n = n,
                                         .multiple = multiple,
                                         .rotation = rotation,
                                         .to_end = to_end};
    if (ric_cascade_follow(atlas, branch_named(atlas, label), &options, &cascade))
        fail_msg("%s", ric_detail());
    return cascade;
}

static ric_cascade_step step_of(const ric_cascade *cascade, int i)
{
    ric_cascade_step out;
    assert_int_equal(ric_cascade_step_at(cascade, i, &out), RIC_OK);
    return out;
}

static void doublings_converge(void **state)
{
    (void)state;
    const int twos[] = {2, 2, 2, 2, 2, 2, 2};
    ric_atlas *atlas = explore_text(article);
    ric_cascade *cascade = follow(atlas, "A5[00101]", 7, twos, NULL, false);
    assert_int_equal(ric_cascade_length(cascade), 7);
    for (int i = 0; i < 7; i++) {
        ric_cascade_step s = step_of(cascade, i);
        if (s.impacts != 5 << i || s.symmetric) fail_msg("doubling %d: %d impacts", i, s.impacts);
        if (!(s.residual < 1e-13)) fail_msg("doubling %d: residual %g", i, s.residual);
        if (!(s.return_error < 1e-9)) fail_msg("doubling %d: returns to %g", i, s.return_error);
        if (i >= 2 && fabs(s.ratio - DELTA) > 0.3 / (1 << (i - 2)))
            fail_msg("doubling %d: ratio %.7f", i, s.ratio);
    }
    /* from independent data: doubling of A5[00101] */
    assert_true(fabs(step_of(cascade, 0).energy - 28.565381100457987) < 1e-9);
    if (fabs(step_of(cascade, 6).ratio - DELTA) > 1e-3)
        fail_msg("ratio %.9f", step_of(cascade, 6).ratio);
    ric_cascade_free(cascade);
    ric_atlas_free(atlas);
}

static void long_orbits_keep_their_digits(void **state)
{
    (void)state;
    const int q[] = {8, 8, 4, 2};
    ric_atlas *atlas = explore_text(article_with_s6);
    ric_cascade *cascade = follow(atlas, "S6[010101]", 4, q, NULL, false);
    ric_cascade_step s = step_of(cascade, 3);
    double sum = 0;
    assert_int_equal(s.impacts, 1536);
    if (!(s.residual < 1e-13)) fail_msg("residual %g", s.residual);
    if (!(s.return_error < 1e-9)) fail_msg("returns to %g", s.return_error);
    for (int k = 0; k < s.impacts; k++) sum += s.flights[k];
    assert_true(fabs(sum * s.frequency / (2 * acos(-1)) - 1) < 1e-13);
    const double energy = ric_model_energy(ric_atlas_model(atlas), s.state, s.state + 2);
    assert_true(fabs(energy / s.energy - 1) < 1e-13);
    ric_cascade_free(cascade);
    ric_atlas_free(atlas);
}

static void path_of_the_article(void **state)
{
    (void)state;
    const int q[] = {3, 2, 4}, p[] = {2, 0, 0};
    const double energy[] = {3.8487372168924985,
                             17.8169663303}; /* reference, as is the doubling of S6 */
    ric_atlas *atlas = explore_text(article);
    ric_cascade *cascade = follow(atlas, "S2-[01]", 3, q, p, true);
    assert_int_equal(ric_cascade_length(cascade), 4);
    const int impacts[] = {2, 6, 12, 46};
    for (int i = 0; i < 4; i++) {
        ric_cascade_step s = step_of(cascade, i);
        assert_int_equal(s.impacts, impacts[i]);
        assert_int_equal(s.multiple, i < 3 ? q[i] : 1);
        assert_int_equal(s.grazings, i < 3 ? 0 : 2);
        assert_true(s.symmetric == (i < 2));
        if (i < 2 && fabs(s.energy / energy[i] - 1) > 1e-10)
            fail_msg("step %d: energy %.14g", i, s.energy);
        assert_true((i == 0) == (s.n_point == 0));
    }
    /* the last family starts with the displacements of the orbit that it leaves, each four times,
     * and ends at the frequency of the end */
    double x[48 * 2], first[48 * 2];
    ric_point point;
    assert_int_equal(ric_cascade_impacts(cascade, 3), 48);
    assert_int_equal(ric_cascade_point(cascade, 3, 0, &point, x), RIC_OK);
    assert_true(fabs(4 * point.frequency / step_of(cascade, 2).frequency - 1) < 1e-10);
    for (int k = 0; k < 48; k++)
        for (int i = 0; i < 2; i++)
            assert_true(fabs(x[2 * k + i] - x[2 * ((k + 12) % 48) + i]) < 1e-8);
    const int last = step_of(cascade, 3).n_point - 1;
    assert_int_equal(ric_cascade_point(cascade, 3, last, &point, first), RIC_OK);
    assert_true(fabs(point.frequency / step_of(cascade, 3).frequency - 1) < 1e-8);
    ric_cascade_free(cascade);
    ric_atlas_free(atlas);
}

/* ---------------------------------------------------------------- law power */

static ric_atlas *explore_cubic(int multiply, int depth)
{
    char text[512];
    snprintf(text, sizeof text, cubic, multiply, depth);
    return explore_text(text);
}

/* Sum of the multipliers of the orbit of a step, from motions of the simulator beside it: 2 for the
 * flow and the energy, 2 cos(2 pi p / q). */
static void check_multipliers(const ric_model *m, const ric_cascade_step *s)
{
    enum { SIZE = 4 };
    const double h = 1e-6, period = 2 * acos(-1) / s->frequency;
    double trace = 0;
    for (int i = 0; i < SIZE; i++)
        for (int side = -1; side <= 1; side += 2) {
            ric_simulator *sim = NULL;
            ric_impact impact;
            bool hit;
            double x[SIZE];
            memcpy(x, s->state, sizeof x);
            x[i] += side * h;
            assert_int_equal(ric_simulator_create(m, &sim), RIC_OK);
            assert_int_equal(ric_simulator_start(sim, x, x + 2), RIC_OK);
            assert_int_equal(ric_simulator_advance(sim, period, &hit, &impact), RIC_OK);
            ric_simulator_state(sim, NULL, x, x + 2);
            trace += side * x[i] / (2 * h);
            ric_simulator_free(sim);
        }
    double expected = 2 + 2 * cos(2 * acos(-1) * s->rotation[0] / s->multiple);
    if (!(fabs(trace - expected) < 1e-5))
        fail_msg("%d/%d at energy %.9g: multipliers add up to %.9g", s->rotation[0], s->multiple,
                 s->energy, trace);
}

static void doublings_of_a_cubic_spring(void **state)
{
    (void)state;
    const int twos[] = {2, 2, 2, 2, 2, 2, 2}, length = long_form() ? 7 : 5;
    ric_atlas *atlas = explore_cubic(1, 1);
    ric_cascade *cascade = follow(atlas, "S+", length, twos, NULL, false);
    assert_int_equal(ric_cascade_length(cascade), length);
    for (int i = 0; i < length; i++) {
        ric_cascade_step s = step_of(cascade, i);
        if (s.impacts != 0 || s.letters != 0 || s.symmetric != (i == 0))
            fail_msg("doubling %d: %d impacts", i, s.impacts);
        if (!(s.residual < 1e-12 && s.return_error < 1e-9))
            fail_msg("doubling %d: residual %g, returns to %g", i, s.residual, s.return_error);
        if (i >= 3 && fabs(s.ratio - DELTA) > 2 * pow(0.2, i - 3))
            fail_msg("doubling %d: ratio %.7f", i, s.ratio);
        assert_true(fabs(s.flights[0] * s.frequency / (2 * acos(-1)) - 1) < 1e-13);
        if (i < 4) check_multipliers(ric_atlas_model(atlas), &s);
    }
    ric_cascade_free(cascade);
    ric_atlas_free(atlas);
}

/* Fig. 29: from the out-of-phase mode by 3, 2 and 4. Displacements are taken once in a period of
 * that mode, and those of x2 start at 0. */
static void path_at_n_3(void **state)
{
    (void)state;
    const int q[] = {3, 2, 4}, p[] = {2, 0, 0};
    const double energy[] = {109.859528466023, 737.247544040769,
                             719.909796156005}; /* those of docs/gallery.md */
    const double frequency[] = {1.61672208528233, 0.799503810679707,
                                0.199896817752509}; /* over the multiplicity */
    ric_atlas *atlas = explore_cubic(1, 1);
    ric_cascade *cascade = follow(atlas, "S-", 3, q, p, true);
    assert_int_equal(ric_cascade_length(cascade), 4);
    for (int i = 0; i < 3; i++) {
        ric_cascade_step s = step_of(cascade, i);
        if (fabs(s.energy / energy[i] - 1) > 1e-10 ||
            fabs(s.frequency / q[i] / frequency[i] - 1) > 1e-10)
            fail_msg("step %d: energy %.14g, frequency %.14g", i, s.energy, s.frequency / q[i]);
        assert_true(s.residual < 1e-13 && s.return_error < 1e-11);
        assert_true(s.symmetric == (i < 2));
        check_multipliers(ric_atlas_model(atlas), &s);
    }
    double x[24 * 2];
    ric_point point;
    assert_int_equal(ric_cascade_impacts(cascade, 1), 3);
    assert_int_equal(ric_cascade_impacts(cascade, 3), 24);
    assert_int_equal(ric_cascade_point(cascade, 1, 0, &point, x), RIC_OK);
    for (int k = 0; k < 3; k++)
        assert_true(fabs(x[2 * k + 1]) < 1e-9); /* three times round S- from its centre */
    assert_int_equal(ric_cascade_point(cascade, 3, 0, &point, x), RIC_OK);
    for (int k = 0; k < 24; k++)
        for (int i = 0; i < 2; i++)
            assert_true(fabs(x[2 * k + i] - x[2 * ((k + 6) % 24) + i]) <
                        1e-6 * (1 + fabs(x[2 * k + i])));
    ric_cascade_free(cascade);
    ric_atlas_free(atlas);
}

/* The elementary structure is inherited (Fig. 24, 25): F_1^1 is the in-phase path with its bridge,
 * F_2^1 the other backbone, and F_2^2 the closed loop that leaves its doublings. */
static void bases_of_a_cubic_spring(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_cubic(2, 2);
    ric_bases *bases = NULL;
    int found = 0;
    assert_int_equal(ric_bases_find(atlas, 0, &bases), RIC_OK);
    for (int i = 0; i < ric_bases_n(bases); i++) {
        ric_base base;
        assert_int_equal(ric_bases_get(bases, i, &base), RIC_OK);
        if (base.j > base.mode) continue;
        found++;
        if (base.j == base.mode && base.mode == 1) {
            assert_int_equal(base.n_branch, 2);
            assert_int_equal(branch_of(atlas, base.branches[0]).mode, 1);
            ric_branch bridge = branch_of(atlas, base.branches[1]);
            assert_true(fabs(bridge.energy_min / 2.764187897 - 1) < 1e-9 &&
                        fabs(bridge.energy_max / 490.609515779 - 1) < 1e-9);
        }
        if (base.j == 1 && base.mode == 2) {
            assert_int_equal(base.n_branch, 1);
            assert_int_equal(branch_of(atlas, base.branches[0]).mode, 2);
        }
        if (base.j == 2 && base.mode == 2) {
            assert_int_equal(base.n_branch, 2);
            ric_branch a = branch_of(atlas, base.branches[0]),
                       b = branch_of(atlas, base.branches[1]);
            assert_true(a.from && a.to && a.from != a.to && a.from == b.from && a.to == b.to);
            assert_int_equal(junction_of(atlas, a.from).multiple, 2);
            assert_int_equal(junction_of(atlas, a.to).multiple, 2);
        }
        for (int k = 0; k < base.n_branch; k++)
            assert_true(ric_bases_elementary(bases, base.branches[k]));
    }
    assert_int_equal(found, 3);
    ric_bases_free(bases);
    ric_atlas_free(atlas);
}

static void requests_are_checked(void **state)
{
    (void)state;
    const int two[] = {2}, wrong[] = {1}, many[] = {2, 64, 64, 64};
    ric_atlas *atlas = explore_text(article);
    ric_cascade *cascade = NULL;
    ric_cascade_options options = {.n = 1, .multiple = two};
    assert_int_equal(ric_cascade_follow(atlas, 1, &options, &cascade),
                     RIC_E_RANGE); /* a linear mode */
    assert_int_equal(ric_cascade_follow(atlas, 1000, &options, &cascade), RIC_E_RANGE);
    options.multiple = wrong;
    assert_int_equal(ric_cascade_follow(atlas, branch_named(atlas, "A5[00101]"), &options,
                                        &cascade),
                     RIC_E_INPUT);
    /* A3[001] is never stable */
    options.multiple = many;
    assert_int_equal(ric_cascade_follow(atlas, branch_named(atlas, "A3[001]"), &options, &cascade),
                     RIC_E_RANGE);
    assert_non_null(strstr(ric_detail(), "0 of 1"));
    assert_null(cascade);
    ric_atlas_free(atlas);
}

static void guided_run(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(guided);
    ric_branch b;
    int twelve = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        assert_int_equal(ric_atlas_branch(atlas, id, &b), RIC_OK);
        if (b.impacts != 0 && b.impacts != 1 && b.impacts != 2 && b.impacts != 6 && b.impacts != 12)
            fail_msg("%s", b.label);
        if (b.depth != (b.impacts == 12 ? 3 : b.impacts == 6 ? 2 : b.impacts ? 1 : 0))
            fail_msg("%s at depth %d", b.label, b.depth);
        twelve += b.impacts == 12;
    }
    assert_true(twelve >= 2);
    ric_atlas_free(atlas);
}

/* The plane that the structured factorisation gives is that of the dense singular value
 * decomposition, at a multiplication of every form. */
static void kernels_agree(void **state)
{
    (void)state;
    const int q[] = {3, 2, 4}, p[] = {2, 0, 0};
    ric_atlas *atlas = explore_text(article);
    const ric_model *m = ric_atlas_model(atlas);
    ric_cascade *cascade = follow(atlas, "S2-[01]", 3, q, p, false);
    for (int i = 0; i < 3; i++) {
        ric_cascade_step s = step_of(cascade, i);
        ric_periodic *orbit = ric_periodic_create(m->n, s.impacts);
        ric_symmetry problems[2];
        memcpy(orbit->face, s.word, (size_t)s.impacts * sizeof *s.word);
        for (int k = 0; k < s.impacts; k++) orbit->tau[k] = s.flights[k] * m->omega_ref;
        ric_model_from_state(m, s.state, s.state + m->n_dof, orbit->w);
        ric_periodic_find_symmetries(m, orbit, 1e-8);
        int count = ric_symmetry_multiplying(orbit, s.rotation[0], s.rotation[1], problems);
        for (int k = 0; k < count; k++) {
            ric_shooting *c = NULL;
            double *u = NULL, second;
            ric_periodic *repeated = ric_symmetry_cycle(orbit, &problems[k]);
            assert_int_equal(ric_periodic_to_chain(m, repeated, &c, &u), RIC_OK);
            int size = c->n_unknown;
            double *J = calloc((size_t)(c->n_flight + 2 * c->n + 2) * size, sizeof *J),
                   *plane = calloc(2 * (size_t)size, sizeof *plane);
            ric_shooting_evaluate(c, u);
            assert_true(ric_shooting_plane(c, plane, &second));
            if (!(second < 1e-7))
                fail_msg("step %d, problem %d: second singular value %g", i, k, second);
            int rows = ric_shooting_jacobian(c, u, J);
            for (int v = 0; v < 2; v++)
                for (int r = 0; r < rows; r++) {
                    double sum = 0;
                    for (int j = 0; j < size; j++) sum += J[r * size + j] * plane[v * size + j];
                    if (!(fabs(sum) < 1e-6))
                        fail_msg("step %d, problem %d: row %d of vector %d is %g", i, k, r, v, sum);
                }
            double aa = 0, ab = 0, bb = 0;
            for (int j = 0; j < size; j++) {
                aa += plane[j] * plane[j];
                ab += plane[j] * plane[size + j];
                bb += plane[size + j] * plane[size + j];
            }
            assert_true(fabs(aa - 1) + fabs(ab) + fabs(bb - 1) < 1e-12);
            free(J);
            free(plane);
            free(u);
            ric_shooting_free(c);
            ric_periodic_free(repeated);
        }
        ric_periodic_free(orbit);
    }
    ric_cascade_free(cascade);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(doublings_converge),   cmocka_unit_test(long_orbits_keep_their_digits),
        cmocka_unit_test(path_of_the_article),  cmocka_unit_test(doublings_of_a_cubic_spring),
        cmocka_unit_test(path_at_n_3),          cmocka_unit_test(bases_of_a_cubic_spring),
        cmocka_unit_test(requests_are_checked), cmocka_unit_test(guided_run),
        cmocka_unit_test(kernels_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
