/* Pictures of cascades: the bifurcation diagram, the shapes at the multiplications, and multipliers
 * on the unit circle. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

static const double type = 12;
enum { SAMPLES = 1600, ARC = 240 };
/* Solid lines, dark and orange; the same thick, for dots. */
static const plot_stroke thin[2] = {PLOT_SYMMETRIC + RIC_STABLE_NO,
                                    PLOT_ASYMMETRIC + RIC_STABLE_NO};
static const plot_stroke thick[2] = {PLOT_SYMMETRIC + RIC_STABLE_YES,
                                     PLOT_ASYMMETRIC + RIC_STABLE_YES};

typedef struct {
    const plot_options *common;
    ric_atlas *atlas;
    ric_branch branch;
    cli_cascade_request request;
    ric_cascade *cascade;
    int dof;        /* from 0 */
    long duplicate; /* K of --circle */
    bool shapes, circle;
    plot_page *page;
} picture;

static bool make_page(picture *p, double height)
{
    p->page = plot_page_create(plot_layout_width(p->common, PLOT_WIDTH),
                               plot_layout_height(p->common, height));
    return p->page;
}

static plot_units units_of(const picture *p)
{
    return plot_units_of(p->common, ric_atlas_model(p->atlas));
}

/* The name that the study gives to a multiplication by q at an energy; false if it gives none. */
static bool name_of(const picture *p, double energy, int q, size_t size, char *out)
{
    for (int id = 1; id <= ric_atlas_n_junction(p->atlas); id++) {
        ric_junction j;
        if (ric_atlas_junction(p->atlas, id, &j) != RIC_OK || j.kind != RIC_KIND_MULTIPLICATION ||
            !j.name || !*j.name || j.multiple != q || fabs(j.energy - energy) > 1e-7 * energy)
            continue;
        plot_text_label(j.name, size, out);
        return true;
    }
    return false;
}

/* Whether there are no impacts at all: law power. */
static bool smooth(const picture *p)
{
    return ric_model_n_face(ric_atlas_model(p->atlas)) == 0;
}

/* Periods of the branch in one of the orbit of a step. */
static double periods(const picture *p, int step)
{
    double product = 1;
    for (int i = 0; i < step; i++) {
        ric_cascade_step s;
        ric_cascade_step_at(p->cascade, i, &s);
        product *= s.multiple;
    }
    return product;
}

/* ----------------------------------------------------------------- diagram */

/* The families of a cascade: for each a line of displacements for every impact. */
typedef struct {
    int n_point, impacts;
    double from;           /* accumulated frequency where it starts */
    double *way;           /* [n_point] accumulated frequency */
    double *x;             /* [n_point * impacts] */
    ric_stability *stable; /* [n_point] */
} strip;

static ric_status read_strip(const picture *p, int step, double from, strip *out)
{
    const int n_dof = ric_model_n_dof(ric_atlas_model(p->atlas));
    ric_cascade_step s;
    ric_status status = ric_cascade_step_at(p->cascade, step, &s);
    const double product = periods(p, step);
    double before = NAN, *x = NULL;
    if (status) return status;
    *out = (strip){.n_point = s.n_point,
                   .impacts = ric_cascade_impacts(p->cascade, step),
                   .from = from};
    out->way = calloc((size_t)out->n_point + 1, sizeof *out->way);
    out->x = calloc((size_t)out->n_point * (size_t)out->impacts + 1, sizeof *out->x);
    out->stable = calloc((size_t)out->n_point + 1, sizeof *out->stable);
    x = calloc((size_t)out->impacts * (size_t)n_dof + 1, sizeof *x);
    if (!out->way || !out->x || !out->stable || !x) status = RIC_E_NOMEM;
    for (int i = 0; !status && i < out->n_point; i++) {
        ric_point point;
        if ((status = ric_cascade_point(p->cascade, step, i, &point, x))) break;
        from += i ? fabs(product * (point.frequency - before)) : 0;
        before = point.frequency;
        out->way[i] = from;
        out->stable[i] = (ric_stability)point.stable;
        for (int k = 0; k < out->impacts; k++)
            out->x[(size_t)i * (size_t)out->impacts + (size_t)k] = x[k * n_dof + p->dof];
    }
    free(x);
    return status;
}

