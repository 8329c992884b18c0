/* The page of a picture: lines, marks and texts in pixels, and the script that has gnuplot draw
 * them. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/buffer.h"
#include "plot.h"

/* Colours of branches: linear modes, asymmetric and symmetric branches, and one of several atlases.
 * Any two of either group stay apart for a reader without one kind of cones, and by lightness alone
 * in grey print (tests/cli). */
static const struct {
    const char *colour, *name;
    const char *text; /* of a label: dark enough for thin letters */
} branches[PLOT_N_BRANCH] = {
    {"#a8a8a8", "linear", "#5e5e5e"},    {"#d0701c", "asymmetric", "#a85410"},
    {"#16325c", "symmetric", "#16325c"}, {"#16325c", "atlas 1", "#16325c"},
    {"#ff6f00", "atlas 2", "#b34e00"},   {"#6915b6", "atlas 3", "#6915b6"},
    {"#51d18a", "atlas 4", "#1d7846"},   {"#9c4e30", "atlas 5", "#8a4026"},
    {"#757aba", "atlas 6", "#4b50a0"},
};

typedef struct {
    const char *colour, *title;
    double width;
    double dash[4]; /* on, off, on, off in pixels between round ends; none = solid */
} stroke_style;

/* Stable thick, unstable thin, undecided dotted; by stability, once solid and once dashed. */
static const stroke_style by_stability[2][3] = {
    {[RIC_STABLE_NO] = {NULL, "unstable", 0.8, {0}},
     [RIC_STABLE_YES] = {NULL, "stable", 2.4, {0}},
     [RIC_STABLE_UNDECIDED] = {NULL, "stability undecided", 2.2, {0.1, 4.4}}},
    {[RIC_STABLE_NO] = {NULL, "unstable, duplicate", 0.8, {6, 3.5}},
     [RIC_STABLE_YES] = {NULL, "stable, duplicate", 2.4, {6, 5.5}},
     [RIC_STABLE_UNDECIDED] = {NULL, "stability undecided, duplicate", 1.8, {6, 4, 0.1, 4}}},
};

