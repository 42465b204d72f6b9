"""The inputs of every attitude row of the speed benchmark: one simulated flight, its models and its estimators."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from robustnav.benchmark.nine_axes import NineAxes, nine_axes
from robustnav.engine.filters import SensorData
from robustnav.frames import Array, euler_from_quat
from robustnav.model.blocks import Model
from robustnav.models import AttitudeNoise, attitude, attitude_euler
from robustnav.run import Start
from robustnav.sim.attitude_cases import BIAS_WALK_DPS_RTS, DIP_DEG, FIELD_UT, IMU, MAGNETOMETER, environment, sensors
from robustnav.sim.batch import simulate
from robustnav.sim.trajectory import SineAttitude
from robustnav.units import DEG, DPS, MICRO_TESLA

RATE_HZ = 200.0
DT = 1.0 / RATE_HZ
WHAT = (
    f"simulated flight at {RATE_HZ:g} Hz: roll, pitch, yaw swing by 50, 45, 80 deg at 1, 0.9, 0.7 rad/s; "
    f"white noise of {IMU} and {MAGNETOMETER}, one magnetometer reading a sample"
)


@lru_cache(maxsize=4)
def flight(samples: int) -> tuple[NineAxes, Array]:
    """Return the readings and the true attitude ``q_nb`` (n, 4) of the flight's first ``samples`` samples."""
    swing = SineAttitude((50 * DEG, 45 * DEG, 80 * DEG), (1.0, 0.9, 0.7), (0.0, 0.0, 0.0), (samples - 1) * DT, RATE_HZ)
    batch = simulate(swing, sensors(), environment(), runs=1, seed=1)
    return nine_axes(batch.log(0)), batch.q_nb


def readings(axes: NineAxes) -> list[SensorData | None]:
    """Return what our models' sensors read, ``accel`` then ``mag``."""
    return [SensorData(axes.t, axes.accel), SensorData(axes.t, axes.mag)]


def rows(gyro: Array, accel: Array, mag: Array) -> list[tuple[Array, Array, Array]]:
    """Return one tuple of three arrays (3,) a sample, made before any clock runs."""
    return list(zip(list(gyro), list(accel), list(mag), strict=True))


def quaternion_model() -> Model:
    """Return ``attitude`` with the noise that the flight was simulated with."""
    return attitude(_noise(), field=FIELD_UT * MICRO_TESLA, dip_deg=DIP_DEG)


def euler_model() -> Model:
    """Return ``attitude_euler`` with the noise that the flight was simulated with."""
    return attitude_euler(_noise(), field=FIELD_UT * MICRO_TESLA, dip_deg=DIP_DEG)


def start(model: Model, q_nb: Array) -> Start:
    """Return the start of a filter at a true attitude (4,), with the model's own start deviations."""
    if model.rotation is None:
        return Start.at(model, euler=euler_from_quat(q_nb))
    return Start.at(model, q_nb=q_nb)


def _noise() -> AttitudeNoise:
    return AttitudeNoise.from_datasheet(IMU, MAGNETOMETER, RATE_HZ, gyro_bias_density=BIAS_WALK_DPS_RTS * DPS)


def off_by(q_nb: Array, true_q_nb: Array) -> float:
    """Return the angle between two attitudes (4,) [rad]; NaN where one of them is NaN."""
    return float(2 * np.arccos(np.clip(abs(float(q_nb @ true_q_nb)), 0.0, 1.0)))
