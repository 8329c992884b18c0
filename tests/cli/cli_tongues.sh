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
ok 'and how to see its backbone' grep -q 'leaves its backbone: .*tongues: cross' "$folder/follow.log"
ok 'which is no advice where that was done' bash -c '! grep -q "leaves its backbone" "$0"' "$folder/cross.log"
ok 'and which ones it has stepped over' grep -q 'S2+\[01\] .*steps over ' "$folder/cross.log"
says() { "$ricochet" "$1" "$folder/$2.ricochet" "${@:4}" | grep -q "$3"; }
ok 'so does report' says report follow 'internal resonance on branch.*follows 9 : 1 with mode 2'
ok 'so does the list of branches' says branches follow 'follows 9 : 1 with mode 2' --csv
ok 'tongues have a list of their own' says branches follow ',9,1,2,false,0,' --tongues --csv
ok 'in which those that are stepped over are' says branches cross ',9,1,2,true,0,' --tongues --csv
twice() { "$ricochet" branches "$folder/cross.ricochet" --tongues --segments; [ $? = 2 ]; }
ok 'one list at a time' twice

top() { "$ricochet" branches "$folder/$1.ricochet" --json | python3 -S -c 'import json, sys; print([b["frequency_max"] for b in json.load(sys.stdin) if b["label"] == "S2+[01]"][0])'; }
beyond() { python3 -S -c 'import sys; a, b = map(float, sys.argv[1:]); assert a < 1.04 and b > 3, (a, b)' "$(top follow)" "$(top cross)"; }
ok 'the backbone goes on behind them' beyond
ok 'every orbit behind them passes' "$ricochet" verify "$folder/cross.ricochet" --all

# The gap is said where somebody asks for what would be in it.
in_gap()
{
    local middle
    middle=$("$ricochet" branches "$folder/cross.ricochet" --tongues --json |
        python3 -S -c 'import json, sys; t = json.load(sys.stdin)[0]; print((t["frequency_from"] + t["frequency_to"]) / 2)')
    "$ricochet" orbit "$folder/cross.ricochet" --branch 'S2+[01]' --frequency "$middle" 2>"$folder/said"
    grep -q 'has no orbit of frequency .* steps over 9 : 1 with mode 2' "$folder/said"
}
ok 'there is no orbit in a gap, and it says why' in_gap
cat >"$folder/four.yaml" <<'E1'
model:
  mass: [[1, 0, 0, 0], [0, 1.25, 0, 0], [0, 0, 1.5, 0], [0, 0, 0, 0.75]]
  stiffness: [[5.75, -1, 0, 0], [-1, 8.25, -7.25, 0], [0, -7.25, 13.5, -6.25], [0, 0, -6.25, 6.25]]
  contacts: [{normal: [0, 0, 0, 1], law: bilinear, clearance: 1.246, sides: upper, stiffness: 107.2}]
explore: {start: [1], impacts: 1, multiply: 1, depth: 1, tongues: cross}
E1
"$ricochet" run "$folder/four.yaml" -o "$folder/four.ricochet" --quiet
partly() { # E 0.361 is passed before and behind the gap from 0.3686 to 0.3538, and in it
    "$ricochet" orbit "$folder/four.ricochet" --branch 'A1(1)[0]' --energy 0.361 --json 2>"$folder/said" | grep -q '"word"' &&
        grep -q 'may be missing: .* steps over 5 : 1 with mode 2' "$folder/said"
}
ok 'where there are some elsewhere, it says what may be missing' partly
whole() { ! "$ricochet" orbit "$folder/four.ricochet" --branch 'A1(1)[0]' --energy 0.5 --json 2>&1 >/dev/null | grep .; }
ok 'and nothing where there is no gap' whole

