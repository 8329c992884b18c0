/* The page of a picture and its rendering by gnuplot. gnuplot sees nothing but numbers, texts and a script on its standard input: it is started
 * without a shell, never learns a file name, and writes to an anonymous file that becomes the target only after it has succeeded. */
#define _POSIX_C_SOURCE 200809L

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "plot.h"

static const double pi = 3.14159265358979323846;

/* Told apart by lightness as well as by hue, so that they stay apart in grey print: symmetric dark, asymmetric middle, linear light;
 * stable thick, unstable thin, undecided dotted. */
static const struct {
    const char *colour, *title;
    double width;
    double dash[4]; /* on, off, on, off in pixels between round ends; none = solid */
} strokes[PLOT_N_STROKE] = {
    [PLOT_GRID] = {"#dddddd", "grid", 0.6, {0}},
    [PLOT_NATURAL] = {"#808080", "natural frequency", 0.8, {12, 4, 1, 4}},
    [PLOT_LOCKED] = {"#808080", "frequency with a contact locked", 0.8, {5, 4}},
    [PLOT_GHOST] = {"#e3122d", "ghost", 0.7, {0}},
    [PLOT_LINEAR + RIC_STABLE_NO] = {"#b4b4b4", "linear, unstable", 0.9, {0}},
    [PLOT_LINEAR + RIC_STABLE_YES] = {"#b4b4b4", "linear, stable", 2.8, {0}},
    [PLOT_LINEAR + RIC_STABLE_UNDECIDED] = {"#b4b4b4", "linear, stability undecided", 2.2, {0.1, 4.4}},
    [PLOT_ASYMMETRIC + RIC_STABLE_NO] = {"#d0701c", "asymmetric, unstable", 0.9, {0}},
    [PLOT_ASYMMETRIC + RIC_STABLE_YES] = {"#d0701c", "asymmetric, stable", 2.8, {0}},
    [PLOT_ASYMMETRIC + RIC_STABLE_UNDECIDED] = {"#d0701c", "asymmetric, stability undecided", 2.2, {0.1, 4.4}},
    [PLOT_SYMMETRIC + RIC_STABLE_NO] = {"#16325c", "symmetric, unstable", 0.9, {0}},
    [PLOT_SYMMETRIC + RIC_STABLE_YES] = {"#16325c", "symmetric, stable", 2.8, {0}},
    [PLOT_SYMMETRIC + RIC_STABLE_UNDECIDED] = {"#16325c", "symmetric, stability undecided", 2.2, {0.1, 4.4}},
    [PLOT_DUPLICATE] = {"#b4b4b4", "duplicate, linear", 0.9, {6, 3.5}},
    [PLOT_DUPLICATE + 1] = {"#d0701c", "duplicate, asymmetric", 0.9, {6, 3.5}},
    [PLOT_DUPLICATE + 2] = {"#16325c", "duplicate, symmetric", 0.9, {6, 3.5}},
    [PLOT_ATLAS_DUPLICATE] = {"#16325c", "duplicate, atlas 1", 0.9, {6, 3.5}},
    [PLOT_ATLAS_DUPLICATE + 1] = {"#c2301f", "duplicate, atlas 2", 0.9, {6, 3.5}},
    [PLOT_ATLAS_DUPLICATE + 2] = {"#2a8a57", "duplicate, atlas 3", 0.9, {6, 3.5}},
    [PLOT_ATLAS_DUPLICATE + 3] = {"#b07a00", "duplicate, atlas 4", 0.9, {6, 3.5}},
    [PLOT_ATLAS_DUPLICATE + 4] = {"#8a4aa8", "duplicate, atlas 5", 0.9, {6, 3.5}},
    [PLOT_ATLAS_DUPLICATE + 5] = {"#3a9ac0", "duplicate, atlas 6", 0.9, {6, 3.5}},
    [PLOT_ATLAS] = {"#16325c", "atlas 1, unstable", 0.9, {0}},
    [PLOT_ATLAS + 1] = {"#16325c", "atlas 1, stable", 2.8, {0}},
    [PLOT_ATLAS + 2] = {"#16325c", "atlas 1, stability undecided", 2.2, {0.1, 4.4}},
    [PLOT_ATLAS + 3] = {"#c2301f", "atlas 2, unstable", 0.9, {0}},
    [PLOT_ATLAS + 4] = {"#c2301f", "atlas 2, stable", 2.8, {0}},
    [PLOT_ATLAS + 5] = {"#c2301f", "atlas 2, stability undecided", 2.2, {0.1, 4.4}},
    [PLOT_ATLAS + 6] = {"#2a8a57", "atlas 3, unstable", 0.9, {0}},
    [PLOT_ATLAS + 7] = {"#2a8a57", "atlas 3, stable", 2.8, {0}},
    [PLOT_ATLAS + 8] = {"#2a8a57", "atlas 3, stability undecided", 2.2, {0.1, 4.4}},
    [PLOT_ATLAS + 9] = {"#b07a00", "atlas 4, unstable", 0.9, {0}},
    [PLOT_ATLAS + 10] = {"#b07a00", "atlas 4, stable", 2.8, {0}},
    [PLOT_ATLAS + 11] = {"#b07a00", "atlas 4, stability undecided", 2.2, {0.1, 4.4}},
    [PLOT_ATLAS + 12] = {"#8a4aa8", "atlas 5, unstable", 0.9, {0}},
    [PLOT_ATLAS + 13] = {"#8a4aa8", "atlas 5, stable", 2.8, {0}},
    [PLOT_ATLAS + 14] = {"#8a4aa8", "atlas 5, stability undecided", 2.2, {0.1, 4.4}},
    [PLOT_ATLAS + 15] = {"#3a9ac0", "atlas 6, unstable", 0.9, {0}},
    [PLOT_ATLAS + 16] = {"#3a9ac0", "atlas 6, stable", 2.8, {0}},
    [PLOT_ATLAS + 17] = {"#3a9ac0", "atlas 6, stability undecided", 2.2, {0.1, 4.4}},
    [PLOT_ZOOM] = {"#2a8a57", "window of a zoom", 0.9, {4, 3}},
    [PLOT_SHEET] = {"#3a5f94", "sheet", 0.8, {0}},
    [PLOT_SHEET + 1] = {"#16325c", "edge of a sheet", 1.7, {0}},
    [PLOT_JUMP] = {"#8c8c8c", "jump of the velocity", 0.9, {2.5, 3}},
    [PLOT_STOP] = {"#555555", "stop", 1.1, {12, 4}},
    [PLOT_SERIES] = {"#16325c", "first", 1.7, {0}},
    [PLOT_SERIES + 1] = {"#d0701c", "second", 1.7, {7, 4}},
    [PLOT_SERIES + 2] = {"#2a8a57", "third", 1.7, {9, 4, 1, 4}},
    [PLOT_SERIES + 3] = {"#a04a8c", "fourth", 2, {0.1, 4}},
    [PLOT_FRAME] = {"#222222", "axes", 0.9, {0}},
    [PLOT_LEADER] = {"#777777", "leaders", 0.6, {0}},
};

