/* ricochet hunt STUDY: periodic orbits of one energy by brute force, and what an atlas lacks of them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "common/cli.h"

static const double two_pi = 6.283185307179586;

enum { POINTS_MAX = 100000000 };

typedef struct {
    ric_hunt_options options;
    const char *atlas_path;
    bool add;
    cli_format format;
} request;

/* ----------------------------------------------------------------- progress */

typedef struct {
    bool terminal;
    struct timespec shown;
} display;

static bool show_progress(const char *what, double part, int found, void *user)
{
    display *d = user;
    if (d->terminal && cli_seconds_since(&d->shown) > 0.1) {
        fprintf(stderr, "\r\033[K%s: %.0f %%, %d orbits", what, 100 * part, found);
        fflush(stderr);
        clock_gettime(CLOCK_MONOTONIC, &d->shown);
    }
    return cli_stopped();
}

/* ------------------------------------------------------------------ options */

static bool take_count(int *argc, char **argv, const char *name, int min, int *out)
{
    const char *text;
    long value = *out;
    if (!cli_take_value(argc, argv, name, &text) || (text && !cli_parse_integer(text, name, min, POINTS_MAX, &value)))
        return false;
    *out = (int)value;
    return true;
}

static bool take_positive(int *argc, char **argv, const char *name, bool *given, double *out)
{
    const char *text;
    if (!cli_take_value(argc, argv, name, &text)) return false;
    *given = text != NULL;
    if (!text) return true;
    if (!cli_parse_number(text, name, out)) return false;
    if (*out > 0) return true;
    cli_wrong("hunt: %s '%s' is not positive", name, text);
    return false;
}

static bool take_request(int *argc, char **argv, request *r, bool *bounded)
{
    const char *text;
    long value;
    bool energy;
    ric_hunt_options *o = &r->options;
    ric_hunt_options_init(o);
    r->add = cli_take_flag(argc, argv, "--add");
    if (!cli_take_format(argc, argv, &r->format) || !cli_take_value(argc, argv, "--atlas", &r->atlas_path) ||
        !take_positive(argc, argv, "--energy", &energy, &o->energy) ||
        !take_positive(argc, argv, "--period", bounded, &o->period[1]) ||
        !take_count(argc, argv, "--lines", 2, &o->lines) || !take_count(argc, argv, "--rows", 0, &o->rows) ||
        !take_count(argc, argv, "--row", 2, &o->row) || !take_count(argc, argv, "--random", 0, &o->random) ||
        !cli_take_value(argc, argv, "--impacts", &text) ||
        (text && !cli_parse_integer(text, "--impacts", 1, RIC_HUNT_IMPACTS, &value)))
        return false;
    if (text) o->impacts = (int)value;
    if (!cli_take_value(argc, argv, "--seed", &text) ||
        (text && !cli_parse_integer(text, "--seed", 0, 2147483647, &value)))
        return false;
    if (text) o->seed = (uint64_t)value;
    if (!energy)
        cli_wrong("hunt: --energy is missing; give the scaled energy at which to look, for example --energy 2.5");
    else if (r->add && !r->atlas_path) cli_wrong("hunt: --add needs --atlas FILE, the atlas to add to");
    return energy && !(r->add && !r->atlas_path);
}

/* --------------------------------------------------------------------- rows */

static json_t *numbers(int n, const double *values)
{
    json_t *list = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(list, cli_number(values[i]));
    return list;
}

static json_t *pairs(const double values[4])
{
    json_t *list = json_array();
    for (int i = 0; i < 4; i += 2) json_array_append_new(list, numbers(2, values + i));
    return list;
}

static void add_finding(json_t *row, const ric_finding *f)
{
    json_object_set_new(row, "atlas", json_string(ric_found_text(f->state)));
    json_object_set_new(row, "branch", cli_id(f->state == RIC_FOUND_KNOWN ? f->branch : 0));
    json_object_set_new(row, "family", cli_id(f->family));
    json_object_set_new(row, "reason", json_string(f->why));
}

