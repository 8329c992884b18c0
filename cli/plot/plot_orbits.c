/* Several orbits in one figure: a row for each with its displacements over time, impacts and touches, and phase
 * portraits; or histories only, in columns. Orbits come from one or more atlases. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

enum { MAX_ORBIT = 40, MAX_SHOWN = 4 };
static const double type = 12;

typedef struct {
    plot_choice choice;
    const char *text; /* as it was asked for */
    int atlas;
} panel;

typedef struct {
    const plot_options *common;
    plot_atlases from;
    int n;
    panel panels[MAX_ORBIT];
    bool histories; /* no phase portraits */
    bool same;      /* the same axes in all rows */
    long columns;
    int n_shown, shown[MAX_SHOWN];
    plot_page *page;
} figure;

/* ------------------------------------------------------------------ request */

static bool take_coordinates(figure *f, const char *text)
{
    const int n_dof = ric_model_n_dof(ric_atlas_model(f->from.atlas[0]));
    f->n_shown = 0;
    for (const char *c = text; c && *c; c += strspn(c, ",")) {
        char item[24];
        long index;
        const size_t n = strcspn(c, ",");
        snprintf(item, sizeof item, "%.*s", (int)(n < 20 ? n : 20), c);
        if (f->n_shown == MAX_SHOWN) {
            cli_wrong("--coordinates %s: at most %d fit", text, MAX_SHOWN);
            return false;
        }
        if (!cli_parse_integer(item, "--coordinates", 1, n_dof, &index)) return false;
        f->shown[f->n_shown++] = (int)index - 1;
        c += n;
    }
    for (int i = 0; !text && i < n_dof && i < 2; i++) f->shown[f->n_shown++] = i;
    return f->n_shown > 0 || (cli_wrong("--coordinates %s: which?", text), false);
}

static int take_orbits(int argc, char **argv, figure *f)
{
    plot_listed values[MAX_ORBIT];
    const int code = plot_take_listed(argc, argv, "--orbit", &f->from, MAX_ORBIT, &f->n, values);
    for (int i = 0; i < f->n; i++) f->panels[i] = (panel){.text = values[i].text, .atlas = values[i].atlas};
    if (code != CLI_DONE) return code;
    if (f->n == 0)
        return cli_wrong("plot orbits: --orbit SPEC is missing: a junction, or BRANCH@PLACE; see ricochet plot --help");
    for (int i = 0; i < f->n; i++)
        if (f->panels[i].atlas < 0 && f->from.n > 1)
            return cli_wrong("--orbit %s: with several atlases an orbit stands behind the one that it belongs to",
                             f->panels[i].text);
    return CLI_DONE;
}

static int load(figure *f)
{
    const int read = plot_atlases_read(&f->from);
    if (read != CLI_DONE) return read;
    if (!plot_same_length(f->common, f->from.n, f->from.atlas)) return CLI_WRONG;
    for (int i = 1; i < f->from.n; i++)
        if (ric_model_n_dof(ric_atlas_model(f->from.atlas[i])) != ric_model_n_dof(ric_atlas_model(f->from.atlas[0])))
            return cli_wrong("plot orbits: the models have different numbers of coordinates");
    for (int i = 0; i < f->n; i++) {
        panel *p = &f->panels[i];
        const int code = plot_choose(f->from.atlas[p->atlas < 0 ? 0 : p->atlas], p->text, "--orbit", &p->choice);
        if (code != CLI_DONE) return code;
        const ric_status status = plot_motion_make(&p->choice.motion);
        if (status != RIC_OK) return cli_report(status);
    }
    return CLI_DONE;
}

/* ------------------------------------------------------------------ drawing */

static plot_axis axis_over(double lo, double hi, double from, double to)
{
    return (plot_axis){.scale = PLOT_SCALE_LINEAR, .lo = lo, .hi = hi, .from = from, .to = to};
}

