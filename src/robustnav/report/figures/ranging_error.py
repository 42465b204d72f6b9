"""Errors of positions over time, many runs together, beside the bound no filter can beat."""

from __future__ import annotations

from collections.abc import Mapping

from robustnav.records import Array
from robustnav.report.drawing import Plot, caption, trace
from robustnav.report.style import BOUND, CYCLE, add_legend, label_time, label_value, new_figure

LINES = ("-", "--", ":")


def ranging_error(t: Array, errors: Mapping[str, Array], bound: Array | None, words: str) -> Plot:
    """Draw errors over time, one line a method, and the bound.

    Parameters
    ----------
    t : (n,) times [s].
    errors : by method (n,) [m], positive.
    bound : (n,) [m], or None.
    words : what the errors are of, for the caption.
    """
    figure, (axes,) = new_figure(1, row_in=2.8)
    fewer = False
    for k, (name, values) in enumerate(errors.items()):
        line = LINES[k % len(LINES)]
        fewer |= trace(axes, t, values, label=name, color=CYCLE[k % len(CYCLE)], linestyle=line, linewidth=1.2)
    if bound is not None:
        fewer |= trace(axes, t, bound, label="Bound", color=BOUND, linewidth=1.0)
    axes.set_yscale("log")
    label_value(axes, "RMS position error, m")
    label_time(axes)
    add_legend(figure, axes)
    return Plot(figure, caption([words], fewer))
