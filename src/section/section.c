#include "section.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* A given state is on a face where its gap is within this part of the clearance: stored orbits are
 * solved to less. */
#define ON_FACE 1e-9
/* A given state has the energy asked for within this part of it: that of a stored orbit, and of
 * what was printed. */
#define ITS_ENERGY 1e-9
/* Points of the sequence that are tried for each start: other contacts may cut most of the ball
 * away. */
enum { TRIES = 2000 };
/* Places after which progress is shown and a stop is looked for: a few milliseconds. */
enum { PAUSE = 4096 };
/* ROWS: bytes that the places on the section may take. */
#define ROWS_MOST 8e9

void ric_section_options_init(ric_section_options *options)
{
    *options = (ric_section_options){.starts = 16, .impacts = 1000, .workers = 1, .rows = true};
}

/* ------------------------------------------------------------------ create */

static ric_status check_options(const ric_model *m, const ric_section_options *o)
{
    if (!(o->energy > 0) || !isfinite(o->energy))
        return ric_fail(RIC_E_INPUT, "a section needs a scaled energy above 0, not %.9g",
                        o->energy);
    if (ric_model_restitution(m) != 1)
        return ric_fail(
            RIC_E_INPUT,
            "restitution %.9g takes energy at every impact: no section of one energy; set it to "
            "1, or follow single motions with `ricochet simulate`",
            ric_model_restitution(m));
    if (m->n_contact == 0 || m->n == 0)
        return ric_fail(
            RIC_E_INPUT,
            "the structure has no contact that its modes see: there is nothing to section");
    if (o->starts < 1 || o->impacts < 1)
        return ric_fail(RIC_E_INPUT,
                        "a section needs a start and an impact at least, not %d and %ld", o->starts,
                        o->impacts);
    if (!(o->radius >= 0 && o->radius <= 1))
        return ric_fail(
            RIC_E_INPUT,
            "the radius of starts about a state is a part of the section from 0 to 1, not %.9g",
            o->radius);
    double bytes = (double)o->starts * (double)o->impacts * (2 + 2 * m->n) * (double)sizeof(double);
    if (o->rows && bytes > ROWS_MOST)
        return ric_fail(
            RIC_E_INPUT,
            "%d starts of %ld impacts need %.2g bytes; take fewer, or keep the exponents only",
            o->starts, o->impacts, bytes);
    return RIC_OK;
}

/* The face that a given state is on: *into if it moves towards the contact. -1: it is in flight. */
static int face_of(const ric_section *s, const double *w, bool *into)
{
    for (int i = 0; i < s->surface->n_face; i++) {
        const ric_section_face *f = &s->surface->face[i];
        double off = ric_dot(s->m->n, f->g, w) - f->gap,
               speed = ric_dot(s->m->n, f->c, w + s->m->n) * f->side;
        if (fabs(off) > ON_FACE * fmax(fabs(f->gap), f->radius)) continue;
        *into = speed < 0;
        if (speed > 0 || !(f->spring || s->surface->smooth)) return i;
    }
    return -1;
}

/* Puts a state that is in flight onto the section. */
static ric_status fly_on(const ric_section *s, double *w, int *face, uint64_t *closed)
{
    ric_section_motion *motion;
    ric_status status = ric_section_motion_create(s->m, s->surface->energy, &motion);
    if (status) return status;
    ric_section_motion_start(motion, *closed, -1, w);
    status = ric_section_motion_next(motion, face);
    if (!status && motion->why[0])
        status = ric_fail(RIC_E_INPUT, "the state given never comes to the section: %s",
                          motion->why);
    memcpy(w, motion->w, 2 * (size_t)s->m->n * sizeof *w);
    *closed = motion->closed;
    ric_section_motion_free(motion);
    return status;
}

static ric_status read_given(const ric_section *s, int i, double *w, int *face, uint64_t *closed)
{
    const ric_model *m = s->m;
    int dof = m->n_dof;
    bool outside, into = false;
    const double *state = s->options.given + (size_t)i * 2 * (size_t)dof;
    ric_model_from_state(m, state, state + dof, w);
    *face = face_of(s, w, &into);
    *closed = ric_section_surface_closed(m, w, *face, &outside);
    if (outside)
        return ric_fail(RIC_E_INPUT, "state %d is beyond a stop; give one on this side of it",
                        i + 1);
    double energy = ric_flight_energy(m, *closed, w) * m->energy_unit;
    if (!(fabs(energy - s->options.energy) <= ITS_ENERGY * s->options.energy))
        return ric_fail(
            RIC_E_INPUT,
            "state %d has the scaled energy %.17g in the modes that contacts see, and the "
            "section that of %.17g",
            i + 1, energy, s->options.energy);
    if (*face < 0) return fly_on(s, w, face, closed);
    const ric_section_face *f = &s->surface->face[*face];
    ric_section_motion_onto(m->n, f->g, f->gap, w);
    if (f->spring) *closed |= (uint64_t)1 << *face;
    else if (into && !s->surface->smooth) ric_impact_reflect(m->n, &m->face[*face], w + m->n);
    return RIC_OK;
}

