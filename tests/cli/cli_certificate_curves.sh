#!/usr/bin/env bash
# Certificates of curves and junctions, checked by what shares nothing with the program: what it writes passes, lies do not.
set -u
. tests/support/tap.sh
. tests/support/proofs.sh

needs_checker
for name in elementary three-masses two-walls corner stop-and-spring symmetric-chain bilinear cascade; do
    "$ricochet" run "examples/$name/study.yaml" -o "$folder/$name.ricochet" --quiet
    if "$ricochet" prove "$folder/$name.ricochet" --junctions -o "$folder/$name-j.jsonl" 2>&1 | grep -q 'left out of this program'; then
        echo '1..0 # SKIP the program was built without FLINT'
        exit 77
    fi
done
certificates "$folder/elementary.ricochet" "$folder/elementary-c.jsonl" --curves $(some_of '3 4 5 8 11' '') >"$folder/said" 2>&1
certificates "$folder/three-masses.ricochet" "$folder/three-masses-c.jsonl" --curves $(some_of 4 '') >"$folder/said" 2>&1
certificates "$folder/two-walls.ricochet" "$folder/two-walls-c.jsonl" --curves $(some_of 21 '') >"$folder/said" 2>&1
certificates "$folder/bilinear.ricochet" "$folder/bilinear-c.jsonl" --curves $(some_of 3 '') >"$folder/said" 2>&1
certificates "$folder/cascade.ricochet" "$folder/cascade-c.jsonl" --curves 4 >"$folder/said" 2>&1
accepted() { "$python" tools/check_certificate.py "$@" >"$folder/checked" && [ "$(tail -1 "$folder/checked")" = "$count accepted, 0 refused" ]; }
# some NAME EVERY HOW_MANY: one certificate of a junction in so many, of as many as there are
some()
{
    awk -v every="$2" 'NR == 1 || NR % every == 0' "$folder/$1-j.jsonl" >"$folder/some.jsonl" && count=$(($(wc -l <"$folder/some.jsonl") - 1))
    [ -z "${3:-}" ] || [ "$(wc -l <"$folder/$1-j.jsonl")" = $(($3 + 1)) ] || count=none
}
some elementary "$(every_of 3)" 18
ok 'junctions of elementary are accepted, and are those of the atlas' accepted "$folder/some.jsonl" "$folder/elementary.ricochet"
some corner "$(every_of 4)"
ok 'so are corners' accepted "$folder/some.jsonl" "$folder/corner.ricochet"
some stop-and-spring "$(every_of 2)"
ok 'junctions beside a spring' accepted "$folder/some.jsonl" "$folder/stop-and-spring.ricochet"
some three-masses "$(every_of 6)"
ok 'and those of three masses' accepted "$folder/some.jsonl" "$folder/three-masses.ricochet"
count=8
ok 'and all of bilinear' accepted "$folder/bilinear-j.jsonl" "$folder/bilinear.ricochet"

some symmetric-chain "$(every_of 2)" 13
ok 'and those that a permutation and the way back take to themselves' accepted "$folder/some.jsonl" "$folder/symmetric-chain.ricochet"

# lies CODE: Python over the certificates; refused(LINE): why the checker refuses what a liar signs, or None
lies() {
    "$python" - "$folder" "$(every_of 40)" <<END
import copy, json, random, sys
sys.path.insert(0, "tools")
import check_certificate as checker
random.seed(3)
folder, every = sys.argv[1], int(sys.argv[2])
def read(name):
    lines = [checker.read_line(text) for text in open(f"{folder}/{name}.jsonl").read().splitlines()]
    return checker.Model(lines[0]), lines[1:]
model, curves = read("elementary-c")
of = {line["branch"]: line for line in curves}
def refused(line, model=model):
    body = json.dumps({key: line[key] for key in line if key != "check"})[:-1]
    value = 0xCBF29CE484222325
    for byte in body.encode(): value = (value ^ byte) * 0x100000001B3 & (1 << 64) - 1
    try:
        line = checker.read_line(body + f', "check": "{value:016x}"}}')
        checker.check(model, line)
    except checker.REFUSED as error:
        return str(error) or type(error).__name__
def part(line, first, last, arc=0):
    return {**line, "arcs": [copy.deepcopy(line["arcs"][arc][first:last])]}
$1
END
}
# S2+ over its fold and beside the grazing, A2, which is straight, and the step of S6 that ends before what it crosses
ok 'curves of elementary are accepted' lies '
pieces = [(3, 0, 2, 0), (3, 40, 42, 0), (5, 3, 5, 0)] if every > 1 else [(b, 0, len(l["arcs"][0]), 0) for b, l in of.items() if len(l["tau"]) < 3]
for branch, first, last, arc in pieces + [(11, 0, 2, 1), (8, 30, 32, 0)]:
    why = refused(part(of[branch], first, last, arc))
    assert not why, (branch, first, why)
