/* The command line: one file per command, one table of commands, one way to print rows. */
#ifndef CLI_H
#define CLI_H

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>
#include <time.h>

#include "atlas/columns.h"
#include "ricochet.h"

enum {
    CLI_DONE = 0,
    CLI_FAILED = 1,        /* could not be done */
    CLI_WRONG = 2,         /* the call or the study is wrong */
    CLI_LIMIT = 3,         /* stopped by a limit that was asked for: there is more to do */
    CLI_INTERRUPTED = 130, /* by a signal; what a shell says of Ctrl-C */
};

/* One thing that a command explains, in the order of its text. This table is the only place where
 * an option is described: help, manual, completion and the refusal of unknown options are made from
 * it. */
typedef struct {
    const char *name; /* an option: "--branch"; else a column or a word; NULL: a paragraph */
    const char
        *value; /* what the option takes, "ID"; NULL: nothing. ATLAS, STUDY and FILE are files */
    const char *words; /* the values if they are fixed words, with blanks between */
    const char *text;  /* one line however long; NULL in the last item */
    bool picture; /* a picture of `plot`, and what follows belongs to it; "all": to every one */
} cli_item;

/* What commands that list rows have in common. */
#define CLI_ITEM_JSON                                                                              \
    {                                                                                              \
        .name = "--json", .text = "one array of objects; numbers read back bit for bit"            \
    }
#define CLI_ITEM_CSV                                                                               \
    {                                                                                              \
        .name = "--csv", .text = "the same as comma-separated columns with a heading"              \
    }
#define CLI_ITEM_WIDE                                                                              \
    {                                                                                              \
        .name = "--wide",                                                                          \
        .text =                                                                                    \
            "--csv with a column for each number of a list: x1.. v1.. of a state, flights_1.., "   \
            "multipliers_1_re.."                                                                   \
    }

typedef struct {
    const char *name;                  /* "branches" */
    const char *summary;               /* one line for `ricochet --help` */
    const char *usage;                 /* lines; those that continue one begin with blanks */
    const cli_item *items;             /* ends with {0} */
    const char *example;               /* lines that work */
    int (*run)(int argc, char **argv); /* argv[0] is the command's name; returns an exit code */
} cli_command;

/* One per cmd_*.c, listed in main.c. */
extern const cli_command cli_run, cli_check, cli_new, cli_words, cli_branches, cli_junctions,
    cli_points, cli_orbit, cli_verify, cli_prove, cli_simulate, cli_plot, cli_bases, cli_cascade,
    cli_report_atlas, cli_hunt, cli_view, cli_export, cli_section_command, cli_force, cli_response,
    cli_locus_command, cli_help;

/* All commands, up to NULL, and the options of the program itself (main.c). */
extern const cli_command *const cli_commands[];
extern const cli_item cli_program_items[];

/* Exit codes with their meaning, up to one without: of --help and the manual pages. */
typedef struct {
    int code;
    const char *meaning;
} cli_exit_code;
extern const cli_exit_code cli_exit_codes[];

/* ----- likeness.c: what was meant by a word; `known` is the nearest of those that were shown to
 * cli_nearest(), NULL if all are far. */
typedef struct {
    const char *word, *known;
    int distance;
} cli_guess;
void cli_nearest(cli_guess *guess, const char *known);

/* ----- help.c, manual.c and completion.c: what is made from the tables, to standard output */

enum { CLI_USAGE_INDENT = 7 }; /* of "usage: " */
void cli_print_help(const cli_command *command);
/* Of one of its pictures only; NULL: of all. */
void cli_print_picture_help(const cli_command *command, const char *picture);
/* The picture that is asked for: the first of these words that is the name of one, NULL if none is.
 */
const char *cli_find_picture(const cli_command *command, int argc, char **argv);
void cli_print_program_help(FILE *out);
/* The usage to stderr, after a message. */
void cli_say_usage(const cli_command *command);
/* A text in lines of at most `width` columns, those after the first after `indent` blanks;
 * `column`: where it begins. */
void cli_print_wrapped(const char *text, int column, int indent, int width);
/* Pages of section 1; NULL: that of the program. */
void cli_print_manual(const cli_command *command);
/* "bash", "zsh" or "fish"; false if it is another. */
bool cli_print_completion(const char *shell);
/* Whether an item is an option; whether its value, or an operand, is a file. */
bool cli_is_option_item(const cli_item *item);
bool cli_takes_file(const cli_item *item);
/* Whether a command has pictures. */
bool cli_has_pictures(const cli_command *command);
/* The items of a command's option that hold for a picture (NULL: all), one after the other; NULL
 * after the last. `last` is NULL at first. */
