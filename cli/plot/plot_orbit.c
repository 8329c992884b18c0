/* One orbit: displacements and gaps over a period, impacts and touches with the letters of their
 * faces, and phase portraits. The motion itself is made in plot_motion.c. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

enum { MAX_SHOWN = 4 };
static const double type = 12;
/* How near a gap must come to a stop, in clearances, to be a touch: an orbit of a branch is exact
 * to rounding; a grazing junction of a very unstable orbit carries the error of its flights. */
static const double touch_of_branch = 1e-9, touch_of_grazing = 1e-7;

typedef struct {
    const plot_options *common;
    plot_units unit;
    ric_atlas *atlas;
    plot_motion *motion;
    plot_table data; /* t, x1.., v1.. of one's own */
    char title[400];
    int n_shown, shown[MAX_SHOWN], n_gap, gaps[MAX_SHOWN];
    int missing;
    plot_page *page;
} orbit;

/* ------------------------------------------------------------------ request */

static void set_title(orbit *o, const char *name, double energy, const char *extra)
{
    char place[120];
    plot_place_text(o->common, o->motion->model, energy, 2 * CLI_PI / o->motion->period,
                    sizeof place, place);
    snprintf(o->title, sizeof o->title, "%s:  %s%s", name, place, extra);
}

static int take_junction(orbit *o, const char *text)
{
    long id;
    ric_junction junction;
    char name[160];
    if (!cli_parse_integer(text, "--junction", 1, 2147483647, &id)) return CLI_WRONG;
    const ric_status status = ric_atlas_junction(o->atlas, (int)id, &junction);
    if (status != RIC_OK) return cli_report(status);
    o->motion->tolerance = junction.kind == RIC_KIND_GRAZING ? touch_of_grazing : touch_of_branch;
    if (!plot_motion_keep(o->motion, junction.letters, junction.word, junction.state,
                          junction.flights))
        return cli_report(RIC_E_NOMEM);
    plot_text_label(junction.name && *junction.name ? junction.name : junction.label, sizeof name,
                    name);
    set_title(o, name, junction.energy, "");
    return CLI_DONE;
}

typedef struct {
    const char *branch, *junction, *point, *energy, *frequency, *which, *coordinates, *data;
} words;

static int choose_orbit(orbit *o, const ric_branch *branch, const words *w, int n,
                        ric_orbit **orbits)
{
    static const char *const stability[] = {", unstable", ", stable", ", stability undecided"};
    long which = 1;
    char name[200];
    ric_point point;
    if (n == 0) {
        fprintf(stderr,
                "ricochet: no orbit of branch %d there; it has energies %.6g to %.6g and "
                "frequencies %.6g to %.6g\n",
                branch->id, branch->energy_min * o->unit.energy,
                branch->energy_max * o->unit.energy, branch->frequency_min * o->unit.frequency,
                branch->frequency_max * o->unit.frequency);
        return CLI_FAILED;
    }
    if (w->which && !cli_parse_integer(w->which, "--which", 1, n, &which)) return CLI_WRONG;
    if (n > 1 && !w->which)
        fprintf(stderr, "ricochet: %d orbits fit, this is the first; --which K draws another\n", n);
    const ric_orbit *chosen = orbits[which - 1];
    const int impacts = ric_orbit_letters(chosen), room = impacts > 0 ? impacts : 1;
    double *state = calloc(2 * (size_t)o->motion->n, sizeof *state),
           *flights = calloc((size_t)room, sizeof *flights);
    int *word = calloc((size_t)room, sizeof *word);
    int code = CLI_DONE;
    if (state && flights && word) ric_orbit_data(chosen, &point, state, flights, word);
    if (!state || !flights || !word ||
        !plot_motion_keep(o->motion, impacts, word, state, flights)) {
        code = cli_report(RIC_E_NOMEM);
        goto out;
    }
    plot_branch_title(branch, 1, sizeof name, name);
    set_title(o, name, point.energy,
              point.stable >= 0 && point.stable <= 2 ? stability[point.stable] : "");
out:
    free(state);
    free(flights);
    free(word);
    return code;
}

