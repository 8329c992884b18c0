/* The atlas file of a run: opened under a lock, continued, committed, closed. */
#include "store_parts.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/room.h"

enum {
    WRITER_WAIT = 60000, /* ms that a run waits for readers */
    /* the path begins with a slash; what is attached to it is named by an address */
    WRITER_FLAGS = SQLITE_OPEN_READWRITE | SQLITE_OPEN_URI
};

static const char schema[] = "CREATE TABLE meta (key TEXT PRIMARY KEY NOT NULL, value TEXT NOT "
                             "NULL) WITHOUT ROWID;CREATE TABLE trace (key TEXT "
                             "PRIMARY KEY NOT NULL, blob BLOB NOT NULL, digest INTEGER NOT NULL)";

struct ric_store {
    ric_database file;
    ric_store_stage stage;
    ric_store_later *later; /* that keeps work, NULL: it is kept at once */
    ric_store_names names;
    char *path, *lock_path;
    int lock; /* descriptor that holds the lock, -1 = none */
    sqlite3_stmt *get, *put, *drop;
    bool sound;  /* nothing has been found that is damaged */
    bool writes; /* the file has been set up for it */
};

/* ------------------------------------------------------------------- store */

static void roll_back(ric_database file)
{
    if (!sqlite3_get_autocommit(file.db)) sqlite3_exec(file.db, "ROLLBACK", NULL, NULL, NULL);
}

/* A transaction holds what it changes in memory until it commits, so that readers wait only for the
 * commit itself. Leaving the mode PERSIST removes a journal that a killed run has left without any
 * effect. */
static ric_status set_up_writer(ric_database file)
{
    return ric_store_sqlite_run(file,
                                "PRAGMA journal_mode = PERSIST; PRAGMA journal_mode = DELETE; "
                                "PRAGMA synchronous = FULL; PRAGMA cache_spill = 0");
}

/* Until something is to be written the file is only read: the mode of its journal is part of it. */
static ric_status begin(ric_store *store)
{
    ric_status status = store->writes ? RIC_OK : set_up_writer(store->file);
    if (status) return status;
    store->writes = true;
    return sqlite3_get_autocommit(store->file.db)
               ? ric_store_sqlite_run(store->file, "BEGIN IMMEDIATE")
               : RIC_OK;
}

ric_status ric_store_fill(ric_store *store, const char *create, const char *insert,
                          ric_database *file, sqlite3_stmt **query)
{
    *file = store->file;
    ric_status status = begin(store);
    if (!status) status = ric_store_sqlite_run(*file, create);
    return status ? status : ric_store_sqlite_prepare(*file, insert, query);
}

/* An empty file of ours, which SQLite then fills: what another has just laid there is neither
 * filled nor removed. */
static ric_status lay_file(const char *path)
{
    int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                    0644); /* as SQLite makes its files */
    if (file < 0)
        return ric_fail(RIC_E_IO, "%s: cannot be made (%s); choose another file with -o", path,
                        strerror(errno));
    close(file);
    return RIC_OK;
}

static ric_status create_tables(ric_database file)
{
    static const ric_table *const tables[] = {&ric_table_branch, &ric_table_branch_junction,
                                              &ric_table_point, &ric_table_junction,
                                              &ric_table_junction_branch};
    ric_status status = ric_store_sqlite_run(file, schema);
    for (size_t i = 0; !status && i < sizeof tables / sizeof *tables; i++) {
        sqlite3_stmt *create;
        bool row;
        status = ric_store_sqlite_table(file, tables[i], RIC_SQL_CREATE, &create);
        if (!status) status = ric_store_sqlite_step(file, create, &row);
        sqlite3_finalize(create);
    }
    return status;
}

