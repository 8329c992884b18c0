#include "store.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <sqlite3.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "status.h"

enum {
    APPLICATION_ID = 0x52434854, /* "RCHT" */
    FORMAT_VERSION = 1,
    READER_WAIT = 60000, /* ms that a reader waits for a run that is just writing */
    WRITER_WAIT = 60000, /* ms that a run waits for readers */
};

/* Floating-point columns carry no type: with REAL the file would keep -0.0 as 0. */
static const char schema[] =
    "CREATE TABLE meta (key TEXT PRIMARY KEY NOT NULL, value TEXT NOT NULL) WITHOUT ROWID;"
    "CREATE TABLE trace (key TEXT PRIMARY KEY NOT NULL, blob BLOB NOT NULL, digest INTEGER NOT NULL);"
    "CREATE TABLE branch (id INTEGER PRIMARY KEY, label TEXT NOT NULL, impacts INTEGER NOT NULL, word TEXT NOT NULL,"
    " symmetric INTEGER NOT NULL, reversible INTEGER NOT NULL, mirror TEXT NOT NULL, stable_fraction, points INTEGER NOT NULL,"
    " energy_min, energy_max, frequency_min, frequency_max, from_junction INTEGER REFERENCES junction,"
    " to_junction INTEGER REFERENCES junction, stop TEXT NOT NULL, why TEXT NOT NULL, depth INTEGER NOT NULL, mode INTEGER NOT NULL);"
    "CREATE TABLE branch_junction (branch INTEGER NOT NULL REFERENCES branch, position INTEGER NOT NULL,"
    " junction INTEGER NOT NULL REFERENCES junction, arclength, PRIMARY KEY (branch, position)) WITHOUT ROWID;"
    "CREATE TABLE point (branch INTEGER NOT NULL REFERENCES branch, point INTEGER NOT NULL, arclength, energy, frequency, period,"
    " trace, log_trace, trace_asinh, rotation, stable INTEGER NOT NULL, reach, approach, residual, state BLOB NOT NULL,"
    " flights BLOB NOT NULL, PRIMARY KEY (branch, point)) WITHOUT ROWID;"
    "CREATE TABLE junction (id INTEGER PRIMARY KEY, kind TEXT NOT NULL, label TEXT NOT NULL, name TEXT NOT NULL,"
    " impacts INTEGER NOT NULL, word TEXT NOT NULL, grazings INTEGER NOT NULL, multiple INTEGER NOT NULL,"
    " rotation_p INTEGER NOT NULL, rotation_q INTEGER NOT NULL, a INTEGER NOT NULL, b INTEGER NOT NULL, energy, frequency,"
    " state BLOB NOT NULL, flights BLOB NOT NULL, taken INTEGER NOT NULL, known INTEGER NOT NULL, inadmissible INTEGER NOT NULL,"
    " over_budget INTEGER NOT NULL, refused INTEGER NOT NULL, refusal TEXT NOT NULL);"
    "CREATE TABLE junction_branch (junction INTEGER NOT NULL REFERENCES junction, branch INTEGER NOT NULL REFERENCES branch,"
    " PRIMARY KEY (junction, branch)) WITHOUT ROWID;";

/* The columns of a row in the order in which they are put and taken below. */
#define BRANCH_COLUMNS \
    "id, label, impacts, word, symmetric, reversible, mirror, stable_fraction, points, energy_min, energy_max, frequency_min, " \
    "frequency_max, from_junction, to_junction, stop, why, depth, mode"
#define BRANCH_JUNCTION_COLUMNS "branch, position, junction, arclength"
#define POINT_COLUMNS \
    "branch, point, arclength, energy, frequency, trace_asinh, rotation, stable, reach, approach, residual, state, flights, " \
    "period, trace, log_trace"
#define JUNCTION_COLUMNS \
    "id, kind, label, name, impacts, word, grazings, multiple, rotation_p, rotation_q, a, b, energy, frequency, state, flights, " \
    "taken, known, inadmissible, over_budget, refused, refusal"
#define JUNCTION_BRANCH_COLUMNS "junction, branch"

typedef struct {
    sqlite3 *db;
    const char *path; /* borrowed */
} database;

struct ric_store {
    database file;
    char *path, *lock_path;
    int lock; /* descriptor that holds the lock, -1 = none */
    sqlite3_stmt *get, *put;
};

/* ------------------------------------------------------------------ errors */

static ric_status fail_memory(void)
{
    return ric_fail(RIC_E_NOMEM, "out of memory");
}

static ric_status fail_damaged(const char *path, const char *what)
{
    return ric_fail(RIC_E_FORMAT, "%s: damaged atlas (%s); restore it from a copy, or remove it and run the study again", path, what);
}

static ric_status fail_foreign(const char *path)
{
    return ric_fail(RIC_E_FORMAT, "%s: not an atlas; name a file made by `ricochet run`, or another file for a new atlas", path);
}

/* A result code of SQLite as one of our kinds. */
static ric_status fail_sql(database file, int code)
{
    switch (code & 0xff) {
    case SQLITE_NOMEM:
        return fail_memory();
    case SQLITE_NOTADB:
        return fail_foreign(file.path);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return ric_fail(RIC_E_BUSY, "%s: another program keeps the atlas locked; close it and try again", file.path);
    case SQLITE_FULL:
        return ric_fail(RIC_E_IO, "%s: disk full; make room and give the same command again, what was done is kept", file.path);
    case SQLITE_READONLY:
        return code == SQLITE_READONLY_ROLLBACK
            ? ric_fail(RIC_E_IO, "%s: a run was killed while it wrote, and the atlas is read-only; copy it together with "
                       "the file ending in -journal to a folder that can be written", file.path)
            : ric_fail(RIC_E_IO, "%s: cannot be written; check its permissions and those of its folder", file.path);
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
    case SQLITE_AUTH:
        return ric_fail(RIC_E_IO, "%s: cannot be opened; check that its folder exists, and the permissions of both", file.path);
    case SQLITE_IOERR:
        return ric_fail(RIC_E_IO, "%s: cannot be read or written (%s); check the disk", file.path, sqlite3_errstr(code));
    case SQLITE_TOOBIG:
        return ric_fail(RIC_E_RANGE, "%s: one record is larger than the file can hold; use a smaller study", file.path);
    default:
        return fail_damaged(file.path, sqlite3_errmsg(file.db));
    }
}

/* ------------------------------------------------------------ small pieces */

static ric_status run_sql(database file, const char *sql)
{
    int code = sqlite3_exec(file.db, sql, NULL, NULL, NULL);
    return code ? fail_sql(file, code) : RIC_OK;
}

static ric_status prepare(database file, const char *sql, sqlite3_stmt **out)
{
    int code = sqlite3_prepare_v2(file.db, sql, -1, out, NULL);
    return code ? fail_sql(file, code) : RIC_OK;
}

