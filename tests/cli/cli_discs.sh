#!/bin/bash
# Twelve discs, each with a stop, of which a study keeps eight modes: what is said and drawn of many contacts, and of
# modes that are left out, which are no modes that no contact sees.
set -u
. tests/support/tap.sh

python3 -S - >"$folder/discs.yaml" <<'P'
n = 12
row = lambda f: "[" + ", ".join(map(str, f)) + "]"
print("units: {length: mm, force: N}\nmodel:\n  modes: 8")
print("  mass:", row(row(int(i == j) for j in range(n)) for i in range(n)))
print("  stiffness:", row(row(1000 * (2 * (i == j) - (abs(i - j) == 1)) for j in range(n)) for i in range(n)))
print("  contacts:")
for i in range(n):
    print("    - {normal:", row(int(i == j) for j in range(n)) + f", clearance: {0.01 * (1 + 0.1 * i):.4g}" + "}")
print("explore: {start: [1], depth: 1, impacts: 2, multiply: 1, energy: [0, 2000], frequency: [2, 100]}")
P
says() { # PATTERN ARGUMENTS: the program says it, with exit code 0
    local pattern=$1
    shift
    "$ricochet" "$@" >"$folder/said" 2>&1 || { cat "$folder/said"; return 1; }
    grep -q -e "$pattern" "$folder/said" || { cat "$folder/said"; return 1; }
}
ok 'modes that are kept are counted' says '^12 degrees of freedom, 8 modes are kept, 8 of them seen by the stops; 12 contacts' check "$folder/discs.yaml"
ok 'the others are left out' test "$(grep -c '[0-9]  -  *left out$' "$folder/said")" = 4
ok 'and are none that no contact sees' bash -c '! grep "no contact sees" "$0"' "$folder/said"
ok 'what they would have shown of rigid stops is said, once' \
    test "$(grep -c 'the upper half of all modes brings up to 50 % of c.c of contact 1 and of 11 more, which still grows' "$folder/said")" = 1
kept() { "$ricochet" check "$folder/discs.yaml" --json | python3 -S -c 'import json, sys; assert [m["kept"] for m in json.load(sys.stdin)] == 8 * [True] + 4 * [False]'; }
ok 'so do the rows of --json' kept
sed 's/modes: 8/modes: all/' "$folder/discs.yaml" >"$folder/all.yaml"
ok 'where all are kept stops are warned of once, too' says '^warning: the upper half of all modes brings up to 50 % of c.c of contact 1 and of 11 more' check "$folder/all.yaml"

"$ricochet" run "$folder/discs.yaml" >/dev/null 2>&1
says 'and [0-9]* more$' verify "$folder/discs.ricochet" --all
ok 'of numbers that cannot be checked the first are named' grep -q 'not checked: v1, v2, v3, v4, v5, v6 and 6 more$' "$folder/said"
says 54 plot fep "$folder/discs.ricochet" --frequency 2:100 -o "$folder/fep.svg"
ok 'frequencies of locked contacts do not hide the branches' grep -q ' frequencies with a contact locked are not drawn' "$folder/said"
ok 'nor are they in the legend' bash -c '! grep "contact locked" "$0"' "$folder/fep.svg"
"$ricochet" plot model "$folder/discs.yaml" -o "$folder/model.svg" 2>/dev/null
ok 'a schematic has the contacts of the study, not those of the modes that are kept' bash -c '! grep "and 8 more" "$0"' "$folder/model.svg"
ok 'and says what its numbers are in' grep -q 'lengths in mm, stiffness in N/mm, masses in t' "$folder/model.svg"
curves() { "$ricochet" plot law "$folder/discs.yaml" -o "$folder/law.svg" 2>"$folder/said"; [ $? = 2 ] && grep -q 'more than 6 contacts .*; give a study with those that matter' "$folder/said"; }
ok 'more force curves than can be told apart are refused with a way out' curves

if "$ricochet" prove "$folder/discs.ricochet" 2>&1 | grep -q FLINT; then left_out 'points that are not proved' 'built without FLINT'; else
    proved() { "$ricochet" prove "$folder/discs.ricochet" >"$folder/said" 2>&1; [ $? = 1 ] && "$@" "$folder/said"; }
    ok 'points that are not proved for one reason are one line' proved grep -q 'point 1 and [0-9]* more are not proved: 8 modes are seen, and by the decimals of the model it is 12$'
    many() { "$ricochet" prove "$folder/discs.ricochet" --junctions >"$folder/said" 2>&1; [ $? = 1 ] && "$@" "$folder/said"; }
    ok 'so are junctions' many grep -q '^ricochet: junction 1 G1_0,. and [0-9]* more are not proved: '
    ok 'and nothing else of them' test "$(grep -c 'not proved' "$folder/said")" = 1
    ok 'which says what can be done' proved grep -q 'the study keeps 8 of 12 modes, .*`modes: all`'
fi

echo "1..$number"
exit $failed
