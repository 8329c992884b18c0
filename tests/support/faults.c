/* Loaded before a program (LD_PRELOAD), it lets one of its requests to the system fail:
 *
 *   FAULT_ALLOC=K   the K-th call of malloc, calloc, realloc or strdup finds no memory
 *   FAULT_DISK=K    from the K-th writing call (write, pwrite, ftruncate, fsync, fdatasync) on the
 *                   disk is full
 *   FAULT_POWER=K   at the K-th writing call the power fails: every file is as it was when it was
 *                   last synchronised
 *   FAULT_COUNT=F   at the end the numbers of both kinds of calls are written to the file F
 *
 * Only what the program itself and the libraries it calls ask for counts. Of a file that was never
 * synchronised nothing is left. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static long fail_alloc, fail_disk, fail_power, n_alloc, n_disk;
static const char *count_file;
static bool ready;

static void *(*real_malloc)(size_t);
static void *(*real_calloc)(size_t, size_t);
static void *(*real_realloc)(void *, size_t);
static ssize_t (*real_write)(int, const void *, size_t);
static ssize_t (*real_pwrite)(int, const void *, size_t, off_t);
static int (*real_ftruncate)(int, off_t);
static int (*real_fsync)(int), (*real_fdatasync)(int);

static long number(const char *name)
{
    const char *text = getenv(name);
    return text ? atol(text) : 0;
}

__attribute__((constructor)) static void begin(void)
{
    real_write = (ssize_t(*)(int, const void *, size_t))dlsym(RTLD_NEXT, "write");
    real_pwrite = (ssize_t(*)(int, const void *, size_t, off_t))dlsym(RTLD_NEXT, "pwrite64");
    real_ftruncate = (int (*)(int, off_t))dlsym(RTLD_NEXT, "ftruncate64");
    real_fsync = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
    real_fdatasync = (int (*)(int))dlsym(RTLD_NEXT, "fdatasync");
    real_malloc = (void *(*)(size_t))dlsym(RTLD_NEXT, "malloc");
    real_calloc = (void *(*)(size_t, size_t))dlsym(RTLD_NEXT, "calloc");
    real_realloc = (void *(*)(void *, size_t))dlsym(RTLD_NEXT, "realloc");
    fail_alloc = number("FAULT_ALLOC");
    fail_disk = number("FAULT_DISK");
    fail_power = number("FAULT_POWER");
    count_file = getenv("FAULT_COUNT");
    unsetenv("LD_PRELOAD");
    ready = true;
}

__attribute__((destructor)) static void end(void)
{
    char text[64];
    if (!count_file) return;
    int file = open(count_file, O_WRONLY | O_CREAT | O_TRUNC, 0666),
        size = snprintf(text, sizeof text, "%ld %ld\n", n_alloc, n_disk);
    if (file < 0 || real_write(file, text, (size_t)size) != size) abort();
}

/* ------------------------------------------------------------------- memory */

extern void *__libc_malloc(size_t);
extern void *__libc_calloc(size_t, size_t);
extern void *__libc_realloc(void *, size_t);

static bool starved(void)
{
    if (!ready) return false;
    if (__atomic_add_fetch(&n_alloc, 1, __ATOMIC_RELAXED) != fail_alloc) return false;
    errno = ENOMEM;
    return true;
}

void *malloc(size_t size)
{
    return starved() ? NULL : __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    return starved() ? NULL : __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    return starved() ? NULL : __libc_realloc(old, size);
}

/* --------------------------------------------------------------------- disk */

#define MAX_FILES 64
static struct {
    char path[PATH_MAX];
    char *bytes; /* when it was last synchronised; NULL: never */
    size_t size;
} known[MAX_FILES];
static int n_known;

/* The place of a regular file among the known ones, -1: none. */
static int find(int file)
{
    char link[64], path[PATH_MAX];
    struct stat about;
    if (fstat(file, &about) || !S_ISREG(about.st_mode)) return -1;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return -1;
    path[length] = 0;
    for (int i = 0; i < n_known; i++)
        if (!strcmp(known[i].path, path)) return i;
    if (n_known == MAX_FILES) abort();
    strcpy(known[n_known].path, path);
    return n_known++;
}

static void remember(int i)
{
    struct stat about;
    int file = open(known[i].path, O_RDONLY);
    free(known[i].bytes);
    known[i].bytes = NULL;
    if (file < 0 || fstat(file, &about) ||
        !(known[i].bytes = __libc_malloc((size_t)about.st_size + 1)))
        abort();
    if (read(file, known[i].bytes, (size_t)about.st_size) != about.st_size) abort();
    known[i].size = (size_t)about.st_size;
    close(file);
}

static void lose_power(void)
{
    for (int i = 0; i < n_known; i++) {
        if (access(known[i].path, F_OK)) continue;
        if (!known[i].bytes) {
            unlink(known[i].path);
            continue;
        }
        int file = open(known[i].path, O_WRONLY | O_TRUNC);
        if (file < 0 || real_write(file, known[i].bytes, known[i].size) != (ssize_t)known[i].size)
            abort();
        close(file);
    }
    kill(getpid(), SIGKILL);
}

/* True: the call is to fail. A file that was there before the program began counts as synchronised.
 */
static bool refused(int file, bool before)
{
    struct stat about;
    int n = n_known, i = find(file);
    if (i < 0) return false;
    if (n_known > n && before && !fstat(file, &about) && about.st_size > 0) remember(i);
    n_disk++;
    if (n_disk == fail_power) lose_power();
    if (!fail_disk || n_disk < fail_disk) return false;
    errno = ENOSPC;
    return true;
}

ssize_t write(int file, const void *bytes, size_t size)
{
    return refused(file, true) ? -1 : real_write(file, bytes, size);
}

ssize_t pwrite(int file, const void *bytes, size_t size, off_t at)
{
    return refused(file, true) ? -1 : real_pwrite(file, bytes, size, at);
}

ssize_t pwrite64(int file, const void *bytes, size_t size, off_t at)
{
    return pwrite(file, bytes, size, at);
}

int ftruncate(int file, off_t size)
{
    return refused(file, true) ? -1 : real_ftruncate(file, size);
}

int ftruncate64(int file, off_t size)
{
    return ftruncate(file, size);
}

static int synchronise(int file, int (*real)(int))
{
    int i = find(file);
    if (refused(file, false)) return -1;
    if (i >= 0) remember(i);
    return real(file);
}

int fsync(int file)
{
    return synchronise(file, real_fsync);
}

int fdatasync(int file)
{
    return synchronise(file, real_fdatasync);
}
