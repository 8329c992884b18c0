#!/usr/bin/env bash
# Junctions at which several contacts touch or close at one instant, and grazings that are one touch only in a smaller
# class than that of their branches: proved as what they are, and refused where they are a little wrong.
set -u
. tests/support/tap.sh
. tests/support/proofs.sh

for name in symmetric-chain two-walls loose-mass corner; do
    if ! "$ricochet" run "examples/$name/study.yaml" -o "$folder/$name.ricochet" --quiet; then echo '1..0 # SKIP no atlas'; exit 77; fi
done
needs_flint "$folder/corner.ricochet"

# planted NAME CODE: a copy of that atlas with Python over the database \`db\` done to it, its digest made anew
planted() { plant "$folder/$1.ricochet" "$folder/p.ricochet" "$2"; }
# junctions NAME: the rows of that atlas
junctions() { prove "$folder/$1.ricochet" "$folder/rows.json" --junctions; }

# Both stops touch at once in every mode, as exchanging left and right takes one to the other. omega^2 = 2 - sqrt(2), 2,
# 2 + sqrt(2), phi = (1, sqrt(2), 1), (1, 0, -1), (1, -sqrt(2), 1)
junctions symmetric-chain
ok 'two stops are touched at once, which are images of one another' rows "$folder/rows.json" '
root = 2 ** 0.5
known = {"G1_0,4": (2 + root, (1, -root, 1)), "G2_0,4": (2, (1, 0, -1)), "G3_0,4": (2 - root, (1, root, 1))}
some = [row for row in proved if row["label"] in known]
assert len(some) == 3, rows
for row in some:
    z, phi = known[row["label"]]
    E = z * sum(x * x for x in phi) / (2 * (phi[1] - phi[0]) ** 2)
    assert row["energy"][0] - 1e-13 * E <= E <= row["energy"][1] + 1e-13 * E and row["exists"] < 1e-30, row
    T = 2 * math.pi / z ** 0.5
    assert row["period"][0] - 1e-13 * T <= T <= row["period"][1] + 1e-13 * T, row'
prove "$folder/symmetric-chain.ricochet" "$folder/points.json"
ok 'and the branches that leave begin there, or end' rows "$folder/points.json" '
assert len(rows) == 457, len(rows)
assert [(row["branch"], row["point"]) for row in rows if row not in proved] in ([], [(13, 60)]), len(proved) # K1 itself
ends = {row["branch"]: row["why"] for row in proved if row["point"] == (54 if row["branch"] == 5 else 0)}
assert [ends[b] for b in (4, 5, 6, 7)] == [f"the junction G{k}_0,4 itself" for k in (1, 3, 2, 1)], ends'
curves() {
    local branch
    for branch in 4 5 6 7; do
        "$ricochet" prove "$folder/symmetric-chain.ricochet" --curves --branch $branch | grep '^1 of 1 curves proved' || return 1
    done
}
ok 'where two stored points are one orbit the curve goes on' curves
# Both stops touch one after the other, and are taken to one another by the way back and exchanging left and right.
junctions symmetric-chain
ok 'stops touched in turn are images under the way back and an exchange' rows "$folder/rows.json" '
some = {row["label"]: row for row in proved if row["label"] in ("G1_2,4", "G2_2,4", "G1_4,2")}
assert len(some) == 3 and all(row["how"] == "a gap touches in flight 1" and row["exists"] < 1e-30 for row in some.values()), rows
assert [row["label"] for row in rows if row not in proved] == ["K1"], rows'
ok 'and the curves of their branches reach them' bash -c '
for branch in 8 10; do
    "$0" prove "$1" --curves --branch $branch | grep "^1 of 1 curves proved, 1 of them from end to end" || exit 1
done' "$ricochet" "$folder/symmetric-chain.ricochet"
# in_turn CODE: none of them is proved after that
in_turn() {
    planted symmetric-chain "$1" && prove "$folder/p.ricochet" "$folder/rows.json" --junctions
    rows "$folder/rows.json" '
labels = {row["label"] for row in proved}
assert len(rows) > 10 and not labels & {"G1_2,4", "G2_2,4", "G1_4,2"}, labels'
}
turned='
for id, state, flights, word in db.execute("SELECT id, state, flights, word FROM junction WHERE kind = ? AND impacts > 0", ("grazing",)).fetchall():
    x, t = floats(state), floats(flights)'
ok 'not with a state off by 1e-6' in_turn "$turned"'
    db.execute("UPDATE junction SET state = ? WHERE id = ?", (blob(x[:3] + [x[3] + 1e-6 * x[4], x[4] - 1e-6 * x[3], x[5]]), id))'
ok 'nor with other flights' in_turn "$turned"'
    db.execute("UPDATE junction SET flights = ? WHERE id = ?", (blob([t[0] + 1e-6, t[1] - 1e-6] + t[2:]), id))'
ok 'nor with another word' in_turn "$turned"'
    db.execute("UPDATE junction SET word = ? WHERE id = ?", (word.translate(str.maketrans("0123", "2103")), id))'