# Ends and extrema of a branch are its orbits, also in units in which the last digit comes out otherwise.
ends()
{
    local unit
    for unit in '' --physical --hz; do
        "$ricochet" branches "$folder/four.ricochet" --json $unit | python3 -S -c '
import json, sys
for b in json.load(sys.stdin):
    for what in ("energy_min", "energy_max", "frequency_min", "frequency_max"):
        if b[what] > 0: print(b["id"], what[:-4], repr(b[what]))' >"$folder/ends"
        [ "$(wc -l <"$folder/ends")" = 7 ] || return
        while read -r id what value; do
            "$ricochet" orbit "$folder/four.ricochet" --branch "$id" --"$what" "$value" $unit --csv || return
        done <"$folder/ends"
    done
}
ok 'the least and largest energies and frequencies of a branch have orbits in every unit' ends
draws() { "$ricochet" plot fep "$folder/$1.ricochet" -o "$folder/$1.svg" && [ "$(grep -c '9 : 1, mode 2' "$folder/$1.svg")" = "$2" ]; }
ok 'the picture names a resonance that is followed' draws follow 1
ok 'and leaves a gap where none is' draws cross 0

# Right behind the first touch, where the spring hardly acts, nothing tells how large the mode will be: it is tried again.
cat >"$folder/near.yaml" <<'E1'
model:
  mass: [[1, 0], [0, 1]]
  stiffness: [[1, 0], [0, 49.021]]
  contacts: [{normal: [1, 0.004], clearance: 1, sides: upper, law: bilinear, stiffness: 40}]
explore: {start: [1], energy: [0, 50], frequency: [0.1, 20], impacts: 2, multiply: 1, depth: 1, tongues: cross}
E1
"$ricochet" run "$folder/near.yaml" -o "$folder/near.ricochet" >"$folder/near.log" 2>&1
far() { "$ricochet" branches "$folder/near.ricochet" --json | python3 -S -c 'import json, sys; sys.exit(max(b["frequency_max"] for b in json.load(sys.stdin)) < 1.6)'; }
ok 'a resonance 0.0002 behind the first touch is stepped over' far
ok 'as are the ones that follow' grep -q 'steps over 7 : 1 .*steps over 6 : 1 .*steps over 5 : 1 ' "$folder/near.log"
ok 'and every orbit passes' "$ricochet" verify "$folder/near.ricochet" --all

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
    plant "$folder/cross.ricochet" "$folder/planted.ricochet" "db.execute('UPDATE meta SET value = ? WHERE key = ?', ('''$1''', 'gaps'))"
    "$ricochet" branches "$folder/planted.ricochet" 2>"$folder/said"
    [ $? != 0 ] && grep -q 'row gaps' "$folder/said"
}
for line in '9 1 2 9 0' '2 99999 2 9 0' '2 3 7 9 0' '2 3 2 0 0' '2 3 2 400 0' '2 3 2' 'no' '-2 3 2 9 0' '99999999999 1 1 1 1'; do
    ok "no gap: $line" planted "$line
"
done
# While a spring is closed a mode turns otherwise: each contact of a branch may take or give a turn. Gears with ten contacts
# a period had tongues of 49 turns in the time of 46, and their atlas was refused.
shifted()
{
    plant "$folder/near.ricochet" "$folder/planted.ricochet" "
(text,) = db.execute('SELECT value FROM meta WHERE key = ?', ('gaps',)).fetchone()
branch, point, mode, turns, others = map(int, text.split()[:5])
(impacts,) = db.execute('SELECT impacts FROM branch WHERE id = ?', (branch,)).fetchone()
db.execute('UPDATE meta SET value = ? WHERE key = ?', (f'{branch} {point} {mode} {turns + $1 * impacts} {others}\\n', 'gaps'))"
    "$ricochet" branches "$folder/planted.ricochet" >"$folder/said" 2>&1
}
ok 'a turn more for every contact' shifted 1
three() { ! shifted 3; }
ok 'but not three' three
ok 'it is said what may stand there' bash -c '! "$0" check "$1" 2>"$1.log" && grep -q "neither follow nor cross" "$1.log"' "$ricochet" "$folder/wrong.yaml"
sed 's/^explore: {/&tongues: cross, /' >"$folder/power.yaml" <<'E2'
model: {mass: [[1]], stiffness: [[1]], contacts: [{normal: [1], law: power, exponent: 3, stiffness: 1}]}
explore: {energy: [0, 5]}
E2
ok 'not under a power law' bash -c '! "$0" check "$1" 2>"$1.log" && grep -q "under a power law" "$1.log"' "$ricochet" "$folder/power.yaml"

