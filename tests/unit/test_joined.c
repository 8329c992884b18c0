/* Contacts that close together (model/joined.h): against the half of the structure written down by
 * hand, against a replay on the whole structure, where both contacts are met, and against what is
 * no such structure. */
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

enum { HALF = 2, N = 2 * HALF, TEXT = 6000 };

/* Two equal halves, coordinates i and i + HALF of one another's image, with springs between them:
 * M = [[A, B], [B, A]] and likewise K. */
typedef struct {
    double M[N * N], K[N * N];             /* of the whole */
    double m[HALF * HALF], k[HALF * HALF]; /* of half of it, even motions: A + B; odd: A - B */
    double b[HALF];                        /* of the contact of the first half */
} structure;

static void random_blocks(double shift, double coupling, int sign, double *whole, double *half)
{
    double A[HALF * HALF], B[HALF * HALF];
    random_definite(HALF, HALF, shift, A);
    random_definite(HALF, HALF, 0, B);
    for (int i = 0; i < HALF; i++)
        for (int j = 0; j < HALF; j++) {
            const double b = coupling * B[i * HALF + j];
            for (int k = 0; k < 2; k++) {
                whole[(i + k * HALF) * N + j + k * HALF] = A[i * HALF + j];
                whole[(i + k * HALF) * N + j + (1 - k) * HALF] = b;
            }
            half[i * HALF + j] = 2 * (A[i * HALF + j] + sign * b);
        }
}

static structure random_structure(int sign, double in_mass)
{
    structure s;
    random_blocks(1, in_mass, sign, s.M, s.m);
    random_blocks(1, 0.3, sign, s.K, s.k);
    for (int i = 0; i < HALF; i++) s.b[i] = uniform(-1, 1);
    return s;
}

static size_t put_matrix(char *text, size_t at, const char *key, int n, const double *A)
{
    at += (size_t)snprintf(text + at, TEXT - at, "  %s: [", key);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            at += (size_t)snprintf(text + at, TEXT - at, "%s%.17g%s", j ? ", " : "[", A[i * n + j],
                                   j < n - 1   ? ""
                                   : i < n - 1 ? "], "
                                               : "]]\n");
    return at;
}

/* A contact along b [HALF], in displacements from `first` on of n. */
static size_t put_contact(char *text, size_t at, int n, int first, const double *b,
                          const char *rest)
{
    at += (size_t)snprintf(text + at, TEXT - at, "    - {normal: [");
    for (int i = 0; i < n; i++)
        at += (size_t)snprintf(text + at, TEXT - at, "%s%.17g", i ? ", " : "",
                               i >= first && i < first + HALF ? b[i - first] : 0.0);
    return at + (size_t)snprintf(text + at, TEXT - at, "], %s}\n", rest);
}

static const char explore[] = "explore: {energy: [0, %g], frequency: [0.05, 20], impacts: 4, "
                              "multiply: 2, depth: 2, tongues: cross}\n";

/* The whole, its contacts 1 and 2 joined by `together`, or as they are, NULL. */
static void write_whole(const structure *s, const char *together, const char *sides,
                        const char *law, char text[TEXT])
{
    char rest[200];
    size_t at = (size_t)snprintf(text, TEXT, explore, 40.0);
    at += (size_t)snprintf(text + at, TEXT - at, "model:\n");
    at = put_matrix(text, at, "mass", N, s->M);
    at = put_matrix(text, at, "stiffness", N, s->K);
    if (together) at += (size_t)snprintf(text + at, TEXT - at, "  together: %s\n", together);
    at += (size_t)snprintf(text + at, TEXT - at, "  contacts:\n");
    const bool turned = together && strchr(together, '-');
    for (int k = 0; k < 2; k++) {
        snprintf(rest, sizeof rest, "sides: %s, clearance: 1%s",
                 k && turned && !strcmp(sides, "upper") ? "lower" : sides, law);
        at = put_contact(text, at, N, k * HALF, s->b, rest);
    }
}

