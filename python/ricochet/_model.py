"""Structures: masses, stiffnesses and contacts."""
from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Optional, Sequence, Union

from ._library import InputError, check, copy_of, ffi, filled, lib, pointer, text_of
import numpy as np

from ._show import table, text_table

_SIDES = {"both": lib.RIC_SIDES_BOTH, "upper": lib.RIC_SIDES_UPPER, "lower": lib.RIC_SIDES_LOWER}
_LAWS = {"rigid": lib.RIC_LAW_RIGID, "bilinear": lib.RIC_LAW_BILINEAR, "power": lib.RIC_LAW_POWER}


@dataclass(frozen=True, eq=False)
class Contact:
    """A place where the motion is stopped, with the gap coordinate s = normal . x.

    Parameters
    ----------
    normal : array [n_dof]
        Direction of the gap coordinate; not scaled, so that s is a length if its entries are pure numbers.
    clearance : float, length
        d > 0 of laws rigid and bilinear.
    sides : "both", "upper" (s <= d) or "lower" (s >= -d)
    law : "rigid" (an impact), "bilinear" (force -stiffness (s - d) beyond d) or "power" (force -stiffness s^exponent, or
        -reference length (s / length)^exponent)
    stiffness : float, force / length (bilinear) or force / length^exponent (power)
    exponent : odd int, 3 to 99, of law power
    length, reference : float, length and force / length, of law power in the place of a stiffness
    name : str
    """

    normal: np.ndarray
    clearance: Optional[float] = None
    sides: str = "both"
    law: str = "rigid"
    stiffness: Optional[float] = None
    exponent: Optional[int] = None
    length: Optional[float] = None
    reference: Optional[float] = None
    name: Optional[str] = None

    def __post_init__(self):
        object.__setattr__(self, "normal", np.array(self.normal, float).ravel())
        for what, value, known in (("sides", self.sides, _SIDES), ("law", self.law, _LAWS)):
            if value not in known:
                raise InputError(f"contact: {what} '{value}' is not known; give one of {', '.join(known)}")

    def __repr__(self) -> str:
        given = [f"{field.name}={getattr(self, field.name)!r}" for field in fields(self)[1:]
                 if getattr(self, field.name) != field.default]
        return f"Contact({', '.join([repr(self.normal.tolist()), *given])})"


def _matrix(value, what: str) -> np.ndarray:
    """Dense, row by row; SciPy's sparse matrices are taken too."""
    try:
        array = np.array(value.toarray() if hasattr(value, "toarray") else value, dtype=float, order="C")
    except (TypeError, ValueError) as wrong:
        raise InputError(f"{what}: no matrix of numbers: {wrong}") from None
    if array.ndim != 2 or array.shape[0] != array.shape[1] or array.size == 0:
        hint = "; numpy.diag makes one with these on its diagonal" if array.ndim == 1 else ""
        raise InputError(f"{what}: an array of shape {array.shape} is no square matrix{hint}")
    return array