/* Ranges of displacements and speeds: of one panel, or of all. */
static void ranges(const figure *f, int only, int coordinate, double x[2], double v[2])
{
    x[0] = v[0] = INFINITY;
    x[1] = v[1] = -INFINITY;
    for (int i = 0; i < f->n; i++)
        for (int k = 0; k < f->n_shown; k++) {
            if ((i != only && !f->same) || (coordinate >= 0 && f->shown[k] != coordinate)) continue;
            plot_motion_range(&f->panels[i].choice.motion, plot_read_x, f->shown[k], &x[0], &x[1]);
            plot_motion_range(&f->panels[i].choice.motion, plot_read_v, f->shown[k], &v[0], &v[1]);
        }
    plot_range_widen(false, 0.08, &x[0], &x[1]);
    plot_range_widen(false, 0.08, &v[0], &v[1]);
}

/* Letters of the faces above the history, as long as each finds room; lines down to the curves tie impacts of both
 * together. */
static void draw_events(figure *f, const panel *p, const plot_panel *at)
{
    const plot_motion *m = &p->choice.motion;
    const plot_box box = plot_panel_box(at);
    for (int period = 0; period < p->choice.periods; period++)
        for (int i = 0; i < m->n_event; i++) {
            const plot_event *e = &m->events[i];
            const double x = plot_axis_at(&at->x, e->time + period * m->period);
            int contact, side, mirror;
            char letter[24], text[48];
            if (x > box.right + 0.5 || (period > 0 && e->time == 0)) continue;
            plot_page_line(f->page, PLOT_GRID, 2, (plot_point[]){{x, box.bottom}, {x, box.top}});
            plot_page_mark(f->page, plot_event_mark(e), (plot_point){x, box.top}, 2.6);
            if (e->opens || ric_model_face(m->model, e->face, &contact, &side, &mirror) != RIC_OK ||
                ric_word_format(m->model, 1, &e->face, sizeof letter, letter) != RIC_OK)
                continue;
            plot_text_escape(letter, sizeof text, text);
            const plot_point place = {x, box.top + 10};
            if (plot_page_free_box(f->page, plot_text_box(place, PLOT_CENTRE, type - 2, false, text)))
                plot_page_text(f->page, place, PLOT_CENTRE, type - 2, "#000000", false, text);
        }
}

static void caption(const figure *f, const panel *p, char letter, size_t size, char *out)
{
    static const char *const stability[] = {", unstable", ", stable", ", stability undecided"};
    char name[200], times[40] = "", place[120];
    plot_text_label(p->choice.name, sizeof name, name);
    if (p->choice.periods > 1) snprintf(times, sizeof times, ",  %d periods", p->choice.periods);
    plot_place_text(f->common, p->choice.motion.model, p->choice.energy, p->choice.frequency, sizeof place, place);
    snprintf(out, size, "(%c)  %s:  %s%s%s", letter, name, place,
             p->choice.stable >= 0 ? stability[p->choice.stable] : "", times);
}

static void draw_history(figure *f, int i, plot_box box, bool numbers)
{
    const panel *p = &f->panels[i];
    const plot_motion *m = &p->choice.motion;
    double x[2], v[2];
    char text[400];
    ranges(f, i, -1, x, v);
    plot_panel at = {axis_over(0, m->period * p->choice.periods, box.left, box.right),
                     axis_over(x[0], x[1], box.bottom, box.top)};
    at.y.unit = plot_units_of(f->common, m->model).length;
    draw_events(f, p, &at);
    for (int k = 0; k < f->n_shown; k++)
        for (int period = 0; period < p->choice.periods; period++)
            plot_motion_draw(f->page, &at, PLOT_SERIES + (plot_stroke)k, m, plot_read_time, plot_read_x, f->shown[k],
                             period * m->period);
    plot_panel_frame(f->page, &at, numbers ? "time (s)" : "", "x");
    caption(f, p, (char)('a' + i % 26), sizeof text, text);
    plot_page_text(f->page, (plot_point){box.left, box.top + 25}, PLOT_LEFT, type, "#000000", false, text);
}

