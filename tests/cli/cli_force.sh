#!/usr/bin/env bash
# Damping and force from outside: numbers, columns, wrong calls.
set -u
. tests/support/tap.sh

atlas="$folder/e.ricochet"
ok "an atlas" "$ricochet" run examples/elementary/study.yaml -o "$atlas" --quiet
before=$(cksum "$atlas")

# ends CODE WORDS ARGUMENT...: the exit code, and the message
ends() {
    local code=$1 words=$2 got=0
    shift 2
    "$ricochet" force "$@" >"$folder/out" 2>"$folder/err" || got=$?
    [ "$got" = "$code" ] && grep -q -e "$words" "$folder/err"
}
rows() { python3 -S -c "import json, sys; rows = json.load(open('$folder/rows')); $1"; }

ok "an energy" "$ricochet" force "$atlas" --force 1,0 --damping 0.001 --energy 1
ok "its columns" test "$("$ricochet" force "$atlas" --force 1,0 --damping 0.001 --energy 1 --csv | head -1)" = \
    branch,key,energy,frequency,harmonic,omega,threshold,loss_damping,loss_impacts,phases,stable,trusted
"$ricochet" force "$atlas" --force 1,0 --damping 0.001 --harmonic 1,2,3 --level 0.02 --json >"$folder/rows"
ok "all points, three harmonics" rows 'assert len(rows) > 300 and {r["harmonic"] for r in rows} == {1, 2, 3}'
ok "phases where the level is above the threshold" rows \
    'assert all((len(r["phases"]) == 2) == (r["threshold"] is not None and r["threshold"] <= 0.02) for r in rows)'
ok "even harmonics do no work on symmetric orbits" rows \
    'assert any(r["harmonic"] == 2 and r["threshold"] is None and r["trusted"] == "work" for r in rows)'
ok "some are trusted, some are not" rows 'assert {"yes", "period"} <= {r["trusted"] for r in rows}'
reversed() { cmp -s <("$ricochet" force "$atlas" --force "-1,0" --damping 0.001 --energy 1 --csv) <("$ricochet" force "$atlas" --force=-1,0 --damping 0.001 --energy 1 --csv); }
ok "a force that begins with a minus is no option" reversed
ok "and is one" "$ricochet" force "$atlas" --force -1,0 --damping 0.001 --energy 1
printf '%%%%MatrixMarket matrix array real symmetric\n2 2\n0.02\n0\n0.01\n' >"$folder/C.mtx"
ok "a matrix" "$ricochet" force "$atlas" --force 1,0 --damping "$folder/C.mtx" --energy 1
ok "a window" "$ricochet" force "$atlas" --force 1,0 --damping 0.001 --energy 0.9,1.2
ok "a negative damping" ends 2 negative "$atlas" --force 1,0 --damping -0.001
ok "no force" ends 2 "force is missing" "$atlas" --damping 0.001
ok "a force of the wrong length" ends 2 "3 numbers" "$atlas" --force 1,0,0 --damping 0.001
ok "a force that is no number" ends 2 "not a finite number" "$atlas" --force 1,x --damping 0.001
ok "restitution 0" ends 2 "restitution 0" "$atlas" --force 1,0 --restitution 0
ok "nothing is lost" ends 2 "nothing is lost" "$atlas" --force 1,0
cat >"$folder/twice.yaml" <<'END'
model:
  mass: [[0.5, 0], [0, 0.5]]
  stiffness: [[7.75, -5.25], [-5.25, 5.25]]
  contacts: [{normal: [0, 1], clearance: 1.273, sides: upper}, {normal: [-1, 1], clearance: 0.6489}, {normal: [1, 1], clearance: 1.315, sides: upper}]
