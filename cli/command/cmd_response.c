/* ricochet response ATLAS: curves of exact forced orbits; ricochet response FILE lists what such a
 * file has. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/shaking.h"

enum { LEVELS_MOST = 100 };

typedef enum { LIST_CURVES, LIST_POINTS, LIST_EVENTS } listed;

typedef struct {
    const char *path, *out, *study;
    cli_shaking shaking;
    ric_response_options options;
    double omega[2], levels[LEVELS_MOST];
    int n_omega, n_level;
    listed what;
    long curve; /* 0: all */
    cli_format format;
} request;

/* -------------------------------------------------------------------- rows */

static void add_orbit(json_t *row, int n, int letters, const ric_response_point *p)
{
    json_object_set_new(row, "arclength", cli_number(p->arclength));
    json_object_set_new(row, "omega", cli_number(p->omega));
    json_object_set_new(row, "level", cli_number(p->level));
    json_object_set_new(row, "restitution", cli_number(p->restitution));
    json_object_set_new(row, "period", cli_number(p->period));
    json_object_set_new(row, "phase", cli_number(p->phase));
    json_object_set_new(row, "peak", cli_numbers(n, p->peak, 1));
    json_object_set_new(row, "rms", cli_numbers(n, p->rms, 1));
    json_object_set_new(row, "stable", json_string(cli_stability(p->stable)));
    json_object_set_new(row, "largest", cli_number(p->largest));
    json_object_set_new(row, "reach", cli_number(p->reach));
    json_object_set_new(row, "approach", cli_number(p->approach));
    json_object_set_new(row, "residual", cli_number(p->residual));
    json_object_set_new(row, "state", cli_numbers(2 * n, p->state, 1));
    json_object_set_new(row, "flights", cli_numbers(letters ? letters : 1, p->flights, 1));
    json_object_set_new(row, "multipliers", cli_pairs(2 * n, p->multipliers));
}

/* What varies, at the ends of a curve. */
static void window_of(const ric_response *r, const ric_response_curve *c, double out[2],
                      double *stable)
{
    ric_response_point p;
    int count = 0;
    out[0] = INFINITY;
    out[1] = -INFINITY;
    for (int i = 0; i < c->n_point && !ric_response_point_at(r, c->id, i, &p); i++) {
        const ric_response_along along = ric_response_asked(r)->along;
        const double value = along == RIC_RESPONSE_OMEGA   ? p.omega
                             : along == RIC_RESPONSE_LEVEL ? p.level
                                                           : p.restitution;
        out[0] = fmin(out[0], value);
        out[1] = fmax(out[1], value);
        count += p.stable == RIC_STABLE_YES;
    }
    *stable = c->n_point ? (double)count / c->n_point : NAN;
}

static json_t *curve_row(const ric_response *r, const ric_response_curve *c)
{
    double window[2], stable;
    json_t *row = json_object();
    window_of(r, c, window, &stable);
    json_object_set_new(row, "id", json_integer(c->id));
    json_object_set_new(row, "word", cli_word(ric_response_model(r), c->letters, c->word));
    json_object_set_new(row, "impacts", json_integer(c->impacts));
    json_object_set_new(row, "periods", json_integer(c->harmonic));
    json_object_set_new(row, "level", cli_number(c->level));
    json_object_set_new(row, "points", json_integer(c->n_point));
    json_object_set_new(row, "lowest", cli_number(window[0]));
    json_object_set_new(row, "highest", cli_number(window[1]));
    json_object_set_new(row, "stable_points", cli_number(stable));
    json_object_set_new(row, "branch", cli_id(c->branch));
    json_object_set_new(row, "from", cli_id(c->from));
    json_object_set_new(row, "to", cli_id(c->to));
    json_object_set_new(row, "begins", json_string(ric_response_stop_text(c->begin)));
    json_object_set_new(row, "ends", json_string(ric_response_stop_text(c->end)));
    return row;
}

static ric_status add_points(const ric_response *r, const ric_response_curve *c, json_t *rows)
{
    ric_response_point p;
    ric_status status = RIC_OK;
    for (int i = 0; i < c->n_point && !status; i++) {
        json_t *row = json_object();
        status = ric_response_point_at(r, c->id, i, &p);
        json_object_set_new(row, "curve", json_integer(c->id));
        json_object_set_new(row, "point", json_integer(i));
        if (!status) add_orbit(row, ric_model_n_dof(ric_response_model(r)), c->letters, &p);
        json_array_append_new(rows, row);
    }
    return status;
}

