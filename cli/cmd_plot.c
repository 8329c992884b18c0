/* ricochet plot: chooses the kind of picture; and what all kinds share: axes, panels, legend, labels, common options. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

enum { MAX_TICKS = 160 };
static const double far_away = 1e6; /* pixels, for values that a logarithm does not reach */
static const double knee_part = 0.68; /* of a broken axis lies below its knee */
static const double type = 12;

/* --------------------------------------------------------------------- axes */

static double clamp_pixels(double value)
{
    return isnan(value) ? value : fmax(-far_away, fmin(far_away, value));
}

double plot_axis_at(const plot_axis *axis, double value)
{
    const double length = axis->to - axis->from, fold = axis->from + knee_part * length;
    switch (axis->scale) {
    case PLOT_SCALE_LOG:
        if (value <= 0)
            return axis->from - far_away;
        return clamp_pixels(axis->from + length * log(value / axis->lo) / log(axis->hi / axis->lo));
    case PLOT_SCALE_BROKEN:
        if (value > axis->knee)
            return clamp_pixels(fold + (axis->to - fold) * log(value / axis->knee) / log(axis->hi / axis->knee));
        return clamp_pixels(axis->from + (fold - axis->from) * (value - axis->lo) / (axis->knee - axis->lo));
    default:
        return clamp_pixels(axis->from + length * (value - axis->lo) / (axis->hi - axis->lo));
    }
}

void plot_range_widen(bool logarithmic, double part, double *lo, double *hi)
{
    if (logarithmic) {
        const double factor = *hi > *lo * (1 + 1e-6) ? pow(*hi / *lo, part) : 1.1;
        *lo /= factor;
        *hi *= factor;
        return;
    }
    const double size = fmax(fabs(*lo), fabs(*hi));
    const double margin = *hi - *lo > 1e-9 * size ? part * (*hi - *lo) : size > 0 ? 0.05 * size : 1;
    *lo -= margin;
    *hi += margin;
}

typedef struct {
    double at, from, to; /* pixels; from..to is what a label that is shown covers */
    bool major, shown;
    char text[64];
} tick;

typedef struct {
    const plot_axis *axis;
    double low, high; /* data range that the tics are for */
    int n;
    tick ticks[MAX_TICKS];
} tick_list;

/* `text` NULL makes a minor tic. */
static void add_tick(tick_list *list, double value, const char *text)
{
    if (list->n == MAX_TICKS || value < list->low || value > list->high)
        return;
    tick *t = &list->ticks[list->n++];
    *t = (tick){.at = plot_axis_at(list->axis, value), .major = text != NULL};
    if (text && *text == '-') /* a real minus sign */
        snprintf(t->text, sizeof t->text, "\xe2\x88\x92%.56s", text + 1);
    else if (text)
        snprintf(t->text, sizeof t->text, "%s", text);
}

