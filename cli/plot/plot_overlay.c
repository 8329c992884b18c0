/* Several orbits over one another, each stretched to the same period and shifted to the phase in
 * which it is most like the first one: what a law, an energy or a multiplication does to a motion.
 */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot_orbits.h"

enum { MOST = 6, PHASES = 720 };

/* ------------------------------------------------------------------- phases */

/* Displacements at PHASES times of all its periods, [PHASES * n]; false: no memory. */
static bool sample(const plot_choice *c, double *out)
{
    const plot_motion *m = &c->motion;
    for (int i = 0; i < PHASES; i++)
        for (int k = 0; k < m->n; k++)
            out[i * m->n + k] = plot_motion_at(m, c->periods * m->period * i / PHASES, k);
    return out;
}

static double likeness(int n, const double *a, const double *b, int shift)
{
    double sum = 0;
    for (int i = 0; i < PHASES; i++)
        for (int k = 0; k < n; k++) sum += a[i * n + k] * b[(i + shift) % PHASES * n + k];
    return sum;
}

/* Time at which an orbit begins in the picture: the correlation with the first one is largest, its
 * top between samples that of the parabola through three. */
static double start_like(int n, const double *first, const double *own, double total)
{
    int best = 0;
    double most = -INFINITY;
    for (int i = 0; i < PHASES; i++) {
        const double c = likeness(n, first, own, i);
        if (c > most * (1 + 1e-12)) {
            most = c;
            best = i;
        }
    }
    const double before = likeness(n, first, own, (best + PHASES - 1) % PHASES),
                 after = likeness(n, first, own, (best + 1) % PHASES),
                 bend = before - 2 * most + after;
    return total / PHASES * (best + (bend < 0 ? 0.5 * (before - after) / bend : 0));
}

/* The first orbit begins where its gap grows through zero after its longest stretch below. */
static bool find_starts(const orbits_figure *f, double start[MOST])
{
    const int n = f->panels[0].choice.motion.n;
    double *first = malloc(2 * PHASES * (size_t)n * sizeof *first), *own = first + PHASES * n;
    if (!first) return false;
    sample(&f->panels[0].choice, first);
    start[0] = plot_motion_start(&f->panels[0].choice.motion, 0);
    for (int i = 1; i < f->n; i++) {
        const plot_choice *c = &f->panels[i].choice;
        const plot_choice *base = &f->panels[0].choice;
        sample(c, own);
        const double total = c->periods * c->motion.period;
        start[i] = start_like(n, first, own, total) +
                   start[0] / (base->periods * base->motion.period) * total;
    }
    free(first);
    return true;
}

/* ------------------------------------------------------------------ drawing */

static double read_gap_speed(const plot_motion *m, const double *row, int what)
{
    return plot_motion_gap(m, what, row + 1 + m->n);
}

static void range_of(const orbits_figure *f, plot_reading y, int what, double range[2])
{
    range[0] = INFINITY;
    range[1] = -INFINITY;
    for (int i = 0; i < f->n; i++)
        plot_motion_range(&f->panels[i].choice.motion, y, what, &range[0], &range[1]);
    plot_range_widen(false, 0.07, &range[0], &range[1]);
}

/* The stops of the first contact of any of the orbits, at +1 and -1. */
static void draw_stops(const orbits_figure *f, const plot_panel *panel)
{
    for (int side = -1; side <= 1; side += 2) {
        bool some = false;
        for (int i = 0; i < f->n; i++) {
            const plot_motion *m = &f->panels[i].choice.motion;
            some |= ric_model_n_face(m->model) == 0 || plot_motion_face(m, 0, side) >= 0;
        }
        if (!some) continue;
        plot_panel_curve(f->page, panel, PLOT_STOP, 2,
                         (plot_point[]){{panel->x.lo, side}, {panel->x.hi, side}});
    }
}

typedef struct {
    plot_reading x, v;
    int what;
    bool gap;
    char name[24], symbol[24], speed[24];
} reading;

static void draw_history(const orbits_figure *f, const reading *r, const double *start,
                         plot_box box, bool title)
{
    double y[2], whole[2] = {0, 1};
    range_of(f, r->x, r->what, y);
    plot_panel panel = {plot_axis_linear(whole[0], whole[1], box.left, box.right),
                        plot_axis_linear(y[0], y[1], box.bottom, box.top)};
    panel.y.unit = r->gap ? 1 : plot_units_of(f->common, f->panels[0].choice.motion.model).length;
    if (r->gap) draw_stops(f, &panel);
    for (int i = 0; i < f->n; i++) {
        const plot_choice *c = &f->panels[i].choice;
        plot_panel own = panel;
        own.x.hi = c->periods * c->motion.period;
        for (int k = -1; k <= 2 * c->periods; k++)
            plot_motion_draw(f->page, &own, PLOT_OVERLAY + (plot_stroke)i, &c->motion,
                             plot_read_time, r->x, r->what, k * c->motion.period - start[i]);
    }
    plot_panel_frame(f->page, &panel, title ? "t / T" : "", r->name);
}

