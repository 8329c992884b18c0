#include "event.h"

#include <stdlib.h>
#include <string.h>

#include "symmetric_end.h"
#include "branch_point_gap.h"
#include "event_parts.h"
#include "model/room.h"
#include "base/room.h"

/* A step, relative to the size of the orbit, in which a factor of the map that changes its sign
 * without a zero has jumped. */
#define JUMP 1e-7
/* How far the sign of a factor that was never seen may come out of rounding in one step, over the
 * least that is seen. */
#define EMERGED 100
/* Of the size: the start of a closed branch again. */
#define SAME_PLACE 1e-8
/* The same at a branch point, of the step over it: the cubic is off by its fourth power, and
 * another branch through that point has another heading. */
#define ON_CUBIC 1e-4
/* ASIDE: of a step: so far from its tangent the start lies on another part of the curve. SAME_WAY:
 * cosine of the angle to the heading there: what comes back goes the same way, or another branch
 * passes */
#define ASIDE 0.3
#define SAME_WAY 0.5
/* A step over a crossing has it in its middle: as long as it should be within SHORTER and LONGER of
 * that and below LONGEST lengths it is placed well; farther ahead than LATER of a length the
 * crossing is reached by a step before that, shortened at least to SOONER of it, as the place is
 * known by a secant */
#define SHORTER 0.7
#define LONGER 1.4
#define LONGEST 3
#define LATER 1.1
#define SOONER 0.9
/* Attempts to place a step over it well: the secant has settled by then, or the determinant only
 * touches zero. */
#define APPROACHES 4

/* POLE: of 1, its largest value: the test of a resonance that is above it where it has changed its
 * sign has no zero there; lambda + 1/lambda went through infinity, or rounding made it jump */
#define POLE 0.1
#define RATIO_NEAREST 20 /* of the first distance from there that is looked at, at most */
/* PASSES: looks at one step, the later ones with the events of the one before among the points */
#define PASSES 8
/* NEAREST: distance from an end with poles, of the size of the orbit, up to which events are looked
 * for: nearer by orbits are known to rounding over the distance */
#define NEAREST 1e-7
/* SHORTEST: step, of the size, that is not made shorter for a sign that comes out of rounding */
#define SHORTEST 3e-7
/* SHORT_OF: of the size of the orbit: what is seen so far before a zero is seen before it. */
#define SHORT_OF 1e-12
#define SHORTENED 8 /* times that an end is taken back before its touch */

/* What ghosts are allowed to do: gaps are penetrated, impacts have the wrong direction. Where the
 * speed of one of them passes through zero the singular functions change sign without a zero. */
static const unsigned free_of_ghosts = 1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH |
                                       1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D;

bool ric_event_watched(const ric_continuation *tr, int test)
{
    if (tr->ignore & 1u << test) return false;
    /* short of an orbit of fewer periods the determinant is rounding, and its zero nothing that
     * could be crossed */
    if (test == RIC_TEST_DET && tr->longest < HUGE_VAL) return false;
    return !(tr->limits->ghost && (free_of_ghosts & 1u << test));
}

/* Distance of a zero of the bordered determinant in this step or close behind its end; infinite if
 * there is none. */
static double crossing_ahead(const ric_continuation *tr, double h)
{
    double fa = tr->now.test[RIC_TEST_DET], fb = tr->next.test[RIC_TEST_DET],
           x = h * fa / (fa - fb);
    return ric_event_watched(tr, RIC_TEST_DET) && !tr->avoided && x > 0 &&
                   x < h + RIC_CROSSING / 4 * tr->chain->scale
               ? x
               : HUGE_VAL;
}

/* Behind a multiplication of high order the signs of the factors are lost in rounding for a long
 * way, and the first that is seen may be that behind a zero: it has to be seen soon after it
 * emerges. */
static bool emerges_late(const ric_continuation *tr)
{
    for (int i = 0; i < 3; i++) {
        int test = RIC_TEST_A + i;
        bool lost = tr->definite[test] == 0 && tr->past.test[test] == 0 && tr->now.test[test] == 0;
        if (ric_event_watched(tr, test) && lost &&
            fabs(tr->next.test[test]) > EMERGED * tr->now.hidden[i])
            return true;
    }
    return false;
}

