/* Several orbits in one figure: a row for each with its displacements over time, impacts and
 * touches, and phase portraits; or histories only, in columns. Orbits come from one or more
 * atlases. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot_orbits.h"

static const double type = 12, small = 11;

/* ------------------------------------------------------------------ request */

static bool take_coordinates(orbits_figure *f, const char *text)
{
    const int n_dof = ric_model_n_dof(ric_atlas_model(f->from.atlas[0]));
    f->n_shown = 0;
    for (const char *c = text; c && *c; c += strspn(c, ",")) {
        char item[24];
        long index;
        const size_t n = strcspn(c, ",");
        snprintf(item, sizeof item, "%.*s", (int)(n < 20 ? n : 20), c);
        if (f->n_shown == ORBITS_SHOWN) {
            cli_wrong("--coordinates %s: at most %d fit", text, ORBITS_SHOWN);
            return false;
        }
        if (!cli_parse_integer(item, "--coordinates", 1, n_dof, &index)) return false;
        f->shown[f->n_shown++] = (int)index - 1;
        c += n;
    }
    for (int i = 0; !text && i < n_dof && i < 2; i++) f->shown[f->n_shown++] = i;
    if (!text && n_dof > f->n_shown)
        cli_say("ricochet: %d of %d coordinates are shown; --coordinates I,J chooses which\n",
                f->n_shown, n_dof);
    return f->n_shown > 0 || (cli_wrong("--coordinates %s: which?", text), false);
}

/* Orbits of a branch, from one of its ends to the other, behind those that are named. */
static int take_branch(orbits_figure *f)
{
    if (f->from.n > 1)
        return cli_wrong("plot orbits: --branch is of one atlas; with several name each orbit, "
                         "ATLAS --orbit %s@0.5",
                         f->branch);
    if (f->n + ORBITS_ALONG > ORBITS_MAX)
        return cli_wrong("plot orbits: at most %d orbits fit on a page", ORBITS_MAX);
    for (int i = 0; i < ORBITS_ALONG; i++) {
        char *text = f->along[i];
        if (snprintf(text, sizeof f->along[i], "%s@%g", f->branch,
                     (double)i / (ORBITS_ALONG - 1)) >= (int)sizeof f->along[i])
            return cli_wrong("plot orbits: --branch %s: no branch has such a name", f->branch);
        f->panels[f->n++] = (orbits_panel){.text = text, .atlas = 0};
    }
    return CLI_DONE;
}

static int take_orbits(int argc, char **argv, orbits_figure *f)
{
    plot_listed values[ORBITS_MAX];
    const int code = plot_take_listed(argc, argv, "--orbit", &f->from, ORBITS_MAX, &f->n, values);
    for (int i = 0; i < f->n; i++)
        f->panels[i] = (orbits_panel){.text = values[i].text, .atlas = values[i].atlas};
    if (code != CLI_DONE) return code;
    if (f->n == 0 && !f->branch)
        return cli_wrong("plot orbits: --orbit SPEC is missing: a junction, or BRANCH@PLACE; or "
                         "--branch ID for some orbits of a branch; see ricochet plot --help");
    for (int i = 0; i < f->n; i++)
        if (f->panels[i].atlas < 0 && f->from.n > 1)
            return cli_wrong("--orbit %s: with several atlases an orbit stands behind the one that "
                             "it belongs to",
                             f->panels[i].text);
    return f->branch ? take_branch(f) : CLI_DONE;
}

static int load(orbits_figure *f)
{
    const int read = plot_atlases_read(&f->from);
    if (read != CLI_DONE) return read;
    if (!plot_same_length(f->common, f->from.n, f->from.atlas)) return CLI_WRONG;
    for (int i = 1; i < f->from.n; i++)
        if (ric_model_n_dof(ric_atlas_model(f->from.atlas[i])) !=
            ric_model_n_dof(ric_atlas_model(f->from.atlas[0])))
            return cli_wrong("plot orbits: the models have different numbers of coordinates");
    for (int i = 0; i < f->n; i++) {
        orbits_panel *p = &f->panels[i];
        const int code = plot_choose(f->from.atlas[p->atlas < 0 ? 0 : p->atlas], p->text, "--orbit",
                                     &p->choice);
        if (code != CLI_DONE) return code;
        const ric_status status = plot_motion_make(&p->choice.motion);
        if (status != RIC_OK) return cli_report(status);
    }
    return CLI_DONE;
}