static ric_study *study_of(const char *text)
{
    ric_study *study = NULL;
    if (ric_study_parse(text, "test", ".", &study)) fail_msg("%s\n%s", ric_detail(), text);
    return study;
}

static ric_atlas *explored_whole(const structure *s, bool odd, const char *sides, const char *law)
{
    char text[TEXT];
    write_whole(s, odd ? "[[1, -2]]" : "[[1, 2]]", sides, law, text);
    return explore_text(text);
}

/* The half: in y, of which x = (y, +-y), the energy of both halves is 2 (A +- B) / 2. */
static ric_atlas *explored_half(const structure *s, const char *sides, const char *law)
{
    char text[TEXT], rest[200];
    size_t at = (size_t)snprintf(text, TEXT, explore, 40.0);
    at += (size_t)snprintf(text + at, TEXT - at, "model:\n");
    at = put_matrix(text, at, "mass", HALF, s->m);
    at = put_matrix(text, at, "stiffness", HALF, s->k);
    at += (size_t)snprintf(text + at, TEXT - at, "  contacts:\n");
    snprintf(rest, sizeof rest, "sides: %s, clearance: 1%s", sides, law);
    put_contact(text, at, HALF, 0, s->b, rest);
    return explore_text(text);
}

static bool near(double a, double b)
{
    return fabs(a - b) <= 1e-7 * (1 + fabs(b)) || (isnan(a) && isnan(b));
}

static void same_atlases(const ric_atlas *a, const ric_atlas *b)
{
    assert_int_equal(ric_atlas_n_junction(a), ric_atlas_n_junction(b));
    for (int id = 1; id <= ric_atlas_n_junction(a); id++) {
        const ric_junction p = junction_of(a, id), q = junction_of(b, id);
        assert_int_equal(p.kind, q.kind);
        assert_true(near(p.energy, q.energy));
        assert_true(near(p.frequency, q.frequency));
    }
    /* the modes of the whole have other numbers; one in which the contacts would part is no branch
     */
    int other = 0;
    assert_int_equal(ric_atlas_n_branch(a), ric_atlas_n_branch(b));
    for (int id = 1; id <= ric_atlas_n_branch(a); id++) {
        const ric_branch p = branch_of(a, id);
        if (p.impacts == 0) continue;
        while (++other <= ric_atlas_n_branch(b) && branch_of(b, other).impacts == 0) continue;
        const ric_branch q = branch_of(b, other);
        assert_int_equal(p.impacts, q.impacts);
        assert_memory_equal(p.word, q.word, (size_t)p.letters * sizeof *p.word);
        assert_true(near(p.energy_min, q.energy_min) && near(p.energy_max, q.energy_max));
        assert_true(near(p.frequency_min, q.frequency_min));
        assert_true(near(p.frequency_max, q.frequency_max));
        assert_true(fabs(p.stable_fraction - q.stable_fraction) < 1e-3 ||
                    (isnan(p.stable_fraction) && isnan(q.stable_fraction)));
    }
}

/* Even and odd motions, whatever the mass matrix couples, of stops and of springs. */
static void the_atlas_is_that_of_the_half(void **state)
{
    (void)state;
    seed_now = 71000101;
    /* of a half, all masses and springs count: its contact has those of both */
    static const char *const law[][2] = {{"", ""},
                                         {", law: bilinear, stiffness: 3",
                                          ", law: bilinear, stiffness: 6"}};
    for (int k = 0; k < 8; k++) {
        const bool odd = k % 2, spring = k / 2 % 2;
        const structure s = random_structure(odd ? -1 : 1, 0.2);
        const char *sides = k < 4 ? "both" : "upper";
        ric_atlas *whole = explored_whole(&s, odd, sides, law[spring][0]),
                  *half = explored_half(&s, sides, law[spring][1]);
        assert_true(ric_atlas_n_branch(half) > 3);
        same_atlases(whole, half);
        ric_atlas_free(whole);
        ric_atlas_free(half);
    }
}

