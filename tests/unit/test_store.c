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

static const char other_text[] = "model:\n"
                                 "  mass: [[2, 0], [0, 1]]\n"
                                 "  stiffness: [[9, -1], [-1, 1.0000000000000002]]\n"
                                 "  contacts:\n"
                                 "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                                 "explore:\n"
                                 "  energy: [0, 200]\n"
                                 "  frequency: [0.2, 10]\n"
                                 "  impacts: 24\n";

static void assert_unreadable(const char *path, ric_status expected, const char *reason)
{
    ric_atlas *atlas = NULL;
    int n_before = files_in_folder();
    assert_int_equal(ric_atlas_read(path, &atlas), expected);
    assert_null(atlas);
    if (!strstr(ric_detail(), reason)) fail_msg("expected \"%s\" in: %s", reason, ric_detail());
    assert_int_equal(files_in_folder(), n_before);
}

static void assert_sql(const char *path, const char *sql)
{
    sqlite3 *db = NULL;
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    if (sqlite3_exec(db, sql, NULL, NULL, NULL)) fail_msg("%s: %s", sql, sqlite3_errmsg(db));
    sqlite3_close(db);
}

/* ------------------------------------------------------------- round trips */

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
    assert_int_equal(ric_store_compare_models("a", stored,
                                              "model: \n  mass:\n    - [2.0, 1000]\n  law: rigid"),
                     RIC_OK);
    assert_int_equal(
        ric_store_compare_models("a", stored,
                                 "model:\n  mass:\n    - [2, 1000.0000000000001]\n  law: rigid\n"),
        RIC_E_CONFLICT);
    assert_int_equal(ric_store_compare_models("a", stored,
                                              "model:\n  mass:\n    - [2, 1e3]\n  law: power\n"),
                     RIC_E_CONFLICT);
    assert_int_equal(ric_store_compare_models("a", stored, "model:\n  mass:\n    - [2, 1e3]\n"),
                     RIC_E_CONFLICT);
    assert_int_equal(ric_store_compare_models("a", "model: [1]", "model: [1, 2]"), RIC_E_CONFLICT);
    char *model = ric_store_model_text(
        "title: \"model:\"\nmodel:\n  mass: 1\n\n# note\n  law: rigid\nexplore:\n  model: 3\n");
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
    assert_sql(in_folder("wal ?#%41.db"),
               "PRAGMA journal_mode = WAL; CREATE TABLE t (x); PRAGMA user_version = 1");
    static const char *const names[] = {"text", "zeros", "foreign", "wal ?#%41.db"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        assert_refused(in_folder(names[i]), pair_text, RIC_E_FORMAT, "not an atlas");
        assert_unreadable(in_folder(names[i]), RIC_E_FORMAT, "not an atlas");
    }
    assert_unreadable(in_folder("empty"), RIC_E_FORMAT, "empty");
    assert_unreadable(in_folder("none"), RIC_E_MISSING, "no such file");
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
        branch->row.impacts = branch->row.letters = i ? branch->row.impacts : 0;
        branch->row.n_point = 5;
        fill_points(branch, ric_atlas_model(made));
    }
    return made;
}

