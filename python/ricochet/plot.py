"""Pictures on axes of matplotlib, so that data and style of one's own go on the same axes.

Every function takes `ax`, draws on it, or on new axes without it, and returns it.
"""
from __future__ import annotations

from typing import Callable, Iterable, Optional, Sequence, Union

from . import _labels
from ._atlas import Atlas, Branch, Junction
from ._orbit import Orbit
import matplotlib.pyplot as plt
from matplotlib.ticker import LogLocator
import numpy as np

THIN, THICK = 0.8, 2.4  # points: unstable, stable
_MARKERS = {"grazing": "o", "corner": "s", "extremum": "^", "branch-point": "D", "multiplication": "x",
            "period-extremum": "v", "user": "+"}
_NEAR = 6               # points of each branch on either side of a junction that a zoom shows


def _axes(ax):
    return plt.subplots()[1] if ax is None else ax


def _with_junctions(one: Branch) -> tuple:
    """Energies, frequencies, and which points are stable, undecided, and at a junction, where stability changes."""
    at = one.junction_arclengths
    inner = one.junctions
    s, neutral = one.arclength, np.zeros(len(one) + len(inner), bool)
    order = np.argsort(np.concatenate([s, at]), kind="stable")
    x = np.concatenate([one.energy, [other.energy for other in inner]])[order]
    y = np.concatenate([one.frequency, [other.frequency * other.level(one) for other in inner]])[order]
    flags = [np.concatenate([flag, np.zeros(len(inner), bool)])[order] for flag in (one.stable, one.undecided)]
    arclength = np.concatenate([s, at])[order]
    for place in at:
        neutral |= np.abs(arclength - place) <= 1e-9 * (1 + np.abs(arclength))
    for i, end in ((0, one.ends[0]), (-1, one.ends[1])):
        neutral[i] |= end is not None
    return x, y, *flags, neutral


def _pieces(keep: np.ndarray, neutral: np.ndarray) -> np.ndarray:
    """Which points belong to a piece of a curve whose ends are both kept, or one is and the other at a junction."""
    one_kept, loose = keep & ~neutral, keep | neutral
    piece = loose[1:] & loose[:-1] & (one_kept[1:] | one_kept[:-1])
    return np.concatenate([[False], piece]) | np.concatenate([piece, [False]])


def branch(one: Branch, ax=None, duplicate: int = 1, **style):
    """Frequency over energy of a branch: thick where it is stable, dotted where that is undecided.

    Parameters
    ----------
    one : Branch
    duplicate : int
        Gone through so many times: its frequencies are divided by it.
    style
        Of matplotlib's lines: color, label, alpha, ...
    """
    ax = _axes(ax)
    x, y, stable, undecided, neutral = _with_junctions(one)
    y = y / duplicate
    line, = ax.plot(x, y, **{"lw": THIN, "color": "k", **style})
    for keep, extra in ((stable, {"lw": THICK}), (undecided, {"lw": THICK, "ls": ":"})):
        shown = _pieces(keep, neutral)
        if shown.any():
            given = {**style, "color": line.get_color(), "label": "_nolegend_", **extra}
            ax.plot(np.where(shown, x, np.nan), np.where(shown, y, np.nan), **given)
    return ax


def junction(one: Junction, ax=None, label: Union[bool, str] = True, **style):
    """A mark at a junction, with its name or label, which keeps away from curves and other labels of these axes."""
    ax = _axes(ax)
    ax.plot([one.energy], [one.frequency], **{"marker": _MARKERS.get(one.kind, "."), "ms": 4, "mfc": "w", "ls": "",
                                               "color": "tab:red", "zorder": 3, **style})
    if label:
        _labels.label(ax, label if isinstance(label, str) else one.title, (one.energy, one.frequency))
    return ax