static int take_branch(orbit *o, const words *w)
{
    long id, point = 0;
    double value = 0;
    ric_branch branch;
    ric_orbit **orbits = NULL;
    int n = 0;
    if (!cli_parse_integer(w->branch, "--branch", 1, 2147483647, &id) ||
        (w->point && !cli_parse_integer(w->point, "--point", 0, 2147483647, &point)) ||
        (w->energy && !cli_parse_number(w->energy, "--energy", &value)) ||
        (w->frequency && !cli_parse_number(w->frequency, "--frequency", &value)))
        return CLI_WRONG;
    value = w->point ? (double)point : value / (w->energy ? o->unit.energy : o->unit.frequency);
    ric_status status = ric_atlas_branch(o->atlas, (int)id, &branch);
    if (status == RIC_OK)
        status = ric_orbit_find(o->atlas, (int)id,
                                w->point    ? RIC_AT_POINT
                                : w->energy ? RIC_AT_ENERGY
                                            : RIC_AT_FREQUENCY,
                                value, &n, &orbits);
    if (status != RIC_OK) return cli_report(status);
    o->motion->tolerance = touch_of_branch;
    const int code = choose_orbit(o, &branch, w, n, orbits);
    ric_orbits_free(n, orbits);
    return code;
}

static int by_number(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

/* Coordinates on which contacts act most, where there are too many to show; in their order. */
static void usual_coordinates(orbit *o)
{
    o->n_shown = o->motion->n < MAX_SHOWN ? o->motion->n : MAX_SHOWN;
    for (int i = 0; i < o->n_shown; i++) o->shown[i] = i;
    if (o->motion->n <= MAX_SHOWN) return;
    double taken[MAX_SHOWN] = {0};
    o->n_shown = 0;
    for (int i = 0; i < o->motion->n; i++) {
        double weight = 0;
        for (int contact = 0; contact < ric_model_n_contact(o->motion->model); contact++) {
            ric_contact c;
            if (ric_model_contact(o->motion->model, contact, &c) == RIC_OK)
                weight += fabs(c.normal[i]);
        }
        int place = o->n_shown;
        while (place > 0 && taken[place - 1] < weight) place--;
        if (place == MAX_SHOWN) continue;
        o->n_shown += o->n_shown < MAX_SHOWN;
        for (int k = o->n_shown - 1; k > place; k--) {
            taken[k] = taken[k - 1];
            o->shown[k] = o->shown[k - 1];
        }
        taken[place] = weight;
        o->shown[place] = i;
    }
    qsort(o->shown, (size_t)o->n_shown, sizeof *o->shown, by_number);
}

static bool take_coordinates(orbit *o, const char *text)
{
    for (const char *c = text;; c++) {
        char item[24];
        const size_t n = strcspn(c, ",");
        long index;
        snprintf(item, sizeof item, "%.*s", (int)(n < 20 ? n : 20), c);
        if (o->n_shown == MAX_SHOWN) {
            cli_wrong("--coordinates %s: at most %d fit on a page", text, MAX_SHOWN);
            return false;
        }
        if (!cli_parse_integer(item, "--coordinates", 1, o->motion->n, &index)) return false;
        o->shown[o->n_shown++] = (int)index - 1;
        c += n;
        if (!*c) return true;
    }
}

/* Contacts that are hit or touched, then others, as many as can be told apart. */
static void choose_gaps(orbit *o)
{
    const int n = ric_model_n_contact(o->motion->model);
    for (int round = 0; round < 2; round++)
        for (int contact = 0; contact < n; contact++) {
            bool met = false, known = false;
            for (int i = 0; i < o->motion->n_event; i++) {
                int c, side, mirror;
                met |= ric_model_face(o->motion->model, o->motion->events[i].face, &c, &side,
                                      &mirror) == RIC_OK &&
                       c == contact;
            }
            for (int i = 0; i < o->n_gap; i++) known |= o->gaps[i] == contact;
            if (!known && met == (round == 0) && o->n_gap < MAX_SHOWN)
                o->gaps[o->n_gap++] = contact;
        }
    for (int i = 1; i < o->n_gap; i++) /* in the order of the study */
        for (int k = i; k > 0 && o->gaps[k - 1] > o->gaps[k]; k--) {
            const int other = o->gaps[k];
            o->gaps[k] = o->gaps[k - 1];
            o->gaps[k - 1] = other;
        }
    if (n > o->n_gap) fprintf(stderr, "ricochet: %d of %d contacts are shown\n", o->n_gap, n);
}

/* ------------------------------------------------------------------ drawing */

static plot_axis time_axis(const orbit *o, double from, double to)
{
    return plot_axis_linear(-0.025 * o->motion->period, 1.025 * o->motion->period, from, to);
}

/* Thin upright lines tie the impacts of the two histories together. */
static void draw_event_lines(const orbit *o, const plot_panel *panel)
{
    const plot_box box = plot_panel_box(panel);
    for (int i = 0; i < o->motion->n_event; i++) {
        const double x = plot_axis_at(&panel->x, o->motion->events[i].time);
        if (!o->motion->events[i].touch)
            plot_page_line(o->page, PLOT_GRID, 2, (plot_point[]){{x, box.bottom}, {x, box.top}});
    }
}

/* The instants of touches, t_1 and so on, above the history, if they find room. */
static void name_touches(const orbit *o, const plot_panel *panel)
{
    const plot_box box = plot_panel_box(panel);
    double last = -1;
    for (int number = 1;; number++) { /* in their order, which is not that of the contacts */
        const plot_event *next = NULL;
        for (int i = 0; i < o->motion->n_event; i++) {
            const plot_event *e = &o->motion->events[i];
            if (e->touch && e->time > last && (!next || e->time < next->time)) next = e;
        }
        if (!next) return;
        const double x = plot_axis_at(&panel->x, last = next->time);
        char text[24];
        snprintf(text, sizeof text, "t_{%d}", number);
        plot_page_line(o->page, PLOT_JUMP, 2, (plot_point[]){{x, box.bottom}, {x, box.top}});
        const plot_point at = {x, box.top + 9};
        if (plot_page_free_box(o->page, plot_text_box(at, PLOT_CENTRE, type - 1, false, text)))
            plot_page_text(o->page, at, PLOT_CENTRE, type - 1, "#000000", false, text);
    }
}

/* What was measured, in the units of the picture, over time. */
static void draw_data(const orbit *o, const plot_panel *panel)
{
    for (int row = 0; row < o->data.n; row++)
        for (int i = 0; i < o->n_shown; i++)
            plot_panel_dot(o->page, panel, PLOT_DATA + 1 + (plot_stroke)i,
                           (plot_point){plot_table_at(&o->data, row, 0),
                                        plot_table_at(&o->data, row, 1 + i) / o->unit.length});
}

static void draw_displacements(orbit *o, plot_box box, bool numbers)
{
    plot_legend_entry entries[MAX_SHOWN];
    char names[MAX_SHOWN][24];
    double lo = INFINITY, hi = -INFINITY;
    for (int i = 0; i < o->n_shown; i++)
        plot_motion_range(o->motion, plot_read_x, o->shown[i], &lo, &hi);
    plot_range_widen(false, 0.07, &lo, &hi);
    plot_panel panel = {time_axis(o, box.left, box.right),
                        plot_axis_linear(lo, hi, box.bottom, box.top)};
    panel.y.unit = o->unit.length;
    draw_event_lines(o, &panel);
    name_touches(o, &panel);
    for (int i = 0; i < o->n_shown; i++) {
        plot_motion_draw(o->page, &panel, PLOT_SERIES + (plot_stroke)i, o->motion, plot_read_time,
                         plot_read_x, o->shown[i], 0);
        snprintf(names[i], sizeof names[i], "x_{%d}", o->shown[i] + 1);
        entries[i] = (plot_legend_entry){names[i], PLOT_SERIES + i, -1};
    }
    draw_data(o, &panel);
    char title[64];
    plot_length_title(o->common, o->motion->model, "displacement", "", sizeof title, title);
    plot_panel_frame(o->page, &panel, numbers ? "" : NULL, title);
    plot_legend(o->page, o->n_shown, entries, box.left, box.right, box.top + 34);
}

/* The name of a contact, or its number, between two words. */
static void gap_name(const orbit *o, int contact, const char *before, const char *after,
                     size_t size, char *out)
{
    ric_contact c;
    char name[60];
    if (ric_model_contact(o->motion->model, contact, &c) == RIC_OK && c.name && *c.name)
        plot_text_escape(c.name, sizeof name, name);
    else snprintf(name, sizeof name, "contact %d", contact + 1);
    snprintf(out, size, "%s%s%s", before, name, after);
}

/* Whether the gap shown as number i has a stop on a side. */
static bool has_stop(const orbit *o, int i, int side)
{
    return plot_motion_face(o->motion, o->gaps[i], side) >= 0;
}

/* How many of the gaps shown have one there. */
static int stops_on(const orbit *o, int side)
{
    int n = 0;
    for (int i = 0; i < o->n_gap; i++) n += has_stop(o, i, side);
    return n;
}

/* The line of a stop that not every gap has is in the colour of the gap that it bounds: others pass
 * it freely. */
static bool own_stop(const orbit *o, int i, int side)
{
    return has_stop(o, i, side) && stops_on(o, side) < o->n_gap;
}

static void draw_stops(const orbit *o, const plot_panel *panel)
{
    for (int side = -1; side <= 1; side += 2) {
        double y = plot_axis_at(&panel->y, side);
        if (o->n_gap && stops_on(o, side) == o->n_gap)
            plot_page_line(o->page, PLOT_STOP, 2,
                           (plot_point[]){{panel->x.from, y}, {panel->x.to, y}});
        for (int i = 0; i < o->n_gap; i++) {
            if (!own_stop(o, i, side)) continue;
            plot_page_line(o->page, PLOT_STOP + 1 + (plot_stroke)i, 2,
                           (plot_point[]){{panel->x.from, y}, {panel->x.to, y}});
            y += 2.5 * side; /* several such stops lie side by side */
        }
    }
}

/* The letter of a face beside its mark, in one of three rows beyond the stop; left out where all
 * three are taken. */
static void draw_letter(orbit *o, plot_point at, int side, int face)
{
    char letter[24], text[48];
    if (ric_word_format(o->motion->model, 1, &face, sizeof letter, letter) != RIC_OK) return;
    plot_text_escape(letter, sizeof text, text);
    for (int line = 0; line < 3; line++) {
        const plot_point place = {at.x, at.y + side * (13 + 13.5 * line)};
        plot_box box = plot_text_box(place, PLOT_CENTRE, type - 1, false, text);
        box.left += 0.5;
        box.right -= 0.5;
        if (!plot_page_free_box(o->page, box)) continue;
        plot_page_text(o->page, place, PLOT_CENTRE, type - 1, "#000000", false, text);
        return;
    }
    o->missing++;
}

static void draw_gap_events(orbit *o, const plot_panel *panel)
{
    for (int round = 0; round < 2; round++) /* letters after all marks */
        for (int i = 0; i < o->motion->n_event; i++) {
            const plot_event *e = &o->motion->events[i];
            int contact, side, mirror;
            bool shown = false;
            if (ric_model_face(o->motion->model, e->face, &contact, &side, &mirror) != RIC_OK)
                continue;
            for (int k = 0; k < o->n_gap; k++) shown |= o->gaps[k] == contact;
            const plot_point at = plot_panel_at(panel, (plot_point){e->time, side});
            if (shown && round == 0) plot_page_mark(o->page, plot_event_mark(e), at, 3.6);
            else if (shown && !e->opens) draw_letter(o, at, side, e->face);
        }
}

/* What the legend says of gaps and lines of stops. names [2 MAX_SHOWN], for the texts. */
static int gap_entries(const orbit *o, char (*names)[96], plot_legend_entry *entries)
{
    int n = 0;
    bool shared = false;
    for (int i = 0; i < o->n_gap; i++) {
        gap_name(o, o->gaps[i], "gap of ", "", sizeof names[i], names[i]);
        entries[n++] = (plot_legend_entry){names[i], PLOT_SERIES + i, -1};
    }
    for (int side = -1; side <= 1; side += 2)
        shared |= o->n_gap > 0 && stops_on(o, side) == o->n_gap;
    if (shared) entries[n++] = (plot_legend_entry){"contact closed", PLOT_STOP, -1};
    for (int i = 0; i < o->n_gap; i++) {
        char *name = names[MAX_SHOWN + i];
        gap_name(o, o->gaps[i], "", " closed", sizeof names[0], name);
        if (own_stop(o, i, -1) || own_stop(o, i, 1))
            entries[n++] = (plot_legend_entry){name, PLOT_STOP + 1 + i, -1};
    }
    return n;
}

static void draw_gaps(orbit *o, plot_box box)
{
    const double room = 50; /* pixels beyond a stop, for three rows of letters */
    const bool upper = stops_on(o, 1), lower = stops_on(o, -1);
    double lo = lower ? -1 : 0, hi = upper ? 1 : 0;
    plot_legend_entry entries[2 * MAX_SHOWN + 1], marks[PLOT_MAX_EVENT_ENTRY];
    char names[2 * MAX_SHOWN][96];
    const int n = gap_entries(o, names, entries),
              n_mark = plot_event_entries(plot_events_seen(o->motion, 0), marks);
    const double head = box.top + 22;
    box.top -= plot_legend(NULL, n, entries, box.left, box.right, 0) -
               plot_legend(NULL, 1, entries, 0, box.right, 0);
    for (int i = 0; i < o->n_gap; i++)
        plot_motion_range(o->motion, plot_read_gap, o->gaps[i], &lo, &hi);
    const double above = upper ? room : 12, below = lower ? room : 12,
                 scale = (hi - lo) / fmax(20, box.top - box.bottom - above - below);
    const plot_panel panel = {time_axis(o, box.left, box.right),
                              plot_axis_linear(lo - below * scale, hi + above * scale, box.bottom,
                                               box.top)};
    draw_event_lines(o, &panel);
    draw_stops(o, &panel);
    for (int i = 0; i < o->n_gap; i++)
        plot_motion_draw(o->page, &panel, PLOT_SERIES + (plot_stroke)i, o->motion, plot_read_time,
                         plot_read_gap, o->gaps[i], 0);
    plot_panel_frame(o->page, &panel, "time (s)", "gap / clearance");
    draw_gap_events(o, &panel);
    plot_legend(o->page, n, entries, box.left, box.right, head);
    if (n_mark > 0) plot_legend(o->page, n_mark, marks, box.left, box.right, box.bottom - 42);
}

static void mark_row(const orbit *o, const plot_panel *panel, int coordinate, int index,
                     plot_mark mark)
{
    const double *r = plot_motion_row(o->motion, index);
    plot_page_mark(o->page, mark,
                   plot_panel_at(panel, (plot_point){plot_read_x(o->motion, r, coordinate),
                                                     plot_read_v(o->motion, r, coordinate)}),
                   3);
}

static void draw_portrait(orbit *o, int i, plot_box box)
{
    const int coordinate = o->shown[i];
    double x[2] = {INFINITY, -INFINITY}, v[2] = {INFINITY, -INFINITY};
    const char *length = o->common->physical ? ric_model_units(o->motion->model)->length : "";
    char across[64], up[64];
    plot_motion_range(o->motion, plot_read_x, coordinate, &x[0], &x[1]);
    plot_motion_range(o->motion, plot_read_v, coordinate, &v[0], &v[1]);
    plot_range_widen(false, 0.07, &x[0], &x[1]);
    plot_range_widen(false, 0.07, &v[0], &v[1]);
    plot_panel panel = {plot_axis_linear(x[0], x[1], box.left, box.right),
                        plot_axis_linear(v[0], v[1], box.bottom, box.top)};
    panel.x.unit = panel.y.unit = o->unit.length;
    plot_motion_draw(o->page, &panel, PLOT_PORTRAIT + (plot_stroke)i, o->motion, plot_read_x,
                     plot_read_v, coordinate, 0);
    for (int row = 0; row < o->data.n; row++)
        plot_panel_dot(o->page, &panel, PLOT_DATA + 1 + (plot_stroke)i,
                       (plot_point){plot_table_at(&o->data, row, 1 + i) / o->unit.length,
                                    plot_table_at(&o->data, row, 1 + o->n_shown + i) /
                                        o->unit.length});
    snprintf(across, sizeof across, "x_{%d}%s%s%s", coordinate + 1, *length ? " (" : "", length,
             *length ? ")" : "");
    snprintf(up, sizeof up, "v_{%d}%s%s%s", coordinate + 1, *length ? " (" : "", length,
             *length ? "/s)" : "");
    plot_panel_frame(o->page, &panel, across, up);
    for (int k = 0; k < o->motion->n_event; k++) {
        const plot_event *e = &o->motion->events[k];
        mark_row(o, &panel, coordinate, e->sample, plot_event_mark(e));
        if (!e->touch && e->sample > 0 &&
            e->sample + 1 < o->motion->first[o->motion->n_piece]) /* the other side */
            mark_row(o, &panel, coordinate, e->sample - 1, plot_event_mark(e));
    }
}

static void draw_portraits(orbit *o, plot_box area)
{
    const int columns = o->n_shown > 2 ? 2 : 1, lines = (o->n_shown + columns - 1) / columns;
    const double width = (area.right - area.left) / columns,
                 height = (area.top - area.bottom) / lines;
    for (int i = 0; i < o->n_shown; i++) {
        const double left = area.left + width * (i % columns),
                     top = area.top - height * (i / columns);
        draw_portrait(o, i, (plot_box){left + 70, top - height + 46, left + width - 8, top - 6});
    }
}

static int draw(orbit *o)
{
    const double width = plot_layout_width(o->common, PLOT_WIDTH),
                 height = plot_layout_height(o->common, 560);
    o->page = plot_page_create(width, height);
    if (!o->page) return cli_report(RIC_E_NOMEM);
    const bool titled = *o->title || o->common->title;
    const double split = width * (o->n_shown > 2 ? 0.52 : 0.62), foot = 64, head = titled ? 66 : 44,
                 middle = foot + (height - foot - head) * 0.52;
    draw_displacements(o, (plot_box){64, middle + 30, split - 8, height - head}, false);
    draw_gaps(o, (plot_box){64, foot, split - 8, middle - 4});
    draw_portraits(o, (plot_box){split, foot - 46, width - 8, height - (titled ? 30 : 8)});
    plot_page_title(o->page, o->common, *o->title ? o->title : NULL);
    if (o->missing)
        fprintf(stderr,
                "ricochet: %d letter%s of impacts left out for want of room; --size makes more\n",
                o->missing, o->missing == 1 ? "" : "s");
    return plot_page_write(o->page, o->common);
}

static int parse(int *argc, char **argv, words *w)
{
    static const char *const names[] = {"--branch",    "--junction", "--point",       "--energy",
                                        "--frequency", "--which",    "--coordinates", "--data"};
    const char **values[] = {&w->branch,    &w->junction, &w->point,       &w->energy,
                             &w->frequency, &w->which,    &w->coordinates, &w->data};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!cli_take_value(argc, argv, names[i], values[i])) return CLI_WRONG;
    const int places = (w->point != NULL) + (w->energy != NULL) + (w->frequency != NULL);
    if (!w->branch == !w->junction)
        return cli_wrong(
            "plot orbit: give either --branch ID with a place on it, or --junction ID");
    if (w->junction && (places || w->which))
        return cli_wrong("plot orbit: --junction ID is one orbit; --point, --energy, --frequency "
                         "and --which go with --branch");
    if (w->branch && places != 1)
        return cli_wrong("plot orbit: --branch needs one of --point I, --energy E, --frequency F");
    return cli_operands(&cli_plot, *argc, argv, 1) ? CLI_DONE : CLI_WRONG;
}

