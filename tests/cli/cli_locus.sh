#!/usr/bin/env bash
# Loci of junctions from outside: against atlases of other structures, closed forms, folds, wrong calls.
set -u
. tests/support/tap.sh

# study K2 ENERGY REST: the article's masses with this second stiffness
study() {
    printf 'model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[%s, %s], [%s, %s]]\n  contacts: [%s]\n%s\n' "$(python3 -S -c "print(8 + $1)")" "-$1" "-$1" "$1" \
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

def modes(k):
    "of M = diag(2, 1), K = [[8 + k, -k], [-k, k]]: frequencies, and what the gap has of them"
    b, root = 8 + 3 * k, math.sqrt((8 + 3 * k) ** 2 - 64 * k)
    out = []
    for lam in ((b - root) / 4, (b + root) / 4):
        x = (8 + k - 2 * lam) / k
        out.append((math.sqrt(lam), (x - 1) / math.sqrt(2 + x * x)))
    return out

def largest(gap, speed, end):
    "the largest |gap| inside, where the speed is 0"
    n, best = 2000, 0
    for i in range(4, n - 4):
        a, b = end * i / n, end * (i + 1) / n
        if speed(a) * speed(b) > 0: continue
        for _ in range(100):
            c = (a + b) / 2
            if speed(a) * speed(c) <= 0: b = c
            else: a = c
        best = max(best, abs(gap(a)))
    return best

def ends_at(id):
    rows = [r for r in locus("v.ricochet", id) if r["mark"] == "end" and r["what"] == "another gap touches, too"]
    assert rows, id
    return [(r["value"], 2 * math.pi / r["frequency"], r["energy"]) for r in rows]

def codimension_two():
    "ends at which something else touches, too, in closed form"
    def two(id, order): # [01] out of its centre: flights of half a period, q_i ~ sin(omega_i (t - tau / 2))
        for k, T, E in ends_at(id):
            tau, m = T / 2, modes(k)
            A = 1 / sum(c * c * math.tan(w * tau / 2) / w for w, c in m)
            gap = lambda t: -A * sum(c * c * math.sin(w * (t - tau / 2)) / (w * math.cos(w * tau / 2)) for w, c in m)
            speed = lambda t: -A * sum(c * c * math.cos(w * (t - tau / 2)) / math.cos(w * tau / 2) for w, c in m)
            energy = A * A * sum(c * c / math.cos(w * tau / 2) ** 2 for w, c in m) / 2
            assert abs(energy / E - 1) < 1e-11 and abs(largest(gap, speed, tau) - 1) < 1e-10, (id, k)
            # -1 times half a period: a flight, and the impact by which it ends; two of four values are 1
            n, cc = range(2), sum(c * c for _, c in m)
            q = [-A * c * math.sin(w * tau / 2) / (w * math.cos(w * tau / 2)) for w, c in m]
            pull = sum(-c * w * w * x for (w, c), x in zip(m, q))
            cp = -A * sum(c * c for _, c in m)
            fly = [[math.cos(w * tau), math.sin(w * tau) / w, -w * math.sin(w * tau), math.cos(w * tau)] for w, _ in m]
            trace = 0
            for i in n: # diagonal of S F
                for j in n:
                    R = (i == j) - 2 * m[i][1] * m[j][1] / cc
                    bend = 2 * m[i][1] * pull / cc * m[j][1] / cp
                    if i == j: trace += R * (fly[j][0] + fly[j][3]) + bend * fly[j][1]
            assert min(abs(-trace - 2 - s * 2 * math.cos(math.pi * p / order)) for p in range(1, order) for s in (1, -1)) < 1e-9, (id, k, trace)
    two("jamh8hj0h", 2) # a doubling of S2
    two("ja1rbthgd", 3) # and a tripling
    for k, T, E in ends_at("jqj8nbaqt"): # an extremum of A1[0]: one flight, q_i ~ cos(omega_i (t - T / 2))
        m = modes(k)
        def energy(T):
            a = 1 / sum(c * c / math.tan(w * T / 2) / w for w, c in m)
            return a * a * sum(c * c / math.sin(w * T / 2) ** 2 for w, c in m) / 2
        a = 1 / sum(c * c / math.tan(w * T / 2) / w for w, c in m)
        gap = lambda t: a * sum(c * c * math.cos(w * (t - T / 2)) / (w * math.sin(w * T / 2)) for w, c in m)
        speed = lambda t: -a * sum(c * c * math.sin(w * (t - T / 2)) / math.sin(w * T / 2) for w, c in m)
        assert abs(energy(T) / E - 1) < 1e-11 and abs(largest(gap, speed, T) - 1) < 1e-10
        assert abs(energy(T * (1 + 1e-5)) - energy(T * (1 - 1e-5))) < 1e-11 * E, "dE/dT"

def commensurate():
    "where modes are commensurate a curve ends, and that place is told: omega_2 = 3 omega_1, and 7 : 3"
    for id, p, q in (("j1y7c6gyb", 3, 1), ("jpr864d85", 3, 1), ("js5atyk7t", 7, 3)):
        whats = [r["what"] for r in locus("v.ricochet", id) if r["mark"] == "end"]
        said = [w for w in whats if f"modes 1 and 2 are commensurate, {q} to {p}, where the parameter is" in w]
        assert said, whats
        (one, _), (two, _) = modes(float(said[0].split()[-1]))
        assert abs(two / one - p / q) < 1e-12, said

def speed_lost():
    "where an impact loses its speed, and functions turn too sharply to be followed, the parameter is told: two junctions end at one"
    places = []
    for id in ("jy8w37s54", "jt1xvv4pa"):
        whats = [r["what"] for r in locus("v.ricochet", id) if r["mark"] == "end"]
        said = [w for w in whats if "an impact loses its speed, of which" in w]
        assert len(said) == 1, whats
        words = said[0].split()
        places.append((float(words[-3]), float(words[-1])))
    (one, off), (two, other) = places
    assert 0 < off < 1e-6 and 0 < other < 1e-6 and abs(one - two) < off + other, places
    assert abs(one - 0.9107196586) < 1e-8, places

def factor_of_four():
    "C_33 of S2- and the branch point of S2+ that is the article's C1_32 at 20 values, a factor of four, and in atlases made there"
    long_form = sys.argv[4] == "1"
    values = [0.4 * 4 ** (i / 19) for i in range(19)] + [1.6]
    chosen = values if long_form else [values[3], values[12]]
    for k in chosen:
        with open(f"{folder}/f.yaml", "w") as f:
            f.write(f"model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[{8 + k!r}, {-k!r}], [{-k!r}, {k!r}]]\n  contacts: [{{normal: [-1, 1], clearance: 1}}]\n"
                    "explore: {energy: [0, 60], frequency: [0.1, 12], impacts: 2, multiply: 3, depth: 1}\n")
        subprocess.run([program, "run", f"{folder}/f.yaml", "-o", f"{folder}/f{k!r}.ricochet", "--quiet"], check=True)
    for id, kind, multiple in (("jbezjyx5e", "multiplication", 3), ("js6sykkwf", "multiplication", 2), ("j9mf41qkm", "multiplication", 3), ("jna6p8eac", "branch-point", 1)):
        rows = locus("v.ricochet", id, "--values", ",".join(map(repr, values)))
        assert {r["value"] for r in rows} >= set(values), id
        for k in chosen:
            row = next(r for r in rows if r["value"] == k)
            there = [j for j in ask("junctions", f"{folder}/f{k!r}.ricochet") if (j["kind"], j["multiple"], j["word"]) == (kind, multiple, "01")]
            assert near(row, there)[1] < 1e-9, (id, k, near(row, there))

def annihilation():
    "two branch points of an orbit of eight impacts meet: on one side of the fold an atlas made there has both, on the other none"
    id = "jmmrggzda"
    turn = next(r["value"] for r in locus("v.ricochet", id) if r["mark"] == "fold")
    for k, wanted in ((turn + 2e-3, 2), (turn - 2e-3, 0)):
        with open(f"{folder}/n.yaml", "w") as f:
            f.write(f"model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[{8 + k!r}, {-k!r}], [{-k!r}, {k!r}]]\n  contacts: [{{normal: [-1, 1], clearance: 1}}]\n"
                    "explore: {energy: [0, 12], frequency: [0.2, 10], impacts: 8, multiply: 3, depth: 3}\n")
        subprocess.run([program, "run", f"{folder}/n.yaml", "-o", f"{folder}/n{wanted}.ricochet", "--quiet"], check=True)
        there = [j for j in ask("junctions", f"{folder}/n{wanted}.ricochet") if (j["kind"], j["word"]) == ("branch-point", "01010101") and 1.6 < j["energy"] < 1.7]
        rows = [r for r in locus("v.ricochet", id, "--values", repr(k)) if r["mark"] == "asked"]
        assert len(there) == len(rows) == wanted, (k, there, rows)
        assert all(near(r, there)[1] < 1e-9 for r in rows), rows

{f.__name__: f for f in (annihilation, against_atlases, closed_form, orbits, fold, steps, law, codimension_two, commensurate, speed_lost, factor_of_four)}[sys.argv[3]](*([] if sys.argv[3] == "factor_of_four" else sys.argv[4:]))
P
judge() { python3 -S "$folder/judge.py" "$ricochet" "$folder" "$@"; }
ok "against atlases of other structures" judge against_atlases
ok "linear modes in closed form" judge closed_form
ok "states are orbits" judge orbits
ok "two junctions annihilate each other" judge fold
ok "and so say atlases made on either side" judge annihilation
ok "ends of codimension two" judge codimension_two
ok "commensurate modes" judge commensurate
ok "an impact that loses its speed" judge speed_lost
# A third mass hangs on nothing that the contact sees: its mode lies between the two that the curve belongs to.
printf 'model:\n  mass: [[2, 0, 0], [0, 1, 0], [0, 0, 1]]\n  stiffness: [[9, -1, 0], [-1, 1, 0], [0, 0, 2.1]]\n  contacts: [{normal: [-1, 1, 0], clearance: 1}]
explore: {energy: [0, 12], frequency: [0.2, 10], impacts: 2, multiply: 3, depth: 3}
vary: {name: k2, at: 1, from: 0.4, to: 1.6, stiffness: [[1, -1, 0], [-1, 1, 0], [0, 0, 0]]}\n' >"$folder/third.yaml"
seen() { "$ricochet" run "$folder/third.yaml" -o "$folder/third.ricochet" --quiet && "$ricochet" locus "$folder/third.ricochet" --junction j1y7c6gyb --csv >"$folder/third" 2>&1 && grep 'modes 1 and 3 are commensurate, 1 to 3, where the parameter is 0.5112790290120' "$folder/third"; }
ok "of those that the contact sees" seen
ok "a factor of four" judge factor_of_four "$(some_of 0 1)"
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

# A grazing ends where another gap touches, too: both do there, flown in closed form.
cat >"$folder/g.yaml" <<'END'
model:
  mass: [[1, 0], [0, 1]]
  stiffness: [[3, -1], [-1, 2]]
  contacts: [{normal: [1, 0], clearance: 1, sides: both, law: rigid}, {normal: [0, 1], clearance: 0.8, sides: both, law: rigid}]
explore: {energy: [0, 20], frequency: [0.2, 6], impacts: 4, multiply: 1, depth: 1}
vary: {name: d, at: 1, from: 0.4, to: 1.9, clearance: [0, 1]}
END
cat >"$folder/both.py" <<'P'
import json, math, subprocess, sys
program, folder = sys.argv[1:]
rows = json.loads(subprocess.run([program, "locus", f"{folder}/g.ricochet", "--junction", "G1_1,1", "--json"], capture_output=True, text=True).stdout)
end = next(r for r in rows if "another gap" in r["what"])
d, T, (x1, x2, v1, v2) = 0.8 + end["value"] - 1, sum(end["flights"]), end["state"]
root = math.sqrt(5) / 2
modes = []
for square in (2.5 - root, 2.5 + root): # of [[3, -1], [-1, 2]]
    a, b = 1, 3 - square
    size, w = math.hypot(a, b), math.sqrt(square)
    a, b = a / size, b / size
    modes.append((w, a, b, a * x1 + b * x2, (a * v1 + b * v2) / w))
def x(t, i):
    return sum(m[1 + i] * (m[3] * math.cos(m[0] * t) + m[4] * math.sin(m[0] * t)) for m in modes)
def most(i, sign):
    n = 20000
    k = max(range(1, n), key=lambda k: sign * x(k * T / n, i))
    lo, hi = (k - 1) * T / n, (k + 1) * T / n
    for _ in range(60):
        a, b = lo + (hi - lo) * 0.381966, hi - (hi - lo) * 0.381966
        lo, hi = (a, hi) if sign * x(a, i) < sign * x(b, i) else (lo, b)
    return sign * x(lo, i)
first, second = max(most(0, 1), most(0, -1)), most(1, -1) / d
assert abs(first - 1) < 1e-11 and abs(second - 1) < 1e-11, (end["value"], first - 1, second - 1)
P
ok "an atlas of two walls" "$ricochet" run "$folder/g.yaml" -o "$folder/g.ricochet" --quiet
ok "where a second gap touches both do" python3 -S "$folder/both.py" "$ricochet" "$folder"

# ends CODE WORDS ARGUMENT...: the exit code, and the message
ends() {
    local code=$1 words=$2 got=0
    shift 2
    "$ricochet" "$@" >"$folder/out" 2>"$folder/err" || got=$?
    [ "$got" = "$code" ] && grep -q -e "$words" "$folder/err"
}
ok "no junction named" ends 2 "junction is missing" locus "$folder/v.ricochet"
ok "a value outside the range" ends 2 "outside the range" locus "$folder/v.ricochet" --junction 11 --values 3
cat >"$folder/k.yaml" <<'END'
model:
  mass: [[1.25, 0, 0], [0, 0.5, 0], [0, 0, 0.25]]
  stiffness: [[8, -5.5, 0], [-5.5, 11.75, -6.25], [0, -6.25, 7.25]]
  contacts:
    - {normal: [0, 1, 0], law: bilinear, clearance: 1.7, sides: both, stiffness: 1960000}
    - {normal: [1, 0, 0], law: rigid, clearance: 1.16, sides: upper}
explore: {energy: [0, 5], frequency: [0.2619, 20.05], impacts: 4, multiply: 1, depth: 1}
vary: {name: k, at: 1, from: 0.7, to: 1.3, stiffness: [[0, 0, 0], [0, 0, 0], [0, 0, 2.9]]}
END
ok "an atlas with a corner of one impact" "$ricochet" run "$folder/k.yaml" -o "$folder/k.ricochet" --quiet
ok "a corner without a flight that vanishes" ends 2 "no flight between them vanishes" locus "$folder/k.ricochet" --junction K1
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
ok "too many gaps" wrong "list of 1 number," "vary: {from: -0.5, to: 2, clearance: [1, 2]}"
ok "a matrix of another size" wrong "3 x 3" "vary: {from: -1, to: 2, mass: [[1, 0, 0], [0, 0, 0], [0, 0, 0]]}"
ok "no range" wrong "missing" "vary: {to: 2, mass: [[1, 0], [0, 0]]}"
ok "a picture" "$ricochet" plot locus "$folder/v.ricochet" --junction 11 --junction 12 -o "$folder/l.svg"
ok "of frequencies" "$ricochet" plot locus "$folder/v.ricochet" --junction 11 --y frequency --hz -o "$folder/f.svg"
finish
