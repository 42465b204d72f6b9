"""One setting for the properties: the study's sensors, magnetic-north axes, a start drawn from what is told."""

from types import SimpleNamespace

import numpy as np
import pytest

from robustnav.frames import matrix_from_quat, quat_from_rotvec, quat_multiply
from robustnav.models import AttitudeNoise, attitude, attitude_euler
from robustnav.run import Start
from robustnav.sim.attitude_cases import BIAS_WALK_DPS_RTS, DIP_DEG, FIELD_UT, IMU, MAGNETOMETER, environment, sensors
from robustnav.sim.batch import simulate
from robustnav.studies.attitude_setting import vibrating_noise, vibrating_sensors
from robustnav.units import DEG, DPS, MICRO_TESLA

START_SD = {"q_nb": 1 * DEG, "gyro_bias": 0.1 * DPS}


@pytest.fixture(scope="session")
def setting():
    def make(trajectory, runs, seed=0, *, vibrating=False):
        carried = vibrating_sensors(100.0) if vibrating else sensors()
        batch = simulate(trajectory, carried, environment(), runs=runs, seed=seed)
        rate_hz = 1 / (batch.t[1] - batch.t[0])
        noise = AttitudeNoise.from_datasheet(IMU, MAGNETOMETER, rate_hz, gyro_bias_density=BIAS_WALK_DPS_RTS * DPS)
        noise = vibrating_noise() if vibrating else noise
        place = {"field": FIELD_UT * MICRO_TESLA, "dip_deg": DIP_DEG}
        return SimpleNamespace(
            batch=batch, rate_hz=rate_hz, model=attitude(noise, **place), euler=attitude_euler(noise, **place)
        )

    return make


@pytest.fixture(scope="session")
def drawn_start():
    """A start off the truth by a draw from the covariance (6, 6) it is told, in navigation axes."""

    def make(model, batch, run, P=None):
        P = model.start_covariance(START_SD) if P is None else P
        error = np.linalg.cholesky(P) @ np.random.default_rng([5, run]).normal(size=6)
        C_bn, turn = matrix_from_quat(batch.q_nb[0]).T, np.eye(6)
        turn[3:, 3:] = C_bn
        q_nb = quat_multiply(quat_from_rotvec(-error[:3]), batch.q_nb[0])
        return Start(np.r_[q_nb, batch.gyro_bias[run, 0] - C_bn @ error[3:]], turn @ P @ turn.T)

    return make
