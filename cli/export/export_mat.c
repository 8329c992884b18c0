/* An export as a MAT file of version 5, for Octave, Matlab and SciPy: a structure for each table, a
 * field for each column. All numbers are doubles, which hold ids and counts exactly. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "export/export.h"

#ifdef WITH_MATIO
#include <matio.h>

/* Rows and columns change places: the file holds columns. */
static matvar_t *matrix(size_t rows, size_t width, const double *reals, const int64_t *integers)
{
    size_t shape[2] = {rows, width};
    double *turned = malloc((rows * width + 1) * sizeof *turned);
    for (size_t i = 0; turned && i < rows; i++)
        for (size_t k = 0; k < width; k++)
            turned[k * rows + i] = reals ? reals[i * width + k] : (double)integers[i * width + k];
    matvar_t *out = turned ? Mat_VarCreate(NULL, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, shape, turned, 0)
                           : NULL;
    free(turned);
    return out;
}

static matvar_t *text(char *value)
{
    size_t shape[2] = {*value != '\0', strlen(value)};
    return Mat_VarCreate(NULL, MAT_C_CHAR, MAT_T_UTF8, 2, shape, value, 0);
}

static matvar_t *texts(const export_column *c)
{
    size_t shape[2] = {c->n, 1};
    matvar_t *cells = Mat_VarCreate(NULL, MAT_C_CELL, MAT_T_CELL, 2, shape, NULL, 0);
    bool done = cells;
    for (size_t i = 0; done && i < c->n; i++) {
        matvar_t *cell = text(c->texts[i]);
        done = cell;
        Mat_VarSetCell(cells, (int)i, cell);
    }
    if (!done) Mat_VarFree(cells);
    return done ? cells : NULL;
}

static bool set_field(matvar_t *table, const char *name, matvar_t *value)
{
    if (!value) return false;
    Mat_VarAddStructField(table, name);
    Mat_VarSetStructFieldByName(table, name, 0, value);
    return true;
}

static bool put_column(matvar_t *table, const export_column *c, size_t rows)
{
    char name[80];
    matvar_t *value = c->kind == EXPORT_TEXT
                          ? texts(c)
                          : matrix(c->n / c->width, c->width, c->reals, c->integers);
    snprintf(name, sizeof name, "%s_n", c->name);
    return set_field(table, c->name, value) &&
           (!c->counts || set_field(table, name, matrix(rows, 1, NULL, c->counts)));
}

static matvar_t *make_table(const export_table *t)
{
    size_t shape[2] = {1, 1};
    matvar_t *table = Mat_VarCreateStruct(t->name, 2, shape, NULL, 0);
    bool done = table;
    for (int k = 0; done && k < t->n; k++) done = put_column(table, &t->columns[k], t->rows);
    if (!done) Mat_VarFree(table);
    return done ? table : NULL;
}

static bool put_table(mat_t *file, const export_table *t)
{
    matvar_t *table = make_table(t);
    const bool done = table && Mat_VarWrite(file, table, MAT_COMPRESSION_NONE) == 0;
    Mat_VarFree(table);
    return done;
}

static bool same(matvar_t *a, matvar_t *b)
{
    if (!a || !b || a->class_type != b->class_type || a->dims[0] != b->dims[0] ||
        a->dims[1] != b->dims[1])
        return false;
    const bool parts = a->class_type == MAT_C_CELL || a->class_type == MAT_C_STRUCT;
    const size_t n = a->class_type == MAT_C_STRUCT ? Mat_VarGetNumberOfFields(a)
                                                   : a->dims[0] * a->dims[1];
    if (!parts)
        return a->nbytes == b->nbytes && (!a->nbytes || !memcmp(a->data, b->data, a->nbytes));
    for (size_t i = 0; i < n; i++)
        if (!same(((matvar_t *const *)a->data)[i], ((matvar_t *const *)b->data)[i])) return false;
    return true;
}

/* matio does not say that a write has failed: what is in the file is read and compared. */
static bool has_table(mat_t *file, const export_table *t)
{
    matvar_t *table = make_table(t), *found = Mat_VarRead(file, t->name);
    const bool done = same(table, found);
    Mat_VarFree(table);
    Mat_VarFree(found);
    return done;
}

/* A variable of version 5 has a length of 32 bits. */
static bool too_long(const export_table *t)
{
    size_t bytes = 0;
    for (int k = 0; k < t->n; k++) bytes += 8 * (t->columns[k].n + t->rows) + 64;
    return bytes > (size_t)1 << 31;
}

const char *export_mat(const char *path, const export_table *tables, int n)
{
    for (int i = 0; i < n; i++)
        if (too_long(&tables[i]))
            return "a table has more than the two gigabytes of a MAT file; take .h5";
    mat_t *file = Mat_CreateVer(path, NULL, MAT_FT_MAT5);
    bool done = file;
    for (int i = 0; done && i < n; i++) done = put_table(file, &tables[i]);
    if (file) done = Mat_Close(file) == 0 && done;
    file = done ? Mat_Open(path, MAT_ACC_RDONLY) : NULL;
    done = file;
    for (int i = 0; done && i < n; i++) done = has_table(file, &tables[i]);
    if (file) Mat_Close(file);
    return done ? NULL : "the disk is full, or the file cannot be written";
}
#else
const char *export_mat(const char *path, const export_table *tables, int n)
{
    (void)path, (void)tables, (void)n;
    return "this program was built without matio; install libmatio-dev (Debian) and build again, "
           "or take .h5 or .csv";
}
#endif
