/* Rows on standard output: JSON for programs, CSV for tables, aligned text for people. */
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "cli.h"

/* jansson leaves out what it finds no memory for, and so do the values made here. That is
 * remembered, so that no list is shown with something missing. */
static _Thread_local bool lost;

static void *allocate(size_t size)
{
    void *memory = malloc(size);
    lost |= !memory;
    return memory;
}

json_t *cli_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *cli_numbers(int n, const double *values, double unit)
{
    json_t *list = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(list, cli_number(unit * values[i]));
    return list;
}

json_t *cli_pairs(int n, const double *values)
{
    json_t *list = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(list, cli_numbers(2, values + 2 * i, 1));
    return list;
}

const char *cli_stability(ric_stability stable)
{
    return stable == RIC_STABLE_YES ? "yes" : stable == RIC_STABLE_NO ? "no" : "undecided";
}

json_t *cli_word(const ric_model *model, int n, const int *word)
{
    size_t size = 12 * (size_t)n + 1;
    char *text = allocate(size);
    json_t *value = text && !ric_word_format(model, n, word, size, text) ? json_string(text) : NULL;
    free(text);
    return value;
}

json_t *cli_id(int id)
{
    return id ? json_integer(id) : json_null();
}

json_t *cli_integers(int n, const int *values)
{
    json_t *array = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(array, json_integer(values[i]));
    return array;
}

json_t *cli_duplicate_label(const ric_branch *branch, int k)
{
    size_t size = strlen(branch->label) + 16;
    char *text = allocate(size);
    json_t *value = text && !ric_duplicate_label(branch, k, size, text) ? json_string(text) : NULL;
    free(text);
    return value;
}

/* ------------------------------------------------------------------- cells */

/* A growing text; `failed` once memory has run out. */
typedef struct {
    char *text;
    size_t n, size;
    bool failed;
} buffer;

static void add_text(buffer *b, const char *text)
{
    size_t n = strlen(text);
    if (!b->failed && b->n + n + 1 > b->size) {
        size_t size = 2 * (b->n + n + 32);
        char *larger = realloc(b->text, size);
        b->failed = !larger;
        b->text = larger ? larger : b->text;
        b->size = larger ? size : b->size;
    }
    if (b->failed) return;
    memcpy(b->text + b->n, text, n + 1);
    b->n += n;
}

static void add_value(buffer *b, const json_t *value, cli_format format);

/* Members one after the other with blanks between; those of an object with their names. */
static void add_members(buffer *b, const json_t *value, cli_format format)
{
    const char *key;
    json_t *member;
    size_t i;
    bool first = true;
    if (json_is_array(value)) {
        json_array_foreach(value, i, member)
        {
            add_text(b, first ? "" : " ");
            add_text(b, json_is_null(member) ? "null" : "");
            add_value(b, member, format);
            first = false;
        }
        return;
    }
    json_object_foreach((json_t *)(uintptr_t)value, key, member)
    { /* Jansson asks for one that may change and leaves it as it
       * is */
        add_text(b, first ? "" : " ");
        add_text(b, key);
        add_text(b, "=");
        add_value(b, member, format);
        first = false;
    }
}

