/* ricochet simulate STUDY: the motion from a state, found impact by impact. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/shaking.h"

enum {
    STEPS = 200,
    STEPS_MAX = 10000000,
    IMPACTS_MAX = 1000000
}; /* a mass as fast as one likes has as many impacts as
    * one likes */

typedef struct {
    ric_study *study;
    ric_simulator *sim;
    ric_shaken *shaken; /* instead of it, under damping and force */
    cli_drive drive;
    int n;
    long steps, struck;
    double end, length; /* length: 1, or that of the model for physical units */
    bool impacts;       /* list these instead of the history */
    bool told;          /* why the motion came to an end has been said */
    double *state;      /* [2n] x, v as asked for */
    char **column;      /* [2n + 2] names, NULL at the end */
    json_t *rows;
} simulation;

/* ------------------------------------------------------------------ options */

static bool parse_times(simulation *s, const char *end, const char *steps)
{
    s->steps = STEPS;
    return cli_parse_end("simulate", end, &s->end) &&
           (!steps || cli_parse_integer(steps, "--steps", 1, STEPS_MAX, &s->steps));
}

/* ------------------------------------------------------------------- motion */

static bool make_columns(simulation *s)
{
    enum { WIDTH = 16 };
    s->state = calloc(2 * (size_t)s->n, sizeof *s->state);
    s->column = calloc(2 * (size_t)s->n + 2, sizeof *s->column);
    for (int i = 0; s->column && i <= 2 * s->n; i++) {
        if (!(s->column[i] = malloc(WIDTH))) return false;
        if (i == 0) snprintf(s->column[i], WIDTH, "t");
        else snprintf(s->column[i], WIDTH, "%c%d", i <= s->n ? 'x' : 'v', i <= s->n ? i : i - s->n);
    }
    s->rows = json_array();
    return s->state && s->column && s->rows;
}

static void state_of(simulation *s)
{
    if (s->drive.is_shaken) ric_shaken_state(s->shaken, NULL, s->state, s->state + s->n);
    else ric_simulator_state(s->sim, NULL, s->state, s->state + s->n);
}

static ric_status begin(simulation *s)
{
    const ric_model *model = ric_study_model(s->study);
    const double *x = s->state, *v = x + s->n;
    if (s->drive.is_shaken) return cli_drive_start(&s->drive, model, s->state, &s->shaken);
    ric_status status = ric_simulator_create(model, &s->sim);
    if (!status) ric_simulator_set_restitution(s->sim, s->drive.shaking.restitution);
    return status ? status : ric_simulator_start(s->sim, x, v);
}

static ric_status advance_to(simulation *s, double t, bool *hit, ric_impact *impact)
{
    return s->drive.is_shaken ? ric_shaken_advance(s->shaken, t, hit, impact)
                              : ric_simulator_advance(s->sim, t, hit, impact);
}

static void add_state(simulation *s, double t)
{
    json_t *row = json_object();
    if (t > 0) /* the first row is the state as it was given */
        state_of(s);
    json_object_set_new(row, "t", cli_number(t));
    for (int i = 0; i < 2 * s->n; i++)
        json_object_set_new(row, s->column[i + 1], cli_number(s->state[i] * s->length));
    json_array_append_new(s->rows, row);
}

static void add_impact(simulation *s, const ric_impact *impact)
{
    json_t *row = json_object();
    json_object_set_new(row, "t", cli_number(impact->time));
    json_object_set_new(row, "face", json_integer(impact->face));
    json_object_set_new(row, "approach", cli_number(impact->approach * s->length));
    json_object_set_new(row, "impulse", cli_number(impact->impulse * s->length));
    json_object_set_new(row, "opens", json_boolean(impact->opens));
    json_array_append_new(s->rows, row);
}

static ric_status advance(simulation *s, double t)
{
    bool hit = true;
    while (hit) {
        ric_impact impact;
        ric_status status = advance_to(s, t, &hit, &impact);
        if (status) return status;
        if (hit && ++s->struck > IMPACTS_MAX) {
            cli_wrong("simulate: more than %d impacts up to time %.9g; give a shorter --time, or "
                      "less speed",
                      IMPACTS_MAX, impact.time);
            s->told = true;
            return RIC_E_RANGE;
        }
        if (hit && s->impacts) add_impact(s, &impact);
    }
    return RIC_OK;
}

static ric_status simulate(simulation *s)
{
    ric_status status = begin(s);
    if (status) return status;
    if (s->impacts) return advance(s, s->end);
    add_state(s, 0);
    for (long i = 1; i <= s->steps && !status; i++) {
        double t = i == s->steps ? s->end : s->end * (double)i / (double)s->steps;
        if (!(status = advance(s, t))) add_state(s, t);
    }
    return status;
}