/* The motion from the state of an orbit, on the whole structure: how far it is from it after a
 * period, and how many impacts it had. */
static double replay(ric_simulator *sim, const ric_orbit *orbit, int *impacts)
{
    enum { PIECES = 4 };
    double x[2 * N], now[2 * N], then[2 * N], off = 0;
    ric_point point;
    bool hit;
    ric_orbit_data(orbit, &point, x, NULL, NULL);
    assert_int_equal(ric_simulator_start(sim, x, x + N), RIC_OK);
    *impacts = 0;
    for (int k = 1; k <= PIECES; k++) { /* between impacts, and not at any of them */
        const double t = 2 * acos(-1) / point.frequency * (k - 0.317) / PIECES;
        ric_impact impact;
        do {
            assert_int_equal(ric_simulator_advance(sim, t, &hit, &impact), RIC_OK);
            *impacts += hit;
        } while (hit);
        ric_simulator_state(sim, NULL, now, now + N);
        ric_orbit_at_time(orbit, t, then, then + N);
        for (int i = 0; i < 2 * N; i++) off = fmax(off, fabs(now[i] - then[i]));
    }
    return off;
}

/* Where the two impacts do not disturb each other the whole structure, whose two stops are met one
 * after the other within rounding, moves as the orbit says. */
static void an_orbit_is_one_of_the_whole(void **state)
{
    (void)state;
    seed_now = 71000201;
    int replayed = 0;
    for (int k = 0; k < 4; k++) {
        const structure s = random_structure(k % 2 ? -1 : 1, 0);
        char text[TEXT];
        ric_atlas *atlas = explored_whole(&s, k % 2, "both", "");
        write_whole(&s, NULL, "both", "", text);
        ric_study *study = study_of(text);
        ric_simulator *sim = NULL;
        assert_int_equal(ric_simulator_create(ric_study_model(study), &sim), RIC_OK);
        for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
            const ric_branch b = branch_of(atlas, id);
            ric_orbit **orbits = NULL;
            int n = 0, impacts;
            if (!b.impacts) continue;
            assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_POINT, b.n_point / 2, &n, &orbits),
                             RIC_OK);
            assert_int_equal(n, 1);
            assert_true(replay(sim, orbits[0], &impacts) < 1e-6);
            assert_int_equal(impacts, 2 * b.impacts - 2); /* of the first the motion starts */
            replayed++;
            ric_orbits_free(n, orbits);
        }
        ric_simulator_free(sim);
        ric_study_free(study);
        ric_atlas_free(atlas);
    }
    assert_true(replayed > 30);
}

/* ------------------------------------------------------------------ what parts them */

/* A state of the orbit, moved by `by` along displacement (or velocity) i of the first half and
 * oppositely in the second one, after a time on the whole structure. */
static void move_on(ric_simulator *sim, const double *x, int sign, int i, double by, double time,
                    double *out)
{
    double y[2 * N];
    bool hit = true;
    memcpy(y, x, sizeof y);
    const int at = i < HALF ? i : N + i - HALF;
    y[at] += by;
    y[at + HALF] -= sign * by;
    assert_int_equal(ric_simulator_start(sim, y, y + N), RIC_OK);
    while (hit) assert_int_equal(ric_simulator_advance(sim, time, &hit, NULL), RIC_OK);
    ric_simulator_state(sim, NULL, out, out + N);
}

