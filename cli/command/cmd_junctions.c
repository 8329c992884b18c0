/* ricochet junctions ATLAS: one row per junction; or one per junction on a duplicate of a branch.
 */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"

static json_t *departures(const ric_departures *count)
{
    json_t *object = json_object();
    json_object_set_new(object, "taken", json_integer(count->taken));
    json_object_set_new(object, "known", json_integer(count->known));
    json_object_set_new(object, "inadmissible", json_integer(count->inadmissible));
    json_object_set_new(object, "over_budget", json_integer(count->over_budget));
    json_object_set_new(object, "refused", json_integer(count->refused));
    return object;
}

/* Which budgets were exceeded, and how often: {"impacts": 2}. */
static json_t *budgets(const ric_departures *count)
{
    json_t *object = json_object();
    for (int i = 0; i < RIC_N_BUDGET; i++)
        if (count->over[i])
            json_object_set_new(object, ric_budget_text((ric_budget)i),
                                json_integer(count->over[i]));
    return object;
}

/* What is null or put together: a and b where they are none of a C_ab. */
static json_t *made(const ric_column *column, const void *row)
{
    const ric_junction *j = row;
    const char *name = column->name;
    if (!strcmp(name, "departures")) return departures(&j->departures);
    if (!strcmp(name, "budgets")) return budgets(&j->departures);
    if (!strcmp(name, "rotation"))
        return j->rotation[1] ? cli_integers(2, j->rotation) : json_null();
    if (!strcmp(name, "decided")) return j->a ? json_boolean(j->decided) : json_null();
    return j->a || j->b ? json_integer(!strcmp(name, "a") ? j->a : j->b) : json_null();
}

ric_status cli_junction_row(const ric_atlas *atlas, int id, double d, json_t *row)
{
    ric_junction junction;
    const ric_status status = ric_atlas_junction(atlas, id, &junction);
    if (!status)
        cli_table_row(&ric_table_junction, &junction, ric_atlas_model(atlas), d, made, row);
    return status;
}

/* -------------------------------------------------------------- duplicates */

typedef struct {
    long branch, largest;
    bool ghost;
} wanted; /* branch 0: all */

/* G_{kN,kp} where the k-duplicate of a grazing is no junction of its own, else its label. */
static json_t *point_label(const ric_junction *junction, int times)
{
    if (junction->kind != RIC_KIND_GRAZING || junction->multiple == times)
        return json_string(junction->label);
    return json_sprintf("G_%lld,%lld", (long long)times * junction->impacts,
                        (long long)times * junction->grazings);
}

static ric_status point_row(const ric_atlas *atlas, const ric_branch *branch,
                            const ric_duplicate_point *point, double d, json_t *row)
{
    ric_junction junction;
    const ric_status status = ric_atlas_junction(atlas, point->junction, &junction);
    if (status) return status;
    json_object_set_new(row, "duplicate", cli_duplicate_label(branch, point->k));
    json_object_set_new(row, "branch", json_integer(point->branch));
    json_object_set_new(row, "k", json_integer(point->k));
    json_object_set_new(row, "kind", json_string(ric_kind_text(junction.kind)));
    json_object_set_new(row, "origin", json_string(ric_duplicate_origin_text(point->origin)));
    json_object_set_new(row, "j", point->j ? json_integer(point->j) : json_null());
    json_object_set_new(row, "rotation",
                        point->j ? cli_integers(2, junction.rotation) : json_null());
    json_object_set_new(row, "label", point_label(&junction, point->times));
    json_object_set_new(row, "name", json_string(junction.name));
    json_object_set_new(row, "junction", json_integer(junction.id));
    json_object_set_new(row, "energy", cli_energy(point->energy, d));
    json_object_set_new(row, "frequency", cli_number(point->frequency));
    return RIC_OK;
}

static ric_status duplicate_rows(const ric_atlas *atlas, const ric_branch *branch, int k, double d,
                                 json_t *rows)
{
    int n = 0;
    ric_duplicate_point *points = calloc((size_t)branch->n_junction + 2, sizeof *points);
    ric_status status = points ? ric_duplicate_points(atlas, branch->id, k, &n, points)
                               : RIC_E_NOMEM;
    for (int i = 0; !status && i < n; i++) {
        json_t *row = json_object();
        status = point_row(atlas, branch, &points[i], d, row);
        json_array_append_new(rows, row);
    }
    free(points);
    return status;
}

/* A multiplication p/q on the ghost beyond an end of the branch, as the k-duplicates with q | k
 * have it. */
