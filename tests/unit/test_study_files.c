/* Studies and their matrices from files: what is read, and what is said of paths that are no files
 * and of Matrix Market files that are none. */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "ricochet.h"
#include "study/study.h"

static char folder[] = "/tmp/ricochet-study-XXXXXX";

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static const char *const files[] = {"s.yaml", "M.mtx", "K.mtx", "pipe"};

static void path_of(const char *name, char out[200])
{
    snprintf(out, 200, "%s/%s", folder, name);
}

static int remove_folder(void **state)
{
    char path[200];
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        path_of(files[i], path);
        unlink(path);
    }
    return rmdir(folder);
}

static void put(const char *name, const char *text)
{
    char path[200];
    path_of(name, path);
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs(text, out);
    fclose(out);
}

static const char with_files[] = "model:\n  mass: {file: M.mtx}\n  stiffness:\n    file: K.mtx\n"
                                 "  contacts: [{normal: [-1, 1], clearance: 1}]\n";

static void matrices_from_files(void **state)
{
    char path[200];
    ric_study *study = NULL, *again = NULL;
    (void)state;
    put("s.yaml", with_files);
    put("M.mtx", "%%MatrixMarket matrix coordinate integer symmetric\n% a comment\n\n2 2 2\n1 1 "
                 "2\n%another\n2 2 1\n");
    put("K.mtx", "%%MatrixMarket MATRIX Array Real General\n2 2\n9\n-1\n-1\n1\n");
    path_of("s.yaml", path);
    assert_int_equal(ric_study_read(path, &study), RIC_OK);
    assert_true(ric_model_mass(ric_study_model(study))[0] == 2 &&
                ric_model_stiffness(ric_study_model(study))[2] == -1);
    /* the text stands alone: it is read without the files */
    assert_int_equal(ric_study_parse(ric_study_text(study), "t", "/nowhere", &again), RIC_OK);
    assert_string_equal(ric_study_text(study), ric_study_text(again));
    ric_study_free(study);
    ric_study_free(again);
}

static void matrix_file_refused(const char *text, const char *says)
{
    char path[200];
    ric_study *study = NULL;
    put("s.yaml", with_files);
    put("M.mtx", text);
    path_of("s.yaml", path);
    assert_int_equal(ric_study_read(path, &study), RIC_E_INPUT);
    if (!strstr(ric_detail(), says) || !strstr(ric_detail(), "/s.yaml:2: model.mass: "))
        print_error("no '%s' in '%s'\n", says, ric_detail());
    assert_non_null(strstr(ric_detail(), "/s.yaml:2: model.mass: "));
    assert_non_null(strstr(ric_detail(), says));
}

#define COORDINATE "%%MatrixMarket matrix coordinate real symmetric\n"

static void bad_matrix_files(void **state)
{
    (void)state;
    matrix_file_refused("", "M.mtx:1: not a Matrix Market file");
    matrix_file_refused("1 2\n3 4\n", "M.mtx:1: not a Matrix Market file");
    matrix_file_refused("%%MatrixMarket matrix coordinate pattern symmetric\n1 1 1\n1 1\n",
                        "M.mtx:1: 'pattern' entries");
    matrix_file_refused("%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 1 0\n",
                        "M.mtx:1: 'complex' entries");
    matrix_file_refused("%%MatrixMarket matrix array real hermitian\n1 1\n1\n",
                        "M.mtx:1: 'hermitian' matrix");
    matrix_file_refused("%%MatrixMarket matrix array real skew-symmetric\n1 1\n1\n",
                        "M.mtx:1: 'skew-symmetric'");
    matrix_file_refused("%%MatrixMarket matrix banded real general\n1 1\n1\n",
                        "M.mtx:1: format 'banded'");
    matrix_file_refused(COORDINATE "2 3 1\n1 1 1\n", "2 rows but 3 columns");
    matrix_file_refused(
        COORDINATE "1001 1001 1\n1 1 1\n",
        "M.mtx:2: the number of rows is '1001'; it must be a whole number from 1 to 1000");
    matrix_file_refused(COORDINATE "99999999999999999999 1 1\n", "M.mtx:2: the number of rows");
    matrix_file_refused(COORDINATE "2 2 99999999\n",
                        "M.mtx:2: the number of entries is '99999999'");
    matrix_file_refused(COORDINATE "2 2 4\n1 1 1\n", "the file ends");
    matrix_file_refused(COORDINATE "-2 2 1\n", "the number of rows is '-2'");
    matrix_file_refused(COORDINATE "2 2 2\n1 1 1\n3 1 1\n", "M.mtx:4: a row is '3'");
    matrix_file_refused(COORDINATE "2 2 4\n1 1 1\n2 2 1\n1 2 0.5\n2 1 0.5\n",
                        "M.mtx:6: row 2, column 1, and row 1, column 2 as well");
    matrix_file_refused(COORDINATE "2 2 2\n1 1 1e308\n1 1 1e308\n",
                        "M.mtx:4: the entries of row 1, column 1 have no");
    matrix_file_refused(COORDINATE "2 2 2\n1 1 1\n", "the file ends");
    matrix_file_refused(COORDINATE "2 2 1\n1 1 1\n2 2 1\n",
                        "M.mtx:4: '2' follows after the last of 1 entries");
    matrix_file_refused(COORDINATE "2 2 2\n1 1 nan\n2 2 1\n",
                        "M.mtx:3: the entry of row 1, column 1 is 'nan'; entries must be finite");
#define ZEROS "0000000000000000000000000000000000000000000000000000000000000000000"
    matrix_file_refused(COORDINATE "2 2 2\n1 1 1\n2 2 2." ZEROS "e1\n",
                        "M.mtx:4: '2.000000000000000000...' has more than");
    matrix_file_refused(COORDINATE "2 2 2\n1 1 1\n2 " ZEROS "2 1\n",
                        "M.mtx:4: '00000000000000000000...' has more than");
    matrix_file_refused(COORDINATE "2 2 2\n1 1 1\n2 2 1D\n",
                        "M.mtx:4: the entry of row 2, column 2 is '1D'");
    matrix_file_refused(COORDINATE "2 2 2\n1 1 1\n2 2 1D999\n", "entries must be finite");
    matrix_file_refused(
        "%%MatrixMarket matrix coordinate real general\n2 2 3\n1 1 1\n2 2 1\n2 1 0.5\n",
        "all on one side of the diagonal is zero: if this is half");
    matrix_file_refused("%%MatrixMarket matrix array real general\n2 2\n1\n0.5\n0\n1\n",
                        "not symmetric");
    matrix_file_refused("%%MatrixMarket matrix array real general\n2 2\n1 0 0\n", "the file ends");
}

