#!/usr/bin/env bash
# Certificates, checked by what shares nothing with the program: those that it writes pass, and lies do not.
set -u
. tests/support/tap.sh

if ! python3 -c 'import mpmath' 2>/dev/null; then echo '1..0 # SKIP no mpmath'; exit 77; fi
for name in elementary three-masses two-walls; do
    "$ricochet" run "examples/$name/study.yaml" -o "$folder/$name.ricochet" --quiet
    if "$ricochet" prove "$folder/$name.ricochet" -o "$folder/$name.jsonl" 2>&1 | grep -q 'left out of this program'; then
        echo '1..0 # SKIP the program was built without FLINT'
        exit 77
    fi
done

# checked FILE EVERY: the certificates, or some of them, are accepted, and there are some
checked() {
    awk -v every="$2" 'NR == 1 || NR % every == 2 % every' "$1" >"$folder/some.jsonl"
    tools/check_certificate.py "$folder/some.jsonl" || return 1
    [ "$(wc -l <"$folder/some.jsonl")" -gt 10 ]
}
ok 'certificates of elementary are accepted' checked "$folder/elementary.jsonl" "$(every_of 40)"
ok 'certificates of three-masses are accepted' checked "$folder/three-masses.jsonl" "$(every_of 30)"
ok 'certificates of two-walls are accepted' checked "$folder/two-walls.jsonl" "$(every_of 45)"
ok 'no certificate is no success' bash -c '! tools/check_certificate.py /dev/null'

# lies NAME CODE: Python over the model and the lines of that atlas; refused(LINE) whether the checker refuses what a liar signs
lies() {
    python3 - "$folder/$1.jsonl" "$(every_of 20)" <<END
import copy, json, random, sys
sys.path.insert(0, "tools")
import check_certificate as checker
random.seed(11)
texts = open(sys.argv[1]).read().splitlines()
few = int(sys.argv[2])
first = checker.read_line(texts[0])
lines = [checker.read_line(text) for text in texts[1:]]
short = [line for line in lines if len(line["tau"]) == 1]

def sign(body):
    value = 0xCBF29CE484222325
    for byte in body.encode():
        value = (value ^ byte) * 0x100000001B3 & (1 << 64) - 1
    return body + f', "check": "{value:016x}"}}'

def signed(line):
    return sign(json.dumps({key: line[key] for key in line if key != "check"})[:-1])

def refused(text, model=checker.Model(first)):
    try:
        checker.check(model, checker.read_line(text))
    except (checker.Refused, ArithmeticError, LookupError, TypeError, ValueError) as error:
        return str(error) or type(error).__name__
    return None

def some(count, of=short):
    return [copy.deepcopy(line) for line in random.sample(of, count)]

assert not any(refused(signed(line)) for line in some(3))
$2
END
}

ok 'no digit of 1000 is changed unseen' lies elementary '
for text in random.choices(texts, k=1000):
    where = random.choice([i for i, letter in enumerate(text) if letter.isdigit()])
    new = random.choice([d for d in "0123456789" if d != text[where]])
    try:
        checker.read_line(text[:where] + new + text[where + 1:])
    except checker.Refused:
        continue
    raise AssertionError((text, where, new))'

