/* Texts in gnuplot's enhanced notation: names as the article sets them, and how wide they are. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
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

/* [0-121], in which a letter may be more than one character: as it is, with a true minus sign. */
static void plain_word(const char *word, size_t n, size_t size, char *out)
{
    size_t used = (size_t)snprintf(out, size, "[");
    for (size_t i = 0; i < n && used + 8 < size; i++)
        used += (size_t)snprintf(out + used, size - used, word[i] == '-' ? "\xe2\x88\x92" : "%c",
                                 word[i]);
    snprintf(out + used, size - used, "]");
}

/* [01010101] as [01]^4, [00001111] as [0^4 1^4]; short words as they are. */
static void word_text(const char *word, size_t n, size_t size, char *out)
{
    size_t part = 1;
    if (memchr(word, '-', n) || memchr(word, '.', n)) {
        plain_word(word, n, size, out);
        return;
    }
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

/* A name in its pieces: S2^{3-}[01] has letters S, digits 2, power 3, mark - and word 01; in C1_32?
 * low is 32?. */
typedef struct {
    const char *text;
    int n;
} piece;
typedef struct {
    piece letters, digits, power, mark, low, word;
} name_parts;

static piece take(const char **c, size_t n)
{
    const piece out = {*c, (int)n};
    *c += n;
    return out;
}

/* + or -, or the number of a mode in brackets. */
static size_t mark_length(const char *c)
{
    if (*c == '+' || *c == '-') return 1;
    const size_t n = *c == '(' ? strspn(c + 1, "0123456789") : 0;
    return n && c[1 + n] == ')' ? n + 2 : 0;
}

static bool take_word(const char **c, piece *out)
{
    const size_t n = **c == '[' ? strspn(*c + 1, "0123456789abcdefghijklmnopqrstuvwxyz-.") : 0;
    if (**c != '[' || (*c)[n + 1] != ']') return **c != '[';
    *out = (piece){*c + 1, (int)n};
    *c += n + 2;
    return true;
}

static bool take_name(const char *c, name_parts *p)
{
    *p = (name_parts){0};
    p->letters = take(&c, strcspn(c, "0123456789+-^_([,? "));
    for (int i = 0; i < p->letters.n; i++)
        if (!isalpha((unsigned char)p->letters.text[i])) return false;
    p->digits = take(&c, strspn(c, "0123456789,"));
    if (p->letters.n < 1 || p->letters.n > 2 || (p->digits.n && *p->digits.text == ','))
        return false;
    if (*c == '^') { /* the mark stands behind the number of repeats */
        if (c[1] != '{') return false;
        c += 2;
        p->power = take(&c, strspn(c, "0123456789"));
        p->mark = take(&c, mark_length(c));
        if (p->power.n < 1 || *c++ != '}') return false;
    } else if (*c == '_') {
        size_t n = 1;
        while (isalnum((unsigned char)c[n]) || c[n] == ',') n++;
        if (n > 1) n += strspn(c + n, "?"); /* not decided, or not measured */
        c++;
        p->low = take(&c, n - 1);
    } else if (*c == '?' && p->digits.n) {
        p->digits.n += (int)strspn(c, "?"); /* a kind of points without a number: C21? */
        c += strspn(c, "?");
    } else {
        p->mark = take(&c, mark_length(c));
    }
    return take_word(&c, &p->word) && !*c && (p->digits.n || p->mark.n);
}

static void set_name(const char *label, size_t size, char *out)
{
    name_parts p;
    char whole[2000], *const place = out;
    const size_t given = size;
    if (lettered(label, size, out)) return;
    if (!take_name(label, &p) || strlen(label) > sizeof whole / 4) {
        plot_text_escape(label, size, out);
        return;
    }
    out = whole; /* long words become short ones, and a text that is cut is none */
    size = sizeof whole;
    int used = snprintf(out, size, "%.*s", p.letters.n, p.letters.text);
    char *rest = out + used;
    const size_t room = size - (size_t)used;
    if (p.low.n)
        used += snprintf(rest, room, "@^{%.*s}_{%.*s}", p.digits.n, p.digits.text, p.low.n,
                         p.low.text);
    else if (p.mark.n || p.power.n) {
        char raised[64];
        const bool minus = p.mark.n == 1 && *p.mark.text == '-';
        snprintf(raised, sizeof raised, "%.*s%.*s", p.power.n, p.power.text, minus ? 3 : p.mark.n,
                 minus      ? "\xe2\x88\x92"
                 : p.mark.n ? p.mark.text
                            : "");
        if (p.digits.n)
            used += snprintf(rest, room, "@^{%s}_{%.*s}", raised, p.digits.n, p.digits.text);
        else used += snprintf(rest, room, "^{%s}", raised);
    } else {
        used += snprintf(rest, room, "_{%.*s}", p.digits.n, p.digits.text);
    }
    if (p.word.text && (size_t)used < size)
        word_text(p.word.text, (size_t)p.word.n, size - (size_t)used, out + used);
    if (strlen(whole) < given) snprintf(place, given, "%s", whole);
    else plot_text_escape(label, given, place);
}

/* A name may be of several words: S6 minimum. */
void plot_text_label(const char *label, size_t size, char *out)
{
    char word[400];
    for (size_t used = 0; used < size;) {
        const size_t n = strcspn(label, " ");
        if (n >= sizeof word) {
            plot_text_escape(label, size - used, out + used);
            return;
        }
        memcpy(word, label, n);
        word[n] = '\0';
        set_name(word, size - used, out + used);
        used += strlen(out + used);
        label += n;
        if (!*label || used + 1 >= size) return;
        out[used++] = *label++;
        out[used] = '\0';
    }
}

void plot_text_number(double value, int digits, size_t size, char *out)
{
    char plain[48];
    snprintf(plain, sizeof plain, "%.*g", digits, value);
    const char *mark = strchr(plain, 'e');
    const int n = mark ? (int)(mark - plain) : 0, power = mark ? atoi(mark + 1) : 0;
    const bool one = n == 1 && *plain == '1';
    if (!mark) snprintf(out, size, "%s", plain);
    else
        snprintf(out, size, "%.*s%s10^{%s%d}", one ? 0 : n, plain, one ? "" : "\xc2\xb7",
                 power < 0 ? "\xe2\x88\x92" : "", abs(power));
}

/* Advance widths of Helvetica in thousandths of an em (Adobe font metrics), for ASCII from the
 * space on. */
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

plot_box plot_text_box(plot_point at, plot_anchor anchor, double size, bool upright,
                       const char *text)
{
    const double width = plot_text_width(text, size),
                 half = (strpbrk(text, "_^") ? 0.82 : 0.62) * size;
    const double start = anchor == PLOT_LEFT ? 0 : anchor == PLOT_CENTRE ? -width / 2 : -width;
    if (upright) return (plot_box){at.x - half, at.y + start, at.x + half, at.y + start + width};
    return (plot_box){at.x + start, at.y - half, at.x + start + width, at.y + half};
}
