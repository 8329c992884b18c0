/* The options of a study as text: commented lines of a new study, tables of docs/study.md. */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <string.h>

#include "options.h"
#include "base/room.h"

#define TEXT_OF(value) #value
#define TEXT(macro) TEXT_OF(macro)

static void write_default(const ric_option *option, size_t size, char *text)
{
    ric_explore_options defaults;
    ric_forcing forcing;
    ric_explore_options_init(&defaults);
    ric_option_forcing_init(&forcing);
    text[0] = '\0';
    if (!strcmp(option->section, "forcing")) return; /* what is not given is not there */
    FILE *out = fmemopen(text, size, "w");
    if (!out) return;
    ric_option_write(option, ric_option_is_forcing(option) ? (const void *)&forcing : &defaults,
                     out);
    fclose(out);
}

void ric_options_template(const char *section, FILE *out)
{
    char value[64], line[96];
    int n;
    const ric_option *list = ric_options_list(&n);
    for (int i = 0; i < n; i++) {
        const ric_option *option = &list[i];
        if (strcmp(option->section, section) || ric_option_is_forcing(option)) continue;
        write_default(option, sizeof value, value);
        snprintf(line, sizeof line, "%s%s: %s", section[0] ? "  " : "", option->key, value);
        fprintf(out, "%-26s # %s%s%s%s\n", line, option->help, option->unit[0] ? " (" : "",
                option->unit, option->unit[0] ? ")" : "");
    }
}

static const char *type_text(ric_option_type type)
{
    switch (type) {
    case RIC_OPTION_REAL: return "number";
    case RIC_OPTION_INTEGER: return "whole number";
    case RIC_OPTION_SWITCH: return "true or false";
    case RIC_OPTION_WINDOW: return "[lower, upper] or `auto`";
    case RIC_OPTION_MODES: return "`modes` or a list";
    case RIC_OPTION_NUMBERS: return "list of up to " TEXT(RIC_NUMBERS_MAX) " numbers";
    case RIC_OPTION_CASCADE: return "`all` or a list";
    case RIC_OPTION_TONGUES: return "`follow` or `cross`";
    case RIC_OPTION_BAND: return "number or [lower, upper]";
    case RIC_OPTION_AMOUNTS: return "number, or a list of up to " TEXT(RIC_NUMBERS_MAX);
    case RIC_OPTION_WHOLES: return "whole number, or a list of up to " TEXT(RIC_NUMBERS_MAX);
    }
    return "";
}

static void document_table(bool forcing, FILE *out)
{
    char value[64], range[64];
    fputs("| key | type | default | allowed | unit | meaning |\n|---|---|---|---|---|---|\n", out);
    int n;
    const ric_option *list = ric_options_list(&n);
    for (int i = 0; i < n; i++) {
        const ric_option *option = &list[i];
        if (ric_option_is_forcing(option) != forcing) continue;
        write_default(option, sizeof value, value);
        ric_option_range(option, sizeof range, range);
        const bool words = option->type == RIC_OPTION_SWITCH || option->type == RIC_OPTION_TONGUES;
        const char *quote = value[0] ? "`" : "";
        fprintf(out, "| `%s%s%s` | %s | %s%s%s | %s | %s | %s |\n", option->section,
                option->section[0] ? "." : "", option->key, type_text(option->type), quote,
                value[0] ? value : "none", quote, words ? "" : range, option->unit, option->help);
    }
}

void ric_options_document(FILE *out)
{
    fputs("## explore\n\n"
          "Keys of the section `explore` of a study, and one at its top. All are optional.\n\n",
          out);
    document_table(false, out);
    fputs("\n## forcing\n\n"
          "What shakes the structure, and what it loses: [damping and force](forcing.md).\n"
          "`simulate`, `force` and `response` take it where their options say nothing else.\n"
          "The atlas is that of the structure without losses and force, whatever stands here:\n"
          "an atlas stays that of its study when these keys change.\n"
          "`ricochet run` once more takes the new keys into it, and so does `--study` of `force` "
          "and `response`.\n\n"
          "```yaml\n"
          "damping: 0.01             # ratio of all modes; [0.01, 0.02]: of each; {alpha: 0.1, "
          "beta: 1.0e-4}: alpha M + "
          "beta K;\n"
          "                          # or a matrix, rows or {file: C.mtx}\n"
          "restitution: 0.95\n"
          "forcing:\n"
          "  vector: [1, 0]          # f, one number per displacement; or coordinate: 1\n"
          "  amplitude: [0.1, 0.2]\n"
          "  frequency: [0.5, 2]\n"
          "  harmonic: 1\n"
          "```\n\n"
          "`damping` takes no energy where it is not given; no ratio is negative, and a matrix is "
          "symmetric without a\n"
          "negative eigenvalue.\n"
          "`forcing` needs `vector` or `coordinate`.\n\n",
          out);
    document_table(true, out);
    fputs("\n## regions\n\n"
          "Larger budgets for a part of the plane, in a list at the top of a study;\n"
          "`ricochet view` writes such regions into its atlas.\n\n"
          "```yaml\n"
          "regions:\n"
          "  - {energy: [1.5, 3], frequency: [1.7, 1.9], depth: 6, impacts: 36, multiply: 2}\n"
          "```\n\n"
          "`energy` and `frequency` say where.\n"
          "`depth`, `impacts` and `multiply` hold for departures from junctions that are there, "
          "drawn there\n"
          "or with their orbit there, if they are larger than those of `explore`,\n"
          "and are those of `explore` where they are not given.\n"
          "Departures elsewhere stay over their budgets and are counted so.\n"
          "A region may lie outside the windows: branches are then followed as far as the\n"
          "smallest windows that hold it too, linear modes start there,\n"
          "and departures from junctions in neither are `outside the windows`.\n"
          "At most " TEXT(RIC_REGIONS_MAX) " regions, and none with `explore.cascade`.\n",
          out);
}
