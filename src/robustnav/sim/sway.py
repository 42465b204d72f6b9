"""A carrier that sways at its mooring: three sines, and the exact increments an inertial unit on it would measure."""

from __future__ import annotations

from dataclasses import dataclass
from math import gcd, pi, sqrt

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import (
    Array,
    matrix_from_quat,
    quat_conjugate,
    quat_from_euler,
    quat_from_rotvec,
    quat_multiply,
    rotate,
)
from robustnav.strapdown.increments import ImuSamples
from robustnav.strapdown.static import Place

# Gauss-Legendre over [0, 1], exact for polynomials of degree 5.
_NODES = (0.5 - sqrt(0.15), 0.5, 0.5 + sqrt(0.15))
_WEIGHTS = (5 / 18, 8 / 18, 5 / 18)
PIECES = 2000  # at most, of a product over all samples


@dataclass(frozen=True)
class Swing:
    """One angle: ``mean + amplitude sin(2 pi frequency_hz t + phase)``, angles in rad."""

    mean: float = 0.0
    amplitude: float = 0.0
    frequency_hz: float = 0.0
    phase: float = 0.0

    def angle(self, t: Array) -> Array:
        """Return the angle [rad] at times [s]."""
        return self.mean + self.amplitude * np.sin(self._argument(t))

    def rate(self, t: Array) -> Array:
        """Return its derivative [rad/s]."""
        return self.amplitude * 2 * pi * self.frequency_hz * np.cos(self._argument(t))

    def _argument(self, t: Array) -> Array:
        return 2 * pi * self.frequency_hz * t + self.phase


@dataclass(frozen=True)
class Sway:
    """Roll, pitch and yaw of a carrier; yaw is counted from axes h: level, turned from n by the heading."""

    roll: Swing
    pitch: Swing
    yaw: Swing = Swing()

    def attitude(self, t: Array) -> Array:
        """Return ``q_hb`` (n, 4) at times (n,) [s]."""
        return quat_from_euler(np.stack([swing.angle(t) for swing in (self.roll, self.pitch, self.yaw)], axis=-1))

    def body_rate(self, t: Array) -> Array:
        """Return the body rate against the ground (n, 3) [rad/s], body axes."""
        roll, pitch = self.roll.angle(t), self.pitch.angle(t)
        p, q, r = (swing.rate(t) for swing in (self.roll, self.pitch, self.yaw))
        turning = r * np.cos(pitch)
        return np.stack(
            [
                p - r * np.sin(pitch),
                q * np.cos(roll) + turning * np.sin(roll),
                turning * np.cos(roll) - q * np.sin(roll),
            ],
            axis=-1,
        )


@dataclass(frozen=True)
class SwayIncrements:
    """What is the same for every heading and place, sample by sample.

    ``angle`` (n, 3): body rate against the ground, integrated [rad]; ``axes`` (n, 3, 3): ``C_bh`` integrated [s];
    ``dt``: sample interval [s].
    """

    angle: Array
    axes: Array
    dt: float

    def samples(self, heading: float, place: Place) -> ImuSamples:
        """Return what an ideal unit measures with its h axes turned by ``heading`` [rad] from north, at a place."""
        q_hn = quat_from_rotvec([0.0, 0.0, -heading])
        earth_rate_h, force_h = rotate(q_hn, place.earth_rate_n), rotate(q_hn, -place.gravity_n)
        # One product of 3 x 3 a sample is slow, and so is one of all: BLAS then wakes threads of its own.
        rows = self.axes.reshape(gcd(len(self.axes), PIECES), -1, 3)
        angle, velocity = ((rows @ vector_h).reshape(-1, 3) for vector_h in (earth_rate_h, force_h))
        angle += self.angle
        return ImuSamples(angle, velocity, self.dt)


def sway_increments(sway: Sway, n: int, rate_hz: float) -> SwayIncrements:
    """Integrate a sway over ``n`` samples at ``rate_hz`` [Hz] by three-point Gauss quadrature.

    The error of a sine of angular rate ``s`` is ``(s dt)^6 / 2e6`` of its increment: rounding, for 10 Hz at 1 kHz.

    Raises
    ------
    InputError : no sample, a rate that is not positive, or a sway too fast for that bound to stay below 1e-9.
    """
    if n < 1 or not 0 < rate_hz < np.inf:
        raise InputError("sway", got=f"{n} samples at {rate_hz} Hz", expected="at least one, at a positive rate")
    fastest = max(sway.roll.frequency_hz, sway.pitch.frequency_hz, sway.yaw.frequency_hz)
    if not (2 * pi * fastest / rate_hz) ** 6 / 2e6 < 1e-9:
        raise InputError(
            "sway", got=f"{fastest} Hz in samples at {rate_hz} Hz", expected="at least 18 samples a period"
        )
    dt, start = 1 / rate_hz, np.arange(n) / rate_hz
    angle, axes = np.zeros((n, 3)), np.zeros((n, 3, 3))
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        t = start + node * dt
        angle += weight * dt * sway.body_rate(t)
        axes += weight * dt * matrix_from_quat(quat_conjugate(sway.attitude(t)))
    return SwayIncrements(angle, axes, dt)


def attitude_n(sway: Sway, heading: float, t: Array) -> Array:
    """Return ``q_nb`` (n, 4) at times (n,) [s] of a carrier whose h axes are turned by ``heading`` [rad]."""
    return quat_multiply(quat_from_rotvec([0.0, 0.0, heading]), sway.attitude(t))
