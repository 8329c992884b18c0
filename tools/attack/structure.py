"""A structure read from the model section of a study: masses, springs, contacts, and the linear motion between events.

Coordinates: u = L' x with M = L L', over the seen part of the structure only, so that u'' = -A u - (closed springs) and the
energy is (u'.u' + u.A u) / 2 + springs. Lengths are over the clearance of the first contact, times over the reciprocal of a
reference frequency: all numbers are of the order of one, whatever the units of the study.
"""
import json

import numpy as np

import arithmetic as ar

EQUAL = 1e-11  # of an eigenvalue: one that is farther than this from the next is an eigenspace of its own, however stiff others are,
ROUNDED = 2.2e-16  # and one that is farther than roundings of its own and of every entry of the matrices make it
OWN = 512
ZERO = 1e-13  # of the largest eigenvalue: below it a motion is free
UNSEEN = 1e-10  # of a normal: the share in an eigenspace that counts as none


def read_study(path):
    """The study as a dictionary: JSON, which is YAML; other YAML needs the module yaml."""
    with open(path, encoding="utf-8") as text:
        content = text.read()
    try:
        return json.loads(content)
    except ValueError:
        import yaml

        return yaml.safe_load(content)


class Face:
    """One side of a contact. `limit`: gap at which it is met, over d; `spring` 0: a rigid stop."""

    def __init__(self, contact, side, limit, spring):
        self.contact, self.side, self.limit, self.spring = contact, side, limit, spring


