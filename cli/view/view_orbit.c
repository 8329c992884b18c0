/* The orbit at any place of a branch, with its history, for the page of `ricochet view`. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view.h"

enum {
    SAMPLES_PER_CYCLE = 24, /* of the highest mode */
    SAMPLES_AT_LEAST = 6,   /* of one flight */
    SAMPLES_ALONE = 300, /* of the only flight of an orbit: under a power law it has more harmonics
                            than the linear modes tell */
    NUMBERS_AT_MOST =
        200000 /* in one history; long orbits of large models are sampled more coarsely */
};

/* ------------------------------------------------------------------ history */

typedef struct {
    const ric_orbit *orbit;
    int n_dof;
    double *x, *v;
    json_t *t, *xs, *vs; /* times; one array per degree of freedom in the others */
} history;

static void add_sample(history *h, double t, double at)
{
    ric_orbit_at_time(h->orbit, at, h->x, h->v);
    json_array_append_new(h->t, cli_number(t));
    for (int i = 0; i < h->n_dof; i++) {
        json_array_append_new(json_array_get(h->xs, (size_t)i), cli_number(h->x[i]));
        json_array_append_new(json_array_get(h->vs, (size_t)i), cli_number(h->v[i]));
    }
}

/* One period, flight by flight. Each impact appears twice, with the velocity before and after it:
 * the last sample of a flight is taken just before its end, where it differs from the limit by less
 * than a pixel of any picture. */
static void add_flights(history *h, int n_flight, const double *flights, double highest)
{
    const double before = 1 - 1e-10;
    double period = 0, begin = 0;
    for (int k = 0; k < n_flight; k++) period += flights[k];
    const double wanted = n_flight * (SAMPLES_AT_LEAST + 1) + SAMPLES_ALONE +
                          SAMPLES_PER_CYCLE * period * highest / CLI_TWO_PI;
    const double thin = fmin(1, NUMBERS_AT_MOST / (2.0 * h->n_dof * wanted));
    for (int k = 0; k < n_flight; k++) {
        const int n = (int)fmax(2, thin * ((n_flight > 1 ? SAMPLES_AT_LEAST : SAMPLES_ALONE) +
                                           SAMPLES_PER_CYCLE * flights[k] * highest / CLI_TWO_PI));
        for (int i = 0; i <= n; i++) {
            const double part = (double)i / n;
            add_sample(h, begin + part * flights[k], begin + fmin(part, before) * flights[k]);
        }
        begin += flights[k];
    }
}

static json_t *make_history(const ric_orbit *orbit, const ric_model *model, int n_flight,
                            const double *flights)
{
    const int n = ric_model_n_dof(model);
    double *work = calloc(3 * (size_t)n, sizeof *work);
    history h = {.orbit = orbit,
                 .n_dof = n,
                 .x = work,
                 .v = work + n,
                 .t = json_array(),
                 .xs = json_array(),
                 .vs = json_array()};
    if (!work || ric_model_frequencies(model, work + 2 * n)) {
        free(work);
        return json_null();
    }
    for (int i = 0; i < n; i++) {
        json_array_append_new(h.xs, json_array());
        json_array_append_new(h.vs, json_array());
    }
    add_flights(&h, n_flight, flights, work[3 * n - 1]);
    free(work);
    json_t *object = json_object();
    json_object_set_new(object, "t", h.t);
    json_object_set_new(object, "x", h.xs);
    json_object_set_new(object, "v", h.vs);
    return object;
}

/* --------------------------------------------------------------------- rows */

/* Time and face of each impact, or closing of a spring; speeds and impulses are in the row already.
 * Where a spring opens is no impact. */
static void add_impacts(json_t *row, int n, const int *word, const double *flights, int n_face)
{
    json_t *times = json_array(), *faces = json_array();
    double t = 0;
    for (int k = 0; k < n; k++) {
        if (word[k] < n_face) {
            json_array_append_new(times, cli_number(t));
            json_array_append_new(faces, json_integer(word[k]));
        }
        t += flights[k];
    }
    json_object_set_new(row, "impact_times", times);
    json_object_set_new(row, "impact_faces", faces);
}