/* Each of these leaves a sound SQLite file with wrong contents. */
static void inconsistent_contents_are_refused(void **state)
{
    (void)state;
    static const char *const changes[] = {
        "UPDATE branch SET to_junction = 99 WHERE id = 1",
        "UPDATE branch SET impacts = impacts + 1",
        "UPDATE branch SET word = '9'",
        "UPDATE branch SET points = points + 1 WHERE id = 1",
        "UPDATE branch SET points = 2147483647",
        "UPDATE branch SET id = 9 WHERE id = 3",
        "UPDATE branch SET stop = 'nowhere'",
        "UPDATE branch SET energy_min = 'low'",
        "UPDATE branch SET symmetric = 2",
        "UPDATE branch SET mode = 3",
        "DELETE FROM branch WHERE id = 3",
        "DELETE FROM branch",
        "DELETE FROM point WHERE branch = 3",
        "UPDATE point SET state = x'00'",
        "UPDATE point SET state = state || x'00'",
        "UPDATE point SET flights = zeroblob(0)",
        "UPDATE point SET flights = 3",
        "UPDATE point SET point = point + 100",
        "UPDATE point SET stable = 3",
        "UPDATE point SET energy = x'00'",
        "INSERT INTO branch_junction VALUES (1, 77, 1, 0.5)",
        "INSERT INTO branch_junction VALUES (77, 0, 1, 0.5)",
        "UPDATE junction SET kind = ''",
        "UPDATE junction SET multiple = 0",
        "UPDATE junction SET state = zeroblob(24)",
        "UPDATE junction SET id = 7 WHERE id = 1",
        "INSERT INTO junction_branch VALUES (1, 77)",
        "INSERT INTO junction_branch VALUES (77, 1)",
        "DELETE FROM junction",
        "DELETE FROM meta",
        "UPDATE meta SET value = 'x' WHERE key = 'study'",
        "DELETE FROM meta WHERE key = 'study'",
        "DROP TABLE point",
        "DROP TABLE trace",
        "ALTER TABLE point RENAME COLUMN state TO place",
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
        "UPDATE branch SET to_junction = 99 WHERE id = 1",
        "UPDATE branch SET impacts = impacts + 1",
        "UPDATE branch SET word = '9'",
        "UPDATE branch SET word = replace(word, '1', '2')",
        "UPDATE point SET state = zeroblob(40)",
        "UPDATE branch SET points = points + 1 WHERE id = 1",
        "UPDATE branch SET points = 2147483647",
        "UPDATE branch SET id = 9 WHERE id = 3",
        "UPDATE branch SET stop = 'nowhere'",
        "UPDATE branch SET energy_min = 'low'",
        "UPDATE branch SET mode = 3",
        "DELETE FROM branch WHERE id = 3",
        "UPDATE point SET state = x'00'",
        "UPDATE point SET flights = 3",
        "UPDATE point SET stable = 3",
        "INSERT INTO branch_junction VALUES (1, 77, 1, 0.5)",
        "INSERT INTO branch_junction VALUES (77, 0, 1, 0.5)",
        "UPDATE junction SET kind = ''",
        "UPDATE junction SET multiple = 0",
        "UPDATE junction SET state = zeroblob(24)",
        "INSERT INTO junction_branch VALUES (1, 77)",
        "INSERT INTO junction_branch VALUES (77, 1)",
        "DELETE FROM junction",
        "UPDATE meta SET value = 'x' WHERE key = 'study'",
        "DELETE FROM meta WHERE key = 'study'",
    };
    ric_atlas *made = atlas_with_a_touchless_branch();
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        ric_database file;
        remove(in_folder("a"));
        make_file(in_folder("a"), made);
        assert_sql(in_folder("a"), changes[i]);
        assert_done(ric_store_sqlite_open(in_folder("a"), SQLITE_OPEN_READWRITE, 0, &file));
        assert_done(ric_store_put_digest(file));
        sqlite3_close(file.db);
        assert_unreadable(in_folder("a"), RIC_E_FORMAT, "damaged");
    }
    ric_atlas_free(made);
}

