"""Robust least squares over a whole recording: the most likely path, as a reference for whatever runs online.

The path minimises, over all its states, half the sum of squared start error, process noise of every step and readings,
each in its standard deviations, a reading's square entering through its rule (Huber 1964; Student-t: Lange, Little and
Taylor 1989).  Every pass linearises all of it at the path, turns rules into weights, and solves the normal equations,
which are block tridiagonal, by eliminating forwards and substituting back.  The elimination is in covariance form,
P = (information)^-1, so that steps without noise in some direction are no special case: Gauss-Newton as an iterated
Kalman smoother (Bell 1994).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from robustnav.errors import EstimatorError, InputError
from robustnav.filter.smoother import back
from robustnav.filter.weighting import Rule
from robustnav.frames import Array
from robustnav.model.functions import ModelFunctions
from robustnav.records import IntArray


@dataclass(frozen=True)
class Readings:
    """Finite readings ``z`` (m, width) of one sensor at rows ``row`` (m,) of the path, and their rule."""

    row: IntArray
    z: Array
    rule: Rule


@dataclass(frozen=True)
class Problem:
    """What is known of a path: steps ``dt`` (n,) > 0 [s] from the row before, inputs ``u`` (n, nu) held over them (of
    the first row, neither is used), the start ``x`` (nx,) with covariance ``P`` (ne, ne), readings by sensor.
    """

    dt: Array
    u: Array
    x: Array
    P: Array
    readings: tuple[Readings, ...]


@dataclass(frozen=True)
class Effort:
    """How long to go on.

    passes : at most.
    tolerance : done when no state is corrected by more than this many of its standard deviations.
    progress : called after every pass with its number and its largest correction in standard deviations.
    """

    passes: int = 15
    tolerance: float = 0.01
    progress: Callable[[int, float], None] = field(default=lambda number, step: None)

    def __post_init__(self) -> None:
        if not (self.passes >= 1 and self.tolerance > 0):
            got = f"{self.passes} passes, tolerance {self.tolerance}"
            raise InputError("batch", got=got, expected="at least one pass and a tolerance above zero")


@dataclass(frozen=True)
class Solution:
    """A path: states ``x`` (n, nx) with covariances ``P`` (n, ne, ne).

    ``residuals`` (m, rows) and ``weights`` (m,) are by sensor, of the readings on it.  ``step`` is the last pass's
    largest correction in standard deviations, after ``passes`` passes.
    """

    x: Array
    P: Array
    residuals: tuple[Array, ...]
    weights: tuple[Array, ...]
    passes: int
    step: float


def solve(model: ModelFunctions, problem: Problem, path: Array, effort: Effort) -> Solution:
    """Return the most likely path near a first guess.

    Parameters
    ----------
    model : the model's functions.
    problem : what is known.
    path : first guess (n, nx), as a smoother gives it.
    effort : how long to go on.

    Raises
    ------
    EstimatorError : a pass that gives a number that is not finite.
    """
    x = np.array(path, float)
    step, number = np.inf, 0
    while number < effort.passes and step > effort.tolerance:
        number += 1
        residuals, weights = weigh(model, problem, x)
        errors, P = _pass(model, problem, x, residuals, weights)
        if not (np.isfinite(errors).all() and np.isfinite(P).all()):
            raise EstimatorError("batch least squares diverged", place=f"pass {number}", do="give it a better start")
        sd = np.sqrt(np.diagonal(P, axis1=1, axis2=2))
        step = float(np.max(np.abs(errors) / np.where(sd > 0, sd, np.inf), initial=0.0))
        x = np.array([model.inject(one, e) for one, e in zip(x, errors, strict=True)])
        effort.progress(number, step)
    return Solution(x, P, *weigh(model, problem, x), number, step)


def weigh(model: ModelFunctions, problem: Problem, x: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Return by sensor the residuals (m, rows) of readings on a path, and what each counts for (m,)."""
    residuals, weights = [], []
    for j, (readings, variance) in enumerate(zip(problem.readings, model.model.variances, strict=True)):
        pairs = zip(readings.row, readings.z, strict=True)
        r = np.array([model.residual(j, x[k], z) for k, z in pairs]).reshape(-1, model.rows[j])
        rows = r.shape[1]
        residuals.append(r)
        weights.append(np.array([readings.rule.weight(float(one @ one) / variance, rows) for one in r]))
    return tuple(residuals), tuple(weights)


def _pass(
    model: ModelFunctions, problem: Problem, x: Array, residuals: tuple[Array, ...], weights: tuple[Array, ...]
) -> tuple[Array, Array]:
    """Return the errors (n, ne) of a path by everything linearised at it, and their covariances (n, ne, ne)."""
    seen = _rows(model, problem, x, residuals, weights)
    n = len(x)
    e, P = np.empty((n, len(problem.P))), np.empty((n, *problem.P.shape))
    moves: list[tuple[Array, Array, Array]] = []
    for k in range(n):
        if k == 0:
            e[0], P[0] = model.difference(problem.x, x[0]), problem.P
        else:
            dt, u = float(problem.dt[k]), problem.u[k]
            F, Q = model.transition(x[k - 1], u, dt)
            e[k] = F @ e[k - 1] + model.difference(model.propagate(x[k - 1], u, dt), x[k])
            P[k] = F @ P[k - 1] @ F.T + Q
            moves.append((F, Q, e[k].copy()))
        if seen[k]:
            _fuse(e[k], P[k], seen[k])
    for k in reversed(range(n - 1)):
        F, Q, e_pred = moves[k]
        G, P[k] = back(F, Q, P[k], P[k + 1])
        e[k] += G @ (e[k + 1] - e_pred)
    return e, P


Row = tuple[Array, Array, float]  # Jacobian (m, ne), residuals (m,), variance of each


def _rows(
    model: ModelFunctions, problem: Problem, x: Array, residuals: tuple[Array, ...], weights: tuple[Array, ...]
) -> list[list[Row]]:
    """Return what is read at each step of a path, linearised, its variance raised by its weight."""
    out: list[list[Row]] = [[] for _ in x]
    for j, (readings, variance) in enumerate(zip(problem.readings, model.model.variances, strict=True)):
        size = model.model.sensors[j].size
        for k, z, r, w in zip(readings.row, readings.z, residuals[j], weights[j], strict=True):
            if w > 0:
                out[k].append((model.jacobian(j, x[k], z[size:]), r, variance / w))
    return out


def _fuse(e: Array, P: Array, seen: list[Row]) -> None:
    """Update an error (ne,) and its covariance (ne, ne) in place."""
    H = np.vstack([one[0] for one in seen])
    R = np.concatenate([np.full(len(one[1]), one[2]) for one in seen])
    PH = P @ H.T
    S = H @ PH + np.diag(R)
    K = np.linalg.solve(S, PH.T).T
    e += K @ (np.concatenate([one[1] for one in seen]) - H @ e)
    left = np.eye(len(P)) - K @ H
    P[:] = left @ P @ left.T + (K * R) @ K.T
