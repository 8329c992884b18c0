/* The motion of an orbit over one period, as rows of numbers, with its impacts and touches. Between
 * rigid impacts it is written down from the modes, flight by flight, so that speeds on both sides
 * of an impact are exact; under a power law it is what the simulator gives from the stored state.
 */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

double *plot_motion_row(const plot_motion *o, int i)
{
    return o->rows + (size_t)i * (size_t)(1 + 2 * o->n);
}

/* What the gap coordinate is measured by: the clearance, or the length of a power law, scaled like
 * the displacements. */
static double unit_of(const plot_motion *o, const ric_contact *c)
{
    const double unit = c->law != RIC_LAW_POWER ? c->clearance
                        : c->length > 0         ? c->length
                                                : ric_model_length(o->model);
    return unit / ric_model_length(o->model);
}

/* Gap coordinate in clearances: the stops are at +1 and -1 for every contact. */
double plot_motion_gap(const plot_motion *o, int contact, const double *x)
{
    ric_contact c;
    double s = 0;
    if (ric_model_contact(o->model, contact, &c) != RIC_OK) return NAN;
    for (int i = 0; i < o->n; i++) s += c.normal[i] * x[i];
    return s / unit_of(o, &c);
}

double plot_motion_clearance(const plot_motion *o, int contact)
{
    ric_contact c;
    return ric_model_contact(o->model, contact, &c) == RIC_OK ? unit_of(o, &c) : NAN;
}

/* ------------------------------------------------------------------- motion */

typedef struct {
    int n;
    double *omega, *shapes, *q, *p; /* modes; modal state at the start of the flight */
    ric_simulator *springs; /* of a model with contacts of law bilinear: it flies, from `state` [2
                               n]; NULL without */
    double *state;
} modal;

static bool is_spring(const ric_model *model, int face)
{
    int contact;
    ric_contact c;
    return !ric_model_face(model, face, &contact, NULL, NULL) &&
           !ric_model_contact(model, contact, &c) && c.law == RIC_LAW_BILINEAR;
}

static ric_status modal_create(const ric_model *model, modal *m)
{
    const size_t n = (size_t)ric_model_n_dof(model);
    *m = (modal){.n = (int)n,
                 .omega = calloc(n, sizeof(double)),
                 .shapes = calloc(n * n, sizeof(double)),
                 .q = calloc(n, sizeof(double)),
                 .p = calloc(n, sizeof(double)),
                 .state = calloc(2 * n, sizeof(double))};
    if (!m->omega || !m->shapes || !m->q || !m->p || !m->state) return RIC_E_NOMEM;
    for (int f = 0; f < ric_model_n_face(model); f++)
        if (is_spring(model, f) && !m->springs &&
            ric_simulator_create(model, &m->springs) != RIC_OK)
            return RIC_E_NOMEM;
    const ric_status status = ric_model_frequencies(model, m->omega);
    return status == RIC_OK ? ric_model_modes(model, m->shapes) : status;
}

static void modal_free(modal *m)
{
    free(m->omega);
    free(m->shapes);
    free(m->q);
    free(m->p);
    free(m->state);
    ric_simulator_free(m->springs);
}

/* q = Phi^T M x, p = Phi^T M v */
static void modal_start(modal *m, const double *mass, const double *state)
{
    const int n = m->n;
    memcpy(m->state, state, 2 * (size_t)n * sizeof *state);
    for (int k = 0; k < n; k++) {
        m->q[k] = m->p[k] = 0;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                m->q[k] += m->shapes[i * n + k] * mass[i * n + j] * state[j];
                m->p[k] += m->shapes[i * n + k] * mass[i * n + j] * state[n + j];
            }
    }
}

/* x and v at time t of the flight; out [2 n]. */
static void modal_at(const modal *m, double t, double *out)
{
    const int n = m->n;
    if (m->springs &&
        t >= 0) { /* closed or not, the simulator knows; a short flight, so that nothing grows */
        bool hit = ric_simulator_start(m->springs, m->state, m->state + n) == RIC_OK;
        while (hit && ric_simulator_advance(m->springs, t, &hit, NULL) == RIC_OK) {
        }
        ric_simulator_state(m->springs, NULL, out, out + n);
        return;
    }
    memset(out, 0, 2 * (size_t)n * sizeof *out);
    for (int k = 0; k < n; k++) {
        const double w = m->omega[k], c = cos(w * t), s = sin(w * t);
        const double q = m->q[k] * c + m->p[k] * (w > 0 ? s / w : t),
                     p = m->p[k] * c - w * m->q[k] * s;
        for (int i = 0; i < n; i++) {
            out[i] += m->shapes[i * n + k] * q;
            out[n + i] += m->shapes[i * n + k] * p;
        }
    }
}