struct plot_page {
    double width, height;
    struct {
        FILE *file;
        char *text;
        size_t size;
    } lines[PLOT_N_STROKE], objects, texts;
    int n_label;
    plot_box *boxes; /* texts and marks */
    int n_box, room;
    unsigned char *ink; /* [rows * columns], pixels under lines */
    unsigned *sums;     /* [(rows + 1) * (columns + 1)] running sums of ink, made when asked for; NULL = stale */
    int columns, rows;
    bool failed;
};

const char *plot_stroke_colour(plot_stroke stroke)
{
    return strokes[stroke].colour;
}

double plot_page_width(const plot_page *page) { return page->width; }
double plot_page_height(const plot_page *page) { return page->height; }

plot_page *plot_page_create(double width, double height)
{
    plot_page *page = calloc(1, sizeof *page);
    if (!page)
        return NULL;
    page->width = width;
    page->height = height;
    page->columns = (int)ceil(width);
    page->rows = (int)ceil(height);
    page->ink = calloc((size_t)page->columns * (size_t)page->rows, 1);
    bool good = page->ink;
    for (int i = 0; i < PLOT_N_STROKE; i++)
        good &= (page->lines[i].file = open_memstream(&page->lines[i].text, &page->lines[i].size)) != NULL;
    good &= (page->objects.file = open_memstream(&page->objects.text, &page->objects.size)) != NULL;
    good &= (page->texts.file = open_memstream(&page->texts.text, &page->texts.size)) != NULL;
    if (good)
        return page;
    plot_page_free(page);
    return NULL;
}

