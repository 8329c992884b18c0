/* The atlas file: what goes in comes out, and nothing else ever does. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <math.h>
#include <signal.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* Some tests forge a file with the store's own inner functions. */
#include "store_parts.h"

static const char pair_text[] =
    "title: A pair\n"
    "model:\n"
    "  mass: [[2, 0], [0, 1]]\n"
    "  stiffness: [[9, -1], [-1, 1]]\n"
    "  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore:\n"
    "  energy: [0, 200]\n"
    "  frequency: [0.2, 10]\n"
    "  impacts: 24\n";

/* The same model, its numbers written in another way, with other budgets. */
static const char budget_text[] =
    "title: A pair, further\n"
    "model:\n"
    "  mass: [[2.0, 0e0], [0, 1.00]]\n"
    "  stiffness:\n"
    "    - [9, -1]\n"
    "    - [-1, 1]\n"
    "  contacts:\n"
    "    - {normal: [-1, 1], clearance: 10e-1, sides: both, law: rigid}\n"
    "explore:\n"
    "  energy: [0, 300]\n"
    "  frequency: [0.2, 10]\n"
    "  impacts: 30\n";

static const char other_text[] =
    "model:\n"
    "  mass: [[2, 0], [0, 1]]\n"
    "  stiffness: [[9, -1], [-1, 1.0000000000000002]]\n"
    "  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore:\n"
    "  energy: [0, 200]\n"
    "  frequency: [0.2, 10]\n"
    "  impacts: 24\n";

/* --------------------------------------------------------------- utensils */

static char folder[256];

