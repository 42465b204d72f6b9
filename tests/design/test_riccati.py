from dataclasses import replace

import numpy as np
import pytest

from robustnav.design import Plant, gain_table, h2_riccati, verify_h2
from robustnav.design.riccati import filter_riccati
from robustnav.errors import EstimatorError
from robustnav.units import DEG


def test_attitude_figures(plant):
    design = h2_riccati(plant)
    assert design.gamma / DEG == pytest.approx(0.034891, abs=5e-7)
    assert np.allclose(np.sqrt(np.diag(design.P))[:3] / DEG, [0.0093, 0.0093, 0.0323], atol=5e-5)
    poles = np.sort(design.certificate.eigenvalues.real)
    assert np.allclose(poles, [-0.59, -0.59, -0.057, -0.0146, -0.0141, -0.0141], atol=5e-3, rtol=5e-3)
    assert design.certificate.time_constant == pytest.approx(71, abs=0.5)
    assert design.certificate.residual < 1e-9
    assert design.certificate.ratio == pytest.approx(1, abs=1e-12)


def test_scalar_case_by_hand():
    """x' = a x + sqrt(q) w1, y = c x + sqrt(r) w2 has P = (a r + sqrt(a^2 r^2 + c^2 q r)) / c^2."""
    a, q, c, r = 0.3, 2.0, 1.7, 0.5
    design = h2_riccati(Plant([[a]], [[np.sqrt(q), 0]], [[c]], [[0, np.sqrt(r)]], [[2.0]]))
    P = (a * r + np.sqrt(a**2 * r**2 + c**2 * q * r)) / c**2
    assert design.P[0, 0] == pytest.approx(P, rel=1e-12)
    assert design.L[0, 0] == pytest.approx(-P * c / r, rel=1e-12)
    assert design.gamma == pytest.approx(2 * np.sqrt(P), rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_no_other_gain_is_better_even_with_cross_noise(random_plant, seed):
    """Stationarity and optimality, which a wrong cross term would break."""
    plant = random_plant(seed)
    assert np.abs(plant.S).max() > 0.1
    design = h2_riccati(plant)
    rng = np.random.default_rng(seed)
    for _ in range(5):
        step = 1e-4 * rng.normal(size=design.L.shape)
        there, back = (verify_h2(plant, design.L + s * step, design.gamma).verified for s in (1, -1))
        assert min(there, back) >= design.gamma * (1 - 1e-12)
        assert abs(there - back) < 1e-5 * design.gamma * np.abs(step).max() / 1e-4


def test_optimum_does_not_depend_on_what_it_is_judged_on(plant):
    other = replace(plant, C_z=np.eye(6))
    assert np.allclose(h2_riccati(plant).L, h2_riccati(other).L, rtol=1e-10)


def test_agrees_with_the_sampled_filter(plant, make_sampled):
    """The discrete gain per tick tends to -L dt; 0.3 % apart at 100 Hz."""
    L = h2_riccati(plant).L
    sampled = make_sampled()
    K = gain_table(sampled.F, sampled.Q, sampled.sensors, sampled.dt).gains[0, -1] / sampled.dt
    signs = np.array([-1.0] * 3 + [1.0] * 3)  # the accelerometer row is specific force there, gravity here
    error = np.abs(K + L * signs).max(axis=0)[[0, 1, 3, 4, 5]] / np.abs(L).max(axis=0)[[0, 1, 3, 4, 5]]
    assert error.max() < 0.004


def test_no_solution_is_an_estimator_error(plant):
    with pytest.raises(EstimatorError, match="no stabilising solution"):
        filter_riccati(plant, gamma=1e-9)
