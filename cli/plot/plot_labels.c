/* The legend of a picture, and labels that keep clear of all else. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

static const double type = 12;

/* ------------------------------------------------------------------- legend */

int plot_legend_entries(const bool family[3], unsigned stability, const bool *kinds, plot_legend_entry *out)
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
    const int sample = family && family[2] ? PLOT_SYMMETRIC : family && family[1] ? PLOT_ASYMMETRIC : PLOT_LINEAR;
    int n = 0;
    for (int i = 2; family && i >= 0; i--)
        if (family[i]) out[n++] = (plot_legend_entry){families[i], PLOT_LINEAR + 3 * i + RIC_STABLE_YES, -1};
    if (stability & 1u << RIC_STABLE_NO) out[n++] = (plot_legend_entry){"thin: unstable", sample + RIC_STABLE_NO, -1};
    if (stability & 1u << RIC_STABLE_UNDECIDED)
        out[n++] = (plot_legend_entry){"dotted: undecided", sample + RIC_STABLE_UNDECIDED, -1};
    for (int kind = 0; kinds && kind <= RIC_KIND_USER; kind++)
        if (kinds[kind]) out[n++] = (plot_legend_entry){words[kind], -1, (int)plot_junction_mark((ric_kind)kind)};
    return n;
}

/* A piece of a line; proofs are rings, and bands end with their round ends. */
static void draw_sample(plot_page *page, int stroke, double from, double to, double y)
{
    const double middle = (from + to) / 2,
                 end = stroke == PLOT_ISLAND || (stroke >= PLOT_LIT && stroke < PLOT_LIT + 8) ? 5 : 0;
    if (stroke != PLOT_PROOF) {
        plot_page_line(page, (plot_stroke)stroke, 2, (plot_point[]){{from + end, y}, {to - end, y}});
        return;
    }
    for (int ring = 0; ring < 2; ring++)
        plot_page_line(page, PLOT_PROOF + (plot_stroke)ring, 2, (plot_point[]){{middle, y}, {middle + 0.02, y}});
}

