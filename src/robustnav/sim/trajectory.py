"""Motions as data: each is a small record of parameters, and ``sample()`` gives times, attitude and body rate."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Protocol

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import (
    Array,
    quat_conjugate,
    quat_from_euler,
    quat_from_rotvec,
    quat_multiply,
    rotvec_from_quat,
)
from robustnav.units import DEG, DPS

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Motion:
    """A sampled motion.

    Parameters
    ----------
    t : (n,) evenly spaced seconds, n at least 2.
    q_nb : (n, 4) attitude at ``t``.
    omega_b : (n, 3) mean body rate over the interval that ends at ``t`` [rad/s]: ``q[k] = q[k-1] * Exp(omega[k] dt)``
        exactly.  Row 0, with no interval before it, repeats row 1.
    acceleration_n : (n, 3) acceleration at ``t`` [m/s^2].

    Raises
    ------
    InputError : shapes differ, or the times are not even.
    """

    t: Array
    q_nb: Array
    omega_b: Array
    acceleration_n: Array

    def __post_init__(self) -> None:
        n = len(self.t)
        for name, width in (("q_nb", 4), ("omega_b", 3), ("acceleration_n", 3)):
            if np.shape(getattr(self, name)) != (n, width):
                raise InputError(
                    f"motion, {name}", got=f"shape {np.shape(getattr(self, name))}", expected=f"shape ({n}, {width})"
                )
        step = np.diff(self.t)
        if n < 2 or not np.all(np.abs(step - step.mean()) < 1e-6 * step.mean()):
            raise InputError("motion, t", got=f"{n} times", expected="at least two, evenly spaced and increasing")

    @property
    def rate_hz(self) -> float:
        """Sample rate [Hz]."""
        return (len(self.t) - 1) / float(self.t[-1] - self.t[0])


class Trajectory(Protocol):
    """Anything that can be sampled into a ``Motion``."""

    def sample(self) -> Motion:
        """Return the motion."""
        ...


def motion_from_attitude(t: Array, q_nb: Array) -> Motion:
    """Return the motion without translation through attitudes ``q_nb`` (n, 4) at even times ``t`` (n,) [s].

    Less than half a turn may lie between two samples.
    """
    step = rotvec_from_quat(quat_multiply(quat_conjugate(q_nb[:-1]), q_nb[1:]))
    omega_b = step / np.diff(t)[:, None]
    return Motion(t, q_nb, np.concatenate([omega_b[:1], omega_b]), np.zeros((len(t), 3)))


@dataclass(frozen=True)
class SineAttitude:
    """Roll, pitch and yaw as sines: ``amplitude * sin(frequency * t + phase)``.

    Parameters
    ----------
    amplitude : roll, pitch, yaw [rad].
    frequency : of each angle [rad/s].
    phase : of each angle [rad].
    duration : [s]; the last sample is at ``duration`` when it is a whole number of intervals.
    rate_hz : sample rate [Hz].

    Raises
    ------
    InputError : a number is not finite, or duration and rate make less than one interval.
    """

    amplitude: Vector
    frequency: Vector
    phase: Vector
    duration: float
    rate_hz: float

    def __post_init__(self) -> None:
        for name in ("amplitude", "frequency", "phase"):
            check_vector(getattr(self, name), f"sine attitude, {name}")
        check_times(self.duration, self.rate_hz)

    def sample(self) -> Motion:
        """Return the motion; no translation."""
        t = even_times(self.duration, self.rate_hz)
        angle = np.multiply.outer(t, self.frequency) + self.phase
        return motion_from_attitude(t, quat_from_euler(np.asarray(self.amplitude) * np.sin(angle)))


@dataclass(frozen=True)
class Turn:
    """A turn by ``rotvec`` (body axes, rad; more than a whole turn is allowed) within ``duration`` [s]."""

    rotvec: Vector
    duration: float


@dataclass(frozen=True)
class BodyTurns:
    """Turns about body axes, one after the other, from a level attitude heading north.

    Parameters
    ----------
    turns : in order.
    rate_hz : sample rate [Hz].
    eased : True starts and ends every turn at rest (raised-cosine rate); False turns at a constant rate.

    Raises
    ------
    InputError : no turn, a number that is not finite, or less than one interval in all.
    """

    turns: tuple[Turn, ...]
    rate_hz: float
    eased: bool

    def __post_init__(self) -> None:
        if not self.turns:
            raise InputError("body turns", got="none", expected="at least one turn")
        for k, turn in enumerate(self.turns):
            check_vector(turn.rotvec, f"turn {k}, rotvec")
            if not 0 < turn.duration < np.inf:
                raise InputError(f"turn {k}, duration", got=f"{turn.duration}", expected="a positive number of seconds")
        check_times(sum(turn.duration for turn in self.turns), self.rate_hz)

    def sample(self) -> Motion:
        """Return the motion; no translation."""
        t = even_times(sum(turn.duration for turn in self.turns), self.rate_hz)
        q_nb = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (len(t), 4))
        start = 0.0
        for turn in self.turns:
            part = np.clip((t - start) / turn.duration, 0.0, 1.0)
            if self.eased:
                part = part - np.sin(2 * pi * part) / (2 * pi)
            # A turn not begun is no rotation and one that is over is complete, so the product serves every time.
            q_nb = quat_multiply(q_nb, quat_from_rotvec(np.multiply.outer(part, turn.rotvec)))
            start += turn.duration
        return motion_from_attitude(t, q_nb)


def case_one() -> SineAttitude:
    """Return published case I: slow, angles below 30 deg, 50 s.  Amplitudes, phases and rate are our assumptions."""
    return SineAttitude((20 * DEG, 15 * DEG, 25 * DEG), (pi / 50,) * 3, (0.0, 0.0, 0.0), 50.0, 100.0)


def case_two() -> SineAttitude:
    """Return published case II: fast, angles above 30 deg, 10 s.  Amplitudes, phases and rate are our assumptions."""
    return SineAttitude((50 * DEG, 45 * DEG, 80 * DEG), (pi / 3,) * 3, (0.0, 0.0, 0.0), 10.0, 100.0)


def steady_turn(rate: float = 20 * DPS, duration: float = 180.0, rate_hz: float = 100.0) -> BodyTurns:
    """Return a level turn to the right at a constant ``rate`` [rad/s]."""
    return BodyTurns((Turn((0.0, 0.0, rate * duration), duration),), rate_hz, eased=False)


def full_roll_and_pitch(turn_time: float = 10.0, rate_hz: float = 100.0) -> BodyTurns:
    """Return a full roll, then a full loop (pitch through +90 and -90 deg), each in ``turn_time`` [s]."""
    roll, loop = Turn((2 * pi, 0.0, 0.0), turn_time), Turn((0.0, 2 * pi, 0.0), turn_time)
    return BodyTurns((roll, loop), rate_hz, eased=True)


def even_times(duration: float, rate_hz: float) -> Array:
    """Return times 0, 1 / rate_hz, ... up to ``duration`` [s], which is the last where it is one of them."""
    # A duration such as 0.29 s at 100 Hz is 28.999999999999996 intervals in floating point and means 29.
    return np.arange(int(duration * rate_hz + 1e-6) + 1) / rate_hz


def check_times(duration: float, rate_hz: float) -> None:
    """Raise ``InputError`` unless both are positive and ``duration`` [s] holds an interval at ``rate_hz``."""
    if not (0 < duration < np.inf and 0 < rate_hz < np.inf and duration * rate_hz >= 1):
        raise InputError(
            "trajectory",
            got=f"duration {duration} s, rate {rate_hz} Hz",
            expected="positive numbers with at least one interval in the duration",
        )


def check_vector(value: Vector, thing: str) -> None:
    """Raise ``InputError`` unless ``value`` is three finite numbers."""
    if np.shape(value) != (3,) or not np.all(np.isfinite(value)):
        raise InputError(thing, got=str(value), expected="three finite numbers")
