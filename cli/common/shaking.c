/* What shakes a structure, as it is named on the command line. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shaking.h"
#include "study/matrix_market.h"

/* "1,0,2": *n numbers in out [most]. */
static bool parse_harmonics(const char *text, cli_shaking *ask)
{
    double values[CLI_HARMONICS_MOST];
    ask->n_harmonic = ask->harmonics[0] = 1;
    ask->harmonic_given = text;
    if (!text) return true;
    if (!cli_parse_list(text, "--harmonic", CLI_HARMONICS_MOST, &ask->n_harmonic, values))
        return false;
    for (int i = 0; i < ask->n_harmonic; i++) {
        if (!(values[i] >= 1 && values[i] <= 10000 && values[i] == floor(values[i]))) {
            cli_wrong("--harmonic %s: harmonics of the orbit are whole numbers from 1 to 10000",
                      text);
            return false;
        }
        ask->harmonics[i] = (int)values[i];
    }
    return true;
}

/* Ratios, or what else stands there is a file with a matrix. *code: that of a file that cannot be
 * read. */
static bool parse_damping(const char *text, cli_shaking *ask, int *code)
{
    if (!text) return true;
    if (strspn(text, "0123456789.,+-eE") == strlen(text))
        return cli_parse_list(text, "--damping", CLI_NUMBERS_MOST, &ask->n_ratio, ask->ratios);
    ric_status status = ric_matrix_market_read(text, &ask->n_matrix, &ask->matrix, NULL);
    if (status) *code = cli_report(status);
    return !status;
}

/* *code: the exit code where it is not that of a wrong call. */
bool cli_take_shaking(int *argc, char **argv, cli_shaking *out, int *code)
{
    const char *force, *damping, *restitution, *harmonic;
    *code = CLI_WRONG;
    out->restitution = 1;
    return cli_take_value(argc, argv, "--force", &force) &&
           cli_take_value(argc, argv, "--damping", &damping) &&
           cli_take_value(argc, argv, "--restitution", &restitution) &&
           cli_take_value(argc, argv, "--harmonic", &harmonic) &&
           (!force ||
            cli_parse_list(force, "--force", CLI_NUMBERS_MOST, &out->n_force, out->force)) &&
           parse_harmonics(harmonic, out) &&
           (!restitution || cli_parse_list(restitution, "--restitution", 2, &out->n_restitution,
                                           out->restitutions)) &&
           ((out->restitution = out->n_restitution ? out->restitutions[out->n_restitution - 1] : 1),
            true) &&
           parse_damping(damping, out, code);
}

static double *copy_of(size_t n, const double *x)
{
    double *out = malloc((n + 1) * sizeof *out);
    if (out) memcpy(out, x, n * sizeof *out);
    return out;
}

static bool complete(cli_shaking *s, const ric_study *study)
{
    ric_forcing of;
    if (!ric_study_forcing(study, &of)) return true;
    const ric_shaking *h = &of.shaking;
    if (!s->n_force)
        memcpy(s->force, h->force, (size_t)(s->n_force = h->n_force) * sizeof *s->force);
    if (!s->n_ratio && !s->n_matrix) {
        memcpy(s->ratios, h->ratios, (size_t)(s->n_ratio = h->n_ratio) * sizeof *s->ratios);
        s->n_matrix = h->n_matrix;
        if (h->n_matrix &&
            !(s->matrix = copy_of((size_t)h->n_matrix * (size_t)h->n_matrix, h->matrix)))
            return false;
    }
    if (!s->n_restitution) s->restitution = h->restitution;
    for (int i = 0; !s->harmonic_given && i < of.harmonic.n; i++) {
        s->harmonics[i] = (int)of.harmonic.value[i];
        s->n_harmonic = i + 1;
    }
    s->amplitude = of.amplitude;
    memcpy(s->frequency, of.frequency, sizeof s->frequency);
    return true;
}

int cli_shaking_read(cli_shaking *s, const char *command, const char *path, const ric_study *own)
{
    ric_study *other = NULL;
    int code = path ? cli_read_study(path, &other) : CLI_DONE;
    if (!code && path && !ric_model_same(ric_study_model(other), ric_study_model(own)))
        code = cli_wrong("%s: --study %s is a study of another structure than that of the atlas",
                         command, path);
    if (!code && !complete(s, path ? other : own)) code = cli_report(RIC_E_NOMEM);
    ric_study_free(other);
    return code;
}