explore: {impacts: 1, multiply: 2, depth: 1}
END
"$ricochet" run "$folder/twice.yaml" -o "$folder/twice.ricochet" --quiet
"$ricochet" force "$folder/twice.ricochet" --force 1,0 --damping 0.001 --branch 'A1+[3]' --json >"$folder/rows"
slopes() { # dT/dE beside a junction that is stored twice, from the periods of the orbits around it
    rows 'import math
double = [k for k in range(1, len(rows) - 2) if rows[k + 1]["energy"] - rows[k]["energy"] < 1e-9 * rows[k]["energy"]]
assert double, "no point is stored twice"
for k in double:
    a, b = rows[k - 1], rows[k + 2]
    chord = 2 * math.pi * (1 / b["frequency"] - 1 / a["frequency"]) / (b["energy"] - a["energy"])
    for r in rows[k:k + 2]: assert 0.5 < r["slope"] / chord < 2, (r, chord)'
}
ok "a junction that is stored twice has the slope of the branch" slopes
ok "an energy without an orbit" ends 1 "no orbit of energy" "$atlas" --force 1,0 --damping 0.001 --energy 1e9
ok "a window without an orbit" ends 1 "no stored orbit" "$atlas" --force 1,0 --damping 0.001 --energy 1e8,1e9
ok "a window the wrong way round" ends 2 "window" "$atlas" --force 1,0 --damping 0.001 --energy 2,1
ok "a level below 0" ends 2 "level" "$atlas" --force 1,0 --damping 0.001 --level -1
ok "a harmonic that is none" ends 2 "harmonic" "$atlas" --force 1,0 --damping 0.001 --harmonic 0.5
ok "a matrix that is not there" ends 2 "none.mtx" "$atlas" --force 1,0 --damping "$folder/none.mtx"
exact() { "$ricochet" force "$atlas" --force 1,0 --damping 0.001 --energy 1 --level "$1" --exact --json >"$folder/rows"; }
ok "exact orbits" exact 0.01621538422
ok "a centre and a saddle" rows 'assert [round(r["largest"], 4) for r in rows] == [0.9935, 1.1293] and [r["stable"] for r in rows] == ["yes", "no"]'
"$ricochet" force "$atlas" --force 1,0 --damping 0.001 --level 0.03 --exact --json >"$folder/rows" 2>"$folder/err"
ok "what is trusted is there, and near" rows 'trusted = [r for r in rows if r["trusted"] == "yes"]
assert len(trusted) > 200 and all(not r["fault"] and r["distance"] < 0.05 for r in trusted)'
ok "solutions that are no motions are refused" rows 'faults = {r["fault"] for r in rows}
assert {"an impact does not approach its stop", "a stop is passed, or touched, between two impacts"} <= faults
assert all((r["state"] is None) == (r["fault"] != "") for r in rows)'
ok "and named" grep -q "no forced orbit is found: a stop is passed" "$folder/err"
ok "exact without a level" ends 2 "level" "$atlas" --force 1,0 --damping 0.001 --exact
ok "exact below the threshold" ends 1 "below the threshold" "$atlas" --force 1,0 --damping 0.001 --energy 1 --level 0.001 --exact --branch 3
"$ricochet" force "$atlas" --force 1,0 --damping 0.001 --harmonic 3 --level 10 --exact --json >"$folder/rows" 2>"$folder/err"
ok "a force that moves the structure as far as the motion is not trusted" rows 'said = [r for r in rows if r["trusted"] == "force"]
pairs = {(r["branch"], r["omega"]) for r in said}
other = {(r["branch"], r["omega"]) for r in said if r["fault"] != "" or r["distance"] > 0.1 or r["largest"] > 2}
assert pairs and pairs == other and not [r for r in rows if r["trusted"] == "yes"]'
isolas() { "$ricochet" force "$atlas" --damping 0.01 --restitution 0.9 --isolas "$@" --json >"$folder/rows" 2>"$folder/err"; }
ok "births of detached resonances" isolas --force 1,-0.1
ok "are located" rows 'first = next(r for r in rows if r["branch"] == 3)
assert first["event"] == "birth" and first["located"] < 1e-10 and abs(first["threshold"] / 0.307289004661 - 1) < 1e-10
assert abs(first["energy"] / 0.744310129805 - 1) < 1e-10 and all(r["event"] in ("birth", "join") for r in rows)'
ok "a window has those inside" isolas --force 1,-0.1 --energy 0.7,0.8
ok "and no others" rows 'assert rows and all(0.7 < r["energy"] < 0.8 for r in rows)'
ok "none is an answer" isolas --force 1,-0.1 --branch 1
ok "that is said" grep -q "no least or largest" "$folder/err"
ok "no single energy" ends 2 "leave --energy" "$atlas" --force 1,0 --damping 0.01 --isolas --energy 1
ok "nor exact orbits" ends 2 "leave --exact" "$atlas" --force 1,0 --damping 0.01 --isolas --exact --level 1
picture() { "$ricochet" plot force "$atlas" --force 1,-0.1 --damping 0.01 --restitution 0.9 "$@" 2>"$folder/err"; }
ok "a picture of what two levels keep up" picture --level 0.4,0.6 -o "$folder/lit.svg"
ok "with the level at which an isola is born" grep -q '>0.3073<' "$folder/lit.svg"
ok "and what the bands mean" bash -c "grep -q 'kept up at 0.6' '$folder/lit.svg' && grep -q 'kept up at 0.4' '$folder/lit.svg' && grep -q 'isola is born' '$folder/lit.svg'"
ok "amplitudes over the frequency of the force" picture --level 0.4 --output x2 -o "$folder/over.svg"
ok "which the axes say" bash -c "grep -q 'frequency of the force' '$folder/over.svg' && grep -q '>0.3073<' '$folder/over.svg'"
narrow() { "$ricochet" plot force "$atlas" --force 1,0 --damping 0.001 --window 0.998:1.002,1.2375:1.2382 "$@" -o "$folder/edge.svg" 2>"$folder/err"; }
ok "above the threshold 0.01247 of the middle of a window there is a band" narrow --level 0.01249
ok "the legend has it" grep -q 'kept up at 0.01249' "$folder/edge.svg"
ok "below it there is none" narrow --level 0.01245
ok "that is said" grep -q "no part of a branch in the picture is kept up" "$folder/err"
no_picture() { ! picture "$@" -o "$folder/none.svg" && ! test -e "$folder/none.svg" && grep -q "$words" "$folder/err"; }
words="level L is missing" ok "no level" no_picture
words="above 0" ok "a level below 0" no_picture --level -1
words="displacement, x1 to x2" ok "a displacement that is none" no_picture --level 0.4 --output y1
words="from 1 to 2" ok "one that is not there" no_picture --level 0.4 --output x3
words="one harmonic" ok "several harmonics" no_picture --level 0.4 --harmonic 1,3
ok "the atlas is what it was" test "$before" = "$(cksum "$atlas")"
finish
