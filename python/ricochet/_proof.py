"""Stored orbits as theorems."""
from __future__ import annotations

import threading
from dataclasses import dataclass, field
from functools import partial
from typing import List, Optional, Tuple

from ._library import check, ffi, fields_of, lib, text_of
import numpy as np

from ._running import with_bar
from ._show import table, text_table

_STATES = {lib.RIC_PROOF_DONE: "proved", lib.RIC_PROOF_NONE: "not proved", lib.RIC_PROOF_LEFT_OUT: "left out"}
_STABLE = {lib.RIC_STABLE_YES: "yes", lib.RIC_STABLE_NO: "no", lib.RIC_STABLE_UNDECIDED: "undecided"}
_HEADING = ["branch", "point", "state", "bits", "exists within", "alone within", "stable", "why"]


@dataclass
class Proof:
    """What is proved of a stored point.

    state, proved, not proved or left out, and why; bits of the arithmetic; exists and unique, radii: the orbit is within
    `exists` of the centre of the theorem, and no other one within `unique`; distance of the stored orbit from it,
    relative; energy, period and trace, intervals; approach: no impact is slower, scaled; stable, yes, no or undecided,
    symmetric and reversible, as proved; certificate, a line of JSON that tools/check_certificate.py checks.
    """

    branch: int
    point: int
    state: str
    why: str
    bits: int
    distance: float
    exists: float
    unique: float
    energy: Tuple[float, float]
    period: Tuple[float, float]
    trace: Tuple[float, float]
    approach: float
    stable: str
    symmetric: bool
    reversible: bool
    certificate: str = field(default="", repr=False)

    @property
    def proved(self) -> bool:
        """Whether there is a theorem."""
        return self.state == "proved"

    def _row(self) -> list:
        return [self.branch, self.point, self.state, self.bits, self.exists, self.unique, self.stable, self.why]


class Proofs(list):
    """The proofs, in the order of branches and points. True if all that were tried are proved."""

    def __init__(self, proofs, model: str):
        super().__init__(proofs)
        self.model = model
        """the line of JSON that comes before certificates in a file of them"""

    def __bool__(self) -> bool:
        return all(one.state != "not proved" for one in self)

    def save(self, path: str) -> None:
        """A file of certificates that tools/check_certificate.py checks without the library."""
        with open(path, "w", encoding="utf-8") as file:
            file.writelines(line + "\n" for line in [self.model, *(one.certificate for one in self if one.certificate)])

    def _head(self) -> str:
        return f"{sum(one.proved for one in self)} of {len(self)} points are proved"

    def __repr__(self) -> str:
        return self._head() + ("\n" + text_table(_HEADING, [one._row() for one in self if not one.proved]) if not self else "")

    def _repr_html_(self) -> str:
        return table(_HEADING, [one._row() for one in self], self._head())


def _proof(raw, certificate: str) -> Proof:
    said = fields_of(raw)
    said["state"], said["stable"] = _STATES[said["state"]], _STABLE[said["stable"]]
    said.update({name: tuple(said[name]) for name in ("energy", "period", "trace")})
    return Proof(certificate=certificate, **{name: said[name] for name in Proof.__dataclass_fields__ if name != "certificate"})


def kept(atlas, branch: int, i: int) -> Optional[Proof]:
    """The proof that the file keeps of a point."""
    raw, certificate = ffi.new("ric_proof *"), ffi.new("const char **")
    if not lib.ric_proof_kept(atlas._handle, branch, i, raw, certificate):
        return None
    return _proof(raw[0], text_of(certificate[0]))


class _Provers:
    """One prover for each thread: they may not be shared."""

    def __init__(self, atlas):
        self.atlas, self.own, self.model = atlas, threading.local(), ""

    def _handle(self):
        if not hasattr(self.own, "handle"):
            made = ffi.new("ric_prover **")
            check(lib.ric_prover_create(self.atlas._handle, made))
            self.own.handle = ffi.gc(made[0], lib.ric_prover_free)
            self.model = text_of(lib.ric_prover_model(self.own.handle))
        return self.own.handle

    def prove(self, branch: int, i: int) -> Proof:
        """With as many bits as it takes."""
        handle, raw = self._handle(), ffi.new("ric_proof *")
        check(lib.ric_prover_point(handle, branch, i, raw))
        return _proof(raw[0], text_of(lib.ric_prover_certificate(handle)))


def prove(atlas, branch, points: Optional[List[int]], workers: int, progress) -> Proofs:
    """As the command `prove` does it, but that nothing is kept in the file."""
    provers, calls = _Provers(atlas), []
    for one in atlas.branches if branch is None else [atlas.branch(branch)]:
        chosen = range(len(one)) if points is None else [i + len(one) if i < 0 else int(i) for i in np.atleast_1d(points)]
        calls += [partial(provers.prove, one.id, i) for i in chosen]
    return Proofs(with_bar(calls, workers, progress), provers.model)
