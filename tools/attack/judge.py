"""The judge of one atlas: everything it says of its orbits is computed again from the study, M, K and the contacts.

`judge(...)` gives a Verdict: findings (what is wrong), and counts of what was confirmed and of what cannot be decided.
"""
import collections
import json
import math
import sqlite3
import subprocess

import mpmath
import numpy as np

import arithmetic as ar
import gaps
import orbits
import smooth
import smooth_fine
from structure import Structure, read_word

RESIDUAL = 1e-10  # of a stored orbit in its equations, relative to its size; times the square root of the stiffest phase
ROUNDED = 16 * 2.2e-16  # of the stored numbers: what the equations make of it is allowed, too
RETURN = 1e-12  # of an orbit under a power law to its start, relative to its size, over the growth of its neighbours
AMPLIFIES = 1e6  # more than this between two events of one chain: each flight is given a state of its own
DISTANCE = 1e-8  # from a stored orbit to the nearest solution, relative
TOUCH = 1e-8  # by which reach may pass 1, s/d
NUMBER = 1e-8  # relative: energies, frequencies, margins
SIMILAR = 1e-7  # relative: symmetries of an orbit
SYMMETRIC = 1e-11  # the same, to take multipliers from half of it
FACTOR = 200.0  # rounding of the program over what one rounding of the stored numbers does to a multiplier
BORDER = 1e-14  # of |rho| from 2: rounding of the stored doubles moves the orbit along its branch across it
FINELY_REAL = 1e-14  # of rho in many digits, of orbits 1e-30 away, whose double roots are off by the square root
PROMISED = 1e-3  # relative: the digits that a multiplier has to have to be given
LOST = 1e-3  # of 1 + |trace|: error from which on a trace is not stored
UNPLACED = 1e-7  # relative: to what the place of a junction is said to be known whose label is not decided
REPEATED = 1e-10  # relative: an orbit as near as this to a shorter one gone through again is looked at in many digits
CONVERGED = 1e-35  # relative residual in many digits
MP_POINTS = 200  # per structure that are worth 50 digits: half a second each with five modes
TOO_MANY = f"more than {MP_POINTS} points ask for many digits"
NO_DIGITS = "many digits do not converge"
NOT_HELD = "the stored numbers hold less than is promised"
YES, NO, UNDECIDED = 1, 0, 2


class Verdict:
    def __init__(self):
        self.findings, self.counts, self.open = [], collections.Counter(), []

    def leave(self, kind, where, text, why):
        """Neither confirmed nor false: counted, and kept with the reason."""
        self.counts[f"{kind} not confirmed"] += 1
        self.open.append({"kind": kind, "where": where, "text": text, "why": why})

    def find(self, kind, where, text):
        self.findings.append({"kind": kind, "where": where, "text": text})


def floats(blob):
    return np.frombuffer(blob, dtype="<f8")


class Atlas:
    def __init__(self, path):
        db = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
        db.row_factory = sqlite3.Row
        self.branches = db.execute("SELECT * FROM branch ORDER BY id").fetchall()
        self.junctions = db.execute("SELECT * FROM junction ORDER BY id").fetchall()
        self.meta = dict(db.execute("SELECT key, value FROM meta").fetchall())
        self.points = collections.defaultdict(list)
        for row in db.execute("SELECT * FROM point ORDER BY branch, point"):
            self.points[row["branch"]].append(row)
        self.on_branch = collections.defaultdict(list)
        for row in db.execute("SELECT * FROM branch_junction ORDER BY branch, position"):
            self.on_branch[row["branch"]].append(row)
        db.close()


def close(a, b, relative, absolute=0.0):
    return abs(a - b) <= relative * max(abs(a), abs(b)) + absolute


