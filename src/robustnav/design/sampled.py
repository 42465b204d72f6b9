"""A sampled linear system as a gain schedule sees it: one tick of dynamics, and which sensors speak at which tick."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from math import lcm

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robustnav.design.flow import LyapunovMap, RiccatiMap, Visit
from robustnav.design.matrices import covariance, matrix, symmetric
from robustnav.errors import InputError
from robustnav.records import Array

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


class SampledSystem:
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

    def turned(self, P: Array, turning: Turning | None) -> SampledSystem:
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

    def optimal_posterior(self, phase: int, P: Array) -> Array:
        """Return the posterior (n, n) of the prior P at a phase with the optimal gain."""
        mask = int(self.masks[phase])
        return self.update(self.gain(P, mask))(P) if mask else P
