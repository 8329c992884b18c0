#!/usr/bin/env bash
# The hunt from outside: wrong calls, an atlas that lacks an isolated family, which is added, followed, resumed and found.
set -u
. tests/support/tap.sh

cat >"$folder/study.yaml" <<YAML
title: Two masses
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {normal: [-1, 1], clearance: 1.0, law: rigid}
explore: {energy: [0, 40], frequency: [0.2, 10], impacts: 6, multiply: 2, depth: 0}
YAML
sed 's/9, -1/9.5, -1/' "$folder/study.yaml" >"$folder/other.yaml"
atlas=$folder/atlas.ricochet

hunt() { "$ricochet" hunt "$folder/study.yaml" --energy 5 --impacts 4 --lines 2000 --rows 15 --row 200 --random 5000 --starts 20 "$@"; }

refused() { refusal hunt "$@"; } # CODE PATTERN ARGUMENTS...
ok "no energy" refused 2 "energy is missing" "$folder/study.yaml"
ok "a negative energy" refused 2 "not positive" "$folder/study.yaml" --energy -1
ok "no impacts" refused 2 "whole number" "$folder/study.yaml" --energy 1 --impacts 0
ok "--add without an atlas" refused 2 "needs --atlas" "$folder/study.yaml" --energy 1 --add
ok "three modes" refused 2 "see 3 modes" examples/three-masses/study.yaml --energy 1
printf '%s\n' 'model:' '  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]' '  stiffness: [[3, -1, -1], [-1, 3, -1], [-1, -1, 3]]' \
    '  contacts: [{normal: [1, 0, 0], clearance: 1}]' >"$folder/equal.yaml"
ok "two modes of one frequency" refused 2 "modes have one frequency, and the stops see a mixture" "$folder/equal.yaml" --energy 2
printf '%s\n' 'model:' '  mass: [[2, 0], [0, 1]]' '  stiffness: [[9, -1], [-1, 1]]' '  contacts:' \
    '    - {normal: [-1, 1], clearance: 1}' '    - {normal: [2, -2], clearance: 2, sides: lower}' >"$folder/twice.yaml"
ok "a stop that is given twice" refused 2 "contacts 1 and 2 are one stop" "$folder/twice.yaml" --energy 5
ok "no such atlas" refused 2 "no such file" "$folder/study.yaml" --energy 1 --atlas "$folder/none.ricochet"

ok "an atlas" "$ricochet" run "$folder/study.yaml" -o "$atlas"
ok "of another model" refused 1 "another model" "$folder/other.yaml" --energy 1 --atlas "$atlas"
ok "below all stops there is nothing" test "$("$ricochet" hunt "$folder/study.yaml" --energy 0.01 --json 2>/dev/null | tr -d '[:space:]')" = "[]"

hunt --csv >"$folder/first.csv" 2>/dev/null
hunt --csv >"$folder/second.csv" 2>/dev/null
ok "ten orbits at energy 5" test "$(tail -n +2 "$folder/first.csv" | wc -l)" = 10
ok "the same ones again" same "$folder/first.csv" "$folder/second.csv"

hunt --atlas "$atlas" --csv >"$folder/lacking.csv" 2>"$folder/lacking"
ok "nothing is unexplained" grep -q " 0 unexplained" "$folder/lacking"
lacking=$(grep -c ,isolated, "$folder/lacking.csv")
ok "some families are isolated" test "$lacking" -gt 0
tables "$atlas" >"$folder/before.txt"

ok "they are added" hunt --atlas "$atlas" --add
tables "$atlas" >"$folder/between.txt"
ok "which changes no row" same "$folder/before.txt" "$folder/between.txt"
cp "$atlas" "$folder/killed.ricochet"
cp "$atlas" "$folder/workers.ricochet"
ok "the next run follows them" "$ricochet" run "$folder/study.yaml" -o "$atlas"
grew() { test "$("$ricochet" branches "$atlas" --csv | wc -l)" -gt "$("$ricochet" branches "$folder/killed.ricochet" --csv | wc -l)"; }
ok "to branches that it did not have" grew
ok "what they lead to verifies" "$ricochet" verify "$atlas"
hunt --atlas "$atlas" --csv >"$folder/now.csv" 2>/dev/null
ok "and nothing is isolated any more" test "$(grep -c ,isolated, "$folder/now.csv")" = 0
tables "$atlas" >"$folder/whole.txt"
ok "the same run again" "$ricochet" run "$folder/study.yaml" -o "$atlas"
tables "$atlas" >"$folder/again.txt"
ok "changes nothing" same "$folder/whole.txt" "$folder/again.txt"

