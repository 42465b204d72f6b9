"""What an ideal gyro and an ideal accelerometer would read along a motion."""

from __future__ import annotations

from robustnav.frames import Array, quat_conjugate, rotate
from robustnav.sim.trajectory import Motion


def true_gyro(motion: Motion) -> Array:
    """Return the mean body rate (n, 3) [rad/s] over each interval; the Earth's rotation is left out."""
    return motion.omega_b


def true_specific_force(motion: Motion, gravity: float) -> Array:
    """Return specific force ``f_b = C_bn (a_n - g_n)`` (n, 3) [m/s^2]; ``gravity`` [m/s^2] points down."""
    return rotate(quat_conjugate(motion.q_nb), motion.acceleration_n - [0.0, 0.0, gravity])
