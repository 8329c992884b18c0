/* Windows in force: what `check` says of them, and what `run` says when they hold no impact. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "model/model.h"
#include "study/study.h"
#include "study/windows.h"
#include "cli.h"

/* What is asked of a model once. n modes. */
typedef struct {
    const ric_explore_options *options;
    const ric_model *model;
    int n, reference; /* number from 1 of the mode that dimensionless energies are relative to; 0:
                         none */
    double unit;      /* its onset */
    double *frequency, *onset; /* [n] */
    bool *seen;                /* [n] */
    bool smooth;
} facts;

static void facts_free(facts *f)
{
    free(f->frequency);
    free(f->onset);
    free(f->seen);
}

static ric_status facts_ask(const ric_study *study, facts *f)
{
    const ric_model *model = ric_study_model(study);
    const size_t n = (size_t)ric_model_n_dof(model);
    *f = (facts){.options = ric_study_options(study),
                 .model = model,
                 .n = (int)n,
                 .smooth = ric_model_n_face(model) == 0};
    f->unit = ric_model_onset(model, &f->reference);
    f->frequency = malloc(n * sizeof *f->frequency);
    f->onset = malloc(n * sizeof *f->onset);
    f->seen = malloc(n * sizeof *f->seen);
    if (!f->frequency || !f->onset || !f->seen) return RIC_E_NOMEM;
    ric_status status = ric_model_frequencies(model, f->frequency);
    if (!status) status = ric_model_onsets(model, f->onset);
    return status ? status : ric_model_seen(model, f->seen);
}

static bool is_started(const facts *f, int mode)
{
    for (int i = 0; i < f->options->n_start; i++)
        if (f->options->start[i] == mode + 1) return true;
    return f->options->n_start == 0;
}

/* Whether impact orbits of mode i can begin in the windows: its branch leaves the linear one at the
 * onset. */
static bool begins(const facts *f, int i)
{
    const double *frequency = f->options->frequency;
    return isfinite(f->onset[i]) && (f->smooth || f->onset[i] <= f->options->energy[1]) &&
           f->frequency[i] >= frequency[0] && f->frequency[i] <= frequency[1];
}

/* In how many ways masses are loose. */
static int loose_ways(const facts *f)
{
    int count = 0;
    for (int i = 0; i < f->n; i++) count += f->seen[i] && f->frequency[i] == 0;
    return count;
}

ric_status cli_windows_loose(const ric_study *study, int *ways)
{
    facts f;
    ric_status status = facts_ask(study, &f);
    *ways = status ? 0 : loose_ways(&f);
    facts_free(&f);
    return status;
}

/* --------------------------------------------------------------- remarks */

static const char *touch_text(const facts *f)
{
    return f->smooth ? "the springs matter to it from" : "its first touch is at";
}

static void print_mode_left_out(const facts *f, int i)
{
    const double *energy = f->options->energy, *frequency = f->options->frequency;
    if (!is_started(f, i) || !isfinite(f->onset[i])) return;
    if (!f->smooth && f->onset[i] > energy[1])
        printf("  mode %d stays linear: %s energy %.6g, above the window\n", i + 1, touch_text(f),
               f->onset[i]);
    else if (f->frequency[i] < frequency[0] || f->frequency[i] > frequency[1])
        printf("  mode %d stays linear: its frequency %.6g rad/s is %s the window\n", i + 1,
               f->frequency[i], f->frequency[i] < frequency[0] ? "below" : "above");
}

enum { FEW = 4 }; /* modes that are named one by one */

static void print_left_out(const facts *f)
{
    int left = 0, not_started = 0;
    for (int i = 0; i < f->n; i++) {
        const bool out = is_started(f, i) && isfinite(f->onset[i]) && !begins(f, i);
        if (out && ++left <= FEW) print_mode_left_out(f, i);
        not_started += isfinite(f->onset[i]) && !is_started(f, i);
    }
    if (left > FEW)
        printf("  and so do%s %d more, see `onset` in --json\n", left - FEW == 1 ? "es" : "",
               left - FEW);
    if (not_started)
        printf(
            "  %d mode%s not in `start`: what belongs to %s is found only on the way from others\n",
            not_started, not_started == 1 ? " is" : "s are", not_started == 1 ? "it" : "them");
}

