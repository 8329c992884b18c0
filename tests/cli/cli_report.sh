#!/bin/bash
# What a report says of branches and departures that could not be followed: which, where, and why.
set -u
. tests/support/tap.sh

sed 's/depth: .*/depth: 1/' examples/elementary/study.yaml >"$folder/study.yaml"
"$ricochet" run "$folder/study.yaml" -o "$folder/a.ricochet" >"$folder/err" 2>&1 || cat "$folder/err"

# change SQL: of one row of the copy, whose digest is made anew; alter SQL: of a fresh copy
change() {
    python3 -S -c 'import sqlite3, sys
db = sqlite3.connect(sys.argv[1])
assert db.execute(sys.argv[2]).rowcount == 1
db.commit()' "$folder/b.ricochet" "$1" && tools/attack/atlas_digest.py "$folder/b.ricochet" >/dev/null
}
alter() { cp "$folder/a.ricochet" "$folder/b.ricochet" && change "$1"; }
one() { python3 -S -c 'import sqlite3, sys; print(*sqlite3.connect(sys.argv[1]).execute(sys.argv[2]).fetchone())' "$folder/a.ricochet" "$1"; }
# said PATTERN...: one row of the report has them all
said() {
    "$ricochet" report "$folder/b.ricochet" >"$folder/rows" || return 1
    cat "$folder/rows"
    for pattern in "$@"; do grep -e "$pattern" "$folder/rows" >"$folder/left"; cp "$folder/left" "$folder/rows"; done
    [ "$(wc -l <"$folder/rows")" = 1 ]
}

read -r branch from to < <(one 'SELECT id, from_junction, to_junction FROM branch WHERE from_junction <> to_junction')
disagree() {
    alter "UPDATE branch SET stop = 'failed', why = 'planted' WHERE id = $branch" || return 1
    said "^ends disagree of branch  *$branch " "from [^ ]* (junction $from, E [0-9]" "to [^ ]* (junction $to, E [0-9]" ': planted$'
}
ok 'a branch whose ends disagree is named with both of them' disagree

read -r loose start < <(one 'SELECT id, from_junction FROM branch WHERE to_junction IS NULL AND from_junction > 0')
beyond() {
    alter "UPDATE branch SET stop = 'failed', why = 'planted' WHERE id = $loose" || return 1
    said "^rest missing of branch  *$loose " 'beyond E [0-9]' "from [^ ]* (junction $start, E [0-9]" ': planted$'
}
ok 'a branch that stops before its end is named with where it stops and where it began' beyond

inexact() {
    alter "UPDATE point SET residual = 2e-12 WHERE branch = $branch AND point = 3" || return 1
    said '^points that miss the accuracy asked for  *1 ' 'the `tolerance` 1e-12$'
}
ok 'an orbit that misses the accuracy that the study asks for is counted' inexact

label=$(one 'SELECT label FROM junction WHERE id = 2')
refused() {
    alter "UPDATE junction SET refused = 3, refusal = 'planted' WHERE id = 2" || return 1
    said '^branches may be missing at junction  *2 ' "$label, E [0-9.]* omega [0-9.]*: 3 refused: planted"
}
ok 'a junction with refused departures is named with its place' refused

reasons() { # that differ in a residual only are one, and residuals stand with the junction
    alter "UPDATE junction SET refused = 3, refusal = 'no orbit (residual 7e-14); no orbit (residual 9e-14); no start: residual 8e-14'
        WHERE id = 2" || return 1
    said '^departures refused  *3  no orbit; no start$' && "$ricochet" report "$folder/b.ricochet" | grep -q 'no orbit (residual 9e-14)'
}
ok 'reasons that differ in a residual only are counted as one' reasons

read -r point < <(one "SELECT id FROM junction WHERE kind = 'extremum'")
undecided() {
    alter "UPDATE junction SET label = label || '?' WHERE id = $point" || return 1
    said '^labels that are not decided  *1 ' 'another step may find such a junction elsewhere or not at all$' &&
        said "^label not decided of junction  *$point " 'C[^ ]*?, E [0-9.]* omega [0-9.]*: its place is known to about 1e-07$' || return 1
    "$ricochet" report "$folder/a.ricochet" | grep 'not decided' && return 1
    return 0
}
ok 'labels that nobody can tell are counted, and listed with their places' undecided

