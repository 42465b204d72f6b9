"""Covariances many ticks ahead without walking there: tick maps that compose, and double.

A predict-update pair maps one prior covariance to the next.  Both the optimal filter's map (Riccati) and a held gain's
(Lyapunov) are closed under composition, so a period is one map and 2^k periods cost k compositions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Generic, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from robustnav.design.matrices import covariance_difference, symmetric
from robustnav.errors import EstimatorError
from robustnav.records import Array, BoolArray

_CONVERGED = 1e-13
_MAX_DOUBLINGS = 48
_BEYOND_ANY_UNIT = 1e100
_WINDOWS = 5  # of one period, that stand for a long interval


class CovarianceMap(Protocol):
    """A map of covariances that composes with its like; ``offset`` (n, n) is its value at zero."""

    @property
    def offset(self) -> Array:
        """Value at zero."""
        ...

    def __call__(self, P: Array) -> Array:
        """Return the covariance P (n, n) is taken to."""
        ...

    def then(self, later: Self) -> Self:
        """Return the map that applies this one, then ``later``."""
        ...


@dataclass(frozen=True)
class RiccatiMap:
    """P -> offset + A P (I + G P)^-1 A': prior to prior with the optimal gain.

    For one tick A = F, G = H' R^-1 H and offset = Q.

    References
    ----------
    Chu, Fan, Lin, Wang, Int. J. Control 77 (2004) (structure-preserving doubling); Sarkka, Garcia-Fernandez, IEEE TAC
    66 (2021) (composition of filtering steps).
    """

    A: Array
    G: Array
    offset: Array

    def __call__(self, P: Array) -> Array:
        """Return the covariance P (n, n) is taken to."""
        seen = np.linalg.solve(np.eye(len(P)) + self.G @ P, self.A.T)
        return symmetric(self.offset + self.A @ P @ seen)

    def then(self, later: RiccatiMap) -> RiccatiMap:
        """Return the map that applies this one, then ``later``."""
        mixed = np.eye(len(self.A)) + self.offset @ later.G
        n = len(self.A)
        solved = np.linalg.solve(mixed, np.hstack([self.A, self.offset]))
        return RiccatiMap(
            later.A @ solved[:, :n],
            symmetric(self.G + self.A.T @ later.G @ solved[:, :n]),
            symmetric(later.offset + later.A @ solved[:, n:] @ later.A.T),
        )


@dataclass(frozen=True)
class LyapunovMap:
    """P -> offset + A P A': prior to prior with a held gain."""

    A: Array
    offset: Array

    def __call__(self, P: Array) -> Array:
        """Return the covariance P (n, n) is taken to."""
        return symmetric(self.offset + self.A @ P @ self.A.T)

    def then(self, later: LyapunovMap) -> LyapunovMap:
        """Return the map that applies this one, then ``later``."""
        return LyapunovMap(later.A @ self.A, later(self.offset))


M = TypeVar("M", bound=CovarianceMap)


@dataclass(frozen=True)
class Visit:
    """Priors seen at some ticks of an interval: ``phases`` (k,), ``priors`` (k, n, n), ``weights`` (k,) ticks each."""

    phases: NDArray[np.intp]
    priors: Array
    weights: Array

    def mean(self, covariances: Array | None = None, where: BoolArray | None = None) -> Array:
        """Return the time-average (n, n) of ``covariances`` (k, n, n), default the priors, over ticks ``where``."""
        values = self.priors if covariances is None else covariances
        weights = self.weights if where is None else self.weights * where
        return np.asarray(np.tensordot(weights / weights.sum(), values, axes=1))


class PeriodicFlow(Generic[M]):
    """Tick maps that repeat, one per phase of a period, and their powers (computed once, when first needed)."""

    def __init__(self, ticks: Sequence[M]) -> None:
        self.ticks = tuple(ticks)
        self.period = len(self.ticks)
        self._doubled: list[M] = [reduce(lambda first, later: first.then(later), self.ticks)]

    @property
    def over_period(self) -> M:
        """The map over one whole period, starting at phase 0."""
        return self._doubled[0]

    def doubled(self, k: int) -> M:
        """Return the map over 2^k periods."""
        while len(self._doubled) <= k:
            self._doubled.append(self._doubled[-1].then(self._doubled[-1]))
        return self._doubled[k]

    def jump(self, P: Array, periods: int) -> Array:
        """Return the prior covariance a number of periods after P (n, n) at phase 0."""
        for k in range(periods.bit_length()):
            if periods >> k & 1:
                P = self.doubled(k)(P)
        return P

    def fixed_point(self) -> Array:
        """Return the periodic steady-state prior (n, n) at phase 0, or raise ``EstimatorError`` if there is none."""
        growing, previous = 0, self.over_period.offset
        for k in range(1, _MAX_DOUBLINGS):
            P = self.doubled(k).offset
            if covariance_difference(previous, P) < _CONVERGED:
                return P
            before = np.diag(previous)
            growth = np.divide(np.diag(P), before, out=np.zeros(len(P)), where=before > 0)
            growing, previous = int(np.argmax(growth)), P
            if P.max() > _BEYOND_ANY_UNIT:  # the next doubling might overflow
                break
        raise EstimatorError(
            "the error covariance has no steady state",
            got=f"the variance of state {growing} keeps growing",
            expected="every state that does not decay visible to the sensors",
            do="add a sensor that sees this state, or take it out",
        )

    def visit(self, P: Array, start: int, stop: int) -> tuple[Visit, Array]:
        """Walk from the prior P (n, n) at tick ``start`` to ``stop``; return what was seen and the prior at ``stop``.

        Whole periods are sampled in at most five windows of one period, evenly spread; the rest is jumped over.
        ``stop`` is a multiple of the period or less than two periods after ``start``.
        """
        phases, priors, weights = [], [], []
        tick = start
        for skipped, ticks, weight in _plan(start, stop, self.period):
            P = self.jump(P, skipped)
            for _ in range(ticks):
                phases.append(tick % self.period)
                priors.append(P)
                weights.append(weight)
                P = self.ticks[tick % self.period](P)
                tick += 1
        return Visit(np.array(phases, np.intp), np.array(priors), np.array(weights)), P


def _plan(start: int, stop: int, period: int) -> list[tuple[int, int, float]]:
    """Return (periods to jump, then ticks to walk, weight of each of these ticks), in order."""
    aligned = -(-start // period) * period
    if stop < aligned + period:
        return [(0, stop - start, 1.0)]
    count = (stop - aligned) // period
    chosen = np.unique(np.linspace(0, count - 1, min(count, _WINDOWS)).round().astype(int))
    steps = np.diff(chosen, prepend=-1) - 1
    plan = [(0, aligned - start, 1.0)] if aligned > start else []
    return plan + [(int(step), period, count / len(chosen)) for step in steps]
