"""The navigation equations on a flight whose sensors were derived in inertial axes."""

from math import cos, radians

import numpy as np
import pytest

from robustnav.earth import SEMI_MAJOR
from robustnav.errors import InputError
from robustnav.frames import rotation_error
from robustnav.strapdown import LATITUDE_LIMIT, ImuSamples, Navigation, Place, navigate


def errors(found, flight, every):
    """Largest error of attitude [rad], velocity [m/s] and position [m]."""
    true = flight.path.rows()[every::every]
    attitude = np.linalg.norm(rotation_error(found.q_nb, true[:, :4]), axis=1).max()
    velocity = np.linalg.norm(found.v_n - true[:, 4:7], axis=1).max()
    off = found.rows()[:, 7:] - true[:, 7:]
    metres = off * np.stack([np.full(len(true), SEMI_MAJOR), SEMI_MAJOR * np.cos(true[:, 7]), np.ones(len(true))], 1)
    return attitude, velocity, np.linalg.norm(metres, axis=1).max()


@pytest.mark.parametrize("start_deg", [40.0, -65.0, 0.0, 88.0])
def test_a_flight_is_followed_at_any_latitude(flight, start_deg):
    one = flight(start_deg, 20.0, 50.0)
    attitude, velocity, position = errors(navigate(one.start, one.samples), one, 1)
    assert attitude < 6e-9
    assert velocity < 2e-6
    assert position < 6e-4


def test_a_shorter_interval_is_better_by_its_square(flight):
    """And so every term of the first order is there: Earth rate, transport rate, Coriolis, gravity, curvature."""
    one = flight(60.0, 10.0, 200.0)
    coarse, fine = (errors(navigate(one.start, one.samples, every), one, every) for every in (40, 20))
    assert all(3.4 < a / b < 4.6 for a, b in zip(coarse, fine, strict=True)), (coarse, fine)


def test_at_rest_nothing_moves():
    place = Place.at(radians(32))
    q = np.array([1.0, 0, 0, 0])
    n, dt = 1000, 0.1
    still = ImuSamples(np.tile(place.earth_rate_n * dt, (n, 1)), np.tile(-place.gravity_n * dt, (n, 1)), dt)
    end = navigate(Navigation(q, np.zeros(3), radians(32), 0.0, 0.0), still)
    assert np.abs(end.v_n).max() < 1e-7  # the Earth's turn in an interval, squared, times gravity: 5e-10 m/s^2
    assert np.linalg.norm(rotation_error(end.q_nb, q), axis=1).max() < 1e-10


def test_the_neighbourhood_of_the_poles_is_refused():
    place = Place.at(radians(89.89))
    n, dt, speed = 200, 0.1, 300.0
    q = np.array([1.0, 0, 0, 0])
    still = ImuSamples(np.tile(place.earth_rate_n * dt, (n, 1)), np.tile(-place.gravity_n * dt, (n, 1)), dt)
    north = Navigation(q, np.array([speed, 0, 0]), radians(89.89), 0.0, 0.0)
    with pytest.raises(InputError, match=r"step \d+, .* from the start") as refused:
        navigate(north, still)
    arrival = (LATITUDE_LIMIT - radians(89.89)) * 6.4e6 / speed
    assert abs(float(refused.value.place.split(",")[1].split()[0]) - arrival) < 1.0
    for latitude in (LATITUDE_LIMIT + 1e-9, -LATITUDE_LIMIT - 1e-9):
        with pytest.raises(InputError, match="start of navigation"):
            navigate(Navigation(q, np.zeros(3), latitude, 0.0, 0.0), still)
    assert cos(LATITUDE_LIMIT) * SEMI_MAJOR == pytest.approx(11e3, rel=0.02)  # metres to the pole


@pytest.mark.parametrize("spoil", [{"q_nb": np.array([1.0, 1, 0, 0])}, {"v_n": np.full(3, np.nan)}, {"height": np.inf}])
def test_a_start_that_is_none_is_refused(spoil):
    still = ImuSamples(np.zeros((2, 3)), np.zeros((2, 3)), 0.1)
    start = {"q_nb": np.array([1.0, 0, 0, 0]), "v_n": np.zeros(3), "latitude": 0.5, "longitude": 0.0, "height": 0.0}
    with pytest.raises(InputError, match="start of navigation"):
        navigate(Navigation(**(start | spoil)), still)