const cli_item *cli_next_option(const cli_command *command, const char *picture,
                                const cli_item *last);
/* Whether a picture is one that can be drawn, not "all" or "names". */
bool cli_is_picture(const cli_item *item);

#define CLI_PI 3.14159265358979323846
#define CLI_TWO_PI 6.28318530717958647692

/* The whole program; returns its exit code. */
int cli_main(int argc, char **argv);
/* Who lends a hand to `run` besides its threads; NULL: nobody. */
struct ric_remote;
extern const struct ric_remote *cli_run_remote;

/* CLI_WIDE: CSV with a column for each number of a list. CLI_SHORT: as CLI_TEXT, with numbers of
 * seven digits, where a terminal has no room for more */
typedef enum { CLI_TEXT, CLI_JSON, CLI_CSV, CLI_WIDE, CLI_SHORT } cli_format;

/* choose.c: which rows of a list are asked for. */
typedef struct {
    const char *kind, *word, *stable; /* NULL: any */
    const char *sort;    /* a column, with '-' before it for falling values; NULL: as they come */
    long impacts, limit; /* negative: any, all */
    bool by_energy, by_frequency;
    bool hertz; /* frequencies are in Hz, those of the choice too: set by the command */
    double energy[2], frequency[2]; /* in the units of the list */
} cli_choice;
/* The order alone, of a list that has no other choice; false with a message where it is wrong. */
bool cli_take_sort(int *argc, char **argv, cli_choice *out);
/* Whether rows that are still to be computed will have the column of that order; false with a
 * message. `columns` and `lists` name those of one value each and those that hold lists. */
bool cli_sorts_by(const cli_choice *choice, const char *columns, const char *lists);
/* Takes the options out of argv; false with a message where they are wrong. */
bool cli_take_choice(int *argc, char **argv, cli_choice *out);
/* Leaves those rows, in order; false with a message where the list lacks a column that is asked
 * for. */
bool cli_choose(json_t *rows, const cli_choice *choice);

/* Frequencies of rows, all columns that are called so, in Hz instead of rad/s. */
void cli_in_hertz(json_t *rows);
/* The end of a word that stands behind the number n: "s", or nothing for 1. */
const char *cli_plural(long n);
/* What lengths of a list are multiplied by, energies by its square: 1, or where numbers of the
 * study are asked for d of the structure; then what the units are called, if the study says so, is
 * a line on stderr. */
double cli_unit_of_lengths(const ric_model *model, bool physical);
/* Its square; NAN where that leaves the range of doubles, so that no energy is shown as 0 or
 * infinite. */
double cli_unit_of_energies(double d);
#define CLI_ITEM_HZ                                                                                \
    {                                                                                              \
        .name = "--hz",                                                                            \
        .text = "frequencies in Hz, also that of --frequency; sentences keep omega, rad/s"         \
    }

/* The options of it; a list has those whose columns it has. */
#define CLI_ITEM_SORT                                                                              \
    {                                                                                              \
        .name = "--sort", .value = "COLUMN",                                                       \
        .text = "rows by this column, -COLUMN for falling values; what has none comes last"        \
    }
#define CLI_ITEMS_PLACE                                                                            \
    {.name = "--energy",                                                                           \
     .value = "A,B",                                                                               \
     .text = "only rows that reach into these energies, in the units of the list"},                \
        {.name = "--frequency",                                                                    \
         .value = "A,B",                                                                           \
         .text = "only rows that reach into these frequencies"},                                   \
        CLI_ITEM_SORT,                                                                             \
    {                                                                                              \
        .name = "--limit", .value = "N", .text = "only the first N rows"                           \
    }
#define CLI_ITEMS_WORD                                                                             \
    {.name = "--word", .value = "WORD", .text = "only rows of this word, as the list writes it"},  \
    {                                                                                              \
        .name = "--impacts", .value = "N", .text = "only rows of N impacts"                        \
    }
#define CLI_ITEM_STABLE                                                                            \
    {                                                                                              \
        .name = "--stable", .value = "S", .words = "yes no partly undecided",                      \
        .text = "only rows of this stability"                                                      \
    }

