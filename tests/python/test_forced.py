"""Responses, loci, censuses and motions under a force are those of the program, to the bit."""
import os
import subprocess

from tap import LONG, NEAR, PROGRAM, Skip, program, raises, run, same

import ricochet
import numpy as np

ELEMENTARY = "examples/elementary/study.yaml"
SMALL = {"energy": [0, 20], "frequency": [0.2, 10], "impacts": 4, "multiply": 2, "depth": 3}
VARY = {"name": "k2", "at": 1, "from": 0.4, "to": 1.6, "stiffness": [[1, -1], [-1, 1]]}


def two_masses(folder, name="a.ricochet", **keys):
    model = ricochet.Model(np.diag([2, 1]), [[9, -1], [-1, 1]], [dict(normal=[-1, 1], clearance=1)])
    study = ricochet.Study(model, "Two masses", **keys, **SMALL)
    return ricochet.explore(study, os.path.join(folder, name))


def study_file(folder, study):
    path = os.path.join(folder, "study.yaml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(study.text)
    return path


NUMBERS = ("arclength", "omega", "restitution", "period", "phase", "largest", "reach", "approach", "residual")


def twin(mine, theirs):
    """The file whose numbers are those of a response: of the same call of the program. With other roundings a curve has other
    points, and the program reads the file that the package has made."""
    return mine if NEAR else theirs


def check_curves(response, path):
    """Every number of a response is that of `ricochet response FILE`."""
    curves, points, events = (program("response", path, *option) for option in ((), ("--points",), ("--events",)))
    names = ("id", "word", "impacts", "periods", "level", "branch", "begins", "ends")
    for one, row in zip(response.curves, curves, strict=True):
        for name in names:
            same(getattr(one, name), row[name], f"curve {one.id} {name}")
        same([end and end.id for end in one.events], [row["from"], row["to"]], "ends of a curve")
        same([len(one), one.varies.min(), one.varies.max(), one.stable.mean()],
             [row[name] for name in ("points", "lowest", "highest", "stable_points")], "what a curve spans")
    for one in response.curves:
        rows = [row for row in points if row["curve"] == one.id]
        assert len(rows) == len(one)
        for name in NUMBERS:
            same(getattr(one, name).tolist(), [row[name] for row in rows], f"curve {one.id} {name}")
        same(one.levels.tolist(), [row["level"] for row in rows], "levels")
        for name in ("state", "flights", "peak", "rms", "multipliers"):
            same(getattr(one, name).tolist(), [row[name] for row in rows], f"curve {one.id} {name}")
        said = ["yes" if yes else "undecided" if not known else "no" for yes, known in zip(one.stable, ~one.undecided)]
        same(said, [row["stable"] for row in rows], "stable")
    for one, row in zip(response.events, events, strict=True):
        for name in (*NUMBERS, "id", "kind", "curve", "level", "stable"):
            same(getattr(one, name), row[name], f"event {one.id} {name}")
        for name in ("state", "flights", "peak", "rms", "multipliers"):
            same(getattr(one, name).tolist(), row[name], f"event {one.id} {name}")
    return len(points)


def test_response(folder):
    """a response has the curves, points and events of `ricochet response`; it is replayed, and reads back"""
    atlas = two_masses(folder)
    mine, theirs = os.path.join(folder, "mine"), os.path.join(folder, "theirs")
    response = atlas.response(mine, [1, 0], level=0.2, omega=(0.3, 3.2), damping=0.01)
    subprocess.run([PROGRAM, "response", atlas.path, "--force", "1,0", "--damping", "0.01", "--level", "0.2", "--omega", "0.3,3.2",
                    "-o", theirs], check=True, capture_output=True)
    assert response.finished and len(response.curves) > 4 and len(response.events) > 4
    assert check_curves(response, twin(mine, theirs)) > 200
    checks, rows = response.verify(workers=2), program("verify", twin(mine, theirs))
    for one, row in zip(checks, rows, strict=True):
        for name, value in row.items():
            same(one[name], value, f"replay {name}")
    assert checks and checks[0].passed and "confirmed" in repr(checks)
    again = ricochet.Response(mine)
    assert (again.curves[2].state == response.curves[2].state).all() and "curves" in repr(again)
    assert "<table" in again._repr_html_() and "<svg" in again.curves[0]._repr_html_() and "Curve 1" in repr(again.curves[0])
    assert "grazing" in " ".join(map(repr, again.events))
    asked = again.asked
    assert asked["window"] == [0.3, 3.2] and asked["level"].tolist() == [0.2] and asked["force"].tolist() == [1, 0]
    assert asked["damping"].tolist() == [0.01] and asked["impacts"] == 12 and asked["harmonic"].tolist() == [1]
    raises(ValueError, "read-only", again.curves[0].omega.__setitem__, 0, 1.0)


def test_along(folder):
    """along the level and the restitution, from a branch, with a matrix; what is wrong is told"""
    atlas = two_masses(folder)
    for along, options, words in (
            ("level", {"level": (0.01, 0.3), "omega": 1.3, "damping": 0.01}, ["--level", "0.01,0.3", "--damping", "0.01"]),
            ("restitution", {"level": 0.3, "omega": 1.3, "damping": [0.01, 0.02], "restitution": (0.8, 1)},
             ["--level", "0.3", "--damping", "0.01,0.02", "--restitution", "0.8,1"])):
        mine, theirs = (os.path.join(folder, f"{along}-{name}") for name in ("mine", "theirs"))
        response = atlas.response(mine, [1, 0], along=along, **options)
        subprocess.run([PROGRAM, "response", atlas.path, "--force", "1,0", "--along", along, "--omega", "1.3", *words, "-o", theirs],
                       check=True, capture_output=True)
        assert response.along == along and response.curves and check_curves(response, twin(mine, theirs))
    none = atlas.response(os.path.join(folder, "none"), [1, 0], level=1e-4, omega=(1, 1.1), damping=0.01, branch="S2+[01]")
    assert not none.curves and "no forced orbit" in repr(none)
    assert not os.path.exists(none.path), "a file without a curve is left"
    path = os.path.join(folder, "wrong")
    raises(ValueError, "window", atlas.response, path, [1, 0], level=1, omega=1.3)
    raises(ValueError, "does not vary", atlas.response, path, [1, 0], level=(0.1, 1), along="level", omega=(1, 2))
    raises(ValueError, "what varies", atlas.response, path, [1, 0], level=1, omega=(1, 2), along="mass")
    raises(ricochet.InputError, "", atlas.response, path, [1, 0, 0], level=1, omega=(1, 2))
    raises(ricochet.FormatError, "not a response", ricochet.Response, atlas.path)
    raises(ricochet.ConflictError, "name another file", atlas.response, os.path.join(folder, "level-mine"), [1, 0], level=0.2, omega=(1, 2),
           damping=0.01)
    assert not os.path.exists(path)


def test_study_keys(folder):
    """damping, restitution and forcing of a study are kept, told, and taken where nothing else is given"""
    forcing = {"vector": [1, 0], "amplitude": [0.1, 0.2], "frequency": [1.2, 1.5], "harmonic": 1}
    atlas = two_masses(folder, damping=np.array([0.01, 0.02]), restitution=0.95, forcing=forcing, vary=VARY)
    own = atlas.study.forcing
    assert own.force.tolist() == [1, 0] and own.damping.tolist() == [0.01, 0.02] and own.restitution == 0.95
    assert own.amplitude.tolist() == [0.1, 0.2] and own.frequency == (1.2, 1.5) and own.harmonic.tolist() == [1]
    assert atlas.study.vary["stiffness"].tolist() == VARY["stiffness"] and atlas.study.vary["mass"] is None
    for text in ("damping", "forcing", "vary"):
        assert text in repr(atlas.study) and text in atlas.study._repr_html_()
    bare = two_masses(folder, "b.ricochet")
    assert bare.study.forcing is None and bare.study.vary is None and "damping" not in repr(bare.study)
    branch = atlas.branch("S2+[01]")
    same(atlas.shaking().predict(branch.orbit(energy=5)).threshold,
         program("force", atlas.path, "--branch", branch.id, "--energy", 5)[0]["threshold"], "threshold")
    mine, theirs = os.path.join(folder, "mine"), os.path.join(folder, "theirs")
    response = atlas.response(mine)
    subprocess.run([PROGRAM, "response", atlas.path, "-o", theirs], check=True, capture_output=True)
    assert check_curves(response, twin(mine, theirs)) and {one.level for one in response.curves} == {0.1, 0.2}
    other = ricochet.Study(atlas.model, damping={"alpha": 0.1, "beta": 1e-3}, forcing={"coordinate": 2})
    wanted = 0.1 * atlas.model.mass + 1e-3 * atlas.model.stiffness
    assert (other.forcing.damping == wanted).all() and other.forcing.force.tolist() == [0, 1]
    assert other.forcing.frequency is None and other.forcing.amplitude.size == 0
    same(bare.shaking(study=other).predict(branch.orbit(energy=5)).loss_damping,
         program("force", bare.path, "--study", study_file(folder, other), "--branch", branch.id, "--energy", 5)[0]["loss_damping"],
         "loss")
    raises(ricochet.InputError, "force is missing", bare.shaking)
    raises(ricochet.InputError, "damping", two_masses, folder, damping=-1)
    stranger = ricochet.Study(ricochet.Model(np.eye(2), [[9, -1], [-1, 1]], [dict(normal=[-1, 1], clearance=1)]), damping=0.1)
    raises(ricochet.InputError, "another structure", bare.shaking, [1, 0], study=stranger)


def test_shaken_motion(folder):
    """a motion under damping and a force is that of `ricochet simulate`"""
    study = ricochet.Study.read(ELEMENTARY)
    x, v = [0.1, 0.2], [1.5, -0.5]
    for given, words in (({"force": [1, 0], "omega": 1.3, "level": 0.4, "phase": 0.5, "damping": 0.02, "restitution": 0.9},
                          ["--force", "1,0", "--omega", 1.3, "--level", 0.4, "--phase", 0.5, "--damping", 0.02, "--restitution", 0.9]),
                         ({"damping": [0.02, 0.01]}, ["--damping", "0.02,0.01"]), ({"restitution": 0.5}, ["--restitution", 0.5])):
        found = study.model.simulate(x, v, 12, steps=7, **given)
        call = ("simulate", ELEMENTARY, "--state", *x, *v, "--time", 12, *words)
        for k, row in enumerate(program(*call, "--steps", 7)):
            same([found.t[k], *found.x[k], *found.v[k]], list(row.values()), "motion")
        for impact, row in zip(found.impacts, program(*call, "--impacts"), strict=True):
            same([one.item() for one in impact], list(row.values()), "impact")
    raises(ricochet.InputError, "omega", study.model.simulate, x, v, 1, force=[1, 0])
    raises(ricochet.InputError, "", study.model.simulate, x, v, 1, force=[1, 0, 0], omega=1)


def test_locus(folder):
    """a locus has the points of `ricochet locus`, from the study of the atlas, another one or a dict"""
    atlas, plain = two_masses(folder, vary=VARY), two_masses(folder, "b.ricochet")
    points = 0
    for kind in ("grazing", "branch-point", "extremum"):
        junction = next(one for one in atlas.junctions if one.kind == kind)
        rows = program("locus", atlas.path, "--junction", junction.id, "--values", "0.6,1.3")
        other = ricochet.Study(plain.model, vary=VARY)
        for found in (atlas.locus(junction, (0.6, 1.3)), plain.locus(junction.id, [0.6, 1.3], vary=VARY),
                      plain.locus(junction.label, [0.6, 1.3], vary=other)):
            assert found.parameter == "k2" and len(found) == len(rows) and found.junction.id == junction.id
            for name in ("value", "energy", "frequency", "mark", "what", "length", "residual", "state", "flights"):
                column = getattr(found, name)
                same(column if isinstance(column, list) else column.tolist(), [row[name] for row in rows], name)
            assert len(found.marked("start")) == 1 and len(found.marked("asked")) >= 1 and "Locus of" in repr(found)
            assert found._repr_html_().count("<table") == 1
        points += len(rows)
    assert points > 100
    raises(ricochet.InputError, "section vary", plain.locus, 2)
    raises(ricochet.InputError, "vary", plain.locus, 2, vary={"name": "k2"})


def test_census(folder):
    """a census has the orbits of `ricochet prove --complete`, and says what it has looked at"""
    atlas = two_masses(folder)
    path, most = study_file(folder, atlas.study), 3 if LONG else 2
    try:
        census = atlas.census(5, most, workers=2)
    except ricochet.InputError as why:
        raise Skip(str(why)) if "FLINT" in str(why) else why
    rows = program("prove", "--complete", path, "--energy", 5, "--impacts", most)
    assert census.complete and len(rows) > 1 and census.account.boxes > 100
    for one, row in zip(census, rows, strict=True):
        for name in ("word", "impacts", "period", "frequency", "symmetric", "reversible", "stable", "trace", "approach"):
            same(getattr(one, name), row[name], name)
        for name in ("period_within", "trace_within", "state", "flights"):
            same(list(getattr(one, name)), row[name], name)
    assert "complete: " in repr(census) and "<table" in census._repr_html_() and (census.column("period") > 0).all()
    short = atlas.model.census(5, 3, seconds=1e-9)
    assert short.account.stopped and not short.complete and short.account.undecided and "not complete" in repr(short)
    raises(ricochet.InputError, "", atlas.census, 5, 99)


run([test_response, test_along, test_study_keys, test_shaken_motion, test_locus, test_census])
