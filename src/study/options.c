#define _POSIX_C_SOURCE 200809L

#include "options.h"
#include "base/room.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FIELD(name) offsetof(ric_explore_options, name)
#define FORCING(name) offsetof(ric_forcing, name)
#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

static const ric_option RIC_OPTIONS[] = {
    /* section, key, type, field, default, min, max, above, unit, help */
    {"explore",
     "start",
     RIC_OPTION_MODES,
     FIELD(start),
     {0, 0},
     1,
     1000,
     false,
     "mode numbers",
     "linear modes to start from: modes for all, or a list such as [1, 2]"},
    {"explore",
     "energy",
     RIC_OPTION_WINDOW,
     FIELD(energy),
     {0, 0},
     0,
     1e18,
     false,
     "scaled energy",
     "energy window, auto, or multiples of an onset, {first_touch_of: 1, times: [0, 100]}; a "
     "branch that begins below "
     "its lower end is followed up into it, one that comes down to it ends "
     "there"},
    {"explore",
     "frequency",
     RIC_OPTION_WINDOW,
     FIELD(frequency),
     {0, 0},
     0,
     1e12,
     true,
     "rad/s",
     "window of the frequency that belongs to the shortest period, or auto"},
    {"explore",
     "impacts",
     RIC_OPTION_INTEGER,
     FIELD(impacts),
     {12, 0},
     1,
     4096,
     false,
     "impacts",
     "largest number of impacts per period"},
    {"explore",
     "multiply",
     RIC_OPTION_INTEGER,
     FIELD(multiply),
     {2, 0},
     1,
     1000,
     false,
     "periods",
     "largest q of one q-tupling, and largest k of a duplicated grazing junction that is departed "
     "from; 1 = none"},
    {"explore",
     "base",
     RIC_OPTION_INTEGER,
     FIELD(base),
     {0, 0},
     0,
     1000,
     false,
     "periods",
     "K: only those multiplications and duplicates that the K-duplicate of a branch shows, q and k "
     "that divide K; 0 = "
     "all"},
    {"explore",
     "depth",
     RIC_OPTION_INTEGER,
     FIELD(depth),
     {3, 0},
     0,
     1000000,
     false,
     "departures",
     "departures from the start along the shortest path; 0 = unlimited"},
    {"explore",
     "points",
     RIC_OPTION_INTEGER,
     FIELD(points),
     {0, 0},
     0,
     1000000000,
     false,
     "points",
     "points of all branches from which on nothing more is departed to, but for what leaves the "
     "linear modes; 0 = "
     "unlimited, which a study without energy and frequency is not unless it says so"},
    {"explore",
     "cascade",
     RIC_OPTION_CASCADE,
     FIELD(cascade),
     {0, 0},
     2,
     64,
     false,
     "periods",
     "all for every junction, or a list such as [3, 2, 4]: depart only from multiplications, by 3 "
     "first, by 2 on what "
     "leaves there, by 4 on that"},
    {"explore",
     "step",
     RIC_OPTION_REAL,
     FIELD(max_step),
     {0.03, 0},
     0,
     10,
     true,
     "relative to 1 + norm of the state",
     "largest arclength step"},
    {"explore",
     "tongues",
     RIC_OPTION_TONGUES,
     FIELD(cross_tongues),
     {0, 0},
     0,
     1,
     false,
     "",
     "follow or cross: what a branch does at an internal resonance with a mode that it hardly "
     "excites, climb along it, "
     "or go on behind it if it is narrower than tongue_width"},
    {"explore",
     "tongue_width",
     RIC_OPTION_REAL,
     FIELD(tongue_width),
     {0.01, 0},
     0,
     0.5,
     true,
     "relative to the frequency",
     "with tongues: cross, the widest gap that is stepped over"},
    {"explore",
     "symmetric",
     RIC_OPTION_SWITCH,
     FIELD(symmetric_only),
     {0, 0},
     0,
     1,
     false,
     "",
     "depart only to branches with z(t + T/2) = -z(t)"},
    {"explore",
     "at_energy",
     RIC_OPTION_NUMBERS,
     FIELD(at_energy),
     {0, 0},
     0,
     1e18,
     true,
     "scaled energy",
     "energies, or multiples of an onset, that become junctions of kind user on every branch that "
     "passes them, such as "
     "[1.5, 10]"},
    {"explore",
     "at_frequency",
     RIC_OPTION_NUMBERS,
     FIELD(at_frequency),
     {0, 0},
     0,
     1e12,
     true,
     "rad/s",
     "the same for frequencies of the orbit, such as [1.2, 1.6]"},
    {"",
     "tolerance",
     RIC_OPTION_REAL,
     FIELD(tolerance),
     {1e-12, 0},
     1e-14,
     1e-4,
     false,
     "relative",
     "accuracy asked for: orbits are always solved to rounding, and those of which it leaves a "
     "larger residual are "
     "counted by `run` and `report`"},
    {"",
     "restitution",
     RIC_OPTION_REAL,
     FORCING(shaking.restitution),
     {1, 0},
     0,
     1,
     false,
     "",
     "speed after an impact over that before, of all rigid stops; `force` and `response` take it "
     "above 0"},
    {"forcing",
     "amplitude",
     RIC_OPTION_AMOUNTS,
     FORCING(amplitude),
     {0, 0},
     0,
     1e18,
     true,
     "force",
     "L of the force L f cos(Omega t + phase), or a list such as [0.1, 0.2]"},
    {"forcing",
     "frequency",
     RIC_OPTION_BAND,
     FORCING(frequency),
     {0, 0},
     0,
     1e12,
     true,
     "rad/s",
     "Omega of the force, or a window such as [0.5, 2]"},
    {"forcing",
     "harmonic",
     RIC_OPTION_WHOLES,
     FORCING(harmonic),
     {0, 0},
     1,
     10000,
     false,
     "frequencies of the orbit",
     "m of Omega = m omega, or a list such as [1, 2]; 1 where it is not given"},
};

