/* The module prove: stored orbits as theorems, by ball arithmetic. */
#define _POSIX_C_SOURCE 200809L

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/halt.h"
#include "common/module.h"
#include "study/study.h"
#include "prove.h"

enum { MOST_TOLD = 20 };

/* ------------------------------------------------------------------ working */

static void keep_model(prove_list *w, const ric_prover *prover)
{
    pthread_mutex_lock(&w->workers.mutex);
    if (!w->model) w->model = strdup(ric_prover_model(prover));
    pthread_mutex_unlock(&w->workers.mutex);
}

static ric_status prove_one(prove_list *w, ric_prover *prover, prove_result *r)
{
    ric_status status = w->curves ? prove_curve_on(w, prover, r)
                        : w->junctions
                            ? ric_prover_junction(prover, r->junction.junction, &r->junction)
                            : ric_prover_point(prover, r->proof.branch, r->proof.point, &r->proof);
    if (status || ric_halted()) return status; /* what was stopped in its midst says nothing */
    const char *text = ric_prover_certificate(prover);
    if (*text && !(r->certificate = strdup(text))) return RIC_E_NOMEM;
    pthread_mutex_lock(&w->workers.mutex);
    r->done = true;
    if (w->curves) prove_curves_count(w, r);
    prove_keep_some(w);
    pthread_mutex_unlock(&w->workers.mutex);
    cli_workers_finish(&w->workers);
    return RIC_OK;
}

static void work(void *user)
{
    prove_list *w = user;
    ric_prover *prover = NULL;
    ric_status status = ric_prover_create(w->atlas, &prover);
    if (!status) keep_model(w, prover);
    ric_halt_ask(cli_workers_over, &w->workers);
    for (int i; !status && (i = cli_workers_take(&w->workers)) >= 0;)
        if (!w->results[i].done) status = prove_one(w, prover, &w->results[i]);
    ric_halt_ask(NULL, NULL);
    if (status) cli_workers_fail(&w->workers, status);
    ric_prover_free(prover);
}

/* ---------------------------------------------------------------- the points */

static ric_status add_points(prove_list *w, int id, long point)
{
    ric_branch branch;
    ric_status status = ric_atlas_branch(w->atlas, id, &branch);
    if (status) return status;
    int first = point >= 0 ? (int)point : 0, last = point >= 0 ? (int)point : branch.n_point - 1;
    if (point >= branch.n_point)
        return ric_atlas_point(w->atlas, id, (int)point, &(ric_point){0}, NULL, NULL);
    prove_result *more = realloc(w->results, (size_t)(w->n + last - first + 1) * sizeof *more);
    if (!more && last >= first) return RIC_E_NOMEM;
    w->results = more;
    for (int i = first; i <= last; i++) {
        prove_result *r = &w->results[w->n++];
        const char *certificate = NULL;
        *r = (prove_result){.proof = {.branch = id, .point = i}};
        if (!ric_prover_available() || !ric_proof_kept(w->atlas, id, i, &r->proof, &certificate) ||
            prove_again(r->proof.state, r->proof.prover))
            continue;
        r->done = r->kept = true;
        w->workers.finished++;
        if (!(r->certificate = strdup(certificate))) return RIC_E_NOMEM;
    }
    return RIC_OK;
}

/* ------------------------------------------------------------------ answers */

static const char *const state_text[] = {"proved", "not proved", "left out"};

static void add_row(json_t *rows, const ric_proof *p)
{
    const bool proved = p->state == RIC_PROOF_DONE;
    json_t *row = json_object();
    json_object_set_new(row, "branch", json_integer(p->branch));
    json_object_set_new(row, "point", json_integer(p->point));
    json_object_set_new(row, "verdict", json_string(state_text[p->state]));
    json_object_set_new(row, "bits", proved ? json_integer(p->bits) : json_null());
    json_object_set_new(row, "distance", cli_number(proved ? p->distance : NAN));
    json_object_set_new(row, "exists", cli_number(proved ? p->exists : NAN));
    json_object_set_new(row, "unique", cli_number(proved ? p->unique : NAN));
    json_object_set_new(row, "approach", cli_number(proved ? p->approach : NAN));
    json_object_set_new(row, "stable",
                        proved ? json_string(cli_stability(p->stable)) : json_null());
    json_object_set_new(row, "symmetric", proved ? json_boolean(p->symmetric) : json_null());
    json_object_set_new(row, "reversible", proved ? json_boolean(p->reversible) : json_null());
    json_object_set_new(row, "why", json_string(p->why));
    if (proved) {
        json_object_set_new(row, "energy", cli_numbers(2, p->energy, 1));
        json_object_set_new(row, "period", cli_numbers(2, p->period, 1));
        json_object_set_new(row, "trace", cli_numbers(2, p->trace, 1));
    }
    json_array_append_new(rows, row);
}

