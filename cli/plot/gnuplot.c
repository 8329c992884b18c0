/* Rendering by gnuplot. It sees nothing but numbers, texts and a script on its standard input: it
 * is started without a shell, never learns a file name, and writes to an anonymous file that
 * becomes the target only after it has succeeded. */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "plot.h"

static plot_format format_of(const char *path)
{
    const char *name = strrchr(path, '/'), *dot = strrchr(name ? name : path, '.');
    if (dot && dot != path && dot[-1] != '/') {
        if (!strcasecmp(dot, ".svg")) return PLOT_FORMAT_SVG;
        if (!strcasecmp(dot, ".pdf")) return PLOT_FORMAT_PDF;
        if (!strcasecmp(dot, ".png")) return PLOT_FORMAT_PNG;
        if (!strcasecmp(dot, ".gp")) return PLOT_FORMAT_GNUPLOT;
    }
    return PLOT_FORMAT_NONE;
}

/* Whether a new file can be made there: said before the work, not after it. */
static int check_folder(const char *path)
{
    char folder[PATH_MAX];
    const char *slash = strrchr(path, '/');
    const size_t length = !slash ? 1 : slash == path ? 1 : (size_t)(slash - path);
    if (length >= sizeof folder) return CLI_DONE; /* opening it says what is wrong */
    memcpy(folder, slash ? path : ".", length);
    folder[length] = '\0';
    if (access(folder, W_OK | X_OK) == 0) return CLI_DONE;
    cli_say("ricochet: cannot write %s: folder %s: %s\n", path, folder, strerror(errno));
    return CLI_FAILED;
}

int plot_check_target(const plot_options *options)
{
    const char *path = options->out;
    struct stat info;
    if (format_of(path) == PLOT_FORMAT_NONE)
        return cli_wrong("-o %s: the ending says what to draw: .svg, .pdf or .png, or .gp for the "
                         "script of gnuplot",
                         path);
    if (options->dpi > 0 && format_of(path) != PLOT_FORMAT_PNG)
        return cli_wrong("--dpi goes with -o FILE.png: %s has no pixels", path);
    if (stat(path, &info) == 0)
        return S_ISREG(info.st_mode) ? CLI_DONE
               : S_ISDIR(info.st_mode)
                   ? cli_wrong("-o %s: this is a folder; give a file name", path)
                   : cli_wrong("-o %s: this is no plain file; give another file name", path);
    if (lstat(path, &info) == 0)
        return cli_wrong(
            "-o %s: this is a symbolic link to nothing; remove it, or give another file name",
            path);
    return check_folder(path);
}

/* Starts gnuplot on the three files. Returns 0 and its exit status, or the errno that kept it from
 * starting. */
static int run_gnuplot(FILE *script, FILE *result, FILE *complaint, int *status)
{
    int trouble[2], failed = 0; /* closed by a successful exec, else it carries errno */
    if (pipe(trouble) != 0) return errno;
    fcntl(trouble[1], F_SETFD, FD_CLOEXEC);
    const pid_t child = fork();
    if (child == 0) {
        static char name[] = "gnuplot", plain[] = "-d"; /* -d: no start-up file of the user */
        char *const arguments[] = {name, plain, NULL};
        dup2(fileno(script), STDIN_FILENO);
        dup2(fileno(result), STDOUT_FILENO);
        dup2(fileno(complaint), STDERR_FILENO);
        execvp(arguments[0], arguments);
        failed = errno;
        if (write(trouble[1], &failed, sizeof failed) < 0) _exit(126);
        _exit(127);
    }
    if (child < 0) failed = errno;
    close(trouble[1]);
    if (child > 0) {
        if (read(trouble[0], &failed, sizeof failed) != sizeof failed) failed = 0;
        while (waitpid(child, status, 0) < 0 && errno == EINTR) {
        }
    }
    close(trouble[0]);
    return failed;
}

/* Prints the last line that gnuplot complained with. */
static int report_complaint(FILE *complaint, int status)
{
    char line[512], last[512] = "no message";
    rewind(complaint);
    while (fgets(line, sizeof line, complaint))
        if (strspn(line, " \t\r\n^") != strlen(line))
            snprintf(last, sizeof last, "%s", line + strspn(line, " \t"));
    last[strcspn(last, "\n")] = '\0';
    if (WIFSIGNALED(status))
        cli_say("ricochet: gnuplot was ended by signal %d\n", WTERMSIG(status));
    else
        cli_say("ricochet: gnuplot could not draw the picture: %s; version 5.0 or later with cairo "
                "is needed (Debian: "
                "gnuplot-nox)\n",
                last);
    return CLI_FAILED;
}