/* x and v of the modal state. */
static void modal_out(const modal *m, double *out)
{
    const int n = m->n;
    memset(out, 0, 2 * (size_t)n * sizeof *out);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < n; i++) {
            out[i] += m->shapes[i * n + k] * m->q[k];
            out[n + i] += m->shapes[i * n + k] * m->p[k];
        }
}

/* To the end of a flight, and the elastic impact there: p - 2 (c.p)/(c.c) c. face < 0: none. */
static void modal_step(modal *m, const ric_model *model, double t, int face)
{
    int contact, side, mirror;
    ric_contact c;
    double along = 0, square = 0;
    for (int k = 0; k < m->n; k++) {
        const double w = m->omega[k], q = m->q[k], p = m->p[k];
        m->q[k] = q * cos(w * t) + p * (w > 0 ? sin(w * t) / w : t);
        m->p[k] = p * cos(w * t) - w * q * sin(w * t);
    }
    if (face < 0 || ric_model_face(model, face, &contact, &side, &mirror) != RIC_OK ||
        ric_model_contact(model, contact, &c) != RIC_OK)
        return;
    for (int round = 0; round < 2; round++) /* first the sums, then the change */
        for (int k = 0; k < m->n; k++) {
            double normal = 0;
            for (int i = 0; i < m->n; i++) normal += m->shapes[i * m->n + k] * c.normal[i];
            if (round == 0) {
                along += normal * m->p[k];
                square += normal * normal;
            } else if (square > 0) {
                m->p[k] -= 2 * along / square * normal;
            }
        }
}

static bool add_row(plot_motion *o, double time, const double *state)
{
    const size_t width = (size_t)(1 + 2 * o->n);
    if (o->n_row == o->room) {
        const int room = o->room ? 2 * o->room : 1024;
        double *rows = realloc(o->rows, (size_t)room * width * sizeof *rows);
        if (!rows) return false;
        o->rows = rows;
        o->room = room;
    }
    double *r = plot_motion_row(o, o->n_row++);
    r[0] = time;
    memcpy(r + 1, state, (width - 1) * sizeof *r);
    return true;
}

static bool add_event(plot_motion *o, plot_event event)
{
    plot_event *events = realloc(o->events, ((size_t)o->n_event + 1) * sizeof *events);
    if (!events) return false;
    o->events = events;
    events[o->n_event++] = event;
    return true;
}

/* Letter k of the word: an impact, the closing of a spring or its opening. */
static bool add_letter(plot_motion *o, double time, int k, int sample)
{
    const int n_face = ric_model_n_face(o->model);
    if (!o->impacts) return true;
    return add_event(o, (plot_event){.time = time,
                                     .face = o->word[k] % n_face,
                                     .opens = o->word[k] >= n_face,
                                     .sample = sample});
}

int plot_motion_face(const plot_motion *o, int contact, int side)
{
    for (int face = 0; face < ric_model_n_face(o->model); face++) {
        int c, s, mirror;
        if (ric_model_face(o->model, face, &c, &s, &mirror) == RIC_OK && c == contact && s == side)
            return face;
    }
    return -1;
}

/* Speed of a gap at time t of the flight; the state goes to work [2 n]. */
static double gap_speed(const plot_motion *o, const modal *m, int contact, double t, double *work)
{
    modal_at(m, t, work);
    return plot_motion_gap(o, contact, work + o->n);
}

