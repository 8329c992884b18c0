#!/usr/bin/env python3
"""Checks certificates of `ricochet prove` by other means: check_certificate.py FILE [ATLAS]

The first line is the structure, in decimals; every other one is an orbit, a junction or a curve.
Each is a zero of one system of equations, closed by a number that is held, by what vanishes at a
junction, or by planes across a line. A contraction in balls proves that it is there once, and all
that the line says has to follow from it, digit by digit. See docs/proofs.md.
"""
import copy
import json
import math
import sqlite3
import sys
from fractions import Fraction
from functools import lru_cache

import numpy as np
from mpmath import mp

mp.dps = 90  # of what is approximate, and of an angle
P = 288
ONE = 1 << P  # numbers are integers in units of 2^-P
LONG = ONE * ONE << 5  # of |A| t, of which nothing is known: numbers grow to its exponential
TERMS, SHORT, TAIL = 34, ONE >> 4, ONE // 10**75  # of exp(A t) for |A| t < 1/16: the rest is 10^-79
STEPS, DEEPEST = 6, 60  # towards a zero; halvings of a flight
RADII = [ONE >> k for k in (10, 20, 30, 40)]  # within which a zero may be the only one
FLOOR, TRIES, PARTS, SHALLOW = 14, 4, 9, 14  # tubes: 2^-radius, boxes, halvings, those of flights
MORE = ONE >> 12  # of a line, beyond its ends
UNIT, HELD = 18, 1000  # decimals of states and times; the held one is a multiple of 1000 units
DIGITS = 12  # of energy, period and trace
NEAR = 1e-8  # what an atlas stores is that near
SIDES = {"both": (1, -1), "upper": (1,), "lower": (-1,)}
BESIDE = {"energy": [(0, 0)], "period": [(0, 0)], "double": [(0, 0)], "turn": [(0, 0), (1, 1)]}


def need(condition, what):
    if not condition:
        raise ValueError(what)