/* The trace of the map of disturbances over a period, by differences: they stay apart. */
static double trace_of(ric_simulator *sim, const ric_orbit *orbit, int sign, double *spread)
{
    const double step = 1e-8; /* to second order the two ways to part them differ */
    double x[2 * N], ahead[2 * N], behind[2 * N], flights[64], trace = 0;
    ric_point point;
    ric_orbit_data(orbit, &point, NULL, flights, NULL);
    ric_orbit_at_time(orbit, flights[0] / 2, x, x + N); /* in flight, and so is the end */
    *spread = 0;
    for (int i = 0; i < 2 * HALF; i++) {
        const int at = i < HALF ? i : N + i - HALF;
        const double time = 2 * acos(-1) / point.frequency;
        move_on(sim, x, sign, i, step, time, ahead);
        move_on(sim, x, sign, i, -step, time, behind);
        trace += (ahead[at] - behind[at]) / (2 * step);
        *spread = fmax(*spread, fabs(ahead[at] - behind[at]) / (2 * step));
        for (int k = 0; k < HALF; k++) /* what is even stays as it is */
            assert_true(
                fabs(ahead[k] + sign * ahead[k + HALF] - behind[k] - sign * behind[k + HALF]) <
                1e-4 * step * (1 + *spread) * (1 + *spread));
    }
    return trace;
}

/* Stops, whose masses move on their own, and springs: the sum of the multipliers against a replay
 * of disturbed motions on the whole structure, which meet the two contacts one after the other. */
static void what_parts_them_is_known(void **state)
{
    (void)state;
    seed_now = 71000701;
    int asked = 0, flags[3] = {0};
    for (int k = 0; k < 6; k++) {
        const int sign = k % 2 ? -1 : 1;
        const char *law = k / 2 % 2 ? ", law: bilinear, stiffness: 3" : "";
        const structure s = random_structure(sign, 0);
        char text[TEXT];
        ric_atlas *atlas = explored_whole(&s, k % 2, "both", law);
        write_whole(&s, NULL, "both", law, text);
        ric_study *study = study_of(text);
        ric_simulator *sim = NULL;
        assert_int_equal(ric_simulator_create(ric_study_model(study), &sim), RIC_OK);
        for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
            const ric_branch b = branch_of(atlas, id);
            ric_orbit **orbits = NULL;
            ric_stability stable;
            double pairs[4 * N], sum = 0, spread;
            int n = 0, count = 0;
            if (!b.impacts) continue;
            assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_POINT, b.n_point / 2, &n, &orbits),
                             RIC_OK);
            assert_int_equal(ric_orbit_parting(orbits[0], &count, pairs, &stable), RIC_OK);
            assert_int_equal(count, 2 * (N - HALF));
            for (int i = 0; i < count; i++) sum += pairs[2 * i];
            const double trace = trace_of(sim, orbits[0], sign, &spread);
            if (spread < 100) {
                assert_true(fabs(trace - sum) < 1e-5 * (1 + spread));
                flags[stable]++;
                asked++;
            }
            ric_orbits_free(n, orbits);
        }
        ric_simulator_free(sim);
        ric_study_free(study);
        ric_atlas_free(atlas);
    }
    assert_true(asked > 20 && flags[RIC_STABLE_YES] && flags[RIC_STABLE_NO]);
}

/* The order of two impacts that disturb each other is not known, and nothing is said. */
static void an_unknown_order_is_told(void **state)
{
    (void)state;
    seed_now = 71000801;
    const structure s = random_structure(1, 0.2);
    ric_atlas *atlas = explored_whole(&s, false, "both", "");
    int asked = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_orbit **orbits = NULL;
        ric_stability stable;
        double pairs[4 * N];
        int n = 0, count = 0;
        assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_POINT, 1, &n, &orbits), RIC_OK);
        const bool impacts = branch_of(atlas, id).impacts > 0;
        assert_int_equal(ric_orbit_parting(orbits[0], &count, pairs, &stable),
                         impacts ? RIC_E_INPUT : RIC_OK);
        assert_int_equal(count, 0);
        asked += impacts;
        ric_orbits_free(n, orbits);
    }
    assert_true(asked > 0);
    ric_atlas_free(atlas);
}

/* ------------------------------------------------------------------ what is said */