/* Orbits at the ends of branches are junctions, where the equations of the branch are not those
 * that prove. */
static bool is_end(const prove_list *w, const ric_proof *p)
{
    ric_branch branch;
    return !ric_atlas_branch(w->atlas, p->branch, &branch) &&
           (p->point == 0 || p->point == branch.n_point - 1);
}

/* The first point that is not proved for a reason, and how many there are. */
typedef struct {
    const ric_proof *first;
    int n;
} failure;

static void tell_failure(const prove_list *w, const failure *f)
{
    const ric_proof *p = f->first;
    ric_branch branch;
    const char *label = ric_atlas_branch(w->atlas, p->branch, &branch) ? "" : branch.label;
    char more[40] = "is";
    if (f->n > 1) snprintf(more, sizeof more, "and %d more are", f->n - 1);
    cli_say("ricochet: branch %d %s, point %d %s not proved: %s\n", p->branch, label, p->point,
            more, p->why);
}

/* Points that are no ends of branches, or all of them, by their reasons. */
static void tell_failures(const prove_list *w, bool ends)
{
    failure told[MOST_TOLD];
    int n = 0, rest = 0;
    for (int i = 0; i < w->n; i++) {
        const ric_proof *p = &w->results[i].proof;
        if (!w->results[i].done || p->state != RIC_PROOF_NONE || (!ends && is_end(w, p))) continue;
        int k = 0;
        while (k < n && strcmp(told[k].first->why, p->why) != 0) k++;
        if (k < n) told[k].n++;
        else if (n < MOST_TOLD) told[n++] = (failure){p, 1};
        else rest++;
    }
    for (int k = 0; k < n; k++) tell_failure(w, &told[k]);
    if (rest) cli_say("ricochet: and %d more, each for a reason of its own\n", rest);
}

/* A structure with some of its modes has contacts that push only those, by normals that are
 * rounded: in the numbers as they stand there other modes are seen, too. */
void prove_tell_kept(const prove_list *w)
{
    const ric_study *study = ric_atlas_study(w->atlas);
    const int n = ric_study_n_mode(study), all = ric_model_n_dof(ric_study_model(study));
    if (n < all)
        cli_say("ricochet: the study keeps %d of %d modes, and what is proved has to hold for its "
                "numbers to the last digit, by which contacts see a little of the others: an atlas "
                "with `modes: all` under `model` is another structure, and can be proved\n",
                n, all);
}

bool prove_tells(const prove_list *w, prove_why *why, int i, size_t size, char *is)
{
    enum { EACH = 3 }; /* entries of one reason that are told one by one */
    const char *own = why(&w->results[i]);
    int n = 0, before = 0;
    for (int k = 0; k < w->n; k++) {
        const char *other = why(&w->results[k]);
        if (!other || strcmp(other, own) != 0) continue;
        n++;
        before += k < i;
    }
    snprintf(is, size, "is");
    if (n <= EACH) return true;
    snprintf(is, size, "and %d more are", n - 1);
    return before == 0;
}

/* The counts of each verdict; of those that are not proved `ends` are ends of branches. */
static void tell_counts(const prove_list *w, FILE *out, const int count[3], int ends, int undecided)
{
    int junctions = 0;
    for (int i = 0; i < w->n; i++)
        junctions += w->results[i].done && w->results[i].proof.state == RIC_PROOF_DONE &&
                     *w->results[i].proof.why;
    const int tried = count[RIC_PROOF_DONE] + count[RIC_PROOF_NONE];
    if (tried == 0 && count[RIC_PROOF_LEFT_OUT])
        cli_tell(out, "nothing here is of a kind that can be proved\n");
    else
        cli_tell(out, "%d of %d points proved, of %d the stability is undecided\n",
                 count[RIC_PROOF_DONE], tried, undecided);
    if (junctions) cli_tell(out, "%d of them as the junctions that they are\n", junctions);
    if (ends) cli_tell(out, "%d of those that are not are ends of branches\n", ends);
    if (count[RIC_PROOF_LEFT_OUT]) cli_tell(out, "%d points left out\n", count[RIC_PROOF_LEFT_OUT]);
    for (int i = 0; i < w->n && count[RIC_PROOF_LEFT_OUT]; i++)
        if (w->results[i].done && w->results[i].proof.state == RIC_PROOF_LEFT_OUT) {
            cli_tell(out, "the first of them: %s\n", w->results[i].proof.why);
            break;
        }
}

