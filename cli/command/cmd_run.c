/* ricochet run STUDY: explores a study into an atlas. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "atlas/atlas.h"
#include "explore/remote.h"
#include "study/region.h"
#include "study/study.h"
#include "report.h"
#include "common/shaking.h"

#define MANY_MODES 200
/* SHARE: a run lasts at least so many times as long as it takes to come to something new: one that
 * was stopped again and again on the way there would never end */
#define SHARE 1.25
/* FIRST_LINE: seconds until a run that nobody watches on a terminal says how far it is, into its
 * log */
#define FIRST_LINE 3.0
/* LATER_LINE: and at most between such lines: each comes when as much time has passed again */
#define LATER_LINE 60.0

const ric_remote *cli_run_remote = NULL;

/* ---------------------------------------------------------------- progress */

typedef struct {
    cli_progress line;
    bool over;      /* the time given has passed */
    double seconds; /* given for the run; HUGE_VAL: any */
    double news; /* seconds until the run came to something that an earlier one had not done; 0: not
                    yet */
    struct timespec start;
    double logged; /* seconds at the last line of a log */
    int most;      /* departures of the round at work; `open` of them are left */
    int depth;     /* that the study allows, 0: any */
    ric_progress last;
    const ric_atlas *before; /* what was in the file; NULL: nothing */
    bool quiet, json;        /* nothing in words; the report in JSON */
    long workers;            /* 0: not given, so one */
    const char *step;        /* --max-step, or NULL */
    bool prove;
    bool same, kept; /* it is of the same study; its tables were left as they are */
} display;

/* How far the run is. Departures make new ones, so that their share is that of the round at work:
 * those that were open when it began, all of one depth. */
static void say_progress(const display *d, double passed)
{
    const ric_progress *now = &d->last;
    cli_say("%d branch%s, %d junction%s, ", now->branches, now->branches == 1 ? "" : "es",
            now->junctions, cli_plural(now->junctions));
    if (now->labels) cli_say("%d label%s left, ", now->labels, cli_plural(now->labels));
    else {
        cli_say("depth %d", now->depth);
        if (d->depth) cli_say(" of %d", d->depth);
        if (d->most > 0)
            cli_say(": %d of %d departures (%.0f %%)", d->most - now->open, d->most,
                    100.0 * (d->most - now->open) / d->most);
        cli_say(", %.0f steps/s, ", passed > 0 ? now->fresh / passed : 0);
    }
    cli_say("%ld at a time, %.0f s", d->workers ? d->workers : 1, now->seconds);
    fflush(stderr);
}

static bool show_progress(const ric_progress *now, void *user)
{
    display *d = user;
    const double passed = cli_seconds_since(&d->start);
    if (now->depth != d->last.depth || now->open > d->last.open) d->most = now->open;
    d->last = *now;
    if (cli_progress_due(&d->line)) say_progress(d, passed);
    else if (!d->line.terminal && !d->quiet &&
             passed > d->logged + fmin(fmax(d->logged, FIRST_LINE), LATER_LINE)) {
        fputs("ricochet: ", stderr);
        say_progress(d, passed);
        fputc('\n', stderr);
        d->logged = passed;
    }
    if (now->fresh && d->news == 0) d->news = passed;
    d->over = now->fresh && passed > fmax(d->seconds, SHARE * d->news);
    return d->over || cli_stopped();
}

/* An unfinished atlas takes the place of what was in the file, unless it is of the same study and
 * has not come as far yet. */
static bool worth(void *user, const ric_atlas *unfinished)
{
    display *d = user;
    d->kept = d->before && d->same && !ric_atlas_contains(unfinished, d->before);
    return !d->kept;
}

/* ----------------------------------------------------------------- summary */

/* Rows that name one branch or junction. There may be hundreds of these: `ricochet report` lists
 * them, here they are counted. */
typedef struct {
    size_t missing, known_less, open; /* the last are counted by another row */
} counted;

static bool is_counted(const char *item, counted *n)
{
    const struct {
        const char *item;
        size_t *count;
    } items[] = {{"events may be missing on branch", &n->missing},
                 {"rest missing of branch", &n->missing},
                 {"ends disagree of branch", &n->missing},
                 {"branches may be missing at junction", &n->missing},
                 {CLI_REPORT_TURNS, &n->missing},
                 {CLI_REPORT_RANGES, &n->known_less},
                 {CLI_REPORT_BESIDE, &n->known_less},
                 {CLI_REPORT_OPEN, &n->open}};
    for (size_t i = 0; item && i < sizeof items / sizeof *items; i++)
        if (!strcmp(item, items[i].item)) return ++*items[i].count;
    return false;
}

