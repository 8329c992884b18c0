"""Studies: a model with the windows and budgets of its exploration."""
from __future__ import annotations

import json
import os
import re
import time
from typing import Callable, NamedTuple, Optional, Union

from ._library import InputError, Interrupted, check, copy_of, ffi, fields_of, lib, text_of
import numpy as np

from ._atlas import Atlas
from ._force import Forcing, forcing_of
from ._model import Model
from ._running import Bar, Job


class Study:
    """A model, and what is to be explored of it.

    Parameters
    ----------
    model : Model
    title : str
    names : list of dicts with name, kind, energy and frequency, for junctions
    regions : list of dicts, parts of the plane with larger budgets
    tolerance : float, relative
    damping, restitution, forcing, vary, drawing, units
        What the structure loses, what shakes it, a parameter of it, where it is, and what its units are called, as these keys
        are in a study file (docs/study.md): units={"length": "mm", "force": "N"}, damping=0.01, forcing={"vector": [1, 0], "amplitude": 0.2, "frequency": [0.5, 2]}, vary={"name": "k2",
        "at": 1, "from": 0.5, "to": 2, "stiffness": [[1, -1], [-1, 1]]}. The atlas is that of the structure without losses and
        force.
    explore
        Windows and budgets by the names that they have in a study file (docs/study.md): energy=[0, 20] (scaled),
        frequency=[0.2, 10] (rad/s), impacts=6, multiply=2, depth=3, start=[1, 2], at_energy=[1.5], step=0.03, ...
        What is not given is as in a file that does not say it.

    `Study.read(path)` takes a study file instead.
    """

    def __init__(self, model: Model, title: Optional[str] = None, *, names=None, regions=None, tolerance=None,
                 damping=None, restitution: Optional[float] = None, forcing: Optional[dict] = None, vary: Optional[dict] = None,
                 drawing: Optional[dict] = None, units: Optional[dict] = None, **explore):
        if not isinstance(model, Model):
            raise InputError(f"a study is made of a Model, not of {type(model).__name__}; Study.read(path) reads a file")
        out = ffi.new("ric_study **")
        check(lib.ric_study_create(model._handle, ffi.NULL, (title or "A structure").encode(), out))
        bare = ffi.gc(out[0], lib.ric_study_free)
        keys = {"names": names, "regions": regions, "tolerance": tolerance, "explore": explore or None, "damping": damping,
                "restitution": restitution, "forcing": forcing, "vary": vary, "drawing": drawing, "units": units}
        text = _with_keys(text_of(lib.ric_study_text(bare)), {key: value for key, value in keys.items() if value is not None})
        check(lib.ric_study_parse(text.encode(), b"study", b".", out))
        self._take(ffi.gc(out[0], lib.ric_study_free), None)

    def _take(self, handle, owner) -> Study:
        self._handle, self._owner = handle, owner
        return self

    @classmethod
    def read(cls, path: Union[str, os.PathLike]) -> Study:
        """The study of a file; an InputError has its line, its key, what is wrong and what would be right."""
        out = ffi.new("ric_study **")
        check(lib.ric_study_read(os.fsencode(path), out))
        return cls.__new__(cls)._take(ffi.gc(out[0], lib.ric_study_free), None)

    @classmethod
    def parse(cls, text: str, base: str = ".") -> Study:
        """The study of a text; files that it names are looked for in the folder `base`."""
        out = ffi.new("ric_study **")
        check(lib.ric_study_parse(text.encode(), b"study", os.fsencode(base), out))
        return cls.__new__(cls)._take(ffi.gc(out[0], lib.ric_study_free), None)

    @classmethod
    def _borrow(cls, handle, owner) -> Study:
        return cls.__new__(cls)._take(ffi.cast("ric_study *", handle), owner)

    @property
    def title(self) -> str:
        """What it is called."""
        return text_of(lib.ric_study_title(self._handle))

    @property
    def text(self) -> str:
        """The whole study as a text that `ricochet run` takes."""
        return text_of(lib.ric_study_text(self._handle))

    @property
    def model(self) -> Model:
        """The structure."""
        return Model._borrow(lib.ric_study_model(self._handle), self)

    @property
    def options(self) -> dict:
        """Windows and budgets in force, by their names in the library."""
        return fields_of(lib.ric_study_options(self._handle)[0])

    @property
    def forcing(self) -> Optional[Forcing]:
        """Its keys damping, restitution and forcing; None where it has none of them."""
        raw = ffi.new("ric_forcing *")
        if not lib.ric_study_forcing(self._handle, raw):
            return None
        window = tuple(raw.frequency) if raw.frequency[1] > 0 else None
        return Forcing(**forcing_of(raw.shaking), amplitude=_numbers(raw.amplitude), frequency=window,
                       harmonic=_numbers(raw.harmonic).astype(np.intc))

    @property
    def vary(self) -> Optional[dict]:
        """Its parameter: name, at, from and to, and mass and stiffness [n_dof, n_dof] and clearance [n_contact], what grows
        with it, None where nothing does; None without section vary."""
        raw, n = ffi.new("ric_vary *"), self.model.n_dof
        if not lib.ric_study_vary(self._handle, raw):
            return None
        out = fields_of(raw[0])
        for name, shape in (("mass", (n, n)), ("stiffness", (n, n)), ("clearance", (len(self.model.contacts),))):
            given = getattr(raw, name)
            out[name] = copy_of(given, int(np.prod(shape))).reshape(shape) if given != ffi.NULL else None
        return out

    def _explored(self) -> str:
        return re.search(r"^explore:\n(?: .*\n)*", self.text, re.MULTILINE)[0]

    def _losses(self) -> str:
        """The keys of losses, force and parameter, as they stand in the text."""
        found = re.findall(r"^(?:damping|restitution|forcing|vary):.*\n(?: .*\n)*", self.text, re.MULTILINE)
        return "".join(found)

    def __repr__(self) -> str:
        return f"Study '{self.title}'\n{self.model!r}\n{self._explored()}{self._losses()}".rstrip()

    def _repr_html_(self) -> str:
        import html
        return (f"<b>{html.escape(self.title)}</b>{self.model._repr_html_()}"
                f"<pre>{html.escape(self._explored() + self._losses())}</pre>")


