/* Following a locus: predict along its direction in the chart, solve, look for what it meets, adapt
 * the step. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "locus_parts.h"

#define FIRST_STEP 0.01 /* of a locus, in the metric of its chart */
#define LARGEST_STEP 0.03
#define SMALLEST_STEP 1e-7
/* BEND: cosine of the angle between two directions: a step over a sharper bend is halved */
#define BEND 0.9
#define PLACE 1e-12 /* of a step: where the place of what is met is known */
/* NO_MARGIN: what is this small at the start has to be so by symmetry, and tells nothing */
#define NO_MARGIN 1e-7
/* ZERO: of a value at the ends of a step: what is larger where it was located is none */
#define ZERO 1e-6
/* CROSSED: of the bordered determinant at the start: where a locus is lost with less, a branch
 * crosses */
#define CROSSED 0.1
#define STANDS 1e-3 /* of the speed at the start: an impact that has less has all but lost it */
/* KNOWN: of a parameter: no less is said of how well a place is known that is on a line through two
 */
#define KNOWN 1e-10
/* SLOW: a step below it is a slow one: of SLOW_STEPS in a row nothing more is to be hoped */
#define SLOW 1e-5
enum { PLACE_STEPS = 80, LEAST_CLOSED = 3, SLOW_STEPS = 20, KINDS = RIC_LOCUS_MEETINGS + 7 };

/* What is looked for in a step: first the ends, then the fold, then what is met. */
enum {
    SPARE_GAP,
    SPARE_SPEED,
    SPARE_FLIGHT,
    SPARE_BRANCH,
    FOLD,
    WINDOW,
    MEETING,
    IMAGE = MEETING + RIC_LOCUS_MEETINGS
};

static const char *const texts[KINDS] = {
    [SPARE_GAP] = "another gap touches, too",
    [SPARE_SPEED] = "an impact loses its speed, too",
    [SPARE_FLIGHT] = "two contacts are met at one instant, too",
    [SPARE_BRANCH] = "ends at a branch point: another branch crosses the one that it lies on",
    [FOLD] = "fold: two such junctions meet and annihilate each other",
    [WINDOW] = "border of the range of the parameter",
    [MEETING] = "is an energy extremum, too",
    [MEETING + 1] = "is a period extremum, too",
    [MEETING + 2] = "is a branch point that breaks a symmetry, too",
    [MEETING + 3] = "is a branch point that breaks a symmetry, too",
    [MEETING + 4] = "is a branch point that breaks a symmetry, too",
    [IMAGE] = ("ends in an orbit with more symmetry, or of fewer periods: on the other side it is "
               "its own image"),
};

typedef struct {
    ric_locus *locus;
    ric_locus_problem *q;
    const ric_locus_options *options;
    bool ignored[KINDS];
    ric_locus_orbit start; /* for a locus that closes */
    int points;
    double before[2]; /* parameter and slowest speed at the place before the last one */
} walk;

/* One place of a step: an orbit and its chart. */
typedef struct {
    double s;
    ric_locus_orbit *orbit; /* owned, as charts borrow it */
    ric_locus_chart chart;
} stand;

static void stand_free(stand *x)
{
    ric_locus_chart_free(&x->chart);
    if (x->orbit) ric_locus_orbit_free(x->orbit);
    free(x->orbit);
    *x = (stand){.orbit = NULL};
}

static ric_status stand_make(walk *w, double s, ric_locus_orbit *orbit, const double *before,
                             stand *out)
{
    *out = (stand){.s = s, .orbit = ric_malloc(sizeof *orbit)};
    if (!out->orbit) {
        ric_locus_orbit_free(orbit);
        return ric_no_memory("a locus");
    }
    *out->orbit = *orbit;
    *orbit = (ric_locus_orbit){.p = 0};
    ric_status status = ric_locus_chart_make(w->q, out->orbit, before, &out->chart);
    if (status) stand_free(out);
    return status;
}

/* The locus at a distance s, in units of the chart's direction, from the stand. */
static ric_status advance(walk *w, const stand *from, double s, stand *out)
{
    const ric_locus_chart *chart = &from->chart;
    const double at[2] = {s * chart->ahead[0], s * chart->ahead[1]},
                 across[2] = {-chart->ahead[1], chart->ahead[0]};
    ric_locus_orbit orbit;
    *out = (stand){.orbit = NULL};
    ric_status status = ric_locus_orbit_solve(w->q, chart, at, across, &orbit);
    return status ? status : stand_make(w, s, &orbit, chart->ahead, out);
}

