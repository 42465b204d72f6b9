"""Which sensor was heard when, and where it fell silent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from robustnav.evaluate.reference import gaps
from robustnav.records import Array, Stream
from robustnav.report.drawing import Plot, caption, trace
from robustnav.report.style import BLUE, REFUSED, SMALL_PT, add_legend, label_time, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BAR = 0.3  # height of a stream's bar, of one row


def timeline(streams: Sequence[Stream]) -> Plot:
    """Draw when each stream has samples, and its gaps: intervals longer than three median ones."""
    figure, (axes,) = new_figure(1, row_in=0.55 + 0.42 * len(streams))
    words, fewer = [], False
    for row, stream in enumerate(streams):
        silent = gaps(stream.t)
        fewer |= _draw(axes, row, stream.t, silent)
        if len(silent):
            longest = float(np.max(np.diff(silent, axis=1)))
            words.append(f"Gaps in {stream.name}: {len(silent)}, the longest {longest:.3g} s.")
    axes.set_yticks(range(len(streams)), [f"{one.name}  {one.rate_hz:.4g} Hz" for one in streams], fontsize=SMALL_PT)
    axes.set_ylim(len(streams) - 0.4, -0.6)
    axes.grid(False, axis="y")
    label_time(axes)
    add_legend(figure, axes)
    words.insert(0, "Samples of each stream over time." if words else "Samples of each stream over time; no gaps.")
    return Plot(figure, caption(words, fewer))


def _draw(axes: Axes, row: int, t: Array, silent: Array) -> bool:
    if not len(t):
        return False
    starts, ends = np.append(t[0], silent[:, 1]), np.append(silent[:, 0], t[-1])
    spans = list(zip(starts.tolist(), (ends - starts).tolist(), strict=True))
    axes.broken_barh(spans, (row - BAR / 2, BAR), color=BLUE, linewidth=0, label="Samples")
    # A tick higher than the bar shows a gap that is too short to be seen in it.
    ticks: dict[str, Any] = {"linestyle": "none", "marker": "|", "markersize": 15, "markeredgewidth": 1.5}
    return bool(len(silent)) and trace(
        axes, silent.mean(axis=1), np.full(len(silent), float(row)), color=REFUSED, label="Gap", **ticks
    )