static void add_value(buffer *b, const json_t *value, cli_format format)
{
    char number[40];
    switch (value ? json_typeof(value) : JSON_NULL) {
    case JSON_OBJECT:
    case JSON_ARRAY: add_members(b, value, format); break;
    case JSON_STRING: add_text(b, json_string_value(value)); break;
    case JSON_INTEGER:
        snprintf(number, sizeof number, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
        add_text(b, number);
        break;
    case JSON_REAL: /* 17 digits name every double, 12 can be read, 7 have room */
        snprintf(number, sizeof number,
                 format == CLI_CSV     ? "%.17g"
                 : format == CLI_SHORT ? "%.7g"
                                       : "%.12g",
                 json_real_value(value));
        add_text(b, number);
        break;
    case JSON_TRUE: add_text(b, format == CLI_CSV ? "true" : "yes"); break;
    case JSON_FALSE: add_text(b, format == CLI_CSV ? "false" : "no"); break;
    case JSON_NULL: break;
    }
}

/* NULL without memory. */
static char *cell_text(const json_t *row, const char *column, cli_format format)
{
    buffer b = {0};
    add_text(&b, "");
    add_value(&b, json_object_get(row, column), format);
    if (b.failed) {
        free(b.text);
        return NULL;
    }
    return b.text;
}

/* -------------------------------------------------------------------- JSON */

/* One row per line. */
static bool print_json(const json_t *rows)
{
    const size_t plain = isatty(STDOUT_FILENO) ? JSON_ENSURE_ASCII
                                               : 0; /* some characters steer a terminal */
    size_t i, n = json_array_size(rows);
    if (n == 0) return puts("[]") >= 0;
    for (i = 0; i < n; i++) {
        fputs(i ? ",\n " : "[\n ", stdout);
        if (json_dumpf(json_array_get(rows, i), stdout, JSON_REAL_PRECISION(17) | plain))
            return false;
    }
    return puts("\n]") >= 0;
}

/* --------------------------------------------------------------------- CSV */

/* RFC 4180: a cell with a comma, a quote or a line break is quoted, its quotes are doubled. */
static void print_csv_cell(const char *text)
{
    if (!strpbrk(text, ",\"\r\n")) {
        fputs(text, stdout);
        return;
    }
    putchar('"');
    for (; *text; text++) {
        if (*text == '"') putchar('"');
        putchar(*text);
    }
    putchar('"');
}

/* As it is in a file; on a terminal, without what would steer it. */
static char *csv_text(const json_t *row, const char *column)
{
    char *text = cell_text(row, column, CLI_CSV);
    if (!text || !isatty(STDOUT_FILENO)) return text;
    char *visible = cli_visible(text, true);
    free(text);
    return visible;
}

static bool print_csv(const json_t *rows, const char *const *columns)
{
    const json_t *row;
    size_t i;
    for (size_t k = 0; columns[k]; k++) {
        fputs(k ? "," : "", stdout);
        print_csv_cell(columns[k]);
    }
    putchar('\n');
    json_array_foreach(rows, i, row)
    {
        for (size_t k = 0; columns[k]; k++) {
            char *text = csv_text(row, columns[k]);
            if (!text) return false;
            fputs(k ? "," : "", stdout);
            print_csv_cell(text);
            free(text);
        }
        putchar('\n');
    }
    return true;
}

/* -------------------------------------------------------------------- text */

/* Characters, not bytes, of UTF-8. */
static int width_of(const char *text)
{
    int n = 0;
    for (; *text; text++) n += ((unsigned char)*text & 0xc0) != 0x80;
    return n;
}

static void print_padded(const char *text, int width, bool right, bool last)
{
    int blanks = width - width_of(text);
    printf("%*s%s%*s", right && blanks > 0 ? blanks : 0, "", text,
           !right && !last && blanks > 0 ? blanks : 0, "");
    fputs(last ? "\n" : "  ", stdout);
}

/* Numbers stand to the right; a column of nothing but nulls counts as one. */
static bool is_numeric(const json_t *rows, const char *column)
{
    const json_t *row;
    size_t i;
    json_array_foreach(rows, i, row)
    {
        const json_t *value = json_object_get(row, column);
        if (value && !json_is_number(value) && !json_is_null(value)) return false;
    }
    return true;
}

static const char *shown(const char *text)
{
    return *text ? text : "-";
}

/* A table of text: cells row by row, and what each column takes. */
typedef struct {
    size_t n_row, n_column;
    const char *const *columns;
    char **cells;
    int *width;
    bool *numeric, *hidden; /* hidden: there is no room for the column */
    bool cut;               /* a list is longer than what is shown of it */
} grid;

static void free_grid(grid *t)
{
    for (size_t i = 0; t->cells && i < t->n_row * t->n_column; i++) free(t->cells[i]);
    free(t->cells);
    free(t->width);
    free(t->numeric);
    free(t->hidden);
}

/* What does not fit into `most` columns ends in three dots. */
static void shorten(char *text, int most)
{
    if (width_of(text) <= most) return;
    char *end = text;
    for (int n = 0; *end && (n < most - 3 || ((unsigned char)*end & 0xc0) == 0x80); end++)
        n += (((unsigned char)end[1] & 0xc0) != 0x80);
    memcpy(end, "...", 4);
}

enum {
    LIST_MOST = 160
}; /* characters of a list in a table: a state of a dozen numbers; there are lists of thousands */

/* Cuts a list that is too long for a line behind one of its members, and says how many there are.
 */
static void cut_list(grid *t, const json_t *value, char *text)
{
    char tail[40];
    if (!json_is_array(value) || strlen(text) <= LIST_MOST) return;
    snprintf(tail, sizeof tail, " ... (%zu in all)", json_array_size(value));
    size_t end = LIST_MOST - strlen(tail);
    while (end > 1 && text[end] != ' ') end--;
    strcpy(text + end, tail); /* shorter than what stood there */
    t->cut = true;
}

/* Sets all cells, texts of at most `most` columns; false without memory. */
static bool fill_grid(grid *t, const json_t *rows, cli_format format, int most)
{
    for (size_t k = 0; k < t->n_column; k++) {
        t->width[k] = width_of(t->columns[k]);
        t->numeric[k] = is_numeric(rows, t->columns[k]);
        for (size_t i = 0; i < t->n_row; i++) {
            char *cell = cell_text(json_array_get(rows, i), t->columns[k], format),
                 **at = &t->cells[i * t->n_column + k];
            free(*at);
            *at = cell ? cli_visible(cell, false) : NULL;
            free(cell);
            if (!*at) return false;
            cut_list(t, json_object_get(json_array_get(rows, i), t->columns[k]), *at);
            if (!t->numeric[k]) shorten(*at, most);
            t->width[k] = width_of(shown(*at)) > t->width[k] ? width_of(shown(*at)) : t->width[k];
        }
    }
    return true;
}

static bool fits(const grid *t, int room)
{
    int used = -2;
    for (size_t k = 0; k < t->n_column; k++)
        if (!t->hidden[k]) used += t->width[k] + 2;
    return used <= room;
}

static bool hide(grid *t, const char *name)
{
    for (size_t k = 0; k < t->n_column; k++)
        if (!t->hidden[k] && !strcmp(t->columns[k], name)) return t->hidden[k] = true;
    return false;
}

/* Leaves out columns until a line fits: first those that are missed least, then from the end. */
static void hide_columns(grid *t, int room)
{
    static const char *const spare[] = {"symmetric", "reversible", "junctions", "depth",
                                        "name",      "grazings",   "multiple",  "branches",
                                        "rotation",  "points",     "arclength", "residual",
                                        "approach",  "period",     "reach",     "stop",
                                        "to",        "from",       "impacts",   "stable_fraction",
                                        "key"};
    for (size_t i = 0; i < sizeof spare / sizeof *spare && !fits(t, room); i++) hide(t, spare[i]);
    for (size_t k = t->n_column; k-- > 1 && !fits(t, room);) t->hidden[k] = true;
}

/* The columns of the terminal; INT_MAX where there is none, or none that says so. */
static int room_of_terminal(void)
{
    struct winsize size;
    return isatty(STDOUT_FILENO) && !ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) && size.ws_col
               ? size.ws_col
               : INT_MAX;
}