# Signed anew, a certificate with another digit passes only if it is still true: it says another name of the point, or
# the same point within its radius, or a weaker or another bound of the same number, or the same orbit on another plane.
ok 'a digit that is changed and signed makes no lie' lies elementary '
passed = []
for line in random.choices(short, k=1000 // few):
    text = signed(line)
    body = text[:text.rindex(", \"check\"")]
    where = random.choice([i for i, letter in enumerate(body) if letter.isdigit()])
    new = random.choice([d for d in "0123456789" if d != body[where]])
    text = sign(body[:where] + new + body[where + 1:])
    why = refused(text)
    if why: continue
    after = json.loads(text)
    (key,) = [key for key in after if key != "check" and after[key] != line[key]]
    passed.append(key)
    radius = float(line["exists"]) + float(after["exists"])
    flat = lambda x: [a for part in x for a in flat(part)] if isinstance(x, list) else [checker.Fraction(x)]
    if key in ("x", "v", "tau", "exists"):
        assert all(abs(a - b) <= radius for k in ("x", "v", "tau") for a, b in zip(flat(after[k]), flat(line[k]))), (key, text)
        assert float(after["exists"]) > 0.01 * float(line["exists"]), text
    elif key in ("energy", "period", "trace"):
        (a, b), (c, d) = flat(line[key]), flat(after[key])
        assert c <= b and a <= d, (key, text)
    elif key == "unique":
        assert float(after[key]) < 10 * float(line[key]) or float(after[key]) < 0.01, text
    else:
        assert key in ("branch", "point", "bits", "block", "plane"), (key, text)
assert len(passed) < 0.7 * 1000 // few, len(passed)'

ok 'no state off by 1e-6, flight, or other face' lies elementary '
for line in some(4):
    for key in ("x", "v"):
        lie = copy.deepcopy(line)
        lie[key][0][0] = repr(float(lie[key][0][0]) + 1e-6)
        assert refused(signed(lie)), lie
    lie = copy.deepcopy(line)
    lie["tau"][0] = repr(float(lie["tau"][0]) * (1 + 1e-6))
    assert refused(signed(lie)), lie
    face = next(i for i, f in enumerate(line["faces"]) if f >= 0)
    lie = copy.deepcopy(line)
    lie["faces"][face] = 1 - lie["faces"][face]
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
        lie[key] = [lie[key][1], repr(float(lie[key][1]) * (1 + 1e-9))]
        assert refused(signed(lie)), lie'
ok 'no flag that is turned round, no shifted interval' lies elementary "$turned"
# Both pairs of multipliers of those are real and negative: midway between them the sign changes, too.
ok 'nor where two pairs of multipliers are outside' lies three-masses "$turned"

# The orbit of one impact with rest in between solves the equations for every T; for 4.845 <= T < 5.840 alone it passes no stop.
ok 'a solution that passes a stop is none' lies elementary '
from mpmath import mp, mpf
mp.dps = 60
z = [(11 - mp.sqrt(57)) / 4, (11 + mp.sqrt(57)) / 4]
modes = [[1 / mp.sqrt(2 + (9 - 2 * a) ** 2), (9 - 2 * a) / mp.sqrt(2 + (9 - 2 * a) ** 2)] for a in z]
c, omega = [m[1] - m[0] for m in modes], [mp.sqrt(a) for a in z]
def why(time):
    T = mpf(time)
    s = 1 / sum(c[i] ** 2 / mp.tan(omega[i] * T / 2) / omega[i] for i in range(2))
    q = [s * c[i] / mp.tan(omega[i] * T / 2) / omega[i] for i in range(2)]
    text = lambda a: mp.nstr(a, 50)
    x = [text(sum(modes[i][j] * q[i] for i in range(2))) for j in range(2)]
    v = [text(s * sum(modes[i][j] * c[i] for i in range(2))) for j in range(2)]
    return refused(signed({"type": "point", "branch": 1, "point": 1, "bits": 64, "start": "impact", "end": "rest", "sigma": 1,
        "time": 0, "faces": [0, -1], "x": [x], "v": [v], "tau": [text(T / 2)], "block": 0,
        "plane": ["0e+00", "0e+00", "0e+00", "0e+00", "1e+00"], "exists": "1e-40", "unique": "1e-6",
        "energy": ["0", "1e3"], "period": ["0", "9"], "trace": ["-1e9", "1e9"], "stable": "undecided",
        "symmetric": False, "reversible": True}))
assert not why("4.9") and not why("5.8"), (why("4.9"), why("5.8"))
for T in ("4.7", "6.0"):
    assert "passed" in why(T) or "approach" in why(T), (T, why(T))'
finish
