/* From an atlas to the response of the shaken structure: curves from the predictions of first order and from the linear
 * motion, and from what they meet, task by task. Each task is done or not done in the file, so the order is always the
 * same. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "response.h"
#include "response_word.h"

#define SAME 1e-6     /* relative: two orbits that were solved to rounding and located */
#define BLURRED 1e-3  /* relative: two orbits at branch points */
#define NO_SPEED 1e-6 /* scaled: of an impact whose multipliers are infinite */

enum {
    STARTS = 3,    /* of a run of stored orbits above the threshold */
    SETS_MOST = 4, /* touches of a grazing of which all sets are tried */
    KEY_MAX = 96
};

typedef struct {
    const ric_atlas *atlas;
    ric_force *force;
    ric_force_medium *medium;
    ric_response *r;
    ric_response_file *file;
    ric_response_trace_options trace;
    double level;   /* of the curves that are looked for, physical */
    bool own_image; /* the event that is left is an orbit that x -> -x maps to itself */
} driver;

/* --------------------------------------------------------------------- rows */

static bool row_from(driver *d, ric_force_orbit *o, const ric_response_orbit *at, ric_response_row *row,
                     ric_status *status)
{
    const int n = o->n, letters = o->events ? o->N : 0;
    const double t = d->medium->time;
    *row = (ric_response_row){0};
    if (!(row->numbers = ric_calloc(ric_response_numbers(n, letters), sizeof *row->numbers))) {
        *status = ric_no_memory("a response");
        return false;
    }
    ric_response_row_arrange(row, n, letters);
    double *state = row->numbers, *flights = state + 2 * n, *multipliers = flights + (letters ? letters : 1);
    ric_force_measures measures = {.peak = multipliers + 4 * n, .rms = multipliers + 5 * n};
    ric_response_trace_put(at, o);
    ric_force_motion_leave(d->medium, o->u, state);
    flights[0] = ric_force_orbit_period(o) / t;
    for (int k = 0; k < letters; k++) flights[k] = ric_force_orbit_tau(o, k) / t;
    memcpy(multipliers, at->multipliers, 4 * (size_t)n * sizeof *multipliers);
    if ((*status = ric_force_motion_measure(o, &measures))) {
        free(row->numbers);
        return false;
    }
    ric_response_point *p = &row->data;
    p->arclength = at->arclength;
    p->omega = o->drive.omega * t;
    p->level = o->drive.level;
    p->restitution = o->drive.restitution;
    p->period = ric_force_orbit_period(o) / t;
    p->phase = remainder(ric_force_orbit_theta(o, 0), RIC_TWO_PI);
    p->residual = at->residual;
    p->largest = at->largest;
    p->stable = at->stable;
    if (measures.approach < NO_SPEED) {
        for (int i = 0; i < 4 * n; i++) multipliers[i] = NAN;
        p->largest = NAN;
        p->stable = RIC_STABLE_UNDECIDED;
    }
    p->reach = measures.reach;
    p->approach = measures.approach * t;
    return true;
}

/* The orbit of a row, with the word of its curve; its states after other events are flown. NULL: it cannot be. */
static ric_force_orbit *orbit_from(driver *d, const ric_response_line *line, const ric_response_row *row)
{
    const int n = d->medium->n, letters = line->data.letters,
              N = letters             ? letters
                  : d->medium->smooth ? 4
                                      : 1,
              faces = d->medium->model->n_face;
    int face[N];
    uint64_t closed[N], now = 0;
    ric_force_orbit *o;
    for (int k = 0; k < 2 * letters; k++) { /* twice round: what is closed at the start is known then */
        const int letter = line->word[k % letters], f = letter % faces;
        if (!ric_force_medium_rigid(d->medium, f))
            now = letter >= faces ? now & ~((uint64_t)1 << f) : now | (uint64_t)1 << f;
        face[k % letters] = f;
        closed[k % letters] = now;
    }
    if (!letters) memset(closed, 0, sizeof closed);
    if (ric_force_orbit_create(d->medium, N, letters ? face : NULL, closed, line->data.harmonic, &o)) return NULL;
    o->drive = (ric_force_drive){row->data.omega / d->medium->time, row->data.level, row->data.restitution};
    ric_force_motion_enter(d->medium, row->data.state, o->u);
    for (int k = 0; k < N; k++)
        ric_force_orbit_node(o, k)[2 * n + 1] = letters ? row->data.flights[k] * d->medium->time
                                                        : ric_force_orbit_period(o) / N;
    o->u[2 * n] = letters ? row->data.phase : 0;
    if (!ric_force_orbit_spread(o)) return o;
    ric_force_orbit_free(o);
    return NULL;
}

