"""Times, names and the samples of one sensor: what the other records are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robustnav.errors import InputError

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]


def check_time(t: Array, thing: str) -> None:
    """Raise ``InputError`` unless ``t`` (n,) is finite and never decreases; the message names the row."""
    if t.ndim != 1:
        raise InputError(f"time of {thing}", got=f"shape {t.shape}", expected="shape (n,)")
    bad = np.flatnonzero(~np.isfinite(t))
    if bad.size:
        raise InputError(
            f"time of {thing}",
            place=f"row {bad[0]}",
            got=str(t[bad[0]]),
            expected="a finite number of seconds",
        )
    back = np.flatnonzero(np.diff(t) < 0)
    if back.size:
        k = int(back[0]) + 1
        raise InputError(
            f"time goes backwards in {thing}",
            place=f"row {k}",
            got=f"{t[k]:.6f} s after {t[k - 1]:.6f} s",
            expected="times that never decrease",
            do="sort or cut the recording, or drop the stream",
        )


def check_names(names: tuple[str, ...], thing: str) -> None:
    """Raise ``InputError`` unless there are names, all of them printable, not empty and different."""
    wrong = [name for name in names if not name or not name.isprintable() or name != name.strip()]
    twice = [name for name in names if names.count(name) > 1]
    if not names or wrong or twice:
        got = f"{twice[0]!r} twice" if twice and not wrong else repr(wrong[0]) if wrong else "none"
        raise InputError(f"names of {thing}", got=got, expected="different printable names, one at least")


@dataclass(frozen=True)
class Stream:
    """Samples of one sensor in time order.

    Parameters
    ----------
    name : sensor name as the models use it: ``gyro``, ``accel``, ``mag``, ...
    t : (n,) seconds since the log's start, never decreasing.
    values : (n, m) readings in ``unit``; NaN marks a missing number.
    unit : SI unit, e.g. ``rad/s``, ``m/s^2``, ``T``.
    frame : frame of the values, ``b`` for body axes (forward-right-down).

    Raises
    ------
    InputError : shapes differ, a time is not finite or goes backwards, a value is infinite.
    """

    name: str
    t: Array
    values: Array
    unit: str
    frame: str = "b"

    def __post_init__(self) -> None:
        object.__setattr__(self, "t", np.ascontiguousarray(self.t, float))
        object.__setattr__(self, "values", np.ascontiguousarray(self.values, float))
        if self.values.ndim != 2 or len(self.values) != len(self.t):
            raise InputError(
                f"stream {self.name!r}",
                got=f"values of shape {self.values.shape}",
                expected=f"shape ({len(self.t)}, m)",
            )
        check_time(self.t, f"stream {self.name!r}")
        bad = np.flatnonzero(np.isinf(self.values).any(axis=1))
        if bad.size:
            raise InputError(
                f"stream {self.name!r}",
                place=f"row {bad[0]}",
                got=str(self.values[bad[0]]),
                expected="finite numbers, or NaN where a reading is missing",
            )

    def __len__(self) -> int:
        return len(self.t)

    @property
    def rate_hz(self) -> float:
        """Mean sample rate (n - 1) / (last - first) [Hz]; NaN with fewer than two distinct times."""
        span = float(self.t[-1] - self.t[0]) if len(self.t) > 1 else 0.0
        return (len(self.t) - 1) / span if span > 0 else float("nan")

    def between(self, start: float, stop: float) -> Stream:
        """Return the samples with ``start <= t <= stop`` [s], times unchanged."""
        keep = slice(int(np.searchsorted(self.t, start)), int(np.searchsorted(self.t, stop, side="right")))
        return Stream(self.name, self.t[keep], self.values[keep], self.unit, self.frame)
