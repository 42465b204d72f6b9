"""Gravity, rotation and field against published figures and against other derivations of the same."""

from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav import earth
from robustnav.errors import InputError
from robustnav.units import NANO_TESLA

LATITUDES = st.floats(-np.pi / 2, np.pi / 2)


@pytest.mark.parametrize(
    ("latitude_deg", "published"),
    [(0, 9.7803253359), (90, 9.8321849379), (-90, 9.8321849379), (45, 9.8061977693)],
)
def test_normal_gravity_at_the_surface(latitude_deg, published):
    assert earth.normal_gravity(radians(latitude_deg)) == pytest.approx(published, abs=1e-10)


@given(LATITUDES)
def test_gravity_is_symmetric_and_between_equator_and_pole(latitude):
    gravity = earth.normal_gravity(latitude)
    assert gravity == earth.normal_gravity(-latitude)
    assert earth.GRAVITY_EQUATOR <= gravity <= 9.8321849379 + 1e-10


@pytest.mark.parametrize("latitude_deg", [0.0, 47.4, 90.0])
def test_height_lowers_gravity_like_an_inverse_square(latitude_deg):
    latitude = radians(latitude_deg)
    surface, step = earth.normal_gravity(latitude), 1.0
    slope = (earth.normal_gravity(latitude, step) - earth.normal_gravity(latitude, -step)) / (2 * step)
    assert slope == pytest.approx(-3.086e-6, rel=0.002)  # free-air gradient
    # The centrifugal part apart, gravity falls with the square of the distance from the centre.
    radius = 6371e3
    for height in (1e3, 1e4, 5e4):
        expected = surface * (radius / (radius + height)) ** 2
        assert earth.normal_gravity(latitude, height) == pytest.approx(expected, rel=1e-4)


@given(LATITUDES)
def test_earth_rate_has_its_size_and_points_to_the_pole(latitude):
    rate = earth.earth_rate_n(latitude)
    assert np.linalg.norm(rate) == pytest.approx(7.292115e-5, rel=1e-14)
    assert rate[1] == 0
    assert np.arctan2(-rate[2], rate[0]) == pytest.approx(latitude, abs=1e-12)


def test_world_magnetic_model_at_zurich():
    field = earth.magnetic_field(47.397742, 8.545594, 488.0, 2026.0)
    assert field.declination_deg == pytest.approx(3.547, abs=5e-4)
    assert field.dip_deg == pytest.approx(63.520, abs=5e-4)
    assert field.norm == pytest.approx(48363.7 * NANO_TESLA, abs=0.05 * NANO_TESLA)


# NOAA, WMM2020 test values: date, height [km], latitude, longitude, X, Y, Z [nT]
@pytest.mark.parametrize(
    ("year", "height_km", "latitude", "longitude", "published"),
    [
        (2020.0, 0, 80, 0, (6570.4, -146.3, 54606.0)),
        (2020.0, 0, 0, 120, (39624.3, 109.9, -10932.5)),
        (2020.0, 0, -80, 240, (5940.6, 15772.1, -52480.8)),
        (2020.0, 100, 80, 0, (6261.8, -185.5, 52429.1)),
        (2022.5, 0, 80, 0, (6529.9, 1.1, 54713.4)),
    ],
)
def test_field_against_published_test_values(year, height_km, latitude, longitude, published):
    field = earth.magnetic_field(latitude, longitude, 1000.0 * height_km, year)
    np.testing.assert_allclose(field.vector_n / NANO_TESLA, published, atol=0.1)


def test_angles_of_a_field_by_hand():
    field = earth.MagneticField(np.array([3.0, 4.0, 5.0]))
    assert field.norm == pytest.approx(50**0.5)
    assert field.declination_deg == pytest.approx(53.13010235)
    assert field.dip_deg == pytest.approx(45.0)


@pytest.mark.parametrize("year", [2009.999, 2030.0, float("nan"), float("inf")])
def test_a_year_without_a_model_is_refused(year):
    with pytest.raises(InputError, match="year"):
        earth.magnetic_field(0, 0, 0, year)


@pytest.mark.parametrize("latitude", [-90.001, 91.0, float("nan")])
def test_a_latitude_off_the_globe_is_refused(latitude):
    with pytest.raises(InputError, match="latitude"):
        earth.magnetic_field(latitude, 0, 0, 2026.0)


@pytest.mark.parametrize("year", [2010.0, 2014.99, 2015.0, 2024.99, 2025.0, 2029.99])
def test_every_year_from_2010_has_a_model(year):
    assert 40e-6 < earth.magnetic_field(47, 8, 0, year).norm < 60e-6


PLACES = st.tuples(st.floats(-1.5, 1.5), st.floats(-3.1, 3.1), st.floats(-100, 9000))


def test_ecef_of_known_places():
    half = earth.SEMI_MAJOR * (1 - earth.FLATTENING)  # the semi-minor axis
    for place, expected in (((0, 0, 0), (earth.SEMI_MAJOR, 0, 0)), ((np.pi / 2, 1.0, 10), (0, 0, half + 10))):
        np.testing.assert_allclose(earth.ecef_from_geodetic(place), expected, atol=1e-8)


@given(PLACES)
def test_ned_steps_are_along_the_ellipsoid_and_its_normal(origin):
    latitude, _, height = origin
    s2 = np.sin(latitude) ** 2
    ratio = 1 - earth.ECCENTRICITY_SQUARED * s2
    meridian = earth.SEMI_MAJOR * (1 - earth.ECCENTRICITY_SQUARED) / ratio**1.5
    normal = earth.SEMI_MAJOR / ratio**0.5
    metres = np.array([1.0 / (meridian + height), 1.0 / ((normal + height) * np.cos(latitude)), -1.0])
    p_n = earth.ned_from_geodetic(np.asarray(origin) + np.diag(metres), origin)
    np.testing.assert_allclose(p_n, np.eye(3), atol=3e-6)


@given(PLACES, PLACES)
def test_ned_keeps_distances(place, origin):
    away = earth.ecef_from_geodetic(place) - earth.ecef_from_geodetic(origin)
    assert np.linalg.norm(earth.ned_from_geodetic(place, origin)) == pytest.approx(np.linalg.norm(away), abs=1e-6)
