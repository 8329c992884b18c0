"""Atlases: branches, and the junctions where they meet."""
from __future__ import annotations

import difflib
import os
from functools import partial
from typing import Iterator, List, NamedTuple, Optional, Sequence, Tuple, Union

from ._library import InputError, RangeError, check, column_of, copy_of, ffi, fields_of, lib, pointer, text_of, word_of
import numpy as np

from ._model import Model
from ._orbit import Orbit
from ._show import Markup, curve, table, text_table

_AT_A_TIME = 2000  # points whose multipliers are computed between two looks for Ctrl-C


class Listing(tuple):
    """Branches or junctions in the order of their ids: a tuple that shows itself as a table.

    `column("energy_min")` is an array with one number of all of them.
    """

    def column(self, name: str) -> np.ndarray:
        """[len] an attribute of all of them."""
        return np.array([getattr(one, name) for one in self])

    def _rows(self, markup: bool) -> list:
        return [one._row(markup) for one in self]

    def __repr__(self) -> str:
        return text_table(self[0]._HEADING, self._rows(False)) if self else "none"

    def _repr_html_(self) -> str:
        return table(self[0]._HEADING + [""], self._rows(True)) if self else "none"


class Tongue(NamedTuple):
    """An internal resonance along a branch: a linear mode turns `turns` times while the motion goes round `per` times."""

    mode: int
    """from 1"""
    turns: int
    per: int
    crossed: bool
    """stepped over: a gap between the points `first` and `last`"""
    others: int
    """narrower ones that were stepped over with it"""
    first: int
    """the point of the branch at which it begins"""
    last: int
    """and ends"""
    energy: Tuple[float, float]
    """at both, scaled"""
    frequency: Tuple[float, float]
    """at both, rad/s"""


class Junction:
    """A place where branches meet, or where one has an extremum.

    Attributes
    ----------
    id : int, from 1
    kind : start, grazing, corner, extremum, branch-point, multiplication, period-extremum or user
    key : str, stays the same whatever the budgets
    label : str, such as G1_2,4 or C1_32; name : str, from the study
    energy : float, scaled; frequency : float, rad/s, where it is drawn (omega / q of a q-tupling)
    impacts, letters, grazings : int
    multiple : int, q of a q-tupling, else 1
    rotation : (p, q) or None
    a, b : int or None
        Multiplicities of the article's C_ab; `decided` whether they are measured.
    refusal : str
        Why departures were refused.
    proved : bool
        By a proof that `ricochet prove --junctions` has kept in the file.
    """

    _HEADING = ["id", "label", "name", "kind", "energy", "frequency", "branches", "open departures"]

    def __init__(self, atlas: Atlas, number: int):
        self.atlas, self._raw = atlas, ffi.new("ric_junction *")
        check(lib.ric_atlas_junction(atlas._handle, number, self._raw))
        self.__dict__.update({name: value for name, value in fields_of(self._raw[0]).items() if name != "n_branch"})
        self.kind = text_of(lib.ric_kind_text(self._raw.kind))
        self.rotation = tuple(self.rotation) if self.rotation[1] else None
        if not (self.a or self.b):
            self.a = self.b = self.decided = None

    def level(self, branch: "Branch") -> int:
        """Which duplicate of a branch passes here: q for the branch that a q-tupling lies on, 1 for what leaves there."""
        return lib.ric_junction_level(self._raw, branch._raw)

    @property
    def word(self) -> str:
        """Faces that the orbit hits in one period."""
        return word_of(self.atlas.model._handle, self.letters, self._raw.word)

    @property
    def state(self) -> np.ndarray:
        """[2 n_dof] x, then v (1/s), scaled, of the original orbit right after its first impact."""
        return copy_of(self._raw.state, 2 * self.atlas.model.n_dof)

    @property
    def flights(self) -> np.ndarray:
        """[max(letters, 1)], s."""
        return copy_of(self._raw.flights, max(1, self.letters))

    @property
    def branches(self) -> Listing:
        """The branches that end at it or pass it."""
        ids = copy_of(self._raw.branches, self._raw.n_branch, np.intc)
        return Listing(self.atlas.branches[i - 1] for i in ids)

    @property
    def departures(self) -> dict:
        """What became of them: taken, known, inadmissible, over_budget and refused; `over` counts by budget."""
        counts = fields_of(self._raw.departures)
        over = counts.pop("over")
        counts["over"] = {text_of(lib.ric_budget_text(i)): count for i, count in enumerate(over) if count}
        return counts

    @property
    def title(self) -> str:
        """Its name, or else its label."""
        return self.name or self.label

    def _row(self, markup: bool) -> list:
        row = [self.id, self.label, self.name, self.kind, self.energy, self.frequency,
               " ".join(branch.label for branch in self.branches), self.departures["over_budget"]]
        return row + [""] * markup

    def __repr__(self) -> str:
        return (f"Junction {self.id} {self.label}{f' ({self.name})' if self.name else ''}: {self.kind}, energy "
                f"{self.energy:.10g}, frequency {self.frequency:.10g} rad/s, {len(self.branches)} branches")

    def _repr_html_(self) -> str:
        return table(self._HEADING, [self._row(False)])


