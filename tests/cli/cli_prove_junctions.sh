#!/usr/bin/env bash
# Junctions as theorems: those of the demo are proved, each as what it is; what is a little wrong is not.
set -u
. tests/support/tap.sh
. tests/support/proofs.sh

if ! "$ricochet" run examples/elementary/study.yaml -o "$folder/e.ricochet" --quiet; then echo '1..0 # SKIP no atlas'; exit 77; fi
needs_flint "$folder/e.ricochet"

# planted CODE: a copy of the atlas with Python over the database \`db\` done to it, its digest made anew; and its rows
planted() {
    plant "$folder/e.ricochet" "$folder/p.ricochet" '
def change(column, to):
    for id, old in db.execute(f"SELECT id, {column} FROM junction ORDER BY id").fetchall():
        db.execute(f"UPDATE junction SET {column} = ? WHERE id = ?", (to(old), id))
'"$1"
    prove "$folder/p.ricochet" "$folder/p.json" --junctions
}

ok 'all junctions are proved' bash -c '"$0" prove "$1" --junctions | grep -q "^18 of 18 junctions proved"' "$ricochet" "$folder/e.ricochet"
prove "$folder/e.ricochet" "$folder/all.json" --junctions
ok 'each by what vanishes there' rows "$folder/all.json" '
ways = {"grazing": ("an impact has no speed", "a gap touches"), "extremum": ("the energy turns",),
        "period-extremum": ("the period turns",), "branch-point": ("a motion breaks",), "multiplication": ("multipliers turn by 2/6",)}
assert len(rows) == 18
for row in rows:
    assert row["how"].startswith(ways[row["kind"]]), row
    assert row["exists"] < 1e-30 < 1e-9 < row["unique"], row
    assert row["distance"] < 1e-11, row
broken = {row["label"]: row["how"] for row in rows if row["kind"] == "branch-point"}
assert broken["C2_32"] == "a motion breaks both mirrors" and "both" not in broken["C1_32"], broken'
# G1_0,2 and G2_0,2: the linear modes that reach the stop, E = 1 / (2 sum(c)^2) omega^2. C1_32: where sum(c^2 / (omega tan(omega tau / 2))) = 0 on S2.
# The others have been computed by another program.
ok 'the linear modes touch at the energies of their closed form' rows "$folder/all.json" '
from fractions import Fraction
for row, z in zip(rows, ((11 - math.sqrt(57)) / 4, (11 + math.sqrt(57)) / 4)):
    phi = (1, 9 - 2 * z)
    E = z * (2 * phi[0] ** 2 + phi[1] ** 2) / (2 * (phi[1] - phi[0]) ** 2)
    assert abs(row["energy"][0] - E) < 1e-13 * E and row["energy"][0] <= row["energy"][1], (row, E)
    T = 2 * math.pi / math.sqrt(z)
    assert abs(row["period"][0] - T) < 1e-13 * T, (row, T)
known = {"G1_2,4": "80.974067470264848868799186367524154", "C1_32": "1.90132763794569891260284294568",
         "C3_32": "22.9874031990843804776697006239", "C4_32": "15.5574570225909028331225633331"}
for row in rows:
    if row["label"] in known:
        low, high = (Fraction(x) for x in row["energy"])
        assert low <= Fraction(known[row["label"]]) <= high, row'

# Along the masses, which opens no gap, and with the speed that keeps the energy; at rest there is none.
planted '
def potential(x): return 4.5 * x[0] ** 2 - x[0] * x[1] + x[1] ** 2 / 2
for id, state in db.execute("SELECT id, state FROM junction").fetchall():
    x = floats(state)
    by, kinetic = 1e-6 * max(map(abs, x)), x[2] ** 2 + x[3] ** 2 / 2
    y = [x[0] - by, x[1] - by]
    E = potential(x) + kinetic
    faster = ((E - potential(y)) / kinetic) ** 0.5 if kinetic > 0 else 1
    if kinetic == 0: E = potential(y)
    db.execute("UPDATE junction SET state = ?, energy = ? WHERE id = ?", (blob(y + [v * faster for v in x[2:]]), E, id))'
