/* The legend of a picture, and the marks and titles on which pictures agree. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

static const double type = 12, sample_width = 26, entry_gap = 18;

/* ------------------------------------------------------------------- legend */

int plot_legend_entries(const bool family[3], unsigned stability, const bool *kinds,
                        plot_legend_entry *out)
{
    static const char *const families[] = {"linear mode", "asymmetric", "symmetric"};
    static const char *const words[] = {
        [RIC_KIND_START] = "start",
        [RIC_KIND_GRAZING] = "grazing",
        [RIC_KIND_CORNER] = "corner",
        [RIC_KIND_EXTREMUM] = "extremum",
        [RIC_KIND_BRANCH_POINT] = "branch point",
        [RIC_KIND_MULTIPLICATION] = "period multiplication",
        [RIC_KIND_PERIOD_EXTREMUM] = "period extremum",
        [RIC_KIND_USER] = "asked for",
    };
    const int sample = family && family[2]   ? PLOT_SYMMETRIC
                       : family && family[1] ? PLOT_ASYMMETRIC
                                             : PLOT_LINEAR;
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
            out[n++] = (plot_legend_entry){words[kind], -1,
                                           (int)plot_junction_mark((ric_kind)kind)};
    return n;
}

/* A piece of a line; proofs are rings, and bands end with their round ends. */
static void draw_sample(plot_page *page, int stroke, double from, double to, double y)
{
    const double middle = (from + to) / 2,
                 end = stroke == PLOT_ISLAND || (stroke >= PLOT_LIT && stroke < PLOT_LIT + 8) ? 5
                                                                                              : 0;
    if (stroke != PLOT_PROOF) {
        plot_page_line(page, (plot_stroke)stroke, 2,
                       (plot_point[]){{from + end, y}, {to - end, y}});
        return;
    }
    for (int ring = 0; ring < 2; ring++)
        plot_page_line(page, PLOT_PROOF + (plot_stroke)ring, 2,
                       (plot_point[]){{middle, y}, {middle + 0.02, y}});
}

static double entry_width(const plot_legend_entry *entry)
{
    return sample_width + 5 + plot_text_width(entry->text, type - 1) + entry_gap;
}

/* The end of the row of entries that begins with `first`: lines and marks have rows of their own.
 * *width: of the row. */
static int end_of_row(int n, const plot_legend_entry *entries, int first, double room,
                      double *width)
{
    int next = first;
    for (*width = -entry_gap; next < n; next++) {
        const double wider = *width + entry_width(&entries[next]);
        if (next > first &&
            (wider > room || (entries[next].mark >= 0) != (entries[first].mark >= 0)))
            break;
        *width = wider;
    }
    return next;
}

static int count_rows(int n, const plot_legend_entry *entries, double room)
{
    double width;
    int rows = 0;
    for (int first = 0; first < n; rows++) first = end_of_row(n, entries, first, room, &width);
    return rows;
}

/* The least width that makes no more rows: none is left with a single entry that others have room
 * for. */
static double even_width(int n, const plot_legend_entry *entries, double room)
{
    const int rows = count_rows(n, entries, room);
    double least = room;
    while (least > 40 && count_rows(n, entries, least - 4) == rows) least -= 4;
    return least;
}

double plot_legend(plot_page *page, int n, const plot_legend_entry *entries, double left,
                   double right, double top)
{
    const double line = 1.55 * type, room = even_width(n, entries, right - left);
    double height = 0, width;
    for (int first = 0, next; first < n; first = next) {
        next = end_of_row(n, entries, first, room, &width);
        height += line;
        double x = (left + right - width) / 2;
        const double y = top - height + line / 2;
        for (int i = first; page && i < next; i++) {
            if (entries[i].stroke >= 0)
                draw_sample(page, entries[i].stroke, x, x + sample_width, y);
            if (entries[i].mark >= 0)
                plot_page_mark(page, (plot_mark)entries[i].mark,
                               (plot_point){x + sample_width / 2, y}, 4.5);
            plot_page_text(page, (plot_point){x + sample_width + 5, y}, PLOT_LEFT, type - 1,
                           "#222222", false, entries[i].text);
            x += entry_width(&entries[i]);
        }
    }
    return height;
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

plot_stroke plot_branch_family(const ric_model *model, const ric_branch *branch)
{
    return ric_branch_linear(model, branch) ? PLOT_LINEAR
           : branch->symmetric              ? PLOT_SYMMETRIC
                                            : PLOT_ASYMMETRIC;
}

void plot_branch_title(const ric_branch *branch, int k, size_t size, char *out)
{
    char text[400];
    const bool fits = branch->label && !ric_duplicate_label(branch, k, sizeof text, text);
    plot_text_label(fits ? text : branch->label ? branch->label : "", size, out);
}
