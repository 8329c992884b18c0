#!/usr/bin/env bash
# Certificates, checked by what shares nothing with the program: those that it writes pass, and lies do not.
set -u
. tests/support/tap.sh
. tests/support/proofs.sh

needs_checker
while read -r name some; do
    "$ricochet" run "examples/$name/study.yaml" -o "$folder/$name.ricochet" --quiet
    long_form && some=
    if certificates "$folder/$name.ricochet" "$folder/$name.jsonl" '' $some 2>&1 | grep -q 'left out of this program'; then
        echo '1..0 # SKIP the program was built without FLINT'
        exit 77
    fi
done <<'END'
elementary
three-masses 5 7 8
two-walls 6 9
stop-and-spring 3 4 7
bilinear 3
END

# checked FILE EVERY: the certificates, or some of them, are accepted, and there are some
checked() {
    awk -v every="$2" 'NR == 1 || NR % every == 2 % every' "$1" >"$folder/some.jsonl"
    "$python" tools/check_certificate.py "$folder/some.jsonl" "${1%.jsonl}.ricochet" || return 1
    [ "$(wc -l <"$folder/some.jsonl")" -gt "$(some_of 2 5)" ]
}
ok 'certificates of elementary are accepted' checked "$folder/elementary.jsonl" "$(every_of 340)"
ok 'certificates of three-masses are accepted' checked "$folder/three-masses.jsonl" "$(every_of 90)"
ok 'certificates of two-walls are accepted' checked "$folder/two-walls.jsonl" "$(every_of 60)"
ok 'certificates of stop-and-spring are accepted' checked "$folder/stop-and-spring.jsonl" "$(every_of 60)"
ok 'certificates of bilinear, whose springs turn a motion within 1e-5 s, are accepted' checked "$folder/bilinear.jsonl" "$(every_of 12)"
# The last ones before a grazing end, where a gap all but closes in flight, and the first ones.
ends() {
    awk 'NR == 1 { print; next }
        { split($4, branch, ","); if (branch[1] != last) { if (last) print line; print }; last = branch[1]; line = $0 }
        END { print line }' "$1" | awk -v every="$(every_of 12)" 'NR == 1 || NR % every == 0' >"$folder/ends.jsonl"
    [ "$(wc -l <"$folder/ends.jsonl")" -gt "$(some_of 2 10)" ] && (ulimit -t 60; "$python" tools/check_certificate.py "$folder/ends.jsonl")
}
ok 'the first and last of every branch in no more time' ends "$folder/elementary.jsonl"
ok 'no certificate is no success' bash -c '! "$0" tools/check_certificate.py /dev/null' "$python"

# Numbers in balls, some at their very ends, by exact fractions, and flights by mpmath.
balls() {
    "$python" - <<'END'
import random, sys
sys.path.insert(0, "tools")
from fractions import Fraction
from mpmath import mp
import certificate_balls as numbers
from certificate_balls import ONE, Ball, ball
random.seed(5)
def number():
    mid = int(random.choice([1, -1]) * 10 ** random.uniform(-60, 12) * 2.0 ** 200) << 88
    rad = random.choice([0.0, 10 ** random.uniform(-80, 3)])
    return Ball(mid, rad), Fraction(mid, ONE) + Fraction(rad) * random.choice([-1, 1, Fraction(random.randint(-99, 99), 99)])
def holds(a, true): return abs(Fraction(int(a.mid), ONE) - true) <= Fraction(float(a.rad))
for _ in range(2000):
    (a, x), (b, y) = number(), number()
    assert holds(a + b, x + y) and holds(a - b, x - y) and holds(a * b, x * y)
    assert Fraction(float(a.most)) >= abs(x) and (not a > 0 or x > 0)
    try: assert holds(a / b, x / y)
    except ValueError: assert float(b.rad) >= 0.99 * abs(float(b.near))
for _ in range(100):
    rows, columns = ([number() for _ in range(5)] for _ in range(2))
    A, B = (numbers.stack([one[None] for one, _ in some])[:, 0] for some in (rows, columns))
    assert holds(A @ B, sum(x * y for (_, x), (_, y) in zip(rows, columns)))
    x = Fraction(random.randint(-10 ** 9, 10 ** 9), random.randint(1, 10 ** 9))
    assert holds(ball(x), x) and holds(ball(float(x)), Fraction(float(x)))
mp.dps = 120
ratio = lambda a: mp.mpf(int(Fraction(a).numerator)) / int(Fraction(a).denominator)
for n in (1, 2, 3, 2, 3):
    one = numbers.eye(n)
    K = numbers.each(lambda _: random.randint(-3, 3), one)
    K = K @ K.T + random.choice([0, 1000]) * one
    phase = numbers.Phase(numbers.framed([[K, 0 * one], [0 * one, one]]) * Fraction(1), numbers.framed([[0 * one, one], [-one, 0 * one]]))
    t, rad = random.uniform(0, 9), random.choice([0.0, 1e-40, 1e-3])
    E, true = phase.exp(ball(t) + Ball(0, rad)), Fraction(t) + Fraction(rad) * random.choice([-1, 1])
    A = mp.matrix([[ratio(Fraction(int(a), ONE)) for a in row] for row in phase.A.mid])
    true = mp.expm(A * ratio(true), method="taylor")
    for i in range(2 * n + 1):
        for j in range(2 * n + 1):
            off, radius = abs(mp.mpf(int(E[i, j].mid)) / ONE - true[i, j]), float(E[i, j].rad)
            assert off <= radius and (rad or radius < 1e-60), (n, i, j, off, radius)
END
}
ok 'balls hold what exact numbers are, and flights what mpmath says' balls

