/* ricochet orbit ATLAS --branch ID ...: the orbits of a branch at a point, an energy or a
 * frequency. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"

enum { STEPS_MAX = 1000000 }; /* of a history; more is a slip in --history */

/* One orbit with its numbers and room to work. */
typedef struct {
    const ric_orbit *orbit;
    const ric_model *model;
    int n_dof, n_letter;
    double period, d; /* d: unit of lengths */
    ric_point point;
    double *state;       /* [2 n_dof] */
    double *flights;     /* [max(n_letter, 1)] */
    int *word;           /* [n_letter] */
    double *x, *v;       /* [n_dof] each, work */
    double *multipliers; /* [4 n_mode] */
} subject;

static void subject_free(subject *s)
{
    free(s->state);
    free(s->flights);
    free(s->word);
    free(s->x);
    free(s->v);
    free(s->multipliers);
}

static bool subject_init(subject *s, const ric_orbit *orbit, const ric_model *model, double d)
{
    size_t n = (size_t)ric_model_n_dof(model), n_letter = (size_t)ric_orbit_letters(orbit);
    *s = (subject){.orbit = orbit,
                   .model = model,
                   .n_dof = (int)n,
                   .n_letter = (int)n_letter,
                   .d = d};
    s->state = calloc(2 * n, sizeof *s->state);
    s->flights = calloc(n_letter + 1, sizeof *s->flights);
    s->word = calloc(n_letter + 1, sizeof *s->word);
    s->x = calloc(n, sizeof *s->x);
    s->v = calloc(n, sizeof *s->v);
    s->multipliers = calloc(4 * (size_t)ric_model_n_mode(model) + 1, sizeof *s->multipliers);
    if (!s->state || !s->flights || !s->word || !s->x || !s->v || !s->multipliers) return false;
    ric_orbit_data(orbit, &s->point, s->state, s->flights, s->word);
    s->period = CLI_TWO_PI / s->point.frequency;
    return true;
}

/* ----------------------------------------------------------------- impacts */

static ric_status add_impacts(subject *s, json_t *speeds, json_t *impulses)
{
    double *numbers = calloc(2 * (size_t)s->n_letter + 1, sizeof *numbers);
    int n = 0;
    ric_status status = numbers ? ric_orbit_exchanges(s->orbit, &n, numbers, numbers + s->n_letter)
                                : RIC_E_NOMEM;
    for (int k = 0; k < n; k++) {
        json_array_append_new(speeds, cli_number(s->d * numbers[k]));
        json_array_append_new(impulses, cli_number(s->d * numbers[s->n_letter + k]));
    }
    free(numbers);
    return status;
}

/* -------------------------------------------------------------------- rows */

static json_t *multiplier_pairs(subject *s)
{
    int n = 2 * (ric_model_n_mode(s->model) - 1);
    if (n > 0 && ric_orbit_multipliers(s->orbit, s->multipliers)) return json_null();
    return cli_pairs(n, s->multipliers);
}

/* What parts contacts that close together, where some do. */
static void add_parting(json_t *row, const subject *s)
{
    double *pairs = calloc(4 * (size_t)s->n_dof, sizeof *pairs);
    ric_stability stable = RIC_STABLE_UNDECIDED;
    int n = 0;
    const ric_status status = pairs ? ric_orbit_parting(s->orbit, &n, pairs, &stable) : RIC_E_NOMEM;
    if (status || n) {
        json_object_set_new(row, "parting", status ? json_null() : cli_pairs(n, pairs));
        json_object_set_new(row, "parting_stable", json_string(cli_stability(stable)));
    }
    free(pairs);
}

