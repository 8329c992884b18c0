"""Motion under power laws and its neighbours, by Taylor series in long doubles, many orbits at a time, each with its own step."""
import numpy as np

import arithmetic as ar

ORDER = 30
STEPS = 4000
SOLVED = 1e-15  # of a closure, relative: another Newton step would not better it by what a double shows


class _Power:
    """Coefficients of s^(m-1) as those of s come in: binary products of series."""

    def __init__(self, m, shape):
        self.plan, power, rest = [], 0, m - 1  # power 0: s itself
        names, have, result = 1, 0, None
        while rest:
            if rest & 1:
                if result is None:
                    result = have
                else:
                    self.plan.append((names, result, have))
                    result, names = names, names + 1
            rest >>= 1
            if rest:
                self.plan.append((names, have, have))
                have, names = names, names + 1
        self.result = result
        self.series = np.zeros((names, ORDER + 1) + shape, dtype=ar.LONG)

    def add(self, j, s):
        self.series[0, j] = s
        for target, a, b in self.plan:
            self.series[target, j] = (self.series[a, :j + 1] * self.series[b, j::-1]).sum(axis=0)
        return self.series[self.result]


def _expand(structure, u, v, X, tau_only=False):
    """Taylor coefficients of u [ORDER+3, P, n] and of the upper half of the neighbours [ORDER+3, P, n, columns]."""
    P, n = u.shape
    U = np.zeros((ORDER + 3, P, n), dtype=ar.LONG)
    U[0], U[1] = u, v
    columns = 0 if X is None else X.shape[2]
    W = np.zeros((ORDER + 3, P, n, columns), dtype=ar.LONG)
    if columns:
        W[0], W[1] = X[:, :n], X[:, n:]
    powers = [(_Power(m, (P,)), structure.c[i], m, k) for i, m, k in structure.powers]
    gaps = [np.zeros((ORDER + 1, P, columns), dtype=ar.LONG) for _ in powers]
    for j in range(ORDER + 1):
        force = -(U[j] @ structure.A)
        bend = -(structure.A @ W[j]) if columns else None
        for (power, c, m, k), gap in zip(powers, gaps):
            s = power.series[0]
            q = power.add(j, U[j] @ c)
            force = force - k * (q[:j + 1] * s[j::-1]).sum(axis=0)[:, None] * c
            if columns:
                gap[j] = c @ W[j]
                bend = bend - (k * m) * c[:, None] * (q[:j + 1, :, None] * gap[j::-1]).sum(axis=0)[:, None, :]
        U[j + 2] = force / ((j + 1) * (j + 2))
        if columns:
            W[j + 2] = bend / ((j + 1) * (j + 2))
    return U, W


def integrate(structure, u, v, T, neighbours=True, tolerance=1e-19):
    """States after the times T [P], and the matrices [P, 2n, 2n] of small deviations (None without). Many orbits at once cost
    little more than one: each goes on at its own step, and leaves when its time is over."""
    P, n = u.shape
    X = None
    if neighbours:
        X = np.zeros((P, 2 * n, 2 * n), dtype=ar.LONG)
        X[:, range(2 * n), range(2 * n)] = 1
    u, v, left = u.copy(), v.copy(), T.copy()
    for _ in range(STEPS):
        on = np.nonzero(left > 0)[0]
        if len(on) == 0:
            return u, v, X
        u[on], v[on], Y, h = _step(structure, u[on], v[on], X[on] if neighbours else None, left[on], tolerance)
        if neighbours:
            X[on] = Y
        left[on] = left[on] - h
        left = np.where(left < 1e-18 * T, 0, left)
    raise ArithmeticError(f"more than {STEPS} steps")


def _step(structure, u, v, X, left, tolerance):
    """(u, v, X, how long) of orbits that have `left` [P] > 0 to go."""
    j = np.arange(ORDER + 3, dtype=ar.LONG)
    U, W = _expand(structure, u, v, X)
    size = np.abs(U[0]).max(axis=1) + np.abs(U[1]).max(axis=1)
    h = left.copy()
    for order in (ORDER + 2, ORDER + 1, ORDER):
        last = np.abs(U[order]).max(axis=1) + 1e-4000
        h = np.minimum(h, (tolerance * size / last) ** (ar.LONG(1) / order) * ar.LONG(0.9))
    if X is not None:
        scale = np.abs(X).max(axis=(1, 2))
        for order in (ORDER + 2, ORDER + 1):
            last = np.abs(W[order]).max(axis=(1, 2)) + 1e-4000
            h = np.minimum(h, (tolerance * scale / last) ** (ar.LONG(1) / order) * ar.LONG(0.9))
    h = _sound(structure, U, W if X is not None else None, h, tolerance)
    powers = h[None, :] ** j[:, None]
    slopes = j[1:, None] * h[None, :] ** j[None, :-1].T
    u, v = (U * powers[:, :, None]).sum(axis=0), (U[1:] * slopes[:, :, None]).sum(axis=0)
    if X is not None:
        X = np.concatenate([(W * powers[:, :, None, None]).sum(axis=0), (W[1:] * slopes[:, :, None, None]).sum(axis=0)], axis=1)
    return u, v, X, h


