/* Of the rows of a list those that are asked for: by kind, word, impacts, stability, energy and
 * frequency, and in which order. */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

/* "A,B" in order. */
static bool parse_range(const char *text, const char *what, double *out)
{
    char first[64];
    const size_t n = strcspn(text, ",");
    if (text[n] != ',' || n >= sizeof first) {
        cli_wrong("%s '%s' is no range; give two numbers with a comma between, for example 0.5,2",
                  what, text);
        return false;
    }
    snprintf(first, sizeof first, "%.*s", (int)n, text);
    if (!cli_parse_number(first, what, &out[0]) || !cli_parse_number(text + n + 1, what, &out[1]))
        return false;
    if (out[0] <= out[1]) return true;
    cli_wrong("%s '%s' is empty: the first number is the lower end", what, text);
    return false;
}

bool cli_take_sort(int *argc, char **argv, cli_choice *out)
{
    *out = (cli_choice){.impacts = -1, .limit = -1};
    return cli_take_value(argc, argv, "--sort", &out->sort);
}

/* false with a message that lists them. */
static bool is_kind(const char *text)
{
    char all[200] = "";
    for (ric_kind kind = RIC_KIND_START; kind <= RIC_KIND_USER; kind++) {
        const size_t used = strlen(all);
        if (!strcmp(text, ric_kind_text(kind))) return true;
        snprintf(all + used, sizeof all - used, "%s%s",
                 used == 0               ? ""
                 : kind == RIC_KIND_USER ? " and "
                                         : ", ",
                 ric_kind_text(kind));
    }
    cli_wrong("--kind %s: there are %s", text, all);
    return false;
}

bool cli_take_choice(int *argc, char **argv, cli_choice *out)
{
    const char *impacts, *energy, *frequency, *limit;
    if (!cli_take_sort(argc, argv, out) || !cli_take_value(argc, argv, "--kind", &out->kind) ||
        !cli_take_value(argc, argv, "--word", &out->word) ||
        !cli_take_value(argc, argv, "--stable", &out->stable) ||
        !cli_take_value(argc, argv, "--impacts", &impacts) ||
        !cli_take_value(argc, argv, "--energy", &energy) ||
        !cli_take_value(argc, argv, "--frequency", &frequency) ||
        !cli_take_value(argc, argv, "--limit", &limit))
        return false;
    if (out->kind && !is_kind(out->kind)) return false;
    if (out->stable && strcmp(out->stable, "yes") != 0 && strcmp(out->stable, "no") != 0 &&
        strcmp(out->stable, "partly") != 0 && strcmp(out->stable, "undecided") != 0) {
        cli_wrong("--stable %s: there are yes, no, partly and undecided", out->stable);
        return false;
    }
    out->by_energy = energy;
    out->by_frequency = frequency;
    return (!impacts || cli_parse_integer(impacts, "--impacts", 0, INT_MAX, &out->impacts)) &&
           (!limit || cli_parse_integer(limit, "--limit", 0, INT_MAX, &out->limit)) &&
           (!energy || parse_range(energy, "--energy", out->energy)) &&
           (!frequency || parse_range(frequency, "--frequency", out->frequency));
}

/* ------------------------------------------------------------------ one row */

/* What a list says of stability: of a point or a segment in a word, of a branch as a share. */
static const char *stability(const json_t *row)
{
    const json_t *share = json_object_get(row, "stable_fraction"),
                 *word = json_object_get(row, "stable");
    if (json_is_string(word)) return json_string_value(word);
    if (!json_is_number(share)) return "undecided";
    return json_number_value(share) == 1 ? "yes" : json_number_value(share) == 0 ? "no" : "partly";
}

/* Whether a row lies in a range, or reaches into it. */
static bool within(const json_t *row, const char *name, const double *range)
{
    char lower[32], upper[32];
    snprintf(lower, sizeof lower, "%s_min", name);
    snprintf(upper, sizeof upper, "%s_max", name);
    const json_t *at = json_object_get(row, name), *min = at ? at : json_object_get(row, lower),
                 *max = at ? at : json_object_get(row, upper);
    return json_is_number(min) && json_is_number(max) && json_number_value(max) >= range[0] &&
           json_number_value(min) <= range[1];
}

static bool says(const json_t *row, const char *name, const char *wanted)
{
    const char *text = json_string_value(json_object_get(row, name));
    return text && !strcmp(text, wanted);
}

static bool chosen(const json_t *row, const cli_choice *c)
{
    return (!c->kind || says(row, "kind", c->kind)) && (!c->word || says(row, "word", c->word)) &&
           (!c->stable || !strcmp(stability(row), c->stable)) &&
           (c->impacts < 0 || json_integer_value(json_object_get(row, "impacts")) == c->impacts) &&
           (!c->by_energy || within(row, "energy", c->energy)) &&
           (!c->by_frequency || within(row, "frequency", c->frequency));
}

/* A list without the column would look as if there were nothing of the kind. */
static bool lacks(const json_t *row, const char *column, bool asked)
{
    if (!row || !asked || json_object_get(row, column)) return false;
    cli_wrong("--%s: the rows of this list have no column '%s'", column, column);
    return true;
}

/* -------------------------------------------------------------------- hertz */