/* A path in the test's folder; valid until the fourth next call. */
static const char *in_folder(const char *name)
{
    static char paths[4][512];
    static int turn;
    char *path = paths[turn++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static ric_study *study_of(const char *text)
{
    ric_study *study = NULL;
    ric_status status = ric_study_parse(text, "test", ".", &study);
    if (status)
        print_error("%s\n", ric_detail());
    assert_int_equal(status, RIC_OK);
    return study;
}

static uint64_t random_state;

static uint64_t random_bits(void)
{
    random_state += 0x9e3779b97f4a7c15u; /* splitmix64 */
    uint64_t z = random_state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static int random_below(int n)
{
    return (int)(random_bits() % (uint64_t)n);
}

/* Any double that is a number or the one NaN; now and then a zero with a sign, an infinity, a denormal. */
static double random_double(void)
{
    static const double special[] = {0.0, -0.0, INFINITY, -INFINITY, 5e-324, -1e308, 1.0, -7.0, 1e15, 9007199254740993.0};
    double value;
    uint64_t bits = random_bits();
    if (random_below(8) == 0)
        return special[random_below(10)];
    memcpy(&value, &bits, sizeof value);
    return isnan(value) ? NAN : value;
}

static int *random_word(int n, int n_face)
{
    int *word = calloc((size_t)n + 1, sizeof *word);
    for (int i = 0; i < n; i++)
        word[i] = random_below(n_face);
    return word;
}

static void fill_points(ric_branch_record *branch, int n_dof)
{
    branch->stride = ric_point_stride(n_dof, branch->row.impacts);
    branch->points = calloc((size_t)branch->row.n_point + 1, branch->stride * sizeof(double));
    for (int i = 0; i < branch->row.n_point; i++) {
        double *at = branch->points + (size_t)i * branch->stride;
        ric_point point = {random_double(), random_double(), random_double(), random_double(), random_double(), random_double(),
                           random_double(), (float)(random_below(1000) * 1e-16), random_below(3)};
        for (size_t k = 0; k < branch->stride; k++)
            at[k] = random_double();
        memcpy(at, &point, sizeof point);
    }
}

static ric_branch_record random_branch(int id, int n_junction, const ric_model *model)
{
    static const char *const mirrors[] = {"", "centre-impact", "rest-rest"};
    ric_branch_record branch = {0};
    char label[64];
    int n = random_below(4) * 3;
    snprintf(label, sizeof label, "S%d-[\"%d\", \xc3\xa9]", n, id);
    branch.label = strdup(label);
    branch.mirror = strdup(mirrors[random_below(3)]);
    branch.why = strdup(id % 2 ? "" : "energy 200 is the end of the window");
    branch.word = random_word(n, ric_model_n_face(model));
    int n_inner = random_below(5);
    branch.junctions = calloc((size_t)n_inner + 1, sizeof *branch.junctions);
    branch.junction_at = calloc((size_t)n_inner + 1, sizeof *branch.junction_at);
    for (int i = 0; i < n_inner; i++) {
        branch.junctions[i] = 1 + random_below(n_junction);
        branch.junction_at[i] = random_double();
    }
    branch.row = (ric_branch){
        .id = id, .label = branch.label, .impacts = n, .word = branch.word, .symmetric = random_below(2), .reversible = random_below(2),
        .mirror = branch.mirror, .stable_fraction = id == 2 ? NAN : 0.25, .n_point = random_below(30), .energy_min = random_double(),
        .energy_max = random_double(), .frequency_min = random_double(), .frequency_max = random_double(),
        .from = random_below(n_junction + 1), .to = random_below(n_junction + 1), .stop = (ric_stop)random_below(6), .why = branch.why,
        .n_junction = n_inner, .junctions = branch.junctions, .junction_at = branch.junction_at, .depth = random_below(9),
        .mode = random_below(ric_model_n_dof(model) + 1)};
    fill_points(&branch, ric_model_n_dof(model));
    return branch;
}

static ric_junction_record random_junction(int id, int n_branch, const ric_model *model)
{
    ric_junction_record junction = {0};
    int n = random_below(4) * 2, n_state = 2 * ric_model_n_dof(model), n_flight = n ? n : 1;
    junction.label = strdup("G1_2,4");
    junction.name = strdup(id % 3 ? "" : "C1_32");
    junction.refusal = strdup(id % 2 ? "" : "more than 6 grazings, \"all\"");
    junction.word = random_word(n, ric_model_n_face(model));
    junction.branches = calloc((size_t)n_branch + 1, sizeof *junction.branches);
    junction.state = calloc((size_t)n_state, sizeof(double));
    junction.flights = calloc((size_t)n_flight, sizeof(double));
    for (int i = 0; i < n_state; i++)
        junction.state[i] = random_double();
    for (int i = 0; i < n_flight; i++)
        junction.flights[i] = random_double();
    int n_at = 0;
    for (int i = 1; i <= n_branch; i++)
        if (random_below(3) == 0)
            junction.branches[n_at++] = i;
    junction.row = (ric_junction){
        .id = id, .kind = (ric_kind)random_below(8), .label = junction.label, .name = junction.name, .impacts = n, .word = junction.word,
        .grazings = random_below(7), .multiple = 1 + random_below(6), .rotation = {random_below(5), random_below(6)}, .a = random_below(4),
        .b = random_below(4), .energy = random_double(), .frequency = random_double(), .state = junction.state,
        .flights = junction.flights, .n_branch = n_at, .branches = junction.branches,
        .departures = {random_below(9), random_below(9), random_below(9), random_below(9), random_below(9)}, .refusal = junction.refusal};
    return junction;
}

static ric_atlas *random_atlas(const char *study, uint64_t seed, int n_branch, int n_junction)
{
    ric_atlas *atlas = calloc(1, sizeof *atlas);
    random_state = seed;
    atlas->study = study_of(study);
    const ric_model *model = ric_study_model(atlas->study);
    atlas->finished = seed % 2;
    atlas->n_branch = n_branch;
    atlas->n_junction = n_junction;
    atlas->branches = calloc((size_t)n_branch + 1, sizeof *atlas->branches);
    atlas->junctions = calloc((size_t)n_junction + 1, sizeof *atlas->junctions);
    for (int i = 0; i < n_branch; i++)
        atlas->branches[i] = random_branch(i + 1, n_junction, model);
    for (int i = 0; i < n_junction; i++)
        atlas->junctions[i] = random_junction(i + 1, n_branch, model);
    return atlas;
}

static bool same_bits(double a, double b)
{
    return (isnan(a) && isnan(b)) || !memcmp(&a, &b, sizeof a);
}

static bool same_points(const ric_branch_record *a, const ric_branch_record *b)
{
    if (a->stride != b->stride)
        return false;
    for (int i = 0; i < a->row.n_point; i++) {
        const double *x = a->points + (size_t)i * a->stride, *y = b->points + (size_t)i * a->stride;
        size_t k = offsetof(ric_point, residual) / sizeof *x; /* the slot of two smaller numbers */
        for (size_t j = 0; j < a->stride; j++)
            if (j != k && !same_bits(x[j], y[j]))
                return false;
        if (memcmp(&x[k], &y[k], sizeof *x))
            return false;
    }
    return true;
}

static bool same_branch(const ric_branch_record *left, const ric_branch_record *right)
{
    const ric_branch *a = &left->row, *b = &right->row;
    bool same = a->id == b->id && !strcmp(a->label, b->label) && a->impacts == b->impacts &&
        !memcmp(a->word, b->word, (size_t)a->impacts * sizeof *a->word) && a->symmetric == b->symmetric &&
        a->reversible == b->reversible && !strcmp(a->mirror, b->mirror) && same_bits(a->stable_fraction, b->stable_fraction) &&
        a->n_point == b->n_point && same_bits(a->energy_min, b->energy_min) && same_bits(a->energy_max, b->energy_max) &&
        same_bits(a->frequency_min, b->frequency_min) && same_bits(a->frequency_max, b->frequency_max) && a->from == b->from &&
        a->to == b->to && a->stop == b->stop && !strcmp(a->why, b->why) && a->n_junction == b->n_junction &&
        a->depth == b->depth && a->mode == b->mode && same_points(left, right);
    for (int i = 0; same && i < a->n_junction; i++)
        same = a->junctions[i] == b->junctions[i] && same_bits(a->junction_at[i], b->junction_at[i]);
    return same;
}

static bool same_junction(const ric_junction *a, const ric_junction *b, int n_dof)
{
    int n_flight = a->impacts ? a->impacts : 1;
    bool same = a->id == b->id && a->kind == b->kind && !strcmp(a->label, b->label) && !strcmp(a->name, b->name) &&
        a->impacts == b->impacts && !memcmp(a->word, b->word, (size_t)a->impacts * sizeof *a->word) && a->grazings == b->grazings &&
        a->multiple == b->multiple && a->rotation[0] == b->rotation[0] && a->rotation[1] == b->rotation[1] && a->a == b->a &&
        a->b == b->b && same_bits(a->energy, b->energy) && same_bits(a->frequency, b->frequency) && a->n_branch == b->n_branch &&
        !memcmp(&a->departures, &b->departures, sizeof a->departures) && !strcmp(a->refusal, b->refusal);
    for (int i = 0; same && i < 2 * n_dof; i++)
        same = same_bits(a->state[i], b->state[i]);
    for (int i = 0; same && i < n_flight; i++)
        same = same_bits(a->flights[i], b->flights[i]);
    for (int i = 0; same && i < a->n_branch; i++)
        same = a->branches[i] == b->branches[i];
    return same;
}

static bool same_atlas(const ric_atlas *a, const ric_atlas *b)
{
    bool same = !strcmp(ric_study_text(a->study), ric_study_text(b->study)) && a->finished == b->finished &&
        a->n_branch == b->n_branch && a->n_junction == b->n_junction;
    for (int i = 0; same && i < a->n_branch; i++)
        same = same_branch(&a->branches[i], &b->branches[i]);
    for (int i = 0; same && i < a->n_junction; i++)
        same = same_junction(&a->junctions[i].row, &b->junctions[i].row, ric_model_n_dof(ric_atlas_model(a)));
    return same;
}

static void assert_done(ric_status status)
{
    if (status)
        print_error("%s\n", ric_detail());
    assert_int_equal(status, RIC_OK);
}

/* An atlas file with some finished work in it. */
static void make_file(const char *path, const ric_atlas *atlas)
{
    ric_store *store = NULL;
    assert_done(ric_store_open(path, atlas->study, &store));
    assert_done(ric_store_trace_put(store, "S2-[01]", "some work\0done", 14));
    assert_done(ric_store_trace_put(store, "empty", NULL, 0));
    assert_done(ric_store_commit(store));
    assert_done(ric_store_write(store, atlas));
    ric_store_close(store);
}

typedef struct {
    unsigned char *bytes;
    size_t n;
} content;

static content content_of(const char *path)
{
    content c = {0};
    FILE *file = fopen(path, "rb");
    if (!file)
        return c;
    fseek(file, 0, SEEK_END);
    c.n = (size_t)ftell(file);
    rewind(file);
    c.bytes = malloc(c.n + 1);
    assert_int_equal(fread(c.bytes, 1, c.n, file), c.n);
    fclose(file);
    return c;
}

static void write_file(const char *path, const void *bytes, size_t n)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

static int files_in_folder(void)
{
    int n = 0;
    DIR *dir = opendir(folder);
    while (readdir(dir))
        n++;
    closedir(dir);
    return n - 2;
}

static int set_up(void **state)
{
    (void)state;
    const char *parent = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/ricochet-store-XXXXXX", parent ? parent : "/tmp");
    return mkdtemp(folder) ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    chmod(folder, 0755);
    DIR *dir = opendir(folder);
    for (struct dirent *entry; (entry = readdir(dir));)
        if (entry->d_name[0] != '.')
            remove(in_folder(entry->d_name));
    closedir(dir);
    return rmdir(folder);
}

/* Both ways in refuse `path` with `expected`, say why, and leave every byte and the folder as they were. */
static void assert_refused(const char *path, const char *study_text, ric_status expected, const char *reason)
{
    ric_study *study = study_of(study_text);
    ric_store *store = NULL;
    content before = content_of(path);
    int n_before = files_in_folder();
    assert_int_equal(ric_store_open(path, study, &store), expected);
    assert_null(store);
    if (!strstr(ric_detail(), reason))
        fail_msg("expected \"%s\" in: %s", reason, ric_detail());
    content after = content_of(path);
    assert_int_equal(before.n, after.n);
    if (before.n)
        assert_memory_equal(before.bytes, after.bytes, before.n);
    assert_int_equal(files_in_folder(), n_before);
    free(before.bytes);
    free(after.bytes);
    ric_study_free(study);
}

static void assert_unreadable(const char *path, ric_status expected, const char *reason)
{
    ric_atlas *atlas = NULL;
    int n_before = files_in_folder();
    assert_int_equal(ric_atlas_read(path, &atlas), expected);
    assert_null(atlas);
    if (!strstr(ric_detail(), reason))
        fail_msg("expected \"%s\" in: %s", reason, ric_detail());
    assert_int_equal(files_in_folder(), n_before);
}

static void assert_sql(const char *path, const char *sql)
{
    sqlite3 *db = NULL;
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    if (sqlite3_exec(db, sql, NULL, NULL, NULL))
        fail_msg("%s: %s", sql, sqlite3_errmsg(db));
    sqlite3_close(db);
}

/* ------------------------------------------------------------- round trips */

static void atlases_come_back_bit_for_bit(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        ric_atlas *made = random_atlas(pair_text, seed, 1 + (int)seed % 7, 1 + (int)seed % 5), *read = NULL;
        make_file(in_folder("a"), made);
        assert_done(ric_atlas_read(in_folder("a"), &read));
        if (!same_atlas(made, read))
            fail_msg("seed %d: the atlas has changed", (int)seed);
        ric_atlas_free(made);
        ric_atlas_free(read);
    }
    assert_int_equal(files_in_folder(), 1);
}

static void faces_beyond_36_are_kept(void **state)
{
    (void)state;
    char text[8192];
    int n = snprintf(text, sizeof text, "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n");
    for (int i = 0; i < 20; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, "    - {normal: [-1, %d], clearance: %d, sides: both, law: rigid}\n", i + 1, i + 3);
    snprintf(text + n, sizeof text - (size_t)n, "explore: {energy: [0, 20], frequency: [0.2, 10], impacts: 4}\n");
    ric_atlas *made = random_atlas(text, 5, 6, 6), *read = NULL;
    make_file(in_folder("a"), made);
    assert_done(ric_atlas_read(in_folder("a"), &read));
    assert_true(same_atlas(made, read));
    ric_atlas_free(made);
    ric_atlas_free(read);
}

static void rows_can_be_asked_for(void **state)
{
    (void)state;
    ric_atlas *atlas = random_atlas(pair_text, 3, 3, 2);
    ric_branch branch;
    ric_junction junction;
    ric_point point;
    double values[4], flights[16];
    atlas->branches[0].row.n_point = 0;
    assert_done(ric_atlas_branch(atlas, 3, &branch));
    assert_int_equal(branch.id, 3);
    assert_done(ric_atlas_junction(atlas, 2, &junction));
    assert_int_equal(junction.id, 2);
    for (int i = 0; i < branch.n_point; i++) {
        const double *at = atlas->branches[2].points + (size_t)i * atlas->branches[2].stride;
        assert_done(ric_atlas_point(atlas, 3, i, &point, values, flights));
        assert_memory_equal(&point, at, sizeof point);
        assert_memory_equal(values, at + 8, sizeof values);
        assert_memory_equal(flights, at + 12, sizeof *flights * (size_t)(branch.impacts ? branch.impacts : 1));
        assert_done(ric_atlas_point(atlas, 3, i, NULL, NULL, NULL));
    }
    assert_int_equal(ric_atlas_branch(atlas, 0, &branch), RIC_E_RANGE);
    assert_int_equal(ric_atlas_branch(atlas, 4, &branch), RIC_E_RANGE);
    assert_non_null(strstr(ric_detail(), "1 to 3"));
    assert_int_equal(ric_atlas_junction(atlas, 3, &junction), RIC_E_RANGE);
    assert_int_equal(ric_atlas_point(atlas, 3, branch.n_point, NULL, NULL, NULL), RIC_E_RANGE);
    assert_int_equal(ric_atlas_point(atlas, 3, -1, NULL, NULL, NULL), RIC_E_RANGE);
    assert_int_equal(ric_atlas_point(atlas, 1, 0, NULL, NULL, NULL), RIC_E_RANGE);
    ric_atlas_free(atlas);
    ric_atlas_free(NULL);
}

static void trace_column_is_the_trace(void **state)
{
    (void)state;
    static const double traces[] = {0.0, -1.5, 1.9999999999999998, -2.0, 9e16, -1e300};
    ric_atlas *made = random_atlas(pair_text, 1, 1, 1);
    ric_branch_record *branch = &made->branches[0];
    sqlite3 *db = NULL;
    sqlite3_stmt *query = NULL;
    free(branch->points);
    branch->row.n_point = 8;
    fill_points(branch, 2);
    for (int i = 0; i < 8; i++) {
        ric_point *point = (ric_point *)(void *)(branch->points + (size_t)i * branch->stride);
        point->trace = i < 6 ? asinh(traces[i] / 2) : i == 6 ? -5000 : NAN;
    }
    make_file(in_folder("a"), made);
    assert_int_equal(sqlite3_open(in_folder("a"), &db), SQLITE_OK);
    assert_int_equal(sqlite3_prepare_v2(db, "SELECT trace, log_trace, trace_asinh FROM point WHERE branch = 1 ORDER BY point", -1, &query, NULL), SQLITE_OK);
    for (int i = 0; i < 8; i++) {
        assert_int_equal(sqlite3_step(query), SQLITE_ROW);
        double trace = sqlite3_column_double(query, 0), logarithm = sqlite3_column_double(query, 1);
        assert_int_equal(sqlite3_column_type(query, 0), i < 6 ? SQLITE_FLOAT : SQLITE_NULL);
        assert_int_equal(sqlite3_column_type(query, 1), i < 7 && i > 0 ? SQLITE_FLOAT : SQLITE_NULL);
        if (i < 6)
            assert_true(fabs(trace - traces[i]) <= 1e-12 * fabs(traces[i]) * (1 + fabs(log(fabs(traces[i]) + 1))));
        if (i > 0 && i < 6)
            assert_true(fabs(logarithm - log(fabs(traces[i]))) <= 1e-13 * (1 + fabs(logarithm)));
        if (i == 6)
            assert_true(logarithm == 5000);
    }
    sqlite3_finalize(query);
    sqlite3_close(db);
    ric_atlas_free(made);
}

static void finished_work_is_found_again(void **state)
{
    (void)state;
    ric_study *study = study_of(pair_text);
    ric_store *store = NULL;
    ric_atlas *atlas = NULL;
    void *blob = NULL;
    size_t size = 9;
    unsigned char *big = malloc(3000000);
    random_state = 1;
    for (int i = 0; i < 3000000; i++)
        big[i] = (unsigned char)random_bits();
    assert_done(ric_store_open(in_folder("a"), study, &store));
    assert_done(ric_store_trace_get(store, "big", &blob, &size));
    assert_null(blob);
    assert_int_equal(size, 0);
    assert_done(ric_store_trace_put(store, "big", "first", 5));
    assert_done(ric_store_trace_put(store, "big", big, 3000000));
    assert_done(ric_store_trace_put(store, "none", NULL, 0));
    assert_done(ric_store_commit(store));
    assert_done(ric_store_commit(store));
    ric_store_close(store);
    assert_done(ric_store_open(in_folder("a"), study, &store));
    assert_done(ric_store_trace_get(store, "big", &blob, &size));
    assert_int_equal(size, 3000000);
    assert_memory_equal(blob, big, size);
    free(blob);
    assert_done(ric_store_trace_get(store, "none", &blob, &size));
    assert_non_null(blob);
    assert_int_equal(size, 0);
    free(blob);
    ric_store_close(store);
    assert_done(ric_atlas_read(in_folder("a"), &atlas)); /* an atlas of nothing yet */
    assert_int_equal(ric_atlas_n_branch(atlas), 0);
    assert_false(ric_atlas_finished(atlas));
    ric_atlas_free(atlas);
    ric_study_free(study);
    free(big);
    assert_int_equal(files_in_folder(), 1);
}

static void other_budgets_continue_the_file(void **state)
{
    (void)state;
    ric_atlas *first = random_atlas(pair_text, 1, 2, 2), *second = random_atlas(budget_text, 2, 5, 4), *read = NULL;
    ric_store *store = NULL;
    void *blob = NULL;
    size_t size;
    make_file(in_folder("a"), first);
    assert_done(ric_store_open(in_folder("a"), second->study, &store));
    assert_done(ric_store_trace_get(store, "S2-[01]", &blob, &size));
    assert_int_equal(size, 14);
    free(blob);
    assert_done(ric_atlas_read(in_folder("a"), &read)); /* what was there stays until the new tables are there */
    assert_true(same_atlas(first, read));
    ric_atlas_free(read);
    assert_done(ric_store_write(store, second));
    ric_store_close(store);
    assert_done(ric_atlas_read(in_folder("a"), &read));
    assert_true(same_atlas(second, read));
    ric_atlas_free(read);
    ric_atlas_free(first);
    ric_atlas_free(second);
}

/* ---------------------------------------------------------------- refusals */

static void another_model_is_refused(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 1, 2, 2);
    make_file(in_folder("a"), made);
    assert_refused(in_folder("a"), other_text, RIC_E_CONFLICT, "1.0000000000000002");
    ric_atlas_free(made);
}

/* Texts of other versions of the program may write the same model in another way. */
static void models_are_compared_by_their_numbers(void **state)
{
    (void)state;
    const char *stored = "model:\n  mass:\n    - [2, 1e3]\n  law: rigid\n";
    assert_int_equal(ric_store_compare_models("a", stored, "model: \n  mass:\n    - [2.0, 1000]\n  law: rigid"), RIC_OK);
    assert_int_equal(ric_store_compare_models("a", stored, "model:\n  mass:\n    - [2, 1000.0000000000001]\n  law: rigid\n"), RIC_E_CONFLICT);
    assert_int_equal(ric_store_compare_models("a", stored, "model:\n  mass:\n    - [2, 1e3]\n  law: power\n"), RIC_E_CONFLICT);
    assert_int_equal(ric_store_compare_models("a", stored, "model:\n  mass:\n    - [2, 1e3]\n"), RIC_E_CONFLICT);
    assert_int_equal(ric_store_compare_models("a", "model: [1]", "model: [1, 2]"), RIC_E_CONFLICT);
    char *model = ric_store_model_text("title: \"model:\"\nmodel:\n  mass: 1\n\n# note\n  law: rigid\nexplore:\n  model: 3\n");
    assert_string_equal(model, "model:\n  mass: 1\n\n# note\n  law: rigid\n");
    free(model);
}

static void foreign_files_are_refused(void **state)
{
    (void)state;
    char zeros[5000] = {0};
    write_file(in_folder("text"), "energy,frequency\n1,2\n", 21);
    write_file(in_folder("zeros"), zeros, sizeof zeros);
    write_file(in_folder("empty"), "", 0);
    assert_sql(in_folder("foreign"), "CREATE TABLE branch (id); PRAGMA user_version = 1");
    assert_sql(in_folder("wal ?#%41.db"), "PRAGMA journal_mode = WAL; CREATE TABLE t (x); PRAGMA user_version = 1");
    static const char *const names[] = {"text", "zeros", "foreign", "wal ?#%41.db"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        assert_refused(in_folder(names[i]), pair_text, RIC_E_FORMAT, "not an atlas");
        assert_unreadable(in_folder(names[i]), RIC_E_FORMAT, "not an atlas");
    }
    assert_unreadable(in_folder("empty"), RIC_E_FORMAT, "empty");
    assert_unreadable(in_folder("none"), RIC_E_IO, "no such file");
    assert_unreadable(folder, RIC_E_IO, "folder");
    assert_refused(in_folder("none/a"), pair_text, RIC_E_IO, "No such file");
}

static void folders_and_devices_are_refused(void **state)
{
    (void)state;
    ric_study *study = study_of(pair_text);
    ric_store *store = NULL;
    assert_int_equal(ric_store_open(folder, study, &store), RIC_E_IO);
    assert_int_equal(ric_store_open("/dev/null", study, &store), RIC_E_IO);
    assert_int_equal(files_in_folder(), 0);
    ric_study_free(study);
}

static void newer_formats_are_refused(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 1, 2, 2);
    make_file(in_folder("a"), made);
    assert_sql(in_folder("a"), "PRAGMA user_version = 2");
    assert_refused(in_folder("a"), pair_text, RIC_E_FORMAT, "newer");
    assert_unreadable(in_folder("a"), RIC_E_FORMAT, "newer");
    ric_atlas_free(made);
}

