/* The rows of branches, points and junctions, out: study and atlas to tables. */
#include "store_parts.h"
#include "base/room.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------ values */

/* Room for `size` bytes, which the next value takes over. */
static void *room_for(ric_store_maker *maker, size_t size)
{
    if (size > maker->size) {
        void *grown = ric_realloc(maker->room, size);
        if (!grown) return NULL;
        maker->room = grown;
        maker->size = size;
    }
    return maker->room;
}

static ric_store_value integer(sqlite3_int64 value)
{
    return (ric_store_value){.type = SQLITE_INTEGER, .integer = value};
}

/* SQLite has no NaN. */
static ric_store_value real(double value)
{
    return isnan(value) ? (ric_store_value){.type = SQLITE_NULL}
                        : (ric_store_value){.type = SQLITE_FLOAT, .real = value};
}

static ric_store_value text(const char *value)
{
    const char *bytes = value ? value : "";
    return (ric_store_value){.type = SQLITE_TEXT, .bytes = bytes, .n = strlen(bytes)};
}

static bool make_word(ric_store_maker *maker, int n, const int *word, ric_store_value *value)
{
    const size_t size = 12 * (size_t)n + 1;
    char *out = room_for(maker, size);
    if (!out) return false;
    *out = '\0';
    if (n > 0 && ric_word_format(maker->model, n, word, size, out)) return false;
    *value = text(out);
    return true;
}

/* Whether numbers lie in memory as they do in the file. */
static bool little_endian(void)
{
    const uint16_t one = 1;
    return *(const unsigned char *)&one == 1;
}

static bool make_float64s(ric_store_maker *maker, size_t n, const double *values,
                          ric_store_value *value)
{
    *value = (ric_store_value){.type = SQLITE_BLOB, .bytes = values, .n = 8 * n};
    if (little_endian()) return true;
    unsigned char *blob = room_for(maker, 8 * n + 1);
    if (!blob) return false;
    ric_store_put_float64(blob, n, values);
    value->bytes = blob;
    return true;
}

/* Derived columns are only read by others, who are spared infinities. */
bool ric_store_value_of(ric_store_maker *maker, const ric_column *c, const void *row,
                        ric_store_value *value)
{
    const void *at = (const char *)row + c->offset;
    const double number = ric_column_number(c, row);
    const int id = c->type == RIC_COLUMN_JUNCTION ? *(const int *)at : 0;
    switch (c->type) {
    case RIC_COLUMN_FLAG: *value = integer(*(const bool *)at); break;
    case RIC_COLUMN_JUNCTION: *value = id ? integer(id) : real(NAN); break;
    case RIC_COLUMN_REAL:
    case RIC_COLUMN_MAYBE:
    case RIC_COLUMN_SINGLE: *value = real(number); break;
    case RIC_COLUMN_DERIVED: *value = real(isfinite(number) ? number : NAN); break;
    case RIC_COLUMN_TEXT: *value = text(*(const char *const *)at); break;
    case RIC_COLUMN_WORD:
        return make_word(maker, ric_column_count(c, row), *(const int *const *)at, value);
    case RIC_COLUMN_STOP: *value = text(ric_stop_text(*(const ric_stop *)at)); break;
    case RIC_COLUMN_KIND: *value = text(ric_kind_text(*(const ric_kind *)at)); break;
    case RIC_COLUMN_STATE:
    case RIC_COLUMN_FLIGHTS:
        return make_float64s(maker, ric_column_width(c, row, ric_model_n_dof(maker->model)),
                             *(const double *const *)at, value);
    default: *value = integer(*(const int *)at);
    }
    return true;
}

/* -------------------------------------------------------------------- rows */

typedef struct {
    const ric_atlas *atlas;
    const ric_table *table;
    ric_status (*take)(void *user, const ric_table *table, const void *row);
    void *user;
} row_giver;

static ric_status give_points(const row_giver *to, const ric_branch *branch)
{
    ric_status status = RIC_OK;
    for (int i = 0; !status && i < branch->n_point; i++) {
        const ric_point_row row = ric_atlas_point_row(to->atlas, branch->id, i);
        status = to->take(to->user, to->table, &row);
    }
    return status;
}

static ric_status give_passages(const row_giver *to, const ric_branch *branch)
{
    ric_status status = RIC_OK;
    for (int i = 0; !status && i < branch->n_junction; i++) {
        const ric_link_row row = {branch->id, i, branch->junctions[i], branch->junction_at[i]};
        status = to->take(to->user, to->table, &row);
    }
    return status;
}

static int compare_ids(const void *a, const void *b)
{
    const int p = *(const int *)a, q = *(const int *)b;
    return (p > q) - (p < q);
}

