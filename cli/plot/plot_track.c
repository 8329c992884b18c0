/* A branch on the way to the page: its stored points with the junctions between them, the curve
 * through them, and its pieces of equal stability. */
#include <math.h>
#include <stdlib.h>

#include "plot.h"

/* The curve: points of a branch depend smoothly on its arclength. Slopes come from the polynomial
 * through five stored points (Fornberg, Math. Comp. 51 (1988) 699-706), and a cubic joins two
 * points with theirs (Hermite): the error is of fourth order in the step of the continuation, that
 * of a chord of the second. */
enum { STENCIL = 5, MOST_PIECES = 64 };
static const double visible = 0.02; /* pixels that a chord may be off */
static const double crowded =
    0.05; /* of the step beside it: so near a point adds noise to a slope, and no more */
static const double two_dots = 4.5; /* pixels from one dot of what is undecided to the next */

bool plot_track_add(plot_track *t, plot_point at, double arclength, int stable)
{
    if (t->n == t->room) {
        const int room = t->room ? 2 * t->room : 256;
        plot_knot *knots = realloc(t->knots, (size_t)room * sizeof *knots);
        if (!knots) return false;
        t->knots = knots;
        t->room = room;
    }
    t->knots[t->n++] = (plot_knot){.at = at,
                                   .arclength = arclength,
                                   .stable = stable,
                                   .stored = true};
    return true;
}

bool plot_track_join(plot_track *t, plot_point at, double arclength)
{
    if (!plot_track_add(t, at, arclength, PLOT_JOINT)) return false;
    t->knots[t->n - 1].stored = false;
    return true;
}

void plot_track_gap(plot_track *t)
{
    if (t->n > 0) t->knots[t->n - 1].gap = true;
}

void plot_track_free(plot_track *t)
{
    free(t->knots);
    *t = (plot_track){0};
}

static int by_arclength(const void *a, const void *b)
{
    const plot_knot *s = a, *t = b;
    if (s->arclength != t->arclength)
        return (s->arclength > t->arclength) - (s->arclength < t->arclength);
    return (s->stable == PLOT_JOINT) - (t->stable == PLOT_JOINT);
}

int plot_point_stability(const ric_atlas *atlas, const ric_branch *branch, int i,
                         const ric_point *point)
{
    const int stable = point->stable >= 0 && point->stable <= 2 ? point->stable
                                                                : RIC_STABLE_UNDECIDED;
    const bool inside = i > 0 &&
                        i + 1 < branch->n_point; /* else there may be no neighbour that could say */
    const bool joint = (inside || stable == RIC_STABLE_UNDECIDED) &&
                       cli_point_at_junction(branch, i, point);
    return joint || cli_stability_changes(atlas, branch, i, point) ? PLOT_JOINT : stable;
}

void plot_track_sort(plot_track *t)
{
    if (t->n > 0) qsort(t->knots, (size_t)t->n, sizeof *t->knots, by_arclength);
}

/* ------------------------------------------------------------------- curves */

typedef struct {
    plot_point at, slope; /* slope: by arclength; NaN where there is none */
} node;

static plot_point slope_of(const plot_track *t, int n, const int *stencil, int own)
{
    const plot_knot *k = t->knots;
    plot_point slope = {0, 0};
    if (n < 2) return (plot_point){NAN, NAN};
    for (int i = 0; i < n; i++) {
        double weight = 1;
        if (stencil[i] == own) continue;
        for (int j = 0; j < n; j++) { /* the derivative of Lagrange's polynomial of point i */
            if (j == i) continue;
            const double from = k[stencil[i]].arclength - k[stencil[j]].arclength;
            weight *= (stencil[j] == own ? 1 : k[own].arclength - k[stencil[j]].arclength) / from;
        }
        slope.x += weight * (k[stencil[i]].at.x - k[own].at.x);
        slope.y += weight * (k[stencil[i]].at.y - k[own].at.y);
    }
    return slope;
}

/* The nearest stored point on one side that is not crowded, -1 if the curve ends before. */
static int next_stored(const plot_track *t, int from, int step, double least)
{
    for (int i = from;;) {
        if (step > 0 && t->knots[i].gap) return -1;
        i += step;
        if (i < 0 || i >= t->n || (step < 0 && t->knots[i].gap)) return -1;
        if (t->knots[i].stored && fabs(t->knots[i].arclength - t->knots[from].arclength) > least)
            return i;
    }
}

