/* The atlas reader on files whose bytes were changed: edits of a good atlas, as pairs of a place (4
 * bytes) and a value, or, with a first byte below 16, a file of the bytes themselves. Nearly all
 * are refused; none may be anything worse. */
#include "fuzz.h"

static uint8_t *good;
static size_t good_size;

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    fuzz_enter_folder();
    fuzz_make_atlas("good.ricochet");
    good = fuzz_read("good.ricochet", &good_size);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    ric_atlas *atlas = NULL;
    if (size < 1) return 0;
    if (data[0] < 16) fuzz_write("fuzz.ricochet", data + 1, size - 1);
    else {
        uint8_t *copy = malloc(good_size);
        fuzz_need(copy != NULL, "memory");
        memcpy(copy, good, good_size);
        for (size_t i = 1; i + 4 < size; i += 5) {
            uint32_t place;
            memcpy(&place, data + i, 4);
            copy[place % good_size] = data[i + 4];
        }
        fuzz_write("fuzz.ricochet", copy, data[0] % 4 ? good_size : good_size * data[0] / 256);
        free(copy);
    }
    ric_status status = ric_atlas_read("fuzz.ricochet", &atlas);
    if (status && (atlas || !ric_detail()[0])) abort();
    ric_atlas_free(atlas);
    return 0;
}
