/* Three quantities at once: a box seen from the front, the left and a little above, without
 * perspective, so that curves stay smooth functions of their parameter. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

static const double type = 12;
static const double degree = 3.14159265358979323846 / 180;

bool plot_parse_view(const char *text, plot_space *out)
{
    char first[64];
    const char *comma = text ? strchr(text, ',') : NULL;
    out->around = 32;
    out->above = 22;
    if (!text) return true;
    snprintf(first, sizeof first, "%.*s", (int)(comma ? comma - text : 0), text);
    if (comma && comma - text < 60 &&
        (!cli_parse_number(first, "--view", &out->around) ||
         !cli_parse_number(comma + 1, "--view", &out->above)))
        return false;
    if (comma && out->around >= 5 && out->around <= 85 && out->above >= 5 && out->above <= 85)
        return true;
    cli_wrong("--view %s: two angles of 5 to 85 degrees, for example 32,22", text);
    return false;
}

/* Of a point of the unit cube around its middle: to the right and upwards. */
static plot_point turned(const plot_space *s, double u, double v, double w)
{
    const double a = s->around * degree, b = s->above * degree, depth = -u * sin(a) + v * cos(a);
    return (plot_point){u * cos(a) + v * sin(a), w * cos(b) + depth * sin(b)};
}

plot_point plot_space_at(const plot_space *s, const double p[3])
{
    double part[3];
    for (int i = 0; i < 3; i++) part[i] = (p[i] - s->lo[i]) / (s->hi[i] - s->lo[i]) - 0.5;
    const plot_point t = turned(s, part[0], part[1], part[2]), far = turned(s, 0.5, 0.5, 0),
                     high = turned(s, -0.5, 0.5, 0.5);
    return (plot_point){(s->box.left + s->box.right) / 2 +
                            t.x / far.x * (s->box.right - s->box.left) / 2,
                        (s->box.bottom + s->box.top) / 2 +
                            t.y / high.y * (s->box.top - s->box.bottom) / 2};
}

bool plot_space_inside(const plot_space *s, const double p[3])
{
    for (int i = 0; i < 3; i++)
        if (!(p[i] >= s->lo[i] && p[i] <= s->hi[i])) return false;
    return true;
}

/* The point of an edge: coordinate `axis` has a value, the others stand at their low (0) or high
 * (1) end. */
static plot_point on_edge(const plot_space *s, int axis, double value, const bool high[3])
{
    double p[3];
    for (int i = 0; i < 3; i++) p[i] = i == axis ? value : high[i] ? s->hi[i] : s->lo[i];
    return plot_space_at(s, p);
}

static void draw_edge(plot_page *page, const plot_space *s, plot_stroke stroke, int axis,
                      const bool high[3])
{
    plot_page_line(page, stroke, 2,
                   (plot_point[]){on_edge(s, axis, s->lo[axis], high),
                                  on_edge(s, axis, s->hi[axis], high)});
}

/* Numbers along an edge, `out` away from it, and the name of its quantity beyond them. */
static void number_edge(plot_page *page, const plot_space *s, int axis, const bool high[3],
                        plot_point out, const char *title)
{
    const double unit = s->unit[axis] > 0 ? s->unit[axis] : 1, lo = s->lo[axis] * unit,
                 hi = s->hi[axis] * unit;
    const double step = plot_nice_step(hi - lo, 4);
    const int digits = (int)fmax(0, -floor(log10(step) + 1e-9));
    const bool upright = axis == 2;
    double widest = 0;
    for (double k = ceil(lo / step - 1e-9); k * step <= hi + 1e-9 * (hi - lo); k++) {
        const plot_point at = on_edge(s, axis, k * step / unit, high),
                         tip = {at.x + out.x / 2, at.y + out.y / 2};
        char text[40];
        snprintf(text, sizeof text, "%s%.*f", k < 0 ? "\xe2\x88\x92" : "", digits, fabs(k * step));
        plot_page_line(page, PLOT_FRAME, 2, (plot_point[]){at, tip});
        plot_page_text(page, (plot_point){at.x + out.x, at.y + out.y - (upright ? 0 : 5)},
                       upright     ? PLOT_RIGHT
                       : axis == 0 ? PLOT_RIGHT
                                   : PLOT_LEFT,
                       type, "#222222", false, text);
        widest = fmax(widest, plot_text_width(text, type));
    }
    const plot_point middle = on_edge(s, axis, (s->lo[axis] + s->hi[axis]) / 2, high);
    if (upright)
        plot_page_text(page, (plot_point){middle.x + out.x - widest - 14, middle.y}, PLOT_CENTRE,
                       type + 1, "#222222", true, title);
    else
        plot_page_text(page,
                       (plot_point){middle.x + (axis == 0 ? -1 : 1) * (widest + 16) + out.x,
                                    middle.y + out.y - 14},
                       axis == 0 ? PLOT_RIGHT : PLOT_LEFT, type + 1, "#222222", false, title);
}

void plot_space_frame(plot_page *page, const plot_space *s, const char *const titles[3])
{
    static const bool front[3] = {false, false, false}, right[3] = {true, false, false},
                      back[3] = {false, true, false}, far[3] = {true, true, false},
                      top_back[3] = {false, true, true}, top_left[3] = {false, false, true};
    draw_edge(page, s, PLOT_GRID, 2, back);
    draw_edge(page, s, PLOT_GRID, 2, far);
    draw_edge(page, s, PLOT_GRID, 0, back);
    draw_edge(page, s, PLOT_GRID, 1, front);
    draw_edge(page, s, PLOT_GRID, 0, top_back);
    draw_edge(page, s, PLOT_GRID, 1, top_left);
    draw_edge(page, s, PLOT_FRAME, 0, front);
    draw_edge(page, s, PLOT_FRAME, 1, right);
    draw_edge(page, s, PLOT_FRAME, 2, front);
    number_edge(page, s, 0, front, (plot_point){-4, -7}, titles[0]);
    number_edge(page, s, 1, right, (plot_point){5, -6}, titles[1]);
    number_edge(page, s, 2, front, (plot_point){-8, 0}, titles[2]);
}

void plot_space_curve(plot_page *page, const plot_space *s, plot_stroke stroke, int n,
                      const double *points)
{
    const plot_panel panel = plot_pixels(page);
    plot_point *line = malloc((size_t)(n > 0 ? n : 1) * sizeof *line);
    for (int i = 0; line && i < n; i++)
        line[i] = plot_space_inside(s, points + 3 * i) ? plot_space_at(s, points + 3 * i)
                                                       : (plot_point){NAN, NAN};
    if (line) plot_panel_curve(page, &panel, stroke, n, line);
    else plot_page_fail(page);
    free(line);
}

plot_panel plot_pixels(const plot_page *page)
{
    const double width = plot_page_width(page), height = plot_page_height(page);
    return (plot_panel){{.lo = 0, .hi = width, .from = 0, .to = width},
                        {.lo = 0, .hi = height, .from = 0, .to = height}};
}
