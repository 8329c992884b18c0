/* Axes with their tics, panels, and curves in them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

static const double far_away = 1e6;   /* pixels, for values that a logarithm does not reach */
static const double knee_part = 0.68; /* of a broken axis lies below its knee */
static const double cut_part = 0.014; /* of a cut axis is the width of a cut */
static const double type = 12;

/* --------------------------------------------------------------------- axes */

static double clamp_pixels(double value)
{
    return isnan(value) ? value : fmax(-far_away, fmin(far_away, value));
}

/* Piece i of a cut axis, or its cut i: data and pixels, by which it is linear. */
static plot_axis piece_of(const plot_axis *a, int i, bool is_cut)
{
    const double length = a->to - a->from, half = cut_part * length / 2;
    const plot_cut *below = i > 0 ? &a->cut[i - 1] : NULL,
                   *above = i < a->n_cut ? &a->cut[i] : NULL;
    plot_axis piece = {.scale = PLOT_SCALE_LINEAR, .unit = a->unit};
    if (is_cut) {
        const double at = a->from + a->cut[i].at * length;
        piece.lo = a->cut[i].lo;
        piece.hi = a->cut[i].hi;
        piece.from = at - half;
        piece.to = at + half;
        return piece;
    }
    piece.lo = below ? below->hi : a->lo;
    piece.hi = above ? above->lo : a->hi;
    piece.from = below ? a->from + below->at * length + half : a->from;
    piece.to = above ? a->from + above->at * length - half : a->to;
    return piece;
}

bool plot_axis_omits(const plot_axis *a, double value)
{
    bool omits = false;
    for (int i = 0; i < a->n_cut && a->scale == PLOT_SCALE_CUT; i++)
        omits |= value > a->cut[i].lo && value < a->cut[i].hi;
    return omits;
}

static double cut_axis_at(const plot_axis *a, double value)
{
    int i = 0;
    while (i < a->n_cut && value > a->cut[i].lo) i++;
    const bool in_cut = i > 0 && value < a->cut[i - 1].hi;
    const plot_axis piece = piece_of(a, in_cut ? i - 1 : i, in_cut);
    return piece.from + (piece.to - piece.from) * (value - piece.lo) / (piece.hi - piece.lo);
}

double plot_axis_at(const plot_axis *axis, double value)
{
    const double length = axis->to - axis->from, fold = axis->from + knee_part * length;
    switch (axis->scale) {
    case PLOT_SCALE_LOG:
        if (value <= 0) return axis->from - far_away;
        return clamp_pixels(axis->from + length * log(value / axis->lo) / log(axis->hi / axis->lo));
    case PLOT_SCALE_BROKEN:
        if (value > axis->knee)
            return clamp_pixels(fold + (axis->to - fold) * log(value / axis->knee) /
                                           log(axis->hi / axis->knee));
        return clamp_pixels(axis->from +
                            (fold - axis->from) * (value - axis->lo) / (axis->knee - axis->lo));
    case PLOT_SCALE_CUT: return clamp_pixels(cut_axis_at(axis, value));
    default: return clamp_pixels(axis->from + length * (value - axis->lo) / (axis->hi - axis->lo));
    }
}

void plot_range_empty(double x[2], double y[2])
{
    x[0] = y[0] = INFINITY;
    x[1] = y[1] = -INFINITY;
}

void plot_range_take(plot_point p, double x[2], double y[2])
{
    x[0] = fmin(x[0], p.x);
    x[1] = fmax(x[1], p.x);
    y[0] = fmin(y[0], p.y);
    y[1] = fmax(y[1], p.y);
}

void plot_range_window(const double window[4], double x[2], double y[2])
{
    for (int i = 0; i < 2; i++) {
        x[i] = window[i];
        y[i] = window[2 + i];
    }
}

