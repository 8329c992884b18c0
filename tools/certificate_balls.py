"""What check_certificate.py computes with: numbers in balls, exact matrices, and the flow of a
linear structure, each of which can be read by itself. Nothing here knows of orbits."""
import math
from fractions import Fraction
from functools import lru_cache

import numpy as np
from mpmath import mp

mp.dps = 90  # of what is approximate, and of an angle
P = 288
ONE = 1 << P  # numbers are integers in units of 2^-P
LONG = ONE * ONE << 5  # of |A| t, of which nothing is known: numbers grow to its exponential
TERMS, SHORT, TAIL = 34, ONE >> 4, ONE // 10**75  # of exp(A t) for |A| t < 1/16: the rest is 10^-79
SIDES = {"both": (1, -1), "upper": (1,), "lower": (-1,)}


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


def reduced(A):
    """Rows that span those of an exact matrix: the first number of each is 1, and alone in its
    column."""
    A, rank = A * Fraction(1), 0
    for j in range(A.shape[1]):
        found = [i for i in range(rank, len(A)) if A[i, j]]
        if found:
            A[[rank, found[0]]] = A[[found[0], rank]]
            A[rank] /= A[rank, j]
            others = np.arange(len(A)) != rank
            A[others] -= np.outer(A[others, j], A[rank])
            rank += 1
    return A[:rank]


def framed(blocks, last=0):
    """For (x, v, 1), with a last number on the diagonal."""
    A = np.pad(np.block(blocks), (0, 1))
    A[-1, -1] = last
    return A


def pivots(A):
    """Of a symmetric matrix, with the signs of its eigenvalues, one by one while none is zero."""
    while len(A):
        yield A[0, 0]
        A = A[1:, 1:] - np.outer(A[1:, 0] / A[0, 0], A[0, 1:])


class Phase:
    """While springs are closed: dw/dt = A w, w = (x, v, 1), with the energy w'Gw / 2."""

    def __init__(self, G, flow):
        self.G, self.A = balls(G), balls(flow @ G)
        fast = Fraction(2)**((size(self.A) >> P).bit_length() // 2)  # about its highest frequency
        units = np.array([Fraction(1), 1 / fast, Fraction(1)]).repeat([len(G) // 2, len(G) // 2, 1])
        self.back = balls(np.outer(1 / units, units))  # from speeds in units of that
        A = balls(flow @ G * np.outer(units, 1 / units))
        self.norm, self.terms = size(A), [eye(len(G))]
        for k in range(1, TERMS):
            self.terms.append(self.terms[-1] @ A * (1 / Ball(k * ONE)))

    @lru_cache(10000)
    def series(self, mid, rad):
        """exp(A t)"""
        return self.back * self.scaled(mid, rad)

    @lru_cache(10000)
    def scaled(self, mid, rad):
        need(abs(mid) < ONE << 40 and rad * self.norm < LONG, "a flight is too long")
        if (abs(mid) + rad) * self.norm >= SHORT * ONE:
            half = self.scaled(mid // 2, rad // 2 + 1)
            return half @ half
        total, t = self.terms[-1], Ball(mid, rad)
        for term in reversed(self.terms[:-1]):
            total = total * t + term
        return total + Ball(0, TAIL)

    def fly(self, W, t):
        """W after t, with derivatives. What moves little is flown as that, so that the rest of a
        stiff spring, where large numbers cancel, stays tight."""
        t0 = t[0] + Ball(0)
        W = self.series(t0.mid, 0) @ W
        W = W + self.series(0, t0.rad) @ (self.A @ W) * Ball(0, t0.rad)
        return W + self.A @ W[:, :1] * [0, *t[1:]]

    def flies(self, row, W, factors, t, depth, opens, closes, pressed=False):
        """Halves a flight of W @ factors until a gap is positive, or moves or bends away from where
        it is 0; or `pressed` together: to 0, or to rest, at both ends, and bent towards 0 all the
        way."""
        need(depth, "a face is passed, or not approached")
        part = (t[0].mid + t[0].rad >> 1) + 1
        if part * self.norm < LONG:
            moves = self.A @ W
            rate, bend = (-(row @ (self.series(part, part) @ dW)) @ factors
                          for dW in (moves, self.A @ moves))
            gap = Ball(part, part) * rate - row @ W @ factors
            if (gap > 0 or opens and rate > 0 or closes and -rate > 0
                    or (opens or closes) and bend > 0 or pressed and -bend > 0):
                return
        half = t / Ball(2 * ONE)
        self.flies(row, W, factors, half, depth - 1, opens, False)
        self.flies(row, self.fly(W, half), factors, half, depth - 1, False, closes)


class Model:
    """In units of the first clearance and 2^-time s: a gap is minus the row of its face on w."""

    def __init__(self, line):
        self.n, self.scale, sides = len(line["mass"]), Fraction(2)**line["time"], line["sides"]
        M, K, b, d = (exact(line[key]) for key in ("mass", "stiffness", "normals", "clearances"))
        self.springs = exact(line.get("springs", [0] * len(sides))) / self.scale**2
        n, self.soft, self.one = self.n, self.springs > 0, eye(2 * self.n + 1)
        need(all(A.shape == (n, n) and (A == A.T).all() for A in (M, K)), "not symmetric")
        need((len(d), n) == b.shape == (len(sides), n) and len(self.soft) == len(d), "contacts")
        need(min(d) > 0 <= min(self.springs), "a clearance or a spring is negative")
        need(all(pivot > 0 for pivot in pivots(M)), "the mass is not positive definite")
        W, none = reduced(np.hstack([M, eye(n)]))[:, n:], 0 * M
        self.G = framed([[K / self.scale**2, none], [none, M]])
        self.flow = framed([[none, W], [-W, none]])
        self.faces = [(c, side) for c in range(len(sides)) for side in SIDES[sides[c]]]
        self.exact = {(c, s): np.array([*s * b[c], *none[0], -d[c] / d[0]])
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
            return self.one
        e, speed = self.kick[face], self.speed[face]
        return self.one - 2 * np.outer(e, speed) / (speed @ e)

    def turned(self, x, v, face=None):
        """The matrix that takes places by x, and speeds by v, after an event."""
        return framed([[x, 0 * x], [0 * x, v]], 1) @ self.impact(face)

    def twin(self, to):
        """The matrix that takes coordinate i to |to[i]|, with its sign: it undoes itself, and takes
        the structure and the set of its faces to themselves."""
        need(not any(self.soft), "a structure with springs has no twins")
        X = (eye(self.n)[np.abs(to) - 1] * np.sign(to)[:, None]).T
        S, rows = self.turned(X, X), np.array([self.exact[face] for face in self.faces])
        same = (S @ S == self.one).all() and (S.T @ self.G @ S == self.G).all()
        same = same and sorted(map(tuple, rows)) == sorted(map(tuple, rows @ S))
        need(same, "the structure is not taken to itself")
        return X