static const stroke_style strokes[PLOT_N_STROKE] = {
    [PLOT_GRID] = {"#dddddd", "grid", 0.6, {0}},
    [PLOT_NATURAL] = {"#808080", "natural frequency", 0.8, {12, 4, 1, 4}},
    [PLOT_LOCKED] = {"#808080", "frequency with a contact locked", 0.8, {5, 4}},
    [PLOT_ISLAND] = {"#dccff0", "island", 9, {0}},
    [PLOT_LIT] = {"#ffe08a", "kept up", 9, {0}},
    [PLOT_LIT + 1] = {"#ffb84d", "kept up, second level", 9, {0}},
    [PLOT_LIT + 2] = {"#f0803c", "kept up, third level", 9, {0}},
    [PLOT_LIT + 3] = {"#d6493a", "kept up, fourth level", 9, {0}},
    [PLOT_LIT + 4] = {"#ffe08a", "kept up, not trusted", 6, {0}},
    [PLOT_LIT + 5] = {"#ffb84d", "kept up, second level, not trusted", 6, {0}},
    [PLOT_LIT + 6] = {"#f0803c", "kept up, third level, not trusted", 6, {0}},
    [PLOT_LIT + 7] = {"#d6493a", "kept up, fourth level, not trusted", 6, {0}},
    [PLOT_GHOST] = {"#e3122d", "ghost", 1, {0}},
    [PLOT_GHOST + 1] = {"#e3122d", "ghost of a duplicate", 1, {6, 3.5}},
    [PLOT_SHADE] = {"#b0b0b0", "without a shade", 1.5, {0}},
    [PLOT_SHADE + 1] = {"#0d0887", "shade 1", 1.5, {0}},
    [PLOT_SHADE + 2] = {"#2a0693", "shade 2", 1.5, {0}},
    [PLOT_SHADE + 3] = {"#46039f", "shade 3", 1.5, {0}},
    [PLOT_SHADE + 4] = {"#5c02a4", "shade 4", 1.5, {0}},
    [PLOT_SHADE + 5] = {"#7201a8", "shade 5", 1.5, {0}},
    [PLOT_SHADE + 6] = {"#870ca3", "shade 6", 1.5, {0}},
    [PLOT_SHADE + 7] = {"#9c179e", "shade 7", 1.5, {0}},
    [PLOT_SHADE + 8] = {"#ad2792", "shade 8", 1.5, {0}},
    [PLOT_SHADE + 9] = {"#bd3786", "shade 9", 1.5, {0}},
    [PLOT_SHADE + 10] = {"#cb4779", "shade 10", 1.5, {0}},
    [PLOT_SHADE + 11] = {"#d8576b", "shade 11", 1.5, {0}},
    [PLOT_SHADE + 12] = {"#e3685f", "shade 12", 1.5, {0}},
    [PLOT_SHADE + 13] = {"#ed7953", "shade 13", 1.5, {0}},
    [PLOT_SHADE + 14] = {"#f48c47", "shade 14", 1.5, {0}},
    [PLOT_SHADE + 15] = {"#fb9f3a", "shade 15", 1.5, {0}},
    [PLOT_ZOOM] = {"#444444", "window of a zoom", 0.9, {4, 3}},
    [PLOT_SHEET] = {"#3a5f94", "sheet", 0.8, {0}},
    [PLOT_SHEET + 1] = {"#16325c", "edge of a sheet", 1.7, {0}},
    [PLOT_JUMP] = {"#8c8c8c", "jump of the velocity", 0.9, {2.5, 3}},
    [PLOT_STOP] = {"#555555", "stop", 1.1, {12, 4}},
    [PLOT_STOP + 1] = {"#16325c", "stop of the first", 1.1, {12, 4}},
    [PLOT_STOP + 2] = {"#d0701c", "stop of the second", 1.1, {12, 4}},
    [PLOT_STOP + 3] = {"#6915b6", "stop of the third", 1.1, {12, 4}},
    [PLOT_STOP + 4] = {"#51d18a", "stop of the fourth", 1.1, {12, 4}},
    [PLOT_SERIES] = {"#16325c", "first", 1.7, {0}},
    [PLOT_SERIES + 1] = {"#d0701c", "second", 1.7, {7, 4}},
    [PLOT_SERIES + 2] = {"#6915b6", "third", 1.7, {9, 4, 1, 4}},
    [PLOT_SERIES + 3] = {"#51d18a", "fourth", 2, {0.1, 4}},
    [PLOT_PORTRAIT] = {"#16325c", "portrait of the first", 1.2, {0}},
    [PLOT_PORTRAIT + 1] = {"#d0701c", "portrait of the second", 1.2, {0}},
    [PLOT_PORTRAIT + 2] = {"#6915b6", "portrait of the third", 1.2, {0}},
    [PLOT_PORTRAIT + 3] = {"#51d18a", "portrait of the fourth", 1.2, {0}},
    [PLOT_SHADOW] = {"#b0b0b0", "shadow", 1, {0}},
    [PLOT_GAP] = {"#777777", "gap", 1.2, {0}},
    [PLOT_OVERLAY] = {"#16325c", "first of several", 1.7, {0}},
    [PLOT_OVERLAY + 1] = {"#ff6f00", "second of several", 1.7, {7, 4}},
    [PLOT_OVERLAY + 2] = {"#6915b6", "third of several", 1.7, {9, 4, 1, 4}},
    [PLOT_OVERLAY + 3] = {"#51d18a", "fourth of several", 2, {0.1, 4}},
    [PLOT_OVERLAY + 4] = {"#9c4e30", "fifth of several", 1.7, {14, 5}},
    [PLOT_OVERLAY + 5] = {"#757aba", "sixth of several", 1.7, {4, 3}},
    [PLOT_BEAM] = {"#9aa4b4", "member", 3, {0}},
    [PLOT_PART] = {"#222222", "part", 1.4, {0}},
    [PLOT_PROOF] = {"#222222", "proved", 4.2, {0}},
    [PLOT_PROOF + 1] = {"#ffffff", "proved, inside", 2.4, {0}},
    [PLOT_ARROW] = {"#e3122d", "inherited", 0.9, {0}},
    [PLOT_DATA] = {"#c2188b", "data", 5, {0.1, 8}},
    [PLOT_DATA + 1] = {"#16325c", "data of the first", 4.5, {0.1, 8}},
    [PLOT_DATA + 2] = {"#d0701c", "data of the second", 4.5, {0.1, 8}},
    [PLOT_DATA + 3] = {"#6915b6", "data of the third", 4.5, {0.1, 8}},
    [PLOT_DATA + 4] = {"#51d18a", "data of the fourth", 4.5, {0.1, 8}},
    [PLOT_FRAME] = {"#222222", "axes", 0.9, {0}},
    [PLOT_LEADER] = {"#777777", "leaders", 0.6, {0}},
};

