#!/usr/bin/env python3
"""Checks certificates of `ricochet prove -o FILE` by other means: check_certificate.py FILE...

Only Python and mpmath are used; nothing is shared with the program that wrote the file, and no inverse, mode or
enclosure is taken from it. The first line is the structure, in decimals. For every point the equations of the chain
(docs/proofs.md) are written anew in interval arithmetic: one contraction proves one zero within `exists` of the centre,
and no other within `unique`; then energy, period, symmetries, passage, trace and stability have to follow.
Prints one line for each that is refused and a count; exit status 1 if one is, or if there is none.
"""
import json
import sys
from fractions import Fraction
from functools import reduce

from mpmath import iv, mp, mpf

mp.dps = iv.dps = 160
FINE = mpf(10) ** -140  # what is left of modes
EPS = mpf(10) ** -120  # what it does to flights: at most 16 FINE times FACTORS (Duhamel's formula)
FACTORS = mpf(10) ** 18  # (1 + t)^3 (1 + L)^3 (1 + |w|), at most
DEEPEST = STEPS = 50  # bisections of a flight, steps of a refinement


class Refused(Exception):
    pass


def need(condition, what):
    """Only True passes: mpmath answers None where an interval leaves a comparison open."""
    if condition is not True:
        raise Refused(what)


ratio = lambda exact: iv.mpf(exact.numerator) / iv.mpf(exact.denominator)
number = lambda text: ratio(Fraction(text))
wide = lambda x, by: x + iv.mpf([-by, by])
mid = lambda x: mpf(iv.mpf(x).mid)
less = lambda A, d: [[a - (d[i] if i == j else 0) for j, a in enumerate(row)] for i, row in enumerate(A)]
norm = lambda A: max(sum(map(size, row)) for row in A)
unit = lambda n, j: [iv.mpf(int(i == j)) for i in range(n)]
dot = lambda x, y: sum((a * b for a, b in zip(x, y)), iv.mpf(0))
turn = lambda A: [list(column) for column in zip(*A)]
times = lambda A, B: [[dot(row, column) for column in zip(*B)] for row in A]


def size(x):
    """Of a finite interval: of a NaN `max` would know nothing."""
    need(mp.isfinite(x.a) and mp.isfinite(x.b), "a number is not finite")
    return max(abs(mpf(x.a)), abs(mpf(x.b)))


def read_line(text):
    """The last field is the digest FNV-1a, 64 bits, of all before it; a text is read in one way only."""
    body, mark, rest = text.rpartition(', "check": "')
    value = 0xCBF29CE484222325
    for byte in body.encode():
        value = (value ^ byte) * 0x100000001B3 & (1 << 64) - 1
    need(rest == f'{value:016x}"}}', "the line does not match its checksum")
    line = json.loads(text)
    need(json.dumps(line) == text, "the line is not written as certificates are")
    return line


class Model:
    """An approximate basis Y of modes differs from the orthonormal X = Y (Y'MY)^-1/2 by |Y| |Y'MY - 1| at most, and in
    X the stiffness is L but for FINE: frequencies may be equal, or zero."""

    def __init__(self, line):
        M, K, normals = ([[Fraction(x) for x in row] for row in line[key]] for key in ("mass", "stiffness", "normals"))
        n, gaps = len(M), [Fraction(d) for d in line["clearances"]]
        need(all(len(row) == n for row in M + K + normals) and len(K) == n, "the matrices do not fit")
        need(turn(M) == M and turn(K) == K, "a matrix is not symmetric")
        need(len(gaps) == len(normals) == len(line["sides"]) and min(gaps) > 0, "the contacts do not fit")
        need(all(side in ("both", "upper", "lower") for side in line["sides"]), "a side is unknown")
        plain = lambda rows: mp.matrix([[mpf(x.numerator) / x.denominator for x in row] for row in rows])
        balls = lambda rows: [[ratio(x) for x in row] for row in rows]
        root = mp.inverse(mp.cholesky(plain(M)))
        values, vectors = mp.eigsy(root * plain(K) * root.T)
        Y, M, K = [[iv.mpf(y) for y in row] for row in (root.T * vectors).tolist()], balls(M), balls(K)
        off = norm(less(times(times(turn(Y), M), Y), [1] * n))
        need(n * off < mpf(1) / 4, "no modes were found")
        self.n, self.X = n, [[wide(y, n * n * off * norm(Y)) for y in row] for row in Y]
        self.square = [iv.mpf(0 if abs(v) < FINE else v) for v in values]
        left = less(times(times(turn(self.X), K), self.X), self.square)
        need(norm(left) < FINE and min(map(mid, self.square)) >= 0, "a stiffness is negative, or modes do not solve")
        self.back = times(turn(self.X), M)
        self.gaps = [ratio(d / gaps[0]) for d in gaps]
        self.c = times(balls(normals), self.X)
        self.faces = [(contact, side) for contact, sides in enumerate(line["sides"]) for side in (1, -1)
                      if sides == "both" or (side > 0) == (sides == "upper")]


