"""Explorations from Python: the same atlas, Ctrl-C, errors, and how objects show themselves."""
import contextlib
import glob
import io
import os
import shutil
import signal
import sqlite3
import subprocess
import sys

from tap import NEAR, PROGRAM, Skip, raises, run

import ricochet
from ricochet._running import Bar
import numpy as np

STUDY = "examples/symmetric-path/study.yaml"


def tables(path):
    """Every row of every table, but for the cache of traces and the texts about the run."""
    atlas = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    names = [name for (name,) in atlas.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name")]
    assert {"branch", "point", "junction"} <= set(names)
    return {name: sorted(atlas.execute(f"SELECT * FROM {name}"), key=repr) for name in names
            if name not in ("trace", "meta") and not name.startswith("sqlite_")}


def differing(one, other):
    """Which tables differ, and one row of each that only one of them has."""
    assert one.keys() == other.keys(), (one.keys(), other.keys())
    return {name: [next((row for row in a if row not in b), None) for a, b in ((one[name], other[name]), (other[name], one[name]))]
            for name in one if one[name] != other[name]}


def by_program(study, folder):
    path = os.path.join(folder, "program.ricochet")
    subprocess.run([PROGRAM, "run", study, "-o", path], capture_output=True, check=True)
    return tables(path)


def alike(path, study, folder):
    """Whether an atlas is that of the program, row for row; under other roundings, whether it has the same branches."""
    wanted = by_program(study, folder)
    if NEAR:
        return [one.label for one in ricochet.Atlas(path)] == [one.label for one in ricochet.Atlas(os.path.join(folder, "program.ricochet"))]
    return tables(path) == wanted


def two_masses(**explore):
    model = ricochet.Model(np.diag([2, 1]), [[9, -1], [-1, 1]], [ricochet.Contact([-1, 1], clearance=1, name="stop")])
    return ricochet.Study(model, "Two masses", **explore)


def test_same_atlas(folder):
    """an exploration from Python gives the atlas of the program, row for row, with two workers"""
    path = os.path.join(folder, "python.ricochet")
    atlas = ricochet.explore(STUDY, path, workers=2)
    assert atlas.finished and alike(path, STUDY, folder)


def test_matrices(folder):
    """matrices of NumPy make the atlas of the same study in a file"""
    study = two_masses(energy=[0, 20], impacts=4, multiply=1)
    text = os.path.join(folder, "study.yaml")
    with open(text, "w", encoding="utf-8") as file:
        file.write("title: Two masses\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                   "    - {name: stop, normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                   "explore: {energy: [0, 20], impacts: 4, multiply: 1}\n")
    path = os.path.join(folder, "python.ricochet")
    ricochet.explore(study, path)
    assert alike(path, text, folder)
    assert ricochet.Atlas(path).study.text == ricochet.Study.read(text).text


def test_all_digits(folder):
    """numbers of a study keep all their digits, also those of random structures with sparse matrices"""
    import scipy.sparse
    random = np.random.default_rng(7)
    half = random.standard_normal((3, 3))
    mass, stiffness = half @ half.T + np.eye(3), half.T @ half + np.eye(3)
    mass, stiffness = (mass + mass.T) / 2, (stiffness + stiffness.T) / 2
    contacts = [dict(normal=random.standard_normal(3), clearance=random.random() + 0.1),
                dict(normal=random.standard_normal(3), clearance=random.random() + 0.1, law="bilinear", stiffness=3 / 7)]
    model = ricochet.Model(scipy.sparse.csr_matrix(mass), scipy.sparse.coo_matrix(stiffness), contacts)
    named = ricochet.Study(model, units={"length": "mm", "force": "N"}, energy=[0, 2])
    assert 'length: "mm"' in named.text and 'force: "N"' in named.text, named.text
    study = ricochet.Study(model, energy=[0, 1 / 3], start=np.array([1, 2]), impacts=np.int64(3), tolerance=1e-11)
    for one in (model, study.model):
        assert (one.mass == mass).all() and (one.stiffness == stiffness).all()
        for found, wanted in zip(one.contacts, contacts):
            assert (found.normal == wanted["normal"]).all() and found.clearance == wanted["clearance"]
    assert study.model.contacts[1].stiffness == 3 / 7 and study.options["energy"] == [0, 1 / 3]
    assert study.options["impacts"] == 3 and study.options["tolerance"] == 1e-11 and study.options["n_start"] == 2
    inverse = np.linalg.inv(mass)
    for i, one in enumerate(contacts):
        assert np.isclose(model.compliance(i)[-1], one["normal"] @ inverse @ one["normal"], rtol=1e-12)


CHILD = """
import signal, sys
sys.path[:0] = [{tests!r}]
import tap, ricochet
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell that has started the suite behind itself ignores it
def look(now):
    if now.depth >= 2 and now.branches >= 16: print("far enough", flush=True)
ricochet.explore({study!r}, {path!r}, workers=2, progress=look)
"""


def interrupt(folder, path, study):
    """A run of Python that is told to stop by Ctrl-C when it has come far enough."""
    text = CHILD.format(tests=os.path.dirname(os.path.abspath(__file__)), study=study, path=path)
    with subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        told = child.stdout.readline()
        child.send_signal(signal.SIGINT)
        _, said = child.communicate()
    assert told == "far enough\n" and "KeyboardInterrupt" in said, said
    assert child.returncode in (1, -signal.SIGINT, 130), child.returncode


def test_interrupt(folder):
    """Ctrl-C keeps what was done; the same call goes on and ends with the same atlas"""
    study = os.path.join(folder, "study.yaml")
    with open("examples/fractal-base/study.yaml", encoding="utf-8") as file, open(study, "w", encoding="utf-8") as out:
        out.write(file.read().replace("explore:", "explore:\n  step: 0.0005", 1))
    path = os.path.join(folder, "python.ricochet")
    interrupt(folder, path, study)
    part = ricochet.Atlas(path)
    assert not part.finished and len(part) > 0, (part.finished, len(part))
    again = ricochet.explore(study, path, progress=lambda now: True)
    assert not again.finished and len(again) >= len(part), "a run that is stopped sooner takes nothing away"
    if NEAR:
        return  # the rest is one long exploration more
    whole = ricochet.explore(study, path)
    assert whole.finished and len(whole) >= len(part), (whole.finished, len(whole), len(part))
    differ = differing(tables(path), by_program(study, folder))
    assert not differ, differ


def test_kernel(folder):
    """the stop button of a notebook keeps what was done; its bar was shown, and the same cell goes on"""
    try:
        from jupyter_client.manager import KernelManager
        import ipykernel  # noqa: F401
    except ImportError as missing:
        raise Skip(str(missing)) from None
    path, study = os.path.join(folder, "a.ricochet"), os.path.join(folder, "study.yaml")
    with open("examples/fractal-base/study.yaml", encoding="utf-8") as file, open(study, "w", encoding="utf-8") as out:
        out.write(file.read().replace("explore:", "explore:\n  step: 0.0005", 1))
    manager = KernelManager(connection_file=os.path.join(folder, "kernel.json"))
    manager._kernel_spec = _kernel()
    manager.start_kernel(cwd=os.getcwd())
    client = manager.blocking_client()
    try:
        client.start_channels()
        client.wait_for_ready(timeout=300)
        shown = []

        def looks(message):
            shown.append(message["content"].get("data", {}).get("text/html", ""))
            if "depth 2" in shown[-1] and len(interrupted) == 0:
                interrupted.append(True)
                manager.interrupt_kernel()
        interrupted = []
        cell = f"import ricochet\natlas = ricochet.explore({study!r}, {path!r}, workers=2)"
        reply = client.execute_interactive(cell, timeout=600, output_hook=looks)["content"]
        assert reply["status"] == "error" and reply["ename"] == "KeyboardInterrupt", reply
        assert interrupted and sum("<progress" in one for one in shown) > 1
        part = ricochet.Atlas(path)
        assert not part.finished and len(part) > 0
        reply = client.execute_interactive("again = ricochet.explore(" + repr(study) + f", {path!r}, progress=lambda now: True)\nlen(again)",
                                           timeout=600, output_hook=lambda message: None)["content"]
        assert reply["status"] == "ok", reply
        assert len(ricochet.Atlas(path)) >= len(part)
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)


def _kernel():
    """This Python, whatever kernels are installed."""
    from jupyter_client.kernelspec import KernelSpec
    return KernelSpec(argv=[sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"], display_name="this", language="python")


def test_stops(folder):
    """a run stops when its progress function or its time says so"""
    study, path = two_masses(energy=[0, 200], impacts=24, multiply=1, depth=4, step=0.001), os.path.join(folder, "a.ricochet")
    seen = []
    atlas = ricochet.explore(study, path, progress=lambda now: seen.append(now) or now.branches > 2)
    assert seen and not atlas.finished and isinstance(seen[-1], ricochet.Progress)
    before = len(atlas.branches)
    atlas = ricochet.explore(study, path, seconds=0.01)
    assert not atlas.finished and len(atlas.branches) >= before

    def fail(now):
        raise ZeroDivisionError("in the progress function")
    raises(ZeroDivisionError, "progress function", ricochet.explore, study, path, progress=fail)


def test_errors(folder):
    """what the library says comes as an exception"""
    path = os.path.join(folder, "a.ricochet")
    stop = dict(normal=[1, 0], clearance=1)
    raises(ricochet.InputError, "positive definite", ricochet.Model, [[1, 0], [0, -1]], np.eye(2), [stop])
    raises(ricochet.InputError, "no contacts", ricochet.Model, np.eye(2), np.eye(2), [])
    raises(ricochet.InputError, "sides", ricochet.Contact, [1, 0], 1, sides="left")
    raises(ricochet.InputError, "clearance", ricochet.Model, np.eye(2), np.eye(2), [dict(normal=[1, 0], clearance=-1)])
    raises(ricochet.InputError, "normal of 3", ricochet.Model, np.eye(2), np.eye(2), [dict(normal=[1, 0, 0], clearance=1)])
    raises(ricochet.InputError, "no square matrix; numpy.diag", ricochet.Model, [1, 2], np.eye(2), [])
    raises(ricochet.InputError, "stiffness: no matrix of numbers", ricochet.Model, np.eye(2), [[1, "k"], ["k", 1]], [stop])
    raises(ricochet.InputError, "Study.read", ricochet.Study, STUDY)
    assert ricochet.Model(np.eye(2), np.eye(2), stop).n_mode == 1
    raises(ricochet.InputError, "impact", two_masses, impact=3)
    raises(ValueError, "energy", two_masses, energy=[2, 1])
    raises(ricochet.MissingError, "nowhere", ricochet.Atlas, os.path.join(folder, "nowhere.ricochet"))
    raises(ricochet.FormatError, "", ricochet.Atlas, "README.md")
    raises(ricochet.MissingError, "study.yaml", ricochet.Study.read, os.path.join(folder, "study.yaml"))
    atlas = ricochet.explore(two_masses(energy=[0, 3], impacts=2, multiply=1), path)
    other = ricochet.Model(np.diag([2, 1.5]), [[9, -1], [-1, 1]], [dict(normal=[-1, 1], clearance=1)])
    raises(ricochet.ConflictError, "model", ricochet.explore, ricochet.Study(other), path)
    raises(LookupError, "run from 1 to", atlas.branch, 99)
    raises(ricochet.RangeError, "S2-[01]", atlas.branch, "S2-[0]")
    backbone = atlas.branch("S2+[01]")
    raises(ricochet.RangeError, "it runs from", backbone.orbit, energy=1e6)
    raises(ricochet.RangeError, "99", backbone.point, 99999)
    raises(TypeError, "energy", backbone.orbit)
    raises(ricochet.InputError, "degrees of freedom", atlas.model.simulate,
           [0], [1], 1)
    raises(ValueError, "read-only", backbone.energy.__setitem__, 0, 1.0)
    raises(ricochet.InputError, "option", atlas.hunt, 1, dense=3)


def test_several(folder):
    """several orbits of one energy are not one"""
    atlas = ricochet.explore(two_masses(energy=[0, 20], impacts=2, multiply=2), os.path.join(folder, "a.ricochet"))
    branch = atlas.branch("A1[0]")
    assert len(branch.orbits(energy=1.5)) == 2
    raises(ricochet.RangeError, "which=0 to 1", branch.orbit, energy=1.5)
    first, second = sorted((branch.orbit(energy=1.5, which=k) for k in (0, 1)), key=lambda one: not one.stable)
    assert first.frequency != second.frequency and abs(first.energy - 1.5) < 1e-12
    closed = first.simulate(3)
    assert len(closed.impacts) in (2, 3) and np.allclose(closed.x[0], closed.x[-1], atol=1e-9)
    t, x, v = first.history()
    assert np.allclose([atlas.model.energy(*state) for state in zip(x, v)], 1.5, rtol=1e-12)
    assert np.allclose(x[0], x[-1]) and t[-1] == first.period
    assert (first.at(t[:5])[0] == x[:5]).all() and (first.at(float(t[3]))[1] == v[3]).all()


def test_flags(folder):
    """stability is a mask: what is undecided is not stable"""
    atlas = ricochet.explore(two_masses(energy=[0, 20], impacts=4, multiply=1), os.path.join(folder, "a.ricochet"))
    for one in atlas.branches:
        assert one.stable.dtype == bool and not (one.stable & one.undecided).any() and len(one.stable) == len(one)
        assert one.multipliers.shape == (len(one), 2)
        known = ~one.undecided & np.isfinite(one.multipliers).all(axis=1) & (one.impacts > 0)
        assert np.allclose(one.multipliers[known].prod(axis=1), 1)
        assert (np.abs(one.multipliers[known & one.stable]) < 1 + 1e-6).all()
    checks = atlas.verify(all=True, workers=2)
    assert checks and not checks.failures and (checks.column("kind") == "junction").sum() == len(atlas.junctions)
    assert len(atlas.verify(branch=3)) < len(atlas.verify())
    assert (atlas.branches.column("energy_max") <= 20 * (1 + 1e-12)).all()


def test_together(folder):
    """of contacts that close together there is more than one kind of disturbance"""
    atlas = ricochet.explore(ricochet.Study.read("examples/two-bearings/study.yaml"), os.path.join(folder, "a.ricochet"))
    assert [one.name for one in atlas.model.contacts] == ["left+right"]
    orbit = atlas.branch("S2(1)[01]").orbit(energy=2)
    assert orbit.parting.shape == (2,) and abs(orbit.parting.prod() - 1) < 1e-9
    assert atlas.branch("S0(1)").orbit(energy=1).parting.shape == (0,)
    raises(ricochet.InputError, "close together", ricochet.Study, atlas.model)


def test_shows(folder):
    """every object prints itself, and shows itself in a notebook"""
    study = two_masses(energy=[0, 20], impacts=4, multiply=2)
    atlas = ricochet.explore(study, os.path.join(folder, "a.ricochet"))
    orbit = atlas.branch("S2-[01]").orbit(energy=5)
    objects = {"Two masses": atlas, "S2-[01]": atlas.branch("S2-[01]"), "G1_0,2": atlas.junction("G1_0,2"), "energy 5": orbit,
               "instants": orbit.history(0.1), "Simulation": orbit.simulate(), "omega": study, "agree": atlas.verify(),
               "stable share": atlas.branches, "kind": atlas.junctions, "degrees of freedom": atlas.model}
    for text, one in objects.items():
        assert text in repr(one), (text, repr(one))
        markup = one._repr_html_()
        assert markup.count("<table") == markup.count("</table>") and "nan" not in markup, markup
    assert "<svg" in atlas._repr_html_() and "<table" in atlas._repr_html_() and "<svg" in objects["S2-[01]"]._repr_html_()
    assert "Contact(" in repr(atlas.model.contacts)


def test_copies(folder):
    """arrays are copied once, and live on without the atlas"""
    path = os.path.join(folder, "a.ricochet")
    atlas = ricochet.explore(two_masses(energy=[0, 20], impacts=4, multiply=1), path)
    branch = atlas.branch("S2-[01]")
    assert branch.energy is branch.energy and branch.state.shape == (len(branch), 4) and branch.state.flags.c_contiguous
    energy, orbit, junction = branch.energy, branch.point(0), atlas.junctions[0].state
    wanted = energy.copy(), orbit.state.copy(), junction.copy()
    study = atlas.study
    del atlas, branch
    noise = [ricochet.Atlas(path) for _ in range(5)]
    assert (energy == wanted[0]).all() and (orbit.state == wanted[1]).all() and (junction == wanted[2]).all()
    assert orbit.at(0.1)[0].shape == (2,) and study.model.n_dof == 2 and noise


def test_older(folder):
    """a file of a program that counted less is opened; one of a newer format, and one without a number, are refused"""
    atlas = ricochet.explore(two_masses(energy=[0, 20], impacts=2, multiply=1), os.path.join(folder, "a.ricochet"))

    def changed(name, *calls):
        path = shutil.copy(atlas.path, os.path.join(folder, name))
        with contextlib.closing(sqlite3.connect(path)) as file:
            for call in calls:
                file.execute(call)
            file.commit()
        return path
    old = changed("old", "DELETE FROM meta WHERE key IN ('n_dof', 'unplaced', 'blind')")
    subprocess.run([sys.executable, "tools/attack/atlas_digest.py", old], check=True, capture_output=True)
    assert repr(ricochet.Atlas(old).branches) == repr(atlas.branches)
    raises(ricochet.FormatError, "use a newer ricochet", ricochet.Atlas, changed("new", "PRAGMA user_version = 2"))
    raises(ricochet.FormatError, "damaged", ricochet.Atlas, changed("none", "PRAGMA user_version = 0"))


def test_few_packages(folder):
    """the package needs neither SciPy nor matplotlib until it is asked for what they do"""
    code = ("import sys; sys.modules['scipy'] = sys.modules['matplotlib'] = None\n"
            "import ricochet; print(ricochet.explore.__name__)\n"
            "try: ricochet.reduce\nexcept ImportError: print('no reduce')\n")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == ["explore", "no reduce"], done


def test_bar(folder):
    """a progress bar is drawn on a terminal, taken away at the end, and never where none is wanted"""
    with contextlib.redirect_stderr(io.StringIO()) as terminal:
        bar = Bar(True)
        bar.show(0.5, "12 branches")
        bar.close()
    assert "[############............] 12 branches" in terminal.getvalue() and terminal.getvalue().endswith("\r\033[K")
    for wanted in (None, False):  # None: a StringIO is no terminal
        with contextlib.redirect_stderr(io.StringIO()) as terminal:
            bar = Bar(wanted)
            bar.show(0.5, "12 branches")
            bar.close()
        assert not terminal.getvalue()


def test_linear_algebra(folder):
    """another BLAS that was loaded before is told, since last digits may differ; the reference one is not"""
    found = glob.glob("/usr/lib/*/blas/libblas.so.3")
    if not found:
        raise Skip("the reference BLAS has no folder of its own")
    other = shutil.copy(found[0], os.path.join(folder, "libblas.so.3"))
    for first, said in ((f"import ctypes; ctypes.CDLL('{other}')", "loaded before ricochet"), ("import numpy", "")):
        done = subprocess.run([sys.executable, "-c", f"{first}\nimport ricochet"], capture_output=True, text=True, check=True)
        assert said in done.stderr and bool(done.stderr) == bool(said), done.stderr


run([test_same_atlas, test_matrices, test_all_digits, test_interrupt, test_kernel, test_stops, test_errors, test_several, test_flags,
     test_together,
     test_shows, test_copies, test_older, test_few_packages, test_bar, test_linear_algebra])