/* ------------------------------------------------------------------ drawing */

/* Ranges of displacements and speeds: of one panel, or of all. */
static void ranges(const orbits_figure *f, int only, int coordinate, double x[2], double v[2])
{
    x[0] = v[0] = INFINITY;
    x[1] = v[1] = -INFINITY;
    for (int i = 0; i < f->n; i++)
        for (int k = 0; k < f->n_shown; k++) {
            if ((i != only && !f->same) || (coordinate >= 0 && f->shown[k] != coordinate)) continue;
            plot_motion_range(&f->panels[i].choice.motion, plot_read_x, f->shown[k], &x[0], &x[1]);
            plot_motion_range(&f->panels[i].choice.motion, plot_read_v, f->shown[k], &v[0], &v[1]);
            if (f->gap && coordinate < 0)
                plot_motion_range(&f->panels[i].choice.motion, plot_read_distance, 0, &x[0], &x[1]);
        }
    plot_range_widen(false, 0.08, &x[0], &x[1]);
    plot_range_widen(false, 0.08, &v[0], &v[1]);
}

/* Letters of the faces above the history, as long as each finds room; lines down to the curves tie
 * impacts of both together. */
static void draw_events(orbits_figure *f, const orbits_panel *p, const plot_panel *at)
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
            const plot_point place = {x, box.top + 11};
            if (plot_page_free_box(f->page, plot_text_box(place, PLOT_CENTRE, small, false, text)))
                plot_page_text(f->page, place, PLOT_CENTRE, small, "#000000", false, text);
        }
}

/* A caption in lines that are as wide as their panel at most. */
enum { MAX_LINE = 4 };
typedef struct {
    int n;
    char lines[MAX_LINE][400];
} caption;

static void add_piece(caption *c, double width, const char *piece)
{
    char longer[500];
    char *last = c->lines[c->n ? c->n - 1 : 0];
    snprintf(longer, sizeof longer, "%s%s%s", last, c->n ? "  " : "", piece);
    if (c->n > 0 && (plot_text_width(longer, type) <= width || c->n == MAX_LINE))
        snprintf(last, sizeof c->lines[0], "%.399s", longer);
    else snprintf(c->lines[c->n++], sizeof c->lines[0], "%.399s", piece);
}

static caption make_caption(const orbits_figure *f, int i, double width)
{
    static const char *const stability[] = {"unstable", "stable", "stability undecided"};
    const orbits_panel *p = &f->panels[i];
    const plot_units unit = plot_units_of(f->common, p->choice.motion.model);
    caption c = {0};
    char name[200], piece[240];
    plot_text_label(p->choice.name, sizeof name, name);
    snprintf(piece, sizeof piece, "(%c)  %s:", 'a' + i % 26, name);
    add_piece(&c, width, piece);
    snprintf(piece, sizeof piece, "%s = %.6g,", plot_energy_letter(p->choice.motion.model),
             p->choice.energy * unit.energy);
    add_piece(&c, width, piece);
    snprintf(piece, sizeof piece, "%s = %.6g %s", f->common->hertz ? "f" : "ω",
             p->choice.frequency * unit.frequency, f->common->hertz ? "Hz" : "rad/s");
    add_piece(&c, width, piece);
    if (p->choice.periods > 1) {
        snprintf(piece, sizeof piece, "%d periods", p->choice.periods);
        add_piece(&c, width, piece);
    }
    if (p->choice.stable >= 0) add_piece(&c, width, stability[p->choice.stable]);
    return c;
}

static double caption_height(int lines)
{
    return 1.3 * type * lines;
}

/* The gap of a contact in units of length, with lines where the contact closes. */
static void draw_gap(orbits_figure *f, const plot_motion *m, const plot_panel *at, int periods)
{
    for (int side = -1; side <= 1; side += 2) {
        const double y = side * plot_motion_clearance(m, 0);
        if (plot_motion_face(m, 0, side) >= 0 || ric_model_n_face(m->model) == 0)
            plot_panel_curve(f->page, at, PLOT_STOP, 2,
                             (plot_point[]){{at->x.lo, y}, {at->x.hi, y}});
    }
    for (int period = 0; period < periods; period++)
        plot_motion_draw(f->page, at, PLOT_GAP, m, plot_read_time, plot_read_distance, 0,
                         period * m->period);
}