static void tell_counted(const counted *n)
{
    if (n->missing)
        cli_tell(stdout,
                 "something may be missing on branches and at junctions: %zu (`ricochet report` "
                 "names them)\n",
                 n->missing);
    if (n->known_less)
        cli_tell(stdout,
                 "places on branches that are known to less than 1e-9 of the energy: %zu "
                 "(`ricochet report` says to what)\n",
                 n->known_less);
}

enum { TONGUES = 5 }; /* branches whose internal resonances are told here */

/* Rows of one item in one line: "departures not tried: 4 (beyond `depth`), 2 (more than
 * `impacts`)". What there is none of is left out, and rows of single branches and junctions are
 * counted. */
static void print_report(const json_t *rows, const ric_explore_options *options)
{
    const char *last = "";
    size_t i, tongues = 0;
    counted single = {0};
    bool climbs = false, /* some branch leaves its backbone along a tongue */
        first = false,   /* a first look has ended by its points, */
        deeper = false;  /* or by its depth */
    json_t *row;
    json_array_foreach(rows, i, row)
    {
        const char *item = json_string_value(json_object_get(row, "item")),
                   *detail = json_string_value(json_object_get(row, "detail"));
        if (is_counted(item, &single)) continue;
        climbs = climbs ||
                 (item && detail && !strcmp(item, CLI_RESONANCE) && strstr(detail, " follows "));
        if (item && !strcmp(item, CLI_RESONANCE) && ++tongues > TONGUES) continue;
        const json_t *value = json_object_get(row, "value");
        first = first ||
                (item && detail && json_integer_value(value) && strstr(detail, "`points`"));
        deeper = deeper || (options->points && item && detail && json_integer_value(value) &&
                            !strcmp(detail, "beyond `depth`"));
        if (!item || !detail || json_is_null(value) ||
            (json_is_integer(value) && json_integer_value(value) == 0))
            continue;
        cli_tell(stdout, strcmp(item, last) ? "%s%s: " : ", ", *last ? "\n" : "", item);
        last = item;
        if (json_is_string(value)) cli_tell(stdout, "%s", json_string_value(value));
        else if (json_is_integer(value))
            cli_tell(stdout, "%lld", (long long)json_integer_value(value));
        else cli_tell(stdout, "%.1e", json_real_value(value));
        if (*detail) cli_tell(stdout, " (%s)", detail);
    }
    putchar('\n');
    if (tongues > TONGUES)
        cli_tell(
            stdout,
            "internal resonances on %zu more branches (`ricochet branches --tongues` names them)\n",
            tongues - TONGUES);
    if (climbs && !options->cross_tongues)
        cli_tell(stdout,
                 "where a branch follows a resonance it leaves its backbone: `explore: {tongues: "
                 "cross}` goes on "
                 "behind, and with `depth: 1` and few `impacts` shows the backbones alone\n");
    if (first)
        cli_tell(stdout,
                 "a first look: from %d points on nothing more was departed to; `points: 0` under "
                 "`explore` goes on with "
                 "what is left, and `--seconds S` with that ends it\n",
                 options->points);
    else if (deeper)
        cli_tell(
            stdout,
            "a first look: what lies beyond `depth` is tried with `depth: %d` under `explore`, "
            "and the same command then extends the atlas\n",
            options->depth + 1);
    tell_counted(&single);
}

/* What `ricochet report` says of the file, from what was written there. An atlas that is not
 * finished is no reason to say why it lacks something. */
