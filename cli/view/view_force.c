/* What a harmonic force and small losses make of the orbits of a branch, for the page of `ricochet
 * view` (docs/forcing.md). */
#include <math.h>
#include <stdlib.h>

#include "view.h"

typedef struct {
    const ric_force *force;
    const view_force_request *ask;
    json_t *arclength, *energy, *omega, *threshold, *stable, *trusted, *amplitudes;
} columns;

static ric_status add_orbit(const columns *c, const ric_orbit *orbit)
{
    ric_prediction p;
    ric_point point;
    const int n = ric_model_n_dof(ric_force_model(c->force));
    double *amplitudes = calloc((size_t)n, sizeof *amplitudes);
    ric_status status = amplitudes ? ric_force_predict(c->force, c->ask->branch, orbit,
                                                       c->ask->harmonic, 0, &p)
                                   : RIC_E_NOMEM;
    if (!status) status = ric_orbit_amplitudes(orbit, amplitudes);
    if (!status) {
        ric_orbit_data(orbit, &point, NULL, NULL, NULL);
        json_t *list = json_array();
        for (int i = 0; i < n; i++) json_array_append_new(list, cli_number(amplitudes[i]));
        json_array_append_new(c->arclength, cli_number(point.arclength));
        json_array_append_new(c->energy, cli_number(p.energy));
        json_array_append_new(c->omega, cli_number(p.omega));
        json_array_append_new(c->threshold, cli_number(p.threshold));
        json_array_append_new(c->stable, json_integer(p.stable));
        json_array_append_new(c->trusted, json_string(p.why));
        json_array_append_new(c->amplitudes, list);
    }
    free(amplitudes);
    return status;
}

/* Stored points, all or evenly chosen ones with both ends; those without energy move nothing. */
static ric_status add_points(const ric_atlas *atlas, const columns *c)
{
    ric_branch b;
    ric_status status = ric_atlas_branch(atlas, c->ask->branch, &b);
    const int n = status ? 0 : b.n_point < VIEW_FORCE_POINTS ? b.n_point : VIEW_FORCE_POINTS;
    for (int k = 0; k < n && !status; k++) {
        const int i = n > 1 ? (int)((long)k * (b.n_point - 1) / (n - 1)) : 0;
        ric_point point;
        ric_orbit **orbits = NULL;
        int found = 0;
        status = ric_atlas_point(atlas, b.id, i, &point, NULL, NULL);
        if (status || !(point.energy > 0)) continue;
        status = ric_orbit_find(atlas, b.id, RIC_AT_POINT, i, &found, &orbits);
        for (int j = 0; j < found && !status; j++) status = add_orbit(c, orbits[j]);
        ric_orbits_free(found, orbits);
    }
    return status;
}

/* Extrema of the threshold: where detached resonances are born and join. */
static ric_status add_turns(const columns *c, json_t *turns)
{
    ric_force_extreme *list = NULL;
    int n = 0;
    const ric_status status = ric_force_extremes(c->force, c->ask->branch, c->ask->harmonic, &n,
                                                 &list);
    for (int i = 0; i < n; i++) {
        const ric_prediction *p = &list[i].at;
        json_array_append_new(turns,
                              json_pack("{s:b,s:o,s:o,s:o,s:o,s:s,s:o}", "birth", list[i].birth,
                                        "arclength", cli_number(list[i].arclength), "energy",
                                        cli_number(p->energy), "omega", cli_number(p->omega),
                                        "threshold", cli_number(p->threshold), "why", p->why,
                                        "error", cli_number(list[i].error)));
    }
    ric_force_extremes_free(list);
    return status;
}

ric_status view_force(const ric_atlas *atlas, const view_force_request *r, json_t **out)
{
    const ric_shaking shaking = {.n_force = r->n_force,
                                 .force = r->force,
                                 .n_ratio = r->n_ratio,
                                 .ratios = r->n_ratio ? r->ratios : NULL,
                                 .restitution = r->restitution};
    ric_force *force = NULL;
    columns c = {.ask = r,
                 .arclength = json_array(),
                 .energy = json_array(),
                 .omega = json_array(),
                 .threshold = json_array(),
                 .stable = json_array(),
                 .trusted = json_array(),
                 .amplitudes = json_array()};
    ric_status status = ric_force_create(atlas, &shaking, &force);
    c.force = force;
    if (!status) status = add_points(atlas, &c);
    json_t *turns = json_array();
    if (!status) status = add_turns(&c, turns);
    ric_force_free(force);
    *out = json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "turns", turns, "arclength", c.arclength,
                     "energy", c.energy, "omega", c.omega, "threshold", c.threshold, "stable",
                     c.stable, "why", c.trusted, "amplitudes", c.amplitudes);
    if (!status) return RIC_OK;
    json_decref(*out);
    *out = NULL;
    return status;
}

/* ----------------------------------------------------------- exact response */

/* A curve: omega, stable and the peaks of its orbits, displacement by displacement. */
static json_t *response_curve(const ric_response *r, int id)
{
    ric_response_curve c;
    ric_response_point p;
    if (ric_response_curve_at(r, id, &c)) return json_null();
    const int n = ric_model_n_dof(ric_response_model(r));
    json_t *omega = json_array(), *stable = json_array(), *peaks = json_array();
    for (int j = 0; j < n; j++) json_array_append_new(peaks, json_array());
    for (int i = 0; i < c.n_point && !ric_response_point_at(r, id, i, &p); i++) {
        json_array_append_new(omega, cli_number(p.omega));
        json_array_append_new(stable, json_integer(p.stable));
        for (int j = 0; j < n; j++)
            json_array_append_new(json_array_get(peaks, (size_t)j), cli_number(p.peak[j]));
    }
    return json_pack("{s:i,s:o,s:i,s:i,s:b,s:o,s:o,s:o}", "id", c.id, "level", cli_number(c.level),
                     "impacts", c.impacts, "periods", c.harmonic, "closed",
                     c.end == RIC_RESPONSE_CLOSED, "omega", omega, "stable", stable, "peaks",
                     peaks);
}

json_t *view_response(const ric_response *r)
{
    json_t *curves = json_array();
    for (int id = 1; id <= ric_response_n_curve(r); id++)
        json_array_append_new(curves, response_curve(r, id));
    const ric_shaking *s = &ric_response_asked(r)->shaking;
    json_t *force = json_array(), *damping = json_array();
    for (int i = 0; i < s->n_force; i++) json_array_append_new(force, cli_number(s->force[i]));
    for (int i = 0; i < s->n_ratio; i++) json_array_append_new(damping, cli_number(s->ratios[i]));
    return json_pack("{s:o,s:b,s:o,s:o,s:o}", "curves", curves, "finished",
                     ric_response_finished(r), "force", force, "damping", damping, "restitution",
                     cli_number(s->restitution));
}