void cli_in_hertz(json_t *rows)
{
    const char *name;
    json_t *row, *value;
    size_t i;
    json_array_foreach(rows, i, row)
    {
        json_object_foreach(row, name,
                            value) if (!strncmp(name, "frequency", 9) && json_is_real(value))
            json_real_set(value, json_real_value(value) / CLI_TWO_PI);
    }
}

/* -------------------------------------------------------------------- order */

/* A row with what it is ordered by, and where it stood: rows that are alike keep their order. */
typedef struct {
    json_t *row;
    const json_t *value;
    size_t place;
    bool falling;
} sorted;

/* Numbers by size, texts by their letters, no before yes; NULL for what is none of these, such as a
 * list. */
static bool has_order(const json_t *value)
{
    return json_is_number(value) || json_is_string(value) || json_is_boolean(value);
}

static double size_of(const json_t *value)
{
    return json_is_boolean(value) ? json_is_true(value) : json_number_value(value);
}

static int compare_rows(const void *left, const void *right)
{
    const sorted *a = left, *b = right;
    const bool known_a = has_order(a->value), known_b = has_order(b->value);
    int order = 0;
    if (!known_a || !known_b)
        order = known_b - known_a; /* what has no value comes last, both ways */
    else if (json_is_string(a->value) || json_is_string(b->value)) {
        const char *x = json_string_value(a->value), *y = json_string_value(b->value);
        order = x && y ? strcmp(x, y)
                       : (x != NULL) - (y != NULL); /* a trace beyond all doubles is a text */
    } else
        order = (size_of(a->value) > size_of(b->value)) - (size_of(a->value) < size_of(b->value));
    if (known_a && known_b && a->falling) order = -order;
    return order ? order : (a->place > b->place) - (a->place < b->place);
}

/* Whether a word is among others, which are separated by spaces. */
static bool among(const char *words, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = words; *at; at += strspn(at, " ")) {
        const size_t length = strcspn(at, " ");
        if (length == n && !strncmp(at, word, n)) return true;
        at += length;
    }
    return false;
}

static bool has_lists(const char *column)
{
    cli_wrong("--sort %s: the column holds lists, which have no order", column);
    return false;
}

static bool has_none(const char *column, const char *known)
{
    cli_wrong("--sort %s: the rows of this list have no such column; they have %s", column, known);
    return false;
}

bool cli_sorts_by(const cli_choice *c, const char *columns, const char *lists)
{
    const char *column = c->sort ? c->sort + (*c->sort == '-') : NULL;
    if (!column || among(columns, column)) return true;
    return among(lists, column) ? has_lists(column) : has_none(column, columns);
}

/* Whether the rows of a list have such a column, of one value each; else a message that names those
 * that have. */
static bool can_sort(const json_t *rows, const char *column)
{
    char known[600] = "";
    bool found = false;
    const char *name;
    json_t *value, *row;
    size_t i;
    json_array_foreach(rows, i, row)
    {
        value = json_object_get(row, column);
        if (json_is_array(value) || json_is_object(value)) return has_lists(column);
        found |= value != NULL;
    }
    if (found) return true;
    json_object_foreach(json_array_get(rows, 0), name,
                        value) if (!json_is_array(value) && !json_is_object(value))
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", *known ? " " : "",
                 name);
    return has_none(column, known);
}

static bool sort_rows(json_t *rows, const char *by)
{
    const bool falling = *by == '-';
    const size_t n = json_array_size(rows);
    if (n == 0) return true;
    if (!can_sort(rows, by + falling)) return false;
    sorted *all = calloc(n, sizeof *all);
    if (!all) {
        cli_report(RIC_E_NOMEM);
        return false;
    }
    for (size_t i = 0; i < n; i++) {
        json_t *row = json_incref(json_array_get(rows, i));
        all[i] = (sorted){.row = row,
                          .value = json_object_get(row, by + falling),
                          .place = i,
                          .falling = falling};
    }
    qsort(all, n, sizeof *all, compare_rows);
    json_array_clear(rows);
    for (size_t i = 0; i < n; i++) json_array_append_new(rows, all[i].row);
    free(all);
    return true;
}

bool cli_choose(json_t *rows, const cli_choice *c)
{
    if (c->sort && !sort_rows(rows, c->sort)) return false;
    const json_t *first = json_array_get(rows, 0);
    if (lacks(first, "kind", c->kind) || lacks(first, "word", c->word) ||
        lacks(first, "impacts", c->impacts >= 0))
        return false;
    json_t *kept = json_array();
    const size_t all = json_array_size(rows);
    for (size_t i = 0; i < all; i++)
        if (chosen(json_array_get(rows, i), c)) json_array_append(kept, json_array_get(rows, i));
    const size_t found = json_array_size(kept);
    if (c->limit >= 0 && found > (size_t)c->limit) {
        cli_say("ricochet: %ld of %zu rows are shown\n", c->limit, found);
        for (size_t i = found; i > (size_t)c->limit; i--) json_array_remove(kept, i - 1);
    } else if (!found && all) cli_say("ricochet: none of %zu rows is of this kind\n", all);
    json_array_clear(rows);
    json_array_extend(rows, kept);
    json_decref(kept);
    return true;
}
