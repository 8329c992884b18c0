/* Structures with their lowest modes only: against the same structure written down in modal
 * coordinates, where leaving out the rest is leaving out rows. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "model/room.h"
#include "random_models.h"

enum { N = 6 };

static ric_model *random_model(double stiffness)
{
    static double M[N * N], K[N * N], b[2][N];
    ric_model *m = NULL;
    random_definite(N, N, 0.5, M);
    random_definite(N, N, 0.2, K);
    for (int i = 0; i < N; i++) {
        b[0][i] = uniform(-1, 1);
        b[1][i] = uniform(-1, 1);
    }
    const ric_contact contacts[2] = {
        {.normal = b[0],
         .clearance = uniform(0.5, 2),
         .law = stiffness > 0 ? RIC_LAW_BILINEAR : RIC_LAW_RIGID,
         .stiffness = stiffness},
        {.normal = b[1], .clearance = uniform(0.5, 2)},
    };
    assert_int_equal(ric_model_create(N, M, K, 2, contacts, 1, &m), RIC_OK);
    return m;
}

/* Of the modes that are kept nothing changes, of the others contacts see nothing, not even
 * rounding. */
static void the_rest_is_not_seen(void **state)
{
    (void)state;
    seed_now = 71;
    for (int k = 0; k < 40; k++) {
        ric_model *full = random_model(k % 2 ? 3 : 0), *some = NULL;
        const int kept = 1 + k % N;
        assert_int_equal(ric_model_truncate(full, kept, &some), RIC_OK);
        assert_int_equal(ric_model_n_mode(some), kept);
        assert_memory_equal(full->Phi, some->Phi, N * N * sizeof *full->Phi); /* found once */
        assert_memory_equal(full->frequency_low, some->frequency_low,
                            N * sizeof *full->frequency_low);
        double c[2][2 * N], frequency[2][N], compliance[2][N];
        ric_model_modal_normals(full, c[0]);
        ric_model_modal_normals(some, c[1]);
        ric_model_frequencies(full, frequency[0]);
        ric_model_frequencies(some, frequency[1]);
        for (int i = 0; i < N; i++) {
            assert_true(frequency[0][i] == frequency[1][i]);
            for (int f = 0; f < 2; f++)
                assert_true(fabs(c[1][f * N + i] - (i < kept ? c[0][f * N + i] : 0)) < 1e-11);
        }
        for (int f = 0; f < 2; f++) {
            ric_contact a, b;
            double rest = 0;
            ric_model_compliance(full, f, compliance[0]);
            ric_model_compliance(some, f, compliance[1]);
            assert_true(fabs(compliance[1][N - 1] / compliance[0][kept - 1] - 1) < 1e-11);
            ric_model_contact(full, f, &a);
            ric_model_contact(some, f, &b);
            for (int i = kept; i < N; i++) rest += pow(c[0][f * N + i] / frequency[0][i], 2);
            assert_true(a.clearance == b.clearance && a.law == b.law);
            if (a.law == RIC_LAW_BILINEAR)
                assert_true(fabs(b.stiffness * (1 / a.stiffness + rest) - 1) < 1e-12);
        }
        ric_model_free(full);
        ric_model_free(some);
    }
}

/* A force at the contact moves it as in the structure with all modes: the modes that are kept, and
 * the spring that has become softer. */
static void the_static_compliance_is_kept(void **state)
{
    (void)state;
    seed_now = 72;
    for (int k = 0; k < 20; k++) {
        const double stiffness = uniform(0.5, 50);
        ric_model *full = random_model(stiffness), *some = NULL;
        const int kept = 1 + k % (N - 1);
        assert_int_equal(ric_model_truncate(full, kept, &some), RIC_OK);
        double c[2 * N], frequency[N], all = 1 / stiffness, left = 0;
        ric_contact spring;
        ric_model_modal_normals(full, c);
        ric_model_frequencies(full, frequency);
        ric_model_contact(some, 0, &spring);
        for (int i = 0; i < N; i++) all += pow(c[i] / frequency[i], 2);
        for (int i = 0; i < kept; i++) left += pow(c[i] / frequency[i], 2);
        assert_true(fabs((left + 1 / spring.stiffness) / all - 1) < 1e-12);
        ric_model_free(full);
        ric_model_free(some);
    }
}

