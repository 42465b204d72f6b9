"""Constant gains for a sampled filter: the periodic steady state, and a start-up schedule of gain sets before it.

Where dynamics and outputs do not depend on the path, the whole Kalman gain sequence is known before the data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from robustnav.design.certificates import Certificate, residual_reasons
from robustnav.design.flow import PeriodicFlow, RiccatiMap, Visit
from robustnav.design.matrices import covariance, covariance_difference, modes
from robustnav.design.sampled import SampledSystem, SensorRows, Turning
from robustnav.errors import InputError
from robustnav.records import Array

__all__ = ["GainTable", "SensorRows", "Startup", "Turning", "gain_table"]

_SETTLED = 0.02  # largest relative distance of a covariance from the steady state at which the last set takes over


@dataclass(frozen=True)
class GainTable:
    """Gains by time since start and by which sensors are present.

    Parameters
    ----------
    dt : tick [s].
    times : (s,) start of each set since the filter's start [s]; the first is 0, later ones lie half a tick before
        the set's first tick, so that rounding in a time stamp cannot pick the wrong set.
    gains : (s, 2**k - 1, n, m_total); ``gains[i, mask - 1]`` is for the sensors whose bits are set in ``mask`` (bit j
        for sensor j), columns in sensor order, zero for absent sensors.  Correction: x += K (y - H x).
    covariance : (s, n, n) posterior covariance with these held gains, averaged over the set's ticks.
    certificate : of the steady state, the last set.  ``ratio`` is the price of holding one gain per subset.
    """

    dt: float
    times: Array
    gains: Array
    covariance: Array
    certificate: Certificate


@dataclass(frozen=True)
class Startup:
    """What a start-up schedule is designed for.

    Parameters
    ----------
    P0 : (n, n) covariance of the start error, the prior at tick 0.
    sets : number of gain sets; fewer come back if the filter settles in fewer ticks.
    turning : how the carrier may turn meanwhile, or None.
    """

    P0: ArrayLike
    sets: int = 32
    turning: Turning | None = None


def gain_table(
    F: ArrayLike, Q: ArrayLike, sensors: Sequence[SensorRows], dt: float, startup: Startup | None = None
) -> GainTable:
    """Design the gains of a constant-gain filter, with a start-up schedule if the start covariance is given.

    The filter corrects at tick 0 first, then propagates; sensor j has samples at ticks that ``every`` divides.  Each
    set serves from its tick until the next one's; sets are spread evenly over the logarithm of time.  A gain is the
    Kalman gain for the mean prior over those ticks of its interval at which its subset occurs (all ticks, for a subset
    that does not occur), where the prior starts from what the sets before really leave, not from the optimum.

    Parameters
    ----------
    F : (n, n) transition over one tick.
    Q : (n, n) process-noise covariance of one tick.
    sensors : at most 8.
    dt : tick [s].
    startup : None designs the steady state only.

    Raises
    ------
    InputError : shapes, signs, a covariance that is not one, too many sensors, a period above 20 000 ticks.
    EstimatorError : no steady state, or the certificate fails.

    References
    ----------
    Anderson, Moore, Optimal Filtering (1979), chapters 4 and 6; Bittanti, Colaneri, Periodic Systems (2009).
    """
    system = SampledSystem(F, Q, sensors, dt)
    optimum = PeriodicFlow(system.optimal())
    P_steady = optimum.fixed_point()
    seen, _ = optimum.visit(P_steady, 0, system.period)
    steady_gains = system.gains(seen)
    certificate, steady_covariance = _certify(system, optimum, seen, steady_gains)
    certificate.require("the gain table")
    starts = [0]
    gains, covariances = [], []
    if startup is not None:
        P = covariance(startup.P0, system.n, "start covariance P0")
        starts = _starts(_settling_ticks(optimum, P, P_steady), startup.sets, system.period)
        for start, stop in pairwise(starts):
            local = system.turned(P, startup.turning)
            held_gains = local.gains(PeriodicFlow(local.optimal()).visit(P, start, stop)[0])
            seen, P = PeriodicFlow(local.held(held_gains)).visit(P, start, stop)
            gains.append(held_gains)
            covariances.append(seen.mean(local.posteriors(held_gains, seen)))
    times = np.maximum(np.array(starts) - 0.5, 0.0) * dt
    return GainTable(
        dt, times, np.array([*gains, steady_gains]), np.array([*covariances, steady_covariance]), certificate
    )


def _certify(
    system: SampledSystem, optimum: PeriodicFlow[RiccatiMap], seen: Visit, gains: Array
) -> tuple[Certificate, Array]:
    """Return the certificate of held steady gains and their mean posterior (n, n), by propagating the true error."""
    pairs = zip(seen.phases, seen.priors, strict=True)
    best = seen.mean(np.array([system.optimal_posterior(int(phase), P) for phase, P in pairs]))
    promised = float(np.sqrt(np.trace(best)))
    residual = covariance_difference(optimum.over_period(seen.priors[0]), seen.priors[0])
    held = PeriodicFlow(system.held(gains))
    poles = modes(held.over_period.A)
    radius = float(np.abs(poles).max())
    if not radius < 1 - 1e-12:
        unstable = (f"stability: spectral radius {radius:.12g} over a period; a state without noise?",)
        return Certificate("periodic H2", promised, np.inf, residual, poles, 1 - radius, np.inf, unstable), best
    after, _ = held.visit(held.fixed_point(), 0, system.period)
    actual = after.mean(system.posteriors(gains, after))
    verified = float(np.sqrt(np.trace(actual)))
    reasons = residual_reasons(residual)
    if not verified >= promised * (1 - 1e-6):
        reasons += (f"norm: {verified:.6g} with held gains, below the optimum {promised:.6g}",)
    forgets = -system.period * system.dt / np.log(radius) if radius > 0 else 0.0
    return Certificate("periodic H2", promised, verified, residual, poles, 1 - radius, forgets, reasons), actual


def _settling_ticks(optimum: PeriodicFlow[RiccatiMap], P: Array, P_steady: Array) -> int:
    """Return the tick, a multiple of the period, from which the optimal prior stays near its steady state."""

    def settled(P_prior: Array) -> bool:
        return covariance_difference(P_prior, P_steady) < _SETTLED

    level = 0
    while not settled(optimum.jump(P, 1 << level)):
        level += 1
    periods = 0
    for k in reversed(range(level)):
        ahead = optimum.doubled(k)(P)
        if not settled(ahead):
            P, periods = ahead, periods + (1 << k)
    return (periods + 1) * optimum.period


def _starts(last: int, sets: int, period: int) -> list[int]:
    """Return at most ``sets`` first ticks, evenly spread over log time from 0 to ``last``; later ones whole periods."""
    if sets != int(sets) or sets < 2:
        raise InputError("number of gain sets", got=str(sets), expected="a whole number of at least 2")
    starts = [0]
    while starts[-1] < last:
        left = sets - len(starts)
        here = starts[-1]
        target = max(here + 1, round(max(here, 1) * (last / max(here, 1)) ** (1 / left))) if left > 1 else last
        if target > period:
            target = -(-target // period) * period
        starts.append(min(target, last))
    return starts
