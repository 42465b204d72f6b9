"""The library filterpy (R. Labbe) on our Euler model: the equations by hand in Python, as its users write them."""

from __future__ import annotations

from math import cos, sin, tan
from typing import Any

import numpy as np

from robustnav.frames import Array
from robustnav.model.blocks import Model


class EulerEquations:
    """The equations of ``attitude_euler``: state roll, pitch, yaw [rad] and gyro bias [rad/s].

    The same step as the compiled model (midpoint rule), in blocks of three because half of every matrix is known;
    docs/models.md, section 3.
    """

    def __init__(self, model: Model, dt: float) -> None:
        self.dt = dt
        self.gravity, self.north, self.down = model.parameter_values
        self.gyro_q, bias_q = model.intensities
        self.R = np.diag(np.repeat(model.variances, 3))
        self._F, self._H = np.eye(6), np.zeros((6, 6))
        self._Q = np.diag([0.0, 0.0, 0.0, *[dt * bias_q] * 3])

    def propagate(self, x: Array, u: Array) -> Array:
        """Return the state (6,) after one step of the gyro reading ``u`` (3,)."""
        out = x.copy()
        out[:3] += self.dt * self._rate(*self._middle(x, u), u - x[3:])
        return out

    def transition(self, x: Array, u: Array) -> tuple[Array, Array]:
        """Return F and Q (6, 6) of the step that starts at ``x``; both are overwritten by the next call."""
        dt, w = self.dt, u - x[3:]
        T, A = self._turn(x[0], x[1]), self._slope(x[0], x[1], w)
        roll, pitch = self._middle(x, u)
        T_mid, A_mid = self._turn(roll, pitch), self._slope(roll, pitch, w)
        self._F[:3, :3] = np.eye(3) + dt * (A_mid + dt / 2 * A_mid @ A)
        self._F[:3, 3:] = -dt * (T_mid + dt / 2 * A_mid @ T)
        self._Q[:3, :3] = dt * self.gyro_q * T_mid @ T_mid.T
        return self._F, self._Q

    def measure(self, x: Array) -> Array:
        """Return what accelerometer and magnetometer read at ``x`` (6,)."""
        C = self._C_bn(x)
        return np.concatenate([-self.gravity * C[:, 2], self.north * C[:, 0] + self.down * C[:, 2]])

    def accel(self, x: Array) -> Array:
        """Return what the accelerometer reads at ``x`` (6,)."""
        cp = cos(x[1])
        up = np.array([sin(x[1]), -sin(x[0]) * cp, -cos(x[0]) * cp])
        return np.asarray(self.gravity * up)

    def accel_jacobian(self, x: Array) -> Array:
        """Return the Jacobian (3, 6) of ``accel``."""
        cr, sr, cp, sp = cos(x[0]), sin(x[0]), cos(x[1]), sin(x[1])
        H = np.zeros((3, 6))
        H[:, :2] = self.gravity * np.array([[0.0, cp], [-cr * cp, sr * sp], [sr * cp, cr * sp]])
        return H

    def mag(self, x: Array) -> Array:
        """Return what the magnetometer reads at ``x`` (6,)."""
        C = self._C_bn(x)
        return np.asarray(self.north * C[:, 0] + self.down * C[:, 2])

    def mag_jacobian(self, x: Array) -> Array:
        """Return the Jacobian (3, 6) of ``mag``."""
        return self.jacobian(x)[3:].copy()

    def jacobian(self, x: Array) -> Array:
        """Return the Jacobian (6, 6) of ``measure``; overwritten by the next call."""
        C, cr, sr = self._C_bn(x), cos(x[0]), sin(x[0])
        cp, sp, cy, sy = cos(x[1]), sin(x[1]), cos(x[2]), sin(x[2])
        by_pitch_north = np.array([-sp * cy, sr * cp * cy, cr * cp * cy])
        by_pitch_down = np.array([-cp, -sr * sp, -cr * sp])
        by_yaw_north = np.array([-cp * sy, -sr * sp * sy - cr * cy, -cr * sp * sy + sr * cy])
        by_roll = C[[0, 2, 1]] * np.array([[0.0], [1.0], [-1.0]])
        H = self._H
        H[:3, 0], H[:3, 1] = -self.gravity * by_roll[:, 2], -self.gravity * by_pitch_down
        H[3:, 0] = self.north * by_roll[:, 0] + self.down * by_roll[:, 2]
        H[3:, 1] = self.north * by_pitch_north + self.down * by_pitch_down
        H[3:, 2] = self.north * by_yaw_north
        return H

    def _middle(self, x: Array, u: Array) -> tuple[float, float]:
        rate = self._rate(x[0], x[1], u - x[3:])
        return x[0] + self.dt / 2 * rate[0], x[1] + self.dt / 2 * rate[1]

    def _rate(self, roll: float, pitch: float, w: Array) -> Array:
        sr, cr = sin(roll), cos(roll)
        p, q, r = w
        turning = q * sr + r * cr
        return np.array([p + turning * tan(pitch), q * cr - r * sr, turning / cos(pitch)])

    def _turn(self, roll: float, pitch: float) -> Array:
        sr, cr, tp, over = sin(roll), cos(roll), tan(pitch), 1.0 / cos(pitch)
        return np.array([[1.0, sr * tp, cr * tp], [0.0, cr, -sr], [0.0, sr * over, cr * over]])

    def _slope(self, roll: float, pitch: float, w: Array) -> Array:
        """Return the derivative (3, 3) of the angle rates by the angles."""
        sr, cr, tp, over = sin(roll), cos(roll), tan(pitch), 1.0 / cos(pitch)
        _, q, r = w
        turning, across = q * sr + r * cr, q * cr - r * sr
        return np.array(
            [
                [across * tp, turning * over * over, 0.0],
                [-turning, 0.0, 0.0],
                [across * over, turning * over * tp, 0.0],
            ]
        )

    def _C_bn(self, x: Array) -> Array:
        cr, sr, cp, sp, cy, sy = cos(x[0]), sin(x[0]), cos(x[1]), sin(x[1]), cos(x[2]), sin(x[2])
        return np.array(
            [
                [cp * cy, cp * sy, -sp],
                [sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp],
                [cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp],
            ]
        )


