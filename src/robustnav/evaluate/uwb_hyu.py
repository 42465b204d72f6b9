"""The published metric of the HYU outdoor set: errors inside a window of the path, a fixed height under the tag.

"Comprehensive outdoor UWB dataset", Scientific Data 2025, doi 10.1038/s41597-025-05887-9, the authors' script.  It is
reproduced to the last printed digit; here it works in frame a, (x, -y, -z) of the source's, so distances are the same.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from robustnav.errors import InputError
from robustnav.logs.uwb_recording import NANO, RangeRecording
from robustnav.records import Array, BoolArray

Trajectory = Literal["A", "B"]
TAG_FROM_REFERENCE_A = np.array([0.0, 0.0, -1.0])  # m: the metric takes the tag to be 1 m above the reference
LEVEL = 0.5  # m, of the reference's height inside the window


class Window(NamedTuple):
    """First and last row of the reference that the metric takes, both included."""

    first: int
    last: int


def hyu_window(recording: RangeRecording, trajectory: Trajectory) -> Window:
    """Return the window of the metric for a case on trajectory A or B.

    Raises
    ------
    InputError : another trajectory, or a reference that never enters or never leaves the window.
    """
    x, y, _ = recording.reference["position"].values.T
    west, far = x < 8.6, y > 7.0  # y of frame a: the source's, negated
    if trajectory == "A":
        entered, left = (x > 49.3) & (y < 5.0), (x <= 12.0) & (y < -3.4)
    elif trajectory == "B":
        entered, left = west & far, (x > 8.6) & far
    else:
        raise InputError("HYU trajectory", got=repr(trajectory), expected="A or B")
    place = recording.log.source
    first = _first(entered, 0, f"never enters the window of {trajectory}", place)
    return Window(first, _first(left, first, f"never leaves the window of {trajectory}", place))


def in_window(recording: RangeRecording, t: Array, window: Window) -> BoolArray:
    """Return which times (n,) [s] lie in the window, ends included."""
    stamps, ends = _stamps(recording, t), _stamps(recording, recording.reference["position"].t)[list(window)]
    return np.asarray((stamps >= ends[0]) & (stamps <= ends[1]))


def in_reference(recording: RangeRecording, t: Array) -> BoolArray:
    """Return which times (n,) [s] lie in the reference's span, ends included."""
    return in_window(recording, t, Window(0, -1))


def hyu_errors(recording: RangeRecording, t: Array, p_a: Array, window: Window | None = None) -> Array:
    """Return estimate minus where the metric takes the tag to be (n, 3) [m], frame a.

    Parameters
    ----------
    recording : its reference.
    t : (n,) times [s], see ``in_window`` and ``in_reference``.
    p_a : (n, 3) positions [m], frame a, NaN where there is none.
    window : of the metric, with its rule that the reference be within 0.5 m of its starting height; None takes the
        whole reference as it is.
    """
    position = recording.reference["position"]
    stamps = _stamps(recording, position.t)
    rows = np.arange(len(stamps)) if window is None else np.arange(window.first, window.last + 1)
    base = stamps[rows[0]]
    if window is not None:
        rows = rows[np.abs(position.values[rows, 2]) < LEVEL]
    at = _stamps(recording, t) - base
    reference = np.column_stack([np.interp(at, stamps[rows] - base, column) for column in position.values[rows].T])
    out: Array = p_a - reference - TAG_FROM_REFERENCE_A
    return out


def _stamps(recording: RangeRecording, t: Array) -> Array:
    """Return times as float64 nanoseconds since 1970, 256 ns apart: the metric computes with these."""
    whole = recording.log.origin_ns + np.round(t / NANO).astype(np.int64)
    return np.asarray(whole, float)


def _first(mask: BoolArray, start: int, got: str, place: str) -> int:
    found = np.flatnonzero(mask[start:])
    if not found.size:
        expected = "a whole run of its trajectory"
        raise InputError("HYU reference", place=place, got=got, expected=expected, do="check the trajectory's letter")
    return start + int(found[0])