static ric_status add_orbit(const ric_atlas *atlas, const ric_orbit *orbit, bool moving,
                            json_t *rows)
{
    const ric_model *model = ric_atlas_model(atlas);
    const int n = ric_orbit_letters(orbit);
    ric_point point;
    double *flights = calloc((size_t)n + 1, sizeof *flights);
    int *word = calloc((size_t)n + 1, sizeof *word);
    ric_status status = flights && word ? cli_orbit_row(orbit, model, 1, rows) : RIC_E_NOMEM;
    if (!status) {
        json_t *row = json_array_get(rows, json_array_size(rows) - 1);
        ric_orbit_data(orbit, &point, NULL, flights, word);
        json_object_set_new(row, "arclength", cli_number(point.arclength));
        json_object_set_new(row, "trace",
                            isfinite(point.trace) ? cli_number(2 * sinh(point.trace))
                                                  : json_null());
        json_object_set_new(row, "rotation", cli_number(point.rotation));
        json_object_set_new(row, "reach", cli_number(point.reach));
        json_object_set_new(row, "approach", cli_number(point.approach));
        json_object_set_new(row, "residual", cli_number((double)point.residual));
        add_impacts(row, n, word, flights, ric_model_n_face(model));
        if (moving)
            json_object_set_new(row, "history", make_history(orbit, model, n > 0 ? n : 1, flights));
    }
    free(flights);
    free(word);
    return status;
}

/* ------------------------------------------------------------------- places */

/* An arclength between stored points i and i + 1 as what ric_orbit_find can be asked for: the
 * energy or the frequency at that part of the interval, whichever differs more between the points,
 * so that neither an extremum nor a level branch is asked for what it does not have. */
typedef struct {
    ric_at at[2];
    double value[2], from, to;
    int n;
} place;

static ric_status locate(const ric_atlas *atlas, const ric_branch *b, double s, place *out)
{
    ric_point p, q;
    int i = 0, j = b->n_point - 1;
    ric_status status = ric_atlas_point(atlas, b->id, 0, &p, NULL, NULL);
    if (!status) status = ric_atlas_point(atlas, b->id, j, &q, NULL, NULL);
    while (!status && j - i > 1) {
        ric_point middle;
        const int k = i + (j - i) / 2;
        if (!(status = ric_atlas_point(atlas, b->id, k, &middle, NULL, NULL))) {
            if (middle.arclength <= s) {
                i = k;
                p = middle;
            } else {
                j = k;
                q = middle;
            }
        }
    }
    if (status) return status;
    *out = (place){.from = p.arclength, .to = q.arclength};
    const double part = q.arclength > p.arclength ? (s - p.arclength) / (q.arclength - p.arclength)
                                                  : 0;
    /* where a tongue was stepped over there are no orbits in between */
    if (part <= 0 || part >= 1 || ric_branch_steps_over(atlas, b->id, i)) {
        out->n = 1;
        out->at[0] = RIC_AT_POINT;
        out->value[0] = part < 0.5 ? i : j;
        return RIC_OK;
    }
    const bool linear = ric_branch_linear(ric_atlas_model(atlas), b);
    const bool by_energy = linear ||
                           fabs(q.energy / p.energy - 1) > fabs(q.frequency / p.frequency - 1);
    const double energy = linear ? q.energy * (s / q.arclength) * (s / q.arclength)
                                 : p.energy + part * (q.energy - p.energy);
    const double frequency = p.frequency + part * (q.frequency - p.frequency);
    out->n = linear ? 1 : 2; /* the second if the first fails */
    out->at[0] = by_energy ? RIC_AT_ENERGY : RIC_AT_FREQUENCY;
    out->value[0] = by_energy ? energy : frequency;
    out->at[1] = by_energy ? RIC_AT_FREQUENCY : RIC_AT_ENERGY;
    out->value[1] = by_energy ? frequency : energy;
    return RIC_OK;
}

/* Of the orbits that fit the one whose arclength is nearest to s, if it lies between the two
 * points. */
static const ric_orbit *nearest(int n, ric_orbit *const *orbits, const place *where, double s)
{
    const ric_orbit *best = NULL;
    double least = INFINITY;
    for (int i = 0; i < n; i++) {
        ric_point p;
        ric_orbit_data(orbits[i], &p, NULL, NULL, NULL);
        const double slack = 1e-9 * (1 + fabs(where->to)), distance = fabs(p.arclength - s);
        if ((where->at[0] == RIC_AT_POINT ||
             (p.arclength >= where->from - slack && p.arclength <= where->to + slack)) &&
            distance < least) {
            least = distance;
            best = orbits[i];
        }
    }
    return best;
}

