/* Files that are no atlas, or not that of the study, and damaged and forged ones: refused by name.
 */
#include "stored_atlases.h"

/* Some tests forge a file with the store's own inner functions. */
#include "atlas/store_parts.h"
#include "sample.h"

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

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(another_model_is_refused),    TEST(models_are_compared_by_their_numbers),
        TEST(foreign_files_are_refused),   TEST(folders_and_devices_are_refused),
        TEST(newer_formats_are_refused),   TEST(inconsistent_contents_are_refused),
        TEST(forged_contents_are_refused), TEST(forged_numbers_are_named),
        TEST(truncated_files_are_refused), TEST(flipped_bits_are_harmless),
    };
#undef TEST
    return cmocka_run_group_tests(tests, NULL, NULL);
}
