/* An export as comma-separated columns: one file holds all tables one after the other, each after a
 * line with its name. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "export/export.h"

static void put_text(FILE *file, const char *text)
{
    const bool plain = !strpbrk(text, ",\"\r\n");
    if (!plain) putc('"', file);
    for (; *text; text++) {
        if (*text == '"') putc('"', file);
        putc(*text, file);
    }
    if (!plain) putc('"', file);
}

/* Nothing for what is not a number; 17 digits bring every other one back. */
static void put_entry(FILE *file, const export_column *c, size_t i)
{
    if (c->kind == EXPORT_TEXT) put_text(file, c->texts[i]);
    else if (c->kind == EXPORT_INTEGER) fprintf(file, "%lld", (long long)c->integers[i]);
    else if (!isnan(c->reals[i])) fprintf(file, "%.17g", c->reals[i]);
}

/* The entries of a row from `at` on; the lists of a cell have blanks between, matrices a column for
 * each number. */
static size_t put_cell(FILE *file, const export_column *c, size_t row, size_t at)
{
    const size_t n = c->counts ? (size_t)c->counts[row] : c->width;
    for (size_t k = 0; k < n; k++) {
        if (k) putc(c->counts ? ' ' : ',', file);
        put_entry(file, c, at + k);
    }
    return at + n;
}

static void put_names(FILE *file, const export_table *table)
{
    for (int k = 0; k < table->n; k++) {
        const export_column *c = &table->columns[k];
        if (k) putc(',', file);
        for (size_t w = 1; c->width > 1 && w <= c->width; w++)
            fprintf(file, "%s%s_%zu", w > 1 ? "," : "", c->name, w);
        if (c->width == 1) put_text(file, c->name);
    }
    putc('\n', file);
}

static void put_table(FILE *file, const export_table *table)
{
    size_t at[EXPORT_MAX_COLUMN] = {0};
    put_names(file, table);
    for (size_t row = 0; row < table->rows; row++) {
        for (int k = 0; k < table->n; k++) {
            if (k) putc(',', file);
            at[k] = put_cell(file, &table->columns[k], row, at[k]);
        }
        putc('\n', file);
    }
}

const char *export_csv(const char *path, const export_table *tables, int n)
{
    FILE *file = fopen(path, "w");
    if (!file) return "the file cannot be opened";
    for (int i = 0; i < n; i++) {
        if (n > 1) fprintf(file, "%s# %s\n", i ? "\n" : "", tables[i].name);
        put_table(file, &tables[i]);
    }
    const bool failed = ferror(file);
    return fclose(file) || failed ? "the disk is full, or the file cannot be written" : NULL;
}
