/* ricochet: finds the command and runs it. */
#define _XOPEN_SOURCE 700

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sqlite3.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "cli.h"

const cli_command *const cli_commands[] = {
    &cli_new,       &cli_check,    &cli_run,           &cli_branches,
    &cli_junctions, &cli_bases,    &cli_points,        &cli_report_atlas,
    &cli_orbit,     &cli_cascade,  &cli_plot,          &cli_view,
    &cli_verify,    &cli_prove,    &cli_hunt,          &cli_section_command,
    &cli_force,     &cli_response, &cli_locus_command, &cli_simulate,
    &cli_words,     &cli_export,   &cli_help,          NULL,
};

const cli_item cli_program_items[] = {
    {.name = "--help",
     .text = "what the program does; behind a command: what that does, its options and an example"},
    {.name = "--version", .text = "the version"},
    {.name = "--man",
     .value = "COMMAND",
     .text = "the manual page of a command, or of ricochet, for man -l"},
    {.name = "--completion",
     .value = "SHELL",
     .words = "bash zsh fish",
     .text = "what makes a shell complete commands, options and their values"},
    {0},
};

const cli_exit_code cli_exit_codes[] = {
    {CLI_DONE, "done"},
    {CLI_FAILED, "could not be done, or what was checked does not agree"},
    {CLI_WRONG, "the call or the study is wrong, or a file that was named is missing, or a study "
                "where an atlas belongs"},
    {CLI_LIMIT, "stopped by a limit that was asked for: there is more to do"},
    {CLI_INTERRUPTED, "interrupted, by Ctrl-C or a signal to end"},
    {0, NULL},
};

void cli_print_program_help(FILE *out)
{
    fputs("usage: ricochet COMMAND ...\n\n"
          "Periodic orbits of linear structures with stops, gaps and springs: from a study to an "
          "atlas.\n\n",
          out);
    for (const cli_command *const *c = cli_commands; *c; c++)
        fprintf(out, "  %-10s %s\n", (*c)->name, (*c)->summary);
    fputs("\n  ricochet COMMAND --help   options and an example\n"
          "  ricochet --version\n"
          "  ricochet --man COMMAND    its manual page; of the program: ricochet --man ricochet\n"
          "  ricochet --completion bash|zsh|fish\n\n"
          "A first atlas:\n"
          "  ricochet new demo\n"
          "  ricochet run demo/study.yaml\n"
          "  ricochet branches demo/study.ricochet\n\n"
          "Exit codes:\n",
          out);
    for (const cli_exit_code *e = cli_exit_codes; e->meaning; e++)
        fprintf(out, "  %3d   %s\n", e->code, e->meaning);
}

static int unknown_command(const char *name)
{
    if (name[0] == '-')
        return cli_wrong("'%s' stands before the command; write `ricochet COMMAND ... %s`, and "
                         "`ricochet --help` lists the commands",
                         name, name);
    cli_guess guess = {.word = name};
    for (const cli_command *const *c = cli_commands; *c; c++) cli_nearest(&guess, (*c)->name);
    if (guess.known)
        return cli_wrong("unknown command '%s'; did you mean '%s'? `ricochet --help` lists all",
                         name, guess.known);
    return cli_wrong("unknown command '%s'; `ricochet --help` lists the commands", name);
}

static bool asks_for_help(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (!strcmp(argv[i], "--help") || !strcmp(argv[i], "-h")) return true;
    return false;
}

static const cli_command *find_command(const char *name)
{
    for (const cli_command *const *c = cli_commands; *c; c++)
        if (!strcmp(name, (*c)->name)) return *c;
    return NULL;
}

static int print_manual(const char *name)
{
    const bool program = !strcmp(name, "ricochet");
    const cli_command *command = program ? NULL : find_command(name);
    if (!program && !command) return unknown_command(name);
    cli_print_manual(command);
    return CLI_DONE;
}

