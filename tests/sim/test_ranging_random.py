"""Tracks drawn from the white-acceleration model: start, steps and covariance are the model's own."""

from dataclasses import replace

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.sim.ranging_random import WhiteAcceleration

WHITE = WhiteAcceleration((1.0, 2.0, -3.0), (0.5, 0.0, 0.0), (2.0, 1.0, 0.5), (0.3, 0.2, 0.0), (0.7, 0.5, 0.0))
UNEVEN = np.cumsum([5.0, 0.1, 0.0, 0.7, 0.02, 1.5, 0.3])


def states(t, runs=4000, seed=1):
    tracks = WHITE.draw(t, runs=runs, seed=seed)
    return np.stack([tracks.p_n, tracks.v_n], axis=2)  # (runs, n, 2, 3)


def test_the_start_is_drawn_from_its_distribution(in_band, near):
    start = states(UNEVEN)[:, 0]
    for block, mean, sd in ((0, WHITE.p_mean, WHITE.p_sd), (1, WHITE.v_mean, WHITE.v_sd)):
        for axis in range(3):
            if sd[axis] == 0:
                np.testing.assert_array_equal(start[:, block, axis], mean[axis])
                continue
            near(np.mean(start[:, block, axis]), mean[axis], sd[axis], len(start))
            in_band(start[:, block, axis] - mean[axis], sd[axis] ** 2)


def test_every_step_has_the_models_covariance_and_no_memory(in_band, near):
    x, q = states(UNEVEN), 0.7**2
    whitened = []
    for k, dt in enumerate(np.diff(UNEVEN)):
        step = x[:, k + 1, :, 0] - x[:, k, :, 0] @ np.array([[1, dt], [0, 1]]).T
        if dt == 0:
            assert not step.any()
            continue
        Q = q * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
        white = np.linalg.solve(np.linalg.cholesky(Q), step.T)
        in_band(white, 1.0)
        near(np.mean(white[0] * white[1]), 0.0, 1.0, white.shape[1])
        whitened.append(white[1])
    near(np.mean(whitened[0] * whitened[1]), 0.0, 1.0, len(x))


def test_a_long_way_in_one_step_or_in_many_is_the_same_law(in_band):
    for t in (np.array([0.0, 3.0]), np.linspace(0, 3, 31)):
        end = states(t, seed=2)[:, -1, :, 0]
        p, v = end[:, 0] - (1.0 + 0.5 * 3.0), end[:, 1] - 0.5
        in_band(p, 2.0**2 + 0.3**2 * 9 + 0.49 * 9.0)  # q t^3 / 3
        in_band(v, 0.3**2 + 0.49 * 3.0)


def test_an_axis_without_noise_is_straight_and_axes_are_independent(near):
    x = states(UNEVEN)
    np.testing.assert_allclose(x[:, :, 0, 2], np.broadcast_to(x[:, :1, 0, 2], x.shape[:2]), atol=1e-12)
    end = x[:, -1, 1, :2] - [0.5, 0.0]
    near(np.mean(end[:, 0] * end[:, 1]), 0.0, np.std(end[:, 0] * end[:, 1]), len(end))


def test_a_seed_and_a_run_number_fix_a_track():
    many = states(UNEVEN, runs=10)
    np.testing.assert_array_equal(states(UNEVEN, runs=range(4, 6)), many[4:6])
    assert not np.array_equal(states(UNEVEN, runs=10, seed=2), many)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: replace(WHITE, p_sd=(1.0, -1.0, 0.0)), "p_sd"),
        (lambda: replace(WHITE, p_mean=(1.0, np.nan, 0.0)), "p_mean"),
        (lambda: replace(WHITE, acceleration_density=(1.0, 2.0)), "acceleration_density"),
        (lambda: WHITE.draw(np.array([1.0, 0.5]), runs=1, seed=0), "never decrease"),
        (lambda: WHITE.draw(np.zeros(0), runs=1, seed=0), "0 times"),
        (lambda: WHITE.draw(UNEVEN, runs=0, seed=0), "runs"),
        (lambda: WHITE.draw(UNEVEN, runs=1, seed=-1), "seed"),
    ],
)
def test_bad_input(make, words):
    with pytest.raises(InputError, match=words):
        make()