/* Thick where stable: from a point of one kind to the first of the next. */
static void draw_strip(picture *p, const plot_panel *panel, int step, const strip *s)
{
    plot_point *line = malloc(((size_t)s->n_point + 1) * sizeof *line);
    for (int k = 0; line && k < s->impacts; k++) {
        for (int i = 0; i < s->n_point; i++)
            line[i] = (plot_point){s->way[i], s->x[(size_t)i * (size_t)s->impacts + (size_t)k]};
        for (int i = 0, first = 0; i < s->n_point; i++) {
            if (i + 1 < s->n_point && s->stable[i + 1] == s->stable[first]) continue;
            const bool stable = s->stable[first] == RIC_STABLE_YES;
            const int last = i + 1 < s->n_point ? i + 1 : i;
            plot_panel_curve(p->page, panel, stable ? thick[step % 2] : thin[step % 2],
                             last - first + 1, line + first);
            first = last;
        }
    }
    free(line);
}

/* What is drawn. */
static void draw_legend(picture *p, int n, const strip *strips, double top)
{
    plot_legend_entry entries[3];
    bool seen[2] = {false, false};
    int count = 0;
    for (int i = 1; i < n; i++)
        for (int k = 0; k < strips[i].n_point; k++)
            seen[strips[i].stable[k] == RIC_STABLE_YES] = true;
    if (seen[1]) entries[count++] = (plot_legend_entry){"stable", (int)thick[1], -1};
    if (seen[0]) entries[count++] = (plot_legend_entry){"unstable", (int)thin[1], -1};
    if (n > 2) entries[count++] = (plot_legend_entry){"every other family", (int)thin[0], -1};
    plot_legend(p->page, count, entries, 12, plot_page_width(p->page) - 12, top);
}

/* A dashed line where each family starts, labelled with its p/q and impacts. */
static void mark_strips(picture *p, const plot_panel *panel, int n, const strip *strips)
{
    plot_tag tags[CLI_MAX_CASCADE + 1];
    int n_tag = 0;
    const plot_box above = {panel->x.from - 30, panel->y.to + 4, panel->x.to, panel->y.to + 40};
    for (int i = 1; i < n; i++) {
        ric_cascade_step s;
        const double at = strips[i].n_point ? strips[i].way[0] : 0;
        const plot_point foot[2] = {{at, panel->y.lo}, {at, panel->y.hi}};
        ric_cascade_step_at(p->cascade, i - 1, &s);
        plot_panel_curve(p->page, panel, PLOT_NATURAL, 2, foot);
        plot_tag *t = &tags[n_tag++];
        *t = (plot_tag){.at = {plot_axis_at(&panel->x, at), panel->y.to + 12},
                        .clear = 0,
                        .weight = n - i,
                        .colour = "#000000"};
        if (!name_of(p, s.energy, s.multiple, sizeof t->text, t->text))
            snprintf(t->text, sizeof t->text, "%d/%d", s.rotation[0], s.rotation[1]);
    }
    plot_place_tags(p->page, above, n_tag, tags, type);
}

static int draw_diagram(picture *p)
{
    const int n = ric_cascade_length(p->cascade);
    strip *strips = calloc((size_t)n + 1, sizeof *strips);
    double x = 0, y[2] = {INFINITY, -INFINITY};
    char name[64];
    int code = CLI_FAILED;
    ric_status status = strips && make_page(p, 500) ? RIC_OK : RIC_E_NOMEM;
    for (int i = 1; !status && i < n; i++) {
        status = read_strip(p, i, x, &strips[i]);
        if (!status && strips[i].n_point) x = strips[i].way[strips[i].n_point - 1];
        for (int k = 0; !status && k < strips[i].n_point * strips[i].impacts; k++) {
            y[0] = fmin(y[0], strips[i].x[k]);
            y[1] = fmax(y[1], strips[i].x[k]);
        }
    }
    if (status) code = cli_report(status);
    else if (!(y[0] <= y[1]))
        code = cli_wrong("plot cascade: with one multiplication there is no family to draw; ask "
                         "for two at least, or "
                         "for --multiply, which ends with a family");
    else {
        plot_range_widen(false, 0.04, &y[0], &y[1]);
        const plot_units unit = units_of(p);
        plot_panel panel =
            {{.from = 82, .to = plot_page_width(p->page) - 24, .lo = 0, .hi = x > 0 ? 1.02 * x : 1},
             {.from = 90,
              .to = plot_page_height(p->page) - 30 - plot_page_head(p->common, NULL),
              .lo = y[0],
              .hi = y[1]}};
        panel.x.unit = unit.frequency;
        panel.y.unit = unit.length;
        for (int i = 1; i < n; i++) draw_strip(p, &panel, i, &strips[i]);
        snprintf(name, sizeof name,
                 smooth(p) ? "once a period of the branch: x_{%d}" : "at impacts: x_{%d}",
                 p->dof + 1);
        plot_panel_frame(p->page, &panel,
                         p->common->hertz
                             ? "frequency passed on the way, times the multiplicities (Hz)"
                             : "frequency passed on the way, times the multiplicities (rad/s)",
                         name);
        draw_legend(p, n, strips, panel.y.from - 46);
        mark_strips(p, &panel, n, strips);
        plot_page_title(p->page, p->common, NULL);
        code = plot_page_write(p->page, p->common);
    }
    for (int i = 0; strips && i < n; i++) {
        free(strips[i].way);
        free(strips[i].x);
        free(strips[i].stable);
    }
    free(strips);
    return code;
}

