/* What the store asks of SQLite, and the errors it answers with. */
#include "store_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* ------------------------------------------------------------------ errors */

ric_status ric_store_fail_memory(void)
{
    return ric_fail(RIC_E_NOMEM, "out of memory");
}

ric_status ric_store_fail_damaged(const char *path, const char *what)
{
    return ric_fail(
        RIC_E_FORMAT,
        "%s: damaged atlas (%s); restore it from a copy, or remove it and run the study again",
        path, what);
}

ric_status ric_store_fail_row(const char *path, const char *table, const char *key,
                              const char *what)
{
    char all[240];
    snprintf(all, sizeof all, "table %s, row %.100s: %s", table, key ? key : "without a key", what);
    return ric_store_fail_damaged(path, all);
}

ric_status ric_store_fail_foreign(const char *path)
{
    return ric_fail(
        RIC_E_FORMAT,
        "%s: not an atlas; name a file made by `ricochet run`, or another file for a new atlas",
        path);
}

ric_status ric_store_sqlite_fail(ric_database file, int code)
{
    switch (code == SQLITE_IOERR_NOMEM ? SQLITE_NOMEM : code & 0xff) {
    case SQLITE_NOMEM: return ric_store_fail_memory();
    case SQLITE_NOTADB: return ric_store_fail_foreign(file.path);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return ric_fail(RIC_E_BUSY,
                        "%s: another program keeps the atlas locked; close it and try again",
                        file.path);
    case SQLITE_FULL:
        return ric_fail(
            RIC_E_IO,
            "%s: disk full; make room and give the same command again, what was done is kept",
            file.path);
    case SQLITE_READONLY:
        return code == SQLITE_READONLY_ROLLBACK
                   ? ric_fail(RIC_E_IO,
                              "%s: a run was killed while it wrote, and the atlas is read-only; "
                              "copy it together with "
                              "the file ending in -journal to a folder that can be written",
                              file.path)
                   : ric_fail(
                         RIC_E_IO,
                         "%s: cannot be written; check its permissions and those of its folder",
                         file.path);
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
    case SQLITE_AUTH:
        return ric_fail(
            RIC_E_IO,
            "%s: cannot be opened; check that its folder exists, and the permissions of both",
            file.path);
    case SQLITE_IOERR:
        return ric_fail(RIC_E_IO,
                        "%s: cannot be read or written (%s); check the disk, and the largest size "
                        "of a file (ulimit -f)",
                        file.path, sqlite3_errstr(code));
    case SQLITE_TOOBIG:
        return ric_fail(RIC_E_RANGE,
                        "%s: one record is larger than the file can hold; use a smaller study",
                        file.path);
    default: return ric_store_fail_damaged(file.path, sqlite3_errmsg(file.db));
    }
}

/* ------------------------------------------------------------ small pieces */

ric_status ric_store_sqlite_run(ric_database file, const char *sql)
{
    int code = sqlite3_exec(file.db, sql, NULL, NULL, NULL);
    return code ? ric_store_sqlite_fail(file, code) : RIC_OK;
}

ric_status ric_store_sqlite_prepare(ric_database file, const char *sql, sqlite3_stmt **out)
{
    int code = sqlite3_prepare_v2(file.db, sql, -1, out, NULL);
    return code ? ric_store_sqlite_fail(file, code) : RIC_OK;
}

const ric_column *ric_store_next_column(const ric_table *table, const ric_column *before, bool all)
{
    const ric_column *end = table->column + table->n, *c = before ? before + 1 : table->column;
    bool derived = before && before->type == RIC_COLUMN_DERIVED;
    for (;; c = table->column, derived = true) {
        for (; c < end; c++)
            if (!(c->flags & RIC_NOT_STORED) && (c->type == RIC_COLUMN_DERIVED) == derived)
                return c;
        if (derived || !all) return NULL;
    }
}

static void write_names(const ric_table *table, FILE *out)
{
    const char *between = "";
    for (const ric_column *c = NULL; (c = ric_store_next_column(table, c, true)); between = ", ")
        fprintf(out, "%s%s", between, c->name);
}

static void write_schema(const ric_table *table, FILE *out)
{
    const char *between = "";
    fprintf(out, "CREATE TABLE %s (", table->name);
    for (const ric_column *c = table->column; c < table->column + table->n; c++)
        if (!(c->flags & RIC_NOT_STORED)) {
            fprintf(out, "%s%s%s", between, c->name, ric_column_declaration(c));
            between = ", ";
        }
    if (table->column->type == RIC_COLUMN_ID) fputs(")", out);
    else fprintf(out, ", PRIMARY KEY (%s)) WITHOUT ROWID", table->key);
}

