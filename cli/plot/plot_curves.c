/* Unknowns of branches against each other. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot_quantity.h"

static const double type = 12;

/* The place on a track at an arclength, between its points. */
static plot_point track_at(const plot_track *t, double arclength)
{
    int i = 1;
    while (i < t->n - 1 && t->knots[i].arclength < arclength) i++;
    if (t->n < 2) return t->n ? t->knots[0].at : (plot_point){NAN, NAN};
    const plot_knot *a = &t->knots[i - 1], *b = &t->knots[i];
    const double length = b->arclength - a->arclength,
                 part = length > 0 ? fmax(0, fmin(1, (arclength - a->arclength) / length)) : 0;
    return (plot_point){a->at.x + part * (b->at.x - a->at.x), a->at.y + part * (b->at.y - a->at.y)};
}

/* ------------------------------------------------------------------- curves */

typedef struct {
    const plot_options *common;
    ric_atlas *atlas;
    plot_quantity x, y, z;
    bool log_x, log_y, spatial;  /* the last: z, too */
    int n_branch, *branches;     /* ids */
    plot_track *tracks, *depths; /* (x, y), and (z, z) of the same knots */
    plot_page *page;
    plot_panel panel;
    plot_space space;
    plot_table data; /* of one's own, in the columns of x and y */
    bool has_window;
    double window[6]; /* x from, to, y from, to, z from, to */
    bool family[3];
    unsigned stability;
    bool kinds[RIC_KIND_USER + 1];
    enum { TAGS_ALL, TAGS_NAMED, TAGS_NONE } wanted;
    int n_tag;
    plot_tag *tags;
} curves;

static bool track_range(const curves *c, double x[2], double y[2])
{
    plot_range_empty(x, y);
    for (int i = 0; i < c->n_branch; i++)
        for (int k = 0; k < c->tracks[i].n; k++) {
            const plot_point p = c->tracks[i].knots[k].at;
            if (!isfinite(p.x) || !isfinite(p.y) || (c->log_x && p.x <= 0) ||
                (c->log_y && p.y <= 0))
                continue;
            plot_range_take(p, x, y);
        }
    if (!(x[1] >= x[0])) return false;
    if (c->has_window) {
        for (int i = 0; i < 2; i++) {
            x[i] = c->window[i] / c->x.unit;
            y[i] = c->window[2 + i] / c->y.unit;
        }
        return true;
    }
    plot_range_widen(c->log_x, 0.05, &x[0], &x[1]);
    plot_range_widen(c->log_y, 0.05, &y[0], &y[1]);
    return true;
}

static plot_axis axis_of(const plot_quantity *q, bool logarithmic, const double range[2],
                         double from, double to)
{
    return (plot_axis){.scale = logarithmic             ? PLOT_SCALE_LOG
                                : q->kind == PLOT_TRACE ? PLOT_SCALE_ASINH
                                                        : PLOT_SCALE_LINEAR,
                       .lo = range[0],
                       .hi = range[1],
                       .from = from,
                       .to = to,
                       .unit = q->unit};
}

/* Range of z on what the windows of x and y leave. */
static bool depth_range(curves *c, const double x[2], const double y[2], double z[2])
{
    z[0] = INFINITY;
    z[1] = -INFINITY;
    for (int i = 0; i < c->n_branch; i++)
        for (int k = 0; k < c->tracks[i].n; k++) {
            const plot_point p = c->tracks[i].knots[k].at;
            const double depth = c->depths[i].knots[k].at.x;
            if (!(p.x >= x[0] && p.x <= x[1] && p.y >= y[0] && p.y <= y[1]) || !isfinite(depth))
                continue;
            z[0] = fmin(z[0], depth);
            z[1] = fmax(z[1], depth);
        }
    for (int i = 0; i < 2 && c->has_window; i++) z[i] = c->window[4 + i] / c->z.unit;
    if (z[1] >= z[0] && !c->has_window) plot_range_widen(false, 0.05, &z[0], &z[1]);
    return z[1] > z[0];
}

/* What the curves would throw on the floor, if light came from above. */
static void draw_shadows(const curves *c)
{
    for (int i = 0; i < c->n_branch; i++) {
        const plot_track *t = &c->tracks[i];
        double *floor = malloc(3 * ((size_t)t->n + 1) * sizeof *floor);
        for (int k = 0; floor && k < t->n; k++) {
            const double z = c->depths[i].knots[k].at.x;
            const bool seen = z >= c->space.lo[2] && z <= c->space.hi[2];
            floor[3 * k] = t->knots[k].at.x;
            floor[3 * k + 1] = t->knots[k].at.y;
            floor[3 * k + 2] = seen ? c->space.lo[2] : NAN;
        }
        if (floor) plot_space_curve(c->page, &c->space, PLOT_SHADOW, t->n, floor);
        free(floor);
    }
}

