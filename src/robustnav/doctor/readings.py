"""Q, F, B: the readings of one sensor by themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.records import Array, Stream

SATURATED_RUN = 3  # equal extremes in a row, other axes still changing, before a range limit is suspected


@dataclass(frozen=True)
class Readings:
    """Readings of one stream in its own unit.

    ``missing`` rows hold a NaN; ``held`` rows repeat the row before; ``constant`` and ``limited`` list the axes that
    never change, or that stand at their own extreme for several samples while the others move; ``limit`` is the
    largest of those extremes.
    """

    missing: int
    held: int
    constant: tuple[int, ...]
    limited: tuple[int, ...]
    limit: float
    mean: Array
    norm_median: float
    norm_mean: float
    norm_sd: float


def readings(stream: Stream) -> Readings:
    """Return the figures of a stream's readings; NaN when every row is missing."""
    v = stream.values
    good = v[np.isfinite(v).all(axis=1)]
    nan = float("nan")
    if not len(good):
        return Readings(len(v), 0, (), (), nan, np.full(v.shape[1], nan), nan, nan, nan)
    norm = np.linalg.norm(good, axis=1)
    changed = (good[1:] != good[:-1]).any(axis=1)
    limited = tuple(axis for axis in range(good.shape[1]) if _stands_at_extreme(good[:, axis], changed))
    return Readings(
        missing=len(v) - len(good),
        held=int(np.sum(~changed)),
        constant=tuple(int(k) for k in np.flatnonzero(np.ptp(good, axis=0) == 0)) if len(good) > 1 else (),
        limited=limited,
        limit=float(np.abs(good[:, list(limited)]).max()) if limited else nan,
        mean=good.mean(axis=0),
        norm_median=float(np.median(norm)),
        norm_mean=float(norm.mean()),
        norm_sd=float(norm.std()),
    )


def _stands_at_extreme(x: Array, changed: Array) -> bool:
    """Say whether ``x`` (n,) keeps its extreme for ``SATURATED_RUN`` samples while rows are ``changed`` (n - 1,)."""
    size = np.abs(x)
    top = size == size.max()
    held = top[1:] & top[:-1] & (x[1:] == x[:-1]) & changed
    need = SATURATED_RUN - 1
    return len(held) >= need and bool(np.convolve(held, np.ones(need), "valid").max() >= need)
