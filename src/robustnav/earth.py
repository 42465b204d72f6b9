"""The Earth as sensors feel it: WGS-84 normal gravity, rotation rate and magnetic field."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, degrees, hypot, sin, sqrt

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.frames import Array
from robustnav.units import NANO_TESLA

EARTH_RATE = 7.292115e-5  # rad/s, WGS-84
SEMI_MAJOR = 6378137.0  # m, WGS-84
FLATTENING = 1 / 298.257223563
ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)
GRAVITY_EQUATOR = 9.7803253359  # m/s^2, WGS-84 (NIMA TR8350.2, table 3.4)
_SOMIGLIANA = 0.00193185265241
_M = 0.00344978650684  # omega^2 a^2 b / GM


def normal_gravity(latitude: float, height: float = 0.0) -> float:
    """Return WGS-84 normal gravity [m/s^2] at geodetic ``latitude`` [rad] and ``height`` above the ellipsoid [m].

    Somigliana's formula with the second-order height term; NIMA TR8350.2, equations 4-1 and 4-3.
    """
    s2 = sin(latitude) ** 2
    surface = GRAVITY_EQUATOR * (1 + _SOMIGLIANA * s2) / sqrt(1 - ECCENTRICITY_SQUARED * s2)
    ratio = height / SEMI_MAJOR
    return surface * (1 - 2 * (1 + FLATTENING + _M - 2 * FLATTENING * s2) * ratio + 3 * ratio * ratio)


def earth_rate_n(latitude: float) -> Array:
    """Return the Earth's rotation rate (3,) [rad/s] in NED at geodetic ``latitude`` [rad]."""
    return EARTH_RATE * np.array([cos(latitude), 0.0, -sin(latitude)])


@dataclass(frozen=True)
class MagneticField:
    """Magnetic field at a place: ``vector_n`` (3,) in NED [T], declination east positive, dip down positive."""

    vector_n: Array

    @property
    def norm(self) -> float:
        """Field strength [T]."""
        return float(np.linalg.norm(self.vector_n))

    @property
    def declination_deg(self) -> float:
        """Angle from true to magnetic north, east positive [deg]."""
        return degrees(atan2(self.vector_n[1], self.vector_n[0]))

    @property
    def dip_deg(self) -> float:
        """Angle of the field below the horizon [deg]."""
        return degrees(atan2(self.vector_n[2], hypot(self.vector_n[0], self.vector_n[1])))


def magnetic_field(latitude_deg: float, longitude_deg: float, height: float, year: float) -> MagneticField:
    """Return the World Magnetic Model's field.

    Parameters
    ----------
    latitude_deg, longitude_deg : geodetic position [deg].
    height : above the ellipsoid [m].
    year : decimal year, within the models shipped with pygeomag (2010 to 2030).

    Raises
    ------
    InputError : a latitude or a year outside the model.
    """
    from pygeomag import GeoMag

    files = {
        2010: "wmm/WMM_2010.COF",
        2015: "wmm/WMM_2015v2.COF",
        2020: "wmm/WMM_2020.COF",
        2025: "wmm/WMM_2025.COF",
    }
    if not 2010 <= year < 2030:
        raise InputError("year of the magnetic model", got=f"{year}", expected="2010 to 2030")
    if not -90 <= latitude_deg <= 90:
        raise InputError("latitude", got=f"{latitude_deg} deg", expected="-90 to 90 deg")
    model = GeoMag(coefficients_file=files[int(year // 5) * 5])
    result = model.calculate(glat=latitude_deg, glon=longitude_deg, alt=height / 1000.0, time=year)
    return MagneticField(np.array([result.x, result.y, result.z]) * NANO_TESLA)


def ecef_from_geodetic(place: ArrayLike) -> Array:
    """Return positions (..., 3) [m] in Earth-centred Earth-fixed axes of geodetic places.

    Parameters
    ----------
    place : (..., 3) latitude [rad], longitude [rad], height above the ellipsoid [m].

    NIMA TR8350.2, equation 4-14.
    """
    latitude, longitude, height = np.moveaxis(np.asarray(place, float), -1, 0)
    normal = SEMI_MAJOR / np.sqrt(1 - ECCENTRICITY_SQUARED * np.sin(latitude) ** 2)
    level = (normal + height) * np.cos(latitude)
    up = (normal * (1 - ECCENTRICITY_SQUARED) + height) * np.sin(latitude)
    return np.stack([level * np.cos(longitude), level * np.sin(longitude), up], axis=-1)


def ned_from_geodetic(place: ArrayLike, origin: ArrayLike) -> Array:
    """Return positions (..., 3) [m] north, east and down of ``origin``, in the axes that are level there.

    Straight axes: 1 km off they are 0.08 m, 10 km off 8 m above the level surface through the origin.

    Parameters
    ----------
    place : (..., 3) latitude [rad], longitude [rad], height above the ellipsoid [m].
    origin : (3,) likewise.
    """
    latitude, longitude, _ = np.asarray(origin, float)
    sl, cl, so, co = np.sin(latitude), np.cos(latitude), np.sin(longitude), np.cos(longitude)
    C_ne = np.array([[-sl * co, -sl * so, cl], [-so, co, 0.0], [-cl * co, -cl * so, -sl]])
    out: Array = (ecef_from_geodetic(place) - ecef_from_geodetic(origin)) @ C_ne.T
    return out
