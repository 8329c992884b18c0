/* ricochet hunt STUDY: periodic orbits of one energy, or of a window of them, by brute force, and
 * what an atlas lacks. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/shaking.h"

enum {
    POINTS_MAX = 100000000,
    LEVELS = 6, /* of a ladder of energies: each lies in the middle of two of the level before; 65
                   in all */
    LEVELS_LEAST = 3, /* that are gone through, even if one finds nothing new: 9 energies */
};

typedef struct {
    ric_hunt_options options;
    double energy[2]; /* a window, or one energy twice */
    const char *atlas_path;
    bool add, physical;
    cli_choice choice; /* order, and Hz */
    double
        d; /* the length that states are multiplied by, energies by its square: 1 unless physical */
    cli_format format;
} request;

/* ----------------------------------------------------------------- progress */

static bool show_progress(const char *what, double part, int found, void *user)
{
    if (cli_progress_due(user))
        fprintf(stderr, "%s: %.0f %%, %d orbit%s", what, 100 * part, found, cli_plural(found));
    return cli_stopped();
}

/* ------------------------------------------------------------------ options */

/* Columns in which rows may be in order; those of lists; and what a comparison adds. */
#define COLUMNS "orbit energy word impacts period frequency symmetric reversible trace"
#define LISTS "multipliers state flights"
#define COMPARED " atlas branch family reason"

static bool take_count(int *argc, char **argv, const char *name, int min, int *out)
{
    const char *text;
    long value = *out;
    if (!cli_take_value(argc, argv, name, &text) ||
        (text && !cli_parse_integer(text, name, min, POINTS_MAX, &value)))
        return false;
    *out = (int)value;
    return true;
}

/* One energy, or a window as A,B. */
static bool take_energies(int *argc, char **argv, double energy[2])
{
    const char *text;
    int n;
    if (!cli_take_value(argc, argv, "--energy", &text)) return false;
    if (!text) {
        cli_wrong("hunt: --energy is missing; give the scaled energy at which to look, for example "
                  "--energy 2.5, or a window, --energy 0.7,40");
        return false;
    }
    if (!cli_parse_list(text, "--energy", 2, &n, energy)) return false;
    if (n == 1) energy[1] = energy[0];
    if (!(energy[0] > 0)) cli_wrong("hunt: --energy '%s' is not positive", text);
    else if (energy[1] < energy[0])
        cli_wrong("hunt: --energy '%s': the window ends before it begins", text);
    return energy[0] > 0 && energy[1] >= energy[0];
}

static bool take_request(int *argc, char **argv, request *r, bool *bounded)
{
    const char *text;
    long value;
    double period = NAN;
    ric_hunt_options *o = &r->options;
    ric_hunt_options_init(o);
    r->add = cli_take_flag(argc, argv, "--add");
    r->physical = cli_take_flag(argc, argv, "--physical");
    const bool hertz = cli_take_flag(argc, argv, "--hz");
    if (!cli_take_sort(argc, argv, &r->choice) || !cli_take_format(argc, argv, &r->format) ||
        !cli_take_value(argc, argv, "--atlas", &r->atlas_path) ||
        !take_energies(argc, argv, r->energy) ||
        !cli_take_positive(argc, argv, "hunt", "--period", HUGE_VAL, &period) ||
        !take_count(argc, argv, "--lines", 2, &o->lines) ||
        !take_count(argc, argv, "--rows", 0, &o->rows) ||
        !take_count(argc, argv, "--row", 2, &o->row) ||
        !take_count(argc, argv, "--random", 0, &o->random) ||
        !take_count(argc, argv, "--starts", 0, &o->starts) ||
        !cli_take_value(argc, argv, "--impacts", &text) ||
        (text && !cli_parse_integer(text, "--impacts", 1, RIC_HUNT_IMPACTS, &value)))
        return false;
    if (text) o->impacts = (int)value;
    if (!cli_take_value(argc, argv, "--seed", &text) ||
        (text && !cli_parse_integer(text, "--seed", 0, 2147483647, &value)))
        return false;
    if (text) o->seed = (uint64_t)value;
    r->choice.hertz = hertz;
    *bounded = !isnan(period);
    if (*bounded) o->period[1] = period;
    o->energy = r->energy[0];
    return true;
}

