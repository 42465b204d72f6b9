"""Reading heading from the Earth rate: against a brute sum, with nothing known, with two modes, mixed."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from robustnav.alignment.filter import RATE, Belief, start
from robustnav.alignment.heading import answer, mix, tilt_between
from robustnav.alignment.setting import AlignSetup, Wind
from robustnav.frames import quat_from_euler, quat_from_rotvec, quat_multiply

from .conftest import setup_of


def belief_with(rate_cov: np.ndarray, heading: float, down_gain: float = 2.0) -> tuple[Belief, AlignSetup]:
    """Random correlations with the rest, a rate near the one of the given azimuth of the wander frame."""
    setup, rng = setup_of(), np.random.default_rng(0)
    belief = start(setup, Wind(0.1, 2.0), quat_from_euler([0.1, 0.2, 0.7]), np.zeros(2))
    gain = np.zeros((15, 2))
    gain[:11] = rng.normal(size=(11, 2)) * np.array([4, 4, down_gain, 100, 100, 1, 1, 1, 100, 100, 100])[:, None]
    gain[RATE : RATE + 2] = np.eye(2)
    P = gain @ rate_cov @ gain.T + np.diag(np.r_[[1e-8] * 3, [1e-4] * 2, [1e-16] * 3, [1e-8] * 3, [0, 0], [1e-2] * 2])
    x = belief.core.x.copy()
    x[-2:] = setup.horizontal_earth_rate * np.array([np.cos(heading), -np.sin(heading)]) + [4e-6, -3e-6]
    return replace(belief, P=P, core=replace(belief.core, x=x)), setup


def brute(belief: Belief, setup: AlignSetup) -> tuple[np.ndarray, np.ndarray, complex, float]:
    """Mean and covariance of tilt, mean vector and variance of the azimuth, by a sum over 200 000 of them."""
    p = np.linspace(-pi, pi, 200_000, endpoint=False)
    info = np.linalg.inv(belief.P[RATE : RATE + 2, RATE : RATE + 2])
    off = setup.horizontal_earth_rate * np.stack([np.cos(p), -np.sin(p)], -1) - belief.core.rate
    w = np.exp(-0.5 * np.einsum("ki,ij,kj->k", off, info, off))
    w /= w.sum()
    K = belief.P[:3, RATE : RATE + 2] @ info
    given = belief.P[:2, :2] - K[:2] @ belief.P[RATE : RATE + 2, :2]
    tilt = off @ K[:2].T
    cov = given + (tilt * w[:, None]).T @ tilt - np.outer(w @ tilt, w @ tilt)
    vector = complex(w @ np.exp(1j * (p + off @ K[2])))
    around = (p - np.angle(vector) + pi) % (2 * pi) - pi + off @ K[2]
    given_down = belief.P[2, 2] - K[2] @ belief.P[RATE : RATE + 2, 2]
    return w @ tilt, cov, vector, float(w @ around**2 - (w @ around) ** 2 + given_down)


COVS = [np.diag([1e-12, 4e-12]), np.diag([4e-10, 1e-10]), np.array([[3e-9, 1e-9], [1e-9, 2e-9]]), 1e-7 * np.eye(2)]


@pytest.mark.parametrize("cov", COVS)
@pytest.mark.parametrize("heading", [0.3, 3.0, -1.7])
def test_answer_is_the_sum_over_the_circle(cov, heading):
    belief, setup = belief_with(cov, heading, down_gain=5e3)
    said, (tilt, tilt_cov, vector, var) = answer(belief, setup), brute(belief, setup)
    np.testing.assert_allclose(said.tilt, tilt, rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(said.tilt_cov, tilt_cov, rtol=1e-4, atol=1e-13)
    assert said.concentration == pytest.approx(abs(vector), abs=1e-5)
    if abs(vector) > 0.99:
        assert said.heading_var == pytest.approx(var, rel=1e-3)
        assert said.heading == pytest.approx((0.7 + np.angle(vector) + pi) % (2 * pi) - pi, abs=1e-3)


def test_a_rate_that_is_not_known_leaves_no_heading():
    belief, setup = belief_with(1e-6 * np.eye(2), 0.3)
    said = answer(belief, setup)
    assert said.concentration < 0.01
    assert np.sqrt(said.heading_var) > 1.5


def test_a_wander_azimuth_that_drifted_is_no_heading():
    belief, setup = belief_with(COVS[0], 0.3)
    loose = replace(belief, P=belief.P.copy())
    loose.P[2, 2] += 1.2**2
    near, far = answer(belief, setup), answer(loose, setup)
    assert far.concentration == pytest.approx(near.concentration * np.exp(-0.72), rel=1e-6)
    assert far.heading_var == pytest.approx(near.heading_var + 1.44)


def test_two_places_on_the_circle_are_both_counted():
    """A rate known in one direction only: north or south of it, nobody knows."""
    belief, setup = belief_with(np.diag([1e-14, 1e-8]), pi / 3)
    x = belief.core.x.copy()
    x[-1] = 0.0
    belief = replace(belief, core=replace(belief.core, x=x))
    said, (tilt, _, vector, _) = answer(belief, setup), brute(belief, setup)
    np.testing.assert_allclose(said.tilt, tilt, rtol=1e-3)
    assert said.concentration == pytest.approx(abs(vector), abs=1e-3) == pytest.approx(0.56, abs=0.01)
    assert np.sqrt(said.heading_var) > 0.9


@pytest.mark.parametrize("share", [0.999, 0.99, 0.9, 0.5])
def test_two_places_near_each_other_are_counted_once(share):
    """One component known, the other not: the two headings draw together as the known one nears the radius."""
    belief, setup = belief_with(np.diag([1e-13, 1e-8]), 0.0)
    x = belief.core.x.copy()
    x[-2:] = [share * setup.horizontal_earth_rate, 0.0]
    belief = replace(belief, core=replace(belief.core, x=x))
    said, (tilt, cov, vector, var) = answer(belief, setup), brute(belief, setup)
    np.testing.assert_allclose(said.tilt, tilt, rtol=1e-2, atol=1e-6)
    np.testing.assert_allclose(said.tilt_cov, cov, rtol=1e-2, atol=1e-10)
    assert said.concentration == pytest.approx(abs(vector), abs=1e-3)
    # Where the two meet exactly the whole circle is summed, at steps as wide as the density.
    assert share < 0.9 or said.heading_var == pytest.approx(var, rel=0.1 if share == 0.999 else 1e-2)


def test_mixing_moments():
    belief, setup = belief_with(COVS[0], 0.3)
    one = answer(belief, setup)
    np.testing.assert_allclose(mix([one, one], np.array([0.3, 0.7])).row, one.row, atol=1e-12)
    turn = np.array([1e-3, -2e-3, 0.0])
    other = replace(one, q=quat_multiply(quat_from_rotvec(turn), one.q), heading=one.heading + 0.01)
    np.testing.assert_allclose(tilt_between(other.q, one.q), turn[:2], rtol=1e-5)
    both = mix([one, other], np.array([0.6, 0.4]))
    np.testing.assert_allclose(both.tilt - one.tilt, 0.4 * turn[:2], rtol=1e-5)
    spread = 0.24 * np.outer(turn[:2], turn[:2])
    np.testing.assert_allclose(both.tilt_cov - one.tilt_cov, spread, rtol=1e-4, atol=1e-15)
    assert both.heading - one.heading == pytest.approx(0.004)
    assert both.heading_var - one.heading_var == pytest.approx(0.24e-4)