bool ric_event_suspicious(const ric_continuation *tr, double h)
{
    return tr->has_past && h >= SHORTEST * tr->chain->scale && crossing_ahead(tr, h) == HUGE_VAL &&
           emerges_late(tr);
}

/* -------------------------------------------------------------------- keeping */

static ric_status fill_event(const ric_continuation *tr, int test, const ric_station *p,
                             ric_event *out)
{
    size_t bytes = (size_t)tr->chain->n_unknown * sizeof(double);
    *out = (ric_event){.test = test, .s = p->s, .u = ric_malloc(bytes), .t = ric_malloc(bytes)};
    if (!out->u || !out->t) {
        free(out->u);
        free(out->t);
        out->u = out->t = NULL;
        return ric_no_memory("an event");
    }
    memcpy(out->u, p->u, bytes);
    memcpy(out->t, p->t, bytes);
    return RIC_OK;
}

ric_status ric_event_keep(ric_continuation *tr, int test, const ric_station *p)
{
    if (tr->n_event == tr->event_capacity) {
        int capacity = tr->event_capacity ? 2 * tr->event_capacity : 8;
        ric_event *grown = ric_realloc(tr->events, (size_t)capacity * sizeof *grown);
        if (!grown) return ric_fail(RIC_E_NOMEM, "no memory for %d events", capacity);
        tr->events = grown;
        tr->event_capacity = capacity;
    }
    ric_status status = fill_event(tr, test, p, &tr->events[tr->n_event]);
    if (!status) tr->n_event++;
    return status;
}

ric_status ric_event_arrive(ric_continuation *tr, const ric_station *p)
{
    ric_status status = fill_event(tr, RIC_TEST_DET, p, &tr->end);
    tr->arrival = true;
    tr->stop = RIC_STOP_JUNCTION;
    tr->why = RIC_WHY_NONE;
    return status ? status : ric_continuation_keep(tr, p);
}

ric_status ric_event_border(ric_continuation *tr, const ric_station *p)
{
    ric_status status = fill_event(tr, RIC_TEST_F_MAX, p, &tr->end);
    tr->stop = RIC_STOP_WINDOW;
    tr->why = RIC_WHY_TONGUE;
    return status ? status : ric_continuation_keep(tr, p);
}

/* ------------------------------------------------------------------- the step */

static void end_by(ric_continuation *tr, int test)
{
    static const ric_why edge[RIC_N_TEST] = {[RIC_TEST_E_MAX] = RIC_WHY_ENERGY_MAX,
                                             [RIC_TEST_E_MIN] = RIC_WHY_ENERGY_MIN,
                                             [RIC_TEST_F_MAX] = RIC_WHY_FREQUENCY_MAX,
                                             [RIC_TEST_F_MIN] = RIC_WHY_FREQUENCY_MIN};
    tr->stop = edge[test] ? RIC_STOP_WINDOW : RIC_STOP_JUNCTION;
    tr->why = edge[test];
}

/* Back at the orbit `home`, at the arclength s, going the same way as `heading` from there. */
static bool reaches(ric_continuation *tr, double h, const double *home, const double *heading,
                    double *s)
{
    int size = tr->chain->n_unknown;
    double along = 0, across = 0;
    for (int i = 0; i < size; i++) along += (home[i] - tr->now.u[i]) * tr->now.t[i];
    if (!(along > 0 && along <= h)) return false;
    for (int i = 0; i < size; i++) {
        double d = home[i] - tr->now.u[i] - along * tr->now.t[i];
        across += d * d;
    }
    if (sqrt(across) > ASIDE * h) return false;
    double distance = 0, first = along, most = SAME_PLACE * tr->chain->scale, *u = tr->mid.u;
    const double *t = tr->next.t;
    /* a branch point itself, as which many branches start: the cubic knows it */
    if (tr->now.test[RIC_TEST_DET] * tr->next.test[RIC_TEST_DET] < 0) {
        ric_event_cubic(tr, along, h, u);
        along = 0;
        for (int i = 0; i < size; i++) along += (home[i] - u[i]) * t[i];
        for (int i = 0; i < size; i++) u[i] += along * t[i];
        most = fmax(most, ON_CUBIC * h);
    } else {
        bool good = false;
        if (ric_event_solve(tr, along, h, RIC_LOOK_ALL, &tr->mid, &good) || !good) return false;
        t = tr->mid.t;
    }
    for (int i = 0; i < size; i++) distance = fmax(distance, fabs(u[i] - home[i]));
    if (!(distance < most && ric_dot(size, t, heading) > SAME_WAY)) return false;
    *s = tr->now.s + (tr->next.s - tr->now.s) * (first / h);
    return true;
}

