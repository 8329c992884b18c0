"""Small models of finite-element ones: Craig and Bampton with residual modes.

The boundary of the component are the degrees of freedom that a contact acts on, b; all others are i. The basis is

    x_b = u,   x_i = -K_ii^-1 K_ib u + V eta,

constraint modes and vectors V that leave the boundary at rest: the lowest modes of the structure with fixed boundary
(Craig and Bampton, AIAA J. 6 (1968) 1313-1319), and residual modes of two kinds, made orthonormal to them:

  inertia   K_ii^-1 (M_ib + M_ii Psi): the static answer of the interior to the inertia of the constraint modes, which the
            modes left out would give (Shyu, Hulbert and Ma, AIAA J. 35 (1997) 1390-1396, quasi-static compensation);
  impulse   the interior part of M^-1 b: what an impulse on the boundary sets in motion.

With the impulse vectors in the basis T the mass that a stop feels is that of the whole model, whatever the number of
modes: T (T' M T)^-1 T' M is a projector that leaves M^-1 b alone, so that b' T (T' M T)^-1 T' b = b' M^-1 b = c.c.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Mapping, Sequence, Union

from ._library import InputError
import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg

from ._model import Contact, Model
from ._show import table, text_table

_DEPENDENT = 1e-8  # a residual mode that has less than this part of its norm outside the others is none


@dataclass(eq=False)
class Reduction:
    """A small model of a large one, and how good it is.

    Attributes
    ----------
    mass, stiffness : array [n, n]
        Coordinates are the displacements of `contact_dofs`, then modal amplitudes.
    basis : array [n_full, n]
        Displacements of the whole model are basis @ coordinates.
    contact_dofs : array of int
    n_modes, n_residual : int
        Modes with fixed boundary, and residual modes besides.
    full_frequencies : array, rad/s
        The lowest ones of the whole model, as many as there are modes (12 at most).
    full_compliance : array [len(contact_dofs)], 1 / mass
        c.c of the whole model at each of the contact_dofs.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    basis: np.ndarray
    contact_dofs: np.ndarray
    n_modes: int
    n_residual: int
    full_frequencies: np.ndarray
    full_compliance: np.ndarray
    _nested: list = field(default_factory=list)  # (n modes, frequencies, c.c) of smaller bases without residual modes

    @property
    def frequencies(self) -> np.ndarray:
        """[n] rad/s, ascending, of the small model."""
        return _frequencies(self.mass, self.stiffness)

    @property
    def frequency_errors(self) -> np.ndarray:
        """Relative errors of the lowest frequencies, where the whole model has them above 0."""
        n = len(self.full_frequencies)
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = self.frequencies[:n] / self.full_frequencies - 1
        return np.where(self.full_frequencies > 1e-6 * self.full_frequencies.max(initial=0), errors, np.nan)

    @property
    def compliance(self) -> np.ndarray:
        """[len(contact_dofs)] c.c of the small model; that of the whole one if the impulse residuals are in it."""
        return _compliance(self.mass, len(self.contact_dofs))

    def normal(self, direction: Union[int, Mapping[int, float], Sequence[float]]) -> np.ndarray:
        """[n] the normal of a contact in reduced coordinates.

        Parameters
        ----------
        direction : a degree of freedom of the whole model; or {degree of freedom: factor}; or an array [n_full]
        """
        full = np.zeros(len(self.basis))
        if isinstance(direction, (int, np.integer)):
            direction = {direction: 1.0}
        if isinstance(direction, Mapping):
            full[list(direction)] = list(direction.values())
        else:
            full[:] = direction
        outside = sorted(set(np.flatnonzero(full).tolist()) - set(self.contact_dofs.tolist()))
        if outside:
            raise InputError(f"the contact acts on degree of freedom {outside[0]}, which is none of the contact_dofs "
                             f"{self.contact_dofs.tolist()}: its motion is not kept; reduce again with it")
        return self.basis.T @ full

    def contact(self, direction, clearance=None, **contact) -> Contact:
        """A Contact of the small model; `direction` as in `normal`, the rest as in Contact."""
        return Contact(self.normal(direction), clearance, **contact)

    def model(self, contacts: Sequence[Contact], restitution: float = 1.0) -> Model:
        """The small model with these contacts."""
        return Model(self.mass, self.stiffness, contacts, restitution)

    def expand(self, x: np.ndarray) -> np.ndarray:
        """[..., n_full] displacements of the whole model from those of the small one, [..., n]."""
        return np.asarray(x) @ self.basis.T

    def _frequency_rows(self) -> list:
        return [[i + 1, full, own, error] for i, (full, own, error) in
                enumerate(zip(self.full_frequencies.tolist(), self.frequencies.tolist(), self.frequency_errors.tolist()))]

    def _compliance_rows(self) -> list:
        """How c.c grows with the modes alone, and what residual modes make of it."""
        rows = [[f"{n} modes", *(own / self.full_compliance)] for n, _, own in self._nested]
        rows.append([f"{self.n_modes} modes, {self.n_residual} residual", *(self.compliance / self.full_compliance)])
        return [[name, *map(float, values)] for name, *values in rows]

    def _head(self) -> str:
        return (f"Reduction of {len(self.basis)} degrees of freedom to {len(self.mass)}: {len(self.contact_dofs)} at "
                f"contacts, {self.n_modes} modes, {self.n_residual} residual modes")

    def _headings(self) -> tuple:
        return (["mode", "full rad/s", "reduced rad/s", "relative error"],
                ["c.c over that of the full model", *(f"dof {dof}" for dof in self.contact_dofs)])

    def __repr__(self) -> str:
        first, second = self._headings()
        return "\n".join([self._head(), text_table(first, self._frequency_rows()),
                          text_table(second, self._compliance_rows())])

    def _repr_html_(self) -> str:
        first, second = self._headings()
        return table(first, self._frequency_rows(), self._head()) + table(second, self._compliance_rows())


