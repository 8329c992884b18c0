/* Whether a file is an atlas of ours, whole, and of the model of a study. A foreign, damaged or
 * newer one is refused and left as it is. */
#include "store_parts.h"
#include "base/room.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---------------------------------------------------------------- identity */

ric_status ric_store_look(const char *path, bool *exists, bool *empty)
{
    struct stat found;
    *exists = *empty = false;
    if (stat(path, &found)) {
        if (errno == ENOENT && !lstat(path, &found))
            return ric_fail(RIC_E_IO,
                            "%s: a symbolic link to a file that is not there; remove it, or choose "
                            "another name",
                            path);
        return errno == ENOENT
                   ? RIC_OK
                   : ric_fail(RIC_E_IO, "%s: %s; choose another file", path, strerror(errno));
    }
    if (!S_ISREG(found.st_mode))
        return ric_fail(RIC_E_IO, "%s: not a file but %s; choose another name", path,
                        ric_store_file_kind(found.st_mode));
    *exists = true;
    *empty = found.st_size == 0;
    return RIC_OK;
}

/* Damage is left for the full check to find, because what looks like it may be a transaction that
 * opening the file will undo. */
ric_status ric_store_check_identity(const char *path)
{
    ric_database file;
    sqlite3_int64 application = 0, version = 0;
    ric_status status = ric_store_sqlite_open_still(path, &file);
    if (status == RIC_E_NOMEM) goto out;
    if (status) {
        status = ric_fail(status, "%s: cannot be read; check its permissions", path);
        goto out;
    }
    int code = ric_store_sqlite_ask(file.db, "PRAGMA application_id", &application);
    if (!code) code = ric_store_sqlite_ask(file.db, "PRAGMA user_version", &version);
    if (code) status = (code & 0xff) == SQLITE_CORRUPT ? RIC_OK : ric_store_sqlite_fail(file, code);
    else if (application == RIC_RESPONSE_ID)
        status = ric_fail(RIC_E_FORMAT,
                          "%s: not an atlas but curves of `ricochet response`; `ricochet plot "
                          "response` draws them, and `ricochet response FILE` lists them",
                          path);
    else if (application != RIC_APPLICATION_ID) status = ric_store_fail_foreign(path);
    else if (version > RIC_FORMAT_VERSION)
        status = ric_fail(RIC_E_FORMAT,
                          "%s: atlas of format %lld, and ricochet %s knows formats up to %d; use a "
                          "newer ricochet",
                          path, (long long)version, ric_version(), RIC_FORMAT_VERSION);
    else if (version < 1) status = ric_store_fail_damaged(path, "its format has no number");
out:
    sqlite3_close(file.db);
    return status;
}

/* -------------------------------------------------------------------- meta */

ric_status ric_store_get_meta(ric_database file, const char *key, char **value)
{
    sqlite3_stmt *query = NULL;
    bool row = false;
    *value = NULL;
    ric_status status = ric_store_sqlite_prepare(file, "SELECT value FROM meta WHERE key = ?",
                                                 &query);
    if (!status) {
        sqlite3_bind_text(query, 1, key, -1, SQLITE_STATIC);
        status = ric_store_sqlite_step(file, query, &row);
    }
    if (!status && row) {
        bool is_text = sqlite3_column_type(query, 0) == SQLITE_TEXT;
        const char *text = is_text ? (const char *)sqlite3_column_text(query, 0) : NULL;
        *value = text ? ric_strdup(text) : NULL;
        if (!is_text)
            status = ric_store_fail_damaged(file.path, "table meta: a value is not a text");
        else if (!*value) status = ric_store_fail_memory();
    }
    sqlite3_finalize(query);
    return status;
}

ric_status ric_store_put_meta(ric_database file, const char *key, const char *value)
{
    sqlite3_stmt *insert = NULL;
    bool row;
    ric_status status =
        ric_store_sqlite_prepare(file, "INSERT OR REPLACE INTO meta (key, value) VALUES (?, ?)",
                                 &insert);
    if (!status) {
        int code = sqlite3_bind_text(insert, 1, key, -1, SQLITE_STATIC) |
                   sqlite3_bind_text(insert, 2, value, -1, SQLITE_STATIC);
        status = code ? ric_store_fail_memory() : ric_store_sqlite_step(file, insert, &row);
    }
    sqlite3_finalize(insert);
    return status;
}

/* ---------------------------------------------------------------- contents */

static ric_status check_digest(ric_database file)
{
    uint64_t digest;
    char text[17], *stored = NULL;
    ric_status status = ric_store_digest_contents(file, &digest);
    if (!status) status = ric_store_get_meta(file, "digest", &stored);
    if (!status) {
        snprintf(text, sizeof text, "%016llx", (unsigned long long)digest);
        if (!stored || strcmp(stored, text))
            status = ric_store_fail_damaged(file.path, "the contents do not match their digest");
    }
    free(stored);
    return status;
}

