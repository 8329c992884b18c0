/* Labels that keep clear of all else. They are placed one after the other, the weightiest first;
 * then each that stands badly is placed once more, and those beside it make way for it where that
 * is better for both. */
#include <math.h>
#include <stdlib.h>

#include "plot.h"

enum { ROUNDS = 3, WAYS = 16 };
static const double distances[] = {2, 5, 8, 13, 20, 29, 40, 53, 68, 86, 106, 130}; /* pixels */
enum { PLACES = WAYS * (int)(sizeof distances / sizeof *distances) };
static const double near_by =
    9; /* pixels: from this distance on a label needs a line to its point */
static const double good_enough = 12; /* cost of a place that is not looked for again */
static const double spare_cost =
    30; /* of a label that stands elsewhere, too: it has no worse place */
static const double cost_of_none = 400; /* of a label without a place */
static const double sight = 200;        /* pixels: labels further away do not stand in the way */

typedef struct {
    plot_point from, to;
} leader_line;

typedef struct {
    double cost; /* infinite: none */
    plot_box box;
    leader_line line; /* to it */
    bool led;         /* the line is drawn */
    int tag;
} stand;

typedef struct {
    plot_page *page;
    plot_box bounds;
    double size;
    int n;
    const plot_tag *tags;
    int n_label, *first; /* [n_label], the weightiest tag of each label */
    stand *stands;       /* [n_label] */
    double *alone; /* [n * PLACES] cost of a place of a tag without other labels; NaN: not looked at
                      yet */
} placing;

static int heavier(const void *a, const void *b)
{
    const plot_tag *s = a, *t = b;
    if (s->weight != t->weight) return s->weight < t->weight ? 1 : -1;
    /* qsort keeps no order of its own, and the picture must be the same on every machine */
    return s->at.x != t->at.x ? (s->at.x > t->at.x) - (s->at.x < t->at.x)
                              : (s->at.y > t->at.y) - (s->at.y < t->at.y);
}

/* ------------------------------------------------------------------ leaders */

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

static bool inked(plot_page *page, double column, double row)
{
    return plot_page_ink(page, (plot_box){column, row, column + 1, row + 1}) > 0;
}

/* Pixels of lines that the leader passes over. Between two that touch at a corner only there may be
 * a line that passes over the corner, too. */
static double leader_ink(plot_page *page, leader_line line)
{
    const double length = hypot(line.to.x - line.from.x, line.to.y - line.from.y), step = 0.5;
    double ink = 0, last[2] = {floor(line.from.x), floor(line.from.y)};
    for (double s = 0; s < length; s += step) {
        const double x = floor(line.from.x + (line.to.x - line.from.x) * s / length),
                     y = floor(line.from.y + (line.to.y - line.from.y) * s / length);
        const bool corner = x != last[0] && y != last[1];
        if (s > 0 && x == last[0] && y == last[1]) continue;
        ink += inked(page, x, y) || (corner && inked(page, last[0], y) && inked(page, x, last[1]));
        last[0] = x;
        last[1] = y;
    }
    return ink;
}

static plot_point nearest_in(plot_box box, plot_point at)
{
    return (plot_point){fmax(box.left, fmin(box.right, at.x)),
                        fmax(box.bottom, fmin(box.top, at.y))};
}

/* To the nearest piece of the text: its first letter, which is lower than what is raised and
 * lowered behind it, or the rest. */
static leader_line leader_to(const placing *p, const plot_tag *tag, plot_box box)
{
    const double middle = (box.bottom + box.top) / 2, half = 0.5 * p->size,
                 letter = box.left + 0.72 * p->size;
    const plot_box first = {box.left, fmax(box.bottom, middle - half), fmin(letter, box.right),
                            fmin(box.top, middle + half)},
                   rest = {first.right, box.bottom, box.right, box.top};
    const plot_point a = nearest_in(first, tag->at), b = nearest_in(rest, tag->at);
    const double to_a = hypot(a.x - tag->at.x, a.y - tag->at.y),
                 to_b = hypot(b.x - tag->at.x, b.y - tag->at.y);
    const plot_point nearest = to_a <= to_b ? a : b;
    const double dx = nearest.x - tag->at.x, dy = nearest.y - tag->at.y,
                 length = fmax(hypot(dx, dy), 1e-9), start = fmin(tag->clear, length);
    return (leader_line){{tag->at.x + dx / length * start, tag->at.y + dy / length * start},
                         nearest};
}

