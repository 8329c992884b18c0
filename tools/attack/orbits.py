"""Orbits of one word, many at a time: chain of flights, residual, polishing, multipliers, gaps. Nothing of it is the program's.

A chain starts right after event 0 and meets event 1, ..., N-1, 0; `tau` [P, N] are the times between. Flights with given times
are isometries (but for springs), so that a chain is well conditioned whatever its multipliers; growth sits in the times.
"""
import mpmath
import numpy as np

import arithmetic as ar

CUT = 1e-11  # singular values below this part of the largest are left alone: along the curve, and its kin at a branch point


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
            u, v = s.fly(closed, *self.start(k, u, v), self.tau[:, k])
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

    def start(self, _k, u, v):
        """Where flight k starts, if the one before ends at (u, v)."""
        return u, v

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
        n, N, P = self.s.n, self.N, len(self.u)
        exact = ar.exact_of(self.u)
        X = ar.zeros((P, 2 * n, 2 * n + N), exact)
        X[:, range(2 * n), range(2 * n)] = X[:, range(2 * n), range(2 * n)] + 1
        rows = []
        for k in range(N):
            X, slope = self._through(k, X)
            rows.append(slope)
        X[:, range(2 * n), range(2 * n)] = X[:, range(2 * n), range(2 * n)] - 1
        return np.concatenate([np.stack(rows, axis=1), X], axis=1)

    def _through(self, k, X):
        """Deviations X behind event k taken through flight k, with its time as unknown 2n + k, and what they do to its gap."""
        s, n = self.s, self.s.n
        X = s.fly_columns(self.closed[k], X, self.tau[:, k])
        u, v = self.before[k]
        X[:, :n, 2 * n + k] = X[:, :n, 2 * n + k] + v
        X[:, n:, 2 * n + k] = X[:, n:, 2 * n + k] + s.acceleration(self.closed[k], u)
        f, kind = self.events[(k + 1) % self.N]
        face, c = s.faces[f], s.c[s.faces[f].contact]
        slope = face.side * (c @ X[:, :n])
        if kind == "hit":
            X[:, n:] = X[:, n:] - (2 / (c @ c)) * c[:, None] * (c @ X[:, n:])[:, None, :]
        return X, slope

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

    def chosen(self, pick, other):
        """Orbits of this chain where `pick` [P], of the other elsewhere."""
        pick = pick[:, None]
        return Chain(self.s, self.events, self.first_closed, np.where(pick, self.u, other.u), np.where(pick, self.v, other.v),
                     np.where(pick, self.tau, other.tau))

    def relative_residual(self):
        return np.abs(ar.double(self.residual()) / self.weights()[1]).max(axis=1)

    def weighted(self):
        """The Jacobian between unknowns and equations over their sizes, in doubles."""
        unknowns, equations = self.weights()
        return ar.double(self.jacobian()) * unknowns[:, None, :] / equations[:, :, None]

    def singular(self):
        """Its singular value decomposition."""
        return np.linalg.svd(self.weighted())

    def growth(self):
        """[P]: what the equations make of a change of the unknowns, at most, both relative."""
        return np.linalg.norm(self.weighted(), ord=2, axis=(1, 2))

    def rounded_gap(self, k, contact, at):
        """[P]: what the last digits of the numbers that are stored make of the gap of a contact at its maximum, so long after flight
        k has begun: all flights before last as long as they are said to, and that one to wherever the maximum is."""
        s, n, P = self.s, self.s.n, len(self.u)
        X = ar.zeros((P, 2 * n, 2 * n + self.N), ar.exact_of(self.u))
        X[:, range(2 * n), range(2 * n)] = X[:, range(2 * n), range(2 * n)] + 1
        for i in range(k):
            X, _ = self._through(i, X)
        X = s.fly_columns(self.closed[k], X, at)
        return np.abs(ar.double(s.c[contact] @ X[:, :n]) * self.weights()[0]).sum(axis=1) * 2 ** -53


def solve(a, b):
    """x with a x = b, by elimination with pivots in the digits of the numbers."""
    a, x = a.copy(), b.copy()
    for i in range(len(a)):
        p = i + int(np.argmax([abs(z) for z in a[i:, i]]))
        if a[p, i] == 0:
            raise ArithmeticError("a matrix has no inverse")
        a[[i, p]], x[[i, p]] = a[[p, i]], x[[p, i]]
        for j in range(i + 1, len(a)):
            if a[j, i] != 0:
                part = a[j, i] / a[i, i]
                a[j, i:] = a[j, i:] - part * a[i, i:]
                x[j] = x[j] - part * x[i]
    for i in range(len(a) - 1, -1, -1):
        x[i] = (x[i] - (a[i, i + 1:] * x[i + 1:]).sum()) / a[i, i]
    return x


