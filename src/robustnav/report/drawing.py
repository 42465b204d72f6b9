"""What every figure is made of: decimated traces, bands, and a caption that says what was left out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from robustnav.evaluate.reference import gaps
from robustnav.records import Array
from robustnav.report.decimate import MAX_POINTS, decimate
from robustnav.report.style import BAND, BAND_ALPHA, MUTED
from robustnav.units import DEG, DPS, MICRO_TESLA

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DECIMATED = f"Traces are decimated to {MAX_POINTS} points by minimum and maximum; numbers in words use all data."

VISIBLE_GAP = 0.005  # of the time axis
SHOWN_IN = {
    "rad": ("deg", DEG),
    "rad/s": ("deg/s", DPS),
    "T": ("µT", MICRO_TESLA),
    "m/s^2": ("m/s²", 1.0),
}


@dataclass(frozen=True)
class Plot:
    """A matplotlib ``figure`` and the ``caption`` to print below it."""

    figure: Figure
    caption: str


def caption(sentences: Iterable[str], decimated: bool) -> str:
    """Return a caption of sentences, the empty ones left out, that says when traces are decimated."""
    return " ".join([sentence for sentence in sentences if sentence] + [DECIMATED] * decimated)


def trace(axes: Axes, t: Array, values: Array, *, turn: float | None = None, **style: Any) -> bool:
    """Draw one trace (n,) and say whether it was decimated.

    The line breaks at gaps wide enough to see, and with ``turn`` where an angle wraps.
    """
    silent = gaps(t)
    silent = silent[np.diff(silent, axis=1)[:, 0] > VISIBLE_GAP * np.ptp(t)] if len(silent) else silent
    t, values, fewer = decimate(t, values)
    breaks = np.searchsorted(t, silent[:, 0], side="right")
    if turn is not None:
        breaks = np.union1d(breaks, np.flatnonzero(np.abs(np.diff(values)) > turn / 2) + 1)
    axes.plot(np.insert(t, breaks, t[breaks]), np.insert(values, breaks, np.nan), **style)
    return fewer


def band(axes: Axes, t: Array, low: Array, high: Array, label: str) -> bool:
    """Draw a band from ``low`` to ``high`` (n,) and say whether it was decimated."""
    t, edges, fewer = decimate(t, np.column_stack([low, high]))
    axes.fill_between(t, *edges.T, color=BAND, alpha=BAND_ALPHA, linewidth=0, label=label)
    axes.plot(t, edges, color=MUTED, linewidth=0.7, zorder=3)  # a dense trace may cover the band
    return fewer


def shown_in(unit: str) -> tuple[str, float]:
    """Return the unit to show for values in an SI unit, and its size: degrees for radians, microtesla for tesla."""
    return SHOWN_IN.get(unit, (unit, 1.0))


def axis_names(count: int) -> tuple[str, ...]:
    """Return x, y, z for three components, numbers otherwise."""
    return ("x", "y", "z") if count == 3 else tuple(str(k + 1) for k in range(count))