static int print_summary(const char *path, const ric_atlas *atlas, const display *d, bool stopped)
{
    if (d->quiet && !d->json) return CLI_DONE;
    json_t *rows = json_array();
    ric_status status = rows ? RIC_OK : RIC_E_NOMEM;
    if (!status && d->json) {
        status = cli_report_rows(atlas, rows);
        if (!status && cli_print_rows(rows, NULL, CLI_JSON)) {
            json_decref(rows);
            return CLI_FAILED;
        }
    } else if (!status) {
        const int branches = ric_atlas_n_branch(atlas), junctions = ric_atlas_n_junction(atlas);
        cli_tell(stdout, "%s: %d branch%s, %d junction%s, %.1f s\n", path, branches,
                 branches == 1 ? "" : "es", junctions, cli_plural(junctions),
                 cli_seconds_since(&d->start));
        if (!(status = cli_report_rows(atlas, rows)) && cli_lost_memory()) status = RIC_E_NOMEM;
        if (!status) print_report(rows, ric_study_options(ric_atlas_study(atlas)));
        if (!status && !stopped) status = cli_windows_tell(atlas);
    }
    json_decref(rows);
    return status ? cli_report(status) : CLI_DONE;
}

/* ----------------------------------------------------------------- command */

/* study.yaml -> study.ricochet; the caller frees it. */
static char *default_path(const char *study)
{
    static const char *const endings[] = {".yaml", ".yml"};
    size_t length = strlen(study);
    char *path = malloc(length + sizeof ".ricochet");
    if (!path) return NULL;
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        size_t ending = strlen(endings[i]);
        if (length > ending && !strcmp(study + length - ending, endings[i]) &&
            study[length - ending - 1] != '/') {
            length -= ending;
            break;
        }
    }
    snprintf(path, length + sizeof ".ricochet", "%.*s.ricochet", (int)length, study);
    return path;
}

/* ------------------------------------------------------------------- budgets */

/* What a study asks for less of than the atlas already has: "depth, impacts, regions". */
static void list_smaller(const ric_explore_options *old, const ric_explore_options *now,
                         size_t size, char *out)
{
    bool kept = true;
    for (int i = 0; i < old->n_region && kept; i++) {
        kept = false;
        for (int k = 0; k < now->n_region && !kept; k++)
            kept = ric_region_covers(&now->region[k], &old->region[i]);
    }
    const struct {
        const char *name;
        bool smaller;
    } all[] = {
        {"energy", now->energy[0] > old->energy[0] || now->energy[1] < old->energy[1]},
        {"frequency",
         now->frequency[0] > old->frequency[0] || now->frequency[1] < old->frequency[1]},
        {"impacts", now->impacts < old->impacts},
        {"multiply", now->multiply < old->multiply},
        {"depth", now->depth && (!old->depth || now->depth < old->depth)},
        {"points", now->points && (!old->points || now->points < old->points)},
        {"regions", !kept},
    };
    out[0] = '\0';
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (all[i].smaller)
            snprintf(out + strlen(out), size - strlen(out), "%s%s", *out ? ", " : "", all[i].name);
}

/* The regions of a study as they stand in its text, to be copied into another. */
static void print_regions(const ric_study *study)
{
    const char *text = strstr(ric_study_text(study), "\nregions:\n"),
               *line = text ? text + 1 : NULL;
    for (bool first = true; line && *line && (first || *line == ' '); first = false) {
        const int n = (int)strcspn(line, "\n");
        cli_say("%.*s\n", n, line);
        line += n + (line[n] == '\n');
    }
}

/* An atlas that was extended, by `ricochet view` or by a larger study, is made smaller by this one:
 * that is said. */
static void tell_smaller(const char *path, const ric_study *old, const ric_study *now)
{
    char what[100];
    list_smaller(ric_study_options(old), ric_study_options(now), sizeof what, what);
    if (*what)
        cli_say("ricochet: %s was made with larger budgets than this study has (%s); what was "
                "found with them is not "
                "listed any more, the work is kept\n",
                path, what);
    if (strstr(what, "regions")) {
        fputs("ricochet: with these lines in the study it comes back:\n", stderr);
        print_regions(old);
    }
}

/* A word that a shell reads as it is. */
static void say_word(const char *text)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "_./+:,@%=-";
    if (*text && text[strspn(text, plain)] == '\0') {
        cli_say(" %s", text);
        return;
    }
    fputs(" '", stderr);
    for (const char *c = text; *c; c++)
        if (*c == '\'') fputs("'\\''", stderr);
        else if ((unsigned char)*c >= ' ') fputc(*c, stderr);
    fputc('\'', stderr);
}

/* What goes on with it: a run with another step makes another atlas. */
static void say_command(const char *path, const char *study, const display *d)
{
    fputs("\nricochet: the same command continues there: ricochet run", stderr);
    say_word(study);
    fputs(" -o", stderr);
    say_word(path);
    if (d->workers) cli_say(" -j %ld", d->workers);
    if (d->step) cli_say(" --max-step %s", d->step);
    if (d->prove) fputs(" --prove", stderr);
    fputc('\n', stderr);
}