static int *word_from(const ric_force_orbit *o)
{
    int *word = ric_calloc((size_t)o->N + 1, sizeof *word);
    for (int k = 0; word && k < o->N && o->events; k++) {
        const bool opens = !ric_force_medium_rigid(o->medium, o->face[k]) && !(o->closed[k] >> o->face[k] & 1);
        word[k] = o->face[k] + (opens ? o->medium->model->n_face : 0);
    }
    return word;
}

static int impacts_of(const ric_force_orbit *o)
{
    int count = 0;
    for (int k = 0; k < o->N && o->events; k++)
        count += ric_force_medium_rigid(o->medium, o->face[k]) || (o->closed[k] >> o->face[k] & 1);
    return count;
}

/* ----------------------------------------------------------- the same orbit */

/* Whether both are one motion at one parameter, or mirror images: their states at one phase of the force. */
static bool same_motion(const driver *d, const ric_force_orbit *a, const ric_force_orbit *b, double near)
{
    const int size = 2 * a->n, images = ric_model_symmetric(d->medium->model) ? 2 : 1;
    double z[size], x[size];
    if (a->harmonic != b->harmonic || ric_force_motion_strobe(a, 0, z)) return false;
    for (int i = 0; i < images; i++)
        for (int k = 0; k < b->harmonic; k++) {
            double most = 0, length = 1;
            if (ric_force_motion_strobe(b, RIC_TWO_PI * k + (i ? RIC_PI : 0), x)) return false;
            for (int j = 0; j < size; j++) {
                most = fmax(most, fabs(z[j] - (i ? -x[j] : x[j])));
                length = fmax(length, 1 + fabs(z[j]));
            }
            if (most < near * length) return true;
        }
    return false;
}

/* Whether a motion of several periods of the force repeats itself earlier: it is one of fewer, traversed more than
 * once, as the predictions beside duplicates lead to. */
static bool repeats(const ric_force_orbit *o)
{
    const int size = 2 * o->n;
    double z[size], x[size];
    if (o->harmonic < 2 || ric_force_motion_strobe(o, 0, z)) return false;
    for (int k = 1; 2 * k <= o->harmonic; k++) {
        double most = 0, length = 1;
        if (o->harmonic % k || ric_force_motion_strobe(o, RIC_TWO_PI * k, x)) continue;
        for (int j = 0; j < size; j++) {
            most = fmax(most, fabs(z[j] - x[j]));
            length = fmax(length, 1 + fabs(z[j]));
        }
        if (most < SAME * length) return true;
    }
    return false;
}

static double value_of(const driver *d, const ric_response_point *p)
{
    return d->trace.along == RIC_ALONG_OMEGA   ? p->omega / d->medium->time
           : d->trace.along == RIC_ALONG_LEVEL ? p->level
                                               : p->restitution;
}

/* Whether the orbit o lies between two neighbouring rows: the one there is solved for. */
static bool between(driver *d, const ric_response_line *line, int i, const ric_force_orbit *o, double value)
{
    const ric_response_row *a = &line->points[i], *b = &line->points[i + 1];
    const double from = value_of(d, &a->data), to = value_of(d, &b->data), part = (value - from) / (to - from);
    if (!(part >= 0 && part <= 1)) return false;
    ric_force_orbit *x = orbit_from(d, line, a), *y = orbit_from(d, line, b);
    bool same = false;
    if (x && y) {
        for (int k = 0; k < x->N * x->m; k++) {
            const double off = y->u[k] - x->u[k];
            x->u[k] += part * (k % x->m == 2 * x->n ? remainder(off, RIC_TWO_PI) : off);
        }
        x->drive = o->drive;
        same = ric_force_orbit_solve(x, d->trace.along, d->trace.scale, NULL, 0, NULL) && same_motion(d, o, x, SAME);
    }
    ric_force_orbit_free(x);
    ric_force_orbit_free(y);
    return same;
}

/* The curve that an orbit lies on already, 0: none. */
static int known_curve(driver *d, ric_force_orbit *o)
{
    const double value = *ric_force_orbit_parameter(o, d->trace.along);
    const int letters = o->events ? o->N : 0;
    for (int c = 0; c < d->r->n_curve; c++) {
        const ric_response_line *line = &d->r->curves[c];
        if (line->data.letters != letters || line->data.harmonic != o->harmonic) continue;
        if (d->trace.along != RIC_ALONG_LEVEL && line->data.level != o->drive.level) continue;
        for (int i = 0; i + 1 < line->data.n_point; i++)
            if (between(d, line, i, o, value)) return c + 1;
    }
    return 0;
}

