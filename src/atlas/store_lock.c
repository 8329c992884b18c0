/* The files beside an atlas, whose names the program and SQLite choose: the lock of a run and the
 * journals. Somebody else may have laid something of that name, a link to a file that is dear or a
 * file with contents of its own: nothing is opened that is not a plain file of the right owner, and
 * nothing is changed or removed that we have not written (CWE-59, following links). */
#include "store_parts.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/room.h"

/* ------------------------------------------------------------------- names */

char *ric_store_resolve(const char *path)
{
    char *whole = realpath(path, NULL), *folder, *real;
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    if (whole) return whole;
    folder = slash ? strndup(path, (size_t)(slash - path) + 1) : ric_strdup(".");
    real = folder && *name ? realpath(folder, NULL) : NULL;
    free(folder);
    if (!real) return ric_strdup(path); /* what is wrong with it is said when it is opened */
    whole = ric_malloc(strlen(real) + strlen(name) + 2);
    if (whole) sprintf(whole, "%s%s%s", real, strcmp(real, "/") ? "/" : "", name);
    free(real);
    return whole;
}

static char *beside(const char *atlas, const char *ending)
{
    char *path = ric_malloc(strlen(atlas) + strlen(ending) + 1);
    if (path) sprintf(path, "%s%s", atlas, ending);
    return path;
}

/* ------------------------------------------------------------ what is there */

const char *ric_store_file_kind(mode_t mode)
{
    return S_ISREG(mode)    ? "a plain file"
           : S_ISDIR(mode)  ? "a folder"
           : S_ISLNK(mode)  ? "a symbolic link"
           : S_ISFIFO(mode) ? "a pipe"
           : S_ISSOCK(mode) ? "a socket"
                            : "a device";
}

static ric_status not_ours(const char *path, const char *what, const char *purpose)
{
    return ric_fail(RIC_E_IO,
                    "%s: it is %s and not %s; nothing was changed. Look at it and move it away, or "
                    "choose another name "
                    "for the atlas",
                    path, what, purpose);
}

/* A plain file under this name alone. `owner`: another user to whom it may belong. */
static ric_status check_plain(const char *path, const struct stat *found, uid_t owner,
                              const char *purpose)
{
    if (!S_ISREG(found->st_mode))
        return not_ours(path, ric_store_file_kind(found->st_mode), purpose);
    if (found->st_nlink > 1)
        return not_ours(path, "a file with a second name (a hard link)", purpose);
    if (found->st_uid != geteuid() && found->st_uid != owner)
        return not_ours(path, "a file of another user", purpose);
    return RIC_OK;
}

/* -------------------------------------------------------------------- lock */

static const char lock_purpose[] = "the lock of a run of ours";

/* The lock lies on a file beside the atlas, PATH-lock: closing any descriptor of the atlas itself
 * would end the locks of SQLite. The system releases it when the process ends, however it ends; a
 * file left over by a kill locks nothing. */
static void sign_lock(int lock)
{
    char host[65] = "this machine", when[32] = "", text[160];
    time_t now = time(NULL);
    struct tm local;
    gethostname(host, sizeof host - 1);
    if (localtime_r(&now, &local)) strftime(when, sizeof when, "%Y-%m-%d %H:%M", &local);
    int size = snprintf(text, sizeof text, "process %ld on %s since %s", (long)getpid(), host,
                        when);
    /* a disk that takes no more leaves the lock without a name */
    if (ftruncate(lock, 0) == 0 && size > 0 && pwrite(lock, text, (size_t)size, 0) < 0) return;
}

/* Who has signed the lock; whatever stands there that is no plain text is left out. */
static void read_signature(int lock, char *text, size_t size)
{
    ssize_t length = pread(lock, text, size - 1, 0);
    text[length > 0 ? length : 0] = 0;
    for (char *c = text; *c; c++)
        if (*c < ' ' || *c > '~') *c = '?';
}

/* Whether the file is empty, or holds what sign_lock writes and nothing else. */
static bool is_signed(int lock, off_t size)
{
    char text[161];
    if (size == 0) return true;
    ssize_t length = size < (off_t)sizeof text ? pread(lock, text, sizeof text - 1, 0) : 0;
    if (length != size) return false;
    text[length] = 0;
    const char *on = strstr(text, " on "), *since = strstr(text, " since ");
    if (strncmp(text, "process ", 8) || !on || !since || since < on ||
        strlen(text) != (size_t)length)
        return false;
    return strspn(text + 8, "0123456789") == (size_t)(on - text) - 8 && !strpbrk(text, "\r\n\t") &&
           strspn(since + 7, "0123456789-: ") == strlen(since + 7);
}

/* Opens without waiting, following or changing anything. A file that vanishes in between is tried
 * again: *out = -1. */
static ric_status open_lock(const char *path, const char *atlas, int *out)
{
    struct stat found;
    *out = -1;
    if (!lstat(path, &found)) {
        ric_status status = check_plain(path, &found, geteuid(), lock_purpose);
        if (status) return status;
    }
    int lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY, 0666);
    if (lock < 0 && errno == ELOOP) return not_ours(path, "a symbolic link", lock_purpose);
    if (lock < 0)
        return ric_fail(RIC_E_IO,
                        "%s: cannot write in its folder (%s); choose another file with -o", atlas,
                        strerror(errno));
    if (fstat(lock, &found) || found.st_nlink == 0) {
        close(lock);
        return RIC_OK;
    }
    ric_status status = check_plain(path, &found, geteuid(), lock_purpose);
    if (status) close(lock);
    else *out = lock;
    return status;
}