/* Distance to the farther one of the stored points beside a knot. */
static double step_at(const plot_track *t, int own)
{
    double step = 0;
    for (int side = -1; side <= 1; side += 2) {
        const int i = next_stored(t, own, side, 0);
        if (i >= 0) step = fmax(step, fabs(t->knots[i].arclength - t->knots[own].arclength));
    }
    return step;
}

/* Slope at a stored knot: points on both sides as far as there are some, else more of one side. */
static plot_point stored_slope(const plot_track *t, int own)
{
    const double least = crowded * step_at(t, own);
    int stencil[STENCIL] = {own}, n = 1, end[2] = {own, own};
    for (bool found = true; found && n < STENCIL;) {
        found = false;
        for (int side = 0; side < 2 && n < STENCIL; side++) {
            const int i = end[side] < 0 ? -1 : next_stored(t, end[side], side ? 1 : -1, least);
            end[side] = i;
            if (i < 0) continue;
            stencil[n++] = i;
            found = true;
        }
    }
    return slope_of(t, n, stencil, own);
}

static plot_point hermite(const node *a, const node *b, double h, double s)
{
    const double r = 1 - s, wa = r * r * (1 + 2 * s), wb = s * s * (3 - 2 * s), va = h * s * r * r,
                 vb = -h * s * s * r;
    return (plot_point){wa * a->at.x + wb * b->at.x + va * a->slope.x + vb * b->slope.x,
                        wa * a->at.y + wb * b->at.y + va * a->slope.y + vb * b->slope.y};
}

static plot_point hermite_slope(const node *a, const node *b, double h, double s)
{
    const double r = 1 - s, w = 6 * s * r / h, va = r * (1 - 3 * s), vb = s * (3 * s - 2);
    return (plot_point){w * (b->at.x - a->at.x) + va * a->slope.x + vb * b->slope.x,
                        w * (b->at.y - a->at.y) + va * a->slope.y + vb * b->slope.y};
}

/* Slopes of all knots; those of junctions are of the cubic between the stored points around them.
 */
static void find_nodes(const plot_track *t, node *nodes)
{
    for (int i = 0; i < t->n; i++)
        nodes[i] = (node){t->knots[i].at,
                          t->knots[i].stored ? stored_slope(t, i) : (plot_point){NAN, NAN}};
    for (int i = 0; i < t->n; i++) {
        if (t->knots[i].stored) continue;
        const int a = next_stored(t, i, -1, 0), b = next_stored(t, i, 1, 0);
        if (a < 0 || b < 0) continue;
        const double h = t->knots[b].arclength - t->knots[a].arclength;
        nodes[i].slope = hermite_slope(&nodes[a], &nodes[b], h,
                                       (t->knots[i].arclength - t->knots[a].arclength) / h);
    }
}

/* Into how many chords the curve between two knots is cut, so that none is visibly off; 1 where it
 * cannot be trusted. */
static int pieces_of(const plot_panel *panel, const node *a, const node *b, double h)
{
    const plot_point p = plot_panel_at(panel, a->at), q = plot_panel_at(panel, b->at);
    const plot_box box = plot_panel_box(panel);
    const double length = hypot(q.x - p.x, q.y - p.y);
    double off = 0;
    if ((p.x < box.left && q.x < box.left) || (p.x > box.right && q.x > box.right) ||
        (p.y < box.bottom && q.y < box.bottom) || (p.y > box.top && q.y > box.top))
        return 1;
    for (int i = 1; i < 4; i++) {
        const plot_point m = plot_panel_at(panel, hermite(a, b, h, i / 4.));
        /* the distance from the chord is what is seen, not the place along it */
        off = fmax(off, fabs((m.x - p.x) * (q.y - p.y) - (m.y - p.y) * (q.x - p.x)) /
                            fmax(length, visible));
        if (isnan(m.x + m.y)) off = NAN;
    }
    if (!(off <= length))
        return 1; /* a fold within one step that the cubic cannot know, or no slope */
    return (int)fmin(MOST_PIECES, ceil(sqrt(off / visible)));
}

/* Stability of what lies behind knot i: that of the next point where a junction has been passed,
 * else of the last. */
static int stable_behind(const plot_track *t, int i)
{
    const int step = t->knots[i].stable == PLOT_JOINT ? 1 : -1;
    for (int k = i; k >= 0 && k < t->n; k += step)
        if (t->knots[k].stable != PLOT_JOINT) return t->knots[k].stable;
    return PLOT_JOINT;
}