static void say_hidden(const grid *t)
{
    int n = 0;
    for (size_t k = 0; k < t->n_column; k++)
        if (t->hidden[k])
            fprintf(stderr, "%s %s", n++ ? "," : "ricochet: no room for", t->columns[k]);
    if (n) fputs("; a wider terminal, --csv or --json shows them\n", stderr);
}

/* The cells of row i; the names of the columns where i is n_row. */
static void print_line(const grid *t, size_t i)
{
    size_t last = t->n_column;
    while (last > 0 && t->hidden[last - 1]) last--;
    for (size_t k = 0; k < last; k++)
        if (!t->hidden[k])
            print_padded(i < t->n_row ? shown(t->cells[i * t->n_column + k]) : t->columns[k],
                         t->width[k], t->numeric[k], k + 1 == last);
}

/* A line that is broken by the terminal cannot be read: there, numbers are shortened first, then
 * texts, and what still has no room is named. */
static bool print_table(const json_t *rows, const char *const *columns)
{
    enum { LONGEST = 20 }; /* columns of a text where room is shortest */
    const int room = room_of_terminal();
    grid t = {.n_row = json_array_size(rows), .columns = columns};
    while (columns[t.n_column]) t.n_column++;
    t.cells = calloc(t.n_row * t.n_column + 1, sizeof *t.cells);
    t.width = calloc(t.n_column + 1, sizeof *t.width);
    t.numeric = calloc(t.n_column + 1, sizeof *t.numeric);
    t.hidden = calloc(t.n_column + 1, sizeof *t.hidden);
    bool done = t.cells && t.width && t.numeric && t.hidden &&
                fill_grid(&t, rows, CLI_TEXT, INT_MAX);
    if (done && !fits(&t, room)) done = fill_grid(&t, rows, CLI_SHORT, INT_MAX);
    for (int most = LIST_MOST / 2; done && most >= LONGEST && !fits(&t, room); most /= 2)
        done = fill_grid(&t, rows, CLI_SHORT, most);
    if (done) {
        hide_columns(&t, room);
        print_line(&t, t.n_row);
        for (size_t i = 0; i < t.n_row; i++) print_line(&t, i);
        say_hidden(&t);
        if (t.cut)
            fputs("ricochet: long lists are cut; --csv or --json shows all of them\n", stderr);
    }
    free_grid(&t);
    return done;
}

