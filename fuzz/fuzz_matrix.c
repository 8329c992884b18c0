/* The Matrix Market reader. */
#include <math.h>

#include "fuzz.h"
#include "study/matrix_market.h"

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    double *matrix = NULL;
    int n = 0;
    char *text = malloc(size + 1);
    fuzz_need(text != NULL, "memory");
    memcpy(text, data, size);
    text[size] = 0;
    if (!ric_matrix_market_parse(text, size, "fuzz.mtx", &n, &matrix, NULL)) {
        if (n < 1 || n > RIC_MATRIX_MAX) abort();
        for (int i = 0; i < n * n; i++)
            if (!isfinite(matrix[i])) abort();
    } else if (matrix || !ric_detail()[0]) abort();
    free(matrix);
    free(text);
    return 0;
}