class Branch:
    """A family of periodic orbits of one word and one symmetry.

    Attributes
    ----------
    id : int, from 1
    key : str, stays the same whatever the budgets
    label : str, such as S2-[01]
    impacts, letters : int, of one period
    symmetric, reversible : bool
    mirror : str
        Mirror points, "" if not reversible.
    stable_fraction : float
        Share of its length, as far as it is decided; nan if it is nowhere.
    energy_min, energy_max : float, scaled; frequency_min, frequency_max : float, rad/s
    stop : str
        Why its far end is where it is: junction, corner, window, budget, closed or failed; `why` a sentence.
    depth : int
        Departures from the start.
    mode : int
        Of linear modes and backbones, from 1, else 0.
    family : int
        The least id of the branches that a chain of junctions joins with this one.
    linked : bool
        Whether one of these leaves a linear mode, or is one; else they are an island.
    n_proved : int
        Points with a proof that `ricochet prove` has kept in the file.
    curve_proved : bool
        Whether such a proof says that it is one arc from end to end.

    The numbers of its points are arrays [n_point]: arclength, energy (scaled), frequency (rad/s), period (s), trace
    (lambda + 1/lambda, n = 2), log_trace, rotation (gamma of multipliers exp(+-2 pi i gamma)), reach (gap over clearance),
    approach (scaled speed), residual (relative); stable and undecided (bool); state [n_point, 2 n_dof], flights
    [n_point, max(letters, 1)], multipliers [n_point, 2 (n_mode - 1)]. They are read once, by one copy, and cannot be
    written to.
    """

    _HEADING = ["id", "label", "impacts", "points", "stable share", "energy", "frequency", "from", "to"]

    def __init__(self, atlas: Atlas, number: int):
        self.atlas, self._raw, self._columns = atlas, ffi.new("ric_branch *"), {}
        check(lib.ric_atlas_branch(atlas._handle, number, self._raw))
        hidden = ("n_point", "n_junction", "from", "to")
        self.__dict__.update({name: value for name, value in fields_of(self._raw[0]).items() if name not in hidden})
        self.stop = text_of(lib.ric_stop_text(self._raw.stop))

    def __len__(self) -> int:
        return self._raw.n_point

    def _column(self, name: str) -> np.ndarray:
        if name not in self._columns:
            read = partial(lib.ric_atlas_column, self.atlas._handle, self.id)
            self._columns[name] = column_of(read, len(self), name, name in ("state", "flights"))
        return self._columns[name]

    arclength = property(lambda self: self._column("arclength"), doc="[n_point]")
    energy = property(lambda self: self._column("energy"), doc="[n_point], scaled")
    frequency = property(lambda self: self._column("frequency"), doc="[n_point], rad/s")
    period = property(lambda self: self._column("period"), doc="[n_point], s")
    trace = property(lambda self: self._column("trace"), doc="[n_point] lambda + 1/lambda; NaN for n_mode != 2")
    log_trace = property(lambda self: self._column("log_trace"), doc="[n_point] log |trace|, without overflow")
    rotation = property(lambda self: self._column("rotation"), doc="[n_point] gamma in [0, 1); NaN off the unit circle")
    reach = property(lambda self: self._column("reach"), doc="[n_point] largest gap over clearance in flight")
    approach = property(lambda self: self._column("approach"), doc="[n_point] smallest speed at which a face is met or a spring left, scaled, 1/s")
    residual = property(lambda self: self._column("residual"), doc="[n_point] relative")
    state = property(lambda self: self._column("state"), doc="[n_point, 2 n_dof] x, then v (1/s), scaled")
    flights = property(lambda self: self._column("flights"), doc="[n_point, max(letters, 1)], s")

    @property
    def stable(self) -> np.ndarray:
        """[n_point] bool; what is not stable is unstable or undecided."""
        return self._column("stable") == lib.RIC_STABLE_YES

    @property
    def undecided(self) -> np.ndarray:
        """[n_point] bool: on the border within rounding."""
        return self._column("stable") == lib.RIC_STABLE_UNDECIDED

    @property
    def multipliers(self) -> np.ndarray:
        """[n_point, 2 (n_mode - 1)] complex, computed when first asked for, on all processors; NaN where they are lost.

        Of two modes they follow from the stored trace, but for linear modes and what is undecided: a million points take a
        quarter of a second. Others take the flight of every orbit: 30 microseconds a point with two modes, more with more.
        """
        if "multipliers" not in self._columns:
            array = np.empty((len(self), max(0, 2 * (self.atlas.model.n_mode - 1))), complex)
            for first in range(0, len(self) * bool(array.size), _AT_A_TIME):
                part = array[first:first + _AT_A_TIME].view(float)
                check(lib.ric_atlas_multipliers(self.atlas._handle, self.id, first, len(part), os.cpu_count() or 1, pointer(part)))
            array.flags.writeable = False
            self._columns["multipliers"] = array
        return self._columns["multipliers"]

    @property
    def word(self) -> str:
        """The faces that are hit in one period: 0-9a-z, numbers with dots beyond."""
        return word_of(self.atlas.model._handle, self.letters, self._raw.word)

    @property
    def ends(self) -> tuple:
        """The junctions at its first and at its last point, None where there is none."""
        return tuple(self.atlas.junctions[i - 1] if i else None for i in (getattr(self._raw, "from"), self._raw.to))

    @property
    def junctions(self) -> Listing:
        """The junctions between its ends, in their order; `junction_arclengths` says where."""
        ids = copy_of(self._raw.junctions, self._raw.n_junction, np.intc)
        return Listing(self.atlas.junctions[i - 1] for i in ids)

    @property
    def junction_arclengths(self) -> np.ndarray:
        """[len(junctions)]"""
        return copy_of(self._raw.junction_at, self._raw.n_junction)

    @property
    def tongues(self) -> List["Tongue"]:
        """The internal resonances that it follows or steps over, in their order."""
        n, out = ffi.new("int *"), ffi.new("ric_tongue **")
        check(lib.ric_branch_tongues(self.atlas._handle, self.id, n, out))
        found = ffi.gc(out[0], lib.ric_tongues_free)
        return [Tongue(t.mode, t.turns, t.per, bool(t.crossed), t.others, t.first, t.last, tuple(t.energy), tuple(t.frequency)) for t in found[0 : n[0]]]

    def _find(self, at: int, value: float) -> List[Orbit]:
        n, out = ffi.new("int *"), ffi.new("ric_orbit ***")
        check(lib.ric_orbit_find(self.atlas._handle, self.id, at, value, n, out))
        count, array = n[0], out[0]
        owner = ffi.gc(array, lambda orbits: lib.ric_orbits_free(count, orbits))
        return [Orbit(self, array[i], owner) for i in range(count)]

    def proof(self, i: int):
        """The Proof of stored point i that is kept in the file, None if there is none; `Atlas.prove` makes one."""
        from ._proof import kept
        return kept(self.atlas, self.id, i + len(self) if i < 0 else i)

    def point(self, i: int) -> Orbit:
        """The orbit of stored point i, from 0; -1 is the last one."""
        return self._find(lib.RIC_AT_POINT, i + len(self) if i < 0 else i)[0]

    def orbits(self, energy: Optional[float] = None, frequency: Optional[float] = None) -> List[Orbit]:
        """Every orbit of a scaled energy, or of a frequency in rad/s, in the order of the branch."""
        if (energy is None) == (frequency is None):
            raise TypeError("give either energy=E, scaled, or frequency=F in rad/s")
        at, value = (lib.RIC_AT_ENERGY, energy) if frequency is None else (lib.RIC_AT_FREQUENCY, frequency)
        return self._find(at, value)

    def orbit(self, energy: Optional[float] = None, frequency: Optional[float] = None,
              which: Optional[int] = None) -> Orbit:
        """The orbit of a scaled energy, or of a frequency in rad/s; `which`, from 0, if there are several."""
        found = self.orbits(energy, frequency)
        if which is not None and -len(found) <= which < len(found):
            return found[which]
        if which is None and len(found) == 1:
            return found[0]
        asked = f"energy {energy:.12g}" if frequency is None else f"frequency {frequency:.12g}"
        low, high = (self.energy_min, self.energy_max) if frequency is None else (self.frequency_min, self.frequency_max)
        if not found:
            raise RangeError(f"branch {self.id} {self.label} has no orbit of {asked}; it runs from {low:.12g} to {high:.12g}")
        raise RangeError(f"branch {self.id} {self.label} has {len(found)} orbits of {asked}: give which=0 to "
                         f"{len(found) - 1}, or take them all with orbits()")

    def _row(self, markup: bool) -> list:
        ends = [end.title if end else "" for end in self.ends]
        if not ends[1]:
            ends[1] = self.stop
        row = [self.id, self.label, self.impacts, len(self), self.stable_fraction,
               f"{self.energy_min:.5g} to {self.energy_max:.5g}", f"{self.frequency_min:.5g} to {self.frequency_max:.5g}",
               *ends]
        return row + [Markup(self._picture(90, 24))] * markup

    def _picture(self, width: int, height: int) -> str:
        with np.errstate(divide="ignore", invalid="ignore"):
            energy = np.log10(self.energy)
        return curve(np.where(np.isfinite(energy), energy, np.nanmin(energy[np.isfinite(energy)], initial=0)),
                     self.frequency, self.stable, width, height)

    def __repr__(self) -> str:
        return (f"Branch {self.id} {self.label}: {self.impacts} impacts, {len(self)} points, energy {self.energy_min:.6g} to "
                f"{self.energy_max:.6g}, frequency {self.frequency_min:.6g} to {self.frequency_max:.6g} rad/s, stable share "
                f"{self.stable_fraction:.3g}")

    def _repr_html_(self) -> str:
        return f"{table(self._HEADING, [self._row(False)])}{self._picture(240, 90)}"


