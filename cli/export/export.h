/* ricochet export: an atlas as tables of columns (export_tables.c), and who writes them:
 * export_hdf5.c, export_mat.c, export_csv.c. */
#ifndef EXPORT_H
#define EXPORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/cli.h"

typedef enum { EXPORT_REAL, EXPORT_INTEGER, EXPORT_TEXT } export_kind;

/* One quantity of all rows of a table. Row i has `width` numbers, or, where `counts` is there,
 * counts[i]; they follow each other, `n` in all. Texts have one per row. */
typedef struct {
    char name[64];
    export_kind kind;
    size_t n, width;
    int64_t *counts; /* [rows] or NULL */
    double *reals;   /* [n] for EXPORT_REAL */
    int64_t *integers;
    char **texts;
} export_column;

enum { EXPORT_MAX_COLUMN = 64, EXPORT_N_TABLE = 5 };
typedef struct {
    const char *name;
    size_t rows;
    int n;
    export_column columns[EXPORT_MAX_COLUMN];
} export_table;

/* about, branches, points, junctions and graph. To be freed also after a failure. */
ric_status export_tables_make(const ric_atlas *atlas, export_table tables[EXPORT_N_TABLE]);
void export_tables_free(export_table tables[EXPORT_N_TABLE]);

/* What was not possible, NULL: all was done; the message is constant. The file exists already, is
 * empty and ours. */
typedef const char *(*export_writer)(const char *path, const export_table *tables, int n);
const char *export_hdf5(const char *path, const export_table *tables, int n);
const char *export_mat(const char *path, const export_table *tables, int n);
const char *export_csv(const char *path, const export_table *tables, int n);

#endif