static bool looks_like(FILE *file, plot_format kind)
{
    char head[8] = "";
    rewind(file);
    const size_t n = fread(head, 1, sizeof head, file);
    rewind(file);
    return n == sizeof head && (kind == PLOT_FORMAT_PNG   ? !memcmp(head, "\x89PNG", 4)
                                : kind == PLOT_FORMAT_PDF ? !memcmp(head, "%PDF", 4)
                                                          : head[0] == '<');
}

static bool copy_file(FILE *from, int to)
{
    char block[65536];
    size_t n;
    while ((n = fread(block, 1, sizeof block, from)) > 0)
        for (size_t done = 0; done < n;) {
            const ssize_t written = write(to, block + done, n - done);
            if (written < 0 && errno != EINTR) return false;
            done += written > 0 ? (size_t)written : 0;
        }
    return !ferror(from);
}

/* Puts the result in place by way of a file beside it, so that a half-written picture is never
 * seen. A link stays, and the file that it leads to is replaced. */
static int deliver(FILE *result, const char *path)
{
    char *real = realpath(path, NULL);
    const char *target = real ? real : path;
    const size_t length = strlen(target);
    char *beside = malloc(length + 8);
    int code = CLI_FAILED, file = -1;
    if (!beside) {
        code = cli_report(RIC_E_NOMEM);
        goto out;
    }
    memcpy(beside, target, length);
    memcpy(beside + length, ".XXXXXX", 8);
    file = mkstemp(beside);
    if (file < 0) {
        cli_say("ricochet: cannot write %s: %s\n", path, strerror(errno));
        goto out;
    }
    const mode_t mask = umask(0);
    umask(mask);
    bool good = copy_file(result, file) && fchmod(file, 0666 & ~mask) == 0;
    good &= close(file) == 0;
    if (!good || rename(beside, target) != 0) {
        cli_say("ricochet: cannot write %s: %s\n", path, strerror(errno));
        unlink(beside);
        goto out;
    }
    code = CLI_DONE;
out:
    free(beside);
    free(real);
    return code;
}

int plot_page_write(plot_page *page, const plot_options *options)
{
    const char *path = options->out;
    const plot_format kind = format_of(path);
    FILE *script = tmpfile(), *result = tmpfile(), *complaint = tmpfile(), *small = NULL;
    int code = CLI_FAILED, status = 0;
    if (!script || !result || !complaint) {
        cli_say("ricochet: no temporary file for the picture: %s\n", strerror(errno));
        goto out;
    }
    if (!plot_page_script(page, kind, options, script) || fseek(script, 0, SEEK_SET) != 0) {
        cli_say("ricochet: the picture could not be prepared: %s\n",
                plot_page_failed(page) ? "out of memory" : strerror(errno));
        goto out;
    }
    if (kind == PLOT_FORMAT_GNUPLOT) {
        code = deliver(script, path);
        goto out;
    }
    const int failed = run_gnuplot(script, result, complaint, &status);
    if (failed == ENOENT) {
        cli_say("ricochet: gnuplot is not installed; pictures need it (Debian: apt-get install "
                "gnuplot-nox)\n");
        goto out;
    }
    if (failed) {
        cli_say("ricochet: gnuplot cannot be started: %s\n", strerror(failed));
        goto out;
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || !looks_like(result, kind)) {
        code = report_complaint(complaint, status);
        goto out;
    }
    if (kind == PLOT_FORMAT_SVG && !(small = tmpfile())) {
        cli_say("ricochet: no temporary file for the picture: %s\n", strerror(errno));
        goto out;
    }
    if (small && (!plot_svg_squeeze(result, small) || fseek(small, 0, SEEK_SET) != 0)) {
        cli_say("ricochet: the picture could not be written: %s\n", strerror(errno));
        goto out;
    }
    code = deliver(small ? small : result, path);
out:
    if (small) fclose(small);
    if (script) fclose(script);
    if (result) fclose(result);
    if (complaint) fclose(complaint);
    return code;
}
