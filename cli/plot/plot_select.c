/* Junctions, branches, parts of branches and orbits, named as a reader of a picture names them:
 * C1_32, S6[010101], S6[010101]|C1_33 C3_32, C1_33*2, S4[0011]@E=20. */
#define _POSIX_C_SOURCE 200809L

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

enum { NAME = 160, SHOWN = 8 /* branches that are named where several fit */ };
/* As in plot_orbit.c: exact to rounding on a branch, with the error of its flights at a grazing. */
static const double touch_of_branch = 1e-9, touch_of_grazing = 1e-7;

static bool is_number(const char *text)
{
    return *text && text[strspn(text, "0123456789")] == '\0';
}

/* text[0 .. n) without spaces at its ends. */
static void trim(const char *text, size_t n, char out[NAME])
{
    while (n > 0 && isspace((unsigned char)*text)) {
        text++;
        n--;
    }
    while (n > 0 && isspace((unsigned char)text[n - 1])) n--;
    snprintf(out, NAME, "%.*s", (int)(n < NAME ? n : 0),
             text); /* a part of a name is another name */
}

/* ---------------------------------------------------------------- junctions */

bool plot_find_junction(const ric_atlas *atlas, const char *text, const char *what, int *id)
{
    const int total = ric_atlas_n_junction(atlas);
    ric_junction j;
    if (is_number(text)) {
        long number;
        if (!cli_parse_integer(text, what, 1, 2147483647, &number)) return false;
        *id = (int)number;
        return ric_atlas_junction(atlas, *id, &j) == RIC_OK ||
               (cli_wrong("%s %s: %s", what, text, ric_detail()), false);
    }
    for (int round = 0; round < 2;
         round++) /* a name of the study goes before a label, which may be another point's name */
        for (int i = 1; i <= total; i++) {
            if (ric_atlas_junction(atlas, i, &j) != RIC_OK) continue;
            const bool named = j.name && *j.name;
            if (strcmp(text, round == 0 ? named ? j.name : "" : named ? "" : j.label) == 0) {
                *id = i;
                return true;
            }
        }
    const int handle = cli_find_handle(atlas, false, text, what, id, NULL);
    if (!handle)
        cli_wrong("%s %s: no junction has this name, label or key; `ricochet junctions` lists them",
                  what, text);
    return handle > 0;
}

/* ----------------------------------------------------------------- branches */

/* A junction that a closed branch meets twice counts where it is met first. */
double plot_junction_at(const ric_atlas *atlas, const ric_branch *b, int junction)
{
    ric_point p;
    if (b->from == junction && ric_atlas_point(atlas, b->id, 0, &p, NULL, NULL) == RIC_OK)
        return p.arclength;
    for (int i = 0; i < b->n_junction; i++)
        if (b->junctions[i] == junction) return b->junction_at[i];
    if (b->to == junction &&
        ric_atlas_point(atlas, b->id, b->n_point - 1, &p, NULL, NULL) == RIC_OK)
        return p.arclength;
    return NAN;
}

static bool ends(const ric_atlas *atlas, const ric_branch *b, double s[2])
{
    ric_point first, last;
    if (b->n_point < 1 || ric_atlas_point(atlas, b->id, 0, &first, NULL, NULL) != RIC_OK ||
        ric_atlas_point(atlas, b->id, b->n_point - 1, &last, NULL, NULL) != RIC_OK)
        return false;
    s[0] = first.arclength;
    s[1] = last.arclength;
    return true;
}

bool plot_is_branch(const ric_atlas *atlas, const char *label)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b;
        char duplicate[400];
        if (ric_atlas_branch(atlas, id, &b) != RIC_OK) continue;
        for (int k = 1; k <= 100; k++)
            if (ric_duplicate_label(&b, k, sizeof duplicate, duplicate) == RIC_OK &&
                !strcmp(duplicate, label))
                return true;
    }
    return false;
}

/* "P1 P2" or "P1" of LABEL|P1 P2. */
static bool take_ends(const ric_atlas *atlas, const char *text, const char *what, int *n,
                      int junctions[2])
{
    *n = 0;
    while (*text) {
        text += strspn(text, " ");
        const size_t length = strcspn(text, " ");
        char name[NAME];
        trim(text, length, name);
        text += length;
        if (!*name) break;
        if (*n == 2) {
            cli_wrong("%s: a part of a branch lies between two junctions, not more", what);
            return false;
        }
        if (!plot_find_junction(atlas, name, what, &junctions[*n])) return false;
        ++*n;
    }
    return true;
}

/* Several that fit, the first of them by their ids. */
static void say_several(const char *what, const char *text, int found, const char *ids)
{
    cli_wrong("%s %s: %d branches fit, %s%s; give an id, name their ends as well, LABEL|P1 P2, or "
              "add #N for the Nth",
              what, text, found, ids, found > SHOWN ? " and more" : "");
}

