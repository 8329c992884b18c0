"""What is around the orbits: sections, forces and proofs, to the bit as the program has them."""
import os
import subprocess

from tap import PROGRAM, Skip, program, raises, run, same

import ricochet
import numpy as np


def explored(folder):
    path = os.path.join(folder, "a.ricochet")
    return ricochet.explore("examples/elementary/study.yaml", path)


def test_section(folder):
    """a section has the impacts, rotation numbers and exponents of `ricochet section`"""
    atlas = explored(folder)
    section = atlas.section(5, 6, 40, workers=2)
    rows = program("section", atlas.path, "--energy", 5, "--starts", 6, "--impacts", 40)
    assert len(section) == 6 and all(np.isfinite(one.times).all() and len(one.times) == one.impacts for one in section)
    assert sum(one.impacts for one in section) == len(rows) > 200
    for one in section:
        for k, row in enumerate(row for row in rows if row["start"] == one.start):
            same(one.times[k], row["time"], "time")
            assert one.faces[k] == row["face"]
            for i in range(2):
                same(one.x[k, i], row[f"x{i + 1}"], "x")
                same(one.v[k, i], row[f"v{i + 1}"], "v")
            for name in ("rotation", "lyapunov", "lyapunov_error"):
                same(getattr(one, name), row[name], name)
    energies = [atlas.model.energy(one.x[-1], one.v[-1]) for one in section]
    assert np.allclose(energies, 5, rtol=1e-11) and all((np.hypot(*one.places.T) <= 1 + 1e-12).all() for one in section)
    orbit = atlas.branch("S2+[01]").orbit(energy=5)
    again = atlas.section(5, impacts=4, states=orbit.state)
    assert len(again) == 1 and np.allclose(again[0].x[2], orbit.x, atol=1e-9)
    assert "<table" in section._repr_html_() and "6 motions" in repr(section)
    raises(ValueError, "are 4", atlas.section, 5, states=[1, 2, 3])


def test_force(folder):
    """predictions of a force, and exact orbits, are those of `ricochet force`; what is wrong is told"""
    atlas = explored(folder)
    branch = atlas.branch("S2+[01]")
    shaken = atlas.shaking([0, 1], damping=0.005, restitution=0.99)
    told = shaken.predict(branch.orbit(energy=5))
    common = ("force", atlas.path, "--force", "0,1", "--damping", 0.005, "--restitution", 0.99, "--branch", branch.id, "--energy", 5)
    row = next(row for row in program(*common) if row["harmonic"] == 1)
    for name in ("energy", "frequency", "omega", "loss_damping", "loss_impacts", "threshold", "threshold_impacts", "slope", "estimate"):
        same(getattr(told, name), row[name], name)
    same(told.work, row["work"], "work")
    same(told.stable, row["stable"], "stable")
    shaken = atlas.shaking([0, 1], damping=0.005)
    level = 1.3 * shaken.predict(branch.orbit(energy=5)).threshold
    exact = shaken.solve(branch.orbit(energy=5), level=level)
    assert exact and exact.residual < 1e-11 and exact.multipliers.shape == (4,) and abs(abs(exact.multipliers).max() / exact.largest - 1) < 1e-9
    below = shaken.solve(branch.orbit(energy=5), level=0.5 * level / 1.3)
    assert not below and "threshold" in below.fault
    for damping in (np.diag([0.02, 0.01]), [0.005, 0.005]):
        assert atlas.shaking([0, 1], damping).predict(branch.orbit(energy=5)).loss_damping > 0
    raises(ValueError, "square matrix", atlas.shaking, [0, 1], [[1, 2]])
    raises(ricochet.InputError, "", atlas.shaking, [0, 1, 2])


def test_proofs(folder):
    """proofs are those of `ricochet prove`; what the file keeps is read; certificates are accepted by the checker"""
    if not ricochet._lib.ric_prover_available():
        raise Skip("the library was built without FLINT")
    atlas = explored(folder)
    branch = atlas.branch("S2+[01]")
    proofs = atlas.prove(branch.id, points=[10, 20, -5], workers=2)
    assert proofs and len(proofs) == 3 and all(one.proved for one in proofs) and proofs[2].point == len(branch) - 5
    rows = {row["point"]: row for row in program("prove", atlas.path, "--branch", branch.id)}
    for one in proofs:
        row = rows[one.point]
        for name in ("bits", "exists", "unique"):
            if name in row:
                same(getattr(one, name), row[name], name)
        assert one.energy[0] <= branch.energy[one.point] <= one.energy[1] or one.energy[0] < one.energy[1]
        assert one.energy[1] - one.energy[0] < 1e-9 and one.exists <= one.unique
    path = os.path.join(folder, "proofs.jsonl")
    proofs.save(path)
    checked = subprocess.run(["tools/python", "tools/check_certificate.py", path], capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    kept = ricochet.Atlas(atlas.path).branch(branch.id).proof(10)
    assert kept is not None and kept.proved and kept.exists == proofs[0].exists
    assert ricochet.Atlas(atlas.path).branch("S2-[01]").proof(3) is None
    assert "3 of 3" in repr(proofs)


if __name__ == "__main__":
    run([test_section, test_force, test_proofs])