static ric_status create_file(ric_store *store, const ric_study *study, bool exists)
{
    char numbers[96];
    ric_status status = exists ? RIC_OK : lay_file(store->path);
    if (status) return status;
    status = ric_store_sqlite_open(store->path, WRITER_FLAGS, WRITER_WAIT, &store->file);
    if (!status) status = begin(store);
    if (!status) status = create_tables(store->file);
    snprintf(numbers, sizeof numbers, "PRAGMA application_id = %d; PRAGMA user_version = %d",
             RIC_APPLICATION_ID, RIC_FORMAT_VERSION);
    if (!status) status = ric_store_sqlite_run(store->file, numbers);
    if (!status) status = ric_store_put_study(store->file, study, false, 0, 0);
    if (!status) status = ric_store_put_digest(store->file);
    if (!status) status = ric_store_sqlite_run(store->file, "COMMIT");
    store->names.whole = !status;
    if (status) {
        sqlite3_close(store->file.db);
        store->file.db = NULL;
        if (!exists) unlink(store->path);
    }
    return status;
}

/* All that the file holds, before anything is written to it: what a run finds out later it finds
 * out in between. */
static ric_status check_whole(ric_database file, const ric_study *study)
{
    ric_atlas *before = NULL;
    ric_status status = ric_store_check_contents(file);
    if (!status) status = ric_store_check_model(file, study);
    if (!status) status = ric_store_read_tables(file, &before);
    if (!status) status = ric_store_check_work(file);
    ric_atlas_free(before);
    return status;
}

static ric_status open_file(ric_store *store, const ric_study *study)
{
    ric_status status = ric_store_check_identity(store->path);
    if (!status)
        status = ric_store_sqlite_open(store->path, WRITER_FLAGS, WRITER_WAIT, &store->file);
    if (!status) status = check_whole(store->file, study);
    if (!status && sqlite3_db_readonly(store->file.db, "main"))
        status = ric_store_sqlite_fail(store->file, SQLITE_READONLY);
    return status;
}

/* A power failure can leave a journal that takes the file back to the state before it was made,
 * which is no atlas but an empty file. */
static ric_status recover(ric_store *store, bool *exists, bool *empty)
{
    ric_database file = {0};
    char journal[strlen(store->path) + sizeof "-journal"];
    sprintf(journal, "%s-journal", store->path);
    /* what is wrong is said later */
    if (*empty || access(journal, F_OK) || ric_store_check_identity(store->path)) return RIC_OK;
    ric_status status = ric_store_sqlite_open(store->path, SQLITE_OPEN_READWRITE, WRITER_WAIT,
                                              &file);
    if (!status) status = ric_store_sqlite_run(file, "SELECT count(*) FROM sqlite_master");
    sqlite3_close(file.db);
    return status ? status : ric_store_look(store->path, exists, empty);
}

static ric_status add_name(void *user, const char *key)
{
    ric_store_names_add(&((ric_store *)user)->names, key);
    return RIC_OK;
}

static ric_status list_names(ric_store *store)
{
    store->names.whole = true;
    return ric_store_trace_keys(store, "", add_name, store);
}

ric_status ric_store_open(const char *path, const ric_study *study, ric_store **out)
{
    ric_store *store = ric_calloc(1, sizeof *store);
    bool exists, empty;
    ric_status status = RIC_OK;
    *out = NULL;
    if (!store) return ric_store_fail_memory();
    store->lock = -1;
    store->path = ric_store_resolve(path);
    store->lock_path = store->path ? ric_malloc(strlen(store->path) + sizeof "-lock") : NULL;
    if (!store->lock_path) {
        status = ric_store_fail_memory();
        goto out;
    }
    sprintf(store->lock_path, "%s-lock", store->path);
    status = ric_store_look(store->path, &exists, &empty);
    if (!status) status = ric_store_lock_take(store->path, store->lock_path, &store->lock);
    if (!status) status = ric_store_check_beside(store->path);
    if (!status)
        status = ric_store_look(store->path, &exists,
                                &empty); /* again, now that nobody else creates it */
    if (!status && exists) status = recover(store, &exists, &empty);
    if (!status)
        status = exists && !empty ? open_file(store, study) : create_file(store, study, exists);
    if (!status)
        status = ric_store_sqlite_prepare(store->file,
                                          "SELECT blob, digest FROM trace WHERE key = ?",
                                          &store->get);
    if (!status)
        status = ric_store_sqlite_prepare(
            store->file, "INSERT OR REPLACE INTO trace (key, blob, digest) VALUES (?, ?, ?)",
            &store->put);
    if (!status)
        status = ric_store_sqlite_prepare(store->file, "DELETE FROM trace WHERE key = ?",
                                          &store->drop);
out:
    if (!status && !store->names.whole) status = list_names(store);
    store->sound = !status;
    if (status) ric_store_close(store);
    else *out = store;
    return status;
}