/* Extrema of the gaps that reach a stop between t0 and t1 of the flight that starts at `begin`. */
static bool find_touches(plot_motion *o, const modal *m, int contact, double begin, double t0,
                         double t1, double *work)
{
    if (gap_speed(o, m, contact, t0, work) * gap_speed(o, m, contact, t1, work) > 0) return true;
    const double sign = gap_speed(o, m, contact, t0, work) > 0 ? 1 : -1;
    for (int i = 0; i < 60; i++) {
        const double middle = (t0 + t1) / 2;
        if (sign * gap_speed(o, m, contact, middle, work) > 0) t0 = middle;
        else t1 = middle;
    }
    modal_at(m, t0, work);
    const double gap = plot_motion_gap(o, contact, work);
    const int face = plot_motion_face(o, contact, gap > 0 ? 1 : -1);
    if (face < 0 || fabs(fabs(gap) - 1) > o->tolerance) return true;
    double time = begin + t0;
    if (time < -1e-9 * o->period) time += o->period;
    return add_row(o, time, work) && add_event(o, (plot_event){.time = time,
                                                               .face = face,
                                                               .touch = true,
                                                               .sample = o->n_row - 1});
}

/* Rows of one flight. The touches' rows come after all flights, outside the curves. */
static bool sample_flight(plot_motion *o, const modal *m, double begin, double length, double *work)
{
    const double turns = m->omega[m->n - 1] * length / (2 * CLI_PI);
    const int n = (int)
        fmax(400, fmin(4000, 96 * turns)); /* a loop of a portrait has no corners that are seen */
    for (int i = 0; i <= n; i++) {
        modal_at(m, length * i / n, work);
        if (!add_row(o, begin + length * i / n, work)) return false;
    }
    return true;
}

/* Part of a flight at its end: stored times of flight are known better. */
#define END 1e-10

static bool touches_of_flight(plot_motion *o, const modal *m, double begin, double length,
                              double *work)
{
    const double turns = m->omega[m->n - 1] * length / (2 * CLI_PI);
    const int n = (int)fmax(96, fmin(8000, 48 * turns));
    /* Without impacts the period starts anywhere, also at a touch: the search starts a little
     * earlier. */
    const double shift = o->impacts ? 0 : -length / n / 2;
    for (int contact = 0; contact < ric_model_n_contact(o->model); contact++)
        for (int i = 0; i < n; i++) {
            /* At the end a simulator may have reflected the motion: no extremum, but the impact. */
            const double to = i + 1 < n || !m->springs ? length * (i + 1) / n : length * (1 - END);
            if (!find_touches(o, m, contact, begin, shift + length * i / n, shift + to, work))
                return false;
        }
    return true;
}

/* To the start of flight k + 1. */
static void step(modal *m, const plot_motion *o, int k)
{
    int face = o->impacts ? o->word[(k + 1) % o->impacts] % ric_model_n_face(o->model) : -1;
    const bool spring = face >= 0 && is_spring(o->model, face);
    double state[2 * m->n];
    if (m->springs) modal_at(m, o->flights[k], state);
    if (m->springs) modal_start(m, ric_model_mass(o->model), state);
    modal_step(m, o->model, m->springs ? 0 : o->flights[k], spring ? -1 : face);
    if (!m->springs) return;
    modal_out(m, state);
    memcpy(m->state, state, sizeof state);
}

/* Rigid stops and springs beyond a gap: flights from the modes, then the touches. */
static ric_status reflect(plot_motion *o)
{
    const int flights = o->n_piece;
    modal m;
    double *work = calloc(2 * (size_t)o->n, sizeof *work), begin = 0;
    ric_status status = modal_create(o->model, &m);
    bool good = work && (o->first = calloc((size_t)flights + 1, sizeof *o->first));
    if (status != RIC_OK || !good) goto out;
    for (int touches = 0; touches < 2; touches++) {
        modal_start(&m, ric_model_mass(o->model), o->state);
        begin = 0;
        for (int k = 0; k < flights && good; k++) {
            if (touches) good = touches_of_flight(o, &m, begin, o->flights[k], work);
            else good = sample_flight(o, &m, begin, o->flights[k], work);
            if (!touches) o->first[k + 1] = o->n_row;
            if (!touches) good = good && add_letter(o, begin, k, o->first[k]);
            begin += o->flights[k];
            step(&m, o, k);
        }
        if (!touches)
            good = good && add_letter(o, begin, 0, o->n_row - 1); /* again, where the period ends */
    }
out:
    modal_free(&m);
    free(work);
    return status != RIC_OK ? status : good ? RIC_OK : RIC_E_NOMEM;
}

/* ----------------------------------------------------------------- power laws */

enum { ROWS = 2400 };
static const double return_bound =
    1e-3; /* how far a motion may end from its start, relative to its largest value */