/* The grazing that is this orbit, 0: none. */
static int known_event(driver *d, ric_force_orbit *o)
{
    int found = 0;
    for (int i = 0; i < d->r->n_event && !found; i++) {
        const ric_response_mark *e = &d->r->events[i];
        const double mine = *ric_force_orbit_parameter(o, d->trace.along), other = value_of(d, &e->data.at);
        if (e->data.kind != RIC_RESPONSE_GRAZING || !(fabs(mine - other) < SAME * (1 + fabs(mine)))) continue;
        ric_force_orbit *x = orbit_from(d, &d->r->curves[e->data.curve - 1], &e->row);
        if (x && x->drive.level == o->drive.level && same_motion(d, o, x, SAME)) found = e->data.id;
        ric_force_orbit_free(x);
    }
    return found;
}

/* Whether an orbit, of a curve that leaves events of this kind, is the one of such an event: there it is known to the
 * third root of rounding only. */
static bool at_event(driver *d, ric_force_orbit *o, const ric_response_mark *e)
{
    const ric_response_line *line = &d->r->curves[e->data.curve - 1];
    const int copies = e->data.kind == RIC_RESPONSE_DOUBLING ? 2 : 1;
    if (e->data.kind != RIC_RESPONSE_DOUBLING && e->data.kind != RIC_RESPONSE_BRANCH_POINT) return false;
    if (line->data.harmonic * copies != o->harmonic) return false;
    if (!(fabs(value_of(d, &e->data.at) / *ric_force_orbit_parameter(o, d->trace.along) - 1) < SAME)) return false;
    ric_force_orbit *once = orbit_from(d, line, &e->row), *x = once ? ric_response_word_repeat(once, copies) : NULL;
    const bool same = x && x->drive.level == o->drive.level && same_motion(d, o, x, BLURRED);
    ric_force_orbit_free(once);
    ric_force_orbit_free(x);
    return same;
}

/* The branch point or doubling at which this orbit of a trace arrives, 0: none that is known. */
static int arrival(driver *d, const ric_response_trace *t, const ric_response_orbit *at)
{
    ric_response_trace_put(at, t->shape);
    for (int i = 0; i < d->r->n_event; i++)
        if (at_event(d, t->shape, &d->r->events[i])) return d->r->events[i].data.id;
    return 0;
}

/* ------------------------------------------------------------------- keeping */

static ric_status keep_events(driver *d, ric_response_trace *t, ric_response_curve *c)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < t->n_event && !status; i++) {
        const ric_response_trace_event *e = &t->events[i];
        ric_response_row row;
        ric_response_trace_put(&e->at, t->shape);
        int id = e->kind == RIC_RESPONSE_GRAZING ? known_event(d, t->shape) : 0;
        if (!id) {
            const ric_response_event event = {.curve = c->id, .kind = e->kind};
            if (!row_from(d, t->shape, &e->at, &row, &status)) break;
            if (!ric_response_add_event(d->r, &event, &row)) {
                free(row.numbers);
                return ric_no_memory("a response");
            }
            id = d->r->n_event;
        }
        if (e->kind != RIC_RESPONSE_GRAZING) continue;
        if (e->at.arclength < 0 || (e->at.arclength == 0 && i == 0)) c->from = id;
        else c->to = id;
    }
    return status;
}

/* Takes the trace. from: the event that it begins at, 0: none. */
static ric_status keep(driver *d, ric_response_trace *t, int branch, int from)
{
    ric_status status = t->status;
    int *word = status ? NULL : word_from(t->shape);
    ric_response_curve data = {.letters = t->shape->events ? t->shape->N : 0,
                               .impacts = impacts_of(t->shape),
                               .harmonic = t->shape->harmonic,
                               .level = d->trace.along == RIC_ALONG_LEVEL ? NAN : t->shape->drive.level,
                               .branch = branch,
                               .from = from,
                               .begin = from ? RIC_RESPONSE_JOINS : t->other,
                               .end = t->stop};
    if (!status && t->stop == RIC_RESPONSE_JOINS) data.to = arrival(d, t, &t->points[t->n_point - 1]);
    if (!status && !from && t->other == RIC_RESPONSE_JOINS) data.from = arrival(d, t, &t->points[0]);
    ric_response_line *line = word ? ric_response_add_curve(d->r, &data, word) : NULL;
    if (!status && !line) status = ric_no_memory("a response");
    for (int i = 0; line && i < t->n_point && !status; i++) {
        ric_response_row row;
        if (!row_from(d, t->shape, &t->points[i], &row, &status)) break;
        if (ric_response_add_point(line, &row)) continue;
        free(row.numbers);
        status = ric_no_memory("a response");
    }
    if (!status) status = keep_events(d, t, &line->data);
    ric_response_trace_free(t);
    return status;
}

