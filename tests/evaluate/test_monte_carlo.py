import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.evaluate import monte_carlo, settle_time
from robustnav.units import DEG


def test_rms_and_extremes_in_degrees():
    errors = np.zeros((3, 4, 3))
    errors[..., 0] = 2 * DEG
    errors[0, 0, 1] = -6 * DEG
    got = monte_carlo(np.arange(4.0), errors)
    np.testing.assert_allclose(got.rms_deg, [2, 6 / np.sqrt(12), 0], atol=1e-12)
    np.testing.assert_allclose(got.min_deg, [2, -6, 0], atol=1e-12)
    np.testing.assert_allclose(got.max_deg, [2, 0, 0], atol=1e-12)
    assert got.total_deg == pytest.approx(np.sqrt(4 + 3))
    assert (got.low_deg[0], got.high_deg[0]) == pytest.approx((2, 2))


def test_interval_has_the_width_of_the_normal_theory():
    """Runs with a constant error each, so a run is worth one sample: var of the mean square is 2 / runs."""
    errors = np.repeat(np.random.default_rng(5).normal(size=(900, 1, 3)), 5, axis=1)
    got = monte_carlo(np.arange(5.0), errors, confidence=0.9)
    mean_square = (got.rms_deg * DEG) ** 2
    half_width = 1.645 * mean_square * np.sqrt(2 / 900)
    np.testing.assert_allclose((got.low_deg * DEG) ** 2, mean_square - half_width, atol=0.25 * half_width.max())
    np.testing.assert_allclose((got.high_deg * DEG) ** 2, mean_square + half_width, atol=0.25 * half_width.max())


def test_equal_seeds_give_equal_figures():
    errors = np.random.default_rng(6).normal(size=(20, 3, 3))
    one, two, other = (monte_carlo(np.arange(3.0), errors, seed=s).low_deg for s in (1, 1, 2))
    assert (one == two).all() and (one != other).any()


def test_settle_time_is_after_the_last_exceedance():
    t = np.array([10.0, 11.0, 12.0, 14.0])
    error = np.array([[3, 0.5, 3, 1.0], [0, 0, 0, 0], [0, 0, 0, 2], [np.nan, 0, 0, 0], [-3, 0, 0, 0]])
    np.testing.assert_array_equal(settle_time(t, error, 1.0), [4, 0, np.nan, 1, 1])


def test_a_nan_run_is_counted_and_fails_the_figures():
    errors = np.zeros((4, 3, 3))
    errors[1, 2, 0] = np.nan
    got = monte_carlo(np.arange(3.0), errors)
    assert got.failed == 1 and np.isnan(got.rms_deg[0]) and np.isnan(got.total_deg)
    assert np.isnan(got.settle_s[1]) and got.settle_s[0] == 0


@pytest.mark.parametrize("shape", [(1, 3, 3), (4, 2, 3), (4, 3, 2), (4, 3)])
def test_shapes_and_single_runs_are_refused(shape):
    with pytest.raises(InputError, match="Monte Carlo errors"):
        monte_carlo(np.arange(3.0), np.zeros(shape))