static void draw_portrait(figure *f, int i, int coordinate, plot_box box)
{
    double x[2], v[2];
    char across[24], up[24];
    ranges(f, i, coordinate, x, v);
    plot_panel at = {axis_over(x[0], x[1], box.left, box.right), axis_over(v[0], v[1], box.bottom, box.top)};
    at.x.unit = at.y.unit = plot_units_of(f->common, f->panels[i].choice.motion.model).length;
    int series = 0;
    for (int k = 0; k < f->n_shown; k++) series = f->shown[k] == coordinate ? k : series;
    plot_motion_draw(f->page, &at, series ? PLOT_ASYMMETRIC : PLOT_SYMMETRIC, &f->panels[i].choice.motion, plot_read_x,
                     plot_read_v, coordinate, 0);
    snprintf(across, sizeof across, "x_{%d}", coordinate + 1);
    snprintf(up, sizeof up, "v_{%d}", coordinate + 1);
    plot_panel_frame(f->page, &at, across, up);
}

static void draw_row(figure *f, int i, plot_box cell, bool last)
{
    const double height = cell.top - cell.bottom, foot = 48,
                 side = f->histories ? 0 : f->n_shown * (height - foot + 66);
    const double right = cell.right - side;
    draw_history(f, i, (plot_box){cell.left + 56, cell.bottom + foot, right - 12, cell.top - 34},
                 last || f->histories || true);
    for (int k = 0; !f->histories && k < f->n_shown; k++) {
        const double left = right + k * (height - foot + 66) + 62;
        draw_portrait(f, i, f->shown[k], (plot_box){left, cell.bottom + foot, left + height - foot - 6, cell.top - 34});
    }
}

static int draw(figure *f)
{
    const int columns = (int)f->columns, rows = (f->n + columns - 1) / columns;
    const double row = f->histories ? 190 : 210, head = 58;
    const double width = plot_layout_width(f->common, columns > 1 ? 1200 : 1000);
    const double height = plot_layout_height(f->common, head + row * rows);
    plot_legend_entry entries[MAX_SHOWN + 2];
    char names[MAX_SHOWN][24], title[400];
    int n = 0;
    unsigned seen = 0;
    f->page = plot_page_create(width, height);
    if (!f->page) return cli_report(RIC_E_NOMEM);
    const double w = width / columns, h = (height - head) / rows;
    for (int i = 0; i < f->n; i++) {
        const double left = w * (i % columns), top = height - head - h * (i / columns);
        draw_row(f, i, (plot_box){left, top - h, left + w, top}, i + columns >= f->n);
        seen = plot_events_seen(&f->panels[i].choice.motion, seen);
    }
    for (int k = 0; k < f->n_shown; k++) {
        snprintf(names[k], sizeof names[k], "x_{%d}", f->shown[k] + 1);
        entries[n++] = (plot_legend_entry){names[k], PLOT_SERIES + k, -1};
    }
    plot_legend(f->page, n, entries, 12, 0.5 * width, height - 34);
    n = plot_event_entries(seen, entries);
    plot_legend(f->page, n, entries, 0.5 * width, width - 12, height - 34);
    plot_text_escape(f->common->title ? f->common->title : ric_study_title(ric_atlas_study(f->from.atlas[0])),
                     sizeof title, title);
    plot_page_text(f->page, (plot_point){width / 2, height - 17}, PLOT_CENTRE, type + 2, "#000000", false, title);
    return plot_page_write(f->page, f->common);
}

int plot_orbits(int argc, char **argv, const plot_options *common)
{
    figure f = {.common = common, .columns = 1};
    const char *coordinates, *columns;
    f.histories = cli_take_flag(&argc, argv, "--histories");
    f.same = cli_take_flag(&argc, argv, "--same-axes");
    if (!cli_take_value(&argc, argv, "--coordinates", &coordinates) ||
        !cli_take_value(&argc, argv, "--columns", &columns) ||
        (columns && !cli_parse_integer(columns, "--columns", 1, 6, &f.columns)))
        return CLI_WRONG;
    int code = take_orbits(argc, argv, &f);
    if (code == CLI_DONE) code = load(&f);
    if (code == CLI_DONE) code = take_coordinates(&f, coordinates) ? draw(&f) : CLI_WRONG;
    plot_page_free(f.page);
    for (int i = 0; i < f.n; i++) plot_motion_free(&f.panels[i].choice.motion);
    plot_atlases_free(&f.from);
    return code;
}
