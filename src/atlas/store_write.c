/* The rows of branches, points and junctions, out: study and atlas to tables. */
#include "store_parts.h"
#include "base/room.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Fills the values of one insert from left to right; the first error is kept. */
typedef struct {
    ric_database file;
    sqlite3_stmt *insert;
    int column, code;
} row_writer;

static ric_status writer_start(row_writer *row, ric_database file, const ric_table *table)
{
    *row = (row_writer){.file = file};
    return ric_store_sqlite_table(file, table, RIC_SQL_INSERT, &row->insert);
}

static void put_integer(row_writer *row, sqlite3_int64 value)
{
    row->code |= sqlite3_bind_int64(row->insert, ++row->column, value);
}

static void put_real(row_writer *row, double value)
{
    row->code |= ric_store_sqlite_bind_number(row->insert, ++row->column, value);
}

static void put_id(row_writer *row, int id)
{
    if (id) put_integer(row, id);
    else row->code |= sqlite3_bind_null(row->insert, ++row->column);
}

static void put_text(row_writer *row, const char *text)
{
    row->code |= sqlite3_bind_text(row->insert, ++row->column, text ? text : "", -1,
                                   SQLITE_TRANSIENT);
}

static void put_float64s(row_writer *row, size_t n, const double *values)
{
    unsigned char *blob = ric_malloc(8 * n + 1);
    if (blob) ric_store_put_float64(blob, n, values);
    row->code |= blob ? sqlite3_bind_blob64(row->insert, ++row->column, blob, 8 * n, free)
                      : SQLITE_NOMEM;
}

static void put_word(row_writer *row, const ric_model *model, int n, const int *word)
{
    size_t size = 12 * (size_t)n + 1;
    char *text = ric_calloc(size, 1);
    if (!text || (n > 0 && ric_word_format(model, n, word, size, text))) row->code |= SQLITE_NOMEM;
    else put_text(row, text);
    free(text);
}

/* Derived columns are only read by others, who are spared infinities. */
static void put_column(row_writer *out, const ric_column *c, const ric_model *model,
                       const void *row)
{
    const void *at = (const char *)row + c->offset;
    double number = ric_column_number(c, row);
    switch (c->type) {
    case RIC_COLUMN_FLAG: put_integer(out, *(const bool *)at); break;
    case RIC_COLUMN_JUNCTION: put_id(out, *(const int *)at); break;
    case RIC_COLUMN_REAL:
    case RIC_COLUMN_MAYBE:
    case RIC_COLUMN_SINGLE: put_real(out, number); break;
    case RIC_COLUMN_DERIVED: put_real(out, isfinite(number) ? number : NAN); break;
    case RIC_COLUMN_TEXT: put_text(out, *(const char *const *)at); break;
    case RIC_COLUMN_WORD:
        put_word(out, model, ric_column_count(c, row), *(const int *const *)at);
        break;
    case RIC_COLUMN_STOP: put_text(out, ric_stop_text(*(const ric_stop *)at)); break;
    case RIC_COLUMN_KIND: put_text(out, ric_kind_text(*(const ric_kind *)at)); break;
    case RIC_COLUMN_STATE:
    case RIC_COLUMN_FLIGHTS:
        put_float64s(out, ric_column_width(c, row, ric_model_n_dof(model)),
                     *(const double *const *)at);
        break;
    default: put_integer(out, *(const int *)at);
    }
}

static ric_status write_row(row_writer *out, const ric_table *table, const ric_model *model,
                            const void *row)
{
    for (const ric_column *c = NULL; (c = ric_store_next_column(table, c, true));)
        put_column(out, c, model, row);
    bool ignored;
    ric_status status = out->code ? ric_store_fail_memory()
                                  : ric_store_sqlite_step(out->file, out->insert, &ignored);
    out->column = 0;
    return status;
}

ric_status ric_store_put_branches(ric_database file, const ric_atlas *atlas)
{
    const ric_model *model = ric_atlas_model(atlas);
    row_writer branch = {0}, point = {0}, junction = {0};
    ric_status status = writer_start(&branch, file, &ric_table_branch);
    if (!status) status = writer_start(&point, file, &ric_table_point);
    if (!status) status = writer_start(&junction, file, &ric_table_branch_junction);
    for (int k = 0; !status && k < atlas->n_branch; k++) {
        const ric_branch *row = &atlas->branches[k].row;
        status = write_row(&branch, &ric_table_branch, model, row);
        for (int i = 0; !status && i < row->n_point; i++) {
            const ric_point_row at = ric_atlas_point_row(atlas, row->id, i);
            status = write_row(&point, &ric_table_point, model, &at);
        }
        for (int i = 0; !status && i < row->n_junction; i++) {
            const ric_link_row link = {row->id, i, row->junctions[i], row->junction_at[i]};
            status = write_row(&junction, &ric_table_branch_junction, model, &link);
        }
    }
    sqlite3_finalize(branch.insert);
    sqlite3_finalize(point.insert);
    sqlite3_finalize(junction.insert);
    return status;
}

ric_status ric_store_put_junctions(ric_database file, const ric_atlas *atlas)
{
    row_writer junction = {0}, branch = {0};
    ric_status status = writer_start(&junction, file, &ric_table_junction);
    if (!status) status = writer_start(&branch, file, &ric_table_junction_branch);
    for (int k = 0; !status && k < atlas->n_junction; k++) {
        const ric_junction *row = &atlas->junctions[k].row;
        status = write_row(&junction, &ric_table_junction, ric_atlas_model(atlas), row);
        for (int i = 0; !status && i < row->n_branch; i++) {
            const ric_link_row link = {.owner = row->id, .other = row->branches[i]};
            status = write_row(&branch, &ric_table_junction_branch, ric_atlas_model(atlas), &link);
        }
    }
    sqlite3_finalize(junction.insert);
    sqlite3_finalize(branch.insert);
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
