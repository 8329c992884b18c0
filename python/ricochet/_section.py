"""Motions of one energy on a section, and their exponents."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional

from ._library import check, ffi, fields_of, lib, pointer
import numpy as np

from ._running import Bar, Job
from ._show import table, text_table

_HEADING = ["start", "face", "impacts", "time", "rotation", "lyapunov", "lyapunov error", "ended early"]
_NUMBERS = ("time", "rotation", "rotation_error", "lyapunov", "lyapunov_error", "energy_error")


@dataclass
class Track:
    """What came of one start on a section.

    face, where it begins; impacts, how many; time, s, of the last one; rotation, mean turns of neighbours per impact, in
    [0, 1), NaN where neighbours part exponentially and unless two modes are seen; lyapunov, per second; both with what
    they may be off by; energy_error, relative; why it ended before its time, "". With rows kept also of each impact
    times [k], s; faces [k]; x and v [k, n_dof], scaled, right after it; places [k, 2 (n_mode - 1)] on the section:
    displacements, then momenta, in a ball of radius 1 whose volume the map preserves.
    """

    start: int
    face: int
    impacts: int
    time: float
    rotation: float
    rotation_error: float
    lyapunov: float
    lyapunov_error: float
    energy_error: float
    why: str
    times: np.ndarray = field(default=None, repr=False)
    faces: np.ndarray = field(default=None, repr=False)
    x: np.ndarray = field(default=None, repr=False)
    v: np.ndarray = field(default=None, repr=False)
    places: np.ndarray = field(default=None, repr=False)

    def _row(self) -> list:
        return [self.start, self.face, self.impacts, self.time, self.rotation, self.lyapunov, self.lyapunov_error, self.why]


class Section(list):
    """The tracks, one for each start, of one scaled `energy`."""

    def __init__(self, tracks, model, energy: float):
        super().__init__(tracks)
        self.model, self.energy = model, energy

    def column(self, name: str) -> np.ndarray:
        """[len] a number of all tracks."""
        return np.array([getattr(one, name) for one in self])

    def _head(self) -> str:
        return f"{len(self)} motions of energy {self.energy:g}"

    def __repr__(self) -> str:
        return self._head() + ("\n" + text_table(_HEADING, [one._row() for one in self]) if self else "")

    def _repr_html_(self) -> str:
        return table(_HEADING, [one._row() for one in self], self._head())


def _track(handle, model, i: int, rows: bool) -> Track:
    raw = ffi.new("ric_section_track *")
    check(lib.ric_section_track_at(handle, i, raw))
    said = fields_of(raw[0])
    out = Track(i + 1, said["face"], said["impacts"], why=said["why"], **{name: said[name] for name in _NUMBERS})
    if rows:
        _fill(handle, model, i, out)
    return out


def _fill(handle, model, i: int, out: Track) -> None:
    """The impacts of a track, copied once."""
    k, n, width = out.impacts, model.n_dof, 2 * (model.n_mode - 1)
    out.times, out.faces = np.zeros(k), np.zeros(k, np.intc)
    out.x, out.v, out.places = np.zeros((k, n)), np.zeros((k, n)), np.zeros((k, width))
    doubles, ints = {name: ffi.cast("double *", pointer(getattr(out, name))) if getattr(out, name).size else ffi.NULL
                     for name in ("times", "x", "v", "places")}, ffi.cast("int *", pointer(out.faces))
    for row in range(k):
        x, v = doubles["x"] + row * n, doubles["v"] + row * n
        check(lib.ric_section_impact(handle, i, row, doubles["times"] + row, ints + row, x, v))
        if width:
            check(lib.ric_section_place(handle, ints[row], x, v, doubles["places"] + row * width))


def _options(model, energy: float, starts, impacts, states, radius: float, rows: bool, workers: int):
    options, given = ffi.new("ric_section_options *"), None
    lib.ric_section_options_init(options)
    options.energy, options.rows, options.workers, options.radius = energy, rows, workers, radius
    if starts is not None:
        options.starts = starts
    if impacts is not None:
        options.impacts = impacts
    if states is not None:
        given = np.ascontiguousarray(np.atleast_2d(states), float)
        if given.shape[1] != 2 * model.n_dof:
            raise ValueError(f"states of {given.shape[1]} numbers: x, then v, are {2 * model.n_dof}")
        options.n_given, options.given = len(given), pointer(given)
    return options, given


def section(model, energy: float, starts: Optional[int], impacts: Optional[int], states, radius: float, rows: bool,
            workers: int, progress) -> Section:
    """As the command `section` does it."""
    options, given = _options(model, energy, starts, impacts, states, radius, rows, workers)
    made, part = ffi.new("ric_section **"), [0.0]

    def call(job: Job) -> int:
        def told(share, user):
            part[0] = share
            return job.stopping
        options.progress = job.told = ffi.callback("bool(double, void *)", told, error=True)
        check(lib.ric_section_create(model._handle, options, made))
        return lib.ric_section_run(made[0])

    bar = Bar(progress)
    try:
        Job(call).run(lambda: bar.show(part[0], f"{100 * part[0]:.0f} %"))
        return Section([_track(made[0], model, i, rows) for i in range(lib.ric_section_n_start(made[0]))], model, energy)
    finally:
        bar.close()
        lib.ric_section_free(made[0])