assert len(of) == (5 if every > 1 else 12) and len(of[11]["arcs"]) == 2'
ok 'and of three masses' lies '
other, lines = read("three-masses-c")
line = min(lines, key=lambda line: len(line["faces"]))
assert not refused(part(line, 1, 3), other)'
# Where the spring is just met, and where it turns the motion within a thousandth of the period.
ok 'and of a stiff spring' lies '
other, lines = read("bilinear-c")
for line in lines:
    last = len(line["arcs"][0])
    for first in [0, last // 2] if every > 1 else range(last - 1): assert not refused(part(line, first, first + 2), other), first'
ok 'and beside a grazing, where the arc bends off its chord by more than what a gap is open' lies '
other, lines = read("two-walls-c")
line = next(line for line in lines if line["branch"] == 21)
for first in [16] if every > 1 else range(14, len(line["arcs"][0]) - 1): assert not refused(part(line, first, first + 2), other), first'
# Beside a branch point a tube is longer than bounds number by number bear: the checker halves it itself, and takes no
# longer for that than for orbits in between.
ok 'and beside a branch point, where it has a line to halve' lies '
other, (line,) = read("cascade-c")
assert not refused(part(line, 0, 2), other)'
certificates "$folder/cascade.ricochet" "$folder/cascade-five.jsonl" '' 5 >"$folder/said" 2>&1
awk 'NR == 1 || /"trace": \[-1000000000000, -12\]/' "$folder/cascade-five.jsonl" >"$folder/some.jsonl"
count=1
ok 'a trace that is rounded up to one digit more is accepted' accepted "$folder/some.jsonl"
certificates "$folder/cascade.ricochet" "$folder/cascade-six.jsonl" --curves 6 >"$folder/said" 2>&1
ok 'which is why there are few orbits in between' [ "$(grep -o '"held"' "$folder/cascade-six.jsonl" | wc -l)" -lt 300 ]
ok 'what leaves out all orbits but the first and the last is joined all the same' lies '
assert not refused({**of[3], "arcs": [[of[3]["arcs"][0][0], of[3]["arcs"][0][-1]]]})'
ok 'and nothing by a box that is only tried' lies '
import certificate_chain as chain
chain.TRIES = 1
assert refused(part(of[3], 40, 42)) == "an arc is not proved to be one"'
ok 'a chord from one branch to another is none' lies '
assert (of[3]["faces"], of[3]["start"]) == (of[4]["faces"], of[4]["start"])
assert refused({**of[3], "arcs": [[of[3]["arcs"][0][44], of[4]["arcs"][0][20]]]})'
# The branch point that both arcs end at is on no arc: its equations are singular.
ok 'nor is what crosses another curve, has an orbit twice, or the mirrors of another one' lies '
whole = part(of[5], 3, 6)
whole["arcs"][0][1] = whole["arcs"][0][0]
assert refused(whole) == "an orbit stands there twice"
before, behind = of[11]["arcs"]
assert refused({**of[11], "arcs": [[before[-1], behind[0]]]})
assert refused({**part(of[3], 40, 42), "end": "rest"})
assert refused({**part(of[5], 3, 5), "faces": [0, 0]})
assert refused({**of[5], "arcs": [of[5]["arcs"][0][:1]]}) == "an arc has no two orbits"'
# Beside a corner solutions of the equations pass the stop that the orbit of the corner meets at an impact.
ok 'no curve leads from the orbit of a corner to what passes a stop' lies '
import certificate_balls as numbers
model, lines = read("corner-j")
def node(line, said, **question):
    blocks, n = [said[i:i + 2 * model.n + 1] for i in range(0, len(said), 2 * model.n + 1)], model.n
    return {**question, "x": [b[:n] for b in blocks], "v": [b[n:-1] for b in blocks], "tau": [b[-1] for b in blocks]}
line = next(line for line in lines if line["where"][0] == "gap")
at = [a for one in zip(line["x"], line["v"], line["tau"]) for a in (*one[0], *one[1], one[2])]
whole, passed = {"type": "curve", **{key: line[key] for key in ("start", "end", "faces")}}, []
for step in (10 ** 14, -10 ** 14):
    near = [(at[0] + step) // 1000 * 1000, *at[1:]]
    orbit = checker.System(model, {**whole, **node(line, near, held=[0, 0])})
    u = orbit.centre
    for _ in range(8): u = (u - numbers.inverse(orbit.slopes(u)) @ orbit.equations(u)).middle
    near = node(line, [(int(x) * 10 ** 18 * 2 // numbers.ONE + 1) // 2 for x in u.mid[:, 0]], held=[0, 0])
    orbit = checker.System(model, {**whole, **near})
    try: orbit.stands(orbit.prove())
    except ValueError as error: passed.append(str(error))
    assert refused({**whole, "arcs": [[node(line, at, where=line["where"]), near]]}, model), step
assert len(passed) == 1 and "passed" in passed[0], passed'
ok 'no digit of an orbit of a curve is changed and signed anew' lies '
for _ in range(1 + 40 // every):
    line = part(of[5], 3, 5)
    node = random.choice(line["arcs"][0])
    key = random.choice("x v tau".split())
    numbers = node[key] if key == "tau" else node[key][0]
    at = random.randrange(len(numbers))
    digits = list(str(numbers[at]))
    where = random.choice([i for i, d in enumerate(digits) if d.isdigit()])
    digits[where] = random.choice([d for d in "0123456789" if d != digits[where]])
    numbers[at] = int("".join(digits))
    assert refused(line), (key, at, line)'
ok 'no grazing with another digit, impact, or speed' lies '
model, lines = read("elementary-j")
slow = [line for line in lines if line["where"][0] == "speed"]
for line in slow[:2 if every > 1 else 4]:
    for key in ("x", "v", "tau"):
        lie = copy.deepcopy(line)
        there = lie[key] if key == "tau" else lie[key][0]
        there[-1] += 1
        assert refused(lie), lie
    for key in ("energy", "period"):
        lie = copy.deepcopy(line)
        lie[key][0] += 1
        assert refused(lie) == f"the {key} is another one", lie
    others = [k for k in range(len(line["faces"])) if k != line["where"][1]]
    assert all(refused({**line, "where": ["speed", k]}) for k in others), line
    assert refused({**line, "where": [*line["where"], 0]}) == "what is held or vanishes has other numbers", line'
ok 'no junction of another kind' lies '
model, lines = read("elementary-j")
others = [["energy"], ["period"], ["double"], ["break", 0, 1], ["break", 1, 0], ["break", 1, 1], ["turn", 1, 3], ["turn", 1, 6]]
for line in [line for line in lines if line["where"][0] != "speed"][::every and (4 if every > 1 else 1)]:
    for where in others:
        if where != line["where"] and not where[0] == line["where"][0] == "turn":
            assert refused({**line, "where": where}), (line, where)'
ok 'no other permutation, none that the structure has not, and none of a point' lies '
model, lines = read("symmetric-chain-j")
twins = [line for line in lines if "twin" in line]
assert len(twins) == 3 and not any(refused(line, model) for line in twins)
for line in twins:
    for twin in ([3, 2, 1], [-3, -2, -1], [3, -2, 1], [1, 3, 2], [2, 3, 1], [1, 2, 3], [-1, -2, -3], [3, 2], [3, 2, 2], [0, 2, 3]):
        assert twin == line["twin"] or refused({**line, "twin": twin}, model), (twin, line)
    ends = ["twin", "rest", "centre", "impact", "general"]
    for start in ends[1:]:
        assert refused({**line, "start": start}, model), (start, line)
    assert refused({key: line[key] for key in line if key != "twin"}, model)
    assert refused({**line, "type": "point", "point": 3}, model) and refused({**line, "where": ["break", 1, 0]}, model)
    lie = copy.deepcopy(line)
    lie["x"][0][0] += 1
    assert refused(lie, model), lie
first = checker.read_line(open(f"{folder}/symmetric-chain-j.jsonl").readline().rstrip())
for key, i in (("mass", 0), ("stiffness", 2)):
    other = copy.deepcopy(first)
    other[key][i][i] += 1e-12
    assert refused(twins[0], checker.Model(other)) == "the structure is not taken to itself"
for sides, clearance in (("upper", 1.0), ("both", 1.0000001)):
    other = copy.deepcopy(first)
    other["sides"][1], other["clearances"][1] = sides, clearance
    assert refused(twins[0], checker.Model(other))'
ok 'nor a corner at another event, of another contact, or whose flight lasts' lies '
model, lines = read("corner-j")
corners = [line for line in lines if line["where"][0] in ("gap", "time")]
assert corners
for line in corners:
    where = line["where"]
    if where[0] == "gap": # a gap that moves the other way is passed
        orbit, face = checker.System(model, line), tuple(where[2:])
        u = orbit.prove()
        orbit.stands(u)
        model.speeds[face] = -model.speeds[face]
        try: orbit.stands(u)
        except ValueError as error: assert "no speed" in str(error), error
        else: assert False, line
        model.speeds[face] = -model.speeds[face]
    for k in range(len(line["faces"])):
        if k != where[1]: assert refused({**line, "where": [where[0], k, *where[2:]]}), (line, k)
    for face in model.faces:
        if where[0] == "time" or list(face) != where[2:]: assert refused({**line, "where": ["gap", where[1], *face]}), (line, face)'
finish
