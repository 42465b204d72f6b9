"""Attitude estimators for recordings: started from the first readings, with noise wide enough for motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import asin, degrees

import numpy as np
from numpy.typing import ArrayLike

from robustnav.errors import InputError
from robustnav.frames import Array, euler_from_quat, quat_from_rotvec, quat_multiply, rotate, triad
from robustnav.models import AttitudeNoise, attitude, attitude_euler
from robustnav.records import Log, Run, Stream
from robustnav.run.estimators import EKF, H2, UKF, Estimator
from robustnav.run.loop import Start, run
from robustnav.units import DEG, DPS, MICRO_TESLA

ESTIMATORS = ("h2", "mekf", "ukf", "h2-euler", "ekf-euler")
TYPICAL_TURN = 100 * DPS  # what a hand-held or flying carrier does when it turns
_LEVEL_SD = 3 * DEG
_HEADING_SD = 6 * DEG
_BIAS_SD = 0.5 * DPS
_NO_FIELD = 50 * MICRO_TESLA


@dataclass(frozen=True)
class FirstReadings:
    """Means over the first part of a log.

    ``f_b`` (3,) specific force [m/s^2]; ``m_b`` (3,) field [T] or None without a magnetometer; rates [Hz] of gyro,
    accelerometer and magnetometer by stream name.
    """

    f_b: Array
    m_b: Array | None
    rates_hz: dict[str, float]

    @property
    def field(self) -> float:
        """Strength of the magnetic field [T]; a stand-in without a magnetometer, whose readings are then not fused."""
        return _NO_FIELD if self.m_b is None else float(np.linalg.norm(self.m_b))

    @property
    def dip_deg(self) -> float:
        """Angle of the field below the horizon [deg]."""
        if self.m_b is None:
            return 0.0
        cosine = -float(self.f_b @ self.m_b) / float(np.linalg.norm(self.f_b) * np.linalg.norm(self.m_b))
        return degrees(asin(min(1.0, max(-1.0, cosine))))

    @property
    def q_nb(self) -> Array:
        """Attitude to magnetic north-east-down; heading zero without a magnetometer."""
        ahead = (
            np.array([1.0, 0.0, 0.0]) if abs(self.f_b[0]) < 0.9 * np.linalg.norm(self.f_b) else np.array([0, 0, 1.0])
        )
        return triad(self.f_b, ahead if self.m_b is None else self.m_b)


def first_readings(log: Log, seconds: float = 0.5) -> FirstReadings:
    """Return the mean of a log's first ``seconds`` of readings, turned back to the first gyro sample's body axes.

    Raises
    ------
    InputError : a stream is missing or has no finite reading there, or the field is parallel to gravity.
    """
    gyro = log.stream("gyro")
    if not len(gyro):
        raise InputError("no gyro samples", place=log.source)
    begin = float(gyro.t[0])
    turned = _turned_since_start(gyro.between(begin, begin + 2 * seconds))
    f_b = _mean(log.stream("accel"), seconds, turned, log.source)
    m_b = None
    if "mag" in log.streams and len(log.streams["mag"]):
        m_b = _mean(log.streams["mag"], max(seconds, 2.5 / log.streams["mag"].rate_hz), turned, log.source)
        cross = np.linalg.norm(np.cross(f_b, m_b)) / (np.linalg.norm(f_b) * np.linalg.norm(m_b))
        if not cross > 0.05:
            raise InputError(
                "start attitude",
                place=log.source,
                got="a magnetic field along gravity",
                expected="a horizontal part",
                do="check the magnetometer with: robustnav doctor",
            )
    rates = {name: s.rate_hz for name, s in log.streams.items() if name in ("gyro", "accel", "mag")}
    return FirstReadings(f_b, m_b, rates)


@dataclass(frozen=True)
class Sensors:
    """Data-sheet presets of what recorded a log, see ``robustnav.datasheet.names()``."""

    imu: str
    magnetometer: str


def estimator_for(name: str, log: Log, sensors: Sensors, *, seconds: float = 0.5) -> tuple[Estimator, Start]:
    """Return an attitude estimator and its start for a recording of a carrier that moves.

    The field's strength and dip are those of the first readings; noise is ``AttitudeNoise.moving``.  A constant gain
    cannot follow the turn rate, so its gyro noise is that of a turn at ``TYPICAL_TURN``.

    Parameters
    ----------
    name : ``h2``, ``mekf``, ``ukf`` on the quaternion model, ``h2-euler``, ``ekf-euler`` on the published one.
    log : with streams ``gyro`` and ``accel``, and ``mag`` if there is one.
    sensors : what recorded it.
    seconds : how long the first readings are averaged [s]; the carrier may turn, but should not accelerate.

    Raises
    ------
    InputError : unknown name or preset, or unusable first readings.
    """
    if name not in ESTIMATORS:
        raise InputError(f"estimator {name!r}", expected=", ".join(ESTIMATORS))
    first = first_readings(log, seconds)
    rates = first.rates_hz
    noise = AttitudeNoise.from_datasheet(sensors.imu, sensors.magnetometer, rates["gyro"], gyro_bias_density=0.0)
    noise = noise.moving(rates["accel"], rates.get("mag", rates["accel"]), first.field)
    euler = name.endswith("-euler")
    if name.startswith("h2"):
        noise = noise.turning(TYPICAL_TURN)
    model = (attitude_euler if euler else attitude)(noise, field=first.field, dip_deg=first.dip_deg)
    block, value = ("euler", euler_from_quat(first.q_nb)) if euler else ("q_nb", first.q_nb)
    sd: dict[str, ArrayLike] = {block: (_LEVEL_SD, _LEVEL_SD, _HEADING_SD), "gyro_bias": _BIAS_SD}
    start = Start.at(model, sd, **{block: value})
    if name.startswith("h2"):
        slower: dict[str, float] = {n: min(rates[n], rates["gyro"]) for n in ("accel", "mag") if n in rates}
        return H2(model, rates["gyro"], sensor_rates_hz=slower, start_sd="steady" if euler else sd), start
    return (UKF(model) if name == "ukf" else EKF(model)), start


def run_recorded(name: str, log: Log, sensors: Sensors, *, backend: str = "auto") -> Run:
    """Run a named attitude estimator over a recording; arguments as ``estimator_for``.

    The filters work in magnetic-north axes.  A log that states its declination gets its attitude to true north.
    """
    estimator, start = estimator_for(name, log, sensors)
    out = run(estimator, log, start, backend=backend)
    settings = {**out.settings, "imu": sensors.imu, "magnetometer": sensors.magnetometer, "north": "magnetic"}
    declination_deg = log.info.get("declination_deg")
    state = dict(out.state)
    if isinstance(declination_deg, float | int) and np.isfinite(declination_deg) and declination_deg != 0:
        settings |= {"north": "true", "declination [deg]": declination_deg}
        if "q_nb" in state:
            turn = quat_from_rotvec(np.array([0.0, 0.0, declination_deg * DEG]))
            state["q_nb"] = quat_multiply(turn, state["q_nb"])
        else:
            state["euler"] = state["euler"] + np.array([0.0, 0.0, declination_deg * DEG])
    return replace(out, estimator=name, state=state, settings=settings)


def _turned_since_start(gyro: Stream) -> tuple[Array, Array]:
    """Return times (n,) and attitudes (n, 4) of the body against its first sample's axes, by the gyro alone."""
    whole = np.isfinite(gyro.values).all(axis=1)
    t, rate = gyro.t[whole], gyro.values[whole]
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1))
    for k, step in enumerate(quat_from_rotvec(rate[1:] * np.diff(t)[:, None])):
        q[k + 1] = quat_multiply(q[k], step)
    return t, q


def _mean(stream: Stream, seconds: float, turned: tuple[Array, Array], source: str) -> Array:
    t, q = turned
    if not len(t):
        raise InputError("start attitude: no gyro reading", place=source, expected="finite readings")
    first = stream.between(t[0], t[0] + seconds)
    nearest = np.clip(np.searchsorted(t, first.t), 0, len(t) - 1)
    values = rotate(q[nearest], first.values)
    values = values[np.isfinite(values).all(axis=1)]
    if not len(values) or not np.linalg.norm(values.mean(axis=0)) > 0:
        raise InputError(
            f"start attitude: no {stream.name} reading",
            place=f"{source}, first {seconds:g} s",
            expected="finite readings",
            do="cut the recording to where the sensor works",
        )
    mean: Array = values.mean(axis=0)
    return mean
