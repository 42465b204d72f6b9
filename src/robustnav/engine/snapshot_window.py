"""The minima of a window of readings compiled: what ``robustnav.snapshot.window`` finds, for a loop that asks often."""

from __future__ import annotations

from typing import Literal

import numpy as np

from robustnav.engine import _kernel
from robustnav.errors import InputError
from robustnav.records import Array
from robustnav.snapshot.window import Minimum, WindowReadings

MAX_READINGS, MAX_ANCHORS, MAX_GUESSES = 512, 32, 8
_MINIMA, _ROW = 36, 10  # rn_snapshot_host.h
_PACKED = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
_UNKNOWN, _WITH_SD, _EXACT = range(3)


def robust_minima(
    readings: WindowReadings, guesses: Array | None = None, real: Literal["double", "float"] = "double"
) -> list[Minimum]:
    """Return the minima of the robust cost, the lowest first; the same as ``robustnav.snapshot.window.robust_minima``.

    Parameters
    ----------
    readings : of a window in which the tag hardly moves: at most 512, of at most 32 anchors.
    guesses : (k, 3) at most 8 places to start from beside the closed forms [m], or None.
    real : number type of the kernel, ``double`` or ``float``.

    Returns
    -------
    minima : empty with fewer than three readings.

    Raises
    ------
    InputError : shapes, numbers that are not finite, an sd that is not positive, more than the kernel holds.
    """
    return _call(readings, np.zeros((0, 3)) if guesses is None else guesses, None, real)[0]


def robust_search(
    readings: WindowReadings, track: Array, real: Literal["double", "float"] = "double"
) -> tuple[list[Minimum], float]:
    """Return the minima, started at the end of a track as well, and the robust cost of the track itself.

    Parameters
    ----------
    readings : of a window in which the tag hardly moves.
    track : (m, 3) where a filter believes the tag was at each reading, the newest last [m].
    real : number type of the kernel, ``double`` or ``float``.

    Returns
    -------
    minima, cost : a filter is lost where the first minimum costs much less than its track.

    Raises
    ------
    InputError : as for ``robust_minima``; a track of another length.
    """
    places = np.ascontiguousarray(track, float)
    if places.shape != (len(readings.value), 3) or not np.isfinite(places).all():
        expected = f"finite positions, shape ({len(readings.value)}, 3)"
        raise InputError("window track", got=f"shape {places.shape}", expected=expected)
    return _call(readings, places[-1:], places, real)


def _call(readings: WindowReadings, guesses: Array, track: Array | None, real: str) -> tuple[list[Minimum], float]:
    arrays = _checked(readings)
    starts = np.ascontiguousarray(guesses, float)
    if starts.ndim != 2 or starts.shape[1] != 3 or len(starts) > MAX_GUESSES or not np.isfinite(starts).all():
        expected = f"finite positions, shape (0 to {MAX_GUESSES}, 3)"
        raise InputError("window guesses", got=f"shape {starts.shape}", expected=expected)
    if real not in ("double", "float"):
        raise InputError("window real", got=repr(real), expected="double or float")
    if not len(readings.value):
        return [], 0.0
    known, down = _UNKNOWN, 0.0
    if readings.down is not None:
        known, down = _EXACT if readings.down_sd == 0.0 else _WITH_SD, float(readings.down)
    rows = np.empty((_MINIMA, _ROW))
    count, cost = _kernel.window(real, *arrays, (known, down, float(readings.down_sd)), starts, track, rows)
    return [Minimum(r[:3].copy(), r[3:9][_PACKED], float(r[9])) for r in rows[:count]], cost


def _checked(readings: WindowReadings) -> tuple[Array, ...]:
    """Return value, sd, first, second and pairs as the kernel takes them."""
    m = len(readings.value)
    if m > MAX_READINGS:
        do = "use robustnav.snapshot.window, which has no limit"
        raise InputError("window", got=f"{m} readings", expected=f"at most {MAX_READINGS}", do=do)
    pairs = np.ascontiguousarray(readings.pairs, np.uint8)
    arrays = [np.ascontiguousarray(getattr(readings, name), float) for name in ("value", "sd", "first", "second")]
    shapes = [(m,), (m,), (m, 3), (m, 3)]
    for name, array, shape in zip(("value", "sd", "first", "second"), arrays, shapes, strict=True):
        if array.shape != shape:
            raise InputError(f"window {name}", got=f"shape {array.shape}", expected=f"shape {shape}")
        good = np.isfinite(array) & ((array > 0) | (name != "sd"))
        if not good.all():
            row = int(np.argwhere(~good)[0, 0])
            expected = "a finite sd above zero, in m" if name == "sd" else "finite numbers in m"
            raise InputError(f"window {name}", place=f"row {row}", got=str(array[row]), expected=expected)
    if pairs.shape != (m,):
        raise InputError("window pairs", got=f"shape {pairs.shape}", expected=f"shape ({m},)")
    height = (0.0 if readings.down is None else readings.down, readings.down_sd)
    if not (np.isfinite(height).all() and readings.down_sd >= 0.0):
        expected = "a finite coordinate and an sd of zero or more, in m"
        raise InputError("window height", got=str(height), expected=expected)
    places = len(np.unique(np.vstack([arrays[2], arrays[3][pairs > 0]]), axis=0))
    if places > MAX_ANCHORS:
        do = "use robustnav.snapshot.window, which has no limit"
        raise InputError("window", got=f"{places} anchors", expected=f"at most {MAX_ANCHORS}", do=do)
    return (*arrays, pairs)