static ric_atlas *atlas_with_a_touchless_branch(void)
{
    ric_atlas *made = random_atlas(pair_text, 8, 3, 3);
    for (int i = 0; i < 3; i++) {
        ric_branch_record *branch = &made->branches[i];
        free(branch->points);
        branch->row.impacts = i ? branch->row.impacts : 0;
        branch->row.n_point = 5;
        fill_points(branch, 2);
    }
    return made;
}

/* Each of these leaves a sound SQLite file with wrong contents. */
static void inconsistent_contents_are_refused(void **state)
{
    (void)state;
    static const char *const changes[] = {
        "UPDATE branch SET to_junction = 99 WHERE id = 1", "UPDATE branch SET impacts = impacts + 1", "UPDATE branch SET word = '9'",
        "UPDATE branch SET points = points + 1 WHERE id = 1", "UPDATE branch SET points = 2147483647", "UPDATE branch SET id = 9 WHERE id = 3",
        "UPDATE branch SET stop = 'nowhere'", "UPDATE branch SET energy_min = 'low'", "UPDATE branch SET symmetric = 2",
        "UPDATE branch SET mode = 3", "DELETE FROM branch WHERE id = 3", "DELETE FROM branch", "DELETE FROM point WHERE branch = 3",
        "UPDATE point SET state = x'00'", "UPDATE point SET state = state || x'00'", "UPDATE point SET flights = zeroblob(0)",
        "UPDATE point SET flights = 3", "UPDATE point SET point = point + 100", "UPDATE point SET stable = 3", "UPDATE point SET energy = x'00'",
        "INSERT INTO branch_junction VALUES (1, 77, 1, 0.5)", "INSERT INTO branch_junction VALUES (77, 0, 1, 0.5)",
        "UPDATE junction SET kind = ''", "UPDATE junction SET multiple = 0", "UPDATE junction SET state = zeroblob(24)",
        "UPDATE junction SET id = 7 WHERE id = 1", "INSERT INTO junction_branch VALUES (1, 77)", "INSERT INTO junction_branch VALUES (77, 1)",
        "DELETE FROM junction", "DELETE FROM meta", "UPDATE meta SET value = 'x' WHERE key = 'study'", "DELETE FROM meta WHERE key = 'study'",
        "DROP TABLE point", "DROP TABLE trace", "ALTER TABLE point RENAME COLUMN state TO place",
        "DROP TABLE branch; CREATE VIEW branch AS SELECT * FROM branch",
    };
    ric_atlas *made = atlas_with_a_touchless_branch();
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        remove(in_folder("a"));
        make_file(in_folder("a"), made);
        assert_sql(in_folder("a"), changes[i]);
        assert_unreadable(in_folder("a"), RIC_E_FORMAT, "damaged");
        assert_refused(in_folder("a"), pair_text, RIC_E_FORMAT, "damaged");
    }
    ric_atlas_free(made);
}