lost() { # an extremum that is none any more, on a point that has no trace any more
    alter "UPDATE junction SET kind = 'multiplication', rotation_p = 1, rotation_q = 3 WHERE id = $point" || return 1
    change "UPDATE point SET trace = NULL, log_trace = NULL, trace_asinh = NULL, rotation = NULL WHERE EXISTS
        (SELECT 1 FROM branch_junction b WHERE b.junction = $point AND b.branch = point.branch AND b.arclength = point.arclength)" || return 1
    said '^multiplications of lost multipliers  *1 ' "(junction $point), E" 'the trace is known there to less than three digits, and its place to no more$'
}
ok 'multiplications at which no trace is stored are counted' lost

aside() {
    alter "UPDATE junction SET energy = energy * (1 + 1e-8) WHERE id = $point" || return 1
    said '^junctions aside of their orbits  *1 ' "(junction $point), E" 'its place is known to about 4e-08$' || return 1
    change "UPDATE junction SET kind = 'branch-point' WHERE id = $point" || return 1
    said '^junctions aside of their orbits  *1 ' "(junction $point), E" 'its place is known to about 4e-08$'
}
ok 'a junction that is not the orbit found on its branch is named with what that leaves of its place' aside

read -r touch < <(one "SELECT j.id FROM junction j JOIN branch b ON b.to_junction = j.id WHERE j.kind = 'grazing'")
still() { # a touch that is a corner
    alter "UPDATE junction SET kind = 'corner', label = 'K1', name = '' WHERE id = $touch" || return 1
    said '^corners without speed  *1 ' "K1 (junction $touch), E" 'gaps go with the square of it: its place is known to about 1.5e-08$' || return 1
    "$ricochet" report "$folder/a.ricochet" | grep 'corners without' && return 1
    return 0
}
ok 'corners at which a contact has no speed are counted, with what is known of their place' still

beside() {
    alter "UPDATE point SET energy = energy * (1 - 1e-6) WHERE branch = $branch AND point = (SELECT points - 1 FROM branch WHERE id = $branch)" || return 1
    said "^last orbit beside the junction of branch  *$branch " "which is 1e-06 of it beside [^ ]* (junction $to)"
}
ok 'a branch whose last orbit lies beside its junction says how far' beside

