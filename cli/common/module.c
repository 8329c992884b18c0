/* Modules: FLINT, HDF5, matio and libmicrohttpd bring some forty other libraries, and to load them
 * takes longer than all else that a short command does. The commands that need them lie in shared
 * objects of their own, beside the program where it is built and in a folder below lib/ where it is
 * installed. They call what the program is made of, so that only those of its own version are taken
 * (docs/decisions/0009-modules.md). */
#include "module.h"

#include <dlfcn.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#ifdef __APPLE__
#include <mach-o/dyld.h>
#else
#include <sys/auxv.h>
#endif

#include "cli.h"

enum { PATH_SIZE = 4096, NAME_SIZE = 256 }; /* bytes of a folder, and of what comes behind it */

/* dlsym returns a pointer to data: ISO C cannot convert it to one to a function, and POSIX has the
 * same bytes. */
static cli_module_function *function_of(void *handle, const char *name)
{
    cli_module_function *out = NULL;
    void *found = handle ? dlsym(handle, name) : NULL;
    if (found) memcpy(&out, &found, sizeof out);
    return out;
}

/* The file of the program, links followed. */
#ifdef __APPLE__
static bool own_file(char out[PATH_SIZE])
{
    char path[PATH_SIZE];
    uint32_t size = PATH_SIZE;
    return !_NSGetExecutablePath(path, &size) && realpath(path, out);
}
#else
/* Where no /proc is mounted it is what the kernel was told to begin. */
static bool own_file(char out[PATH_SIZE])
{
    const ssize_t n = readlink("/proc/self/exe", out, PATH_SIZE - 1);
    const char *begun = (const char *)getauxval(AT_EXECFN);
    out[n > 0 ? n : 0] = '\0';
    return n > 0 || (begun && realpath(begun, out));
}
#endif

static bool own_folder(char out[PATH_SIZE])
{
    if (!own_file(out)) return false;
    *strrchr(out, '/') = '\0';
    return true;
}

/* Whether another user may have laid a file into the folder: it is not of the user, of root or of
 * whom the program is of, or all may write to it. Where all may write to the program, as on disks
 * that know no owners, that tells nothing. */
static bool is_open_to_others(const char *folder)
{
    char own[PATH_SIZE];
    struct stat program = {0}, info;
    if (own_file(own) && !stat(own, &program) && program.st_mode & S_IWOTH) return false;
    if (stat(*folder ? folder : "/", &info) || info.st_mode & S_IWOTH) return true;
    return info.st_uid != 0 && info.st_uid != geteuid() && info.st_uid != program.st_uid;
}

/* Where the module is; the last place that was looked at if it is nowhere. */
static bool find_file(const char *module, char path[PATH_SIZE + NAME_SIZE])
{
    static const char *const places[] = {".", CLI_MODULES};
    char folder[PATH_SIZE];
    bool found = false;
    snprintf(path, PATH_SIZE + NAME_SIZE, "ricochet-%s.so", module);
    if (!own_folder(folder)) return false;
    for (size_t i = 0; !found && i < sizeof places / sizeof *places; i++) {
        const bool absolute = places[i][0] == '/';
        snprintf(path, PATH_SIZE + NAME_SIZE, "%s%s%s/ricochet-%s.so", absolute ? "" : folder,
                 absolute ? "" : "/", places[i], module);
        found = access(path, R_OK) == 0;
    }
    return found;
}

/* A module of another version would take the atlas for something else. */
static bool fits(void *handle)
{
    const char *const *version = dlsym(handle, "cli_module_version");
    return version && !strcmp(*version, RIC_VERSION);
}

static cli_module_function *load(const char *module, const char *path, const char *function)
{
    cli_module_function *out = NULL;
    void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!handle)
        cli_say("ricochet: %s: a part of the program cannot be loaded: %s\n", module, dlerror());
    else if (!fits(handle))
        cli_say("ricochet: %s: %s is of another version; install ricochet again\n", module, path);
    else if (!(out = function_of(handle, function)))
        cli_say("ricochet: %s: %s has no %s\n", module, path, function);
    return out;
}

cli_module_function *cli_module_find(const char *module, const char *function)
{
    cli_module_function *out = function_of(dlopen(NULL, RTLD_NOW), function);
    char path[PATH_SIZE + NAME_SIZE], file[PATH_SIZE], folder[PATH_SIZE];
    if (out) return out; /* the program was linked with it */
    if (!find_file(module, path) || !realpath(path, file)) {
        cli_say("ricochet: %s: a part of the program is missing, %s; install ricochet again, or "
                "leave the program "
                "where it was built, with all that is beside it\n",
                module, path);
        return NULL;
    }
    snprintf(folder, sizeof folder, "%s", file);
    *strrchr(folder, '/') = '\0';
    if (!is_open_to_others(folder)) return load(module, file, function);
    cli_say("ricochet: %s: %s is not loaded, as another user may have laid it there; move the "
            "program, with all that "
            "is beside it, into a folder that only you can write to\n",
            module, file);
    return NULL;
}

int cli_module_run(const char *module, const char *command, int argc, char **argv)
{
    cli_module_function *found = cli_module_find(module, command);
    return found ? ((int (*)(int, char **))found)(argc, argv) : CLI_FAILED;
}