/* Prints an array of flat objects: JSON array, CSV with a header, or an aligned table. `columns`,
 * names with blanks between, orders and selects those of CSV and text, NULL: what the first row
 * has; JSON shows everything. Numbers read back bit for bit; NaN and infinities become null.
 * Returns CLI_DONE or CLI_FAILED. */
int cli_print_rows(const json_t *rows, const char *columns, cli_format format);
/* From cli_watch_memory on, whether JSON values of this thread have found no memory since the last
 * question; they are then missing in what they belong to. */
void cli_watch_memory(void);
bool cli_lost_memory(void);
/* A JSON number, or null if not finite. */
json_t *cli_number(double value);
/* A scaled energy where lengths go by d (cli_unit_of_lengths). */
json_t *cli_energy(double energy, double d);
/* Of each number `unit` times as much. */
json_t *cli_numbers(int n, const double *values, double unit);
/* Of 2n numbers, as real and imaginary parts. */
json_t *cli_pairs(int n, const double *values);
/* Whether an orbit is stable: yes, no or undecided. */
const char *cli_stability(ric_stability stable);
/* An id, or null for 0. */
json_t *cli_id(int id);
json_t *cli_integers(int n, const int *values);
/* The label of a k-duplicate; NULL when there is no memory. */
json_t *cli_duplicate_label(const ric_branch *branch, int k);
/* The letters of a word. */
json_t *cli_word(const ric_model *model, int n, const int *word);

/* A command that lists what an atlas has n of: `row` fills an empty object for one of them, d the
 * unit of lengths, 1 or the clearance for physical ones. */
typedef struct {
    const cli_command *command;
    int (*count)(const ric_atlas *atlas);
    ric_status (*row)(const ric_atlas *atlas, int id, double d, json_t *row);
    const ric_table *table; /* whose columns are listed; NULL: */
    const char *all, *few;  /* those of CSV and of a terminal */
    /* or, for rows that are no such list: appends all of them; `row` and `count` are not used then
     */
    ric_status (*rows)(const ric_atlas *atlas, double d, const void *user, json_t *rows);
    const void *user;
} cli_listing;

/* Takes `ATLAS [--physical] [--json | --csv]`, prints the rows and returns an exit code. */
int cli_list(const cli_listing *listing, int argc, char **argv);

/* The listed columns of a row of the atlas, into an empty object; what the command makes itself
 * comes from `made`. */
void cli_table_row(const ric_table *table, const void *row, const ric_model *model, double d,
                   json_t *(*made)(const ric_column *column, const void *row), json_t *out);
/* Their names, as cli_print_rows takes them; to be freed, NULL: no memory. */
char *cli_table_names(const ric_table *table, cli_format format);

/* What `ricochet report` lists: rows with item, value and detail. */
ric_status cli_report_rows(const ric_atlas *atlas, json_t *rows);
/* Of the windows of a study: what `run` says first, of one that will take long; what `check`
 * prints, and adds to its rows, one per mode; and what `run` says of an atlas without an orbit that
 * meets a contact. */
ric_status cli_windows_warn(const ric_study *study);
ric_status cli_windows_print(const ric_study *study);
ric_status cli_windows_rows(const ric_study *study, json_t *rows);
ric_status cli_windows_tell(const ric_atlas *atlas);
/* In how many ways masses are loose, and what is said where there are several. */
ric_status cli_windows_loose(const ric_study *study, int *ways);
#define CLI_SEVERAL                                                                                \
    "families that begin between three faces or more are not looked for, and motions of these "    \
    "masses may be missing"
/* What is said of a loose mass from which no family starts. */
#define CLI_LOOSE                                                                                  \
    "before a stop on one side alone a loose mass flies off, and masses that are loose in "        \
    "several "                                                                                     \
    "ways strike\n"                                                                                \
    "more than two faces a period: give both sides of a gap, or hold what is loose by a soft "     \
    "spring"
/* Junctions whose label, C_ab, a stopped run has not measured yet. */
int cli_unmeasured(const ric_atlas *atlas);
/* verify_response.c; returns an exit code. */
int cli_verify_response(const char *path, bool all, bool quiet, cli_format format);
/* Proofs that are kept with an atlas. Curves are those of branches with impacts that are one arc
 * from end to end. */
