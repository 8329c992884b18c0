"""Periodic orbits of one energy, without families: many motions from event to event, and Newton's method from those that come back.

Starts lie right behind an event: by chance on every face, and on the sets that time reversal keeps, where motions begin at rest or
with an impact that turns them round. A motion that comes near to its start behind an event of the same kind gives word and times to
Newton's method, of which the result has to pass the judge's gaps. Two modes make the starts dense; three leave more to chance.
"""
import numpy as np

import arithmetic as ar
import gaps
from orbits import Chain

STEP = 0.12  # radians of the fastest mode between looks at the gaps: what enters and leaves between two looks is missed
LOOKS = 64  # at once
MOST_LOOKS = 12800  # for one flight
STARTS = {2: 1500, 3: 4000}  # by chance, per face; and half as many of each kind that is turned round
NEAREST = {2: 40, 3: 120}  # of each word go to Newton's method
WORDS = 400  # the most frequent ones
ROUNDS = 16  # of Newton's method
LEFT = 1e-13  # residual of an orbit
SLOWEST = 1e-6  # speed at an event, over the largest: slower ones are grazings
SAME = 1e-7  # of times: one orbit
REPEATED = 1e-9


class Motions:
    """Motions from event to event in doubles. `shut` [P] is the set of closed springs as bits."""

    def __init__(self, s):
        self.s = s
        self.c = [ar.double(s.c[f.contact]) for f in s.faces]
        self.side = [float(f.side) for f in s.faces]
        self.limit = [float(f.limit) for f in s.faces]
        self.spring = [float(f.spring) for f in s.faces]

    def closed(self, bits):
        return frozenset(f for f in range(len(self.c)) if bits >> f & 1)

    def gap(self, f, u):
        return self.side[f] * (u @ self.c[f]) - self.limit[f]

    def potential(self, u):
        """Energy at rest, whatever springs are reached."""
        sum_ = ((u @ ar.double(self.s.A)) * u).sum(axis=1) / 2
        for f, spring in enumerate(self.spring):
            sum_ = sum_ + spring * np.maximum(self.gap(f, u), 0) ** 2 / 2
        return sum_

    def next(self, shut, u, v, limit):
        """(face, time) of the next event of motions with one set of closed springs; face -1 where there is none in time."""
        vectors, lam, rest = (ar.double(x) for x in self.s.phase(self.closed(shut)))
        w = np.sqrt(np.maximum(lam, 0))
        y, yd = (u - rest) @ vectors, v @ vectors
        face, when = np.full(len(u), -1), np.zeros(len(u))
        step, begin, open_ = STEP / w.max(), 0.0, np.arange(len(u))
        rounds = int(min(np.ceil(limit / (step * LOOKS)), MOST_LOOKS / LOOKS))
        for _ in range(max(1, rounds)):
            t = begin + step * np.arange(LOOKS + 1)
            place = _place(w, y[open_], yd[open_], t) @ vectors.T + rest
            first = np.full(len(open_), LOOKS + 1)
            for f in range(len(self.c)):
                sign = -1 if shut >> f & 1 else 1
                g = sign * self.gap(f, place)
                crossed = (g[:, :-1] <= 0) & (g[:, 1:] > 0)
                if begin == 0:
                    crossed[:, 0] &= g[:, 0] < -1e-9
                at = np.where(crossed.any(axis=1), crossed.argmax(axis=1), LOOKS + 1)
                earlier = at < first
                face[open_[earlier]], first = np.where(earlier, f, face[open_])[earlier], np.minimum(first, at)
            met = first <= LOOKS
            when[open_[met]] = begin + step * first[met]
            open_, begin = open_[~met], begin + step * LOOKS
            if not len(open_):
                break
        self._refine(shut, (vectors, w, rest, y, yd), face, when, step)
        face[when > limit] = -1
        return face, when

    def _refine(self, shut, motion, face, when, step):
        vectors, w, rest, y, yd = motion
        for f in np.unique(face[face >= 0]):
            p = np.nonzero(face == f)[0]
            sign = -1 if shut >> int(f) & 1 else 1
            low, high = when[p], when[p] + step
            for _ in range(46):
                at = (low + high) / 2
                place = _place(w, y[p], yd[p], at[:, None])[:, 0] @ vectors.T + rest
                inside = sign * self.gap(f, place) <= 0
                low, high = np.where(inside, at, low), np.where(inside, high, at)
            when[p] = (low + high) / 2

    def through(self, shut, u, v, limit):
        """(face, kind, time, set, u, v) behind the next event of each motion; kind 0 impact, 1 closing, 2 opening, -1 none."""
        face, time = np.full(len(u), -1), np.zeros(len(u))
        kind, shut, u, v = face.copy(), shut.copy(), u.copy(), v.copy()
        for bits in np.unique(shut):
            p = np.nonzero(shut == bits)[0]
            face[p], time[p] = self.next(int(bits), u[p], v[p], limit)
            p = p[face[p] >= 0]
            if len(p):
                u[p], v[p] = (ar.double(x) for x in self.s.fly(self.closed(int(bits)), u[p], v[p], time[p]))
        for f in np.unique(face[face >= 0]):
            p, c = np.nonzero(face == f)[0], self.c[f]
            if self.spring[f]:
                kind[p] = np.where(shut[p] >> f & 1, 2, 1)
                shut[p] ^= 1 << int(f)
            else:
                kind[p] = 0
                v[p] -= (2 * (v[p] @ c) / (c @ c))[:, None] * c
        return face, kind, time, shut, u, v


