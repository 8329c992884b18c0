"""The family of an orbit that an atlas lacks, followed by the judge to both its ends, and the junctions of the atlas that it meets.

A family of orbits ends where a face is touched or left without speed; an arrival at a more symmetric or at a repeated orbit is
passed through, with an extremum of the energy there. Both are looked up among the junctions by energy and frequency."""
import math

import numpy as np

import arithmetic as ar
import gaps
import search

STEPS = 500  # in one direction
LONGEST, SHORTEST = 0.2, 1e-7  # steps, over the size of an orbit; shorter ones are where the family cannot be followed
NEAR = 1e-6  # relative: an end lies at a junction, in energy and in frequency
NEAR_FOLD = 1e-4  # the same of an extremum of the energy, which is read off a parabola
TURN = 0.35  # of the tangent over one step


class End:
    """Where a family meets something: `what` it is, energy (as stored) and frequency."""

    def __init__(self, what, energy=math.nan, frequency=math.nan):
        self.what, self.energy, self.frequency = what, energy, frequency


def _tangent(chain, before=None):
    unknowns = chain.weights()[0]
    t = chain.singular()[2][0][-1]
    if before is not None and t @ before < 0:
        t = -t
    return t, unknowns[0]


def _corrected(chain):
    """The orbit nearest to a guess, None if it is far or not reached."""
    start = chain
    unknowns, equations = chain.weights()
    for _ in range(6):
        U, s, Vt = chain.singular()
        off = ar.double(chain.residual()) / equations
        inverse = np.where(s > 1e-11 * s[:, :1], 1 / np.maximum(s, 1e-300), 0)
        step = np.einsum("pji,pj->pi", Vt, inverse * np.einsum("pji,pj->pi", U, off)) * unknowns
        chain = chain.moved(-step.astype(ar.LONG))
        if np.abs(step / unknowns).max() < 1e-14:
            break
    moved = max(np.abs(ar.double(a - b)).max() for a, b in ((chain.u, start.u), (chain.v, start.v)))
    good = chain.relative_residual()[0] < 1e-13 and moved < 0.1 * max(np.abs(ar.double(x)).max() for x in (start.u, start.v))
    return chain if good else None


def _inside(chain):
    """Whether all speeds, times and gaps are those of an orbit; a touch within rounding belongs to it."""
    if min(float(x[0]) for x in chain.speed) < 0 or float(chain.tau[0].min()) < 0:
        return False
    return gaps.Reach(chain).worst()[0] <= 1


def _place(chain):
    """(energy as stored, frequency)."""
    s = chain.s
    return (float(search.s_energy(chain)[0]) * s.omega_ref**2, 2 * math.pi * s.omega_ref / float(chain.tau[0].sum()))


def _fold(rows):
    """(energy, frequency) at the extremum through three places with their arclengths."""
    s, e, w = (np.array(x) for x in zip(*rows))
    curve, line = np.polyfit(s - s[1], e, 2), np.polyfit(s - s[1], w, 2)
    at = -curve[1] / (2 * curve[0])
    return float(np.polyval(curve, at)), float(np.polyval(line, at))


def one_way(orbit, sign, window, band):
    """What the family meets in one direction, ends and extrema of the energy, [End]."""
    chain, out, size = orbit.chain, [], 0.01
    t, unknowns = _tangent(chain)
    t = t * sign
    rows, arclength = [(0.0, *_place(chain))], 0.0
    for _ in range(STEPS):
        guess = _corrected(chain.moved((t * unknowns * size)[None, :].astype(ar.LONG)))
        new = _tangent(guess, t) if guess is not None else None
        short = guess is None or (new[0] @ t) < 1 - TURN**2 / 2
        if short or not _inside(guess):
            size /= 2
            if size < SHORTEST:
                return out + [End("not followed" if short else "touch", *_place(chain))]
            continue
        chain, (t, unknowns) = guess, new
        arclength, size = arclength + size, min(1.5 * size, LONGEST)
        rows.append((arclength, *_place(chain)))
        if len(rows) > 2 and (rows[-1][1] - rows[-2][1]) * (rows[-2][1] - rows[-3][1]) < 0:
            out.append(End("extremum", *_fold(rows[-3:])))
        energy, frequency = rows[-1][1:]
        if not (window[0] <= energy <= window[1] and band[0] <= frequency <= band[1]):
            return out + [End("window", energy, frequency)]
        if len(rows) > 3 and search.Orbit(chain, 0, 0).same(orbit):
            return out + [End("closed")]
    return out + [End("long", *_place(chain))]


def ends(orbit, window, band):
    """All that the family of an orbit meets in both directions."""

    return [end for sign in (1, -1) for end in one_way(orbit, sign, window, band)]


def junctions(atlas, end, times):
    """Rows of the atlas at that place, of orbits that the family goes through so many times."""
    near = NEAR if end.what == "touch" else NEAR_FOLD
    if end.what not in ("touch", "extremum"):
        return []
    return [j for j in atlas.junctions if abs(j["energy"] - end.energy) <= near * end.energy
            and abs(j["frequency"] - times * end.frequency) <= near * times * end.frequency]