/* --data: times and what was measured at them, of the coordinates that are shown. */
static int read_data(orbit *o, const char *path)
{
    enum { WIDTH = 24 };
    char texts[2 * MAX_SHOWN][WIDTH];
    const char *names[1 + 2 * MAX_SHOWN] = {"t"};
    if (!path) return CLI_DONE;
    for (int i = 0; i < o->n_shown; i++) {
        snprintf(texts[i], WIDTH, "x%d", o->shown[i] + 1);
        snprintf(texts[MAX_SHOWN + i], WIDTH, "v%d", o->shown[i] + 1);
        names[1 + i] = texts[i];
        names[1 + o->n_shown + i] = texts[MAX_SHOWN + i];
    }
    return plot_table_read(path, 1 + 2 * o->n_shown, names, 1, &o->data);
}

/* Which coordinates and gaps, and the page. */
static int show(orbit *o, const char *coordinates, const char *data)
{
    if (coordinates && !take_coordinates(o, coordinates)) return CLI_WRONG;
    if (!coordinates) usual_coordinates(o);
    if (!coordinates && o->motion->n > o->n_shown)
        fprintf(stderr,
                "ricochet: %d of %d coordinates are shown; --coordinates I,J chooses which\n",
                o->n_shown, o->motion->n);
    const int code = read_data(o, data);
    if (code != CLI_DONE) return code;
    choose_gaps(o);
    return draw(o);
}

