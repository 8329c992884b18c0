/* What the files of the store share: its database, its checks and its rows. No other file needs it.
 */
#ifndef RIC_ATLAS_STORE_PARTS_H
#define RIC_ATLAS_STORE_PARTS_H

#include <sqlite3.h>
#include <stdint.h>
#include <sys/types.h>

#include "columns.h"
#include "store.h"
#include "base/room.h"

enum {
    RIC_APPLICATION_ID = 0x52434854, /* "RCHT" */
    RIC_FORMAT_VERSION = 1,
};

typedef struct {
    sqlite3 *db;
    const char *path; /* borrowed */
} ric_database;

/* ------------------------------------------------------------ store_sqlite.c */

ric_status ric_store_fail_memory(void);
ric_status ric_store_fail_damaged(const char *path, const char *what);
/* The row of a table with this key. */
ric_status ric_store_fail_row(const char *path, const char *table, const char *key,
                              const char *what);
ric_status ric_store_fail_foreign(const char *path);

/* A result code of SQLite as one of our kinds. */
ric_status ric_store_sqlite_fail(ric_database file, int code);
/* `wait`: ms until a locked file is given up. */
ric_status ric_store_sqlite_open(const char *path, int flags, int wait, ric_database *out);
/* The file as it lies there: no locks, no journals, nothing is made beside it. Only for what nobody
 * writes meanwhile. */
ric_status ric_store_sqlite_open_still(const char *path, ric_database *out);
ric_status ric_store_sqlite_run(ric_database file, const char *sql);
ric_status ric_store_sqlite_prepare(ric_database file, const char *sql, sqlite3_stmt **out);
/* The same of a table that a file need not have: *out stays NULL if it has none. */
ric_status ric_store_sqlite_prepare_there(ric_database file, const char *table, const char *sql,
                                          sqlite3_stmt **out);
/* One row further; *row = false at the end, and then the query may run again. */
ric_status ric_store_sqlite_step(ric_database file, sqlite3_stmt *query, bool *row);
/* SQLite has no NaN: it is NULL in the file. Columns of a row count from 0, of what is bound from
 * 1, which returns a code of SQLite. */
double ric_store_sqlite_number(sqlite3_stmt *row, int column);
int ric_store_sqlite_bind_number(sqlite3_stmt *query, int column, double value);
/* What is asked of a table; the columns of other readers, which are derived, come last. */
typedef enum { RIC_SQL_CREATE, RIC_SQL_INSERT, RIC_SQL_SELECT, RIC_SQL_COUNT } ric_sql;
ric_status ric_store_sqlite_table(ric_database file, const ric_table *table, ric_sql what,
                                  sqlite3_stmt **out);
/* Columns in that order, NULL behind the last: of what is stored, and where all is false, not
 * derived. */
const ric_column *ric_store_next_column(const ric_table *table, const ric_column *before, bool all);
/* The number in a one-row answer, as a result code of SQLite. */
int ric_store_sqlite_ask(sqlite3 *db, const char *sql, sqlite3_int64 *out);

/* Little-endian float64 on any machine. */
void ric_store_put_float64(unsigned char *out, size_t n, const double *values);
void ric_store_take_float64(const unsigned char *in, size_t n, double *values);

/* -------------------------------------------------------------- store_lock.c */

/* The file itself behind links, which may not exist yet, to be freed; NULL without memory. */
char *ric_store_resolve(const char *path);
/* What a file is, in words: "a folder". */
const char *ric_store_file_kind(mode_t mode);
/* The lock `path` beside the atlas `atlas`, and its descriptor; released, *lock = -1. */
ric_status ric_store_lock_take(const char *atlas, const char *path, int *lock);
void ric_store_lock_release(const char *path, int *lock);
/* Whether another program has left the file in write-ahead mode without anything waiting beside it:
 * SQLite would make files beside it for whoever only reads, and a run takes it out of that mode. */
bool ric_store_left_ahead(const char *atlas);
/* Refuses what SQLite would take for journals of the atlas and is none, before it is opened. */
ric_status ric_store_check_beside(const char *atlas);