# lies NAME CODE: Python over the model and the lines of that atlas; refused(LINE): why the checker refuses what a liar signs, or None
lies() {
    "$python" - "$folder/$1" "$(every_of 300)" <<END
import copy, json, random, sys
sys.path.insert(0, "tools")
import check_certificate as checker
random.seed(11)
texts = open(sys.argv[1] + ".jsonl").read().splitlines()
few = int(sys.argv[2])
if few > 1: texts[1:] = texts[1::4]
least = lambda count: -(-count // few) # of the long form's
structure, points = checker.read_atlas(sys.argv[1] + ".ricochet")
first = checker.read_line(texts[0])
model = checker.Model(first)
lines = [checker.read_line(text) for text in texts[1:]]
short = [line for line in lines if len(line["tau"]) == 1] or lines

def sign(body):
    value = 0xCBF29CE484222325
    for byte in body.encode():
        value = (value ^ byte) * 0x100000001B3 & (1 << 64) - 1
    return body + f', "check": "{value:016x}"}}'

def body(line):
    return json.dumps({key: line[key] for key in line if key != "check"})[:-1]

def reason(attempt):
    try:
        attempt()
    except checker.REFUSED as error:
        return str(error) or type(error).__name__
    return None

def refused(text, model=model):
    return reason(lambda: checker.check(model, checker.read_line(text), points))

def signed(line):
    return sign(body(line))

def some(count, of=short):
    return [copy.deepcopy(line) for line in random.sample(of, count if few == 1 else 1 + count // 6)]

# Another digit at a random place.
def change(text):
    where = random.choice([i for i, letter in enumerate(text) if letter.isdigit()])
    return text[:where] + random.choice([d for d in "0123456789" if d != text[where]]) + text[where + 1:]

assert not any(refused(signed(line)) for line in some(3))
$2
END
}

ok 'no digit of 1000 is changed unseen' lies elementary '
for text in random.choices(texts, k=1000):
    lie = change(text)
    assert reason(lambda: checker.read_line(lie)), lie'

# Nor where it is signed anew: all numbers follow from the one that is held, which is a multiple of 1000 units of the last digit.
ok 'no digit is changed and signed anew' lies elementary '
for line in random.choices(short, k=least(900)) + random.choices(lines, k=least(100)):
    lie = sign(change(body(line)))
    assert refused(lie), lie'
ok 'no digit of three masses is changed and signed anew' lies three-masses '
for line in random.choices(short, k=least(200)):
    lie = sign(change(body(line)))
    assert refused(lie), lie'
ok 'no digit of the structure is changed and signed anew' lies three-masses '
for _ in range(least(100)):
    lie = sign(change(body(first)))
    def look():
        line = checker.read_line(lie)
        other = checker.Model(line)
        if structure == {key: line[key] for key in structure}: assert refused(signed(short[0]), other), lie
        else: raise ValueError
    assert reason(look) or json.loads(lie)["time"] != first["time"], lie'

ok 'no spring is pressed where its gap is open, from its first closing on' lies bilinear '
from certificate_chain import DEEPEST
line = min(lines, key=lambda line: line["point"])
orbit = checker.System(model, line)
u = orbit.prove()
orbit.stands(u)
closed = next(phase for phase, faces in zip(orbit.phases, orbit.closed) if faces)
flies = type(closed).flies
def other(phase, rows, W, factors, t, depth, *met):
    flies(phase, -rows if phase is closed and depth == DEEPEST else rows, W, factors, t, depth, *met)
type(closed).flies = other
assert reason(lambda: orbit.stands(u)) == "a face is passed, or not approached"'

ok 'no spring is another one, nor one that opens where it closes' lies stop-and-spring '
line = next(line for line in lines if max(line["faces"]) > 2 and line["point"] > 20)
stiffer, lie = copy.deepcopy(first), copy.deepcopy(line)
stiffer["springs"][1] *= 1 + 1e-9
assert refused(signed(line), checker.Model(checker.read_line(signed(stiffer))))
lie["faces"] = [(face + 3) % 6 if face in (1, 2, 4, 5) else face for face in line["faces"]]
assert refused(signed(lie)), lie
assert not refused(signed(line))'
# Faces are counted on where a spring opens: what says so of a stop, or of a spring that closes, is no other name for the same.
opened='
for faces in sorted({tuple(line["faces"]) for line in lines}):
    line = next(line for line in lines if tuple(line["faces"]) == faces)
    for k in (k for k, face in enumerate(faces) if face >= 0):
        lie = copy.deepcopy(line)
        lie["faces"][k] = (faces[k] + len(model.faces)) % (2 * len(model.faces))
        assert refused(signed(lie)), lie'
ok 'no stop opens' lies elementary "$opened"
ok 'no event of a spring is said to be the other one' lies stop-and-spring "$opened"
ok 'no state off by 1e-6, flight, or other face' lies elementary '
for line in some(4):
    for key, to in (("x", line["x"][0]), ("v", line["v"][0]), ("tau", line["tau"])):
        lie = copy.deepcopy(line)
        there = lie[key] if key == "tau" else lie[key][0]
        there[0] += 10 ** 12
        assert refused(signed(lie)), lie
    face = next(i for i, f in enumerate(line["faces"]) if f >= 0)
    lie = copy.deepcopy(line)
    lie["faces"][face] = 1 - lie["faces"][face]
    assert refused(signed(lie)), lie'

ok 'no mirror of rest is one of the centre, and no chain is whole that is half' lies elementary '
mirrors = [line for line in short if {line["start"], line["end"]} & {"rest", "centre"}]
for line in some(6, mirrors):
    lie = copy.deepcopy(line)
    for key in ("start", "end"): lie[key] = {"rest": "centre", "centre": "rest"}.get(lie[key], lie[key])
    lie["symmetric"] = not lie["symmetric"]
    assert refused(signed(lie)), lie
for line in some(3, [line for line in lines if line["start"] == "general" and len(line["tau"]) < 4]):
    lie = copy.deepcopy(line)
    lie["faces"][-1] = 1 - lie["faces"][-1]
    lie["symmetric"] = not lie["symmetric"]
    assert refused(signed(lie)), lie
    lie = copy.deepcopy(line)
    for key in ("x", "v", "tau"): lie[key].pop()
    lie["faces"].pop(-2)
    assert refused(signed(lie)), lie'

turned='
for line in some(4, short if len(first["mass"]) == 2 else [line for line in short if line["branch"] == 7]):
    lie = copy.deepcopy(line)
    lie["stable"] = {"yes": "no", "no": "yes"}[lie["stable"]]
    assert refused(signed(lie)).startswith("the stability"), lie
    for key in ("symmetric", "reversible"):
        lie = copy.deepcopy(line)
        lie[key] = not lie[key]
        assert refused(signed(lie)) == "a symmetry is wrong", lie
    for key in ("energy", "period"):
        lie = copy.deepcopy(line)
        lie[key][0] += 1
        assert refused(signed(lie)) == f"the {key} is another one", lie
    lie = copy.deepcopy(line)
    lie["point"] += 1
    assert refused(signed(lie)), lie'
ok 'no flag that is turned round, no other number, no other name' lies elementary "$turned"
# Both pairs of multipliers of those are real and negative: the signs of a polynomial between them tell nothing.
ok 'nor where two pairs of multipliers are outside' lies three-masses "$turned"

# The orbit of one impact with rest in between solves the equations for every T; for 4.845 <= T < 5.840 alone it passes no stop.
ok 'a solution that passes a stop is none' lies elementary '
from mpmath import mp, mpf
z = [(11 - mp.sqrt(57)) / 4, (11 + mp.sqrt(57)) / 4]
modes = [[1 / mp.sqrt(2 + (9 - 2 * a) ** 2), (9 - 2 * a) / mp.sqrt(2 + (9 - 2 * a) ** 2)] for a in z]
c, omega = [m[1] - m[0] for m in modes], [mp.sqrt(a) for a in z]
unit = mpf(2) ** -first["time"]
def why(time):
    T = mpf(time)
    s = 1 / sum(c[i] ** 2 / mp.tan(omega[i] * T / 2) / omega[i] for i in range(2))
    q = [s * c[i] / mp.tan(omega[i] * T / 2) / omega[i] for i in range(2)]
    number = lambda a: int(mp.nint(a * 10 ** 18))
    x = [number(sum(modes[i][j] * q[i] for i in range(2))) for j in range(2)]
    v = [number(s * unit * sum(modes[i][j] * c[i] for i in range(2))) for j in range(2)]
    orbit = checker.System(model, {"start": "impact", "end": "rest", "faces": [0, -1], "x": [x], "v": [v],
        "tau": [number(T / 2 / unit)], "held": [0, 4]})
    u = orbit.prove()
    return reason(lambda: orbit.stands(u))
assert not why("5.8") and (few > 1 or not why("4.9"))
for T in ("6.0",) if few > 1 else ("4.7", "6.0"):
    assert "passed" in why(T), (T, why(T))'
finish
