"""The chain of a certificate for check_certificate.py: its equations, the proof that they have one
zero, that the zero is a motion, and that one arc of motions joins two of them."""
from fractions import Fraction

import numpy as np
from mpmath import mp

from certificate_balls import (P, REFUSED, TAIL, UP, Ball, ball, eye, inverse, need, reduced,
                               stack, times)

mp.dps = 90  # of an angle
STEPS, CLOSE = 12, 1e-60  # towards a zero
RADII = [2.0**-k for k in (10, 20, 30, 40)]  # within which a zero may be the only one
DEEPEST, SHALLOW = 60, 14  # halvings of a flight
UNIT, HELD = 18, 1000  # decimals of states and times; the held one is a multiple of 1000 units
MORE = 2.0**-12  # of a line, beyond its ends
HALF, SPAN = Fraction(1, 2), Ball(0, 0.5 + MORE)
TRIES, PARTS, THIN = 6, 16, 2.0**-24  # boxes, halvings of a line, the least side of a box
ASKED = {"held": 2, "speed": 1, "gap": 3, "time": 1, "break": 2, "turn": 2}  # numbers behind it
BESIDE = {"energy": [(0, 0)], "period": [(0, 0)], "double": [(0, 1)], "turn": [(0, 0), (1, 1)]}
size = lambda A: A.most.sum(1).max()  # the largest sum in a row


