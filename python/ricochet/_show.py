"""How objects show themselves: tables, and small pictures in a notebook."""
from __future__ import annotations

import html
import math

import numpy as np

ROWS = 24  # of a table in a notebook


def number(value) -> str:
    """Short, for a table; an empty text for what there is none of."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def table(heading: list, rows: list, caption: str = "") -> str:
    """HTML. The first and the last rows of a long one."""
    shown = rows if len(rows) <= ROWS else rows[:ROWS - 4] + [["…"] * len(heading)] + rows[-3:]
    lines = ["<table>", f"<caption>{html.escape(caption)}</caption>" if caption else "",
             "<tr>" + "".join(f"<th>{html.escape(name)}</th>" for name in heading) + "</tr>"]
    for row in shown:
        cells = (value if isinstance(value, Markup) else html.escape(number(value)) for value in row)
        lines.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    return "\n".join([*lines, "</table>"])


def text_table(heading: list, rows: list) -> str:
    """The same for a terminal."""
    shown = rows if len(rows) <= ROWS else rows[:ROWS - 4] + [["..."] * len(heading)] + rows[-3:]
    cells = [heading] + [[number(value) for value in row] for row in shown]
    widths = [max(len(row[i]) for row in cells) for i in range(len(heading))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in cells)


class Markup(str):
    """A text that is HTML already."""


def _scaled(values: np.ndarray, size: float) -> np.ndarray:
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return np.full(values.shape, size / 2)
    low, high = finite.min(), finite.max()
    return (values - low) / (high - low) * size if high > low else np.full(values.shape, size / 2)


def _path(x: np.ndarray, y: np.ndarray) -> str:
    return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y))


def curve(x, y, thick, width: int = 180, height: int = 70, most: int = 400) -> str:
    """SVG of a curve; thick where `thick` says so."""
    step = max(1, len(x) // most)
    keep = np.r_[0:len(x):step, len(x) - 1] if len(x) else np.empty(0, int)
    a, b = _scaled(np.asarray(x, float), width - 10)[keep] + 5, height - 5 - _scaled(np.asarray(y, float), height - 10)[keep]
    bold = np.asarray(thick)[keep]
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">']
    if len(keep):
        parts.append(f'<path d="{_path(a, b)}" fill="none" stroke="#1f4e79" stroke-width="0.8"/>')
    edges = np.flatnonzero(np.diff(np.r_[False, bold, False].astype(int)))
    for first, last in zip(edges[::2], edges[1::2]):
        parts.append(f'<path d="{_path(a[first:last], b[first:last])}" fill="none" stroke="#1f4e79" stroke-width="2.4"/>')
    return "".join(parts) + "</svg>"


def lines(x, columns, width: int = 260, height: int = 80) -> str:
    """SVG of some curves over one axis, with one scale."""
    colours = ["#1f4e79", "#c55a11", "#548235", "#7030a0"]
    a, values = _scaled(np.asarray(x, float), width - 10) + 5, np.asarray(columns, float)
    y = height - 5 - _scaled(values.ravel(), height - 10).reshape(values.shape)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">']
    for i, row in enumerate(y[:len(colours)]):
        parts.append(f'<path d="{_path(a, row)}" fill="none" stroke="{colours[i]}" stroke-width="1.2"/>')
    return "".join(parts) + "</svg>"