turns() { # an extremum that is none any more: the energy of its branch turns all the same
    alter "UPDATE junction SET kind = 'user', label = name, a = 0, b = 0 WHERE id = $point" || return 1
    said '^turns without a junction on branch ' "its energy has a l[a-z]* value from [0-9.]* to [0-9.]*, beside E [0-9.]* omega [0-9.]*, that is no extremum"
}
ok 'an energy that turns where no extremum is stored is said' turns
nearby() { # the nearest orbit farther out than the extremum, or not so far
    local on at found=0
    read -r on at < <(one "SELECT p.branch, p.point FROM point p, junction j WHERE j.id = $point
        ORDER BY abs(p.energy / j.energy - 1) + abs(p.frequency / j.frequency - 1) LIMIT 1")
    for part in -1e-6 1e-6; do
        alter "UPDATE point SET energy = energy * (1 + $part) WHERE branch = $on AND point = $at" || return 1
        "$ricochet" report "$folder/b.ricochet" | grep '^turns without a junction on branch ' && found=$((found + 1))
    done
    [ $found = 1 ]
}
ok 'and where a stored orbit is farther out than the extremum beside it' nearby

# Squares of frequencies 2e-7 apart: 16 roundings of a double over that, and on what leaves the modes over what the frequency changes by.
near() {
    cat >"$folder/near.yaml" <<'END'
model:
  mass: [[1, 0], [0, 1]]
  stiffness: [[1.0000001, 0.0000001], [0.0000001, 1.0000001]]
  contacts: [{normal: [1, 0], clearance: 1, sides: both}]
explore: {energy: [0, 3], frequency: [0.5, 3], impacts: 2, depth: 1, multiply: 1}
END
    rm -f "$folder/b.ricochet"
    "$ricochet" run "$folder/near.yaml" -o "$folder/b.ricochet" >"$folder/run" 2>&1 || { cat "$folder/run"; return 1; }
    grep '^places on branches that are known to less than 1e-9 of the energy: 2 ' "$folder/run" &&
        said '^modes of nearly one frequency  *1.776' 'modes 1 and 2 differ by 2e-07 of themselves: .* known to 1.8e-08$' &&
        said '^places known to less on branch ' 'S2+\[01\]: junctions from E 1 to 3 to 3.6e-08 of the energy, as the frequency changes by only 2.8e-08'
}
ok 'modes of nearly one frequency, and what is known to less for them, are said' near

ranges() {
    "$ricochet" report "$folder/b.ricochet" --json | python3 -S -c '
import json, sys
rows = [r for r in json.load(sys.stdin) if r["item"] == "places known to less on branch"]
assert len(rows) == 2
for r in rows:
    for one in r["ranges"]:
        assert one["energy_from"] < one["energy_to"] and 1e-9 < one["known_to"] < 1e-6, one'
}
ok 'programs get them as numbers' ranges

# The third mass swings at a frequency that the second has, too: beside two periods of an orbit of the other two masses that
# take as long. Both branches with mirror points leave where a period takes every deviation to its negative.
along() {
    cat >"$folder/along.yaml" <<'END'
model:
  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
  stiffness: [[3, 0, 0], [0, 2, 0], [0, 0, 2]]
  contacts:
    - {normal: [-1, 1, 0], clearance: 1, sides: upper}
    - {normal: [1, 0, -1], clearance: 900, sides: upper}
explore: {energy: [0, 1000], frequency: [1, 4], impacts: 2, depth: 2, multiply: 2}
END
    rm -f "$folder/b.ricochet"
    "$ricochet" run "$folder/along.yaml" -o "$folder/b.ricochet" >"$folder/run" 2>&1 || { cat "$folder/run"; return 1; }
    said '^a mode goes along on branch  *6 ' 'A2\[00\]: all its orbits have omega 1.41421356, in each of which mode 1 turns 1 time: '
}
ok 'a branch is one of many where a mode goes along that it does not feel' along
along_spring() { # whose word has letters for its openings, too
    sed -e 's/clearance: 1, sides: upper/&, law: bilinear, stiffness: 50/' -e 's/^explore: .*/explore: {energy: [0, 100], frequency: [0.5, 6], impacts: 3, depth: 2, multiply: 3}/' \
        "$folder/along.yaml" >"$folder/spring.yaml"
    rm -f "$folder/b.ricochet"
    "$ricochet" run "$folder/spring.yaml" -o "$folder/b.ricochet" >"$folder/run" 2>&1 || { cat "$folder/run"; return 1; }
    said '^a mode goes along on branch ' 'A3\[000\]: all its orbits have omega 0.707106781, in each of which mode 1 turns 2 times: '
}
ok 'and where that has a spring' along_spring
felt() { # of one frequency, 1/2 of that of the sprung mass, which every impact moves
    "$ricochet" run examples/loose-mass/study.yaml -o "$folder/loose.ricochet" --quiet && cp "$folder/loose.ricochet" "$folder/b.ricochet" &&
        "$ricochet" branches "$folder/b.ricochet" | grep ' 0.5  *0.5 ' && ! said '^a mode goes along'
}
ok 'and not where it feels the mode' felt

# Where nothing of this holds nothing is said.
plain() { ! "$ricochet" report "$folder/a.ricochet" | grep -E 'known to|turns without|beside|nearly one'; }
ok 'of a plain structure none of this is said' plain

ambiguous() {
    alter "UPDATE junction SET name = '$label' WHERE id = 1" || return 1
    said '^names that are labels of other junctions  *[0-9]* ' "$label is junction 1 by name, and the label of junction 2; "
}
ok 'a label that the study gives to another junction as a name is said' ambiguous

# What the program writes has none: a label gives way to a name, and a name that is a label of its family is the label.
one_numbering() {
    "$ricochet" run examples/elementary/study.yaml -o "$folder/e.ricochet" >/dev/null 2>&1 &&
        "$ricochet" junctions "$folder/e.ricochet" --json | python3 -S -c '
import json, re, sys
rows = json.load(sys.stdin)
labels = [r["label"] for r in rows]
named = {r["name"]: r for r in rows if r["name"]}
assert len(set(labels)) == len(labels) and "C4_32" in named
own = [n for n in named if re.fullmatch(r"[CG]\d+_\S+", n)]
assert len(own) > 10 and all(named[n]["label"] == n for n in own), own
assert all(named[r["label"]]["id"] == r["id"] for r in rows if r["label"] in named)'
}
ok 'no label is the name of another junction' one_numbering

# A mass that a cubic spring alone holds: the way from two branch points to the least frequency steps over resonances that
# the way back follows, to another branch.
printf '%s\n' 'model:' '  mass: [[1, 0], [0, 0.05]]' '  stiffness: [[1, 0], [0, 0]]' \
    '  contacts: [{normal: [1, -1], law: power, exponent: 3, stiffness: 1}]' \
    'explore: {energy: [0, 0.1], frequency: [0.12, 5], multiply: 2, depth: 3}' >"$folder/sink.yaml"
astray() {
    "$ricochet" run "$folder/sink.yaml" -o "$folder/sink.ricochet" --quiet && "$ricochet" report "$folder/sink.ricochet" >"$folder/rows" || return 1
    cat "$folder/rows"
    [ "$(grep -c '^branches may be missing at junction .*and from there back it does not pass the junction' "$folder/rows")" = 2 ]
}
ok 'a branch that is not the one its junction lies on is refused there' astray
ok 'and none is stored twice' bash -c '! "$0" branches "$1" --csv | grep "~"' "$ricochet" "$folder/sink.ricochet"
# Two stops that a symmetry exchanges touch at one instant between the contacts with a spring: beyond that only one of
# them is met, on a branch for each, which begins where its mode touches stop and spring together. That both are met for
# good is refused.
printf '%s\n' 'model:' '  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]' '  stiffness: [[7, -1, -1], [-1, 7, -1], [-1, -1, 7]]' '  contacts:' \
    '    - {normal: [1, 0, 0], clearance: 1, sides: upper, law: bilinear, stiffness: 0.5}' \
    '    - {normal: [0, 1, 0], clearance: 1, sides: upper}' '    - {normal: [0, 0, 1], clearance: 1, sides: upper}' \
    'explore: {start: [3], energy: [0, 30], frequency: [1, 6], impacts: 3, multiply: 1, depth: 2}' >"$folder/ring.yaml"
twins() {
    "$ricochet" run "$folder/ring.yaml" -o "$folder/ring.ricochet" --quiet && "$ricochet" verify "$folder/ring.ricochet" --all &&
        "$ricochet" junctions "$folder/ring.ricochet" --json >"$folder/junctions" && "$ricochet" branches "$folder/ring.ricochet" --json >"$folder/branches" &&
        python3 -S -c '
import json, sys
junctions, branches = (json.load(open(name)) for name in sys.argv[1:])
[end] = [j for j in junctions if j["word"] == "0" and abs(j["energy"] - 25.4191596809) < 1e-8]
assert end["kind"] == "grazing" and end["grazings"] == 2 and "close together for a whole branch" in end["refusal"], end
leave = {b["word"]: b for b in branches if end["id"] in (b["from"], b["to"])}
assert set(leave) == {"0", "01", "02"}, leave
for word in ("01", "02"):
    assert abs(leave[word]["energy_min"] - 8) < 1e-9 and leave[word]["stop"] == "junction", leave[word]' "$folder/junctions" "$folder/branches"
}
ok 'of two stops that are touched at one instant one is met alone' twins
finish
