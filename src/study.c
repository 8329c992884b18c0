/* Reader and writer of studies. Bytes -> limits -> libyaml document -> typed values -> model; every check names file, line and key. */
#define _POSIX_C_SOURCE 200809L

#include "study.h"

#include <ctype.h>
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "matrix_market.h"
#include "options.h"
#include "status.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

/* Bounds of what is read, so that no file can take more than seconds and a few hundred megabytes. */
enum {
    FILE_MAX = 64 << 20,
    DEPTH_MAX = 12,      /* a contact's normal is at depth 5 */
    ANCHOR_MAX = 100,    /* anchors, and aliases, of a document */
    NODE_MAX = 4000000,  /* two inline matrices of 1000 rows need half of it */
    CONTACT_MAX = 1000,
    NAME_MAX_COUNT = 10000,
    STRING_MAX = 1000,   /* bytes of a title or name */
    KEY_MAX = 96,        /* "model.contacts[12].clearance" */
};

struct ric_study {
    char *title, *text;
    size_t explore_at, explore_end; /* the explore options in `text` */
    ric_model *model;
    size_t restitution_line;
    ric_explore_options options;
    int n_name;
    ric_name *names;
};

typedef struct {
    const char *label, *base;
    yaml_document_t document;
} reader;

typedef yaml_node_t node;

/* A key of a mapping with its value; both NULL when the study does not give it. */
typedef struct {
    const node *key, *value;
} slot;

typedef struct {
    int n, n_contact;
    double *mass, *stiffness;
    ric_contact *contacts; /* names and normals owned */
    double restitution;
    size_t restitution_line; /* 0 if not given */
} raw_model;

/* ---------------------------------------------------------------- messages */

/* "FILE:LINE: key: what is wrong; what would be right", in one printable line. */
static ric_status vwrong(const reader *r, size_t line, const char *key, const char *format, va_list arguments)
{
    char what[700];
    vsnprintf(what, sizeof what, format, arguments);
    for (char *c = what; *c; c++)
        if (iscntrl((unsigned char)*c))
            *c = '?';
    return ric_fail(RIC_E_INPUT, "%.200s:%zu: %s: %s", r->label, line, key, what);
}

