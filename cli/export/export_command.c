/* The module export: the tables of an atlas as HDF5, as a MAT file or as comma-separated columns.
 */
#define _XOPEN_SOURCE 700

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/module.h"
#include "export/export.h"

static export_writer writer_of(const char *path)
{
    static const struct {
        const char *ending;
        export_writer write;
    } kinds[] = {{".h5", export_hdf5}, {".mat", export_mat}, {".csv", export_csv}};
    const size_t n = strlen(path);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        const size_t length = strlen(kinds[i].ending);
        if (n > length && !strcmp(path + n - length, kinds[i].ending)) return kinds[i].write;
    }
    return NULL;
}

static int check_target(const char *path)
{
    struct stat info;
    if (!writer_of(path))
        return cli_wrong("-o %s: the ending says what to write: .h5, .mat or .csv", path);
    if (lstat(path, &info) == 0 && !S_ISREG(info.st_mode))
        return cli_wrong("-o %s: this is no plain file; give another file name", path);
    return CLI_DONE;
}

/* With the rights that a new file of the user has. */
static bool give_rights(int fd)
{
    const mode_t mask = umask(0);
    umask(mask);
    return fchmod(fd, 0666 & ~mask) == 0;
}

/* Into a new file beside the target, which takes its place when all is in it. */
static int write_beside(const char *path, const export_table *tables)
{
    const size_t size = strlen(path) + 8;
    char *part = malloc(size);
    if (!part) return cli_report(RIC_E_NOMEM);
    snprintf(part, size, "%s.XXXXXX", path);
    const int fd = mkstemp(part);
    const char *wrong = fd < 0 || !give_rights(fd) ? strerror(errno) : NULL;
    if (fd >= 0) close(fd);
    if (!wrong) wrong = writer_of(path)(part, tables, EXPORT_N_TABLE);
    if (!wrong && rename(part, path)) wrong = strerror(errno);
    if (wrong) {
        if (fd >= 0) unlink(part);
        cli_say("ricochet: %s is not written: %s\n", path, wrong);
    }
    free(part);
    return wrong ? CLI_FAILED : CLI_DONE;
}

int export_command(int argc, char **argv)
{
    const char *out;
    export_table tables[EXPORT_N_TABLE] = {0};
    ric_atlas *atlas = NULL;
    if (!cli_take_value(&argc, argv, "-o", &out) || !cli_operands(&cli_export, argc, argv, 1))
        return CLI_WRONG;
    if (!out) return cli_wrong("export: -o FILE.h5, FILE.mat or FILE.csv is missing");
    if (check_target(out) != CLI_DONE) return CLI_WRONG;
    ric_status status = ric_atlas_read(argv[1], &atlas);
    if (!status) status = export_tables_make(atlas, tables);
    const int code = status ? cli_report(status) : write_beside(out, tables);
    if (code == CLI_DONE) {
        cli_print_visible(out, false);
        putchar('\n');
    }
    export_tables_free(tables);
    ric_atlas_free(atlas);
    return code;
}
