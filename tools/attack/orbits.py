"""Orbits of one word, many at a time: chain of flights, residual, polishing, multipliers, gaps. Nothing of it is the program's.

A chain starts right after event 0 and meets event 1, ..., N-1, 0; `tau` [P, N] are the times between. Flights with given times
are isometries (but for springs), so that a chain is well conditioned whatever its multipliers; growth sits in the times.
"""
import mpmath
import numpy as np

import arithmetic as ar


class Chain:
    """All states along the orbits (u, v) [P, n] with times tau [P, N]."""

    def __init__(self, structure, events, closed, u, v, tau):
        self.s, self.events, self.first_closed = structure, events, closed
        self.u, self.v, self.tau = u, v, tau
        self.N = len(events)
        self.run()

    def run(self):
        s, u, v, closed = self.s, self.u, self.v, self.first_closed
        self.before, self.after, self.closed = [], [(u, v)], [closed]
        self.gap, self.speed = [], []
        for k in range(self.N):
            u, v = s.fly(closed, u, v, self.tau[:, k])
            self.before.append((u, v))
            f, kind = self.events[(k + 1) % self.N]
            face, c = s.faces[f], s.c[s.faces[f].contact]
            self.gap.append(face.side * (u @ c) - face.limit)
            speed = face.side * (v @ c)
            self.speed.append(-speed if kind == "open" else speed)
            if kind == "hit":
                v = v - (2 * (v @ c) / (c @ c))[:, None] * c
            closed = closed | {f} if kind == "close" else closed - {f}
            self.after.append((u, v))
            self.closed.append(closed)
        self.sound = closed == self.first_closed

    def residual(self):
        """[P, N + 2n]: gaps at all events, then the closure."""
        (u, v), (a, b) = self.after[-1], self.after[0]
        return np.concatenate([np.stack(self.gap, axis=1), u - a, v - b], axis=1)

    def size(self):
        """[P] of u, of v: from the energy, since all of a motion may rest at its events."""
        v = np.sqrt(2 * np.maximum(ar.double(self.s.energy(self.first_closed, *self.after[0])), 1e-60))
        u = np.max([np.abs(ar.double(a)).max(axis=1) for a, _ in self.after], axis=0)
        return np.maximum(u, v), v

    def jacobian(self):
        """Derivatives of the residual by u, v, tau, [P, N + 2n, 2n + N]: no saltation, since times are unknowns."""
        s, n, N, P = self.s, self.s.n, self.N, len(self.u)
        exact = ar.exact_of(self.u)
        X = ar.zeros((P, 2 * n, 2 * n + N), exact)
        X[:, range(2 * n), range(2 * n)] = X[:, range(2 * n), range(2 * n)] + 1
        rows = []
        for k in range(N):
            X = s.fly_columns(self.closed[k], X, self.tau[:, k])
            u, v = self.before[k]
            X[:, :n, 2 * n + k] = X[:, :n, 2 * n + k] + v
            X[:, n:, 2 * n + k] = X[:, n:, 2 * n + k] + s.acceleration(self.closed[k], u)
            f, kind = self.events[(k + 1) % N]
            face, c = s.faces[f], s.c[s.faces[f].contact]
            rows.append(face.side * (c @ X[:, :n]))
            if kind == "hit":
                X[:, n:] = X[:, n:] - (2 / (c @ c)) * c[:, None] * (c @ X[:, n:])[:, None, :]
        X[:, range(2 * n), range(2 * n)] = X[:, range(2 * n), range(2 * n)] - 1
        return np.concatenate([np.stack(rows, axis=1), X], axis=1)

    def moved(self, du):
        n = self.s.n
        return Chain(self.s, self.events, self.first_closed, self.u + du[:, :n], self.v + du[:, n:2 * n], self.tau + du[:, 2 * n:])

    def weights(self):
        """[P, 2n + N] sizes of the unknowns and [P, N + 2n] of the equations."""
        n, N = self.s.n, self.N
        u, v = self.size()
        tau = np.abs(ar.double(self.tau)).sum(axis=1) / N
        ones = np.ones((1, n))
        unknowns = np.concatenate([u[:, None] * ones, v[:, None] * ones, tau[:, None] * np.ones((1, N))], axis=1)
        equations = np.concatenate([u[:, None] * np.ones((1, N)), u[:, None] * ones, v[:, None] * ones], axis=1)
        return unknowns, equations

    def relative_residual(self):
        return np.abs(ar.double(self.residual()) / self.weights()[1]).max(axis=1)

    def singular(self):
        """Singular value decomposition of the weighted Jacobian, in doubles."""
        unknowns, equations = self.weights()
        J = ar.double(self.jacobian()) * unknowns[:, None, :] / equations[:, :, None]
        return np.linalg.svd(J)