typedef struct {
    int points, points_proved, curves, curves_proved, junctions, junctions_proved;
    int tried;     /* how many of all of these */
    char why[200]; /* why points are left out, or "" */
} cli_proofs;
/* false: none are kept. */
bool cli_count_proofs(const ric_atlas *atlas, cli_proofs *out);
/* "720 of 720 points, 12 of 12 curves, 18 of 18 junctions" */
void cli_write_proofs(const cli_proofs *p, char *text, size_t size);
/* together.c. What the next contacts after `last` (0: the first) that close together are good for;
 * false: there is no more. And what is said where a study has joined some, "" if none. */
enum { CLI_TOGETHER = 16 * 1024 }; /* all contacts that a study may have */
bool cli_together_next(const ric_model *model, int *last, char text[CLI_TOGETHER]);
const char *cli_together_remark(const ric_model *model);

/* Proves the orbits, curves and junctions of an atlas and keeps the proofs in it; the counts go to
 * `out`, NULL: nowhere. An exit code. */
int cli_prove_atlas(const char *path, int workers, FILE *out);
/* What one row of a command holds, d the unit of lengths. They belong to cmd_branches.c,
 * cmd_junctions.c, cmd_bases.c, cmd_cascade.c and cmd_orbit.c, and are used by the page of
 * cmd_view.c as well: both show the same numbers. */
/* Its internal resonances in words, "" if it follows none; each of them fits CLI_TONGUE bytes. */
enum { CLI_TONGUE = 240 };
#define CLI_RESONANCE "internal resonance on branch" /* item of the report */
ric_status cli_tongues_text(const ric_atlas *atlas, int id, double d, json_t **out);
ric_status cli_branch_row(const ric_atlas *atlas, int id, double d, json_t *row);
ric_status cli_junction_row(const ric_atlas *atlas, int id, double d, json_t *row);
/* Whether a point of a branch is its junction, an interior one or that at an end: an orbit on the
 * border has no stability of its own, the branch on either side has. */
bool cli_point_at_junction(const ric_branch *branch, int i, const ric_point *point);
/* Whether stability changes at a point that is itself undecided, as a multiplier is at 1 or -1
 * there: one neighbour is stable and the other is not. */
bool cli_stability_changes(const ric_atlas *atlas, const ric_branch *branch, int i,
                           const ric_point *point);
json_t *cli_base_row(const ric_atlas *atlas, const ric_base *base, double d);
/* Appends a row. */
ric_status cli_orbit_row(const ric_orbit *orbit, const ric_model *model, double d, json_t *rows);

/* The text with what would steer a terminal written out, \x1b for ESC; line breaks stay where
 * `lines`. Study, names and file names may come from anyone. To be freed; NULL without memory. */
char *cli_visible(const char *text, bool lines);
/* The same to standard output, which takes no memory: half way through a page nothing can be said
 * any more. */
void cli_print_visible(const char *text, bool lines);
/* Whether one of the next three had no memory for its text: the command has then not done what it
 * says. */
