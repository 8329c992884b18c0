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

static ric_status writer_start(row_writer *row, ric_database file, const char *table, const char *columns)
{
    char sql[1024];
    size_t n = (size_t)snprintf(sql, sizeof sql, "INSERT INTO %s (%s) VALUES (?", table, columns);
    for (const char *c = columns; *c && n < sizeof sql - 4; c++)
        if (*c == ',') n += (size_t)sprintf(sql + n, ",?");
    strcpy(sql + n, ")");
    *row = (row_writer){.file = file};
    return ric_store_sqlite_prepare(file, sql, &row->insert);
}

static void put_integer(row_writer *row, sqlite3_int64 value)
{
    row->code |= sqlite3_bind_int64(row->insert, ++row->column, value);
}

/* SQLite has no NaN: it is NULL in the file. */
static void put_real(row_writer *row, double value)
{
    ++row->column;
    row->code |= isnan(value) ? sqlite3_bind_null(row->insert, row->column)
                              : sqlite3_bind_double(row->insert, row->column, value);
}

/* For columns that are only read by others, who are spared infinities. */
static void put_finite(row_writer *row, double value)
{
    put_real(row, isfinite(value) ? value : NAN);
}

static void put_id(row_writer *row, int id)
{
    if (id) put_integer(row, id);
    else row->code |= sqlite3_bind_null(row->insert, ++row->column);
}

static void put_text(row_writer *row, const char *text)
{
    row->code |= sqlite3_bind_text(row->insert, ++row->column, text ? text : "", -1, SQLITE_TRANSIENT);
}

static void put_float64s(row_writer *row, size_t n, const double *values)
{
    unsigned char *blob = ric_malloc(8 * n + 1);
    if (blob) ric_store_put_float64(blob, n, values);
    row->code |= blob ? sqlite3_bind_blob64(row->insert, ++row->column, blob, 8 * n, free) : SQLITE_NOMEM;
}

static void put_word(row_writer *row, const ric_model *model, int n, const int *word)
{
    size_t size = 12 * (size_t)n + 1;
    char *text = ric_calloc(size, 1);
    if (!text || (n > 0 && ric_word_format(model, n, word, size, text))) row->code |= SQLITE_NOMEM;
    else put_text(row, text);
    free(text);
}

static ric_status writer_row(row_writer *row)
{
    bool ignored;
    ric_status status = row->code ? ric_store_fail_memory() : ric_store_sqlite_step(row->file, row->insert, &ignored);
    row->column = 0;
    return status;
}

static ric_status write_branch(row_writer *row, const ric_model *model, const ric_branch *branch)
{
    put_integer(row, branch->id);
    put_text(row, branch->label);
    put_integer(row, branch->impacts);
    put_word(row, model, branch->letters, branch->word);
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
    size_t n_flight = branch->letters > 0 ? (size_t)branch->letters : 1;
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
    put_finite(row, RIC_TWO_PI / point.frequency);
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
    put_word(row, model, junction->letters, junction->word);
    put_integer(row, junction->grazings);
    put_integer(row, junction->multiple);
    put_integer(row, junction->rotation[0]);
    put_integer(row, junction->rotation[1]);
    put_integer(row, junction->a);
    put_integer(row, junction->b);
    put_real(row, junction->energy);
    put_real(row, junction->frequency);
    put_float64s(row, 2 * (size_t)ric_model_n_dof(model), junction->state);
    put_float64s(row, junction->letters > 0 ? (size_t)junction->letters : 1, junction->flights);
    put_integer(row, count->taken);
    put_integer(row, count->known);
    put_integer(row, count->inadmissible);
    put_integer(row, count->over_budget);
    put_integer(row, count->refused);
    put_text(row, junction->refusal);
    for (int i = 0; i < RIC_N_BUDGET; i++) put_integer(row, count->over[i]);
    return writer_row(row);
}

ric_status ric_store_put_branches(ric_database file, const ric_atlas *atlas)
{
    const ric_model *model = ric_atlas_model(atlas);
    int n_dof = ric_model_n_dof(model);
    row_writer branch = {0}, point = {0}, junction = {0};
    ric_status status = writer_start(&branch, file, "branch", BRANCH_COLUMNS);
    if (!status) status = writer_start(&point, file, "point", POINT_COLUMNS);
    if (!status) status = writer_start(&junction, file, "branch_junction", BRANCH_JUNCTION_COLUMNS);
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

ric_status ric_store_put_junctions(ric_database file, const ric_atlas *atlas)
{
    row_writer junction = {0}, branch = {0};
    ric_status status = writer_start(&junction, file, "junction", JUNCTION_COLUMNS);
    if (!status) status = writer_start(&branch, file, "junction_branch", JUNCTION_BRANCH_COLUMNS);
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

ric_status ric_store_put_study(ric_database file, const ric_study *study, bool finished, int n_unplaced, int n_blind)
{
    char text[64];
    char *model = ric_store_model_text(ric_study_text(study));
    ric_status status = model ? ric_store_put_meta(file, "study", ric_study_text(study)) : ric_store_fail_memory();
    if (!status) status = ric_store_put_meta(file, "model", model);
    if (!status) status = ric_store_put_meta(file, "program", "ricochet " RIC_VERSION);
    locale_t before = ric_c_locale_enter();
    snprintf(text, sizeof text, "%.17g", ric_study_options(study)->tolerance);
    ric_c_locale_leave(before);
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
