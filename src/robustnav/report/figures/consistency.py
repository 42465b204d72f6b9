"""NEES or NIS averaged over runs, with its chi-square band."""

from __future__ import annotations

from robustnav.evaluate.consistency import consistency
from robustnav.records import Array
from robustnav.report.drawing import Plot, caption, trace
from robustnav.report.style import BAND, BAND_ALPHA, BOUND, ESTIMATE, add_legend, label_time, label_value, new_figure


def consistency_band(t: Array, values: Array, dof: int, name: str = "NEES") -> Plot:
    """Draw the average of squared normalised errors over independent runs.

    Parameters
    ----------
    t : (n,) times [s].
    values : (runs, n) NEES or NIS, see ``robustnav.evaluate.nees``.
    dof : degrees of freedom of each value.
    name : what the values are.
    """
    test = consistency(values, dof)
    figure, (axes,) = new_figure(1, row_in=2.4)
    percent = f"{100 * test.confidence:g} %"
    axes.axhspan(test.low, test.high, color=BAND, alpha=BAND_ALPHA, linewidth=0, label=f"{percent} band")
    axes.axhline(dof, color=BOUND, linewidth=1.0, linestyle="--", zorder=3, label=f"Expected, {dof}")
    axes.hlines([test.low, test.high], t[0], t[-1], color=BOUND, linewidth=0.8, zorder=3)
    fewer = trace(axes, t, values.mean(axis=0), color=ESTIMATE, linewidth=0.9, label=f"Average of {test.runs} runs")
    label_value(axes, name)
    label_time(axes)
    add_legend(figure, axes)
    words = [
        f"{name} averaged over {test.runs} runs: {100 * test.inside:.1f} % of {test.steps} steps inside the "
        f"{percent} chi-square band [{test.low:.3g}, {test.high:.3g}], mean {test.mean:.3g}, expected {dof}.",
        f"NaN values, counted as outside: {test.missing}." if test.missing else "",
    ]
    return Plot(figure, caption(words, fewer))
