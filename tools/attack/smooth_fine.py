"""Motion under power laws and its neighbours in many digits: Taylor series of one orbit, for what long doubles leave open.

Numbers are those of gmpy2 (Debian: python3-gmpy2), tens of times faster than mpmath's, which are used without it."""
import mpmath
import numpy as np

import arithmetic as ar
import orbits

try:
    import gmpy2
except ImportError:
    gmpy2 = None

DIGITS = 46  # of a step; numbers have a few more
ORDER = 56
STEPS = 3000
SAFE = 0.8  # of the step at which the last terms are at the rounding


class TooLong(ArithmeticError):
    """More steps than this is worth."""


def fast(x):
    """An mpmath number as one of gmpy2."""
    x = mpmath.mpf(x)
    if gmpy2 is None:
        return x
    sign, man, exp, _ = x._mpf_
    return gmpy2.mul_2exp(gmpy2.mpfr(-int(man) if sign else int(man), 240), exp) if exp >= 0 else \
        gmpy2.div_2exp(gmpy2.mpfr(-int(man) if sign else int(man), 240), -exp)


def _slow(x):
    """And back."""
    if gmpy2 is None:
        return x
    man, exp, _ = x.digits(2)
    negative = man.startswith("-")
    digits = man.lstrip("-")
    value = mpmath.mpf(int(digits, 2)) * mpmath.mpf(2) ** (exp - len(digits)) if x != 0 else mpmath.mpf(0)
    return -value if negative else value


def _each(function, x):
    out = np.empty(np.shape(x), dtype=object)
    for index, value in np.ndenumerate(x):
        out[index] = function(value)
    return out


class Motion:
    """A structure's equations in fast numbers."""

    def __init__(self, structure):
        if gmpy2 is not None:
            gmpy2.get_context().precision = 180
        self.n, self.zero = structure.n, fast(0)
        self.A = _each(fast, structure.A)
        self.laws = [(_each(fast, structure.c[i]), m, fast(k)) for i, m, k in structure.powers]
        self.plans = [_plan(m) for _, m, _ in self.laws]

    def _expand(self, u, v, X):
        """Taylor coefficients [ORDER + 1, n] of the motion, and [ORDER + 1, n, columns] of its neighbours."""
        n, columns = self.n, X.shape[1]
        U = np.full((ORDER + 1, n), self.zero, dtype=object)
        W = np.full((ORDER + 1, n, columns), self.zero, dtype=object)
        U[0], U[1], W[0], W[1] = u, v, X[:n], X[n:]
        series = [np.full((plan[0], ORDER + 1), self.zero, dtype=object) for plan in self.plans]
        gaps = [np.full((ORDER + 1, columns), self.zero, dtype=object) for _ in self.laws]
        for j in range(ORDER - 1):
            force, bend = -(self.A @ U[j]), -(self.A @ W[j]) if columns else None
            for (c, m, k), (_, steps, result), s, gap in zip(self.laws, self.plans, series, gaps):
                s[0, j] = (c * U[j]).sum()
                for target, a, b in steps:
                    s[target, j] = (s[a, :j + 1] * s[b, j::-1]).sum()
                q = s[result]
                force = force - k * (q[:j + 1] * s[0, j::-1]).sum() * c
                if columns:
                    gap[j] = c @ W[j]
                    bend = bend - np.outer(k * m * c, q[:j + 1] @ gap[j::-1])
            U[j + 2] = force / ((j + 1) * (j + 2))
            if columns:
                W[j + 2] = bend / ((j + 1) * (j + 2))
        return U, W

    def fly(self, u, v, T, neighbours):
        """State after the time T, and the matrix of small deviations (of no columns without)."""
        n = self.n
        X = np.full((2 * n, 2 * n if neighbours else 0), self.zero, dtype=object)
        for i in range(X.shape[1]):
            X[i, i] = fast(1)
        left = T
        for _ in range(STEPS):
            U, W = self._expand(u, v, X)
            h = min(_reach(U), _reach(W)) if neighbours else _reach(U)
            h, last = (left, True) if float(left) <= h else (fast(h), False)
            u, v = _sum(U, h), _sum(_slopes(U), h)
            if neighbours:
                X = np.concatenate([_sum(W, h), _sum(_slopes(W), h)])
            if last:
                return u, v, X
            left = left - h
        raise TooLong(f"more than {STEPS} steps")

    def acceleration(self, u):
        out = -(self.A @ u)
        for c, m, k in self.laws:
            out = out - k * (c * u).sum() ** m * c
        return out


