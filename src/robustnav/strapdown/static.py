"""The step of a carrier that sways at one place, and the way back through stored increments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robustnav.earth import earth_rate_n, normal_gravity
from robustnav.errors import InputError
from robustnav.frames import Array, quat_conjugate, quat_from_rotvec, quat_multiply, quat_normalize, rotate
from robustnav.strapdown.increments import Increments

_NO_BIAS = (np.zeros(3), np.zeros(3))


@dataclass(frozen=True)
class Place:
    """Where the carrier is: the Earth's rate (3,) [rad/s] and gravity (3,) [m/s^2], both in navigation axes."""

    earth_rate_n: Array
    gravity_n: Array

    @classmethod
    def at(cls, latitude: float, height: float = 0.0) -> Place:
        """Return the place at a geodetic ``latitude`` [rad] and ``height`` above the WGS-84 ellipsoid [m].

        Raises
        ------
        InputError : a latitude beyond the poles, or a height that is not finite.
        """
        if not (abs(latitude) <= np.pi / 2 and np.isfinite(height)):
            raise InputError(
                "place", got=f"latitude {latitude} rad, height {height} m", expected="a place on the Earth"
            )
        return cls(earth_rate_n(latitude), np.array([0.0, 0.0, normal_gravity(latitude, height)]))


def carry(
    q_nb: Array, v_n: Array, increments: Increments, place: Place, bias: tuple[Array, Array] | None = None
) -> tuple[Array, Array]:
    """Carry attitude and velocity over intervals at one place; the transport rate is left out.

    ``v <- v + a + T (g - 2 w x v - w x a / 2)``, ``q <- Exp(-w T) * q * dq`` with ``a = C_nb`` times the velocity
    increment, ``w`` the Earth's rate, ``T`` the interval.

    Parameters
    ----------
    q_nb, v_n : attitude (4,) and velocity (3,) [m/s] at the start.
    increments : n of them.
    place : where.
    bias : gyro bias [rad/s] and accelerometer bias [m/s^2], each (3,) or (n, 3), taken off the increments; or None.

    Returns
    -------
    ``q_nb`` (n + 1, 4) and ``v_n`` (n + 1, 3), the start first.
    """
    rotation, velocity = increments.corrected(*(bias or _NO_BIAS))
    T, w = increments.dt, place.earth_rate_n
    frame_turn = quat_from_rotvec(-w * T)
    q, v = np.empty((len(increments) + 1, 4)), np.empty((len(increments) + 1, 3))
    q[0], v[0] = q_nb, v_n
    for k in range(len(increments)):
        a = rotate(q[k], velocity[k])
        v[k + 1] = v[k] + a + T * (place.gravity_n - np.cross(w, 2 * v[k] + a / 2))
        q[k + 1] = quat_normalize(quat_multiply(quat_multiply(frame_turn, q[k]), rotation[k]))
    return q, v


def backtrack(q_nb: Array, increments: Increments, place: Place, gyro_bias: Array | None = None) -> Array:
    """Return the attitude ``q_nb`` (4,) at the start of stored increments from that at their end.

    ``C(0) = Exp(w t) C(t) [prod Exp(-J bias) dC]'``, the exact inverse of ``carry``.

    Parameters
    ----------
    q_nb : attitude (..., 4) at the end.
    increments, place : as for ``carry``.
    gyro_bias : (3,) or (n, 3) [rad/s], or None.
    """
    rotation, _ = increments.corrected(_NO_BIAS[0] if gyro_bias is None else gyro_bias, _NO_BIAS[1])
    back = quat_from_rotvec(place.earth_rate_n * increments.dt * len(increments))
    return quat_normalize(quat_multiply(quat_multiply(back, q_nb), quat_conjugate(_product(rotation))))


def _product(q: Array) -> Array:
    """Return the product (4,) of quaternions (n, 4) in their order, by halves so that rounding does not pile up."""
    while len(q) > 1:
        odd = q[len(q) - len(q) % 2 :]
        q = np.concatenate([quat_multiply(q[: len(q) - len(odd) : 2], q[1::2]), odd])
    whole: Array = q[0]
    return whole
