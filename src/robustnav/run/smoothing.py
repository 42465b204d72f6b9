"""Estimates that use the whole recording: the smoother behind a filter, and robust batch least squares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robustnav.engine.backends import RunningFilter
from robustnav.engine.filters import Output, SensorData, SensorSeen
from robustnav.engine.smoothing import smooth as smooth_rows
from robustnav.errors import InputError
from robustnav.filter.batch import Effort, Problem, Readings, Solution, solve
from robustnav.filter.steps import unpack
from robustnav.filter.weighting import Rule, StudentT
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.records import IntArray, Log, Run
from robustnav.run.estimators import EKF, UKF
from robustnav.run.feed import Feed, broken, deviations, events_of, feed_of, innovations_of, settings_of
from robustnav.run.loop import Start, stream

_MAX_GAP = 1.0  # a longer pause of the input [s] is named in the events


def smooth(estimator: EKF | UKF, log: Log, start: Start, *, backend: str = "auto") -> Run:
    """Run an estimator over a log and back: every state by all readings, later ones too.

    Readings keep the weights the filter gave them.  Rauch, Tung, Striebel (1965), on the error state.

    Parameters
    ----------
    estimator : ``EKF`` or ``UKF`` with its model.
    log, start, backend : as for ``run``.

    Returns
    -------
    Run : smoothed states and standard deviations at the times ``run`` reports, where an input is missing too;
        innovations of the filter on its way forward.

    Raises
    ------
    InputError : as for ``run``; another estimator, a constant gain for one; no input sample that is whole.
    EstimatorError : the filter's covariance broke.
    """
    if not isinstance(estimator, EKF | UKF):
        expected = "EKF or UKF: a smoother goes back over their covariances"
        raise InputError("smoother", got=getattr(estimator, "name", str(estimator)), expected=expected)
    model, feed = estimator.model, feed_of(estimator.model, log)
    there = _there(estimator, feed, start, backend, log.source)
    x, P = there.back()
    at = _reported(feed, there.t)
    return Run(
        estimator=f"{estimator.name}-rts",
        model=model.name,
        t=feed.t,
        state={name: x[at, part] for name, part in model.state_slices.items()},
        sd=deviations(model, unpack(P[at])),
        innovations=innovations_of(model, feed, there.output.seen),
        events=events_of(model, log, feed, _MAX_GAP) + broken(model, feed, there.output.seen),
        settings=settings_of(model, there.running.backend),
    )


def batch(
    model: Model,
    log: Log,
    start: Start,
    outliers: Mapping[str, Rule] | None = None,
    effort: Effort | None = None,
    *,
    backend: str = "auto",
) -> Run:
    """Fit the most likely path to a whole log by robust least squares, as a reference for what runs online.

    Begun at the smoothed path of an EKF with the same rules.  It linearises every step and reading at the path itself
    and weighs readings by their residuals there, where a filter could only use what it knew then.

    Parameters
    ----------
    model : the model, with its noise.
    log, start, backend : as for ``run``.
    outliers : by sensor name, what a reading far off counts for, absent: as any; None: ``StudentT(3)`` for all.
    effort : passes, tolerance and a callback for progress; None for the defaults.

    Returns
    -------
    Run : states and standard deviations at the times ``run`` reports.  Innovations are the residuals on the path, their
        variances the sensors' alone.  The events say when it has not settled.

    Raises
    ------
    InputError : as for ``run``; no input sample that is whole.
    EstimatorError : the filter's covariance broke, or the fit diverged.
    """
    effort = effort or Effort()
    rules = {s.name: StudentT(3.0) for s in model.sensors} if outliers is None else outliers
    estimator, feed = EKF(model, rules), feed_of(model, log)
    there = _there(estimator, feed, start, backend, log.source)
    used = [_used(data, there.t) for data in feed.sensors]
    readings = [
        Readings(np.searchsorted(there.t, data.t[rows]), data.z[rows], rule)
        if data is not None
        else Readings(rows, np.zeros((0, sensor.width)), rule)
        for sensor, data, rows, rule in zip(model.sensors, feed.sensors, used, there.running.setup.rules, strict=True)
    ]
    problem = Problem(np.diff(there.t, prepend=np.nan), there.u, start.x, start.P, tuple(readings))
    solution = solve(there.running.model, problem, there.back()[0], effort)
    at = _reported(feed, there.t)
    settled = solution.step <= effort.tolerance
    unsettled = f"not settled after {solution.passes} passes: the last moved a state by {solution.step:.2g} of its sd"
    return Run(
        estimator="batch",
        model=model.name,
        t=feed.t,
        state={name: solution.x[at, part] for name, part in model.state_slices.items()},
        sd=deviations(model, solution.P[at]),
        innovations=innovations_of(model, feed, _seen(model, feed, used, solution)),
        events=events_of(model, log, feed, _MAX_GAP) + (() if settled else (unsettled,)),
        settings=settings_of(model, there.running.backend) | {"passes": solution.passes},
    )


@dataclass(frozen=True)
class _There:
    """A filter's way forward over every time ``t`` (m,) at which something is read, with inputs ``u`` (m, nu)."""

    t: Array
    u: Array
    running: RunningFilter
    output: Output

    def back(self) -> tuple[Array, Array]:
        """Return smoothed states (m, nx) and packed covariances."""
        return smooth_rows(self.running.model, self.t, self.u, self.output.x, np.asarray(self.output.P))


