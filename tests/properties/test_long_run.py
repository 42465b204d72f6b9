"""Ten million steps in float: nothing drifts, no covariance loses definiteness."""

import numpy as np
import pytest

from robustnav.engine import CompiledModel, KernelFilter, SensorData
from robustnav.frames import euler_from_quat, quat_from_euler, rotation_error
from robustnav.run import EKF, H2
from robustnav.sim.trajectory import SineAttitude
from robustnav.units import DEG

STEPS, ROWS, PERIOD = 10_000_000, 20_000, 200.0
# whole periods of every angle in 200 s: the end of the recording is its beginning
FREQUENCY = tuple(2 * np.pi / seconds for seconds in (4, 5, 10))
MOTION = SineAttitude((50 * DEG, 40 * DEG, 120 * DEG), FREQUENCY, (0, 0, 0), PERIOD, 100.0)


@pytest.fixture(scope="module")
def simulated(setting):
    return setting(MOTION, 1)


def running(estimator, q_nb, real):
    model = estimator.model
    start = np.r_[q_nb if model.rotation else euler_from_quat(q_nb), np.zeros(3)]
    setup = estimator.setup(start, model.start_covariance())
    return KernelFilter(CompiledModel(model, real=real), setup)


@pytest.mark.parametrize("form", ["mekf", "h2", "ekf-euler"])
def test_ten_million_steps_in_float(simulated, form):
    one, batch = simulated, simulated.batch
    estimator = {
        "mekf": lambda: EKF(one.model),
        "h2": lambda: H2(one.model, 100.0),
        "ekf-euler": lambda: EKF(one.euler),
    }[form]()
    t, u = batch.t[1:], batch.gyro[0, 1:]
    readings = [batch.accel[0, 1:], batch.mag[0, 1:]]
    single, double = (running(estimator, batch.q_nb[0], real) for real in ("float", "double"))
    ends, roots = [], []
    for k in range(STEPS // ROWS):
        now = t + k * PERIOD
        sensors = [SensorData(now, z) for z in readings]
        single.run(now, u, sensors, covariance=False, innovations=False)
        if k < 20:
            double.run(now, u, sensors, covariance=False, innovations=False)
        ends.append(single.state)
        roots.append(np.linalg.eigvalsh(single.covariance)[0] if form != "h2" else 1.0)
        if k == 19:
            np.testing.assert_allclose(single.state, double.state, atol=2e-5)
            np.testing.assert_allclose(single.covariance, double.covariance, rtol=1e-3, atol=1e-12)
    assert single.snapshot()[3] == pytest.approx(STEPS / 100, rel=1e-6)
    assert min(roots) > 0
    x = np.array(ends[20:])  # the gyro bias has settled
    q_nb = x[:, :4] if estimator.model.rotation else quat_from_euler(x[:, :3])
    off = np.linalg.norm(rotation_error(q_nb, batch.q_nb[-1]), axis=1)
    assert off.max() < 0.3 * DEG
    assert np.ptp(x, axis=0).max() < 1e-5  # the same recording, the same end