static void refused(const char *text, const char *why)
{
    ric_study *study = NULL;
    assert_int_equal(ric_study_parse(text, "test", ".", &study), RIC_E_INPUT);
    if (!strstr(ric_detail(), why)) fail_msg("%s\ndoes not say: %s", ric_detail(), why);
}

static void a_wrong_group_is_refused(void **state)
{
    (void)state;
    seed_now = 71000301;
    structure s = random_structure(1, 0.2);
    static const char *const wrong[][2] = {
        {"[[1, 3]]", "3 is no contact"},         {"[[1]]", "a single number"},
        {"[1, 2]", "expected a list of two"},    {"[[1, 1]]", "contact 1 stands there before"},
        {"[[1, 2.5]]", "2.5 is no contact"},     {"[]", "an empty list"},
        {"yes", "expected a list of groups"},    {"[[1, 2], [2, 1]]", "stands there before"},
        {"[[1, -9999999999]]", "is no contact"}, {"[[0, 1]]", "0 is no contact"},
    };
    char text[TEXT];
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        write_whole(&s, wrong[i][0], "both", "", text);
        refused(text, wrong[i][1]);
        refused(text, "model.together");
    }
    write_whole(&s, "[[1, 2]]", "upper", "", text);
    char *side = strstr(strstr(text, "upper") + 1, "upper");
    memcpy(side, "lower", 5);
    refused(text, "one closes upwards and the other downwards");
    write_whole(&s, "[[1, 2]]", "both", "", text);
    char *clearance = strstr(strstr(text, "clearance: 1") + 1, "clearance: 1");
    clearance[11] = '2';
    refused(text, "clearances differ");
    s.K[0] *= 1 + 1e-6; /* no image of itself any more */
    write_whole(&s, "[[1, 2]]", "both", "", text);
    refused(text, "do not stay together: mode");
}

/* The same text comes back from what is kept in an atlas. */
static void the_text_is_read_back(void **state)
{
    (void)state;
    seed_now = 71000401;
    const structure s = random_structure(-1, 0.2);
    char text[TEXT];
    write_whole(&s, "[[2, -1]]", "upper", "", text);
    ric_study *first = study_of(text), *second = study_of(ric_study_text(first)), *third = NULL;
    ric_contact c;
    assert_non_null(strstr(ric_study_text(first), "together: [[1, -2]]"));
    assert_string_equal(ric_study_text(first), ric_study_text(second));
    assert_true(ric_model_same(ric_study_model(first), ric_study_model(second)));
    assert_int_equal(ric_model_n_contact(ric_study_model(first)), 1);
    assert_int_equal(ric_model_contact(ric_study_model(first), 0, &c), RIC_OK);
    assert_int_equal(c.together, 2);
    /* from a model alone nothing could say it */
    assert_int_equal(ric_study_create(ric_study_model(first), NULL, NULL, &third), RIC_E_INPUT);
    ric_study_free(first);
    ric_study_free(second);
}

/* What may be written is found: both, of symmetric structures, and nothing of others. */
static void what_may_be_joined_is_found(void **state)
{
    (void)state;
    seed_now = 71000501;
    for (int k = 0; k < 40; k++) {
        structure s = random_structure(1, 0.2);
        char text[TEXT], found[100];
        bool mode[N], other[N];
        const bool broken = k % 4 == 3;
        if (broken) s.M[N + 1] *= 1.01;
        write_whole(&s, NULL, "both", k % 2 ? ", law: bilinear, stiffness: 2" : "", text);
        ric_study *study = study_of(text);
        const ric_model *m = ric_study_model(study);
        int last = ric_model_together(m, 0, sizeof found, found, mode);
        assert_int_equal(!last, broken);
        if (!broken) {
            assert_string_equal(found, "[[1, 2]]");
            last = ric_model_together(m, last, sizeof found, found, other);
            assert_string_equal(found, "[[1, -2]]");
            int n = 0;
            for (int i = 0; i < N; i++) {
                assert_int_equal(mode[i], !other[i]);
                n += mode[i];
            }
            assert_int_equal(n, HALF);
            assert_int_equal(ric_model_together(m, last, sizeof found, found, mode), 0);
        }
        ric_study_free(study);
    }
}