/* ------------------------------------------------------------------ shapes */

/* Whether the velocity jumps from one sample to the next: much more than beside it. */
static bool jumps(int n, const plot_point *data, int i, double range)
{
    const double step = fabs(data[i + 1].y - data[i].y),
                 before = i > 0 ? fabs(data[i].y - data[i - 1].y) : 0,
                 after = i + 2 < n ? fabs(data[i + 2].y - data[i + 1].y) : 0;
    return step > 0.01 * range && step > 3 * fmax(before, after);
}

/* Samples of a phase portrait, `step` apart in time; where the velocity jumps a dashed line, as in
 * the pictures of orbits, where the motion before meets that after it. */
static void draw_portrait(picture *p, const plot_panel *panel, double step, int n,
                          const plot_point *data)
{
    for (int i = 0, first = 0; i < n; i++) {
        if (i + 1 < n && !jumps(n, data, i, panel->y.hi - panel->y.lo)) continue;
        plot_panel_curve(p->page, panel, thin[1], i + 1 - first, data + first);
        first = i + 1;
        if (first == n) break;
        const plot_point *from = data + i, *to = from + 1;
        const double t = (to->x - from->x - to->y * step) / (from->y - to->y),
                     x = from->x + from->y * fmax(0, fmin(step, t));
        const plot_point before = {x, from->y}, after = {x, to->y};
        plot_panel_curve(p->page, panel, thin[1], 2, (plot_point[]){*from, before});
        plot_panel_curve(p->page, panel, PLOT_JUMP, 2, (plot_point[]){before, after});
        plot_panel_curve(p->page, panel, thin[1], 2, (plot_point[]){after, *to});
    }
}

/* One row: the displacement over as many periods as give the impacts of the last orbit, and its
 * phase portrait. */
static bool draw_shape(picture *p, int step, plot_box row, const double range[2],
                       const double speed[2], bool last)
{
    const int n = ric_cascade_length(p->cascade),
              n_dof = ric_model_n_dof(ric_atlas_model(p->atlas));
    const double gap = 76, split = row.right - (row.top - row.bottom) - gap,
                 times = periods(p, n - 1) / periods(p, step);
    ric_cascade_step s;
    ric_cascade_step_at(p->cascade, step, &s);
    const double period = 2 * CLI_PI / s.frequency;
    double *state = calloc(2 * (size_t)n_dof, sizeof *state);
    plot_point *history = calloc(SAMPLES + 1, sizeof *history),
               *portrait = calloc(SAMPLES + 1, sizeof *portrait);
    plot_panel left = {{.from = row.left, .to = split, .lo = 0, .hi = 1},
                       {.from = row.bottom, .to = row.top, .lo = range[0], .hi = range[1]}};
    plot_panel right = {{.from = split + gap, .to = row.right, .lo = range[0], .hi = range[1]},
                        {.from = row.bottom, .to = row.top, .lo = speed[0], .hi = speed[1]}};
    char text[240], name[32];
    const bool good = state && history && portrait;
    left.y.unit = right.x.unit = right.y.unit = units_of(p).length;
    for (int i = 0; good && i <= SAMPLES; i++) {
        ric_cascade_at_time(p->cascade, step, period * times * i / SAMPLES, state, state + n_dof);
        history[i] = (plot_point){(double)i / SAMPLES, state[p->dof]};
        portrait[i] = (plot_point){state[p->dof], state[n_dof + p->dof]};
    }
    if (good) {
        plot_panel_curve(p->page, &left, thin[0], SAMPLES + 1, history);
        draw_portrait(p, &right, period * times / SAMPLES, SAMPLES + 1, portrait);
        snprintf(name, sizeof name, "x_{%d}", p->dof + 1);
        plot_panel_frame(p->page, &left, last ? "time, in periods of the last orbit" : NULL, name);
        snprintf(text, sizeof text, "v_{%d}", p->dof + 1);
        plot_panel_frame(p->page, &right, last ? name : NULL, text);
        char place[120], what[64] = "end";
        plot_place_text(p->common, ric_atlas_model(p->atlas), s.energy, s.frequency, sizeof place,
                        place);
        if (s.multiple > 1)
            snprintf(what, sizeof what, "p/q = %d/%d", s.rotation[0], s.rotation[1]);
        if (smooth(p)) snprintf(text, sizeof text, "%s,  %s", what, place);
        else if (s.multiple > 1)
            snprintf(text, sizeof text, "%s,  %d impact%s,  %s", what, s.impacts,
                     cli_plural(s.impacts), place);
        else
            snprintf(text, sizeof text, "%s,  %d impact%s, %d touch%s,  %s", what, s.impacts,
                     cli_plural(s.impacts), s.grazings, s.grazings == 1 ? "" : "es", place);
        char whole[340], own[64];
        const bool named = s.multiple > 1 && name_of(p, s.energy, s.multiple, sizeof own, own);
        snprintf(whole, sizeof whole, "(%c)  %s%s%s", 'a' + step % 26, named ? own : "",
                 named ? ":  " : "", text);
        plot_page_text(p->page, (plot_point){row.left, row.top + 11}, PLOT_LEFT, type, "#000000",
                       false, whole);
    }
    free(state);
    free(history);
    free(portrait);
    return good;
}