/* The same with a digest that was made to fit: the checks behind it stand on their own. */
static void forged_contents_are_refused(void **state)
{
    (void)state;
    static const char *const changes[] = {
        "UPDATE branch SET to_junction = 99 WHERE id = 1", "UPDATE branch SET impacts = impacts + 1", "UPDATE branch SET word = '9'",
        "UPDATE branch SET word = replace(word, '1', '2')", "UPDATE point SET state = zeroblob(40)",
        "UPDATE branch SET points = points + 1 WHERE id = 1", "UPDATE branch SET points = 2147483647", "UPDATE branch SET id = 9 WHERE id = 3",
        "UPDATE branch SET stop = 'nowhere'", "UPDATE branch SET energy_min = 'low'", "UPDATE branch SET mode = 3",
        "DELETE FROM branch WHERE id = 3", "UPDATE point SET state = x'00'", "UPDATE point SET flights = 3", "UPDATE point SET stable = 3",
        "INSERT INTO branch_junction VALUES (1, 77, 1, 0.5)", "INSERT INTO branch_junction VALUES (77, 0, 1, 0.5)",
        "UPDATE junction SET kind = ''", "UPDATE junction SET multiple = 0", "UPDATE junction SET state = zeroblob(24)",
        "INSERT INTO junction_branch VALUES (1, 77)", "INSERT INTO junction_branch VALUES (77, 1)", "DELETE FROM junction",
        "UPDATE meta SET value = 'x' WHERE key = 'study'", "DELETE FROM meta WHERE key = 'study'",
    };
    ric_atlas *made = atlas_with_a_touchless_branch();
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        ric_database file;
        remove(in_folder("a"));
        make_file(in_folder("a"), made);
        assert_sql(in_folder("a"), changes[i]);
        assert_done(ric_database_open(in_folder("a"), SQLITE_OPEN_READWRITE, 0, &file));
        assert_done(ric_store_put_digest(file));
        sqlite3_close(file.db);
        assert_unreadable(in_folder("a"), RIC_E_FORMAT, "damaged");
    }
    ric_atlas_free(made);
}

