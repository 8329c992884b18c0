#define _POSIX_C_SOURCE 200809L

#include "locus.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

bool cli_locus_take(int *argc, char **argv, const char *what, cli_locus_request *r)
{
    const char *junction, *values, *step;
    long id = 0;
    *r = (cli_locus_request){.junction = 0};
    if (!cli_take_value(argc, argv, "--junction", &junction) ||
        !cli_take_value(argc, argv, "--study", &r->study) ||
        !cli_take_value(argc, argv, "--values", &values) ||
        !cli_take_value(argc, argv, "--max-step", &step))
        return false;
    if (!junction) {
        cli_wrong("%s: --junction is missing; `ricochet junctions ATLAS` lists them", what);
        return false;
    }
    if (!cli_parse_integer(junction, "--junction", 1, INT_MAX, &id) ||
        (values && !cli_parse_list(values, "--values", CLI_LOCUS_VALUES, &r->n_value, r->values)) ||
        (step && !cli_parse_number(step, "--max-step", &r->max_step)))
        return false;
    r->junction = (int)id;
    if (!step || (r->max_step > 0 && r->max_step <= 1)) return true;
    cli_wrong("%s: --max-step %s is not above 0 and at most 1", what, step);
    return false;
}

typedef struct {
    cli_progress line;
    const char *name;
} display;

static bool show_progress(int points, double value, void *user)
{
    display *d = user;
    if (cli_progress_due(&d->line))
        fprintf(stderr, "%d point%s, %s = %.6g", points, cli_plural(points), d->name, value);
    return cli_stopped();
}

/* Section vary of another study of the same structure. */
static int take_vary(const char *path, const cli_locus_request *r, cli_locus *x)
{
    const ric_study *study = ric_atlas_study(x->atlas);
    if (r->study) {
        const int code = cli_read_study(r->study, &x->study);
        if (code) return code;
        study = x->study;
        if (!ric_model_same(ric_study_model(study), ric_atlas_model(x->atlas)))
            return cli_wrong("locus: %s is a study of another structure than %s", r->study, path);
    }
    if (ric_study_vary(study, &x->vary)) return CLI_DONE;
    return cli_wrong(
        "locus: %s has no section vary, which says what the parameter changes; write for example\n"
        "  vary: {name: k2, at: 1, from: 0.5, to: 2, stiffness: [[1, -1], [-1, 1]]}\n"
        "into a study and name it with --study",
        r->study ? r->study : "the study of the atlas");
}

int cli_locus_open(const char *path, const cli_locus_request *r, cli_locus *x)
{
    display shown = {.line = cli_progress_begin()};
    ric_locus_options options;
    *x = (cli_locus){.atlas = NULL};
    ric_status status = ric_atlas_read(path, &x->atlas);
    if (status) return cli_report(status);
    const int code = take_vary(path, r, x);
    if (code) return code;
    ric_locus_options_init(&options);
    options.n_value = r->n_value;
    options.values = r->values;
    options.max_step = r->max_step;
    options.progress = show_progress;
    options.user = &shown;
    shown.name = x->vary.name;
    cli_catch_signals();
    status = ric_locus_follow(x->atlas, &x->vary, r->junction, &options, &x->locus);
    cli_progress_end(&shown.line);
    return status == RIC_E_INTERRUPTED ? CLI_INTERRUPTED : cli_report(status);
}

void cli_locus_close(cli_locus *x)
{
    ric_locus_free(x->locus);
    ric_study_free(x->study);
    ric_atlas_free(x->atlas);
}