static void shape_ranges(const picture *p, double x[2], double v[2])
{
    const int n_dof = ric_model_n_dof(ric_atlas_model(p->atlas));
    double state[2 * n_dof];
    x[0] = v[0] = INFINITY;
    x[1] = v[1] = -INFINITY;
    for (int step = 0; step < ric_cascade_length(p->cascade); step++) {
        ric_cascade_step s;
        ric_cascade_step_at(p->cascade, step, &s);
        for (int i = 0; i < SAMPLES; i++) {
            ric_cascade_at_time(p->cascade, step, 2 * CLI_PI / s.frequency * i / SAMPLES, state,
                                state + n_dof);
            x[0] = fmin(x[0], state[p->dof]);
            x[1] = fmax(x[1], state[p->dof]);
            v[0] = fmin(v[0], state[n_dof + p->dof]);
            v[1] = fmax(v[1], state[n_dof + p->dof]);
        }
    }
    plot_range_widen(false, 0.06, &x[0], &x[1]);
    plot_range_widen(false, 0.06, &v[0], &v[1]);
}

static int draw_shapes(picture *p)
{
    const int n = ric_cascade_length(p->cascade);
    double x[2], v[2];
    if (!make_page(p, 70 + 132.0 * n)) return cli_report(RIC_E_NOMEM);
    const double top = plot_page_height(p->page) - plot_page_head(p->common, NULL) - 22,
                 bottom = 30, step = (top - bottom) / n;
    shape_ranges(p, x, v);
    for (int i = 0; i < n; i++) {
        const plot_box row = {72, top - (i + 1) * step + 28, plot_page_width(p->page) - 20,
                              top - i * step};
        if (!draw_shape(p, i, row, x, v, i + 1 == n)) return cli_report(RIC_E_NOMEM);
    }
    plot_page_title(p->page, p->common, NULL);
    return plot_page_write(p->page, p->common);
}

/* ------------------------------------------------------------------ circle */

/* From one stored point to the next: arcs of the circle, the second one drawn inside of it to be
 * seen. */
static void draw_step(picture *p, const plot_panel *circle, const plot_panel *angles, double before,
                      double last, const ric_point *point)
{
    enum { PIECES = 16 };
    static const double radius[2] = {1, 0.93};
    const double turn = remainder(point->rotation - last, 1);
    for (int k = 0; k < 2; k++) {
        const double sign = k ? -1 : 1;
        plot_point arc[PIECES + 1];
        for (int i = 0; i <= PIECES; i++) {
            const double angle = 2 * CLI_PI * sign * (last + turn * i / PIECES);
            arc[i] = (plot_point){radius[k] * cos(angle), radius[k] * sin(angle)};
        }
        plot_panel_curve(p->page, circle, thick[k], PIECES + 1, arc);
        if (fabs(point->rotation - last) < 0.5)
            plot_panel_curve(p->page, angles, thick[k], 2,
                             (plot_point[]){{before, k ? 1 - last : last},
                                            {point->arclength,
                                             k ? 1 - point->rotation : point->rotation}});
    }
}

