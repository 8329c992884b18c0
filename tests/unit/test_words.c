/* Words: canonical forms, counts against the article's table and against brute force, enumeration
 * against both. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ricochet.h"
#include "sample.h"

enum { LONGEST = 64 };

/* Contacts with the sides given, on a fixed-free chain with one mass per contact. */
static ric_model *make_model(int n_contact, const ric_sides *sides)
{
    double mass[16] = {0}, stiffness[16] = {0}, normal[16] = {0};
    ric_contact contacts[4];
    ric_model *model = NULL;
    int n = n_contact;
    for (int i = 0; i < n; i++) {
        mass[i * n + i] = 1;
        stiffness[i * n + i] = i + 1 < n ? 2 : 1;
        if (i > 0) stiffness[i * n + i - 1] = stiffness[(i - 1) * n + i] = -1;
        normal[i * n + i] = 1;
        contacts[i] = (ric_contact){.normal = normal + i * n,
                                    .clearance = 1,
                                    .sides = sides[i],
                                    .law = RIC_LAW_RIGID};
    }
    assert_int_equal(ric_model_create(n, mass, stiffness, n, contacts, 1, &model), RIC_OK);
    return model;
}

static int count_by_enumeration(const ric_model *model, int n, bool reversal)
{
    int word[LONGEST] = {-1}, before[LONGEST], canonical[LONGEST], count = 0;
    bool more = true;
    for (;;) {
        memcpy(before, word, sizeof word);
        assert_int_equal(ric_word_next(model, n, reversal, word, &more), RIC_OK);
        if (!more) return count;
        assert_int_equal(ric_word_canonical(model, n, word, reversal, canonical), RIC_OK);
        assert_memory_equal(word, canonical, (size_t)n * sizeof *word);
        int i = 0;
        while (count && i < n && word[i] == before[i]) i++;
        if (count) assert_true(i < n && word[i] > before[i]);
        count++;
    }
}

/* Every word there is, made canonical and marked: shares only ric_word_canonical with the
 * enumeration. */
static int count_by_force(const ric_model *model, int faces, int n, bool reversal)
{
    int total = 1, count = 0;
    for (int i = 0; i < n; i++) total *= faces;
    for (int code = 0; code < total; code++) {
        int word[LONGEST], canonical[LONGEST], rest = code;
        for (int i = n - 1; i >= 0; i--, rest /= faces) word[i] = rest % faces;
        assert_int_equal(ric_word_canonical(model, n, word, reversal, canonical), RIC_OK);
        count += !memcmp(word, canonical, (size_t)n * sizeof *word);
    }
    return count;
}

static void counts_are_those_of_the_article(void **state)
{
    static const uint64_t without[] = {1, 2, 2, 4, 4, 8, 10, 20, 30, 56, 94, 180};
    static const uint64_t with[] = {9, 18, 23, 44, 63};
    uint64_t count;
    (void)state;
    for (int n = 1; n <= 12; n++) {
        assert_int_equal(ric_word_count(NULL, n, false, &count), RIC_OK);
        assert_int_equal(count, without[n - 1]);
        assert_int_equal(count_by_enumeration(NULL, n, false), without[n - 1]);
    }
    for (int n = 7; n <= 11; n++) {
        assert_int_equal(ric_word_count(NULL, n, true, &count), RIC_OK);
        assert_int_equal(count, with[n - 7]);
        assert_int_equal(count_by_enumeration(NULL, n, true), with[n - 7]);
    }
}

static void three_ways_agree_for_any_faces(void **state)
{
    static const ric_sides sides[][3] = {
        {RIC_SIDES_BOTH, RIC_SIDES_BOTH, RIC_SIDES_BOTH},
        {RIC_SIDES_UPPER, RIC_SIDES_BOTH, RIC_SIDES_LOWER},
        {RIC_SIDES_UPPER, RIC_SIDES_UPPER, RIC_SIDES_BOTH},
        {RIC_SIDES_LOWER, RIC_SIDES_UPPER, RIC_SIDES_UPPER},
    };
    (void)state;
    for (int set = 0; set < 4; set++)
        for (int contacts = 1; contacts <= 3; contacts++) {
            ric_model *model = make_model(contacts, sides[set]);
            int faces = ric_model_n_face(model), most = faces <= 3 ? 8 : 6;
            for (int n = 1; n <= most; n++)
                for (int reversal = 0; reversal < 2; reversal++) {
                    uint64_t count;
                    assert_int_equal(ric_word_count(model, n, reversal, &count), RIC_OK);
                    assert_int_equal(count, count_by_force(model, faces, n, reversal));
                    assert_int_equal(count, count_by_enumeration(model, n, reversal));
                }
            ric_model_free(model);
        }
}

