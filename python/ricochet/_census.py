"""All periodic orbits of one energy with few impacts."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional, Tuple

from ._library import check, ffi, lib, pointer, word_of
import numpy as np

from ._running import Bar, Job
from ._show import table, text_table

_STABLE = {lib.RIC_STABLE_YES: "yes", lib.RIC_STABLE_NO: "no", lib.RIC_STABLE_UNDECIDED: "undecided"}
_HEADING = ["orbit", "word", "period", "symmetric", "reversible", "stable", "trace", "approach"]


@dataclass
class CensusOrbit:
    """An orbit of a census: it is another one than all before, also run backwards, mirrored and begun at another impact.

    word; impacts; period, s, frequency, rad/s, and trace, lambda + 1/lambda, the middles of the intervals period_within and
    trace_within that are proved to hold them; approach: no impact is slower, scaled; stable, yes, no or undecided, as proved;
    symmetric and reversible, true as proved; state [2 n_dof], x then v, scaled, right after the first impact, and flights
    [impacts], s, near those of the orbit.
    """

    word: str
    impacts: int
    period: float
    frequency: float
    trace: float
    period_within: Tuple[float, float]
    trace_within: Tuple[float, float]
    approach: float
    stable: str
    symmetric: bool
    reversible: bool
    state: np.ndarray = field(repr=False)
    flights: np.ndarray = field(repr=False)


@dataclass
class Account:
    """What a census has looked at.

    flight, s: no flight is longer, inf where none is proved, 0 where no stop is reached; period, s, (low, high), what was
    looked through; all_periods: no orbit of so many impacts has another period; words, up to images; boxes; ghosts, zeros of
    the equations that are no motions; open, zeros of which it is not proved whether they are motions; undecided, boxes that
    are neither empty nor known to hold one orbit; measure, their share of all flight times and states; stopped, on
    request, or as the time was over.
    """

    flight: float
    period: Tuple[float, float]
    all_periods: bool
    words: int
    boxes: int
    ghosts: int
    open: int
    undecided: int
    measure: float
    stopped: bool


class Census(list):
    """The orbits, by impacts and period; `complete` tells whether these are all.

    Attributes
    ----------
    energy : float, scaled
    impacts : int
        Of the longest words that were looked through.
    account : Account
    open : list of (word, flights [impacts], s)
        Solutions of which it is not proved whether they are motions.
    """

    def __init__(self, orbits, energy: float, impacts: int, account: Account, open_ones: list):
        super().__init__(orbits)
        self.energy, self.impacts, self.account, self.open = energy, impacts, account, open_ones

    @property
    def complete(self) -> bool:
        """Whether it is a theorem that there are no others: nothing is undecided, and nothing open."""
        return not self.account.undecided and not self.account.open and not self.account.stopped

    def column(self, name: str) -> np.ndarray:
        """[len] a number of all orbits."""
        return np.array([getattr(one, name) for one in self])

    def _head(self) -> str:
        a = self.account
        where = "which reaches no stop" if not a.flight > 0 else "of any period" if a.all_periods else \
            f"of periods from {a.period[0]:.4g} to {a.period[1]:.4g} s"
        rest = f", {a.undecided} boxes undecided" * bool(a.undecided) + f", {a.open} solutions open" * bool(a.open)
        return (f"{'complete' if self.complete else 'not complete'}: {len(self)} orbits of up to {self.impacts} impacts at energy "
                f"{self.energy:g}, {where}{rest}")

    def _rows(self) -> list:
        return [[i + 1, one.word, one.period, one.symmetric, one.reversible, one.stable, one.trace, one.approach]
                for i, one in enumerate(self)]

    def __repr__(self) -> str:
        return self._head() + ("\n" + text_table(_HEADING, self._rows()) if self else "")

    def _repr_html_(self) -> str:
        return table(_HEADING, self._rows(), self._head())


def _orbit(handle, model, i: int) -> CensusOrbit:
    raw, most = ffi.new("ric_census_orbit *"), lib.RIC_CENSUS_LONGEST
    word, state, flights = np.zeros(most, np.intc), np.zeros(2 * model.n_dof), np.zeros(most)
    check(lib.ric_census_orbit_at(handle, i, raw, pointer(word), pointer(state), pointer(flights)))
    period, n = (raw.period[0] + raw.period[1]) / 2, raw.impacts
    return CensusOrbit(word_of(model._handle, n, pointer(word)), n, period, 6.283185307179586 / period,
                       (raw.trace[0] + raw.trace[1]) / 2, tuple(raw.period), tuple(raw.trace), raw.approach, _STABLE[raw.stable],
                       raw.symmetric, raw.reversible, state, flights[:n].copy())


def _open(handle, model, i: int) -> tuple:
    n, most = ffi.new("int *"), lib.RIC_CENSUS_LONGEST
    word, flights = np.zeros(most, np.intc), np.zeros(most)
    check(lib.ric_census_open_at(handle, i, n, pointer(word), pointer(flights)))
    return word_of(model._handle, n[0], pointer(word)), flights[:n[0]].copy()


def _result(handle, model, energy: float, impacts: int) -> Census:
    raw = ffi.new("ric_census_account *")
    lib.ric_census_account_of(handle, raw)
    said = {name: getattr(raw, name) for name in Account.__dataclass_fields__}
    account = Account(**{**said, "period": tuple(raw.period)})
    return Census([_orbit(handle, model, i) for i in range(lib.ric_census_n_orbit(handle))], energy, impacts, account,
                  [_open(handle, model, i) for i in range(raw.open)])


def bounded(study) -> float:
    """The longest period that the frequency window of a study allows, s."""
    options = ffi.new("ric_hunt_options *")
    lib.ric_hunt_options_init(options)
    lib.ric_hunt_options_bound(options, study._handle)
    return options.period[1]


def census(model, energy: float, impacts: int, period: Optional[float] = None, workers: int = 1,
           seconds: Optional[float] = None, progress: Optional[bool] = None) -> Census:
    """As the command `prove --complete` does it, but for the hunt that comes after it."""
    options, made, now = ffi.new("ric_census_options *"), ffi.new("ric_census **"), [0.0, 0]
    lib.ric_census_options_init(options)
    options.energy, options.impacts, options.workers = energy, impacts, workers
    if period is not None:
        options.period[1] = period
    if seconds is not None:
        options.seconds = seconds

    def call(job: Job) -> int:
        def told(part, found, user):
            now[:] = part, found
            return job.stopping
        options.progress = job.told = ffi.callback("bool(double, int, void *)", told, error=True)
        return lib.ric_census_run(model._handle, options, made)

    bar = Bar(progress)
    try:
        Job(call).run(lambda: bar.show(now[0], f"{100 * now[0]:.1f} %, {now[1]} orbits and images of them"))
        return _result(made[0], model, energy, impacts)
    finally:
        bar.close()
        lib.ric_census_free(made[0])