/* The least scaled energy of any motion that meets contact k: between stops and springs that are
 * open s = b.x is at most sqrt(2 E b.K^-1 b), and what closed springs hold is taken from E. 0 where
 * it moves freely. normal: of this contact, [n]. */
static double least_energy(const facts *f, const double *normal, double clearance)
{
    double give = 0;
    for (int i = 0; i < f->n; i++)
        if (f->frequency[i] > 0) give += pow(normal[i] / f->frequency[i], 2);
        else if (normal[i] != 0) return 0;
    return pow(clearance / ric_model_length(f->model), 2) / (2 * give);
}

/* Contacts that take part in nothing: one of them with a clearance in other units, say. */
static ric_status print_out_of_reach(const facts *f)
{
    const double rounding = 1e-9;
    const int m = ric_model_n_contact(f->model);
    double *normals = f->smooth ? NULL : malloc((size_t)m * (size_t)f->n * sizeof *normals);
    ric_status status = f->smooth  ? RIC_OK
                        : !normals ? RIC_E_NOMEM
                                   : ric_model_modal_normals(f->model, normals);
    for (int k = 0; k < m && !f->smooth && !status; k++) {
        ric_contact contact;
        if ((status = ric_model_contact(f->model, k, &contact))) break;
        const double least = least_energy(f, normals + (size_t)k * (size_t)f->n, contact.clearance);
        if (least > f->options->energy[1] * (1 + rounding))
            printf("  contact %d is out of reach: no motion of an energy below %.6g meets it\n",
                   k + 1, least);
    }
    free(normals);
    return status;
}

/* Seconds that a branch of n modes takes, roughly, on one core of 2022: a step is the solution of
 * equations of that size, and under a power law the integration of as many sensitivities. Chains of
 * 20, 40 and 60 masses with two stops took 0.7e-5, 1.5e-5 and 0.9e-5 n^3. */
#define RIGID_SECONDS 1e-5
#define SMOOTH_SECONDS 4e-3
#define LONG 0.4        /* seconds for one branch from which on that is said */
#define FEW_BRANCHES 20 /* that an atlas has with the default budgets, and many */
#define MANY_BRANCHES 200

static double branch_seconds(const facts *f)
{
    const double n = ric_model_n_mode(f->model);
    return (f->smooth ? SMOOTH_SECONDS : RIGID_SECONDS) * n * n * n;
}

/* "4 s", "10 min", "2 h": one digit, which is all that is known. */
static void write_duration(double seconds, size_t size, char *out)
{
    const double unit = seconds < 100 ? 1 : seconds < 6000 ? 60 : 3600;
    snprintf(out, size, "%.0f %s", ceil(seconds / unit),
             unit == 1    ? "s"
             : unit == 60 ? "min"
                          : "h");
}

/* Modes far above those that begin in the windows act on them by their static compliance, nearly.
 */
static int modes_worth(const facts *f)
{
    double fastest = 0;
    for (int i = 0; i < f->n; i++)
        if (is_started(f, i) && begins(f, i)) fastest = fmax(fastest, f->frequency[i]);
    return ric_windows_worth(f->n, f->frequency, fastest);
}