const char *plot_text_colour(plot_stroke branch)
{
    return branches[((int)branch - PLOT_LINEAR) / 3].text;
}

static stroke_style style_of(plot_stroke stroke, char title[64])
{
    const int i = (int)stroke - PLOT_DUPLICATE;
    if (i < 0 || i >= 6 * PLOT_N_BRANCH) return strokes[stroke];
    const int branch = i / 3 % PLOT_N_BRANCH;
    stroke_style out = by_stability[i < 3 * PLOT_N_BRANCH][i % 3];
    snprintf(title, 64, "%s, %s", branches[branch].name, out.title);
    out.colour = branches[branch].colour;
    out.title = title;
    return out;
}

struct plot_page {
    double width, height;
    ric_buffer lines[PLOT_N_STROKE], objects, texts;
    int n_label;
    plot_box *boxes; /* texts and marks */
    int n_box, room;
    unsigned char *ink; /* [rows * columns], what colour is under lines; 0: none */
    unsigned *sums; /* [(rows + 1) * (columns + 1)] running sums of ink, made when asked for; NULL =
                       stale */
    int columns, rows;
    bool failed;
};

const char *plot_stroke_colour(plot_stroke stroke)
{
    char title[64];
    return style_of(stroke, title).colour;
}

double plot_page_width(const plot_page *page)
{
    return page->width;
}
double plot_page_height(const plot_page *page)
{
    return page->height;
}

plot_page *plot_page_create(double width, double height)
{
    plot_page *page = calloc(1, sizeof *page);
    if (!page) return NULL;
    page->width = width;
    page->height = height;
    page->columns = (int)ceil(width);
    page->rows = (int)ceil(height);
    page->ink = calloc((size_t)page->columns * (size_t)page->rows, 1);
    bool good = page->ink;
    for (int i = 0; i < PLOT_N_STROKE; i++) good &= ric_buffer_open(&page->lines[i]);
    good &= ric_buffer_open(&page->objects) && ric_buffer_open(&page->texts);
    if (good) return page;
    plot_page_free(page);
    return NULL;
}

void plot_page_free(plot_page *page)
{
    if (!page) return;
    for (int i = 0; i < PLOT_N_STROKE; i++) ric_buffer_free(&page->lines[i]);
    ric_buffer_free(&page->objects);
    ric_buffer_free(&page->texts);
    free(page->boxes);
    free(page->ink);
    free(page->sums);
    free(page);
}

/* ------------------------------------------------------------------ drawing */

/* Branches in their colours, all else in one. */
static unsigned char tint_of(plot_stroke stroke)
{
    const int i = (int)stroke - PLOT_DUPLICATE;
    return i < 0 || i >= 6 * PLOT_N_BRANCH ? 1 : (unsigned char)(2 + i / 3 % PLOT_N_BRANCH);
}

static void stain(plot_page *page, unsigned char tint, plot_point a, plot_point b)
{
    const double length = hypot(b.x - a.x, b.y - a.y);
    const int n = 1 + (int)fmin(length, 1e5);
    for (int i = 0; i <= n; i++) {
        const int column = (int)floor(a.x + (b.x - a.x) * i / n),
                  row = (int)floor(a.y + (b.y - a.y) * i / n);
        if (column >= 0 && column < page->columns && row >= 0 && row < page->rows)
            page->ink[(size_t)row * (size_t)page->columns + (size_t)column] = tint;
    }
}

void plot_page_line(plot_page *page, plot_stroke stroke, int n, const plot_point *points)
{
    FILE *file = page->lines[stroke].file;
    for (int i = 0; i < n; i++) {
        fprintf(file, "%.2f %.2f\n", points[i].x, points[i].y);
        if (i > 0) stain(page, tint_of(stroke), points[i - 1], points[i]);
    }
    fputc('\n', file); /* an empty line lifts the pen */
    free(page->sums);
    page->sums = NULL;
}

static void remember(plot_page *page, plot_box box)
{
    if (page->n_box == page->room) {
        const int room = page->room ? 2 * page->room : 256;
        plot_box *boxes = realloc(page->boxes, (size_t)room * sizeof *boxes);
        if (!boxes) {
            page->failed = true;
            return;
        }
        page->boxes = boxes;
        page->room = room;
    }
    page->boxes[page->n_box++] = box;
}