void plot_page_free(plot_page *page)
{
    if (!page)
        return;
    for (int i = 0; i < PLOT_N_STROKE; i++) {
        if (page->lines[i].file)
            fclose(page->lines[i].file);
        free(page->lines[i].text);
    }
    if (page->objects.file)
        fclose(page->objects.file);
    if (page->texts.file)
        fclose(page->texts.file);
    free(page->objects.text);
    free(page->texts.text);
    free(page->boxes);
    free(page->ink);
    free(page->sums);
    free(page);
}

/* --------------------------------------------------------------------- text */

static size_t utf8_length(const char *text)
{
    const unsigned char *u = (const unsigned char *)text;
    const size_t n = u[0] < 0x80 ? 1 : u[0] >= 0xc2 && u[0] < 0xe0 ? 2 : u[0] >= 0xe0 && u[0] < 0xf0 ? 3 : u[0] >= 0xf0 && u[0] < 0xf5 ? 4 : 0;
    for (size_t i = 1; i < n; i++)
        if ((u[i] & 0xc0) != 0x80)
            return 0;
    return n;
}

void plot_text_escape(const char *text, size_t size, char *out)
{
    size_t used = 0;
    while (*text) {
        const size_t n = utf8_length(text);
        if (used + (n ? n : 1) + 2 > size)
            break;
        if (n == 0 || (n == 1 && ((unsigned char)*text < 0x20 || *text == 0x7f))) {
            out[used++] = n ? ' ' : '?';
            text++;
            continue;
        }
        if (n == 1 && strchr("_^{}&~@\\", *text))
            out[used++] = '\\';
        for (size_t i = 0; i < n; i++)
            out[used++] = *text++;
    }
    out[used] = '\0';
}

/* [01010101] as [01]^4, [00001111] as [0^4 1^4]; short words as they are. */
static void word_text(const char *word, size_t n, size_t size, char *out)
{
    size_t part = 1;
    while (part < n && (n % part || memcmp(word, word + part, n - part)))
        part++;
    if (n / part >= 3 && part <= 8) {
        snprintf(out, size, "[%.*s]^{%zu}", (int)part, word, n / part);
        return;
    }
    if (n <= 8) {
        snprintf(out, size, "[%.*s]", (int)n, word);
        return;
    }
    size_t used = (size_t)snprintf(out, size, "[");
    for (size_t i = 0, run; i < n && used + 16 < size; i += run) {
        for (run = 1; i + run < n && word[i + run] == word[i]; run++) {}
        if (run < 3)
            used += (size_t)snprintf(out + used, size - used, "%.*s", (int)run, word + i);
        else
            used += (size_t)snprintf(out + used, size - used, "%c^{%zu}", word[i], run);
    }
    snprintf(out + used, size - used, "]");
}

/* Points of power-law structures have letters for numbers in the article: Ca_33, Ca8_33. */
static bool lettered(const char *label, size_t size, char *out)
{
    if ((*label != 'C' && *label != 'G') || !islower((unsigned char)label[1]))
        return false;
    const size_t n = 1 + strspn(label + 2, "0123456789");
    const char *low = label + 1 + n;
    if (*low != '_' || !low[1] || strspn(low + 1, "0123456789,") != strlen(low + 1))
        return false;
    snprintf(out, size, "%c@^{%.*s}_{%s}", *label, (int)n, label + 1, low + 1);
    return true;
}

