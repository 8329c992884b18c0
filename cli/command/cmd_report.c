/* ricochet report ATLAS: what a run did, what it left out and why, and how good what it found is;
 * all of it from the file. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/shaking.h"
#include "report.h"

enum { SAMPLE = 64 }; /* branches whose middle point is replayed, as long as that takes no time: */
/* QUICK: degrees of freedom; a replay begins with the simulator's own modes, which grow with the
 * cube */
#define QUICK 32

json_t *cli_report_add(json_t *rows, const char *item, json_t *value, const char *detail)
{
    json_t *row = json_object();
    json_object_set_new(row, "item", json_string(item));
    json_object_set_new(row, "value", value);
    json_object_set_new(row, "detail", json_string(detail));
    json_array_append_new(rows, row);
    return row;
}

static void add(json_t *rows, const char *item, json_t *value, const char *detail)
{
    cli_report_add(rows, item, value, detail);
}

static void add_count(json_t *rows, const char *item, json_int_t count, const char *detail)
{
    add(rows, item, json_integer(count), detail);
}

/* ------------------------------------------------------------------ branches */

static ric_status add_branches(json_t *rows, const ric_atlas *atlas)
{
    int n = ric_atlas_n_branch(atlas), stops[16] = {0}, points = 0, open = 0;
    const double tolerance = ric_study_options(ric_atlas_study(atlas))->tolerance;
    double residual = 0;
    char detail[80];
    for (int id = 1; id <= n; id++) {
        ric_branch branch;
        ric_status status = ric_atlas_branch(atlas, id, &branch);
        if (status) return status;
        stops[branch.stop % 16]++;
        points += branch.n_point;
        for (int i = 0; i < branch.n_point; i++) {
            ric_point point;
            if ((status = ric_atlas_point(atlas, id, i, &point, NULL, NULL))) return status;
            residual = fmax(residual, point.residual);
            open += point.residual > tolerance;
        }
    }
    add_count(rows, "branches", n, "");
    for (int i = 0; i < 16; i++)
        if (stops[i]) add_count(rows, "branches that stop", stops[i], ric_stop_text((ric_stop)i));
    add_count(rows, "points", points, "");
    add(rows, "largest residual", cli_number(residual), "relative to 1 + |state|");
    snprintf(detail, sizeof detail, "which rounding leaves at more than the `tolerance` %g",
             tolerance);
    if (open) add_count(rows, "points that miss the accuracy asked for", open, detail);
    return RIC_OK;
}

/* -------------------------------------------------------------------- proofs */

/* How much of it are theorems; nothing is said of an atlas for which that was not asked. */
static void add_proofs(json_t *rows, const ric_atlas *atlas)
{
    cli_proofs p;
    char detail[240];
    if (!cli_count_proofs(atlas, &p)) return;
    const struct {
        const char *item;
        int proved, all;
    } counts[] = {{"points proved", p.points_proved, p.points},
                  {"curves proved", p.curves_proved, p.curves},
                  {"junctions proved", p.junctions_proved, p.junctions}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        snprintf(detail, sizeof detail, "of %d%s%s", counts[i].all, *p.why ? "; left out: " : "",
                 p.why);
        add_count(rows, counts[i].item, counts[i].proved, detail);
    }
}

/* ---------------------------------------------------------------------- gaps */

/* One end of a branch: its junction if there is one, and where it is. */
static void name_end(const ric_atlas *atlas, int junction, const ric_point *point, size_t size,
                     char *text)
{
    ric_junction at;
    if (junction && !ric_atlas_junction(atlas, junction, &at))
        snprintf(text, size, "%.100s (junction %d, E %.9g omega %.9g)", at.label, junction,
                 at.energy, at.frequency);
    else snprintf(text, size, "E %.9g omega %.9g", point->energy, point->frequency);
}

/* A branch that could not be followed further: what lies beyond its last point is missing. One that
 * has a junction at its far end was followed to it, but from there it comes to somewhere else:
 * either end may be the wrong one. */
