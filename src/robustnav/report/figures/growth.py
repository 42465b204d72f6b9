"""Errors of several estimators over time on one logarithmic axis: who holds, and who diverges."""

from __future__ import annotations

from collections.abc import Mapping

from robustnav.records import Array
from robustnav.report.drawing import Plot, caption, trace
from robustnav.report.style import CYCLE, add_legend, label_time, label_value, new_figure


def growth(t: Array, errors: Mapping[str, Array], words: str) -> Plot:
    """Draw errors against time, one line an estimator.

    Parameters
    ----------
    t : (n,) times [s].
    errors : by estimator (n,), positive [deg].
    words : what the errors are of, for the caption.
    """
    figure, (axes,) = new_figure(1, row_in=2.8)
    fewer = False
    for k, (name, values) in enumerate(errors.items()):
        color, line = CYCLE[k % len(CYCLE)], "--" if k % 2 else "-"
        fewer |= trace(axes, t, values, label=name, color=color, linestyle=line, linewidth=1.2)
    axes.set_yscale("log")
    label_value(axes, "RMS error, deg")
    label_time(axes)
    add_legend(figure, axes)
    return Plot(figure, caption([words], fewer))
