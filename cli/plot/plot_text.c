/* Texts in gnuplot's enhanced notation: names as the article sets them, and how wide they are. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plot.h"

static size_t utf8_length(const char *text)
{
    const unsigned char *u = (const unsigned char *)text;
    const size_t n = u[0] < 0x80                   ? 1
                     : u[0] >= 0xc2 && u[0] < 0xe0 ? 2
                     : u[0] >= 0xe0 && u[0] < 0xf0 ? 3
                     : u[0] >= 0xf0 && u[0] < 0xf5 ? 4
                                                   : 0;
    for (size_t i = 1; i < n; i++)
        if ((u[i] & 0xc0) != 0x80) return 0;
    return n;
}

void plot_text_escape(const char *text, size_t size, char *out)
{
    size_t used = 0;
    while (*text) {
        const size_t n = utf8_length(text);
        if (used + (n ? n : 1) + 2 > size) break;
        if (n == 0 || (n == 1 && ((unsigned char)*text < 0x20 || *text == 0x7f))) {
            out[used++] = n ? ' ' : '?';
            text++;
            continue;
        }
        if (n == 1 && strchr("_^{}&~@\\", *text)) out[used++] = '\\';
        for (size_t i = 0; i < n; i++) out[used++] = *text++;
    }
    out[used] = '\0';
}

/* [01010101] as [01]^4, [00001111] as [0^4 1^4]; short words as they are. */
static void word_text(const char *word, size_t n, size_t size, char *out)
{
    size_t part = 1;
    while (part < n && (n % part || memcmp(word, word + part, n - part))) part++;
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
        for (run = 1; i + run < n && word[i + run] == word[i]; run++) {
        }
        if (run < 3) used += (size_t)snprintf(out + used, size - used, "%.*s", (int)run, word + i);
        else used += (size_t)snprintf(out + used, size - used, "%c^{%zu}", word[i], run);
    }
    snprintf(out + used, size - used, "]");
}

/* Points of power-law structures have letters for numbers in the article: Ca_33, Ca8_33. */
static bool lettered(const char *label, size_t size, char *out)
{
    if ((*label != 'C' && *label != 'G') || !islower((unsigned char)label[1])) return false;
    const size_t n = 1 + strspn(label + 2, "0123456789");
    const char *low = label + 1 + n;
    if (*low != '_' || !low[1] || strspn(low + 1, "0123456789,") != strlen(low + 1)) return false;
    snprintf(out, size, "%c@^{%.*s}_{%s}", *label, (int)n, label + 1, low + 1);
    return true;
}

void plot_text_label(const char *label, size_t size, char *out)
{
    if (lettered(label, size, out)) return;
    const char *c = label, *low = NULL;
    while (isalpha((unsigned char)*c)) c++;
    const char *digits = c;
    while (isdigit((unsigned char)*c) || (*c == ',' && c > digits)) c++;
    const char *end = c;
    const char *sign = *c == '+' || *c == '-' ? c++ : NULL;
    int power = 0; /* S2^{3-}[01]: the sign stands behind the number of repeats */
    if (!sign && *c == '^' && sscanf(c, "^{%9d", &power) == 1) {
        c += 2 + strspn(c + 2, "0123456789");
        sign = *c == '+' || *c == '-' ? c++ : NULL;
        c += *c == '}';
    } else if (!sign && *c == '_') {
        low = ++c;
        while (isalnum((unsigned char)*c) || *c == ',') c++;
        while (*c == '?' && c > low) c++; /* not decided, or not measured */
    }
    const char *low_end = c, *word = NULL;
    if (*c == '[' && strspn(c + 1, "0123456789abcdefghijklmnopqrstuvwxyz") + 1 == strcspn(c, "]") &&
        c[strcspn(c, "]")] && !c[strcspn(c, "]") + 1]) {
        word = c;
        c += strlen(c);
    }
    if (digits == label || digits - label > 2 || (end == digits && !sign) || *c || strlen(label) > size / 2) {
        plot_text_escape(label, size, out);
        return;
    }
    const int letters = (int)(digits - label), n = (int)(end - digits);
    int used;
    if (low) used = snprintf(out, size, "%.*s@^{%.*s}_{%.*s}", letters, label, n, digits, (int)(low_end - low), low);
    else if (sign || power) {
        char times[12] = "";
        if (power) snprintf(times, sizeof times, "%d", power);
        const char *raised = !sign ? "" : *sign == '-' ? "\xe2\x88\x92" : "+";
        if (n > 0) used = snprintf(out, size, "%.*s@^{%s%s}_{%.*s}", letters, label, times, raised, n, digits);
        else used = snprintf(out, size, "%.*s^{%s%s}", letters, label, times, raised);
    } else used = snprintf(out, size, "%.*s_{%.*s}", letters, label, n, digits);
    if (word && used > 0 && (size_t)used < size) word_text(word + 1, strlen(word) - 2, size - (size_t)used, out + used);
}

/* Advance widths of Helvetica in thousandths of an em (Adobe font metrics), for ASCII from the space on. */
static const short helvetica[95] = {
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333,  278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
    611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667,  611, 722, 667, 944, 667,
    667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278,  556, 556, 222, 222, 500,
    222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500,  500, 334, 260, 334, 584,
};

static double glyph_width(unsigned char c)
{
    return c >= 32 && c < 127 ? helvetica[c - 32] / 1000. : 0.65;
}

static double item_width(const char **text);

static double group_width(const char **text)
{
    double width = 0;
    while (**text && **text != '}') width += item_width(text);
    if (**text) ++*text;
    return width;
}

static double item_width(const char **text)
{
    const unsigned char c = (unsigned char)*(*text)++;
    if (c == '{') return group_width(text);
    if (c == '^' || c == '_') return **text ? 0.8 * item_width(text) : 0;
    if (c == '@') { /* the next two stand one above the other */
        const double first = **text ? item_width(text) : 0;
        return fmax(first, **text ? item_width(text) : 0);
    }
    if (c == '\\') return **text ? glyph_width((unsigned char)*(*text)++) : 0;
    if (c < 0x80) return glyph_width(c);
    const bool minus = !strncmp(*text - 1, "\xe2\x88\x92", 3);
    while (((unsigned char)**text & 0xc0) == 0x80) ++*text;
    return minus ? 0.584 : 0.77; /* Greek capitals are about the widest */
}

double plot_text_exact_width(const char *text, const char *end, double size)
{
    double width = 0;
    while (text < end && *text) width += *text == '}' ? (text++, 0.) : item_width(&text);
    return size * width;
}

double plot_text_width(const char *text, double size)
{
    /* substitutes for Helvetica run up to an eighth wider */
    return 1.12 * plot_text_exact_width(text, text + strlen(text), size);
}

plot_box plot_text_box(plot_point at, plot_anchor anchor, double size, bool upright, const char *text)
{
    const double width = plot_text_width(text, size), half = (strpbrk(text, "_^") ? 0.82 : 0.62) * size;
    const double start = anchor == PLOT_LEFT ? 0 : anchor == PLOT_CENTRE ? -width / 2 : -width;
    if (upright) return (plot_box){at.x - half, at.y + start, at.x + half, at.y + start + width};
    return (plot_box){at.x + start, at.y - half, at.x + start + width, at.y + half};
}