cp "$folder/killed.ricochet" "$folder/begun.ricochet"
whole=$(bytes "$atlas") begun=$(bytes "$folder/killed.ricochet") kills=0
for attempt in 0 1 2 3; do
    "$ricochet" run "$folder/study.yaml" -o "$folder/killed.ricochet" 2>/dev/null &
    break_off KILL $! "$folder/killed.ricochet" $((begun + 1 + attempt * (whole - begun) / 5)) && kills=$((kills + 1))
done
for _ in 1 2 3 4 5 6 7 8; do # a busy machine may look only when all is written: from the beginning
    [ $kills = 0 ] || break
    cp "$folder/begun.ricochet" "$folder/killed.ricochet"
    "$ricochet" run "$folder/study.yaml" -o "$folder/killed.ricochet" 2>/dev/null &
    break_off KILL $! "$folder/killed.ricochet" $((begun + 1)) && kills=1
done
ok "it is killed in the midst of what it adds" test $kills -ge 1
ok "killed four times the run ends" "$ricochet" run "$folder/study.yaml" -o "$folder/killed.ricochet"
tables "$folder/killed.ricochet" >"$folder/killed.txt"
ok "with the same atlas" same "$folder/whole.txt" "$folder/killed.txt"
ok "two workers" "$ricochet" run "$folder/study.yaml" -o "$folder/workers.ricochet" -j 2
tables "$folder/workers.ricochet" >"$folder/workers.txt"
ok "with the same atlas" same "$folder/whole.txt" "$folder/workers.txt"

# Families that leave a doubling of S2[01]: an atlas that looks for no multiplications does not list it.
cat >"$folder/single.yaml" <<YAML
title: No multiplications
model:
  mass: [[0.64, 0], [0, 1.941]]
  stiffness: [[3.4828, -1.5114], [-1.5114, 3.452]]
  contacts:
    - {law: rigid, normal: [0, 1], clearance: 0.975, sides: both}
explore: {energy: [0, 138.465], frequency: [0.2884, 6.0669], impacts: 8, multiply: 1, depth: 3}
YAML
single() { "$ricochet" hunt "$folder/single.yaml" --energy 83.0787 --impacts 4 --atlas "$folder/single.ricochet" --csv; }
ok "an atlas without multiplications" "$ricochet" run "$folder/single.yaml" -o "$folder/single.ricochet"
single >"$folder/single.csv" 2>"$folder/single.err"
ok "what leaves one of them is beyond a budget" test "$(grep -c 'a multiplication by 2 at E 9.53965884.*beyond explore.multiply' "$folder/single.csv")" = 4
ok "and nothing is unexplained" test "$(grep -c ,unexplained, "$folder/single.csv")" = 0

