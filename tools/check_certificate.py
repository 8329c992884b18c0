#!/usr/bin/env python3
"""Checks certificates of `ricochet prove` by other means: check_certificate.py FILE [ATLAS]

The first line is the structure, in decimals. Of every other line the class of the orbit and the one
number that is held are the question; the answer is computed here in interval arithmetic, and has to
be, digit by digit, what the line says; with an atlas, what is stored there. See docs/proofs.md.
"""
import json
import sqlite3
import sys
from functools import lru_cache
from math import comb

from mpmath import iv, mp, mpf

mp.dps = iv.dps = 80
TERMS, SHORT = 34, mpf(1) / 16  # of the series of a flight, for times with |A| t < SHORT
TAIL = mpf(10) ** -75  # more than the rest of it: 2 SHORT^34 / 34! = 10^-79
STEPS, DEEPEST = 6, 60  # towards an orbit; bisections of a flight
NEAR = 1e-8  # what an atlas stores is that near to the orbit
RADII = [mpf(2) ** -k for k in (10, 20, 30, 40)]  # within which an orbit may be the only one
UNIT, HELD = -18, 1000  # states and times are integers, of 10^UNIT; the held one a multiple of HELD
SIDES = {"both": (1, -1), "upper": (1,), "lower": (-1,)}
middle = lambda A: A.apply(lambda x: iv.mpf(x.mid))
wide = lambda A, by: A.apply(lambda x: x + iv.mpf([-by, by]))


def need(condition, what):
    """Only True passes: mpmath answers None where an interval leaves a comparison open."""
    if condition is not True:
        raise ValueError(what)


def size(A):
    """The largest sum of |a| in a row. Of a NaN `max` would know nothing."""
    need(all(mp.isfinite(x.a) and mp.isfinite(x.b) for x in A), "a number is not finite")
    return max(mpf(sum(map(abs, row)).b) for row in A.tolist())


def block(*rows):
    return iv.matrix([sum(parts, []) for row in rows for parts in zip(*(A.tolist() for A in row))])


def rounded(x, power):
    """x / 10^power as an integer, if all of the interval is rounded to the same."""
    ends = {int(mp.floor(mpf(end) / mpf(10) ** power + 0.5)) for end in (x.a, x.b)}
    need(len(ends) == 1, "a number lies between two integers")
    return ends.pop()


def read_line(text):
    """The last field is the digest FNV-1a, 64 bits, of all before it: it finds accidents."""
    value = 0xCBF29CE484222325
    for byte in text.rpartition(', "check": "')[0].encode():
        value = (value ^ byte) * 0x100000001B3 & (1 << 64) - 1
    line = {**json.loads(text), "check": f"{value:016x}"}
    need(json.dumps(line) == text, "the line does not match its checksum, or is written otherwise")
    return line


class Model:
    """In units of the first clearance and 2^-time s: w = (x, v) has dw/dt = A w, energy w'Gw / 2; a
    face is closed where side row.w is its gap, an impact adds a multiple of e = (0, M^-1 b)."""

    def __init__(self, line):
        for A in (line["mass"], line["stiffness"]):
            need(A == [list(column) for column in zip(*A)], "a matrix is not symmetric")
        M, K, b, d = (iv.matrix([[repr(x) for x in row] for row in rows]) for rows in
                      (line["mass"], line["stiffness"], line["normals"], [line["clearances"]]))
        need(b.rows == d.cols == len(line["sides"]), "the contacts do not fit")
        need(min(line["clearances"]) > 0, "a clearance is not positive")
        iv.cholesky(M)  # fails for what is not positive definite
        self.n, self.scale, zero = M.rows, iv.mpf(2) ** line["time"], 0 * M
        K, self.one = K / self.scale ** 2, iv.eye(2 * self.n)
        self.A = block((zero, iv.eye(self.n)), (-M ** -1 * K, zero))
        self.G, self.J = block((K, zero), (zero, M)), block((zero, M), (M, zero))
        self.rows = [block((b[c, :], 0 * b[c, :])) for c in range(b.rows)]
        self.back, self.gaps = self.J ** -1, d / d[0]
        self.faces = [(c, side) for c, sides in enumerate(line["sides"]) for side in SIDES[sides]]
        self.norm, self.terms = size(self.A), [self.one]
        for k in range(1, TERMS):
            self.terms.append(self.terms[-1] * self.A / k)

    @lru_cache(10000)
    def series(self, t):
        """exp(A t), which takes w to what it is after t."""
        need(abs(t).b < 2 ** 60, "a flight is too long")
        if (abs(t).b * self.norm < SHORT) is not True:
            return self.series(t / 2) ** 2
        return wide(sum((term * t ** k for k, term in enumerate(self.terms)), 0 * self.A), TAIL)

    @lru_cache(10000)
    def flight(self, t):
        """The same, tight for a short interval."""
        mid = iv.mpf(t.mid)
        return self.series(mid) * self.series(t - mid)

    def impact(self, face, w=None):
        """The matrix that takes w to what is behind it; with that state, its derivative."""
        row = self.rows[face[0]]
        e, rate = self.back * row.T, row * self.A
        push = 2 / (rate * e)[0]
        if w is None:
            return self.one - e * rate * push
        kick = push * (rate * self.A * w)[0] / (rate * w)[0]
        return self.one - (e * rate + self.A * e * row) * push - e * row * kick

    def mirror(self, kind, face):
        """n rows, and what the first of them is on w at a mirror point; the others are 0."""
        n, one = self.n, self.one
        if kind != "impact":
            return {"rest": one[n:, :], "centre": one[:n, :]}[kind], 0
        row, e = self.rows[face[0]], self.back * self.rows[face[0]].T
        j = max(range(n, 2 * n), key=lambda i: mpf(abs(e[i]).mid))
        along = ((e[j] * one[i, :] - e[i] * one[j, :],) for i in range(n, 2 * n) if i != j)
        return block((row,), *along), face[1] * self.gaps[face[0]]