/* What the study calls the multiplication of the branch at k/K. */
static bool root_name(const picture *p, long k, size_t size, char *out)
{
    for (int i = 0; i < p->branch.n_junction; i++) {
        ric_junction j;
        if (ric_atlas_junction(p->atlas, p->branch.junctions[i], &j) != RIC_OK ||
            j.kind != RIC_KIND_MULTIPLICATION || !j.name || !*j.name ||
            ric_junction_level(&j, &p->branch) < 2 ||
            j.rotation[0] * p->duplicate != k * j.rotation[1])
            continue;
        plot_text_label(j.name, size, out);
        return true;
    }
    return false;
}

/* The circle itself and the roots of unity p/K outside it, where the K-duplicate has its
 * multiplications. */
static void draw_roots(picture *p, const plot_panel *circle, const plot_panel *angles)
{
    plot_point arc[ARC + 1];
    char text[48];
    for (int i = 0; i <= ARC; i++)
        arc[i] = (plot_point){cos(2 * CLI_PI * i / ARC), sin(2 * CLI_PI * i / ARC)};
    plot_panel_curve(p->page, circle, PLOT_GRID, ARC + 1, arc);
    for (int k = 1; k < p->duplicate; k++) {
        const double gamma = (double)k / (double)p->duplicate;
        const plot_point at = {cos(2 * CLI_PI * gamma), sin(2 * CLI_PI * gamma)},
                         tip = {1.25 * at.x, 1.25 * at.y};
        const plot_point line[2] = {{angles->x.lo, gamma}, {angles->x.hi, gamma}};
        plot_page_mark(p->page, PLOT_STAR, plot_panel_at(circle, at), 4);
        if (!root_name(p, k, sizeof text, text))
            snprintf(text, sizeof text, "%d/%ld", k, p->duplicate);
        plot_page_text(p->page, plot_panel_at(circle, tip), PLOT_CENTRE, type, "#000000", false,
                       text);
        plot_panel_curve(p->page, angles, PLOT_GRID, 2, line);
    }
}

/* Where the pair goes as the arclength grows: an arrow beside the circle, at the angle that it has
 * half way. */
static void draw_direction(picture *p, const plot_panel *circle, double before, double after,
                           plot_stroke stroke, double radius)
{
    const double turn = remainder(after - before, 1), step = turn > 0 ? 1 : -1,
                 middle = before + turn / 2;
    plot_point arrow[12];
    if (turn == 0) return;
    for (int i = 0; i < 9; i++) {
        const double angle = 2 * CLI_PI * (middle + step * (i - 4) * 0.012);
        arrow[i] = plot_panel_at(circle, (plot_point){radius * cos(angle), radius * sin(angle)});
    }
    const plot_point tip = arrow[8], way = {tip.x - arrow[6].x, tip.y - arrow[6].y};
    const double length = hypot(way.x, way.y), ux = way.x / length, uy = way.y / length, head = 6;
    arrow[9] = (plot_point){tip.x - head * ux - 0.5 * head * uy,
                            tip.y - head * uy + 0.5 * head * ux};
    arrow[10] = tip;
    arrow[11] = (plot_point){tip.x - head * ux + 0.5 * head * uy,
                             tip.y - head * uy - 0.5 * head * ux};
    plot_page_line(p->page, stroke, 12, arrow);
}

