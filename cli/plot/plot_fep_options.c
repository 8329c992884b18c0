/* The options of the frequency-energy plot. */
#define _POSIX_C_SOURCE 200809L

#include <stdlib.h>
#include <string.h>

#include "plot_fep.h"

const char *const fep_questions[ASK_N] = {"--branch", "--duplicate", "--base",
                                          "--label",  "--mark",      "--key"};

/* --zoom E0:E1,F0:F1 */
static bool take_zoom(const char *text, const fep_options *o, double out[4])
{
    if (!plot_parse_window(text, "--zoom", out)) return false;
    if (out[0] > 0 || !o->log_energy) return true;
    cli_wrong("--zoom %s: a logarithmic axis starts above 0", text);
    return false;
}

static int take_zooms(int *argc, char **argv, fep_options *o)
{
    for (const char *text = "";;) {
        if (!cli_take_value(argc, argv, "--zoom", &text)) return CLI_WRONG;
        if (!text) return CLI_DONE;
        if (o->n_zoom == FEP_MAX_PANEL - 1)
            return cli_wrong("--zoom: at most %d panels fit beside the first", FEP_MAX_PANEL - 1);
        if (!take_zoom(text, o, o->zoom[o->n_zoom++])) return CLI_WRONG;
    }
}

/* --frame 'NAME: E0:E1,F0:F1' */
static int take_frames(int *argc, char **argv, fep_options *o)
{
    for (const char *text = "";;) {
        if (!cli_take_value(argc, argv, "--frame", &text)) return CLI_WRONG;
        if (!text) return CLI_DONE;
        if (o->n_frame == FEP_MAX_PANEL) return cli_wrong("--frame: at most %d fit", FEP_MAX_PANEL);
        const char *named = strstr(text, ": ");
        if (!plot_parse_window(named ? named + 2 : text, "--frame", o->frame[o->n_frame]))
            return CLI_WRONG;
        o->frame_name[o->n_frame++] = named ? text : NULL;
    }
}

static bool asks(const char *word, const char *name, const char **value)
{
    const size_t n = strlen(name);
    if (strncmp(word, name, n) || (word[n] && word[n] != '=')) return false;
    *value = word[n] ? word + n + 1 : NULL;
    return true;
}

/* Atlases, and the options that belong to them by their order. */
static int take_asked(int argc, char **argv, fep_options *o)
{
    for (int i = 1; i < argc; i++) {
        fep_asked a = {.what = ASK_N, .atlas = o->n_atlas - 1};
        for (int k = 0; k < ASK_N && a.what == ASK_N; k++)
            if (asks(argv[i], fep_questions[k], &a.text)) a.what = (fep_question)k;
        if (a.what == ASK_N && argv[i][0] == '-' && argv[i][1]) /* says what is wrong with it */
            return cli_operands(&cli_plot, argc, argv, 1) ? CLI_DONE : CLI_WRONG;
        if (a.what == ASK_N) {
            if (o->n_atlas == FEP_MAX_ATLAS)
                return cli_wrong("plot fep: at most %d atlases can be told apart", FEP_MAX_ATLAS);
            o->paths[o->n_atlas++] = argv[i];
            continue;
        }
        if (!a.text && i + 1 < argc) a.text = argv[++i];
        if (!a.text || !*a.text)
            return cli_wrong("%s needs a value; see ricochet plot --help", fep_questions[a.what]);
        if (o->n_asked == FEP_MAX_ASKED)
            return cli_wrong("plot fep: more than %d branches, labels and marks", FEP_MAX_ASKED);
        o->asked[o->n_asked++] = a;
    }
    if (o->n_atlas == 0) return cli_operands(&cli_plot, 1, argv, 1) ? CLI_DONE : CLI_WRONG;
    for (int i = 0; i < o->n_asked; i++) {
        if (o->asked[i].atlas < 0 && o->n_atlas > 1)
            return cli_wrong(
                "%s %s: with several atlases this stands behind the one that it belongs to",
                fep_questions[o->asked[i].what], o->asked[i].text);
        o->asked[i].atlas = o->asked[i].atlas < 0 ? 0 : o->asked[i].atlas;
        o->n_duplicate += o->asked[i].what == ASK_DUPLICATE || o->asked[i].what == ASK_BASE;
        o->n_label += o->asked[i].what == ASK_LABEL;
    }
    return CLI_DONE;
}