# ------------------------------------------------------------------ the basis


def _square(value, what: str):
    matrix = scipy.sparse.csc_matrix(value, dtype=float)
    if matrix.shape[0] != matrix.shape[1]:
        raise InputError(f"{what}: a matrix of shape {matrix.shape} is not square")
    asymmetry = abs(matrix - matrix.T).max() if matrix.nnz else 0
    if not np.isfinite(matrix.data).all() or asymmetry > 1e-10 * abs(matrix).max():
        raise InputError(f"{what}: the matrix is not symmetric and finite; the largest difference is {asymmetry:g}")
    return (matrix + matrix.T) / 2


def _lowest(k, m, n: int, shift: float):
    """The n lowest eigenpairs of K phi = omega^2 M phi, with phi' M phi = 1."""
    size = k.shape[0]
    if n >= size - 1 or size < 60:
        values, vectors = scipy.linalg.eigh(k.toarray(), m.toarray(), subset_by_index=[0, min(n, size) - 1])
        return values, vectors
    start = np.random.default_rng(1).standard_normal(size)  # the same one every time, for the same digits
    values, vectors = scipy.sparse.linalg.eigsh(k, n, m, sigma=shift, v0=start)
    order = np.argsort(values)
    return values[order], vectors[:, order]


def _solver(matrix, what: str):
    """x -> matrix^-1 x."""
    try:
        factors = scipy.sparse.linalg.splu(scipy.sparse.csc_matrix(matrix))
    except RuntimeError:
        raise InputError(what) from None
    pivots = abs(factors.U.diagonal())
    if pivots.min() <= 1e-14 * pivots.max():
        raise InputError(what)
    return factors.solve


def _add_independent(vectors: np.ndarray, more: np.ndarray, m) -> np.ndarray:
    """`vectors`, which are M-orthonormal, and what `more` has beside them; Gram and Schmidt, twice."""
    for column in more.T:
        before = np.sqrt(column @ (m @ column))
        if not before > 0:
            continue
        rest = column / before
        for _ in range(2):
            rest = rest - vectors @ (vectors.T @ (m @ rest))
        norm = np.sqrt(rest @ (m @ rest))
        if norm > _DEPENDENT:
            vectors = np.column_stack([vectors, rest / norm])
    return vectors


def _frequencies(mass: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(0, scipy.linalg.eigh(stiffness, mass, eigvals_only=True)))


def _compliance(mass: np.ndarray, n_contact: int) -> np.ndarray:
    return np.diag(np.linalg.inv(mass))[:n_contact].copy()