def _numbers(raw) -> np.ndarray:
    return copy_of(raw.value, raw.n)


def _plain(value):
    """What JSON can write; numbers of NumPy become those of Python, which are written with all their digits."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (tuple, range)):
        return list(value)
    raise TypeError(f"{value!r} has no place in a study")


def _with_keys(text: str, keys: dict) -> str:
    """The text of a study with other values of some of its keys, written as JSON, which is YAML."""
    for key in keys:
        text = re.sub(rf"^{key}:.*\n(?:[ #-].*\n|\n)*", "", text, flags=re.MULTILINE)
    return text + "".join(f"{key}: {json.dumps(value, default=_plain)}\n" for key, value in keys.items())


# ------------------------------------------------------------------ exploring


class Progress(NamedTuple):
    """How far an exploration is."""

    branches: int
    junctions: int
    open: int        # departures that are not taken yet
    depth: int
    labels: int      # at the end: junctions whose label is still to be measured
    seconds: float


_SHARE = 1.25  # a run with a limit lasts at least so many times as long as it takes to come to something new


class _Run:
    """What the library and the thread that waits know of each other."""

    def __init__(self, seconds):
        self.now = Progress(0, 0, 0, 0, 0, 0.0)
        self.seconds, self.start, self.news, self.over = seconds, time.monotonic(), 0.0, False

    def report(self, job: Job, now) -> bool:
        """Called by the library; True stops it."""
        passed = time.monotonic() - self.start
        self.now = Progress(now.branches, now.junctions, now.open, now.depth, now.labels, now.seconds)
        if now.fresh and not self.news:
            self.news = passed
        if self.seconds is not None and now.fresh and passed > max(self.seconds, _SHARE * self.news):
            self.over = True
        return self.over or job.stopping


def _run_study(study: Study, path, workers: int, run: _Run):
    def call(job: Job) -> int:
        told = ffi.callback("bool(const ric_progress *, void *)", lambda now, user: run.report(job, now[0]), error=True)
        options = ffi.new("ric_run_options *", {"workers": workers, "progress": told})
        return lib.ric_explore(study._handle, os.fsencode(path), options)
    return Job(call)


def explore(study: Union[Study, str, os.PathLike], path: Union[str, os.PathLike], workers: int = 1,
            progress: Union[None, bool, Callable[[Progress], Optional[bool]]] = None,
            seconds: Optional[float] = None) -> Atlas:
    """Explores a study into the atlas file `path`, which is created, continued or extended.

    Ctrl-C (or the stop button of a notebook) keeps what was done: it is in the file when KeyboardInterrupt is raised,
    and the same call goes on from there and ends with the same atlas, whatever the number of workers.

    Parameters
    ----------
    study : Study, or the path of a study file
    path : str
    workers : int
        Departures that are prepared at a time.
    progress : None, bool or callable
        None shows a bar on a terminal and in a notebook. A callable is given a Progress about ten times a second;
        what it returns, if true, stops the run.
    seconds : float
        Stop after that time, with what there is; `Atlas.finished` tells.

    Returns
    -------
    Atlas
    """
    study = study if isinstance(study, Study) else Study.read(study)
    run = _Run(seconds)
    job = _run_study(study, path, workers, run)
    bar = Bar(progress if not callable(progress) else False)
    asked = [False]

    def look():
        now = run.now
        text = f"{now.labels} labels left" if now.labels else f"{now.open} open departures, depth {now.depth}"
        bar.show(now.branches / max(1, now.branches + now.open),
                 f"{now.branches} branches, {now.junctions} junctions, {text}, {now.seconds:.0f} s")
        if callable(progress) and progress(now):
            asked[0] = job.stopping = True

    try:
        _until_stopped(job, look, lambda: run.over or asked[0])
        atlas = Atlas(path)
    except BaseException:
        bar.close(f"{run.now.branches} branches, {run.now.junctions} junctions")
        raise
    bar.close(f"{len(atlas.branches)} branches, {len(atlas.junctions)} junctions")
    return atlas


def _until_stopped(job: Job, look, wanted) -> None:
    """Runs a job; that it was stopped is no error where that is what was wanted."""
    try:
        job.run(look)
    except Interrupted:
        if not wanted():
            raise
