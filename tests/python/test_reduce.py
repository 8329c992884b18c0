"""Reduction of sparse matrices: closed forms, what is kept exactly, and refusals."""
import math

from tap import raises, run

import ricochet
import numpy as np
import scipy.linalg
import scipy.sparse

CANTILEVER = (1.875104068711961, 4.694091132974175, 7.854757438237613)  # roots of cos x cosh x = -1


def beam(n, tip=0.0):
    """A cantilever of unit length, stiffness and mass with n elements (Hermite cubics); a mass at its end."""
    h, size = 1 / n, 2 * (n + 1)
    k = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h], [-12, -6 * h, 12, -6 * h],
                  [6 * h, 2 * h * h, -6 * h, 4 * h * h]]) / h**3
    m = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h], [54, 13 * h, 156, -22 * h],
                  [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]) * h / 420
    mass, stiffness = scipy.sparse.lil_matrix((size, size)), scipy.sparse.lil_matrix((size, size))
    for e in range(n):
        place = np.ix_(range(2 * e, 2 * e + 4), range(2 * e, 2 * e + 4))
        mass[place], stiffness[place] = mass[place] + m, stiffness[place] + k
    mass[size - 2, size - 2] += tip
    return mass.tocsc()[2:, 2:], stiffness.tocsc()[2:, 2:]


def test_closed_form(folder):
    """frequencies of a cantilever are those of the books"""
    mass, stiffness = beam(60)
    small = ricochet.reduce(mass, stiffness, [118], 6)
    wanted = np.square(CANTILEVER)
    assert np.allclose(small.frequencies[:3], wanted, rtol=2e-6), small.frequencies[:3] / wanted - 1
    assert np.allclose(small.full_frequencies[:3], wanted, rtol=2e-6)
    assert np.nanmax(np.abs(small.frequency_errors[:4])) < 1e-6 and (small.frequency_errors > -1e-7).all()


def test_convergence(folder):
    """errors of frequencies fall with the modes, and residual inertia makes them smaller"""
    mass, stiffness = beam(40, tip=0.1)
    last = np.inf
    for n in (2, 4, 8, 16):
        plain, better = (ricochet.reduce(mass, stiffness, [78], n, residual) for residual in ("none", "inertia"))
        error = plain.frequency_errors[0]
        assert -1e-9 < error < last / 4 or error < 1e-9, (n, error, last)
        assert abs(better.frequency_errors[0]) < max(1e-8, plain.frequency_errors[0] / 50)
        last = error


def test_mass_at_the_contact(folder):
    """the mass that a stop feels is that of the whole model with impulse residuals, and less without"""
    mass, stiffness = beam(30, tip=0.2)
    dense = np.linalg.inv(mass.toarray())
    for dofs in ([58], [10, 58], [58, 59, 20]):
        for residual in ("both", "impulse"):
            small = ricochet.reduce(mass, stiffness, dofs, 3, residual)
            wanted = np.diag(dense)[sorted(dofs)]
            assert np.allclose(small.full_compliance, wanted, rtol=1e-9)
            assert np.allclose(small.compliance, wanted, rtol=1e-9), small.compliance / wanted - 1
        without = ricochet.reduce(mass, stiffness, dofs, 3, "none")
        assert (without.compliance < wanted * (1 - 1e-3)).all()
    # between two degrees of freedom too: b' M^-1 b of a relative displacement
    small = ricochet.reduce(mass, stiffness, [20, 58], 3)
    b, full = small.normal({20: 1, 58: -1}), np.zeros(60)
    full[[20, 58]] = 1, -1
    model = small.model([small.contact({20: 1, 58: -1}, clearance=0.1)])
    assert math.isclose(model.compliance()[-1], full @ dense @ full, rel_tol=1e-9)
    assert np.allclose(b @ np.linalg.solve(small.mass, b), full @ dense @ full, rtol=1e-9)


def test_all_modes(folder):
    """with all modes the small model is the whole one"""
    mass, stiffness = beam(6)
    small = ricochet.reduce(mass, stiffness, [10], 11)
    whole = np.sqrt(scipy.linalg.eigh(stiffness.toarray(), mass.toarray(), eigvals_only=True))
    assert len(small.mass) == 12 and small.n_residual == 0
    assert np.allclose(small.frequencies, whole, rtol=1e-7)