/* From here on tracks are what is seen on the page, in pixels: the view is linear, so that they
 * stay smooth. */
static void project(curves *c)
{
    for (int i = 0; i < c->n_branch; i++)
        for (int k = 0; k < c->tracks[i].n; k++) {
            plot_knot *knot = &c->tracks[i].knots[k];
            const double p[3] = {knot->at.x, knot->at.y, c->depths[i].knots[k].at.x};
            const bool inside = plot_space_inside(&c->space, p);
            knot->at = plot_space_at(&c->space, p);
            if (inside) continue;
            knot->gap = true;
            if (k > 0) c->tracks[i].knots[k - 1].gap = true;
        }
}

static bool look_from_front(curves *c, const double x[2], const double y[2])
{
    double z[2];
    if (!depth_range(c, x, y, z)) return false;
    const double width = plot_page_width(c->page), height = plot_page_height(c->page);
    const plot_space view = c->space;
    c->space = (plot_space){{96, 112, width - 60, height - plot_page_head(c->common, NULL)},
                            {x[0], y[0], z[0]},
                            {x[1], y[1], z[1]},
                            {c->x.unit, c->y.unit, c->z.unit},
                            view.around,
                            view.above};
    c->panel = plot_pixels(c->page);
    draw_shadows(c);
    project(c);
    return true;
}

static void mark_junction(curves *c, int id, plot_point data)
{
    ric_junction junction;
    if (id <= 0 || !plot_panel_inside(&c->panel, data) ||
        ric_atlas_junction(c->atlas, id, &junction) != RIC_OK || junction.kind == RIC_KIND_START)
        return;
    const plot_point at = plot_panel_at(&c->panel, data);
    const bool named = junction.name && *junction.name;
    plot_page_mark(c->page, plot_junction_mark(junction.kind), at, 4);
    c->kinds[junction.kind] = true;
    if (c->wanted == TAGS_NONE || (c->wanted == TAGS_NAMED && !named)) return;
    plot_tag *tags = realloc(c->tags, ((size_t)c->n_tag + 1) * sizeof *tags);
    if (!tags) return;
    c->tags = tags;
    plot_tag *tag = &tags[c->n_tag++];
    *tag = (plot_tag){.at = at,
                      .clear = 4,
                      .weight = (named ? 1000 : 0) - junction.impacts,
                      .group = id,
                      .colour = "#000000",
                      .leader = true};
    plot_text_label(named ? junction.name : junction.label, sizeof tag->text, tag->text);
}

/* Whether a place lies beyond the box of three axes. */
static bool beyond(const curves *c, const plot_track *t, double arclength)
{
    int i = 0;
    while (i < t->n - 1 && t->knots[i + 1].arclength <= arclength) i++;
    return c->spatial && t->knots[i].gap;
}

static ric_status draw_curves(curves *c)
{
    for (int i = 0; i < c->n_branch; i++) {
        ric_branch branch;
        const ric_status status = ric_atlas_branch(c->atlas, c->branches[i], &branch);
        if (status != RIC_OK) return status;
        const plot_stroke family = plot_branch_family(ric_atlas_model(c->atlas), &branch);
        if (plot_quantity_smooth(&c->x) && plot_quantity_smooth(&c->y) &&
            (!c->spatial || plot_quantity_smooth(&c->z)) &&
            !plot_track_smooth(&c->panel, &c->tracks[i]))
            return RIC_E_NOMEM;
        const unsigned seen = plot_track_draw(c->page, &c->panel, family, &c->tracks[i]);
        c->stability |= seen;
        c->family[(family - PLOT_LINEAR) / 3] |= seen != 0;
    }
    for (int i = 0; i < c->n_branch; i++) {
        ric_branch branch;
        const plot_track *t = &c->tracks[i];
        if (ric_atlas_branch(c->atlas, c->branches[i], &branch) != RIC_OK || t->n == 0) continue;
        if (!beyond(c, t, t->knots[0].arclength)) mark_junction(c, branch.from, t->knots[0].at);
        if (!beyond(c, t, t->knots[t->n - 1].arclength))
            mark_junction(c, branch.to, t->knots[t->n - 1].at);
        for (int k = 0; k < branch.n_junction; k++)
            if (!beyond(c, t, branch.junction_at[k]))
                mark_junction(c, branch.junctions[k], track_at(t, branch.junction_at[k]));
    }
    return RIC_OK;
}

