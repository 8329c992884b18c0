#!/bin/bash
# What the listing commands print: JSON that parses, CSV that agrees with it, exit codes. RICOCHET is the program.
set -uo pipefail

if ! command -v python3 >/dev/null; then
    echo "1..0 # SKIP python3 is needed to read JSON and CSV"
    exit 77
fi
program=${RICOCHET:-ricochet}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
study=$folder/study.yaml atlas=$folder/study.ricochet
number=0 failed=0

report() { # report STATUS NAME
    number=$((number + 1))
    if [ "$1" -eq 0 ]; then
        echo "ok $number - $2"
    else
        echo "not ok $number - $2"
        sed 's/^/# /' "$folder/said" 2>/dev/null
        failed=1
    fi
}

expect() { # expect CODE NAME COMMAND...
    local code=$1 name=$2
    shift 2
    "$@" >"$folder/out" 2>"$folder/said"
    local got=$?
    [ "$got" -eq "$code" ] || echo "exit $got instead of $code: $*" >>"$folder/said"
    [ "$got" -eq "$code" ] && { [ "$code" -eq 0 ] || [ -s "$folder/said" ]; }
    report $? "$name"
}

# Lengths are not 1 here, so that --physical shows.
cat >"$study" <<'YAML'
title: Two masses, 2 mm of play
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {name: stop, normal: [-1, 1], clearance: 2, sides: both, law: rigid}
explore:
  energy: [0, 6]
  frequency: [0.5, 6]
  impacts: 4
  multiply: 1
  depth: 1
YAML

expect 0 "an atlas is made" "$program" run "$study" -o "$atlas"
if [ "$failed" -ne 0 ]; then
    exit 1
fi