/* Numbers that no run writes are named: table, row, field, what is wrong. */
static void forged_numbers_are_named(void **state)
{
    (void)state;
#define FIRST " WHERE branch = 2 AND point = 3"
#define PUT(column, bytes)                                                                         \
    "UPDATE point SET " column " = CAST(x'" bytes "' || substr(" column ", 9) AS BLOB)" FIRST
    static const char *const changes[][2] = {
        {"UPDATE point SET energy = 9e999" FIRST,
         "table point, row 2, 3, energy: inf is not between"},
        {"UPDATE point SET energy = NULL" FIRST, "table point, row 2, 3, energy: not a number"},
        {"UPDATE point SET energy = -1.0" FIRST,
         "table point, row 2, 3, energy: -1 is not between"},
        {"UPDATE point SET energy = energy + 1.0" FIRST,
         "table point, row 2, 3, state: its energy is"},
        {"UPDATE point SET energy = 3" FIRST, "table point, row 2, 3, energy: not a number"},
        {"UPDATE point SET frequency = 0.0" FIRST,
         "table point, row 2, 3, frequency: 0 is not between"},
        {"UPDATE point SET frequency = 1e300" FIRST,
         "table point, row 2, 3, frequency: 1e+300 is not between"},
        {"UPDATE point SET frequency = frequency * 1.1" FIRST,
         "table point, row 2, 3, flights: together"},
        {"UPDATE point SET arclength = 1e-9" FIRST,
         "table point, row 2, 3, arclength: 1e-09 after"},
        {"UPDATE point SET rotation = 7.5" FIRST,
         "table point, row 2, 3, rotation: 7.5 is not between"},
        {"UPDATE point SET residual = 1e300" FIRST, "table point, row 2, 3, residual: "},
        {"UPDATE point SET approach = -9e999" FIRST, "table point, row 2, 3, approach: "},
        {PUT("state", "000000000000f87f"),
         "table point, row 2, 3, state: a number in it is not finite"},
        {PUT("state", "9c7500883ce4377e"),
         "table point, row 2, 3, state: a number in it is not finite, or beyond"},
        {PUT("flights", "000000000000f07f"),
         "table point, row 2, 3, flights: a number in it is not finite"},
        {PUT("flights", "000000000000f0bf"),
         "table point, row 2, 3, flights: -1 s is less than no time"},
        {"UPDATE branch SET stable_fraction = 1.5 WHERE id = 3",
         "table branch, row 3, stable_fraction: 1.5"},
        {"UPDATE branch SET energy_min = 1e99 WHERE id = 3",
         "table branch, row 3, energy_min: more than"},
        {"UPDATE branch SET impacts = 9223372036854775807 WHERE id = 3",
         "table branch, row 3, impacts: not a whole"},
        {"UPDATE branch SET mode = 0 WHERE id = 1", "table branch, row 1, mode: 0 where"},
        {"UPDATE branch SET word = word || 'x' WHERE id = 3",
         "table branch, row 3, word: no word of faces"},
        {"UPDATE branch SET label = CAST(x'41ff' AS TEXT) WHERE id = 3",
         "table branch, row 3, label: not a text"},
        {"UPDATE branch SET label = CAST(x'410042' AS TEXT) WHERE id = 3",
         "table branch, row 3, label: not a text"},
        {"DELETE FROM junction_branch", "does not list branch"},
        {"INSERT OR IGNORE INTO junction_branch SELECT junction.id, branch.id FROM junction, "
         "branch",
         "neither ends here nor passes"},
        {"UPDATE junction SET multiple = 2000000000 WHERE id = 2",
         "table junction, row 2, multiple: not a whole"},
        {"UPDATE junction SET grazings = 2000000000 WHERE id = 2",
         "table junction, row 2, grazings: not a whole"},
        {"UPDATE junction SET rotation_p = 3, rotation_q = 2 WHERE id = 2",
         "table junction, row 2, rotation_p: 3 of 2"},
        {"UPDATE junction SET frequency = NULL WHERE id = 2",
         "table junction, row 2, frequency: not a number"},
        {"UPDATE junction SET kind = 'x' WHERE id = 2",
         "table junction, row 2, kind: none of the words"},
        {"UPDATE branch_junction SET arclength = 9e999", "arclength: inf is not between"},
        {"UPDATE meta SET value = '9999999999999' WHERE key = 'blind'",
         "table meta, row blind: not a count"},
        {"UPDATE meta SET value = 'x' WHERE key = 'finished'",
         "table meta, row finished: neither 0 nor 1"},
        {"UPDATE meta SET value = 'model:' WHERE key = 'model'",
         "table meta, row model: not the model"},
        {"UPDATE meta SET value = x'31' WHERE key = 'finished'",
         "table meta: a value is not a text"},
    };
    ric_atlas *made = atlas_with_a_touchless_branch();
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        ric_database file;
        ric_atlas *read = NULL;
        remove(in_folder("a"));
        make_file(in_folder("a"), made);
        assert_sql(in_folder("a"), changes[i][0]);
        assert_done(ric_store_sqlite_open(in_folder("a"), SQLITE_OPEN_READWRITE, 0, &file));
        assert_done(ric_store_put_digest(file));
        sqlite3_close(file.db);
        if (ric_atlas_read(in_folder("a"), &read) != RIC_E_FORMAT ||
            !strstr(ric_detail(), changes[i][1]))
            fail_msg("%s: %s", changes[i][0], read ? "read" : ric_detail());
        assert_unreadable(in_folder("a"), RIC_E_FORMAT, "restore it from a copy");
    }
    ric_atlas_free(made);
}

/* The damaged bytes either are found out or do not matter, for the reader and for a run. */
static void assert_harmless(const content *damaged, const ric_atlas *made, const char *what,
                            long at)
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
    if (!status && !ric_store_trace_get(store, "S2-[01]", &blob, &size) && blob &&
        (size != 14 || memcmp(blob, "some work\0done", 14)))
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
    seed_now = 20240607;
    for (int i = 0; i < 3000; i += every_of(4)) {
        size_t at = i < 100    ? (size_t)i
                    : i < 1000 ? (size_t)below(4096)
                               : (size_t)below((int)whole.n);
        unsigned char before = whole.bytes[at];
        whole.bytes[at] ^= (unsigned char)(i % 3 ? 1 << below(8) : 1 + below(255));
        assert_harmless(&whole, made, "flip", (long)at);
        whole.bytes[at] = before;
    }
    free(whole.bytes);
    ric_atlas_free(made);
}

/* ------------------------------------------------------------------- bytes */

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

/* ----------------------------------------------------------- documentation */

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
        TEST(another_model_is_refused),
        TEST(models_are_compared_by_their_numbers),
        TEST(foreign_files_are_refused),
        TEST(folders_and_devices_are_refused),
        TEST(newer_formats_are_refused),
        TEST(inconsistent_contents_are_refused),
        TEST(forged_contents_are_refused),
        TEST(forged_numbers_are_named),
        TEST(truncated_files_are_refused),
        TEST(flipped_bits_are_harmless),
        TEST(every_column_is_documented),
        TEST(document_is_up_to_date),
        TEST(bytes_come_back),
    };
#undef TEST
    return cmocka_run_group_tests(tests, NULL, NULL);
}