/* Back at the start, at the arclength s; `home` [n_unknown] is the start once more. From a centre
 * to a rest under a power law an orbit shows its image x -> -x half a period on, which is the same
 * orbit: there the way round a closed branch may end with the other sign. */
static bool closes(ric_continuation *tr, double h, double *home, double *s)
{
    const ric_shooting *c = tr->chain;
    int size = c->n_unknown;
    double heading[size];
    if (tr->n_point < 8) return false;
    memcpy(home, tr->start_u, (size_t)size * sizeof *home);
    if (reaches(tr, h, home, tr->start_t, s)) return true;
    if (ric_periodic_has_events(c->model) || c->start != RIC_MIRROR_CENTRE ||
        c->end != RIC_MIRROR_REST)
        return false;
    for (int i = 0; i < size; i++) {
        double sign = i == c->n_start ? 1 : -1; /* the time, and states before and after it */
        home[i] = sign * tr->start_u[i];
        heading[i] = sign * tr->start_t[i];
    }
    return reaches(tr, h, home, heading, s);
}

/* Ends a closed branch with the point that it began with; what lies beyond was met at the start. */
static ric_status close_up(ric_continuation *tr, const double *home, double s)
{
    double slack = SAME_PLACE * tr->chain->scale;
    for (; tr->n_event > 0 && tr->events[tr->n_event - 1].s > s + slack; tr->n_event--) {
        free(tr->events[tr->n_event - 1].u);
        free(tr->events[tr->n_event - 1].t);
    }
    tr->stop = RIC_STOP_CLOSED;
    tr->why = RIC_WHY_CLOSED;
    memcpy(tr->mid.u, home, (size_t)tr->chain->n_unknown * sizeof *home);
    ric_status status = ric_continuation_fill(tr, s, &tr->mid);
    return status ? status : ric_continuation_keep(tr, &tr->mid);
}

typedef struct {
    int n, capacity;
    ric_event_root *root;
} root_list;

static void list_root(root_list *list, int test, double x)
{
    if (list->n < list->capacity) list->root[list->n++] = (ric_event_root){test, x};
}

/* Zeros of one test between the points that are known, up to distance `to`. A sign that rounding
 * hid at some of them has changed at the first one: as near as can be told. */
static ric_status find_zeros(ric_continuation *tr, int test, double to, double h, root_list *list,
                             bool *retry)
{
    const ric_event_samples *q = &tr->samples;
    if (q->n == q->now + 2 && ric_event_samples_values(tr, q->now)[test] *
                                      ric_event_samples_values(tr, q->now + 1)[test] >
                                  0)
        return RIC_OK; /* as nearly always */
    double last = test < RIC_N_TEST ? tr->definite[test] : tr->passed[test - RIC_N_TEST];
    double hidden = 0;
    for (int i = q->now; i < q->n && q->x[i] < to; i++) {
        double f = ric_event_samples_values(tr, i)[test], x;
        bool zero, open = last == 0;
        if (isnan(f)) {
            last = 0;
            continue;
        }
        if (f == 0) {
            if (i == q->now || ric_event_samples_values(tr, i - 1)[test] != 0) hidden = q->x[i];
            continue;
        }
        bool changed = last * f<0, seen = i> q->now &&
                       ric_event_samples_values(tr, i - 1)[test] != 0;
        last = f;
        if (!changed || open || i == q->now) continue;
        if (!seen) {
            list_root(list, test, hidden);
            continue;
        }
        double a = q->x[i - 1], b = q->x[i];
        ric_status status = ric_event_locate(tr, test, a, ric_event_samples_values(tr, i - 1)[test],
                                             b, f, h, &x, &zero);
        if (status) return status;
        /* the factors of the map may jump where rounding hides them; in a piece this short nothing
         * else can have happened. The place of a resonance is known well enough there: the junction
         * is solved anew */
        bool narrow = b - a < JUMP * tr->chain->scale;
        if (!zero && narrow && test < RIC_N_TEST && EVENT_SINGULAR & 1u << test) continue;
        if (!zero && narrow && test >= RIC_N_TEST &&
            fabs(ric_event_value(tr, test, &tr->mid)) > POLE)
            continue;
        if (!zero && !(narrow && test >= RIC_N_TEST)) {
            *retry = true;
            return RIC_OK;
        }
        list_root(list, test, x);
    }
    return RIC_OK;
}