ok 'none is proved at a state that is off by 1e-6' rows "$folder/p.json" 'assert len(rows) == 18 and not proved, proved[:2]'
planted '
change("flights", lambda old: blob([floats(old)[0] * (1 + 1e-6)] + floats(old)[1:]))'
ok 'nor with another flight' rows "$folder/p.json" 'assert len(rows) == 18 and not proved, proved[:2]'
planted 'change("energy", lambda old: old * (1 + 1e-7))'
ok 'nor with another energy' rows "$folder/p.json" 'assert len(rows) == 18 and not proved, proved[:2]'
# Another kind of the same form; a study gives names to kinds, which have to fit.
exchanged() {
    planted "db.execute(\"UPDATE junction SET kind = '$2' WHERE kind = '$1'\")"
    rows "$folder/p.json" "
some = [row for row in rows if row['kind'] == '$2']
assert some and not [row for row in some if row['verdict'] == 'proved' and row['junction'] in $3], some"
}
ok 'no turn of the energy is one of the period' exchanged extremum period-extremum '(3, 4, 8, 15, 16)'
ok 'no turn of the period is one of the energy' exchanged period-extremum extremum '(9,)'
ok 'no turn of the energy is a branch point' exchanged extremum branch-point '(3, 4, 8, 15, 16)'
ok 'no branch point is a turn' exchanged branch-point extremum '(5, 10, 11, 18)'
planted '
for id, word in db.execute("SELECT id, word FROM junction").fetchall():
    if word: db.execute("UPDATE junction SET word = ? WHERE id = ?", (word[:-1] + str(1 - int(word[-1])), id))'
ok 'none is proved with an impact on the other face' rows "$folder/p.json" 'assert not [row for row in proved if row["junction"] > 2], proved'
# A branch that does not touch at its end: the point before it.
planted '
for id, n in db.execute("SELECT branch, max(point) FROM point GROUP BY branch").fetchall():
    for at, by in ((0, 1), (n, n - 1)):
        row = db.execute("SELECT energy, frequency, state, flights FROM point WHERE branch = ? AND point = ?", (id, by)).fetchone()
        db.execute("UPDATE point SET energy = ?, frequency = ?, state = ?, flights = ? WHERE branch = ? AND point = ?", (*row, id, at))'
ok 'no grazing is proved where nothing touches' rows "$folder/p.json" '
assert not [row for row in proved if row["kind"] == "grazing" and row["distance"] > 1e-8], proved'
ok 'options that do not go together are refused' bash -c '
for more in --curves "--branch 3"; do "$0" prove "$1/e.ricochet" --junctions $more 2>/dev/null; [ $? -eq 2 ] || exit 1; done' "$ricochet" "$folder"
# Three modes and one stop: A4[0000] and A5[00000] have no mirror, and their multipliers pass exp(2 pi i / 3). That they stay on the unit circle
# there follows as no other multiplier is near.
cat >"$folder/turns.yaml" <<'END'
model:
  mass: [[0.671875, 0.015625, -0.09375], [0.015625, 1.828125, -0.046875], [-0.09375, -0.046875, 1.84375]]
  stiffness: [[1875000, -31250, -31250], [-31250, 1453125, -609375], [-31250, -609375, 515625]]
  contacts:
    - {law: rigid, normal: [-1, 0, -1], clearance: 1.2, sides: lower}
explore: {start: modes, frequency: [68.9, 5037], energy: [0, 2200000], impacts: 5, multiply: 3, depth: 2}
END
"$ricochet" run "$folder/turns.yaml" -o "$folder/turns.ricochet" --quiet
prove "$folder/turns.ricochet" "$folder/turns.json" --junctions
ok 'multipliers of three modes that turn by a third, of an orbit without a mirror' rows "$folder/turns.json" '
assert len(proved) == len(rows) > 60, [row for row in rows if row["verdict"] != "proved"]
assert [row for row in rows if row["how"] == "multipliers turn by 1/3"], {row["how"] for row in rows}'
finish