void plot_text_label(const char *label, size_t size, char *out)
{
    if (lettered(label, size, out))
        return;
    const char *c = label, *low = NULL;
    while (isalpha((unsigned char)*c))
        c++;
    const char *digits = c;
    while (isdigit((unsigned char)*c) || (*c == ',' && c > digits))
        c++;
    const char *end = c;
    const char *sign = *c == '+' || *c == '-' ? c++ : NULL;
    int power = 0; /* S2^{3-}[01]: the sign stands behind the number of repeats */
    if (!sign && *c == '^' && sscanf(c, "^{%9d", &power) == 1) {
        c += 2 + strspn(c + 2, "0123456789");
        sign = *c == '+' || *c == '-' ? c++ : NULL;
        c += *c == '}';
    } else if (!sign && *c == '_') {
        low = ++c;
        while (isalnum((unsigned char)*c) || *c == ',')
            c++;
    }
    const char *low_end = c, *word = NULL;
    if (*c == '[' && strspn(c + 1, "0123456789abcdefghijklmnopqrstuvwxyz") + 1 == strcspn(c, "]") && c[strcspn(c, "]")] && !c[strcspn(c, "]") + 1]) {
        word = c;
        c += strlen(c);
    }
    if (digits == label || digits - label > 2 || (end == digits && !sign) || *c || strlen(label) > size / 2) {
        plot_text_escape(label, size, out);
        return;
    }
    const int letters = (int)(digits - label), n = (int)(end - digits);
    int used;
    if (low)
        used = snprintf(out, size, "%.*s@^{%.*s}_{%.*s}", letters, label, n, digits, (int)(low_end - low), low);
    else if (sign || power) {
        char times[12] = "";
        if (power)
            snprintf(times, sizeof times, "%d", power);
        const char *raised = !sign ? "" : *sign == '-' ? "\xe2\x88\x92" : "+";
        if (n > 0)
            used = snprintf(out, size, "%.*s@^{%s%s}_{%.*s}", letters, label, times, raised, n, digits);
        else
            used = snprintf(out, size, "%.*s^{%s%s}", letters, label, times, raised);
    }
    else
        used = snprintf(out, size, "%.*s_{%.*s}", letters, label, n, digits);
    if (word && used > 0 && (size_t)used < size)
        word_text(word + 1, strlen(word) - 2, size - (size_t)used, out + used);
}

/* Advance widths of Helvetica in thousandths of an em (Adobe font metrics), for ASCII from the space on. */
static const short helvetica[95] = {
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556, 556, 556, 556,
    556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278, 556,
    556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
};

static double glyph_width(unsigned char c)
{
    return c >= 32 && c < 127 ? helvetica[c - 32] / 1000. : 0.65;
}

static double item_width(const char **text);

static double group_width(const char **text)
{
    double width = 0;
    while (**text && **text != '}')
        width += item_width(text);
    if (**text)
        ++*text;
    return width;
}

static double item_width(const char **text)
{
    const unsigned char c = (unsigned char)*(*text)++;
    if (c == '{')
        return group_width(text);
    if (c == '^' || c == '_')
        return **text ? 0.8 * item_width(text) : 0;
    if (c == '@') { /* the next two stand one above the other */
        const double first = **text ? item_width(text) : 0;
        return fmax(first, **text ? item_width(text) : 0);
    }
    if (c == '\\')
        return **text ? glyph_width((unsigned char)*(*text)++) : 0;
    if (c < 0x80)
        return glyph_width(c);
    const bool minus = !strncmp(*text - 1, "\xe2\x88\x92", 3);
    while (((unsigned char)**text & 0xc0) == 0x80)
        ++*text;
    return minus ? 0.584 : 0.77; /* Greek capitals are about the widest */
}

static double exact_width(const char *text, const char *end, double size)
{
    double width = 0;
    while (text < end && *text)
        width += *text == '}' ? (text++, 0.) : item_width(&text);
    return size * width;
}

double plot_text_width(const char *text, double size)
{
    return 1.12 * exact_width(text, text + strlen(text), size); /* substitutes for Helvetica run up to an eighth wider */
}

plot_box plot_text_box(plot_point at, plot_anchor anchor, double size, bool upright, const char *text)
{
    const double width = plot_text_width(text, size), half = (strpbrk(text, "_^") ? 0.82 : 0.62) * size;
    const double start = anchor == PLOT_LEFT ? 0 : anchor == PLOT_CENTRE ? -width / 2 : -width;
    if (upright)
        return (plot_box){at.x - half, at.y + start, at.x + half, at.y + start + width};
    return (plot_box){at.x + start, at.y - half, at.x + start + width, at.y + half};
}

/* ------------------------------------------------------------------ drawing */

