"""The step at one place, on a swaying carrier whose attitude is known in closed form."""

from math import radians

import numpy as np
import pytest

from robustnav.earth import normal_gravity
from robustnav.errors import InputError
from robustnav.frames import matrix_from_quat, quat_multiply, rotation_error
from robustnav.sim.sway import Sway, Swing, attitude_n, sway_increments
from robustnav.strapdown import ImuSamples, Place, backtrack, carry, preintegrate

SWAY = Sway(Swing(amplitude=radians(3), frequency_hz=10.0), Swing(radians(45), radians(5), 2.0))
A = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])  # north-east-down of east-north-up, forward-right-down of r-f-u


@pytest.fixture(scope="module")
def swaying():
    """The published sway for 20 s: true attitude at 10 Hz, and samples at 1 kHz, at three places and headings."""
    increments = sway_increments(SWAY, 20_000, 1000.0)
    t = np.arange(201) * 0.1
    return [
        (Place.at(latitude), attitude_n(SWAY, heading, t), increments.samples(heading, Place.at(latitude)))
        for latitude, heading in ((radians(32.03), 1.0), (radians(-70), 4.0), (0.0, -0.5), (radians(89), 2.5))
    ]


def test_what_the_integration_adds_to_an_exact_truth(swaying):
    """1e-9 rad of attitude, 1e-8 m/s^2 of force, at any latitude: far below any sensor."""
    for place, q_nb, samples in swaying:
        q, v = carry(q_nb[0], np.zeros(3), preintegrate(samples, 100), place)
        assert np.linalg.norm(rotation_error(q, q_nb), axis=1).max() < 1e-9
        assert np.linalg.norm(v, axis=1).max() < 1e-8 * 20


def test_backtracking_is_the_way_back(swaying):
    place, q_nb, samples = swaying[0]
    increments = preintegrate(samples, 100)
    bias = (np.array([1e-4, -2e-4, 3e-4]), np.array([1e-3, 1e-3, 1e-3]))
    walk = np.linspace(0, 1, len(increments))[:, None] * bias[0]
    for gyro_bias in (None, bias[0], walk):
        q, _ = carry(q_nb[0], np.zeros(3), increments, place, None if gyro_bias is None else (gyro_bias, bias[1]))
        back = backtrack(q[-1], increments, place, gyro_bias)
        assert np.linalg.norm(rotation_error(back, q_nb[0])) < 1e-11
    part = increments.between(0, 73)
    assert np.linalg.norm(rotation_error(backtrack(q[73], part, place, walk[:73]), q_nb[0])) < 1e-11
    both = backtrack(np.stack([q[73], -q[73]]), part, place, walk[:73])
    np.testing.assert_allclose(both[0], -both[1])


def test_bias_is_taken_off(swaying):
    place, q_nb, samples = swaying[0]
    bias = (np.array([1e-4, -2e-4, 3e-4]), np.array([1e-3, -1e-3, 1e-3]))
    biased = ImuSamples(samples.angle + bias[0] * samples.dt, samples.velocity + bias[1] * samples.dt, samples.dt)
    q, v = carry(q_nb[0], np.zeros(3), preintegrate(biased, 100), place, bias)
    assert np.linalg.norm(rotation_error(q, q_nb), axis=1).max() < 1e-7  # uncorrected: 7e-3
    assert np.linalg.norm(v, axis=1).max() < 1e-5


def test_the_same_in_east_north_up(swaying):
    """Body and navigation axes turned, gravity up: the result turns with them."""
    place, q_nb, samples = swaying[0]
    q, v = carry(q_nb[0], np.array([1.0, 2.0, -0.5]), preintegrate(samples, 100), place)
    rfu = ImuSamples(samples.angle @ A.T, samples.velocity @ A.T, samples.dt)
    enu = Place(A @ place.earth_rate_n, A @ place.gravity_n)
    half = np.sqrt(0.5)
    q_a = np.array([0.0, half, half, 0.0])
    np.testing.assert_allclose(matrix_from_quat(q_a), A, atol=1e-15)

    def turned(q):
        return quat_multiply(quat_multiply(q_a, q), q_a)

    q_enu, v_enu = carry(turned(q_nb[0]), A @ [1.0, 2.0, -0.5], preintegrate(rfu, 100), enu)
    assert np.linalg.norm(rotation_error(q_enu, turned(q)), axis=1).max() < 1e-9
    np.testing.assert_allclose(v_enu, v @ A.T, atol=1e-9)


def test_free_of_the_earth_a_still_unit_stays(swaying):
    still = ImuSamples(np.zeros((50, 3)), np.tile([0.0, 0, -9.8 * 0.01], (50, 1)), 0.01)
    q, v = carry(
        np.array([1.0, 0, 0, 0]), np.zeros(3), preintegrate(still, 10), Place(np.zeros(3), np.array([0, 0, 9.8]))
    )
    np.testing.assert_allclose(q, np.tile([1.0, 0, 0, 0], (6, 1)), atol=1e-15)
    np.testing.assert_allclose(v, 0, atol=1e-13)


def test_a_place_is_on_the_earth():
    there = Place.at(radians(-45), 100.0)
    assert there.earth_rate_n[2] > 0  # south of the equator the Earth turns upwards about down
    assert there.gravity_n.tolist() == [0, 0, normal_gravity(radians(-45), 100.0)]
    for latitude, height in ((1.6, 0.0), (np.nan, 0.0), (0.0, np.inf)):
        with pytest.raises(InputError, match="place"):
            Place.at(latitude, height)
