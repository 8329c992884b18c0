/* What a harmonic force and small losses make of the orbits of a branch, for the page of `ricochet view`
 * (docs/forcing.md). */
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
    ric_status status = amplitudes ? ric_force_predict(c->force, c->ask->branch, orbit, c->ask->harmonic, 0, &p)
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
    ric_force_free(force);
    *out = json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "arclength", c.arclength, "energy", c.energy, "omega", c.omega,
                     "threshold", c.threshold, "stable", c.stable, "why", c.trusted, "amplitudes", c.amplitudes);
    if (!status) return RIC_OK;
    json_decref(*out);
    *out = NULL;
    return status;
}
