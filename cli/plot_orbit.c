/* One orbit: displacements and gaps over a period, impacts and touches with the letters of their faces, and phase portraits.
 * The motion between impacts is written down from the modes, flight by flight, so that speeds on both sides of an impact are exact. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

enum { MAX_SHOWN = 4 };
static const double type = 12, pi = 3.14159265358979323846;
/* How near a gap must come to a stop, in clearances, to be a touch: an orbit of a branch is exact to rounding; a grazing junction of a very
 * unstable orbit carries the error of its flights. */
static const double touch_of_branch = 1e-9, touch_of_grazing = 1e-7;

typedef struct {
    double time;
    int face;
    bool touch;
    int sample; /* index of a state at this time */
} event;

typedef struct {
    const plot_options *common;
    ric_atlas *atlas;
    const ric_model *model;
    int n; /* degrees of freedom */
    /* What is drawn. */
    int impacts, *word; /* letters of the word, [impacts]; from n_face on a spring opens */
    double *state, *flights, period, tolerance;
    char title[400];
    /* The motion: row i is t, x [n], v [n]; flight k owns the rows first[k] .. first[k + 1] - 1. */
    int n_row, room, *first;
    double *rows;
    int n_event;
    event *events;
    int n_shown, shown[MAX_SHOWN], n_gap, gaps[MAX_SHOWN];
    int missing;
    plot_page *page;
} orbit;

static double *row(const orbit *o, int i)
{
    return o->rows + (size_t)i * (size_t)(1 + 2 * o->n);
}

static double clearance_of(const orbit *o, const ric_contact *contact)
{
    if (contact->law == RIC_LAW_POWER) /* nothing to touch: its own length, or that of the scale */
        return contact->length > 0 ? contact->length / ric_model_length(o->model) : 1;
    return contact->clearance / ric_model_length(o->model);
}

/* Gap coordinate in clearances: the stops are at +1 and -1 for every contact. */
static double gap_of(const orbit *o, int contact, const double *x)
{
    ric_contact c;
    double s = 0;
    if (ric_model_contact(o->model, contact, &c) != RIC_OK)
        return NAN;
    for (int i = 0; i < o->n; i++)
        s += c.normal[i] * x[i];
    return s / clearance_of(o, &c);
}

/* ------------------------------------------------------------------- motion */

typedef struct {
    int n;
    double *omega, *shapes, *q, *p; /* modes; modal state at the start of the flight */
    ric_simulator *springs;         /* of a model with contacts of law bilinear: it flies, from `state` [2 n]; NULL without */
    double *state;
} modal;

static bool is_spring(const ric_model *model, int face)
{
    int contact;
    ric_contact c;
    return !ric_model_face(model, face, &contact, NULL, NULL) && !ric_model_contact(model, contact, &c) && c.law == RIC_LAW_BILINEAR;
}