static void canonical_form_is_the_same_for_all_images(void **state)
{
    unsigned seed = 20240229;
    (void)state;
    print_message("# seed %u\n", seed);
    for (int trial = 0; trial < 2000; trial += every()) {
        int word[LONGEST], image[LONGEST], a[LONGEST], b[LONGEST];
        seed = seed * 1103515245u + 12345u;
        int n = 1 + (int)(seed >> 16) % 40, shift = (int)(seed >> 20) % n;
        bool flip = seed >> 28 & 1, reverse = seed >> 29 & 1;
        for (int i = 0; i < n; i++) {
            seed = seed * 1103515245u + 12345u;
            word[i] = seed >> 30 & 1;
        }
        for (int i = 0; i < n; i++) {
            int letter = word[(reverse ? n - 1 - i + shift : i + shift) % n];
            image[i] = flip ? 1 - letter : letter;
        }
        assert_int_equal(ric_word_canonical(NULL, n, word, reverse, a), RIC_OK);
        assert_int_equal(ric_word_canonical(NULL, n, image, reverse, b), RIC_OK);
        assert_memory_equal(a, b, (size_t)n * sizeof *a);
        assert_int_equal(ric_word_canonical(NULL, n, image, reverse, image), RIC_OK); /* in place */
        assert_memory_equal(a, image, (size_t)n * sizeof *a);
    }
}

static void articles_words_have_their_names(void **state)
{
    static const int words[][6] = {{0, 1, 0}, {1, 1, 0, 0}, {1, 0, 1, 0, 1, 0}, {1, 0, 1, 1, 0}};
    static const int lengths[] = {3, 4, 6, 5};
    static const char *const names[] = {"001", "0011", "010101", "00101"};
    (void)state;
    for (int i = 0; i < 4; i++) {
        int canonical[6];
        char text[16];
        assert_int_equal(ric_word_canonical(NULL, lengths[i], words[i], true, canonical), RIC_OK);
        assert_int_equal(ric_word_format(NULL, lengths[i], canonical, sizeof text, text), RIC_OK);
        assert_string_equal(text, names[i]);
    }
}

static void one_sided_stop_has_one_word(void **state)
{
    ric_sides upper = RIC_SIDES_UPPER;
    ric_model *model = make_model(1, &upper);
    uint64_t count;
    (void)state;
    for (int n = 1; n < 2000; n += 37) {
        assert_int_equal(ric_word_count(model, n, true, &count), RIC_OK);
        assert_int_equal(count, 1);
    }
    assert_int_equal(count_by_enumeration(model, 9, false), 1);
    ric_model_free(model);
}

static void counts_beyond_64_bits_are_refused(void **state)
{
    uint64_t count, largest = 0;
    int last = 0;
    (void)state;
    for (int n = 1; n < 300; n++) {
        ric_status status = ric_word_count(NULL, n, false, &count);
        if (status == RIC_OK) {
            assert_int_equal(last, n - 1);
            assert_true(count >= largest);
            last = n;
            largest = count;
        } else assert_int_equal(status, RIC_E_RANGE);
    }
    /* 2^71 / 142 is the first above 2^64: log2(142) = 7.15, so 2^n / 2n < 2^64 up to n = 71 */
    assert_int_equal(last, 71);
    assert_non_null(strstr(ric_detail(), "64 bits"));
    assert_int_equal(ric_word_count(NULL, 2147483647, false, &count), RIC_E_RANGE);
    assert_int_equal(ric_word_count(NULL, -1, false, &count), RIC_E_RANGE);
}

/* Only feasible because prefixes that cannot be completed are skipped. */
static void long_words_enumerate_without_gaps(void **state)
{
    int word[LONGEST] = {-1}, last[LONGEST];
    bool more = true;
    (void)state;
    for (int i = 0; i < 5000 && more; i++)
        assert_int_equal(ric_word_next(NULL, LONGEST, true, word, &more), RIC_OK);
    assert_true(more);
    for (int i = 0; i < LONGEST; i++) word[i] = last[i] = i % 2;
    assert_int_equal(ric_word_next(NULL, LONGEST, true, word, &more), RIC_OK);
    assert_false(more);
    assert_int_equal(ric_word_canonical(NULL, LONGEST, last, true, word), RIC_OK);
    assert_memory_equal(word, last, sizeof last);
}

static void wrong_calls_are_refused(void **state)
{
    int word[3] = {0, 2, 0}, out[3];
    char text[3];
    bool more;
    (void)state;
    assert_int_equal(ric_word_canonical(NULL, 3, word, true, out), RIC_E_RANGE);
    assert_non_null(strstr(ric_detail(), "letter 2"));
    assert_int_equal(ric_word_format(NULL, 3, word, sizeof text, text), RIC_E_RANGE);
    word[1] = 1;
    assert_int_equal(ric_word_format(NULL, 3, word, sizeof text, text), RIC_E_RANGE);
    assert_int_equal(ric_word_next(NULL, 0, true, word, &more), RIC_E_RANGE);
    assert_int_equal(ric_word_canonical(NULL, 0, word, true, out), RIC_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_are_those_of_the_article),
        cmocka_unit_test(three_ways_agree_for_any_faces),
        cmocka_unit_test(canonical_form_is_the_same_for_all_images),
        cmocka_unit_test(articles_words_have_their_names),
        cmocka_unit_test(one_sided_stop_has_one_word),
        cmocka_unit_test(counts_beyond_64_bits_are_refused),
        cmocka_unit_test(long_words_enumerate_without_gaps),
        cmocka_unit_test(wrong_calls_are_refused),
    };
    return cmocka_run_group_tests_name("words", tests, NULL, NULL);
}
