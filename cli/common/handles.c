/* What a branch or a junction goes by: its id, its key or the beginning of one, its name, its
 * label, or a place. Commands take ids; here the arguments are gone through once, before the
 * command sees them, so that all take all. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "plot/plot.h"

enum {
    CANDIDATES = 6, /* that a message lists */
    FEWEST = 2,     /* letters of a key that are taken for the beginning of one */
    MORE = 3        /* arguments that --at may bring: an option, its value, and NULL behind all */
};

/* Distances in the plane of logarithms, so relative ones: from which on the nearest is far, and by
 * how much the next has to be farther for the nearest to be meant. */
static const double far = 1e-2, told_apart = 1e-3, rounding = 1e-6;

/* ---------------------------------------------------------------------- rows */

static int total(const ric_atlas *atlas, bool branch)
{
    return branch ? ric_atlas_n_branch(atlas) : ric_atlas_n_junction(atlas);
}

/* The key of a row, and, unless it is NULL, a line that shows what it is. */
static const char *row_key(const ric_atlas *atlas, bool branch, int id, size_t size, char *line)
{
    ric_branch b;
    ric_junction j;
    if (branch ? ric_atlas_branch(atlas, id, &b) : ric_atlas_junction(atlas, id, &j)) return "";
    if (line && branch)
        snprintf(line, size, "%s (id %d, %s, energy %.6g to %.6g)", b.key, id, b.label,
                 b.energy_min, b.energy_max);
    else if (line)
        snprintf(line, size, "%s (id %d, %s, energy %.6g, frequency %.6g)", j.key, id,
                 *j.name ? j.name : j.label, j.energy, j.frequency);
    return branch ? b.key : j.key;
}

static void add_candidate(const ric_atlas *atlas, bool branch, int id, int n, size_t size,
                          char *list)
{
    char line[400];
    size_t used = strlen(list);
    row_key(atlas, branch, id, sizeof line, line);
    if (n < CANDIDATES) snprintf(list + used, size - used, "%s%s", n ? "; " : "", line);
    else if (n == CANDIDATES) snprintf(list + used, size - used, "; ...");
}

/* ---------------------------------------------------------------------- keys */

static int find_key(const ric_atlas *atlas, bool branch, const char *text, const char *what,
                    int *id)
{
    char list[CANDIDATES * 420] = "";
    int found = 0;
    if (text[0] != (branch ? 'b' : 'j') || strlen(text) < FEWEST) return 0;
    for (int i = 1; i <= total(atlas, branch); i++) {
        const char *key = row_key(atlas, branch, i, 0, NULL);
        if (strncmp(key, text, strlen(text)) != 0) continue;
        *id = i;
        if (!strcmp(key, text)) return 1;
        add_candidate(atlas, branch, i, found++, sizeof list, list);
    }
    if (found > 1) cli_wrong("%s %s: %d keys begin like this: %s", what, text, found, list);
    return found > 1 ? -1 : found;
}

/* -------------------------------------------------------------------- places */

/* What is near to a place. */
typedef struct {
    double distance;
    int id, point;
} candidate;

static double logarithm(double x)
{
    return log(x > 1e-300 ? x : 1e-300);
}

/* From a place to the line between two others. */
static double to_line(const double at[2], const double a[2], const double b[2])
{
    const double d[2] = {b[0] - a[0], b[1] - a[1]}, length = d[0] * d[0] + d[1] * d[1];
    double t = length > 0 ? ((at[0] - a[0]) * d[0] + (at[1] - a[1]) * d[1]) / length : 0;
    t = fmin(fmax(t, 0), 1);
    return hypot(at[0] - a[0] - t * d[0], at[1] - a[1] - t * d[1]);
}

static candidate near_branch(const ric_atlas *atlas, int id, const double at[2])
{
    candidate out = {.distance = INFINITY, .id = id};
    double last[2] = {0, 0}, nearest = INFINITY;
    ric_branch b;
    ric_point p;
    if (ric_atlas_branch(atlas, id, &b)) return out;
    for (int i = 0; i < b.n_point && !ric_atlas_point(atlas, id, i, &p, NULL, NULL); i++) {
        const double here[2] = {logarithm(p.energy), logarithm(p.frequency)},
                     away = hypot(here[0] - at[0], here[1] - at[1]);
        out.distance = fmin(out.distance, i ? to_line(at, last, here) : away);
        if (away < nearest) out.point = i;
        nearest = fmin(nearest, away);
        memcpy(last, here, sizeof last);
    }
    return out;
}