static ric_status find_roots(ric_continuation *tr, unsigned which, double h, root_list *list,
                             bool *retry)
{
    for (int i = 0; i < RIC_N_TEST && !*retry; i++) {
        ric_status status = which & 1u << i ? find_zeros(tr, i, HUGE_VAL, h, list, retry) : RIC_OK;
        if (status) return status;
    }
    return RIC_OK;
}

/* Tests of `which` that are looked at in this step. Of those that vanish at the start the ones that
 * do not end a branch are looked at right behind it. */
static unsigned seen_in(const ric_continuation *tr, unsigned which)
{
    unsigned seen = 0, inside = EVENT_SINGULAR | EVENT_EXTREMA;
    for (int i = 0; i < RIC_N_TEST; i++) {
        bool ghost = tr->limits->ghost && free_of_ghosts & 1u << i;
        if (which & 1u << i &&
            (ric_event_watched(tr, i) || (inside & tr->ignore & 1u << i && !ghost)))
            seen |= 1u << i;
    }
    return seen;
}

/* Arranges for a short step with the crossing in its middle, and for no point close to one, where
 * all but the determinant is rounding; false when all is well, or no such step can be taken. */
static bool approach_crossing(ric_continuation *tr, double h)
{
    double x = crossing_ahead(tr, h), length = RIC_CROSSING * tr->chain->scale,
           step = fmax(2 * x, length / 2);
    if (x == HUGE_VAL || (h > SHORTER * step && h < LONGER * step && h < LONGEST * length) ||
        ++tr->approaches > APPROACHES)
        return false;
    tr->wanted = x > LATER * length ? fmin(x - length / 2, SOONER * h) : step;
    /* under a power law such a step is made shorter again, time after time, to this one; between
     * springs one in a thousand of these places is seen only as it is looked at again */
    if (ric_flight_law_of(tr->chain->model)->integrated && tr->wanted >= tr->too_long) {
        tr->approaches = APPROACHES;
        tr->wanted = 0;
        return false;
    }
    tr->after = length;
    return true;
}

/* Whether functions may have poles where this test vanishes: an impact loses its speed, or a
 * contact shrinks to nothing. */
static bool has_poles(int test)
{
    return test == RIC_TEST_REACH || test == RIC_TEST_APPROACH || test == RIC_TEST_FLIGHT;
}

/* Where a gap closes before the first zero of the other functions that end a branch. Behind an
 * impact that loses its speed the gap that opens before it leaves `reach` above 1 by the square of
 * the distance, which hides its zero in rounding; it is none, so that nothing is looked for behind
 * the others. A spring that opens as another one closes is such an end, and a touch as well: there
 * both are asked for. */
static ric_status find_reach(ric_continuation *tr, double h, root_list *list, bool *retry)
{
    double to = HUGE_VAL;
    bool good = false, springs = ric_flight_law_of(tr->chain->model)->closes;
    for (int i = 0; i < list->n; i++) to = fmin(to, list->root[i].x);
    if (to < HUGE_VAL && !springs) {
        ric_status status = ric_event_samples_insert(tr,
                                                     fmax(to - SHORT_OF * tr->chain->scale, to / 2),
                                                     h, &good);
        if (status) return status;
    }
    return find_zeros(tr, RIC_TEST_REACH, good ? to : HUGE_VAL, h, list, retry);
}

/* The first zero of the functions `which` that end a branch. */
static ric_status find_first(ric_continuation *tr, unsigned which, double h, ric_event_root *first,
                             bool *found, bool *retry)
{
    ric_event_root roots[RIC_MOST_SAMPLES];
    root_list list = {.capacity = RIC_MOST_SAMPLES, .root = roots};
    const unsigned reach = which & 1u << RIC_TEST_REACH;
    ric_status status = find_roots(tr, which & ~reach, h, &list, retry);
    if (!status && !*retry && reach) status = find_reach(tr, h, &list, retry);
    if ((*found = !status && !*retry && list.n)) {
        qsort(roots, (size_t)list.n, sizeof *roots, ric_event_by_place);
        *first = roots[0];
    }
    return status;
}