/* ------------------------------------------------------------- store_check.c */

/* Whether there is a file with something in it; anything but a regular file is refused. */
ric_status ric_store_look(const char *path, bool *exists, bool *empty);
/* Only the identification numbers, so that a foreign file is left exactly as it is. */
ric_status ric_store_check_identity(const char *path);
/* Structure, tables and contents, inside the reader's transaction. */
ric_status ric_store_check_contents(ric_database file);
/* The rows of the table `trace`: their types, that no key comes twice, and the digest of each. */
ric_status ric_store_check_work(ric_database file);
/* That the file is of the model of `study`. */
ric_status ric_store_check_model(ric_database file, const ric_study *study);

/* The model of a study: from the line `model:` to the next top-level key, as a copy; "" if there is
 * none. NULL without memory. */
char *ric_store_model_text(const char *study);
/* 9 and 9.0 are the same model. */
ric_status ric_store_compare_models(const char *path, const char *stored, const char *given);

/* *value = NULL when there is no such key; to be freed. */
ric_status ric_store_get_meta(ric_database file, const char *key, char **value);
ric_status ric_store_put_meta(ric_database file, const char *key, const char *value);

/* ------------------------------------------------------------ store_digest.c */

/* Over all numbers of a structure. */
uint64_t ric_store_digest_model(const ric_model *model);
/* Of what was printed, which is closed: finds damage, not forgery. */
ric_status ric_store_digest_text(ric_buffer *text, uint64_t *digest);
/* That of all contents of a file. */
ric_status ric_store_digest_contents(ric_database file, uint64_t *digest);
/* The same in two steps, before the rows are in the file: its table meta, then the rows that are to
 * be written, for which nothing is asked of the file. */
ric_status ric_store_digest_meta(ric_database file, uint64_t *digest);
ric_status ric_store_digest_rows(const ric_atlas *atlas, uint64_t *digest);
/* Writes the digest of all contents, which makes them valid: one that is known, or that of what is
 * in the file. */
ric_status ric_store_set_digest(ric_database file, uint64_t digest);
ric_status ric_store_put_digest(ric_database file);

/* -------------------------------------------------------------- store_read.c */

/* The tables as an atlas whose numbers may be those of one. The contents have been checked. */
ric_status ric_store_read_tables(ric_database file, ric_atlas **out);

/* ------------------------------------------------------------- store_valid.c */

/* Refuses an atlas with numbers that no run can have written. */
ric_status ric_store_check_numbers(const char *path, const ric_atlas *atlas);

/* ------------------------------------------------------------- store_write.c */

ric_status ric_store_put_study(ric_database file, const ric_study *study, bool finished,
                               int n_unplaced, int n_blind);

/* A value as SQLite has it: `type` is SQLITE_INTEGER and so on, and what does not belong to it is
 * zero. Bytes are borrowed. */
typedef struct {
    int type;
    sqlite3_int64 integer;
    double real;
    const void *bytes;
    size_t n;
} ric_store_value;

/* Makes values; its room, to be freed, holds the bytes of the last one. */
typedef struct {
    const ric_model *model;
    void *room;
    size_t size;
} ric_store_maker;

/* What a column of a row holds in the file; false without memory. */
bool ric_store_value_of(ric_store_maker *maker, const ric_column *column, const void *row,
                        ric_store_value *value);
/* Calls `take` for every row of a table in the order of its key, until one fails. */
ric_status ric_store_each_row(const ric_atlas *atlas, const ric_table *table,
                              ric_status (*take)(void *user, const ric_table *table,
                                                 const void *row),
                              void *user);
ric_status ric_store_put_rows(ric_database file, const ric_atlas *atlas, const ric_table *table);

/* ------------------------------------------------------------- store_stage.c */

/* Rows of points in a database in memory. */
typedef struct {
    ric_database memory;
    const ric_atlas *atlas;
} ric_store_stage;

