/* ricochet verify ATLAS: replays stored orbits with the simulator, which knows nothing of how they
 * were found, and computes anew what is stored with them. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/halt.h"
#include "common/cli.h"
#include "common/workers.h"

typedef enum { OF_POINT, OF_BRANCH, OF_JUNCTION } subject;
static const char *const subject_text[] = {"point", "branch", "junction"};

typedef struct {
    subject of;
    bool done;
    ric_check check; /* of a junction: its id is the point */
    ric_claims claims;
} result;

typedef struct {
    const ric_atlas *atlas;
    bool all;
    result *results;
    int n, room, branches;
    cli_workers workers;
} audit;

/* --------------------------------------------------------------- what to do */

static ric_status add(audit *a, subject of, int branch, int point)
{
    if (a->n == a->room) {
        int room = a->room ? 2 * a->room : 1024;
        result *more = realloc(a->results, (size_t)room * sizeof *more);
        if (!more) return RIC_E_NOMEM;
        a->results = more;
        a->room = room;
    }
    a->results[a->n++] = (result){.of = of,
                                  .check = {.branch = branch,
                                            .point = point,
                                            .flight_error = NAN,
                                            .return_error = NAN,
                                            .condition = NAN,
                                            .energy_error = NAN,
                                            .faces_agree = true,
                                            .passed = true}};
    return RIC_OK;
}

/* point: from 0, or -1. */
static ric_status add_branch(audit *a, int id, long point)
{
    ric_branch branch;
    int chosen[RIC_VERIFY_SAMPLE], n_chosen = 0;
    ric_status status = ric_atlas_branch(a->atlas, id, &branch);
    if (status) return status;
    if (point >= 0) {
        ric_point stored;
        status = ric_atlas_point(a->atlas, id, (int)point, &stored, NULL, NULL);
        a->branches = 1;
        return status ? status : add(a, OF_POINT, id, (int)point);
    }
    if (branch.n_point == 0) return RIC_OK;
    a->branches++;
    if ((status = add(a, OF_BRANCH, id, -1))) return status;
    for (int i = 0; a->all && i < branch.n_point && !status; i++) status = add(a, OF_POINT, id, i);
    if (a->all) return status;
    status = ric_verify_sample(a->atlas, id, &n_chosen, chosen);
    for (int i = 0; i < n_chosen && !status; i++) status = add(a, OF_POINT, id, chosen[i]);
    return status;
}

/* ------------------------------------------------------------------ working */

static void work(void *user)
{
    audit *a = user;
    ric_halt_ask(cli_workers_over, &a->workers);
    for (int i; (i = cli_workers_take(&a->workers)) >= 0;) {
        result *r = &a->results[i];
        int branch = r->check.branch, point = r->check.point;
        ric_status status = r->of == OF_BRANCH ? ric_verify_branch(a->atlas, branch, &r->claims)
                            : r->of == OF_JUNCTION
                                ? ric_verify_junction(a->atlas, point, &r->claims)
                                : ric_verify_point(a->atlas, branch, point, &r->check);
        if (!status && r->of == OF_POINT)
            status = ric_verify_claims(a->atlas, branch, point, &r->claims);
        if (ric_halted()) break; /* what was found since is no answer */
        if (status) {
            cli_workers_fail(&a->workers, status);
            break;
        }
        r->done = true;
        cli_workers_finish(&a->workers);
    }
    if (ric_halted()) a->workers.stop = true;
    ric_halt_ask(NULL, NULL);
}

static ric_status work_all(audit *a, int workers)
{
    a->workers.n = a->n;
    a->workers.pieces = "points";
    a->workers.work = work;
    a->workers.user = a;
    return cli_workers_run(&a->workers, workers);
}

/* ------------------------------------------------------------------ answers */

#define COLUMNS                                                                                    \
    "kind branch point junction flight_error return_error condition energy_error faces_agree "     \
    "multiplier_error multiplier_bound multipliers_agree stable_agrees numbers_agree unchecked "   \
    "passed"

static const char *agreement(ric_agreement a)
{
    return a == RIC_AGREES_YES ? "yes" : a == RIC_AGREES_NO ? "no" : "unchecked";
}

static bool passes(const result *r)
{
    return r->check.passed && r->claims.multipliers != RIC_AGREES_NO &&
           r->claims.stable != RIC_AGREES_NO && r->claims.numbers != RIC_AGREES_NO;
}