static ric_status wrong_at(const reader *r, size_t line, const char *key, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

static ric_status wrong_at(const reader *r, size_t line, const char *key, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    ric_status status = vwrong(r, line, key, format, arguments);
    va_end(arguments);
    return status;
}

static ric_status wrong(const reader *r, const node *where, const char *key, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

static ric_status wrong(const reader *r, const node *where, const char *key, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    ric_status status = vwrong(r, where->start_mark.line + 1, key, format, arguments);
    va_end(arguments);
    return status;
}

static ric_status no_memory(const reader *r)
{
    return ric_fail(RIC_E_NOMEM, "%.200s: no memory for the study", r->label);
}

/* ------------------------------------------------------------------ limits */

/* Length of the UTF-8 character at c, 0 if it is none (overlong forms and surrogates are none). */
static int utf8_length(const unsigned char *c)
{
    static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
    int n = c[0] < 0x80 ? 1 : c[0] >> 5 == 6 ? 2 : c[0] >> 4 == 14 ? 3 : c[0] >> 3 == 30 ? 4 : 0;
    unsigned code = n < 2 ? c[0] : c[0] & (0x7Fu >> n);
    for (int i = 1; i < n; i++) {
        if (c[i] >> 6 != 2)
            return 0;
        code = code << 6 | (c[i] & 0x3Fu);
    }
    return n < 2 || (code >= least[n] && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF)) ? n : 0;
}

static ric_status check_bytes(const reader *r, const char *text, size_t size)
{
    size_t line = 1;
    bool content = false;
    for (size_t i = 0; i < size;) {
        unsigned char c = (unsigned char)text[i];
        int length = utf8_length((const unsigned char *)text + i);
        if (length == 0)
            return wrong_at(r, line, "text", "byte 0x%02X is not UTF-8; save the study as UTF-8 text", c);
        if (c == 0x7F || (c < 0x20 && c != '\n' && c != '\r' && c != '\t'))
            return wrong_at(r, line, "text", "control character 0x%02X; a study is plain UTF-8 text", c);
        content = content || !isspace(c);
        line += c == '\n';
        i += (size_t)length;
    }
    if (!content)
        return wrong_at(r, 1, "model", "the study is empty; `ricochet new NAME` writes one to start from");
    return RIC_OK;
}

static ric_status syntax_error(const reader *r, const yaml_parser_t *parser)
{
    return wrong_at(r, parser->problem_mark.line + 1, "syntax", "%s%s%s; check indentation, brackets and colons near column %zu",
                    parser->context ? parser->context : "", parser->context ? ", " : "",
                    parser->problem ? parser->problem : "not YAML", parser->problem_mark.column + 1);
}

typedef struct {
    long nodes, anchors, depth, documents;
} tally;

static ric_status count_event(const reader *r, const yaml_event_t *event, tally *t)
{
    size_t line = event->start_mark.line + 1;
    const yaml_char_t *anchor = NULL;
    switch (event->type) {
    case YAML_SCALAR_EVENT: anchor = event->data.scalar.anchor; break;
    case YAML_SEQUENCE_START_EVENT: anchor = event->data.sequence_start.anchor; t->depth++; break;
    case YAML_MAPPING_START_EVENT: anchor = event->data.mapping_start.anchor; t->depth++; break;
    case YAML_SEQUENCE_END_EVENT: t->depth--; break;
    case YAML_MAPPING_END_EVENT: t->depth--; break;
    case YAML_DOCUMENT_START_EVENT: t->documents++; break;
    default: break;
    }
    t->nodes++;
    t->anchors += anchor || event->type == YAML_ALIAS_EVENT;
    if (t->depth > DEPTH_MAX)
        return wrong_at(r, line, "syntax", "nested more than %d levels deep; a study needs six", DEPTH_MAX);
    if (t->anchors > ANCHOR_MAX)
        return wrong_at(r, line, "syntax", "more than %d anchors (&) and aliases (*); write the values out", ANCHOR_MAX);
    if (t->nodes > NODE_MAX)
        return wrong_at(r, line, "syntax", "more than %d values; put large matrices into Matrix Market files", NODE_MAX);
    if (t->documents > 1)
        return wrong_at(r, line, "syntax", "a second document starts here; one file holds one study");
    return RIC_OK;
}

/* A pass over the events before any tree is built: what is too deep or too much costs nothing. */
static ric_status check_limits(const reader *r, const char *text, size_t size)
{
    yaml_parser_t parser;
    yaml_event_t event;
    tally t = {0, 0, 0, 0};
    ric_status status = RIC_OK;
    if (!yaml_parser_initialize(&parser))
        return no_memory(r);
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    for (bool end = false; !end && !status;) {
        if (!yaml_parser_parse(&parser, &event)) {
            status = parser.error == YAML_MEMORY_ERROR ? no_memory(r) : syntax_error(r, &parser);
            break;
        }
        status = count_event(r, &event, &t);
        end = event.type == YAML_STREAM_END_EVENT;
        yaml_event_delete(&event);
    }
    if (!status && t.documents == 0)
        status = wrong_at(r, 1, "model", "the study is empty; `ricochet new NAME` writes one to start from");
    yaml_parser_delete(&parser);
    return status;
}

/* On success r->document is to be deleted. */
static ric_status load(reader *r, const char *text, size_t size)
{
    yaml_parser_t parser;
    ric_status status = RIC_OK;
    if (!yaml_parser_initialize(&parser))
        return no_memory(r);
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    if (!yaml_parser_load(&parser, &r->document))
        status = parser.error == YAML_MEMORY_ERROR ? no_memory(r) : syntax_error(r, &parser);
    yaml_parser_delete(&parser);
    return status;
}

/* ------------------------------------------------------------------ shapes */

static const node *at(const reader *r, int index)
{
    return yaml_document_get_node((yaml_document_t *)(uintptr_t)&r->document, index);
}

static const char *text_of(const node *value)
{
    return (const char *)value->data.scalar.value;
}

static bool is_list(const node *value)
{
    return value->type == YAML_SEQUENCE_NODE;
}

static int list_length(const node *list)
{
    return (int)(list->data.sequence.items.top - list->data.sequence.items.start);
}

static const node *list_item(const reader *r, const node *list, int i)
{
    return at(r, list->data.sequence.items.start[i]);
}

static const char *kind_of(const node *value)
{
    switch (value->type) {
    case YAML_SEQUENCE_NODE: return "a list";
    case YAML_MAPPING_NODE: return "a group of keys";
    case YAML_SCALAR_NODE: return value->data.scalar.length ? "a single value" : "nothing";
    default: return "nothing";
    }
}

static bool is_scalar(const node *value)
{
    return value->type == YAML_SCALAR_NODE;
}

/* Quoted text is no number, even if it looks like one. */
static bool is_plain(const node *value)
{
    return is_scalar(value) && value->data.scalar.style == YAML_PLAIN_SCALAR_STYLE;
}

static int edit_distance(const char *a, const char *b)
{
    enum { LONGEST = 24 };
    int row[LONGEST + 1], n = (int)strlen(b);
    if (strlen(a) > LONGEST || n > LONGEST)
        return LONGEST;
    for (int j = 0; j <= n; j++)
        row[j] = j;
    for (int i = 1; a[i - 1]; i++) {
        int diagonal = row[0];
        row[0] = i;
        for (int j = 1; j <= n; j++) {
            int best = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            best = best < row[j] + 1 ? best : row[j] + 1;
            row[j] = best < row[j - 1] + 1 ? best : row[j - 1] + 1;
        }
    }
    return row[n];
}

static void join(char out[KEY_MAX], const char *path, const char *key)
{
    snprintf(out, KEY_MAX, "%.60s%s%.32s", path, path[0] ? "." : "", key);
}

static ric_status unknown_key(const reader *r, const node *key, const char *path, int n, const char *const *keys)
{
    char full[KEY_MAX], all[300] = "";
    const char *closest = NULL;
    int distance = 3;
    for (int i = 0; i < n; i++) {
        int d = edit_distance(text_of(key), keys[i]);
        if (d < distance) {
            distance = d;
            closest = keys[i];
        }
        size_t used = strlen(all);
        snprintf(all + used, sizeof all - used, "%s%s", i ? ", " : "", keys[i]);
    }
    join(full, path, text_of(key));
    for (char *c = full; *c; c++)
        if (iscntrl((unsigned char)*c))
            *c = '?';
    if (closest)
        return wrong(r, key, full, "unknown key; did you mean '%s'?", closest);
    return wrong(r, key, full, "unknown key; the keys here are %s", all);
}

/* Fills slots[n] from a mapping: every key is known and occurs once. */
static ric_status read_map(const reader *r, const node *map, const char *path, int n, const char *const *keys, slot *slots)
{
    memset(slots, 0, (size_t)n * sizeof *slots);
    if (map->type != YAML_MAPPING_NODE)
        return wrong(r, map, path[0] ? path : "study", "expected a group of keys (%s, ...), found %s", keys[0], kind_of(map));
    for (yaml_node_pair_t *pair = map->data.mapping.pairs.start; pair < map->data.mapping.pairs.top; pair++) {
        char full[KEY_MAX];
        const node *key = at(r, pair->key);
        int i = 0;
        if (!is_scalar(key))
            return wrong(r, key, path[0] ? path : "study", "a key is %s; keys are words", kind_of(key));
        while (i < n && strcmp(keys[i], text_of(key)))
            i++;
        if (i == n)
            return unknown_key(r, key, path, n, keys);
        join(full, path, keys[i]);
        if (slots[i].key)
            return wrong(r, key, full, "given twice, first in line %zu; keep one of the two", slots[i].key->start_mark.line + 1);
        slots[i] = (slot){key, at(r, pair->value)};
    }
    return RIC_OK;
}

static ric_status read_real(const reader *r, const node *value, const char *key, double *out)
{
    if (!is_scalar(value))
        return wrong(r, value, key, "expected a number, found %s", kind_of(value));
    if (!is_plain(value))
        return wrong(r, value, key, "expected a number, found the quoted text '%.40s'; remove the quotes", text_of(value));
    switch (ric_text_real(text_of(value), out)) {
    case RIC_TEXT_NUMBER: return RIC_OK;
    case RIC_TEXT_NOT_FINITE: return wrong(r, value, key, "'%.40s' is not finite; NaN and infinities have no meaning here, give a number",
                                           text_of(value));
    case RIC_TEXT_NO_NUMBER: break;
    }
    if (!text_of(value)[0])
        return wrong(r, value, key, "no value; give a number");
    return wrong(r, value, key, "'%.40s' is not a number; write it in decimal, for example 0.5 or 2.5e-3", text_of(value));
}

/* *out is allocated; the text has no NUL inside (a quoted "\0" may try). */
static ric_status read_string(const reader *r, const node *value, const char *key, char **out)
{
    if (!is_scalar(value))
        return wrong(r, value, key, "expected a text, found %s", kind_of(value));
    if (value->data.scalar.length > STRING_MAX || strlen(text_of(value)) != value->data.scalar.length)
        return wrong(r, value, key, "the text is longer than %d bytes or has a zero byte inside; shorten it", STRING_MAX);
    *out = strdup(text_of(value));
    return *out ? RIC_OK : no_memory(r);
}

/* ---------------------------------------------------------------- matrices */

static ric_status read_row(const reader *r, const node *row, const char *key, int i, int n, double *out)
{
    if (!is_list(row))
        return wrong(r, row, key, "row %d is %s; a matrix is a list of rows such as [[2, 0], [0, 1]], or {file: M.mtx}", i + 1,
                     kind_of(row));
    if (list_length(row) != n)
        return wrong(r, row, key, "row %d has %d entries, but there are %d rows; the matrix must be square", i + 1, list_length(row), n);
    for (int j = 0; j < n; j++) {
        char entry[KEY_MAX + 32];
        const node *item = list_item(r, row, j);
        snprintf(entry, sizeof entry, "%s, row %d, column %d", key, i + 1, j + 1);
        ric_status status = read_real(r, item, entry, &out[j]);
        if (status)
            return status;
    }
    return RIC_OK;
}

static ric_status read_rows(const reader *r, const node *list, const char *key, int *n, double **out)
{
    *n = list_length(list);
    if (*n < 1 || *n > RIC_MATRIX_MAX)
        return wrong(r, list, key, "%d rows; there must be 1 to %d", *n, RIC_MATRIX_MAX);
    *out = malloc((size_t)*n * (size_t)*n * sizeof **out);
    if (!*out)
        return no_memory(r);
    for (int i = 0; i < *n; i++) {
        ric_status status = read_row(r, list_item(r, list, i), key, i, *n, *out + (size_t)i * (size_t)*n);
        if (status)
            return status;
    }
    return RIC_OK;
}

static ric_status read_matrix_file(const reader *r, const node *map, const char *key, int *n, double **out)
{
    static const char *const keys[] = {"file"};
    slot file;
    char *name = NULL, *path = NULL, why[600];
    ric_status status = read_map(r, map, key, 1, keys, &file);
    if (status)
        goto out;
    if (!file.key) {
        status = wrong(r, map, key, "no key 'file'; write {file: M.mtx}");
        goto out;
    }
    if ((status = read_string(r, file.value, key, &name)))
        goto out;
    if (!name[0]) {
        status = wrong(r, file.value, key, "the file has no name; write {file: M.mtx}");
        goto out;
    }
    bool relative = name[0] != '/' && r->base && r->base[0];
    size_t size = strlen(name) + (relative ? strlen(r->base) : 0) + 2;
    if (!(path = malloc(size))) {
        status = no_memory(r);
        goto out;
    }
    snprintf(path, size, "%s%s%s", relative ? r->base : "", relative ? "/" : "", name);
    status = ric_matrix_market_read(path, n, out);
    if (status == RIC_E_INPUT) {
        snprintf(why, sizeof why, "%s", ric_detail());
        status = wrong(r, file.value, key, "%s", why);
    }
out:
    free(name);
    free(path);
    return status;
}

/* Twice the stored rounding of a symmetric matrix that some program wrote; larger differences are mistakes. */
#define SYMMETRY_TOLERANCE 1e-12

static ric_status check_symmetric(const reader *r, const node *value, const char *key, int n, double *A)
{
    double largest = 0;
    for (size_t i = 0; i < (size_t)n * (size_t)n; i++)
        largest = fmax(largest, fabs(A[i]));
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) {
            double *low = &A[(size_t)i * (size_t)n + (size_t)j], *high = &A[(size_t)j * (size_t)n + (size_t)i];
            const node *row = is_list(value) ? list_item(r, value, i) : value;
            if (fabs(*low - *high) > SYMMETRY_TOLERANCE * largest)
                return wrong(r, row, key, "not symmetric: row %d, column %d is %.10g but row %d, column %d is %.10g; make them equal",
                             i + 1, j + 1, *low, j + 1, i + 1, *high);
            *low = *high = *low == *high ? *low : 0.5 * *low + 0.5 * *high;
        }
    return RIC_OK;
}

