#!/usr/bin/env bash
# Sections from outside: rows and their columns, wrong calls, limits and Ctrl-C, workers, orbits of an atlas.
set -u
. tests/support/tap.sh

cat >"$folder/study.yaml" <<YAML
title: Two masses
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {normal: [-1, 1], clearance: 2.0, law: rigid}
explore: {energy: [0, 40], frequency: [0.2, 10], impacts: 4, multiply: 2, depth: 1}
YAML
sed 's/^model:/model:\n  restitution: 0.9/' "$folder/study.yaml" >"$folder/lossy.yaml"
atlas=$folder/atlas.ricochet

section() { "$ricochet" section "$@"; }
refused() { refusal section "$@"; } # CODE PATTERN ARGUMENTS...
ok "no energy" refused 2 "energy is missing" "$folder/study.yaml"
ok "a negative energy" refused 2 "not positive" "$folder/study.yaml" --energy -1
ok "an energy that is no number" refused 2 "energy" "$folder/study.yaml" --energy five
ok "an energy that is not finite" refused 2 "energy" "$folder/study.yaml" --energy inf
ok "below all stops" refused 2 "least energy that does is 0.5" "$folder/study.yaml" --energy 0.4
ok "no starts" refused 2 "whole number" "$folder/study.yaml" --energy 1 --starts 0
ok "no impacts" refused 2 "whole number" "$folder/study.yaml" --energy 1 --impacts 0
ok "more than there is memory for" refused 2 "exponents only" "$folder/study.yaml" --energy 1 --starts 1000000 --impacts 1000000
ok "orbits of a study" refused 2 "of an atlas" "$folder/study.yaml" --energy 1 --orbits
ok "a radius about nothing" refused 2 "about orbits" "$folder/study.yaml" --energy 1 --radius 0.1
ok "starts about no radius" refused 2 "give --radius R too" "$folder/study.yaml" --energy 1 --branch 1 --starts 2
ok "losses" refused 2 "restitution" "$folder/lossy.yaml" --energy 5
ok "no such file" refused 2 "No such file" "$folder/none.yaml" --energy 5
ok "both formats" refused 2 "csv" "$folder/study.yaml" --energy 5 --json --csv
ok "an unknown option" refused 2 "start" "$folder/study.yaml" --energy 5 --start 3

ok "an atlas" "$ricochet" run "$folder/study.yaml" -o "$atlas"
ok "a branch without an orbit of this energy" refused 1 "no orbit of energy 500" "$atlas" --energy 500 --branch 3
ok "an atlas without one" refused 1 "no orbit of energy 500" "$atlas" --energy 500 --orbits

rows() { tail -n +2 | wc -l; }
section "$folder/study.yaml" --energy 5 --starts 6 --impacts 500 --csv >"$folder/one.csv" 2>"$folder/told"
ok "the columns" grep -qx "start,impact,time,face,x1,x2,v1,v2,rotation,lyapunov,lyapunov_error" "$folder/one.csv"
ok "a row per impact" test "$(rows <"$folder/one.csv")" = 3000
ok "what came of it is said" grep -q "6 starts, 3000 impacts at energy 5" "$folder/told"
section "$folder/study.yaml" --energy 5 --starts 6 --impacts 500 --csv -j 3 >"$folder/three.csv" 2>/dev/null
ok "workers change no bit" same "$folder/one.csv" "$folder/three.csv"
section "$atlas" --energy 5 --starts 6 --impacts 500 --csv >"$folder/atlas.csv" 2>/dev/null
ok "an atlas is its study" same "$folder/one.csv" "$folder/atlas.csv"
section "$folder/study.yaml" --energy 20 --starts 6 --impacts 500 --csv --physical >"$folder/physical.csv" 2>/dev/null
doubled() { # physical lengths are twice the scaled ones
    python3 -S - "$folder/one.csv" "$folder/physical.csv" <<'END'
import csv, sys
one, two = ([list(map(float, (x or "nan" for x in row))) for row in list(csv.reader(open(f)))[1:]] for f in sys.argv[1:])
assert all(2 * u == v for a, b in zip(one, two) for u, v in zip(a[4:8], b[4:8]))
END
}
ok "physical units" doubled

json() # the same numbers as CSV has, of the kinds that they are
{
    section "$folder/study.yaml" --energy 5 --starts 6 --impacts 500 --json 2>/dev/null >"$folder/one.json"
    python3 -S - "$folder/one.csv" "$folder/one.json" <<'END'
import csv, json, sys
rows = json.load(open(sys.argv[2]))
table = list(csv.DictReader(open(sys.argv[1])))
assert len(rows) == len(table) == 3000 and list(rows[0]) == list(table[0])
for row, cells in zip(rows, table):
    assert all((float(cells[k]) if cells[k] else None) == v for k, v in row.items())
    assert type(row["face"]) is type(row["impact"]) is int and type(row["time"]) is type(row["x1"]) is float
END
}
ok "JSON" json

