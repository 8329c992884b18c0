"""Motions in time: histories of orbits, and the simulator."""
from __future__ import annotations

from typing import NamedTuple

from ._library import Error, InputError, check, ffi, lib, pointer
import numpy as np

from ._force import fill_shaking
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
        Largest gap over clearance outside impacts: 1 at a touch; NaN under damping or force.
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


class _Motion:
    """The simulator of free motions, or that of motions under damping and force."""

    def __init__(self, model, x: np.ndarray, v: np.ndarray, shaken):
        kind, out = "simulator" if shaken is None else "shaken", None
        self._advance, self._state = getattr(lib, f"ric_{kind}_advance"), getattr(lib, f"ric_{kind}_state")
        out = ffi.new(f"ric_{kind} **")
        if shaken is None:
            check(lib.ric_simulator_create(model._handle, out))
        else:
            check(lib.ric_shaken_create(model._handle, shaken["raw"], shaken["omega"], shaken["level"], out))
        self.handle = ffi.gc(out[0], getattr(lib, f"ric_{kind}_free"))
        start, phase = getattr(lib, f"ric_{kind}_start"), () if shaken is None else (shaken["phase"],)
        check(start(self.handle, pointer(x), pointer(v), *phase))

    def advance(self, time: float, found: list, most: int) -> None:
        """To an instant, with the impacts on the way."""
        hit, impact = ffi.new("bool *", True), ffi.new("ric_impact *")
        while hit[0]:
            check(self._advance(self.handle, time, hit, impact))
            if hit[0]:
                found.append((impact.time, impact.face, impact.approach, impact.impulse, impact.opens))
            if len(found) > most:
                raise Error(f"more than {most} impacts before t = {time:g} s; the last one at {impact.time:g} s")

    def state(self, out: np.ndarray) -> None:
        """Into out [2, n_dof]."""
        self._state(self.handle, ffi.NULL, pointer(out[0]), pointer(out[1]))


def shaken(model, force, omega: float, level: float, phase: float, damping, restitution):
    """What shakes a motion, for `simulate`; None where nothing does, and nothing is lost."""
    if force is None and damping is None and restitution is None:
        return None
    raw = ffi.new("ric_shaking *")
    keep = fill_shaking(raw, force, damping, model.restitution if restitution is None else restitution)
    check(lib.ric_force_check(model._handle, raw))
    if force is not None and level and not omega:
        raise InputError("force needs omega, its frequency in rad/s")
    return {"raw": raw, "keep": keep, "omega": omega, "level": level, "phase": phase}


def simulate(model, x: np.ndarray, v: np.ndarray, time: float, steps: int, most: int, given=None) -> Simulation:
    """The motion from (x, v), at `steps` + 1 instants up to `time`. Impacts are those of a motion without steps, each of
    which costs a rounding."""
    if not time > 0 or steps < 1:
        raise InputError(f"time {time:g}, steps {steps}: motion is followed forward from time 0, in one step at least")
    whole, found = _Motion(model, x, v, given), []
    whole.advance(time, found, most)
    again = _Motion(model, x, v, given)
    times = np.array([time * k / steps for k in range(steps)] + [time])
    states = np.empty((steps + 1, 2, x.size))
    states[0] = x, v
    for k in range(1, steps + 1):
        again.advance(times[k], [], most)
        again.state(states[k])
    reach = lib.ric_simulator_reach(whole.handle) if given is None else np.nan
    return Simulation(times, states[:, 0], states[:, 1], np.array(found, IMPACT), reach)