/* The damaged bytes either are found out or do not matter, for the reader and for a run. */
static void assert_harmless(const content *damaged, const ric_atlas *made, const char *what, long at)
{
    ric_atlas *read = NULL;
    ric_store *store = NULL;
    void *blob = NULL;
    size_t size;
    const char *path = in_folder("damaged");
    write_file(path, damaged->bytes, damaged->n);
    ric_status status = ric_atlas_read(path, &read);
    if (!status && !same_atlas(made, read))
        fail_msg("%s at %ld: read without an error, and not the same", what, at);
    ric_atlas_free(read);
    status = ric_store_open(path, made->study, &store);
    if (status && damaged->n) {
        content after = content_of(path);
        assert_int_equal(after.n, damaged->n);
        assert_memory_equal(after.bytes, damaged->bytes, after.n);
        free(after.bytes);
    }
    if (!status && !ric_store_trace_get(store, "S2-[01]", &blob, &size) && blob && (size != 14 || memcmp(blob, "some work\0done", 14)))
        fail_msg("%s at %ld: other work came back", what, at);
    free(blob);
    ric_store_close(store);
}

static void truncated_files_are_refused(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 3, 3, 3);
    make_file(in_folder("a"), made);
    content whole = content_of(in_folder("a")), part = whole;
    for (part.n = 0; part.n < whole.n; part.n += part.n < 200 ? 7 : 311) {
        ric_atlas *read = NULL;
        assert_harmless(&part, made, "cut", (long)part.n);
        write_file(in_folder("damaged"), part.bytes, part.n);
        assert_int_equal(ric_atlas_read(in_folder("damaged"), &read), RIC_E_FORMAT);
    }
    free(whole.bytes);
    ric_atlas_free(made);
}