def test_static(folder):
    """a force on the contact bends the small model as the whole one"""
    mass, stiffness = beam(25)
    small = ricochet.reduce(mass, stiffness, [48], 2)
    force = small.normal(48)
    x = small.expand(np.linalg.solve(small.stiffness, force))
    full = np.zeros(50)
    full[48] = 1
    assert np.allclose(x, scipy.sparse.linalg.spsolve(stiffness, full), rtol=1e-8)
    assert math.isclose(x[48], 1 / 3, rel_tol=1e-8)  # force L^3 / (3 EI)


def test_free_body(folder):
    """a structure that nothing holds keeps its rigid motion"""
    n = 40
    stiffness = scipy.sparse.diags([-np.ones(n - 1), np.r_[1, 2 * np.ones(n - 2), 1], -np.ones(n - 1)], [-1, 0, 1]).tocsc()
    small = ricochet.reduce(scipy.sparse.identity(n), stiffness, [n - 1], 5)
    assert small.frequencies[0] < 1e-7 and np.isnan(small.frequency_errors[0]) and small.full_frequencies[1] > 0.05
    assert np.nanmax(np.abs(small.frequency_errors)) < 1e-3 and math.isclose(small.compliance[0], 1, rel_tol=1e-9)


def test_same_digits(folder):
    """the same matrices give the same digits"""
    mass, stiffness = beam(80)
    first, second = (ricochet.reduce(mass, stiffness, [158], 6) for _ in range(2))
    assert (first.mass == second.mass).all() and (first.stiffness == second.stiffness).all()


def test_refusals(folder):
    """what cannot be reduced is told"""
    mass, stiffness = beam(10)
    raises(ricochet.InputError, "contact_dofs", ricochet.reduce, mass, stiffness, [20], 3)
    raises(ricochet.InputError, "contact_dofs", ricochet.reduce, mass, stiffness, [], 3)
    raises(ricochet.InputError, "contact_dofs", ricochet.reduce, mass, stiffness, [0.5], 3)
    raises(ricochet.InputError, "n_modes", ricochet.reduce, mass, stiffness, [18], 0)
    raises(ricochet.InputError, "residual", ricochet.reduce, mass, stiffness, [18], 3, "all")
    raises(ricochet.InputError, "symmetric", ricochet.reduce, mass, stiffness + scipy.sparse.eye(20, k=1), [18], 3)
    raises(ricochet.InputError, "without a force", ricochet.reduce, np.eye(4), np.diag([1, 1, 0, 1]), [0], 1)
    raises(ricochet.InputError, "singular", ricochet.reduce, np.diag([1, 1, 0, 1.0]), np.eye(4), [0], 1)
    small = ricochet.reduce(mass, stiffness, [18], 3)
    raises(ricochet.InputError, "none of the contact_dofs", small.normal, 4)


def test_shows(folder):
    """a reduction says how good it is"""
    small = ricochet.reduce(*beam(20, tip=0.5), [38], 4)
    for text in ("relative error", "c.c over", "residual modes", "1 modes"):
        assert text in repr(small) and text in small._repr_html_(), repr(small)


def test_atlas(folder):
    """from sparse matrices, with a mass that hangs on a spring, to an atlas that verifies"""
    mass, stiffness = (scipy.sparse.block_diag([one, [[value]]], "lil") for one, value in zip(beam(40), (0.2, 20)))
    stiffness[78, 78] += 20
    stiffness[78, 80] = stiffness[80, 78] = -20
    small = ricochet.reduce(mass, stiffness, [80], 1, "none")
    assert small.full_compliance[0] == 5 and 0.96 < small.compliance[0] / 5 < 0.99 and len(small.mass) == 2
    model = small.model([small.contact(80, clearance=0.01)])
    first, energy = model.frequencies[0], model.grazing_energies[0]
    study = ricochet.Study(model, energy=[0, 10 * energy], frequency=[first / 2, 2 * first], impacts=2, multiply=1, depth=1,
                           start=[1])
    atlas = ricochet.explore(study, folder + "/beam.ricochet")
    assert atlas.branch("S2+[01]").energy_max > 5 * energy and atlas.verify()
    orbit = atlas.branch("S2+[01]").point(20)
    assert np.isclose(abs(small.expand(orbit.x)[80]), 1, rtol=1e-9), "it is at the stop at its first impact"


run([test_closed_form, test_convergence, test_mass_at_the_contact, test_all_modes, test_static, test_free_body, test_same_digits,
     test_refusals, test_shows, test_atlas])
