/* The command line: lines of the input are the arguments. In a folder with a study and its atlas;
 * nothing outside it can be named. Where an option asks for much work the answer may take long, so
 * those are left out here. */
#include "common/cli.h"
#include "fuzz.h"

enum { ARGUMENTS = 24 };

static uint8_t *atlas;
static size_t atlas_size;

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    fuzz_enter_folder();
    fuzz_make_atlas("a.ricochet");
    atlas = fuzz_read("a.ricochet", &atlas_size);
    setenv("PATH", "/nonexistent", 1); /* no gnuplot: pictures are made up to there */
    return 0;
}

/* Asks for work without end, by itself or by a large number. */
static bool laborious(int argc, char **argv)
{
    static const struct {
        const char *command;
        int few; /* with up to so many words it only explains itself or finds a fault */
    } slow[] = {{"hunt", 3}, {"run", 3}, {"new", 3}, {"cascade", 3}, {"view", 2}};
    for (size_t i = 0; i < sizeof slow / sizeof *slow; i++)
        if (argc > slow[i].few && !strcmp(argv[1], slow[i].command)) return true;
    for (int i = 1; i < argc; i++) {
        const char *number = strpbrk(argv[i], "0123456789.");
        if (strchr(argv[i], '/') || strstr(argv[i], "..")) return true;
        if (number && (strtod(number, NULL) > 20 || strpbrk(number, "eExXpP"))) return true;
        if (number && strtod(number, NULL) < 0.01 && strtod(number, NULL) > 0) return true;
    }
    return false;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char name[] = "ricochet", *text = malloc(size + 1), *argv[ARGUMENTS + 2], *next = text;
    int argc = 0;
    fuzz_need(text != NULL, "memory");
    memcpy(text, data, size);
    text[size] = 0;
    argv[argc++] = name;
    while (next && argc <= ARGUMENTS) argv[argc++] = strsep(&next, "\n");
    argv[argc] = NULL;
    if (!laborious(argc, argv)) {
        fuzz_write("s.yaml", FUZZ_STUDY, strlen(FUZZ_STUDY));
        fuzz_write("a.ricochet", atlas, atlas_size);
        int code = cli_main(argc, argv);
        if (code < CLI_DONE || code > CLI_WRONG) abort();
    }
    free(text);
    return 0;
}
