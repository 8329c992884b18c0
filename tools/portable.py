#!/usr/bin/env python3
"""portable.py FILE...: the calls of built files that only Linux or the GNU library has, and where the sources make them.

What the files ask of the system's libraries is compared with what POSIX and macOS have; what is left must be in the list below, with the
reason why it is used and what takes its place elsewhere. A call that is new fails.
"""
import glob
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# POSIX 2008, C11 or macOS 10.13; names as in C.
THERE = set("""
access acos acosh alarm asin asinh atan atan2 atanh bind cabs calloc cbrt ceil clock_gettime close cos cosh csqrt csqrtl cpow cexp clog creal cimag
abort atexit connect dprintf dup dup2 execlp execv execvp exit _exit exp exp2 expm1 fabs fchmod fclose fcntl fdopen feof ferror fflush fgetc
fgets fileno flock floor fma fmax fmemopen fmin fmod fopen fork fprintf fputc fputs fread free freeaddrinfo freelocale getentropy frexp fscanf fseek
fseeko fstat fsync ftell ftello ftruncate fwrite getaddrinfo getc getenv geteuid gethostname getline getpid getsockname hypot ilogb inet_ntop
inet_pton isatty kill ldexp lgamma link listen llround localtime_r log log10 log1p log2 lround lstat malloc memchr memcmp memcpy memmove memset
mkdir mkdtemp mkstemp mktime modf munmap mmap nan nanosleep newlocale nextafter open open_memstream perror pipe poll pow pread printf
pthread_cond_broadcast pthread_cond_destroy pthread_cond_init pthread_cond_signal pthread_cond_timedwait pthread_cond_wait pthread_create
pthread_equal pthread_join pthread_mutex_destroy pthread_mutex_init pthread_mutex_lock pthread_mutex_trylock pthread_mutex_unlock pthread_once
pthread_self pthread_sigmask putc putchar puts pwrite qsort raise read readlink realloc realpath remainder remove remquo rename rewind rint rmdir
round scalbn select send setsid setsockopt shutdown sigaction sigaddset sigemptyset sigfillset signal sigprocmask sin sinh snprintf socket sprintf
sqrt sscanf stat strcasecmp strcat strchr strcmp strcpy strcspn strdup strerror strftime strlen strncasecmp strncat strncmp strncpy strndup
strpbrk strrchr strspn strstr strtod strtok_r strtol strtold strtoll strtoul strtoull sysconf system tan tanh tgamma time tmpfile tolower toupper trunc umask
stderr stdin stdout unlink uselocale usleep vfprintf vsnprintf waitpid write
asprintf vasprintf dirfd dlerror dlopen dlsym fdopendir opendir readdir closedir fnmatch fprintf getopt getopt_long getpagesize gettimeofday getuid getpgrp gmtime_r
isinf isnan j0 j1 lrint mkostemp mlock nice openat popen pclose posix_memalign aligned_alloc pthread_attr_init pthread_attr_setstacksize
pthread_attr_destroy pthread_cond_wait pthread_detach pthread_getspecific pthread_key_create pthread_rwlock_init pthread_rwlock_rdlock
pthread_rwlock_wrlock pthread_rwlock_unlock pthread_rwlock_destroy pthread_setspecific recv rand_r setenv unsetenv setitimer setlocale setrlimit
getrlimit getrusage setvbuf sleep strcasestr memmem strnlen strsep strtof strxfrm times timegm ungetc vprintf vsscanf y0 y1 wait fputws
asinhl atan2l cabsl cosl expl fabsl fmaxl fminl fmal frexpl hypotl ldexpl log1pl logl log2l powl sinl sqrtl tanl
""".split())
KNOWN = {
    "fopencookie": "a stream that grows in memory and can fail (base/buffer.c); elsewhere funopen, there",
    "getauxval": "what the kernel began, where no /proc is mounted (cli/common/module.c); elsewhere _NSGetExecutablePath, there",
    "ioctl": "TIOCGWINSZ, the width of a terminal (cli/common/output.c), which every Unix has; elsewhere as if there were none",
    "madvise": "large pages for the heap (base/memory.c); elsewhere left out, which only takes time",
    "mallopt": "keeps memory that threads free (cli/common/main.c); elsewhere left out, which only takes time",
    "sincos": "also made by the compiler out of sin and cos; elsewhere the two of them (base/elsewhere.h)",
    "sincosl": "made by the compiler out of sinl and cosl, as sincos",
}
# What is not a call by name: __float128 and where linkers differ. Each is looked for in the sources and listed.
WAYS = {
    "/proc/self/exe": ("cli/common/module.c", "where the program lies; elsewhere _NSGetExecutablePath, there"),
    "__float128": ("src/*/*.[ch]", "a type of GCC; elsewhere long double, there"),
}


def asked(path):
    """Names that a file wants from the C library, without what the compiler itself wraps around them."""
    text = subprocess.run(["nm", "-D", "--undefined-only", path], check=True, capture_output=True, text=True).stdout
    for name in re.findall(r" [Uw] (\w+)@GLIBC", text):
        name = re.sub(r"^__isoc(99|23)_", "", name)
        name = re.sub(r"^__(\w+)_chk$", r"\1", name)
        name = re.sub(r"(?<=\w)64$", "", name)
        if not name.startswith("__"):
            yield name


def places(word, pattern="{src,cli,mpi}"):
    files = [f for p in (["src/*/*.[ch]", "cli/*/*.[ch]", "mpi/*.c"] if "{" in pattern else [pattern]) for f in glob.glob(os.path.join(ROOT, p))]
    for path in sorted(files):
        with open(path, encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                if re.search(rf"(?<!\w){word}(?!\w)", line):
                    yield f"{os.path.relpath(path, ROOT)}:{number}"


def main():
    wanted = {name for path in sys.argv[1:] for name in asked(path)}
    if len(wanted) < 20:
        sys.exit("portable.py: these files ask for next to nothing; were they built?")
    left = sorted(wanted - THERE)
    for name in left:
        print(f"{name}: {KNOWN.get(name, 'new: use what POSIX has, or give it a fallback and list it here')}")
        print("    " + (", ".join(places(name)) or "not called by name"))
    for word, (pattern, reason) in WAYS.items():
        print(f"{word}: {reason}\n    " + ", ".join(places(word, pattern)))
    new = [name for name in left if name not in KNOWN]
    if new:
        sys.exit("portable.py: " + ", ".join(new) + " would not link elsewhere")


main()
