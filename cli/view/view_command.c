/* The module view: a page to look at an atlas, served to the browser of this machine. */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "common/module.h"
#include "view.h"

enum {
    FIRST_PORT = 8787,
    PAGE_PATH = 4096,
    PAGE_SECONDS = 60, /* that a browser may take to start */
    LEAVING_SECONDS = 2,
};
#define PAGE_NAME "/open.html"

/* ------------------------------------------------------------------ browser */

static bool on_path(const char *program)
{
    const char *path = getenv("PATH");
    char *copy = path ? strdup(path) : NULL, *rest = NULL, file[4096];
    bool found = false;
    for (char *part = copy ? strtok_r(copy, ":", &rest) : NULL; part && !found;
         part = strtok_r(NULL, ":", &rest)) {
        snprintf(file, sizeof file, "%s/%s", part, program);
        found = !access(file, X_OK);
    }
    free(copy);
    return found;
}

static void remove_page(char *page)
{
    if (!*page) return;
    unlink(page);
    page[strlen(page) - strlen(PAGE_NAME)] = '\0';
    rmdir(page);
    *page = '\0';
}

static bool has_browser(void)
{
    return on_path("xdg-open") && (getenv("DISPLAY") || getenv("WAYLAND_DISPLAY"));
}

/* The arguments of a program are for everybody on the machine to read: the browser is not given the
 * address, which holds the token, but a file that only its owner can read, and that leads there.
 * *page: its path, "" if there is none. */
static bool write_page(const char *address, char *page)
{
    const char *home = getenv("XDG_RUNTIME_DIR");
    if (!home || !*home) home = getenv("TMPDIR");
    const int n = snprintf(page, PAGE_PATH - sizeof PAGE_NAME, "%s/ricochet-XXXXXX",
                           home && *home ? home : "/tmp");
    if (n < 0 || n >= (int)(PAGE_PATH - sizeof PAGE_NAME) || !mkdtemp(page)) {
        *page = '\0';
        return false;
    }
    strcpy(page + n, PAGE_NAME);
    const int fd = open(page, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    const bool written =
        fd >= 0 &&
        dprintf(fd,
                "<!doctype html><meta charset=utf-8><title>ricochet</title>"
                "<meta http-equiv=refresh content=\"0;url=%s\"><a href=\"%s\">ricochet view</a>\n",
                address, address) > 0;
    if (fd >= 0) close(fd);
    if (!written) remove_page(page);
    return written;
}

/* Twice forked, so that the browser is nobody's child to wait for; quiet, because browsers are not.
 */
static bool open_browser(const char *address)
{
    const pid_t child = fork();
    if (child == 0) {
        const int nothing = open("/dev/null", O_RDWR);
        if (fork() != 0) _exit(0);
        setsid();
        if (nothing >= 0) {
            dup2(nothing, 0);
            dup2(nothing, 1);
            dup2(nothing, 2);
        }
        execlp("xdg-open", "xdg-open", address, (char *)NULL);
        _exit(127);
    }
    if (child > 0) waitpid(child, NULL, 0);
    return child > 0;
}

/* -------------------------------------------------------------------- serve */

typedef struct {
    view_listen where;
    const char *response; /* a file, or NULL */
    long workers;
    bool browser;
} view_options;

static void announce(const view_server *server, const view_options *o, const char *path, char *page)
{
    const char *address = view_server_address(server);
    if (!view_server_loopback(server))
        cli_say("ricochet: WARNING: whoever reaches this address reads %s, and with the token "
                "extends it; nothing is "
                "encrypted\n",
                path);
    printf("%s\n", address);
    if (fflush(stdout)) /* nobody would know */
        cli_say("ricochet: view: the address cannot be written (%s); it is %s\n", strerror(errno),
                address);
    if (o->browser && has_browser() && write_page(address, page) && open_browser(page))
        fputs("opened in the browser; ", stderr);
    fputs("Ctrl-C ends it\n", stderr);
}

/* Until a signal comes. What another run writes into the atlas appears on the pages. */
static void wait_and_watch(view_server *server, view_shelf *shelf, view_grower *grower, char *page)
{
    const struct timespec tick = {.tv_nsec = 100000000};
    for (unsigned long n = 1; !cli_stopped(); n++) {
        nanosleep(&tick, NULL);
        view_server_tidy(server);
        if (*page && (view_server_visited(server) || n > 10 * PAGE_SECONDS)) remove_page(page);
        if (n % 10 == 0 && !view_grower_busy(grower) && view_shelf_stale(shelf) &&
            view_shelf_reload(shelf))
            cli_say("ricochet: %s; the pages keep to what was there before\n", ric_detail());
    }
}

/* What has not heard of the end by now is left as by a kill, which an atlas survives. */
static void leave(int number)
{
    (void)number;
    _exit(CLI_DONE);
}

static void leave_soon(void)
{
    signal(SIGALRM, leave);
    alarm(LEAVING_SECONDS);
}

/* Threads inherit the mask of the one that starts them: signals are for the main thread, which
 * alone reads whether there was one. */
static void block_signals(bool block)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    pthread_sigmask(block ? SIG_BLOCK : SIG_UNBLOCK, &set, NULL);
}