ok 'nor with left and right exchanged' in_turn "$turned"'
    db.execute("UPDATE junction SET state = ? WHERE id = ?", (blob(x[2::-1] + x[:2:-1]), id))'
ok 'nor with another energy' in_turn 'db.execute("UPDATE junction SET energy = energy * (1 + 2e-8)")'
# A stiffness that is off by 1e-12: the stops are touched one after the other. What touches one alone may be so.
planted symmetric-chain '
for key in "model", "study":
    text, = db.execute("SELECT value FROM meta WHERE key = ?", (key,)).fetchone()
    changed = text.replace("[0, -1, 2]", "[0, -1, 2.000000000001]")
    assert changed != text
    db.execute("UPDATE meta SET value = ? WHERE key = ?", (changed, key))'
prove "$folder/p.ricochet" "$folder/points.json"
ok 'stops of a structure that is not quite symmetric are not' rows "$folder/points.json" '
first = {row["branch"] for row in proved if row["point"] == 0 and row["branch"] > 3}
assert len(rows) > 100 and 6 not in first and not {4, 7} <= first, first'

# Corners: two contacts close at one instant, in either order, or where only one of them is hit.
junctions two-walls
ok 'two contacts close at one instant, in either order' rows "$folder/rows.json" '
some = {row["label"]: row["how"] for row in proved if row["kind"] == "corner"}
assert set(some) == {"K1", "K2", "K3", "K4"}, some
# K1: beside a mirror point that is an impact the other gap has no speed
assert some.pop("K1") == "a gap closes at an impact on another contact" and all("has no length" in how for how in some.values()), some'
prove "$folder/two-walls.ricochet" "$folder/points.json"
ok 'and the branches on both sides of it end there' rows "$folder/points.json" '
ends = {row["branch"] for row in proved if " K" in row["why"]}
# one that is regular to its digits may be proved as an orbit
assert len(ends & {4, 16, 18, 19, 20, 21}) >= 4, ends
assert len(rows) == len(proved) == 640'
# A2[12] has two centres, which the branch that hits one more stop at its end lacks: the touch is proved in its own class
ok 'a grazing in the class of a branch that has more mirrors' bash -c '
"$0" prove "$1" --curves --branch 9 | grep "^1 of 1 curves proved, 1 of them from end to end"' "$ricochet" "$folder/two-walls.ricochet"
turned_end() {
    planted two-walls '
state, = db.execute("SELECT state FROM point WHERE branch = 9 AND point = 34").fetchone()
x = floats(state)
db.execute("UPDATE point SET state = ? WHERE branch = 9 AND point = 34", (blob(x[:3] + [x[3] + 1e-6 * x[4], x[4] - 1e-6 * x[3], x[5]]),))'
    prove "$folder/p.ricochet" "$folder/points.json" --branch 9
    rows "$folder/points.json" 'assert [row["point"] for row in rows if row not in proved] == [34], proved'
}
ok 'but not where it is stored 1e-6 away' turned_end
junctions corner
ok 'a gap closes at an impact on another contact' rows "$folder/rows.json" '
assert len(proved) == len(rows) == 20 and [row["how"] for row in rows if row["kind"] == "corner"] == ["a gap closes at an impact on another contact"]'
# refused NAME CODE: no corner of the atlas is proved after that
refused() {
    planted "$1" "$2" && prove "$folder/p.ricochet" "$folder/rows.json" --junctions
    rows "$folder/rows.json" 'assert len(rows) > 10 and not [row for row in proved if row["kind"] == "corner"], proved'
}
ok 'no corner with a state off by 1e-6' refused two-walls '
for id, state in db.execute("SELECT id, state FROM junction WHERE kind = ?", ("corner",)).fetchall():
    x = floats(state)
    db.execute("UPDATE junction SET state = ? WHERE id = ?", (blob([x[0] - 1e-6] + x[1:]), id))'
for name in two-walls corner; do
    ok "nor of $name with other flights" refused "$name" '
for id, flights in db.execute("SELECT id, flights FROM junction WHERE kind = ?", ("corner",)).fetchall():
    db.execute("UPDATE junction SET flights = ? WHERE id = ?", (blob([t + 1e-6 for t in floats(flights)]), id))'
    ok "nor of $name with another energy" refused "$name" 'db.execute("UPDATE junction SET energy = energy * (1 + 2e-8) WHERE kind = ?", ("corner",))'
done
# Frames that pound at two floors: eight branches end where both impacts turn the motion round together, in its middle or
# every half of its period. Flights of no length are no place on the branch alone there.
cat >"$folder/floors.yaml" <<'STUDY'
model:
  mass: [[120, 0, 0, 0], [0, 100, 0, 0], [0, 0, 90, 0], [0, 0, 0, 80]]
  stiffness: [[38000, -18000, 0, 0], [-18000, 18000, 0, 0], [0, 0, 52000, -24000], [0, 0, -24000, 24000]]
  contacts:
    - {normal: [1, 0, -1, 0], clearance: 0.03, sides: upper, law: rigid}
    - {normal: [0, 1, 0, -1], clearance: 0.04, sides: upper, law: rigid}