static ric_status add_orbit(json_t *rows, subject *s)
{
    json_t *row = json_object(), *speeds = json_array(), *impulses = json_array();
    double *amplitudes = calloc((size_t)s->n_dof, sizeof *amplitudes);
    ric_status status = amplitudes ? ric_orbit_amplitudes(s->orbit, amplitudes) : RIC_E_NOMEM;
    json_array_append_new(rows, row);
    json_object_set_new(row, "word", cli_word(s->model, s->n_letter, s->word));
    json_object_set_new(row, "state", cli_numbers(2 * s->n_dof, s->state, s->d));
    json_object_set_new(row, "flights",
                        cli_numbers(s->n_letter > 0 ? s->n_letter : 1, s->flights, 1));
    json_object_set_new(row, "period", cli_number(s->period));
    json_object_set_new(row, "frequency", cli_number(s->point.frequency));
    json_object_set_new(row, "energy", cli_energy(s->point.energy, s->d));
    json_object_set_new(row, "multipliers", multiplier_pairs(s));
    json_object_set_new(row, "stable", json_string(cli_stability((ric_stability)s->point.stable)));
    add_parting(row, s);
    json_object_set_new(row, "amplitudes",
                        status ? json_null() : cli_numbers(s->n_dof, amplitudes, s->d));
    if (!status) status = add_impacts(s, speeds, impulses);
    json_object_set_new(row, "impact_speeds", speeds);
    json_object_set_new(row, "impulses", impulses);
    free(amplitudes);
    return status;
}

ric_status cli_orbit_row(const ric_orbit *orbit, const ric_model *model, double d, json_t *rows)
{
    subject s;
    ric_status status = subject_init(&s, orbit, model, d) ? add_orbit(rows, &s) : RIC_E_NOMEM;
    subject_free(&s);
    return status;
}

static json_t *history_row(subject *s, double t, int number)
{
    json_t *row = json_object();
    char key[24];
    ric_orbit_at_time(s->orbit, t, s->x, s->v);
    json_object_set_new(row, "t", cli_number(t));
    for (int i = 0; i < 2 * s->n_dof; i++) {
        int j = i % s->n_dof;
        snprintf(key, sizeof key, "%c%d", i < s->n_dof ? 'x' : 'v', j + 1);
        json_object_set_new(row, key, cli_number(s->d * (i < s->n_dof ? s->x : s->v)[j]));
    }
    if (number) json_object_set_new(row, "orbit", json_integer(number));
    return row;
}

/* One period in steps of dt, and its end. `number` is 0 when there is only one orbit. */
static void add_history(json_t *rows, subject *s, double dt, int number)
{
    int n = (int)floor(s->period / dt * (1 - 1e-12));
    for (int k = 0; k <= n; k++) json_array_append_new(rows, history_row(s, k * dt, number));
    json_t *last = history_row(s, 0, number);
    json_object_set_new(last, "t", cli_number(s->period));
    json_array_append_new(rows, last);
}

/* ----------------------------------------------------------------- command */

typedef struct {
    const char *path;
    int branch;
    ric_at at;
    double value, step; /* step of the history, 0 = none */
    bool physical, hertz;
    cli_format format;
} request;

/* What the number that is asked for is a multiple of. */
static double unit_of(const request *ask, const ric_model *model)
{
    const double d = ask->physical ? ric_model_length(model) : 1;
    return ask->at == RIC_AT_ENERGY                    ? cli_unit_of_energies(d)
           : ask->at == RIC_AT_FREQUENCY && ask->hertz ? 1 / CLI_TWO_PI
                                                       : 1;
}

/* *found: number of orbits. *too_long: a history would have too many rows, and there are none. */
static ric_status add_rows(json_t *rows, const request *ask, const ric_atlas *atlas, int *found,
                           bool *too_long)
{
    const ric_model *model = ric_atlas_model(atlas);
    const double d = cli_unit_of_lengths(model, ask->physical);
    const double value = ask->value / unit_of(ask, model);
    ric_orbit **orbits = NULL;
    int n = 0;
    ric_status status = ric_orbit_find(atlas, ask->branch, ask->at, value, &n, &orbits);
    for (int i = 0; !status && i < n; i++) {
        subject s;
        if (!subject_init(&s, orbits[i], model, d)) status = RIC_E_NOMEM;
        else if (ask->step > 0 && s.period / ask->step > STEPS_MAX) *too_long = true;
        else if (ask->step > 0) add_history(rows, &s, ask->step, n > 1 ? i + 1 : 0);
        else status = add_orbit(rows, &s);
        subject_free(&s);
    }
    if (ask->hertz) cli_in_hertz(rows);
    ric_orbits_free(n, orbits);
    *found = n;
    return status;
}