/* Follows the curve of a solved orbit, which it takes. direction: NULL both ways. */
static ric_status follow(driver *d, ric_force_orbit *o, const double *direction, int branch, int from)
{
    const int m = o->m;
    double along[m + 1];
    memset(along, 0, sizeof along);
    along[m] = 1;
    if (d->r->n_curve >= d->r->asked.curves) {
        ric_force_orbit_free(o);
        return RIC_OK;
    }
    ric_response_trace *t = ric_response_trace_run(o, &d->trace, direction ? direction : along, !direction);
    if (!t) return ric_no_memory("a response");
    if (t->n_point == 0) {
        const ric_status status = t->status;
        ric_response_trace_free(t);
        return status;
    }
    return keep(d, t, branch, from);
}

/* A solved start: followed if it is a motion, and new. */
static ric_status take_start(driver *d, ric_force_orbit *o, int branch, bool *taken)
{
    double margin;
    ric_status status = ric_response_trace_margin(o, &margin);
    const double value = *ric_force_orbit_parameter(o, d->trace.along);
    *taken = !status && margin > 0 && value >= d->trace.window[0] && value <= d->trace.window[1];
    if (*taken && !repeats(o) && !known_curve(d, o)) return follow(d, o, NULL, branch, 0);
    ric_force_orbit_free(o);
    return status;
}

/* ------------------------------------------------------------------- starts */

/* Errors of a start, as a resonance, are no reason to stop; they are counted, and the first one is kept. */
static ric_status forgive(driver *d, ric_status status)
{
    if (status != RIC_E_NUMERIC) return status;
    d->r->n_skipped++;
    if (!d->r->skipped) d->r->skipped = ric_strdup(ric_detail());
    return d->r->skipped ? RIC_OK : ric_no_memory("a response");
}

/* Whether the structure has a steady answer with the springs of each flight: Newton's method would only say that it
 * does not converge. */
static ric_status answers(const driver *d, const ric_force_orbit *o)
{
    const ric_force_frame *frame;
    ric_status status = RIC_OK;
    for (int k = 0; k < o->N && !status && !d->medium->smooth; k++)
        status = ric_force_frame_find(d->medium, o->closed[k], o->drive.omega, &frame);
    return status;
}

static ric_status start_linear(driver *d)
{
    ric_force_orbit *o = NULL;
    bool taken;
    ric_status status = RIC_OK;
    for (int end = 0; end < 2 && !status; end++) {
        double omega = d->r->asked.omega / d->medium->time, level = d->level;
        if (d->trace.along == RIC_ALONG_OMEGA) omega = d->trace.window[end];
        if (d->trace.along == RIC_ALONG_LEVEL) level = d->trace.window[end];
        status = forgive(d, ric_force_start_linear(d->medium, omega, level, &o));
        if (!o) continue;
        const ric_status resonant = answers(d, o);
        if (!status) status = forgive(d, resonant);
        if (d->trace.along == RIC_ALONG_RESTITUTION) o->drive.restitution = d->trace.window[end];
        if (!status && !resonant && ric_force_orbit_solve(o, d->trace.along, d->trace.scale, NULL, 0, NULL))
            status = take_start(d, o, 0, &taken);
        else ric_force_orbit_free(o);
        o = NULL;
    }
    return status;
}

/* Both phases at one orbit of the atlas; *taken: one of them was found. */
static ric_status start_beside(driver *d, int branch, const ric_orbit *orbit, int harmonic, double level, bool *taken)
{
    ric_prediction p;
    ric_status status = ric_force_predict(d->force, branch, orbit, harmonic, level, &p);
    *taken = false;
    for (int k = 0; k < p.n_phase && !status; k++) {
        ric_force_orbit *o = NULL;
        bool one = false;
        ric_status possible = ric_force_start_from(d->medium, orbit, harmonic, level, p.phases[k], &o);
        if (!possible) possible = answers(d, o);
        status = forgive(d, possible);
        if (o && !possible && ric_force_start_settle(o)) status = forgive(d, take_start(d, o, branch, &one));
        else ric_force_orbit_free(o);
        *taken = *taken || one;
    }
    return status;
}

/* How good a start an orbit is: lower is better, NaN is none. */
static double merit(driver *d, int branch, const ric_orbit *orbit, int harmonic)
{
    ric_prediction p;
    if (ric_force_predict(d->force, branch, orbit, harmonic, 0, &p)) return NAN;
    const double omega = p.omega / d->medium->time;
    if (!(p.threshold < d->level) || omega < d->trace.window[0] || omega > d->trace.window[1]) return NAN;
    return p.threshold / d->level + (p.trusted ? 0 : 1);
}