/* --------------------------------------------------------------------- rows */

static void add_finding(json_t *row, const ric_finding *f)
{
    json_object_set_new(row, "atlas", json_string(ric_found_text(f->state)));
    json_object_set_new(row, "branch", cli_id(f->state == RIC_FOUND_KNOWN ? f->branch : 0));
    json_object_set_new(row, "family", cli_id(f->family));
    json_object_set_new(row, "reason", json_string(f->why));
}

/* d: the unit of lengths */
static json_t *make_row(const ric_hunt *h, const ric_model *m, double energy, double d, int i,
                        const ric_comparison *c)
{
    ric_found p;
    ric_finding finding;
    int n = ric_model_n_dof(m), word[RIC_HUNT_IMPACTS];
    double state[2 * n], flights[RIC_HUNT_IMPACTS];
    json_t *row = json_object();
    ric_hunt_found(h, i, &p, word, state, flights);
    json_object_set_new(row, "orbit", json_integer(i + 1));
    json_object_set_new(row, "energy", cli_energy(energy, d));
    json_object_set_new(row, "word", cli_word(m, p.impacts, word));
    json_object_set_new(row, "impacts", json_integer(p.impacts));
    json_object_set_new(row, "period", cli_number(p.period));
    json_object_set_new(row, "frequency", cli_number(CLI_TWO_PI / p.period));
    json_object_set_new(row, "symmetric", json_boolean(p.symmetric));
    json_object_set_new(row, "reversible", json_boolean(p.reversible));
    json_object_set_new(row, "trace", cli_number(p.trace));
    json_object_set_new(row, "multipliers", cli_pairs(2, p.multipliers));
    json_object_set_new(row, "state", cli_numbers(2 * n, state, d));
    json_object_set_new(row, "flights", cli_numbers(p.impacts, flights, 1));
    if (c && !ric_comparison_finding(c, i, &finding)) add_finding(row, &finding);
    return row;
}

static void add_rows(const ric_hunt *h, const ric_model *m, double energy, double d,
                     const ric_comparison *c, json_t *rows)
{
    for (int i = 0; i < ric_hunt_n_found(h); i++)
        json_array_append_new(rows, make_row(h, m, energy, d, i, c));
}

static int print(json_t *rows, bool compared, cli_format format)
{
    static const char columns[] =
        "orbit energy word period frequency symmetric reversible trace atlas branch reason";
    static const char alone[] = "orbit energy word period frequency symmetric reversible trace";
    return cli_print_rows(rows, compared ? columns : alone, format);
}

static void tell_missed(const ric_comparison *c, int n_missed)
{
    for (int i = 0; i < n_missed; i++) {
        ric_missed m;
        if (ric_comparison_missed(c, i, &m)) continue;
        cli_say("not found again: %d impact%s on branch %d, period %.10g, trace %.6g, slowest "
                "impact %.3g\n",
                m.impacts, cli_plural(m.impacts), m.branch, m.period, m.trace, m.approach);
    }
}

