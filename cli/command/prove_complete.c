/* ricochet prove --complete STUDY: all periodic orbits of one energy with few impacts, as a
 * theorem, and the same looked for by brute force. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "prove.h"
#include "common/shaking.h"

enum { MOST_WORKERS = 256, MOST_TOLD = 10 };
/* A period and a trace of the hunt are those of an orbit of the census, relative. */
#define SAME_PERIOD 1e-8
#define SAME_TRACE 1e-5
/* RETURNED: turns: phases that differ by less are one to boxes along a curve */
#define RETURNED 1e-7

typedef struct {
    ric_census_options options;
    cli_choice choice;
    cli_format format;
    bool physical, bounded;
    const ric_model *model;
    double length; /* that states are multiplied by: 1 unless physical */
    cli_progress line;
} request;

static bool show_progress(double part, int found, void *user)
{
    request *r = user;
    if (cli_progress_due(&r->line))
        fprintf(stderr, "%.1f %%, %d orbits and images of them", 100 * part, found);
    return cli_stopped();
}

/* ------------------------------------------------------------------ options */

static bool take_request(int *argc, char **argv, request *r)
{
    static const char what[] = "prove --complete";
    const char *text;
    long impacts, workers = 1;
    ric_census_options *o = &r->options;
    ric_census_options_init(o);
    impacts = o->impacts;
    r->physical = cli_take_flag(argc, argv, "--physical");
    const bool hertz = cli_take_flag(argc, argv, "--hz");
    double period = NAN;
    o->energy = NAN;
    if (!cli_take_sort(argc, argv, &r->choice) || !cli_take_format(argc, argv, &r->format) ||
        !cli_take_positive(argc, argv, what, "--energy", HUGE_VAL, &o->energy) ||
        !cli_take_positive(argc, argv, what, "--period", HUGE_VAL, &period) ||
        !cli_take_positive(argc, argv, what, "--seconds", HUGE_VAL, &o->seconds) ||
        !cli_take_value(argc, argv, "--impacts", &text) ||
        (text && !cli_parse_integer(text, "--impacts", 1, RIC_CENSUS_LONGEST, &impacts)) ||
        !cli_take_workers(argc, argv, MOST_WORKERS, &workers))
        return false;
    if (isnan(o->energy)) {
        cli_wrong("prove --complete: --energy is missing; give the scaled energy at which to look, "
                  "for example "
                  "--energy 5");
        return false;
    }
    o->impacts = (int)impacts;
    o->workers = (int)workers;
    r->choice.hertz = hertz;
    r->bounded = !isnan(period);
    if (r->bounded) o->period[1] = period;
    return true;
}

/* --------------------------------------------------------------------- rows */

static json_t *make_row(const request *r, const ric_census *census, int i)
{
    ric_census_orbit z;
    const int n = ric_model_n_dof(r->model);
    int word[RIC_CENSUS_LONGEST];
    double state[2 * n], flights[RIC_CENSUS_LONGEST];
    ric_census_orbit_at(census, i, &z, word, state, flights);
    const double period = (z.period[0] + z.period[1]) / 2;
    json_t *row = json_object();
    json_object_set_new(row, "orbit", json_integer(i + 1));
    json_object_set_new(row, "energy", cli_energy(r->options.energy, r->length));
    json_object_set_new(row, "word", cli_word(r->model, z.impacts, word));
    json_object_set_new(row, "impacts", json_integer(z.impacts));
    json_object_set_new(row, "period", cli_number(period));
    json_object_set_new(row, "frequency", cli_number(CLI_TWO_PI / period));
    json_object_set_new(row, "symmetric", json_boolean(z.symmetric));
    json_object_set_new(row, "reversible", json_boolean(z.reversible));
    json_object_set_new(row, "stable", json_string(cli_stability(z.stable)));
    json_object_set_new(row, "trace", cli_number((z.trace[0] + z.trace[1]) / 2));
    json_object_set_new(row, "approach", cli_number(r->length * z.approach));
    json_object_set_new(row, "period_within", cli_numbers(2, z.period, 1));
    json_object_set_new(row, "trace_within", cli_numbers(2, z.trace, 1));
    json_object_set_new(row, "state", cli_numbers(2 * n, state, r->length));
    json_object_set_new(row, "flights", cli_numbers(z.impacts, flights, 1));
    return row;
}