def fep(atlas: Atlas, ax=None, branches: Optional[Iterable[Branch]] = None, labels: Union[str, Sequence[str]] = "named",
        style: Optional[Callable[[Branch], dict]] = None, log: bool = True, **lines):
    """The frequency-energy picture of an atlas, with its junctions.

    Parameters
    ----------
    atlas : Atlas
    branches : iterable of Branch
        Only these; all unless given. Junctions are those that they meet.
    labels : "named", "all", "none", or names and labels of junctions
        "named" are those with a name in the study; all where none has one and they are 12 at most.
    style : callable
        branch -> style of its line, such as {"color": "C1"}.
    log : bool
        Whether the axes are logarithmic.
    lines
        Style of all lines.
    """
    ax = _axes(ax)
    chosen = list(atlas.branches if branches is None else branches)
    for one in chosen:
        branch(one, ax, **{**lines, **(style(one) if style else {})})
    ids = {other.id for one in chosen for other in (*one.junctions, *filter(None, one.ends))}
    wanted = _wanted_labels(atlas, labels)
    for one in (one for one in atlas.junctions if one.id in ids and one.kind != "start"):
        junction(one, ax, label=wanted(one))
    if log:
        _logarithmic(ax)
    ax.set_xlabel("energy / d²")
    ax.set_ylabel("frequency, rad/s")
    return ax


def _logarithmic(ax) -> None:
    """Both axes; frequencies span a decade or two and have their numbers at 1, 2 and 5."""
    ax.set(xscale="log", yscale="log")
    low, high = ax.get_ylim()
    if high / low < 200:
        ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter("")


def _wanted_labels(atlas: Atlas, labels):
    named = any(one.name for one in atlas.junctions)
    if labels == "named":
        return lambda one: bool(one.name) if named else len(atlas.junctions) <= 12
    if isinstance(labels, str):
        return lambda one: labels == "all"
    return lambda one: one.name in labels or one.label in labels


def _near(one: Branch, at: Junction) -> list:
    """Orbits of a branch about a junction: arclengths, energies and frequencies of pieces of it."""
    pieces = []
    for level in (at.multiple, 1):
        distance = np.abs(np.log(one.frequency / level / at.frequency)) + np.abs(np.log1p(one.energy) - np.log1p(at.energy))
        i = int(distance.argmin())
        if not pieces or distance[i] < pieces[0][0]:
            pieces[:] = [(distance[i], level, slice(max(0, i - _NEAR), i + _NEAR + 1))]
    return pieces[0][1:]


def zoom(at: Junction, ax=None, energy: Optional[Sequence[float]] = None, frequency: Optional[Sequence[float]] = None,
         **lines):
    """The surroundings of a junction: the branches that meet there, and what else is in the window.

    Parameters
    ----------
    at : Junction
    energy, frequency : (low, high)
        The window; unless given, that of some stored points about the junction.
    lines
        Style of all lines.
    """
    ax = _axes(ax)
    x, y = [at.energy], [at.frequency]
    levels = {}
    for one in at.branches:
        levels[one.id], near = _near(one, at)
        x.extend(one.energy[near])
        y.extend(one.frequency[near] / levels[one.id])
    window = [_widened(x) if energy is None else energy, _widened(y) if frequency is None else frequency]
    for one in at.atlas.branches:
        branch(one, ax, duplicate=levels.get(one.id, 1), **{**lines, **({} if one.id in levels else {"alpha": 0.35})})
    for one in at.atlas.junctions:
        if one.kind != "start" and window[0][0] <= one.energy <= window[0][1] and \
                window[1][0] <= one.frequency <= window[1][1]:
            junction(one, ax)
    ax.set(xlim=window[0], ylim=window[1], xlabel="energy / d²", ylabel="frequency, rad/s", title=_labels.typeset(at.title))
    return ax


def _widened(values) -> tuple:
    low, high = float(np.min(values)), float(np.max(values))
    margin = 0.08 * (high - low) or 0.01 * abs(high) or 1.0
    return low - margin, high + margin


def orbit(one: Orbit, ax=None, coordinates: Optional[Sequence[int]] = None, periods: float = 1, **style):
    """Displacements over time, with the instants of the impacts.

    Parameters
    ----------
    one : Orbit
    coordinates : sequence of int, from 0
        All, up to four, unless given.
    periods : float
    """
    ax = _axes(ax)
    t = np.linspace(0, periods * one.period, int(400 * max(1, periods)) + 1)
    x = one.at(t)[0]
    for i in _coordinates(one, coordinates):
        ax.plot(t, x[:, i], **{"lw": 1.2, "label": f"x{i + 1}", **style})
    for begin in np.arange(int(np.ceil(periods))) * one.period if one.impacts else []:
        for time in one.impact_times + begin:
            if time <= t[-1]:
                ax.axvline(time, color="0.8", lw=0.6, zorder=0)
    ax.set(xlabel="t, s", ylabel="x / d", title=f"{one.branch.label}, energy {one.energy:.6g}")
    ax.legend(fontsize=7)
    return ax