/* One line on stderr; exit code 1 if something is not explained. */
static int summarise(const ric_hunt *h, const ric_hunt_options *options, double unit,
                     const ric_comparison *c, int added)
{
    int counts[4] = {0}, n = ric_hunt_n_found(h), n_atlas, n_again, n_missed;
    cli_say("%d orbit%s of up to %d impact%s and period up to %g s at energy %g\n", n,
            cli_plural(n), options->impacts, cli_plural(options->impacts), options->period[1],
            unit * options->energy);
    if (!c) return CLI_DONE;
    for (int i = 0; i < n; i++) {
        ric_finding finding;
        if (!ric_comparison_finding(c, i, &finding)) counts[finding.state]++;
    }
    ric_comparison_count(c, &n_atlas, &n_again, &n_missed);
    cli_say("of the atlas's %d orbit%s there, %d %s found again; it lacks %d: %d beyond its "
            "budgets, %d isolated, %d "
            "unexplained\n",
            n_atlas, cli_plural(n_atlas), n_again, n_again == 1 ? "was" : "were",
            n - counts[RIC_FOUND_KNOWN], counts[RIC_FOUND_BUDGET], counts[RIC_FOUND_ISOLATED],
            counts[RIC_FOUND_UNEXPLAINED]);
    tell_missed(c, n_missed);
    if (added)
        cli_say("%d start%s added; the next `ricochet run` follows %s\n", added,
                added == 1 ? "" : "s", added == 1 ? "it" : "them");
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

/* What a hunt goes through: one energy after the other. */
typedef struct {
    const request *request;
    const ric_study *study;
    ric_atlas *atlas; /* NULL: nothing to compare with; explored anew where something was added */
    cli_progress line;
    json_t *rows;
    json_t *isolated; /* word and symmetries of what an atlas lacks, as keys */
    int added, fresh; /* starts; isolated ones of the level at work that no level before has seen */
    int n_energy, code;
} quest;

/* An isolated family shows at many energies: by its word and symmetries it is counted once. */
static void count_isolated(quest *q, const ric_hunt *h, const ric_comparison *c)
{
    for (int i = 0; c && i < ric_hunt_n_found(h); i++) {
        ric_finding finding;
        ric_found found;
        int word[RIC_HUNT_IMPACTS];
        if (ric_comparison_finding(c, i, &finding) || finding.state != RIC_FOUND_ISOLATED) continue;
        ric_hunt_found(h, i, &found, word, NULL, NULL);
        json_t *text = cli_word(ric_study_model(q->study), found.impacts, word);
        json_t *key = json_sprintf("%s %d %d", json_string_value(text), found.symmetric,
                                   found.reversible);
        q->fresh += key && !json_object_get(q->isolated, json_string_value(key));
        if (key) json_object_set_new(q->isolated, json_string_value(key), json_true());
        json_decref(key);
        json_decref(text);
    }
}

static ric_status hunt_at(quest *q, double energy)
{
    ric_hunt *h = NULL;
    ric_comparison *c = NULL;
    int added = 0;
    const ric_model *model = ric_study_model(q->study);
    ric_hunt_options options = q->request->options;
    options.energy = energy;
    options.progress = show_progress;
    options.user = &q->line;
    ric_status status = ric_hunt_create(model, &options, &h);
    if (!status) status = ric_hunt_run(h);
    if (status == RIC_E_INTERRUPTED) add_rows(h, model, energy, q->request->d, NULL, q->rows);
    if (!status && q->atlas) status = ric_hunt_compare(h, q->atlas, &c);
    if (!status && q->request->add)
        status = ric_hunt_add(h, c, q->atlas, q->request->atlas_path, &added);
    cli_progress_end(&q->line);
    if (!status) {
        q->added += added;
        q->n_energy++;
        count_isolated(q, h, c);
        add_rows(h, model, energy, q->request->d, c, q->rows);
        if (summarise(h, &options, q->request->d * q->request->d, c, added)) q->code = CLI_FAILED;
    }
    ric_comparison_free(c);
    ric_hunt_free(h);
    return status;
}

static bool stop_is_asked(const ric_progress *now, void *user)
{
    (void)now;
    (void)user;
    return cli_stopped();
}

/* Follows what the last level has added, so that the next one knows it. */
static ric_status follow_added(quest *q, int before)
{
    if (q->added == before) return RIC_OK;
    ric_atlas *atlas = NULL;
    const ric_run_options run = {.workers = 1, .progress = stop_is_asked};
    ric_status status = ric_explore(q->study, q->request->atlas_path, &run);
    if (!status) status = ric_atlas_read(q->request->atlas_path, &atlas);
    if (!status) {
        ric_atlas_free(q->atlas);
        q->atlas = atlas;
    }
    return status;
}

/* Energies of one level, geometrically between the ends: the ends and the middle first, then the
 * middles between. */
static ric_status hunt_level(quest *q, int level)
{
    const double *window = q->request->energy;
    const int parts = 1 << level, before = q->added;
    ric_status status = RIC_OK;
    q->fresh = 0;
    for (int i = 0; i <= parts && !status; i++)
        if (level == 1 || i % 2)
            status = hunt_at(q, window[0] * pow(window[1] / window[0], (double)i / parts));
    return status ? status : follow_added(q, before);
}

static ric_status hunt_window(quest *q)
{
    const double unit = q->request->d * q->request->d;
    ric_status status = RIC_OK;
    int level = 1;
    for (; level <= LEVELS && !status; level++) {
        status = hunt_level(q, level);
        if (level >= LEVELS_LEAST && q->fresh == 0) break;
    }
    if (!status)
        cli_say(
            "%d energies from %g to %g were looked at; %s; %d kinds of isolated orbits in all\n",
            q->n_energy, unit * q->request->energy[0], unit * q->request->energy[1],
            level <= LEVELS ? "the last ones, between those before, found nothing new"
                            : "the last ones still found something new, and there may be more",
            (int)json_object_size(q->isolated));
    return status;
}

/* Prints what was found, all of it or until it was stopped; the exit code, `code` where it is not
 * 0. */
static int answer(const quest *q, const request *r, int code)
{
    if (r->choice.hertz) cli_in_hertz(q->rows);
    if (!cli_choose(q->rows, &r->choice)) return CLI_WRONG;
    if (code)
        cli_say("%zu orbits were found until then%s\n", json_array_size(q->rows),
                q->atlas ? "; those without a word in `atlas` were not compared" : "");
    int printed = print(q->rows, q->atlas != NULL, r->format);
    return printed ? printed : code ? code : q->code;
}

static int hunt(const request *r, const ric_study *study, ric_atlas **atlas)
{
    quest q = {.request = r,
               .study = study,
               .atlas = *atlas,
               .line = cli_progress_begin(),
               .rows = json_array(),
               .isolated = json_object()};
    cli_catch_signals();
    ric_status status = !q.rows || !q.isolated        ? RIC_E_NOMEM
                        : r->energy[0] < r->energy[1] ? hunt_window(&q)
                                                      : hunt_at(&q, r->energy[0]);
    int code = cli_report(status);
    if (!status || status == RIC_E_INTERRUPTED) code = answer(&q, r, code);
    *atlas = q.atlas;
    json_decref(q.rows);
    json_decref(q.isolated);
    return code;
}

/* The study that is hunted in, and the atlas to compare with: a file that is an atlas is both. */
static ric_status read_files(request *r, const char *path, ric_study **study, ric_atlas **atlas)
{
    ric_status status = ric_study_read(path, study);
    if (status == RIC_E_INPUT && !ric_atlas_read(path, atlas)) {
        if (!r->atlas_path) r->atlas_path = path;
        status = ric_study_parse(ric_study_text(ric_atlas_study(*atlas)), path, ".", study);
        if (strcmp(r->atlas_path, path)) {
            ric_atlas_free(*atlas);
            *atlas = NULL;
        }
    } else if (status == RIC_E_INPUT)
        status = ric_study_read(path, study); /* its own message again */
    if (!status && r->atlas_path && !*atlas) status = ric_atlas_read(r->atlas_path, atlas);
    return status;
}

static int run(int argc, char **argv)
{
    request r = {0};
    bool bounded;
    ric_study *study = NULL;
    ric_atlas *atlas = NULL;
    int code;
    if (!take_request(&argc, argv, &r, &bounded) || !cli_operands(&cli_hunt, argc, argv, 1))
        return CLI_WRONG;
    ric_status status = read_files(&r, argv[1], &study, &atlas);
    r.d = status ? 1 : cli_unit_of_lengths(ric_study_model(study), r.physical);
    for (int i = 0; i < 2; i++) r.energy[i] /= cli_unit_of_energies(r.d);
    r.options.energy = r.energy[0];
    if (status) code = cli_report(status);
    else if (r.add && !atlas)
        code = cli_wrong("hunt: --add needs --atlas FILE, the atlas to add to");
    else if (atlas && !same_model(ric_study_model(study), ric_atlas_model(atlas))) {
        cli_wrong("hunt: %s is the atlas of another model than that of %s", r.atlas_path, argv[1]);
        code = CLI_FAILED;
    } else {
        /* the windows of the atlas, so that the two can be compared */
        double asked = r.options.period[1];
        ric_hunt_options_bound(&r.options, atlas ? ric_atlas_study(atlas) : study);
        if (bounded && !(atlas && asked > r.options.period[1])) r.options.period[1] = asked;
        cli_forcing_warn(study, argv[1], "what is hunted");
        code = cli_sorts_by(&r.choice, atlas ? COLUMNS COMPARED : COLUMNS, LISTS)
                   ? hunt(&r, study, &atlas)
                   : CLI_WRONG;
    }
    ric_atlas_free(atlas);
    ric_study_free(study);
    return code;
}

static const cli_item items[] = {
    {.text =
         "Looks for all periodic orbits of one scaled energy with up to N impacts per period, "
         "without "
         "following any branch: symmetry lines are scanned, rows and random starts are flown from "
         "impact to "
         "impact, and the times of all impacts of a word are guessed at once. For rigid stops that "
         "see two modes. "
         "Every orbit is checked with the simulator. "
         "An empty result is no proof; what a known atlas has is the measure of what is found."},
    {.name = "--energy",
     .value = "E[,E]",
     .text = "scaled energy; or a window, in which energies are looked at, and those between them, "
             "until the last ones "
             "find no other kind of isolated orbit (9 at least, 65 at most); with --add what is "
             "found is followed in "
             "between"},
    {.name = "--impacts", .value = "N", .text = "words of up to N letters, 6 unless given"},
    {.name = "--period",
     .value = "T",
     .text = "periods up to T seconds; unless given 2 pi over the lower end of the study's "
             "frequency window"},
    {.name = "--atlas",
     .value = "FILE",
     .text = "tells which of the orbits this atlas has (known), and why it lacks others: they are "
             "beyond a "
             "departure that it has not taken (budget), or their family meets none of its "
             "junctions (isolated); "
             "exit code 1 if one is unexplained"},
    {.name = "--add",
     .text =
         "puts the isolated ones into the atlas as starts; the next `ricochet run` follows them"},
    {.name = "--lines",
     .value = "N",
     .text = "points on each symmetry line before it is refined, 20000 unless given"},
    {.name = "--rows", .value = "N", .text = "rows on the section of each face, 60 unless given"},
    {.name = "--row", .value = "N", .text = "points on each row, 1000 unless given"},
    {.name = "--random", .value = "N", .text = "random starts on each face, 250000 unless given"},
    {.name = "--starts",
     .value = "N",
     .text = "guesses of all impact times for each letter of each word, in every round, 60 unless "
             "given"},
    {.name = "--seed", .value = "S", .text = "of the random starts and guesses, 1 unless given"},
    {.name = "--physical",
     .text = "energies, those of --energy too, and states in the units of the study, not scaled by "
             "the clearance"},
    CLI_ITEM_SORT,
    CLI_ITEM_HZ,
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    CLI_ITEM_WIDE,
    {0},
};

const cli_command cli_hunt = {
    .name = "hunt",
    .summary = "periodic orbits of one energy by brute force; what an atlas lacks",
    .usage = "ricochet hunt STUDY|ATLAS --energy E[,E] [--impacts N] [--period T] [--atlas FILE "
             "[--add]]\n"
             "           [--lines N] [--rows N] [--row N] [--random N] [--starts N] [--seed S]\n"
             "           [--physical] [--hz] [--sort COLUMN] [--json | --csv | --wide]\n",
    .items = items,
    .example = "ricochet hunt examples/elementary/study.yaml --energy 5 --impacts 4\n"
               "ricochet hunt study.ricochet --energy 0.7,40 --impacts 4 --add\n",
    .run = run,
};
