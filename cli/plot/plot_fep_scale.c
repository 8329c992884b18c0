/* Scales of the axes of the frequency-energy picture, where nobody asked for one: that by which the
 * branches share the axis most evenly. */
#include <math.h>
#include <stdlib.h>

#include "plot_fep.h"

enum { BINS = 32, KNEES = 12 };
static const double telling =
    0.15; /* nats by which another scale must be more even than a linear one */
static const double decade = 10; /* energies that span as much are logarithmic in any case */
static const double wide_gap =
    1.3; /* ratio of the frequencies beside a gap that an axis may leave out */
static const double least_piece =
    0.07; /* part of its length that a piece of a cut axis has at least */
static const double narrow =
    3; /* and those that span less are linear: their tics are easier to read */

typedef struct {
    double energy, frequency;
} place;

/* All stored points in the window, branch by branch, but of linear modes on which nothing happens.
 */
typedef struct {
    int n, room, n_run, *ends; /* places, and where the points of a part end: [n_run] */
    place *places;
} crowd;

static bool add_place(crowd *c, place p)
{
    if (c->n == c->room) {
        const int room = c->room ? 2 * c->room : 4096;
        place *places = realloc(c->places, (size_t)room * sizeof *places);
        if (!places) return false;
        c->places = places;
        c->room = room;
    }
    c->places[c->n++] = p;
    return true;
}

static ric_status gather_part(const fep *f, const fep_source *s, const fep_part *part, crowd *c)
{
    const plot_axis *x = &f->panels[0].x, *y = &f->panels[0].y;
    ric_branch branch;
    ric_status status = ric_atlas_branch(s->atlas, part->branch, &branch);
    for (int i = 0; status == RIC_OK && i < branch.n_point && !part->idle; i++) {
        ric_point p;
        status = ric_atlas_point(s->atlas, part->branch, i, &p, NULL, NULL);
        const place at = {p.energy, p.frequency / part->k};
        const bool seen = p.arclength >= part->lo && p.arclength <= part->hi &&
                          at.energy >= x->lo && at.energy <= x->hi && at.frequency >= y->lo &&
                          at.frequency <= y->hi;
        if (status == RIC_OK && seen && !add_place(c, at)) status = RIC_E_NOMEM;
    }
    c->ends[c->n_run++] = c->n;
    return status;
}

static ric_status gather(const fep *f, crowd *c)
{
    int parts = 0;
    for (int i = 0; i < f->n_source; i++) parts += f->sources[i].n_part;
    ric_status status = (c->ends = calloc((size_t)parts + 1, sizeof *c->ends)) ? RIC_OK
                                                                               : RIC_E_NOMEM;
    for (int k = 0; status == RIC_OK && k < f->n_source; k++)
        for (int i = 0; status == RIC_OK && i < f->sources[k].n_part; i++)
            status = gather_part(f, &f->sources[k], &f->sources[k].parts[i], c);
    return status;
}

/* Adds the way between two places, in parts of the axis, to the bins that it passes. */
static void spread_over(double a, double b, double length, double bins[BINS])
{
    enum { STEPS = 2 * BINS };
    const int n = 1 + (int)fmin(STEPS, STEPS * fabs(b - a));
    for (int i = 0; i < n; i++) {
        const double at = a + (b - a) * (i + 0.5) / n;
        const int bin = (int)(BINS * at);
        if (at >= 0 && bin < BINS) bins[bin] += length / n;
    }
}

/* Entropy of how the branches, each of weight one, lie along the axis; the other axis only lends
 * their lengths. */
