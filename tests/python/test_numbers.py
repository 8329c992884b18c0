"""Every number of the package is that of the program, to the bit, over all examples."""
import glob
import json
import math
import os
import subprocess

from tap import LONG, NEAR, PROGRAM, near, run

import ricochet
import numpy as np

STUDIES = sorted(glob.glob("examples/*/study.yaml"))[::3 if NEAR else 1 if LONG else 2] + (sorted(glob.glob("examples/paper/*.yaml")) if LONG else [])
SECONDS = 60 if LONG else 0.4  # of an exploration: what there is then is compared
BRANCHES = 10**6 if LONG else 4  # of an atlas, whose points and orbits are compared


def program(*arguments):
    """The rows that a command of the program prints as JSON."""
    done = subprocess.run([PROGRAM, *map(str, arguments), "--json"], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1, 3) and done.stdout, (arguments, done.stderr)
    return json.loads(done.stdout)


compared = 0  # numbers, texts and flags


def same(found, wanted, where):
    """Equal bit by bit; what is no finite number is null in JSON."""
    global compared
    compared += not isinstance(wanted, list)
    if isinstance(wanted, list):
        assert len(found) == len(wanted), (where, found, wanted)
        for i, (a, b) in enumerate(zip(found, wanted)):
            same(a, b, f"{where}[{i}]")
    elif isinstance(wanted, float) or isinstance(found, float):
        value = float(found)
        if not math.isfinite(value):
            assert wanted is None or isinstance(wanted, str), (where, found, wanted)
        else:
            assert wanted is not None and (value == float(wanted) or NEAR and near(value, float(wanted))), (where, found, wanted)
    else:
        assert found == wanted, (where, found, wanted)


def same_complex(found, wanted, where):
    """Complex numbers as the program prints them; with other roundings the one of a pair may come before the other."""
    if not NEAR:
        return same([[value.real, value.imag] for value in found], wanted, where)
    known = [complex(*row) for row in wanted if None not in row]
    assert len(found) == len(wanted) and all(any(near(value, one) for value in found) for one in known), (where, found, wanted)


def word_said(stable, undecided):
    return "yes" if stable else "undecided" if undecided else "no"


def check_branches(atlas):
    for one, row in zip(atlas.branches, program("branches", atlas.path), strict=True):
        ends = [end.id if end else None for end in one.ends]
        for name in ("id", "label", "word", "impacts", "symmetric", "reversible", "mirror", "stable_fraction", "energy_min",
                     "energy_max", "frequency_min", "frequency_max", "stop", "why", "depth"):
            same(getattr(one, name), row[name], f"branch {one.id} {name}")
        same(ends, [row["from"], row["to"]], f"branch {one.id} ends")
        same([other.id for other in one.junctions], row["junctions"], f"branch {one.id} junctions")
        same(one.junction_arclengths.tolist(), row["junction_arclengths"], f"branch {one.id} arclengths")
        assert len(one) == row["points"] and (one.mode or None) == row["mode"]
        if "key" in row:
            assert one.key == row["key"]


def check_junctions(atlas):
    for one, row in zip(atlas.junctions, program("junctions", atlas.path), strict=True):
        for name in ("id", "kind", "label", "name", "word", "impacts", "grazings", "multiple", "a", "b", "decided", "energy",
                     "frequency", "refusal"):
            same(getattr(one, name), row[name], f"junction {one.id} {name}")
        same(list(one.rotation) if one.rotation else None, row["rotation"], f"junction {one.id} rotation")
        same(one.state.tolist(), row["state"], f"junction {one.id} state")
        same(one.flights.tolist(), row["flights"], f"junction {one.id} flights")
        same([other.id for other in one.branches], row["branches"], f"junction {one.id} branches")
        counts = one.departures
        same(counts.pop("over"), row["budgets"], f"junction {one.id} budgets")
        same(counts, row["departures"], f"junction {one.id} departures")


def check_points(one):
    rows = program("points", one.atlas.path, "--branch", one.id)
    columns = ("arclength", "energy", "frequency", "period", "trace", "log_trace", "rotation", "reach", "approach", "residual")
    arrays = {name: getattr(one, name).tolist() for name in columns}
    for i, row in enumerate(rows):
        for name in columns:
            same(arrays[name][i], row[name], f"branch {one.id} point {i} {name}")
        assert row["stable"] == word_said(one.stable[i], one.undecided[i])
        if row.get("multipliers") and i % (1 if LONG else 9) == 0:
            same_complex(one.point(i).multipliers, row["multipliers"], f"branch {one.id} point {i} multipliers")
    assert len(rows) == len(one)


def check_orbit(found, row, where):
    same(found.word, row["word"], where + " word")
    same(found.state.tolist(), row["state"], where + " state")
    for name in ("flights", "amplitudes", "impact_speeds", "impulses"):
        same(getattr(found, name).tolist(), row[name], f"{where} {name}")
    for name in ("period", "frequency", "energy"):
        same(getattr(found, name), row[name], f"{where} {name}")
    same_complex(found.multipliers, row["multipliers"], where + " multipliers")
    assert row["stable"] == word_said(found.stable, found.undecided)


