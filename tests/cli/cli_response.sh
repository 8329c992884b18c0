#!/usr/bin/env bash
# Curves of exact forced orbits from outside: numbers in closed form, the same in two ways, what is refused.
set -u
. tests/support/tap.sh

atlas="$folder/e.ricochet"
ok "an atlas" "$ricochet" run examples/elementary/study.yaml -o "$atlas" --quiet
before=$(cksum "$atlas")
curves() { "$ricochet" response "$atlas" --force 1,0 --damping 0.01 --omega 0.3,3.2 "$@"; }
# ends CODE WORDS ARGUMENT...: the exit code, and the message
ends() {
    local code=$1 words=$2 got=0
    shift 2
    "$ricochet" response "$@" >"$folder/out" 2>"$folder/err" || got=$?
    [ "$got" = "$code" ] && grep -q -e "$words" "$folder/err"
}
rows() { python3 -S - "$folder" <<END
import cmath, json, math, sys
def read(name): return json.load(open(sys.argv[1] + "/" + name))
$1
END
}

ok "a response" curves --level 0.2 -o "$folder/a" --json
"$ricochet" response "$folder/a" --json >"$folder/curves"
"$ricochet" response "$folder/a" --events --json >"$folder/events"
"$ricochet" response "$folder/a" --points --json >"$folder/points"
ok "the linear motion grazes where its closed form does" rows '
def gap(W, zeta=0.01, F=0.2):
    # modes of M = diag(2, 1), K = [[9, -1], [-1, 1]]
    a, b = 2.0, -(9 + 2.0)
    out = 0
    for lam in ((11 - math.sqrt(121 - 64)) / 4, (11 + math.sqrt(121 - 64)) / 4):
        x = (1.0, 9 - 2 * lam)
        norm = 2 * x[0] ** 2 + x[1] ** 2
        out += (x[1] - x[0]) * F * x[0] / norm / (lam - W * W + 2j * zeta * math.sqrt(lam) * W)
    return abs(out) - 1
def root(a, b):
    for _ in range(200):
        c = (a + b) / 2
        if (gap(a) > 0) == (gap(c) > 0): a = c
        else: b = c
    return a
grid = [0.3 + 2.9 * i / 4000 for i in range(4001)]
roots = [root(a, b) for a, b in zip(grid, grid[1:]) if (gap(a) > 0) != (gap(b) > 0)]
found = sorted(e["omega"] for e in read("events") if e["kind"] == "grazing")
assert len(roots) == 4 and len(found) == 4, (roots, found)
assert all(abs(a / b - 1) < 1e-11 for a, b in zip(roots, found)), (roots, found)'
ok "every end is a window, or an event that both curves name" rows '
curves = read("curves")
at = [c[k] for c in curves for k in ("from", "to") if c[k]]
grazing = [e["id"] for e in read("events") if e["kind"] == "grazing"]
assert all(at.count(i) == 2 for i in grazing), at
kinds = {e["id"]: e["kind"] for e in read("events")}
aside = [c for c in curves if c["begins"] == c["ends"] == "event"]
assert len(aside) == 1 and [kinds[aside[0][k]] for k in ("from", "to")] == ["branch-point"] * 2'
ok "curves are solved to rounding" rows 'assert all(p["residual"] < 1e-12 for p in read("points"))'
"$ricochet" force "$atlas" --force 1,0 --damping 0.01 --branch 3 --energy 1 --level 0.2 --exact --json >"$folder/exact"
ok "what force finds lies on a curve" rows '
for x in read("exact"):
    def apart(p): return abs(p["omega"] - x["omega"]) + max(abs(a - b) for a, b in zip(p["state"], x["state"]))
    assert min(apart(p) for p in read("points")) < 0.1'
