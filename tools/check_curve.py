"""Checks curves of `ricochet prove --curves -o`: that the orbits of each arc lie on one smooth arc of
motions, each joined with the next one. Part of check_certificate.py; see docs/proofs.md.
"""
from collections import namedtuple

from mpmath import iv, mp, mpf

import check_chain
from check_chain import Chain, UNIT, block, middle, need, rounded

MORE = mpf(2) ** -12  # of a line, beyond its ends
FLOOR = mpf(2) ** -14  # of the longest step: no radius is less
TRIES, STEPS, DEEPEST = 4, 8, 9  # boxes; steps towards an orbit; halvings of a line
DIGITS = 30
upper = lambda x: mpf(abs(x).b)


Part = namedtuple("Part", "first last radii C Z")


class Tube(Chain):
    """Between the orbits a and b: p(s) = a + s (b - a), and on the plane row.(u - p(s)) = 0 for each s
    one zero in the box of radii `radii` around p(s), row = b - a."""

    deepest = 14  # halvings of a flight: what takes more is shorter lines

    def __init__(self, a, b):
        self.__dict__.update(a.__dict__)
        self.row = middle(b.centre - a.centre)
        self.start = middle(a.centre)
        self.floor = FLOOR * max(upper(x) for x in self.row)
        self.spot = None  # where the plane lies

    def plane(self, put, U):
        put(self.row.T, (self.row.T * self.spot)[0], U)

    def place(self, s):
        return self.start + self.row * s

    def values(self, u):
        return self.equations(u)

    def slopes(self, u):
        one = iv.eye(u.rows)
        return self.equations(block((u, one)))[:, 1:]

    def box(self, first, last, radii):
        u = self.place(iv.mpf([first, last]))
        return iv.matrix([x + iv.mpf([-r, r]) for x, r in zip(u, radii)])

    def contract(self, first, last):
        """The box that is taken into itself for first <= s <= last, or None. F(p(s)) is F at the middle and
        what it changes by along half of the line."""
        n, mid, half = self.row.rows, (first + last) / 2, (last - first) / 2
        self.spot = self.place(mid)
        D = self.slopes(self.spot).apply(lambda x: mpf(x.mid))
        C = iv.matrix(mp.inverse(mp.matrix(D.tolist())).tolist())
        at = self.values(self.spot)
        at[0] = 0
        radii = [self.floor] * n
        for _ in range(TRIES):
            J = self.slopes(self.box(first, last, radii))
            along = J * self.row * iv.mpf([-half, half])
            along[0] = 0
            y, Z = C * (at + along), C * J - iv.eye(n)
            image = [upper(y[i]) + sum(upper(Z[i, j]) * radii[j] for j in range(n)) for i in range(n)]
            need(all(mp.isfinite(x) for x in image), "a number is not finite")
            if all(x < r for x, r in zip(image, radii)):
                return Part(first, last, radii, C, Z)
            radii = [r if x < r else x * 9 / 8 for x, r in zip(image, radii)]
        return None

    def stands(self, first, last, radii):
        """All of them close, and are motions."""
        u, n = self.box(first, last, radii), 2 * self.m.n
        w = u[:n, 0]
        self.energy(w, 1 + u[u.rows - 1] if self.general else 1)
        for k, w, t, begin, end in self.flights(u):
            ends = [(begin, self.opens[k], w, 1)] if begin else []
            if end and not self.general:  # each event but the last one is the beginning of a flight
                ends.append((end, self.opens[k + 1], self.phases[k].after(w, t[0]), -1))
            for face, opens, state, out in ends:
                if self.m.soft[face[0]]:
                    out = 1 if opens else -1
                need(-out * face[1] * (self.m.rows[face[0]] * self.m.A * state)[0] > 0, "an impact has no speed")
        self.passage(u)

    def touches(self, k):
        return True  # impacts have a speed, which is proved, and may be as slow as they like

    def parts(self, first=-MORE, last=1 + MORE, depth=0):
        """Boxes along the line, from part to part."""
        try:
            found = self.contract(first, last)
            need(found is not None, "the arc between two orbits is not proved to be one")
            self.stands(first, last, found.radii)
            return [found]
        except (ArithmeticError, ValueError):
            if depth == DEEPEST:
                raise
        mid = (first + last) / 2
        return self.parts(first, mid, depth + 1) + self.parts(mid, last, depth + 1)

    def meet(self, one, other):
        """Whether the zero of one part where they meet, found by steps that its box contracts, is in the other
        one, too: z is at most d from u if |z - u| <= |C F(u)| + Z |z - u|."""
        n, s = self.row.rows, iv.mpf(one.last if one.last == other.first else one.first)
        self.spot = u = middle(self.place(s))
        for _ in range(STEPS):
            u = middle(u - one.C * self.values(u))
        left, d = one.C * self.values(u), [2 * r + upper(a - b) for r, a, b in zip(one.radii, u, self.spot)]
        for _ in range(2 * STEPS):
            d = [upper(left[i]) + sum(upper(one.Z[i, j]) * d[j] for j in range(n)) for i in range(n)]
        off = [upper(a - b) + x for a, b, x in zip(u, self.spot, d)]
        return all(x < r for x, r in zip(off, other.radii)) and all(x < r for x, r in zip(off, one.radii))

    def holds(self, u, s, radii):
        """Whether an orbit near the end s, in the balls u, is on the arc there."""
        off = u - self.place(iv.mpf(s))
        share = upper((self.row.T * off)[0] / (self.row.T * self.row)[0])
        return share < MORE and all(upper(off[i]) + share * upper(self.row[i]) < radii[i] for i in range(off.rows))


def read_node(model, line, node):
    chain = Chain(model, {**node, "start": line["start"], "end": line["end"], "faces": line["faces"]})
    u = chain.prove()
    need([rounded(a, UNIT) for a in u[:len(chain.said)]] == chain.said, "other states or times")
    return chain, u


def check_step(a, b):
    """(chain, balls) of two orbits in a row."""
    need(a[0].said != b[0].said, "an orbit stands there twice")
    tube = Tube(a[0], b[0])
    parts = tube.parts()
    for before, after in zip(parts, parts[1:]):
        need(tube.meet(before, after) or tube.meet(after, before), "parts of a tube are not proved to meet")
    need(tube.holds(a[1], 0, parts[0].radii) and tube.holds(b[1], 1, parts[-1].radii), "tubes are not proved to meet")


def check(model, line):
    need(len(line["arcs"]) > 0 and all(len(arc) > 1 for arc in line["arcs"]), "an arc has no two orbits")
    for arc in line["arcs"]:
        before = None
        for node in arc:
            mp.dps = iv.dps = check_chain.DIGITS
            here = read_node(model, line, node)
            mp.dps = iv.dps = DIGITS
            if before:
                check_step(before, here)
            before = here
    mp.dps = iv.dps = check_chain.DIGITS