static int draw_curve_page(curves *c)
{
    const double width = plot_layout_width(c->common, PLOT_WIDTH),
                 height = plot_layout_height(c->common, 500);
    double x[2], y[2];
    plot_legend_entry entries[PLOT_MAX_LEGEND];
    if (!track_range(c, x, y)) {
        fprintf(stderr,
                "ricochet: nothing to draw: no point of these branches has both %s and %s%s\n",
                c->x.title, c->y.title, c->log_x || c->log_y ? " with a logarithm" : "");
        return CLI_FAILED;
    }
    c->page = plot_page_create(width, height);
    if (!c->page) return cli_report(RIC_E_NOMEM);
    if (c->spatial && !look_from_front(c, x, y)) {
        cli_say("ricochet: nothing to draw: no point of these branches lies in the window\n");
        return CLI_FAILED;
    }
    if (!c->spatial)
        c->panel = (plot_panel){axis_of(&c->x, c->log_x, x, 78, width - 18),
                                axis_of(&c->y, c->log_y, y, 92,
                                        height - plot_page_head(c->common, NULL))};
    const ric_status status = draw_curves(c);
    if (status != RIC_OK) return cli_report(status);
    const char *const titles[3] = {c->x.title, c->y.title, c->z.title};
    if (c->spatial) plot_space_frame(c->page, &c->space, titles);
    else plot_panel_frame(c->page, &c->panel, c->x.title, c->y.title);
    for (int i = 0; i < c->data.n && !c->spatial; i++)
        plot_panel_dot(c->page, &c->panel, PLOT_DATA,
                       (plot_point){plot_table_at(&c->data, i, 0) / c->x.unit,
                                    plot_table_at(&c->data, i, 1) / c->y.unit});
    const int missing = plot_place_tags(c->page, plot_panel_box(&c->panel), c->n_tag, c->tags,
                                        type);
    if (missing)
        fprintf(stderr,
                "ricochet: %d label%s left out for want of room; --branch or --size make more\n",
                missing, missing == 1 ? "" : "s");
    plot_page_title(c->page, c->common, NULL);
    int n = plot_legend_entries(c->family, c->stability, NULL, entries);
    if (c->data.n) entries[n++] = (plot_legend_entry){c->data.name, PLOT_DATA, -1};
    n += plot_legend_entries(NULL, 0, c->kinds, entries + n);
    plot_legend(c->page, n, entries, 12, width - 12,
                (c->spatial ? 0 : c->panel.y.from) - 46 + 92 * c->spatial);
    return plot_page_write(c->page, c->common);
}

/* --branch ID, as often as it is given; all branches if it is not. */
static int take_branches(int *argc, char **argv, int *n, int **out)
{
    const char *text;
    while (true) {
        long id;
        if (!cli_take_value(argc, argv, "--branch", &text)) return CLI_WRONG;
        if (!text) return CLI_DONE;
        if (!cli_parse_integer(text, "--branch", 1, 2147483647, &id)) return CLI_WRONG;
        int *more = realloc(*out, ((size_t)*n + 1) * sizeof *more);
        if (!more) return cli_report(RIC_E_NOMEM);
        *out = more;
        more[(*n)++] = (int)id;
    }
}

static ric_status load_tracks(curves *c)
{
    const int total = ric_atlas_n_branch(c->atlas);
    if (c->n_branch == 0) {
        c->branches = malloc(((size_t)total + 1) * sizeof *c->branches);
        if (!c->branches) return RIC_E_NOMEM;
        for (; c->n_branch < total; c->n_branch++) c->branches[c->n_branch] = c->n_branch + 1;
    }
    c->tracks = calloc((size_t)c->n_branch + 1, sizeof *c->tracks);
    c->depths = calloc((size_t)c->n_branch + 1, sizeof *c->depths);
    ric_status status = c->tracks && c->depths ? RIC_OK : RIC_E_NOMEM;
    for (int i = 0; status == RIC_OK && i < c->n_branch; i++) {
        ric_branch branch;
        status = ric_atlas_branch(c->atlas, c->branches[i], &branch);
        if (status == RIC_OK)
            status = plot_quantity_track(c->atlas, &branch, &c->x, &c->y, &c->tracks[i]);
        if (status == RIC_OK && c->spatial)
            status = plot_quantity_track(c->atlas, &branch, &c->z, &c->z, &c->depths[i]);
    }
    return status;
}

/* A:B,C:D,E:F */
static bool take_space(const char *text, double window[6])
{
    char first[200];
    const char *last = strrchr(text, ',');
    if (!last || (size_t)(last - text) >= sizeof first ||
        !memchr(text, ',', (size_t)(last - text))) {
        cli_wrong("--window %s: of three axes a window is X0:X1,Y0:Y1,Z0:Z1", text);
        return false;
    }
    snprintf(first, sizeof first, "%.*s", (int)(last - text), text);
    return plot_parse_window(first, "--window", window) &&
           plot_parse_range(last + 1, "--window", window + 4);
}

