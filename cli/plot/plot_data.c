/* Numbers of one's own for a picture, out of a CSV file: --data FILE.csv. */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "plot.h"

enum { LINE_MOST = 4096, ROWS_MOST = 1000000 };

/* Field `column` of a line, without blanks and quotation marks around it; false if the line ends
 * before. */
static bool field(const char *line, int column, size_t size, char *out)
{
    for (; column > 0; column--) {
        line += strcspn(line, ",");
        if (*line++ != ',') return false;
    }
    size_t n = strcspn(line, ",\r\n");
    while (n && strchr(" \t\"", *line)) {
        line++;
        n--;
    }
    while (n && strchr(" \t\"", line[n - 1])) n--;
    if (n >= size) return false;
    memcpy(out, line, n);
    out[n] = '\0';
    return true;
}

/* Which column has a name, -1 for none; letters of either case. */
static int find_column(const char *line, const char *name)
{
    char text[64];
    int columns = 1;
    for (const char *c = line; *c; c++) columns += *c == ',';
    for (int i = 0; i < columns; i++)
        if (field(line, i, sizeof text, text) && !strcasecmp(text, name)) return i;
    return -1;
}

static bool read_number(const char *line, int column, double *out)
{
    char text[64], *end;
    if (!field(line, column, sizeof text, text) || !*text) return false;
    *out = strtod(text, &end);
    return !*end && isfinite(*out);
}

static bool add_row(plot_table *t, int line, const double *values)
{
    if (t->n == t->room) {
        const int room = t->room ? 2 * t->room : 256;
        double *more = realloc(t->values, (size_t)room * (size_t)t->n_column * sizeof *more);
        if (!more) return false;
        t->values = more;
        int *lines = realloc(t->lines, (size_t)room * sizeof *lines);
        if (!lines) return false;
        t->lines = lines;
        t->room = room;
    }
    memcpy(t->values + (size_t)t->n * (size_t)t->n_column, values,
           (size_t)t->n_column * sizeof *values);
    t->lines[t->n++] = line;
    return true;
}

/* The line that names the columns: where each of those asked for stands. */
static int find_columns(const char *path, int row, const char *text, const char *const *names,
                        int needed, const plot_table *t, int *columns)
{
    char wanted[200] = "";
    for (int i = 0; i < t->n_column; i++) columns[i] = find_column(text, names[i]);
    for (int i = 0; i < needed; i++)
        snprintf(wanted + strlen(wanted), sizeof wanted - strlen(wanted), "%s%s", i ? " and " : "",
                 names[i]);
    for (int i = 0; i < needed; i++)
        if (columns[i] < 0)
            return cli_wrong(
                "%s:%d: the first line names the columns, %s among them, with commas between", path,
                row, wanted);
    return CLI_DONE;
}

static int read_rows(FILE *file, const char *path, const char *const *names, int needed,
                     plot_table *t, int *columns, double *values)
{
    char line[LINE_MOST];
    bool named = false;
    for (int row = 1; fgets(line, sizeof line, file); row++) {
        const char *text = row == 1 && !strncmp(line, "\xef\xbb\xbf", 3)
                               ? line + 3
                               : line; /* a byte order mark */
        if (!strchr(line, '\n') && !feof(file))
            return cli_wrong("%s:%d: this line is too long", path, row);
        if (*text == '#' || strspn(text, " \t\r\n") == strlen(text)) continue;
        if (!named) {
            const int code = find_columns(path, row, text, names, needed, t, columns);
            if (code != CLI_DONE) return code;
            named = true;
            continue;
        }
        for (int i = 0; i < t->n_column; i++) {
            values[i] = NAN;
            if (columns[i] >= 0 && !read_number(text, columns[i], &values[i]) && i < needed)
                return cli_wrong("%s:%d: the %s is not a number", path, row, names[i]);
        }
        if (t->n == ROWS_MOST) return cli_wrong("%s:%d: more than %d points", path, row, ROWS_MOST);
        if (!add_row(t, row, values)) return cli_report(RIC_E_NOMEM);
    }
    if (ferror(file)) return cli_wrong("%s: %s", path, strerror(errno));
    return t->n ? CLI_DONE : cli_wrong("%s: there are no points in it", path);
}

int plot_table_read(const char *path, int n, const char *const *names, int needed, plot_table *out)
{
    *out = (plot_table){.n_column = n};
    FILE *file = fopen(path, "r");
    if (!file) return cli_wrong("--data %s: %s", path, strerror(errno));
    int *columns = calloc((size_t)n, sizeof *columns);
    double *values = calloc((size_t)n, sizeof *values);
    const int code = columns && values ? read_rows(file, path, names, needed, out, columns, values)
                                       : cli_report(RIC_E_NOMEM);
    fclose(file);
    free(columns);
    free(values);
    const char *slash = strrchr(path, '/');
    plot_text_escape(slash ? slash + 1 : path, sizeof out->name, out->name);
    return code;
}

double plot_table_at(const plot_table *table, int row, int column)
{
    return table->values[(size_t)row * (size_t)table->n_column + (size_t)column];
}

void plot_table_free(plot_table *table)
{
    free(table->values);
    free(table->lines);
    *table = (plot_table){0};
}

/* A line without length, with its round ends. */
void plot_panel_dot(plot_page *page, const plot_panel *panel, plot_stroke stroke, plot_point data)
{
    if (isnan(data.x + data.y) || !plot_panel_inside(panel, data)) return;
    const plot_point at = plot_panel_at(panel, data);
    plot_page_line(page, stroke, 2, (plot_point[]){at, {at.x + 0.02, at.y}});
}