/* The report of what was found so far, what is left, and how to go on. */
static int tell_stopped(const char *path, const char *study, const ric_atlas *atlas,
                        const display *d)
{
    const int branches = ric_atlas_n_branch(atlas), junctions = ric_atlas_n_junction(atlas),
              unmeasured = cli_unmeasured(atlas);
    const int report = d->kept ? CLI_DONE : print_summary(path, atlas, d, true);
    if (report) return report;
    fflush(stdout);
    if (d->over) cli_say("ricochet: the %g s given are over\n", d->seconds);
    if (d->kept)
        cli_say(
            "ricochet: stopped before it came as far as an earlier run, whose tables stay in %s;",
            path);
    else
        cli_say("ricochet: stopped; what was found so far is in %s: %d branch%s, %d junction%s;",
                path, branches, branches == 1 ? "" : "es", junctions, cli_plural(junctions));
    if (d->last.open > 0)
        cli_say(" %d departure%s of depth %d %s left, and what follows from %s", d->last.open,
                cli_plural(d->last.open), d->last.depth, d->last.open == 1 ? "is" : "are",
                d->last.open == 1 ? "it" : "them");
    else if (d->last.branches == 0) fputs(" it was looking for where branches start", stderr);
    else fputs(" all departures are done", stderr);
    if (unmeasured)
        cli_say(", %d label%s not measured yet", unmeasured, unmeasured == 1 ? " is" : "s are");
    /* a branch under way is in no table, and may be all that the time went into */
    if (d->last.fresh > 0)
        cli_say("; %d step%s of this run %s kept, those of unfinished branches too", d->last.fresh,
                cli_plural(d->last.fresh), d->last.fresh == 1 ? "is" : "are");
    say_command(path, study, d);
    return d->over ? CLI_LIMIT : CLI_INTERRUPTED;
}

/* Contacts that close together, or might. */
static void say_together(const ric_model *model)
{
    char text[CLI_TOGETHER];
    if (*cli_together_remark(model)) cli_say("ricochet: %s\n", cli_together_remark(model));
    for (int last = 0; cli_together_next(model, &last, text);) cli_say("ricochet: %s\n", text);
}

static int explore(const ric_study *study, const char *name, const char *path, display d)
{
    if (!d.quiet) d.line = cli_progress_begin();
    d.depth = ric_study_options(study)->depth;
    clock_gettime(CLOCK_MONOTONIC, &d.start);
    const ric_run_options options = {.workers = d.workers ? (int)d.workers : 1,
                                     .progress = show_progress,
                                     .user = &d};
    const ric_explore_more more = {.crew = cli_run_remote, .worth = worth, .user = &d};
    ric_atlas *before = NULL, *atlas = NULL;
    if (!access(path, F_OK) && ric_atlas_read(path, &before))
        before = NULL; /* the run itself says what is wrong with it */
    d.before = before;
    d.same = before && !strcmp(ric_study_text(ric_atlas_study(before)), ric_study_text(study));
    if (*ric_study_remark(study)) cli_say("ricochet: %s: %s\n", name, ric_study_remark(study));
    if (!d.quiet) cli_forcing_warn(study, name, "the atlas");
    cli_windows_warn(study);
    if (!d.quiet) say_together(ric_study_model(study));
    cli_catch_signals();
    ric_status status = ric_explore_with(study, path, &options, &more, &atlas);
    cli_progress_end(&d.line);
    if (before && !d.kept && (!status || status == RIC_E_INTERRUPTED))
        tell_smaller(path, ric_atlas_study(before), study);
    ric_atlas_free(before);
    const int code = status == RIC_E_INTERRUPTED ? tell_stopped(path, name, atlas, &d)
                     : status                    ? cli_report(status)
                                                 : print_summary(path, atlas, &d, false);
    ric_atlas_free(atlas);
    if (!d.workers && !d.quiet && !cli_run_remote)
        cli_tell_idle("run", cli_seconds_since(&d.start));
    return code;
}

/* The work for one orbit grows with the cube of the modes that take part. Where a single branch may
 * take minutes, nobody shall wait unawares. */
