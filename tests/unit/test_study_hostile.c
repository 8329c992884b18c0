/* The study reader on what is hardly a study: broken YAML, texts that are none, bombs, bytes
 * changed at random; and buffers without memory. */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/buffer.h"
#include "ricochet.h"
#include "refused_studies.h"
#include "sample.h"

static char *repeated(const char *head, const char *piece, int n, const char *tail)
{
    size_t size = strlen(head) + strlen(piece) * (size_t)n + strlen(tail) + 1;
    char *text = malloc(size), *at = text;
    assert_non_null(text);
    at += sprintf(at, "%s", head);
    for (int i = 0; i < n; i++) at += sprintf(at, "%s", piece);
    sprintf(at, "%s", tail);
    return text;
}

static void broken_yaml(void **state)
{
    char *text = with_line(3, "  mass: [[2, 0], [0, 1]");
    (void)state;
    refused(text, 4, "syntax", SAYS("brackets"));
    free(text);
    line_refused(9, "\t  sides: both", "syntax", SAYS("a tab stands in the indentation", "blanks"));
    line_refused(9, "      \tsides: [both", "syntax", SAYS("a tab stands"));
    line_refused(10, "  }", "syntax", SAYS("brackets"));
    refused("model: *nothing\n", 1, "syntax", SAYS("alias"));
    refused("title: a\n---\ntitle: b\n", 2, "syntax", SAYS("second document"));
    refused("title: \"a\n", 2, "syntax", SAYS("quoted"));
}

static void empty_texts(void **state)
{
    (void)state;
    refused("", 1, "model", SAYS("empty", "ricochet new"));
    refused("  \n\n", 1, "model", SAYS("empty"));
    refused("# only a comment\n", 1, "model", SAYS("empty"));
    refused("---\n", 2, "study", SAYS("expected a group of keys"));
}

static void texts_that_are_none(void **state)
{
    (void)state;
    refused("title: caf\xE9\n", 1, "text", SAYS("0xE9", "UTF-8"));
    refused("title: a\n\xC0\xAF: 1\n", 2, "text", SAYS("UTF-8"));
    refused("title: \xED\xA0\x80\n", 1, "text", SAYS("UTF-8"));
    refused("\xFF\xFEt\n", 1, "text", SAYS("UTF-8"));
    refused("title: a\n\x01\n", 2, "text", SAYS("0x01", "plain UTF-8 text"));
    refused("title: \"a\\0b\"\n", 1, "title", SAYS("zero byte"));
}

static void deep_and_bombed(void **state)
{
    char *text;
    (void)state;
    text = repeated("title: ", "[", 100000, "\n");
    refused(text, 1, "syntax", SAYS("levels deep"));
    free(text);
    text = repeated("title: ", "{a: ", 100000, "\n");
    refused(text, 1, "syntax", SAYS("levels deep"));
    free(text);
    text = repeated("", "? ", 50000, "\n");
    refused(text, 1, "syntax", SAYS("levels deep"));
    free(text);
    text = repeated("title: [&a x", ", *a", 1000, "]\n");
    refused(text, 1, "syntax", SAYS("anchors", "write the values out"));
    free(text);
    text = repeated("title: [x", ", x", 4100000, "]\n");
    refused(text, 1, "syntax", SAYS("values", "Matrix Market"));
    free(text);
    refused("&a a: *a\n", 1, "a", SAYS("unknown key"));
    refused("model: &m\n  mass: &r [*r, *r]\n  stiffness: [[1]]\n  contacts: []\n", 2, "model.mass",
            SAYS("found a list"));
    text = repeated("title: ", "x", 2000, "\n");
    refused(text, 1, "title", SAYS("longer than"));
    free(text);
    text = repeated("", "k", 900, ": 1\n");
    refused(text, 1, "kkkk", SAYS("keys here"));
    free(text);
}

static void few_aliases_are_fine(void **state)
{
    static const char text[] = "model:\n  mass: &one [[1, 0], [0, 1]]\n  stiffness: *one\n"
                               "  contacts: [{normal: [1, 0], clearance: 1}]\n";
    ric_study *study = NULL;
    (void)state;
    assert_int_equal(ric_study_parse(text, "s", NULL, &study), RIC_OK);
    ric_study_free(study);
}