/* The far end of the branch, if one of the functions `which` that end it vanishes in this step: its
 * test, or -1, and its distance. The zero that is found tells whether there may be one before. */
static ric_status find_end(ric_continuation *tr, unsigned which, double h, int *test, double *end,
                           bool *retry)
{
    ric_event_root first = {-1, h};
    *test = -1;
    *end = h;
    which = seen_in(tr, which);
    ric_status status = ric_event_samples_refine(tr, which, false, NAN, NAN, h);
    if (!status) status = ric_event_samples_probe(tr, which, false, NULL, h);
    bool found = false;
    for (int pass = 0; pass < PASSES && !status; pass++) {
        status = find_first(tr, which, h, &first, &found, retry);
        if (status || *retry || !found) return status;
        const int before = ric_event_samples_changes(tr, which, false);
        status = ric_event_samples_probe(tr, which, false, &first, h);
        if (ric_event_samples_changes(tr, which, false) == before) break;
    }
    if (status) return status;
    *test = first.test;
    *end = first.x;
    const bool touch = *test == RIC_TEST_APPROACH && ric_flight_law_of(tr->chain->model)->closes;
    return touch && which & 1u << RIC_TEST_REACH
               ? ric_event_reach_beside(tr, NEAREST * tr->chain->scale, h, test, end)
               : RIC_OK;
}

/* The points of the step for what happens inside, up to distance `to`: where the branch ends there,
 * it is looked at a little before, and ever nearer if functions may have poles. */
static ric_status sample(ric_continuation *tr, unsigned which, int test, double to, double h)
{
    ric_event_samples *q = &tr->samples;
    double least = NEAREST * tr->chain->scale, from = NAN, end = NAN;
    const unsigned margins = 1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH | 1u << RIC_TEST_FLIGHT;
    bool pairs = tr->n_resonance > 0, poles = tr->ignore & margins;
    ric_status status = RIC_OK;
    if (test >= 0 && (status = ric_event_samples_cut(tr, fmax(to - least, to / 2), h)))
        return status;
    if (q->n < q->now + 2) return RIC_OK; /* nothing converges there */
    double last = q->x[q->n - 1];
    if (poles) {
        from = 0;
        status = ric_event_samples_approach(tr, 0, last, least, h);
        ric_event_samples_tell(tr, &tr->now, q->now + 1, tr->next.row.energy);
        for (int k = 0; k < ric_continuation_watched(tr); k++)
            ric_event_samples_values(tr, q->now)[k] = NAN;
    }
    if (!status && test >= 0 && has_poles(test)) {
        end = to;
        status = ric_event_samples_approach(tr, to, q->x[q->n - 2], least, h);
    }
    return status ? status : ric_event_samples_refine(tr, which, pairs, from, end, h);
}

/* The length on which some pair is lost in rounding; on the way to an end where functions have
 * poles this is no news nearer than NEAREST. */
static double lost_length(const ric_continuation *tr)
{
    const ric_event_samples *q = &tr->samples;
    double length = 0;
    for (int i = q->now; tr->n_resonance && i + 1 < q->n; i++) {
        bool lost = isnan(ric_event_samples_values(tr, i)[RIC_N_TEST]) ||
                    isnan(ric_event_samples_values(tr, i + 1)[RIC_N_TEST]);
        double piece = q->x[i + 1] - q->x[i];
        if (lost && piece > RATIO_NEAREST * NEAREST * tr->chain->scale) length += piece;
    }
    return length;
}

/* Whether the signs change as often as they did `before`, among n points. */
static bool as_before(const ric_continuation *tr, unsigned which, int n, int before)
{
    return tr->samples.n == n || ric_event_samples_changes(tr, which, true) == before;
}

/* Zeros of all that is looked at inside. Where one function vanishes the others are looked at, too:
 * they tell each other's ways. */