/* A chain of four masses with a stop, and its two lowest modes: as they are left by the key and as
 * a study of two modal coordinates the atlas is one. */
static void the_atlas_is_that_of_modal_coordinates(void **state)
{
    (void)state;
    static const char chain[] =
        "model:\n  mass: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
        "  stiffness: [[2, -1, 0, 0], [-1, 2, -1, 0], [0, -1, 2, -1], [0, 0, -1, 1]]\n"
        "  contacts: [{normal: [0, 0, 0, 1], clearance: 1}]\n";
    static const char explore[] =
        "explore: {energy: [0, 40], frequency: [0.05, 8], impacts: 6, multiply: 2, depth: 2}\n";
    char text[2048];
    snprintf(text, sizeof text, "%s  modes: 2\n%s", chain, explore);
    ric_atlas *kept = explore_text(text);
    double frequency[4], c[4];
    const ric_model *m = ric_atlas_model(kept);
    ric_model_frequencies(m, frequency);
    ric_model_modal_normals(m, c);
    snprintf(text, sizeof text,
             "model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[%.17g, 0], [0, %.17g]]\n"
             "  contacts: [{normal: [%.17g, %.17g], clearance: 1}]\n%s",
             frequency[0] * frequency[0], frequency[1] * frequency[1], c[0], c[1], explore);
    ric_atlas *modal = explore_text(text);
    int n = 0;
    for (int id = 1; id <= ric_atlas_n_branch(modal); id++) {
        const ric_branch b = branch_of(modal, id);
        bool found = false;
        if (b.impacts == 0) continue;
        n++;
        for (int other = 1; other <= ric_atlas_n_branch(kept) && !found; other++) {
            const ric_branch a = branch_of(kept, other);
            found = a.letters == b.letters &&
                    !memcmp(a.word, b.word, (size_t)a.letters * sizeof *a.word) &&
                    fabs(a.energy_min / b.energy_min - 1) < 1e-8 &&
                    fabs(a.energy_max / b.energy_max - 1) < 1e-8 &&
                    fabs(a.frequency_min / b.frequency_min - 1) < 1e-8 &&
                    fabs(a.frequency_max / b.frequency_max - 1) < 1e-8;
            if (found) point_passes(kept, other, a.n_point / 2);
        }
        if (!found) fail_msg("branch %s of the modal coordinates is missing", b.label);
    }
    assert_true(n > 4);
    ric_atlas_free(kept);
    ric_atlas_free(modal);
}

static void what_cannot_be_kept_is_refused(void **state)
{
    (void)state;
    static const double M[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, K[9] = {1, 0, 0, 0, 4, 0, 0, 0, 4};
    const ric_contact third = {.normal = (const double[]){0, 0.6, 0.8}, .clearance = 1};
    ric_model *m = NULL, *out = NULL;
    assert_int_equal(ric_model_create(3, M, K, 1, &third, 1, &m), RIC_OK);
    assert_int_equal(ric_model_truncate(m, 0, &out), RIC_E_INPUT);
    assert_int_equal(ric_model_truncate(m, 4, &out), RIC_E_INPUT);
    assert_int_equal(ric_model_truncate(m, 2, &out), RIC_E_INPUT);
    assert_non_null(strstr(ric_detail(), "one frequency"));
    assert_int_equal(ric_model_truncate(m, 1, &out), RIC_E_INPUT);
    assert_non_null(strstr(ric_detail(), "seen by none"));
    assert_null(out);
    ric_model_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_rest_is_not_seen),
        cmocka_unit_test(the_static_compliance_is_kept),
        cmocka_unit_test(the_atlas_is_that_of_modal_coordinates),
        cmocka_unit_test(what_cannot_be_kept_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