void ric_store_close(ric_store *store)
{
    if (!store) return;
    ric_store_rejoin(store);
    sqlite3_finalize(store->get);
    sqlite3_finalize(store->put);
    sqlite3_finalize(store->drop);
    if (store->sound && !store->writes)
        set_up_writer(store->file); /* no journal without effect stays behind */
    /* What was put is worth keeping; if the disk refuses, the last commit still stands. */
    if (store->file.db && !sqlite3_get_autocommit(store->file.db) &&
        sqlite3_exec(store->file.db, "COMMIT", NULL, NULL, NULL))
        roll_back(store->file);
    ric_store_stage_drop(store);
    sqlite3_close(store->file.db);
    ric_store_lock_release(store->lock_path, &store->lock);
    free(store->names.slots);
    free(store->path);
    free(store->lock_path);
    free(store);
}

/* All that is put aside has come to the file. */
static ric_status caught_up(ric_store *store)
{
    return store->later ? ric_store_later_wait(store->later) : RIC_OK;
}

ric_status ric_store_trace_get(ric_store *store, const char *key, void **blob, size_t *size)
{
    bool row = false;
    *blob = NULL;
    *size = 0;
    if (ric_store_names_lack(&store->names, key)) return RIC_OK;
    ric_status status = caught_up(store);
    if (status) return status;
    sqlite3_bind_text(store->get, 1, key, -1, SQLITE_STATIC);
    status = ric_store_sqlite_step(store->file, store->get, &row);
    if (!status && row) {
        size_t n = (size_t)sqlite3_column_bytes(store->get, 0);
        const void *bytes = sqlite3_column_blob(store->get, 0);
        if (sqlite3_column_int64(store->get, 1) !=
            (sqlite3_int64)ric_bytes_hash(RIC_BYTES_HASH, bytes, n))
            status = ric_store_fail_row(store->path, "trace", key,
                                        "the bytes do not match their digest");
        else if (!(*blob = ric_malloc(n + 1))) status = ric_store_fail_memory();
        else if (n) memcpy(*blob, bytes, n);
        *size = status ? 0 : n;
    }
    sqlite3_reset(store->get);
    sqlite3_clear_bindings(store->get);
    return status;
}

static ric_status put_now(ric_store *store, const ric_store_task *task)
{
    bool row;
    ric_status status = begin(store);
    if (status) return status;
    sqlite3_bind_text(store->put, 1, task->key, -1, SQLITE_STATIC);
    int code = task->size
                   ? sqlite3_bind_blob64(store->put, 2, task->blob, task->size, SQLITE_STATIC)
                   : sqlite3_bind_zeroblob(store->put, 2, 0);
    sqlite3_bind_int64(store->put, 3,
                       (sqlite3_int64)ric_bytes_hash(RIC_BYTES_HASH, task->blob, task->size));
    status = code ? ric_store_sqlite_fail(store->file, code)
                  : ric_store_sqlite_step(store->file, store->put, &row);
    sqlite3_clear_bindings(store->put);
    return status;
}

ric_status ric_store_trace_keys(ric_store *store, const char *ending,
                                ric_status (*each)(void *user, const char *key), void *user)
{
    sqlite3_stmt *query = NULL;
    bool row = false;
    ric_status status = caught_up(store);
    if (!status)
        status = ric_store_sqlite_prepare(store->file,
                                          "SELECT key FROM trace WHERE key LIKE '%' || ?", &query);
    if (status) return status;
    sqlite3_bind_text(query, 1, ending, -1, SQLITE_STATIC);
    while (!(status = ric_store_sqlite_step(store->file, query, &row)) && row)
        if ((status = each(user, (const char *)sqlite3_column_text(query, 0)))) break;
    sqlite3_finalize(query);
    return status;
}

