"""Pictures on axes of one's own, and what the README promises."""
import os
import re
import subprocess
import sys

from tap import LONG, raises, run

import ricochet
from ricochet import plot
import matplotlib.pyplot as plt
from matplotlib.text import Text
import numpy as np


def atlas_in(folder, **explore):
    model = ricochet.Model(np.diag([2, 1]), [[9, -1], [-1, 1]], [dict(normal=[-1, 1], clearance=1)])
    study = ricochet.Study(model, "Two masses", **{"energy": [0, 20], "impacts": 4, "multiply": 2, **explore})
    return ricochet.explore(study, os.path.join(folder, "a.ricochet"))


def thick(ax):
    """Points of thick lines: (energy, frequency)."""
    lines = [line for line in ax.get_lines() if line.get_linewidth() == plot.THICK and line.get_linestyle() == "-"]
    points = [np.column_stack(line.get_data()) for line in lines]
    points = np.concatenate(points) if points else np.empty((0, 2))
    return points[np.isfinite(points).all(axis=1)]


def test_axes(folder):
    """everything is drawn on the axes that are given, in the style that is given"""
    atlas = atlas_in(folder)
    ax = plt.subplots()[1]
    ax.plot([1, 2], [1, 2], "g--", label="measured")
    before, orbit, branch = len(ax.get_lines()), atlas.branch("S2-[01]").orbit(energy=5), atlas.branch("S2-[01]")
    for draw in (lambda: plot.fep(atlas, ax, color="tab:orange", alpha=0.5), lambda: plot.zoom(atlas.junction("G1_0,2"), ax),
                 lambda: plot.orbit(orbit, ax, color="k"), lambda: plot.phase(orbit, ax, [0]),
                 lambda: plot.branch(branch, ax, duplicate=3), lambda: plot.multipliers(branch, ax),
                 lambda: plot.multipliers(branch, ax, x="energy"), lambda: plot.junction(atlas.junction("G1_0,2"), ax)):
        assert draw() is ax and len(ax.get_lines()) > before
        before = len(ax.get_lines())
    orange = [line for line in ax.get_lines() if line.get_color() == "tab:orange"]
    assert len(orange) >= len(atlas.branches) and all(line.get_alpha() == 0.5 for line in orange)
    ax.figure.savefig(os.path.join(folder, "a.svg"))
    plt.close("all")


def test_levels(folder):
    """a branch passes a q-tupling at its own frequency, whether the junction lies on it or it leaves there"""
    atlas = atlas_in(folder, impacts=6, multiply=3, depth=2)
    passed = [(at, one) for one in atlas.branches for at in one.junctions if at.multiple == 3]
    assert {at.level(one) for at, one in passed} == {1, 3}
    for _, one in passed:
        y = plot.branch(one).get_lines()[0].get_ydata()
        plt.close("all")
        assert one.frequency.min() * (1 - 1e-9) <= y.min() and y.max() <= one.frequency.max() * (1 + 1e-9), one


def test_stable_parts(folder):
    """thick is what is stable, up to the junction where that ends"""
    atlas = atlas_in(folder)
    backbone, at = atlas.branch("S2+[01]"), next(one for one in atlas.branch("S2+[01]").junctions if one.kind == "branch-point")
    ax = plot.branch(backbone)
    drawn = thick(ax)
    stable = np.column_stack([backbone.energy, backbone.frequency])[backbone.stable]
    assert all((np.abs(drawn - point).sum(axis=1) < 1e-12).any() for point in stable)
    assert (np.abs(drawn - [at.energy, at.frequency]).sum(axis=1) < 1e-9).any(), "the line ends at the junction"
    unstable = np.column_stack([backbone.energy, backbone.frequency])[~backbone.stable & ~backbone.undecided]
    inside = [point for point in unstable if not any(np.hypot(*(point - [one.energy, one.frequency])) < 1e-6
                                                     for one in (*backbone.junctions, *filter(None, backbone.ends)))]
    assert inside and not any((np.abs(drawn - point).sum(axis=1) < 1e-12).any() for point in inside)
    plt.close("all")