/* n = 0 on entry: any size. */
static ric_status read_matrix(const reader *r, const slot *matrix, const char *key, int *n, double **out)
{
    int rows = 0;
    ric_status status;
    if (is_list(matrix->value))
        status = read_rows(r, matrix->value, key, &rows, out);
    else if (matrix->value->type == YAML_MAPPING_NODE)
        status = read_matrix_file(r, matrix->value, key, &rows, out);
    else
        return wrong(r, matrix->value, key, "expected a matrix, found %s; write rows such as [[2, 0], [0, 1]], or {file: M.mtx}",
                     kind_of(matrix->value));
    if (!status && *n && rows != *n)
        status = wrong(r, matrix->key, key, "%d x %d, but the mass matrix is %d x %d; both have one row per displacement", rows, rows, *n, *n);
    if (!status)
        status = check_symmetric(r, matrix->value, key, rows, *out);
    *n = rows;
    return status;
}

/* ---------------------------------------------------------------- contacts */

enum { C_NAME, C_NORMAL, C_CLEARANCE, C_SIDES, C_LAW, C_STIFFNESS, C_EXPONENT, C_LENGTH, C_REFERENCE, C_COUNT };
static const char *const contact_keys[C_COUNT] = {"name", "normal", "clearance", "sides", "law",
                                                  "stiffness", "exponent", "length", "reference"};
