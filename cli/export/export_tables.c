/* The tables of an export. Branches and junctions are the rows that `ricochet branches --json` and
 * `junctions --json` show; points come column by column, because there are many. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "export/export.h"

/* ----------------------------------------------------------------- columns */

/* An empty column for n entries; NULL without memory. */
static export_column *add_column(export_table *table, const char *name, export_kind kind, size_t n)
{
    export_column *c = table->n < EXPORT_MAX_COLUMN ? &table->columns[table->n] : NULL;
    if (!c) return NULL;
    *c = (export_column){.kind = kind, .n = n, .width = 1};
    snprintf(c->name, sizeof c->name, "%s", name);
    table->n++;
    c->reals = kind == EXPORT_REAL ? calloc(n + 1, sizeof *c->reals) : NULL;
    c->integers = kind == EXPORT_INTEGER ? calloc(n + 1, sizeof *c->integers) : NULL;
    c->texts = kind == EXPORT_TEXT ? calloc(n + 1, sizeof *c->texts) : NULL;
    return c->reals || c->integers || c->texts ? c : NULL;
}

void export_tables_free(export_table tables[EXPORT_N_TABLE])
{
    for (export_table *t = tables; t < tables + EXPORT_N_TABLE; t++)
        for (export_column *c = t->columns; c < t->columns + t->n; c++) {
            for (size_t i = 0; c->texts && i < c->n; i++) free(c->texts[i]);
            free(c->texts);
            free(c->reals);
            free(c->integers);
            free(c->counts);
        }
}

/* ------------------------------------------------------------ rows of JSON */

static void name_of(const char *key, const char *inner, size_t size, char *name)
{
    snprintf(name, size, "%s_%s", key, inner);
    for (char *c = name; *c; c++) *c = *c == '-' || *c == '.' ? '_' : *c;
}

/* Members of objects become values of the row, departures_taken, and those of a list of objects
 * lists, resonances_m; the keys of such lists in `lists`. */
static bool flatten(json_t *row, json_t *lists)
{
    json_t *flat = json_object();
    const char *key, *inner;
    json_t *value, *one, *member;
    size_t k;
    char name[64];
    json_object_foreach(row, key, value)
    {
        json_object_foreach(value, inner, member)
        {
            name_of(key, inner, sizeof name, name);
            json_object_set(flat, name, member);
        }
        json_array_foreach(value, k, one) json_object_foreach(one, inner, member)
        {
            name_of(key, inner, sizeof name, name);
            if (!json_object_get(flat, name)) json_object_set_new(flat, name, json_array());
            json_array_append(json_object_get(flat, name), member);
            json_object_set(lists, key, json_true());
        }
    }
    json_object_foreach(flat, key, value) json_object_set(row, key, value);
    const bool done = flat != NULL;
    json_decref(flat);
    return done;
}

typedef struct {
    bool text, array, real, integer, boolean;
    size_t n; /* entries in all rows */
} survey;

static void look(const json_t *value, survey *s)
{
    s->text |= json_is_string(value);
    s->real |= json_is_real(value);
    s->integer |= json_is_integer(value);
    s->boolean |= json_is_boolean(value);
}

static survey look_at(const json_t *rows, const char *key)
{
    survey s = {0};
    for (size_t i = 0; i < json_array_size(rows); i++) {
        const json_t *value = json_object_get(json_array_get(rows, i), key);
        look(value, &s);
        s.array |= json_is_array(value);
        for (size_t k = 0; k < json_array_size(value); k++) look(json_array_get(value, k), &s);
        s.n += json_array_size(value);
    }
    s.n = s.array ? s.n : json_array_size(rows);
    return s;
}

/* What is not there is NaN, an empty text, 0 of a number or an id, and -1 of what is yes (1) or no
 * (0). */
static bool set_entry(export_column *c, size_t i, const json_t *value, const survey *s)
{
    if (c->kind == EXPORT_REAL)
        c->reals[i] = json_is_number(value) ? json_number_value(value) : NAN;
    else if (c->kind == EXPORT_TEXT)
        c->texts[i] = strdup(json_is_string(value) ? json_string_value(value) : "");
    else if (s->boolean) c->integers[i] = json_is_boolean(value) ? json_is_true(value) : -1;
    else c->integers[i] = json_integer_value(value);
    return c->kind != EXPORT_TEXT || c->texts[i];
}