bool plot_track_smooth(const plot_panel *panel, plot_track *t)
{
    node *nodes = malloc(((size_t)t->n + 1) * sizeof *nodes);
    plot_track out = {0};
    bool good = nodes;
    if (good) find_nodes(t, nodes);
    for (int i = 0; good && i < t->n; i++) {
        const plot_knot *a = &t->knots[i], *b = a + 1;
        good = plot_track_add(&out, a->at, a->arclength, a->stable);
        if (!good) break;
        out.knots[out.n - 1] = *a;
        if (i + 1 == t->n || a->gap || !(b->arclength > a->arclength)) continue;
        const double h = b->arclength - a->arclength;
        const int pieces = pieces_of(panel, &nodes[i], &nodes[i + 1], h),
                  before = stable_behind(t, i);
        for (int k = 1; good && k < pieces; k++) {
            const bool late = 2 * k >= pieces && b->stable != PLOT_JOINT;
            const double s = (double)k / pieces;
            good = plot_track_add(&out, hermite(&nodes[i], &nodes[i + 1], h, s),
                                  a->arclength + s * h, late ? b->stable : before);
            if (good) out.knots[out.n - 1].stored = false;
        }
    }
    free(nodes);
    plot_track_free(good ? t : &out);
    if (good) *t = out;
    return good;
}

/* ---------------------------------------------------------------- stability */

/* Where stability changes on the way to knot i: the first junction since the last point, else half
 * way. Returns the knot that the new run starts with, after setting *middle. */
static int change_before(const plot_track *t, int i, plot_point *middle)
{
    int first = i;
    while (first > 0 && t->knots[first - 1].stable == PLOT_JOINT && !t->knots[first - 1].gap)
        first--;
    if (first < i) {
        *middle = t->knots[first].at;
        return first + 1;
    }
    const plot_point a = t->knots[i - 1].at, b = t->knots[i].at;
    *middle = (plot_point){(a.x + b.x) / 2, (a.y + b.y) / 2};
    return i;
}

/* Draws a run of one stability. Returns it as a set, empty where nothing of it is to be seen: a run
 * beyond the panel, and a dotted one that is too short for two dots. */
static unsigned draw_run(plot_page *page, const plot_panel *panel, plot_stroke family,
                         int stability, int n, const plot_point *run)
{
    bool inside = false;
    double length = 0;
    for (int i = 0; i < n; i++) {
        inside |= plot_panel_inside(panel, run[i]);
        if (i == 0) continue;
        const plot_point a = plot_panel_at(panel, run[i - 1]), b = plot_panel_at(panel, run[i]);
        length += hypot(b.x - a.x, b.y - a.y);
    }
    plot_panel_curve(page, panel, family + (plot_stroke)stability, n, run);
    return inside && (stability != RIC_STABLE_UNDECIDED || length >= two_dots) ? 1u << stability
                                                                               : 0;
}

unsigned plot_track_draw(plot_page *page, const plot_panel *panel, plot_stroke family,
                         const plot_track *t)
{
    plot_point *run = malloc(((size_t)t->n + 2) * sizeof *run);
    unsigned seen = 0;
    int n = 0, present = RIC_STABLE_UNDECIDED, i = 0;
    for (int k = 0; k < t->n; k++)
        if (t->knots[k].stable != PLOT_JOINT) {
            present = t->knots[k].stable;
            break;
        }
    for (; run && i < t->n; i++) {
        const plot_knot *knot = &t->knots[i];
        if (n == 0 && knot->stable != PLOT_JOINT) present = knot->stable;
        if (knot->stable != PLOT_JOINT && knot->stable != present) {
            plot_point middle;
            const int start = change_before(t, i, &middle);
            n -= i - start; /* joints behind the change belong to the new run */
            if (start == i) run[n++] = middle;
            seen |= draw_run(page, panel, family, present, n, run);
            run[0] = middle;
            n = 1;
            for (int k = start; k < i; k++) run[n++] = t->knots[k].at;
            present = knot->stable;
        }
        run[n++] = knot->at;
        if (!knot->gap) continue;
        seen |= draw_run(page, panel, family, present, n, run);
        n = 0;
    }
    if (run && n > 0) seen |= draw_run(page, panel, family, present, n, run);
    free(run);
    return seen;
}