static bool take_labels(int *argc, char **argv, curves *c)
{
    static const char *const choices[] =
        {[TAGS_ALL] = "all", [TAGS_NAMED] = "named", [TAGS_NONE] = "none"};
    const char *labels = NULL;
    if (!cli_take_value(argc, argv, "--labels", &labels)) return false;
    for (unsigned i = TAGS_ALL; i <= TAGS_NONE; i++) {
        if (labels && strcmp(labels, choices[i])) continue;
        c->wanted = i;
        return true;
    }
    cli_wrong("--labels %s: there are all, named and none", labels);
    return false;
}

int plot_curves(int argc, char **argv, const plot_options *common)
{
    curves c = {.common = common};
    const char *data = NULL, *x = NULL, *y = NULL, *z = NULL, *view = NULL, *logs = NULL,
               *window = NULL;
    int code = take_branches(&argc, argv, &c.n_branch, &c.branches);
    if (code != CLI_DONE || !cli_take_value(&argc, argv, "--x", &x) ||
        !cli_take_value(&argc, argv, "--y", &y) || !cli_take_value(&argc, argv, "--z", &z) ||
        !cli_take_value(&argc, argv, "--data", &data) ||
        !cli_take_value(&argc, argv, "--view", &view) ||
        !cli_take_value(&argc, argv, "--log", &logs) ||
        !cli_take_value(&argc, argv, "--window", &window) || !take_labels(&argc, argv, &c) ||
        !cli_operands(&cli_plot, argc, argv, 1)) {
        code = code != CLI_DONE ? code : CLI_WRONG;
        goto out;
    }
    if (!x || !y) {
        code = cli_wrong(
            "plot curves: --x NAME and --y NAME are needed, for example --x x1 --y v1");
        goto out;
    }
    if (logs && strcmp(logs, "x") && strcmp(logs, "y") && strcmp(logs, "xy")) {
        code = cli_wrong("--log %s: there are x, y and xy", logs);
        goto out;
    }
    c.has_window = window;
    c.spatial = z;
    if (data && z) {
        code = cli_wrong("--data %s: goes with two axes", data);
        goto out;
    }
    if (data &&
        (code = plot_table_read(data, 2, (const char *const[]){x, y}, 2, &c.data)) != CLI_DONE)
        goto out;
    if (view && !z) {
        code = cli_wrong("--view %s: goes with --z", view);
        goto out;
    }
    if (!plot_parse_view(view, &c.space)) {
        code = CLI_WRONG;
        goto out;
    }
    if (z && logs) {
        code = cli_wrong("--log %s: three axes are linear", logs);
        goto out;
    }
    if (window &&
        !(z ? take_space(window, c.window) : plot_parse_window(window, "--window", c.window))) {
        code = CLI_WRONG;
        goto out;
    }
    c.log_x = logs && *logs == 'x';
    c.log_y = logs && logs[strlen(logs) - 1] == 'y';
    if (window && ((c.log_x && c.window[0] <= 0) || (c.log_y && c.window[2] <= 0))) {
        code = cli_wrong("--window %s: a logarithmic axis starts above 0", window);
        goto out;
    }
    ric_status status = ric_atlas_read(argv[1], &c.atlas);
    if (status != RIC_OK) {
        code = cli_report(status);
        goto out;
    }
    const int n_dof = ric_model_n_dof(ric_atlas_model(c.atlas));
    if (!plot_quantity_find(x, "--x", n_dof, &c.x) || !plot_quantity_find(y, "--y", n_dof, &c.y) ||
        (z && !plot_quantity_find(z, "--z", n_dof, &c.z))) {
        code = CLI_WRONG;
        goto out;
    }
    plot_quantity_set_unit(&c.x, common, c.atlas);
    plot_quantity_set_unit(&c.y, common, c.atlas);
    plot_quantity_set_unit(&c.z, common, c.atlas);
    status = load_tracks(&c);
    code = status == RIC_OK ? draw_curve_page(&c) : cli_report(status);
out:
    for (int i = 0; c.tracks && i < c.n_branch; i++) plot_track_free(&c.tracks[i]);
    for (int i = 0; c.depths && i < c.n_branch; i++) plot_track_free(&c.depths[i]);
    free(c.depths);
    plot_table_free(&c.data);
    plot_page_free(c.page);
    ric_atlas_free(c.atlas);
    free(c.tracks);
    free(c.branches);
    free(c.tags);
    return code;
}