/* The tongue that was stepped over where the orbit would be, ", and ..", or "". */
static void find_gap(const request *ask, const ric_atlas *atlas, double unit, size_t size,
                     char *out)
{
    int n = 0;
    char text[CLI_TONGUE];
    ric_tongue *tongues = NULL;
    *out = '\0';
    if (ric_branch_tongues(atlas, ask->branch, &n, &tongues)) return;
    for (int i = 0; i < n; i++) {
        const double *ends = ask->at == RIC_AT_ENERGY ? tongues[i].energy : tongues[i].frequency,
                     value = ask->value / unit;
        if (!tongues[i].crossed || !((ends[0] - value) * (ends[1] - value) < 0)) continue;
        ric_tongue_text(&tongues[i], ask->at == RIC_AT_ENERGY ? unit : 1, sizeof text, text);
        snprintf(out, size, ", and %s", text);
    }
    ric_tongues_free(tongues);
}

static int report_none(const request *ask, const ric_atlas *atlas)
{
    ric_branch branch;
    bool energy = ask->at == RIC_AT_ENERGY;
    ric_status status = ric_atlas_branch(atlas, ask->branch, &branch);
    if (status) return cli_report(status);
    const double unit = unit_of(ask, ric_atlas_model(atlas));
    char gap[CLI_TONGUE + 8];
    find_gap(ask, atlas, unit, sizeof gap, gap);
    cli_say("ricochet: branch %d has no orbit of %s %.12g; it runs from %.12g to %.12g%s\n",
            ask->branch, energy ? "energy" : "frequency", ask->value,
            unit * (energy ? branch.energy_min : branch.frequency_min),
            unit * (energy ? branch.energy_max : branch.frequency_max), gap);
    return CLI_FAILED;
}

/* Where the branch has the energy or frequency elsewhere than in the gap, too. */
static void report_left_out(const request *ask, const ric_atlas *atlas)
{
    char gap[CLI_TONGUE + 8] = "";
    if (ask->at != RIC_AT_POINT)
        find_gap(ask, atlas, unit_of(ask, ric_atlas_model(atlas)), sizeof gap, gap);
    if (*gap)
        cli_say("ricochet: orbits may be missing: branch %d has what is listed%s\n", ask->branch,
                gap);
}

/* An orbit is too long for a line: the table has one line per quantity. */
static int print_orbits(const json_t *orbits, cli_format format)
{
    const json_t *orbit;
    const char *name;
    json_t *value;
    size_t i;
    if (format != CLI_TEXT) return cli_print_rows(orbits, NULL, format);
    json_t *rows = json_array();
    json_array_foreach(orbits, i, orbit)
    {
        json_object_foreach((json_t *)(uintptr_t)orbit, name, value)
        {
            json_t *row = json_object();
            json_object_set_new(row, "orbit", json_integer((json_int_t)i + 1));
            json_object_set_new(row, "quantity", json_string(name));
            json_object_set(row, "value", value);
            json_array_append_new(rows, row);
        }
    }
    int code = cli_print_rows(rows, NULL, format);
    json_decref(rows);
    return code;
}

static int answer(const request *ask)
{
    json_t *rows = json_array();
    ric_atlas *atlas = NULL;
    bool too_long = false;
    int code, found = 0;
    ric_status status = ric_atlas_read(ask->path, &atlas);
    if (!status) status = add_rows(rows, ask, atlas, &found, &too_long);
    if (!status && !found) code = report_none(ask, atlas);
    else if (!status && too_long)
        code = cli_wrong("orbit: --history %g gives more than %d rows; choose a larger step",
                         ask->step, STEPS_MAX);
    else if (status) code = cli_report(status);
    else {
        report_left_out(ask, atlas);
        code = ask->step > 0 ? cli_print_rows(rows, NULL, ask->format)
                             : print_orbits(rows, ask->format);
    }
    json_decref(rows);
    ric_atlas_free(atlas);
    return code;
}

