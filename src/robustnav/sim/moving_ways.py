"""Ways of carriers that move, drawn at random: a drone between points, already under way, and a car in traffic."""

from __future__ import annotations

from math import pi

import numpy as np

from robustnav.errors import InputError
from robustnav.frames import Array, quat_conjugate, quat_from_euler, rotate
from robustnav.sim.ranging_path import Leg, Path, States
from robustnav.sim.trajectory import check_times, even_times, motion_from_attitude
from robustnav.units import DEG, STANDARD_GRAVITY

_LEG = 5.0  # s between two points of the drone
_TURNS = (6.0, 12.0)  # s between two turns of the car
_TURN_TIME = 2.5  # s, time constant of a turn


def drone_way(seed: int, duration: float, rate_hz: float) -> States:
    """Return a multicopter that flies from point to point with its nose anywhere, and is on its way at time 0.

    Up to 6 m/s, 5 m/s^2 and 30 deg of tilt.

    Parameters
    ----------
    seed : fixes the way.
    duration, rate_hz : [s], [Hz].

    Raises
    ------
    InputError : less than one interval.
    """
    check_times(duration, rate_hz)
    rng = np.random.default_rng([seed, 11])
    legs, p = [], np.array([0.0, 0.0, -20.0])
    for _ in range(int(duration / _LEG) + 2):
        course, length = rng.uniform(-pi, pi), rng.uniform(6.0, 14.0)
        p = p + np.array([length * np.cos(course), length * np.sin(course), rng.uniform(-2.0, 2.0)])
        legs.append(Leg((float(p[0]), float(p[1]), float(p[2])), _LEG, float(rng.uniform(-1.0, 1.0))))
    path = Path((0.0, 0.0, -20.0), float(rng.uniform(-pi, pi)), tuple(legs), STANDARD_GRAVITY, tilts=True)
    t = even_times(duration, rate_hz)
    one = path.at(t + rng.uniform(0.25, 0.6) * _LEG)
    return States(t, one.p_n, one.v_n, one.a_n, one.q_nb, one.omega_b, one.f_b)


def car_way(seed: int, duration: float, rate_hz: float) -> States:
    """Return a car on hilly roads that turns at crossings, speeds up and brakes, leans and dives.

    4 m/s to 12 m/s, up to 4 m/s^2; parameters as of ``drone_way``.
    """
    check_times(duration, rate_hz)
    rng = np.random.default_rng([seed, 13])
    t = even_times(duration, rate_hz)
    phase, slope = rng.uniform(-pi, pi, 2)
    speed, speed_rate = _sine(t, 8.0, 4.0, 22.0, phase)
    grade, grade_rate = _sine(t, 0.0, 3 * DEG, 35.0, slope)
    course, course_rate = _turns(t, rng)
    forward = np.stack([np.cos(grade) * np.cos(course), np.cos(grade) * np.sin(course), -np.sin(grade)], axis=1)
    along = np.stack([-np.sin(grade) * np.cos(course), -np.sin(grade) * np.sin(course), -np.cos(grade)], axis=1)
    right = np.stack([-np.sin(course), np.cos(course), np.zeros_like(t)], axis=1)
    aside = speed * np.cos(grade) * course_rate
    v_n = speed[:, None] * forward
    a_n = speed_rate[:, None] * forward + (speed * grade_rate)[:, None] * along + aside[:, None] * right
    lean, dive = -0.5 * DEG * aside, 0.4 * DEG * speed_rate
    q_nb = quat_from_euler(np.stack([lean, grade + dive, course], axis=1))
    p_n = np.vstack([np.zeros(3), np.cumsum((v_n[1:] + v_n[:-1]) / 2, axis=0) / rate_hz])
    omega_b = motion_from_attitude(t, q_nb).omega_b
    return States(t, p_n, v_n, a_n, q_nb, omega_b, rotate(quat_conjugate(q_nb), a_n - [0.0, 0.0, STANDARD_GRAVITY]))


WAYS = {"drone": drone_way, "car": car_way}


def way(name: str, seed: int, duration: float, rate_hz: float) -> States:
    """Return a way by its name in ``WAYS``.

    Raises
    ------
    InputError : another name.
    """
    if name not in WAYS:
        raise InputError("way of a carrier", got=repr(name), expected=", ".join(WAYS))
    return WAYS[name](seed, duration, rate_hz)


def _sine(t: Array, middle: float, size: float, period: float, phase: float) -> tuple[Array, Array]:
    """Return a sine about a middle value, and its rate."""
    rate = 2 * pi / period
    return middle + size * np.sin(rate * t + phase), size * rate * np.cos(rate * t + phase)


def _turns(t: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return a course [rad] that turns by right angles or less, now left, now right, and its rate."""
    course, rate = np.full_like(t, rng.uniform(-pi, pi)), np.zeros_like(t)
    at = rng.uniform(0.0, _TURNS[1])
    while at < t[-1] + 3 * _TURN_TIME:
        angle = rng.choice([-1.0, 1.0]) * rng.uniform(30.0, 90.0) * DEG
        part = np.tanh((t - at) / _TURN_TIME)
        course = course + angle * (1 + part) / 2
        rate = rate + angle * (1 - part**2) / (2 * _TURN_TIME)
        at += rng.uniform(*_TURNS)
    return course, rate
