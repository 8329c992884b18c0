/* `ricochet --completion SHELL`: scripts for bash, zsh and fish, from the same tables as --help. */
#include <stdio.h>
#include <string.h>

#include "cli.h"

/* A place where options are offered: a command, or a picture of one. */
typedef struct {
    const cli_command *command;
    const cli_item *picture; /* NULL: the command has none, or none has been chosen */
} scope;

typedef void (*visitor)(scope s);

static void visit(visitor visit_one)
{
    for (const cli_command *const *c = cli_commands; *c; c++) {
        if (!cli_has_pictures(*c)) visit_one((scope){*c, NULL});
        for (const cli_item *item = (*c)->items; item->text; item++)
            if (cli_is_picture(item)) visit_one((scope){*c, item});
    }
}

static const cli_item *next(scope s, const cli_item *last)
{
    return cli_next_option(s.command, s.picture ? s.picture->name : NULL, last);
}

static void print_pictures(const cli_command *command)
{
    for (const cli_item *item = command->items; item->text; item++)
        if (cli_is_picture(item)) printf(" %s", item->name);
}

/* A text inside single quotes; `special` characters are kept from the shell's own function by a
 * backslash. */
static void print_quoted(int n, const char *text, const char *quote, const char *special)
{
    for (int i = 0; i < n; i++) {
        if (text[i] == '\'') fputs(quote, stdout);
        else printf(strchr(special, text[i]) ? "\\%c" : "%c", text[i]);
    }
}

/* What a list of completions says of an option: up to the first stop. */
static int short_text(const char *text)
{
    return (int)strcspn(text, ";");
}

/* -------------------------------------------------------------------- bash */

static void bash_options(scope s)
{
    printf("    '%s%s%s') options='", s.command->name, s.picture ? " " : "",
           s.picture ? s.picture->name : "");
    for (const cli_item *item = NULL; (item = next(s, item));) printf("%s ", item->name);
    fputs("--help' ;;\n", stdout);
}

static void bash_values(scope s)
{
    for (const cli_item *item = NULL; (item = next(s, item));) {
        if (!item->value) continue;
        printf("    '%s%s%s %s') ", s.command->name, s.picture ? " " : "",
               s.picture ? s.picture->name : "", item->name);
        if (item->words) printf("kind=words words='%s' ;;\n", item->words);
        else printf("kind=%s ;;\n", cli_takes_file(item) ? "files" : "text");
    }
}

static void bash_pictures(void)
{
    for (const cli_command *const *c = cli_commands; *c; c++)
        if (cli_has_pictures(*c)) {
            printf("    %s) pictures='", (*c)->name);
            print_pictures(*c);
            fputs("' ;;\n", stdout);
        }
}

static void print_bash(void)
{
    fputs("# bash completion for ricochet, written by `ricochet --completion bash`\n"
          "_ricochet() {\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} last=${COMP_WORDS[COMP_CWORD-1]} "
          "scope=${COMP_WORDS[1]}\n"
          "    local commands='",
          stdout);
    for (const cli_command *const *c = cli_commands; *c; c++) printf("%s ", (*c)->name);
    for (const cli_item *item = cli_program_items; item->text; item++) printf("%s ", item->name);
    fputs("' options='' pictures='' kind='' words=''\n"
          "    COMPREPLY=()\n"
          "    if [ \"$COMP_CWORD\" = 1 ]; then\n"
          "        COMPREPLY=($(compgen -W \"$commands\" -- \"$word\"))\n"
          "        return\n"
          "    fi\n"
          "    if [ \"$word\" = = ]; then word=''; elif [ \"$last\" = = ]; then "
          "last=${COMP_WORDS[COMP_CWORD-2]}; fi\n"
          "    case $scope in\n",
          stdout);
    bash_pictures();
    fputs("    esac\n"
          "    if [ -n \"$pictures\" ]; then\n"
          "        if [ \"$COMP_CWORD\" = 2 ]; then\n"
          "            COMPREPLY=($(compgen -W \"$pictures --help\" -- \"$word\"))\n"
          "            return\n"
          "        fi\n"
          "        scope=\"$scope ${COMP_WORDS[2]}\"\n"
          "    fi\n"
          "    case \"$scope $last\" in\n",
          stdout);
    for (const cli_item *item = cli_program_items; item->text; item++)
        if (item->value)
            printf("    '%s %s') kind=words words=\"%s\" ;;\n", item->name, item->name,
                   item->words ? item->words : "${commands%%--*}ricochet");
    visit(bash_values);
    fputs("    esac\n"
          "    case \"$scope\" in\n",
          stdout);
    visit(bash_options);
    fputs("    esac\n"
          "    case $kind in\n"
          "    words) COMPREPLY=($(compgen -W \"$words\" -- \"$word\")) ;;\n"
          "    text) ;;\n"
          "    *)\n"
          "        if [ -z \"$kind\" ] && [[ $word == -* ]]; then\n"
          "            COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
          "        else\n"
          "            compopt -o filenames 2>/dev/null\n"
          "            mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
          "        fi ;;\n"
          "    esac\n"
          "}\n"
          "complete -F _ricochet ricochet\n",
          stdout);
}

/* --------------------------------------------------------------------- zsh */

#define ZSH_QUOTE "'\\''"
#define ZSH_SPECIAL "[]:\\"