static void same_as_inline(const char *mass, const char *stiffness, const char *remark)
{
    char path[200];
    ric_study *study = NULL;
    put("s.yaml", with_files);
    put("M.mtx", mass);
    put("K.mtx", stiffness);
    path_of("s.yaml", path);
    if (ric_study_read(path, &study)) print_error("%s\n", ric_detail());
    assert_non_null(study);
    const double M[] = {2000, 0.5, 0.5, 1}, K[] = {9, -1, -1, 1};
    assert_memory_equal(ric_model_mass(ric_study_model(study)), M, sizeof M);
    assert_memory_equal(ric_model_stiffness(ric_study_model(study)), K, sizeof K);
    if (!strstr(ric_study_remark(study), remark)) print_error("%s\n", ric_study_remark(study));
    assert_true(*remark ? strstr(ric_study_remark(study), remark) != NULL
                        : !*ric_study_remark(study));
    ric_study_free(study);
}

/* Fortran's exponents, the upper half instead of the lower, entries that an assembly writes one
 * after the other. */
static void what_other_programs_write(void **state)
{
    static const char M[] = COORDINATE "2 2 3\n1 1 2.0D+03\n1 2 5.0d-1\n2 2 1D0\n",
                      K[] = COORDINATE "2 2 3\n1 1 9\n2 1 -1\n2 2 1\n";
    (void)state;
    same_as_inline(M, K, "");
    same_as_inline(M, COORDINATE "2 2 5\n1 1 8\n2 1 -0.5\n1 1 1\n2 2 1\n2 1 -0.5\n",
                   "model.stiffness: 2 entries of its file stand there before, and are added");
    same_as_inline(COORDINATE "2 2 4\n1 1 1.D3\n1 2 .5D0\n2 2 1\n1 1 1.D+03\n", K,
                   "model.mass: 1 entry of its file stands");
    same_as_inline(
        "%%MatrixMarket matrix coordinate real general\n2 2 5\n1 1 2000\n1 2 0.5\n2 1 0.25\n2 2 1\n"
        "2 1 0.25\n",
        K, "model.mass: 1 entry of its file stands");
}

static void matrix_paths_that_are_no_files(void **state)
{
    char path[200], text[600];
    ric_study *study = NULL;
    static const char *const names[] = {"absent.mtx", ".", "/dev/zero", "pipe", "\"\""};
    static const char *const says[] = {"No such file", "a folder", "not a plain file",
                                       "not a plain file", "no name"};
    (void)state;
    path_of("pipe", path);
    assert_int_equal(mkfifo(path, 0600), 0);
    for (int i = 0; i < 5; i++) {
        snprintf(text, sizeof text,
                 "model:\n  mass: {file: %s}\n  stiffness: [[1]]\n  contacts: []\n", names[i]);
        put("s.yaml", text);
        path_of("s.yaml", path);
        assert_int_equal(ric_study_read(path, &study), RIC_E_INPUT);
        assert_non_null(strstr(ric_detail(), "s.yaml:2: model.mass: "));
        assert_non_null(strstr(ric_detail(), says[i]));
    }
}

static void study_paths_that_are_no_files(void **state)
{
    ric_study *study = NULL;
    (void)state;
    assert_int_equal(ric_study_read("/tmp", &study), RIC_E_INPUT);
    assert_non_null(strstr(ric_detail(), "/tmp: this is a folder"));
    assert_int_equal(ric_study_read("/nowhere/s.yaml", &study), RIC_E_MISSING);
    assert_non_null(strstr(ric_detail(), "/nowhere/s.yaml: No such file"));
    assert_int_equal(ric_study_read("/dev/null", &study), RIC_E_INPUT);
    assert_non_null(strstr(ric_detail(), "/dev/null:1: model: the study is empty"));
    assert_int_equal(ric_study_read("/dev/zero", &study), RIC_E_INPUT);
    assert_non_null(strstr(ric_detail(), "larger than 64 MB"));
    assert_null(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(matrices_from_files),
        cmocka_unit_test(bad_matrix_files),
        cmocka_unit_test(what_other_programs_write),
        cmocka_unit_test(matrix_paths_that_are_no_files),
        cmocka_unit_test(study_paths_that_are_no_files),
    };
    return cmocka_run_group_tests_name("study_files", tests, make_folder, remove_folder);
}