static const char *const law_names[] = {"rigid", "bilinear", "power"};
static const char *const side_names[] = {"both", "upper", "lower"};

static ric_status read_choice(const reader *r, const slot *from, const char *key, int n, const char *const *names, int *out)
{
    char all[100] = "";
    if (!from->key)
        return RIC_OK;
    for (int i = 0; i < n; i++) {
        if (is_scalar(from->value) && !strcmp(text_of(from->value), names[i])) {
            *out = i;
            return RIC_OK;
        }
        size_t used = strlen(all);
        snprintf(all + used, sizeof all - used, "%s%s", i == 0 ? "" : i + 1 == n ? " or " : ", ", names[i]);
    }
    if (!is_scalar(from->value))
        return wrong(r, from->value, key, "expected a word, found %s; write %s", kind_of(from->value), all);
    return wrong(r, from->value, key, "'%.40s' is not known; write %s", text_of(from->value), all);
}

static ric_status read_normal(const reader *r, const node *map, const slot *from, const char *key, int n, double *out)
{
    bool zero = true;
    if (!from->key)
        return wrong(r, map, key, "missing; give the list b of %d numbers that makes the gap coordinate s = b.x", n);
    if (!is_list(from->value))
        return wrong(r, from->value, key, "expected a list of %d numbers, found %s", n, kind_of(from->value));
    if (list_length(from->value) != n)
        return wrong(r, from->value, key, "%d numbers, but the mass matrix has %d rows; give one number per displacement",
                     list_length(from->value), n);
    for (int j = 0; j < n; j++) {
        ric_status status = read_real(r, list_item(r, from->value, j), key, &out[j]);
        if (status)
            return status;
        zero = zero && out[j] == 0;
    }
    if (zero)
        return wrong(r, from->value, key, "all zeros, so that no motion closes the gap; name the displacements that do, for example "
                                          "[-1, 1] for x2 - x1");
    return RIC_OK;
}

static ric_status read_positive(const reader *r, const node *map, const slot *from, const char *key, const char *meaning, double *out)
{
    if (!from->key)
        return wrong(r, map, key, "missing; give %s, a number > 0", meaning);
    ric_status status = read_real(r, from->value, key, out);
    if (!status && *out <= 0)
        status = wrong(r, from->value, key, "%.10g is not positive; give %s, a number > 0", *out, meaning);
    return status;
}

static ric_status read_clearance(const reader *r, const node *map, const slot *from, const char *key, double *out)
{
    if (!from->key)
        return wrong(r, map, key, "missing; give the distance d > 0 from rest to the stop");
    ric_status status = read_real(r, from->value, key, out);
    if (!status && *out == 0)
        return wrong(r, from->value, key, "zero; without a gap every motion impacts at any energy and the linear motions that the "
                                          "exploration starts from do not exist; use a small positive clearance");
    if (!status && *out < 0)
        return wrong(r, from->value, key, "%.10g is negative, a preloaded stop: the structure at rest would be beyond it and its "
                                          "equilibrium is not that of K; measure x from the true equilibrium and give a (small) positive clearance",
                     *out);
    return status;
}

/* Keys that a law does not have are refused one by one: a stiffness beside law rigid is most likely a forgotten law. */
static ric_status check_law_keys(const reader *r, const slot *slots, const char *path, int law)
{
    static const bool allowed[][C_COUNT] = {
        {[C_NAME] = 1, [C_NORMAL] = 1, [C_CLEARANCE] = 1, [C_SIDES] = 1, [C_LAW] = 1},
        {[C_NAME] = 1, [C_NORMAL] = 1, [C_CLEARANCE] = 1, [C_SIDES] = 1, [C_LAW] = 1, [C_STIFFNESS] = 1},
        {[C_NAME] = 1, [C_NORMAL] = 1, [C_LAW] = 1, [C_EXPONENT] = 1, [C_STIFFNESS] = 1, [C_LENGTH] = 1, [C_REFERENCE] = 1},
    };
    static const char *const takes[] = {"normal, clearance and sides", "normal, clearance, sides and stiffness",
                                        "normal, exponent, and stiffness or length with reference"};
    char key[KEY_MAX];
    for (int i = 0; i < C_COUNT; i++)
        if (slots[i].key && !allowed[law][i]) {
            join(key, path, contact_keys[i]);
            return wrong(r, slots[i].key, key, "not a key of law %s, which takes %s; remove it or change the law", law_names[law], takes[law]);
        }
    return RIC_OK;
}