def bordered(chain):
    """The relative Jacobian of one orbit in 50 digits, [size + 1, size + 1] with the direction along the curve and the equation that
    energy makes superfluous."""
    unknowns, equations = [ar.array(w[0], True) for w in chain.weights()]
    U, _, Vt = chain.singular()
    size = len(unknowns)
    matrix = ar.zeros((size + 1, size + 1), True)
    matrix[:size, :size] = chain.jacobian()[0] * unknowns[None, :] / equations[:, None]
    matrix[:size, size], matrix[size, :size] = ar.array(U[0, :, -1], True), ar.array(Vt[0, -1], True)
    return matrix


def tangent_finely(chain):
    """The direction along the curve of one orbit in 50 digits, of unit length in relative unknowns."""
    matrix = bordered(chain)
    right = ar.zeros(len(matrix), True)
    right[-1] = ar.number(1, True)
    tangent = ar.double(solve(matrix, right)[:-1])
    return tangent / np.linalg.norm(tangent)


def polish_finely(chain, rounds=6):
    """The same for one orbit in 50 digits: Newton's method with its Jacobian in these, bordered by the direction along the curve and
    the equation that energy makes superfluous, so that small singular values cost digits and not the convergence."""
    start, (unknowns, equations) = chain, [ar.array(w[0], True) for w in chain.weights()]
    for _ in range(rounds):
        left = float(max(abs(r) for r in chain.residual()[0] / equations))
        if left < 1e-42:
            break
        right = np.append(-chain.residual()[0] / equations, ar.zeros(1, True))
        chain = chain.moved((solve(bordered(chain), right)[:-1] * unknowns)[None, :])
    difference = np.concatenate([chain.u - start.u, chain.v - start.v, chain.tau - start.tau], axis=1)[0] / unknowns
    return chain, float(max(abs(x) for x in difference))


def polish(chain, rounds=4, cut=CUT):
    """The solution nearest to the chain (minimum-norm Newton steps, double Jacobian, residuals in the chain's digits) and how far
    away it is, [P], relative. Singular values below `cut` are left alone."""
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
        best = chain.chosen(better, best)
        least = np.where(better, now, least)
        chain = best
    difference = np.concatenate([best.u - start.u, best.v - start.v, best.tau - start.tau], axis=1)
    n, N = chain.s.n, chain.N
    own = np.concatenate([unknowns[:, :2 * n], unknowns[:, -N:]], axis=1)
    return best, np.abs(ar.double(difference) / own).max(axis=1)


