#!/bin/bash
# Regions of a study: larger budgets hold for departures from junctions there, and nowhere else.
set -u
. tests/support/tap.sh

study() { sed 's/depth: 4/depth: 3/' examples/elementary/study.yaml; [ $# = 0 ] || printf 'regions:\n'; for region in "$@"; do printf '  - {%s}\n' "$region"; done; }
explore() { study "${@:2}" >"$folder/$1.yaml" && "$ricochet" run "$folder/$1.yaml" -o "$folder/$1.ricochet" 2>"$folder/$1.err"; }
rows() { "$ricochet" "$1" "$folder/$2.ricochet" --json; }
same() { for what in branches junctions; do [ "$(rows $what "$1")" = "$(rows $what "$2")" ] || return 1; done; }
# The same but for labels: one that was shown before an atlas grew stays, and so a fresh run numbers junctions otherwise.
unlabelled() { rows junctions "$1" | python3 -S -c 'import json, sys; print([{k: v for k, v in j.items() if k != "label"} for j in json.load(sys.stdin)])'; }
as() { [ "$(rows branches "$1")" = "$(rows branches "$2")" ] && [ "$(unlabelled "$1")" = "$(unlabelled "$2")" ]; }

# Whether every branch of $1 is in $2, some are new, and those that no budget of elsewhere allows, at depth 4 and more or multiplied, meet a
# junction within energy $3 to $4, frequency $5 to $6 (its own, or that of its orbit gone through several times).
local_only() {
    rows branches "$1" >"$folder/small" && rows branches "$2" >"$folder/large" && rows junctions "$2" >"$folder/junctions" || return 1
    python3 -S - "$folder" "${@:3}" <<'END'
import json, sys
folder, window = sys.argv[1], [float(v) for v in sys.argv[2:]]
small, large, junctions = (json.load(open(f"{folder}/{name}")) for name in ("small", "large", "junctions"))
key = lambda b: (b["word"], b["symmetric"], *(f"{b[k]:.7g}" for k in ("energy_min", "energy_max", "frequency_min", "frequency_max")))
inside = {j["id"] for j in junctions if window[0] <= j["energy"] <= window[1] and any(window[2] <= j["frequency"] * m <= window[3] for m in (1, j["multiple"]))}
new = [b for b in large if key(b) not in set(map(key, small))]
print(len(small), "branches and", len(new), "new ones")
assert new and set(map(key, small)) <= set(map(key, large))
multiplied = {j["id"] for j in junctions if j["kind"] == "multiplication"}
ends = lambda b: {b["from"], b["to"]}
assert all(inside & {*ends(b), *b["junctions"]} for b in new if b["depth"] > 3), [b["id"] for b in new]
assert all(inside & ends(b) for b in new if multiplied & ends(b)), [b["id"] for b in new]
assert any(inside & ends(b) for b in new)
END
}

explore none
explore deeper 'energy: [15, 16], frequency: [1.5, 1.6], depth: 5'
ok 'one departure more, from the junctions of a region alone' local_only none deeper 15 16 1.5 1.6
explore double 'energy: [1.5, 3], frequency: [1.7, 1.9], multiply: 2'
ok 'multiplications in a region alone' local_only none double 1.5 3 1.7 1.9
c33() { "$ricochet" junctions "$folder/$1.ricochet" | grep -q '2.25568932141 *1.80003134035'; }
ok 'C33^6 is among them' c33 double
explore orbit 'energy: [1.5, 3], frequency: [3.5, 3.7], multiply: 2'
left() { rows junctions orbit | python3 -S -c 'import json, sys; assert [j["budgets"] for j in json.load(sys.stdin) if abs(j["energy"] - 2.25568932141) < 1e-9] == [{}]'; }
ok 'also when the region holds its orbit, not the place where it is drawn' left
counted() { "$ricochet" report "$folder/double.ricochet" | grep -q 'beyond .multiply' && "$ricochet" report "$folder/double.ricochet" | grep -q 'region with larger budgets.*energy 1.5 to 3, frequency 1.7 to 1.9'; }
ok 'the report names the region, and counts what was not tried elsewhere' counted
ok 'what was found verifies' "$ricochet" verify "$folder/double.ricochet"

explore beyond 'energy: [250, 400], frequency: [1.5, 2]'
further() { [ "$(rows branches beyond | python3 -S -c 'import json, sys; print(max(b["energy_max"] for b in json.load(sys.stdin)) > 399)')" = True ]; }
ok 'beyond the window branches are followed into the region' further

# one file: extended, made smaller, extended again
cp "$folder/double.yaml" "$folder/file.yaml"
cp "$folder/none.ricochet" "$folder/file.ricochet"
again() { "$ricochet" run "$folder/file.yaml" -o "$folder/file.ricochet" -j 2 2>"$folder/err"; }
extended() { again && as double file; }
ok 'an extended atlas is that of the study with regions' extended
smaller() { study >"$folder/file.yaml" && again && same none file && grep -q 'larger budgets than this study has (regions)' "$folder/err" && grep -q '^  - {energy: \[1.5, 3\], frequency: \[1.7, 1.9\], multiply: 2}' "$folder/err"; }
ok 'without them it is what it was, and the run says what it leaves out' smaller
back() { grep -A1 '^regions:' "$folder/err" >>"$folder/file.yaml" && again && as double file && ! grep -q 'was made with' "$folder/err"; }
ok 'the lines that it prints bring them back' back

other_model() { sed 's/2, 0/3, 0/' "$folder/none.yaml" >"$folder/heavy.yaml"; "$ricochet" run "$folder/heavy.yaml" -o "$folder/double.ricochet" 2>"$folder/err"; [ $? = 1 ] && grep -q 'another model' "$folder/err" && ! grep -q 'was made with' "$folder/err"; }
ok 'another model is refused without a word on budgets' other_model
refused() { study "$1" >"$folder/bad.yaml"; "$ricochet" run "$folder/bad.yaml" -o "$folder/bad.ricochet" 2>"$folder/err"; [ $? = 2 ] && grep -q "$2" "$folder/err" && [ ! -e "$folder/bad.ricochet" ]; }
ok 'a region without a window' refused 'energy: [1, 2]' 'regions\[1\].frequency: missing'
ok 'a window turned round' refused 'energy: [2, 1], frequency: [1, 2]' 'write the lower bound first'
ok 'an unknown key' refused 'energy: [1, 2], frequency: [1, 2], deepth: 3' "did you mean 'depth'"
finish