static int draw_circle(picture *p)
{
    double x[2] = {INFINITY, -INFINITY}, before = NAN;
    int on_circle = 0;
    if (!make_page(p, 400)) return cli_report(RIC_E_NOMEM);
    const double side = plot_page_height(p->page) - 110;
    for (int i = 0; i < p->branch.n_point; i++) {
        ric_point point;
        if (ric_atlas_point(p->atlas, p->branch.id, i, &point, NULL, NULL) ||
            !isfinite(point.rotation))
            continue;
        x[0] = fmin(x[0], point.arclength);
        x[1] = fmax(x[1], point.arclength);
        on_circle++;
    }
    if (on_circle == 0) {
        fprintf(stderr,
                "ricochet: branch %d has no multipliers on the unit circle, or not two modes; "
                "`ricochet plot floquet` "
                "draws what it has\n",
                p->branch.id);
        return CLI_FAILED;
    }
    plot_range_widen(false, 0.03, &x[0], &x[1]);
    const plot_panel circle = {{.from = 66, .to = 66 + side, .lo = -1.55, .hi = 1.55},
                               {.from = 60, .to = 60 + side, .lo = -1.55, .hi = 1.55}};
    const plot_panel angles =
        {{.from = 66 + side + 90, .to = plot_page_width(p->page) - 20, .lo = x[0], .hi = x[1]},
         {.from = 60, .to = 60 + side, .lo = 0, .hi = 1}};
    draw_roots(p, &circle, &angles);
    double first = NAN, last = NAN;
    for (int i = 0; i < p->branch.n_point; i++) {
        ric_point point;
        if (ric_atlas_point(p->atlas, p->branch.id, i, &point, NULL, NULL)) continue;
        if (isfinite(point.rotation) && isfinite(last))
            draw_step(p, &circle, &angles, before, last, &point);
        if (isfinite(point.rotation) && isnan(first)) first = point.rotation;
        before = point.arclength;
        if (isfinite(point.rotation)) last = point.rotation;
    }
    draw_direction(p, &circle, first, first + 0.5 * (last - first), thin[0], 1.1);
    draw_direction(p, &circle, -first, -first - 0.5 * (last - first), thin[1], 0.83);
    const plot_legend_entry pair[2] = {{"exp(2πiγ)", (int)thick[0], -1},
                                       {"exp(\xe2\x88\x92"
                                        "2πiγ)",
                                        (int)thick[1], -1}};
    plot_legend(p->page, 2, pair, 66, 66 + side, plot_page_height(p->page) - 28);
    plot_panel_frame(p->page, &circle, "Re μ", "Im μ");
    plot_panel_frame(p->page, &angles, "arclength", "arg μ / 2π");
    plot_page_title(p->page, p->common, NULL);
    return plot_page_write(p->page, p->common);
}

/* ----------------------------------------------------------------- command */

static int parse(int *argc, char **argv, picture *p)
{
    const char *dof, *duplicate;
    long number = 0;
    p->shapes = cli_take_flag(argc, argv, "--shapes");
    p->circle = cli_take_flag(argc, argv, "--circle");
    p->duplicate = 8;
    if (!cli_take_cascade(argc, argv, &p->request) || !cli_take_value(argc, argv, "--dof", &dof) ||
        !cli_take_value(argc, argv, "--duplicate", &duplicate) ||
        !cli_operands(&cli_plot, *argc, argv, 1) ||
        (dof && !cli_parse_integer(dof, "--dof", 1, 2147483647, &number)) ||
        (duplicate && !cli_parse_integer(duplicate, "--duplicate", 2, 24, &p->duplicate)))
        return CLI_WRONG;
    p->dof = (int)number - 1;
    if (!p->request.branch) return cli_wrong("plot cascade: --branch ID is missing");
    if (p->circle && (p->shapes || p->request.given))
        return cli_wrong("plot cascade: --circle shows one branch; leave out --shapes, --multiply "
                         "and --doublings");
    if (!p->circle && !p->request.given)
        return cli_wrong("plot cascade: --multiply 3,2,4 or --doublings N is missing; or --circle "
                         "for the multipliers "
                         "of the branch");
    return CLI_DONE;
}

int plot_cascade(int argc, char **argv, const plot_options *common)
{
    picture p = {.common = common};
    int code = parse(&argc, argv, &p);
    if (code != CLI_DONE) return code;
    ric_status status = ric_atlas_read(argv[1], &p.atlas);
    if (!status) status = ric_atlas_branch(p.atlas, p.request.branch, &p.branch);
    const int n_dof = status ? 0 : ric_model_n_dof(ric_atlas_model(p.atlas));
    if (status) code = cli_report(status);
    else if (p.dof >= n_dof)
        code = cli_wrong("--dof %d: there are displacements 1 to %d", p.dof + 1, n_dof);
    else if (p.circle) code = draw_circle(&p);
    else if ((code = cli_follow_cascade(p.atlas, &p.request, &p.cascade)) == CLI_DONE) {
        p.dof = p.dof < 0 ? n_dof - 1 : p.dof;
        code = p.shapes ? draw_shapes(&p) : draw_diagram(&p);
    }
    plot_page_free(p.page);
    ric_cascade_free(p.cascade);
    ric_atlas_free(p.atlas);
    return code;
}