static bool returns(const plot_motion *o, const double *z)
{
    double size = 0, error = 0;
    for (int i = 0; i < 2 * o->n; i++) {
        error = fmax(error, fabs(z[i] - o->state[i]));
        for (int k = 0; k < o->n_row; k++) size = fmax(size, fabs(plot_motion_row(o, k)[1 + i]));
    }
    return error <= return_bound * size;
}

/* The motion of the simulator, in one smooth piece; refused where it has not come back after one
 * period. */
static ric_status integrate(plot_motion *o)
{
    ric_simulator *simulator = NULL;
    double *z = calloc(2 * (size_t)o->n, sizeof *z);
    ric_status status = z && (o->first = calloc(2, sizeof *o->first))
                            ? ric_simulator_create(o->model, &simulator)
                            : RIC_E_NOMEM;
    if (status == RIC_OK) status = ric_simulator_start(simulator, o->state, o->state + o->n);
    for (int i = 0; status == RIC_OK && i <= ROWS; i++) {
        bool hit;
        if (i > 0) status = ric_simulator_advance(simulator, o->period * i / ROWS, &hit, NULL);
        ric_simulator_state(simulator, NULL, z, z + o->n);
        if (status == RIC_OK && !add_row(o, o->period * i / ROWS, z)) status = RIC_E_NOMEM;
    }
    if (status == RIC_OK && !returns(o, z)) {
        fprintf(stderr, "ricochet: this orbit is too unstable to be drawn from its start: after "
                        "one period it misses it\n");
        status = RIC_E_NUMERIC;
    }
    if (o->first) o->first[1] = o->n_row;
    ric_simulator_free(simulator);
    free(z);
    return status;
}

ric_status plot_motion_make(plot_motion *o)
{
    bool flights = true;
    for (int contact = 0; contact < ric_model_n_contact(o->model); contact++) {
        ric_contact c;
        flights &= ric_model_contact(o->model, contact, &c) == RIC_OK && c.law != RIC_LAW_POWER;
    }
    o->jumps = flights && o->impacts > 0;
    o->n_piece = o->jumps ? o->impacts : 1;
    return flights ? reflect(o) : integrate(o);
}

/* ------------------------------------------------------------------ reading */

bool plot_motion_keep(plot_motion *o, int impacts, const int *word, const double *state,
                      const double *flights)
{
    const size_t n = 2 * (size_t)o->n, k = impacts > 0 ? (size_t)impacts : 1;
    o->impacts = impacts;
    o->word = calloc(k, sizeof *o->word);
    o->state = calloc(n, sizeof *o->state);
    o->flights = calloc(k, sizeof *o->flights);
    if (!o->word || !o->state || !o->flights) return false;
    if (impacts > 0) memcpy(o->word, word, (size_t)impacts * sizeof *word);
    memcpy(o->state, state, n * sizeof *state);
    memcpy(o->flights, flights, k * sizeof *flights);
    for (size_t i = 0; i < k; i++) o->period += flights[i];
    return true;
}

double plot_read_time(const plot_motion *o, const double *r, int what)
{
    (void)o;
    (void)what;
    return r[0];
}

double plot_read_x(const plot_motion *o, const double *r, int what)
{
    (void)o;
    return r[1 + what];
}

double plot_read_v(const plot_motion *o, const double *r, int what)
{
    return r[1 + o->n + what];
}

double plot_read_gap(const plot_motion *o, const double *r, int what)
{
    return plot_motion_gap(o, what, r + 1);
}

double plot_read_distance(const plot_motion *o, const double *r, int what)
{
    return plot_motion_gap(o, what, r + 1) * plot_motion_clearance(o, what);
}

void plot_motion_range(const plot_motion *o, plot_reading y, int what, double *lo, double *hi)
{
    for (int i = 0; i < o->first[o->n_piece]; i++) {
        *lo = fmin(*lo, y(o, plot_motion_row(o, i), what));
        *hi = fmax(*hi, y(o, plot_motion_row(o, i), what));
    }
}