class Model:
    """A linear structure with contacts.

    Parameters
    ----------
    mass : array [n_dof, n_dof]
        Symmetric positive definite; a NumPy array, nested lists or a SciPy sparse matrix. Physical units.
    stiffness : array [n_dof, n_dof]
        Symmetric positive semidefinite.
    contacts : sequence of Contact, or of dicts with its parameters
    restitution : float in [0, 1]
        An atlas needs 1; the simulator takes all.

    What a model tells is in physical units, and energies are scaled: divided by `length` squared.
    """

    def __init__(self, mass, stiffness, contacts: Sequence[Union[Contact, dict]], restitution: float = 1.0):
        m, k = _matrix(mass, "mass"), _matrix(stiffness, "stiffness")
        if k.shape != m.shape:
            raise InputError(f"stiffness: shape {k.shape}, but the mass matrix has shape {m.shape}")
        if isinstance(contacts, (Contact, dict)):
            contacts = [contacts]
        listed = [one if isinstance(one, Contact) else Contact(**one) for one in contacts]
        for one in listed:
            if one.normal.size != len(m):
                raise InputError(f"contact: a normal of {one.normal.size} numbers, but the structure has {len(m)} degrees "
                                 "of freedom")
        raw, keep = ffi.new("ric_contact[]", max(1, len(listed))), []
        for i, one in enumerate(listed):
            keep += _fill(raw[i], one)
        out = ffi.new("ric_model **")
        check(lib.ric_model_create(len(m), pointer(m), pointer(k), len(listed), raw, float(restitution), out))
        self._take(ffi.gc(out[0], lib.ric_model_free), None)

    def _take(self, handle, owner) -> Model:
        self._handle, self._owner = handle, owner
        return self

    @classmethod
    def _borrow(cls, handle, owner) -> Model:
        """That of a study or an atlas, `owner`, which lives as long."""
        return cls.__new__(cls)._take(ffi.cast("ric_model *", handle), owner)

    @property
    def n_dof(self) -> int:
        """Degrees of freedom."""
        return lib.ric_model_n_dof(self._handle)

    @property
    def n_mode(self) -> int:
        """Modes that some contact sees."""
        return lib.ric_model_n_mode(self._handle)

    @property
    def n_face(self) -> int:
        """Faces: sides of rigid and bilinear contacts."""
        return lib.ric_model_n_face(self._handle)

    @property
    def n_part(self) -> int:
        """Independent parts: groups of modes that no contact joins."""
        return lib.ric_model_n_part(self._handle)

    @property
    def symmetric(self) -> bool:
        """Whether x -> -x maps the structure to itself."""
        return lib.ric_model_symmetric(self._handle)

    @property
    def length(self) -> float:
        """d, by which lengths are scaled: clearance or length of the first contact."""
        return lib.ric_model_length(self._handle)

    @property
    def restitution(self) -> float:
        """Coefficient of restitution."""
        return lib.ric_model_restitution(self._handle)

    @property
    def mass(self) -> np.ndarray:
        """[n_dof, n_dof], as given."""
        return copy_of(lib.ric_model_mass(self._handle), self.n_dof**2).reshape(self.n_dof, -1)

    @property
    def stiffness(self) -> np.ndarray:
        """[n_dof, n_dof], as given."""
        return copy_of(lib.ric_model_stiffness(self._handle), self.n_dof**2).reshape(self.n_dof, -1)

    @property
    def contacts(self) -> list:
        """The contacts, as given."""
        return [self._contact(i) for i in range(lib.ric_model_n_contact(self._handle))]

    def _contact(self, i: int) -> Contact:
        raw = ffi.new("ric_contact *")
        check(lib.ric_model_contact(self._handle, i, raw))
        numbers = {name: getattr(raw, name) or None for name in ("clearance", "stiffness", "exponent", "length",
                                                                  "reference")}
        return Contact(copy_of(raw.normal, self.n_dof), sides=_key(_SIDES, raw.sides), law=_key(_LAWS, raw.law),
                       name=text_of(raw.name) or None, **numbers)

    @property
    def frequencies(self) -> np.ndarray:
        """[n_dof] natural frequencies, ascending, rad/s; 0 of rigid motions."""
        return filled(self.n_dof, lambda out: lib.ric_model_frequencies(self._handle, out))

    @property
    def modes(self) -> np.ndarray:
        """[n_dof, n_dof] mass-normalised mode shapes, one a column."""
        return filled((self.n_dof, self.n_dof), lambda out: lib.ric_model_modes(self._handle, out))

    @property
    def seen(self) -> np.ndarray:
        """[n_dof] whether a contact sees the mode; what none sees stays linear for ever."""
        return filled(self.n_dof, lambda out: lib.ric_model_seen(self._handle, out), bool)

    @property
    def modal_normals(self) -> np.ndarray:
        """[n_contact, n_dof] c = modes^T normal."""
        shape = (lib.ric_model_n_contact(self._handle), self.n_dof)
        return filled(shape, lambda out: lib.ric_model_modal_normals(self._handle, out))

    @property
    def grazing_energies(self) -> np.ndarray:
        """[n_dof] scaled energy at which a linear mode first touches a contact; inf where it never does."""
        contact = np.zeros(self.n_dof, np.intc)
        return filled(self.n_dof, lambda out: lib.ric_model_grazing_energies(self._handle, out, pointer(contact)))

    def locked_frequencies(self, contact: int = 0) -> np.ndarray:
        """[n_dof - 1] rad/s, of the structure with this contact closed for good (s = 0)."""
        out = filled(self.n_dof, lambda out: lib.ric_model_locked_frequencies(self._handle, contact, out))
        return out[:-1]

    def compliance(self, contact: int = 0) -> np.ndarray:
        """[n_dof] 1 / mass: c.c of the lowest k modes, k = 1..n_dof; the last one is normal . M^-1 normal.

        A rigid stop feels the mass 1 / c.c. Where c.c goes on growing with the modes, impact orbits do not converge.
        """
        return filled(self.n_dof, lambda out: lib.ric_model_compliance(self._handle, contact, out))

    def energy(self, x, v) -> float:
        """Scaled energy of scaled displacements x [n_dof] and velocities v [n_dof, 1/s]."""
        x, v = self._vector(x, "x"), self._vector(v, "v")
        return lib.ric_model_energy(self._handle, pointer(x), pointer(v))

    def section(self, energy: float, starts: Optional[int] = None, impacts: Optional[int] = None, states=None,
                radius: float = 0, rows: bool = True, workers: int = 1, progress: Optional[bool] = None):
        """Motions of one scaled energy on the section, where a motion is right after an impact.

        Parameters
        ----------
        energy : float, scaled
        starts : int
            How many, a fixed sequence that fills the section evenly; as many as `ricochet section` takes unless given.
        impacts : int
            Of each start.
        states : array [k, 2 n_dof]
            Instead: starts at these scaled states, x then v, or within `radius` of the section about them.
        rows : bool
            Whether to keep the impacts, not only what is said of each start.
        workers : int

        Returns
        -------
        Section
        """
        from ._section import section
        return section(self, energy, starts, impacts, states, radius, rows, workers, progress)

    def census(self, energy: float, impacts: int = 3, period: Optional[float] = None, workers: int = 1,
               seconds: Optional[float] = None, progress: Optional[bool] = None):
        """All periodic orbits of one scaled energy with few impacts, as a theorem, by ball arithmetic. Experimental.

        For structures of which rigid stops see two modes.

        Parameters
        ----------
        energy : float, scaled
        impacts : int
            Of the longest words, at most 6.
        period : float, s
            Longest period; unless given, any.
        workers : int
        seconds : float
            When these are over what was not looked at is counted as undecided.

        Returns
        -------
        Census
        """
        from ._census import census
        return census(self, energy, impacts, period, workers, seconds, progress)

    def simulate(self, x, v, time: float, steps: int = 200, impacts: int = 1000000, force=None, omega: float = 0,
                 level: float = 1, phase: float = 0, damping=None, restitution: Optional[float] = None):
        """The motion from a scaled state, found impact by impact by a simulator that knows nothing of orbits.

        Parameters
        ----------
        x, v : array [n_dof]
            Scaled displacements, and velocities in 1/s.
        time : float, s
        steps : int
            Of the history.
        impacts : int
            After so many an Error says so: a loose mass may have as many as one likes.
        force : array [n_dof]
            Shaken by level force cos(omega t + phase) from time 0 on, physical; omega in rad/s.
        damping : float, array [n_dof] or array [n_dof, n_dof]
            Modal ratios, one for all modes or one for each, or a damping matrix, physical.
        restitution : float
            Instead of that of the model.

        Returns
        -------
        Simulation
        """
        from ._simulation import shaken, simulate
        given = shaken(self, force, omega, level, phase, damping, restitution)
        return simulate(self, self._vector(x, "x"), self._vector(v, "v"), time, steps, impacts, given)

    def _vector(self, value, what: str) -> np.ndarray:
        array = np.array(value, float).ravel()
        if array.size != self.n_dof:
            raise InputError(f"{what}: {array.size} numbers, but the structure has {self.n_dof} degrees of freedom")
        return array

    def _rows(self) -> list:
        names = [number + 1 for number in range(self.n_dof)]
        return list(zip(names, self.frequencies.tolist(), ["yes" if seen else "no" for seen in self.seen],
                        self.grazing_energies.tolist()))

    def _head(self) -> str:
        contacts = self.contacts
        return (f"Model of {self.n_dof} degree{'s' * (self.n_dof != 1)} of freedom, {self.n_mode} seen by "
                f"{len(contacts)} contact{'s' * (len(contacts) != 1)} ({', '.join(one.law for one in contacts)})")

    def __repr__(self) -> str:
        return self._head() + "\n" + text_table(_HEADING, self._rows())

    def _repr_html_(self) -> str:
        return table(_HEADING, self._rows(), self._head())


_HEADING = ["mode", "omega rad/s", "seen", "first touch at scaled energy"]


def _key(known: dict, value: int) -> str:
    return next(name for name, number in known.items() if number == value)


def _fill(raw, one: Contact) -> list:
    """Fills a ric_contact; returns what must live as long as it."""
    normal = np.ascontiguousarray(one.normal)
    keep = [normal, pointer(normal), ffi.new("char[]", (one.name or "").encode())]
    raw.normal = keep[1]
    raw.name = keep[2] if one.name else ffi.NULL
    raw.sides, raw.law = _SIDES[one.sides], _LAWS[one.law]
    for name in ("clearance", "stiffness", "exponent", "length", "reference"):
        setattr(raw, name, getattr(one, name) or 0)
    return keep