/* ------------------------------------------------------------------ events */

typedef struct {
    int kind;
    double parameter; /* of WINDOW: the value that is asked for, or NAN for the borders */
} sought;

static double value_of(const walk *w, sought what, const stand *x)
{
    const int kind = what.kind;
    const double parameter = what.parameter;
    const ric_vary *v = &w->q->vary;
    const double p = x->orbit->p;
    if (kind < FOLD) return x->orbit->spare[kind];
    if (kind == FOLD) return x->chart.ahead[1];
    if (kind == IMAGE) return NAN; /* told at a fold */
    if (kind >= MEETING) return x->orbit->meets[kind - MEETING];
    return isfinite(parameter) ? p - parameter : fmin(p - v->from, v->to - p);
}

/* Where a value changes its sign between two places of a step; false positions that halve, after
 * Illinois. */
static ric_status locate(walk *w, const stand *from, sought what, const stand *lo, const stand *hi,
                         stand *out)
{
    double a = lo->s, b = hi->s, fa = value_of(w, what, lo), fb = value_of(w, what, hi);
    const double first = fa, last = fb;
    ric_status status = RIC_OK;
    *out = (stand){.orbit = NULL};
    for (int i = 0, side = 0; i < PLACE_STEPS && !status; i++) {
        const double middle = i % 3 == 2 ? (a + b) / 2 : (a * fb - b * fa) / (fb - fa);
        stand_free(out);
        if ((status = advance(w, from, middle, out))) break;
        const double f = value_of(w, what, out);
        if (!isfinite(f)) break;
        if (f == 0 || fabs(b - a) <= PLACE * hi->s) break;
        const bool left = (f > 0) == (fa > 0);
        if (left) {
            a = middle;
            fa = f;
            if (side > 0) fb /= 2;
        } else {
            b = middle;
            fb = f;
            if (side < 0) fa /= 2;
        }
        side = left ? 1 : -1;
    }
    /* a sign that changes without a zero: the step has left the curve, and a shorter one will tell
     */
    if (!status && out->orbit &&
        fabs(value_of(w, what, out)) > ZERO * fmax(fabs(first), fabs(last)))
        status = ric_fail(RIC_E_NUMERIC, "what ends it changes its sign without passing zero");
    return status;
}

static bool changes(const walk *w, sought what, const stand *lo, const stand *hi)
{
    const int kind = what.kind;
    const double a = value_of(w, what, lo), b = value_of(w, what, hi);
    if (kind < FOLD && w->ignored[kind]) return false;
    if (kind < FOLD || (kind == WINDOW && !isfinite(what.parameter))) return b < 0;
    return isfinite(a) && isfinite(b) && a * b < 0;
}

/* The orbit where the parameter has a value, near a place of the step. */
static ric_status solve_at(walk *w, const stand *near, double parameter, ric_locus_orbit *out)
{
    static const double along[2] = {1, 0};
    const double b = (parameter - near->orbit->p) / ric_locus_range(&w->q->vary),
                 at[2] = {near->chart.ahead[1] != 0
                              ? b * near->chart.ahead[0] / near->chart.ahead[1]
                              : 0,
                          b};
    ric_status status = ric_locus_orbit_solve(w->q, &near->chart, at, along, out);
    if (!status) out->p = parameter;
    return status;
}

typedef struct {
    sought what;
    stand at;
} event;

static int by_place(const void *x, const void *y)
{
    const event *a = x, *b = y;
    return a->at.s < b->at.s ? -1 : a->at.s > b->at.s;
}

static bool ends(const event *e)
{
    return e->what.kind < FOLD || e->what.kind == IMAGE ||
           (e->what.kind == WINDOW && !isfinite(e->what.parameter));
}

static ric_status keep_event(walk *w, const event *e)
{
    const ric_locus_mark mark = ends(e)                  ? RIC_LOCUS_END
                                : e->what.kind == WINDOW ? RIC_LOCUS_ASKED
                                : e->what.kind == FOLD   ? RIC_LOCUS_FOLD
                                                         : RIC_LOCUS_MEETS;
    return ric_locus_keep(w->locus, e->at.orbit, mark,
                          mark == RIC_LOCUS_ASKED ? "asked for" : texts[e->what.kind]);
}

