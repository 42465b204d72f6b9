"""What the range benchmarks compare of ours, by name: from a recording to positions at given times.

A method sees ranges, other sensors and anchors; it never sees the reference.  A new one is one line in ``METHODS``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robustnav.errors import InputError
from robustnav.logs.uwb_recording import RangeRecording
from robustnav.records import Array, Ranges, Run
from robustnav.snapshot import solve_ranges

Method = Callable[[RangeRecording, Array], Array]
"""From a recording and times (n,) [s] to positions (n, 3) [m] in frame a, NaN before the first one."""

RANGE_SD = 0.15  # m, of a range outdoors in motion; nothing is fitted to a recording
MAX_AGE = 0.25  # s, of a range that still counts as one of this instant


def snapshot_positions(recording: RangeRecording, t: Array) -> Array:
    """Return the position of each instant by itself, from every anchor's latest range within ``MAX_AGE``.

    Causal, without motion model; where the anchors heard are too few the last position stays.

    Raises
    ------
    InputError : ranges of several tags.
    """
    ranges = recording.ranges
    if len(ranges.tags) > 1:
        raise InputError("snapshot positions", got=f"{len(ranges.tags)} tags", expected="ranges of one tag")
    out = np.full((len(t), 3), np.nan)
    held = np.full(3, np.nan)
    for k, now in enumerate(t):
        fix = solve_ranges(ranges.anchors.p_a, _latest(ranges, now), RANGE_SD)
        held = fix.position if np.isfinite(fix.position).all() else held
        out[k] = held
    return out


def positions_at(run: Run, t: Array, *, smoothed: bool = False) -> Array:
    """Return positions (n, 3) [m] of a run with the blocks ``p_n`` and ``v_n`` at times ``t`` (n,) [s].

    The latest estimate is carried on by its velocity, so that no later reading takes part; with ``smoothed`` times
    between two estimates are interpolated.  NaN before the first estimate.
    """
    p, v = run.state["p_n"], run.state["v_n"]
    row = np.searchsorted(run.t, t, side="right") - 1
    latest = np.maximum(row, 0)
    out: Array = p[latest] + v[latest] * (t - run.t[latest])[:, None]
    out[row < 0] = np.nan
    inside = (row >= 0) & (t < run.t[-1])
    if smoothed:
        out[inside] = np.column_stack([np.interp(t[inside], run.t, column) for column in p.T])
    return out


METHODS: dict[str, Method] = {"snapshot": snapshot_positions}


def _latest(ranges: Ranges, now: float) -> Array:
    """Return each anchor's latest range (k,) [m] up to ``now`` [s]; NaN where there is none young enough."""
    first, stop = np.searchsorted(ranges.t, [now - MAX_AGE, now], side="right")
    out = np.full(len(ranges.anchors.ids), np.nan)
    out[ranges.anchor[first:stop]] = ranges.distance[first:stop]  # of equal anchors the last one stays
    return out
