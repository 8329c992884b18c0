/* ricochet: finds the command and runs it. */
#define _XOPEN_SOURCE 700

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

static const cli_command *const commands[] = {
    &cli_new,   &cli_check,   &cli_run,  &cli_branches, &cli_junctions, &cli_bases, &cli_points,   &cli_report_atlas,
    &cli_orbit, &cli_cascade, &cli_plot, &cli_view,     &cli_verify,    &cli_hunt,  &cli_simulate, &cli_words,
};

static void print_help(FILE *out)
{
    fputs("usage: ricochet COMMAND ...\n\n"
          "Periodic orbits of linear structures with stops, gaps and springs: from a study to an atlas.\n\n",
          out);
    for (int i = 0; i < COUNT(commands); i++) fprintf(out, "  %-10s %s\n", commands[i]->name, commands[i]->summary);
    fputs("\n  ricochet COMMAND --help   options and an example\n"
          "  ricochet --version\n\n"
          "A first atlas:\n"
          "  ricochet new demo\n"
          "  ricochet run demo/study.yaml\n"
          "  ricochet branches demo/study.ricochet\n\n"
          "Exit codes: 0 done, 1 could not be done, 2 the call or the study is wrong.\n",
          out);
}

/* Letters that two words share at the front, less what differs in length: enough for a slip of the finger. */
static int likeness(const char *a, const char *b)
{
    int common = 0, swapped = 0;
    while (a[common] && a[common] == b[common]) common++;
    for (const char *c = a; *c; c++) swapped += strchr(b, *c) != NULL;
    int longer = (int)strlen(a) - (int)strlen(b);
    return 2 * common + swapped - (longer < 0 ? -longer : longer);
}

static int unknown_command(const char *name)
{
    const char *closest = NULL;
    int best = 3;
    for (int i = 0; i < COUNT(commands); i++) {
        int like = likeness(name, commands[i]->name);
        if (like > best) {
            best = like;
            closest = commands[i]->name;
        }
    }
    if (closest)
        return cli_wrong("unknown command '%s'; did you mean '%s'? `ricochet --help` lists all", name, closest);
    return cli_wrong("unknown command '%s'; `ricochet --help` lists the commands", name);
}

static bool asks_for_help(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (!strcmp(argv[i], "--help") || !strcmp(argv[i], "-h")) return true;
    return false;
}

static int dispatch(int argc, char **argv)
{
    if (argc < 2) {
        print_help(stderr);
        return CLI_WRONG;
    }
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h") || (!strcmp(argv[1], "help") && argc == 2)) {
        print_help(stdout);
        return CLI_DONE;
    }
    if (!strcmp(argv[1], "--version")) {
        printf("ricochet %s\n", ric_version());
        return CLI_DONE;
    }
    for (int i = 0; i < COUNT(commands); i++)
        if (!strcmp(argv[1], commands[i]->name)) {
            if (asks_for_help(argc - 1, argv + 1)) {
                fputs(commands[i]->help, stdout);
                return CLI_DONE;
            }
            return commands[i]->run(argc - 1, argv + 1);
        }
    return unknown_command(argv[1]);
}

/* A standard stream that is closed is one that cannot be read or written; without this its number goes to the next
 * file that is opened, and messages into that file. */
static void hold_streams(void)
{
    int fd;
    do {
        fd = open("/dev/null", O_WRONLY);
        if (fd > STDIN_FILENO && fd <= STDERR_FILENO) { /* to be read only, so that writing to it fails */
            close(fd);
            fd = open("/dev/null", O_RDONLY);
        }
    } while (fd >= 0 && fd <= STDERR_FILENO);
    if (fd >= 0) close(fd);
}

int cli_main(int argc, char **argv)
{
    hold_streams();
    /* The locale stays "C": numbers are written with a decimal point everywhere. */
    cli_watch_memory();
    signal(SIGXFSZ, SIG_IGN); /* a file that may not grow is then an error like a full disk, and has a message */
    int code = dispatch(argc, argv);
    errno = 0;
    if ((fflush(stdout) || ferror(stdout)) && code == CLI_DONE) {
        fprintf(stderr, "ricochet: the output cannot be written: %s\n", errno ? strerror(errno) : "write error");
        code = CLI_FAILED;
    }
    return ferror(stderr) && code == CLI_DONE ? CLI_FAILED : code; /* a report or a warning has not arrived */
}
