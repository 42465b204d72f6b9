"""Range errors over distance, before and after a calibration."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robustnav.calibrate.pairs import Pairs
from robustnav.calibrate.ranges import RangeCalibration
from robustnav.records import Array, IntArray
from robustnav.report.drawing import Plot, caption
from robustnav.report.style import BAND, BAND_ALPHA, CYCLE, INK, MUTED, add_legend, label_value, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BINS = 60  # places along the distance where the files are not told
LOW, HIGH = 5, 95
LEVEL_SD = 2.0
BAND_NAME = f"±{LEVEL_SD:g} sd of a range"


def residual_ranges(pairs: Pairs, corrected: Array, calibration: RangeCalibration) -> Plot:
    """Draw measured minus true distance over the true one, and what a calibration leaves of it.

    Parameters
    ----------
    pairs : true distances and measured ranges.
    corrected : (n,) the calibrated distances [m].
    calibration : whose corrections are drawn as lines.
    """
    figure, (before, after) = new_figure(2, row_in=2.4)
    group = _groups(pairs)
    d = pairs.distance_true
    _spots(before, group, d, pairs.measured - d, CYCLE[0])
    reach = np.linspace(pairs.measured.min(), pairs.measured.max(), 200)
    for k, (key, correction) in enumerate(calibration.corrections.items()):
        true = correction.distance(reach)
        label = f"Correction {'-'.join(key)}".strip() if k < len(CYCLE) else "_"
        before.plot(true, reach - true, color=CYCLE[(k + 1) % len(CYCLE)], linewidth=1.2, label=label, zorder=4)
    _spots(after, group, d, corrected - d, CYCLE[0])
    sd = float(np.sqrt(np.median([c.range_variance for c in calibration.corrections.values()])))
    after.axhspan(-LEVEL_SD * sd, LEVEL_SD * sd, color=BAND, alpha=BAND_ALPHA, linewidth=0)
    for axes, name in ((before, "Before, m"), (after, "After, m")):
        axes.axhline(0.0, color=INK, linewidth=0.8)
        label_value(axes, name)
        axes.margins(x=0.02)
    after.set_xlabel("True distance, m", color=INK)
    figure.align_ylabels([before, after])
    before.plot([], [], color=BAND, alpha=BAND_ALPHA, linewidth=6, label=BAND_NAME)
    add_legend(figure, before)
    place = "file" if pairs.file is not None else "place"
    words = f"Range errors before and after calibration: median of each {place}, bars from {LOW} to {HIGH} %."
    return Plot(figure, caption([words], False))


def _groups(pairs: Pairs) -> IntArray:
    """Return the number of the file and anchor, or of the stretch of distance, of each reading (n,)."""
    if pairs.file is None:
        span = np.ptp(pairs.distance_true) or 1.0
        place = (BINS * (pairs.distance_true - pairs.distance_true.min()) / span).astype(np.int64)
        return np.asarray(np.minimum(place, BINS - 1), np.int64)
    return np.asarray(np.unique(pairs.file, return_inverse=True)[1], np.int64)


def _spots(axes: Axes, group: IntArray, d: Array, error: Array, colour: str) -> None:
    rows = [np.flatnonzero(group == k) for k in np.unique(group)]
    middle = np.array([[np.mean(d[r]), *np.percentile(error[r], [LOW, 50, HIGH])] for r in rows])
    axes.vlines(middle[:, 0], middle[:, 1], middle[:, 3], color=MUTED, linewidth=0.7)
    axes.plot(middle[:, 0], middle[:, 2], "o", color=colour, markersize=3.5, linestyle="none", label="Measured")
