#!/usr/bin/env bash
# Help, the glossary, what is meant by a slip of the finger, and one exit code for one kind of mistake.
set -u
. tests/support/tap.sh

said() { # CODE PATTERN ARGUMENT...
    local code=$1 pattern=$2 got=0
    shift 2
    "$ricochet" "$@" >"$folder/said" 2>&1 || got=$?
    cat "$folder/said"
    [ "$got" = "$code" ] && grep -q -e "$pattern" "$folder/said"
}
same_text() { diff <("$ricochet" help "$1") <("$ricochet" "$1" --help); }

ok 'help lists the commands' said 0 '^  branches ' help
ok 'help of a command' same_text run
ok 'help of a picture' said 0 '^usage: ricochet plot fep ATLAS' help plot fep
lacks() { ! grep -q -e "$1" "$folder/said"; }
ok 'and of no other' lacks '--circle\|ricochet plot strobe'
ok 'the same behind the picture' diff "$folder/said" <("$ricochet" plot fep --help)
ok 'a picture that is none' said 2 "plot has no picture 'fop'" help plot fop
ok 'a picture of a command without' said 2 "'fep' is one argument too many" help run fep
ok 'help of a word' said 0 '^departure  *a branch that may leave' help departure
ok 'help of several words' said 0 '^branch point ' help 'branch point'
ok 'help of nothing known' said 2 "did you mean 'junctions'" help juntcions
ok '-V' said 0 '^ricochet [0-9]' -V
ok 'a command' said 2 "did you mean 'check'" chekc
ok 'an option' said 2 "did you mean '--branch'" points x --brnch 3
ok 'an option as other programs have it' said 2 "option '--output' is unknown; it is '-o' here" run x --output y
ok 'and a form of a table' said 2 "it is '--csv' here" branches x --format csv
ok 'the beginning of an option' said 2 "did you mean '--physical'" branches x --phys
ok 'an option like none' said 2 "see ricochet run --help" run --zzzzzzzz
ok 'a study that is missing' said 2 'No such file' check "$folder/none.yaml"
for command in branches junctions report verify; do
    ok "$command: an atlas that is missing" said 2 'no such file' "$command" "$folder/none.ricochet"
done

ok 'the glossary is in the documents' diff \
    <("$ricochet" help glossary | sed -E 's/^ +/ /; s/^([^ ]+( [^ ]+)?)  +/\n| \1 | /' | tr -d '\n' | sed 's/| [a-z ]* | /\n&/g' | grep '|' | tr -s ' ') \
    <(sed -n '/^|---/,$p' docs/glossary.md | grep -v '^|--' | sed 's/ |$//')
ok 'one table of exit codes' diff <("$ricochet" --help | sed -n '/^Exit codes/,$s/^ *\([0-9]*\) *\([a-z].*\)/\1 \2/p') \
    <(sed -n '/^| exit code/,/^$/s/^| \([0-9]*\) | \(.*\) |$/\1 \2/p' docs/commands.md)
finish
