"""The published alignment model in NumPy as users of filterpy write it, and filterpy's unscented filter on it."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np

from robustnav.filter.ukf import Spread
from robustnav.frames import Array, skew
from robustnav.model.blocks import Model

V, Q, GYRO, ACCEL = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)  # of the state


class AlignmentEquations:
    """The equations of ``robustnav.models.alignment``: state velocity, quaternion, gyro bias, accelerometer bias."""

    def __init__(self, model: Model, dt: float) -> None:
        gravity, north, down = model.parameter_values
        earth_rate_n = np.array([north, 0.0, down])
        self.dt, self.variance = dt, float(model.variances[0])
        self.gyro_q, self.accel_q, self.gyro_bias_q, self.accel_bias_q = model.intensities
        self._fall = np.array([0.0, 0.0, gravity * dt])
        self._coriolis = dt * skew(earth_rate_n)
        self._earth = _left(_increment(-earth_rate_n * dt))

    def propagate(self, x: Array, u: Array) -> Array:
        """Return the state (13,) after the increments ``u`` (25,)."""
        turn_by_bias, velocity_by_bias = u[7:16].reshape(3, 3), u[16:].reshape(3, 3)
        turn = _left(_increment(-turn_by_bias @ x[GYRO])) @ u[:4]
        a = _scaled_matrix(x[Q]) @ (u[4:7] - turn_by_bias @ x[ACCEL] - velocity_by_bias @ x[GYRO])
        out = x.copy()
        out[V] += a + self._fall - self._coriolis @ (a / 2 + 2 * x[V])
        out[Q] = _left(self._earth @ x[Q]) @ turn
        return out

    def noise(self, x: Array) -> Array:
        """Return the process noise (13, 13) of a step from ``x`` (13,)."""
        q, out = x[Q], np.zeros((13, 13))
        out[V, V] = self.accel_q * np.eye(3)
        out[Q, Q] = self.gyro_q / 4 * (q @ q * np.eye(4) - np.outer(q, q))
        out[GYRO, GYRO], out[ACCEL, ACCEL] = self.gyro_bias_q * np.eye(3), self.accel_bias_q * np.eye(3)
        return self.dt * out


class AlignmentUkf:
    """filterpy's ``UnscentedKalmanFilter`` on these equations, with our spread of points."""

    def __init__(self, kalman: Any, equations: AlignmentEquations, spread: Spread) -> None:
        points = kalman.MerweScaledSigmaPoints(13, alpha=spread.alpha, beta=spread.beta, kappa=spread.kappa)
        self.equations = equations
        self.filter = kalman.UnscentedKalmanFilter(13, 3, equations.dt, _measure, self._move, points)
        self.filter.R = equations.variance * np.eye(3)

    def restart(self, x: Array, P: Array) -> None:
        """Put state (13,) and covariance (13, 13) back."""
        self.filter.x, self.filter.P = x.copy(), P.copy()

    def step(self, increments: Array, velocity: Array) -> None:
        """Predict with increments (25,) and update with a velocity (3,)."""
        self.filter.Q = self.equations.noise(self.filter.x)
        self.filter.predict(u=increments)
        self.filter.update(velocity)

    def _move(self, x: Array, dt: float, u: Array) -> Array:
        return self.equations.propagate(x, u)


def _measure(x: Array) -> Array:
    return x[V]


def _increment(phi: Array) -> Array:
    """Return the quaternion (4,) of a small turn, to fourth order in the angle."""
    square = float(phi @ phi)
    return np.array([1 - square / 8 + square**2 / 384, *(phi * (0.5 - square / 48))])


def _left(q: Array) -> Array:
    """Return the matrix (4, 4) that takes p to q * p."""
    w, x, y, z = q.tolist()
    return np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])


def _scaled_matrix(q: Array) -> Array:
    """Return C(Q) (3, 3): a rotation times the square of the length."""
    w, x, y, z = (q * sqrt(2.0)).tolist()
    half = (w * w + x * x + y * y + z * z) / 2
    return np.array(
        [
            [w * w + x * x - half, x * y - w * z, x * z + w * y],
            [x * y + w * z, w * w + y * y - half, y * z - w * x],
            [x * z - w * y, y * z + w * x, w * w + z * z - half],
        ]
    )
