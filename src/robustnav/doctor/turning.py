"""A, S, L: the gyro against the rate of a recorded attitude."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.doctor.axes import AxisMatch, match_axes
from robustnav.doctor.motion import running_integral, whole_rows
from robustnav.frames import quat_conjugate, quat_multiply, rotvec_from_quat
from robustnav.records import Array, Stream, Truth
from robustnav.units import MS

LAG_RANGE = 100  # ms
LAG_ROWS = 4000  # intervals the lag is searched on; more would not change it and would cost time
FEW = 10  # intervals below which nothing is said


@dataclass(frozen=True)
class Rates:
    """Mean rates between attitude stamps ``start`` and ``stop`` (n,) [s]: by attitude and by gyro (n, 3) [rad/s]."""

    start: Array
    stop: Array
    attitude: Array
    gyro: Array


@dataclass(frozen=True)
class Turning:
    """Gyro against attitude.

    ``axes``; ``scale`` k = sum w.g / sum g.g of attitude rate w and gyro g; ``size`` ratio of their root sums of
    squares, blind to axes; ``lag_ms`` of the attitude behind the gyro, NaN at the edge of the search;
    ``share_at_lag`` and ``scale_at_lag`` with the gyro shifted by it; ``conjugated``, ``reordered`` the share were
    the quaternion inverted, or in the other order of numbers.
    """

    axes: AxisMatch
    scale: float
    size: float
    lag_ms: float
    share_at_lag: float
    scale_at_lag: float
    conjugated: float
    reordered: float


def interval_rates(gyro: Stream, t: Array, q_nb: Array, longest: float = 3.0) -> Rates:
    """Return the mean rates over the intervals of the stamps ``t`` (n,) of an attitude ``q_nb`` (n, 4).

    Intervals outside the gyro's span, of zero length, of ``longest`` medians or more, and those with a missing
    attitude are left out.
    """
    keep = np.isfinite(q_nb).all(axis=1)
    t, q_nb = t[keep], q_nb[keep]
    gyro_t, rate = whole_rows(gyro)
    dt = np.diff(t)
    use = dt > 0
    if use.any():
        use &= dt < longest * np.median(dt[use])
    if len(gyro_t):
        use &= (t[:-1] >= gyro_t[0]) & (t[1:] <= gyro_t[-1])
    else:
        use[:] = False
    turned = rotvec_from_quat(quat_multiply(quat_conjugate(q_nb[:-1][use]), q_nb[1:][use]))
    start, stop = t[:-1][use], t[1:][use]
    attitude = turned / (stop - start)[:, None]
    if not len(start):
        return Rates(start, stop, attitude, attitude)
    return Rates(start, stop, attitude, mean_rate(gyro_t, running_integral(gyro_t, rate), start, stop))


def mean_rate(t: Array, angle: Array, start: Array, stop: Array) -> Array:
    """Return the mean rate (k, 3) over intervals from the integrated ``angle`` (n, 3) at ``t`` (n,)."""
    rise = [np.interp(stop, t, a) - np.interp(start, t, a) for a in angle.T]
    out: Array = np.stack(rise, axis=1) / (stop - start)[:, None]
    return out


def explained(w: Array, g: Array, M: Array | None = None) -> float:
    """Return the share 1 - sum |w - M g|^2 / sum |w|^2 of the rates ``w`` (n, 3) that ``g`` (n, 3) explains."""
    total = float(np.sum(w * w))
    residual = w - (g if M is None else g @ M.T)
    return 1 - float(np.sum(residual * residual)) / total if total > 0 else float("nan")


def turning(gyro: Stream, truth: Truth) -> Turning | None:
    """Return how a recorded attitude and the gyro fit, or None without enough common intervals."""
    if truth.q_nb is None:
        return None
    rates = interval_rates(gyro, truth.t, truth.q_nb)
    w, g = rates.attitude, rates.gyro
    ww, gg = float(np.sum(w * w)), float(np.sum(g * g))
    if len(w) < FEW or ww == 0 or gg == 0:
        return None
    size = float(np.sqrt(ww / gg))
    # In a wrong unit the search over axes means nothing, so there the gyro is brought to the attitude's size.
    factor = size if not 0.5 < size < 2 else 1.0
    lag = _lag(gyro, rates, factor)
    shifted = _shifted(gyro, rates, 0.0 if np.isnan(lag) else lag * MS)
    orders = [np.roll(truth.q_nb, shift, axis=1) for shift in (1, -1)]
    return Turning(
        axes=_match(w, g * factor),
        scale=float(np.sum(w * g)) / gg,
        size=size,
        lag_ms=lag,
        share_at_lag=explained(w, shifted * factor),
        scale_at_lag=float(np.sum(w * shifted) / np.sum(shifted * shifted)),
        conjugated=_share_if(gyro, truth.t, quat_conjugate(truth.q_nb), factor),
        reordered=max(_share_if(gyro, truth.t, q, factor) for q in orders),
    )


def _match(w: Array, g: Array) -> AxisMatch:
    """Return the axes of ``g`` (n, 3) that fit ``w`` (n, 3), through their 3 by 3 sums only."""
    cross, ww, gg = w.T @ g, float(np.sum(w * w)), float(np.sum(g * g))
    return match_axes(lambda M: float(1 - (ww + gg - 2 * np.sum(M * cross)) / ww))


def _share_if(gyro: Stream, t: Array, q_nb: Array, factor: float) -> float:
    """Return the share explained were the attitude ``q_nb`` (n, 4)."""
    rates = interval_rates(gyro, t, q_nb)
    return explained(rates.attitude, rates.gyro * factor)


def _shifted(gyro: Stream, rates: Rates, lag: float) -> Array:
    """Return the gyro's mean rates (n, 3) over the intervals moved ``lag`` [s] into the past."""
    t, rate = whole_rows(gyro)
    return mean_rate(t, running_integral(t, rate), rates.start - lag, rates.stop - lag)


def _lag(gyro: Stream, rates: Rates, factor: float) -> float:
    """Return how far the attitude is behind the gyro [ms], whole milliseconds, or NaN at the edge of the search."""
    t, rate = whole_rows(gyro)
    angle = running_integral(t, rate) * factor
    inside = np.flatnonzero((rates.start - t[0] > LAG_RANGE * MS) & (t[-1] - rates.stop > LAG_RANGE * MS))
    if len(inside) < FEW:
        return float("nan")
    # Rows at rest do not care about the lag: the fastest decide, at most LAG_ROWS of them.
    speed = np.linalg.norm(rates.attitude[inside], axis=1)
    rows = np.sort(inside[np.argsort(speed)[-LAG_ROWS:]])
    start, stop, w = rates.start[rows], rates.stop[rows], rates.attitude[rows]

    def misfit(lag_ms: int) -> float:
        return float(np.sum((w - mean_rate(t, angle, start - lag_ms * MS, stop - lag_ms * MS)) ** 2))

    coarse = min(range(-LAG_RANGE, LAG_RANGE + 1, 10), key=misfit)
    best = min(range(coarse - 10, coarse + 11), key=misfit)
    return float(best) if abs(best) < LAG_RANGE else float("nan")