static void add_stopped(json_t *rows, const ric_atlas *atlas, const ric_branch *branch)
{
    ric_point first, last;
    char from[200], to[200];
    if (branch->stop != RIC_STOP_FAILED || !branch->n_point ||
        ric_atlas_point(atlas, branch->id, 0, &first, NULL, NULL) ||
        ric_atlas_point(atlas, branch->id, branch->n_point - 1, &last, NULL, NULL))
        return;
    name_end(atlas, branch->from, &first, sizeof from, from);
    name_end(atlas, branch->to, &last, sizeof to, to);
    json_t *detail = branch->to ? json_sprintf("%s from %s to %s: %s", branch->label, from, to,
                                               branch->why)
                                : json_sprintf("%s beyond %s, from %s: %s", branch->label, to, from,
                                               branch->why);
    add(rows, branch->to ? "ends disagree of branch" : "rest missing of branch",
        json_integer(branch->id), detail ? json_string_value(detail) : branch->why);
    json_decref(detail);
}

/* Every branch on which events may be missing, with their kind, their place and the reason. */
static ric_status add_gaps(json_t *rows, const ric_atlas *atlas)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch branch;
        ric_status status = ric_atlas_branch(atlas, id, &branch);
        if (status) return status;
        const char *gaps = ric_branch_gaps(&branch);
        if (*gaps) {
            json_t *detail = json_sprintf("%s, E %.9g to %.9g: %s", branch.label, branch.energy_min,
                                          branch.energy_max, gaps);
            add(rows, "events may be missing on branch", json_integer(id),
                detail ? json_string_value(detail) : gaps);
            json_decref(detail);
        }
        add_stopped(rows, atlas, &branch);
    }
    return RIC_OK;
}

/* ------------------------------------------------------------------- tongues */

/* Where a branch is no longer what its name says: it climbs along a mode at an all but constant
 * frequency. */
static ric_status add_tongues(json_t *rows, const ric_atlas *atlas)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch branch;
        json_t *text = NULL;
        ric_status status = ric_atlas_branch(atlas, id, &branch);
        if (!status) status = cli_tongues_text(atlas, id, 1, &text);
        if (status) return status;
        if (*json_string_value(text)) {
            json_t *detail = json_sprintf("%s %s", branch.label, json_string_value(text));
            add(rows, CLI_RESONANCE, json_integer(id),
                detail ? json_string_value(detail) : json_string_value(text));
            json_decref(detail);
        }
        json_decref(text);
    }
    return RIC_OK;
}

/* ------------------------------------------------------------------- islands */

/* Families that no chain of junctions links to a linear mode, under the budgets of the study. */
static ric_status add_islands(json_t *rows, const ric_atlas *atlas)
{
    const int n = ric_atlas_n_branch(atlas);
    int islands = 0;
    for (int first = 1; first <= n; first++) {
        ric_branch branch, other;
        double energy[2] = {HUGE_VAL, -HUGE_VAL};
        int members = 0;
        ric_status status = ric_atlas_branch(atlas, first, &branch);
        if (status) return status;
        if (branch.linked || branch.family != first) continue;
        for (int id = first; id <= n; id++) {
            if ((status = ric_atlas_branch(atlas, id, &other))) return status;
            if (other.family != first) continue;
            members++;
            energy[0] = fmin(energy[0], other.energy_min);
            energy[1] = fmax(energy[1], other.energy_max);
        }
        json_t *detail = json_sprintf("%d branch%s from %s on, E %.9g to %.9g", members,
                                      members == 1 ? "" : "es", branch.label, energy[0], energy[1]);
        add(rows, "island of branch", json_integer(first),
            detail ? json_string_value(detail) : branch.label);
        json_decref(detail);
        islands++;
    }
    add(rows, "families linked to no mode", json_integer(islands),
        islands ? "under the budgets of the study" : "");
    return RIC_OK;
}