class Chain:
    """The equations on (q, p, tau) per block, and lambda. Times are those of the certificate, 2^-time s."""

    def __init__(self, model, line):
        self.m, self.line, self.n, self.sigma = model, line, model.n, line["sigma"]
        n, faces, ends, plane = model.n, line["faces"], (line["start"], line["end"]), list(map(number, line["plane"]))
        self.count, self.faces, self.width, self.at = len(line["tau"]), faces, 2 * n + 1, line["block"]
        self.square = [s / iv.mpf(4) ** line["time"] for s in model.square]
        self.omega = [iv.sqrt(s) for s in self.square]
        need(len(faces) == self.count + 1 == len(line["x"]) + 1 == len(line["v"]) + 1 > 1, "the chain has gaps")
        need(all(-1 <= f < len(model.faces) for f in faces) and all(f >= 0 for f in faces[1:-1]), "a face is wrong")
        in_flight = {"general": False, "impact": False, "rest": True, "centre": True}
        need([in_flight[end] for end in ends] == [faces[0] < 0, faces[-1] < 0], "an end is wrong")
        self.general, mixed = ends == ("general", "general"), (ends[0] == "centre") != (ends[1] == "centre")
        need(self.general or "general" not in ends, "an end is missing")
        need(self.sigma in ((1, -1) if self.general else (1,)), "sigma is wrong")
        self.symmetric = self.sigma < 0 if self.general else mixed
        self.imaged = self.symmetric or "centre" in ends
        walls = [model.faces[f] for f in faces if f >= 0]
        need(not self.imaged or all((c, -s) in model.faces for c, s in walls), "an image of an impact has no face")
        need(not self.general or walls[0] == (walls[-1][0], self.sigma * walls[-1][1]), "the chain does not close")
        self.centre = []
        for x, v, tau in zip(line["x"], line["v"], line["tau"]):
            need(len(x) == len(v) == n, "a state does not fit")
            self.centre += [dot(row, map(number, part)) for part in (x, v) for row in model.back] + [number(tau)]
        self.centre += [iv.mpf(0)] * self.general
        need(len(plane) == self.width and 0 <= self.at < self.count, "the plane does not fit")
        self.row = [dot(mode, plane[part:part + n]) for part in (0, n) for mode in zip(*model.X)] + [plane[2 * n]]

    def block(self, u, k):
        return u[k * self.width:(k + 1) * self.width]

    def fly(self, w, t):
        """The state after t, and the derivative by (q, p, tau) as rows."""
        n, q, p = self.n, [], []
        factors = (1 + size(t)) ** 3 * (1 + sum(map(size, self.square))) ** 3 * (1 + sum(map(size, w)))
        need(factors < FACTORS, "a flight is too long")
        rows = [[iv.mpf([-EPS, EPS]) for _ in range(2 * n)] for _ in range(2 * n)]
        for i, (o, square) in enumerate(zip(self.omega, self.square)):
            c, s = iv.cos(o * t), iv.sin(o * t)
            cos, sin = wide(c, EPS), wide(t if mid(square) == 0 else s / o, EPS)
            q.append(cos * w[i] + sin * w[n + i])
            p.append(cos * w[n + i] - wide(o * s, EPS) * w[i])
            rows[i][i], rows[i][n + i], rows[n + i][i], rows[n + i][n + i] = cos, sin, wide(-o * s, EPS), cos
        q, p = [wide(a, EPS) for a in q], [wide(a, EPS) for a in p]
        last = p + [wide(-square * a, EPS) for square, a in zip(self.square, q)]
        return q + p, [row + [a] for row, a in zip(rows, last)]

    def wall(self, face):
        contact, side = self.m.faces[face]
        return self.m.c[contact], side * self.m.gaps[contact]

    def reflect(self, face, p):
        c, _ = self.wall(face)
        along = 2 * dot(c, p) / dot(c, c)
        return [a - along * b for a, b in zip(p, c)]

    def mirror(self, kind, face):
        """The n conditions b.w = d of a mirror point as pairs (b, d)."""
        n = self.n
        if kind != "impact":
            return [(unit(2 * n, i + n * (kind == "rest")), 0) for i in range(n)]
        c, d = self.wall(face)
        j = max(range(n), key=lambda i: abs(mid(c[i])))
        need(size(1 / c[j]) < FACTORS, "a normal is lost")
        pair = lambda i: zip(unit(2 * n, n + i), unit(2 * n, n + j))
        return [(c + [iv.mpf(0)] * n, d)] + [([c[j] * a - c[i] * b for a, b in pair(i)], 0) for i in range(n) if i != j]

    def equations(self, u):
        """Numbers that have to vanish, and a list of (place, derivative) for each."""
        n, F, D, full = self.n, [], [], [unit(self.width, i) for i in range(2 * self.n)]

        def put(value, *parts):
            F.append(value)
            D.append([(k * self.width + j, a) for k, row in parts for j, a in enumerate(row)])

        def gap(k):
            c, d = self.wall(self.faces[k])
            put(dot(c, self.block(u, k)) - d, (k, c))

        def mirror(kind, face, state, rows, k):
            for b, d in self.mirror(kind, face):
                put(dot(b, state) - d, (k, times([b], rows)[0]))

        if self.general:
            gap(0)
        else:
            mirror(self.line["start"], self.faces[0], self.block(u, 0)[:2 * n], full, 0)
        for k in range(self.count):
            w, last = self.block(u, k), k == self.count - 1
            state, rows = self.fly(w[:2 * n], w[2 * n])
            if last and not self.general:
                mirror(self.line["end"], self.faces[-1], state, rows, k)
                break
            state = state[:n] + self.reflect(self.faces[k + 1], state[n:])
            rows = rows[:n] + turn([self.reflect(self.faces[k + 1], column) for column in zip(*rows[n:])])
            factor, target = (self.sigma * (1 + u[-1]), 0) if last else (iv.mpf(1), k + 1)
            for i in range(2 * n):
                row = [-factor * a for a in rows[i]] + [-self.sigma * state[i]] * last
                put(self.block(u, target)[i] - factor * state[i], (k, row), (target, full[i]))
            if not last:
                gap(k + 1)
        ahead = [a - b for a, b in zip(self.block(u, self.at), self.block(self.centre, self.at))]
        put(dot(self.row, ahead), (self.at, self.row))
        return F, D

    def prove(self):
        """u - C F(u) contracts the box of radius `outer` by `rate` and moves a point u of it by `step`: there is one
        zero in the box, within step / (1 - rate) of u. Returns that ball."""
        exists, unique = (mid(number(self.line[key])) for key in ("exists", "unique"))
        need(0 < exists < unique, "the radii are wrong")
        u, count = [mid(a) for a in self.centre], len(self.centre)
        outer = unique * max(1, norm(self.m.back)) + EPS
        F, rows = self.equations([iv.mpf(a) for a in u])
        need(len(F) == count, "there are not as many equations as unknowns")
        D = mp.matrix(count)
        for i, j, a in ((i, j, a) for i, row in enumerate(rows) for j, a in row):
            D[i, j] += mid(a)
        C = mp.inverse(D).tolist()
        for _ in range(STEPS):
            u = [a - mp.fdot(row, map(mid, F)) for a, row in zip(u, C)]
            F, _ = self.equations([iv.mpf(a) for a in u])
            if max(map(size, F)) < EPS * 10 ** 6:
                break
        C = [[iv.mpf(a) for a in row] for row in C]
        _, rows = self.equations([wide(iv.mpf(mid(a)), outer) for a in self.centre])
        product = less([[iv.mpf(0)] * count for _ in range(count)], [1] * count)
        for k, j, a in ((k, j, a) for k, row in enumerate(rows) for j, a in row):
            for i in range(count):
                product[i][j] += C[i][k] * a
        rate, step = norm(product), max(size(dot(row, F)) for row in C)
        need(rate < 0.999, f"no contraction: {mp.nstr(rate, 3)}")
        ball = step / (1 - rate) * 2
        moved = [iv.mpf(a) - b for a, b in zip(u, self.centre)]
        need(max(map(size, moved)) + ball < outer < 1, "no zero is proved")
        box = [wide(a, ball) for a in moved]
        parts = [self.block(box, k)[part:] for k in range(self.count) for part in (0, self.n)]
        away = [dot(row, part) for part in parts for row in self.m.X] + box[2 * self.n::self.width]
        need(max(map(size, away)) < exists, f"the zero is not within `exists`, but {mp.nstr(max(map(size, away)), 3)}")
        return [wide(iv.mpf(a), ball) for a in u]

    def is_open(self, gap, a, b, depth=0):
        t, m = iv.mpf([mpf(a.a), mpf(b.b)]), iv.mpf(mid((a + b) / 2))
        if (gap(t)[0] > 0) is True or (gap(m)[0] + gap(t)[1] * (t - m) > 0) is True:
            return True
        return depth < DEEPEST and self.is_open(gap, a, m, depth + 1) and self.is_open(gap, m, b, depth + 1)

    def opening(self, rate):
        """A time for which rate(0..time) > 0, so that what vanishes at 0 is open."""
        parts = (mpf(2) ** -i for i in range(1, 2 * DEEPEST))
        part = next((part for part in parts if (rate(iv.mpf([0, part])) > 0) is True), None)
        need(part is not None, "an impact does not approach")
        return part

    def passage(self, u):
        n = self.n
        for k in range(self.count):
            w, tau = self.block(u, k)[:2 * n], self.block(u, k)[2 * n]
            need(tau > 0, f"flight {k + 1} does not last")
            ends = [self.m.faces[f] if f >= 0 else None for f in self.faces[k:k + 2]]
            images = (1, -1) if self.imaged else (1,)
            for contact, side in {(contact, side * image) for contact, side in self.m.faces for image in images}:
                c, d = self.m.c[contact], self.m.gaps[contact]

                def gap(t):
                    state = self.fly(w, t)[0]
                    return d - side * dot(c, state[:n]), -side * dot(c, state[n:])

                a, b = iv.mpf(0), tau
                if ends[0] == (contact, side):
                    a = iv.mpf(self.opening(lambda t: gap(t)[1]))
                if ends[1] == (contact, side):
                    b = tau - self.opening(lambda t: -gap(tau - t)[1])
                need((a >= b) is True or self.is_open(gap, a, b), f"a face is passed in flight {k + 1}")

    def salt(self, face, w, P):
        """The derivative of an impact, with the state behind it, on columns (dq, dp)."""
        n, (c, _) = self.n, self.wall(face)
        kick = 2 * wide(dot(c, [s * q for s, q in zip(self.square, w)]), EPS) / (dot(c, c) * dot(c, w[n:2 * n]))
        kicked = lambda q, p: [a + kick * dot(c, q) * b for a, b in zip(self.reflect(face, p), c)]
        return turn([self.reflect(face, column[:n]) + kicked(column[:n], column[n:]) for column in zip(*P)])

    def inverse(self, P, s):
        """P^-1 of a symplectic P for s = -1, R P^-1 R with R (q, p) = (q, -p) for s = 1."""
        n = self.n
        part = lambda rows, columns, sign: [[sign * P[i][j] for i in rows] for j in columns]
        a, b = range(n), range(n, 2 * n)
        upper, lower = zip(part(b, b, 1), part(a, b, s)), zip(part(b, a, s), part(a, a, 1))
        return [x + y for x, y in (*upper, *lower)]

    def monodromy(self, u):
        """Of the return, or of half of it and -1; back from a mirror point by R P^-1 R."""
        n, P = self.n, [unit(2 * self.n, i) for i in range(2 * self.n)]
        for k in range(self.count):
            w = self.block(u, k)
            P = self.salt(self.faces[k], w, P) if k else P
            state, rows = self.fly(w[:2 * n], w[2 * n])
            P = times([row[:2 * n] for row in rows], P)
        if not self.general:
            back = self.inverse(P, 1)
            if self.faces[-1] >= 0:
                P = self.salt(self.faces[-1], state[:n] + self.reflect(self.faces[-1], state[n:]), P)
            P = times(back, P)
        P = self.salt(self.faces[0], self.block(u, 0), P) if self.faces[0] >= 0 else P
        return [[-a for a in row] for row in P] if self.symmetric else P

    def polynomial(self, u):
        """Coefficients, highest first, of the polynomial whose roots are x + 1/x of all pairs of multipliers but 1, 1.
        Their powers and 2^k, each twice, add up to the trace of (P + P^-1)^k; Newton's identities make the rest."""
        P, p, sums = self.monodromy(u), [iv.mpf(1)], [iv.mpf(0)]
        both = power = [[a + b for a, b in zip(x, y)] for x, y in zip(P, self.inverse(P, -1))]
        for k in range(1, self.n):
            sums.append(sum((row[i] for i, row in enumerate(power)), iv.mpf(0)) / 2 - 2 ** k)
            p.append(-dot(sums[1:], p[::-1]) / k)
            power = times(power, both)
        return p