/* What is said of a run that will take long; "" for others. */
static void write_length(const facts *f, size_t size, char *out)
{
    char each[20], least[20], most[20], few[160];
    const int worth = modes_worth(f);
    const double seconds = branch_seconds(f);
    out[0] = '\0';
    if (seconds <= LONG) return;
    if (seconds < 1) snprintf(each, sizeof each, "%.1g s", seconds);
    else write_duration(seconds, sizeof each, each);
    write_duration(FEW_BRANCHES * seconds, sizeof least, least);
    write_duration(MANY_BRANCHES * seconds, sizeof most, most);
    if (worth > 0 && worth < f->n)
        snprintf(few, sizeof few,
                 "`model: {modes: %d}` keeps those up to %d times the highest that begins in the "
                 "windows",
                 worth, RIC_WINDOWS_FAR);
    else snprintf(few, sizeof few, "reduce the structure to those that matter");
    snprintf(out, size,
             "a branch of %d modes takes about %s, and an atlas of %d to %d branches %s to %s; "
             "--seconds S ends with what is found till then, and `start: [1]` with `depth: 1` asks "
             "for little. The "
             "work grows with the cube of the modes: %s",
             ric_model_n_mode(f->model), each, FEW_BRANCHES, MANY_BRANCHES, least, most, few);
}

ric_status cli_windows_warn(const ric_study *study)
{
    facts f;
    char length[500];
    ric_status status = facts_ask(study, &f);
    if (!status) write_length(&f, sizeof length, length);
    if (!status && *length) cli_say("ricochet: %s\n", length);
    facts_free(&f);
    return status;
}

static bool any_begins(const facts *f)
{
    for (int i = 0; i < f->n; i++)
        if (is_started(f, i) && begins(f, i)) return true;
    return ric_model_rattles(f->model);
}

/* Contacts of a part cannot be met at the energy of that part alone: a run departs from nothing
 * then. */
static bool falls_apart(const facts *f)
{
    return ric_model_n_part(f->model) > 1;
}

/* ----------------------------------------------------------------- check */

static const char *by(bool chosen)
{
    return chosen ? " (chosen)" : "";
}

/* What a run says to the study before it begins. */
static bool refused(const ric_study *study, char *why, size_t size)
{
    const bool is = ric_explore_check(study) == RIC_E_INPUT;
    snprintf(why, size, "%s", is ? ric_detail() : "");
    return is;
}

/* What a study that leaves open where to look leaves to the program, too. */
static void print_look(const facts *f, const ric_study *study)
{
    const ric_explore_options *o = f->options;
    if (!ric_study_window_chosen(study, false) || !ric_study_window_chosen(study, true)) return;
    if (o->points)
        printf("  a first look: from %d points on nothing more is departed to; `points: 0` under "
               "`explore` goes on\n",
               o->points);
    if (o->cross_tongues)
        printf("  internal resonances narrower than %g of the frequency are stepped over; "
               "`tongues: follow` follows "
               "them\n",
               o->tongue_width);
}

static ric_status print_windows(const facts *f, const ric_study *study)
{
    char length[500], why[600];
    const double *energy = f->options->energy, *frequency = f->options->frequency;
    printf("\nwindows: scaled energy %.6g to %.6g%s, frequency %.6g to %.6g rad/s%s\n", energy[0],
           energy[1], by(ric_study_window_chosen(study, false)), frequency[0], frequency[1],
           by(ric_study_window_chosen(study, true)));
    if (f->reference)
        printf("  an energy of 1 without dimensions is %.10g, %s of mode %d; the window ends at "
               "%.4g\n",
               f->unit,
               f->smooth ? "where the springs are as stiff as the structure in the motion"
                         : "the first touch",
               f->reference, energy[1] / f->unit);
    print_left_out(f);
    const ric_status status = print_out_of_reach(f);
    print_look(f, study);
    if (refused(study, why, sizeof why)) printf("warning: a run refuses this study: %s\n", why);
    if (!any_begins(f))
        puts("warning: the windows hold no mode that meets a contact, and a run would find linear "
             "motions only; leave "
             "out\nenergy and frequency, or write auto, for windows that do");
    if (falls_apart(f))
        puts("warning: the structure falls into parts that no contact joins, and a run departs "
             "from nothing in it; "
             "study\neach part alone");
    write_length(f, sizeof length, length);
    if (*length) printf("warning: %s\n", length);
    return status;
}

ric_status cli_windows_print(const ric_study *study)
{
    facts f;
    ric_status status = facts_ask(study, &f);
    if (!status) status = print_windows(&f, study);
    facts_free(&f);
    return status;
}

