"""Trials of BROAD made from nothing: the same fields, seconds instead of minutes."""

import numpy as np
import pytest
from scipy.io import savemat

from robustnav.frames import frd_from_flu, ned_from_enu, quat_ned_frd_from_enu_flu
from robustnav.sim.attitude_cases import environment, sensors
from robustnav.sim.batch import simulate
from robustnav.sim.trajectory import SineAttitude

RATE_HZ = 200.0


@pytest.fixture(scope="session")
def simulated():
    """A log of ten seconds in our frames."""
    swing = SineAttitude((0.6, 0.5, 0.9), (1.0, 0.9, 0.7), (0.0, 0.0, 0.3), 10.0, RATE_HZ)
    return simulate(swing, sensors(), environment(), runs=1, seed=3).log(0)


@pytest.fixture(scope="session")
def fields(simulated):
    """The same recording as BROAD writes it: sensor axes FLU, world ENU, microtesla."""
    gyro, accel, mag = (frd_from_flu(simulated.streams[name].values) for name in ("gyro", "accel", "mag"))
    n = len(gyro)
    return {
        "imu_gyr": gyro,
        "imu_acc": accel,
        "imu_mag": mag * 1e6,
        "opt_quat": quat_ned_frd_from_enu_flu(simulated.truth.q_nb),
        "opt_pos": ned_from_enu(np.zeros((n, 3))),
        "movement": (np.arange(n) > n // 4).astype(np.uint8)[:, None],
        "sampling_rate": RATE_HZ,
    }


@pytest.fixture(scope="session")
def folder(tmp_path_factory, fields):
    """A folder with one undisturbed and one disturbed trial."""
    place = tmp_path_factory.mktemp("broad")
    for name in ("03_undisturbed_made_up.mat", "30_disturbed_made_up.mat"):
        savemat(place / name, fields)
    return place
