"""Dilution of precision over a level slice, as a map with the anchors on it."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from robustnav.records import Anchors, Array
from robustnav.report.drawing import Plot, caption
from robustnav.report.style import INK, SMALL_PT, TEXT_PT, VERMILION, add_legend, label_value, new_figure

LEVELS = (0.0, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
# one hue from light to dark, as printed maps do; what no filter should rely on stands out
SHADES = ("#f7fbff", "#e3eef9", "#cde0f1", "#abcfe5", "#7fb8da", "#4d99c9", "#2474b5", "#0a4a90", "#3d3d3d")
TALLEST_IN, WIDEST_IN = 6.5, 6.4


def gdop_map(
    place: tuple[Array, Array], values: Array, anchors: Anchors, name: str, extra: Array | None = None
) -> Plot:
    """Draw one dilution of precision over a grid.

    Parameters
    ----------
    place : x (nx,) and y (ny,) of the grid [m] in frame a.
    values : (ny, nx), infinite where not observable.
    anchors : drawn where they stand, also outside the grid.
    name : of the values, e.g. ``HDOP at a height of 1 m``.
    extra : (3,) proposed place of one more anchor [m], or None.
    """
    x, y = place
    near = np.vstack([anchors.p_a[:, :2]] + ([extra[None, :2]] if extra is not None else []))
    low, high = np.minimum([x[0], y[0]], near.min(axis=0)), np.maximum([x[-1], y[-1]], near.max(axis=0))
    margin = 0.05 * float((high - low).max())
    aspect = float((high - low + 2 * margin)[0] / (high - low + 2 * margin)[1])
    figure, (axes,) = new_figure(1, row_in=min(TALLEST_IN, max(1.5, WIDEST_IN / aspect)))
    shown = np.where(np.isfinite(values), np.minimum(values, 2 * LEVELS[-1]), 2 * LEVELS[-1])
    edges = [*LEVELS, 3 * LEVELS[-1]]
    axes.contourf(x, y, shown, levels=edges, colors=SHADES)
    names = [f"{a:g} to {b:g}" for a, b in pairwise(LEVELS)] + [f"beyond {LEVELS[-1]:g}"]
    for k, (shade, text) in enumerate(zip(SHADES, names, strict=True)):
        if ((shown >= edges[k]) & (shown < edges[k + 1])).any():
            axes.fill([], [], color=shade, edgecolor="#888888", linewidth=0.5, label=text)
    marker: dict[str, Any] = {"linestyle": "none", "markeredgecolor": "white", "zorder": 4}  # clear of dark shades
    axes.plot(*anchors.p_a[:, :2].T, "^", color=INK, markersize=8, label="Anchor", **marker)
    for anchor, p in zip(anchors.ids, anchors.p_a, strict=True):
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8}
        style: dict[str, Any] = {"textcoords": "offset points", "fontsize": SMALL_PT, "color": INK, "bbox": box}
        axes.annotate(f"{anchor} ({0.0 - p[2]:.2g} m)", p[:2], (6, 6), **style)
    if extra is not None:
        axes.plot(*extra[:2], "*", color=VERMILION, markersize=14, label="One more helps most", **marker)
    axes.set_aspect("equal")
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(high[1] + margin, low[1] - margin)  # y is to the right of x with z down: seen from above
    axes.set_xlabel("x of frame a, m", fontsize=TEXT_PT, color=INK)
    label_value(axes, "y of frame a, m")
    add_legend(figure, axes)
    words = f"{name}: the sd of the position is so many times that of one range. Seen from above; heights in brackets."
    return Plot(figure, caption([words], False))