static ric_status add_events(const ric_response *r, long curve, json_t *rows)
{
    ric_response_event e;
    ric_response_curve c;
    ric_status status = RIC_OK;
    for (int id = 1; id <= ric_response_n_event(r) && !status; id++) {
        status = ric_response_event_at(r, id, &e);
        if (!status) status = ric_response_curve_at(r, e.curve, &c);
        if (status || (curve && e.curve != curve)) continue;
        json_t *row = json_object();
        json_object_set_new(row, "id", json_integer(e.id));
        json_object_set_new(row, "kind", json_string(ric_response_kind_text(e.kind)));
        json_object_set_new(row, "curve", json_integer(e.curve));
        add_orbit(row, ric_model_n_dof(ric_response_model(r)), c.letters, &e.at);
        json_array_append_new(rows, row);
    }
    return status;
}

static int list(const request *ask, const ric_response *r)
{
    static const char *const columns[] =
        {("id word impacts periods level points lowest highest stable_points branch from to "
          "begins ends"),
         "curve point omega level restitution period phase peak rms stable largest reach approach",
         "id kind curve omega level restitution period peak stable largest"};
    json_t *rows = json_array();
    ric_status status = RIC_OK;
    for (int id = 1; id <= ric_response_n_curve(r) && !status && ask->what != LIST_EVENTS; id++) {
        ric_response_curve c;
        if (ask->curve && id != ask->curve) continue;
        status = ric_response_curve_at(r, id, &c);
        if (!status && ask->what == LIST_CURVES) json_array_append_new(rows, curve_row(r, &c));
        else if (!status) status = add_points(r, &c, rows);
    }
    if (ask->what == LIST_EVENTS) status = add_events(r, ask->curve, rows);
    const int code = status ? cli_report(status)
                            : cli_print_rows(rows, columns[ask->what], ask->format);
    json_decref(rows);
    return code;
}

static void say_skipped(const ric_response *r)
{
    const char *why;
    const int n = ric_response_skipped(r, &why);
    if (n) cli_say("ricochet: %d start%s left out: %s\n", n, n == 1 ? " was" : "s were", why);
}

static int list_file(const request *ask, const char *path)
{
    ric_response *r = NULL;
    ric_status status = ric_response_read(path, &r);
    int code = status ? cli_report(status) : CLI_DONE;
    if (!code && ask->curve > ric_response_n_curve(r))
        code = cli_wrong("response: no curve %ld; %s has %d", ask->curve, path,
                         ric_response_n_curve(r));
    if (!code) code = list(ask, r);
    if (!code) say_skipped(r);
    if (!code && !ric_response_finished(r))
        cli_say("ricochet: %s is not finished; give the call that began it once more\n", path);
    ric_response_free(r);
    return code;
}

/* ------------------------------------------------------------------- command */

static bool asked_to_stop(void *user)
{
    (void)user;
    return cli_stopped();
}

static int none(const request *ask, const ric_response *r)
{
    say_skipped(r);
    cli_say("ricochet: no forced orbit was found in the window; `ricochet force %s` lists the "
            "thresholds of all orbits\n",
            ask->path);
    return CLI_FAILED;
}

static bool parse_whole(const char *text, const char *what, int *out)
{
    long value;
    if (!text) return true;
    if (!cli_parse_integer(text, what, 1, INT_MAX, &value)) return false;
    *out = (int)value;
    return true;
}

static bool parse_along(const char *text, ric_response_along *out)
{
    static const char *const words[] = {"omega", "level", "restitution"};
    for (int i = 0; text && i < 3; i++)
        if (strcmp(text, words[i]) == 0) {
            *out = (ric_response_along)i;
            return true;
        }
    if (!text) return true;
    cli_wrong("response: --along %s: what varies is omega, level or restitution", text);
    return false;
}

static bool is_window(int n, const double *values, const char *option)
{
    if (n == 2 && values[0] > 0 && values[1] > values[0]) return true;
    if (!strcmp(option, "--restitution"))
        cli_wrong("response: --restitution gives what varies: two numbers above 0, at which bodies "
                  "would stay together "
                  "after an impact, and at most 1, the smaller one first, such as 0.5,1");
    else
        cli_wrong("response: %s gives what varies: two numbers above 0, the smaller one first, "
                  "such as 0.5,2",
                  option);
    return false;
}

