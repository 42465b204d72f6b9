"""Contenders of filterpy on the Euler model; their Python callbacks make a step so slow that few samples suffice."""

from __future__ import annotations

import numpy as np

from robustnav.benchmark.flight import DT, euler_model, flight, start
from robustnav.benchmark.ours import CALLBACK_SHARE, attitude_fault
from robustnav.benchmark.peer import require
from robustnav.benchmark.peer_filterpy import EulerEkf, EulerEquations, EulerUkf
from robustnav.benchmark.timing import Contender
from robustnav.frames import quat_from_euler


def few(samples: int) -> int:
    """Return how many of the flight's samples a row with Python callbacks takes."""
    return max(samples // CALLBACK_SHARE, 2)


def filterpy_steps(kind: type[EulerEkf] | type[EulerUkf], samples: int) -> Contender:
    """Return a contender that predicts and updates once a sample, the Python loop included."""
    axes, true_q_nb = flight(few(samples))
    model = euler_model()
    begin = start(model, true_q_nb[0])
    estimator = kind(require("filterpy.kalman"), EulerEquations(model, DT), begin.x, begin.P)
    inputs = list(zip(list(axes.gyro), list(np.hstack([axes.accel, axes.mag])), strict=True))
    step, fault = estimator.step, attitude_fault(true_q_nb[-1])

    def work() -> None:
        estimator.restart(begin.x, begin.P)
        for gyro, reading in inputs:
            step(gyro, reading)

    return Contender(work, len(inputs), lambda _: fault(quat_from_euler(estimator.filter.x[:3])))
