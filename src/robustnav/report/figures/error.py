"""Attitude error inside, or outside, the band the filter claims."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robustnav.records import Array
from robustnav.report.drawing import Plot, band, caption, trace
from robustnav.report.style import ESTIMATE, add_legend, label_time, label_value, new_figure
from robustnav.units import DEG

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAVIGATION_AXES = ("About north", "About east", "About down")


def error_band(t: Array, error: Array, sd: Array | None = None, names: tuple[str, ...] = NAVIGATION_AXES) -> Plot:
    """Draw errors with the band of three standard deviations.

    Parameters
    ----------
    t : (n,) times [s].
    error : (n, k) errors [rad], NaN where there is no reference.
    sd : (n, k) claimed standard deviations on the same axes [rad], or None.
    names : of the k axes.
    """
    figure, rows = new_figure(len(names))
    fewer = False
    for k, (axes, name) in enumerate(zip(rows, names, strict=True)):
        error_deg = error[:, k] / DEG
        if sd is not None:
            claimed_deg = 3 * sd[:, k] / DEG
            fewer |= band(axes, t, -claimed_deg, claimed_deg, "±3 standard deviations claimed")
        fewer |= trace(axes, t, error_deg, color=ESTIMATE, linewidth=0.9, label="Error")
        _limit(axes, error_deg, None if sd is None else 3 * sd[:, k] / DEG)
        label_value(axes, f"{name}, deg")
    if np.ptp(t) > 0:
        rows[-1].set_xlim(t[0], t[-1])  # also where there is no reference
    label_time(rows[-1])
    figure.align_ylabels(rows)
    add_legend(figure, rows[0])
    return Plot(figure, caption(["Attitude error." if sd is None else _inside(error, sd)], fewer))


def _inside(error: Array, sd: Array) -> str:
    known = np.isfinite(error)
    if not known.any():
        return "Attitude error: no sample has both an estimate and a reference."
    share = np.mean(np.abs(error[known]) <= 3 * sd[known])
    return (
        f"Attitude error and the band of ±3 standard deviations the filter claims; {100 * share:.1f} % of the values "
        "lie inside, 99.7 % are expected. A wide band at the start may leave the plot."
    )


def _limit(axes: Axes, error: Array, claimed: Array | None) -> None:
    """Let the error fill the plot: the claim at the start may be hundreds of times wider."""
    largest = [np.max(np.abs(error[np.isfinite(error)]), initial=0.0)]
    if claimed is not None and np.isfinite(claimed).any():
        largest.append(1.3 * float(np.nanmedian(claimed)))
    if max(largest) > 0:
        axes.set_ylim(-1.1 * max(largest), 1.1 * max(largest))