/* Three contacts around a ring: where they move as one, all are told at once. */
static void a_ring_is_found(void **state)
{
    (void)state;
    enum { RING = 6 };
    seed_now = 72000701;
    for (int trial = 0; trial < 8; trial++) {
        const char *const odd = trial % 2 ? "[[1, 2, -3]]" : "[[1, 2, 3]]";
        double M[RING * RING] = {0}, K[RING * RING] = {0}, A[HALF * HALF], B[HALF * HALF], b[RING];
        char text[TEXT], found[100];
        bool mode[RING];
        int told = 0, alike = 0;
        random_definite(HALF, HALF, 2, A);
        for (int i = 0; i < HALF * HALF; i++) B[i] = uniform(-0.4, 0.4);
        for (int i = 0; i < RING; i++) M[i * RING + i] = 1;
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < HALF; i++)
                for (int j = 0; j < HALF; j++) {
                    const int row = k * HALF + i, next = (k + 1) % 3 * HALF + j;
                    K[row * RING + k * HALF + j] = A[i * HALF + j];
                    K[row * RING + next] = K[next * RING + row] = B[i * HALF + j];
                }
        for (int i = 0; i < HALF; i++) b[i] = uniform(0.2, 1);
        size_t at = (size_t)snprintf(text, TEXT, "model:\n");
        at = put_matrix(text, at, "mass", RING, M);
        at = put_matrix(text, at, "stiffness", RING, K);
        const size_t key = at;
        at += (size_t)snprintf(text + at, TEXT - at, "  contacts:\n");
        for (int k = 0; k < 3; k++) {
            if (k == 2 && trial % 2)
                for (int i = 0; i < HALF; i++) b[i] = -b[i];
            at = put_contact(text, at, RING, k * HALF, b, "clearance: 1");
        }
        ric_study *study = study_of(text);
        for (int last = 0;
             (last = ric_model_together(ric_study_model(study), last, sizeof found, found, mode));)
            if (!strcmp(found, odd)) {
                told++;
                for (int i = 0; i < RING; i++) alike += mode[i];
            }
        ric_study_free(study);
        assert_int_equal(told, 1);
        assert_int_equal(alike, HALF);
        snprintf(found, sizeof found, "  together: %s\n", odd);
        memmove(text + key + strlen(found), text + key, strlen(text + key) + 1);
        memcpy(text + key, found, strlen(found));
        ric_study_free(study_of(text));
    }
}

/* Where some are joined the numbers of the rest are not those of the study: no more is told. */
static void of_joined_contacts_no_more_is_told(void **state)
{
    (void)state;
    static const char square[] =
        "model:\n  mass: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
        "  stiffness: [[3, -1, 0, -1], [-1, 3, -1, 0], [0, -1, 3, -1], [-1, 0, -1, 3]]\n%s"
        "  contacts:\n    - {normal: [1, 0, 0, 0], clearance: 1}\n"
        "    - {normal: [0, 1, 0, 0], clearance: 1}\n    - {normal: [0, 0, 1, 0], clearance: 1}\n"
        "    - {normal: [0, 0, 0, 1], clearance: 1}\n";
    char text[TEXT], found[100];
    bool mode[4];
    for (int joined = 0; joined < 2; joined++) {
        snprintf(text, TEXT, square, joined ? "  together: [[1, 3], [2, 4]]\n" : "");
        ric_study *study = study_of(text);
        assert_int_equal(ric_model_together(ric_study_model(study), 0, sizeof found, found, mode) ==
                             0,
                         joined);
        ric_study_free(study);
    }
}