def polish(chain, rounds=4, cut=1e-11):
    """The solution nearest to the chain (minimum-norm Newton steps, double Jacobian, residuals in the chain's digits) and how far
    away it is, [P], relative. Singular values below `cut` are left alone: along the curve, and its kin at a branch point."""
    start = chain
    unknowns, equations = chain.weights()
    U, s, Vt = chain.singular()
    inverse = np.where(s > cut * s[:, :1], 1 / np.maximum(s, 1e-300), 0)
    best, least = chain, chain.relative_residual()
    exact = ar.exact_of(chain.u)
    for _ in range(rounds * (3 if exact else 1)):
        r = chain.residual()
        size = np.maximum(np.abs(ar.double(r) / equations).max(axis=1), 1e-4000 if exact else 1e-300)
        if exact:
            scale = [max(abs(x / ar.number(float(w), True)) for x, w in zip(row, weight)) for row, weight in zip(r, equations)]
            if max(scale) == 0:
                break
            part = np.array([[float(x / ar.number(float(w), True) / (z or 1)) for x, w in zip(row, weight)]
                             for row, weight, z in zip(r, equations, scale)])
            step = np.einsum("pji,pj->pi", Vt, inverse * np.einsum("pji,pj->pi", U, part)) * unknowns
            step = ar.array(step, True) * np.array(scale, dtype=object)[:, None]
        else:
            step = np.einsum("pji,pj->pi", Vt, inverse * np.einsum("pji,pj->pi", U, ar.double(r) / equations)) * unknowns
            step = step.astype(ar.LONG)
        chain = chain.moved(-step)
        now = chain.relative_residual()
        if exact:
            best, least = chain, now
            continue
        better = now < least
        if not better.any():
            break
        pick = better[:, None]
        best = Chain(chain.s, chain.events, chain.first_closed, np.where(pick, chain.u, best.u),
                     np.where(pick, chain.v, best.v), np.where(pick, chain.tau, best.tau))
        least = np.where(better, now, least)
        chain = best
    difference = np.concatenate([best.u - start.u, best.v - start.v, best.tau - start.tau], axis=1)
    return best, np.abs(ar.double(difference) / unknowns).max(axis=1)


def monodromy(chain):
    """[P, 2n, 2n] small deviations carried once round from right after event 0, with the saltation of each stop."""
    s, n, N, P = chain.s, chain.s.n, chain.N, len(chain.u)
    X = ar.zeros((P, 2 * n, 2 * n), ar.exact_of(chain.u))
    X[:, range(2 * n), range(2 * n)] = X[:, range(2 * n), range(2 * n)] + 1
    for k in range(N):
        X = s.fly_columns(chain.closed[k], X, chain.tau[:, k])
        f, kind = chain.events[(k + 1) % N]
        if kind != "hit":
            continue  # a spring closes and opens without force: speed and acceleration go on
        c = s.c[s.faces[f].contact]
        u, v = chain.before[k]
        pull = s.acceleration(chain.closed[k], u) @ c
        along = c @ X[:, :n]
        turn = 2 / (c @ c) * (c @ X[:, n:] - (pull / (v @ c))[:, None] * along)
        X = np.concatenate([X[:, :n] - 2 / (c @ c) * c[:, None] * along[:, None, :], X[:, n:] - c[:, None] * turn[:, None, :]], axis=1)
    return X


def reduced(chain, X):
    """The map without its trivial part [P, m, m], m = 2(n-1): on what is perpendicular to the flow and to the gradient of energy."""
    n, P, exact = chain.s.n, len(chain.u), ar.exact_of(chain.u)
    u, v = chain.after[0]
    a = chain.s.acceleration(chain.first_closed, u)
    return section_map(np.concatenate([v, a], axis=1), np.concatenate([-a, v], axis=1), X, exact)


