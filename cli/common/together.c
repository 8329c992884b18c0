/* Contacts that close together: what a study may say of them, and what follows where it does. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

/* "modes 1, 3"; of many the first ones, and how many they are. */
static void list_modes(int n, const bool *mode, size_t size, char *out)
{
    enum { SHOWN = 12 };
    int count = 0, shown = 0;
    for (int i = 0; i < n; i++) count += mode[i];
    size_t used = (size_t)snprintf(out, size, "mode%s", cli_plural(count));
    for (int i = 0; i < n && shown < SHOWN; i++)
        if (mode[i])
            used += (size_t)snprintf(out + used, size - used, "%s%d", shown++ ? ", " : " ", i + 1);
    if (shown < count) snprintf(out + used, size - used, ", ... (%d in all)", count);
}

bool cli_together_next(const ric_model *model, int *last, char text[CLI_TOGETHER])
{
    enum { MODES = 200, KEY = CLI_TOGETHER - 400 };
    const int n = ric_model_n_dof(model);
    char key[KEY], modes[MODES];
    bool *mode = calloc((size_t)n + 1, sizeof *mode);
    *last = mode ? ric_model_together(model, *last, sizeof key, key, mode) : 0;
    if (*last) {
        list_modes(n, mode, sizeof modes, modes);
        snprintf(text, CLI_TOGETHER,
                 "motions of %s alone close contacts together and are no branches here: "
                 "`together: %s` under `model` makes the study of them",
                 modes, key);
    }
    free(mode);
    return *last;
}

const char *cli_together_remark(const ric_model *model)
{
    ric_contact c;
    for (int f = 0; f < ric_model_n_contact(model); f++)
        if (!ric_model_contact(model, f, &c) && c.together > 1)
            return "contacts close together, by `together`: stability, multipliers and junctions "
                   "are about disturbances that keep them so; of others `ricochet orbit` has "
                   "`parting`";
    return "";
}
