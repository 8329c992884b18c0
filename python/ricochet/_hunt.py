"""The search by brute force."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import List, Optional

from ._library import InputError, check, ffi, fields_of, lib, pointer, text_of, word_of
import numpy as np

from ._running import Bar, Job
from ._show import table, text_table

_HEADING = ["word", "period", "trace", "symmetric", "reversible", "atlas", "branch", "reason"]


@dataclass
class Found:
    """An orbit that the hunt has found; it has passed the simulator.

    word : str; impacts : int; period, s; frequency, rad/s; trace, lambda + 1/lambda; multipliers, complex [2]; state
    [2 n_dof], scaled, right after the first impact; flights [impacts], s. `atlas` is known, budget, isolated or
    unexplained ("" if it was not compared), `branch` the id where it is known, `reason` why the atlas lacks it.
    """

    word: str
    impacts: int
    period: float
    frequency: float
    symmetric: bool
    reversible: bool
    trace: float
    multipliers: np.ndarray = field(repr=False)
    state: np.ndarray = field(repr=False)
    flights: np.ndarray = field(repr=False)
    atlas: str = ""
    branch: Optional[int] = None
    family: Optional[int] = None
    reason: str = ""

    def _row(self) -> list:
        return [self.word, self.period, self.trace, self.symmetric, self.reversible, self.atlas, self.branch, self.reason]


class Hunt(list):
    """The orbits found, by impacts, word and period.

    Attributes
    ----------
    energy : float, scaled
    n_atlas, n_again : int
        Orbits of the atlas within the bounds of the hunt, and how many of them were found: what the search is worth.
    missed : list of dicts with branch, impacts, period, trace and approach
        Orbits of the atlas that the hunt has not come to.
    """

    energy, n_atlas, n_again = 0.0, 0, 0

    def __init__(self, orbits, energy):
        super().__init__(orbits)
        self.energy, self.missed = energy, []

    @property
    def unexplained(self) -> List[Found]:
        """What the exploration has missed."""
        return [one for one in self if one.atlas == "unexplained"]

    def _head(self) -> str:
        return (f"{len(self)} orbits at energy {self.energy:g}; of the atlas's {self.n_atlas} there {self.n_again} were "
                f"found again, {len(self.unexplained)} unexplained")

    def __repr__(self) -> str:
        return self._head() + ("\n" + text_table(_HEADING, [one._row() for one in self]) if self else "")

    def _repr_html_(self) -> str:
        return table(_HEADING, [one._row() for one in self], self._head())


def _found(handle, model, i: int) -> Found:
    raw, most = ffi.new("ric_found *"), lib.RIC_HUNT_IMPACTS
    word, state, flights = np.zeros(most, np.intc), np.zeros(2 * model.n_dof), np.zeros(most)
    check(lib.ric_hunt_found(handle, i, raw, pointer(word), pointer(state), pointer(flights)))
    n = raw.impacts
    return Found(word_of(model._handle, n, pointer(word)), n, raw.period, 6.283185307179586 / raw.period, raw.symmetric,
                 raw.reversible, raw.trace, np.array(list(raw.multipliers)).view(complex), state, flights[:n].copy())


def _compare(handle, atlas, out: Hunt) -> None:
    got = ffi.new("ric_comparison **")
    check(lib.ric_hunt_compare(handle, atlas._handle, got))
    comparison, finding = ffi.gc(got[0], lib.ric_comparison_free), ffi.new("ric_finding *")
    counts = ffi.new("int[3]")
    lib.ric_comparison_count(comparison, counts, counts + 1, counts + 2)
    out.n_atlas, out.n_again = counts[0], counts[1]
    for i, one in enumerate(out):
        check(lib.ric_comparison_finding(comparison, i, finding))
        one.atlas, one.reason = text_of(lib.ric_found_text(finding.state)), text_of(finding.why)
        one.branch = finding.branch if finding.state == lib.RIC_FOUND_KNOWN and finding.branch else None
        one.family = finding.family or None
    for i in range(counts[2]):
        missed = ffi.new("ric_missed *")
        check(lib.ric_comparison_missed(comparison, i, missed))
        out.missed.append(fields_of(missed[0]))


def _options(atlas, energy: float, impacts: int, period, given: dict):
    options = ffi.new("ric_hunt_options *")
    lib.ric_hunt_options_init(options)
    lib.ric_hunt_options_bound(options, lib.ric_atlas_study(atlas._handle))
    options.energy, options.impacts = energy, impacts
    if period is not None:
        options.period[1] = min(period, options.period[1])
    for name, value in given.items():
        if name not in ("lines", "rows", "row", "random", "starts", "seed"):
            raise InputError(f"hunt: no option '{name}': there are lines, rows, row, random, starts and seed")
        setattr(options, name, value)
    return options


def hunt(atlas, energy: float, impacts: int, period, progress, compare: bool, given: dict) -> Hunt:
    """As the command `hunt` does it."""
    options, now = _options(atlas, energy, impacts, period, given), ["", 0.0, 0]
    handles, result = ffi.new("ric_hunt **"), []

    def call(job: Job) -> int:
        def told(what, part, found, user):
            now[:] = text_of(what), part, found
            return job.stopping
        options.progress = job.told = ffi.callback("bool(const char *, double, int, void *)", told, error=True)
        check(lib.ric_hunt_create(atlas.model._handle, options, handles))
        handle = ffi.gc(handles[0], lib.ric_hunt_free)
        check(lib.ric_hunt_run(handle))
        out = Hunt([_found(handle, atlas.model, i) for i in range(lib.ric_hunt_n_found(handle))], energy)
        if compare:
            _compare(handle, atlas, out)
        result.append(out)
        return lib.RIC_OK

    bar = Bar(progress)
    try:
        Job(call).run(lambda: bar.show(now[1], f"{now[0]}, {now[2]} orbits"))
    finally:
        bar.close()
    return result[0]