static ric_status check_power(const reader *r, const node *map, const slot *slots, const char *path)
{
    char key[KEY_MAX];
    double exponent = 0, value = 0;
    ric_status status;
    join(key, path, "exponent");
    if ((status = read_positive(r, map, &slots[C_EXPONENT], key, "the power m of the force, odd and at least 3", &exponent)))
        return status;
    if (exponent == 1)
        return wrong(r, slots[C_EXPONENT].value, key, "1 is a linear spring; add it to the stiffness matrix, or give an odd m of at least 3");
    if (fmod(exponent, 2) != 1 || exponent > 1001)
        return wrong(r, slots[C_EXPONENT].value, key, "%.10g is not an odd whole number from 3 to 1001; an even power does not restore on both sides",
                     exponent);
    const slot *stiffness = &slots[C_STIFFNESS], *length = &slots[C_LENGTH], *reference = &slots[C_REFERENCE];
    join(key, path, "stiffness");
    if (stiffness->key && (length->key || reference->key))
        return wrong(r, stiffness->key, key, "given together with length or reference; give stiffness k_c, or length d with reference k");
    if (stiffness->key || (!length->key && !reference->key))
        return read_positive(r, map, stiffness, key, "k_c of the force -k_c s^m (or length with reference)", &value);
    join(key, path, "length");
    if ((status = read_positive(r, map, length, key, "d of the force -k d (s/d)^m, beside reference k", &value)))
        return status;
    join(key, path, "reference");
    return read_positive(r, map, reference, key, "k of the force -k d (s/d)^m, beside length d", &value);
}

static ric_status read_contact(const reader *r, const node *map, const char *path, int n, ric_contact *out)
{
    slot slots[C_COUNT];
    char key[KEY_MAX], *name = NULL;
    int law = RIC_LAW_RIGID, sides = RIC_SIDES_BOTH;
    double unused = 0, *normal = calloc((size_t)n, sizeof *normal);
    ric_status status;
    out->normal = normal; /* released with the contact, also on failure */
    if (!normal)
        return no_memory(r);
    if ((status = read_map(r, map, path, C_COUNT, contact_keys, slots)))
        return status;
    join(key, path, "law");
    if ((status = read_choice(r, &slots[C_LAW], key, COUNT(law_names), law_names, &law)))
        return status;
    if ((status = check_law_keys(r, slots, path, law)))
        return status;
    join(key, path, "name");
    if (slots[C_NAME].key && (status = read_string(r, slots[C_NAME].value, key, &name)))
        return status;
    out->name = name;
    join(key, path, "normal");
    if ((status = read_normal(r, map, &slots[C_NORMAL], key, n, normal)))
        return status;
    out->law = (ric_law)law;
    if (law == RIC_LAW_POWER)
        return check_power(r, map, slots, path);
    join(key, path, "clearance");
    if ((status = read_clearance(r, map, &slots[C_CLEARANCE], key, &out->clearance)))
        return status;
    join(key, path, "sides");
    if ((status = read_choice(r, &slots[C_SIDES], key, COUNT(side_names), side_names, &sides)))
        return status;
    out->sides = (ric_sides)sides;
    join(key, path, "stiffness");
    if (law == RIC_LAW_BILINEAR)
        status = read_positive(r, map, &slots[C_STIFFNESS], key, "the contact stiffness ks", &unused);
    return status;
}

static ric_status check_laws(const reader *r, const node *list, const raw_model *raw)
{
    char key[KEY_MAX];
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < raw->n_contact; i++) {
            const char *law = law_names[raw->contacts[i].law];
            snprintf(key, sizeof key, "model.contacts[%d].law", i + 1);
            if (pass == 0 && raw->contacts[i].law != raw->contacts[0].law)
                return wrong(r, list_item(r, list, i), key, "%s beside %s of contact 1; mixed laws are not supported, give all contacts one law",
                             law, law_names[raw->contacts[0].law]);
            if (pass == 1 && raw->contacts[i].law != RIC_LAW_RIGID)
                return wrong(r, list_item(r, list, i), key, "%s is not computed by this version, which has rigid contacts only; write "
                                                            "law: rigid with normal, clearance and sides", law);
        }
    return RIC_OK;
}

static ric_status read_contacts(const reader *r, const node *map, const slot *from, raw_model *raw)
{
    char key[KEY_MAX];
    if (!from->key)
        return wrong(r, map, "model.contacts", "missing; give a list with normal and clearance of each stop");
    if (!is_list(from->value))
        return wrong(r, from->value, "model.contacts", "expected a list, found %s; start each contact with '- '", kind_of(from->value));
    int n = list_length(from->value);
    if (n < 1 || n > CONTACT_MAX)
        return wrong(r, from->value, "model.contacts", "%d contacts; there must be 1 to %d, without any the structure is linear", n, CONTACT_MAX);
    raw->contacts = calloc((size_t)n, sizeof *raw->contacts);
    if (!raw->contacts)
        return no_memory(r);
    for (int i = 0; i < n; i++) {
        snprintf(key, sizeof key, "model.contacts[%d]", i + 1);
        raw->n_contact = i + 1;
        ric_status status = read_contact(r, list_item(r, from->value, i), key, raw->n, &raw->contacts[i]);
        if (status)
            return status;
    }
    return check_laws(r, from->value, raw);
}

/* ------------------------------------------------------------------- model */

enum { M_MASS, M_STIFFNESS, M_CONTACTS, M_RESTITUTION, M_COUNT };
static const char *const model_keys[M_COUNT] = {"mass", "stiffness", "contacts", "restitution"};

static void raw_model_free(raw_model *raw)
{
    for (int i = 0; i < raw->n_contact; i++) {
        free((void *)(uintptr_t)raw->contacts[i].name);
        free((void *)(uintptr_t)raw->contacts[i].normal);
    }
    free(raw->contacts);
    free(raw->mass);
    free(raw->stiffness);
}

