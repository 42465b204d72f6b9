"""A small synthetic run with everything a report shows."""

import numpy as np
import pytest

from robustnav.frames import quat_from_euler, quat_from_rotvec, quat_multiply
from robustnav.records import Innovations, Log, Run, Stream, Truth


def innovations(t, sd, seed, scale=1.0):
    z = np.random.default_rng(seed).normal(size=(len(t), 3)) * sd * scale
    s = np.full(z.shape, sd * sd)
    nis = (z * z / s).sum(axis=1)
    return Innovations(t, z, s, nis, nis < 16.3)


def sample(*, n=400, scale=1.0, events=(), settings=None, kind="optical"):
    t = np.arange(n) * 0.01
    q_nb = quat_from_euler(np.stack([0.5 * np.sin(t), 0.3 * np.cos(t), 3 + 0.2 * t], axis=1))
    error = np.random.default_rng(1).normal(size=(n, 3)) * 0.01
    bias = np.full((n, 3), 0.002)
    run = Run(
        "MEKF",
        "attitude",
        t,
        {"q_nb": quat_multiply(quat_from_rotvec(error), q_nb), "gyro_bias": bias},
        {"q_nb": np.full((n, 3), 0.01), "gyro_bias": bias / 4},
        {"accel": innovations(t, 0.3, 2), "mag": innovations(t, 5e-7, 3, scale)},
        tuple(events),
        {"imu": "mpu9250"} if settings is None else settings,
    )
    truth = Truth(t, q_nb, kind=kind)
    log = Log({"accel": Stream("accel", t, np.zeros((n, 3)), "m/s^2")}, "flight.ulg", truth=truth)
    return run, truth, log


@pytest.fixture
def make_sample():
    return sample
