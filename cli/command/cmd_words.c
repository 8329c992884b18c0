/* ricochet words N [STUDY]: the independent response forms of N impacts and their numbers. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"

enum {
    N_MAX = 1024,     /* letters */
    LIST_MAX = 10000, /* rows; beyond, a list is of no use to anyone */
};

typedef struct {
    const ric_model *model; /* NULL: the article's two faces */
    int n;
    int *word, *other; /* [n] */
    char *text;
    size_t size;
} lister;

static bool lister_init(lister *l, const ric_model *model, int n)
{
    *l = (lister){.model = model, .n = n, .size = (size_t)n * 12 + 1};
    l->word = calloc((size_t)n, sizeof *l->word);
    l->other = calloc((size_t)n, sizeof *l->other);
    l->text = malloc(l->size);
    return l->word && l->other && l->text;
}

static void lister_free(lister *l)
{
    free(l->word);
    free(l->other);
    free(l->text);
}

/* Smallest r > 0 such that moving the word on by r letters gives the word, or its image under x ->
 * -x; 0 if there is none. All shifts that give one of the two are multiples of the smallest, which
 * divides n. */
static int shift_that_fits(const lister *l, bool flip)
{
    for (int r = 1; r <= l->n; r++) {
        int i = 0;
        if (l->n % r) continue;
        for (; i < l->n; i++) {
            int letter = l->word[(i + r) % l->n], mirror = 1 - letter;
            if (flip && l->model && ric_model_face(l->model, letter, NULL, NULL, &mirror)) return 0;
            if ((flip ? mirror : letter) != l->word[i]) break;
        }
        if (i == l->n) return r;
    }
    return 0;
}

/* z(t+T/2) = -z(t) is possible: half the word on is the flipped word, so that n / 2 is an odd
 * multiple of the shift. */
static bool may_be_symmetric(const lister *l)
{
    int shift = l->model && !ric_model_symmetric(l->model) ? 0 : shift_that_fits(l, true);
    return shift && l->n % (2 * shift) == 0 && (l->n / 2 / shift) % 2 == 1;
}

static json_t *word_row(lister *l, int number)
{
    json_t *row = json_object();
    ric_word_format(l->model, l->n, l->word, l->size, l->text);
    json_object_set_new(row, "number", json_integer(number));
    json_object_set_new(row, "word", json_string(l->text));
    json_object_set_new(row, "repeats", json_integer(l->n / shift_that_fits(l, false)));
    json_object_set_new(row, "symmetric", json_boolean(may_be_symmetric(l)));
    for (int i = 0; i < l->n; i++) l->other[i] = l->word[l->n - 1 - i];
    ric_word_canonical(l->model, l->n, l->other, false, l->other);
    json_object_set_new(row, "reversible",
                        json_boolean(!memcmp(l->other, l->word, (size_t)l->n * sizeof *l->word)));
    ric_word_format(l->model, l->n, l->other, l->size, l->text);
    json_object_set_new(row, "reversed", json_string(l->text));
    return row;
}

static ric_status list_words(lister *l, long limit, json_t *rows, bool *complete)
{
    bool more = true;
    l->word[0] = -1;
    *complete = false;
    for (long i = 0; i <= limit; i++) {
        ric_status status = ric_word_next(l->model, l->n, false, l->word, &more);
        if (status) return status;
        if (!more) {
            *complete = true;
            return RIC_OK;
        }
        if (i < limit) json_array_append_new(rows, word_row(l, (int)i + 1));
    }
    return RIC_OK;
}

static void format_count(const lister *l, bool reversal, size_t size, char *out)
{
    uint64_t count;
    if (ric_word_count(l->model, l->n, reversal, &count) == RIC_OK)
        snprintf(out, size, "%" PRIu64, count);
    else snprintf(out, size, "more than %" PRIu64, UINT64_MAX);
}

static int print_words(lister *l, const json_t *rows, cli_format format, bool complete)
{
    static const char columns[] = "number word repeats symmetric reversible reversed";
    char without[64], with[64];
    format_count(l, false, sizeof without, without);
    format_count(l, true, sizeof with, with);
    int code = cli_print_rows(rows, columns, format);
    /* the numbers belong to the text; a reader of rows gets them beside the rows */
    FILE *out = format == CLI_TEXT ? stdout : stderr;
    fprintf(out,
            "%s%d impact%s: %s independent forms, %s if a form and its time reversal count once\n",
            out == stdout ? "\n" : "", l->n, l->n == 1 ? "" : "s", without, with);
    if (!complete)
        fprintf(out, "only the first %zu forms are listed; --limit L lists up to %d\n",
                json_array_size(rows), LIST_MAX);
    return code;
}

static int run(int argc, char **argv)
{
    cli_format format;
    const char *limit_text;
    long n, limit = 200;
    ric_study *study = NULL;
    json_t *rows = NULL;
    lister l = {0};
    bool complete;
    ric_status status = RIC_OK;
    if (!cli_take_format(&argc, argv, &format) ||
        !cli_take_value(&argc, argv, "--limit", &limit_text) ||
        !cli_operands(&cli_words, argc, argv, argc == 3 ? 2 : 1) ||
        !cli_parse_integer(argv[1], "N", 1, N_MAX, &n) ||
        (limit_text && !cli_parse_integer(limit_text, "--limit", 0, LIST_MAX, &limit)))
        return CLI_WRONG;
    if (!limit_text && format != CLI_TEXT) limit = LIST_MAX;
    if (argc == 3) status = ric_study_read(argv[2], &study);
    if (!status &&
        (!(rows = json_array()) || !lister_init(&l, study ? ric_study_model(study) : NULL, (int)n)))
        status = RIC_E_NOMEM;
    if (!status) status = list_words(&l, limit, rows, &complete);
    int code = status ? cli_report(status) : print_words(&l, rows, format, complete);
    json_decref(rows);
    lister_free(&l);
    ric_study_free(study);
    return code;
}

static const cli_item items[] = {
    {.text = "Lists the forms (cyclic words of the faces that are hit) of N impacts per period, "
             "one of each set "
             "that differs by where the period starts or by x -> -x, in ascending order, and says "
             "how many there "
             "are without and with time reversal. Faces are those of the study, or 0 and 1, the "
             "two faces of one "
             "stop."},
    {.name = "repeats", .text = "how often a shorter word is repeated: 1 for a word of its own"},
    {.name = "symmetric", .text = "whether a motion with z(t + T/2) = -z(t) can have the word"},
    {.name = "reversible",
     .text = "whether the word read backwards is the same form; `reversed` is that form"},
    {.name = "--limit",
     .value = "L",
     .text = "list at most L forms: 200 unless given, for --json and --csv 10000"},
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_words = {
    .name = "words",
    .summary = "list the independent forms of N impacts and their numbers",
    .usage = "ricochet words N [STUDY] [--limit L] [--json | --csv]\n",
    .items = items,
    .example = "ricochet words 6\n",
    .run = run,
};