def _sound(structure, U, W, h, tolerance):
    """Steps at whose end the series still solve the equations: a power beyond the order shows late in the coefficients."""
    j = np.arange(2, ORDER + 3, dtype=ar.LONG)
    for _ in range(60):
        powers = h[None, :] ** np.arange(ORDER + 3, dtype=ar.LONG)[:, None]
        bends = (j * (j - 1))[:, None] * powers[:-2]
        u = (U * powers[:, :, None]).sum(axis=0)
        force = acceleration(structure, u)
        off = np.abs((U[2:] * bends[:, :, None]).sum(axis=0) - force).max(axis=1)
        allowed = 100 * tolerance * (np.abs(force).max(axis=1) + np.abs(U[0]).max(axis=1) + np.abs(U[1]).max(axis=1))
        bad = off > allowed
        if W is not None:
            w = (W * powers[:, :, None, None]).sum(axis=0)
            want = -(structure.A @ w)
            for i, m, k in structure.powers:
                c = structure.c[i]
                want = want - (k * m) * ((u @ c) ** (m - 1))[:, None, None] * c[:, None] * (c @ w)[:, None, :]
            off = np.abs((W[2:] * bends[:, :, None, None]).sum(axis=0) - want).max(axis=(1, 2))
            bad |= off > 100 * tolerance * (np.abs(want).max(axis=(1, 2)) + np.abs(w).max(axis=(1, 2)))
        if not bad.any():
            break
        h = np.where(bad, h * ar.LONG(0.75), h)
    return h


def acceleration(structure, u):
    out = -(u @ structure.A)
    for i, m, k in structure.powers:
        c = structure.c[i]
        out = out - k * ((u @ c) ** m)[:, None] * c
    return out


def energy(structure, u, v):
    sum_ = (ar.dot(v, v) + ar.dot(u, u @ structure.A)) / 2
    for i, m, k in structure.powers:
        sum_ = sum_ + k * (u @ structure.c[i]) ** (m + 1) / (m + 1)
    return sum_


def polish(structure, u, v, T, rounds=2, cut=1e-10):
    """The nearest periodic orbits, their matrices, what the closure lacked at the start (relative) how far they are,
    what the closure lacks at the end, what one period changes in their energy, and the least singular value, relative,
    by which the closure divides rounding."""
    n, first, least = structure.n, None, None
    u, v, T = u.copy(), v.copy(), T.copy()
    start = np.concatenate([u, v, T[:, None]], axis=1)
    a, b, X = integrate(structure, u, v, T)
    for round_ in range(rounds + 1):
        su, sv = np.abs(ar.double(u)).max(axis=1) + np.abs(ar.double(v)).max(axis=1), np.abs(ar.double(v)).max(axis=1)
        sv = np.maximum(sv, su)
        weight = np.concatenate([su[:, None] * np.ones((1, n)), sv[:, None] * np.ones((1, n))], axis=1)
        gap = ar.double(np.concatenate([a - u, b - v], axis=1)) / weight
        if first is None:
            first = np.abs(gap).max(axis=1)
        open_ = np.nonzero(~(np.abs(gap).max(axis=1) < SOLVED))[0] if round_ else np.arange(len(u))
        if round_ == rounds or len(open_) == 0:
            break
        rate = np.concatenate([b, acceleration(structure, a)], axis=1)
        J = np.concatenate([ar.double(X) - np.eye(2 * n), ar.double(rate)[:, :, None]], axis=2)
        unknowns = np.concatenate([weight, ar.double(T)[:, None]], axis=1)
        J = J * unknowns[:, None, :] / weight[:, :, None]
        U, s, Vt = np.linalg.svd(J, full_matrices=False)
        if least is None:
            least = np.where(s > cut * s[:, :1], s / s[:, :1], 1).min(axis=1)
        inverse = np.where(s > cut * s[:, :1], 1 / np.maximum(s, 1e-300), 0)
        step = -np.einsum("pji,pj->pi", Vt, inverse * np.einsum("pji,pj->pi", U, gap)) * unknowns
        for x, dx in ((u, step[:, :n]), (v, step[:, n:2 * n]), (T, step[:, 2 * n])):
            x[open_] = x[open_] + dx[open_]
        a[open_], b[open_], X[open_] = integrate(structure, u[open_], v[open_], T[open_])
    moved = ar.double(np.concatenate([u, v, T[:, None]], axis=1) - start) / np.concatenate([weight, ar.double(T)[:, None]], axis=1)
    drift = np.abs(ar.double(energy(structure, a, b) / energy(structure, u, v) - 1))
    return u, v, T, X, first, np.abs(moved).max(axis=1), np.abs(gap).max(axis=1), drift, least