/* What of a line lies beyond the first pixels, which belong to the own mark or curve, and marks
 * that share its place. */
static leader_line beyond_own(leader_line line, double own)
{
    const double length = hypot(line.from.x - line.to.x, line.from.y - line.to.y),
                 part = fmin(1, own / fmax(length, 1e-9));
    line.from.x += (line.to.x - line.from.x) * part;
    line.from.y += (line.to.y - line.from.y) * part;
    return line;
}

/* Cost of the leader beside what is drawn, or infinity where it would meet a mark. A curve that it
 * crosses is worth a longer way around. */
static double leader_cost(const placing *p, const plot_tag *tag, leader_line line)
{
    const leader_line rest = beyond_own(line, 2);
    if (!plot_page_free_line(p->page, rest.from, rest.to)) return INFINITY;
    return 30 * leader_ink(p->page, rest) + (tag->clear > 0 ? 4 : 8);
}

/* ------------------------------------------------------------------- places */

/* On how many sides of a box lines pass so near that it may seem to belong to them, beyond the
 * first, its own. */
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

/* How many lines leave a small square around a point, beyond the two ends of the one through it,
 * more than any where they run into one another: a line to where curves meet tells none of them. */
static int others_near(plot_page *page, plot_point at)
{
    enum { HALF = 5, SIDE = 2 * HALF, BUNDLE = 6 };
    const double left = floor(at.x) - HALF, bottom = floor(at.y) - HALF;
    bool was = inked(page, left, bottom + 1);
    int ends = 0, pixels = 0;
    for (int i = 0; i < 4 * SIDE; i++) {
        const int side = i / SIDE, k = i % SIDE;
        const double x = left + (side == 0   ? k
                                 : side == 1 ? SIDE
                                 : side == 2 ? SIDE - k
                                             : 0),
                     y = bottom + (side == 0   ? 0
                                   : side == 1 ? k
                                   : side == 2 ? SIDE
                                               : SIDE - k);
        const bool is = inked(page, x, y);
        ends += is && !was;
        pixels += is;
        was = is;
    }
    if (pixels > BUNDLE) return SIDE;
    return ends > 2 ? ends - 2 : 0;
}

static plot_box widened(plot_box box)
{
    return (plot_box){box.left - 2, box.bottom - 1, box.right + 2, box.top + 1};
}

/* Whether the labels that have a place leave a place free, and their leaders, and whether its own
 * leader meets none. */
static bool clear_of_labels(const placing *p, const stand *place)
{
    const plot_box box = widened(place->box);
    const leader_line rest = beyond_own(place->line, 2);
    for (int i = 0; i < p->n_label; i++) {
        const stand *s = &p->stands[i];
        if (s->cost == INFINITY) continue;
        if (box.left < s->box.right && s->box.left < box.right && box.bottom < s->box.top &&
            s->box.bottom < box.top)
            return false;
        if (s->led && crosses_box(s->line, box)) return false;
        if (place->led &&
            (crosses_box(rest, s->box) || (s->led && lines_cross(place->line, s->line))))
            return false;
    }
    return true;
}

/* Whether a curve of another colour lies between a curve and the label beside it. */
static bool other_between(const placing *p, const plot_tag *tag, plot_point to)
{
    const double length = hypot(to.x - tag->at.x, to.y - tag->at.y);
    bool found = false;
    for (double s = 0.5; tag->curve && s < length && !found; s += 0.5)
        found = plot_page_other(p->page,
                                (plot_point){tag->at.x + (to.x - tag->at.x) * s / length,
                                             tag->at.y + (to.y - tag->at.y) * s / length},
                                tag->stroke);
    return found;
}