/* Of a run of stored orbits [from, to] above the threshold: at its best place, then towards its ends. */
static ric_status start_run(driver *d, int branch, int harmonic, int from, int to, const double *merits)
{
    int best = from;
    ric_status status = RIC_OK;
    for (int i = from; i <= to; i++)
        if (merits[i] < merits[best]) best = i;
    const int places[STARTS] = {best, (best + to) / 2, (best + from) / 2};
    bool taken = false;
    for (int k = 0; k < STARTS && !status && !taken; k++) {
        ric_orbit **orbits = NULL;
        int n = 0;
        if (k > 0 && places[k] == best) continue;
        status = ric_orbit_find(d->atlas, branch, RIC_AT_POINT, places[k], &n, &orbits);
        if (!status && n > 0) status = start_beside(d, branch, orbits[0], harmonic, d->level, &taken);
        ric_orbits_free(n, orbits);
    }
    return status;
}

static ric_status along_omega(driver *d, const ric_branch *b, int harmonic)
{
    double *merits = ric_calloc((size_t)b->n_point + 2, sizeof *merits);
    ric_status status = merits ? RIC_OK : ric_no_memory("a response");
    int from = -1;
    for (int i = 0; i < b->n_point && !status; i++) {
        ric_orbit **orbits = NULL;
        int n = 0;
        ric_point point;
        merits[i] = NAN;
        if (ric_atlas_point(d->atlas, b->id, i, &point, NULL, NULL) || !(point.energy > 0)) continue;
        status = ric_orbit_find(d->atlas, b->id, RIC_AT_POINT, i, &n, &orbits);
        if (!status && n > 0) merits[i] = merit(d, b->id, orbits[0], harmonic);
        ric_orbits_free(n, orbits);
    }
    for (int i = 0; i <= b->n_point && !status; i++) {
        const bool good = i < b->n_point && !isnan(merits[i]);
        if (good && from < 0) from = i;
        if (good || from < 0) continue;
        status = start_run(d, b->id, harmonic, from, i - 1, merits);
        from = -1;
    }
    free(merits);
    return status;
}

/* At one frequency: twice the threshold where the level varies. */
static ric_status at_omega(driver *d, const ric_branch *b, int harmonic)
{
    ric_orbit **orbits = NULL;
    int n = 0;
    ric_prediction p;
    bool taken;
    ric_status status = ric_orbit_find(d->atlas, b->id, RIC_AT_FREQUENCY, d->r->asked.omega / harmonic, &n, &orbits);
    for (int i = 0; i < n && !status; i++) {
        double level = d->level;
        status = ric_force_predict(d->force, b->id, orbits[i], harmonic, 0, &p);
        if (!status && d->trace.along == RIC_ALONG_LEVEL)
            level = fmin(2 * p.threshold, (p.threshold + d->trace.window[1]) / 2);
        if (!status && isfinite(level)) status = start_beside(d, b->id, orbits[i], harmonic, level, &taken);
    }
    ric_orbits_free(n, orbits);
    return status == RIC_E_RANGE ? RIC_OK : status;
}

/* --------------------------------------------------------------- departures */

static bool mute(const driver *d, int curve, int event)
{
    const ric_response_curve *c = &d->r->curves[curve].data;
    return c->from == event || c->to == event;
}

/* Whether a is b from letter `turn` on, or, mirrored, with all faces exchanged for those on the other side. */
static bool same_word(const ric_model *m, int letters, const int *a, const int *b, int turn, bool mirrored)
{
    for (int i = 0; i < letters; i++) {
        const int letter = b[(i + turn) % letters], f = letter % m->n_face, image = mirrored ? m->face[f].mirror : f;
        if (image < 0 || a[i] != image + (letter - f)) return false;
    }
    return true;
}

/* Whether a curve with this word leaves the event already, whatever letter it begins with, or its mirror image does. */
static bool has_left(const driver *d, const ric_force_orbit *o, int event)
{
    int *word = word_from(o);
    const int letters = o->events ? o->N : 0;
    bool found = false;
    for (int c = 0; word && c < d->r->n_curve && !found; c++) {
        const ric_response_curve *other = &d->r->curves[c].data;
        if (!mute(d, c, event) || other->letters != letters || other->harmonic != o->harmonic) continue;
        found = letters == 0;
        for (int turn = 0; turn < letters && !found; turn++)
            for (int image = 0; image <= d->own_image && !found; image++)
                found = same_word(d->medium->model, letters, word, d->r->curves[c].word, turn, image);
    }
    free(word);
    return found;
}