static void flipped_bits_are_harmless(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 3, 3, 3);
    make_file(in_folder("a"), made);
    content whole = content_of(in_folder("a"));
    random_state = 20240607;
    for (int i = 0; i < 3000; i++) {
        size_t at = i < 100 ? (size_t)i : i < 1000 ? (size_t)random_below(4096) : (size_t)random_below((int)whole.n);
        unsigned char before = whole.bytes[at];
        whole.bytes[at] ^= (unsigned char)(i % 3 ? 1 << random_below(8) : 1 + random_below(255));
        assert_harmless(&whole, made, "flip", (long)at);
        whole.bytes[at] = before;
    }
    free(whole.bytes);
    ric_atlas_free(made);
}

/* -------------------------------------------------- locks, kills, full disks */

static void a_second_run_is_told(void **state)
{
    (void)state;
    ric_study *study = study_of(pair_text);
    ric_store *store = NULL;
    ric_atlas *atlas = NULL;
    int ready[2], hold[2], status;
    char byte;
    assert_int_equal(pipe(ready), 0);
    assert_int_equal(pipe(hold), 0);
    pid_t child = fork();
    if (child == 0) { /* holds the atlas until it is killed, or until the parent is gone */
        close(hold[1]);
        byte = (char)(ric_store_open(in_folder("a"), study, &store) || ric_store_trace_put(store, "k", "v", 1));
        if (write(ready[1], &byte, 1) == 1 && read(hold[0], &byte, 1) == 0)
            _exit(0);
        _exit(1);
    }
    assert_int_equal(read(ready[0], &byte, 1), 1);
    assert_int_equal(byte, 0);
    assert_refused(in_folder("a"), pair_text, RIC_E_BUSY, "another run");
    assert_done(ric_atlas_read(in_folder("a"), &atlas)); /* reading is possible all the time */
    ric_atlas_free(atlas);
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    assert_done(ric_store_open(in_folder("a"), study, &store)); /* a kill leaves no lock */
    assert_refused(in_folder("a"), pair_text, RIC_E_BUSY, "another run");
    ric_store_close(store);
    assert_int_equal(files_in_folder(), 1);
    for (int i = 0; i < 2; i++) {
        close(ready[i]);
        close(hold[i]);
    }
    ric_study_free(study);
}

