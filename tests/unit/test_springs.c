/* Orbits with contacts of law bilinear: the orbit problem against differences and a dense solve,
 * its regular passage through a grazing, values published elsewhere, the limit of stiff springs,
 * words, and atlases of random structures replayed by the simulator. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "random_models.h"
#include "model/word.h"
#include "sample.h"

enum { MAX = 60 };

static ric_model *structure(uint64_t seed, int n, int n_contact, double stiffest)
{
    double M[n * n], K[n * n], normal[n_contact * n];
    ric_contact contacts[n_contact];
    ric_model *model = NULL;
    seed_now = seed;
    random_definite(n, n, 0.5, M);
    random_definite(n, n, 0.3, K);
    for (int f = 0; f < n_contact; f++) {
        for (int i = 0; i < n; i++) normal[f * n + i] = uniform(-1, 1);
        contacts[f] = (ric_contact){.normal = normal + f * n,
                                    .clearance = uniform(0.5, 2),
                                    .law = RIC_LAW_BILINEAR,
                                    .stiffness = pow(10, uniform(0, stiffest))};
    }
    if (ric_model_create(n, M, K, n_contact, contacts, 1, &model))
        fail_msg("seed %llu: %s", (unsigned long long)seed, ric_detail());
    return model;
}

/* ------------------------------------------------------------ orbit problem */

/* Chains over contacts that close and open, one inside another, from rest to rest, from the centre
 * to rest, and from a closing round; some closed flights last no time, or a negative one. */
static void jacobians(void **state)
{
    (void)state;
    static const struct {
        ric_mirror start, end;
        int n_flight, face[8];
        uint64_t closed;
    } cases[] = {
        {RIC_MIRROR_CENTRE, RIC_MIRROR_REST, 2, {-1, 0, -1}, 0},
        {RIC_MIRROR_CENTRE, RIC_MIRROR_REST, 4, {-1, 0, 0, 1, -1}, 0},
        {RIC_MIRROR_REST, RIC_MIRROR_REST, 6, {-1, 0, 2, 2, 1, 1, -1}, 1},
        {RIC_MIRROR_REST, RIC_MIRROR_REST, 5, {-1, 2, 0, 2, 0, -1}, 1},
        {RIC_MIRROR_NONE, RIC_MIRROR_NONE, 4, {0, 0, 1, 1, 0}, 1},
        {RIC_MIRROR_NONE, RIC_MIRROR_NONE, 6, {0, 2, 0, 2, 1, 1, 0}, 1},
    };
    for (unsigned seed = 1; seed <= 30; seed += (unsigned)every())
        for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
            ric_model *m = structure(seed, 2 + (int)seed % 2, 2, 2);
            ric_shooting *c = NULL;
            double u[MAX], J[MAX * MAX], plus[MAX], minus[MAX], h = 1e-5;
            assert_int_equal(ric_shooting_create(m, cases[k].start, cases[k].end, 1,
                                                 cases[k].n_flight, cases[k].face, &c),
                             RIC_OK);
            ric_shooting_close(c, cases[k].closed);
            for (int i = 0; i < c->n_start; i++) u[i] = uniform(-2, 2);
            for (int i = c->n_start; i < c->n_unknown; i++)
                u[i] = ric_shooting_between(c, i - c->n_start) ? uniform(-0.2, 0.4) * below(2)
                                                               : uniform(0.1, 1);
            int rows = ric_shooting_jacobian(c, u, J);
            double top = 1;
            for (int i = 0; i < rows * c->n_unknown; i++) top = fmax(top, fabs(J[i]));
            for (int j = 0; j < c->n_unknown; j++) {
                double keep = u[j];
                u[j] = keep + h;
                ric_shooting_residuals(c, u, plus);
                u[j] = keep - h;
                ric_shooting_residuals(c, u, minus);
                u[j] = keep;
                for (int i = 0; i < rows; i++) {
                    double slope = (plus[i] - minus[i]) / (2 * h);
                    if (fabs(slope - J[i * c->n_unknown + j]) > 1e-7 * top * top)
                        fail_msg("seed %u case %zu row %d column %d: %g against %g", seed, k, i, j,
                                 J[i * c->n_unknown + j], slope);
                }
            }
            ric_shooting_free(c);
            ric_model_free(m);
        }
}

/* Newton steps of the structured solve lead to solutions, whose dense Jacobian has one kernel
 * vector: the same. */
