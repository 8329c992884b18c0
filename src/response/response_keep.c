#include "response_keep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define BLURRED 1e-3  /* relative: two orbits at branch points */
#define NO_SPEED 1e-6 /* scaled: of an impact whose multipliers are infinite */

/* --------------------------------------------------------------------- rows */

static bool row_from(ric_response_driver *d, ric_force_orbit *o, const ric_response_orbit *at,
                     ric_response_row *row, ric_status *status)
{
    const int n = o->n, letters = o->events ? o->N : 0;
    const double t = d->medium->time;
    *row = (ric_response_row){0};
    if (!(row->numbers = ric_calloc(ric_response_numbers(n, letters), sizeof *row->numbers))) {
        *status = ric_no_memory("a response");
        return false;
    }
    ric_response_row_arrange(row, n, letters);
    double *state = row->numbers, *flights = state + 2 * n,
           *multipliers = flights + (letters ? letters : 1);
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

ric_force_orbit *ric_response_keep_orbit(ric_response_driver *d, const ric_response_line *line,
                                         const ric_response_row *row)
{
    const int n = d->medium->n, letters = line->data.letters,
              N = letters             ? letters
                  : d->medium->smooth ? 4
                                      : 1,
              faces = d->medium->model->n_face;
    int face[N];
    uint64_t closed[N], now = 0;
    ric_force_orbit *o;
    for (int k = 0; k < 2 * letters;
         k++) { /* twice round: what is closed at the start is known then */
        const int letter = line->word[k % letters], f = letter % faces;
        if (!ric_force_medium_rigid(d->medium, f))
            now = letter >= faces ? now & ~((uint64_t)1 << f) : now | (uint64_t)1 << f;
        face[k % letters] = f;
        closed[k % letters] = now;
    }
    if (!letters) memset(closed, 0, sizeof closed);
    if (ric_force_orbit_create(d->medium, N, letters ? face : NULL, closed, line->data.harmonic,
                               &o))
        return NULL;
    o->drive = (ric_force_drive){row->data.omega / d->medium->time, row->data.level,
                                 row->data.restitution};
    ric_force_motion_enter(d->medium, row->data.state, o->u);
    for (int k = 0; k < N; k++)
        ric_force_orbit_node(o, k)[2 * n + 1] = letters ? row->data.flights[k] * d->medium->time
                                                        : ric_force_orbit_period(o) / N;
    o->u[2 * n] = letters ? row->data.phase : 0;
    if (!ric_force_orbit_spread(o)) return o;
    ric_force_orbit_free(o);
    return NULL;
}

int *ric_response_keep_word(const ric_force_orbit *o)
{
    int *word = ric_calloc((size_t)o->N + 1, sizeof *word);
    for (int k = 0; word && k < o->N && o->events; k++) {
        const bool opens = !ric_force_medium_rigid(o->medium, o->face[k]) &&
                           !ric_face_in(o->closed[k], o->face[k]);
        word[k] = o->face[k] + (opens ? o->medium->model->n_face : 0);
    }
    return word;
}

int ric_response_keep_impacts(const ric_force_orbit *o)
{
    int count = 0;
    for (int k = 0; k < o->N && o->events; k++)
        count += ric_force_medium_rigid(o->medium, o->face[k]) ||
                 ric_face_in(o->closed[k], o->face[k]);
    return count;
}

/* ----------------------------------------------------------- the same orbit */

/* Whether both are one motion at one parameter, or mirror images: their states at one phase of the
 * force. */
static bool same_motion(const ric_response_driver *d, const ric_force_orbit *a,
                        const ric_force_orbit *b, double near)
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

bool ric_response_keep_repeats(const ric_force_orbit *o)
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
        if (most < RIC_RESPONSE_SAME * length) return true;
    }
    return false;
}

double ric_response_keep_value(const ric_response_driver *d, const ric_response_point *p)
{
    return d->trace.along == RIC_ALONG_OMEGA   ? p->omega / d->medium->time
           : d->trace.along == RIC_ALONG_LEVEL ? p->level
                                               : p->restitution;
}

/* Whether the orbit o lies between two neighbouring rows: the one there is solved for. */
static bool between(ric_response_driver *d, const ric_response_line *line, int i,
                    const ric_force_orbit *o, double value)
{
    const ric_response_row *a = &line->points[i], *b = &line->points[i + 1];
    const double from = ric_response_keep_value(d, &a->data),
                 to = ric_response_keep_value(d, &b->data), part = (value - from) / (to - from);
    if (!(part >= 0 && part <= 1)) return false;
    ric_force_orbit *x = ric_response_keep_orbit(d, line, a),
                    *y = ric_response_keep_orbit(d, line, b);
    bool same = false;
    if (x && y) {
        for (int k = 0; k < x->N * x->m; k++) {
            const double off = y->u[k] - x->u[k];
            x->u[k] += part * (k % x->m == 2 * x->n ? remainder(off, RIC_TWO_PI) : off);
        }
        x->drive = o->drive;
        same = ric_force_orbit_solve(x, d->trace.along, d->trace.scale, NULL, 0, NULL) &&
               same_motion(d, o, x, RIC_RESPONSE_SAME);
    }
    ric_force_orbit_free(x);
    ric_force_orbit_free(y);
    return same;
}