class Structure:
    """Matrices, faces, and a table of the linear phases, in long doubles or in mpmath numbers (`exact`)."""

    def __init__(self, model, exact=False):
        self.exact, self.model = exact, model
        mass, stiffness = ar.array(model["mass"], exact), ar.array(model["stiffness"], exact)
        self.mass, self.stiffness = mass, stiffness
        self.low = ar.cholesky(mass)
        half = ar.solve_lower(self.low, stiffness)
        a = ar.solve_lower(self.low, half.T.copy())
        a = (a + a.T) / 2
        contacts = model["contacts"]
        first = contacts[0]
        self.power = first["law"] == "power"
        self.d = ar.number(first.get("clearance", first.get("length", 1)), exact)
        normals = [ar.solve_lower(self.low, ar.array(c["normal"], exact)) for c in contacts]
        self._keep_seen(a, normals)
        self.omega_ref = float(np.sqrt(max(ar.double(self.lam).max(), 1e-300)))
        self.A = self.A / ar.number(self.omega_ref, exact) ** 2
        self.phases = {}
        self._list_contacts(contacts)

    def _keep_seen(self, a, normals):
        """The subspace of u that contacts see: of each eigenspace as many directions as normals have a share in."""
        lam, vectors = ar.eigen(a)
        order = np.argsort(ar.double(lam), kind="stable")
        lam, vectors = lam[order], vectors[:, order]
        top, groups = float(max(abs(ar.double(lam)))), []
        for i in range(len(lam)):
            if groups and self._equal(lam, vectors, groups[-1][0], i, ZERO * top):
                groups[-1].append(i)
            else:
                groups.append([i])
        kept = []
        held = [group for group in groups if float(lam[group[-1]]) > ZERO * top]
        # By how much squares of frequencies differ that rounding alone tells apart, relative.
        self.one = max((float((lam[group[-1]] - lam[group[0]]) / lam[group[-1]]) for group in held), default=0.0)
        for group in groups:
            space = vectors[:, group]
            basis = []
            for c in normals:
                share = space @ (space.T @ c)
                for _ in range(2):
                    for b in basis:
                        share = share - b * (b @ share)
                size = float(ar.sqrt(np.array([share @ share]))[0])
                if size > UNSEEN * float(ar.sqrt(np.array([c @ c]))[0]):
                    basis.append(share / ar.number(size, self.exact))
                    norm = ar.sqrt(np.array([basis[-1] @ basis[-1]]))[0]
                    basis[-1] = basis[-1] / norm
            kept += basis
        self.seen = np.array(kept).T.copy()
        self.n = self.seen.shape[1]
        self.A = self.seen.T @ a @ self.seen
        self.c = [self.seen.T @ c for c in normals]
        self.all_lam = lam
        self.lam = ar.eigen(self.A)[0]

    def _equal(self, lam, vectors, first, i, zero):
        """Whether rounding alone tells two eigenvalues apart, or they are of free motions."""
        gap, size = float(lam[i] - lam[first]), float(lam[i])
        if size <= zero or gap <= OWN * ROUNDED * size:
            return True
        return gap <= EQUAL * size and gap <= self._rounding(float(lam[first]), vectors[:, first]) + self._rounding(size, vectors[:, i])

    def _rounding(self, lam, vector):
        """What a rounding of every entry of the matrices makes of an eigenvalue."""
        shape = np.abs(np.linalg.solve(ar.double(self.low).T, ar.double(vector)))
        return ROUNDED * float(shape @ (np.abs(ar.double(self.stiffness)) + lam * np.abs(ar.double(self.mass))) @ shape)

    def _list_contacts(self, contacts):
        exact, omega2 = self.exact, ar.number(self.omega_ref, self.exact) ** 2
        self.faces, self.powers = [], []
        for i, contact in enumerate(contacts):
            if contact["law"] == "power":
                m = contact["exponent"]
                if "length" in contact:
                    k = ar.number(contact["reference"], exact) * (self.d / ar.number(contact["length"], exact)) ** (m - 1)
                else:
                    k = ar.number(contact["stiffness"], exact) * self.d ** (m - 1)
                self.powers.append((i, m, k / omega2))
                continue
            limit = ar.number(contact["clearance"], exact) / self.d
            spring = ar.number(contact["stiffness"], exact) / omega2 if contact["law"] == "bilinear" else 0
            sides = {"both": (1, -1), "upper": (1,), "lower": (-1,)}[contact.get("sides", "both")]
            self.faces += [Face(i, side, limit, spring) for side in sides]
        self.symmetric = self.power or all(c.get("sides", "both") == "both" for c in contacts)

    # ---- phases

    def phase(self, closed):
        """(vectors, squared frequencies, equilibrium) with the springs of these faces closed."""
        key = frozenset(closed)
        if key not in self.phases:
            a, force = self.A.copy(), ar.zeros(self.n, self.exact)
            for f in sorted(key):
                face = self.faces[f]
                c = self.c[face.contact]
                a = a + face.spring * np.outer(c, c)
                force = force + face.spring * face.side * face.limit * c
            lam, vectors = ar.eigen(a)
            small = ZERO * float(max(ar.double(self.lam).max() / self.omega_ref**2, 0))
            zero = ar.double(lam) < small
            lam[zero] = lam[zero] * 0
            share = vectors.T @ force
            share[zero] = share[zero] * 0
            divisor = lam.copy()
            divisor[zero] = divisor[zero] + 1
            self.phases[key] = vectors, lam, vectors @ (share / divisor)
        return self.phases[key]

    def rotation(self, closed, t):
        """(vectors, C, S, -lam S): each mode's rotation over the times t [P]."""
        vectors, lam, _ = self.phase(closed)
        w = ar.sqrt(lam)
        angle = t[:, None] * w
        still = ar.double(lam) == 0
        divisor = w.copy()
        divisor[still] = divisor[still] + 1
        c, s = ar.cos(angle), ar.sin(angle) / divisor
        s[:, still] = t[:, None]
        return vectors, c, s, -s * lam

    def fly(self, closed, u, v, t):
        """States after the times t [P] with these faces closed all the time; u, v [P, n]."""
        rest = self.phase(closed)[2]
        vectors, c, s, minus = self.rotation(closed, t)
        y, yd = (u - rest) @ vectors, v @ vectors
        return (y * c + yd * s) @ vectors.T + rest, (y * minus + yd * c) @ vectors.T

    def fly_columns(self, closed, X, t):
        """Small deviations X [P, 2n, columns] after the times t."""
        n = self.n
        vectors, c, s, minus = self.rotation(closed, t)
        y, yd = vectors.T @ X[:, :n], vectors.T @ X[:, n:]
        c, s, minus = c[:, :, None], s[:, :, None], minus[:, :, None]
        return np.concatenate([vectors @ (y * c + yd * s), vectors @ (y * minus + yd * c)], axis=1)

    def acceleration(self, closed, u):
        out = -(u @ self.A)
        for f in sorted(closed):
            face = self.faces[f]
            c = self.c[face.contact]
            out = out - face.spring * (u @ c - face.side * face.limit)[:, None] * c
        return out

    def energy(self, closed, u, v):
        """In units of the judge; `scaled_energy` of the program is this times omega_ref^2."""
        sum_ = (ar.dot(v, v) + ar.dot(u, u @ self.A)) / 2
        for f in sorted(closed):
            face = self.faces[f]
            s = u @ self.c[face.contact] - face.side * face.limit
            sum_ = sum_ + face.spring * s * s / 2
        return sum_

    # ---- what the program stores

    def from_stored(self, states):
        """u, v [P, n] of stored states [P, 2 n_dof] and the largest part of them in what no contact sees."""
        half = states.shape[1] // 2
        x, v = ar.array(states[:, :half], self.exact), ar.array(states[:, half:], self.exact)
        x, v = x @ self.low, v @ self.low / ar.number(self.omega_ref, self.exact)
        u, w = x @ self.seen, v @ self.seen
        lost = max(np.abs(ar.double(x - u @ self.seen.T)).max(initial=0), np.abs(ar.double(v - w @ self.seen.T)).max(initial=0))
        return u, w, lost

    def raw_energy(self, states, flights_closed):
        """Scaled energies of stored states straight from mass, stiffness and springs."""
        half = states.shape[1] // 2
        x, v = ar.array(states[:, :half], self.exact), ar.array(states[:, half:], self.exact)
        sum_ = (ar.dot(v, v @ self.mass) + ar.dot(x, x @ self.stiffness)) / 2
        contacts = self.model["contacts"]
        for f in sorted(flights_closed):
            face = self.faces[f]
            s = x @ ar.array(contacts[face.contact]["normal"], self.exact) - face.side * face.limit
            sum_ = sum_ + ar.number(contacts[face.contact]["stiffness"], self.exact) * s * s / 2
        for i, m, k in self.powers:
            s = x @ ar.array(contacts[i]["normal"], self.exact)
            sum_ = sum_ + k * ar.number(self.omega_ref, self.exact) ** 2 * s ** (m + 1) / (m + 1)
        return sum_