static void draw_history(orbits_figure *f, int i, plot_box box, bool title)
{
    const orbits_panel *p = &f->panels[i];
    const plot_motion *m = &p->choice.motion;
    double x[2], v[2];
    ranges(f, i, -1, x, v);
    plot_panel at = {plot_axis_linear(0, m->period * p->choice.periods, box.left, box.right),
                     plot_axis_linear(x[0], x[1], box.bottom, box.top)};
    at.y.unit = plot_units_of(f->common, m->model).length;
    draw_events(f, p, &at);
    if (f->gap) draw_gap(f, m, &at, p->choice.periods);
    for (int k = 0; k < f->n_shown; k++)
        for (int period = 0; period < p->choice.periods; period++)
            plot_motion_draw(f->page, &at, PLOT_SERIES + (plot_stroke)k, m, plot_read_time,
                             plot_read_x, f->shown[k], period * m->period);
    plot_panel_frame(f->page, &at, title ? "time (s)" : "", "x");
    const caption c = make_caption(f, i, box.right - box.left);
    for (int k = 0; k < c.n; k++)
        plot_page_text(f->page, (plot_point){box.left, box.top + 26 + caption_height(c.n - 1 - k)},
                       PLOT_LEFT, type, "#000000", false, c.lines[k]);
}

static void draw_portrait(orbits_figure *f, int i, int coordinate, plot_box box, bool title)
{
    double x[2], v[2];
    char across[24], up[24];
    ranges(f, i, coordinate, x, v);
    plot_panel at = {plot_axis_linear(x[0], x[1], box.left, box.right),
                     plot_axis_linear(v[0], v[1], box.bottom, box.top)};
    at.x.unit = at.y.unit = plot_units_of(f->common, f->panels[i].choice.motion.model).length;
    int series = 0;
    for (int k = 0; k < f->n_shown; k++) series = f->shown[k] == coordinate ? k : series;
    plot_motion_draw(f->page, &at, PLOT_PORTRAIT + (plot_stroke)series, &f->panels[i].choice.motion,
                     plot_read_x, plot_read_v, coordinate, 0);
    snprintf(across, sizeof across, "x_{%d}", coordinate + 1);
    snprintf(up, sizeof up, "v_{%d}", coordinate + 1);
    plot_panel_frame(f->page, &at, title ? across : "", up);
}

/* What the cells of the figure share. */
typedef struct {
    int rows;
    double width, height; /* of a cell */
    double head, foot;    /* of it, beside the panels themselves */
    double numbers;       /* room left of a portrait for its numbers and title */
    double portrait;      /* width of one, with that; 0: none */
} grid;

enum { LEFT = 60, RIGHT = 12, FOOT = 24, TITLE = 22, LEGEND = 26 };
/* Beside the numbers of an axis: its title, and what keeps that from the panel before. */
enum { TITLED = 33 };

/* Speeds of a structure in seconds may have four digits. */
static double portrait_numbers(const orbits_figure *f, double height)
{
    double widest = 0;
    for (int i = 0; i < f->n; i++)
        for (int k = 0; k < f->n_shown; k++) {
            double x[2], v[2];
            ranges(f, i, f->shown[k], x, v);
            plot_axis axis = plot_axis_linear(v[0], v[1], 0, height);
            axis.unit = plot_units_of(f->common, f->panels[i].choice.motion.model).length;
            widest = fmax(widest, plot_axis_widest(&axis));
        }
    return fmax(LEFT, widest + TITLED);
}

/* Portraits are square; the history has what is left of the row. */
static grid make_grid(const orbits_figure *f)
{
    const int columns = (int)f->columns;
    const double width = plot_layout_width(f->common, PLOT_WIDTH),
                 top = plot_page_head(f->common, NULL) + LEGEND;
    grid g = {.rows = (f->n + columns - 1) / columns, .width = width / columns, .foot = FOOT};
    const double usual = g.rows <= 4 ? 112
                                     : 80; /* of a panel: so many rows fill a page of a journal */
    int lines = 1;
    for (int round = 0; round < 2; round++) { /* the captions depend on the width that the portraits
                                                 leave, these on the height of the captions */
        g.head = 18 + caption_height(lines);
        g.height = (plot_layout_height(f->common, top + TITLE + g.rows * (usual + g.head + FOOT)) -
                    top - TITLE) /
                   g.rows;
        const double side = g.height - g.head - FOOT;
        g.numbers = portrait_numbers(f, side);
        g.portrait = f->histories ? 0 : side + g.numbers + 4;
        lines = 1;
        for (int i = 0; i < f->n; i++) {
            const caption c = make_caption(f, i, g.width - LEFT - RIGHT - g.portrait * f->n_shown);
            lines = c.n > lines ? c.n : lines;
        }
    }
    return g;
}