static void ghost_row(const ric_branch *branch, const ric_ghost_multiplication *m, ric_end end,
                      int k, double d, json_t *rows)
{
    const int times = k / m->rotation[1];
    json_t *row = json_object();
    json_object_set_new(row, "duplicate", cli_duplicate_label(branch, k));
    json_object_set_new(row, "branch", json_integer(branch->id));
    json_object_set_new(row, "k", json_integer(k));
    json_object_set_new(row, "kind", json_string(ric_kind_text(RIC_KIND_MULTIPLICATION)));
    json_object_set_new(row, "origin",
                        json_string(ric_duplicate_origin_text(
                            times == 1 ? RIC_DUPLICATE_OWN : RIC_DUPLICATE_INHERITED)));
    json_object_set_new(row, "j", json_integer(times * m->rotation[0]));
    json_object_set_new(row, "rotation", cli_integers(2, m->rotation));
    json_object_set_new(row, "end", json_string(end == RIC_END_FROM ? "from" : "to"));
    json_object_set_new(row, "admissible", json_boolean(m->admissible));
    json_object_set_new(row, "energy", cli_energy(m->energy, d));
    json_object_set_new(row, "frequency", cli_number(m->frequency / k));
    json_array_append_new(rows, row);
}

static ric_status ghost_rows(const ric_atlas *atlas, const ric_branch *branch, long largest,
                             double d, json_t *rows)
{
    ric_ghost_limits limits;
    ric_ghost **ghosts = NULL;
    int n = 0;
    ric_ghost_limits_init(atlas, &limits);
    limits.multiply = (int)largest;
    ric_status status = ric_ghost_find(atlas, branch->id, &limits, &n, &ghosts);
    for (int k = 2; !status && k <= largest; k++)
        for (int i = 0; !status && i < n; i++)
            for (int j = 0; !status && j < ric_ghost_n_multiplication(ghosts[i]); j++) {
                ric_ghost_multiplication m;
                ric_ghost_data data;
                ric_ghost_describe(ghosts[i], &data);
                if (!(status = ric_ghost_multiplication_at(ghosts[i], j, &m)) &&
                    k % m.rotation[1] == 0)
                    ghost_row(branch, &m, data.end, k, d, rows);
            }
    ric_ghosts_free(n, ghosts);
    return status;
}

static ric_status all_ghosts(const ric_atlas *atlas, double d, const void *user, json_t *rows)
{
    const wanted *w = user;
    ric_branch branch;
    ric_status status = w->branch ? ric_atlas_branch(atlas, (int)w->branch, &branch) : RIC_OK;
    for (int id = 1; !status && id <= ric_atlas_n_branch(atlas); id++)
        if ((!w->branch || id == w->branch) && !(status = ric_atlas_branch(atlas, id, &branch)))
            status = ghost_rows(atlas, &branch, w->largest, d, rows);
    return status;
}

static ric_status all_duplicates(const ric_atlas *atlas, double d, const void *user, json_t *rows)
{
    const wanted *w = user;
    const int multiply = ric_study_options(ric_atlas_study(atlas))->multiply,
              n = ric_atlas_n_branch(atlas);
    ric_branch branch;
    ric_status status = w->branch ? ric_atlas_branch(atlas, (int)w->branch, &branch) : RIC_OK;
    for (int id = 1; !status && id <= n; id++) {
        if ((w->branch && id != w->branch) || (status = ric_atlas_branch(atlas, id, &branch)))
            continue;
        for (int k = 1; !status && k <= w->largest; k++)
            status = duplicate_rows(atlas, &branch, k, d, rows);
    }
    if (!status && w->largest > multiply)
        cli_say("ricochet: q-tuplings with q above %d were not looked for; run the study with "
                "'multiply: %ld' for all "
                "points of the duplicates up to %ld\n",
                multiply, w->largest, w->largest);
    return status;
}

static int run_duplicates(const wanted *w, int argc, char **argv)
{
    static const char columns[] =
        "duplicate branch k kind origin j rotation label name junction energy frequency";
    static const char of_ghosts[] =
        "duplicate branch k kind origin j rotation end admissible energy frequency";
    const cli_listing listing = {.command = &cli_junctions,
                                 .all = w->ghost ? of_ghosts : columns,
                                 .few = w->ghost ? of_ghosts : columns,
                                 .rows = w->ghost ? all_ghosts : all_duplicates,
                                 .user = w};
    return cli_list(&listing, argc, argv);
}