class Chain:
    """States and times (x, v, tau) behind impacts or from a mirror point on, and lambda."""

    def __init__(self, model, line):
        self.m, self.width, self.ends = model, 2 * model.n + 1, (line["start"], line["end"])
        blocks = zip(line["x"], line["v"], line["tau"], strict=True)
        self.said = [a for x, v, tau in blocks for a in (*x, *v, tau)]
        self.faces = [[*model.faces, None][face] for face in line["faces"]]
        begin, end, self.count = self.faces[0], self.faces[-1], len(self.faces) - 1
        need([e in ("rest", "centre") for e in self.ends] == [not begin, not end], "a wrong end")
        self.general, self.sigma = "general" in self.ends, 1 if begin == end else -1
        need(not self.general or (self.ends[0], begin[0]) == (self.ends[1], end[0]), "it is open")
        self.symmetric = self.sigma < 0 if self.general else self.ends.count("centre") == 1
        self.images = (1, -1) if self.symmetric or "centre" in self.ends else (1,)
        images = {(c, s * image) for c, s in filter(None, self.faces) for image in self.images}
        need(images <= set(model.faces), "an image of an impact has no face")
        (first, number), self.centre = line["held"], iv.matrix(self.said + [0] * self.general)
        self.centre, self.held = self.centre * iv.mpf(10) ** UNIT, first * self.width + number
        need(min(line["held"]) >= 0 and number < self.width, "no number is held")
        need(self.said[self.held] % HELD == 0, "another number is held")

    def flights(self, u):
        for k in range(self.count):
            first, last = k * self.width, (k + 1) * self.width - 1
            yield k, u[first:last, :], u[last, :], self.faces[k], self.faces[k + 1]

    def equations(self, U):
        """Numbers that have to vanish; where U has derivatives behind its numbers, with theirs."""
        m, n, found = self.m, self.m.n, []

        def put(rows, d, W):
            W = rows * W
            W[0, 0] -= d
            found.extend(W.tolist())

        put(iv.eye(1), self.centre[self.held], U[self.held, :])
        if not self.general:
            put(*m.mirror(self.ends[0], self.faces[0]), U[:2 * n, :])
        for k, W, t, begin, end in self.flights(U):
            if begin and (k or self.general):
                put(m.rows[begin[0]], begin[1] * m.gaps[begin[0]], W)
            W, t[0] = m.flight(t[0]) * W, 0
            W += m.A * W[:, 0] * t
            if k == self.count - 1 and not self.general:
                put(*m.mirror(self.ends[1], end), W)
                break
            to = (k + 1) % self.count * self.width
            if k == self.count - 1:
                grow, factor = U[U.rows - 1, :], 1 + U[U.rows - 1, 0]
                grow[0] = 0
                W = self.sigma * (W * factor + W[:, 0] * grow)
            found += (U[to:to + 2 * n, :] - m.impact(end) * W).tolist()
        return iv.matrix(found)

    def prove(self):
        """u - C F(u) contracts the box of radius `outer` by 0.9 and moves u by `step`: the box has
        one zero, within 10 steps of u. Returns that ball."""
        u, one = middle(self.centre), iv.eye(self.centre.rows)
        D = self.equations(block((u, one)))[:, 1:].apply(lambda x: mpf(x.mid))
        C = iv.matrix(mp.inverse(mp.matrix(D.tolist())).tolist())
        for _ in range(STEPS):
            u = middle(u - C * self.equations(u))
        ball = 11 * size(C * self.equations(u))
        box = lambda r: self.equations(block((wide(self.centre, r), one)))[:, 1:]
        outer = next((r for r in RADII if size(C * box(r) - one) < 0.9), None)
        need(outer is not None and size(u - self.centre) + ball < outer, "no zero is proved")
        return wide(u, ball)

    def passage(self, u):
        """Flights last, impacts approach, gaps are open in between: parts of a flight are halved
        until a gap is positive on them, or grows from or falls to an end at which it is closed."""
        m = self.m
        for k, w, t, begin, end in self.flights(u):
            need(t[0] > 0, f"flight {k + 1} does not last")
            images = {(c, side * image) for c, side in m.faces for image in self.images}
            todo = [(face, w, 0, face == begin, face == end) for face in images]
            while todo:
                face, w, depth, opens, closes = todo.pop()
                need(depth < DEEPEST, f"a face is passed, or not approached, in flight {k + 1}")
                part, row = t[0] / 2 ** depth, face[1] * m.rows[face[0]]
                times = iv.mpf([0, part.b])
                rate = -(row * m.A * (m.series(times) * w))[0]
                gap = m.gaps[face[0]] - (row * w)[0] + rate * times
                if not any(a is True for a in (gap > 0, opens and rate > 0, closes and rate < 0)):
                    todo.append((face, w, depth + 1, opens, False))
                    todo.append((face, m.flight(part / 2) * w, depth + 1, False, closes))

    def multipliers(self, u):
        """Sums over the pairs of multipliers x, 1/x but 1, 1 of r^k, r = x + 1/x, k < 2 n - 1, from
        traces of powers of the derivative of the return, or of half of it."""
        m, n, P = self.m, self.m.n, iv.eye(2 * self.m.n)
        for k, w, t, begin, end in self.flights(u):
            P = m.flight(t[0]) * (m.impact(begin, w) * P if k else P)
        if not self.general:
            back, z = m.back * P.T * m.J, m.flight(t[0]) * w
            P = back * (m.impact(end, m.impact(end) * z) * P if end else P)
        P = m.impact(self.faces[0], u[:2 * n, 0]) * P if self.faces[0] else P
        power, P, traces = iv.eye(2 * n), -P if self.symmetric else P, []
        for k in range(2 * n - 1):
            traces.append(sum(power[i, i] for i in range(2 * n)))
            power *= P
        return [sum(comb(k, j) * traces[abs(k - 2 * j)] for j in range(k + 1)) / 2 - 2 ** k
                for k in range(2 * n - 1)]


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
    u = chain.prove()
    need([rounded(a, UNIT) for a in u[:count]] == chain.said, "other states or times")
    chain.passage(u)
    w, sums = u[:2 * n, 0], chain.multipliers(u)
    copies = (1 if chain.general else 2) * (2 if chain.symmetric else 1)
    numbers = {"energy": (w.T * model.G * w)[0] / 2 * model.scale ** 2,
               "period": copies * sum(u[2 * n:count:2 * n + 1]) / model.scale}
    need(numbers["energy"] > 0, "the energy is not positive")
    stored = points[line["branch"], line["point"]] if points else {}
    if "trace" in line:
        numbers["trace"] = sums[2] - 2 * (n - 1) if chain.symmetric else sums[1]
    for name, true in numbers.items():
        power = max(UNIT, int(mp.floor(mp.log10(mpf(abs(true).mid)))) - 11)
        need(line[name] == [rounded(true, power), power], f"the {name} is another one")
        need(name not in stored or abs(true / stored[name] - 1) < NEAR, "the atlas has another one")
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
    points = db.execute("SELECT branch, point, energy, period FROM point")
    return structure, {(b, p): {"energy": E, "period": T} for b, p, E, T in points}


def main(path, atlas=None):
    model, count, (structure, points) = None, [0, 0], read_atlas(atlas) if atlas else ({}, None)
    for where, text in enumerate(open(path), 1):
        try:
            line = read_line(text.rstrip("\n"))
            if line["type"] == "point":
                check(model, line, points)
                count[0] += 1
            else:
                model = Model(line)
                need(structure == {key: line[key] for key in structure}, "not that of the atlas")
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            count[1] += 1
            print(f"{path}:{where}: refused: {error or type(error).__name__}")
    print(f"{count[0]} accepted, {count[1]} refused")
    return 0 if count[0] and not count[1] else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]) if sys.argv[1:] else __doc__)
