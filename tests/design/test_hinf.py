import numpy as np
import pytest

from robustnav.design import Plant, h2_riccati, hinf_norm, hinf_observer
from robustnav.design.hinf import certified_hinf, frequency_sweep
from robustnav.errors import EstimatorError, InputError


@pytest.mark.parametrize("damping", [0.01, 0.1, 0.5])
def test_norm_of_an_oscillator(damping):
    """1 / (s^2 + 2 d s + 1) peaks at 1 / (2 d sqrt(1 - d^2))."""
    F = np.array([[0.0, 1.0], [-1.0, -2 * damping]])
    norm = hinf_norm(F, np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]))
    assert norm == pytest.approx(1 / (2 * damping * np.sqrt(1 - damping**2)), rel=5e-6)


def test_norm_of_a_lag_and_of_nothing():
    F, one = np.array([[-2.0]]), np.array([[1.0]])
    assert hinf_norm(F, one, 3 * one) == pytest.approx(1.5, rel=5e-6)
    assert hinf_norm(F, one, 0 * one) == 0.0


@pytest.mark.parametrize("seed", range(6))
def test_norm_bounds_a_dense_sweep(seed):
    rng = np.random.default_rng(seed)
    F = rng.normal(size=(5, 5))
    F -= (np.linalg.eigvals(F).real.max() + 0.05) * np.eye(5)
    B, C = rng.normal(size=(5, 2)), rng.normal(size=(3, 5))
    norm = hinf_norm(F, B, C)
    w = np.linspace(0, 20, 40001)
    response = C @ np.linalg.solve(1j * w[:, None, None] * np.eye(5) - F, B)
    peak = np.linalg.svd(response, compute_uv=False)[:, 0].max()
    assert peak <= norm
    assert norm < peak * (1 + 1e-4)
    assert frequency_sweep(F, B, C) <= norm


def test_smallest_gamma_is_near_tight(plant):
    design = hinf_observer(plant)
    assert design.certificate.ok
    assert design.swept <= design.certificate.verified <= design.gamma * (1 + 1e-5)
    assert design.swept > 0.99 * design.gamma
    nominal = h2_riccati(plant)
    assert design.gamma < 0.7 * hinf_norm(*plant.closed_loop(nominal.L), plant.C_z)
    with pytest.raises(EstimatorError, match="no stabilising solution"):
        hinf_observer(plant, gamma=design.gamma / 1.02)


@pytest.mark.parametrize("seed", range(2))
def test_promise_kept_with_cross_noise(random_plant, seed):
    plant = random_plant(seed)
    for relax in (1.01, 1.5):
        design = hinf_observer(plant, relax=relax)
        assert design.certificate.verified <= design.gamma * (1 + 1e-5)
        assert design.certificate.residual < 1e-9


def test_scalar_case_by_hand():
    """x' = w1, y = x + w2, z = x: P^2 (1 - 1/gamma^2) = 1, so gamma > 1 and L = -P."""
    plant = Plant([[0.0]], [[1.0, 0.0]], [[1.0]], [[0.0, 1.0]], [[1.0]])
    assert hinf_observer(plant, relax=1.0001).gamma == pytest.approx(1.0, rel=2e-4)
    assert hinf_observer(plant, gamma=2.0).L[0, 0] == pytest.approx(-1 / np.sqrt(0.75), rel=1e-9)


def test_becomes_the_kalman_gain_as_gamma_grows(plant):
    L = h2_riccati(plant).L
    size = hinf_norm(*plant.closed_loop(L), plant.C_z)
    distance = [np.abs(hinf_observer(plant, gamma=f * size).L - L).max() / np.abs(L).max() for f in (10, 100, 1000)]
    assert distance[0] > 50 * distance[1] > 2500 * distance[2]
    assert distance[2] < 1e-6


def test_a_false_bound_or_unstable_gain_is_refused(plant):
    L = h2_riccati(plant).L
    size = hinf_norm(*plant.closed_loop(L), plant.C_z)
    assert certified_hinf(plant, L, 1.001 * size, 0.0).certificate.ok
    with pytest.raises(EstimatorError, match="norm: "):
        certified_hinf(plant, L, 0.9 * size, 0.0)
    with pytest.raises(EstimatorError, match="stability: "):
        certified_hinf(plant, -L, size, 0.0)
    with pytest.raises(EstimatorError, match="residual: "):
        certified_hinf(plant, L, 1.001 * size, np.nan)


@pytest.mark.parametrize("options", [{"gamma": 0.0}, {"gamma": np.nan}, {"relax": 1.0}])
def test_bad_input(plant, options):
    with pytest.raises(InputError, match="H-infinity"):
        hinf_observer(plant, **options)