plot_axis plot_axis_linear(double lo, double hi, double from, double to)
{
    return (plot_axis){.scale = PLOT_SCALE_LINEAR, .lo = lo, .hi = hi, .from = from, .to = to};
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
    plot_axis axis;   /* as its numbers have it */
    double low, high; /* data range that the tics are for */
    int power;        /* of ten, that the labels of a linear axis leave to its title */
    int n, room;
    tick *ticks; /* as many as the length of the axis asks for */
    bool failed; /* no memory: the list is not whole, and the page must not be shown */
} tick_list;

/* `text` NULL makes a minor tic. */
static void add_tick(tick_list *list, double value, const char *text)
{
    if (list->failed || value < list->low || value > list->high) return;
    if (list->n == list->room) {
        const int room = list->room ? 2 * list->room : 256;
        tick *ticks = realloc(list->ticks, (size_t)room * sizeof *ticks);
        list->failed = !ticks;
        if (!ticks) return;
        list->ticks = ticks;
        list->room = room;
    }
    tick *t = &list->ticks[list->n++];
    *t = (tick){.at = plot_axis_at(&list->axis, value), .major = text != NULL};
    if (text && *text == '-') /* a real minus sign */
        snprintf(t->text, sizeof t->text, "\xe2\x88\x92%.56s", text + 1);
    else if (text) snprintf(t->text, sizeof t->text, "%s", text);
}