# The arm with some of its modes: the backbones are one, but for their tongues.
arm() # MODES: the curve, "omega E gap" per point, in $folder/arm-MODES
{
    mkdir -p "$folder/arm"
    cp examples/arm/*.mtx "$folder/arm"
    sed "s/^model:/model:\n  modes: $1/" examples/arm/study.yaml >"$folder/arm/arm-$1.yaml"
    "$ricochet" run "$folder/arm/arm-$1.yaml" -o "$folder/arm-$1.ricochet" >"$folder/arm-$1.log" 2>&1 || return 1
    "$ricochet" verify "$folder/arm-$1.ricochet" >/dev/null || return 1
    "$ricochet" points "$folder/arm-$1.ricochet" --branch 2 --json >"$folder/arm-$1.json"
    "$ricochet" branches "$folder/arm-$1.ricochet" --tongues --json >"$folder/arm-$1.tongues"
}
agree()
{
    python3 -S - "$folder" "$@" <<'P'
import json, sys
folder, curves = sys.argv[1], {}
for modes in sys.argv[2:]:
    points = json.load(open(f"{folder}/arm-{modes}.json"))
    gaps = {t["first_point"] for t in json.load(open(f"{folder}/arm-{modes}.tongues")) if t["crossed"]}
    curves[modes] = [(p["frequency"], p["energy"], q["frequency"], q["energy"]) for i, (p, q) in enumerate(zip(points, points[1:])) if i not in gaps]
    assert points[0]["frequency"] < 460.3 and points[-1]["frequency"] > 638, (modes, points[-1])
    assert bool(gaps) == (modes != "1"), gaps
def energy(modes, omega):
    for a, e, b, f in curves[modes]:
        if a <= omega < b:
            return e + (omega - a) / (b - a) * (f - e)
seen = 0
for omega in [462 + 5.5 * k for k in range(32)]:
    values = [v for v in (energy(modes, omega) for modes in sys.argv[2:]) if v]
    seen += len(values) == len(sys.argv) - 2
    assert max(values) < 1.01 * min(values), (omega, values)
assert seen > 20, seen
P
}
for modes in 1 2 4; do ok "the arm with $modes of its modes" arm $modes; done
ok 'their backbones agree away from the tongues' agree 1 2 4
said() { grep -q "$2" "$folder/arm-$1.log"; }
ok 'what is left out is said' said 2 'arm-2.yaml: 2 of 10 modes are kept, up to 8796.4 rad/s; contact 1: c.c is 12.1749 of 12.4576'
ok 'and what becomes of the spring' said 1 'its stiffness 20000 becomes 19998.2 with the static compliance of the rest'
up_to()
{
    sed 's/^model:/model:\n  modes: {up_to: 9000}/' examples/arm/study.yaml >"$folder/arm/up.yaml"
    diff <("$ricochet" check "$folder/arm/up.yaml" --json) <("$ricochet" check "$folder/arm/arm-2.yaml" --json)
}
ok 'as many modes as there are up to a frequency' up_to
refuses() # VALUE TEXT
{
    sed "s/^model:/model:\n  modes: $1/" examples/arm/study.yaml >"$folder/arm/no.yaml"
    "$ricochet" check "$folder/arm/no.yaml" 2>"$folder/said"
    [ $? = 2 ] && grep -q "no.yaml:[0-9]*: model.modes.*$2" "$folder/said"
}
ok 'no modes' refuses 0 'the structure has modes 1 to 10'
ok 'more than there are' refuses 11 'the structure has modes 1 to 10'
ok 'half a mode' refuses 2.5 'the structure has modes 1 to 10'
ok 'none up to there' refuses '{up_to: 100}' 'no mode has a frequency up to 100'
ok 'a list' refuses '[1, 2]' 'expected a number, found a list'
rigid()
{
    sed 's/law: bilinear/law: rigid/; /stiffness: 2.0/d; s/^model:/model:\n  modes: 3/' examples/arm/study.yaml >"$folder/arm/rigid.yaml"
    "$ricochet" check "$folder/arm/rigid.yaml" | grep 'is left out: behind it a rigid stop would be a spring'
}
ok 'a rigid stop stays one, and that is said' rigid

# Where the structure is.
drawing() # TEXT REFUSAL
{
    printf 'model: {mass: [[1]], stiffness: [[1]], contacts: [{normal: [1], clearance: 1}]}\ndrawing: %s\n' "$1" >"$folder/drawing.yaml"
    "$ricochet" check "$folder/drawing.yaml" >/dev/null 2>"$folder/said"
    [ $? = "$([ -z "$2" ] && echo 0 || echo 2)" ] && grep -q "$2" "$folder/said" || [ -z "$2$(cat "$folder/said")" ]
}
ok 'a drawing' drawing '{nodes: [{at: [0, 0]}, {at: [1, 0.5], moves: [0, 1]}], lines: [[1, 2]]}' ''
ok 'without a node' drawing '{lines: [[1, 2]]}' 'drawing.nodes: missing'
ok 'a displacement that there is not' drawing '{nodes: [{at: [0], moves: [2]}]}' 'drawing.nodes\[1\].moves: 2 is no displacement'
ok 'more directions than coordinates' drawing '{nodes: [{at: [0], moves: [1, 1]}]}' '2 directions, but the node lies in 1'
ok 'a line to nowhere' drawing '{nodes: [{at: [0]}], lines: [[1, 2]]}' 'drawing.lines\[1\]: a line joins two nodes'
kept()
{
    "$ricochet" run "$folder/arm/arm-1.yaml" -o "$folder/kept.ricochet" >/dev/null 2>&1
    python3 -S -c 'import sqlite3, sys; print(sqlite3.connect(sys.argv[1]).execute("SELECT value FROM meta WHERE key = ?", ("study",)).fetchone()[0])' \
        "$folder/kept.ricochet" >"$folder/arm/kept.yaml"
    grep -q 'moves: \[0, 9, 0\]' "$folder/arm/kept.yaml" && grep -q '^    - \[5, 6\]' "$folder/arm/kept.yaml" && grep -q '^  modes: 1$' "$folder/arm/kept.yaml" || return 1
    "$ricochet" run "$folder/arm/kept.yaml" -o "$folder/kept.ricochet"
}
ok 'the atlas has it, and the modes; its study is the same one' kept

# The arm of a drone: the backbones of one, two, four modes and, in the long form, all ten agree away from the tongues that they step over.
arm()
{
    local modes=(1 2 4) n
    long_form && modes+=(10)
    for n in "${modes[@]}"; do
        sed "s#^  contacts:#  modes: $n\n  contacts:#; s#file: #file: $PWD/examples/arm/#" examples/arm/study.yaml >"$folder/arm$n.yaml"
        "$ricochet" run "$folder/arm$n.yaml" -o "$folder/arm$n.ricochet" --quiet || return 1
        "$ricochet" points "$folder/arm$n.ricochet" --branch 'S2(1)[01]' --json >"$folder/arm$n.json" 2>/dev/null ||
            "$ricochet" points "$folder/arm$n.ricochet" --branch 'S2[01]' --json >"$folder/arm$n.json" || return 1
        "$ricochet" branches "$folder/arm$n.ricochet" --tongues --json >"$folder/tongues$n.json"
    done
    python3 -S - "$folder" "${modes[@]}" <<'P'
import json, math, sys
folder, modes = sys.argv[1], sys.argv[2:]
curve = {n: [(p["energy"], p["frequency"]) for p in json.load(open(f"{folder}/arm{n}.json"))] for n in modes}
def at(n, energy):
    for a, b in zip(curve[n], curve[n][1:]):
        if a[0] <= energy <= b[0]:
            return a[1] * (b[1] / a[1]) ** (math.log(energy / a[0]) / math.log(b[0] / a[0]))
    raise AssertionError((n, energy))
for n in modes:
    tongues = json.load(open(f"{folder}/tongues{n}.json"))
    assert abs(curve[n][0][1] - 460.288) < 0.01 and abs(max(p[1] for p in curve[n]) - 638.589) < 0.01, n
    assert all(t["crossed"] and t["of_mode"] > 1 for t in tongues) and (len(tongues) > 0) == (n != "1"), (n, len(tongues))
worst = max(abs(at(n, energy) / at(modes[-1], energy) - 1) for n in modes for energy in (9500, 1e4, 1.2e4, 2e4, 5e4, 1e5, 3e5, 8e5))
print(f"# modes {', '.join(modes)}: frequencies at eight energies agree to {worst:.1e}")
assert worst < 1e-4
P
}
ok 'the backbones of an arm agree, whatever the number of modes' arm

echo "1..$number"
exit $((failed > 0))