static ric_status give_branches(const row_giver *to, const ric_junction *junction)
{
    const size_t n = (size_t)junction->n_branch;
    int *ids = ric_malloc((n + 1) * sizeof *ids);
    ric_status status = ids ? RIC_OK : ric_store_fail_memory();
    if (ids && n) {
        memcpy(ids, junction->branches, n * sizeof *ids);
        qsort(ids, n, sizeof *ids, compare_ids);
    }
    for (size_t i = 0; !status && i < n; i++) {
        const ric_link_row row = {.owner = junction->id, .other = ids[i]};
        status = to->take(to->user, to->table, &row);
    }
    free(ids);
    return status;
}

ric_status ric_store_each_row(const ric_atlas *atlas, const ric_table *table,
                              ric_status (*take)(void *user, const ric_table *table,
                                                 const void *row),
                              void *user)
{
    const row_giver to = {atlas, table, take, user};
    const bool of_branches = table == &ric_table_branch || table == &ric_table_point ||
                             table == &ric_table_branch_junction;
    ric_status status = RIC_OK;
    for (int i = 0; of_branches && !status && i < atlas->n_branch; i++) {
        const ric_branch *branch = &atlas->branches[i].row;
        status = table == &ric_table_branch  ? take(user, table, branch)
                 : table == &ric_table_point ? give_points(&to, branch)
                                             : give_passages(&to, branch);
    }
    for (int i = 0; !of_branches && !status && i < atlas->n_junction; i++) {
        const ric_junction *junction = &atlas->junctions[i].row;
        status = table == &ric_table_junction ? take(user, table, junction)
                                              : give_branches(&to, junction);
    }
    return status;
}

/* ------------------------------------------------------------------- insert */

typedef struct {
    ric_database file;
    sqlite3_stmt *insert;
    ric_store_maker maker;
} row_writer;

/* What lies in the room of a maker is copied: the next value takes it over. */
static int bind(sqlite3_stmt *insert, int column, const ric_store_value *value, const void *room)
{
    sqlite3_destructor_type keep = value->bytes == room ? SQLITE_TRANSIENT : SQLITE_STATIC;
    switch (value->type) {
    case SQLITE_INTEGER: return sqlite3_bind_int64(insert, column, value->integer);
    case SQLITE_FLOAT: return sqlite3_bind_double(insert, column, value->real);
    case SQLITE_TEXT: return sqlite3_bind_text(insert, column, value->bytes, (int)value->n, keep);
    case SQLITE_BLOB: return sqlite3_bind_blob64(insert, column, value->bytes, value->n, keep);
    default: return sqlite3_bind_null(insert, column);
    }
}

static ric_status write_row(void *user, const ric_table *table, const void *row)
{
    row_writer *out = user;
    ric_store_value value;
    int column = 0;
    bool ignored;
    for (const ric_column *c = NULL; (c = ric_store_next_column(table, c, true));)
        if (!ric_store_value_of(&out->maker, c, row, &value) ||
            bind(out->insert, ++column, &value, out->maker.room))
            return ric_store_fail_memory();
    return ric_store_sqlite_step(out->file, out->insert, &ignored);
}

ric_status ric_store_put_rows(ric_database file, const ric_atlas *atlas, const ric_table *table)
{
    row_writer out = {.file = file, .maker = {.model = ric_atlas_model(atlas)}};
    ric_status status = ric_store_sqlite_table(file, table, RIC_SQL_INSERT, &out.insert);
    if (!status) status = ric_store_each_row(atlas, table, write_row, &out);
    sqlite3_finalize(out.insert);
    free(out.maker.room);
    return status;
}

ric_status ric_store_put_study(ric_database file, const ric_study *study, bool finished,
                               int n_unplaced, int n_blind)
{
    char text[64];
    char *model = ric_store_model_text(ric_study_text(study));
    ric_status status = model ? ric_store_put_meta(file, "study", ric_study_text(study))
                              : ric_store_fail_memory();
    if (!status) status = ric_store_put_meta(file, "model", model);
    if (!status) status = ric_store_put_meta(file, "program", "ricochet " RIC_VERSION);
    ric_c_print(text, sizeof text, "%.17g", ric_study_options(study)->tolerance);
    if (!status) status = ric_store_put_meta(file, "tolerance", text);
    snprintf(text, sizeof text, "%d", ric_model_n_dof(ric_study_model(study)));
    if (!status) status = ric_store_put_meta(file, "n_dof", text);
    if (!status) status = ric_store_put_meta(file, "finished", finished ? "1" : "0");
    snprintf(text, sizeof text, "%d", n_unplaced);
    if (!status) status = ric_store_put_meta(file, "unplaced", text);
    snprintf(text, sizeof text, "%d", n_blind);
    if (!status) status = ric_store_put_meta(file, "blind", text);
    free(model);
    return status;
}