class Apart(Chain):
    """The same orbits with a state of its own behind every event (multiple shooting): what is amplified from one end of a period
    to the other is amplified by one flight only, and an orbit that one chain cannot hold in its digits can be polished.

    Unknowns are the 2n of each state in turn, then the times; equations all gaps, then what joins the flights."""

    def __init__(self, structure, events, closed, starts, tau):
        self.starts = starts
        super().__init__(structure, events, closed, *starts[0], tau)

    @classmethod
    def of(cls, chain, picked):
        """The orbits `picked` of a chain. States of the second half are flown to from the end, which is the start: what a whole
        period makes of rounding would put them beside another orbit of the branch, and that one would be found."""
        starts = [(u[picked], v[picked]) for u, v in chain.after[:chain.N]]
        u, v = starts[0]
        for k in range(chain.N - 1, chain.N // 2, -1):
            f, kind = chain.events[(k + 1) % chain.N]
            if kind == "hit":
                c = chain.s.c[chain.s.faces[f].contact]
                v = v - (2 * (v @ c) / (c @ c))[:, None] * c
            u, v = chain.s.fly(chain.closed[k], u, v, -chain.tau[picked, k])
            starts[k] = (u, v)
        return cls(chain.s, chain.events, chain.first_closed, starts, chain.tau[picked])

    def run(self):
        super().run()
        self.ends = self.after[1:]
        self.after = self.starts + self.after[-1:]

    def start(self, k, u, v):
        return self.starts[k]

    def residual(self):
        joints = [np.concatenate([a - b for a, b in zip(self.ends[k], self.starts[(k + 1) % self.N])], axis=1)
                  for k in range(self.N)]
        return np.concatenate([np.stack(self.gap, axis=1)] + joints, axis=1)

    def jacobian(self):
        n, N, P = self.s.n, self.N, len(self.u)
        out = ar.zeros((P, N + 2 * n * N, 2 * n * N + N), ar.exact_of(self.u))
        for k in range(N):
            X = ar.zeros((P, 2 * n, 2 * n + N), ar.exact_of(self.u))
            X[:, range(2 * n), range(2 * n)] = X[:, range(2 * n), range(2 * n)] + 1
            X, slope = self._through(k, X)
            here, there, joint = 2 * n * k, 2 * n * ((k + 1) % N), N + 2 * n * k
            out[:, k, here:here + 2 * n], out[:, k, 2 * n * N + k] = slope[:, :2 * n], slope[:, 2 * n + k]
            out[:, joint:joint + 2 * n, here:here + 2 * n] = X[:, :, :2 * n]
            out[:, joint:joint + 2 * n, 2 * n * N + k] = X[:, :, 2 * n + k]
            for i in range(2 * n):
                out[:, joint + i, there + i] = out[:, joint + i, there + i] - 1
        return out

    def moved(self, du):
        n, N = self.s.n, self.N
        starts = [(u + du[:, 2 * n * k:2 * n * k + n], v + du[:, 2 * n * k + n:2 * n * (k + 1)])
                  for k, (u, v) in enumerate(self.starts)]
        return Apart(self.s, self.events, self.first_closed, starts, self.tau + du[:, 2 * n * N:])

    def chosen(self, pick, other):
        pick = pick[:, None]
        starts = [tuple(np.where(pick, a, b) for a, b in zip(x, y)) for x, y in zip(self.starts, other.starts)]
        return Apart(self.s, self.events, self.first_closed, starts, np.where(pick, self.tau, other.tau))

    def weights(self):
        unknowns, equations = super().weights()
        n, N = self.s.n, self.N
        return (np.concatenate([unknowns[:, :2 * n]] * N + [unknowns[:, 2 * n:]], axis=1),
                np.concatenate([equations[:, :N]] + [equations[:, N:]] * N, axis=1))


def opposite_events(chain, k):
    """Whether the events k later are those of the opposite faces: a contact with one side has none, and closes on one half only."""
    faces, events = chain.s.faces, chain.events
    return all(kind == other and faces[f].contact == faces[g].contact and faces[f].side == -faces[g].side
               for (f, kind), (g, other) in zip(events, events[k:] + events[:k]))


def half(chain, near=1e-10):
    """The number of events after which all orbits of a chain are at minus their beginning and go on as its image, for the same times,
    None if there is none: a motion that is all but linear is at minus its beginning before it goes on for another time."""
    if chain.N % 2 or not opposite_events(chain, chain.N // 2):
        return None
    k, (su, sv) = chain.N // 2, chain.size()
    (u0, v0), (u, v) = chain.after[0], chain.after[k]
    off = np.maximum(np.abs(ar.double(u + u0)).max(axis=1) / su, np.abs(ar.double(v + v0)).max(axis=1) / sv)
    tau = ar.double(chain.tau)
    other = np.abs(tau[:, :k] - tau[:, k:]).max(axis=1) / tau.sum(axis=1)
    return k if max(off.max(), other.max()) < near else None


def monodromy(chain, events=None):
    """[P, 2n, 2n] small deviations carried once round from right after event 0, or through its first flights, with the saltation of
    each stop."""
    s, n, N, P = chain.s, chain.s.n, chain.N, len(chain.u)
    X = ar.zeros((P, 2 * n, 2 * n), ar.exact_of(chain.u))
    X[:, range(2 * n), range(2 * n)] = X[:, range(2 * n), range(2 * n)] + 1
    for k in range(events or N):
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


def rho(chain):
    """rho of all pairs. Of an orbit that is at minus its beginning after half its events, from that half: +-2 and clusters of the
    whole are told apart there."""
    k = half(chain)
    if k is None:
        return pairs(reduced(chain, monodromy(chain)))
    return doubled(pairs(reduced(chain, -monodromy(chain, k))))


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
        return np.array([[_beside_two(x)] for x in ratio])
    if ar.exact_of(polynomial):
        return np.array([_exact_roots(c) for c in polynomial])
    return _long_roots(polynomial)


def doubled(own):
    """rho of a map gone through twice, rho^2 - 2, from its own. A pair at i and -i, well inside, is at -1 then: as a double it is
    put on the side of -2 where it is."""
    own = np.asarray(own)
    full, square = own * own - 2, (own * own).real
    beside = np.where((full.real == -2) & (square != 0), np.nextafter(-2.0, np.where(square > 0, 0.0, -4.0)), full.real)
    return beside + 1j * full.imag if np.iscomplexobj(own) else beside


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