int plot_motion_page(const plot_options *common, plot_motion *motion, const char *title,
                     const char *coordinates, const char *data)
{
    orbit o = {.common = common, .motion = motion, .unit = plot_units_of(common, motion->model)};
    if (title) snprintf(o.title, sizeof o.title, "%s", title);
    const int code = show(&o, coordinates, data);
    plot_table_free(&o.data);
    plot_page_free(o.page);
    return code;
}

static int find_and_draw(orbit *o, const words *w)
{
    o->motion->model = ric_atlas_model(o->atlas);
    o->motion->n = ric_model_n_dof(o->motion->model);
    o->unit = plot_units_of(o->common, o->motion->model);
    const int code = w->junction ? take_junction(o, w->junction) : take_branch(o, w);
    if (code != CLI_DONE) return code;
    const ric_status status = plot_motion_make(o->motion);
    return status == RIC_OK ? show(o, w->coordinates, w->data) : cli_report(status);
}

int plot_orbit(int argc, char **argv, const plot_options *common)
{
    plot_motion motion = {0};
    orbit o = {.common = common, .motion = &motion};
    words w = {0};
    int code = parse(&argc, argv, &w);
    if (code != CLI_DONE) return code;
    const ric_status status = ric_atlas_read(argv[1], &o.atlas);
    if (status != RIC_OK) return cli_report(status);
    code = find_and_draw(&o, &w);
    plot_table_free(&o.data);
    plot_page_free(o.page);
    ric_atlas_free(o.atlas);
    plot_motion_free(&motion);
    return code;
}
