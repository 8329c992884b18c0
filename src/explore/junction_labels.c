/* Labels of junctions: the article's letter with what the junction is, and a number that counts its
 * family. A label that a finished atlas has shown stays with the key of its junction, whatever
 * larger budgets find beside it. */
#include "base/room.h"
#include "rows_parts.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *letter(ric_kind kind)
{
    switch (kind) {
    case RIC_KIND_GRAZING: return "G";
    case RIC_KIND_CORNER: return "K";
    case RIC_KIND_PERIOD_EXTREMUM: return "P";
    case RIC_KIND_START: return "O";
    case RIC_KIND_USER: return "U";
    default: return "C";
    }
}

/* ------------------------------------------------------------------ families */

/* Junctions of one family share all of their label but its number. */
static int family_order(const ric_junction *a, const ric_junction *b)
{
    int order = strcmp(letter(a->kind), letter(b->kind));
    if (order) return order;
    bool grazing = a->kind == RIC_KIND_GRAZING;
    const int mine[2] = {grazing ? a->impacts * a->multiple : a->a,
                         grazing ? a->grazings * a->multiple : a->b};
    const int yours[2] = {grazing ? b->impacts * b->multiple : b->a,
                          grazing ? b->grazings * b->multiple : b->b};
    return mine[0] != yours[0]   ? (mine[0] < yours[0] ? -1 : 1)
           : mine[1] != yours[1] ? (mine[1] < yours[1] ? -1 : 1)
                                 : 0;
}

static int label_order(const void *p, const void *q)
{
    const ric_junction *a = &(*(ric_junction_record *const *)p)->row,
                       *b = &(*(ric_junction_record *const *)q)->row;
    const int order = family_order(a, b);
    return order ? order : a->id - b->id;
}

static char *label_of(const ric_junction *row, int number)
{
    char text[64];
    const char *l = letter(row->kind);
    if (row->kind == RIC_KIND_GRAZING)
        snprintf(text, sizeof text, "G%d_%d,%d", number, row->impacts * row->multiple,
                 row->grazings * row->multiple);
    else if (*l == 'C' && row->b == 0)
        snprintf(text, sizeof text, "C%d_??", number); /* not measured yet */
    else if (*l == 'C')
        snprintf(text, sizeof text, "C%d_%d%d%s", number, row->a, row->b, row->decided ? "" : "?");
    else snprintf(text, sizeof text, "%s%d", l, number);
    return ric_strdup(text);
}

/* Whether a text is a label of the family of a junction. */
static bool is_of_family(const ric_junction *row, const char *text)
{
    const char *first = text + strcspn(text, "0123456789");
    const long number = strtol(first, NULL, 10);
    char *label = number > 0 && number < INT_MAX ? label_of(row, (int)number) : NULL;
    const bool own = label && !strcmp(label, text);
    free(label);
    return own;
}

/* ---------------------------------------------------------------------- kept */

/* A line "KEY LABEL" of what atlases of this file have shown. */
typedef struct {
    const char *key, *label;
} shown;

typedef struct {
    char *text; /* of which the lines are parts */
    int n, n_taken;
    shown *lines;       /* by key */
    const char **taken; /* labels of lines and names of the study, sorted: what no other may have */
} ledger;

static int by_key(const void *p, const void *q)
{
    return strcmp(((const shown *)p)->key, ((const shown *)q)->key);
}

static int by_text(const void *p, const void *q)
{
    return strcmp(*(const char *const *)p, *(const char *const *)q);
}

static void close_ledger(ledger *l)
{
    free(l->text);
    free(l->lines);
    free(l->taken);
}

/* A line that is none, of a file that was written by hand, is passed over. */
static ric_status open_ledger(const char *kept, int n_name, ledger *out)
{
    int most = 1;
    for (const char *at = kept; at && *at; at++) most += *at == '\n';
    *out = (ledger){.text = ric_strdup(kept ? kept : "")};
    out->lines = ric_malloc((size_t)most * sizeof *out->lines);
    out->taken = ric_malloc(((size_t)most + (size_t)n_name + 1) * sizeof *out->taken);
    if (!out->text || !out->lines || !out->taken) return ric_no_rows();
    for (char *at = out->text, *next; *at; at = next) {
        next = at + strcspn(at, "\n");
        if (*next) *next++ = '\0';
        char *label = strchr(at, ' ');
        if (!label) continue;
        *label++ = '\0';
        out->lines[out->n++] = (shown){at, label};
        out->taken[out->n_taken++] = label;
    }
    qsort(out->lines, (size_t)out->n, sizeof *out->lines, by_key);
    return RIC_OK;
}