# A window of energies: the chain of A3[001] and A4[0001] that no departure leads to, between two touches of three impacts.
sed 's/impacts: 6, multiply: 2/impacts: 4, multiply: 1/' "$folder/study.yaml" >"$folder/islands.yaml"
"$ricochet" run "$folder/islands.yaml" -o "$folder/islands.ricochet" >/dev/null 2>&1
window() { "$ricochet" hunt "$folder/islands.ricochet" --energy "$1" --impacts 4 --lines 4000 --rows 10 --row 200 --random 3000 --starts 20 "${@:2}"; }
ok "a window that ends before it begins" refused 2 "ends before it begins" "$folder/islands.ricochet" --energy 11,3
ok "a window without an end" refused 2 "a number is missing" "$folder/islands.ricochet" --energy 3,
ok "before, every branch is linked to a mode" eval "! '$ricochet' branches '$folder/islands.ricochet' --json | grep -q '\"linked\": false'"
window 3,11 --add --json >"$folder/window.json" 2>"$folder/window"
ok "energies between energies are looked at until nothing new is found" grep -q "17 energies from 3 to 11 were looked at; .* found nothing new" "$folder/window"
"$ricochet" branches "$folder/islands.ricochet" --json >"$folder/islands.json"
is_island() { python3 -S -c '
import json, sys
rows = [r for r in json.load(open(sys.argv[1])) if not r["linked"]]
chain = [r for r in rows if abs(r["energy_min"] - 3.154787) < 1e-5 and abs(r["energy_max"] - 10.694157) < 1e-5]
print(rows)
assert {r["label"] for r in chain} == {"A3[001]", "A4[0001]"}
assert all(abs(r["frequency_min"] - 1.418199) < 1e-5 and abs(r["frequency_max"] - 1.553366) < 1e-5 for r in chain)
' "$folder/islands.json"; }
ok "the island has the ends that are known" is_island
ok "report counts the islands" eval "'$ricochet' report '$folder/islands.ricochet' | grep -q 'families linked to no mode  *3 '"

# Words alone: an orbit with multipliers of 1e17, whose word no start in double precision has.
by_words() { "$ricochet" hunt "$folder/study.yaml" --lines 2 --rows 0 --random 0 "$@"; }
by_words --energy 2.5 --impacts 7 --csv >"$folder/steep.csv" 2>/dev/null
ok "an orbit that no motion leads to" grep -q ",0010011,26.06828454.*,-975484" "$folder/steep.csv"
none() { test "$(by_words --energy 2.5 --impacts 7 --starts 0 --csv 2>/dev/null | grep -c 26.0682845)" = 0; }
ok "and that is not found without guesses of impact times" none
set -m # else the shell lets its children ignore Ctrl-C
"$ricochet" hunt "$folder/study.yaml" --lines 2 --rows 0 --random 0 --energy 2.5 --starts 100000000 --csv >"$folder/stopped.csv" 2>"$folder/stopped" &
spent() { test -r "/proc/$1/stat" && test "$(awk '{ print $14 }' "/proc/$1/stat")" -ge 50; } # half a second of processor time
while kill -0 $! 2>/dev/null && ! spent $!; do sleep 0.05; done
kill -INT $!
wait $!
ok "Ctrl-C ends it with its own exit code" test $? = 130
ok "and prints what was found until then" test "$(tail -n +2 "$folder/stopped.csv" | wc -l)" -gt 0
set +m
ok "and says so" grep -q "orbits were found until then" "$folder/stopped"

sed 's/clearance: 1.0/clearance: 2.0/' "$folder/study.yaml" >"$folder/wide.yaml"
units() { # with twice the clearance energies are four times as large, and displacements twice
    local few=(--impacts 3 --lines 500 --rows 5 --row 50 --random 500 --json)
    "$ricochet" hunt "$folder/study.yaml" --energy 5 "${few[@]}" >"$folder/scaled.json" 2>"$folder/err" \
        && "$ricochet" hunt "$folder/wide.yaml" --energy 20 --physical --hz "${few[@]}" >"$folder/physical.json" 2>>"$folder/err" || return 1
    grep 'at energy 20$' "$folder/err" && python3 -S - "$folder" <<'PY'
import json, math, sys
a, b = (json.load(open(f"{sys.argv[1]}/{name}.json")) for name in ("scaled", "physical"))
assert len(a) == len(b) > 0
for p, q in zip(a, b):
    assert p["word"] == q["word"] and q["energy"] == 20 and p["energy"] == 5
    assert math.isclose(p["period"], q["period"], rel_tol=1e-9) and math.isclose(p["frequency"], 2 * math.pi * q["frequency"], rel_tol=1e-9)
    assert all(math.isclose(2 * x, y, rel_tol=1e-8, abs_tol=1e-8) for x, y in zip(p["state"], q["state"]))
PY
}
ok 'in the units of the study' units
small() { "$ricochet" hunt "$@" --impacts 2 --lines 1000 --rows 5 --row 50 --random 1000 --starts 5; }
printf '%s\n' 'model:' '  mass: [[2, 0], [0, 0.5]]' '  stiffness: [[0, 0], [0, 32]]' '  contacts:' \
    '    - {normal: [1, 0], clearance: 0.23, sides: upper}' '    - {normal: [1, -1], clearance: 0.49, sides: lower}' >"$folder/loose.yaml"
ok 'a line so short that no number halves it' small "$folder/loose.yaml" --energy 0.3
printf '%s\n' 'model:' '  mass: [[1, 0], [0, 2]]' '  stiffness: [[0, 0], [0, 32]]' '  contacts:' \
    '    - {normal: [1, 0], clearance: 0.23, sides: upper}' '    - {normal: [1, -1], clearance: 0.49, sides: lower}' \
    'explore: {depth: 2, impacts: 2, frequency: [1, 20]}' >"$folder/loose.yaml"
loose() { # the orbits of a loose mass that are found without a branch are those of its branches
    "$ricochet" run "$folder/loose.yaml" --quiet && small "$folder/loose.ricochet" --energy 3 --atlas "$folder/loose.ricochet" >"$folder/said" 2>&1 &&
        grep '4 orbits there, 4 were found again; it lacks 0' "$folder/said"
}
ok 'a loose mass' loose
finish