int ric_response_keep_known(ric_response_driver *d, ric_force_orbit *o)
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
static int known_event(ric_response_driver *d, ric_force_orbit *o)
{
    int found = 0;
    for (int i = 0; i < d->r->n_event && !found; i++) {
        const ric_response_mark *e = &d->r->events[i];
        const double mine = *ric_force_orbit_parameter(o, d->trace.along),
                     other = ric_response_keep_value(d, &e->data.at);
        if (e->data.kind != RIC_RESPONSE_GRAZING ||
            !(fabs(mine - other) < RIC_RESPONSE_SAME * (1 + fabs(mine))))
            continue;
        ric_force_orbit *x = ric_response_keep_orbit(d, &d->r->curves[e->data.curve - 1], &e->row);
        if (x && x->drive.level == o->drive.level && same_motion(d, o, x, RIC_RESPONSE_SAME))
            found = e->data.id;
        ric_force_orbit_free(x);
    }
    return found;
}

bool ric_response_keep_at_event(ric_response_driver *d, ric_force_orbit *o,
                                const ric_response_mark *e)
{
    const ric_response_line *line = &d->r->curves[e->data.curve - 1];
    const int copies = e->data.kind == RIC_RESPONSE_DOUBLING ? 2 : 1;
    if (e->data.kind != RIC_RESPONSE_DOUBLING && e->data.kind != RIC_RESPONSE_BRANCH_POINT)
        return false;
    if (line->data.harmonic * copies != o->harmonic) return false;
    if (!(fabs(ric_response_keep_value(d, &e->data.at) /
                   *ric_force_orbit_parameter(o, d->trace.along) -
               1) < RIC_RESPONSE_SAME))
        return false;
    ric_force_orbit *once = ric_response_keep_orbit(d, line, &e->row),
                    *x = once ? ric_response_word_repeat(once, copies) : NULL;
    const bool same = x && x->drive.level == o->drive.level && same_motion(d, o, x, BLURRED);
    ric_force_orbit_free(once);
    ric_force_orbit_free(x);
    return same;
}

/* The branch point or doubling at which this orbit of a trace arrives, 0: none that is known. */
static int arrival(ric_response_driver *d, const ric_response_trace *t,
                   const ric_response_orbit *at)
{
    ric_response_trace_put(at, t->shape);
    for (int i = 0; i < d->r->n_event; i++)
        if (ric_response_keep_at_event(d, t->shape, &d->r->events[i]))
            return d->r->events[i].data.id;
    return 0;
}

/* ------------------------------------------------------------------- keeping */

static ric_status keep_events(ric_response_driver *d, ric_response_trace *t, ric_response_curve *c)
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
static ric_status keep(ric_response_driver *d, ric_response_trace *t, int branch, int from)
{
    ric_status status = t->status;
    int *word = status ? NULL : ric_response_keep_word(t->shape);
    ric_response_curve data = {.letters = t->shape->events ? t->shape->N : 0,
                               .impacts = ric_response_keep_impacts(t->shape),
                               .harmonic = t->shape->harmonic,
                               .level = d->trace.along == RIC_ALONG_LEVEL ? NAN
                                                                          : t->shape->drive.level,
                               .branch = branch,
                               .from = from,
                               .begin = from ? RIC_RESPONSE_JOINS : t->other,
                               .end = t->stop};
    if (!status && t->stop == RIC_RESPONSE_JOINS)
        data.to = arrival(d, t, &t->points[t->n_point - 1]);
    if (!status && !from && t->other == RIC_RESPONSE_JOINS)
        data.from = arrival(d, t, &t->points[0]);
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

ric_status ric_response_keep_follow(ric_response_driver *d, ric_force_orbit *o,
                                    const double *direction, int branch, int from)
{
    const int m = o->m;
    double along[m + 1];
    memset(along, 0, sizeof along);
    along[m] = 1;
    if (d->r->n_curve >= d->r->asked.curves) {
        ric_force_orbit_free(o);
        return RIC_OK;
    }
    ric_response_trace *t = ric_response_trace_run(o, &d->trace, direction ? direction : along,
                                                   !direction);
    if (!t) return ric_no_memory("a response");
    if (t->n_point == 0) {
        const ric_status status = t->status;
        ric_response_trace_free(t);
        return status;
    }
    return keep(d, t, branch, from);
}

ric_status ric_response_keep_forgive(ric_response_driver *d, ric_status status)
{
    if (status != RIC_E_NUMERIC) return status;
    d->r->n_skipped++;
    if (!d->r->skipped) d->r->skipped = ric_strdup(ric_detail());
    return d->r->skipped ? RIC_OK : ric_no_memory("a response");
}
