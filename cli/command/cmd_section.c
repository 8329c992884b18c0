/* ricochet section STUDY|ATLAS: motions of one energy, impact by impact, with their exponents and
 * rotation numbers. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/section.h"

/* ----------------------------------------------------------------- impacts */

/* There may be millions of rows: they are printed one by one. */
typedef struct {
    cli_format format;
    int n;      /* degrees of freedom */
    double d;   /* unit of lengths */
    bool first; /* nothing has been printed yet */
    int column; /* of the row at work */
} printer;

static void begin_cell(printer *p, const char *name)
{
    if (p->format == CLI_JSON) printf("%s\"%s\": ", p->column ? ", " : "{", name);
    else if (p->column) fputs(p->format == CLI_CSV ? "," : "  ", stdout);
    p->column++;
}

static void print_integer(printer *p, const char *name, long value)
{
    begin_cell(p, name);
    printf(p->format == CLI_TEXT ? "%8ld" : "%ld", value);
}

/* Seventeen digits read back bit for bit; a whole number keeps its point, so that it is read as a
 * number of its kind. */
static void print_number(printer *p, const char *name, double value)
{
    char text[40];
    begin_cell(p, name);
    snprintf(text, sizeof text, p->format == CLI_TEXT ? "%.12g" : "%.17g", value);
    if (!isfinite(value))
        snprintf(text, sizeof text, "%s",
                 p->format == CLI_JSON  ? "null"
                 : p->format == CLI_CSV ? ""
                                        : "-");
    else if (p->format == CLI_JSON && !strpbrk(text, ".e")) strcat(text, ".0");
    printf(p->format == CLI_TEXT ? "%18s" : "%s", text);
}

static const char *state_name(const printer *p, int i, char name[16])
{
    snprintf(name, 16, "%c%d", i < p->n ? 'x' : 'v', i < p->n ? i + 1 : i - p->n + 1);
    return name;
}

static void print_heading(const printer *p)
{
    static const char *const first[] = {"start", "impact", "time", "face"},
                             *const last[] = {"rotation", "lyapunov", "lyapunov_error"};
    const bool text = p->format == CLI_TEXT;
    char name[16];
    for (int i = 0; i < 4; i++)
        printf(!text    ? "%s%s"
               : i == 2 ? "%s%18s"
                        : "%s%8s",
               i == 0 ? ""
               : text ? "  "
                      : ",",
               first[i]);
    for (int i = 0; i < 2 * p->n; i++) printf(text ? "  %18s" : ",%s", state_name(p, i, name));
    for (int i = 0; i < 3; i++) printf(text ? "  %18s" : ",%s", last[i]);
    putchar('\n');
}

static void print_impact(printer *p, const ric_section *section, const ric_section_track *track,
                         int start, long k)
{
    double state[2 * p->n], time;
    char name[16];
    int face;
    if (ric_section_impact(section, start, k, &time, &face, state, state + p->n)) return;
    if (p->format == CLI_JSON) fputs(p->first ? "[\n " : ",\n ", stdout);
    p->first = false;
    p->column = 0;
    print_integer(p, "start", start + 1);
    print_integer(p, "impact", k + 1);
    print_number(p, "time", time);
    print_integer(p, "face", face);
    for (int i = 0; i < 2 * p->n; i++) print_number(p, state_name(p, i, name), state[i] * p->d);
    print_number(p, "rotation", track->rotation);
    print_number(p, "lyapunov", track->lyapunov);
    print_number(p, "lyapunov_error", track->lyapunov_error);
    if (p->format == CLI_JSON) putchar('}');
    else putchar('\n');
}

static int print_impacts(const cli_section *s, double d, cli_format format)
{
    printer p = {.format = format, .n = ric_model_n_dof(s->model), .d = d, .first = true};
    if (format != CLI_JSON) print_heading(&p);
    for (int i = 0; i < ric_section_n_start(s->section) && !ferror(stdout); i++) {
        ric_section_track track;
        if (ric_section_track_at(s->section, i, &track)) continue;
        for (long k = 0; k < track.impacts; k++) print_impact(&p, s->section, &track, i, k);
    }
    if (format == CLI_JSON) puts(p.first ? "[]" : "\n]");
    errno = 0;
    if (!fflush(stdout) && !ferror(stdout)) return CLI_DONE;
    cli_say("ricochet: the output cannot be written: %s\n",
            errno ? strerror(errno) : "write error");
    return CLI_FAILED;
}

/* ------------------------------------------------------------------ starts */

static json_t *start_row(const cli_section *s, int i, const ric_section_track *t)
{
    json_t *row = json_object();
    const cli_section_orbit *orbit = s->given.n ? &s->given.orbits[i % s->given.n] : NULL;
    json_object_set_new(row, "start", json_integer(i + 1));
    json_object_set_new(row, "branch", cli_id(orbit ? orbit->branch : 0));
    json_object_set_new(row, "face", json_integer(t->face));
    json_object_set_new(row, "impacts", json_integer(t->impacts));
    json_object_set_new(row, "time", cli_number(t->time));
    json_object_set_new(row, "rotation", cli_number(t->rotation));
    json_object_set_new(row, "rotation_error", cli_number(t->rotation_error));
    json_object_set_new(row, "lyapunov", cli_number(t->lyapunov));
    json_object_set_new(row, "lyapunov_error", cli_number(t->lyapunov_error));
    json_object_set_new(row, "energy_error", cli_number(t->energy_error));
    json_object_set_new(row, "why", json_string(t->why));
    return row;
}

