"""Periodic orbits of linear structures with rigid stops, bilinear springs or power-law springs.

    model = ricochet.Model(mass, stiffness, [ricochet.Contact(normal, clearance=1)])
    atlas = ricochet.explore(ricochet.Study(model, energy=[0, 20], impacts=6), "mine.ricochet", workers=2)
    atlas.branch("S2-[01]").orbit(energy=5).history(dt=0.01)

Lengths are scaled by d, the clearance or length of the first contact (`model.length`), energies by d^2; times are in s and
frequencies in rad/s. Matrices, and everything that describes a structure, are in physical units. `ricochet.plot` draws on
axes of matplotlib, `ricochet.reduce` makes a small model of a finite-element one.
"""
from ._library import (BusyError, ConflictError, Error, FileError, FormatError, InputError, Interrupted, MissingError,
                       NumericError, RangeError, ffi as _ffi, lib as _lib)
from ._atlas import Atlas, Branch, Junction, Listing, Tongue
from ._census import Account, Census, CensusOrbit
from ._force import Forced, Forcing, Prediction, Shaking
from ._hunt import Found, Hunt
from ._locus import Locus
from ._model import Contact, Model
from ._orbit import Orbit
from ._proof import Proof, Proofs
from ._response import Response, ResponseCheck, ResponseChecks, ResponseCurve, ResponseEvent
from ._section import Section, Track
from ._simulation import History, Simulation
from ._study import Progress, Study, explore
from ._verify import Check, Verification

__version__ = _ffi.string(_lib.ric_version()).decode()

__all__ = ["Account", "Atlas", "Branch", "BusyError", "Census", "CensusOrbit", "Check", "ConflictError", "Contact",
           "Error", "FileError", "Forced", "Forcing", "FormatError", "Found", "History", "Hunt", "InputError",
           "Interrupted", "Junction", "Listing", "Locus", "MissingError", "Model", "NumericError", "Orbit",
           "Prediction", "Progress", "Proof", "Proofs", "RangeError", "Reduction", "Response", "ResponseCheck",
           "ResponseChecks", "ResponseCurve", "ResponseEvent", "Section", "Shaking", "Simulation", "Study", "Tongue",
           "Track", "Verification", "explore", "plot", "reduce"]


def __getattr__(name: str):
    """What needs SciPy or matplotlib is imported when it is asked for."""
    import importlib
    if name in ("reduce", "Reduction"):
        return getattr(importlib.import_module("._reduction", __name__), name)
    if name == "plot":
        return importlib.import_module(".plot", __name__)
    raise AttributeError(f"module 'ricochet' has no attribute '{name}'")
