/* What the harnesses share. Each is a libFuzzer program: it gets bytes that coverage led to, and
 * may neither crash, leak, overrun nor hang. `make fuzz` builds them, tools/fuzz.sh runs them. */
#ifndef FUZZ_H
#define FUZZ_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ricochet.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv);

#define FUZZ_STUDY                                                                                 \
    "title: fuzz\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  "           \
    "contacts:\n"                                                                                  \
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"                             \
    "explore: {energy: [0, 3], frequency: [0.5, 10], impacts: 2, multiply: 1, depth: 1}\n"

/* A failure of the harness itself. */
static inline void fuzz_need(int good, const char *what)
{
    if (good) return;
    fprintf(stderr, "fuzz: %s failed: %s\n", what, ric_detail());
    _exit(1);
}

/* Working in a folder of its own, in that of the run (tools/fuzz.sh), or in memory where there is
 * room for it. */
static inline void fuzz_enter_folder(void)
{
    char own[4096], shared[] = "/dev/shm/ricochet-fuzz-XXXXXX",
                    other[] = "/tmp/ricochet-fuzz-XXXXXX";
    const char *room = getenv("FUZZ_ROOM"), *folder = NULL;
    int length = room ? snprintf(own, sizeof own, "%s/ricochet-fuzz-XXXXXX", room) : 0;
    if (length > 0 && length < (int)sizeof own) folder = mkdtemp(own);
    if (!folder) folder = mkdtemp(shared);
    if (!folder) folder = mkdtemp(other);
    fuzz_need(folder && !chdir(folder), "a folder");
}

static inline void fuzz_write(const char *path, const void *bytes, size_t size)
{
    FILE *out = fopen(path, "wb");
    fuzz_need(out && fwrite(bytes, 1, size, out) == size && !fclose(out), path);
}

/* The whole file, allocated. */
static inline uint8_t *fuzz_read(const char *path, size_t *size)
{
    FILE *in = fopen(path, "rb");
    fuzz_need(in && !fseek(in, 0, SEEK_END), path);
    *size = (size_t)ftell(in);
    uint8_t *bytes = malloc(*size + 1);
    fuzz_need(bytes != NULL, path);
    rewind(in);
    fuzz_need(fread(bytes, 1, *size, in) == *size && !fclose(in), path);
    return bytes;
}

static inline ric_study *fuzz_study(void)
{
    ric_study *study = NULL;
    fuzz_need(!ric_study_parse(FUZZ_STUDY, "fuzz", ".", &study), "the study");
    return study;
}

/* A small atlas at `path`. */
static inline void fuzz_make_atlas(const char *path)
{
    ric_study *study = fuzz_study();
    ric_run_options run = {.workers = 1};
    fuzz_need(!ric_explore(study, path, &run), "the atlas");
    ric_study_free(study);
}

#endif