static double evenness(const crowd *c, plot_axis x, plot_axis y, bool along_x)
{
    double sum[BINS] = {0}, total = 0, entropy = 0;
    x.from = y.from = 0;
    x.to = y.to = 1;
    for (int run = 0, i = 0; run < c->n_run; run++) {
        double own[BINS] = {0}, all = 0;
        for (int first = i; i < c->ends[run]; i++) {
            if (i == first) continue;
            const place *p = &c->places[i - 1], *q = &c->places[i];
            const double x0 = plot_axis_at(&x, p->energy), x1 = plot_axis_at(&x, q->energy),
                         y0 = plot_axis_at(&y, p->frequency), y1 = plot_axis_at(&y, q->frequency);
            spread_over(along_x ? x0 : y0, along_x ? x1 : y1, hypot(x1 - x0, y1 - y0), own);
        }
        for (int k = 0; k < BINS; k++) all += own[k];
        for (int k = 0; k < BINS && all > 0; k++) sum[k] += own[k] / all;
        total += all > 0;
    }
    for (int k = 0; k < BINS; k++)
        if (sum[k] > 0) entropy -= sum[k] / total * log(sum[k] / total);
    return entropy;
}

static int by_frequency(const void *a, const void *b)
{
    const place *p = a, *q = b;
    return (p->frequency > q->frequency) - (p->frequency < q->frequency);
}

/* The stored points by frequency; NULL: no memory. */
static place *sort_places(const crowd *c)
{
    place *sorted = malloc(((size_t)c->n + 1) * sizeof *sorted);
    for (int i = 0; sorted && i < c->n; i++) sorted[i] = c->places[i];
    if (sorted) qsort(sorted, (size_t)c->n, sizeof *sorted, by_frequency);
    return sorted;
}

static int by_place(const void *a, const void *b)
{
    const plot_cut *s = a, *t = b;
    return (s->lo > t->lo) - (s->lo < t->lo);
}

/* The widest gaps in the frequencies of the stored points, by their ratio, in ascending order; a
 * margin stays of them. */
static void widest_gaps(const crowd *c, const place *sorted, plot_axis *y)
{
    for (int i = 1; i < c->n; i++) {
        const plot_cut gap = {sorted[i - 1].frequency, sorted[i].frequency, 0};
        if (!(gap.hi > wide_gap * gap.lo)) continue;
        int at = y->n_cut;
        if (at == PLOT_MAX_CUT) { /* in the place of the narrowest one, if that is narrower */
            for (int k = at = 0; k < PLOT_MAX_CUT; k++)
                if (y->cut[k].hi / y->cut[k].lo < y->cut[at].hi / y->cut[at].lo) at = k;
            if (gap.hi / gap.lo <= y->cut[at].hi / y->cut[at].lo) continue;
        } else y->n_cut++;
        y->cut[at] = gap;
    }
    qsort(y->cut, (size_t)y->n_cut, sizeof *y->cut, by_place);
}

/* Pieces get a margin of a part of their width, and of their frequency where they are a line; and
 * of the length of the axis a least part and a share of the rest, as the root of how many branches
 * they have. */
static void lay_pieces(const crowd *c, plot_axis *y)
{
    double share[PLOT_MAX_CUT + 1] = {0}, all = 0, at = 0;
    const double lo = y->lo, hi = y->hi, rest = 1 - least_piece * (y->n_cut + 1);
    for (int run = 0, i = 0; run < c->n_run; i = c->ends[run++]) {
        if (c->ends[run] == i) continue;
        int k = 0;
        while (k < y->n_cut && c->places[(i + c->ends[run]) / 2].frequency > y->cut[k].lo) k++;
        share[k]++;
    }
    for (int k = 0; k <= y->n_cut; k++) all += share[k] = sqrt(share[k]);
    for (int k = 0; k <= y->n_cut; k++) {
        const double from = k ? y->cut[k - 1].hi : lo, to = k < y->n_cut ? y->cut[k].lo : hi,
                     margin = fmax(0.08 * (to - from), 0.01 * to);
        at += least_piece + rest * share[k] / all;
        if (k < y->n_cut) {
            y->cut[k].at = at;
            y->cut[k].lo = to + margin;
        }
        if (k > 0) y->cut[k - 1].hi = from - margin;
    }
}

/* An axis of linear pieces, without the ranges between them where no branch is; false if there are
 * none. */