const ric_option *ric_options_list(int *n)
{
    *n = COUNT(RIC_OPTIONS);
    return RIC_OPTIONS;
}

bool ric_option_is_forcing(const ric_option *option)
{
    return !strcmp(option->section, "forcing") || !strcmp(option->key, "restitution");
}

const ric_option *ric_option_find(const char *section, const char *key)
{
    for (int i = 0; i < COUNT(RIC_OPTIONS); i++)
        if (!strcmp(RIC_OPTIONS[i].section, section) && !strcmp(RIC_OPTIONS[i].key, key))
            return &RIC_OPTIONS[i];
    return NULL;
}

static void *field(const ric_option *option, void *options)
{
    return (char *)options + option->offset;
}

static const void *const_field(const ric_option *option, const void *options)
{
    return (const char *)options + option->offset;
}

static void store(const ric_option *option, const double value[2], void *options)
{
    void *where = field(option, options);
    ric_explore_options *out = options; /* of lists that know where they are */
    switch (option->type) {
    case RIC_OPTION_REAL: *(double *)where = value[0]; break;
    case RIC_OPTION_INTEGER: *(int *)where = (int)value[0]; break;
    case RIC_OPTION_SWITCH: *(bool *)where = value[0] != 0; break;
    case RIC_OPTION_BAND:
    case RIC_OPTION_WINDOW: memcpy(where, value, 2 * sizeof *value); break;
    case RIC_OPTION_MODES: out->n_start = 0; break;
    case RIC_OPTION_AMOUNTS:
    case RIC_OPTION_WHOLES:
    case RIC_OPTION_NUMBERS: ((ric_numbers *)where)->n = 0; break;
    case RIC_OPTION_CASCADE: out->n_cascade = 0; break;
    case RIC_OPTION_TONGUES: *(bool *)where = value[0] != 0; break;
    }
}

void ric_explore_options_init(ric_explore_options *options)
{
    memset(options, 0, sizeof *options);
    for (int i = 0; i < COUNT(RIC_OPTIONS); i++)
        if (!ric_option_is_forcing(&RIC_OPTIONS[i]))
            store(&RIC_OPTIONS[i], RIC_OPTIONS[i].initial, options);
}