#define WITHOUT                                                                                    \
    " that of the structure without losses and force; what the study says of them is taken by "    \
    "`ricochet simulate`, "                                                                        \
    "`force` and `response`"

const char *cli_forcing_remark(const ric_study *study)
{
    ric_forcing forcing;
    return ric_study_forcing(study, &forcing) ? "the atlas is" WITHOUT : "";
}

void cli_forcing_warn(const ric_study *study, const char *name, const char *what)
{
    ric_forcing forcing;
    if (ric_study_forcing(study, &forcing)) cli_say("ricochet: %s: %s is" WITHOUT "\n", name, what);
}

ric_shaking cli_shaking_of(const cli_shaking *s)
{
    return (ric_shaking){.n_force = s->n_force,
                         .force = s->n_force ? s->force : NULL,
                         .n_ratio = s->n_ratio,
                         .ratios = s->n_ratio ? s->ratios : NULL,
                         .n_matrix = s->n_matrix,
                         .matrix = s->matrix,
                         .restitution = s->restitution};
}

void cli_shaking_free(cli_shaking *s)
{
    free(s->matrix);
}

/* --------------------------------------------------------------- one motion */

bool cli_take_drive(int *argc, char **argv, cli_drive *d, int *code)
{
    const char *omega, *level, *phase;
    d->level = NAN;
    return cli_take_shaking(argc, argv, &d->shaking, code) &&
           cli_take_value(argc, argv, "--omega", &omega) &&
           cli_take_value(argc, argv, "--level", &level) &&
           cli_take_value(argc, argv, "--phase", &phase) &&
           (!omega || cli_parse_number(omega, "--omega", &d->omega)) &&
           (!level || cli_parse_number(level, "--level", &d->level)) &&
           (!phase || cli_parse_number(phase, "--phase", &d->phase)) &&
           ((d->phased = omega || level || phase), (d->still = omega && d->omega == 0), true);
}

/* The one frequency and the one level of the force: of the options, or of the study. */
static int place_force(cli_drive *d, const char *command)
{
    const cli_shaking *h = &d->shaking;
    if (d->still)
        return cli_wrong("%s: --omega 0 is a force that does not change; give its frequency in "
                         "rad/s, above 0, or --level 0 alone for no force",
                         command);
    if (d->omega == 0 && h->frequency[0] == h->frequency[1]) d->omega = h->frequency[0];
    if (isnan(d->level) && h->amplitude.n > 1)
        return cli_wrong("%s: the study has %d amplitudes of the force; --level L says which",
                         command, h->amplitude.n);
    if (isnan(d->level)) d->level = h->amplitude.n ? h->amplitude.value[0] : 1;
    if (d->omega == 0 && d->level != 0)
        return cli_wrong("%s: %s needs --omega W, the frequency of the force in rad/s%s", command,
                         d->own_force ? "--force" : "the force of the study",
                         d->own_force ? "" : "; --level 0 leaves the force out");
    return CLI_DONE;
}

int cli_drive_complete(cli_drive *d, const char *command, const ric_study *study)
{
    cli_shaking *h = &d->shaking;
    d->own_force = h->n_force;
    if (!complete(h, study)) return cli_report(RIC_E_NOMEM);
    if (d->phased && !h->n_force)
        return cli_wrong("%s: --omega, --level and --phase go with --force F1,F2,..", command);
    d->is_shaken = h->n_force || h->n_ratio || h->n_matrix || h->n_restitution;
    const int code = h->n_force ? place_force(d, command) : CLI_DONE;
    if (code || !d->is_shaken) return code;
    ric_shaking shaking = cli_shaking_of(h);
    return cli_report(ric_force_check(ric_study_model(study), &shaking));
}

ric_status cli_drive_start(const cli_drive *d, const ric_model *model, const double *state,
                           ric_shaken **out)
{
    const ric_shaking shaking = cli_shaking_of(&d->shaking);
    const ric_status status = ric_shaken_create(model, &shaking, d->omega, d->level, out);
    return status ? status
                  : ric_shaken_start(*out, state, state + ric_model_n_dof(model), d->phase);
}
