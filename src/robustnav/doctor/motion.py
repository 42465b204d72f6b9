"""E and M: how much the vehicle turns, and when it stands still."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.records import Array, Stream
from robustnav.units import DEG, DPS

MOVING = 10 * DPS  # rad/s, a sample faster than this counts as motion
SWEPT_ENOUGH = 10 * DEG  # rad, an axis that swept less cannot be judged
PEAK_ENOUGH = 5 * DPS  # rad/s over half a second: a drifting integral alone is no rotation
QUIET_SPAN = 2.0  # s, length of the quietest window


@dataclass(frozen=True)
class Motion:
    """Rotation seen by the gyro, per axis.

    ``swept_deg`` range of the integrated rate less its median; ``rms_dps``, ``largest_dps``; ``peak_dps`` the largest
    half-second mean less the median; ``moving_share`` of samples above 10 deg/s, between ``moving_from_s`` and
    ``moving_to_s``; ``quiet_*`` the two seconds with the least gyro noise: start, mean rate (the bias if the vehicle
    stands) and standard deviation.
    """

    swept_deg: Array
    rms_dps: Array
    largest_dps: Array
    peak_dps: float
    moving_share: float
    moving_from_s: float
    moving_to_s: float
    quiet_at_s: float
    quiet_mean_dps: Array
    quiet_sd_dps: Array

    @property
    def unchecked(self) -> tuple[str, ...]:
        """Names of the axes that swept too little to be judged."""
        return tuple(name for name, swept in zip("xyz", self.swept_deg, strict=True) if swept * DEG < SWEPT_ENOUGH)

    @property
    def enough(self) -> bool:
        """Whether axes, scale and lag can be judged: two axes swept ten degrees, at a real rate."""
        return len(self.unchecked) <= 1 and self.peak_dps * DPS >= PEAK_ENOUGH


def whole_rows(stream: Stream) -> tuple[Array, Array]:
    """Return times (n,) and values (n, m) of the rows without a missing number."""
    keep = np.isfinite(stream.values).all(axis=1)
    return stream.t[keep], stream.values[keep]


def running_integral(t: Array, rate: Array) -> Array:
    """Return the trapezoid integral (n, m) of ``rate`` (n, m) over ``t`` (n,), zero at the first row."""
    out = np.zeros_like(rate)
    np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(t)[:, None], axis=0, out=out[1:])
    return out


def motion(gyro: Stream) -> Motion | None:
    """Return what the gyro [rad/s] (n, 3) says of the motion, or None with fewer than two whole rows or no time."""
    t, rate = whole_rows(gyro)
    if len(t) < 2 or t[-1] <= t[0]:
        return None
    angle = running_integral(t, rate - np.median(rate, axis=0))
    moving = np.flatnonzero(np.linalg.norm(rate, axis=1) > MOVING)
    first, last = (t[moving[0]], t[moving[-1]]) if moving.size else (np.nan, np.nan)
    start, mean, sd = _quietest(t, rate)
    return Motion(
        swept_deg=np.ptp(angle, axis=0) / DEG,
        rms_dps=np.sqrt(np.mean(rate**2, axis=0)) / DPS,
        largest_dps=np.abs(rate).max(axis=0) / DPS,
        peak_dps=_peak(t, angle) / DPS,
        moving_share=moving.size / len(t),
        moving_from_s=float(first),
        moving_to_s=float(last),
        quiet_at_s=start,
        quiet_mean_dps=mean / DPS,
        quiet_sd_dps=sd / DPS,
    )


def _peak(t: Array, angle: Array) -> float:
    """Return the largest mean rate [rad/s] over half a second, or over one interval where that is longer."""
    later = np.minimum(np.searchsorted(t, t + 0.5), len(t) - 1)
    span = t[later] - t
    whole = span >= min(0.5, t[-1] - t[0])
    return float(np.max(np.linalg.norm(angle[later] - angle, axis=1)[whole] / span[whole], initial=0.0))


def _quietest(t: Array, rate: Array) -> tuple[float, Array, Array]:
    """Return start [s], mean and standard deviation (3,) of the window of ``QUIET_SPAN`` with the least variance."""
    dt = np.diff(t)
    rows = int(np.clip(np.round(QUIET_SPAN / np.median(dt[dt > 0])), 2, len(t)))
    starts = np.arange(0, len(t) - rows + 1, max(1, rows // 5))
    # Running sums about the median: a constant offset would cost the variance its digits.
    about = rate - np.median(rate, axis=0)
    sums = np.vstack([np.zeros((1, 3)), np.cumsum(about, axis=0)])
    squares = np.vstack([np.zeros((1, 3)), np.cumsum(about**2, axis=0)])
    mean = (sums[starts + rows] - sums[starts]) / rows
    variance = (squares[starts + rows] - squares[starts]) / rows - mean**2
    best = int(starts[np.argmin(variance.sum(axis=1))])
    window = rate[best : best + rows]
    return float(t[best]), window.mean(axis=0), window.std(axis=0)