/* What varies has a window, the rest numbers. */
static bool place_windows(request *ask)
{
    ric_response_options *o = &ask->options;
    const bool by_omega = o->along == RIC_RESPONSE_OMEGA, by_level = o->along == RIC_RESPONSE_LEVEL;
    const double *window = by_omega   ? ask->omega
                           : by_level ? ask->levels
                                      : ask->shaking.restitutions;
    const int n = by_omega ? ask->n_omega : by_level ? ask->n_level : ask->shaking.n_restitution;
    if (!is_window(n, window, by_omega ? "--omega" : by_level ? "--level" : "--restitution"))
        return false;
    memcpy(o->window, window, sizeof o->window);
    if (!by_omega && ask->n_omega != 1) {
        cli_wrong("response: --omega W gives the one frequency of the force, rad/s");
        return false;
    }
    if (o->along != RIC_RESPONSE_RESTITUTION && ask->shaking.n_restitution > 1) {
        cli_wrong("response: --restitution takes one number unless --along restitution");
        return false;
    }
    o->omega = by_omega ? 0 : ask->omega[0];
    if (by_level) ask->n_level = 0;
    else if (ask->n_level < 1) {
        cli_wrong("response: --level L,.. is missing, the amplitudes of the force");
        return false;
    }
    return true;
}

static int run_response(request *ask, const ric_atlas *atlas)
{
    ric_response *r = NULL;
    ric_status status;
    struct stat before;
    const bool is_new = lstat(ask->out, &before) != 0;
    cli_catch_signals();
    ask->options.shaking = cli_shaking_of(&ask->shaking);
    ask->options.n_harmonic = ask->shaking.n_harmonic;
    ask->options.harmonics = ask->shaking.harmonics;
    ask->options.n_level = ask->n_level;
    ask->options.levels = ask->levels;
    if ((status = ric_response_run(atlas, &ask->options, ask->out, asked_to_stop, NULL)))
        return cli_report(status);
    if ((status = ric_response_read(ask->out, &r))) return cli_report(status);
    const int code = ric_response_n_curve(r) ? list(ask, r) : none(ask, r);
    if (ric_response_n_curve(r)) say_skipped(r);
    else if (is_new && ric_response_finished(r))
        unlink(ask->out); /* it would refuse the next call */
    ric_response_free(r);
    return code;
}

/* What is not said by options, from the study. */
static int complete(request *ask, const ric_atlas *atlas)
{
    cli_shaking *h = &ask->shaking;
    const int code = cli_shaking_read(h, "response", ask->study, ric_atlas_study(atlas));
    if (code) return code;
    for (int i = 0, given = ask->n_level; !given && i < h->amplitude.n; i++) {
        ask->levels[i] = h->amplitude.value[i];
        ask->n_level = i + 1;
    }
    if (!ask->n_omega && h->frequency[1] > 0) {
        memcpy(ask->omega, h->frequency, sizeof ask->omega);
        ask->n_omega = h->frequency[1] > h->frequency[0] ? 2 : 1;
    }
    if (!h->n_force)
        return cli_wrong("response: --force is missing; give the vector f of the force, one number "
                         "per displacement, for "
                         "example --force 1,0, or section forcing of the study");
    return place_windows(ask) ? CLI_DONE : CLI_WRONG;
}

static int compute(request *ask)
{
    ric_atlas *atlas = NULL;
    const ric_status status = ric_atlas_read(ask->path, &atlas);
    int code = status      ? cli_report(status)
               : !ask->out ? cli_wrong("response: -o FILE is missing, the file for the response")
                           : complete(ask, atlas);
    if (!code) code = run_response(ask, atlas);
    ric_atlas_free(atlas);
    return code;
}

static int take_request(int *argc, char **argv, request *ask)
{
    const char *omega, *level, *along, *branch, *impacts, *periods, *points, *curves, *step, *curve,
        *once;
    int code = CLI_WRONG;
    long number = 0;
    if (cli_take_flag(argc, argv, "--points")) ask->what = LIST_POINTS;
    if (cli_take_flag(argc, argv, "--events")) ask->what = LIST_EVENTS;
    if (!cli_take_format(argc, argv, &ask->format) ||
        !cli_take_shaking(argc, argv, &ask->shaking, &code) ||
        !cli_take_value(argc, argv, "--omega", &omega) ||
        !cli_take_value(argc, argv, "--level", &level) ||
        !cli_take_value(argc, argv, "--along", &along) ||
        !cli_take_value(argc, argv, "--branch", &branch) ||
        !cli_take_value(argc, argv, "--impacts", &impacts) ||
        !cli_take_value(argc, argv, "--periods", &periods) ||
        !cli_take_value(argc, argv, "--once-in", &once) ||
        !cli_take_value(argc, argv, "--most-points", &points) ||
        !cli_take_value(argc, argv, "--most-curves", &curves) ||
        !cli_take_value(argc, argv, "--step", &step) ||
        !cli_take_value(argc, argv, "--curve", &curve) ||
        !cli_take_value(argc, argv, "--study", &ask->study) ||
        !cli_take_value(argc, argv, "-o", &ask->out) ||
        !cli_operands(&cli_response, *argc, argv, 1))
        return code;
    ask->path = argv[1];
    ric_response_options *o = &ask->options;
    if ((curve && !cli_parse_integer(curve, "--curve", 1, INT_MAX, &number)) ||
        !parse_along(along, &o->along) ||
        (omega && !cli_parse_list(omega, "--omega", 2, &ask->n_omega, ask->omega)) ||
        (level && !cli_parse_list(level, "--level", LEVELS_MOST, &ask->n_level, ask->levels)) ||
        !parse_whole(branch, "--branch", &o->branch) ||
        !parse_whole(impacts, "--impacts", &o->impacts) ||
        !parse_whole(periods, "--periods", &o->periods) ||
        !parse_whole(once, "--once-in", &o->once_in) ||
        !parse_whole(points, "--most-points", &o->points) ||
        !parse_whole(curves, "--most-curves", &o->curves) ||
        (step && !cli_parse_number(step, "--step", &o->step)))
        return CLI_WRONG;
    ask->curve = number;
    return CLI_DONE;
}