/* What a step meets, in order: at most every kind and every value on either side of a fold. */
typedef struct {
    int n;
    event *list; /* owned */
} events;

static void events_free(events *x)
{
    for (int i = 0; i < x->n; i++) stand_free(&x->list[i].at);
    free(x->list);
    *x = (events){.n = 0};
}

static ric_status add_event(walk *w, const stand *from, sought what, const stand *lo,
                            const stand *hi, events *out)
{
    const ric_vary *v = &w->q->vary;
    event *e = &out->list[out->n];
    *e = (event){.what = what};
    ric_status status = locate(w, from, what, lo, hi, &e->at);
    if (!status && what.kind == WINDOW) {
        ric_locus_orbit exact;
        const double p = isfinite(what.parameter) ? what.parameter
                         : fabs(e->at.orbit->p - v->from) < fabs(e->at.orbit->p - v->to) ? v->from
                                                                                         : v->to;
        status = solve_at(w, &e->at, p, &exact);
        if (!status) {
            ric_locus_orbit_free(e->at.orbit);
            *e->at.orbit = exact;
        }
    }
    /* a sign that is lost beside its zero is no event */
    if (!status && !isnan(value_of(w, what, &e->at))) out->n++;
    else stand_free(&e->at);
    return status;
}

static ric_status add_between(walk *w, const stand *from, const stand *lo, const stand *hi,
                              events *out)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < KINDS + w->options->n_value && !status; i++) {
        const sought what = {i < KINDS ? i : WINDOW,
                             i < KINDS ? NAN : w->options->values[i - KINDS]};
        if (what.kind != FOLD && changes(w, what, lo, hi))
            status = add_event(w, from, what, lo, hi, out);
    }
    return status;
}

/* Where a locus of orbits meets its own image the parameter turns, too, but nothing is annihilated:
 * the orbit there has a symmetry that its neighbours have not, or is one of fewer periods gone
 * through several times. */
static bool is_image(const stand *fold)
{
    const ric_model *m = fold->orbit->model;
    ric_periodic *cycle = ric_periodic_from_chain(fold->orbit->chain, fold->orbit->u);
    if (!cycle) return false;
    const bool half = cycle->half, pure = cycle->pure >= 0, flip = cycle->flip >= 0;
    const int copies = ric_periodic_find_symmetries(m, cycle, RIC_SAME_READ_OFF);
    const bool more = copies > 1 || (cycle->half && !half) || (cycle->pure >= 0 && !pure) ||
                      (cycle->flip >= 0 && !flip);
    ric_periodic_free(cycle);
    return more;
}

/* A fold first, as the parameter passes a value twice beside it. */
static ric_status find_events(walk *w, const stand *from, const stand *next, events *out)
{
    *out = (events){
        .list = ric_calloc(2 * (size_t)(KINDS + w->options->n_value) + 1, sizeof *out->list)};
    if (!out->list) return ric_no_memory("a locus");
    stand fold = {.orbit = NULL};
    const sought turn = {FOLD, NAN};
    const bool folds = changes(w, turn, from, next);
    ric_status status = folds ? locate(w, from, turn, from, next, &fold) : RIC_OK;
    if (!status) status = add_between(w, from, from, folds ? &fold : next, out);
    if (!status && folds) status = add_between(w, from, &fold, next, out);
    if (!status && folds)
        out->list[out->n++] = (event){.what = {is_image(&fold) ? IMAGE : FOLD, NAN}, .at = fold};
    else stand_free(&fold);
    if (!status) qsort(out->list, (size_t)out->n, sizeof *out->list, by_place);
    else events_free(out);
    return status;
}

static ric_status keep_events(walk *w, const events *found, bool *done)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < found->n && !status && !*done; i++) {
        status = keep_event(w, &found->list[i]);
        *done = ends(&found->list[i]);
    }
    return status;
}

/* ------------------------------------------------------------------- steps */

static ric_status end_here(walk *w, const stand *at, const char *why)
{
    return ric_locus_keep(w->locus, at->orbit, RIC_LOCUS_END, why);
}

