/* The rows of branches, points and junctions, in: a file that may come from anyone to an atlas. */
#include "keys.h"
#include "links.h"
#include "store_parts.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"

enum {
    READER_WAIT = 60000, /* ms that a reader waits for a run that is just writing */
};

/* Takes the values of one row from left to right. A value of the wrong type, range or size makes
 * the row `wrong`, once and for all; the first that does is named. */
typedef struct {
    sqlite3_stmt *query;
    int column;
    const char *wrong; /* what is wrong with column `at` */
    int at;
    bool no_memory;
} row_reader;

static void fault(row_reader *row, int column, const char *what)
{
    if (row->wrong) return;
    row->wrong = what;
    row->at = column;
}

static int take_integer(row_reader *row, int min, int max)
{
    int column = row->column++;
    sqlite3_int64 value = sqlite3_column_int64(row->query, column);
    if (sqlite3_column_type(row->query, column) == SQLITE_INTEGER && value >= min && value <= max)
        return (int)value;
    fault(row, column, "not a whole number in its range");
    return min;
}

static double take_real(row_reader *row)
{
    int column = row->column++, type = sqlite3_column_type(row->query, column);
    if (type == SQLITE_FLOAT) return sqlite3_column_double(row->query, column);
    if (type != SQLITE_NULL) fault(row, column, "not a number");
    return NAN;
}

static int take_id(row_reader *row, int max)
{
    if (sqlite3_column_type(row->query, row->column) != SQLITE_NULL)
        return take_integer(row, 1, max);
    row->column++;
    return 0;
}

/* Whether the n bytes are UTF-8 without a zero (RFC 3629): JSON and pages take no other text. */
static bool is_text(const unsigned char *byte, size_t n)
{
    for (size_t i = 0; i < n;) {
        static const uint32_t least[] = {1, 1, 0x80, 0x800, 0x10000};
        unsigned char first = byte[i++];
        int length = first < 0x80       ? 1
                     : first >> 5 == 6  ? 2
                     : first >> 4 == 14 ? 3
                     : first >> 3 == 30 ? 4
                                        : 0;
        uint32_t code = length < 2 ? first : first & (0x7fu >> length);
        for (int k = 1; k < length; k++, i++) {
            if (i >= n || byte[i] >> 6 != 2) return false;
            code = code << 6 | (byte[i] & 0x3f);
        }
        if (!length || code < least[length] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000))
            return false;
    }
    return true;
}

static char *take_text(row_reader *row)
{
    int column = row->column++;
    const char *text = sqlite3_column_type(row->query, column) == SQLITE_TEXT
                           ? (const char *)sqlite3_column_text(row->query, column)
                           : NULL;
    if (!text ||
        !is_text((const unsigned char *)text, (size_t)sqlite3_column_bytes(row->query, column))) {
        fault(row, column, "not a text in UTF-8");
        text = "";
    }
    char *copy = ric_strdup(text);
    row->no_memory |= !copy;
    return copy;
}

/* One of the n texts of an enumeration. */
static int take_choice(row_reader *row, int n, const char *(*text_of)(int))
{
    int column = row->column, choice = 0;
    char *text = take_text(row);
    while (text && choice < n && strcmp(text, text_of(choice))) choice++;
    free(text);
    if (choice == n) fault(row, column, "none of the words that may stand there");
    return choice < n ? choice : 0;
}

static void take_float64s(row_reader *row, size_t n, double *values)
{
    int column = row->column++;
    const void *blob = sqlite3_column_type(row->query, column) == SQLITE_BLOB
                           ? sqlite3_column_blob(row->query, column)
                           : NULL;
    if (values && blob && (size_t)sqlite3_column_bytes(row->query, column) == 8 * n)
        ric_store_take_float64(blob, n, values);
    else fault(row, column, "not as many bytes as the model and the word ask for");
}

/* A word with `impacts` impacts; *n letters. */
static int *take_word(row_reader *row, const ric_model *model, int impacts, int *n)
{
    int column = row->column;
    char *text = take_text(row);
    int *word = text ? ric_word_read(model, text, n) : NULL;
    row->no_memory |= text && !word;
    if (!text || (word && *n < 0)) fault(row, column, "no word of faces of the model");
    else if (word && ric_word_impacts(model, *n, word) != impacts)
        fault(row, column, "not as long as its impacts");
    if (row->wrong || !word) *n = 0;
    free(text);
    return word;
}