static bool fill(export_column *c, const json_t *rows, const char *key, const survey *s)
{
    size_t at = 0;
    for (size_t i = 0; i < json_array_size(rows); i++) {
        const json_t *value = json_object_get(json_array_get(rows, i), key);
        if (!s->array && !set_entry(c, at++, value, s)) return false;
        for (size_t k = 0; s->array && k < json_array_size(value); k++)
            if (!set_entry(c, at++, json_array_get(value, k), s)) return false;
        if (s->array) c->counts[i] = (int64_t)json_array_size(value);
    }
    return true;
}

static bool add_key(export_table *table, const json_t *rows, const char *key)
{
    for (int i = 0; i < table->n; i++)
        if (!strcmp(table->columns[i].name, key)) return true;
    const survey s = look_at(rows, key);
    export_column *c = add_column(table, key,
                                  s.text                    ? EXPORT_TEXT
                                  : s.integer && !s.real    ? EXPORT_INTEGER
                                  : s.boolean && !s.integer ? EXPORT_INTEGER
                                                            : EXPORT_REAL,
                                  s.n);
    if (c && s.array) c->counts = calloc(json_array_size(rows) + 1, sizeof *c->counts);
    return c && (!s.array || c->counts) && fill(c, rows, key, &s);
}

/* Every key of any row becomes a column, in the order in which they appear. */
static bool add_rows(export_table *table, json_t *rows)
{
    json_t *lists = json_object();
    bool done = lists != NULL;
    table->rows = json_array_size(rows);
    for (size_t i = 0; i < table->rows && done; i++) done = flatten(json_array_get(rows, i), lists);
    done = done && !cli_lost_memory();
    for (size_t i = 0; i < table->rows && done; i++) {
        const char *key;
        json_t *value, *row = json_array_get(rows, i);
        json_object_foreach(row, key, value)
        {
            if (json_is_object(value) || json_object_get(lists, key)) continue;
            if (!(done = add_key(table, rows, key))) break;
        }
    }
    json_decref(lists);
    return done;
}

/* ------------------------------------------------------------------ tables */

typedef ric_status (*row_maker)(const ric_atlas *atlas, int id, double d, json_t *row);

static ric_status make_listed(export_table *table, const ric_atlas *atlas, int n, row_maker make)
{
    json_t *rows = json_array();
    ric_status status = rows ? RIC_OK : RIC_E_NOMEM;
    for (int id = 1; !status && id <= n; id++) {
        json_t *row = json_object();
        status = row ? make(atlas, id, 1, row) : RIC_E_NOMEM;
        json_array_append_new(rows, row);
    }
    if (!status && !add_rows(table, rows)) status = RIC_E_NOMEM;
    json_decref(rows);
    return status;
}

static ric_status add_place(json_t *rows, const ric_branch *branch, int junction, double at,
                            const char *place)
{
    json_t *row = json_object();
    json_object_set_new(row, "branch", json_integer(branch->id));
    json_object_set_new(row, "junction", json_integer(junction));
    json_object_set_new(row, "arclength", cli_number(at));
    json_object_set_new(row, "place", json_string(place));
    return json_array_append_new(rows, row) ? RIC_E_NOMEM : RIC_OK;
}

static ric_status add_edge(const ric_atlas *atlas, int id, json_t *rows)
{
    ric_branch branch;
    ric_point first, last;
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    if (!status) status = ric_atlas_point(atlas, id, 0, &first, NULL, NULL);
    if (!status) status = ric_atlas_point(atlas, id, branch.n_point - 1, &last, NULL, NULL);
    if (!status && branch.from)
        status = add_place(rows, &branch, branch.from, first.arclength, "from");
    for (int i = 0; !status && i < branch.n_junction; i++)
        status = add_place(rows, &branch, branch.junctions[i], branch.junction_at[i], "inner");
    if (!status && branch.to) status = add_place(rows, &branch, branch.to, last.arclength, "to");
    return status;
}

/* Branches are the edges, junctions the nodes: one row for every junction on every branch. */
static ric_status make_graph(export_table *table, const ric_atlas *atlas)
{
    json_t *rows = json_array();
    ric_status status = rows ? RIC_OK : RIC_E_NOMEM;
    for (int id = 1; !status && id <= ric_atlas_n_branch(atlas); id++)
        status = add_edge(atlas, id, rows);
    if (!status && !add_rows(table, rows)) status = RIC_E_NOMEM;
    json_decref(rows);
    return status;
}