static int run(int argc, char **argv)
{
    request *ask = calloc(1, sizeof *ask);
    if (!ask) return cli_report(RIC_E_NOMEM);
    ric_response_defaults(&ask->options);
    int code = take_request(&argc, argv, ask);
    if (code == CLI_DONE)
        code = ric_response_is(ask->path) ? list_file(ask, ask->path) : compute(ask);
    cli_shaking_free(&ask->shaking);
    free(ask);
    return code;
}

static const cli_item items[] = {
    {.text = "Curves of periodic motions of the damped and shaken structure, solved to rounding: "
             "from the predictions of "
             "first order beside the orbits of the atlas and from the linear motion, followed "
             "along the frequency of the "
             "force, its level, or the restitution. At grazings other impacts are tried, at branch "
             "points and doublings "
             "the "
             "curves that leave are followed. They are kept in a file of their own; a run that was "
             "stopped goes on when "
             "the same call is given once more. Given such a file, lists what it has."},
    CLI_ITEMS_SHAKING,
    CLI_ITEM_SHAKING_STUDY,
    {.name = "--along",
     .value = "WHAT",
     .words = "omega level restitution",
     .text = "what varies; omega unless given"},
    {.name = "--omega",
     .value = "A,B",
     .text = "window of the frequency of the force, rad/s; one number if it does not vary"},
    {.name = "--level",
     .value = "L,..",
     .text = "amplitudes of the force, curves for each; its window if it varies"},
    {.name = "-o", .value = "FILE", .text = "the file of the response"},
    {.name = "--branch",
     .value = "ID",
     .text = "only beside this branch of the atlas, and without the linear motion"},
    {.name = "--impacts",
     .value = "N",
     .text = "largest number of impacts in a period of the motion: 12 unless given"},
    {.name = "--periods",
     .value = "N",
     .text = "largest number of periods of the force in one of the motion: 4 unless given"},
    {.name = "--once-in",
     .value = "N",
     .text = "at a grazing also motions that impact there once in up to N of its periods: 1, in "
             "each, unless given"},
    {.name = "--most-points", .value = "N", .text = "most orbits of a curve: 2000 unless given"},
    {.name = "--most-curves", .value = "N", .text = "most curves: 200 unless given"},
    {.name = "--step",
     .value = "H",
     .text = "longest step, relative to the motion: 0.05 unless given"},
    {.name = "--points",
     .text = "list the orbits of the curves instead: peak and rms of every displacement, scaled"},
    {.name = "--events",
     .text = "list the events: fold, branch-point, doubling, neimark-sacker, grazing"},
    {.name = "--curve", .value = "ID", .text = "only of this curve"},
    {.name = "begins",
     .text = "grazing, window, budget, closed, failed, or event: at one of another curve, `from`; "
             "ends: likewise"},
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_response = {
    .name = "response",
    .summary = "curves of exact forced motions of the damped structure",
    .usage = "ricochet response ATLAS [--force F1,F2,..] [--level L,..] [--omega A,B]\n"
             "           [--damping ZETA|FILE] [--restitution E] [--harmonic M] [--study STUDY]\n"
             "           [--along WHAT] [--branch ID] [--impacts N] [--periods N] [--once-in N]\n"
             "           [--most-points N] [--most-curves N] [--step H] -o FILE [--json | --csv]\n"
             "ricochet response FILE [--points | --events] [--curve ID] [--json | --csv]\n",
    .items = items,
    .example =
        "ricochet response s.ricochet --force 1,0 --damping 0.01 --level 0.2 --omega 1,3 -o r\n",
    .run = run,
};
