/* The points of an atlas on their way into the file. Their rows are nearly all that a run writes at
 * its end, and SQLite takes them one by one; so they are laid into a table in memory, for which
 * nothing of the file is needed while others still work, and the file takes over the table as it
 * is. That is several times as fast, and fills its pages: rows that are inserted one by one leave
 * one byte in nine of the pages empty. */
#include "store_parts.h"
#include "base/room.h"

#include <stdio.h>

enum { NAME = 80 /* of the database in memory, its end included */ };

/* Two connections of one process that name it are at the same database, which goes with the last
 * of them. */
static void name_of(const void *owner, char *name)
{
    snprintf(name, NAME, "file:ricochet-%p?mode=memory&cache=shared", owner);
}

/* Its pages go with it, so that they may be of the size that takes least time. */
static ric_status fill(const ric_store_stage *stage)
{
    sqlite3_stmt *create = NULL;
    bool row;
    ric_status status = ric_store_sqlite_run(stage->memory, "PRAGMA page_size = 32768; PRAGMA "
                                                            "journal_mode = OFF; BEGIN");
    if (!status)
        status = ric_store_sqlite_table(stage->memory, &ric_table_point, RIC_SQL_CREATE, &create);
    if (!status) status = ric_store_sqlite_step(stage->memory, create, &row);
    sqlite3_finalize(create);
    if (!status) status = ric_store_put_rows(stage->memory, stage->atlas, &ric_table_point);
    return status ? status : ric_store_sqlite_run(stage->memory, "COMMIT");
}

ric_status ric_store_stage_lay(ric_store_stage *stage, const char *path, const ric_atlas *atlas)
{
    char name[NAME];
    name_of(stage, name);
    ric_status status = ric_store_sqlite_open(name,
                                              SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE |
                                                  SQLITE_OPEN_URI,
                                              0, &stage->memory);
    stage->memory.path = path;
    stage->atlas = atlas;
    return status ? status : fill(stage);
}

static ric_status attach(const ric_store_stage *stage, ric_database file)
{
    char name[NAME];
    sqlite3_stmt *query = NULL;
    bool row;
    name_of(stage, name);
    ric_status status = ric_store_sqlite_prepare(file, "ATTACH ? AS stage", &query);
    if (!status && sqlite3_bind_text(query, 1, name, -1, SQLITE_STATIC))
        status = ric_store_fail_memory();
    if (!status) status = ric_store_sqlite_step(file, query, &row);
    sqlite3_finalize(query);
    return status;
}

/* Between two tables that are declared alike, of which the second is empty, SQLite moves rows
 * without looking into them, and fills pages to the end. */
ric_status ric_store_stage_take(ric_store_stage *stage, ric_database file)
{
    const ric_status status = attach(stage, file);
    return status ? status
                  : ric_store_sqlite_run(file, "INSERT INTO main.point SELECT * FROM stage.point");
}

void ric_store_stage_close(ric_store_stage *stage, ric_database file)
{
    if (stage->memory.db) sqlite3_exec(file.db, "DETACH stage", NULL, NULL, NULL);
    sqlite3_close(stage->memory.db);
    *stage = (ric_store_stage){0};
}