static void kernels(void **state)
{
    (void)state;
    static const int face[] = {-1, 0, 0, 1, 1, -1};
    int found = 0;
    for (unsigned seed = 1; seed <= 400; seed += (unsigned)every()) {
        ric_model *m = structure(seed, 2, 1, 3);
        ric_shooting *c = NULL;
        double u[MAX], du[MAX], t[MAX], J[MAX * MAX];
        int iterations;
        assert_int_equal(ric_shooting_create(m, RIC_MIRROR_REST, RIC_MIRROR_CENTRE, 1, 5, face, &c),
                         RIC_OK);
        for (int i = 0; i < c->n_start; i++) u[i] = uniform(-2, 2);
        for (int i = c->n_start; i < c->n_unknown; i++) u[i] = uniform(0.1, 1);
        if (ric_continuation_correct(c, u, NULL, NULL, 0, du, &iterations) && c->smallest > 1e-3) {
            ric_continuation_tangent(c, NULL, t);
            int rows = ric_shooting_jacobian(c, u, J);
            for (int i = 0; i < rows; i++) {
                double product = ric_dot(c->n_unknown, J + i * c->n_unknown, t),
                       size = sqrt(
                           ric_dot(c->n_unknown, J + i * c->n_unknown, J + i * c->n_unknown));
                assert_true(fabs(product) <= 1e-9 * (1 + size));
            }
            found++;
        }
        ric_shooting_free(c);
        ric_model_free(m);
    }
    assert_true(found >= 20);
}

/* --------------------------------------------------------------- two masses */

static ric_atlas *two_masses(double ks, const char *explore)
{
    char text[600];
    snprintf(text, sizeof text,
             "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
             "    - {normal: [-1, 1], clearance: 1, sides: both, law: bilinear, stiffness: "
             "%.17g}\nexplore: {%s}\n",
             ks, explore);
    return explore_text(text);
}

static double omega_at_10(double ks)
{
    double omega = NAN;
    ric_atlas *atlas = two_masses(ks, "start: [1], energy: [0, 12], frequency: [0.2, 10], impacts: "
                                      "2, multiply: 1, depth: 1, at_energy: [10]");
    for (int i = 1; i <= ric_atlas_n_junction(atlas); i++) {
        ric_junction j = junction_of(atlas, i);
        if (j.kind == RIC_KIND_USER && j.impacts == 2) omega = j.frequency;
    }
    ric_atlas_free(atlas);
    return omega;
}

/* S2+ at E = 10: omega = 1.565493796 for ks = 1e4, 1.571293037 for rigid stops, and the difference
 * falls as ks^(-1/2). From its grazing the family first passes an extremum and a branch point at a
 * distance of 1/ks. */
static void stiff_limit(void **state)
{
    (void)state;
    double rigid = 1.571293037, last = 0;
    assert_true(fabs(omega_at_10(1e4) - 1.565493796) < 1e-8 * 1.565493796);
    for (int k = 4; k <= 9; k++) {
        double off = rigid - omega_at_10(pow(10, k));
        if (isnan(off) || (k > 4 && fabs(log10(off / last) + 0.5) > 0.01))
            fail_msg("ks = 1e%d: exponent %g", k, log10(off / last));
        last = off;
    }
}

static void replayed(const ric_atlas *atlas, const char *what)
{
    for (int b = 1; b <= ric_atlas_n_branch(atlas); b++)
        for (int i = 0; i < branch_of(atlas, b).n_point; i++) {
            ric_check check;
            assert_int_equal(ric_verify_point(atlas, b, i, &check), RIC_OK);
            if (!check.passed)
                fail_msg("%s: branch %d %s point %d: flight %g return %g energy %g faces %d", what,
                         b, branch_of(atlas, b).label, i, check.flight_error, check.return_error,
                         check.energy_error, check.faces_agree);
        }
}

/* The symmetric path: S2+ passes its grazing G_2,4 with all four touches kept, and nothing else
 * leaves there. The linear modes graze where they do with rigid stops. */
