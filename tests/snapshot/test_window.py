"""A window of readings: minima against a grid, covariance against draws, mirror images, outliers."""

import numpy as np
import pytest

from robustnav.sim.rig import ceiling, hall
from robustnav.snapshot.window import WindowReadings, residuals, robust_cost, robust_minima

TAG = np.array([1.5, -2.0, -1.4])
SD = 0.1


def readings(anchors, tag=TAG, rounds=4, sd=SD, seed=0, down=None, down_sd=0.0):
    p = np.tile(anchors.p_a, (rounds, 1))
    noise = sd * np.random.default_rng(seed).standard_normal(len(p))
    value = np.linalg.norm(p - tag, axis=1) + noise
    return WindowReadings(value, p, p, np.zeros(len(p), bool), np.full(len(p), SD), down, down_sd)


def differences(anchors, rounds=5, seed=0):
    first = np.tile(anchors.p_a, (rounds, 1))
    second = np.roll(first, -1, axis=0)
    noise = SD * np.random.default_rng(seed).standard_normal(len(first))
    value = np.linalg.norm(second - TAG, axis=1) - np.linalg.norm(first - TAG, axis=1) + noise
    return WindowReadings(value, first, second, np.ones(len(first), bool), np.full(len(first), SD))


def cost_at(given, p):
    p = np.atleast_2d(p)
    return robust_cost(given, np.broadcast_to(p[:, None], (len(p), len(given.value), 3)))


@pytest.mark.parametrize("given", [readings(hall()), differences(hall())], ids=["ranges", "differences"])
def test_the_minimum_is_the_lowest_of_a_grid(given):
    found = robust_minima(given)
    axis = np.linspace(-8.0, 8.0, 33)
    grid = np.stack(np.meshgrid(axis, axis, np.linspace(-8.0, 3.0, 23), indexing="ij"), axis=-1).reshape(-1, 3)
    cost = np.concatenate([cost_at(given, part) for part in np.array_split(grid, 20)])
    assert found[0].cost <= cost.min()
    assert np.linalg.norm(found[0].p - grid[np.argmin(cost)]) < 0.6
    near = found[0].p + 0.02 * np.random.default_rng(1).standard_normal((200, 3))
    assert (cost_at(given, near) >= found[0].cost).all()


@pytest.mark.parametrize("given", [readings(hall()), differences(hall())], ids=["ranges", "differences"])
def test_the_jacobian_agrees_with_differences(given):
    p, step = np.broadcast_to(TAG + 0.3, (len(given.value), 3)), 1e-6
    J = residuals(given, p)[1]
    for k, e in enumerate(np.eye(3)):
        moved = (residuals(given, p - step * e)[0] - residuals(given, p + step * e)[0]) / (2 * step)
        np.testing.assert_allclose(J[:, k], moved, atol=1e-8)


def test_the_covariance_is_that_of_many_draws():
    """Student-t weights cost a little against Gaussian noise, and the information is that of the weighted readings."""
    found = [robust_minima(readings(hall(), seed=k))[0] for k in range(120)]
    spread = np.cov(np.array([m.p for m in found]).T)
    stated = np.mean([m.P for m in found], axis=0)
    ratio = np.diag(spread) / np.diag(stated)
    assert ((ratio > 0.7) & (ratio < 1.6)).all()


def test_coplanar_anchors_give_both_mirror_images():
    found = robust_minima(readings(ceiling()))
    assert len(found) >= 2
    assert found[0].cost == pytest.approx(found[1].cost, abs=1e-6)
    np.testing.assert_allclose(found[0].p[:2], found[1].p[:2], atol=1e-6)
    assert found[0].p[2] + found[1].p[2] == pytest.approx(-8.0, abs=1e-6)


def test_a_third_of_outliers_moves_it_little():
    given = readings(hall(), rounds=6)
    value = given.value.copy()
    value[::3] += np.random.default_rng(3).uniform(1.0, 6.0, len(value[::3]))
    found = robust_minima(given._replace(value=value))
    assert np.linalg.norm(found[0].p - TAG) < 0.15
    plain = np.linalg.norm(robust_minima(given)[0].p - TAG)
    assert plain < 0.1


def test_a_known_third_coordinate_is_kept_exactly_or_within_its_sd():
    exact = robust_minima(readings(ceiling(), down=TAG[2]))[0]
    assert exact.p[2] == TAG[2]
    assert not exact.P[2].any()
    soft = robust_minima(readings(ceiling(), down=TAG[2] + 0.2, down_sd=0.1))[0]
    assert TAG[2] - 0.2 < soft.p[2] < TAG[2] + 0.2
    assert soft.P[2, 2] < 0.1**2


def test_anchors_on_a_line_have_no_information_around_it():
    line = hall().p_a[:4].copy()
    line[:, 1:] = line[0, 1:]
    line[:, 0] = [-6.0, -2.0, 2.0, 6.0]
    p = np.tile(line, (4, 1))
    given = WindowReadings(np.linalg.norm(p - TAG, axis=1), p, p, np.zeros(16, bool), np.full(16, SD))
    assert max(np.linalg.eigvalsh(m.P).max() for m in robust_minima(given)) > 1e3


def test_too_few_readings_give_nothing():
    given = readings(hall(), rounds=1)
    few = [a[:2] if isinstance(a, np.ndarray) else a for a in given]
    assert robust_minima(WindowReadings(*few)) == []