static void add_row(json_t *rows, const result *r)
{
    const ric_check *check = &r->check;
    const ric_claims *claims = &r->claims;
    json_t *row = json_object();
    json_object_set_new(row, "kind", json_string(subject_text[r->of]));
    json_object_set_new(row, "branch",
                        r->of == OF_JUNCTION ? json_null() : json_integer(check->branch));
    json_object_set_new(row, "point", r->of == OF_POINT ? json_integer(check->point) : json_null());
    json_object_set_new(row, "junction",
                        r->of == OF_JUNCTION ? json_integer(check->point) : json_null());
    json_object_set_new(row, "flight_error", cli_number(check->flight_error));
    json_object_set_new(row, "return_error", cli_number(check->return_error));
    json_object_set_new(row, "condition", cli_number(check->condition));
    json_object_set_new(row, "energy_error", cli_number(check->energy_error));
    json_object_set_new(row, "faces_agree", json_boolean(check->faces_agree));
    json_object_set_new(row, "multiplier_error", cli_number(claims->multiplier_error));
    json_object_set_new(row, "multiplier_bound", cli_number(claims->multiplier_bound));
    json_object_set_new(row, "multipliers_agree", json_string(agreement(claims->multipliers)));
    json_object_set_new(row, "stable_agrees", json_string(agreement(claims->stable)));
    json_object_set_new(row, "numbers_agree", json_string(agreement(claims->numbers)));
    json_object_set_new(row, "unchecked", json_string(claims->unchecked));
    json_object_set_new(row, "passed", json_boolean(passes(r)));
    json_object_set_new(row, "finding", json_string(claims->finding));
    json_array_append_new(rows, row);
}

/* What is wrong with a point, in a sentence; the first few of them. */
static void tell_failure(const audit *a, const result *r)
{
    ric_branch branch;
    ric_junction junction;
    if (r->of == OF_JUNCTION) {
        const char *name = ric_atlas_junction(a->atlas, r->check.point, &junction) ? ""
                                                                                   : junction.label;
        cli_say("ricochet: junction %d %s: %s\n", r->check.point, name, r->claims.finding);
        return;
    }
    const char *label = ric_atlas_branch(a->atlas, r->check.branch, &branch) ? "" : branch.label;
    if (r->of == OF_BRANCH) {
        cli_say("ricochet: branch %d %s: %s\n", r->check.branch, label, r->claims.finding);
        return;
    }
    cli_say("ricochet: branch %d %s, point %d: %s\n", r->check.branch, label, r->check.point,
            !r->check.passed ? "the motion is not what the simulator makes of it"
                             : r->claims.finding);
}

/* The first names of a list, and how many more there are: of many displacements it is long. */
static void shorten(const char *names, size_t size, char *out)
{
    enum { SHOWN = 6 };
    int n = 1, shown = 1;
    size_t length = strlen(names);
    for (const char *c = names; (c = strstr(c, ", ")); c += 2)
        if (n++ == SHOWN) length = (size_t)(c - names);
    shown = n > SHOWN + 2 ? SHOWN : n;
    if (shown == n) snprintf(out, size, "%s", names);
    else snprintf(out, size, "%.*s and %d more", (int)length, names, n - shown);
}

/* What of one row could not be checked, by name. */
static void tell_unchecked(const audit *a, const result *r, FILE *out)
{
    char names[400];
    shorten(r->claims.unchecked, sizeof names, names);
    ric_junction junction;
    if (r->of == OF_JUNCTION && !ric_atlas_junction(a->atlas, r->check.point, &junction))
        cli_tell(out, "junction %d %s: not checked: %s\n", r->check.point, junction.label, names);
    else if (r->of == OF_POINT)
        cli_tell(out, "branch %d, point %d: not checked: %s\n", r->check.branch, r->check.point,
                 names);
}

static const char *rows_of(subject of)
{
    return of == OF_BRANCH ? "branches" : "junctions";
}

/* How much of what was looked at could not be checked, with the reasons. */
static void count_unchecked(const audit *a, FILE *out)
{
    int open = 0, flags = 0, margins = 0, rows[3] = {0};
    for (int i = 0; i < a->n; i++) {
        const result *r = &a->results[i];
        if (!r->done) continue;
        rows[r->of] += r->claims.numbers == RIC_AGREES_UNCHECKED;
        if (r->of != OF_POINT) continue;
        open += r->claims.multipliers == RIC_AGREES_UNCHECKED && !isnan(r->claims.multiplier_bound);
        flags += r->claims.stable == RIC_AGREES_UNCHECKED;
        margins += *r->claims.unchecked != 0;
    }
    if (open)
        cli_tell(out,
                 "multipliers not checked at %d point%s: rounding of the stored digits leaves too "
                 "little of them\n",
                 open, open == 1 ? "" : "s");
    if (flags)
        cli_tell(out, "stability not checked at %d point%s: on the border within rounding\n", flags,
                 flags == 1 ? "" : "s");
    if (margins)
        cli_tell(out,
                 "%d point%s of which some numbers could not be checked to a part in a million: "
                 "rounding of the stored "
                 "digits is multiplied beyond it\n",
                 margins, margins == 1 ? "" : "s");
    for (subject of = OF_BRANCH; of <= OF_JUNCTION; of++)
        if (rows[of])
            cli_tell(out, "%d row%s of %s could not be checked in full\n", rows[of],
                     rows[of] == 1 ? "" : "s", rows_of(of));
}

