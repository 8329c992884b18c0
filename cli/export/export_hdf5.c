/* An export as HDF5: a group for each table, a dataset for each column. */
#include <stdio.h>
#include <stdlib.h>

#include "export/export.h"

#ifdef WITH_HDF5
#include <hdf5.h>

static bool put(hid_t group, const char *name, hid_t stored, hid_t held, const hsize_t shape[2],
                const void *data)
{
    const hid_t space = H5Screate_simple(shape[1] > 1 ? 2 : 1, shape, NULL),
                set = H5Dcreate2(group, name, stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const bool done = set >= 0 &&
                      (!shape[0] || H5Dwrite(set, held, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
    const bool closed = set >= 0 && H5Dclose(set) >= 0;
    H5Sclose(space);
    return done && closed;
}

static bool put_texts(hid_t group, const export_column *c)
{
    const hid_t text = H5Tcopy(H5T_C_S1);
    H5Tset_size(text, H5T_VARIABLE);
    H5Tset_cset(text, H5T_CSET_UTF8);
    const bool done = put(group, c->name, text, text, (hsize_t[]){c->n, 1}, c->texts);
    H5Tclose(text);
    return done;
}

static bool put_column(hid_t group, const export_column *c, size_t rows)
{
    char name[80];
    const hsize_t shape[2] = {c->n / c->width, c->width};
    bool done = c->kind == EXPORT_TEXT ? put_texts(group, c)
                : c->kind == EXPORT_REAL
                    ? put(group, c->name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, shape, c->reals)
                    : put(group, c->name, H5T_STD_I64LE, H5T_NATIVE_INT64, shape, c->integers);
    snprintf(name, sizeof name, "%s_n", c->name);
    if (c->counts)
        done = done &&
               put(group, name, H5T_STD_I64LE, H5T_NATIVE_INT64, (hsize_t[]){rows, 1}, c->counts);
    return done;
}

static bool put_tables(hid_t file, const export_table *tables, int n)
{
    bool done = true;
    for (int i = 0; done && i < n; i++) {
        const hid_t group = H5Gcreate2(file, tables[i].name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        done = group >= 0;
        for (int k = 0; done && k < tables[i].n; k++)
            done = put_column(group, &tables[i].columns[k], tables[i].rows);
        if (group >= 0) H5Gclose(group);
    }
    return done && H5Fflush(file, H5F_SCOPE_LOCAL) >= 0;
}

/* The bytes of the whole file. The library makes it in memory: after a write that fails on a full
 * disk it cannot be closed any more, and ends the program. */
static void *make_image(const export_table *tables, int n, size_t *size)
{
    void *image = NULL;
    const hid_t in_memory = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_fapl_core(in_memory, (size_t)1 << 20, false);
    const hid_t file = H5Fcreate("export", H5F_ACC_TRUNC, H5P_DEFAULT, in_memory);
    H5Pclose(in_memory);
    if (file < 0) return NULL;
    const ssize_t bytes = put_tables(file, tables, n) ? H5Fget_file_image(file, NULL, 0) : -1;
    if (bytes > 0 && (image = malloc((size_t)bytes)) &&
        H5Fget_file_image(file, image, (size_t)bytes) != bytes) {
        free(image);
        image = NULL;
    }
    *size = image ? (size_t)bytes : 0;
    H5Fclose(file);
    return image;
}

const char *export_hdf5(const char *path, const export_table *tables, int n)
{
    size_t size = 0;
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    void *image = make_image(tables, n, &size);
    FILE *file = image ? fopen(path, "wb") : NULL;
    bool done = file && fwrite(image, 1, size, file) == size;
    if (file) done = fclose(file) == 0 && done;
    const char *wrong = image ? "the disk is full, or the file cannot be written" : "out of memory";
    free(image);
    return done ? NULL : wrong;
}
#else
const char *export_hdf5(const char *path, const export_table *tables, int n)
{
    (void)path, (void)tables, (void)n;
    return "this program was built without HDF5; install libhdf5-dev (Debian) and build again, or "
           "take .mat or .csv";
}
#endif