class _Component:
    """The whole model, cut at the boundary."""

    def __init__(self, m, k, contact_dofs: np.ndarray):
        self.m, self.k, self.b = m, k, contact_dofs
        self.i = np.setdiff1d(np.arange(m.shape[0]), contact_dofs)
        self.m_ii, self.k_ii = m[self.i][:, self.i], k[self.i][:, self.i]
        self.m_ib, self.k_ib = m[self.i][:, self.b].toarray(), k[self.i][:, self.b].toarray()
        self.solve = _solver(self.k_ii, "stiffness: with the contact_dofs held the structure still has a motion without "
                             "a force; hold it by a weak spring, or add the degrees of freedom that lead it to contact_dofs")
        self.psi = -self.solve(self.k_ib)

    def modes(self, n: int) -> np.ndarray:
        return _lowest(self.k_ii, self.m_ii, n, 0.0)[1]

    def inertia(self) -> np.ndarray:
        return self.solve(self.m_ib + self.m_ii @ self.psi)

    def impulse(self, response: np.ndarray) -> np.ndarray:
        return response[self.i] - self.psi @ response[self.b]

    def basis(self, interior: np.ndarray) -> np.ndarray:
        n_b = len(self.b)
        out = np.zeros((self.m.shape[0], n_b + interior.shape[1]))
        out[self.b, np.arange(n_b)] = 1
        out[self.i, :n_b] = self.psi
        out[self.i, n_b:] = interior
        return out

    def project(self, basis: np.ndarray) -> tuple:
        mass, stiffness = basis.T @ (self.m @ basis), basis.T @ (self.k @ basis)
        return (mass + mass.T) / 2, (stiffness + stiffness.T) / 2


def _check_dofs(contact_dofs, size: int) -> np.ndarray:
    dofs = np.unique(np.atleast_1d(np.asarray(contact_dofs)))
    if dofs.size == 0 or dofs.dtype.kind not in "iu" or dofs[0] < 0 or dofs[-1] >= size or dofs.size >= size:
        raise InputError(f"contact_dofs: {contact_dofs!r} are no degrees of freedom of a model that has 0 to {size - 1}, and "
                         "not all of them")
    return dofs.astype(int)


def reduce(mass, stiffness, contact_dofs, n_modes: int, residual: str = "both") -> Reduction:
    """A small model from large sparse matrices, by Craig and Bampton's method with residual modes.

    Parameters
    ----------
    mass, stiffness : SciPy sparse matrix or array [n_full, n_full]
        Symmetric; the mass positive definite.
    contact_dofs : sequence of int
        Degrees of freedom that a contact acts on, from 0. Their displacements stay coordinates of the small model.
    n_modes : int
        Modes with fixed contact_dofs.
    residual : "both", "impulse", "inertia" or "none"
        Residual modes: "impulse" keeps the mass that a stop feels exactly, "inertia" makes the frequencies more accurate.

    Returns
    -------
    Reduction
        Prints what frequencies and c.c are beside those of the whole model. If c.c grows without bound as the *mesh* is
        refined, orbits with a rigid stop do not converge, whatever the reduction; a mass of its own at the contact, or a
        compliant contact, is the cure.
    """
    m, k = _square(mass, "mass"), _square(stiffness, "stiffness")
    if m.shape != k.shape:
        raise InputError(f"stiffness: shape {k.shape}, but the mass matrix has shape {m.shape}")
    if residual not in ("both", "impulse", "inertia", "none"):
        raise InputError(f"residual: '{residual}' is not known; give both, impulse, inertia or none")
    dofs = _check_dofs(contact_dofs, m.shape[0])
    part = _Component(m, k, dofs)
    if not 0 < n_modes <= len(part.i):
        raise InputError(f"n_modes: {n_modes}; the structure with its contact_dofs held has 1 to {len(part.i)}")
    response = _solver(m, "mass: the matrix is singular; every degree of freedom needs a mass")(
        np.eye(m.shape[0])[:, dofs])
    modes = part.modes(n_modes)
    interior = modes
    if residual in ("both", "inertia"):
        interior = _add_independent(interior, part.inertia(), part.m_ii)
    if residual in ("both", "impulse"):
        interior = _add_independent(interior, part.impulse(response), part.m_ii)
    basis = part.basis(interior)
    reduced = part.project(basis)
    shift = -0.01 * float(modes[:, 0] @ (part.k_ii @ modes[:, 0]))
    n_full = min(n_modes, 12, m.shape[0])
    full = np.sqrt(np.maximum(0, _lowest(k, m, n_full, shift)[0]))
    return Reduction(*reduced, basis, dofs, n_modes, interior.shape[1] - n_modes, full, response[dofs].diagonal().copy(),
                     _nested(part, modes))


def _nested(part: _Component, modes: np.ndarray) -> list:
    """Bases of fewer and fewer modes, without residual modes."""
    out, n = [], modes.shape[1]
    for count in sorted({max(1, n // 4), max(1, n // 2), n}):
        mass, stiffness = part.project(part.basis(modes[:, :count]))
        out.append((count, _frequencies(mass, stiffness), _compliance(mass, len(part.b))))
    return out