/* What is told is taken: of structures that are their own image to so many digits, too. */
static void what_is_told_is_taken(void **state)
{
    (void)state;
    seed_now = 72000501;
    int told = 0, refusals = 0;
    for (int k = 0; k < 40; k++) {
        structure s = random_structure(1, 0.2);
        char text[TEXT], found[100];
        bool mode[N];
        s.K[0] *= 1 + pow(10, -15 + k / 4);
        write_whole(&s, NULL, "both", "", text);
        ric_study *study = study_of(text), *joined = NULL;
        for (int last = 0; (last = ric_model_together(ric_study_model(study), last, sizeof found,
                                                      found, mode));) {
            write_whole(&s, found, "both", "", text);
            if (ric_study_parse(text, "test", ".", &joined)) fail_msg("%d: %s", k, ric_detail());
            ric_study_free(joined);
            told++;
        }
        write_whole(&s, "[[1, 2]]", "both", "", text);
        if (k >= 12 && k < 36) { /* 1e-12 to 1e-7 */
            if (ric_study_parse(text, "test", ".", &joined) == RIC_OK) ric_study_free(joined);
            else refusals += strstr(ric_detail(), "but for the last digits it is one") != NULL;
        }
        ric_study_free(study);
    }
    assert_true(told >= 16 && refusals >= 16);
}

/* A mode that parts them starts no family. */
static void a_start_that_parts_them_is_refused(void **state)
{
    (void)state;
    seed_now = 72000601;
    const structure s = random_structure(1, 0);
    char text[TEXT], whole[TEXT + 100], key[40];
    bool parted[N];
    write_whole(&s, "[[1, 2]]", "both", "", text);
    ric_study *study = study_of(text);
    assert_int_equal(ric_model_parted(ric_study_model(study), parted), RIC_OK);
    ric_study_free(study);
    char *at = strstr(text, "explore: {") + strlen("explore: {");
    for (int i = 0; i < N; i++) {
        snprintf(key, sizeof key, "start: [%d], ", i + 1);
        snprintf(whole, sizeof whole, "%.*s%s%s", (int)(at - text), text, key, at);
        if (parted[i]) refused(whole, "parts contacts that close together by model.together");
        else ric_study_free(study_of(whole));
    }
}

/* A motion that parts them is none of the structure. */
static void a_state_that_parts_them_is_told(void **state)
{
    (void)state;
    seed_now = 71000601;
    const structure s = random_structure(-1, 0.2);
    char text[TEXT];
    write_whole(&s, "[[1, -2]]", "both", "", text);
    ric_study *study = study_of(text);
    const ric_model *m = ric_study_model(study);
    const double odd[N] = {0.1, 0.2, -0.1, -0.2}, even[N] = {0, 0.1, 0, 0.1}, none[N] = {0};
    assert_int_equal(ric_model_check_state(m, odd, odd), RIC_OK);
    assert_int_equal(ric_model_check_state(m, none, none), RIC_OK);
    assert_int_equal(ric_model_check_state(m, odd, even), RIC_E_INPUT);
    assert_non_null(strstr(ric_detail(), "velocity"));
    assert_int_equal(ric_model_check_state(m, even, none), RIC_E_INPUT);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_atlas_is_that_of_the_half),
        cmocka_unit_test(an_orbit_is_one_of_the_whole),
        cmocka_unit_test(what_parts_them_is_known),
        cmocka_unit_test(an_unknown_order_is_told),
        cmocka_unit_test(a_wrong_group_is_refused),
        cmocka_unit_test(the_text_is_read_back),
        cmocka_unit_test(what_may_be_joined_is_found),
        cmocka_unit_test(a_ring_is_found),
        cmocka_unit_test(of_joined_contacts_no_more_is_told),
        cmocka_unit_test(what_is_told_is_taken),
        cmocka_unit_test(a_start_that_parts_them_is_refused),
        cmocka_unit_test(a_state_that_parts_them_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