/* The next place of the sequence, about the given ones or on the faces in turn; false: none is
 * left. */
static bool scatter(const ric_section *s, const ric_section_run_of *centres, int n_centre, long *k,
                    int i, ric_section_run_of *out)
{
    int size = 2 * (s->m->n - 1);
    double b[size + 1], middle[size + 1];
    const ric_section_run_of *centre = &centres[i % n_centre];
    out->face = centre->face;
    for (int t = 0; t < TRIES; t++) {
        if (centre->w) ric_section_surface_place(s->surface, centre->face, centre->w, middle);
        ric_section_surface_sequence(size, ++k[i % n_centre], b);
        for (int j = 0; centre->w && j < size; j++) b[j] = middle[j] + s->options.radius * b[j];
        if (ric_section_surface_at(s->surface, out->face, b, out->w, &out->closed)) return true;
        if (size == 0) return false;
    }
    return false;
}

/* Whether some motion leaves a face with all other gaps open; a start of the sequence is tried. */
static bool has_place(const ric_section *s, int face)
{
    double w[2 * s->m->n];
    long k = 0;
    ric_section_run_of centre = {.face = face}, found = {.w = w};
    return scatter(s, &centre, 1, &k, 0, &found);
}

/* Centres: the given states, or the faces that count, without one. */
static ric_status find_centres(ric_section *s, ric_section_run_of *centres, double *states,
                               int *n_centre)
{
    const ric_section_options *o = &s->options;
    ric_status status = RIC_OK;
    *n_centre = 0;
    for (int i = 0; i < o->n_given && !status; i++) {
        ric_section_run_of *c = &centres[(*n_centre)++];
        c->w = states + (size_t)i * 2 * (size_t)s->m->n;
        status = read_given(s, i, c->w, &c->face, &c->closed);
    }
    for (int f = 0; f < s->surface->n_face && o->n_given == 0; f++) {
        const ric_section_face *face = &s->surface->face[f];
        if (face->radius > 0 && (face->image < 0 || face->image > f) && has_place(s, f))
            centres[(*n_centre)++].face = f;
    }
    if (!status && *n_centre == 0)
        return ric_fail(RIC_E_INPUT,
                        "no motion of scaled energy %.9g was found that leaves a contact with all "
                        "other gaps open, among "
                        "%d places on each; take another energy",
                        o->energy, (int)TRIES);
    return status;
}

static ric_status make_starts(ric_section *s, ric_section_run_of *centres, int n_centre, long *k)
{
    const ric_section_options *o = &s->options;
    size_t size = 2 * (size_t)s->m->n;
    if (o->n_given > 0 && o->radius == 0) s->n_start = o->n_given;
    else if (s->m->n == 1) s->n_start = o->starts < n_centre ? o->starts : n_centre;
    else s->n_start = o->starts;
    s->starts = ric_calloc((size_t)s->n_start, sizeof *s->starts);
    s->states = ric_calloc((size_t)s->n_start * size, sizeof *s->states);
    if (!s->starts || !s->states) return ric_no_memory("the starts of a section");
    for (int i = 0; i < s->n_start; i++) {
        ric_section_run_of *start = &s->starts[i];
        start->w = s->states + (size_t)i * size;
        if (o->n_given > 0 && i < n_centre) {
            memcpy(start->w, centres[i].w, size * sizeof *start->w);
            start->face = centres[i].face;
            start->closed = centres[i].closed;
        } else if (!scatter(s, centres, n_centre, k, i, start)) {
            return ric_fail(RIC_E_INPUT,
                            "among %d places on face %d there is none with all other gaps open at "
                            "scaled energy %.9g; "
                            "ask for fewer starts",
                            (int)TRIES, start->face, o->energy);
        }
        start->track = (ric_section_track){.face = start->face,
                                           .rotation = NAN,
                                           .rotation_error = NAN,
                                           .lyapunov = NAN,
                                           .lyapunov_error = NAN,
                                           .why = "stopped before it began"};
    }
    return RIC_OK;
}