/* Takes o. */
static ric_status depart(driver *d, ric_force_orbit *o, const double *direction, int branch, int event)
{
    if (!o) return RIC_OK;
    if (impacts_of(o) > d->r->asked.impacts || has_left(d, o, event) || repeats(o) || known_curve(d, o)) {
        ric_force_orbit_free(o);
        return RIC_OK;
    }
    return follow(d, o, direction, branch, event);
}

static ric_status leave_grazing(driver *d, ric_force_orbit *o, int branch, int event)
{
    ric_response_touch touches[RIC_TOUCHES_MOST];
    int n;
    double direction[o->m + 1];
    ric_status status = ric_response_word_touches(o, touches, &n);
    for (unsigned set = 0; n > 0 && n <= SETS_MOST && set < 1u << n && !status; set++) {
        ric_force_orbit *x = ric_response_word_change(o, &d->trace, n, touches, set, direction);
        status = forgive(d, depart(d, x, direction, branch, event));
    }
    return status;
}

/* Motions of several periods of the one that grazes, with the impact in one of them only: near a grazing these begin,
 * too, and beside a resonance of the force with the free motion they are the ones that are stable (Nordmark,
 * Nonlinearity 14 (2001); Ghosh and Simpson, arXiv 2510.16218). */
static ric_status leave_grazing_once(driver *d, const ric_force_orbit *o, int branch, int event)
{
    ric_response_touch touches[RIC_TOUCHES_MOST];
    int n = 0;
    double direction[o->m + 1];
    ric_status status = RIC_OK;
    for (int copies = 2; copies <= d->r->asked.once_in && copies * o->harmonic <= d->r->asked.periods && !status;
         copies++) {
        ric_force_orbit *longer = ric_response_word_repeat(o, copies);
        status = longer ? ric_response_word_touches(longer, touches, &n) : ric_no_memory("a response");
        for (int i = 0; i < n / copies && !status; i++) {
            ric_force_orbit *x = ric_response_word_change(longer, &d->trace, n, touches, 1u << i, direction);
            status = forgive(d, depart(d, x, direction, branch, event));
        }
        ric_force_orbit_free(longer);
    }
    return status;
}

/* Direction [m + 1] of the curve at an event of it: from the row before to the one behind. At the event itself the
 * equations have two. */
static bool secant(driver *d, const ric_response_mark *e, double *out)
{
    const ric_response_line *line = &d->r->curves[e->data.curve - 1];
    int i = 0;
    while (i + 2 < line->data.n_point && line->points[i + 1].data.arclength < e->data.at.arclength) i++;
    if (line->data.n_point < 2) return false;
    ric_force_orbit *x = orbit_from(d, line, &line->points[i]), *y = orbit_from(d, line, &line->points[i + 1]);
    const bool found = x && y;
    double length = 0;
    const int m = found ? x->m : 0;
    for (int k = 0; k < m; k++) {
        const double off = y->u[k] - x->u[k];
        out[k] = k == 2 * x->n ? remainder(off, RIC_TWO_PI) : off;
    }
    out[m] = (value_of(d, &line->points[i + 1].data) - value_of(d, &line->points[i].data)) / d->trace.scale;
    for (int k = 0; k <= m; k++) length += out[k] * out[k];
    for (int k = 0; k <= m; k++) out[k] /= sqrt(length);
    ric_force_orbit_free(x);
    ric_force_orbit_free(y);
    return found && length > 0;
}

/* Whether a curve that left another event, or began beside an orbit of the atlas, has come to this one. */
static bool reached(driver *d, const ric_response_mark *event)
{
    bool found = false;
    for (int i = 0; i < d->r->n_curve && !found; i++) {
        const ric_response_line *line = &d->r->curves[i];
        for (int end = 0; end < 2 && !found && line->data.n_point > 0; end++) {
            const bool joins = end ? line->data.end == RIC_RESPONSE_JOINS
                                   : line->data.begin == RIC_RESPONSE_JOINS && !line->data.from;
            ric_force_orbit *x = joins ? orbit_from(d, line, &line->points[end ? line->data.n_point - 1 : 0]) : NULL;
            found = (end ? line->data.to : line->data.from) == event->data.id || (x && at_event(d, x, event));
            ric_force_orbit_free(x);
        }
    }
    return found;
}

