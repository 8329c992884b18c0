"""Curves of exact forced orbits."""
from __future__ import annotations

import os
import time
from dataclasses import dataclass
from functools import partial
from typing import List, Optional, Union

from ._library import check, column_of, copy_of, ffi, fields_of, lib, pointer, text_of, word_of
import numpy as np

from ._force import fill_shaking, forcing_of
from ._model import Model
from ._running import Bar, Job, with_bar
from ._show import curve, table, text_table

_ALONG = {"omega": lib.RIC_RESPONSE_OMEGA, "level": lib.RIC_RESPONSE_LEVEL, "restitution": lib.RIC_RESPONSE_RESTITUTION}
_STABLE = {lib.RIC_STABLE_YES: "yes", lib.RIC_STABLE_NO: "no", lib.RIC_STABLE_UNDECIDED: "undecided"}
_PLACES = 5  # of each curve that are replayed, unless all are asked for
_CHECKS = ["curve", "point", "flight error", "return error", "multiplier error", "faces agree"]


class ResponseCurve:
    """A curve of periodic motions of the damped and shaken structure.

    Attributes
    ----------
    id : int, from 1
    word : str
        Faces that are hit in one period of the motion, "" without impacts.
    impacts, letters : int
    periods : int
        Of the force, in one of the motion.
    level : float
        Physical amplitude of the force where that does not vary, else NaN.
    branch : int or None
        That of the atlas beside which it was begun.
    begins, ends : str
        grazing, window, budget, closed, event (of another curve) or failed.

    The numbers of its points are arrays [n_point]: arclength, omega (rad/s), level (physical), restitution, period (s),
    phase (of the force at the state, rad), residual (relative), largest (modulus of the largest multiplier), reach (gap over
    clearance), approach (scaled speed, 1/s); stable and undecided (bool); state [n_point, 2 n_dof], scaled, flights [n_point,
    max(letters, 1)], s, multipliers, complex [n_point, 2 n_dof], peak and rms of displacements [n_point, n_dof], scaled. They
    are read once, by one copy, and cannot be written to.
    """

    _HEADING = ["id", "word", "periods", "level", "points", "lowest", "highest", "stable share", "begins", "ends"]

    def __init__(self, response: Response, number: int):
        self.response, self._columns = response, {}
        raw = ffi.new("ric_response_curve *")
        check(lib.ric_response_curve_at(response._handle, number, raw))
        self.id, self.impacts, self.letters, self.periods, self.level = raw.id, raw.impacts, raw.letters, raw.harmonic, raw.level
        self.word = word_of(response.model._handle, raw.letters, raw.word)
        self.branch, self._points = raw.branch or None, raw.n_point
        self._ends = getattr(raw, "from") or None, raw.to or None
        self.begins, self.ends = (text_of(lib.ric_response_stop_text(stop)) for stop in (raw.begin, raw.end))

    def __len__(self) -> int:
        return self._points

    def _column(self, name: str, wide: bool = False) -> np.ndarray:
        if name not in self._columns:
            read = partial(lib.ric_response_column, self.response._handle, self.id)
            self._columns[name] = column_of(read, len(self), name, wide)
        return self._columns[name]

    arclength = property(lambda self: self._column("arclength"), doc="[n_point]")
    omega = property(lambda self: self._column("omega"), doc="[n_point] frequency of the force, rad/s")
    levels = property(lambda self: self._column("level"), doc="[n_point] physical amplitude of the force")
    restitution = property(lambda self: self._column("restitution"), doc="[n_point]")
    period = property(lambda self: self._column("period"), doc="[n_point], s")
    phase = property(lambda self: self._column("phase"), doc="[n_point] of the force at the state, rad")
    residual = property(lambda self: self._column("residual"), doc="[n_point] relative")
    largest = property(lambda self: self._column("largest"), doc="[n_point] modulus of the largest multiplier")
    reach = property(lambda self: self._column("reach"), doc="[n_point] largest gap over clearance in flight; NaN below a half")
    approach = property(lambda self: self._column("approach"), doc="[n_point] least speed at an event, scaled, 1/s; NaN without")
    state = property(lambda self: self._column("state", True), doc="[n_point, 2 n_dof] x, then v (1/s), scaled, right after the first event, at phase 0 without events")
    flights = property(lambda self: self._column("flights", True), doc="[n_point, max(letters, 1)], s")
    peak = property(lambda self: self._column("peak", True), doc="[n_point, n_dof] largest |x|, scaled")
    rms = property(lambda self: self._column("rms", True), doc="[n_point, n_dof] of x, scaled")

    @property
    def multipliers(self) -> np.ndarray:
        """[n_point, 2 n_dof] complex, of the map over a period."""
        return self._column("multipliers", True).view(complex)

    @property
    def stable(self) -> np.ndarray:
        """[n_point] bool; what is not stable is unstable or undecided."""
        return self._column("stable") == lib.RIC_STABLE_YES

    @property
    def undecided(self) -> np.ndarray:
        """[n_point] bool: on the border within rounding."""
        return self._column("stable") == lib.RIC_STABLE_UNDECIDED

    @property
    def varies(self) -> np.ndarray:
        """[n_point] what the response is along: omega, level or restitution."""
        return self._column(self.response.along)

    @property
    def events(self) -> tuple:
        """The events at its first and at its last point, None where there is none."""
        return tuple(self.response.events[i - 1] if i else None for i in self._ends)

    def _row(self) -> list:
        given, share = self.varies, float(np.mean(self.stable)) if len(self) else np.nan
        return [self.id, self.word, self.periods, self.level, len(self), float(given.min(initial=np.inf)),
                float(given.max(initial=-np.inf)), share, self.begins, self.ends]

    def __repr__(self) -> str:
        row = self._row()
        return (f"Curve {self.id} of word '{self.word}', {self.impacts} impacts in {self.periods} "
                f"period{'s' * (self.periods != 1)} of the force: {len(self)} points, {self.response.along} {row[5]:.6g} to "
                f"{row[6]:.6g}, stable share {row[7]:.3g}, from {self.begins} to {self.ends}")

    def _repr_html_(self) -> str:
        return table(self._HEADING, [self._row()]) + curve(self.varies, self.peak.max(axis=1, initial=0), self.stable, 240, 90)


