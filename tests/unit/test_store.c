/* The atlas file: what goes in comes out, and nothing else ever does. */
#include "base/bytes.h"
#include "stored_atlases.h"

/* Some tests forge a file with the store's own inner functions. */
#include "atlas/store_parts.h"
#include "sample.h"

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

static void atlases_come_back_bit_for_bit(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 20; seed += (uint64_t)every()) {
        ric_atlas *made = random_atlas(pair_text, seed, 1 + (int)seed % 7, 1 + (int)seed % 5),
                  *read = NULL;
        make_file(in_folder("a"), made);
        assert_done(ric_atlas_read(in_folder("a"), &read));
        if (!same_atlas(made, read)) fail_msg("seed %d: the atlas has changed", (int)seed);
        ric_atlas_free(made);
        ric_atlas_free(read);
    }
    assert_int_equal(files_in_folder(), 1);
}

static void faces_beyond_36_are_kept(void **state)
{
    (void)state;
    char text[8192];
    int n = snprintf(
        text, sizeof text,
        "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n");
    for (int i = 0; i < 20; i++)
        n += snprintf(text + n, sizeof text - (size_t)n,
                      "    - {normal: [-1, %d], clearance: %d, sides: both, law: rigid}\n", i + 1,
                      i + 3);
    snprintf(text + n, sizeof text - (size_t)n,
             "explore: {energy: [0, 20], frequency: [0.2, 10], impacts: 4}\n");
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
        assert_memory_equal(flights, at + 12,
                            sizeof *flights * (size_t)(branch.impacts ? branch.impacts : 1));
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
    fill_points(branch, ric_atlas_model(made));
    for (int i = 0; i < 8; i++) {
        ric_point *point = (ric_point *)(void *)(branch->points + (size_t)i * branch->stride);
        point->trace = i < 6 ? asinh(traces[i] / 2) : i == 6 ? -5000 : NAN;
    }
    make_file(in_folder("a"), made);
    assert_int_equal(sqlite3_open(in_folder("a"), &db), SQLITE_OK);
    assert_int_equal(
        sqlite3_prepare_v2(
            db, "SELECT trace, log_trace, trace_asinh FROM point WHERE branch = 1 ORDER BY point",
            -1, &query, NULL),
        SQLITE_OK);
    for (int i = 0; i < 8; i++) {
        assert_int_equal(sqlite3_step(query), SQLITE_ROW);
        double trace = sqlite3_column_double(query, 0), logarithm = sqlite3_column_double(query, 1);
        assert_int_equal(sqlite3_column_type(query, 0), i < 6 ? SQLITE_FLOAT : SQLITE_NULL);
        assert_int_equal(sqlite3_column_type(query, 1),
                         i < 7 && i > 0 ? SQLITE_FLOAT : SQLITE_NULL);
        if (i < 6)
            assert_true(fabs(trace - traces[i]) <=
                        1e-12 * fabs(traces[i]) * (1 + fabs(log(fabs(traces[i]) + 1))));
        if (i > 0 && i < 6)
            assert_true(fabs(logarithm - log(fabs(traces[i]))) <= 1e-13 * (1 + fabs(logarithm)));
        if (i == 6) assert_true(logarithm == 5000);
    }
    sqlite3_finalize(query);
    sqlite3_close(db);
    ric_atlas_free(made);
}

/* Of a table with many points, in a file that had another one before. Without SQLite's table dbstat
 * there is nothing to be asked. */
static void pages_of_points_are_full(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 2, 2, 2), *read = NULL;
    sqlite3 *db = NULL;
    sqlite3_int64 empty = 0;
    for (int k = 0; k < 2; k++) {
        ric_branch_record *branch = &made->branches[k];
        free(branch->points);
        branch->row.n_point = 1500 + 1000 * k;
        fill_points(branch, ric_atlas_model(made));
        make_file(in_folder("a"), made);
    }
    assert_done(ric_atlas_read(in_folder("a"), &read));
    assert_true(same_atlas(made, read));
    assert_int_equal(sqlite3_open(in_folder("a"), &db), SQLITE_OK);
    const int code = ric_store_sqlite_ask(
        db, "SELECT 1000 * sum(unused) / sum(pgsize) FROM dbstat WHERE name = 'point'", &empty);
    if (!code) assert_in_range(empty, 0, 50);
    sqlite3_close(db);
    ric_atlas_free(made);
    ric_atlas_free(read);
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
    seed_now = 1;
    for (int i = 0; i < 3000000; i++) big[i] = (unsigned char)random_bits();
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

static void ask_for(ric_store *store, int k, bool there)
{
    char key[32], *blob = NULL;
    size_t size = 9;
    snprintf(key, sizeof key, "work %d", k);
    assert_done(ric_store_trace_get(store, key, (void **)&blob, &size));
    assert_int_equal(blob != NULL, there);
    assert_int_equal(size, there ? (size_t)(k % 5000) : 0);
    for (size_t i = 0; i < size; i++) assert_int_equal(blob[i], (char)k);
    free(blob);
}