/* Every junction with branches that leave it and could not be followed. */
static ric_status add_refused(json_t *rows, const ric_atlas *atlas)
{
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j;
        ric_status status = ric_atlas_junction(atlas, id, &j);
        if (status) return status;
        if (j.departures.refused <= 0) continue;
        json_t *detail = json_sprintf("%s, E %.9g omega %.9g: %d refused: %s", j.label, j.energy,
                                      j.frequency, j.departures.refused, j.refusal);
        add(rows, "branches may be missing at junction", json_integer(id),
            detail ? json_string_value(detail) : j.refusal);
        json_decref(detail);
    }
    return RIC_OK;
}

/* ---------------------------------------------------------------- departures */

/* Where the residual that a reason ends with begins, or the reason's end. */
static size_t without_residual(const char *why, size_t n)
{
    static const char *const before[] = {" (residual ", ": residual "};
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < sizeof before / sizeof *before; k++)
            if (!strncmp(why + i, before[k], strlen(before[k]))) return i;
    return n;
}

/* The reasons of a junction without their residuals, each once: numbers that differ make no other
 * reason. */
static char *kinds_of_refusal(const char *refusal)
{
    char *out = calloc(1, strlen(refusal) + 1);
    for (const char *why = refusal; out && *why;) {
        const char *end = strstr(why, "; ");
        const size_t n = end ? (size_t)(end - why) : strlen(why), kept = without_residual(why, n),
                     used = strlen(out);
        bool known = false;
        for (const char *c = out; c && *c && !known; c = strstr(c, "; "), c = c ? c + 2 : NULL)
            known = !strncmp(c, why, kept) && (!c[kept] || !strncmp(c + kept, "; ", 2));
        if (!known) sprintf(out + used, "%s%.*s", used ? "; " : "", (int)kept, why);
        why = end ? end + 2 : why + n;
    }
    return out;
}

/* Counts each reason once; few are different. */
static void add_refusals(json_t *rows, const ric_atlas *atlas)
{
    json_t *reasons = json_object();
    const char *why;
    json_t *count;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction junction;
        if (ric_atlas_junction(atlas, id, &junction) || !junction.departures.refused) continue;
        char *kinds = kinds_of_refusal(junction.refusal);
        const char *key = kinds ? kinds : junction.refusal;
        json_int_t before = json_integer_value(json_object_get(reasons, key));
        json_object_set_new(reasons, key, json_integer(before + junction.departures.refused));
        free(kinds);
    }
    json_object_foreach(reasons, why, count)
        add(rows, "departures refused", json_incref(count), why);
    json_decref(reasons);
}

/* Where departures were tried with larger budgets than elsewhere. */
static void add_regions(json_t *rows, const ric_atlas *atlas)
{
    const ric_explore_options *o = ric_study_options(ric_atlas_study(atlas));
    char detail[200];
    for (int i = 0; i < o->n_region; i++) {
        const ric_region *r = &o->region[i];
        snprintf(detail, sizeof detail, "energy %.6g to %.6g, frequency %.6g to %.6g", r->energy[0],
                 r->energy[1], r->frequency[0], r->frequency[1]);
        add_count(rows, "region with larger budgets", i + 1, detail);
    }
}

int cli_unmeasured(const ric_atlas *atlas)
{
    int n = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction junction;
        n += !ric_atlas_junction(atlas, id, &junction) && junction.b == 0 &&
             (junction.kind == RIC_KIND_EXTREMUM || junction.kind == RIC_KIND_BRANCH_POINT ||
              junction.kind == RIC_KIND_MULTIPLICATION);
    }
    return n;
}

/* What there is to say of a junction, which counts then; false: nothing, and it does not. */
typedef bool remark(const ric_atlas *atlas, int id, const ric_junction *j, json_t **text);