void ric_option_forcing_init(ric_forcing *forcing)
{
    memset(forcing, 0, sizeof *forcing);
    for (int i = 0; i < COUNT(RIC_OPTIONS); i++)
        if (ric_option_is_forcing(&RIC_OPTIONS[i]))
            store(&RIC_OPTIONS[i], RIC_OPTIONS[i].initial, forcing);
}

/* ----------------------------------------------------------------- numbers */

static const char *digits(const char *text)
{
    while (isdigit((unsigned char)*text)) text++;
    return text;
}

/* [-+] digits [. digits] [e [-+] digits], also with the d of Fortran, with a digit before or after
 * the point: no hexadecimal, no blanks. */
static bool is_decimal(const char *text)
{
    text += *text == '-' || *text == '+';
    const char *whole = digits(text);
    bool any = whole > text;
    text = whole;
    if (*text == '.') {
        const char *end = digits(text + 1);
        any = any || end > text + 1;
        text = end;
    }
    if (any && *text && strchr("eEdD", *text)) {
        text += text[1] == '-' || text[1] == '+' ? 2 : 1;
        const char *end = digits(text);
        any = end > text;
        text = end;
    }
    return any && *text == '\0';
}

static bool names_no_finite(const char *text)
{
    static const char *const names[] = {"nan", "inf", "infinity"};
    char lower[12] = "";
    text += *text == '-' || *text == '+';
    text += *text == '.';
    for (size_t i = 0; i + 1 < sizeof lower && text[i]; i++)
        lower[i] = (char)tolower((unsigned char)text[i]);
    for (int i = 0; i < COUNT(names); i++)
        if (!strcmp(lower, names[i])) return true;
    return false;
}

enum { FORTRAN_MAX = 64 }; /* characters of a number whose exponent is a d; 25 name every double */

ric_text_kind ric_option_text_real(const char *text, double *out)
{
    char copy[FORTRAN_MAX];
    if (!is_decimal(text)) return names_no_finite(text) ? RIC_TEXT_NOT_FINITE : RIC_TEXT_NO_NUMBER;
    const size_t mark = strcspn(text, "dD");
    if (text[mark]) {
        if (strlen(text) >= sizeof copy) return RIC_TEXT_NO_NUMBER;
        strcpy(copy, text);
        copy[mark] = 'e';
        text = copy;
    }
    *out = ric_c_strtod(text, NULL);
    return isfinite(*out) ? RIC_TEXT_NUMBER : RIC_TEXT_NOT_FINITE;
}

bool ric_option_text_integer(const char *text, long *out)
{
    const char *first = text + (*text == '-' || *text == '+');
    if (!isdigit((unsigned char)*first) || *digits(first)) return false;
    errno = 0;
    *out = strtol(text, NULL, 10);
    return errno == 0;
}

void ric_option_text_write(double value, FILE *out)
{
    char text[40];
    for (int precision = 15; precision <= 17; precision++) {
        ric_c_print(text, sizeof text, "%.*g", precision, value);
        if (ric_c_strtod(text, NULL) == value) break;
    }
    fputs(text, out);
}

/* ----------------------------------------------------------------- reading */

void ric_option_range(const ric_option *option, size_t size, char *out)
{
    snprintf(out, size, "%s%g, %g]", option->above ? "(" : "[", option->min, option->max);
}

static ric_status read_number(const ric_option *option, const char *text, double *out)
{
    char range[64];
    long whole = 0;
    ric_text_kind kind = ric_option_text_real(text, out);
    ric_option_range(option, sizeof range, range);
    if (kind == RIC_TEXT_NOT_FINITE)
        return ric_fail(RIC_E_INPUT, "'%.40s' is not finite; give a number in %s", text, range);
    bool integer = option->type == RIC_OPTION_INTEGER || option->type == RIC_OPTION_MODES ||
                   option->type == RIC_OPTION_WHOLES;
    if (kind != RIC_TEXT_NUMBER || (integer && !ric_option_text_integer(text, &whole)))
        return ric_fail(RIC_E_INPUT, "'%.40s' is not a%s number; give one in %s", text,
                        integer ? " whole" : "", range);
    if (*out < option->min || *out > option->max || (option->above && *out == option->min))
        return ric_fail(RIC_E_INPUT, "%.40s is out of range; give a%s number in %s", text,
                        integer ? " whole" : "", range);
    return RIC_OK;
}

