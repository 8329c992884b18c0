"""The orbit problem of certificates of `ricochet prove`, in interval arithmetic: the structure, and chains
of states and flight times. What check_certificate.py and check_curve.py stand on; see docs/proofs.md.
"""
from functools import lru_cache
from math import comb

from mpmath import iv, mp, mpf
from mpmath.libmp.libmpi import mpi_add, mpi_mul, mpi_zero

DIGITS = 80
mp.dps = iv.dps = DIGITS
TERMS, SHORT = 34, mpf(1) / 16  # of the series of a flight, for times with |A| t < SHORT
TAIL = mpf(10) ** -75  # more than the rest of it: 2 SHORT^34 / 34! = 10^-79
STEPS, DEEPEST = 6, 60  # towards an orbit; bisections of a flight
RADII = [mpf(2) ** -k for k in (10, 20, 30, 40)]  # within which an orbit may be the only one
UNIT, HELD = -18, 1000  # states and times are integers, of 10^UNIT; the held one a multiple of HELD
SIDES = {"both": (1, -1), "upper": (1,), "lower": (-1,)}
middle = lambda A: A.apply(lambda x: iv.mpf(x.mid))
wide = lambda A, by: A.apply(lambda x: x + iv.mpf([-by, by]))


def product(A, B, theirs=iv.matrix.__mul__):
    """What mpmath has for A B, to the last bit, without products with zero, which most of them are."""
    if not isinstance(B, iv.matrix) or A.cols != B.rows:
        return theirs(A, B)
    prec, C, columns = iv.prec, iv.matrix(A.rows, B.cols), [[b._mpi_ for b in column] for column in zip(*B.tolist())]
    for i, row in enumerate(A.tolist()):
        there = [(k, a._mpi_) for k, a in enumerate(row) if a._mpi_ != mpi_zero]
        for j, column in enumerate(columns):
            total = mpi_zero
            for k, a in there:
                if column[k] != mpi_zero:
                    total = mpi_add(total, mpi_mul(a, column[k], prec), prec)
            if total != mpi_zero:
                C[i, j] = iv.make_mpf(total)
    return C


iv.matrix.__mul__ = product


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


class Phase:
    """While a set of springs is closed, dw/dt = A (w - rest)."""

    def __init__(self, A, rest):
        self.A, self.rest, self.one = A, rest, iv.eye(A.rows)
        self.norm, self.terms = size(A), [self.one]
        for k in range(1, TERMS):
            self.terms.append(self.terms[-1] * A / k)

    @lru_cache(10000)
    def series(self, t):
        """exp(A t), which takes w - rest to what it is after t."""
        need(abs(t).b < 2 ** 60, "a flight is too long")
        if (abs(t).b * self.norm < SHORT) is not True:
            half = self.series(t / 2)
            return half * half  # half ** 2 makes another product, which nobody asks for
        return wide(sum((term * t ** k for k, term in enumerate(self.terms)), 0 * self.A), TAIL)

    @lru_cache(10000)
    def flight(self, t):
        """The same, tight for a short interval."""
        mid = iv.mpf(t.mid)
        return self.series(mid) * self.series(t - mid)

    def after(self, w, t):
        return self.flight(t) * (w - self.rest) + self.rest


