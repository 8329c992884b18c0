#!/usr/bin/env bash
# Structures in units of their own, without a window in the study: the first run gives a picture with impacts, soon; and what check and run say where
# windows hold nothing.
set -u
. tests/support/tap.sh

cat >"$folder/chain.yaml" <<'Y'
title: Three masses in a row, mm t s
model:
  mass: [[0.001, 0, 0], [0, 0.002, 0], [0, 0, 0.001]]
  stiffness: [[700, -500, 0], [-500, 1000, -500], [0, -500, 600]]
  contacts:
    - {normal: [0, 1, 0], clearance: 0.25}
Y
cat >"$folder/cubic.yaml" <<'Y'
title: Two masses and a cubic spring
model:
  mass: [[1, 0], [0, 1]]
  stiffness: [[2, -1], [-1, 2]]
  contacts:
    - {normal: [1, 0], law: power, exponent: 3, stiffness: 0.5}
Y
cat >"$folder/gear.yaml" <<'Y'
title: A loose gear on one that is held by a spring, SI
model:
  mass: [[1, 0], [0, 0.3]]
  stiffness: [[5.0e+4, 0], [0, 0]]
  contacts:
    - {normal: [1, -1], clearance: 1.0e-3}
Y
cat >"$folder/free.yaml" <<'Y'
title: A free mass between two stops
model:
  mass: [[0.3]]
  stiffness: [[0]]
  contacts:
    - {normal: [1], clearance: 1.0e-3}
Y
cat >"$folder/one.yaml" <<'Y'
title: An impact oscillator, SI
model:
  mass: [[0.5]]
  stiffness: [[2000]]
  contacts:
    - {normal: [1], clearance: 1.0e-3, sides: upper}
