#!/bin/bash
# Tongues: named in every list, stepped over on request, and said where they were.
set -u
. tests/support/tap.sh

two='model:
  mass: [[1, 0], [0, 1]]
  stiffness: [[1, 0], [0, 85.1929]]
  contacts: [{normal: [1, 0.004], clearance: 1}]
explore: {start: [1], energy: [0, 5], frequency: [0.1, 20], impacts: 2, multiply: 1, depth: 1'
printf '%s}\n' "$two" >"$folder/follow.yaml"
printf '%s, tongues: cross}\n' "$two" >"$folder/cross.yaml"
printf '%s, tongues: over}\n' "$two" >"$folder/wrong.yaml"
for name in follow cross; do "$ricochet" run "$folder/$name.yaml" -o "$folder/$name.ricochet" >"$folder/$name.log" 2>&1; done

ok 'a run says that a branch follows a resonance' grep -q 'S2+\[01\] follows 9 : 1 with mode 2 from E ' "$folder/follow.log"
ok 'and which ones it has stepped over' grep -q 'S2+\[01\] .*steps over ' "$folder/cross.log"
says() { "$ricochet" "$1" "$folder/$2.ricochet" "${@:4}" | grep -q "$3"; }
ok 'so does report' says report follow 'internal resonance on branch.*follows 9 : 1 with mode 2'
ok 'so does the list of branches' says branches follow 'follows 9 : 1 with mode 2' --csv
ok 'tongues have a list of their own' says branches follow ',9,1,2,false,0,' --tongues --csv
ok 'in which those that are stepped over are' says branches cross ',9,1,2,true,0,' --tongues --csv
twice() { "$ricochet" branches "$folder/cross.ricochet" --tongues --segments; [ $? = 2 ]; }
ok 'one list at a time' twice

top() { "$ricochet" branches "$folder/$1.ricochet" --json | python3 -c 'import json, sys; print([b["frequency_max"] for b in json.load(sys.stdin) if b["label"] == "S2+[01]"][0])'; }
beyond() { python3 -c 'import sys; a, b = map(float, sys.argv[1:]); assert a < 1.04 and b > 3, (a, b)' "$(top follow)" "$(top cross)"; }
ok 'the backbone goes on behind them' beyond
ok 'every orbit behind them passes' "$ricochet" verify "$folder/cross.ricochet" --all

# The gap is said where somebody asks for what would be in it.
in_gap()
{
    local middle
    middle=$("$ricochet" branches "$folder/cross.ricochet" --tongues --json |
        python3 -c 'import json, sys; t = json.load(sys.stdin)[0]; print((t["frequency_from"] + t["frequency_to"]) / 2)')
    "$ricochet" orbit "$folder/cross.ricochet" --branch 'S2+[01]' --frequency "$middle" 2>"$folder/said"
    grep -q 'has no orbit of frequency .* steps over 9 : 1 with mode 2' "$folder/said"
}
ok 'there is no orbit in a gap, and it says why' in_gap
draws() { "$ricochet" plot fep "$folder/$1.ricochet" -o "$folder/$1.svg" && [ "$(grep -c '9 : 1, mode 2' "$folder/$1.svg")" = "$2" ]; }
ok 'the picture names a resonance that is followed' draws follow 1
ok 'and leaves a gap where none is' draws cross 0

# The same tables again from what is kept, and with workers.
again()
{
    tables "$folder/cross.ricochet" >"$folder/a"
    "$ricochet" branches "$folder/cross.ricochet" --tongues --csv >>"$folder/a"
    rm "$folder/cross.ricochet"
    "$ricochet" run "$folder/cross.yaml" -o "$folder/cross.ricochet" -j 2 >/dev/null 2>&1
    "$ricochet" run "$folder/cross.yaml" -o "$folder/cross.ricochet" >/dev/null 2>&1
    tables "$folder/cross.ricochet" >"$folder/b"
    "$ricochet" branches "$folder/cross.ricochet" --tongues --csv >>"$folder/b"
    cmp "$folder/a" "$folder/b"
}
ok 'the same atlas with two workers, and when it is taken up again' again

# A gap that no branch has is refused, whatever the digest.
planted()
{
    cp "$folder/cross.ricochet" "$folder/planted.ricochet"
    python3 -c 'import sqlite3, sys; a = sqlite3.connect(sys.argv[1]); a.execute("UPDATE meta SET value = ? WHERE key = ?", (sys.argv[2], "gaps")); a.commit()' \
        "$folder/planted.ricochet" "$1"
    python3 tools/attack/atlas_digest.py "$folder/planted.ricochet" >/dev/null
    "$ricochet" branches "$folder/planted.ricochet" 2>"$folder/said"
    [ $? != 0 ] && grep -q 'row gaps' "$folder/said"
}
for line in '9 1 2 9 0' '2 99999 2 9 0' '2 3 7 9 0' '2 3 2 0 0' '2 3 2 400 0' '2 3 2' 'no' '-2 3 2 9 0' '99999999999 1 1 1 1'; do
    ok "no gap: $line" planted "$line
"
done
ok 'it is said what may stand there' bash -c '! "$0" check "$1" 2>"$1.log" && grep -q "neither follow nor cross" "$1.log"' "$ricochet" "$folder/wrong.yaml"
sed 's/^explore: {/&tongues: cross, /' >"$folder/power.yaml" <<'E2'
model: {mass: [[1]], stiffness: [[1]], contacts: [{normal: [1], law: power, exponent: 3, stiffness: 1}]}
explore: {energy: [0, 5]}
E2
ok 'not under a power law' bash -c '! "$0" check "$1" 2>"$1.log" && grep -q "under a power law" "$1.log"' "$ricochet" "$folder/power.yaml"

echo "1..$number"
exit $((failed > 0))
