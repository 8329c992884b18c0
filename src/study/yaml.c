/* The YAML of a study: bytes, limits, libyaml document, typed values; every check names file, line
 * and key. */
#include "study_parts.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "options.h"
#include "base/room.h"

/* Bounds of what is read, so that no file can take more than seconds and a few hundred megabytes.
 */
enum {
    DEPTH_MAX = 12,     /* a contact's normal is at depth 5 */
    ANCHOR_MAX = 100,   /* anchors, and aliases, of a document */
    NODE_MAX = 4000000, /* two inline matrices of 1000 rows need half of it */
    STRING_MAX = 1000,  /* bytes of a title or name */
};

/* ---------------------------------------------------------------- messages */

static ric_status vwrong(const ric_yaml *r, size_t line, const char *key, const char *format,
                         va_list arguments) __attribute__((format(printf, 4, 0)));

static ric_status vwrong(const ric_yaml *r, size_t line, const char *key, const char *format,
                         va_list arguments)
{
    char what[700];
    vsnprintf(what, sizeof what, format, arguments);
    for (char *c = what; *c; c++)
        if (iscntrl((unsigned char)*c)) *c = '?';
    return ric_fail(RIC_E_INPUT, "%.200s:%zu: %s: %s", r->label, line, key, what);
}

static ric_status wrong_at(const ric_yaml *r, size_t line, const char *key, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

static ric_status wrong_at(const ric_yaml *r, size_t line, const char *key, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    ric_status status = vwrong(r, line, key, format, arguments);
    va_end(arguments);
    return status;
}

ric_status ric_yaml_wrong(const ric_yaml *r, const ric_yaml_node *where, const char *key,
                          const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    ric_status status = vwrong(r, where->start_mark.line + 1, key, format, arguments);
    va_end(arguments);
    return status;
}

ric_status ric_yaml_no_memory(const ric_yaml *r)
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
        if (c[i] >> 6 != 2) return 0;
        code = code << 6 | (c[i] & 0x3Fu);
    }
    return n < 2 || (code >= least[n] && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF)) ? n
                                                                                               : 0;
}

static ric_status check_bytes(const ric_yaml *r, const char *text, size_t size)
{
    size_t line = 1;
    bool content = false;
    for (size_t i = 0; i < size;) {
        unsigned char c = (unsigned char)text[i];
        int length = utf8_length((const unsigned char *)text + i);
        if (length == 0)
            return wrong_at(r, line, "text",
                            "byte 0x%02X is not UTF-8; save the study as UTF-8 text", c);
        if (c == 0x7F || (c < 0x20 && c != '\n' && c != '\r' && c != '\t'))
            return wrong_at(r, line, "text",
                            "control character 0x%02X; a study is plain UTF-8 text", c);
        content = content || !isspace(c);
        line += c == '\n';
        i += (size_t)length;
    }
    if (!content)
        return wrong_at(r, 1, "model",
                        "the study is empty; `ricochet new NAME` writes one to start from");
    return RIC_OK;
}

/* Whether a tab is among the blanks that line `line`, from 0, begins with. */
static bool tab_indents(const char *text, size_t line)
{
    for (; line > 0 && text; line--) {
        text = strchr(text, '\n');
        text += text != NULL;
    }
    return text && memchr(text, '\t', strspn(text, " \t"));
}

/* libyaml names every problem but, now and then, that of memory. */
static ric_status parser_failed(const ric_yaml *r, const yaml_parser_t *parser)
{
    if (parser->error == YAML_MEMORY_ERROR || !parser->problem) return ric_yaml_no_memory(r);
    if (tab_indents(r->text, parser->problem_mark.line))
        return wrong_at(r, parser->problem_mark.line + 1, "syntax",
                        "a tab stands in the indentation of this line; YAML is indented by blanks, "
                        "never by tabs");
    return wrong_at(r, parser->problem_mark.line + 1, "syntax",
                    "%s%s%s; check indentation, brackets and colons near column %zu",
                    parser->context ? parser->context : "", parser->context ? ", " : "",
                    parser->problem, parser->problem_mark.column + 1);
}

typedef struct {
    long nodes, anchors, depth, documents;
} tally;

