"""Labels of junctions, put where they cover neither one another nor a curve whenever axes are drawn."""
from __future__ import annotations

import re

from matplotlib.artist import Artist
from matplotlib.text import Text
import numpy as np

_CELL = 2.0                      # pixels of the grid on which curves are marked
_RINGS = (1.0, 10.0, 22.0, 36.0)  # points between a mark and its label
_ANGLES = np.radians([40, 140, -40, -140, 0, 180, 90, -90, 65, 115, -65, -115, 20, 160, -20, -160])
_LEADER = 8.0                    # points from which on a line leads to the mark
_OVERLAP, _OUTSIDE, _CURVE, _FAR = 50.0, 200.0, 1.0, 0.25


def typeset(title: str) -> str:
    """C1_32 with its indices; any other name as it is."""
    parts = re.fullmatch(r"([A-Z])(\d*)_([\d,?]+)(\??)", title)
    if not parts:
        return title.replace("$", r"\$")
    raised = f"^{{({parts[2]})}}" if parts[2] else ""
    indices = parts[3].replace(",", "{,}")
    return rf"$\mathrm{{{parts[1]}}}_{{{indices}}}{raised}$" + parts[4]


def label(ax, title: str, at: tuple):
    """Adds a label to a place on axes, and has it moved with the others."""
    text = ax.annotate(typeset(title), at, xytext=(6, 6), textcoords="offset points", ha="center", va="center", fontsize=8,
                       annotation_clip=True, arrowprops={"arrowstyle": "-", "lw": 0.4, "color": "0.4", "shrinkA": 0, "shrinkB": 2})
    text.set_in_layout(False)
    mover = next((one for one in ax.artists if isinstance(one, _Mover)), None)
    if mover is None:
        mover = _Mover()
        ax.add_artist(mover)
    mover.labels.append(text)
    return text


class _Mover(Artist):
    """Drawn before the labels: it gives each its place."""

    def __init__(self):
        super().__init__()
        self.labels = []
        self.set_in_layout(False)
        self.set_zorder(-1)

    def get_window_extent(self, renderer=None):
        """It has none."""
        from matplotlib.transforms import Bbox
        return Bbox.null()

    def draw(self, renderer):
        """Places the labels, from the left to the right."""
        shown = [one for one in self.labels if one.get_visible() and one.axes is self.axes]
        _place(self.axes, shown, renderer)


def _place(ax, labels: list, renderer) -> None:
    frame, unit = ax.get_window_extent(renderer), renderer.points_to_pixels(1)
    marks = [ax.transData.transform(one.xy) for one in labels]
    inside = [i for i, mark in enumerate(marks) if np.isfinite(mark).all() and frame.contains(*mark)]
    covered, taken = _covered(ax, frame), [_box(mark, 6 * unit, 6 * unit) for mark in ax.transData.transform(_marked(ax))]
    for i in sorted(inside, key=lambda k: tuple(marks[k])):
        size = Text.get_window_extent(labels[i], renderer)
        middles, rings = _candidates(marks[i], size.width, size.height, unit)
        boxes = [_box(middle, size.width + unit, size.height) for middle in middles]
        best = int(np.argmin([_cost(box, frame, covered, taken, marks[i]) + _FAR * ring for box, ring in zip(boxes, rings)]))
        taken.append(boxes[best])
        labels[i].set_position(tuple((middles[best] - marks[i]) / unit))
        labels[i].arrow_patch.set_visible(bool(rings[best] >= _LEADER))


def _candidates(mark, width: float, height: float, unit: float) -> tuple:
    """Middles of boxes whose edge is so many points from a mark, and these distances."""
    middles, rings = [], []
    for ring in _RINGS:
        for angle in _ANGLES:
            way = np.array([np.cos(angle), np.sin(angle)])
            reach = (ring + 3) * unit
            middles.append(mark + way * reach + np.clip(way / 0.6, -1, 1) * [width / 2, height / 2])
            rings.append(ring)
    return middles, rings


def _box(middle, width: float, height: float) -> np.ndarray:
    """left, bottom, right, top"""
    half = np.array([width, height]) / 2
    return np.concatenate([middle - half, middle + half])


def _marked(ax) -> np.ndarray:
    """[k, 2] places of marks on axes: lines without a stroke."""
    points = [line.get_xydata() for line in ax.get_lines() if line.get_linestyle() in ("None", "", " ") and len(line.get_xdata()) == 1]
    return np.concatenate(points) if points else np.empty((0, 2))


def _covered(ax, frame) -> tuple:
    """Curves on a grid over the axes, summed from its corner, so that what lies in a box is four numbers."""
    shape = int(frame.width / _CELL) + 2, int(frame.height / _CELL) + 2
    grid = np.zeros(shape)
    for line in ax.get_lines():
        if line.get_linestyle() not in ("None", "", " ") and line.get_visible():
            cells = ((_dense(line.get_transform().transform(line.get_xydata())) - [frame.x0, frame.y0]) / _CELL)
            cells = cells[np.isfinite(cells).all(axis=1)]
            cells = cells[(cells >= 0).all(axis=1) & (cells < shape).all(axis=1)].astype(int)
            grid[cells[:, 0], cells[:, 1]] = 1
    return np.pad(grid.cumsum(0).cumsum(1), ((1, 0), (1, 0))), frame


def _dense(points: np.ndarray) -> np.ndarray:
    """Points on a curve no farther apart than a cell, but for what is far outside."""
    points = np.clip(points[np.isfinite(points).all(axis=1)], -1e4, 1e5)
    if len(points) < 2:
        return points
    many = np.clip(np.ceil(np.hypot(*np.diff(points, axis=0).T) / _CELL), 1, 2000).astype(int)
    index = np.repeat(np.arange(len(many)), many)
    part = (np.arange(len(index)) - np.repeat(np.cumsum(many) - many, many)) / np.repeat(many, many)
    return points[index] + (points[index + 1] - points[index]) * part[:, None]


def _cost(box, frame, covered: tuple, taken: list, mark) -> float:
    """What a box hides, and how far it is outside."""
    cost = 0.0
    for other in taken:
        width, height = np.minimum(box[2:], other[2:]) - np.maximum(box[:2], other[:2])
        if width > 0 and height > 0:
            cost += _OVERLAP + width * height
    if box[0] < frame.x0 or box[1] < frame.y0 or box[2] > frame.x1 or box[3] > frame.y1:
        cost += _OUTSIDE
    sums, (x, y) = covered[0], np.array(covered[0].shape) - 1
    left, low, right, top = np.clip(((box - np.tile([frame.x0, frame.y0], 2)) / _CELL).astype(int), 0, [x, y, x, y])
    return cost + _CURVE * (sums[right, top] - sums[left, top] - sums[right, low] + sums[left, low])
