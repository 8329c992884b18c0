#!/usr/bin/env bash
# Proofs between bilinear springs, by themselves and beside a stop: what is stored is proved, what is a little wrong is not.
set -u
. tests/support/tap.sh
. tests/support/proofs.sh

if ! "$ricochet" run examples/stop-and-spring/study.yaml -o "$folder/stop-and-spring.ricochet" --quiet; then echo '1..0 # SKIP no atlas'; exit 77; fi
needs_flint "$folder/stop-and-spring.ricochet"

# planted CODE BRANCH...: a copy of the atlas of two springs with Python over \`points\` done to it, its digest made anew; and its rows,
# or those of some branches
planted() {
    plant "$folder/two-springs.ricochet" "$folder/p.ricochet" '
random.seed(7)
points = [p for p in db.execute("SELECT branch, point, state, flights, stable FROM point WHERE branch IN"
                                " (SELECT id FROM branch WHERE impacts > 0) AND point % 4 = 1 ORDER BY branch, point")]
'"$1"
    prove_some "$folder/p.ricochet" "$folder/p.json" "${@:2}"
}

# What is not proved are ends of branches.
for line in 'bilinear 186 186 3 3 3 8 8' 'two-springs 272 272 6 6 4 7 7' 'stop-and-spring 291 291 5 5 4 9 9'; do
    read -r name points of_points curves of_curves whole junctions of_junctions <<<"$line"
    [ -f "$folder/$name.ricochet" ] || "$ricochet" run "examples/$name/study.yaml" -o "$folder/$name.ricochet" --quiet
    prove "$folder/$name.ricochet" "$folder/$name.json"
    ok "$name: all points but some ends are proved" rows "$folder/$name.json" "
last = {}
for row in rows: last[row['branch']] = max(row['point'], last.get(row['branch'], 0))
assert len(rows) == $of_points and len(proved) == $points, (len(proved), len(rows))
for row in rows:
    assert row['verdict'] == 'proved' or row['point'] in (0, last[row['branch']]), row
    assert row['why'] or row['distance'] < 1e-10, row"
    ok "$name: energy, period and stability are those that are stored" rows "$folder/$name.json" "
import sqlite3
db = sqlite3.connect('$folder/$name.ricochet')
for row in proved:
    E, omega, stable = db.execute('SELECT energy, frequency, stable FROM point WHERE branch = ? AND point = ?', (row['branch'], row['point'])).fetchone()
    assert row['energy'][0] * (1 - 1e-9) <= E <= row['energy'][1] * (1 + 1e-9), row
    assert row['period'][0] * (1 - 1e-9) <= 2 * math.pi / omega <= row['period'][1] * (1 + 1e-9), row
    assert row['stable'] == 'undecided' or stable == 2 or row['stable'] == ('no', 'yes')[stable], row"
    ok "$name: so are its curves, $whole of them from end to end" bash -c '"$0" prove "$1" --curves | grep -q "^$2 of $3 curves proved, $4 of them from end to end"' "$ricochet" "$folder/$name.ricochet" "$curves" "$of_curves" "$whole"
    ok "$name: and its junctions" bash -c '"$0" prove "$1" --junctions 2>/dev/null | grep -q "^$2 of $3 junctions proved"' "$ricochet" "$folder/$name.ricochet" "$junctions" "$of_junctions"
done

# Half of its branches take longer than that by themselves: what was stopped in its midst is not kept, and proved the next time.
stopped() {
    cp "$folder/two-springs.ricochet" "$folder/stopped.ricochet"
    plant "$folder/stopped.ricochet" "$folder/s.ricochet" 'db.execute("DELETE FROM proof_graph")'
    "$ricochet" prove "$folder/s.ricochet" --curves --seconds 0.02
    [ $? -eq 3 ] || return 1
    plant "$folder/stopped.ricochet" "$folder/u.ricochet" 'db.execute("DELETE FROM proof_graph")'
    local whole; whole=$("$ricochet" prove "$folder/u.ricochet" --curves)
    grep -q '^6 of 6 curves proved, 4 of them from end to end' <<<"$whole" &&
        [ "$("$ricochet" prove "$folder/s.ricochet" --curves)" = "$whole" ]
}
ok 'a stop ends within a curve, and nothing half done is kept' stopped

# One mass 1 on a spring 1, with a spring 5 beyond |x| = 1: half a quarter is asin(1 / A), the other acos((1 - r) / B) / w, w^2 = 6.
cat >"$folder/one.yaml" <<'E2'
title: One mass between two springs
model:
  mass: [[1]]
  stiffness: [[1]]
  contacts:
    - {name: wall, normal: [1], clearance: 1, sides: both, law: bilinear, stiffness: 5}
explore: {start: modes, energy: [0, 10], frequency: [0.2, 10], impacts: 2, multiply: 1, depth: 1}
E2
"$ricochet" run "$folder/one.yaml" -o "$folder/one.ricochet" --quiet
prove "$folder/one.ricochet" "$folder/one.json"
ok 'one mass has the period of its closed form at its energy' rows "$folder/one.json" '
some = [row for row in proved if row["branch"] == 2 and row["energy"][0] > 0.6]
assert len(some) > 10, len(some)
def period(E):
    w, r = 6 ** 0.5, 5 / 6
    A, speed = (2 * E) ** 0.5, (2 * E - 1) ** 0.5
    return 4 * (math.asin(1 / A) + math.acos((1 - r) / math.hypot(1 - r, speed / w)) / w)
for row in some:
    T = period(sum(row["energy"]) / 2)
    assert abs(row["period"][0] - T) < 1e-13 * T and abs(row["period"][1] - T) < 1e-13 * T, (row, T)'
