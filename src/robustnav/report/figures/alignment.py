"""An initial alignment over time: misalignment of several methods, existence of the H-infinity filter, the wind."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robustnav.frames import Array
from robustnav.report.drawing import Plot, band, caption, trace
from robustnav.report.style import CYCLE, REFERENCE, add_legend, label_time, label_value, new_figure
from robustnav.units import ARCMIN

LINES = ("-", "--", ":")


def tilt_courses(t: Array, middle: Mapping[str, Array], high: Mapping[str, Array], words: str) -> Plot:
    """Draw the tilt of several methods: above the median over runs, below the 95th percentile.

    Parameters
    ----------
    t : (n,) times [s].
    middle, high : by method (n,) [arcmin], positive; NaN where it said nothing.
    words : what was run, for the caption.
    """
    figure, axes = new_figure(2, row_in=2.2)
    fewer = False
    for one, curves, label in zip(axes, (middle, high), ("Median tilt, arcmin", "95 % tilt, arcmin"), strict=True):
        for k, (name, values) in enumerate(curves.items()):
            said = ~np.isnan(values)
            line = LINES[k % len(LINES)]
            fewer |= trace(
                one, t[said], values[said], label=name, color=CYCLE[k % len(CYCLE)], linestyle=line, linewidth=1.2
            )
        one.set_yscale("log")
        label_value(one, label)
    label_time(axes[-1])
    add_legend(figure, axes[0])
    return Plot(figure, caption([words], fewer))


def misalignment(t: Array, tilt: Array, sd: Array, name: str, limit_arcmin: float = 30.0) -> Plot:
    """Draw misalignment about north and east of one run with twice the standard deviation the filter claims.

    Parameters
    ----------
    t : (n,) times [s].
    tilt : (n, 2) about north and east [rad].
    sd : (n,) of one axis [rad].
    name : of the method.
    limit_arcmin : larger values are not drawn.
    """
    figure, axes = new_figure(2, row_in=1.8)
    bound = np.minimum(2 * sd / ARCMIN, 2 * limit_arcmin)
    fewer = False
    for one, values, label in zip(axes, tilt.T / ARCMIN, ("North, arcmin", "East, arcmin"), strict=True):
        fewer |= band(one, t, -bound, bound, "2 sd claimed")
        fewer |= trace(one, t, values, label=name, color=CYCLE[0], linewidth=1.2)
        one.set_ylim(-limit_arcmin, limit_arcmin)
        label_value(one, label)
    label_time(axes[-1])
    add_legend(figure, axes[0])
    words = f"Misalignment of {name} in one run; axes end at {limit_arcmin:g} arcmin."
    return Plot(figure, caption([words], fewer))


def existence(t: Array, margin: Array, words: str) -> Plot:
    """Draw the existence margin (n,) of an H-infinity filter: it exists where the margin is above zero."""
    figure, (axes,) = new_figure(1, row_in=1.8)
    fewer = trace(axes, t, 1 - margin, label="1 - margin", color=CYCLE[0], linewidth=1.2)
    axes.axhline(1.0, color=REFERENCE, linestyle="--", linewidth=1.0, label="No filter at and above")
    axes.set_yscale("log")
    label_value(axes, "1 - margin")
    label_time(axes)
    add_legend(figure, axes)
    return Plot(figure, caption([words], fewer))


def disturbance(t: Array, true: Array, found: Array, words: str) -> Plot:
    """Draw a velocity disturbance north and east, ``true`` and ``found`` (n, 2) [m/s]."""
    figure, axes = new_figure(2, row_in=1.6)
    fewer = False
    for k, (one, label) in enumerate(zip(axes, ("North, m/s", "East, m/s"), strict=True)):
        fewer |= trace(one, t, true[:, k], label="True", color=REFERENCE, linewidth=1.0)
        said = ~np.isnan(found[:, k])
        fewer |= trace(one, t[said], found[said, k], label="Estimated", color=CYCLE[1], linestyle="--", linewidth=1.2)
        label_value(one, label)
    label_time(axes[-1])
    add_legend(figure, axes[0])
    return Plot(figure, caption([words], fewer))