static candidate near_junction(const ric_atlas *atlas, int id, const double at[2])
{
    ric_junction j;
    if (ric_atlas_junction(atlas, id, &j)) return (candidate){.distance = INFINITY, .id = id};
    return (candidate){hypot(logarithm(j.energy) - at[0], logarithm(j.frequency) - at[1]), id, 0};
}

static int compare_distances(const void *p, const void *q)
{
    const candidate *a = p, *b = q;
    return a->distance < b->distance ? -1 : a->distance > b->distance ? 1 : a->id - b->id;
}

static int choose_nearest(const ric_atlas *atlas, bool branch, const char *text, const char *what,
                          int n, candidate *all)
{
    const char *const word = branch ? "branch" : "junction";
    char list[CANDIDATES * 420] = "";
    int alike = 0;
    qsort(all, (size_t)n, sizeof *all, compare_distances);
    if (n == 0 || !isfinite(all[0].distance))
        return cli_wrong("%s %s: the atlas has no %s", what, text, word), -1;
    for (const double d = all[0].distance;
         alike < n && all[alike].distance <= d + fmin(d, told_apart) + rounding;)
        add_candidate(atlas, branch, all[alike].id, alike, sizeof list, list), alike++;
    if (alike > 1)
        return cli_wrong("%s %s: %d %s come equally near: %s", what, text, alike,
                         branch ? "branches" : "junctions", list),
               -1;
    if (all[0].distance > far)
        cli_say("ricochet: %s %s: nothing is there; the nearest %s, %s, is %.2g %% away\n", what,
                text, word, list, 100 * all[0].distance);
    return 1;
}

/* Whether the text is E,OMEGA: its two numbers. -1 with a message where they are not above 0. */
static int read_place(const char *text, const char *what, double out[2])
{
    char *end, *last;
    double e = strtod(text, &end), omega = *end == ',' ? strtod(end + 1, &last) : 0;
    if (end == text || *end != ',' || last == end + 1 || *last) return 0;
    if (!(e > 0 && omega > 0 && isfinite(e) && isfinite(omega)))
        return cli_wrong("%s %s: energy and frequency of a place are finite and above 0", what,
                         text),
               -1;
    out[0] = log(e);
    out[1] = log(omega);
    return 1;
}

static int find_place(const ric_atlas *atlas, bool branch, const char *text, const char *what,
                      int *id, int *point)
{
    double at[2];
    const int n = total(atlas, branch), is_place = read_place(text, what, at);
    if (is_place < 1) return is_place;
    candidate *all = calloc((size_t)n + 1, sizeof *all);
    if (!all) return cli_report(RIC_E_NOMEM), -1;
    for (int i = 0; i < n; i++)
        all[i] = branch ? near_branch(atlas, i + 1, at) : near_junction(atlas, i + 1, at);
    const int found = choose_nearest(atlas, branch, text, what, n, all);
    *id = all[0].id;
    if (point) *point = all[0].point;
    free(all);
    return found;
}

int cli_find_handle(const ric_atlas *atlas, bool branch, const char *text, const char *what,
                    int *id, int *point)
{
    const int found = find_key(atlas, branch, text, what, id);
    return found ? found : find_place(atlas, branch, text, what, id, point);
}

/* ----------------------------------------------------------------- arguments */

static bool is_option(const char *text, const char *name)
{
    const size_t n = strlen(name);
    return !strncmp(text, name, n) && (!text[n] || text[n] == '=');
}

/* Ids, and what is no whole number but begins like one, are the command's own business. */
static bool is_plain(const char *text)
{
    return strspn(text, "0123456789+-") > 0 && !strchr(text, ',');
}

/* Whether an argument stands for the value of the option before it. */
static bool is_value(const cli_command *command, char **argv, int i)
{
    if (argv[i - 1][0] != '-' || strchr(argv[i - 1], '=')) return false;
    for (const cli_item *item = command->items; item->text; item++)
        if (item->name && !strcmp(item->name, argv[i - 1])) return item->value != NULL;
    return false;
}

/* The first word that is neither an option nor the value of one. */
static const char *operand(const cli_command *command, int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (argv[i][0] != '-' && !is_value(command, argv, i)) return argv[i];
    return NULL;
}