static ric_status count_event(const ric_yaml *r, const yaml_event_t *event, tally *t)
{
    size_t line = event->start_mark.line + 1;
    const yaml_char_t *anchor = NULL;
    switch (event->type) {
    case YAML_SCALAR_EVENT: anchor = event->data.scalar.anchor; break;
    case YAML_SEQUENCE_START_EVENT:
        anchor = event->data.sequence_start.anchor;
        t->depth++;
        break;
    case YAML_MAPPING_START_EVENT:
        anchor = event->data.mapping_start.anchor;
        t->depth++;
        break;
    case YAML_SEQUENCE_END_EVENT: t->depth--; break;
    case YAML_MAPPING_END_EVENT: t->depth--; break;
    case YAML_DOCUMENT_START_EVENT: t->documents++; break;
    default: break;
    }
    t->nodes++;
    t->anchors += anchor || event->type == YAML_ALIAS_EVENT;
    if (t->depth > DEPTH_MAX)
        return wrong_at(r, line, "syntax", "nested more than %d levels deep; a study needs six",
                        DEPTH_MAX);
    if (t->anchors > ANCHOR_MAX)
        return wrong_at(r, line, "syntax",
                        "more than %d anchors (&) and aliases (*); write the values out",
                        ANCHOR_MAX);
    if (t->nodes > NODE_MAX)
        return wrong_at(r, line, "syntax",
                        "more than %d values; put large matrices into Matrix Market files",
                        NODE_MAX);
    if (t->documents > 1)
        return wrong_at(r, line, "syntax",
                        "a second document starts here; one file holds one study");
    return RIC_OK;
}

/* A pass over the events before any tree is built: what is too deep or too much costs nothing. */
static ric_status check_limits(const ric_yaml *r, const char *text, size_t size)
{
    yaml_parser_t parser;
    yaml_event_t event;
    tally t = {0, 0, 0, 0};
    ric_status status = RIC_OK;
    if (!yaml_parser_initialize(&parser)) return ric_yaml_no_memory(r);
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    for (bool end = false; !end && !status;) {
        if (!yaml_parser_parse(&parser, &event)) {
            status = parser_failed(r, &parser);
            break;
        }
        status = count_event(r, &event, &t);
        end = event.type == YAML_STREAM_END_EVENT;
        yaml_event_delete(&event);
    }
    if (!status && t.documents == 0)
        status = wrong_at(r, 1, "model",
                          "the study is empty; `ricochet new NAME` writes one to start from");
    yaml_parser_delete(&parser);
    return status;
}

static ric_status load(ric_yaml *r, const char *text, size_t size)
{
    yaml_parser_t parser;
    ric_status status = RIC_OK;
    if (!yaml_parser_initialize(&parser)) return ric_yaml_no_memory(r);
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, size);
    if (!yaml_parser_load(&parser, &r->document)) status = parser_failed(r, &parser);
    yaml_parser_delete(&parser);
    return status;
}

ric_status ric_yaml_load(ric_yaml *r, const char *text, size_t size)
{
    r->text = text;
    ric_status status = check_bytes(r, text, size);
    if (!status) status = check_limits(r, text, size);
    if (!status) status = load(r, text, size);
    r->text = NULL;
    return status;
}

void ric_yaml_unload(ric_yaml *r)
{
    yaml_document_delete(&r->document);
}

/* ------------------------------------------------------------------ shapes */

static const ric_yaml_node *at(const ric_yaml *r, int index)
{
    return yaml_document_get_node((yaml_document_t *)(uintptr_t)&r->document, index);
}

const ric_yaml_node *ric_yaml_root(const ric_yaml *r)
{
    return at(r, 1);
}

const char *ric_yaml_text(const ric_yaml_node *value)
{
    return (const char *)value->data.scalar.value;
}

bool ric_yaml_is_list(const ric_yaml_node *value)
{
    return value->type == YAML_SEQUENCE_NODE;
}

int ric_yaml_length(const ric_yaml_node *list)
{
    return (int)(list->data.sequence.items.top - list->data.sequence.items.start);
}

const ric_yaml_node *ric_yaml_item(const ric_yaml *r, const ric_yaml_node *list, int i)
{
    return at(r, list->data.sequence.items.start[i]);
}

