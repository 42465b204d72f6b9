"""Runs of the gyrocompass study: a base that trembles, sways or stands in the wind, the peer, and what is possible."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, hypot, pi, sin, sqrt, tan

import numpy as np

from robustnav.alignment import Alignment, AlignSetup, align
from robustnav.engine.strapdown import preintegrate
from robustnav.errors import InputError
from robustnav.frames import Array, euler_from_quat, quat_conjugate, rotate, rotvec_from_quat, skew, wrap_angle
from robustnav.sim.alignment import AlignmentData, load_scenario, simulate_alignment
from robustnav.sim.alignment_scenario import Scenario, SensorErrors
from robustnav.sim.sway import Sway, Swing
from robustnav.strapdown.increments import Increments
from robustnav.studies.alignment_errors import heading_error, tilt_error
from robustnav.units import DEG, DEG_PER_HOUR, DPS, MICRO_G, MICRO_TESLA, MILLI_G

RATE_HZ, LATITUDE = 100.0, 45 * DEG
MARKOV_TIME = 3600.0  # s
TREMBLE = 0.005  # m/s, of a base that stands
ROOT_HOUR = 60.0  # of a second's root
DIP, DECLINATION = 60 * DEG, 5 * DEG
COMPASS_SD, COMPASS_BIAS_SD = 1 * DEG, 2 * DEG


@dataclass(frozen=True)
class Grade:
    """Sensors: biases, half their variance constant and half a Markov process of an hour, and two-sided densities."""

    gyro_bias_sd: float
    gyro_density: float
    accel_bias_sd: float
    accel_density: float


GRADES = {
    "0.01 deg/h": Grade(0.01 * DEG_PER_HOUR, 0.002 * DEG / ROOT_HOUR, 50 * MICRO_G, 10 * MICRO_G),
    "0.1 deg/h": Grade(0.1 * DEG_PER_HOUR, 0.01 * DEG / ROOT_HOUR, 100 * MICRO_G, 30 * MICRO_G),
    "1 deg/h": Grade(1.0 * DEG_PER_HOUR, 0.1 * DEG / ROOT_HOUR, 1 * MILLI_G, 50 * MICRO_G),
    "0.5 deg/s": Grade(0.5 * DPS, 0.005 * DPS, 5 * MILLI_G, 100 * MICRO_G),
    # An MPU-9250 as delivered: its data sheet's turn-on biases, and densities brought to two sides.
    "3 deg/s": Grade(2.9 * DPS, 0.007 * DPS, 46 * MILLI_G, 212 * MICRO_G),
}
BASES = {
    "still": Sway(Swing(mean=3 * DEG), Swing(mean=-2 * DEG)),
    "engine": Sway(Swing(3 * DEG, 0.1 * DEG, 4.371), Swing(-2 * DEG, 0.1 * DEG, 3.127)),
    "boat": Sway(Swing(0.0, 5 * DEG, 0.2), Swing(2 * DEG, 3 * DEG, 0.15)),
}


@dataclass(frozen=True)
class Said:
    """What one run gave at one instant [rad]: errors of heading and tilt (2,) with what was claimed, and the peer's."""

    heading: float
    heading_sd: float
    tilt: Array
    tilt_var: float
    observable: bool
    peer: float


def scenario_of(grade: Grade, base: str, wind: str, seconds: float) -> Scenario:
    """Return what is simulated, on a base of ``BASES``, in a wind of ``sim.alignment.wind_names``."""
    published = load_scenario("h-10-10-60", wind)
    errors = []
    for bias_sd, density in ((grade.gyro_bias_sd, grade.gyro_density), (grade.accel_bias_sd, grade.accel_density)):
        half = bias_sd / sqrt(2)
        errors.append(SensorErrors(half, density * sqrt(RATE_HZ), half, MARKOV_TIME))
    return replace(
        published,
        sway=BASES[base],
        latitude=LATITUDE,
        duration=seconds,
        imu_rate_hz=RATE_HZ,
        gyro=errors[0],
        accel=errors[1],
    )


def setup_of(grade: Grade, reference_sd: float) -> AlignSetup:
    """Return what ``align`` is told of a grade."""
    published = AlignSetup.published(grade.gyro_bias_sd, grade.accel_bias_sd, LATITUDE)
    return replace(
        published,
        gyro_density=grade.gyro_density,
        gyro_bias_sd=grade.gyro_bias_sd,
        gyro_bias_walk=grade.gyro_bias_sd / sqrt(MARKOV_TIME),
        accel_density=grade.accel_density,
        accel_bias_sd=grade.accel_bias_sd,
        accel_bias_walk=grade.accel_bias_sd / sqrt(MARKOV_TIME),
        reference_sd=reference_sd,
    )


def with_compass(setup: AlignSetup) -> AlignSetup:
    """Return the same with the study's compass."""
    return replace(setup, declination=DECLINATION, compass_sd=COMPASS_SD, compass_bias_sd=COMPASS_BIAS_SD)


