"""How innovations of ranges are distributed, beside the Gauss curve they would follow without outliers."""

from __future__ import annotations

import numpy as np

from robustnav.records import Innovations
from robustnav.report.drawing import Plot, caption
from robustnav.report.style import BLUE, BOUND, INK, add_legend, label_value, new_figure

EDGE = 8.0  # standard deviations
BINS = 80
FAR = 3.0


def ranging_histogram(data: Innovations, words: str) -> Plot:
    """Draw the histogram of innovations over their predicted standard deviations on a logarithmic axis.

    Parameters
    ----------
    data : of one sensor with one row a reading.
    words : what the readings are of, for the caption.
    """
    figure, (axes,) = new_figure(1, row_in=2.8)
    scaled = data.z[:, 0] / np.sqrt(data.s[:, 0])
    scaled = scaled[np.isfinite(scaled)]
    edges = np.linspace(-EDGE, EDGE, BINS + 1)
    counts, _ = np.histogram(np.clip(scaled, -EDGE, EDGE), edges)
    middle = 0.5 * (edges[1:] + edges[:-1])
    axes.bar(middle, counts, width=0.9 * (edges[1] - edges[0]), color=BLUE, label="Readings")
    expected = len(scaled) * (edges[1] - edges[0]) * np.exp(-0.5 * middle**2) / np.sqrt(2 * np.pi)
    axes.plot(middle, expected, color=BOUND, linewidth=1.2, linestyle="--", label="Gauss")
    axes.set_yscale("log")
    axes.set_ylim(0.5, None)
    axes.margins(x=0.01)
    axes.set_xlabel("Innovation over predicted standard deviation", color=INK)
    label_value(axes, "Readings")
    add_legend(figure, axes)
    far = 100 * float(np.mean(np.abs(scaled) > FAR)) if scaled.size else 0.0
    beyond = f"{far:.1f} % of {len(scaled)} lie beyond {FAR:g} standard deviations, 0.3 % are expected."
    return Plot(figure, caption([words, beyond, "What lies beyond the plot is in its last bars."], False))