static int print(const request *r, const ric_census *census)
{
    static const char columns[] =
        "orbit energy word period frequency symmetric reversible stable trace approach";
    json_t *rows = json_array();
    if (!rows) return cli_report(RIC_E_NOMEM);
    for (int i = 0; i < ric_census_n_orbit(census); i++)
        json_array_append_new(rows, make_row(r, census, i));
    if (r->choice.hertz) cli_in_hertz(rows);
    const int code = cli_choose(rows, &r->choice) ? cli_print_rows(rows, columns, r->format)
                                                  : CLI_WRONG;
    json_decref(rows);
    return code;
}

/* ------------------------------------------------------------------ the account */

static void tell_periods(const ric_census_account *a, FILE *out)
{
    if (!(a->flight > 0)) cli_tell(out, "which reaches no stop\n");
    else if (!a->all_periods)
        cli_tell(out, "of periods from %.4g to %.4g s\n", a->period[0], a->period[1]);
    else
        cli_tell(out,
                 "of any period: none is shorter than %.4g s, no flight is longer than %.4g s\n",
                 a->period[0], a->flight);
}

static void tell_open(const request *r, const ric_census *census, int n)
{
    for (int i = 0; i < n && i < MOST_TOLD; i++) {
        int impacts, word[RIC_CENSUS_LONGEST];
        double flights[RIC_CENSUS_LONGEST];
        if (ric_census_open_at(census, i, &impacts, word, flights)) continue;
        json_t *text = cli_word(r->model, impacts, word), *times = cli_numbers(impacts, flights, 1);
        char *shown = json_dumps(times, JSON_REAL_PRECISION(8));
        cli_say("ricochet: not proved to be a motion, nor to be none: word %s, flights %s\n",
                json_string_value(text), shown ? shown : "");
        free(shown);
        json_decref(times);
        json_decref(text);
    }
}

/* Why boxes are undecided where all linear motions come back within the periods looked through, and
 * some of them reach no stop. */
static void tell_return(const ric_model *model, const ric_census_account *a, FILE *out)
{
    const int n = ric_model_n_dof(model);
    double frequency[n], two[2] = {0};
    bool seen[n];
    if (a->flight < HUGE_VAL || ric_model_frequencies(model, frequency) ||
        ric_model_seen(model, seen))
        return;
    for (int i = n - 1, k = 1; i >= 0 && k >= 0; i--)
        if (seen[i]) two[k--] = frequency[i];
    const double most = a->period[1] * two[0] / (2 * acos(-1));
    for (int k = 1; two[0] > 0 && k <= most; k++) {
        const double other = k * two[1] / two[0];
        if (fabs(other - round(other)) > RETURNED) continue;
        cli_tell(out,
                 "the modes turn %d : %.0f times in one period, so that linear motions come back; "
                 "those that touch a stop lie on curves, which no boxes decide\n",
                 k, other);
        return;
    }
}

static void tell_account(const request *r, const ric_census *census, const ric_census_account *a,
                         FILE *out)
{
    const bool complete = !a->undecided && !a->open;
    const double energy = cli_unit_of_energies(r->length) * r->options.energy;
    cli_tell(out, "%s: %d orbit%s of up to %d impact%s at energy %g, ",
             complete ? "complete" : "not complete", ric_census_n_orbit(census),
             cli_plural(ric_census_n_orbit(census)), r->options.impacts,
             cli_plural(r->options.impacts), energy);
    tell_periods(a, out);
    cli_tell(out, "%ld boxes of flight times in %d words; %d solutions are no motions\n", a->boxes,
             a->words, a->ghosts);
    if (a->undecided)
        cli_tell(out, "%ld boxes are undecided, %.3g of all flight times and states\n",
                 a->undecided, a->measure);
    if (a->undecided) tell_return(r->model, a, out);
    if (a->open)
        cli_tell(out, "of %d solutions it is not proved whether they are motions\n", a->open);
    tell_open(r, census, a->open);
}

/* Whether an orbit of the hunt is one of the census. */
static bool is_counted(const ric_census *census, const ric_found *found)
{
    for (int i = 0; i < ric_census_n_orbit(census); i++) {
        ric_census_orbit z;
        ric_census_orbit_at(census, i, &z, NULL, NULL, NULL);
        const double period = (z.period[0] + z.period[1]) / 2,
                     trace = (z.trace[0] + z.trace[1]) / 2;
        if (z.impacts == found->impacts && fabs(period - found->period) <= SAME_PERIOD * period &&
            fabs(trace - found->trace) <= SAME_TRACE * (1 + fabs(trace)))
            return true;
    }
    return false;
}