/* How many junctions there is something to say of, with what is said of the first. */
static ric_status add_remarked(json_t *rows, const ric_atlas *atlas, const char *item, remark *say)
{
    int n = 0;
    json_t *first = NULL;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j;
        ric_status status = ric_atlas_junction(atlas, id, &j);
        if (status) return json_decref(first), status;
        n += say(atlas, id, &j, n ? NULL : &first);
    }
    if (n) add_count(rows, item, n, first ? json_string_value(first) : "");
    json_decref(first);
    return RIC_OK;
}

/* A label whose multiplicities nobody can tell. */
static bool is_undecided(const ric_atlas *atlas, int id, const ric_junction *j, json_t **text)
{
    (void)atlas;
    (void)id;
    if (j->a == 0 || j->decided) return false;
    if (text)
        *text = json_string(
            "lost in rounding, a and b are those of the kind; another step may find "
            "such a junction elsewhere or not at all");
    return true;
}

/* The first junction whose label is what the study calls another one, `named`; 0: none. */
static int labelled_like(const ric_atlas *atlas, int named, const char *name)
{
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j;
        if (id != named && !ric_atlas_junction(atlas, id, &j) && !strcmp(j.label, name)) return id;
    }
    return 0;
}

/* Two numberings stand side by side: a label may be what the study calls another junction. */
static bool is_ambiguous(const ric_atlas *atlas, int id, const ric_junction *j, json_t **text)
{
    const int other = *j->name ? labelled_like(atlas, id, j->name) : 0;
    if (other && text)
        *text = json_sprintf(
            "%s is junction %d by name, and the label of junction %d; a name comes first", j->name,
            id, other);
    return other > 0;
}

static long count_points(const ric_atlas *atlas)
{
    long sum = 0;
    ric_branch branch;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        if (!ric_atlas_branch(atlas, id, &branch)) sum += branch.n_point;
    return sum;
}

static void add_together(json_t *rows, const ric_model *model)
{
    char text[CLI_TOGETHER];
    if (*cli_together_remark(model))
        add(rows, "contacts that close together", json_null(), cli_together_remark(model));
    for (int last = 0; cli_together_next(model, &last, text);)
        add(rows, "contacts that close together", json_null(), text);
}

static ric_status add_departures(json_t *rows, const ric_atlas *atlas)
{
    const char *over[RIC_N_BUDGET] =
        {[RIC_BUDGET_WINDOW] = "outside the windows",
         [RIC_BUDGET_MULTIPLY] = "beyond `multiply`",
         [RIC_BUDGET_IMPACTS] = "more than `impacts`",
         [RIC_BUDGET_SYMMETRIC] = "not symmetric",
         [RIC_BUDGET_TOUCHES] = "more touches at once than are enumerated",
         [RIC_BUDGET_DEPTH] = "beyond `depth`"};
    /* of a file that may say any int */
    struct {
        json_int_t taken, known, inadmissible, over[RIC_N_BUDGET];
    } sum = {0};
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction junction;
        ric_status status = ric_atlas_junction(atlas, id, &junction);
        if (status) return status;
        sum.taken += junction.departures.taken;
        sum.known += junction.departures.known;
        sum.inadmissible += junction.departures.inadmissible;
        for (int i = 0; i < RIC_N_BUDGET; i++) sum.over[i] += junction.departures.over[i];
    }
    const int limit = ric_study_options(ric_atlas_study(atlas))->points;
    if (limit && count_points(atlas) >= limit)
        over[RIC_BUDGET_DEPTH] = "beyond `depth` or `points`";
    add_count(rows, "junctions", ric_atlas_n_junction(atlas), "");
    if (cli_unmeasured(atlas))
        add_count(rows, "junctions without a label", cli_unmeasured(atlas),
                  "not measured yet; the run goes on with them");
    ric_status status = add_remarked(rows, atlas, "labels that are not decided", is_undecided);
    if (!status)
        status = add_remarked(rows, atlas, "names that are labels of other junctions",
                              is_ambiguous);
    if (status) return status;
    if (ric_atlas_n_unplaced(atlas))
        add_count(rows, "events that are no junctions", ric_atlas_n_unplaced(atlas),
                  "their junction does not converge");
    if (ric_atlas_n_blind(atlas))
        add_count(rows, "branches with multiplications not looked for", ric_atlas_n_blind(atlas),
                  "where multipliers are lost in rounding");
    add_count(rows, "departures taken", sum.taken, "");
    add_count(rows, "departures known", sum.known, "the branch was found another way");
    add_count(rows, "departures inadmissible", sum.inadmissible, "no motions leave");
    int ways;
    if ((status = cli_windows_loose(ric_atlas_study(atlas), &ways))) return status;
    if (ways > 1) add_count(rows, "ways in which masses are loose", ways, CLI_SEVERAL);
    add_regions(rows, atlas);
    add_together(rows, ric_atlas_model(atlas));
    if (*cli_forcing_remark(ric_atlas_study(atlas)))
        add(rows, "losses and force", json_null(), cli_forcing_remark(ric_atlas_study(atlas)));
    add_refusals(rows, atlas);
    for (int i = 0; i < RIC_N_BUDGET; i++)
        if (sum.over[i]) add_count(rows, "departures not tried", sum.over[i], over[i]);
    return RIC_OK;
}