int fep_parse_options(int *argc, char **argv, fep_options *o)
{
    const char *energy = NULL, *frequency = NULL, *knee = NULL, *labels = NULL, *marks = NULL,
               *duplicates = NULL;
    o->linear = cli_take_flag(argc, argv, "--linear");
    o->log_energy = cli_take_flag(argc, argv, "--log");
    o->linear_frequency = cli_take_flag(argc, argv, "--linear-frequency");
    o->ghosts = cli_take_flag(argc, argv, "--ghosts");
    o->symmetric = cli_take_flag(argc, argv, "--symmetric");
    o->arrows = cli_take_flag(argc, argv, "--arrows");
    o->log_frequency = cli_take_flag(argc, argv, "--log-frequency");
    if (!cli_take_value(argc, argv, "--energy", &energy) ||
        !cli_take_value(argc, argv, "--frequency", &frequency) ||
        !cli_take_value(argc, argv, "--break", &knee) ||
        !cli_take_value(argc, argv, "--labels", &labels) ||
        !cli_take_value(argc, argv, "--marks", &marks) ||
        !cli_take_value(argc, argv, "--data", &o->data) ||
        !cli_take_value(argc, argv, "--duplicates", &duplicates) ||
        !cli_take_value(argc, argv, "--letters", &o->letters) ||
        take_zooms(argc, argv, o) != CLI_DONE || take_frames(argc, argv, o) != CLI_DONE)
        return CLI_WRONG;
    o->duplicates = 1;
    if ((energy && !plot_parse_range(energy, "--energy", o->energy)) ||
        (frequency && !plot_parse_range(frequency, "--frequency", o->frequency)) ||
        (knee && !cli_parse_number(knee, "--break", &o->knee)) ||
        (duplicates && !cli_parse_integer(duplicates, "--duplicates", 1, 100, &o->duplicates)))
        return CLI_WRONG;
    o->has_energy = energy;
    o->has_frequency = frequency;
    o->has_break = knee;
    if (o->linear && o->log_energy)
        return cli_wrong("--linear and --log: one of them, of the energies");
    if (energy && o->log_energy && o->energy[0] <= 0)
        return cli_wrong(
            "--energy %s: a logarithmic axis starts above 0; give a positive start or --linear",
            energy);
    if (frequency && o->log_frequency && o->frequency[0] <= 0)
        return cli_wrong("--frequency %s: a logarithmic axis starts above 0", frequency);
    if (knee && !(o->knee > 0))
        return cli_wrong("--break %s: the frequency of the break must be positive", knee);
    if ((knee != NULL) + o->log_frequency + o->linear_frequency > 1)
        return cli_wrong("--break, --log-frequency and --linear-frequency: the axis is broken, "
                         "logarithmic or linear throughout");
    static const char *const choices[] = {"", "all", "named", "none"};
    for (int i = LABELS_ALL; labels && i <= LABELS_NONE; i++)
        if (!strcmp(labels, choices[i])) o->labels = (fep_labels)i;
    if (labels && o->labels == LABELS_MAIN)
        return cli_wrong("--labels %s: there are all, named and none; --label NAME asks for one",
                         labels);
    static const char *const which[] = {"main", "all", "asked", "none"};
    o->marks = (fep_marks)-1;
    for (int i = MARKS_MAIN; i <= MARKS_NONE; i++)
        if (!strcmp(marks ? marks : "main", which[i])) o->marks = (fep_marks)i;
    if (o->marks == (fep_marks)-1)
        return cli_wrong("--marks %s: there are main, all, asked and none", marks);
    const int code = take_asked(*argc, argv, o);
    if (code == CLI_DONE && o->arrows && o->duplicates < 2)
        return cli_wrong("--arrows: between duplicates; goes with --duplicates K");
    if (code == CLI_DONE && o->n_label && !labels) o->labels = LABELS_ASKED;
    return code;
}