/* One row further; *row = false at the end, and then the query may run again. */
static ric_status step(database file, sqlite3_stmt *query, bool *row)
{
    int code = sqlite3_step(query);
    ric_status status = code == SQLITE_ROW || code == SQLITE_DONE ? RIC_OK : fail_sql(file, code);
    *row = code == SQLITE_ROW;
    if (!*row)
        sqlite3_reset(query);
    return status;
}

/* The number in a one-row answer, as a result code of SQLite. */
static int ask_integer(sqlite3 *db, const char *sql, sqlite3_int64 *out)
{
    sqlite3_stmt *query = NULL;
    int code = sqlite3_prepare_v2(db, sql, -1, &query, NULL);
    if (!code) {
        code = sqlite3_step(query);
        *out = code == SQLITE_ROW ? sqlite3_column_int64(query, 0) : 0;
        code = code == SQLITE_ROW || code == SQLITE_DONE ? SQLITE_OK : code;
    }
    sqlite3_finalize(query);
    return code;
}

static ric_status open_database(const char *path, int flags, int wait, database *out)
{
    *out = (database){NULL, path};
    int code = sqlite3_open_v2(path, &out->db, flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE, NULL);
    if (code) {
        sqlite3_close(out->db);
        out->db = NULL;
        return fail_sql(*out, code);
    }
    sqlite3_busy_timeout(out->db, wait);
    /* The file may come from anyone: nothing in its schema is run. */
    sqlite3_db_config(out->db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(out->db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_db_config(out->db, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, NULL);
    sqlite3_db_config(out->db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, NULL);
    return run_sql(*out, "PRAGMA cell_size_check = 1");
}

/* Little-endian float64 on any machine. */
static void put_float64(unsigned char *out, size_t n, const double *values)
{
    for (size_t i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        for (int k = 0; k < 8; k++)
            *out++ = (unsigned char)(bits >> 8 * k);
    }
}

static void take_float64(const unsigned char *in, size_t n, double *values)
{
    for (size_t i = 0; i < n; i++) {
        uint64_t bits = 0;
        for (int k = 0; k < 8; k++)
            bits |= (uint64_t)*in++ << 8 * k;
        memcpy(&values[i], &bits, sizeof bits);
    }
}

/* -------------------------------------------------------------------- lock */

/* The lock lies on a file beside the atlas, PATH-lock: closing any descriptor of the atlas itself would end the locks of SQLite.
 * The system releases it when the process ends, however it ends; a file left over by a kill locks nothing. */
static ric_status take_lock(ric_store *store)
{
    for (;;) {
        struct stat held, named;
        int lock = open(store->lock_path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (lock < 0)
            return ric_fail(RIC_E_IO, "%s: cannot write in its folder (%s); choose another file with -o", store->path, strerror(errno));
        if (flock(lock, LOCK_EX | LOCK_NB)) {
            int reason = errno;
            close(lock);
            if (reason == EINTR)
                continue;
            return reason == EWOULDBLOCK
                ? ric_fail(RIC_E_BUSY, "%s: in use by another run; wait for its end, or choose another file with -o", store->path)
                : ric_fail(RIC_E_IO, "%s: cannot be locked (%s); choose a file on another disk with -o", store->path, strerror(reason));
        }
        /* A run removes the file when it ends: what is locked here may no longer be what others find. */
        if (!fstat(lock, &held) && !stat(store->lock_path, &named) && held.st_ino == named.st_ino && held.st_dev == named.st_dev) {
            store->lock = lock;
            return RIC_OK;
        }
        close(lock);
    }
}

static void release_lock(ric_store *store)
{
    if (store->lock < 0)
        return;
    unlink(store->lock_path);
    close(store->lock);
    store->lock = -1;
}

/* ------------------------------------------------------------------ checks */

/* Whether there is a file with something in it; anything but a regular file is refused. */
static ric_status look(const char *path, bool *exists, bool *empty)
{
    struct stat found;
    *exists = *empty = false;
    if (stat(path, &found))
        return errno == ENOENT ? RIC_OK : ric_fail(RIC_E_IO, "%s: %s; choose another file", path, strerror(errno));
    if (!S_ISREG(found.st_mode))
        return ric_fail(RIC_E_IO, "%s: not a file but %s; choose another name", path, S_ISDIR(found.st_mode) ? "a folder" : "a device");
    *exists = true;
    *empty = found.st_size == 0;
    return RIC_OK;
}

/* An address that makes SQLite read the file as it lies there, without locks, journals or changes. */
static char *immutable_uri(const char *path)
{
    char *uri = malloc(3 * strlen(path) + sizeof "file:?immutable=1"), *out = uri;
    if (!uri)
        return NULL;
    out += sprintf(out, "file:");
    for (const char *c = path; *c; c++)
        out += strchr("?#%", *c) ? sprintf(out, "%%%02X", (unsigned)*c) : sprintf(out, "%c", *c);
    strcpy(out, "?immutable=1");
    return uri;
}

/* Only the identification numbers, so that a foreign file is left exactly as it is. Damage is left for the full check to find,
 * because what looks like it may be a transaction that opening the file will undo. */
static ric_status check_identity(const char *path)
{
    database file = {NULL, path};
    sqlite3_int64 application = 0, version = 0;
    ric_status status;
    char *uri = immutable_uri(path);
    if (!uri)
        return fail_memory();
    status = open_database(uri, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, 0, &file);
    file.path = path;
    if (status) {
        status = ric_fail(status, "%s: cannot be read; check its permissions", path);
        goto out;
    }
    int code = ask_integer(file.db, "PRAGMA application_id", &application);
    if (!code)
        code = ask_integer(file.db, "PRAGMA user_version", &version);
    if (code)
        status = (code & 0xff) == SQLITE_CORRUPT ? RIC_OK : fail_sql(file, code);
    else if (application != APPLICATION_ID)
        status = fail_foreign(path);
    else if (version > FORMAT_VERSION)
        status = ric_fail(RIC_E_FORMAT, "%s: atlas of format %lld, and ricochet %s knows formats up to %d; use a newer ricochet", path,
                          (long long)version, ric_version(), FORMAT_VERSION);
    else if (version < 1)
        status = fail_damaged(path, "its format has no number");
out:
    sqlite3_close(file.db);
    free(uri);
    return status;
}

/* FNV-1a with 64 bits (Fowler, Noll, Vo): finds damage, not forgery. */
static const uint64_t digest_start = 0xcbf29ce484222325u;

static uint64_t digest_bytes(uint64_t digest, const void *bytes, size_t n)
{
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < n; i++)
        digest = (digest ^ byte[i]) * 0x100000001b3u;
    return digest;
}

static uint64_t digest_column(uint64_t digest, sqlite3_stmt *row, int column)
{
    unsigned char type = (unsigned char)sqlite3_column_type(row, column);
    unsigned char bits[8] = {0};
    uint64_t integer = 0;
    const void *bytes = bits;
    size_t n = sizeof bits;
    if (type == SQLITE_FLOAT)
        put_float64(bits, 1, &(double){sqlite3_column_double(row, column)});
    else if (type == SQLITE_INTEGER)
        integer = (uint64_t)sqlite3_column_int64(row, column);
    else if (type != SQLITE_NULL) {
        bytes = sqlite3_column_blob(row, column);
        integer = n = (size_t)sqlite3_column_bytes(row, column);
    }
    digest = digest_bytes(digest, &type, 1);
    for (int k = 0; k < 8; k++)
        digest = digest_bytes(digest, &(unsigned char){(unsigned char)(integer >> 8 * k)}, 1);
    return digest_bytes(digest, bytes, n);
}

/* Over every value that a reader may rely on, derived columns included. */
static ric_status digest_contents(database file, uint64_t *digest)
{
    static const char *const queries[] = {
        "SELECT key, value FROM meta WHERE key <> 'digest' ORDER BY key",
        "SELECT " BRANCH_COLUMNS " FROM branch ORDER BY id",
        "SELECT " BRANCH_JUNCTION_COLUMNS " FROM branch_junction ORDER BY branch, position",
        "SELECT " POINT_COLUMNS " FROM point ORDER BY branch, point",
        "SELECT " JUNCTION_COLUMNS " FROM junction ORDER BY id",
        "SELECT " JUNCTION_BRANCH_COLUMNS " FROM junction_branch ORDER BY junction, branch",
    };
    *digest = digest_start;
    for (size_t i = 0; i < sizeof queries / sizeof *queries; i++) {
        sqlite3_stmt *query = NULL;
        bool row = true;
        ric_status status = prepare(file, queries[i], &query);
        while (!status && row) {
            status = step(file, query, &row);
            for (int k = 0; !status && row && k < sqlite3_column_count(query); k++)
                *digest = digest_column(*digest, query, k);
        }
        sqlite3_finalize(query);
        if (status)
            return status;
    }
    return RIC_OK;
}

/* *value = NULL when there is no such key. */
static ric_status get_meta(database file, const char *key, char **value)
{
    sqlite3_stmt *query = NULL;
    bool row = false;
    *value = NULL;
    ric_status status = prepare(file, "SELECT value FROM meta WHERE key = ?", &query);
    if (!status) {
        sqlite3_bind_text(query, 1, key, -1, SQLITE_STATIC);
        status = step(file, query, &row);
    }
    if (!status && row) {
        const char *text = (const char *)sqlite3_column_text(query, 0);
        *value = text ? strdup(text) : NULL;
        if (!*value)
            status = fail_memory();
    }
    sqlite3_finalize(query);
    return status;
}

static ric_status put_meta(database file, const char *key, const char *value)
{
    sqlite3_stmt *insert = NULL;
    bool row;
    ric_status status = prepare(file, "INSERT OR REPLACE INTO meta (key, value) VALUES (?, ?)", &insert);
    if (!status) {
        int code = sqlite3_bind_text(insert, 1, key, -1, SQLITE_STATIC) | sqlite3_bind_text(insert, 2, value, -1, SQLITE_STATIC);
        status = code ? fail_memory() : step(file, insert, &row);
    }
    sqlite3_finalize(insert);
    return status;
}

static ric_status put_digest(database file)
{
    uint64_t digest;
    char text[17];
    ric_status status = digest_contents(file, &digest);
    if (status)
        return status;
    snprintf(text, sizeof text, "%016llx", (unsigned long long)digest);
    return put_meta(file, "digest", text);
}

static ric_status check_digest(database file)
{
    uint64_t digest;
    char text[17], *stored = NULL;
    ric_status status = digest_contents(file, &digest);
    if (!status)
        status = get_meta(file, "digest", &stored);
    if (!status) {
        snprintf(text, sizeof text, "%016llx", (unsigned long long)digest);
        if (!stored || strcmp(stored, text))
            status = fail_damaged(file.path, "the contents do not match their digest");
    }
    free(stored);
    return status;
}

/* Structure, tables and contents, inside the reader's transaction. */
static ric_status check_contents(database file)
{
    sqlite3_stmt *query = NULL;
    sqlite3_int64 tables = 0;
    bool row = false;
    ric_status status = prepare(file, "PRAGMA quick_check(1)", &query);
    if (!status)
        status = step(file, query, &row);
    if (!status && row) {
        const char *answer = (const char *)sqlite3_column_text(query, 0);
        if (!answer || strcmp(answer, "ok"))
            status = fail_damaged(file.path, answer ? answer : "it cannot be checked");
    }
    sqlite3_finalize(query);
    if (status)
        return status;
    int code = ask_integer(file.db, "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND rootpage > 0 AND name IN "
                           "('meta', 'trace', 'branch', 'branch_junction', 'point', 'junction', 'junction_branch')", &tables);
    if (code)
        return fail_sql(file, code);
    return tables == 7 ? check_digest(file) : fail_damaged(file.path, "a table is missing");
}

/* ---------------------------------------------------------- model identity */

/* The model of a study: from the line `model:` to the next top-level key, as a copy; "" if there is none. NULL without memory. */
static char *model_text(const char *study)
{
    const char *begin = NULL, *line = study;
    while (line && *line) {
        const char *next = strchr(line, '\n');
        if (!begin && !strncmp(line, "model:", 6))
            begin = line;
        else if (begin && !strchr(" \t\r\n#-]}", *line))
            break;
        line = next ? next + 1 : line + strlen(line);
    }
    return begin ? strndup(begin, (size_t)(line - begin)) : strdup("");
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
    if (n_a == n_b && !memcmp(a, b, n_a))
        return true;
    double x = strtod(a, &end_a), y = strtod(b, &end_b);
    return n_a && n_b && end_a == a + n_a && end_b == b + n_b && x == y;
}

/* 9 and 9.0 are the same model. */
static ric_status compare_models(const char *path, const char *stored, const char *given)
{
    for (;;) {
        size_t n_a = next_token(&stored), n_b = next_token(&given);
        if (!same_token(stored, n_a, given, n_b))
            return ric_fail(RIC_E_CONFLICT, "%s: the atlas of another model (it has `%.*s` where the study has `%.*s`); "
                            "choose another file with -o", path, (int)(n_a > 40 ? 40 : n_a), stored, (int)(n_b > 40 ? 40 : n_b), given);
        if (!n_a)
            return RIC_OK;
        stored += n_a;
        given += n_b;
    }
}

static ric_status check_model(database file, const ric_study *study)
{
    char *stored = NULL, *given = NULL;
    ric_status status = get_meta(file, "model", &stored);
    if (status)
        goto out;
    given = model_text(ric_study_text(study));
    status = !given ? fail_memory() : !stored ? fail_damaged(file.path, "its model is missing") : compare_models(file.path, stored, given);
out:
    free(stored);
    free(given);
    return status;
}

/* --------------------------------------------------------------- rows, out */

/* Fills the values of one insert from left to right; the first error is kept. */
typedef struct {
    database file;
    sqlite3_stmt *insert;
    int column, code;
} row_writer;

static ric_status writer_start(row_writer *row, database file, const char *table, const char *columns)
{
    char sql[1024];
    size_t n = (size_t)snprintf(sql, sizeof sql, "INSERT INTO %s (%s) VALUES (?", table, columns);
    for (const char *c = columns; *c && n < sizeof sql - 4; c++)
        if (*c == ',')
            n += (size_t)sprintf(sql + n, ",?");
    strcpy(sql + n, ")");
    *row = (row_writer){.file = file};
    return prepare(file, sql, &row->insert);
}

static void put_integer(row_writer *row, sqlite3_int64 value)
{
    row->code |= sqlite3_bind_int64(row->insert, ++row->column, value);
}

/* SQLite has no NaN: it is NULL in the file. */
static void put_real(row_writer *row, double value)
{
    ++row->column;
    row->code |= isnan(value) ? sqlite3_bind_null(row->insert, row->column) : sqlite3_bind_double(row->insert, row->column, value);
}

/* For columns that are only read by others, who are spared infinities. */
static void put_finite(row_writer *row, double value)
{
    put_real(row, isfinite(value) ? value : NAN);
}

static void put_id(row_writer *row, int id)
{
    if (id)
        put_integer(row, id);
    else
        row->code |= sqlite3_bind_null(row->insert, ++row->column);
}

static void put_text(row_writer *row, const char *text)
{
    row->code |= sqlite3_bind_text(row->insert, ++row->column, text ? text : "", -1, SQLITE_TRANSIENT);
}

static void put_float64s(row_writer *row, size_t n, const double *values)
{
    unsigned char *blob = malloc(8 * n + 1);
    if (blob)
        put_float64(blob, n, values);
    row->code |= blob ? sqlite3_bind_blob64(row->insert, ++row->column, blob, 8 * n, free) : SQLITE_NOMEM;
}

static void put_word(row_writer *row, const ric_model *model, int n, const int *word)
{
    size_t size = 12 * (size_t)n + 1;
    char *text = calloc(size, 1);
    if (!text || (n > 0 && ric_word_format(model, n, word, size, text)))
        row->code |= SQLITE_NOMEM;
    else
        put_text(row, text);
    free(text);
}

static ric_status writer_row(row_writer *row)
{
    bool ignored;
    ric_status status = row->code ? fail_memory() : step(row->file, row->insert, &ignored);
    row->column = 0;
    return status;
}

static ric_status write_branch(row_writer *row, const ric_model *model, const ric_branch *branch)
{
    put_integer(row, branch->id);
    put_text(row, branch->label);
    put_integer(row, branch->impacts);
    put_word(row, model, branch->impacts, branch->word);
    put_integer(row, branch->symmetric);
    put_integer(row, branch->reversible);
    put_text(row, branch->mirror);
    put_real(row, branch->stable_fraction);
    put_integer(row, branch->n_point);
    put_real(row, branch->energy_min);
    put_real(row, branch->energy_max);
    put_real(row, branch->frequency_min);
    put_real(row, branch->frequency_max);
    put_id(row, branch->from);
    put_id(row, branch->to);
    put_text(row, ric_stop_text(branch->stop));
    put_text(row, branch->why);
    put_integer(row, branch->depth);
    put_integer(row, branch->mode);
    return writer_row(row);
}

/* log |2 sinh y| without overflow */
static double log_trace(double y)
{
    return fabs(y) + log(-expm1(-2 * fabs(y)));
}

static ric_status write_point(row_writer *row, int n_dof, const ric_branch *branch, int i, const double *at)
{
    ric_point point;
    size_t n_flight = branch->impacts > 0 ? (size_t)branch->impacts : 1;
    memcpy(&point, at, sizeof point);
    at += sizeof point / sizeof *at;
    put_integer(row, branch->id);
    put_integer(row, i);
    put_real(row, point.arclength);
    put_real(row, point.energy);
    put_real(row, point.frequency);
    put_real(row, point.trace);
    put_real(row, point.rotation);
    put_integer(row, point.stable);
    put_real(row, point.reach);
    put_real(row, point.approach);
    put_real(row, point.residual);
    put_float64s(row, 2 * (size_t)n_dof, at);
    put_float64s(row, n_flight, at + 2 * n_dof);
    put_finite(row, 2 * 3.14159265358979323846 / point.frequency);
    put_finite(row, 2 * sinh(point.trace));
    put_finite(row, log_trace(point.trace));
    return writer_row(row);
}

static ric_status write_junction(row_writer *row, const ric_model *model, const ric_junction *junction)
{
    const ric_departures *count = &junction->departures;
    put_integer(row, junction->id);
    put_text(row, ric_kind_text(junction->kind));
    put_text(row, junction->label);
    put_text(row, junction->name);
    put_integer(row, junction->impacts);
    put_word(row, model, junction->impacts, junction->word);
    put_integer(row, junction->grazings);
    put_integer(row, junction->multiple);
    put_integer(row, junction->rotation[0]);
    put_integer(row, junction->rotation[1]);
    put_integer(row, junction->a);
    put_integer(row, junction->b);
    put_real(row, junction->energy);
    put_real(row, junction->frequency);
    put_float64s(row, 2 * (size_t)ric_model_n_dof(model), junction->state);
    put_float64s(row, junction->impacts > 0 ? (size_t)junction->impacts : 1, junction->flights);
    put_integer(row, count->taken);
    put_integer(row, count->known);
    put_integer(row, count->inadmissible);
    put_integer(row, count->over_budget);
    put_integer(row, count->refused);
    put_text(row, junction->refusal);
    return writer_row(row);
}

static ric_status write_branches(database file, const ric_atlas *atlas)
{
    const ric_model *model = ric_atlas_model(atlas);
    int n_dof = ric_model_n_dof(model);
    row_writer branch = {0}, point = {0}, junction = {0};
    ric_status status = writer_start(&branch, file, "branch", BRANCH_COLUMNS);
    if (!status)
        status = writer_start(&point, file, "point", POINT_COLUMNS);
    if (!status)
        status = writer_start(&junction, file, "branch_junction", BRANCH_JUNCTION_COLUMNS);
    for (int k = 0; !status && k < atlas->n_branch; k++) {
        const ric_branch_record *record = &atlas->branches[k];
        status = write_branch(&branch, model, &record->row);
        for (int i = 0; !status && i < record->row.n_point; i++)
            status = write_point(&point, n_dof, &record->row, i, record->points + (size_t)i * record->stride);
        for (int i = 0; !status && i < record->row.n_junction; i++) {
            put_integer(&junction, record->row.id);
            put_integer(&junction, i);
            put_integer(&junction, record->row.junctions[i]);
            put_real(&junction, record->row.junction_at[i]);
            status = writer_row(&junction);
        }
    }
    sqlite3_finalize(branch.insert);
    sqlite3_finalize(point.insert);
    sqlite3_finalize(junction.insert);
    return status;
}

static ric_status write_junctions(database file, const ric_atlas *atlas)
{
    row_writer junction = {0}, branch = {0};
    ric_status status = writer_start(&junction, file, "junction", JUNCTION_COLUMNS);
    if (!status)
        status = writer_start(&branch, file, "junction_branch", JUNCTION_BRANCH_COLUMNS);
    for (int k = 0; !status && k < atlas->n_junction; k++) {
        const ric_junction *row = &atlas->junctions[k].row;
        status = write_junction(&junction, ric_atlas_model(atlas), row);
        for (int i = 0; !status && i < row->n_branch; i++) {
            put_integer(&branch, row->id);
            put_integer(&branch, row->branches[i]);
            status = writer_row(&branch);
        }
    }
    sqlite3_finalize(junction.insert);
    sqlite3_finalize(branch.insert);
    return status;
}

static ric_status write_meta(database file, const ric_study *study, bool finished)
{
    char text[64];
    char *model = model_text(ric_study_text(study));
    ric_status status = model ? put_meta(file, "study", ric_study_text(study)) : fail_memory();
    if (!status)
        status = put_meta(file, "model", model);
    if (!status)
        status = put_meta(file, "program", "ricochet " RIC_VERSION);
    snprintf(text, sizeof text, "%.17g", ric_study_options(study)->tolerance);
    if (!status)
        status = put_meta(file, "tolerance", text);
    snprintf(text, sizeof text, "%d", ric_model_n_dof(ric_study_model(study)));
    if (!status)
        status = put_meta(file, "n_dof", text);
    if (!status)
        status = put_meta(file, "finished", finished ? "1" : "0");
    free(model);
    return status;
}

/* ---------------------------------------------------------------- rows, in */

/* Takes the values of one row from left to right. A value of the wrong type, range or size makes the row `wrong`, once and for all. */
typedef struct {
    sqlite3_stmt *query;
    int column;
    bool wrong, no_memory;
} row_reader;

static int take_integer(row_reader *row, int min, int max)
{
    int column = row->column++;
    sqlite3_int64 value = sqlite3_column_int64(row->query, column);
    if (sqlite3_column_type(row->query, column) == SQLITE_INTEGER && value >= min && value <= max)
        return (int)value;
    row->wrong = true;
    return min;
}

static double take_real(row_reader *row)
{
    int column = row->column++, type = sqlite3_column_type(row->query, column);
    if (type == SQLITE_FLOAT)
        return sqlite3_column_double(row->query, column);
    row->wrong |= type != SQLITE_NULL;
    return NAN;
}

static int take_id(row_reader *row, int max)
{
    if (sqlite3_column_type(row->query, row->column) != SQLITE_NULL)
        return take_integer(row, 1, max);
    row->column++;
    return 0;
}

static char *take_text(row_reader *row)
{
    int column = row->column++;
    const char *text = sqlite3_column_type(row->query, column) == SQLITE_TEXT ? (const char *)sqlite3_column_text(row->query, column) : NULL;
    char *copy = strdup(text ? text : "");
    row->wrong |= !text;
    row->no_memory |= !copy;
    return copy;
}

/* One of the n texts of an enumeration. */
static int take_choice(row_reader *row, int n, const char *(*text_of)(int))
{
    char *text = take_text(row);
    int choice = 0;
    while (text && choice < n && strcmp(text, text_of(choice)))
        choice++;
    free(text);
    row->wrong |= choice == n;
    return choice;
}

static void take_float64s(row_reader *row, size_t n, double *values)
{
    int column = row->column++;
    const void *blob = sqlite3_column_type(row->query, column) == SQLITE_BLOB ? sqlite3_column_blob(row->query, column) : NULL;
    if (values && blob && (size_t)sqlite3_column_bytes(row->query, column) == 8 * n)
        take_float64(blob, n, values);
    else
        row->wrong = true;
}

static int letter_value(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'z' ? c - 'a' + 10 : INT_MAX;
}

/* The inverse of ric_word_format. False unless the text is exactly n faces of the model. */
static bool parse_word(const ric_model *model, const char *text, int n, int *word)
{
    int n_face = ric_model_n_face(model);
    for (int i = 0; i < n; i++) {
        if (n_face <= 36) {
            word[i] = letter_value(*text);
            text += *text != '\0';
        } else {
            char *end;
            if ((i > 0 && *text++ != '.') || *text < '0' || *text > '9')
                return false;
            long face = strtol(text, &end, 10);
            word[i] = face < n_face ? (int)face : INT_MAX;
            text = end;
        }
        if (word[i] >= n_face)
            return false;
    }
    return *text == '\0';
}

static int *take_word(row_reader *row, const ric_model *model, int n)
{
    char *text = take_text(row);
    int *word = NULL;
    if (text && strlen(text) >= (size_t)n)
        word = calloc((size_t)n + 1, sizeof *word);
    else
        row->wrong = true;
    if (word)
        row->wrong |= !parse_word(model, text, n, word);
    else
        row->no_memory |= !row->wrong;
    free(text);
    return word;
}

static ric_status reader_status(const row_reader *row, database file, const char *table)
{
    char what[64];
    if (row->no_memory)
        return fail_memory();
    if (!row->wrong)
        return RIC_OK;
    snprintf(what, sizeof what, "a row of table %s is inconsistent", table);
    return fail_damaged(file.path, what);
}

/* A table, or what one branch or junction owns of it; the queries then take its id. */
typedef struct {
    const char *table, *count, *rows;
} listing;

static const listing branches = {"branch", "SELECT count(*) FROM branch", "SELECT " BRANCH_COLUMNS " FROM branch ORDER BY id"};
static const listing junctions = {"junction", "SELECT count(*) FROM junction", "SELECT " JUNCTION_COLUMNS " FROM junction ORDER BY id"};
static const listing points_of_branch = {
    "point", "SELECT count(*) FROM point WHERE branch = ?", "SELECT " POINT_COLUMNS " FROM point WHERE branch = ? ORDER BY point"};
static const listing junctions_of_branch = {
    "branch_junction", "SELECT count(*) FROM branch_junction WHERE branch = ?",
    "SELECT " BRANCH_JUNCTION_COLUMNS " FROM branch_junction WHERE branch = ? ORDER BY position"};
static const listing branches_of_junction = {
    "junction_branch", "SELECT count(*) FROM junction_branch WHERE junction = ?",
    "SELECT " JUNCTION_BRANCH_COLUMNS " FROM junction_branch WHERE junction = ? ORDER BY branch"};

/* Owner 0 stands for the whole table. */
static ric_status prepare_listing(database file, const char *sql, int owner, sqlite3_stmt **query)
{
    ric_status status = prepare(file, sql, query);
    if (!status && owner)
        sqlite3_bind_int(*query, 1, owner);
    return status;
}

static ric_status count_rows(database file, const listing *list, int owner, int *n)
{
    sqlite3_stmt *query = NULL;
    bool row = false;
    ric_status status = prepare_listing(file, list->count, owner, &query);
    if (!status)
        status = step(file, query, &row);
    sqlite3_int64 count = !status && row ? sqlite3_column_int64(query, 0) : 0;
    sqlite3_finalize(query);
    *n = (int)(count <= INT_MAX ? count : 0);
    return count > INT_MAX ? fail_damaged(file.path, "a table has too many rows") : status;
}

/* Where the rows go to. */
typedef struct {
    ric_atlas *atlas;
    ric_branch_record *branch;
    ric_junction_record *junction;
} target;

/* Takes n rows, as many as were counted; a row is the i-th of its list. */
static ric_status take_rows(database file, const listing *list, int owner, int n, void (*take)(row_reader *, int i, target *), target *to)
{
    row_reader row = {0};
    bool more = true;
    ric_status status = prepare_listing(file, list->rows, owner, &row.query);
    for (int i = 0; !status && more; i++) {
        status = step(file, row.query, &more);
        row.column = 0;
        if (!status && more && i < n) {
            take(&row, i, to);
            status = reader_status(&row, file, list->table);
        }
    }
    sqlite3_finalize(row.query);
    return status;
}

static const char *stop_text(int stop)
{
    return ric_stop_text((ric_stop)stop);
}

static const char *kind_text(int kind)
{
    return ric_kind_text((ric_kind)kind);
}

static void take_branch(row_reader *row, int i, target *to)
{
    const ric_model *model = ric_atlas_model(to->atlas);
    ric_branch_record *record = &to->atlas->branches[i];
    ric_branch *branch = &record->row;
    branch->id = take_integer(row, i + 1, i + 1);
    branch->label = record->label = take_text(row);
    branch->impacts = take_integer(row, 0, INT_MAX / 2);
    branch->word = record->word = take_word(row, model, branch->impacts);
    branch->symmetric = take_integer(row, 0, 1);
    branch->reversible = take_integer(row, 0, 1);
    branch->mirror = record->mirror = take_text(row);
    branch->stable_fraction = take_real(row);
    branch->n_point = take_integer(row, 0, INT_MAX);
    branch->energy_min = take_real(row);
    branch->energy_max = take_real(row);
    branch->frequency_min = take_real(row);
    branch->frequency_max = take_real(row);
    branch->from = take_id(row, to->atlas->n_junction);
    branch->to = take_id(row, to->atlas->n_junction);
    branch->stop = (ric_stop)take_choice(row, RIC_STOP_FAILED + 1, stop_text);
    branch->why = record->why = take_text(row);
    branch->depth = take_integer(row, 0, INT_MAX);
    branch->mode = take_integer(row, 0, ric_model_n_dof(model));
    record->stride = ric_point_stride(ric_model_n_dof(model), branch->impacts);
}

static void take_point(row_reader *row, int i, target *to)
{
    const ric_branch *branch = &to->branch->row;
    size_t n_state = 2 * (size_t)ric_model_n_dof(ric_atlas_model(to->atlas));
    double *at = to->branch->points + (size_t)i * to->branch->stride;
    ric_point point;
    take_integer(row, branch->id, branch->id);
    take_integer(row, i, i);
    point.arclength = take_real(row);
    point.energy = take_real(row);
    point.frequency = take_real(row);
    point.trace = take_real(row);
    point.rotation = take_real(row);
    point.stable = take_integer(row, RIC_STABLE_NO, RIC_STABLE_UNDECIDED);
    point.reach = take_real(row);
    point.approach = take_real(row);
    point.residual = (float)take_real(row);
    memcpy(at, &point, sizeof point);
    at += sizeof point / sizeof *at;
    take_float64s(row, n_state, at);
    take_float64s(row, branch->impacts > 0 ? (size_t)branch->impacts : 1, at + n_state);
}

static void take_branch_junction(row_reader *row, int i, target *to)
{
    take_integer(row, to->branch->row.id, to->branch->row.id);
    take_integer(row, i, i);
    to->branch->junctions[i] = take_integer(row, 1, to->atlas->n_junction);
    to->branch->junction_at[i] = take_real(row);
}

static ric_status read_points(database file, target *to)
{
    ric_branch_record *record = to->branch;
    int n = 0;
    ric_status status = count_rows(file, &points_of_branch, record->row.id, &n);
    if (status)
        return status;
    if (n != record->row.n_point)
        return fail_damaged(file.path, "points of a branch are missing");
    record->points = calloc((size_t)n + 1, record->stride * sizeof *record->points);
    return record->points ? take_rows(file, &points_of_branch, record->row.id, n, take_point, to) : fail_memory();
}

static ric_status read_branch_junctions(database file, target *to)
{
    ric_branch_record *record = to->branch;
    int n = 0;
    ric_status status = count_rows(file, &junctions_of_branch, record->row.id, &n);
    if (status)
        return status;
    record->row.n_junction = n;
    record->row.junctions = record->junctions = calloc((size_t)n + 1, sizeof *record->junctions);
    record->row.junction_at = record->junction_at = calloc((size_t)n + 1, sizeof *record->junction_at);
    if (!record->junctions || !record->junction_at)
        return fail_memory();
    return take_rows(file, &junctions_of_branch, record->row.id, n, take_branch_junction, to);
}

static ric_status read_branches(database file, ric_atlas *atlas)
{
    target to = {.atlas = atlas};
    ric_status status = take_rows(file, &branches, 0, atlas->n_branch, take_branch, &to);
    for (int i = 0; !status && i < atlas->n_branch; i++) {
        to.branch = &atlas->branches[i];
        status = read_points(file, &to);
        if (!status)
            status = read_branch_junctions(file, &to);
    }
    return status;
}

static void take_junction(row_reader *row, int i, target *to)
{
    const ric_model *model = ric_atlas_model(to->atlas);
    ric_junction_record *record = &to->atlas->junctions[i];
    ric_junction *junction = &record->row;
    ric_departures *count = &junction->departures;
    size_t n_state = 2 * (size_t)ric_model_n_dof(model), n_flight;
    junction->id = take_integer(row, i + 1, i + 1);
    junction->kind = (ric_kind)take_choice(row, RIC_KIND_USER + 1, kind_text);
    junction->label = record->label = take_text(row);
    junction->name = record->name = take_text(row);
    junction->impacts = take_integer(row, 0, INT_MAX / 2);
    junction->word = record->word = take_word(row, model, junction->impacts);
    junction->grazings = take_integer(row, 0, INT_MAX);
    junction->multiple = take_integer(row, 1, INT_MAX);
    junction->rotation[0] = take_integer(row, INT_MIN, INT_MAX);
    junction->rotation[1] = take_integer(row, 0, INT_MAX);
    junction->a = take_integer(row, 0, INT_MAX);
    junction->b = take_integer(row, 0, INT_MAX);
    junction->energy = take_real(row);
    junction->frequency = take_real(row);
    n_flight = junction->impacts > 0 && !row->wrong ? (size_t)junction->impacts : 1;
    junction->state = record->state = calloc(n_state, sizeof *record->state);
    junction->flights = record->flights = calloc(n_flight, sizeof *record->flights);
    row->no_memory |= !record->state || !record->flights;
    take_float64s(row, n_state, record->state);
    take_float64s(row, n_flight, record->flights);
    count->taken = take_integer(row, 0, INT_MAX);
    count->known = take_integer(row, 0, INT_MAX);
    count->inadmissible = take_integer(row, 0, INT_MAX);
    count->over_budget = take_integer(row, 0, INT_MAX);
    count->refused = take_integer(row, 0, INT_MAX);
    junction->refusal = record->refusal = take_text(row);
}

static void take_junction_branch(row_reader *row, int i, target *to)
{
    take_integer(row, to->junction->row.id, to->junction->row.id);
    to->junction->branches[i] = take_integer(row, 1, to->atlas->n_branch);
}

static ric_status read_junction_branches(database file, target *to)
{
    ric_junction_record *record = to->junction;
    int n = 0;
    ric_status status = count_rows(file, &branches_of_junction, record->row.id, &n);
    if (status)
        return status;
    record->row.n_branch = n;
    record->row.branches = record->branches = calloc((size_t)n + 1, sizeof *record->branches);
    return record->branches ? take_rows(file, &branches_of_junction, record->row.id, n, take_junction_branch, to) : fail_memory();
}

static ric_status read_junctions(database file, ric_atlas *atlas)
{
    target to = {.atlas = atlas};
    ric_status status = take_rows(file, &junctions, 0, atlas->n_junction, take_junction, &to);
    for (int i = 0; !status && i < atlas->n_junction; i++) {
        to.junction = &atlas->junctions[i];
        status = read_junction_branches(file, &to);
    }
    return status;
}

/* Rows that no branch or junction owns. */
static ric_status check_orphans(database file)
{
    sqlite3_int64 n = 0;
    int code = ask_integer(file.db,
        "SELECT (SELECT count(*) FROM point WHERE branch NOT IN (SELECT id FROM branch))"
        " + (SELECT count(*) FROM branch_junction WHERE branch NOT IN (SELECT id FROM branch))"
        " + (SELECT count(*) FROM junction_branch WHERE junction NOT IN (SELECT id FROM junction))", &n);
    if (code)
        return fail_sql(file, code);
    return n ? fail_damaged(file.path, "rows belong to no branch or junction") : RIC_OK;
}

static ric_status read_study(database file, ric_atlas *atlas)
{
    char *study = NULL, *finished = NULL;
    ric_status status = get_meta(file, "study", &study);
    if (!status)
        status = get_meta(file, "finished", &finished);
    if (!status && (!study || !finished))
        status = fail_damaged(file.path, "its study is missing");
    if (status)
        goto out;
    atlas->finished = !strcmp(finished, "1");
    status = ric_study_parse(study, file.path, ".", &atlas->study);
    if (status && status != RIC_E_NOMEM)
        status = fail_damaged(file.path, "its study cannot be read");
out:
    free(study);
    free(finished);
    return status;
}

static ric_status read_atlas(database file, ric_atlas *atlas)
{
    int n_branch = 0, n_junction = 0;
    ric_status status = read_study(file, atlas);
    if (!status)
        status = count_rows(file, &branches, 0, &n_branch);
    if (!status)
        status = count_rows(file, &junctions, 0, &n_junction);
    if (status)
        return status;
    atlas->branches = calloc((size_t)n_branch + 1, sizeof *atlas->branches);
    atlas->junctions = calloc((size_t)n_junction + 1, sizeof *atlas->junctions);
    if (!atlas->branches || !atlas->junctions)
        return fail_memory();
    atlas->n_branch = n_branch;
    atlas->n_junction = n_junction;
    status = check_orphans(file);
    if (!status)
        status = read_branches(file, atlas);
    if (!status)
        status = read_junctions(file, atlas);
    return status;
}

/* Read-only, unless a killed run has left a transaction that has to be undone first. */
static ric_status open_reader(const char *path, database *file)
{
    static const char begin[] = "BEGIN; SELECT count(*) FROM sqlite_master";
    ric_status status = open_database(path, SQLITE_OPEN_READONLY, READER_WAIT, file);
    if (status)
        return status;
    int code = sqlite3_exec(file->db, begin, NULL, NULL, NULL);
    if (code == SQLITE_READONLY_ROLLBACK) {
        sqlite3_close(file->db);
        status = open_database(path, SQLITE_OPEN_READWRITE, READER_WAIT, file);
        if (status)
            return status;
        code = sqlite3_exec(file->db, begin, NULL, NULL, NULL);
    }
    return code ? fail_sql(*file, code) : RIC_OK;
}

ric_status ric_store_read(const char *path, ric_atlas **out)
{
    database file = {NULL, path};
    ric_atlas *atlas = NULL;
    bool exists, empty;
    ric_status status;
    *out = NULL;
    status = look(path, &exists, &empty);
    if (!status && !exists)
        status = ric_fail(RIC_E_IO, "%s: no such file; make an atlas with `ricochet run`", path);
    else if (!status && empty)
        status = ric_fail(RIC_E_FORMAT, "%s: the file is empty; make an atlas with `ricochet run`", path);
    if (!status)
        status = check_identity(path);
    if (!status)
        status = open_reader(path, &file);
    if (!status)
        status = check_contents(file);
    if (status)
        goto out;
    atlas = calloc(1, sizeof *atlas);
    status = atlas ? read_atlas(file, atlas) : fail_memory();
out:
    sqlite3_close(file.db);
    if (status)
        ric_atlas_free(atlas);
    else
        *out = atlas;
    return status;
}

/* ------------------------------------------------------------------- store */

static ric_status begin(database file)
{
    return sqlite3_get_autocommit(file.db) ? run_sql(file, "BEGIN IMMEDIATE") : RIC_OK;
}

static void roll_back(database file)
{
    if (!sqlite3_get_autocommit(file.db))
        sqlite3_exec(file.db, "ROLLBACK", NULL, NULL, NULL);
}

/* A transaction holds what it changes in memory until it commits, so that readers wait only for the commit itself.
 * Leaving the mode PERSIST removes a journal that a killed run has left without any effect. */
static ric_status set_up_writer(database file)
{
    return run_sql(file, "PRAGMA journal_mode = PERSIST; PRAGMA journal_mode = DELETE; PRAGMA synchronous = FULL; PRAGMA cache_spill = 0");
}

static ric_status create_file(ric_store *store, const ric_study *study, bool exists)
{
    char numbers[96];
    ric_status status = open_database(store->path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, WRITER_WAIT, &store->file);
    if (!status)
        status = set_up_writer(store->file);
    if (!status)
        status = begin(store->file);
    if (!status)
        status = run_sql(store->file, schema);
    snprintf(numbers, sizeof numbers, "PRAGMA application_id = %d; PRAGMA user_version = %d", APPLICATION_ID, FORMAT_VERSION);
    if (!status)
        status = run_sql(store->file, numbers);
    if (!status)
        status = write_meta(store->file, study, false);
    if (!status)
        status = put_digest(store->file);
    if (!status)
        status = run_sql(store->file, "COMMIT");
    if (status) {
        sqlite3_close(store->file.db);
        store->file.db = NULL;
        if (!exists)
            unlink(store->path);
    }
    return status;
}

static ric_status open_file(ric_store *store, const ric_study *study)
{
    ric_status status = check_identity(store->path);
    if (!status)
        status = open_database(store->path, SQLITE_OPEN_READWRITE, WRITER_WAIT, &store->file);
    if (!status)
        status = check_contents(store->file);
    if (!status)
        status = check_model(store->file, study);
    if (!status && sqlite3_db_readonly(store->file.db, "main"))
        status = fail_sql(store->file, SQLITE_READONLY);
    if (!status)
        status = set_up_writer(store->file);
    return status;
}

ric_status ric_store_open(const char *path, const ric_study *study, ric_store **out)
{
    ric_store *store = calloc(1, sizeof *store);
    bool exists, empty;
    ric_status status = RIC_OK;
    *out = NULL;
    if (!store)
        return fail_memory();
    store->lock = -1;
    store->path = realpath(path, NULL);
    if (!store->path)
        store->path = strdup(path);
    store->lock_path = store->path ? malloc(strlen(store->path) + sizeof "-lock") : NULL;
    if (!store->lock_path) {
        status = fail_memory();
        goto out;
    }
    sprintf(store->lock_path, "%s-lock", store->path);
    status = look(store->path, &exists, &empty);
    if (!status)
        status = take_lock(store);
    if (!status)
        status = look(store->path, &exists, &empty); /* again, now that nobody else creates it */
    if (!status)
        status = exists && !empty ? open_file(store, study) : create_file(store, study, exists);
    if (!status)
        status = prepare(store->file, "SELECT blob, digest FROM trace WHERE key = ?", &store->get);
    if (!status)
        status = prepare(store->file, "INSERT OR REPLACE INTO trace (key, blob, digest) VALUES (?, ?, ?)", &store->put);
out:
    if (status)
        ric_store_close(store);
    else
        *out = store;
    return status;
}

void ric_store_close(ric_store *store)
{
    if (!store)
        return;
    sqlite3_finalize(store->get);
    sqlite3_finalize(store->put);
    /* What was put is worth keeping; if the disk refuses, the last commit still stands. */
    if (store->file.db && !sqlite3_get_autocommit(store->file.db) && sqlite3_exec(store->file.db, "COMMIT", NULL, NULL, NULL))
        roll_back(store->file);
    sqlite3_close(store->file.db);
    release_lock(store);
    free(store->path);
    free(store->lock_path);
    free(store);
}

ric_status ric_store_trace_get(ric_store *store, const char *key, void **blob, size_t *size)
{
    bool row = false;
    *blob = NULL;
    *size = 0;
    sqlite3_bind_text(store->get, 1, key, -1, SQLITE_STATIC);
    ric_status status = step(store->file, store->get, &row);
    if (!status && row) {
        size_t n = (size_t)sqlite3_column_bytes(store->get, 0);
        const void *bytes = sqlite3_column_blob(store->get, 0);
        if (sqlite3_column_int64(store->get, 1) != (sqlite3_int64)digest_bytes(digest_start, bytes, n))
            status = fail_damaged(store->path, "finished work does not match its digest");
        else if (!(*blob = malloc(n + 1)))
            status = fail_memory();
        else if (n)
            memcpy(*blob, bytes, n);
        *size = status ? 0 : n;
    }
    sqlite3_reset(store->get);
    sqlite3_clear_bindings(store->get);
    return status;
}

ric_status ric_store_trace_put(ric_store *store, const char *key, const void *blob, size_t size)
{
    bool row;
    ric_status status = begin(store->file);
    if (status)
        return status;
    sqlite3_bind_text(store->put, 1, key, -1, SQLITE_STATIC);
    int code = size ? sqlite3_bind_blob64(store->put, 2, blob, size, SQLITE_STATIC) : sqlite3_bind_zeroblob(store->put, 2, 0);
    sqlite3_bind_int64(store->put, 3, (sqlite3_int64)digest_bytes(digest_start, blob, size));
    status = code ? fail_sql(store->file, code) : step(store->file, store->put, &row);
    sqlite3_clear_bindings(store->put);
    return status;
}

ric_status ric_store_commit(ric_store *store)
{
    return sqlite3_get_autocommit(store->file.db) ? RIC_OK : run_sql(store->file, "COMMIT");
}

ric_status ric_store_write(ric_store *store, const ric_atlas *atlas)
{
    database file = store->file;
    ric_status status = ric_store_commit(store); /* the work itself is kept even if the tables cannot be written */
    if (!status)
        status = begin(file);
    if (!status)
        status = run_sql(file, "DELETE FROM point; DELETE FROM branch_junction; DELETE FROM junction_branch; "
                         "DELETE FROM branch; DELETE FROM junction");
    if (!status)
        status = write_branches(file, atlas);
    if (!status)
        status = write_junctions(file, atlas);
    if (!status)
        status = write_meta(file, atlas->study, atlas->finished);
    if (!status)
        status = put_digest(file);
    if (!status)
        status = run_sql(file, "COMMIT");
    if (status)
        roll_back(file);
    return status;
}