/* The id that a handle stands for, and the point next to a place. */
static int resolve(const ric_atlas *atlas, bool branch, const char *text, const char *what, int *id,
                   int *point)
{
    plot_segment segment = {0};
    if (!strcmp(what, "--at")) {
        const int found = find_place(atlas, true, text, what, id, point);
        if (!found)
            cli_wrong("--at %s: write a scaled energy and a frequency in rad/s, --at 5,1.3", text);
        return found > 0 ? CLI_DONE : CLI_WRONG;
    }
    if (!branch) return plot_find_junction(atlas, text, what, id) ? CLI_DONE : CLI_WRONG;
    if (!plot_find_segment(atlas, text, what, &segment)) return CLI_WRONG;
    *id = segment.branch;
    return CLI_DONE;
}

/* Whether an orbit has been chosen; what wants none has no option --point. */
static bool wants_point(const cli_command *command, const cli_handles *h)
{
    const bool picture = cli_has_pictures(command);
    if (strcmp(picture ? h->argv[0] : command->name, "orbit") != 0) return false;
    for (int i = 1; i < h->argc; i++)
        if (is_option(h->argv[i], "--point") || is_option(h->argv[i], "--energy") ||
            is_option(h->argv[i], "--frequency"))
            return false;
    return true;
}

/* Argument i names something; n: of the new texts. */
static int replace(const cli_command *command, const ric_atlas *atlas, cli_handles *h, int *i,
                   int *n)
{
    static const char *const names[] = {"--branch", "--junction", "--at"};
    int k = 0, id = 0, point = -1;
    while (k < 3 && !is_option(h->argv[*i], names[k])) k++;
    const bool joined = k < 3 && strchr(h->argv[*i], '=') != NULL;
    if (k == 3 || (!joined && *i + 1 >= h->argc)) return CLI_DONE;
    char **value = &h->argv[*i + !joined];
    const char *text = joined ? strchr(*value, '=') + 1 : *value;
    if (k < 2 && (is_plain(text) || !*text)) return CLI_DONE;
    const int code = resolve(atlas, k != 1, text, names[k], &id, &point);
    if (code != CLI_DONE) return code;
    if (k == 2 && wants_point(command, h)) {
        snprintf(h->texts[*n], sizeof *h->texts, "--point=%d", point);
        h->argv[h->argc++] = h->texts[(*n)++];
        h->argv[h->argc] = NULL;
    }
    if (joined)
        snprintf(h->texts[*n], sizeof *h->texts, "--%s=%d", k == 1 ? "junction" : "branch", id);
    else snprintf(h->texts[*n], sizeof *h->texts, "%d", id);
    static char branch[] = "--branch";
    if (k == 2 && !joined) h->argv[*i] = branch;
    *value = h->texts[(*n)++];
    *i += !joined;
    return CLI_DONE;
}

/* Whether there is something to resolve, so that the atlas is read only then. */
static bool has_handles(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        const char *equals = strchr(argv[i], '='), *text = equals         ? equals + 1
                                                           : i + 1 < argc ? argv[i + 1]
                                                                          : "0";
        if (is_option(argv[i], "--at")) return true;
        if ((is_option(argv[i], "--branch") || is_option(argv[i], "--junction")) && *text &&
            !is_plain(text))
            return true;
    }
    return false;
}

static bool both_given(int argc, char **argv)
{
    int branch = 0, at = 0;
    for (int i = 1; i < argc; i++) {
        branch += is_option(argv[i], "--branch");
        at += is_option(argv[i], "--at");
    }
    return branch && at;
}

int cli_resolve_handles(const cli_command *command, cli_handles *h)
{
    ric_atlas *atlas = NULL;
    const char *path = operand(command, h->argc, h->argv);
    int code = CLI_DONE, n = 0;
    if (!has_handles(h->argc, h->argv)) return CLI_DONE;
    if (both_given(h->argc, h->argv))
        return cli_wrong("--branch and --at are both given; choose one");
    if (!path) {
        cli_wrong(
            "%s: 1 argument is missing: the atlas that --branch, --junction or --at looks into",
            command->name);
        cli_say_usage(command);
        return CLI_WRONG;
    }
    h->owned = calloc((size_t)h->argc + MORE, sizeof *h->owned);
    h->texts = calloc((size_t)h->argc + MORE, sizeof *h->texts);
    ric_status status = h->owned && h->texts ? ric_atlas_read(path, &atlas) : RIC_E_NOMEM;
    if (status) return cli_report(status);
    memcpy(h->owned, h->argv, (size_t)h->argc * sizeof *h->argv);
    h->argv = h->owned;
    const int argc = h->argc;
    for (int i = 1; i < argc && code == CLI_DONE; i++) code = replace(command, atlas, h, &i, &n);
    ric_atlas_free(atlas);
    return code;
}

void cli_handles_release(cli_handles *h)
{
    free(h->owned);
    free(h->texts);
}