static bool cut_axis(const crowd *c, const place *sorted, plot_axis *y)
{
    y->scale = PLOT_SCALE_CUT;
    y->n_cut = 0;
    if (c->n_run < 2) return false;
    widest_gaps(c, sorted, y);
    lay_pieces(c, y);
    bool good = y->n_cut > 0;
    for (int k = 0; k < y->n_cut; k++) good &= y->cut[k].lo < y->cut[k].hi;
    return good;
}

bool fep_log_window(const fep_options *o, double lo, double hi)
{
    return o->log_energy || (!o->linear && lo > 0 && hi >= narrow * lo);
}

static void choose_energy(const fep *f, const crowd *c, plot_axis *x, plot_axis y)
{
    plot_axis even = *x, log = *x;
    even.scale = PLOT_SCALE_LINEAR;
    log.scale = PLOT_SCALE_LOG;
    x->scale = fep_log_window(f->options, x->lo, x->hi) ? PLOT_SCALE_LOG : PLOT_SCALE_LINEAR;
    if (x->scale == PLOT_SCALE_LOG && !f->options->log_energy && x->hi < decade * x->lo &&
        evenness(c, log, y, true) < evenness(c, even, y, true) + telling)
        x->scale = PLOT_SCALE_LINEAR;
}

/* Takes the other axis if the branches lie more evenly along it. */
static void take_if_even(const crowd *c, const plot_axis *x, const plot_axis *other, double *best,
                         plot_axis *y)
{
    const double even = evenness(c, *x, *other, false);
    if (!(even > *best)) return;
    *best = even;
    *y = *other;
}

/* Knees of a broken axis are tried above most of the stored points. Cuts hide how far the pieces
 * are apart: they have to be worth it once more. */
static bool choose_frequency(const fep *f, const crowd *c, plot_axis x, plot_axis *y)
{
    const fep_options *o = f->options;
    if (o->has_break || o->log_frequency || o->linear_frequency || y->hi < narrow * y->lo ||
        c->n == 0)
        return true;
    double best = evenness(c, x, *y, false) + telling;
    const plot_axis even = *y;
    plot_axis other = even;
    place *sorted = sort_places(c);
    if (!sorted) return false;
    other.scale = PLOT_SCALE_LOG;
    if (even.lo > 0) take_if_even(c, &x, &other, &best, y);
    for (int i = 0; i < KNEES; i++) {
        const int rank = (int)((double)c->n * (0.6 + 0.4 * i / KNEES));
        other = even;
        other.scale = PLOT_SCALE_BROKEN;
        other.knee = 1.02 * sorted[rank < c->n ? rank : c->n - 1].frequency;
        if (other.knee > even.lo && even.hi > narrow * other.knee)
            take_if_even(c, &x, &other, &best, y);
    }
    other = even;
    best += telling;
    if (cut_axis(c, sorted, &other)) take_if_even(c, &x, &other, &best, y);
    free(sorted);
    return true;
}

/* Linear modes on which nothing happens make no piece of the axis: those in a cut are not drawn. */
static ric_status leave_out_cut(fep *f, fep_source *s)
{
    int n = 0;
    for (int i = 0; i < s->n_part; i++) {
        const fep_part *part = &s->parts[i];
        ric_branch branch;
        const ric_status status = ric_atlas_branch(s->atlas, part->branch, &branch);
        if (status != RIC_OK) return status;
        const double frequency = branch.frequency_max / part->k;
        if (part->idle && plot_axis_omits(&f->panels[0].y, frequency))
            fep_leave_out(f, frequency, frequency);
        else s->parts[n++] = *part;
    }
    s->n_part = n;
    return RIC_OK;
}

ric_status fep_choose_scales(fep *f)
{
    crowd c = {0};
    plot_axis *x = &f->panels[0].x, *y = &f->panels[0].y;
    ric_status status = gather(f, &c);
    if (status == RIC_OK) {
        choose_energy(f, &c, x, *y);
        if (!choose_frequency(f, &c, *x, y)) status = RIC_E_NOMEM;
    }
    free(c.ends);
    free(c.places);
    for (int i = 0; status == RIC_OK && i < f->n_source && y->n_cut > 0; i++)
        status = leave_out_cut(f, &f->sources[i]);
    return status;
}