static const shown *find_shown(const ledger *l, const char *key)
{
    const shown wanted = {.key = key};
    return l->n ? bsearch(&wanted, l->lines, (size_t)l->n, sizeof wanted, by_key) : NULL;
}

static bool is_taken(const ledger *l, const char *text)
{
    return bsearch(&text, l->taken, (size_t)l->n_taken, sizeof text, by_text) != NULL;
}

/* ------------------------------------------------------------------- numbers */

static bool is_name(int n, const char **names, const char *text)
{
    return bsearch(&text, names, (size_t)n, sizeof text, by_text) != NULL;
}

/* The label that its junction has had before; NULL if it had none, or if that is another junction's
 * name now. Whether the multiplicities were decided may have hung on the last digits: it stays,
 * too. */
static char *label_before(const ledger *l, int n_name, const char **names, ric_junction *row)
{
    const shown *line = find_shown(l, row->key);
    if (!line || is_name(n_name, names, line->label)) return NULL;
    if (is_of_family(row, line->label)) return ric_strdup(line->label);
    if (row->b == 0) return NULL;
    row->decided = !row->decided;
    if (is_of_family(row, line->label)) return ric_strdup(line->label);
    row->decided = !row->decided;
    return NULL;
}

/* The next number whose label nothing has, had, or is called. */
static char *next_label(const ledger *l, const ric_junction *row, int *number)
{
    for (;;) {
        char *label = label_of(row, ++*number);
        if (!label || !is_taken(l, label)) return label;
        free(label);
    }
}

/* Lines of junctions that are not there stay as they are. */
static ric_status write_ledger(const ledger *l, const ric_atlas *atlas, char **out)
{
    ric_buffer text;
    bool *there = ric_calloc((size_t)l->n + 1, sizeof *there);
    if (!there || !ric_buffer_open(&text)) {
        free(there);
        return ric_no_rows();
    }
    for (int i = 0; i < atlas->n_junction; i++) {
        const ric_junction *row = &atlas->junctions[i].row;
        const shown *line = find_shown(l, row->key);
        if (line) there[line - l->lines] = true;
        fprintf(text.file, "%s %s\n", row->key, row->label);
    }
    for (int i = 0; i < l->n; i++)
        if (!there[i]) fprintf(text.file, "%s %s\n", l->lines[i].key, l->lines[i].label);
    free(there);
    *out = ric_buffer_take(&text);
    return *out ? RIC_OK : ric_no_rows();
}

static ric_status give(const ledger *l, int n, ric_junction_record **list, int n_name,
                       const char **names)
{
    for (int i = 0, number = 0; i < n; i++) {
        ric_junction_record *r = list[i];
        if (i > 0 && family_order(&list[i - 1]->row, &r->row) != 0) number = 0;
        char *label = is_of_family(&r->row, r->row.name) ? ric_strdup(r->row.name)
                                                         : label_before(l, n_name, names, &r->row);
        if (!label) label = next_label(l, &r->row, &number);
        free(r->label);
        r->row.label = r->label = label;
        if (!label) return ric_no_rows();
    }
    return RIC_OK;
}

ric_status ric_junction_labels_give(const char *kept, ric_atlas *atlas)
{
    const int n = atlas->n_junction;
    ledger l = {0};
    int n_name = 0;
    ric_junction_record **list = ric_malloc(((size_t)n + 1) * sizeof(*list));
    const char **names = ric_malloc(((size_t)n + 1) * sizeof *names);
    const int n_given = ric_study_n_name(atlas->study);
    ric_status status = list && names ? open_ledger(kept, n_given, &l) : ric_no_rows();
    for (int i = 0; i < n && !status; i++) {
        list[i] = &atlas->junctions[i];
        if (*list[i]->row.name) names[n_name++] = list[i]->row.name;
    }
    for (int i = 0; i < n_given && !status; i++) { /* also of junctions that are found later */
        ric_name name;
        if (!(status = ric_study_name(atlas->study, i, &name))) l.taken[l.n_taken++] = name.name;
    }
    if (!status) {
        qsort(list, (size_t)n, sizeof *list, label_order);
        qsort(names, (size_t)n_name, sizeof *names, by_text);
        qsort(l.taken, (size_t)l.n_taken, sizeof *l.taken, by_text);
        status = give(&l, n, list, n_name, names);
    }
    free(atlas->labels);
    atlas->labels = NULL;
    if (!status && atlas->finished) status = write_ledger(&l, atlas, &atlas->labels);
    else if (!status && kept && !(atlas->labels = ric_strdup(kept))) status = ric_no_rows();
    close_ledger(&l);
    free(list);
    free(names);
    return status;
}