static ric_status read_window(const ric_option *option, bool list, int n, const char *const *texts,
                              double out[2], int *item)
{
    out[0] = out[1] = 0;
    if (!list && !strcmp(texts[0], "auto")) return RIC_OK;
    if (!list || n != 2)
        return ric_fail(
            RIC_E_INPUT,
            "a window has two numbers; write [lower, upper], for example [0.2, 10], or auto");
    for (int i = 0; i < 2; i++) {
        ric_status status = read_number(option, texts[i], &out[i]);
        if (status) {
            *item = i;
            return status;
        }
    }
    if (out[0] < out[1]) return RIC_OK;
    return ric_fail(RIC_E_INPUT, "the window [%.17g, %.17g] is %s; write the lower bound first",
                    out[0], out[1], out[0] == out[1] ? "empty" : "reversed");
}

/* A number stands for a window without width. */
static ric_status read_band(const ric_option *option, bool list, int n, const char *const *texts,
                            double out[2], int *item)
{
    if (list && n != 2)
        return ric_fail(RIC_E_INPUT,
                        "expected a number, or a window [lower, upper], for example [0.5, 2]");
    if (list) return read_window(option, list, n, texts, out, item);
    ric_status status = read_number(option, texts[0], &out[0]);
    out[1] = out[0];
    return status;
}

bool ric_option_is_auto(const double window[2])
{
    return window[0] == 0 && window[1] == 0;
}

static int compare_integers(const void *left, const void *right)
{
    int a = *(const int *)left, b = *(const int *)right;
    return (a > b) - (a < b);
}

/* A word, *n = 0, or a list of whole numbers. */
static ric_status read_list(const ric_option *option, const char *word, bool list, int n,
                            const char *const *texts, int room, int *out, int *n_out, int *item)
{
    double number;
    *n_out = 0;
    if (!list && !strcmp(texts[0], word)) return RIC_OK;
    if (!list || n < 1 || n > room)
        return ric_fail(RIC_E_INPUT,
                        "expected the word %s or a list of 1 to %d numbers; write %s, or [%g, 3]",
                        word, room, word, option->min);
    for (int i = 0; i < n; i++) {
        *item = i;
        ric_status status = read_number(option, texts[i], &number);
        if (status) return status;
        out[i] = (int)number;
    }
    *item = -1;
    *n_out = n;
    return RIC_OK;
}

static ric_status read_modes(const ric_option *option, bool list, int n, const char *const *texts,
                             ric_explore_options *out, int *item)
{
    int start[COUNT(out->start)];
    ric_status status = read_list(option, "modes", list, n, texts, COUNT(start), start, &n, item);
    if (status) return status;
    qsort(start, (size_t)n, sizeof *start, compare_integers);
    for (int i = 1; i < n; i++)
        if (start[i] == start[i - 1])
            return ric_fail(RIC_E_INPUT, "mode %d is listed twice; name each mode once", start[i]);
    memcpy(out->start, start, (size_t)n * sizeof *start);
    out->n_start = n;
    return RIC_OK;
}

