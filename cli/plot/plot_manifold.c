/* The orbits along a part of a branch in three coordinates of the phase space: together they are a
 * surface. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot_sheet.h"

enum { SHADES = 15 };
static const double type = 12;

/* x1, v2: which number of a row, after the time. */
static bool take_axis(const char *text, int n, int *out, char title[24])
{
    long index;
    if ((*text != 'x' && *text != 'v') || !cli_parse_integer(text + 1, "--space", 1, n, &index))
        return cli_wrong("--space %s: there are x1 to x%d and v1 to v%d", text, n, n) == CLI_DONE;
    *out = (int)index - 1 + (*text == 'v' ? n : 0);
    snprintf(title, 24, "%c_{%ld}", *text, index);
    return true;
}

static bool take_space(const sheet *s, int axes[3], char titles[3][24])
{
    char text[64], *rest = NULL;
    int count = 0;
    const int n = ric_model_n_dof(ric_atlas_model(s->from.atlas[0]));
    for (int i = 1; i < s->from.n; i++)
        if (ric_model_n_dof(ric_atlas_model(s->from.atlas[i])) != n)
            return cli_wrong("plot sheet: the models have different numbers of coordinates") ==
                   CLI_DONE;
    snprintf(text, sizeof text, "%s", s->space);
    for (char *c = strtok_r(text, ",", &rest); c; c = strtok_r(NULL, ",", &rest)) {
        if (count == 3 || !take_axis(c, n, &axes[count], titles[count])) {
            if (count == 3)
                cli_wrong("--space %s: three coordinates, for example x1,x2,v2", s->space);
            return false;
        }
        count++;
    }
    if (count == 3) return true;
    cli_wrong("--space %s: three coordinates, for example x1,x2,v2", s->space);
    return false;
}

static void read_point(const plot_motion *m, int row, const int axes[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = plot_motion_row(m, row)[1 + axes[i]];
}

static void find_ranges(const sheet_part *p, const int axes[3], plot_space *space)
{
    for (int i = 0; i < 3; i++) {
        space->lo[i] = INFINITY;
        space->hi[i] = -INFINITY;
        space->unit[i] = 1;
    }
    for (int k = 0; k < p->n; k++)
        for (int row = 0; row < p->motions[k].first[p->motions[k].n_piece]; row++) {
            double at[3];
            read_point(&p->motions[k], row, axes, at);
            for (int i = 0; i < 3; i++) {
                space->lo[i] = fmin(space->lo[i], at[i]);
                space->hi[i] = fmax(space->hi[i], at[i]);
            }
        }
    for (int i = 0; i < 3; i++) plot_range_widen(false, 0.05, &space->lo[i], &space->hi[i]);
}

static void draw_motion(sheet *s, const plot_space *space, const plot_motion *m, const int axes[3],
                        plot_stroke stroke)
{
    for (int k = 0; k < m->n_piece; k++) { /* speeds jump between pieces */
        const int n = m->first[k + 1] - m->first[k];
        double *points = malloc(3 * (size_t)n * sizeof *points);
        for (int i = 0; points && i < n; i++) read_point(m, m->first[k] + i, axes, points + 3 * i);
        if (points) plot_space_curve(s->page, space, stroke, n, points);
        else plot_page_fail(s->page);
        free(points);
    }
}

/* The energies that the shades stand for. */
static void draw_bar(sheet *s, const sheet_part *p, plot_box box, double lo, double hi)
{
    const double width = 130, left = (box.left + box.right - width) / 2, step = width / SHADES;
    char text[64];
    for (int i = 0; i < SHADES; i++)
        for (double y = 0; y < 5; y++)
            plot_page_line(s->page, PLOT_SHADE + 1 + (plot_stroke)i, 2,
                           (plot_point[]){{left + step * i, box.bottom + y},
                                          {left + step * (i + 1), box.bottom + y}});
    snprintf(text, sizeof text, "%s = %.4g", plot_energy_letter(p->motions[0].model), lo);
    plot_page_text(s->page, (plot_point){left - 8, box.bottom + 2}, PLOT_RIGHT, type, "#222222",
                   false, text);
    snprintf(text, sizeof text, "%.4g", hi);
    plot_page_text(s->page, (plot_point){left + width + 8, box.bottom + 2}, PLOT_LEFT, type,
                   "#222222", false, text);
}

static void draw_part(sheet *s, int i, plot_box box, const int axes[3], char titles[3][24])
{
    const sheet_part *p = &s->parts[i];
    const char *const names[3] = {titles[0], titles[1], titles[2]};
    plot_space space = s->view;
    char title[400];
    double lo = INFINITY, hi = -INFINITY;
    for (int k = 0; k < p->n; k++) {
        lo = fmin(lo, p->energies[k]);
        hi = fmax(hi, p->energies[k]);
    }
    space.box = (plot_box){box.left + 62, box.bottom + 66, box.right - 34, box.top - 28};
    find_ranges(p, axes, &space);
    const plot_units unit = plot_units_of(s->common, p->motions[0].model);
    for (int k = 0; k < 3; k++) space.unit[k] = unit.length;
    plot_space_frame(s->page, &space, names);
    for (int k = 0; k < p->n; k++) {
        const double part = hi > lo ? (p->energies[k] - lo) / (hi - lo) : 0;
        draw_motion(s, &space, &p->motions[k], axes,
                    PLOT_SHADE + 1 + (plot_stroke)fmin(SHADES - 1, SHADES * part));
    }
    draw_bar(s, p, (plot_box){box.left, box.bottom + 10, box.right, 0}, lo * unit.energy,
             hi * unit.energy);
    sheet_title(s, i, sizeof title, title);
    plot_page_text(s->page, (plot_point){(box.left + box.right) / 2, box.top - 12}, PLOT_CENTRE,
                   type, "#000000", false, title);
}

int sheet_manifolds(sheet *s)
{
    int axes[3];
    char titles[3][24];
    if (!take_space(s, axes, titles)) return CLI_WRONG;
    const int columns = s->n > 1 ? 2 : 1, rows = (s->n + columns - 1) / columns;
    const double head = plot_page_head(s->common, NULL),
                 width = plot_layout_width(s->common, PLOT_WIDTH),
                 height = plot_layout_height(s->common, head + (columns == 1 ? 500 : 315) * rows);
    s->page = plot_page_create(width, height);
    if (!s->page) return cli_report(RIC_E_NOMEM);
    const double w = width / columns, h = (height - head) / rows;
    for (int i = 0; i < s->n; i++) {
        const double left = w * (i % columns), top = height - head - h * (i / columns);
        draw_part(s, i, (plot_box){left, top - h, left + w, top}, axes, titles);
    }
    plot_page_title(s->page, s->common, NULL);
    return plot_page_write(s->page, s->common);
}