/* No branch has the label, or meets these junctions as well; the first that begins so is named. */
static void say_none(const ric_atlas *atlas, const char *what, const char *text, const char *label,
                     bool ends)
{
    ric_branch b;
    const int total = ric_atlas_n_branch(atlas);
    int id = 1;
    while (id <= total && (ric_atlas_branch(atlas, id, &b) != RIC_OK || !*label ||
                           strncmp(b.label, label, strlen(label)) != 0))
        id++;
    if (!ends && id <= total)
        cli_wrong("%s %s: no branch has this label or key; '%s' begins so, and `ricochet branches` "
                  "lists all",
                  what, text, b.label);
    else
        cli_wrong("%s %s: no branch has this label or key%s; `ricochet branches` lists them", what,
                  text, ends ? " and meets these junctions" : "");
}

bool plot_find_segment(const ric_atlas *atlas, const char *text, const char *what,
                       plot_segment *out)
{
    const char *bar;
    char label[NAME];
    int n_end = 0, junctions[2], found = 0, by_handle = 0, total = ric_atlas_n_branch(atlas);
    char body[2 * NAME], ids[16 * SHOWN] = "";
    size_t used = 0;
    const char *number = strrchr(text, '#');
    long which = 0;
    if (number && !cli_parse_integer(number + 1, what, 1, 1000000, &which)) return false;
    snprintf(body, sizeof body, "%.*s", (int)(number ? number - text : (long)strlen(text)), text);
    bar = strchr(body, '|');
    trim(body, bar ? (size_t)(bar - body) : strlen(body), label);
    if (bar && !take_ends(atlas, bar + 1, what, &n_end, junctions)) return false;
    int handle = plot_is_branch(atlas, label)
                     ? 0
                     : cli_find_handle(atlas, true, label, what, &by_handle, NULL);
    if (handle < 0) return false;
    for (int id = 1; id <= total; id++) {
        ric_branch b;
        double s[2], at[2];
        if (ric_atlas_branch(atlas, id, &b) != RIC_OK || !ends(atlas, &b, s)) continue;
        if (handle             ? by_handle != id
            : is_number(label) ? atoi(label) != id
                               : strcmp(label, b.label) != 0)
            continue;
        for (int i = 0; i < n_end; i++) at[i] = plot_junction_at(atlas, &b, junctions[i]);
        if ((n_end > 0 && isnan(at[0])) || (n_end > 1 && isnan(at[1]))) continue;
        if (which && ++found != which) continue;
        found += !which;
        if (!which && found <= SHOWN)
            used += (size_t)snprintf(ids + used, sizeof ids - used, found > 1 ? ", %d" : "%d", id);
        *out = (plot_segment){.branch = id,
                              .s = {n_end == 2 ? at[0] : s[0], n_end == 2 ? at[1] : s[1]}};
    }
    if (which ? found >= which : found == 1) return true;
    if (which && found > 0)
        cli_wrong("%s %s: only %d branch%s fit%s", what, text, found, found == 1 ? "" : "es",
                  found == 1 ? "s" : "");
    else if (found == 0) say_none(atlas, what, text, label, n_end > 0);
    else say_several(what, text, found, ids);
    return false;
}

/* ------------------------------------------------------------------- orbits */

static int keep(plot_choice *out, int impacts, const int *word, const double *state,
                const double *flights)
{
    if (!plot_motion_keep(&out->motion, impacts, word, state, flights))
        return cli_report(RIC_E_NOMEM);
    out->frequency = 2 * CLI_PI / out->motion.period;
    return CLI_DONE;
}

static int take_junction(const ric_atlas *atlas, const char *text, const char *what,
                         plot_choice *out)
{
    ric_junction j;
    int id;
    if (!plot_find_junction(atlas, text, what, &id)) return CLI_WRONG;
    const ric_status status = ric_atlas_junction(atlas, id, &j);
    if (status != RIC_OK) return cli_report(status);
    out->junction = id;
    out->kind = (int)j.kind;
    out->energy = j.energy;
    out->stable = -1;
    out->periods *= j.multiple;
    out->motion.tolerance = j.kind == RIC_KIND_GRAZING ? touch_of_grazing : touch_of_branch;
    if (!*out->name)
        snprintf(out->name, sizeof out->name, "%s", j.name && *j.name ? j.name : j.label);
    return keep(out, j.letters, j.word, j.state, j.flights);
}

static int keep_point(const ric_atlas *atlas, const ric_branch *b, int i, plot_choice *out)
{
    double *state = calloc(2 * (size_t)out->motion.n, sizeof *state),
           *flights = calloc((size_t)b->letters + 1, sizeof *flights);
    ric_point p;
    ric_status status = state && flights ? ric_atlas_point(atlas, b->id, i, &p, state, flights)
                                         : RIC_E_NOMEM;
    int code = status == RIC_OK ? CLI_DONE : cli_report(status);
    if (code == CLI_DONE) {
        out->energy = p.energy;
        out->stable = p.stable;
        code = keep(out, b->letters, b->word, state, flights);
    }
    free(state);
    free(flights);
    return code;
}