static int run(int argc, char **argv)
{
    static const cli_listing listing = {.command = &cli_junctions,
                                        .count = ric_atlas_n_junction,
                                        .row = cli_junction_row,
                                        .table = &ric_table_junction};
    const char *largest, *branch;
    wanted w = {.ghost = cli_take_flag(&argc, argv, "--ghost")};
    if (!cli_take_value(&argc, argv, "--duplicates", &largest) ||
        !cli_take_value(&argc, argv, "--branch", &branch))
        return CLI_WRONG;
    if (branch && !largest)
        return cli_wrong("--branch chooses a branch whose duplicates are listed; say up to which "
                         "with --duplicates K");
    if (w.ghost && !largest)
        return cli_wrong("--ghost lists the multiplications on the ghosts of duplicates; say up to "
                         "which with --duplicates K");
    if ((largest && !cli_parse_integer(largest, "--duplicates", 1, 1000, &w.largest)) ||
        (branch && !cli_parse_integer(branch, "--branch", 1, INT_MAX, &w.branch)))
        return CLI_WRONG;
    if (largest) return run_duplicates(&w, argc, argv);
    return cli_list(&listing, argc, argv);
}

static const cli_item items[] = {
    {.text = "One row per junction: where branches begin, end, meet or turn. The table leaves out "
             "what does not "
             "fit on a line; --csv and --json show everything."},
    {.name = "key", .text = "stays the same whatever the budgets, unlike id and label"},
    {.name = "kind",
     .text =
         "start, grazing, corner, extremum, branch-point, multiplication, period-extremum or user"},
    {.name = "word",
     .text = "of the original orbit, touches left out; impacts is its length, grazings the number "
             "of touches"},
    {.name = "multiple", .text = "q of a q-tupling, 1 otherwise; rotation is its p/q"},
    {.name = "a, b", .text = "multiplicities of a point C_ab"},
    {.name = "decided",
     .text = "whether they are measured; no: lost in rounding, those of the kind are given and the "
             "label ends in ?"},
    {.name = "frequency", .text = "where it is drawn: omega / q for a q-tupling"},
    {.name = "state",
     .text = "x then v right after the first impact of the word, at a mirror point if there is no "
             "impact"},
    {.name = "flights", .text = "flight times, or the period if there is no impact"},
    {.name = "branches", .text = "ids of the branches that end at it or pass through it"},
    {.name = "departures",
     .text = "what became of the candidates: taken, known, inadmissible, over_budget, refused; "
             "refusal says why"},
    {.name = "proved", .text = "by a proof that `ricochet prove --junctions` has kept"},
    {.name = "budgets", .text = "of those over budget, how many exceed which one first"},
    {.name = "--physical",
     .text = "lengths, speeds and energies in the units of the study, not scaled by the clearance"},
    {.name = "--duplicates",
     .value = "K",
     .text = "instead, the junctions on the k-duplicates of the branches, k = 1..K: the same "
             "motions at frequency "
             "/ k"},
    {.name = "--branch", .value = "ID", .text = "with it: of this branch only"},
    CLI_ITEM_AT,
    {.name = "--ghost",
     .text = "with it: instead, the multiplications on the ghosts of the duplicates, where the "
             "equations hold "
             "beyond a grazing and the orbits are no motions"},
    {.text = "With --duplicates the columns are"},
    {.name = "duplicate",
     .text = "its label, S2^{3-}[01] for k = 3; branch is the id of the original"},
    {.name = "origin",
     .text = "own: a k-tupling, which the k-duplicate is the first to have; inherited: a q-tupling "
             "with q | k, a "
             "duplicate of the point on the q-duplicate; copy: a junction of the branch itself"},
    {.name = "j", .text = "the rotation number is j/k, in lowest terms p/q in the column rotation"},
    {.name = "frequency", .text = "of the duplicate"},
    {.name = "end",
     .text = "of ghosts: the end of the branch that it extends; admissible: yes where the orbit is "
             "a motion again"},
    {.name = "--kind",
     .value = "KIND",
     .words = "start grazing corner extremum branch-point multiplication period-extremum user",
     .text = "only rows of this kind"},
    CLI_ITEMS_WORD,
    CLI_ITEMS_PLACE,
    CLI_ITEM_HZ,
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    CLI_ITEM_WIDE,
    {0},
};

const cli_command cli_junctions = {
    .name = "junctions",
    .summary = "list the junctions of an atlas",
    .usage =
        "ricochet junctions ATLAS [--duplicates K [--ghost] [--branch ID | --at E,OMEGA]]\n"
        "           [--physical] [--hz] [--json | --csv | --wide]\n"
        "           [--kind KIND] [--word WORD] [--impacts N] [--energy A,B] [--frequency A,B]\n"
        "           [--sort COLUMN] [--limit N]\n",
    .items = items,
    .example = "ricochet junctions study.ricochet\n"
               "ricochet junctions study.ricochet --duplicates 4 --branch 3\n"
               "ricochet junctions study.ricochet --duplicates 6 --branch 3 --ghost\n",
    .run = run,
};