ric_status ric_section_create(const ric_model *model, const ric_section_options *options,
                              ric_section **out)
{
    ric_status status = check_options(model, options);
    ric_section *s = NULL;
    ric_section_run_of *centres = NULL;
    double *states = NULL;
    long *k = NULL;
    int n_centre = 0;
    *out = NULL;
    if (status) return status;
    if (!(s = ric_calloc(1, sizeof *s))) return ric_no_memory("a section");
    pthread_mutex_init(&s->lock, NULL);
    s->m = model;
    s->options = *options;
    if ((status = ric_section_surface_create(model, options->energy / model->energy_unit,
                                             &s->surface)))
        goto out;
    size_t most = (size_t)(options->n_given > s->surface->n_face ? options->n_given
                                                                 : s->surface->n_face) +
                  1;
    centres = ric_calloc(most, sizeof *centres);
    states = ric_calloc(most * 2 * (size_t)model->n, sizeof *states);
    k = ric_calloc(most, sizeof *k);
    if (!centres || !states || !k) status = ric_no_memory("the starts of a section");
    if (!status) status = find_centres(s, centres, states, &n_centre);
    if (!status) status = make_starts(s, centres, n_centre, k);
out:
    free(centres);
    free(states);
    free(k);
    s->options.given = NULL;
    if (!status) *out = s;
    else ric_section_free(s);
    return status;
}

void ric_section_free(ric_section *s)
{
    if (!s) return;
    for (int i = 0; s->starts && i < s->n_start; i++) free(s->starts[i].rows);
    ric_section_surface_free(s->surface);
    pthread_mutex_destroy(&s->lock);
    free(s->starts);
    free(s->states);
    free(s);
}

/* --------------------------------------------------------------------- run */

/* Asks whether to stop; another thread that asks at this moment does it for all. */
static void pause_here(ric_section *s, long more)
{
    double whole = (double)s->n_start * (double)s->options.impacts;
    atomic_fetch_add(&s->done, more);
    if (!s->options.progress || pthread_mutex_trylock(&s->lock)) return;
    if (s->options.progress((double)atomic_load(&s->done) / whole, s->options.user)) s->stop = true;
    pthread_mutex_unlock(&s->lock);
}

static void keep_row(const ric_section *s, ric_section_run_of *start,
                     const ric_section_motion *motion, int face)
{
    size_t size = 2 * (size_t)s->m->n;
    double *row = start->rows + (size_t)start->n_row * (2 + size);
    row[0] = motion->time;
    row[1] = face;
    memcpy(row + 2, motion->w, size * sizeof *row);
}

/* The energy from the raw matrices, which share nothing with the motion. */
static double energy_error(const ric_section *s, const ric_section_motion *motion)
{
    int dof = s->m->n_dof;
    double x[2 * dof];
    ric_model_to_state(s->m, motion->w, x, x + dof);
    return fabs(ric_model_energy(s->m, x, x + dof) / s->options.energy - 1);
}

/* A part of the motion is over: its growth. */
static void end_batch(const ric_section *s, ric_section_motion *motion, ric_section_track *t)
{
    ric_section_measure *measure = &motion->measure;
    int k = measure->n_batch++;
    measure->growth[k] = ric_section_measure_growth(measure, motion->u);
    measure->time[k] = motion->time;
    t->energy_error = fmax(t->energy_error, energy_error(s, motion));
}

static void take_measures(const ric_section *s, const ric_section_motion *motion,
                          ric_section_run_of *start)
{
    ric_section_track *t = &start->track;
    long flights = start->n_row - 1;
    double unit = s->m->omega_ref;
    t->impacts = start->n_row;
    t->time = motion->time / unit;
    ric_section_measure_exponent(&motion->measure, flights, &t->lyapunov, &t->lyapunov_error);
    t->lyapunov *= unit;
    t->lyapunov_error *= unit;
    t->rotation = t->rotation_error = NAN;
    if (s->m->n != 2 || flights < 1 || !(t->lyapunov <= 2 * t->lyapunov_error)) return;
    t->rotation = ric_section_measure_rotation(&motion->measure, flights);
    t->rotation_error = 1 / (double)flights;
}

/* Batches end where the flights so far are equal parts of those asked for. */
static bool batch_is_over(const ric_section *s, const ric_section_motion *motion, long flights)
{
    long whole = s->options.impacts - 1;
    return flights * RIC_SECTION_BATCHES >= (motion->measure.n_batch + 1) * whole;
}

static ric_status follow(ric_section *s, ric_section_motion *motion, ric_section_run_of *start)
{
    ric_section_track *t = &start->track;
    int face = start->face;
    ric_status status = RIC_OK;
    ric_section_motion_start(motion, start->closed, face, start->w);
    t->energy_error = energy_error(s, motion);
    for (long k = 0; !status; k++) {
        start->n_row = k;
        if (start->rows) keep_row(s, start, motion, face);
        start->n_row++;
        if (k > 0 && batch_is_over(s, motion, k)) end_batch(s, motion, t);
        if (k + 1 == s->options.impacts) break;
        if ((k + 1) % PAUSE == 0) pause_here(s, PAUSE);
        if (s->stop) snprintf(motion->why, sizeof motion->why, "stopped on request");
        else status = ric_section_motion_next(motion, &face);
        if (motion->why[0]) break;
    }
    if (motion->why[0] && motion->measure.n_batch < RIC_SECTION_BATCHES) end_batch(s, motion, t);
    snprintf(t->why, sizeof t->why, "%s", motion->why);
    take_measures(s, motion, start);
    pause_here(s, start->n_row % PAUSE);
    return status;
}