/* -------------------------------------------------------------------- replay */

static int sample_size(const ric_atlas *atlas)
{
    double larger = ric_model_n_dof(ric_atlas_model(atlas)) / (double)QUICK;
    return larger > 1 ? (int)(SAMPLE / (larger * larger * larger)) : SAMPLE;
}

/* Of orbits in the midst of branches, on how many a disturbance grows that parts contacts which
 * close together. */
static ric_status add_parting(json_t *rows, const ric_atlas *atlas)
{
    const int size = sample_size(atlas), n_branch = size ? ric_atlas_n_branch(atlas) : 0,
              step = n_branch / (size + !size) + 1;
    int asked = 0, grows = 0, unknown = 0;
    char why[160] = "", detail[400];
    double pairs[4 * ric_model_n_dof(ric_atlas_model(atlas))];
    if (!*cli_together_remark(ric_atlas_model(atlas))) return RIC_OK;
    for (int id = 1; id <= n_branch; id += step) {
        ric_branch b;
        ric_orbit **orbits = NULL;
        ric_stability stable;
        int found = 0, n = 0;
        ric_status status = ric_atlas_branch(atlas, id, &b);
        if (status) return status;
        if (!b.n_point || ric_branch_linear(ric_atlas_model(atlas), &b)) continue;
        status = ric_orbit_find(atlas, id, RIC_AT_POINT, b.n_point / 2, &found, &orbits);
        const ric_status known = status ? status : ric_orbit_parting(orbits[0], &n, pairs, &stable);
        ric_orbits_free(found, orbits);
        if (status) return status;
        if (known == RIC_E_INPUT && !unknown++) snprintf(why, sizeof why, "%s", ric_detail());
        if (known || !n) continue;
        asked++;
        grows += stable == RIC_STABLE_NO;
    }
    const size_t used = (size_t)snprintf(detail, sizeof detail,
                                         "of %d orbits in the midst of branches; `ricochet orbit` "
                                         "has their multipliers as parting",
                                         asked);
    if (unknown)
        snprintf(detail + used, sizeof detail - used, "; of %d more it is unknown: %s", unknown,
                 why);
    add_count(rows, "disturbances that part contacts grow", grows, detail);
    return RIC_OK;
}

