"""Fewer points for the eye, with every spike kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robustnav.records import Array

IntArray = NDArray[np.intp]
MAX_POINTS = 2000


def decimate(t: Array, values: Array, points: int = MAX_POINTS) -> tuple[Array, Array, bool]:
    """Return at most ``points`` samples: the first, the last, and the extremes of equal spans of time.

    A span that holds only NaN keeps one, so a hole in the trace stays a hole.  Numbers are never made from
    decimated traces.

    Parameters
    ----------
    t : (n,) times that never decrease.
    values : (n,) one trace, or (n, k) traces that keep common times, NaN where missing.

    Returns
    -------
    Times, values, and whether anything was left out.
    """
    if len(t) <= points:
        return t, values, False
    traces = values.reshape(len(t), -1).T
    spans = (points - 2) // (2 * len(traces))
    length = float(t[-1] - t[0])
    share = (t - t[0]) / length if length > 0 else np.zeros(len(t))
    span = np.minimum((share * spans).astype(int), spans - 1)
    ends = np.array([0, len(t) - 1])
    kept = np.unique(np.concatenate([ends, *(_extremes(span, one) for one in traces)]))
    return t[kept], values[kept], True


def _extremes(span: IntArray, values: Array) -> IntArray:
    """Return where each span has its lowest and its highest value; the first of a span with none."""
    known = np.flatnonzero(np.isfinite(values))
    order = known[np.lexsort((values[known], span[known]))]
    seen, first, counts = np.unique(span[order], return_index=True, return_counts=True)
    everywhere, start = np.unique(span, return_index=True)
    return np.concatenate([order[first], order[first + counts - 1], start[~np.isin(everywhere, seen)]])