class EulerEkf:
    """filterpy's ``ExtendedKalmanFilter`` as ours works: a predict, then an update a sensor, each linearised anew."""

    rows = 3  # of one update

    def __init__(self, kalman: Any, equations: EulerEquations, x: Array, P: Array) -> None:
        class Filter(kalman.ExtendedKalmanFilter):  # type: ignore[misc]
            def predict_x(self, u: Array) -> None:  # the library's own place for a nonlinear step
                self.x: Array = equations.propagate(self.x, u)

        self.equations, self.filter = equations, Filter(6, self.rows)
        self.R_accel, self.R_mag = equations.R[:3, :3], equations.R[3:, 3:]
        self.filter.R = equations.R[: self.rows, : self.rows]
        self.restart(x, P)

    def restart(self, x: Array, P: Array) -> None:
        """Put state (6,) and covariance (6, 6) back."""
        self.filter.x, self.filter.P = x.copy(), P.copy()

    def step(self, gyro: Array, reading: Array) -> None:
        """Predict with a gyro reading (3,), update with the accelerometer, then with the magnetometer (6,)."""
        own, equations = self.filter, self.equations
        own.F, own.Q = equations.transition(own.x, gyro)
        own.predict(gyro)
        own.update(reading[:3], equations.accel_jacobian, equations.accel, self.R_accel)
        own.update(reading[3:], equations.mag_jacobian, equations.mag, self.R_mag)


class EulerEkfJoint(EulerEkf):
    """The same with one update of six rows: less work, for sensors that always come together."""

    rows = 6

    def step(self, gyro: Array, reading: Array) -> None:
        """Predict with a gyro reading (3,) and update with accelerometer and magnetometer (6,) at once."""
        own, equations = self.filter, self.equations
        own.F, own.Q = equations.transition(own.x, gyro)
        own.predict(gyro)
        own.update(reading, equations.jacobian, equations.measure)


class EulerUkf:
    """filterpy's ``UnscentedKalmanFilter`` with our spread of points (cubature); redraws them once a step."""

    def __init__(self, kalman: Any, equations: EulerEquations, x: Array, P: Array) -> None:
        points = kalman.MerweScaledSigmaPoints(6, alpha=1.0, beta=0.0, kappa=0.0)
        self.equations = equations
        self.filter = kalman.UnscentedKalmanFilter(6, 6, equations.dt, equations.measure, self._move, points)
        self.filter.R = equations.R
        self.restart(x, P)

    def restart(self, x: Array, P: Array) -> None:
        """Put state (6,) and covariance (6, 6) back."""
        self.filter.x, self.filter.P = x.copy(), P.copy()

    def step(self, gyro: Array, reading: Array) -> None:
        """Predict with a gyro reading (3,) and update with accelerometer and magnetometer (6,)."""
        _, self.filter.Q = self.equations.transition(self.filter.x, gyro)
        self.filter.predict(u=gyro)
        self.filter.update(reading)

    def _move(self, x: Array, dt: float, u: Array) -> Array:
        return self.equations.propagate(x, u)