double plot_legend(plot_page *page, int n, const plot_legend_entry *entries, double left, double right, double top)
{
    const double sample = 26, gap = 18, line = 1.55 * type;
    double height = 0;
    for (int first = 0, next; first < n; first = next) {
        double width = -gap;
        for (next = first; next < n; next++) { /* lines and marks in rows of their own */
            const double entry = sample + 5 + plot_text_width(entries[next].text, type - 1) + gap;
            if (next > first &&
                (width + entry > right - left || (entries[next].mark >= 0) != (entries[first].mark >= 0)))
                break;
            width += entry;
        }
        height += line;
        double x = (left + right - width) / 2;
        const double y = top - height + line / 2;
        for (int i = first; page && i < next; i++) {
            if (entries[i].stroke >= 0) draw_sample(page, entries[i].stroke, x, x + sample, y);
            if (entries[i].mark >= 0)
                plot_page_mark(page, (plot_mark)entries[i].mark, (plot_point){x + sample / 2, y}, 4.5);
            plot_page_text(page, (plot_point){x + sample + 5, y}, PLOT_LEFT, type - 1, "#222222", false,
                           entries[i].text);
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
    if (s->weight != t->weight) return s->weight < t->weight ? 1 : -1;
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
    return side_of(a.from, a.to, b.from) * side_of(a.from, a.to, b.to) <= 0 &&
           side_of(b.from, b.to, a.from) * side_of(b.from, b.to, a.to) <= 0;
}

/* Pixels of lines that the leader passes over. */
static double leader_ink(plot_page *page, leader_line line)
{
    const double length = hypot(line.to.x - line.from.x, line.to.y - line.from.y);
    double ink = 0;
    for (double s = 0; s < length; s += 1) {
        const double x = line.from.x + (line.to.x - line.from.x) * s / length,
                     y = line.from.y + (line.to.y - line.from.y) * s / length;
        ink += plot_page_ink(page, (plot_box){floor(x), floor(y), floor(x) + 1, floor(y) + 1}) > 0;
    }
    return ink;
}

static leader_line leader_to(const plot_tag *tag, plot_box box)
{
    const plot_point nearest = {fmax(box.left, fmin(box.right, tag->at.x)), fmax(box.bottom, fmin(box.top, tag->at.y))};
    const double dx = nearest.x - tag->at.x, dy = nearest.y - tag->at.y, length = fmax(hypot(dx, dy), 1e-9),
                 start = fmin(tag->clear, length);
    return (leader_line){{tag->at.x + dx / length * start, tag->at.y + dy / length * start}, nearest};
}

/* What of a line lies beyond the first pixels, which belong to the own mark or curve, and marks that share its place.
 */
static leader_line beyond_own(leader_line line, double own)
{
    const double length = hypot(line.from.x - line.to.x, line.from.y - line.to.y),
                 part = fmin(1, own / fmax(length, 1e-9));
    line.from.x += (line.to.x - line.from.x) * part;
    line.from.y += (line.to.y - line.from.y) * part;
    return line;
}

/* Cost of the leader, or infinity where it would meet a label, another mark or a leader. */
static double leader_cost(const placing *p, const plot_tag *tag, leader_line line)
{
    const leader_line rest = beyond_own(line, 2);
    if (!plot_page_free_line(p->page, rest.from, rest.to)) return INFINITY;
    for (int i = 0; i < p->n_leader; i++)
        if (lines_cross(line, p->leaders[i])) return INFINITY;
    return 8 * leader_ink(p->page, rest) + (tag->clear > 0 ? 4 : 8);
}

/* On how many sides of a box lines pass so near that it may seem to belong to them, beyond the first, its own. */
static int crowding(plot_page *page, plot_box box)
{
    const double reach = 7;
    const plot_box strips[] = {{box.left - reach, box.bottom, box.left, box.top},
                               {box.right, box.bottom, box.right + reach, box.top},
                               {box.left, box.bottom - reach, box.right, box.bottom},
                               {box.left, box.top, box.right, box.top + reach}};
    int sides = 0;
    for (int i = 0; i < 4; i++) sides += plot_page_ink(page, strips[i]) > 0;
    return sides > 1 ? sides - 1 : 0;
}

/* Cost of a box for the tag: infinite where it cannot stand. */
static double box_cost(const placing *p, const plot_tag *tag, plot_box box, double gap)
{
    double distance = gap;
    const plot_box wide = {box.left - 2, box.bottom - 1, box.right + 2, box.top + 1};
    if (wide.left < p->bounds.left || wide.right > p->bounds.right || wide.bottom < p->bounds.bottom ||
        wide.top > p->bounds.top)
        return INFINITY;
    if (!plot_page_free_box(p->page, wide) || plot_page_ink(p->page, wide) > 0) return INFINITY;
    for (int i = 0; i < p->n_leader; i++)
        if (crosses_box(p->leaders[i], wide)) return INFINITY;
    distance += 10 * crowding(p->page, wide);
    if (gap < 9) { /* a curve between the label and its own would seem to be the one that is meant */
        const double ink = leader_ink(p->page, beyond_own(leader_to(tag, box), 0.5));
        return ink > 2 ? INFINITY : distance + 6 * ink;
    }
    return tag->leader ? distance + leader_cost(p, tag, leader_to(tag, box)) : INFINITY;
}

static plot_box box_around(plot_point centre, double width, double height)
{
    return (plot_box){centre.x - width / 2, centre.y - height / 2, centre.x + width / 2, centre.y + height / 2};
}

typedef struct {
    double cost; /* infinite: none */
    plot_box box;
    double gap;
    int tag;
} stand;

/* Sixteen directions at growing distances; to the right and above are preferred a little, as on maps. Takes what costs
 * less than `best`, `extra` included. */
static void find_place(const placing *p, const plot_tag *tags, int i, double extra, stand *best)
{
    static const double distances[] = {2, 5, 8, 13, 20, 29, 40, 53, 68, 86, 106, 130};
    const plot_tag *tag = &tags[i];
    const plot_box size = plot_text_box((plot_point){0, 0}, PLOT_LEFT, p->size, false, tag->text);
    const double width = size.right - size.left, height = size.top - size.bottom;
    for (size_t d = 0; d < sizeof distances / sizeof *distances && distances[d] + extra < best->cost; d++)
        for (int k = 0; k < 16; k++) {
            const double angle = acos(-1) / 8 * k, reach = tag->clear + distances[d];
            const plot_point centre = {tag->at.x + cos(angle) * (reach + width / 2),
                                       tag->at.y + sin(angle) * (reach + height / 2)};
            const plot_box box = box_around(centre, width, height);
            const double cost = box_cost(p, tag, box, distances[d]) + 0.6 * (1 - cos(angle - 0.6)) + extra;
            if (cost < best->cost) *best = (stand){cost, box, distances[d], i};
        }
}

/* The best place of a label, or of any of its alternatives, which come after it. */
static stand best_place(const placing *p, int n, const plot_tag *tags, int first)
{
    stand best = {.cost = INFINITY};
    for (int i = first; i < n; i++)
        if (i == first || (tags[first].group > 0 && tags[i].group == tags[first].group))
            find_place(p, tags, i, tags[first].weight - tags[i].weight, &best);
    return best;
}

static bool group_done(int n, const plot_tag *tags, const bool *placed, int group)
{
    for (int i = 0; group > 0 && i < n; i++)
        if (placed[i] && tags[i].group == group) return true;
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
    if (!placed || !p.leaders) goto out;
    if (n > 0) qsort(tags, (size_t)n, sizeof *tags, heavier);
    for (int i = 0; i < n; i++) {
        if (group_done(n, tags, placed, tags[i].group)) continue;
        const stand s = best_place(&p, n, tags, i);
        if (s.cost == INFINITY) continue;
        placed[i] = true;
        plot_page_text(page, (plot_point){s.box.left, (s.box.bottom + s.box.top) / 2}, PLOT_LEFT, size, tags[i].colour,
                       false, tags[i].text);
        if (s.gap >= 9) p.leaders[p.n_leader++] = leader_to(&tags[s.tag], s.box);
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

plot_stroke plot_branch_family(const ric_model *model, const ric_branch *branch)
{
    return ric_branch_linear(model, branch) ? PLOT_LINEAR : branch->symmetric ? PLOT_SYMMETRIC : PLOT_ASYMMETRIC;
}

void plot_branch_title(const ric_branch *branch, int k, size_t size, char *out)
{
    char text[400];
    const bool fits = branch->label && !ric_duplicate_label(branch, k, sizeof text, text);
    plot_text_label(fits ? text : branch->label ? branch->label : "", size, out);
}
