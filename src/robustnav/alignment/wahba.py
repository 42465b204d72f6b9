"""Attitude from integrated velocities alone, without a filter or a start: the optimisation-based alignment.

Gravity summed over a while turns, seen from axes that stand still in space, and so does what the accelerometers summed;
the rotation between the two is the attitude.  M. Wu, Y. Wu, X. Hu, D. Hu, "Optimization-based alignment for inertial
navigation systems: theory and algorithm", Aerospace Science and Technology 15(1), 2011; the velocity reference as in
Y. Wu, X. Pan, IEEE Transactions on Aerospace and Electronic Systems 49(2), 2013.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.frames import Array, quat_conjugate, quat_from_rotvec, quat_multiply, quat_normalize, rotate
from robustnav.strapdown.increments import Increments
from robustnav.strapdown.static import Place


def wahba_attitude(increments: Increments, velocity_n: ArrayLike, place: Place) -> Array:
    """Return the attitude ``q_nb`` (4,) at the end of a window.

    Parameters
    ----------
    increments : n of them, without a gap.
    velocity_n : (n + 1, 3) reference velocity in navigation axes at the start and after each of them [m/s].
    place : where; the transport rate is left out.

    Raises
    ------
    InputError : shapes that do not fit, a velocity that is not finite, or fewer than two increments.

    Notes
    -----
    Biases and whatever the reference shows besides the base's own motion go into the answer in full: it is a start.
    """
    v = np.asarray(velocity_n, float)
    n = len(increments)
    if n < 2 or v.shape != (n + 1, 3) or not np.isfinite(v).all():
        raise InputError("reference velocity of a window", got=f"shape {v.shape}", expected=f"finite ({n + 1}, 3)")
    T, w, g = increments.dt, place.earth_rate_n, place.gravity_n
    # Axes that stood still since the start: b0 those of the body, n0 those of navigation.
    to_n0 = quat_from_rotvec(np.outer(T * np.arange(n + 1), w))
    to_b0 = np.empty((n + 1, 4))
    to_b0[0] = [1.0, 0.0, 0.0, 0.0]
    for k in range(n):
        to_b0[k + 1] = quat_normalize(quat_multiply(to_b0[k], increments.rotation[k]))
    seen_b0 = np.cumsum(rotate(to_b0[:-1], increments.velocity), axis=0)
    middle = quat_multiply(to_n0[:-1], np.broadcast_to(quat_from_rotvec(w * T / 2), (n, 4)))
    rate = np.cross(w, (v[1:] + v[:-1]) / 2) - g
    seen_n0 = rotate(to_n0[1:], v[1:]) - v[0] + T * np.cumsum(rotate(middle, rate), axis=0)
    q_n0_b0 = _wahba(seen_n0, seen_b0)
    return quat_normalize(quat_multiply(quat_multiply(quat_conjugate(to_n0[-1]), q_n0_b0), to_b0[-1]))


def _wahba(to: Array, of: Array) -> Array:
    """Return the rotation (4,) that takes vectors ``of`` to ``to`` (n, 3) best, by Davenport's q-method."""
    B = to.T @ of
    z = np.array([B[2, 1] - B[1, 2], B[0, 2] - B[2, 0], B[1, 0] - B[0, 1]])
    K = np.empty((4, 4))
    K[0, 0], K[0, 1:], K[1:, 0] = np.trace(B), z, z
    K[1:, 1:] = B + B.T - np.trace(B) * np.eye(3)
    out: Array = np.linalg.eigh(K)[1][:, -1]
    return out
