/* `ricochet COMMAND --help`, and how the table of a command is read. */
#include <stdio.h>
#include <string.h>

#include "cli.h"

enum {
    WIDTH = 100,    /* columns of a page of help */
    NAMES_MAX = 18, /* columns of names; a longer one has a line of its own */
};

/* ------------------------------------------------------------------- table */

bool cli_is_option_item(const cli_item *item)
{
    return item->name && item->name[0] == '-';
}

bool cli_takes_file(const cli_item *item)
{
    return item->value && (!strcmp(item->value, "FILE") || !strcmp(item->value, "ATLAS") ||
                           !strcmp(item->value, "STUDY"));
}

bool cli_is_picture(const cli_item *item)
{
    return item->picture && strcmp(item->name, "all") != 0 && strcmp(item->name, "names") != 0;
}

bool cli_has_pictures(const cli_command *command)
{
    for (const cli_item *item = command->items; item->text; item++)
        if (item->picture) return true;
    return false;
}

/* The picture that an item belongs to, "all" before the first one. */
static const char *picture_of(const cli_command *command, const cli_item *item)
{
    const char *picture = "all";
    for (const cli_item *i = command->items; i <= item; i++)
        if (i->picture) picture = i->name;
    return picture;
}

const cli_item *cli_next_option(const cli_command *command, const char *picture,
                                const cli_item *last)
{
    for (const cli_item *item = last ? last + 1 : command->items; item->text; item++) {
        const char *of = picture_of(command, item);
        if (cli_is_option_item(item) && (!picture || !strcmp(of, "all") || !strcmp(of, picture)))
            return item;
    }
    return NULL;
}

/* -------------------------------------------------------------------- help */

void cli_print_wrapped(const char *text, int column, int indent, int width)
{
    for (bool first = true; *text; first = false) {
        const int n = (int)strcspn(text, " ");
        const bool breaks = !first && column + 1 + n > width;
        if (breaks) printf("\n%*s", indent, "");
        else if (!first) putchar(' ');
        column = breaks ? indent + n : column + n + !first;
        printf("%.*s", n, text);
        text += n + (text[n] == ' ');
    }
    putchar('\n');
}

/* Lines of a text, each after `first` or, if it continues one, after its own blanks. */
static void print_lines(FILE *out, const char *head, const char *text)
{
    for (bool begun = false; *text; begun = true) {
        const int n = (int)strcspn(text, "\n");
        if (*text == ' ') fprintf(out, "%.*s\n", n, text);
        else fprintf(out, "%*s%.*s\n", (int)strlen(head), begun ? "" : head, n, text);
        text += n + (text[n] == '\n');
    }
}

static int name_width(const cli_item *item)
{
    return (int)strlen(item->name) + (item->value ? 1 + (int)strlen(item->value) : 0);
}

/* Columns of the names of a command, so that their meanings stand below each other. */
static int names_width(const cli_command *command)
{
    int width = 0;
    for (const cli_item *item = command->items; item->text; item++)
        if (item->name && name_width(item) > width && name_width(item) <= NAMES_MAX)
            width = name_width(item);
    return width;
}

static void print_item(const cli_item *item, int width)
{
    const int indent = width + 4, left = item->picture ? 0 : 2, end = left + name_width(item);
    printf("%*s%s%s%s", left, "", item->name, item->value ? " " : "",
           item->value ? item->value : "");
    if (end + 2 > indent) printf("\n%*s", indent, "");
    else printf("%*s", indent - end, "");
    cli_print_wrapped(item->text, indent, indent, WIDTH);
}

/* Whether an item is of use to who draws this picture: its own, or one for all. NULL: the help of
 * all pictures. */
static bool belongs(const cli_command *command, const cli_item *item, const char *picture)
{
    const char *of = picture_of(command, item);
    return !picture || !strcmp(of, picture) || !strcmp(of, "all") || !strcmp(of, "names");
}

/* The lines of a usage that draw one picture, and what is said of each. */
static void print_picture_usage(const cli_command *command, const char *picture)
{
    bool shown = false, begun = false;
    const size_t name = strlen("ricochet ") + strlen(command->name) + 1, length = strlen(picture);
    for (const char *line = command->usage; *line; line += strcspn(line, "\n") + 1) {
        const bool calls = !strncmp(line, "ricochet ", 9);
        if (*line != ' ')
            shown = !calls ||
                    (!strncmp(line + name, picture, length) && line[name + length] == ' ');
        if (!shown) continue;
        const char *head = calls && !begun ? "usage: " : calls ? "       " : "";
        printf("%s%.*s\n", head, (int)strcspn(line, "\n"), line);
        begun = true;
    }
}

void cli_print_picture_help(const cli_command *command, const char *picture)
{
    const int width = names_width(command);
    if (picture) print_picture_usage(command, picture);
    else print_lines(stdout, "usage: ", command->usage);
    for (const cli_item *item = command->items; item->text; item++) {
        const bool opens = item == command->items || !item->name != !item[-1].name ||
                           item->picture ||
                           (!item[-1].picture &&
                            cli_is_option_item(item) != cli_is_option_item(item - 1));
        if (!belongs(command, item, picture)) continue;
        if (opens || !item->name) putchar('\n');
        if (item->name) print_item(item, width);
        else cli_print_wrapped(item->text, 0, 0, WIDTH);
    }
    putchar('\n');
    print_lines(stdout, "example: ", command->example);
}

void cli_print_help(const cli_command *command)
{
    cli_print_picture_help(command, NULL);
}

void cli_say_usage(const cli_command *command)
{
    fprintf(stderr, "usage: %.*s\n", (int)strcspn(command->usage, "\n"), command->usage);
}