int prove_tell_rest(const prove_list *w, int done, const char *what)
{
    if (done == w->n) return CLI_DONE;
    cli_say("ricochet: stopped %s: %d of %d %s were not looked at\n",
            cli_stopped() ? "on request" : "when the time given was over", w->n - done, w->n, what);
    return cli_stopped() ? CLI_INTERRUPTED : CLI_LIMIT;
}

/* What came of it; the counts to `out` unless it is NULL. */
static int tell_all(const prove_list *w, FILE *out, bool verbose)
{
    int count[3] = {0}, ends = 0, undecided = 0, done = 0;
    for (int i = 0; i < w->n; i++) {
        const ric_proof *p = &w->results[i].proof;
        if (!w->results[i].done) continue;
        done++;
        count[p->state]++;
        undecided += p->state == RIC_PROOF_DONE && p->stable == RIC_STABLE_UNDECIDED;
        ends += p->state == RIC_PROOF_NONE && is_end(w, p);
    }
    tell_failures(w, verbose);
    if (count[RIC_PROOF_NONE] > ends) prove_tell_kept(w);
    if (out) tell_counts(w, out, count, ends, undecided);
    const int code = prove_tell_rest(w, done, "points");
    return code ? code : count[RIC_PROOF_NONE] > ends ? CLI_FAILED : CLI_DONE;
}

static int write_certificates(const prove_list *w, const char *path)
{
    FILE *f = fopen(path, "wx");
    if (!f) {
        cli_say("ricochet: %s cannot be made: it is there already, or its folder is not\n", path);
        return CLI_FAILED;
    }
    fprintf(f, "%s\n", w->model ? w->model : "");
    for (int i = 0; i < w->n; i++)
        if (w->results[i].certificate && *w->results[i].certificate)
            fprintf(f, "%s\n", w->results[i].certificate);
    const bool lost = ferror(f) || fflush(f);
    if (!fclose(f) && !lost) return CLI_DONE;
    cli_say("ricochet: %s cannot be written\n", path);
    return CLI_FAILED;
}

static int print_all(const prove_list *w, cli_format format, bool verbose)
{
    static const char columns[] =
        "branch point verdict bits distance exists unique approach stable symmetric reversible why";
    json_t *rows = json_array();
    if (!rows) return cli_report(RIC_E_NOMEM);
    for (int i = 0; i < w->n; i++)
        if (w->results[i].done) add_row(rows, &w->results[i].proof);
    const int code = format != CLI_TEXT || verbose ? cli_print_rows(rows, columns, format)
                                                   : CLI_DONE;
    json_decref(rows);
    return code ? code : tell_all(w, format == CLI_TEXT ? stdout : stderr, verbose);
}

static void release(prove_list *w)
{
    for (int i = 0; i < w->n; i++) {
        free(w->results[i].certificate);
        prove_arcs_free(&w->results[i]);
    }
    free(w->results);
    free(w->model);
}

/* Proves what is listed and keeps it. */
static ric_status prove_all(prove_list *w, int workers)
{
    cli_workers *all = &w->workers;
    all->n = w->n;
    all->pieces = w->curves ? "curves" : w->junctions ? "junctions" : "points";
    all->work = work;
    all->user = w;
    const ric_status status = cli_workers_run(all, workers);
    if (!status) prove_keep_rest(w);
    if (status && *all->detail) cli_say("ricochet: %s\n", all->detail);
    return status;
}

static ric_status list_points(prove_list *w, int branch, long point)
{
    ric_status status = branch ? add_points(w, branch, point) : RIC_OK;
    for (int id = 1; !status && !branch && id <= ric_atlas_n_branch(w->atlas); id++)
        status = add_points(w, id, -1);
    return status;
}