/* 1, 2 or 5 times a power of ten, so that about `count` steps fit. */
static double nice_step(double span, double count)
{
    const double raw = span / fmax(1, count), power = pow(10, floor(log10(raw))), lead = raw / power;
    return power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

static void linear_ticks(tick_list *list, double pixels, double spacing)
{
    const double step = nice_step(list->high - list->low, pixels / spacing), slack = 1e-9 * (list->high - list->low);
    const double lead = step / pow(10, floor(log10(step) + 1e-9)), size = fmax(fabs(list->low), fabs(list->high));
    const int fine = lead > 1.5 && lead < 3 ? 4 : 5, minor = pixels * step / (list->high - list->low) / fine < 7 ? fine == 4 ? 2 : 1 : fine;
    const bool plain = size < 1e5 && step > 1e-7 * (size < 1 ? 1 : size);
    const int digits = plain ? (int)fmax(0, -floor(log10(step) + 1e-9)) : 6;
    list->low -= slack;
    list->high += slack;
    for (double k = ceil(list->low / step * minor); k * step / minor <= list->high && list->n < MAX_TICKS; k++) {
        const double value = k == 0 ? 0 : k * step / minor;
        char text[64];
        snprintf(text, sizeof text, plain ? "%.*f" : "%.*g", digits, value);
        add_tick(list, value, fabs(fmod(k, minor)) < 0.5 ? text : NULL);
    }
}

/* lead * 10^exponent */
static void power_tick(tick_list *list, int lead, int exponent)
{
    const double value = lead * pow(10, exponent);
    char text[64];
    if (exponent < 5 && exponent > -4)
        snprintf(text, sizeof text, "%.10g", value);
    else if (lead == 1)
        snprintf(text, sizeof text, "10^{%d}", exponent);
    else
        snprintf(text, sizeof text, "%d\xc2\xb7" "10^{%d}", lead, exponent);
    add_tick(list, value, text);
}

static void log_ticks(tick_list *list, double pixels, double spacing)
{
    const double decade = pixels / log10(list->high / list->low);
    if (pixels / decade < 0.45) {
        linear_ticks(list, pixels, spacing);
        return;
    }
    /* Labelled leads: the more, the larger a decade; with tiny decades only every other power. */
    const char *leads = decade > 22 * spacing ? "123456789" : decade > 9 * spacing ? "1235" : decade > 4.5 * spacing ? "125"
                      : decade > 2.2 * spacing ? "13" : "1";
    const int every = (int)fmax(1, ceil(spacing / decade));
    for (int e = (int)floor(log10(list->low)) - 1; e <= (int)ceil(log10(list->high)); e++)
        for (int lead = 1; lead <= 9; lead++) {
            if (strchr(leads, '0' + lead) && e % every == 0)
                power_tick(list, lead, e);
            else if (decade > 25)
                add_tick(list, lead * pow(10, e), NULL);
        }
}

/* The trace on the scale asinh(trace / 2), which shows its sign and all its orders of magnitude; what is to be labelled first comes first. */
static void asinh_ticks(tick_list *list, double pixels)
{
    const int orders = (int)ceil(fmax(fabs(list->low), fabs(list->high)) / log(10));
    const int every = (int)fmax(1, ceil(orders * 60 / pixels));
    char text[64];
    add_tick(list, 0, "0");
    for (int sign = -1; sign <= 1; sign += 2) {
        add_tick(list, sign * asinh(1), sign > 0 ? "2" : "-2");
        for (int e = every; e <= orders; e += every) {
            snprintf(text, sizeof text, e == 1 ? "%s10" : "%s10^{%d}", sign < 0 ? "-" : "", e);
            add_tick(list, sign * (e < 15 ? asinh(pow(10, e) / 2) : e * log(10)), text);
        }
    }
}

static void axis_ticks(tick_list *list, const plot_axis *axis, double spacing)
{
    const double pixels = axis->to - axis->from;
    *list = (tick_list){.axis = axis, .low = axis->lo, .high = axis->hi};
    switch (axis->scale) {
    case PLOT_SCALE_LINEAR: linear_ticks(list, pixels, spacing); break;
    case PLOT_SCALE_LOG: log_ticks(list, pixels, spacing); break;
    case PLOT_SCALE_ASINH: asinh_ticks(list, pixels); break;
    case PLOT_SCALE_BROKEN:
        list->high = axis->knee;
        linear_ticks(list, knee_part * pixels, spacing);
        list->low = axis->knee * 1.02;
        list->high = axis->hi;
        log_ticks(list, (1 - knee_part) * pixels, spacing);
        break;
    }
}

/* ------------------------------------------------------------------- panels */

plot_box plot_panel_box(const plot_panel *panel)
{
    return (plot_box){panel->x.from, panel->y.from, panel->x.to, panel->y.to};
}

plot_point plot_panel_at(const plot_panel *panel, plot_point data)
{
    return (plot_point){plot_axis_at(&panel->x, data.x), plot_axis_at(&panel->y, data.y)};
}

bool plot_panel_inside(const plot_panel *panel, plot_point data)
{
    const plot_point p = plot_panel_at(panel, data);
    const plot_box box = plot_panel_box(panel);
    return p.x >= box.left - 0.01 && p.x <= box.right + 0.01 && p.y >= box.bottom - 0.01 && p.y <= box.top + 0.01;
}

static void draw_segment(plot_page *page, plot_stroke stroke, double x0, double y0, double x1, double y1)
{
    plot_page_line(page, stroke, 2, (plot_point[]){{x0, y0}, {x1, y1}});
}

/* Whether the label of tick i, `half` to both sides of it, stays `gap` away from those shown before. */
static bool show_label(tick_list *list, int i, double half, double gap)
{
    tick *t = &list->ticks[i];
    t->from = t->at - half;
    t->to = t->at + half;
    t->shown = t->major;
    for (int k = 0; k < i && t->shown; k++)
        t->shown = !list->ticks[k].shown || t->from > list->ticks[k].to + gap || t->to < list->ticks[k].from - gap;
    return t->shown;
}

static void draw_x_axis(plot_page *page, const plot_box *box, const plot_axis *axis, const char *title)
{
    tick_list list;
    axis_ticks(&list, axis, 62);
    for (int i = 0; i < list.n; i++) {
        const tick *t = &list.ticks[i];
        const double length = t->major ? 6 : 3;
        draw_segment(page, PLOT_FRAME, t->at, box->bottom, t->at, box->bottom + length);
        draw_segment(page, PLOT_FRAME, t->at, box->top, t->at, box->top - length);
        if (title && show_label(&list, i, plot_text_width(t->text, type) / 2, 6))
            plot_page_text(page, (plot_point){t->at, box->bottom - 12}, PLOT_CENTRE, type, "#222222", false, t->text);
    }
    if (title && *title)
        plot_page_text(page, (plot_point){(box->left + box->right) / 2, box->bottom - 31}, PLOT_CENTRE, type + 1, "#222222", false, title);
}

static void draw_y_axis(plot_page *page, const plot_box *box, const plot_axis *axis, const char *title)
{
    tick_list list;
    double widest = 0;
    axis_ticks(&list, axis, 42);
    for (int i = 0; i < list.n; i++) {
        const tick *t = &list.ticks[i];
        const double length = t->major ? 6 : 3;
        draw_segment(page, PLOT_FRAME, box->left, t->at, box->left + length, t->at);
        draw_segment(page, PLOT_FRAME, box->right, t->at, box->right - length, t->at);
        if (title && show_label(&list, i, 0.6 * type, 0)) {
            plot_page_text(page, (plot_point){box->left - 10, t->at}, PLOT_RIGHT, type, "#222222", false, t->text);
            widest = fmax(widest, plot_text_width(t->text, type));
        }
    }
    if (!title || !*title)
        return;
    const double size = fmin(type + 1, (type + 1) * (box->top - box->bottom) / plot_text_width(title, type + 1)); /* never beyond the page */
    plot_page_text(page, (plot_point){box->left - widest - 23, (box->bottom + box->top) / 2}, PLOT_CENTRE, size, "#222222", true, title);
}

void plot_panel_frame(plot_page *page, const plot_panel *panel, const char *x_title, const char *y_title)
{
    const plot_box box = plot_panel_box(panel);
    plot_page_line(page, PLOT_FRAME, 5, (plot_point[]){{box.left, box.bottom}, {box.right, box.bottom}, {box.right, box.top},
                                                       {box.left, box.top}, {box.left, box.bottom}});
    draw_x_axis(page, &box, &panel->x, x_title);
    draw_y_axis(page, &box, &panel->y, y_title);
    if (panel->y.scale == PLOT_SCALE_BROKEN) {
        const double knee = plot_axis_at(&panel->y, panel->y.knee);
        draw_segment(page, PLOT_GRID, box.left, knee, box.right, knee);
        for (int side = 0; side < 2; side++)
            for (int stripe = -1; stripe <= 1; stripe += 2) {
                const double x = side ? box.right : box.left, y = knee + 2.5 * stripe;
                draw_segment(page, PLOT_FRAME, x - 7, y - 4, x + 7, y + 4);
            }
    }
}

/* Liang and Barsky 1984. */
bool plot_clip_segment(const plot_box *box, plot_point *a, plot_point *b)
{
    const double dx = b->x - a->x, dy = b->y - a->y;
    const double p[4] = {-dx, dx, -dy, dy}, q[4] = {a->x - box->left, box->right - a->x, a->y - box->bottom, box->top - a->y};
    double enter = 0, leave = 1;
    for (int i = 0; i < 4; i++) {
        if (p[i] == 0 && q[i] < 0)
            return false;
        if (p[i] < 0)
            enter = fmax(enter, q[i] / p[i]);
        else if (p[i] > 0)
            leave = fmin(leave, q[i] / p[i]);
    }
    if (enter > leave)
        return false;
    const plot_point start = *a;
    *a = (plot_point){start.x + enter * dx, start.y + enter * dy};
    *b = (plot_point){start.x + leave * dx, start.y + leave * dy};
    return true;
}

/* Drops points that lie within a twelfth of a pixel of the line through their neighbours: a cone of directions from the last kept
 * point narrows with every point passed over. In place; returns how many are left. */
static int thin_line(int n, plot_point *p)
{
    const double tolerance = 1. / 12;
    int kept = n > 0;
    double middle = 0, low = -4, high = 4, reach = 0;
    bool open = false;
    for (int i = 1; i < n; i++) {
        const plot_point from = p[kept - 1];
        const double dx = p[i].x - from.x, dy = p[i].y - from.y, distance = hypot(dx, dy);
        if (distance <= tolerance && i < n - 1 && !open)
            continue;
        double angle = atan2(dy, dx);
        if (open)
            angle = middle + remainder(angle - middle, 2 * acos(-1));
        const double half = distance > tolerance ? asin(tolerance / distance) : 4;
        if (open && (angle < low || angle > high || distance < reach)) {
            p[kept++] = p[i - 1]; /* never overtakes: kept <= i - 1 */
            open = false;
            i--;
            continue;
        }
        middle = open ? middle : angle;
        low = open ? fmax(low, angle - half) : angle - half;
        high = open ? fmin(high, angle + half) : angle + half;
        reach = distance;
        open = true;
        if (i == n - 1)
            p[kept++] = p[i];
    }
    return kept;
}

static void flush_run(plot_page *page, plot_stroke stroke, int *n, plot_point *run)
{
    const int left = thin_line(*n, run);
    if (left > 1)
        plot_page_line(page, stroke, left, run);
    *n = 0;
}

void plot_panel_curve(plot_page *page, const plot_panel *panel, plot_stroke stroke, int n, const plot_point *data)
{
    const plot_box box = plot_panel_box(panel);
    plot_point *run = malloc((size_t)(n > 0 ? n : 1) * sizeof *run);
    int length = 0;
    for (int i = 1; run && i < n; i++) {
        plot_point a = plot_panel_at(panel, data[i - 1]), b = plot_panel_at(panel, data[i]);
        const plot_point end = b;
        if (isnan(a.x + a.y + b.x + b.y) || !plot_clip_segment(&box, &a, &b)) {
            flush_run(page, stroke, &length, run);
            continue;
        }
        if (length == 0)
            run[length++] = a;
        run[length++] = b;
        if (b.x != end.x || b.y != end.y)
            flush_run(page, stroke, &length, run);
    }
    if (run)
        flush_run(page, stroke, &length, run);
    free(run);
}

int plot_legend_entries(const bool family[3], unsigned stability, const bool *kinds, plot_legend_entry *out)
{
    static const char *const families[] = {"linear mode", "asymmetric", "symmetric"};
    static const char *const words[] = {
        [RIC_KIND_START] = "start", [RIC_KIND_GRAZING] = "grazing", [RIC_KIND_CORNER] = "corner", [RIC_KIND_EXTREMUM] = "extremum",
        [RIC_KIND_BRANCH_POINT] = "branch point", [RIC_KIND_MULTIPLICATION] = "period multiplication",
        [RIC_KIND_PERIOD_EXTREMUM] = "period extremum", [RIC_KIND_USER] = "asked for",
    };
    const int sample = family && family[2] ? PLOT_SYMMETRIC : family && family[1] ? PLOT_ASYMMETRIC : PLOT_LINEAR;
    int n = 0;
    for (int i = 2; family && i >= 0; i--)
        if (family[i])
            out[n++] = (plot_legend_entry){families[i], PLOT_LINEAR + 3 * i + RIC_STABLE_YES, -1};
    if (stability & 1u << RIC_STABLE_NO)
        out[n++] = (plot_legend_entry){"thin: unstable", sample + RIC_STABLE_NO, -1};
    if (stability & 1u << RIC_STABLE_UNDECIDED)
        out[n++] = (plot_legend_entry){"dotted: undecided", sample + RIC_STABLE_UNDECIDED, -1};
    for (int kind = 0; kinds && kind <= RIC_KIND_USER; kind++)
        if (kinds[kind])
            out[n++] = (plot_legend_entry){words[kind], -1, (int)plot_junction_mark((ric_kind)kind)};
    return n;
}

double plot_legend(plot_page *page, int n, const plot_legend_entry *entries, double left, double right, double top)
{
    const double sample = 26, gap = 18, line = 1.55 * type;
    double height = 0;
    for (int first = 0, next; first < n; first = next) {
        double width = -gap;
        for (next = first; next < n; next++) { /* lines and marks in rows of their own */
            const double entry = sample + 5 + plot_text_width(entries[next].text, type - 1) + gap;
            if (next > first && (width + entry > right - left || (entries[next].mark >= 0) != (entries[first].mark >= 0)))
                break;
            width += entry;
        }
        height += line;
        double x = (left + right - width) / 2;
        const double y = top - height + line / 2;
        for (int i = first; page && i < next; i++) {
            if (entries[i].stroke >= 0)
                draw_segment(page, (plot_stroke)entries[i].stroke, x, y, x + sample, y);
            if (entries[i].mark >= 0)
                plot_page_mark(page, (plot_mark)entries[i].mark, (plot_point){x + sample / 2, y}, 4.5);
            plot_page_text(page, (plot_point){x + sample + 5, y}, PLOT_LEFT, type - 1, "#222222", false, entries[i].text);
            x += sample + 5 + plot_text_width(entries[i].text, type - 1) + gap;
        }
    }
    return height;
}

/* ------------------------------------------------------------------- labels */

typedef struct {
    plot_point from, to;
} leader_line;

typedef struct {
    plot_page *page;
    plot_box bounds;
    double size;
    int n_leader;
    leader_line *leaders;
} placing;

static int heavier(const void *a, const void *b)
{
    const plot_tag *s = a, *t = b;
    if (s->weight != t->weight)
        return s->weight < t->weight ? 1 : -1;
    /* qsort keeps no order of its own, and the picture must be the same on every machine */
    return s->at.x != t->at.x ? (s->at.x > t->at.x) - (s->at.x < t->at.x) : (s->at.y > t->at.y) - (s->at.y < t->at.y);
}

static bool crosses_box(leader_line line, plot_box box)
{
    return plot_clip_segment(&box, &line.from, &line.to);
}

static double side_of(plot_point a, plot_point b, plot_point c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static bool lines_cross(leader_line a, leader_line b)
{
    return side_of(a.from, a.to, b.from) * side_of(a.from, a.to, b.to) <= 0 && side_of(b.from, b.to, a.from) * side_of(b.from, b.to, a.to) <= 0;
}

/* Pixels of lines that the leader passes over. */
static double leader_ink(plot_page *page, leader_line line)
{
    const double length = hypot(line.to.x - line.from.x, line.to.y - line.from.y);
    double ink = 0;
    for (double s = 0; s < length; s += 1) {
        const double x = line.from.x + (line.to.x - line.from.x) * s / length, y = line.from.y + (line.to.y - line.from.y) * s / length;
        ink += plot_page_ink(page, (plot_box){floor(x), floor(y), floor(x) + 1, floor(y) + 1}) > 0;
    }
    return ink;
}

static leader_line leader_to(const plot_tag *tag, plot_box box)
{
    const plot_point nearest = {fmax(box.left, fmin(box.right, tag->at.x)), fmax(box.bottom, fmin(box.top, tag->at.y))};
    const double dx = nearest.x - tag->at.x, dy = nearest.y - tag->at.y, length = fmax(hypot(dx, dy), 1e-9), start = fmin(tag->clear, length);
    return (leader_line){{tag->at.x + dx / length * start, tag->at.y + dy / length * start}, nearest};
}

/* Cost of the leader, or infinity where it would meet a label, another mark or a leader. */
static double leader_cost(const placing *p, const plot_tag *tag, leader_line line)
{
    const double start = hypot(line.from.x - line.to.x, line.from.y - line.to.y);
    /* The first pixel belongs to the own mark, and to marks that share its place. */
    leader_line rest = line;
    rest.from.x += (line.to.x - line.from.x) * fmin(1, 2 / fmax(start, 1e-9));
    rest.from.y += (line.to.y - line.from.y) * fmin(1, 2 / fmax(start, 1e-9));
    if (!plot_page_free_line(p->page, rest.from, rest.to))
        return INFINITY;
    for (int i = 0; i < p->n_leader; i++)
        if (lines_cross(line, p->leaders[i]))
            return INFINITY;
    return 2.5 * leader_ink(p->page, rest) + (tag->clear > 0 ? 4 : 8);
}

/* Cost of a box for the tag: infinite where it cannot stand. */
static double box_cost(const placing *p, const plot_tag *tag, plot_box box, double distance)
{
    const plot_box wide = {box.left - 2, box.bottom - 1, box.right + 2, box.top + 1};
    if (wide.left < p->bounds.left || wide.right > p->bounds.right || wide.bottom < p->bounds.bottom || wide.top > p->bounds.top)
        return INFINITY;
    if (!plot_page_free_box(p->page, wide) || plot_page_ink(p->page, wide) > 0)
        return INFINITY;
    for (int i = 0; i < p->n_leader; i++)
        if (crosses_box(p->leaders[i], wide))
            return INFINITY;
    if (distance < 9)
        return distance;
    return tag->leader ? distance + leader_cost(p, tag, leader_to(tag, box)) : INFINITY;
}

static plot_box box_around(plot_point centre, double width, double height)
{
    return (plot_box){centre.x - width / 2, centre.y - height / 2, centre.x + width / 2, centre.y + height / 2};
}

/* Sixteen directions at growing distances; to the right and above are preferred a little, as on maps. */
static bool find_place(const placing *p, const plot_tag *tag, plot_box *out, double *gap)
{
    static const double distances[] = {2, 5, 8, 13, 20, 29, 40, 53, 68, 86, 106, 130};
    const plot_box size = plot_text_box((plot_point){0, 0}, PLOT_LEFT, p->size, false, tag->text);
    const double width = size.right - size.left, height = size.top - size.bottom;
    double best = INFINITY;
    for (size_t i = 0; i < sizeof distances / sizeof *distances && distances[i] < best; i++)
        for (int k = 0; k < 16; k++) {
            const double angle = acos(-1) / 8 * k, reach = tag->clear + distances[i];
            const plot_point centre = {tag->at.x + cos(angle) * (reach + width / 2), tag->at.y + sin(angle) * (reach + height / 2)};
            const plot_box box = box_around(centre, width, height);
            const double cost = box_cost(p, tag, box, distances[i]) + 0.6 * (1 - cos(angle - 0.6));
            if (cost < best) {
                best = cost;
                *out = box;
                *gap = distances[i];
            }
        }
    return best < INFINITY;
}

static bool group_done(int n, const plot_tag *tags, const bool *placed, int group)
{
    for (int i = 0; group > 0 && i < n; i++)
        if (placed[i] && tags[i].group == group)
            return true;
    return false;
}

/* Labels that found no place, alternatives counted once. */
static int count_missing(int n, const plot_tag *tags, bool *placed)
{
    int missing = 0;
    for (int i = 0; i < n; i++)
        if (!placed[i] && !group_done(n, tags, placed, tags[i].group)) {
            placed[i] = true;
            missing++;
        }
    return missing;
}

int plot_place_tags(plot_page *page, plot_box bounds, int n, plot_tag *tags, double size)
{
    bool *placed = calloc((size_t)n + 1, sizeof *placed);
    placing p = {.page = page, .bounds = bounds, .size = size, .leaders = malloc(((size_t)n + 1) * sizeof *p.leaders)};
    int missing = n;
    if (!placed || !p.leaders)
        goto out;
    if (n > 0)
        qsort(tags, (size_t)n, sizeof *tags, heavier);
    for (int i = 0; i < n; i++) {
        plot_box box;
        double gap = 0;
        if (group_done(n, tags, placed, tags[i].group) || !find_place(&p, &tags[i], &box, &gap))
            continue;
        placed[i] = true;
        plot_page_text(page, (plot_point){box.left, (box.bottom + box.top) / 2}, PLOT_LEFT, size, tags[i].colour, false, tags[i].text);
        if (gap >= 9)
            p.leaders[p.n_leader++] = leader_to(&tags[i], box);
    }
    for (int i = 0; i < p.n_leader; i++)
        plot_page_line(page, PLOT_LEADER, 2, (plot_point[]){p.leaders[i].from, p.leaders[i].to});
    missing = count_missing(n, tags, placed);
out:
    free(placed);
    free(p.leaders);
    return missing;
}

/* --------------------------------------------------- what pictures agree on */

plot_mark plot_junction_mark(ric_kind kind)
{
    switch (kind) {
    case RIC_KIND_GRAZING: return PLOT_CIRCLE;
    case RIC_KIND_BRANCH_POINT: return PLOT_SQUARE;
    case RIC_KIND_EXTREMUM: return PLOT_TRIANGLE;
    case RIC_KIND_CORNER: return PLOT_DIAMOND;
    case RIC_KIND_MULTIPLICATION: return PLOT_STAR;
    case RIC_KIND_PERIOD_EXTREMUM: return PLOT_TRIANGLE_DOWN;
    case RIC_KIND_USER: return PLOT_CROSS;
    case RIC_KIND_START: break;
    }
    return PLOT_DOT;
}

plot_stroke plot_branch_family(const ric_branch *branch)
{
    return branch->impacts == 0 && branch->depth == 0 ? PLOT_LINEAR : branch->symmetric ? PLOT_SYMMETRIC : PLOT_ASYMMETRIC;
}

void plot_branch_title(const ric_branch *branch, int k, size_t size, char *out)
{
    char text[400];
    const bool fits = branch->label && !ric_duplicate_label(branch, k, sizeof text, text);
    plot_text_label(fits ? text : branch->label ? branch->label : "", size, out);
}

/* ------------------------------------------------------------------ options */

bool plot_parse_range(const char *text, const char *what, double range[2])
{
    char first[64];
    const char *colon = strchr(text, ':');
    if (!colon || (size_t)(colon - text) >= sizeof first) {
        cli_wrong("%s %s: a range is A:B, for example 0.5:200", what, text);
        return false;
    }
    memcpy(first, text, (size_t)(colon - text));
    first[colon - text] = '\0';
    if (!cli_parse_number(first, what, &range[0]) || !cli_parse_number(colon + 1, what, &range[1]))
        return false;
    if (!(isfinite(range[0]) && isfinite(range[1]) && range[0] < range[1])) {
        cli_wrong("%s %s: a range A:B needs A < B", what, text);
        return false;
    }
    return true;
}

bool plot_parse_window(const char *text, const char *what, double window[4])
{
    char first[64];
    const char *comma = strchr(text, ',');
    if (!comma || (size_t)(comma - text) >= sizeof first) {
        cli_wrong("%s %s: a window is X0:X1,Y0:Y1, for example 15:30,1.5:1.7", what, text);
        return false;
    }
    memcpy(first, text, (size_t)(comma - text));
    first[comma - text] = '\0';
    return plot_parse_range(first, what, window) && plot_parse_range(comma + 1, what, window + 2);
}

static bool take_size(const char *text, plot_options *options)
{
    char first[32];
    const char *cross = strchr(text, 'x');
    long width, height;
    if (!cross || (size_t)(cross - text) >= sizeof first) {
        cli_wrong("--size %s: a size is WIDTHxHEIGHT in pixels, for example 1000x700", text);
        return false;
    }
    memcpy(first, text, (size_t)(cross - text));
    first[cross - text] = '\0';
    if (!cli_parse_integer(first, "--size", 320, 8000, &width) || !cli_parse_integer(cross + 1, "--size", 240, 8000, &height))
        return false;
    options->width = (double)width;
    options->height = (double)height;
    return true;
}

static const struct {
    const char *name;
    int (*run)(int argc, char **argv, const plot_options *options);
    bool by_id; /* takes branches and junctions by id only */
} kinds[] = {
    {"fep", plot_fep, false}, {"orbit", plot_orbit, true}, {"orbits", plot_orbits, false}, {"curves", plot_curves, true},
    {"floquet", plot_floquet, true}, {"cascade", plot_cascade, true}, {"sheet", plot_sheet, false}, {"strobe", plot_strobe, false},
};

/* The first word that is neither an option nor the value of one. */
static const char *operand(int argc, char **argv)
{
    for (int i = 2; i < argc; i++) {
        if (argv[i][0] != '-')
            return argv[i];
        if (strcmp(argv[i], "--circle") && strcmp(argv[i], "--shapes") && !strchr(argv[i], '='))
            i++;
    }
    return NULL;
}

/* Pictures of one atlas take branches and junctions by id; here names become ids. */
enum { MAX_NAMED = 64 };
static int resolve_names(int argc, char **argv, char ids[MAX_NAMED][16])
{
    ric_atlas *atlas = NULL;
    int n = 0, code = CLI_DONE;
    for (int i = 2; i + 1 < argc && n < MAX_NAMED && code == CLI_DONE; i++) {
        const bool branch = !strcmp(argv[i], "--branch");
        char *name = argv[i + 1];
        plot_segment segment;
        if ((!branch && strcmp(argv[i], "--junction")) || strspn(name, "0123456789+-") > 0 || !operand(argc, argv))
            continue;
        if (!atlas && ric_atlas_read(operand(argc, argv), &atlas) != RIC_OK)
            return CLI_DONE; /* the picture itself will say what is wrong with it */
        if (branch ? plot_find_segment(atlas, name, "--branch", &segment) : plot_find_junction(atlas, name, "--junction", &segment.branch)) {
            snprintf(ids[n], sizeof ids[n], "%d", segment.branch);
            argv[i + 1] = ids[n++];
        } else {
            code = CLI_WRONG;
        }
    }
    ric_atlas_free(atlas);
    return code;
}

static int run(int argc, char **argv)
{
    plot_options options = {0};
    char ids[MAX_NAMED][16];
    const char *size = NULL;
    if (argc < 2)
        return cli_wrong("plot: which picture? fep, orbit, orbits, curves, floquet, cascade, sheet or strobe; see ricochet plot --help");
    if (!cli_take_value(&argc, argv, "-o", &options.out) || !cli_take_value(&argc, argv, "--title", &options.title)
        || !cli_take_value(&argc, argv, "--size", &size))
        return CLI_WRONG;
    if (size && !take_size(size, &options))
        return CLI_WRONG;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (argc > 1 && !strcmp(argv[1], kinds[i].name)) {
            if (!options.out)
                return cli_wrong("plot %s: -o FILE.svg, FILE.pdf or FILE.png is missing", argv[1]);
            int code = plot_check_target(options.out);
            if (code == CLI_DONE && kinds[i].by_id)
                code = resolve_names(argc, argv, ids);
            return code == CLI_DONE ? kinds[i].run(argc - 1, argv + 1, &options) : code;
        }
    return cli_wrong("plot: unknown picture '%s'; there are fep, orbit, orbits, curves, floquet, cascade, sheet and strobe", argc > 1 ? argv[1] : "");
}

const cli_command cli_plot = {
    .name = "plot",
    .summary = "draw an atlas, an orbit or curves as SVG, PDF or PNG",
    .help =
        "usage: ricochet plot fep ATLAS... [--linear] [--log-frequency] [--energy A:B] [--frequency A:B] [--break F] [--zoom A:B,C:D]...\n"
        "           [--labels all|named|none] [--label NAME]... [--mark ORBIT]... [--ghosts] [--symmetric] [--duplicates K]\n"
        "           [--branch SEGMENT]... [--duplicate K:SEGMENT]... [--base Fj_i] [--key TEXT] -o FILE\n"
        "       ricochet plot orbit ATLAS --branch ID (--point I | --energy E | --frequency F) [--which K] [--coordinates 1,2] -o FILE\n"
        "       ricochet plot orbit ATLAS --junction ID [--coordinates 1,2] -o FILE\n"
        "       ricochet plot orbits ATLAS --orbit ORBIT... [ATLAS --orbit ORBIT...]... [--histories] [--columns N] [--same-axes] [--coordinates 1,2] -o FILE\n"
        "       ricochet plot curves ATLAS --x NAME --y NAME [--branch ID]... [--log x|y|xy] [--window A:B,C:D] -o FILE\n"
        "       ricochet plot floquet ATLAS --branch ID [--x NAME] -o FILE\n"
        "       ricochet plot cascade ATLAS --branch ID (--multiply LIST | --doublings N) [--dof I] [--shapes] -o FILE\n"
        "       ricochet plot cascade ATLAS --branch ID --circle [--duplicate K] -o FILE\n"
        "       ricochet plot sheet ATLAS --segment SEGMENT... [ATLAS --segment SEGMENT...]... [--orbits N] [--contact I] -o FILE\n"
        "       ricochet plot strobe ATLAS --segment [K:]SEGMENT... [--samples N] [--dof I] [--orbits N] [--stretch] -o FILE\n"
        "\n"
        "Draws with gnuplot; the ending of FILE chooses SVG, PDF or PNG.\n"
        "\n"
        "fep      frequency-energy plot: symmetric branches dark, asymmetric ones orange, linear modes grey; stable thick, unstable thin,\n"
        "         undecided dotted; natural frequencies and frequencies with a contact locked as reference lines\n"
        "  --linear            linear energy axis instead of a logarithmic one\n"
        "  --energy A:B        window of the scaled energy\n"
        "  --frequency A:B     window of the frequency, rad/s\n"
        "  --break F           broken frequency axis: logarithmic and compressed above F\n"
        "  --labels WHAT       all: every junction that finds room; named: those with a name in the study; none. Without it: named and main ones\n"
        "  --duplicates K      dashed: the branches gone through k = 2..K times, at frequency / k, with the multiplications on them\n"
        "  --log-frequency     logarithmic frequency axis\n"
        "  --zoom A:B,C:D      one more panel with these energies and frequencies; up to five\n"
        "  --symmetric         only symmetric branches; --branch SEGMENT: only these; --base F6_2: only what `ricochet bases` lists there\n"
        "  --duplicate K:SEGMENT  the K-duplicate of this one\n"
        "  --label NAME        only this junction or branch has a label; may be repeated\n"
        "  --mark ORBIT        a dot, or the mark of a junction, with a name of its own\n"
        "  --key TEXT          several atlases are drawn over one another, each in its colour: what the legend calls it, else the title of its study\n"
        "  --ghosts            red: how the equations of the branches shown go on beyond grazings and corners, where they give no motion\n"
        "orbit    displacements and gaps over one period with impacts and touches, and phase portraits\n"
        "  --branch ID         with --point I (from 0), --energy E or --frequency F; --which K if several orbits fit (from 1)\n"
        "  --junction ID       the original orbit of a junction\n"
        "  --coordinates LIST  which coordinates to show, at most 4\n"
        "orbits   a row of histories and phase portraits for each orbit, its impacts above it; --histories leaves out the portraits\n"
        "  --columns N         rows side by side; --same-axes: the same scales in all\n"
        "curves   any unknowns against each other: arclength energy frequency period trace rotation reach approach x1.. v1.. tau1..\n"
        "  --branch ID         only this branch; may be repeated\n"
        "  --log x|y|xy        logarithmic axes; --window A:B,C:D what they show\n"
        "floquet  multipliers along a branch: the trace (2 and -2 dashed) and rotation number of two masses, moduli and angles of more\n"
        "  --x NAME            against arclength (usual), energy or frequency\n"
        "cascade  a cascade as `ricochet cascade` follows it: a displacement at all impacts against the frequency passed on the way, times q\n"
        "  --multiply LIST, --doublings N   which cascade\n"
        "  --dof I             the displacement; the last one unless given\n"
        "  --shapes            instead the motions at the multiplications, time scaled to equal numbers of impacts\n"
        "  --circle            instead the multipliers along the branch on the unit circle, with the multiplications p/K of its K-duplicate\n"
        "  --duplicate K       8 unless given\n"
        "sheet    a gap along a part of a branch: --orbits N motions one behind the other, over time in periods; --contact I chooses the gap\n"
        "strobe   a displacement, zero at the start, at --samples N instants of K periods, along segments one after the other\n"
        "  --stretch           all segments equally wide instead of by the frequency passed\n"
        "names    a junction: its id, name or label. SEGMENT: a branch by id or label, LABEL|P1 where it meets P1, LABEL|P1 P2 for the part between\n"
        "         two junctions, #N behind it for the Nth that fits. ORBIT: a junction, or SEGMENT@0.3 (part of the way), SEGMENT@E=20, SEGMENT@F=1.5; then *K if it is gone through\n"
        "         K times (a q-tupling counts q); before it 'NAME: '. With several atlases such options stand behind the one that they belong to\n"
        "all\n"
        "  --title TEXT        instead of the title of the study\n"
        "  --size WxH          pixels (1/96 inch in PDF)\n"
        "\n"
        "example: ricochet plot fep two-masses.ricochet --break 2.2 -o two-masses.svg\n",
    .run = run,
};