/* Symmetric around zero, and as large as a reading of an orbit. */
static plot_axis axis_of(const plot_motion *m, plot_reading y, int what, double from, double to)
{
    double range[2] = {0, 0};
    plot_motion_range(m, y, what, &range[0], &range[1]);
    const double most = 1.1 * fmax(range[1], -range[0]);
    return plot_axis_linear(-most, most, from, to);
}

/* Each motion over its largest values: shapes are compared, and energies may be far apart. */
static void draw_portrait(const orbits_figure *f, const reading *r, plot_box box)
{
    const double whole[2] = {-1.1, 1.1};
    char across[64], up[64];
    for (int i = 0; i < f->n; i++) {
        const plot_motion *m = &f->panels[i].choice.motion;
        const plot_panel own = {axis_of(m, r->x, r->what, box.left, box.right),
                                axis_of(m, r->v, r->what, box.bottom, box.top)};
        plot_motion_draw(f->page, &own, PLOT_OVERLAY + (plot_stroke)i, m, r->x, r->v, r->what, 0);
    }
    const plot_panel panel = {plot_axis_linear(whole[0], whole[1], box.left, box.right),
                              plot_axis_linear(whole[0], whole[1], box.bottom, box.top)};
    snprintf(across, sizeof across, "%s / largest", r->symbol);
    snprintf(up, sizeof up, "%s / largest", r->speed);
    plot_panel_frame(f->page, &panel, across, up);
}

static int make_readings(const orbits_figure *f, reading *out)
{
    int n = 0;
    for (int k = 0; k < f->n_shown; k++) {
        reading *r = &out[n++];
        *r = (reading){.x = plot_read_x, .v = plot_read_v, .what = f->shown[k]};
        snprintf(r->name, sizeof r->name, "x_{%d}", r->what + 1);
        snprintf(r->symbol, sizeof r->symbol, "x_{%d}", r->what + 1);
        snprintf(r->speed, sizeof r->speed, "v_{%d}", r->what + 1);
    }
    if (f->gap) {
        out[n++] = (reading){.x = plot_read_gap,
                             .v = read_gap_speed,
                             .gap = true,
                             .name = "gap / clearance",
                             .symbol = "s",
                             .speed = "ds/dt"};
    }
    return n;
}

static void key_of(const orbits_figure *f, int i, size_t size, char *out)
{
    const plot_choice *c = &f->panels[i].choice;
    char name[200], place[120], times[40] = "";
    plot_text_label(c->name, sizeof name, name);
    plot_place_text(f->common, c->motion.model, c->energy, c->frequency, sizeof place, place);
    if (c->periods > 1) snprintf(times, sizeof times, ",  %d periods", c->periods);
    snprintf(out, size, "%s:  %s%s", name, place, times);
}

int orbits_overlay(orbits_figure *f)
{
    reading readings[ORBITS_SHOWN + 1];
    double start[MOST];
    char keys[MOST][400];
    plot_legend_entry entries[MOST];
    if (f->n > MOST) return cli_wrong("--overlay: at most %d orbits can be told apart", MOST);
    const int rows = make_readings(f, readings);
    for (int i = 0; i < f->n; i++) {
        key_of(f, i, sizeof keys[i], keys[i]);
        entries[i] = (plot_legend_entry){keys[i], PLOT_OVERLAY + i, -1};
    }
    const double width = plot_layout_width(f->common, PLOT_WIDTH), foot = 48, gap = 48,
                 head = plot_page_head(f->common, NULL),
                 legend = plot_legend(NULL, f->n, entries, 12, width - 12, 0),
                 height = plot_layout_height(f->common,
                                             head + legend + 8 + rows * 160 + foot - gap);
    const double row = (height - head - legend - 8 - foot + gap) / rows, side = row - gap;
    if (!find_starts(f, start) || !(f->page = plot_page_create(width, height)))
        return cli_report(RIC_E_NOMEM);
    for (int i = 0; i < rows; i++) {
        const double top = height - head - row * i,
                     right = width - 12 - (f->histories ? 0 : side + 64);
        draw_history(f, &readings[i], start, (plot_box){60, top - side, right, top}, i + 1 == rows);
        if (!f->histories)
            draw_portrait(f, &readings[i], (plot_box){right + 64, top - side, width - 12, top});
    }
    plot_legend(f->page, f->n, entries, 12, width - 12, legend + 4);
    plot_page_title(f->page, f->common, NULL);
    return plot_page_write(f->page, f->common);
}
