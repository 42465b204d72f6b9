"""The attitude study as data: published figures, cases, protocols, models and estimators.

Source of the published figures: Kim, Tadiparthi, Bhattacharya, "Nonlinear Attitude Estimation for Small UAVs with Low
Power Microprocessors", ACC 2020, tables of RMS and min-max error in degrees.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from robustnav.frames import Array, euler_from_quat, matrix_from_quat, quat_from_rotvec, quat_multiply
from robustnav.model.blocks import Model
from robustnav.models import AttitudeNoise, attitude, attitude_euler
from robustnav.run import EKF, H2, Estimator, Start
from robustnav.sim.attitude_cases import BIAS_WALK_DPS_RTS, DIP_DEG, FIELD_UT, IMU, MAGNETOMETER, sensors
from robustnav.sim.batch import Sensors
from robustnav.sim.trajectory import SineAttitude, case_one, case_two
from robustnav.units import DEG, DPS, MICRO_TESLA, STANDARD_GRAVITY

PUBLISHED: dict[str, dict[str, dict[str, list[float]]]] = {
    "I": {
        "extended H2": {
            "rms_deg": [0.0331, 0.0538, 0.1107],
            "min_deg": [-0.152, -0.284, -0.423],
            "max_deg": [0.125, 0.240, 0.402],
        },
        "EKF": {
            "rms_deg": [0.0533, 0.0988, 0.2298],
            "min_deg": [-0.257, -0.523, -1.087],
            "max_deg": [0.249, 0.444, 0.937],
        },
    },
    "II": {
        "extended H2": {
            "rms_deg": [0.3045, 0.3260, 0.3121],
            "min_deg": [-0.592, -0.897, -0.857],
            "max_deg": [0.730, 0.602, 0.664],
        },
        # The pitch range is printed "[-1.84000.692]"; read as [-1.840, 0.692].
        "EKF": {
            "rms_deg": [0.3073, 0.2656, 0.5275],
            "min_deg": [-2.212, -1.840, -2.227],
            "max_deg": [1.404, 0.692, 3.097],
        },
    },
}
CASES: dict[str, SineAttitude] = {"I": case_one(), "II": case_two()}
ESTIMATORS = ("h2-euler", "ekf-euler", "h2", "mekf")
PROTOCOLS = {
    "warm": "every filter's start error is drawn from the steady-state covariance, the same draw for all",
    "cold": "every start error is drawn from 1 deg and 0.1 deg/s, the covariance that every filter is given",
    "published": "every filter starts at the exact truth; only the EKFs are told it may be off by 1 deg, 0.1 deg/s",
}
COLD_SD = {"attitude": 1.0 * DEG, "gyro_bias": 0.1 * DPS}
VIBRATING_GYRO = 3.5e-4  # rad/s/sqrt(Hz), two-sided: 0.005 rad/s a sample at 200 Hz
TURN_INTENSITY = 0.02  # rad^2/s, for the start-up schedule: 6 deg/s over a second


def noise(rate_hz: float) -> AttitudeNoise:
    """Return the study's sensor noise at a sample rate."""
    return AttitudeNoise.from_datasheet(IMU, MAGNETOMETER, rate_hz, gyro_bias_density=BIAS_WALK_DPS_RTS * DPS)


def vibrating_noise() -> AttitudeNoise:
    """Return the noise of a small multicopter's sensors in flight: what vibration adds dwarfs the data sheet."""
    return AttitudeNoise(VIBRATING_GYRO, 1e-4, 0.03 * STANDARD_GRAVITY, 0.02 * FIELD_UT * MICRO_TESLA)


def vibrating_sensors(rate_hz: float) -> Sensors:
    """Return the study's sensors with ``vibrating_noise`` at a sample rate."""
    plain, wide = sensors(), vibrating_noise()
    gyro = replace(plain.imu.gyro, density=wide.gyro_density * sqrt(2))
    accel = replace(plain.imu.accel, density=wide.accel_sd / sqrt(rate_hz / 2))
    if plain.magnetometer is None:
        raise TypeError("the study's sensors have a magnetometer")
    field = replace(plain.magnetometer.field, density=None, noise_rms_sd=wide.mag_sd)
    unit = replace(plain.imu, gyro=gyro, accel=accel)
    return Sensors(unit, replace(plain.magnetometer, field=field), plain.errors)


def quaternion_model(sensor_noise: AttitudeNoise) -> Model:
    """Return ``attitude`` with the study's field."""
    return attitude(sensor_noise, field=FIELD_UT * MICRO_TESLA, dip_deg=DIP_DEG)


