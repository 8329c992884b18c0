/* The study reader. What it accepts has to come back from its own text as the same study, and every
 * answer about it can be asked for. */
#include "fuzz.h"

static void ask(const ric_study *study)
{
    const ric_model *m = ric_study_model(study);
    int n = ric_model_n_dof(m);
    double *numbers = calloc((size_t)n * (size_t)n, sizeof *numbers);
    int *contact = calloc((size_t)n, sizeof *contact);
    ric_name name;
    fuzz_need(numbers && contact, "memory");
    ric_model_frequencies(m, numbers);
    ric_model_modes(m, numbers);
    ric_model_grazing_energies(m, numbers, contact);
    for (int i = 0; i < ric_model_n_contact(m); i++) {
        ric_model_locked_frequencies(m, i, numbers);
        ric_model_compliance(m, i, numbers);
    }
    for (int i = 0; i < ric_study_n_name(study); i++) ric_study_name(study, i, &name);
    free(numbers);
    free(contact);
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    fuzz_enter_folder();
    static const char matrix[] = "%%MatrixMarket matrix array real general\n2 2\n2\n0\n0\n1\n";
    fuzz_write("M.mtx", matrix, sizeof matrix - 1);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    ric_study *study = NULL, *again = NULL;
    char *text = malloc(size + 1);
    fuzz_need(text != NULL, "memory");
    memcpy(text, data, size);
    text[size] = 0;
    ric_status status = ric_study_parse(text, "fuzz", ".", &study);
    if (!status) {
        ask(study);
        if (ric_study_parse(ric_study_text(study), "again", ".", &again)) {
            fprintf(stderr, "its own text is refused: %s\n%s\n", ric_detail(),
                    ric_study_text(study));
            abort();
        }
        if (strcmp(ric_study_text(study), ric_study_text(again))) abort();
        ric_study_free(again);
    } else if (study || !ric_detail()[0] || strchr(ric_detail(), '\n'))
        abort(); /* one line that says what is wrong */
    ric_study_free(study);
    free(text);
    return 0;
}
