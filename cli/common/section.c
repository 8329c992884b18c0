/* Sections of a study or an atlas: options, starts and progress. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "section.h"
#include "shaking.h"

enum { MOST_WORKERS = 256, MOST_STARTS = 10000000, MOST_IMPACTS = 1000000000 };

/* Relative: what an orbit that is solved at an energy may be off by; Newton's method leaves less.
 */
#define ITS_ENERGY 1e-9

/* ------------------------------------------------------------------ orbits */

static ric_status add_orbit(const ric_orbit *orbit, int branch, double energy,
                            cli_section_orbits *out)
{
    const size_t size = 2 * (size_t)ric_model_n_dof(ric_orbit_model(orbit));
    ric_point point;
    ric_orbit_data(orbit, &point, NULL, NULL, NULL);
    if (!(fabs(point.energy - energy) <= ITS_ENERGY * energy)) {
        out->off++;
        return RIC_OK;
    }
    if (out->n == out->room) {
        const int room = out->room ? 2 * out->room : 32;
        cli_section_orbit *orbits = realloc(out->orbits, (size_t)room * sizeof *orbits);
        if (orbits) out->orbits = orbits;
        double *states = realloc(out->states, (size_t)room * size * sizeof *states);
        if (states) out->states = states;
        if (!orbits || !states) return RIC_E_NOMEM;
        out->room = room;
    }
    ric_orbit_data(orbit, NULL, out->states + (size_t)out->n * size, NULL, NULL);
    out->orbits[out->n++] = (cli_section_orbit){.branch = branch,
                                                .impacts = ric_orbit_impacts(orbit),
                                                .stable = ric_orbit_stability(orbit),
                                                .period = CLI_TWO_PI / point.frequency};
    return RIC_OK;
}

static ric_status add_branch(const ric_atlas *atlas, int id, double energy, cli_section_orbits *out)
{
    ric_branch branch;
    ric_orbit **orbits = NULL;
    int n = 0;
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    if (status) return status;
    const bool meets = branch.impacts > 0 || ric_model_n_face(ric_atlas_model(atlas)) == 0;
    if (!meets || energy < branch.energy_min || energy > branch.energy_max) return RIC_OK;
    status = ric_orbit_find(atlas, id, RIC_AT_ENERGY, energy, &n, &orbits);
    for (int i = 0; i < n && !status; i++) status = add_orbit(orbits[i], id, energy, out);
    ric_orbits_free(n, orbits);
    return status;
}

ric_status cli_section_find(const ric_atlas *atlas, int branch, double energy,
                            cli_section_orbits *out)
{
    ric_status status = RIC_OK;
    for (int id = branch ? branch : 1;
         id <= (branch ? branch : ric_atlas_n_branch(atlas)) && !status; id++)
        status = add_branch(atlas, id, energy, out);
    if (!status && out->off)
        cli_say("%d orbit%s of the atlas could not be solved at this energy and %s left out\n",
                out->off, out->off == 1 ? "" : "s", out->off == 1 ? "is" : "are");
    return status;
}

void cli_section_release(cli_section_orbits *orbits)
{
    free(orbits->orbits);
    free(orbits->states);
    *orbits = (cli_section_orbits){0};
}

/* ----------------------------------------------------------------- options */

static bool take_integer(int *argc, char **argv, const char *name, long most, long *out)
{
    const char *text;
    return cli_take_value(argc, argv, name, &text) &&
           (!text || cli_parse_integer(text, name, 1, most, out));
}

