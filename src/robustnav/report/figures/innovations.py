"""What a sensor told the filter that the filter did not expect."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from robustnav.records import Array, Innovations
from robustnav.report.drawing import Plot, axis_names, band, caption, shown_in, trace
from robustnav.report.style import ESTIMATE, REFUSED, add_legend, label_time, label_value, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_SIGMAS = 8.0


def innovations(sensor: str, data: Innovations, unit: str) -> Plot:
    """Draw one sensor's innovations with three predicted standard deviations; refused readings are crosses.

    A reading further out than ``MAX_SIGMAS`` median standard deviations is drawn at the edge of the plot, and
    counted in the caption.  ``unit`` is the SI unit of the readings.
    """
    size = data.z.shape[1]
    figure, rows = new_figure(size)
    shown, factor = shown_in(unit)
    z, sigma = data.z / factor, np.sqrt(data.s) / factor
    fewer, beyond = False, 0
    for k, (axes, name) in enumerate(zip(rows, axis_names(size), strict=True)):
        limit = _limit(z[:, k], sigma[:, k])
        beyond += int(np.sum(np.abs(z[:, k]) > limit))
        if np.isfinite(sigma[:, k]).any():
            fewer |= band(axes, data.t, -3 * sigma[:, k], 3 * sigma[:, k], "±3 standard deviations predicted")
        fewer |= _readings(axes, data, np.clip(z[:, k], -limit, limit))
        axes.set_ylim(-1.08 * limit, 1.08 * limit)
        label_value(axes, f"{name}, {shown}")
    label_time(rows[-1])
    figure.align_ylabels(rows)
    add_legend(figure, rows[0])
    refused, missing = refusals(data)
    words = [
        f"Innovations of {sensor}: {len(data.t)} readings, {refused} refused, {missing} missing.",
        f"Values beyond the plot, drawn at its edge: {beyond}." if beyond else "",
    ]
    return Plot(figure, caption(words, fewer))


def refusals(data: Innovations) -> tuple[int, int]:
    """Return how many readings a gate refused, and how many were missing altogether or in part."""
    complete = np.isfinite(data.z).all(axis=1)
    return int(np.sum(complete & ~data.used)), int(np.sum(~complete))


def _readings(axes: Axes, data: Innovations, z: Array) -> bool:
    crosses: dict[str, Any] = {
        "linestyle": "none",
        "color": REFUSED,
        "marker": "x",
        "markersize": 4,
        "label": "Refused",
    }
    # A line: of decimated points only the extremes are left, which drawn as dots would look like two clusters.
    fewer = trace(axes, data.t[data.used], z[data.used], color=ESTIMATE, linewidth=0.7, label="Used")
    if not data.used.all():
        fewer |= trace(axes, data.t[~data.used], z[~data.used], **crosses)
    return fewer


def _limit(z: Array, sigma: Array) -> float:
    largest = float(np.max(np.abs(z[np.isfinite(z)]), initial=0.0))
    if np.isfinite(sigma).any():
        spread = float(np.nanmedian(sigma))
        largest = min(max(largest, 3.3 * spread), MAX_SIGMAS * spread)
    return largest or 1.0
