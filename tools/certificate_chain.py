"""The chain of a certificate for check_certificate.py: its equations, the proof that they have one
zero, and that the zero is a motion."""
from fractions import Fraction

import numpy as np
from mpmath import mp

from certificate_balls import (ONE, P, TAIL, Ball, balls, each, eye, inverse, middle, need, reduced,
                               size, times)

STEPS, DEEPEST = 6, 60  # towards a zero; halvings of a flight
RADII = [ONE >> k for k in (10, 20, 30, 40)]  # within which a zero may be the only one
UNIT, HELD = 18, 1000  # decimals of states and times; the held one is a multiple of 1000 units
ASKED = {"held": 2, "speed": 1, "gap": 3, "time": 1, "break": 2, "turn": 2}  # numbers behind it
BESIDE = {"energy": [(0, 0)], "period": [(0, 0)], "double": [(0, 1)], "turn": [(0, 0), (1, 1)]}


class System:
    """Unknown are (x, v, tau) behind each event, or from a mirror point on; then, in the same
    order, those of motions beside the orbit, with shifts in time of the next event."""

    def __init__(self, model, line):
        self.m, self.n, self.ends = model, model.n, (line["start"], line["end"])
        said = np.column_stack([np.array(line[key], object) for key in ("x", "v", "tau")])
        self.said, self.centre = [*said.flat], balls(said.reshape(-1, 1) * Fraction(1, 10**UNIT))
        self.kind, *self.ask = line["where"] if "where" in line else ("held", *line["held"])
        faces, self.width = len(model.faces), 2 * model.n + 1
        need(all(-1 <= f < 2 * faces for f in line["faces"]), "there is no such face")
        self.faces = [model.faces[f % faces] if f >= 0 else None for f in line["faces"]]
        self.jumps = [balls(model.impact(face)) for face in self.faces]
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
        self.turn, self.symmetric = balls(turn), bool((around == -one).all())
        self.copies = (1 if self.general else 2) * (1 if (around == one).all() else 2)
        signs = (1, -1) if self.symmetric or "centre" in self.ends else (1,)
        images = lambda faces: {(c, s * i) for c, s in faces for i in signs}
        self.watched = images(m.faces)
        need(images({*self.faces} - {None}) <= {*m.faces}, "an image of an impact has no face")

    def place(self, event, face):
        """An event and a face there: where a chain closes, its last event is the first one, or its
        image."""
        closes = self.general and event == self.count
        return (0, (face[0], face[1] * self.sigma)) if closes else (event, face)

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
        (k, *more), N, T, self.slow = (*self.ask, 0), self.size, self.width, None
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
            row[k * T + more[0]], row[-1] = 1, -self.centre[k * T + more[0], 0]
        elif self.kind == "time":
            row[k * T + T - 1] = 1
            met += [(k, self.faces[k + 1]), (k + 1, self.faces[k])]
        elif self.kind == "period":
            row[N + T - 1:-T:T] = 1
        elif self.kind in ("speed", "gap"):
            slow, at = self.kind == "speed", k * T if k < self.count else last
            met.append((k, self.faces[k] if slow else tuple(more[:2])))
            self.slow = self.place(*met[-1]) if slow else None
            *row[at:at + T - 1], row[-1] = (self.m.speeds if slow else self.m.rows)[met[-1][1]]
        self.linear, self.met = [row] * bool(row.any()), {self.place(*one) for one in met if one[1]}
        need(all(k <= self.count and face in self.watched for k, face in self.met), "no such face")

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
                self.left_out = max(first, key=lambda i: abs(slope[i] + Ball(0)).mid)
                edges[1] = edges[1][first != self.left_out]
            for i, face in enumerate((self.faces[0], self.faces[-1])):
                more = self.m.rows[face] if face else middle(flows[i])[:, 0]
                more = [more] * (bool(face) != bool(odd[i]) and not (i and self.general))
                edges[i] = np.vstack([balls(edges[i]), *more])
            self.edges.append(((-1)**odd[1], *edges))

    def gradient(self, begin, end):
        """Twice that of the energy; if a number of it is not zero, the row left out follows."""
        other, G = (begin, self.phases[0].G) if self.general else (end, self.phases[-1].G)
        return (G @ (other + self.turn @ end))[:, 0]

    def path(self, U):
        """Of the orbit and each motion: states behind events, and before the next ones."""
        found, n, T = [], 2 * self.n, self.width
        for i in range(len(U) // self.size):
            known, begins, ends = eye(U.shape[1])[:1] * int(i == 0), [], []
            for k, phase in enumerate(self.phases):
                at = (i * self.count + k) * T
                begins.append(np.vstack([U[at:at + n], known]))
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
                found += [*(begins[k] - self.jumps[k] @ ends[k - 1])[:-1]]
                found.append(self.m.rows[self.faces[k]] @ begins[k])
            left = begins[0] - sign * (self.turn @ end) if self.general else end
            found += [*first @ begins[0], *last @ left]
        if self.kind == "energy":
            slope = self.phases[0].G @ layers[0][0][0]
            found.append(sum(times(a, b[None]) for a, b in zip(slope, layers[1][0][0])))
        whole = np.vstack([U, layers[0][1][-1]])
        return np.vstack(found + [row @ whole for row in self.linear])

    def slopes(self, u):
        return self.equations(np.hstack([u, eye(len(u))]))[:, 1:]

    def contracts(self, C, box):
        """By 0.9; not known where one of its flights may be too long for the series."""
        try:
            return size(C @ self.slopes(box) - eye(len(C))) * 10 < 9 * ONE
        except ValueError:
            return False

    def prove(self):
        """u - C F(u) contracts the box of radius `outer` by 0.9, so that it has one zero, which is
        within 10 steps of each u in it."""
        N, u = self.size, self.centre
        if self.beside:  # near the last singular vector of rows that are linear in the motions
            rows = self.slopes(np.vstack([u] * (1 + len(self.beside))))[N - 1:, N:]
            rows = each(lambda x: (x + Ball(0)).mid / ONE)(rows).astype(float)
            a = middle(balls(each(Fraction)(np.linalg.svd(rows)[2][-1])))
            self.linear.append(np.array([*[0] * N, *a, *[0] * 2 * self.n, -1], object))
            u = np.vstack([u, a[:, None]])
        centre, C = u, inverse(self.slopes(u))
        for _ in range(STEPS):
            u = middle(u - C @ self.equations(u))
        centre[N:] = u[N:]  # motions are in no certificate
        ball = 11 * size(C @ self.equations(u))
        outer = next((r for r in RADII if self.contracts(C, centre + Ball(0, r))), 0)
        need(size(u - centre) + ball < outer, "no zero is proved")
        u = u[:N] + Ball(0, ball)
        need([x.rounded(UNIT) for x in u[:, 0]] == self.said, "other states or times")
        return u

    def stands(self, u, depth=DEEPEST, split=None):
        """Rows left out follow, flights last, events approach, and gaps are open. What is known of
        the numbers of an arc together is in `split`: columns of them, and a factor for each."""
        (begins, ends), (columns, factors) = self.path(u)[0], split or (u, [1])
        if self.left_out is not None:
            1 / self.gradient(begins[0], ends[-1])[self.left_out]
        for k, phase in enumerate(self.phases):
            if (self.kind, *self.ask[:1]) == ("time", k):
                continue
            t = u[(k + 1) * self.width - 1]
            need(t[0] > 0, f"flight {k + 1} does not last")
            W = np.vstack([columns[k * self.width:(k + 1) * self.width - 1], eye(len(factors))[:1]])
            for face in self.watched:
                sign, met, lies = -1 if face in self.closed[k] else 1, [], []
                for event, w, out in ((k, begins[k], -1), (k + 1, ends[k], 1)):
                    place = self.place(event, face)
                    met.append(place in self.met)
                    lies.append(met[-1] or self.rests(event))
                    need(not met[-1] or self.still(*place)
                         or (self.m.speeds[face] @ w)[0] * (out * sign) > 0,
                         "an impact has no speed")
                row = self.m.rows[face] * sign
                phase.flies(row, W, factors, t, depth, *met, all(lies))

    def rests(self, event):
        """At a mirror point, from which the flight goes back as it came."""
        return event in (0, self.count) and self.ends[event > 0] == "rest"

    def still(self, event, face):
        """Whether a face that is met has exactly no speed: at the slow event, at rest, or where the
        impact of a mirror point changes nothing that its contact sees."""
        own, mirror = self.faces[event], not self.general and event in (0, self.count)
        return (event, face) == self.slow or self.rests(event) or (
            mirror and own and self.m.speed[face] @ self.m.kick[own] == 0)