static bool stop_is_asked(const char *what, double part, int found, void *user)
{
    (void)what;
    (void)part;
    (void)found;
    (void)user;
    return cli_stopped();
}

/* The same by the search that knows nothing of boxes: what it finds has to be there. */
static int check_by_hunt(const request *r, const ric_census *census, const ric_census_account *a,
                         FILE *out)
{
    ric_hunt *hunt = NULL;
    ric_hunt_options o;
    int missing = 0;
    ric_hunt_options_init(&o);
    o.energy = r->options.energy;
    o.impacts = r->options.impacts;
    if (a->period[1] > 0) o.period[1] = a->period[1];
    o.progress = stop_is_asked;
    ric_status status = ric_hunt_create(r->model, &o, &hunt);
    if (!status) status = ric_hunt_run(hunt);
    for (int i = 0; !status && i < ric_hunt_n_found(hunt); i++) {
        ric_found found;
        ric_hunt_found(hunt, i, &found, NULL, NULL, NULL);
        if (is_counted(census, &found)) continue;
        missing++;
        cli_say(
            "ricochet: an orbit of %d impact%s and period %.12g that the hunt finds is not there\n",
            found.impacts, cli_plural(found.impacts), found.period);
    }
    if (!status)
        cli_tell(out, "a hunt finds %d orbit%s there, of which %d %s missing here\n",
                 ric_hunt_n_found(hunt), cli_plural(ric_hunt_n_found(hunt)), missing,
                 missing == 1 ? "is" : "are");
    ric_hunt_free(hunt);
    return status ? cli_report(status) : missing ? CLI_FAILED : CLI_DONE;
}

static int run_census(request *r)
{
    ric_census *census = NULL;
    ric_census_account a;
    FILE *out = r->format == CLI_TEXT ? stdout : stderr;
    r->options.progress = show_progress;
    r->options.user = r;
    r->line = cli_progress_begin();
    cli_catch_signals();
    const ric_status status = ric_census_run(r->model, &r->options, &census);
    cli_progress_end(&r->line);
    if (status) return cli_report(status);
    ric_census_account_of(census, &a);
    int code = print(r, census);
    if (!code) tell_account(r, census, &a, out);
    if (!code && a.stopped) code = cli_stopped() ? CLI_INTERRUPTED : CLI_LIMIT;
    if (!code) code = check_by_hunt(r, census, &a, out);
    if (!code && (a.undecided || a.open)) code = CLI_FAILED;
    ric_census_free(census);
    return code;
}

bool prove_complete_only(int *argc, char **argv)
{
    static const char *const values[] = {"--energy", "--impacts", "--period", "--sort"};
    static const char *const flags[] = {"--physical", "--hz"};
    const char *given = NULL, *text;
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        if (!cli_take_value(argc, argv, values[i], &text)) return false;
        if (text) given = values[i];
    }
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++)
        if (cli_take_flag(argc, argv, flags[i])) given = flags[i];
    if (given) cli_wrong("prove: %s is about --complete, which is not given", given);
    return !given;
}

int prove_complete(int argc, char **argv)
{
    request r = {.length = 1};
    ric_study *study = NULL;
    ric_hunt_options window;
    cli_command this = cli_prove;
    this.usage = strstr(cli_prove.usage, "ricochet prove STUDY"); /* the last of its four */
    if (!take_request(&argc, argv, &r) || !cli_operands(&this, argc, argv, 1) ||
        !cli_sorts_by(&r.choice,
                      "orbit energy word impacts period frequency symmetric reversible stable "
                      "trace approach",
                      "period_within trace_within state flights"))
        return CLI_WRONG;
    ric_status status = ric_study_read(argv[1], &study);
    if (status) return cli_report(status);
    cli_forcing_warn(study, argv[1], "the census");
    r.model = ric_study_model(study);
    if (r.physical) r.length = cli_unit_of_lengths(r.model, true);
    r.options.energy /= cli_unit_of_energies(r.length);
    ric_hunt_options_init(&window);
    ric_hunt_options_bound(&window, study);
    if (!r.bounded) r.options.period[1] = window.period[1];
    const int code = run_census(&r);
    ric_study_free(study);
    return code;
}
