/* What the header says of threads: one atlas, which is only read, serves several at once, and each
 * has the answers and the messages that it would have alone. Under `make race` a write would be
 * seen. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ricochet.h"

enum { THREADS = 4 };

typedef struct {
    const ric_atlas *atlas;
    int branch; /* that this thread asks for besides, which is not there */
    double sum[8];
    char message[200];
    bool failed;
} reader;

/* Questions of all kinds; the sums tell whether two readers have had the same answers. */
static void ask_branch(reader *r, int id)
{
    ric_branch b;
    ric_check check;
    ric_claims claims;
    ric_orbit **orbits = NULL;
    int n = 0, *sample = NULL;
    r->failed |= ric_atlas_branch(r->atlas, id, &b) != RIC_OK ||
                 !(sample = calloc((size_t)b.n_point, sizeof *sample));
    if (r->failed) return;
    double *energy = calloc((size_t)b.n_point, sizeof *energy);
    r->failed |= !energy || ric_atlas_column(r->atlas, id, "energy", &n, energy) != RIC_OK;
    for (int i = 0; !r->failed && i < b.n_point; i++) r->sum[0] += energy[i];
    const int middle = b.n_point / 2;
    r->failed |= ric_verify_point(r->atlas, id, middle, &check) ||
                 ric_verify_claims(r->atlas, id, middle, &claims);
    r->sum[1] += check.flight_error;
    r->sum[2] += (double)strlen(claims.finding);
    r->failed |= ric_orbit_find(r->atlas, id, RIC_AT_POINT, middle, &n, &orbits) != RIC_OK;
    for (int i = 0; i < n; i++) r->sum[3] += (double)ric_orbit_stability(orbits[i]);
    ric_orbits_free(n, orbits);
    free(energy);
    free(sample);
}

static void *ask(void *user)
{
    reader *r = user;
    for (int id = 1; id <= ric_atlas_n_branch(r->atlas) && !r->failed; id++) ask_branch(r, id);
    for (int id = 1; id <= ric_atlas_n_junction(r->atlas) && !r->failed; id++) {
        ric_claims claims;
        ric_junction j;
        r->failed |= ric_atlas_junction(r->atlas, id, &j) ||
                     ric_verify_junction(r->atlas, id, &claims);
        r->sum[4] += j.energy;
        r->sum[5] += (double)claims.numbers;
    }
    const ric_model *model = ric_atlas_model(r->atlas);
    double state[4] = {0.1, 0.2, 1, -0.5};
    r->sum[6] = ric_model_energy(model, state, state + 2);
    ric_branch none;
    r->failed |= ric_atlas_branch(r->atlas, r->branch, &none) != RIC_E_RANGE;
    snprintf(r->message, sizeof r->message, "%s", ric_detail());
    return NULL;
}

static void one_atlas_serves_many(void **state)
{
    (void)state;
    static const char text[] =
        "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
        "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
        "    - {normal: [1, 0], clearance: 2, sides: upper, law: bilinear, stiffness: 3}\n"
        "explore: {start: modes, energy: [0, 30], frequency: [0.2, 10], impacts: 4, depth: 2}\n";
    ric_study *study = NULL;
    ric_atlas *atlas = NULL;
    const ric_run_options run = {.workers = 1};
    char path[] = "/tmp/ricochet-threads-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    remove(path);
    assert_int_equal(ric_study_parse(text, "test", ".", &study), RIC_OK);
    assert_int_equal(ric_explore(study, path, &run), RIC_OK);
    assert_int_equal(ric_atlas_read(path, &atlas), RIC_OK);
    remove(path);
    reader alone = {.atlas = atlas, .branch = 1000}, all[THREADS];
    pthread_t threads[THREADS];
    ask(&alone);
    assert_false(alone.failed);
    for (int i = 0; i < THREADS; i++) {
        all[i] = (reader){.atlas = atlas, .branch = 1001 + i};
        assert_int_equal(pthread_create(&threads[i], NULL, ask, &all[i]), 0);
    }
    for (int i = 0; i < THREADS; i++) pthread_join(threads[i], NULL);
    for (int i = 0; i < THREADS; i++) {
        char number[16];
        assert_false(all[i].failed);
        assert_memory_equal(all[i].sum, alone.sum, sizeof alone.sum);
        snprintf(number, sizeof number, "%d", all[i].branch);
        assert_non_null(strstr(all[i].message, number));
    }
    ric_atlas_free(atlas);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(one_atlas_serves_many)};
    return cmocka_run_group_tests_name("threads", tests, NULL, NULL);
}