static ric_status add_replay(json_t *rows, const ric_atlas *atlas)
{
    int size = sample_size(atlas), n = size ? ric_atlas_n_branch(atlas) : 0,
        step = n / (size + !size) + 1, replayed = 0, failed = 0;
    double flight = 0, back = 0, energy = 0;
    for (int id = 1; id <= n; id += step) {
        ric_branch branch;
        ric_check check;
        ric_status status = ric_atlas_branch(atlas, id, &branch);
        if (status) return status;
        if (!branch.n_point) continue;
        if ((status = ric_verify_point(atlas, id, branch.n_point / 2, &check))) return status;
        replayed++;
        failed += !check.passed;
        flight = fmax(flight, check.flight_error);
        back = fmax(back, isnan(check.return_error)
                              ? 0
                              : check.return_error / fmax(1, 1e-7 * check.condition));
        energy = fmax(energy, check.energy_error);
    }
    if (size == 0) {
        add(rows, "orbits replayed", json_string("none"),
            "the structure is too large to do so in passing; `ricochet verify` does it");
        return RIC_OK;
    }
    add_count(rows, "orbits replayed", replayed,
              "the middle of a sample of branches; `ricochet verify` does more");
    add_count(rows, "of them wrong", failed, "");
    add(rows, "largest flight error", cli_number(flight), "time and state at the next impact");
    add(rows, "largest return error", cli_number(back),
        "after one period, over max(1, 1e-7 largest multiplier)");
    add(rows, "largest energy drift", cli_number(energy), "");
    return RIC_OK;
}

/* What relative energies are multiples of; nothing for a free body, which has none. */
static void add_onset(json_t *rows, const ric_atlas *atlas)
{
    char detail[120];
    int mode;
    const ric_model *model = ric_atlas_model(atlas);
    const double onset = ric_model_onset(model, &mode);
    snprintf(detail, sizeof detail, "scaled, %s mode %d; relative energies are multiples of it",
             ric_model_n_face(model) ? "the first touch of"
                                     : "where springs are as stiff as the structure to",
             mode);
    if (mode) add(rows, "onset", cli_number(onset), detail);
}

ric_status cli_report_rows(const ric_atlas *atlas, json_t *rows)
{
    ric_status status = add_branches(rows, atlas);
    add_onset(rows, atlas);
    if (!status) add_proofs(rows, atlas);
    if (!status) status = add_departures(rows, atlas);
    if (!status) status = add_islands(rows, atlas);
    if (!status) status = add_tongues(rows, atlas);
    if (!status) status = add_gaps(rows, atlas);
    if (!status) status = add_refused(rows, atlas);
    if (!status) status = cli_report_places(atlas, rows);
    if (!status) status = add_parting(rows, atlas);
    return status ? status : add_replay(rows, atlas);
}

static ric_status rows_of(const ric_atlas *atlas, double d, const void *user, json_t *rows)
{
    (void)d;
    (void)user;
    return cli_report_rows(atlas, rows);
}

static int run(int argc, char **argv)
{
    static const char columns[] = "item value detail";
    static const cli_listing listing = {.command = &cli_report_atlas,
                                        .rows = rows_of,
                                        .all = columns,
                                        .few = columns};
    return cli_list(&listing, argc, argv);
}

static const cli_item items[] = {
    {.text =
         "Counts the branches and how they end, and what became of the departures from every "
         "junction: taken, "
         "known, inadmissible, refused and why, not tried and for which budget. Names every "
         "branch that follows an "
         "internal resonance, with the mode and the energies between which it does so; every "
         "branch on which "
         "events may be missing, with what kind of event, where, and why; every branch that "
         "could not be "
         "followed, with both its ends; every junction with departures that could not be "
         "followed, with its "
         "place and the reasons; and what is known to less than 1e-9 of its energy, to what, and "
         "why: junctions of "
         "branches whose frequency hardly changes or of modes of nearly one frequency, last "
         "orbits beside a junction, "
         "turns of an energy or frequency that are no junctions, and junctions whose label is "
         "not decided, which "
         "another step may find elsewhere or not at all. The largest residual is that of all "
         "points; the errors of "
         "replay are those of the "
         "middle points of at most 64 branches (fewer beyond 32 "
         "degrees of freedom), which the simulator of `ricochet verify` flies again. All of it "
         "comes from the "
         "file."},
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_report_atlas = {
    .name = "report",
    .summary = "what a run did, what it left out and why, and how good what it found is",
    .usage = "ricochet report ATLAS [--json | --csv]\n",
    .items = items,
    .example = "ricochet report study.ricochet\n",
    .run = run,
};