void cli_watch_memory(void)
{
    json_set_alloc_funcs(allocate, free);
}

bool cli_lost_memory(void)
{
    bool was = lost;
    lost = false;
    return was;
}

/* The names of the columns of CSV and text, NULL behind the last: those of a text that is cut, or
 * of the first row. */
static const char **split(char *text, const json_t *rows)
{
    const json_t *first = json_array_get(rows, 0);
    const char **names = calloc((text ? strlen(text) : json_object_size(first)) + 1, sizeof *names),
               *key;
    json_t *value;
    size_t n = 0;
    if (!names) return NULL;
    if (text)
        for (char *rest = NULL, *name = strtok_r(text, " ", &rest); name;
             name = strtok_r(NULL, " ", &rest))
            names[n++] = name;
    else json_object_foreach((json_t *)(uintptr_t)first, key, value) names[n++] = key;
    return names;
}

/* -------------------------------------------------------------------- wide */

/* Rows and columns in which every number of a list has a column of its own. */
typedef struct {
    json_t *rows; /* new ones */
    buffer names;
} spread;

static void add_name(spread *s, const char *name)
{
    add_text(&s->names, s->names.n ? " " : "");
    add_text(&s->names, name);
}

/* Number i of n in a column: x2, v1 of a state, else `flights_2`; of a pair, multipliers_1_re. */
static void name_number(const char *column, size_t i, size_t n, const char *part, size_t size,
                        char *out)
{
    const size_t half = n / 2;
    if (!strcmp(column, "state")) snprintf(out, size, "%c%zu", i < half ? 'x' : 'v', i % half + 1);
    else snprintf(out, size, "%s_%zu%s", column, i + 1, part);
}

static void spread_list(spread *s, const json_t *rows, const char *column, size_t n, bool pairs)
{
    char name[120];
    for (size_t k = 0; k < (pairs ? 2 * n : n); k++) {
        const size_t i = pairs ? k / 2 : k, row_count = json_array_size(rows);
        name_number(column, i, n, !pairs ? "" : k % 2 ? "_im" : "_re", sizeof name, name);
        add_name(s, name);
        for (size_t r = 0; r < row_count; r++) {
            json_t *value = json_array_get(json_object_get(json_array_get(rows, r), column), i);
            json_object_set(json_array_get(s->rows, r), name,
                            pairs ? json_array_get(value, k % 2) : value);
        }
    }
}

/* Members of one sort, `taken` and so on: they have names. */
static void spread_object(spread *s, const json_t *rows, const char *column, json_t *all)
{
    char name[120];
    const char *key;
    json_t *value;
    json_object_foreach(all, key, value)
    {
        snprintf(name, sizeof name, "%s_%s", column, key);
        add_name(s, name);
        for (size_t r = 0, n = json_array_size(rows); r < n; r++)
            json_object_set(json_array_get(s->rows, r), name,
                            json_object_get(json_object_get(json_array_get(rows, r), column), key));
    }
}

static void spread_column(spread *s, const json_t *rows, const char *column)
{
    const json_t *row;
    json_t *all = json_object(); /* all names that members have, in any row */
    size_t i, most = 0;
    bool pairs = false;
    json_array_foreach(rows, i, row)
    {
        json_t *value = json_object_get(row, column);
        if (json_array_size(value) > most) most = json_array_size(value);
        if (json_is_object(value)) json_object_update_missing(all, value);
        pairs = pairs || json_is_array(json_array_get(value, 0));
    }
    if (most) spread_list(s, rows, column, most, pairs);
    else if (json_object_size(all)) spread_object(s, rows, column, all);
    else {
        add_name(s, column);
        json_array_foreach(rows, i, row)
            json_object_set(json_array_get(s->rows, i), column, json_object_get(row, column));
    }
    json_decref(all);
}