/* Whether the descriptor is what others find under that name: a run removes the file when it ends.
 */
static bool is_named(int lock, const char *path, struct stat *held)
{
    struct stat named;
    return !fstat(lock, held) && !lstat(path, &named) && held->st_ino == named.st_ino &&
           held->st_dev == named.st_dev;
}

static ric_status refuse_lock(int lock, int reason, const char *atlas)
{
    char holder[160];
    read_signature(lock, holder, sizeof holder);
    return reason == EWOULDBLOCK
               ? ric_fail(RIC_E_BUSY,
                          "%s: in use by another run (%s); wait for its end, or choose another "
                          "file with -o",
                          atlas, *holder ? holder : "it did not sign")
               : ric_fail(RIC_E_IO,
                          "%s: cannot be locked (%s); choose a file on another disk with -o", atlas,
                          strerror(reason));
}

ric_status ric_store_lock_take(const char *atlas, const char *path, int *out)
{
    for (*out = -1;;) {
        struct stat held;
        int lock;
        ric_status status = open_lock(path, atlas, &lock);
        if (status) return status;
        if (lock < 0) continue;
        if (flock(lock, LOCK_EX | LOCK_NB)) {
            int reason = errno;
            if (reason != EINTR) status = refuse_lock(lock, reason, atlas);
        } else if (is_named(lock, path, &held)) {
            if (is_signed(lock, held.st_size)) {
                sign_lock(lock);
                *out = lock;
                return RIC_OK;
            }
            status = not_ours(path, "a file with other contents", lock_purpose);
        }
        close(lock);
        if (status) return status;
    }
}

void ric_store_lock_release(const char *path, int *lock)
{
    struct stat held;
    if (*lock < 0) return;
    if (is_named(*lock, path, &held)) unlink(path);
    close(*lock);
    *lock = -1;
}

/* ---------------------------------------------------------------- journals */

static const unsigned char journal_magic[8] = {0xd9, 0xd5, 0x05, 0xf9, 0x20, 0xa1, 0x63, 0xd7};

/* SQLite removes a journal that it takes for one, with another file that the journal names at its
 * end (super-journal), of which an atlas has no need. A journal that was not finished starts with
 * zeros. Format: www.sqlite.org/fileformat sections 3 and 4. A run that is just committing writes
 * over these zeros, so that each place is read once. */
static const char *wrong_journal(int file, off_t size, bool log)
{
    static const unsigned char zeros[8] = {0},
                               logs[2][4] = {{0x37, 0x7f, 6, 0x82}, {0x37, 0x7f, 6, 0x83}};
    unsigned char first[8], last[8];
    const size_t n = log ? sizeof logs[0] : sizeof first;
    if (size == 0) return NULL;
    bool ours = size >= (off_t)n && pread(file, first, n, 0) == (ssize_t)n;
    if (log) ours = ours && (!memcmp(first, logs[0], n) || !memcmp(first, logs[1], n));
    else ours = ours && (!memcmp(first, journal_magic, n) || !memcmp(first, zeros, n));
    if (!ours) return "a file with other contents";
    if (log || size <= (off_t)sizeof last) return NULL;
    return pread(file, last, sizeof last, size - 8) == sizeof last &&
                   !memcmp(last, journal_magic, sizeof last)
               ? "a journal that names further files"
               : NULL;
}

static ric_status check_journal(const char *path, uid_t owner, bool log)
{
    static const char purpose[] = "the journal of this atlas";
    struct stat found;
    if (lstat(path, &found)) return RIC_OK;
    ric_status status = check_plain(path, &found, owner, purpose);
    if (status) return status;
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY);
    if (file < 0) /* gone with the transaction that it was for, or SQLite says what is wrong */
        return errno == ELOOP ? not_ours(path, "a symbolic link", purpose) : RIC_OK;
    const char *wrong = fstat(file, &found) ? NULL : wrong_journal(file, found.st_size, log);
    if (wrong) status = not_ours(path, wrong, purpose);
    close(file);
    return status;
}

ric_status ric_store_check_beside(const char *atlas)
{
    static const struct {
        const char *ending;
        bool log;
    } journals[] = {{"-journal", false}, {"-wal", true}};
    struct stat found;
    ric_status status = RIC_OK;
    char *real = ric_store_resolve(atlas);
    uid_t owner = real && !stat(real, &found) ? found.st_uid : geteuid();
    for (int i = 0; real && !status && i < 2; i++) {
        char *path = beside(real, journals[i].ending);
        status = path ? check_journal(path, owner, journals[i].log) : ric_store_fail_memory();
        free(path);
    }
    free(real);
    return real ? status : ric_store_fail_memory();
}

/* Byte 19 of the header is 2 in write-ahead mode (www.sqlite.org/fileformat, section 1.3). */
bool ric_store_left_ahead(const char *atlas)
{
    char mode = 0, *real = ric_store_resolve(atlas), *log = real ? beside(real, "-wal") : NULL;
    struct stat waiting;
    bool nothing = log && (stat(log, &waiting) || waiting.st_size == 0);
    int file = nothing ? open(real, O_RDONLY | O_CLOEXEC | O_NONBLOCK) : -1;
    if (file >= 0) {
        if (pread(file, &mode, 1, 19) != 1) mode = 0;
        close(file);
    }
    free(log);
    free(real);
    return mode == 2;
}