/* The stored point next to an arclength, `inside` a segment as far as there is one. */
static int nearest_point(const ric_atlas *atlas, const ric_branch *b, double s)
{
    int best = 0;
    double distance = INFINITY;
    for (int i = 0; i < b->n_point; i++) {
        ric_point p;
        if (ric_atlas_point(atlas, b->id, i, &p, NULL, NULL) == RIC_OK &&
            fabs(p.arclength - s) < distance) {
            distance = fabs(p.arclength - s);
            best = i;
        }
    }
    return best;
}

/* The orbit at an energy or a frequency on a segment: there must be just one. */
static int keep_solved(const ric_atlas *atlas, const ric_branch *b, const plot_segment *segment,
                       ric_at at, double value, const char *text, const char *what,
                       plot_choice *out)
{
    const double lo = fmin(segment->s[0], segment->s[1]), hi = fmax(segment->s[0], segment->s[1]);
    int n = 0, chosen = -1, fit = 0;
    ric_orbit **orbits = NULL;
    const ric_status status = ric_orbit_find(atlas, b->id, at, value, &n, &orbits);
    if (status != RIC_OK) return cli_report(status);
    for (int i = 0; i < n; i++) {
        ric_point p;
        ric_orbit_data(orbits[i], &p, NULL, NULL, NULL);
        if (p.arclength >= lo && p.arclength <= hi) {
            chosen = i;
            fit++;
        }
    }
    int code = CLI_FAILED;
    double *state = calloc(2 * (size_t)out->motion.n, sizeof *state),
           *flights = calloc((size_t)b->letters + 1, sizeof *flights);
    int *word = calloc((size_t)b->letters + 1, sizeof *word);
    if (fit != 1) {
        fprintf(stderr, "ricochet: %s %s: %d orbits fit%s\n", what, text, fit,
                fit ? "; name the part of the branch, LABEL|P1 P2" : "");
    } else if (!state || !flights || !word) {
        code = cli_report(RIC_E_NOMEM);
    } else {
        ric_point p;
        ric_orbit_data(orbits[chosen], &p, state, flights, word);
        out->energy = p.energy;
        out->stable = p.stable;
        code = keep(out, ric_orbit_letters(orbits[chosen]), word, state, flights);
    }
    free(state);
    free(flights);
    free(word);
    ric_orbits_free(n, orbits);
    return code;
}

/* SEGMENT@0.3, SEGMENT@E=20, SEGMENT@F=1.5 */
static int take_branch(const ric_atlas *atlas, const char *segment_text, const char *place,
                       const char *what, plot_choice *out)
{
    plot_segment segment;
    ric_branch b;
    double value;
    const bool energy = !strncmp(place, "E=", 2), frequency = !strncmp(place, "F=", 2);
    if (!plot_find_segment(atlas, segment_text, what, &segment) ||
        !cli_parse_number(energy || frequency ? place + 2 : place, what, &value))
        return CLI_WRONG;
    const ric_status status = ric_atlas_branch(atlas, segment.branch, &b);
    if (status != RIC_OK) return cli_report(status);
    out->branch = segment.branch;
    out->motion.tolerance = touch_of_branch;
    if (!*out->name) snprintf(out->name, sizeof out->name, "%s", b.label);
    if (energy || frequency)
        return keep_solved(atlas, &b, &segment, energy ? RIC_AT_ENERGY : RIC_AT_FREQUENCY, value,
                           segment_text, what, out);
    if (!(value >= 0 && value <= 1))
        return cli_wrong("%s %s@%s: a part of the way along a branch lies between 0 and 1", what,
                         segment_text, place);
    return keep_point(atlas, &b,
                      nearest_point(atlas, &b,
                                    segment.s[0] + value * (segment.s[1] - segment.s[0])),
                      out);
}

int plot_choose(const ric_atlas *atlas, const char *text, const char *what, plot_choice *out)
{
    const char *colon = strstr(text, ": "), *rest = colon ? colon + 2 : text,
               *star = strrchr(rest, '*');
    char body[2 * NAME], segment[NAME];
    long periods = 1;
    *out = (plot_choice){.periods = 1,
                         .kind = -1,
                         .stable = -1,
                         .motion = {.model = ric_atlas_model(atlas),
                                    .n = ric_model_n_dof(ric_atlas_model(atlas))}};
    if (colon)
        snprintf(out->name, sizeof out->name, "%.*s",
                 (int)(colon - text < NAME ? colon - text : NAME - 1), text);
    if (star && !cli_parse_integer(star + 1, what, 1, 1000, &periods)) return CLI_WRONG;
    out->periods = (int)periods;
    snprintf(body, sizeof body, "%.*s", (int)(star ? star - rest : (long)strlen(rest)), rest);
    const char *at = strchr(body, '@');
    trim(body, at ? (size_t)(at - body) : strlen(body), segment);
    return at ? take_branch(atlas, segment, at + 1, what, out)
              : take_junction(atlas, segment, what, out);
}