/* Exactly one of --point, --energy and --frequency. */
static bool parse_place(const char *const texts[3], request *ask)
{
    static const char *const names[] = {"--point", "--energy", "--frequency"};
    static const ric_at kinds[] = {RIC_AT_POINT, RIC_AT_ENERGY, RIC_AT_FREQUENCY};
    int n = 0, which = 0;
    long point = 0;
    for (int i = 0; i < 3; i++)
        if (texts[i]) {
            n++;
            which = i;
        }
    if (n != 1) {
        cli_wrong("orbit: give one of --point I, --energy E and --frequency F%s",
                  n ? ", not several" : "");
        return false;
    }
    ask->at = kinds[which];
    if (which > 0) return cli_parse_number(texts[which], names[which], &ask->value);
    if (!cli_parse_integer(texts[0], names[0], 0, INT_MAX, &point)) return false;
    ask->value = (double)point;
    return true;
}

static bool parse_step(const char *text, double *step)
{
    if (text && (!cli_parse_number(text, "--history", step))) return false;
    if (text && !(*step > 0)) {
        cli_wrong("--history '%s' is not a step of time; give seconds above 0, for example 0.01",
                  text);
        return false;
    }
    return true;
}

static int run(int argc, char **argv)
{
    const char *branch = NULL, *places[3] = {NULL, NULL, NULL}, *step = NULL;
    long id = 0;
    request ask = {.physical = cli_take_flag(&argc, argv, "--physical"),
                   .hertz = cli_take_flag(&argc, argv, "--hz")};
    if (!cli_take_format(&argc, argv, &ask.format) ||
        !cli_take_value(&argc, argv, "--branch", &branch) ||
        !cli_take_value(&argc, argv, "--point", &places[0]) ||
        !cli_take_value(&argc, argv, "--energy", &places[1]) ||
        !cli_take_value(&argc, argv, "--frequency", &places[2]) ||
        !cli_take_value(&argc, argv, "--history", &step) ||
        !cli_operands(&cli_orbit, argc, argv, 1))
        return CLI_WRONG;
    if (!branch)
        return cli_wrong("orbit: --branch ID is missing; `ricochet branches %s` lists the ids",
                         argv[1]);
    if (!cli_parse_integer(branch, "--branch", 1, INT_MAX, &id) || !parse_place(places, &ask) ||
        !parse_step(step, &ask.step))
        return CLI_WRONG;
    ask.path = argv[1];
    ask.branch = (int)id;
    return answer(&ask);
}

static const cli_item items[] = {
    {.text = "Solves every orbit of the branch that fits, to rounding: one row each for --csv and "
             "--json, one line "
             "per quantity otherwise."},
    {.name = "--branch", .value = "ID", .text = "the branch, by its number in `ricochet branches`"},
    CLI_ITEM_AT,
    {.name = "--point",
     .value = "I",
     .text = "stored point I, from 0, as `ricochet points` lists them"},
    {.name = "--energy", .value = "E", .text = "all orbits of energy E"},
    {.name = "--frequency", .value = "F", .text = "all orbits of frequency F, rad/s"},
    {.name = "--history",
     .value = "DT",
     .text = "one period in steps of DT seconds instead, columns t x1.. v1..; a last column "
             "`orbit` if there are "
             "several"},
    {.name = "--physical",
     .text = "lengths, speeds and energies (also E) in the units of the study, not scaled by the "
             "clearance"},
    {.name = "state", .text = "x then v right after the first impact of the word"},
    {.name = "flights", .text = "times from impact to impact, or the period if there is no impact"},
    {.name = "multipliers",
     .text = "beside the trivial ones, as pairs of real and imaginary part; null where they are "
             "lost in rounding"},
    {.name = "parting",
     .text = "where contacts close together (key `together` of the study): multipliers of "
             "disturbances that part them, null where they are not defined; parting_stable: yes, "
             "no or undecided"},
    {.name = "amplitudes", .text = "largest |x| of every degree of freedom over the period"},
    {.name = "impact_speeds",
     .text = "speed of approach of each impact of the word; impulses: the momentum exchanged"},
    CLI_ITEM_HZ,
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    CLI_ITEM_WIDE,
    {0},
};

const cli_command cli_orbit = {
    .name = "orbit",
    .summary = "solve the orbits of a branch at a point, an energy or a frequency",
    .usage = "ricochet orbit ATLAS (--branch ID | --at E,OMEGA) (--point I | --energy E | "
             "--frequency F)\n"
             "           [--history DT] [--physical] [--hz] [--json | --csv | --wide]\n",
    .items = items,
    .example = "ricochet orbit study.ricochet --branch 3 --energy 1.5\n",
    .run = run,
};
