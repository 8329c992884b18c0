/* ricochet force ATLAS: what damping and a harmonic force make of the orbits of an atlas. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/shaking.h"

static const double same_phase = 1e-7; /* rad: of orbits that are solved to 1e-11 */

typedef struct {
    const char *path, *study; /* study: of the losses and the force, NULL: that of the atlas */
    cli_shaking shaking;
    double level;
    int branch; /* 0: all */
    int n_energy;
    double energy[2]; /* one, or a window */
    bool exact, isolas;
    cli_format format;
} request;

/* ------------------------------------------------------------------- answers */

static json_t *prediction_row(const ric_branch *b, const ric_prediction *p)
{
    json_t *row = json_object();
    json_object_set_new(row, "branch", json_integer(b->id));
    json_object_set_new(row, "key", json_string(b->key));
    json_object_set_new(row, "energy", cli_number(p->energy));
    json_object_set_new(row, "frequency", cli_number(p->frequency));
    json_object_set_new(row, "harmonic", json_integer(p->harmonic));
    json_object_set_new(row, "omega", cli_number(p->omega));
    json_object_set_new(row, "threshold", cli_number(p->threshold));
    json_object_set_new(row, "loss_damping", cli_number(p->loss_damping));
    json_object_set_new(row, "loss_impacts", cli_number(p->loss_impacts));
    json_object_set_new(row, "phases", cli_numbers(p->n_phase, p->phases, 1));
    json_object_set_new(row, "stable", json_string(cli_stability(p->stable)));
    json_object_set_new(row, "trusted", json_string(p->trusted ? "yes" : p->why));
    json_object_set_new(row, "threshold_impacts", cli_number(p->threshold_impacts));
    json_object_set_new(row, "work", cli_numbers(2, p->work, 1));
    json_object_set_new(row, "slope", cli_number(p->slope));
    json_object_set_new(row, "estimate", cli_number(p->estimate));
    json_object_set_new(row, "error", cli_number(p->error));
    return row;
}

/* An exact forced orbit with room for its numbers. */
typedef struct {
    ric_forced data;
    double *state, *flights, *multipliers; /* [2 n], [letters], [4 n] */
} forced;

static json_t *forced_row(const ric_force *force, const ric_branch *b, const ric_prediction *p,
                          const forced *x)
{
    const int n = ric_model_n_dof(ric_force_model(force));
    const bool found = !*x->data.fault;
    json_t *row = json_object();
    json_object_set_new(row, "branch", json_integer(b->id));
    json_object_set_new(row, "key", json_string(b->key));
    json_object_set_new(row, "energy", cli_number(p->energy));
    json_object_set_new(row, "harmonic", json_integer(p->harmonic));
    json_object_set_new(row, "omega", cli_number(p->omega));
    json_object_set_new(row, "state", found ? cli_numbers(2 * n, x->state, 1) : json_null());
    json_object_set_new(row, "flights",
                        found ? cli_numbers(b->letters ? b->letters : 1, x->flights, 1)
                              : json_null());
    json_object_set_new(row, "phase", cli_number(found ? x->data.phase : NAN));
    json_object_set_new(row, "multipliers", cli_pairs(found ? 2 * n : 0, x->multipliers));
    json_object_set_new(row, "largest", cli_number(found ? x->data.largest : NAN));
    json_object_set_new(row, "stable",
                        found ? json_string(cli_stability(x->data.stable)) : json_null());
    json_object_set_new(row, "residual", cli_number(x->data.residual));
    json_object_set_new(row, "distance", cli_number(found ? x->data.distance : NAN));
    json_object_set_new(row, "trusted", json_string(p->trusted ? "yes" : p->why));
    json_object_set_new(row, "fault", json_string(x->data.fault));
    return row;
}

static void say_fault(const ric_branch *b, const ric_prediction *p, int k, const char *fault)
{
    cli_say("ricochet: branch %d, energy %.10g, harmonic %d, phase %.6g: no forced orbit is found: "
            "%s\n",
            b->id, p->energy, p->harmonic, p->phases[k], fault);
}

static bool same_orbit(int n, const forced *x, const double *first, double phase)
{
    double apart = fabs(x->data.phase - phase); /* which is 0 for all where there are no events */
    for (int i = 0; i < n; i++) apart = fmax(apart, fabs(x->state[i] - first[i]));
    return apart < same_phase;
}