STUDY
"$ricochet" run "$folder/floors.yaml" -o "$folder/floors.ricochet" --quiet
junctions floors
parted='some = [row for row in proved if row["how"] == "a motion parts two impacts at one instant"]'
ok 'a motion parts two impacts at one instant' rows "$folder/rows.json" "$parted"'
known = 44631.9936085056, 174238.991094092, 193654.327055415
assert len(some) == 8 and all(row["exists"] < 1e-30 and row["distance"] < 1e-12 for row in some), some
assert all(any(abs(row["energy"][0] - E) < 1e-12 * E for row in some) for E in known), some'
ok 'and one at which a gap touches, too, which one branch has as an impact of no speed' rows "$folder/rows.json" '
some = [row for row in proved if row["how"] == "a gap touches beside two impacts at one instant"]
assert len(some) == 4 and all(row["exists"] < 1e-30 and row["distance"] < 1e-12 for row in some), some
assert len(proved) == len(rows) > 180, [row for row in rows if row not in proved]'
beside_ends() {
    local ids
    ids=$(python3 -S -c '
import json, sys
print(*[row["branch"] for row in json.load(open(sys.argv[1])) if row["how"].startswith("a gap touches beside")])' "$folder/rows.json")
    [ "$(wc -w <<<"$ids")" = 4 ] || return 1
    for id in $ids; do
        "$ricochet" prove "$folder/floors.ricochet" --branch "$id" | grep -q '^2 of them as the junctions that they are' || return 1
    done
}
ok 'at which the branches end that come there' beside_ends
unparted() {
    planted floors "$1" && prove "$folder/p.ricochet" "$folder/rows.json" --junctions
    rows "$folder/rows.json" 'some = [row for row in proved if "two impacts at one instant" in row["how"]]
assert len(rows) > 10 and not some, some'
}
ok 'but not where a state is off by 1e-6' unparted '
for id, state in db.execute("SELECT id, state FROM junction WHERE kind = ?", ("corner",)).fetchall():
    x = floats(state)
    db.execute("UPDATE junction SET state = ? WHERE id = ?", (blob([x[0] - 1e-6] + x[1:]), id))'
ok 'nor with another energy' unparted 'db.execute("UPDATE junction SET energy = energy * (1 + 2e-8) WHERE kind = ?", ("corner",))'
# What both turn round in the middle of half a period, with x -> -x: from there to the centre, which the branch keeps.
cat >"$folder/centres.yaml" <<'STUDY'
model:
  mass: [[1.712, 0, 0, 0, 0], [0, 1.417, 0, 0, 0], [0, 0, 1.433, 0, 0], [0, 0, 0, 1.741, 0], [0, 0, 0, 0, 1.965]]
  stiffness:
    - [2.474, -0.346, 0, 0, -1.697]
    - [-0.346, 3.45, 0, 0, -1.788]
    - [0, 0, 0.969, 0, -0.648]
    - [0, 0, 0, 0.37, 0]
    - [-1.697, -1.788, -0.648, 0, 5.866]
  contacts:
    - {normal: [0, 0, 1, 0, 0], clearance: 0.809, sides: both, law: rigid}
    - {normal: [0, 0, 0, 1, -1], clearance: 1.377, sides: both, law: rigid}
explore: {energy: [0, 12], impacts: 4, multiply: 2, depth: 3}
STUDY
"$ricochet" run "$folder/centres.yaml" -o "$folder/centres.ricochet" --quiet
junctions centres
ok 'nor does it matter that the motion is its own image' rows "$folder/rows.json" "$parted"'
assert len(some) == 1 and some[0]["distance"] < 1e-12 and abs(some[0]["energy"][0] - 5.788196613314899) < 1e-12, some'
# A mode that touches 18 times in nine periods touches once in its own class; so do branch points whose other branch
# the atlas does not have.
junctions loose-mass
ok 'a grazing that is gone through several times is one touch' rows "$folder/rows.json" '
assert len(proved) == len(rows) == 48, [row for row in rows if row["verdict"] != "proved"]
assert len([row for row in proved if row["label"] in ("G1_0,18", "G1_0,14", "G1_0,10", "G1_0,6")]) == 4'
ok 'and all points are proved' bash -c '"$0" prove "$1" | grep -q "^1419 of 1419 points proved"' "$ricochet" "$folder/loose-mass.ricochet"
# Impacts that become slower towards one of no speed, each with the square of the next one: 1e-7 is none of no speed, and
# 1e-10 may be stored as one.
sed '/^# The numbers/,$d; s/energy: [^]]*]/energy: [1.8, 3]/; s/frequency: [^]]*]/frequency: [0.34, 2.2]/; s/depth: 4/depth: 2/' \
    examples/paper/base-6.yaml >"$folder/slow.yaml"
"$ricochet" run "$folder/slow.yaml" -o "$folder/slow.ricochet" --quiet
ok 'ends beside impacts that are all but of no speed' bash -c '
for end in "18 50" "23 57" "24 31" "25 27"; do
    "$0" prove "$1" --branch ${end% *} --point ${end#* } | grep "^1 of them as the junctions" || exit 1
done' "$ricochet" "$folder/slow.ricochet"
finish