def _plan(m):
    """(how many series, products (target, a, b), which of them is s^(m-1)) for a power m."""
    steps, names, have, result, rest = [], 1, 0, None, m - 1
    while rest:
        if rest & 1:
            if result is None:
                result = have
            else:
                steps.append((names, result, have))
                result, names = names, names + 1
        rest >>= 1
        if rest:
            steps.append((names, have, have))
            have, names = names, names + 1
    return names, steps, result


def _size(x):
    return max((abs(z) for z in x.flat), default=0)


def _log2(x):
    """log2 of a number that may be too small for a double."""
    return -1e9 if x == 0 else float(gmpy2.log2(x)) if gmpy2 is not None else float(mpmath.log(x, 2))


def _reach(U):
    """The time up to which the last terms of a series stay at the rounding of its first ones."""
    size = _log2(max(_size(U[0]), _size(U[1]))) - DIGITS * 3.3219
    terms = [(size - _log2(_size(U[j]))) / j for j in range(ORDER - 6, ORDER + 1)]
    return SAFE * 2.0 ** min(min(terms), 60)


def _slopes(U):
    return U[1:] * np.array([j for j in range(1, ORDER + 1)], dtype=object).reshape((-1,) + (1,) * (U.ndim - 1))


def _sum(U, h):
    out = U[-1]
    for row in U[-2::-1]:
        out = out * h + row
    return out


def orbit(structure, u, v, T, rounds=5):
    """The periodic orbit beside u, v [n], T in mpmath numbers: Newton's method with the closure in many digits and its Jacobian as it
    was at the beginning; energy is the equation that is left over, the flow and the curve's direction are left alone.
    (u, v, T, how far away, what the closure lacks), in fast numbers."""
    motion, n = Motion(structure), structure.n
    u, v, T = _each(fast, u), _each(fast, v), fast(T)
    weight = np.full(2 * n, _size(u) + _size(v), dtype=object)
    solve = far = None
    for _ in range(rounds):
        a, b, X = motion.fly(u, v, T, solve is None)
        off = np.concatenate([a - u, b - v]) / weight
        left = float(_size(off))
        if solve is None:
            solve = _bordered(motion, u, v, X, a, b, weight, T)
            first = np.concatenate([u, v, [T]])
        if left < 1e-38:
            break
        step = solve(off)
        u, v, T = u + step[:n] * weight[0], v + step[n:2 * n] * weight[0], T + step[2 * n] * T
    far = float(max(abs(x) for x in (np.concatenate([u, v, [T]]) - first) / np.append(weight, T)))
    return motion, u, v, T, far, left


def _bordered(motion, u, v, X, a, b, weight, T):
    """What gives a step of Newton's method for a closure."""
    n = motion.n
    rate = np.concatenate([b, motion.acceleration(a)]) * T / weight
    J = np.concatenate([X, rate[:, None]], axis=1)
    for i in range(2 * n):
        J[i, i] = J[i, i] - 1
    flow = np.concatenate([v, motion.acceleration(u)]) / weight
    flow = np.append(flow / _size(flow), motion.zero)
    bare = J.astype(float)
    U, _, Vt = np.linalg.svd(np.concatenate([bare, flow.astype(float)[None, :]]))
    along = _each(fast, Vt[-1])
    energy = np.concatenate([-motion.acceleration(u), v]) / weight
    border = (energy / _size(energy))[:, None]
    size = 2 * n + 2
    matrix = np.full((size, size), motion.zero, dtype=object)
    matrix[:2 * n, :2 * n + 1], matrix[:2 * n, 2 * n + 1:] = J, border
    matrix[2 * n, :2 * n + 1], matrix[2 * n + 1, :2 * n + 1] = flow, along
    return lambda off: orbits.solve(matrix, np.append(-off, np.array([motion.zero, motion.zero])))[:2 * n + 1]


def rho(structure, motion, u, v, T, symmetric):
    """rho of all pairs as doubles (orbits.pairs), of a symmetric orbit from half of it."""
    _, _, X = motion.fly(u, v, T / 2 if symmetric else T, True)
    a = motion.acceleration(u)
    X, flow, gradient = (_each(_slow, x) for x in (X, np.concatenate([v, a]), np.concatenate([-a, v])))
    R = orbits.section_map(flow[None, :], gradient[None, :], (-X if symmetric else X)[None, :, :], True)
    return orbits.doubled(orbits.pairs(R))[0] if symmetric else orbits.pairs(R)[0]
