"""Paths of a carrier in closed form: legs, rests and figures of eight, each from rest to rest.

Every segment runs along its curve by the same polynomial of time, whose first three derivatives vanish at both ends.
Position, velocity, acceleration and jerk are therefore continuous, and with them attitude and body rate.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import pi
from typing import Protocol

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array, quat_conjugate, quat_from_euler, quat_from_matrix, rotate
from robustnav.records import Truth
from robustnav.sim.trajectory import Motion, Vector, check_times, check_vector, even_times, motion_from_attitude


@dataclass(frozen=True)
class States:
    """What a carrier does at ``t`` (n,) [s].

    ``p_n`` [m], ``v_n`` [m/s], ``a_n`` [m/s^2] (n, 3) in NED; ``q_nb`` (n, 4) body FRD to NED; ``omega_b`` (n, 3) body
    rate at ``t`` [rad/s], the Earth's rotation left out; ``f_b`` (n, 3) specific force at ``t`` [m/s^2].
    """

    t: Array
    p_n: Array
    v_n: Array
    a_n: Array
    q_nb: Array
    omega_b: Array
    f_b: Array

    def truth(self, north: str = "magnetic") -> Truth:
        """Return position, velocity and attitude as a reference."""
        return Truth(self.t, self.q_nb, kind="simulated", north=north, p_n=self.p_n, v_n=self.v_n, accuracy="exact")


class Segment(Protocol):
    """A curve p(u), 0 <= u <= 1, taken in ``duration`` [s] while the heading changes by ``turn`` [rad]."""

    @property
    def duration(self) -> float:
        """How long it takes [s]."""
        ...

    @property
    def turn(self) -> float:
        """Change of heading [rad]."""
        ...

    def curve(self, start: Array, u: Array) -> Array:
        """Return p, p', p'', p''' (4, n, 3) [m] at ``u`` (n,) of the curve that begins at ``start`` (3,)."""
        ...


@dataclass(frozen=True)
class Rest:
    """Stay for ``duration`` [s]."""

    duration: float
    turn: float = 0.0

    def curve(self, start: Array, u: Array) -> Array:
        """Return the point where it began, and no derivative."""
        out = np.zeros((4, len(u), 3))
        out[0] = start
        return out


@dataclass(frozen=True)
class Leg:
    """Go straight to the point ``to`` (3,) [m, NED] in ``duration`` [s].

    Raises
    ------
    InputError : ``to`` is not three finite numbers.
    """

    to: Vector
    duration: float
    turn: float = 0.0

    def __post_init__(self) -> None:
        check_vector(self.to, "leg, to")

    def curve(self, start: Array, u: Array) -> Array:
        """Return the straight line and its derivatives."""
        way = np.asarray(self.to) - start
        out = np.zeros((4, len(u), 3))
        out[0], out[1] = start + np.multiply.outer(u, way), way
        return out


@dataclass(frozen=True)
class FigureEight:
    """Fly figures of eight about the point where it begins and ends.

    Parameters
    ----------
    length, width, climb : half extent along north, east and up [m]; the height rises by twice ``climb`` half-way.
    laps : how many, a whole number.
    duration : of all laps [s].
    turn : change of heading [rad].

    Raises
    ------
    InputError : an extent that is not finite, or laps that are no whole number.
    """

    length: float
    width: float
    climb: float
    laps: int
    duration: float
    turn: float = 0.0

    def __post_init__(self) -> None:
        check_vector((self.length, self.width, self.climb), "figure of eight, extents")
        if self.laps < 1 or self.laps != int(self.laps):
            raise InputError("figure of eight, laps", got=str(self.laps), expected="1, 2, 3, ...")

    def curve(self, start: Array, u: Array) -> Array:
        """Return sines of one, two and one turns a lap, with their derivatives."""
        rate = 2 * pi * self.laps * np.array([1.0, 2.0, 1.0])
        angle = np.multiply.outer(u, rate) - [0.0, 0.0, pi / 2]
        size = np.array([self.length, self.width, -self.climb])
        # The k-th derivative of a sine is the sine a quarter of a turn further on.
        out = np.stack([size * rate**k * np.sin(angle + k * pi / 2) for k in range(4)])
        out[0] += start - np.array([0.0, 0.0, self.climb])
        return out


@dataclass(frozen=True)
class Path:
    """A carrier on its way through segments, one after the other; before and after them it rests.

    Parameters
    ----------
    start : (3,) [m, NED].
    heading : at the start [rad].
    segments : in order.
    gravity : [m/s^2], down.
    tilts : True for a multicopter without drag, whose thrust along body up is the only force beside gravity; False for
        a carrier that stays level.

    Raises
    ------
    InputError : no segment, a duration or a number out of its range, or an acceleration that takes away all thrust.
    """

    start: Vector
    heading: float
    segments: tuple[Segment, ...]
    gravity: float
    tilts: bool

    def __post_init__(self) -> None:
        check_vector(self.start, "path, start")
        if not self.segments:
            raise InputError("path", got="no segment", expected="one or more")
        for k, segment in enumerate(self.segments):
            if not (0 < segment.duration < np.inf and np.isfinite(segment.turn)):
                got = f"duration {segment.duration} s, turn {segment.turn} rad"
                raise InputError(f"path, segment {k}", got=got, expected="a duration > 0 and a finite turn")
        if not (np.isfinite(self.heading) and 0 < self.gravity < np.inf):
            got = f"heading {self.heading}, gravity {self.gravity}"
            raise InputError("path", got=got, expected="a finite heading, gravity > 0")

    @property
    def duration(self) -> float:
        """Of all segments [s]."""
        return float(sum(segment.duration for segment in self.segments))

    def at(self, t: Array) -> States:
        """Return the states at ``t`` (n,) [s].

        Raises
        ------
        InputError : a multicopter that falls freely at one of the times: no thrust, no attitude.
        """
        t = np.asarray(t, float)
        move, heading, heading_rate = self._moves(t)
        f_n = move[2] - [0.0, 0.0, self.gravity]
        if self.tilts:
            q_nb, omega_b = _thrust_attitude(f_n, move[3], heading, heading_rate)
        else:
            still = np.zeros_like(heading)
            q_nb = quat_from_euler(np.stack([still, still, heading], axis=1))
            omega_b = np.stack([still, still, heading_rate], axis=1)
        return States(t, move[0], move[1], move[2], q_nb, omega_b, rotate(quat_conjugate(q_nb), f_n))

    def _moves(self, t: Array) -> tuple[Array, Array, Array]:
        """Return position and its derivatives to the jerk (4, n, 3), heading and its rate (n,)."""
        move, heading, rate = np.zeros((4, len(t), 3)), np.zeros(len(t)), np.zeros(len(t))
        for k, (begin, start, course) in enumerate(self._begins()):
            segment = self.segments[k]
            # The first segment also serves the times before it, and a segment the later ones until the next begins.
            here = (t >= begin) | (k == 0)
            s = _eased((t[here] - begin) / segment.duration, segment.duration)
            p0, p1, p2, p3 = segment.curve(start, s[0])
            s1, s2, s3 = s[1:, :, None]
            move[:, here] = p0, p1 * s1, p2 * s1**2 + p1 * s2, p3 * s1**3 + 3 * p2 * s1 * s2 + p1 * s3
            heading[here], rate[here] = course + segment.turn * s[0], segment.turn * s[1]
        return move, heading, rate

    def _begins(self) -> Iterator[tuple[float, Array, float]]:
        """Yield when, where and with which heading each segment begins."""
        begin, start, course = 0.0, np.asarray(self.start, float), self.heading
        for segment in self.segments:
            yield begin, start, course
            begin, course = begin + segment.duration, course + segment.turn
            start = segment.curve(start, np.ones(1))[0, 0]


@dataclass(frozen=True)
class SampledPath:
    """A path sampled by an IMU at ``rate_hz`` [Hz], from time 0 to its end.

    Raises
    ------
    InputError : a rate that is not positive, or less than one interval.
    """

    path: Path
    rate_hz: float

    def __post_init__(self) -> None:
        check_times(self.path.duration, self.rate_hz)

    def states(self) -> States:
        """Return the states at the sample times."""
        return self.path.at(even_times(self.path.duration, self.rate_hz))

    def sample(self) -> Motion:
        """Return the motion for ``sim.batch.simulate``: mean rates over intervals, acceleration at the samples."""
        states = self.states()
        return replace(motion_from_attitude(states.t, states.q_nb), acceleration_n=states.a_n)


def _eased(part: Array, duration: float) -> Array:
    """Return s(t) from 0 to 1 and its first three derivatives by time (4, n); s' goes with x^3 (1 - x)^3."""
    x = np.clip(part, 0.0, 1.0)
    y = 1 - x
    s = x**4 * (35 + x * (-84 + x * (70 - 20 * x)))
    rates = 140 * x**3 * y**3, 420 * x**2 * y**2 * (y - x), 840 * x * y * (1 - 5 * x * y)
    return np.stack([s, *(rate / duration**k for k, rate in enumerate(rates, 1))])