static ric_status reader_status(const row_reader *row, ric_database file, const char *table)
{
    char what[200], sub[32] = "";
    if (row->no_memory) return ric_store_fail_memory();
    if (!row->wrong) return RIC_OK;
    if (sqlite3_errcode(file.db) ==
        SQLITE_NOMEM) /* a value that SQLite could not hand out is no fault of the file */
        return ric_store_fail_memory();
    if (sqlite3_column_count(row->query) > 1 && strcmp(sqlite3_column_name(row->query, 0), "id"))
        snprintf(sub, sizeof sub, ", %lld", (long long)sqlite3_column_int64(row->query, 1));
    snprintf(what, sizeof what, "table %s, row %lld%s, %s: %s", table,
             (long long)sqlite3_column_int64(row->query, 0), sub,
             sqlite3_column_name(row->query, row->at), row->wrong);
    return ric_store_fail_damaged(file.path, what);
}

static ric_status count_rows(ric_database file, const char *query, int *n)
{
    sqlite3_int64 count = 0;
    int code = ric_store_sqlite_ask(file.db, query, &count);
    *n = (int)(count <= INT_MAX ? count : 0);
    if (code) return ric_store_sqlite_fail(file, code);
    return count > INT_MAX ? ric_store_fail_damaged(file.path, "a table has too many rows")
                           : RIC_OK;
}

/* How many rows each of n_owner owners has, counts[0..n_owner-1]; there are no rows without one. */
static ric_status count_owned(ric_database file, const ric_table *table, int n_owner, int *counts)
{
    row_reader row = {0};
    bool more = true;
    ric_status status = ric_store_sqlite_table(file, table, RIC_SQL_COUNT, &row.query);
    memset(counts, 0, (size_t)n_owner * sizeof *counts);
    while (!status && !(status = ric_store_sqlite_step(file, row.query, &more)) && more) {
        row.column = 0;
        int owner = take_integer(&row, 1, n_owner), count = take_integer(&row, 1, INT_MAX);
        if (row.wrong)
            status = ric_store_fail_damaged(file.path, "rows belong to no branch or junction");
        else counts[owner - 1] = count;
    }
    sqlite3_finalize(row.query);
    return status;
}

/* Takes as many rows as were counted: n, or those of each owner. A row is the i-th of its list, or
 * of its owner, whose number is its first value. */