const char *ric_yaml_kind(const ric_yaml_node *value)
{
    switch (value->type) {
    case YAML_SEQUENCE_NODE: return "a list";
    case YAML_MAPPING_NODE: return "a group of keys";
    case YAML_SCALAR_NODE: return value->data.scalar.length ? "a single value" : "nothing";
    default: return "nothing";
    }
}

bool ric_yaml_is_scalar(const ric_yaml_node *value)
{
    return value->type == YAML_SCALAR_NODE;
}

bool ric_yaml_is_plain(const ric_yaml_node *value)
{
    return ric_yaml_is_scalar(value) && value->data.scalar.style == YAML_PLAIN_SCALAR_STYLE;
}

static int edit_distance(const char *a, const char *b)
{
    enum { LONGEST = 24 };
    int row[LONGEST + 1], n = (int)strlen(b);
    if (strlen(a) > LONGEST || n > LONGEST) return LONGEST;
    for (int j = 0; j <= n; j++) row[j] = j;
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

void ric_yaml_join(char out[RIC_KEY_MAX], const char *path, const char *key)
{
    snprintf(out, RIC_KEY_MAX, "%.60s%s%.32s", path, path[0] ? "." : "", key);
}

static size_t shared(const char *a, const char *b)
{
    size_t n = 0;
    while (a[n] && a[n] == b[n]) n++;
    return n;
}

enum { STEM = 4 }; /* letters at the beginning that make two words forms of one */

/* The key that is meant: by another word, with a slip of the pen in less than half of it, or in
 * another form. */
static const char *meant_key(const char *found, int n, const char *const *keys)
{
    const char *meant = ric_study_word_of_key(found, n, keys);
    int distance = 3;
    for (int i = 0; i < n && !ric_study_word_of_key(found, n, keys); i++) {
        int d = edit_distance(found, keys[i]);
        if (d < distance && 2 * d < (int)strlen(found)) {
            distance = d;
            meant = keys[i];
        }
    }
    for (int i = 0; i < n && !meant; i++)
        if (shared(found, keys[i]) >= STEM) meant = keys[i];
    return meant;
}

static ric_status unknown_key(const ric_yaml *r, const ric_yaml_node *key, const char *path, int n,
                              const char *const *keys)
{
    char full[RIC_KEY_MAX], all[300] = "";
    const char *closest = meant_key(ric_yaml_text(key), n, keys),
               *none = ric_study_word_of_nothing(ric_yaml_text(key));
    for (int i = 0; i < n; i++) {
        size_t used = strlen(all);
        snprintf(all + used, sizeof all - used, "%s%s", i ? ", " : "", keys[i]);
    }
    ric_yaml_join(full, path, ric_yaml_text(key));
    for (char *c = full; *c; c++)
        if (iscntrl((unsigned char)*c)) *c = '?';
    if (none)
        return ric_yaml_wrong(r, key, full, "unknown key; %s; the keys here are %s", none, all);
    if (closest) return ric_yaml_wrong(r, key, full, "unknown key; did you mean '%s'?", closest);
    return ric_yaml_wrong(r, key, full, "unknown key; the keys here are %s", all);
}

ric_status ric_yaml_map(const ric_yaml *r, const ric_yaml_node *map, const char *path, int n,
                        const char *const *keys, ric_yaml_slot *slots)
{
    memset(slots, 0, (size_t)n * sizeof *slots);
    if (map->type != YAML_MAPPING_NODE)
        return ric_yaml_wrong(r, map, path[0] ? path : "study",
                              "expected a group of keys (%s, ...), found %s", keys[0],
                              ric_yaml_kind(map));
    for (yaml_node_pair_t *pair = map->data.mapping.pairs.start; pair < map->data.mapping.pairs.top;
         pair++) {
        char full[RIC_KEY_MAX];
        const ric_yaml_node *key = at(r, pair->key);
        int i = 0;
        if (!ric_yaml_is_scalar(key))
            return ric_yaml_wrong(r, key, path[0] ? path : "study", "a key is %s; keys are words",
                                  ric_yaml_kind(key));
        while (i < n && strcmp(keys[i], ric_yaml_text(key))) i++;
        if (i == n) return unknown_key(r, key, path, n, keys);
        ric_yaml_join(full, path, keys[i]);
        if (slots[i].key)
            return ric_yaml_wrong(r, key, full,
                                  "given twice, first in line %zu; keep one of the two",
                                  slots[i].key->start_mark.line + 1);
        slots[i] = (ric_yaml_slot){key, at(r, pair->value)};
    }
    return RIC_OK;
}

ric_status ric_yaml_real(const ric_yaml *r, const ric_yaml_node *value, const char *key,
                         double *out)
{
    if (!ric_yaml_is_scalar(value))
        return ric_yaml_wrong(r, value, key, "expected a number, found %s", ric_yaml_kind(value));
    if (!ric_yaml_is_plain(value))
        return ric_yaml_wrong(r, value, key,
                              "expected a number, found the quoted text '%.40s'; remove the quotes",
                              ric_yaml_text(value));
    switch (ric_option_text_real(ric_yaml_text(value), out)) {
    case RIC_TEXT_NUMBER: return RIC_OK;
    case RIC_TEXT_NOT_FINITE:
        return ric_yaml_wrong(r, value, key,
                              "'%.40s' is not finite; NaN and infinities have no meaning here, "
                              "give a number",
                              ric_yaml_text(value));
    case RIC_TEXT_NO_NUMBER: break;
    }
    if (!ric_yaml_text(value)[0]) return ric_yaml_wrong(r, value, key, "no value; give a number");
    return ric_yaml_wrong(r, value, key,
                          "'%.40s' is not a number; write it in decimal, for example 0.5 or 2.5e-3",
                          ric_yaml_text(value));
}

ric_status ric_yaml_string(const ric_yaml *r, const ric_yaml_node *value, const char *key,
                           char **out)
{
    if (!ric_yaml_is_scalar(value))
        return ric_yaml_wrong(r, value, key, "expected a text, found %s", ric_yaml_kind(value));
    if (value->data.scalar.length > STRING_MAX ||
        strlen(ric_yaml_text(value)) != value->data.scalar.length)
        return ric_yaml_wrong(
            r, value, key, "the text is longer than %d bytes or has a zero byte inside; shorten it",
            STRING_MAX);
    *out = ric_strdup(ric_yaml_text(value));
    return *out ? RIC_OK : ric_yaml_no_memory(r);
}

ric_status ric_yaml_choice(const ric_yaml *r, const ric_yaml_slot *from, const char *key, int n,
                           const char *const *names, int *out)
{
    char all[100] = "";
    if (!from->key) return RIC_OK;
    for (int i = 0; i < n; i++) {
        if (ric_yaml_is_scalar(from->value) && !strcmp(ric_yaml_text(from->value), names[i])) {
            *out = i;
            return RIC_OK;
        }
        size_t used = strlen(all);
        snprintf(all + used, sizeof all - used, "%s%s",
                 i == 0       ? ""
                 : i + 1 == n ? " or "
                              : ", ",
                 names[i]);
    }
    if (!ric_yaml_is_scalar(from->value))
        return ric_yaml_wrong(r, from->value, key, "expected a word, found %s; write %s",
                              ric_yaml_kind(from->value), all);
    const char *meant = ric_study_word_of_value(ric_yaml_text(from->value));
    return ric_yaml_wrong(r, from->value, key, "'%.40s' is not known; write %s%s%s",
                          ric_yaml_text(from->value), all, meant ? "; you may mean " : "",
                          meant ? meant : "");
}

/* ----------------------------------------------------------------- writing */

void ric_yaml_write(const char *text, FILE *out)
{
    const unsigned char *c = (const unsigned char *)text;
    fputc('"', out);
    while (*c) {
        int length = utf8_length(c);
        unsigned code = length < 2 ? c[0] : c[0] & (0x7Fu >> length);
        for (int i = 1; i < length; i++) code = code << 6 | (c[i] & 0x3Fu);
        if (code == '"' || code == '\\') fprintf(out, "\\%c", (int)code);
        else if (code < 0x20 || (code >= 0x7F && code <= 0xA0) ||
                 (code >= 0x2028 && code <= 0x2029) || code >= 0xFEFF)
            fprintf(out, "\\U%08X", code);
        else fwrite(c, 1, (size_t)length, out);
        c += length ? length : 1;
    }
    fputc('"', out);
}