/* The orbits at both phases of a prediction. */
static ric_status solve_both(const request *ask, const ric_force *force, const ric_branch *b,
                             const ric_orbit *orbit, const ric_prediction *p, json_t *rows)
{
    const size_t n = (size_t)ric_model_n_dof(ric_force_model(force)), letters = (size_t)b->letters;
    double *room = calloc(7 * n + letters + 1, sizeof *room), *first = room + 6 * n + letters + 1;
    double first_phase = NAN;
    char why[512];
    forced x = {.state = room, .multipliers = room + 2 * n, .flights = room + 6 * n};
    ric_status status = room ? RIC_OK : RIC_E_NOMEM;
    for (int k = 0; k < p->n_phase && !status; k++) {
        status = ric_force_solve(force, orbit, p->harmonic, ask->level, p->phases[k], &x.data,
                                 x.state, x.flights, x.multipliers);
        if (status == RIC_E_NUMERIC) { /* this orbit cannot be forced so; others can */
            snprintf(why, sizeof why, "%s", ric_detail());
            x.data.fault = why;
            status = RIC_OK;
        }
        if (!status && k == 1 && !*x.data.fault && same_orbit((int)n, &x, first, first_phase))
            x.data.fault = "both phases lead to one orbit";
        if (!status && *x.data.fault) say_fault(b, p, k, x.data.fault);
        if (!status) json_array_append_new(rows, forced_row(force, b, p, &x));
        first_phase = *x.data.fault ? NAN : x.data.phase;
        if (!status) memcpy(first, x.state, n * sizeof *first);
    }
    if (!status && !p->n_phase)
        cli_say("ricochet: branch %d, energy %.10g, harmonic %d: the level %.10g is below the "
                "threshold %.10g\n",
                b->id, p->energy, p->harmonic, ask->level, p->threshold);
    free(room);
    return status;
}

static ric_status add_orbit(const request *ask, const ric_force *force, const ric_branch *b,
                            const ric_orbit *orbit, json_t *rows)
{
    ric_prediction p;
    ric_status status = RIC_OK;
    for (int i = 0; i < ask->shaking.n_harmonic && !status; i++) {
        status = ric_force_predict(force, b->id, orbit, ask->shaking.harmonics[i], ask->level, &p);
        if (!status && ask->exact)
            status = b->letters || !ric_model_n_face(ric_force_model(force))
                         ? solve_both(ask, force, b, orbit, &p, rows)
                         : RIC_OK;
        else if (!status) json_array_append_new(rows, prediction_row(b, &p));
    }
    return status;
}

static ric_status add_found(const request *ask, const ric_force *force, const ric_atlas *atlas,
                            const ric_branch *b, ric_at at, double value, json_t *rows)
{
    ric_orbit **orbits = NULL;
    int n = 0;
    ric_status status = ric_orbit_find(atlas, b->id, at, value, &n, &orbits);
    for (int i = 0; i < n && !status; i++) status = add_orbit(ask, force, b, orbits[i], rows);
    ric_orbits_free(n, orbits);
    return status;
}

/* Extrema of the threshold along a branch, in the window of energies. */
static ric_status add_isolas(const request *ask, const ric_force *force, const ric_branch *b,
                             json_t *rows)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < ask->shaking.n_harmonic && !status; i++) {
        ric_force_extreme *list = NULL;
        int n = 0;
        status = ric_force_extremes(force, b->id, ask->shaking.harmonics[i], &n, &list);
        for (int k = 0; k < n && !status; k++) {
            if (ask->n_energy == 2 &&
                !(list[k].at.energy >= ask->energy[0] && list[k].at.energy <= ask->energy[1]))
                continue;
            json_t *row = prediction_row(b, &list[k].at);
            json_object_set_new(row, "event", json_string(list[k].birth ? "birth" : "join"));
            json_object_set_new(row, "located", cli_number(list[k].error));
            json_array_append_new(rows, row);
        }
        ric_force_extremes_free(list);
    }
    return status;
}

/* At an energy, all orbits there; else the stored points, those of a window. */
static ric_status add_branch(const request *ask, const ric_force *force, const ric_atlas *atlas,
                             int id, json_t *rows)
{
    ric_branch b;
    ric_point p;
    ric_status status = ric_atlas_branch(atlas, id, &b);
    if (!status && ask->isolas) return add_isolas(ask, force, &b, rows);
    if (!status && ask->n_energy == 1)
        return add_found(ask, force, atlas, &b, RIC_AT_ENERGY, ask->energy[0], rows);
    for (int i = 0; i < b.n_point && !status; i++) {
        status = ric_atlas_point(atlas, id, i, &p, NULL, NULL);
        if (status || !(p.energy > 0)) continue;
        if (ask->n_energy == 2 && !(p.energy >= ask->energy[0] && p.energy <= ask->energy[1]))
            continue;
        status = add_found(ask, force, atlas, &b, RIC_AT_POINT, i, rows);
    }
    return status;
}