static void grazings(void **state)
{
    (void)state;
    ric_atlas *atlas =
        two_masses(1e4,
                   "energy: [0, 120], frequency: [0.2, 10], impacts: 6, multiply: 1, depth: 2");
    const ric_branch s2 = branch_of(atlas, branch_named(atlas, "S2+[01]")),
                     s6 = branch_of(atlas, branch_named(atlas, "S6[010101]"));
    ric_junction first = junction_of(atlas, s2.from), last = junction_of(atlas, s2.to);
    assert_true(fabs(first.energy - 0.601588369489) < 1e-11);
    assert_int_equal(last.kind, RIC_KIND_GRAZING);
    assert_int_equal(last.impacts, 2);
    assert_int_equal(last.grazings, 4);
    assert_true(s6.from == s2.to || s6.to == s2.to);
    assert_int_equal(last.departures.taken, 1);
    assert_int_equal(last.departures.known, 1);
    assert_int_equal(last.departures.refused, 0);
    assert_int_equal(s2.letters, 4);
    assert_int_equal(s2.impacts, 2);
    replayed(atlas, "two masses");
    ric_atlas_free(atlas);
}

/* At stiffnesses near to rigid stops the same orbits are there, from their grazings to the border
 * of the window, and the simulator finds them. */
static void stiff(void **state)
{
    (void)state;
    for (int k = 5; k <= 7; k++) {
        ric_atlas *atlas = two_masses(pow(10, k),
                                      "energy: [0, 1000], frequency: [0.2, 10], impacts: 12, "
                                      "multiply: 1, depth: 2, symmetric: true");
        assert_int_equal(branch_of(atlas, branch_named(atlas, "S2-[01]")).stop, RIC_STOP_WINDOW);
        branch_named(atlas, "S6[010101]");
        for (int b = 1; b <= ric_atlas_n_branch(atlas); b++)
            if (branch_of(atlas, b).stop == RIC_STOP_FAILED)
                fail_msg("ks = 1e%d: %s fails", k, branch_of(atlas, b).label);
        replayed(atlas, "stiff");
        ric_atlas_free(atlas);
    }
}

/* Many short contacts in a row, slow ones among them, and ends at branch points: every stored orbit
 * is one, to rounding. No multiplicity is larger than the kind of a point allows, however near the
 * grazing of a spring. */
static void every_point(void **state)
{
    (void)state;
    ric_atlas *atlas =
        two_masses(1e4,
                   "energy: [0, 200], frequency: [0.2, 10], impacts: 12, multiply: 3, depth: 3");
    assert_true(ric_atlas_n_branch(atlas) > 50);
    replayed(atlas, "wide");
    for (int b = 1; b <= ric_atlas_n_branch(atlas);
         b++) /* A8 and A12 to doublings on sharp turns, A3 beside an orbit with more symmetry */
        if (branch_of(atlas, b).stop == RIC_STOP_FAILED)
            fail_msg("branch %d %s: %s", b, branch_of(atlas, b).label, branch_of(atlas, b).why);
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        if (j.kind != RIC_KIND_GRAZING && (j.a > 3 || j.b > 3))
            fail_msg("%s at energy %.9g", j.label, j.energy);
    }
    ric_atlas_free(atlas);
}

/* dE/ds vanishes at a grazing: near it the energy is quadratic in the time of contact, on S2+ as E
 * - E_g ~ tau^2. */
static void quadratic(void **state)
{
    (void)state;
    ric_atlas *atlas = two_masses(
        100, "start: [1], energy: [0, 2], frequency: [0.2, 10], impacts: 2, multiply: 1, depth: 1");
    const ric_branch s2 = branch_of(atlas, branch_named(atlas, "S2+[01]"));
    ric_point zero, one;
    double flights[4];
    assert_int_equal(ric_atlas_point(atlas, s2.id, 0, &zero, NULL, flights), RIC_OK);
    assert_true(fabs(flights[0]) < 1e-12);
    double least = HUGE_VAL, most = 0;
    for (int i = 1; i <= 3; i++) {
        assert_int_equal(ric_atlas_point(atlas, s2.id, i, &one, NULL, flights), RIC_OK);
        double ratio = (one.energy - zero.energy) / (flights[0] * flights[0]);
        least = fmin(least, ratio);
        most = fmax(most, ratio);
    }
    assert_true(least > 0 && most < 1.2 * least);
    ric_atlas_free(atlas);
}

/* ------------------------------------------------------------------- others */