ok "another step" curves --level 0.2 --step 0.02 -o "$folder/b"
"$ricochet" response "$folder/b" --events --json >"$folder/others"
ok "gives the same events" rows '
def of(name): return sorted((e["kind"], e["omega"]) for e in read(name) if e["kind"] in ("grazing", "fold") and not 1.38 < e["omega"] < 1.39)
assert len(of("events")) == len(of("others")) and all(a[0] == b[0] and abs(a[1] / b[1] - 1) < 1e-10 for a, b in zip(of("events"), of("others")))'
ok "branch points are located to rounding, a multiplier is 1 there" rows '
def of(name): return sorted((e["omega"], min(abs(complex(*m) - 1) for m in e["multipliers"])) for e in read(name) if e["kind"] == "branch-point")
a, b = of("events"), of("others")
assert len(a) >= 2 and len(a) == len(b) and all(abs(x[0] / y[0] - 1) < 1e-13 for x, y in zip(a, b)), (a, b)
assert all(x[1] < 1e-11 for x in a + b), (a, b)'
before_a=$(cksum "$folder/a")
ok "the same call once more" curves --level 0.2 -o "$folder/a"
ok "changes nothing" test "$before_a" = "$(cksum "$folder/a")"
ok "stopped after two tasks, the file goes on" bash -c "cp '$folder/a' '$folder/c' &&
    python3 -S -c \"
