"""Numbers from many independent runs: how large the errors are, how sure that is, and how soon they are small."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.errors import InputError
from robustnav.records import Array, check_time
from robustnav.units import DEG

RESAMPLES = 1000


@dataclass(frozen=True)
class MonteCarlo:
    """Errors over independent runs, per axis in the order given and for the norm of the three.

    Parameters
    ----------
    rms_deg, low_deg, high_deg : (3,) root mean square over runs and times and its confidence interval.
    min_deg, max_deg : (3,) extreme errors.
    total_deg, total_low_deg, total_high_deg : the same rms and interval for the norm of the three axes.
    settle_s : (runs,) time from the start after which the norm stays within ``settle_deg``; NaN where it never does.
    settle_deg, confidence : as asked.
    runs, failed : number of runs, and of those with a NaN error, which make the figures NaN.
    """

    rms_deg: Array
    low_deg: Array
    high_deg: Array
    min_deg: Array
    max_deg: Array
    total_deg: float
    total_low_deg: float
    total_high_deg: float
    settle_s: Array
    settle_deg: float
    confidence: float
    runs: int
    failed: int


def monte_carlo(
    t: Array, errors: Array, *, settle_deg: float = 1.0, confidence: float = 0.95, seed: int = 0
) -> MonteCarlo:
    """Return the error figures of independent runs with bootstrap intervals.

    Whole runs are resampled, as the errors within one run are correlated in time (Efron, Tibshirani, An Introduction
    to the Bootstrap, 1993, section 13.3, percentile interval).  The interval needs some tens of runs to be honest.

    Parameters
    ----------
    t : (n,) times [s], the same for all runs.
    errors : (runs, n, 3) attitude errors [rad].
    settle_deg : limit of the settle time.
    confidence : probability of the intervals.
    seed : of the resampling; equal seeds give equal figures.

    Raises
    ------
    InputError : shapes differ, fewer than two runs, or no times.
    """
    check_time(t, "Monte Carlo runs")
    if errors.shape[1:] != (len(t), 3) or len(errors) < 2 or not len(t):
        raise InputError(
            "Monte Carlo errors",
            got=f"shape {errors.shape} with {len(t)} times",
            expected=f"shape (runs, {len(t)}, 3), two runs or more",
        )
    norm = np.linalg.norm(errors, axis=2)
    squares = np.mean(np.concatenate([errors, norm[..., None]], axis=2) ** 2, axis=1) / DEG**2
    low, high = _bootstrap_rms(squares, confidence, seed)
    rms = np.sqrt(squares.mean(axis=0))
    return MonteCarlo(
        rms_deg=rms[:3],
        low_deg=low[:3],
        high_deg=high[:3],
        min_deg=errors.min(axis=(0, 1)) / DEG,
        max_deg=errors.max(axis=(0, 1)) / DEG,
        total_deg=float(rms[3]),
        total_low_deg=float(low[3]),
        total_high_deg=float(high[3]),
        settle_s=settle_time(t, norm, settle_deg * DEG),
        settle_deg=settle_deg,
        confidence=confidence,
        runs=len(errors),
        failed=int(np.isnan(errors).any(axis=(1, 2)).sum()),
    )


def settle_time(t: Array, error: Array, limit: float) -> Array:
    """Return the time after the first one from which each error stays within a limit.

    Parameters
    ----------
    t : (n,) times [s].
    error : (runs, n) size of the error, any unit; NaN counts as outside.
    limit : largest size that counts as settled, same unit.

    Returns
    -------
    (runs,) seconds since ``t[0]``: zero if always within, NaN if the last sample is outside.
    """
    outside = ~(np.abs(error) <= limit)
    first_settled = error.shape[1] - np.argmax(outside[:, ::-1], axis=1)
    first_settled[~outside.any(axis=1)] = 0
    since_start = np.append(t - t[0], np.nan)
    out: Array = since_start[first_settled]
    return out


def _bootstrap_rms(squares: Array, confidence: float, seed: int) -> tuple[Array, Array]:
    """Percentile interval of sqrt(mean over runs) for mean squares (runs, k)."""
    rng = np.random.default_rng(seed)
    runs = len(squares)
    means = np.array([squares[rng.integers(0, runs, runs)].mean(axis=0) for _ in range(RESAMPLES)])
    tail = 50 * (1 - confidence)
    low, high = np.sqrt(np.percentile(means, [tail, 100 - tail], axis=0))
    return low, high
