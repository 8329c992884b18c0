#!/usr/bin/env bash
# Loci of junctions from outside: against atlases of other structures, closed forms, folds, wrong calls.
set -u
. tests/support/tap.sh

# study K2 ENERGY REST: the article's masses with this second stiffness
study() {
    printf 'model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[%s, %s], [%s, %s]]\n  contacts: [%s]\n%s\n' "$(python3 -c "print(8 + $1)")" "-$1" "-$1" "$1" \
        "${3:-{normal: [-1, 1], clearance: 1\}}" "explore: {energy: [0, $2], frequency: [0.2, 10], impacts: 8, multiply: 3, depth: 3}"
}
vary='vary: {name: k2, at: 1, from: 0.4, to: 1.6, stiffness: [[1, -1], [-1, 1]]}'
{ study 1 30; echo "$vary"; } >"$folder/v.yaml"
ok "an atlas with a section vary" "$ricochet" run "$folder/v.yaml" -o "$folder/v.ricochet" --quiet
for k in 0.6 1.3; do
    study "$k" 60 >"$folder/w.yaml"
    ok "an atlas at $k" "$ricochet" run "$folder/w.yaml" -o "$folder/w$k.ricochet" --quiet
done

cat >"$folder/judge.py" <<'P'
import json, math, subprocess, sys
program, folder = sys.argv[1:3]
def ask(*words):
    done = subprocess.run([program, *words, "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
def locus(atlas, id, *words): return ask("locus", f"{folder}/{atlas}", "--junction", str(id), *words)
def near(row, rows):
    off = lambda j: abs(j["energy"] / row["energy"] - 1) + abs(j["frequency"] * j["multiple"] / row["frequency"] - 1)
    best = min(rows, key=off)
    return best["kind"], off(best)

def against_atlases():
    "every junction that has a locus, at two other values: most are in the atlases made there, at the same place"
    others = {k: ask("junctions", f"{folder}/w{k}.ricochet") for k in ("0.6", "1.3")}
    mine = {(j["kind"], j["label"]): j for j in ask("junctions", f"{folder}/v.ricochet")}
    kinds, found, asked = set(), 0, 0
    branches = ask("branches", f"{folder}/v.ricochet")
    named = {b["label"]: b for b in branches if b["label"] in ("S2-[01]", "S2+[01]", "A1[0]", "S2[01]")}
    ids = sorted({i for b in named.values() for i in b["junctions"] + [b["from"], b["to"]] if i})
    for j in [j for j in mine.values() if j["id"] in ids and j["kind"] != "user"]:
        for row in locus("v.ricochet", j["id"], "--values", "0.6,1.3"):
            if row["mark"] != "asked": continue
            asked += 1
            kind, off = near(row, others["0.6" if row["value"] < 1 else "1.3"])
            if off < 1e-9 and kind == j["kind"]:
                found += 1
                kinds.add(kind)
    assert kinds >= {"grazing", "extremum", "branch-point", "multiplication"}, kinds
    assert found > 20 and found >= 0.8 * asked, (found, asked)

def closed_form():
    "grazings of the linear modes: E = omega^2 d^2 / (2 c^2)"
    for j in ask("junctions", f"{folder}/v.ricochet"):
        if j["kind"] != "grazing" or j["impacts"] or j["multiple"] > 1: continue
        rows = locus("v.ricochet", j["id"])
        assert len(rows) > 100 and rows[0]["mark"] == rows[-1]["mark"] == "end"
        for r in rows:
            k = r["value"]
            a, b = (8 + k) / 2 + k, ((8 + k) / 2) * k - k * k / 2
            root = math.sqrt(a * a - 4 * b)
            w2 = min(((a - root) / 2, (a + root) / 2), key=lambda w: abs(w - r["frequency"] ** 2))
            x = 1 - w2 / k if k else 0 # mass 1 over mass 2
            c2 = (1 - x) ** 2 / (2 * x * x + 1)
            assert abs(r["frequency"] ** 2 / w2 - 1) < 1e-12 and abs(r["energy"] / (w2 / (2 * c2)) - 1) < 1e-12, r

def orbits():
    "states are orbits of the structure with that value: the energy, and the stop where it is hit"
    j = next(j for j in ask("junctions", f"{folder}/v.ricochet") if j["kind"] == "branch-point" and j["word"] == "01")
    for r in locus("v.ricochet", j["id"]):
        k, (x1, x2, v1, v2) = r["value"], r["state"]
        energy = (2 * v1 * v1 + v2 * v2 + (8 + k) * x1 * x1 - 2 * k * x1 * x2 + k * x2 * x2) / 2
        assert abs(energy / r["energy"] - 1) < 1e-12 and abs(abs(x2 - x1) - 1) < 1e-12, r
        assert abs(2 * math.pi / sum(r["flights"]) / r["frequency"] - 1) < 1e-12 and r["residual"] < 1e-12

def fold():
    "two junctions annihilate each other: between two folds there are two more of them than beyond"
    id = "jmwpw360p" # a doubling of an orbit of eight impacts
    turns = [r["value"] for r in locus("v.ricochet", id) if r["mark"] == "fold"]
    assert len(turns) == 2 and max(turns) - min(turns) > 0.1, turns
    middle = sum(turns) / 2
    inside = [r for r in locus("v.ricochet", id, "--values", repr(middle)) if r["mark"] == "asked"]
    assert len({round(r["energy"], 9) for r in inside}) >= 2, inside
    for turn, side in ((max(turns), 1e-4), (min(turns), -1e-4)):
        beyond = [r for r in locus("v.ricochet", id, "--values", repr(turn + side)) if r["mark"] == "asked"]
        within = [r for r in locus("v.ricochet", id, "--values", repr(turn - side)) if r["mark"] == "asked"]
        assert len(within) == len(beyond) + 2, (id, turn, len(beyond), len(within))

def steps():
    "the same places whatever the step"
    j = next(j for j in ask("junctions", f"{folder}/v.ricochet") if j["kind"] == "multiplication" and j["multiple"] == 2)
    one, two = ([r for r in locus("v.ricochet", j["id"], "--values", "0.7,1.2", "--max-step", h) if r["mark"] != ""] for h in ("0.03", "0.01"))
    assert [r["mark"] for r in one] == [r["mark"] for r in two]
    for a, b in zip(one, two):
        if not a["what"].startswith("it is not"): assert abs(a["energy"] / b["energy"] - 1) < 1e-9, (a, b)

def law(name):
    "other laws, against an atlas of the structure at another value"
    other, rows = ask("junctions", f"{folder}/{name}1.ricochet"), []
    for j in ask("junctions", f"{folder}/{name}.ricochet"):
        done = subprocess.run([program, "locus", f"{folder}/{name}.ricochet", "--junction", str(j["id"]), "--values", "1.2", "--json"], capture_output=True, text=True)
        if done.returncode: continue
        rows += [(near(r, other)[1], j["label"]) for r in json.loads(done.stdout) if r["mark"] == "asked"]
    good = [off for off, label in rows if off < 1e-8]
    assert len(good) >= 3 and len(good) >= 0.7 * len(rows), rows

{f.__name__: f for f in (against_atlases, closed_form, orbits, fold, steps, law)}[sys.argv[3]](*sys.argv[4:])
P
judge() { python3 "$folder/judge.py" "$ricochet" "$folder" "$@"; }
ok "against atlases of other structures" judge against_atlases
ok "linear modes in closed form" judge closed_form
ok "states are orbits" judge orbits
ok "two junctions annihilate each other" judge fold
ok "whatever the step" judge steps
contact='{normal: [-1, 1], clearance: 1, law: bilinear, stiffness: 30}'
power='{normal: [-1, 1], law: power, exponent: 3, stiffness: 1}'
for law in bilinear power; do
    [ $law = power ] && contact=$power
    { study 1 12 "$contact" | sed 's/impacts: 8, multiply: 3, depth: 3/impacts: 4, multiply: 2, depth: 2/'; echo "$vary"; } >"$folder/$law.yaml"
    study 1.2 18 "$contact" | sed 's/impacts: 8, multiply: 3, depth: 3/impacts: 4, multiply: 2, depth: 2/' >"$folder/${law}1.yaml"
    for s in $law ${law}1; do "$ricochet" run "$folder/$s.yaml" -o "$folder/$s.ricochet" --quiet; done
    ok "law $law" judge law $law
done

# ends CODE WORDS ARGUMENT...: the exit code, and the message
ends() {
    local code=$1 words=$2 got=0
    shift 2
    "$ricochet" "$@" >"$folder/out" 2>"$folder/err" || got=$?
    [ "$got" = "$code" ] && grep -q -e "$words" "$folder/err"
}
ok "no junction named" ends 2 "junction is missing" locus "$folder/v.ricochet"
ok "a value outside the range" ends 2 "outside the range" locus "$folder/v.ricochet" --junction 11 --values 3
ok "no section vary" ends 2 "no section vary" locus "$folder/w0.6.ricochet" --junction 11
ok "one from a study of another structure" ends 2 "another structure" locus "$folder/w0.6.ricochet" --junction 11 --study "$folder/v.yaml"
ok "a step that is none" ends 2 "max-step" locus "$folder/v.ricochet" --junction 11 --max-step 0
# wrong WORDS SECTION
wrong() {
    { study 1 30; echo "$2"; } >"$folder/x.yaml"
    ends 2 "$1" check "$folder/x.yaml" && grep -q "x.yaml:[0-9]*: vary" "$folder/err"
}
ok "a range without the study" wrong "does not hold 0" "vary: {from: 1, to: 2, stiffness: [[1, 0], [0, 0]]}"
ok "nothing varies" wrong "nothing depends" "vary: {from: -1, to: 2, stiffness: [[0, 0], [0, 0]]}"
ok "a gap that closes" wrong "clearance of -1" "vary: {from: -2, to: 2, clearance: [1]}"
ok "too many gaps" wrong "list of 1 numbers" "vary: {from: -0.5, to: 2, clearance: [1, 2]}"
ok "a matrix of another size" wrong "3 x 3" "vary: {from: -1, to: 2, mass: [[1, 0, 0], [0, 0, 0], [0, 0, 0]]}"
ok "no range" wrong "missing" "vary: {to: 2, mass: [[1, 0], [0, 0]]}"
ok "a picture" "$ricochet" plot locus "$folder/v.ricochet" --junction 11 --junction 12 -o "$folder/l.svg"
ok "of frequencies" "$ricochet" plot locus "$folder/v.ricochet" --junction 11 --y frequency --hz -o "$folder/f.svg"
finish
