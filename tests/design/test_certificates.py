import numpy as np
import pytest

from robustnav.design import gain_table, h2_riccati, rate_history_certificate, verify_h2
from robustnav.errors import EstimatorError, InputError


def test_norm_by_simulation_in_the_frequency_domain(random_plant):
    """The H2 norm is the integral of |G(jw)|^2 over frequency: a third route, without a matrix equation."""
    plant = random_plant(1)
    design = h2_riccati(plant)
    F, B = plant.closed_loop(design.L)
    angle = np.linspace(0, np.pi / 2, 4001)[:-1]
    w = np.tan(angle)
    response = plant.C_z @ np.linalg.solve(1j * w[:, None, None] * np.eye(4) - F, B)
    power = (np.abs(response) ** 2).sum((1, 2)) / np.cos(angle) ** 2
    tail = (np.abs(plant.C_z @ B) ** 2).sum()
    squared = np.trapezoid([*power, tail], [*angle, np.pi / 2]) / np.pi
    assert design.certificate.verified == pytest.approx(np.sqrt(squared), rel=1e-6)


def test_a_false_promise_is_named(plant):
    design = h2_riccati(plant)
    certificate = verify_h2(plant, design.L, 0.9 * design.gamma)
    assert not certificate.ok
    with pytest.raises(EstimatorError, match="norm: "):
        certificate.require("a gain")
    assert verify_h2(plant, design.L, 2 * design.gamma).ratio == pytest.approx(0.5)


def test_an_unstable_gain_is_named(plant):
    design = h2_riccati(plant)
    certificate = verify_h2(plant, -design.L, design.gamma)
    assert certificate.verified == np.inf
    assert certificate.margin < 0
    with pytest.raises(EstimatorError, match="stability: "):
        certificate.require("a gain")
    zero = verify_h2(plant, np.zeros((6, 6)), design.gamma)
    assert not zero.ok


def test_not_a_number_never_passes(plant):
    design = h2_riccati(plant)
    assert not verify_h2(plant, design.L, np.nan).ok
    with pytest.raises(InputError, match="gain L"):
        verify_h2(plant, np.full((6, 6), np.nan), design.gamma)
    with pytest.raises(InputError, match="gain L"):
        verify_h2(plant, np.eye(3), design.gamma)


def nav_gain(make_sampled):
    sampled = make_sampled()
    K = gain_table(sampled.F, sampled.Q, sampled.sensors, sampled.dt).gains[0, -1]
    H = np.vstack([s.H for s in sampled.sensors])[:, :3]
    return K[:3], K[3:], H, sampled.dt


def test_rate_history_figures(make_sampled):
    K_theta, K_b, H, dt = nav_gain(make_sampled)
    certificate = rate_history_certificate(K_theta, K_b, H, dt)
    assert certificate.ok
    assert certificate.asymmetry < 1e-10
    assert np.allclose(np.linalg.eigvalsh(-K_b @ H / dt), [0.0008, 0.0084, 0.0084], rtol=0.01, atol=5e-5)


def test_lyapunov_function_never_grows_whatever_the_rate(make_sampled):
    """V' = -2 eps' A2 A1 eps by integrating the error under a violent random rate history."""
    K_theta, K_b, H, dt = nav_gain(make_sampled)
    A1, A2 = K_theta @ H / dt, -K_b @ H / dt
    rng = np.random.default_rng(7)
    eps, beta = rng.normal(size=3), rng.normal(size=3) * 0.1
    fine = 1e-4
    values = []
    for _ in range(3000):
        omega = 5 * rng.normal(size=3)
        values.append(eps @ A2 @ eps + beta @ beta)

        def rate(e, b, omega=omega):
            return -b - A1 @ e, np.cross(omega, b) + A2 @ e

        e1, b1 = rate(eps, beta)
        e2, b2 = rate(eps + fine / 2 * e1, beta + fine / 2 * b1)
        predicted = -2 * eps @ A2 @ A1 @ eps
        assert 2 * eps @ A2 @ e1 + 2 * beta @ b1 == pytest.approx(predicted, rel=1e-9, abs=1e-15)
        eps, beta = eps + fine * e2, beta + fine * b2
    assert np.all(np.diff(values) < 1e-9)


@pytest.mark.parametrize(
    ("K_theta", "K_b", "word"),
    [
        (np.eye(3), np.eye(3), "A2 has"),
        (-np.eye(3), -np.eye(3), "A1"),
        (np.eye(3), -np.eye(3) + np.triu(np.full((3, 3), 0.1), 1), "asymmetric"),
    ],
)
def test_rate_history_refusals(K_theta, K_b, word):
    certificate = rate_history_certificate(K_theta, K_b, np.eye(3), 0.01)
    assert not certificate.ok
    assert any(word in reason for reason in certificate.reasons)


def test_rate_history_bad_shapes():
    with pytest.raises(InputError, match="K_b"):
        rate_history_certificate(np.eye(3), np.eye(2), np.eye(3), 0.01)
