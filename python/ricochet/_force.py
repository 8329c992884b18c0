"""Orbits under damping and a harmonic force."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional, Tuple

from ._library import InputError, check, copy_of, ffi, fields_of, lib, pointer, text_of
import numpy as np

_STABLE = {lib.RIC_STABLE_YES: "yes", lib.RIC_STABLE_NO: "no", lib.RIC_STABLE_UNDECIDED: "undecided"}


@dataclass
class Forcing:
    """What a study says of force and losses.

    force [n_dof], of amplitude 1, physical, or None; damping, modal ratios [1 or n_dof], a matrix [n_dof, n_dof], physical, or
    None; restitution; amplitude [k], physical, perhaps none; frequency, (low, high), rad/s, twice the same number where it is
    one, or None; harmonic [k], of the orbit, perhaps none.
    """

    force: Optional[np.ndarray]
    damping: Optional[np.ndarray]
    restitution: float
    amplitude: np.ndarray
    frequency: Optional[Tuple[float, float]]
    harmonic: np.ndarray


def forcing_of(raw) -> dict:
    """Force, damping and restitution of a structure of the library; None where there is none."""
    force = copy_of(raw.force, raw.n_force) if raw.n_force else None
    damping = copy_of(raw.ratios, raw.n_ratio) if raw.n_ratio else None
    if raw.n_matrix:
        damping = copy_of(raw.matrix, raw.n_matrix**2).reshape(raw.n_matrix, -1)
    return {"force": force, "damping": damping, "restitution": raw.restitution}


def fill_shaking(raw, force, damping, restitution: float) -> list:
    """Fills a structure of the library; returns what has to live as long as it."""
    keep = [np.ascontiguousarray(force, float).ravel()] if force is not None else []
    if keep:
        raw.n_force, raw.force = keep[0].size, pointer(keep[0])
    raw.restitution = restitution
    losses = None if damping is None else np.ascontiguousarray(np.atleast_1d(damping), float)
    if losses is not None and losses.ndim == 2:
        if losses.shape[0] != losses.shape[1]:
            raise ValueError(f"damping of shape {losses.shape}: one ratio, one for each mode, or a square matrix")
        raw.n_matrix, raw.matrix = len(losses), pointer(losses)
    elif losses is not None:
        raw.n_ratio, raw.ratios = losses.size, pointer(losses)
    return [*keep, losses]


def completed(study, force, damping, restitution) -> dict:
    """What is given, and what is None as the study has it."""
    own = study.forcing
    if own is not None:
        force = own.force if force is None else force
        damping = own.damping if damping is None else damping
        restitution = own.restitution if restitution is None else restitution
    return {"force": force, "damping": damping, "restitution": 1.0 if restitution is None else restitution}


@dataclass
class Prediction:
    """What first order says of an orbit under a harmonic force and small losses.

    energy, scaled, and frequency, rad/s, of the orbit; harmonic m; omega = m frequency, of the force; loss_damping and
    loss_impacts, per period, scaled energies; work, complex, the scaled work of a force of amplitude 1; threshold, least
    physical amplitude, and threshold_impacts, what impacts lose of it; phases [0 or 2] of the force at the state of the
    orbit, rad; stable, of the first, yes, no or undecided; slope dT/dE; estimate of the next order and error of
    quadratures, relative; trusted, and why not.
    """

    energy: float
    frequency: float
    harmonic: int
    omega: float
    loss_damping: float
    loss_impacts: float
    work: complex
    threshold: float
    threshold_impacts: float
    phases: np.ndarray
    stable: str
    slope: float
    estimate: float
    error: float
    trusted: bool
    why: str


@dataclass
class Forced:
    """An exact forced orbit.

    omega of the force, rad/s; phase of the force at the state, rad; state [2 n_dof], x then v, scaled, right after the
    first impact; flights [max(letters, 1)], s; multipliers, complex [2 n_dof], of all modes over a period, and largest,
    the modulus of the largest; stable, yes, no or undecided; residual and distance from the orbit of the atlas, relative;
    fault, why there is no such orbit, "" where there is one: elsewhere nothing else holds.
    """

    omega: float
    phase: float
    residual: float
    distance: float
    largest: float
    stable: str
    fault: str
    state: np.ndarray = field(repr=False)
    flights: np.ndarray = field(repr=False)
    multipliers: np.ndarray = field(repr=False)

    def __bool__(self) -> bool:
        return not self.fault


class Shaking:
    """An atlas under a harmonic force f cos(omega t + phase) and losses; `Atlas.shaking` makes it.

    Attributes
    ----------
    atlas : Atlas
    force : array [n_dof], physical, of amplitude 1
    """

    def __init__(self, atlas, given: dict):
        self.atlas, self.force = atlas, given["force"]
        if self.force is None:
            raise InputError("force is missing: the vector f, one number per displacement; the study has no section forcing")
        self.force = np.ascontiguousarray(self.force, float).ravel()
        raw = ffi.new("ric_shaking *")
        self._keep = fill_shaking(raw, self.force, given["damping"], given["restitution"])
        made = ffi.new("ric_force **")
        check(lib.ric_force_create(atlas._handle, raw, made))
        self._handle = ffi.gc(made[0], lib.ric_force_free)

    def predict(self, orbit, harmonic: int = 1, level: float = 0) -> Prediction:
        """What first order says of an orbit of the atlas.

        Parameters
        ----------
        orbit : Orbit
        harmonic : int
            The force has so many periods in one of the orbit.
        level : float
            Physical amplitude; 0: that of the threshold.
        """
        raw = ffi.new("ric_prediction *")
        check(lib.ric_force_predict(self._handle, orbit.branch.id, orbit._handle, harmonic, level, raw))
        said = fields_of(raw[0])
        said["phases"] = np.array(said["phases"][:said.pop("n_phase")])
        said["work"], said["stable"] = complex(*said["work"]), _STABLE[said["stable"]]
        return Prediction(**{name: said[name] for name in Prediction.__dataclass_fields__})

    def solve(self, orbit, harmonic: int = 1, level: float = 0, phase: Optional[float] = None) -> Forced:
        """The exact forced orbit that Newton's method finds from an orbit and a phase.

        Parameters
        ----------
        orbit : Orbit
        harmonic : int
        level : float
            Physical amplitude.
        phase : float, rad
            Of the force at the state of the orbit; unless given, the first one that is predicted.
        """
        if phase is None:
            told = self.predict(orbit, harmonic, level).phases
            if not len(told):
                return Forced(*[np.nan] * 5, "undecided", "the level is below the threshold", *[np.empty(0)] * 3)
            phase = told[0]
        raw, n = ffi.new("ric_forced *"), self.atlas.model.n_dof
        state, flights, multipliers = np.zeros(2 * n), np.zeros(len(orbit.flights)), np.zeros(4 * n)
        check(lib.ric_force_solve(self._handle, orbit._handle, harmonic, level, phase, raw, pointer(state), pointer(flights),
                                  pointer(multipliers)))
        numbers = {name: getattr(raw, name) for name in ("omega", "phase", "residual", "distance", "largest")}
        return Forced(**numbers, stable=_STABLE[raw.stable], fault=text_of(raw.fault), state=state, flights=flights,
                      multipliers=multipliers.view(complex))

    def __repr__(self) -> str:
        return f"Force {self.force.tolist()} cos(omega t + phase) on {self.atlas.study.title or self.atlas.path}"