Y
# A drone's arm: a tube of carbon, clamped, five beam elements, a mass at its tip, which meets a bumper. SI, Matrix Market files as a finite-element
# program writes them.
python3 -S - "$folder" <<'P'
import math, sys
folder, L, elements, E, rho = sys.argv[1], 0.25, 5, 70e9, 1600
I, A, h = math.pi / 64 * (0.016**4 - 0.014**4), math.pi / 4 * (0.016**2 - 0.014**2), 0.05
k = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h], [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
m = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h], [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
n = 2 * elements
def assembled(element, factor):
    full = [[0.0] * (n + 2) for _ in range(n + 2)]
    for e in range(elements):
        for i in range(4):
            for j in range(4):
                full[2 * e + i][2 * e + j] += factor * element[i][j]
    return [row[2:] for row in full[2:]]
M, K = assembled(m, rho * A * h / 420), assembled(k, E * I / h**3)
M[n - 2][n - 2] += 0.08
for name, matrix in ("M", M), ("K", K):
    with open(f"{folder}/{name}.mtx", "w") as out:
        print("%%MatrixMarket matrix array real general", n, n, sep="\n", file=out)
        for j in range(n):
            for i in range(n):
                print(repr(matrix[i][j]), file=out)
tip = [int(i == n - 2) for i in range(n)]
print(f"title: A drone's arm\nmodel:\n  mass: {{file: M.mtx}}\n  stiffness: {{file: K.mtx}}\n  contacts:\n"
      f"    - {{normal: {tip}, clearance: 0.002, law: bilinear, stiffness: 2.0e+4}}", file=open(f"{folder}/drone.yaml", "w"))
P

# picture NAME BRANCHES: a run ends with at least so many branches that meet a contact, over a range of energies, whose middle points are replayed
picture() {
    "$ricochet" run "$folder/$1.yaml" >"$folder/said" 2>&1 || { cat "$folder/said"; return 1; }
    ! grep 'no orbit that meets' "$folder/said" || return 1
    "$ricochet" branches "$folder/$1.ricochet" --json >"$folder/branches.json" || return 1
    python3 -S - "$folder/branches.json" "$2" <<'P'
import json, sys
rows = [b for b in json.load(open(sys.argv[1])) if b["impacts"] or b["frequency_max"] > b["frequency_min"]]
print(len(rows), "branches that meet a contact,", sum(b["points"] for b in rows), "points")
assert len(rows) >= int(sys.argv[2])
assert max(b["energy_max"] for b in rows) > 8 * min(b["energy_min"] for b in rows)
P
    [ $? = 0 ] && grep 'orbits replayed' "$folder/said"
}
ok 'a chain in mm, t, s' picture chain 50
ok 'a drone arm of beam elements' picture drone 10
idle() { # modes on which nothing happens do not press the picture to its foot, and it says so
    "$ricochet" plot fep "$folder/drone.ricochet" -o "$folder/drone.svg" 2>"$folder/said" || return 1
    grep '9 linear modes touch no contact in the windows and are not shown, at 8796' "$folder/said" &&
        ! grep -q '678' "$folder/drone.svg" && "$ricochet" plot fep "$folder/drone.ricochet" --frequency 100:1e6 -o "$folder/drone.svg" 2>"$folder/said" &&
        ! grep 'not shown, at' "$folder/said"
}
ok 'a picture shows where something happens' idle
backbone() { # of the drone's arm goes from 460 to beyond 640 rad/s, and what it steps over has names
    "$ricochet" branches "$folder/drone.ricochet" --json | python3 -S -c '
import json, sys
rows = [b for b in json.load(sys.stdin) if b["label"] == "S2(1)[01]"]
print(rows)
assert len(rows) == 1 and rows[0]["frequency_min"] < 461 and rows[0]["frequency_max"] > 640 and "steps over" in str(rows[0]["tongues"])'
}
ok 'its backbone goes on behind internal resonances' backbone
# A frame of steel, 40 degrees of freedom, SI: columns of 4 m, a beam of 6 m, one foot on a hinge; with a stop or a bumper at a corner.
python3 -S - "$folder" <<'P'
import math, sys
E, A, I, rho, H, L = 210e9, 2.85e-3, 1.94e-5, 7850, 4.0, 6.0
nodes = [(0, H * i / 5) for i in range(6)] + [(L * i / 4, H) for i in range(1, 5)] + [(L, H - H * i / 5) for i in range(1, 6)]
n = 3 * len(nodes)
M, K = [[0.0] * n for _ in range(n)], [[0.0] * n for _ in range(n)]
for a in range(len(nodes) - 1):
    (x1, y1), (x2, y2) = nodes[a], nodes[a + 1]
    h = math.hypot(x2 - x1, y2 - y1)
    c, s = (x2 - x1) / h, (y2 - y1) / h
    k, m = [[0.0] * 6 for _ in range(6)], [[0.0] * 6 for _ in range(6)]
    bend = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h], [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
    mass = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h], [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
    for i, p in enumerate((1, 2, 4, 5)):
        for j, q in enumerate((1, 2, 4, 5)):
            k[p][q], m[p][q] = E * I / h**3 * bend[i][j], rho * A * h / 420 * mass[i][j]
    for p, q, sign in ((0, 0, 1), (0, 3, -1), (3, 0, -1), (3, 3, 1)):
        k[p][q], m[p][q] = sign * E * A / h, rho * A * h / 6 * (2 if p == q else 1)
    T = [[0.0] * 6 for _ in range(6)]
    for o in (0, 3):
        T[o][o], T[o][o + 1], T[o + 1][o], T[o + 1][o + 1], T[o + 2][o + 2] = c, s, -s, c, 1
    for i in range(6):
        for j in range(6):
            K[3 * a + i][3 * a + j] += sum(T[p][i] * k[p][q] * T[q][j] for p in range(6) for q in range(6))
            M[3 * a + i][3 * a + j] += sum(T[p][i] * m[p][q] * T[q][j] for p in range(6) for q in range(6))
for node in (5, 9):
    for i in range(2):
        M[3 * node + i][3 * node + i] += 500
keep = [i for i in range(n) if i not in (0, 1, 42, 43, 44)]
row = lambda f: "[" + ", ".join(map(str, f)) + "]"
for name, law in ("frame", ""), ("bumper", ", law: bilinear, stiffness: 2.0e+6"):
    with open(f"{sys.argv[1]}/{name}.yaml", "w") as out:
        print("model:\n  mass:", row(row(M[i][j] for j in keep) for i in keep), file=out)
        print("  stiffness:", row(row(K[i][j] for j in keep) for i in keep), file=out)
        print("  contacts:\n    - {normal:", row(int(i == 15) for i in keep) + ", clearance: 0.02" + law + "}", file=out)
P
if long_form; then ok 'a frame of 40 degrees of freedom and a stop' picture frame 20
else left_out 'a frame of 40 degrees of freedom and a stop' 'make long; with a bumper in the short form'
fi
ok 'a frame of 40 degrees of freedom and a bumper' picture bumper 2
goes_on() { # what a first look leaves out it says, and `points: 0` has it
    grep 'a first look: from 1100 points on' "$folder/said" && # of the run before
        { cat "$folder/bumper.yaml"; echo 'explore: {points: 0, depth: 1}'; } >"$folder/whole.yaml" && "$ricochet" run "$folder/whole.yaml" >"$folder/said" 2>&1 &&
        ! grep 'a first look: ' "$folder/said"
}
ok 'a first look says that it is one' goes_on
ok 'two masses and a cubic spring' picture cubic 3
ok 'a loose gear' picture gear 50
ok 'a free mass' picture free 1
ok 'an impact oscillator' picture one 1

windows() { # of every model, as check has them: where the modes begin that it says begin
    for name in chain drone cubic gear free one; do
        "$ricochet" check "$folder/$name.yaml" --json >"$folder/check.json" || return 1
        python3 -S - "$folder/check.json" <<'P' || return 1
import json, sys
for row in json.load(open(sys.argv[1])):
    assert row["window_energy_by"] == row["window_frequency_by"] == "auto"
    (e0, e1), (f0, f1) = row["window_energy"], row["window_frequency"]
    assert 0 <= e0 < e1 and 0 < f0 < f1
    assert not row["begins"] or (e0 < row["onset"] < e1 and f0 < row["frequency"] < f1)
P
    done
}
ok 'check has the windows' windows
says() { # PATTERN ARGUMENTS: the program says it, with exit code 0
    local pattern=$1
    shift
    "$ricochet" "$@" >"$folder/said" 2>&1 || { cat "$folder/said"; return 1; }
    cat "$folder/said"
    tr '\n' ' ' <"$folder/said" | grep -q -e "$pattern"
}
ok 'a frame is looked at with some of its modes' says '3 of 40 modes are kept' check "$folder/frame.yaml"
ok 'check names what the windows leave out' says 'mode 2 stays linear: its first touch is at energy 65671.7, above the window' check "$folder/chain.yaml"
{ cat "$folder/chain.yaml"; echo 'explore: {energy: [0, 50], frequency: [0.2, 10]}'; } >"$folder/narrow.yaml"
ok 'check warns of windows that hold nothing' says 'the windows hold no mode that meets a contact' check "$folder/narrow.yaml"
ok 'a run there says why' says 'no orbit that meets a contact was found: mode 1 touches first, at scaled energy 118.49, and the window ends at 50; leave out' \
    run "$folder/narrow.yaml"
sed 's/energy: \[0, 50\]/energy: [0, 20000]/' "$folder/narrow.yaml" >"$folder/slow.yaml"
ok 'and of frequencies' says 'warning: the windows hold no mode' check "$folder/slow.yaml"

refused() { # PATTERN STUDY: by run, with exit code 2 and no file, and check says so beforehand
    "$ricochet" check "$2" >"$folder/said" 2>&1 && grep -q -e "warning: a run refuses this study: .*$1" "$folder/said" || { cat "$folder/said"; return 1; }
    "$ricochet" check "$2" --json | grep -q -e "\"refused\": .*$1" || return 1
    "$ricochet" run "$2" >"$folder/said" 2>&1
    [ $? = 2 ] && grep -q -e "$1" "$folder/said" || { cat "$folder/said"; return 1; }
    [ ! -e "${2%.yaml}.ricochet" ]
}
{ cat "$folder/drone.yaml"; echo 'explore: {frequency: [0.2, 10]}'; } >"$folder/fast.yaml"
ok 'what run refuses check says: a mode that turns too often' refused 'mode 10 at .* turns' "$folder/fast.yaml"
sed 's/clearance: 1.0e-3/clearance: 1.0e-3, law: bilinear, stiffness: 1.0e+5/' "$folder/free.yaml" >"$folder/loose.yaml"
rattles() { # MANY STUDY: so many branches or more, all of them true
    "$ricochet" run "$2" >"$folder/said" 2>&1 && [ "$("$ricochet" branches "${2%.yaml}.ricochet" --csv | tail -n +2 | wc -l)" -ge "$1" ] &&
        "$ricochet" verify "${2%.yaml}.ricochet" >"$folder/said" 2>&1 || { tail "$folder/said"; return 1; }
}
ok 'a loose mass against a spring' says 'its families go to and fro between two faces' check "$folder/loose.yaml"
ok 'and its atlas' rattles 1 "$folder/loose.yaml"
cat >"$folder/wall.yaml" <<'Y'
model:
  mass: [[1, 0], [0, 2]]
  stiffness: [[0, 0], [0, 50]]
  contacts:
    - {normal: [1, 0], clearance: 0.1, sides: upper}
    - {normal: [1, -1], clearance: 0.2, sides: lower}
Y
ok 'a loose mass between a wall and a body, which comes to rest on the wall' rattles 60 "$folder/wall.yaml"
sed 's/0.1, sides/0.1, law: bilinear, stiffness: 400, sides/' "$folder/wall.yaml" >"$folder/buffer.yaml"
ok 'and between a spring and a stop' rattles 10 "$folder/buffer.yaml"
all_told() { # no departure of either atlas is refused: those whose faces push the mass one way alone are none
    for name in wall buffer; do "$ricochet" report "$folder/$name.ricochet" >"$folder/said" && ! grep 'departures refused' "$folder/said" || return 1; done
}
ok 'whose momentum says what departures have no motions' all_told
cat >"$folder/rest.yaml" <<'Y'
model:
  mass: [[3.3, 0], [0, 3.3]]
  stiffness: [[0, 0], [0, 20.912728837075985]]
  contacts:
    - {normal: [1, -1], clearance: 0.76, sides: upper, law: bilinear, stiffness: 15.2}
    - {normal: [1, -1], clearance: 0.28, sides: lower}
explore: {depth: 2, points: 600}
Y
# The speeds of its branch A2[01] fall by the cube of the touch of the spring: it ends where the loose mass rests and both faces are just
# reached, by no steps within rounding, of which there were 1,800, with the energy of half the way between them.
rests() {
    rattles 8 "$folder/rest.yaml" || return
    "$ricochet" branches "$folder/rest.ricochet" --json >"$folder/rest.json" && "$ricochet" junctions "$folder/rest.ricochet" --json >"$folder/ends.json" &&
        python3 -S - "$folder/rest.json" "$folder/ends.json" <<'P'
import json, sys
branches, junctions = (json.load(open(path)) for path in sys.argv[1:])
energy = 20.912728837075985 / 2 * (0.52 / 0.76) ** 2
ends = [j for j in junctions if abs(j["energy"] / energy - 1) < 1e-14]
assert [(j["impacts"], j["grazings"]) for j in ends] == [(0, 2)], ends
assert max(b["points"] for b in branches) < 300, branches
P
}
ok 'a mass that comes to rest on a stop ends its branch there' rests
cat >"$folder/midst.yaml" <<'Y'
model:
  mass: [[2, 0], [0, 3.3]]
  stiffness: [[0, 0], [0, 19.844716564731524]]
  contacts:
    - {normal: [1, 0], clearance: 0.86, sides: upper}
    - {normal: [1, -1], clearance: 0.19, sides: lower, law: bilinear, stiffness: 53.4}
explore: {depth: 1, points: 600}
Y
# From such an end no first step shows the speeds: a branch that was found in its midst is followed from its other one.
midst() {
    "$ricochet" run "$folder/midst.yaml" -o "$folder/midst.ricochet" && "$ricochet" branches "$folder/midst.ricochet" --csv >"$folder/rows" &&
        grep -Eq '^[0-9]+,[^,]*,A2\[01\],.*,4\.149253[0-9]*,1(50|49\.9999)' "$folder/rows" && ! "$ricochet" junctions "$folder/midst.ricochet" --csv | grep ',start,'
}
ok 'what was found in its midst is followed from either end' midst
cat >"$folder/rests.yaml" <<'Y'
model:
  mass: [[1, 0, 0], [0, 0.5, 0], [0, 0, 3.3]]
  stiffness: [[0, 0, 0], [0, 68.07626394885557, -29.64973852196805], [0, -29.64973852196805, 29.64973852196805]]
  contacts:
    - {normal: [1, 0, 0], clearance: 0.51, sides: upper, law: bilinear, stiffness: 17.8}
    - {normal: [1, -1, 0], clearance: 0.74, sides: lower, law: bilinear, stiffness: 97.6}
explore: {depth: 0, points: 600}
Y
ok 'a loose mass between two springs' rattles 10 "$folder/rests.yaml"
ends_well() { "$ricochet" report "$folder/rests.ricochet" >"$folder/out" && ! grep 'rest missing' "$folder/out"; }
ok 'no branch of which is left with an end that is no junction' ends_well
cat >"$folder/stands.yaml" <<'Y'
model:
  mass: [[3.3, 0, 0, 0], [0, 0.3, 0, 0], [0, 0, 0.5, 0], [0, 0, 0, 2]]
  stiffness: [[0, 0, 0, 0], [0, 17.381, -4.0738, 0], [0, -4.0738, 24.745, -20.671], [0, 0, -20.671, 20.671]]
  contacts:
    - {normal: [1, 0, 0, -1], clearance: 1.32, sides: upper}
    - {normal: [1, -1, 0, 0], clearance: 1.45, sides: lower}
explore: {depth: 0, points: 200, frequency: [0.18, 0.2]}
Y
ok 'a loose mass between two others' rattles 5 "$folder/stands.yaml"
ok 'a branch of which ends where it stands' says 'rest missing of .* rests on a contact' report "$folder/stands.ricochet"
cat >"$folder/far.yaml" <<'Y'
model:
  mass: [[0.5, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0.3, 0], [0, 0, 0, 1]]
  stiffness: [[0, 0, 0, 0], [0, 7.6, 0, 0], [0, 0, 51.5, -38.1], [0, 0, -38.1, 51.4]]
  contacts:
    - {normal: [1, 0, 0, 0], clearance: 0.23, sides: upper, law: bilinear, stiffness: 1270}
    - {normal: [1, 0, -1, 0], clearance: 0.21, sides: lower}
explore: {depth: 1}
Y
ok 'one that takes long from a spring to a stop and back' rattles 10 "$folder/far.yaml"
ok 'whose orbits are stored with all their digits' "$ricochet" verify "$folder/far.ricochet" --all
{ cat "$folder/chain.yaml"; echo 'explore: {energy: {first_touch_of: 1, times: [0, 20]}, impacts: 4, depth: 1}'; } >"$folder/times.yaml"
ok 'energies in first touches' says 'scaled energy 0 to 2369.8, ' check "$folder/times.yaml"
python3 -S - >"$folder/long.yaml" <<'P'
n = 120
row = lambda f: "[" + ", ".join(map(str, f)) + "]"
print("model:\n  modes: all\n  mass:", row(row(int(i == j) for j in range(n)) for i in range(n)))
print("  stiffness:", row(row(2 * (i == j) - (abs(i - j) == 1) for j in range(n)) for i in range(n)))
print("  contacts:\n    - {normal:", row(int(i == n // 2) for i in range(n)) + ", clearance: 1}")
P
ok 'check says that a run will take long' says 'warning: a branch of 120 modes takes about 18 s, and an atlas .* 6 min to 58 min' check "$folder/long.yaml"
{ cat "$folder/long.yaml"; echo 'explore: {start: [1]}'; } >"$folder/lowest.yaml"
ok 'and which modes are worth it' says 'modes: `model: {modes: [1-9][0-9]}` keeps those up to 20 times the highest that begins' check "$folder/lowest.yaml"
sed '/modes: all/d' "$folder/long.yaml" >"$folder/chosen.yaml"
ok 'a study that names neither modes nor a window is looked at with those that matter' says '10 of 120 modes are kept' check "$folder/chosen.yaml"
ok 'and how to have all' says '`modes: all` keeps all' check "$folder/chosen.yaml"
kept() { # a window, or the study in an atlas, says nothing else
    { cat "$folder/chosen.yaml"; echo 'explore: {energy: [0, 50]}'; } >"$folder/window.yaml"
    { cat "$folder/window.yaml" | sed 's/^model:/&\n  modes: auto/'; } >"$folder/auto.yaml"
    ! "$ricochet" check "$folder/window.yaml" | grep 'modes are kept' && says '10 of 120 modes are kept' check "$folder/auto.yaml" &&
        "$ricochet" run "$folder/chosen.yaml" -o "$folder/chosen.ricochet" --seconds 0.5 >"$folder/said" 2>&1
    [ $? = 3 ] && "$ricochet" run "$folder/chosen.yaml" -o "$folder/chosen.ricochet" --seconds 0.5 >"$folder/said" 2>&1
    [ $? = 3 ] && ! grep 'another model' "$folder/said"
}
ok 'where a window is given all are kept' kept
begun() { # run says it, too
    "$ricochet" run "$folder/long.yaml" --seconds 0.1 >"$folder/said" 2>&1
    [ $? = 3 ] && grep 'a branch of 120 modes takes about' "$folder/said"
}
ok 'and so does the run' begun
cat >"$folder/planes.yaml" <<'Y'
model:
  mass: [[0.02, 0], [0, 0.02]]
  stiffness: [[12000, 0], [0, 13000]]
  contacts:
    - {normal: [1, 0], clearance: 0.15}
    - {normal: [0, 1], clearance: 0.15}
Y
printf '%s\n' 'model:' '  mass: [[2, 0], [0, 1]]' '  stiffness: [[9, -1], [-1, 1]]' '  contacts:' \
    '    - {normal: [-1, 1], clearance: 1}' '    - {normal: [1, 0], clearance: 2}' \
    '    - {normal: [2, -2], clearance: 2, sides: lower}' >"$folder/twice.yaml"
ok 'a stop that is given twice is named' says 'warning: contacts 1 and 3 are one stop' check "$folder/twice.yaml"
ok 'and what is given once is not' bash -c '! grep "contacts [0-9] and 2\|contacts 2" "$0"' "$folder/said"
sed -i 's/sides: lower/sides: upper/; s/, clearance: 1}/, clearance: 1, sides: upper}/' "$folder/twice.yaml"
ok 'nor are the two sides of a gap' bash -c '! "$0" check "$1" | grep "one stop"' "$ricochet" "$folder/twice.yaml"
# sqrt(2 E b.K^-1 b) = d with b.K^-1 b = 2/3: E = 0.75 d^2, of which the motion is a static deflection
printf '%s\n' 'model:' '  mass: [[1, 0], [0, 1]]' '  stiffness: [[2, -1], [-1, 2]]' '  contacts:' \
    '    - {normal: [1, 0], clearance: 1}' '    - {normal: [0, 1], clearance: 1000}' >"$folder/far.yaml"
ok 'a stop that nothing can reach is named' says 'contact 2 is out of reach: no motion of an energy below 750000 meets it' check "$folder/far.yaml"
ok 'and one that is reached is not' bash -c '! grep "contact 1 is out of reach" "$0"' "$folder/said"
"$ricochet" run "$folder/twice.yaml" >"$folder/said" 2>&1
ok 'a first look that ends at its depth says how to go on' grep -q '^a first look: what lies beyond `depth` is tried with `depth: 4` under `explore`' "$folder/said"
ok 'a structure that falls apart: check' says 'warning: the structure falls into parts' check "$folder/planes.yaml"
ok 'and run' says 'no orbit that meets .*: the structure falls into parts that no contact joins' run "$folder/planes.yaml"
cat >"$folder/side.yaml" <<'Y'
model:
  mass: [[0.12, 0], [0, 0.05]]
  stiffness: [[6.0e+4, 0], [0, 0]]
  contacts:
    - {normal: [-1, 1], clearance: 0.0005, sides: lower}
Y
ok 'a loose mass before one side' says 'no family starts from it, which takes two faces that push it in opposite directions' check "$folder/side.yaml"
ok 'and how to say it' says 'before a stop on one side alone a loose mass flies off' check "$folder/side.yaml"
ok 'a run says it, too' says 'before a stop on one side alone a loose mass flies off' run "$folder/side.yaml"
printf '%s\n' 'model:' '  mass: [[1, 0], [0, 2]]' '  stiffness: [[0, 0], [0, 0]]' '  contacts:' \
    '    - {normal: [1, -1], clearance: 0.2}' '    - {normal: [0, 1], clearance: 0.5, sides: upper}' 'explore: {depth: 1}' >"$folder/train.yaml"
ok 'masses that are loose in several ways: check' says 'masses are loose in several ways: families .* three faces or more are not looked for' check "$folder/train.yaml"
ok 'and run, of an atlas that has some of their motions' \
    says 'ways in which masses are loose: 2 (families that begin between three faces or more are not looked for' run "$folder/train.yaml"
ok 'a mass that is loose in one way has none of these' bash -c '! "$0" report "$1" | grep "ways in which"' "$ricochet" "$folder/wall.ricochet"
sed 's/clearance: 0.2/clearance: 0.2, sides: upper/' "$folder/train.yaml" >"$folder/apart.yaml"
ok 'and of one that has none' says 'masses that are loose in several ways strike' run "$folder/apart.yaml"
sed 's/^model:/units: {length: mm, force: N}\n&/' "$folder/chain.yaml" >"$folder/named.yaml"
named() { # units on the axes of a force curve
    sed 's/clearance: 0.25/&, law: bilinear, stiffness: 900/' "$folder/named.yaml" >"$folder/spring.yaml"
    "$ricochet" plot law "$folder/spring.yaml" -o "$folder/law.svg" && grep -q 's (mm)' "$folder/law.svg" && grep -q '(N)' "$folder/law.svg" &&
        sed '/^units/d' "$folder/spring.yaml" >"$folder/unnamed.yaml" && "$ricochet" plot law "$folder/unnamed.yaml" -o "$folder/law.svg" &&
        ! grep -q '(N)' "$folder/law.svg"
}
ok 'force curves have their units' named
masses() { # LENGTH FORCE MASS WORDS: what check says of the unit of mass
    sed "s/^units:.*/units: {length: $1, force: $2, mass: $3}/" "$folder/named.yaml" >"$folder/masses.yaml"
    "$ricochet" check "$folder/masses.yaml" 2>&1 | grep -q -- "$4"
}
ok 'the unit of mass follows' masses mm N t 'masses in N s^2/mm, which is t,'
ok 'also where it is none with a name' masses mm kN parcel 'which is 1000 t,'
ok 'and of pounds and inches' masses in lbf slinch 'which is slinch,'
ok 'masses in kg where t belong are refused, with the factor' masses mm N kg 'units.mass: .* masses are in t: multiply those in kg by 0.001'
ok 'a mass is no length' masses mm N cm 'cm is no unit of mass, but of length'
# Of a few hundred coordinates the modes take seconds: a terminal says what goes on before there is anything else to show.
begins() { python3 -S tests/support/terminal.py 80 "$ricochet" run "$folder/chain.yaml" -o "$folder/shown.ricochet" --seconds 0.2 | head -c 200 | grep -q "^$folder/chain.yaml: read, and its modes"; }
ok 'a run says at once what it does' begins

# Two masses on one spring, each between walls: one may rest at a wall while the other moves, which touches for good.
cat >"$folder/walls.yaml" <<'END'
title: A free pair between walls
model:
  mass: [[1, 0], [0, 1]]
  stiffness: [[125000, -125000], [-125000, 125000]]
  contacts:
    - {normal: [0, 1], clearance: 1.68, law: rigid}
    - {normal: [1, 0], clearance: 1.68, law: rigid}
explore: {energy: [0, 1062000], frequency: [100, 1500], impacts: 4, multiply: 2, depth: 2}
END
ok 'a body that rests at a stop is no lack of memory' "$ricochet" run "$folder/walls.yaml" -o "$folder/walls.ricochet"
ok 'and what is found of it is right' "$ricochet" verify "$folder/walls.ricochet" --all
cat >"$folder/springs.yaml" <<'END'
model:
  mass: [[1, 0, 0], [0, 2, 0], [0, 0, 1]]
  stiffness: [[0, 0, 0], [0, 60, -20], [0, -20, 40]]
  contacts:
    - {normal: [1, 0, 0], clearance: 0.1, sides: upper, law: bilinear, stiffness: 900}
    - {normal: [1, -1, 0], clearance: 0.2, sides: lower, law: bilinear, stiffness: 500}
END
counts() { "$ricochet" run "$folder/springs.yaml" --quiet && "$ricochet" report "$folder/springs.ricochet" | grep -q 'events that are no junctions *[1-9]'; }
ok 'the report counts what is left out' counts

finish