/* What the model itself finds (eigenvalues) is said with the line of the key it is about. */
static ric_status create_model(const reader *r, const node *key, const slot *slots, const raw_model *raw, ric_model **out)
{
    static const char *const words[] = {"mass", "stiffness"};
    char why[600];
    ric_status status = ric_model_create(raw->n, raw->mass, raw->stiffness, raw->n_contact, raw->contacts, raw->restitution, out);
    if (status != RIC_E_INPUT)
        return status;
    snprintf(why, sizeof why, "%s", ric_detail());
    for (int i = 0; i < COUNT(words); i++)
        if (!strncmp(why, words[i], strlen(words[i])))
            return wrong(r, slots[i].key, i == M_MASS ? "model.mass" : "model.stiffness", "%s", why);
    return wrong(r, key, "model", "%s", why);
}

static ric_status read_model(const reader *r, const slot *from, raw_model *raw, ric_model **out)
{
    slot slots[M_COUNT];
    int n = 0;
    ric_status status = read_map(r, from->value, "model", M_COUNT, model_keys, slots);
    if (status)
        return status;
    if (!slots[M_MASS].key)
        return wrong(r, from->key, "model.mass", "missing; give rows such as [[2, 0], [0, 1]], or {file: M.mtx}");
    if (!slots[M_STIFFNESS].key)
        return wrong(r, from->key, "model.stiffness", "missing; give rows such as [[9, -1], [-1, 1]], or {file: K.mtx}");
    if ((status = read_matrix(r, &slots[M_MASS], "model.mass", &n, &raw->mass)))
        return status;
    raw->n = n;
    if ((status = read_matrix(r, &slots[M_STIFFNESS], "model.stiffness", &n, &raw->stiffness)))
        return status;
    if ((status = read_contacts(r, from->key, &slots[M_CONTACTS], raw)))
        return status;
    raw->restitution = 1;
    const node *restitution = slots[M_RESTITUTION].value;
    raw->restitution_line = restitution ? restitution->start_mark.line + 1 : 0;
    if (restitution && (status = read_real(r, restitution, "model.restitution", &raw->restitution)))
        return status;
    if (raw->restitution < 0 || raw->restitution > 1)
        return wrong(r, restitution, "model.restitution", "%.10g is out of range; give a number in [0, 1], 1 for an atlas", raw->restitution);
    return create_model(r, from->key, slots, raw, out);
}

/* ----------------------------------------------------------------- explore */

static ric_status read_option(const reader *r, const ric_option *option, const char *key, const node *value, ric_explore_options *out)
{
    enum { LONGEST = COUNT(out->start) + 1 };
    const char *texts[LONGEST] = {NULL};
    char why[300];
    bool list = is_list(value);
    int n = list ? list_length(value) : 1, item = -1;
    if (value->type == YAML_MAPPING_NODE)
        return wrong(r, value, key, "expected a value, found %s", kind_of(value));
    for (int i = 0; i < n && i < LONGEST; i++) {
        const node *part = list ? list_item(r, value, i) : value;
        if (!is_scalar(part) || (!is_plain(part) && option->type != RIC_OPTION_MODES))
            return wrong(r, part, key, "expected a plain value, found %s", is_scalar(part) ? "quoted text; remove the quotes" : kind_of(part));
        texts[i] = text_of(part);
    }
    ric_status status = ric_option_read(option, list, n < LONGEST ? n : LONGEST, texts, out, &item);
    if (status != RIC_E_INPUT)
        return status;
    snprintf(why, sizeof why, "%s", ric_detail());
    return wrong(r, list && item >= 0 ? list_item(r, value, item) : value, key, "%s", why);
}

/* *start: where the list of modes stands, NULL if it is not given. */
static ric_status read_explore(const reader *r, const slot *from, const node **start, ric_explore_options *out)
{
    enum { MOST = 32 };
    const ric_option *options, *found[MOST];
    const char *keys[MOST] = {NULL};
    slot slots[MOST];
    char key[KEY_MAX];
    int n_option, n = 0;
    options = ric_options_list(&n_option);
    for (int i = 0; i < n_option && n < MOST; i++)
        if (!strcmp(options[i].section, "explore")) {
            found[n] = &options[i];
            keys[n++] = options[i].key;
        }
    ric_status status = from->key ? read_map(r, from->value, "explore", n, keys, slots) : RIC_OK;
    for (int i = 0; from->key && i < n && !status; i++) {
        join(key, "explore", keys[i]);
        if (slots[i].key)
            status = read_option(r, found[i], key, slots[i].value, out);
        if (found[i]->type == RIC_OPTION_MODES)
            *start = slots[i].value;
    }
    return status;
}

static ric_status check_start(const reader *r, const node *start, int n_dof, const ric_explore_options *options)
{
    for (int i = 0; i < options->n_start; i++)
        if (options->start[i] > n_dof)
            return wrong(r, start, "explore.start", "there is no mode %d; the structure has modes 1 to %d", options->start[i], n_dof);
    return RIC_OK;
}

/* ------------------------------------------------------------------- names */

static ric_status check_kind(const reader *r, const node *value, const char *key)
{
    for (int kind = RIC_KIND_START; kind <= RIC_KIND_USER; kind++)
        if (!strcmp(text_of(value), ric_kind_text((ric_kind)kind)))
            return RIC_OK;
    return wrong(r, value, key, "'%.40s' is no kind of junction; write start, grazing, corner, extremum, branch-point, multiplication, "
                                "period-extremum or user", text_of(value));
}