/* 1, 2 or 5 times a power of ten, so that about `count` steps fit. */
double plot_nice_step(double span, double count)
{
    const double raw = span / fmax(1, count), power = pow(10, floor(log10(raw))),
                 lead = raw / power;
    return power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

/* A step that shows three labels or more: one alone says nothing of the scale. */
static double telling_step(double low, double high, double count)
{
    double step = plot_nice_step(high - low, count);
    for (int i = 0; i < 2 && floor(high / step) - ceil(low / step) < 2; i++)
        step = plot_nice_step(step / 2, 1);
    return step;
}

/* Very small and very large numbers may share a power of ten that a title names. */
static void linear_ticks(tick_list *list, double pixels, double spacing, bool share_power)
{
    const double step = telling_step(list->low, list->high, pixels / spacing),
                 slack = 1e-9 * (list->high - list->low);
    const double lead = step / pow(10, floor(log10(step) + 1e-9)),
                 size = fmax(fabs(list->low), fabs(list->high));
    const int fine = lead > 1.5 && lead < 3 ? 4 : 5,
              minor = pixels * step / (list->high - list->low) / fine < 7 ? fine == 4 ? 2 : 1
                                                                          : fine;
    list->power = share_power && size > 0 && (size < 0.02 || size >= 1e5)
                      ? (int)floor(log10(size) + 1e-9)
                      : 0;
    const double unit = pow(10, list->power), shown = size / unit;
    const bool plain = shown < 1e5 && step / unit > 1e-7 * (shown < 1 ? 1 : shown);
    const int digits = plain ? (int)fmax(0, -floor(log10(step / unit) + 1e-9)) : 6;
    const int most = list->n +
                     (int)pixels; /* also where a step is lost in the last digit of the values */
    list->low -= slack;
    list->high += slack;
    for (double k = ceil(list->low / step * minor);
         k * step / minor <= list->high && list->n < most && !list->failed; k++) {
        const double value = k == 0 ? 0 : k * step / minor;
        char text[64];
        snprintf(text, sizeof text, plain ? "%.*f" : "%.*g", digits, value / unit);
        add_tick(list, value, fabs(fmod(k, minor)) < 0.5 ? text : NULL);
    }
}

/* tenths / 10 * 10^exponent */
static void power_tick(tick_list *list, int tenths, int exponent)
{
    const double value = tenths * pow(10, exponent - 1);
    char text[64];
    if (exponent < 5 && exponent > -4) snprintf(text, sizeof text, "%.10g", value);
    else if (tenths == 10) snprintf(text, sizeof text, "10^{%d}", exponent);
    else
        snprintf(text, sizeof text,
                 "%g\xc2\xb7"
                 "10^{%d}",
                 tenths / 10., exponent);
    add_tick(list, value, text);
}

/* Which of a decade have a label, in tenths: the more, the larger a decade is, in widths of a
 * label. */
static const char *labelled(double decade)
{
    static const struct {
        double least;
        char tenths[13];
    } sets[] = {{22, {10, 12, 15, 20, 25, 30, 40, 50, 60, 70, 80, 90}},
                {12, {10, 15, 20, 30, 40, 50, 70}},
                {9, {10, 20, 30, 50}},
                {4.5, {10, 20, 50}},
                {2.2, {10, 30}},
                {0, {10}}};
    int i = 0;
    while (decade <= sets[i].least && sets[i].least > 0) i++;
    return sets[i].tenths;
}

static void log_ticks(tick_list *list, double pixels, double spacing)
{
    const double decade = pixels / log10(list->high / list->low);
    if (pixels / decade < 0.45) {
        linear_ticks(list, pixels, spacing, false);
        return;
    }
    const char *tenths = labelled(decade / spacing);
    const int every = (int)fmax(1, ceil(spacing /
                                        decade)); /* with tiny decades only every other power */
    const bool fine = decade > 22 * spacing;
    for (int e = (int)floor(log10(list->low)) - 1; e <= (int)ceil(log10(list->high)); e++)
        for (int k = 10; k < 100; k++) {
            if (strchr(tenths, k) && e % every == 0) power_tick(list, k, e);
            else if (decade > 25 && (k % 10 == 0 || (fine && (k < 50 || k % 5 == 0))))
                add_tick(list, k * pow(10, e - 1), NULL);
        }
}

/* The trace on the scale asinh(trace / 2), which shows its sign and all its orders of magnitude;
 * what is to be labelled first comes first. */
static void asinh_ticks(tick_list *list, double pixels)
{
    const double orders = ceil(fmax(fabs(list->low), fabs(list->high)) / log(10)),
                 every = fmax(1, ceil(orders * 60 /
                                      pixels)); /* as many as a trace beyond all doubles may have */
    char text[64];
    add_tick(list, 0, "0");
    for (int sign = -1; sign <= 1; sign += 2) {
        add_tick(list, sign * asinh(1), sign > 0 ? "2" : "-2");
        for (double e = every; e <= orders; e += every) {
            snprintf(text, sizeof text, e == 1 ? "%s10" : "%s10^{%.10g}", sign < 0 ? "-" : "", e);
            add_tick(list, sign * (e < 15 ? asinh(pow(10, e) / 2) : e * log(10)), text);
        }
    }
}

/* Each piece has tics of its own; every one shows its numbers. */
static void cut_ticks(tick_list *list, double spacing)
{
    const plot_axis *axis = &list->axis;
    for (int i = 0; i <= axis->n_cut; i++) {
        const plot_axis piece = piece_of(axis, i, false);
        list->low = piece.lo;
        list->high = piece.hi;
        linear_ticks(list, piece.to - piece.from, spacing, false);
    }
}

static void axis_ticks(tick_list *list, const plot_axis *axis, double spacing, const char *title)
{
    const double pixels = axis->to - axis->from, unit = axis->unit > 0 ? axis->unit : 1;
    *list = (tick_list){.axis = *axis};
    axis = &list->axis;
    list->axis.lo *= unit;
    list->axis.hi *= unit;
    list->axis.knee *= unit;
    for (int i = 0; i < axis->n_cut; i++) {
        list->axis.cut[i].lo *= unit;
        list->axis.cut[i].hi *= unit;
    }
    list->low = axis->lo;
    list->high = axis->hi;
    switch (axis->scale) {
    case PLOT_SCALE_LINEAR: linear_ticks(list, pixels, spacing, title && *title); break;
    case PLOT_SCALE_LOG: log_ticks(list, pixels, spacing); break;
    case PLOT_SCALE_ASINH: asinh_ticks(list, pixels); break;
    case PLOT_SCALE_CUT: cut_ticks(list, spacing); break;
    case PLOT_SCALE_BROKEN:
        list->high = axis->knee;
        linear_ticks(list, knee_part * pixels, spacing, false);
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
    return p.x >= box.left - 0.01 && p.x <= box.right + 0.01 && p.y >= box.bottom - 0.01 &&
           p.y <= box.top + 0.01;
}

static void draw_segment(plot_page *page, plot_stroke stroke, double x0, double y0, double x1,
                         double y1)
{
    plot_page_line(page, stroke, 2, (plot_point[]){{x0, y0}, {x1, y1}});
}

/* Whether the label of tick i, `half` to both sides of it, stays `gap` away from those shown
 * before. */
static bool show_label(tick_list *list, int i, double half, double gap)
{
    tick *t = &list->ticks[i];
    t->from = t->at - half;
    t->to = t->at + half;
    t->shown = t->major;
    for (int k = 0; k < i && t->shown; k++)
        t->shown = !list->ticks[k].shown || t->from > list->ticks[k].to + gap ||
                   t->to < list->ticks[k].from - gap;
    return t->shown;
}

/* For a title with its power of ten, which must not be cut off. */
static size_t title_room(const char *title)
{
    return (title ? strlen(title) : 0) + sizeof " / 10^{-2147483648}";
}

/* "time (s)" of which the labels are 1, 2 and 3 for 1e-4, 2e-4 and 3e-4: "time (s) / 10^{-4}". */
static const char *full_title(const tick_list *list, const char *title, size_t size, char *out)
{
    if (list->power == 0) return title;
    snprintf(out, size, "%s / 10^{%d}", title, list->power);
    return out;
}

static void draw_x_axis(plot_page *page, const plot_box *box, const plot_axis *axis,
                        const char *title)
{
    tick_list list;
    char full[title_room(title)];
    axis_ticks(&list, axis, 62, title);
    title = full_title(&list, title, sizeof full, full);
    if (list.failed) plot_page_fail(page);
    for (int i = 0; i < list.n; i++) {
        const tick *t = &list.ticks[i];
        const double length = t->major ? 6 : 3;
        draw_segment(page, PLOT_FRAME, t->at, box->bottom, t->at, box->bottom + length);
        draw_segment(page, PLOT_FRAME, t->at, box->top, t->at, box->top - length);
        if (title && show_label(&list, i, plot_text_width(t->text, type) / 2, 6))
            plot_page_text(page, (plot_point){t->at, box->bottom - 12}, PLOT_CENTRE, type,
                           "#222222", false, t->text);
    }
    free(list.ticks);
    if (title && *title)
        plot_page_text(page, (plot_point){(box->left + box->right) / 2, box->bottom - 31},
                       PLOT_CENTRE, type + 1, "#222222", false, title);
}

double plot_axis_widest(const plot_axis *axis)
{
    tick_list list;
    double widest = 0;
    axis_ticks(&list, axis, 42, "");
    for (int i = 0; i < list.n; i++)
        if (list.ticks[i].major) widest = fmax(widest, plot_text_width(list.ticks[i].text, type));
    free(list.ticks);
    return widest;
}

static void draw_y_axis(plot_page *page, const plot_box *box, const plot_axis *axis,
                        const char *title)
{
    tick_list list;
    double widest = 0;
    char full[title_room(title)];
    axis_ticks(&list, axis, 42, title);
    title = full_title(&list, title, sizeof full, full);
    if (list.failed) plot_page_fail(page);
    for (int i = 0; i < list.n; i++) {
        const tick *t = &list.ticks[i];
        const double length = t->major ? 6 : 3;
        draw_segment(page, PLOT_FRAME, box->left, t->at, box->left + length, t->at);
        draw_segment(page, PLOT_FRAME, box->right, t->at, box->right - length, t->at);
        if (title && show_label(&list, i, 0.6 * type, 0)) {
            plot_page_text(page, (plot_point){box->left - 10, t->at}, PLOT_RIGHT, type, "#222222",
                           false, t->text);
            widest = fmax(widest, plot_text_width(t->text, type));
        }
    }
    free(list.ticks);
    if (!title || !*title) return;
    /* never beyond the page */
    const double size = fmin(type + 1, (type + 1) * (box->top - box->bottom) /
                                           plot_text_width(title, type + 1));
    const double x = fmax(box->left - widest - 23,
                          0.8 * size); /* long numbers do not push it off the page */
    plot_page_text(page, (plot_point){x, (box->bottom + box->top) / 2}, PLOT_CENTRE, size,
                   "#222222", true, title);
}

/* A line across, and the sign of a broken axis at both ends of it. */
static void draw_break(plot_page *page, const plot_box *box, double at)
{
    draw_segment(page, PLOT_GRID, box->left, at, box->right, at);
    for (int side = 0; side < 2; side++)
        for (int stripe = -1; stripe <= 1; stripe += 2) {
            const double x = side ? box->right : box->left, y = at + 2.5 * stripe;
            draw_segment(page, PLOT_FRAME, x - 7, y - 4, x + 7, y + 4);
        }
}

void plot_panel_frame(plot_page *page, const plot_panel *panel, const char *x_title,
                      const char *y_title)
{
    const plot_box box = plot_panel_box(panel);
    plot_page_line(page, PLOT_FRAME, 5,
                   (plot_point[]){{box.left, box.bottom},
                                  {box.right, box.bottom},
                                  {box.right, box.top},
                                  {box.left, box.top},
                                  {box.left, box.bottom}});
    draw_x_axis(page, &box, &panel->x, x_title);
    draw_y_axis(page, &box, &panel->y, y_title);
    const plot_axis *y = &panel->y;
    if (y->scale == PLOT_SCALE_BROKEN) draw_break(page, &box, plot_axis_at(y, y->knee));
    for (int i = 0; i < y->n_cut && y->scale == PLOT_SCALE_CUT; i++)
        draw_break(page, &box, y->from + y->cut[i].at * (y->to - y->from));
}

/* Liang and Barsky 1984. */
bool plot_clip_segment(const plot_box *box, plot_point *a, plot_point *b)
{
    const double dx = b->x - a->x, dy = b->y - a->y;
    const double p[4] = {-dx, dx, -dy, dy},
                 q[4] = {a->x - box->left, box->right - a->x, a->y - box->bottom, box->top - a->y};
    double enter = 0, leave = 1;
    for (int i = 0; i < 4; i++) {
        if (p[i] == 0 && q[i] < 0) return false;
        if (p[i] < 0) enter = fmax(enter, q[i] / p[i]);
        else if (p[i] > 0) leave = fmin(leave, q[i] / p[i]);
    }
    if (enter > leave) return false;
    const plot_point start = *a;
    *a = (plot_point){start.x + enter * dx, start.y + enter * dy};
    *b = (plot_point){start.x + leave * dx, start.y + leave * dy};
    return true;
}

/* Drops points that lie within a fortieth of a pixel, a tenth where a picture is seen four times as
 * large, of the line through their neighbours: a cone of directions from the last kept point
 * narrows with every point passed over. In place; returns how many are left. */
static int thin_line(int n, plot_point *p)
{
    const double tolerance = 1. / 40;
    int kept = n > 0;
    double middle = 0, low = -4, high = 4, reach = 0;
    bool open = false;
    for (int i = 1; i < n; i++) {
        const plot_point from = p[kept - 1];
        const double dx = p[i].x - from.x, dy = p[i].y - from.y, distance = hypot(dx, dy);
        if (distance <= tolerance && i < n - 1 && !open) continue;
        double angle = atan2(dy, dx);
        if (open) angle = middle + remainder(angle - middle, 2 * acos(-1));
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
        if (i == n - 1) p[kept++] = p[i];
    }
    return kept;
}

static void flush_run(plot_page *page, plot_stroke stroke, int *n, plot_point *run)
{
    const int left = thin_line(*n, run);
    if (left > 1) plot_page_line(page, stroke, left, run);
    *n = 0;
}

void plot_panel_curve(plot_page *page, const plot_panel *panel, plot_stroke stroke, int n,
                      const plot_point *data)
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
        if (length == 0) run[length++] = a;
        run[length++] = b;
        if (b.x != end.x || b.y != end.y) flush_run(page, stroke, &length, run);
    }
    if (run) flush_run(page, stroke, &length, run);
    free(run);
}
