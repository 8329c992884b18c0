/* The list of options is the only place where defaults and ranges stand: what is made of it must
 * agree with it. */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "study/options.h"
#include "ricochet.h"
#include "study/windows.h"

static const char model[] = "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  "
                            "contacts: [{normal: [-1, 1], clearance: "
                            "1}]\n";

static char *written(void (*write)(FILE *))
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    write(out);
    assert_int_equal(fclose(out), 0);
    return text;
}

static void write_template(FILE *out)
{
    fputs(model, out);
    fputs("explore:\n", out);
    ric_options_template("explore", out);
    ric_options_template("", out);
}

static void defaults_are_those_promised(void **state)
{
    ric_explore_options o;
    (void)state;
    ric_explore_options_init(&o);
    assert_true(ric_option_is_auto(o.energy) && ric_option_is_auto(o.frequency));
    assert_int_equal(o.impacts, 12);
    assert_int_equal(o.multiply, 2);
    assert_int_equal(o.depth, 3);
    assert_true(o.tolerance == 1e-12 && o.max_step == 0.03);
    assert_false(o.symmetric_only);
    assert_int_equal(o.n_start, 0);
    assert_int_equal(o.at_energy.n, 0);
    assert_int_equal(o.at_frequency.n, 0);
}

static void template_reads_back_as_the_defaults(void **state)
{
    ric_explore_options defaults;
    ric_study *study = NULL;
    char *text = written(write_template);
    (void)state;
    ric_explore_options_init(&defaults);
    assert_int_equal(ric_study_parse(text, "template", NULL, &study), RIC_OK);
    assert_int_equal(ric_windows_choose(ric_study_model(study), &defaults), RIC_OK);
    assert_memory_equal(ric_study_options(study), &defaults, sizeof defaults);
    ric_study_free(study);
    free(text);
}

static void every_option_has_a_place_and_words(void **state)
{
    int n;
    const ric_option *list = ric_options_list(&n);
    (void)state;
    for (int i = 0; i < n; i++) {
        const size_t size = ric_option_is_forcing(&list[i]) ? sizeof(ric_forcing)
                                                            : sizeof(ric_explore_options);
        assert_true(list[i].help[0] != '\0' && list[i].offset < size);
        assert_ptr_equal(ric_option_find(list[i].section, list[i].key), &list[i]);
        assert_true(list[i].min < list[i].max);
        for (int j = 0; j < i; j++)
            assert_true(list[j].offset != list[i].offset ||
                        ric_option_is_forcing(&list[j]) != ric_option_is_forcing(&list[i]));
    }
    assert_null(ric_option_find("explore", "no-such-option"));
}

/* Every number just inside its range is taken and just outside refused, through the study reader.
 */
static void ranges_are_kept(void **state)
{
    int n;
    const ric_option *list = ric_options_list(&n);
    (void)state;
    for (int i = 0; i < n; i++) {
        if (list[i].type != RIC_OPTION_REAL && list[i].type != RIC_OPTION_INTEGER) continue;
        bool whole = list[i].type == RIC_OPTION_INTEGER;
        double low = whole           ? list[i].min - 1
                     : list[i].above ? list[i].min
                                     : nextafter(list[i].min, -INFINITY);
        double high = whole ? list[i].max + 1 : nextafter(list[i].max, INFINITY);
        double inside = list[i].above ? nextafter(list[i].min, INFINITY) : list[i].min;
        const double values[] = {low, high, inside, list[i].max};
        for (int j = 0; j < 4; j++) {
            char text[600];
            ric_study *study = NULL;
            snprintf(text, sizeof text, "%s%s%s%s: %.17g\n", model,
                     list[i].section[0] ? "explore:\n" : "", list[i].section[0] ? "  " : "",
                     list[i].key, values[j]);
            assert_int_equal(ric_study_parse(text, "range", NULL, &study),
                             j < 2 ? RIC_E_INPUT : RIC_OK);
            if (j < 2) assert_non_null(strstr(ric_detail(), list[i].key));
            ric_study_free(study);
        }
    }
}