static void words(void **state)
{
    (void)state;
    ric_model *m = structure(3, 3, 2, 2); /* faces 0 1 2 3; openings 4 5 6 7 */
    static const struct {
        int n, word[8];
        const char *text;
        int impacts;
    } cases[] = {
        {4, {0, 4, 1, 5}, "01", 2},   {4, {0, 2, 4, 6}, "02-0-2", 2},
        {4, {0, 2, 6, 4}, "02-0", 2}, {6, {0, 2, 6, 2, 6, 4}, "022-0", 3},
        {2, {0, 4}, "0", 1},          {2, {4, 0}, "-00", 1},
        {4, {4, 1, 5, 0}, "-010", 2}, {8, {0, 3, 4, 7, 1, 2, 5, 6}, "03-0-312-1-2", 4},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char text[64];
        int n, *back;
        assert_int_equal(ric_word_format(m, cases[k].n, cases[k].word, sizeof text, text), RIC_OK);
        assert_string_equal(text, cases[k].text);
        assert_non_null(back = ric_word_read(m, text, &n));
        assert_int_equal(n, cases[k].n);
        assert_memory_equal(back, cases[k].word, (size_t)n * sizeof n);
        assert_int_equal(ric_word_impacts(m, n, back), cases[k].impacts);
        free(back);
    }
    int n, *none = ric_word_read(m, "09", &n);
    assert_int_equal(n, -1);
    free(none);
    ric_model_free(m);
}

/* Random structures with one or two contacts, soft and stiff, one of them rigid at times: every
 * stored orbit is found by the simulator. */
static void random_atlases(void **state)
{
    (void)state;
    int branches = 0, interleaved = 0;
    const int few = every_of(5); /* of all kinds, which go by 2, 3 and 4 */
    for (unsigned seed = 1; seed <= 24; seed += (unsigned)few) {
        char text[900], what[32];
        seed_now = 77 + seed;
        double m1 = uniform(0.5, 3), m2 = uniform(0.5, 3), m3 = uniform(0.5, 3),
               k1 = uniform(0.5, 9), k2 = uniform(0.3, 3), k3 = uniform(0.3, 3);
        double ks = pow(10, uniform(0.5, 4)), kt = pow(10, uniform(0.5, 3));
        const char *second = seed % 3 == 0 ? ", law: rigid" : ", law: bilinear, stiffness: ";
        int used =
            seed % 2
                ? snprintf(
                      text, sizeof text,
                      "model:\n  mass: [[%.15g, 0], [0, %.15g]]\n"
                      "  stiffness: [[%.15g, %.15g], [%.15g, %.15g]]\n  contacts:\n"
                      "    - {normal: [-1, 1], clearance: 1, sides: %s, law: bilinear, stiffness: "
                      "%.15g}\n",
                      m1, m2, k1 + k2, -k2, -k2, k2 + k3, seed % 4 == 1 ? "both" : "upper", ks)
                : snprintf(
                      text, sizeof text,
                      "model:\n  mass: [[%.15g, 0, 0], [0, %.15g, 0], [0, 0, %.15g]]\n"
                      "  stiffness: [[%.15g, %.15g, 0], [%.15g, %.15g, %.15g], [0, %.15g, %.15g]]\n"
                      "  contacts:\n"
                      "    - {normal: [1, 0, 0], clearance: 1, sides: both, law: bilinear, "
                      "stiffness: "
                      "%.15g}\n"
                      "    - {normal: [0, 0, 1], clearance: 1.3, sides: both%s",
                      m1, m2, m3, k1 + k2, -k2, -k2, k2 + k3, -k3, -k3, k3 + 1, ks, second);
        if (seed % 2 == 0 && seed % 3)
            used += snprintf(text + used, sizeof text - (size_t)used, "%.15g", kt);
        if (seed % 2 == 0) used += snprintf(text + used, sizeof text - (size_t)used, "}\n");
        snprintf(text + used, sizeof text - (size_t)used,
                 "explore: {energy: [0, %.15g], frequency: [0.1, 10], impacts: 6, multiply: 1, "
                 "depth: 2}\n",
                 8 * (k1 + k2));
        snprintf(what, sizeof what, "seed %u", seed);
        ric_atlas *atlas = explore_text(text);
        branches += ric_atlas_n_branch(atlas);
        for (int b = 1; b <= ric_atlas_n_branch(atlas); b++)
            interleaved += strchr(branch_of(atlas, b).label, '-') &&
                           branch_of(atlas, b).letters > 4;
        replayed(atlas, what);
        ric_atlas_free(atlas);
    }
    if (!(branches > 100 / few && interleaved > 5 / few))
        fail_msg("%d branches, %d interleaved", branches, interleaved);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(jacobians), cmocka_unit_test(kernels), cmocka_unit_test(stiff_limit),
        cmocka_unit_test(grazings),  cmocka_unit_test(stiff),   cmocka_unit_test(every_point),
        cmocka_unit_test(quadratic), cmocka_unit_test(words),   cmocka_unit_test(random_atlases),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