static int tell_all(const audit *a, FILE *out)
{
    enum { TOLD = 10 };
    int points = 0, failed = 0, unchecked = 0, rows[3] = {0}, wrong[3] = {0};
    for (int i = 0; i < a->n; i++) {
        const result *r = &a->results[i];
        points += r->of == OF_POINT;
        if (!r->done) continue;
        if (!passes(r) && failed++ < TOLD) tell_failure(a, r);
        rows[r->of]++;
        wrong[r->of] += !passes(r);
        if (*r->claims.unchecked && unchecked++ < TOLD) tell_unchecked(a, r, out);
    }
    if (failed > TOLD) cli_say("ricochet: and %d more\n", failed - TOLD);
    cli_tell(out, "%d of %d points on %d branch%s agree with the simulator\n",
             rows[OF_POINT] - wrong[OF_POINT], rows[OF_POINT], a->branches,
             a->branches == 1 ? "" : "es");
    for (subject of = OF_BRANCH; of <= OF_JUNCTION; of++)
        if (wrong[of])
            cli_tell(out, "%d of %d rows of %s do not\n", wrong[of], rows[of], rows_of(of));
    count_unchecked(a, out);
    bool whole = rows[OF_POINT] + rows[OF_BRANCH] + rows[OF_JUNCTION] == a->n;
    if (!whole)
        cli_say("ricochet: stopped %s: %d of %d points were not looked at\n",
                cli_stopped() ? "on request" : "when the time given was over",
                points - rows[OF_POINT], points);
    return failed ? CLI_FAILED : whole ? CLI_DONE : cli_stopped() ? CLI_INTERRUPTED : CLI_LIMIT;
}

/* In words the verdict is the answer; rows, where they are asked for, are, and the verdict is a
 * remark on them. */
static int print_audit(const audit *a, cli_format format, const cli_choice *choice, bool verbose,
                       bool quiet)
{
    json_t *rows = json_array();
    if (!rows) return cli_report(RIC_E_NOMEM);
    for (int i = 0; i < a->n; i++)
        if (a->results[i].done) add_row(rows, &a->results[i]);
    const bool listed = format != CLI_TEXT || verbose;
    const int code = !cli_choose(rows, choice) ? CLI_WRONG
                     : listed                  ? cli_print_rows(rows, COLUMNS, format)
                                               : CLI_DONE;
    json_decref(rows);
    FILE *none = quiet ? fopen("/dev/null", "w") : NULL;
    const int verdict = code ? code
                             : tell_all(a, none                 ? none
                                           : format == CLI_TEXT ? stdout
                                                                : stderr);
    if (none) fclose(none);
    return verdict;
}