/* docs/study.md ends with the tables that the list makes. UPDATE=1 in the environment writes them
 * anew. */
static void document_is_up_to_date(void **state)
{
    char *wanted = written(ric_options_document);
    static char page[65536];
    FILE *file = fopen("docs/study.md", getenv("UPDATE") ? "r+" : "r");
    (void)state;
    assert_non_null(file); /* tests run in the root of the source */
    page[fread(page, 1, sizeof page - 1, file)] = '\0';
    char *mark = strstr(page, "writes it anew. -->\n\n");
    assert_non_null(mark);
    mark = strstr(mark, "\n\n") + 2;
    if (getenv("UPDATE")) {
        strcpy(mark, wanted);
        assert_int_equal(fseek(file, mark - page, SEEK_SET), 0);
        fputs(wanted, file);
        assert_int_equal(ftruncate(fileno(file), ftell(file)), 0);
    }
    fclose(file);
    assert_string_equal(mark, wanted);
    free(wanted);
}

static void numbers_are_read_strictly(void **state)
{
    static const char *const good[] = {"0",       "-0",  "1.",  ".5",       "-1e3", "1E-300",
                                       "+2.5e+2", "007", "1d3", "-2.5D-03", "1.D0"};
    static const char *const bad[] = {"",    "-",     ".",   "e5",  "1e",   "0x10", "1 2",   " 1",
                                      "1,5", "1_000", "--1", "1e+", "true", "1d",   "1d3e1", "d3"};
    static const char *const not_finite[] = {"nan",   ".nan",      ".NaN",  "inf",
                                             "-.inf", "+Infinity", "1e999", "-1e999"};
    double value;
    long whole;
    (void)state;
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        assert_int_equal(ric_option_text_real(good[i], &value), RIC_TEXT_NUMBER);
        char plain[20];
        snprintf(plain, sizeof plain, "%s", good[i]);
        for (char *c = plain; *c; c++)
            if (*c == 'd' || *c == 'D') *c = 'e';
        assert_true(value == strtod(plain, NULL));
    }
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(ric_option_text_real(bad[i], &value), RIC_TEXT_NO_NUMBER);
    for (size_t i = 0; i < sizeof not_finite / sizeof *not_finite; i++)
        assert_int_equal(ric_option_text_real(not_finite[i], &value), RIC_TEXT_NOT_FINITE);
    assert_true(ric_option_text_integer("-12", &whole) && whole == -12);
    assert_false(ric_option_text_integer("12.0", &whole));
    assert_false(ric_option_text_integer("99999999999999999999", &whole));
}

static void numbers_are_written_bit_for_bit(void **state)
{
    const double values[] = {0,
                             -0.0,
                             1,
                             0.1,
                             1.0 / 3,
                             5e-324,
                             1.7976931348623157e308,
                             -2.2250738585072014e-308,
                             123456789.123456789};
    (void)state;
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        char *text = NULL;
        size_t size;
        double back;
        FILE *out = open_memstream(&text, &size);
        assert_non_null(out);
        ric_option_text_write(values[i], out);
        fclose(out);
        assert_int_equal(ric_option_text_real(text, &back), RIC_TEXT_NUMBER);
        assert_memory_equal(&back, &values[i], sizeof back);
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_those_promised),
        cmocka_unit_test(template_reads_back_as_the_defaults),
        cmocka_unit_test(every_option_has_a_place_and_words),
        cmocka_unit_test(ranges_are_kept),
        cmocka_unit_test(document_is_up_to_date),
        cmocka_unit_test(numbers_are_read_strictly),
        cmocka_unit_test(numbers_are_written_bit_for_bit),
    };
    return cmocka_run_group_tests_name("options", tests, NULL, NULL);
}