def test_zoom(folder):
    """a zoom has its junction inside, and the ends of the branches that meet there at it"""
    atlas = atlas_in(folder)
    for one in [one for one in atlas.junctions if one.kind != "start"][::1 if LONG else 9]:  # each draws all branches anew
        ax = plot.zoom(one)
        (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
        assert left < one.energy < right and low < one.frequency < high
        # a curve of every branch that meets here comes as close as the spacing of its points allows
        curves = [np.column_stack(line.get_data()) for line in ax.get_lines() if len(line.get_xdata()) > 1]
        close = [line for line in curves if np.nanmin(np.abs(line[:, 0] / one.energy - 1) +
                                                      np.abs(line[:, 1] / one.frequency - 1)) < 1e-6]
        assert len(close) >= len(one.branches), (one, len(close))
        plt.close("all")


def test_labels(folder):
    """labels that are asked for are there"""
    atlas = atlas_in(folder)
    assert len(plot.fep(atlas, labels="all").texts) == sum(one.kind != "start" for one in atlas.junctions)
    assert [text.get_text() for text in plot.fep(atlas, labels=["G1_0,2"]).texts] == [r"$\mathrm{G}_{0{,}2}^{(1)}$"]
    assert plot.junction(atlas.junctions[1], label="my $ name").texts[0].get_text() == r"my \$ name"
    assert not plot.fep(atlas, labels="none").texts
    assert len(plot.fep(atlas, branches=[atlas.branch("S2-[01]")], labels="all").texts) < 8
    raises(ricochet.RangeError, "junction", atlas.junction, "G9")
    plt.close("all")


def boxes(ax):
    """Where labels were drawn, in pixels."""
    return [Text.get_window_extent(text) for text in ax.texts if ax.get_window_extent().contains(*ax.transData.transform(text.xy))]


def test_room(folder):
    """labels cover neither one another nor the marks, and nothing of the picture in the README is cut off"""
    atlas = atlas_in(folder, impacts=6, multiply=1)
    with open("README.md", encoding="utf-8") as file:
        made = re.search(r"plt\.subplots\(.*\)", file.read())[0]
    figure, axes = eval(made)  # as the README makes it
    plot.fep(atlas, axes[0])
    plot.zoom(atlas.branch("S2+[01]").junctions[1], axes[1])
    figure.savefig(os.path.join(folder, "a.png"))
    for ax in axes:
        found = boxes(ax)
        marks = [ax.transData.transform(line.get_xydata()[0]) for line in ax.get_lines() if line.get_marker() not in ("None", "")]
        assert len(found) >= 2
        for i, box in enumerate(found):
            assert not any(box.overlaps(other) for other in found[:i]) and not any(box.contains(*mark) for mark in marks)
        whole = ax.get_tightbbox()
        assert whole.x0 >= 0 and whole.y0 >= 0 and whole.x1 <= figure.bbox.x1 and whole.y1 <= figure.bbox.y1, whole
    plt.close("all")


def test_animation(folder):
    """an orbit moves, as dots along its histories or in a shape of one's own"""
    orbit = atlas_in(folder).branch("S2-[01]").orbit(energy=5)
    path = os.path.join(folder, "orbit.gif")
    plot.animate(orbit, frames=4).save(path, writer="pillow")
    assert os.path.getsize(path) > 1000
    moving = plot.animate(orbit, shape=lambda x: np.array([[0, 1, 2], [0, *x]]), frames=8)
    first = moving._func(0)[0].get_ydata().copy()
    later = moving._func(3)[0].get_ydata().copy()
    assert (first[1:] == orbit.at(0.0)[0]).all() and not np.allclose(first, later)
    moving._draw_was_started = True
    plt.close("all")


def test_readme(folder):
    """the README: from import to a junction zoomed in and an orbit animated, in less than 20 lines"""
    with open("README.md", encoding="utf-8") as file:
        code = re.search(r"```python package\n(.*?)```", file.read(), re.DOTALL)[1]
    lines = [line for line in code.splitlines() if line.strip()]
    assert len(lines) < 20 and "zoom" in code and "animate" in code, len(lines)
    if not LONG:  # each picture takes a fifth of a second
        assert "frames=40" in code
        code = code.replace("frames=40", "frames=4")
    subprocess.run([sys.executable, "-c", code], cwd=folder, check=True, capture_output=True)
    made = set(os.listdir(folder))
    assert {"two-masses.ricochet", "two-masses.png", "orbit.gif"} <= made, made


run([test_axes, test_levels, test_stable_parts, test_zoom, test_labels, test_room, test_animation, test_readme])