/* Exact curves, of this structure and along the frequency. */
static int open_response(const char *path, view_shelf *shelf, ric_response **out)
{
    if (!path) return CLI_DONE;
    const ric_status status = ric_response_read(path, out);
    if (status) return cli_report(status);
    view_data *data = view_data_take(shelf);
    const bool same = ric_model_same(ric_response_model(*out), ric_atlas_model(data->atlas));
    view_data_release(shelf, data);
    if (!same)
        return cli_wrong("view: %s is the response of another structure than that of the atlas",
                         path);
    if (ric_response_asked(*out)->along != RIC_RESPONSE_OMEGA)
        return cli_wrong("view: %s is not along the frequency; the page draws amplitudes over that",
                         path);
    return CLI_DONE;
}

static int serve(const char *path, const char *other, const view_options *o)
{
    view_listen where = o->where;
    ric_response *response = NULL;
    view_shelf *shelf = NULL;
    view_grower *grower = NULL;
    view_server *server = NULL;
    char page[PAGE_PATH] = "";
    int code = CLI_FAILED;
    ric_status status = view_shelf_open(path, &shelf);
    if (!status && other) status = view_shelf_open(other, &where.other);
    if (!status) status = view_grower_create(shelf, (int)o->workers, &grower);
    if (status) {
        code = cli_report(status);
        goto out;
    }
    if ((code = open_response(o->response, shelf, &response))) goto out;
    where.response = response;
    code = CLI_FAILED;
    cli_catch_signals();
    signal(SIGPIPE, SIG_IGN); /* a browser may close a connection at any time */
    block_signals(true);
    server = view_server_start(shelf, grower, &where);
    block_signals(false);
    if (server) {
        announce(server, o, path, page);
        wait_and_watch(server, shelf, grower, page);
        leave_soon();
        if (view_grower_busy(grower))
            fputs("ricochet: stopping the extension; what was done is kept\n", stderr);
        code = CLI_DONE;
    }
out:
    remove_page(page);
    if (grower) view_grower_leave(grower);
    view_server_stop(server); /* requests end before what they use */
    view_grower_free(grower);
    view_shelf_close(shelf);
    view_shelf_close(where.other);
    ric_response_free(response);
    return code;
}

/* Under another name until all of it is there: what was in the file before is not lost to a full
 * disk. */
static int save(const char *path, const char *name)
{
    view_shelf *shelf = NULL;
    bool written = false;
    char part[PAGE_PATH];
    if (snprintf(part, sizeof part, "%s.part", name) >= (int)sizeof part)
        return cli_wrong("view: --save '%s' is too long for a name", name);
    ric_status status = view_shelf_open(path, &shelf);
    if (status) return cli_report(status);
    view_data *data = view_data_take(shelf);
    FILE *file = fopen(part, "w");
    if (file) status = view_save(data, file, &written);
    if (file && fclose(file)) written = false;
    if (written) written = !rename(part, name);
    const int why = errno;
    if (file && !written) unlink(part);
    view_data_release(shelf, data);
    view_shelf_close(shelf);
    if (status) return cli_report(status);
    if (written) return CLI_DONE;
    cli_say("ricochet: view: %s cannot be written (%s)\n", name, strerror(why));
    return CLI_FAILED;
}

int view_command(int argc, char **argv)
{
    const char *port = NULL, *workers = NULL, *name = NULL;
    long number = FIRST_PORT;
    view_options o = {.workers = 1, .browser = !cli_take_flag(&argc, argv, "--no-browser")};
    if (!cli_take_value(&argc, argv, "--port", &port) ||
        !cli_take_value(&argc, argv, "--save", &name) ||
        !cli_take_value(&argc, argv, "--response", &o.response) ||
        !cli_take_value(&argc, argv, "--listen", &o.where.address) ||
        !cli_take_value(&argc, argv, "-j", &workers) ||
        !cli_operands(&cli_view, argc, argv, argc == 3 ? 2 : 1) ||
        (port && !cli_parse_integer(port, "--port", 0, 65535, &number)) ||
        (workers && !cli_parse_integer(workers, "-j", 1, 1024, &o.workers)))
        return CLI_WRONG;
    if (o.where.address && !view_address_valid(o.where.address))
        return cli_wrong("view: --listen '%s' is not an address; give one of this machine's, such "
                         "as 192.168.1.7, or "
                         "0.0.0.0 for all",
                         o.where.address);
    if (!view_page[0].path) {
        fputs("ricochet: view: this program was built without the page, because neither esbuild "
              "nor Node.js with the "
              "packages in web/ was there. Install one (Debian: esbuild; then `make build` builds "
              "it)\n",
              stderr);
        return CLI_FAILED;
    }
    if (name && argc == 3) return cli_wrong("view: --save writes a page of one atlas");
    if (name && o.response)
        return cli_wrong("view: --save writes no response; leave --response out");
    if (name) return save(argv[1], name);
    o.where.port = (int)number;
    o.where.exact = port != NULL;
    return serve(argv[1], argc == 3 ? argv[2] : NULL, &o);
}