static void draw_cell(orbits_figure *f, const grid *g, int i, double left, double top)
{
    const int columns = (int)f->columns;
    const double bottom = top - g->height + g->foot, upper = top - g->head,
                 right = left + g->width - RIGHT - g->portrait * f->n_shown;
    const bool last = i + columns >= f->n;
    draw_history(f, i, (plot_box){left + LEFT, bottom, right, upper}, last);
    for (int k = 0; !f->histories && k < f->n_shown; k++) {
        const double from = right + g->numbers + k * g->portrait,
                     to = right + (k + 1) * g->portrait;
        draw_portrait(f, i, f->shown[k], (plot_box){from, bottom, to, upper}, last);
    }
}

static void draw_legends(orbits_figure *f, double top)
{
    plot_legend_entry entries[ORBITS_SHOWN + 2 + PLOT_MAX_EVENT_ENTRY];
    char names[ORBITS_SHOWN][24];
    const double width = plot_page_width(f->page);
    int n = 0;
    unsigned seen = 0;
    for (int i = 0; i < f->n; i++) seen = plot_events_seen(&f->panels[i].choice.motion, seen);
    for (int k = 0; k < f->n_shown; k++) {
        snprintf(names[k], sizeof names[k], "x_{%d}", f->shown[k] + 1);
        entries[n++] = (plot_legend_entry){names[k], PLOT_SERIES + k, -1};
    }
    if (f->gap) {
        entries[n++] = (plot_legend_entry){"gap", PLOT_GAP, -1};
        entries[n++] = (plot_legend_entry){"contact closed", PLOT_STOP, -1};
    }
    const int n_mark = plot_event_entries(seen, entries + n);
    const double split = n_mark ? 0.66 * width : width;
    plot_legend(f->page, n, entries, 12, split, top);
    plot_legend(f->page, n_mark, entries + n, split, width - 12, top);
}

static int draw(orbits_figure *f)
{
    const int columns = (int)f->columns;
    const grid g = make_grid(f);
    const double head = plot_page_head(f->common, NULL) + LEGEND,
                 height = head + TITLE + g.rows * g.height;
    f->page = plot_page_create(g.width * columns, height);
    if (!f->page) return cli_report(RIC_E_NOMEM);
    for (int i = 0; i < f->n; i++)
        draw_cell(f, &g, i, g.width * (i % columns), height - head - g.height * (i / columns));
    draw_legends(f, height - head + LEGEND - 2);
    plot_page_title(f->page, f->common, NULL);
    return plot_page_write(f->page, f->common);
}

int plot_orbits(int argc, char **argv, const plot_options *common)
{
    orbits_figure f = {.common = common, .columns = 1};
    const char *coordinates, *columns;
    f.histories = cli_take_flag(&argc, argv, "--histories");
    f.same = cli_take_flag(&argc, argv, "--same-axes");
    f.gap = cli_take_flag(&argc, argv, "--gap");
    f.overlay = cli_take_flag(&argc, argv, "--overlay");
    if (!cli_take_value(&argc, argv, "--branch", &f.branch) ||
        !cli_take_value(&argc, argv, "--coordinates", &coordinates) ||
        !cli_take_value(&argc, argv, "--columns", &columns) ||
        (columns && !cli_parse_integer(columns, "--columns", 1, 6, &f.columns)))
        return CLI_WRONG;
    if (f.overlay && (columns || f.same))
        return cli_wrong(
            "--overlay: all orbits share their axes; --columns and --same-axes go without it");
    int code = take_orbits(argc, argv, &f);
    if (code == CLI_DONE) code = load(&f);
    if (code == CLI_DONE)
        code = !take_coordinates(&f, coordinates) ? CLI_WRONG
               : f.overlay                        ? orbits_overlay(&f)
                                                  : draw(&f);
    plot_page_free(f.page);
    for (int i = 0; i < f.n; i++) plot_motion_free(&f.panels[i].choice.motion);
    plot_atlases_free(&f.from);
    return code;
}