static json_t *pair(const double window[2])
{
    return json_pack("[o, o]", cli_number(window[0]), cli_number(window[1]));
}

ric_status cli_windows_rows(const ric_study *study, json_t *rows)
{
    facts f;
    char why[600];
    ric_status status = facts_ask(study, &f);
    const bool is_refused = !status && refused(study, why, sizeof why);
    json_t *row;
    size_t i;
    json_array_foreach(rows, i, row)
    {
        if (status) break;
        json_object_set_new(row, "onset", cli_number(f.onset[i]));
        json_object_set_new(row, "relative_onset", cli_number(f.onset[i] / f.unit));
        json_object_set_new(row, "begins",
                            json_boolean(is_started(&f, (int)i) && begins(&f, (int)i)));
        json_object_set_new(row, "window_energy", pair(f.options->energy));
        json_object_set_new(row, "window_frequency", pair(f.options->frequency));
        json_object_set_new(row, "window_energy_by",
                            json_string(ric_study_window_chosen(study, false) ? "auto" : "study"));
        json_object_set_new(row, "window_frequency_by",
                            json_string(ric_study_window_chosen(study, true) ? "auto" : "study"));
        json_object_set_new(row, "refused", is_refused ? json_string(why) : json_null());
        json_object_set_new(row, "branch_seconds", cli_number(branch_seconds(&f)));
    }
    facts_free(&f);
    return status;
}

/* ------------------------------------------------------------------- run */

static bool has_impacts(const ric_atlas *atlas, const facts *f)
{
    ric_branch branch;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        if (!ric_atlas_branch(atlas, id, &branch) && !ric_branch_linear(f->model, &branch))
            return true;
    return false;
}

/* The first refusal of a junction; "" if there is none. */
static const char *refusal(const ric_atlas *atlas)
{
    ric_junction junction;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++)
        if (!ric_atlas_junction(atlas, id, &junction) && junction.departures.refused)
            return junction.refusal;
    return "";
}

static void say_why(const facts *f, const ric_atlas *atlas)
{
    int lowest = -1;
    const double *energy = f->options->energy, *frequency = f->options->frequency;
    for (int i = 0; i < f->n; i++)
        if (is_started(f, i) && isfinite(f->onset[i]) &&
            (lowest < 0 || f->onset[i] < f->onset[lowest]))
            lowest = i;
    if (any_begins(f)) {
        const char *why = refusal(atlas);
        cli_say("ricochet: no orbit that meets a contact was found, although modes meet one inside "
                "the windows%s%s; "
                "`ricochet report` says which departures were refused or not tried\n",
                *why ? ": " : "", why);
        if (loose_ways(f) && !ric_model_rattles(f->model)) cli_say("%s\n", CLI_LOOSE);
        return;
    }
    cli_say("ricochet: no orbit that meets a contact was found");
    if (lowest < 0) {
        cli_say(": none of the modes that are started from meets one\n");
        if (loose_ways(f) && !ric_model_rattles(f->model)) cli_say("%s\n", CLI_LOOSE);
        return;
    }
    if (f->onset[lowest] > energy[1])
        cli_say(": mode %d touches first, at scaled energy %.6g, and the window ends at %.6g",
                lowest + 1, f->onset[lowest], energy[1]);
    else
        cli_say(": mode %d meets it at %.6g rad/s, and the window is %.6g to %.6g rad/s",
                lowest + 1, f->frequency[lowest], frequency[0], frequency[1]);
    cli_say("; leave out energy and frequency, or write auto, for windows that hold what the model "
            "does, and see "
            "`ricochet check`\n");
}

ric_status cli_windows_tell(const ric_atlas *atlas)
{
    facts f;
    ric_status status = facts_ask(ric_atlas_study(atlas), &f);
    if (!status && !has_impacts(atlas, &f)) say_why(&f, atlas);
    facts_free(&f);
    return status;
}