static ric_status make_about(export_table *table, const ric_atlas *atlas)
{
    const ric_model *model = ric_atlas_model(atlas);
    json_t *row = json_object(), *rows = json_array();
    json_object_set_new(row, "program", json_sprintf("ricochet %s", ric_version()));
    json_object_set_new(row, "n_dof", json_integer(ric_model_n_dof(model)));
    json_object_set_new(row, "length", json_real(ric_model_length(model)));
    const ric_units *units = ric_model_units(model);
    json_object_set_new(row, "unit_length", json_string(units->length));
    json_object_set_new(row, "unit_time", json_string(units->time));
    json_object_set_new(row, "unit_force", json_string(units->force));
    json_object_set_new(row, "finished", json_boolean(ric_atlas_finished(atlas)));
    json_array_append_new(rows, row);
    const bool done = add_rows(table, rows);
    json_decref(rows);
    return done ? RIC_OK : RIC_E_NOMEM;
}

/* ------------------------------------------------------------------ points */

static size_t count_points(const ric_atlas *atlas)
{
    size_t n = 0;
    ric_branch branch;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        if (!ric_atlas_branch(atlas, id, &branch)) n += (size_t)branch.n_point;
    return n;
}

/* One quantity of all points of all branches; the rows of one may be longer than those of the other
 * (flights). */
static ric_status add_quantity(export_table *table, const ric_atlas *atlas, const char *name,
                               bool ragged)
{
    ric_branch branch;
    ric_status status = RIC_OK;
    size_t n = 0, at = 0, row = 0;
    int width = 1;
    for (int id = 1; !status && id <= ric_atlas_n_branch(atlas); id++)
        if (!(status = ric_atlas_branch(atlas, id, &branch)) &&
            !(status = ric_atlas_column(atlas, id, name, &width, NULL)))
            n += (size_t)branch.n_point * (size_t)width;
    export_column *c = status ? NULL : add_column(table, name, EXPORT_REAL, n);
    if (c && ragged) c->counts = calloc(table->rows + 1, sizeof *c->counts);
    if (!status && (!c || (ragged && !c->counts))) return RIC_E_NOMEM;
    for (int id = 1; !status && id <= ric_atlas_n_branch(atlas); id++) {
        if ((status = ric_atlas_branch(atlas, id, &branch)) ||
            (status = ric_atlas_column(atlas, id, name, &width, c->reals + at)))
            break;
        at += (size_t)branch.n_point * (size_t)width;
        for (int i = 0; ragged && i < branch.n_point; i++) c->counts[row++] = width;
    }
    if (c && !ragged) c->width = (size_t)width;
    return status;
}

static ric_status add_numbering(export_table *table, const ric_atlas *atlas)
{
    ric_branch branch;
    size_t at = 0;
    export_column *of = add_column(table, "branch", EXPORT_INTEGER, table->rows),
                  *point = of ? add_column(table, "point", EXPORT_INTEGER, table->rows) : NULL;
    for (int id = 1; point && id <= ric_atlas_n_branch(atlas); id++)
        for (int i = 0; !ric_atlas_branch(atlas, id, &branch) && i < branch.n_point; i++, at++) {
            of->integers[at] = id;
            point->integers[at] = i;
        }
    return point ? RIC_OK : RIC_E_NOMEM;
}

static ric_status make_points(export_table *table, const ric_atlas *atlas)
{
    const ric_table *all = &ric_table_point;
    table->rows = count_points(atlas);
    ric_status status = add_numbering(table, atlas);
    for (const ric_column *c = all->column; !status && c < all->column + all->n; c++) {
        const bool vector = c->type == RIC_COLUMN_STATE || c->type == RIC_COLUMN_FLIGHTS;
        if (c->type == RIC_COLUMN_PLACE || !(vector || c->flags & RIC_LISTED)) continue;
        status = add_quantity(table, atlas, c->name, c->type == RIC_COLUMN_FLIGHTS);
    }
    return status;
}

ric_status export_tables_make(const ric_atlas *atlas, export_table tables[EXPORT_N_TABLE])
{
    static const char *const names[EXPORT_N_TABLE] = {"about", "branches", "points", "junctions",
                                                      "graph"};
    for (int i = 0; i < EXPORT_N_TABLE; i++) tables[i].name = names[i];
    ric_status status = make_about(&tables[0], atlas);
    if (!status) status = make_listed(&tables[1], atlas, ric_atlas_n_branch(atlas), cli_branch_row);
    if (!status) status = make_points(&tables[2], atlas);
    if (!status)
        status = make_listed(&tables[3], atlas, ric_atlas_n_junction(atlas), cli_junction_row);
    return status ? status : make_graph(&tables[4], atlas);
}
