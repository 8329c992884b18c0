/* What every command needs: taking options out of argv, numbers, messages, signals. */
#define _POSIX_C_SOURCE 200809L

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"

/* ----------------------------------------------------------------- signals */

/* Set by a signal: the one thing that a handler may safely do. */
static volatile sig_atomic_t stop_asked;

static void ask_to_stop(int number)
{
    (void)number;
    stop_asked = 1;
}

/* A second Ctrl-C kills: SA_RESETHAND. An atlas survives that too. */
void cli_catch_signals(void)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = ask_to_stop;
    action.sa_flags = (int)SA_RESETHAND;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

bool cli_stopped(void)
{
    return stop_asked != 0;
}

double cli_seconds_since(const struct timespec *then)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - then->tv_sec) + 1e-9 * (double)(now.tv_nsec - then->tv_nsec);
}

cli_progress cli_progress_begin(void)
{
    return (cli_progress){.terminal = isatty(STDERR_FILENO)};
}

bool cli_progress_due(cli_progress *p)
{
    if (!p->terminal || cli_seconds_since(&p->shown) <= 0.1) return false;
    fputs("\r\033[K", stderr);
    clock_gettime(CLOCK_MONOTONIC, &p->shown);
    return true;
}

void cli_progress_end(const cli_progress *p)
{
    if (p->terminal) fputs("\r\033[K", stderr);
}

/* ---------------------------------------------------------------- messages */

/* Bytes of a character that steers: a control of ASCII, one of Latin-1 (U+0080 to U+009F), or one
 * that turns the direction of writing (U+202A to U+202E, U+2066 to U+2069); else 0. */
static int steering(const unsigned char *c)
{
    if (*c < ' ' || *c == 0x7f) return 1;
    if (*c == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0) return 2;
    if (*c == 0xe2 && c[1] == 0x80 && c[2] >= 0xaa && c[2] <= 0xae) return 3;
    return *c == 0xe2 && c[1] == 0x81 && c[2] >= 0xa6 && c[2] <= 0xa9 ? 3 : 0;
}

char *cli_visible(const char *text, bool lines)
{
    char *all = malloc(4 * strlen(text) + 1), *out = all;
    for (const unsigned char *c = (const unsigned char *)text; all && *c;) {
        int n = *c == '\n' && lines ? 0 : steering(c);
        if (!n) *out++ = (char)*c++;
        for (; n > 0; n--) out += sprintf(out, "\\x%02x", *c++);
    }
    if (all) *out = '\0';
    return all;
}

static void put_visible(FILE *out, const char *text, bool lines)
{
    for (const unsigned char *c = (const unsigned char *)text; *c;) {
        int n = *c == '\n' && lines ? 0 : steering(c);
        if (!n) putc(*c++, out);
        for (; n > 0; n--) fprintf(out, "\\x%02x", *c++);
    }
}

void cli_print_visible(const char *text, bool lines)
{
    put_visible(stdout, text, lines);
}

int cli_report(ric_status status)
{
    if (status == RIC_OK) return CLI_DONE;
    const char *detail = ric_detail();
    if (status == RIC_E_NOMEM &&
        !strstr(detail,
                "memory")) /* the command itself had none; the detail is that of something before */
        detail = "";
    fputs("ricochet: ", stderr);
    put_visible(stderr, detail[0] ? detail : ric_status_text(status), true);
    fputc('\n', stderr);
    switch (status) {
    case RIC_E_INPUT:
    case RIC_E_MISSING: return CLI_WRONG;
    case RIC_E_INTERRUPTED: return CLI_INTERRUPTED;
    default: return CLI_FAILED;
    }
}

static bool unsaid; /* something that was to be told had no memory */

bool cli_left_unsaid(void)
{
    return unsaid;
}

static void put_formatted(FILE *out, const char *format, va_list arguments)
    __attribute__((format(printf, 2, 0)));

static void put_formatted(FILE *out, const char *format, va_list arguments)
{
    va_list again;
    va_copy(again, arguments);
    int size = vsnprintf(NULL, 0, format, again);
    va_end(again);
    char *text = size < 0 ? NULL : malloc((size_t)size + 1);
    if (text) vsnprintf(text, (size_t)size + 1, format, arguments);
    unsaid = unsaid || !text;
    if (text) put_visible(out, text, true);
    free(text);
}

void cli_say(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    put_formatted(stderr, format, arguments);
    va_end(arguments);
}

void cli_tell(FILE *out, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    put_formatted(out, format, arguments);
    va_end(arguments);
}

