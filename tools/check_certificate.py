#!/usr/bin/env python3
"""Checks certificates of `ricochet prove` by other means: check_certificate.py FILE [ATLAS]

The first line is the structure, in decimals. Of every other line the class of the orbit and the one
number that is held, or the impact that has no speed, are the question; the answer is computed here in
interval arithmetic (check_chain.py), and has to be, digit by digit, what the line says; with an atlas,
what is stored there. Curves are in check_curve.py. See docs/proofs.md.
"""
import json
import sqlite3
import sys

from mpmath import mp, mpf

import check_curve
from check_chain import SIDES, UNIT, Chain, Model, need, rounded

NEAR = 1e-8  # what an atlas stores is that near to the orbit


def read_line(text):
    """The last field is the digest FNV-1a, 64 bits, of all before it: it finds accidents."""
    value = 0xCBF29CE484222325
    for byte in text.rpartition(', "check": "')[0].encode():
        value = (value ^ byte) * 0x100000001B3 & (1 << 64) - 1
    line = {**json.loads(text), "check": f"{value:016x}"}
    need(json.dumps(line) == text, "the line does not match its checksum, or is written otherwise")
    return line


def stability(sums):
    """Stable: all r are real, apart and in (-2, 2), so that the matrix of the sums of
    (4 - r^2) r^(i+j) is positive definite; its signature counts those, less real ones outside
    (Hermite). Where r are large the sum of r^2k is more than n 4^k."""
    n, stable = len(sums) // 2, "yes"
    if any((sums[2 * k] > n * 4 ** k) is True for k in range(1, n + 1)):
        return "no"
    rows = [[4 * sums[i + j] - sums[i + j + 2] for j in range(n)] for i in range(n)]
    while rows:
        (pivot, *first), *rest = rows
        if (pivot > 0) is not True:
            stable = "no"
        if not ((pivot > 0) is True or (pivot < 0) is True):
            return "undecided"
        rows = [[a - b / pivot * row[0] for a, b in zip(row[1:], first)] for row in rest]
    return stable


def check(model, line, points=None):
    """All that the line says, from its question."""
    chain, n, count = Chain(model, line), model.n, len(line["tau"]) * (2 * model.n + 1)
    point = line["type"] == "point"
    need(point == (chain.slow is None), "it is no grazing")
    u = chain.prove()
    need([rounded(a, UNIT) for a in u[:count]] == chain.said, "other states or times")
    chain.passage(u)
    w, sums = u[:2 * n, 0], chain.multipliers(u) if point else None
    copies = (1 if chain.general else 2) * (2 if chain.symmetric else 1)
    numbers = {"energy": chain.energy(w, 1 + u[count] if chain.general else 1) * model.scale ** 2,
               "period": copies * sum(u[2 * n:count:2 * n + 1]) / model.scale}
    stored = points[line["branch"] if point else "junction", line[line["type"]]] if points else {}
    if "trace" in line:
        numbers["trace"] = sums[2] - 2 * (n - 1) if chain.symmetric else sums[1]
    for name, true in numbers.items():
        power = max(UNIT, int(mp.floor(mp.log10(mpf(abs(true).mid)))) - 11)
        need(line[name] == [rounded(true, power), power], f"the {name} is another one")
        need(name not in stored or abs(true / stored[name] - 1) < NEAR, "the atlas has another one")
    if not point:
        return
    need(line["stable"] in ("undecided", stability(sums)), f"the stability is: {stability(sums)}")
    need(line["symmetric"] is chain.symmetric, "a symmetry is wrong")
    need(line["reversible"] is not chain.general, "a symmetry is wrong")


def read_atlas(path):
    """What the first line has to say of the structure, and energy and period of the points."""
    import yaml
    db = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    (text,) = db.execute("SELECT value FROM meta WHERE key = 'model'").fetchone()
    model = yaml.load(text, yaml.BaseLoader)["model"]
    plain = lambda a: list(map(plain, a)) if type(a) is list else a if a in SIDES else float(a)
    contacts = [[one[key] for one in model["contacts"]] for key in ("normal", "clearance", "sides")]
    structure = dict(zip(("mass", "stiffness", "normals", "clearances", "sides"),
                         plain([model["mass"], model["stiffness"], *contacts])))
    springs = [float(one.get("stiffness", 0)) for one in model["contacts"]]
    structure.update({"springs": springs} if any(springs) else {})
    points = db.execute("SELECT branch, point, energy, period FROM point")
    junctions = db.execute("SELECT 'junction', id, energy, NULL FROM junction")
    return structure, {(b, p): {"energy": E, **({"period": T} if T else {})}
                       for b, p, E, T in (*points, *junctions)}


def main(path, atlas=None):
    model, count, (structure, points) = None, [0, 0], read_atlas(atlas) if atlas else ({}, None)
    for where, text in enumerate(open(path), 1):
        try:
            line = read_line(text.rstrip("\n"))
            if line["type"] == "curve":
                check_curve.check(model, line)
            elif line["type"] != "model":
                check(model, line, points)
            if line["type"] != "model":
                count[0] += 1
            else:
                model = Model(line)
                need(not structure or structure == {key: line[key] for key in line if key not in ("type", "time", "check")},
                     "not that of the atlas")
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            count[1] += 1
            print(f"{path}:{where}: refused: {error or type(error).__name__}")
    print(f"{count[0]} accepted, {count[1]} refused")
    return 0 if count[0] and not count[1] else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]) if sys.argv[1:] else __doc__)