static json_t *make_row(const ric_hunt *h, const ric_model *m, int i, const ric_comparison *c)
{
    ric_found p;
    ric_finding finding;
    int n = ric_model_n_dof(m), word[RIC_HUNT_IMPACTS];
    double state[2 * n], flights[RIC_HUNT_IMPACTS];
    json_t *row = json_object();
    ric_hunt_found(h, i, &p, word, state, flights);
    json_object_set_new(row, "orbit", json_integer(i + 1));
    json_object_set_new(row, "word", cli_word(m, p.impacts, word));
    json_object_set_new(row, "impacts", json_integer(p.impacts));
    json_object_set_new(row, "period", cli_number(p.period));
    json_object_set_new(row, "frequency", cli_number(two_pi / p.period));
    json_object_set_new(row, "symmetric", json_boolean(p.symmetric));
    json_object_set_new(row, "reversible", json_boolean(p.reversible));
    json_object_set_new(row, "trace", cli_number(p.trace));
    json_object_set_new(row, "multipliers", pairs(p.multipliers));
    json_object_set_new(row, "state", numbers(2 * n, state));
    json_object_set_new(row, "flights", numbers(p.impacts, flights));
    if (c && !ric_comparison_finding(c, i, &finding)) add_finding(row, &finding);
    return row;
}

static int print(const ric_hunt *h, const ric_model *m, const ric_comparison *c, cli_format format)
{
    static const char columns[] = "orbit word period frequency symmetric reversible trace atlas branch reason";
    static const char alone[] = "orbit word period frequency symmetric reversible trace";
    json_t *rows = json_array();
    for (int i = 0; rows && i < ric_hunt_n_found(h); i++) json_array_append_new(rows, make_row(h, m, i, c));
    int code = rows ? cli_print_rows(rows, c ? columns : alone, format) : cli_report(RIC_E_NOMEM);
    json_decref(rows);
    return code;
}

static void tell_missed(const ric_comparison *c, int n_missed)
{
    for (int i = 0; i < n_missed; i++) {
        ric_missed m;
        if (ric_comparison_missed(c, i, &m)) continue;
        cli_say("not found again: %d impacts on branch %d, period %.10g, trace %.6g, slowest impact %.3g\n", m.impacts,
                m.branch, m.period, m.trace, m.approach);
    }
}

/* One line on stderr; exit code 1 if something is not explained. */
static int summarise(const ric_hunt *h, const ric_hunt_options *options, const ric_comparison *c, int added)
{
    int counts[4] = {0}, n = ric_hunt_n_found(h), n_atlas, n_again, n_missed;
    cli_say("%d orbits of up to %d impacts and period up to %g s at energy %g\n", n, options->impacts,
            options->period[1], options->energy);
    if (!c) return CLI_DONE;
    for (int i = 0; i < n; i++) {
        ric_finding finding;
        if (!ric_comparison_finding(c, i, &finding)) counts[finding.state]++;
    }
    ric_comparison_count(c, &n_atlas, &n_again, &n_missed);
    cli_say("of the atlas's %d orbits there, %d were found again; it lacks %d: %d beyond its budgets, %d isolated, %d "
            "unexplained\n",
            n_atlas, n_again, n - counts[RIC_FOUND_KNOWN], counts[RIC_FOUND_BUDGET], counts[RIC_FOUND_ISOLATED],
            counts[RIC_FOUND_UNEXPLAINED]);
    tell_missed(c, n_missed);
    if (added)
        cli_say("%d start%s added; the next `ricochet run` follows %s\n", added, added == 1 ? "" : "s",
                added == 1 ? "it" : "them");
    return counts[RIC_FOUND_UNEXPLAINED] ? CLI_FAILED : CLI_DONE;
}

/* ------------------------------------------------------------------ command */

/* Whether an atlas is of the model of the study, number by number. */
static bool same_model(const ric_model *a, const ric_model *b)
{
    int n = ric_model_n_dof(a), contacts = ric_model_n_contact(a);
    size_t bytes = (size_t)n * (size_t)n * sizeof(double);
    if (n != ric_model_n_dof(b) || contacts != ric_model_n_contact(b)) return false;
    if (memcmp(ric_model_mass(a), ric_model_mass(b), bytes) ||
        memcmp(ric_model_stiffness(a), ric_model_stiffness(b), bytes))
        return false;
    for (int i = 0; i < contacts; i++) {
        ric_contact x, y;
        if (ric_model_contact(a, i, &x) || ric_model_contact(b, i, &y)) return false;
        if (x.clearance != y.clearance || x.sides != y.sides || x.law != y.law ||
            memcmp(x.normal, y.normal, (size_t)n * sizeof(double)))
            return false;
    }
    return true;
}

