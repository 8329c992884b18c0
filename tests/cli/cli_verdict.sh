#!/usr/bin/env bash
# What run and verify answer stands on standard output, what they remark on standard error.
set -u
. tests/support/tap.sh

study=examples/elementary/study.yaml atlas="$folder/e.ricochet"
# answers PATTERN ARGUMENT...: on standard output alone
answers() {
    local pattern=$1
    shift
    "$ricochet" "$@" >"$folder/out" 2>"$folder/said" || { cat "$folder/said"; return 1; }
    cat "$folder/out"
    grep -q -e "$pattern" "$folder/out" && ! grep -q -e "$pattern" "$folder/said"
}
silent() { "$ricochet" "$@" >"$folder/out" 2>&1 && [ ! -s "$folder/out" ]; }
refused() { "$ricochet" "$@" >"$folder/out" 2>&1; [ $? = 2 ]; }

ok 'run: the report' answers '^departures taken: ' run "$study" -o "$atlas"
ok 'run --quiet' silent run "$study" -o "$atlas" --quiet
as_report() { "$ricochet" run "$study" -o "$atlas" --json >"$folder/json" && diff "$folder/json" <("$ricochet" report "$atlas" --json); }
ok 'run --json' as_report
ok 'run on all cores' answers '14 branches' run "$study" -o "$folder/all.ricochet" -j 0
ok 'run: --jobs and -j' refused run "$study" -o "$atlas" -j 1 --jobs 1
ok 'verify: the verdict' answers 'points on 14 branches agree' verify "$atlas" --jobs 0
few() { ! grep -q "flight_error\|^point " "$folder/out" && [ "$(wc -l <"$folder/out")" -le 20 ]; }
"$ricochet" verify "$atlas" >"$folder/out" 2>/dev/null
ok 'verify: the verdict alone' few
ok 'verify --quiet' silent verify "$atlas" --quiet
rows() { "$ricochet" verify "$atlas" --verbose 2>&1 | grep -c '^point '; }
ok 'verify --verbose: a row for each' test "$(rows)" -gt 50
beside() { "$ricochet" verify "$atlas" --json 2>"$folder/said" | python3 -S -c 'import json, sys; assert len(json.load(sys.stdin)) > 50' && grep -q 'agree with' "$folder/said"; }
ok 'verify --json: rows, and the verdict beside them' beside
planted() {
    cp "$atlas" "$folder/b.ricochet"
    python3 -S -c 'import sqlite3, sys
db = sqlite3.connect(sys.argv[1])
db.execute("UPDATE branch SET energy_max = energy_max * 2 WHERE id = 3")
db.commit()' "$folder/b.ricochet" && tools/attack/atlas_digest.py "$folder/b.ricochet" >/dev/null
    "$ricochet" verify "$folder/b.ricochet" --quiet >"$folder/out" 2>"$folder/said"
    [ $? = 1 ] && [ ! -s "$folder/out" ] && grep -q 'branch 3 ' "$folder/said"
}
ok 'verify --quiet: what does not pass is named' planted

# Beside a junction, between springs a million times as stiff as the structure, traces are those of polished orbits.
cat >"$folder/stiff.yaml" <<'END'
model:
  mass: [[1.75, 0], [0, 0.25]]
  stiffness: [[12.25, -4.5], [-4.5, 10.5]]
  contacts: [{normal: [0, 1], law: bilinear, clearance: 0.819, sides: both, stiffness: 10740000}]
explore: {energy: [0, 115.2], frequency: [0.4785, 19.74], impacts: 6, multiply: 2, depth: 2}
END
passes() { "$ricochet" run "$folder/$1.yaml" -o "$folder/$1.ricochet" --quiet && "$ricochet" verify "$folder/$1.ricochet" --all --quiet; }
ok 'verify: a trace is as exact as the library states' passes stiff

# A pair that meets -1 is on the unit circle or beside it by less than the library states.
cat >"$folder/stiffer.yaml" <<'END'
model:
  mass: [[0.75, 0], [0, 0.5]]
  stiffness: [[1562500, -1000000], [-1000000, 1625000]]
  contacts: [{normal: [-1, 1], law: bilinear, clearance: 0.0012, sides: upper, stiffness: 110900000000}]
explore: {energy: [0, 83670000], frequency: [193.1, 6293], impacts: 6, multiply: 2, depth: 2}
END
ok 'verify: whether a pair turns is as certain as the library states' passes stiffer
finish