def _thrust_attitude(f_n: Array, jerk_n: Array, heading: Array, heading_rate: Array) -> tuple[Array, Array]:
    """Return q_nb and body rate of a body whose up axis points along ``f_n`` (n, 3) and whose yaw is ``heading``.

    D. Mellinger, V. Kumar, Minimum snap trajectory generation and control for quadrotors, ICRA 2011, section III,
    with the yaw of our Euler angles.
    """
    thrust = np.linalg.norm(f_n, axis=1, keepdims=True)
    weak = np.flatnonzero(thrust[:, 0] < 1e-6)
    if weak.size:
        raise InputError("path", place=f"row {weak[0]}", got="free fall", expected="thrust", do="move more gently")
    down = -f_n / thrust
    down_rate = -(jerk_n - down * np.sum(jerk_n * down, axis=1, keepdims=True)) / thrust
    still = np.zeros_like(heading)
    level_right = np.stack([-np.sin(heading), np.cos(heading), still], axis=1)
    forward = np.cross(level_right, down)
    # Its norm is the cosine of roll; thrust may not point along the level right axis.
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    right = np.cross(down, forward)
    p, q = -np.sum(right * down_rate, axis=1), np.sum(forward * down_rate, axis=1)
    # yaw' = (q sin(roll) + r cos(roll)) / cos(pitch); (sin, cos of roll) cos(pitch) are the down parts of right, down.
    cos_pitch = np.hypot(right[:, 2], down[:, 2])
    r = (heading_rate * cos_pitch**2 - q * right[:, 2]) / down[:, 2]
    return quat_from_matrix(np.stack([forward, right, down], axis=2)), np.stack([p, q, r], axis=1)
