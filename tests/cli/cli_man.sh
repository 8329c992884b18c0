#!/usr/bin/env bash
# One table of options: --help, the manual pages and what the parser takes say the same.
set -u
. tests/support/tap.sh

commands=$("$ricochet" --help | awk '/^  [a-z]+  / { print $1 }')
well_formed() { # COMMAND: has every section
    "$ricochet" --man "$1" >"$folder/$1.1" || return 1
    for section in NAME SYNOPSIS DESCRIPTION OPTIONS 'EXIT STATUS' EXAMPLES 'SEE ALSO'; do
        case $(<"$folder/$1.1") in *$'\n'".SH $section"$'\n'*) ;; *) echo "no section $section"; return 1 ;; esac
    done
}
for command in ricochet $commands; do
    ok "ricochet --man $command: every section" well_formed "$command"
done
shown() { # PAGE: by man itself, without a warning
    MANWIDTH=80 LC_ALL=C.UTF-8 man --warnings -l "$folder/$1.1" >"$folder/shown" 2>"$folder/warnings" || return 1
    cat "$folder/warnings"
    [ ! -s "$folder/warnings" ] && [ -s "$folder/shown" ]
}
groff=
if command -v man >/dev/null && command -v groff >/dev/null; then
    groff=groff
    ok 'man shows the page of the program, and has no warning' shown ricochet
    ok 'and that of a command' shown plot
else
    left_out 'manual pages' 'man or groff is missing (Debian: man-db, groff)'
fi

# Pages as groff sets them, usage and table, and what the parser takes: of every command and picture, in one process.
python3 -S tests/support/options.py "$ricochet" "$folder" $groff >"$folder/claims"
ok 'all commands and pictures were asked' test $? = 0 -a "$(grep -c 'refuses others' "$folder/claims")" -ge $(($(wc -w <<<"$commands") + 8))
claims "$folder/claims"
no_value() { "$ricochet" branches a.ricochet --json=yes 2>&1 | grep -q "option '--json=yes' takes no value"; }
ok 'a flag takes no value' no_value
of_another() { "$ricochet" plot fep a.ricochet --histories -o a.svg 2>&1 | grep -q "'--histories' is unknown to plot fep"; }
ok 'a picture refuses the options of another' of_another
no_page() { "$ricochet" --man nothing 2>"$folder/out"; [ $? = 2 ] && grep -q 'unknown command' "$folder/out"; }
ok 'a page of nothing' no_page
finish