def _place(w, y, yd, t):
    """Modal displacements [P, times, n]; t [times] or [P, 1]."""
    angle = np.asarray(t)[..., None] * w
    still = w == 0
    sine = np.where(still, np.broadcast_to(np.asarray(t)[..., None], angle.shape), np.sin(angle) / np.where(still, 1, w))
    return y[:, None, :] * np.cos(angle) + yd[:, None, :] * sine


def _directions(rng, count, n):
    x = rng.standard_normal((count, n))
    return x / np.linalg.norm(x, axis=1, keepdims=True)


def _on_face(m, f, energy, count, rng):
    """States that meet a face, in place and direction by chance; half of them turned round by the impact if it is rigid."""
    s, c, A = m.s, m.c[f], ar.double(m.s.A)
    low, vectors = np.linalg.eigh(A)
    u = _directions(rng, count, s.n) * rng.uniform(0, 1, (count, 1)) ** (1 / s.n) @ (vectors * np.sqrt(2 * energy / low)).T
    u += ((m.side[f] * m.limit[f] - u @ c) / (c @ c))[:, None] * c
    room = 2 * (energy - m.potential(u))
    v = _directions(rng, count, s.n)
    if not m.spring[f]:
        v[::2] = c
    v *= np.where(m.side[f] * (v @ c) > 0, 1, -1)[:, None]
    v *= np.sqrt(np.maximum(room, 0) / (v * v).sum(axis=1))[:, None]
    if not m.spring[f]:
        v -= (2 * (v @ c) / (c @ c))[:, None] * c
    return u[room > 0], v[room > 0]


def _at_rest(m, energy, count, rng):
    """Displacements from which motions of that energy begin at rest, springs closed or open."""
    d = _directions(rng, count, m.s.n)
    low, high = np.zeros(count), np.full(count, 1.0)
    for _ in range(200):
        short = m.potential(d * high[:, None]) < energy
        if not short.any():
            break
        high[short] *= 2
    for _ in range(60):
        at = (low + high) / 2
        short = m.potential(d * at[:, None]) < energy
        low, high = np.where(short, at, low), np.where(short, high, at)
    return d * low[:, None]


def _allowed(m, u):
    """Whether no rigid stop is passed; and the springs that are closed."""
    good, shut = np.ones(len(u), dtype=bool), np.zeros(len(u), dtype=np.int64)
    for f, spring in enumerate(m.spring):
        gap = m.gap(f, u)
        if spring:
            shut += np.where(gap > 1e-12, 1 << f, 0)
        else:
            good &= gap <= 1e-12
    return good, shut


def starts(m, energy, limit, rng):
    """(face, kind, set, u, v) right behind an event."""
    count, out = STARTS[m.s.n], []
    for f, spring in enumerate(m.spring):
        u, v = _on_face(m, f, energy, count, rng)
        good, shut = _allowed(m, u)
        u, v, shut = u[good], v[good], shut[good]
        if spring:
            shut |= 1 << f
        out.append((np.full(len(u), f), np.full(len(u), 1 if spring else 0), shut, u, v))
    u = _at_rest(m, energy, count, rng)
    good, shut = _allowed(m, u)
    u, shut = u[good], shut[good]
    if len(u):
        face, kind, _, shut, u, v = m.through(shut, u, np.zeros_like(u), limit)
        met = face >= 0
        out.append((face[met], kind[met], shut[met], u[met], v[met]))
    return [np.concatenate(x) for x in zip(*out)]


def returns(m, energy, most, limit, rng):
    """{(set, events): [(distance, u, v, times)]} of motions that come back to the event they begin behind."""
    face, kind, shut, u, v = starts(m, energy, limit, rng)
    first = face, kind, shut, u, v
    size = np.sqrt(2 * energy)
    alive, words, times = np.arange(len(u)), [[] for _ in u], [[] for _ in u]
    letters, spent, found = np.zeros(len(u), dtype=int), np.zeros(len(u)), {}
    for _ in range(4 * most):
        face, kind, time, shut, u, v = m.through(shut, u, v, limit)
        spent = spent + time
        letters = letters + (kind < 2)
        keep = (face >= 0) & (letters <= most) & (spent < limit)
        alive, face, kind, shut, u, v, spent, letters, time = (x[keep] for x in (alive, face, kind, shut, u, v, spent, letters, time))
        for p, f, k, t in zip(alive, face, kind, time):
            words[p].append((int(f), int(k)))
            times[p].append(t)
        if not len(alive):
            break
        back = (face == first[0][alive]) & (kind == first[1][alive]) & (shut == first[2][alive])
        off = np.abs(u - first[3][alive]).max(axis=1) / size + np.abs(v - first[4][alive]).max(axis=1) / size
        for i in np.nonzero(back & (off < 1))[0]:
            p = alive[i]
            events = tuple(words[p][-1:] + words[p][:-1])
            found.setdefault((int(first[2][p]), events), []).append((off[i], p, tuple(times[p])))
    return found, first