static bool too_large(const ric_study *study, double seconds)
{
    return ric_model_n_mode(ric_study_model(study)) > MANY_MODES && seconds == HUGE_VAL;
}

/* Of a few hundred coordinates the modes take seconds, before there is anything else to show. */
static ric_status read_study(const char *path, bool quiet, ric_study **out)
{
    const bool shown = !quiet && isatty(STDERR_FILENO);
    if (shown) cli_say("%s: read, and its modes solved for ...", path);
    const ric_status status = ric_study_read(path, out);
    if (shown) fputs("\r\033[K", stderr);
    return status;
}

static int run(int argc, char **argv)
{
    const char *given;
    char *path = NULL;
    display d = {.seconds = HUGE_VAL,
                 .quiet = cli_take_flag(&argc, argv, "--quiet"),
                 .json = cli_take_flag(&argc, argv, "--json")};
    d.prove = cli_take_flag(&argc, argv, "--prove");
    ric_study *study = NULL;
    int code;
    if (!cli_take_value(&argc, argv, "-o", &given) ||
        !cli_take_workers(&argc, argv, 1024, &d.workers) ||
        !cli_take_value(&argc, argv, "--max-step", &d.step) ||
        !cli_take_seconds(&argc, argv, "run", &d.seconds) || !cli_operands(&cli_run, argc, argv, 1))
        return CLI_WRONG;
    ric_status status = read_study(argv[1], d.quiet, &study);
    if (!status && d.step)
        status = ric_study_override(study, "explore", "step", d.step, "--max-step");
    if (!status && !(path = given ? strdup(given) : default_path(argv[1]))) status = RIC_E_NOMEM;
    if (status) code = cli_report(status);
    else if (!strcmp(path, argv[1]))
        code = cli_wrong("run: the atlas %s would overwrite the study; choose another name with -o",
                         path);
    else if (ric_model_restitution(ric_study_model(study)) < 1 && ric_explore_check(study))
        code = cli_wrong("%s:%zu: %s", argv[1], ric_study_restitution_line(study), ric_detail());
    else if (too_large(study, d.seconds))
        code = cli_wrong(
            "%s: %d modes take part in the motion, and a branch of such orbits may take minutes or "
            "hours; "
            "give --seconds S to try for so long, or reduce the structure to the modes that matter",
            argv[1], ric_model_n_mode(ric_study_model(study)));
    else code = explore(study, argv[1], path, d);
    if (d.prove && code == CLI_DONE)
        code = cli_prove_atlas(path, d.workers ? (int)d.workers : 1,
                               d.quiet  ? NULL
                               : d.json ? stderr
                                        : stdout);
    free(path);
    ric_study_free(study);
    return code;
}

static const cli_item items[] = {
    {.text = "Explores from the linear modes within the budgets of the study and writes the atlas, "
             "one file. "
             "Stopped with Ctrl-C, or killed, the same command continues; with larger budgets in "
             "the study it "
             "extends the atlas. The result does not depend on WORKERS."},
    {.name = "-o",
     .value = "ATLAS",
     .text = "the file to write; study.ricochet for study.yaml unless given"},
    {.name = "-j",
     .value = "WORKERS",
     .text = "how many at a time, 1 unless given; 0: one for each core"},
    {.name = "--jobs", .value = "WORKERS", .text = "the same"},
    {.name = "--max-step",
     .value = "H",
     .text = "largest arclength step, instead of the study's explore.step"},
    {.name = "--seconds",
     .value = "S",
     .text = "stop after that time, with exit code 3 if there is more to do; the same command goes "
             "on from there. "
             "Needed where more than 200 modes take part"},
    {.name = "--prove",
     .text =
         "when it is finished, prove its orbits, curves and junctions as `ricochet prove` does"},
    {.name = "--quiet", .text = "no report and no progress; warnings and what stops it are said"},
    {.name = "--json", .text = "the report as `ricochet report --json` gives it"},
    {0},
};

const cli_command cli_run = {
    .name = "run",
    .summary = "explore a study into an atlas",
    .usage = "ricochet run STUDY [-o ATLAS] [-j WORKERS | --jobs WORKERS]\n"
             "             [--max-step H] [--seconds S] [--prove]\n"
             "             [--quiet] [--json]\n",
    .items = items,
    .example = "ricochet run examples/elementary/study.yaml -o two-masses.ricochet\n",
    .run = run,
};