ric_status ric_store_check_contents(ric_database file)
{
    sqlite3_stmt *query = NULL;
    sqlite3_int64 tables = 0;
    bool row = false;
    ric_status status = ric_store_sqlite_prepare(file, "PRAGMA quick_check(1)", &query);
    if (!status) status = ric_store_sqlite_step(file, query, &row);
    if (!status && row) {
        const char *answer = (const char *)sqlite3_column_text(query, 0);
        if (!answer || strcmp(answer, "ok"))
            status = ric_store_fail_damaged(file.path, answer ? answer : "it cannot be checked");
    }
    sqlite3_finalize(query);
    if (status) return status;
    int code = ric_store_sqlite_ask(
        file.db,
        "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND rootpage > 0 AND name IN "
        "('meta', 'trace', 'branch', 'branch_junction', 'point', 'junction', 'junction_branch')",
        &tables);
    if (code) return ric_store_sqlite_fail(file, code);
    return tables == 7 ? check_digest(file)
                       : ric_store_fail_damaged(file.path, "a table is missing");
}

/* ------------------------------------------------------------- stored work */

/* What is wrong with a row of the table `trace`, NULL: nothing. `last`: the key before it. */
static const char *wrong_work(sqlite3_stmt *row, const char *last)
{
    if (sqlite3_column_type(row, 0) != SQLITE_TEXT) return "its key is not a text";
    const char *key = (const char *)sqlite3_column_text(row, 0);
    if (!key || strlen(key) != (size_t)sqlite3_column_bytes(row, 0)) return "its key is not a text";
    if (last && !strcmp(last, key)) return "its key is there twice";
    if (sqlite3_column_type(row, 1) != SQLITE_BLOB) return "blob: not a row of bytes";
    if (sqlite3_column_type(row, 2) != SQLITE_INTEGER) return "digest: not a whole number";
    const void *bytes = sqlite3_column_blob(row, 1);
    const size_t n = (size_t)sqlite3_column_bytes(row, 1);
    return sqlite3_column_int64(row, 2) == (sqlite3_int64)ric_bytes_hash(RIC_BYTES_HASH, bytes, n)
               ? NULL
               : "the bytes do not match their digest";
}

/* Rows without a type of their own are compared in the order of their keys, so that a key that
 * comes twice shows. */
ric_status ric_store_check_work(ric_database file)
{
    sqlite3_stmt *query = NULL;
    char *last = NULL;
    bool row = false;
    ric_status status = ric_store_sqlite_prepare(file,
                                                 "SELECT key, blob, digest FROM trace ORDER BY key",
                                                 &query);
    while (!status && !(status = ric_store_sqlite_step(file, query, &row)) && row) {
        const char *wrong = wrong_work(query, last),
                   *key = (const char *)sqlite3_column_text(query, 0);
        if (sqlite3_errcode(file.db) == SQLITE_NOMEM) status = ric_store_fail_memory();
        else if (wrong) status = ric_store_fail_row(file.path, "trace", key, wrong);
        free(last);
        last = key ? ric_strdup(key) : NULL;
        if (!status && key && !last) status = ric_store_fail_memory();
    }
    free(last);
    sqlite3_finalize(query);
    return status;
}

/* ---------------------------------------------------------- model identity */

char *ric_store_model_text(const char *study)
{
    const char *begin = NULL, *line = study;
    while (line && *line) {
        const char *next = strchr(line, '\n');
        if (!begin && !strncmp(line, "model:", 6)) begin = line;
        else if (begin && !strchr(" \t\r\n#-]}", *line)) break;
        line = next ? next + 1 : line + strlen(line);
    }
    return begin ? strndup(begin, (size_t)(line - begin)) : ric_strdup("");
}

/* Next run of characters that carries meaning; returns its length, 0 at the end. */
static size_t next_token(const char **text)
{
    static const char separators[] = " \t\r\n,[]{}";
    *text += strspn(*text, separators);
    return strcspn(*text, separators);
}

static bool same_token(const char *a, size_t n_a, const char *b, size_t n_b)
{
    char *end_a, *end_b;
    if (n_a == n_b && !memcmp(a, b, n_a)) return true;
    double x = ric_c_strtod(a, &end_a), y = ric_c_strtod(b, &end_b);
    return n_a && n_b && end_a == a + n_a && end_b == b + n_b && x == y;
}

ric_status ric_store_compare_models(const char *path, const char *stored, const char *given)
{
    for (;;) {
        size_t n_a = next_token(&stored), n_b = next_token(&given);
        if (!same_token(stored, n_a, given, n_b))
            return ric_fail(RIC_E_CONFLICT,
                            "%s: the atlas of another model (it has `%.*s` where the study has "
                            "`%.*s`); choose another "
                            "file with -o",
                            path, (int)(n_a > 40 ? 40 : n_a), stored, (int)(n_b > 40 ? 40 : n_b),
                            given);
        if (!n_a) return RIC_OK;
        stored += n_a;
        given += n_b;
    }
}

ric_status ric_store_check_model(ric_database file, const ric_study *study)
{
    char *stored = NULL, *given = NULL;
    ric_status status = ric_store_get_meta(file, "model", &stored);
    if (status) goto out;
    given = ric_store_model_text(ric_study_text(study));
    if (!given) status = ric_store_fail_memory();
    else
        status = stored ? ric_store_compare_models(file.path, stored, given)
                        : ric_store_fail_damaged(file.path, "its model is missing");
out:
    free(stored);
    free(given);
    return status;
}