/* Cost of a box for the tag beside what is drawn: infinite where it cannot stand. */
static double box_cost(const placing *p, const plot_tag *tag, plot_box box, double gap)
{
    const plot_box wide = widened(box);
    if (wide.left < p->bounds.left || wide.right > p->bounds.right ||
        wide.bottom < p->bounds.bottom || wide.top > p->bounds.top)
        return INFINITY;
    if (plot_page_ink(p->page, wide) > 0 || !plot_page_free_box(p->page, wide)) return INFINITY;
    const double distance = gap + 10 * crowding(p->page, wide);
    const int others = tag->curve ? others_near(p->page, tag->at) : 0;
    const leader_line line = leader_to(p, tag, box);
    if (gap >= near_by)
        return tag->leader ? distance + 15 * fmin(others, 4) + leader_cost(p, tag, line) : INFINITY;
    /* a curve or mark between the label and its own would seem to be the one that is meant */
    const leader_line rest = beyond_own(line, 0.5 * tag->clear);
    const double ink = leader_ink(p->page, beyond_own(line, 0.5));
    const bool unclear = tag->curve ? ink > 0 || others > 2 || other_between(p, tag, line.to)
                                    : ink > 2;
    return unclear || !plot_page_free_line(p->page, rest.from, rest.to)
               ? INFINITY
               : distance + 6 * ink + 2 * others;
}

static plot_box box_around(plot_point centre, double width, double height)
{
    return (plot_box){centre.x - width / 2, centre.y - height / 2, centre.x + width / 2,
                      centre.y + height / 2};
}

/* Sixteen directions at growing distances; to the right and above are preferred a little, as on
 * maps. Takes what costs less than `best`, `extra` included. */
static void find_place(const placing *p, int i, double extra, stand *best)
{
    const plot_tag *tag = &p->tags[i];
    const plot_box size = plot_text_box((plot_point){0, 0}, PLOT_LEFT, p->size, false, tag->text);
    const double width = size.right - size.left, height = size.top - size.bottom;
    if (tag->curve && !plot_page_free_box(p->page, box_around(tag->at, 20, 20))) return;
    for (int k = 0; k < PLACES && distances[k / WAYS] + extra < best->cost; k++) {
        const double gap = distances[k / WAYS], angle = 2 * acos(-1) / WAYS * (k % WAYS),
                     reach = tag->clear + gap;
        const plot_point centre = {tag->at.x + cos(angle) * (reach + width / 2),
                                   tag->at.y + sin(angle) * (reach + height / 2)};
        const plot_box box = box_around(centre, width, height);
        double *alone = &p->alone[(size_t)i * PLACES + (size_t)k];
        if (isnan(*alone)) *alone = box_cost(p, tag, box, gap) + 0.6 * (1 - cos(angle - 0.6));
        if (!(*alone + extra < best->cost)) continue;
        const stand place = {*alone + extra, box, leader_to(p, tag, box), gap >= near_by, i};
        if (clear_of_labels(p, &place)) *best = place;
    }
}

/* The best place of a label by any of its alternatives, which come after the first; one to spare
 * has a good one or none. */
static stand best_place(const placing *p, int label)
{
    const int first = p->first[label], group = p->tags[first].group;
    stand best = {.cost = INFINITY};
    for (int i = first; i < p->n; i++)
        if (i == first || (group > 0 && p->tags[i].group == group))
            find_place(p, i, p->tags[first].weight - p->tags[i].weight, &best);
    if (p->tags[first].spare && best.cost > spare_cost) best.cost = INFINITY;
    return best;
}

/* ---------------------------------------------------------- one for another */

static double price(const placing *p, int label)
{
    return fmin(p->stands[label].cost, p->tags[p->first[label]].spare ? spare_cost : cost_of_none);
}