static ric_status modal_create(const ric_model *model, modal *m)
{
    const size_t n = (size_t)ric_model_n_dof(model);
    *m = (modal){.n = (int)n, .omega = calloc(n, sizeof(double)), .shapes = calloc(n * n, sizeof(double)), .q = calloc(n, sizeof(double)),
                 .p = calloc(n, sizeof(double)), .state = calloc(2 * n, sizeof(double))};
    if (!m->omega || !m->shapes || !m->q || !m->p || !m->state)
        return RIC_E_NOMEM;
    for (int f = 0; f < ric_model_n_face(model); f++)
        if (is_spring(model, f) && !m->springs && ric_simulator_create(model, &m->springs) != RIC_OK)
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
    if (m->springs && t >= 0) { /* closed or not, the simulator knows; a short flight, so that nothing grows */
        bool hit = ric_simulator_start(m->springs, m->state, m->state + n) == RIC_OK;
        while (hit && ric_simulator_advance(m->springs, t, &hit, NULL) == RIC_OK) {}
        ric_simulator_state(m->springs, NULL, out, out + n);
        return;
    }
    memset(out, 0, 2 * (size_t)n * sizeof *out);
    for (int k = 0; k < n; k++) {
        const double w = m->omega[k], c = cos(w * t), s = sin(w * t);
        const double q = m->q[k] * c + m->p[k] * (w > 0 ? s / w : t), p = m->p[k] * c - w * m->q[k] * s;
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
    if (face < 0 || ric_model_face(model, face, &contact, &side, &mirror) != RIC_OK || ric_model_contact(model, contact, &c) != RIC_OK)
        return;
    for (int round = 0; round < 2; round++) /* first the sums, then the change */
        for (int k = 0; k < m->n; k++) {
            double normal = 0;
            for (int i = 0; i < m->n; i++)
                normal += m->shapes[i * m->n + k] * c.normal[i];
            if (round == 0) {
                along += normal * m->p[k];
                square += normal * normal;
            } else if (square > 0) {
                m->p[k] -= 2 * along / square * normal;
            }
        }
}

static bool add_row(orbit *o, double time, const double *state)
{
    const size_t width = (size_t)(1 + 2 * o->n);
    if (o->n_row == o->room) {
        const int room = o->room ? 2 * o->room : 1024;
        double *rows = realloc(o->rows, (size_t)room * width * sizeof *rows);
        if (!rows)
            return false;
        o->rows = rows;
        o->room = room;
    }
    double *r = row(o, o->n_row++);
    r[0] = time;
    memcpy(r + 1, state, (width - 1) * sizeof *r);
    return true;
}

static bool add_event(orbit *o, double time, int face, bool touch, int sample)
{
    event *events = realloc(o->events, ((size_t)o->n_event + 1) * sizeof *events);
    if (!events)
        return false;
    o->events = events;
    events[o->n_event++] = (event){time, face, touch, sample};
    return true;
}

static int face_of(const orbit *o, int contact, int side)
{
    for (int face = 0; face < ric_model_n_face(o->model); face++) {
        int c, s, mirror;
        if (ric_model_face(o->model, face, &c, &s, &mirror) == RIC_OK && c == contact && s == side)
            return face;
    }
    return -1;
}

/* Speed of a gap at time t of the flight; the state goes to work [2 n]. */
static double gap_speed(const orbit *o, const modal *m, int contact, double t, double *work)
{
    modal_at(m, t, work);
    return gap_of(o, contact, work + o->n);
}

/* Extrema of the gaps that reach a stop between t0 and t1 of the flight that starts at `begin`. */
static bool find_touches(orbit *o, const modal *m, int contact, double begin, double t0, double t1, double *work)
{
    if (gap_speed(o, m, contact, t0, work) * gap_speed(o, m, contact, t1, work) > 0)
        return true;
    const double sign = gap_speed(o, m, contact, t0, work) > 0 ? 1 : -1;
    for (int i = 0; i < 60; i++) {
        const double middle = (t0 + t1) / 2;
        if (sign * gap_speed(o, m, contact, middle, work) > 0)
            t0 = middle;
        else
            t1 = middle;
    }
    modal_at(m, t0, work);
    const double gap = gap_of(o, contact, work);
    const int face = face_of(o, contact, gap > 0 ? 1 : -1);
    if (face < 0 || fabs(fabs(gap) - 1) > o->tolerance)
        return true;
    double time = begin + t0;
    if (time < -1e-9 * o->period)
        time += o->period;
    return add_row(o, time, work) && add_event(o, time, face, true, o->n_row - 1);
}

/* Rows of one flight. The touches' rows come after all flights, outside the curves. */
static bool sample_flight(orbit *o, const modal *m, double begin, double length, double *work)
{
    const double turns = m->omega[m->n - 1] * length / (2 * pi);
    const int n = (int)fmax(48, fmin(4000, 32 * turns));
    for (int i = 0; i <= n; i++) {
        modal_at(m, length * i / n, work);
        if (!add_row(o, begin + length * i / n, work))
            return false;
    }
    return true;
}

static bool touches_of_flight(orbit *o, const modal *m, double begin, double length, double *work)
{
    const double turns = m->omega[m->n - 1] * length / (2 * pi);
    const int n = (int)fmax(96, fmin(8000, 48 * turns));
    /* Without impacts the period starts anywhere, also at a touch: the search starts a little earlier. */
    const double shift = o->impacts ? 0 : -length / n / 2;
    for (int contact = 0; contact < ric_model_n_contact(o->model); contact++)
        for (int i = 0; i < n; i++)
            if (!find_touches(o, m, contact, begin, shift + length * i / n, shift + length * (i + 1) / n, work))
                return false;
    return true;
}

/* Under a power law the motion is that of the simulator. */
static ric_status make_smooth_motion(orbit *o)
{
    enum { SAMPLES = 960 };
    ric_simulator *simulator = NULL;
    double *state = calloc(2 * (size_t)o->n, sizeof *state);
    ric_status status = state && (o->first = calloc(2, sizeof *o->first)) ? ric_simulator_create(o->model, &simulator) : RIC_E_NOMEM;
    if (status == RIC_OK)
        status = ric_simulator_start(simulator, o->state, o->state + o->n);
    for (int i = 0; i <= SAMPLES && status == RIC_OK; i++) {
        const double t = o->flights[0] * i / SAMPLES;
        bool hit;
        if (i > 0)
            status = ric_simulator_advance(simulator, t, &hit, NULL);
        ric_simulator_state(simulator, NULL, state, state + o->n);
        if (status == RIC_OK && !add_row(o, t, state))
            status = RIC_E_NOMEM;
    }
    if (o->first)
        o->first[1] = o->n_row;
    ric_simulator_free(simulator);
    free(state);
    return status;
}

/* To the start of flight k + 1. */
static void step(modal *m, const orbit *o, int k)
{
    int face = o->impacts ? o->word[(k + 1) % o->impacts] % ric_model_n_face(o->model) : -1;
    const bool spring = face >= 0 && is_spring(o->model, face);
    double state[2 * m->n];
    if (m->springs)
        modal_at(m, o->flights[k], state);
    if (m->springs)
        modal_start(m, ric_model_mass(o->model), state);
    modal_step(m, o->model, m->springs ? 0 : o->flights[k], spring ? -1 : face);
    if (!m->springs)
        return;
    modal_out(m, state);
    memcpy(m->state, state, sizeof state);
}

static ric_status make_motion(orbit *o)
{
    if (ric_model_n_face(o->model) == 0)
        return make_smooth_motion(o);
    const int flights = o->impacts > 0 ? o->impacts : 1;
    modal m;
    double *work = calloc(2 * (size_t)o->n, sizeof *work), begin = 0;
    ric_status status = modal_create(o->model, &m);
    bool good = work && (o->first = calloc((size_t)flights + 1, sizeof *o->first));
    if (status != RIC_OK || !good)
        goto out;
    for (int touches = 0; touches < 2; touches++) {
        modal_start(&m, ric_model_mass(o->model), o->state);
        begin = 0;
        for (int k = 0; k < flights && good; k++) {
            if (touches)
                good = touches_of_flight(o, &m, begin, o->flights[k], work);
            else
                good = sample_flight(o, &m, begin, o->flights[k], work);
            if (!touches)
                o->first[k + 1] = o->n_row;
            if (!touches && o->impacts && o->word[k] < ric_model_n_face(o->model)) /* not where a spring opens */
                good = good && add_event(o, begin, o->word[k], false, o->first[k]);
            begin += o->flights[k];
            step(&m, o, k);
        }
        if (!touches && o->impacts && good) /* the first impact again, where the period ends */
            good = add_event(o, begin, o->word[0], false, o->n_row - 1);
    }
out:
    modal_free(&m);
    free(work);
    return status != RIC_OK ? status : good ? RIC_OK : RIC_E_NOMEM;
}

/* ------------------------------------------------------------------ request */

static bool keep_orbit(orbit *o, int impacts, const int *word, const double *state, const double *flights)
{
    const size_t n = 2 * (size_t)o->n, k = impacts > 0 ? (size_t)impacts : 1;
    o->impacts = impacts;
    o->word = calloc(k, sizeof *o->word);
    o->state = calloc(n, sizeof *o->state);
    o->flights = calloc(k, sizeof *o->flights);
    if (!o->word || !o->state || !o->flights)
        return false;
    if (impacts > 0)
        memcpy(o->word, word, (size_t)impacts * sizeof *word);
    memcpy(o->state, state, n * sizeof *state);
    memcpy(o->flights, flights, k * sizeof *flights);
    for (size_t i = 0; i < k; i++)
        o->period += flights[i];
    return true;
}

static void set_title(orbit *o, const char *name, double energy, const char *extra)
{
    if (o->common->title)
        plot_text_escape(o->common->title, sizeof o->title, o->title);
    else
        snprintf(o->title, sizeof o->title, "%s:  E = %.6g,  ω = %.6g rad/s%s", name, energy, 2 * pi / o->period, extra);
}

static int take_junction(orbit *o, const char *text)
{
    long id;
    ric_junction junction;
    char name[160];
    if (!cli_parse_integer(text, "--junction", 1, 2147483647, &id))
        return CLI_WRONG;
    const ric_status status = ric_atlas_junction(o->atlas, (int)id, &junction);
    if (status != RIC_OK)
        return cli_report(status);
    o->tolerance = junction.kind == RIC_KIND_GRAZING ? touch_of_grazing : touch_of_branch;
    if (!keep_orbit(o, junction.letters, junction.word, junction.state, junction.flights))
        return cli_report(RIC_E_NOMEM);
    plot_text_label(junction.name && *junction.name ? junction.name : junction.label, sizeof name, name);
    set_title(o, name, junction.energy, "");
    return CLI_DONE;
}

typedef struct { const char *branch, *junction, *point, *energy, *frequency, *which, *coordinates; } words;

static int choose_orbit(orbit *o, const ric_branch *branch, const words *w, int n, ric_orbit **orbits)
{
    static const char *const stability[] = {", unstable", ", stable", ", stability undecided"};
    long which = 1;
    char name[200];
    ric_point point;
    if (n == 0) {
        fprintf(stderr, "ricochet: no orbit of branch %d there; it has energies %.6g to %.6g and frequencies %.6g to %.6g\n", branch->id,
                branch->energy_min, branch->energy_max, branch->frequency_min, branch->frequency_max);
        return CLI_FAILED;
    }
    if (w->which && !cli_parse_integer(w->which, "--which", 1, n, &which))
        return CLI_WRONG;
    if (n > 1 && !w->which)
        fprintf(stderr, "ricochet: %d orbits fit, this is the first; --which K draws another\n", n);
    const ric_orbit *chosen = orbits[which - 1];
    const int impacts = ric_orbit_letters(chosen), room = impacts > 0 ? impacts : 1;
    double *state = calloc(2 * (size_t)o->n, sizeof *state), *flights = calloc((size_t)room, sizeof *flights);
    int *word = calloc((size_t)room, sizeof *word);
    int code = CLI_DONE;
    if (state && flights && word)
        ric_orbit_data(chosen, &point, state, flights, word);
    if (!state || !flights || !word || !keep_orbit(o, impacts, word, state, flights)) {
        code = cli_report(RIC_E_NOMEM);
        goto out;
    }
    plot_branch_title(branch, 1, sizeof name, name);
    set_title(o, name, point.energy, point.stable >= 0 && point.stable <= 2 ? stability[point.stable] : "");
out:
    free(state);
    free(flights);
    free(word);
    return code;
}

static int take_branch(orbit *o, const words *w)
{
    long id, point = 0;
    double value;
    ric_branch branch;
    ric_orbit **orbits = NULL;
    int n = 0;
    if (!cli_parse_integer(w->branch, "--branch", 1, 2147483647, &id)
        || (w->point && !cli_parse_integer(w->point, "--point", 0, 2147483647, &point))
        || (w->energy && !cli_parse_number(w->energy, "--energy", &value))
        || (w->frequency && !cli_parse_number(w->frequency, "--frequency", &value)))
        return CLI_WRONG;
    if (w->point)
        value = (double)point;
    ric_status status = ric_atlas_branch(o->atlas, (int)id, &branch);
    if (status == RIC_OK)
        status = ric_orbit_find(o->atlas, (int)id, w->point ? RIC_AT_POINT : w->energy ? RIC_AT_ENERGY : RIC_AT_FREQUENCY, value, &n, &orbits);
    if (status != RIC_OK)
        return cli_report(status);
    o->tolerance = touch_of_branch;
    const int code = choose_orbit(o, &branch, w, n, orbits);
    ric_orbits_free(n, orbits);
    return code;
}

/* Coordinates on which contacts act most, where there are too many to show. */
static void usual_coordinates(orbit *o)
{
    o->n_shown = o->n < MAX_SHOWN ? o->n : MAX_SHOWN;
    for (int i = 0; i < o->n_shown; i++)
        o->shown[i] = i;
    if (o->n <= MAX_SHOWN)
        return;
    double taken[MAX_SHOWN] = {0};
    o->n_shown = 0;
    for (int i = 0; i < o->n; i++) {
        double weight = 0;
        for (int contact = 0; contact < ric_model_n_contact(o->model); contact++) {
            ric_contact c;
            if (ric_model_contact(o->model, contact, &c) == RIC_OK)
                weight += fabs(c.normal[i]);
        }
        int place = o->n_shown;
        while (place > 0 && taken[place - 1] < weight)
            place--;
        if (place == MAX_SHOWN)
            continue;
        o->n_shown += o->n_shown < MAX_SHOWN;
        for (int k = o->n_shown - 1; k > place; k--) {
            taken[k] = taken[k - 1];
            o->shown[k] = o->shown[k - 1];
        }
        taken[place] = weight;
        o->shown[place] = i;
    }
}

static bool take_coordinates(orbit *o, const char *text)
{
    for (const char *c = text;; c++) {
        char item[24];
        const size_t n = strcspn(c, ",");
        long index;
        snprintf(item, sizeof item, "%.*s", (int)(n < 20 ? n : 20), c);
        if (o->n_shown == MAX_SHOWN) {
            cli_wrong("--coordinates %s: at most %d fit on a page", text, MAX_SHOWN);
            return false;
        }
        if (!cli_parse_integer(item, "--coordinates", 1, o->n, &index))
            return false;
        o->shown[o->n_shown++] = (int)index - 1;
        c += n;
        if (!*c)
            return true;
    }
}

/* Contacts that are hit or touched, then others, as many as can be told apart. */
static void choose_gaps(orbit *o)
{
    const int n = ric_model_n_contact(o->model);
    for (int round = 0; round < 2; round++)
        for (int contact = 0; contact < n; contact++) {
            bool met = false, known = false;
            for (int i = 0; i < o->n_event; i++) {
                int c, side, mirror;
                met |= ric_model_face(o->model, o->events[i].face, &c, &side, &mirror) == RIC_OK && c == contact;
            }
            for (int i = 0; i < o->n_gap; i++)
                known |= o->gaps[i] == contact;
            if (!known && met == (round == 0) && o->n_gap < MAX_SHOWN)
                o->gaps[o->n_gap++] = contact;
        }
    for (int i = 1; i < o->n_gap; i++) /* in the order of the study */
        for (int k = i; k > 0 && o->gaps[k - 1] > o->gaps[k]; k--) {
            const int other = o->gaps[k];
            o->gaps[k] = o->gaps[k - 1];
            o->gaps[k - 1] = other;
        }
    if (n > o->n_gap)
        fprintf(stderr, "ricochet: %d of %d contacts are shown\n", o->n_gap, n);
}

/* ------------------------------------------------------------------ drawing */

/* A curve of the flights: value y of a row against value x, two functions of the row. `jumps` joins the ends of flights. */
typedef double (*reading)(const orbit *o, const double *row, int what);

static double read_time(const orbit *o, const double *r, int what) { (void)o; (void)what; return r[0]; }
static double read_x(const orbit *o, const double *r, int what) { (void)o; return r[1 + what]; }
static double read_v(const orbit *o, const double *r, int what) { return r[1 + o->n + what]; }
static double read_gap(const orbit *o, const double *r, int what) { return gap_of(o, what, r + 1); }

static int n_flight(const orbit *o)
{
    return o->impacts > 0 ? o->impacts : 1;
}

static void draw_flights(const orbit *o, const plot_panel *panel, plot_stroke stroke, reading x, reading y, int what)
{
    const int last = o->first[n_flight(o)];
    plot_point *points = malloc((size_t)last * sizeof *points);
    for (int k = 0; points && k < n_flight(o); k++) {
        const int n = o->first[k + 1] - o->first[k];
        for (int i = 0; i < n; i++)
            points[i] = (plot_point){x(o, row(o, o->first[k] + i), what), y(o, row(o, o->first[k] + i), what)};
        plot_panel_curve(o->page, panel, stroke, n, points);
        const double *after = row(o, o->first[(k + 1) % n_flight(o)]);
        const plot_point jump[] = {points[n - 1], {x(o, after, what), y(o, after, what)}};
        if (o->impacts && x != read_time)
            plot_panel_curve(o->page, panel, PLOT_JUMP, 2, jump);
    }
    free(points);
}

static void read_range(const orbit *o, reading y, int what, double *lo, double *hi)
{
    for (int i = 0; i < o->first[n_flight(o)]; i++) {
        *lo = fmin(*lo, y(o, row(o, i), what));
        *hi = fmax(*hi, y(o, row(o, i), what));
    }
}

static plot_axis axis_over(double lo, double hi, double from, double to)
{
    return (plot_axis){PLOT_SCALE_LINEAR, lo, hi, 0, from, to};
}

static plot_axis time_axis(const orbit *o, double from, double to)
{
    return axis_over(-0.025 * o->period, 1.025 * o->period, from, to);
}

/* Thin upright lines tie the impacts of the two histories together. */
static void draw_event_lines(const orbit *o, const plot_panel *panel)
{
    const plot_box box = plot_panel_box(panel);
    for (int i = 0; i < o->n_event; i++) {
        const double x = plot_axis_at(&panel->x, o->events[i].time);
        if (!o->events[i].touch)
            plot_page_line(o->page, PLOT_GRID, 2, (plot_point[]){{x, box.bottom}, {x, box.top}});
    }
}

static void draw_displacements(orbit *o, plot_box box, bool numbers)
{
    plot_legend_entry entries[MAX_SHOWN];
    char names[MAX_SHOWN][24];
    double lo = INFINITY, hi = -INFINITY;
    for (int i = 0; i < o->n_shown; i++)
        read_range(o, read_x, o->shown[i], &lo, &hi);
    plot_range_widen(false, 0.07, &lo, &hi);
    const plot_panel panel = {time_axis(o, box.left, box.right), axis_over(lo, hi, box.bottom, box.top)};
    draw_event_lines(o, &panel);
    for (int i = 0; i < o->n_shown; i++) {
        draw_flights(o, &panel, PLOT_SERIES + (plot_stroke)i, read_time, read_x, o->shown[i]);
        snprintf(names[i], sizeof names[i], "x_{%d}", o->shown[i] + 1);
        entries[i] = (plot_legend_entry){names[i], PLOT_SERIES + i, -1};
    }
    plot_panel_frame(o->page, &panel, numbers ? "" : NULL, "scaled displacement");
    plot_legend(o->page, o->n_shown, entries, box.left, box.right, box.top + 22);
}

static void gap_name(const orbit *o, int contact, size_t size, char *out)
{
    ric_contact c;
    char name[60];
    if (ric_model_contact(o->model, contact, &c) == RIC_OK && c.name && *c.name) {
        plot_text_escape(c.name, sizeof name, name);
        snprintf(out, size, "gap at %s", name);
    } else {
        snprintf(out, size, "gap %d", contact + 1);
    }
}

/* Whether a stop on this side exists among the gaps shown. */
static bool has_side(const orbit *o, int side)
{
    for (int i = 0; i < o->n_gap; i++)
        if (face_of(o, o->gaps[i], side) >= 0)
            return true;
    return false;
}

/* The letter of a face beside its mark, in one of three rows beyond the stop; left out where all three are taken. */
static void draw_letter(orbit *o, plot_point at, int side, int face)
{
    char letter[24], text[48];
    if (ric_word_format(o->model, 1, &face, sizeof letter, letter) != RIC_OK)
        return;
    plot_text_escape(letter, sizeof text, text);
    for (int line = 0; line < 3; line++) {
        const plot_point place = {at.x, at.y + side * (13 + 13.5 * line)};
        plot_box box = plot_text_box(place, PLOT_CENTRE, type - 1, false, text);
        box.left += 0.5;
        box.right -= 0.5;
        if (!plot_page_free_box(o->page, box))
            continue;
        plot_page_text(o->page, place, PLOT_CENTRE, type - 1, "#000000", false, text);
        return;
    }
    o->missing++;
}

static void draw_gap_events(orbit *o, const plot_panel *panel)
{
    for (int round = 0; round < 2; round++) /* letters after all marks */
        for (int i = 0; i < o->n_event; i++) {
            const event *e = &o->events[i];
            int contact, side, mirror;
            bool shown = false;
            if (ric_model_face(o->model, e->face, &contact, &side, &mirror) != RIC_OK)
                continue;
            for (int k = 0; k < o->n_gap; k++)
                shown |= o->gaps[k] == contact;
            const plot_point at = plot_panel_at(panel, (plot_point){e->time, side});
            if (shown && round == 0)
                plot_page_mark(o->page, e->touch ? PLOT_CIRCLE : PLOT_DOT, at, 3.6);
            else if (shown)
                draw_letter(o, at, side, e->face);
        }
}

static void draw_gaps(orbit *o, plot_box box)
{
    const double room = 50; /* pixels beyond a stop, for three rows of letters */
    const bool upper = has_side(o, 1), lower = has_side(o, -1);
    double lo = lower ? -1 : 0, hi = upper ? 1 : 0;
    plot_legend_entry entries[MAX_SHOWN + 2];
    char names[MAX_SHOWN][80];
    int n = 0;
    for (int i = 0; i < o->n_gap; i++)
        read_range(o, read_gap, o->gaps[i], &lo, &hi);
    const double above = upper ? room : 12, below = lower ? room : 12, scale = (hi - lo) / fmax(20, box.top - box.bottom - above - below);
    const plot_panel panel = {time_axis(o, box.left, box.right), axis_over(lo - below * scale, hi + above * scale, box.bottom, box.top)};
    draw_event_lines(o, &panel);
    for (int side = -1; side <= 1; side += 2)
        if (has_side(o, side)) {
            const double y = plot_axis_at(&panel.y, side);
            plot_page_line(o->page, PLOT_STOP, 2, (plot_point[]){{box.left, y}, {box.right, y}});
        }
    for (int i = 0; i < o->n_gap; i++) {
        draw_flights(o, &panel, PLOT_SERIES + (plot_stroke)i, read_time, read_gap, o->gaps[i]);
        gap_name(o, o->gaps[i], sizeof names[i], names[i]);
        entries[n++] = (plot_legend_entry){names[i], PLOT_SERIES + i, -1};
    }
    entries[n++] = (plot_legend_entry){"stop", PLOT_STOP, -1};
    plot_panel_frame(o->page, &panel, "time (s)", "gap / clearance");
    draw_gap_events(o, &panel);
    bool hit = false, touch = false;
    for (int i = 0; i < o->n_event; i++) {
        touch |= o->events[i].touch;
        hit |= !o->events[i].touch;
    }
    plot_legend(o->page, n, entries, box.left, box.right, box.top + 22);
    if (hit || touch) {
        plot_legend_entry marks[2];
        int k = 0;
        if (hit)
            marks[k++] = (plot_legend_entry){"impact", -1, PLOT_DOT};
        if (touch)
            marks[k++] = (plot_legend_entry){"touch", -1, PLOT_CIRCLE};
        plot_legend(o->page, k, marks, box.left, box.right, box.bottom - 42);
    }
}

static void mark_row(const orbit *o, const plot_panel *panel, int coordinate, int index, plot_mark mark)
{
    const double *r = row(o, index);
    plot_page_mark(o->page, mark, plot_panel_at(panel, (plot_point){read_x(o, r, coordinate), read_v(o, r, coordinate)}), 3);
}

static void draw_portrait(orbit *o, int coordinate, plot_box box)
{
    double x[2] = {INFINITY, -INFINITY}, v[2] = {INFINITY, -INFINITY};
    char across[24], up[24];
    read_range(o, read_x, coordinate, &x[0], &x[1]);
    read_range(o, read_v, coordinate, &v[0], &v[1]);
    plot_range_widen(false, 0.07, &x[0], &x[1]);
    plot_range_widen(false, 0.07, &v[0], &v[1]);
    const plot_panel panel = {axis_over(x[0], x[1], box.left, box.right), axis_over(v[0], v[1], box.bottom, box.top)};
    draw_flights(o, &panel, PLOT_SERIES, read_x, read_v, coordinate);
    snprintf(across, sizeof across, "x_{%d}", coordinate + 1);
    snprintf(up, sizeof up, "v_{%d}", coordinate + 1);
    plot_panel_frame(o->page, &panel, across, up);
    for (int k = 0; o->impacts && k < o->impacts; k++) { /* both sides of every impact */
        mark_row(o, &panel, coordinate, o->first[k], PLOT_DOT);
        mark_row(o, &panel, coordinate, o->first[k + 1] - 1, PLOT_DOT);
    }
    for (int i = 0; i < o->n_event; i++)
        if (o->events[i].touch)
            mark_row(o, &panel, coordinate, o->events[i].sample, PLOT_CIRCLE);
}

static void draw_portraits(orbit *o, plot_box area)
{
    const int columns = o->n_shown > 2 ? 2 : 1, lines = (o->n_shown + columns - 1) / columns;
    const double width = (area.right - area.left) / columns, height = (area.top - area.bottom) / lines;
    for (int i = 0; i < o->n_shown; i++) {
        const double left = area.left + width * (i % columns), top = area.top - height * (i / columns);
        draw_portrait(o, o->shown[i], (plot_box){left + 62, top - height + 46, left + width - 8, top - 6});
    }
}

static int draw(orbit *o)
{
    const double width = o->common->width > 0 ? o->common->width : 1000, height = o->common->height > 0 ? o->common->height : 640;
    o->page = plot_page_create(width, height);
    if (!o->page)
        return cli_report(RIC_E_NOMEM);
    const double split = width * (o->n_shown > 2 ? 0.52 : 0.62), foot = 64, head = 58, middle = foot + (height - foot - head) * 0.52;
    draw_displacements(o, (plot_box){64, middle + 30, split - 8, height - head}, false);
    draw_gaps(o, (plot_box){64, foot, split - 8, middle - 4});
    draw_portraits(o, (plot_box){split, foot - 46, width - 8, height - 30});
    plot_page_text(o->page, (plot_point){width / 2, height - 18}, PLOT_CENTRE, type + 2, "#000000", false, o->title);
    if (o->missing)
        fprintf(stderr, "ricochet: %d letter%s of impacts left out for want of room; --size makes more\n", o->missing, o->missing == 1 ? "" : "s");
    return plot_page_write(o->page, o->common->out);
}

static int parse(int *argc, char **argv, words *w)
{
    static const char *const names[] = {"--branch", "--junction", "--point", "--energy", "--frequency", "--which", "--coordinates"};
    const char **values[] = {&w->branch, &w->junction, &w->point, &w->energy, &w->frequency, &w->which, &w->coordinates};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!cli_take_value(argc, argv, names[i], values[i]))
            return CLI_WRONG;
    const int places = (w->point != NULL) + (w->energy != NULL) + (w->frequency != NULL);
    if (!w->branch == !w->junction)
        return cli_wrong("plot orbit: give either --branch ID with a place on it, or --junction ID");
    if (w->junction && (places || w->which))
        return cli_wrong("plot orbit: --junction ID is one orbit; --point, --energy, --frequency and --which go with --branch");
    if (w->branch && places != 1)
        return cli_wrong("plot orbit: --branch needs one of --point I, --energy E, --frequency F");
    return cli_operands(&cli_plot, *argc, argv, 1) ? CLI_DONE : CLI_WRONG;
}

static int find_and_draw(orbit *o, const words *w)
{
    o->model = ric_atlas_model(o->atlas);
    o->n = ric_model_n_dof(o->model);
    int code = w->junction ? take_junction(o, w->junction) : take_branch(o, w);
    if (code != CLI_DONE)
        return code;
    if (w->coordinates && !take_coordinates(o, w->coordinates))
        return CLI_WRONG;
    if (!w->coordinates)
        usual_coordinates(o);
    const ric_status status = make_motion(o);
    if (status != RIC_OK)
        return cli_report(status);
    choose_gaps(o);
    return draw(o);
}

int plot_orbit(int argc, char **argv, const plot_options *common)
{
    orbit o = {.common = common};
    words w = {0};
    int code = parse(&argc, argv, &w);
    if (code != CLI_DONE)
        return code;
    const ric_status status = ric_atlas_read(argv[1], &o.atlas);
    if (status != RIC_OK)
        return cli_report(status);
    code = find_and_draw(&o, &w);
    plot_page_free(o.page);
    ric_atlas_free(o.atlas);
    free(o.word);
    free(o.state);
    free(o.flights);
    free(o.first);
    free(o.rows);
    free(o.events);
    return code;
}
