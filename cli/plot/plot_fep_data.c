/* Energies and frequencies of one's own in the frequency-energy picture: --data FILE.csv. */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "plot_fep.h"

enum { LINE_MOST = 4096, POINTS_MOST = 1000000 };

/* Field `column` of a line, without blanks and quotation marks around it; false if the line ends before. */
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

static bool add_point(fep *f, plot_point data)
{
    if (f->n_data == f->data_room) {
        const int room = f->data_room ? 2 * f->data_room : 256;
        plot_point *more = realloc(f->data, (size_t)room * sizeof *more);
        if (!more) return false;
        f->data = more;
        f->data_room = room;
    }
    f->data[f->n_data++] = data;
    return true;
}

static bool read_number(const char *line, int column, double *out)
{
    char text[64], *end;
    if (!field(line, column, sizeof text, text) || !*text) return false;
    *out = strtod(text, &end);
    return !*end && isfinite(*out);
}

static int read_rows(fep *f, FILE *file, const char *path)
{
    const plot_units unit = plot_units_of(f->options->common, f->sources[0].model);
    char line[LINE_MOST];
    int energy = -1, frequency = -1;
    for (int row = 1; fgets(line, sizeof line, file); row++) {
        const char *text = row == 1 && !strncmp(line, "\xef\xbb\xbf", 3) ? line + 3 : line; /* a byte order mark */
        plot_point p;
        if (!strchr(line, '\n') && !feof(file)) return cli_wrong("%s:%d: this line is too long", path, row);
        if (*text == '#' || strspn(text, " \t\r\n") == strlen(text)) continue;
        if (energy < 0) {
            energy = find_column(text, "energy");
            frequency = find_column(text, "frequency");
            if (energy < 0 || frequency < 0)
                return cli_wrong("%s:%d: the first line names the columns, energy and frequency among them, with "
                                 "commas between",
                                 path, row);
            continue;
        }
        if (!read_number(text, energy, &p.x) || !read_number(text, frequency, &p.y) || p.x < 0 || p.y <= 0)
            return cli_wrong("%s:%d: an energy from 0 on and a frequency above 0 are needed, as numbers", path, row);
        if (f->n_data == POINTS_MOST) return cli_wrong("%s:%d: more than %d points", path, row, POINTS_MOST);
        if (!add_point(f, (plot_point){p.x / unit.energy, p.y / unit.frequency})) return cli_report(RIC_E_NOMEM);
    }
    if (ferror(file)) return cli_wrong("%s: %s", path, strerror(errno));
    return f->n_data ? CLI_DONE : cli_wrong("%s: there are no points in it", path);
}

int fep_read_data(fep *f)
{
    const char *path = f->options->data;
    if (!path) return CLI_DONE;
    FILE *file = fopen(path, "r");
    if (!file) return cli_wrong("--data %s: %s", path, strerror(errno));
    const int code = read_rows(f, file, path);
    fclose(file);
    const char *slash = strrchr(path, '/');
    plot_text_escape(slash ? slash + 1 : path, sizeof f->data_name, f->data_name);
    return code;
}

/* Dots: lines without length, with their round ends. */
void fep_draw_data(fep *f)
{
    for (int i = 0; i < f->n_data; i++) {
        if (!plot_panel_inside(f->panel, f->data[i])) continue;
        const plot_point at = plot_panel_at(f->panel, f->data[i]);
        plot_page_line(f->page, PLOT_DATA, 2, (plot_point[]){at, {at.x + 0.02, at.y}});
    }
}
