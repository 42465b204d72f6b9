"""Constant gains for a sampled filter: the periodic steady state, and a start-up schedule of gain sets before it.

Where dynamics and outputs do not depend on the path, the whole Kalman gain sequence is known before the data.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from itertools import pairwise
from math import lcm

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robustnav.design.certificates import Certificate, residual_reasons
from robustnav.design.flow import LyapunovMap, PeriodicFlow, RiccatiMap, Visit
from robustnav.design.matrices import covariance, covariance_difference, matrix, modes, symmetric
from robustnav.errors import InputError
from robustnav.records import Array

_SETTLED = 0.02  # largest relative distance of a covariance from the steady state at which the last set takes over
_MAX_SENSORS = 8
_MAX_PERIOD = 20_000  # ticks


@dataclass(frozen=True)
class SensorRows:
    """One sensor as the observer sees it at the nominal point.

    Parameters
    ----------
    name : sensor name.
    H : (m, n) output rows.
    variance : of one row of one sample, in the output's unit squared.
    every : ticks from one sample to the next; the first is at tick 0.
    """

    name: str
    H: Array
    variance: float
    every: int = 1

    def __post_init__(self) -> None:
        object.__setattr__(self, "H", matrix(self.H, (-1, -1), f"rows H of sensor {self.name!r}"))
        if not 0 < self.variance < np.inf:
            got = str(self.variance)
            raise InputError(f"variance of sensor {self.name!r}", got=got, expected="a finite number above zero")
        if self.every != int(self.every) or self.every < 1:
            raise InputError(f"sensor {self.name!r}: every", got=str(self.every), expected="a whole number of ticks")


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
class Turning:
    """Vectors of the state that the carrier swings through the design's axes, at rates the design does not know.

    White turn rates of two-sided density ``intensity`` about every axis make the covariance P of such a vector
    forget its direction, never its size: P' = intensity (tr(P) I - 3 P) (an isotropic random rotation).  As two
    linear parts: the vector decays at the rate ``intensity``, and noise intensity (tr(P) I - P) comes in.

    Parameters
    ----------
    vectors : where each vector lies in the state, three numbers each.
    intensity : [rad^2/s]; a turn rate of standard deviation s and correlation time tau has 2 s^2 tau.
    """

    vectors: tuple[slice, ...]
    intensity: float

    def __post_init__(self) -> None:
        if not 0 <= self.intensity < np.inf:
            got = f"{self.intensity} rad^2/s"
            raise InputError("intensity of turning", got=got, expected="a finite number of at least zero")


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
    system = _System(F, Q, sensors, dt)
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


class _System:
    """Dynamics and sensors of one design, checked, with the sensors present at each phase of the period."""

    def __init__(self, F: ArrayLike, Q: ArrayLike, sensors: Sequence[SensorRows], dt: float) -> None:
        self.n = n = len(np.atleast_1d(np.asarray(F, float)))
        self.F = matrix(F, (n, n), "transition F")
        self.Q = covariance(Q, n, "process noise Q")
        if not 0 < dt < np.inf:
            raise InputError("tick dt", got=f"{dt} s", expected="a finite number above zero")
        if not 1 <= len(sensors) <= _MAX_SENSORS:
            raise InputError("sensors", got=str(len(sensors)), expected=f"1 to {_MAX_SENSORS}")
        for sensor in sensors:
            matrix(sensor.H, (-1, n), f"rows H of sensor {sensor.name!r}")
        self.dt = dt
        self.sensors = tuple(sensors)
        self.period = lcm(*(int(sensor.every) for sensor in sensors))
        if self.period > _MAX_PERIOD:
            got = f"{self.period} ticks until the sensors' rates repeat"
            raise InputError("sensor rates", got=got, expected=f"at most {_MAX_PERIOD}", do="round `every`")
        self.H = np.vstack([sensor.H for sensor in sensors])
        self.variance = np.concatenate([np.full(len(sensor.H), sensor.variance) for sensor in sensors])
        self.owner = np.concatenate([np.full(len(sensor.H), j) for j, sensor in enumerate(sensors)])
        ticks = np.arange(self.period)
        self.masks = sum((ticks % sensor.every == 0).astype(int) << j for j, sensor in enumerate(sensors))

    def rows(self, mask: int) -> NDArray[np.intp]:
        """Return the indices of the rows of the sensors in ``mask``."""
        return np.flatnonzero(mask >> self.owner & 1)

    def turned(self, P: Array, turning: Turning | None) -> _System:
        """Return the system as it is near the covariance P (n, n) when its vectors turn."""
        out = copy(self)
        if turning is not None and turning.intensity > 0:
            out.F, out.Q = self.F.copy(), self.Q.copy()
            share = turning.intensity * self.dt
            for part in turning.vectors:
                out.F[part, part] *= 1 - share
                out.Q[part, part] += share * (np.trace(P[part, part]) * np.eye(3) - P[part, part])
        return out

    def optimal(self) -> list[RiccatiMap]:
        """Return the optimal prior-to-prior map of each phase."""
        return [self.riccati(mask) for mask in self.masks]

    def riccati(self, mask: int) -> RiccatiMap:
        """Return the optimal map of a tick with the sensors in ``mask``."""
        rows = self.rows(mask)
        H = self.H[rows]
        return RiccatiMap(self.F, H.T @ (H / self.variance[rows, None]), self.Q)

    def gain(self, P: Array, mask: int) -> Array:
        """Return the Kalman gain (n, m_total) for the prior P (n, n), zero for sensors absent from ``mask``."""
        rows = self.rows(mask)
        H = self.H[rows]
        out = np.zeros((self.n, len(self.H)))
        out[:, rows] = np.linalg.solve(H @ P @ H.T + np.diag(self.variance[rows]), H @ P).T
        return out

    def gains(self, seen: Visit) -> Array:
        """Return the gains (2**k - 1, n, m_total) for the mean priors of a visit."""
        present = self.masks[seen.phases]
        return np.array(
            [
                self.gain(seen.mean(where=present == mask if np.any(present == mask) else None), mask)
                for mask in range(1, 2 ** len(self.sensors))
            ]
        )

    def update(self, K: Array) -> LyapunovMap:
        """Return the map from prior to posterior with the held gain K (n, m_total)."""
        return LyapunovMap(np.eye(self.n) - K @ self.H, symmetric(K * self.variance @ K.T))

    def _phase_gain(self, gains: Array, phase: int) -> Array:
        mask = self.masks[phase]
        return gains[mask - 1] if mask else np.zeros((self.n, len(self.H)))

    def held(self, gains: Array) -> list[LyapunovMap]:
        """Return the prior-to-prior map of each phase with held gains."""
        predict = LyapunovMap(self.F, self.Q)
        return [self.update(self._phase_gain(gains, phase)).then(predict) for phase in range(self.period)]

    def posteriors(self, gains: Array, seen: Visit) -> Array:
        """Return the posterior (k, n, n) of every visited prior with held gains."""
        pairs = zip(seen.phases, seen.priors, strict=True)
        return np.array([self.update(self._phase_gain(gains, phase))(P) for phase, P in pairs])


def _certify(
    system: _System, optimum: PeriodicFlow[RiccatiMap], seen: Visit, gains: Array
) -> tuple[Certificate, Array]:
    """Return the certificate of held steady gains and their mean posterior (n, n), by propagating the true error."""
    pairs = zip(seen.phases, seen.priors, strict=True)
    best = seen.mean(np.array([_posterior(system, int(phase), P) for phase, P in pairs]))
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


def _posterior(system: _System, phase: int, P: Array) -> Array:
    """Return the optimal posterior (n, n) at a phase."""
    mask = int(system.masks[phase])
    return system.update(system.gain(P, mask))(P) if mask else P


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
