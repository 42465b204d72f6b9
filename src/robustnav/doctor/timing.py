"""T: what the stamps of a stream say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.records import Stream

ROUNDING = 1.001  # an interval of exactly two medians is not a gap because of the last bit of a stamp


@dataclass(frozen=True)
class Timing:
    """Stamps of one stream.

    ``rows``; ``rate_hz`` = (n - 1) / (last - first); ``interval_s`` median of the intervals above zero; ``repeats``
    intervals of zero; ``gaps`` intervals above two medians, ``stretched`` above one and a half;
    ``largest_gap_s`` the longest interval, which begins at ``largest_gap_at_s`` [s].
    """

    rows: int
    start_s: float
    stop_s: float
    rate_hz: float
    interval_s: float
    repeats: int
    gaps: int
    stretched: int
    largest_gap_s: float
    largest_gap_at_s: float


def timing(stream: Stream) -> Timing:
    """Return the time figures of a stream; NaN where it has too few distinct stamps."""
    nan = float("nan")
    t = stream.t
    dt = np.diff(t)
    positive = dt[dt > 0]
    start, stop = (float(t[0]), float(t[-1])) if len(t) else (nan, nan)
    repeats = int(len(dt) - len(positive))
    if not len(positive):
        return Timing(len(t), start, stop, nan, nan, repeats, 0, 0, nan, nan)
    median = float(np.median(positive))
    longest = int(np.argmax(dt))
    return Timing(
        rows=len(t),
        start_s=start,
        stop_s=stop,
        rate_hz=stream.rate_hz,
        interval_s=median,
        repeats=repeats,
        gaps=int(np.sum(dt > 2 * median * ROUNDING)),
        stretched=int(np.sum(dt > 1.5 * median)),
        largest_gap_s=float(dt[longest]),
        largest_gap_at_s=float(t[longest]),
    )
