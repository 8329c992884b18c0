"""Motions in time: histories of orbits, and the simulator."""
from __future__ import annotations

from typing import NamedTuple

from ._library import Error, InputError, check, ffi, lib, pointer
import numpy as np

from ._show import lines

IMPACT = np.dtype([("time", float), ("face", int), ("approach", float), ("impulse", float), ("opens", bool)])


class History(NamedTuple):
    """A motion at instants: t [k] in s, scaled displacements x [k, n_dof], velocities v [k, n_dof] in 1/s."""

    t: np.ndarray
    x: np.ndarray
    v: np.ndarray

    def __repr__(self) -> str:
        return f"History of {len(self.t)} instants, t = {self.t[0]:g} to {self.t[-1]:g} s, {self.x.shape[1]} coordinates"

    def _repr_html_(self) -> str:
        return f"{self!r}<br>{lines(self.t, self.x.T)}"


class Simulation:
    """What the simulator makes of a state.

    Attributes
    ----------
    t : array [k], s
    x, v : array [k, n_dof], scaled; v in 1/s
    impacts : structured array with time (s), face, approach (scaled speed, negative where a spring opens), impulse
        (scaled) and opens
    reach : float
        Largest gap over clearance outside impacts: 1 at a touch.
    """

    def __init__(self, t, x, v, impacts, reach):
        self.t, self.x, self.v, self.impacts, self.reach = t, x, v, impacts, reach

    @property
    def history(self) -> History:
        """t, x and v."""
        return History(self.t, self.x, self.v)

    def __repr__(self) -> str:
        return f"Simulation to t = {self.t[-1]:g} s with {len(self.impacts)} impacts"

    def _repr_html_(self) -> str:
        return f"{self!r}<br>{lines(self.t, self.x.T)}"


def _start(model, x: np.ndarray, v: np.ndarray):
    out = ffi.new("ric_simulator **")
    check(lib.ric_simulator_create(model._handle, out))
    sim = ffi.gc(out[0], lib.ric_simulator_free)
    check(lib.ric_simulator_start(sim, pointer(x), pointer(v)))
    return sim


def _advance(sim, time: float, found: list, most: int) -> None:
    hit, impact = ffi.new("bool *", True), ffi.new("ric_impact *")
    while hit[0]:
        check(lib.ric_simulator_advance(sim, time, hit, impact))
        if hit[0]:
            found.append((impact.time, impact.face, impact.approach, impact.impulse, impact.opens))
        if len(found) > most:
            raise Error(f"more than {most} impacts before t = {time:g} s; the last one at {impact.time:g} s")


def simulate(model, x: np.ndarray, v: np.ndarray, time: float, steps: int, most: int) -> Simulation:
    """The motion from (x, v), at `steps` + 1 instants up to `time`. Impacts are those of a motion without steps, each of
    which costs a rounding."""
    if not time > 0 or steps < 1:
        raise InputError(f"time {time:g}, steps {steps}: motion is followed forward from time 0, in one step at least")
    whole, found = _start(model, x, v), []
    _advance(whole, time, found, most)
    sim = _start(model, x, v)
    times = np.array([time * k / steps for k in range(steps)] + [time])
    states = np.empty((steps + 1, 2, x.size))
    states[0] = x, v
    for k in range(1, steps + 1):
        _advance(sim, times[k], [], most)
        lib.ric_simulator_state(sim, ffi.NULL, pointer(states[k, 0]), pointer(states[k, 1]))
    return Simulation(times, states[:, 0], states[:, 1], np.array(found, IMPACT), lib.ric_simulator_reach(whole))
