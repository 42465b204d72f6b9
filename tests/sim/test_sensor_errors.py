"""Each error model against its theory: chi-square bands, Allan deviations, limits and streams."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from robustnav.datasheet.sensors import SensorSpec
from robustnav.errors import InputError
from robustnav.sim import sensor_errors
from robustnav.sim.sensor_errors import ALL_ERRORS, NO_ERRORS, Draws, ErrorSwitches, Sampled, active, corrupt

RATE = 100.0


def run(spec, errors, true, runs=1, seed=7):
    return corrupt(true, Sampled(spec, errors, RATE, Draws(seed, range(runs), "gyro")))


def zeros(n):
    return np.zeros((n, 3))


def assert_variance(x, variance, dof=None):
    """Two-sided 99.9 % chi-square band on the mean square of independent numbers of known zero mean."""
    dof = dof or x.size
    low, high = chi2.ppf([0.0005, 0.9995], dof) / dof
    assert low < np.mean(np.square(x)) / variance < high


def allan_deviation(x, rate_hz, m):
    """Overlapping Allan deviation of x (runs, n) at averaging time m / rate_hz (IEEE Std 952, annex C)."""
    sums = np.cumsum(np.pad(x, ((0, 0), (1, 0))), axis=1) / rate_hz
    second = sums[:, 2 * m :] - 2 * sums[:, m:-m] + sums[:, : -2 * m]
    return np.sqrt(np.mean(second**2) / 2) * rate_hz / m


def test_white_noise_variance_whiteness_and_independence():
    spec = SensorSpec(density=0.02)
    values, bias = run(spec, ErrorSwitches(white_noise=True), zeros(2000), runs=20)
    assert not bias.any()
    assert_variance(values, 0.02**2 * RATE / 2)
    sd, size = spec.sample_sd(RATE), values[:, 1:].size
    for a, b in (
        (values[:, 1:], values[:, :-1]),
        (values[:, :, 0], values[:, :, 1]),
        (values[::2], values[1::2]),
    ):
        assert abs(np.mean(a * b)) < 4 * sd**2 / np.sqrt(min(size, a.size))


def test_white_noise_allan_deviation_is_the_random_walk_of_its_integral():
    spec = SensorSpec(density=0.02)
    values, _ = run(spec, ErrorSwitches(white_noise=True), zeros(4000), runs=20)
    x = np.concatenate(list(values.transpose(2, 0, 1)))
    for m in (1, 10, 50):
        assert allan_deviation(x, RATE, m) == pytest.approx(np.sqrt(spec.intensity * RATE / m), rel=0.03)


def test_random_walk_variance_grows_with_time_and_allan_slope_is_one_half():
    spec = SensorSpec(random_walk=0.3)
    values, bias = run(spec, ErrorSwitches(random_walk=True), zeros(2001), runs=300)
    np.testing.assert_array_equal(values, bias)
    assert not bias[:, 0].any()
    for k in (1, 500, 2000):
        assert_variance(bias[:, k], 0.3**2 * k / RATE)
    x = np.concatenate(list(bias.transpose(2, 0, 1)))
    for m in (40, 160):
        assert allan_deviation(x, RATE, m) == pytest.approx(0.3 * np.sqrt(m / RATE / 3), rel=0.03)


def test_bias_instability_is_stationary_with_the_stated_allan_peak(monkeypatch):
    monkeypatch.setattr(sensor_errors, "INSTABILITY_TIME", 2.0)
    values, bias = run(SensorSpec(bias_instability=0.5), ErrorSwitches(bias_instability=True), zeros(6000), runs=100)
    np.testing.assert_array_equal(values, bias)
    sd = 0.5 / sensor_errors.GAUSS_MARKOV_PEAK
    for k in (0, 1, 3000, 5999):
        assert_variance(bias[:, k], sd**2)
    lag = np.mean(bias[:, 200:] * bias[:, :-200]) / np.mean(bias**2)
    assert lag == pytest.approx(np.exp(-1), abs=0.03)  # one time constant
    x = np.concatenate(list(bias.transpose(2, 0, 1)))
    levels = [allan_deviation(x, RATE, m) for m in (100, 379, 1200)]
    assert levels[1] == pytest.approx(0.5, rel=0.03)  # 1.89 time constants
    assert levels[1] > levels[0] and levels[1] > levels[2]


def test_gauss_markov_peak_constant():
    x = np.linspace(1.0, 4.0, 30001)
    variance = 2 / x * (1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x))
    assert np.sqrt(variance.max()) == pytest.approx(sensor_errors.GAUSS_MARKOV_PEAK, abs=5e-5)
    assert x[variance.argmax()] == pytest.approx(1.89, abs=0.005)


def test_turn_on_bias_is_constant_bounded_and_has_its_sd():
    spec = SensorSpec(turn_on_bias_sd=0.2)
    values, bias = run(spec, ErrorSwitches(turn_on_bias=True), zeros(3), runs=3000)
    np.testing.assert_array_equal(values, bias)
    assert np.ptp(bias, axis=1).max() == 0
    assert np.abs(bias).max() <= 0.2 * np.sqrt(3)
    assert np.mean(bias**2) == pytest.approx(0.04, rel=0.04)
    assert abs(np.mean(bias)) < 4 * 0.2 / np.sqrt(9000)


def test_scale_and_misalignment_make_one_matrix():
    spec = SensorSpec(scale_sd=0.03, misalignment_sd=0.01)
    true = np.concatenate([np.eye(3), [[1.0, -2.0, 3.0]]])
    both, _ = run(spec, ErrorSwitches(scale=True, misalignment=True), true, runs=2000)
    scale, _ = run(spec, ErrorSwitches(scale=True), true, runs=2000)
    matrix = both[:, :3].transpose(0, 2, 1)  # column j is the answer to axis j
    np.testing.assert_allclose(both[:, 3], matrix @ [1.0, -2.0, 3.0], atol=1e-12)
    error = matrix - np.eye(3)
    diagonal, off = np.einsum("rii->ri", error), error[:, ~np.eye(3, dtype=bool)]
    assert np.mean(diagonal**2) == pytest.approx(0.03**2, rel=0.05)
    assert np.mean(off**2) == pytest.approx(0.01**2, rel=0.05)
    assert np.abs(np.corrcoef(off.T) - np.eye(6)).max() < 4 / np.sqrt(2000)
    np.testing.assert_allclose(np.einsum("rii->ri", scale[:, :3]), 1 + diagonal, atol=1e-12)
    assert not scale[:, :3][:, ~np.eye(3, dtype=bool)].any()


def test_bandwidth_is_minus_three_decibel_and_passes_a_constant():
    spec, on = SensorSpec(bandwidth_hz=2.0), ErrorSwitches(bandwidth=True)
    constant, _ = run(spec, on, np.ones((50, 3)))
    np.testing.assert_allclose(constant, 1.0, atol=1e-12)
    t = np.arange(2000) / RATE
    wave, _ = run(spec, on, np.tile(np.sin(2 * np.pi * 2.0 * t)[:, None], 3))
    assert np.abs(wave[0, 1000:]).max() == pytest.approx(np.sqrt(0.5), rel=0.03)


def test_low_passed_noise_is_stationary_and_keeps_its_low_frequency_density():
    spec = SensorSpec(density=0.02, bandwidth_hz=5.0)
    values, _ = run(spec, ErrorSwitches(white_noise=True, bandwidth=True), zeros(4000), runs=100)
    pole = np.exp(-2 * np.pi * 5.0 / RATE)
    variance = 0.02**2 * RATE / 2 * (1 - pole) / (1 + pole)
    for k in (0, 1, 2, 3999):
        assert_variance(values[:, k], variance)
    assert variance == pytest.approx(0.02**2 * 5.0 * np.pi / 2, rel=0.01)  # the continuous low-pass
    means = values.reshape(100, 10, 400, 3).mean(axis=2)  # 4 s means: density N alone counts
    assert np.mean(means**2) == pytest.approx(spec.intensity / 4.0, rel=0.1)


def test_total_noise_is_not_filtered_again():
    spec = SensorSpec(noise_rms_sd=0.3, bandwidth_hz=1.0)
    values, _ = run(spec, ErrorSwitches(white_noise=True, bandwidth=True), zeros(3000))
    assert_variance(values, 0.09)


def test_quantisation_and_clipping():
    true = np.linspace(-3.2, 3.2, 999)[:, None] * np.ones(3)
    spec = SensorSpec(resolution=0.3, range_max=2.0)
    values, _ = run(spec, ErrorSwitches(resolution=True), true)
    np.testing.assert_allclose(values / 0.3, np.rint(values / 0.3), atol=1e-9)
    assert np.abs(values - true).max() <= 0.15 + 1e-12
    assert np.mean((values - true) ** 2) == pytest.approx(0.3**2 / 12, rel=0.05)
    clipped, _ = run(spec, ErrorSwitches(clipping=True), true)
    np.testing.assert_array_equal(clipped[0], np.clip(true, -2.0, 2.0))
    both, _ = run(spec, ErrorSwitches(resolution=True, clipping=True), true)
    np.testing.assert_allclose([both.min(), both.max()], [-1.8, 1.8])  # whole bits inside the range


def test_last_bit_at_the_range_survives_rounding():
    spec = SensorSpec(resolution=0.1, range_max=0.3)  # 0.3 / 0.1 is 2.9999999999999996
    values, _ = run(spec, ErrorSwitches(resolution=True, clipping=True), np.full((1, 3), 0.3))
    np.testing.assert_allclose(values, 0.3)


def test_nothing_on_is_the_truth_and_absent_figures_add_nothing():
    true = np.arange(12.0).reshape(4, 3)
    for spec, errors in (
        (SensorSpec(density=1.0, scale_sd=1.0, resolution=5.0), NO_ERRORS),
        (SensorSpec(density=1.0), replace(ALL_ERRORS, white_noise=False)),
    ):
        values, bias = run(spec, errors, true, runs=2)
        np.testing.assert_array_equal(values, np.stack([true, true]))
        assert not bias.any()
        assert active(spec, errors) == {}


def test_white_noise_without_a_figure_is_refused():
    with pytest.raises(InputError, match="noise figure"):
        run(SensorSpec(scale_sd=0.1), ALL_ERRORS, zeros(2))


def test_every_switch_acts():
    spec = SensorSpec(*[0.01] * 10)
    true = np.sin(np.arange(30.0))[:, None] * np.ones(3)
    for name in vars(ALL_ERRORS):
        values, _ = run(spec, ErrorSwitches(**{name: True}), true)
        assert not np.array_equal(values[0], true), name
    assert all(vars(ALL_ERRORS).values()) and not any(vars(NO_ERRORS).values())


def test_a_run_does_not_depend_on_the_others():
    spec = SensorSpec(*[0.01] * 7, 0.01)
    true = np.ones((20, 3))

    def readings(runs, sensor="gyro", seed=3):
        return corrupt(true, Sampled(spec, ALL_ERRORS, RATE, Draws(seed, runs, sensor)))[0]

    many = readings(range(12))
    np.testing.assert_array_equal(readings(range(5)), many[:5])
    np.testing.assert_array_equal(readings(range(7, 10)), many[7:10])
    assert len({row.tobytes() for row in many}) == 12
    assert not np.array_equal(readings(range(5), seed=4), many[:5])
    assert not np.array_equal(readings(range(5), sensor="accel"), many[:5])


def test_switching_one_error_leaves_the_others_alone():
    spec = SensorSpec(density=0.1, random_walk=0.1, turn_on_bias_sd=0.1)
    both, _ = run(spec, ErrorSwitches(white_noise=True, random_walk=True), zeros(50))
    noise, _ = run(spec, ErrorSwitches(white_noise=True), zeros(50))
    walk, _ = run(spec, ErrorSwitches(random_walk=True), zeros(50))
    np.testing.assert_allclose(both, noise + walk, atol=1e-15)