/* Whether a step passes the orbit from which the locus began: the same one where the parameter has
 * its value there. */
static ric_status closes(walk *w, const stand *now, const stand *next, bool *closed)
{
    const ric_locus_orbit *start = &w->start;
    ric_locus_orbit again;
    *closed = false;
    if (w->points < LEAST_CLOSED || (now->orbit->p - start->p) * (next->orbit->p - start->p) > 0)
        return RIC_OK;
    const bool later = fabs(next->orbit->p - start->p) < fabs(now->orbit->p - start->p);
    const ric_status status = solve_at(w, later ? next : now, start->p, &again);
    if (status) return status == RIC_E_NUMERIC ? RIC_OK : status;
    *closed = fabs(again.energy / start->energy - 1) < RIC_SAME_SOLVED &&
              fabs(again.frequency / start->frequency - 1) < RIC_SAME_SOLVED;
    ric_locus_orbit_free(&again);
    return RIC_OK;
}

/* The next place and what lies before it, with the step halved until both are solved; *found false:
 * there is none. */
static ric_status step_on(walk *w, const stand *now, double *step, stand *next, events *met,
                          bool *found)
{
    *found = false;
    for (; *step > SMALLEST_STEP && !*found; *step /= 2) {
        ric_status status = advance(w, now, *step / now->chart.stretch, next);
        if (!status && ric_dot(2, now->chart.ahead, next->chart.ahead) > BEND) {
            status = find_events(w, now, next, met);
            *found = !status;
        }
        if (*found) break;
        stand_free(next);
        if (status && status != RIC_E_NUMERIC && status != RIC_E_INPUT) return status;
    }
    return ric_trust(RIC_OK);
}

/* Why no further place is found. Where another branch crosses, and where modes are commensurate so
 * that orbits of two parameters take over, the surface of orbits is not smooth, and no place is
 * solved close by: what the last one has to spare tells. */
static ric_status end_lost(walk *w, const stand *at)
{
    const ric_locus_orbit *o = at->orbit;
    const double left = o->spare[SPARE_BRANCH] / w->start.spare[SPARE_BRANCH];
    const double speed = o->spare[SPARE_SPEED], lost = w->before[1] - speed,
                 rest = lost > 0 ? speed * (o->p - w->before[0]) / lost : 0;
    char why[400], detail[200];
    ric_locus_commensurate c;
    snprintf(detail, sizeof detail, "%s", ric_detail());
    if (ric_locus_commensurate_near(w->q, o->p, o->frequency, &c))
        snprintf(why, sizeof why,
                 "it is not followed further: its period is %d of mode %d within %.1g, and modes "
                 "%d and %d are "
                 "commensurate, %d to %d, where the parameter is %.15g",
                 c.swings, c.swinging + 1, c.off, c.mode[0] + 1, c.mode[1] + 1, c.ratio[0],
                 c.ratio[1], c.value);
    else if (speed < STANDS * w->start.spare[SPARE_SPEED])
        snprintf(why, sizeof why,
                 "it is not followed further: an impact loses its speed, of which %.1g of that at "
                 "the start is left, "
                 "and what it is told by turns ever more sharply; that is where the parameter is "
                 "%.10g within %.1g",
                 speed / w->start.spare[SPARE_SPEED], o->p + rest, fmax(fabs(rest), KNOWN));
    else if (left < CROSSED)
        snprintf(why, sizeof why,
                 "it is not followed further: another branch crosses the one that it lies on, or "
                 "comes near; the "
                 "determinant that vanishes there is %.2g of that at the start",
                 left);
    else
        snprintf(why, sizeof why,
                 "it is not followed further: %s; the slowest impact has a speed of %.3g, the "
                 "shortest flight takes "
                 "%.3g s",
                 detail, o->spare[SPARE_SPEED], o->spare[SPARE_FLIGHT] / o->model->omega_ref);
    return end_here(w, at, why);
}

