"""The start: level exactly from exact readings at any attitude, gusts and gaps told apart from wind."""

import numpy as np
import pytest

from robustnav.alignment.level import first_velocity, level_attitude, odd_limit, oddness
from robustnav.alignment.readings import reading_rows
from robustnav.frames import matrix_from_quat, quat_from_euler, quat_from_rotvec, quat_multiply
from robustnav.units import DEG

from .conftest import attitude, increments_at_rest, setup_of


@pytest.mark.parametrize(
    "turn", [[0, 0, 0], [0.5, 0, 1], [3, 0.2, 0], [0, np.pi / 2, 0], [np.pi, 0, 0], [0, np.pi, 0.3]]
)
def test_level_is_exact_without_noise(turn):
    setup, zero = setup_of(), np.zeros((20, 3))
    q = quat_multiply(attitude(0.1 * np.arange(21), 0.4), quat_from_euler(np.array(turn, float)))
    rows = reading_rows(increments_at_rest(setup, q, zero, zero), np.zeros((20, 2)))
    down = matrix_from_quat(level_attitude(rows)) @ matrix_from_quat(q[0]).T @ [0.0, 0.0, 1.0]
    # The Earth turns 30 arcseconds in these two seconds.
    np.testing.assert_allclose(down, [0, 0, 1], atol=1.5e-4)


def test_level_takes_the_gyro_bias_off():
    """Three degrees a second, six over the two seconds."""
    setup, bias = setup_of(), np.array([0.05, -0.03, 0.04])
    q = attitude(0.1 * np.arange(21), 0.4)
    rows = reading_rows(increments_at_rest(setup, q, np.tile(bias, (20, 1)), np.zeros((20, 3))), np.zeros((20, 2)))
    off = [matrix_from_quat(level_attitude(rows, b)) @ matrix_from_quat(q[0]).T @ [0.0, 0.0, 1.0] for b in (bias, None)]
    np.testing.assert_allclose(off[0], [0, 0, 1], atol=2e-4)
    assert np.hypot(off[1][0], off[1][1]) > 0.02


def test_level_upside_down():
    row = np.zeros((20, 30))
    row[:, 0], row[:, 6] = 1.0, 0.98
    np.testing.assert_allclose(matrix_from_quat(level_attitude(row)) @ [0, 0, 1.0], [0, 0, -1], atol=1e-12)


def test_level_differs_with_the_readings():
    rows = np.zeros((20, 30))
    rows[:, 0] = 1.0
    rows[:, 4:7] = matrix_from_quat(quat_from_rotvec([20 * DEG, 0, 0])).T @ [0, 0, -0.98]
    np.testing.assert_allclose(level_attitude(rows), quat_from_rotvec([20 * DEG, 0, 0]), atol=1e-12)


def test_gusts_stand_out_and_wind_does_not():
    rng = np.random.default_rng(0)
    t = 0.1 * np.arange(300)
    z = np.stack([np.sin(2 * t), np.cos(t)], -1) + 0.05 * rng.standard_normal((300, 2))
    gusts = np.array([3, 40, 77, 150, 290])
    z[gusts] += [2.0, -1.5]
    z[[10, 11, 200]] = np.nan
    odd = oddness(z)
    flagged = np.flatnonzero(odd > odd_limit(odd, 0.05))
    assert set(gusts) | {10, 11, 200} == set(flagged)
    strong = 3.0 * np.cumsum(rng.standard_normal((300, 2)), axis=0)
    odd = oddness(strong)
    assert (odd > odd_limit(odd, 0.05)).mean() < 0.05


def test_first_velocity_ignores_a_gust_and_a_gap():
    z = np.array([[9.0, -9.0], [1.0, 2.0], [np.nan, 2.0], [1.1, 2.1], [1.2, 1.9]])
    np.testing.assert_array_equal(first_velocity(z), [1.2, 2.0])
    np.testing.assert_array_equal(first_velocity(np.full((5, 2), np.nan)), [0.0, 0.0])