static int compare_reals(const void *left, const void *right)
{
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

static bool is_numbers(ric_option_type type)
{
    return type == RIC_OPTION_NUMBERS || type == RIC_OPTION_AMOUNTS || type == RIC_OPTION_WHOLES;
}

static ric_status read_numbers(const ric_option *option, bool list, int n, const char *const *texts,
                               ric_numbers *out, int *item)
{
    ric_numbers numbers = {.n = n};
    if (!list && option->type == RIC_OPTION_NUMBERS)
        return ric_fail(RIC_E_INPUT, "expected a list of numbers; write [%.40s], or [] for none",
                        texts[0]);
    if (n == 0 && option->type != RIC_OPTION_NUMBERS)
        return ric_fail(RIC_E_INPUT, "an empty list; give a number, or leave the key out");
    if (n > RIC_NUMBERS_MAX)
        return ric_fail(RIC_E_INPUT, "more than %d numbers; leave some for another study",
                        RIC_NUMBERS_MAX);
    for (int i = 0; i < n; i++) {
        *item = i;
        ric_status status = read_number(option, texts[i], &numbers.value[i]);
        if (status) return status;
        for (int j = 0; j < i; j++)
            if (numbers.value[j] == numbers.value[i])
                return ric_fail(RIC_E_INPUT, "%.40s is listed twice; give each number once",
                                texts[i]);
    }
    *item = -1;
    qsort(numbers.value, (size_t)n, sizeof *numbers.value, compare_reals);
    *out = numbers;
    return RIC_OK;
}

ric_status ric_option_read(const ric_option *option, bool list, int n, const char *const *texts,
                           void *options, int *item)
{
    double value[2] = {0, 0};
    ric_status status = RIC_OK;
    ric_explore_options *out = options;
    *item = -1;
    if (option->type == RIC_OPTION_MODES) return read_modes(option, list, n, texts, out, item);
    if (is_numbers(option->type))
        return read_numbers(option, list, n, texts, field(option, out), item);
    if (option->type == RIC_OPTION_CASCADE)
        return read_list(option, "all", list, n, texts, COUNT(out->cascade), out->cascade,
                         &out->n_cascade, item);
    if (option->type == RIC_OPTION_TONGUES && !list) {
        value[0] = strcmp(texts[0], "cross") ? 0 : 1;
        if (value[0] == 0 && strcmp(texts[0], "follow"))
            return ric_fail(RIC_E_INPUT, "'%.40s' is neither follow nor cross; write one of them",
                            texts[0]);
    } else if (option->type == RIC_OPTION_WINDOW)
        status = read_window(option, list, n, texts, value, item);
    else if (option->type == RIC_OPTION_BAND)
        status = read_band(option, list, n, texts, value, item);
    else if (list) return ric_fail(RIC_E_INPUT, "expected one value, found a list of %d", n);
    else if (option->type == RIC_OPTION_SWITCH) {
        value[0] = strcmp(texts[0], "true") ? 0 : 1;
        if (value[0] == 0 && strcmp(texts[0], "false"))
            return ric_fail(RIC_E_INPUT, "'%.40s' is neither true nor false; write one of them",
                            texts[0]);
    } else status = read_number(option, texts[0], &value[0]);
    if (!status) store(option, value, options);
    return status;
}

/* ----------------------------------------------------------------- writing */

static void write_numbers(int n, const double *values, FILE *out)
{
    fputc('[', out);
    for (int i = 0; i < n; i++) {
        if (i) fputs(", ", out);
        ric_option_text_write(values[i], out);
    }
    fputc(']', out);
}

static void write_list(const char *word, int n, const int *list, FILE *out)
{
    if (n == 0) fputs(word, out);
    for (int i = 0; i < n; i++)
        fprintf(out, "%s%d%s", i ? ", " : "[", list[i], i + 1 == n ? "]" : "");
}

void ric_option_write(const ric_option *option, const void *of, FILE *out)
{
    const void *where = const_field(option, of);
    const ric_explore_options *options = of;
    const double *real = where;
    switch (option->type) {
    case RIC_OPTION_REAL: ric_option_text_write(*real, out); break;
    case RIC_OPTION_INTEGER: fprintf(out, "%d", *(const int *)where); break;
    case RIC_OPTION_SWITCH: fputs(*(const bool *)where ? "true" : "false", out); break;
    case RIC_OPTION_WINDOW:
        if (ric_option_is_auto(real)) fputs("auto", out);
        else write_numbers(2, real, out);
        break;
    case RIC_OPTION_BAND:
        if (real[0] == real[1]) ric_option_text_write(*real, out);
        else write_numbers(2, real, out);
        break;
    case RIC_OPTION_AMOUNTS:
    case RIC_OPTION_WHOLES:
    case RIC_OPTION_NUMBERS:
        write_numbers(((const ric_numbers *)where)->n, ((const ric_numbers *)where)->value, out);
        break;
    case RIC_OPTION_MODES: write_list("modes", options->n_start, options->start, out); break;
    case RIC_OPTION_TONGUES: fputs(*(const bool *)where ? "cross" : "follow", out); break;
    case RIC_OPTION_CASCADE: write_list("all", options->n_cascade, options->cascade, out); break;
    }
}