def read_word(structure, word):
    """Events of a word, [(face, kind)] with kind `hit`, `close` or `open`, and the faces closed right after the first."""
    letters, i = [], 0
    parts = word.split(".") if "." in word else None
    if parts is None:
        while i < len(word):
            minus = word[i] == "-"
            i += minus
            letters.append((minus, int(word[i], 36)))
            i += 1
    else:
        letters = [(p.startswith("-"), int(p.lstrip("-"))) for p in parts if p]
    events = []
    spelled = [f for minus, f in letters if minus]
    for k, (minus, f) in enumerate(letters):
        if not structure.faces[f].spring:
            events.append((f, "hit"))
        elif minus:
            events.append((f, "open"))
        else:
            events.append((f, "close"))
            if not spelled or not _opens_later(letters, k):
                events.append((f, "open"))
    closed = set()
    for _ in range(2):
        for f, kind in events:
            closed = closed | {f} if kind == "close" else closed - {f}
    f, kind = events[0]
    closed = closed | {f} if kind == "close" else closed - {f}
    return events, frozenset(closed)


def _opens_later(letters, k):
    """Whether the opening of the closing k is written: before its face closes again there is a letter with a minus."""
    f, size = letters[k][1], len(letters)
    for j in range(1, size):
        minus, g = letters[(k + j) % size]
        if g == f:
            return minus
    return False