/* ------------------------------------------------------------------- command */

static int print(const request *ask, const json_t *rows)
{
    static const char columns[] =
        "branch key energy frequency harmonic omega threshold loss_damping loss_impacts "
        "phases stable trusted";
    static const char exact[] =
        "branch key energy harmonic omega state flights phase multipliers stable residual";
    static const char isolas[] =
        "branch key event threshold energy frequency harmonic omega loss_damping loss_impacts "
        "stable trusted located";
    return cli_print_rows(rows, ask->isolas ? isolas : ask->exact ? exact : columns, ask->format);
}

/* Whether one of the forced orbits that were asked for is there. */
static bool some_found(const json_t *rows)
{
    const json_t *row;
    size_t i;
    json_array_foreach(rows, i, row) if (!json_is_null(json_object_get(row, "state"))) return true;
    return false;
}

static int report_none(const request *ask, const ric_atlas *atlas)
{
    if (ask->exact) {
        cli_say("ricochet: no forced orbit was found\n");
        return CLI_FAILED;
    }
    char of[40] = "the atlas";
    if (ask->branch) snprintf(of, sizeof of, "branch %d", ask->branch);
    if (ask->n_energy == 1)
        cli_say("ricochet: %s has no orbit of energy %.12g", of, ask->energy[0]);
    else if (ask->n_energy == 2)
        cli_say("ricochet: %s has no stored orbit with an energy from %.12g to %.12g", of,
                ask->energy[0], ask->energy[1]);
    else cli_say("ricochet: %s has no orbit with energy", of);
    ric_branch b;
    if (ask->branch && !ric_atlas_branch(atlas, ask->branch, &b))
        cli_say("; its energies are %.12g to %.12g\n", b.energy_min, b.energy_max);
    else cli_say("; `ricochet branches %s` lists the energies of every branch\n", ask->path);
    return CLI_FAILED;
}

/* What is not said by options, from the study: its force, its losses, and its amplitude, if it has
 * one. */
static int complete(request *ask, const ric_atlas *atlas)
{
    const int code = cli_shaking_read(&ask->shaking, "force", ask->study, ric_atlas_study(atlas));
    if (code) return code;
    if (!(ask->level > 0) && ask->shaking.amplitude.n == 1)
        ask->level = ask->shaking.amplitude.value[0];
    if (ask->exact && !(ask->level > 0))
        return cli_wrong("force: --exact needs --level L, the amplitude of the force");
    if (!ask->shaking.n_force)
        return cli_wrong("force: --force is missing; give the vector f of the force, one number "
                         "per displacement, for "
                         "example --force 1,0, or section forcing of the study");
    return CLI_DONE;
}

static int answer(request *ask)
{
    ric_atlas *atlas = NULL;
    ric_force *force = NULL;
    ric_status status = ric_atlas_read(ask->path, &atlas);
    const int wrong = status ? cli_report(status) : complete(ask, atlas);
    if (wrong) {
        ric_atlas_free(atlas);
        return wrong;
    }
    const ric_shaking shaking = cli_shaking_of(&ask->shaking);
    json_t *rows = json_array();
    status = ric_force_create(atlas, &shaking, &force);
    const int first = ask->branch ? ask->branch : 1, last = !atlas ? 0
                                                            : ask->branch
                                                                ? first
                                                                : ric_atlas_n_branch(atlas);
    for (int id = first; id <= last && !status; id++)
        status = add_branch(ask, force, atlas, id, rows);
    int code = status                                 ? cli_report(status)
               : json_array_size(rows) || ask->isolas ? print(ask, rows)
                                                      : report_none(ask, atlas);
    if (code == CLI_DONE && ask->isolas && !json_array_size(rows))
        cli_say("ricochet: the threshold has no least or largest value inside these branches\n");
    if (code == CLI_DONE && ask->exact && !some_found(rows)) code = CLI_FAILED;
    json_decref(rows);
    ric_force_free(force);
    ric_atlas_free(atlas);
    return code;
}

static bool parse_energy(const char *text, request *ask)
{
    if (!text) return true;
    if (!cli_parse_list(text, "--energy", 2, &ask->n_energy, ask->energy)) return false;
    if (ask->energy[0] > 0 && (ask->n_energy == 1 || ask->energy[1] > ask->energy[0])) return true;
    cli_wrong("--energy %s: give a scaled energy above 0, or a window such as 0.5,2", text);
    return false;
}