static void zsh_option(const cli_item *item)
{
    printf(" \\\n        '*%s%s[", item->name,
           item->value ? (item->name[1] == '-' ? "=" : "+") : "");
    print_quoted(short_text(item->text), item->text, ZSH_QUOTE, ZSH_SPECIAL);
    putchar(']');
    if (item->value) {
        putchar(':');
        print_quoted((int)strlen(item->value), item->value, ZSH_QUOTE, ZSH_SPECIAL);
        if (item->words) printf(":(%s)", item->words);
        else fputs(cli_takes_file(item) ? ":_files" : ": ", stdout);
    }
    putchar('\'');
}

static void zsh_scope(scope s)
{
    printf("    '%s%s%s')\n        _arguments", s.command->name, s.picture ? " " : "",
           s.picture ? s.picture->name : "");
    for (const cli_item *item = NULL; (item = next(s, item));) zsh_option(item);
    fputs(" \\\n        '--help[show the help]' '*:file:_files' ;;\n", stdout);
}

static void zsh_pictures(const cli_command *command)
{
    printf("    %s)\n        if (( CURRENT == 3 )); then\n            local -a pictures=(",
           command->name);
    for (const cli_item *item = command->items; item->text; item++)
        if (cli_is_picture(item)) {
            printf("\n                '%s:", item->name);
            print_quoted(short_text(item->text), item->text, ZSH_QUOTE, "\\");
            putchar('\'');
        }
    fputs(")\n            _describe picture pictures\n            return\n        fi\n"
          "        scope=\"$scope $words[3]\" depth=2 ;;\n",
          stdout);
}

static void print_zsh(void)
{
    fputs("#compdef ricochet\n# written by `ricochet --completion zsh`\n"
          "_ricochet() {\n"
          "    local scope=$words[2] depth=1\n"
          "    if (( CURRENT == 2 )); then\n"
          "        local -a commands=(",
          stdout);
    for (const cli_command *const *c = cli_commands; *c; c++) {
        printf("\n            '%s:", (*c)->name);
        print_quoted((int)strlen((*c)->summary), (*c)->summary, ZSH_QUOTE, "\\");
        putchar('\'');
    }
    fputs(")\n        _describe command commands\n        _arguments", stdout);
    for (const cli_item *item = cli_program_items; item->text; item++) {
        printf(" '%s[", item->name);
        print_quoted(short_text(item->text), item->text, ZSH_QUOTE, ZSH_SPECIAL);
        fputs("]'", stdout);
    }
    fputs("\n        return\n    fi\n    case $scope in\n", stdout);
    for (const cli_item *item = cli_program_items; item->text; item++)
        if (item->words) printf("    %s) compadd %s; return ;;\n", item->name, item->words);
    for (const cli_command *const *c = cli_commands; *c; c++)
        if (cli_has_pictures(*c)) zsh_pictures(*c);
    fputs("    esac\n    shift $depth words\n    (( CURRENT -= depth ))\n    case $scope in\n",
          stdout);
    visit(zsh_scope);
    fputs("    esac\n}\n"
          "if [[ $zsh_eval_context[-1] == loadautofunc ]]; then _ricochet \"$@\"; else compdef "
          "_ricochet ricochet; fi\n",
          stdout);
}

/* -------------------------------------------------------------------- fish */

#define FISH_QUOTE "\\'"

static void fish_words(const char *condition, const char *name, const char *text)
{
    printf("complete -c ricochet -n '%s' -f -a %s -d '", condition, name);
    print_quoted(short_text(text), text, FISH_QUOTE, "\\");
    fputs("'\n", stdout);
}

static void fish_option(const char *condition, const cli_item *item)
{
    const bool brief = item->name[1] != '-';
    printf("complete -c ricochet -n '%s' -%c %s", condition, brief ? 's' : 'l',
           item->name + (brief ? 1 : 2));
    if (item->value) fputs(cli_takes_file(item) ? " -r -F" : " -x", stdout);
    if (item->words) printf(" -a '%s'", item->words);
    fputs(" -d '", stdout);
    print_quoted(short_text(item->text), item->text, FISH_QUOTE, "\\");
    fputs("'\n", stdout);
}

static void fish_scope(scope s)
{
    char condition[96];
    static const cli_item help = {.name = "--help", .text = "show the help"};
    snprintf(condition, sizeof condition, "__ricochet_in %s %s", s.command->name,
             s.picture ? s.picture->name : "");
    for (const cli_item *item = NULL; (item = next(s, item));) fish_option(condition, item);
    fish_option(condition, &help);
}

static void print_fish(void)
{
    fputs("# fish completion for ricochet, written by `ricochet --completion fish`\n"
          "# Whether the words before the cursor begin with these.\n"
          "function __ricochet_in\n"
          "    set -l before (commandline -opc)[2..-1]\n"
          "    set -l n (count $argv)\n"
          "    test (count $before) -ge $n\n"
          "    and test \"$before[1..$n]\" = \"$argv\"\n"
          "end\n"
          "# Whether exactly these are before it.\n"
          "function __ricochet_at\n"
          "    set -l before (commandline -opc)[2..-1]\n"
          "    test \"$before\" = \"$argv\"\n"
          "end\n",
          stdout);
    for (const cli_item *item = cli_program_items; item->text; item++)
        fish_option("__ricochet_at", item);
    for (const cli_command *const *c = cli_commands; *c; c++) {
        fish_words("__ricochet_at", (*c)->name, (*c)->summary);
        for (const cli_item *item = (*c)->items; item->text; item++)
            if (cli_is_picture(item)) fish_words("__ricochet_at plot", item->name, item->text);
    }
    visit(fish_scope);
}

bool cli_print_completion(const char *shell)
{
    if (!strcmp(shell, "bash")) print_bash();
    else if (!strcmp(shell, "zsh")) print_zsh();
    else if (!strcmp(shell, "fish")) print_fish();
    else return false;
    return true;
}