enum { ROUND = 20, CORNERS = 20 };

/* Corners of a mark around the origin, of radius about 1; returns how many. */
static int mark_shape(plot_mark mark, plot_point *out)
{
    static const struct {
        int n;
        double turn, size;
    } regular[PLOT_N_MARK] = {
        [PLOT_SQUARE] = {4, 0.125, 1.2},        [PLOT_TRIANGLE] = {3, 0.25, 1.25},
        [PLOT_TRIANGLE_DOWN] = {3, 0.75, 1.25}, [PLOT_DIAMOND] = {4, 0, 1.3},
        [PLOT_STAR] = {10, 0.25, 1.45},         [PLOT_CROSS] = {12, 0.125, 1},
    };
    const int n = regular[mark].n ? regular[mark].n
                                  : ROUND; /* gnuplot's own circles have a hundred corners */
    for (int i = 0; i < n; i++) {
        double radius = regular[mark].n ? regular[mark].size : mark == PLOT_DOT ? 0.8 : 1;
        if (mark == PLOT_STAR && i % 2) radius *= 0.45;
        const double angle = 2 * CLI_PI * (regular[mark].turn + (double)i / n);
        out[i] = (plot_point){radius * cos(angle), radius * sin(angle)};
    }
    if (mark == PLOT_CROSS) {
        static const signed char plus[12][2] = {{1, 3},   {1, 1},  {3, 1},   {3, -1},
                                                {1, -1},  {1, -3}, {-1, -3}, {-1, -1},
                                                {-3, -1}, {-3, 1}, {-1, 1},  {-1, 3}};
        for (int i = 0; i < n; i++) out[i] = (plot_point){plus[i][0] * 0.4, plus[i][1] * 0.4};
    }
    return n;
}

void plot_page_mark(plot_page *page, plot_mark mark, plot_point at, double radius)
{
    FILE *file = page->objects.file;
    plot_point shape[CORNERS];
    const int n = mark_shape(mark, shape);
    const char *fill = mark == PLOT_DOT ? "#222222" : "#ffffff";
    remember(page, (plot_box){at.x - radius, at.y - radius, at.x + radius, at.y + radius});
    fputs("set object polygon from ", file);
    for (int i = 0; i <= n; i++)
        fprintf(file, "%s%.2f,%.2f", i ? " to " : "", at.x + radius * shape[i % n].x,
                at.y + radius * shape[i % n].y);
    fprintf(file, " front fs solid 1 border rgb '#222222' fc rgb '%s' lw LINE\n", fill);
}

static void put_label(plot_page *page, plot_point at, const char *anchor, double size,
                      const char *colour, bool upright, const char *text, size_t n)
{
    FILE *file = page->texts.file;
    fprintf(file, "set label %d '", ++page->n_label);
    /* gnuplot takes a doubled quote for one quote, but not where a text begins with it: it is added
     * as a text of its own. Within double quotes it would look for commands. */
    for (size_t i = 0; i < n; i++) {
        if (text[i] == '\'') fputs("'.\"'\".'", file);
        else fputc((unsigned char)text[i] < ' ' || text[i] == 0x7f ? ' ' : text[i], file);
    }
    /* FONT(..) is a function of the script: the terminals measure type in different units. */
    fprintf(file, "' at %.2f,%.2f %s front %s font FONT(%.2f) tc rgb '%s'\n", at.x, at.y, anchor,
            upright ? "rotate by 90" : "norotate", size, colour);
}

/* gnuplot sets raised over lowered text too tight, and not at all alike in SVG; so the pieces of
 * such a text are placed one by one. */
static void put_pieces(plot_page *page, plot_point at, double size, const char *colour,
                       const char *text)
{
    while (*text) {
        const char *end = text;
        while (*end && *end != '@') end += *end == '\\' && end[1] ? 2 : 1;
        put_label(page, at, "left", size, colour, false, text, (size_t)(end - text));
        at.x += plot_text_exact_width(text, end, size);
        if (!*end) return;
        double widest = 0;
        for (text = end + 1; *text == '^' || *text == '_'; text = end) {
            const double small = 0.74 * size, shift = *text == '^' ? 0.44 * size : -0.44 * size;
            end = text + 1;
            const char *inner = end + (*end == '{');
            end += *end == '{' ? strcspn(end, "}") : 1;
            put_label(page, (plot_point){at.x + 0.5, at.y + shift}, "left", small, colour, false,
                      inner, (size_t)(end - inner));
            widest = fmax(widest, plot_text_exact_width(inner, end, small));
            end += *end == '}';
        }
        at.x += widest + 1;
    }
}

