"""Several methods or cases over time: how large their errors are, and whether they are as large as stated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from robustnav.frames import Array
from robustnav.report.drawing import Plot, caption, trace
from robustnav.report.style import BAND, BAND_ALPHA, BOUND, CYCLE, add_legend, label_time, label_value, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINES = ("-", "--", ":")


class Judged(NamedTuple):
    """Mean squared errors over their variances, expected 1: by case (n,), and the band that means of so many keep."""

    means: Mapping[str, Array]
    low: float
    high: float


def error_courses(t: Array, middle: Mapping[str, Array], high: Mapping[str, Array], what: str, words: str) -> Plot:
    """Draw an error of several cases: above the median over runs, below the 95th percentile.

    Parameters
    ----------
    t : (n,) times [s].
    middle, high : by case (n,), positive; NaN where nothing was said.
    what : name and unit of the error.
    words : what was run, for the caption.
    """
    figure, axes = new_figure(2, row_in=2.2)
    fewer = False
    for one, curves, label in zip(axes, (middle, high), (f"Median {what}", f"95 % {what}"), strict=True):
        fewer |= _lines(one, t, curves)
        one.set_yscale("log")
        label_value(one, label)
    label_time(axes[-1])
    add_legend(figure, axes[0])
    return Plot(figure, caption([words], fewer))


def nees_courses(t: Array, parts: Mapping[str, Judged], words: str) -> Plot:
    """Draw normalised squared errors of several cases, one row for each of ``parts``, with the band they should keep.

    Parameters
    ----------
    t : (n,) times [s].
    parts : by the name of what errs; NaN where not every run had begun.
    words : what was run, for the caption.
    """
    figure, axes = new_figure(len(parts), row_in=1.9)
    fewer = False
    for one, (what, judged) in zip(axes, parts.items(), strict=True):
        one.axhspan(judged.low, judged.high, color=BAND, alpha=BAND_ALPHA, linewidth=0)
        one.axhline(1.0, color=BOUND, linewidth=0.8, linestyle="--")
        fewer |= _lines(one, t, judged.means)
        one.set_ylim(bottom=0.0)
        label_value(one, f"NEES, {what}")
    label_time(axes[-1])
    add_legend(figure, axes[0])
    bands = ", ".join(f"{one.low:.2f} to {one.high:.2f} for {what}" for what, one in parts.items())
    return Plot(figure, caption([words, f"Expected 1; band {bands}."], fewer))


def _lines(axes: Axes, t: Array, curves: Mapping[str, Array]) -> bool:
    """Draw a line a case and say whether any was decimated."""
    fewer = False
    for k, (name, values) in enumerate(curves.items()):
        said = ~np.isnan(values)
        color, line = CYCLE[k % len(CYCLE)], LINES[k % len(LINES)]
        fewer |= trace(axes, t[said], values[said], label=name, color=color, linestyle=line, linewidth=1.2)
    return fewer