int cli_wrong(const char *format, ...)
{
    va_list arguments;
    fputs("ricochet: ", stderr);
    va_start(arguments, format);
    put_formatted(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    return CLI_WRONG;
}

/* ----------------------------------------------------------------- options */

static void take_out(int *argc, char **argv, int at, int n)
{
    memmove(argv + at, argv + at + n, (size_t)(*argc - at - n + 1) * sizeof *argv);
    *argc -= n;
}

bool cli_take_flag(int *argc, char **argv, const char *name)
{
    bool found = false;
    for (int i = 1; i < *argc;)
        if (!strcmp(argv[i], name)) {
            take_out(argc, argv, i, 1);
            found = true;
        } else i++;
    return found;
}

bool cli_take_format(int *argc, char **argv, cli_format *format)
{
    const bool json = cli_take_flag(argc, argv, "--json"),
               wide = cli_take_flag(argc, argv, "--wide"),
               csv = cli_take_flag(argc, argv, "--csv") || wide;
    if (json && csv) {
        cli_wrong("--json and --csv are both given; choose one");
        return false;
    }
    *format = json ? CLI_JSON : wide ? CLI_WIDE : csv ? CLI_CSV : CLI_TEXT;
    return true;
}

/* One number, or the first of a list: "-0.5,1". */
static bool begins_with_number(const char *text)
{
    char *end;
    strtod(text, &end);
    return end != text && (*end == '\0' || *end == ',');
}

/* The start of an option, as against a negative number or a lone "-". */
static bool is_option(const char *text)
{
    return text[0] == '-' && text[1] && !begins_with_number(text);
}

/* `--sort -energy`: a column with a minus before it, no option; those of one dash have one letter.
 */
static bool may_be_minus(const char *option, const char *text)
{
    return !strcmp(option, "--sort") && text[0] == '-' && text[1] && text[1] != '-' && text[2];
}

/* The value in one word with the option: --columns=energy, or -j2 as make has it; NULL: none. A
 * letter that is followed by letters, -out, is more likely another option. */
static const char *value_within(const char *word)
{
    const char *equals = strchr(word, '=');
    if (equals) return equals + 1;
    return word[0] == '-' && isalpha((unsigned char)word[1]) && isdigit((unsigned char)word[2])
               ? word + 2
               : NULL;
}

static bool names(const char *word, const char *option)
{
    const char *value = value_within(word);
    const size_t length = value ? (size_t)(value - word) - (value[-1] == '=') : strlen(word);
    return strlen(option) == length && !strncmp(word, option, length);
}

bool cli_take_value(int *argc, char **argv, const char *name, const char **value)
{
    *value = NULL;
    for (int i = 1; i < *argc; i++) {
        if (!names(argv[i], name)) continue;
        if (value_within(argv[i])) {
            *value = value_within(argv[i]);
            take_out(argc, argv, i, 1);
        } else if (i + 1 < *argc && (!is_option(argv[i + 1]) || may_be_minus(name, argv[i + 1]))) {
            *value = argv[i + 1];
            take_out(argc, argv, i, 2);
        }
        if (!*value || !**value) {
            cli_wrong("%s needs a value; see ricochet %s --help", name, argv[0]);
            return false;
        }
        return true;
    }
    return true;
}

static const cli_item *find_option(const cli_command *command, const char *picture,
                                   const char *word)
{
    for (const cli_item *item = NULL; (item = cli_next_option(command, picture, item));)
        if (names(word, item->name)) return item;
    return NULL;
}

const char *cli_find_picture(const cli_command *command, int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        for (const cli_item *item = command->items; item->text; item++)
            if (cli_is_picture(item) && !strcmp(argv[i], item->name)) return item->name;
    return NULL;
}

/* What other programs call it: the option of this command, or the word itself. */
static const char *translated(const cli_command *command, const char *picture, const char *word)
{
    static const char *const words[][2] = {{"--output", "-o"},  {"--out", "-o"},
                                           {"--workers", "-j"}, {"--threads", "-j"},
                                           {"--jobs", "-j"},    {"--format", "--csv"}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strcmp(word, words[i][0]) && find_option(command, picture, words[i][1]))
            return words[i][1];
    return word;
}

static void say_unknown(const cli_command *command, const char *picture, const char *word)
{
    char typed[40];
    snprintf(typed, sizeof typed, "%.*s", (int)strcspn(word, "="), word);
    const char *own = translated(command, picture, typed);
    if (own != typed) {
        cli_wrong("%s: option '%s' is unknown; it is '%s' here", command->name, word, own);
        return;
    }
    cli_guess guess = {.word = typed};
    for (const cli_item *item = NULL; (item = cli_next_option(command, picture, item));)
        cli_nearest(&guess, item->name);
    if (access(word, F_OK) == 0)
        cli_wrong("%s: option '%s' is unknown; the file of that name is written ./%s",
                  command->name, word, word);
    else if (guess.known && strlen(guess.known) > 2)
        cli_wrong("%s: option '%s' is unknown; did you mean '%s'?", command->name, word,
                  guess.known);
    else if (picture)
        cli_wrong("%s: option '%s' is unknown to plot %s; see ricochet plot --help", command->name,
                  word, picture);
    else
        cli_wrong("%s: option '%s' is unknown; see ricochet %s --help", command->name, word,
                  command->name);
}

bool cli_know_options(const cli_command *command, int argc, char **argv)
{
    const char *picture = cli_find_picture(command, argc, argv);
    for (int i = 1; i < argc; i++) {
        if (!is_option(argv[i])) continue;
        const cli_item *item = find_option(command, picture, argv[i]);
        if (!item || (!item->value && value_within(argv[i]))) {
            if (item) cli_wrong("%s: option '%s' takes no value", command->name, argv[i]);
            else say_unknown(command, picture, argv[i]);
            cli_say_usage(command);
            return false;
        }
        i += item->value && !value_within(argv[i]) && i + 1 < argc &&
             (!is_option(argv[i + 1]) || may_be_minus(item->name, argv[i + 1]));
    }
    return true;
}

/* A study where an atlas belongs: a text that is called like one. */
static bool is_study(const char *path)
{
    static const char atlas[] = "SQLite format 3";
    char head[sizeof atlas] = "";
    const char *dot = strrchr(path, '.');
    FILE *file = dot && (!strcmp(dot, ".yaml") || !strcmp(dot, ".yml")) ? fopen(path, "rb") : NULL;
    const size_t n = file ? fread(head, 1, sizeof head, file) : 0;
    if (file) fclose(file);
    return n > 0 && (n < sizeof head || memcmp(head, atlas, sizeof atlas) != 0);
}

bool cli_wants_atlas(const char *what, const char *path)
{
    if (!is_study(path)) return false;
    cli_wrong("%s: %s is a study, and this wants its atlas: `ricochet run %s` makes it, "
              "%.*s.ricochet",
              what, path, path, (int)(strrchr(path, '.') - path), path);
    return true;
}

/* A command whose first operand is an atlas has no other of its kind, or further atlases. */
static bool names_study(const cli_command *command, int argc, char **argv)
{
    char begin[64];
    snprintf(begin, sizeof begin, "ricochet %s ATLAS", command->name);
    if (strncmp(command->usage, begin, strlen(begin)) != 0) return false;
    for (int i = 1; i < argc && (i == 1 || !strstr(command->usage, "STUDY")); i++)
        if (cli_wants_atlas(command->name, argv[i])) return true;
    return false;
}

/* Says what is wrong with the arguments; false if nothing is. */
static bool wrong_operands(const cli_command *command, int argc, char **argv, int n)
{
    for (int i = 1; i < argc; i++)
        if (is_option(argv[i]))
            return cli_wrong("%s: option '%s' is given twice", command->name, argv[i]);
    for (int i = 1; i < argc; i++)
        if (!argv[i][0])
            return cli_wrong("%s: argument %d is empty; it must name something", command->name, i);
    if (argc - 1 == n) return false;
    if (argc - 1 > n)
        return cli_wrong("%s: '%s' is one argument too many", command->name, argv[n + 1]);
    return cli_wrong("%s: %d argument%s missing", command->name, n - argc + 1,
                     n - argc + 1 == 1 ? " is" : "s are");
}

bool cli_operands(const cli_command *command, int argc, char **argv, int n)
{
    if (names_study(command, argc, argv)) return false;
    if (!wrong_operands(command, argc, argv, n)) return true;
    cli_say_usage(command);
    return false;
}

/* ----------------------------------------------------------------- numbers */

bool cli_parse_number(const char *text, const char *what, double *out)
{
    char *end = NULL;
    if (!*text) {
        cli_wrong("%s: a number is missing, as behind a comma at the end", what);
        return false;
    }
    /* strtod skips blanks and reads hexadecimal and nan; none of them is a number here */
    bool starts = isdigit((unsigned char)text[0]) ||
                  ((text[0] == '-' || text[0] == '+' || text[0] == '.') && text[1]);
    double value = starts ? strtod(text, &end) : 0;
    if (!starts || end == text || *end || !isfinite(value) || strpbrk(text, "xX")) {
        cli_wrong("%s '%s' is not a finite number; write it in decimal, for example 0.5 or 2.5e-3",
                  what, text);
        return false;
    }
    *out = value;
    return true;
}

bool cli_take_positive(int *argc, char **argv, const char *what, const char *name, double most,
                       double *out)
{
    const char *text;
    if (!cli_take_value(argc, argv, name, &text)) return false;
    if (!text) return true;
    if (!cli_parse_number(text, name, out)) return false;
    if (*out > 0 && *out <= most) return true;
    if (most < HUGE_VAL)
        cli_wrong("%s: %s '%s' is not above 0 and at most %g", what, name, text, most);
    else cli_wrong("%s: %s '%s' is not positive", what, name, text);
    return false;
}

bool cli_take_seconds(int *argc, char **argv, const char *what, double *out)
{
    const char *text;
    if (!cli_take_value(argc, argv, "--seconds", &text)) return false;
    if (text && !cli_parse_number(text, "--seconds", out)) return false;
    if (!text || *out > 0) return true;
    cli_wrong("%s: --seconds: %s is no time; give a number above 0", what, text);
    return false;
}

bool cli_parse_list(const char *text, const char *what, int most, int *n, double *out)
{
    char item[64];
    for (*n = 0; *n < most; text++) {
        const size_t length = strcspn(text, ",");
        snprintf(item, sizeof item, "%.*s",
                 length < sizeof item ? (int)length : (int)sizeof item - 1, text);
        if (!cli_parse_number(item, what, &out[*n])) return false;
        ++*n;
        text += length;
        if (!*text) return true;
    }
    cli_wrong("%s has more than %d numbers", what, most);
    return false;
}

bool cli_parse_integer(const char *text, const char *what, long min, long max, long *out)
{
    char *end = NULL;
    bool starts = isdigit((unsigned char)text[0]) ||
                  ((text[0] == '-' || text[0] == '+') && isdigit((unsigned char)text[1]));
    errno = 0;
    long value = starts ? strtol(text, &end, 10) : 0;
    if (!starts || *end || errno || value < min || value > max) {
        cli_wrong("%s '%s' is not a whole number from %ld to %ld", what, text, min, max);
        return false;
    }
    *out = value;
    return true;
}

/* ------------------------------------------------------------ standard input */

enum { INPUT_MAX = 64 << 20 }; /* bytes; a study may have no more */

/* All of standard input with a 0 behind it, to be freed; NULL: no memory, or more than a study may
 * have. */
static char *read_input(size_t *size)
{
    size_t room = 1 << 16;
    char *text = malloc(room);
    for (*size = 0; text;) {
        const size_t n = fread(text + *size, 1, room - *size - 1, stdin);
        *size += n;
        if (n == 0) break;
        if (*size + 1 < room) continue;
        char *larger = room > INPUT_MAX ? NULL : realloc(text, room *= 2);
        if (!larger) free(text);
        text = larger;
    }
    if (text) text[*size] = '\0';
    return text;
}

int cli_read_study(const char *path, ric_study **out)
{
    size_t size;
    *out = NULL;
    if (strcmp(path, "-") != 0) return cli_report(ric_study_read(path, out));
    char *text = read_input(&size);
    int code = CLI_DONE;
    if (!text)
        code = cli_wrong("standard input: no memory for it, or more than %d MB", INPUT_MAX >> 20);
    else if (ferror(stdin)) code = cli_wrong("standard input cannot be read: %s", strerror(errno));
    else if (size == 0) code = cli_wrong("standard input is empty; a study was expected there");
    else if (strlen(text) < size)
        code = cli_wrong("standard input: a zero byte is in it; a study is a text");
    else code = cli_report(ric_study_parse(text, "standard input", ".", out));
    free(text);
    return code;
}

#define LONG_ENOUGH 3.0 /* seconds from which on waiting is noticed */

void cli_tell_idle(const char *command, double seconds)
{
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (seconds > LONG_ENOUGH && cores > 1)
        cli_say("ricochet: one of %ld cores was used; `%s -j 0` takes all of them, with the same "
                "result\n",
                cores, command);
}

bool cli_take_workers(int *argc, char **argv, long most, long *workers)
{
    const char *text, *alias;
    if (!cli_take_value(argc, argv, "-j", &text) || !cli_take_value(argc, argv, "--jobs", &alias))
        return false;
    if (text && alias) {
        cli_wrong("-j and --jobs are both given; they mean the same");
        return false;
    }
    if (!text && !alias) return true;
    if (!cli_parse_integer(text ? text : alias, text ? "-j" : "--jobs", 0, most, workers))
        return false;
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (*workers == 0) *workers = cores < 1 ? 1 : cores > most ? most : cores;
    return true;
}
