#!/usr/bin/env bash
# Curves: branches are proved to be one arc of motions from point to point, over folds; what hops, or passes a stop, is not.
set -u
. tests/support/tap.sh

if ! "$ricochet" run examples/elementary/study.yaml -o "$folder/e.ricochet" --quiet; then echo '1..0 # SKIP no atlas'; exit 77; fi
if "$ricochet" prove "$folder/e.ricochet" --curves --branch 4 2>&1 | grep -q 'left out of this program'; then
    echo '1..0 # SKIP the program was built without FLINT'
    exit 77
fi

# curve ATLAS ID: verdict, whether its ends are on it, number of tubes, and why not
curve() { "$ricochet" prove "$1" --curves --branch "$2" --json 2>/dev/null | python3 -S -c '
import json, sys
row, = json.load(sys.stdin)
print(row["verdict"], row["from"], row["to"], row["tubes"], row["why"])'; }
# planted CODE: a copy of the atlas with Python over the database `db` done to it, its digest made anew
planted() { plant "$folder/e.ricochet" "$folder/p.ricochet" "$1"; }
refuses() { curve "$folder/p.ricochet" "$1" | grep -q "^not proved .*$2"; }

# The branch passes a fold of the energy, C1_31, and a branch point; one tube from point to point is enough.
ok 'S2+ is one curve from grazing to grazing, over its fold, by a tube a step' bash -c '[[ $1 =~ ^proved\ True\ True\ (8|9).\  ]]' . "$(curve "$folder/e.ricochet" 3)"
ok 'a branch that ends at the window is one to its end' bash -c '[[ $1 =~ ^proved\ True\ True\ (5|6).\  ]]' . "$(curve "$folder/e.ricochet" 4)"
ok 'A2 begins where a mirror of S2+ is broken, and ends in a grazing' bash -c '[[ $1 =~ ^proved\ True\ True\  ]]' . "$(curve "$folder/e.ricochet" 5)"
for id in 6 7 9 10 12; do
    ok "branch $id is one from end to end" bash -c '[[ $1 =~ ^proved\ True\ True\  ]]' . "$(curve "$folder/e.ricochet" $id)"
done
# C2_32 breaks both mirrors, C3_32 and C4_32 one in flight
for id in 8 13 14; do
    ok "branch $id begins in the orbit that it leaves, by few tubes" bash -c '[[ $1 =~ ^proved\ True\ True\ [1-6]?.\  ]]' . "$(curve "$folder/e.ricochet" $id)"
done
ok 'S6 passes three turns of S2-, of its own class' bash -c '[[ $1 =~ ^proved\ True\ True\ 1[1-4].\  ]]' . "$(curve "$folder/e.ricochet" 11)"
stable() { "$ricochet" prove "$1" --curves --json | python3 -S -c '
import json, sys
for row in json.load(sys.stdin):
    if row["branch"] in (3, 4, 6, 12, 14): assert row["stable"] + row["unstable"] > 0.98, row
    if row["branch"] == 5: assert row["stable"] > 0.8, row'; }
ok 'stability is told along nearly all of them' stable "$folder/e.ricochet"
ok 'so are branches without a mirror, and horizontal ones' bash -c '[[ $1 =~ ^proved ]] && [[ $2 =~ ^proved ]]' . "$(curve "$folder/e.ricochet" 6)" "$(curve "$folder/e.ricochet" 5)"
ok 'linear modes are left out' bash -c '[[ $1 =~ ^left\ out ]]' . "$(curve "$folder/e.ricochet" 1)"

# A2[12] passes the orbit of the branch with a mirror, on which it is found, in its own class, which lacks that.
"$ricochet" run examples/two-walls/study.yaml -o "$folder/w.ricochet" --quiet
ok 'curves without a mirror cross those with one' bash -c '[[ $1 =~ ^proved\ True\ True\  ]]' . "$(curve "$folder/w.ricochet" 10)"

"$ricochet" run examples/three-masses/study.yaml -o "$folder/t.ricochet" --quiet
ok 'of three modes, too, tubes are halved where stability is told by that' bash -c '"$0" prove "$1" --curves --branch 7 --json | python3 -S -c "
import json, sys
row, = json.load(sys.stdin)
assert row[\"unstable\"] > 0.45, row"' "$ricochet" "$folder/t.ricochet"

"$ricochet" run examples/two-springs/study.yaml -o "$folder/b.ricochet" --quiet
ok 'so it is between springs, along nearly all of two curves' bash -c '"$0" prove "$1" --curves --json | python3 -S -c "
import json, sys
for row in json.load(sys.stdin):
    if row[\"branch\"] in (4, 5): assert row[\"stable\"] + row[\"unstable\"] > 0.98, row"' "$ricochet" "$folder/b.ricochet"

# A branch that has an image under x -> -x nearby, where Newton's method for the doubling that it passes comes to that of the image.
# Three masses, free to move but for the stops of the one in the middle.
cat >"$folder/images.yaml" <<'END'
model:
  mass: [[0.75, 0, 0], [0, 0.5, 0], [0, 0, 0.5]]
  stiffness: [[7.5, -7.5, 0], [-7.5, 8, -0.5], [0, -0.5, 0.5]]
  contacts:
    - {law: rigid, normal: [0, 1, 0], clearance: 1.71, sides: both}
explore: {start: modes, frequency: [0.2337, 0.6], energy: [0, 0.14], impacts: 2, multiply: 2, depth: 2}
END
"$ricochet" run "$folder/images.yaml" -o "$folder/i.ricochet" --quiet
ok 'a junction that is passed is told as on the branch, not as on its image' bash -c '"$0" prove "$1" --curves | grep -q "^6 of 6 curves proved, 6 of them from end to end"' "$ricochet" "$folder/i.ricochet"

# Between some of its points the curve is bent so much that Newton's method does not find it from their mean
"$ricochet" run examples/symmetric-path/study.yaml -o "$folder/s.ricochet" --quiet
ok 'a branch is one up to a grazing beside which it is all but singular' bash -c '[[ $1 =~ ^proved\ True\ True\  ]]' . "$(curve "$folder/s.ricochet" 37)"
# It comes to a grazing by ever slower impacts, as slow as the tube is short where their speed is told from a flight
ok 'slow impacts are told from the states behind them, by few tubes' bash -c '[[ $1 =~ ^proved\ True\ True\ (3|4).\  ]]' . "$(curve "$folder/s.ricochet" 26)"

# A3[001] leaves another one where frequencies are far apart: the arc from there is 1e-9 long. Its first points are enough.
mkdir "$folder/beam" && cp examples/beam-lumped/*.mtx "$folder/beam"
sed 's/impacts: .*/impacts: 3/; s/energy: .*/energy: [0, 25]/' examples/beam-lumped/study.yaml >"$folder/beam/study.yaml"
"$ricochet" run "$folder/beam/study.yaml" -o "$folder/beam.ricochet" --quiet
plant "$folder/beam.ricochet" "$folder/p.ricochet" '
high, = db.execute("SELECT energy FROM point WHERE branch = 7 AND point = 2").fetchone()
db.execute("DELETE FROM point WHERE branch = 7 AND point > 2")
db.execute("DELETE FROM junction_branch WHERE branch = 7 AND junction = (SELECT to_junction FROM branch WHERE id = 7)")
db.execute("UPDATE branch SET points = 3, energy_max = ?, to_junction = NULL, stop = ? WHERE id = 7", (high, "window"))'
ok 'a branch of twenty modes begins in the branch point that it leaves' bash -c '[[ $1 =~ ^proved\ True\ True\  ]]' . "$(curve "$folder/p.ricochet" 7)"

# S2- has the word and the class of S2+
planted '
columns = [row[1] for row in db.execute("PRAGMA table_info(point)") if row[1] not in ("branch", "point", "arclength")]
for p in range(45, 90):
    db.execute("UPDATE point SET ({0}) = (SELECT {0} FROM point WHERE branch = 4 AND point = ?) WHERE branch = 3 AND point = ?".format(
        ", ".join(columns)), (p - 45, p))'
ok 'a chord from one branch to another is no curve' refuses 3 'between points 44 and 45'

planted '
for p, state in db.execute("SELECT point, state FROM point WHERE branch = 3 AND point = 30").fetchall():
    x = floats(state)
    x[0] += 1e-6
    E = x[2] ** 2 + x[3] ** 2 / 2 + 4.5 * x[0] ** 2 - x[0] * x[1] + x[1] ** 2 / 2
    db.execute("UPDATE point SET state = ?, energy = ? WHERE branch = 3 AND point = ?", (blob(x), E, p))'
ok 'a point that is off by 1e-6 is on none' refuses 3 'between points 29 and 30'

planted 'db.execute("UPDATE branch SET word = ? WHERE id = 6", ("011",))'
ok 'another word is no curve' refuses 6 ''
# Branch 12 has the word of branch 8, and mirrors
planted '
for name in "state", "flights", "energy", "frequency":
    db.execute("UPDATE point SET {0} = (SELECT {0} FROM point WHERE branch = 8 AND point = 25) WHERE branch = 12 AND point = 25".format(name))'
ok 'an orbit without the mirrors of the branch is not on it' refuses 12 'between points 24 and 25'

planted '
db.execute("DELETE FROM branch_junction WHERE branch = 11 AND junction = 17")
for k, (j,) in enumerate(db.execute("SELECT junction FROM branch_junction WHERE branch = 11 ORDER BY position").fetchall()):
    db.execute("UPDATE branch_junction SET position = ? WHERE branch = 11 AND junction = ?", (k, j))
db.execute("DELETE FROM junction_branch WHERE branch = 11 AND junction = 17")'
ok 'without what it crosses S6 is not one curve there' refuses 11 'between points 47 and 48'
planted '
for branch, junction in ((13, 10), (14, 18)):
    db.execute("UPDATE branch SET from_junction = ? WHERE id = ?", (junction, branch))
    db.execute("UPDATE junction_branch SET branch = ? WHERE junction = ? AND branch = ?", (branch, junction, 27 - branch))'
for id in 13 14; do
    ok "branch $id does not begin where another mirror is broken" bash -c '[[ $1 =~ ^proved\ False\ True\  ]]' . "$(curve "$folder/p.ricochet" $id)"
done

# The grazing orbit of another branch at the end of A3: no tube reaches it
planted '
for p in (71,):
    for name in "state", "flights", "energy", "frequency":
        db.execute("UPDATE point SET {0} = (SELECT {0} FROM point WHERE branch = 6 AND point = 69) WHERE branch = 6 AND point = ?".format(name), (p,))'
ok 'an end that does not touch is joined with no grazing' bash -c '[[ $1 =~ ^proved\ True\ False\  ]]' . "$(curve "$folder/p.ricochet" 6)"

# family FROM TO: one impact, at rest in between, q_i = s c_i cos(omega_i (t - T / 2)) / (omega_i sin(omega_i T / 2)): solves
# the equations for every T, and is a motion, which passes no stop, for 4.845 <= T < 5.840 alone
family() { planted "
roots = [(11 - math.sqrt(57)) / 4, (11 + math.sqrt(57)) / 4]
modes = [[1 / math.sqrt(2 + (9 - 2 * z) ** 2), (9 - 2 * z) / math.sqrt(2 + (9 - 2 * z) ** 2)] for z in roots]
c, omega = [m[1] - m[0] for m in modes], [math.sqrt(z) for z in roots]
db.execute('UPDATE branch SET word = ?, impacts = 1, symmetric = 0, mirror = ? WHERE id = 4', ('0', 'impact-rest'))
n, = db.execute('SELECT count(*) FROM point WHERE branch = 4').fetchone()
for p in range(n):
    T = $1 + p * ($2 - $1) / (n - 1)
    s = 1 / sum(c[i] ** 2 / math.tan(omega[i] * T / 2) / omega[i] for i in range(2))
    q = [s * c[i] / math.tan(omega[i] * T / 2) / omega[i] for i in range(2)]
    x = [sum(modes[i][j] * q[i] for i in range(2)) for j in range(2)]
    v = [s * sum(modes[i][j] * c[i] for i in range(2)) for j in range(2)]
    E = v[0] ** 2 + v[1] ** 2 / 2 + 4.5 * x[0] ** 2 - x[0] * x[1] + x[1] ** 2 / 2
    db.execute('UPDATE point SET state = ?, flights = ?, energy = ?, frequency = ? WHERE branch = 4 AND point = ?',
               (blob(x + v), blob([T]), E, 2 * math.pi / T, p))"; }
family 4.85 5.83
ok 'a family of one impact is a curve where it is one' bash -c '[[ $1 =~ ^proved ]]' . "$(curve "$folder/p.ricochet" 4)"
family 5.5 6.2
ok 'it is a ghost beyond T = 5.840, and no curve' refuses 4 'between points 27 and 28: the first impact is not proved to approach'

# A branch that crosses one of a third of its period half way between stored points, a hundredth apart: in the long form, six seconds
if long_form; then
    "$ricochet" run examples/fractal-base/study.yaml -o "$folder/base.ricochet" --quiet
    ok 'a curve is crossed where stored points are not near' bash -c '[[ $1 =~ ^proved\ True\ True\  ]]' . "$(curve "$folder/base.ricochet" 38)"
fi
finish