def _newton(chain, energy, rounds):
    """The chain after so many of Newton's steps in states and times, with its energy as one equation more."""
    s = chain.s
    for _ in range(rounds):
        held = s.energy(chain.first_closed, chain.u, chain.v) - energy
        off = ar.double(np.concatenate([chain.residual(), held[:, None]], axis=1))
        slope = np.concatenate([-s.acceleration(chain.first_closed, chain.u), chain.v, chain.tau * 0], axis=1)[:, None, :]
        J = ar.double(np.concatenate([chain.jacobian(), slope], axis=1))
        sound = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(off).all(axis=1)
        step = np.zeros((len(off), J.shape[2]))
        step[sound] = np.einsum("pij,pj->pi", np.linalg.pinv(J[sound], rcond=1e-12), off[sound])
        size = np.abs(step).max(axis=1, keepdims=True)
        chain = chain.moved(-(step / np.maximum(1, 2 * size)).astype(ar.LONG))
    return chain


def picked(chain, p):
    return Chain(chain.s, chain.events, chain.first_closed, chain.u[p], chain.v[p], chain.tau[p])


def solve(chain, energy, rounds=ROUNDS):
    """The orbits of that energy to which Newton's method leads, and whether it does."""
    chain = _newton(chain, energy, rounds)
    held = np.abs(ar.double(s_energy(chain)) / energy - 1)
    return chain, (chain.relative_residual() < LEFT) & (held < 1e-11)


def s_energy(chain):
    return chain.s.energy(chain.first_closed, chain.u, chain.v)


def admissible(chain):
    """[P]: events in their order, each met with speed, no face passed between them."""
    size = chain.size()[1]
    speeds = np.min([ar.double(x) for x in chain.speed], axis=0) / size
    times = ar.double(chain.tau).min(axis=1) / ar.double(chain.tau).sum(axis=1)
    good = (speeds > SLOWEST) & (times > 0)
    if good.any():
        good[good] = gaps.Reach(picked(chain, good)).worst() < 1 - 1e-9
    return good


def shorter(chain):
    """[P]: whether the orbit is a shorter one gone through several times."""
    size, out = np.sqrt(2 * ar.double(s_energy(chain))), np.zeros(len(chain.u), dtype=bool)
    for part in range(1, chain.N):
        if chain.N % part == 0 and chain.events[part:] + chain.events[:part] == chain.events:
            off = [np.abs(ar.double(a - b)).max(axis=1) for k in range(chain.N)
                   for a, b in zip(chain.after[k], chain.after[(k + part) % chain.N])]
            out |= np.max(off, axis=0) < REPEATED * size
    return out


class Orbit:
    """One orbit: the chain of it alone, and what does not depend on where it begins or in which direction it is gone through."""

    def __init__(self, chain, p, energy):
        self.chain, self.energy = picked(chain, [p]), energy
        self.period = float(chain.tau[p].sum())
        self.times = np.sort(ar.double(chain.tau[p])) / self.period
        self.impacts = sum(kind != "open" for _, kind in chain.events)
        self.laws = tuple(sorted(kind for _, kind in chain.events))

    def same(self, other):
        return (self.impacts == other.impacts and self.laws == other.laws and abs(self.period - other.period) < SAME * self.period
                and np.abs(self.times - other.times).max() < SAME)

    def letters(self):
        return " ".join(f"{'-' if kind == 'open' else ''}{f}" for f, kind in self.chain.events)


def orbits_at(s, energy, most, limit, rng):
    """All orbits of that energy (in units of the judge) that are found, each once."""
    m = Motions(s)
    found, first = returns(m, energy, most, limit, rng)
    out = []
    for (shut, events), motions in sorted(found.items(), key=lambda x: -len(x[1]))[:WORDS]:
        motions.sort(key=lambda x: x[0])
        motions = motions[:NEAREST[s.n]]
        p = [x[1] for x in motions]
        names = [(f, ("hit", "close", "open")[k]) for f, k in events]
        chain = Chain(s, names, m.closed(shut), *(first[i][p].astype(ar.LONG) for i in (3, 4)),
                      np.array([x[2] for x in motions]).astype(ar.LONG))
        if not chain.sound:
            continue
        chain, good = solve(chain, energy)
        if not good.any():
            continue
        chain = picked(chain, good)
        good = admissible(chain)
        good[good] = ~shorter(picked(chain, good)) if good.any() else False
        for i in np.nonzero(good)[0]:
            orbit = Orbit(chain, i, energy)
            if orbit.period < limit and not any(orbit.same(o) for o in out):
                out.append(orbit)
    return out
