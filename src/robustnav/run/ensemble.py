"""One estimator over many independent runs of the same motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter_ns

import numpy as np

from robustnav.engine.filters import Output, SensorData
from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.run.estimators import Estimator
from robustnav.run.loop import Start, covariance_of, stream


@dataclass(frozen=True)
class Readings:
    """Inputs ``u`` (runs, n, nu) at ``t`` (n,); by sensor of the model (times, values (runs, m, size)) or None."""

    t: Array
    u: Array
    sensors: Sequence[tuple[Array, Array] | None]


@dataclass(frozen=True)
class Ensemble:
    """States ``x`` (runs, n, nx), NIS by sensor (runs, m), covariances (runs, n, ne, ne) or None, time a step."""

    x: Array
    nis: tuple[Array | None, ...]
    P: Array | None
    ns_per_step: float


def run_ensemble(
    estimator: Estimator,
    readings: Readings,
    starts: Sequence[Start],
    *,
    covariance: bool = False,
    progress: Callable[[], None] = lambda: None,
) -> Ensemble:
    """Run an estimator over every run, each from its own start.

    Parameters
    ----------
    estimator : with its model.
    readings : of all runs.
    starts : one a run.
    covariance : keep the covariance at every step and the NIS (memory: runs x n x ne^2 numbers).
    progress : called after every run.

    Raises
    ------
    InputError : not one start a run.
    """
    if len(starts) != len(readings.u):
        raise InputError("starts", got=f"{len(starts)}", expected=f"{len(readings.u)}, one a run")
    states, covariances, times = [], [], []
    seen: list[Output] = []
    for i, start in enumerate(starts):
        running = stream(estimator, start)
        sensors = [None if s is None else SensorData(s[0], s[1][i]) for s in readings.sensors]
        begin = perf_counter_ns()
        output = running.run(readings.t, readings.u[i], sensors, covariance=covariance, innovations=covariance)
        times.append((perf_counter_ns() - begin) / len(readings.t))
        states.append(output.x)
        if covariance:
            covariances.append(covariance_of(estimator, readings.t, readings.u[i], output))
            seen.append(output)
        progress()
    count = len(readings.sensors)
    nis = tuple(_stacked([one.nis for o in seen if (one := o.seen[j]) is not None]) for j in range(count))
    P = np.array(covariances) if covariance else None
    return Ensemble(np.array(states), nis, P, float(np.median(times)))


def _stacked(parts: list[Array]) -> Array | None:
    return np.array(parts) if parts else None
