"""Whether branches of two atlases are one, by the orbits that they share: what of an orbit depends neither on the event it is
stored from, nor on the direction it is gone through, nor on coordinates, read off where one branch passes the energy of the other."""
import numpy as np

ASKED = 5  # points of a branch that are looked for on the other
LEFT_OPEN = 2.0  # times what a third point adds to the chord between two: how far the orbit may lie off the chord
ROUNDED = 1e-7  # relative: what is left where three points lie on a line


def _orbit(row, mass, normals):
    """[numbers]: frequency, shares of the flights in the period, margins; without events the state where the motion turns round."""
    flights = np.sort(np.frombuffer(row["flights"], dtype="<f8"))
    margins = [row[name] if row[name] is not None else 0.0 for name in ("reach", "approach")]
    if len(flights) > 1:
        return np.concatenate([[row["frequency"]], flights / flights.sum(), margins])
    state = np.frombuffer(row["state"], dtype="<f8")
    x, v = state[: len(mass)], state[len(mass):]
    return np.concatenate([[row["frequency"]], margins, np.abs(normals @ x), np.abs(normals @ v), [x @ mass @ x, v @ mass @ v]])


class Curves:
    """The branches of one atlas as energies [P] and orbits [P, numbers], made when they are asked for; `said`: what its report says."""

    def __init__(self, atlas, model, said):
        self.atlas, self.said, self.mass = atlas, said, np.array(model["mass"], dtype=float)
        self.normals = np.array([c["normal"] for c in model["contacts"]], dtype=float)
        self.rows, self.made = {b["id"]: b for b in atlas.branches}, {}
        self.junctions = {j["id"]: j for j in atlas.junctions}

    def of(self, branch):
        if branch not in self.made:
            rows = self.atlas.points[branch]
            self.made[branch] = (np.array([r["energy"] for r in rows]),
                                 np.array([_orbit(r, self.mass, self.normals) for r in rows]))
        return self.made[branch]

    def kind(self, branch):
        b = self.rows[branch]
        return b["impacts"], b["symmetric"], b["reversible"], b["mirror"] if b["impacts"] == 0 else ""

    def beyond(self, branch, energy):
        """Whether an energy lies in the last step of a branch that got stuck, or where it has not come."""
        e = self.of(branch)[0]
        low, high = self.step_around(branch, e[-1])
        return low <= energy <= high or not e.min() < energy < e.max()

    def step_around(self, branch, energy):
        """Least and largest energy of the steps of the branch that hold this one, and of their neighbours."""
        e = self.of(branch)[0]
        held = [i for i in range(len(e) - 1) if min(e[i], e[i + 1]) <= energy <= max(e[i], e[i + 1])]
        near = [e[j] for i in held for j in range(max(0, i - 1), min(len(e), i + 3))]
        return (min(near), max(near)) if near else (energy, energy)


def _on(energy, orbit, energies, orbits):
    """Whether a curve passes an orbit: on the plane of its energy, between two points, as near as the bend of the curve allows."""
    for i in range(len(energies) - 1):
        low, high = energies[i], energies[i + 1]
        if not min(low, high) <= energy <= max(low, high) or low == high:
            continue
        j = i + 2 if i + 2 < len(energies) else i - 1
        part = (energy - low) / (high - low)
        chord = orbits[i] + part * (orbits[i + 1] - orbits[i])
        far = (energies[j] - low) / (high - low) if j >= 0 else 0
        rest = far * (far - 1)
        bend = np.zeros_like(chord) if j < 0 or rest == 0 else (orbits[j] - orbits[i] - far * (orbits[i + 1] - orbits[i])) / rest
        allowed = LEFT_OPEN * np.abs(bend) * abs(part * (part - 1)) + ROUNDED * (np.abs(chord) + np.abs(chord).max())
        if (np.abs(orbit - chord - bend * part * (part - 1)) <= allowed).all():
            return True
    return False


def shared(one, a, other, b):
    """Whether branch a of one atlas and b of the other have orbits in common: half of those that both energies hold."""
    if one.kind(a) != other.kind(b):
        return False
    (e, x), (f, y) = one.of(a), other.of(b)
    if min(len(e), len(f)) < 2 or x.shape[1] != y.shape[1]:
        return False
    both = [i for i in range(len(e)) if f.min() <= e[i] <= f.max()]
    if not both:
        return False
    asked = sorted({both[k * (len(both) - 1) // max(ASKED - 1, 1)] for k in range(ASKED)})
    return 2 * sum(_on(e[i], x[i], f, y) for i in asked) >= len(asked)
