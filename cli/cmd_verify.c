/* ricochet verify ATLAS: replays stored orbits with the simulator, which knows nothing of how they were found. */
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"

enum { SAMPLE = 5 };

typedef struct {
    const ric_atlas *atlas;
    bool all;
    json_t *rows;
    int points, failed, branches;
} audit;

static void add_row(audit *a, const ric_check *check)
{
    json_t *row = json_object();
    json_object_set_new(row, "branch", json_integer(check->branch));
    json_object_set_new(row, "point", json_integer(check->point));
    json_object_set_new(row, "flight_error", cli_number(check->flight_error));
    json_object_set_new(row, "return_error", cli_number(check->return_error));
    json_object_set_new(row, "condition", cli_number(check->condition));
    json_object_set_new(row, "energy_error", cli_number(check->energy_error));
    json_object_set_new(row, "faces_agree", json_boolean(check->faces_agree));
    json_object_set_new(row, "passed", json_boolean(check->passed));
    json_array_append_new(a->rows, row);
    a->points++;
    a->failed += !check->passed;
}

static int compare(const void *a, const void *b)
{
    int x = *(const int *)a, y = *(const int *)b;
    return (x > y) - (x < y);
}

/* First, middle, last and SAMPLE more, spread by a hash of the branch's number (Steele, Lea, Flood 2014): the same ones
 * every time. Ascending, maybe with repetitions. */
static void choose(int branch, int n_point, int *chosen)
{
    uint64_t z = (uint64_t)branch;
    chosen[0] = 0;
    chosen[1] = n_point / 2;
    chosen[2] = n_point - 1;
    for (int i = 0; i < SAMPLE; i++) {
        uint64_t mixed = z += 0x9e3779b97f4a7c15u;
        mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9u;
        mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebu;
        chosen[3 + i] = (int)((mixed ^ (mixed >> 31)) % (uint64_t)n_point);
    }
    qsort(chosen, 3 + SAMPLE, sizeof *chosen, compare);
}

static ric_status verify_one(audit *a, int branch, int point)
{
    ric_check check;
    ric_status status = ric_verify_point(a->atlas, branch, point, &check);
    if (!status)
        add_row(a, &check);
    return status;
}

static ric_status verify_branch(audit *a, int id)
{
    ric_branch branch;
    int chosen[3 + SAMPLE];
    ric_status status = ric_atlas_branch(a->atlas, id, &branch);
    if (status || branch.n_point == 0)
        return status;
    a->branches++;
    if (a->all) {
        for (int i = 0; i < branch.n_point && !status; i++)
            status = verify_one(a, id, i);
        return status;
    }
    choose(id, branch.n_point, chosen);
    for (int i = 0; i < 3 + SAMPLE && !status; i++)
        if (i == 0 || chosen[i] != chosen[i - 1])
            status = verify_one(a, id, chosen[i]);
    return status;
}

static int print_audit(const audit *a, cli_format format)
{
    static const char *const columns[] = {
        "branch", "point", "flight_error", "return_error", "condition", "energy_error", "faces_agree", "passed", NULL};
    int code = cli_print_rows(a->rows, columns, format);
    fprintf(stderr, "%d of %d points on %d branch%s agree with the simulator\n", a->points - a->failed, a->points,
            a->branches, a->branches == 1 ? "" : "es");
    return code ? code : a->failed ? CLI_FAILED : CLI_DONE;
}

static int run(int argc, char **argv)
{
    cli_format format;
    const char *text;
    long branch = 0;
    ric_atlas *atlas = NULL;
    audit a = {0};
    a.all = cli_take_flag(&argc, argv, "--all");
    if (!cli_take_format(&argc, argv, &format) || !cli_take_value(&argc, argv, "--branch", &text) ||
        !cli_operands(&cli_verify, argc, argv, 1) ||
        (text && !cli_parse_integer(text, "--branch", 1, INT_MAX, &branch)))
        return CLI_WRONG;
    ric_status status = ric_atlas_read(argv[1], &atlas);
    if (!status) {
        a.atlas = atlas;
        if (!(a.rows = json_array()))
            status = RIC_E_NOMEM;
    }
    if (!status && branch)
        status = verify_branch(&a, (int)branch);
    for (int id = 1; !status && !branch && id <= ric_atlas_n_branch(atlas); id++)
        status = verify_branch(&a, id);
    int code = status ? cli_report(status) : print_audit(&a, format);
    json_decref(a.rows);
    ric_atlas_free(atlas);
    return code;
}

const cli_command cli_verify = {
    .name = "verify",
    .summary = "replay the orbits of an atlas with an independent simulator",
    .help =
        "usage: ricochet verify ATLAS [--branch ID] [--all] [--json | --csv]\n"
        "\n"
        "Replays the first, the middle and the last point of every branch and five more with a simulator that\n"
        "knows only the masses, the stiffnesses, the stops and the stored state, and finds every impact\n"
        "itself.\n"
        "\n"
        "  flight_error   largest relative error of the time and the end of a flight; at most 1e-11\n"
        "  return_error   relative distance from the start after one period; at most 1e-9 max(1, 1e-7\n"
        "                 condition); none at a corner\n"
        "  condition      largest modulus of a multiplier: what one period makes of a small error; more where\n"
        "                 slow impacts amplify the simulator's own rounding on the way beyond that\n"
        "  energy_error   relative error of the energy; at most 1e-11\n"
        "  faces_agree    whether the faces of the word are met in their order, and no other\n"
        "  --branch ID    only this branch\n"
        "  --all          every stored point\n"
        "\n"
        "The exit code is 1 if a point does not pass.\n"
        "\n"
        "example: ricochet verify study.ricochet --branch 3 --all\n",
    .run = run,
};
