"""What check_certificate.py computes with: arrays of numbers in balls, exact matrices, and the flow
of a linear structure, each of which can be read by itself. Nothing here knows of orbits."""
from fractions import Fraction
from functools import cached_property, lru_cache

import numpy as np

P = 288
ONE, UNIT = 1 << P, 2.0**-P  # centres are integers in units of 2^-P, radii are doubles,
UP, LAST = 1 + 2.0**-40, 2.0**(1 - P)  # which this rounds up; what a shift rounds
TERMS, SHORT, TAIL = 5, 2.0**-5, 2.0**-276  # 2^5 of exp(A t), |A| t < 2^-5: 2^-160/32! is the rest
SIDES = {"both": (1, -1), "upper": (1,), "lower": (-1,)}

np.seterr(all="ignore")  # what overflows is no number, which passes no test
each = lambda f, x: np.frompyfunc(f, 1, 1)(np.asarray(x, object))
exact = lambda x: each(lambda a: Fraction(str(a)), x)  # decimals
eye = lambda n: np.eye(n, dtype=int).astype(object)


REFUSED = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError,
           np.linalg.LinAlgError)  # what is not as it should be


def need(condition, what):
    if not condition:
        raise ValueError(what)


class Ball:
    """Numbers within `rad` of `mid`. A test is passed by no radius that is not a number."""

    __array_ufunc__ = None
    __radd__ = lambda a, b: a + b
    __rmul__ = lambda a, b: a * b
    __mul__ = lambda a, b: a.product(np.multiply, b)
    __matmul__ = lambda a, b: a.product(np.matmul, b)
    __rmatmul__ = lambda a, b: ball(b) @ a
    __neg__ = lambda a: Ball(-a.mid, a.rad)
    __sub__ = lambda a, b: a + -b
    __rsub__ = lambda a, b: -a + b
    __len__ = lambda a: len(a.mid)
    __getitem__ = lambda a, at: Ball(a.mid[at], a.rad[at])
    __gt__ = lambda a, b: (a - b).near > a.rad * UP
    T = property(lambda a: Ball(a.mid.T, a.rad.T))
    shape = property(lambda a: a.mid.shape)
    middle = property(lambda a: Ball(a.mid))
    near = cached_property(lambda a: a.mid.astype(float) * UNIT)
    most = cached_property(lambda a: (abs(a.near) + a.rad) * UP)  # no number of it is larger

    def __init__(self, mid, rad=0.0):
        self.mid = np.asarray(mid, object)
        self.rad = np.asarray(rad + np.zeros(self.mid.shape), float)

    def __add__(a, b):
        b = ball(b)
        return Ball(a.mid + b.mid, (a.rad + b.rad) * UP)

    def product(a, f, b):
        b = ball(b)
        rad = f(a.most, b.rad) + f(a.rad, abs(b.near))
        return Ball(f(a.mid, b.mid) >> P, rad * UP + LAST)

    def __rtruediv__(a, b):
        least = abs(a.near) / UP - a.rad
        need((least > 0).all(), "a number may be zero")
        return b * Ball(ONE * ONE // a.mid, a.rad / least / abs(a.near) * UP + LAST)

    def __truediv__(a, b):
        return 1 / ball(b) * a


def ball(x):
    if isinstance(x, Ball):
        return x
    return Ball(each(lambda a: int(a * ONE), x), each(lambda a: a % 1 and LAST, x))


def stack(parts):
    parts = [ball(part) for part in parts]
    return Ball(*(np.vstack([getattr(part, one) for part in parts]) for one in ("mid", "rad")))


def times(t, W):
    """A number and a matrix with derivatives behind both."""
    return W * t[0] + W[:, :1] * rates(t)


def rates(t):
    return Ball(*(np.where(np.arange(len(t)), one, 0) for one in (t.mid, t.rad)))


def inverse(A):
    """Near that of the middle: nothing depends on it but whether a proof succeeds."""
    C = ball(np.linalg.inv(A.near))
    for _ in range(2):
        C = (C + C @ (eye(len(C)) - A.middle @ C)).middle
    return C


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
        A = A[1:, 1:] - A[1:, :1] / A[0, 0] * A[:1, 1:]


class Phase:
    """While springs are closed: dw/dt = A w, w = (x, v, 1), with the energy w'Gw / 2."""

    def __init__(self, G, flow):
        self.G, self.A = ball(G), ball(flow @ G)
        fast = Fraction(2)**int(np.log2(self.A.most.sum(1).max() + 1) // 2)  # about its highest
        units = np.array([Fraction(1), 1 / fast, Fraction(1)]).repeat([len(G) // 2, len(G) // 2, 1])
        self.back = ball(np.outer(1 / units, units))  # from speeds in units of that frequency
        A = ball(flow @ G * np.outer(units, 1 / units))
        self.norm, terms = A.most.sum(1).max(), [ball(eye(len(G)))]
        for k in range(1, 1 << TERMS):
            terms.append(terms[-1] @ A * Fraction(1, k))
        self.terms = stack([Ball(term.mid.reshape(1, -1), term.rad.reshape(1, -1))
                            for term in terms])

    def exp(self, t):
        """exp(A t)"""
        return self.back * self.scaled(int(t.mid), float(t.rad))

    @lru_cache(10000)
    def scaled(self, mid, rad):
        """The same in those units."""
        long = Ball(mid, rad).most * self.norm
        need(long < 1 << 16 and rad * self.norm < 32, "a flight is too long")
        if not long < SHORT:
            half = self.scaled(mid // 2, (rad / 2 + UNIT) * UP)
            return half @ half
        power, powers = Ball(mid, rad), ball([[1]])
        for _ in range(TERMS):
            powers, power = stack([powers, powers * power]), power * power
        total = powers.T @ self.terms
        return Ball(*(one.reshape(self.A.shape) for one in (total.mid, total.rad + TAIL)))

    def fly(self, W, t):
        """W after t, with derivatives. What moves little is flown as that, so that the rest of a
        stiff spring, where large numbers cancel, stays tight."""
        off = Ball(0, t.rad[0])
        W = self.exp(t[0].middle) @ W
        if off.rad:
            W = W + self.exp(off) @ (self.A @ W) * off
        return W + self.A @ W[:, :1] * rates(t) if len(t) > 1 else W

    def flies(self, rows, W, factors, t, depth, opens, closes, pressed):
        """Halves a flight of W @ factors until all gaps are positive, or move or bend away from
        where they are 0; or `pressed` together: to 0, or to rest, at both ends, and bent towards 0
        all the way."""
        need(depth, "a face is passed, or not approached")
        part = Ball(0, t.most[0] / 2 * UP) + t.most[0] / 2
        left = np.arange(len(rows))
        if part.most * self.norm < 32:
            moves, E = self.A @ W, self.exp(part)
            rate, bend = (-(rows @ (E @ dW)) @ factors for dW in (moves, self.A @ moves))
            gap = part * rate - rows @ W @ factors
            left = np.flatnonzero(~((gap > 0) | opens & (rate > 0) | closes & (-rate > 0)
                                    | (opens | closes) & (bend > 0) | pressed & (-bend > 0)))
        if len(left):
            half, rows, opens, closes = t * Fraction(1, 2), rows[left], opens[left], closes[left]
            none = np.zeros(len(left), bool)
            self.flies(rows, W, factors, half, depth - 1, opens, none, none)
            self.flies(rows, self.fly(W, half), factors, half, depth - 1, none, closes, none)


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
        self.rows = {face: ball(row) for face, row in self.exact.items()}
        self.kick = {face: self.flow @ row for face, row in self.exact.items()}  # along which, and
        self.speed = {face: row @ self.flow @ self.G for face, row in self.exact.items()}
        self.speeds = {face: ball(row) for face, row in self.speed.items()}

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