returns() # every orbit of the atlas is back after its impacts, to what its multiplier leaves
{
    section "$atlas" --energy 5 --orbits --impacts 40 --json 2>/dev/null >"$folder/orbits.json"
    python3 -S - "$folder/orbits.json" <<'END'
import json, sys
starts = {}
for row in json.load(open(sys.argv[1])):
    starts.setdefault(row["start"], []).append(row)
assert len(starts) >= 3
for rows in starts.values():
    first = rows[0]
    best = min(max(abs(row[k] - first[k]) for k in ("x1", "x2", "v1", "v2")) for row in rows[1:9])
    assert best < 1e-10, best
END
}
ok "orbits of the atlas return" returns
ok "about an orbit" test "$(section "$atlas" --energy 5 --at 5,1.6 --radius 0.05 --starts 7 --exponents --csv 2>/dev/null | rows)" = 7
ok "at a place" section "$atlas" --energy 5 --at 5,1.6 --exponents

plots() # FILE ARGUMENTS...
{
    local out=$1
    shift
    "$ricochet" plot section "$@" -o "$out" && whole "$out"
}
ok "a picture of an atlas" plots "$folder/section.svg" "$atlas" --energy 5 --starts 12 --impacts 200
curves "$folder/section.svg" >"$folder/curves"
ok "has regular and chaotic motions" test "$(grep -c '^shade' "$folder/curves")" -ge 3
marked() { [ "$(grep -c "polygon\|<path stroke='rgb( 34" "$1")" -gt 0 ] && grep -q 'elliptic orbit' "$1" && grep -q 'hyperbolic orbit' "$1"; }
ok "and orbits of both kinds" marked "$folder/section.svg"
ok "every impact of the face or its image is a dot" test "$(awk '/shade/ { n += $NF } END { print n }' "$folder/curves")" -ge 2400
ok "the same again" plots "$folder/again.svg" "$atlas" --energy 5 --starts 12 --impacts 200 -j 2
ok "bit for bit" same "$folder/section.svg" "$folder/again.svg"
ok "of a study, by rotation" plots "$folder/rotation.png" "$folder/study.yaml" --energy 5 --starts 8 --impacts 100 --colour rotation
ok "a part of it" plots "$folder/part.pdf" "$atlas" --energy 5 --at 5,1.6 --radius 0.05 --impacts 100 --window 0:0.5,-0.3:0.3
undrawn() # CODE PATTERN ARGUMENTS...
{
    local code=$1 pattern=$2 got=0
    shift 2
    "$ricochet" plot section "$@" -o "$folder/none.svg" >"$folder/out" 2>"$folder/err" || got=$?
    cat "$folder/err"
    [ "$got" = "$code" ] && grep -q -e "$pattern" "$folder/err" && [ ! -e "$folder/none.svg" ]
}
ok "no picture without an energy" undrawn 2 "energy is missing" "$folder/study.yaml"
ok "no face that is not there" undrawn 1 "no impact on face 7" "$folder/study.yaml" --energy 5 --face 7
ok "no colour by another name" undrawn 2 "lyapunov and rotation" "$folder/study.yaml" --energy 5 --colour speed
ok "no picture of an empty window" undrawn 1 "nothing to draw" "$folder/study.yaml" --energy 5 --window 2:3,2:3
ok "no picture of one mode" undrawn 1 "single mode" examples/free-pair/study.yaml --energy 5

# Soft modes bent against each other: the force along the face is as large as the energy over the gap.
cat >"$folder/bent.yaml" <<'END'
model:
  mass: [[1.5, -0.0625, 0.125], [-0.0625, 2.203125, 0.140625], [0.125, 0.140625, 1.40625]]
  stiffness: [[931250, 237500, 181250], [237500, 781250, -162500], [181250, -162500, 206250]]
  contacts: [{normal: [-1, 0, 1], law: bilinear, clearance: 0.02705, sides: lower, stiffness: 7700000}]
explore: {impacts: 1, multiply: 1, depth: 1}
END
"$ricochet" run "$folder/bent.yaml" -o "$folder/bent.ricochet" --quiet
on_the_face() {
    "$ricochet" section "$folder/bent.ricochet" --branch 'A1(1)[0]' --energy 37324.488 --impacts 200 --json | python3 -S -c '
import json, sys
K, M = [[931250, 237500, 181250], [237500, 781250, -162500], [181250, -162500, 206250]], [[1.5, -0.0625, 0.125], [-0.0625, 2.203125, 0.140625], [0.125, 0.140625, 1.40625]]
square = lambda A, y: sum(y[i] * A[i][j] * y[j] for i in range(3) for j in range(3))
rows = json.load(sys.stdin)
assert len(rows) == 200
for r in rows: # the spring is not pressed yet
    x, v = ([r[f"{name}{i}"] for i in (1, 2, 3)] for name in "xv")
    energy = (square(M, v) + square(K, x)) / 2
    assert abs(x[0] - x[2] - 1) < 1e-14 and abs(energy / 37324.488 - 1) < 1e-12, (r, energy)'
}
ok "every row lies on its face, with the energy, where the force along the face is large" on_the_face

got=0
section "$folder/study.yaml" --energy 5 --impacts 100000000 --starts 2 --exponents --seconds 0.2 --csv >"$folder/out" 2>"$folder/err" || got=$?
ok "a limit of time" test "$got" = 3
ok "what was done is shown" test "$(rows <"$folder/out")" = 2
ok "and said" grep -q "stopped when the time given was over" "$folder/err"
"$ricochet" section "$folder/study.yaml" --energy 5 --impacts 1000000000 --starts 2 --exponents --csv >"$folder/out" 2>"$folder/err" &
listens $!
kill -TERM $!
wait $!
ok "a signal to end" test "$?" = 130
ok "shows what was done, too" test "$(rows <"$folder/out")" = 2
finish
