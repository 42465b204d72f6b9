"""A range to an anchor fused in space: position and velocity, predict to its stamp and update."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from robustnav.benchmark.callbacks import few
from robustnav.benchmark.peer import require
from robustnav.benchmark.timing import Contender, Entry, Work
from robustnav.engine.filters import Output, SensorData
from robustnav.frames import Array
from robustnav.model.blocks import Model
from robustnav.models import RangeBias, uwb
from robustnav.run import EKF, Start, stream
from robustnav.sim.ranging import simulate_ranging
from robustnav.sim.ranging_errors import RangingErrors
from robustnav.sim.ranging_random import WhiteAcceleration
from robustnav.sim.ranging_setup import RangingSetup, Schedule
from robustnav.sim.rig import hall

ANCHORS, RATE_HZ, RANGE_SD, DENSITY = 8, 20.0, 0.1, 0.3
MIDDLE = (6.0, 4.0, -2.0)  # m, of the hall
RIGHT = 0.5  # m, from the truth at the end


@lru_cache(maxsize=8)
def _ranges(samples: int, together: bool) -> tuple[Array, Array, Array]:
    """Return stamps (n,), readings (n, 4) and the true last position (3,) of a tag in the hall."""
    anchors = hall()
    schedule = Schedule(RATE_HZ, (samples // ANCHORS + 2) / RATE_HZ, simultaneous=together)
    setup = RangingSetup(anchors, schedule, RangingErrors(white_sd=RANGE_SD))
    t = setup.events.t[:samples]
    none = (0.0, 0.0, 0.0)
    slow = WhiteAcceleration(MIDDLE, none, none, none, none)
    batch = simulate_ranging(slow.draw(setup.events.t, runs=1, seed=1), setup, runs=1, seed=1)
    return t, batch.ranges(0).stream().values[:samples], np.array(MIDDLE)


def _model(*, bias: bool = False) -> Model:
    noise = RangeBias(0.04, 60.0, 0.004) if bias else None
    return uwb(range_sd=RANGE_SD, acceleration_density=DENSITY, bias=noise)


def _ours(samples: int, *, together: bool, bias: bool = False) -> Contender:
    t, z, truth = _ranges(samples, together)
    model = _model(bias=bias)
    if bias:
        z = np.hstack([z, np.eye(ANCHORS)[np.arange(len(z)) % ANCHORS]])
    running = stream(EKF(model), Start.at(model, p_n=MIDDLE))
    begin = running.snapshot()
    stamps = np.unique(t)
    empty, sensors = np.zeros((len(stamps), 0)), [SensorData(t, z), None, None, None]

    def work() -> Output:
        running.restore(begin)
        return running.run(stamps, empty, sensors, covariance=False, innovations=False)

    return Contender(work, len(t), lambda output: float(np.linalg.norm(output.x[-1, :3] - truth)) / RIGHT)


def _filterpy(samples: int) -> Contender:
    """Return filterpy's ``ExtendedKalmanFilter``: predict to each stamp and update with one range."""
    t, z, truth = _ranges(few(samples) * 4, False)
    ekf: Any = require("filterpy.kalman").ExtendedKalmanFilter(6, 1)
    ekf.R *= RANGE_SD**2
    dt, one, q = float(t[1] - t[0]), np.eye(3), DENSITY**2
    ekf.F = np.block([[one, dt * one], [np.zeros((3, 3)), one]])
    ekf.Q = q * np.block([[dt**3 / 3 * one, dt**2 / 2 * one], [dt**2 / 2 * one, dt * one]])
    begin = Start.at(_model(), p_n=MIDDLE)

    def predicted(x: Array, anchor: Array) -> Array:
        return np.array([np.linalg.norm(x[:3] - anchor)])

    def row(x: Array, anchor: Array) -> Array:
        away = x[:3] - anchor
        return np.concatenate([away / np.linalg.norm(away), np.zeros(3)])[None]

    def work() -> Array:
        ekf.x, ekf.P = begin.x.copy(), begin.P.copy()
        for reading in z:
            ekf.predict()
            ekf.update(reading[:1], row, predicted, args=(reading[1:],), hx_args=(reading[1:],))
        return np.asarray(ekf.x)

    return Contender(work, len(z), lambda x: float(np.linalg.norm(x[:3] - truth)) / RIGHT)


WORK = Work(
    "range-update",
    "one range of a tag in space fused: update, and a predict to its stamp; +round: eight ranges share a stamp",
    f"simulated ranges of {ANCHORS} anchors, white noise of {RANGE_SD:g} m, {RATE_HZ:g} rounds a second",
    {
        "uwb-3d": Entry(lambda n: _ours(n, together=False)),
        "uwb-3d+round": Entry(lambda n: _ours(n, together=True)),
        "uwb-3d-biased": Entry(lambda n: _ours(n, together=False, bias=True)),
        "filterpy-ekf": Entry(_filterpy, needs="filterpy", baseline=True),
    },
)