/* Fills it; `path` is what errors speak of. */
ric_status ric_store_stage_lay(ric_store_stage *stage, const char *path, const ric_atlas *atlas);
/* Takes the rows into the file, whose table of points is empty. */
ric_status ric_store_stage_take(ric_store_stage *stage, ric_database file);
/* Outside a transaction of the file. */
void ric_store_stage_close(ric_store_stage *stage, ric_database file);

/* ------------------------------------------------------------- store_later.c */

/* What is done to the work that is kept. */
typedef enum { RIC_STORE_PUT, RIC_STORE_DROP, RIC_STORE_COMMIT } ric_store_act;
typedef struct {
    ric_store_act act;
    const char *key; /* "" of a commit */
    const void *blob;
    size_t size;
} ric_store_task;

typedef struct ric_store_later ric_store_later;
/* A thread that does so by `apply`; NULL where there is none to be had. */
ric_store_later *ric_store_later_begin(ric_status (*apply)(void *user, const ric_store_task *task),
                                       void *user);
/* Copies the task; after one has failed, its status and reason. */
ric_status ric_store_later_add(ric_store_later *later, const ric_store_task *task);
/* Until all is done. */
ric_status ric_store_later_wait(ric_store_later *later);
/* The same, and the thread ends. */
ric_status ric_store_later_end(ric_store_later *later);

/* The keys of all work that a file keeps, or has kept, by their hashes. */
typedef struct {
    bool whole; /* no key is missing */
    size_t count, n_slot;
    uint64_t *slots; /* [n_slot], a power of two; 0: free. To be freed */
} ric_store_names;
void ric_store_names_add(ric_store_names *names, const char *key);
/* Whether nothing is kept under a key for certain. */
bool ric_store_names_lack(const ric_store_names *names, const char *key);

/* -------------------------------------------------------------- store_gaps.c */

ric_status ric_store_put_gaps(ric_database file, const ric_atlas *atlas);
ric_status ric_store_read_gaps(ric_database file, ric_atlas *atlas);

/* ------------------------------------------------------------------ store.c */

/* Begins to put rows into a table, which is made if it is not there, in a transaction that
 * ric_store_commit ends. */
ric_status ric_store_fill(ric_store *store, const char *create, const char *insert,
                          ric_database *file, sqlite3_stmt **query);

/* --------------------------------------------------------- store_refusals.c */

/* What was not proved: a "point" of branch `id`, a "curve" or a "junction"; and the checksum of the
 * row that says so. */
typedef struct {
    const char *kind;
    int id, point;
    uint64_t digest;
} ric_refused;

/* Asks for the version of the prover, "" if the file has none; the query is NULL if it has no such
 * table. */
ric_status ric_store_refusals_find(ric_database file, sqlite3_stmt **out);
ric_status ric_store_refusals_read(ric_database file, sqlite3_stmt *query, const ric_refused *what,
                                   size_t size, char *prover);
/* Keeps it; the table is made if it is not there. */
ric_status ric_store_refusals_fill(ric_database file, sqlite3_stmt **out);
ric_status ric_store_refusals_put(ric_database file, sqlite3_stmt *query, const ric_refused *what,
                                  const char *prover);

/* ----------------------------------------------------------- store_proofs.c */

/* Proofs of points that are what they were; none if there is no such table. */
ric_status ric_store_read_proofs(ric_database file, ric_atlas *atlas);

/* ------------------------------------------------------------ store_graph.c */

/* The same of curves and junctions. */
ric_status ric_store_read_graph(ric_database file, ric_atlas *atlas);
/* All that a curve is laid through, as text for a checksum. */
void ric_store_graph_print_branch(FILE *f, const ric_atlas *atlas, int id);

/* ------------------------------------------------------------- store_arcs.c */

/* Arcs of curves in work. */
ric_status ric_store_read_arcs(ric_database file, ric_atlas *atlas);
/* Drops those of a branch, if there is such a table. */
ric_status ric_store_arcs_drop(ric_database file, int branch);

#endif