/* A thousand rows are read, one more is not; both in bounded time. */
static void sizes_are_bounded(void **state)
{
    (void)state;
    for (int n = 1000; n <= 1001; n++) {
        char *text = NULL;
        size_t size;
        ric_study *study = NULL;
        FILE *out = open_memstream(&text, &size);
        assert_non_null(out);
        fputs("model:\n  mass: [", out);
        for (int i = 0; i < n; i++) {
            fputs(i ? ",[" : "[", out);
            for (int j = 0; j < n; j++) fprintf(out, "%s%d", j ? "," : "", i == j);
            fputs("]\n ", out);
        }
        fputs("]\n  stiffness: [[1]]\n  contacts: []\n", out);
        fclose(out);
        assert_int_equal(ric_study_parse(text, "s", NULL, &study), RIC_E_INPUT);
        assert_non_null(
            strstr(ric_detail(), n == 1000
                                     ? "model.stiffness: 1 x 1, but the mass matrix is 1000 x 1000"
                                     : "1001 rows"));
        free(text);
    }
}

/* The good study with bytes changed at random: any answer will do, as long as there is one. Meant
 * for the sanitizers. */
static void scrambled_studies_are_survived(void **state)
{
    static const char bytes[] = "[]{}:,-&*!|>'\"#%?\n\t 019.eE\xC3\xFF\\~";
    char *text = with_line(0, NULL);
    size_t size = strlen(text);
    unsigned seed = 12345;
    (void)state;
    print_message("# seed %u\n", seed);
    for (int trial = 0; trial < 3000; trial += every()) {
        char *copy = malloc(size + 1);
        ric_study *study = NULL;
        assert_non_null(copy);
        memcpy(copy, text, size + 1);
        for (int i = 0; i < 1 + trial % 4; i++) {
            seed = seed * 1103515245u + 12345u;
            copy[(seed >> 8) % size] = bytes[(seed >> 4) % (sizeof bytes - 1)];
        }
        ric_status status = ric_study_parse(copy, "s", NULL, &study);
        assert_true(status == RIC_OK || status == RIC_E_INPUT);
        assert_true((status == RIC_OK) == (study != NULL));
        if (status) assert_int_equal(strncmp(ric_detail(), "s:", 2), 0);
        ric_study_free(study);
        free(copy);
    }
    free(text);
}

/* The text of a study is printed into a buffer. One that found no memory for a part of it says so,
 * and never comes back shortened. */
static void cut_texts_are_not_kept(void **state)
{
    (void)state;
    ric_buffer b;
    assert_true(ric_buffer_open(&b));
    for (int i = 0; i < 10000; i++) fprintf(b.file, "line %d\n", i);
    assert_true(ric_buffer_sync(&b));
    assert_int_equal(b.size, strlen(b.text));
    assert_string_equal(b.text + b.size - 10, "line 9999\n");
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
    ric_buffer_free(&b); /* an allocator of sanitizers stops the program where it has no memory */
    skip();
#endif
    size_t size = b.size, capacity = b.capacity;
    b.size = b.capacity = SIZE_MAX / 8; /* the next line asks for a quarter of all addresses, which
                                           valgrind takes for a size yet */
    fputs("more", b.file);
    assert_false(ric_buffer_sync(&b));
    b.size = size;
    b.capacity = capacity;
    fputs("there is room again, but something is missing", b.file);
    assert_false(ric_buffer_sync(&b));
    assert_null(ric_buffer_take(&b));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cut_texts_are_not_kept),
        cmocka_unit_test(broken_yaml),
        cmocka_unit_test(empty_texts),
        cmocka_unit_test(texts_that_are_none),
        cmocka_unit_test(deep_and_bombed),
        cmocka_unit_test(few_aliases_are_fine),
        cmocka_unit_test(sizes_are_bounded),
        cmocka_unit_test(scrambled_studies_are_survived),
    };
    return cmocka_run_group_tests_name("study_hostile", tests, NULL, NULL);
}