def standing(scenario: Scenario, seed: int, setup: AlignSetup, times: tuple[float, ...]) -> list[Said]:
    """Simulate and align a base that stands, trembles and may shake; return how that went at ``times`` [s]."""
    data = simulate_alignment(scenario, seed, preintegrate)
    q_true, given = _truth(data), data.increments
    tremble = TREMBLE * np.random.default_rng([seed, 1]).standard_normal((scenario.intervals + 1, 3))
    velocity = given.velocity + rotate(quat_conjugate(q_true[:-1]), np.diff(tremble, axis=0))
    shaken = Increments.of(given.rotation, velocity, (given.J, given.H), given.dt)
    said, out = align(shaken, None, data.velocity.t, setup), []
    for time in times:
        k = round(time * scenario.filter_rate_hz)
        peer = coarse_heading(shaken.between(0, k)) - float(euler_from_quat(q_true[k])[2])
        out.append(_said(said, q_true, k, float(wrap_angle(peer))))
    return out


def in_wind(scenario: Scenario, seed: int, setup: AlignSetup) -> Said:
    """Simulate a base in the wind, with a field where the setup has a compass; return how its end went."""
    data = simulate_alignment(scenario, seed, preintegrate)
    q_true, field_b = _truth(data), None
    if setup.compass is not None:
        rng = np.random.default_rng([seed, 2])
        error = setup.compass.bias_sd * rng.standard_normal()
        azimuth = setup.compass.declination + error + setup.compass.sd * rng.standard_normal(scenario.intervals)
        level = cos(DIP) * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
        field_n = 48 * MICRO_TESLA * np.column_stack([level, np.full(len(level), sin(DIP))])
        field_b = rotate(quat_conjugate(q_true[1:]), field_n)
    said = align(data.increments, data.velocity.values[:, :2], data.velocity.t, setup, field_b=field_b)
    return _said(said, q_true, scenario.intervals, float("nan"))


def coarse_heading(increments: Increments) -> float:
    """Return the heading [rad] of mean rate and mean specific force, as if nothing moved: coarse gyrocompassing.

    Down is against the mean force, east across down and the Earth's rotation; Titterton and Weston, Strapdown Inertial
    Navigation Technology, 2nd edition (2004), section 10.4.1.
    """
    rate = np.mean(rotvec_from_quat(increments.rotation), axis=0)
    down = -np.mean(increments.velocity, axis=0)
    east = np.cross(down / np.linalg.norm(down), rate)
    north = np.cross(east, down)
    return float(np.arctan2(east[0] / np.linalg.norm(east), north[0] / np.linalg.norm(north)))


def still_bound(setup: AlignSetup, seconds: float) -> float:
    """Return the heading sd [rad] of a unit known not to move: gyro bias, angle random walk, level by its own force."""
    rate = hypot(setup.gyro_bias_sd, setup.gyro_density / sqrt(seconds)) / setup.horizontal_earth_rate
    return hypot(rate, tan(setup.latitude) * setup.accel_bias_sd / setup.gravity)


def velocity_bound(setup: AlignSetup, seconds: float) -> float:
    """Return the heading sd [rad] that a level base with its velocity known to be zero leaves, turn as it may.

    The covariance of the error equations linear about the truth, north-east-down, with no prior of heading.
    """
    T, n = setup.period, 11  # turn 3, velocity 2, gyro bias 3, accelerometer bias 3
    w = np.array([setup.horizontal_earth_rate, 0.0, -setup.horizontal_earth_rate * tan(setup.latitude)])
    F = np.eye(n)
    F[:3, :3] -= T * skew(w)
    F[:3, 5:8] = -T * np.eye(3)
    F[3:5, :3] = -skew(np.array([0.0, 0.0, -setup.gravity * T]))[:2]
    F[3:5, 8:] = -T * np.eye(3)[:2]
    parts = ((setup.gyro_density, 3), (setup.accel_density, 2), (setup.gyro_bias_walk, 3), (setup.accel_bias_walk, 3))
    Q = T * np.diag([density**2 for density, size in parts for _ in range(size)])
    P = np.diag([1.0, 1.0, pi**2, 9.0, 9.0, *[setup.gyro_bias_sd**2] * 3, *[setup.accel_bias_sd**2] * 3])
    for _ in range(round(seconds / T)):
        P = F @ P @ F.T + Q
        PH = P[:, 3:5]
        P = P - PH @ np.linalg.solve(PH[3:5] + setup.reference_sd**2 * np.eye(2), PH.T)
        P = 0.5 * (P + P.T)  # what rounding makes uneven would grow
    return float(sqrt(P[2, 2]))


def _said(said: Alignment, q_true: Array, k: int, peer: float) -> Said:
    """Judge interval ``k``, counted from one; a tilt's covariance is about axes of its own, its mean is taken."""
    q_est = said.q_nb[k - 1]
    return Said(
        heading=float(heading_error(q_true[k], q_est)),
        heading_sd=float(said.heading_sd[k - 1]),
        tilt=tilt_error(q_true[k], q_est),
        tilt_var=0.5 * float(np.trace(said.tilt_cov[k - 1])),
        observable=bool(said.heading_observable[k - 1]),
        peer=peer,
    )


def _truth(data: AlignmentData) -> Array:
    if data.truth.q_nb is None:
        raise InputError("simulated alignment", got="a truth without attitude", expected="q_nb")
    return data.truth.q_nb
