"""The orbits of one energy that an atlas holds: Newton's method between neighbouring stored points, by the judge's own equations."""
import numpy as np

import arithmetic as ar
import search
from orbits import Chain
from structure import read_word

WIDE = 0.3  # part of the interval between two points by which the energy may lie beside it: a fold between them
AWAY = 2.0  # the same, of the distance between two points, by which the orbit may lie off the chord


def _blob(row, name):
    return np.frombuffer(row[name], dtype="<f8")


def chain_of(s, word, rows):
    """The stored orbits as one chain."""
    events, closed = read_word(s, word)
    u, v, _ = s.from_stored(np.stack([_blob(r, "state") for r in rows]))
    tau = np.stack([_blob(r, "flights") for r in rows]).astype(ar.LONG) * ar.LONG(s.omega_ref)
    return Chain(s, events, closed, u, v, tau)


def _between(rows, energy):
    """[(index, part)] of the intervals that may hold the energy."""
    out = []
    for i, (a, b) in enumerate(zip(rows, rows[1:])):
        low, high = a["energy"], b["energy"]
        part = (energy - low) / (high - low) if high != low else 0.5
        fold = 0 < i < len(rows) - 2 and (rows[i - 1]["energy"] - low) * (high - rows[i + 2]["energy"]) < 0
        if -WIDE < part < 1 + WIDE or (fold and abs(energy - low) < 2 * abs(high - low) + 1e-3 * energy):
            out.append((i, min(max(part, 0), 1)))
    return out


def on_branch(s, branch, rows, energy):
    """[Orbit] of that energy (in units of the judge, `energy` scaled as stored over omega_ref^2)."""
    where = _between(rows, energy * s.omega_ref**2)
    if not where:
        return []
    chain = chain_of(s, branch["word"], rows)
    u, v, tau = (np.stack([x[i] + ar.LONG(part) * (x[i + 1] - x[i]) for i, part in where]) for x in (chain.u, chain.v, chain.tau))
    first = Chain(s, chain.events, chain.first_closed, u, v, tau)
    last, good = search.solve(first, energy)
    chord = [max(ar.double(np.abs(x[i + 1] - x[i])).max() for x in (chain.u, chain.v, chain.tau)) for i, _ in where]
    moved = [max(ar.double(np.abs(x[p] - y[p])).max() for x, y in ((last.u, u), (last.v, v), (last.tau, tau)))
             for p in range(len(where))]
    near = np.array(moved) <= AWAY * np.array(chord)
    good &= near
    if good.any():  # beyond an end of the branch there is no orbit of it
        good[good] = search.admissible(search.picked(last, good))
    return [search.Orbit(last, p, energy) for p in np.nonzero(good)[0]]


def at(s, atlas, energy, most):
    """[(branch, Orbit)] of all branches with so many impacts at most."""
    out = []
    for branch in atlas.branches:
        if not branch["word"] or branch["impacts"] > most:
            continue
        mine = []
        for orbit in on_branch(s, branch, atlas.points[branch["id"]], energy):
            if not any(orbit.same(o) for o in mine):
                mine.append(orbit)
        out += [(branch["id"], o) for o in mine]
    return out
