"""The wind in words: lines, Markov wandering and gusts that were put in come out, and nothing else."""

import numpy as np
import pytest

from robustnav.alignment.disturbance import disturbance_of

from .conftest import markov, setup_of

MEAN = np.array([2.7, -2.0])


def readings(seed, n=600):
    return MEAN + 0.05 * np.random.default_rng(seed).standard_normal((n, 2))


def test_lines_come_back_with_period_and_amplitude():
    t = 0.1 * np.arange(900)
    z = readings(1, 900) + np.outer(np.sin(0.7 * t), [0.3, 0.4]) + np.outer(np.cos(2.5 * t), [0.2, 0.0])
    z += np.outer(np.sin(1.5 * t + 1), [0.0, 0.6])
    z[100:130] = np.nan
    found = disturbance_of(z, setup_of())
    np.testing.assert_allclose(found.line_period, 2 * np.pi / np.array([0.7, 1.5, 2.5]), rtol=3e-3)
    np.testing.assert_allclose(found.line_amplitude, [[0.3, 0.4], [0.0, 0.6], [0.2, 0.0]], atol=0.02)
    np.testing.assert_allclose(found.mean, MEAN, atol=0.02)
    assert found.span == 60.0
    assert "2.70 m/s north, -2.00 m/s east" in found.words and "8.98 s (0.50 m/s)" in found.words


@pytest.mark.parametrize(("sd", "time"), [(0.5, 4.0), (1.5, 4.0)])
def test_a_wandering_wind_has_no_lines(sd, time):
    found = disturbance_of(readings(2) + markov(np.random.default_rng(3), 600, 0.1, sd, time), setup_of())
    assert not found.line_period.size and "no lines" in found.words
    assert 0.4 * sd < found.markov_sd < 2.5 * sd and "wanders" in found.words


def test_gusts_are_counted_and_a_calm_is_calm():
    z = readings(4)
    calm = disturbance_of(z, setup_of())
    assert calm.gust_share < 0.01 and "wanders" not in calm.words and "gusts" not in calm.words
    z[10::20] += 4.0
    found = disturbance_of(z, setup_of())
    assert found.gust_share == pytest.approx(0.05, abs=0.005) and "5.0 % of the readings" in found.words
    np.testing.assert_allclose(found.mean, MEAN, atol=0.02)


def test_little_is_not_described():
    assert disturbance_of(readings(5, 119), setup_of()) is None
    assert disturbance_of(np.full((600, 2), np.nan), setup_of()) is None
    assert disturbance_of(np.zeros((0, 2)), setup_of()) is None
