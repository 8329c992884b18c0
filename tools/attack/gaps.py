"""How far gaps open between events: stationary points and kinks of s(t) over each flight, from a grid finer than the fastest
mode by 2 pi / 0.05, each sign change of the slope polished, and where the slope comes near to zero between three points, too. Towards
both ends of a flight the grid grows denser, so that a bump right beside an event is seen down to 1e-6 of an interval."""
import numpy as np

import arithmetic as ar

FLAT = 1e-7  # part of the largest speed: a gap that changes no faster at an event may have its maximum there
FINE = 0.05  # radians of the fastest mode between grid points
MOST = 6000
HALVINGS = 20  # of the first and last interval
BRIEF = 1e-9  # of the period: a flight of that length begins and ends at once, and what is largest in it may be so by rounding


class Reach:
    """`stationary` [P]: largest s/d at maxima in flight; `kink` [P]: at hits of other contacts with a local maximum there;
    `event` [P]: at any event of other contacts. A closed face counts the other way round, 2 - s/d."""

    def __init__(self, chain):
        P = len(chain.u)
        self.stationary = np.full(P, -np.inf)
        self.kink = np.full(P, -np.inf)
        self.values = [[] for _ in range(P)]  # at all stationary points, and at all hits of other contacts
        self.event = np.full(P, -np.inf)
        self.touches = np.zeros(P, dtype=int)
        self.where = [""] * P
        self.place = [None] * P  # of `stationary`: (flight, contact, time in it, factor of s/d)
        for k in range(chain.N):
            self._flight(chain, k)
            self._at_event(chain, k)

    def _sides(self, structure, contact, closed):
        """(factor of s/d, offset) of the faces that count."""
        faces = [(f, face) for f, face in enumerate(structure.faces) if face.contact == contact]
        shut = [(f, face) for f, face in faces if f in closed]
        if shut:
            return [(f, -face.side / float(face.limit), 2.0) for f, face in shut]
        return [(f, face.side / float(face.limit), 0.0) for f, face in faces]

    def _flight(self, chain, k):
        s, closed = chain.s, chain.closed[k]
        vectors, lam, rest = (ar.double(x) for x in s.phase(closed))
        u, v = (ar.double(x) for x in chain.after[k])
        tau = ar.double(chain.tau[:, k])
        brief = tau < BRIEF * ar.double(chain.tau).sum(axis=1)
        w = np.sqrt(np.maximum(lam, 0))
        count = int(min(MOST, max(8, np.ceil(max(tau.max(), 0) * w.max() / FINE))))
        y, yd = (u - rest) @ vectors, v @ vectors
        t = tau[:, None] * _parts(count)[None]
        for contact, c in enumerate(s.c):
            sides = self._sides(s, contact, closed)
            if not sides:
                continue
            g = ar.double(c) @ vectors
            base = float(ar.double(c) @ rest)
            slope = _slope(g, w, y, yd, t)
            for f, factor, offset in sides:
                sign = np.sign(factor)
                if offset:
                    self._deepest(sign, slope, t, g, w, y, yd, factor, offset, base)
                p, lower, upper = _brackets(sign, sign * slope, t, g, w, y, yd)
                if len(p) == 0:
                    continue
                for _ in range(50):
                    middle = (lower + upper) / 2
                    rising = sign * _slope(g, w, y[p], yd[p], middle[:, None])[:, 0] > 0
                    lower, upper = np.where(rising, middle, lower), np.where(rising, upper, middle)
                    if _ > 28:
                        break
                at = (lower + upper) / 2
                near = (at < 1e-7 * tau[p]) | (at > (1 - 1e-7) * tau[p])
                value = factor * (base + _value(g, w, y[p], yd[p], at[:, None])[:, 0]) + offset
                for q, z, at_end, moment in zip(p, value, near, at):
                    if at_end and abs(z - 1) < 1e-6:
                        continue
                    self.values[q].append(float(z))
                    if z > self.stationary[q] and not brief[q]:
                        self.stationary[q], self.where[q] = z, f"face {f}, flight {k}"
                        self.place[q] = k, contact, moment, factor
                    if abs(z - 1) < 1e-8:
                        self.touches[q] += 1

    def _deepest(self, sign, slope, t, g, w, y, yd, factor, offset, base):
        turn = (sign * slope[:, :-1] < 0) & (sign * slope[:, 1:] >= 0)
        for p, i in zip(*np.nonzero(turn)):
            # the parabola through the slopes
            a, b = slope[p, i], slope[p, i + 1]
            at = t[p, i] + (t[p, i + 1] - t[p, i]) * a / (a - b)
            value = factor * (base + _value(g, w, y[p:p + 1], yd[p:p + 1], np.array([[at]]))[0, 0]) + offset
            self.values[p].append(float(value))

    def _at_event(self, chain, k):
        s = chain.s
        f, kind = chain.events[(k + 1) % chain.N]
        (u, v), (_, after) = chain.before[k], chain.after[k + 1]
        for contact, c in enumerate(s.c):
            if contact == s.faces[f].contact:
                continue
            gap, before, behind = ar.double(u @ c), ar.double(v @ c), ar.double(after @ c)
            bend = ar.double(s.acceleration(chain.closed[k], u) @ c)
            flat = np.abs(before) < FLAT * chain.size()[1] * np.sqrt(ar.double(c @ c))
            for _, factor, offset in self._sides(s, contact, chain.closed[k]):
                value = factor * gap + offset
                self.event = np.maximum(self.event, value)
                if kind != "hit" or np.all(before == behind):
                    self._rest(value, flat, factor * bend < 0)
                if kind == "hit":
                    bends = (factor * before > 0) & (factor * behind < 0)
                    for listed, z in zip(self.values, value):
                        listed.append(float(z))
                    self.kink = np.maximum(self.kink, np.where(bends, value, -np.inf))

    def _rest(self, value, flat, peak):
        """A stationary point that falls on an event which does not bend this gap is inside neither flight."""
        for p in np.nonzero(flat)[0]:
            self.values[p].append(float(value[p]))
            if peak[p] and abs(value[p] - 1) > 1e-6:
                self.stationary[p] = max(self.stationary[p], value[p])

    def worst(self):
        return np.maximum(np.maximum(self.stationary, self.event), self.kink)

    def says(self, i, reach):
        """Whether the program may call this the reach of orbit i: the gap at some stationary point or at a hit of another contact,
        and not less than at any maximum. (What is less than the largest maximum would hide how near the next face is.)"""
        largest = max(self.stationary[i], self.kink[i])
        if max(self.values[i], default=0) < 0.05 or reach < 0.05:
            return largest < 0.05 + reach
        return reach > largest - 1e-6 and any(abs(z - reach) <= 1e-6 * max(1, abs(reach)) for z in self.values[i])