static ric_status take_rows(ric_database file, const ric_table *table, int n, const int *counts,
                            void (*take)(row_reader *, int i, ric_atlas *), ric_atlas *atlas)
{
    row_reader row = {0};
    bool more = true;
    ric_status status = ric_store_sqlite_table(file, table, RIC_SQL_SELECT, &row.query);
    for (int i = 0, last = 0; !status; i++) {
        if ((status = ric_store_sqlite_step(file, row.query, &more)) || !more) break;
        row.column = 0;
        int owner = counts ? take_integer(&row, 1, n) : 0;
        if (owner != last) i = 0;
        last = owner;
        row.column = 0;
        if (!row.wrong && i < (counts ? counts[owner - 1] : n)) take(&row, i, atlas);
        status = reader_status(&row, file, table->name);
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

/* A state or flights: where the row has room for them, else allocated. */
static void take_vector(row_reader *row, size_t n, const double **at)
{
    double *values = *at ? ric_own(*at) : ric_calloc(n, sizeof *values);
    row->no_memory |= !values;
    take_float64s(row, n, values);
    *at = values;
}

/* One value into its row, which has its own number and that of its owner, and the impacts of its
 * word. */
static void take_column(row_reader *in, const ric_column *c, const ric_atlas *atlas, void *row)
{
    const ric_model *model = ric_atlas_model(atlas);
    void *at = (char *)row + c->offset;
    int *number = at;
    switch (c->type) {
    case RIC_COLUMN_ID:
    case RIC_COLUMN_PLACE: *number = take_integer(in, *number, *number); break;
    case RIC_COLUMN_OF_BRANCH: *number = take_integer(in, 1, atlas->n_branch); break;
    case RIC_COLUMN_OF_JUNCTION: *number = take_integer(in, 1, atlas->n_junction); break;
    case RIC_COLUMN_INTEGER: *number = take_integer(in, (int)c->min, (int)c->max); break;
    case RIC_COLUMN_MODE: *number = take_integer(in, 0, ric_model_n_dof(model)); break;
    case RIC_COLUMN_FLAG: *(bool *)at = take_integer(in, 0, 1); break;
    case RIC_COLUMN_JUNCTION: *number = take_id(in, atlas->n_junction); break;
    case RIC_COLUMN_REAL:
    case RIC_COLUMN_MAYBE: *(double *)at = take_real(in); break;
    case RIC_COLUMN_SINGLE: *(float *)at = (float)take_real(in); break;
    case RIC_COLUMN_TEXT: *(const char **)at = take_text(in); break;
    case RIC_COLUMN_WORD: /* behind its impacts */
        *(const int **)at = take_word(in, model, *(int *)(void *)((char *)row + c[-1].offset),
                                      (void *)((char *)row + c->count));
        break;
    case RIC_COLUMN_STOP:
        *(ric_stop *)at = (ric_stop)take_choice(in, RIC_STOP_FAILED + 1, stop_text);
        break;
    case RIC_COLUMN_KIND:
        *(ric_kind *)at = (ric_kind)take_choice(in, RIC_KIND_USER + 1, kind_text);
        break;
    case RIC_COLUMN_STATE:
    case RIC_COLUMN_FLIGHTS:
        take_vector(in, ric_column_width(c, row, ric_model_n_dof(model)), (const double **)at);
        break;
    default: break;
    }
}

static void take_columns(row_reader *in, const ric_table *table, const ric_atlas *atlas, void *row)
{
    for (const ric_column *c = NULL; (c = ric_store_next_column(table, c, false));)
        take_column(in, c, atlas, row);
}

static void take_branch(row_reader *row, int i, ric_atlas *atlas)
{
    ric_branch_record *record = &atlas->branches[i];
    ric_branch *branch = &record->row;
    branch->id = i + 1;
    take_columns(row, &ric_table_branch, atlas, branch);
    record->label = ric_own(branch->label);
    record->word = ric_own(branch->word);
    record->mirror = ric_own(branch->mirror);
    record->why = ric_own(branch->why);
    record->stride = ric_atlas_point_stride(ric_model_n_dof(ric_atlas_model(atlas)),
                                            branch->letters);
}

/* Its state and flights go where they belong. */
static void take_point(row_reader *row, int i, ric_atlas *atlas)
{
    const int branch = sqlite3_column_int(row->query, 0); /* has been looked at */
    ric_point_row point = ric_atlas_point_row(atlas, branch, i);
    take_columns(row, &ric_table_point, atlas, &point);
    memcpy((double *)ric_own(point.state) - sizeof(ric_point) / sizeof(double), &point.point,
           sizeof(ric_point));
}

static void take_branch_junction(row_reader *row, int i, ric_atlas *atlas)
{
    ric_link_row link = {.place = i};
    take_columns(row, &ric_table_branch_junction, atlas, &link);
    ric_branch_record *record = &atlas->branches[link.owner - 1];
    record->junctions[i] = link.other;
    record->junction_at[i] = link.arclength;
}

static ric_status read_points(ric_database file, ric_atlas *atlas, int *counts)
{
    ric_status status = count_owned(file, &ric_table_point, atlas->n_branch, counts);
    for (int k = 0; !status && k < atlas->n_branch; k++) {
        ric_branch_record *record = &atlas->branches[k];
        if (counts[k] != record->row.n_point)
            return ric_store_fail_damaged(file.path, "points of a branch are missing");
        record->points = ric_calloc((size_t)counts[k] + 1, record->stride * sizeof *record->points);
        if (!record->points) return ric_store_fail_memory();
    }
    return status ? status
                  : take_rows(file, &ric_table_point, atlas->n_branch, counts, take_point, atlas);
}

static ric_status read_branch_junctions(ric_database file, ric_atlas *atlas, int *counts)
{
    ric_status status = count_owned(file, &ric_table_branch_junction, atlas->n_branch, counts);
    for (int k = 0; !status && k < atlas->n_branch; k++) {
        ric_branch_record *record = &atlas->branches[k];
        record->row.n_junction = counts[k];
        record->row.junctions = record->junctions = ric_calloc((size_t)counts[k] + 1,
                                                               sizeof *record->junctions);
        record->row.junction_at = record->junction_at = ric_calloc((size_t)counts[k] + 1,
                                                                   sizeof *record->junction_at);
        if (!record->junctions || !record->junction_at) return ric_store_fail_memory();
    }
    return status ? status
                  : take_rows(file, &ric_table_branch_junction, atlas->n_branch, counts,
                              take_branch_junction, atlas);
}

static ric_status read_branches(ric_database file, ric_atlas *atlas, int *counts)
{
    ric_status status = take_rows(file, &ric_table_branch, atlas->n_branch, NULL, take_branch,
                                  atlas);
    if (!status) status = read_points(file, atlas, counts);
    return status ? status : read_branch_junctions(file, atlas, counts);
}

static void take_junction(row_reader *row, int i, ric_atlas *atlas)
{
    ric_junction_record *record = &atlas->junctions[i];
    ric_junction *junction = &record->row;
    junction->id = i + 1;
    take_columns(row, &ric_table_junction, atlas, junction);
    junction->decided = junction->a > 0 && junction->label && !strchr(junction->label, '?');
    record->label = ric_own(junction->label);
    record->name = ric_own(junction->name);
    record->word = ric_own(junction->word);
    record->state = ric_own(junction->state);
    record->flights = ric_own(junction->flights);
    record->refusal = ric_own(junction->refusal);
}

static void take_junction_branch(row_reader *row, int i, ric_atlas *atlas)
{
    ric_link_row link = {0};
    take_columns(row, &ric_table_junction_branch, atlas, &link);
    atlas->junctions[link.owner - 1].branches[i] = link.other;
}

static ric_status read_junctions(ric_database file, ric_atlas *atlas, int *counts)
{
    ric_status status = take_rows(file, &ric_table_junction, atlas->n_junction, NULL, take_junction,
                                  atlas);
    if (!status) status = count_owned(file, &ric_table_junction_branch, atlas->n_junction, counts);
    for (int k = 0; !status && k < atlas->n_junction; k++) {
        ric_junction_record *record = &atlas->junctions[k];
        record->row.n_branch = counts[k];
        record->row.branches = record->branches = ric_calloc((size_t)counts[k] + 1,
                                                             sizeof *record->branches);
        if (!record->branches) return ric_store_fail_memory();
    }
    return status ? status
                  : take_rows(file, &ric_table_junction_branch, atlas->n_junction, counts,
                              take_junction_branch, atlas);
}

/* A count from 0; `missing` where an older program did not count. */
static ric_status read_count(ric_database file, const char *key, long missing, int *out)
{
    char *text = NULL, *end = NULL, what[80];
    ric_status status = ric_store_get_meta(file, key, &text);
    errno = 0;
    long count = text ? strtol(text, &end, 10) : missing;
    if (!status && text && (*text < '0' || *text > '9' || *end || errno || count > INT_MAX)) {
        snprintf(what, sizeof what, "table meta, row %s: not a count", key);
        status = ric_store_fail_damaged(file.path, what);
    }
    *out = status ? 0 : (int)count;
    free(text);
    return status;
}

/* What the table meta says of the study is what the study says. */
static ric_status check_study(ric_database file, const char *study, const ric_model *model)
{
    int n_dof = 0;
    char *text = ric_store_model_text(study), *stored = NULL;
    ric_status status = text ? ric_store_get_meta(file, "model", &stored) : ric_store_fail_memory();
    if (!status) status = read_count(file, "n_dof", ric_model_n_dof(model), &n_dof);
    if (!status && (!stored || strcmp(stored, text)))
        status = ric_store_fail_damaged(file.path,
                                        "table meta, row model: not the model of its study");
    if (!status && n_dof != ric_model_n_dof(model))
        status = ric_store_fail_damaged(file.path, "table meta, row n_dof: not that of its study");
    free(text);
    free(stored);
    return status;
}

static ric_status read_study(ric_database file, ric_atlas *atlas)
{
    char *study = NULL, *finished = NULL;
    ric_status status = ric_store_get_meta(file, "study", &study);
    if (!status) status = ric_store_get_meta(file, "finished", &finished);
    if (!status) status = read_count(file, "unplaced", 0, &atlas->n_unplaced);
    if (!status) status = read_count(file, "blind", 0, &atlas->n_blind);
    if (!status && (!study || !finished))
        status = ric_store_fail_damaged(file.path, "its study is missing");
    if (status) goto out;
    atlas->finished = !strcmp(finished, "1");
    if (!atlas->finished && strcmp(finished, "0")) {
        status = ric_store_fail_damaged(file.path, "table meta, row finished: neither 0 nor 1");
        goto out;
    }
    if ((status = ric_store_get_meta(file, "labels", &atlas->labels))) goto out;
    status = ric_study_parse(study, file.path, ".", &atlas->study);
    if (status && status != RIC_E_NOMEM)
        status = ric_store_fail_damaged(file.path, "its study cannot be read");
    if (!status) status = check_study(file, study, ric_study_model(atlas->study));
out:
    free(study);
    free(finished);
    return status;
}

static ric_status read_atlas(ric_database file, ric_atlas *atlas)
{
    int n_branch = 0, n_junction = 0;
    ric_status status = read_study(file, atlas);
    if (!status) status = count_rows(file, "SELECT count(*) FROM branch", &n_branch);
    if (!status) status = count_rows(file, "SELECT count(*) FROM junction", &n_junction);
    if (status) return status;
    atlas->branches = ric_calloc((size_t)n_branch + 1, sizeof *atlas->branches);
    atlas->junctions = ric_calloc((size_t)n_junction + 1, sizeof *atlas->junctions);
    int *counts = ric_calloc((size_t)(n_branch > n_junction ? n_branch : n_junction) + 1,
                             sizeof *counts);
    if (!atlas->branches || !atlas->junctions || !counts) {
        status = ric_store_fail_memory();
        goto out;
    }
    atlas->n_branch = n_branch;
    atlas->n_junction = n_junction;
    status = read_branches(file, atlas, counts);
    if (!status) status = read_junctions(file, atlas, counts);
    if (!status) status = ric_store_read_gaps(file, atlas);
out:
    free(counts);
    return status;
}

/* Read-only, unless a killed run has left a transaction that has to be undone first. */
static ric_status open_reader(const char *path, ric_database *file)
{
    static const char begin[] = "BEGIN; SELECT count(*) FROM sqlite_master";
    ric_status status = ric_store_left_ahead(path)
                            ? ric_store_sqlite_open_still(path, file)
                            : ric_store_sqlite_open(path, SQLITE_OPEN_READONLY, READER_WAIT, file);
    if (status) return status;
    int code = sqlite3_exec(file->db, begin, NULL, NULL, NULL);
    if (code == SQLITE_READONLY_ROLLBACK) {
        sqlite3_close(file->db);
        status = ric_store_sqlite_open(path, SQLITE_OPEN_READWRITE, READER_WAIT, file);
        if (status) return status;
        code = sqlite3_exec(file->db, begin, NULL, NULL, NULL);
    }
    return code ? ric_store_sqlite_fail(*file, code) : RIC_OK;
}

ric_status ric_store_read_tables(ric_database file, ric_atlas **out)
{
    ric_atlas *atlas = ric_calloc(1, sizeof *atlas);
    ric_status status = atlas ? read_atlas(file, atlas) : ric_store_fail_memory();
    if (!status) status = ric_store_check_numbers(file.path, atlas);
    if (!status) status = ric_store_read_proofs(file, atlas);
    if (!status) status = ric_store_read_graph(file, atlas);
    if (!status) status = ric_store_read_arcs(file, atlas);
    if (!status) status = ric_keys_make(atlas);
    if (!status) status = ric_links_make(atlas);
    if (status) ric_atlas_free(atlas);
    *out = status ? NULL : atlas;
    return status;
}

ric_status ric_store_read(const char *path, ric_atlas **out)
{
    ric_database file = {NULL, path};
    bool exists, empty;
    ric_status status;
    *out = NULL;
    status = ric_store_look(path, &exists, &empty);
    if (!status && !exists)
        status = ric_fail(RIC_E_MISSING, "%s: no such file; make an atlas with `ricochet run`",
                          path);
    else if (!status && empty)
        status = ric_fail(RIC_E_FORMAT, "%s: the file is empty; make an atlas with `ricochet run`",
                          path);
    if (!status) status = ric_store_check_identity(path);
    if (!status) status = ric_store_check_beside(path);
    if (!status) status = open_reader(path, &file);
    if (!status) status = ric_store_check_contents(file);
    if (!status) status = ric_store_read_tables(file, out);
    sqlite3_close(file.db);
    return status;
}