static void write_insert(const ric_table *table, FILE *out)
{
    fprintf(out, "INSERT INTO %s (", table->name);
    write_names(table, out);
    fputs(") VALUES (?", out);
    for (const ric_column *c = ric_store_next_column(table, NULL, true);
         (c = ric_store_next_column(table, c, true));)
        fputs(",?", out);
    fputs(")", out);
}

ric_status ric_store_sqlite_table(ric_database file, const ric_table *table, ric_sql what,
                                  sqlite3_stmt **out)
{
    const char *owner = table->column->name;
    ric_buffer sql;
    *out = NULL;
    if (!ric_buffer_open(&sql)) return ric_store_fail_memory();
    if (what == RIC_SQL_CREATE) write_schema(table, sql.file);
    else if (what == RIC_SQL_INSERT) write_insert(table, sql.file);
    else if (what == RIC_SQL_SELECT) {
        fputs("SELECT ", sql.file);
        write_names(table, sql.file);
        fprintf(sql.file, " FROM %s ORDER BY %s", table->name, table->key);
    } else fprintf(sql.file, "SELECT %s, count(*) FROM %s GROUP BY %s", owner, table->name, owner);
    char *text = ric_buffer_take(&sql);
    ric_status status = text ? ric_store_sqlite_prepare(file, text, out) : ric_store_fail_memory();
    free(text);
    return status;
}

ric_status ric_store_sqlite_step(ric_database file, sqlite3_stmt *query, bool *row)
{
    int code = sqlite3_step(query);
    ric_status status = code == SQLITE_ROW || code == SQLITE_DONE
                            ? RIC_OK
                            : ric_store_sqlite_fail(file, code);
    *row = code == SQLITE_ROW;
    if (!*row) sqlite3_reset(query);
    return status;
}

double ric_store_sqlite_number(sqlite3_stmt *row, int column)
{
    return sqlite3_column_type(row, column) == SQLITE_NULL ? NAN
                                                           : sqlite3_column_double(row, column);
}

int ric_store_sqlite_bind_number(sqlite3_stmt *query, int column, double value)
{
    return isnan(value) ? sqlite3_bind_null(query, column)
                        : sqlite3_bind_double(query, column, value);
}

int ric_store_sqlite_ask(sqlite3 *db, const char *sql, sqlite3_int64 *out)
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

ric_status ric_store_sqlite_prepare_there(ric_database file, const char *table, const char *sql,
                                          sqlite3_stmt **out)
{
    char there[120];
    sqlite3_int64 tables = 0;
    *out = NULL;
    snprintf(there, sizeof there,
             "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = '%s'", table);
    const int code = ric_store_sqlite_ask(file.db, there, &tables);
    if (code) return ric_store_sqlite_fail(file, code);
    return tables ? ric_store_sqlite_prepare(file, sql, out) : RIC_OK;
}

ric_status ric_store_sqlite_open(const char *path, int flags, int wait, ric_database *out)
{
    *out = (ric_database){NULL, path};
    int code = sqlite3_open_v2(path, &out->db, flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE,
                               NULL);
    if (code) {
        sqlite3_close(out->db);
        out->db = NULL;
        return ric_store_sqlite_fail(*out, code);
    }
    sqlite3_busy_timeout(out->db, wait);
    /* The file may come from anyone: nothing in its schema is run. */
    sqlite3_db_config(out->db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(out->db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_db_config(out->db, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, NULL);
    sqlite3_db_config(out->db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, NULL);
    return ric_store_sqlite_run(*out, "PRAGMA cell_size_check = 1");
}

/* An address that makes SQLite read the file as it lies there, without locks, journals or changes.
 */
static char *immutable_uri(const char *path)
{
    char *uri = ric_malloc(3 * strlen(path) + sizeof "file:?immutable=1"), *out = uri;
    if (!uri) return NULL;
    out += sprintf(out, "file:");
    for (const char *c = path; *c; c++)
        out += strchr("?#%", *c) ? sprintf(out, "%%%02X", (unsigned)*c) : sprintf(out, "%c", *c);
    strcpy(out, "?immutable=1");
    return uri;
}

ric_status ric_store_sqlite_open_still(const char *path, ric_database *out)
{
    char *uri = immutable_uri(path);
    *out = (ric_database){NULL, path};
    if (!uri) return ric_store_fail_memory();
    ric_status status = ric_store_sqlite_open(uri, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, 0, out);
    out->path = path;
    free(uri);
    return status;
}

void ric_store_put_float64(unsigned char *out, size_t n, const double *values)
{
    for (size_t i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        for (int k = 0; k < 8; k++) *out++ = (unsigned char)(bits >> 8 * k);
    }
}

void ric_store_take_float64(const unsigned char *in, size_t n, double *values)
{
    for (size_t i = 0; i < n; i++) {
        uint64_t bits = 0;
        for (int k = 0; k < 8; k++) bits |= (uint64_t)*in++ << 8 * k;
        memcpy(&values[i], &bits, sizeof bits);
    }
}
