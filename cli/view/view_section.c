/* Motions of one energy on the section of a face, and the orbits of the atlas there, for the page
 * of `ricochet view` (docs/sections.md). */
#include <math.h>
#include <stdlib.h>

#include "base/halt.h"
#include "common/section.h"
#include "view.h"

typedef struct {
    const ric_model *model;
    const ric_section *section;
    int n, size;   /* degrees of freedom, coordinates of a place */
    double *state; /* [2 n], and a place [size] behind it */
} places;

/* Displacement and momentum of a place that are drawn: the first of each. Faces that x -> -x
 * exchanges are one. */
static void add_place(const places *p, int face, json_t *faces, json_t *list)
{
    const int image = ric_section_image(p->section, face),
              shown = image >= 0 && image < face ? image : face;
    double *place = p->state + 2 * p->n;
    for (int i = 0; i < 2 * p->n && shown != face; i++) p->state[i] = -p->state[i];
    if (ric_section_place(p->section, shown, p->state, p->state + p->n, place)) return;
    json_array_append_new(faces, json_integer(shown));
    json_array_append_new(list, cli_number(place[0]));
    json_array_append_new(list, cli_number(place[p->size / 2]));
}

/* The places of a start; of an orbit no more than its impacts. */
static void add_places(const places *p, int start, long most, json_t *row)
{
    json_t *faces = json_array(), *list = json_array();
    int face;
    for (long k = 0; k < most; k++)
        if (!ric_section_impact(p->section, start, k, NULL, &face, p->state, p->state + p->n))
            add_place(p, face, faces, list);
    json_object_set_new(row, "faces", faces);
    json_object_set_new(row, "places", list);
}

static bool stopped(double part, void *user)
{
    (void)part;
    (void)user;
    return ric_halt(1e6) || ric_halted();
}

/* Follows the starts and makes a row of each; `row` has what is known of it before. */
static ric_status follow(const ric_model *model, const ric_section_options *options,
                         const cli_section_orbits *orbits, json_t *rows)
{
    ric_section *section = NULL;
    const int n = ric_model_n_dof(model), size = 2 * (ric_model_n_mode(model) - 1);
    double *room = calloc((size_t)(2 * n + size) + 2, sizeof *room);
    ric_status status = room ? ric_section_create(model, options, &section) : RIC_E_NOMEM;
    if (!status) status = ric_section_run(section);
    const places p = {.model = model, .section = section, .n = n, .size = size, .state = room};
    for (int i = 0; !status && i < ric_section_n_start(section); i++) {
        ric_section_track track;
        json_t *row = json_object();
        json_array_append_new(rows, row);
        if ((status = ric_section_track_at(section, i, &track))) break;
        const cli_section_orbit *orbit = orbits ? &orbits->orbits[i] : NULL;
        if (orbit) json_object_set_new(row, "branch", json_integer(orbit->branch));
        if (orbit) json_object_set_new(row, "stable", json_integer(orbit->stable));
        json_object_set_new(row, "lyapunov", cli_number(track.lyapunov));
        json_object_set_new(row, "lyapunov_error", cli_number(track.lyapunov_error));
        json_object_set_new(row, "rotation", cli_number(track.rotation));
        json_object_set_new(row, "why", json_string(track.why));
        const long impacts = orbit && orbit->impacts > 0 ? orbit->impacts : track.impacts;
        add_places(&p, i, impacts < track.impacts ? impacts : track.impacts, row);
    }
    ric_section_free(section);
    free(room);
    return status;
}

/* The orbits of the atlas at this energy, each with its own impacts. */
static ric_status add_orbits(const ric_atlas *atlas, ric_section_options options, json_t *rows)
{
    cli_section_orbits orbits = {0};
    ric_status status = cli_section_find(atlas, 0, options.energy, &orbits);
    options.n_given = options.starts = orbits.n;
    options.given = orbits.states;
    options.impacts = 2;
    for (int i = 0; i < orbits.n; i++)
        if (orbits.orbits[i].impacts + 1 > options.impacts)
            options.impacts = orbits.orbits[i].impacts + 1;
    if (!status && orbits.n > 0) status = follow(ric_atlas_model(atlas), &options, &orbits, rows);
    cli_section_release(&orbits);
    return status;
}

/* One motion, from a place. */
static ric_status add_motion(const ric_model *model, ric_section_options options,
                             const view_section_request *r, json_t *rows)
{
    ric_section *section = NULL;
    const int n = ric_model_n_dof(model), size = 2 * (ric_model_n_mode(model) - 1);
    double *state = calloc((size_t)(2 * n + size) + 2, sizeof *state), *place = state + 2 * n;
    options.starts = 1;
    ric_status status = state ? ric_section_create(model, &options, &section) : RIC_E_NOMEM;
    if (!status && size > 0) {
        place[0] = r->place[0];
        place[size / 2] = r->place[1];
    }
    if (!status) status = ric_section_state(section, r->face, place, state, state + n);
    options.n_given = 1;
    options.given = state;
    if (!status) status = follow(model, &options, NULL, rows);
    ric_section_free(section);
    free(state);
    return status;
}

ric_status view_section(const ric_atlas *atlas, const view_section_request *r, json_t **out)
{
    const ric_model *model = ric_atlas_model(atlas);
    ric_section_options options;
    json_t *starts = json_array(), *orbits = json_array();
    ric_section_options_init(&options);
    options.energy = r->energy;
    options.starts = r->starts;
    options.impacts = r->impacts;
    options.rows = true;
    options.progress = stopped;
    ric_status status = r->from_place ? add_motion(model, options, r, starts)
                                      : follow(model, &options, NULL, starts);
    if (!status && r->orbits) status = add_orbits(atlas, options, orbits);
    *out = json_pack("{s:f,s:i,s:o,s:o}", "energy", r->energy, "modes", ric_model_n_mode(model),
                     "starts", starts, "orbits", orbits);
    if (!status) return RIC_OK;
    json_decref(*out);
    *out = NULL;
    return status;
}