static int run(int argc, char **argv)
{
    cli_format format;
    const char *text, *point_text;
    long branch = 0, point = -1, workers = 0;
    ric_atlas *atlas = NULL;
    audit a = {.workers = {.seconds = HUGE_VAL, .mutex = PTHREAD_MUTEX_INITIALIZER}};
    a.all = cli_take_flag(&argc, argv, "--all");
    const bool verbose = cli_take_flag(&argc, argv, "--verbose"),
               quiet = cli_take_flag(&argc, argv, "--quiet");
    cli_choice choice;
    if (!cli_take_format(&argc, argv, &format) || !cli_take_sort(&argc, argv, &choice) ||
        !cli_take_value(&argc, argv, "--branch", &text) ||
        !cli_take_value(&argc, argv, "--point", &point_text) ||
        !cli_take_seconds(&argc, argv, "verify", &a.workers.seconds) ||
        !cli_take_workers(&argc, argv, CLI_WORKERS_MOST, &workers) ||
        !cli_operands(&cli_verify, argc, argv, 1) ||
        (text && !cli_parse_integer(text, "--branch", 1, INT_MAX, &branch)) ||
        (point_text && !cli_parse_integer(point_text, "--point", 0, INT_MAX, &point)))
        return CLI_WRONG;
    if (!cli_sorts_by(&choice, COLUMNS " finding", "")) return CLI_WRONG;
    if (point_text && !text)
        return cli_wrong("verify: --point needs --branch ID, whose points it counts");
    if (ric_response_is(argv[1])) return cli_verify_response(argv[1], a.all, quiet, format);
    ric_status status = ric_atlas_read(argv[1], &atlas);
    a.atlas = atlas;
    if (!status && branch) status = add_branch(&a, (int)branch, point);
    for (int id = 1; !status && !branch && id <= ric_atlas_n_branch(atlas); id++)
        status = add_branch(&a, id, -1);
    for (int id = 1; !status && !branch && id <= ric_atlas_n_junction(atlas); id++)
        status = add(&a, OF_JUNCTION, -1, id);
    if (!status && (status = work_all(&a, workers ? (int)workers : 1)) && *a.workers.detail) {
        cli_say("ricochet: %s\n", a.workers.detail);
        free(a.results);
        ric_atlas_free(atlas);
        return CLI_FAILED;
    }
    int code = status ? cli_report(status) : print_audit(&a, format, &choice, verbose, quiet);
    if (!workers && !quiet && !status) cli_tell_idle("verify", cli_seconds_since(&a.workers.start));
    free(a.results);
    ric_atlas_free(atlas);
    return code;
}

static const cli_item items[] = {
    {.text = "Replays the first, the middle and the last point of every branch and five more with "
             "a simulator that "
             "knows only the masses, the stiffnesses, the stops and the stored state, and finds "
             "every impact "
             "itself. What is stored with the orbit is computed anew. Rows of branches and "
             "junctions are compared "
             "with their points and orbits: one row for each, kind branch or junction. Given a "
             "file of `ricochet "
             "response`, replays orbits of its curves under damping and force, and their largest "
             "multiplier from "
             "differences."},
    {.name = "flight_error",
     .text = "largest relative error of the time and the end of a flight; at most 1e-11"},
    {.name = "return_error",
     .text = "relative distance from the start after one period; at most 1e-9 max(1, 1e-7 "
             "condition); none at a "
             "corner"},
    {.name = "condition",
     .text = "largest modulus of a multiplier: what one period makes of a small error; more where "
             "slow impacts "
             "amplify the simulator's own rounding on the way beyond that"},
    {.name = "energy_error", .text = "relative error of the energy; at most 1e-11"},
    {.name = "faces_agree",
     .text = "whether the faces of the word are met in their order, and no other"},
    {.name = "multiplier_error, multiplier_bound",
     .text = "of the trace, over sqrt(trace^2 + 4), and what rounding leaves of it, measured; for "
             "more modes of "
             "the multipliers that `points` and `orbit` give"},
    {.name = "multipliers_agree, stable_agrees, numbers_agree",
     .text = "yes, no or unchecked: trace and rotation; the flag; the state, energy, frequency, "
             "reach and "
             "approach"},
    {.name = "unchecked",
     .text = "numbers that could be off by a part in a million, of the largest of their kind, "
             "without being found: "
             "x1, v2, reach, approach"},
    {.name = "--branch", .value = "ID", .text = "only this branch"},
    CLI_ITEM_AT,
    {.name = "--point", .value = "I", .text = "with --branch: only this point, from 0"},
    {.name = "--all", .text = "every stored point"},
    {.name = "-j",
     .value = "WORKERS",
     .text = "how many at a time, 1 unless given; 0: one for each core"},
    {.name = "--jobs", .value = "WORKERS", .text = "the same"},
    {.name = "--seconds", .value = "S", .text = "stop after that time and show what was done"},
    {.name = "--verbose",
     .text = "a row for every point as well; without it the verdict, and what does not pass"},
    {.name = "--quiet", .text = "only what does not pass, and the exit code"},
    {.text =
         "The exit code is 1 if a point does not pass, 3 if the time was over, 130 after Ctrl-C."},
    CLI_ITEM_SORT,
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_verify = {
    .name = "verify",
    .summary = "replay the orbits of an atlas with an independent simulator",
    .usage =
        "ricochet verify ATLAS [(--branch ID | --at E,OMEGA) [--point I]] [--all]\n"
        "                       [-j WORKERS | --jobs WORKERS] [--seconds S] [--verbose | --quiet]\n"
        "                       [--sort COLUMN] [--json | --csv]\n",
    .items = items,
    .example = "ricochet verify study.ricochet --branch 3 --all\n",
    .run = run,
};