class Ball:
    """A number within `rad` of `mid`; integers are exact beside it."""

    __slots__ = ("mid", "rad")

    def __init__(self, mid, rad=0):
        self.mid, self.rad = mid, rad

    def __add__(a, b):
        b = b if type(b) is Ball else Ball(b * ONE)
        return Ball(a.mid + b.mid, a.rad + b.rad)

    def __mul__(a, b):
        if type(b) is not Ball:
            return Ball(a.mid * b, a.rad * abs(b)) if b else 0
        rad = abs(a.mid) * b.rad + a.rad * (abs(b.mid) + b.rad)
        return Ball(a.mid * b.mid >> P, (rad >> P) + 2)

    def __rtruediv__(a, b):
        need(abs(a.mid) > a.rad, "a number may be zero")
        one = ONE * ONE
        return b * Ball(one // a.mid, one // (abs(a.mid) - a.rad) - one // abs(a.mid) + 2)

    __radd__, __rmul__ = __add__, __mul__
    __neg__ = lambda a: Ball(-a.mid, a.rad)
    __sub__ = lambda a, b: a + -b
    __rsub__ = lambda a, b: -a + b
    __truediv__ = lambda a, b: b.__rtruediv__(a)
    __abs__ = lambda a: Ball(abs(a.mid) + a.rad)
    __gt__ = lambda a, b: a.mid - b * ONE > a.rad

    def rounded(self, decimals):
        """The integer to which all of it times 10^decimals is rounded."""
        ends = {math.floor(Fraction(end, ONE) * Fraction(10)**decimals + Fraction(1, 2))
                for end in (self.mid - self.rad, self.mid + self.rad)}
        need(len(ends) == 1, "a number lies between two integers")
        return ends.pop()


each = lambda f: np.vectorize(f, otypes=[object])
exact = each(lambda x: Fraction(str(x)))  # a decimal
balls = each(lambda x: Ball(x * ONE // 1, 1) if x % 1 else int(x))
middle = each(lambda x: Ball(x.mid) if type(x) is Ball else x)
eye = lambda n: np.eye(n, dtype=int).astype(object)
size = lambda A: max(sum(map(abs, row), Ball(0)).mid for row in A)  # the largest sum in a row
times = lambda t, W: W * t[0] + W[:, :1] * [0, *t[1:]]  # with derivatives behind both


def inverse(A):
    """Near that of the middle: nothing depends on it but whether a proof succeeds."""
    with mp.workdps(50):
        C = mp.inverse(mp.matrix(each(lambda x: mp.mpf((x + Ball(0)).mid) / ONE)(A).tolist()))
        return each(lambda x: Ball(int(mp.ldexp(x, P))))(np.array(C.tolist(), object))


class Phase:
    """While springs are closed: dw/dt = A w, w = (x, v, 1), with the energy w'Gw / 2."""

    def __init__(self, G, flow):
        self.G, self.A = balls(G), balls(flow @ G)
        self.norm, self.terms = size(self.A), [eye(len(G))]
        for k in range(1, TERMS):
            self.terms.append(self.terms[-1] @ self.A * (1 / Ball(k * ONE)))

    @lru_cache(10000)
    def series(self, mid, rad):
        """exp(A t)"""
        need(abs(mid) < ONE << 40 and rad * self.norm < LONG, "a flight is too long")
        if (abs(mid) + rad) * self.norm >= SHORT * ONE:
            half = self.series(mid // 2, rad // 2 + 1)
            return half @ half
        total, t = self.terms[-1], Ball(mid, rad)
        for term in reversed(self.terms[:-1]):
            total = total * t + term
        return total + Ball(0, TAIL)

    def fly(self, W, t):
        """W after t, tight where t is short, and with derivatives."""
        t0 = t[0] + Ball(0)
        W = self.series(t0.mid, 0) @ (self.series(0, t0.rad) @ W)
        return W + self.A @ W[:, :1] * [0, *t[1:]]


    def gap(self, row, w, part):
        """A gap up to 2 part, its rate and how it bends."""
        if part * self.norm >= LONG:
            return 0, 0, 0
        moved = self.A @ (self.series(part, part) @ w)
        rate, bend = -(row @ moved)[0], -(row @ (self.A @ moved))[0]
        return Ball(part, part) * rate - (row @ w)[0], rate, bend


class Model:
    """In units of the first clearance and 2^-time s: a gap is minus the row of its face on w."""

    def __init__(self, line):
        self.n, self.scale, sides = len(line["mass"]), Fraction(2)**line["time"], line["sides"]
        M, K, b, d = (exact(line[key]) for key in ("mass", "stiffness", "normals", "clearances"))
        self.springs = exact(line.get("springs", [0] * len(sides))) / self.scale**2
        n, self.soft = self.n, self.springs > 0
        need(all(A.shape == (n, n) and (A == A.T).all() for A in (M, K)), "not symmetric")
        need((len(d), n) == b.shape == (len(sides), n) and len(self.soft) == len(d), "contacts")
        need(min(d) > 0 <= min(self.springs), "a clearance or a spring is negative")
        W = np.hstack([M, eye(n)])
        for i in range(n):
            need(W[i, i] > 0, "the mass is not positive definite")
            W[i] /= W[i, i]
            W -= W[:, i:i + 1] * W[i] * (np.arange(n) != i)[:, None]
        self.G, self.flow = 0 * eye(2 * n + 1), 0 * eye(2 * n + 1)
        self.G[:n, :n], self.G[n:-1, n:-1] = K / self.scale**2, M
        self.flow[:n, n:-1], self.flow[n:-1, :n] = W[:, n:], -W[:, n:]
        self.faces = [(c, side) for c in range(len(sides)) for side in SIDES[sides[c]]]
        self.exact = {(c, s): np.array([*s * b[c], *0 * b[c], -d[c] / d[0]])
                      for c in range(len(sides)) for s in (1, -1)}
        self.rows = {face: balls(row) for face, row in self.exact.items()}
        self.kick = {face: self.flow @ row for face, row in self.exact.items()}  # along which, and
        self.speed = {face: row @ self.flow @ self.G for face, row in self.exact.items()}
        self.speeds = {face: balls(row) for face, row in self.speed.items()}

    @lru_cache(1000)
    def phase(self, closed):
        need(all(self.soft[c] for c, side in closed), "a stop is closed")
        more = (self.springs[f[0]] * np.outer(self.exact[f], self.exact[f]) for f in closed)
        return Phase(sum(more, self.G), self.flow)

    @lru_cache(1000)
    def impact(self, face):
        """The matrix that takes w to what is behind an event; where a spring switches it is 1."""
        if not face or self.soft[face[0]]:
            return eye(2 * self.n + 1)
        e, speed = self.kick[face], self.speed[face]
        return balls(eye(2 * self.n + 1) - 2 * np.outer(e, speed) / (speed @ e))

    def twin(self, to):
        """The matrix that takes coordinate i to |to[i]|, with its sign: it undoes itself, and takes
        the structure and the set of its faces to themselves."""
        n = self.n
        need(sorted(map(abs, to)) == [*range(1, n + 1)] and not any(self.soft), "no permutation")
        S = eye(2 * n + 1)
        S[:n, :n] = sum(np.outer(eye(n)[abs(j) - 1], eye(n)[i]) * (1 if j > 0 else -1)
                        for i, j in enumerate(to))
        S[n:-1, n:-1] = S[:n, :n]
        rows = lambda S: sorted(tuple(self.exact[face] @ S) for face in self.faces)
        need((S @ S == eye(2 * n + 1)).all() and (S.T @ self.G @ S == self.G).all()
             and rows(S) == rows(eye(2 * n + 1)), "the structure is not taken to itself")
        return S

    def mirror(self, kind, face, shift, odd):
        """Rows that vanish at a mirror point; of odd motions, which it turns into their opposite,
        one more, which forbids a shift in time. The motion may go back as its image."""
        n, one = self.n, eye(2 * self.n + 1)
        x, v = one[:n], one[n:-1]
        if type(kind) is np.ndarray:
            need(not odd, "a twin is broken")
            pairs = [i for i in range(n) if not any(kind[i, :i])]
            rows = np.vstack([(one - kind)[pairs], (one + kind)[n:][pairs]])
            return rows[[any(row) for row in rows]]
        if kind != "impact":
            return np.vstack([x if (kind == "centre") != bool(odd) else v, *[shift] * odd])
        e = self.kick[face]
        j = max(range(n, 2 * n), key=lambda i: abs(e[i]))
        even = [e[j] * one[i] - e[i] * one[j] for i in range(n, 2 * n) if i != j]
        return balls(np.vstack([*x, self.speed[face]] if odd else [self.exact[face], *even]))


class System:
    """Unknown are (x, v, tau) behind each event, or from a mirror point on; then, in the same
    order, those of motions beside the orbit, with shifts in time of the next event."""

    def __init__(self, model, line):
        self.m, self.n, self.ends = model, model.n, (line["start"], line["end"])
        self.said = [a for one in zip(line["x"], line["v"], line["tau"], strict=True)
                     for a in (*one[0], *one[1], one[2])]
        self.centre = balls(np.array(self.said, object)[:, None] * Fraction(1, 10**UNIT))
        self.kind, *self.ask = line["where"] if "where" in line else ("held", *line["held"])
        faces, self.width = len(model.faces), 2 * model.n + 1
        need(all(-1 <= f < 2 * faces for f in line["faces"]), "there is no such face")
        self.faces = [model.faces[f % faces] if f >= 0 else None for f in line["faces"]]
        begin, end, self.count = self.faces[0], self.faces[-1], len(self.faces) - 1
        self.size, self.touched = self.count * self.width, [{f} - {None} for f in self.faces]
        need(len(self.said) == self.size, "the states do not fit to the faces")
        flight = ("rest", "centre", "twin")
        need([e in flight for e in self.ends] == [not begin, not end], "a wrong end")
        need(("twin" in self.ends) == ("twin" in line), "a twin is missing")
        self.twin = model.twin(line["twin"]) if "twin" in line else eye(self.width)
        self.general, self.sigma = "general" in self.ends, 1 if begin == end else -1
        need(not self.general or (self.ends[0], begin[0]) == (self.ends[1], end[0]), "it is open")
        need(self.general or not any(f and model.soft[f[0]] for f in (begin, end)), "no mirror")
        turned = {"centre": -eye(self.n), "twin": self.twin[:self.n, :self.n]}
        around = [turned.get(e, eye(self.n)) for e in self.ends]
        around = around[0] @ around[1] * (self.sigma if self.general else 1)
        self.symmetric = bool((around == -eye(self.n)).all())
        self.copies = (1 if self.general else 2) * (1 if (around == eye(self.n)).all() else 2)
        self.images = (1, -1) if self.symmetric or "centre" in self.ends else (1,)
        self.watched = {(c, s * i) for c, s in model.faces for i in self.images}
        need({(c, s * i) for c, s in filter(None, self.faces) for i in self.images}
             <= set(model.faces), "an image of an impact has no face")
        self.find_phases([f >= faces for f in line["faces"]])
        self.find_question()

    def find_phases(self, opens):
        """Closed is first what opens at its first event; events change that, but mere touches. A
        spring is said to open where it is not closed behind an event, or is before the last one."""
        soft = [f is not None and self.m.soft[f[0]] for f in self.faces]
        switch = [s and [self.kind, *self.ask[:1]] != ["speed", k] for k, s in enumerate(soft)]
        first = {f: o for f, o, s in reversed([*zip(self.faces, opens, switch)]) if s}
        closed, self.closed = {f for f in first if first[f]}, []
        for k, face in enumerate(self.faces):
            before, closed = closed, closed ^ ({face} if switch[k] else set())
            opened = face in before if k == self.count else face not in closed
            need(opens[k] == (soft[k] and opened), "what is closed closes, or what is open opens")
            self.closed.append(frozenset(closed))
        self.phases = [self.m.phase(one) for one in self.closed[:-1]]

    def find_question(self):
        """What closes the system, the faces that are met at events, and rows at both ends."""
        n, m, one, (k, *more) = self.n, self.m, eye(self.width), (*self.ask, 0)
        need(k >= 0, "there is no such event")
        if self.kind == "held":
            self.held = k * self.width + more[0]
            need(0 <= more[0] < self.width and self.said[self.held] % HELD == 0, "another is held")
        elif self.kind == "gap":
            need(tuple(more[:2]) in self.watched, "there is no such face")
            self.touched[k].add(tuple(more[:2]))
        elif self.kind == "time":
            self.touched[k:k + 2] = [self.touched[k] | self.touched[k + 1]] * 2
        if self.general:
            turned = lambda faces: {(c, s * self.sigma) for c, s in faces}
            self.touched[0] = self.touched[0] | turned(self.touched[-1])
            self.touched[-1] = turned(self.touched[0])
        self.turn = m.impact(self.faces[-1]) * np.array([self.sigma] * 2 * n + [1], object)[:, None]
        beside = BESIDE.get(self.kind, [tuple(self.ask)] if self.kind == "break" else [])
        self.beside, (begins, ends) = len(beside), self.path(self.centre, 1)[0]
        g = self.gradient(begins[0], ends[-1])
        self.left_out, self.rows = max(range(2 * n), key=lambda i: abs(g[i] + Ball(0)).mid), []
        kinds = [self.twin if e == "twin" else e for e in self.ends]
        places = [(kinds[0], self.faces[0], middle(self.phases[0].A @ begins[0])[:, 0]),
                  (kinds[1], self.faces[-1], middle(self.phases[-1].A @ ends[-1])[:, 0])]
        for i, odd in enumerate([(0, 0), *beside]):
            first, last, gone = one[:0], one[:-1], [self.left_out]
            gone *= (i, self.kind) != (1, "double")
            if not self.general:
                first, last = (m.mirror(*place, flag) for place, flag in zip(places, odd))
                gone = [n if self.ends[1] == "impact" else self.left_out % n]
                gone *= self.kind == "break" and all(odd)
            self.rows.append((first, np.delete(last, gone, 0)))

    def gradient(self, begin, end):
        """Twice that of the energy; if a number of it is not zero, the row left out follows."""
        if self.general:
            return (self.phases[0].G @ (begin + self.turn @ end))[:, 0]
        return (self.phases[-1].G @ (end + end))[:, 0]

    def path(self, U, layers=None):
        """Of the orbit and each motion: states behind events, and before the next ones."""
        found, n, T = [], 2 * self.n, self.width
        for i in range(layers or 1 + self.beside):
            known, begins, ends = eye(U.shape[1])[:1] * int(i == 0), [], []
            for k, phase in enumerate(self.phases):
                at = (i * self.count + k) * T
                begins.append(np.vstack([U[at:at + n], known]))
                W = begins[k] + times(U[at + n], phase.A @ found[0][0][k]) if i else begins[k]
                ends.append(phase.fly(W, U[k * T + n]))
            found.append((begins, ends))
        return found

    def equations(self, U):
        """Numbers that have to vanish; where U has derivatives behind its numbers, with theirs."""
        layers, found = self.path(U), []
        lasts, unit = [ends[-1] for begins, ends in layers], eye(U.shape[1])[0]
        if self.kind == "turn":
            angle, (a, b) = mp.pi * self.ask[0] / self.ask[1], lasts[1:]
            c, s = (Ball(int(mp.ldexp(x, P)), TAIL) for x in (mp.cos(angle), mp.sin(angle)))
            lasts[1:] = a * c + b * s, b * c - a * s
        for i, (begins, ends) in enumerate(layers):
            for k, face in enumerate(self.faces[:-1]):
                if k:
                    found += [*(begins[k] - self.m.impact(face) @ ends[k - 1])[:-1]]
                if face and (k or self.general):
                    found.append(self.m.rows[face] @ begins[k])
            sign, (first, last) = -1 if (i, self.kind) == (1, "double") else 1, self.rows[i]
            found += [*first @ begins[0]]
            ring = begins[0] - sign * (self.turn @ lasts[i])
            found += [*last @ (ring if self.general else lasts[i])]
            found += self.closing(U, unit, layers) if i == 0 else []
        return np.vstack(found + ([self.norm @ U[self.size:] - unit] if self.beside else []))

    def closing(self, U, unit, layers):
        """What is held, or vanishes, of the orbit."""
        (begins, ends), (k, *more), T = layers[0], (*self.ask, 0), self.width
        if self.kind in ("speed", "gap"):
            face = self.faces[k] if self.kind == "speed" else tuple(more[:2])
            row = (self.m.speeds if self.kind == "speed" else self.m.rows)[face]
            return [row @ (begins + ends[-1:])[k]]
        if self.kind == "energy":
            W, Z = self.phases[0].G @ begins[0], layers[1][0][0]
            return [W[:, 0] @ Z + Z[:, 0] @ W - unit * (W[:, 0] @ Z[:, 0])]
        return {"held": lambda: [U[self.held] - self.centre[self.held] * unit],
                "plane": lambda: [self.along[:, 0] @ (U - self.spot * unit)],
                "time": lambda: [U[k * T + T - 1]],
                "period": lambda: [sum(U[self.size + T - 1::T])]}.get(self.kind, list)()

    def slopes(self, u):
        return self.equations(np.hstack([u, eye(len(u))]))[:, 1:]

    def prove(self):
        """u - C F(u) contracts the box of radius `outer` by 0.9, so that it has one zero, which is
        within 10 steps of each u in it."""
        N, count, u = self.size, self.beside * self.size, self.centre
        if self.beside:
            a = each(Ball)(ONE + np.arange(count)[:, None] % 3 * ONE)
            self.norm = a[:, 0]
            C = inverse(self.slopes(np.vstack([u, a]))[N - 1:N - 1 + count, N:])
            for _ in range(3):
                a = middle(C @ a)
                a = middle(a / Ball(size(a)))
            self.norm = middle(a / (a.T @ a)[0, 0])[:, 0]
            u = np.vstack([u, a])
        centre, C = u, inverse(self.slopes(u))
        for _ in range(STEPS):
            u = middle(u - C @ self.equations(u))
        ball = 11 * size(C @ self.equations(u))
        left = lambda r: size(C @ self.slopes(centre + Ball(0, r)) - eye(N + count))
        outer = next((r for r in RADII if left(r) * 10 < 9 * ONE), 0)
        need(size(u - centre) + ball < outer, "no zero is proved")
        u = u + Ball(0, ball)
        need([x.rounded(UNIT) for x in u[:N, 0]] == self.said, "other states or times")
        return u

    def stands(self, u, depth=DEEPEST):
        """Rows left out follow, flights last, events approach, and gaps are open: parts of a flight
        are halved until a gap is positive, or moves or bends away from where it is closed."""
        m, (begins, ends), where = self.m, self.path(u, 1)[0], (self.kind, *self.ask[:1])
        if self.general or self.kind == "break" and all(self.ask):
            1 / self.gradient(begins[0], ends[-1])[self.left_out]
        for k in range(self.count):
            for event, w, out in ((k, begins[k], -1), (k + 1, ends[k], 1)):
                for face in self.touched[event]:
                    speed = (m.speeds[face] @ w)[0] * (-out if face in self.closed[k] else out)
                    need(where == ("time", k) or self.still(event, face) or speed > 0,
                         "an impact has no speed")
        for k, phase in enumerate(self.phases):
            t = u[(k + 1) * self.width - 1]
            if where == ("time", k):
                continue
            need(t[0] > 0, f"flight {k + 1} does not last")
            for face in self.watched:
                row = m.rows[face] * (-1 if face in self.closed[k] else 1)
                todo = [(begins[k], 0, face in self.touched[k], face in self.touched[k + 1])]
                while todo:
                    w, level, opens, closes = todo.pop()
                    need(level < depth, f"a face is passed, or not approached, in flight {k + 1}")
                    part = (t[0].mid + t[0].rad >> level + 1) + 1
                    gap, rate, bend = phase.gap(row, w, part)
                    if not (gap > 0 or opens and rate > 0 or closes and -rate > 0
                            or (opens or closes) and bend > 0):
                        half = phase.fly(w, t / Ball(ONE << level + 1))
                        todo += (w, level + 1, opens, False), (half, level + 1, False, closes)

    def still(self, event, face):
        """Whether a face that is met has exactly no speed: at the slow event, at rest, or where the
        impact of a mirror point changes nothing that its contact sees."""
        events = (0, self.count) if self.general and event in (0, self.count) else (event,)
        own, kind = self.faces[event], self.ends[0 if event == 0 else 1]
        if face == own:
            return self.kind == "speed" and self.ask[0] in events
        mirror = not self.general and event in (0, self.count)
        return mirror and (kind == "rest" or self.m.speed[face] @ self.m.kick[own] == 0)

    def multipliers(self, u):
        """Sums over the pairs of multipliers x, 1/x but 1, 1 of r^k, r = x + 1/x, from traces of
        powers of the return to an event, or of half of it, where times are those of events."""
        m, n, (begins, ends), P = self.m, self.n, self.path(u, 1)[0], eye(self.width)
        way = [(k, self.faces[k + 1], self.phases[k].A @ ends[k]) for k in range(self.count)]
        if not self.general:
            back = np.array([[1]] * n + [[-1]] * n + [[1]], object)
            way += [(k, self.faces[k], back * (self.phases[k].A @ begins[k]))
                    for k in reversed(range(self.count))]
        for k, face, flow in way:
            P = self.phases[k].fly(P, u[(k + 1) * self.width - 1])
            if face:
                P = P - np.outer(flow[:, 0] / (m.rows[face] @ flow)[0], m.rows[face] @ P)
                P = m.impact(face) @ P
        P, power = (-P if self.symmetric else P)[:-1, :-1], eye(2 * n)
        traces = [2 * n - 2]
        for _ in range(2 * n - 2):
            power = power @ P
            traces.append(power.trace() - 1)
        return [sum(math.comb(k, j) * traces[abs(k - 2 * j)] for j in range(k + 1)) * Ball(ONE >> 1)
                for k in range(2 * n - 1)]

    def join(self, u, other, v):
        """On planes across the line between two centres lies one arc, with both orbits."""
        need(self.said != other.said, "an orbit stands there twice")
        tube = copy.copy(self)
        tube.kind, tube.ask, tube.start = "plane", [], middle(self.centre)
        tube.along = middle(other.centre - self.centre)
        tube.spot = tube.start + tube.along * Ball(ONE >> 1)
        bent = inverse(tube.slopes(tube.spot)) @ tube.equations(tube.spot)
        tube.shape = each(lambda x: Ball(max(abs(x).mid, size(bent) >> 2, 1)))(bent)
        tube.shape = middle(tube.shape / Ball(size(tube.shape)))
        radius = tube.follow(-MORE, ONE + MORE)
        for orbit, s in ((u, 0), (v, ONE)):
            off = orbit - tube.start - tube.along * Ball(s)
            share = abs((tube.along.T @ off)[0, 0] / (tube.along.T @ tube.along)[0, 0]).mid
            far = size(off / tube.shape) + (share * size(tube.along / tube.shape) >> P)
            need(share < MORE and far < radius, "tubes are not proved to meet")

    def follow(self, first, last, depth=0):
        """The least size of boxes around the line, of a shape that tells how it bends, with one
        zero on each plane, all motions."""
        half = (last - first) // 2
        try:
            self.spot = self.start + self.along * Ball(first + half)
            C, at = inverse(self.slopes(self.spot)), self.equations(self.spot)
            span, radius = Ball(0, half + 1), size(self.along) >> FLOOR
            narrow = lambda A: size(A / self.shape)
            for _ in range(TRIES):
                box = self.spot + self.along * span + self.shape * Ball(0, radius)
                J = self.slopes(box)
                shrinks = narrow((C @ J - eye(self.size)) * self.shape.T)
                least = narrow(C[:, :-1] @ (at + J @ self.along * span)[:-1])
                least += (shrinks * radius >> P) + 1
                need(shrinks < ONE, "the arc between two orbits is not proved to be one")
                if least < radius:
                    self.stands(box, SHALLOW)
                    return radius
                radius = least * 9 // 8
            raise ValueError("the arc between two orbits is not proved to be one")
        except (ArithmeticError, ValueError):
            if depth == PARTS:
                raise
        parts = ((first, first + half), (first + half, last))
        return min(self.follow(*part, depth + 1) for part in parts)


def stability(sums):
    """Stable: all r are real, apart and in (-2, 2), so that the matrix of the sums of
    (4 - r^2) r^(i+j) is positive definite; its signature counts those, less real ones outside
    (Hermite). Where r are large the sum of r^2k is more than n 4^k."""
    n, stable = len(sums) // 2, "yes"
    if any(sums[2 * k] > n * 4**k for k in range(1, n + 1)):
        return "no"
    H = np.array([[4 * sums[i + j] - sums[i + j + 2] for j in range(n)] for i in range(n)])
    while len(H):
        pivot = H[0, 0]
        if not (pivot > 0 or -pivot > 0):
            return "undecided"
        stable = stable if pivot > 0 else "no"
        H = H[1:, 1:] - np.outer(H[1:, 0] / pivot, H[0, 1:])
    return stable


def check(model, line, points=None):
    """All that the line says, from its question."""
    if line["type"] == "curve":
        need(line["arcs"] and min(map(len, line["arcs"])) > 1, "an arc has no two orbits")
        for arc in line["arcs"]:
            nodes = [System(model, {**line, **node}) for node in arc]
            need(all(node.kind == "held" for node in nodes), "an orbit of a curve is held")
            orbits = [node.prove() for node in nodes]
            for a, u, b, v in zip(nodes, orbits, nodes[1:], orbits[1:]):
                a.join(u, b, v)
        return
    s, point = System(model, line), line["type"] == "point"
    need(point == (s.kind == "held") and not (point and "twin" in line), "it is no junction")
    u = s.prove()
    s.stands(u)
    w, copies = s.path(u, 1)[0][0][0], s.copies
    numbers = {"energy": (w.T @ s.phases[0].G @ w)[0, 0] * balls(model.scale**2 / 2)[()],
               "period": sum(u[s.width - 1:s.size:s.width, 0]) * balls(copies / model.scale)[()]}
    sums = s.multipliers(u) if point else None
    if "trace" in line:
        numbers["trace"] = sums[2] - 2 * (s.n - 1) if s.symmetric else sums[1]
    stored = points[line["branch"] if point else "junction", line[line["type"]]] if points else {}
    for name, true in numbers.items():
        value = true.mid / ONE
        decimals = min(UNIT, DIGITS + UNIT - len(str(abs(true.mid) * 10**UNIT >> P)))
        need(line[name] == [true.rounded(decimals), -decimals], f"the {name} is another one")
        need(abs(value / stored.get(name, value) - 1) < NEAR, "the atlas has another one")
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
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            count[1] += 1
            print(f"{path}:{where}: refused: {error or type(error).__name__}")
    print(f"{count[0]} accepted, {count[1]} refused")
    return 0 if count[0] and not count[1] else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]) if sys.argv[1:] else __doc__)