def section_map(flow, gradient, X, exact):
    """X on what is perpendicular to flow and gradient [P, m]: bases from doubles, made orthonormal again in their own digits."""
    P, size = flow.shape
    start = np.stack([ar.double(flow), ar.double(gradient)], axis=2)
    q, _ = np.linalg.qr(np.concatenate([start, np.broadcast_to(np.eye(size), (P, size, size))], axis=2))
    basis = [flow, gradient] + [ar.array(q[:, :, j], exact) for j in range(2, size)]
    for i in range(size):
        b = basis[i]
        for _ in range(2):
            for j in range(i):
                b = b - basis[j] * ar.dot(basis[j], b)[:, None]
            b = b / ar.sqrt(ar.dot(b, b))[:, None]
        basis[i] = b
    q = np.stack(basis[2:], axis=2) if size > 2 else ar.zeros((P, size, 0), exact)
    return q.transpose(0, 2, 1) @ X @ q


def pair_polynomial(R):
    """Coefficients, highest first, of the polynomial of degree m/2 whose roots are rho = lambda + 1/lambda, [P][m/2 + 1].

    e_j, the elementary symmetric functions of the multipliers, come from Faddeev and LeVerrier; sum over j of
    (-1)^j e_j lambda^(m-j) is palindromic, and lambda^k + lambda^-k are polynomials in rho (Chebyshev)."""
    P, m = R.shape[0], R.shape[1]
    h = m // 2
    exact = ar.exact_of(R)
    one = ar.zeros((P, m, m), exact)
    one[:, range(m), range(m)] = one[:, range(m), range(m)] + 1
    coefficient, Mk = [one[:, 0, 0]], one * 0
    for k in range(1, h + 1):
        Mk = R @ Mk + coefficient[-1][:, None, None] * one
        coefficient.append(-np.trace(R @ Mk, axis1=1, axis2=2) / k)
    # lambda^h * (c_h + sum_{j<h} c_j (lambda^(h-j) + lambda^-(h-j)))
    T = [[2], [0, 1]]  # lambda^k + lambda^-k in powers of rho, lowest first
    for k in range(2, h + 1):
        shifted = [0] + T[-1]
        T.append([shifted[i] - (T[-2][i] if i < len(T[-2]) else 0) for i in range(len(shifted))])
    out = ar.zeros((P, h + 1), exact)
    for j in range(h):
        for power, value in enumerate(T[h - j]):
            out[:, h - power] = out[:, h - power] + coefficient[j] * value
    out[:, h] = out[:, h] + coefficient[h]
    return out


def pairs(R):
    """rho = lambda + 1/lambda of all pairs, [P, n-1] complex doubles, sorted; polished in the digits of R."""
    polynomial = pair_polynomial(R)
    P, h = len(R), R.shape[1] // 2
    if h == 0:
        return np.zeros((P, 0))
    if h == 1:
        ratio = -polynomial[:, 1] / polynomial[:, 0]
        return np.array([[_beside_two(x) if ar.exact_of(polynomial) else float(x)] for x in ratio])
    if ar.exact_of(polynomial):
        return np.array([_exact_roots(c) for c in polynomial])
    return _long_roots(polynomial)


def _beside_two(x):
    """A number of many digits as a double, on the side of 2 or of -2 where it is."""
    near = float(x)
    if abs(near) == 2 and abs(x) != 2:
        return np.nextafter(near, near * 2 if abs(x) > 2 else 0)
    return near


def _exact_roots(c):
    try:
        z = mpmath.polyroots(list(c), maxsteps=400, extraprec=400)
        return np.array(sorted((complex(_beside_two(x.real), x.imag) for x in z), key=lambda x: (x.real, x.imag)))
    except (mpmath.libmp.NoConvergence, ZeroDivisionError):
        return np.full(len(c) - 1, np.nan + 0j)


def _long_roots(c):
    """Roots of the monic polynomials [P, h + 1]: eigenvalues of companion matrices, then Newton's method in long doubles."""
    P, h = c.shape[0], c.shape[1] - 1
    sound = np.isfinite(ar.double(c)).all(axis=1)
    companion = np.zeros((P, h, h))
    companion[:, range(1, h), range(h - 1)] = 1
    companion[sound, 0, :] = -ar.double(c[sound, 1:])
    with np.errstate(all="ignore"):
        z = np.linalg.eigvals(companion).astype(np.clongdouble)
        for _ in range(4):
            value, slope = z * 0, z * 0
            for k in range(h + 1):
                slope, value = slope * z + value, value * z + c[:, k:k + 1]
            step = np.where(slope != 0, value / np.where(slope == 0, 1, slope), 0)
            z = np.where(np.abs(step) < 0.1 * np.abs(z) + 1e-9, z - step, z)
    out = np.sort_complex(z.astype(complex))
    out[~sound] = np.nan
    return out