static int print_starts(const cli_section *s, cli_format format)
{
    static const char columns[] =
        "start branch face impacts time rotation rotation_error lyapunov lyapunov_error "
        "energy_error why";
    json_t *rows = json_array();
    for (int i = 0; i < ric_section_n_start(s->section); i++) {
        ric_section_track track;
        if (!ric_section_track_at(s->section, i, &track))
            json_array_append_new(rows, start_row(s, i, &track));
    }
    const int code = rows ? cli_print_rows(rows, columns, format) : cli_report(RIC_E_NOMEM);
    json_decref(rows);
    return code;
}

/* In one line what came of it, and each start that ended before its time. */
static void summarise(const cli_section *s, const cli_section_request *r, int code)
{
    enum { MOST_TOLD = 5 };
    int grow = 0, ended = 0, n = ric_section_n_start(s->section);
    double worst = 0;
    long impacts = 0;
    for (int i = 0; i < n; i++) {
        ric_section_track t;
        if (ric_section_track_at(s->section, i, &t)) continue;
        impacts += t.impacts;
        grow += t.lyapunov > 2 * t.lyapunov_error;
        worst = fmax(worst, t.energy_error);
        if (t.why[0] && !code && ended++ < MOST_TOLD)
            cli_say("start %d ends after %ld impact%s: %s\n", i + 1, t.impacts,
                    cli_plural(t.impacts), t.why);
    }
    if (ended > MOST_TOLD)
        cli_say("and %d more start%s before %s time\n", ended - MOST_TOLD,
                ended - MOST_TOLD == 1 ? " ends" : "s end",
                ended - MOST_TOLD == 1 ? "its" : "their");
    cli_say("%d start%s, %ld impact%s at energy %.12g; neighbours part exponentially in %d; the "
            "energy stayed within %.1e\n",
            n, cli_plural(n), impacts, cli_plural(impacts), r->energy, grow, worst);
    if (code)
        cli_say("ricochet: stopped %s: %.3g %% of the impacts were not reached\n",
                code == CLI_LIMIT ? "when the time given was over" : "on request",
                100 * (1 - (double)impacts / ((double)n * (double)r->options.impacts)));
}

/* ----------------------------------------------------------------- command */

static int run(int argc, char **argv)
{
    cli_format format;
    cli_section_request request;
    cli_section s = {0};
    const bool physical = cli_take_flag(&argc, argv, "--physical"),
               starts = cli_take_flag(&argc, argv, "--exponents");
    if (!cli_take_format(&argc, argv, &format) ||
        !cli_section_take(&argc, argv, "section", CLI_SECTION_STARTS, &request) ||
        !cli_operands(&cli_section_command, argc, argv, 1))
        return CLI_WRONG;
    int code = cli_section_open(argv[1], &s);
    const double d = code ? 1 : cli_unit_of_lengths(s.model, physical);
    request.options.rows = !starts;
    if (!code) code = cli_section_follow(&request, d, &s);
    if (code == CLI_DONE || code == CLI_LIMIT || code == CLI_INTERRUPTED) {
        const int printed = starts ? print_starts(&s, format) : print_impacts(&s, d, format);
        summarise(&s, &request, code);
        if (printed) code = printed;
    }
    cli_section_close(&s);
    return code;
}

static const cli_item items[] = {
    {.text = "Follows motions of one energy from impact to impact and tells regular ones from "
             "chaotic ones. A row is a "
             "state right after an impact; between bilinear springs, where a spring closes; under "
             "a power law, where a "
             "spring passes s = 0. No impact is missed: every flight is searched with bounds on "
             "its derivatives. The "
             "same bits whatever the number of workers."},
    {.name = "start, impact, time, face, x1.., v1..",
     .text =
         "which motion, its impact from 1, seconds since the first one, the face that is hit "
         "(under a power law 2 f "
         "where the gap of contact f rises, 2 f + 1 where it falls), displacements and velocities"},
    {.name = "rotation",
     .text = "mean turns of neighbouring motions per impact, between 0 and 1; on an orbit with N "
             "impacts whose "
             "multipliers are exp(+-2 pi i gamma), N times it is +-gamma but for whole turns. Only "
             "where two modes are "
             "seen and the exponent is zero to twice its error"},
    {.name = "lyapunov, lyapunov_error",
     .text = "finite-time Lyapunov exponent, per second, and its error: that of the mean of 16 "
             "parts of the motion, and "
             "ln N / t, which a motion of N impacts without an exponent shows"},
    CLI_ITEMS_SECTION,
    CLI_ITEM_AT,
    {.name = "--exponents",
     .text = "one row for each start instead, and no impacts are kept: for long motions"},
    {.name = "--physical",
     .text = "energy, displacements and velocities in the study's own units of length"},
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_section_command = {
    .name = "section",
    .summary = "motions of one energy from impact to impact, and their exponents",
    .usage = "ricochet section STUDY|ATLAS --energy E [--starts N] [--impacts M]\n"
             "           [(--branch ID | --at E,OMEGA | --orbits) [--radius R]] [--exponents] "
             "[--physical]\n"
             "           [-j WORKERS | --jobs WORKERS] [--seconds S] [--json | --csv]\n",
    .items = items,
    .example =
        "ricochet section examples/elementary/study.yaml --energy 5 --starts 40 --exponents\n"
        "ricochet section study.ricochet --energy 5 --branch 3 --radius 0.1\n",
    .run = run,
};