def _parts(count):
    """Where is looked in a flight, from 0 to 1: evenly, and ever more densely towards both events, beside which a gap that a slow
    impact has hardly opened closes again."""
    beside = 2.0 ** -np.arange(1, HALVINGS + 1) / count
    return np.unique(np.concatenate([np.linspace(0, 1, count + 1), beside, 1 - beside]))


def _brackets(sign, rise, t, g, w, y, yd):
    """(orbit, from, to) of intervals with a maximum: sign changes of the slope on the grid, and pairs of them within two intervals,
    where the slope is nearest to zero between three points: by bisection of the curvature."""
    p, i = np.nonzero((rise[:, :-1] > 0) & (rise[:, 1:] <= 0))
    lower, upper = t[p, i], t[p, i + 1]
    left, middle, right = rise[:, :-2], rise[:, 1:-1], rise[:, 2:]
    side = np.sign(middle)
    near = (side * left >= side * middle) & (side * right >= side * middle)
    q, k = np.nonzero(near & (side != 0))
    if len(q) == 0:
        return p, lower, upper
    begin, end, side = t[q, k], t[q, k + 2], side[q, k]
    low, high = begin, end
    for _ in range(40):
        at = (low + high) / 2
        falling = side * sign * _bend(g, w, y[q], yd[q], at) < 0
        low, high = np.where(falling, at, low), np.where(falling, high, at)
    crossed = side * sign * _slope(g, w, y[q], yd[q], at[:, None])[:, 0] < 0
    begin, end = np.where(side > 0, begin, at)[crossed], np.where(side > 0, at, end)[crossed]
    return np.concatenate([p, q[crossed]]), np.concatenate([lower, begin]), np.concatenate([upper, end])


def _bend(g, w, y, yd, t):
    angle = t[:, None] * w
    return -(((yd * np.sin(angle) + y * w * np.cos(angle)) * w) * g).sum(axis=-1)


def _slope(g, w, y, yd, t):
    angle = t[..., None] * w
    return ((yd[:, None, :] * np.cos(angle) - y[:, None, :] * w * np.sin(angle)) * g).sum(axis=-1)


def _value(g, w, y, yd, t):
    angle = t[..., None] * w
    sine = np.where(w > 0, np.sin(angle) / np.where(w > 0, w, 1), t[..., None])
    return ((y[:, None, :] * np.cos(angle) + yd[:, None, :] * sine) * g).sum(axis=-1)