/* `--man COMMAND` and `--completion SHELL`. */
static int print_made(int argc, char **argv)
{
    const bool manual = !strcmp(argv[1], "--man");
    if (argc != 3)
        return cli_wrong("%s needs %s", argv[1],
                         manual ? "one COMMAND, or ricochet" : "bash, zsh or fish");
    if (manual) return print_manual(argv[2]);
    if (cli_print_completion(argv[2])) return CLI_DONE;
    return cli_wrong("--completion %s: there are bash, zsh and fish", argv[2]);
}

static int run_command(const cli_command *command, int argc, char **argv)
{
    if (asks_for_help(argc, argv)) {
        cli_print_picture_help(command, cli_find_picture(command, argc, argv));
        return CLI_DONE;
    }
    if (!cli_know_options(command, argc, argv)) return CLI_WRONG;
    cli_handles handles = {.argc = argc, .argv = argv};
    int code = cli_has_pictures(command) ? CLI_DONE : cli_resolve_handles(command, &handles);
    if (code == CLI_DONE) code = command->run(handles.argc, handles.argv);
    cli_handles_release(&handles);
    return code;
}

static int dispatch(int argc, char **argv)
{
    if (argc < 2) {
        cli_print_program_help(stderr);
        return CLI_WRONG;
    }
    const bool help = !strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"),
               version = !strcmp(argv[1], "--version") || !strcmp(argv[1], "-V");
    if ((help || version) && argc > 2)
        return cli_wrong("%s: '%s' is one argument too many", argv[1], argv[2]);
    if (help) cli_print_program_help(stdout);
    if (version) printf("ricochet %s\n", ric_version());
    if (help || version) return CLI_DONE;
    if (!strcmp(argv[1], "--man") || !strcmp(argv[1], "--completion"))
        return print_made(argc, argv);
    const cli_command *command = find_command(argv[1]);
    return command ? run_command(command, argc - 1, argv + 1) : unknown_command(argv[1]);
}

/* A standard stream that is closed is one that cannot be read or written; without this its number
 * goes to the next file that is opened, and messages into that file. */
static void hold_streams(void)
{
    int fd;
    do {
        fd = open("/dev/null", O_WRONLY);
        if (fd > STDIN_FILENO &&
            fd <= STDERR_FILENO) { /* to be read only, so that writing to it fails */
            close(fd);
            fd = open("/dev/null", O_RDONLY);
        }
    } while (fd >= 0 && fd <= STDERR_FILENO);
    if (fd >= 0) close(fd);
}

/* Memory that is freed stays with the program: the GNU library gives that of threads back to the
 * system, and asks for it again page by page, thousands of times in a run with workers. Blocks of
 * more than 32 MB (MAPPED) are still given back at once. SQLite counts what it has in use under one
 * lock, for which threads with connections of their own wait; nobody asks for that number. */
static void keep_memory(void)
{
    sqlite3_config(SQLITE_CONFIG_MEMSTATUS, 0);
#ifdef __GLIBC__
    enum { KEPT = 1 << 28, MORE = 1 << 20, MAPPED = 1 << 25 }; /* bytes */
    mallopt(M_TRIM_THRESHOLD, KEPT);
    mallopt(M_TOP_PAD, MORE);
    mallopt(M_MMAP_THRESHOLD, MAPPED);
#endif
}

int cli_main(int argc, char **argv)
{
    keep_memory();
    hold_streams();
    /* The locale stays "C": numbers are written with a decimal point everywhere. */
    cli_watch_memory();
    signal(SIGXFSZ, SIG_IGN); /* a file that may not grow is then an error like a full disk, and has
                                 a message */
    int code = dispatch(argc, argv);
    errno = 0;
    if ((fflush(stdout) || ferror(stdout)) && code == CLI_DONE) {
        fprintf(stderr, "ricochet: the output cannot be written: %s\n",
                errno ? strerror(errno) : "write error");
        code = CLI_FAILED;
    }
    if (cli_left_unsaid() && code == CLI_DONE) {
        fputs("ricochet: out of memory: not all was told\n", stderr);
        code = CLI_FAILED;
    }
    return ferror(stderr) && code == CLI_DONE ? CLI_FAILED
                                              : code; /* a report or a warning has not arrived */
}
