"""Where a tag went and where it was believed to be, from above and from the side, with ellipses of doubt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from robustnav.records import Array
from robustnav.report.drawing import Plot, caption
from robustnav.report.style import (
    BAND,
    BAND_ALPHA,
    ESTIMATE,
    INK,
    MUTED,
    REFERENCE,
    add_legend,
    label_value,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ELLIPSES = 24  # along the way
SIGMAS = 3.0
CIRCLE = np.linspace(0.0, 2 * np.pi, 61)


@dataclass(frozen=True)
class Travelled:
    """Positions ``p_n``, the truth ``p_true``, standard deviations ``sd``, all (n, 3) [m]; ``anchors`` (k, 3) [m]."""

    p_n: Array
    p_true: Array
    sd: Array
    anchors: Array


def trajectory(way: Travelled, words: str) -> Plot:
    """Draw a way over north and east, and its height over north, with ellipses of three standard deviations.

    The axes of the ellipses are those of the frame: a run keeps standard deviations, not their correlations.
    """
    figure, (above, side) = new_figure(2, row_in=3.1)
    height = np.array([1.0, 1.0, -1.0])
    for axes, across, name in ((above, 1, "East, m"), (side, 2, "Height, m")):
        true, est, anchors = way.p_true * height, way.p_n * height, way.anchors * height
        axes.plot(true[:, 0], true[:, across], color=REFERENCE, linewidth=1.0, linestyle="--", label="Truth")
        axes.plot(est[:, 0], est[:, across], color=ESTIMATE, linewidth=1.0, label="Estimate")
        axes.plot(anchors[:, 0], anchors[:, across], "^", color=MUTED, markersize=7, linestyle="none", label="Anchors")
        _ellipses(axes, est[:, [0, across]], way.sd[:, [0, across]])
        axes.margins(0.03)
        label_value(axes, name)
    side.set_xlabel("North, m", color=INK)
    figure.align_ylabels([above, side])
    add_legend(figure, above)
    doubt = f"Ellipses: {SIGMAS:g} standard deviations at {ELLIPSES} places. Axes differ in scale."
    return Plot(figure, caption([words, doubt], False))


def _ellipses(axes: Axes, centre: Array, sd: Array) -> None:
    rows = np.linspace(0, len(centre) - 1, ELLIPSES).astype(int)
    for k, row in enumerate(rows):
        outline = centre[row] + SIGMAS * sd[row] * np.column_stack([np.cos(CIRCLE), np.sin(CIRCLE)])
        label = f"{SIGMAS:g} standard deviations" if k == 0 else "_"
        axes.fill(
            *outline.T, facecolor=BAND, alpha=BAND_ALPHA, edgecolor=ESTIMATE, linewidth=0.6, label=label, zorder=3
        )