class Atlas:
    """An atlas file: branches of periodic orbits, and the junctions where they meet.

    It is read as a whole when it is opened; the file is not held open. Lengths are scaled by d of the first contact and
    energies by d^2 (`model.length`); times are in s, frequencies in rad/s.

    Parameters
    ----------
    path : str

    Attributes
    ----------
    branches, junctions : Listing
        In the order of their ids, from 1: branches[0].id is 1.
    """

    def __init__(self, path: Union[str, os.PathLike]):
        out = ffi.new("ric_atlas **")
        check(lib.ric_atlas_read(os.fsencode(path), out))
        self.path = os.fspath(path)
        self._handle = ffi.gc(out[0], lib.ric_atlas_free)
        self.model = Model._borrow(lib.ric_atlas_model(self._handle), self._handle)
        self.branches = Listing(Branch(self, i + 1) for i in range(lib.ric_atlas_n_branch(self._handle)))
        self.junctions = Listing(Junction(self, i + 1) for i in range(lib.ric_atlas_n_junction(self._handle)))

    @property
    def study(self):
        """The study that it was made from."""
        from ._study import Study
        return Study._borrow(lib.ric_atlas_study(self._handle), self._handle)

    @property
    def finished(self) -> bool:
        """False if the run was stopped before its end; `explore` with the same study and path goes on."""
        return lib.ric_atlas_finished(self._handle)

    def __len__(self) -> int:
        return len(self.branches)

    def __iter__(self) -> Iterator[Branch]:
        return iter(self.branches)

    def branch(self, which: Union[int, str]) -> Branch:
        """A branch by its id, its label or its key."""
        return _choose(self.branches, which, "branch", ("label", "key"))

    def junction(self, which: Union[int, str]) -> Junction:
        """A junction by its id, its name, its label or its key."""
        return _choose(self.junctions, which, "junction", ("name", "label", "key"))

    def verify(self, all: bool = False, branch: Optional[int] = None, workers: int = 1, progress: Optional[bool] = None):
        """Replays stored orbits with an independent simulator, and computes anew what is stored with them.

        Parameters
        ----------
        all : bool
            Every stored point, instead of eight of each branch.
        branch : int
            Only this one.
        workers : int
            How many at a time.

        Returns
        -------
        Verification
        """
        from ._verify import verify
        return verify(self, all, branch, workers, progress)

    def hunt(self, energy: float, impacts: int = 6, period: Optional[float] = None, progress: Optional[bool] = None,
             compare: bool = True, **options):
        """Looks for all periodic orbits of one scaled energy by brute force, and tells which of them the atlas lacks.

        For structures of which rigid stops see two modes. What is not found is not proved to be absent.

        Parameters
        ----------
        energy : float, scaled
        impacts : int
            Longest word, at most 24.
        period : float, s
            Longest period; unless given, what the frequency window of the study allows.
        compare : bool
            Whether to compare with the atlas.
        options
            lines, rows, row, random, starts, seed: how densely is looked; see `ricochet hunt --help`.

        Returns
        -------
        Hunt
        """
        from ._hunt import hunt
        return hunt(self, energy, impacts, period, progress, compare, options)

    def section(self, energy: float, starts: Optional[int] = None, impacts: Optional[int] = None, **options):
        """Motions of one scaled energy on the section; see `Model.section`."""
        return self.model.section(energy, starts, impacts, **options)

    def shaking(self, force=None, damping=None, restitution: Optional[float] = None, study=None):
        """What a harmonic force and losses make of the orbits.

        What is not given is as `study`, or else the study of the atlas, has it (`Study.forcing`); nothing is lost where that
        says nothing.

        Parameters
        ----------
        force : array [n_dof]
            Of amplitude 1, physical.
        damping : float, array [n_dof] or array [n_dof, n_dof]
            A modal damping ratio for all modes, one for each, or a damping matrix, physical.
        restitution : float, above 0, at most 1
        study : Study

        Returns
        -------
        Shaking
        """
        from ._force import Shaking
        return Shaking(self, self._shaken(study, force, damping, restitution))

    def _shaken(self, study, force, damping, restitution) -> dict:
        """What is given, and the rest from a study of this structure."""
        from ._force import completed
        if study is not None and not lib.ric_model_same(study.model._handle, self.model._handle):
            raise InputError("the study is one of another structure than that of the atlas")
        return completed(study or self.study, force, damping, restitution)

    def response(self, path: Union[str, os.PathLike], force=None, level=None, omega=None, damping=None, restitution=None,
                 along: str = "omega", harmonic=None, branch: Union[None, int, str] = None, impacts: Optional[int] = None,
                 periods: Optional[int] = None, points: Optional[int] = None, curves: Optional[int] = None,
                 step: Optional[float] = None, study=None, progress: Optional[bool] = None):
        """Curves of periodic motions of the damped and shaken structure, solved to rounding, into the file `path`.

        Ctrl-C keeps what was done, and the same call goes on from there. What is not given of force, damping, restitution,
        level, omega and harmonic is as `study`, or else the study of the atlas, has it.

        Parameters
        ----------
        path : str
            A file of its own: not that of the atlas. None is left where no motion is found.
        force, damping, restitution
            As of `shaking`.
        level : float or array
            Physical amplitudes of the force, with curves for each.
        omega : float or (low, high)
            Frequency of the force, rad/s.
        along : "omega", "level" or "restitution"
            What varies: that takes a window, (low, high).
        harmonic : int or array of int
            Of the orbits of the atlas, beside which curves begin; 1 unless given.
        branch : int or str
            Only beside this branch of the atlas, and without the linear motion.
        impacts, periods : int
            Most impacts, and most periods of the force, in a period of the motion; 12 and 4 unless given.
        points, curves : int
            Most of a curve, and most of all; 2000 and 200 unless given.
        step : float
            Longest, relative to the motion; 0.05 unless given.

        Returns
        -------
        Response
        """
        from ._response import respond
        shaken = self._shaken(study, force, damping, restitution)
        own = (study or self.study).forcing
        if own is not None:
            level, omega, harmonic = (mine if mine is not None else theirs if np.size(theirs) else None for mine, theirs in
                                      ((level, own.amplitude), (omega, own.frequency), (harmonic, own.harmonic)))
        rest = {"branch": None if branch is None else self.branch(branch).id, "impacts": impacts, "periods": periods,
                "points": points, "curves": curves, "step": step}
        return respond(self, path, along, omega, level, shaken, 1 if harmonic is None else harmonic, progress, rest)

    def locus(self, junction: Union[int, str, Junction], values: Sequence[float] = (), max_step: float = 0, vary=None,
              progress: Optional[bool] = None):
        """A junction as a parameter of the structure varies: a curve through its own folds.

        Parameters
        ----------
        junction : int, str or Junction
        values : sequence of float
            Of the parameter, at which it is solved as well.
        max_step : float
            Largest step, relative to the range and to the orbit; the library's unless given.
        vary : dict or Study
            The parameter, as section vary of a study has it: name, at, from and to, and mass, stiffness or clearance, what
            grows with it. That of the study of the atlas unless given.

        Returns
        -------
        Locus
        """
        from ._locus import locus
        return locus(self, junction, values, max_step, vary, progress)

    def census(self, energy: float, impacts: int = 3, period: Optional[float] = None, **options):
        """All periodic orbits of one scaled energy with few impacts, as a theorem; see `Model.census`.

        Unless `period` is given it is the longest that the frequency window of the study allows, as in `ricochet prove
        --complete`.
        """
        from ._census import bounded, census
        return census(self.model, energy, impacts, bounded(self.study) if period is None else period, **options)

    def prove(self, branch: Union[None, int, str] = None, points: Optional[Sequence[int]] = None, workers: int = 1,
              progress: Optional[bool] = None):
        """Proves stored orbits by ball arithmetic.

        Parameters
        ----------
        branch : int or str
            Only this one.
        points : sequence of int, from 0
            Of each branch; -1 is the last one. All unless given.
        workers : int

        Returns
        -------
        Proofs
        """
        from ._proof import prove
        return prove(self, branch, points, workers, progress)

    def _head(self) -> str:
        return (f"Atlas {self.path}: {self.study.title}, {len(self.branches)} branches, {len(self.junctions)} junctions"
                f"{'' if self.finished else ', not finished'}")

    def __repr__(self) -> str:
        return f"{self._head()}\n{self.branches!r}"

    def _repr_html_(self) -> str:
        import html
        return f"<b>{html.escape(self._head())}</b>{self.branches._repr_html_()}"


def _choose(listing: Listing, which, what: str, names: tuple):
    """By id, or by the first of `names` that fits."""
    if isinstance(which, (int, np.integer)) and not isinstance(which, bool):
        if 1 <= which <= len(listing):
            return listing[which - 1]
        raise RangeError(f"no {what} {which}: the numbers run from 1 to {len(listing)}")
    for name in names:
        found = [one for one in listing if which and getattr(one, name, None) == which]
        if len(found) == 1:
            return found[0]
        if found:
            raise RangeError(f"{len(found)} {what}s have the {name} '{which}': give one of the ids "
                             f"{', '.join(str(one.id) for one in found)}")
    known = [text for one in listing for text in (getattr(one, name, None) for name in names) if text]
    near = difflib.get_close_matches(str(which), known, 3, 0.5)
    raise RangeError(f"no {what} '{which}'" + (f"; there is {', '.join(dict.fromkeys(near))}" if near else ""))
