"""Replays of stored orbits."""
from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import List, Optional

from ._library import check, ffi, fields_of, lib
import numpy as np

from ._running import with_bar
from ._show import table, text_table

_AGREES = {lib.RIC_AGREES_NO: "no", lib.RIC_AGREES_YES: "yes", lib.RIC_AGREES_UNCHECKED: "unchecked"}
_HEADING = ["kind", "branch", "point", "junction", "flight error", "return error", "energy error", "finding"]


@dataclass
class Check:
    """What a replay makes of a stored point, or a comparison of the row of a branch or a junction."""

    kind: str                    # point, branch or junction
    branch: Optional[int]        # ids, and the point from 0
    point: Optional[int]
    junction: Optional[int]
    flight_error: float = np.nan # relative; of a flight's time and end
    return_error: float = np.nan # relative, after one period
    condition: float = np.nan    # what one period makes of a small error
    energy_error: float = np.nan # relative
    faces_agree: bool = True
    multiplier_error: float = np.nan
    multiplier_bound: float = np.nan
    multipliers_agree: str = ""  # yes, no or unchecked
    stable_agrees: str = ""
    numbers_agree: str = ""
    passed: bool = False
    finding: str = ""            # what does not agree, or why something was not checked

    def _row(self) -> list:
        return [self.kind, self.branch, self.point, self.junction, self.flight_error, self.return_error, self.energy_error,
                self.finding or ("" if self.passed else "the motion is not what the simulator makes of it")]


class Verification(list):
    """The checks, in the order of branches, then junctions. True if all have passed."""

    @property
    def failures(self) -> List[Check]:
        """Those that have not passed."""
        return [one for one in self if not one.passed]

    @property
    def unchecked(self) -> List[Check]:
        """Points whose multipliers or stability rounding has left too little of to be checked."""
        return [one for one in self if one.kind == "point" and (one.stable_agrees == "unchecked" or (
            one.multipliers_agree == "unchecked" and not np.isnan(one.multiplier_bound)))]

    def column(self, name: str) -> np.ndarray:
        """[len] a number of all checks."""
        return np.array([getattr(one, name) for one in self])

    def __bool__(self) -> bool:
        return not self.failures

    def __repr__(self) -> str:
        points = [one for one in self if one.kind == "point"]
        wrong, good = self.failures, sum(one.passed for one in points)
        lines = [f"{good} of {len(points)} points agree with the simulator; of {len(self) - len(points)} rows of branches "
                 f"and junctions {sum(one.kind != 'point' for one in wrong)} do not agree",
                 f"{len(self.unchecked)} could not be checked wholly" if self.unchecked else "",
                 text_table(_HEADING, [one._row() for one in wrong]) if wrong else ""]
        return "\n".join(filter(None, lines))

    def _repr_html_(self) -> str:
        head = f"<p>{repr(self).splitlines()[0]}</p>"
        return head + (table(_HEADING, [one._row() for one in self.failures]) if self.failures else "")


def _claims(out: Check, raw) -> Check:
    said = fields_of(raw)
    out.multiplier_error, out.multiplier_bound = said["multiplier_error"], said["multiplier_bound"]
    out.multipliers_agree, out.stable_agrees, out.numbers_agree = (_AGREES[said[name]] for name in
                                                                  ("multipliers", "stable", "numbers"))
    out.finding = said["finding"]
    out.passed = out.passed and "no" not in (out.multipliers_agree, out.stable_agrees, out.numbers_agree)
    return out


def _of_point(atlas, branch: int, i: int) -> Check:
    replay, claims = ffi.new("ric_check *"), ffi.new("ric_claims *")
    check(lib.ric_verify_point(atlas._handle, branch, i, replay))
    check(lib.ric_verify_claims(atlas._handle, branch, i, claims))
    names = ("flight_error", "return_error", "condition", "energy_error", "faces_agree", "passed")
    return _claims(Check("point", branch, i, None, **{name: getattr(replay, name) for name in names}), claims[0])


def _of_row(atlas, kind: str, number: int) -> Check:
    claims = ffi.new("ric_claims *")
    call = lib.ric_verify_branch if kind == "branch" else lib.ric_verify_junction
    check(call(atlas._handle, number, claims))
    ids = (number, None, None) if kind == "branch" else (None, None, number)
    return _claims(Check(kind, *ids, passed=True), claims[0])


def _sample(atlas, branch) -> list:
    n, chosen = ffi.new("int *"), ffi.new(f"int[{lib.RIC_VERIFY_SAMPLE}]")
    check(lib.ric_verify_sample(atlas._handle, branch.id, n, chosen))
    return list(chosen[0:n[0]])


def verify(atlas, all_points: bool, branch, workers: int, progress) -> Verification:
    """As the command `verify` does it."""
    calls = []
    for one in [atlas.branch(branch)] if branch is not None else atlas.branches:
        if len(one):
            calls.append(partial(_of_row, atlas, "branch", one.id))
        for i in range(len(one)) if all_points else _sample(atlas, one):
            calls.append(partial(_of_point, atlas, one.id, i))
    if branch is None:
        calls += [partial(_of_row, atlas, "junction", one.id) for one in atlas.junctions]
    return Verification(with_bar(calls, workers, progress, " replayed"))