class Model:
    """In units of the first clearance and 2^-time s: w = (x, v), energy w'Gw / 2 and that of springs; a
    face is met where side row.w is its gap, an impact adds a multiple of e = (0, M^-1 b)."""

    def __init__(self, line):
        for A in (line["mass"], line["stiffness"]):
            need(A == [list(column) for column in zip(*A)], "a matrix is not symmetric")
        M, K, b, d, k = (iv.matrix([[repr(x) for x in row] for row in rows]) for rows in
                         (line["mass"], line["stiffness"], line["normals"], [line["clearances"]],
                          [line.get("springs", [0.0] * len(line["sides"]))]))
        need(b.rows == d.cols == k.cols == len(line["sides"]), "the contacts do not fit")
        need(min(line["clearances"]) > 0, "a clearance is not positive")
        need(min(line.get("springs", [0])) >= 0, "a spring is negative")
        iv.cholesky(M)  # fails for what is not positive definite
        self.n, self.scale, self.zero = M.rows, iv.mpf(2) ** line["time"], 0 * M
        self.K, self.springs = K / self.scale ** 2, k / self.scale ** 2
        self.one, self.inverse = iv.eye(2 * self.n), M ** -1
        self.G, self.J = block((self.K, self.zero), (self.zero, M)), block((self.zero, M), (M, self.zero))
        self.rows = [block((b[c, :], 0 * b[c, :])) for c in range(b.rows)]
        self.back, self.gaps = self.J ** -1, d / d[0]
        self.faces = [(c, side) for c, sides in enumerate(line["sides"]) for side in SIDES[sides]]
        self.soft = [x > 0 for x in line.get("springs", [0] * b.rows)]  # contacts that are springs
        self.A = self.phase(frozenset()).A

    @lru_cache(1000)
    def phase(self, closed):
        K, force, n = 1 * self.K, 0 * self.K[:, 0], self.n
        for c, side in sorted(closed):
            need(self.soft[c] and (c, -side) not in closed, "a stop cannot be closed, nor both faces of a spring")
            b = self.rows[c][:, :n].T
            K += self.springs[c] * b * b.T
            force += self.springs[c] * side * self.gaps[c] * b
        rest = K ** -1 * force if closed else force
        A = block((self.zero, iv.eye(n)), (-self.inverse * K, self.zero))
        return Phase(A, iv.matrix([*rest, *[0] * n]))

    def impact(self, face, w=None, phase=None):
        """The matrix that takes w to what is behind it; with that state, its derivative. Springs: 1."""
        if self.soft[face[0]]:
            return self.one
        row = self.rows[face[0]]
        e, rate = self.back * row.T, row * self.A
        push = 2 / (rate * e)[0]
        if w is None:
            return self.one - e * rate * push
        kick = push * (rate * phase.A * (w - phase.rest))[0] / (rate * w)[0]
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

    deepest = DEEPEST

    def __init__(self, model, line):
        self.m, self.width, self.ends = model, 2 * model.n + 1, (line["start"], line["end"])
        blocks = zip(line["x"], line["v"], line["tau"], strict=True)
        self.said = [a for x, v, tau in blocks for a in (*x, *v, tau)]
        faces = len(model.faces)
        need(all(-1 <= face < 2 * faces for face in line["faces"]), "there is no such face")
        self.faces = [model.faces[face % faces] if face >= 0 else None for face in line["faces"]]
        self.opens = [face >= faces for face in line["faces"]]
        begin, end, self.count = self.faces[0], self.faces[-1], len(self.faces) - 1
        need([e in ("rest", "centre") for e in self.ends] == [not begin, not end], "a wrong end")
        self.general, self.sigma = "general" in self.ends, 1 if begin == end else -1
        need(not self.general or (self.ends[0], begin[0]) == (self.ends[1], end[0]), "it is open")
        self.symmetric = self.sigma < 0 if self.general else self.ends.count("centre") == 1
        self.images = (1, -1) if self.symmetric or "centre" in self.ends else (1,)
        images = {(c, s * image) for c, s in filter(None, self.faces) for image in self.images}
        need(images <= set(model.faces), "an image of an impact has no face")
        self.find_phases()
        self.centre = iv.matrix(self.said + [0] * self.general) * iv.mpf(10) ** UNIT
        self.slow = line.get("slow")
        if self.slow is None:
            (first, number), self.held = line["held"], line["held"][0] * self.width + line["held"][1]
            need(min(line["held"]) >= 0 and number < self.width, "no number is held")
            need(self.said[self.held] % HELD == 0, "another number is held")
        else:
            need(0 <= self.slow <= self.count and bool(self.faces[self.slow]), "no impact is slow")

    def find_phases(self):
        """The springs that are closed in each flight: at first those whose first event is an opening."""
        events = [(face, opens) for face, opens in zip(self.faces, self.opens) if face]
        need(all(self.m.soft[face[0]] for face, opens in events if opens), "a stop does not open")
        closed, self.closed = {face for face, opens in dict(reversed(events)).items() if opens}, []
        for face, opens in zip(self.faces, self.opens):
            before = frozenset((c, side * self.sigma) for c, side in closed)
            if face and self.m.soft[face[0]]:
                need((face in closed) is opens, "a spring closes, or opens, twice")
                closed ^= {face}
            self.closed.append(frozenset(closed))
        again = frozenset((c, side * self.sigma) for c, side in closed)
        need(not self.general or again == self.closed[0], "other springs are closed at the end")
        need(self.ends[0] != "centre" or not self.closed[0], "a spring is closed at a centre")
        need(self.ends[1] != "centre" or not closed, "a spring is closed at a centre")
        need("impact" not in self.ends or not any(self.m.soft[face[0]] for end, face in
             zip(self.ends, (self.faces[0], self.faces[-1])) if end == "impact"), "no stop at a mirror point")
        self.before = before if self.general else self.closed[0]
        self.phases = [self.m.phase(one) for one in self.closed[:self.count]]

    def energy(self, w, factor=1):
        """That of w, positive; of a general chain also that factor = 1 + lambda is 1: with E = a f^2 - b f + c of
        f w before the first event, of which w is f times, a (1 + f) > b f."""
        E = a = (w.T * self.m.G * w)[0] / 2
        b = iv.mpf(0)
        for c, side in self.closed[0]:
            E += self.m.springs[c] * ((self.m.rows[c] * w)[0] - side * self.m.gaps[c]) ** 2 / 2
        for c, side in self.before:
            s = (self.m.rows[c] * w)[0]
            a, b = a + self.m.springs[c] * s ** 2 / 2, b + self.m.springs[c] * s * side * self.m.gaps[c]
        need(E > 0, "the energy is not positive")
        need(factor > 0 and a * (1 + factor) > b * factor, "it is not closed")
        return E

    def fly(self, W, t, phase):
        W = 1 * W
        W[:, 0] -= phase.rest
        W, t[0] = phase.flight(t[0]) * W, 0
        W += phase.A * W[:, 0] * t
        W[:, 0] += phase.rest
        return W

    def plane(self, put, U):
        """The equation that picks one orbit of a curve: a number that is held, or no speed."""
        if self.slow is None:
            return put(iv.eye(1), self.centre[self.held], U[self.held, :])
        first = min(self.slow, self.count - 1) * self.width
        W, t = U[first:first + 2 * self.m.n, :], U[first + self.width - 1, :]
        return put(self.m.rows[self.faces[self.slow][0]] * self.m.A, 0,
                   W if self.slow < self.count else self.fly(W, t, self.phases[-1]))

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

        self.plane(put, U)
        if not self.general:
            put(*m.mirror(self.ends[0], self.faces[0]), U[:2 * n, :])
        for k, W, t, begin, end in self.flights(U):
            if begin and (k or self.general):
                put(m.rows[begin[0]], begin[1] * m.gaps[begin[0]], W)
            W = self.fly(W, t, self.phases[k])
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

    def touches(self, k):
        """Whether impact k has no speed; that at the end of a general chain is the first one."""
        return self.slow is not None and self.slow in (k, k % self.count if self.general else k)

    def passage(self, u):
        """Flights last, impacts approach, gaps are open in between: parts of a flight are halved
        until a gap is positive on them, or grows from or falls to an end at which it is closed; where
        that may be an impact of no speed (2), it may bend away from it, too."""
        m, kind = self.m, lambda k: 2 if self.touches(k) else 1
        for k, w, t, begin, end in self.flights(u):
            need(t[0] > 0, f"flight {k + 1} does not last")
            images = {(c, side * image) for c, side in m.faces for image in self.images}
            phase, closed = self.phases[k], self.closed[k]
            todo = [(face, w - phase.rest, 0, (face == begin) * kind(k), (face == end) * kind(k + 1)) for face in images]
            while todo:
                face, w, depth, opens, closes = todo.pop()
                need(depth < self.deepest, f"a face is passed, or not approached, in flight {k + 1}")
                inside = -1 if face in closed else 1  # a closed spring is pressed in all the time
                part, row = t[0] / 2 ** depth, inside * face[1] * m.rows[face[0]]
                times = iv.mpf([0, part.b])
                moved = phase.A * (phase.series(times) * w)
                rate, bend = -(row * moved)[0], -(row * phase.A * moved)[0]
                gap = inside * m.gaps[face[0]] - (row * (w + phase.rest))[0] + rate * times
                if not any(a is True for a in (gap > 0, opens and rate > 0, closes and rate < 0,
                                                 2 in (opens, closes) and bend > 0)):
                    todo.append((face, w, depth + 1, opens, False))
                    todo.append((face, phase.flight(part / 2) * w, depth + 1, False, closes))

    def multipliers(self, u):
        """Sums over the pairs of multipliers x, 1/x but 1, 1 of r^k, r = x + 1/x, k < 2 n - 1, from
        traces of powers of the derivative of the return, or of half of it."""
        m, n, P = self.m, self.m.n, iv.eye(2 * self.m.n)
        for k, w, t, begin, end in self.flights(u):
            P = self.phases[k].flight(t[0]) * (m.impact(begin, w, self.phases[k]) * P if k else P)
        if not self.general:
            back, z = m.back * P.T * m.J, self.phases[-1].after(w, t[0])
            P = back * (m.impact(end, m.impact(end) * z, self.phases[-1]) * P if end else P)
        P = m.impact(self.faces[0], u[:2 * n, 0], self.phases[0]) * P if self.faces[0] else P
        power, P, traces = iv.eye(2 * n), -P if self.symmetric else P, []
        for k in range(2 * n - 1):
            traces.append(sum(power[i, i] for i in range(2 * n)))
            power *= P
        return [sum(comb(k, j) * traces[abs(k - 2 * j)] for j in range(k + 1)) / 2 - 2 ** k
                for k in range(2 * n - 1)]