/* As CSV, with those columns. */
static bool print_wide(const json_t *rows, const char *const *columns)
{
    spread s = {.rows = json_array()};
    for (size_t i = 0, n = json_array_size(rows); i < n; i++)
        json_array_append_new(s.rows, json_object());
    add_text(&s.names, "");
    for (size_t k = 0; columns[k]; k++) spread_column(&s, rows, columns[k]);
    bool done = !s.names.failed && !cli_lost_memory();
    const char **names = done ? split(s.names.text, s.rows) : NULL;
    done = names && print_csv(s.rows, names);
    free(names);
    free(s.names.text);
    json_decref(s.rows);
    return done;
}

static bool print_rows(const json_t *rows, const char *columns, cli_format format)
{
    if (format == CLI_JSON) return print_json(rows);
    char *text = columns ? strdup(columns) : NULL;
    const char **names = text || !columns ? split(text, rows) : NULL;
    const bool done = names && (format == CLI_CSV    ? print_csv(rows, names)
                                : format == CLI_WIDE ? print_wide(rows, names)
                                                     : print_table(rows, names));
    free(names);
    free(text);
    return done;
}

int cli_print_rows(const json_t *rows, const char *columns, cli_format format)
{
    bool done = !cli_lost_memory() && print_rows(rows, columns, format);
    errno = 0;
    if (!done && !ferror(stdout)) {
        fputs("ricochet: out of memory\n", stderr);
        return CLI_FAILED;
    }
    if (fflush(stdout) || ferror(stdout)) {
        fprintf(stderr, "ricochet: the output cannot be written: %s\n",
                errno ? strerror(errno) : "write error");
        return CLI_FAILED;
    }
    return CLI_DONE;
}

/* -------------------------------------------------------- rows of a table */

static double scale_of(ric_unit unit, double d)
{
    switch (unit) {
    case RIC_UNIT_ENERGY: return cli_unit_of_energies(d);
    case RIC_UNIT_SPEED:
    case RIC_UNIT_STATE: return d;
    default: return 1;
    }
}

static json_t *value_of(const ric_column *c, const void *row, const ric_model *model, double d)
{
    const void *at = (const char *)row + c->offset;
    const double number = ric_column_number(c, row), scale = scale_of(c->unit, d);
    const size_t count = (size_t)ric_column_count(c, row),
                 width = ric_column_width(c, row, ric_model_n_dof(model));
    switch (c->type) {
    case RIC_COLUMN_FLAG: return json_boolean(*(const bool *)at);
    case RIC_COLUMN_MODE:
    case RIC_COLUMN_JUNCTION: return cli_id(*(const int *)at);
    case RIC_COLUMN_REAL:
    case RIC_COLUMN_MAYBE:
    case RIC_COLUMN_SINGLE:
    case RIC_COLUMN_DERIVED:
        return cli_number(c->unit == RIC_UNIT_ONSET ? number / ric_model_onset(model, NULL)
                                                    : scale * number);
    case RIC_COLUMN_TEXT: return json_string(*(const char *const *)at);
    case RIC_COLUMN_WORD: return cli_word(model, (int)count, *(const int *const *)at);
    case RIC_COLUMN_STOP: return json_string(ric_stop_text(*(const ric_stop *)at));
    case RIC_COLUMN_KIND: return json_string(ric_kind_text(*(const ric_kind *)at));
    case RIC_COLUMN_STATE:
    case RIC_COLUMN_FLIGHTS: return cli_numbers((int)width, *(const double *const *)at, scale);
    case RIC_COLUMN_INTEGERS: return cli_integers((int)count, *(const int *const *)at);
    case RIC_COLUMN_NUMBERS: return cli_numbers((int)count, *(const double *const *)at, scale);
    default: return json_integer(*(const int *)at);
    }
}

static const char *name_of(const ric_column *c)
{
    return c->listed ? c->listed : c->name;
}

void cli_table_row(const ric_table *table, const void *row, const ric_model *model, double d,
                   json_t *(*made)(const ric_column *column, const void *row), json_t *out)
{
    const ric_column *c;
    for (int k = 0; (c = ric_column_listed(table, k)); k++)
        json_object_set_new(out, name_of(c),
                            c->flags & RIC_MADE ? made(c, row) : value_of(c, row, model, d));
}

char *cli_table_names(const ric_table *table, cli_format format)
{
    const unsigned shown = format == CLI_TEXT ? RIC_IN_TABLE : RIC_LISTED;
    const ric_column *c;
    buffer b = {0};
    for (int k = 0; (c = ric_column_listed(table, k)); k++)
        if ((c->flags & shown) == shown) {
            add_text(&b, b.n ? " " : "");
            add_text(&b, name_of(c));
        }
    if (b.failed) free(b.text);
    return b.failed ? NULL : b.text;
}