/* Places label a anew, and b after it (the same: a alone); false, and all as it was, where that is
 * no better. */
static bool place_again(placing *p, int a, int b)
{
    const stand old[] = {p->stands[a], p->stands[b]};
    const double before = price(p, a) + (a != b) * price(p, b);
    p->stands[a].cost = p->stands[b].cost = INFINITY;
    p->stands[a] = best_place(p, a);
    if (a != b) p->stands[b] = best_place(p, b);
    if (price(p, a) + (a != b) * price(p, b) < before - 1) return true;
    p->stands[a] = old[0];
    p->stands[b] = old[1];
    return false;
}

/* Whether label b stands where it may be in the way of a. */
static bool in_sight(const placing *p, int a, int b)
{
    const int first = p->first[a], group = p->tags[first].group;
    const stand *s = &p->stands[b];
    if (a == b) return true;
    for (int i = first; i < p->n && s->cost < INFINITY; i++) {
        const plot_point at = p->tags[i].at, nearest = nearest_in(s->box, at);
        if ((i == first || (group > 0 && p->tags[i].group == group)) &&
            hypot(nearest.x - at.x, nearest.y - at.y) < sight)
            return true;
    }
    return false;
}

static void improve(placing *p)
{
    bool any = true;
    for (int round = 0; any && round < ROUNDS; round++) {
        any = false;
        for (int a = 0; a < p->n_label; a++)
            for (int b = 0; b < p->n_label && price(p, a) > good_enough; b++)
                if (in_sight(p, a, b)) any |= place_again(p, a, b);
    }
}

/* ------------------------------------------------------------------ all of it */

/* The first tag of each label; alternatives follow it. */
static void find_labels(placing *p)
{
    for (int i = 0; i < p->n; i++) {
        bool later = false;
        for (int k = 0; k < p->n_label && !later && p->tags[i].group > 0; k++)
            later = p->tags[p->first[k]].group == p->tags[i].group;
        if (!later) p->first[p->n_label++] = i;
    }
}

static void write_label(const placing *p, const stand *s)
{
    const plot_tag *tag = &p->tags[s->tag];
    plot_page_text(p->page, (plot_point){s->box.left, (s->box.bottom + s->box.top) / 2}, PLOT_LEFT,
                   p->size, tag->colour, false, tag->text);
}

int plot_place_tags(plot_page *page, plot_box bounds, int n, plot_tag *tags, double size)
{
    placing p = {.page = page, .bounds = bounds, .size = size, .n = n, .tags = tags};
    int missing = n;
    p.first = malloc(((size_t)n + 1) * sizeof *p.first);
    p.stands = malloc(((size_t)n + 1) * sizeof *p.stands);
    p.alone = malloc(((size_t)n * PLACES + 1) * sizeof *p.alone);
    if (!p.first || !p.stands || !p.alone) goto out;
    for (size_t i = 0; i < (size_t)n * PLACES; i++) p.alone[i] = NAN;
    if (n > 0) qsort(tags, (size_t)n, sizeof *tags, heavier);
    find_labels(&p);
    for (int i = 0; i < p.n_label; i++) p.stands[i].cost = INFINITY;
    for (int i = 0; i < p.n_label; i++) p.stands[i] = best_place(&p, i);
    improve(&p);
    missing = 0;
    for (int i = 0; i < p.n_label; i++) {
        const stand *s = &p.stands[i];
        if (s->cost < INFINITY) write_label(&p, s);
        else missing += !tags[p.first[i]].spare;
    }
    for (int i = 0; i < p.n_label; i++) {
        const stand *s = &p.stands[i];
        if (s->cost < INFINITY && s->led)
            plot_page_line(page, PLOT_LEADER, 2, (plot_point[]){s->line.from, s->line.to});
    }
out:
    free(p.first);
    free(p.stands);
    free(p.alone);
    return missing;
}