static ric_status drop_now(ric_store *store, const char *key)
{
    bool row;
    ric_status status = begin(store);
    if (status) return status;
    sqlite3_bind_text(store->drop, 1, key, -1, SQLITE_STATIC);
    status = ric_store_sqlite_step(store->file, store->drop, &row);
    sqlite3_clear_bindings(store->drop);
    return status;
}

static ric_status apply(void *user, const ric_store_task *task)
{
    ric_store *store = user;
    switch (task->act) {
    case RIC_STORE_PUT: return put_now(store, task);
    case RIC_STORE_DROP: return drop_now(store, task->key);
    case RIC_STORE_COMMIT: break;
    }
    return sqlite3_get_autocommit(store->file.db) ? RIC_OK
                                                  : ric_store_sqlite_run(store->file, "COMMIT");
}

static ric_status act(ric_store *store, ric_store_task task)
{
    return store->later ? ric_store_later_add(store->later, &task) : apply(store, &task);
}

ric_status ric_store_trace_put(ric_store *store, const char *key, const void *blob, size_t size)
{
    ric_store_names_add(&store->names, key);
    return act(store, (ric_store_task){RIC_STORE_PUT, key, blob, size});
}

ric_status ric_store_trace_drop(ric_store *store, const char *key)
{
    if (ric_store_names_lack(&store->names, key)) return RIC_OK;
    return act(store, (ric_store_task){.act = RIC_STORE_DROP, .key = key});
}

ric_status ric_store_commit(ric_store *store)
{
    return act(store, (ric_store_task){.act = RIC_STORE_COMMIT, .key = ""});
}

void ric_store_aside(ric_store *store)
{
    if (!store->later) store->later = ric_store_later_begin(apply, store);
}

ric_status ric_store_rejoin(ric_store *store)
{
    ric_status status = ric_store_later_end(store->later);
    store->later = NULL;
    return status;
}

ric_status ric_store_starts_get(ric_store *store, char **text)
{
    return ric_store_get_meta(store->file, "starts", text);
}

/* Those of the tables, of a file that does not keep them yet. */
static ric_status labels_of_tables(ric_database file, char **text)
{
    ric_atlas *atlas = NULL;
    ric_buffer out;
    ric_status status = ric_store_read_tables(file, &atlas);
    if (!status && !ric_buffer_open(&out)) status = ric_store_fail_memory();
    if (!status) {
        for (int i = 0; i < atlas->n_junction; i++)
            fprintf(out.file, "%s %s\n", atlas->junctions[i].row.key,
                    atlas->junctions[i].row.label);
        if (!(*text = ric_buffer_take(&out))) status = ric_store_fail_memory();
    }
    ric_atlas_free(atlas);
    return status;
}

ric_status ric_store_labels_get(ric_store *store, char **text)
{
    char *finished = NULL;
    ric_status status = ric_store_get_meta(store->file, "labels", text);
    if (!status && !*text) status = ric_store_get_meta(store->file, "finished", &finished);
    if (!status && finished && !strcmp(finished, "1")) status = labels_of_tables(store->file, text);
    free(finished);
    return status;
}

/* The end of a transaction that changed the tables: all of it, with the digest that goes with them,
 * if it is known, or nothing. */
static ric_status conclude(ric_database file, ric_status status, const uint64_t *digest)
{
    if (!status) status = digest ? ric_store_set_digest(file, *digest) : ric_store_put_digest(file);
    if (!status) status = ric_store_sqlite_run(file, "COMMIT");
    if (status) roll_back(file);
    return status;
}

ric_status ric_store_refuse(ric_store *store, const char *table, const char *key, const char *what)
{
    store->sound = false;
    return ric_store_fail_row(store->path, table, key, what);
}

ric_status ric_store_is_solver(ric_store *store, const char *version, bool *same)
{
    char *kept = NULL;
    ric_status status = ric_store_get_meta(store->file, "solver", &kept);
    *same = kept && !strcmp(kept, version);
    free(kept);
    return status;
}

