"""The start without a prior: which way is down, where velocity starts, and which readings are gusts."""

from __future__ import annotations

import numpy as np

from robustnav.frames import Array, quat_from_rotvec, quat_multiply, quat_normalize, rotate
from robustnav.records import BoolArray

GUST_FACTOR = 4.0  # times the usual distance from the median
GUST_LEAST = 6.0  # times the reference's noise


def level_attitude(readings: Array, gyro_bias: Array | None = None) -> Array:
    """Return the attitude ``q`` (4,), body to wander frame at the first row, that makes mean specific force point up.

    Parameters
    ----------
    readings : (n, 30) rows; the slope of the summed specific force is that of gravity as far as the base stays put.
    gyro_bias : (3,) [rad/s], taken off the rows; None takes nothing.
    """
    bias = np.zeros(3) if gyro_bias is None else gyro_bias
    q, total = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros((len(readings) + 1, 3))
    for k, row in enumerate(readings):
        J, H = row[7:16].reshape(3, 3), row[16:25].reshape(3, 3)
        total[k + 1] = total[k] + rotate(q, row[4:7] - H @ bias)
        q = quat_normalize(quat_multiply(quat_multiply(q, quat_from_rotvec(-J @ bias)), row[:4]))
    lever = np.arange(len(total)) - 0.5 * len(readings)
    slope = lever @ total
    down = -slope / np.linalg.norm(slope)
    out = np.array([1 + down[2], down[1], -down[0], 0.0])
    length = float(np.linalg.norm(out))
    # Upside down any level axis will do.
    return out / length if length >= 1e-3 else np.array([0.0, 1.0, 0.0, 0.0])


def missing(z: Array) -> BoolArray:
    """Return which readings (..., 2) are not there."""
    return np.asarray(np.isnan(z).any(axis=-1))


def first_velocity(z: Array) -> Array:
    """Return the median (2,) of the first five reference velocities (n, 2) [m/s] that are there."""
    return _median(z[:5])


def oddness(z: Array) -> Array:
    """Return how far each reading (n, 2) is from the median of the five around it (n,) [m/s]; inf where missing."""
    out = np.full(len(z), np.inf)
    for k in np.flatnonzero(~missing(z)):
        out[k] = np.abs(z[k] - _median(z[max(k - 2, 0) : k + 3])).max()
    return out


def odd_limit(odd: Array, reference_sd: float) -> float:
    """Return the oddness [m/s] beyond which a reading is a gust: a multiple of the mean, taken twice."""
    limit = np.inf
    for _ in range(2):
        kept = odd[odd < limit]
        if kept.size:
            limit = GUST_FACTOR * float(kept.mean())
    least = GUST_LEAST * reference_sd
    return max(limit, least) if limit < np.inf else least


def _median(z: Array) -> Array:
    """Median of the rows that are there, the upper one of an even number; 0 if there is none."""
    kept = np.sort(z[~missing(z)], axis=0)
    out: Array = kept[len(kept) // 2] if len(kept) else np.zeros(2)
    return out
