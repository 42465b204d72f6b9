from dataclasses import dataclass

import numpy as np
import pytest

from robustnav.design import Plant, SensorRows
from robustnav.frames import skew
from robustnav.units import DEG, DPS, MICRO_G, MICRO_TESLA, STANDARD_GRAVITY

# MPU-9250 data sheet: one-sided densities N become intensities N^2 / 2; 0.5 uT per sample at 100 Hz; dip 60 degrees.
GYRO = (0.01 * DPS) ** 2 / 2
BIAS = (1e-4 * DPS) ** 2
ACCEL = (300 * MICRO_G) ** 2 / 2
MAG = (0.5 * MICRO_TESLA) ** 2 / 100
FIELD_N = 48 * MICRO_TESLA * np.array([np.cos(60 * DEG), 0.0, np.sin(60 * DEG)])
DOWN_N = np.array([0.0, 0.0, STANDARD_GRAVITY])


def attitude_plant(gyro_intensity=GYRO, bias_intensity=BIAS, accel_intensity=ACCEL, mag_intensity=MAG, field_n=FIELD_N):
    """Attitude and gyro bias, linearised at level and north: errors (roll, pitch, yaw, bias)."""
    eye, none = np.eye(3), np.zeros((3, 3))
    process = np.sqrt(np.diag([gyro_intensity] * 3 + [bias_intensity] * 3))
    sensors = np.sqrt(np.diag([accel_intensity] * 3 + [mag_intensity] * 3))
    return Plant(
        A=np.block([[none, -eye], [none, none]]),
        B_w=np.hstack([process, np.zeros((6, 6))]),
        C_y=np.block([[skew(DOWN_N), none], [skew(field_n), none]]),
        D_w=np.hstack([np.zeros((6, 6)), sensors]),
        C_z=np.hstack([eye, none]),
    )


@dataclass(frozen=True)
class Sampled:
    F: np.ndarray
    Q: np.ndarray
    sensors: list
    dt: float


def sampled_attitude(dt=0.01, mag_every=1):
    """The same errors in the nav frame, sampled."""
    eye, none = np.eye(3), np.zeros((3, 3))
    return Sampled(
        F=np.block([[eye, -dt * eye], [none, eye]]),
        Q=np.diag([GYRO * dt] * 3 + [BIAS * dt] * 3),
        sensors=[
            SensorRows("accel", np.hstack([skew(-DOWN_N), none]), ACCEL / dt),
            SensorRows("mag", np.hstack([skew(FIELD_N), none]), MAG / dt, mag_every),
        ],
        dt=dt,
    )


@pytest.fixture(scope="session")
def make_plant():
    return attitude_plant


@pytest.fixture(scope="session")
def plant():
    return attitude_plant()


@pytest.fixture(scope="session")
def make_sampled():
    return sampled_attitude


@pytest.fixture
def random_plant():
    """Plants with noise that enters states and outputs together."""

    def make(seed, n=4, m=2):
        rng = np.random.default_rng(seed)
        A, B, C, D = (rng.normal(size=s) for s in ((n, n), (n, n + m), (m, n), (m, n + m)))
        return Plant(A, B, C, D, rng.normal(size=(2, n)))

    return make