bool cli_section_take(int *argc, char **argv, const char *what, long starts, cli_section_request *r)
{
    long impacts, workers = 1, asked = 0;
    *r = (cli_section_request){.seconds = HUGE_VAL, .energy = NAN};
    ric_section_options_init(&r->options);
    impacts = r->options.impacts;
    r->orbits = cli_take_flag(argc, argv, "--orbits");
    if (!cli_take_positive(argc, argv, what, "--energy", HUGE_VAL, &r->energy) ||
        !take_integer(argc, argv, "--starts", MOST_STARTS, &asked) ||
        !take_integer(argc, argv, "--impacts", MOST_IMPACTS, &impacts) ||
        !take_integer(argc, argv, "--branch", INT_MAX, &r->branch) ||
        !cli_take_positive(argc, argv, what, "--radius", 1, &r->options.radius) ||
        !cli_take_positive(argc, argv, what, "--seconds", HUGE_VAL, &r->seconds) ||
        !cli_take_workers(argc, argv, MOST_WORKERS, &workers))
        return false;
    r->options.starts = (int)(asked ? asked : starts);
    r->options.impacts = impacts;
    r->options.workers = (int)workers;
    const char *wrong =
        isnan(r->energy) ? "--energy is missing; give the scaled energy of the motions, for "
                           "example --energy 5"
        : r->branch && r->orbits ? "--branch and --orbits are both given; choose one"
        : r->options.radius > 0 && !r->branch && !r->orbits
            ? "--radius is about orbits of an atlas; give --branch ID or --orbits too"
        : asked && !(r->options.radius > 0) && (r->branch || r->orbits)
            ? "--starts is the number of motions about orbits, which start at these themselves; "
              "give --radius R too, or leave --starts out"
            : NULL;
    if (wrong) cli_wrong("%s: %s", what, wrong);
    return !wrong;
}

/* ------------------------------------------------------------------ follow */

int cli_section_open(const char *path, cli_section *s)
{
    *s = (cli_section){0};
    ric_status status = ric_study_read(path, &s->study);
    if (status == RIC_E_INPUT && !ric_atlas_read(path, &s->atlas)) status = RIC_OK;
    else if (status == RIC_E_INPUT)
        status = ric_study_read(path, &s->study); /* its own message again */
    if (!status)
        cli_forcing_warn(s->atlas ? ric_atlas_study(s->atlas) : s->study, path, "the section");
    if (!status) s->model = s->atlas ? ric_atlas_model(s->atlas) : ric_study_model(s->study);
    return cli_report(status);
}

typedef struct {
    cli_progress line;
    bool late;
    struct timespec begun;
    double seconds;
} display;

static bool show_progress(double part, void *user)
{
    display *d = user;
    if (cli_progress_due(&d->line))
        fprintf(stderr, "%.0f %%, %.0f s", 100 * part, cli_seconds_since(&d->begun));
    d->late = d->late || cli_seconds_since(&d->begun) > d->seconds;
    return d->late || cli_stopped();
}

/* The orbits to start at. */
static int find_given(const cli_section_request *r, cli_section *s)
{
    if (!r->branch && !r->orbits) return CLI_DONE;
    if (!s->atlas)
        return cli_wrong("section: --branch and --orbits are of an atlas, and the file is a study");
    ric_status status = cli_section_find(s->atlas, (int)r->branch, r->options.energy, &s->given);
    if (status) return cli_report(status);
    if (s->given.n > 0) return CLI_DONE;
    if (r->branch)
        cli_say("ricochet: branch %ld has no orbit of energy %.12g with impacts\n", r->branch,
                r->energy);
    else cli_say("ricochet: the atlas has no orbit of energy %.12g with impacts\n", r->energy);
    return CLI_FAILED;
}

int cli_section_follow(cli_section_request *r, double d, cli_section *s)
{
    display shown = {.line = cli_progress_begin(), .seconds = r->seconds};
    ric_section_options *o = &r->options;
    o->energy = d > 0 ? r->energy / cli_unit_of_energies(d) : r->energy;
    const int code = find_given(r, s);
    if (code) return code;
    o->n_given = s->given.n;
    o->given = s->given.states;
    if (o->radius > 0 && o->starts < o->n_given) o->starts = o->n_given;
    o->progress = show_progress;
    o->user = &shown;
    clock_gettime(CLOCK_MONOTONIC, &shown.begun);
    cli_catch_signals();
    ric_status status = ric_section_create(s->model, o, &s->section);
    if (!status) status = ric_section_run(s->section);
    cli_progress_end(&shown.line);
    s->late = shown.late;
    o->progress = NULL; /* who asks for more by the same options comes when `shown` is gone */
    o->user = NULL;
    if (status == RIC_E_INTERRUPTED) return shown.late ? CLI_LIMIT : CLI_INTERRUPTED;
    return cli_report(status);
}

void cli_section_close(cli_section *s)
{
    ric_section_free(s->section);
    cli_section_release(&s->given);
    ric_atlas_free(s->atlas);
    ric_study_free(s->study);
}
