"""The swaying carrier: rates, exact increments, headings and places."""

from math import pi, radians

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.frames import matrix_from_quat, quat_conjugate, quat_multiply, rotate, rotvec_from_quat
from robustnav.sim.sway import Sway, Swing, attitude_n, sway_increments
from robustnav.strapdown import Place

SWAY = Sway(Swing(0.1, 0.2, 3.0, 0.4), Swing(0.7, 0.1, 2.0, -1.0), Swing(-0.2, 0.3, 0.5, 2.0))


def test_the_body_rate_is_the_attitude_s_derivative():
    t, h = np.linspace(0, 3, 50), 1e-5
    step = quat_multiply(quat_conjugate(SWAY.attitude(t - h)), SWAY.attitude(t + h))
    np.testing.assert_allclose(SWAY.body_rate(t), rotvec_from_quat(step) / (2 * h), atol=1e-7)


def test_increments_are_the_integrals():
    """Against a quadrature forty times denser, on every sample of a second."""
    n, rate, fine = 200, 200.0, 40
    found = sway_increments(SWAY, n, rate)
    t = (np.arange(n * fine) + 0.5) / (rate * fine)
    rough = SWAY.body_rate(t).reshape(n, fine, 3).mean(axis=1) / rate
    axes = matrix_from_quat(quat_conjugate(SWAY.attitude(t))).reshape(n, fine, 3, 3).mean(axis=1) / rate
    finer = sway_increments(SWAY, 4 * n, 4 * rate)
    np.testing.assert_allclose(found.angle, rough, atol=3e-8)
    np.testing.assert_allclose(found.axes, axes, atol=3e-8)
    np.testing.assert_allclose(found.angle, finer.angle.reshape(n, 4, 3).sum(axis=1), atol=1e-13)
    np.testing.assert_allclose(found.axes, finer.axes.reshape(n, 4, 3, 3).sum(axis=1), atol=1e-13)


def test_heading_and_place_turn_earth_rate_and_gravity():
    heading, place = 2.2, Place.at(radians(-50), 300.0)
    found = sway_increments(SWAY, 100, 500.0).samples(heading, place)
    t = (np.arange(100 * 50) + 0.5) / (500 * 50)
    q_bn = quat_conjugate(attitude_n(SWAY, heading, t))
    rate = SWAY.body_rate(t) + rotate(q_bn, np.broadcast_to(place.earth_rate_n, (len(t), 3)))
    force = rotate(q_bn, np.broadcast_to(-place.gravity_n, (len(t), 3)))
    np.testing.assert_allclose(found.angle, rate.reshape(100, 50, 3).mean(axis=1) / 500, atol=1e-9)
    np.testing.assert_allclose(found.velocity, force.reshape(100, 50, 3).mean(axis=1) / 500, atol=1e-8)
    earth = found.angle - sway_increments(SWAY, 100, 500.0).angle
    np.testing.assert_allclose(np.linalg.norm(earth, axis=1) * 500, 7.292115e-5, rtol=1e-3)


def test_a_heading_of_a_quarter_turn_points_east():
    still = Sway(Swing(), Swing())
    C = matrix_from_quat(attitude_n(still, pi / 2, np.zeros(1))[0])
    np.testing.assert_allclose(C[:, 0], [0, 1, 0], atol=1e-15)


@pytest.mark.parametrize(("n", "rate"), [(0, 100.0), (10, 0.0), (10, np.nan), (10, 50.0)])
def test_a_sway_too_fast_for_its_samples_is_refused(n, rate):
    with pytest.raises(InputError, match="sway"):
        sway_increments(SWAY, n, rate)
