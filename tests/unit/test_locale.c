/* The library in a program whose locale writes 0,5 for one half. */
#include "stored_atlases.h"

#include <locale.h>
#include <sqlite3.h>

#include "study/options.h"
#include "explore/start.h"

/* A German locale of the system, or one made here; false: there is none to be had. */
static bool comma_locale(void)
{
    char command[600];
    if (setlocale(LC_ALL, "de_DE.UTF-8") || setlocale(LC_ALL, "fr_FR.UTF-8")) return true;
    snprintf(command, sizeof command,
             "localedef -c -i de_DE -f UTF-8 '%s/de_DE.UTF-8' >/dev/null 2>&1", folder);
    if (system(command) == -1) return false;
    setenv("LOCPATH", folder, 1);
    bool found = setlocale(LC_ALL, "de_DE.UTF-8");
    snprintf(command, sizeof command, "rm -rf '%s/de_DE.UTF-8'", folder);
    return system(command) != -1 && found;
}

static void numbers_keep_their_points(void **state)
{
    (void)state;
    static const double flights[] = {0.5, 0.25}, x[] = {1.5, -0.1}, v[] = {0.3, 0.7};
    static const int word[] = {0, 1};
    char plain[64] = "";
    if (!comma_locale()) {
        print_message(
            "no locale with decimal commas is there, and localedef makes none (Debian: locales)\n");
        skip();
    }
    snprintf(plain, sizeof plain, "%g", 0.5);
    assert_string_equal(plain, "0,5");
    ric_study *study = study_of(pair_text);
    char *line = ric_start_line(2, 2, false, -1, -1, word, flights, x, v);
    assert_non_null(line);
    assert_null(strchr(line, ','));
    ric_starts starts;
    assert_done(ric_starts_parse(ric_study_model(study), line, &starts));
    assert_int_equal(starts.n, 1);
    ric_starts_release(&starts);
    free(line);
    double number = 0;
    assert_int_equal(ric_option_text_real("2.5e-1", &number), RIC_TEXT_NUMBER);
    assert_true(number == 0.25);
    snprintf(plain, sizeof plain, "%g", 0.5);
    assert_string_equal(plain, "0,5"); /* the caller's locale is left as it was */
    setlocale(LC_ALL, "C");
    ric_study_free(study);
}

static void keys_of_work(char keys[20000])
{
    sqlite3 *db = NULL;
    sqlite3_stmt *query = NULL;
    ric_study *study = study_of(
        "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9.5, -1], [-1, 1]]\n  contacts:\n"
        "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
        "explore: {energy: [0, 2.5], impacts: 2, depth: 1}\n");
    assert_done(ric_explore(study, in_folder("a"), NULL));
    assert_int_equal(sqlite3_open(in_folder("a"), &db), SQLITE_OK);
    assert_int_equal(sqlite3_prepare_v2(
                         db,
                         "SELECT group_concat(key) || (SELECT group_concat(value) FROM meta) FROM "
                         "(SELECT key FROM trace ORDER BY key)",
                         -1, &query, NULL),
                     SQLITE_OK);
    assert_int_equal(sqlite3_step(query), SQLITE_ROW);
    snprintf(keys, 20000, "%s", (const char *)sqlite3_column_text(query, 0));
    sqlite3_finalize(query);
    sqlite3_close(db);
    remove(in_folder("a"));
    ric_study_free(study);
}

/* Finished work is found by keys that have numbers in them. */
static void work_has_the_same_keys(void **state)
{
    (void)state;
    static char plain[20000], comma[20000];
    keys_of_work(plain);
    if (!comma_locale()) skip();
    keys_of_work(comma);
    setlocale(LC_ALL, "C");
    assert_true(strlen(plain) > 200);
    assert_string_equal(plain, comma);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(numbers_keep_their_points, set_up, tear_down),
        cmocka_unit_test_setup_teardown(work_has_the_same_keys, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