/* One way, from a stand that is taken over. *closed: it came back to where it began. */
static ric_status go(walk *w, stand now, bool *closed)
{
    const double longest = w->options->max_step > 0 ? w->options->max_step : LARGEST_STEP;
    double step = fmin(FIRST_STEP, longest);
    bool done = false;
    int slow = 0;
    ric_status status = RIC_OK;
    for (w->points = 0; !status && !done; w->points++) {
        stand next = {.orbit = NULL};
        events met = {.n = 0};
        bool found = false;
        if (ric_locus_stopped(w->options, w->points, now.orbit->p))
            status = ric_fail(RIC_E_INTERRUPTED, "stopped on request");
        else if (w->points < w->options->max_points && slow < SLOW_STEPS)
            status = step_on(w, &now, &step, &next, &met, &found);
        if (!status && !found) {
            status = w->points < w->options->max_points ? end_lost(w, &now)
                                                        : end_here(w, &now, "budget of points");
            done = true;
        }
        if (!status && !done) status = keep_events(w, &met, &done);
        if (!status && !done) status = closes(w, &now, &next, closed);
        if (!status && *closed) {
            status = end_here(w, &next, "closed");
            done = true;
        }
        if (!status && !done) status = ric_locus_keep(w->locus, next.orbit, RIC_LOCUS_PLAIN, "");
        slow = step < SLOW ? slow + 1 : 0;
        events_free(&met);
        w->before[0] = now.orbit->p;
        w->before[1] = now.orbit->spare[SPARE_SPEED];
        stand_free(&now);
        now = next;
        now.s = 0;
        step = fmin(1.5 * step, longest);
    }
    stand_free(&now);
    return status;
}

/* The orbit that the equations of the junction lead to has to be that of the junction, and a
 * motion.
 */
static ric_status check_start(const ric_locus_orbit *rough, const ric_locus_orbit *exact)
{
    if (!(fabs(exact->energy / rough->energy - 1) <= RIC_SAME_LOCATED &&
          fabs(exact->frequency / rough->frequency - 1) <= RIC_SAME_LOCATED))
        return ric_fail(RIC_E_NUMERIC,
                        "the junction is not found again: what its kind demands leads from E %.9g "
                        "to another orbit at E %.9g",
                        rough->energy, exact->energy);
    return exact->spare[SPARE_GAP] > -RIC_SAME_LOCATED
               ? RIC_OK
               : ric_fail(RIC_E_NUMERIC, "the orbit of the junction passes a stop");
}

static ric_status stand_at_start(walk *w, const ric_periodic *cycle, const double *before,
                                 stand *out)
{
    static const double along[2] = {1, 0}, here[2] = {0, 0};
    ric_locus_orbit rough, exact;
    ric_locus_chart chart;
    *out = (stand){.orbit = NULL};
    ric_status status = ric_locus_orbit_begin(w->q, cycle, &rough);
    if (!status && !(status = ric_locus_chart_make(w->q, &rough, NULL, &chart))) {
        status = ric_locus_orbit_solve(w->q, &chart, here, along, &exact);
        ric_locus_chart_free(&chart);
        if (!status && (status = check_start(&rough, &exact))) ric_locus_orbit_free(&exact);
        if (!status) exact.p = w->q->vary.at;
        if (!status) status = stand_make(w, 0, &exact, before, out);
    }
    ric_locus_orbit_free(&rough);
    return status;
}

ric_status ric_locus_follow_curve(ric_locus *locus, ric_locus_problem *q, const ric_periodic *cycle,
                                  const ric_locus_options *options)
{
    walk w = {.locus = locus, .q = q, .options = options};
    bool closed = false;
    stand first = {.orbit = NULL}, second = {.orbit = NULL};
    ric_status status = stand_at_start(&w, cycle, NULL, &first);
    if (status) return status;
    const double back[2] = {-first.chart.ahead[0], -first.chart.ahead[1]};
    for (int i = 0; i < FOLD; i++) w.ignored[i] = first.orbit->spare[i] < NO_MARGIN;
    w.start = (ric_locus_orbit){.p = first.orbit->p,
                                .energy = first.orbit->energy,
                                .frequency = first.orbit->frequency};
    memcpy(w.start.spare, first.orbit->spare, sizeof w.start.spare);
    status = stand_at_start(&w, cycle, back, &second);
    const ric_locus_orbit *start = second.orbit;
    if (!status) status = go(&w, first, &closed);
    else stand_free(&first);
    if (!status) {
        ric_locus_turn(locus);
        status = ric_locus_keep(locus, start, RIC_LOCUS_START, "the structure of the atlas");
    }
    if (!status && !closed) status = go(&w, second, &closed);
    else stand_free(&second);
    return status;
}