/* Whether a proof of the stored point is kept: in the last row. */
static void add_proof(const ric_atlas *atlas, int branch, int point, json_t *rows)
{
    const size_t n = json_array_size(rows);
    ric_proof proof;
    if (n > 0)
        json_object_set_new(json_array_get(rows, n - 1), "proved",
                            json_boolean(ric_proof_kept(atlas, branch, point, &proof, NULL) &&
                                         proof.state == RIC_PROOF_DONE));
}

static ric_status orbit_at_arclength(const ric_atlas *atlas, const ric_branch *b, double s,
                                     json_t *rows)
{
    place where = {0};
    ric_status status = locate(atlas, b, s, &where);
    for (int k = 0; !status && k < where.n; k++) {
        ric_orbit **orbits = NULL;
        int n = 0;
        const ric_status found = ric_orbit_find(atlas, b->id, where.at[k], where.value[k], &n,
                                                &orbits);
        const ric_orbit *best = found ? NULL : nearest(n, orbits, &where, s);
        if (best) status = add_orbit(atlas, best, true, rows);
        if (best && !status && where.at[k] == RIC_AT_POINT)
            add_proof(atlas, b->id, (int)where.value[k], rows);
        ric_orbits_free(n, orbits);
        if (best || (found && found != RIC_E_NUMERIC)) return best ? status : found;
    }
    return status;
}

ric_status view_orbits(const ric_atlas *atlas, int id, view_at at, double value, json_t **out)
{
    static const ric_at kinds[] = {RIC_AT_POINT, RIC_AT_ENERGY, RIC_AT_FREQUENCY};
    json_t *rows = json_array();
    ric_orbit **orbits = NULL;
    ric_branch branch;
    int n = 0;
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    if (!status && at == VIEW_AT_ARCLENGTH)
        status = orbit_at_arclength(atlas, &branch, value, rows);
    else if (!status) status = ric_orbit_find(atlas, id, kinds[at], value, &n, &orbits);
    for (int i = 0; !status && i < n; i++) status = add_orbit(atlas, orbits[i], true, rows);
    if (!status && at == VIEW_AT_POINT) add_proof(atlas, id, (int)value, rows);
    ric_orbits_free(n, orbits);
    if (status) {
        json_decref(rows);
        rows = NULL;
    }
    *out = rows;
    return status;
}

/* The orbit by the first way of `locate` alone, so that arclengths between two stored points keep
 * their order. */
static ric_status add_place(const ric_atlas *atlas, const ric_branch *b, double s,
                            json_t *const columns[3])
{
    place where = {0};
    ric_orbit **orbits = NULL;
    int n = 0;
    ric_status status = locate(atlas, b, s, &where);
    if (status || where.at[0] == RIC_AT_POINT) return status;
    status = ric_orbit_find(atlas, b->id, where.at[0], where.value[0], &n, &orbits);
    const ric_orbit *best = status ? NULL : nearest(n, orbits, &where, s);
    if (best) {
        ric_point p;
        ric_orbit_data(best, &p, NULL, NULL, NULL);
        json_array_append_new(columns[0], cli_number(p.arclength));
        json_array_append_new(columns[1], cli_number(p.energy));
        json_array_append_new(columns[2], cli_number(p.frequency));
    }
    ric_orbits_free(n, orbits);
    return status == RIC_E_NUMERIC ? RIC_OK : status;
}

ric_status view_curve(const ric_atlas *atlas, int id, double from, double to, int count,
                      json_t **out)
{
    json_t *const columns[3] = {json_array(), json_array(), json_array()};
    ric_branch branch;
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    for (int i = 0; !status && i < count; i++)
        status = add_place(atlas, &branch, from + (to - from) * i / (count > 1 ? count - 1 : 1),
                           columns);
    *out = json_pack("{s:o,s:o,s:o}", "arclength", columns[0], "energy", columns[1], "frequency",
                     columns[2]);
    if (!status) return RIC_OK;
    json_decref(*out);
    *out = NULL;
    return status;
}

ric_status view_stored_orbit(const ric_atlas *atlas, int branch, int point, json_t **out)
{
    ric_orbit **orbits = NULL;
    int n = 0;
    json_t *rows = json_array();
    ric_status status = ric_orbit_find(atlas, branch, RIC_AT_POINT, point, &n, &orbits);
    if (!status) status = n > 0 ? add_orbit(atlas, orbits[0], false, rows) : RIC_E_NUMERIC;
    ric_orbits_free(n, orbits);
    if (status) {
        json_decref(rows);
        rows = NULL;
    }
    *out = rows;
    return status;
}