def phase(one: Orbit, ax=None, coordinates: Optional[Sequence[int]] = None, **style):
    """Velocities over displacements, closed curves with jumps at impacts."""
    ax = _axes(ax)
    before = np.append(one.impact_times[1:], one.period) * (1 - 1e-14)
    t = np.sort(np.concatenate([np.linspace(0, one.period, 801), one.impact_times, before]))
    x, v = one.at(np.append(t, 0.0))
    for i in _coordinates(one, coordinates):
        ax.plot(x[:, i], v[:, i], **{"lw": 1.2, "label": f"x{i + 1}", **style})
    ax.set(xlabel="x / d", ylabel="v / d, 1/s", title=f"{one.branch.label}, energy {one.energy:.6g}")
    ax.legend(fontsize=7)
    return ax


def _coordinates(one: Orbit, coordinates) -> Sequence[int]:
    return range(min(4, one.model.n_dof)) if coordinates is None else coordinates


def multipliers(one: Branch, ax=None, x: Optional[str] = None, **style):
    """Floquet multipliers of the points of a branch.

    Parameters
    ----------
    one : Branch
    x : None, "energy", "frequency" or "arclength"
        Without it the multipliers are drawn in the complex plane, with the unit circle; with it their moduli, on a
        logarithmic axis, over it.
    """
    ax = _axes(ax)
    values = one.multipliers
    if x is not None:
        for column in values.T:
            ax.plot(getattr(one, x), np.abs(column), **{"marker": ".", "ms": 3, "ls": "", "color": "k", **style})
        ax.set(yscale="log", xlabel=x, ylabel="modulus of multipliers")
        return ax
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 201))
    ax.plot(circle.real, circle.imag, color="0.7", lw=0.8)
    for keep, colour in ((one.stable, "tab:blue"), (~one.stable, "tab:red")):
        shown = values[keep].ravel()
        shown = shown[np.isfinite(shown)]
        ax.plot(shown.real, shown.imag, **{"marker": ".", "ms": 3, "ls": "", "color": colour, **style})
    ax.set(xlim=(-2, 2), ylim=(-2, 2), aspect="equal", xlabel="real part", ylabel="imaginary part",
           title=f"{one.label}: multipliers")
    return ax


def animate(one: Orbit, ax=None, shape: Optional[Callable] = None, frames: int = 100, seconds: float = 4,
            coordinates: Optional[Sequence[int]] = None, **style):
    """A matplotlib animation of one period.

    In a notebook `HTML(plot.animate(orbit).to_jshtml())` shows it; `.save("orbit.gif")` keeps it.

    Parameters
    ----------
    one : Orbit
    shape : callable
        x [n_dof], scaled -> y, or (x, y), the line that is drawn: the deflection of a beam, for example. Without it the
        displacements run along their histories.
    frames : int
    seconds : float
        How long a period takes.
    """
    from matplotlib.animation import FuncAnimation
    ax = _axes(ax)
    x = one.at(np.arange(frames) / frames * one.period)[0]
    update = _moving_shape(ax, x, shape, style) if shape else _moving_dots(one, ax, x, coordinates, style)
    return FuncAnimation(ax.figure, update, frames=frames, interval=1000 * seconds / frames, blit=False)


def _moving_shape(ax, x: np.ndarray, shape: Callable, style: dict):
    drawn = [shape(row) for row in x]
    curves = [np.asarray(one) if np.ndim(one) == 2 else np.array([np.arange(len(one)), one]) for one in drawn]
    line, = ax.plot(*curves[0], **{"lw": 2, **style})
    everything = np.concatenate(curves, axis=1)
    ax.set(xlim=_widened(everything[0]), ylim=_widened(everything[1]))
    return lambda frame: (line.set_data(*curves[frame]), line)[1:]


def _moving_dots(one: Orbit, ax, x: np.ndarray, coordinates, style: dict):
    orbit(one, ax, coordinates)
    chosen = list(_coordinates(one, coordinates))
    times = np.arange(len(x)) / len(x) * one.period
    dots = [ax.plot([], [], **{"marker": "o", "color": line.get_color(), **style})[0]
            for line in ax.get_lines()[:len(chosen)]]

    def update(frame):
        for dot, i in zip(dots, chosen):
            dot.set_data([times[frame]], [x[frame, i]])
        return dots
    return update
