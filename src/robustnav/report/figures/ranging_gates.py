"""What a filter made of every range: taken in full, in part, or refused."""

from __future__ import annotations

import numpy as np

from robustnav.records import BoolArray, Innovations
from robustnav.report.drawing import Plot, caption
from robustnav.report.style import BLUE, MUTED, ORANGE, REFUSED, add_legend, label_time, label_value, new_figure

PART = 0.2  # a reading that counts for less than this is drawn as refused
LIMIT_M = 3.0  # of the plot


def ranging_gates(data: Innovations, words: str) -> Plot:
    """Draw innovations of ranges over time, coloured by what each counted for; those far out lie on the edge.

    Parameters
    ----------
    data : of one sensor with one row a reading [m].
    words : what the readings are of, for the caption.
    """
    figure, (axes,) = new_figure(1, row_in=2.8)
    known = np.isfinite(data.weight)
    t, z, weight = data.t[known], data.z[known, 0], data.weight[known]
    kinds = {
        "In full": (weight >= 1.0, BLUE, ".", 2.0),
        "In part": ((weight < 1.0) & (weight >= PART), ORANGE, ".", 3.0),
        f"Below {PART:g}, or refused": (weight < PART, REFUSED, "x", 4.0),
    }
    shown = np.clip(z, -LIMIT_M, LIMIT_M)
    for name, (rows, colour, marker, size) in kinds.items():
        axes.plot(t[rows], shown[rows], marker, color=colour, markersize=size, linestyle="none", label=name)
    axes.axhline(0.0, color=MUTED, linewidth=0.8)
    axes.set_ylim(-1.05 * LIMIT_M, 1.05 * LIMIT_M)
    label_value(axes, "Innovation, m")
    label_time(axes)
    add_legend(figure, axes)
    return Plot(figure, caption([words, _counts({name: rows for name, (rows, *_) in kinds.items()})], False))


def _counts(kinds: dict[str, BoolArray]) -> str:
    total = sum(int(rows.sum()) for rows in kinds.values())
    parts = ", ".join(f"{name[0].lower()}{name[1:]} {int(rows.sum())}" for name, rows in kinds.items())
    return f"Of {total} readings: {parts}."
