"""One gain for every attitude, and the published form that has one for the north only."""

import numpy as np
import pytest

from robustnav.design.certificates import rate_history_certificate
from robustnav.engine import CompiledModel
from robustnav.frames import matrix_from_quat
from robustnav.models import attitude, attitude_euler
from robustnav.run import H2
from robustnav.studies.attitude_setting import noise, vibrating_noise
from robustnav.units import DEG

DT = 0.01
PLACE = {"field": 4.8e-5, "dip_deg": 60.0}
NOISES = {"data sheet": noise(100.0), "vibrating": vibrating_noise()}


def designed(model):
    functions = CompiledModel(model)
    return functions, H2(model, 1 / DT, start_sd="steady").table.gains[-1][-1]


def growth(functions, K, x, turn=None):
    """Largest growth rate [1/s] of the error in the loop that stands at x; body vectors in navigation axes by turn."""
    F = functions.transition(x, np.zeros(3), DT)[0]
    H = np.vstack([functions.jacobian(j, x) for j in range(2)])
    if turn is not None:
        F = turn @ F @ turn.T
    return np.log(np.abs(np.linalg.eigvals((np.eye(6) - K @ H) @ F))).max() / DT


@pytest.mark.parametrize("name", NOISES)
def test_the_loop_is_the_same_at_every_attitude(name):
    model = attitude(NOISES[name], **PLACE)
    functions, K = designed(model)
    rng, level = np.random.default_rng(0), growth(functions, K, model.nominal_state())
    assert level < 0
    for _ in range(10):
        q = rng.normal(size=4)
        q, turn = q / np.linalg.norm(q), np.eye(6)
        turn[3:, 3:] = matrix_from_quat(q)
        assert growth(functions, K, np.r_[q, 0, 0, 0], turn) == pytest.approx(level, rel=1e-6)


@pytest.mark.parametrize("name", NOISES)
def test_no_rate_history_makes_it_unstable(name):
    functions, K = designed(attitude(NOISES[name], **PLACE))
    H = np.vstack([functions.jacobian(j, functions.model.nominal_state()) for j in range(2)])[:, :3]
    found = rate_history_certificate(K[:3], K[3:], H, DT)
    assert found.ok, found.reasons


@pytest.mark.parametrize("name", NOISES)
def test_the_published_form_is_unstable_beyond_ninety_degrees(name):
    functions, K = designed(attitude_euler(NOISES[name], **PLACE))
    rates = {yaw: growth(functions, K, np.r_[0, 0, yaw * DEG, 0, 0, 0]) for yaw in (0, 60, 90, 100, 180)}
    assert max(rates[0], rates[60]) < -1e-3
    assert abs(rates[90]) < 1e-6
    assert rates[180] > rates[100] > 1e-3