static void stain(plot_page *page, plot_point a, plot_point b)
{
    const double length = hypot(b.x - a.x, b.y - a.y);
    const int n = 1 + (int)fmin(length, 1e5);
    for (int i = 0; i <= n; i++) {
        const int column = (int)floor(a.x + (b.x - a.x) * i / n), row = (int)floor(a.y + (b.y - a.y) * i / n);
        if (column >= 0 && column < page->columns && row >= 0 && row < page->rows)
            page->ink[(size_t)row * (size_t)page->columns + (size_t)column] = 1;
    }
}

void plot_page_line(plot_page *page, plot_stroke stroke, int n, const plot_point *points)
{
    FILE *file = page->lines[stroke].file;
    for (int i = 0; i < n; i++) {
        fprintf(file, "%.2f %.2f\n", points[i].x, points[i].y);
        if (i > 0)
            stain(page, points[i - 1], points[i]);
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
    static const struct { int n; double turn, size; } regular[PLOT_N_MARK] = {
        [PLOT_SQUARE] = {4, 0.125, 1.2}, [PLOT_TRIANGLE] = {3, 0.25, 1.25}, [PLOT_TRIANGLE_DOWN] = {3, 0.75, 1.25},
        [PLOT_DIAMOND] = {4, 0, 1.3}, [PLOT_STAR] = {10, 0.25, 1.45}, [PLOT_CROSS] = {12, 0.125, 1},
    };
    const int n = regular[mark].n ? regular[mark].n : ROUND; /* gnuplot's own circles have a hundred corners */
    for (int i = 0; i < n; i++) {
        double radius = regular[mark].n ? regular[mark].size : mark == PLOT_DOT ? 0.8 : 1;
        if (mark == PLOT_STAR && i % 2)
            radius *= 0.45;
        const double angle = 2 * pi * (regular[mark].turn + (double)i / n);
        out[i] = (plot_point){radius * cos(angle), radius * sin(angle)};
    }
    if (mark == PLOT_CROSS) {
        static const signed char plus[12][2] = {{1, 3}, {1, 1}, {3, 1}, {3, -1}, {1, -1}, {1, -3}, {-1, -3}, {-1, -1}, {-3, -1},
                                                {-3, 1}, {-1, 1}, {-1, 3}};
        for (int i = 0; i < n; i++)
            out[i] = (plot_point){plus[i][0] * 0.4, plus[i][1] * 0.4};
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
        fprintf(file, "%s%.2f,%.2f", i ? " to " : "", at.x + radius * shape[i % n].x, at.y + radius * shape[i % n].y);
    fprintf(file, " front fs solid 1 border rgb '#222222' fc rgb '%s' lw 1\n", fill);
}

static void put_label(plot_page *page, plot_point at, const char *anchor, double size, const char *colour, bool upright, const char *text, size_t n)
{
    FILE *file = page->texts.file;
    fprintf(file, "set label %d '", ++page->n_label);
    for (size_t i = 0; i < n; i++) {
        if (text[i] == '\'')
            fputc('\'', file);
        fputc(text[i] == '\n' ? ' ' : text[i], file);
    }
    /* FONT(..) is a function of the script: the terminals measure type in different units. */
    fprintf(file, "' at %.2f,%.2f %s front %s font FONT(%.2f) tc rgb '%s'\n", at.x, at.y, anchor, upright ? "rotate by 90" : "norotate", size, colour);
}

/* gnuplot sets raised over lowered text too tight, and not at all alike in SVG; so the pieces of such a text are placed one by one. */
static void put_pieces(plot_page *page, plot_point at, double size, const char *colour, const char *text)
{
    while (*text) {
        const char *end = text;
        while (*end && *end != '@')
            end += *end == '\\' && end[1] ? 2 : 1;
        put_label(page, at, "left", size, colour, false, text, (size_t)(end - text));
        at.x += exact_width(text, end, size);
        if (!*end)
            return;
        double widest = 0;
        for (text = end + 1; *text == '^' || *text == '_'; text = end) {
            const double small = 0.74 * size, shift = *text == '^' ? 0.44 * size : -0.44 * size;
            end = text + 1;
            const char *inner = end + (*end == '{');
            end += *end == '{' ? strcspn(end, "}") : 1;
            put_label(page, (plot_point){at.x + 0.5, at.y + shift}, "left", small, colour, false, inner, (size_t)(end - inner));
            widest = fmax(widest, exact_width(inner, end, small));
            end += *end == '}';
        }
        at.x += widest + 1;
    }
}

void plot_page_text(plot_page *page, plot_point at, plot_anchor anchor, double size, const char *colour, bool upright, const char *text)
{
    static const char *const words[] = {"left", "center", "right"};
    remember(page, plot_text_box(at, anchor, size, upright, text));
    if (!upright && strchr(text, '@')) {
        const double width = exact_width(text, text + strlen(text), size);
        put_pieces(page, (plot_point){at.x - (anchor == PLOT_LEFT ? 0 : anchor == PLOT_CENTRE ? width / 2 : width), at.y}, size, colour, text);
        return;
    }
    put_label(page, at, words[anchor], size, colour, upright, text, strlen(text));
}

bool plot_page_free_box(const plot_page *page, plot_box box)
{
    for (int i = 0; i < page->n_box; i++) {
        const plot_box *b = &page->boxes[i];
        if (box.left < b->right && b->left < box.right && box.bottom < b->top && b->bottom < box.top)
            return false;
    }
    return true;
}

bool plot_page_free_line(const plot_page *page, plot_point from, plot_point to)
{
    for (int i = 0; i < page->n_box; i++) {
        plot_point a = from, b = to;
        if (plot_clip_segment(&page->boxes[i], &a, &b))
            return false;
    }
    return true;
}

static bool sum_ink(plot_page *page)
{
    const size_t columns = (size_t)page->columns, rows = (size_t)page->rows, stride = columns + 1;
    page->sums = calloc((rows + 1) * stride, sizeof *page->sums);
    if (!page->sums)
        return false;
    for (size_t row = 0; row < rows; row++)
        for (size_t column = 0, line = 0; column < columns; column++) {
            line += page->ink[row * columns + column];
            page->sums[(row + 1) * stride + column + 1] = page->sums[row * stride + column + 1] + (unsigned)line;
        }
    return true;
}

static size_t pixel(double value, int limit)
{
    return value < 0 ? 0 : value > limit ? (size_t)limit : (size_t)value;
}

double plot_page_ink(plot_page *page, plot_box box)
{
    if (!page->sums && !sum_ink(page))
        return 0;
    const size_t stride = (size_t)page->columns + 1;
    const size_t left = pixel(floor(box.left), page->columns), right = pixel(ceil(box.right), page->columns);
    const size_t bottom = pixel(floor(box.bottom), page->rows), top = pixel(ceil(box.top), page->rows);
    const unsigned *s = page->sums;
    return (double)(s[top * stride + right] - s[bottom * stride + right] - s[top * stride + left] + s[bottom * stride + left]);
}

/* ---------------------------------------------------------------- rendering */

typedef enum { FORMAT_NONE, FORMAT_SVG, FORMAT_PDF, FORMAT_PNG } format;

static format format_of(const char *path)
{
    const char *name = strrchr(path, '/'), *dot = strrchr(name ? name : path, '.');
    if (dot && dot != path && dot[-1] != '/') {
        if (!strcasecmp(dot, ".svg"))
            return FORMAT_SVG;
        if (!strcasecmp(dot, ".pdf"))
            return FORMAT_PDF;
        if (!strcasecmp(dot, ".png"))
            return FORMAT_PNG;
    }
    return FORMAT_NONE;
}

int plot_check_target(const char *path)
{
    struct stat info;
    if (format_of(path) == FORMAT_NONE)
        return cli_wrong("-o %s: the ending says what to draw: .svg, .pdf or .png", path);
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return cli_wrong("-o %s: this is a folder; give a file name", path);
    return CLI_DONE;
}

/* The terminals measure type, line widths and dashes in units of their own; the factors to pixels were measured with gnuplot 5.4. */
static void write_terminal(FILE *script, const plot_page *page, format kind)
{
    const double w = page->width, h = page->height;
    double type = 1;
    switch (kind) {
    case FORMAT_SVG:
        fprintf(script, "set terminal svg size %.0f,%.0f enhanced rounded background '#ffffff' font 'Helvetica,12'\n", w, h);
        break;
    case FORMAT_PDF:
        type = 0.5625;
        fprintf(script, "set terminal pdfcairo size %.4fin,%.4fin enhanced rounded fontscale 1 linewidth 1.5 font 'Helvetica,9'\n", w / 96, h / 96);
        break;
    default:
        type = 0.75;
        fprintf(script, "set terminal pngcairo size %.0f,%.0f enhanced rounded font 'Helvetica,9'\n", w, h);
    }
    fprintf(script, "FONT(s) = sprintf('Helvetica,%%.2f', %g * s)\n", type);
}

static void write_stroke(FILE *script, format kind, int stroke)
{
    const double *dash = strokes[stroke].dash, width = strokes[stroke].width;
    const double unit = kind == FORMAT_SVG ? 0.5 * width : kind == FORMAT_PNG ? 0.25 * fmax(1, width) : 0.3667 * fmax(1, 0.75 * width);
    fprintf(script, ", \\\n $l%d with lines lw %g lc rgb '%s' dt ", stroke, width, strokes[stroke].colour);
    for (int i = 0; i < 4 && dash[i] > 0; i++)
        fprintf(script, "%c%.3f", i ? ',' : '(', dash[i] / unit);
    fprintf(script, "%s title '%s'", dash[0] > 0 ? ")" : "solid", strokes[stroke].title);
}

static bool write_script(plot_page *page, format kind, FILE *script)
{
    bool good = !page->failed;
    for (int i = 0; i < PLOT_N_STROKE; i++)
        good &= fflush(page->lines[i].file) == 0;
    good &= fflush(page->objects.file) == 0 && fflush(page->texts.file) == 0;
    if (!good)
        return false;
    fputs("set encoding utf8\n", script);
    write_terminal(script, page, kind);
    fputs("unset key\nunset border\nunset tics\n"
          "set lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen 0\nset tmargin at screen 1\n", script);
    fprintf(script, "set xrange [0:%g]\nset yrange [0:%g]\n", page->width, page->height);
    for (int i = 0; i < PLOT_N_STROKE; i++)
        if (page->lines[i].size)
            fprintf(script, "$l%d << EOD\n%sEOD\n", i, page->lines[i].text);
    fputs(page->objects.text, script);
    fputs(page->texts.text, script);
    fputs("plot -1 lw 0 notitle", script); /* so that there is always a first */
    for (int i = 0; i < PLOT_N_STROKE; i++)
        if (page->lines[i].size)
            write_stroke(script, kind, i);
    fputc('\n', script);
    return fflush(script) == 0 && !ferror(script);
}

/* Starts gnuplot on the three files. Returns 0 and its exit status, or the errno that kept it from starting. */
static int run_gnuplot(FILE *script, FILE *result, FILE *complaint, int *status)
{
    int trouble[2], failed = 0; /* closed by a successful exec, else it carries errno */
    if (pipe(trouble) != 0)
        return errno;
    fcntl(trouble[1], F_SETFD, FD_CLOEXEC);
    const pid_t child = fork();
    if (child == 0) {
        static char name[] = "gnuplot", plain[] = "-d"; /* -d: no start-up file of the user */
        char *const arguments[] = {name, plain, NULL};
        dup2(fileno(script), STDIN_FILENO);
        dup2(fileno(result), STDOUT_FILENO);
        dup2(fileno(complaint), STDERR_FILENO);
        execvp(arguments[0], arguments);
        failed = errno;
        if (write(trouble[1], &failed, sizeof failed) < 0)
            _exit(126);
        _exit(127);
    }
    if (child < 0)
        failed = errno;
    close(trouble[1]);
    if (child > 0) {
        if (read(trouble[0], &failed, sizeof failed) != sizeof failed)
            failed = 0;
        while (waitpid(child, status, 0) < 0 && errno == EINTR) {}
    }
    close(trouble[0]);
    return failed;
}

/* Prints the last line that gnuplot complained with. */
static int report_complaint(FILE *complaint, int status)
{
    char line[512], last[512] = "no message";
    rewind(complaint);
    while (fgets(line, sizeof line, complaint))
        if (strspn(line, " \t\r\n^") != strlen(line))
            snprintf(last, sizeof last, "%s", line + strspn(line, " \t"));
    last[strcspn(last, "\n")] = '\0';
    if (WIFSIGNALED(status))
        fprintf(stderr, "ricochet: gnuplot was ended by signal %d\n", WTERMSIG(status));
    else
        fprintf(stderr, "ricochet: gnuplot could not draw the picture: %s; version 5.0 or later with cairo is needed (Debian: gnuplot-nox)\n", last);
    return CLI_FAILED;
}

static bool looks_like(FILE *file, format kind)
{
    char head[8] = "";
    rewind(file);
    const size_t n = fread(head, 1, sizeof head, file);
    rewind(file);
    return n == sizeof head && (kind == FORMAT_PNG ? !memcmp(head, "\x89PNG", 4) : kind == FORMAT_PDF ? !memcmp(head, "%PDF", 4) : head[0] == '<');
}

static bool copy_file(FILE *from, int to)
{
    char block[65536];
    size_t n;
    while ((n = fread(block, 1, sizeof block, from)) > 0)
        for (size_t done = 0; done < n;) {
            const ssize_t written = write(to, block + done, n - done);
            if (written < 0 && errno != EINTR)
                return false;
            done += written > 0 ? (size_t)written : 0;
        }
    return !ferror(from);
}

/* Puts the result in place by way of a file beside it, so that a half-written picture is never seen. */
static int deliver(FILE *result, const char *path)
{
    const size_t length = strlen(path);
    char *beside = malloc(length + 8);
    int code = CLI_FAILED, file = -1;
    if (!beside)
        return cli_report(RIC_E_NOMEM);
    memcpy(beside, path, length);
    memcpy(beside + length, ".XXXXXX", 8);
    file = mkstemp(beside);
    if (file < 0) {
        fprintf(stderr, "ricochet: cannot write %s: %s\n", path, strerror(errno));
        goto out;
    }
    const mode_t mask = umask(0);
    umask(mask);
    bool good = copy_file(result, file) && fchmod(file, 0666 & ~mask) == 0;
    good &= close(file) == 0;
    if (!good || rename(beside, path) != 0) {
        fprintf(stderr, "ricochet: cannot write %s: %s\n", path, strerror(errno));
        unlink(beside);
        goto out;
    }
    code = CLI_DONE;
out:
    free(beside);
    return code;
}

int plot_page_write(plot_page *page, const char *path)
{
    const format kind = format_of(path);
    FILE *script = tmpfile(), *result = tmpfile(), *complaint = tmpfile(), *small = NULL;
    int code = CLI_FAILED, status = 0;
    if (!script || !result || !complaint) {
        fprintf(stderr, "ricochet: no temporary file for the picture: %s\n", strerror(errno));
        goto out;
    }
    if (!write_script(page, kind, script) || fseek(script, 0, SEEK_SET) != 0) {
        fprintf(stderr, "ricochet: the picture could not be prepared: %s\n", page->failed ? "out of memory" : strerror(errno));
        goto out;
    }
    const int failed = run_gnuplot(script, result, complaint, &status);
    if (failed == ENOENT) {
        fprintf(stderr, "ricochet: gnuplot is not installed; pictures need it (Debian: apt-get install gnuplot-nox)\n");
        goto out;
    }
    if (failed) {
        fprintf(stderr, "ricochet: gnuplot cannot be started: %s\n", strerror(failed));
        goto out;
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || !looks_like(result, kind)) {
        code = report_complaint(complaint, status);
        goto out;
    }
    if (kind == FORMAT_SVG && !(small = tmpfile())) {
        fprintf(stderr, "ricochet: no temporary file for the picture: %s\n", strerror(errno));
        goto out;
    }
    if (small && (!plot_svg_squeeze(result, small) || fseek(small, 0, SEEK_SET) != 0)) {
        fprintf(stderr, "ricochet: the picture could not be written: %s\n", strerror(errno));
        goto out;
    }
    code = deliver(small ? small : result, path);
out:
    if (small)
        fclose(small);
    if (script)
        fclose(script);
    if (result)
        fclose(result);
    if (complaint)
        fclose(complaint);
    return code;
}