@dataclass
class ResponseEvent:
    """A place on a curve where its motions change.

    kind: fold, branch-point, doubling, neimark-sacker or grazing; curve, its id; omega, rad/s; level, physical; restitution;
    period, s; phase, rad, of the force at the state; residual, relative; largest, modulus of the largest multiplier; reach;
    approach; stable, yes, no or undecided; arclength; state [2 n_dof], x then v, scaled; flights [max(letters, 1)], s;
    multipliers, complex [2 n_dof]; peak and rms [n_dof], scaled.
    """

    id: int
    kind: str
    curve: int
    arclength: float
    omega: float
    level: float
    restitution: float
    period: float
    phase: float
    residual: float
    largest: float
    reach: float
    approach: float
    stable: str
    state: np.ndarray
    flights: np.ndarray
    multipliers: np.ndarray
    peak: np.ndarray
    rms: np.ndarray

    def _row(self) -> list:
        return [self.id, self.kind, self.curve, self.omega, self.level, self.restitution, self.stable]

    def __repr__(self) -> str:
        return (f"Event {self.id} of curve {self.curve}: {self.kind} at {self.omega:.10g} rad/s, level {self.level:.10g}, "
                f"restitution {self.restitution:.10g}")


class ResponseCheck(dict):
    """A replay: curve, point, flight_error, return_error, multiplier_error, faces_agree and passed, by their names."""

    __getattr__ = dict.__getitem__


class ResponseChecks(list):
    """Replays of a response, in the order of curves. True if all have passed."""

    def __bool__(self) -> bool:
        return all(one["passed"] for one in self)

    def __repr__(self) -> str:
        wrong = [list(one.values())[:-1] for one in self if not one["passed"]]
        return (f"{len(self) - len(wrong)} of {len(self)} orbits are confirmed by the simulator" +
                ("\n" + text_table(_CHECKS, wrong) if wrong else ""))