void plot_page_text(plot_page *page, plot_point at, plot_anchor anchor, double size,
                    const char *colour, bool upright, const char *text)
{
    static const char *const words[] = {"left", "center", "right"};
    remember(page, plot_text_box(at, anchor, size, upright, text));
    if (!upright && strchr(text, '@')) {
        const double width = plot_text_exact_width(text, text + strlen(text), size);
        put_pieces(page,
                   (plot_point){at.x - (anchor == PLOT_LEFT     ? 0
                                        : anchor == PLOT_CENTRE ? width / 2
                                                                : width),
                                at.y},
                   size, colour, text);
        return;
    }
    put_label(page, at, words[anchor], size, colour, upright, text, strlen(text));
}

bool plot_page_free_box(const plot_page *page, plot_box box)
{
    for (int i = 0; i < page->n_box; i++) {
        const plot_box *b = &page->boxes[i];
        if (box.left < b->right && b->left < box.right && box.bottom < b->top &&
            b->bottom < box.top)
            return false;
    }
    return true;
}

bool plot_page_free_line(const plot_page *page, plot_point from, plot_point to)
{
    for (int i = 0; i < page->n_box; i++) {
        plot_point a = from, b = to;
        if (plot_clip_segment(&page->boxes[i], &a, &b)) return false;
    }
    return true;
}

static bool sum_ink(plot_page *page)
{
    const size_t columns = (size_t)page->columns, rows = (size_t)page->rows, stride = columns + 1;
    page->sums = calloc((rows + 1) * stride, sizeof *page->sums);
    if (!page->sums) return false;
    for (size_t row = 0; row < rows; row++)
        for (size_t column = 0, line = 0; column < columns; column++) {
            line += page->ink[row * columns + column] != 0;
            page->sums[(row + 1) * stride + column + 1] = page->sums[row * stride + column + 1] +
                                                          (unsigned)line;
        }
    return true;
}

static size_t pixel(double value, int limit)
{
    return value < 0 ? 0 : value > limit ? (size_t)limit : (size_t)value;
}

double plot_page_ink(plot_page *page, plot_box box)
{
    if (!page->sums && !sum_ink(page)) return 0;
    const size_t stride = (size_t)page->columns + 1;
    const size_t left = pixel(floor(box.left), page->columns),
                 right = pixel(ceil(box.right), page->columns);
    const size_t bottom = pixel(floor(box.bottom), page->rows),
                 top = pixel(ceil(box.top), page->rows);
    const unsigned *s = page->sums;
    return (double)(s[top * stride + right] - s[bottom * stride + right] - s[top * stride + left] +
                    s[bottom * stride + left]);
}

bool plot_page_other(const plot_page *page, plot_point at, plot_stroke own)
{
    if (!(at.x >= 0 && at.y >= 0 && at.x < page->columns && at.y < page->rows)) return false;
    const unsigned char tint = page->ink[(size_t)at.y * (size_t)page->columns + (size_t)at.x];
    return tint && tint != tint_of(own);
}

/* ------------------------------------------------------------------- script */

bool plot_page_failed(const plot_page *page)
{
    return page->failed;
}

void plot_page_fail(plot_page *page)
{
    page->failed = true;
}

static const double usual_font = 9, usual_dpi = 96; /* points, and pixels per inch */

static double magnification(const plot_options *o)
{
    return o->font > 0 ? o->font / usual_font : 1;
}

double plot_layout_width(const plot_options *o, double usual)
{
    return (o->width > 0 ? o->width : usual) / magnification(o);
}

double plot_layout_height(const plot_options *o, double usual)
{
    return (o->height > 0 ? o->height : usual) / magnification(o);
}

static const double title_type = 14;

void plot_page_title(plot_page *page, const plot_options *common, const char *own)
{
    char title[400];
    if (!common->title && !own) return;
    if (common->title) plot_text_escape(common->title, sizeof title, title);
    else snprintf(title, sizeof title, "%s", own);
    plot_page_text(page, (plot_point){page->width / 2, page->height - 17}, PLOT_CENTRE, title_type,
                   "#000000", false, title);
}