static ric_status leave_aside(driver *d, ric_force_orbit *o, int branch, int event, ric_response_kind kind)
{
    const int m = o->m, copies = kind == RIC_RESPONSE_DOUBLING ? 2 : 1,
              sides = copies == 2 || ric_model_symmetric(d->medium->model) ? 1 : 2;
    double row[m + 1], direction[m + 1];
    ric_status status = RIC_OK;
    if (o->harmonic * copies > d->r->asked.periods || impacts_of(o) * copies > d->r->asked.impacts ||
        reached(d, &d->r->events[event - 1]) || !secant(d, &d->r->events[event - 1], row))
        return RIC_OK;
    for (int side = 0; side < sides && !status; side++) {
        ric_force_orbit *x = ric_response_word_aside(o, &d->trace, row, copies, side ? -1 : 1, direction);
        if (x && !known_curve(d, x)) status = forgive(d, follow(d, x, direction, branch, event));
        else ric_force_orbit_free(x);
    }
    return status;
}

static bool own_image(const driver *d, const ric_force_orbit *o)
{
    const int size = 2 * o->n;
    double z[size], x[size], most = 0, length = 1;
    if (!ric_model_symmetric(d->medium->model)) return false;
    if (ric_force_motion_strobe(o, 0, z) || ric_force_motion_strobe(o, RIC_PI, x)) return false;
    for (int j = 0; j < size; j++) {
        most = fmax(most, fabs(z[j] + x[j]));
        length = fmax(length, 1 + fabs(z[j]));
    }
    return most < SAME * length;
}

static ric_status leave(driver *d, int event)
{
    const ric_response_mark *e = &d->r->events[event - 1];
    const ric_response_kind kind = e->data.kind;
    const int branch = d->r->curves[e->data.curve - 1].data.branch;
    ric_force_orbit *o = orbit_from(d, &d->r->curves[e->data.curve - 1], &e->row);
    ric_status status = RIC_OK;
    if (!o) return ric_trust(RIC_OK);
    d->own_image = own_image(d, o);
    if (kind == RIC_RESPONSE_GRAZING) status = leave_grazing(d, o, branch, event);
    if (kind == RIC_RESPONSE_GRAZING && !status) status = leave_grazing_once(d, o, branch, event);
    if (kind == RIC_RESPONSE_BRANCH_POINT || kind == RIC_RESPONSE_DOUBLING)
        status = leave_aside(d, o, branch, event, kind);
    ric_force_orbit_free(o);
    return status;
}

/* -------------------------------------------------------------------- tasks */

static ric_status done(driver *d, const char *key, int curve, int event)
{
    ric_status status = ric_trust(RIC_OK);
    if (!status) status = ric_response_store_put(d->file, d->r, curve, event, key);
    if (!status && !ric_response_add_task(d->r, key)) status = ric_no_memory("a response");
    return status;
}

static ric_status start_all(driver *d, int place)
{
    const ric_response_options *a = &d->r->asked;
    char key[KEY_MAX];
    ric_branch b;
    ric_status status = RIC_OK;
    const int first = a->branch ? a->branch : 0, last = a->branch ? a->branch : ric_atlas_n_branch(d->atlas);
    for (int id = first; id <= last && !status; id++)
        for (int h = 0; h < (id ? a->n_harmonic : 1) && !status; h++) {
            const int curve = d->r->n_curve + 1, event = d->r->n_event + 1;
            if (id) status = ric_atlas_branch(d->atlas, id, &b);
            snprintf(key, sizeof key, "level %d branch %s harmonic %d", place, id && !status ? b.key : "-",
                     id ? a->harmonics[h] : 1);
            if (status || ric_response_did(d->r, key)) continue;
            if (id == 0) status = start_linear(d);
            const bool moves = id && !status && !(b.letters == 0 && d->medium->model->n_face);
            if (id && a->branch && !status && !moves)
                status = forgive(d, ric_fail(RIC_E_NUMERIC,
                                             "branch %d is a linear mode, which meets no stop: its forced motion is "
                                             "that of the linear structure, which is followed where no branch is named",
                                             id));
            if (moves)
                status = a->along == RIC_RESPONSE_OMEGA ? along_omega(d, &b, a->harmonics[h])
                                                        : at_omega(d, &b, a->harmonics[h]);
            if (!status) status = done(d, key, curve, event);
        }
    return status;
}

static ric_status leave_all(driver *d)
{
    char key[KEY_MAX];
    ric_status status = RIC_OK;
    for (int id = 1; id <= d->r->n_event && !status; id++) {
        const int curve = d->r->n_curve + 1, event = d->r->n_event + 1;
        snprintf(key, sizeof key, "event %d", id);
        if (ric_response_did(d->r, key)) continue;
        status = leave(d, id);
        if (!status) status = done(d, key, curve, event);
    }
    return status;
}