static bool parse_level(const char *text, request *ask)
{
    if (!text) return true;
    if (!cli_parse_number(text, "--level", &ask->level)) return false;
    if (ask->level > 0) return true;
    cli_wrong("--level %s: a level is an amplitude of the force, above 0", text);
    return false;
}

static int take_request(int *argc, char **argv, request *ask)
{
    const char *branch, *energy, *level;
    long id = 0;
    int code = CLI_WRONG;
    ask->exact = cli_take_flag(argc, argv, "--exact");
    ask->isolas = cli_take_flag(argc, argv, "--isolas");
    if (!cli_take_format(argc, argv, &ask->format) ||
        !cli_take_shaking(argc, argv, &ask->shaking, &code) ||
        !cli_take_value(argc, argv, "--branch", &branch) ||
        !cli_take_value(argc, argv, "--energy", &energy) ||
        !cli_take_value(argc, argv, "--study", &ask->study) ||
        !cli_take_value(argc, argv, "--level", &level) || !cli_operands(&cli_force, *argc, argv, 1))
        return code;
    ask->path = argv[1];
    if ((branch && !cli_parse_integer(branch, "--branch", 1, INT_MAX, &id)) ||
        !parse_energy(energy, ask) || !parse_level(level, ask))
        return CLI_WRONG;
    ask->branch = (int)id;
    if (ask->isolas && (ask->exact || ask->n_energy == 1))
        return cli_wrong("force: --isolas finds energies by itself; leave %s out",
                         ask->exact ? "--exact" : "--energy E, or give a window A,B");
    return CLI_DONE;
}

static int run(int argc, char **argv)
{
    request *ask = calloc(1, sizeof *ask);
    if (!ask) return cli_report(RIC_E_NOMEM);
    int code = take_request(&argc, argv, ask);
    if (code == CLI_DONE) code = answer(ask);
    cli_shaking_free(&ask->shaking);
    free(ask);
    return code;
}

static const cli_item items[] = {
    {.text = "What small damping and a harmonic force f cos(Omega t + phase), Omega = m omega, "
             "make of the orbits of an "
             "atlas, to first order: the least amplitude that keeps the motion up, and the two "
             "phases at which it does. "
             "One row for each stored orbit and harmonic. The atlas itself stays that of the "
             "structure without both."},
    CLI_ITEMS_SHAKING,
    CLI_ITEM_SHAKING_STUDY,
    {.name = "--branch", .value = "ID", .text = "only this branch"},
    CLI_ITEM_AT,
    {.name = "--energy",
     .value = "E",
     .text =
         "all orbits of this scaled energy, solved to rounding; or stored ones in a window A,B"},
    {.name = "--level", .value = "L", .text = "amplitude of the force for which phases are given"},
    {.name = "--exact",
     .text = "solves the forced problem itself at --level, from both phases: state right after the "
             "first impact, flights, "
             "phase, all multipliers, stable, residual; under a power law the state is that at "
             "phase 0"},
    {.name = "--isolas",
     .text = "only where the threshold along a branch is least, `birth` of a detached resonance as "
             "the level grows, or "
             "largest, `join` of two, located to the error `located`, relative"},
    {.name = "threshold",
     .text = "least amplitude L of the force L f, physical; null where the force does no work"},
    {.name = "loss_damping",
     .text = "energy per period, scaled, lost by damping; loss_impacts: at impacts"},
    {.name = "phases",
     .text = "two at --level, rad, t = 0 at the first impact of the stored state: that of the "
             "orbit which inherits the "
             "stability of the one in the atlas, and that of a saddle"},
    {.name = "stable",
     .text = "whether the first of the two is predicted to be stable; the second never is"},
    {.name = "trusted",
     .text = "yes, or why not: period (it hardly depends on the energy), force (it is not small "
             "beside the motion), "
             "multiplier (one is near 1), grazing, size (the next order is not small), level (it "
             "is too near the "
             "threshold), work (the force does none), error (of a quadrature)"},
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_force = {
    .name = "force",
    .summary = "orbits of an atlas under damping and a harmonic force",
    .usage = "ricochet force ATLAS [--force F1,F2,..] [--damping ZETA|FILE] [--restitution E]\n"
             "           [--harmonic M] [--study STUDY] [--branch ID | --at E,OMEGA] [--energy E]\n"
             "           [--level L [--exact]] [--isolas] [--json | --csv]\n",
    .items = items,
    .example = "ricochet force study.ricochet --force 1,0 --damping 0.001 --energy 1\n",
    .run = run,
};