void plot_motion_draw(plot_page *page, const plot_panel *panel, plot_stroke stroke,
                      const plot_motion *o, plot_reading x, plot_reading y, int what, double later)
{
    const double shift = x == plot_read_time ? later : 0;
    plot_point *points = malloc((size_t)o->first[o->n_piece] * sizeof *points);
    for (int k = 0; points && k < o->n_piece; k++) {
        const int n = o->first[k + 1] - o->first[k];
        for (int i = 0; i < n; i++) {
            const double *r = plot_motion_row(o, o->first[k] + i);
            points[i] = (plot_point){x(o, r, what) + shift, y(o, r, what)};
        }
        plot_panel_curve(page, panel, stroke, n, points);
        const double *after = plot_motion_row(o, o->first[(k + 1) % o->n_piece]);
        const plot_point jump[] = {points[n - 1], {x(o, after, what), y(o, after, what)}};
        if (o->jumps && x != plot_read_time && !(o->open && k + 1 == o->n_piece))
            plot_panel_curve(page, panel, PLOT_JUMP, 2, jump);
    }
    free(points);
}

/* ------------------------------------------------------------------- events */

enum { SEEN_IMPACT = 1, SEEN_CLOSING = 2, SEEN_OPENING = 4, SEEN_TOUCH = 8 };

plot_mark plot_event_mark(const plot_event *event)
{
    return event->touch ? PLOT_CIRCLE : event->opens ? PLOT_DIAMOND : PLOT_DOT;
}

unsigned plot_events_seen(const plot_motion *o, unsigned seen)
{
    for (int i = 0; i < o->n_event; i++) {
        const plot_event *e = &o->events[i];
        seen |= e->touch                       ? SEEN_TOUCH
                : e->opens                     ? SEEN_OPENING
                : is_spring(o->model, e->face) ? SEEN_CLOSING
                                               : SEEN_IMPACT;
    }
    return seen;
}

int plot_event_entries(unsigned seen, plot_legend_entry *out)
{
    static const char *const full[] = {"", "impact", "closing", "impact, closing"};
    int n = 0;
    if (seen & (SEEN_IMPACT | SEEN_CLOSING))
        out[n++] = (plot_legend_entry){full[seen & (SEEN_IMPACT | SEEN_CLOSING)], -1, PLOT_DOT};
    if (seen & SEEN_OPENING) out[n++] = (plot_legend_entry){"opening", -1, PLOT_DIAMOND};
    if (seen & SEEN_TOUCH) out[n++] = (plot_legend_entry){"touch", -1, PLOT_CIRCLE};
    return n;
}

void plot_motion_free(plot_motion *o)
{
    free(o->word);
    free(o->state);
    free(o->flights);
    free(o->first);
    free(o->rows);
    free(o->events);
    *o = (plot_motion){0};
}

double plot_motion_at(const plot_motion *o, double t, int coordinate)
{
    t = fmod(t, o->period);
    t = t < 0 ? t + o->period : t;
    int lo = 0, hi = o->first[o->n_piece] - 1;
    while (hi - lo > 1) {
        const int middle = (lo + hi) / 2;
        if (plot_motion_row(o, middle)[0] <= t) lo = middle;
        else hi = middle;
    }
    const double *a = plot_motion_row(o, lo), *b = plot_motion_row(o, hi), h = b[0] - a[0];
    const double x0 = a[1 + coordinate], x1 = b[1 + coordinate], v0 = a[1 + o->n + coordinate],
                 v1 = b[1 + o->n + coordinate];
    if (!(h > 0)) /* two rows at an impact */
        return x0;
    const double s = (t - a[0]) / h;
    return x0 * (1 + 2 * s) * (1 - s) * (1 - s) + h * v0 * s * (1 - s) * (1 - s) +
           x1 * s * s * (3 - 2 * s) - h * v1 * s * s * (1 - s);
}

double plot_motion_gap_at(const plot_motion *m, int contact, double t)
{
    double x[m->n];
    for (int i = 0; i < m->n; i++) x[i] = plot_motion_at(m, t, i);
    return plot_motion_gap(m, contact, x);
}

double plot_motion_start(const plot_motion *m, int contact)
{
    enum { SAMPLES = 500 };
    double best = 0, length = -1, since = NAN, before = plot_motion_gap_at(m, contact, 0);
    for (int i = 1; i <= 2 * SAMPLES; i++) { /* two periods, so that every stretch is seen whole */
        const double t = m->period * i / SAMPLES, gap = plot_motion_gap_at(m, contact, t);
        if (before > 0 && gap <= 0) since = t;
        if (before <= 0 && gap > 0 && t - since > length) {
            length = t - since;
            best = t - m->period / SAMPLES * gap / (gap - before);
        }
        before = gap;
    }
    return best;
}
