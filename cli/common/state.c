/* A state and a time on the command line: --state X.. V.. and --time T, of `ricochet simulate` and
 * its picture. */
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static bool is_number(const char *text)
{
    char *end;
    strtod(text, &end);
    return end != text && !*end;
}

bool cli_take_state(int *argc, char **argv, const char *what, int *count, const char **texts)
{
    int at = 1;
    *count = 0;
    while (at < *argc && strncmp(argv[at], "--state", 7)) at++;
    if (at < *argc && argv[at][7] == '=') {
        cli_wrong("%s: %s: the numbers follow after a blank, for example --state 0 0 1 -1", what,
                  argv[at]);
        return false;
    }
    if (at == *argc || argv[at][7]) {
        cli_wrong("%s: --state is missing; give the displacements and then the velocities, for "
                  "example --state 0 0 1 -1",
                  what);
        return false;
    }
    int next = at + 1;
    while (next < *argc && is_number(argv[next])) texts[(*count)++] = argv[next++];
    if (next < *argc && argv[next][0] != '-' &&
        *argc - (next - at) > 2) { /* more than the study is left */
        cli_wrong("%s: '%s' after --state is not a number; give displacements, then velocities, "
                  "with blanks between",
                  what, argv[next]);
        return false;
    }
    memmove(argv + at, argv + next, (size_t)(*argc - next + 1) * sizeof *argv);
    *argc -= next - at;
    return true;
}

bool cli_parse_state(const char *what, const ric_model *model, int count, const char **texts,
                     double length, double *out)
{
    const int n = ric_model_n_dof(model);
    if (count != 2 * n) {
        cli_wrong("%s: --state has %d number%s; this study needs %d: %d displacement%s, then as "
                  "many velocities",
                  what, count, count == 1 ? "" : "s", 2 * n, n, n == 1 ? "" : "s");
        return false;
    }
    for (int i = 0; i < count; i++) {
        if (!cli_parse_number(texts[i], "--state", &out[i])) return false;
        out[i] /= length;
    }
    if (!ric_model_check_state(model, out, out + n)) return true;
    cli_wrong("%s: --state: %s", what, ric_detail());
    return false;
}

bool cli_parse_end(const char *what, const char *text, double *out)
{
    if (!text) {
        cli_wrong("%s: --time is missing; give the time to stop at, in seconds", what);
        return false;
    }
    if (!cli_parse_number(text, "--time", out)) return false;
    if (*out > 0) return true;
    cli_wrong("%s: --time '%s' is not positive; motion is followed forward from time 0", what,
              text);
    return false;
}
