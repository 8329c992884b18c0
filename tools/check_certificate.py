#!/usr/bin/env python3
"""Checks certificates of `ricochet prove` by other means: check_certificate.py FILE [ATLAS]

The first line is the structure, in decimals; every other one is an orbit, a junction or a curve.
Each is a zero of one system of equations, closed by a number that is held, by what vanishes at a
junction, or by planes across a line. A contraction in balls proves that it is there once, and all
that the line says has to follow from it, digit by digit. See docs/proofs.md.
Here is what each line says; the equations, with the proof that their zero is a motion, and arcs of
motions are in certificate_chain.py, numbers, matrices and flights in certificate_balls.py.
"""
import copy
import json
import math
import sqlite3
import sys
from fractions import Fraction

import numpy as np

from certificate_balls import P, REFUSED, SIDES, Model, ball, eye, need, pivots, stack
from certificate_chain import HALF, UNIT, System

DIGITS = 12  # of energy, period and trace
NEAR = 1e-8  # what an atlas stores is that near


def multipliers(s, u):
    """Sums over the pairs of multipliers x, 1/x but 1, 1 of r^k, r = x + 1/x, from traces of
    powers of the return to an event, or of half of it, where times are those of events."""
    n, (begins, ends), M = s.n, s.path(u)[0], s.m.one
    way = [(k, k + 1, (s.phases[k].A @ ends[k])[:, :1]) for k in range(s.count)]
    if not s.general:
        back = np.array([[1]] * n + [[-1]] * n + [[1]], object)
        way += [(k, k, back * (s.phases[k].A @ begins[k])) for k in reversed(range(s.count))]
    for k, event, flow in way:
        M = s.phases[k].fly(M, u[(k + 1) * s.width - 1])
        if s.faces[event]:
            row = s.m.rows[s.faces[event]]
            M = s.jumps[event] @ (M - flow / (row @ flow)[0] * (row @ M))
    M, power, traces = (-M if s.symmetric else M)[:-1, :-1], ball(eye(2 * n)), [[2 * n - 2]]
    for _ in range(2 * n - 2):
        power = power @ M
        traces.append(sum(power[i, i] for i in range(2 * n))[None] - 1)
    binomials = 0 * eye(2 * n - 1)
    for k in range(2 * n - 1):
        for j in range(k + 1):
            binomials[k, abs(k - 2 * j)] += math.comb(k, j)
    return binomials @ stack(traces)[:, 0] * HALF


def stability(sums):
    """Stable: all r are real, apart and in (-2, 2), so that the matrix of the sums of
    (4 - r^2) r^(i+j) is positive definite; its signature counts those, less real ones outside
    (Hermite). Where r are large the sum of r^2k is more than n 4^k."""
    n, stable = len(sums) // 2, "yes"
    if any(sums[2 * k] > n * 4**k for k in range(1, n + 1)):
        return "no"
    H = stack([sums[i:i + n] * 4 - sums[i + 2:i + n + 2] for i in range(n)])
    for pivot in pivots(H):
        if not (pivot > 0 or -pivot > 0):
            return "undecided"
        stable = stable if pivot > 0 else "no"
    return stable


def check(model, line, points=None):
    """All that the line says, from its question."""
    if line["type"] == "curve":
        need(line["arcs"] and min(map(len, line["arcs"])) > 1, "an arc has no two orbits")
        for arc in line["arcs"]:
            nodes = [System(model, {**line, **node}) for node in arc]
            need({node.kind for node in nodes} == {"held"}, "an orbit of a curve is held")
            orbits = [(node, node.prove()) for node in nodes]
            for (a, u), (b, v) in zip(orbits, orbits[1:]):
                need(a.said != b.said, "an orbit stands there twice")
                copy.copy(a).join(u, v)
        return
    s, point = System(model, line), line["type"] == "point"
    need(point == (s.kind == "held") and not (point and "twin" in line), "it is no junction")
    u = s.prove()
    s.stands(u)
    w, copies = s.path(u)[0][0][0], s.copies
    numbers = {"energy": (w.T @ s.phases[0].G @ w)[0, 0] * (model.scale**2 / 2),
               "period": sum(u[s.width - 1::s.width, 0]) * (copies / model.scale)}
    sums = multipliers(s, u) if point else None
    if "trace" in line:
        numbers["trace"] = sums[2] - 2 * (s.n - 1) if s.symmetric else sums[1]
    stored = points[line["branch"] if point else "junction", line[line["type"]]] if points else {}
    for name, true in numbers.items():
        digits, power = line[name]
        decimals = min(UNIT, DIGITS + UNIT - len(str(abs(int(true.mid)) * 10**UNIT >> P)))
        need(type(digits) is int and power == -decimals, f"the {name} has other digits")
        unit, near = Fraction(10)**power, stored.get(name, float(true.near))
        need((true - digits * unit).most < unit / 2, f"the {name} is another one")
        need(abs(float(true.near) / near - 1) < NEAR, "the atlas has another one")
    if point:
        stable = stability(sums)
        need(line["stable"] in ("undecided", stable), f"the stability is: {stable}")
        need(line["symmetric"] is s.symmetric, "a symmetry is wrong")
        need(line["reversible"] is not s.general, "a symmetry is wrong")


def read_line(text):
    """The last field is the digest FNV-1a, 64 bits, of all before it: it finds accidents."""
    value = 0xCBF29CE484222325
    for byte in text.rpartition(', "check": "')[0].encode():
        value = (value ^ byte) * 0x100000001B3 & (1 << 64) - 1
    line = {**json.loads(text), "check": f"{value:016x}"}
    need(json.dumps(line) == text, "the line does not match its checksum, or is written otherwise")
    return line


def read_atlas(path):
    """What the first line has to say; energy and period of points and junctions."""
    import yaml
    db = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    (text,) = db.execute("SELECT value FROM meta WHERE key = 'model'").fetchone()
    model = yaml.load(text, yaml.BaseLoader)["model"]
    plain = lambda a: [*map(plain, a)] if type(a) is list else a if a in SIDES else float(a)
    structure = {key: plain(model[key]) for key in ("mass", "stiffness")}
    for key in ("normals", "clearances", "sides", "springs"):
        name = {"sides": "sides", "springs": "stiffness"}.get(key, key[:-1])
        structure[key] = plain([one.get(name, 0) for one in model["contacts"]])
    if not any(structure["springs"]):
        del structure["springs"]
    points = {(b, p): {"energy": E, "period": T} for b, p, E, T in
              db.execute("SELECT branch, point, energy, period FROM point")}
    junctions = db.execute("SELECT id, energy FROM junction")
    return structure, {**points, **{("junction", j): {"energy": E} for j, E in junctions}}


def main(path, atlas=None):
    model, count, (structure, points) = None, [0, 0], read_atlas(atlas) if atlas else (None, None)
    for where, text in enumerate(open(path), 1):
        try:
            line = read_line(text.rstrip("\n"))
            if line["type"] == "model":
                model, keys = Model(line), line.keys() - {"type", "time", "check"}
                need(structure in (None, {key: line[key] for key in keys}), "not that of the atlas")
                continue
            check(model, line, points)
            count[0] += 1
        except REFUSED as error:
            count[1] += 1
            print(f"{path}:{where}: refused: {error or type(error).__name__}")
    print(f"{count[0]} accepted, {count[1]} refused")
    return 0 if count[0] and not count[1] else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]) if sys.argv[1:] else __doc__)