def check_orbits(one):
    where, middle = f"branch {one.id}", len(one) // 2
    energy = (one.energy[middle] + one.energy[max(0, middle - 1)]) / 2
    arguments = ("orbit", one.atlas.path, "--branch", one.id)
    check_orbit(one.point(middle), program(*arguments, "--point", middle)[0], where)
    found = one.orbits(energy=energy)
    for orbit, row in zip(found, program(*arguments, "--energy", repr(energy)), strict=True):
        check_orbit(orbit, row, f"{where} at {energy}")
    dt = float(found[0].period / 7)
    rows = program(*arguments, "--point", middle, "--history", repr(dt))
    t, x, v = one.point(middle).history(dt)
    assert len(rows) == len(t)
    for i, row in enumerate(rows):
        same([t[i], *x[i], *v[i]], list(row.values()), f"{where} history {i}")


ROUNDING = ("flight_error", "return_error", "condition", "energy_error", "multiplier_error", "multiplier_bound")


def check_verification(atlas):
    rows = program("verify", atlas.path)
    names = ("kind", "branch", "point", "junction", "flight_error", "return_error", "condition", "energy_error", "faces_agree",
             "multiplier_error", "multiplier_bound", "multipliers_agree", "stable_agrees", "numbers_agree", "passed", "finding")
    checks = atlas.verify(workers=2)
    for one, row in zip(checks, rows, strict=True):
        for name in names:
            if NEAR and name in ROUNDING:
                continue  # what is measured of it is another one
            same(getattr(one, name), row[name], f"verify {one.kind} {one.branch} {one.point} {name}")
    assert bool(checks) == all(row["passed"] for row in rows)


def check_model(study, model):
    for i, row in enumerate(program("check", study)):
        same(model.frequencies[i], row["frequency"], f"frequency {i}")
        same(bool(model.seen[i]), row["seen"], f"seen {i}")
        if row["grazing_energy"] is not None:
            same(model.grazing_energies[i], row["grazing_energy"], f"grazing energy {i}")
        for contact in range(len(model.contacts)):
            same(model.modal_normals[contact, i], row[f"normal_{contact + 1}"], f"normal {contact} {i}")
            same(model.compliance(contact)[i], row[f"compliance_{contact + 1}"], f"compliance {contact} {i}")
            if i + 1 < model.n_dof:
                same(model.locked_frequencies(contact)[i], row[f"locked_{contact + 1}"], f"locked {contact} {i}")


def check_simulation(study, atlas):
    orbit = atlas.branches[-1].point(-1)
    state = [repr(float(value)) for value in orbit.state]
    common = ("simulate", study, "--state", *state, "--time", repr(orbit.period))
    found = atlas.model.simulate(orbit.x, orbit.v, orbit.period, steps=13)
    for i, row in enumerate(program(*common, "--steps", 13)):
        same([found.t[i], *found.x[i], *found.v[i]], list(row.values()), f"simulation {i}")
    if NEAR:
        return  # the orbit is the last of a branch: whether it touches a face there is a matter of rounding
    for impact, row in zip(found.impacts, program(*common, "--impacts"), strict=True):
        same([value.item() for value in impact], list(row.values()), "impacts")


def test_of(study):
    name = os.path.basename(os.path.dirname(study) if study.endswith("study.yaml") else "paper-" + os.path.basename(study))

    def test(folder):
        path = os.path.join(folder, "a.ricochet")
        limit, atlas = ["--seconds", str(SECONDS)], ()
        while not atlas:
            done = subprocess.run([PROGRAM, "run", study, "-o", path, "-j", "2", *limit], capture_output=True, text=True, check=False)
            assert done.returncode in (0, 3), (done.returncode, done.stderr)
            atlas = ricochet.Atlas(path)
            check_model(study, atlas.model)
        check_branches(atlas)
        check_junctions(atlas)
        for one in atlas.branches[::max(1, len(atlas.branches) // BRANCHES)]:
            check_points(one)
            check_orbits(one)
        check_verification(atlas)
        check_simulation(study, atlas)
        print(f"# {name}: {len(atlas)} branches, {sum(map(len, atlas))} points{'' if atlas.finished else ', not all there is'}; {compared} numbers compared so far", flush=True)

    test.__name__ = f"test_{name}"
    test.__doc__ = f"{name}: the numbers of the package are those of the program"
    return test


def test_hunt(folder):
    """a hunt from Python finds what the program finds"""
    path, study = os.path.join(folder, "a.ricochet"), "examples/elementary/study.yaml"
    subprocess.run([PROGRAM, "run", study, "-o", path], capture_output=True, check=True)
    rows = program("hunt", study, "--energy", 5, "--impacts", 2, "--atlas", path, "--rows", 10, "--random", 2000)
    hunt = ricochet.Atlas(path).hunt(5, impacts=2, rows=10, random=2000)
    assert len(rows) >= 3 and hunt.n_again <= hunt.n_atlas and len(hunt.missed) == hunt.n_atlas - hunt.n_again
    for one, row in zip(hunt, rows, strict=True):
        for name in ("word", "impacts", "period", "frequency", "symmetric", "reversible", "trace", "branch", "family",
                     "atlas", "reason"):
            same(getattr(one, name), row[name], f"hunt {name}")
        same_complex(one.multipliers, row["multipliers"], "hunt multipliers")
        same(one.state.tolist(), row["state"], "hunt state")
        same(one.flights.tolist(), row["flights"], "hunt flights")
    assert "found again" in repr(hunt)


run([test_of(study) for study in STUDIES] + [test_hunt])
