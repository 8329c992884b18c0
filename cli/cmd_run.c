/* ricochet run STUDY: explores a study into an atlas. */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "../src/crew.h"
#include "../src/study.h"
#include "cli.h"

const ric_crew *cli_run_crew = NULL;

/* ---------------------------------------------------------------- progress */

typedef struct {
    bool terminal;
    struct timespec start, shown;
} display;

static double seconds_since(const struct timespec *then)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - then->tv_sec) + 1e-9 * (double)(now.tv_nsec - then->tv_nsec);
}

static bool show_progress(const ric_progress *now, void *user)
{
    display *d = user;
    if (d->terminal && seconds_since(&d->shown) > 0.1) {
        fprintf(stderr, "\r\033[K%d branches, %d junctions, %d open departures, depth %d, %.0f s", now->branches, now->junctions, now->open,
                now->depth, now->seconds);
        fflush(stderr);
        clock_gettime(CLOCK_MONOTONIC, &d->shown);
    }
    return cli_stopped();
}

static void clear_progress(const display *d)
{
    if (d->terminal)
        fputs("\r\033[K", stderr);
}

/* ----------------------------------------------------------------- summary */

static int print_summary(const char *path, const display *d)
{
    static const ric_stop reasons[] = {RIC_STOP_FAILED, RIC_STOP_BUDGET, RIC_STOP_CORNER};
    ric_atlas *atlas = NULL;
    int counts[sizeof reasons / sizeof *reasons] = {0};
    ric_status status = ric_atlas_read(path, &atlas);
    if (status)
        return cli_report(status);
    int n = ric_atlas_n_branch(atlas);
    for (int id = 1; id <= n; id++) {
        ric_branch branch;
        if (ric_atlas_branch(atlas, id, &branch))
            continue;
        for (size_t i = 0; i < sizeof reasons / sizeof *reasons; i++)
            counts[i] += branch.stop == reasons[i];
    }
    fprintf(stderr, "%s: %d branches, %d junctions, %.1f s\n", path, n, ric_atlas_n_junction(atlas), seconds_since(&d->start));
    for (size_t i = 0; i < sizeof reasons / sizeof *reasons; i++)
        if (counts[i])
            fprintf(stderr, "%d branch%s stopped at: %s; `ricochet branches` says where\n", counts[i], counts[i] == 1 ? "" : "es",
                    ric_stop_text(reasons[i]));
    int missing = ric_atlas_n_unplaced(atlas);
    if (missing)
        fprintf(stderr, "%d event%s on branches do%s not converge and make%s no junction; `why` in `ricochet branches --json` says where\n",
                missing, missing == 1 ? "" : "s", missing == 1 ? "es" : "", missing == 1 ? "s" : "");
    ric_atlas_free(atlas);
    return CLI_DONE;
}

/* ----------------------------------------------------------------- command */

/* study.yaml -> study.ricochet; the caller frees it. */
static char *default_path(const char *study)
{
    static const char *const endings[] = {".yaml", ".yml"};
    size_t length = strlen(study);
    char *path = malloc(length + sizeof ".ricochet");
    if (!path)
        return NULL;
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        size_t ending = strlen(endings[i]);
        if (length > ending && !strcmp(study + length - ending, endings[i]) && study[length - ending - 1] != '/') {
            length -= ending;
            break;
        }
    }
    snprintf(path, length + sizeof ".ricochet", "%.*s.ricochet", (int)length, study);
    return path;
}

static int explore(const ric_study *study, const char *path, long workers)
{
    display d = {.terminal = isatty(STDERR_FILENO)};
    clock_gettime(CLOCK_MONOTONIC, &d.start);
    ric_run_options options = {.workers = (int)workers, .progress = show_progress, .user = &d};
    cli_catch_signals();
    ric_status status = ric_explore_with(study, path, &options, cli_run_crew);
    clear_progress(&d);
    if (status == RIC_E_INTERRUPTED) {
        fprintf(stderr, "ricochet: stopped; what was done is kept in %s, and the same command continues there\n", path);
        return CLI_FAILED;
    }
    return status ? cli_report(status) : print_summary(path, &d);
}

static int run(int argc, char **argv)
{
    const char *given, *workers_text, *step;
    char *path = NULL;
    long workers = 1;
    ric_study *study = NULL;
    int code;
    if (!cli_take_value(&argc, argv, "-o", &given) || !cli_take_value(&argc, argv, "-j", &workers_text)
        || !cli_take_value(&argc, argv, "--max-step", &step) || !cli_operands(&cli_run, argc, argv, 1)
        || (workers_text && !cli_parse_integer(workers_text, "-j", 1, 1024, &workers)))
        return CLI_WRONG;
    ric_status status = ric_study_read(argv[1], &study);
    if (!status && step)
        status = ric_study_override(study, "explore", "step", step, "--max-step");
    if (!status && !(path = given ? strdup(given) : default_path(argv[1])))
        status = RIC_E_NOMEM;
    if (status)
        code = cli_report(status);
    else if (!strcmp(path, argv[1]))
        code = cli_wrong("run: the atlas %s would overwrite the study; choose another name with -o", path);
    else if (ric_model_restitution(ric_study_model(study)) < 1)
        code = cli_wrong("%s:%zu: model.restitution: %g loses energy, so that there are no families of periodic orbits; an atlas needs 1, "
                         "`ricochet simulate` takes [0, 1]", argv[1], ric_study_restitution_line(study),
                         ric_model_restitution(ric_study_model(study)));
    else
        code = explore(study, path, workers);
    free(path);
    ric_study_free(study);
    return code;
}

const cli_command cli_run = {
    .name = "run",
    .summary = "explore a study into an atlas",
    .help =
        "usage: ricochet run STUDY [-o ATLAS] [-j WORKERS] [--max-step H]\n"
        "\n"
        "Explores from the linear modes within the budgets of the study and writes the atlas, one file. Stopped with Ctrl-C, or killed, the\n"
        "same command continues; with larger budgets in the study it extends the atlas. The result does not depend on WORKERS.\n"
        "\n"
        "  -o ATLAS       the file to write; study.ricochet for study.yaml unless given\n"
        "  -j WORKERS     how many at a time, 1 unless given\n"
        "  --max-step H   largest arclength step, instead of the study's explore.step\n"
        "\n"
        "example: ricochet run examples/elementary/study.yaml -o two-masses.ricochet\n",
    .run = run,
};
