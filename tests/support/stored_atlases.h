/* Random atlases, a folder for their files, and what of them is the same: for the tests of the
 * store. */
#ifndef STORED_ATLASES_H
#define STORED_ATLASES_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "random_models.h"
#include "atlas/store.h"

static const char pair_text[] = "title: A pair\n"
                                "model:\n"
                                "  mass: [[2, 0], [0, 1]]\n"
                                "  stiffness: [[9, -1], [-1, 1]]\n"
                                "  contacts:\n"
                                "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                                "explore:\n"
                                "  energy: [0, 200]\n"
                                "  frequency: [0.2, 10]\n"
                                "  impacts: 24\n"
                                "  multiply: 1\n";

static char folder[256];

/* A path in the test's folder; valid until the fourth next call. */
static inline const char *in_folder(const char *name)
{
    static char paths[4][512];
    static int turn;
    char *path = paths[turn++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static inline ric_study *study_of(const char *text)
{
    ric_study *study = NULL;
    ric_status status = ric_study_parse(text, "test", ".", &study);
    if (status) print_error("%s\n", ric_detail());
    assert_int_equal(status, RIC_OK);
    return study;
}

/* A number as an atlas may have it: of moderate size, now and then a zero with a sign or a
 * denormal. */
static inline double random_number(void)
{
    static const double special[] = {0.0, -0.0, 5e-324, 1.0, -7.0, 1e15, 9007199254740993.0};
    return below(8) == 0 ? special[below(7)]
                         : ldexp((double)(int64_t)random_bits(), below(80) - 100);
}

static inline double random_or_nothing(void)
{
    return below(4) ? random_number() : NAN;
}

static inline double random_share(void)
{
    return (double)(random_bits() >> 11) * 0x1p-53;
}

/* A state [2 n_dof] and flights, and the energy and frequency that go with them. */
static inline void fill_orbit(const ric_model *model, int n_flight, double *state, double *flights,
                              double *energy, double *frequency)
{
    int n = ric_model_n_dof(model);
    double period = 0;
    for (int i = 0; i < 2 * n; i++)
        state[i] = below(8) ? ldexp((double)(int64_t)random_bits(), -60) : 5e-324;
    for (int i = 0; i < n_flight; i++)
        period += flights[i] = below(8) ? 9 * random_share() + 0.01 : 1e-300;
    if (!(period > 0.01)) period += flights[0] = 2.5;
    double fit = fmin(1, 30 / period); /* the longest that the window of frequencies has */
    for (int i = 0; i < n_flight; i++) flights[i] *= fit;
    period *= fit;
    *energy = ric_model_energy(model, state, state + n);
    *frequency = 2 * 3.14159265358979323846 / period;
}

static inline int *random_word(int n, int n_face)
{
    int *word = calloc((size_t)n + 1, sizeof *word);
    for (int i = 0; i < n; i++) word[i] = below(n_face);
    return word;
}

static inline void fill_points(ric_branch_record *branch, const ric_model *model)
{
    int n_dof = ric_model_n_dof(model), n_flight = branch->row.letters ? branch->row.letters : 1;
    double arclength = 0;
    branch->stride = ric_atlas_point_stride(n_dof, branch->row.letters);
    branch->points = calloc((size_t)branch->row.n_point + 1, branch->stride * sizeof(double));
    for (int i = 0; i < branch->row.n_point; i++) {
        double *at = branch->points + (size_t)i * branch->stride,
               *state = at + sizeof(ric_point) / sizeof *at, energy, frequency;
        fill_orbit(model, n_flight, state, state + 2 * n_dof, &energy, &frequency);
        ric_point point = {arclength += random_share(),
                           energy,
                           frequency,
                           random_or_nothing(),
                           below(3) ? random_share() : NAN,
                           random_or_nothing(),
                           random_or_nothing(),
                           (float)(below(1000) * 1e-16),
                           below(3)};
        memcpy(at, &point, sizeof point);
    }
}

static inline ric_branch_record random_branch(int id, int n_junction, const ric_model *model)
{
    static const char *const mirrors[] = {"", "centre-impact", "rest-rest"};
    ric_branch_record branch = {0};
    char label[64];
    int n = below(4) * 3;
    snprintf(label, sizeof label, "S%d-[\"%d\", \xc3\xa9]", n, id);
    branch.label = strdup(label);
    branch.mirror = strdup(mirrors[below(3)]);
    branch.why = strdup(id % 2 ? "" : "energy 200 is the end of the window");
    branch.word = random_word(n, ric_model_n_face(model));
    int n_inner = below(5);
    branch.junctions = calloc((size_t)n_inner + 1, sizeof *branch.junctions);
    branch.junction_at = calloc((size_t)n_inner + 1, sizeof *branch.junction_at);
    for (int i = 0; i < n_inner; i++) {
        branch.junctions[i] = 1 + below(n_junction);
        branch.junction_at[i] = random_number();
    }
    double energy = fabs(random_number()), frequency = fabs(random_number());
    branch.row = (ric_branch){.id = id,
                              .label = branch.label,
                              .impacts = n,
                              .letters = n,
                              .word = branch.word,
                              .symmetric = below(2),
                              .reversible = below(2),
                              .mirror = branch.mirror,
                              .stable_fraction = id == 2 ? NAN : 0.25,
                              .n_point = 1 + below(30),
                              .energy_min = energy,
                              .energy_max = energy * (1 + random_share()),
                              .frequency_min = frequency,
                              .frequency_max = id % 3 ? frequency : NAN,
                              .from = below(n_junction + 1),
                              .to = below(n_junction + 1),
                              .stop = (ric_stop)below(6),
                              .why = branch.why,
                              .n_junction = n_inner,
                              .junctions = branch.junctions,
                              .junction_at = branch.junction_at,
                              .depth = below(9),
                              .mode = below(ric_model_n_dof(model)) + 1};
    fill_points(&branch, model);
    return branch;
}

static inline ric_junction_record random_junction(int id, int n_branch, const ric_model *model)
{
    ric_junction_record junction = {0};
    int n = below(4) * 2, n_state = 2 * ric_model_n_dof(model), n_flight = n ? n : 1;
    junction.label = strdup("G1_2,4");
    junction.name = strdup(id % 3 ? "" : "C1_32");
    junction.refusal = strdup(id % 2 ? "" : "more than 6 grazings, \"all\"");
    junction.word = random_word(n, ric_model_n_face(model));
    junction.branches = calloc((size_t)n_branch + 1, sizeof *junction.branches);
    junction.state = calloc((size_t)n_state, sizeof(double));
    junction.flights = calloc((size_t)n_flight, sizeof(double));
    double energy, frequency;
    int multiple = 1 + below(6), turns = below(6);
    fill_orbit(model, n_flight, junction.state, junction.flights, &energy, &frequency);
    junction.row = (ric_junction){.id = id,
                                  .kind = (ric_kind)below(8),
                                  .label = junction.label,
                                  .name = junction.name,
                                  .impacts = n,
                                  .letters = n,
                                  .word = junction.word,
                                  .grazings = below(7),
                                  .multiple = multiple,
                                  .rotation = {below(turns + 1), turns},
                                  .a = below(4),
                                  .b = below(4),
                                  .energy = energy,
                                  .frequency = frequency / multiple,
                                  .state = junction.state,
                                  .flights = junction.flights,
                                  .branches = junction.branches,
                                  .departures = {below(9), below(9), below(9), below(9), below(9)},
                                  .refusal = junction.refusal};
    return junction;
}

/* Junctions list the branches that name them. */
static inline void list_branches(ric_atlas *atlas)
{
    for (int k = 0; k < atlas->n_junction; k++) atlas->junctions[k].row.n_branch = 0;
    for (int i = 0; i < atlas->n_branch; i++) {
        const ric_branch *b = &atlas->branches[i].row;
        for (int k = 0; k < atlas->n_junction; k++) {
            ric_junction_record *j = &atlas->junctions[k];
            bool named = b->from == k + 1 || b->to == k + 1;
            for (int p = 0; p < b->n_junction; p++) named |= b->junctions[p] == k + 1;
            if (named) j->branches[j->row.n_branch++] = i + 1;
        }
    }
}

static inline ric_atlas *random_atlas(const char *study, uint64_t seed, int n_branch,
                                      int n_junction)
{
    ric_atlas *atlas = calloc(1, sizeof *atlas);
    seed_now = seed;
    atlas->study = study_of(study);
    const ric_model *model = ric_study_model(atlas->study);
    atlas->finished = seed % 2;
    atlas->n_unplaced = (int)(seed % 5);
    atlas->n_blind = (int)(seed % 3);
    atlas->n_branch = n_branch;
    atlas->n_junction = n_junction;
    atlas->branches = calloc((size_t)n_branch + 1, sizeof *atlas->branches);
    atlas->junctions = calloc((size_t)n_junction + 1, sizeof *atlas->junctions);
    for (int i = 0; i < n_branch; i++) atlas->branches[i] = random_branch(i + 1, n_junction, model);
    for (int i = 0; i < n_junction; i++)
        atlas->junctions[i] = random_junction(i + 1, n_branch, model);
    list_branches(atlas);
    return atlas;
}

static inline bool same_bits(double a, double b)
{
    return (isnan(a) && isnan(b)) || !memcmp(&a, &b, sizeof a);
}

static inline bool same_points(const ric_branch_record *a, const ric_branch_record *b)
{
    if (a->stride != b->stride) return false;
    for (int i = 0; i < a->row.n_point; i++) {
        const double *x = a->points + (size_t)i * a->stride, *y = b->points + (size_t)i * a->stride;
        size_t k = offsetof(ric_point, residual) / sizeof *x; /* the slot of two smaller numbers */
        for (size_t j = 0; j < a->stride; j++)
            if (j != k && !same_bits(x[j], y[j])) return false;
        if (memcmp(&x[k], &y[k], sizeof *x)) return false;
    }
    return true;
}

static inline bool same_branch(const ric_branch_record *left, const ric_branch_record *right)
{
    const ric_branch *a = &left->row, *b = &right->row;
    bool same = a->id == b->id && !strcmp(a->label, b->label) && a->impacts == b->impacts &&
                !memcmp(a->word, b->word, (size_t)a->impacts * sizeof *a->word) &&
                a->symmetric == b->symmetric && a->reversible == b->reversible &&
                !strcmp(a->mirror, b->mirror) &&
                same_bits(a->stable_fraction, b->stable_fraction) && a->n_point == b->n_point &&
                same_bits(a->energy_min, b->energy_min) &&
                same_bits(a->energy_max, b->energy_max) &&
                same_bits(a->frequency_min, b->frequency_min) &&
                same_bits(a->frequency_max, b->frequency_max) && a->from == b->from &&
                a->to == b->to && a->stop == b->stop && !strcmp(a->why, b->why) &&
                a->n_junction == b->n_junction && a->depth == b->depth && a->mode == b->mode &&
                same_points(left, right);
    for (int i = 0; same && i < a->n_junction; i++)
        same = a->junctions[i] == b->junctions[i] &&
               same_bits(a->junction_at[i], b->junction_at[i]);
    return same;
}

static inline bool same_junction(const ric_junction *a, const ric_junction *b, int n_dof)
{
    int n_flight = a->impacts ? a->impacts : 1;
    bool same = a->id == b->id && a->kind == b->kind && !strcmp(a->label, b->label) &&
                !strcmp(a->name, b->name) && a->impacts == b->impacts &&
                !memcmp(a->word, b->word, (size_t)a->impacts * sizeof *a->word) &&
                a->grazings == b->grazings && a->multiple == b->multiple &&
                a->rotation[0] == b->rotation[0] && a->rotation[1] == b->rotation[1] &&
                a->a == b->a && a->b == b->b && same_bits(a->energy, b->energy) &&
                same_bits(a->frequency, b->frequency) && a->n_branch == b->n_branch &&
                !memcmp(&a->departures, &b->departures, sizeof a->departures) &&
                !strcmp(a->refusal, b->refusal);
    for (int i = 0; same && i < 2 * n_dof; i++) same = same_bits(a->state[i], b->state[i]);
    for (int i = 0; same && i < n_flight; i++) same = same_bits(a->flights[i], b->flights[i]);
    for (int i = 0; same && i < a->n_branch; i++) same = a->branches[i] == b->branches[i];
    return same;
}

static inline bool same_atlas(const ric_atlas *a, const ric_atlas *b)
{
    bool same = !strcmp(ric_study_text(a->study), ric_study_text(b->study)) &&
                a->finished == b->finished && a->n_unplaced == b->n_unplaced &&
                a->n_blind == b->n_blind && a->n_branch == b->n_branch &&
                a->n_junction == b->n_junction;
    for (int i = 0; same && i < a->n_branch; i++)
        same = same_branch(&a->branches[i], &b->branches[i]);
    for (int i = 0; same && i < a->n_junction; i++)
        same = same_junction(&a->junctions[i].row, &b->junctions[i].row,
                             ric_model_n_dof(ric_atlas_model(a)));
    return same;
}

static inline void assert_done(ric_status status)
{
    if (status) print_error("%s\n", ric_detail());
    assert_int_equal(status, RIC_OK);
}

/* An atlas file with some finished work in it. */
static inline void make_file(const char *path, const ric_atlas *atlas)
{
    ric_store *store = NULL;
    assert_done(ric_store_open(path, atlas->study, &store));
    assert_done(ric_store_trace_put(store, "S2-[01]", "some work\0done", 14));
    assert_done(ric_store_trace_put(store, "empty", NULL, 0));
    assert_done(ric_store_commit(store));
    assert_done(ric_store_write(store, atlas, 1));
    ric_store_close(store);
}

typedef struct {
    unsigned char *bytes;
    size_t n;
} content;

static inline content content_of(const char *path)
{
    content c = {0};
    FILE *file = fopen(path, "rb");
    if (!file) return c;
    fseek(file, 0, SEEK_END);
    c.n = (size_t)ftell(file);
    rewind(file);
    c.bytes = malloc(c.n + 1);
    assert_int_equal(fread(c.bytes, 1, c.n, file), c.n);
    fclose(file);
    return c;
}

static inline void write_file(const char *path, const void *bytes, size_t n)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

static inline int files_in_folder(void)
{
    int n = 0;
    DIR *dir = opendir(folder);
    while (readdir(dir)) n++;
    closedir(dir);
    return n - 2;
}

static inline int set_up(void **state)
{
    (void)state;
    const char *parent = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/ricochet-store-XXXXXX", parent ? parent : "/tmp");
    return mkdtemp(folder) ? 0 : -1;
}

static inline int tear_down(void **state)
{
    (void)state;
    chmod(folder, 0755);
    DIR *dir = opendir(folder);
    for (struct dirent *entry; (entry = readdir(dir));)
        if (entry->d_name[0] != '.') remove(in_folder(entry->d_name));
    closedir(dir);
    return rmdir(folder);
}

/* Both ways in refuse `path` with `expected`, say why, and leave every byte and the folder as they
 * were. */
static inline void assert_refused(const char *path, const char *study_text, ric_status expected,
                                  const char *reason)
{
    ric_study *study = study_of(study_text);
    ric_store *store = NULL;
    content before = content_of(path);
    int n_before = files_in_folder();
    assert_int_equal(ric_store_open(path, study, &store), expected);
    assert_null(store);
    if (!strstr(ric_detail(), reason)) fail_msg("expected \"%s\" in: %s", reason, ric_detail());
    content after = content_of(path);
    assert_int_equal(before.n, after.n);
    if (before.n) assert_memory_equal(before.bytes, after.bytes, before.n);
    assert_int_equal(files_in_folder(), n_before);
    free(before.bytes);
    free(after.bytes);
    ric_study_free(study);
}

#endif
