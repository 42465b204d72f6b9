"""A log's three sensors on the gyro's clock, as libraries that want one reading of each a sample take them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.records import Log, Stream


@dataclass(frozen=True)
class NineAxes:
    """One row a gyro sample, body FRD: ``t`` (n,) [s] and ``rate_hz``, their mean rate.

    ``gyro`` [rad/s], ``accel`` specific force [m/s^2], ``mag`` [T], each (n, 3) and contiguous.
    """

    t: Array
    gyro: Array
    accel: Array
    mag: Array
    rate_hz: float


def nine_axes(log: Log) -> NineAxes:
    """Return the readings of ``gyro``, ``accel`` and ``mag`` at the gyro's times.

    A sensor on other stamps, and a missing (NaN) reading, holds its latest reading; before its first reading it takes
    that one.  Such libraries count samples, not time, so this is all the timing they can be given.

    Raises
    ------
    InputError : a stream is missing, is not three columns wide or has no finite reading, or fewer than two gyro times.
    """
    gyro = log.stream("gyro")
    if not gyro.rate_hz > 0:
        raise InputError("no gyro rate", place=log.source, got=f"{len(gyro)} samples", expected="two times at least")
    turn, force, field = (_held(log.stream(name), gyro.t, log.source) for name in ("gyro", "accel", "mag"))
    return NineAxes(gyro.t, turn, force, field, gyro.rate_hz)


def _held(stream: Stream, t: Array, source: str) -> Array:
    finite = np.isfinite(stream.values).all(axis=1)
    if stream.values.shape[1] != 3 or not finite.any():
        got = f"{int(finite.sum())} finite rows of {stream.values.shape[1]} numbers"
        raise InputError(f"stream {stream.name!r}", place=source, got=got, expected="finite rows of 3 numbers")
    latest = np.searchsorted(stream.t[finite], t, side="right") - 1
    return np.ascontiguousarray(stream.values[finite][np.maximum(latest, 0)])