/* ---------------------------------------------------------------------- call */

static ric_status check(const ric_response_options *o)
{
    const double *w = o->window;
    if (!(isfinite(w[0]) && isfinite(w[1]) && w[0] > 0 && w[1] > w[0]))
        return ric_fail(RIC_E_INPUT, "the window is %.10g to %.10g; give two numbers above 0, the smaller one first",
                        w[0], w[1]);
    if (o->along == RIC_RESPONSE_RESTITUTION && !(w[1] <= 1))
        return ric_fail(RIC_E_INPUT, "the window of the restitution is %.10g to %.10g; it is at most 1", w[0], w[1]);
    if (o->along != RIC_RESPONSE_OMEGA && !(o->omega > 0 && isfinite(o->omega)))
        return ric_fail(RIC_E_INPUT, "the frequency of the force is missing; give it in rad/s");
    if (o->along != RIC_RESPONSE_LEVEL && o->n_level < 1)
        return ric_fail(RIC_E_INPUT, "the level of the force is missing; give one or several");
    for (int i = 0; i < o->n_level && o->along != RIC_RESPONSE_LEVEL; i++)
        if (!(o->levels[i] > 0 && isfinite(o->levels[i])))
            return ric_fail(RIC_E_INPUT, "level %.10g; a level is an amplitude of the force, above 0", o->levels[i]);
    for (int i = 0; i < o->n_harmonic; i++)
        if (o->harmonics[i] < 1)
            return ric_fail(RIC_E_INPUT, "harmonic %d; harmonics are 1, 2, 3, ...", o->harmonics[i]);
    if (!(o->step > 0 && o->step <= 1)) return ric_fail(RIC_E_INPUT, "step %.10g; give a number from 0 to 1", o->step);
    return RIC_OK;
}

/* A restitution is one of rigid stops. */
static ric_status check_along(const ric_force_medium *m, const ric_response_options *o)
{
    bool rigid = o->along != RIC_RESPONSE_RESTITUTION;
    for (int f = 0; f < m->model->n_face && !rigid; f++) rigid = ric_force_medium_rigid(m, f);
    if (rigid) return RIC_OK;
    return ric_fail(RIC_E_INPUT, "the restitution cannot vary, as no contact of this structure is rigid; vary the "
                                 "frequency or the level of the force");
}

static ric_status open_driver(const ric_atlas *atlas, const ric_response_options *o, const char *path, driver *d)
{
    *d = (driver){.atlas = atlas};
    ric_shaking shaking = o->shaking;
    if (o->along == RIC_RESPONSE_RESTITUTION) shaking.restitution = o->window[1];
    ric_status status = check(o);
    if (!status) status = ric_force_create(atlas, &shaking, &d->force);
    if (!status) status = ric_force_medium_create(d->force, &d->medium);
    if (!status) status = check_along(d->medium, o);
    if (status) return status;
    d->r = ric_response_create(d->medium->model);
    if (d->r) d->r->atlas = atlas;
    char *text = d->r && ric_response_take(d->r, o) ? ric_response_store_text(d->r) : NULL;
    if (!text) return ric_no_memory("a response");
    status = ric_response_store_open(path, text, ric_study_text(ric_atlas_study(atlas)), d->r, &d->file);
    free(text);
    const double unit = o->along == RIC_RESPONSE_OMEGA ? d->medium->time : 1;
    d->trace = (ric_response_trace_options){.along = (ric_force_along)o->along,
                                            .scale = o->along == RIC_RESPONSE_LEVEL ? o->window[1] : 1,
                                            .window = {o->window[0] / unit, o->window[1] / unit},
                                            .step = o->step,
                                            .points = o->points};
    return status;
}

ric_status ric_response_run(const ric_atlas *atlas, const ric_response_options *o, const char *path,
                            bool (*stop)(void *user), void *user)
{
    driver d;
    ric_status status = open_driver(atlas, o, path, &d);
    ric_halt_ask(stop, user);
    if (!status && !d.r->finished) {
        const int levels = o->along == RIC_RESPONSE_LEVEL ? 1 : o->n_level;
        for (int i = 0; i < levels && !status; i++) {
            d.level = o->along == RIC_RESPONSE_LEVEL ? o->window[0] : o->levels[i];
            status = start_all(&d, i);
        }
        if (!status) status = leave_all(&d);
        if (!status) status = ric_response_store_finish(d.file);
    }
    ric_halt_ask(NULL, NULL);
    ric_response_store_close(d.file);
    ric_response_free(d.r);
    ric_force_medium_free(d.medium);
    ric_force_free(d.force);
    return status;
}