/* A run that never ends: atlas k has k % 5 + 1 branches; every commit is reported once it has returned. */
static void write_for_ever(int report, ric_atlas *const *atlases)
{
    ric_store *store = NULL;
    char key[32];
    if (ric_store_open(in_folder("a"), atlases[0]->study, &store))
        _exit(1);
    for (int i = 0;; i++) {
        snprintf(key, sizeof key, "%d", i);
        if (ric_store_trace_put(store, key, atlases[0]->branches[0].points, 20000) || ric_store_commit(store) ||
            write(report, &i, sizeof i) != sizeof i || (i % 3 == 0 && ric_store_write(store, atlases[i % 5])))
            _exit(1);
    }
}

static void a_kill_loses_nothing_committed(void **state)
{
    (void)state;
    ric_atlas *atlases[5];
    for (int i = 0; i < 5; i++)
        atlases[i] = random_atlas(pair_text, (uint64_t)i + 31, i + 1, 3);
    free(atlases[0]->branches[0].points);
    atlases[0]->branches[0].row.n_point = 2000;
    fill_points(&atlases[0]->branches[0], 2);
    srand(7);
    for (int round = 0; round < 25; round++) {
        int report[2], last = -1, status;
        ric_store *store = NULL;
        ric_atlas *read_back = NULL;
        assert_int_equal(pipe(report), 0);
        pid_t child = fork();
        if (child == 0)
            write_for_ever(report[1], atlases);
        close(report[1]);
        if (read(report[0], &last, sizeof last) != sizeof last)
            fail_msg("the child has stopped by itself");
        usleep((useconds_t)(rand() % 30000));
        kill(child, SIGKILL);
        waitpid(child, &status, 0);
        assert_true(WIFSIGNALED(status));
        while (read(report[0], &last, sizeof last) == sizeof last)
            ;
        close(report[0]);
        if (round % 2) /* a reader may be the first to come by */
            assert_done(ric_atlas_read(in_folder("a"), &read_back));
        else {
            assert_done(ric_store_open(in_folder("a"), atlases[0]->study, &store));
            for (int i = 0; i <= last; i++) {
                char key[32];
                void *blob = NULL;
                size_t size;
                snprintf(key, sizeof key, "%d", i);
                assert_done(ric_store_trace_get(store, key, &blob, &size));
                assert_int_equal(size, 20000);
                assert_memory_equal(blob, atlases[0]->branches[0].points, size);
                free(blob);
            }
            ric_store_close(store);
            assert_int_equal(files_in_folder(), 1);
            assert_done(ric_atlas_read(in_folder("a"), &read_back));
        }
        bool known = ric_atlas_n_branch(read_back) == 0;
        for (int i = 0; i < 5; i++)
            known |= same_atlas(read_back, atlases[i]);
        assert_true(known);
        ric_atlas_free(read_back);
    }
    for (int i = 0; i < 5; i++)
        ric_atlas_free(atlases[i]);
}

static void readers_and_a_run_get_on(void **state)
{
    (void)state;
    ric_atlas *atlases[2] = {random_atlas(pair_text, 41, 3, 3), random_atlas(pair_text, 42, 6, 3)};
    ric_store *store = NULL;
    int status;
    make_file(in_folder("a"), atlases[0]);
    pid_t child = fork();
    if (child == 0) {
        for (int i = 0; i < 60; i++) {
            ric_atlas *atlas = NULL;
            if (ric_atlas_read(in_folder("a"), &atlas))
                _exit(1);
            if (!same_atlas(atlas, atlases[0]) && !same_atlas(atlas, atlases[1]))
                _exit(2);
            ric_atlas_free(atlas);
        }
        _exit(0);
    }
    assert_done(ric_store_open(in_folder("a"), atlases[0]->study, &store));
    for (int i = 0; waitpid(child, &status, WNOHANG) == 0; i++) {
        assert_done(ric_store_trace_put(store, "key", atlases, sizeof atlases));
        assert_done(ric_store_write(store, atlases[i % 2]));
    }
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    ric_store_close(store);
    ric_atlas_free(atlases[0]);
    ric_atlas_free(atlases[1]);
}

/* Work that waits for its commit is kept in memory, also when it is larger than the cache of SQLite. */
static void uncommitted_work_blocks_no_reader(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 3, 2, 2), *read_back = NULL;
    ric_store *store = NULL;
    const size_t size = 1 << 20;
    char *work = calloc(size, 1), key[16];
    make_file(in_folder("a"), made);
    assert_done(ric_store_open(in_folder("a"), made->study, &store));
    for (int i = 0; i < 20; i++) {
        snprintf(key, sizeof key, "%d", i);
        assert_done(ric_store_trace_put(store, key, work, size));
    }
    assert_done(ric_atlas_read(in_folder("a"), &read_back));
    assert_true(same_atlas(made, read_back));
    ric_store_close(store);
    ric_atlas_free(made);
    ric_atlas_free(read_back);
    free(work);
}

/* Runs `work` where permissions count: as a user who is not root. Returns what it returns. */
static int as_user(int (*work)(const ric_atlas *), const ric_atlas *atlas)
{
    int status;
    pid_t child = fork();
    if (child == 0)
        _exit(geteuid() == 0 && setuid(65534) ? 99 : work(atlas));
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 98;
}

