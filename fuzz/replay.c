/* In place of libFuzzer's own main: runs a harness once over every file of the folders given. So
 * the suite builds the harnesses with any compiler, and what once broke one stays mended. One line
 * of TAP for each folder. */
#include <dirent.h>
#include <limits.h>

#include "fuzz.h"

/* Number of files run. */
static int replay(const char *folder)
{
    DIR *dir = opendir(folder);
    int n = 0;
    fuzz_need(dir != NULL, folder);
    for (struct dirent *entry; (entry = readdir(dir));) {
        char path[PATH_MAX];
        size_t size;
        if (entry->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        uint8_t *bytes = fuzz_read(path, &size);
        fprintf(stderr, "%s\n", path);
        LLVMFuzzerTestOneInput(bytes, size);
        free(bytes);
        n++;
    }
    closedir(dir);
    return n;
}

/* The folder that the harness made for itself. */
static void remove_folder(void)
{
    char here[PATH_MAX];
    if (!getcwd(here, sizeof here) || !strstr(here, "ricochet-fuzz-")) return;
    DIR *dir = opendir(".");
    if (!dir) return;
    for (struct dirent *entry; (entry = readdir(dir));) unlink(entry->d_name);
    closedir(dir);
    rmdir(here);
}

int main(int argc, char **argv)
{
    char(*folders)[PATH_MAX] = calloc((size_t)argc, sizeof *folders);
    int n_empty = 0, report = dup(STDOUT_FILENO); /* a harness may close standard output */
    fuzz_need(folders && report >= 0, "memory");
    /* before the harness changes its folder */
    for (int i = 1; i < argc; i++) fuzz_need(realpath(argv[i], folders[i]) != NULL, argv[i]);
    LLVMFuzzerInitialize(&argc, &argv);
    for (int i = 1; i < argc; i++) {
        int n = replay(folders[i]);
        n_empty += n == 0;
        dprintf(report, "%sok %d - %d files of %s\n", n ? "" : "not ", i, n, argv[i]);
    }
    dprintf(report, "1..%d\n", argc - 1);
    free(folders);
    remove_folder();
    return n_empty > 0;
}
