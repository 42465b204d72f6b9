"""V: the gyro against the directions of gravity and field, without any attitude."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robustnav.doctor.axes import AxisMatch, match_axes
from robustnav.doctor.motion import running_integral, whole_rows
from robustnav.records import Array, Stream

WINDOW = 0.2  # s
MOST_WINDOWS = 100  # for each gyro sample: beyond, the stamps are wild and nearly all windows empty
FEW = 10  # window pairs below which nothing is said


@dataclass(frozen=True)
class VectorMatch:
    """Gyro against directions: its ``axes``, and ``scale``, the factor on its angles that fits best."""

    axes: AxisMatch
    scale: float


def match_vectors(gyro: Stream, vectors: Sequence[Stream]) -> VectorMatch | None:
    """Return which axes of the gyro explain how the directions of ``vectors`` turn, or None with too few windows.

    A direction u fixed in the world moves in body axes by ``-theta x u`` while the body turns by theta; over windows
    of 0.2 s the share explained is ``1 - sum |du + (M theta) x u|^2 / sum |du|^2``.
    """
    steps = [_steps(gyro, vector) for vector in vectors]
    if not steps:
        return None
    du, theta, u = (np.concatenate([step[k] for step in steps]) for k in range(3))
    total = float(np.sum(du * du))
    seen = np.cross(u, theta)  # -theta x u, what the gyro says du is
    if len(du) < FEW or total == 0 or not seen.any():
        return None
    factor = float(np.sqrt(total / np.sum(seen * seen)))
    # In a wrong unit the search over axes means nothing, so there the gyro is brought to the size of what is seen.
    angle = theta * (factor if not 0.2 < factor < 5 else 1.0)

    def share_of(M: Array) -> float:
        residual = du - np.cross(u, angle @ M.T)
        return 1 - float(np.sum(residual * residual)) / total

    return VectorMatch(match_axes(share_of), float(np.sum(du * seen) / np.sum(seen * seen)))


def _steps(gyro: Stream, vector: Stream) -> tuple[Array, Array, Array]:
    """Return direction changes, angles turned and mean directions (k, 3) between neighbouring windows."""
    t, rate = whole_rows(gyro)
    tv, v = whole_rows(vector)
    empty = np.zeros((0, 3))
    if len(t) < 2 or len(tv) < 2:
        return empty, empty, empty
    start, stop = max(t[0], tv[0]), min(t[-1], tv[-1])
    windows = (stop - start) / WINDOW
    if not 2 <= windows <= MOST_WINDOWS * len(t):
        return empty, empty, empty
    count = int(windows)
    angle = _window_means(t, running_integral(t, rate), start, count)
    u = _window_means(tv, v, start, count)
    with np.errstate(invalid="ignore"):
        u = u / np.linalg.norm(u, axis=1, keepdims=True)
    du, theta, middle = np.diff(u, axis=0), np.diff(angle, axis=0), 0.5 * (u[1:] + u[:-1])
    whole = np.isfinite(du).all(axis=1) & np.isfinite(theta).all(axis=1)
    return du[whole], theta[whole], middle[whole]


def _window_means(t: Array, values: Array, start: float, count: int) -> Array:
    """Return the means (count, m) of ``values`` over consecutive windows; NaN where one is empty."""
    index = np.floor((t - start) / WINDOW).astype(int)
    inside = (index >= 0) & (index < count)
    rows = np.bincount(index[inside], minlength=count)
    sums = np.stack([np.bincount(index[inside], column[inside], minlength=count) for column in values.T], axis=1)
    out: Array = np.where(rows[:, None] > 0, sums / np.maximum(rows, 1)[:, None], np.nan)
    return out