class System:
    """Unknown are (x, v, tau) behind each event, or from a mirror point on; then, in the same
    order, those of motions beside the orbit, with shifts in time of the next event."""

    def __init__(self, model, line):
        self.m, self.n, self.ends = model, model.n, (line["start"], line["end"])
        said = np.column_stack([np.array(line[key], object) for key in ("x", "v", "tau")])
        need({*map(type, said.flat)} == {int}, "a number is no integer")
        self.said, self.centre = [*said.flat], ball(said.reshape(-1, 1) * Fraction(1, 10**UNIT))
        self.kind, *self.ask = line["where"] if "where" in line else ("held", *line["held"])
        faces, self.width = len(model.faces), 2 * model.n + 1
        need(all(-1 <= f < 2 * faces for f in line["faces"]), "there is no such face")
        self.faces = [model.faces[f % faces] if f >= 0 else None for f in line["faces"]]
        self.jumps = [ball(model.impact(face)) for face in self.faces]
        self.count = len(self.faces) - 1
        self.size = self.count * self.width
        need(said.shape == (self.count, self.width), "the states do not fit to the faces")
        self.find_ends(line)
        self.find_phases([f >= faces for f in line["faces"]])
        self.find_question()
        self.find_edges()

    def find_ends(self, line):
        """A matrix for each end, that takes the state at a mirror point to itself, as the way back
        does; or the last one to the first. Both ends together are a symmetry of the orbit."""
        m, one, (begin, *_, end) = self.m, eye(self.n), self.faces
        flight = [e in ("rest", "centre", "twin") for e in self.ends]
        need(flight == [not begin, not end] and ("twin" in self.ends) == ("twin" in line), "an end")
        self.general, self.sigma = "general" in self.ends, 1 if begin == end else -1
        spaces = {"rest": one, "impact": one, "centre": -one, "general": self.sigma * one}
        spaces["twin"] = m.twin(line["twin"]) if "twin" in line else None
        first, last = (spaces[e] for e in self.ends)
        if self.general:
            need((self.ends[0], begin[0]) == (self.ends[1], end[0]), "it is open")
            turn, around = m.turned(last, last, end), last
        else:
            need(not any(f and m.soft[f[0]] for f in (begin, end)), "no mirror")
            turn, around = m.turned(last, -last, end), first @ last
        self.backs = (m.one, 0 * m.one) if self.general else (m.turned(first, -first, begin), turn)
        self.turn, self.symmetric = ball(turn), bool((around == -one).all())
        self.copies = (1 if self.general else 2) * (1 if (around == one).all() else 2)
        signs = (1, -1) if self.symmetric or "centre" in self.ends else (1,)
        images = lambda faces: {(c, s * i) for c, s in faces for i in signs}
        self.watched = sorted(images(m.faces))
        need(images({*self.faces} - {None}) <= {*m.faces}, "an image of an impact has no face")

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
        """A row that vanishes, of all unknowns and of the state before the last event; motions
        beside the orbit, odd at ends that are 1; what is met at events; and what has no speed."""
        (k, *more), N, T = (*self.ask, 0), self.size, self.width
        need(len(self.ask) == ASKED.get(self.kind, 0), "what is held or vanishes has other numbers")
        need(k >= 0, "there is no such event")
        self.beside = {**BESIDE, "break": [tuple(self.ask)]}.get(self.kind, [])
        for odd, end in [pair for one in self.beside for pair in zip(one, self.ends, strict=True)]:
            may = end != "twin" and self.general == (self.kind == "double")
            need(odd == 0 or odd == 1 and may, "no motion is odd there")
        met, last = [*enumerate(self.faces)], N * (1 + len(self.beside))
        row = np.array([0] * (last + T), object)
        if self.kind == "held":
            need(0 <= more[0] < T and self.said[k * T + more[0]] % HELD == 0, "another is held")
            row[k * T + more[0]], row[-1] = 1, -Fraction(self.said[k * T + more[0]], 10**UNIT)
        elif self.kind == "time":
            row[k * T + T - 1] = 1
            met += [(k, self.faces[k + 1]), (k + 1, self.faces[k])]
        elif self.kind == "period":
            row[N + T - 1:-T:T] = 1
        elif self.kind in ("speed", "gap"):
            at, slow = k * T if k < self.count else last, self.kind == "speed"
            met.append((k, self.faces[k] if slow else tuple(more[:2])))
            *row[at:at + T - 1], row[-1] = (self.m.speed if slow else self.m.exact)[met[-1][1]]
        self.linear = [ball(row)] * bool(row.any())
        self.find_met([one for one in met if one[1]], met[-1] if self.kind == "speed" else None)

    def find_met(self, met, slow):
        """Faces at events, and whether they have exactly no speed there: the slow one, what is at
        rest, and what the impact of a mirror point changes nothing of. Where a chain closes, its
        last event is the first one, or its image."""
        self.met = {}
        for k, face in met:
            need(k <= self.count and face in self.watched, "no such face")
            own, same = self.faces[k], [(k, face)]
            still = (k, face) == slow or self.rests(k)
            if k in (0, self.count) and self.general:
                same.append((self.count - k, (face[0], face[1] * self.sigma)))
            elif k in (0, self.count) and own:
                still = still or self.m.speed[face] @ self.m.kick[own] == 0
            for one in same:
                self.met[one] = self.met.get(one) or still

    def find_edges(self):
        """Rows that vanish at the first state, and at the last one or what it leaves open; of odd
        motions, which a mirror point turns into their opposite, one more, which forbids a shift in
        time. One that follows from the others, as these keep the energy, is left out."""
        self.left_out, self.edges, (begins, ends) = None, [], self.path(self.centre)[0]
        slope = self.gradient(begins[0], ends[-1])
        flows = self.phases[0].A @ begins[0], self.phases[-1].A @ ends[-1]
        for odd in [(0, 0), *self.beside]:
            edges = [reduced((self.m.one - (-1)**o * R)[:-1]) for o, R in zip(odd, self.backs)]
            if odd == 2 * (not self.general,) and self.kind != "turn":
                first = np.argmax(edges[1] != 0, 1)
                self.left_out = max(first, key=lambda i: slope[i].most)
                edges[1] = edges[1][first != self.left_out]
            for i, face in enumerate((self.faces[0], self.faces[-1])):
                more = self.m.rows[face] if face else flows[i].middle[:, 0]
                more = [more] * (bool(face) != bool(odd[i]) and not (i and self.general))
                edges[i] = stack([edges[i], *more])
            self.edges.append(((-1)**odd[1], *edges))

    def gradient(self, begin, end):
        """Twice that of the energy; if a number of it is not zero, the row left out follows."""
        other, G = (begin, self.phases[0].G) if self.general else (end, self.phases[-1].G)
        return (G @ (other + self.turn @ end))[:, 0]

    def follow(self, u):
        """The states of motions, of which the row that is left out follows from the others."""
        begins, ends = self.path(u)[0]
        if self.left_out is not None:
            1 / self.gradient(begins[0], ends[-1])[self.left_out]
        return begins, ends

    def path(self, U):
        """Of the orbit and each motion: states behind events, and before the next ones."""
        found, n, T, one = [], 2 * self.n, self.width, np.eye(1, U.shape[1])
        for i in range(len(U) // self.size):
            begins, ends = [], []
            for k, phase in enumerate(self.phases):
                at = (i * self.count + k) * T
                begins.append(stack([U[at:at + n], one * (i == 0)]))
                W = begins[k] + times(U[at + n], phase.A @ found[0][0][k]) if i else begins[k]
                ends.append(phase.fly(W, U[k * T + n]))
            found.append((begins, ends))
        return found

    def equations(self, U):
        """Numbers that have to vanish; where U has derivatives behind its numbers, with theirs."""
        layers, found = self.path(U), []
        lasts = [ends[-1] for begins, ends in layers]
        if self.kind == "turn":
            angle, (a, b) = mp.pi * self.ask[0] / self.ask[1], lasts[1:]
            c, s = (Ball(int(mp.ldexp(x, P)), TAIL) for x in (mp.cos(angle), mp.sin(angle)))
            lasts[1:] = a * c + b * s, b * c - a * s
        for (begins, ends), end, (sign, first, last) in zip(layers, lasts, self.edges, strict=True):
            for k in range(1, self.count):
                found.append((begins[k] - self.jumps[k] @ ends[k - 1])[:-1])
                found.append(self.m.rows[self.faces[k]] @ begins[k])
            left = begins[0] - self.turn @ end * sign if self.general else end
            found += [first @ begins[0], last @ left]
        if self.kind == "energy":
            slope = self.phases[0].G @ layers[0][0][0]
            found.append(sum(times(a, b[None]) for a, b in zip(slope, layers[1][0][0])))
        whole = stack([U, layers[0][1][-1]])
        return stack(found + [row @ whole for row in self.linear])

    def slopes(self, u):
        return self.equations(stack([u.T, eye(len(u))]).T)[:, 1:]

    def contracts(self, C, box):
        """By 0.9; not known where one of its flights may be too long for the series."""
        try:
            return size(C @ self.slopes(box) - eye(len(C))) < 0.9
        except REFUSED:
            return False

    def zero(self, u):
        """u - C F(u) contracts the box of radius `outer` by 0.9, so that it has one zero, which is
        within 10 steps of each u in it."""
        for k in range(STEPS):
            C = inverse(self.slopes(u)) if k % 3 == 0 else C
            step = C @ self.equations(u)
            u = (u - step).middle
            if size(step) < CLOSE:
                break
        radius = 11 * size(C @ self.equations(u))
        outer = next((r for r in RADII if self.contracts(C, u + Ball(0, r))), 0)
        need(radius < outer, "no zero is proved")
        u = u[:self.size] + Ball(0, radius)
        self.follow(u)
        return u

    def prove(self):
        """The orbit, whose numbers are those of the line."""
        N, u = self.size, self.centre
        if self.beside:  # near the last singular vector of rows that are linear in the motions
            rows = self.slopes(stack([u] * (1 + len(self.beside))))[N - 1:, N:].near
            a = ball(np.linalg.svd(rows)[2][-1])
            none = [[0]] * N, [[0]] * 2 * self.n
            self.linear.append(stack([none[0], a[:, None], none[1], [[-1]]])[:, 0])
            u = stack([u, a[:, None]])
        u = self.zero(u)
        need(((u - self.centre).most < 0.5 * 10.0**-UNIT).all(), "other states or times")
        return u

    def tube(self, a, b):
        """One motion on each plane across the line from an orbit to another, and a little beyond,
        within a box around it: an arc through both."""
        way = (b - a).middle
        spot, none = (a + way * HALF).middle, [[0]] * 2 * self.n
        self.linear = [stack([way, none, -(way.T @ spot)])[:, 0]]
        C, at, r = inverse(self.slopes(spot)), self.equations(spot), 0 * way.most
        for attempt in range(TRIES):
            J = self.slopes(spot + way * SPAN + Ball(0 * way.mid, r))
            least, Z = (C[:, :-1] @ (at + J @ way * SPAN)[:-1]).most, (C @ J - eye(len(C))).most
            inner = (least + Z @ r) * UP
            if (inner < r).all():
                break
            need(attempt < TRIES - 1, "an arc is not proved to be one")
            r = inner * 1.25 + (inner.max() + way.most.max() * THIN) * THIN
        for off in (a - spot + way * HALF, b - spot - way * HALF):
            share = (way.T @ off)[0, 0] / (way.T @ way)[0, 0]
            need(share.most < MORE and ((off - way * share).most < r).all(), "tubes do not meet")
        rest = Ball(0 * way.mid, inner)
        split = stack([spot.T, way.T, rest.T]).T, stack([[[1]], SPAN, [[1]]])[:, 0]
        self.stands(spot + way * SPAN + rest, SHALLOW, split)

    def join(self, a, b, depth=PARTS):
        """The orbits a and b, by one arc of motions: of tubes to orbits in between."""
        try:
            return self.tube(a, b)
        except REFUSED:
            if not depth:
                raise
        half = self.zero((a + (b - a) * HALF).middle)
        self.join(a, half, depth - 1)
        self.join(half, b, depth - 1)

    def stands(self, u, depth=DEEPEST, split=None):
        """Flights last, events approach, and gaps are open. What is known of
        the numbers of an arc together is in `split`: columns of them, and a factor for each."""
        (begins, ends), (columns, factors) = self.follow(u), split or (u, ball([1]))
        for k, phase in enumerate(self.phases):
            if (self.kind, *self.ask[:1]) == ("time", k):
                continue
            t = u[(k + 1) * self.width - 1]
            need(t[0] > 0, f"flight {k + 1} does not last")
            W = stack([columns[k * self.width:(k + 1) * self.width - 1], np.eye(1, len(factors))])
            signs = [-1 if face in self.closed[k] else 1 for face in self.watched]
            met, lies = [], []
            for event, w, out in ((k, begins[k], -1), (k + 1, ends[k], 1)):
                met.append(np.array([(event, face) in self.met for face in self.watched]))
                lies.append(met[-1] | self.rests(event))
                for face, sign in zip(self.watched, signs):
                    need(self.met.get((event, face), True)
                         or (self.m.speeds[face] @ w)[0] * (out * sign) > 0,
                         "an impact has no speed")
            rows = stack([self.m.rows[face] * sign for face, sign in zip(self.watched, signs)])
            phase.flies(rows, W, factors, t, depth, *met, lies[0] & lies[1])

    def rests(self, event):
        """At a mirror point, from which the flight goes back as it came."""
        return event in (0, self.count) and self.ends[event > 0] == "rest"