static ric_status read_name(const reader *r, const node *map, const char *path, ric_name *out)
{
    static const char *const keys[] = {"name", "kind", "energy", "frequency"};
    slot slots[4];
    char key[KEY_MAX], *texts[2] = {NULL, NULL};
    ric_status status = read_map(r, map, path, 4, keys, slots);
    for (int i = 0; i < 4 && !status; i++) {
        join(key, path, keys[i]);
        if (!slots[i].key)
            status = wrong(r, map, key, "missing; a name is {name: C1_32, kind: branch-point, energy: 1.9, frequency: 1.4}");
        else if (i < 2)
            status = read_string(r, slots[i].value, key, &texts[i]);
        else
            status = read_real(r, slots[i].value, key, i == 2 ? &out->energy : &out->frequency);
        if (!status && i == 1)
            status = check_kind(r, slots[1].value, key);
    }
    out->name = texts[0];
    out->kind = texts[1];
    join(key, path, "energy");
    if (!status && out->energy < 0)
        status = wrong(r, slots[2].value, key, "%.10g is negative; give the scaled energy of the junction", out->energy);
    join(key, path, "frequency");
    if (!status && out->frequency <= 0)
        status = wrong(r, slots[3].value, key, "%.10g is not positive; give the frequency of the junction in rad/s", out->frequency);
    return status;
}

static ric_status read_names(const reader *r, const slot *from, ric_study *study)
{
    char key[KEY_MAX];
    if (!from->key)
        return RIC_OK;
    if (!is_list(from->value))
        return wrong(r, from->value, "names", "expected a list, found %s; write '- {name: C1_32, kind: branch-point, energy: 1.9, frequency: 1.4}'",
                     kind_of(from->value));
    int n = list_length(from->value);
    if (n > NAME_MAX_COUNT)
        return wrong(r, from->value, "names", "%d names; at most %d are read", n, NAME_MAX_COUNT);
    study->names = calloc((size_t)n + 1, sizeof *study->names);
    if (!study->names)
        return no_memory(r);
    for (int i = 0; i < n; i++) {
        snprintf(key, sizeof key, "names[%d]", i + 1);
        study->n_name = i + 1;
        ric_status status = read_name(r, list_item(r, from->value, i), key, &study->names[i]);
        if (status)
            return status;
    }
    return RIC_OK;
}

/* ----------------------------------------------------------------- writing */

/* Double-quoted YAML: what is not plainly printable is escaped, so that any text comes back as it was. */
static void write_string(const char *text, FILE *out)
{
    const unsigned char *c = (const unsigned char *)text;
    fputc('"', out);
    while (*c) {
        int length = utf8_length(c);
        unsigned code = length < 2 ? c[0] : c[0] & (0x7Fu >> length);
        for (int i = 1; i < length; i++)
            code = code << 6 | (c[i] & 0x3Fu);
        if (code == '"' || code == '\\')
            fprintf(out, "\\%c", (int)code);
        else if (code < 0x20 || (code >= 0x7F && code <= 0xA0) || (code >= 0x2028 && code <= 0x2029) || code >= 0xFEFF)
            fprintf(out, "\\U%08X", code);
        else
            fwrite(c, 1, (size_t)length, out);
        c += length ? length : 1;
    }
    fputc('"', out);
}

static void write_list(int n, const double *values, FILE *out)
{
    for (int i = 0; i < n; i++) {
        fputs(i ? ", " : "[", out);
        ric_text_write(values[i], out);
    }
    fputs("]\n", out);
}

static void write_matrix(const char *key, int n, const double *A, FILE *out)
{
    fprintf(out, "  %s:\n", key);
    for (int i = 0; i < n; i++) {
        fputs("    - ", out);
        write_list(n, A + (size_t)i * (size_t)n, out);
    }
}

static void write_model(const raw_model *raw, FILE *out)
{
    fputs("model:\n", out);
    write_matrix("mass", raw->n, raw->mass, out);
    write_matrix("stiffness", raw->n, raw->stiffness, out);
    fputs("  restitution: ", out);
    ric_text_write(raw->restitution, out);
    fputs("\n  contacts:\n", out);
    for (int i = 0; i < raw->n_contact; i++) {
        const ric_contact *contact = &raw->contacts[i];
        fputs("    - normal: ", out);
        write_list(raw->n, contact->normal, out);
        if (contact->name) {
            fputs("      name: ", out);
            write_string(contact->name, out);
            fputc('\n', out);
        }
        fputs("      clearance: ", out);
        ric_text_write(contact->clearance, out);
        fprintf(out, "\n      sides: %s\n      law: %s\n", side_names[contact->sides], law_names[contact->law]);
    }
}

static void write_options(const ric_explore_options *options, FILE *out)
{
    int n;
    const ric_option *list = ric_options_list(&n);
    for (int top = 0; top < 2; top++) {
        if (!top)
            fputs("explore:\n", out);
        for (int i = 0; i < n; i++) {
            if ((list[i].section[0] == '\0') != top)
                continue;
            fprintf(out, "%s%s: ", top ? "" : "  ", list[i].key);
            ric_option_write(&list[i], options, out);
            fputc('\n', out);
        }
    }
}

static void write_names(const ric_study *study, FILE *out)
{
    if (study->n_name)
        fputs("names:\n", out);
    for (int i = 0; i < study->n_name; i++) {
        fputs("  - {name: ", out);
        write_string(study->names[i].name, out);
        fprintf(out, ", kind: %s, energy: ", study->names[i].kind);
        ric_text_write(study->names[i].energy, out);
        fputs(", frequency: ", out);
        ric_text_write(study->names[i].frequency, out);
        fputs("}\n", out);
    }
}

/* Text of the study with the explore options as they are now; the rest from `raw`, or from the text there is if raw is NULL. */
static ric_status write_text(ric_study *study, const raw_model *raw)
{
    char *text = NULL;
    size_t size = 0, begin, end;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return ric_fail(RIC_E_NOMEM, "no memory for the text of the study");
    if (raw) {
        fputs("title: ", out);
        write_string(study->title, out);
        fputc('\n', out);
        write_model(raw, out);
    } else
        fwrite(study->text, 1, study->explore_at, out);
    fflush(out);
    begin = size;
    write_options(&study->options, out);
    fflush(out);
    end = size;
    if (raw)
        write_names(study, out);
    else
        fputs(study->text + study->explore_end, out);
    bool failed = ferror(out);
    if (fclose(out) || failed) {
        free(text);
        return ric_fail(RIC_E_NOMEM, "no memory for the text of the study");
    }
    free(study->text);
    study->text = text;
    study->explore_at = begin;
    study->explore_end = end;
    return RIC_OK;
}

