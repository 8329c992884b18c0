"""One periodic orbit."""
from __future__ import annotations

import math

from ._library import check, ffi, filled, lib, pointer, word_of
import numpy as np

from ._show import lines
from ._simulation import History, Simulation, simulate

TWO_PI = 6.283185307179586
STEPS = 400  # of a history, unless given


class Orbit:
    """A periodic orbit of a branch, solved to rounding.

    Lengths are scaled by d of the first contact and energies by d^2 (`model.length`); times are in s, frequencies in
    rad/s.

    Attributes
    ----------
    branch : Branch
    energy : float, scaled
    frequency : float, rad/s
    period : float, s
    word : str
        The faces that are hit in one period, in their order.
    x, v : array [n_dof]
        Scaled state right after the first impact of the word, v in 1/s.
    flights : array [max(letters, 1)], s
    stable, undecided : bool
        Not stable and not undecided is unstable.
    multipliers : complex array [2 (n_mode - 1)]
        Without the trivial ones; NaN where rounding leaves less than three digits.
    multiplier_error : float
        What the sum of a pair may be off by.
    reach, approach : float
        Largest gap over clearance in flight, smallest scaled speed of approach.
    residual : float, relative
    """

    def __init__(self, branch, handle, owner):
        self.branch, self._handle, self._owner = branch, handle, owner
        self.model = branch.atlas.model
        letters, n = lib.ric_orbit_letters(handle), self.model.n_dof
        point, state = ffi.new("ric_point *"), np.zeros(2 * n)
        self.flights, self._word = np.zeros(max(letters, 1)), np.zeros(letters, np.intc)
        lib.ric_orbit_data(handle, point, pointer(state), pointer(self.flights), pointer(self._word))
        self.impacts = lib.ric_orbit_impacts(handle)
        self.state, self.x, self.v = state, state[:n], state[n:]
        self.energy, self.frequency, self.period = point.energy, point.frequency, TWO_PI / point.frequency
        self.reach, self.approach, self.residual = point.reach, point.approach, float(point.residual)
        self.stable = point.stable == lib.RIC_STABLE_YES
        self.undecided = point.stable == lib.RIC_STABLE_UNDECIDED
        self.multiplier_error = lib.ric_orbit_multiplier_error(handle)

    @property
    def word(self) -> str:
        """The faces that are hit in one period."""
        return word_of(self.model._handle, len(self._word), pointer(self._word))

    @property
    def multipliers(self) -> np.ndarray:
        """Complex [2 (n_mode - 1)], lambda before 1 / lambda."""
        n = max(0, 2 * (self.model.n_mode - 1))
        return filled(2 * n + 1, lambda out: lib.ric_orbit_multipliers(self._handle, out))[:2 * n].view(complex)

    @property
    def parting(self) -> np.ndarray:
        """Complex, of disturbances that part contacts which close together (key `together` of a study): empty where
        none do. InputError where they are not defined."""
        n, stable = ffi.new("int *"), ffi.new("ric_stability *")
        out = filled(4 * self.model.n_dof, lambda out: lib.ric_orbit_parting(self._handle, n, out, stable))
        return out[:2 * n[0]].view(complex)

    @property
    def impact_times(self) -> np.ndarray:
        """[max(letters, 1)], s, from 0 on."""
        return np.concatenate([[0.0], np.cumsum(self.flights)[:-1]])

    @property
    def amplitudes(self) -> np.ndarray:
        """[n_dof] largest |x| over the period, scaled."""
        return filled(self.model.n_dof, lambda out: lib.ric_orbit_amplitudes(self._handle, out))

    def _exchanges(self) -> np.ndarray:
        n, out = ffi.new("int *"), np.zeros((2, len(self._word) + 1))
        check(lib.ric_orbit_exchanges(self._handle, n, pointer(out[0]), pointer(out[1])))
        return out[:, :n[0]]

    @property
    def impact_speeds(self) -> np.ndarray:
        """[impacts] speed of approach, scaled, 1/s."""
        return self._exchanges()[0]

    @property
    def impulses(self) -> np.ndarray:
        """[impacts] momentum exchanged along the normal, scaled, mass/s; of a spring from closing to opening."""
        return self._exchanges()[1]

    def at(self, t) -> tuple:
        """The state (x, v) at time t in s, modulo the period: [n_dof] each, or [k, n_dof] for an array of k instants."""
        times = np.asarray(t, float)
        out = np.empty((times.size, 2, self.model.n_dof))
        for row, instant in zip(out, times.ravel()):
            lib.ric_orbit_at_time(self._handle, instant, pointer(row[0]), pointer(row[1]))
        return (out[0, 0], out[0, 1]) if times.ndim == 0 else (out[:, 0], out[:, 1])

    def history(self, dt: float = None) -> History:
        """The motion over one period, every dt seconds and at its end; without dt in 400 steps.

        Returns
        -------
        History: t [k], x [k, n_dof], v [k, n_dof]
        """
        dt = self.period / STEPS if dt is None else float(dt)
        if not dt > 0 or self.period / dt > 1e7:
            raise ValueError(f"dt = {dt:g} s: a period of {self.period:g} s needs a step between {self.period / 1e7:.1g} "
                             "s and itself")
        times = np.arange(int(math.floor(self.period / dt * (1 - 1e-12))) + 1) * dt
        x, v = self.at(np.append(times, 0.0))
        return History(np.append(times, self.period), x, v)

    def simulate(self, periods: float = 1, steps: int = STEPS) -> Simulation:
        """What the simulator, which knows nothing of the orbit, makes of its state.

        Parameters
        ----------
        periods : float
        steps : int
            Of the history, per period.
        """
        return simulate(self.model, self.x, self.v, periods * self.period, max(1, round(steps * periods)), 1000000)

    def animate(self, **style):
        """A matplotlib animation of the motion; see plot.animate."""
        from . import plot
        return plot.animate(self, **style)

    def _stability(self) -> str:
        return "stable" if self.stable else "undecided" if self.undecided else "unstable"

    def __repr__(self) -> str:
        return (f"Orbit of {self.branch.label}: energy {self.energy:.10g}, frequency {self.frequency:.10g} rad/s, "
                f"period {self.period:.10g} s, {self.impacts} impacts, {self._stability()}")

    def _repr_html_(self) -> str:
        history = self.history(self.period / 200)
        return f"{self!r}<br>{lines(history.t, history.x.T)}"