ok 'and touches at its first energy, 1/2' bash -c '"$0" prove "$1" --junctions --json 2>/dev/null | python3 -S -c "
import json, sys
row = json.load(sys.stdin)[0]
assert row[\"verdict\"] == \"proved\" and row[\"energy\"][0] <= 0.5 <= row[\"energy\"][1] and row[\"how\"].startswith(\"a gap touches\"), row"' "$ricochet" "$folder/one.ricochet"

planted '
for b, p, state, flights, stable in points:
    x = floats(state)
    i, before = random.randrange(3), list(x)
    x[3 + i] += 1e-6 * max(map(abs, x)) * random.choice((-1, 1))
    more = (1, 1, 1.5)[i] * (x[3 + i] ** 2 - before[3 + i] ** 2) / 2
    db.execute("UPDATE point SET state = ?, energy = energy + ? WHERE branch = ? AND point = ?", (blob(x), more, b, p))'
ok 'no orbit is proved at a state that is off by 1e-6' rows "$folder/p.json" '
some = [row for row in rows if row["point"] % 4 == 1 and row["branch"] > 3]
assert len(some) > 50 and not [row for row in some if row["verdict"] == "proved"]'
planted '
for b, p, state, flights, stable in points:
    if stable < 2: db.execute("UPDATE point SET stable = ? WHERE branch = ? AND point = ?", (1 - stable, b, p))'
ok 'no flag that is turned round passes' rows "$folder/p.json" '
some = [row for row in rows if row["point"] % 4 == 1 and row["branch"] > 3]
assert len(some) > 50 and not [row for row in some if row["verdict"] == "proved" and row["stable"] != "undecided"], len(proved)
assert sum(row["why"].startswith("stored as") for row in some) > 0.9 * len(some)'
planted '
for b, p, state, flights, stable in points:
    t = floats(flights)
    db.execute("UPDATE point SET flights = ?, energy = energy * (1 + 1e-7) WHERE branch = ? AND point = ?", (blob([t[0] * (1 + 1e-6)] + t[1:]), b, p))'
ok 'nor another time or energy' rows "$folder/p.json" '
assert not [row for row in proved if row["point"] % 4 == 1 and row["branch"] > 3]'
# Closings and openings in another order: the springs of two faces are exchanged.
planted '
for id, word in db.execute("SELECT id, word FROM branch WHERE impacts > 2").fetchall():
    db.execute("UPDATE branch SET word = ? WHERE id = ?", (word.translate(str.maketrans("23", "32")), id))' $(some_of 8 '')
ok 'nor another word' rows "$folder/p.json" '
some = [row for row in rows if row["branch"] > 6]
assert len(some) > 50 and not [row for row in some if row["verdict"] == "proved"], len(proved)'
# The spring of the second one is stiffer by a millionth: where it is closed for long orbits are others.
plant "$folder/two-springs.ricochet" "$folder/p.ricochet" '
db.execute("UPDATE meta SET value = replace(value, ?, ?)", ("stiffness: 9", "stiffness: 9.000009"))'
prove_some "$folder/p.ricochet" "$folder/p.json" $(some_of 8 '')
ok 'nor with another spring' rows "$folder/p.json" '
some = [row for row in rows if row["branch"] > 7]
assert len(some) > 50 and not [row for row in some if row["verdict"] == "proved" and not row["why"]], len(proved)'
# Two masses on one spring, which float while the spring between them is closed.
cat >"$folder/free.yaml" <<'E2'
model:
  mass: [[1, 0], [0, 1]]
  stiffness: [[1, -1], [-1, 1]]
  contacts:
    - {normal: [1, 0], law: rigid, clearance: 1, sides: both}
    - {normal: [1, -1], law: bilinear, clearance: 0.5, sides: both, stiffness: 5}
explore: {energy: [0, 10], frequency: [0.2, 6], impacts: 4, depth: 1}
E2
"$ricochet" run "$folder/free.yaml" -o "$folder/free.ricochet" --quiet
ok 'a structure that floats while a spring is closed' bash -c '
"$0" prove "$1" | grep -Eq "^([0-9]+) of \1 points proved"' "$ricochet" "$folder/free.ricochet"
# Two branches of the loose pair end where the spring is touched several times in one flight, at junctions without a proof.
ok 'and its curves' bash -c '
"$0" prove "$1" --curves | grep -Eq "^([3-9][0-9]*) of \1 curves proved, [1-9][0-9]* of them from end to end"' "$ricochet" "$folder/free.ricochet"
# Beside a linear mode gone through twice the middles of flights lie at mirror points of that mode.
cat >"$folder/twice.yaml" <<'E2'
model:
  mass: [[2.203125, -0.03125, 0.09375], [-0.03125, 2.265625, -0.078125], [0.09375, -0.078125, 1.453125]]
  stiffness: [[8.3125, -4.6875, 6.25], [-4.6875, 7.875, -2], [6.25, -2, 8.8125]]
  contacts:
    - {law: bilinear, normal: [0, 0, 1], clearance: 0.00195, stiffness: 3.778}
    - {law: bilinear, normal: [-1, -2, 1], clearance: 0.00156, stiffness: 10860}
explore: {start: [1], energy: [0, 4], frequency: [0.4, 1], impacts: 2, multiply: 1, depth: 2}
E2
"$ricochet" run "$folder/twice.yaml" -o "$folder/twice.ricochet" --quiet
ok 'points up to the grazing of a mode gone through twice are proved' bash -c '
"$0" branches "$1" --json | grep -q "3.857326883" && "$0" prove "$1" | grep -Eq "^([0-9]+) of \1 points proved"' "$ricochet" "$folder/twice.ricochet"
ok 'a census is of stops alone' bash -c '
"$0" prove examples/bilinear/study.yaml --complete --energy 5 2>&1 | grep -q "bilinear springs"' "$ricochet"
finish