static int hunt(const request *r, const ric_study *study, const ric_atlas *atlas)
{
    ric_hunt *h = NULL;
    ric_comparison *c = NULL;
    int added = 0, code;
    display d = {.terminal = isatty(STDERR_FILENO)};
    ric_hunt_options options = r->options;
    options.progress = show_progress;
    options.user = &d;
    cli_catch_signals();
    ric_status status = ric_hunt_create(ric_study_model(study), &options, &h);
    if (!status) status = ric_hunt_run(h);
    if (!status && atlas) status = ric_hunt_compare(h, atlas, &c);
    if (!status && r->add) status = ric_hunt_add(h, c, atlas, r->atlas_path, &added);
    if (d.terminal) fputs("\r\033[K", stderr);
    code = cli_report(status);
    if (!status && !(code = print(h, ric_study_model(study), c, r->format))) code = summarise(h, &options, c, added);
    ric_comparison_free(c);
    ric_hunt_free(h);
    return code;
}

static int run(int argc, char **argv)
{
    request r = {0};
    bool bounded;
    ric_study *study = NULL;
    ric_atlas *atlas = NULL;
    int code;
    if (!take_request(&argc, argv, &r, &bounded) || !cli_operands(&cli_hunt, argc, argv, 1)) return CLI_WRONG;
    ric_status status = ric_study_read(argv[1], &study);
    if (!status && r.atlas_path) status = ric_atlas_read(r.atlas_path, &atlas);
    if (status) code = cli_report(status);
    else if (atlas && !same_model(ric_study_model(study), ric_atlas_model(atlas))) {
        cli_wrong("hunt: %s is the atlas of another model than that of %s", r.atlas_path, argv[1]);
        code = CLI_FAILED;
    } else {
        /* the windows of the atlas, so that the two can be compared */
        double asked = r.options.period[1];
        ric_hunt_options_bound(&r.options, atlas ? ric_atlas_study(atlas) : study);
        if (bounded && !(atlas && asked > r.options.period[1])) r.options.period[1] = asked;
        code = hunt(&r, study, atlas);
    }
    ric_atlas_free(atlas);
    ric_study_free(study);
    return code;
}

static const cli_item items[] = {
    {.text = "Looks for all periodic orbits of one scaled energy with up to N impacts per period, without "
             "following any branch: symmetry lines are scanned, rows and random starts are flown from impact to "
             "impact. For structures of which the stops see two modes. Every orbit is checked with the simulator. "
             "An empty result is no proof; what a known atlas has is the measure of what is found."},
    {.name = "--energy", .value = "E", .text = "scaled energy"},
    {.name = "--impacts", .value = "N", .text = "words of up to N letters, 6 unless given"},
    {.name = "--period",
     .value = "T",
     .text = "periods up to T seconds; unless given 2 pi over the lower end of the study's frequency window"},
    {.name = "--atlas",
     .value = "FILE",
     .text = "tells which of the orbits this atlas has (known), and why it lacks others: they are beyond a "
             "departure that it has not taken (budget), or their family meets none of its junctions (isolated); "
             "exit code 1 if one is unexplained"},
    {.name = "--add", .text = "puts the isolated ones into the atlas as starts; the next `ricochet run` follows them"},
    {.name = "--lines", .value = "N", .text = "points on each symmetry line before it is refined, 20000 unless given"},
    {.name = "--rows", .value = "N", .text = "rows on the section of each face, 60 unless given"},
    {.name = "--row", .value = "N", .text = "points on each row, 1000 unless given"},
    {.name = "--random", .value = "N", .text = "random starts on each face, 250000 unless given"},
    {.name = "--seed", .value = "S", .text = "of the random starts, 1 unless given"},
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_hunt = {
    .name = "hunt",
    .summary = "periodic orbits of one energy by brute force; what an atlas lacks",
    .usage = "ricochet hunt STUDY --energy E [--impacts N] [--period T] [--atlas FILE [--add]]\n"
             "           [--lines N] [--rows N] [--row N] [--random N] [--seed S] [--json | --csv]\n",
    .items = items,
    .example = "ricochet hunt examples/elementary/study.yaml --energy 5 --impacts 4\n",
    .run = run,
};