def _there(estimator: EKF | UKF, feed: Feed, start: Start, backend: str, source: str) -> _There:
    running = stream(estimator, start, backend=backend)
    t, u = _grid(feed, running.setup.longest_step, source)
    return _There(t, u, running, running.run(t, u, feed.sensors))


def _grid(feed: Feed, longest: float, source: str) -> tuple[Array, Array]:
    """Return every time (m,) at which the filter stops, and the input (m, nu) that leads there: the next whole one."""
    whole = np.flatnonzero(feed.whole)
    if not whole.size:
        raise InputError(
            "no whole input sample", place=source, got="a missing number in each", expected="finite inputs"
        )
    begin, end = feed.t[whole[0]], feed.t[whole[-1]]
    t = np.unique(np.concatenate([feed.t, *[d.t for d in feed.sensors if d is not None]]))
    t = t[(t >= begin) & (t <= end)]
    if np.isfinite(longest):  # stops where the filter divides a long step, to go back over the same ones
        parts = np.maximum(1, np.ceil(np.diff(t) / longest)).astype(int)
        step = np.repeat(np.diff(t) / parts, parts)
        within = np.arange(len(step)) - np.repeat(np.cumsum(parts) - parts, parts)
        t = np.r_[np.repeat(t[:-1], parts) + within * step, t[-1]]
    return t, feed.u[whole][np.searchsorted(feed.t[whole], t)]


def _reported(feed: Feed, t: Array) -> IntArray:
    """Return the row of the grid ``t`` for each time a run is reported at; its ends stand for what lies beyond."""
    rows: IntArray = np.searchsorted(t, np.clip(feed.t, t[0], t[-1]))
    return rows


def _used(data: SensorData | None, t: Array) -> IntArray:
    """Return which readings are there and lie within the times ``t``."""
    if data is None:
        return np.zeros(0, int)
    inside = (data.t >= t[0]) & (data.t <= t[-1])
    return np.flatnonzero(inside & np.isfinite(data.z).all(axis=1))


def _seen(model: Model, feed: Feed, used: list[IntArray], solution: Solution) -> list[SensorSeen | None]:
    """Return residuals and weights of a path as innovations, NaN where a reading was not used."""
    out: list[SensorSeen | None] = []
    for j, (data, variance) in enumerate(zip(feed.sensors, model.variances, strict=True)):
        residuals = solution.residuals[j]
        one = SensorSeen.empty(0 if data is None else len(data.t), residuals.shape[1])
        one.nu[used[j]], one.s[used[j]] = residuals, variance
        one.nis[used[j]] = (residuals**2).sum(axis=1) / variance
        one.weight[used[j]] = solution.weights[j]
        out.append(None if data is None else one)
    return out