class Response:
    """A file of `ricochet response`, or of `Atlas.response`.

    It is read as a whole when it is opened.

    Parameters
    ----------
    path : str

    Attributes
    ----------
    curves : list of ResponseCurve
        curves[0].id is 1.
    events : list of ResponseEvent
    along : str
        What varies: omega, level or restitution.
    finished : bool
        False if the run was stopped; the same call once more goes on.
    """

    def __init__(self, path: Union[str, os.PathLike]):
        out = ffi.new("ric_response **")
        check(lib.ric_response_read(os.fsencode(path), out))
        self.path, self._handle = os.fspath(path), ffi.gc(out[0], lib.ric_response_free)
        self.model = Model._borrow(lib.ric_response_model(self._handle), self._handle)
        asked = lib.ric_response_asked(self._handle)
        self.along = next(name for name, value in _ALONG.items() if value == asked.along)
        self.finished = lib.ric_response_finished(self._handle)
        self.curves = [ResponseCurve(self, i + 1) for i in range(lib.ric_response_n_curve(self._handle))]
        self.events = [self._event(i + 1) for i in range(lib.ric_response_n_event(self._handle))]

    def _event(self, number: int) -> ResponseEvent:
        raw, n = ffi.new("ric_response_event *"), self.model.n_dof
        check(lib.ric_response_event_at(self._handle, number, raw))
        said = fields_of(raw.at)
        said["stable"] = _STABLE[said["stable"]]
        widths = {"state": 2 * n, "flights": max(1, self.curves[raw.curve - 1].letters), "multipliers": 4 * n, "peak": n, "rms": n}
        said.update({name: copy_of(getattr(raw.at, name), width) for name, width in widths.items()})
        said["multipliers"] = said["multipliers"].view(complex)
        return ResponseEvent(raw.id, text_of(lib.ric_response_kind_text(raw.kind)), raw.curve, **said)

    @property
    def asked(self) -> dict:
        """What was asked for: along, window, omega, level [k], harmonic [k], force [n_dof], damping and restitution, as
        `Study.forcing` has them, branch, impacts, periods, points, curves and step."""
        raw = lib.ric_response_asked(self._handle)
        said = {name: value for name, value in fields_of(raw[0]).items() if not name.startswith("n_")}
        said.update(along=self.along, level=copy_of(raw.levels, raw.n_level), branch=raw.branch or None,
                    harmonic=copy_of(raw.harmonics, raw.n_harmonic, np.intc), **forcing_of(raw.shaking))
        return said

    def __len__(self) -> int:
        return len(self.curves)

    def __iter__(self):
        return iter(self.curves)

    def verify(self, all: bool = False, workers: int = 1, progress: Optional[bool] = None) -> ResponseChecks:
        """Replays orbits with the simulator of motions under damping and force, which shares nothing with the solver.

        Parameters
        ----------
        all : bool
            Every point, instead of some of each curve.
        workers : int
        """
        calls = [partial(self._replay, one.id, i) for one in self.curves for i in _sample(len(one), all)]
        return ResponseChecks(with_bar(calls, workers, progress, " replayed"))

    def _replay(self, number: int, i: int) -> ResponseCheck:
        raw = ffi.new("ric_response_checked *")
        check(lib.ric_response_check_point(self._handle, number, i, raw))
        return ResponseCheck(curve=number, point=i, **fields_of(raw[0]))

    def _head(self) -> str:
        return (f"Response {self.path} along {self.along}: {len(self.curves)} curves, {len(self.events)} events"
                f"{'' if self.finished else ', not finished'}")

    def __repr__(self) -> str:
        if not self.curves:
            return self._head() + ": no forced orbit was found in the window"
        return self._head() + "\n" + text_table(ResponseCurve._HEADING, [one._row() for one in self.curves])

    def _repr_html_(self) -> str:
        return table(ResponseCurve._HEADING, [one._row() for one in self.curves], self._head())


def _sample(n: int, everything: bool) -> List[int]:
    """Points that the command `verify` replays."""
    return [i for i in range(n) if everything or i in (0, n - 1) or i * _PLACES // n != (i - 1) * _PLACES // n]


def _window(given, name: str) -> tuple:
    values = np.atleast_1d(np.asarray(given if given is not None else [], float))
    if values.size != 2:
        raise ValueError(f"{name} varies and takes a window, (low, high)")
    return tuple(values)


def _number(given, name: str) -> float:
    values = np.atleast_1d(np.asarray(given if given is not None else [], float))
    if values.size != 1:
        raise ValueError(f"{name} does not vary and takes one number")
    return float(values[0])


def _options(along: str, omega, level, shaking: dict, harmonic, rest: dict):
    """The options, and what they borrow."""
    if along not in _ALONG:
        raise ValueError(f"along={along!r}: what varies is omega, level or restitution")
    out = ffi.new("ric_response_options *")
    lib.ric_response_defaults(out)
    restitution = shaking["restitution"]
    given = {"omega": omega, "level": level, "restitution": restitution}[along]
    out.along, out.window = _ALONG[along], _window(given, along)
    last = float(np.atleast_1d(restitution)[-1]) if along == "restitution" else _number(restitution, "restitution")
    keep = fill_shaking(out.shaking, shaking["force"], shaking["damping"], last)
    if along != "omega":
        out.omega = _number(omega, "omega")
    if along != "level":
        levels = np.ascontiguousarray(np.atleast_1d(level if level is not None else []), float)
        out.n_level, out.levels = levels.size, pointer(levels)
        keep.append(levels)
    harmonics = np.ascontiguousarray(np.atleast_1d(harmonic), np.intc)
    out.n_harmonic, out.harmonics = harmonics.size, pointer(harmonics)
    for name, value in rest.items():
        if value is not None:
            setattr(out, name, value)
    return out, [*keep, harmonics]


def respond(atlas, path, along: str, omega, level, shaking: dict, harmonic, progress, rest: dict) -> Response:
    """As the command `response` does it."""
    options, keep = _options(along, omega, level, shaking, harmonic, rest)
    new = not os.path.lexists(path)
    bar, began = Bar(progress), time.monotonic()

    def call(job: Job) -> int:
        job.told = ffi.callback("bool(void *)", lambda user: job.stopping, error=True)
        return lib.ric_response_run(atlas._handle, options, os.fsencode(path), job.told, ffi.NULL)

    try:
        Job(call).run(lambda: bar.show(0, f"{time.monotonic() - began:.0f} s"))
    finally:
        bar.close()
        del keep
    found = Response(path)
    if new and found.finished and not found.curves:
        os.unlink(path)
    return found