static void simulation_free(simulation *s)
{
    for (int i = 0; s->column && s->column[i]; i++) free(s->column[i]);
    free(s->column);
    free(s->state);
    json_decref(s->rows);
    ric_simulator_free(s->sim);
    ric_shaken_free(s->shaken);
    cli_shaking_free(&s->drive.shaking);
    ric_study_free(s->study);
}

/* What was found before the motion came to an end is printed all the same. */
static int simulate_and_print(simulation *s, cli_format format)
{
    static const char impact_columns[] = "t face approach impulse opens";
    ric_status status = simulate(s);
    int code = s->told ? CLI_FAILED : cli_report(status);
    if (code == CLI_WRONG) return code;
    int printed = cli_print_rows(s->rows, s->impacts ? impact_columns : NULL, format);
    return code ? code : printed;
}

static int run(int argc, char **argv)
{
    cli_format format;
    const char *end, *steps, **texts = calloc((size_t)argc + 1, sizeof *texts);
    simulation s = {.length = 1};
    int code = CLI_WRONG, count;
    if (!texts) {
        code = cli_report(RIC_E_NOMEM);
        goto out;
    }
    bool physical = cli_take_flag(&argc, argv, "--physical");
    s.impacts = cli_take_flag(&argc, argv, "--impacts");
    if (!cli_take_format(&argc, argv, &format) || !cli_take_value(&argc, argv, "--time", &end) ||
        !cli_take_value(&argc, argv, "--steps", &steps) ||
        !cli_take_drive(&argc, argv, &s.drive, &code) ||
        !cli_take_state(&argc, argv, "simulate", &count, texts) ||
        !cli_operands(&cli_simulate, argc, argv, 1) || !parse_times(&s, end, steps))
        goto out;
    ric_status status = ric_study_read(argv[1], &s.study);
    if (status) {
        code = cli_report(status);
        goto out;
    }
    s.n = ric_model_n_dof(ric_study_model(s.study));
    if (physical) s.length = cli_unit_of_lengths(ric_study_model(s.study), true);
    if (!make_columns(&s)) code = cli_report(RIC_E_NOMEM);
    else if ((code = cli_drive_complete(&s.drive, "simulate", s.study)) == CLI_DONE)
        code = cli_parse_state("simulate", ric_study_model(s.study), count, texts, s.length,
                               s.state)
                   ? simulate_and_print(&s, format)
                   : CLI_WRONG;
out:
    free(texts);
    simulation_free(&s);
    return code;
}

static const cli_item items[] = {
    {.text = "Places the structure of the study at displacements X (one per degree of freedom) "
             "with velocities V "
             "at time 0 and follows it to time T in seconds. Every impact is found. Damping, "
             "restitution and force are "
             "those of the study where no option gives them. Lists the columns t x1.. v1.. at N + "
             "1 equal times, or "
             "the impacts. Lengths are in "
             "clearances of the first contact."},
    {.name = "--state",
     .value = "X.. V..",
     .text = "2n numbers; a state on a face that moves into it is just before the impact"},
    {.name = "--time", .value = "T", .text = "where to stop"},
    {.name = "--steps", .value = "N", .text = "number of steps of the history: 200 unless given"},
    {.name = "--impacts",
     .text = "list the impacts instead: t, face, approach (speed of the gap coordinate), impulse, "
             "opens; a contact "
             "of law bilinear has two rows: it closes (impulse 0), and opens (approach < 0) with "
             "the impulse of "
             "the whole contact"},
    {.name = "--physical", .text = "state, history and impacts in the study's own units of length"},
    {.name = "--force",
     .value = "F1,F2,..",
     .text = "shaken by L f cos(W t + P) from time 0 on, physical: f, with --omega W (rad/s), "
             "--level L, 1 unless the "
             "study has one, 0 for no force, and --phase P, rad"},
    {.name = "--omega", .value = "W", .text = "frequency of the force, rad/s"},
    {.name = "--level", .value = "L", .text = "amplitude of the force"},
    {.name = "--phase", .value = "P", .text = "phase of the force at time 0"},
    {.name = "--damping",
     .value = "ZETA|FILE",
     .text = "as of `force`: modal ratios, or a file with the matrix"},
    {.name = "--restitution", .value = "E", .text = "instead of the study's"},
    {.text = "Where the impact law gives no motion (two stops met together whose impacts disturb "
             "each other, "
             "chatter that ends in a lasting contact), the list ends there, a message says why, "
             "and the exit code "
             "is 1; so it does after a million impacts."},
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_simulate = {
    .name = "simulate",
    .summary = "follow the motion from a state, impact by impact",
    .usage =
        "ricochet simulate STUDY --state X.. V.. --time T [--steps N] [--impacts] [--physical]\n"
        "           [--force F1,F2,.. --omega W [--level L] [--phase P]] [--damping ZETA|FILE]\n"
        "           [--restitution E] [--json | --csv]\n",
    .items = items,
    .example = "ricochet simulate examples/elementary/study.yaml --state 0.1 -0.2 0 2.5 --time 20 "
               "--impacts\n",
    .run = run,
};
