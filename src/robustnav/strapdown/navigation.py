"""Navigation equations in north-east-down on WGS-84: Earth rate, transport rate, Coriolis, normal gravity.

P. D. Groves, "Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems", 2nd ed., section 5.4;
docs/strapdown.md, section 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin, sqrt, tan

import numpy as np

from robustnav.earth import ECCENTRICITY_SQUARED, SEMI_MAJOR, earth_rate_n, normal_gravity
from robustnav.errors import InputError
from robustnav.frames import Array, matrix_from_quat, quat_from_rotvec, quat_multiply, quat_normalize
from robustnav.strapdown.increments import ImuSamples
from robustnav.strapdown.preintegration import preintegrate
from robustnav.units import DEG

LATITUDE_LIMIT = 89.9 * DEG  # rad; 11 km from a pole, where north turns too fast for north-east-down axes
SIZE = 10  # numbers of a state: attitude 4, velocity 3, latitude, longitude, height


@dataclass(frozen=True)
class Navigation:
    """Attitude, velocity and position, at one instant or along a path (leading axis).

    Parameters
    ----------
    q_nb : (..., 4) body FRD to north-east-down at the place.
    v_n : (..., 3) velocity against the ground [m/s].
    latitude, longitude : geodetic [rad]; longitude is continuous, not wrapped.
    height : above the WGS-84 ellipsoid [m].
    """

    q_nb: Array
    v_n: Array
    latitude: Array | float
    longitude: Array | float
    height: Array | float

    def rows(self) -> Array:
        """Return the numbers (..., 10) in the order of the fields."""
        position = np.stack([self.latitude, self.longitude, self.height], axis=-1)
        return np.concatenate([self.q_nb, self.v_n, position], axis=-1)

    @classmethod
    def from_rows(cls, rows: Array) -> Navigation:
        """Return the record of numbers (..., 10)."""
        return cls(rows[..., :4], rows[..., 4:7], rows[..., 7], rows[..., 8], rows[..., 9])


def navigate(start: Navigation, samples: ImuSamples, every: int = 1, history: Array | None = None) -> Navigation:
    """Integrate inertial samples to attitude, velocity and position.

    Parameters
    ----------
    start : at one instant.
    samples : n of them, their biases taken off.
    every : samples a navigation step; must divide n.  Coning and sculling are kept whatever it is.
    history : as for ``preintegrate``.

    Returns
    -------
    The path at the end of every step (n / every rows).

    Raises
    ------
    InputError : as ``preintegrate``; a start that is not finite; a latitude beyond ``LATITUDE_LIMIT``, naming the step.
    """
    state, steps = checked_start(start), preintegrate(samples, every, history)
    out = np.empty((len(steps), SIZE))
    for k in range(len(steps)):
        state = out[k] = _step(state, steps.rotation[k], steps.velocity[k], steps.dt)
        if not abs(state[7]) <= LATITUDE_LIMIT:
            raise beyond_the_limit(k, steps.dt)
    return Navigation.from_rows(out)


def checked_start(start: Navigation) -> Array:
    """Return the numbers (10,) of a start, its quaternion of unit norm; errors as for ``navigate``."""
    row = start.rows()
    if row.shape != (SIZE,) or not np.isfinite(row).all() or abs(np.linalg.norm(row[:4]) - 1) > 1e-6:
        raise InputError("start of navigation", got=str(row), expected="one instant, finite numbers, a unit quaternion")
    if abs(row[7]) > LATITUDE_LIMIT:
        raise InputError(
            "start of navigation", got=f"latitude {row[7] / DEG} deg", expected=f"within {LATITUDE_LIMIT / DEG:g} deg"
        )
    return row


def beyond_the_limit(step: int, dt: float) -> InputError:
    """Return the error of a path that left the latitudes where north-east-down axes serve, after ``step``."""
    return InputError(
        "navigation in north-east-down axes",
        place=f"step {step}, {(step + 1) * dt:g} s from the start",
        got="a latitude beyond the limit, or numbers that are not finite",
        expected=f"latitudes within {LATITUDE_LIMIT / DEG:g} deg: north turns too fast about a pole",
        do="check the start and the samples' units; stop the path before the pole",
    )


def _step(state: Array, rotation: Array, velocity: Array, T: float) -> Array:
    """Return the state (10,) after an interval: midpoint rule, the specific force uniform over the interval."""
    q, v, (latitude, longitude, height) = state[:4], state[4:7], state[7:]
    a = matrix_from_quat(q) @ velocity
    meridian, transverse = _radii(latitude, height)
    middle, middle_height = latitude + T / 2 * v[0] / meridian, height - T / 2 * v[2]
    meridian, transverse = _radii(middle, middle_height)
    w_ie, gravity = earth_rate_n(middle), np.array([0.0, 0.0, normal_gravity(middle, middle_height)])

    def transport(v: Array) -> Array:
        return np.array([v[1] / transverse, -v[0] / meridian, -v[1] * tan(middle) / transverse])

    v_mid = v + (a + T * (gravity - np.cross(2 * w_ie + transport(v), v))) / 2
    w_en = transport(v_mid)
    w_in = w_ie + w_en
    v_end = v + a + T * (gravity - np.cross(w_in, a) / 2 - np.cross(2 * w_ie + w_en, v_mid))
    north, east, down = T * (v + v_end) / 2
    q_end = quat_normalize(quat_multiply(quat_multiply(quat_from_rotvec(-w_in * T), q), rotation))
    position = [latitude + north / meridian, longitude + east / (transverse * cos(middle)), height - down]
    return np.concatenate([q_end, v_end, position])


def _radii(latitude: float, height: float) -> tuple[float, float]:
    """Return the distances [m] from a point to the centres of curvature along the meridian and across it."""
    under = 1 - ECCENTRICITY_SQUARED * sin(latitude) ** 2
    transverse = SEMI_MAJOR / sqrt(under)
    return transverse * (1 - ECCENTRICITY_SQUARED) / under + height, transverse + height