bool cli_left_unsaid(void);
/* To standard error, as cli_visible() shows it: whatever holds a name or a text is said by this. */
void cli_say(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* The same to standard output where that is `out`: a verdict in words is an answer, beside rows it
 * is a remark. */
void cli_tell(FILE *out, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Takes --json or --csv out of argv; false (with a message) when both are given. */
bool cli_take_format(int *argc, char **argv, cli_format *format);
/* Takes `--name VALUE` (or --name=VALUE) out of argv; *value stays NULL when it is absent. False
 * with a message when VALUE is missing. */
bool cli_take_value(int *argc, char **argv, const char *name, const char **value);
/* Takes `--name` out of argv. */
bool cli_take_flag(int *argc, char **argv, const char *name);
/* state.c. Takes `--state` and the numbers that follow it, texts [argc]; a negative number is none
 * of the options. Then reads those of a motion of the model, divided by a length, and a time. False
 * with a message that starts with `what`. */
bool cli_take_state(int *argc, char **argv, const char *what, int *count, const char **texts);
bool cli_parse_state(const char *what, const ric_model *model, int count, const char **texts,
                     double length, double *out);
bool cli_parse_end(const char *what, const char *text, double *out);
/* Whether every option in argv is one of the command's table; else a message that shows the usage,
 * and false. */
bool cli_know_options(const cli_command *command, int argc, char **argv);
/* A study where the command or picture `what` wants an atlas: true, and says what to do. */
bool cli_wants_atlas(const char *what, const char *path);
/* What is left must be exactly n operands, none starting with '-' (but numbers may); else a message
 * that shows the usage and false. */
bool cli_operands(const cli_command *command, int argc, char **argv, int n);
/* Whole-string number, with a message naming `what` otherwise. */
bool cli_parse_number(const char *text, const char *what, double *out);
/* The value of an option of the command `what`, above 0 and at most `most`; *out stays as it is
 * without the option. */
bool cli_take_positive(int *argc, char **argv, const char *what, const char *name, double most,
                       double *out);
/* --seconds. */
bool cli_take_seconds(int *argc, char **argv, const char *what, double *out);
/* "1,0,2": *n numbers in out [most]; `what` is the option. */
bool cli_parse_list(const char *text, const char *what, int most, int *n, double *out);
bool cli_parse_integer(const char *text, const char *what, long min, long max, long *out);
/* The study in a file, or on standard input where the path is "-"; files that it names are then
 * looked for from the folder of the call. Returns an exit code, with a message. */
int cli_read_study(const char *path, ric_study **out);
/* Takes -j or --jobs out of argv, at most `most`; 0 means all cores. *workers stays where neither
 * is given. */
bool cli_take_workers(int *argc, char **argv, long most, long *workers);
/* That cores were idle while one worked because nobody asked for more; nothing if it did not take
 * long. */
void cli_tell_idle(const char *command, double seconds);

/* Ctrl-C and termination ask to stop instead of killing; whether that has happened. */
void cli_catch_signals(void);
bool cli_stopped(void);
/* Since a reading of CLOCK_MONOTONIC. */
double cli_seconds_since(const struct timespec *then);

/* A line on a terminal that says how far a computation is. */
typedef struct {
    bool terminal; /* standard error is one */
    struct timespec shown;
} cli_progress;

cli_progress cli_progress_begin(void);
/* Whether the line is to be shown anew, ten times a second; then it is taken away, and who asks
 * writes it to standard error. */
bool cli_progress_due(cli_progress *progress);
/* Takes the line away. */
void cli_progress_end(const cli_progress *progress);

/* ----- handles.c: branches and junctions by key, name, label or place */

/* The arguments of a command with ids in place of handles. */
typedef struct {
    int argc;
    char **argv;
    char **owned; /* argv and its new texts, NULL: there are none */
    char (*texts)[16];
} cli_handles;

/* Puts ids for what --branch and --junction name, and for --at E,OMEGA a --branch, with the --point
 * there where the command wants one orbit and none is chosen. Returns an exit code. */
int cli_resolve_handles(const cli_command *command, cli_handles *handles);
void cli_handles_release(cli_handles *handles);
/* A branch or a junction by its key, or an unambiguous beginning of it, or by a place E,OMEGA: 1
 * found, 0 the text is none of these, -1 with a message. `point` (may be NULL): the stored one of a
 * branch next to the place. */
int cli_find_handle(const ric_atlas *atlas, bool branch, const char *text, const char *what,
                    int *id, int *point);

/* The option beside --branch. */
#define CLI_ITEM_AT                                                                                \
    {                                                                                              \
        .name = "--at", .value = "E,OMEGA",                                                        \
        .text = "instead of --branch: the branch that comes nearest to this scaled energy and "    \
                "frequency, rad/s"                                                                 \
    }

/* A cascade that a command is asked to follow: --branch ID with --multiply LIST or --doublings N.
 */
enum { CLI_MAX_CASCADE = 24 };
typedef struct {
    bool given; /* --multiply or --doublings */
    int branch; /* 0: not given */
    int n;
    int multiple[CLI_MAX_CASCADE], rotation[CLI_MAX_CASCADE];
    bool to_end;
} cli_cascade_request;

/* Takes the options out of argv; false with a message where they are wrong. */
bool cli_take_cascade(int *argc, char **argv, cli_cascade_request *out);
/* Follows it, showing progress; returns an exit code. */
int cli_follow_cascade(const ric_atlas *atlas, const cli_cascade_request *request,
                       ric_cascade **out);

/* Appends the steps of the paths that the atlas holds; returns how many paths. */
int cli_cascade_rows(const ric_atlas *atlas, const cli_cascade_request *request, double d,
                     json_t *rows);

/* Prints "ricochet: <detail>" on stderr and returns the exit code for a status: that of the table.
 */
int cli_report(ric_status status);
/* Prints a message for a wrong call, in the same form, and returns CLI_WRONG. */
int cli_wrong(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