def euler_model(sensor_noise: AttitudeNoise) -> Model:
    """Return ``attitude_euler`` with the study's field."""
    return attitude_euler(sensor_noise, field=FIELD_UT * MICRO_TESLA, dip_deg=DIP_DEG)


@dataclass(frozen=True)
class Lineup:
    """The study's estimators for one protocol: by name, and the covariance (6, 6) their start errors are drawn from.

    Start errors are in navigation axes: attitude, then gyro bias.  ``told`` is the covariance that the filters are
    given; it differs from ``drawn`` under ``published`` only.
    """

    estimators: dict[str, Estimator]
    drawn: Array
    told: Array


def lineup(protocol: str, rate_hz: float, sensor_noise: AttitudeNoise | None = None) -> Lineup:
    """Return the estimators and start covariances of a protocol.

    ``h2-euler`` always runs the one published gain.  ``h2`` runs the start-up schedule where a start covariance is
    known to every filter (cold), and its steady gain otherwise.  ``sensor_noise``: None takes the study's.
    """
    sensor_noise = sensor_noise or noise(rate_hz)
    q, e = quaternion_model(sensor_noise), euler_model(sensor_noise)
    steady = H2(q, rate_hz, start_sd="steady")
    cold = np.diag([COLD_SD["attitude"] ** 2] * 3 + [COLD_SD["gyro_bias"] ** 2] * 3)
    h2 = steady
    if protocol == "cold":
        start_sd = {"q_nb": COLD_SD["attitude"], "gyro_bias": COLD_SD["gyro_bias"]}
        h2 = H2(q, rate_hz, start_sd=start_sd, turn_intensity=TURN_INTENSITY)
    estimators: dict[str, Estimator] = {
        "h2-euler": H2(e, rate_hz, start_sd="steady"),
        "ekf-euler": EKF(e),
        "h2": h2,
        "mekf": EKF(q),
    }
    P_steady = steady.table.covariance[-1]
    drawn = {"warm": P_steady, "cold": cold, "published": np.zeros((6, 6))}[protocol]
    return Lineup(estimators, drawn, P_steady if protocol == "warm" else cold)


@dataclass(frozen=True)
class Acquisition:
    """A wide start: the two filters that are told of it, and the covariance (6, 6) it is drawn from."""

    estimators: dict[str, Estimator]
    P: Array


def acquisition(rate_hz: float, sensor_noise: AttitudeNoise) -> Acquisition:
    """Return ``h2`` with its schedule and ``mekf`` for a start 5 deg off the vertical, 10 deg in heading, 1 deg/s."""
    model = quaternion_model(sensor_noise)
    sd: dict[str, ArrayLike] = {"q_nb": np.array([5.0, 5.0, 10.0]) * DEG, "gyro_bias": 1.0 * DPS}
    h2 = H2(model, rate_hz, start_sd=sd, turn_intensity=TURN_INTENSITY)
    return Acquisition({"h2": h2, "mekf": EKF(model)}, model.start_covariance(sd))


def start_at(model: Model, q_nb: Array, gyro_bias: Array, told: Array, error: Array) -> Start:
    """Return the start of a filter whose error (6,) from the truth is given in navigation axes.

    Parameters
    ----------
    model : ``attitude`` or ``attitude_euler``.
    q_nb, gyro_bias : true attitude (4,) and bias (3,).
    told : covariance (6, 6) in navigation axes.
    error : truth minus start, attitude [rad] and bias [rad/s] in navigation axes.
    """
    C_bn = matrix_from_quat(q_nb).T
    q_start = quat_multiply(quat_from_rotvec(-error[:3]), q_nb)
    bias = gyro_bias - C_bn @ error[3:]
    turn = np.eye(6)
    turn[3:, 3:] = C_bn
    if model.rotation is not None:
        return Start(np.r_[q_start, bias], turn @ told @ turn.T)
    euler = euler_from_quat(q_start)
    turn[:3, :3] = euler_from_rotation(euler)
    return Start(np.r_[euler, bias], turn @ told @ turn.T)


def euler_from_rotation(euler: Array) -> Array:
    """Return d(roll, pitch, yaw)/d(small rotation in navigation axes) (..., 3, 3) at Euler angles (..., 3)."""
    _, pitch, yaw = np.moveaxis(euler, -1, 0)
    zero, one = np.zeros_like(yaw), np.ones_like(yaw)
    rows = [
        [np.cos(yaw) / np.cos(pitch), np.sin(yaw) / np.cos(pitch), zero],
        [-np.sin(yaw), np.cos(yaw), zero],
        [np.cos(yaw) * np.tan(pitch), np.sin(yaw) * np.tan(pitch), one],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
