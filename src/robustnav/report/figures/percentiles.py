"""The spread of an error over many runs."""

from __future__ import annotations

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Array
from robustnav.report.drawing import Plot, band, caption, trace
from robustnav.report.style import ESTIMATE, add_legend, label_time, label_value, new_figure

LOW, HIGH = 5, 95


def percentile_band(t: Array, values: Array, label: str, *, log: bool = False) -> Plot:
    """Draw the median of ``values`` over runs and the band from the 5th to the 95th percentile.

    Parameters
    ----------
    t : (n,) times [s].
    values : (runs, n) e.g. the size of the attitude error; a run with a NaN is left out and counted in the caption.
    label : name and unit of the values.
    log : logarithmic value axis.

    Raises
    ------
    InputError : no run without NaN.
    """
    whole = values[~np.isnan(values).any(axis=1)]
    if not len(whole):
        raise InputError("percentile band", got=f"{len(values)} runs, all with NaN", expected="a run without NaN")
    low, middle, high = np.percentile(whole, [LOW, 50, HIGH], axis=0)
    figure, (axes,) = new_figure(1, row_in=2.6)
    fewer = band(axes, t, low, high, f"{LOW} to {HIGH} % of runs")
    fewer |= trace(axes, t, middle, color=ESTIMATE, linewidth=1.2, label="Median")
    if log:
        axes.set_yscale("log")
    label_value(axes, label)
    label_time(axes)
    add_legend(figure, axes)
    failed = len(values) - len(whole)
    words = [
        f"Median and {LOW}th to {HIGH}th percentile of {len(whole)} runs.",
        f"Runs left out for a NaN: {failed}." if failed else "",
    ]
    return Plot(figure, caption(words, fewer))
