/* `ricochet --man COMMAND`: pages of section 1 in the macros of man(7), from the same tables as
 * --help. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"

/* A character that troff would change or obey: its escape, else NULL. */
static const char *escaped(char c)
{
    return c == '\\'   ? "\\e"
           : c == '^'  ? "\\(ha"
           : c == '~'  ? "\\(ti"
           : c == '`'  ? "\\(ga"
           : c == '\'' ? "\\(aq"
                       : NULL;
}

/* Text without line breaks. The dashes of an option are minus signs, which can be copied to a
 * shell. */
static void put_text(int n, const char *text)
{
    bool option = false;
    if (n && (*text == '.' || *text == '\'')) fputs("\\&", stdout);
    for (int i = 0; i < n; i++) {
        const bool starts = i == 0 || !isalnum((unsigned char)text[i - 1]);
        option = text[i] == '-' && starts
                     ? true
                     : option && (text[i] == '-' || isalnum((unsigned char)text[i]));
        const char *escape = text[i] == '-' && option ? "\\-" : escaped(text[i]);
        if (escape) fputs(escape, stdout);
        else putchar(text[i]);
    }
}

static void put(const char *text)
{
    put_text((int)strlen(text), text);
}

static void section(const char *name)
{
    printf(".SH %s\n", name);
}

static void head(const char *name, const char *summary)
{
    fputs(".TH ", stdout);
    for (const char *c = name; *c; c++) putchar(toupper((unsigned char)*c));
    printf(" 1 \"\" \"ricochet %s\" \"ricochet\"\n", ric_version());
    section("NAME");
    put(name);
    fputs(" \\- ", stdout);
    put(summary);
    putchar('\n');
}

static void paragraph(const char *text)
{
    fputs(".PP\n", stdout);
    put(text);
    putchar('\n');
}

static void item(const cli_item *i)
{
    fputs(".TP\n\\fB", stdout);
    put(i->name);
    fputs("\\fR", stdout);
    if (i->value) {
        fputs(" \\fI", stdout);
        put(i->value);
        fputs("\\fR", stdout);
    }
    putchar('\n');
    put(i->text);
    putchar('\n');
}

/* Each usage is filled; its lines in the table are those of --help. */
static void synopsis(const char *usage)
{
    section("SYNOPSIS");
    for (const char *line = usage; *line; line += strcspn(line, "\n") + 1) {
        const int blanks = (int)strspn(line, " "),
                  name = blanks || strncmp(line, "ricochet ", 9) ? 0 : 9;
        if (name) fputs(line == usage ? ".SY ricochet\n" : ".YS\n.SY ricochet\n", stdout);
        else if (!blanks) fputs(".YS\n.PP\n", stdout);
        put_text((int)strcspn(line + blanks + name, "\n"), line + blanks + name);
        putchar('\n');
        if (!blanks && !name) return;
    }
    fputs(".YS\n", stdout);
}

static void examples(const char *example)
{
    section("EXAMPLES");
    fputs(".EX\n", stdout);
    for (const char *line = example; *line; line += strcspn(line, "\n") + 1) {
        put_text((int)strcspn(line, "\n"), line);
        putchar('\n');
    }
    fputs(".EE\n", stdout);
}

static void exit_status(void)
{
    section("EXIT STATUS");
    for (const cli_exit_code *e = cli_exit_codes; e->meaning; e++)
        printf(".TP\n%d\n%s\n", e->code, e->meaning);
}

static void see_also(const cli_command *self)
{
    section("SEE ALSO");
    bool first = !self;
    if (self) fputs(".BR ricochet (1)", stdout);
    for (const cli_command *const *c = cli_commands; *c; c++)
        if (*c != self) {
            printf("%s.BR ricochet\\-%s (1)", first ? "" : ",\n", (*c)->name);
            first = false;
        }
    putchar('\n');
}

/* What is explained: the options, or all else. */
static void explain(const cli_command *command, bool options)
{
    for (const cli_item *i = command->items; i->text; i++) {
        if (cli_is_option_item(i) != options) continue;
        if (i->name) item(i);
        else paragraph(i->text);
    }
}

static const cli_item help_item = {.name = "--help", .text = "show this, shorter, and end"};

static void explain_pictures(const cli_command *command)
{
    for (const cli_item *i = command->items; i->text; i++)
        if (i->picture) {
            printf(".SS %s\n", i->name);
            put(i->text);
            putchar('\n');
        } else if (i->name) {
            item(i);
        } else {
            paragraph(i->text);
        }
}

static void print_command(const cli_command *command)
{
    char name[64];
    snprintf(name, sizeof name, "ricochet-%s", command->name);
    head(name, command->summary);
    synopsis(command->usage);
    section("DESCRIPTION");
    if (cli_has_pictures(command)) explain_pictures(command);
    else explain(command, false);
    section("OPTIONS");
    if (!cli_has_pictures(command)) explain(command, true);
    item(&help_item);
    exit_status();
    examples(command->example);
    see_also(command);
}

static void print_program(void)
{
    head("ricochet", "periodic orbits of linear structures with stops, gaps and springs");
    section("SYNOPSIS");
    fputs(".SY ricochet\n\\fICOMMAND\\fR ...\n.YS\n", stdout);
    section("DESCRIPTION");
    put("Computes families of periodic orbits, their junctions and their stability, from a study, "
        "a file of YAML, to "
        "an "
        "atlas, one file.");
    fputs("\n.SS Commands\n", stdout);
    for (const cli_command *const *c = cli_commands; *c; c++) {
        printf(".TP\n.BR ricochet\\-%s (1)\n", (*c)->name);
        put((*c)->summary);
        putchar('\n');
    }
    section("OPTIONS");
    for (const cli_item *i = cli_program_items; i->text; i++) item(i);
    exit_status();
    examples(
        "ricochet new demo\nricochet run demo/study.yaml\nricochet branches demo/study.ricochet\n");
    see_also(NULL);
}

void cli_print_manual(const cli_command *command)
{
    if (command) print_command(command);
    else print_program();
}