static int read_but_not_write(const ric_atlas *made)
{
    ric_atlas *atlas = NULL;
    ric_store *store = NULL;
    if (ric_atlas_read(in_folder("a"), &atlas) || !same_atlas(atlas, made))
        return 1;
    ric_atlas_free(atlas);
    if (ric_store_open(in_folder("a"), made->study, &store) != RIC_E_IO || !strstr(ric_detail(), "cannot write in its folder"))
        return 2;
    return ric_store_open(in_folder("new"), made->study, &store) == RIC_E_IO ? 0 : 3;
}

static int refuse_read_only_file(const ric_atlas *made)
{
    ric_store *store = NULL;
    return ric_store_open(in_folder("a"), made->study, &store) == RIC_E_IO && strstr(ric_detail(), "permissions") ? 0 : 1;
}

static void read_only_places_can_be_read(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 1, 2, 2);
    make_file(in_folder("a"), made);
    chmod(in_folder("a"), 0444);
    chmod(folder, 0555);
    assert_int_equal(as_user(read_but_not_write, made), 0);
    chmod(folder, 0777);
    assert_int_equal(as_user(refuse_read_only_file, made), 0);
    chmod(in_folder("a"), 0000);
    assert_int_equal(as_user(refuse_read_only_file, made), 0);
    assert_int_equal(files_in_folder(), 1);
    ric_atlas_free(made);
}

/* A file-size limit stands for the full disk. */
static int meet_full_disk(const ric_atlas *made)
{
    ric_store *store = NULL;
    ric_status status;
    const struct rlimit tight = {16384, 16384}, loose = {131072, 131072};
    signal(SIGXFSZ, SIG_IGN);
    if (made->n_branch == 1) {
        if (setrlimit(RLIMIT_FSIZE, &tight))
            return 1;
        return ric_store_open(in_folder("new"), made->study, &store) == RIC_E_IO ? 0 : 2;
    }
    if (setrlimit(RLIMIT_FSIZE, &loose) || ric_store_open(in_folder("a"), made->study, &store))
        return 3;
    status = ric_store_trace_put(store, "big", made->branches[0].points, 400000);
    if (!status)
        status = ric_store_commit(store);
    if (status != RIC_E_IO)
        return 4;
    ric_store_close(store);
    return 0;
}

static void a_full_disk_is_reported(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 1, 2, 2), *small = random_atlas(pair_text, 1, 1, 1), *read = NULL;
    free(made->branches[0].points);
    made->branches[0].row.n_point = 4000;
    fill_points(&made->branches[0], 2);
    made->branches[0].row.n_point = 10;
    make_file(in_folder("a"), made);
    int status;
    pid_t child = fork();
    if (child == 0)
        _exit(meet_full_disk(small));
    waitpid(child, &status, 0);
    assert_int_equal(WEXITSTATUS(status), 0);
    assert_int_equal(files_in_folder(), 1); /* nothing half made is left */
    child = fork();
    if (child == 0)
        _exit(meet_full_disk(made));
    waitpid(child, &status, 0);
    assert_int_equal(WEXITSTATUS(status), 0);
    assert_done(ric_atlas_read(in_folder("a"), &read));
    assert_true(same_atlas(made, read));
    assert_int_equal(files_in_folder(), 1);
    ric_atlas_free(read);
    ric_atlas_free(made);
    ric_atlas_free(small);
}

/* ----------------------------------------------------------- documentation */

/* Every table and column of the file is in docs/atlas-format.md, as `table` in a heading and `column` in the first cells below it. */
static void every_column_is_documented(void **state)
{
    (void)state;
    content text = content_of("docs/atlas-format.md");
    ric_atlas *made = random_atlas(pair_text, 1, 1, 1);
    sqlite3 *db = NULL;
    sqlite3_stmt *query = NULL;
    char heading[96], cell[96];
    make_file(in_folder("a"), made);
    ric_atlas_free(made);
    if (!text.bytes)
        skip();
    text.bytes[text.n] = '\0';
    assert_int_equal(sqlite3_open(in_folder("a"), &db), SQLITE_OK);
    assert_int_equal(sqlite3_prepare_v2(db, "SELECT m.name, c.name FROM sqlite_master AS m, pragma_table_info(m.name) AS c WHERE m.type = 'table'",
                                        -1, &query, NULL), SQLITE_OK);
    while (sqlite3_step(query) == SQLITE_ROW) {
        snprintf(heading, sizeof heading, "\n## `%s`", (const char *)sqlite3_column_text(query, 0));
        snprintf(cell, sizeof cell, "| `%s` |", (const char *)sqlite3_column_text(query, 1));
        char *section = strstr((char *)text.bytes, heading);
        if (!section)
            fail_msg("docs/atlas-format.md has no section%s", heading);
        section += strlen(heading);
        char *end = strstr(section, "\n## "), *found = strstr(section, cell);
        if (!found || (end && found > end))
            fail_msg("docs/atlas-format.md: no row %s under%s", cell, heading);
    }
    sqlite3_finalize(query);
    sqlite3_close(db);
    free(text.bytes);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(atlases_come_back_bit_for_bit),
        TEST(faces_beyond_36_are_kept),
        TEST(rows_can_be_asked_for),
        TEST(trace_column_is_the_trace),
        TEST(finished_work_is_found_again),
        TEST(other_budgets_continue_the_file),
        TEST(another_model_is_refused),
        TEST(models_are_compared_by_their_numbers),
        TEST(foreign_files_are_refused),
        TEST(folders_and_devices_are_refused),
        TEST(newer_formats_are_refused),
        TEST(inconsistent_contents_are_refused),
        TEST(forged_contents_are_refused),
        TEST(truncated_files_are_refused),
        TEST(flipped_bits_are_harmless),
        TEST(a_second_run_is_told),
        TEST(a_kill_loses_nothing_committed),
        TEST(readers_and_a_run_get_on),
        TEST(uncommitted_work_blocks_no_reader),
        TEST(read_only_places_can_be_read),
        TEST(a_full_disk_is_reported),
        TEST(every_column_is_documented),
    };
#undef TEST
    return cmocka_run_group_tests(tests, NULL, NULL);
}
