"""Position figures: hand-worked numbers, correlated errors, what counts and what does not."""

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.evaluate.position import (
    effective_samples,
    evaluate_position,
    position_at,
    position_figures,
    rms_interval,
)
from robustnav.records import Run, Truth


def coloured(rng, phi, n, width=3):
    """Errors of unit variance with lag-one correlation ``phi``, stationary from the first row."""
    out = rng.standard_normal((n, width))
    out[1:] *= np.sqrt(1 - phi**2)
    for k in range(1, n):
        out[k] += phi * out[k - 1]
    return out


def test_figures_by_hand():
    figures = position_figures(np.array([[3.0, 4.0, 12.0], [0.0, 0.0, -1.0], [-3.0, -4.0, 0.0], [0.0, 0.0, 0.0]]))
    assert figures["rmse_2d"] == pytest.approx(np.sqrt(50 / 4), rel=1e-15)
    assert figures["rmse_3d"] == pytest.approx(np.sqrt((169 + 1 + 25) / 4), rel=1e-15)
    assert (figures["max_2d"], figures["max_3d"], figures["samples"]) == (5.0, 13.0, 4)
    assert figures["median_3d"] == pytest.approx(np.sqrt(13))  # between the squares of 1 and 5
    assert (figures["unstarted"], figures["nan_estimates"]) == (0, 0)


def test_before_the_first_estimate_nothing_counts_and_after_it_everything():
    errors = np.ones((5, 3))
    errors[:2] = np.nan
    figures = position_figures(errors)
    assert (figures["samples"], figures["unstarted"], figures["nan_estimates"]) == (3, 2, 0)
    assert figures["rmse_3d"] == pytest.approx(np.sqrt(3))
    errors[3, 2] = np.nan
    figures = position_figures(errors)
    assert (figures["samples"], figures["unstarted"], figures["nan_estimates"]) == (3, 2, 1)
    assert np.isnan(figures["rmse_3d"]) and np.isnan(figures["p95_3d"])
    nothing = position_figures(np.full((4, 3), np.nan))
    assert (nothing["samples"], nothing["unstarted"]) == (0, 4) and np.isnan(nothing["rmse_2d"])
    with pytest.raises(InputError, match="position errors"):
        position_figures(np.zeros((4, 2)))


@pytest.mark.parametrize("phi", [0.0, 0.8, 0.95])
def test_effective_samples_follow_the_correlation_time(phi):
    rng = np.random.default_rng(2)
    n = 6000
    found = [effective_samples(coloured(rng, phi, n, 1)[:, 0]) for _ in range(10)]
    assert np.mean(found) == pytest.approx(n * (1 - phi) / (1 + phi), rel=0.2)


def test_series_that_say_nothing():
    assert effective_samples(np.full(50, 0.1)) == 1.0
    assert effective_samples(np.array([])) == effective_samples(np.array([1.0, np.nan])) == 0.0
    assert np.isnan(rms_interval(np.full(50, 0.1))).all()


def test_the_interval_covers_about_as_often_as_it_says():
    rng = np.random.default_rng(3)
    inside = 0
    for _ in range(150):
        low, high = rms_interval(np.sum(coloured(rng, 0.9, 1500) ** 2, axis=1))
        inside += low <= np.sqrt(3) <= high
    assert 0.87 < inside / 150 <= 0.99
    naive = rms_interval(np.sum(rng.standard_normal((1500, 3)) ** 2, axis=1))
    assert high - low > 2 * (naive[1] - naive[0])  # correlation widens it


def test_a_reference_is_interpolated_and_never_invented():
    t = np.array([0.0, 1.0, 2.0, 10.0, 11.0])
    p = np.column_stack([t, 2 * t, -t])
    at = np.array([-0.1, 0.0, 0.5, 2.0, 5.0, 10.0, 11.0, 11.1])
    found = position_at(t, p, at)
    np.testing.assert_array_equal(np.isnan(found[:, 0]), [True, False, False, False, True, False, False, True])
    np.testing.assert_allclose(found[[1, 2, 3, 5, 6]], np.outer([0, 0.5, 2, 10, 11], [1, 2, -1]))
    with pytest.raises(InputError, match="reference positions"):
        position_at(np.zeros(0), np.zeros((0, 3)), at)


def test_a_run_is_scored_against_a_truth():
    t = np.arange(20.0)
    truth = Truth(t[5:], None, p_n=np.column_stack([t, t, t])[5:], accuracy="2 cm")
    p_n = np.column_stack([t + 3, t + 4, t])
    run = Run("ekf", "uwb", t + 0.5, {"p_n": p_n + 0.5}, {}, {})
    score = evaluate_position(run, truth)
    assert score.samples == 14 and score.values["rmse_2d"] == pytest.approx(5.0)
    assert score.reference == "simulated, 2 cm"
    assert evaluate_position(run, truth, skip=10).samples == 9
    with pytest.raises(InputError, match="nothing to score"):
        evaluate_position(run, truth, skip=100)
    with pytest.raises(InputError, match="nothing to score"):
        evaluate_position(Run("ekf", "uwb", t[:0], {"p_n": p_n[:0]}, {}, {}), truth)
    with pytest.raises(InputError, match="no position"):
        evaluate_position(Run("ekf", "uwb", t, {"v_n": p_n}, {}, {}), truth)
    with pytest.raises(InputError, match="truth has no position"):
        evaluate_position(run, Truth(t))