/* In a file that is new, and in one that was there: whoever asks for work finds what was put before
 * that, and nothing that was dropped. */
static void work_put_aside_is_kept(void **state)
{
    (void)state;
    enum { MANY = 3000 };
    ric_study *study = study_of(pair_text);
    for (int round = 0; round < 2; round++) {
        ric_store *store = NULL;
        char key[32], bytes[5000];
        assert_done(ric_store_open(in_folder("a"), study, &store));
        ric_store_aside(store);
        for (int k = round * MANY; k < (round + 1) * MANY; k++) {
            snprintf(key, sizeof key, "work %d", k);
            memset(bytes, k, sizeof bytes);
            if (k % 10 == 0) ask_for(store, k, false);
            assert_done(ric_store_trace_put(store, key, bytes, (size_t)(k % 5000)));
            if (k % 7 == 0) assert_done(ric_store_trace_drop(store, key));
            if (k % 100 == 99) assert_done(ric_store_commit(store));
            if (k % 10 == 0) ask_for(store, k, k % 7 != 0);
        }
        assert_done(ric_store_trace_drop(store, "no work"));
        if (round == 0) assert_done(ric_store_rejoin(store));
        ric_store_close(store);
        assert_done(ric_store_open(in_folder("a"), study, &store));
        for (int k = 0; k < (round + 2) * MANY; k++)
            ask_for(store, k, k < (round + 1) * MANY && k % 7 != 0);
        ric_store_close(store);
    }
    ric_study_free(study);
}

typedef struct {
    int done, refused;
} series;

static ric_status do_task(void *user, const ric_store_task *task)
{
    series *s = user;
    if (atoi(task->key) == s->refused) return ric_fail(RIC_E_IO, "disk full at %s", task->key);
    assert_int_equal(atoi(task->key), s->done++);
    return RIC_OK;
}

/* The first failure ends it, and is told to whoever goes on. */
static void what_fails_aside_is_told(void **state)
{
    (void)state;
    for (int refused = 0; refused <= 400; refused += 200) {
        series s = {0, refused};
        ric_store_later *later = ric_store_later_begin(do_task, &s);
        ric_status status = RIC_OK;
        assert_non_null(later);
        for (int k = 0; k < 300 && !status; k++) {
            char key[16];
            snprintf(key, sizeof key, "%d", k);
            status = ric_store_later_add(later, &(ric_store_task){RIC_STORE_PUT, key, "x", 1});
            if (k % 90 == 0 && !status) status = ric_store_later_wait(later);
        }
        assert_true(status == RIC_OK || status == RIC_E_IO);
        assert_int_equal(ric_store_later_end(later), refused < 300 ? RIC_E_IO : RIC_OK);
        assert_int_equal(s.done, refused < 300 ? refused : 300);
        if (refused < 300) assert_non_null(strstr(ric_detail(), "disk full at "));
    }
    assert_done(ric_store_later_end(NULL));
}

static void work_of_another_solver_is_dropped(void **state)
{
    (void)state;
    ric_study *study = study_of(pair_text);
    ric_store *store;
    void *blob = NULL;
    size_t size = 0;
    static const char *const versions[] = {"1.1", "1.1", "2.1", "2.2"};
    for (int i = 0; i < 4; i++) {
        assert_done(ric_store_open(in_folder("versions"), study, &store));
        assert_done(ric_store_set_solver(store, versions[i]));
        assert_done(ric_store_trace_get(store, "branch", &blob, &size));
        assert_true((blob != NULL) == (i == 1)); /* the same version twice */
        free(blob);
        assert_done(ric_store_trace_put(store, "branch", versions[i], 3));
        ric_store_close(store);
    }
    ric_study_free(study);
}

static void other_budgets_continue_the_file(void **state)
{
    (void)state;
    ric_atlas *first = random_atlas(pair_text, 1, 2, 2),
              *second = random_atlas(budget_text, 2, 5, 4), *read = NULL;
    ric_store *store = NULL;
    void *blob = NULL;
    size_t size;
    make_file(in_folder("a"), first);
    assert_done(ric_store_open(in_folder("a"), second->study, &store));
    assert_done(ric_store_trace_get(store, "S2-[01]", &blob, &size));
    assert_int_equal(size, 14);
    free(blob);
    assert_done(ric_atlas_read(in_folder("a"),
                               &read)); /* what was there stays until the new tables are there */
    assert_true(same_atlas(first, read));
    ric_atlas_free(read);
    assert_done(ric_store_write(store, second, 1));
    ric_store_close(store);
    assert_done(ric_atlas_read(in_folder("a"), &read));
    assert_true(same_atlas(second, read));
    ric_atlas_free(read);
    ric_atlas_free(first);
    ric_atlas_free(second);
}