double plot_page_head(const plot_options *common, const char *own)
{
    return common->title || own ? 34 : 10;
}

/* A picture in the making: `scale` is how many pixels of the target, of 1/96 inch in PDF, a pixel
 * of the page has. */
typedef struct {
    FILE *script;
    plot_format kind;
    double scale;
} target;

/* The terminals measure type, line widths and dashes in units of their own; the factors to pixels
 * were measured with gnuplot 5.4. */
static void write_terminal(const target *t, const plot_page *page)
{
    const double w = page->width * t->scale, h = page->height * t->scale;
    double type = t->scale;
    switch (t->kind) {
    case PLOT_FORMAT_PDF:
        type *= 0.5625;
        fprintf(t->script,
                "set terminal pdfcairo size %.4fin,%.4fin enhanced rounded fontscale 1 linewidth "
                "1.5 font "
                "'Helvetica,9'\n",
                w / 96, h / 96);
        break;
    case PLOT_FORMAT_PNG:
        type *= 0.75;
        fprintf(t->script,
                "set terminal pngcairo size %.0f,%.0f enhanced rounded font 'Helvetica,9'\n", w, h);
        break;
    default:
        fprintf(t->script,
                "set terminal svg size %.0f,%.0f enhanced rounded background '#ffffff' font "
                "'Helvetica,12'\n",
                w, h);
    }
    fprintf(t->script, "FONT(s) = sprintf('Helvetica,%%.2f', %g * s)\n", type);
}

static void write_stroke(const target *t, int stroke)
{
    char title[64];
    const stroke_style style = style_of((plot_stroke)stroke, title);
    const double *dash = style.dash, width = style.width * t->scale;
    const double unit = t->kind == PLOT_FORMAT_PDF   ? 0.3667 * fmax(1, 0.75 * width)
                        : t->kind == PLOT_FORMAT_PNG ? 0.25 * fmax(1, width)
                                                     : 0.5 * width;
    fprintf(t->script, ", \\\n $l%d with lines lw %g lc rgb '%s' dt ", stroke, width, style.colour);
    for (int i = 0; i < 4 && dash[i] > 0; i++)
        fprintf(t->script, "%c%.3f", i ? ',' : '(', dash[i] * t->scale / unit);
    fprintf(t->script, "%s title '%s'", dash[0] > 0 ? ")" : "solid", style.title);
}

bool plot_page_script(plot_page *page, plot_format kind, const plot_options *options, FILE *script)
{
    const double dots = kind == PLOT_FORMAT_PNG && options->dpi > 0 ? options->dpi / usual_dpi : 1;
    const target t = {script, kind, magnification(options) * dots};
    bool good = !page->failed;
    for (int i = 0; i < PLOT_N_STROKE; i++) good &= ric_buffer_sync(&page->lines[i]);
    good &= ric_buffer_sync(&page->objects) && ric_buffer_sync(&page->texts);
    if (!good) return false;
    if (kind == PLOT_FORMAT_GNUPLOT)
        fputs("# A picture of ricochet for gnuplot: gnuplot FILE.gp > picture.svg\n"
              "# All is drawn in pixels of the page; styles stand in the last command, the data of "
              "each in a block.\n",
              script);
    fputs("set encoding utf8\n", script);
    fprintf(script, "LINE = %g\n", t.scale); /* marks are written before their width is known */
    write_terminal(&t, page);
    fputs("unset key\nunset border\nunset tics\n"
          "set lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen 0\nset tmargin "
          "at screen 1\n",
          script);
    fprintf(script, "set xrange [0:%.10g]\nset yrange [0:%.10g]\n", page->width, page->height);
    for (int i = 0; i < PLOT_N_STROKE; i++)
        if (page->lines[i].size) fprintf(script, "$l%d << EOD\n%sEOD\n", i, page->lines[i].text);
    fputs(page->objects.text, script);
    fputs(page->texts.text, script);
    fputs("plot -1 lw 0 notitle", script); /* so that there is always a first */
    for (int i = 0; i < PLOT_N_STROKE; i++)
        if (page->lines[i].size) write_stroke(&t, i);
    fputc('\n', script);
    return fflush(script) == 0 && !ferror(script);
}