def stability(p):
    """yes: as many changes of sign between -2 and 2 as there are roots. no: a disc that has a root (within deg |p / p'|
    of any point, Laguerre) has no point of [-2, 2]."""
    at = lambda x, q=p: reduce(lambda sum_, a: sum_ * x + a, q)
    degree, roots = len(p) - 1, mp.polyroots([mid(a) for a in p], maxsteps=200, extraprec=400)
    real = sorted(mp.re(r) for r in roots)
    places = [mpf(-2)] + [(a + b) / 2 for a, b in zip(real, real[1:])] + [mpf(2)]
    signs = [at(iv.mpf(x)) for x in places]
    if places == sorted(places) and all((a * b < 0) is True for a, b in zip(signs, signs[1:])):
        return "yes"
    slope = [a * (degree - i) for i, a in enumerate(p[:-1])]
    for z in (iv.mpc(mp.re(root), mp.im(root)) for root in roots):
        reach = degree * abs(at(z)) / abs(at(z, slope))
        if (abs(z.imag) > reach) is True or (abs(z.real) > 2 + reach) is True:
            return "no"
    return "undecided"


def check(model, line):
    chain = Chain(model, line)
    u = chain.prove()
    n, w = model.n, chain.block(u, 0)
    copies, scale = (1 if chain.general else 2) * (2 if chain.symmetric else 1), iv.mpf(2) ** line["time"]
    energy = wide(dot(w[n:2 * n], w[n:2 * n]) + dot(chain.square, [q * q for q in w[:n]]), EPS) / 2 * scale ** 2
    need(energy > 0, "the energy is not positive")
    chain.passage(u)
    said = {"energy": energy, "period": copies * sum(u[2 * n::chain.width], iv.mpf(0)) / scale}
    polynomial = chain.polynomial(u) if n > 1 else [iv.mpf(1)]
    if n == 2:
        said["trace"] = polynomial[1] ** 2 - 2 if chain.symmetric else -polynomial[1]
    for name, true in said.items():
        low, high = map(number, line[name])
        need((low <= true) is True and true <= high, f"the {name} is not in its interval")
    verdict = stability(polynomial) if n > 1 else "yes"
    need(("trace" in line) == (n == 2), "a trace is missing, or in excess")
    need(line["stable"] in ("undecided", verdict), f"the stability is: {verdict}")
    need(line["symmetric"] is chain.symmetric and line["reversible"] is not chain.general, "a symmetry is wrong")


def main(paths):
    accepted = refused = 0
    for path in paths:
        model = None
        for where, text in enumerate(open(path), 1):
            try:
                line = read_line(text.rstrip("\n"))
                if line["type"] == "model":
                    model = Model(line)
                    continue
                need(model is not None and line["type"] == "point", "there is no model before it")
                check(model, line)
                accepted += 1
            except (Refused, ArithmeticError, AssertionError, LookupError, TypeError, ValueError) as error:
                refused += 1
                print(f"{path}:{where}: refused: {error or type(error).__name__}")
    print(f"{accepted} accepted, {refused} refused")
    return 1 if refused or not accepted else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) if sys.argv[1:] else __doc__)