branch=$("$program" branches "$atlas" --json | python3 -S -c '
import json, sys
print(next(b["id"] for b in json.load(sys.stdin) if b["impacts"] == 2 and b["points"] > 3))')

# Same rows in both formats, number for number; and the columns that others rely on.
cat >"$folder/agree.py" <<'PY'
import csv, json, sys

rows, table = json.load(open(sys.argv[1])), list(csv.DictReader(open(sys.argv[2], newline="")))
assert rows, "no rows"
assert len(rows) == len(table), f"{len(rows)} rows in JSON, {len(table)} in CSV"
missing = set(sys.argv[3].split()) - set(rows[0])
assert not missing, f"not there: {missing}"
missing = set(sys.argv[3].split()) - set(table[0])
assert not missing, f"not there in CSV: {missing}"


def flat(value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return " ".join(f"{key}={flat(member)}" for key, member in value.items())
    if isinstance(value, list):
        return " ".join("null" if member is None else flat(member) for member in value)
    return value if isinstance(value, str) else repr(value)


def same(a, b):
    if a == b:
        return True
    parts = a.replace("=", " ").split(), b.replace("=", " ").split()
    return len(parts[0]) == len(parts[1]) and all(x == y or float(x) == float(y) for x, y in zip(*parts))


for row, line in zip(rows, table):
    for key, text in line.items():
        assert same(flat(row.get(key)), text), f"{key}: {row.get(key)!r} in JSON, {text!r} in CSV"
PY

agree() { # agree "COLUMNS" COMMAND...
    local columns=$1 name="JSON and CSV agree: $2"
    shift
    "$program" "$@" --json >"$folder/json" 2>"$folder/said" && "$program" "$@" --csv >"$folder/csv" 2>>"$folder/said" &&
        "$program" "$@" >"$folder/text" 2>>"$folder/said" && [ -s "$folder/text" ] &&
        python3 -S "$folder/agree.py" "$folder/json" "$folder/csv" "$columns" 2>>"$folder/said"
    report $? "$name"
}

agree "id label word impacts symmetric reversible mirror stable_fraction points energy_min energy_max frequency_min frequency_max from to stop junctions depth" \
    branches "$atlas"
agree "id kind label name word impacts grazings multiple rotation a b energy frequency state flights branches departures" junctions "$atlas"
agree "segment branch from to energy_min energy_max frequency_min frequency_max stable stable_fraction" branches "$atlas" --segments
agree "id label word impacts from to stop junctions depth" branches "$atlas" --elementary
agree "duplicate branch k kind origin j rotation label name junction energy frequency" junctions "$atlas" --duplicates 3
agree "base mode j number branches labels duplicates energy_min energy_max frequency_min frequency_max" bases "$atlas"
agree "arclength energy frequency period trace log_trace rotation stable reach approach residual" points "$atlas" --branch "$branch"
agree "end point arclength energy frequency period trace log_trace rotation stable reach approach residual admissible" \
    points "$atlas" --branch "$branch" --ghost
agree "word state flights period energy multipliers stable amplitudes impact_speeds impulses" orbit "$atlas" --branch "$branch" --point 1
agree "t x1 x2 v1 v2" orbit "$atlas" --branch "$branch" --point 1 --history 0.05

# Rows against each other.
for command in branches junctions; do
    "$program" $command "$atlas" --json >"$folder/$command.json"
    "$program" $command "$atlas" --json --physical >"$folder/$command.physical.json"
done
"$program" points "$atlas" --branch "$branch" --json >"$folder/points.json"
"$program" points "$atlas" --branch "$branch" --json --physical >"$folder/points.physical.json"
"$program" points "$atlas" --branch "$branch" --ghost --json >"$folder/ghost.json" 2>"$folder/ghost.said"
"$program" points "$atlas" --branch "$branch" --ghost --json --physical >"$folder/ghost.physical.json" 2>>"$folder/said"
"$program" orbit "$atlas" --branch "$branch" --point 1 --json >"$folder/orbit.json"
"$program" orbit "$atlas" --branch "$branch" --point 1 --json --physical >"$folder/orbit.physical.json"
"$program" orbit "$atlas" --branch "$branch" --point 1 --history 0.001 --json >"$folder/history.json"
python3 -S - "$folder" "$branch" <<'PY' 2>"$folder/said"
import json, math, sys

folder, branch = sys.argv[1], int(sys.argv[2])
branches, junctions, points, ghost, orbit, history = (
    json.load(open(f"{folder}/{name}.json")) for name in ("branches", "junctions", "points", "ghost", "orbit", "history"))
assert [row["id"] for row in branches] == list(range(1, len(branches) + 1))
assert [row["id"] for row in junctions] == list(range(1, len(junctions) + 1))
for row in branches:
    assert row["stop"] in ("junction", "corner", "window", "budget", "closed", "failed")
    for end in ("from", "to"):
        assert row[end] is None or row["id"] in junctions[row[end] - 1]["branches"], row
    for inner in row["junctions"]:
        assert row["id"] in junctions[inner - 1]["branches"], row
for row in junctions:
    assert set(row["departures"]) == {"taken", "known", "inadmissible", "over_budget", "refused"}
    assert sum(row["budgets"].values()) == row["departures"]["over_budget"], row
    assert len(row["state"]) == 4 and len(row["flights"]) == max(1, row["impacts"])
mine = branches[branch - 1]
assert len(points) == mine["points"]
assert min(p["energy"] for p in points) == mine["energy_min"] and max(p["frequency"] for p in points) == mine["frequency_max"]
assert all(a["arclength"] <= b["arclength"] for a, b in zip(points, points[1:]))
assert all(math.isclose(p["period"] * p["frequency"], 2 * math.pi, rel_tol=1e-15) for p in points)
assert all(math.isclose(p["log_trace"], math.log(abs(p["trace"])), abs_tol=1e-9) for p in points if p["trace"])

# a ghost goes on where the branch ends at a grazing, with negative margins, and only when it is asked for
assert set(ghost[0]) - set(points[0]) == {"end", "admissible"} and not set(points[0]) - set(ghost[0])
for end, tip, sign in (("from", points[0], -1), ("to", points[-1], 1)):
    rows = [row for row in ghost if row["end"] == end]
    grazes = mine[end] is not None and junctions[mine[end] - 1]["kind"] == "grazing"
    assert bool(rows) == grazes, (end, mine[end])
    if not rows:
        continue
    assert [row["point"] for row in rows] == list(range(len(rows)))
    assert rows[0]["arclength"] == tip["arclength"] and math.isclose(rows[0]["energy"], tip["energy"], rel_tol=1e-9)
    assert all(sign * (b["arclength"] - a["arclength"]) > 0 for a, b in zip(rows, rows[1:]))
    assert all(row["approach"] < 0 or row["reach"] > 1 for row in rows[1:]) and not any(row["admissible"] for row in rows)
    assert all(row["residual"] < 1e-13 and row["energy"] <= 6 * (1 + 1e-12) for row in rows)
    assert f"beyond '{end}': {len(rows)} points; stopped: window" in open(f"{folder}/ghost.said").read()
assert ghost

o = orbit[0]
assert math.isclose(o["energy"], points[1]["energy"], rel_tol=1e-9) and math.isclose(sum(o["flights"]), o["period"], rel_tol=1e-12)
for i, amplitude in enumerate(o["amplitudes"]):
    seen = max(abs(row[f"x{i + 1}"]) for row in history)
    assert seen <= amplitude * (1 + 1e-12) and amplitude <= seen * (1 + 1e-4), (amplitude, seen)
assert len(o["impact_speeds"]) == len(o["impulses"]) == len(o["word"])
x, v = o["state"][:2], o["state"][2:]
assert math.isclose(o["impact_speeds"][0], abs(v[1] - v[0]), rel_tol=1e-12)
assert math.isclose(o["impulses"][0], 2 * o["impact_speeds"][0] / 1.5, rel_tol=1e-12)  # b.M^-1 b = 1/2 + 1
assert min(o["impact_speeds"]) >= points[1]["approach"] * (1 - 1e-6)
assert math.isclose(sum(m * s * s for m, s in zip((2, 1), v)) / 2 + (9 * x[0] ** 2 - 2 * x[0] * x[1] + x[1] ** 2) / 2, o["energy"], rel_tol=1e-9)
assert history[0]["t"] == 0 and history[-1]["t"] == o["period"]
assert all(math.isclose(history[0][key], value, rel_tol=1e-12, abs_tol=1e-12) for key, value in zip(("x1", "x2", "v1", "v2"), o["state"]))

d = 2.0
for name, plain, scales in (("branches", branches, {"energy_min": d * d, "energy_max": d * d, "frequency_min": 1}),
                            ("junctions", junctions, {"energy": d * d, "frequency": 1}),
                            ("points", points, {"energy": d * d, "approach": d, "period": 1, "reach": 1}),
                            ("ghost", ghost, {"energy": d * d, "approach": d, "period": 1, "reach": 1}),
                            ("orbit", orbit, {"energy": d * d, "period": 1})):
    physical = json.load(open(f"{folder}/{name}.physical.json"))
    for a, b in zip(plain, physical):
        for key, scale in scales.items():
            assert a[key] is None and b[key] is None or a[key] * scale == b[key], (name, key)
        for key in ("state", "amplitudes", "impact_speeds", "impulses"):
            if key in a and isinstance(a[key], list):
                assert [d * value for value in a[key]] == b[key], (name, key)
PY
report $? "rows fit together"

"$program" orbit "$atlas" --branch "$branch" --point 1 --json >"$folder/orbit.json" 2>"$folder/said"
for key in energy frequency; do
    value=$(python3 -S -c "import json; print(repr(json.load(open('$folder/orbit.json'))[0]['$key']))")
    expect 0 "an orbit is found by its $key" "$program" orbit "$atlas" --branch "$branch" "--$key" "$value" --json
    python3 -S - "$folder/out" "$key" "$value" <<'PY' 2>"$folder/said"
import json, math, sys
rows = json.load(open(sys.argv[1]))
assert rows and all(math.isclose(row[sys.argv[2]], float(sys.argv[3]), rel_tol=1e-9) for row in rows), rows
PY
    report $? "every orbit has that $key"
done

# Duplicates: the same branches k times, counted; and what the run was not asked to look for is told.
"$program" junctions "$atlas" --duplicates 3 --branch "$branch" --json >"$folder/duplicates.json" 2>"$folder/said"
grep -q "q above 1 were not looked for.*'multiply: 3'" "$folder/said"
report $? "duplicates beyond the study's multiply are told"
"$program" junctions "$atlas" --duplicates 3 --branch "$branch" --json --physical >"$folder/duplicates.physical.json" 2>"$folder/said"
"$program" branches "$atlas" --segments --json >"$folder/segments.json" 2>"$folder/said"
"$program" branches "$atlas" --segments --json --physical >"$folder/segments.physical.json" 2>"$folder/said"
"$program" bases "$atlas" --branch "$branch" --json >"$folder/bases.json" 2>"$folder/said"
"$program" bases "$atlas" --branch "$branch" --json --physical >"$folder/bases.physical.json" 2>"$folder/said"
python3 -S - "$folder" "$branch" <<'PY' 2>"$folder/said"
import json, math, sys

folder, branch = sys.argv[1], int(sys.argv[2])
names = ("branches", "junctions", "duplicates", "segments", "bases")
branches, junctions, duplicates, segments, bases = (json.load(open(f"{folder}/{name}.json")) for name in names)
mine = branches[branch - 1]
places = [id for id in (mine["from"], *mine["junctions"], mine["to"]) if id]
assert [row["junction"] for row in duplicates if row["k"] == 1] == places
for row in duplicates:
    k, first = row["k"], [r for r in duplicates if r["k"] == 1][[r for r in duplicates if r["k"] == row["k"]].index(row)]
    assert row["branch"] == branch and row["origin"] == "copy" and row["j"] is None
    assert math.isclose(row["frequency"], first["frequency"] / k, rel_tol=1e-15) and row["energy"] == first["energy"]
    assert (row["duplicate"] == mine["label"]) == (k == 1) and ("{%d" % k in row["duplicate"]) == (k > 1)
for row in segments:
    whole = branches[row["branch"] - 1]
    assert row["segment"].startswith(whole["label"] + "|")
    assert row["energy_max"] <= whole["energy_max"] * (1 + 1e-9)
assert len(segments) == sum(len(row["junctions"]) + 1 for row in branches)
assert len(bases) == 1 and branch in bases[0]["branches"] and bases[0]["number"] == len(bases[0]["branches"])
assert bases[0]["labels"] == [branches[id - 1]["label"] for id in bases[0]["branches"]]
for name, plain, keys in (("duplicates", duplicates, ["energy"]), ("segments", segments, ["energy_min", "energy_max"]),
                          ("bases", bases, ["energy_min", "energy_max"])):
    for a, b in zip(plain, json.load(open(f"{folder}/{name}.physical.json"))):
        assert all(4.0 * a[key] == b[key] for key in keys), (name, a, b)
PY
report $? "duplicates, segments and bases fit the branches"

# The example in the description of the file works as it is.
if [ -e docs/atlas-format.md ]; then
    sed -n '/^```python$/,/^```$/p' docs/atlas-format.md | sed '/^```/d' >"$folder/example.py"
    python3 "$folder/example.py" "$atlas" >"$folder/out" 2>"$folder/said" && [ -s "$folder/out" ]
    report $? "the Python example of docs/atlas-format.md works"
fi

# Wrong calls say so and exit with 2, what cannot be done exits with 1, and nothing of it is on standard output.
echo "not an atlas" >"$folder/foreign"
for command in branches junctions bases; do
    expect 2 "$command without an atlas" "$program" $command
    expect 2 "$command with both formats" "$program" $command "$atlas" --json --csv
    expect 2 "$command with an unknown option" "$program" $command "$atlas" --colour
    expect 2 "$command of a file that is not there" "$program" $command "$folder/none"
    expect 1 "$command of a foreign file" "$program" $command "$folder/foreign"
    expect 1 "$command of a folder" "$program" $command "$folder"
    [ -s "$folder/out" ] && report 1 "$command keeps standard output clean"
done
for command in points orbit; do
    expect 2 "$command without --branch" "$program" $command "$atlas" --point 0
    expect 2 "$command with a branch that is no number" "$program" $command "$atlas" --branch first
done
expect 2 "no duplicates" "$program" junctions "$atlas" --duplicates 0
expect 2 "a branch without duplicates" "$program" junctions "$atlas" --branch "$branch"
grep -q -e '--duplicates K' "$folder/said"
report $? "a branch without duplicates says what to add"
expect 1 "duplicates of a branch that is not there" "$program" junctions "$atlas" --duplicates 2 --branch 9999
expect 1 "bases of a branch that is not there" "$program" bases "$atlas" --branch 9999
expect 2 "bases with too many duplicates" "$program" bases "$atlas" --duplicates 65
expect 1 "points of a branch that is not there" "$program" points "$atlas" --branch 9999
expect 1 "ghosts of a branch that is not there" "$program" points "$atlas" --branch 9999 --ghost
expect 1 "ghosts of a linear mode" "$program" points "$atlas" --branch 1 --ghost
grep -q 'linear mode' "$folder/said" && [ ! -s "$folder/out" ]
report $? "a linear mode says why it has no ghost"
sed 's/energy: \[0, 6\]/energy: [0, 2.2]/; s/depth: 1/depth: 2/' "$study" >"$folder/low.yaml"
"$program" run "$folder/low.yaml" -o "$folder/low.ricochet" >"$folder/out" 2>"$folder/said"
cut=$("$program" branches "$folder/low.ricochet" --json | python3 -S -c '
import json, sys
print(next(b["id"] for b in json.load(sys.stdin) if b["label"] == "A2[01]"))')
expect 1 "ghosts of a branch from a branch point to the window" "$program" points "$folder/low.ricochet" --branch "$cut" --ghost
grep -q 'branch-point C1_32' "$folder/said" && grep -q 'upper end of the energy window' "$folder/said"
report $? "a branch without a grazing end says what its ends are"
expect 1 "an orbit of a branch that is not there" "$program" orbit "$atlas" --branch 9999 --point 0
expect 1 "an orbit at a point that is not there" "$program" orbit "$atlas" --branch "$branch" --point 999999
expect 1 "an orbit at an energy that is not there" "$program" orbit "$atlas" --branch "$branch" --energy 1e9
expect 2 "an orbit without a place" "$program" orbit "$atlas" --branch "$branch"
expect 2 "an orbit at two places" "$program" orbit "$atlas" --branch "$branch" --point 1 --energy 2
expect 2 "a history with no step" "$program" orbit "$atlas" --branch "$branch" --point 1 --history 0
expect 2 "a history of too many steps" "$program" orbit "$atlas" --branch "$branch" --point 1 --history 1e-9
if [ -c /dev/full ]; then
    "$program" branches "$atlas" --json >/dev/full 2>"$folder/said"
    [ $? -eq 1 ] && [ -s "$folder/said" ]
    report $? "a full disk is told"
fi
[ "$(ls "$folder" | grep -c '^study\.ricochet')" -eq 1 ]
report $? "reading leaves nothing beside the atlas"

echo "1..$number"
exit $failed