import sqlite3
c = sqlite3.connect('$folder/c')
keys = sorted(k for k, in c.execute('SELECT key FROM task') if k.startswith('event'))
c.execute(\\\"DELETE FROM task WHERE key LIKE 'event%'\\\")
c.execute('DELETE FROM curve WHERE begins = 4')
c.execute('DELETE FROM point WHERE curve NOT IN (SELECT id FROM curve)')
c.execute('DELETE FROM event WHERE curve NOT IN (SELECT id FROM curve)')
c.execute(\\\"DELETE FROM meta WHERE key = 'finished'\\\")
c.commit()\""
ok "and says that it is not finished" bash -c "'$ricochet' response '$folder/c' 2>&1 | grep -q 'not finished'"
ok "to the end" curves --level 0.2 -o "$folder/c"
"$ricochet" response "$folder/a" --points --csv >"$folder/points.a"
"$ricochet" response "$folder/c" --points --csv >"$folder/points.c"
ok "as if it had not been stopped" cmp "$folder/points.a" "$folder/points.c"
ok "along the level" "$ricochet" response "$atlas" --force 1,0 --damping 0.01 --along level --level 0.01,0.3 --omega 1.3 -o "$folder/level"
ok "along the restitution" "$ricochet" response "$atlas" --force 1,0 --damping 0.01 --along restitution --restitution 0.8,1 --omega 1.3 --level 0.3 -o "$folder/e"
ok "another force, the same file" ends 1 "another force.*name another file" "$atlas" --force 1,1 --damping 0.01 --omega 0.3,3.2 --level 0.2 -o "$folder/a"
ok "a file that is an atlas" ends 1 "not a response" "$atlas" --force 1,1 --damping 0.01 --omega 0.3,3.2 --level 0.2 -o "$atlas"
study() { printf 'model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts: [{normal: [-1, 1], clearance: 1}]\nexplore: {energy: [0, 10], depth: %s, impacts: 4}\n%s' "$1" "${2-}"; }
study 1 >"$folder/s.yaml"
"$ricochet" run "$folder/s.yaml" -o "$folder/s" --quiet
few() { "$ricochet" response "$folder/s" --force 1,0 --damping 0.01 --level 0.5 --omega 1,1.6 -o "$folder/s.response" "$@"; }
few --json >"$folder/before"
study 0 'damping: 0.3
' >"$folder/s.yaml"
"$ricochet" run "$folder/s.yaml" -o "$folder/s" --quiet
ok "a response goes on when the atlas has grown and its study has other keys" few --json
"$ricochet" response "$folder/s.response" --json >"$folder/after"
ok "with all that was there, and what the new branches lead to" rows '
before, after = read("before"), read("after")
assert len(after) > len(before) > 0
assert [(c["word"], c["points"], c["lowest"]) for c in before] == [(c["word"], c["points"], c["lowest"]) for c in after[:len(before)]]'
keys() { "$ricochet" branches "$folder/s" --json >"$folder/branches"; rows 'assert {c["branch"] for c in read("after") if c["branch"]} <= {b["id"] for b in read("branches")}'; }
ok "numbers of branches are those of the atlas" keys
sed 's/\[2, 0\]/[2.5, 0]/' "$folder/s.yaml" >"$folder/t.yaml"
"$ricochet" run "$folder/t.yaml" -o "$folder/t" --quiet
ok "another structure, the same file" ends 1 "another structure" "$folder/t" --force 1,0 --damping 0.01 --level 0.5 --omega 1,1.6 -o "$folder/s.response"
ok "a grazing at which an impact comes once in two periods" bash -c "printf 'model:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts: [{normal: [1], clearance: 1, sides: upper}]\nexplore: {energy: [0, 10], depth: 1, impacts: 2}\n' >'$folder/o.yaml' &&
    '$ricochet' run '$folder/o.yaml' -o '$folder/o' --quiet &&
    '$ricochet' response '$folder/o' --force 1 --damping 0.02 --restitution 0.9 --along level --level 0.02,0.6 --omega 0.81 --once-in 2 -o '$folder/once' --csv | grep -q '^[0-9]*,0,1,2,'"
cat >"$folder/springs.yaml" <<'END'
model:
  mass: [[2.4, 0], [0, 1.1]]
  stiffness: [[6, -1.2], [-1.2, 2.2]]
  contacts: [{normal: [-0.7, 1], clearance: 0.6, law: bilinear, stiffness: 9}]
explore: {impacts: 8, multiply: 2, depth: 2}
damping: [0.002, 0.0007]
forcing: {coordinate: 2, frequency: [1.1, 2.6], amplitude: 0.02}
END
"$ricochet" run "$folder/springs.yaml" -o "$folder/springs" --quiet 2>/dev/null
ok "flights so short that nothing changes in them are looked through" timeout 300 "$ricochet" response "$folder/springs" --impacts 4 -o "$folder/springs.response"
cat >"$folder/u.yaml" <<'END'
model:
  mass: [[1.3, 0], [0, 0.7]]
  stiffness: [[5.2, -1.9], [-1.9, 3.4]]
  contacts: [{normal: [1, 0], clearance: 0.8, sides: upper}]
explore: {impacts: 6, multiply: 2, depth: 1}
damping: {alpha: 0.002, beta: 0.001}
restitution: 0.996
forcing: {vector: [0.3, 1], frequency: [1.2, 3.4], amplitude: 0.03}
END
"$ricochet" run "$folder/u.yaml" -o "$folder/u" --quiet 2>/dev/null
"$ricochet" response "$folder/u" --impacts 4 -o "$folder/u.response" --json >"$folder/doubled"
"$ricochet" response "$folder/u.response" --events --json >"$folder/events"
ok "a curve of twice the period goes from one doubling to the other, once" rows '
twice = [c for c in read("doubled") if c["periods"] == 2]
kinds = {e["id"]: e["kind"] for e in read("events")}
assert len(twice) == 1 and twice[0]["begins"] == twice[0]["ends"] == "event" and twice[0]["from"] != twice[0]["to"]
assert kinds[twice[0]["from"]] == kinds[twice[0]["to"]] == "doubling"'
ok "what its multipliers do between two steps is found" rows '
twice = next(c["id"] for c in read("doubled") if c["periods"] == 2)
on = [(e["kind"], e["omega"]) for e in read("events") if e["curve"] == twice]
assert sorted(k for k, _ in on) == ["fold", "neimark-sacker"]
assert all(abs(w - {"fold": 1.9097161666108944, "neimark-sacker": 1.9097153088666878}[k]) < 1e-12 for k, w in on)'
cat >"$folder/three.yaml" <<'END'
model:
  mass: [[1.1, 0.1, 0], [0.1, 0.9, 0], [0, 0, 1.6]]
  stiffness: [[7, -2, 0], [-2, 5, -1.5], [0, -1.5, 4]]
  contacts:
    - {normal: [-1, 1, 0], clearance: 1.7}
    - {normal: [0, 0, 1], clearance: 2.5, sides: lower}
explore: {impacts: 4, multiply: 2, depth: 2}
damping: [[0.012, -0.004, 0.001], [-0.004, 0.01, -0.003], [0.001, -0.003, 0.009]]
restitution: 0.99
forcing: {vector: [0, 0.4, 1], frequency: [2.3, 2.4], amplitude: 0.3}
END
"$ricochet" run "$folder/three.yaml" -o "$folder/three" --quiet 2>/dev/null
"$ricochet" response "$folder/three" --impacts 2 --periods 1 --most-curves 8 -o "$folder/three.response" >/dev/null
for file in a u three; do
    "$ricochet" response "$folder/$file$([ $file = a ] || echo .response)" --events --json >"$folder/said"
    ok "multipliers at the events of $file are what the events say" rows '
target = {"fold": 1, "branch-point": 1, "doubling": -1}
grazing = [e["omega"] for e in read("said") if e["kind"] == "grazing"]
assert grazing
for e in read("said"):
    if e["kind"] not in target: continue
    assert e["multipliers"][0][0] is not None, e
    assert min(abs(complex(*m) - target[e["kind"]]) for m in e["multipliers"]) < 1e-4, e'
done
cat >"$folder/f.yaml" <<'END'
model:
  mass: [[1, 0, 0, 0, 0], [0, 1.2, 0, 0, 0], [0, 0, 0.9, 0, 0], [0, 0, 0, 1.4, 0], [0, 0, 0, 0, 0.7]]
  stiffness: [[3.1, -1, 0, 0, 0], [-1, 2.5, -1.2, 0, 0], [0, -1.2, 2.9, -1, 0], [0, 0, -1, 2.4, -0.8],
              [0, 0, 0, -0.8, 1.9]]
  contacts: [{normal: [0, 0, 0, 0, 1], clearance: 0.4}]
explore: {start: [2], impacts: 2, multiply: 1, depth: 1}
damping: 0.0015
restitution: 0.998
forcing: {coordinate: 1, frequency: [1.2, 1.27], amplitude: 0.02}
END
"$ricochet" run "$folder/f.yaml" -o "$folder/f" --quiet 2>/dev/null
"$ricochet" response "$folder/f" --impacts 2 --branch "$("$ricochet" branches "$folder/f" --json | python3 -S -c 'import json, sys
print(next(b["id"] for b in json.load(sys.stdin) if b["symmetric"] and b["impacts"] == 2))')" -o "$folder/f.response" --json >"$folder/aside"
ok "a curve that has lost a symmetry goes from one branch point to the other, once" rows '
a, b = read("aside")
assert (b["begins"], b["ends"]) == ("event", "event") and 0 < b["from"] < b["to"] and a["ends"] == "window"'
ok "no file" ends 2 "-o FILE is missing" "$atlas" --force 1,0 --damping 0.01 --omega 1,2 --level 0.2
ok "a negative damping" ends 2 negative "$atlas" --force 1,0 --damping -0.01 --omega 1,2 --level 0.2 -o "$folder/n"
ok "a force of the wrong length" ends 2 "3 numbers" "$atlas" --force 1,0,0 --damping 0.01 --omega 1,2 --level 0.2 -o "$folder/n"
ok "restitution 0" ends 2 "restitution 0" "$atlas" --force 1,0 --restitution 0 --omega 1,2 --level 0.2 -o "$folder/n"
ok "a window the wrong way round" ends 2 "two numbers" "$atlas" --force 1,0 --damping 0.01 --omega 2,1 --level 0.2 -o "$folder/n"
ok "a restitution of springs" ends 2 "no contact of this structure is rigid" "$folder/springs" --along restitution --restitution 0.5,1 --omega 1.7 -o "$folder/n"
ok "restitutions from 0 on" ends 2 "above 0.*at most 1" "$atlas" --force 1,0 --damping 0.01 --along restitution --restitution 0,1 --omega 1.2 --level 0.2 -o "$folder/n"
ok "no level" ends 2 "level" "$atlas" --force 1,0 --damping 0.01 --omega 1,2 -o "$folder/n"
ok "nothing is written by what is refused" test ! -e "$folder/n"
ok "a window with no orbit" ends 1 "no forced orbit" "$atlas" --force 1,0 --damping 0.01 --omega 1,1.1 --level 0.0001 --branch 3 -o "$folder/none"
ok "and leaves no file" test ! -e "$folder/none"
touch "$folder/there"
ok "a file that was there stays" ends 1 "no forced orbit" "$atlas" --force 1,0 --damping 0.01 --omega 1,1.1 --level 0.0001 --branch 3 -o "$folder/there"
ok "and another call takes it" "$ricochet" response "$atlas" --force 1,0 --damping 0.01 --level 0.2 --omega 1.2,1.3 -o "$folder/there"
ok "which then is kept from others" ends 1 "another force" "$atlas" --force 1,0 --damping 0.01 --omega 1,1.1 --level 0.0001 --branch 3 -o "$folder/there"
head -c 9000 "$folder/a" >"$folder/broken"
ok "a file that was cut" ends 1 "not a response" "$folder/broken"
ok "another program confirms the orbits" "$ricochet" verify "$folder/a" --quiet
python3 -S - "$folder" <<'END'
import sqlite3, struct, sys
c = sqlite3.connect(sys.argv[1] + "/c")
curve, i, numbers = c.execute("SELECT curve, i, numbers FROM point WHERE curve = 3 AND i = 0").fetchone()
x = list(struct.unpack("<%dd" % (len(numbers) // 8), numbers))
x[2] += 1e-7
c.execute("UPDATE point SET numbers = ? WHERE curve = ? AND i = ?", (struct.pack("<%dd" % len(x), *x), curve, i))
c.commit()
END
ok "and not one that was changed" bash -c "'$ricochet' verify '$folder/c' --quiet 2>'$folder/err'; test \$? = 1 && grep -q '1 of .* are not confirmed' '$folder/err'"
cat >"$folder/spring.yaml" <<'END'
model:
  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 2]]
  stiffness: [[3, -1, 0], [-1, 2, -1], [0, -1, 2]]
  contacts:
    - {normal: [1, 0, 0], clearance: 0.3, sides: lower, law: rigid}
    - {normal: [0, -1, 1], clearance: 0.4, sides: upper, law: bilinear, stiffness: 5}
explore: {energy: [0, 20], impacts: 5, depth: 1, multiply: 2}
END
"$ricochet" run "$folder/spring.yaml" -o "$folder/spring.ricochet" >/dev/null 2>&1
"$ricochet" response "$folder/spring.ricochet" --force 0,1,0 --damping 0.01 --level 0.2 --omega 1.19,1.42 --impacts 1 --periods 1 \
    -o "$folder/slow" >"$folder/slow.txt" 2>/dev/null
ok "a curve ends where a spring closes at 2e-6" grep -q '^ *[0-9]*  1 .*grazing  *grazing' "$folder/slow.txt"
ok "the times of such slow closings are known less well, and its orbits are confirmed" "$ricochet" verify "$folder/slow" --all --quiet
ok "a picture" "$ricochet" plot response "$folder/a" --output x2 -o "$folder/a.svg"
ok "says what it shows" bash -c "grep -q grazing '$folder/a.svg' && grep -q 'with impacts, stable' '$folder/a.svg'"
"$ricochet" plot response "$folder/u.response" --output x1 --window 1.9094:1.9099,1.05:1.08 -o "$folder/u.gp"
ok "a curve is drawn stable up to the doubling, not to a point" python3 -S - "$folder" <<'END'
import json, re, sys
text = open(sys.argv[1] + "/u.gp").read()
block = re.search(r"(\$l\d+) with lines [^\n]*title 'symmetric, stable'", text).group(1)
lines = text.split(block + " << EOD\n")[1].split("EOD")[0].split("\n\n")
ends = [[tuple(map(float, row.split())) for row in part.splitlines() if row] for part in lines]
left = [e for e in ends if e and min(x for x, _ in e) < 79]
at = [e["omega"] for e in json.load(open(sys.argv[1] + "/events")) if e["kind"] == "doubling" and e["stable"] == "undecided"]
assert len(left) == len(at) == 1, (left, at)
scale = (706 - 78) / 0.0005
assert abs(max(x for x, _ in left[0]) - (78 + (at[0] - 1.9094) * scale)) < 0.1, left
END
ok "no displacement" bash -c "! '$ricochet' plot response '$folder/a' --output x3 -o '$folder/b.svg' 2>/dev/null && ! test -e '$folder/b.svg'"

# A rotor between two bearings: beside a branch point at which Newton's method does not come to an end
bearing='law: rigid, clearance: 1000, sides: both'
printf '%s\n' 'model:' '  mass: [[30000, 0, 0, 0, 0], [0, 27500, 0, 0, 0], [0, 0, 20000, 0, 0], [0, 0, 0, 27500, 0], [0, 0, 0, 0, 30000]]' \
    '  stiffness: [[13000, -8500, 0, 0, 0], [-8500, 18750, -10250, 0, 0], [0, -10250, 20500, -10250, 0],' \
    '              [0, 0, -10250, 18750, -8500], [0, 0, 0, -8500, 13000]]' \
    "  contacts: [{normal: [1, 0, 0, 0, 0], $bearing}, {normal: [0, 0, 0, 0, 1], $bearing}]" \
    'explore: {start: [1], impacts: 2, multiply: 1, depth: 1}' >"$folder/rotor.yaml"
"$ricochet" run "$folder/rotor.yaml" -o "$folder/rotor.ricochet" --quiet
"$ricochet" response "$folder/rotor.ricochet" --force 0.642,0.503,0.763,-0.939,0.384 --damping 0.001 --restitution 0.97 \
    --omega 0.14,0.21 --level 2050000 --impacts 2 --periods 1 --most-curves 7 -o "$folder/rotor" --json >"$folder/curves"
ok "a curve that lost a symmetry ends at the next branch point, and does not come back on its mirror image" rows '
curves = [c for c in read("curves") if c["word"] == "01" and 0.2065 < c["lowest"] and c["highest"] < 0.2068]
assert len(curves) == 1 and curves[0]["ends"] == "event" and curves[0]["to"], curves'

# A spring of fifth power that is a hundred times as stiff as the structure: flights are faster than the mode.
printf '%s\n' 'model:' '  mass: [[1]]' '  stiffness: [[1]]' '  contacts: [{normal: [1], law: power, exponent: 5, stiffness: 200}]' \
    'explore: {energy: [0.001, 20], impacts: 2, depth: 1}' >"$folder/fifth.yaml"
"$ricochet" run "$folder/fifth.yaml" -o "$folder/fifth.ricochet" --quiet
"$ricochet" response "$folder/fifth.ricochet" --force 1 --damping 0.01 --level 4 --omega 0.6,1.5 --most-points 40 --most-curves 1 -o "$folder/fifth" >/dev/null
"$ricochet" response "$folder/fifth" --points --json >"$folder/points"
flown() { # what the simulator, which takes steps of its own, makes of a point that is drawn from those with a large peak
    python3 -S - "$folder" "$ricochet" <<'END'
import json, math, subprocess, sys
folder, program = sys.argv[1:]
p = max(json.load(open(folder + "/points")), key=lambda p: p["peak"][0])
rows = json.loads(subprocess.run([program, "simulate", folder + "/fifth.yaml", "--state", *map(repr, p["state"]), "--time", repr(p["period"]),
    "--steps", "1000", "--force", "1", "--omega", repr(p["omega"]), "--level", repr(p["level"]), "--phase", repr(p["phase"]),
    "--damping", "0.01", "--json"], stdout=subprocess.PIPE, check=True).stdout)
x = [r["x1"] for r in rows]
assert len(x) == 1001 and abs(x[0] - x[-1]) < 1e-9, (len(x), x[0], x[-1])
rms = math.sqrt(sum(y * y for y in x[1:]) / 1000)
assert abs(rms - p["rms"][0]) < 1e-9 * rms, (rms, p["rms"])
END
}
ok "the root of the mean square, where a spring is steep" flown
nowhere() { ends 1 "no branch 99" "$atlas" --force 1,0 --damping 0.01 --level 0.2 --omega 1,2 --branch 99 -o "$folder/nowhere" && [ ! -e "$folder/nowhere" ]; }
ok "a branch that is not there leaves no file" nowhere
ok "a file that is not there" ends 2 "no such file" "$folder/none.response" --points

# A stop between two others: the next impact turns the first mass round before its gap has a maximum within the flight.
cat >"$folder/corner.yaml" <<'END'
model:
  mass: [[1, 0], [0, 1]]
  stiffness: [[3, 0], [0, 2]]
  contacts:
    - {normal: [1, 0], law: rigid, clearance: 0.00181, sides: both}
    - {normal: [-1, 1], law: rigid, clearance: 0.00181, sides: upper}
explore: {energy: [0, 7.908], frequency: [0.2828, 5.196], impacts: 4, depth: 1}
END
ok "an atlas with two stops" "$ricochet" run "$folder/corner.yaml" -o "$folder/c.ricochet" --quiet
ok "its forced motions" "$ricochet" response "$folder/c.ricochet" --force 0.909,-0.916 --damping 0.01 --level 0.0002715 --omega 1.7,1.9 \
    --impacts 4 --most-curves 12 -o "$folder/cornered"
"$ricochet" response "$folder/cornered" --points --json >"$folder/corners"
ok "no motion passes a stop at the instant of another impact" rows '
points = read("corners")
assert len({p["curve"] for p in points}) > 3 and max(p["peak"][0] for p in points) < 1 + 1e-9'

ok "the atlas is what it was" test "$before" = "$(cksum "$atlas")"
finish