static ric_status follow_next(ric_section *s, ric_section_motion *motion, bool *more)
{
    int i = atomic_fetch_add(&s->next, 1);
    *more = i < s->n_start && !s->stop;
    if (!*more) return RIC_OK;
    ric_section_run_of *start = &s->starts[i];
    size_t row = (2 + 2 * (size_t)s->m->n) * sizeof *start->rows;
    if (s->options.rows && !(start->rows = ric_malloc((size_t)s->options.impacts * row)))
        return ric_no_memory("the impacts of a section");
    return follow(s, motion, start);
}

static void *work(void *user)
{
    ric_section *s = user;
    ric_section_motion *motion = NULL;
    bool more = true;
    ric_status status = ric_section_motion_create(s->m, s->surface->energy, &motion);
    while (!status && more) status = follow_next(s, motion, &more);
    ric_section_motion_free(motion);
    if (!status) return NULL;
    pthread_mutex_lock(&s->lock);
    if (!s->status) {
        s->status = status;
        snprintf(s->detail, sizeof s->detail, "%s", ric_detail());
    }
    pthread_mutex_unlock(&s->lock);
    s->stop = true;
    return NULL;
}

ric_status ric_section_run(ric_section *s)
{
    int wanted = s->options.workers < s->n_start ? s->options.workers : s->n_start, started = 0;
    pthread_t *threads = wanted > 1 ? ric_calloc((size_t)wanted, sizeof *threads) : NULL;
    while (threads && started < wanted - 1 && !pthread_create(&threads[started], NULL, work, s))
        started++;
    work(s);
    for (int i = 0; i < started; i++) pthread_join(threads[i], NULL);
    free(threads);
    if (s->status) return ric_fail(s->status, "%s", s->detail);
    return s->stop ? ric_fail(RIC_E_INTERRUPTED, "stopped on request") : RIC_OK;
}

/* ----------------------------------------------------------------- answers */

int ric_section_n_start(const ric_section *s)
{
    return s->n_start;
}

ric_status ric_section_track_at(const ric_section *s, int start, ric_section_track *out)
{
    if (start < 0 || start >= s->n_start)
        return ric_fail(RIC_E_RANGE, "there is no start %d; they are numbered from 0 to %d", start,
                        s->n_start - 1);
    *out = s->starts[start].track;
    return RIC_OK;
}

ric_status ric_section_impact(const ric_section *s, int start, long impact, double *time, int *face,
                              double *x, double *v)
{
    ric_section_track track;
    double spare[2 * s->m->n_dof];
    ric_status status = ric_section_track_at(s, start, &track);
    if (status) return status;
    const ric_section_run_of *run = &s->starts[start];
    if (!run->rows || impact < 0 || impact >= run->n_row)
        return ric_fail(RIC_E_RANGE, "start %d has no impact %ld; %ld are kept", start, impact,
                        run->rows ? run->n_row : 0L);
    const double *row = run->rows + (size_t)impact * (2 + 2 * (size_t)s->m->n);
    if (time) *time = row[0] / s->m->omega_ref;
    if (face) *face = (int)row[1];
    ric_model_to_state(s->m, row + 2, x ? x : spare, v ? v : spare + s->m->n_dof);
    return RIC_OK;
}

ric_status ric_section_place(const ric_section *s, int face, const double *x, const double *v,
                             double *place)
{
    double w[2 * s->m->n];
    if (face < 0 || face >= s->surface->n_face || s->surface->face[face].radius == 0)
        return ric_fail(RIC_E_RANGE, "no motion of this energy is on a face %d", face);
    ric_model_from_state(s->m, x, v, w);
    ric_section_surface_place(s->surface, face, w, place);
    return RIC_OK;
}

ric_status ric_section_state(const ric_section *s, int face, const double *place, double *x,
                             double *v)
{
    double w[2 * s->m->n];
    uint64_t closed;
    if (face < 0 || face >= s->surface->n_face ||
        !ric_section_surface_at(s->surface, face, place, w, &closed))
        return ric_fail(RIC_E_RANGE, "no motion of this energy is at this place of face %d", face);
    ric_model_to_state(s->m, w, x, v);
    return RIC_OK;
}

int ric_section_image(const ric_section *s, int face)
{
    return face >= 0 && face < s->surface->n_face ? s->surface->face[face].image : -1;
}