static ric_status find_inside(ric_continuation *tr, unsigned which, double h, root_list *list,
                              bool *retry)
{
    for (int pass = 0; pass < PASSES; pass++) {
        list->n = 0;
        ric_status status = find_roots(tr, which, h, list, retry);
        for (int k = 0; k < tr->n_resonance && !status && !*retry; k++)
            status = find_zeros(tr, RIC_N_TEST + k, HUGE_VAL, h, list, retry);
        const int before = ric_event_samples_changes(tr, which, true), n = tr->samples.n;
        for (int i = 0; i < list->n && !status && !*retry; i++)
            status = ric_event_samples_add(tr, list->root[i].x, h);
        if (!status && !*retry && list->n)
            status = ric_event_samples_refine(tr, which, tr->n_resonance > 0, NAN, NAN, h);
        if (!status && !*retry && as_before(tr, which, n, before))
            status = ric_event_samples_probe(tr, which, tr->n_resonance > 0, NULL, h);
        if (status || *retry || as_before(tr, which, n, before)) return status;
    }
    ric_event_samples_unresolved(tr);
    return RIC_OK;
}

static ric_status inner_events(ric_continuation *tr, double h, int test, double to, bool *retry)
{
    int most = RIC_N_TEST + tr->n_resonance + 4 * RIC_MOST_SAMPLES;
    ric_event_root roots[most + RIC_EVENT_STRETCHES * tr->limits->n_asked];
    root_list list = {.capacity = most, .root = roots};
    bool good;
    unsigned inner = seen_in(tr, ~EVENT_TERMINAL & ((1u << RIC_N_TEST) - 1));
    ric_status status = sample(tr, inner, test, to, h);
    *retry = tr->samples.n < tr->samples.now + 2;
    if (!status && !*retry) status = find_inside(tr, inner, h, &list, retry);
    for (int i = 0; i < list.n && !status && !*retry; i++) *retry = roots[i].test == RIC_TEST_DET;
    if (!status && !*retry) status = ric_event_asked_find(tr, true, to, h, roots, &list.n, retry);
    if (status || *retry) return status;
    double lost = lost_length(tr);
    if (lost > 0)
        ric_continuation_widen(tr->blind == 0, tr->now.row.energy, tr->next.row.energy,
                               tr->blind_at);
    tr->blind += lost;
    qsort(roots, (size_t)list.n, sizeof *roots, ric_event_by_place);
    for (int i = 0; i < list.n && !status; i++)
        if (!(status = ric_event_solve(tr, roots[i].x, h, RIC_LOOK_ALL, &tr->mid, &good)) &&
            !(status = ric_event_keep(tr, roots[i].test, &tr->mid)))
            status = ric_continuation_keep(tr, &tr->mid); /* a stored point, so that extremes of a
                                                             branch are among its points */
    return status;
}

/* The end as the last point. Read off cubics it may lie before the point with which the step over
 * it began: what is stored behind it belongs to the image of the branch. */
static ric_status keep_end(ric_continuation *tr)
{
    /* a stop gives points back, which nothing may have taken the place of */
    const ric_status whole = ric_trust(RIC_OK);
    if (whole) return whole;
    while (tr->n_point > 1) {
        const ric_point *last = ric_continuation_row(tr, tr->n_point - 1);
        if (!tr->mid.solved || last->arclength <= tr->mid.row.arclength) break;
        tr->n_point--;
    }
    return ric_continuation_keep(tr, &tr->mid);
}

/* What is stored of the end at distance x: an orbit beyond a touch is not, and the branch would end
 * a step before it. Where the place is known to less than counts as rounding it is one on the near
 * side. */
static ric_status near_side(ric_continuation *tr, double *x, double h)
{
    const double before = tr->now.test[RIC_TEST_REACH];
    bool good = true;
    for (int i = 0; i < SHORTENED && good && before > 0 && tr->mid.row.reach > 1 + RIC_MARGIN;
         i++) {
        const double beyond = tr->mid.row.reach - 1;
        *x -= 2 * *x * beyond / (before + beyond);
        ric_status status = ric_event_solve(tr, *x, h, RIC_LOOK_ALL, &tr->mid, &good);
        if (status) return status;
    }
    tr->mid.solved &= good;
    return RIC_OK;
}

/* The same of a corner. Where a spring closes beside an impact on a stop it loses its speed before
 * the two fall together if that impact, however slow, kicks it back: the last orbit that meets all
 * faces from the right side is stored. And of a touch at which an impact loses its speed, where the
 * place is one of the touch. */