class Judge:
    def __init__(self, model, atlas, program=None, path=None, budget=400, rng=None, multiplier_calls=8):
        self.model, self.atlas, self.program, self.path = model, atlas, program, path
        self.s = Structure(model)
        self._exact = None
        self.verdict, self.rng = Verdict(), rng or np.random.default_rng(1)
        self.chosen, self._reach_of = self._choose(budget), (None, None)
        self.calls, self.fine_left = multiplier_calls, MP_POINTS
        self._flown = {}  # under a power law, by branch
        self._digits, self._fine_rho = {}, {}  # by branch and point, so that each is asked for once

    def exact(self):
        if self._exact is None:
            self._exact = Structure(self.model, exact=True)
        return self._exact

    def run(self):
        v = self.verdict
        if self.s.power:
            self._fly_ahead()
        for branch in self.atlas.branches:
            rows = self.atlas.points[branch["id"]]
            if len(rows) != branch["points"]:
                v.find("rows", f"branch {branch['id']}", f"{branch['points']} points said, {len(rows)} there")
            if not rows:
                continue
            rows = self._sample(branch["id"], rows)
            with np.errstate(all="ignore"):
                try:
                    if self.s.power:
                        self._power(branch, rows)
                    elif branch["word"]:
                        self._branch(branch, rows)
                    else:
                        self._linear(branch, rows)
                except (ArithmeticError, np.linalg.LinAlgError) as error:
                    v.counts["not replayed"] += len(rows)
                    v.counts[str(error)] += 1
        with np.errstate(all="ignore"):
            self._junctions()
        return v

    def _choose(self, budget):
        """Points that are judged, (branch, point): both ends of every branch, and `budget` drawn by chance from the structure."""
        places = [(b, i) for b, rows in sorted(self.atlas.points.items()) for i in range(len(rows))]
        if len(places) > budget:
            places = [places[i] for i in self.rng.choice(len(places), budget, replace=False)]
        ends = {(b, i) for b, rows in self.atlas.points.items() for i in (0, len(rows) - 1)}
        return set(places) | ends

    def _sample(self, branch, rows):
        return [row for i, row in enumerate(rows) if (branch, i) in self.chosen]

    # ---- branches

    def _numbers(self, branch, rows):
        """What rows say of themselves."""
        v = self.verdict
        for row in rows:
            where = f"branch {branch['id']} {branch['label']} point {row['point']}"
            omega = 2 * math.pi / float(floats(row["flights"]).sum())
            if not close(row["frequency"], omega, 1e-11) or not close(row["period"], 2 * math.pi / row["frequency"], 1e-14):
                v.find("frequency", where, f"{row['frequency']!r} said, {omega!r} from flights")
            if row["trace"] is not None and row["trace_asinh"] is not None:
                if not close(math.asinh(row["trace"] / 2), row["trace_asinh"], 1e-12, 1e-300):
                    v.find("trace", where, "trace and trace_asinh differ")
            if row["rotation"] is not None and row["trace"] is not None:
                if not close(2 * math.cos(2 * math.pi * row["rotation"]), row["trace"], 1e-6, 1e-6):
                    v.find("rotation", where, f"rotation {row['rotation']!r} and trace {row['trace']!r} differ")

    def _linear(self, branch, rows):
        """Linear modes: motion without impacts; period from the frequencies, gaps from the amplitude."""
        self._numbers(branch, rows)
        s, v = self.s, self.verdict
        raw = s.raw_energy(np.stack([floats(r["state"]) for r in rows]), frozenset())
        lam = np.sqrt(np.maximum(ar.double(s.all_lam), 0))
        for row, E in zip(rows, ar.double(raw)):
            where = f"branch {branch['id']} {branch['label']} point {row['point']}"
            v.counts["linear"] += 1
            if not close(E, row["energy"], NUMBER, 1e-12):
                v.find("energy", where, f"{row['energy']!r} said, {E!r} from matrices")
            if np.abs(lam - row["frequency"]).min() > 1e-9 * row["frequency"]:
                v.find("frequency", where, "no frequency of the structure")
        states = np.stack([floats(r["state"]) for r in rows])
        half = states.shape[1] // 2
        for contact in self.model["contacts"]:
            b, scale = np.array(contact["normal"], dtype=float), float(s.d) / contact["clearance"]
            omega = rows[0]["frequency"]
            amplitude = np.hypot(states[:, :half] @ b, states[:, half:] @ b / omega) * scale
            for row, a in zip(rows, amplitude):
                if a > 1 + TOUCH:
                    v.find("penetration", f"branch {branch['id']} point {row['point']}", f"linear motion opens a gap to {a!r}")

    def chain_of(self, word, rows, structure=None):
        structure = structure or self.s
        events, closed = read_word(structure, word)
        states = np.stack([floats(r["state"]) for r in rows])
        tau = np.stack([floats(r["flights"]) for r in rows])
        if tau.shape[1] != len(events):
            raise ValueError(f"{tau.shape[1]} flights for {len(events)} events")
        u, v, lost = structure.from_stored(states)
        tau = ar.array(tau, structure.exact) * ar.number(structure.omega_ref, structure.exact)
        return orbits.Chain(structure, events, closed, u, v, tau), states, lost

    def _stiff(self):
        """How much a closing spring may multiply rounding: the fastest frequency of all phases met so far, over that of the structure."""
        return max(1.0, max(float(ar.double(lam).max()) for _, lam, _ in self.s.phases.values()) ** 0.5)

    def _branch(self, branch, rows):
        v, s = self.verdict, self.s
        name = f"branch {branch['id']} {branch['label']}"
        self._numbers(branch, rows)
        try:
            chain, states, lost = self.chain_of(branch["word"], rows)
        except (ValueError, IndexError) as error:
            v.find("word", name, str(error))
            return
        v.counts["orbits"] += len(rows)
        if not chain.sound:
            v.find("word", name, f"{branch['word']} does not open what it closes")
            return
        if lost > 1e-9:
            v.find("unseen", name, f"{lost:.1e} of the state is in modes that no contact sees")
        start, growth = chain.relative_residual() / self._stiff(), chain.growth()
        fine, moved = orbits.polish(self._held(chain, growth))
        left = fine.relative_residual()
        energies = ar.double(s.raw_energy(states, chain.first_closed))
        reach = gaps.Reach(fine)
        size = fine.size()[1]
        slow = np.max([np.min([ar.double(x) for x in c.speed], axis=0) for c in (fine, chain)], axis=0) / size
        ends = {0, branch["points"] - 1}
        for i, row in enumerate(rows):
            where = f"{name} point {row['point']}"
            if start[i] > RESIDUAL + ROUNDED * growth[i] or not math.isfinite(start[i]):
                v.find("residual", where, f"stored orbit misses its equations by {start[i]:.1e}")
            elif moved[i] > DISTANCE or left[i] > 1e-14:
                v.counts["loose"] += 1
                if moved[i] > max(1e-6, self._scatter(chain, i)):
                    v.find("distance", where, f"nearest solution is {moved[i]:.1e} away, residual left {left[i]:.1e}")
            if not close(energies[i], row["energy"], NUMBER):
                v.find("energy", where, f"{row['energy']!r} said, {energies[i]!r} from matrices")
            # As stored: where events fall together the polished times scatter about zero by the root of rounding.
            if ar.double(chain.tau[i]).min() < 0:
                v.find("sequence", where, f"flight time {ar.double(chain.tau[i]).min():.1e}")
            if slow[i] < -1e-8:
                v.find("sequence", where, f"a face is left where it should be met, speed {slow[i]:.1e}")
            worst = reach.worst()[i]
            if worst > 1 + (TOUCH if row["point"] not in ends else 1e-6):
                v.find("penetration", where, f"gap opens to {worst!r} ({reach.where[i]})")
            self._margins(row, reach, (fine, chain), i, where)
        self._repeats(branch, fine, rows)
        self._symmetries(branch, (fine, chain), rows, slow)
        if s.n > 1:
            self._multipliers(branch, rows, fine, chain)

    def _margins(self, row, reach, chains, i, where):
        """Beside an event where several singular values are small, the polished orbit differs from the stored one by the rounding of
        the equations over these: the margins are those of either, or between."""
        v = self.verdict
        if row["reach"] is not None:
            v.counts["reach"] += 1
            if not reach.says(i, row["reach"]) and not self._stored_reach(chains[1]).says(i, row["reach"]):
                v.find("reach", where, f"{row['reach']!r} said, {float(max(reach.stationary[i], reach.kink[i]))!r} found")
        least = [min(abs(float(x[i])) * self.s.omega_ref for x in chain.speed) for chain in chains]
        size = chains[0].size()[1][i]
        if row["approach"] is not None:
            v.counts["approach"] += 1
            nearest = min(max(row["approach"], min(least)), max(least))
            if not close(row["approach"], nearest, 1e-6, 1e-9 * size * self.s.omega_ref):
                v.find("approach", where, f"{row['approach']!r} said, {least[0]!r} found, {least[1]!r} as stored")

    def _scatter(self, chain, i):
        """How far away from each other solutions may be of which doubles hold the equations: rounding over the smallest singular
        value that is polished. A closing spring makes a velocity of the rounding of a displacement; frequencies that rounding alone
        tells apart may be taken for one."""
        s = chain.singular()[1][i]
        return max(ROUNDED * max(s[0], self._stiff()), self.s.one * s[0]) / s[s > orbits.CUT * s[0]].min()

    def _stored_reach(self, chain):
        if self._reach_of[0] is not chain:
            self._reach_of = chain, gaps.Reach(chain)
        return self._reach_of[1]

    @staticmethod
    def _held(chain, growth):
        """The chain, or, where its digits do not hold the orbits to their ends, the same orbits with more states."""
        return orbits.Apart.of(chain, growth >= 0) if growth.max() > AMPLIFIES else chain

    @staticmethod
    def _again(chain, part):
        """[P] how far orbits are from themselves `part` events later. Beside a doubling all of the difference may be at some events
        only, or in the times between."""
        su, sv = chain.size()
        period = ar.double(chain.tau).sum(axis=1)
        off = np.zeros(len(su))
        for k in range(chain.N):
            (u, v), (a, b) = chain.after[k], chain.after[(k + part) % chain.N]
            late = np.abs(ar.double(chain.tau[:, k] - chain.tau[:, (k + part) % chain.N])) / period
            off = np.max([off, np.abs(ar.double(u - a)).max(axis=1) / su, np.abs(ar.double(v - b)).max(axis=1) / sv, late], axis=0)
        return off

    def _repeats(self, branch, chain, rows):
        """An orbit that is a shorter one gone through several times has no branch of its own."""
        N, v = chain.N, self.verdict
        for part in range(1, N):
            if N % part or chain.events[part:] + chain.events[:part] != chain.events:
                continue
            for i in np.nonzero(self._again(chain, part) < REPEATED)[0]:
                if rows[i]["point"] in (0, branch["points"] - 1):
                    continue
                where, text = f"branch {branch['id']} {branch['label']} point {rows[i]['point']}", f"after {part} of {N} events"
                exact = self._finely(branch, rows[i])
                if exact is None:
                    v.leave("repeats", where, text, self._why_not())
                elif self._again(exact, part)[0] < math.sqrt(CONVERGED):
                    v.find("repeats", where, f"repeats itself {text}")
                else:
                    v.counts["nearly repeated"] += 1

    def _images(self, chain):
        """{symmetric, reversible: (off, everywhere)}, [P] each: how far orbits are from their images, where they start and at all of
        their events. Where a stop has no counterpart the state at one event may be its own image, and the motion is not."""
        su, sv = chain.size()

        def distance(a, b):
            return np.maximum(np.abs(ar.double(a[0] - b[0])).max(axis=1) / su, np.abs(ar.double(a[1] - b[1])).max(axis=1) / sv)

        N = chain.N
        half, back = [], []  # of each operation, how far off it is at the start, and at every event
        for k in range(N):
            half.append([distance([-x for x in chain.after[(k + j) % N]], chain.after[j]) for j in range(N)])
            for sign in (1, -1):
                back.append([distance((sign * u, -sign * w), chain.after[j])
                             for j in range(N) for u, w in [chain.before[(k - j) % N]]])
        return {what: (np.min([op[0] for op in ops], axis=0), np.min([np.max(op, axis=0) for op in ops], axis=0))
                for what, ops in (("symmetric", half), ("reversible", back))}

    def _symmetries(self, branch, chains, rows, slow):
        """Where rounding leaves a direction open, as along motions that go on at any phase, the polished orbit is another one than
        the stored one, which solves the equations as well: either may have the symmetry."""
        v, images = self.verdict, [self._images(chain) for chain in chains]
        middle = [i for i, r in enumerate(rows) if 0 < r["point"] < branch["points"] - 1 and slow[i] > 1e-4]
        for what in ("symmetric", "reversible"):
            said, found = branch[what], np.minimum(*(image[what][0] for image in images))
            for i in range(len(rows)):
                v.counts[what] += bool(said)
                if said and found[i] > SIMILAR * max(1, 1e-3 / max(slow[i], 1e-9)):
                    v.find(what, f"branch {branch['id']} {branch['label']} point {rows[i]['point']}",
                           f"said to be {what}, {found[i]:.1e} off")
            if not said and len(middle) > 3 and max(images[0][what][1][i] for i in middle) < 1e-10:
                v.find(what, f"branch {branch['id']} {branch['label']}", f"all {len(middle)} inner orbits are {what}, not said")

    # ---- many digits

    def _once(self, branch, row, digits):
        """What many digits say of a point; None where they do not converge or too many points have asked for them."""
        key = branch["id"], row["point"]
        if key not in self._digits:
            self.fine_left -= 1
            self._digits[key] = digits() if self.fine_left >= 0 else None
        return self._digits[key]

    def _why_not(self):
        return NO_DIGITS if self.fine_left >= 0 else TOO_MANY

    def _finely(self, branch, row):
        """The orbit in 50 digits, None where they are not to be had."""
        def converged():
            chain, _, _ = self.chain_of(branch["word"], [row], self.exact())
            polished, moved = orbits.polish_finely(chain)
            if polished.relative_residual()[0] > CONVERGED or moved > 1e-6:
                polished, _ = orbits.polish(self._held(chain, chain.growth()), rounds=4)
            return polished if polished.relative_residual()[0] < CONVERGED else None
        return self._once(branch, row, converged)

    # ---- multipliers

    def _shaken(self, chain, size):
        unknowns = chain.weights()[0]
        return chain.moved(ar.array(self.rng.choice([-1.0, 1.0], unknowns.shape) * size, chain.s.exact)
                           * ar.array(unknowns, chain.s.exact))

    def _rho(self, chain):
        return orbits.rho(chain)

    def _multipliers(self, branch, rows, fine, stored):
        rho = self._rho(fine)
        # Beside a branch point an orbit is known to rounding over the distance only: the stored one counts as it is, too.
        coarse = [self._rho(self._shaken(fine, 2e-16)), self._rho(self._shaken(fine, 2e-16)), self._rho(stored)]
        said = self._said(branch, rows)

        def redo(i):
            chain = self._finely(branch, rows[i])
            if chain is None:
                return None
            return [self._rho(chain)[0]] + [self._rho(self._shaken(chain, 1e-40))[0] for _ in range(2)]

        def as_stored(i):
            chain, _, _ = self.chain_of(branch["word"], [rows[i]], self.exact())
            return [self._rho(chain)[0]] + [self._rho(self._shaken(chain, 2e-16))[0] for _ in range(2)]

        again = []

        def finer(i):
            if not again:
                again.extend(self._rho(self._shaken(fine, 3e-19)) for _ in range(2))
            return [a[i] for a in again]

        self._compare(branch, rows, (rho, coarse, finer), said, (redo, as_stored))

    def _compare(self, branch, rows, found, said, digits):
        """`found`: pairs of all orbits, of orbits moved by a rounding, of one orbit by less; `digits`: of one in many digits, and as
        it is stored."""
        v, n, (rho, coarse, finer) = self.verdict, self.s.n, found
        for i, row in enumerate(rows):
            where = f"branch {branch['id']} {branch['label']} point {row['point']}"
            spread = np.max([np.abs(c[i] - rho[i]) for c in coarse], axis=0)
            exact = [self._rho_once(branch, row, k, lambda i=i, k=k: digits[k](i)) for k in range(2)]
            self._flag(row, where, rho[i], [c[i] for c in coarse], lambda i=i: finer(i), exact)
            if n == 2 and row["trace_asinh"] is not None and row["trace"] is not None:
                v.counts["multipliers"] += 1
                self._pair(row["trace"], rho[i], spread, 1e-9, exact, where)
            elif n > 2 and said is not None and row["point"] in said:
                self._pairs(said[row["point"]], rho[i], spread, exact, where)

    def _rho_once(self, branch, row, which, digits):
        """Pairs that are computed where they are asked for, and once."""
        key = branch["id"], row["point"], which

        def ask():
            if key not in self._fine_rho:
                self._fine_rho[key] = digits()
            return self._fine_rho[key]
        return ask

    def _pairs(self, said, rho, spread, exact, where):
        """Those of more than two modes, of which each is told with its inverse."""
        v = self.verdict
        told = [complex(x[0], x[1]) for x in said if x is not None and x[0] is not None]
        v.counts["multipliers"] += 1
        v.counts["multipliers not given"] += len(told) < len(said)
        for x in told:
            if x != 0:
                self._pair(x + 1 / x, rho, spread, 1e-8, exact, where)

    def _pair(self, said, rho, spread, number, exact, where):
        """One rho as it is told beside those that were found."""
        j = int(np.argmin(np.abs(rho - said)))
        size = 1 + abs(rho[j])
        near = np.sort(np.abs(rho - rho[j]))[1] if len(rho) > 1 else np.inf
        crowded = near < 1e-2 * size
        # A small one beside a large one is known to the rounding of the large one.
        allowed = number * size + FACTOR * spread[j] + (4e-15 * np.abs(rho).max() if len(rho) > 1 else 0)
        if crowded:  # two pairs that all but meet move like the root of what moves their sum
            allowed = max(allowed, 1e-6 * size)
        if not spread[j] < PROMISED * size and not crowded:  # at a grazing multipliers are infinite
            self.verdict.counts["multipliers beyond the stored digits"] += 1
        elif not (abs(said - rho[j]) <= allowed < PROMISED * size):
            self._settle(said, allowed, exact, where, f"{rho[j]!r} found", crowded)

    def _settle(self, said, allowed, exact, where, found, crowded):
        """By many digits; where these do not converge by the orbit as it is stored, moved by its rounding. What is allowed may be more
        than is promised: between the two nothing is said."""
        v = self.verdict
        for ask in exact:
            better = ask()
            if better is None:
                continue
            j = int(np.argmin(np.abs(better[0] - said)))
            promised = PROMISED * (1 + abs(better[0][j]))
            scatter, off = max(np.abs(b - better[0]).max() for b in better[1:]), abs(better[0][j] - said)
            if not scatter <= promised:
                continue
            if off <= min(allowed, promised) + scatter:
                v.counts["multipliers confirmed finely"] += 1
                return
            if off > allowed + scatter and ask is exact[0]:
                v.find("multiplier", where, f"{said!r} said, {found}, {better[0][j]!r} in many digits, allowed {allowed + scatter:.1e}")
                return
        none, text = exact[0]() is None, f"{said!r} said, {found}"
        if none and allowed < PROMISED * (1 + abs(said)) and not crowded:
            v.find("multiplier", where, f"{text}, allowed {allowed:.1e}")
        else:
            v.leave("multipliers", where, text, self._why_not() if none else NOT_HELD)

    def _said(self, branch, rows):
        """Multipliers as the program lists them, for more than two modes."""
        if self.s.n <= 2 or not self.program or self.calls <= 0:
            return None
        self.calls -= 1
        out = subprocess.run([self.program, "points", self.path, "--branch", str(branch["id"]), "--json"], capture_output=True,
                             text=True, timeout=120, check=False)
        if out.returncode:
            self.verdict.find("program", f"branch {branch['id']}", f"points: exit {out.returncode} {out.stderr[-200:]}")
            return None
        return {p["point"]: p["multipliers"] or [] for p in json.loads(out.stdout)}

    @staticmethod
    def stable(rho, real=1e-12):
        """YES or NO by these numbers, whatever their error; `real`: what a double root may have of an imaginary part."""
        rho = np.asarray(rho, dtype=complex)
        if not np.isfinite(rho).all():
            return None
        on_axis = np.abs(rho.imag) <= real * (1 + np.abs(rho))
        return YES if on_axis.all() and (np.abs(rho.real) < 2).all() else NO

    def _flag(self, row, where, rho, coarse, finer, exact):
        v = self.verdict
        said = row["stable"]
        if said == UNDECIDED:
            v.counts["flags undecided"] += 1
            return
        mine = {self.stable(r) for r in [rho] + coarse}
        if mine == {said}:
            v.counts["flags confirmed"] += 1
            return
        text = f"stable {('no', 'yes')[said]} said, rho {[str(complex(x)) for x in rho]}"
        fine = {self.stable(r) for r in [rho] + finer()}
        if fine == {said}:
            v.counts["flags confirmed finely"] += 1
            return
        better = exact[0]()
        digits = better is not None
        distances = np.abs(np.subtract.outer(np.asarray(rho), np.asarray(rho))) + 9 * np.eye(len(rho))
        crowded = distances.min() < 1e-2  # moves like a root of its rounding
        if better is None and len(mine) == 1 and None not in mine and not crowded:
            better = [rho] + coarse
        if better is None:
            v.leave("flags", where, text, self._why_not())
            return
        finest = {self.stable(r, FINELY_REAL if digits else 1e-12) for r in better}
        if finest == {said}:
            v.counts["flags confirmed finely"] += 1
            return
        margin = np.abs(np.abs(np.asarray(better[0])) - 2).min()
        text = f"stable {('no', 'yes')[said]} said, rho {[str(complex(x)) for x in better[0]]}, {margin:.1e} from 2"
        if len(finest) > 1 or None in finest:
            v.leave("flags", where, text, "many digits find both")
        elif self._clustered(better[0], exact[1]()):
            v.leave("flags", where, text, "pairs that meet within the rounding of the stored numbers")
        elif margin < BORDER:
            v.leave("flags", where, text, "nearer to the border than the stored numbers are to the orbit")
        else:
            v.find("flag", where, text)

    @staticmethod
    def _clustered(rho, stored):
        """Whether complex pairs are no farther from the real axis than the rounding of the stored numbers scatters them."""
        rho = np.asarray(rho, dtype=complex)
        off = np.abs(rho.imag)[np.abs(rho.imag) > FINELY_REAL * (1 + np.abs(rho))]
        return bool(stored) and off.size > 0 and off.max() <= max(np.abs(b - rho).max() for b in stored)

    # ---- power laws

    def _fly_ahead(self):
        """All points of a structure at once, which costs a fifth of one branch after the other."""
        chosen = [(branch, self._sample(branch["id"], self.atlas.points[branch["id"]])) for branch in self.atlas.branches]
        chosen = [(branch, rows) for branch, rows in chosen if rows and not self._unseen(rows)]
        with np.errstate(all="ignore"):
            try:
                self._flown = dict(zip([branch["id"] for branch, _ in chosen], self._fly(chosen))) if chosen else {}
            except (ArithmeticError, np.linalg.LinAlgError):
                self._flown = {}  # each branch by itself, so that the one that fails spoils no other

    def _start(self, rows):
        u, v, lost = self.s.from_stored(np.stack([floats(r["state"]) for r in rows]))
        return u, v, lost, np.array([float(floats(r["flights"]).sum()) for r in rows]).astype(ar.LONG) * self.s.omega_ref

    def _unseen(self, rows):
        """Whether this is a mode that no contact sees."""
        u, v, lost, _ = self._start(rows)
        return np.abs(ar.double(u)).max() + np.abs(ar.double(v)).max() < 1e-9 * lost

    def _fly(self, chosen):
        """What is flown for each (branch, rows): polished orbits, what symmetric ones are after half of their period (state and
        matrix), and the multipliers of orbits moved by a rounding."""
        s = self.s
        starts = [self._start(rows) for _, rows in chosen]
        ends = np.cumsum([len(rows) for _, rows in chosen])
        parts = [slice(end - len(rows), end) for end, (_, rows) in zip(ends, chosen)]
        found = smooth.polish(s, *(np.concatenate([start[i] for start in starts]) for i in (0, 1, 3)))
        u, w, T = found[:3]
        out = [{"polished": [x[part] for x in found], "half": None} for part in parts]
        symmetric = [i for i, (branch, _) in enumerate(chosen) if branch["symmetric"]]
        until = T.copy()
        if symmetric:
            on = np.concatenate([np.arange(parts[i].start, parts[i].stop) for i in symmetric])
            a, b, X = smooth.integrate(s, u[on], w[on], T[on] / 2, neighbours=s.n > 1)
            scale = np.abs(ar.double(u[on])).max(axis=1) + np.abs(ar.double(w[on])).max(axis=1)
            off = np.maximum(np.abs(ar.double(a + u[on])).max(axis=1), np.abs(ar.double(b + w[on])).max(axis=1)) / scale
            at = 0
            for i in symmetric:
                here = slice(at, at := at + parts[i].stop - parts[i].start)
                out[i]["half"] = off[here], None if X is None or off[here].max() > SYMMETRIC else -X[here]
                if out[i]["half"][1] is not None:
                    until[parts[i]] = until[parts[i]] / 2
        if s.n > 1:
            shaken = self._power_shaken(u, w, until, 2e-16)
            for flown, part in zip(out, parts):
                flown["shaken"] = [x[part] for x in shaken]
        return out

    def _power(self, branch, rows):
        s, v = self.s, self.verdict
        self._numbers(branch, rows)
        name = f"branch {branch['id']} {branch['label']}"
        if self._unseen(rows):
            v.counts["linear"] += len(rows)
            return
        v.counts["orbits"] += len(rows)
        energies = ar.double(s.raw_energy(np.stack([floats(r["state"]) for r in rows]), frozenset()))
        flown = self._flown.get(branch["id"]) or self._fly([(branch, rows)])[0]
        u, w, T, X, start, moved, left, drift, least = flown["polished"]
        growth = np.abs(ar.double(X)).max(axis=(1, 2))
        if drift.max() > 1e-15:
            v.counts["not replayed"] += len(rows)  # the judge's own series are not good enough
            return
        for i, row in enumerate(rows):
            where = f"{name} point {row['point']}"
            if start[i] > RETURN * max(1, growth[i]):
                v.find("residual", where, f"stored orbit returns {start[i]:.1e} off, growth {growth[i]:.1e}")
            if moved[i] > max(1e-6, FACTOR * 2.2e-16 / least[i]) and left[i] < 1e-13:
                v.find("distance", where, f"nearest solution is {moved[i]:.1e} away")
            if not close(energies[i], row["energy"], NUMBER):
                v.find("energy", where, f"{row['energy']!r} said, {energies[i]!r} from matrices")
        scale = np.abs(ar.double(u)).max(axis=1) + np.abs(ar.double(w)).max(axis=1)
        halves = None
        if branch["symmetric"]:
            off, halves = flown["half"]
            for i in np.nonzero(off > SIMILAR)[0]:
                v.find("symmetric", f"{name} point {rows[i]['point']}", f"said to be symmetric, {off[i]:.1e} off")
        if branch["reversible"]:
            off = np.minimum(np.abs(ar.double(u)).max(axis=1), np.abs(ar.double(w)).max(axis=1)) / scale
            for i in np.nonzero(off > SIMILAR)[0]:
                v.find("reversible", f"{name} point {rows[i]['point']}", f"said to start at a mirror point, {off[i]:.1e} off")
        if s.n > 1:
            half = halves is not None
            self._power_multipliers(branch, rows, (u, w, T / 2 if half else T), halves if half else X, half, flown["shaken"])

    def _power_multipliers(self, branch, rows, orbit, X, half, shaken):
        """Of a symmetric orbit from its first half: +-2 and clusters of the whole are told apart there."""
        u, w, T = orbit
        again = []

        def of_moved(moved):
            a, b, Y = moved
            return self._power_rho(a, b, -Y if half else Y, half)

        def finer(i):
            if not again:
                again.append(of_moved(self._power_shaken(u, w, T, 3e-19)))
            return [again[0][i]]

        def redo(i):
            return self._once(branch, rows[i], lambda: self._power_finely(rows[i], half))

        self._compare(branch, rows, (self._power_rho(u, w, X, half), [of_moved(shaken)], finer), self._said(branch, rows),
                      (redo, lambda i: None))

    def _power_finely(self, row, half):
        """Pairs in 46 digits, of the orbit and of one that is 1e-30 away; None where they are not to be had."""
        s = self.exact()
        u, v, _ = s.from_stored(floats(row["state"])[None, :])
        T = mpmath.mpf(float(floats(row["flights"]).sum())) * ar.number(s.omega_ref, True)
        try:
            motion, u, v, T, far, left = smooth_fine.orbit(s, u[0], v[0], T)
            if left > 1e-30 or far > 1e-6:
                return None
            moved = u * (1 + smooth_fine.fast(1e-30))
            return [smooth_fine.rho(s, motion, x, v, T, half) for x in (u, moved)]
        except ArithmeticError:
            return None

    def _power_shaken(self, u, w, T, size):
        """Orbits that are so far away, relative, and their matrices."""
        scales = [np.abs(ar.double(x)).max(axis=1)[:, None] for x in (u, w)]
        shaken = [x + self.rng.choice([-1.0, 1.0], x.shape) * size * z for x, z in zip((u, w), scales)]
        return *shaken, smooth.integrate(self.s, *shaken, T)[2]

    def _power_rho(self, u, w, X, half):
        a = smooth.acceleration(self.s, u)
        own = orbits.pairs(orbits.section_map(np.concatenate([w, a], axis=1), np.concatenate([-a, w], axis=1), X, False))
        return orbits.doubled(own) if half else own

    # ---- junctions

    def _junctions(self):
        v = self.verdict
        for j in self.atlas.junctions:
            where = f"junction {j['id']} {j['label']}"
            v.counts["junctions"] += 1
            multiple = j["multiple"] or 1
            flights = floats(j["flights"])
            total = float(flights.sum())
            if total > 0:
                omega = 2 * math.pi / total / multiple
                if not close(omega, j["frequency"], 1e-9):
                    v.find("frequency", where, f"{j['frequency']!r} said, {omega!r} from flights")
            if not self.s.power and j["word"]:
                self._junction(j, where)

    def _junction(self, j, where):
        v, s = self.verdict, self.s
        try:
            chain, states, _ = self.chain_of(j["word"], [j])
        except (ValueError, IndexError) as error:
            v.find("word", where, str(error))
            return
        energy = float(s.raw_energy(states, chain.first_closed)[0])
        if not close(energy, j["energy"], 1e-9):
            v.find("energy", where, f"{j['energy']!r} said, {energy!r} from matrices")
        start = chain.relative_residual()[0] / self._stiff()
        if start > RESIDUAL + ROUNDED * chain.growth()[0]:
            v.find("residual", where, f"stored orbit misses its equations by {start:.1e}")
            return
        reach = gaps.Reach(chain)
        if reach.worst()[0] > 1 + 1e-6:
            v.find("penetration", where, f"gap opens to {reach.worst()[0]!r} ({reach.where[0]})")
        speeds = np.array([float(x[0]) for x in chain.speed]) / chain.size()[1][0]
        if j["kind"] == "grazing":
            held = self._touch_held(chain, reach)
            near = abs(reach.stationary[0] - 1) < 1e-7 + held or np.abs(speeds).min() < 1e-6
            if not near:
                v.find("grazing", where, f"no touch: reach {reach.stationary[0]!r} +- {held:.1e}, least speed {np.abs(speeds).min():.1e}")
        elif j["kind"] == "multiplication" and j["rotation_q"] and s.n > 1:
            self._rotation(j, chain, where)
        elif j["kind"] in ("extremum", "branch-point", "period-extremum"):
            self._singular(j, chain, where)

    def _touch_held(self, chain, reach):
        """To what the stored digits of one orbit hold its largest gap. A branch ends at its first touch, so that of several equal ones
        the last, which has come farthest from the stored state, may be the largest by that."""
        if reach.place[0] is None:
            return 0.0
        flight, contact, at, factor = reach.place[0]
        return abs(factor) * float(chain.rounded_gap(flight, contact, np.array([at]))[0])

    def _rotation(self, j, chain, where):
        fine, _ = orbits.polish(chain)
        rho = self._rho(fine)[0]
        blur = np.max([np.abs(self._rho(self._shaken(fine, 1e-15))[0] - rho) for _ in range(3)], axis=0)
        across = self._across(fine)
        if across is None:
            return
        blur = np.maximum(blur, np.max([np.abs(self._rho(x)[0] - rho) for x in across], axis=0))
        want = 2 * math.cos(2 * math.pi * j["rotation_p"] / j["rotation_q"])
        k = int(np.argmin(np.abs(rho - want)))
        allowed = 1e-6 + 1e3 * blur[k]
        if self._without_trace(j):
            allowed += LOST * (1 + abs(want))
        if j["label"].endswith("?"):
            allowed += max(np.abs(self._rho(x)[0] - rho)[k] for x in self._along(fine))
        if abs(rho[k] - want) > allowed:
            self.verdict.find("rotation", where, f"rotation {j['rotation_p']}/{j['rotation_q']} needs rho {want}, "
                                                 f"nearest {rho[k]!r} +- {blur[k]:.1e}")

    def _without_trace(self, j):
        """Whether no trace is stored at a multiplication, which is said to be where it is as far as a trace is known."""
        passed = [(b, row["arclength"]) for b, rows in self.atlas.on_branch.items() for row in rows if row["junction"] == j["id"]]
        return self.s.n == 2 and any(p["trace"] is None for b, at in passed for p in self.atlas.points[b] if p["arclength"] == at)

    def _across(self, chain):
        """Orbits that the stored digits do not tell from this one: moved to either side along the direction that the
        equations hold least, by rounding over how they hold it. None where they hold it not at all."""
        _, sv, Vt = (x[0] for x in chain.singular())
        if len(sv) < 2:
            return [chain]
        if not sv[-2] > 1e-15:
            return None
        step = Vt[-2] * chain.weights()[0][0] * (2 ** -53 / sv[-2])
        return [chain.moved((sign * step)[None, :]) for sign in (-1, 1)]

    def _along(self, chain):
        """The curve on either side of a junction whose label is not decided: as far as its place is said not to be known."""
        step = chain.singular()[2][0][-1] * chain.weights()[0][0] * UNPLACED
        return [chain.moved((sign * step)[None, :]) for sign in (-1, 1)]

    def _singular(self, j, chain, where):
        """At an extremum the curve has no slope in energy; at a branch point the kernel has a second direction."""
        v = self.verdict
        U, sv, Vt = (x[0] for x in chain.singular())
        unknowns = chain.weights()[0][0]
        # the square problem has one redundant equation and one direction along the curve
        second = sv[-2] if len(sv) > 1 else 1
        if j["kind"] == "branch-point":
            if second > 1e-4 * sv[0] ** 0:
                v.find("branch-point", where, f"second smallest singular value {second:.1e}")
            return
        value, allowed = self._slope(j["kind"], chain, Vt[-1] * unknowns), 1e-6 + 1e-13 / second
        if abs(value) > allowed:  # beside stiff springs the largest singular value is 1e10, and doubles hide the direction
            fine, _ = orbits.polish_finely(self.chain_of(j["word"], [j], self.exact())[0])
            value = self._slope(j["kind"], fine, orbits.tangent_finely(fine) * fine.weights()[0][0])
        if abs(value) > allowed:
            v.find(j["kind"], where, f"slope along the branch {value:.1e} (second singular value {second:.1e})")

    def _slope(self, kind, chain, tangent):
        """Relative, of the energy or of the period, per length of the tangent."""
        n = self.s.n
        if kind != "extremum":
            return float(tangent[2 * n:].sum() / ar.double(chain.tau[0]).sum())
        w, a = ar.double(chain.after[0][1][0]), ar.double(chain.s.acceleration(chain.first_closed, chain.after[0][0])[0])
        E = float(chain.s.energy(chain.first_closed, *chain.after[0])[0])
        return float((-a) @ tangent[:n] + w @ tangent[n:2 * n]) / E


def judge(study, path, program=None, budget=400, seed=1):
    return Judge(study["model"], Atlas(path), program, path, budget, np.random.default_rng(seed)).run()