static ric_status list_all(prove_list *w, int branch, long point)
{
    if (w->junctions) return prove_junctions_add(w);
    return w->curves ? prove_curves_add(w, branch) : list_points(w, branch, point);
}

static int print(const prove_list *w, cli_format format, bool verbose)
{
    FILE *out = format == CLI_TEXT ? stdout : stderr;
    if (w->junctions) return prove_junctions_print(w, format, verbose, out);
    return w->curves ? prove_curves_print(w, format, verbose, out) : print_all(w, format, verbose);
}

/* One of the three, of all of an atlas. */
static int prove_kind(const char *path, int workers, bool curves, bool junctions, FILE *out)
{
    ric_atlas *atlas = NULL;
    prove_list w = {.workers = {.seconds = HUGE_VAL, .mutex = PTHREAD_MUTEX_INITIALIZER},
                    .path = path,
                    .curves = curves,
                    .junctions = junctions};
    ric_status status = ric_atlas_read(path, &atlas);
    w.atlas = atlas;
    if (!status) status = list_all(&w, 0, -1);
    int code = status ? cli_report(status) : prove_all(&w, workers) ? CLI_FAILED : CLI_DONE;
    if (!code)
        code = curves      ? prove_curves_print(&w, CLI_TEXT, false, out)
               : junctions ? prove_junctions_print(&w, CLI_TEXT, false, out)
                           : tell_all(&w, out, false);
    release(&w);
    ric_atlas_free(atlas);
    return code;
}

int prove_atlas(const char *path, int workers, FILE *out)
{
    int worst = CLI_DONE;
    for (int kind = 0; kind < 3; kind++) {
        const int code = prove_kind(path, workers, kind == 1, kind == 2, out);
        if (code == CLI_INTERRUPTED || !ric_prover_available()) return code;
        if (code) worst = code;
    }
    return worst;
}

/* What does not go together. */
static bool fits(const prove_list *w, const char *branch, const char *point)
{
    if (w->curves && point) cli_wrong("prove: --curves is about branches: it takes no --point");
    else if (w->junctions && (w->curves || branch || point))
        cli_wrong("prove: --junctions is about all junctions of an atlas: it takes no --curves, "
                  "--branch or --point");
    else if (point && !branch)
        cli_wrong("prove: --point needs --branch ID, whose points it counts");
    else return true;
    return false;
}

int prove_command(int argc, char **argv)
{
    cli_format format;
    const char *text, *point_text, *path;
    long branch = 0, point = -1, workers = 1;
    ric_atlas *atlas = NULL;
    prove_list w = {.workers = {.seconds = HUGE_VAL, .mutex = PTHREAD_MUTEX_INITIALIZER}};
    if (cli_take_flag(&argc, argv, "--complete")) return prove_complete(argc, argv);
    const bool verbose = cli_take_flag(&argc, argv, "--verbose");
    w.curves = cli_take_flag(&argc, argv, "--curves");
    w.junctions = cli_take_flag(&argc, argv, "--junctions");
    if (!prove_complete_only(&argc, argv) || !cli_take_format(&argc, argv, &format) ||
        !cli_take_value(&argc, argv, "--branch", &text) ||
        !cli_take_value(&argc, argv, "--point", &point_text) ||
        !cli_take_value(&argc, argv, "-o", &path) ||
        !cli_take_seconds(&argc, argv, "prove", &w.workers.seconds) ||
        !cli_take_workers(&argc, argv, CLI_WORKERS_MOST, &workers) ||
        !cli_operands(&cli_prove, argc, argv, 1) ||
        (text && !cli_parse_integer(text, "--branch", 1, INT_MAX, &branch)) ||
        (point_text && !cli_parse_integer(point_text, "--point", 0, INT_MAX, &point)))
        return CLI_WRONG;
    if (!fits(&w, text, point_text)) return CLI_WRONG;
    ric_status status = ric_atlas_read(argv[1], &atlas);
    w.atlas = atlas;
    w.path = argv[1];
    w.certified = path;
    if (!status) status = list_all(&w, (int)branch, point);
    int code = status ? cli_report(status) : prove_all(&w, (int)workers) ? CLI_FAILED : CLI_DONE;
    if (code == CLI_DONE && path) code = write_certificates(&w, path);
    if (code == CLI_DONE) code = print(&w, format, verbose);
    release(&w);
    ric_atlas_free(atlas);
    return code;
}