static ric_status right_side(ric_continuation *tr, double x, double h)
{
    bool good = true;
    double meets = -1;
    ric_status status;
    if (!(tr->now.row.approach > 0) || !ric_continuation_goes_wrong(tr, &tr->mid)) return RIC_OK;
    ric_root r = ric_root_between(0, tr->now.row.approach, x, tr->mid.row.approach,
                                  RIC_LAST_DIGIT * h);
    while (good && ric_root_next(&r)) {
        if ((status = ric_event_solve(tr, r.x, h, RIC_LOOK_REACH, &tr->mid, &good))) return status;
        r.f = tr->mid.row.approach;
        if (good && r.f >= 0) meets = r.x;
    }
    if (!good || meets < 0) return RIC_OK;
    if ((status = ric_event_solve(tr, meets, h, RIC_LOOK_ALL, &tr->mid, &good))) return status;
    tr->mid.solved &= good;
    return RIC_OK;
}

/* The tests that end a branch whose places are solved for: a corner, or a touch, next to a branch
 * point is read off cubics with it, as close by nothing can be solved. */
static ric_status solved_ends(ric_continuation *tr, bool crossed, double h, unsigned *which)
{
    const double flight[2] = {tr->now.test[RIC_TEST_FLIGHT], tr->next.test[RIC_TEST_FLIGHT]};
    bool touches = false;
    *which = EVENT_TERMINAL;
    if (!crossed || tr->limits->ghost) return RIC_OK;
    if (flight[0] * flight[1] < 0) *which &= ~(1u << RIC_TEST_FLIGHT);
    const ric_status status = ric_event_cross_touches(tr, h, &touches);
    if (touches) *which &= ~(1u << RIC_TEST_REACH);
    return status;
}

ric_status ric_event_find(ric_continuation *tr, double h, bool *done, bool *retry)
{
    int test;
    double end;
    tr->solved.n = 0;
    bool good, crossed = tr->now.test[RIC_TEST_DET] * tr->next.test[RIC_TEST_DET] < 0 &&
                         ric_event_watched(tr, RIC_TEST_DET);
    if ((*retry = approach_crossing(tr, h))) return RIC_OK;
    double home[tr->chain->n_unknown], s;
    bool closed = closes(tr, h, home, &s);
    ric_event_samples_begin(tr, h);
    unsigned which;
    ric_status status = solved_ends(tr, crossed, h, &which);
    if (!status) status = find_end(tr, which, h, &test, &end, retry);
    if (status || *retry) return status;
    if (test >= 0 && crossed) {
        if ((status = ric_event_solve(tr, end, h, RIC_LOOK_ALL, &tr->mid, &good))) return status;
        crossed = tr->now.test[RIC_TEST_DET] * tr->mid.test[RIC_TEST_DET] < 0;
    }
    int read = -1; /* the end, read off cubics */
    if (crossed) status = ric_event_cross(tr, h, &read, &end, retry);
    else status = inner_events(tr, h, test, end, retry);
    if (!status && !*retry && !crossed && test == RIC_TEST_FLIGHT && !tr->limits->ghost)
        status = ric_event_cross_corner(tr, h, &read, &end);
    if (status || *retry) return status;
    if (test < 0 && !closed && read < 0) return RIC_OK;
    *done = true;
    if (read >= 0) {
        test = read;
        tr->arrival = read == RIC_TEST_DET;
        end_by(tr, test);
        if (tr->arrival && (status = ric_symmetric_end_settle(tr->chain, tr->mid.u))) return status;
        if ((status = ric_continuation_fill(tr, tr->mid.s, &tr->mid))) return status;
        tr->mid.row.stable = RIC_STABLE_UNDECIDED; /* two branches meet there */
    } else if (test < 0) {
        return close_up(tr, home, s);
    } else {
        if ((status = ric_event_solve(tr, end, h, RIC_LOOK_ALL, &tr->mid, &good))) return status;
        tr->mid.solved &= good;
        if (good && has_poles(test) && !crossed)
            ric_event_samples_tell(tr, &tr->mid, tr->samples.n - 1, tr->mid.row.energy);
        end_by(tr, test);
    }
    if ((status = fill_event(tr, test, &tr->mid, &tr->end))) return status;
    if (test == RIC_TEST_REACH && read < 0 && tr->mid.solved && (status = near_side(tr, &end, h)))
        return status;
    if ((test == RIC_TEST_FLIGHT || test == RIC_TEST_REACH) && read < 0 && tr->mid.solved &&
        (status = right_side(tr, end, h)))
        return status;
    return keep_end(tr);
}
