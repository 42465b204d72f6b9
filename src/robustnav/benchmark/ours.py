"""Our filters as contenders: whole arrays, and sample by sample as a program on a live sensor would."""

from __future__ import annotations

from collections.abc import Callable
from math import radians

from robustnav.benchmark.flight import DT, flight, off_by, readings, rows, start
from robustnav.benchmark.timing import Contender
from robustnav.engine.filters import Output
from robustnav.frames import Array, quat_from_euler
from robustnav.run import Estimator, stream

RIGHT = radians(5.0)  # from the truth at the end of the flight; all that work are within a degree or two
STREAM_SHARE = 6  # sample-by-sample rows take this share of the samples, Python-callback rows the next
CALLBACK_SHARE = 200


def attitude_fault(true_q_nb: Array) -> Callable[[Array], float]:
    """Return how far an attitude (4,) is from the truth, in units of ``RIGHT``."""
    return lambda q_nb: off_by(q_nb, true_q_nb) / RIGHT


def whole_array(estimator: Estimator, samples: int, *, outputs: bool = False) -> Contender:
    """Return a contender that runs over whole arrays; ``outputs`` adds covariances and innovations to the states."""
    axes, true_q_nb = flight(samples)
    running = stream(estimator, start(estimator.model, true_q_nb[0]))
    begin, sensors = running.snapshot(), readings(axes)
    fault = attitude_fault(true_q_nb[-1])

    def work() -> Output:
        running.restore(begin)
        return running.run(axes.t, axes.gyro, sensors, covariance=outputs, innovations=outputs)

    return Contender(work, samples, lambda output: fault(_attitude(output.x[-1])))


def sample_by_sample(estimator: Estimator, samples: int, *, backend: str = "auto") -> Contender:
    """Return a contender that is called once a sample, the Python loop included."""
    axes, true_q_nb = flight(samples)
    running = stream(estimator, start(estimator.model, true_q_nb[0]), backend=backend)
    begin, inputs = running.snapshot(), rows(axes.gyro, axes.accel, axes.mag)
    update, fault = running.update, attitude_fault(true_q_nb[-1])

    def work() -> None:
        running.restore(begin)
        for gyro, accel, mag in inputs:
            update(gyro, accel, mag, DT)

    return Contender(work, samples, lambda _: fault(_attitude(running.state)))


def _attitude(x: Array) -> Array:
    return x[:4] if len(x) == 7 else quat_from_euler(x[:3])
