/* ricochet new NAME: a commented study that runs as it is written. */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "study/options.h"
#include "common/cli.h"

static const char model_part[] =
    "# Matrices are in any consistent units; results are scaled by the clearance d of the first "
    "contact: lengths by d, "
    "energies\n"
    "# by d^2. Times are in seconds and frequencies in rad/s if the units of M and K say so.\n"
    "model:\n"
    "  # Two masses in a row, 2 and 1, held by springs 8 and 1. One row and one column per "
    "displacement; M positive "
    "definite,\n"
    "  # K positive semidefinite, both symmetric. Large ones from Matrix Market files: mass: "
    "{file: M.mtx}\n"
    "  mass: [[2, 0], [0, 1]]\n"
    "  stiffness: [[9, -1], [-1, 1]]\n"
    "  contacts:\n"
    "    - name: stop           # optional\n"
    "      normal: [-1, 1]      # gap coordinate s = b.x, here x2 - x1\n"
    "      clearance: 1.0       # d > 0: the stop is at s = d and, on the other side, at s = -d\n"
    "      sides: both          # both, upper (s <= d) or lower (s >= -d)\n"
    "      law: rigid           # or bilinear, with the stiffness of a spring behind the gap; or "
    "power, with keys of "
    "its own\n";

/* Fit to stand between quotes in YAML; a folder may be called anything. */
static bool is_plain(const char *title)
{
    for (; *title; title++)
        if (*title < 0x20 || *title > 0x7E || *title == '"' || *title == '\\') return false;
    return true;
}

static void write_study(const char *title, FILE *out)
{
    fputs("# A study for ricochet. `ricochet check` shows what the model is, `ricochet run` "
          "explores it.\ntitle: \"",
          out);
    fputs(is_plain(title) ? title : "Two masses with symmetric stops", out);
    fputs("\"\n\n", out);
    fputs(model_part, out);
    fputs("\n# Where to look. These are the defaults; raise impacts and depth when the first atlas "
          "is understood.\n"
          "explore:\n",
          out);
    ric_options_template("explore", out);
    fputc('\n', out);
    ric_options_template("", out);
    fputs("\n# Names for junctions, matched by kind, energy and frequency.\n"
          "names:\n"
          "  - {name: \"G1_0,2\", kind: grazing, energy: 0.601588369489, frequency: "
          "0.9287310650464}\n"
          "\n# What the structure loses and what shakes it, for `ricochet simulate`, `force` and "
          "`response`; the atlas "
          "is "
          "that without.\n"
          "# damping: 0.01           # modal ratios; or {alpha: 0.1, beta: 0.001}, or a matrix\n"
          "# restitution: 0.95       # of all rigid stops, 0 to 1\n"
          "# forcing: {vector: [1, 0], amplitude: 0.2, frequency: [0.3, 3.2]}\n",
          out);
}

/* The part of NAME after the last slash, which becomes the title. */
static const char *last_part(char *name)
{
    size_t length = strlen(name);
    while (length > 1 && name[length - 1] == '/') name[--length] = '\0';
    const char *slash = strrchr(name, '/');
    return slash && slash[1] ? slash + 1 : name;
}

static int fail(const char *path)
{
    const int reason = errno;
    if (reason == ENOENT || reason == ENOTDIR)
        return cli_wrong(
            "new: %s: %s; make the folder that it is to lie in first, or choose another name", path,
            strerror(reason));
    cli_say("ricochet: new: %s: %s; choose another name\n", path, strerror(reason));
    return CLI_FAILED;
}

static int create(const char *folder, const char *title)
{
    size_t size = strlen(folder) + sizeof "/study.yaml";
    char *path = malloc(size);
    FILE *out = NULL;
    int file, code = CLI_DONE;
    if (!path) return cli_report(RIC_E_NOMEM);
    snprintf(path, size, "%s/study.yaml", folder);
    if (mkdir(folder, 0777) && errno != EEXIST) {
        code = fail(folder);
        goto out;
    }
    file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0 && errno == EEXIST) {
        cli_say("ricochet: new: %s exists and is left as it is; choose another name\n", path);
        code = CLI_FAILED;
        goto out;
    }
    if (file < 0 || !(out = fdopen(file, "w"))) {
        code = fail(path);
        goto out;
    }
    write_study(title, out);
    if (fflush(out) || ferror(out)) {
        code = fail(path);
        unlink(path); /* half a study would be worse than none */
    } else printf("%s\n", path);
out:
    if (out) fclose(out);
    free(path);
    return code;
}

static int run(int argc, char **argv)
{
    if (argc == 2 && !argv[1][0])
        return cli_wrong("new: the name is empty; for example: ricochet new two-masses");
    if (!cli_operands(&cli_new, argc, argv, 1)) return CLI_WRONG;
    const char *title = last_part(argv[1]);
    return create(argv[1], title);
}

static const cli_item items[] = {
    {.text = "Writes NAME/study.yaml, a study with comments that runs as it is, and prints its "
             "path. An existing "
             "file is left alone."},
    {0},
};

const cli_command cli_new = {
    .name = "new",
    .summary = "write a commented study to start from",
    .usage = "ricochet new NAME\n",
    .items = items,
    .example = "ricochet new two-masses && ricochet check two-masses/study.yaml\n",
    .run = run,
};