ric_status ric_store_set_solver(ric_store *store, const char *version)
{
    bool same;
    ric_status status = ric_store_is_solver(store, version, &same);
    if (status || same) return status;
    status = begin(store);
    if (!status) status = ric_store_sqlite_run(store->file, "DELETE FROM trace");
    if (!status) status = ric_store_put_meta(store->file, "solver", version);
    if (!status) status = ric_store_put_meta(store->file, "finished", "0");
    return conclude(store->file, status, NULL);
}

ric_status ric_store_starts_add(ric_store *store, const char *lines)
{
    ric_database file = store->file;
    char *old = NULL, *all = NULL;
    ric_status status = ric_store_starts_get(store, &old);
    if (!status && !(all = ric_malloc((old ? strlen(old) : 0) + strlen(lines) + 1)))
        status = ric_store_fail_memory();
    if (!status) {
        sprintf(all, "%s%s", old ? old : "", lines);
        status = begin(store);
    }
    if (!status) status = ric_store_put_meta(file, "starts", all);
    if (!status) status = ric_store_put_meta(file, "finished", "0");
    status = conclude(file, status, NULL);
    free(old);
    free(all);
    return status;
}

ric_status ric_store_stage_points(ric_store *store, const ric_atlas *atlas)
{
    ric_store_stage_drop(store);
    return ric_store_stage_lay(&store->stage, store->path, atlas);
}

void ric_store_stage_drop(ric_store *store)
{
    ric_store_stage_close(&store->stage, store->file);
}

typedef struct {
    ric_database file;
    ric_store_stage *stage;
    const ric_atlas *atlas;
    uint64_t digest; /* of the table meta, then of all */
} writing;

/* What is no row, and the digest of that. */
static ric_status put_meta(writing *w)
{
    const ric_atlas *atlas = w->atlas;
    ric_status status =
        ric_store_sqlite_run(w->file, "DELETE FROM point; DELETE FROM branch_junction; DELETE FROM "
                                      "junction_branch; DELETE FROM branch; DELETE FROM junction");
    if (!status)
        status = ric_store_put_study(w->file, atlas->study, atlas->finished, atlas->n_unplaced,
                                     atlas->n_blind);
    if (!status) status = ric_store_put_gaps(w->file, atlas);
    if (!status && atlas->labels) status = ric_store_put_meta(w->file, "labels", atlas->labels);
    return status ? status : ric_store_digest_meta(w->file, &w->digest);
}

static ric_status put_rows(const writing *w)
{
    static const ric_table *const tables[] = {&ric_table_branch, &ric_table_branch_junction,
                                              &ric_table_junction, &ric_table_junction_branch};
    ric_status status = RIC_OK;
    for (size_t i = 0; !status && i < sizeof tables / sizeof *tables; i++)
        status = ric_store_put_rows(w->file, w->atlas, tables[i]);
    return status ? status : ric_store_stage_take(w->stage, w->file);
}

static ric_status digest_rows(void *user)
{
    writing *w = user;
    return ric_store_digest_rows(w->atlas, &w->digest);
}

/* Rows come into the file and, with threads, into the digest at the same time. */
static ric_status write_rows(writing *w, bool aside)
{
    ric_together_call *call = aside ? ric_together_begin(digest_rows, w) : NULL;
    ric_status status = put_rows(w);
    const ric_status digested = call ? ric_together_end(call) : digest_rows(w);
    return status ? status : digested;
}

ric_status ric_store_write(ric_store *store, const ric_atlas *atlas, int workers)
{
    /* the work itself is kept even if the tables cannot be written */
    ric_status status = ric_store_commit(store);
    if (!status && !store->stage.memory.db)
        status = ric_store_stage_lay(&store->stage, store->path, atlas);
    if (!status && !(status = begin(store))) {
        writing w = {.file = store->file, .stage = &store->stage, .atlas = atlas};
        status = put_meta(&w);
        if (!status) status = write_rows(&w, workers > 1);
        status = conclude(store->file, status, &w.digest);
    }
    ric_store_stage_drop(store);
    return status;
}