static void pass_three(ric_bytes *b, void *user)
{
    double *values = user;
    for (int i = 0; i < 3; i++) ric_bytes_pass(b, &values[i], sizeof *values);
}

/* What is written comes back; what is cut off is 0 and said, and nothing behind it is read. */
static void bytes_come_back(void **state)
{
    double values[] = {1.5, -0.0, 3};
    size_t size;
    char *bytes = ric_bytes_make(pass_three, values, &size);
    (void)state;
    assert_non_null(bytes);
    assert_int_equal(size, sizeof values);
    for (size_t cut = 0; cut <= size; cut++) {
        double back[] = {7, 7, 7};
        ric_bytes b = ric_bytes_of(bytes, cut);
        pass_three(&b, back);
        assert_int_equal(b.lost, cut < size);
        for (size_t i = 0; i < 3; i++)
            assert_memory_equal(&back[i], i < cut / sizeof *back ? &values[i] : &(double){0},
                                sizeof *back);
    }
    free(bytes);
}

/* Every table and column of the file is in docs/atlas-format.md, as `table` in a heading and
 * `column` in the first cells below it. */
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
    if (!text.bytes) skip();
    text.bytes[text.n] = '\0';
    assert_int_equal(sqlite3_open(in_folder("a"), &db), SQLITE_OK);
    assert_int_equal(sqlite3_prepare_v2(db,
                                        "SELECT m.name, c.name FROM sqlite_master AS m, "
                                        "pragma_table_info(m.name) AS c WHERE m.type = 'table'",
                                        -1, &query, NULL),
                     SQLITE_OK);
    while (sqlite3_step(query) == SQLITE_ROW) {
        snprintf(heading, sizeof heading, "\n## `%s`", (const char *)sqlite3_column_text(query, 0));
        snprintf(cell, sizeof cell, "| `%s` |", (const char *)sqlite3_column_text(query, 1));
        char *section = strstr((char *)text.bytes, heading);
        if (!section) fail_msg("docs/atlas-format.md has no section%s", heading);
        section += strlen(heading);
        char *end = strstr(section, "\n## "), *found = strstr(section, cell);
        if (!found || (end && found > end))
            fail_msg("docs/atlas-format.md: no row %s under%s", cell, heading);
    }
    sqlite3_finalize(query);
    sqlite3_close(db);
    free(text.bytes);
}

/* The tables of docs/atlas-format.md are those that the list of columns makes: table after table
 * from the head of the first row to an empty line. UPDATE=1 in the environment writes them anew. */
static void document_is_up_to_date(void **state)
{
    static const ric_table *const tables[] = {&ric_table_branch, &ric_table_branch_junction,
                                              &ric_table_point, &ric_table_junction,
                                              &ric_table_junction_branch};
    content page = content_of("docs/atlas-format.md"); /* tests run in the root of the source */
    (void)state;
    assert_non_null(page.bytes);
    page.bytes[page.n] = '\0';
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        char heading[96], *wanted = NULL, *whole = NULL;
        size_t size;
        FILE *out = open_memstream(&wanted, &size);
        assert_non_null(out);
        ric_column_document(tables[i], out);
        fclose(out);
        snprintf(heading, sizeof heading, "\n## `%s`\n", tables[i]->name);
        char *section = strstr((char *)page.bytes, heading),
             *from = section ? strstr(section, "\n| column |") : NULL,
             *to = from ? strstr(from, "\n\n") : NULL;
        assert_non_null(to);
        if (getenv("UPDATE")) {
            assert_true(asprintf(&whole, "%.*s%s%s", (int)(from + 1 - (char *)page.bytes),
                                 (char *)page.bytes, wanted, to + 1) > 0);
            free(page.bytes);
            page = (content){(unsigned char *)whole, strlen(whole)};
            write_file("docs/atlas-format.md", page.bytes, page.n);
        } else if ((size_t)(to - from) != size || strncmp(from + 1, wanted, size))
            fail_msg("docs/atlas-format.md: the table of `%s` is not that of src/atlas/columns.c; "
                     "UPDATE=1 writes it",
                     tables[i]->name);
        free(wanted);
    }
    free(page.bytes);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(atlases_come_back_bit_for_bit),
        TEST(faces_beyond_36_are_kept),
        TEST(rows_can_be_asked_for),
        TEST(trace_column_is_the_trace),
        TEST(work_of_another_solver_is_dropped),
        TEST(pages_of_points_are_full),
        TEST(finished_work_is_found_again),
        TEST(work_put_aside_is_kept),
        TEST(what_fails_aside_is_told),
        TEST(other_budgets_continue_the_file),
        TEST(every_column_is_documented),
        TEST(document_is_up_to_date),
        TEST(bytes_come_back),
    };
#undef TEST
    return cmocka_run_group_tests(tests, NULL, NULL);
}