/* ------------------------------------------------------------------- study */

enum { S_TITLE, S_MODEL, S_EXPLORE, S_NAMES, S_TOLERANCE, S_COUNT };
static const char *const study_keys[S_COUNT] = {"title", "model", "explore", "names", "tolerance"};

static ric_status read_study(const reader *r, ric_study *study, raw_model *raw)
{
    slot slots[S_COUNT];
    const node *root = at(r, 1), *start = NULL;
    ric_status status = read_map(r, root, "", S_COUNT, study_keys, slots);
    if (status)
        return status;
    if (slots[S_TITLE].key)
        status = read_string(r, slots[S_TITLE].value, "title", &study->title);
    else if (!(study->title = strdup("")))
        status = no_memory(r);
    if (status)
        return status;
    /* cheap sections first: a wrong option is told before the eigenvalues of a large model are computed */
    ric_explore_options_init(&study->options);
    if ((status = read_explore(r, &slots[S_EXPLORE], &start, &study->options)))
        return status;
    if (slots[S_TOLERANCE].key)
        status = read_option(r, ric_option_find("", "tolerance"), "tolerance", slots[S_TOLERANCE].value, &study->options);
    if (status || (status = read_names(r, &slots[S_NAMES], study)))
        return status;
    if (!slots[S_MODEL].key)
        return wrong(r, root, "model", "missing; a study has a model with mass, stiffness and contacts");
    if ((status = read_model(r, &slots[S_MODEL], raw, &study->model)))
        return status;
    study->restitution_line = raw->restitution_line;
    if ((status = check_start(r, start, raw->n, &study->options)))
        return status;
    return write_text(study, raw);
}

static ric_status parse(const char *text, size_t size, const char *label, const char *base, ric_study **out)
{
    reader r = {.label = label, .base = base};
    raw_model raw = {0};
    ric_study *study = NULL;
    bool loaded = false;
    /* numbers have a decimal point, whatever the locale of the calling program */
    locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0), before = plain ? uselocale(plain) : (locale_t)0;
    ric_status status = plain ? RIC_OK : no_memory(&r);
    if (status || (status = check_bytes(&r, text, size)) || (status = check_limits(&r, text, size)) || (status = load(&r, text, size)))
        goto out;
    loaded = true;
    study = calloc(1, sizeof *study);
    status = study ? read_study(&r, study, &raw) : no_memory(&r);
    if (status)
        goto out;
    *out = study;
    study = NULL;
out:
    ric_study_free(study);
    raw_model_free(&raw);
    if (loaded)
        yaml_document_delete(&r.document);
    if (plain) {
        uselocale(before);
        freelocale(plain);
    }
    return status;
}

ric_status ric_study_parse(const char *text, const char *label, const char *base, ric_study **out)
{
    size_t size = strlen(text);
    *out = NULL;
    if (size > FILE_MAX)
        return ric_fail(RIC_E_INPUT, "%.200s: larger than %d MB; put large matrices into Matrix Market files", label ? label : "study", FILE_MAX >> 20);
    return parse(text, size, label ? label : "study", base, out);
}

ric_status ric_study_read(const char *path, ric_study **out)
{
    char *text = NULL, *base = NULL;
    size_t size = 0;
    *out = NULL;
    ric_status status = ric_file_read(path, FILE_MAX, false, &text, &size);
    if (status)
        goto out;
    base = strdup(path);
    if (!base) {
        status = ric_fail(RIC_E_NOMEM, "%.200s: no memory for the study", path);
        goto out;
    }
    char *slash = strrchr(base, '/');
    base[!slash ? 0 : slash == base ? 1 : slash - base] = '\0';
    status = parse(text, size, path, base, out);
out:
    free(text);
    free(base);
    return status;
}

ric_status ric_study_override(ric_study *study, const char *section, const char *key, const char *text, const char *label)
{
    const ric_option *option = ric_option_find(section, key);
    ric_explore_options before = study->options;
    char why[300];
    int item;
    if (!option)
        return ric_fail(RIC_E_INPUT, "%s: there is no option '%s'", label, key);
    ric_status status = ric_option_read(option, false, 1, &text, &study->options, &item);
    if (status == RIC_E_INPUT) {
        snprintf(why, sizeof why, "%s", ric_detail());
        return ric_fail(status, "%s: %s", label, why);
    }
    if ((status = write_text(study, NULL)))
        study->options = before;
    return status;
}

void ric_study_free(ric_study *study)
{
    if (!study)
        return;
    for (int i = 0; i < study->n_name; i++) {
        free((void *)(uintptr_t)study->names[i].name);
        free((void *)(uintptr_t)study->names[i].kind);
    }
    free(study->names);
    ric_model_free(study->model);
    free(study->title);
    free(study->text);
    free(study);
}

size_t ric_study_restitution_line(const ric_study *study)
{
    return study->restitution_line;
}

const char *ric_study_title(const ric_study *study)
{
    return study->title;
}

const char *ric_study_text(const ric_study *study)
{
    return study->text;
}

const ric_model *ric_study_model(const ric_study *study)
{
    return study->model;
}

const ric_explore_options *ric_study_options(const ric_study *study)
{
    return &study->options;
}

int ric_study_n_name(const ric_study *study)
{
    return study->n_name;
}

ric_status ric_study_name(const ric_study *study, int i, ric_name *out)
{
    if (i < 0 || i >= study->n_name)
        return ric_fail(RIC_E_RANGE, "name %d does not exist; there are %d, from 0", i, study->n_name);
    *out = study->names[i];
    return RIC_OK;
}
