#!/usr/bin/env bash
# One table of options: --help, the manual pages and what the parser takes say the same.
set -u
. tests/support/tap.sh

commands=$("$ricochet" --help | awk '/^  [a-z]+  / { print $1 }')
options() { grep -oE '^  -[-a-z]+' | tr -d ' ' | sort -u; } # of a page of help

page="$folder/page.1"
well_formed() { # COMMAND: no warning, and every section
    "$ricochet" --man "$1" >"$page" || return 1
    for section in NAME SYNOPSIS DESCRIPTION OPTIONS 'EXIT STATUS' EXAMPLES 'SEE ALSO'; do
        grep -qx "\.SH $section" "$page" || { echo "no section $section"; return 1; }
    done
    MANWIDTH=80 LC_ALL=C.UTF-8 man --warnings -l "$page" >"$folder/shown" 2>"$folder/warnings" || return 1
    cat "$folder/warnings"
    [ ! -s "$folder/warnings" ] && [ -s "$folder/shown" ]
}
words_of() { tr -s ' \n' '\n' | sed '/^$/d'; }
# every word of the help, in the text of the page: a page that leaves something out fails here
says_the_same() { # COMMAND
    "$ricochet" "$1" --help | sed 's/^\(usage\|example\)://' | words_of | sort -u >"$folder/help"
    MANWIDTH=400 MAN_KEEP_FORMATTING= LC_ALL=C man -l "$page" 2>/dev/null | words_of | sort -u >"$folder/manual"
    comm -23 "$folder/help" "$folder/manual" >"$folder/lost"
    cat "$folder/lost"
    [ ! -s "$folder/lost" ]
}
if command -v man >/dev/null && command -v groff >/dev/null; then
    # Every page is set, and in the short form every third one is compared word by word, which sets it again.
    turn=0
    for command in ricochet $commands; do
        turn=$((turn + 1))
        ok "ricochet --man $command: man has no warning" well_formed "$command"
        [ "$command" = ricochet ] || [ $((turn % $(every_of 3))) != 0 ] || ok "$command: the page says what --help says" says_the_same "$command"
    done
else
    left_out 'manual pages' 'man or groff is missing (Debian: man-db, groff)'
fi

# usage and table: the options of the one are those of the other, with the same values
usage_is_table() { # COMMAND
    python3 -S - "$("$ricochet" "$1" --help)" <<'PY'
import re, sys
usage, _, rest = sys.argv[1].partition("\n\n")
option = r"(--?[a-z][a-z-]*)(?: ([^\s\]|)-][^\]|)\n]*?|\[K:\]SEGMENT))?(?=[\]|)\s]|\.\.\.|$)"
told = {m[1] for m in re.finditer(r"(?<![\w-])" + option, usage)} - {"-"}
table = {m[1] for m in re.finditer(r"^  (--?[a-z][a-z-]*)", rest, re.M)}
values = {m[1]: m[2] for m in re.finditer(r"^  (--?[a-z][a-z-]*) (\S+)(?:  |$)", rest, re.M)}
for name, value in values.items():
    if not re.search(re.escape(name) + " (\\[K:\\])?" + re.escape(value), usage):
        print(name, value, "is not in the usage")
        sys.exit(1)
print("usage only:", told - table, "table only:", table - told)
sys.exit(told != table)
PY
}
# what the table has is taken out by the command: what is missing then is something else
taken() { # COMMAND [PICTURE]
    local option
    for option in $("$ricochet" $1 --help | awk -v picture="${2:-}" '
        picture == "" || /^[a-z]/ { here = picture == "" || $1 == picture || $1 == "all" }
        here' | options); do
        [ "${2:+$option}" != -o ] || continue # given below, or no picture is tried
        # an option with a value is taken with it, a flag without
        "$ricochet" "$@" ${2:+-o x.svg} "$option=1" >"$folder/out" 2>&1
        ! grep -q "option '$option=1' takes no value" "$folder/out" || "$ricochet" "$@" ${2:+-o x.svg} "$option" >"$folder/out" 2>&1
        if grep -E "option '$option(=1)?' is (unknown|given twice)" "$folder/out"; then return 1; fi
    done
}
unknown() { # COMMAND [PICTURE]
    "$ricochet" "$@" --nothing x.svg 2>"$folder/out"
    [ $? = 2 ] && grep -q "option '--nothing' is unknown" "$folder/out"
}
for command in $commands; do
    ok "$command: usage and table agree" usage_is_table "$command"
    if [ "$command" = plot ]; then
        for picture in fep orbit orbits curves floquet cascade sheet strobe section; do
            ok "plot $picture takes the options of its table" taken plot "$picture"
            ok "plot $picture refuses others" unknown plot "$picture"
        done
    else
        ok "$command takes the options of its table" taken "$command"
        ok "$command refuses others" unknown "$command"
    fi
done
no_value() { "$ricochet" branches a.ricochet --json=yes 2>&1 | grep -q "option '--json=yes' takes no value"; }
ok 'a flag takes no value' no_value
of_another() { "$ricochet" plot fep a.ricochet --histories -o a.svg 2>&1 | grep -q "'--histories' is unknown to plot fep"; }
ok 'a picture refuses the options of another' of_another
no_page() { "$ricochet" --man nothing 2>"$folder/out"; [ $? = 2 ] && grep -q 'unknown command' "$folder/out"; }
ok 'a page of nothing' no_page
finish
