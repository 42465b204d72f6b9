"""Where a carrier went, from above."""

from __future__ import annotations

import numpy as np

from robustnav.records import Array
from robustnav.report.drawing import Plot, caption
from robustnav.report.style import ESTIMATE, INK, MUTED, REFERENCE, add_legend, label_value, new_figure

_MOST = 2000  # points of a line


def route(p_n: Array, fixes: Array, p_true: Array | None, words: str) -> Plot:
    """Draw positions over east and north.

    Parameters
    ----------
    p_n : (n, 3) estimated [m]; NaN where nothing was said.
    fixes : (k, 3) read by the receiver [m]; NaN where missing.
    p_true : (m, 3) the truth [m], or None.
    words : of the caption.
    """
    figure, (axes,) = new_figure(1, row_in=4.0)
    axes.plot(fixes[:, 1], fixes[:, 0], ".", markersize=2.5, color=MUTED, label="Receiver")
    if p_true is not None:
        axes.plot(*_thinned(p_true), color=REFERENCE, linewidth=1.0, linestyle="--", label="True")
    east, north = _thinned(p_n)
    axes.plot(east, north, color=ESTIMATE, linewidth=1.2, label="Estimate")
    said = np.flatnonzero(np.isfinite(p_n[:, 0]))
    axes.plot(p_n[said[:1], 1], p_n[said[:1], 0], "o", markersize=5, color=ESTIMATE, label="Started")
    axes.set_aspect("equal", adjustable="datalim")
    label_value(axes, "North, m")
    axes.set_xlabel("East, m", color=INK)
    add_legend(figure, axes)
    return Plot(figure, caption([words], False))


def _thinned(p_n: Array) -> tuple[Array, Array]:
    step = -(-len(p_n) // _MOST)
    return p_n[::step, 1], p_n[::step, 0]
